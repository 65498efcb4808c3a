//! The scatterer paths of a tile of facets as the echo reads them, and leaving out those that add nothing.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use num_complex::Complex32;

use super::instants::{Instants, Tier};
use super::slow_time::SlowTime;
use super::supports::{SupportSets, Supports};
use super::{Sample, Tally};
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{LANES, Paths, Row, lanes_for};

/// Channels of a layer: those of a pair that are spread together.
pub(super) const CHANNELS_PER_LAYER: usize = 4;
/// Most lanes of a layer.
const LANES_PER_LAYER: usize = 2 * CHANNELS_PER_LAYER;

/// Lanes of a layer of so many channels: real and imaginary part of each, a power of two.
pub fn lanes_of(channels: usize) -> usize {
    (2 * channels).next_power_of_two()
}

/// Channels of a pair, each given by its group, that are spread together: those that the same pulses fill, up
/// to four. By their places among all channels of the pair.
pub fn layers_of(groups: &[u8]) -> Vec<Vec<usize>> {
    let mut known: Vec<u8> = groups.to_vec();
    known.sort_unstable();
    known.dedup();
    let of_group = |group: u8| (0..groups.len()).filter(|n| groups[*n] == group).collect::<Vec<_>>();
    let of_group = known.into_iter().map(of_group);
    of_group
        .flat_map(|own| own.chunks(CHANNELS_PER_LAYER).map(<[usize]>::to_vec).collect::<Vec<_>>())
        .collect()
}

/// Scatterer paths of a block of pulses side by side: the facets of a tile, in the first [`Tile::count`]
/// places of every array. Filled by [`PathGenerator::visit_tiles`](crate::paths::PathGenerator::visit_tiles),
/// spread by [`Synth::spread_tile`](crate::echo::synth::Synth::spread_tile).
#[derive(Clone)]
pub struct Tile {
    /// Facets.
    pub count: usize,
    /// How it was evaluated.
    pub tier: Tier,
    /// When: pulses of its nodes and scattering epochs.
    pub instants: Instants,
    /// Mean time from pulse to pulse, s.
    pub interval_s: f64,
    /// When its pulses are.
    pub slow: SlowTime,
    /// At which pulses tiles of this block may be evaluated alone, and which of these this one has.
    pub(super) supports: SupportSets,
    /// Per transmitter-receiver pair.
    pub pairs: Vec<Pair>,
}

/// A tile at a node, over one pair.
#[derive(Clone)]
pub struct Node {
    /// Places, delays, directions.
    pub paths: Box<Paths>,
}

/// A tile at a scattering epoch, over one pair.
#[derive(Clone)]
pub struct Epoch {
    /// Amplitudes of the channels of the pair, without gains that are real numbers and without shadows: as
    /// [`layers_of`] has them.
    pub layers: Vec<Layer>,
    /// Largest power of any channel, W.
    pub(super) power: Row,
    /// Bound on the power of the specular points of any facet, also where they are another part, W.
    pub(super) specular_w: f32,
    /// Cosines of the local angles to both antennas.
    pub cosine: [Row; 2],
}

impl Epoch {
    fn new(layers: &[Vec<usize>]) -> Self {
        let layers = layers.iter().map(|channels| Layer::new(channels.clone())).collect();
        Self { layers, power: [0.0; LANES], specular_w: 0.0, cosine: [[0.0; LANES]; 2] }
    }

    fn channels(&self) -> usize {
        self.layers.iter().map(|layer| layer.channels.len()).sum()
    }

    /// Amplitude of a facet in a channel of the pair, sqrt(W).
    pub fn amplitude(&self, channel: usize, facet: usize) -> Complex32 {
        let of = |layer: &Layer| Some((layer.channels.iter().position(|own| *own == channel)?, layer.lanes));
        let found = self.layers.iter().find_map(|layer| of(layer).map(|at| (layer, at)));
        let Some((layer, (place, lanes))) = found else { return Complex32::ZERO };
        let at = facet * lanes + 2 * place;
        Complex32::new(layer.values.0[at], layer.values.0[at + 1])
    }

