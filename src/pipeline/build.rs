//! From a scene and settings to a running stream.
//!
//! ```text
//! generation thread (workers of a pool claim pulses and deliver them) -> ring -> pacer -> a queue per sink
//! ```
//!
//! Claims are bookkeeping only: a pulse depends on its number alone, so neither their length nor the
//! thread count changes a bit of it.

use super::factory::with_classes;
use super::fault::{BuildError, BuildErrors};
use super::memory::{Predicted, Slots, UNUSED_SLOT_BYTES, available_bytes};
use std::iter;
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Instant;

use crossbeam_channel::Sender;
use num_complex::Complex32;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::config::Run;
use crate::motion::PlatformTracks;
use crate::motion::changes::Changes;
use crate::nav::TrackSource;
use crate::pulse::Pulse;
use crate::pulse::converter::Level;
use crate::pulse::costs::Costs;
use crate::pulse::log::Log;
use crate::radar::fault::{RadarError, RadarFault};
use crate::recording::header::Header;
use crate::scene::Scene;
use crate::sea::fleet::{self, FleetError};
use crate::sinks;
use crate::sinks::sink::{SinkError, SinkReport, drain};
use crate::transport::fanout::Fed;
use crate::transport::pacer::{InHand, Status};
use crate::transport::schedule::Schedule;
use crate::transport::stage::{Outcome, RunError, Stream};
use crate::transport::view::{self, Onlooker, View};
use crate::transport::{self, Policy};

use super::changing;
use super::clock_start;
use super::control::{CommandQueue, Control, control};
use super::live::LiveNav;
use super::memory::{PROGRAM_BYTES, sea_bytes};
use super::outputs::{self, Plans, header, open_all, placed, same_kind};
use super::plausible;
use super::prepared::{Files, Prepared};
use super::stages::PulseFactory;
use super::tracks::set_tracks;
use super::workers::{Crew, generate, warm_up, yield_to_pacer};
use crate::pipeline::fault::PulseError;

pub use super::tracks::{TrackNote, tracks};

/// Bytes of samples for which a ring is made longer than its latency asks.
const RING_BYTES: usize = 256 << 20;

/// How often more than what is made at once lies in the ring of policy `relax`.
const AHEAD: u64 = 4;

/// A run that is ready to start.
pub struct PulseStream {
    factory: PulseFactory,
    /// What makes pulses at coarser errors (policy `relax`).
    coarser: Vec<PulseFactory>,
    settings: transport::Settings,
    schedule: Schedule,
    /// Whether these are all pulses of the scenario.
    is_whole: bool,
    header: Header,
    sinks: Vec<sinks::Settings>,
    plans: Plans,
    pool: ThreadPool,
    prepared: Arc<Prepared>,
    sea_bytes: u64,
    ship_bytes: u64,
    live: Option<LiveFlight>,
    /// Whether the first pulse waits until the clock shows its emission.
    waits: bool,
    changes: Option<Arc<Changes>>,
    control: Option<(Control, CommandQueue)>,
    levels: Arc<OnceLock<Vec<Level>>>,
}

