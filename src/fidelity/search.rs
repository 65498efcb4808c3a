//! The cheapest nodes, scattering epochs, gain epochs and sidelobe threshold whose predicted error keeps the
//! budget.

use std::f64::consts::TAU;
use std::rc::Rc;

use super::cost::{CostTable, Size};
use super::echo_settings::{EchoSettings, block_length, block_pulses};
use super::probe::{ErrorSampler, InterpolationError, Omission, Powers, Probed, Sweeps, Swept};
use super::sidelobe::Candidates;
use super::synth_choice::SynthChoice;
use super::{PlanError, Prediction};
use crate::echo::synth::PredictedError;
use crate::fidelity::budget::{Budget, Plan};
use crate::paths::PathGenerator;
use crate::paths::block::{EPOCHS_PER_NODE, Fine, GAIN_POINTS, Sidelobe, WAKE_EPOCHS};
use crate::scene::Scene;
use crate::sea::GRAVITY_MPS2;

/// Fewest scattering epochs in a period of the shortest waves of the surface, where facets turn away. When a
/// facet turned between two epochs is known to a part of their interval only, and single facets make the
/// worst pulses at grazing incidence.
const EPOCHS_PER_PERIOD: f64 = 30.0;

/// Where facets turn away, no tile above this gain, dB, is a sidelobe tile: a single facet whose turn is
/// found late makes the worst pulse (grazing seas of 64 x 64 facets, -67.4 dB where -67.8 were predicted with
/// tiles in the sidelobes below -25 dB).
const OF_TURNING_DB: f64 = -40.0;

/// What the acceleration of the water adds in the worst pulse to its mean, dB: the worst of 48 pulses from
/// 800 km is 4.7 dB above it (`tests/data/scenarios/orbit.toml`, -54.4 against -59.2 dB of the closed form).
const WORST_BOUNCE_DB: f64 = 5.0;

/// Scattering epochs from node to node that come nearest to what is asked.
fn epochs_of(node_pulses: u64, scatter_pulses: u64) -> usize {
    node_pulses.div_ceil(scatter_pulses.max(1)).clamp(1, EPOCHS_PER_NODE as u64) as usize
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

/// A two-way gain below which tiles are sidelobe tiles.
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

/// What is the same for all candidates.
pub(super) struct Search<'a> {
    budget: Budget,
    synth: &'a SynthChoice,
    size: Size,
    gain_steps: Vec<u64>,
    panel_pulses: Option<u64>,
    fine_surface: bool,
    candidates: Candidates,
    thresholds: Vec<Candidate>,
    power: Powers,
    omission: Omission,
    in_flight: f64,
    hold_pulses: Option<u64>,
    overlap_pulses: u64,
    has_sea: bool,
    has_wakes: bool,
    farthest_epoch: u64,
    /// What tiles may lack at their supports alone, and that in the strongest pulse.
    between: Option<f64>,
    between_of_strongest: f64,
}

