//! A way through positions that are reported with course and speed, as AIS has them.
//!
//! Between two reports the way is the cubic that has the positions and velocities of both. So that the
//! acceleration is continuous, a report takes the mean of those of the cubics that meet in it, and the way is
//! the quintic through all ([`crate::scene::trajectory`]).
//!
//! Receivers err, and messages are garbled: a report is **refused** where the ship would have to turn faster
//! than it can, or to be faster than its reports have it by half, since the last one that was kept, counted
//! from one about pulse 0. What is reported is rounded (0.1 degree, 0.1 knot, 0.2 m) and wrong by some
//! metres: that much is allowed on top.
//!
//! Limits: course over ground for the heading; reports are taken for exact.

use crate::frames::{Point, Vector};
use crate::scene::trajectory::Knot;

/// What a position may be wrong by, m, and a course, rad.
const WRONG_M: f64 = 30.0;
const WRONG_RAD: f64 = 0.05;
/// Speed below which a course says nothing, m/s.
const LEAST_MPS: f64 = 0.5;

/// A report: where a ship is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reported {
    /// After pulse 0, s.
    pub time_s: f64,
    /// East and North, m.
    pub position_m: [f64; 2],
    /// The same of the velocity, m/s.
    pub velocity_mps: [f64; 2],
}

/// Reports about pulse 0, on either side, from each of which a way is tried: any of them may be garbled.
const TRIED: usize = 2;

/// Reports, in their order of time, that a ship can have made that turns no faster; and how many it cannot.
/// Of those with the same time the first is kept. Ways lead from a report about pulse 0 to both ends; that
/// which keeps most is taken.
pub fn plausible(reports: &[Reported], most_turn_radps: f64) -> (Vec<Reported>, usize) {
    let mut own: Vec<Reported> = Vec::with_capacity(reports.len());
    for report in reports {
        if own.last().is_none_or(|last| report.time_s > last.time_s) {
            own.push(*report);
        }
    }
    let from = |first: usize| {
        let chain = |mut kept: Vec<Reported>, report: &Reported| {
            if kept.last().is_none_or(|last| is_possible(last, report, most_turn_radps)) {
                kept.push(*report);
            }
            kept
        };
        let mut kept = own[..=first].iter().rev().fold(Vec::new(), chain);
        kept.reverse();
        own[first + 1..].iter().fold(kept, chain)
    };
    let now = own.partition_point(|report| report.time_s < 0.0);
    let tried = now.saturating_sub(TRIED)..(now + TRIED).min(own.len());
    // Of equals the first.
    let kept = tried.rev().map(from).max_by_key(Vec::len).unwrap_or_default();
    let refused = own.len() - kept.len();
    (kept, refused)
}

/// Whether a ship that turns no faster can have made both reports, of different times.
fn is_possible(one: &Reported, other: &Reported, most_turn_radps: f64) -> bool {
    let gap_s = (other.time_s - one.time_s).abs();
    let heading = |of: &Reported| of.velocity_mps[1].atan2(of.velocity_mps[0]);
    let turn = heading(other) - heading(one);
    let turn_rad = turn.sin().atan2(turn.cos()).abs();
    let speeds_mps = [one, other].map(|of| of.velocity_mps[0].hypot(of.velocity_mps[1]));
    let heads = speeds_mps[0].min(speeds_mps[1]) >= LEAST_MPS;
    let [x, y] = [0, 1].map(|i| other.position_m[i] - one.position_m[i]);
    (!heads || turn_rad <= most_turn_radps * gap_s + WRONG_RAD)
        && x.hypot(y) <= 1.5 * speeds_mps[0].max(speeds_mps[1]) * gap_s + WRONG_M
}

/// Knots of the way through reports; heights are 0.
pub fn knots(reports: &[Reported]) -> Vec<Knot> {
    // Of the cubic of a segment, at its begin and at its end.
    let accelerations = |pair: &[Reported]| {
        let h = pair[1].time_s - pair[0].time_s;
        let of = |i: usize| {
            let rise = (pair[1].position_m[i] - pair[0].position_m[i]) / h;
            let [v0, v1] = [pair[0].velocity_mps[i], pair[1].velocity_mps[i]];
            [(6.0 * rise - 4.0 * v0 - 2.0 * v1) / h, (2.0 * v0 + 4.0 * v1 - 6.0 * rise) / h]
        };
        [of(0), of(1)]
    };
    let segments: Vec<[[f64; 2]; 2]> = reports.windows(2).map(accelerations).collect();
    let knot = |(n, report): (usize, &Reported)| {
        let before = n.checked_sub(1).and_then(|n| segments.get(n));
        let acceleration = [0, 1].map(|i| match (before, segments.get(n)) {
            (Some(before), Some(after)) => 0.5 * (before[i][1] + after[i][0]),
            // It begins and ends without turning: beyond its reports it goes straight on.
            _ => 0.0,
        });
        let ([x, y], [vx, vy], [ax, ay]) = (report.position_m, report.velocity_mps, acceleration);
        Knot {
            time_s: report.time_s,
            position: Point::new(x, y, 0.0),
            velocity: Vector::new(vx, vy, 0.0),
            acceleration: Vector::new(ax, ay, 0.0),
        }
    };
    reports.iter().enumerate().map(knot).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Trajectory;

    /// A ship at 8 m/s on a circle of 500 m that reports every 6 s.
    fn circling(n: u32) -> Reported {
        let (time_s, rate) = (6.0 * f64::from(n), 8.0 / 500.0);
        let (sin, cos) = (rate * time_s).sin_cos();
        Reported { time_s, position_m: [500.0 * sin, -500.0 * cos], velocity_mps: [8.0 * cos, 8.0 * sin] }
    }

    /// The cubic through two points of a circle with its tangents leaves it by `R a^4/384` for an angle `a`
    /// between them; the quintic with accelerations of both sides is nearer, except for its ends.
    #[test]
    fn a_circle_stays_a_circle() {
        let reports: Vec<Reported> = (0..60).map(circling).collect();
        let (kept, refused) = plausible(&reports, 0.02);
        assert_eq!((kept.len(), refused), (60, 0));
        let way = Trajectory::new(knots(&kept)).unwrap();
        let angle = 8.0 / 500.0 * 6.0;
        for n in 60..3400 {
            let [x, y, _] = way.at(0.1 * f64::from(n)).position.to_array();
            assert!((x.hypot(y) - 500.0).abs() < 500.0 * f64::powi(angle, 4) / 384.0, "{n}");
        }
    }

    #[test]
    fn what_no_ship_can_do_is_refused() {
        let mut reports: Vec<Reported> = (0..20).map(circling).collect();
        reports[7].position_m[0] += 500.0;
        reports[11].velocity_mps = reports[11].velocity_mps.map(|v| -v);
        reports.insert(3, Reported { time_s: reports[2].time_s, ..reports[9] });
        let (kept, refused) = plausible(&reports, 0.02);
        assert_eq!((kept.len(), refused), (18, 2));
        // Nor does the first one decide.
        reports[0].position_m[0] += 5000.0;
        assert_eq!((plausible(&reports, 0.02).0.len(), plausible(&reports, 0.02).1), (17, 3));
        // A bound below what it does lets it go on only once it has come round again.
        assert!(plausible(&reports, 0.001).1 > 10);
    }
}
