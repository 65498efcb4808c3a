//! Released pulses, read by several and copied for nobody.
//!
//! ```text
//!   generation -> ring of R slots -> pacer --- a reference each ---> sinks, onlooker
//!        ^                            |  ^                                |
//!        +--- one slot for another ---+  +-------- references back -------+
//! ```
//!
//! A pulse is made once, in a slot of the ring. When it is released, the pacer gives every reader a reference
//! to that slot through a [`Lane`], and generation another slot from the [`Pool`] in its place. Readers
//! return their references through their lanes; the one that comes back last makes the slot whole, and the
//! pool has it again. The pacer alone makes and takes back references, so whether one is the last is no race,
//! and it never waits for a slot:
//!
//! - A reader has at most as many pulses as its lane has room for, the one in its hands included. What all of
//!   them hold is never more than [`held_at_most`], and so many slots the pool has.
//! - So there is a slot for every pulse that is released. Generation always has R slots.
//!
//! The pool gives what came back last, which is still in the caches. Its slots are
//! [reserved](Pulse::reserved), and generation [fits](Pulse::fit) what it gets: what readers do not hold is
//! never touched, and takes no memory but that of its records.

use std::sync::Arc;
use std::time::Duration;

use super::ring::{self, Consumer, Polled, Producer, Slot};
use crate::pulse::{Layout, Pulse};

/// Slots that no pulse is in.
#[derive(Debug)]
pub struct Pool {
    free: Vec<Slot<Pulse>>,
    layout: Layout,
}

/// A pulse under way to a reader.
#[derive(Debug)]
struct Shared {
    pulse: Arc<Pulse>,
    /// Whether the reader missed pulses before this one.
    after_gap: bool,
}

/// The pacer's end of the way to a reader.
#[derive(Debug)]
pub struct Lane {
    queue: Producer<Shared>,
    /// References that have not come back.
    held: usize,
}

/// The other end.
#[derive(Debug)]
pub struct Reader {
    queue: Consumer<Shared>,
}

/// Distinct pulses that readers hold at most, given the room that each has and whether it is waited for.
///
/// Readers for whom it waits miss nothing. Each of them holds the latest pulses, without a gap, so together
/// they hold no more than the one with the most room. A reader that may miss pulses keeps old ones while it
/// gets none of the new, and others hold those: its room adds to theirs.
pub fn held_at_most(readers: impl IntoIterator<Item = (usize, bool)>) -> usize {
    let (mut together, mut apart) = (0, 0_usize);
    for (slots, waited_for) in readers {
        if waited_for {
            together = slots.max(together);
        } else {
            apart = apart.saturating_add(slots);
        }
    }
    apart.saturating_add(together)
}

/// The two ends of the way to a reader who may have so many pulses.
pub fn lane(slots: usize) -> (Lane, Reader) {
    let (producer, consumer) = ring::lane(slots);
    (Lane { queue: producer, held: 0 }, Reader { queue: consumer })
}

impl Pool {
    /// A pool of so many slots.
    pub fn new(slots: usize, layout: &Layout) -> Self {
        let mut pool = Self { free: Vec::new(), layout: *layout };
        pool.grow(slots);
        pool
    }

    /// Adds slots.
    pub fn grow(&mut self, slots: usize) {
        self.free.reserve(slots);
        let layout = self.layout;
        self.free.extend((0..slots).map(|_| Slot::new(Pulse::reserved(&layout))));
    }

    /// Slots that it has now.
    #[cfg(test)]
    pub fn slots(&self) -> usize {
        self.free.len()
    }

    fn put(&mut self, shared: Arc<Pulse>) {
        self.free.extend(Slot::reclaim(shared));
    }

    /// A slot for one that was shared: itself, if nobody took it.
    pub fn exchange(&mut self, shared: Arc<Pulse>) -> Slot<Pulse> {
        self.put(shared);
        // One short where a reader broke off with a pulse in its hands, or as one came: that is made up for.
        self.free.pop().unwrap_or_else(|| Slot::new(Pulse::new(&self.layout)))
    }
}

