//! Where the trajectories of a platform come from.

use super::errors::ErrorModel;
use super::gusts::Gusts;
use crate::frames::{Body, Enu, Rotation, Vector};
use crate::nav::{FileSource, LiveSource, Place};

/// Where the trajectories of a platform come from. In a run, `scene.platforms[i]` moves as
/// `nav[i]` says.
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

/// A source of one trajectory.
#[derive(Clone, Debug, PartialEq)]
pub enum TrackSource {
    /// Stays where it is.
    Fixed {
        /// Where.
        place: Place,
        /// Attitude.
        attitude: Rotation<Body, Enu>,
    },
    /// Straight line at constant speed.
    Straight {
        /// Position at the emission of pulse 0.
        place: Place,
        /// Velocity, m/s.
        velocity: Vector<Enu>,
        /// Attitude; `None`: nose along the velocity, wings level.
        attitude: Option<Rotation<Body, Enu>>,
    },
    /// A recorded track.
    File(FileSource),
    /// What a receiver says while the run goes on.
    Live(LiveSource),
}