    /// Multiplies the amplitudes of a facet.
    pub(super) fn scale(&mut self, facet: usize, by: Complex32) {
        self.layers.iter_mut().for_each(|layer| layer.scale(facet, by));
        let powers = (0..self.channels()).map(|channel| self.amplitude(channel, facet).norm_sqr());
        self.power[facet] = powers.fold(0.0, f32::max);
    }

    /// Amplitudes channel by channel, real and imaginary.
    pub fn rows(&self) -> Vec<[Row; 2]> {
        let mut rows = vec![[[0.0; LANES]; 2]; self.channels()];
        for (channel, [re, im]) in rows.iter_mut().enumerate() {
            for i in 0..LANES {
                let own = self.amplitude(channel, i);
                (re[i], im[i]) = (own.re, own.im);
            }
        }
        rows
    }
}

/// Amplitudes of up to four channels, `[facet][lane]`, sqrt(W): lanes are the real and imaginary parts of the
/// channels, as those of the grids they are spread on. Lanes without a channel are zero.
#[derive(Clone)]
pub struct Layer {
    /// Places among the channels of the pair.
    channels: Vec<usize>,
    lanes: usize,
    values: Box<Lined>,
}

/// Numbers that start on a cache line.
#[derive(Clone)]
#[repr(align(64))]
struct Lined([f32; LANES_PER_LAYER * LANES]);

impl Layer {
    fn new(channels: Vec<usize>) -> Self {
        let lanes = lanes_of(channels.len());
        Self { channels, lanes, values: Box::new(Lined([0.0; LANES_PER_LAYER * LANES])) }
    }

    /// Its channels, by their places among those of the pair.
    pub fn channels(&self) -> &[usize] {
        &self.channels
    }

    /// Lanes: 2, 4 or 8.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Those of the first facets.
    pub fn of_first(&self, count: usize) -> &[f32] {
        &self.values.0[..count.min(LANES) * self.lanes]
    }

    /// Facet by facet, for layers of `C` lanes.
    #[inline(always)]
    pub(super) fn lines_mut<const C: usize>(&mut self) -> &mut [[f32; C]] {
        self.values.0.as_chunks_mut().0
    }

    fn keep(&mut self, kept: &[u16]) {
        match self.lanes {
            2 => compact(self.lines_mut::<2>(), kept),
            4 => compact(self.lines_mut::<4>(), kept),
            _ => compact(self.lines_mut::<8>(), kept),
        }
    }

    /// Multiplies the amplitudes of a facet.
    fn scale(&mut self, facet: usize, by: Complex32) {
        let (parts, _) = self.values.0[facet * self.lanes..][..self.lanes].as_chunks_mut::<2>();
        for [re, im] in parts {
            let value = Complex32::new(*re, *im) * by;
            (*re, *im) = (value.re, value.im);
        }
    }
}

/// What turns the facets of a tile at a pulse. Groups of a few facets are written for all pulses: a step from
/// row to row that is no power of two spreads them over the cache.
pub type TurnedRow = [f32; TURNED_LANES];
/// Numbers of such a row.
pub const TURNED_LANES: usize = LANES + 16;

/// A tile over one pair of antennas.
#[derive(Clone)]
pub struct Pair {
    /// Room for all nodes of a block, and how many this tile has.
    pub(super) nodes: Vec<Node>,
    pub(super) node_count: usize,
    /// The same of scattering epochs.
    pub(super) epochs: Vec<Epoch>,
    pub(super) epoch_count: usize,
    /// Per pulse, or support where the tile has any: what multiplies the amplitudes.
    pub factor: Vec<Row>,
    /// As often, real and imaginary: what turns Bragg waves that travel; empty where they do not.
    pub turned: Vec<[TurnedRow; 2]>,
    layers: Vec<Vec<usize>>,
}

impl Pair {
    /// Of channels of some groups.
    pub(super) fn new(groups: &[u8]) -> Self {
        let (nodes, epochs, factor) = (Vec::new(), Vec::new(), Vec::new());
        let layers = layers_of(groups);
        Self { nodes, node_count: 0, epochs, epoch_count: 0, factor, turned: Vec::new(), layers }
    }