impl<'a> Search<'a> {
    pub fn new(
        scene: &Scene,
        generator: &PathGenerator,
        sampler: &mut ErrorSampler<'_>,
        (budget, synth, size, omission): (Budget, &'a SynthChoice, Size, Omission),
        (gain_steps, panel_pulses, fine_surface): (Vec<u64>, Option<u64>, bool),
    ) -> Self {
        let has_sea = generator.facets() > 0;
        let candidates = sampler.candidates().clone();
        let of = |n: usize| {
            let sidelobe = candidates.thresholds_db()[n].filter(|_| has_sea);
            let (epochs, cutoff_db) = (sampler.sidelobe_epochs(), omission.cutoff_db);
            let sidelobe = sidelobe.map(|below_db| Sidelobe { below_db, epochs, cutoff_db });
            Candidate { n, sidelobe, sidelobe_share: sampler.sidelobe_share(n) }
        };
        // Where facets turn away single ones count.
        let may_be = |candidate: &Candidate| {
            let turns = |sidelobe: Sidelobe| sampler.turning() && sidelobe.below_db > OF_TURNING_DB;
            budget.asked.sidelobe_db.is_some() || !candidate.sidelobe.is_some_and(turns)
        };
        let between = sampler.between(budget.power);
        // Without a sea there are no tiles.
        let first = if has_sea { 0 } else { candidates.thresholds_db().len() - 1 };
        let thresholds = (first..candidates.thresholds_db().len()).map(of).filter(may_be).collect();
        Self {
            budget,
            synth,
            size,
            gain_steps,
            panel_pulses,
            fine_surface,
            thresholds,
            candidates,
            power: sampler.power().clone(),
            omission,
            in_flight: 10f64.powf(WORST_BOUNCE_DB / 10.0) * super::in_flight(scene, generator),
            hold_pulses: generator.hold_pulses(),
            overlap_pulses: generator.overlap_pulses().unwrap_or(0),
            has_sea,
            has_wakes: generator.has_short_waves(),
            between,
            between_of_strongest: between.unwrap_or(0.0) * sampler.peak([1.0, 0.0]).max(1.0),
            farthest_epoch: if sampler.turning() { farthest_epoch(scene) } else { u64::MAX },
        }
    }

    /// The cheapest plan that keeps the budget, else that of the least error; spacings of the nodes from far
    /// to close, pulses.
    ///
    /// # Errors
    /// Tracks that end early, or settings that the fast echo refuses.
    pub fn best(&self, sampler: &mut ErrorSampler<'_>, spacings: &[u64]) -> Result<Option<Plan>, PlanError> {
        let mut gains = self.gains_of(&sampler.gains(&self.gain_steps, sampler.longest())?);
        let nothing = [sampler.nothing()];
        let allowed: Vec<(u64, Candidate)> = gains
            .iter()
            .filter(|gain| self.keeps(self.synth.single_error, &nothing, gain))
            .map(|gain| (gain.pulses, gain.candidate))
            .collect();
        let mut best: Option<Plan> = None;
        for &node_pulses in spacings {
            let done = |held: &Plan| held.keeps() && held.seconds() <= self.least_s(node_pulses, &allowed);
            if best.as_ref().is_some_and(done) {
                break;
            }
            if self.budget.asked.gain_pulses.is_some() {
                gains = self.gains_of(&sampler.gains(&self.gain_steps, block_pulses(node_pulses))?);
            }
            let echo = self.synth.error_of(block_length(node_pulses, self.overlap_pulses, self.hold_pulses));
            let probed = self.probe(sampler, node_pulses, (echo, &gains), spacings.len() == 1)?;
            for plan in self.plans(node_pulses, echo, &probed, &gains) {
                if best.as_ref().is_none_or(|held| better(&plan, held)) {
                    best = Some(plan);
                }
            }
        }
        Ok(best)
    }

    /// Interpolation errors at every probe. Other places cost as much again as the first: they are asked once
    /// it allows.
    fn probe(
        &self,
        sampler: &mut ErrorSampler<'_>,
        node_pulses: u64,
        (echo, gains): (PredictedError, &[Gain]),
        only: bool,
    ) -> Result<Vec<Rc<Probed>>, PlanError> {
        let mut probed = vec![sampler.left(0, node_pulses)?];
        let allows = self.thresholds.iter().any(|candidate| {
            (1..=EPOCHS_PER_NODE).any(|epochs| {
                let closest = self.wake_epochs(epochs).last().copied().flatten();
                let left = self.left(&probed, (epochs, closest), candidate);
                let mut of_candidate = gains.iter().filter(|gain| gain.candidate.n == candidate.n);
                of_candidate.any(|gain| self.keeps(echo, &left, gain))
            })
        });
        if allows || only || !self.has_sea {
            let mut blocks = vec![sampler.block_of(0, node_pulses)];
            for place in 1..sampler.places() {
                let block = sampler.block_of(place, node_pulses);
                if !blocks.contains(&block) {
                    blocks.push(block);
                    probed.push(sampler.left(place, node_pulses)?);
                }
            }
        }
        Ok(probed)
    }

    /// Plans of one spacing of the nodes.
    fn plans(
        &self,
        node_pulses: u64,
        echo: PredictedError,
        probed: &[Rc<Probed>],
        gains: &[Gain],
    ) -> Vec<Plan> {
        let asked = &self.budget.asked;
        let mut plans = Vec::new();
        for epochs in 1..=EPOCHS_PER_NODE {
            let other = |pulses: u64| epochs_of(node_pulses, pulses) != epochs;
            let far = node_pulses.div_ceil(epochs as u64) > self.farthest_epoch && epochs < EPOCHS_PER_NODE;
            if asked.scatter_pulses.map_or(far, other) {
                continue;
            }
            let wake_epochs = self.wake_epochs(epochs);
            let each = wake_epochs.iter().flat_map(|own| self.thresholds.iter().map(|c| (*own, c)));
            for (wake_epochs, candidate) in each {
                let left = self.left(probed, (epochs, wake_epochs), candidate);
                for gain in gains.iter().filter(|gain| gain.candidate.n == candidate.n) {
                    // What was found for long blocks holds where six instants of gain fit in.
                    let few = 3 * node_pulses < (GAIN_POINTS as u64 - 1) * gain.pulses;
                    if few && gain.pulses > 1 && asked.gain_pulses.is_none() {
                        continue;
                    }
                    let mut chosen = self.settings(node_pulses, epochs, gain.pulses, candidate);
                    let share = probed.iter().map(|probed| probed.wake_share()).fold(0.0, f64::max);
                    (chosen.wake_epochs, chosen.wake_share) = (wake_epochs, share);
                    let (prediction, work) = (self.predict(echo, &left, gain), self.size.work(&chosen, true));
                    plans.push(Plan { asked: *asked, chosen, prediction, work, size: self.size });
                }
            }
        }
        plans
    }

    /// The least that a spacing of nodes may cost, s per pulse: one scattering epoch a node, gains as far
    /// apart and as many sidelobe tiles as the gains allow.
    fn least_s(&self, node_pulses: u64, allowed: &[(u64, Candidate)]) -> f64 {
        let epochs = self.budget.asked.scatter_pulses.map_or(1, |pulses| epochs_of(node_pulses, pulses));
        let seconds = allowed.iter().map(|(pulses, candidate)| {
            let chosen = self.settings(node_pulses, epochs, *pulses, candidate);
            CostTable::TABLE.seconds(&self.size.work(&chosen, true))
        });
        seconds.reduce(f64::min).unwrap_or(0.0)
    }

    fn gains_of(&self, sweeps: &Sweeps) -> Vec<Gain> {
        let each = self.gain_steps.iter().flat_map(|pulses| self.thresholds.iter().map(|c| (*pulses, *c)));
        let of = |(pulses, candidate): (u64, Candidate)| {
            let swept = sweeps.swept(pulses, &self.candidates, candidate.n);
            Gain { pulses, candidate, swept }
        };
        each.map(of).collect()
    }

    /// Scattering epochs that wake tiles may have, where others have so many.
    fn wake_epochs(&self, epochs: usize) -> Vec<Option<usize>> {
        if self.has_wakes {
            WAKE_EPOCHS.into_iter().filter(|own| *own >= epochs).map(Some).collect()
        } else {
            vec![None]
        }
    }

    fn left(
        &self,
        probed: &[Rc<Probed>],
        epochs: (usize, Option<usize>),
        candidate: &Candidate,
    ) -> Vec<InterpolationError> {
        probed.iter().flat_map(|probed| probed.left(epochs, &self.candidates, candidate.n)).collect()
    }

    fn settings(
        &self,
        node_pulses: u64,
        epochs_per_node: usize,
        gain_pulses: u64,
        candidate: &Candidate,
    ) -> EchoSettings {
        EchoSettings {
            node_pulses,
            overlap_pulses: self.overlap_pulses,
            epochs_per_node,
            wake_epochs: None,
            wake_share: 0.0,
            gain_pulses,
            panel_pulses: self.panel_pulses,
            sidelobe: candidate.sidelobe,
            sidelobe_share: candidate.sidelobe_share,
            beyond_share: candidate.sidelobe.map_or(0.0, |_| self.omission.beyond_share),
            between: self.between,
            least_power: self.omission.least_power,
            turning: self.budget.turning(),
            precision: self.budget.precision,
            fine: Fine { surface: self.fine_surface, shadows: self.budget.needs_exact_shadows() },
            echo: self.synth.settings,
        }
    }

    fn predict(&self, echo: PredictedError, left: &[InterpolationError], gain: &Gain) -> Prediction {
        let judge = Judge { power: &self.power };
        let [path, tilt, gain, culled] = judge.worst(left, (&gain.swept, gain.pulses), &self.omission.power);
        let between = self.between_of_strongest;
        let in_flight = self.in_flight;
        Prediction { echo, path, tilt, gain, culled, between, in_flight, ..Prediction::default() }
    }

    fn keeps(&self, echo: PredictedError, left: &[InterpolationError], gain: &Gain) -> bool {
        self.predict(echo, left, gain).total() <= self.budget.power
    }
}

/// The cheaper of two that keep the budget; of others that of the least error.
fn better(plan: &Plan, held: &Plan) -> bool {
    match (plan.keeps(), held.keeps()) {
        (true, true) => plan.seconds() < held.seconds(),
        (false, false) => plan.prediction.total() < held.prediction.total(),
        (keeps, _) => keeps,
    }
}

/// Most pulses from one scattering epoch to the next: [`EPOCHS_PER_PERIOD`] of the shortest wave, of two
/// facets, `T = sqrt(2 pi 2 d / g)` in deep water.
fn farthest_epoch(scene: &Scene) -> u64 {
    let Some(sea) = &scene.sea else { return u64::MAX };
    let period_s = (TAU * 2.0 * sea.patch.facet_m / GRAVITY_MPS2).sqrt();
    let pulses = period_s / EPOCHS_PER_PERIOD / scene.radar.emissions.mean_pri_s();
    (pulses.floor() as u64).max(1)
}
