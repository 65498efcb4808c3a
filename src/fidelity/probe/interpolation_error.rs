//! What interpolation between nodes and scattering epochs leaves.

use std::f64::consts::TAU;
use std::ops::Range;
use std::rc::Rc;

use num_complex::{Complex32, Complex64};

use super::{ErrorSampler, Powers, TILES, Truth, runs_of, through};
use crate::fidelity::echo_settings::block_pulses;
use crate::fidelity::sidelobe::{Binned, Candidates};
use crate::fidelity::worst::{Cells, Sum};
use crate::paths::block::probe::{Keep, SampledTile, Shadows};
use crate::paths::block::{
    EPOCH_POINTS, EPOCHS_PER_NODE, Instants, Sidelobe, SlowTime, Tier, Tiers, WAKE_EPOCHS, gain_instants,
    gain_step, gain_weights, nodes_within,
};
use crate::radar::fault::RadarError;

/// Factor on the scattering error of sidelobe tiles where facets turn away. Their scattering epochs are so
/// far apart that single facets whose turn is found late leave more in the worst pulse than any sample shows:
/// 12 dB more with epochs at both ends alone, in the grazing scene of `tests/agreement/planned.rs`.
const OF_TURNING: f64 = 10.0;

/// What interpolation between nodes leaves at a probe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterpolationError {
    /// Pulses to the nearer end of the block.
    pub edge: u64,
    /// Of delays.
    pub path: Powers,
    /// Of scattering.
    pub tilt: Powers,
}

/// Of delays, of scattering: `[channel]`, by gain.
type Parts = [Vec<Binned>; 2];

/// What a block leaves at its probes, each tile taken as a mainlobe tile and as a sidelobe tile.
#[derive(Clone, Debug, Default)]
pub struct Probed {
    /// Pulses of the probes to the nearer end of the block.
    edges: Vec<u64>,
    /// `[epochs from node to node][probe]`, epochs as in [`WAKE_EPOCHS`]; more than [`EPOCHS_PER_NODE`] of
    /// wake tiles alone.
    close: Vec<Vec<Parts>>,
    /// Share of the facets in wake tiles.
    wake_share: f64,
    /// `[probe]`; those of mainlobe tiles where blocks have no sidelobe tiles.
    sidelobe: Option<Vec<Parts>>,
    channels: usize,
    share: f64,
    deviations: f64,
    /// What weighs scattering of sidelobe tiles.
    of_turning: f64,
}

impl Probed {
    /// How many numbers it holds.
    fn numbers(&self) -> usize {
        let all = self.close.iter().chain(&self.sidelobe).flatten().flatten().flatten();
        all.map(Binned::numbers).sum()
    }

    /// Share of the facets in wake tiles.
    pub fn wake_share(&self) -> f64 {
        self.wake_share
    }

    /// At every probe, with so many scattering epochs from node to node, also of wake tiles, and sidelobe
    /// tiles by the threshold of a candidate.
    pub fn left(
        &self,
        (epochs, wake_epochs): (usize, Option<usize>),
        candidates: &Candidates,
        candidate: usize,
    ) -> Vec<InterpolationError> {
        if self.edges.is_empty() {
            return vec![nothing(self.channels)];
        }
        let of_epochs = |epochs: usize| {
            let place = WAKE_EPOCHS.iter().position(|own| *own == epochs).unwrap_or(0);
            &self.close[place.min(self.close.len() - 1)]
        };
        let (close, wake) = (of_epochs(epochs), of_epochs(wake_epochs.unwrap_or(epochs)));
        let sidelobe = self.sidelobe.as_ref().unwrap_or(close);
        let of = |probe: usize, part: usize| {
            let channels = close[probe][part].iter().zip(&wake[probe][part]).zip(&sidelobe[probe][part]);
            channels
                .map(|((close, wake), sidelobe)| {
                    let mut sums = [Sum::default(), Sum::default()];
                    close.join_into(candidates, candidate, false, &mut sums[0]);
                    wake.join_wake_into(&mut sums[0]);
                    sidelobe.join_into(candidates, candidate, true, &mut sums[1]);
                    let weights = [1.0, if part == 1 { self.of_turning } else { 1.0 }];
                    let worst = sums.iter().map(|sum| sum.worst(self.share, self.deviations));
                    worst.zip(weights).map(|(worst, weight)| weight * worst).sum()
                })
                .collect()
        };
        let probes = self.edges.iter().enumerate();
        probes
            .map(|(probe, &edge)| InterpolationError { edge, path: of(probe, 0), tilt: of(probe, 1) })
            .collect()
    }
}

/// What blocks leave whose every pulse is a node.
fn nothing(channels: usize) -> InterpolationError {
    InterpolationError { edge: 0, path: vec![0.0; channels], tilt: vec![0.0; channels] }
}

