//! Pulses in blocks: everything found at a few instants, interpolated in between, all pulses spread at once.
//!
//! Block `b` has the pulses `b M .. (b + 1) M`, `M = 3 s + 1`, with nodes at its pulses `0, s, 2 s, 3 s` (`s`
//! the node spacing). The sea comes tile by tile ([`crate::paths::block`]) and is spread at once
//! ([`crate::echo::synth::lanes`]); targets and the direct path are scatterer paths at the gain instants,
//! through which delay, phase and amplitude are cubics ([`crate::echo::synth::block`]); what varies from
//! pulse to pulse multiplies the amplitude at each of them. A block that the run
//! cuts short moves its nodes together. Nodes are functions of time: a pulse is evaluated when it is emitted,
//! so intervals may differ, and of the channels that nodes have it fills those of its polarisation. Where a
//! report is changed by which something is aimed, a block ends ([`PathGenerator::unbroken`]).
//!
//! What is evaluated are the **emissions** that the windows of the block receive ([`Received`]): its own
//! pulses, and where several are in the air those before it that reach into it, or others altogether. Blocks
//! are then shorter by these, so that nodes lie as close. Emissions are cut where a report changes or the
//! patch moves on between them, each part with nodes of its own; parts go to the same grids. Where windows
//! receive too many, every pulse is a block of its own, and nothing is interpolated.
//!
//! A patch that follows stays for some pulses ([`PathGenerator::hold_pulses`]), and blocks divide these. A
//! block depends on its number and the run alone, so any thread may make any pulse: its block is made first,
//! unless that is at hand. Errors of the interpolation: `docs/physics.md` section 15.7.

mod doppler;
mod exact;
mod joint;
mod points;
mod spectra;

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use num_complex::Complex64;

use crate::cpu::Variant;
use crate::echo::synth::bands::Bands;
use crate::echo::synth::block::{BlockPaths, Fill, Frame, MAX_PULSES, Node, Receives};
use crate::echo::synth::lanes::LaneWork;
use crate::echo::synth::{Grids, Synth, SynthError, SynthScratch};
use crate::fidelity::echo_settings::{EchoSettings, block_pulses};
use crate::paths::block::{
    Borders, Fine, Instants, Least, NODES, PanelWork, Sample, ShareBorders, Sidelobe, Tiers, TileWork,
    nodes_within,
};
use crate::paths::list::ScattererPaths;
use crate::paths::{PathGenerator, Received, Workspace};
use crate::pipeline::engine::{EchoEngine, EchoWorker, Needs, path_list, point_paths, receives_one};
use crate::pipeline::fault::PulseError;
use crate::pipeline::kit::Desk;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;

pub(crate) use joint::Joint;
use joint::JointWork;
use spectra::Turned;

/// Most pulses of which points have polynomials in common: phases are rounded by the square of their number.
const POINT_PULSES: usize = 192;

/// What blocks have in common, for all threads.
#[derive(Default)]
struct SharedBorders(Mutex<Borders>);