/// What flies by live navigation.
struct LiveFlight {
    nav: Arc<LiveNav>,
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
///
/// # Errors
/// All faults of the input.
pub fn stream(run: &Run, range: Range<u64>) -> Result<PulseStream, BuildErrors> {
    if run.nav.iter().any(|nav| matches!(nav.truth, TrackSource::Live(_))) {
        // Nobody waits for navigation to be reported this.
        let faults = given(run, &range);
        if !faults.is_empty() {
            return Err(BuildErrors(faults));
        }
    }
    let Some((nominal, nav)) = LiveNav::open(run)? else { return on_known_tracks(run, range) };
    let mut stream = on_nominal_tracks(&nominal, range)?;
    let block_s = stream.factory.block_pulses() as f64 / run.scene.radar.emissions.mean_prf_hz();
    let needed_s = nav.needed_latency_s(block_s);
    if !run.stream.latency_given && needed_s > stream.settings.latency_s {
        stream.wait_for(needed_s);
    }
    let mut tracks = stream.prepared.tracks().to_vec();
    for (platform, (tracks, source)) in tracks.iter_mut().zip(&run.nav).enumerate() {
        if let Some(track) = nav.track(platform) {
            *tracks = set_tracks(track, source, &nominal.scene, platform)?;
        }
    }
    let tracks = changing::tracks(tracks, &nominal.scene, stream.changes.as_ref())?;
    stream.live = Some(LiveFlight { nav, tracks, needed_s });
    Ok(stream)
}

/// Makes a run ready that flies by no live navigation.
fn on_known_tracks(run: &Run, range: Range<u64>) -> Result<PulseStream, BuildErrors> {
    let begun = Instant::now();
    let stream = on_nominal_tracks(run, range.clone())?;
    let Some(later) = clock_start::later(run, begun.elapsed())? else { return Ok(stream) };
    let prepared = Arc::clone(&stream.prepared);
    // Its memory is what the next one takes.
    drop(stream);
    again(&prepared, &later, range)
}

/// What is wrong if the sea takes more than the system can give.
fn too_much(scene: &Scene, threads: usize, needed: u64) -> Option<BuildError> {
    let available = available_bytes().filter(|available| needed > *available)?;
    let facets = scene.sea.as_ref().map_or(0, |sea| sea.patch.len());
    Some(BuildError::Memory { facets, threads, needed_mib: needed >> 20, available_mib: available >> 20 })
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

/// Faults of the sea and of hulls that were not looked for, because others stopped the radar from being made.
fn unmet(scene: &Scene, files: &Files, errors: &BuildErrors) -> Vec<BuildError> {
    let of_sea = |fault: &RadarFault| matches!(fault, RadarFault::Sea(_));
    let met = errors.0.iter().any(
        |error| matches!(error, BuildError::Radar(RadarError::Faults(faults)) if faults.iter().any(of_sea)),
    );
    let Some(sea) = scene.sea.as_ref().filter(|_| !met) else { return Vec::new() };
    let reported = |name: &str| {
        errors.0.iter().any(|error| matches!(error, BuildError::Ship(fault) if fault.ship == name))
    };
    let hulls = scene.ships.iter().filter(|ship| !reported(&ship.name)).filter_map(|ship| {
        let source = fleet::hull(ship).err()?;
        Some(BuildError::Ship(FleetError { ship: ship.name.clone(), source }))
    });
    files.sea(sea, scene.seed).err().map(BuildError::Sea).into_iter().chain(hulls).collect()
}

/// Makes a run ready whose flights are known beforehand: live navigation is left alone, and its nominal
/// trajectory flown.
///
/// # Errors
/// All faults of the input.
pub fn on_nominal_tracks(run: &Run, range: Range<u64>) -> Result<PulseStream, BuildErrors> {
    built(run, range, Prepared::of)
}

/// The same of a run that differs from one that is prepared: what is not different is not read again.
///
/// # Errors
/// All faults of the input.
pub fn again(known: &Prepared, run: &Run, range: Range<u64>) -> Result<PulseStream, BuildErrors> {
    built(run, range, |run| known.again(run))
}

fn built(
    run: &Run,
    range: Range<u64>,
    prepare: impl FnOnce(&Run) -> Result<Prepared, BuildErrors>,
) -> Result<PulseStream, BuildErrors> {
    let mut faults = given(run, &range);
    let scene = &run.scene;
    let threads = match run.stream.threads {
        0 => thread::available_parallelism().map_or(1, usize::from),
        n => n,
    };
    let needed = sea_bytes(scene, &run.fidelity, threads);
    if let Some(fault) = too_much(scene, threads, needed) {
        faults.push(fault);
        return Err(BuildErrors(faults));
    }
    let changes = changing::list(run);
    let refused = |mut faults: Vec<BuildError>, files: &Files, errors: BuildErrors| {
        faults.extend(unmet(scene, files, &errors));
        faults.extend(errors.0);
        Err(BuildErrors(faults))
    };
    let prepared = match prepare(run) {
        Ok(prepared) => Arc::new(prepared),
        Err(errors) => return refused(faults, &Files::default(), errors),
    };
    faults.extend(plausible::faults(&prepared));
    let make = || {
        let tracks = changing::tracks(prepared.tracks().to_vec(), scene, changes.as_ref())?;
        // At pace `fast` nothing falls behind.
        let paced = run.stream.pace == transport::Pace::Realtime;
        let relax_db = if paced { &run.relax_db[..] } else { &[] };
        let (factory, coarser) =
            with_classes(scene, tracks, (&run.fidelity, relax_db), &run.clocks, prepared.files())?;
        let calibrated = |factory: PulseFactory| factory.with_calibration(&run.calibration, &scene.radar);
        let coarser = coarser.into_iter().map(calibrated).collect::<Result<_, _>>()?;
        let factory = calibrated(factory)?;
        changing::enter(&run.events, changes.as_ref())?;
        Ok::<_, BuildErrors>((factory, coarser))
    };
    let (factory, coarser): (_, Vec<PulseFactory>) = match make() {
        Ok(made) if faults.is_empty() => made,
        Ok(_) => return Err(BuildErrors(faults)),
        Err(errors) => return refused(faults, prepared.files(), errors),
    };
    let more = factory.breaker_bytes(threads).saturating_add(factory.single_bytes(threads));
    let needed = needed.saturating_add(more);
    if let Some(fault) = too_much(scene, threads, needed) {
        faults.push(fault);
        return Err(BuildErrors(faults));
    }
    let of_ships = factory.ship_bytes(threads);
    if let Some(available) = available_bytes().filter(|available| of_ships > *available) {
        faults.push(BuildError::ShipMemory {
            paths: factory.ship_paths(),
            threads,
            needed_mib: of_ships >> 20,
            available_mib: available >> 20,
        });
        return Err(BuildErrors(faults));
    }
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("generation {i}"))
        .start_handler(|_| yield_to_pacer())
        .build()?;
    let schedule =
        Schedule { times: scene.radar.emissions.clone(), first: range.start, count: range.end - range.start };
    let scene = prepared.files().laden(scene)?;
    let header = header(run, scene, (&factory, &coarser), &schedule, changes.as_ref());
    header.check().map_err(SinkError::from)?;
    let plans = Plans::of(run, scene, &header)?;
    // Every worker has a block in hand while one waits to be released.
    let block_pulses = coarser.iter().map(PulseFactory::block_pulses).fold(factory.block_pulses(), u64::max);
    let block = usize::try_from(block_pulses).unwrap_or(usize::MAX);
    let layout = factory.layout();
    let slot_bytes = layout.channels * layout.samples * size_of::<Complex32>();
    let wanted = block.saturating_mul(2 * threads + 1).min(RING_BYTES / slot_bytes.max(1));
    let ring_slots = run.stream.ring_slots.max(wanted);
    let batch_pulses = block_pulses.saturating_mul(threads as u64);
    let mut stream = PulseStream {
        factory,
        coarser,
        settings: transport::Settings { ring_slots, batch_pulses, ..run.stream },
        is_whole: range == (0..run.scene.pulses),
        schedule,
        header,
        sinks: run.sinks.clone(),
        plans,
        pool,
        prepared,
        sea_bytes: needed,
        ship_bytes: of_ships,
        levels: Arc::default(),
        live: None,
        waits: run.start_now && run.stream.pace == transport::Pace::Realtime,
        control: changes
            .as_ref()
            .filter(|_| run.control)
            .map(|changes| control(changes, range.end - range.start)),
        changes,
    };
    if run.stream.policy == Policy::Relax {
        stream.make_ahead();
    }
    Ok(stream)
}

impl PulseStream {
    /// The run as it is run, perhaps on a nominal trajectory or with a later start, and what its files hold.
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// Releases pulses so long after their emission, and gives the ring room for them.
    fn wait_for(&mut self, latency_s: f64) {
        let wanted = (latency_s * self.schedule.times.mean_prf_hz()).ceil() as usize + 1;
        self.settings.latency_s = latency_s;
        self.make_room(wanted);
    }

