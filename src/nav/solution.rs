//! What a navigation system reports of one instant: position, velocity, attitude, and their accuracy.
//!
//! In the frame of the place itself (its own East, North and up), as receivers send it. A scene holds states
//! in the ENU frame of its origin; [`Solution::of_scene`] turns them: position by way of ECEF, velocity
//! `v = L R^T v_scene` with R and L the rotations from ECEF to the ENU axes of the origin and of the place,
//! attitude likewise, then to yaw, pitch and roll.
//!
//! ```
//! use nereus::frames::{Earth, Geodetic, Rotation, SceneFrame, Vector, Point};
//! use nereus::nav::solution::Solution;
//! use nereus::time::TimeTag;
//!
//! let frame = SceneFrame::at(Geodetic::from_deg(0.0, 5.0, 0.0), Earth::Flat);
//! let north = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
//! let place = Point::new(0.0, 0.0, 300.0);
//! let solution = Solution::of_scene(&frame, TimeTag::default(), place, Vector::new(1.0, 2.0, 3.0), north).unwrap();
//! assert!((solution.place.h_m - 300.0).abs() < 1e-8);
//! assert!((solution.velocity_mps.unwrap()[2] - 3.0).abs() < 1e-12);
//! ```

use super::{Fix, Place, Sigma};
use crate::frames::{Body, Earth, Enu, Geodetic, Point, Rotation, SceneFrame, Vector};
use crate::time::TimeTag;

/// A state as it is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// When, UTC.
    pub time: TimeTag,
    /// Where, height above the ellipsoid.
    pub place: Geodetic,
    /// Height of mean sea level above the ellipsoid, m.
    pub undulation_m: f64,
    /// Velocity East, North, up of the place, m/s.
    pub velocity_mps: Option<[f64; 3]>,
    /// Yaw (clockwise from North of the place), pitch, roll, radians.
    pub yaw_pitch_roll_rad: Option<[f64; 3]>,
    /// Standard deviations.
    pub sigma: Sigma,
}

impl Solution {
    /// From a state in the frame of a scene; `None` if that is not georeferenced. Mean sea level is that of
    /// the origin.
    pub fn of_scene(
        frame: &SceneFrame,
        time: TimeTag,
        position: Point<Enu>,
        velocity: Vector<Enu>,
        attitude: Rotation<Body, Enu>,
    ) -> Option<Self> {
        let place = frame.to_geodetic(position)?;
        let local = SceneFrame::at(place, Earth::Flat);
        let turned = |v: Vector<Enu>| local.vector_from_ecef(frame.vector_to_ecef(v)?);
        let axis = |x, y, z| turned(attitude * Vector::new(x, y, z));
        let [nose, wing, belly] = [axis(1.0, 0.0, 0.0)?, axis(0.0, 1.0, 0.0)?, axis(0.0, 0.0, 1.0)?];
        Some(Self {
            time,
            place,
            undulation_m: frame.origin()?.h_m,
            velocity_mps: Some(turned(velocity)?.to_array()),
            yaw_pitch_roll_rad: Some(Rotation::from_axes(nose, wing, belly).to_yaw_pitch_roll()),
            sigma: Sigma::default(),
        })
    }

    /// From a recorded fix; `None` if it is in the frame of a scene. A velocity without a climb is taken as
    /// level.
    pub fn of_fix(fix: &Fix, undulation_m: f64) -> Option<Self> {
        let Place::Geodetic(place) = fix.place else { return None };
        Some(Self {
            time: fix.time,
            place,
            undulation_m,
            velocity_mps: fix.velocity_mps.map(|[e, n]| [e, n, fix.climb_mps.unwrap_or(0.0)]),
            yaw_pitch_roll_rad: fix.yaw_pitch_roll_rad,
            sigma: fix.sigma,
        })
    }
}

/// Gives a velocity to the states that have none: from the one before to the one after (`dp/dt`, in the frame
/// of the place; at the ends from one neighbour). How many there were.
pub fn derive_velocities(solutions: &mut [Solution]) -> usize {
    let mut derived = 0;
    for index in 0..solutions.len() {
        if solutions[index].velocity_mps.is_some() {
            continue;
        }
        let (from, to) =
            (&solutions[index.saturating_sub(1)], &solutions[(index + 1).min(solutions.len() - 1)]);
        let step_s = to.time.since(from.time);
        let local = SceneFrame::at(solutions[index].place, Earth::Flat);
        let way = local.vector_from_ecef(to.place.to_ecef() - from.place.to_ecef());
        if let Some(way) = way.filter(|_| step_s > 0.0) {
            solutions[index].velocity_mps = Some((way * step_s.recip()).to_array());
            derived += 1;
        }
    }
    derived
}
