//! Physics dressed as a stage: from a pulse number to a finished pulse.
//!
//! ```text
//! tracks -> generator -> paths -> echo -> spectrum -> receiver -> samples
//! ```
//!
//! The echo is the reference, pulse by pulse, or the fast one, block by block
//! ([`Fidelity`](crate::echo::Fidelity)).
//!
//! A pulse depends on its number alone, so any thread may make any pulse and the bits are the same.

use super::fault::PulseError;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};

use super::block::{BlockEcho, BlockWork};
use super::memory;
use super::single::{SingleEcho, SingleWork};
use crate::echo::reference::ReferenceEcho;
use crate::echo::synth::{Precision, Synth, SynthError};
use crate::fidelity::budget::Plan;
use crate::paths;
use crate::paths::block::NODES;
use crate::paths::list::ScattererPaths;
use crate::paths::snapshot::Snapshot;
use crate::paths::{BeyondHorizon, PathGenerator};
use crate::pipeline::hull_scatterers::ShipTracks;
use crate::pulse::converter::Level;
use crate::pulse::costs::{Costs, Stage};
use crate::pulse::{Layout, Pulse};
use crate::radar::calibration::{CalibrationFault, GeneratorScratch, Generators};
use crate::radar::clock::{ChannelClock, RunningClocks};
use crate::radar::fault::RadarError;
use crate::radar::receiver::{Receiver, ReceiverScratch};
use crate::radar::waveform::Waveform;
use crate::scene::Radar;
use crate::scene::calibration::Calibration;
use crate::scene::radar::Pair;
use crate::sea::land::Dem;

/// Makes pulses. Immutable, shared by all threads.
pub struct PulseFactory {
    pub(crate) generator: PathGenerator,
    pub(crate) echo: Echo,
    pub(crate) sample_rate_hz: f64,
    pub(crate) receiver: Receiver,
    pub(crate) waveform: Arc<dyn Waveform>,
    pub(crate) layout: Layout,
    pub(crate) ships: ShipTracks,
    pub(crate) plan: Option<Plan>,
    pub(crate) clocks: Option<Arc<RunningClocks>>,
    pub(crate) generators: Option<Generators>,
    /// Its workspaces bear the same mark.
    pub(crate) mark: Mark,
}

/// Tells one factory from another: equal to its clones alone.
#[derive(Clone, Default)]
pub(crate) struct Mark(Arc<()>);

impl PartialEq for Mark {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// From scatterer paths to spectra.
pub(crate) enum Echo {
    Reference(ReferenceEcho),
    Fast(Box<BlockEcho>),
    Single(SingleEcho),
}

impl Echo {
    /// By a plan for a run of so many pulses, or the reference.
    ///
    /// # Errors
    /// Settings that the fast echo refuses.
    pub fn of(
        plan: Option<&Plan>,
        radar: &Radar,
        pulses: u64,
        generator: &PathGenerator,
        waveform: &Arc<dyn Waveform>,
    ) -> Result<Self, SynthError> {
        let of_channels = generator.channel_pairs();
        let (carrier_hz, rate_hz, samples) = (radar.carrier_hz, radar.sample_rate_hz, radar.window.samples);
        let waveform = Arc::clone(waveform);
        let Some(Plan { chosen, .. }) = plan else {
            let (pairs, guard) = (of_channels.to_vec(), generator.guard_samples());
            let echo = ReferenceEcho::with_guard(waveform, carrier_hz, rate_hz, samples, pairs, guard);
            return Ok(Self::Reference(echo.in_windows(generator.pair_windows())));
        };
        if chosen.precision == Precision::Double {
            let synth = Synth::new(waveform, carrier_hz, rate_hz, samples, of_channels, chosen.echo)?;
            return Ok(Self::Single(SingleEcho::new(synth.in_windows(generator.pair_windows()))));
        }
        let synth = Synth::new(waveform, carrier_hz, rate_hz, samples, of_channels, chosen.echo)?;
        let synth = synth.grouped(&generator.channel_groups()).in_windows(generator.pair_windows());
        let hold_pulses = generator.hold_pulses();
        Ok(Self::Fast(Box::new(BlockEcho::new(synth, chosen, pulses, hold_pulses)?)))
    }

