//! Preallocated slots that travel between two threads.
//!
//! A ring of `n` slots is two lock-free queues: `filled` from the producer to the consumer and `free`
//! back. Every slot is a box that is allocated once, at construction; afterwards only the boxes'
//! addresses move, so neither side allocates, and a slot is never copied.
//!
//! The producer takes a batch of free slots ([`Producer::reserve`]), fills them in any order (in
//! parallel, for example), and commits the batch in one step: the order in the ring is the order in
//! the batch, whoever filled it. Where workers go at their own pace, slots are [taken](Producer::take) and
//! [put](Producer::put) instead, and [`crew`](super::crew) keeps the order.
//!
//! Waiting is by sleeping [`NAP`] (no core is burnt). When one end is dropped, the other sees it: the
//! consumer gets what was committed and then the end of the stream; the producer gets no more slots.
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

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// How long a waiting end sleeps between two looks.
pub const NAP: Duration = Duration::from_micros(150);

/// The end that fills slots.
#[derive(Debug)]
pub struct Producer<T> {
    filled: rtrb::Producer<Box<T>>,
    free: rtrb::Consumer<Box<T>>,
    /// Slots taken and not yet committed; its capacity is the ring's.
    batch: Vec<Box<T>>,
    slots: usize,
}

/// The end that empties slots.
#[derive(Debug)]
pub struct Consumer<T> {
    filled: rtrb::Consumer<Box<T>>,
    free: rtrb::Producer<Box<T>>,
}

/// What a look into a ring finds.
#[derive(Debug)]
pub enum Look<T> {
    /// The next filled slot.
    Slot(Box<T>),
    /// Nothing yet.
    Empty,
    /// Nothing, and nothing will come.
    Ended,
}

/// A ring that holds the given slots, all free.
pub fn ring<T>(slots: impl IntoIterator<Item = T>) -> (Producer<T>, Consumer<T>) {
    let boxes: Vec<Box<T>> = slots.into_iter().map(Box::new).collect();
    let slots = boxes.len();
    let (filled_in, filled_out) = rtrb::RingBuffer::new(slots);
    let (mut free_in, free_out) = rtrb::RingBuffer::new(slots);
    if let Ok(chunk) = free_in.write_chunk_uninit(slots) {
        chunk.fill_from_iter(boxes);
    }
    (
        Producer { filled: filled_in, free: free_out, batch: Vec::with_capacity(slots), slots },
        Consumer { filled: filled_out, free: free_in },
    )
}

impl<T> Producer<T> {
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
    pub fn reserve(&mut self, n: usize, stop: &AtomicBool) -> Option<&mut [Box<T>]> {
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

    /// One free slot if there is one now; it is handed over by [`commit`](Self::commit)`(1)`.
    pub fn try_reserve(&mut self) -> Option<&mut Box<T>> {
        if self.gather(1) { self.batch.first_mut() } else { None }
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
    pub fn take(&mut self, n: usize, slots: &mut Vec<Box<T>>) -> bool {
        let n = n.min(self.slots);
        let there = self.gather(n);
        if there {
            slots.extend(self.batch.drain(..n));
        }
        there
    }

    /// Hands over slots that were [taken](Self::take), in order and in one step.
    pub fn put(&mut self, slots: &mut Vec<Box<T>>) {
        // Room for every slot that exists.
        if let Ok(chunk) = self.filled.write_chunk_uninit(slots.len()) {
            chunk.fill_from_iter(slots.drain(..));
        }
    }

    /// Hands the first `n` reserved slots to the consumer, in order and in one step.
    pub fn commit(&mut self, n: usize) {
        let n = n.min(self.batch.len());
        // The filled queue has room for every slot that exists, so this never fails.
        if let Ok(chunk) = self.filled.write_chunk_uninit(n) {
            chunk.fill_from_iter(self.batch.drain(..n));
        }
    }
}

impl<T> Consumer<T> {
    /// Filled slots that wait.
    pub fn filled(&self) -> usize {
        self.filled.slots()
    }

    /// Looks once.
    pub fn look(&mut self) -> Look<T> {
        // Asked before the pop: what was committed before the producer went is still delivered.
        let ended = self.filled.is_abandoned();
        match self.filled.pop() {
            Ok(slot) => Look::Slot(slot),
            Err(_) if ended => Look::Ended,
            Err(_) => Look::Empty,
        }
    }

    /// Waits for the next slot. `None` at the end of the stream or when `stop` is set.
    pub fn wait(&mut self, stop: &AtomicBool) -> Option<Box<T>> {
        loop {
            match self.look() {
                Look::Slot(slot) => return Some(slot),
                Look::Ended => return None,
                Look::Empty if stop.load(Ordering::Acquire) => return None,
                Look::Empty => thread::sleep(NAP),
            }
        }
    }

    /// Waits for the next slot for at most `patience`.
    pub fn wait_for(&mut self, patience: Duration) -> Look<T> {
        let begun = Instant::now();
        loop {
            match self.look() {
                Look::Empty if begun.elapsed() < patience => thread::sleep(NAP),
                found => return found,
            }
        }
    }

    /// Returns a slot to the producer.
    pub fn give_back(&mut self, slot: Box<T>) {
        // Room for every slot that exists; a slot that is not of this ring is simply freed.
        let _ = self.free.push(slot);
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
    fn the_end_passes_through_both_ways() {
        let (mut producer, consumer) = ring((0..2).map(|_| 0_u32));
        drop(consumer);
        assert!(producer.reserve(1, &AtomicBool::new(false)).is_none());
        let (producer, mut consumer) = ring((0..2).map(|_| 0_u32));
        drop(producer);
        assert!(matches!(consumer.look(), Look::Ended));
    }

    #[test]
    fn more_than_the_ring_holds_is_the_whole_ring() {
        let (mut producer, _consumer) = ring((0..2).map(|_| 0_u32));
        assert_eq!(producer.reserve(10, &AtomicBool::new(false)).unwrap().len(), 2);
    }
}
