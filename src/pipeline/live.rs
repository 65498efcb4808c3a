//! Live navigation in a run: waits for it, flies by it, goes on without it.
//!
//! ```text
//! feed (a thread per source) -> growing track -> generation, which waits for what the next block rests on
//! ```
//!
//! * **Before the run.** Sources are opened, and the run waits for its first fixes, [`LiveSource::timeout_s`]
//!   at most. What has to know the whole flight beforehand (`plan`, its adequacy) goes by the nominal
//!   trajectory of the source, or straight on from the last fix. Pulses begin when the navigation of every
//!   live platform has reached the emission of the first one: from then on one second of the run is one
//!   second of navigation.
//! * **While it runs** a block is made when the tracks reach its last emission and the light time after it.
//!   It cannot wait longer than `deadline - lead`, with `lead` twice the longest time a block has taken of
//!   late (at most half of the latency): then tracks are extrapolated, and the pulses say so. So with a
//!   latency of support + block + lead, and what the receiver itself is late, every pulse has the bits that a
//!   file would give.
//! * A fix that the platform cannot have flown to is refused and counted ([`MotionGate`]); when such fixes go
//!   on to agree, they are believed, and the motion goes to them as after a time without navigation.
//! * Where the scenario asks for no latency, it is what the interval between the first fixes makes necessary
//!   (`LiveNav::needed_latency_s`).
//! * A fix more than [`MOST_AHEAD_S`] ahead of the schedule comes from a clock that has stepped: it is left,
//!   and counted.

use super::fault::LiveFault;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::config::Run;
use crate::motion::Track;
use crate::motion::gate::{MotionGate, Verdict};
use crate::motion::track::live::LiveTrack;
use crate::nav::Place;
use crate::nav::TrackSource;
use crate::nav::live::{Feed, FeedCounts};
use crate::nav::live::{LiveSource, Origin, ReceivedFix};
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::time::TimeTag;
use crate::transport::{Pace, Policy};

/// How far ahead of the schedule a fix may be, s.
pub const MOST_AHEAD_S: f64 = 5.0;
/// Interval between checks of the stop flag.
const LOOK: Duration = Duration::from_millis(20);
/// How long a time of a block counts at least.
const FORGOTTEN: Duration = Duration::from_secs(5);
/// What a block is always given, in addition to the time it takes.
const LEAST_LEAD: Duration = Duration::from_millis(2);
/// What a receiver and its line may take, and what making a block may, s.
const MARGIN_S: f64 = 0.3;
/// From the last fix to the first pulse of a run that begins with its navigation, s: what making it ready may
/// take.
const READY_S: f64 = 3.0;

/// What became of the navigation of a platform.
#[derive(Clone, Debug, Serialize)]
pub struct FlightReport {
    /// The platform.
    pub platform: String,
    /// Where its navigation comes from.
    pub source: String,
    /// What was read.
    #[serde(flatten)]
    pub counts: FeedCounts,
    /// Fixes left because they were ahead of the schedule.
    pub ahead: u64,
    /// Fixes left because no track can be made of them.
    pub unusable: u64,
    /// Fixes refused because the platform cannot have flown to them.
    pub implausible: u64,
    /// How often such fixes were believed after all, because they went on to agree.
    pub jumps: u64,
    /// The median time between fixes, s.
    pub interval_s: Option<f64>,
    /// Whether the attitude is derived from the motion.
    pub attitude_derived: Option<bool>,
}

/// One platform that flies by live navigation.
struct Flight {
    platform: usize,
    name: String,
    source: LiveSource,
    track: LiveTrack,
    gate: Arc<Gate>,
    feed: Feed,
}

/// What fixes pass on their way into a track.
#[derive(Default)]
struct Gate {
    /// Begin of the schedule, and the time of navigation that is ahead of it by no more than it was then.
    begun: OnceLock<(Instant, TimeTag)>,
    ahead: AtomicU64,
    unusable: AtomicU64,
    implausible: AtomicU64,
    jumps: AtomicU64,
}

/// Counts news, wakes those who wait for them.
#[derive(Default)]
struct Bell {
    news: Mutex<u64>,
    candidate: Condvar,
}

/// The live navigation of a run.
pub struct LiveNav {
    flights: Vec<Flight>,
    bell: Arc<Bell>,
    blocks: Mutex<Blocks>,
}

/// The longest times that blocks have taken, since an instant and in the stretch before it.
struct Blocks {
    since: Instant,
    longest: Duration,
    before: Duration,
}

