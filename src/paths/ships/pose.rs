//! Where a ship is at an instant, and how it moves.
//!
//! Midship sails its course over the mean sea: forward along the heading, up along the vertical there. On a
//! trajectory it heads along its velocity, and turns with it. A ship
//! that rides the waves is lifted by its heave, and turned about midship at the waterline: by its roll, then
//! by its pitch, then by its heading.

use glam::{DMat3, DVec3};

use super::motion::{Motion, Moved, Seas};
use crate::frames::SceneFrame;
use crate::scene::ship::{self, Sailed};
use crate::scene::{Ship, Trajectory};

/// A ship at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::paths) struct Pose {
    /// Midship at the design waterline, m.
    pub origin_m: DVec3,
    /// Its forward, port and up in the scene, as columns.
    pub axes: DMat3,
    /// Velocity of midship, m/s.
    pub velocity_mps: DVec3,
    /// Rate of turn, rad/s.
    pub turning_radps: DVec3,
}

/// How a ship sails.
#[derive(Debug)]
pub(in crate::paths) struct Sailing {
    position_m: [f64; 2],
    ahead: [f64; 2],
    speed_mps: f64,
    trajectory: Option<Trajectory>,
    motion: Option<Motion>,
}

impl Sailing {
    pub fn of(ship: &Ship, seas: Option<Seas<'_>>) -> Self {
        let (sin, cos) = ship.heading_rad.sin_cos();
        let motion = Motion::of(ship, seas);
        Self {
            position_m: ship.position_m,
            ahead: [cos, sin],
            speed_mps: ship.speed_mps,
            trajectory: ship.trajectory.clone(),
            motion,
        }
    }

    /// Whether waves move it.
    pub fn rides(&self) -> bool {
        self.motion.is_some()
    }

    /// Whether it is on a trajectory.
    pub fn turns(&self) -> bool {
        self.trajectory.is_some()
    }

    /// The ship at a time after pulse 0.
    pub fn pose(&self, frame: &SceneFrame, elapsed_s: f64) -> Pose {
        let straight = || {
            let velocity = self.ahead.map(|along| along * self.speed_mps);
            let place = [0, 1].map(|i| self.position_m[i] + velocity[i] * elapsed_s);
            (place, velocity, self.ahead, 0.0)
        };
        let ([x_m, y_m], velocity, heading, turn_radps) =
            self.trajectory.as_ref().map_or_else(straight, |way| {
                let Sailed { position_m, velocity_mps, ahead, turn_radps } =
                    Sailed::on(way, elapsed_s, self.ahead);
                (position_m, velocity_mps, ahead, turn_radps)
            });
        let place = frame.above_sea(x_m, y_m, 0.0);
        let up = frame.earth().up(place).raw();
        let ahead = DVec3::new(heading[0], heading[1], 0.0);
        let ahead = (ahead - up * up.dot(ahead)).normalize_or(DVec3::X);
        // On a curved earth the sea falls away beneath the ship.
        let fall = frame.earth().drop_slope(x_m, y_m);
        let sinks_mps = fall[0] * velocity[0] + fall[1] * velocity[1];
        let level = Pose {
            origin_m: place.raw(),
            axes: DMat3::from_cols(ahead, up.cross(ahead), up),
            velocity_mps: DVec3::new(velocity[0], velocity[1], -sinks_mps),
            turning_radps: up * turn_radps,
        };
        self.motion.as_ref().map_or(level, |motion| moved(&level, &motion.at(elapsed_s)))
    }

    /// No point within a radius of midship is faster, m/s.
    pub fn fastest_mps(&self, radius_m: f64) -> f64 {
        let [heave_mps, pitch_radps, roll_radps] = self.motion.as_ref().map_or([0.0; 3], Motion::rates);
        let sails_mps = self.trajectory.as_ref().map_or(self.speed_mps, Trajectory::fastest_mps);
        let turns_radps = self.trajectory.as_ref().map_or(0.0, ship::fastest_turn_radps);
        sails_mps + heave_mps + radius_m * (pitch_radps + roll_radps + turns_radps)
    }
}

/// A level ship as waves lift and turn it.
fn moved(level: &Pose, Moved { value: [heave_m, pitch, roll], rate }: &Moved) -> Pose {
    let [heave_mps, pitch_radps, roll_radps] = *rate;
    // Up is z of the scene, as the mean sea is above its plane.
    let bow_up = DMat3::from_rotation_y(-pitch);
    Pose {
        origin_m: level.origin_m + DVec3::Z * *heave_m,
        axes: level.axes * bow_up * DMat3::from_rotation_x(*roll),
        velocity_mps: level.velocity_mps + DVec3::Z * heave_mps,
        turning_radps: level.axes * (bow_up * DVec3::X * roll_radps - DVec3::Y * pitch_radps),
    }
}
