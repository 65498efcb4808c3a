//! From what is asked to what is set: the cheapest settings whose predicted error keeps the budget.
//!
//! Settings that are given stay. For the others there are candidates, from far to close nodes; the error of each is probed
//! ([`sounding`](crate::fidelity::probe)) until closer nodes cost more than what was found already. A budget at or below [`EXACT_DB`] takes pulses one by one with exact
//! scatterer paths in f64, and so does a scene that no candidate serves. Facets may be left out while all of them together stay
//! [`CULLED_DB`] below the budget.

use super::echo_settings::{EchoSettings, block_length, block_pulses};
use std::f64::consts::TAU;
use std::sync::Arc;

use super::cost::{Prices, Size, Work};
use super::{PlanError, Prediction};
use crate::echo::Asked;
use crate::echo::synth::doppler::{Doppler, Envelope, error_power, rigid_error_power};
use crate::echo::synth::{Precision, PredictedError, Settings, Synth};
use crate::fidelity::probe::points::Law;
use crate::fidelity::probe::{ErrorSampler, InterpolationError, LONGEST, Powers, Probed, Sweeps, Swept};
use crate::paths::PathGenerator;
use crate::paths::block::{EPOCHS_PER_NODE, GAIN_POINTS, NODES, Sidelobe};
use crate::radar::waveform::Waveform;
use crate::scene::Scene;
use crate::sea::GRAVITY_MPS2;

/// Budgets from here down are kept in f64, pulse by pulse, dB.
pub const EXACT_DB: f64 = -90.0;
/// What is left out because it is weak stays so far below the budget, dB.
pub const CULLED_DB: f64 = 10.0;
/// Longest spacing of the nodes, pulses.
pub const LONGEST_SPACING: u64 = NODE_PULSES[0];
/// Rungs of the nodes, pulses.
const NODE_PULSES: [u64; 9] = [21, 16, 12, 9, 7, 5, 4, 3, 2];
/// Rungs of the gains, pulses.
const GAIN_PULSES: [u64; 9] = [12, 10, 8, 6, 5, 4, 3, 2, 1];
/// Pulses over which places on the grid move in a common block, for their rounding.
const DRIFT_PULSES: f64 = 12.0;
/// Widths of the kernel.
const WIDTHS: std::ops::RangeInclusive<usize> = 4..=8;
/// Scattering epochs in a period of the shortest waves of the surface, at least, where facets turn away: one that does between two scattering epochs is told where
/// to a part of that, and single facets make the worst pulses at grazing incidence.
const LOOKS_PER_PERIOD: f64 = 30.0;

/// Where facets turn away tiles are not in the sidelobes above this gain, dB: a single facet that is told late where it turns makes the worst pulse
/// (grazing seas of 64 x 64 facets, -67.4 dB where -67.8 were predicted with tiles in the sidelobes below -25 dB).
const OF_TURNING_DB: f64 = -40.0;

/// What the acceleration of the water adds in the worst pulse to its mean, dB: the worst of 48 pulses from 800 km is 4.7 dB above it
/// (`tests/data/scenarios/orbit.toml`, -54.4 against -59.2 dB of the closed form).
const WORST_BOUNCE_DB: f64 = 5.0;

/// Rounding of the samples to f32, those of the reference too: uniform within a unit of `2^-23` where the mantissa is 1, on the whole half the
/// power of that, `2 x 2^-46/24`.
const OF_SAMPLES: f64 = 1.2e-15;

/// The spacing that nodes then have, pulses.
fn spacing_within(spacing: u64, hold_pulses: Option<u64>) -> u64 {
    (block_length(spacing, hold_pulses) - 1).div_ceil(NODES as u64 - 1).max(1)
}

/// Scattering epochs from node to node that come nearest to what is asked.
fn epochs_of(node_pulses: u64, scatter_pulses: u64) -> usize {
    node_pulses.div_ceil(scatter_pulses.max(1)).clamp(1, EPOCHS_PER_NODE as u64) as usize
}

/// What was planned for a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// What was asked.
    pub asked: Asked,
    /// What is set.
    pub chosen: EchoSettings,
    /// Its error.
    pub prediction: Prediction,
    /// What it has to do.
    pub work: Work,
    /// Sizes from which that follows.
    pub size: Size,
}