impl LiveNav {
    /// Opens the live sources of a run and waits for their first fixes. `None` if it has none; else the run
    /// as it is run on its nominal trajectory as well.
    pub(super) fn open(run: &Run) -> Result<Option<(Run, Arc<Self>)>, BuildErrors> {
        let live = |(platform, nav): (usize, &crate::motion::PlatformNav)| match &nav.truth {
            TrackSource::Live(source) => Some((platform, source.clone())),
            _ => None,
        };
        let sources: Vec<_> = run.nav.iter().enumerate().filter_map(live).collect();
        if sources.is_empty() {
            return Ok(None);
        }
        let mut faults = refused(run);
        let bell = Arc::new(Bell::default());
        let mut flights = Vec::with_capacity(sources.len());
        for (platform, source) in sources {
            let name = run.scene.platforms[platform].clone();
            let LiveSource { attitude, max_gap_s, max_extrapolation_s, .. } = source;
            let track = LiveTrack::new(run.scene.frame, attitude, max_gap_s, max_extrapolation_s);
            let gate = Arc::new(Gate::default());
            // A file may be read ahead, a receiver cannot.
            let bounded = !matches!(source.origin, Origin::File(_));
            let (to, through, ring) = (track.clone(), Arc::clone(&gate), Arc::clone(&bell));
            let mut plausible = MotionGate::new(run.scene.frame, source.bounds);
            let deliver = move |received: ReceivedFix| {
                if bounded && through.is_ahead(received.fix.time) {
                    through.ahead.fetch_add(1, Ordering::Relaxed);
                    return;
                }
                let fixes = match plausible.judge(&received.fix, received) {
                    Verdict::Believed(received) => vec![received],
                    Verdict::Refused => {
                        through.implausible.fetch_add(1, Ordering::Relaxed);
                        return;
                    }
                    Verdict::Jumped(fixes) => {
                        through.jumps.fetch_add(1, Ordering::Relaxed);
                        if let Some(first) = fixes.first() {
                            to.jump(first.fix.time);
                        }
                        fixes
                    }
                };
                for received in fixes {
                    if to.push(&received.fix, received.arrived).is_err() {
                        through.unusable.fetch_add(1, Ordering::Relaxed);
                    }
                }
                ring.ring();
            };
            match Feed::open(&source, &name, (!run.start_live).then_some(run.scene.start), deliver) {
                Ok(feed) => flights.push(Flight { platform, name, source, track, gate, feed }),
                Err(fault) => faults.push(BuildError::Live { platform: name, source: fault.into() }),
            }
        }
        if !faults.is_empty() {
            return Err(BuildErrors(faults));
        }
        let blocks = Blocks { since: Instant::now(), longest: Duration::ZERO, before: Duration::ZERO };
        let live = Arc::new(Self { flights, bell, blocks: Mutex::new(blocks) });
        live.await_first()?;
        let nominal = live.nominal(run)?;
        Ok(Some((nominal, live)))
    }

    /// Waits until every platform has a track.
    fn await_first(&self) -> Result<(), BuildErrors> {
        let begun = Instant::now();
        loop {
            let news = self.bell.count();
            let silent: Vec<&Flight> =
                self.flights.iter().filter(|flight| !flight.track.is_ready()).collect();
            if silent.is_empty() {
                return Ok(());
            }
            let waited_s = begun.elapsed().as_secs_f64();
            let faults: Vec<BuildError> = silent
                .iter()
                .filter(|flight| waited_s > flight.source.timeout_s)
                .map(|flight| flight.silent())
                .collect();
            if !faults.is_empty() {
                return Err(BuildErrors(faults));
            }
            self.bell.wait(news, Instant::now() + LOOK);
        }
    }

    /// The run with tracks that are known beforehand, and with its begin.
    fn nominal(&self, run: &Run) -> Result<Run, BuildErrors> {
        let mut run = run.clone();
        let latest = self.flights.iter().filter_map(|flight| flight.track.last_fix());
        let latest = latest.reduce(|a, b| if b.since(a) > 0.0 { b } else { a });
        if let (true, Some(latest)) = (run.start_live, latest) {
            // A whole second, so that it can be written down.
            run.scene.start = TimeTag::new(latest.plus(READY_S).seconds() + 1, 0.0);
        }
        let mut faults = Vec::new();
        for flight in &self.flights {
            let first = run.scene.start;
            match flight.track.begin() {
                Some(begins) if begins.since(first) > 0.0 => {
                    let origin = flight.source.origin.clone();
                    faults.push(flight.fault(LiveFault::Begun { origin, begins, first }));
                }
                _ => {}
            }
            run.nav[flight.platform].truth = match (&flight.source.nominal, flight.track.last_known()) {
                (None, Some((time, place, velocity))) => TrackSource::Straight {
                    place: Place::Local(place + velocity * first.since(time)),
                    velocity,
                    attitude: Some(flight.track.report(time).state.attitude),
                },
                // Its track is that of the nominal trajectory, see [`Track::from_source`].
                _ => continue,
            };
        }
        if faults.is_empty() { Ok(run) } else { Err(BuildErrors(faults)) }
    }