impl ShareBorders for SharedBorders {
    fn with(&self, each: &mut dyn FnMut(&mut Borders)) {
        each(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

/// Makes echoes block by block. Shared by all threads, immutable but for what its blocks have in common.
pub(crate) struct BlockEcho {
    synth: Arc<Synth<f32>>,
    borders: Arc<SharedBorders>,
    /// Pulses of a block, and emissions that it needs beyond as many.
    length: u64,
    /// Emissions whose nodes are their own, at most: where pulses are not those emitted any number may fall
    /// into a block.
    part: u64,
    overlap_pulses: u64,
    hold_pulses: Option<u64>,
    gain_pulses: usize,
    /// Pulses from node to node of panels of ships.
    panel_pulses: usize,
    epochs_per_node: usize,
    /// The same of wake tiles, if there may be any.
    wake_epochs: Option<usize>,
    sidelobe: Option<Sidelobe>,
    fine: Fine,
    /// What a tile may lack at its supports alone.
    between: Option<f64>,
    /// Power over the mean of a facet below which one is left out, or a part of one.
    least_power: Least,
    /// Power over that of the echo above which a facet that turns away is decided at its pulse.
    turning: f64,
    pulses: u64,
    /// Where no two emissions are alike.
    joint: Option<Joint>,
}

/// The block at hand, and what makes the next; one per thread.
struct BlockWork {
    /// Pulses of the block at hand, and the first that was not taken from its grids: what is asked for once
    /// more is made once more.
    made: Range<u64>,
    next: u64,
    /// Whether it receives nothing.
    silent: bool,
    received: Received,
    /// Emissions that have nodes in common.
    parts: Vec<Range<u64>>,
    tiers: Tiers,
    nodes: [ScattererPaths; NODES],
    /// `[window][pulse]`.
    windows_s: Vec<Vec<f64>>,
    frame: Frame,
    /// Groups of the pulses' own emissions.
    own_groups: Vec<u8>,
    part: BlockPaths<f32>,
    grids: Grids<f32>,
    scratch: SynthScratch<f32>,
    tiles: Option<Box<TileWork>>,
    lanes: LaneWork,
    samples: Vec<Sample>,
    mean_hz: Vec<f64>,
    /// Of the points of a pulse.
    variations: Vec<f64>,
    /// `[pulse][point][pair]` of a part of the block.
    factors: Vec<f64>,
    panels: Option<Box<PanelWork>>,
    /// For pulses that are taken in bands of Doppler.
    bands: Option<Bands<f32>>,
    of_turns: Turned,
    /// Where grids are those of emissions.
    joint: Option<Box<JointWork>>,
    /// Scatterer paths of the block at hand that are spread, over all pairs.
    spread: usize,
}

struct BlockWorker<'f> {
    echo: &'f BlockEcho,
    work: BlockWork,
}

impl EchoEngine for BlockEcho {
    fn fft_len(&self) -> usize {
        self.joint.as_ref().map_or(self.synth.fft_len(), Joint::out_len)
    }

    fn segment_pulses(&self) -> u64 {
        self.length
    }

    fn needs(&self) -> Needs {
        // Replicas of the block at hand, spread over its pulses.
        let replicas = self.synth.replica_bytes() * self.synth.turns().min(self.length);
        let of_joint = if self.joint.is_some() { self.synth.frequency_bytes() } else { 0 };
        let pulse_bytes = self.synth.pulse_bytes() + (replicas + of_joint) / self.length.max(1);
        Needs { pulse_bytes, lists: NODES + 1, panel_pulses: self.pulses_of_panels() + 1 }
    }

    fn with_nodes(&self, chosen: &EchoSettings) -> Option<Arc<dyn EchoEngine>> {
        let block = usize::try_from(block_pulses(chosen.node_pulses)).ok().filter(|&n| n <= MAX_PULSES);
        let (synth, borders) = (Arc::clone(&self.synth), Arc::default());
        let part = chosen.block_pulses(self.hold_pulses);
        // Segments of pulses that are not those emitted stay.
        let length = if self.length == self.part { part } else { self.length };
        let joint = self.joint.clone();
        block
            .filter(|_| part > 1 || joint.is_none())
            .map(|_| Arc::new(Self { synth, borders, length, part, joint, ..*self }) as Arc<dyn EchoEngine>)
    }

    fn worker<'f>(&'f self, paths: &PathGenerator) -> Box<dyn EchoWorker + 'f> {
        Box::new(BlockWorker { echo: self, work: self.work(paths) })
    }
}

impl EchoWorker for BlockWorker<'_> {
    fn fill(&mut self, index: u64, pulse: &mut Pulse, desk: &mut Desk<'_>) -> Result<(), PulseError> {
        self.echo.fill(index, pulse, desk, &mut self.work)
    }
}

impl BlockEcho {
    /// The same in segments of so many pulses, whatever falls into these.
    pub fn in_segments(self, pulses: u64) -> Self {
        Self { length: pulses.clamp(1, MAX_PULSES as u64), ..self }
    }

    /// The same where no two emissions are alike.
    pub fn joining(self, joint: Joint) -> Self {
        Self { joint: Some(joint), ..self }
    }

