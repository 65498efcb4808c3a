//! From what is asked to what is set: the cheapest settings whose predicted error keeps the budget.
//!
//! Settings that are given stay. For the others there are candidates, from far to close nodes; the error of
//! each is [probed](super::probe) until closer nodes cost more than what was found already. A budget at or
//! below [`EXACT_DB`](super::budget::EXACT_DB) takes pulses one by one with exact scatterer paths in f64, and
//! so does a scene that no candidate serves. Facets may be left out while all of them together stay
//! [`CULLED_DB`](super::budget::CULLED_DB) below the budget. Nodes of panels of ships lie as far apart as
//! leaves [`PANELS_DB`] below it: the price of a panel falls with that distance, what is left rises with its
//! eighth power.

use super::budget::{Budget, PANELS_DB, Plan, may_have_fine_surface};
use std::sync::Arc;

use super::cost::Size;
use super::echo_settings::{EchoSettings, block_length, block_pulses};
use super::probe::{ErrorSampler, is_coarse, unit_of};
use super::search::Search;
use super::synth_choice::Echoes;
use super::{PlanError, Prediction};
use crate::echo::Asked;
use crate::echo::synth::block::MAX_PULSES;
use crate::paths::PathGenerator;
use crate::paths::block::{Fine, Least, NODES};
use crate::radar::waveform::Waveform;
use crate::scene::Scene;

/// Spacings of the nodes, units of pulses.
const NODE_PULSES: [u64; 14] = [21, 18, 16, 14, 12, 10, 9, 8, 7, 6, 5, 4, 3, 2];
/// Units from gain epoch to gain epoch.
const GAIN_PULSES: [u64; 9] = [12, 10, 8, 6, 5, 4, 3, 2, 1];
/// Units from node to node of the panels of ships.
const PANEL_PULSES: [u64; 12] = [21, 16, 12, 10, 8, 7, 6, 5, 4, 3, 2, 1];

/// Where the farthest point of the patch is so many times as far from an antenna as the nearest, a few facets
/// return most, and a sample says little of them: nodes then lie as close as at low PRFs, whatever it says.
const UNEVEN: f64 = 4.0;

/// The spacing that nodes then have, pulses.
fn spacing_within(spacing: u64, overlap: u64, hold_pulses: Option<u64>) -> u64 {
    let emissions = (block_length(spacing, overlap, hold_pulses) + overlap).min(block_pulses(spacing));
    (emissions - 1).div_ceil(NODES as u64 - 1).max(1)
}

/// Chooses the settings of a scene for one error after another: what does not depend on the error is found
/// once.
pub struct Chooser<'a> {
    scene: &'a Scene,
    generator: &'a PathGenerator,
    waveform: &'a Arc<dyn Waveform>,
    sampler: ErrorSampler<'a>,
    given: Given,
    gain_steps: Vec<u64>,
}

/// What is asked that a sample depends on: thresholds of sidelobe tiles and of those left out, pulses of
/// gains and of panels, precision of the surface, length of units.
type Given = ([Option<f64>; 2], [Option<u64>; 2], [bool; 2]);

fn given(asked: &Asked, fine_surface: bool) -> Given {
    let steps = [asked.gain_pulses, asked.panel_pulses];
    ([asked.sidelobe_db, asked.cutoff_db], steps, [fine_surface, is_coarse(asked.error_db)])
}

impl<'a> Chooser<'a> {
    /// For what is asked, whatever the error.
    ///
    /// # Errors
    /// A scene whose tracks end early.
    pub fn new(
        scene: &'a Scene,
        generator: &'a PathGenerator,
        waveform: &'a Arc<dyn Waveform>,
        asked: &Asked,
    ) -> Result<Self, PlanError> {
        Self::with_surface(scene, generator, waveform, asked, false)
    }