impl Lane {
    /// Pulses that the reader may have.
    pub fn slots(&self) -> usize {
        self.queue.slots()
    }

    /// Pulses that wait for the reader.
    pub fn waiting(&self) -> usize {
        self.queue.filled()
    }

    /// Whether the reader has gone.
    pub fn is_abandoned(&self) -> bool {
        self.queue.is_abandoned()
    }

    /// Takes back what the reader has returned; whether it may have one more.
    pub fn has_room(&mut self, pool: &mut Pool) -> bool {
        while let Some(shared) = self.queue.take_back() {
            self.held = self.held.saturating_sub(1);
            pool.put(shared.pulse);
        }
        self.held < self.queue.slots()
    }

    /// Gives a pulse to the reader, who [has room](Self::has_room).
    pub fn send(&mut self, pulse: &Arc<Pulse>, after_gap: bool) {
        self.held += 1;
        self.queue.send(Shared { pulse: Arc::clone(pulse), after_gap });
    }
}

impl Reader {
    /// Pulses that wait.
    pub fn waiting(&self) -> usize {
        self.queue.filled()
    }

    /// Reads the oldest pulse that waits, if there is one, and gives it back. `read` also gets how many wait
    /// behind it, and whether pulses were missed before it.
    pub fn poll<R>(&mut self, read: impl FnOnce(&Pulse, usize, bool) -> R) -> Polled<R> {
        let polled = self.queue.poll();
        self.read(polled, read)
    }

    /// The same, and waits for a pulse for at most `timeout`.
    pub fn wait_for<R>(
        &mut self,
        timeout: Duration,
        read: impl FnOnce(&Pulse, usize, bool) -> R,
    ) -> Polled<R> {
        let polled = self.queue.wait_for(timeout);
        self.read(polled, read)
    }

    fn read<R>(&mut self, polled: Polled<Shared>, read: impl FnOnce(&Pulse, usize, bool) -> R) -> Polled<R> {
        match polled {
            Polled::Slot(shared) => {
                let read = read(&shared.pulse, self.queue.filled(), shared.after_gap);
                self.queue.give_back(shared);
                Polled::Slot(read)
            }
            Polled::Empty => Polled::Empty,
            Polled::Ended => Polled::Ended,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::transport::pacer::tests::LAYOUT;

    /// Where pulses are, and how many references the pacer misses.
    struct Readers {
        pool: Pool,
        ends: Vec<(Lane, Reader, bool)>,
        slot: Option<Slot<Pulse>>,
        places: BTreeSet<usize>,
    }

    impl Readers {
        /// Readers with so much room, and whether they are waited for.
        fn new(readers: &[(usize, bool)]) -> Self {
            let slots = held_at_most(readers.iter().copied());
            let pool = Pool::new(slots, &LAYOUT);
            let slot = Slot::new(Pulse::new(&LAYOUT));
            let place = |slot: &Slot<Pulse>| std::ptr::from_ref::<Pulse>(slot).addr();
            let places = pool.free.iter().chain([&slot]).map(place).collect();
            let ends = readers.iter().map(|(room, waited_for)| {
                let (lane, reader) = lane(*room);
                (lane, reader, *waited_for)
            });
            Self { pool, ends: ends.collect(), slot: Some(slot), places }
        }

        fn read(&mut self, k: usize) -> Option<u64> {
            match self.ends[k].1.poll(|pulse, _, _| pulse.index) {
                Polled::Slot(index) => Some(index),
                Polled::Empty | Polled::Ended => None,
            }
        }

        /// Releases a pulse; which readers missed it.
        fn release(&mut self, index: u64) -> Vec<usize> {
            // Who is waited for reads what it has, until there is room.
            for k in 0..self.ends.len() {
                let (lane, reader, waited_for) = &mut self.ends[k];
                while *waited_for && !lane.has_room(&mut self.pool) {
                    reader.poll(|_, _, _| ());
                }
            }
            let mut slot = self.slot.take().unwrap();
            slot.index = index;
            let pulse = slot.share();
            let mut missed = Vec::new();
            for (k, (lane, _, _)) in self.ends.iter_mut().enumerate() {
                if lane.has_room(&mut self.pool) {
                    lane.send(&pulse, false);
                } else {
                    missed.push(k);
                }
            }
            let slot = self.pool.exchange(pulse);
            // Never one that was not there at the beginning.
            assert!(self.places.contains(&std::ptr::from_ref::<Pulse>(&slot).addr()), "pulse {index}");
            self.slot = Some(slot);
            missed
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 200 }))]

