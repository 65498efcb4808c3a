//! Where everything is at an instant.
//!
//! [`Track`] is the trajectory of a platform; [`fit`] makes one from recorded fixes with [`outliers`] and
//! [`smoother`], [`hermite`] interpolates, [`attitude`] derives what a recording does not say.

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
