//! What ships carry: the scatterers of their hulls become point targets, and ships without any get the panels
//! of their mesh ([`crate::sea::fleet::panels`]).
//!
//! A scatterer stays where its hull's file has it (forward, starboard, down of midship at the waterline) and
//! sails with the ship: height above the mean sea `-down`, velocity that of the ship. Its name is
//! `<ship>.<scatterer>`, its echo that of a sphere of the radar cross section in the file, whatever the
//! length to which the hull is scaled. Limits: scatterers neither heave, roll nor pitch, nothing hides
//! them, and those of a ship without a track sail straight on, off the sea of a curved earth (by 0.8 m
//! after 3.2 km).
//!
//! ```
//! use nereus::pipeline::hull_scatterers::{place, Scatters};
//! use nereus::frames::{Body, Earth, Point, SceneFrame};
//! let ship = Scatters { position_m: [100.0, 50.0], heading_rad: 0.0, speed_mps: 5.0 };
//! // Ahead is East, starboard South, down below the sea.
//! let mast = place(&SceneFrame::plain(Earth::Flat), &ship, Point::<Body>::new(10.0, 2.0, -30.0));
//! assert_eq!(mast.to_array(), [110.0, 48.0, 30.0]);
//! ```

use std::collections::HashSet;

use crate::frames::{Body, Enu, Point, SceneFrame, Vector};
use crate::pulse::Pulse;
use crate::scene::hull::Hull;
use crate::scene::mesh::{self, MeshError};
use crate::scene::ship::{Sailed, ShipMotion};
use crate::scene::trajectory::{Knot, Trajectory};
use crate::scene::{Scene, Ship, Target};
use crate::sea::fleet::{self, FleetError, FleetErrors, ShipError};
use crate::sea::wake::Course;
use crate::time::TimeTag;

/// Where a ship is at pulse 0, and how it sails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatters {
    /// Midship, East and North, m.
    pub position_m: [f64; 2],
    /// Heading, from East counter-clockwise, radians.
    pub heading_rad: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
}

/// Where a point of a ship is in the scene.
pub fn place(frame: &SceneFrame, ship: &Scatters, point: Point<Body>) -> Point<Enu> {
    let [forward_m, starboard_m, down_m] = point.to_array();
    let (sin, cos) = ship.heading_rad.sin_cos();
    let x_m = ship.position_m[0] + forward_m * cos + starboard_m * sin;
    let y_m = ship.position_m[1] + forward_m * sin - starboard_m * cos;
    frame.above_sea(x_m, y_m, -down_m)
}

/// Knots of a carried point in a segment of a ship's trajectory.
const KNOTS_A_SEGMENT: u32 = 4;

/// Where a point of a ship on a trajectory goes: its turns carry the point about midship.
fn carried(frame: &SceneFrame, ship: &Ship, way: &Trajectory, point: Point<Body>) -> Trajectory {
    let [forward_m, starboard_m, down_m] = point.to_array();
    let ahead = [ship.heading_rad.cos(), ship.heading_rad.sin()];
    let at = |time_s: f64| {
        let Sailed { position_m, velocity_mps, ahead: [cos, sin], turn_radps } =
            Sailed::on(way, time_s, ahead);
        let arm = [forward_m * cos + starboard_m * sin, forward_m * sin - starboard_m * cos];
        let place = [position_m[0] + arm[0], position_m[1] + arm[1]];
        let velocity = [velocity_mps[0] - turn_radps * arm[1], velocity_mps[1] + turn_radps * arm[0]];
        let fall = frame.earth().drop_slope(place[0], place[1]);
        let sinks_mps = fall[0] * velocity[0] + fall[1] * velocity[1];
        let position = frame.above_sea(place[0], place[1], -down_m);
        (position, Vector::<Enu>::new(velocity[0], velocity[1], -sinks_mps))
    };
    let [first_s, last_s] = way.span_s();
    let knot = |(time_s, step_s): (f64, f64)| {
        let (position, velocity) = at(time_s);
        // The rate of turn changes as the jerk does: from the velocities beside it.
        let [before_s, after_s] = [(time_s - step_s).max(first_s), (time_s + step_s).min(last_s)];
        let acceleration = (at(after_s).1 - at(before_s).1) * (after_s - before_s).recip();
        Knot { time_s, position, velocity, acceleration }
    };
    let of_segment = |pair: &[Knot]| {
        let (from_s, step_s) =
            (pair[0].time_s, (pair[1].time_s - pair[0].time_s) / f64::from(KNOTS_A_SEGMENT));
        (0..KNOTS_A_SEGMENT).map(move |n| (from_s + step_s * f64::from(n), 1e-3 * step_s)).collect::<Vec<_>>()
    };
    let times =
        way.knots().windows(2).flat_map(of_segment).chain([(last_s, 1e-3 * (last_s - first_s).min(1.0))]);
    Trajectory::new(times.map(knot).collect()).unwrap_or_else(|| way.clone())
}

/// Where the ships of a scene sail: the truth that a recording has of them.
#[derive(Clone, Debug)]
pub struct ShipTracks {
    frame: SceneFrame,
    start: TimeTag,
    courses: Vec<Course>,
    /// Of those that do not sail straight on.
    trajectories: Vec<Option<Trajectory>>,
}

