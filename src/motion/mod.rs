//! Where everything is at an instant.

pub mod attitude;
pub mod fit;
pub mod hermite;
pub mod outliers;
pub mod smoother;
pub mod track;

pub use fit::FitReport;
pub use track::{SourceError, SourceReport, State, Track, TrackError};
