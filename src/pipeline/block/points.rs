//! What a block has of targets, direct paths and panels of ships.

use std::ops::Range;

use super::{BlockEcho, BlockWork};
use crate::paths::block::{PanelWork, nodes_within};
use crate::paths::{PathGenerator, Workspace};
use crate::pipeline::fault::PulseError;
use crate::pulse::costs::Stage;

impl BlockEcho {
    /// Targets and direct paths of some emissions, counted from the first.
    pub(super) fn targets(
        &self,
        generator: &PathGenerator,
        first: u64,
        pulses: Range<usize>,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<(), PulseError> {
        let BlockWork { nodes, variations, factors, .. } = &mut *work;
        let (at, count) = nodes_within(pulses.len());
        for (node, place) in nodes.iter_mut().zip(&at[..count]) {
            generator.steady_targets(first + (pulses.start + place) as u64, memory, node)?;
        }
        factors.clear();
        if generator.targets_vary() {
            for pulse in pulses.clone() {
                generator.target_variations(first + pulse as u64, None, memory, variations)?;
                factors.extend_from_slice(variations);
            }
        }
        self.spread_stretch(pulses, memory, work)?;
        Ok(())
    }

    /// Panels of ships of so many emissions; says how many paths are spread.
    pub(super) fn panels(
        &self,
        generator: &PathGenerator,
        (first, pulses): (u64, usize),
        memory: &mut Workspace,
        work: &mut BlockWork,
        panels: &mut PanelWork,
    ) -> Result<usize, PulseError> {
        let parts = pulses.div_ceil(self.pulses_of_panels());
        let mut spread = 0;
        for part in 0..parts {
            // Parts as long as each other: nodes lie as close as they can.
            let own = part * pulses / parts..(part + 1) * pulses / parts;
            let (at, count) = nodes_within(own.len());
            let at = &at[..count];
            let of_run = first + own.start as u64..first + own.end as u64;
            generator.panels(of_run, at, panels, &mut work.nodes[..count])?;
            memory.costs.lap(Stage::ScattererPaths);
            if work.nodes[0].is_empty() {
                continue;
            }
            let found = self.spread_nodes(own, memory, work, |part, _| {
                (0..generator.pairs().len()).for_each(|pair| part.set_factors(pair, panels.factors(pair)));
            })?;
            spread = spread.max(found);
        }
        Ok(spread)
    }
}
