//! The waves of a ship that turns: those of straight legs, cross-faded.
//!
//! The track is cut into legs over which the course turns by no more than [`LEG_RAD`] and the speed changes
//! by no more than a tenth. Every leg has the wake of a ship that sails straight along it, before it and
//! beyond it as well, under a window on **when a wave was made**:
//!
//! `t_0 = t - K x/V` , `K = 3/2` ,
//!
//! `x` the distance astern of that ship, `V` its speed. A ship makes a wave that runs at an angle theta to
//! the course at `t - x/(V (1 - cos^2(theta)/2))`: `K` is 2 of the transverse waves, 1 of the steepest
//! divergent ones, and 3/2 of those at the cusps. The window rises about the time at which the leg begins and
//! falls about that at which it ends, as `10 u^3 - 15 u^4 + 6 u^5`, over the shorter one of the two legs that
//! meet there: the windows of all legs add up to 1. Rates of the window are in all rates of the waves, so
//! that heights stay the integrals of velocities: with `t` at a fixed place `dx/dt = V`, hence
//! `dt_0/dt = 1 - K`.
//!
//! Approximated: waves of a turn are those of its chords; all waves at a place are taken to be as old as
//! those at the cusps, so that transverse ones fade up to `x/2V` late and divergent ones as much early;
//! waves of a leg run straight on, as real ones do, and nothing bends them; the hull makes no other waves in
//! a turn than on a straight course.
//!
//! ```
//! use nereus::sea::wake::leg::LegWindow;
//! let first = LegWindow { begin_s: None, end_s: Some([100.0, 20.0]) };
//! let second = LegWindow { begin_s: Some([100.0, 20.0]), end_s: None };
//! // 60 m astern at 5 m/s waves are 18 s old.
//! assert_eq!((first.at(100.0, 60.0, 5.0).value, second.at(100.0, 60.0, 5.0).value), (1.0, 0.0));
//! let sum = first.at(115.0, 60.0, 5.0).value + second.at(115.0, 60.0, 5.0).value;
//! assert!((sum - 1.0).abs() < 1e-15);
//! ```

use super::course::Course;
use super::upstream::{Edge, Moving};
use crate::scene::Trajectory;
use crate::scene::ship::Sailed;
use crate::scene::trajectory::Knot;

/// Turn of a leg at most, rad.
pub const LEG_RAD: f64 = 0.2;
/// Change of its speed at most, over it.
const LEG_SPEED: f64 = 0.1;
/// A leg that turns by less is straight, rad.
const STRAIGHT_RAD: f64 = 1e-4;
/// Age of a wave over the time in which the ship ran the distance astern.
pub const AGE: f64 = 1.5;
/// Parts of a segment of a trajectory that are looked at.
const PARTS: u32 = 8;

/// When the waves of a leg were made: the middle and the length of the time over which they set in and end,
/// s after pulse 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LegWindow {
    /// `None`: they were made ever since.
    pub begin_s: Option<[f64; 2]>,
    /// `None`: they are made without end.
    pub end_s: Option<[f64; 2]>,
}

/// Value, first and second derivative of the step from 0 to 1.
fn step(u: f64) -> [f64; 3] {
    if u <= 0.0 {
        return [0.0; 3];
    }
    if u >= 1.0 {
        return [1.0, 0.0, 0.0];
    }
    let v = 1.0 - u;
    [u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * v * v, 60.0 * u * v * (v - u)]
}

impl LegWindow {
    /// Distances astern between which there are waves at a time, m, for a ship of a speed, m/s.
    pub fn range_m(&self, time_s: f64, speed_mps: f64) -> [f64; 2] {
        let astern_m = |made_s: f64| (time_s - made_s) * speed_mps / AGE;
        [
            self.end_s.map_or(f64::NEG_INFINITY, |[middle_s, long_s]| astern_m(middle_s + 0.5 * long_s)),
            self.begin_s.map_or(f64::INFINITY, |[middle_s, long_s]| astern_m(middle_s - 0.5 * long_s)),
        ]
    }

