//! The track of a ship on the water, for what it leaves behind on it.
//!
//! A chain of chords whose courses differ by no more than [`TURN_RAD`], with straight lines before and after.
//! A place is as far astern as the ship has run since it was at the foot of the perpendicular (outside of a
//! corner: at the corner), and as far aside as it is from there; of several feet (a track that comes back to
//! where it was) that counts at which there is most of the wake. A chord of an arc of radius R lies within `R
//! TURN_RAD^2/8` of it: 13 mm of 1 km.
//!
//! ```
//! use nereus::frames::{Point, Vector};
//! use nereus::scene::trajectory::{Knot, Trajectory};
//! use nereus::sea::wake::TurbulentStrip;
//! use nereus::sea::wake::track_line::TrackLine;
//! let knot = |time_s: f64| Knot {
//!     time_s,
//!     position: Point::new(5.0 * time_s, 0.0, 0.0),
//!     velocity: Vector::new(5.0, 0.0, 0.0),
//!     acceleration: Vector::ZERO,
//! };
//! let line = TrackLine::new(&Trajectory::new(vec![knot(0.0), knot(100.0)]).unwrap());
//! let strip = TurbulentStrip::with(50.0, 8.0, 5.0, 1000.0)?;
//! // 60 s after pulse 0 the ship is at x = 300 m; it began before the track did.
//! assert!((line.run_m(60.0) - 300.0).abs() < 1e-9);
//! for (place_m, astern_m) in [([200.0, 3.0], 100.0), ([-100.0, 3.0], 400.0)] {
//!     assert!((line.cover(&strip, place_m, 300.0) - strip.cover([astern_m, 3.0])).abs() < 1e-12);
//! }
//! # Ok::<(), nereus::sea::wake::WakeError>(())
//! ```

use super::turbulent::TurbulentStrip;
use crate::scene::Trajectory;
use crate::scene::ship::Sailed;
use crate::scene::trajectory::Knot;

/// Change of course from chord to chord, rad.
pub const TURN_RAD: f64 = 0.01;
/// Most chords of a segment of a trajectory.
const MOST_CHORDS: f64 = 1000.0;
/// Parts of a segment in which its turns are looked for.
const PARTS: u32 = 8;
/// Chords that are asked together.
const TOGETHER: usize = 16;
/// How far it goes straight on at its ends, m.
const BEYOND_M: f64 = 1e6;

/// A corner of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Vertex {
    time_s: f64,
    place_m: [f64; 2],
    /// Run since pulse 0.
    run_m: f64,
}

/// Some chords: the first of them, and the rectangle (least and largest x, and y) about all.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Group {
    first: usize,
    after: usize,
    bounds_m: [[f64; 2]; 2],
}

/// The track of a ship.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackLine {
    vertices: Vec<Vertex>,
    groups: Vec<Group>,
}

/// Times of the corners within a segment, its end left out.
fn times(way: &Trajectory, pair: &[Knot]) -> Vec<f64> {
    let (from_s, lasts_s) = (pair[0].time_s, pair[1].time_s - pair[0].time_s);
    let turn_radps = |n: u32| {
        let time_s = from_s + lasts_s * f64::from(n) / f64::from(PARTS);
        Sailed::on(way, time_s, [1.0, 0.0]).turn_radps.abs()
    };
    let most_radps = (0..=PARTS).map(turn_radps).fold(0.0, f64::max);
    // From 1 to MOST_CHORDS: the cast is exact.
    let chords = (most_radps * lasts_s / TURN_RAD).ceil().clamp(1.0, MOST_CHORDS) as u32;
    (0..chords).map(|n| from_s + lasts_s * f64::from(n) / f64::from(chords)).collect()
}

