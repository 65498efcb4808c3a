//! From a scene and settings to a running stream.
//!
//! ```text
//! generation thread (workers of a pool claim pulses and deliver them) -> ring -> pacer -> a queue per sink
//! ```
//!
//! Claims are bookkeeping only: a pulse depends on its number alone, so neither their length nor the
//! thread count changes a bit of it.

use std::fs;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Instant;

use crossbeam_channel::Sender;
use num_complex::Complex32;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use thiserror::Error;
use thread_priority::ThreadPriority;

use crate::config::Run;
use crate::echo::Fidelity;
use crate::echo::synth::SynthError;
use crate::motion::track::TrackError;
use crate::motion::{PlatformTracks, SourceError};
use crate::nav::TrackSource;
use crate::nav::changes::{ChangeFault, Changes};
use crate::plan::PlanError;
use crate::pulse::converter::Level;
use crate::pulse::costs::Costs;
use crate::pulse::log::Log;
use crate::pulse::{Layout, Pulse};
use crate::radar::calibration::CalibrationFault;
use crate::radar::clock::{ClockFault, RunningClocks};
use crate::radar::fault::{RadarError, RadarFault};
use crate::radar::illumination::Illumination;
use crate::radar::receiver::Receiver;
use crate::radar::waveform::{self, WaveformError};
use crate::scene::Scene;
use crate::scene::clock::Clocks;
use crate::sea::fleet::{self, FleetError, FleetErrors};
use crate::sea::realise::{RealiseError, realise};
use crate::sinks;
use crate::sinks::sink::{Header, SinkError, SinkReport, drain};
use crate::transport::fanout::Fed;
use crate::transport::pacer::Status;
use crate::transport::schedule::Schedule;
use crate::transport::stage::{Outcome, RunError, Source, Stream};
use crate::transport::{self, StreamError};

use super::aboard::{self, ShipTracks};
use super::changing;
use super::control::{Control, Desk, control};
use super::dry_run;
use super::live::{LiveFault, LiveNav};
use super::memory::{PROGRAM_BYTES, sea_bytes};
use super::outputs::{self, header, open_all, placed, same_kind};
use super::plausible;
use super::stages::{Echo, PulseError, PulseFactory, Workspace};
use super::tracks::flown;

pub use super::tracks::{TrackNote, tracks};

/// Bytes of samples for which a ring is made longer than its latency asks.
const RING_BYTES: usize = 256 << 20;

/// Priority of a worker from 0 to 99, where 50 is that of an ordinary thread: nice 9.
const WORKER_PRIORITY: u8 = 23;

