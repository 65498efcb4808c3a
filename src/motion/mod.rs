//! Where everything is at an instant.

pub mod attitude;
pub mod fit;
pub mod hermite;
pub mod outliers;
pub mod pointing;
pub mod smoother;
pub mod track;

pub use fit::FitReport;
pub use track::{SourceError, SourceReport, State, Track, TrackError};

/// The two trajectories of a platform, never mixed.
#[derive(Clone, Debug)]
pub struct PlatformTracks {
    /// What happens: drives delays, phases, gains.
    pub truth: Track,
    /// What the platform says.
    pub reported: Track,
}