impl Plan {
    /// Whether the error that was asked is kept.
    pub fn keeps(&self) -> bool {
        self.prediction.total_db() <= self.asked.error_db
    }
}

/// Relative to the channel's own power: the worst channel of a sum of powers.
struct Judge<'a> {
    power: &'a Powers,
}

impl Judge<'_> {
    fn ratio(&self, of: &Powers, channel: usize) -> f64 {
        if self.power[channel] > 0.0 { of[channel] / self.power[channel] } else { 0.0 }
    }

    /// Path, tilt, gain and what is left out, of the probe and channel where they are worst together.
    fn worst(
        &self,
        left: &[InterpolationError],
        (gain, gain_pulses): (&Swept, u64),
        culled: &Powers,
    ) -> [f64; 4] {
        let nearest = left.iter().map(|left| left.edge).min().unwrap_or(0);
        let of = |left: &InterpolationError, channel| {
            let gain = if left.edge <= gain_pulses.max(nearest) { &gain.end } else { &gain.inner };
            [&left.path, &left.tilt, gain, culled].map(|part| self.ratio(part, channel))
        };
        (0..self.power.len())
            .flat_map(|channel| left.iter().map(move |left| of(left, channel)))
            .max_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum::<f64>()))
            .unwrap_or_default()
    }
}

/// Share of the budget up to which envelopes are left rigid: 0.04 dB.
const OF_RIGID: f64 = 0.01;

/// Share of the budget that Doppler may leave where pulses are split into bands of it.
const OF_BANDS: f64 = 0.3;

/// A sidelobe threshold below which tiles are in the sidelobes.
#[derive(Clone, Copy)]
struct Candidate {
    n: usize,
    sidelobe: Option<Sidelobe>,
    sidelobe_share: f64,
}

/// Pulses from gain to gain at a step, and what that leaves.
struct Gain {
    pulses: u64,
    candidate: Candidate,
    swept: Swept,
}