/// Why a run cannot be started. Each entry is one fault of the input.
#[derive(Debug, Error)]
pub enum BuildError {
    /// A platform's track.
    #[error("platform '{platform}', {role} track: {source}")]
    Track {
        /// The platform.
        platform: String,
        /// `true` or `reported`.
        role: &'static str,
        /// What is wrong.
        source: SourceError,
    },
    /// A track that ends early, met while looking ahead.
    #[error("platform '{platform}', at pulse {pulse}: {source}")]
    Lost {
        /// The platform.
        platform: String,
        /// The pulse.
        pulse: u64,
        /// Why.
        source: TrackError,
    },
    /// A track that does not reach to a time that was asked for.
    #[error("platform '{platform}', {time_s} s after pulse 0: {source}")]
    Away {
        /// The platform.
        platform: String,
        /// The time, s.
        time_s: f64,
        /// Why.
        source: TrackError,
    },
    /// The sea, told beside faults of other parts.
    #[error("sea: {0}")]
    Sea(#[from] RealiseError),
    /// A ship, told beside faults of other parts.
    #[error(transparent)]
    Ship(#[from] FleetError),
    /// The waveform.
    #[error(transparent)]
    Waveform(#[from] WaveformError),
    /// The instrument or its way through the scene.
    #[error(transparent)]
    Radar(#[from] RadarError),
    /// A clock.
    #[error(transparent)]
    Clock(#[from] ClockFault),
    /// The fast echo.
    #[error(transparent)]
    Echo(#[from] SynthError),
    /// Live navigation.
    #[error("platform '{platform}', live navigation: {source}")]
    Live {
        /// The platform.
        platform: String,
        /// What is wrong.
        source: LiveFault,
    },
    /// An antenna in the water.
    #[error(
        "antenna \"{antenna}\" of platform '{platform}' is {depth_m:.2} m below mean sea level at pulse {pulse}; allowed: on or \
         above it (look at the track, its datum, scene.origin_h_m and lever_arm_m)"
    )]
    BelowSea {
        /// The transmitter or receiver.
        antenna: String,
        /// Its platform.
        platform: String,
        /// Depth, m.
        depth_m: f64,
        /// Where it is deepest.
        pulse: u64,
    },
    /// A pulse from a file that lasts too long.
    #[error(
        "the pulse of {}, {pulse_us} us, is longer than the shortest pulse interval, {pri_us} us: two pulses would leave at once; \
         allowed: a lower radar.prf_hz, or a shorter pulse",
        path.display()
    )]
    LongPulse {
        /// The file.
        path: PathBuf,
        /// Its length, us.
        pulse_us: f64,
        /// The shortest interval, us.
        pri_us: f64,
    },
    /// A pulse of the trial.
    #[error(transparent)]
    Pulse(PulseError),
    /// A sink's output.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// Pulses that the run does not have.
    #[error("pulses {from}..{to} are not part of the run; allowed: at least one pulse within 0..{pulses}")]
    Range {
        /// First pulse asked.
        from: u64,
        /// One past the last pulse asked.
        to: u64,
        /// Pulses of the run.
        pulses: u64,
    },
    /// More than the machine has.
    #[error(
        "a sea of {facets} facets takes about {needed_mib} MiB with {threads} threads, {available_mib} MiB are available; \
         allowed: fewer facets (scene.patch_size_m, scene.facet_m) or fewer stream.threads"
    )]
    Memory {
        /// Facets of the patch.
        facets: usize,
        /// Workers, each with a sea of its own.
        threads: usize,
        /// What they need.
        needed_mib: u64,
        /// What is free.
        available_mib: u64,
    },
    /// A calibration channel.
    #[error(transparent)]
    Calibration(#[from] CalibrationFault),
    /// A change of the scenario.
    #[error("event: {0}")]
    Change(#[from] ChangeFault),
    /// The worker threads.
    #[error("worker threads: {0}")]
    Pool(#[from] ThreadPoolBuildError),
    /// The stream.
    #[error(transparent)]
    Stream(#[from] StreamError),
}

/// Every fault found while building a run.
#[derive(Debug, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct BuildErrors(pub Vec<BuildError>);

impl From<PulseError> for BuildError {
    fn from(error: PulseError) -> Self {
        match error {
            PulseError::Radar(error) => error.into(),
            PulseError::Echo(error) => error.into(),
            PulseError::Unplaced { .. } => Self::Pulse(error),
        }
    }
}

impl From<PlanError> for BuildError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Radar(error) => error.into(),
            PlanError::Echo(error) => error.into(),
        }
    }
}

impl<E: Into<BuildError>> From<E> for BuildErrors {
    fn from(error: E) -> Self {
        Self(vec![error.into()])
    }
}

impl From<FleetErrors> for BuildErrors {
    fn from(errors: FleetErrors) -> Self {
        Self(errors.0.into_iter().map(BuildError::Ship).collect())
    }
}

/// What makes the pulses of a scene whose platforms move on the given tracks.
///
/// This is the way in for a scene built in Rust; see `examples/scene_in_rust.rs`.
pub fn factory(scene: &Scene, tracks: Vec<PlatformTracks>) -> Result<PulseFactory, BuildErrors> {
    factory_of(scene, tracks, &Fidelity::Reference)
}

/// The same with a choice of how echoes are made.
pub fn factory_of(
    scene: &Scene,
    tracks: Vec<PlatformTracks>,
    fidelity: &Fidelity,
) -> Result<PulseFactory, BuildErrors> {
    factory_by(scene, tracks, fidelity, &Clocks::default())
}

/// The same with clocks that are wrong.
pub fn factory_by(
    scene: &Scene,
    tracks: Vec<PlatformTracks>,
    fidelity: &Fidelity,
    clocks: &Clocks,
) -> Result<PulseFactory, BuildErrors> {
    let scene = &*aboard::with_scatterers(scene)?;
    let waveform = waveform::from_description(&scene.radar.waveform)?;
    let radar = &scene.radar;
    let sample_rate_hz = radar.sample_rate_hz;
    let illumination = Illumination::new(scene, waveform.duration_s(), tracks)?;
    let (bandwidth_hz, pulse_s) = (waveform.bandwidth_hz(), waveform.duration_s());
    let clocks = RunningClocks::new(clocks, radar, scene.seed, scene.pulses, bandwidth_hz, pulse_s)?;
    let clocks = clocks.map(Arc::new);
    let illumination = illumination.with_clocks(clocks.clone());
    let plan = match fidelity {
        Fidelity::Reference => None,
        Fidelity::Fast(asked) => Some(dry_run::plan(scene, &illumination, &waveform, asked)?),
    };
    let echo = Echo::of(plan.as_ref(), radar, scene.pulses, &illumination, &waveform)?;
    let receiver = Receiver::new(&scene.radar, scene.seed, echo.fft_len(), scene.radar.channels.len());
    let ships = ShipTracks::of(scene);
    let layout = Layout {
        ships: scene.ships.len(),
        clocks: clocks.as_ref().map_or(0, |clocks| clocks.count()),
        ..scene.radar.layout(scene.platforms.len(), scene.targets.len())
    };
    let generators = None;
    Ok(PulseFactory {
        illumination,
        echo,
        sample_rate_hz,
        receiver,
        waveform,
        layout,
        ships,
        plan,
        clocks,
        generators,
    })
}

/// A run that is ready to start.
pub struct PulseStream {
    factory: PulseFactory,
    settings: transport::Settings,
    schedule: Schedule,
    /// Whether these are all pulses of the scenario.
    is_whole: bool,
    header: Header,
    sinks: Vec<sinks::Settings>,
    pool: ThreadPool,
    notes: Vec<TrackNote>,
    sea_bytes: u64,
    live: Option<Flown>,
    changes: Option<Arc<Changes>>,
    control: Option<(Control, Desk)>,
    levels: Arc<OnceLock<Vec<Level>>>,
}

/// What flies by live navigation.
struct Flown {
    nav: Arc<LiveNav>,
    /// The run with tracks that are known beforehand.
    rehearsed: Run,
    tracks: Vec<PlatformTracks>,
    /// Latency with which every pulse is interpolated, s.
    needed_s: f64,
}

/// How a run ended.
pub type RunOutcome = Outcome<Option<SinkReport>, PulseError, SinkError>;

/// Why a run failed after it had started.
pub type RunFailure = RunError<PulseError, SinkError>;

/// Makes a run ready: loads tracks, patterns and waveform, checks the outputs. Every fault found is
/// reported, and nothing has been written when there is one.
pub fn stream(run: &Run, range: Range<u64>) -> Result<PulseStream, BuildErrors> {
    if run.nav.iter().any(|nav| matches!(nav.truth, TrackSource::Live(_))) {
        // Nobody waits for navigation to be told this.
        let faults = given(run, &range);
        if !faults.is_empty() {
            return Err(BuildErrors(faults));
        }
    }
    let Some((rehearsed, nav)) = LiveNav::open(run)? else { return rehearse(run, range) };
    let mut stream = rehearse(&rehearsed, range)?;
    let block_s = stream.factory.block_pulses() as f64 / run.scene.radar.emissions.mean_prf_hz();
    let needed_s = nav.needed_latency_s(block_s);
    if !run.stream.latency_given && needed_s > stream.settings.latency_s {
        stream.wait_for(needed_s);
    }
    let mut tracks = tracks(&rehearsed.nav, &rehearsed.scene)?.0;
    for (platform, (tracks, source)) in tracks.iter_mut().zip(&run.nav).enumerate() {
        if let Some(track) = nav.track(platform) {
            *tracks = flown(track, source, &rehearsed.scene, platform)?;
        }
    }
    let tracks = changing::tracks(tracks, &rehearsed.scene, stream.changes.as_ref())?;
    stream.live = Some(Flown { nav, rehearsed, tracks, needed_s });
    Ok(stream)
}

/// Faults of outputs and of the pulses that are asked.
fn given(run: &Run, range: &Range<u64>) -> Vec<BuildError> {
    let mut faults: Vec<BuildError> =
        outputs::preflight(&run.sinks).into_iter().map(BuildError::from).collect();
    let pulses = run.scene.pulses;
    if range.is_empty() || range.end > pulses {
        faults.push(BuildError::Range { from: range.start, to: range.end, pulses });
    }
    faults
}

/// Makes a run ready whose flights are known beforehand: live navigation is left alone, and its rehearsal flown.
pub fn rehearse(run: &Run, range: Range<u64>) -> Result<PulseStream, BuildErrors> {
    let mut faults = given(run, &range);
    let scene = &run.scene;
    let threads = match run.stream.threads {
        0 => thread::available_parallelism().map_or(1, usize::from),
        n => n,
    };
    let needed = sea_bytes(scene, &run.fidelity, threads);
    if let Some(available) = available_bytes().filter(|available| needed > *available) {
        let facets = scene.sea.as_ref().map_or(0, |sea| sea.patch.len());
        faults.push(BuildError::Memory {
            facets,
            threads,
            needed_mib: needed >> 20,
            available_mib: available >> 20,
        });
        return Err(BuildErrors(faults));
    }
    let changes = changing::list(run);
    let built = tracks(&run.nav, scene).and_then(|(tracks, notes)| {
        faults.extend(plausible::faults(run, &tracks));
        let tracks = changing::tracks(tracks, scene, changes.as_ref())?;
        let factory = factory_by(scene, tracks, &run.fidelity, &run.clocks)?
            .with_calibration(&run.calibration, &scene.radar)?;
        changing::enter(&run.events, changes.as_ref())?;
        Ok((factory, notes))
    });
    let (factory, notes) = match built {
        Ok(built) if faults.is_empty() => built,
        Ok(_) => return Err(BuildErrors(faults)),
        Err(errors) => {
            // Where something else stopped the radar from being made, its sea has not been looked at.
            let of_sea = |fault: &RadarFault| matches!(fault, RadarFault::Sea(_));
            let met = errors.0.iter().any(|error| {
                matches!(error, BuildError::Radar(RadarError::Faults(faults)) if faults.iter().any(of_sea))
            });
            if let Some(sea) = scene.sea.as_ref().filter(|_| !met) {
                faults.extend(realise(sea, scene.seed).err().map(BuildError::Sea));
                let told = |name: &str| {
                    errors
                        .0
                        .iter()
                        .any(|error| matches!(error, BuildError::Ship(fault) if fault.ship == name))
                };
                let hulls = scene.ships.iter().filter(|ship| !told(&ship.name)).filter_map(|ship| {
                    let source = fleet::hull(ship).err()?;
                    Some(BuildError::Ship(FleetError { ship: ship.name.clone(), source }))
                });
                faults.extend(hulls);
            }
            faults.extend(errors.0);
            return Err(BuildErrors(faults));
        }
    };
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("generation {i}"))
        .start_handler(|_| yield_to_pacer())
        .build()?;
    let schedule =
        Schedule { times: scene.radar.emissions.clone(), first: range.start, count: range.end - range.start };
    let scene = aboard::with_scatterers(scene)?;
    let header = header(run, &scene, &factory, &schedule, changes.as_ref());
    header.check()?;
    // Every worker has a block in hand while one waits to be released.
    let block = usize::try_from(factory.block_pulses()).unwrap_or(usize::MAX);
    let layout = factory.layout();
    let slot_bytes = layout.channels * layout.samples * size_of::<Complex32>();
    let wanted = block.saturating_mul(2 * threads + 1).min(RING_BYTES / slot_bytes.max(1));
    let ring_slots = run.stream.ring_slots.max(wanted);
    let batch_pulses = factory.block_pulses().saturating_mul(threads as u64);
    Ok(PulseStream {
        factory,
        settings: transport::Settings { ring_slots, batch_pulses, ..run.stream },
        is_whole: range == (0..run.scene.pulses),
        schedule,
        header,
        sinks: run.sinks.clone(),
        pool,
        notes,
        sea_bytes: needed,
        levels: Arc::default(),
        live: None,
        control: changes
            .as_ref()
            .filter(|_| run.control)
            .map(|changes| control(changes, range.end - range.start)),
        changes,
    })
}

