//! What there is: plain, resolved descriptions without physics.

pub mod calibration;
pub mod clock;
pub mod front_end;
#[doc(hidden)]
pub mod hermite;
pub mod hull;
pub mod land;
pub mod mesh;
pub mod patch;
pub mod radar;
pub mod sea;
pub mod ship;
pub mod target;
pub mod trajectory;
pub mod water;

use crate::frames::SceneFrame;
use crate::time::TimeTag;

pub use hull::Hull;
pub use land::Land;
pub use patch::Patch;
pub use radar::{Emitter, Radar};
pub use sea::Sea;
pub use ship::Ship;
pub use target::Target;
pub use trajectory::Trajectory;
pub use water::Water;

/// Everything that a run emulates. Where platforms go is not here: tracks come from `nav`, under the
/// same names.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The ENU frame.
    pub frame: SceneFrame,
    /// Emission time of pulse 0.
    pub start: TimeTag,
    /// Pulses in the whole run.
    pub pulses: u64,
    /// Seed of every random stream.
    pub seed: u64,
    /// Names of the platforms; other modules refer to a platform by its place here.
    pub platforms: Vec<String>,
    /// The instrument.
    pub radar: Radar,
    /// The sea; `None` for point targets alone.
    pub sea: Option<Sea>,
    /// Ships, which raise wakes where there is a sea.
    pub ships: Vec<Ship>,
    /// Point targets.
    pub targets: Vec<Target>,
}
