//! Strong facets that turn away from an antenna, or towards it, between nodes: at which pulse they do.
//!
//! The echo of a facet ends where the cosine of its local angle passes zero. Between nodes the cosine is
//! interpolated, so that this may come a pulse early or late, and then the facet's whole echo is wrong in
//! that pulse. Mostly it drowns among the others. Near grazing a few facets return most of the echo, and one
//! of them may break the error that was asked for. Where a facet has more than a share of the power of all,
//! and its cosine is nearer to zero than the interpolation can tell,
//!
//! `|c| < w h |s (s - 1) (s - 2) (s - 3)| / 4!  sqrt(d_3^2 + (w h d_2)^2)`,
//!
//! the slope of the surface is evaluated at that pulse. That is what a cubic through the nodes leaves of a
//! wave of frequency `w`: `h` is the time from node to node, `s` the time over `h`, `d_2` and `d_3` are
//! differences of the cosine at the nodes, and `w` is the frequency of the shortest waves of the grid,
//! `w^2 = g sqrt(2) pi / facet`. Two differences, for where one of a wave passes zero the other is largest.

use std::f64::consts::{PI, SQRT_2};
use std::ops::Range;

use super::instants::{NODES, through};
use super::slow_time::SlowTime;
use super::surface::NodeSurface;
use super::tile::{Bounds, Pair};
use super::timing::Timing;
use crate::cpu::Variant;
use crate::geometry::lanes::{LANES, Row};
use crate::scene::Patch;
use crate::sea::GRAVITY_MPS2;
use crate::sea::surface::Fields;

/// What rounding may leave of a cosine.
const ROUNDING: f32 = 1e-6;
/// How near to zero a cosine must be at a node to pass it beside, over the largest step between nodes: twice
/// what a wave of 0.63 rad from node to node can bend.
const BESIDE: f32 = 0.25;

/// Finds when facets turn; one per thread.
#[derive(Clone, Default)]
pub(super) struct Turning {
    /// Power above which a facet counts, over that of all; `None`: none does.
    pub least: Option<f64>,
    /// The same of every pair of the block at hand, W.
    pub least_w: Vec<f32>,
    /// Facets of the tile and pair at hand that may be in doubt.
    doubtful: Vec<Doubtful>,
    /// The surface at a pulse, made when first asked for.
    surface: Option<(f64, Box<Fields<f32>>)>,
}

/// A strong facet that may turn within the block.
#[derive(Clone)]
struct Doubtful {
    lane: usize,
    /// Of the cosines to both antennas: the difference of the highest order that the nodes have, and the
    /// largest of the order below.
    differences: [[f32; 2]; 2],
    /// Pulses between nodes about which it may pass zero.
    pulses: Range<usize>,
    /// Factor at the pulse at hand, were it not turned away.
    factor: f32,
}

/// The tile and pair at hand.
pub(super) struct Turned<'a> {
    pub pair: &'a Pair,
    /// Of the pair.
    pub number: usize,
    pub timing: &'a Timing,
    pub count: usize,
    /// Mean time from pulse to pulse, s.
    pub interval_s: f64,
    /// At every node.
    pub slopes: &'a [[Row; 2]; NODES],
}

impl Turned<'_> {
    /// By how much the shortest waves of a patch turn from node to node, rad.
    fn turn_rad(&self, patch: &Patch) -> f32 {
        let instants = &self.timing.instants;
        let steps = instants.node_count.saturating_sub(1).max(1) as f64;
        let step_s = instants.pulses.saturating_sub(1) as f64 * self.interval_s / steps;
        (step_s * (GRAVITY_MPS2 * SQRT_2 * PI / patch.facet_m).sqrt()) as f32
    }

    /// Cosine of a facet to an antenna, but for the length of the normal, at directions and slopes that are
    /// sums over the nodes.
    fn cosine(&self, end: usize, lane: usize, weights: &[f32; NODES], slope: Option<[f32; 2]>) -> f32 {
        let (mut k, mut mean) = ([0.0f32; 3], [0.0f32; 2]);
        for ((node, slopes), weight) in self.pair.nodes().iter().zip(self.slopes).zip(weights) {
            let of = if end == 0 { &node.paths.incident } else { &node.paths.scattered };
            k.iter_mut().zip(of).for_each(|(k, row)| *k += weight * row[lane]);
            mean.iter_mut().zip(slopes).for_each(|(slope, row)| *slope += weight * row[lane]);
        }
        let [sx, sy] = slope.unwrap_or(mean);
        let sign = if end == 0 { -1.0 } else { 1.0 };
        sign * (k[2] - k[0] * sx - k[1] * sy)
    }
}

impl Turning {
    /// Sets the power above which a facet counts, of the mean power of a facet of a patch of so many over
    /// every pair, W. A pair of which the sample has nothing has none that count.
    pub fn set_least(&mut self, mean_w: impl Iterator<Item = f64>, facets: usize) {
        let Self { least, least_w, .. } = self;
        least_w.clear();
        let share = least.map_or(f64::INFINITY, |least| least * facets as f64);
        least_w
            .extend(mean_w.map(|mean_w| if mean_w > 0.0 { (share * mean_w) as f32 } else { f32::INFINITY }));
    }