    /// The latency with which every pulse is interpolated, s: the fixes that the interpolant needs after an
    /// instant, one more for sentences, whose epoch ends with the next one, a block of pulses, and
    /// [`MARGIN_S`] for the receiver and for making it.
    pub(super) fn needed_latency_s(&self, block_s: f64) -> f64 {
        let of = |flight: &Flight| {
            let fixes = flight.track.support() + 1;
            flight.track.interval_s().map_or(0.0, |interval_s| fixes as f64 * interval_s)
        };
        self.flights.iter().map(of).fold(0.0, f64::max) + block_s + MARGIN_S
    }

    /// The track of a platform, if it flies by live navigation.
    pub(super) fn track(&self, platform: usize) -> Option<Track> {
        let flight = self.flights.iter().find(|flight| flight.platform == platform)?;
        Some(Track::live(flight.track.clone()))
    }

    /// Waits until navigation has reached the first pulse, or `stop` is set; the schedule begins then.
    ///
    /// # Errors
    /// Sources that fall silent before.
    pub(super) fn await_begin(&self, first: TimeTag, stop: &AtomicBool) -> Result<(), BuildErrors> {
        let mut silent_since = vec![(None, Instant::now()); self.flights.len()];
        loop {
            let news = self.bell.count();
            let short = |flight: &Flight| flight.track.last_fix().is_none_or(|last| first.since(last) > 0.0);
            if !self.flights.iter().any(short) || stop.load(Ordering::Acquire) {
                break;
            }
            for (flight, (last, since)) in self.flights.iter().zip(&mut silent_since) {
                let now = flight.track.last_fix();
                if now != *last {
                    (*last, *since) = (now, Instant::now());
                } else if short(flight) && since.elapsed().as_secs_f64() > flight.source.timeout_s {
                    return Err(flight.silent().into());
                }
            }
            self.bell.wait(news, Instant::now() + LOOK);
        }
        let now = Instant::now();
        for flight in &self.flights {
            let last = flight.track.last_fix().filter(|last| last.since(first) > 0.0);
            let _ = flight.gate.begun.set((now, last.unwrap_or(first)));
        }
        Ok(())
    }

    /// Where the navigation of each platform has got to, with pulses that wait for it from `first` on.
    pub fn standing(&self, first: TimeTag) -> impl Iterator<Item = String> {
        self.flights.iter().map(move |flight| {
            let (name, origin) = (&flight.name, &flight.source.origin);
            format!("platform '{name}' by {origin}: {}", awaited(flight.track.last_fix(), first))
        })
    }

    /// Waits until all tracks reach an instant, until they may have to go on without it, or `stop` is set;
    /// then they do.
    pub(super) fn hold(&self, need: TimeTag, deadline: Instant, latency: Duration, stop: &AtomicBool) {
        let lead = (2 * self.longest() + LEAST_LEAD).min(latency / 2);
        let until = deadline.checked_sub(lead).unwrap_or(deadline);
        loop {
            let news = self.bell.count();
            let short = |flight: &&Flight| flight.track.end().is_none_or(|end| need.since(end) > 0.0);
            if !self.flights.iter().any(|flight| short(&flight)) {
                return;
            }
            let now = Instant::now();
            if now >= until || stop.load(Ordering::Acquire) {
                self.flights.iter().filter(short).for_each(|flight| flight.track.extend(need));
                return;
            }
            self.bell.wait(news, until.min(now + LOOK));
        }
    }

    /// Notes how long a block has taken. What was long once is forgotten after 5 to 10 s: a stall of the
    /// machine is no reason to wait less for ever.
    pub(super) fn took(&self, time: Duration) {
        let mut blocks = self.blocks.lock().unwrap_or_else(PoisonError::into_inner);
        if blocks.since.elapsed() > FORGOTTEN {
            *blocks = Blocks { since: Instant::now(), before: blocks.longest, longest: Duration::ZERO };
        }
        blocks.longest = blocks.longest.max(time);
    }