    /// Makes the ring so long, as far as its memory goes.
    fn make_room(&mut self, wanted: usize) {
        let fit = RING_BYTES / self.factory.layout.slot_bytes().max(1);
        self.settings.ring_slots = self.settings.ring_slots.max(wanted.min(fit));
    }

    /// Makes pulses so far ahead that a load is noticed before the first of them is late: twice as slow as
    /// real time, what is made at once is in time, and a few of these lie in the ring.
    fn make_ahead(&mut self) {
        let enough_s = 2.0 * self.in_hand().batch_s;
        if !self.settings.latency_given && self.settings.latency_s < enough_s {
            self.wait_for(enough_s);
        }
        let more = usize::try_from(AHEAD * self.settings.batch_pulses).unwrap_or(usize::MAX);
        self.make_room(self.settings.ring_slots.saturating_add(more));
    }

    /// Release of a pulse minus its emission, s.
    pub fn latency_s(&self) -> f64 {
        self.settings.latency_s
    }

    /// The latency, and what is made before the first pulse is there.
    pub fn in_hand(&self) -> InHand {
        InHand::of(&self.settings, &self.schedule)
    }

    /// The latency with which every pulse has interpolated navigation, s; `None` without live navigation.
    pub fn needed_latency_s(&self) -> Option<f64> {
        self.live.as_ref().map(|live| live.needed_s)
    }

