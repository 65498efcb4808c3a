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
//! its slope is found more closely: by a polynomial through the surface at the nodes and halfway between
//! them, which leaves some `(w h / 2)^7 / 50` of a wave. The above is what a cubic through the nodes leaves
//! of a wave of frequency `w`: `h` is the time from node to node, `s` the time over `h`, `d_2` and `d_3` are
//! differences of the cosine at the nodes, and `w` is the frequency of the shortest waves of the grid,
//! `w^2 = g sqrt(2) pi / facet`. Two differences, for where one of a wave passes zero the other is largest.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::{PI, SQRT_2};

use super::NodeWork;
use super::instants::{NODES, through};
use super::slow_time::SlowTime;
use super::surface::{NodeSurface, Slopes};
use super::tile::{Bounds, Epoch, Node, Pair};
use super::timing::Timing;
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{LANES, Row, lanes_for};
use crate::scene::Patch;
use crate::sea::GRAVITY_MPS2;
use crate::sea::wake::WakeError;

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
    /// Of the tile and pair at hand.
    bends: Box<Bends>,
    /// Whether some facet of it may turn.
    turns: bool,
    /// Facets in doubt at the pulse at hand, and their factors were they not turned away.
    doubtful: Vec<(usize, f32)>,
    /// The surface between the nodes of the block, found when first asked for.
    between: Option<Between>,
}

/// The surface halfway between nodes.
#[derive(Clone)]
struct Between {
    /// Whether it is that of the block at hand.
    is_found: bool,
    slopes: [Slopes; NODES - 1],
    /// The pulse that was asked for last, and what the surface at it has of that at the nodes and halfway.
    pulse: Option<usize>,
    weights: [[f32; NODES]; 2],
}

/// What a polynomial through the nodes may leave of cosines from a node to the next, over what of it is left
/// at a pulse ([`left_at`](super::instants::left_at));
/// negative where a facet does not count or does not pass zero. `[end][node]`.
#[derive(Clone)]
struct Bends([[Row; NODES]; 2]);

impl Default for Bends {
    fn default() -> Self {
        Self([[[0.0; LANES]; NODES]; 2])
    }
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

    /// Cosine of a facet of some slope to an antenna, along a direction that is a sum over the nodes.
    fn cosine(&self, end: usize, lane: usize, weights: &[f32; NODES], slope: [f32; 2]) -> f32 {
        let mut k = [0.0f32; 3];
        for (node, weight) in self.pair.nodes().iter().zip(weights) {
            let (of, _) = direction(node, end);
            k.iter_mut().zip(of).for_each(|(k, row)| *k += weight * row[lane]);
        }
        let sign = if end == 0 { -1.0 } else { 1.0 };
        sign * (k[2] - k[0] * slope[0] - k[1] * slope[1])
    }

