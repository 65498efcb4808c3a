//! Where everything is at an instant.

pub mod track;
pub mod pointing;

use crate::scene::radar::AimFrom;

use track::Track;

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
