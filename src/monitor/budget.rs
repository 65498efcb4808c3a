//! What share of the machine the monitor may take.
//!
//! Generation uses every core, so what the monitor computes is taken from it. Work is begun only while its time
//! so far stays below a share of the time of all cores; a machine that is too slow for it shows fewer rows.

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

impl Budget {
    /// A share of this machine.
    pub fn of_this_machine() -> Self {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        Self { rate: SHARE * cores as f64, left_s: SAVED.as_secs_f64(), read: Instant::now() }
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
        let done = work();
        self.left_s -= begun.elapsed().as_secs_f64();
        Some(done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_long_is_done_less_often() {
        let mut budget = Budget { rate: 0.1, left_s: 0.001, read: Instant::now() };
        let begun = Instant::now();
        let mut worked = Duration::ZERO;
        while begun.elapsed() < Duration::from_millis(300) {
            let one = Instant::now();
            if budget.spend(|| thread::sleep(Duration::from_millis(4))).is_some() {
                worked += one.elapsed();
            }
            thread::sleep(Duration::from_millis(1));
        }
        // A tenth, what was saved at the beginning, and the piece of work that overdraws it: which a busy machine
        // makes longer, and then there is one.
        let share = worked.as_secs_f64() / begun.elapsed().as_secs_f64();
        assert!(worked > Duration::ZERO && share < 0.5, "{share}");
    }
}
