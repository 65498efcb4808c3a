//! When a pulse is due, when it was made too late, and when what is overdue leaves: see
//! [`pacer`](super::pacer).

use std::time::{Duration, Instant};

use super::schedule::Schedule;

/// Pulses that may leave at once after a delay: few enough for every queue.
pub const BURST_PULSES: u32 = 8;

/// Time emitted for a second of delay that generation has to make up for.
const CATCH_UP: u32 = 20;

/// What distinguishes a pulse that was made too late from a pacer that is late.
#[derive(Debug)]
pub(super) struct Judge {
    /// When the stream started.
    pub(super) start: Instant,
    /// `start + latency`; moves under policy `slip`.
    pub(super) zero: Instant,
    /// The last time that the ring was seen empty: whatever came since was made after it.
    pub(super) seen_empty: Option<Instant>,
    /// The pacer's own worst lateness, and the last pulse that it may have held back.
    held: Duration,
    held_until: u64,
    /// Standstills since a pulse was last released in time.
    pub(super) stood_still: Duration,
    /// The last release.
    pub(super) last: Option<Instant>,
}

impl Judge {
    pub(super) fn new(start: Instant, zero: Instant) -> Self {
        let (held, stood_still) = (Duration::ZERO, Duration::ZERO);
        Self { start, zero, seen_empty: None, held, held_until: 0, stood_still, last: None }
    }

    pub(super) fn deadline(&self, schedule: &Schedule, index: u64) -> Instant {
        Schedule::after(self.zero, schedule.offset(index))
    }

    /// How much later than in time a pulse may be, because the pacer was.
    pub(super) fn allowance(&self, schedule: &Schedule, index: u64) -> Duration {
        if self.held.is_zero() || index <= self.held_until {
            return self.held;
        }
        let since = schedule.offset(index).saturating_sub(schedule.offset(self.held_until));
        self.held.saturating_sub(since / CATCH_UP)
    }

    /// The instant after which a pulse that is not in the ring was made too late.
    pub(super) fn limit(&self, schedule: &Schedule, index: u64) -> Instant {
        let allowed = schedule.pri(index).saturating_add(self.allowance(schedule, index));
        Schedule::after(self.deadline(schedule, index), allowed)
    }

    /// When a pulse is to leave: at its deadline, and what is overdue half an interval after the one before.
    pub(super) fn due(&self, schedule: &Schedule, index: u64, now: Instant) -> Instant {
        let deadline = self.deadline(schedule, index);
        let Some(last) = self.last else { return deadline };
        let pri = schedule.pri(index.saturating_sub(1));
        let burst = Schedule::after(deadline, pri.saturating_mul(BURST_PULSES));
        if now <= burst { deadline } else { deadline.max(Schedule::after(last, pri / 2)) }
    }

    /// Takes note of the pacer's own lateness at a release.
    pub(super) fn released(&mut self, schedule: &Schedule, index: u64, own: Duration, ring_slots: usize) {
        if own >= self.allowance(schedule, index) {
            self.held = own;
            self.held_until = index.saturating_add(2 * ring_slots as u64);
        }
    }

    /// Takes note of a standstill before a pulse.
    pub(super) fn stood_still(
        &mut self,
        schedule: &Schedule,
        index: u64,
        so_long: Duration,
        ring_slots: usize,
    ) {
        self.stood_still = self.stood_still.saturating_add(so_long);
        self.held = self.allowance(schedule, index).saturating_add(so_long);
        self.held_until = index.saturating_add(2 * ring_slots as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::PulseTimes;

    #[test]
    fn what_the_pacer_held_back_is_allowed_for_two_rings() {
        let schedule = Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count: 10_000 };
        let start = Instant::now();
        let mut judge = Judge::new(start, start);
        judge.released(&schedule, 10, Duration::from_millis(300), 8);
        judge.released(&schedule, 11, Duration::from_millis(299), 8);
        let allowed =
            |judge: &Judge, index: u64| judge.limit(&schedule, index) - judge.deadline(&schedule, index);
        assert_eq!(allowed(&judge, 26), Duration::from_millis(301));
        // Then as much less as a generation makes up for that is a twentieth faster than real time.
        assert_eq!(allowed(&judge, 46), Duration::from_millis(300));
        assert_eq!(allowed(&judge, 26 + 20 * 300), Duration::from_millis(1));
        // A standstill adds to what is left.
        judge.stood_still(&schedule, 46, Duration::from_secs(2), 8);
        assert_eq!(allowed(&judge, 50), Duration::from_millis(2300));
    }
}
