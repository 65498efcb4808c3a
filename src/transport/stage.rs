//! A running stream: generation, pacer and sinks, a thread each.
//!
//! Everything is allocated before the threads pass one barrier together; the instant at which it
//! opens is the start of the schedule. The end passes through: when generation returns, the pacer
//! releases what is in the ring and ends, then each sink empties its queue and ends. The first error
//! ends the others and is the run's error. The stop flag (Ctrl-C) is looked at by generation at its
//! next batch and by the pacer within 50 ms; sinks always empty their queues and close.
//!
//! ```
//! use std::sync::{Arc, atomic::AtomicBool};
//! use nereus::{pulse::{Layout, SampleFormat}, time::PulseTimes};
//! use nereus::transport::{Pace, Policy, Settings, fanout::Fed, schedule::Schedule, stage::Stream};
//!
//! let settings =
//!     Settings { pace: Pace::Fast, policy: Policy::Stop, latency_s: 0.1, ring_slots: 8, threads: 1, ..Settings::default() };
//! let schedule = Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count: 20 };
//! let layout = Layout { channels: 1, samples: 4, format: SampleFormat::Cf32, platforms: 0,
//!     antennas: 0, targets: 0, pairs: 0, windows: 0, ships: 0, clocks: 0 };
//! let mut stream = Stream::new(settings, schedule, layout, Arc::new(AtomicBool::new(false)));
//! stream.sink("count", 4, |mut feed| {
//!     let mut last = None;
//!     loop {
//!         match feed.next(std::time::Duration::from_secs(1), |pulse| Ok::<_, String>(pulse.index))? {
//!             Fed::Pulse(index) => last = Some(index),
//!             Fed::Idle => {}
//!             Fed::Ended => return Ok::<_, String>(last),
//!         }
//!     }
//! }).unwrap();
//! let outcome = stream.run(|source| {
//!     for index in 0..20 {
//!         let Some(batch) = source.reserve(1) else { break };
//!         batch[0].index = index;
//!         source.commit(1);
//!     }
//!     Ok::<(), ()>(())
//! });
//! assert!(outcome.result.is_ok());
//! assert_eq!(outcome.summary.health.pulses, 20);
//! assert_eq!(outcome.reports, [("count".to_owned(), Some(19))]);
//! ```

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use serde::Serialize;
use thiserror::Error;

use crate::pulse::{Layout, Pulse};

use super::fanout::{FanOut, Feed, Outlet, Role, outlet};
use super::health::{Health, SinkHealth, Snapshot};
use super::pacer::{Pacer, PacerError, Status, Worth};
use super::rights;
use super::ring::{Producer, Slot, ring};
use super::schedule::Schedule;
use super::view::View;
use super::{Pace, Settings, StreamError};
use crate::transport::dispatcher::Dispatcher;

/// What a sink's thread does with its feed.
type SinkBody<'env, R, S> = Box<dyn FnOnce(Feed) -> Result<R, S> + Send + 'env>;

/// A sink that is to be started.
struct Waiting<'env, R, S> {
    name: String,
    role: Role,
    outlet: Outlet,
    feed: Feed,
    body: SinkBody<'env, R, S>,
}

/// A stream that is being put together. `R` is what a sink's thread returns, `S` its error.
pub struct Stream<'env, R, S> {
    settings: Settings,
    schedule: Schedule,
    layout: Layout,
    stop: Arc<AtomicBool>,
    status: Option<Sender<Status>>,
    view: Option<View>,
    sinks: Vec<Waiting<'env, R, S>>,
}

/// Where generation gets slots and delivers pulses.
#[derive(Debug)]
pub struct Source {
    ring: Producer<Slot<Pulse>>,
    layout: Layout,
    worth: Worth,
    stop: Arc<AtomicBool>,
    health: Arc<Health>,
    busy_since: Instant,
    due: Due,
}

/// When pulses are due.
#[derive(Clone, Debug)]
pub struct Due {
    schedule: Schedule,
    begun: Instant,
    stop: Arc<AtomicBool>,
    /// From the emission of a pulse to its release.
    pub latency: Duration,
}

impl Due {
    fn new(schedule: &Schedule, latency_s: f64, stop: &Arc<AtomicBool>) -> Self {
        let latency = Duration::try_from_secs_f64(latency_s.max(0.0)).unwrap_or_default();
        Self { schedule: schedule.clone(), begun: Instant::now(), stop: Arc::clone(stop), latency }
    }