    /// Finds the facets of a tile and pair that may be in doubt at some pulse.
    pub fn find(&mut self, of: &Turned<'_>, variant: Variant) {
        let Self { least_w, doubtful, .. } = self;
        doubtful.clear();
        let least_w = least_w.get(of.number).copied().unwrap_or(f32::INFINITY);
        let nodes = of.pair.nodes().len();
        if !least_w.is_finite() || nodes < 2 {
            return;
        }
        let places = &of.timing.instants.nodes[..of.timing.instants.node_count];
        let mut bound = [0.0f32; LANES];
        variant.run(Bounds(of.pair, of.count, &mut bound));
        for lane in (0..of.count).filter(|lane| bound[*lane] > least_w) {
            let at = |end: usize, node: usize| {
                let mut weights = [0.0; NODES];
                weights[node] = 1.0;
                of.cosine(end, lane, &weights, None)
            };
            let mut pulses = usize::MAX..0;
            let differences = [0, 1].map(|end| {
                let mut c: [f32; NODES] = std::array::from_fn(|n| if n < nodes { at(end, n) } else { 0.0 });
                let steps = c.windows(2).take(nodes - 1);
                let most = steps.clone().map(|two| (two[1] - two[0]).abs()).fold(0.0, f32::max);
                for (two, ends) in steps.zip(places.windows(2)) {
                    let passes = (two[0] > 0.0) != (two[1] > 0.0);
                    if passes || two[0].abs().min(two[1].abs()) < BESIDE * most + ROUNDING {
                        pulses = pulses.start.min(ends[0])..pulses.end.max(ends[1] + 1);
                    }
                }
                let mut below = 0.0f32;
                for order in 1..nodes {
                    below = c[..=nodes - order].iter().fold(0.0, |most, own| most.max(own.abs()));
                    (0..nodes - order).for_each(|n| c[n] = c[n + 1] - c[n]);
                }
                [c[0].abs(), below]
            });
            if !pulses.is_empty() {
                doubtful.push(Doubtful { lane, differences, pulses, factor: 0.0 });
            }
        }
    }

    /// Whether there is none.
    pub fn is_certain(&self) -> bool {
        self.doubtful.is_empty()
    }

    /// Keeps the factors of a pulse before any facet is turned away.
    pub fn keep(&mut self, factor: &Row) {
        self.doubtful.iter_mut().for_each(|own| own.factor = factor[own.lane]);
    }

    /// Sets the factors of those that are in doubt at a pulse of the block, by the surface at its time.
    pub fn decide(
        &mut self,
        (of, pulse, slow): (&Turned<'_>, usize, &SlowTime),
        (surface, elapsed_s, patch): (&mut NodeSurface, f64, &Patch),
        place: impl Fn(usize) -> ([i64; 2], [f32; 2]),
        out: &mut Row,
    ) {
        let instants = &of.timing.instants;
        let least_w = self.least_w[of.number];
        let Self { doubtful, surface: known, .. } = self;
        let places = &instants.nodes[..instants.node_count];
        let (left, turn_rad) = (left_at(places, pulse, slow), of.turn_rad(patch));
        let (epochs, of_epochs) = (&instants.epochs[..instants.epoch_count], of.pair.epochs());
        let after = epochs.partition_point(|epoch| *epoch <= pulse).clamp(1, epochs.len().max(2) - 1);
        let power = |lane: usize| {
            let about = of_epochs.iter().take(after + 1).skip(after - 1);
            about.fold(0.0f32, |most, epoch| most.max(epoch.power[lane]))
        };
        let mut weights = None;
        let there = doubtful.iter().filter(|own| own.pulses.contains(&pulse) && own.factor != 0.0);
        for own in there.filter(|own| power(own.lane) * own.factor * own.factor > least_w) {
            let weights = weights.get_or_insert_with(|| through(places, pulse, slow));
            let cosine = |end: usize, slope| of.cosine(end, own.lane, weights, slope);
            let doubts = [0, 1].map(|end| {
                let [highest, below] = own.differences[end];
                let most = left * turn_rad * highest.hypot(turn_rad * below);
                cosine(end, None).abs() < most + ROUNDING
            });
            if doubts == [false; 2] {
                continue;
            }
            let (at_s, fields) = known.get_or_insert_with(|| (f64::NAN, Box::new(surface.fields(patch))));
            if *at_s != elapsed_s {
                *at_s = f64::NAN;
                // Its nodes were found: so is this.
                if surface.evaluate(elapsed_s, patch, fields).is_err() {
                    continue;
                }
                *at_s = elapsed_s;
            }
            let (key, fall) = place(own.lane);
            let index = patch.nearest_index(key);
            let slope = [0, 1].map(|axis| fields.slope[axis][index] - fall[axis]);
            let faces = [0, 1].map(|end| cosine(end, Some(slope)) > 0.0);
            out[own.lane] = if faces == [true; 2] { own.factor } else { 0.0 };
        }
    }

    /// The block is done: nothing is decided before the next, which may be of another patch.
    pub fn rest(&mut self) {
        self.least_w.clear();
        if let Some((at_s, _)) = &mut self.surface {
            *at_s = f64::NAN;
        }
    }
}

/// What a polynomial through nodes leaves at a pulse, over the next difference that it does not know.
fn left_at(places: &[usize], pulse: usize, slow: &SlowTime) -> f32 {
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return 0.0 };
    let step = (slow.at(*last) - slow.at(*first)) / (places.len() - 1).max(1) as f64;
    let of = |(n, place): (usize, &usize)| (slow.at(pulse) - slow.at(*place)) / (step * (n + 1) as f64);
    places.iter().enumerate().map(of).product::<f64>().abs() as f32
}
