//! At which pulses of a block something is found, and the weights of what lies between.

use std::ops::RangeInclusive;

/// Most nodes of a block.
pub const NODES: usize = 4;
/// Nodes of a faint tile.
pub const SIDELOBE_NODES: usize = 2;
/// Most looks from one node to the next.
pub const LOOKS_PER_NODE: usize = 3;
/// Most looks of a block.
pub const LOOKS: usize = (NODES - 1) * LOOKS_PER_NODE + 1;
/// Looks that a polynomial goes through.
pub const LOOK_POINTS: usize = 4;
/// Gain instants that a pulse's gain is found from.
pub const GAIN_POINTS: usize = 6;

/// The instants of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instants {
    /// First pulse of the block.
    pub first: u64,
    /// Pulses.
    pub pulses: usize,
    /// Pulses of the nodes within the block, rising, the first and the last among them.
    pub nodes: [usize; NODES],
    /// How many there are.
    pub node_count: usize,
    /// Pulses of the looks, rising: those of the nodes, and some between.
    pub looks: [usize; LOOKS],
    /// How many there are.
    pub look_count: usize,
    /// Pulses from gain to gain.
    pub gain_pulses: usize,
}

impl Instants {
    /// Those of a block: up to [`NODES`] nodes from its first to its last pulse, `looks` from one node to the next where there
    /// are as many pulses.
    pub fn of_block(first: u64, pulses: usize, looks: usize, gain_pulses: usize) -> Self {
        let last = pulses.saturating_sub(1);
        let (nodes, node_count) = nodes_within(pulses);
        let gain_pulses = gain_step(pulses, gain_pulses);
        let mut instants = Self { first, pulses, nodes, node_count, gain_pulses, ..Self::default() };
        for n in 0..node_count {
            let (node, next) = (nodes[n], if n + 1 < node_count { nodes[n + 1] } else { last });
            let steps = looks.clamp(1, LOOKS_PER_NODE).min((next - node).max(1));
            for step in 0..if n + 1 < node_count { steps } else { 1 } {
                instants.looks[instants.look_count.min(LOOKS - 1)] = node + (next - node) * step / steps;
                instants.look_count += 1;
            }
        }
        instants
    }

    /// Those of the faint tiles of such a block: nodes at both ends, some looks (2 at least) from end to end, gains [`sidelobe_gain_pulses`]
    /// apart. `None` of blocks of few pulses.
    pub fn faint(&self, look_count: usize) -> Option<Self> {
        if self.node_count < NODES {
            return None;
        }
        let (last, look_count) = (self.pulses - 1, look_count.clamp(2, NODES));
        let (mut nodes, mut looks) = ([0; NODES], [0; LOOKS]);
        nodes[1] = last;
        for (n, look) in looks[..look_count].iter_mut().enumerate() {
            *look = n * last / (look_count - 1);
        }
        let gain_pulses = gain_step(self.pulses, sidelobe_gain_pulses(self.gain_pulses));
        Some(Self { nodes, node_count: SIDELOBE_NODES, looks, look_count, gain_pulses, ..*self })
    }
}

/// How closely a tile is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// At all instants of its block.
    #[default]
    Close,
    /// At few: no antenna pair has more than a side lobe for it.
    Sidelobe,
}

/// Which tiles are faint, and how they are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sidelobe {
    /// Two-way gain of every pair over its peak below which a tile is faint, dB.
    pub below_db: f64,
    /// Looks from end to end of a block, 2 to 4.
    pub looks: usize,
}

/// The instants of a block for all its tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tiers {
    /// Of tiles that are looked at closely.
    pub close: Instants,
    /// Of faint ones, if there may be any.
    pub faint: Option<Instants>,
    /// Two-way gain of every pair over its peak below which they are, dB.
    pub below_db: f64,
}

impl From<Instants> for Tiers {
    /// All tiles close.
    fn from(close: Instants) -> Self {
        Self::new(close, None)
    }
}

impl Tiers {
    /// Of a block, whose tiles are faint below a two-way gain, if at all.
    pub fn new(close: Instants, faint: Option<Sidelobe>) -> Self {
        let below_db = faint.map_or(f64::NEG_INFINITY, |faint| faint.below_db);
        Self { close, faint: faint.and_then(|faint| close.faint(faint.looks)), below_db }
    }

    /// Those of a tier.
    pub fn of(&self, tier: Tier) -> &Instants {
        match (tier, &self.faint) {
            (Tier::Sidelobe, Some(faint)) => faint,
            _ => &self.close,
        }
    }
}

/// Pulses of the nodes within a block of so many pulses, rising, and how many there are.
pub fn nodes_within(pulses: usize) -> ([usize; NODES], usize) {
    let last = pulses.saturating_sub(1);
    if last >= NODES - 1 {
        (std::array::from_fn(|n| n * last / (NODES - 1)), NODES)
    } else {
        (std::array::from_fn(|n| n.min(last)), last + 1)
    }
}