    /// For a run of so many pulses.
    ///
    /// # Errors
    /// Blocks longer than the fast echo can hold.
    pub fn new(
        synth: Synth<f32>,
        chosen: &EchoSettings,
        pulses: u64,
        hold_pulses: Option<u64>,
    ) -> Result<Self, SynthError> {
        let block = usize::try_from(block_pulses(chosen.node_pulses)).unwrap_or(usize::MAX);
        if block > MAX_PULSES {
            return Err(SynthError::Pulses { pulses: block });
        }
        let gain_pulses = usize::try_from(chosen.gain_pulses).unwrap_or(1).clamp(1, MAX_PULSES);
        Ok(Self {
            synth: Arc::new(synth),
            borders: Arc::default(),
            length: chosen.block_pulses(hold_pulses),
            part: chosen.block_pulses(hold_pulses),
            overlap_pulses: chosen.overlap_pulses,
            hold_pulses,
            gain_pulses,
            panel_pulses: usize::try_from(chosen.panel_pulses.unwrap_or(1)).unwrap_or(1).clamp(1, MAX_PULSES),
            epochs_per_node: chosen.epochs_per_node,
            wake_epochs: chosen.wake_epochs,
            sidelobe: chosen.sidelobe,
            fine: chosen.fine,
            between: chosen.between,
            least_power: chosen.least_power,
            turning: chosen.turning,
            pulses,
            joint: None,
        })
    }

    fn work(&self, generator: &PathGenerator) -> BlockWork {
        let variant = self.synth.settings().variant.unwrap_or_else(Variant::fastest);
        let (length, part) = (self.length as usize, self.part as usize);
        let pairs = generator.pairs().len();
        let breakers = generator.breakers_room(part);
        let at_once = breakers.max(generator.own_clutter_room());
        BlockWork {
            made: 0..0,
            next: 0,
            silent: false,
            received: Received::default(),
            parts: Vec::new(),
            tiers: Tiers::default(),
            nodes: std::array::from_fn(|_| path_list(generator, point_paths(generator).max(at_once))),
            windows_s: (0..generator.windows()).map(|_| Vec::with_capacity(length)).collect(),
            frame: Frame::default(),
            own_groups: Vec::new(),
            part: self.synth.block_with_room(at_once, breakers * part),
            grids: self.synth.grids(),
            scratch: self.synth.scratch(),
            tiles: generator.tile_work(variant, Some(self.borders.clone()), self.fine),
            lanes: LaneWork::default(),
            samples: Vec::with_capacity(pairs),
            mean_hz: Vec::with_capacity(pairs),
            variations: Vec::with_capacity(generator.target_count() * pairs),
            factors: Vec::with_capacity(breakers * pairs * part),
            panels: generator.panel_work(variant, self.pulses_of_panels()),
            bands: self.band_hz().map(|_| self.synth.bands()),
            of_turns: Turned::default(),
            joint: self.joint.as_ref().map(|joint| Box::new(JointWork::new(joint, self.synth.fft_len()))),
            spread: 0,
        }
    }

    /// Fills the record of a pulse and the spectrum of its echo.
    ///
    /// # Errors
    /// A track that ends early, or paths that cannot be followed through the block.
    fn fill(
        &self,
        index: u64,
        pulse: &mut Pulse,
        desk: &mut Desk<'_>,
        work: &mut BlockWork,
    ) -> Result<(), PulseError> {
        if let Some(band_hz) = self.band_hz() {
            return self.fill_in_bands((index, pulse), band_hz, desk, work);
        }
        let Desk { paths: generator, memory, spectrum } = desk;
        generator.record(index, memory, pulse)?;
        if !(work.next..work.made.end).contains(&index) {
            work.made = 0..0;
            work.made = self.prepare(generator, index, pulse, memory, work)?;
            work.of_turns.forget();
        }
        work.next = index + 1;
        if work.silent {
            spectrum.fill(Complex64::ZERO);
            return Ok(());
        }
        if self.joint.is_some() {
            self.join((index, pulse), generator, memory, spectrum, work)?;
            return Ok(());
        }
        self.spectrum_of((index, generator.number_of(index)), spectrum, work);
        memory.costs.lap(Stage::Transform);
        memory.costs.accumulated(work.spread);
        Ok(())
    }

