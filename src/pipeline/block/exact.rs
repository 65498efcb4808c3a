//! What a block has of breaking waves, rain and the far sea, found for an emission or a stretch of them.

use std::ops::Range;

use super::{BlockEcho, BlockWork, POINT_PULSES, check};
use crate::echo::synth::block::Node;
use crate::paths::block::{NODES, Tile, nodes_within};
use crate::paths::spikes::stretch::Stretch;
use crate::paths::{FAR_PULSES, PathGenerator, Workspace};
use crate::pipeline::fault::PulseError;
use crate::pulse::costs::Stage;
use crate::scene::Patch;

/// Emissions of which as few are made exactly.
const FEW_PULSES: usize = 8;
/// The same of clutter that fills the beam.
const FEW_PULSES_OF_CLUTTER: usize = 3;

impl BlockEcho {
    /// Breaking waves of some emissions: together where they are smooth, else by halves, and a few of them
    /// exactly. Says how many paths are spread, over all emissions.
    pub(super) fn breakers(
        &self,
        generator: &PathGenerator,
        (first, patch): (u64, &Patch),
        pulses: Range<usize>,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<usize, PulseError> {
        let Some(tiles) = &work.tiles else { return Ok(0) };
        if pulses.len() <= FEW_PULSES {
            let mut spread = 0;
            for pulse in pulses {
                let Some(tiles) = &work.tiles else { break };
                let index = first + pulse as u64;
                generator.breakers((index, pulse), patch, tiles, memory, &mut work.nodes[0])?;
                spread += self.spread_exact(pulse, memory, work)?;
            }
            return Ok(spread);
        }
        let (at, count) = nodes_within(pulses.len());
        let stretch = Stretch { block: first, pulses: pulses.clone(), nodes: &at[..count], patch };
        let (nodes, factors) = (&mut work.nodes[..count], &mut work.factors);
        if pulses.len() <= POINT_PULSES
            && generator.breakers_of_stretch(&stretch, tiles, memory, nodes, factors)?
        {
            return Ok(self.spread_stretch(pulses.clone(), memory, work)? * pulses.len());
        }
        let middle = pulses.start + pulses.len() / 2;
        let mut spread = 0;
        for half in [pulses.start..middle, middle..pulses.end] {
            spread += self.breakers(generator, (first, patch), half, memory, work)?;
        }
        Ok(spread)
    }

    /// The far sea of some pulses that receive nothing but their own emissions, likewise.
    pub(super) fn far_sea(
        &self,
        generator: &PathGenerator,
        first: u64,
        pulses: Range<usize>,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<usize, PulseError> {
        if pulses.len() <= FEW_PULSES_OF_CLUTTER {
            let mut spread = 0;
            for pulse in pulses {
                let index = first + pulse as u64;
                generator.some_clutter_at(index, (false, 1), memory, &mut work.nodes[0])?;
                spread += self.spread_exact(pulse, memory, work)?;
            }
            return Ok(spread);
        }
        if pulses.len() <= FAR_PULSES {
            let BlockWork { frame, lanes, grids, .. } = &mut *work;
            self.synth.make_room(NODES, pulses.end, lanes);
            let spread = |tile: &Tile| self.synth.spread_tile(tile, frame, lanes, grids);
            if let Some(cells) = generator.far_sea_of_stretch((first, pulses.clone()), memory, spread)? {
                return Ok(cells * generator.pairs().len() * pulses.len());
            }
        }
        let middle = pulses.start + pulses.len() / 2;
        let mut spread = 0;
        for half in [pulses.start..middle, middle..pulses.end] {
            spread += self.far_sea(generator, first, half, memory, work)?;
        }
        Ok(spread)
    }

    /// Spreads what is found for an emission alone, breaking waves; says how many paths.
    fn spread_exact(
        &self,
        pulse: usize,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<usize, PulseError> {
        let BlockWork { nodes, frame, part, .. } = &mut *work;
        let paths = &nodes[0];
        if !paths.is_empty() {
            self.synth.fill_part(&[Node { pulse: 0, paths }], frame, pulse..pulse + 1, part)?;
        }
        self.spread_filled(memory, work)
    }

    /// The same of what is found for the own emission of a pulse: rain.
    pub(super) fn spread_own(
        &self,
        pulse: usize,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<usize, PulseError> {
        let BlockWork { nodes, frame, own_groups, part, .. } = &mut *work;
        if !nodes[0].is_empty() {
            self.synth.fill_own(&nodes[0], frame, (pulse, own_groups.get(pulse).copied()), part)?;
        }
        self.spread_filled(memory, work)
    }

    /// Spreads what the first node was filled from, if anything.
    fn spread_filled(&self, memory: &mut Workspace, work: &mut BlockWork) -> Result<usize, PulseError> {
        let BlockWork { nodes, part, grids, .. } = work;
        if nodes[0].is_empty() {
            memory.costs.lap(Stage::Fill);
            return Ok(0);
        }
        check(part.found())?;
        memory.costs.lap(Stage::Fill);
        self.synth.spread_part(part, grids);
        memory.costs.lap(Stage::Spread);
        Ok(part.found().spread)
    }
}
