//! Where the trajectories of a platform come from.

use super::errors::ErrorModel;
use super::gusts::Gusts;
use crate::nav::TrackSource;

/// Where the trajectories of a platform come from. In a run, `scene.platforms[i]` moves as
/// `nav[i]` has it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlatformNav {
    /// What happens: drives delays, phases and gains.
    pub truth: TrackSource,
    /// What the platform reports, where it differs from the truth.
    pub reported: Option<TrackSource>,
    /// What is wrong with the report.
    pub errors: Option<ErrorModel>,
    /// Turbulence that it flies through.
    pub gusts: Option<Gusts>,
}
