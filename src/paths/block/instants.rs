//! At which pulses of a block something is found, and the weights of what lies between.

use std::ops::{Range, RangeInclusive};

use super::slow_time::SlowTime;

/// Most nodes of a block.
pub const NODES: usize = 4;
/// Nodes of a sidelobe tile.
pub const SIDELOBE_NODES: usize = 2;
/// Most scattering epochs from one node to the next.
pub const EPOCHS_PER_NODE: usize = 3;
/// Scattering epochs from one node to the next that wake tiles may have.
pub const WAKE_EPOCHS: [usize; 5] = [1, 2, EPOCHS_PER_NODE, 6, MOST_PER_NODE];
const MOST_PER_NODE: usize = 8;
/// Most scattering epochs of a block: two are added at its ends.
pub const EPOCHS: usize = (NODES - 1) * MOST_PER_NODE + 1 + 2;
/// Scattering epochs that a polynomial goes through.
pub const EPOCH_POINTS: usize = 4;
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
    /// Pulses of the scattering epochs, rising: those of the nodes, and some between.
    pub epochs: [usize; EPOCHS],
    /// How many there are.
    pub epoch_count: usize,
    /// Pulses from gain to gain.
    pub gain_pulses: usize,
}

impl Instants {
    /// Those of a block: up to [`NODES`] nodes from its first to its last pulse, `epochs` from one node to
    /// the next where there are as many pulses. Of more than [`EPOCHS_PER_NODE`] the first and the last step
    /// of the block are halved: a cubic that ends there is worse than one in the midst of its epochs.
    pub fn of_block(first: u64, pulses: usize, epochs: usize, gain_pulses: usize) -> Self {
        let last = pulses.saturating_sub(1);
        let (nodes, node_count) = nodes_within(pulses);
        let gain_pulses = gain_step(pulses, gain_pulses);
        let mut instants = Self { first, pulses, nodes, node_count, gain_pulses, ..Self::default() };
        for n in 0..node_count {
            let (node, next) = (nodes[n], if n + 1 < node_count { nodes[n + 1] } else { last });
            let steps = epochs.clamp(1, MOST_PER_NODE).min((next - node).max(1));
            for step in 0..if n + 1 < node_count { steps } else { 1 } {
                instants.add_epoch(node + (next - node) * step / steps);
            }
        }
        if epochs > EPOCHS_PER_NODE && instants.epoch_count > 1 {
            let of = &instants.epochs[..instants.epoch_count];
            let halves = [of[0] + of[1], of[of.len() - 2] + of[of.len() - 1]].map(|sum| sum / 2);
            for half in halves {
                if !instants.epochs[..instants.epoch_count].contains(&half) {
                    instants.add_epoch(half);
                }
            }
            instants.epochs[..instants.epoch_count].sort_unstable();
        }
        instants
    }

    /// Some pulses of a block, with a node and a scattering epoch at the first and at the last of them.
    pub(super) fn between(pulses: Range<usize>) -> Self {
        let last = pulses.end.saturating_sub(1);
        let mut instants = Self { pulses: pulses.end, gain_pulses: 1, ..Self::default() };
        for pulse in [pulses.start, last].into_iter().take(if last > pulses.start { 2 } else { 1 }) {
            instants.nodes[instants.node_count] = pulse;
            instants.node_count += 1;
            instants.add_epoch(pulse);
        }
        instants
    }

    fn add_epoch(&mut self, pulse: usize) {
        self.epochs[self.epoch_count.min(EPOCHS - 1)] = pulse;
        self.epoch_count += 1;
    }

    /// Pieces from a node to the next over which amplitudes are one polynomial each: all of it, or from epoch
    /// to epoch where there are more steps than [`EPOCH_POINTS`] epochs have between them.
    pub fn pieces(&self, node: usize) -> impl Iterator<Item = Piece> {
        let epochs = &self.epochs[..self.epoch_count];
        let [from, to] = [node, node + 1].map(|n| self.nodes[n.min(self.node_count.saturating_sub(1))]);
        let end = if node + 2 >= self.node_count { self.pulses } else { to };
        let first = epochs.partition_point(|epoch| *epoch < from);
        let steps = epochs.partition_point(|epoch| *epoch <= to).saturating_sub(first + 1);
        let pieces = if steps < EPOCH_POINTS { 1 } else { steps };
        (0..pieces).map(move |n| {
            let [a, b] = if pieces == 1 { [from, to] } else { [epochs[first + n], epochs[first + n + 1]] };
            let first = epochs_about(epochs, a..=b);
            let middle = if pieces == 1 { (self.nodes[0] + self.pulses) / 2 } else { (a + b) / 2 };
            let pulses = a..if n + 1 == pieces { end } else { b };
            Piece { pulses, epochs: first..epochs.len().min(first + EPOCH_POINTS), middle }
        })
    }