    fn channels(&self) -> usize {
        self.layers.iter().map(Vec::len).sum()
    }

    /// At every node.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes[..self.node_count]
    }

    /// Longest time between the delays of the first facets at a node, s.
    pub fn extent_s(&self, count: usize) -> f64 {
        self.nodes().iter().fold(0.0, |longest: f64, node| {
            let delays_s = node.paths.delay_s[..count].iter();
            let [least, most] = delays_s
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], delay_s| {
                    [least.min(*delay_s), most.max(*delay_s)]
                });
            longest.max(most - least)
        })
    }

    /// At every scattering epoch.
    pub fn epochs(&self) -> &[Epoch] {
        &self.epochs[..self.epoch_count]
    }

    pub(super) fn resize(&mut self, nodes: usize, epochs: usize, pulses: usize) {
        let layers = &self.layers;
        self.nodes.resize_with(nodes, || Node { paths: Paths::boxed() });
        self.epochs.resize_with(epochs, || Epoch::new(layers));
        self.factor.resize(pulses, [0.0; LANES]);
    }

    /// Adds power, and power times delay rate, of facets at the middle node to a sample, each by the share
    /// of it that windows receive at its delay.
    pub(super) fn add_to(&self, sample: &mut Sample, count: usize, share: impl Fn(f64) -> f64) {
        let middle = (
            self.nodes().get(self.node_count / 2),
            self.epochs().get(self.epoch_count / 2),
            self.factor.get(self.factor.len() / 2),
        );
        if let (Some(node), Some(epoch), Some(factor)) = middle {
            for i in 0..count {
                let of = |channel| f64::from(epoch.amplitude(channel, i).norm_sqr());
                let own = (0..self.channels()).map(of).sum::<f64>() * f64::from(factor[i] * factor[i]);
                if own.is_finite() && node.paths.delay_rate[i].is_finite() {
                    let own = own * share(node.paths.delay_s[i]);
                    sample.received_power_w += own;
                    sample.mean_rate += own * node.paths.delay_rate[i];
                }
            }
        }
    }

    /// A bound on the power of each facet at any pulse.
    #[inline(always)]
    fn bounds(&self, count: usize, out: &mut Row) {
        let n = lanes_for(count);
        let (mut amplitude, mut factor) = ([0.0f32; LANES], [0.0f32; LANES]);
        for epoch in self.epochs() {
            for i in 0..n {
                amplitude[i] = amplitude[i].max(epoch.power[i]);
            }
        }
        for row in &self.factor {
            for i in 0..n {
                factor[i] = factor[i].max(row[i].abs());
            }
        }
        for i in 0..n {
            out[i] = amplitude[i] * factor[i] * factor[i];
        }
    }

    /// A bound on the power of the specular points of any of the first facets at any pulse.
    fn specular_w(&self, count: usize) -> f32 {
        let of_epochs = self.epochs().iter().fold(0.0, |most: f32, epoch| most.max(epoch.specular_w));
        if of_epochs == 0.0 {
            return 0.0;
        }
        let mut most = [0.0f32; LANES];
        for row in &self.factor {
            for i in 0..lanes_for(count) {
                most[i] = most[i].max(row[i].abs());
            }
        }
        let factor = most[..count].iter().fold(0.0, |a: f32, b| a.max(*b));
        of_epochs * factor * factor
    }

    fn keep(&mut self, kept: &[u16]) {
        for node in &mut self.nodes[..self.node_count] {
            // What the echo reads, and what turns facets; the rest stays where it was.
            let Paths { delay_s, delay_rate, incident, scattered, .. } = &mut *node.paths;
            compact(delay_s, kept);
            compact(delay_rate, kept);
            incident.iter_mut().chain(scattered).for_each(|row| compact(row, kept));
        }
        for epoch in &mut self.epochs[..self.epoch_count] {
            epoch.layers.iter_mut().for_each(|layer| layer.keep(kept));
        }
        self.factor.iter_mut().for_each(|row| compact(row, kept));
    }
}

pub(super) fn compact<T: Copy>(row: &mut [T], kept: &[u16]) {
    let Some(row) = row.first_chunk_mut::<LANES>() else { return };
    for (to, &from) in kept.iter().enumerate() {
        row[to] = row[usize::from(from) % LANES];
    }
}