    fn with_surface(
        scene: &'a Scene,
        generator: &'a PathGenerator,
        waveform: &'a Arc<dyn Waveform>,
        asked: &Asked,
        fine_surface: bool,
    ) -> Result<Self, PlanError> {
        // Steps that are given need not be whole units.
        let whole = asked.gain_pulses.or(asked.panel_pulses).is_none() && generator.range_ratio()? <= UNEVEN;
        let unit = if whole { unit_of(&scene.radar, scene.pulses, is_coarse(asked.error_db)) } else { 1 };
        let of_run = (scene.pulses, unit);
        let mut sampler = ErrorSampler::new(
            generator,
            &scene.radar,
            waveform.as_ref(),
            of_run,
            (asked.sidelobe_db, asked.cutoff_db, fine_surface),
        )?;
        // No interpolation knows of a jump, and probes may miss it.
        let free = |steps: &[u64]| if generator.aim_jumps() { vec![1] } else { in_units(steps, unit, 1) };
        // Nor of a beam that passes over a target within a unit.
        let of_gains = || if generator.scans() { vec![1] } else { free(&GAIN_PULSES) };
        let gain_steps = asked.gain_pulses.map_or_else(of_gains, |pulses| vec![pulses]);
        let panel_steps = asked.panel_pulses.map_or_else(|| free(&PANEL_PULSES), |pulses| vec![pulses]);
        sampler.follow_points(&gain_steps, &panel_steps)?;
        Ok(Self { scene, generator, waveform, sampler, given: given(asked, fine_surface), gain_steps })
    }

    /// Chooses what is not given.
    ///
    /// # Errors
    /// A scene whose tracks end early, or that the fast echo cannot make.
    pub fn choose(&mut self, asked: &Asked) -> Result<Plan, PlanError> {
        let plan = self.choose_by(asked, false)?;
        // Where heights in f32 keep no nodes: those in f64 may.
        if plan.chosen.node_pulses > 1 || !may_have_fine_surface(asked) || !self.sampler.interpolates() {
            return Ok(plan);
        }
        let fine = self.choose_by(asked, true)?;
        let is_better = fine.keeps() && fine.chosen.node_pulses > 1;
        Ok(if is_better { fine } else { plan })
    }

    /// Pulses of the run and their power by channel, and the mean over the run, in one unit, the strongest
    /// first; empty where no antenna scans.
    pub fn scanned(&self) -> (&[(u64, Vec<f64>)], &[f64]) {
        (self.sampler.scanned(), self.sampler.power())
    }

    fn choose_by(&mut self, asked: &Asked, fine_surface: bool) -> Result<Plan, PlanError> {
        let Self { scene, generator, waveform, .. } = *self;
        if given(asked, fine_surface) == self.given {
            return self.choose_given(asked);
        }
        let mut other = Self::with_surface(scene, generator, waveform, asked, fine_surface)?;
        other.choose_given(asked)
    }

    fn choose_given(&mut self, asked: &Asked) -> Result<Plan, PlanError> {
        let Self { scene, generator, waveform, ref mut sampler, ref gain_steps, .. } = *self;
        let budget = Budget::of(asked);
        let panel_pulses = sampler.choose_panel_pulses(10f64.powf((asked.error_db - PANELS_DB) / 10.0));

        let (hold_pulses, overlap_pulses) =
            (generator.hold_pulses(), generator.overlap_pulses().unwrap_or(0));
        let most = most_pulses(scene, generator, waveform.as_ref());
        let spacings = spacings(asked, (overlap_pulses, hold_pulses), (sampler.unit(), most));
        let length = |pulses: &u64| block_length(*pulses, overlap_pulses, hold_pulses);
        let lengths = spacings.iter().filter(|_| !budget.exact).map(length);
        let blocks: Vec<u64> = [1].into_iter().chain(lengths).collect();
        let synth = Echoes { scene, generator, waveform }.choose(sampler, &budget, &blocks)?;
        let omission = sampler.omission(&budget);
        let size = Size::of(scene, generator, &synth.settings, waveform.as_ref(), omission.kept);
        let one_by_one = |gain_pulses: u64| {
            let chosen = EchoSettings {
                node_pulses: 1,
                overlap_pulses,
                epochs_per_node: 1,
                wake_epochs: None,
                wake_share: 0.0,
                gain_pulses,
                panel_pulses,
                sidelobe: None,
                sidelobe_share: 0.0,
                beyond_share: 0.0,
                between: None,
                least_power: Least { facet: budget.least_power, part: budget.least_power },
                turning: budget.turning(),
                precision: budget.precision,
                fine: Fine { surface: false, shadows: true },
                echo: synth.single,
            };
            let prediction = Prediction { echo: synth.single_error, ..Prediction::default() };
            Plan { asked: *asked, chosen, prediction, work: size.work(&chosen, false), size }
        };
        if budget.exact || !sampler.interpolates() {
            let mut plan = one_by_one(asked.gain_pulses.unwrap_or(1));
            if !budget.exact {
                plan.chosen.node_pulses = asked.node_pulses.unwrap_or(1);
            }
            return Ok(plan);
        }

        let search = Search::new(
            scene,
            generator,
            sampler,
            (budget, &synth, size, omission),
            (gain_steps.clone(), panel_pulses, self.given.2[0]),
        );
        let best = search.best(sampler, &spacings)?.unwrap_or_else(|| one_by_one(1));
        if !best.keeps() && asked.node_pulses.is_none() {
            let plan = one_by_one(asked.gain_pulses.unwrap_or(1));
            if plan.prediction.total() < best.prediction.total() {
                return Ok(plan);
            }
        }
        Ok(best)
    }
}