/// Memory that the system says it can give, bytes; `None` where it does not say.
pub(crate) fn available_bytes() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

impl PulseStream {
    /// The run as it is rehearsed, where live navigation flies it.
    pub fn rehearsed(&self) -> Option<&Run> {
        self.live.as_ref().map(|flown| &flown.rehearsed)
    }

    /// Releases pulses so long after their emission, and gives the ring room for them.
    fn wait_for(&mut self, latency_s: f64) {
        let wanted = (latency_s * self.schedule.times.mean_prf_hz()).ceil() as usize + 1;
        let fit = RING_BYTES / self.factory.layout.slot_bytes().max(1);
        self.settings.latency_s = latency_s;
        self.settings.ring_slots = self.settings.ring_slots.max(wanted.min(fit));
    }

    /// Release of a pulse minus its emission, s.
    pub fn latency_s(&self) -> f64 {
        self.settings.latency_s
    }

    /// The latency with which every pulse has interpolated navigation, s; `None` without live navigation.
    pub fn needed_latency_s(&self) -> Option<f64> {
        self.live.as_ref().map(|flown| flown.needed_s)
    }

    /// Live navigation of the run.
    pub fn live_navigation(&self) -> Option<Arc<LiveNav>> {
        self.live.as_ref().map(|flown| Arc::clone(&flown.nav))
    }

