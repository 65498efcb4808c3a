//! Targets and ships hidden by land.
//!
//! Along the line from a target to an antenna, over the heights of the raster a facet apart ([`Dem`],
//! bilinear, lowered with the sea of a curved earth), a target has the clearance
//!
//! `min of z - z_A - d (h - z_A)/d_A`
//!
//! above the line from the antenna over the highest land before it (`z`, `z_A`, `h` heights of target,
//! antenna and land, `d`, `d_A` distances of target and land from the antenna along the plane), and the
//! weight that a facet has ([`crate::geometry::shadow::visible`]). Sea hides nothing here: crests and horizon
//! do. Weights are found at time samples of the run, from the course of the antenna at the first of the two
//! about an instant (live navigation knows no later one), and are linear in between: at most [`APART_S`], and
//! half a facet of a target's course.
//!
//! A ship that echoes by its mesh has these clearances at its waterline, of bow, midship and stern
//! ([`Hills::along`]); a panel has that of its place along the ship, linear in between, and as much more as
//! it stands higher. It is dark below 0, found and cross-faded as what ships hide of themselves is.
//!
//! Limits: all of the raster hides, and nothing beyond it; lines longer than [`MOST_STEPS`] facets are looked
//! at as many times; land does not change across a ship; the direct path is not hidden.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::frames::{Earth, Enu, Point};
use crate::geometry::shadow::visible;
use crate::motion::pointing::PhaseCentre;
use crate::scene::{Target, Trajectory};
use crate::sea::land::Dem;

/// Time between time samples, s: the longest, and the shortest.
const APART_S: f64 = 0.2;
const SHORTEST_S: f64 = 0.02;
/// Weights that are kept, of all targets and antennas; those about later time samples are found whenever they
/// are needed.
const MOST_KEPT: usize = 4_194_304;
/// Places along a line of sight.
const MOST_STEPS: usize = 4096;

/// The land of a run as it hides targets.
#[derive(Debug)]
pub(super) struct Hills {
    dem: Arc<Dem>,
    earth: Earth,
    width_rad: f64,
    facet_m: f64,
    antennas: usize,
    targets: Vec<Knots>,
}

/// Weights of a target.
#[derive(Debug)]
struct Knots {
    apart_s: f64,
    /// `[knot][antenna]`: at the time sample and at the next.
    weights: Vec<OnceLock<[f64; 2]>>,
}

/// Land as it hides a ship from an antenna.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skyline {
    /// Place along the ship from the stern on, and the height in the scene from which it is seen there, m.
    stations: [(f64, f64); 3],
}

impl Skyline {
    /// Whether it passes a place of a ship, so far ahead of midship and so high in the scene, m.
    pub fn passes(&self, ahead_m: f64, height_m: f64) -> bool {
        let [stern, midship, bow] = self.stations;
        let (from, to) = if ahead_m < midship.0 { (stern, midship) } else { (midship, bow) };
        let share = ((ahead_m - from.0) / (to.0 - from.0)).clamp(0.0, 1.0);
        // Where no land stands its height is -inf: no product of it with 0.
        let least_m = if share > 0.0 && share < 1.0 {
            (1.0 - share) * from.1 + share * to.1
        } else if share > 0.0 {
            to.1
        } else {
            from.1
        };
        height_m >= least_m
    }
}

impl Hills {
    /// Of the land of a run on the earth below, for targets that so many antennas see until a time after
    /// pulse 0.
    pub fn new(
        (dem, earth): (Arc<Dem>, Earth),
        (width_rad, facet_m): (f64, f64),
        antennas: usize,
        targets: &[Target],
        last_s: f64,
    ) -> Self {
        let most = (MOST_KEPT / (targets.len() * antennas).max(1)).max(2);
        let knots = |target: &Target| {
            let [east, north, _] = target.velocity.to_array();
            let fastest_mps = target.trajectory.as_ref().map(Trajectory::fastest_mps);
            let level_mps = fastest_mps.unwrap_or_else(|| east.hypot(north));
            let apart_s = (0.5 * facet_m / level_mps).clamp(SHORTEST_S, APART_S);
            // At most MOST_KEPT: the cast is exact.
            let count = (last_s / apart_s + 3.0).clamp(2.0, most as f64) as usize;
            let weights = std::iter::repeat_with(OnceLock::new).take(count * antennas).collect();
            Knots { apart_s, weights }
        };
        Self { dem, earth, width_rad, facet_m, antennas, targets: targets.iter().map(knots).collect() }
    }