impl ErrorSampler<'_> {
    /// What blocks leave whose every pulse is a node.
    pub fn nothing(&self) -> InterpolationError {
        nothing(self.radar.channels.len())
    }

    /// What blocks with nodes so many pulses apart leave at the probes of a place.
    ///
    /// # Errors
    /// A track that ends before the place.
    pub fn left(&mut self, place: usize, node_pulses: u64) -> Result<Rc<Probed>, RadarError> {
        let key = (place, node_pulses);
        if let Some(known) = self.known.probed.get(&key) {
            return Ok(known);
        }
        let found = self.probe(place, node_pulses)?;
        let numbers = found.numbers();
        Ok(self.known.probed.keep(key, found, numbers))
    }

    fn probe(&mut self, place: usize, node_pulses: u64) -> Result<Probed, RadarError> {
        let channels = self.radar.channels.len();
        let (share, deviations, sidelobe_epochs) =
            (self.sampled(), self.deviations(), self.sidelobe_epochs());
        let of_turning = if self.turning { OF_TURNING } else { 1.0 };
        let none = Probed { channels, share, deviations, of_turning, ..Probed::default() };
        let first = self.block_of(place, node_pulses);
        let Some(patch) = self.generator.patch_of(first)? else { return Ok(none) };
        let until = self.generator.stays(self.places[place].first).end.min(self.pulses);
        let pulses = block_pulses(node_pulses).min(until.saturating_sub(first)) as usize;
        let (nodes, count) = nodes_within(pulses);
        if node_pulses <= 1 || count < 2 || nodes[1] < 2 {
            return Ok(none);
        }
        let probes = self.probes(&nodes[..count]);
        let mut truths = Vec::new();
        for (_, probe) in &probes {
            truths.push(self.illuminate(first + *probe as u64, Some(&patch), Keep::default())?);
        }
        let (pairs, cells) = (self.channels.len(), self.cells_at(first)?);
        let mut slow = SlowTime::default();
        self.generator.slow_time(first, pulses, &mut slow);
        let edges = probes.iter().map(|(_, probe)| (*probe).min(pulses - 1 - *probe) as u64).collect();
        let mut found = Probed { edges, ..none };
        let Some(tiles) = &mut self.tiles else { return Ok(found) };
        let (candidates, interval_s) = (&self.candidates, self.interval_s);
        let waves = (self.radar.carrier_hz, 0.5 * self.pulse_s);
        let all = Sidelobe::everywhere(sidelobe_epochs);
        let has_wakes = self.generator.has_short_waves();
        let each = &WAKE_EPOCHS[..if has_wakes { WAKE_EPOCHS.len() } else { EPOCHS_PER_NODE }];
        let (mut facets, mut in_wakes) = (0, 0);
        for n in 0..=each.len() {
            let sidelobe = n == each.len();
            let epochs = each.get(n).copied().unwrap_or(1);
            let block = Instants::of_block(first, pulses, epochs, pulses);
            let of_wakes = !sidelobe && epochs > EPOCHS_PER_NODE;
            // The last time round all tiles are taken as sidelobe tiles.
            let tiers = Tiers::new(block, sidelobe.then_some(all));
            if sidelobe && tiers.sidelobe.is_none() {
                break;
            }
            let instants = tiers.of(if sidelobe { Tier::Sidelobe } else { Tier::Mainlobe });
            let epochs = &instants.epochs[..instants.epoch_count];
            let interval_of = |(n, probe): &(usize, usize)| {
                let n = (*n).min(instants.node_count - 2);
                let nodes = [instants.nodes[n], instants.nodes[n + 1]];
                let piece = instants.pieces(n).find(|piece| piece.pulses.contains(probe));
                let of = piece.map_or(0..epochs.len().min(EPOCH_POINTS), |piece| piece.epochs);
                Interval { at: n, from: of.start, epochs: &epochs[of], nodes, interval_s, slow: &slow }
            };
            let intervals: Vec<Interval<'_>> = probes.iter().map(interval_of).collect();
            let none: Parts = std::array::from_fn(|_| vec![Binned::new(candidates); channels]);
            let mut sums = vec![none; probes.len()];
            let keep = Keep { shadows: Shadows::Without, surface: n > 0 };
            self.generator.sample_tiles(&tiers, &patch, TILES, keep, tiles, |sampled| {
                let mut runs = runs_of(sampled, candidates);
                for ((lanes, bin), crossed) in runs.iter_mut().zip(sampled.crossed) {
                    if *crossed {
                        *bin = candidates.wake_bin();
                    }
                    facets += lanes.len();
                    in_wakes += if *crossed { lanes.len() } else { 0 };
                }
                runs.retain(|(_, bin)| !of_wakes || *bin == candidates.wake_bin());
                for (((interval, (_, probe)), truths), sum) in
                    intervals.iter().zip(&probes).zip(&truths).zip(&mut sums)
                {
                    let truth = &truths[sampled.tile * pairs + sampled.pair];
                    let own = &self.channels[sampled.pair];
                    for (lanes, bin) in &runs {
                        interval.compare(
                            *probe,
                            sampled,
                            lanes.clone(),
                            truth,
                            waves,
                            (own, cells),
                            (sum, *bin),
                        );
                        for part in sum.iter_mut() {
                            own.iter().for_each(|channel| part[*channel].0[*bin].close());
                        }
                    }
                }
            })?;
            if sidelobe {
                found.sidelobe = Some(sums);
            } else {
                found.close.push(sums);
            }
        }
        found.wake_share = in_wakes as f64 / facets.max(1) as f64;
        Ok(found)
    }

    /// Pulses at which a block is probed, and the intervals of its nodes that hold them.
    fn probes(&self, nodes: &[usize]) -> Vec<(usize, usize)> {
        // A cubic through four points is at its worst 0.38 of the first interval on, and there may be two or
        // three scattering epochs in it.
        let within =
            |n: usize, share: f64| nodes[n] + ((nodes[n + 1] - nodes[n]) as f64 * share).round() as usize;
        let last = nodes.len() - 2;
        let mut probes =
            vec![(0, within(0, 0.2).max(1)), (0, within(0, 0.4).max(1)), (last, within(last, 0.6))];
        if last > 1 {
            probes.push((1, within(1, 0.5)));
        }
        if self.generator.has_short_waves() {
            // Scattering epochs of wake tiles are as close as every other pulse: an odd number from the node.
            let odd = |n: usize, share: f64| (n, nodes[n] + ((within(n, share) - nodes[n]) | 1));
            probes.extend([odd(0, 0.1), odd(0, 0.3), odd(last.min(1), 0.55), odd(last, 0.8)]);
            probes.retain(|(n, pulse)| *pulse < nodes[n + 1]);
            probes.sort_unstable();
        }
        if self.is_small() {
            let more = (0..=last).flat_map(|n| [0.2, 0.4, 0.6, 0.8].map(|share| (n, within(n, share))));
            probes.extend(more);
            probes.sort_unstable();
        }
        probes.retain(|(_, pulse)| !nodes.contains(pulse));
        probes.dedup();
        probes
    }
}

