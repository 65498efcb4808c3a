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
//! seen empty, whichever is later. On an underrun the policy acts:
//!
//! - `stop`: the run ends with [`PacerError::Underrun`].
//! - `slip`: nothing is lost. When the pulse comes, all deadlines from it on move by its lateness; it
//!   carries `LATE` and counts as late, with its lateness to the unmoved deadline. The sum of the moves is
//!   counted.
//! - `drop`: real time is kept. Every pulse that was not made in time is discarded when it comes; missing
//!   indices are counted as dropped, and the next pulse released carries `AFTER_GAP`. Generation learns the
//!   first index still worth making ([`Worth`]): the one emitted now, so that the full latency is again in
//!   hand; the pulses between are never made. Under a lasting overload pulses therefore come in runs of about
//!   a latency's length with gaps between. A run of which not one pulse was released ends with
//!   [`PacerError::NothingReleased`].
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
use thiserror::Error;

use crate::pulse::{Pulse, flags};

use super::fanout::FanOut;
use super::health::Health;
use super::rights;
use super::ring::{Consumer, DOZE, NAP, Polled};
use super::schedule::Schedule;
use super::{Pace, Policy, Settings};

/// The last part of a wait, which is spun: what a plain sleep was seen to overshoot by (median 66 us).
pub const SPIN_BUDGET: Duration = Duration::from_micros(200);

/// Shortest interval at which the pacer may run ahead of all others: what it spins is then at most a fifth of
/// a core.
const LEAST_PRI_AHEAD: Duration = Duration::from_millis(1);

/// Whether the pacer of pulses at a mean rate, Hz, asks for real-time priority.
pub(super) fn may_run_ahead(mean_prf_hz: f64) -> bool {
    mean_prf_hz * LEAST_PRI_AHEAD.as_secs_f64() <= 1.0 + 1e-9
}

/// A long wait looks at the stop flag this often.
const SLICE: Duration = Duration::from_millis(50);

/// Progress is reported this often.
const STATUS_EVERY: Duration = Duration::from_millis(100);

/// Why the pacer ended a run.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PacerError {
    /// Policy `stop`: a pulse was not made in time.
    #[error(
        "{stage} cannot keep up: {:.1} ms after its deadline pulse {index} is not made yet; {}. Allowed: {}, a lighter \
         scene, policy = \"slip\" or \"drop\", or --pace fast",
        late_by_s * 1e3, so_far(*made_hz, *needed_hz), latency.more()
    )]
    Underrun {
        /// The stage that cannot keep up.
        stage: &'static str,
        /// The pulse that was missing.
        index: u64,
        /// How long after its deadline it was still missing, s.
        late_by_s: f64,
        /// Pulses made per second since the start.
        made_hz: f64,
        /// Pulses due per second.
        needed_hz: f64,
        /// What the latency holds.
        latency: InHand,
    },
    /// Policy `drop`: every pulse of the run came too late.
    #[error(
        "not one pulse of {pulses} was released: policy = \"drop\" discards what is made too late, and all of them \
         were. Allowed: {}, a lighter scene, policy = \"slip\", or --pace fast", latency.more()
    )]
    NothingReleased {
        /// Pulses of the run.
        pulses: u64,
        /// What the latency holds.
        latency: InHand,
    },
    /// Generation handed over a pulse that is not after the last one.
    #[error("echo generation handed over pulse {index} where {expected} or a later one was due")]
    Order {
        /// The pulse that came.
        index: u64,
        /// The smallest index allowed.
        expected: u64,
    },
}

/// The latency, and what is made before the first pulse is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InHand {
    /// The latency, s.
    pub latency_s: f64,
    /// Emission time of the pulses that are made at once ([`Settings::batch_pulses`]), s.
    pub batch_s: f64,
}

impl InHand {
    /// The latency that helps.
    fn more(&self) -> String {
        let Self { latency_s, batch_s } = *self;
        if latency_s >= batch_s {
            return "more stream.latency_ms".to_owned();
        }
        // Not a millisecond more for the last bit of a quotient.
        let enough_ms = (batch_s * 1e3 - 1e-6).ceil();
        format!(
            "stream.latency_ms = {enough_ms:.0} or more (it is {}; pulses are made in blocks, and a block for every \
             thread is that long)",
            (latency_s * 1e6).round() / 1e3
        )
    }
}

