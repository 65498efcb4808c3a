//! Physics dressed as a stage: from a pulse number to a finished pulse.
//!
//! ```text
//! tracks -> generator -> paths -> echo -> spectrum -> receiver -> samples
//! ```
//!
//! Echoes are an engine's (`pipeline::engine`): the reference, or the fast one in blocks or pulse by pulse
//! ([`Fidelity`](crate::echo::Fidelity)).
//!
//! A pulse depends on its number alone, so any thread may make any pulse and the bits are the same.

use super::fault::PulseError;
use std::iter;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use num_complex::Complex32;

use super::engine::{EchoEngine, EchoWorker, Needs, Slots, full_list};
use super::kit::{Kit, Reception};
use super::memory;
use super::overheard::Overheard;
use crate::fidelity::budget::Plan;
use crate::fidelity::echo_settings::EchoSettings;
use crate::geometry::lanes::Row;
use crate::motion::PlatformTracks;
use crate::paths::list::ScattererPaths;
use crate::paths::snapshot::Snapshot;
use crate::paths::{BeyondHorizon, PathGenerator};
use crate::pipeline::hull_scatterers::ShipTracks;
use crate::pulse::converter::Level;
use crate::pulse::costs::Costs;
use crate::pulse::{Layout, Pulse};
use crate::radar::calibration::{CalibrationFault, Generators};
use crate::radar::clock::RunningClocks;
use crate::radar::dechirp::Dechirp;
use crate::radar::fault::RadarError;
use crate::radar::front_end::FrontEnd;
use crate::radar::receiver::Receiver;
use crate::radar::waveform::{Waveform, pulses};
use crate::scene::calibration::Calibration;
use crate::scene::radar::Pair;
use crate::scene::{Radar, Scene};
use crate::sea::land::Dem;

/// Makes pulses. Immutable, shared by all threads.
#[derive(Clone)]
pub struct PulseFactory {
    generator: PathGenerator,
    /// The same on the tracks that are flown, where it was prepared on others.
    flown: OnceLock<PathGenerator>,
    echo: Arc<dyn EchoEngine>,
    /// What is received besides the radar's own echoes.
    others: Vec<Arc<Overheard>>,
    reception: Reception,
    sample_rate_hz: f64,
    pub(crate) waveform: Arc<dyn Waveform>,
    pub(crate) layout: Layout,
    plan: Option<Plan>,
}

/// Makes pulses in one thread, without allocating once it has seen the largest list of scatterer paths.
pub struct Worker<'f> {
    factory: &'f PulseFactory,
    echo: Box<dyn EchoWorker + 'f>,
    kit: Kit<'f>,
}

impl Worker<'_> {
    /// Makes pulse `index` in a slot of the factory's layout. Pulses of a block are made at once: it takes
    /// least to ask for them in their order.
    ///
    /// # Errors
    /// A pulse that the run does not have. Tracks were checked to cover the run, so any other error is a
    /// fault of the program.
    pub fn make(&mut self, index: u64, pulse: &mut Pulse) -> Result<(), PulseError> {
        self.make_all(index..index.saturating_add(1), &mut iter::once(pulse))
    }

    /// Makes pulses of one segment of the engine in as many slots.
    ///
    /// # Errors
    /// Those of [`Self::make`].
    pub(crate) fn make_all(&mut self, pulses: Range<u64>, slots: Slots<'_>) -> Result<(), PulseError> {
        self.kit.take_off(self.factory.generator());
        self.kit.desk.memory.costs.begin();
        self.echo.make(pulses, slots, &mut self.kit)
    }

    /// What its pulses have cost.
    pub fn costs(&self) -> &Costs {
        &self.kit.desk.memory.costs
    }

    /// What the converter of each channel was fed with; empty without one.
    pub fn levels(&self) -> &[Level] {
        self.kit.scratch.levels()
    }

    /// Counts costs and levels from 0.
    pub(crate) fn count_anew(&mut self) {
        self.kit.desk.memory.costs = Costs::default();
        self.kit.scratch.reset_levels();
    }
}

