//! Preallocated slots that travel between two threads.
//!
//! A ring of `n` slots is two lock-free queues: `filled` from the producer to the consumer and `free`
//! back. Every slot is allocated once, at construction; afterwards only the slots' addresses move, so neither
//! side allocates, and a slot is never copied. A [`lane`] is the same without slots of its own: it carries
//! what it is [sent](Producer::send), and [back](Producer::take_back).
//!
//! The producer takes a batch of free slots ([`Producer::reserve`]), fills them in any order (in
//! parallel, for example), and commits the batch in one step: the order in the ring is the order in
//! the batch, whoever filled it. Where workers go at their own pace, slots are [taken](Producer::take) and
//! [put](Producer::put) instead, and [`dispatcher`](crate::transport::dispatcher) keeps the order.
//!
//! No core is burnt while an end waits. The consumer is woken by what is committed (without a lock: a flag,
//! and a wake-up where it is set), or looks again after [`DOZE`]: where workers take all cores, looking every
//! 0.15 ms cost them a tenth of their time. The producer sleeps [`NAP`] between two looks for free slots,
//! which are plenty wherever speed matters. When one end is dropped, the other sees it: the consumer gets
//! what was committed and then the end of the stream; the producer gets no more slots.
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use nereus::transport::ring::ring;
//!
//! let (mut producer, mut consumer) = ring((0..4).map(|_| 0_u64));
//! let stop = AtomicBool::new(false);
//! let batch = producer.reserve(3, &stop).unwrap();
//! for (n, slot) in batch.iter_mut().enumerate() {
//!     **slot = n as u64;
//! }
//! producer.commit(3);
//! drop(producer);
//! let mut seen = Vec::new();
//! while let Some(slot) = consumer.wait(&stop) {
//!     seen.push(*slot);
//!     consumer.give_back(slot);
//! }
//! assert_eq!(seen, [0, 1, 2]);
//! ```

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicBool, Ordering, fence};
use std::sync::{Arc, OnceLock};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

/// How long who is not woken sleeps between two looks: a producer, and a pacer whose pulse is overdue.
pub const NAP: Duration = Duration::from_micros(150);
/// How long a consumer sleeps at most between two looks: nothing wakes it at the end of a stream.
pub const DOZE: Duration = Duration::from_millis(5);

/// Wakes the consumer of a ring.
#[derive(Debug, Default)]
pub struct Bell {
    waits: AtomicBool,
    /// The thread that waited first; another one naps.
    sleeper: OnceLock<Thread>,
}

impl Bell {
    /// Sleeps until it rings, or so long; not at all if there is something by now.
    fn wait(&self, at_most: Duration, is_empty: impl FnOnce() -> bool) {
        let current = thread::current();
        if self.sleeper.get_or_init(|| current.clone()).id() != current.id() {
            thread::sleep(at_most.min(NAP));
            return;
        }
        // Either this thread sees what was committed, or the one that committed it sees the flag.
        self.waits.store(true, Ordering::Release);
        fence(Ordering::SeqCst);
        if is_empty() {
            thread::park_timeout(at_most);
        }
        self.waits.store(false, Ordering::Relaxed);
    }

    /// Wakes the consumer if it waits.
    pub fn ring(&self) {
        fence(Ordering::SeqCst);
        if self.waits.load(Ordering::Relaxed)
            && self.waits.swap(false, Ordering::Acquire)
            && let Some(sleeper) = self.sleeper.get()
        {
            sleeper.unpark();
        }
    }
}

/// A place for a `T`. Whoever holds it is alone with it and may write to it; [shared](Self::share), it can be
/// read by several.
#[derive(Debug)]
pub struct Slot<T>(Arc<T>);

impl<T> Slot<T> {
    /// A slot with this content.
    pub fn new(content: T) -> Self {
        Self(Arc::new(content))
    }

    /// Gives up writing to it.
    pub fn share(self) -> Arc<T> {
        self.0
    }

    /// What was shared becomes a slot again where nobody else holds it; otherwise it is let go of.
    pub fn reclaim(mut shared: Arc<T>) -> Option<Self> {
        Arc::get_mut(&mut shared).is_some().then(|| Self(shared))
    }
}

impl<T> Deref for Slot<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Clone> DerefMut for Slot<T> {
    fn deref_mut(&mut self) -> &mut T {
        // A slot is alone with its content, so this never copies; nor could a reader see a change otherwise.
        Arc::make_mut(&mut self.0)
    }
}

/// The end that fills slots, each an `S`.
#[derive(Debug)]
pub struct Producer<S> {
    filled: rtrb::Producer<S>,
    free: rtrb::Consumer<S>,
    /// Slots taken and not yet committed; its capacity is the ring's.
    batch: Vec<S>,
    slots: usize,
    bell: Arc<Bell>,
}

