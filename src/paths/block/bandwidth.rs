//! How fast a tile changes from pulse to pulse, and whether it is evaluated at its supports alone.
//!
//! A tile whose facets have Doppler from `f_1` to `f_2` turns about its middle, `(f_1 + f_2)/2`, and is taken
//! to have the bandwidth
//!
//! `B = max (f_2 - f_1) + 2 f_w + |r| f_s + sum (a |du/dt| + b |dv/dt|)` ,
//!
//! over its nodes and the middles between them: `f_w` is how far waves that travel, or phases that are
//! forgotten, reach off the Doppler of their facets, and `|r| f_s` what a delay of rate `r` that moves over
//! the grid adds at the edge of the band that is received. The sum is over both antennas, of sides `a` and
//! `b` in wavelengths, in whose frames the tile moves: over a unit of `u` the field gain of an aperture has
//! `a/2` cycles at most.
//!
//! A facet that shadows hide or uncover has no such bandwidth: what is seen of it is straight from update to
//! update, with a kink at each. A tile with one is evaluated at every pulse.

use std::f64::consts::TAU;

use glam::DVec3;

use super::TileWork;
use super::tile::Pair;
use super::travelling::Part;
use crate::geometry::lanes::{Paths, Row};
use crate::paths::sea::SeaPlan;
use crate::paths::{PairPlan, PathGenerator};

/// Cells of the delay grid of a sample, about.
const CELLS_PER_SAMPLE: f64 = 2.0;
/// Cells that a tile has on the grid on top of its extent.
const MORE_CELLS: f64 = 10.0;
/// Time to find a pulse from supports, for each cell, over that of a facet at a pulse.
const PER_CELL: f64 = 0.5;
/// What of a facet shadows may hide or uncover from update to update.
const STEADY: f32 = 1e-3;
/// A tile is wider than its first facet shows.
const OF_LINES: f64 = 1.2;
/// Deviations up to which phases that are forgotten turn.
const DEVIATIONS: f64 = 4.0;

/// Rates of the delays of a tile, over its nodes and the middles between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rates {
    /// Largest less least at any of these.
    span: f64,
    /// Largest magnitude.
    fastest: f64,
}

impl Pair {
    /// Least and largest rate of its delays at a node, or `half` of `interval_s` after it, in the middle
    /// between it and the next.
    pub fn rate_span(&self, count: usize, node: usize, half: bool, interval_s: f64) -> [f64; 2] {
        let paths = |n: usize| -> &Paths { &self.nodes()[n].paths };
        let mut span = [f64::INFINITY, f64::NEG_INFINITY];
        let own = paths(node);
        let mut take = |rate: f64| {
            if rate.abs() < 1.0 {
                span = [span[0].min(rate), span[1].max(rate)];
            }
        };
        if half {
            let next = paths(node + 1);
            let per_s = 1.5 / interval_s;
            for i in 0..count {
                let ends = own.delay_rate[i] + next.delay_rate[i];
                take(per_s * (next.delay_s[i] - own.delay_s[i]) - 0.25 * ends);
            }
        } else {
            own.delay_rate[..count].iter().for_each(|rate| take(*rate));
        }
        if span[0] <= span[1] { span } else { [0.0; 2] }
    }
}

impl TileWork {
    /// Whether shadows hide and uncover no facet of the tile at hand.
    fn is_seen_steadily(&self) -> bool {
        let ends = self.shadow_updates.first().map_or(0, |update| update.weights.len());
        let count = self.tile.count;
        let apart = |(before, after): (&Row, &Row)| {
            before[..count].iter().zip(&after[..count]).all(|(a, b)| (a - b).abs() < STEADY)
        };
        !self.dims.contains(&true) || self.seen.iter().zip(self.seen.iter().skip(ends)).all(apart)
    }
}