        /// Whoever reads when, and whatever he misses: no slot is ever needed that is not there, every reader
        /// has its own room, and sees its pulses unchanged and in order.
        #[test]
        fn there_is_a_slot_for_every_pulse(
            readers in prop::collection::vec((1_usize..6, any::<bool>()), 1..5),
            reads in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..8), 1..200),
        ) {
            let mut all = Readers::new(&readers);
            let mut waiting = vec![Vec::new(); readers.len()];
            for (index, (who, count)) in reads.iter().enumerate() {
                let missed = all.release(index as u64);
                for (k, waits) in waiting.iter_mut().enumerate() {
                    prop_assert_eq!(missed.contains(&k), !readers[k].1 && waits.len() == readers[k].0);
                    if readers[k].1 && waits.len() == readers[k].0 {
                        waits.remove(0);
                    }
                    if !missed.contains(&k) {
                        waits.push(index as u64);
                    }
                }
                let k = who.index(readers.len());
                for _ in 0..*count {
                    let expected = (!waiting[k].is_empty()).then(|| waiting[k].remove(0));
                    prop_assert_eq!(all.read(k), expected);
                }
            }
        }
    }

    /// The bound is reached: each of two readers holds pulses that the other has not.
    #[test]
    fn readers_that_miss_pulses_hold_as_many_as_all_have_room_for() {
        let mut all = Readers::new(&[(3, false), (2, false)]);
        for index in 0..8 {
            all.release(index);
            // The second reads while the first is filled, and no more afterwards.
            if index < 4 {
                all.read(1);
            }
        }
        assert_eq!((all.pool.slots(), all.ends[0].0.held, all.ends[1].0.held), (0, 3, 2));
        let left: Vec<_> = [0, 0, 0, 1, 1].map(|k| all.read(k)).into_iter().flatten().collect();
        assert_eq!(left, [0, 1, 2, 4, 5]);
    }

    #[test]
    fn who_is_waited_for_shares() {
        assert_eq!(held_at_most([(100, true), (4000, true), (30, true)]), 4000);
        assert_eq!(held_at_most([(100, true), (40, false), (30, false)]), 170);
        assert_eq!(held_at_most([(usize::MAX, false), (1, false)]), usize::MAX);
    }

    /// A reader that breaks off in the midst of a pulse takes its slot with it, and no other.
    #[test]
    fn a_slot_that_is_lost_is_made_up_for() {
        let mut all = Readers::new(&[(1, false)]);
        all.release(0);
        let broken = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            all.ends[0].1.poll(|_, _, _| panic!("as it should"));
        }));
        assert!(broken.is_err());
        let (mut lane, other) = lane(1);
        assert!(lane.has_room(&mut all.pool));
        let pulse = all.slot.take().unwrap().share();
        lane.send(&pulse, false);
        let next = all.pool.exchange(pulse);
        assert_eq!(next.index, 0);
        drop(other);
        assert!(lane.has_room(&mut all.pool) && lane.is_abandoned());
        assert_eq!(all.pool.slots(), 1);
    }
}
