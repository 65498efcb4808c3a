//! What a tile has of its facets, and leaving out those that nobody would miss.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use super::{Sample, Tally, Tile};
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{LANES, Paths, Row, lanes_for};
use crate::radar::window::Window;

/// A tile at a node, over one pair.
#[derive(Clone)]
pub struct Node {
    /// Places, delays, directions.
    pub paths: Box<Paths>,
}

/// A tile at a scattering epoch, over one pair.
#[derive(Clone)]
pub struct Epoch {
    /// Per channel of the pair: amplitude, sqrt(W), real and imaginary; without gains that are real numbers,
    /// and without shadows.
    pub amplitude: Vec<[Row; 2]>,
    /// Cosines of the local angles to both antennas.
    pub cosine: [Row; 2],
}

/// A tile over one pair of antennas.
#[derive(Clone)]
pub struct Pair {
    /// Room for all nodes of a block, and how many this tile has.
    pub(super) nodes: Vec<Node>,
    pub(super) node_count: usize,
    /// The same of scattering epochs.
    pub(super) epochs: Vec<Epoch>,
    pub(super) epoch_count: usize,
    /// Per pulse: what multiplies the amplitudes.
    pub factor: Vec<Row>,
    channels: usize,
}

impl Pair {
    pub(super) fn new(channels: usize) -> Self {
        let (nodes, epochs, factor) = (Vec::new(), Vec::new(), Vec::new());
        Self { nodes, node_count: 0, epochs, epoch_count: 0, factor, channels }
    }

    /// At every node.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes[..self.node_count]
    }

    /// At every look.
    pub fn epochs(&self) -> &[Epoch] {
        &self.epochs[..self.epoch_count]
    }

    pub(super) fn resize(&mut self, nodes: usize, epochs: usize, pulses: usize) {
        let channels = self.channels;
        self.nodes.resize_with(nodes, || Node { paths: Paths::boxed() });
        self.epochs.resize_with(epochs, || Epoch {
            amplitude: vec![[[0.0; LANES]; 2]; channels],
            cosine: [[0.0; LANES]; 2],
        });
        self.factor.resize(pulses, [0.0; LANES]);
    }

    /// Adds power, and power times delay rate, of facets at the middle node to a sample: of those that the
    /// window receives apart.
    pub(super) fn add_to(&self, sample: &mut Sample, count: usize, window: &Window) {
        let middle = (
            self.nodes().get(self.node_count / 2),
            self.epochs().get(self.epoch_count / 2),
            self.factor.get(self.factor.len() / 2),
        );
        if let (Some(node), Some(epoch), Some(factor)) = middle {
            for i in 0..count {
                let of = |[re, im]: &[Row; 2]| f64::from(re[i] * re[i] + im[i] * im[i]);
                let own = epoch.amplitude.iter().map(of).sum::<f64>() * f64::from(factor[i] * factor[i]);
                if own.is_finite() && node.paths.delay_rate[i].is_finite() {
                    sample.mean_power_w += own;
                    if window.touches(node.paths.delay_s[i]) {
                        sample.received_power_w += own;
                        sample.mean_rate += own * node.paths.delay_rate[i];
                    }
                }
            }
        }
    }

    /// A bound on the power of each facet at any pulse.
    #[inline(always)]
    fn bounds(&self, count: usize, out: &mut Row) {
        let n = lanes_for(count);
        let (mut amplitude, mut factor) = ([0.0f32; LANES], [0.0f32; LANES]);
        for [re, im] in self.epochs().iter().flat_map(|epoch| &epoch.amplitude) {
            for i in 0..n {
                amplitude[i] = amplitude[i].max(re[i] * re[i] + im[i] * im[i]);
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

    fn keep(&mut self, kept: &[u16]) {
        for node in &mut self.nodes[..self.node_count] {
            // What the echo reads; the rest stays where it was.
            compact(&mut node.paths.delay_s, kept);
            compact(&mut node.paths.delay_rate, kept);
        }
        for epoch in &mut self.epochs[..self.epoch_count] {
            for row in epoch.amplitude.as_flattened_mut() {
                compact(row, kept);
            }
        }
        for row in &mut self.factor {
            compact(row, kept);
        }
    }
}

pub(super) fn compact<T: Copy>(row: &mut [T; LANES], kept: &[u16]) {
    for (to, &from) in kept.iter().enumerate() {
        row[to] = row[usize::from(from) % LANES];
    }
}

/// Weak facets are left out of a tile where they are more than one in so many.
pub const FEW: usize = 4;

struct Bounds<'a>(&'a Pair, usize, &'a mut Row);

impl Task for Bounds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.bounds(self.1, self.2);
    }
}

impl Tile {
    /// Leaves out facets that nobody would miss.
    pub(super) fn thin_out(&mut self, variant: Variant, samples: &[Sample], least: f64, tally: &mut Tally) {
        let mut wanted = [false; LANES];
        let mut illuminated = [false; LANES];
        let mut bound = [0.0; LANES];
        for (pair, sample) in self.pairs.iter().zip(samples) {
            variant.run(Bounds(pair, self.count, &mut bound));
            let least_w = (least * sample.mean_power_w) as f32;
            for i in 0..self.count {
                illuminated[i] |= bound[i] > 0.0;
                wanted[i] |= bound[i] > least_w;
            }
        }
        let mut kept = [0u16; LANES];
        let mut count = 0;
        let all_lit = illuminated[..self.count].iter().filter(|illuminated| **illuminated).count();
        tally.illuminated += all_lit as u64;
        for i in 0..self.count {
            if wanted[i] {
                kept[count] = i as u16;
                count += 1;
            }
        }
        // Moving those that stay takes as long as spreading some of the others.
        if self.count - count > self.count / FEW {
            tally.culled += all_lit.saturating_sub(count) as u64;
            for pair in &mut self.pairs {
                pair.keep(&kept[..count]);
            }
            self.count = count;
        }
    }
}