/// Weak facets are left out of a tile where they are more than one in so many.
pub const FEW: usize = 4;

/// A bound on the power of each of the first facets at any pulse, W.
pub(super) struct Bounds<'a>(pub &'a Pair, pub usize, pub &'a mut Row);

impl Task for Bounds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.bounds(self.1, self.2);
    }
}

impl Tile {
    /// Phase about which it turns over a pair at every pulse of the block, turns: that of the middle of its
    /// Doppler, from the first pulse on.
    pub fn middle_turns(&self, pair: usize, carrier_hz: f64, out: &mut Vec<f64>) {
        let (pair, nodes) = (&self.pairs[pair], &self.instants.nodes[..self.instants.node_count]);
        let middle = |[least, most]: [f64; 2]| 0.5 * (least + most);
        out.clear();
        let mut before = 0.0;
        for n in 0..nodes.len() {
            let Some(next) = nodes.get(n + 1) else { continue };
            let [from, to] = [self.slow.at(nodes[n]), self.slow.at(*next)];
            let half_s = 0.5 * (to - from) * self.interval_s;
            let span = |node, half| middle(pair.rate_span(self.count, node, half, 2.0 * half_s));
            // Straight from the node to half-way, and from there to the next.
            let rates = [span(n, false), span(n, true), span(n + 1, false)];
            let delay_s = |x: f64| {
                let (a, b) = (x.min(1.0), (x - 1.0).max(0.0));
                let first = a * (rates[0] + 0.5 * a * (rates[1] - rates[0]));
                half_s * (first + b * (rates[1] + 0.5 * b * (rates[2] - rates[1])))
            };
            let end = if n + 2 == nodes.len() { self.instants.pulses } else { *next };
            for pulse in nodes[n]..end {
                let x = 2.0 * (self.slow.at(pulse) - from) / (to - from);
                out.push(before - carrier_hz * delay_s(x));
            }
            before -= carrier_hz * delay_s(2.0);
        }
    }

    /// Whether any specular points may count, where facets below `least` of the power of a sample do not.
    pub(super) fn reflects(&self, (samples, least): (&[Sample], f64)) -> bool {
        let of = |(pair, sample): (&Pair, &Sample)| {
            pair.specular_w(self.count) > (least * sample.received_power_w) as f32
        };
        self.pairs.iter().zip(samples).any(of)
    }

    /// The pulses at which it was evaluated, where these are not all.
    pub fn supports(&self) -> Option<&Supports> {
        self.supports.chosen()
    }

    /// Leaves out facets that add nothing to the echo; shows which are kept, and says whether these have
    /// moved.
    pub(super) fn thin_out(
        &mut self,
        variant: Variant,
        (samples, least): (&[Sample], f64),
        tally: &mut Tally,
        kept: &mut Vec<u16>,
    ) -> bool {
        let mut wanted = [false; LANES];
        let mut illuminated = [false; LANES];
        let mut bound = [0.0; LANES];
        for (pair, sample) in self.pairs.iter().zip(samples) {
            variant.run(Bounds(pair, self.count, &mut bound));
            let least_w = (least * sample.received_power_w) as f32;
            for i in 0..self.count {
                illuminated[i] |= bound[i] > 0.0;
                wanted[i] |= bound[i] > least_w;
            }
        }
        kept.clear();
        kept.extend((0..self.count as u16).filter(|i| wanted[usize::from(*i)]));
        let count = kept.len();
        let all_illuminated = illuminated[..self.count].iter().filter(|illuminated| **illuminated).count();
        tally.illuminated += all_illuminated as u64;
        // Moving those that stay takes as long as spreading some of the others.
        let moves = self.count - count > self.count / FEW;
        if moves {
            tally.culled += all_illuminated.saturating_sub(count) as u64;
            self.pairs.iter_mut().for_each(|pair| pair.keep(kept));
            self.count = count;
        }
        moves
    }
}

