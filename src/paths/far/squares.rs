//! Squares of the sea: where the cells of the far sea are.
//!
//! A square is halved until it is a **lot**: no larger than [`LOT_CELLS`] cells about its middle. A lot is
//! halved evenly until its cells are no larger than is wanted there. Cells are found and kept by lots,
//! whether or not a beam sees all of one.

use std::f64::consts::PI;

use glam::DVec3;
use rand::RngExt;
use rand_distr::StandardNormal;

use super::{FASTEST_MPS, FarPlan, SLOT_S};
use crate::frames::{Earth, Enu, Point};
use crate::geometry::horizon;
use crate::paths::facets::Reception;
use crate::paths::{PairPlan, PathGenerator};
use crate::rng::{Room, stream};
use crate::scattering::two_scale::TILTS;
use crate::scene::Patch;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Half the side of the sea that is split, m, and how often it is: squares of a metre.
const HALF_M: f64 = 1_048_576.0;
const DEEPEST: u32 = 42;
/// What waves raise a cell, what it moves in half its life, and what antennas turn while light crosses a
/// square, m.
const MARGIN_M: f64 = 20.0 + FASTEST_MPS * SLOT_S;
/// Widest beam by which squares are found, rad.
const WIDEST_RAD: f64 = 0.5;
/// Least horizontal part of the gradient of the way: under an antenna cells of range are wide.
const LEAST_GRADIENT: f64 = 0.1;

/// Cells of a lot, at most, nearly.
pub(super) const LOT_CELLS: u32 = 256;
/// Random processes of a cell, at most.
const MECHANISMS: usize = 1 + TILTS;

/// A rectangle of the sea that is split: level and numbers along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Square {
    level: u32,
    at: [u32; 2],
}

/// A cell: where it is when its life is half over, its area, and its random numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub place_m: [f64; 2],
    pub area_m2: f64,
    /// Phases of its mechanisms, from -1/2 to 1/2 turns.
    pub turns: [f32; MECHANISMS],
    /// Which mechanism and which line it stands for, of 0 to 1, and where in the line, in deviations.
    pub mechanism: f64,
    pub line: f64,
    pub off: f64,
    /// Of its own waves, where it has such.
    pub waves: u64,
}

impl Square {
    pub const ALL: Self = Self { level: 0, at: [0; 2] };

    fn sides_m(self) -> [f64; 2] {
        [self.level.div_ceil(2), self.level / 2].map(|halved| 2.0 * HALF_M / f64::from(1u32 << halved))
    }

    fn low_m(self) -> [f64; 2] {
        let sides_m = self.sides_m();
        [0, 1].map(|i| f64::from(self.at[i]) * sides_m[i] - HALF_M)
    }

    pub fn middle_m(self) -> [f64; 2] {
        let (low_m, sides_m) = (self.low_m(), self.sides_m());
        [0, 1].map(|i| low_m[i] + 0.5 * sides_m[i])
    }

    fn half(self, upper: u32) -> Self {
        let mut at = self.at;
        let axis = (self.level % 2) as usize;
        at[axis] = 2 * at[axis] + upper;
        Self { level: self.level + 1, at }
    }
}

/// How the sea is split in a slot: it follows from the slot alone.
#[derive(Clone, Copy)]
pub(super) struct Split<'a> {
    pub plan: &'a FarPlan,
    pub of: &'a PathGenerator,
    /// Where antennas were when the slot began.
    pub places: &'a [Point<Enu>],
    pub coarser: f64,
    pub slot: i64,
}

/// What is looked for at a pulse, or at some.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub split: Split<'a>,
    pub reception: &'a Reception<'a>,
    /// The patch of the pulse, on which facets are the sea.
    pub patch: &'a Patch,
    /// What antennas, windows and cells move, and what antennas turn about the pulse, m and rad: 0 for that
    /// pulse alone.
    pub about: [f64; 2],
}

/// Whether a place lies on a patch.
pub(super) fn is_on(patch: &Patch, place_m: [f64; 2]) -> bool {
    (0..2).all(|i| {
        let at = place_m[i] / patch.facet_m - patch.first[i] as f64;
        (0.0..patch.facets[i] as f64).contains(&at)
    })
}

/// A place of the mean surface.
pub(super) fn surface(earth: Earth, [x, y]: [f64; 2]) -> Point<Enu> {
    Point::new(x, y, -earth.drop_m(x, y))
}