    fn longest(&self) -> Duration {
        let blocks = self.blocks.lock().unwrap_or_else(PoisonError::into_inner);
        blocks.longest.max(blocks.before)
    }

    /// What became of the navigation so far.
    pub fn report(&self) -> Vec<FlightReport> {
        let of = |flight: &Flight| FlightReport {
            platform: flight.name.clone(),
            source: flight.source.origin.to_string(),
            counts: flight.feed.counts(),
            ahead: flight.gate.ahead.load(Ordering::Relaxed),
            unusable: flight.gate.unusable.load(Ordering::Relaxed),
            implausible: flight.gate.implausible.load(Ordering::Relaxed),
            jumps: flight.gate.jumps.load(Ordering::Relaxed),
            interval_s: flight.track.interval_s(),
            attitude_derived: flight.track.derives_attitude(),
        };
        self.flights.iter().map(of).collect()
    }
}

/// What a run with live navigation cannot have.
fn refused(run: &Run) -> Vec<BuildError> {
    let mut faults = Vec::new();
    for (name, nav) in run.scene.platforms.iter().zip(&run.nav) {
        if !matches!(nav.truth, TrackSource::Live(_)) {
            continue;
        }
        let mut refuse = |source| faults.push(BuildError::Live { platform: name.clone(), source });
        if run.stream.pace == Pace::Fast {
            refuse(LiveFault::Schedule { what: "pace = \"fast\" does not" });
        }
        if run.stream.policy == Policy::Slip {
            refuse(LiveFault::Schedule { what: "policy = \"slip\" stretches time" });
        }
        if nav.gusts.is_some() {
            refuse(LiveFault::Beforehand { what: "turbulence" });
        }
        let reported = crate::motion::errors::Recorded::Reported;
        if nav.errors.as_ref().is_some_and(|errors| errors.recorded == reported) {
            refuse(LiveFault::Beforehand { what: "errors.recorded = \"reported\"" });
        }
    }
    for (name, nav) in run.scene.platforms.iter().zip(&run.nav) {
        if matches!(nav.reported, Some(TrackSource::Live(_))) {
            let what = "a report beside the truth";
            faults.push(BuildError::Live { platform: name.clone(), source: LiveFault::Beforehand { what } });
        }
    }
    faults
}

impl Flight {
    fn silent(&self) -> BuildError {
        self.fault(LiveFault::Silent {
            origin: self.source.origin.clone(),
            timeout_s: self.source.timeout_s,
            good: self.feed.counts().good,
            unusable: self.gate.unusable.load(Ordering::Relaxed),
        })
    }

    fn fault(&self, source: LiveFault) -> BuildError {
        BuildError::Live { platform: self.name.clone(), source }
    }
}

impl Gate {
    fn is_ahead(&self, time: TimeTag) -> bool {
        self.begun
            .get()
            .is_some_and(|(begun, then)| time.since(*then) > begun.elapsed().as_secs_f64() + MOST_AHEAD_S)
    }
}

impl Bell {
    fn ring(&self) {
        *self.news.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.candidate.notify_all();
    }

    fn count(&self) -> u64 {
        *self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for news after those of number `seen`, at most until an instant.
    fn wait(&self, seen: u64, until: Instant) {
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        while *news == seen {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            news = self.candidate.wait_timeout(news, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// Whether navigation has come to the first emission, for which pulses wait.
fn awaited(last: Option<TimeTag>, first: TimeTag) -> String {
    match last {
        None => format!("no position yet; pulses begin when it has come to {first}"),
        Some(last) if first.since(last) > 0.0 => {
            format!("last position at {last}; pulses begin when it has come to {first}")
        }
        Some(last) => format!("last position at {last}; the first pulse is emitted at {first}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn navigation_before_and_past_the_first_pulse() {
        let at = |second: i64| TimeTag::new(1_416_861_020 + second, 0.0);
        let text = |last| awaited(last, at(1));
        insta::assert_snapshot!(text(None), @"no position yet; pulses begin when it has come to 2014-11-24T20:30:21.000000Z");
        insta::assert_snapshot!(text(Some(at(0))), @"last position at 2014-11-24T20:30:20.000000Z; pulses begin when it has come to 2014-11-24T20:30:21.000000Z");
        insta::assert_snapshot!(text(Some(at(1))), @"last position at 2014-11-24T20:30:21.000000Z; the first pulse is emitted at 2014-11-24T20:30:21.000000Z");
    }
}
