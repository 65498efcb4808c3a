//! Releases pulses in order, each at its deadline.
//!
//! Symbols, all on the monotonic clock:
//!
//! | | |
//! | --- | --- |
//! | start | the instant at which the stream's barrier opened |
//! | d(n) | deadline of pulse n: `start + latency + t(n) - t(first)`, [`Schedule`] |
//! | P(n) | the interval that follows pulse n |
//! | r(n) | the instant at which pulse n is handed to the fan-out |
//!
//! **Lateness** is `r(n) - d(n)`, never negative. A pulse is **late** when it exceeds P(n): it is
//! counted and carries `LATE`, whatever the reason.
//!
//! **Underrun**: the main ring was seen empty later than `d(n) + P(n) + h`, so pulse n was not *made* in
//! time. A pacer that wakes late itself finds the pulse in the ring; that is lateness and no underrun. It
//! also holds back slots that generation needs for the pulses that come one ring later: `h` is the pacer's
//! own worst lateness over the last two rings of releases, counted from `d(n)` or from when the ring was last
//! seen empty, whichever is later. After them `h` shrinks by a twentieth of the time emitted, so that a
//! generation which is 5 % faster than real time makes up for it.
//!
//! **Standstill**: the pacer slept [`STANDSTILL`] longer than it asked to: the machine, or this program, was
//! stopped, and generation with it. Its length is counted, and added to `h`. (The monotonic clock stands
//! still while a machine is suspended, and steps of the wall clock do not touch it: the stream goes on where
//! it was.)
//!
//! What is **overdue** never leaves in a burst that the sinks' queues cannot hold: pulses more than
//! [`BURST_PULSES`](super::judge::BURST_PULSES) intervals overdue leave half an interval apart, and a pulse
//! that is late waits for the sinks that are to get every pulse ([`FanOut::make_room`]), up to `d(n) + h` and
//! under `slip` as long as it takes.
//!
//! The policy says what becomes of pulses that are not made in time, and of those that the pacer releases too
//! late:
//!
//! - `stop`: on an underrun the run ends with [`PacerError::Underrun`], or with [`PacerError::StoodStill`]
//!   where it has not caught up with a standstill. What the pacer itself releases late is made up for.
//! - `slip`: nothing is lost. All deadlines from a late pulse on move by its lateness, whatever made it late;
//!   it carries `LATE` and counts as late, with its lateness to the unmoved deadline. So no two pulses leave
//!   closer than their interval, but for the interval by which a pulse is not yet late. The sum of the moves
//!   is counted. A sink that is full is waited for, on time or late.
//! - `drop`: real time is kept. What the pacer finds more than [`STALE`] overdue is discarded, as if it had
//!   not been made. Every pulse that was not made in time is discarded when it comes; missing
//!   indices are counted as dropped, and the next pulse released carries `AFTER_GAP`. Generation learns the
//!   first index still worth making ([`Worth`]): the one emitted now, so that the full latency is again in
//!   hand; the pulses between are never made. Under a lasting overload pulses therefore come in runs of about
//!   a latency's length with gaps between. A run of which not one pulse was released ends with
//!   [`PacerError::NothingReleased`].
//! - `relax`: as `drop`. That pulses are made coarser before any is too late is generation's.
//!
//! At pace `fast` there are no deadlines: nothing waits, nothing is late, nothing is dropped.
//!
//! Waiting for a deadline sleeps until [`SPIN_BUDGET`] before it and spins for the rest: at 222 Hz less
//! than 4.5 % of one core, at 1 kHz less than 20 %. It does not yield while it spins: on a busy machine
//! a yield costs milliseconds (median lateness at 1 kHz beside two busy loops on two cores: 1.3 ms yielding,
//! below 1 us spinning). When the stop flag is set in real time the pacer ends at once: pulses in the
//! ring whose deadline has not come are not released. At pace `fast` the ring is drained.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use spin_sleep::{SpinSleeper, SpinStrategy};

use crate::pulse::{Pulse, flags};

use super::fanout::FanOut;
use super::health::Health;
use super::judge::Judge;
use super::rights;
use super::ring::{Consumer, DOZE, NAP, Polled, Slot};
use super::schedule::Schedule;
use super::{Pace, Policy, Settings};