    pub fn fft_len(&self) -> usize {
        match self {
            Self::Reference(echo) => echo.fft_len(),
            Self::Fast(echo) => echo.fft_len(),
            Self::Single(echo) => echo.fft_len(),
        }
    }
}

/// What one thread needs to make pulses without allocating. Serves the factory that it came from.
pub struct Workspace {
    mark: Mark,
    generator: paths::Workspace,
    echo: EchoWork,
    spectrum: Vec<Complex64>,
    receiver: ReceiverScratch,
    clocks: Vec<ChannelClock>,
    generators: GeneratorScratch,
}

/// What one thread needs for its kind of [`Echo`].
enum EchoWork {
    Reference(ScattererPaths),
    Fast(Box<BlockWork>),
    Single(Box<SingleWork>),
}

impl Workspace {
    /// What its pulses have cost.
    pub fn costs(&self) -> &Costs {
        &self.generator.costs
    }

    /// What the converter of each channel was fed with; empty without one.
    pub fn levels(&self) -> &[Level] {
        self.receiver.levels()
    }

    /// Keeps the memory it has taken, but neither the block at hand nor what that has cost.
    pub(crate) fn start_anew(&mut self) {
        self.generator.costs = Costs::default();
        self.receiver.reset_levels();
        if let EchoWork::Fast(block) = &mut self.echo {
            block.forget();
        }
    }
}

impl PulseFactory {
    /// The same with calibration channels behind those of echoes.
    ///
    /// # Errors
    /// Signals that do not fit the radar.
    pub fn with_calibration(self, list: &[Calibration], radar: &Radar) -> Result<Self, CalibrationFault> {
        if list.is_empty() {
            return Ok(self);
        }
        let clocks = self.clocks.clone();
        let made = Generators::new(list, radar, &*self.waveform, &self.receiver, clocks)?;
        let layout = Layout { channels: radar.channels.len() + made.count(), ..self.layout };
        let receiver = self.receiver.with_behind(made.count());
        Ok(Self { receiver, layout, generators: Some(made), mark: Mark::default(), ..self })
    }

    /// Channels that carry echoes.
    fn echo_channels(&self) -> usize {
        self.layout.channels - self.generators.as_ref().map_or(0, Generators::count)
    }

    /// Sizes of the pulses made.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What was planned; `None` for the reference.
    pub fn plan(&self) -> Option<&Plan> {
        self.plan.as_ref()
    }

    /// Grids of one worker, bytes.
    pub(crate) fn grid_bytes(&self) -> u64 {
        let pulses = self.block_pulses();
        let cells = 2 * self.echo.fft_len() as u64;
        let bytes = match &self.echo {
            Echo::Reference(_) => 0,
            Echo::Fast(_) => 8,
            Echo::Single(_) => 16,
        };
        pulses.saturating_mul(cells).saturating_mul(bytes * self.echo_channels() as u64)
    }

    /// Panels and double bounces of ships that echo by their mesh.
    pub(crate) fn ship_paths(&self) -> usize {
        self.generator.ship_paths()
    }

    /// About what ships that echo by their mesh take with so many workers, bytes.
    pub(crate) fn ship_bytes(&self, threads: usize) -> u64 {
        let (lists, pulses) = match &self.echo {
            Echo::Fast(blocks) => (NODES + 1, blocks.pulses_of_panels() + 1),
            Echo::Reference(_) | Echo::Single(_) => (1, 1),
        };
        let sizes = [self.layout.pairs, self.echo_channels()];
        let each = memory::path_bytes(sizes, lists, pulses).saturating_mul(threads as u64);
        (self.ship_paths() as u64).saturating_mul(each.saturating_add(memory::SHARED_PATH_BYTES))
    }

