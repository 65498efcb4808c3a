//! Squares of the sea: where the cells of the far sea are.

use std::f64::consts::PI;

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::FarPlan;
use crate::frames::{Enu, Point};
use crate::geometry::horizon;
use crate::paths::PathGenerator;
use crate::paths::facets::Reception;
use crate::rng::{Room, stream};
use crate::scene::Patch;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Half the side of the sea that is split, m, and how often it is: squares of a metre.
const HALF_M: f64 = 1_048_576.0;
const DEEPEST: u32 = 42;
/// What waves raise a cell, and what antennas turn while light crosses a square, m.
const MARGIN_M: f64 = 20.0;
/// Widest beam by which squares are found, rad.
const WIDEST_RAD: f64 = 0.5;
/// Least horizontal part of the gradient of the way: under an antenna cells of range are wide.
const LEAST_GRADIENT: f64 = 0.1;

/// A rectangle of the sea that is split: level and numbers along x and y.
#[derive(Clone, Copy)]
pub(super) struct Square {
    level: u32,
    at: [u32; 2],
}

/// A cell that an antenna may see: its random numbers, where it is when its life is half over, and its area.
pub(super) struct Found {
    pub rng: ChaCha8Rng,
    pub place_m: [f64; 2],
    pub area_m2: f64,
}

impl Square {
    pub const ALL: Self = Self { level: 0, at: [0; 2] };

    fn sides_m(self) -> [f64; 2] {
        [self.level.div_ceil(2), self.level / 2].map(|halved| 2.0 * HALF_M / f64::from(1u32 << halved))
    }

    fn half(self, upper: u32) -> Self {
        let mut at = self.at;
        let axis = (self.level % 2) as usize;
        at[axis] = 2 * at[axis] + upper;
        Self { level: self.level + 1, at }
    }
}

/// What is looked for in a slot at a pulse.
pub(super) struct Search<'a> {
    pub plan: &'a FarPlan,
    pub of: &'a PathGenerator,
    pub reception: &'a Reception<'a>,
    /// Where antennas were when the slot began.
    pub places: &'a [Point<Enu>],
    pub coarser: f64,
    pub slot: i64,
    /// The patch of the pulse, on which facets are the sea.
    pub patch: &'a Patch,
    /// What antennas move and turn about the pulse, m and rad: 0 for that pulse alone.
    pub about: [f64; 2],
}

/// Whether a place lies on a patch.
fn is_on(patch: &Patch, place_m: [f64; 2]) -> bool {
    (0..2).all(|i| {
        let at = place_m[i] / patch.facet_m - patch.first[i] as f64;
        (0.0..patch.facets[i] as f64).contains(&at)
    })
}

impl Search<'_> {
    /// A place of the mean surface.
    fn surface(&self, [x, y]: [f64; 2]) -> Point<Enu> {
        Point::new(x, y, -self.of.frame.earth().drop_m(x, y))
    }

    /// Area of the cell about a place, m^2: a range cell by the narrower beam, by the number of cells.
    fn wanted_m2(&self, place: Point<Enu>) -> f64 {
        let transmitters = self.of.radar.transmitters.len();
        let least = self.of.pairs.iter().map(|pair| {
            let ends = [pair.transmitter, transmitters + pair.receiver];
            let ways = ends.map(|end| place.raw() - self.places[end].raw());
            let width_m =
                (0..2).map(|n| self.plan.lobes[ends[n]].width_rad().min(WIDEST_RAD) * ways[n].length());
            let gradient = (ways[0].normalize_or_zero() + ways[1].normalize_or_zero()).truncate().length();
            let range_m = 2.0 * self.plan.range_cell_m / gradient.max(LEAST_GRADIENT);
            range_m * width_m.fold(f64::INFINITY, f64::min)
        });
        // Of both slots that overlap.
        2.0 / self.plan.cells * self.coarser * least.fold(f64::INFINITY, f64::min)
    }

    /// Whether any pair sees a circle about a place of the surface.
    fn is_seen(&self, place: Point<Enu>, radius_m: f64) -> bool {
        let radius_m = radius_m + self.about[0];
        let (emission, offset_s) = (self.reception.emission, self.reception.offset_s);
        let earth = self.of.frame.hiding_earth();
        self.of.plans.iter().any(|plan| {
            let ends = [plan.pair.transmitter, self.of.radar.transmitters.len() + plan.pair.receiver];
            let centres = ends.map(|end| emission.centres[end].position);
            let ways = centres.map(|centre| place.raw() - centre.raw());
            let lengths_m = ways.map(|way| way.length());
            let delay_s = (lengths_m[0] + lengths_m[1]) / SPEED_OF_LIGHT_MPS;
            let slack_s = 2.0 * radius_m / SPEED_OF_LIGHT_MPS;
            let (begin_s, window) = (offset_s + delay_s, self.reception.window(plan));
            let touches = begin_s - slack_s <= window.close_s + window.guard_s
                && begin_s + slack_s + window.pulse_s >= window.open_s - window.guard_s;
            touches
                && (0..2).all(|n| {
                    let height_m = horizon::height_m(earth, centres[n]);
                    let farthest_m = horizon::distance_m(earth, [height_m, horizon::POINT_EDGE_M]);
                    horizon::apart_m(centres[n], place) <= farthest_m + radius_m
                        && self.in_lobe(ends[n], ways[n], delay_s, radius_m)
                })
        })
    }

    /// Whether a circle about a place lies in the main lobe of an antenna.
    fn in_lobe(&self, end: usize, way: DVec3, delay_s: f64, radius_m: f64) -> bool {
        let axes = self.reception.emission.axes_after(end, delay_s, self.reception.axes_span_s);
        let length_m = way.length();
        let slack_rad = if length_m > radius_m { (radius_m / length_m).asin() } else { PI };
        self.plan.lobes[end].holds(axes.transpose() * way, slack_rad + self.about[1])
    }

    /// Hands over the cells of a square that may be seen; `false` once no more are wanted.
    pub fn visit(&self, square: Square, each: &mut impl FnMut(Found) -> bool) -> bool {
        let sides_m = square.sides_m();
        let low = [0, 1].map(|i| f64::from(square.at[i]) * sides_m[i] - HALF_M);
        let middle = self.surface([0, 1].map(|i| low[i] + 0.5 * sides_m[i]));
        let radius_m = 0.5 * sides_m[0].hypot(sides_m[1]);
        // The surface curves within a large square.
        let bulge_m = self.of.frame.earth().drop_m(radius_m, 0.0);
        if !self.is_seen(middle, radius_m + bulge_m + MARGIN_M) {
            return true;
        }
        let area_m2 = sides_m[0] * sides_m[1];
        if square.level < DEEPEST && area_m2 > std::f64::consts::SQRT_2 * self.wanted_m2(middle) {
            return (0..2).all(|upper| self.visit(square.half(upper), each));
        }
        let [x, y] = square.at.map(u64::from);
        let part = (self.slot as u64) << 8 | u64::from(square.level);
        let mut rng = stream(self.plan.seed, Room::FarCell, x << 32 | y, part);
        let place_m = [0, 1].map(|i| low[i] + sides_m[i] * rng.random::<f64>());
        if is_on(self.patch, place_m) || !self.is_seen(self.surface(place_m), 0.0) {
            return true;
        }
        each(Found { rng, place_m, area_m2 })
    }
}