    /// Power of a facet about a pulse, but for its factor, W.
    fn power_w(&self, lane: usize, pulse: usize) -> f32 {
        let instants = &self.timing.instants;
        let epochs = &instants.epochs[..instants.epoch_count];
        let after = epochs.partition_point(|epoch| *epoch <= pulse).clamp(1, epochs.len().max(2) - 1);
        let about = self.pair.epochs().iter().take(after + 1).skip(after - 1);
        about.fold(0.0f32, |most, epoch| most.max(epoch.power[lane]))
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

    /// Finds whether facets of a tile and pair may be in doubt at some pulse.
    pub fn find(&mut self, of: &Turned<'_>, patch: &Patch, variant: Variant) {
        let Self { least_w, bends, turns, .. } = self;
        let least_w = least_w.get(of.number).copied().unwrap_or(f32::INFINITY);
        *turns = false;
        if !least_w.is_finite() || of.pair.nodes().len() < 2 {
            return;
        }
        let mut bound_w = [0.0f32; LANES];
        variant.run(Bounds(of.pair, of.count, &mut bound_w));
        if bound_w[..of.count].iter().all(|bound_w| *bound_w <= least_w) {
            return;
        }
        let (nodes, slopes, count, turn_rad) = (of.pair.nodes(), of.slopes, of.count, of.turn_rad(patch));
        *turns = variant.run(Bend { nodes, slopes, count, turn_rad, bound_w: &bound_w, least_w, bends });
    }

    /// Leaves facets out that are turned away at a pulse of the block, and finds those that are in doubt.
    pub fn turn(&mut self, of: &Turned<'_>, pulse: usize, variant: Variant, factor: &mut Row) {
        self.doubtful.clear();
        let (start, weights) = &of.timing.cosines[pulse];
        let (count, epochs) = (of.count, &of.pair.epochs()[*start..]);
        if !self.turns {
            variant.run(Turn { count, epochs, weights, doubt: None, factor });
            return;
        }
        let (before, mut near) = (*factor, [0.0; LANES]);
        let (node, left) = of.timing.left[pulse];
        let doubt = Some((self.bends.0.each_ref().map(|of_end| &of_end[node]), left, &mut near));
        if variant.run(Turn { count, epochs, weights, doubt, factor }) {
            let least_w = self.least_w[of.number];
            let there = (0..count).filter(|lane| near[*lane] > 0.0);
            let counts = |lane: &usize| of.power_w(*lane, pulse) * before[*lane].powi(2) > least_w;
            self.doubtful.extend(there.filter(counts).map(|lane| (lane, before[lane])));
        }
    }

    /// Whether some are.
    pub fn is_in_doubt(&self) -> bool {
        !self.doubtful.is_empty()
    }

    /// Sets the factors of those that are in doubt at a pulse, by the surface at its time.
    pub fn decide(
        &mut self,
        (of, pulse, slow): (&Turned<'_>, usize, &SlowTime),
        elapsed_s: f64,
        (surface, nodes, patch): (&mut NodeSurface, &[NodeWork], &Patch),
        place: impl Fn(usize) -> ([i64; 2], [f32; 2]),
        out: &mut Row,
    ) {
        let Self { doubtful, between, .. } = self;
        let between = between.get_or_insert_with(|| Between::room(surface, patch));
        // The nodes were found: so is this.
        if between.find(surface, nodes, patch).is_err() {
            return;
        }
        between.weigh(pulse, elapsed_s, nodes);
        let instants = &of.timing.instants;
        let weights = through(&instants.nodes[..instants.node_count], pulse, slow);
        for &(lane, factor) in &*doubtful {
            let (key, fall) = place(lane);
            let [sx, sy] = between.slope(nodes, patch.nearest_index(key));
            let slope = [sx - fall[0], sy - fall[1]];
            let faces = [0, 1].map(|end| of.cosine(end, lane, &weights, slope) > 0.0);
            out[lane] = if faces == [true; 2] { factor } else { 0.0 };
        }
    }

    /// The block is done: nothing is decided before the next, which may be of another patch.
    pub fn rest(&mut self) {
        self.least_w.clear();
        if let Some(between) = &mut self.between {
            (between.is_found, between.pulse) = (false, None);
        }
    }
}

impl Between {
    fn room(surface: &NodeSurface, patch: &Patch) -> Self {
        let slopes = std::array::from_fn(|_| surface.slopes(patch));
        Self { is_found: false, slopes, pulse: None, weights: [[0.0; NODES]; 2] }
    }

    /// Finds the surface halfway between the nodes of a block.
    fn find(
        &mut self,
        surface: &mut NodeSurface,
        nodes: &[NodeWork],
        patch: &Patch,
    ) -> Result<(), WakeError> {
        if !self.is_found {
            for (two, slopes) in nodes.windows(2).zip(&mut self.slopes) {
                surface.evaluate_slopes(halfway_s(two), patch, slopes)?;
            }
            self.is_found = true;
        }
        Ok(())
    }

    /// Weights at a pulse of the polynomial through the nodes and halfway between them.
    fn weigh(&mut self, pulse: usize, elapsed_s: f64, nodes: &[NodeWork]) {
        if self.pulse == Some(pulse) {
            return;
        }
        self.pulse = Some(pulse);
        let mut times_s = [[f64::NAN; NODES]; 2];
        times_s[0].iter_mut().zip(nodes).for_each(|(at_s, node)| *at_s = node.elapsed_s);
        times_s[1].iter_mut().zip(nodes.windows(2)).for_each(|(at_s, two)| *at_s = halfway_s(two));
        let times_s = times_s.as_flattened();
        for (n, weight) in self.weights.as_flattened_mut().iter_mut().enumerate() {
            let others = times_s.iter().enumerate().filter(|(m, at_s)| *m != n && !at_s.is_nan());
            let product = others.map(|(_, at_s)| (elapsed_s - at_s) / (times_s[n] - at_s)).product::<f64>();
            *weight = product as f32;
        }
    }

    /// Slope of a facet at the pulse weighed last, by its place in the patch.
    fn slope(&self, nodes: &[NodeWork], index: usize) -> [f32; 2] {
        let [at_nodes, halfway] = &self.weights;
        let halfway = self.slopes.iter().zip(halfway).take(nodes.len().saturating_sub(1));
        let of_nodes = nodes.iter().zip(at_nodes);
        let of_nodes =
            of_nodes.map(|(node, weight)| (node.fields.slope.each_ref().map(|own| own[index]), weight));
        let all = of_nodes.chain(halfway.map(|(slopes, weight)| (slopes.of(index), weight)));
        all.fold([0.0; 2], |[sx, sy], ([x, y], weight)| [sx + weight * x, sy + weight * y])
    }
}

/// The time halfway between two nodes, s.
fn halfway_s(two: &[NodeWork]) -> f64 {
    0.5 * (two[0].elapsed_s + two[1].elapsed_s)
}

/// Directions to an antenna of a pair at a node, and the sign of a cosine along them.
#[inline(always)]
fn direction(node: &Node, end: usize) -> (&[Row; 3], f32) {
    if end == 0 { (&node.paths.incident, -1.0) } else { (&node.paths.scattered, 1.0) }
}

/// How much cosines may bend between nodes; whether any facet that counts passes zero.
struct Bend<'a> {
    nodes: &'a [Node],
    slopes: &'a [[Row; 2]; NODES],
    count: usize,
    turn_rad: f32,
    /// Bound on the power of each facet, and that above which it counts, W.
    bound_w: &'a Row,
    least_w: f32,
    bends: &'a mut Bends,
}

impl Task for Bend<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { nodes, slopes, count, turn_rad, bound_w, least_w, bends } = self;
        let n = lanes_for(count);
        let mut passes = [0.0f32; LANES];
        for end in 0..2 {
            let mut cosines = [[0.0f32; LANES]; NODES];
            for ((node, slope), cosine) in nodes.iter().zip(slopes).zip(&mut cosines) {
                let (k, sign) = direction(node, end);
                for i in 0..n {
                    cosine[i] = sign * (k[2][i] - k[0][i] * slope[0][i] - k[1][i] * slope[1][i]);
                }
            }
            let mut step = [0.0f32; LANES];
            for two in cosines[..nodes.len()].windows(2) {
                for i in 0..n {
                    step[i] = largest(step[i], two[1][i] - two[0][i]);
                }
            }
            let mut bend = [0.0f32; LANES];
            let [a, b, c, d] = &cosines;
            for i in 0..n {
                // The difference of the highest order, and the largest of the order below.
                let (highest, below) = match nodes.len() {
                    2 => (b[i] - a[i], largest(a[i], b[i])),
                    3 => (c[i] - 2.0 * b[i] + a[i], largest(b[i] - a[i], c[i] - b[i])),
                    _ => {
                        let (first, second) = (c[i] - 2.0 * b[i] + a[i], d[i] - 2.0 * c[i] + b[i]);
                        (second - first, largest(first, second))
                    }
                };
                let below = turn_rad * below;
                bend[i] = turn_rad * (highest * highest + below * below).sqrt();
            }
            for node in 0..nodes.len() - 1 {
                let (from, to, out) = (&cosines[node], &cosines[node + 1], &mut bends.0[end][node]);
                for i in 0..n {
                    let nearest = if from[i].abs() < to[i].abs() { from[i].abs() } else { to[i].abs() };
                    let near = (from[i] > 0.0) != (to[i] > 0.0) || nearest < BESIDE * step[i] + ROUNDING;
                    out[i] = if near && bound_w[i] > least_w { bend[i] } else { -1.0 };
                    passes[i] = if out[i] >= 0.0 { 1.0 } else { passes[i] };
                }
            }
        }
        passes[..count.min(LANES)].iter().any(|passes| *passes > 0.0)
    }
}