impl PathGenerator {
    /// Chooses the supports of the tile at hand: the farthest that its bandwidth allows, if evaluating it at
    /// these alone saves time.
    pub(super) fn choose_supports(&self, sea: &SeaPlan, work: &mut TileWork) {
        work.tile.supports.choose(None);
        let (count, pulses) = (work.tile.count, work.tile.instants.pulses);
        if work.tile.supports.is_empty() || work.whole || count == 0 || !work.is_seen_steadily() {
            return;
        }
        let mut bandwidth_hz = 0.0f64;
        let mut extent_s = 0.0f64;
        for (plan, pair) in self.plans.iter().zip(&work.tile.pairs) {
            let Rates { span, fastest } = self.rates_of_tile(pair, work);
            let of_waves = self.band_of_waves_hz(sea, work.part, pair);
            let of_doppler = self.radar.carrier_hz * span + fastest * self.radar.sample_rate_hz;
            let own = of_doppler + of_waves + self.band_of_gains_hz(plan, pair, work);
            bandwidth_hz = bandwidth_hz.max(own);
            extent_s = extent_s.max(pair.extent_s(count));
        }
        let cells = CELLS_PER_SAMPLE * self.radar.sample_rate_hz * extent_s + MORE_CELLS;
        let Some(chosen) = work.tile.supports.for_bandwidth(bandwidth_hz * work.tile.interval_s) else {
            return;
        };
        let supports = work.tile.supports.get(chosen).map_or(pulses, |own| own.pulses().len());
        let saved = (pulses - supports) as f64 * count as f64;
        // Never of an extent that is no number.
        if PER_CELL * cells * (pulses as f64) < saved {
            work.tile.supports.choose(Some(chosen));
        }
    }

    fn rates_of_tile(&self, pair: &Pair, work: &TileWork) -> Rates {
        let (nodes, count) = (pair.nodes().len(), work.tile.count);
        let (at, slow) = (&work.tile.instants.nodes, &work.tile.slow);
        let mut rates = Rates::default();
        let mut add = |[least, most]: [f64; 2]| {
            rates.span = rates.span.max(most - least);
            rates.fastest = rates.fastest.max(least.abs()).max(most.abs());
        };
        for node in 0..nodes {
            add(pair.rate_span(count, node, false, 0.0));
            if node + 1 < nodes {
                let interval_s = (slow.at(at[node + 1]) - slow.at(at[node])) * work.tile.interval_s;
                add(pair.rate_span(count, node, true, interval_s));
            }
        }
        rates
    }

    /// Both sides of what beams that sweep over the tile, as its first facet shows, add to its bandwidth, Hz.
    fn band_of_gains_hz(&self, plan: &PairPlan, pair: &Pair, work: &TileWork) -> f64 {
        let ends = plan.ends(self.radar.transmitters.len());
        let (timing, slow) = (work.timing(), &work.tile.slow);
        let at = |node: usize, end: usize| {
            let Paths { incident, scattered, .. } = &*pair.nodes()[node].paths;
            let rows = if end == 0 { incident } else { scattered };
            let along = DVec3::from_array([0, 1, 2].map(|axis| f64::from(rows[axis][0])));
            let (axes, _) = self.axes_of(&work.nodes[timing.nodes[node]].emission, ends[end]);
            axes.transpose() * along
        };
        let mut most_hz = 0.0f64;
        for node in 1..pair.nodes().len() {
            let [from, to] = [node - 1, node].map(|n| slow.at(work.tile.instants.nodes[n]));
            let passed_s = (to - from) * work.tile.interval_s;
            let of_end = |end: usize| {
                let [a, b] = self.antennas[ends[end]].sides_wavelengths();
                let moved = (at(node, end) - at(node - 1, end)).abs();
                (a * moved.y + b * moved.z) / passed_s
            };
            most_hz = most_hz.max(of_end(0) + of_end(1));
        }
        most_hz
    }

    /// Both sides of what waves add to the Doppler of their facets, Hz.
    fn band_of_waves_hz(&self, sea: &SeaPlan, part: Part, pair: &Pair) -> f64 {
        let radps = match (sea.scattering.travelling(), part.mechanism()) {
            (Some(lines), Some(mechanism)) => {
                let of = |paths: &Paths| {
                    let [incident, scattered] = [&paths.incident, &paths.scattered]
                        .map(|rows| DVec3::from_array([0, 1, 2].map(|axis| f64::from(rows[axis][0]))));
                    lines.reach_radps(mechanism, incident, scattered)
                };
                OF_LINES * pair.nodes().iter().map(|node| of(&node.paths)).fold(0.0, f64::max)
            }
            _ => match part {
                Part::Forgetting(_) => DEVIATIONS * sea.scattering.forgetting_radps(),
                _ => 0.0,
            },
        };
        2.0 * radps / TAU
    }
}