/// From one node to the next.
struct Interval<'a> {
    /// Place of the first.
    at: usize,
    /// Pulses of its scattering epochs.
    epochs: &'a [usize],
    /// The first of them.
    from: usize,
    nodes: [usize; 2],
    interval_s: f64,
    slow: &'a SlowTime,
}

impl Interval<'_> {
    /// Adds what is left of some lanes at a probe to the sums of a bin.
    fn compare(
        &self,
        probe: usize,
        sampled: &SampledTile<'_>,
        lanes: Range<usize>,
        truth: &Truth,
        (carrier_hz, half_pulse_s): (f64, f64),
        (channels, cells): (&[usize], Cells),
        (sum, bin): (&mut Parts, usize),
    ) {
        let [a, b] = [0, 1].map(|n| &sampled.of.nodes()[self.at + n].paths);
        let slow = |pulse: usize| self.slow.at(pulse);
        let length = slow(self.nodes[1]) - slow(self.nodes[0]);
        let (s, span_s) = ((slow(probe) - slow(self.nodes[0])) / length, length * self.interval_s);
        let weights = through(self.epochs, probe, slow);
        let epochs = &sampled.of.epochs()[self.from..self.from + self.epochs.len()];
        let pulses = sampled.of.factor.len();
        let steps: Vec<usize> = gain_instants(pulses, gain_step(pulses, pulses)).collect();
        let (first, gain_weights) = gain_weights(&steps, probe, self.slow);
        for i in lanes {
            let share = truth.share[i];
            if share <= 0.0 {
                continue;
            }
            // Gains and shadows are those of the probe; of the block's own factor counts whether a facet has
            // turned away.
            let rough: f32 = sampled.gains[first..].iter().zip(gain_weights).map(|(row, w)| row[i] * w).sum();
            let turned = rough != 0.0 && sampled.of.factor[probe][i] == 0.0;
            let exact = f64::from(truth.factor[i]);
            let found = if turned { 0.0 } else { exact };
            if exact == 0.0 {
                continue;
            }
            // Hermite's cubic, from the first node on.
            let (d, v0, v1) =
                (b.delay_s[i] - a.delay_s[i], a.delay_rate[i] * span_s, b.delay_rate[i] * span_s);
            let late_s = (a.delay_s[i] - truth.delay_s[i])
                + s * (v0 + s * ((3.0 * d - 2.0 * v0 - v1) + s * (v0 + v1 - 2.0 * d)));
            let rate = a.delay_rate[i] + s * (b.delay_rate[i] - a.delay_rate[i]);
            let late_s = late_s + half_pulse_s * (rate - truth.rate[i]);
            let radians = (TAU * carrier_hz * late_s).powi(2).min(4.0);
            let cell = cells.of(truth.delay_s[i]);
            for (at, channel) in channels.iter().enumerate() {
                let mut value = Complex32::ZERO;
                for (epoch, weight) in epochs.iter().zip(weights) {
                    value += epoch.amplitude(at, i) * weight as f32;
                }
                let [re, im] = &truth.amplitude[at];
                let own = Complex64::new(re[i].into(), im[i].into()) * exact;
                let value = Complex64::new(value.re.into(), value.im.into()) * found;
                sum[0][*channel].0[bin].add(share * own.norm_sqr() * radians, cell);
                sum[1][*channel].0[bin].add(share * (value - own).norm_sqr(), cell);
            }
        }
    }
}