/// Chooses what is not given.
pub fn choose_settings(
    scene: &Scene,
    generator: &PathGenerator,
    waveform: &Arc<dyn Waveform>,
    asked: &Asked,
) -> Result<Plan, PlanError> {
    let mut sampler =
        ErrorSampler::new(generator, &scene.radar, waveform.as_ref(), scene.pulses, asked.sidelobe_db)?;
    // No interpolation knows of a jump, and soundings may miss it.
    let free: &[u64] = if generator.aim_jumps() { &[1] } else { &GAIN_PULSES };
    let gain_steps: Vec<u64> = asked.gain_pulses.map_or(free.to_vec(), |pulses| vec![pulses]);
    sampler.follow_points(&gain_steps)?;
    let power = sampler.power().clone();
    let judge = Judge { power: &power };
    let budget = 10f64.powf(asked.error_db / 10.0);
    let least_power = 10f64.powf((asked.error_db - CULLED_DB) / 10.0);
    let of_facets = generator.facets() as f64;

    let echoes = Echoes { scene, generator, waveform };
    let doppler = asked.doppler.unwrap_or(match waveform.sweep_rate_hz_per_s() {
        Some(_) => Doppler::Shift,
        None => Doppler::Taylor,
    });
    let settings_of =
        |width: usize| Settings { width, doppler, variant: asked.variant, ..Settings::default() };
    let exact = asked.node_pulses.map_or(asked.error_db <= EXACT_DB, |node_pulses| node_pulses <= 1);
    let precision = if exact && asked.error_db <= EXACT_DB { Precision::Double } else { Precision::Single };
    // Gridding and rounding take a tenth of the budget, or what there is.
    let widths: Vec<usize> = asked.kernel_width.map_or(WIDTHS.collect(), |width| vec![width]);
    let mut settings = settings_of(8);
    let (mut error, mut fft_len) = (PredictedError::default(), 0);
    for width in widths {
        settings = settings_of(width);
        (error, fft_len) = echoes.error(&sampler, settings, precision)?;
        if error.gridding <= 0.1 * budget {
            break;
        }
    }
    let of_rigid = echoes.rigid_error(&sampler, fft_len);
    if !exact && of_rigid <= OF_RIGID * budget {
        settings.envelope = Envelope::Rigid;
    }
    let of_envelope = if settings.envelope == Envelope::Rigid { of_rigid } else { 0.0 };
    let hold_pulses = generator.hold_pulses();
    let mut spacings: Vec<u64> = asked.node_pulses.map_or(NODE_PULSES.to_vec(), |pulses| vec![pulses]);
    spacings.iter_mut().for_each(|pulses| *pulses = spacing_within(*pulses, hold_pulses));
    spacings.dedup();
    spacings.retain(|pulses| *pulses > 1);
    let lengths = spacings.iter().filter(|_| !exact).map(|pulses| block_length(*pulses, hold_pulses));
    let blocks: Vec<u64> = [1].into_iter().chain(lengths).collect();
    let longest = blocks.iter().copied().max().unwrap_or(1);
    let of = |doppler: Doppler| (doppler, settings.envelope);
    let mut of_doppler = echoes.doppler_error(&mut sampler, of(doppler), fft_len, &blocks)?;
    let may_have_moment = asked.doppler.is_none() && doppler != Doppler::Taylor;
    if may_have_moment && of_doppler.of_blocks(longest) > 0.3 * budget {
        let other = echoes.doppler_error(&mut sampler, of(Doppler::Taylor), fft_len, &blocks)?;
        if other.of_blocks(longest) < 0.5 * of_doppler.of_blocks(longest) {
            settings.doppler = Doppler::Taylor;
            of_doppler = other;
        }
    }
    let echo_of = |block: u64| PredictedError { doppler: of_doppler.of_blocks(block) + of_envelope, ..error };
    let of_single = echo_of(1);
    // Pulses by themselves can be split into bands of Doppler.
    let most = OF_BANDS * budget;
    let band = (asked.doppler.is_none() && of_single.doppler > most)
        .then(|| echoes.band(&sampler, of(settings.doppler), fft_len, most))
        .flatten();
    let of_single = match band {
        Some((_, doppler)) => PredictedError { doppler: doppler + of_envelope, ..error },
        None => of_single,
    };
    let kept = sampler.kept(least_power);
    let size = Size::of(scene, generator, &settings, waveform.as_ref(), kept);
    let one_by_one = |gain_pulses: u64| {
        let chosen = EchoSettings {
            node_pulses: 1,
            epochs_per_node: 1,
            gain_pulses,
            sidelobe: None,
            sidelobe_share: 0.0,
            least_power,
            precision,
            echo: Settings { band_hz: band.map(|(band_hz, _)| band_hz), ..settings },
        };
        let prediction = Prediction { echo: of_single, ..Prediction::default() };
        Plan { asked: *asked, chosen, prediction, work: size.work(&chosen, false), size }
    };
    if exact || !sampler.interpolates() {
        let gain_pulses = asked.gain_pulses.unwrap_or(1);
        let mut plan = one_by_one(gain_pulses);
        if !exact {
            plan.chosen.node_pulses = asked.node_pulses.unwrap_or(1);
        }
        return Ok(plan);
    }

    // What is the same for all candidates.
    let culled = sampler.culled(least_power).clone();
    let bounce = 10f64.powf(WORST_BOUNCE_DB / 10.0) * super::bounce(scene, generator);
    let candidates = sampler.candidates().clone();
    let candidate_of = |n: usize| {
        let sidelobe = candidates.thresholds_db()[n].filter(|_| of_facets > 0.0);
        let sidelobe = sidelobe.map(|below_db| Sidelobe { below_db, epochs: sampler.sidelobe_epochs() });
        Candidate { n, sidelobe, sidelobe_share: sampler.sidelobe_share(n) }
    };
    // Where facets turn away single ones count.
    let may_be = |candidate: &Candidate| {
        let turns = |sidelobe: Sidelobe| sampler.turning() && sidelobe.below_db > OF_TURNING_DB;
        asked.sidelobe_db.is_some() || !candidate.sidelobe.is_some_and(turns)
    };
    // Without a sea there is nothing to be in the sidelobes.
    let first = if of_facets > 0.0 { 0 } else { candidates.thresholds_db().len() - 1 };
    let sidelobe_candidates: Vec<Candidate> =
        (first..candidates.thresholds_db().len()).map(candidate_of).filter(may_be).collect();
    let sweeps_of = |sweeps: &Sweeps| -> Vec<Gain> {
        let each = gain_steps
            .iter()
            .flat_map(|pulses| sidelobe_candidates.iter().map(|candidate| (*pulses, *candidate)));
        each.map(|(pulses, candidate)| Gain {
            pulses,
            candidate,
            swept: sweeps.swept(pulses, &candidates, candidate.n),
        })
        .collect()
    };
    let mut gains = sweeps_of(&sampler.gains(&gain_steps, LONGEST)?);
    let predict = |echo: PredictedError, left: &[InterpolationError], gain: &Gain| {
        let [path, tilt, gain, culled] = judge.worst(left, (&gain.swept, gain.pulses), &culled);
        Prediction { echo, path, tilt, gain, culled, bounce, dry_run: None }
    };
    let farthest_epoch = if sampler.turning() { farthest_epoch(scene) } else { u64::MAX };
    let prices = Prices::TABLE;
    let mut best: Option<Plan> = None;
    let settled_of =
        |node_pulses: u64, epochs_per_node: usize, gain_pulses: u64, candidate: Candidate| EchoSettings {
            node_pulses,
            epochs_per_node,
            gain_pulses,
            sidelobe: candidate.sidelobe,
            sidelobe_share: candidate.sidelobe_share,
            least_power,
            precision,
            echo: settings,
        };
    // The least that a spacing of nodes may cost: one look a node, gains as far apart and as many sidelobe tiles as the gains allow.
    let nothing = [sampler.nothing()];
    let allowed: Vec<(u64, Candidate)> = gains
        .iter()
        .filter(|gain| predict(of_single, &nothing, gain).total() <= budget)
        .map(|gain| (gain.pulses, gain.candidate))
        .collect();
    let least = |node_pulses: u64| {
        let epochs = asked.scatter_pulses.map_or(1, |pulses| epochs_of(node_pulses, pulses));
        let seconds = allowed.iter().map(|(pulses, candidate)| {
            prices.seconds(&size.work(&settled_of(node_pulses, epochs, *pulses, *candidate), true))
        });
        seconds.reduce(f64::min).unwrap_or(0.0)
    };
    for &node_pulses in &spacings {
        if best.as_ref().is_some_and(|held| held.keeps() && prices.seconds(&held.work) <= least(node_pulses))
        {
            break;
        }
        if asked.gain_pulses.is_some() {
            gains = sweeps_of(&sampler.gains(&gain_steps, block_pulses(node_pulses))?);
        }
        let of_block = echo_of(block_length(node_pulses, hold_pulses));
        let mut sounded = vec![sampler.left(0, node_pulses)?];
        let left_of = |sounded: &[Probed], epochs: usize, candidate: Candidate| -> Vec<InterpolationError> {
            sounded.iter().flat_map(|sounded| sounded.left(epochs, &candidates, candidate.n)).collect()
        };
        // Other places cost as much again: they are asked once the first allows.
        let allows = sidelobe_candidates.iter().any(|candidate| {
            (1..=EPOCHS_PER_NODE).any(|epochs| {
                let left = left_of(&sounded, epochs, *candidate);
                gains
                    .iter()
                    .filter(|gain| gain.candidate.n == candidate.n)
                    .any(|gain| predict(of_block, &left, gain).total() <= budget)
            })
        });
        if allows || spacings.len() == 1 || of_facets == 0.0 {
            let mut blocks = vec![sampler.block_of(0, node_pulses)];
            for place in 1..sampler.places() {
                let block = sampler.block_of(place, node_pulses);
                if !blocks.contains(&block) {
                    blocks.push(block);
                    sounded.push(sampler.left(place, node_pulses)?);
                }
            }
        }
        for (epochs, candidate) in (1..=EPOCHS_PER_NODE)
            .flat_map(|epochs| sidelobe_candidates.iter().map(move |candidate| (epochs, candidate)))
        {
            if asked.scatter_pulses.is_some_and(|pulses| epochs_of(node_pulses, pulses) != epochs) {
                continue;
            }
            let far = node_pulses.div_ceil(epochs as u64) > farthest_epoch && epochs < EPOCHS_PER_NODE;
            if far && asked.scatter_pulses.is_none() {
                continue;
            }
            let left = left_of(&sounded, epochs, *candidate);
            for gain in gains.iter().filter(|gain| gain.candidate.n == candidate.n) {
                // What was found for long blocks holds where six instants of gain fit in.
                let few = 3 * node_pulses < (GAIN_POINTS as u64 - 1) * gain.pulses;
                if few && gain.pulses > 1 && asked.gain_pulses.is_none() {
                    continue;
                }
                let chosen = settled_of(node_pulses, epochs, gain.pulses, *candidate);
                let prediction = predict(of_block, &left, gain);
                let work = size.work(&chosen, true);
                let plan = Plan { asked: *asked, chosen, prediction, work, size };
                let better = best.as_ref().is_none_or(|held| match (plan.keeps(), held.keeps()) {
                    (true, true) => prices.seconds(&plan.work) < prices.seconds(&held.work),
                    (false, false) => plan.prediction.total() < held.prediction.total(),
                    (keeps, _) => keeps,
                });
                if better {
                    best = Some(plan);
                }
            }
        }
    }
    let best = best.unwrap_or_else(|| one_by_one(1));
    if !best.keeps() && asked.node_pulses.is_none() {
        let plan = one_by_one(asked.gain_pulses.unwrap_or(1));
        if plan.prediction.total() < best.prediction.total() {
            return Ok(plan);
        }
    }
    Ok(best)
}