impl PulseFactory {
    /// What makes the pulses of a scene by an engine and what that was planned by, for a radar much like the
    /// scene's, by ideal clocks.
    pub(crate) fn new(
        (echo, plan): (Arc<dyn EchoEngine>, Option<Plan>),
        (scene, radar): (&Scene, &Radar),
        generator: PathGenerator,
        waveform: Arc<dyn Waveform>,
    ) -> Self {
        let front_end = FrontEnd::new(radar, scene.seed, waveform.as_ref());
        let receiver = Receiver::new(radar, scene.seed, echo.fft_len(), radar.channels.len());
        let receiver = receiver.with_front_end(front_end);
        let layout = radar.layout(scene.platforms.len(), scene.targets.len());
        Self {
            generator,
            flown: OnceLock::new(),
            echo,
            others: Vec::new(),
            reception: Reception {
                receiver,
                dechirp: None,
                ships: ShipTracks::of(scene),
                clocks: None,
                generators: None,
            },
            sample_rate_hz: radar.sample_rate_hz,
            waveform,
            layout: Layout { ships: scene.ships.len(), ..layout },
            plan,
        }
    }

    /// The same by these clocks.
    pub(crate) fn with_clocks(self, clocks: Option<Arc<RunningClocks>>) -> Self {
        let layout = Layout { clocks: clocks.as_ref().map_or(0, |clocks| clocks.count()), ..self.layout };
        Self { layout, reception: Reception { clocks, ..self.reception }, ..self }
    }

    /// The same for a radar that dechirps what the front end takes by which it was made.
    pub(crate) fn with_dechirp(self, (scene, radar): (&Scene, &Radar), front_end: &Radar) -> Self {
        let waveform = Arc::clone(&self.waveform);
        let Some(dechirp) = Dechirp::new(radar, front_end, self.echo.fft_len(), waveform) else {
            return self;
        };
        let ideal = Receiver::new(radar, scene.seed, dechirp.fft_len(), radar.channels.len());
        let receiver = ideal.with_front_end(FrontEnd::new(radar, scene.seed, self.waveform.as_ref()));
        let layout = Layout { samples: radar.window.samples, ..self.layout };
        let reception = Reception { receiver, dechirp: Some(dechirp), ..self.reception };
        Self { reception, layout, sample_rate_hz: radar.sample_rate_hz, ..self }
    }

    /// The same with what is received of emitters.
    pub(crate) fn with_others(self, others: Vec<Overheard>) -> Self {
        Self { others: others.into_iter().map(Arc::new).collect(), ..self }
    }

    /// The same with calibration channels behind those of echoes.
    ///
    /// # Errors
    /// Signals that do not fit the radar.
    pub fn with_calibration(self, list: &[Calibration], radar: &Radar) -> Result<Self, CalibrationFault> {
        if list.is_empty() {
            return Ok(self);
        }
        let Reception { receiver, clocks, .. } = &self.reception;
        let made = Generators::new(list, radar, &*self.waveform, receiver, clocks.clone())?;
        let layout = Layout { channels: radar.channels.len() + made.count(), ..self.layout };
        let receiver = receiver.clone().with_behind(made.count());
        let reception = Reception { receiver, generators: Some(made), ..self.reception };
        Ok(Self { reception, layout, ..self })
    }

    /// The same with other nodes; `None` where pulses are made one by one.
    pub(crate) fn with_nodes(&self, chosen: &EchoSettings) -> Option<Self> {
        Some(Self { echo: self.echo.with_nodes(chosen)?, ..self.clone() })
    }

    /// What finds the scatterer paths of the pulses that are made next.
    pub(crate) fn generator(&self) -> &PathGenerator {
        self.flown.get().unwrap_or(&self.generator)
    }

    /// Bins of the spectrum of a channel, on which its noise is drawn.
    pub(crate) fn fft_len(&self) -> usize {
        self.reception.receiver.fft_len()
    }