impl Split<'_> {
    fn surface(&self, place_m: [f64; 2]) -> Point<Enu> {
        surface(self.of.frame.earth(), place_m)
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

    /// How often a square is halved for cells of the area that is wanted about its middle, but for a root of
    /// two.
    fn halvings(&self, square: Square, middle: Point<Enu>) -> u32 {
        let [x_m, y_m] = square.sides_m();
        let larger = x_m * y_m / (std::f64::consts::SQRT_2 * self.wanted_m2(middle));
        // A number that is none, too.
        (larger.log2().ceil().max(0.0) as u32).min(DEEPEST - square.level)
    }

    fn middle(&self, square: Square) -> Point<Enu> {
        self.surface(square.middle_m())
    }

    /// Cells of a lot.
    pub fn count(&self, lot: Square) -> usize {
        1 << self.halvings(lot, self.middle(lot))
    }

    /// Hands over all cells of a lot; `false` once no more are wanted.
    pub fn cells(&self, lot: Square, each: &mut impl FnMut(Found) -> bool) -> bool {
        let halvings = self.halvings(lot, self.middle(lot));
        let (low_m, sides_m) = (lot.low_m(), lot.sides_m());
        let first = (lot.level % 2) as usize;
        let mut counts = [halvings / 2; 2];
        counts[first] = halvings.div_ceil(2);
        let counts = counts.map(|halved| 1u64 << halved);
        let sides_m = [0, 1].map(|i| sides_m[i] / counts[i] as f64);
        let [x, y] = lot.at.map(u64::from);
        let part = (self.slot as u64) << 8 | u64::from(lot.level);
        let mut rng = stream(self.plan.seed, Room::FarCell, x << 32 | y, part);
        for n in 0..counts[0] * counts[1] {
            let at = [n % counts[0], n / counts[0]];
            let place_m = [0, 1].map(|i| low_m[i] + sides_m[i] * (at[i] as f64 + rng.random::<f64>()));
            let mut turns = [0.0; MECHANISMS];
            turns.fill_with(|| rng.random::<f32>() - 0.5);
            let [mechanism, line] = [(); 2].map(|()| rng.random::<f64>());
            let off = rng.sample(StandardNormal);
            let (area_m2, waves) = (sides_m[0] * sides_m[1], rng.random());
            if !each(Found { place_m, area_m2, turns, mechanism, line, off, waves }) {
                return false;
            }
        }
        true
    }
}

impl Search<'_> {
    /// Hands over the lots of a square that may be seen; `false` once no more are wanted.
    pub fn lots(&self, square: Square, each: &mut impl FnMut(Square) -> bool) -> bool {
        let middle = self.split.middle(square);
        let [x_m, y_m] = square.sides_m();
        let radius_m = 0.5 * x_m.hypot(y_m);
        // The surface curves within a large square.
        let bulge_m = self.split.of.frame.earth().drop_m(radius_m, 0.0);
        if !self.is_seen(middle, radius_m + bulge_m + MARGIN_M) {
            return true;
        }
        if self.split.halvings(square, middle) > LOT_CELLS.ilog2() {
            return (0..2).all(|upper| self.lots(square.half(upper), each));
        }
        each(square)
    }

    /// Hands over the cells that are seen, as if the sea were level; `false` once no more are wanted.
    pub fn seen_cells(&self, each: &mut impl FnMut(Found) -> bool) -> bool {
        self.lots(Square::ALL, &mut |lot| {
            self.split.cells(lot, &mut |found| {
                let place = self.split.surface(found.place_m);
                is_on(self.patch, found.place_m) || !self.is_seen(place, 0.0) || each(found)
            })
        })
    }

    /// Whether any pair sees a circle about a place.
    fn is_seen(&self, place: Point<Enu>, radius_m: f64) -> bool {
        self.split.of.plans.iter().any(|plan| self.is_seen_by(plan, place, radius_m))
    }

    /// Whether a pair sees a circle about a place.
    pub fn is_seen_by(&self, plan: &PairPlan, place: Point<Enu>, radius_m: f64) -> bool {
        let (of, radius_m) = (self.split.of, radius_m + self.about[0]);
        let (emission, offset_s) = (self.reception.emission, self.reception.offset_s);
        let earth = of.frame.hiding_earth();
        let ends = plan.ends(of.radar.transmitters.len());
        let centres = ends.map(|end| emission.centres[end].position);
        let ways = centres.map(|centre| place.raw() - centre.raw());
        let lengths_m = ways.map(|way| way.length());
        let delay_s = (lengths_m[0] + lengths_m[1]) / SPEED_OF_LIGHT_MPS;
        let slack_s = 2.0 * radius_m / SPEED_OF_LIGHT_MPS;
        let (begin_s, window) = (offset_s + delay_s, self.reception.window(plan));
        window.touches_within(begin_s, slack_s)
            && (0..2).all(|n| {
                let height_m = horizon::height_m(earth, centres[n]);
                let farthest_m = horizon::distance_m(earth, [height_m, horizon::POINT_EDGE_M]);
                // A transmitter stays as it is at the emission.
                let after_s = if n == 0 { 0.0 } else { delay_s };
                horizon::apart_m(centres[n], place) <= farthest_m + radius_m
                    && self.in_lobe(ends[n], ways[n], after_s, radius_m)
            })
    }

    /// Whether a circle about a place lies in the main lobe of an antenna.
    fn in_lobe(&self, end: usize, way: DVec3, after_s: f64, radius_m: f64) -> bool {
        let axes = self.reception.emission.axes_after(end, after_s, self.reception.axes_span_s);
        let length_m = way.length();
        let slack_rad = if length_m > radius_m { (radius_m / length_m).asin() } else { PI };
        self.split.plan.lobes[end].holds(axes.transpose() * way, slack_rad + self.about[1])
    }
}
