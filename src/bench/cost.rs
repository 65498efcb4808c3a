//! What pieces of work take on this machine: a short calibration for the prediction of speed.
//!
//! All workers of a stream make blocks at once, each at its own pace, with other settings than those planned
//! (nodes half as far apart); what each stage took over what the cost table has scales the costs of that
//! stage. Every worker makes [`ROUNDS`] blocks that count, and one before, for its memory. Blocks are from
//! the whole run, so their mean counts and not their median: a run may cost more at one end than at the
//! other. Where the patch follows they are the first ones, one after the other, for neighbours share updates
//! of the shadows.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::fidelity::budget::Plan;
use crate::fidelity::cost::CostTable;
use crate::fidelity::echo_settings::EchoSettings;
use crate::pipeline::build::PulseStream;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::fault::PulseError;
use crate::pipeline::stages::Worker;
use crate::pulse::Pulse;
use crate::pulse::costs::{Costs, Stage};

/// Blocks of a worker that count.
pub const ROUNDS: usize = 5;
/// Stages with costs.
const COSTED: [Stage; 6] =
    [Stage::Surface, Stage::Shadow, Stage::ScattererPaths, Stage::Spread, Stage::Transform, Stage::Receive];

/// Speed as predicted.
#[derive(Clone, Copy, Debug)]
pub struct Calibrated {
    /// Real-time factor by the costs of a common machine.
    pub list_factor: f64,
    /// Real-time factor as calibrated on this one.
    pub factor: f64,
    /// Seconds of one worker for a pulse, calibrated; records go with receiving, filling with spreading.
    pub stages_s: [(Stage, f64); COSTED.len()],
}

impl PulseStream {
    /// Speed as predicted; `None` for the reference.
    ///
    /// # Errors
    /// A pulse that cannot be made.
    pub fn calibrated(&self) -> Result<Option<Calibrated>, BuildErrors> {
        let Some(plan) = self.factory().plan() else { return Ok(None) };
        let cost_table = self.cost_table(plan)?;
        let prf_hz = self.schedule().times.mean_prf_hz();
        let pulses = self.schedule().count;
        // A run shorter than a block is taken as it is.
        let block = self.factory().block_pulses().min(pulses);
        let workers = busy_workers(pulses, block, self.threads() as u64);
        let factor = |cost_table: CostTable| workers / cost_table.seconds(&plan.work) / prf_hz;
        Ok(Some(Calibrated {
            list_factor: factor(CostTable::TABLE),
            factor: factor(cost_table),
            stages_s: COSTED.map(|stage| (stage, cost_table.stage_seconds(&plan.work, stage))),
        }))
    }

    /// Costs of this machine.
    fn cost_table(&self, plan: &Plan) -> Result<CostTable, BuildErrors> {
        let chosen = EchoSettings { node_pulses: (plan.chosen.node_pulses / 2).max(2), ..plan.chosen };
        let interpolates = !plan.work.is_one_by_one();
        let other = if interpolates { self.factory().with_nodes(&chosen) } else { None };
        let (factory, work) = match &other {
            Some(other) => (other, plan.size.work(&chosen, true)),
            None => (self.factory(), plan.work),
        };
        let mut hands: Vec<(Pulse, Worker<'_>)> =
            (0..self.threads()).map(|_| (factory.slot(), factory.worker())).collect();
        let block = factory.block_pulses();
        let blocks = (self.schedule().count / block).max(1);
        let consecutive = factory.generator().holds_patch();
        let workers = hands.len() as u64;
        let counted = (ROUNDS as u64 * workers).max(1);
        let turns = AtomicU64::new(0);
        let spent = self.pool().install(|| {
            hands
                .par_iter_mut()
                .with_max_len(1)
                .map(|(slot, worker)| {
                    let mut spent = Vec::with_capacity(ROUNDS);
                    for round in 0..=ROUNDS {
                        let turn = turns.fetch_add(1, Ordering::Relaxed);
                        if consecutive && turn >= blocks && !spent.is_empty() {
                            // Made once more, a block would find the shadows of the first time.
                            break;
                        }
                        let spread = (2 * turn.saturating_sub(workers) + 1) * blocks / (2 * counted);
                        let at = if consecutive { turn } else { spread } % blocks;
                        worker.count_anew();
                        let first = self.schedule().first + at * block;
                        for index in first..(first + block).min(self.schedule().end()) {
                            worker.make(index, slot)?;
                        }
                        if round > 0 {
                            spent.push(COSTED.map(|stage| per_pulse(worker.costs(), stage)));
                        }
                    }
                    Ok(spent)
                })
                .collect::<Result<Vec<_>, PulseError>>()
        })?;
        let spent = spent.concat();
        let mean = |n: usize| spent.iter().map(|stages| stages[n]).sum::<f64>() / spent.len().max(1) as f64;
        let mut cost_table = CostTable::TABLE;
        for (n, stage) in COSTED.into_iter().enumerate() {
            let found = match stage {
                // Single pulses from all over the run make updates that would serve many of their neighbours.
                Stage::Shadow if !interpolates => continue,
                // Exact scatterer paths have their surface in their cost.
                Stage::ScattererPaths if !interpolates => mean(n) + mean(0),
                _ => mean(n),
            };
            let table = CostTable::TABLE.stage_seconds(&work, stage);
            if table > 0.0 && !spent.is_empty() {
                cost_table = cost_table.scaled(stage, found / table);
            }
        }
        Ok(cost_table)
    }
}

/// Workers that are busy in the mean while some pulses are made block by block: at the end of a short run
/// some have no block left. A block that is cut short takes its nodes all the same, half of the time of a
/// whole one.
fn busy_workers(pulses: u64, block: u64, threads: u64) -> f64 {
    let (block, threads) = (block.max(1), threads.max(1));
    let (whole, rest) = (pulses / block, pulses % block);
    let last =
        if rest > 0 && whole.is_multiple_of(threads) { 0.5 + 0.5 * rest as f64 / block as f64 } else { 0.0 };
    let rounds = whole.div_ceil(threads) as f64 + last;
    if rounds > 0.0 { pulses as f64 / block as f64 / rounds } else { threads as f64 }
}

/// What a stage took for a pulse; records go with receiving, and filling with spreading.
fn per_pulse(costs: &Costs, stage: Stage) -> f64 {
    let more = match stage {
        Stage::Receive => costs.seconds_per_pulse(Stage::Record),
        Stage::Spread => costs.seconds_per_pulse(Stage::Fill),
        _ => 0.0,
    };
    costs.seconds_per_pulse(stage) + more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workers_that_have_a_block() {
        assert_eq!(busy_workers(980, 49, 2), 2.0);
        // Eleven blocks, the last of 10 pulses: five rounds of two, and some more.
        let short = busy_workers(500, 49, 2);
        assert!((short - 500.0 / 49.0 / (5.0 + 0.5 + 5.0 / 49.0)).abs() < 1e-12, "{short}");
        // A single block is one worker's.
        assert_eq!(busy_workers(49, 49, 8), 1.0);
        assert_eq!(busy_workers(0, 49, 2), 2.0);
    }
}