/// The larger of two, without their signs.
#[inline(always)]
fn largest(a: f32, b: f32) -> f32 {
    if a.abs() > b.abs() { a.abs() } else { b.abs() }
}

/// Zeroes the factors of facets whose cosine is not positive; whether any is nearer to zero than can be told.
struct Turn<'a> {
    count: usize,
    epochs: &'a [Epoch],
    /// Of the epochs.
    weights: &'a [f32],
    /// How much cosines to both antennas bend about the pulse, over what of it is left there, and which
    /// facets are in doubt.
    doubt: Option<([&'a Row; 2], f32, &'a mut Row)>,
    factor: &'a mut Row,
}

impl Task for Turn<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { count, epochs, weights, mut doubt, factor } = self;
        let n = lanes_for(count);
        let mut any = 0.0f32;
        for end in 0..2 {
            let mut cosine = [0.0f32; LANES];
            for (epoch, weight) in epochs.iter().zip(weights) {
                for i in 0..n {
                    cosine[i] += weight * epoch.cosine[end][i];
                }
            }
            if let Some((bends, left, near)) = &mut doubt {
                let bends = bends[end];
                for i in 0..n {
                    let most = if bends[i] < 0.0 { -1.0 } else { *left * bends[i] + ROUNDING };
                    near[i] = if cosine[i].abs() < most { 1.0 } else { near[i] };
                    any = if near[i] > any { near[i] } else { any };
                }
            }
            for i in 0..n {
                factor[i] = if cosine[i] > 0.0 { factor[i] } else { 0.0 };
            }
        }
        any > 0.0
    }
}
