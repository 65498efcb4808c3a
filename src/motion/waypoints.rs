//! A way through waypoints at constant speed: straight legs, and corners that are rounded.
//!
//! About a waypoint at which the course changes by `D` it turns over a length `L` of its way by
//!
//! `psi(u) = D (10 u^3 - 15 u^4 + 6 u^5)` , `u = s/L` , `L = 15/8 |D| R` ,
//!
//! which is least curved at both ends and has the radius `R` in its middle: heading, rate of turn and its
//! own rate are continuous. The corner begins and ends at the same distance from the waypoint,
//!
//! `d = |integral of (cos psi, sin psi) ds| / (2 cos(D/2))` ,
//!
//! and legs must hold the corners at both of their ends.
//!
//! ```
//! use nereus::motion::waypoints::knots;
//! let knots = knots(&[[0.0, 0.0], [1000.0, 0.0], [1000.0, 1000.0]], 5.0, 100.0, -20.0)?;
//! assert_eq!((knots[0].time_s, knots[0].position.to_array()), (-20.0, [0.0, 0.0, 0.0]));
//! let last = knots.last().unwrap();
//! let [x, y, _] = last.position.to_array();
//! assert!((x - 1000.0).abs() < 1e-6 && (y - 1000.0).abs() < 1e-9);
//! assert!(knots.iter().all(|knot| (knot.velocity.norm() - 5.0).abs() < 1e-9));
//! # Ok::<(), nereus::motion::waypoints::WaypointFault>(())
//! ```

use crate::frames::{Point, Vector};
use crate::scene::trajectory::Knot;

/// Change of course from knot to knot, rad.
const STEP_RAD: f64 = 0.05;
/// Steps of the integral from knot to knot.
const STEPS: u32 = 8;
/// Sharpest corner, degrees.
const MOST_DEG: f64 = 170.0;

/// What is wrong with waypoints; they are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WaypointFault {
    /// Two in the same place.
    #[error("waypoints {first} and {} lie in the same place: legs are at least 1 mm long", first + 1)]
    Coincide {
        /// The first of them.
        first: usize,
    },
    /// A corner too sharp.
    #[error("the course turns by {turn_deg:.1} deg at waypoint {index}: allowed are at most {MOST_DEG} deg")]
    Sharp {
        /// Which.
        index: usize,
        /// By how much, degrees.
        turn_deg: f64,
    },
    /// A leg that does not hold its corners.
    #[error(
        "the leg from waypoint {first} to {} is {leg_m:.1} m long, and its corners take {needed_m:.1} m of \
         it: allowed are longer legs, or a smaller turn_radius_m", first + 1
    )]
    Short {
        /// Where it begins.
        first: usize,
        /// How long it is, m.
        leg_m: f64,
        /// What its corners need, m.
        needed_m: f64,
    },
}

/// A corner.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    turn_rad: f64,
    length_m: f64,
    /// From its ends to the waypoint, m.
    before_m: f64,
}

impl Corner {
    fn new(turn_rad: f64, radius_m: f64) -> Self {
        let length_m = 15.0 / 8.0 * turn_rad.abs() * radius_m;
        let corner = Self { turn_rad, length_m, before_m: 0.0 };
        let [x, y] = corner.run_m(0.0, 1.0, 64 * STEPS);
        Self { before_m: x.hypot(y) / (2.0 * (0.5 * turn_rad).cos()), ..corner }
    }

    /// Heading beyond that before it, rad, and its change over the way, rad/m.
    fn bend(&self, u: f64) -> [f64; 2] {
        let psi = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
        let rate = 30.0 * u * u * (1.0 - u) * (1.0 - u);
        [self.turn_rad * psi, self.turn_rad * rate / self.length_m]
    }

