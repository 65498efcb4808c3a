//! What share of the machine the monitor may take.
//!
//! Generation uses every core, so what the monitor computes is taken from it. Work is begun only while its
//! time so far stays below a share of the time of all cores; a machine that is too slow for it shows fewer
//! rows. What counts is the processor's time: a thread of the lowest priority waits for long on a busy
//! machine, and that costs nobody anything. Range lines and range-Doppler maps have a half each, or a quarter
//! where the radials of a scanning antenna have the other half: a map costs as much as a hundred lines, and
//! none may starve another.

use std::thread;
use std::time::{Duration, Instant};

/// Share of the time of all cores.
const SHARE: f64 = 0.01;
/// What may be spent at once after a time of rest.
const SAVED: Duration = Duration::from_millis(60);

/// Time that may be spent.
#[derive(Debug)]
pub struct Budget {
    /// Seconds earned in a second.
    rate: f64,
    left_s: f64,
    read: Instant,
}

/// Processor time of this thread; time that passes where the system does not say.
fn spent(begun: Instant) -> Duration {
    #[cfg(unix)]
    if let Ok(time) = nix::time::clock_gettime(nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID) {
        return time.into();
    }
    begun.elapsed()
}

impl Budget {
    /// A part of the share of this machine.
    pub fn of_this_machine(part: f64) -> Self {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        Self::of(part * SHARE * cores as f64, SAVED.as_secs_f64())
    }

    /// Seconds earned in a second, and those that may be spent at once.
    pub fn of(rate: f64, left_s: f64) -> Self {
        Self { rate, left_s, read: Instant::now() }
    }

    /// Does some work, if there is time for it now.
    pub fn spend<T>(&mut self, work: impl FnOnce() -> T) -> Option<T> {
        let begun = Instant::now();
        let earned = begun.saturating_duration_since(self.read).as_secs_f64() * self.rate;
        self.left_s = (self.left_s + earned).min(SAVED.as_secs_f64());
        self.read = begun;
        if self.left_s <= 0.0 {
            return None;
        }
        let before = spent(begun);
        let done = work();
        self.left_s -= spent(begun).saturating_sub(before).as_secs_f64();
        Some(done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Works for so long of the processor's time.
    fn work(time: Duration) {
        let begun = Instant::now();
        let before = spent(begun);
        while spent(begun).saturating_sub(before) < time {
            std::hint::spin_loop();
        }
    }

    #[test]
    fn what_takes_long_is_done_less_often() {
        let mut budget = Budget::of(0.1, 0.001);
        let begun = Instant::now();
        let mut pieces = 0;
        while begun.elapsed() < Duration::from_millis(400) {
            pieces += i32::from(budget.spend(|| work(Duration::from_millis(4))).is_some());
            thread::sleep(Duration::from_millis(1));
        }
        // A tenth of the time, what was saved at the beginning, and the last piece, which overdraws: 11 of 4
        // ms.
        let allowed = 0.1 * begun.elapsed().as_secs_f64() / 0.004 + 2.0;
        assert!(pieces > 0 && f64::from(pieces) <= allowed, "{pieces} of {allowed}");
    }

    /// To wait is not to work.
    #[test]
    #[cfg(unix)]
    fn time_that_others_take_is_not_counted() {
        let mut budget = Budget::of(0.0, 0.01);
        for _ in 0..20 {
            assert!(budget.spend(|| thread::sleep(Duration::from_millis(2))).is_some());
        }
        assert!(budget.spend(|| work(Duration::from_millis(11))).is_some() && budget.spend(|| ()).is_none());
    }
}