impl TrackLine {
    /// Of a ship on a trajectory.
    pub fn new(way: &Trajectory) -> Self {
        let of_segments = way.knots().windows(2).flat_map(|pair| times(way, pair));
        let times: Vec<f64> = of_segments.chain([way.span_s()[1]]).collect();
        let at = |time_s: f64| Sailed::on(way, time_s, [1.0, 0.0]);
        let mut vertices: Vec<Vertex> = Vec::with_capacity(times.len() + 2);
        for &time_s in &times {
            let place_m = at(time_s).position_m;
            let run_m = vertices.last().map_or(0.0, |last| {
                last.run_m + (place_m[0] - last.place_m[0]).hypot(place_m[1] - last.place_m[1])
            });
            // A chord has a length.
            if vertices.last().is_none_or(|last| run_m > last.run_m) {
                vertices.push(Vertex { time_s, place_m, run_m });
            }
        }
        let straight = |vertex: &Vertex, sign: f64| {
            let Sailed { velocity_mps, ahead, .. } = at(vertex.time_s);
            let speed_mps = velocity_mps[0].hypot(velocity_mps[1]);
            Vertex {
                time_s: vertex.time_s + sign * BEYOND_M / speed_mps,
                place_m: [0, 1].map(|i| vertex.place_m[i] + sign * BEYOND_M * ahead[i]),
                run_m: vertex.run_m + sign * BEYOND_M,
            }
        };
        let ends = [straight(&vertices[0], -1.0), straight(&vertices[vertices.len() - 1], 1.0)];
        vertices.insert(0, ends[0]);
        vertices.push(ends[1]);
        let mut line = Self { vertices, groups: Vec::new() };
        let offset_m = line.run_m(0.0);
        line.vertices.iter_mut().for_each(|vertex| vertex.run_m -= offset_m);
        line.groups = line.grouped();
        line
    }

    fn grouped(&self) -> Vec<Group> {
        let last = self.vertices.len() - 1;
        // The straight lines at both ends are groups of their own: their rectangles are large.
        let inside = (1..last - 1).step_by(TOGETHER).map(|first| (first, (first + TOGETHER).min(last - 1)));
        let all = [(0, 1)].into_iter().chain(inside).chain([(last - 1, last)]);
        let group = |(first, after): (usize, usize)| {
            let places = self.vertices[first..=after].iter().map(|vertex| vertex.place_m);
            let bounds_m = places.fold([[f64::INFINITY, f64::NEG_INFINITY]; 2], |bounds, place| {
                [0, 1].map(|i| [bounds[i][0].min(place[i]), bounds[i][1].max(place[i])])
            });
            Group { first, after, bounds_m }
        };
        all.filter(|(first, after)| first < after).map(group).collect()
    }

    /// How far the ship has run at a time since pulse 0, m.
    pub fn run_m(&self, time_s: f64) -> f64 {
        let last = self.vertices.len() - 1;
        let after = self.vertices.partition_point(|vertex| vertex.time_s <= time_s).clamp(1, last);
        let (from, to) = (&self.vertices[after - 1], &self.vertices[after]);
        from.run_m + (to.run_m - from.run_m) * (time_s - from.time_s) / (to.time_s - from.time_s)
    }

    /// Share of the water at a place that a strip covers when its ship has run so far, m.
    pub fn cover(&self, strip: &TurbulentStrip, place_m: [f64; 2], run_m: f64) -> f64 {
        let mut most = 0.0f64;
        for group in &self.groups {
            let Some(reach_m) = self.reach_m(strip, group, run_m) else { continue };
            let [[x0, x1], [y0, y1]] = group.bounds_m;
            let inside = place_m[0] > x0 - reach_m
                && place_m[0] < x1 + reach_m
                && place_m[1] > y0 - reach_m
                && place_m[1] < y1 + reach_m;
            if !inside {
                continue;
            }
            // Of the chord before, so that what lies outside of a corner belongs to its vertex.
            let mut before = group.first.checked_sub(1).map_or(0.0, |first| self.foot(first, place_m)[0]);
            for first in group.first..group.after {
                let (a, b) = (&self.vertices[first], &self.vertices[first + 1]);
                let [share, aside_m] = self.foot(first, place_m);
                if (0.0..=1.0).contains(&share) {
                    let astern_m = run_m - (a.run_m + share * (b.run_m - a.run_m));
                    most = most.max(strip.cover([astern_m, aside_m]));
                } else if share < 0.0 && before > 1.0 {
                    let corner_m = (place_m[0] - a.place_m[0]).hypot(place_m[1] - a.place_m[1]);
                    most = most.max(strip.cover([run_m - a.run_m, corner_m]));
                }
                before = share;
            }
        }
        most
    }

    /// Where on a chord the perpendicular of a place stands, 0 to 1 within it, and how far off the place is,
    /// m.
    fn foot(&self, first: usize, place_m: [f64; 2]) -> [f64; 2] {
        let (a, b) = (&self.vertices[first], &self.vertices[first + 1]);
        let [ux, uy] = [0, 1].map(|i| b.place_m[i] - a.place_m[i]);
        let [dx, dy] = [0, 1].map(|i| place_m[i] - a.place_m[i]);
        let square = ux * ux + uy * uy;
        [(dx * ux + dy * uy) / square, (dx * uy - dy * ux).abs() / square.sqrt()]
    }

