//! Pulses in blocks: contacts at a few nodes, everything between them interpolated, all pulses spread at once.
//!
//! Block `b` has the pulses `b M .. (b + 1) M`, `M = 3 s + 1`, with nodes at its pulses `0, s, 2 s, 3 s` (`s` the node spacing), so
//! that delay, phase and amplitudes are cubics through four nodes ([`crate::echo::synth::block`]). A block that the run cuts short
//! moves its nodes together. Where pulses hear more than their own emission, where polarisations alternate or intervals differ, where facets
//! forget their phases, and where an update of shadows that do fall lies within a block, every pulse is a block of
//! its own, and nothing is interpolated.
//!
//! The patch of a block is that at its first pulse. A block depends on its number and the run alone, so any thread may make
//! any pulse: the block that holds it is made first, unless it is at hand. Errors of the interpolation: project notes
//! 8.5; antennas that sweep over the facets ask for the closest nodes (3 pulses: -66 dB in the paper's first scene).

use num_complex::Complex64;

use super::stages::PulseError;
use crate::echo::synth::block::{BlockContacts, MAX_PULSES, Node};
use crate::echo::synth::{Grids, Synth, SynthError, SynthScratch};
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;
use crate::radar::illumination::{Illumination, Workspace};
use crate::scattering::contact::Contacts;

/// Nodes of a block.
const NODES: usize = 4;

/// Pulses of a block whose nodes are so many pulses apart.
pub(super) fn block_pulses(spacing: u64) -> u64 {
    (NODES as u64 - 1).saturating_mul(spacing.max(1)).saturating_add(1)
}

/// Pulses of the nodes within a block of so many pulses; in fewer than four the last one is repeated.
fn places(pulses: usize) -> [usize; NODES] {
    let last = pulses.saturating_sub(1);
    std::array::from_fn(|n| if last >= NODES - 1 { n * last / (NODES - 1) } else { n.min(last) })
}

/// Makes echoes block by block. Immutable, shared by all threads.
pub(super) struct BlockEcho {
    synth: Synth<f32>,
    spacing: u64,
    pulses: u64,
}

/// The block at hand, and what makes the next; one per thread.
pub(super) struct BlockWork {
    /// First pulse and the pulse after the last one.
    held: Option<(u64, u64)>,
    /// First pulse of the last block that cannot be interpolated: to find out lights updates of the shadows that its pulses do
    /// not need, so it is asked once.
    divided: Option<u64>,
    nodes: [Contacts; NODES],
    windows_s: Vec<f64>,
    block: BlockContacts<f32>,
    grids: Grids<f32>,
    scratch: SynthScratch<f32>,
}

impl BlockEcho {
    /// For a run of so many pulses, with nodes `spacing` pulses apart.
    ///
    /// # Errors
    /// Blocks longer than the fast echo can hold.
    pub fn new(synth: Synth<f32>, spacing: u64, pulses: u64) -> Result<Self, SynthError> {
        let block = usize::try_from(block_pulses(spacing)).unwrap_or(usize::MAX);
        if block > MAX_PULSES {
            return Err(SynthError::Pulses { pulses: block });
        }
        Ok(Self { synth, spacing: spacing.max(1), pulses })
    }

    /// Pulses of a block.
    pub fn block_pulses(&self) -> u64 {
        block_pulses(self.spacing)
    }

    pub fn fft_len(&self) -> usize {
        self.synth.fft_len()
    }

    pub fn work(&self, pairs: usize, channels: usize, contacts: usize) -> BlockWork {
        BlockWork {
            held: None,
            divided: None,
            nodes: std::array::from_fn(|_| Contacts::new(pairs, channels, contacts)),
            windows_s: Vec::with_capacity(self.block_pulses() as usize),
            block: self.synth.block(),
            grids: self.synth.grids(),
            scratch: self.synth.scratch(),
        }
    }

    /// Fills the record of a pulse and the spectrum of its echo.
    pub fn make(
        &self,
        illumination: &Illumination,
        index: u64,
        pulse: &mut Pulse,
        light: &mut Workspace,
        work: &mut BlockWork,
        spectrum: &mut [Complex64],
    ) -> Result<(), PulseError> {
        illumination.record(index, light, pulse)?;
        if work.held.is_none_or(|(first, end)| !(first..end).contains(&index)) {
            work.held = None;
            work.held = Some(self.prepare(illumination, index, pulse, light, work)?);
        }
        let first = work.held.map_or(index, |(first, _)| first);
        let BlockWork { block, grids, scratch, .. } = work;
        self.synth.spectrum(block, grids, (index - first) as usize, scratch, spectrum);
        light.costs.lap(Stage::Transform);
        light.costs.accumulated(block.found().sounding);
        Ok(())
    }

    /// Makes the block that holds a pulse; says which pulses it has.
    fn prepare(
        &self,
        illumination: &Illumination,
        index: u64,
        pulse: &mut Pulse,
        light: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<(u64, u64), PulseError> {
        let len = self.block_pulses();
        let first = index / len * len;
        let end = (first + len).min(self.pulses);
        let places = places((end - first) as usize);
        let mut instants = [first; NODES];
        instants.iter_mut().zip(places).for_each(|(instant, place)| *instant = first + place as u64);
        work.windows_s.clear();
        if work.divided != Some(first) && !illumination.hears_itself(&instants, light)? {
            work.divided = Some(first);
        }
        if work.divided == Some(first) {
            // A pulse by itself: exact contacts, one node.
            illumination.pulse(index, light, &mut work.nodes[0], pulse)?;
            work.windows_s.push(pulse.window_start_s);
            self.spread(&[0], light, work)?;
            return Ok((index, index + 1));
        }
        light.costs.lap(Stage::Record);
        let patch = illumination.patch_of(first)?;
        for at in first..end {
            work.windows_s.push(illumination.window_start_of(at)?);
        }
        let mut count = 0;
        for (n, (&place, &instant)) in places.iter().zip(&instants).enumerate() {
            if n > 0 && place == places[n - 1] {
                break;
            }
            illumination.node(instant, patch.as_ref(), light, &mut work.nodes[n])?;
            count += 1;
        }
        self.spread(&places[..count], light, work)?;
        Ok((first, end))
    }

    fn spread(
        &self,
        places: &[usize],
        light: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<(), PulseError> {
        let BlockWork { nodes, windows_s, block, grids, .. } = work;
        let mut given = [Node { pulse: 0, contacts: &nodes[0] }; NODES];
        for ((node, &pulse), contacts) in given.iter_mut().zip(places).zip(nodes.iter()) {
            *node = Node { pulse, contacts };
        }
        self.synth.fill(&given[..places.len()], windows_s, block)?;
        light.costs.lap(Stage::Fill);
        let unplaced = block.found().unplaced;
        if unplaced > 0 {
            return Err(PulseError::Unplaced { unplaced });
        }
        self.synth.spread(block, grids);
        light.costs.lap(Stage::Spread);
        Ok(())
    }
}
