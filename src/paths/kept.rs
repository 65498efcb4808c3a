//! What threads that make pulses share: things that are found once, by whichever thread needs them first.
//!
//! The only locks among them: who asks for a thing while it is found waits, who asks for another does not,
//! and what is found is used by all at once. It depends on neither the thread nor the order in which it is
//! asked for. Places of [`Kept`] are made beforehand and taken again, so that a run in its steady state
//! allocates nothing; [`KeptMany`] is for thousands of things, and allocates each.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};

/// The things that were found last, each of a number or another key.
#[derive(Debug)]
pub(super) struct Kept<K, T> {
    /// What each place is for, and which is taken next.
    keys: Mutex<(Box<[Option<K>]>, usize)>,
    places: Box<[RwLock<Place<K, T>>]>,
}

#[derive(Debug)]
struct Place<K, T> {
    /// Whose thing it is; `None` while it is found, or if that failed.
    of: Option<K>,
    thing: T,
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

impl<K: Copy + PartialEq, T> Kept<K, T> {
    /// So many places, one at least.
    pub fn new(places: usize, mut make: impl FnMut() -> T) -> Self {
        let places: Box<[_]> =
            (0..places.max(1)).map(|_| RwLock::new(Place { of: None, thing: make() })).collect();
        Self { keys: Mutex::new((places.iter().map(|_| None).collect(), 0)), places }
    }

    /// Uses the thing of a key; `find` puts it in place of the one that was found longest ago, unless it is
    /// there. Found again it must be the same.
    ///
    /// # Errors
    /// Those of `find`.
    pub fn with<R, E>(
        &self,
        key: K,
        find: impl FnOnce(&mut T) -> Result<(), E>,
        use_it: impl FnOnce(&T) -> R,
    ) -> Result<R, E> {
        loop {
            let at = self.place_for(key);
            {
                let place = self.places[at].read().unwrap_or_else(PoisonError::into_inner);
                if place.of == Some(key) {
                    return Ok(use_it(&place.thing));
                }
            }
            let mut place = self.places[at].write().unwrap_or_else(PoisonError::into_inner);
            if place.of != Some(key) {
                // Given away while this thread waited.
                if self.place_for(key) != at {
                    continue;
                }
                place.of = None;
                find(&mut place.thing)?;
                place.of = Some(key);
            }
            return Ok(use_it(&place.thing));
        }
    }

    /// How many are kept.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.keys.lock().unwrap().0.iter().flatten().count()
    }

    /// Where the thing of a key is or will be.
    fn place_for(&self, key: K) -> usize {
        let mut keys = self.keys.lock().unwrap_or_else(PoisonError::into_inner);
        let (keys, next) = &mut *keys;
        if let Some(at) = keys.iter().position(|of| *of == Some(key)) {
            return at;
        }
        let at = *next;
        (keys[at], *next) = (Some(key), (at + 1) % keys.len());
        at
    }
}

/// Many things, of which the longest unused half goes where there are too many.
#[derive(Debug)]
pub(super) struct KeptMany<K, T> {
    most: usize,
    inner: Mutex<Many<K, T>>,
}

#[derive(Debug)]
struct Many<K, T> {
    /// When each was used last, and what it is once it is found.
    things: HashMap<K, (u64, Arc<OnceLock<T>>)>,
    uses: u64,
}

impl<K: Copy + Eq + Hash, T> KeptMany<K, T> {
    /// So many at most.
    pub fn new(most: usize) -> Self {
        Self { most, inner: Mutex::new(Many { things: HashMap::new(), uses: 0 }) }
    }

    /// Uses the thing of a key; `find` finds it where nobody has. Found again it must be the same.
    pub fn with<R>(&self, key: K, find: impl FnOnce() -> T, use_it: impl FnOnce(&T) -> R) -> R {
        use_it(self.place_of(key).get_or_init(find))
    }

    fn place_of(&self, key: K) -> Arc<OnceLock<T>> {
        // Freed when nobody waits any more.
        let mut gone = Vec::new();
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let Many { things, uses } = &mut *inner;
        *uses += 1;
        if let Some((used, place)) = things.get_mut(&key) {
            *used = *uses;
            return Arc::clone(place);
        }
        if things.len() >= self.most {
            let mut times: Vec<u64> = things.values().map(|(used, _)| *used).collect();
            let (_, middle, _) = times.select_nth_unstable(self.most / 2);
            gone.extend(things.extract_if(|_, (used, _)| *used < *middle));
        }
        let (_, place) = things.entry(key).or_insert((*uses, Arc::default()));
        Arc::clone(place)
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Eight threads that ask for the same at once make each thing once.
    #[test]
    fn everything_is_found_once() {
        let (kept, count, barrier) = (Kept::new(64, || 0), AtomicUsize::new(0), Barrier::new(8));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    barrier.wait();
                    for number in -10..10i64 {
                        let find = |place: &mut i64| {
                            count.fetch_add(1, Ordering::Relaxed);
                            std::thread::sleep(std::time::Duration::from_millis(2));
                            *place = 3 * number;
                            Ok::<_, Infallible>(())
                        };
                        let Ok(found) = kept.with(number, find, |found| *found);
                        assert_eq!(found, 3 * number);
                    }
                });
            }
        });
        assert_eq!(count.into_inner(), 20);
    }

    /// Threads that ask for more than there is place for find all of it right.
    #[test]
    fn what_is_found_is_right_in_any_order() {
        let kept = Kept::new(3, || 0);
        std::thread::scope(|scope| {
            for thread in 0..4i64 {
                let kept = &kept;
                scope.spawn(move || {
                    for n in 0..20_000 {
                        let number = (n * (2 * thread + 1)) % 7;
                        let find = |place: &mut i64| {
                            *place = 3 * number;
                            Ok::<_, Infallible>(())
                        };
                        let Ok(found) = kept.with(number, find, |found| *found);
                        assert_eq!(found, 3 * number);
                    }
                });
            }
        });
    }

    /// Threads that ask for the same of many find it once, and the last used stay.
    #[test]
    fn many_are_found_once_and_the_last_used_stay() {
        let (kept, found) = (KeptMany::new(1024), AtomicUsize::new(0));
        let ask = |number: usize| {
            let find = || {
                found.fetch_add(1, Ordering::Relaxed);
                3 * number
            };
            assert_eq!(kept.with(number, find, |thing| *thing), 3 * number);
        };
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(ask));
            }
        });
        assert_eq!(found.load(Ordering::Relaxed), 1000);
        for number in 1000..20_000 {
            ask(number);
            ask(0);
        }
        assert_eq!(found.load(Ordering::Relaxed), 20_000);
        assert!(kept.inner.lock().unwrap().things.len() <= 1024);
    }

    #[test]
    fn the_last_are_kept_and_failures_are_not() {
        let (kept, mut found) = (Kept::new(64, || 0), 0);
        for number in (0..100_000).chain([5, 99_990, 5]) {
            let find = |_: &mut i32| {
                found += 1;
                Ok::<_, Infallible>(())
            };
            let Ok(()) = kept.with(number, find, |_| ());
        }
        // Those about the end are still there; the first is not, and once found again it is kept.
        assert_eq!(found, 100_001);
        assert_eq!(kept.with(7, |_| Err("no track"), |_| ()), Err("no track"));
        assert_eq!(
            kept.with(
                7,
                |place| {
                    *place = 2;
                    Ok::<_, &str>(())
                },
                |place| *place,
            ),
            Ok(2)
        );
    }
}