pub use super::shortage::{InHand, PacerError};

/// The last part of a wait, which is spun: what a plain sleep was seen to overshoot by (median 66 us).
pub const SPIN_BUDGET: Duration = Duration::from_micros(200);

/// Shortest interval at which the pacer may run ahead of all others: what it spins is then at most a fifth of
/// a core.
const LEAST_PRI_AHEAD: Duration = Duration::from_millis(1);

/// Whether the pacer of pulses at a mean rate, Hz, asks for real-time priority.
pub(super) fn may_run_ahead(mean_prf_hz: f64) -> bool {
    mean_prf_hz * LEAST_PRI_AHEAD.as_secs_f64() <= 1.0 + 1e-9
}

/// A sleep that lasts so much longer than asked is a standstill.
pub const STANDSTILL: Duration = Duration::from_millis(100);

/// What is longer overdue is no pulse of real time: policy `drop` discards it.
pub const STALE: Duration = Duration::from_secs(1);

/// A long wait looks at the stop flag this often.
const SLICE: Duration = Duration::from_millis(50);

/// Progress is reported this often.
const STATUS_EVERY: Duration = Duration::from_millis(100);

/// Progress of a running stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// Pulses of the run that are behind us: released or dropped.
    pub passed: u64,
    /// Pulses of the whole run.
    pub total: u64,
    /// Late so far.
    pub late: u64,
    /// Dropped so far.
    pub dropped: u64,
}

/// The first pulse that is still worth making, reported by the pacer to the generation.
#[derive(Clone, Debug, Default)]
pub struct Worth(Arc<AtomicU64>);

impl Worth {
    /// The first pulse still worth making.
    pub fn next(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }

    fn raise(&self, index: u64) {
        self.0.fetch_max(index, Ordering::AcqRel);
    }
}

/// What the pacer works with.
#[derive(Debug)]
pub struct Pacer {
    /// The main ring.
    pub ring: Consumer<Slot<Pulse>>,
    /// Where pulses go.
    pub fan_out: FanOut,
    /// When pulses are due.
    pub schedule: Schedule,
    /// How pulses are released.
    pub settings: Settings,
    /// Counters.
    pub health: Arc<Health>,
    /// Passed on to generation.
    pub worth: Worth,
    /// Where progress goes; a full channel loses the message, never time.
    pub status: Option<Sender<Status>>,
}

/// What came for the pacer.
enum Arrival {
    /// A pulse, and whether it was made too late.
    Pulse {
        pulse: Slot<Pulse>,
        too_late: bool,
    },
    Ended,
}

/// What becomes of a pulse when its time has come.
enum Awaited {
    /// It leaves now.
    Now(Release),
    /// It is of no use to real time any more.
    Stale,
}

/// How a pulse leaves.
#[derive(Clone, Copy, Debug, Default)]
struct Release {
    /// None at pace `fast`.
    lateness: Option<Duration>,
    late: bool,
    /// Late, though it was made in time.
    held_up: bool,
}

