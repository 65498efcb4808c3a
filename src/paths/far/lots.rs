//! Lots of cells that were found, for all threads: each is found once, by whichever needs it first.
//!
//! What a lot holds follows from its slot and square alone, so that it does not matter who finds it, when,
//! or how often. Half of those that are kept go, the longest unused, when there are too many.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::cells::Cells;
use super::squares::Square;

/// Lots that are kept, at most.
pub(super) const MOST_LOTS: usize = 1024;

/// A slot and a square.
type Key = (i64, Square);

/// The lots.
#[derive(Debug, Default)]
pub(super) struct Lots(Mutex<Inner>);

#[derive(Debug, Default)]
struct Inner {
    lots: HashMap<Key, Lot>,
    uses: u64,
}

#[derive(Debug)]
struct Lot {
    used: u64,
    cells: Arc<OnceLock<Cells>>,
}

impl Lots {
    /// Uses the cells of a lot; `make` finds them where nobody has.
    pub fn with<R>(&self, key: Key, make: impl FnOnce() -> Cells, use_it: impl FnOnce(&Cells) -> R) -> R {
        let cells = self.place_of(key);
        use_it(cells.get_or_init(make))
    }

    fn place_of(&self, key: Key) -> Arc<OnceLock<Cells>> {
        let mut inner = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let inner = &mut *inner;
        inner.uses += 1;
        let used = inner.uses;
        if let Some(lot) = inner.lots.get_mut(&key) {
            lot.used = used;
            return Arc::clone(&lot.cells);
        }
        if inner.lots.len() >= MOST_LOTS {
            let mut uses: Vec<u64> = inner.lots.values().map(|lot| lot.used).collect();
            let (_, middle, _) = uses.select_nth_unstable(MOST_LOTS / 2);
            inner.lots.retain(|_, lot| lot.used >= *middle);
        }
        let lot = inner.lots.entry(key).or_insert(Lot { used, cells: Arc::default() });
        Arc::clone(&lot.cells)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::frames::Point;

    fn of(x: f64) -> Cells {
        Cells { places: vec![Point::new(x, 0.0, 0.0)], pairs: Vec::new() }
    }

    /// Threads that ask for the same find it once, and the last used stay.
    #[test]
    fn lots_are_found_once_and_the_last_used_stay() {
        let (lots, found) = (Lots::default(), AtomicUsize::new(0));
        let ask = |slot: i64| {
            let make = || {
                found.fetch_add(1, Ordering::Relaxed);
                of(slot as f64)
            };
            let place = lots.with((slot, Square::ALL), make, |cells| cells.places[0]);
            assert_eq!(place, Point::new(slot as f64, 0.0, 0.0));
        };
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(ask));
            }
        });
        assert_eq!(found.load(Ordering::Relaxed), 1000);
        for slot in 1000..20_000 {
            ask(slot);
            ask(0);
        }
        assert_eq!(found.load(Ordering::Relaxed), 20_000);
        assert!(lots.0.lock().unwrap().lots.len() <= MOST_LOTS);
    }
}