    /// Whether pulses are blocks of continuous reception.
    pub(crate) fn is_continuous(&self) -> bool {
        self.reception.receiver.is_continuous()
    }

    /// Makes the next pulses on other tracks, in the order of the platforms, where it was prepared on a
    /// nominal trajectory. That can be done once.
    pub(crate) fn fly(&self, tracks: Vec<PlatformTracks>) {
        self.others.iter().for_each(|other| other.fly(&tracks));
        let _ = self.flown.set(self.generator.on_tracks(tracks));
    }

    /// Channels that carry echoes.
    fn echo_channels(&self) -> usize {
        self.generator.channel_pairs().len()
    }

    /// Sizes of the pulses made.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What was planned; `None` for the reference.
    pub fn plan(&self) -> Option<&Plan> {
        self.plan.as_ref()
    }

    /// Emitters that are received besides: name, share of the pulses that receive it, and what was planned.
    pub(crate) fn others(&self) -> impl Iterator<Item = (&str, f64, Option<&Plan>)> {
        self.others.iter().map(|other| other.summary())
    }

    /// What the emitters radiate.
    pub(crate) fn emitted(&self) -> impl Iterator<Item = &dyn Waveform> {
        self.others.iter().map(|other| other.waveform())
    }

    /// Grids of one worker, bytes.
    pub(crate) fn grid_bytes(&self) -> u64 {
        let own = self.echo.grid_bytes();
        self.others.iter().fold(own, |sum, other| sum.saturating_add(other.grid_bytes()))
    }

    /// Panels and double bounces of ships that echo by their mesh.
    pub(crate) fn ship_paths(&self) -> usize {
        self.generator().ship_paths()
    }

    /// About what ships that echo by their mesh take with so many workers, bytes.
    pub(crate) fn ship_bytes(&self, threads: usize) -> u64 {
        let Needs { lists, panel_pulses, .. } = self.echo.needs();
        let sizes = [self.layout.pairs, self.echo_channels()];
        let each = memory::path_bytes(sizes, lists, panel_pulses).saturating_mul(threads as u64);
        (self.ship_paths() as u64).saturating_mul(each.saturating_add(memory::SHARED_PATH_BYTES))
    }

    /// About what breaking waves take with so many workers, bytes: lists of paths and factors of a block, and
    /// those that are kept for all.
    pub(crate) fn breaker_bytes(&self, threads: usize) -> u64 {
        let pulses = self.block_pulses();
        let lists = self.echo.needs().lists;
        let (count, kept) = self.generator().breakers_within(pulses);
        let each = memory::path_bytes([self.layout.pairs, self.echo_channels()], lists, pulses as usize);
        kept.saturating_add((count as u64).saturating_mul(each.saturating_mul(threads as u64)))
    }

    /// About what the far sea takes with so many workers, bytes: cells that are kept for all, a list of those
    /// of a pulse by itself, and factors of a tile in a block.
    pub(crate) fn far_bytes(&self, threads: usize) -> u64 {
        let generator = self.generator();
        let cells = generator.far_cells().map_or(0.0, |(cells, _)| cells);
        let sizes = [self.layout.pairs, self.echo_channels()];
        let list = (cells as u64).saturating_mul(memory::path_bytes(sizes, 1, 1));
        let rows = self.layout.pairs as u64 * self.block_pulses() * size_of::<Row>() as u64;
        let rows = if cells > 0.0 { rows } else { 0 };
        generator.far_bytes().saturating_add(list.saturating_add(rows).saturating_mul(threads as u64))
    }

    /// What pulses one by one take more than those of a block, bytes.
    pub(crate) fn single_bytes(&self, threads: usize) -> u64 {
        let alone = self.echo.needs().pulse_bytes > 0 && self.block_pulses() == 1;
        if alone { memory::single_bytes(self.facets(), threads) } else { 0 }
    }

    /// Facets of the patch of sea; 0 without one.
    pub fn facets(&self) -> usize {
        self.generator().facets()
    }

    /// Facets, targets and, where it is received, the direct path: what a pulse may have scatterer paths of.
    pub fn paths(&self) -> usize {
        self.facets() + self.generator().point_count()
    }