    /// Share of the field between a target and an antenna that passes the land at a time after pulse 0; says
    /// where the target is, and the antenna, at such a time.
    pub fn weight<E>(
        &self,
        number: usize,
        antenna: usize,
        elapsed_s: f64,
        target: impl Fn(f64) -> Point<Enu>,
        centre: impl FnOnce(f64) -> Result<PhaseCentre, E>,
    ) -> Result<f64, E> {
        let Some(Knots { apart_s, weights }) = self.targets.get(number) else { return Ok(1.0) };
        let at = (elapsed_s / apart_s).max(0.0);
        let (knot, share) = (at.floor() as usize, at.fract());
        let kept = weights.get(knot * self.antennas + antenna);
        let [before, after] = match kept.and_then(OnceLock::get) {
            Some(ends) => *ends,
            None => {
                let time_s = knot as f64 * apart_s;
                let PhaseCentre { position, velocity, .. } = centre(time_s)?;
                let then = position + velocity * *apart_s;
                let ends = [(time_s, position), (time_s + apart_s, then)].map(|(time_s, from)| {
                    visible(self.clearance_m(target(time_s), from), self.width_rad, self.facet_m)
                });
                kept.map_or(ends, |kept| *kept.get_or_init(|| ends))
            }
        };
        Ok(before + share * (after - before))
    }

    /// Land as it hides a ship that reaches from its stern to its bow, in its own axes, m, and is where
    /// `scene_m` says, from an antenna; `None` where none does.
    pub fn along(
        &self,
        [stern_m, bow_m]: [f64; 2],
        scene_m: impl Fn(DVec3) -> DVec3,
        antenna_m: DVec3,
    ) -> Option<Skyline> {
        let stations = [stern_m, 0.5 * (stern_m + bow_m), bow_m].map(|ahead_m| {
            let at_m = scene_m(DVec3::new(ahead_m, 0.0, 0.0));
            let clearance_m = self.clearance_m(Point::from_raw(at_m), Point::from_raw(antenna_m));
            (ahead_m, at_m.z - clearance_m)
        });
        stations.iter().any(|(_, height_m)| height_m.is_finite()).then_some(Skyline { stations })
    }

    /// Height of a place above the line from another over the highest land before it, m; infinite without
    /// any.
    fn clearance_m(&self, place: Point<Enu>, from: Point<Enu>) -> f64 {
        let ([x_m, y_m, z_m], [from_x, from_y, from_z]) = (place.to_array(), from.to_array());
        let (east, north) = (from_x - x_m, from_y - y_m);
        let apart_m = east.hypot(north);
        // A place that is not a number, or one above the other, has no line along the plane.
        if !(apart_m > self.facet_m && apart_m.is_finite()) {
            return f64::INFINITY;
        }
        let enough_m = self.width_rad * self.facet_m;
        let steps = ((apart_m / self.facet_m).floor() as usize).min(MOST_STEPS);
        let step_m = (apart_m / MOST_STEPS as f64).max(self.facet_m);
        let mut least_m = f64::INFINITY;
        for n in 1..steps {
            let share = n as f64 * step_m / apart_m;
            let left = 1.0 - share;
            if left * apart_m < self.facet_m {
                break;
            }
            let at = [x_m + share * east, y_m + share * north];
            let drop_m = self.earth.drop_m(at[0], at[1]);
            // Where no land reaches the line nothing is looked up.
            if z_m + share * (from_z - z_m) + drop_m > self.dem.top_m() + enough_m {
                continue;
            }
            let height_m = self.dem.height_m(at);
            if height_m > 0.0 {
                least_m = least_m.min(z_m - from_z - (height_m - drop_m - from_z) / left);
            }
        }
        least_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skyline_is_linear_between_its_stations() {
        let skyline = Skyline { stations: [(-10.0, 2.0), (0.0, 4.0), (10.0, f64::NEG_INFINITY)] };
        for (ahead_m, least_m) in [(-12.0, 2.0), (-10.0, 2.0), (-5.0, 3.0), (0.0, 4.0)] {
            assert!(skyline.passes(ahead_m, least_m + 0.01) && !skyline.passes(ahead_m, least_m - 0.01));
        }
        assert!(skyline.passes(1.0, -50.0) && skyline.passes(10.0, -50.0) && skyline.passes(20.0, -50.0));
    }
}