    /// How the tracks were made.
    pub fn notes(&self) -> &[TrackNote] {
        &self.notes
    }

    /// What makes the pulses.
    pub fn factory(&self) -> &PulseFactory {
        &self.factory
    }

    /// Which pulses, and when.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Asks for changes of reports while the run goes on; `None` unless the run allows that ([`Run::control`]).
    pub fn control(&self) -> Option<Control> {
        self.control.as_ref().map(|(control, _)| control.clone())
    }

    /// What the converter of each channel is fed with: set when the run has ended, empty without a converter.
    pub fn levels(&self) -> Arc<OnceLock<Vec<Level>>> {
        Arc::clone(&self.levels)
    }

    /// What is changed of reports; `None` where nothing can be.
    pub fn log(&self) -> Option<Arc<Log>> {
        self.header.changes.clone()
    }

    /// Worker threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    pub(super) fn pool(&self) -> &ThreadPool {
        &self.pool
    }

    /// About what the sea takes in all workers, bytes.
    pub(super) fn sea_bytes(&self) -> u64 {
        self.sea_bytes
    }

    /// What the run takes of memory, bytes, as far as it is predicted.
    pub fn predicted_bytes(&self) -> u64 {
        let grids = self.factory.grid_bytes().saturating_mul(self.threads() as u64);
        let waiting = (self.waiting_pulses() * self.factory.layout.slot_bytes()) as u64;
        PROGRAM_BYTES.saturating_add(self.sea_bytes).saturating_add(grids).saturating_add(waiting)
    }

    /// Slots of the ring and of all queues.
    pub(super) fn waiting_pulses(&self) -> usize {
        self.settings.ring_slots + self.sinks.iter().map(|sink| sink.queue_pulses).sum::<usize>()
    }

    /// Runs to the end or until `stop` is set; progress goes to `status`.
    pub fn run(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
    ) -> Result<RunOutcome, BuildErrors> {
        self.start(stop, status, None::<fn(&Pulse)>).map(|(outcome, _)| outcome)
    }

    /// Runs like [`Self::run`] and hands every released pulse to `see` as well, in a thread and through a
    /// queue of its own.
    pub fn tap(
        self,
        stop: &Arc<AtomicBool>,
        see: impl FnMut(&Pulse) + Send,
    ) -> Result<RunOutcome, BuildErrors> {
        self.start(stop, None, Some(see)).map(|(outcome, _)| outcome)
    }

    /// The same, with progress, and tells what the workers have spent.
    pub fn measure(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
        see: impl FnMut(&Pulse) + Send,
    ) -> Result<(RunOutcome, Costs), BuildErrors> {
        self.start(stop, status, Some(see))
    }

    fn start(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
        tap: Option<impl FnMut(&Pulse) + Send>,
    ) -> Result<(RunOutcome, Costs), BuildErrors> {
        let Self { mut factory, settings, schedule, header, sinks, pool, live, control, levels, .. } = self;
        let asked = self.is_whole.then_some(schedule.count);
        let desk = control.map(|(_, desk)| desk);
        let range = schedule.first..schedule.end();
        let first = schedule.times.emission(header.start, range.start);
        let mut stream = Stream::new(settings, schedule, *factory.layout(), Arc::clone(stop));
        if let Some(status) = status {
            stream.status(status);
        }
        let mut workspaces: Vec<Workspace> =
            (0..pool.current_num_threads()).map(|_| factory.workspace()).collect();
        let begun = Instant::now();
        pool.install(|| warm_up(&factory, &range, &mut workspaces));
        let nav = match live {
            Some(flown) => {
                flown.nav.took(begun.elapsed());
                factory.illumination.fly(flown.tracks);
                flown.nav.await_begin(first, stop)?;
                Some(flown.nav)
            }
            None => None,
        };
        let factory = factory;
        let opened = open_all(&sinks, &header)?;
        for (place, (settings, sink)) in sinks.iter().zip(opened).enumerate() {
            let name = match sinks.iter().take(place).filter(|s| same_kind(&s.kind, &settings.kind)).count() {
                0 => sink.name().to_owned(),
                n => format!("{} {}", sink.name(), n + 1),
            };
            stream.sink(&name, settings.queue_pulses, move |feed| drain(sink, feed).map(Some))?;
        }
        if let Some(mut see) = tap {
            stream.sink("tap", settings.ring_slots, move |mut feed| {
                loop {
                    let fed = feed.next(sinks::sink::FLUSH_INTERVAL, |pulse| {
                        see(pulse);
                        Ok::<_, SinkError>(())
                    })?;
                    if matches!(fed, Fed::Ended) {
                        return Ok(None);
                    }
                }
            })?;
        }
        let outcome = stream.run(|source| {
            // The loop runs inside the pool: handing work in from outside would allocate.
            pool.install(|| generate(source, &factory, nav.as_deref(), range, &mut workspaces, desk))
        });
        let mut costs = Costs::default();
        workspaces.iter().for_each(|work| costs.add(work.costs()));
        let _ = levels.set(sum_of(workspaces.iter().map(Workspace::levels)));
        Ok((placed(outcome, asked), costs))
    }
}

