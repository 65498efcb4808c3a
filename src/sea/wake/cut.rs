//! Wave cuts: the height of one ship's wake along a line that sails with it.
//!
//! A longitudinal cut runs along the track, `y` m to starboard; a transverse one across it, `x` m astern of
//! midship. Points are whole steps from midship, as far as the line crosses the patch; heights are summed
//! wave by wave.

use std::io::{self, Write};

use serde::Serialize;

use super::{Wake, WakeError};
use crate::scene::Patch;

/// Most points of a cut.
const MOST_POINTS: f64 = 1e6;
/// Steps that may be asked, m.
pub const STEP_RANGE_M: [f64; 2] = [1e-4, 1e5];
/// Furthest line from a ship, m.
pub const FAR_M: f64 = 1e8;

/// Which way a cut runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Along the track.
    Along,
    /// Across it.
    Across,
}

/// A line of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Which way it runs.
    pub way: Way,
    /// How far to starboard or astern, m: at most [`FAR_M`].
    pub at_m: f64,
    /// Step, m: within [`STEP_RANGE_M`].
    pub step_m: f64,
}

/// Height along a line.
#[derive(Debug, Serialize)]
pub struct Cut {
    ship: String,
    /// `along` or `across` the track.
    way: &'static str,
    points: Vec<CutPoint>,
}

/// A point of a cut.
#[derive(Debug, Serialize)]
struct CutPoint {
    astern_m: f64,
    starboard_m: f64,
    east_m: f64,
    north_m: f64,
    height_m: f64,
}

impl Cut {
    /// Of a ship's wake at a time.
    ///
    /// # Errors
    /// A time out of range.
    pub fn of(ship: &str, wake: &Wake, line: &Line, patch: &Patch, time_s: f64) -> Result<Self, WakeError> {
        let pose = wake.course().pose(time_s);
        let [cos, sin] = pose.ahead;
        let place = |astern_m: f64, starboard_m: f64| {
            [
                pose.position_m[0] - astern_m * cos + starboard_m * sin,
                pose.position_m[1] - astern_m * sin - starboard_m * cos,
            ]
        };
        let own = |along_m: f64| match line.way {
            Way::Along => [along_m, line.at_m],
            Way::Across => [line.at_m, along_m],
        };
        let [x, y] = own(0.0);
        let origin = place(x, y);
        let direction = match line.way {
            Way::Along => [-cos, -sin],
            Way::Across => [sin, -cos],
        };
        let mut points = Vec::new();
        if let Some([from_m, to_m]) = crossing(patch, origin, direction) {
            // A patch holds at most 2^26 facets, a step at least 0.1 mm of it: a cut is thinned rather than
            // endless.
            let step_m = line.step_m.max((to_m - from_m) / MOST_POINTS);
            let (first, last) = ((from_m / step_m).ceil() as i64, (to_m / step_m).floor() as i64);
            for n in first..=last {
                let [astern_m, starboard_m] = own(n as f64 * step_m);
                let [east_m, north_m] = place(astern_m, starboard_m);
                let height_m = wake.at([east_m, north_m], time_s)?.height_m;
                points.push(CutPoint { astern_m, starboard_m, east_m, north_m, height_m });
            }
        }
        let way = if line.way == Way::Along { "along" } else { "across" };
        Ok(Self { ship: ship.to_owned(), way, points })
    }
}

/// Where a line enters and leaves the rectangle of the centres of a patch's facets; `None` where it misses
/// it.
fn crossing(patch: &Patch, origin: [f64; 2], direction: [f64; 2]) -> Option<[f64; 2]> {
    let mut span = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..2 {
        let low = patch.first[axis] as f64 * patch.facet_m - origin[axis];
        let high = low + (patch.facets[axis] - 1) as f64 * patch.facet_m;
        if direction[axis].abs() < 1e-12 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let [a, b] = [low / direction[axis], high / direction[axis]];
        span = [span[0].max(a.min(b)), span[1].min(a.max(b))];
    }
    (span[0] <= span[1]).then_some(span)
}

/// Prints cuts as CSV.
///
/// # Errors
/// What cannot be written.
pub fn print(cuts: &[Cut], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "ship,cut,astern_m,starboard_m,east_m,north_m,height_m")?;
    for Cut { ship, way, points } in cuts {
        for CutPoint { astern_m, starboard_m, east_m, north_m, height_m } in points {
            writeln!(out, "{ship},{way},{astern_m},{starboard_m},{east_m},{north_m},{height_m:.12e}")?;
        }
    }
    Ok(())
}