    /// The window at a time and a distance astern, m.
    pub fn at(&self, time_s: f64, astern_m: f64, speed_mps: f64) -> Moving {
        let made_s = time_s - AGE * astern_m / speed_mps;
        let of = |[middle_s, long_s]: [f64; 2]| {
            let [value, rate, bend] = step((made_s - middle_s) / long_s + 0.5);
            [value, rate / long_s, bend / (long_s * long_s)]
        };
        let begins = self.begin_s.map_or([1.0, 0.0, 0.0], of);
        let ends = self.end_s.map_or([0.0; 3], of);
        let [value, rate, bend] = [0, 1, 2].map(|i| begins[i] - ends[i]);
        let (per_m, per_s) = (-AGE / speed_mps, 1.0 - AGE);
        Moving {
            value,
            rate_per_m: per_m * rate,
            rate_per_s: per_s * rate,
            bend_per_m_s: per_m * per_s * bend,
            bend_per_s2: per_s * per_s * bend,
        }
    }

    /// The same under the window of the ship itself.
    #[inline]
    pub fn under(&self, edge: &Edge, time_s: f64, astern_m: f64, speed_mps: f64) -> Moving {
        edge.moving(speed_mps).times(&self.at(time_s, astern_m, speed_mps))
    }
}

/// A straight leg: the course that leads along it, and when it was sailed; `None` of a ship that sails
/// straight all the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Straight on before and after.
    pub course: Course,
    /// When its waves were made.
    pub window: Option<LegWindow>,
}

/// Something of the way: time, heading without jumps, speed, run so far.
struct Mark {
    time_s: f64,
    heading_rad: f64,
    speed_mps: f64,
    run_m: f64,
}

fn marks(way: &Trajectory) -> Vec<Mark> {
    let of_segment = |pair: &[Knot]| {
        let step_s = (pair[1].time_s - pair[0].time_s) / f64::from(PARTS);
        let from_s = pair[0].time_s;
        (0..PARTS).map(move |n| from_s + step_s * f64::from(n)).collect::<Vec<_>>()
    };
    let times = way.knots().windows(2).flat_map(of_segment).chain([way.span_s()[1]]);
    let mut marks: Vec<Mark> = Vec::new();
    for time_s in times {
        let Sailed { velocity_mps: [vx, vy], ahead, .. } = Sailed::on(way, time_s, [1.0, 0.0]);
        let (heading, speed_mps) = (ahead[1].atan2(ahead[0]), vx.hypot(vy));
        let (heading_rad, run_m) = match marks.last() {
            None => (heading, 0.0),
            Some(last) => {
                let turn = heading - last.heading_rad;
                let mean_mps = 0.5 * (speed_mps + last.speed_mps);
                (
                    last.heading_rad + turn.sin().atan2(turn.cos()),
                    last.run_m + mean_mps * (time_s - last.time_s),
                )
            }
        };
        marks.push(Mark { time_s, heading_rad, speed_mps, run_m });
    }
    marks
}

/// Where a leg that begins at a mark ends: the last mark that still belongs to it, at least the next.
fn end_of(marks: &[Mark], begin: usize) -> usize {
    let first = &marks[begin];
    let mut straight = begin;
    for (n, mark) in marks.iter().enumerate().skip(begin + 1) {
        let turn_rad = (mark.heading_rad - first.heading_rad).abs();
        let faster = (mark.speed_mps / first.speed_mps).ln().abs();
        if turn_rad <= STRAIGHT_RAD {
            straight = n;
        }
        if turn_rad > LEG_RAD || faster > LEG_SPEED {
            // What is straight for most of its time is a leg of its own.
            let lasts_s = |to: usize| marks[to].time_s - first.time_s;
            let cut = if 2.0 * lasts_s(straight) > lasts_s(n - 1) { straight } else { n - 1 };
            return cut.max(begin + 1);
        }
    }
    marks.len() - 1
}

