//! When each pulse of a run is due.
//!
//! Deadline of pulse n: `d(n) = start + latency + (t(n) - t(first))`, where t is the exact emission
//! time; the offset is rounded once, to the nearest integer nanosecond, so it never drifts.

use std::time::{Duration, Instant};

use crate::time::{PulseTimes, TimeTag};

/// The pulses of a run and their rhythm.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// The rhythm.
    pub times: PulseTimes,
    /// First pulse of this run.
    pub first: u64,
    /// Number of pulses of this run.
    pub count: u64,
}

impl Schedule {
    /// Emission of pulse `index` after that of the first pulse (zero for earlier ones).
    ///
    /// ```
    /// use nereus::{time::PulseTimes, transport::schedule::Schedule};
    /// let schedule = Schedule { times: PulseTimes::uniform(222.0).unwrap(), first: 7, count: 1 };
    /// // 1e9 / 222 s = 4504504 + 112/222 s
    /// assert_eq!(schedule.offset(1_000_000_007).as_nanos(), 4_504_504_504_504_505);
    /// ```
    pub fn offset(&self, index: u64) -> Duration {
        let zero = TimeTag::default();
        let first = self.times.emission(zero, self.first);
        let tag = self.times.emission(zero, index.max(self.first));
        let seconds = tag.seconds() - first.seconds();
        let nanoseconds = ((tag.fraction_s() - first.fraction_s()) * 1e9).round() as i64;
        // The fraction may be negative; then at least one whole second can be borrowed.
        let total = i128::from(seconds) * 1_000_000_000 + i128::from(nanoseconds);
        Duration::from_nanos(u64::try_from(total.max(0)).unwrap_or(u64::MAX))
    }

    /// The interval that follows pulse `index`.
    pub fn pri(&self, index: u64) -> Duration {
        Duration::try_from_secs_f64(self.times.interval_s(index, index.saturating_add(1)))
            .unwrap_or(Duration::ZERO)
    }

    /// One past the last pulse.
    pub fn end(&self) -> u64 {
        self.first.saturating_add(self.count)
    }

    /// The first pulse emitted at least `elapsed` after the first one of the run.
    pub fn due_after(&self, elapsed: Duration) -> u64 {
        let guess = (elapsed.as_secs_f64() * self.times.mean_prf_hz()) as u64;
        // The guess is off by a fraction of a cycle of the sequence and by rounding at most.
        let mut index = self.first.saturating_add(guess);
        while index > self.first && self.offset(index - 1) >= elapsed {
            index -= 1;
        }
        while self.offset(index) < elapsed && index < self.end() {
            index += 1;
        }
        index.min(self.end())
    }

    /// `start + by`, as far as an instant can be reported.
    pub(crate) fn after(start: Instant, by: Duration) -> Instant {
        const CENTURY: Duration = Duration::from_secs(100 * 365 * 86_400);
        start.checked_add(by).or_else(|| start.checked_add(CENTURY)).unwrap_or(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pulse_due_is_found_for_any_rhythm() {
        for times in [
            PulseTimes::uniform(333.3).unwrap(),
            PulseTimes::sequence(&[1e-3, 7e-3, 2e-3, 2e-3, 2e-3]).unwrap(),
        ] {
            let schedule = Schedule { times, first: 3, count: 1000 };
            for index in 4..900 {
                let offset = schedule.offset(index);
                assert_eq!(schedule.due_after(offset), index);
                assert_eq!(schedule.due_after(offset + Duration::from_nanos(1)), index + 1);
            }
            assert_eq!(schedule.due_after(Duration::ZERO), 3);
            assert_eq!(schedule.due_after(Duration::from_secs(1_000_000)), 1003);
        }
    }

    #[test]
    fn offsets_of_a_slow_and_of_a_far_schedule() {
        let slow = Schedule { times: PulseTimes::uniform(0.001).unwrap(), first: 0, count: u64::MAX };
        assert_eq!(slow.offset(5), Duration::from_secs(5000));
        assert_eq!(slow.pri(0), Duration::from_secs(1000));
        assert_eq!(slow.end(), u64::MAX);
        let now = Instant::now();
        assert!(Schedule::after(now, Duration::MAX) > now);
    }
}