impl Pacer {
    /// Runs until the stream ends, `stop` is set, or a sink is gone.
    ///
    /// # Errors
    /// Policy `stop` and a pulse that was not made in time, nothing that could be released, or pulses out of
    /// order.
    pub fn run(mut self, start: Instant, stop: &AtomicBool) -> Result<(), PacerError> {
        let latency = Duration::try_from_secs_f64(self.settings.latency_s.max(0.0)).unwrap_or(Duration::ZERO);
        let sleeper =
            SpinSleeper::new(SPIN_BUDGET.subsec_nanos()).with_spin_strategy(SpinStrategy::SpinLoopHint);
        if self.settings.pacer_ahead
            && self.settings.pace == Pace::Realtime
            && may_run_ahead(self.schedule.times.mean_prf_hz())
        {
            self.health.right(rights::run_ahead());
        }
        if let Some(core) = self.settings.pacer_core {
            self.health.right(rights::stay_on(core));
        }
        let begin = Schedule::after(start, latency);
        let mut judge = Judge::new(start, begin);
        let mut expected = self.schedule.first;
        let mut reported = Instant::now();
        let mut cut_short = false;
        while let Arrival::Pulse { mut pulse, too_late } = self.next(&mut judge, expected, stop)? {
            let index = pulse.index;
            if index < expected {
                return Err(PacerError::Order { index, expected });
            }
            if too_late && self.settings.policy.drops() {
                // Counted as part of the gap before the next pulse that is released.
                self.ring.give_back(pulse);
                continue;
            }
            self.health.ring_level(self.ring.filled() + 1);
            let moved = judge.zero - begin;
            let mut release = Release::default();
            if self.settings.pace == Pace::Realtime {
                match self.await_release(&mut judge, index, too_late, sleeper, stop) {
                    Some(Awaited::Now(found)) => release = found,
                    Some(Awaited::Stale) => {
                        self.ring.give_back(pulse);
                        continue;
                    }
                    None => {
                        cut_short = true;
                        break;
                    }
                }
            }
            let gap = index - expected;
            if gap > 0 {
                self.health.drop_pulses(gap);
                pulse.flags |= flags::AFTER_GAP;
            }
            if release.late {
                pulse.flags |= flags::LATE;
            }
            expected = index + 1;
            self.health.passed(&pulse);
            let Some(free) = self.fan_out.send(pulse) else {
                cut_short = true;
                break;
            };
            self.health.release(release.lateness, release.late, moved);
            if release.held_up {
                self.health.hold_up();
            }
            self.ring.give_back(free);
            if self.status.is_some() && reported.elapsed() >= STATUS_EVERY {
                reported = Instant::now();
                self.send_status(expected);
            }
        }
        // Pulses at the end that were skipped or came too late are dropped, too.
        if !cut_short && self.worth.next() > expected && !stop.load(Ordering::Acquire) {
            let end = self.schedule.end();
            self.health.drop_pulses(end.saturating_sub(expected));
            expected = end;
        }
        self.send_status(expected);
        let (released, dropped) = (self.health.released_pulses(), self.health.dropped_pulses());
        if !cut_short && released == 0 && dropped > 0 {
            return Err(PacerError::NothingReleased { pulses: dropped, latency: self.in_hand() });
        }
        Ok(())
    }

    /// Waits until a pulse may leave; `None` once `stop` is set.
    fn await_release(
        &mut self,
        judge: &mut Judge,
        index: u64,
        too_late: bool,
        sleeper: SpinSleeper,
        stop: &AtomicBool,
    ) -> Option<Awaited> {
        let (policy, ring_slots) = (self.settings.policy, self.settings.ring_slots);
        let deadline = judge.deadline(&self.schedule, index);
        let (asked, pri) = (Instant::now(), self.schedule.pri(index));
        let due = judge.due(&self.schedule, index, asked);
        if !sleep_until(due, sleeper, stop) {
            return None;
        }
        let awake = Instant::now();
        self.look_for_standstill(judge, index, due.max(asked), awake);
        let overdue = awake.saturating_duration_since(deadline);
        if policy.drops() && overdue > STALE {
            self.skip_to_now(judge, awake);
            return Some(Awaited::Stale);
        }
        if !too_late {
            // What the pulse itself came late is not the pacer's.
            let since = judge.seen_empty.map_or(deadline, |empty| empty.max(deadline));
            judge.released(&self.schedule, index, awake.saturating_duration_since(since), ring_slots);
        }
        let patience = match policy {
            Policy::Slip => Some(Schedule::after(awake, Duration::MAX)),
            Policy::Stop | Policy::Drop | Policy::Relax => {
                (overdue > pri).then(|| Schedule::after(deadline, judge.allowance(&self.schedule, index)))
            }
        };
        let waited = patience.is_some_and(|until| self.fan_out.make_room(until, stop));
        if waited && stop.load(Ordering::Acquire) {
            return None;
        }
        let now = if waited { Instant::now() } else { awake };
        let lateness = now.saturating_duration_since(deadline);
        let late = lateness > pri;
        if late && policy == Policy::Slip {
            judge.zero = Schedule::after(judge.zero, lateness);
            self.health.slip(lateness);
        }
        if !late {
            judge.stood_still = Duration::ZERO;
        }
        judge.last = Some(now);
        let in_time = judge.seen_empty.is_none_or(|empty| empty <= deadline);
        Some(Awaited::Now(Release { lateness: Some(lateness), late, held_up: late && in_time && !waited }))
    }