/// The legs of a way.
pub fn legs(way: &Trajectory) -> Vec<Leg> {
    let marks = marks(way);
    let mut cuts = vec![0];
    while let Some(&begin) = cuts.last().filter(|begin| **begin + 1 < marks.len()) {
        cuts.push(end_of(&marks, begin));
    }
    let lasts_s: Vec<f64> = cuts.windows(2).map(|cut| marks[cut[1]].time_s - marks[cut[0]].time_s).collect();
    let last = lasts_s.len().saturating_sub(1);
    let seam = |n: usize| [marks[cuts[n]].time_s, lasts_s[n - 1].min(lasts_s[n])];
    let leg = |n: usize| {
        let (from, to) = (&marks[cuts[n]], &marks[cuts[n + 1]]);
        let place = |time_s: f64| Sailed::on(way, time_s, [1.0, 0.0]).position_m;
        let (a, b) = (place(from.time_s), place(to.time_s));
        let middle_s = 0.5 * (from.time_s + to.time_s);
        let bulge = place(middle_s);
        let (speed_mps, heading_rad) =
            ((to.run_m - from.run_m) / lasts_s[n], (b[1] - a[1]).atan2(b[0] - a[0]));
        let (sin, cos) = heading_rad.sin_cos();
        // Of an arc two thirds of the bulge are between the chord and its mean.
        let through = [0, 1].map(|i| (2.0 * bulge[i] + 0.5 * (a[i] + b[i])) / 3.0);
        let position_m = [through[0] - speed_mps * middle_s * cos, through[1] - speed_mps * middle_s * sin];
        let window = (last > 0)
            .then(|| LegWindow { begin_s: (n > 0).then(|| seam(n)), end_s: (n < last).then(|| seam(n + 1)) });
        Leg { course: Course::straight(position_m, heading_rad, speed_mps), window }
    };
    (0..lasts_s.len()).map(leg).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::waypoints;

    fn way(points: &[[f64; 2]]) -> Trajectory {
        Trajectory::new(waypoints::knots(points, 6.0, 120.0, 0.0).unwrap()).unwrap()
    }

    #[test]
    fn a_straight_way_has_one_leg_without_end() {
        let found = legs(&way(&[[10.0, 20.0], [610.0, 20.0], [1210.0, 20.0]]));
        assert_eq!(found.len(), 1);
        let Leg { course, window } = found[0];
        assert_eq!((window, course.heading_rad), (None, 0.0));
        assert!((course.speed_mps - 6.0).abs() < 1e-12);
        assert!((course.position_m[0] - 10.0).hypot(course.position_m[1] - 20.0) < 1e-9);
    }

    /// Windows add up to 1 whenever a wave was made; legs follow the way closely, and straight ones lie on
    /// it.
    #[test]
    fn legs_follow_the_way() {
        let way = way(&[[0.0, 0.0], [900.0, 0.0], [900.0, 900.0], [0.0, 1100.0]]);
        let found = legs(&way);
        assert!((8..=30).contains(&found.len()), "{}", found.len());
        let [_, last_s] = way.span_s();
        for n in -100..1100 {
            let made_s = last_s * f64::from(n) / 1000.0;
            let weight = |leg: &Leg| leg.window.unwrap().at(made_s, 0.0, leg.course.speed_mps).value;
            let sum: f64 = found.iter().map(weight).sum();
            assert!((sum - 1.0).abs() < 1e-12 && found.iter().all(|leg| weight(leg) > -1e-12), "{made_s}");
            let off_m = |leg: &Leg| {
                let ([x, y], [u, v]) =
                    (leg.course.position_m(made_s), Sailed::on(&way, made_s, [1.0, 0.0]).position_m);
                (x - u).hypot(y - v)
            };
            let off: f64 = found.iter().map(|leg| weight(leg) * off_m(leg)).sum();
            // Where a bend sets in, 0.2 rad are up to 60 m long: a chord and its neighbour that fades are off
            // by a tenth of half of that.
            assert!(off < 4.0, "{made_s}: {off}");
        }
        assert!(found[0].course.heading_rad.abs() < 0.005, "{:?}", found[0]);
    }

    /// Rates are those of the values, at a fixed place and along the way.
    #[test]
    fn rates_are_those_of_the_values() {
        let window = LegWindow { begin_s: Some([10.0, 8.0]), end_s: Some([30.0, 12.0]) };
        let (v, h) = (5.0, 1e-4);
        for n in 0..200 {
            let (t, x) = (40.0, f64::from(n));
            let now = window.at(t, x, v);
            let along = |dt: f64, dx: f64| window.at(t + dt, x + dx + v * dt, v);
            let per_m = (along(0.0, h).value - along(0.0, -h).value) / (2.0 * h);
            let per_s = (along(h, 0.0).value - along(-h, 0.0).value) / (2.0 * h);
            let per_m_s = (along(h, 0.0).rate_per_m - along(-h, 0.0).rate_per_m) / (2.0 * h);
            let per_s2 = (along(h, 0.0).rate_per_s - along(-h, 0.0).rate_per_s) / (2.0 * h);
            assert!((per_m - now.rate_per_m).abs() < 1e-7 && (per_s - now.rate_per_s).abs() < 1e-7);
            assert!((per_m_s - now.bend_per_m_s).abs() < 1e-6 && (per_s2 - now.bend_per_s2).abs() < 1e-6);
        }
    }
}