    /// When a pulse is to be released; policy `slip` is not foreseen.
    pub fn deadline(&self, index: u64) -> Instant {
        Schedule::after(self.begun, self.latency.saturating_add(self.schedule.offset(index)))
    }

    /// Set when the run is to end.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// Why a run failed. `G` is generation's error, `S` a sink's.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RunError<G, S> {
    /// Generation failed.
    #[error("echo generation: {0}")]
    Generation(G),
    /// The pacer ended the run.
    #[error(transparent)]
    Pacer(PacerError),
    /// A sink failed.
    #[error("sink '{name}': {error}")]
    Sink {
        /// Which.
        name: String,
        /// Why.
        error: S,
    },
    /// A sink failed, and the run went on to its end without it.
    #[error("sink '{name}' failed and the run went on without it (on_failure = \"continue\"): {error}")]
    Without {
        /// Which.
        name: String,
        /// Why.
        error: S,
    },
    /// A sink missed pulses, and the policy allows no loss.
    #[error(
        "sink '{name}' missed {missed} of {pulses} pulses: its queue was full. Allowed: a larger sink.queue_pulses, a \
         faster output, policy = \"slip\", policy = \"drop\" (which allows losses), or --pace fast"
    )]
    Missed {
        /// Which.
        name: String,
        /// Pulses that it missed.
        missed: u64,
        /// Pulses released.
        pulses: u64,
    },
    /// The stream could not be set up.
    #[error(transparent)]
    Stream(StreamError),
    /// A thread panicked: a fault of the program.
    #[error("thread '{thread}' panicked; this is a fault of the program")]
    Panic {
        /// Its name.
        thread: String,
    },
}

/// Figures of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// All counters.
    #[serde(flatten)]
    pub health: Snapshot,
    /// Wall time from the barrier to the end of the last thread, seconds.
    pub elapsed_s: f64,
    /// Emission time made per second of generation at work: above 1, generation keeps up.
    pub real_time_factor: f64,
    /// Mean of release minus emission, milliseconds, with what policy `slip` has moved; none at pace `fast`.
    pub latency_ms: Option<f64>,
    /// The run was ended by the stop flag.
    pub stopped: bool,
}

/// What became of a run.
#[derive(Debug)]
pub struct Outcome<R, G, S> {
    /// Its figures, also when it failed.
    pub summary: Summary,
    /// What the sinks that ended well returned, by name.
    pub reports: Vec<(String, R)>,
    /// Sinks that failed while the run went on without them, and why.
    pub failed: Vec<(String, S)>,
    /// Done, or the first error.
    pub result: Result<(), RunError<G, S>>,
}

/// Threads arrive, one opens.
#[derive(Default)]
struct Barrier {
    state: Mutex<BarrierState>,
    changed: Condvar,
}

#[derive(Clone, Copy, Default)]
struct BarrierState {
    arrived: usize,
    opened: Option<Instant>,
    aborted: bool,
}

impl Barrier {
    /// Waits for the opening; `None` when the start was called off.
    fn arrive(&self) -> Option<Instant> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.arrived += 1;
        self.changed.notify_all();
        while state.opened.is_none() && !state.aborted {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.aborted { None } else { state.opened }
    }

    /// Opens when `threads` have arrived.
    fn open(&self, threads: usize) -> Instant {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        while state.arrived < threads {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let now = Instant::now();
        state.opened = Some(now);
        self.changed.notify_all();
        now
    }

    fn abort(&self) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).aborted = true;
        self.changed.notify_all();
    }
}

impl Source {
    /// Waits for `n` free slots (at most the whole ring); `None` when the run is over: end then.
    /// A slot still holds some earlier pulse: every field, `flags` too, is to be overwritten.
    pub fn reserve(&mut self, n: usize) -> Option<&mut [Slot<Pulse>]> {
        // The wait is not work: stop the watch, then start it again.
        self.health.made(0, self.busy_since.elapsed());
        let slots = self.ring.reserve(n, &self.stop);
        self.busy_since = Instant::now();
        let slots = slots?;
        slots.iter_mut().for_each(|slot| slot.fit(&self.layout));
        Some(slots)
    }

    /// Hands over the first `n` reserved slots, in order.
    pub fn commit(&mut self, n: usize) {
        self.ring.commit(n);
        self.health.made(n as u64, self.busy_since.elapsed());
        self.busy_since = Instant::now();
    }