    /// The way from one share of the length to another, along and to port of the course before it, m:
    /// Simpson's rule.
    fn run_m(&self, from: f64, to: f64, steps: u32) -> [f64; 2] {
        let h = (to - from) / f64::from(2 * steps);
        let weight = |n: u32| match n {
            0 => 1.0,
            n if n == 2 * steps => 1.0,
            n if n % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let mut sum = [0.0; 2];
        for n in 0..=2 * steps {
            let (sin, cos) = self.bend(from + h * f64::from(n))[0].sin_cos();
            sum = [sum[0] + weight(n) * cos, sum[1] + weight(n) * sin];
        }
        sum.map(|sum| sum * h / 3.0 * self.length_m)
    }
}

/// Knots of the way through waypoints, East and North, m: at a speed, with corners of a radius, leaving the
/// first at a time after pulse 0. Heights are 0.
///
/// # Errors
/// Waypoints through which no such way leads.
pub fn knots(
    points: &[[f64; 2]],
    speed_mps: f64,
    radius_m: f64,
    begin_s: f64,
) -> Result<Vec<Knot>, WaypointFault> {
    let leg = |pair: &[[f64; 2]]| {
        let [x, y] = [0, 1].map(|i| pair[1][i] - pair[0][i]);
        (x.hypot(y), y.atan2(x))
    };
    let legs: Vec<(f64, f64)> = points.windows(2).map(leg).collect();
    if let Some(first) = legs.iter().position(|(length_m, _)| *length_m < 1e-3) {
        return Err(WaypointFault::Coincide { first });
    }
    let mut corners = vec![Corner::default(); points.len()];
    for (index, pair) in legs.windows(2).enumerate() {
        let turn = pair[1].1 - pair[0].1;
        let turn_rad = turn.sin().atan2(turn.cos());
        if turn_rad.to_degrees().abs() > MOST_DEG {
            return Err(WaypointFault::Sharp { index: index + 1, turn_deg: turn_rad.to_degrees().abs() });
        }
        if turn_rad.abs() > 1e-12 {
            corners[index + 1] = Corner::new(turn_rad, radius_m);
        }
    }
    let mut knots = Vec::new();
    let mut run_m = 0.0;
    let mut push = |run_m: f64, [x, y]: [f64; 2], heading_rad: f64, curvature: f64| {
        let (sin, cos) = heading_rad.sin_cos();
        let turns = speed_mps * speed_mps * curvature;
        knots.push(Knot {
            time_s: begin_s + run_m / speed_mps,
            position: Point::new(x, y, 0.0),
            velocity: Vector::new(speed_mps * cos, speed_mps * sin, 0.0),
            acceleration: Vector::new(-turns * sin, turns * cos, 0.0),
        });
    };
    for (first, (leg_m, heading_rad)) in legs.iter().copied().enumerate() {
        let (before, after) = (corners[first], corners[first + 1]);
        let needed_m = before.before_m + after.before_m;
        let straight_m = leg_m - needed_m;
        if straight_m < 1e-3 {
            return Err(WaypointFault::Short { first, leg_m, needed_m });
        }
        let (sin, cos) = heading_rad.sin_cos();
        let at = |along_m: f64| [points[first][0] + along_m * cos, points[first][1] + along_m * sin];
        push(run_m, at(before.before_m), heading_rad, 0.0);
        run_m += straight_m;
        let begins = at(leg_m - after.before_m);
        if first + 2 == points.len() {
            push(run_m, begins, heading_rad, 0.0);
            break;
        }
        if after.length_m == 0.0 {
            continue;
        }
        push(run_m, begins, heading_rad, 0.0);
        let parts = (2.0 * after.turn_rad.abs() / STEP_RAD).ceil().max(4.0);
        let mut place = begins;
        // Its last knot is the first of the next leg.
        for part in 1..parts as u32 {
            let [from, to] = [f64::from(part - 1), f64::from(part)].map(|part| part / parts);
            let [along, port] = after.run_m(from, to, STEPS);
            place = [place[0] + along * cos - port * sin, place[1] + along * sin + port * cos];
            let [bend_rad, curvature] = after.bend(to);
            push(run_m + to * after.length_m, place, heading_rad + bend_rad, curvature);
        }
        run_m += after.length_m;
    }
    Ok(knots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Trajectory;

    /// The way keeps its speed, its heading turns no faster than the radius allows, and its corners join.
    #[test]
    fn corners_are_smooth() {
        let points = [[0.0, 0.0], [800.0, 100.0], [300.0, 900.0], [900.0, 1000.0]];
        let way = Trajectory::new(knots(&points, 7.0, 60.0, 0.0).unwrap()).unwrap();
        let [first_s, last_s] = way.span_s();
        let mut turns = 0.0f64;
        for n in 0..=20_000 {
            let now = way.at(first_s + (last_s - first_s) * f64::from(n) / 20_000.0);
            let ([vx, vy, _], [ax, ay, _]) = (now.velocity.to_array(), now.acceleration.to_array());
            assert!((vx.hypot(vy) - 7.0).abs() < 1e-6, "{}", vx.hypot(vy));
            assert!((vx * ax + vy * ay).abs() < 1e-4, "it speeds up at {}", now.time_s);
            turns = turns.max((vx * ay - vy * ax).abs() / 49.0);
        }
        // Least radius 60 m.
        assert!((turns / (7.0 / 60.0) - 1.0).abs() < 1e-4, "{turns}");
        let [x, y, _] = way.at(last_s).position.to_array();
        assert!((x - 900.0).hypot(y - 1000.0) < 1e-9);
    }

    #[test]
    fn faults_are_named() {
        let text = |points: &[[f64; 2]]| knots(points, 5.0, 100.0, 0.0).unwrap_err().to_string();
        assert!(text(&[[0.0, 0.0], [0.0, 0.0]]).contains("waypoints 0 and 1 lie in the same place"));
        assert!(text(&[[0.0, 0.0], [9.0, 0.0], [0.0, 0.1]]).contains("by 179.4 deg at waypoint 1"));
        let short = text(&[[0.0, 0.0], [100.0, 0.0], [100.0, 900.0]]);
        assert!(short.contains("from waypoint 0 to 1 is 100.0 m long"), "{short}");
    }
}