    /// Those of the sidelobe tiles of such a block: nodes at both ends, some scattering epochs (2 at least)
    /// from end to end, gains [`sidelobe_gain_pulses`] apart. `None` of blocks of few pulses.
    pub fn sidelobe(&self, epoch_count: usize) -> Option<Self> {
        if self.node_count < NODES {
            return None;
        }
        let (last, epoch_count) = (self.pulses - 1, epoch_count.clamp(2, NODES));
        let (mut nodes, mut epochs) = ([0; NODES], [0; EPOCHS]);
        nodes[1] = last;
        for (n, epoch) in epochs[..epoch_count].iter_mut().enumerate() {
            *epoch = n * last / (epoch_count - 1);
        }
        let gain_pulses = gain_step(self.pulses, sidelobe_gain_pulses(self.gain_pulses));
        Some(Self { nodes, node_count: SIDELOBE_NODES, epochs, epoch_count, gain_pulses, ..*self })
    }
}

/// Pulses over which amplitudes are one polynomial.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The pulses.
    pub pulses: Range<usize>,
    /// Places of the scattering epochs that it goes through, up to [`EPOCH_POINTS`].
    pub epochs: Range<usize>,
    /// The pulse from which its powers count.
    pub middle: usize,
}

/// How often a tile is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tier {
    /// At all instants of its block.
    #[default]
    Mainlobe,
    /// At few: no antenna pair has more than a side lobe for it.
    Sidelobe,
    /// At all, and at more scattering epochs: short waves of a ship may cross it.
    Wake,
}

/// Which tiles are in the sidelobes, and how they are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sidelobe {
    /// Two-way gain of every pair over its peak below which a tile is in the sidelobes, dB.
    pub below_db: f64,
    /// Scattering epochs from end to end of a block, 2 to 4.
    pub epochs: usize,
    /// Two-way gain of every pair over its peak below which a tile is left out, dB.
    pub cutoff_db: f64,
}

impl Sidelobe {
    /// All tiles are in the sidelobes, and none is left out.
    pub fn everywhere(epochs: usize) -> Self {
        Self { below_db: f64::INFINITY, epochs, cutoff_db: f64::NEG_INFINITY }
    }
}

/// The instants of a block for all its tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tiers {
    /// Of mainlobe tiles.
    pub mainlobe: Instants,
    /// Of sidelobe tiles, if there may be any.
    pub sidelobe: Option<Instants>,
    /// Two-way gain of every pair over its peak below which they are, and below which they are left out, dB.
    pub below_db: f64,
    pub cutoff_db: f64,
    /// Of wake tiles, if there may be any.
    pub wake: Option<Instants>,
    /// Share of its power that a tile may lack for being evaluated at its supports alone; `None`: at every
    /// pulse.
    pub between: Option<f64>,
    /// Share of the power of all above which a facet that turns away is decided by the surface at that
    /// pulse; `None`: none is.
    pub turning: Option<f64>,
}

impl From<Instants> for Tiers {
    /// All tiles are mainlobe tiles.
    fn from(mainlobe: Instants) -> Self {
        Self::new(mainlobe, None)
    }
}

impl Tiers {
    /// Of a block, whose tiles are in the sidelobes below a two-way gain, if at all.
    pub fn new(mainlobe: Instants, sidelobe: Option<Sidelobe>) -> Self {
        let [below_db, cutoff_db] =
            sidelobe.map_or([f64::NEG_INFINITY; 2], |own| [own.below_db, own.cutoff_db]);
        Self {
            mainlobe,
            sidelobe: sidelobe.and_then(|sidelobe| mainlobe.sidelobe(sidelobe.epochs)),
            below_db,
            cutoff_db,
            wake: None,
            between: None,
            turning: None,
        }
    }

    /// The same with so many scattering epochs from node to node of wake tiles.
    pub fn with_wake(self, epochs: Option<usize>) -> Self {
        let Instants { first, pulses, gain_pulses, .. } = self.mainlobe;
        Self { wake: epochs.map(|epochs| Instants::of_block(first, pulses, epochs, gain_pulses)), ..self }
    }