impl Tile {
    /// Room for scatterers, of channels of some groups by pair, from pulse to pulse of so many seconds.
    pub(in crate::paths) fn new(interval_s: f64, channels: &[Vec<u8>]) -> Self {
        Self {
            count: 0,
            tier: Tier::Mainlobe,
            instants: Instants::default(),
            interval_s,
            pairs: channels.iter().map(|groups| Pair::new(groups)).collect(),
            slow: SlowTime::default(),
            supports: SupportSets::default(),
        }
    }

    /// Takes some pulses of its block, with a node and a scattering epoch at the first and at the last.
    pub(in crate::paths) fn take(&mut self, pulses: Range<usize>) {
        self.instants = Instants::between(pulses.clone());
        for pair in &mut self.pairs {
            pair.resize(2, 2, pulses.end.max(pair.factor.len()));
            (pair.node_count, pair.epoch_count) = (self.instants.node_count, self.instants.epoch_count);
        }
    }
}

impl Pair {
    /// A node and the scattering epoch that is there.
    pub(in crate::paths) fn at_node(&mut self, node: usize) -> Option<(&mut Paths, &mut Epoch)> {
        Some((&mut *self.nodes.get_mut(node)?.paths, self.epochs.get_mut(node)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Facets that stay keep delays, factors and the amplitudes of every channel, in one layer or two, of
    /// every number of lanes.
    #[test]
    fn facets_that_stay_keep_all_they_have() {
        for channels in 1..=5 {
            let mut pair = Pair::new(&vec![0; channels]);
            pair.resize(1, 1, 1);
            (pair.node_count, pair.epoch_count) = (1, 1);
            // Every third facet returns something.
            let power = |i: usize| if i.is_multiple_of(3) { 1.0 + i as f32 } else { 0.0 };
            for i in 0..LANES {
                pair.nodes[0].paths.delay_s[i] = i as f64;
                pair.factor[0][i] = power(i);
                pair.epochs[0].power[i] = 1.0;
                for (place, layer) in pair.epochs[0].layers.iter_mut().enumerate() {
                    let of_layer = (channels - place * CHANNELS_PER_LAYER).min(CHANNELS_PER_LAYER);
                    for k in 0..2 * of_layer {
                        layer.values.0[i * layer.lanes + k] = (100 * place + 10 * k) as f32 + i as f32;
                    }
                }
            }
            let instants = Instants::of_block(0, 1, 1, 1);
            let mut tile = Tile { count: 250, instants, pairs: vec![pair], ..Tile::new(1.0, &[]) };
            let mut tally = Tally::default();
            let (samples, mut shown) = ([Sample::default()], Vec::new());
            assert!(tile.thin_out(Variant::fastest(), (&samples, 0.0), &mut tally, &mut shown));
            let kept: Vec<usize> = (0..250usize).filter(|i| i.is_multiple_of(3)).collect();
            assert!(shown.iter().map(|i| usize::from(*i)).eq(kept.iter().copied()));
            assert_eq!((tile.count, tally.illuminated, tally.culled), (kept.len(), 84, 0), "{channels}");
            let pair = &tile.pairs[0];
            let rows = pair.epochs()[0].rows();
            assert_eq!(rows.len(), channels);
            for (n, &i) in kept.iter().enumerate() {
                assert_eq!((pair.nodes()[0].paths.delay_s[n], pair.factor[0][n]), (i as f64, power(i)));
                for (channel, [re, im]) in rows.iter().enumerate() {
                    let (place, k) = (channel / CHANNELS_PER_LAYER, 2 * (channel % CHANNELS_PER_LAYER));
                    let value = |k: usize| (100 * place + 10 * k) as f32 + i as f32;
                    assert_eq!((re[n], im[n]), (value(k), value(k + 1)), "{channels} {channel} {n}");
                }
            }
            // Lanes without a channel stay zero.
            let last = pair.epochs()[0].layers.last().unwrap();
            let used = 2 * (channels - (channels - 1) / CHANNELS_PER_LAYER * CHANNELS_PER_LAYER);
            let lines = last.of_first(kept.len()).chunks(last.lanes());
            assert!(lines.flat_map(|line| &line[used..]).all(|value| *value == 0.0), "{channels}");
        }
    }
}