    /// Takes note if a sleep that was to end at one instant ended much later.
    fn look_for_standstill(&self, judge: &mut Judge, index: u64, asked: Instant, awake: Instant) {
        let longer = awake.saturating_duration_since(asked);
        if longer >= STANDSTILL {
            self.health.stood_still(longer);
            judge.stood_still(&self.schedule, index, longer, self.settings.ring_slots);
        }
    }

    /// Policy `drop`: what is emitted now is the first that is worth making.
    fn skip_to_now(&self, judge: &Judge, now: Instant) {
        self.worth.raise(self.schedule.due_after(now.saturating_duration_since(judge.start)));
    }

    /// Waits for the next pulse; acts on an underrun while it does not come.
    fn next(&mut self, judge: &mut Judge, expected: u64, stop: &AtomicBool) -> Result<Arrival, PacerError> {
        let realtime = self.settings.pace == Pace::Realtime;
        loop {
            // Read before the poll: if it fails, the ring was empty at this instant or later.
            let now = Instant::now();
            match self.ring.poll() {
                Polled::Slot(pulse) => {
                    let limit = judge.limit(&self.schedule, pulse.index);
                    let too_late = realtime && judge.seen_empty.is_some_and(|empty| empty > limit);
                    return Ok(Arrival::Pulse { pulse, too_late });
                }
                Polled::Ended => return Ok(Arrival::Ended),
                Polled::Empty => judge.seen_empty = Some(now),
            }
            if stop.load(Ordering::Acquire) && realtime {
                return Ok(Arrival::Ended);
            }
            if realtime && expected < self.schedule.end() && now > judge.limit(&self.schedule, expected) {
                match self.settings.policy {
                    Policy::Stop => return Err(self.underrun(judge, now, expected)),
                    Policy::Slip => {}
                    Policy::Drop | Policy::Relax => self.skip_to_now(judge, now),
                }
            }
            let nap = self.until_next_poll(judge, now, expected);
            self.ring.doze(nap);
            if realtime {
                self.look_for_standstill(judge, expected, now + nap.min(DOZE), Instant::now());
            }
        }
    }

    /// How long the pacer need not look into a ring that was empty: till the deadline of the pulse that is
    /// due. From then on it counts when it came.
    fn until_next_poll(&self, judge: &Judge, now: Instant, expected: u64) -> Duration {
        if self.settings.pace != Pace::Realtime || expected >= self.schedule.end() {
            return DOZE;
        }
        let left = judge.deadline(&self.schedule, expected).saturating_duration_since(now);
        if left.is_zero() { NAP } else { left }
    }

    fn underrun(&self, judge: &Judge, now: Instant, index: u64) -> PacerError {
        let deadline = judge.deadline(&self.schedule, index);
        let elapsed_s = now.saturating_duration_since(judge.start).as_secs_f64().max(1e-9);
        let late_by_s = now.saturating_duration_since(deadline).as_secs_f64();
        if !judge.stood_still.is_zero() {
            return PacerError::StoodStill {
                stood_still_s: judge.stood_still.as_secs_f64(),
                index,
                late_by_s,
            };
        }
        PacerError::Underrun {
            stage: "echo generation",
            index,
            late_by_s,
            made_hz: self.health.made_pulses() as f64 / elapsed_s,
            needed_hz: self.schedule.times.mean_prf_hz(),
            latency: self.in_hand(),
        }
    }

    fn in_hand(&self) -> InHand {
        InHand::of(&self.settings, &self.schedule)
    }

    fn send_status(&self, expected: u64) {
        if let Some(status) = &self.status {
            let _ = status.try_send(Status {
                passed: expected.saturating_sub(self.schedule.first),
                total: self.schedule.count,
                late: self.health.late_pulses(),
                dropped: self.health.dropped_pulses(),
            });
        }
    }
}

/// Sleeps until `deadline`; `false` when `stop` was set before it.
fn sleep_until(deadline: Instant, sleeper: SpinSleeper, stop: &AtomicBool) -> bool {
    loop {
        if stop.load(Ordering::Acquire) {
            return false;
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if left <= SLICE {
            sleeper.sleep_until(deadline);
            return true;
        }
        thread::sleep(SLICE.min(left - SLICE / 2));
    }
}

#[cfg(test)]
pub(super) mod tests;