impl ShipTracks {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        let courses = scene.ships.iter().map(fleet::course).collect();
        let trajectories = scene.ships.iter().map(|ship| ship.trajectory.clone()).collect();
        Self { frame: scene.frame, start: scene.start, courses, trajectories }
    }

    /// Writes position, velocity and heading of every ship at the emission of a pulse into its record.
    pub fn record(&self, pulse: &mut Pulse) {
        let time_s = pulse.time.since(self.start);
        let slots = pulse.ship_position_m.iter_mut().zip(&mut pulse.ship_velocity_mps);
        let slots = slots.zip(&mut pulse.ship_heading_deg);
        let ways = self.courses.iter().zip(&self.trajectories);
        for ((course, trajectory), ((position_m, velocity_mps), heading_deg)) in ways.zip(slots) {
            let straight = || {
                let pose = course.pose(time_s);
                let velocity_mps = pose.ahead.map(|component| component * course.speed_mps);
                (pose.position_m, velocity_mps, course.heading_rad(time_s))
            };
            let ([x_m, y_m], [vx, vy], heading_rad) = trajectory.as_ref().map_or_else(straight, |way| {
                let now = Sailed::on(way, time_s, course.pose(0.0).ahead);
                (now.position_m, now.velocity_mps, now.ahead[1].atan2(now.ahead[0]))
            });
            // On a curved earth the sea falls away beneath the ship.
            let fall = self.frame.earth().drop_slope(x_m, y_m);
            *position_m = self.frame.above_sea(x_m, y_m, 0.0).to_array();
            *velocity_mps = [vx, vy, -(fall[0] * vx + fall[1] * vy)];
            *heading_deg = (90.0 - heading_rad.to_degrees()).rem_euclid(360.0);
        }
    }
}

/// The scene with the scatterers of its ships among its targets, and the panels of ships that echo by their
/// mesh; `None` where no ship echoes.
///
/// # Errors
/// Ships whose hulls cannot be read.
pub(super) fn with_scatterers(scene: &Scene) -> Result<Option<Scene>, FleetErrors> {
    if !scene.ships.iter().any(|ship| ship.echo) {
        return Ok(None);
    }
    let mut extended = scene.clone();
    let (mut faults, mut together) = (Vec::new(), 0);
    let mut names: HashSet<String> = scene.targets.iter().map(|target| target.name.clone()).collect();
    for (ship, own) in scene.ships.iter().zip(&mut extended.ships).filter(|(ship, _)| ship.echo) {
        let found = fleet::hull(ship).and_then(|hull| {
            let panels = fleet::panels(ship, &hull)?;
            together += panels.len();
            if together > mesh::MOST_OF_SCENE {
                return Err(MeshError::Together { own: panels.len(), together }.into());
            }
            Ok((targets(ship, &hull, &scene.frame, &mut names)?, panels, fleet::form(&hull)))
        });
        match found {
            Ok((found, panels, of_hull)) => {
                extended.targets.extend(found);
                own.panels = panels.into();
                if let ShipMotion::Waves { form, .. } = &mut own.mesh.motion {
                    *form = Some(of_hull);
                }
            }
            Err(source) => faults.push(FleetError { ship: ship.name.clone(), source }),
        }
        own.echo = false;
    }
    if faults.is_empty() { Ok(Some(extended)) } else { Err(FleetErrors(faults)) }
}

/// The scatterers of a ship; their names go to those of all targets.
fn targets(
    ship: &Ship,
    hull: &Hull,
    frame: &SceneFrame,
    names: &mut HashSet<String>,
) -> Result<Vec<Target>, ShipError> {
    let Ship { position_m, heading_rad, speed_mps, .. } = *ship;
    let at = Scatters { position_m, heading_rad, speed_mps };
    let (sin, cos) = heading_rad.sin_cos();
    let mut found: Vec<Target> = Vec::new();
    for scatterer in hull.scatterers() {
        // Names of targets become groups of recordings; that of a scatterer is any text.
        let plain = |c: char| if c.is_ascii_alphanumeric() || "_-.".contains(c) { c } else { '-' };
        let name = format!("{}.{}", ship.name, scatterer.name.chars().map(plain).collect::<String>());
        if !names.insert(name.clone()) {
            return Err(ShipError::NameTaken { name });
        }
        let velocity = Vector::new(speed_mps * cos, speed_mps * sin, 0.0);
        let scattering = Target::sphere(scatterer.rcs_m2);
        let way = ship.trajectory.as_ref().map(|way| carried(frame, ship, way, scatterer.position));
        let position = place(frame, &at, scatterer.position);
        found.push(Target { trajectory: way, ..Target::new(name, position, velocity, scattering) });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Earth;
    use crate::pulse::Layout;

    /// On a curved earth the recorded velocity is the rate of the recorded position, up and down too.
    #[test]
    fn velocities_are_rates_of_positions() {
        let frame = SceneFrame::plain(Earth::Curved { radius_factor: 1.0 });
        let start = TimeTag::new(1_000_000, 0.25);
        let course = Course::straight([40e3, -20e3], 2.0, 10.0);
        let tracks = ShipTracks { frame, start, courses: vec![course], trajectories: vec![None] };
        let mut pulse = Pulse::new(&Layout { channels: 1, samples: 1, ships: 1, ..Layout::default() });
        let mut at = |time_s: f64| {
            pulse.time = start.plus(time_s);
            tracks.record(&mut pulse);
            (pulse.ship_position_m[0], pulse.ship_velocity_mps[0], pulse.ship_heading_deg[0])
        };
        let ((before, ..), (_, velocity, heading_deg), (after, ..)) = (at(9.0), at(10.0), at(11.0));
        for axis in 0..3 {
            // A parabola: the difference is exact but for rounding of 40 km.
            assert!((0.5 * (after[axis] - before[axis]) - velocity[axis]).abs() < 1e-9);
        }
        assert!(velocity[2] > 0.01 && (heading_deg - (450.0 - 2f64.to_degrees())).abs() < 1e-9);
    }
}