/// The end that empties slots. What it has not emptied when it goes is free.
#[derive(Debug)]
pub struct Consumer<S> {
    filled: rtrb::Consumer<S>,
    free: rtrb::Producer<S>,
    bell: Arc<Bell>,
}

/// What polling a ring finds.
#[derive(Debug)]
pub enum Polled<S> {
    /// The next filled slot.
    Slot(S),
    /// Nothing yet.
    Empty,
    /// Nothing, and nothing will come.
    Ended,
}

/// A ring of slots with these contents, all free.
pub fn ring<T>(contents: impl IntoIterator<Item = T>) -> (Producer<Slot<T>>, Consumer<Slot<T>>) {
    let filled: Vec<Slot<T>> = contents.into_iter().map(Slot::new).collect();
    let (producer, mut consumer) = lane(filled.len());
    filled.into_iter().for_each(|slot| consumer.give_back(slot));
    (producer, consumer)
}

/// A ring for so many slots, which has none of its own.
pub fn lane<S>(slots: usize) -> (Producer<S>, Consumer<S>) {
    let (filled_in, filled_out) = rtrb::RingBuffer::new(slots);
    let (free_in, free_out) = rtrb::RingBuffer::new(slots);
    let bell = Arc::new(Bell::default());
    let batch = Vec::with_capacity(slots);
    (
        Producer { filled: filled_in, free: free_out, batch, slots, bell: Arc::clone(&bell) },
        Consumer { filled: filled_out, free: free_in, bell },
    )
}

impl<S> Producer<S> {
    /// Number of slots of the ring.
    pub fn slots(&self) -> usize {
        self.slots
    }

    /// Filled slots that wait for the consumer.
    pub fn filled(&self) -> usize {
        self.slots - self.filled.slots()
    }

    /// Whether the consumer is gone.
    pub fn is_abandoned(&self) -> bool {
        self.filled.is_abandoned()
    }

    /// Waits until `n` slots (at most all of the ring) are free and returns them, to be filled and then
    /// [committed](Self::commit). `None` when the consumer is gone or `stop` is set.
    pub fn reserve(&mut self, n: usize, stop: &AtomicBool) -> Option<&mut [S]> {
        let n = n.min(self.slots);
        loop {
            if self.is_abandoned() || stop.load(Ordering::Acquire) {
                return None;
            }
            if self.gather(n) {
                return Some(&mut self.batch[..n]);
            }
            thread::sleep(NAP);
        }
    }

    fn gather(&mut self, n: usize) -> bool {
        let missing = n.saturating_sub(self.batch.len());
        if missing > 0
            && let Ok(chunk) = self.free.read_chunk(missing)
        {
            self.batch.extend(chunk);
        }
        self.batch.len() >= n
    }

    /// Moves `n` free slots (at most all of the ring) to an empty list if there are as many now.
    pub fn take(&mut self, n: usize, slots: &mut Vec<S>) -> bool {
        let n = n.min(self.slots);
        let there = self.gather(n);
        if there {
            slots.extend(self.batch.drain(..n));
        }
        there
    }

    /// What wakes the consumer after a [`put`](Self::put).
    pub fn bell(&self) -> Arc<Bell> {
        Arc::clone(&self.bell)
    }

    /// Hands over slots that were [taken](Self::take), in order and in one step. It does not wake the
    /// consumer, so that it may be called with a lock held: the [bell](Self::bell) does.
    pub fn put(&mut self, slots: &mut Vec<S>) {
        // Room for every slot that exists.
        if let Ok(chunk) = self.filled.write_chunk_uninit(slots.len()) {
            chunk.fill_from_iter(slots.drain(..));
        }
    }

    /// Hands over a slot that did not come from this ring, which is to have room for it.
    pub fn send(&mut self, slot: S) {
        // What has no room is let go of, as if it had never been sent.
        let _ = self.filled.push(slot);
        self.bell.ring();
    }

    /// A slot that the consumer has given back.
    pub fn take_back(&mut self) -> Option<S> {
        self.free.pop().ok()
    }

    /// Hands the first `n` reserved slots to the consumer, in order and in one step.
    pub fn commit(&mut self, n: usize) {
        let n = n.min(self.batch.len());
        // The filled queue has room for every slot that exists, so this never fails.
        if let Ok(chunk) = self.filled.write_chunk_uninit(n) {
            chunk.fill_from_iter(self.batch.drain(..n));
        }
        self.bell.ring();
    }
}

impl<S> Consumer<S> {
    /// Filled slots that wait.
    pub fn filled(&self) -> usize {
        self.filled.slots()
    }