    /// Width of the bands of Doppler where every pulse is made by itself, in such bands.
    fn band_hz(&self) -> Option<f64> {
        self.synth.settings().band_hz.filter(|_| self.part == 1)
    }

    /// Makes the block of a pulse; says which pulses it has.
    fn prepare(
        &self,
        generator: &PathGenerator,
        index: u64,
        pulse: &mut Pulse,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<Range<u64>, PulseError> {
        let segment = self.segment_of(index);
        let mut block = segment.start..segment.end.min(self.pulses);
        if !generator.is_apart() {
            // What is aimed by a report jumps with it: such a block ends there.
            block = generator.unbroken(block, index);
        }
        let Range { start: first, end } = block;
        work.windows_s.iter_mut().for_each(Vec::clear);
        (work.spread, work.silent) = (0, false);
        if self.part == 1 || !self.receives(generator, first..end, memory, work)? {
            return self.prepare_single(generator, index, pulse, memory, work);
        }
        if self.joint.is_none() && self.synth.turns() > 0 && !work.received.is_alone() {
            return Err(PulseError::SeveralInTurn { pulse: index });
        }
        // Grids are those of pulses, or of the emissions at hand.
        let mut gridded = first..end;
        if let (Some(Joint { span, .. }), Some(own)) = (&self.joint, &mut work.joint) {
            gridded = work.received.emissions();
            own.begin(gridded.clone());
            for starts_s in &mut work.windows_s {
                starts_s.clear();
                starts_s.resize((gridded.end - gridded.start) as usize, span.origin_s);
            }
        }
        let count = (gridded.end - gridded.start) as usize;
        generator.pulse_groups(gridded.start, count, &mut work.own_groups);
        work.frame.fill_own(&work.own_groups);
        let lead = self.part(generator, work);
        work.silent = work.parts.is_empty();
        if work.silent {
            return Ok(first..end);
        }
        let mut exact = self.emissions(generator, (first, true), work.parts[lead].clone(), memory, work)?;
        for n in (0..work.parts.len()).filter(|n| *n != lead) {
            exact += self.emissions(generator, (first, false), work.parts[n].clone(), memory, work)?;
        }
        let pulses = (end - first) as usize;
        let far = generator.has_far_sea() && !work.received.is_alone();
        for pulse in if generator.rains() || far { 0..pulses } else { 0..0 } {
            let index = first + pulse as u64;
            generator.some_clutter_at(
                index,
                (generator.rains(), usize::from(far)),
                memory,
                &mut work.nodes[0],
            )?;
            exact += self.spread_own(pulse, memory, work)?;
        }
        work.spread += exact / pulses;
        Ok(first..end)
    }

    /// Parts the emissions that a block receives, each with nodes of its own: where a report changes or the
    /// patch moves on, and, of others than its pulses', every so many. Says which decides about Doppler: that
    /// with the emission in the middle.
    fn part(&self, generator: &PathGenerator, work: &mut BlockWork) -> usize {
        let BlockWork { received, parts, .. } = work;
        let emissions = received.emissions();
        parts.clear();
        let mut at = emissions.start;
        let count = emissions.end - emissions.start;
        let longest = count.div_ceil(count.div_ceil(self.part).max(1)).max(1);
        while at < emissions.end {
            let mut part = generator.unbroken(emissions.clone(), at);
            if generator.is_apart() {
                part = at..part.end.min(at + longest);
            }
            at = part.end;
            // Of others few may be received.
            parts.extend(if generator.is_apart() { received.within(&part) } else { Some(part) });
        }
        let middle = emissions.start + (emissions.end - emissions.start) / 2;
        parts.iter().position(|part| part.contains(&middle)).unwrap_or(parts.len() / 2)
    }

    /// Windows of some pulses, and what they receive; `false` where that is more than blocks can have.
    fn receives(
        &self,
        generator: &PathGenerator,
        pulses: Range<u64>,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<bool, PulseError> {
        for at in pulses.clone() {
            for (window, starts_s) in work.windows_s.iter_mut().enumerate() {
                starts_s.push(generator.window_start_of(window, at)?);
            }
        }
        let BlockWork { windows_s, received, .. } = work;
        let in_blocks = generator.received(pulses.start, windows_s, memory, received)?;
        // One more where what is in the air changes; with others nodes would be farther apart than planned.
        let most = pulses.end - pulses.start + self.overlap_pulses + 1;
        let emissions = received.emissions();
        Ok(in_blocks && (generator.is_apart() || emissions.end - emissions.start <= most))
    }

    /// Makes a pulse by itself: exact scatterer paths, one node.
    fn prepare_single(
        &self,
        generator: &PathGenerator,
        index: u64,
        pulse: &mut Pulse,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<Range<u64>, PulseError> {
        let paths = &mut work.nodes[0];
        generator.pulse(index, memory, paths, pulse)?;
        if self.synth.turns() > 0 {
            receives_one(index, paths)?;
        }
        let node = Node { pulse: 0, paths };
        self.synth.fill_in(&[node], pulse.window_starts_s().as_chunks::<1>().0, &mut work.part)?;
        check(work.part.found())?;
        memory.costs.lap(Stage::Fill);
        self.synth.spread(&work.part, &mut work.grids);
        memory.costs.lap(Stage::Spread);
        work.spread = work.part.found().spread;
        work.frame.clone_from(work.part.frame());
        Ok(index..index + 1)
    }

    /// Makes some of the emissions of a block with the given first pulse, and spreads them on the grids of
    /// the pulses that receive them; `leads`: before all others, whose mean Doppler is theirs. Says how many
    /// exact paths are spread, over all emissions.
    fn emissions(
        &self,
        generator: &PathGenerator,
        (first, leads): (u64, bool),
        emissions: Range<u64>,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<usize, PulseError> {
        let (from, count) = (emissions.start, (emissions.end - emissions.start) as usize);
        let instants = Instants::of_block(from, count, self.epochs_per_node, self.gain_pulses);
        work.tiers = Tiers::new(instants, self.sidelobe).with_wake(self.wake_epochs);
        let alone = work.received.is_alone();
        work.frame.receives.clear();
        if let Some(joint) = &work.joint {
            let at = |emitted: u64| (emitted - from) as usize;
            work.frame.receives.extend(emissions.clone().map(|emitted| Receives {
                emission: at(emitted),
                pulse: (emitted - joint.first()) as usize,
                offset_s: 0.0,
            }));
        } else if !alone {
            let of = |(pulse, of): (usize, &Range<u64>)| {
                let index = first + pulse as u64;
                let held = of.start.max(from)..of.end.min(emissions.end);
                held.map(move |emitted| Receives {
                    emission: (emitted - from) as usize,
                    pulse,
                    offset_s: generator.offset_s(index, emitted),
                })
            };
            let of_pulses = work.received.of_pulses().iter().enumerate();
            work.frame.receives.extend(of_pulses.flat_map(of));
            work.frame.receives.sort_unstable_by_key(|own| (own.emission, own.pulse));
        }
        // Rows of a tile are summed with what lies beyond the reach.
        let sums =
            !self.synth.has_exact_reach() && self.synth.windows_align(&work.windows_s, &work.frame.receives);
        work.tiers.between = self.between.filter(|_| sums);
        work.tiers.turning = Some(self.turning);
        let patch = generator.patch_of(from)?;
        let BlockWork { tiers, samples, tiles, mean_hz, nodes, windows_s, .. } = &mut *work;
        samples.clear();
        if let (Some(patch), Some(tiles)) = (&patch, tiles) {
            generator.open_block(tiers, patch, memory, tiles, samples)?;
        }
        if leads {
            let of_pulses = windows_s.first().map_or(0, Vec::len);
            let rain = if generator.is_apart() { from } else { first + (of_pulses / 2) as u64 };
            self.mean_doppler(generator, (from, count, rain), memory, samples, nodes, mean_hz)?;
        }
        let BlockWork { tiers, samples, tiles, mean_hz, windows_s, frame, grids, lanes, .. } = &mut *work;
        memory.costs.lap(Stage::Record);
        if leads {
            self.synth.frame(windows_s, mean_hz, frame);
            self.synth.clear_for(frame, grids);
        }
        generator.slow_time(from, count, &mut frame.slow);
        frame.carrier_turns = generator.carrier_turns(from, count, &mut frame.emission_turns);
        generator.pulse_groups(from, count, &mut frame.groups);
        if !alone {
            frame.fill_received();
            if frame.receives.is_empty() {
                return Ok(0);
            }
        }
        let mut spread = 0;
        if let (Some(patch), Some(tiles)) = (&patch, tiles) {
            let room = count.max(frame.receives.len());
            self.synth.make_room(tiers.epochs(), room, lanes);
            let tally =
                generator.visit_tiles(patch, samples, self.least_power, tiles, &mut memory.costs, |tile| {
                    self.synth.spread_tile(tile, frame, lanes, grids);
                });
            let [facets, illuminated, culled] =
                [tally.facets, tally.illuminated, tally.culled].map(|n| n as usize);
            memory.costs.looked_at(facets, illuminated, culled);
            memory.costs.looked_at_less(tally.sidelobe as usize, tally.beyond as usize);
            spread = (illuminated - culled) * generator.pairs().len();
        }
        if generator.target_count() > 0 {
            let step = ((NODES - 1) * self.gain_pulses).min(POINT_PULSES);
            for at in (0..count).step_by(step) {
                self.targets(generator, from, at..(at + step).min(count), memory, work)?;
            }
            spread += work.part.found().spread;
        }
        if let Some(mut panels) = work.panels.take() {
            let made = self.panels(generator, (from, count), memory, work, &mut panels);
            work.panels = Some(panels);
            spread += made?;
        }
        if leads {
            work.spread += spread;
        }
        let mut exact = match &patch {
            Some(patch) if generator.breakers_alive() > 0.0 => {
                self.breakers(generator, (from, patch), 0..count, memory, work)?
            }
            _ => 0,
        };
        if generator.has_far_sea() && alone && work.joint.is_none() {
            exact += self.far_sea(generator, from, 0..count, memory, work)?;
        }
        Ok(exact)
    }

    /// Spreads the paths at the nodes of some emissions, and what multiplies their amplitudes.
    fn spread_stretch(
        &self,
        pulses: Range<usize>,
        memory: &mut Workspace,
        work: &mut BlockWork,
    ) -> Result<usize, PulseError> {
        let count = pulses.len();
        self.spread_nodes(pulses, memory, work, |part, factors| {
            for of_pulse in factors.chunks_exact((factors.len() / count).max(1)) {
                part.push_factors(of_pulse);
            }
        })
    }

    /// The same with factors that `weigh` puts in; it has those at hand.
    fn spread_nodes(
        &self,
        pulses: Range<usize>,
        memory: &mut Workspace,
        work: &mut BlockWork,
        weigh: impl FnOnce(&mut BlockPaths<f32>, &[f64]),
    ) -> Result<usize, PulseError> {
        let BlockWork { nodes, frame, part, grids, factors, .. } = work;
        let (at, count) = nodes_within(pulses.len());
        let mut given = [Node { pulse: 0, paths: &nodes[0] }; NODES];
        for ((node, &pulse), paths) in given.iter_mut().zip(&at).zip(nodes.iter()) {
            *node = Node { pulse, paths };
        }
        self.synth.fill_part(&given[..count], frame, pulses, part)?;
        check(part.found())?;
        weigh(part, factors);
        memory.costs.lap(Stage::Fill);
        self.synth.spread_part(part, grids);
        memory.costs.lap(Stage::Spread);
        Ok(part.found().spread)
    }

    /// Pulses whose panels of ships are found together, at most.
    fn pulses_of_panels(&self) -> usize {
        ((NODES - 1) * self.panel_pulses + 1).min(POINT_PULSES).min(self.part as usize)
    }
}

pub(super) fn check(found: Fill) -> Result<(), PulseError> {
    match found.unplaced {
        0 => Ok(()),
        unplaced => Err(PulseError::Unplaced { unplaced }),
    }
}
