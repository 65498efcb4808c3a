//! What was found of a scene and may be asked again, for another error.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::interpolation_error::Probed;
use super::points::Stretch;
use super::sweep::OfPlace;

/// Numbers of each kind that are kept, at most: 32 MiB of all.
const MOST_NUMBERS: usize = (1 << 22) / 3;

/// What was found, as long as there is room.
#[derive(Default)]
pub(super) struct Known {
    /// Of a place, with nodes so many pulses apart.
    pub probed: Kept<(usize, u64), Probed>,
    /// Of gains: of their steps and pulses of a block.
    pub swept: Kept<(Vec<u64>, u64), Vec<OfPlace>>,
    /// Points in a stretch of the run.
    pub stretches: Kept<usize, Stretch>,
}

/// Results by what they depend on.
pub(super) struct Kept<K, V> {
    of: BTreeMap<K, Rc<V>>,
    numbers: usize,
}

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self { of: BTreeMap::new(), numbers: 0 }
    }
}

impl<K: Ord, V> Kept<K, V> {
    pub fn get(&self, key: &K) -> Option<Rc<V>> {
        self.of.get(key).map(Rc::clone)
    }

    /// Keeps a result that consists of so many numbers, unless there is no room.
    pub fn keep(&mut self, key: K, found: V, numbers: usize) -> Rc<V> {
        let found = Rc::new(found);
        if self.numbers.saturating_add(numbers) <= MOST_NUMBERS {
            self.numbers += numbers;
            self.of.insert(key, Rc::clone(&found));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_room_is_not_kept() {
        let mut kept = Kept::default();
        assert_eq!(*kept.keep(1, "small", 10), "small");
        assert_eq!(*kept.keep(2, "large", MOST_NUMBERS - 9), "large");
        assert_eq!(*kept.keep(3, "endless", usize::MAX), "endless");
        assert_eq!([1, 2, 3].map(|key| kept.get(&key).is_some()), [true, false, false]);
    }
}