    /// Polls once.
    pub fn poll(&mut self) -> Polled<S> {
        // Asked before the pop: what was committed before the producer went is still delivered.
        let ended = self.filled.is_abandoned();
        match self.filled.pop() {
            Ok(slot) => Polled::Slot(slot),
            Err(_) if ended => Polled::Ended,
            Err(_) => Polled::Empty,
        }
    }

    /// Waits for the next slot. `None` at the end of the stream or when `stop` is set.
    pub fn wait(&mut self, stop: &AtomicBool) -> Option<S> {
        loop {
            match self.poll() {
                Polled::Slot(slot) => return Some(slot),
                Polled::Ended => return None,
                Polled::Empty if stop.load(Ordering::Acquire) => return None,
                Polled::Empty => self.doze(DOZE),
            }
        }
    }

    /// Sleeps until something is committed, but not longer than so, nor than [`DOZE`].
    pub fn doze(&self, at_most: Duration) {
        self.bell.wait(at_most.min(DOZE), || self.filled.slots() == 0);
    }

    /// Waits for the next slot for at most `timeout`.
    pub fn wait_for(&mut self, timeout: Duration) -> Polled<S> {
        let begun = Instant::now();
        loop {
            let found = self.poll();
            let left = timeout.saturating_sub(begun.elapsed());
            if !matches!(found, Polled::Empty) || left.is_zero() {
                return found;
            }
            self.doze(left);
        }
    }

    /// Returns a slot to the producer.
    pub fn give_back(&mut self, slot: S) {
        // Room for every slot that exists; a slot that is not of this ring is simply freed.
        let _ = self.free.push(slot);
    }
}

impl<S> Drop for Consumer<S> {
    fn drop(&mut self) {
        while let Ok(slot) = self.filled.pop() {
            self.give_back(slot);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_batch_keeps_its_order_and_slots_come_back() {
        let (mut producer, mut consumer) = ring((0..5).map(|_| 0_u32));
        let go = AtomicBool::new(false);
        let mut expected = 0;
        for round in 0..100_u32 {
            let batch = producer.reserve(3, &go).unwrap();
            for (k, slot) in batch.iter_mut().enumerate().rev() {
                **slot = round * 3 + k as u32;
            }
            producer.commit(3);
            for _ in 0..3 {
                let slot = consumer.wait(&go).unwrap();
                assert_eq!(*slot, expected);
                expected += 1;
                consumer.give_back(slot);
            }
        }
    }

    #[test]
    fn what_is_committed_wakes_who_waits() {
        let (mut producer, mut consumer) = ring((0..2).map(|_| 0_u32));
        let timeout = Duration::from_secs(60);
        thread::scope(|scope| {
            let waits = scope.spawn(move || {
                let begun = Instant::now();
                // Never longer than that however often it is woken for nothing.
                while matches!(consumer.poll(), Polled::Empty) && begun.elapsed() < timeout {
                    consumer.bell.wait(timeout, || consumer.filled.slots() == 0);
                }
                begun.elapsed()
            });
            thread::sleep(Duration::from_millis(20));
            producer.reserve(1, &AtomicBool::new(false)).unwrap();
            producer.commit(1);
            let waited = waits.join().unwrap();
            assert!(waited < timeout / 2, "{waited:?}");
        });
    }

    #[test]
    fn the_end_passes_through_both_ways() {
        let (mut producer, consumer) = ring((0..2).map(|_| 0_u32));
        drop(consumer);
        assert!(producer.reserve(1, &AtomicBool::new(false)).is_none());
        let (producer, mut consumer) = ring((0..2).map(|_| 0_u32));
        drop(producer);
        assert!(matches!(consumer.poll(), Polled::Ended));
    }

    /// The last of those who hold what was shared gets the slot, not a copy.
    #[test]
    fn a_shared_slot_is_whole_again_when_nobody_else_holds_it() {
        let slot = Slot::new([7; 3]);
        let (place, mine) = (std::ptr::from_ref(&*slot), slot.share());
        let other = Arc::clone(&mine);
        assert!(Slot::reclaim(mine).is_none());
        let mut whole = Slot::reclaim(other).unwrap();
        whole[0] = 8;
        assert_eq!((*whole, std::ptr::from_ref(&*whole)), ([8, 7, 7], place));
    }

    #[test]
    fn what_a_consumer_leaves_behind_comes_back() {
        let (mut producer, consumer) = lane(2);
        producer.send(1);
        producer.send(2);
        assert_eq!(producer.take_back(), None);
        drop(consumer);
        assert_eq!([(); 3].map(|()| producer.take_back()), [Some(1), Some(2), None]);
        assert!(producer.is_abandoned());
    }

    #[test]
    fn more_than_the_ring_holds_is_the_whole_ring() {
        let (mut producer, _consumer) = ring((0..2).map(|_| 0_u32));
        assert_eq!(producer.reserve(10, &AtomicBool::new(false)).unwrap().len(), 2);
    }
}