/// What was made since the start. Before there is a rate, nothing follows from it.
fn so_far(made_hz: f64, needed_hz: f64) -> String {
    if made_hz == 0.0 {
        return "no other is, either".to_owned();
    }
    let factor = made_hz / needed_hz;
    format!("{made_hz:.1} pulses/s made since the start, {needed_hz:.1} needed (factor {factor:.3})")
}

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
    pub ring: Consumer<Pulse>,
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
        pulse: Box<Pulse>,
        too_late: bool,
    },
    Ended,
}

/// What distinguishes a pulse that was made too late from a pacer that is late.
struct Judge {
    /// When the stream started.
    start: Instant,
    /// `start + latency`; moves under policy `slip`.
    zero: Instant,
    /// The last time that the ring was seen empty: whatever came since was made after it.
    seen_empty: Option<Instant>,
    /// The pacer's own worst lateness, and the last pulse that it may have held back.
    held: Duration,
    held_until: u64,
}

impl Judge {
    fn deadline(&self, schedule: &Schedule, index: u64) -> Instant {
        Schedule::after(self.zero, schedule.offset(index))
    }

    /// The instant after which a pulse that is not in the ring was made too late.
    fn limit(&self, schedule: &Schedule, index: u64) -> Instant {
        let held = if index <= self.held_until { self.held } else { Duration::ZERO };
        Schedule::after(self.deadline(schedule, index), schedule.pri(index).saturating_add(held))
    }

