//! What threads that make pulses share: things that are found once, by whichever thread needs them first.
//!
//! The only locks among them: held while something is found, not while a pulse is made of it. What is found depends on neither the
//! thread nor the order in which it is asked for.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// How many are kept.
const MOST: usize = 64;

/// Things that are kept about the number asked for last.
#[derive(Debug)]
pub(super) struct Kept<T> {
    found: Mutex<BTreeMap<u64, Arc<OnceLock<Arc<T>>>>>,
}

/// What one thread uses at a time.
#[derive(Debug)]
pub(super) struct OneAtATime<T>(Mutex<T>);

impl<T> OneAtATime<T> {
    /// Of something that stays usable wherever a thread that uses it stops.
    pub fn new(inner: T) -> Self {
        Self(Mutex::new(inner))
    }

    /// Uses it as soon as nobody else does.
    pub fn with<R>(&self, use_it: impl FnOnce(&mut T) -> R) -> R {
        use_it(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self { found: Mutex::default() }
    }
}

impl<T> Kept<T> {
    /// The thing of a number. Who asks for it while it is found waits; whoever asks for others does not. The
    /// farthest from this number is forgotten: found again it must be the same.
    pub fn get(&self, number: u64, find: impl FnOnce() -> T) -> Arc<T> {
        let place = {
            let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
            let place = Arc::clone(found.entry(number).or_default());
            if found.len() > MOST {
                let ends = [found.first_key_value(), found.last_key_value()];
                let farthest =
                    ends.into_iter().flatten().map(|(at, _)| *at).max_by_key(|at| at.abs_diff(number));
                farthest.and_then(|farthest| found.remove(&farthest));
            }
            place
        };
        Arc::clone(place.get_or_init(|| Arc::new(find())))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Eight threads that ask for the same at once make each thing once.
    #[test]
    fn everything_is_found_once() {
        let (kept, count, barrier) = (Kept::default(), AtomicUsize::new(0), Barrier::new(8));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    barrier.wait();
                    for number in 0..20u64 {
                        let found = kept.get(number, || {
                            count.fetch_add(1, Ordering::Relaxed);
                            std::thread::sleep(std::time::Duration::from_millis(2));
                            3 * number
                        });
                        assert_eq!(*found, 3 * number);
                    }
                });
            }
        });
        assert_eq!(count.into_inner(), 20);
    }

    #[test]
    fn few_are_kept() {
        let (kept, mut found) = (Kept::default(), 0);
        for number in (0..100_000).chain([5, 99_990, 5]) {
            kept.get(number, || found += 1);
        }
        assert_eq!(kept.found.lock().unwrap().len(), MOST);
        // Those about the end are still there; the first is not, and once found again it is kept.
        assert_eq!(found, 100_001);
    }
}