/// Most pulses from scattering epoch to the next: [`LOOKS_PER_PERIOD`] of the shortest wave, of two facets, `T = sqrt(2 pi 2 d / g)` in deep water.
fn farthest_epoch(scene: &Scene) -> u64 {
    let Some(sea) = &scene.sea else { return u64::MAX };
    let period_s = (TAU * 2.0 * sea.patch.facet_m / GRAVITY_MPS2).sqrt();
    let pulses = period_s / LOOKS_PER_PERIOD / scene.radar.emissions.interval_s(0, 1);
    (pulses.floor() as u64).max(1)
}

/// The fast echo of a scene.
struct Echoes<'a> {
    scene: &'a Scene,
    generator: &'a PathGenerator,
    waveform: &'a Arc<dyn Waveform>,
}

/// What Doppler within a pulse leaves: of facets, and of points in blocks of so many pulses.
struct DopplerError {
    of_facets: f64,
    of_points: Vec<(u64, f64)>,
}

impl DopplerError {
    /// In blocks of so many pulses.
    fn of_blocks(&self, pulses: u64) -> f64 {
        let of_points = self.of_points.iter().find(|(block, _)| *block == pulses).map_or(0.0, |(_, of)| *of);
        self.of_facets + of_points
    }
}

impl Echoes<'_> {
    /// Gridding and rounding, the worst pair, and the samples of a transform.
    fn error(
        &self,
        sampler: &ErrorSampler<'_>,
        settings: Settings,
        precision: Precision,
    ) -> Result<(PredictedError, usize), PlanError> {
        let radar = &self.scene.radar;
        let of_channels = self.generator.channel_pairs();
        let (waveform, samples) = (Arc::clone(self.waveform), radar.window.samples);
        let (carrier_hz, rate_hz) = (radar.carrier_hz, radar.sample_rate_hz);
        let cells_per_s = settings.oversampling * rate_hz;
        let half_s = 0.5 * DRIFT_PULSES * radar.emissions.interval_s(0, 1);
        let drift_cells =
            if precision == Precision::Double { 0.0 } else { sampler.fastest() * half_s * cells_per_s };
        let (fft_len, of): (usize, Box<dyn Fn(f64) -> PredictedError>) = match precision {
            Precision::Single => {
                let synth = Synth::<f32>::new(waveform, carrier_hz, rate_hz, samples, of_channels, settings)?;
                (synth.fft_len(), Box::new(move |mean| synth.predicted_error_of(mean, 0.0, drift_cells)))
            }
            Precision::Double => {
                let synth = Synth::<f64>::new(waveform, carrier_hz, rate_hz, samples, of_channels, settings)?;
                (synth.fft_len(), Box::new(move |mean| synth.predicted_error_of(mean, 0.0, drift_cells)))
            }
        };
        let means = sampler.dopplers().into_iter().map(|(mean_hz, _)| mean_hz);
        let errors = [0.0].into_iter().chain(means).map(of);
        let worst = errors.max_by(|a, b| a.total_db().total_cmp(&b.total_db())).unwrap_or_default();
        // What is in proportion to a pulse weighs as the strongest one. The first two images of a point may be in phase.
        let peak = sampler.peak([1.0, 2.0]).max(1.0);
        let rounding = peak * (worst.rounding + OF_SAMPLES);
        Ok((PredictedError { gridding: peak * worst.gridding, rounding, doppler: 0.0 }, fft_len))
    }

    /// What rigid envelopes leave where everything has the largest rate of a delay.
    fn rigid_error(&self, sampler: &ErrorSampler<'_>, fft_len: usize) -> f64 {
        let radar = &self.scene.radar;
        let of = |rate: f64| {
            let waveform = self.waveform.as_ref();
            rigid_error_power(waveform, radar.carrier_hz, radar.sample_rate_hz, fft_len, rate)
        };
        let fastest = sampler.fastest();
        sampler.peak([1.0, 1.0]).max(1.0) * of(fastest).max(of(-fastest))
    }

    /// Widest bands of Doppler that leave no more than `most`, Hz, and what they leave; `None` where none do.
    fn band(
        &self,
        sampler: &ErrorSampler<'_>,
        doppler: (Doppler, Envelope),
        fft_len: usize,
        most: f64,
    ) -> Option<(f64, f64)> {
        let radar = &self.scene.radar;
        let (waveform, rate_hz) = (self.waveform.as_ref(), radar.sample_rate_hz);
        let means: Vec<f64> = sampler.dopplers().into_iter().map(|(mean_hz, _)| mean_hz).collect();
        let peak = sampler.peak([1.0, 1.0]).max(1.0);
        // The strongest scatterer path of a band may lie at one end of it, and another at the other.
        let left = |band_hz: f64| {
            let of = |mean_hz: f64, off_hz: f64| {
                error_power(doppler, waveform, radar.carrier_hz, rate_hz, fft_len, mean_hz, off_hz)
            };
            let both = means.iter().map(|mean_hz| of(*mean_hz, band_hz).max(of(*mean_hz, -band_hz)));
            peak * both.fold(0.0, f64::max)
        };
        let widest_hz = 2.0 * radar.carrier_hz * sampler.fastest();
        let (mut low, mut high) = (1e-7 * widest_hz, widest_hz);
        if !(low > 0.0 && left(low) <= most) {
            return None;
        }
        while high > 1.1 * low {
            let middle = (low * high).sqrt();
            *(if left(middle) <= most { &mut low } else { &mut high }) = middle;
        }
        Some((low, left(low)))
    }

    /// Doppler, the worst pair, in blocks of so many pulses each.
    fn doppler_error(
        &self,
        sampler: &mut ErrorSampler<'_>,
        doppler: (Doppler, Envelope),
        fft_len: usize,
        blocks: &[u64],
    ) -> Result<DopplerError, PlanError> {
        let radar = &self.scene.radar;
        let (waveform, rate_hz) = (self.waveform.as_ref(), radar.sample_rate_hz);
        let off_mean = |mean_hz: f64, off_hz: f64| {
            error_power(doppler, waveform, radar.carrier_hz, rate_hz, fft_len, mean_hz, off_hz)
        };
        let dopplers = sampler.dopplers();
        let of_pair = |(mean_hz, groups): &(f64, Vec<f64>)| {
            let sum: f64 = groups.iter().map(|off_hz| off_mean(*mean_hz, *off_hz)).sum();
            sum / groups.len().max(1) as f64
        };
        let of_facets = sampler.peak([1.0, 0.0]) * dopplers.iter().map(of_pair).fold(0.0, f64::max);
        if self.generator.point_count() == 0 {
            return Ok(DopplerError { of_facets, of_points: Vec::new() });
        }
        let law = Law::new(2.0 * radar.carrier_hz * sampler.fastest(), |off_hz| off_mean(0.0, off_hz));
        Ok(DopplerError { of_facets, of_points: sampler.doppler_of_points(&law, blocks)? })
    }
}
