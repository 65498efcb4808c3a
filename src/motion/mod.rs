//! Where everything is at an instant.
//!
//! [`Track`] is the trajectory of a platform; [`fit`] makes one from recorded fixes with [`outliers`] and
//! [`smoother`], [`hermite`] interpolates, [`attitude`] derives what a recording does not say. [`pointing`]
//! puts antennas on the body and turns them.

pub mod attitude;
pub mod fit;
pub mod hermite;
pub mod outliers;
pub mod pointing;
pub mod smoother;
pub mod track;

pub use fit::FitReport;
pub use track::{SourceError, SourceReport, State, Track, TrackError};

use crate::scene::radar::AimFrom;

/// The two trajectories of a platform, never mixed. In a run they stand in the order of
/// `scene.platforms`.
#[derive(Clone, Debug)]
pub struct PlatformTracks {
    /// What happens: drives delays, phases and gains.
    pub truth: Track,
    /// What the platform says: all that a servo, a range gate and the record's reader know.
    pub reported: Track,
}

impl PlatformTracks {
    /// The trajectory that a servo or a range gate acts on.
    pub fn known(&self, aim_from: AimFrom) -> &Track {
        match aim_from {
            AimFrom::Reported => &self.reported,
            AimFrom::True => &self.truth,
        }
    }
}