/// Levels of several workers together.
pub(super) fn sum_of<'a>(workers: impl Iterator<Item = &'a [Level]>) -> Vec<Level> {
    let mut sum = Vec::new();
    for levels in workers {
        sum.resize(levels.len(), Level::default());
        sum.iter_mut().zip(levels).for_each(|(to, from): (&mut Level, _)| to.add(from));
    }
    sum
}

/// Lowers the priority of a worker, so that the pacer runs as soon as its deadline wakes it. Where the system
/// refuses, pulses are released later and the lateness shows it.
fn yield_to_pacer() {
    if let Ok(level) = WORKER_PRIORITY.try_into() {
        let _ = thread_priority::set_current_thread_priority(ThreadPriority::Crossplatform(level));
    }
}

/// Lets every worker make a block before the clock starts, so that it has all the memory it will need, in runs that are longer than that.
/// What fails here fails again in the run, which tells.
fn warm_up(factory: &PulseFactory, range: &Range<u64>, work: &mut [Workspace]) {
    let block = factory.block_pulses();
    if block <= 1 || (range.end - range.start) / block <= work.len() as u64 {
        return;
    }
    work.par_iter_mut().with_max_len(1).enumerate().for_each(|(place, work)| {
        let index = range.start.saturating_add(place as u64 * block).min(range.end - 1);
        let _ = factory.make(index, &mut Pulse::new(factory.layout()), work);
        work.start_anew();
    });
}