    /// Most scattering epochs of a tile.
    pub fn epochs(&self) -> usize {
        [Tier::Mainlobe, Tier::Sidelobe, Tier::Wake]
            .map(|tier| self.of(tier).epoch_count)
            .into_iter()
            .fold(0, usize::max)
    }

    /// Those of a tier.
    pub fn of(&self, tier: Tier) -> &Instants {
        let own = match tier {
            Tier::Mainlobe => None,
            Tier::Sidelobe => self.sidelobe.as_ref(),
            Tier::Wake => self.wake.as_ref(),
        };
        own.unwrap_or(&self.mainlobe)
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

/// Pulses from gain to gain that a block of so many pulses takes: not more than leave it all the instants of
/// a polynomial.
pub fn gain_step(pulses: usize, gain_pulses: usize) -> usize {
    gain_pulses.min(pulses.saturating_sub(1) / (GAIN_POINTS - 1)).max(1)
}

/// Pulses from gain to gain of a sidelobe tile, where others have so many.
pub fn sidelobe_gain_pulses(gain_pulses: usize) -> usize {
    (3 * gain_pulses / 2).max(1)
}

/// Pulses of the gain instants of a block, its last one among them.
pub fn gain_instants(pulses: usize, gain_pulses: usize) -> impl Iterator<Item = usize> {
    let last = pulses.saturating_sub(1);
    (0..last).step_by(gain_pulses.max(1)).chain([last])
}

/// Weights of the gain instants at a pulse: the first of them that counts, as many before as after but within
/// the block, and the weights from there on.
pub fn gain_weights(places: &[usize], pulse: usize, slow: &SlowTime) -> (usize, [f32; GAIN_POINTS]) {
    let points = GAIN_POINTS.min(places.len());
    let after = places.partition_point(|place| *place <= pulse);
    let first = after.saturating_sub(points / 2).min(places.len() - points);
    (first, through(&places[first..first + points], pulse, slow))
}

/// The first of the [`EPOCH_POINTS`] scattering epochs about some pulses: as many before as after, but within
/// the block.
pub fn epochs_about(epochs: &[usize], pulses: RangeInclusive<usize>) -> usize {
    let from = epochs.partition_point(|epoch| epoch <= pulses.start()).saturating_sub(1);
    let to = epochs.partition_point(|epoch| epoch < pulses.end()).min(epochs.len().saturating_sub(1));
    let points = EPOCH_POINTS.min(epochs.len());
    (from + to).saturating_sub(points - 1).div_euclid(2).min(epochs.len() - points)
}

/// Weights of the polynomial in slow time through values at `places`, at `pulse`.
pub(super) fn through<const N: usize>(places: &[usize], pulse: usize, slow: &SlowTime) -> [f32; N] {
    let (mut weights, at) = ([0.0; N], slow.at(pulse));
    for (n, (weight, own)) in weights.iter_mut().zip(places).enumerate() {
        let others = places.iter().enumerate().filter(|(m, _)| *m != n);
        let product = others.fold(1.0, |product, (_, other)| {
            product * (at - slow.at(*other)) / (slow.at(*own) - slow.at(*other))
        });
        *weight = product as f32;
    }
    weights
}

/// At a pulse, the node before it, and what a polynomial through nodes leaves there, over the next difference
/// that it does not know.
pub(super) fn left_at(places: &[usize], pulse: usize, slow: &SlowTime) -> (usize, f32) {
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return (0, 0.0) };
    let step = (slow.at(*last) - slow.at(*first)) / (places.len() - 1).max(1) as f64;
    let of = |(n, place): (usize, &usize)| (slow.at(pulse) - slow.at(*place)) / (step * (n + 1) as f64);
    let left = places.iter().enumerate().map(of).product::<f64>().abs() as f32;
    (places.partition_point(|place| *place <= pulse).clamp(1, places.len().max(2) - 1) - 1, left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_of_blocks() {
        let block = Instants::of_block(7, 37, 2, 4);
        assert_eq!((block.first, block.node_count, block.nodes), (7, 4, [0, 12, 24, 36]));
        assert_eq!(&block.epochs[..block.epoch_count], [0, 6, 12, 18, 24, 30, 36]);
        // Blocks cut short move their nodes together, down to a single one.
        let short = Instants::of_block(0, 3, 3, 4);
        assert_eq!((short.node_count, &short.epochs[..short.epoch_count]), (3, &[0, 1, 2][..]));
        let single = Instants::of_block(0, 1, 3, 4);
        assert_eq!((single.node_count, single.epoch_count), (1, 1));
        assert_eq!(gain_instants(10, 4).collect::<Vec<_>>(), [0, 4, 8, 9]);
        // Six instants of gain at least, where there are as many pulses.
        assert_eq!([37, 21, 7, 3, 1].map(|pulses| gain_step(pulses, 4)), [4, 4, 1, 1, 1]);
        assert_eq!((block.gain_pulses, short.gain_pulses), (4, 1));
        assert_eq!(gain_instants(1, 4).collect::<Vec<_>>(), [0]);
        // Sidelobe tiles: both ends; the block has no less than six instants of gain.
        let tiers = Tiers::new(block, Some(Sidelobe { below_db: -40.0, ..Sidelobe::everywhere(2) }));
        let sidelobe = tiers.of(Tier::Sidelobe);
        assert_eq!(
            (&sidelobe.nodes[..sidelobe.node_count], &sidelobe.epochs[..sidelobe.epoch_count]),
            (&[0, 36][..], &[0, 36][..])
        );
        assert_eq!((sidelobe.gain_pulses, tiers.of(Tier::Mainlobe)), (6, &block));
        assert_eq!(short.sidelobe(2), None);
        let thrice = block.sidelobe(3).unwrap();
        assert_eq!(&thrice.epochs[..thrice.epoch_count], [0, 18, 36]);
        assert_eq!([1, 2, 3, 4, 6].map(sidelobe_gain_pulses), [1, 3, 4, 6, 9]);
    }

    /// Pieces cover every pulse once, and have their epochs about them; those of wake tiles go from epoch to
    /// epoch.
    #[test]
    fn pieces_of_amplitudes() {
        for (pulses, epochs) in [(49, 1), (49, 2), (49, 3), (49, 6), (37, 8), (22, 8), (7, 8), (3, 8), (1, 1)]
        {
            let block = Instants::of_block(5, pulses, epochs, 4);
            let own = &block.epochs[..block.epoch_count];
            assert!(own.is_sorted_by(|a, b| a < b) && own[0] == 0 && own[own.len() - 1] == pulses - 1);
            assert!(block.nodes[..block.node_count].iter().all(|node| own.contains(node)));
            let mut next = 0;
            for node in 0..block.node_count.saturating_sub(1).max(1) {
                let pieces: Vec<Piece> = block.pieces(node).collect();
                assert!(epochs > EPOCHS_PER_NODE || pieces.len() == 1, "{pulses} {epochs}");
                for piece in pieces {
                    assert_eq!(piece.pulses.start, next, "{pulses} {epochs}");
                    next = piece.pulses.end;
                    let of = &own[piece.epochs.clone()];
                    assert_eq!(of.len(), EPOCH_POINTS.min(own.len()));
                    assert!(of[0] <= piece.pulses.start && piece.pulses.end - 1 <= of[of.len() - 1]);
                }
            }
            assert_eq!(next, pulses, "{pulses} {epochs}");
        }
        // The first and the last step of wake tiles are halved.
        let wake = Instants::of_block(0, 49, 8, 4);
        assert_eq!((wake.epoch_count, &wake.epochs[..4], wake.epochs[25]), (27, &[0, 1, 2, 4][..], 47));
        let tiers = Tiers::new(Instants::of_block(0, 49, 1, 4), None).with_wake(Some(8));
        assert_eq!(
            (tiers.of(Tier::Wake), tiers.of(Tier::Mainlobe).epoch_count, tiers.epochs()),
            (&wake, 4, 27)
        );
        assert_eq!(tiers.with_wake(None).of(Tier::Wake), &tiers.mainlobe);
    }

    #[test]
    fn weights_of_gains_are_those_of_polynomials() {
        let places: Vec<usize> = gain_instants(37, 4).collect();
        for pulse in 0..37 {
            let (first, weights) = gain_weights(&places, pulse, &SlowTime::default());
            // A polynomial of the fifth degree is met: to rounding of values up to 1, weights below 3.
            let of = |m: usize| (m as f32 / 36.0).powi(5);
            let found: f32 = weights.iter().zip(&places[first..]).map(|(w, m)| w * of(*m)).sum();
            assert!((found - of(pulse)).abs() < 2e-6, "{pulse}: {found}");
        }
    }
}