/// Pulses from gain to gain that a block of so many pulses takes: not more than leave it all the instants of a polynomial.
pub fn gain_step(pulses: usize, gain_pulses: usize) -> usize {
    gain_pulses.min(pulses.saturating_sub(1) / (GAIN_POINTS - 1)).max(1)
}

/// Pulses from gain to gain of a faint tile, where others have so many.
pub fn sidelobe_gain_pulses(gain_pulses: usize) -> usize {
    (3 * gain_pulses / 2).max(1)
}

/// Pulses of the gain instants of a block, its last one among them.
pub fn gain_instants(pulses: usize, gain_pulses: usize) -> impl Iterator<Item = usize> {
    let last = pulses.saturating_sub(1);
    (0..last).step_by(gain_pulses.max(1)).chain([last])
}

/// Weights of the gain instants at a pulse: the first of them that counts, as many before as after but within the block, and the
/// weights from there on.
pub fn gain_weights(places: &[usize], pulse: usize) -> (usize, [f32; GAIN_POINTS]) {
    let points = GAIN_POINTS.min(places.len());
    let after = places.partition_point(|place| *place <= pulse);
    let first = after.saturating_sub(points / 2).min(places.len() - points);
    (first, through(&places[first..first + points], pulse))
}

/// The first of the [`LOOK_POINTS`] looks about some pulses: as many before as after, but within the block.
pub fn looks_about(looks: &[usize], pulses: RangeInclusive<usize>) -> usize {
    let from = looks.partition_point(|look| look <= pulses.start()).saturating_sub(1);
    let to = looks.partition_point(|look| look < pulses.end()).min(looks.len().saturating_sub(1));
    let points = LOOK_POINTS.min(looks.len());
    (from + to).saturating_sub(points - 1).div_euclid(2).min(looks.len() - points)
}

/// Weights of the polynomial through values at `places`, at `pulse`.
pub(super) fn through<const N: usize>(places: &[usize], pulse: usize) -> [f32; N] {
    let mut weights = [0.0; N];
    for (n, (weight, own)) in weights.iter_mut().zip(places).enumerate() {
        let others = places.iter().enumerate().filter(|(m, _)| *m != n);
        let product = others.fold(1.0, |product, (_, other)| {
            product * (pulse as f64 - *other as f64) / (*own as f64 - *other as f64)
        });
        *weight = product as f32;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_of_blocks() {
        let block = Instants::of_block(7, 37, 2, 4);
        assert_eq!((block.first, block.node_count, block.nodes), (7, 4, [0, 12, 24, 36]));
        assert_eq!(&block.looks[..block.look_count], [0, 6, 12, 18, 24, 30, 36]);
        // Blocks cut short move their nodes together, down to a single one.
        let short = Instants::of_block(0, 3, 3, 4);
        assert_eq!((short.node_count, &short.looks[..short.look_count]), (3, &[0, 1, 2][..]));
        let single = Instants::of_block(0, 1, 3, 4);
        assert_eq!((single.node_count, single.look_count), (1, 1));
        assert_eq!(gain_instants(10, 4).collect::<Vec<_>>(), [0, 4, 8, 9]);
        // Six instants of gain at least, where there are as many pulses.
        assert_eq!([37, 21, 7, 3, 1].map(|pulses| gain_step(pulses, 4)), [4, 4, 1, 1, 1]);
        assert_eq!((block.gain_pulses, short.gain_pulses), (4, 1));
        assert_eq!(gain_instants(1, 4).collect::<Vec<_>>(), [0]);
        // Faint tiles: both ends; the block has no less than six instants of gain.
        let tiers = Tiers::new(block, Some(Sidelobe { below_db: -40.0, looks: 2 }));
        let faint = tiers.of(Tier::Sidelobe);
        assert_eq!(
            (&faint.nodes[..faint.node_count], &faint.looks[..faint.look_count]),
            (&[0, 36][..], &[0, 36][..])
        );
        assert_eq!((faint.gain_pulses, tiers.of(Tier::Close)), (6, &block));
        assert_eq!(short.faint(2), None);
        let thrice = block.faint(3).unwrap();
        assert_eq!(&thrice.looks[..thrice.look_count], [0, 18, 36]);
        assert_eq!([1, 2, 3, 4, 6].map(sidelobe_gain_pulses), [1, 3, 4, 6, 9]);
    }

    #[test]
    fn weights_of_gains_are_those_of_polynomials() {
        let places: Vec<usize> = gain_instants(37, 4).collect();
        for pulse in 0..37 {
            let (first, weights) = gain_weights(&places, pulse);
            // A polynomial of the fifth degree is met: to rounding of values up to 1, weights below 3.
            let of = |m: usize| (m as f32 / 36.0).powi(5);
            let found: f32 = weights.iter().zip(&places[first..]).map(|(w, m)| w * of(*m)).sum();
            assert!((found - of(pulse)).abs() < 2e-6, "{pulse}: {found}");
        }
    }
}