    /// Live navigation of the run.
    pub fn live_navigation(&self) -> Option<Arc<LiveNav>> {
        self.live.as_ref().map(|live| Arc::clone(&live.nav))
    }

    /// What makes the pulses.
    pub fn factory(&self) -> &PulseFactory {
        &self.factory
    }

    /// What makes them of every error class: as asked, then ever coarser (policy `relax`).
    pub fn classes(&self) -> impl Iterator<Item = &PulseFactory> {
        iter::once(&self.factory).chain(&self.coarser)
    }

    /// Which pulses, and when.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Asks for changes of reports while the run goes on; `None` unless the run allows that
    /// ([`Run::control`]).
    pub fn control(&self) -> Option<Control> {
        self.control.as_ref().map(|(control, _)| control.clone())
    }

    /// A view of what will be released, for [`Self::run_in_view`], and its consumer, fed through a queue of
    /// so many pulses. It never blocks the stream: where its queue is full it alone misses pulses.
    pub fn view(&self, queue_pulses: usize) -> (View, Onlooker) {
        view::view(queue_pulses)
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

    pub(crate) fn pool(&self) -> &ThreadPool {
        &self.pool
    }

    /// About what the sea takes in all workers, bytes.
    pub(crate) fn sea_bytes(&self) -> u64 {
        self.sea_bytes
    }

    /// What the run takes of memory with these sinks, as far as it is predicted.
    pub fn predicted_bytes(&self, sinks: &[sinks::Settings]) -> Predicted {
        let grids = self.classes().map(PulseFactory::grid_bytes).fold(0, u64::saturating_add);
        let grids = grids.saturating_mul(self.threads() as u64);
        let Slots { ring, held } = Slots::of(&self.settings, sinks);
        let slot_bytes = self.factory.layout.slot_bytes() as u64;
        let of = |slots: usize, bytes: u64| (slots as u64).saturating_mul(bytes);
        let far = self.factory.far_bytes(self.threads());
        let parts = [self.sea_bytes, self.ship_bytes, far, grids, of(ring, slot_bytes)];
        let all = parts.into_iter().fold(PROGRAM_BYTES, u64::saturating_add);
        let [kept_up, at_most] =
            [slot_bytes.min(UNUSED_SLOT_BYTES), slot_bytes].map(|each| all + of(held, each));
        Predicted { kept_up, at_most }
    }

    /// Slots for pulses.
    pub(crate) fn slots(&self) -> Slots {
        Slots::of(&self.settings, &self.sinks)
    }

    /// Runs to the end or until `stop` is set; progress goes to `status`.
    ///
    /// # Errors
    /// Live navigation that does not begin, or an output that cannot be opened. What fails later is in the
    /// outcome.
    pub fn run(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
    ) -> Result<RunOutcome, BuildErrors> {
        self.run_in_view(stop, status, None)
    }

    /// Runs like [`Self::run`] while somebody looks on.
    ///
    /// # Errors
    /// As of [`Self::run`].
    pub fn run_in_view(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
        view: Option<View>,
    ) -> Result<RunOutcome, BuildErrors> {
        self.start(stop, status, view, None).map(|(outcome, _)| outcome)
    }

    /// Runs like [`Self::run`] and hands every released pulse to `see` as well, in a thread and through a
    /// queue of its own.
    ///
    /// # Errors
    /// As of [`Self::run`].
    pub fn tap(
        self,
        stop: &Arc<AtomicBool>,
        mut see: impl FnMut(&Pulse) + Send,
    ) -> Result<RunOutcome, BuildErrors> {
        self.start(stop, None, None, Some(&mut see)).map(|(outcome, _)| outcome)
    }

    /// What a sink is reported before the first pulse.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The same, with progress, and reports what the workers have spent.
    ///
    /// # Errors
    /// As of [`Self::run`].
    pub fn measure(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
        mut see: impl FnMut(&Pulse) + Send,
    ) -> Result<(RunOutcome, Costs), BuildErrors> {
        self.start(stop, status, None, Some(&mut see))
    }

    fn start(
        self,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
        view: Option<View>,
        tap: Option<&mut (dyn FnMut(&Pulse) + Send)>,
    ) -> Result<(RunOutcome, Costs), BuildErrors> {
        let Self {
            factory,
            coarser,
            settings,
            schedule,
            header,
            sinks,
            plans,
            pool,
            live,
            control,
            levels,
            is_whole,
            waits,
            ..
        } = self;
        let (asked, policy) = (is_whole.then_some(schedule.count), settings.policy);
        let commands = control.map(|(_, commands)| commands);
        let range = schedule.first..schedule.end();
        let first = schedule.times.emission(header.start, range.start);
        let mut stream = Stream::new(settings, schedule, *factory.layout(), Arc::clone(stop));
        if let Some(status) = status {
            stream.status(status);
        }
        if let Some(view) = view {
            stream.view(view);
        }
        let classes: Vec<&PulseFactory> = iter::once(&factory).chain(&coarser).collect();
        let crew = || -> Crew<'_> { classes.iter().map(|factory| factory.worker()).collect() };
        let mut crews: Vec<Crew<'_>> = (0..pool.current_num_threads()).map(|_| crew()).collect();
        let begun = Instant::now();
        pool.install(|| warm_up(&classes, &range, &mut crews));
        let nav = match live {
            Some(live) => {
                live.nav.took(begun.elapsed());
                classes.iter().for_each(|factory| factory.fly(live.tracks.clone()));
                live.nav.await_begin(first, stop)?;
                Some(live.nav)
            }
            None => None,
        };
        let opened = open_all(&sinks, &header, &plans)?;
        for (place, (settings, sink)) in sinks.iter().zip(opened).enumerate() {
            let name = match sinks.iter().take(place).filter(|s| same_kind(&s.kind, &settings.kind)).count() {
                0 => sink.name().to_owned(),
                n => format!("{} {}", sink.name(), n + 1),
            };
            let take = move |feed| drain(sink, feed).map(Some);
            stream.sink_as(&name, settings.queue_pulses, settings.role(), take)?;
        }
        if let Some(see) = tap {
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
        if waits {
            clock_start::wait(first, stop)?;
        }
        let outcome = stream.run(|source| {
            // The loop runs inside the pool: handing work in from outside would allocate.
            pool.install(|| generate(source, &classes, nav.as_deref(), range, &mut crews, commands))
        });
        let mut costs = Costs::default();
        let workers = || crews.iter().flatten();
        workers().for_each(|worker| costs.add(worker.costs()));
        let _ = levels.set(sum_of(workers().map(|worker| worker.levels())));
        Ok((placed(outcome, asked, policy), costs))
    }
}

/// Levels of several workers together.
pub(crate) fn sum_of<'a>(workers: impl Iterator<Item = &'a [Level]>) -> Vec<Level> {
    let mut sum = Vec::new();
    for levels in workers {
        sum.resize(levels.len(), Level::default());
        sum.iter_mut().zip(levels).for_each(|(to, from): (&mut Level, _)| to.add(from));
    }
    sum
}