    /// Takes note of the pacer's own lateness at a release.
    fn released(&mut self, index: u64, own: Duration, ring_slots: usize) {
        if own >= self.held || index > self.held_until {
            self.held = own;
            self.held_until = index.saturating_add(2 * ring_slots as u64);
        }
    }
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
        let mut judge = Judge { start, zero: begin, seen_empty: None, held: Duration::ZERO, held_until: 0 };
        let mut expected = self.schedule.first;
        let mut reported = Instant::now();
        let mut cut_short = false;
        while let Arrival::Pulse { mut pulse, too_late } = self.next(&mut judge, expected, stop)? {
            let index = pulse.index;
            if index < expected {
                return Err(PacerError::Order { index, expected });
            }
            if too_late && self.settings.policy == Policy::Drop {
                // Counted as part of the gap before the next pulse that is released.
                self.ring.give_back(pulse);
                continue;
            }
            let gap = index - expected;
            if gap > 0 {
                self.health.drop_pulses(gap);
                pulse.flags |= flags::AFTER_GAP;
            }
            self.health.ring_level(self.ring.filled() + 1);
            let (mut released, mut was_late, moved) = (None, false, judge.zero - begin);
            let mut held_up = false;
            if self.settings.pace == Pace::Realtime {
                let deadline = judge.deadline(&self.schedule, index);
                if !sleep_until(deadline, sleeper, stop) {
                    cut_short = true;
                    break;
                }
                let now = Instant::now();
                let lateness = now.saturating_duration_since(deadline);
                let late = lateness > self.schedule.pri(index);
                if late {
                    pulse.flags |= flags::LATE;
                    held_up = judge.seen_empty.is_none_or(|empty| empty <= deadline);
                }
                if !too_late {
                    // What the pulse itself came late is not the pacer's.
                    let since = judge.seen_empty.map_or(deadline, |empty| empty.max(deadline));
                    let own = now.saturating_duration_since(since);
                    judge.released(index, own, self.settings.ring_slots);
                } else if self.settings.policy == Policy::Slip {
                    judge.zero = Schedule::after(judge.zero, lateness);
                    self.health.slip(lateness);
                }
                released = Some(lateness);
                was_late = late;
            }
            expected = index + 1;
            self.health.navigated(&pulse);
            let Some(free) = self.fan_out.send(pulse) else {
                cut_short = true;
                break;
            };
            self.health.release(released, was_late, moved);
            if held_up {
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
                    Policy::Drop => {
                        let elapsed = now.saturating_duration_since(judge.start);
                        self.worth.raise(self.schedule.due_after(elapsed));
                    }
                }
            }
            self.ring.doze(self.until_next_poll(judge, now, expected));
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
        PacerError::Underrun {
            stage: "echo generation",
            index,
            late_by_s: now.saturating_duration_since(deadline).as_secs_f64(),
            made_hz: self.health.made_pulses() as f64 / elapsed_s,
            needed_hz: self.schedule.times.mean_prf_hz(),
            latency: self.in_hand(),
        }
    }

    fn in_hand(&self) -> InHand {
        let batch_s = self.settings.batch_pulses as f64 / self.schedule.times.mean_prf_hz();
        InHand { latency_s: self.settings.latency_s, batch_s }
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
pub(super) mod tests {
    use super::*;
    use crate::pulse::{Layout, SampleFormat};
    use crate::time::PulseTimes;
    use crate::transport::ring::ring;

    /// The least that a pulse can have.
    pub const LAYOUT: Layout = Layout {
        channels: 1,
        samples: 1,
        format: SampleFormat::Cf32,
        platforms: 0,
        antennas: 0,
        targets: 0,
        pairs: 0,
        ships: 0,
        clocks: 0,
    };

    /// A pacer whose ring already holds pulses with these indices, and its health.
    fn filled(policy: Policy, indices: &[u64], count: u64) -> (Pacer, Arc<Health>) {
        let (mut producer, ring) = ring(indices.iter().map(|_| Pulse::new(&LAYOUT)));
        let never = AtomicBool::new(false);
        for (slot, &index) in producer.reserve(indices.len(), &never).unwrap().iter_mut().zip(indices) {
            slot.index = index;
        }
        producer.commit(indices.len());
        let health = Arc::new(Health::new(Vec::new(), 0));
        let pacer = Pacer {
            ring,
            fan_out: FanOut::new(Vec::new(), Pace::Realtime),
            schedule: Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count },
            settings: Settings {
                pace: Pace::Realtime,
                policy,
                latency_s: 0.0,
                ring_slots: 8,
                threads: 1,
                ..Settings::default()
            },
            health: Arc::clone(&health),
            worth: Worth::default(),
            status: None,
        };
        (pacer, health)
    }

    #[test]
    fn a_pacer_that_is_late_itself_is_no_underrun() {
        for policy in [Policy::Stop, Policy::Slip, Policy::Drop] {
            let (pacer, health) = filled(policy, &[0, 1, 2, 3], 4);
            let start = Instant::now().checked_sub(Duration::from_millis(100)).unwrap();
            pacer.run(start, &AtomicBool::new(false)).unwrap();
            let shot = health.snapshot();
            assert_eq!((shot.pulses, shot.late, shot.held_up, shot.dropped), (4, 4, 4, 0), "{policy:?}");
            assert!(shot.slipped_s == 0.0 && shot.lateness_us.max >= 97_000.0, "{policy:?} {shot:?}");
        }
    }

    /// Each batch comes less than an interval later than the one before: at last they are too late all the
    /// same.
    #[test]
    fn a_generation_that_is_short_by_little_is_short() {
        let (batches, batch) = (60, 10);
        let (mut producer, ring) = ring((0..4 * batch).map(|_| Pulse::new(&LAYOUT)));
        let (template, health) = filled(Policy::Drop, &[0], (batches * batch) as u64);
        let pacer = Pacer { ring, ..template };
        thread::scope(|scope| {
            let start = Instant::now();
            let pacing = scope.spawn(move || pacer.run(start, &AtomicBool::new(false)));
            let never = AtomicBool::new(false);
            for n in 0..batches {
                for (slot, index) in producer.reserve(batch, &never).unwrap().iter_mut().zip(n * batch..) {
                    slot.index = index as u64;
                }
                // A batch of 10 ms takes 10.5.
                let due = start + Duration::from_micros(10_500) * n as u32;
                thread::sleep(due.saturating_duration_since(Instant::now()));
                producer.commit(batch);
            }
            drop(producer);
            pacing.join().unwrap().unwrap();
        });
        let shot = health.snapshot();
        assert!(shot.dropped > 0, "{shot:?}");
    }

    /// A batch that comes late is late from its first pulse to its last: nothing of it leaves in a burst.
    #[test]
    fn a_late_batch_is_discarded_whole() {
        let (mut producer, ring) = ring((0..4).map(|_| Pulse::new(&LAYOUT)));
        let (template, health) = filled(Policy::Drop, &[0], 4);
        let pacer = Pacer { ring, ..template };
        let ended = thread::scope(|scope| {
            let pacing = scope.spawn(|| pacer.run(Instant::now(), &AtomicBool::new(false)));
            let never = AtomicBool::new(false);
            for (slot, index) in producer.reserve(4, &never).unwrap().iter_mut().zip(0..) {
                slot.index = index;
            }
            thread::sleep(Duration::from_millis(50));
            producer.commit(4);
            drop(producer);
            pacing.join().unwrap()
        });
        let shot = health.snapshot();
        assert_eq!((shot.pulses, shot.late, shot.dropped), (0, 0, 4));
        // Nor does a run end well that released nothing.
        let Err(error @ PacerError::NothingReleased { pulses: 4, .. }) = ended else { panic!("{ended:?}") };
        insta::assert_snapshot!(error, @r#"not one pulse of 4 was released: policy = "drop" discards what is made too late, and all of them were. Allowed: stream.latency_ms = 1 or more (it is 0; pulses are made in blocks, and a block for every thread is that long), a lighter scene, policy = "slip", or --pace fast"#);
    }

    #[test]
    fn what_the_pacer_held_back_is_allowed_for_two_rings() {
        let schedule = Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count: 100 };
        let start = Instant::now();
        let mut judge = Judge { start, zero: start, seen_empty: None, held: Duration::ZERO, held_until: 0 };
        judge.released(10, Duration::from_millis(300), 8);
        judge.released(11, Duration::from_millis(299), 8);
        let allowed = |index: u64| judge.limit(&schedule, index) - judge.deadline(&schedule, index);
        assert_eq!(allowed(26), Duration::from_millis(301));
        assert_eq!(allowed(27), Duration::from_millis(1));
    }

    #[test]
    fn the_shortage_reads_as_it_should() {
        let error = |index, made_hz, latency_s| PacerError::Underrun {
            stage: "echo generation",
            index,
            late_by_s: 0.00512,
            made_hz,
            needed_hz: 222.0,
            latency: InHand { latency_s, batch_s: 74.0 / 222.0 },
        };
        insta::assert_snapshot!(error(812, 111.0, 0.5), @r#"echo generation cannot keep up: 5.1 ms after its deadline pulse 812 is not made yet; 111.0 pulses/s made since the start, 222.0 needed (factor 0.500). Allowed: more stream.latency_ms, a lighter scene, policy = "slip" or "drop", or --pace fast"#);
        insta::assert_snapshot!(error(0, 0.0, 0.0015), @r#"echo generation cannot keep up: 5.1 ms after its deadline pulse 0 is not made yet; no other is, either. Allowed: stream.latency_ms = 334 or more (it is 1.5; pulses are made in blocks, and a block for every thread is that long), a lighter scene, policy = "slip" or "drop", or --pace fast"#);
    }

    #[test]
    fn skipped_indices_are_counted_and_pulses_out_of_order_refused() {
        let (pacer, health) = filled(Policy::Drop, &[0, 3, 4], 5);
        pacer.run(Instant::now(), &AtomicBool::new(false)).unwrap();
        assert_eq!((health.released_pulses(), health.dropped_pulses()), (3, 2));
        let (pacer, _) = filled(Policy::Drop, &[0, 2, 2], 5);
        let refused = pacer.run(Instant::now(), &AtomicBool::new(false));
        assert_eq!(refused, Err(PacerError::Order { index: 2, expected: 3 }));
    }
}