    /// Workers who fill the ring with some pulses, each at its own pace.
    pub fn dispatcher(&mut self, pulses: Range<u64>, workers: usize) -> Dispatcher<'_> {
        let Self { ring, worth, stop, health, .. } = self;
        Dispatcher::new(ring, pulses, workers, worth, stop, health)
    }

    /// When its pulses are due.
    pub fn due(&self) -> Due {
        self.due.clone()
    }

    /// What is counted.
    pub fn health(&self) -> &Arc<Health> {
        &self.health
    }

    /// The first pulse still worth making: blocks that end before it are skipped without being made.
    pub fn next_worth(&self) -> u64 {
        self.worth.next()
    }
}

impl<'env, R: Send, S: Send> Stream<'env, R, S> {
    /// A stream without sinks.
    pub fn new(settings: Settings, schedule: Schedule, layout: Layout, stop: Arc<AtomicBool>) -> Self {
        Self { settings, schedule, layout, stop, status: None, view: None, sinks: Vec::new() }
    }

    /// Sends progress to a bounded channel, about 10 times per second and once at the end.
    pub fn status(&mut self, status: Sender<Status>) {
        self.status = Some(status);
    }

    /// Lets an onlooker see what is released.
    pub fn view(&mut self, view: View) {
        self.view = Some(view);
    }

    /// Adds a sink: `body` runs in a thread of its own and reads the feed until it has ended. In real time it
    /// misses the pulses for which its queue has no room, and the run ends when it fails.
    ///
    /// # Errors
    /// A queue without slots.
    pub fn sink(
        &mut self,
        name: &str,
        queue_pulses: usize,
        body: impl FnOnce(Feed) -> Result<R, S> + Send + 'env,
    ) -> Result<(), StreamError> {
        self.sink_as(name, queue_pulses, Role::default(), body)
    }

    /// Adds a sink in a role.
    ///
    /// # Errors
    /// A queue without slots.
    pub fn sink_as(
        &mut self,
        name: &str,
        queue_pulses: usize,
        role: Role,
        body: impl FnOnce(Feed) -> Result<R, S> + Send + 'env,
    ) -> Result<(), StreamError> {
        let (outlet, feed) = outlet(name, queue_pulses, role, &self.layout)?;
        self.sinks.push(Waiting { name: name.to_owned(), role, outlet, feed, body: Box::new(body) });
        Ok(())
    }

    /// Runs to the end. `generate` runs in a thread of its own.
    pub fn run<G: Send>(
        self,
        generate: impl FnOnce(&mut Source) -> Result<(), G> + Send + 'env,
    ) -> Outcome<R, G, S> {
        let Self { settings, schedule, layout, stop, status, view, sinks } = self;
        let (producer, consumer) = ring((0..settings.ring_slots).map(|_| Pulse::new(&layout)));
        let (outlets, bodies): (Vec<_>, Vec<_>) = sinks
            .into_iter()
            .map(|Waiting { name, role, outlet, feed, body }| {
                let counts = outlet.health();
                (outlet, (name, role, counts, feed, body))
            })
            .unzip();
        let health = Arc::new(Health::new(outlets.iter().map(Outlet::health).collect(), settings.ring_slots));
        if let Some(view) = &view {
            view.open(&health);
        }
        let worth = Worth::default();
        let ended = Ended::default();
        let fail = |error| ended.fail(error);
        if settings.ring_slots == 0 {
            fail(RunError::Stream(StreamError::EmptyRing));
            return outcome(&health, &schedule, &settings, &stop, 0.0, Vec::new(), ended);
        }
        let mut source = Source {
            ring: producer,
            layout,
            worth: worth.clone(),
            stop: Arc::clone(&stop),
            health: Arc::clone(&health),
            busy_since: Instant::now(),
            due: Due::new(&schedule, settings.latency_s, &stop),
        };
        let pacer = Pacer {
            ring: consumer,
            fan_out: FanOut::new(outlets, &settings, &layout).with_view(view),
            schedule: schedule.clone(),
            settings,
            health: Arc::clone(&health),
            worth,
            status,
        };
        let barrier = Barrier::default();
        let mut reports = Vec::new();
        let mut elapsed_s = 0.0;
        thread::scope(|scope| {
            let mut sink_threads = Vec::with_capacity(bodies.len());
            let mut arrivals = 2;
            let mut spawned = true;
            let refuse = |thread: &str, error: std::io::Error| {
                fail(RunError::Stream(StreamError::Thread { thread: thread.to_owned(), kind: error.kind() }));
                false
            };
            for (name, role, counts, feed, body) in bodies {
                let (barrier, ended) = (&barrier, &ended);
                let label = name.clone();
                let thread =
                    thread::Builder::new().name(format!("sink {name}")).spawn_scoped(scope, move || {
                        barrier.arrive()?;
                        let report = body(feed);
                        report.map_err(|error| ended.sink_failed(label, role, &counts, error)).ok()
                    });
                match thread {
                    Ok(thread) => sink_threads.push((name, thread)),
                    Err(error) => spawned = refuse(&name, error),
                }
                arrivals += 1;
            }
            let pacer_thread = thread::Builder::new().name("pacer".to_owned()).spawn_scoped(scope, || {
                let Some(start) = barrier.arrive() else { return };
                if let Err(error) = pacer.run(start, &stop) {
                    fail(RunError::Pacer(error));
                }
            });
            let generation = thread::Builder::new().name("generation".to_owned()).spawn_scoped(scope, || {
                let Some(start) = barrier.arrive() else { return };
                source.due.begun = start;
                source.busy_since = Instant::now();
                if let Err(error) = generate(&mut source) {
                    fail(RunError::Generation(error));
                }
                source.health.generation_ended();
                // The producer goes with this thread: the end passes on to the pacer.
                drop(source);
            });
            let pacer_thread = pacer_thread.map_err(|error| spawned = refuse("pacer", error)).ok();
            let generation = generation.map_err(|error| spawned = refuse("generation", error)).ok();
            if !spawned {
                barrier.abort();
                return;
            }
            if settings.lock_memory {
                health.right(rights::lock_memory());
            }
            let start = barrier.open(arrivals);
            reports = join([("generation", generation), ("pacer", pacer_thread)], sink_threads, fail);
            elapsed_s = start.elapsed().as_secs_f64();
        });
        outcome(&health, &schedule, &settings, &stop, elapsed_s, reports, ended)
    }
}

