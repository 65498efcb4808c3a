//! From what is asked to what is set: the cheapest settings whose predicted error keeps the budget.
//!
//! Settings that are given stay. For the others there are candidates, from far to close nodes; the error of
//! each is [probed](super::probe) until closer nodes cost more than what was found already. A budget at or
//! below [`EXACT_DB`](super::budget::EXACT_DB) takes pulses one by one with exact scatterer paths in f64, and
//! so does a scene that no candidate serves. Facets may be left out while all of them together stay
//! [`CULLED_DB`](super::budget::CULLED_DB) below the budget. Nodes of panels of ships lie as far apart as
//! leaves [`PANELS_DB`] below it: the price of a panel falls with that distance, what is left rises with its
//! eighth power.

use super::budget::{Budget, PANELS_DB, Plan};
use std::sync::Arc;

use super::cost::Size;
use super::echo_settings::{EchoSettings, block_length};
use super::probe::ErrorSampler;
use super::search::Search;
use super::synth_choice::Echoes;
use super::{PlanError, Prediction};
use crate::echo::Asked;
use crate::paths::PathGenerator;
use crate::paths::block::NODES;
use crate::radar::waveform::Waveform;
use crate::scene::Scene;

/// Spacings of the nodes, pulses.
const NODE_PULSES: [u64; 9] = [21, 16, 12, 9, 7, 5, 4, 3, 2];
/// Pulses from gain epoch to gain epoch.
const GAIN_PULSES: [u64; 9] = [12, 10, 8, 6, 5, 4, 3, 2, 1];
/// Pulses from node to node of the panels of ships.
const PANEL_PULSES: [u64; 12] = [21, 16, 12, 10, 8, 7, 6, 5, 4, 3, 2, 1];

/// The spacing that nodes then have, pulses.
fn spacing_within(spacing: u64, hold_pulses: Option<u64>) -> u64 {
    (block_length(spacing, hold_pulses) - 1).div_ceil(NODES as u64 - 1).max(1)
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

/// What is asked that a sample depends on: sidelobe threshold, pulses of gains and of panels.
type Given = (Option<f64>, [Option<u64>; 2]);

fn given(asked: &Asked) -> Given {
    (asked.sidelobe_db, [asked.gain_pulses, asked.panel_pulses])
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
        let mut sampler =
            ErrorSampler::new(generator, &scene.radar, waveform.as_ref(), scene.pulses, asked.sidelobe_db)?;
        // No interpolation knows of a jump, and probes may miss it.
        let free: &[u64] = if generator.aim_jumps() { &[1] } else { &GAIN_PULSES };
        let gain_steps: Vec<u64> = asked.gain_pulses.map_or(free.to_vec(), |pulses| vec![pulses]);
        let free: &[u64] = if generator.aim_jumps() { &[1] } else { &PANEL_PULSES };
        let panel_steps: Vec<u64> = asked.panel_pulses.map_or(free.to_vec(), |pulses| vec![pulses]);
        sampler.follow_points(&gain_steps, &panel_steps)?;
        Ok(Self { scene, generator, waveform, sampler, given: given(asked), gain_steps })
    }

    /// Chooses what is not given.
    ///
    /// # Errors
    /// A scene whose tracks end early, or that the fast echo cannot make.
    pub fn choose(&mut self, asked: &Asked) -> Result<Plan, PlanError> {
        if given(asked) == self.given {
            return self.choose_given(asked);
        }
        Self::new(self.scene, self.generator, self.waveform, asked)?.choose_given(asked)
    }

    fn choose_given(&mut self, asked: &Asked) -> Result<Plan, PlanError> {
        let Self { scene, generator, waveform, ref mut sampler, ref gain_steps, .. } = *self;
        let budget = Budget::of(asked);
        let panel_pulses = sampler.choose_panel_pulses(10f64.powf((asked.error_db - PANELS_DB) / 10.0));

        let hold_pulses = generator.hold_pulses();
        let spacings = spacings(asked, hold_pulses);
        let lengths =
            spacings.iter().filter(|_| !budget.exact).map(|pulses| block_length(*pulses, hold_pulses));
        let blocks: Vec<u64> = [1].into_iter().chain(lengths).collect();
        let synth = Echoes { scene, generator, waveform }.choose(sampler, &budget, &blocks)?;
        let kept = sampler.kept(budget.least_power);
        let size = Size::of(scene, generator, &synth.settings, waveform.as_ref(), kept);
        let one_by_one = |gain_pulses: u64| {
            let chosen = EchoSettings {
                node_pulses: 1,
                epochs_per_node: 1,
                gain_pulses,
                panel_pulses,
                sidelobe: None,
                sidelobe_share: 0.0,
                least_power: budget.least_power,
                precision: budget.precision,
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
            (budget, &synth, size),
            (gain_steps.clone(), panel_pulses),
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

/// Spacings of the nodes that come into question, from far to close, pulses.
fn spacings(asked: &Asked, hold_pulses: Option<u64>) -> Vec<u64> {
    let mut spacings: Vec<u64> = asked.node_pulses.map_or(NODE_PULSES.to_vec(), |pulses| vec![pulses]);
    spacings.iter_mut().for_each(|pulses| *pulses = spacing_within(*pulses, hold_pulses));
    spacings.dedup();
    spacings.retain(|pulses| *pulses > 1);
    spacings
}