/// Steps of so many units as pulses, from far to close, and closer ones of pulses, down to `least`.
fn in_units(steps: &[u64], unit: u64, least: u64) -> Vec<u64> {
    let closest = unit * steps.last().copied().unwrap_or(1);
    let closer = steps.iter().copied().filter(|pulses| *pulses < closest && unit > 1);
    let closer = closer.filter(|pulses| least > 1 || *pulses == 1);
    steps.iter().map(|units| units * unit).chain(closer).collect()
}

/// Bytes of the grids of a block of more pulses than [`NODE_PULSES`] ask for.
const GRID_BYTES: usize = 64 << 20;

/// Most pulses of a block whose grids are no larger than [`GRID_BYTES`]; of a continuous signal, emissions.
pub(crate) fn most_pulses(scene: &Scene, generator: &PathGenerator, waveform: &dyn Waveform) -> u64 {
    let radar = &scene.radar;
    // Of a continuous signal grids are those of emissions.
    let delays_s = generator.delay_span_of_run_s().ok().flatten().filter(|_| waveform.is_stream());
    let received = delays_s.map_or(radar.window.samples, |(least_s, most_s)| {
        ((most_s - least_s) * radar.sample_rate_hz).ceil() as usize
    });
    let samples = received + waveform.span_samples(radar.sample_rate_hz) + 64;
    // Two cells a sample, real and imaginary; lanes are a power of two.
    let lanes = 2 * radar.channels.len().max(generator.pairs().len()).next_power_of_two();
    let of_pulse = 2 * samples.saturating_mul(lanes) * size_of::<f32>();
    (GRID_BYTES / of_pulse.max(1)).clamp(1, MAX_PULSES) as u64
}

/// Spacings of the nodes that come into question, from far to close, pulses; of a unit of pulses, and blocks
/// of no more than so many.
fn spacings(asked: &Asked, (overlap, hold_pulses): (u64, Option<u64>), (unit, most): (u64, u64)) -> Vec<u64> {
    let free = || in_units(&NODE_PULSES, unit, 2);
    let mut spacings: Vec<u64> = asked.node_pulses.map_or_else(free, |pulses| vec![pulses]);
    if asked.node_pulses.is_none() {
        let farthest = NODE_PULSES[0].max((most - 1) / (NODES as u64 - 1));
        // Blocks of which most are emissions of before are not worth their nodes.
        spacings.retain(|pulses| *pulses <= farthest && block_pulses(*pulses) > 2 * overlap);
    }
    spacings.iter_mut().for_each(|pulses| *pulses = spacing_within(*pulses, overlap, hold_pulses));
    spacings.dedup();
    spacings.retain(|pulses| *pulses > 1);
    spacings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_whole_units_and_closer_ones_single_pulses() {
        assert_eq!(in_units(&NODE_PULSES, 1, 2), NODE_PULSES);
        assert_eq!(in_units(&GAIN_PULSES, 1, 1), GAIN_PULSES);
        let steps = [84, 72, 64, 56, 48, 40, 36, 32, 28, 24, 20, 16, 12, 8, 7, 6, 5, 4, 3, 2];
        assert_eq!(in_units(&NODE_PULSES, 4, 2), steps);
        assert_eq!(in_units(&[3, 2, 1], 4, 1), [12, 8, 4, 1]);
    }
}