    /// Whether a strip may cover any place in a rectangle (least and largest x, and y).
    pub fn is_near(&self, strip: &TurbulentStrip, bounds_m: [[f64; 2]; 2], run_m: f64) -> bool {
        self.groups.iter().any(|group| {
            self.reach_m(strip, group, run_m).is_some_and(|reach_m| {
                let near = |i: usize| {
                    bounds_m[i][0] < group.bounds_m[i][1] + reach_m
                        && bounds_m[i][1] > group.bounds_m[i][0] - reach_m
                };
                near(0) && near(1)
            })
        })
    }

    /// How far from the chords of a group a strip reaches; `None` where the ship has not been there yet, or
    /// it is forgotten.
    fn reach_m(&self, strip: &TurbulentStrip, group: &Group, run_m: f64) -> Option<f64> {
        let least_m = run_m - self.vertices[group.after].run_m;
        let most_m = run_m - self.vertices[group.first].run_m;
        let reach_m = strip.reach_aside_m(most_m.min(strip.end_m()));
        (reach_m > 0.0 && least_m < strip.end_m()).then_some(reach_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::waypoints;

    /// The strip of a ship that goes round lies on its track: full on it, nothing beside it, by the distance
    /// run.
    #[test]
    fn the_strip_lies_on_the_track() {
        let corners = [[0.0, 0.0], [600.0, 0.0], [600.0, 600.0], [0.0, 600.0], [0.0, 200.0], [300.0, 200.0]];
        let way = Trajectory::new(waypoints::knots(&corners, 5.0, 100.0, 0.0).unwrap()).unwrap();
        let (line, strip) = (TrackLine::new(&way), TurbulentStrip::with(40.0, 6.0, 5.0, 800.0).unwrap());
        let now_s = way.span_s()[1];
        let run_m = line.run_m(now_s);
        // At constant speed; corners are chords of arcs, shorter by turn^2/24.
        assert!((run_m / (5.0 * now_s) - 1.0).abs() < 1e-5);
        for n in 0..400 {
            let time_s = now_s * f64::from(n) / 400.0;
            let Sailed { position_m: [x, y], ahead: [cos, sin], .. } = Sailed::on(&way, time_s, [1.0, 0.0]);
            let astern_m = run_m - line.run_m(time_s);
            let wanted = |aside_m: f64| strip.cover([astern_m, aside_m]);
            let half_m = 0.5 * strip.width_m(astern_m - 20.0);
            for aside_m in [0.0, 0.5 * half_m, -0.9 * half_m] {
                let found = line.cover(&strip, [x - aside_m * sin, y + aside_m * cos], run_m);
                assert!((found - wanted(aside_m)).abs() < 2e-3, "{time_s} {aside_m}: {found}");
            }
            // Right behind the stern too, where it sets in.
            let astern_m = 20.0 + 0.02 * f64::from(n);
            let line_m = line.run_m(time_s);
            let found = line.cover(&strip, [x, y], line_m + astern_m);
            assert!((found - strip.cover([astern_m, 0.0])).abs() < 2e-3, "{time_s} {astern_m}: {found}");
            if time_s > 30.0 && half_m > 0.0 {
                let beside = line.cover(&strip, [x + 1.2 * half_m * sin, y - 1.2 * half_m * cos], run_m);
                assert_eq!(beside, 0.0, "{time_s}");
            }
        }
    }

    /// Nothing is covered outside of what is near.
    #[test]
    fn near_is_all_that_is_covered() {
        let corners = [[0.0, 0.0], [300.0, 100.0], [200.0, 400.0], [-200.0, 300.0]];
        let way = Trajectory::new(waypoints::knots(&corners, 4.0, 50.0, 0.0).unwrap()).unwrap();
        let (line, strip) = (TrackLine::new(&way), TurbulentStrip::with(30.0, 5.0, 4.0, 100.0).unwrap());
        let mut covered = 0;
        for n in 0..40 {
            let run_m = 25.0 * f64::from(n);
            for i in -40..40 {
                for j in -20..60 {
                    let place = [f64::from(i) * 10.0, f64::from(j) * 10.0];
                    let around = place.map(|at| [at - 1.0, at + 1.0]);
                    let cover = line.cover(&strip, place, run_m);
                    covered += u32::from(cover > 0.0);
                    assert!(cover == 0.0 || line.is_near(&strip, around, run_m), "{place:?}");
                }
            }
        }
        assert!(covered > 300, "{covered}");
    }
}