    /// About what breaking waves take with so many workers, bytes: lists of paths and factors of a block, and
    /// those that are kept for all.
    pub(crate) fn breaker_bytes(&self, threads: usize) -> u64 {
        let pulses = self.block_pulses();
        let lists = if matches!(self.echo, Echo::Fast(_)) { NODES + 1 } else { 1 };
        let (count, kept) = self.generator.breakers_within(pulses);
        let each = memory::path_bytes([self.layout.pairs, self.echo_channels()], lists, pulses as usize);
        kept.saturating_add((count as u64).saturating_mul(each.saturating_mul(threads as u64)))
    }

    /// What pulses one by one take more than those of a block, bytes.
    pub(crate) fn single_bytes(&self, threads: usize) -> u64 {
        let alone = !matches!(self.echo, Echo::Reference(_)) && self.block_pulses() == 1;
        if alone { memory::single_bytes(self.facets(), threads) } else { 0 }
    }

    /// Facets of the patch of sea; 0 without one.
    pub fn facets(&self) -> usize {
        self.generator.facets()
    }

    /// Facets, targets and, where it is received, the direct path: what a pulse may have scatterer paths of.
    pub fn paths(&self) -> usize {
        self.facets() + self.generator.point_count()
    }

    /// An empty slot for a pulse.
    pub fn slot(&self) -> Pulse {
        Pulse::new(&self.layout)
    }

    /// The transmitted pulse after the receive filter; see [`Receiver::replica`].
    pub fn replica(&self) -> Vec<Complex32> {
        self.receiver.replica(&*self.waveform)
    }

    /// Targets whose whole echo lies in the window of a pulse, in the best pair.
    pub fn targets_in_window(&self, pulse: &Pulse) -> usize {
        let targets = self.layout.targets;
        if targets == 0 {
            return 0;
        }
        let window_s = self.layout.samples as f64 / self.sample_rate_hz;
        let pairs = pulse.target_delay_s.chunks_exact(targets).zip(self.generator.pairs());
        let whole = |(delays_s, pair): (&[f64], &Pair)| {
            let opens_s = pulse.window_start_of(pair.receiver);
            let latest_s = opens_s + window_s - self.waveform.duration_s();
            delays_s.iter().filter(|delay_s| (opens_s..=latest_s).contains(*delay_s)).count()
        };
        pairs.map(whole).max().unwrap_or(0)
    }

    /// Targets that the earth hides from an antenna at a pulse.
    ///
    /// # Errors
    /// A pulse that the run does not have, or a track that ends before it.
    pub fn beyond_horizon(&self, index: u64) -> Result<Vec<BeyondHorizon>, RadarError> {
        self.generator.beyond_horizon(index)
    }

    /// Points that stand for rain at a pulse, mean, and in a resolution cell; `None` where it returns no
    /// echo.
    pub fn rain(&self) -> Option<(f64, f64)> {
        self.generator.rains().then(|| (self.generator.drops(), self.generator.drops_per_cell()))
    }

    /// Heights of the land; `None` without any.
    pub fn dem(&self) -> Option<Arc<Dem>> {
        self.generator.dem()
    }

    /// The facets of the sea as a pulse's emission illuminates them, one snapshot for each of `pulses`; none
    /// for a scene without sea.
    ///
    /// # Errors
    /// A pulse that the run does not have, or a track that ends before it.
    pub fn snapshots(&self, pulses: &[u64]) -> Result<Vec<Snapshot>, RadarError> {
        let mut work = self.generator.workspace();
        pulses.iter().filter_map(|&index| self.generator.snapshot(index, &mut work).transpose()).collect()
    }

    /// The scatterer paths within the receive window of a pulse, as the reference echo takes them, and the
    /// pulse with everything but its samples.
    ///
    /// # Errors
    /// A pulse that the run does not have, or a track that ends before it.
    pub fn scatterer_paths(&self, index: u64) -> Result<(Pulse, ScattererPaths), RadarError> {
        let (mut pulse, mut paths) = (self.slot(), self.path_list());
        self.generator.pulse(index, &mut self.generator.workspace(), &mut paths, &mut pulse)?;
        Ok((pulse, paths))
    }