    /// An empty slot for a pulse.
    pub fn slot(&self) -> Pulse {
        Pulse::new(&self.layout)
    }

    /// The transmitted pulse after the receive filter; see [`Receiver::replica`]. Of pulses in turn one after
    /// the other, each as long as the longest; of a radar that dechirps, the tone of frequency 0 that the
    /// delay of its reference gives.
    pub fn replica(&self) -> Vec<Complex32> {
        if self.reception.dechirp.is_none() {
            let length = self.waveform.span_samples(self.sample_rate_hz);
            let of = |pulse: &dyn Waveform| {
                let mut replica = self.reception.receiver.replica(pulse);
                replica.resize(length, Complex32::ZERO);
                replica
            };
            return pulses(self.waveform.as_ref()).into_iter().flat_map(of).collect();
        }
        // What comes back with the delay of the reference.
        let samples = self.waveform.span_samples(self.sample_rate_hz).min(self.layout.samples);
        vec![Complex32::new(1.0, 0.0); samples]
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
        let generator = self.generator();
        generator.beyond_horizon(generator.emission_at(index))
    }

    /// Cells of the far sea at a pulse, mean, and in a resolution cell; `None` without it.
    pub fn far_sea(&self) -> Option<(f64, f64)> {
        self.generator().far_cells()
    }

    /// Points that stand for rain at a pulse, mean, and in a resolution cell; `None` where it returns no
    /// echo.
    pub fn rain(&self) -> Option<(f64, f64)> {
        self.generator().rains().then(|| (self.generator().drops(), self.generator().drops_per_cell()))
    }

    /// Heights of the land; `None` without any.
    pub fn dem(&self) -> Option<Arc<Dem>> {
        self.generator().dem()
    }

    /// The facets of the sea as a pulse's emission illuminates them, one snapshot for each of `pulses`; none
    /// for a scene without sea.
    ///
    /// # Errors
    /// A pulse that the run does not have, or a track that ends before it.
    pub fn snapshots(&self, pulses: &[u64]) -> Result<Vec<Snapshot>, RadarError> {
        let generator = self.generator();
        let mut work = generator.workspace();
        let of = |index: &u64| generator.snapshot(generator.emission_at(*index), &mut work).transpose();
        pulses.iter().filter_map(of).collect()
    }

    /// The scatterer paths within the receive window of a pulse, as the reference echo takes them, and the
    /// pulse with everything but its samples.
    ///
    /// # Errors
    /// A pulse that the run does not have, or a track that ends before it.
    pub fn scatterer_paths(&self, index: u64) -> Result<(Pulse, ScattererPaths), RadarError> {
        let (mut pulse, mut paths) = (self.slot(), full_list(self.generator()));
        self.generator().pulse(index, &mut self.generator().workspace(), &mut paths, &mut pulse)?;
        self.reception.dechirp.iter().for_each(|dechirp| dechirp.place(&mut pulse));
        Ok((pulse, paths))
    }

    /// The pair of each channel, as scatterer paths have them.
    pub fn channel_pairs(&self) -> &[usize] {
        self.generator().channel_pairs()
    }

    /// Whether there is a sea whose patch moves.
    pub fn follows(&self) -> bool {
        self.generator().follows()
    }

    /// What makes pulses in one thread.
    pub fn worker(&self) -> Worker<'_> {
        let fft_len = self.reception.echo_bins();
        let others = self.others.iter().map(|other| other.listener(fft_len)).collect();
        let kit = Kit::new(self.generator(), others, &self.reception);
        Worker { factory: self, echo: self.echo.worker(self.generator()), kit }
    }

    /// Pulses that are made together: 1, or those of a block.
    pub fn block_pulses(&self) -> u64 {
        self.echo.segment_pulses()
    }

    /// Those that are made together with one; the last of a run may reach beyond it.
    pub(crate) fn segment_of(&self, index: u64) -> Range<u64> {
        self.echo.segment_of(index)
    }
}