/// What went wrong.
struct Ended<G, S> {
    /// The error of the run.
    first: Mutex<Option<RunError<G, S>>>,
    /// Sinks without which it went on.
    failed: Mutex<Vec<(String, S)>>,
}

impl<G, S> Default for Ended<G, S> {
    fn default() -> Self {
        Self { first: Mutex::default(), failed: Mutex::default() }
    }
}

impl<G, S> Ended<G, S> {
    fn fail(&self, error: RunError<G, S>) {
        self.first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    fn sink_failed(&self, name: String, role: Role, counts: &SinkHealth, error: S) {
        if !role.may_fail {
            return self.fail(RunError::Sink { name, error });
        }
        counts.failed();
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).push((name, error));
    }
}

/// Waits for all threads; what the sinks report.
fn join<R, G, S>(
    ends: [(&str, Option<ScopedJoinHandle<'_, ()>>); 2],
    sinks: Vec<(String, ScopedJoinHandle<'_, Option<R>>)>,
    fail: impl Fn(RunError<G, S>),
) -> Vec<(String, R)> {
    for (name, thread) in ends {
        if thread.is_some_and(|thread| thread.join().is_err()) {
            fail(RunError::Panic { thread: name.to_owned() });
        }
    }
    let mut reports = Vec::with_capacity(sinks.len());
    for (name, thread) in sinks {
        match thread.join() {
            Ok(Some(report)) => reports.push((name, report)),
            Ok(None) => {}
            Err(_) => fail(RunError::Panic { thread: format!("sink {name}") }),
        }
    }
    reports
}

fn outcome<R, G, S>(
    health: &Health,
    schedule: &Schedule,
    settings: &Settings,
    stop: &AtomicBool,
    elapsed_s: f64,
    reports: Vec<(String, R)>,
    ended: Ended<G, S>,
) -> Outcome<R, G, S> {
    let shot = health.snapshot();
    let made_s = shot.made as f64 / schedule.times.mean_prf_hz();
    let error = ended.first.into_inner().unwrap_or_else(PoisonError::into_inner);
    Outcome {
        summary: Summary {
            elapsed_s,
            real_time_factor: if shot.generation_busy_s > 0.0 {
                made_s / shot.generation_busy_s
            } else {
                0.0
            },
            latency_ms: (settings.pace == Pace::Realtime)
                .then_some((settings.latency_s + shot.mean_moved_s) * 1e3 + shot.lateness_us.mean * 1e-3),
            stopped: stop.load(Ordering::Acquire),
            health: shot,
        },
        reports,
        failed: ended.failed.into_inner().unwrap_or_else(PoisonError::into_inner),
        result: error.map_or(Ok(()), Err),
    }
}