    /// Room for every facet, target and direct path, of a pulse and of two neighbours.
    fn path_list(&self) -> ScattererPaths {
        ScattererPaths::new(self.layout.pairs, self.echo_channels(), self.point_paths() + self.facets())
    }

    /// Most paths of targets and the direct path, of a pulse and of two neighbours.
    fn point_paths(&self) -> usize {
        3 * (self.layout.targets + 1)
    }

    /// The pair of each channel, as scatterer paths have them.
    pub fn channel_pairs(&self) -> &[usize] {
        self.generator.channel_pairs()
    }

    /// Whether there is a sea whose patch moves.
    pub fn follows(&self) -> bool {
        self.generator.follows()
    }

    /// Memory for one thread.
    pub fn workspace(&self) -> Workspace {
        let (pairs, channels) = (self.layout.pairs, self.echo_channels());
        let echo = match &self.echo {
            Echo::Reference(_) => EchoWork::Reference(self.path_list()),
            Echo::Fast(echo) => {
                let work = echo.work(&self.generator, pairs, channels, self.point_paths());
                EchoWork::Fast(Box::new(work))
            }
            Echo::Single(echo) => EchoWork::Single(Box::new(echo.work(self.path_list()))),
        };
        Workspace {
            mark: self.mark.clone(),
            generator: self.generator.workspace(),
            echo,
            spectrum: vec![Complex64::ZERO; channels * self.echo.fft_len()],
            receiver: self.receiver.scratch(),
            clocks: Vec::with_capacity(channels),
            generators: self
                .generators
                .as_ref()
                .map_or_else(GeneratorScratch::default, |of| of.scratch(&self.receiver)),
        }
    }

    /// Makes pulse `index` in a slot of this factory's layout. Does not allocate once the workspace has seen
    /// the largest scatterer path list.
    ///
    /// # Errors
    /// A workspace of another factory; a pulse that the run does not have. Tracks were checked to cover the
    /// run, so any other error is a fault of the program.
    pub fn make(&self, index: u64, pulse: &mut Pulse, work: &mut Workspace) -> Result<(), PulseError> {
        let Workspace { mark, generator, echo: of_echo, spectrum, receiver, clocks, generators } = work;
        if *mark != self.mark {
            return Err(PulseError::Workspace);
        }
        generator.costs.begin();
        match (&self.echo, of_echo) {
            (Echo::Reference(echo), EchoWork::Reference(paths)) => {
                self.generator.pulse(index, generator, paths, pulse)?;
                echo.spectrum_in(paths, pulse.window_starts_s(), spectrum);
                generator.costs.lap(Stage::Spread);
                generator.costs.accumulated(paths.len() * self.layout.pairs);
            }
            (Echo::Fast(echo), EchoWork::Fast(work)) => {
                echo.make(&self.generator, index, pulse, generator, work, spectrum)?;
            }
            (Echo::Single(echo), EchoWork::Single(work)) => {
                echo.make(&self.generator, index, pulse, generator, work, spectrum)?;
            }
            _ => return Err(PulseError::Workspace),
        }
        self.ships.record(pulse);
        if let Some(running) = &self.clocks {
            // Echoes were made for the window as it is; recorded is what the clocks say.
            self.generator.record_nominal(pulse)?;
            running.channels(index, pulse.window_starts_s(), clocks);
        }
        self.receiver.receive_by(clocks, spectrum, pulse, receiver);
        if let Some(made) = &self.generators {
            made.fill(&self.receiver, pulse, generators, receiver);
        }
        generator.costs.lap(Stage::Receive);
        generator.costs.made();
        Ok(())
    }

    /// Pulses that are made together: 1, or those of a block.
    pub fn block_pulses(&self) -> u64 {
        match &self.echo {
            Echo::Reference(_) | Echo::Single(_) => 1,
            Echo::Fast(echo) => echo.block_pulses(),
        }
    }
}