/// Makes the pulses of `range` until all are made or the stream ends. Workers take block by block, each at its own pace: a block is made by
/// one worker, and two would each make all of it.
fn generate(
    source: &mut Source,
    factory: &PulseFactory,
    nav: Option<&LiveNav>,
    range: Range<u64>,
    work: &mut [Workspace],
    desk: Option<Desk>,
) -> Result<(), PulseError> {
    let length = factory.block_pulses();
    let due = source.due();
    let (begin, end) = (range.start, range.end);
    if let Some(desk) = &desk {
        desk.open(source.health());
    }
    // Blocks are claimed whole, but for those that the ring is too short for.
    let between = |first: u64| {
        if let Some(desk) = &desk {
            let last = |first: u64| (first - 1) / length * length + length - 1;
            let untouched = || match first {
                first if first == begin => first,
                first => factory.illumination.first_untouched(last(first)),
            };
            desk.serve(untouched, end);
        }
    };
    let crew = source.crew(range, work.len()).between(&between);
    work.par_iter_mut().with_max_len(1).try_for_each(|work| {
        // A worker that panics calls the others off as well: its pulses will never come.
        let _watch = crew.watch();
        while let Some(mut claim) = crew.claim(|first| first - first % length + length) {
            let begun = nav.map(|nav| {
                // A block is made whole, whatever part of it was claimed.
                let block = claim.first - claim.first % length + length;
                let after = block.max(claim.first + claim.slots.len() as u64);
                let need = factory.illumination.rests_on(after);
                nav.hold(need, due.deadline(claim.first), due.latency, due.stop());
                Instant::now()
            });
            let pulses = (claim.first..).zip(&mut claim.slots);
            for (index, slot) in pulses {
                factory.make(index, slot, work).inspect_err(|_| crew.call_off())?;
            }
            if let (Some(nav), Some(begun)) = (nav, begun) {
                nav.took(begun.elapsed());
            }
            crew.deliver(claim);
        }
        Ok(())
    })
}
