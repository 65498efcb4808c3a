//! Where a ship is: a straight course, or one that turns slowly.
//!
//! Positions are those of midship at the waterline, in the scene frame; headings run from +x
//! counter-clockwise. In the ship's frame `x` points astern and `y` to starboard:
//! `x = -(r - r_ship).f`, `y = -(r - r_ship).p`, `f` the unit vector ahead, `p` to port.
//!
//! **Turning.** Waves are those of a straight course with the position and heading of the moment: heading and
//! speed are taken as frozen over the age of the wake. Then the pattern at a distance `X` astern moves
//! sideways by `rate X`, which the orbital velocities know nothing of. A turn is allowed as long as
//! `|rate| X / V <= ` [`MOST_TURN_RAD`](super::fault::MOST_TURN_RAD) for the whole [`Reach`]: within it the
//! motion of the pattern departs by less than 5 % of V from that of the fields, and the true, curved wake by
//! `X/2` times that angle.
//!
//! ```
//! use nereus::sea::wake::Course;
//! let ship = Course { turn_rate_radps: 1e-3, ..Course::straight([0.0, 0.0], 0.0, 5.0) };
//! let [x, y] = ship.position_m(100.0);
//! // A circle of radius V/rate = 5 km.
//! assert!((x.hypot(y - 5e3) - 5e3).abs() < 1e-9 && y > 0.0);
//! assert!((ship.heading_rad(100.0) - 0.1).abs() < 1e-15);
//! ```

use super::fault::{MAX_SPEED_MPS, MAX_TIME_S};
use crate::scene::Patch;
use crate::sea::wake::fault::WakeError;

/// Furthest place from the origin, m.
const MAX_PLACE_M: f64 = 1e12;

/// A course of constant speed and rate of turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Position of midship at t = 0, m.
    pub position_m: [f64; 2],
    /// Heading at t = 0, from +x counter-clockwise, radians.
    pub heading_rad: f64,
    /// Speed through the water, m/s, at least 0.
    pub speed_mps: f64,
    /// Rate of turn, to port, rad/s.
    pub turn_rate_radps: f64,
}

impl Course {
    /// A straight course.
    pub fn straight(position_m: [f64; 2], heading_rad: f64, speed_mps: f64) -> Self {
        Self { position_m, heading_rad, speed_mps, turn_rate_radps: 0.0 }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// A speed, place or direction out of range.
    pub fn check(&self) -> Result<(), WakeError> {
        if !(0.0..=MAX_SPEED_MPS).contains(&self.speed_mps) {
            return Err(WakeError::Speed { speed_mps: self.speed_mps });
        }
        let place = self.position_m.iter().all(|x| x.abs() <= MAX_PLACE_M);
        if !(place && self.heading_rad.is_finite() && self.turn_rate_radps.is_finite()) {
            return Err(WakeError::Course);
        }
        Ok(())
    }

    /// Heading at a time, radians.
    pub fn heading_rad(&self, time_s: f64) -> f64 {
        self.heading_rad + self.turn_rate_radps * time_s
    }

    /// Position of midship at a time, m.
    pub fn position_m(&self, time_s: f64) -> [f64; 2] {
        // The chord of the arc: it points along the mean heading.
        let half = 0.5 * self.turn_rate_radps * time_s;
        let shortening = if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { half.sin() / half };
        let chord_m = self.speed_mps * time_s * shortening;
        let (sin, cos) = (self.heading_rad + half).sin_cos();
        [self.position_m[0] + chord_m * cos, self.position_m[1] + chord_m * sin]
    }

    /// The ship's place and direction at a time.
    pub fn pose(&self, time_s: f64) -> Pose {
        let (sin, cos) = self.heading_rad(time_s).sin_cos();
        Pose { position_m: self.position_m(time_s), ahead: [cos, sin], run_m: self.speed_mps * time_s }
    }
}

/// Place and direction of a ship.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Midship, m.
    pub position_m: [f64; 2],
    /// Unit vector ahead.
    pub ahead: [f64; 2],
    /// Run since t = 0, m.
    pub run_m: f64,
}

impl Pose {
    /// Distances astern and to starboard of midship, m.
    pub fn astern_starboard_m(&self, position_m: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = [position_m[0] - self.position_m[0], position_m[1] - self.position_m[1]];
        let [cos, sin] = self.ahead;
        [-(dx * cos + dy * sin), dx * sin - dy * cos]
    }
}

/// How far from midship a wake is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Furthest along the course, ahead or astern, m.
    pub along_m: f64,
    /// Furthest to either side, m.
    pub across_m: f64,
}

impl Reach {
    /// A disc.
    pub fn disc(radius_m: f64) -> Self {
        Self { along_m: radius_m, across_m: radius_m }
    }

    /// What the centres of a patch's facets need while a ship follows its course from one time to another, s.
    pub fn of(patch: &Patch, course: &Course, times_s: [f64; 2]) -> Result<Self, WakeError> {
        course.check()?;
        for time_s in times_s {
            if time_s.is_nan() || time_s.abs() > MAX_TIME_S {
                return Err(WakeError::Time { time_s });
            }
        }
        let corners = corners_m(patch);
        let mut reach = Self::disc(0.0);
        if course.turn_rate_radps == 0.0 {
            for pose in times_s.map(|time_s| course.pose(time_s)) {
                for [along, across] in corners.map(|corner| pose.astern_starboard_m(corner)) {
                    reach.along_m = reach.along_m.max(along.abs());
                    reach.across_m = reach.across_m.max(across.abs());
                }
            }
        } else {
            // The ship stays within half its run of where it is at the middle of the time.
            let middle = course.position_m(0.5 * (times_s[0] + times_s[1]));
            let run_m = 0.5 * course.speed_mps * (times_s[1] - times_s[0]).abs();
            for corner in corners {
                let distance_m = (corner[0] - middle[0]).hypot(corner[1] - middle[1]);
                let radius_m = reach.along_m.max(distance_m + run_m);
                reach = Self::disc(radius_m);
            }
        }
        // Rounding of positions must not put a corner outside.
        let slack_m = 1e-9 * (1.0 + reach.along_m + reach.across_m);
        Ok(Self { along_m: reach.along_m + slack_m, across_m: reach.across_m + slack_m })
    }
}

/// Centres of the four corner facets, m.
pub(super) fn corners_m(patch: &Patch) -> [[f64; 2]; 4] {
    let last = [0, 1].map(|i| patch.first[i] + patch.facets[i].saturating_sub(1) as i64);
    let [a, b] = [patch.first, last];
    [a, [b[0], a[1]], [a[0], b[1]], b].map(|key| patch.centre_m(key))
}
