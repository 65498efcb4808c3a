//! Several workers fill one ring, each at its own pace.
//!
//! A worker **claims** the next pulses with as many free slots, fills them, and **delivers** them. Claims are
//! handed out in order and slots reach the ring in that order, whoever is ready first: what comes early waits
//! until all before it is there. No worker waits for another, only for free slots. All bookkeeping is behind
//! one lock that is held for as long as addresses move; in steady state nothing is allocated.
//!
//! What must not change under a pulse is changed *between* claims: [`Dispatcher::between`] is asked with the
//! first pulse that nobody has begun, while nobody can claim it.
//!
//! Generation is *at work* as long as its workers are: its time is the mean of theirs, without their waits
//! for slots.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::pulse::Pulse;

use super::health::Health;
use super::pacer::Worth;
use super::ring::{Bell, NAP, Producer, Slot};

/// Workers of a stream.
pub struct Dispatcher<'a> {
    held: Mutex<Held<'a>>,
    bell: Arc<Bell>,
    workers: u32,
    /// Pulses from here on are nobody's.
    end: u64,
    worth: &'a Worth,
    stop: &'a AtomicBool,
    gone: AtomicBool,
    health: &'a Health,
    between: Option<&'a (dyn Fn(u64) + Sync)>,
    started: Instant,
}

struct Held<'a> {
    ring: &'a mut Producer<Slot<Pulse>>,
    /// The first pulse that nobody has claimed.
    next: u64,
    /// Slots claimed so far, and those that have reached the ring.
    claimed: u64,
    put: u64,
    /// Delivered before their turn: slot `n` at `n` modulo the ring's length.
    early: Vec<Option<Slot<Pulse>>>,
    /// Emptied lists, to be filled again: one for each worker.
    spare: Vec<Vec<Slot<Pulse>>>,
    /// Time of all workers that has been counted.
    counted: Duration,
    waited: Duration,
}

/// Pulses that a worker makes, and slots for them.
#[derive(Debug)]
pub struct Claim {
    /// The first pulse; the others follow it.
    pub first: u64,
    /// A slot for each, to be [fitted](Pulse::fit). It may hold some earlier pulse: every field, `flags` too,
    /// is to be overwritten.
    pub slots: Vec<Slot<Pulse>>,
    /// Slots claimed before.
    before: u64,
    since: Instant,
}

/// Calls a dispatcher off when its thread panics.
pub struct Watch<'a>(&'a AtomicBool);

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.store(true, Ordering::Release);
        }
    }
}

impl<'a> Dispatcher<'a> {
    pub(super) fn new(
        ring: &'a mut Producer<Slot<Pulse>>,
        pulses: Range<u64>,
        workers: usize,
        worth: &'a Worth,
        stop: &'a AtomicBool,
        health: &'a Health,
    ) -> Self {
        let (slots, bell) = (ring.slots(), ring.bell());
        let held = Held {
            ring,
            next: pulses.start,
            claimed: 0,
            put: 0,
            early: (0..slots).map(|_| None).collect(),
            spare: (0..workers).map(|_| Vec::with_capacity(slots)).collect(),
            counted: Duration::ZERO,
            waited: Duration::ZERO,
        };
        Self {
            held: Mutex::new(held),
            bell,
            workers: u32::try_from(workers.max(1)).unwrap_or(u32::MAX),
            end: pulses.end,
            worth,
            stop,
            gone: AtomicBool::new(false),
            health,
            between: None,
            started: Instant::now(),
        }
    }

    /// Calls something before every claim, and while slots are waited for, with the first pulse that nobody
    /// has begun. It must be short: meanwhile no worker claims or delivers.
    pub fn between(mut self, between: &'a (dyn Fn(u64) + Sync)) -> Self {
        self.between = Some(between);
        self
    }

    fn lock(&self) -> MutexGuard<'_, Held<'a>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for slots and takes the next pulses worth making: those from the given one on to the one that
    /// `until` gives (later than it; never more than the ring has slots). `None` when all are claimed or the
    /// run is over.
    pub fn claim(&self, until: impl Fn(u64) -> u64) -> Option<Claim> {
        let since = Instant::now();
        loop {
            let mut held = self.lock();
            let first = held.next.max(self.worth.next());
            if let Some(between) = self.between {
                between(first.min(self.end));
            }
            let over = self.stop.load(Ordering::Acquire) || self.gone.load(Ordering::Acquire);
            if over || held.ring.is_abandoned() || first >= self.end {
                held.waited += since.elapsed();
                return None;
            }
            let wanted = until(first).clamp(first + 1, self.end) - first;
            let count = usize::try_from(wanted).unwrap_or(usize::MAX).min(held.ring.slots());
            let mut slots = held.spare.pop().unwrap_or_default();
            if held.ring.take(count, &mut slots) {
                let now = Instant::now();
                held.waited += now - since;
                held.next = first + count as u64;
                let before = held.claimed;
                held.claimed += count as u64;
                return Some(Claim { first, slots, before, since: now });
            }
            held.spare.push(slots);
            drop(held);
            thread::sleep(NAP);
        }
    }

    /// Hands over what was claimed.
    pub fn deliver(&self, claim: Claim) {
        let Claim { mut slots, before, since, .. } = claim;
        let spent = since.elapsed();
        let mut held = self.lock();
        held.counted += spent;
        self.health.made(slots.len() as u64, spent / self.workers);
        let Held { early, put, ring, spare, .. } = &mut *held;
        if before == *put {
            *put += slots.len() as u64;
            ring.put(&mut slots);
        } else {
            for (slot, place) in slots.drain(..).zip(before..) {
                let place = place as usize % early.len();
                early[place] = Some(slot);
            }
        }
        // What was early and is due now.
        loop {
            let place = *put as usize % early.len();
            let Some(slot) = early[place].take() else { break };
            slots.push(slot);
            *put += 1;
        }
        ring.put(&mut slots);
        spare.push(slots);
        drop(held);
        // Who is woken may take this core at once: no other worker is to wait for the lock meanwhile.
        self.bell.ring();
    }

    /// Calls all workers off if the thread panics while it holds what is returned.
    pub fn watch(&self) -> Watch<'_> {
        Watch(&self.gone)
    }

    /// Calls all workers off: one of them has failed.
    pub fn call_off(&self) {
        self.gone.store(true, Ordering::Release);
    }
}

impl Drop for Dispatcher<'_> {
    /// Who had nothing more to do while others were still at work has worked as well: the pulses took that
    /// long.
    fn drop(&mut self) {
        let whole = self.started.elapsed() * self.workers;
        let held = self.held.get_mut().unwrap_or_else(PoisonError::into_inner);
        let idle = whole.saturating_sub(held.counted).saturating_sub(held.waited);
        self.health.made(0, idle / self.workers);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;
    use crate::transport::pacer::tests::LAYOUT;
    use crate::transport::ring::ring;

    #[test]
    fn order_is_that_of_the_claims_whoever_is_first() {
        let (mut producer, mut consumer) = ring((0..13).map(|_| Pulse::new(&LAYOUT)));
        let (worth, stop, health) = (Worth::default(), AtomicBool::new(false), Health::new(Vec::new(), 0));
        let pulses = 5..1005;
        let (crew_stop, end) = (&stop, pulses.end);
        thread::scope(|scope| {
            let seen = scope.spawn(move || {
                let mut seen = Vec::new();
                while let Some(slot) = consumer.wait(crew_stop) {
                    seen.push(slot.index);
                    consumer.give_back(slot);
                }
                seen
            });
            let dispatcher = Dispatcher::new(&mut producer, 5..end, 3, &worth, &stop, &health);
            thread::scope(|scope| {
                for worker in 0..3u64 {
                    let dispatcher = &dispatcher;
                    scope.spawn(move || {
                        while let Some(mut claim) = dispatcher.claim(|first| first / 4 * 4 + 4) {
                            // One worker is slow: others deliver before it.
                            if worker == 0 {
                                thread::sleep(Duration::from_micros(300));
                            }
                            for (slot, index) in claim.slots.iter_mut().zip(claim.first..) {
                                slot.index = index;
                            }
                            dispatcher.deliver(claim);
                        }
                    });
                }
            });
            drop(dispatcher);
            drop(producer);
            assert_eq!(seen.join().unwrap(), pulses.collect::<Vec<_>>());
        });
        assert_eq!(health.made_pulses(), 1000);
    }

    #[test]
    fn a_panic_calls_the_others_off() {
        let (mut producer, _consumer) = ring((0..4).map(|_| Pulse::new(&LAYOUT)));
        let (worth, stop, health) = (Worth::default(), AtomicBool::new(false), Health::new(Vec::new(), 0));
        let dispatcher = Dispatcher::new(&mut producer, 0..10, 2, &worth, &stop, &health);
        let (taken, all_taken) = mpsc::channel();
        let ended = thread::scope(|scope| {
            let dispatcher = &dispatcher;
            let fails = scope.spawn(move || {
                let _watch = dispatcher.watch();
                let _claim = dispatcher.claim(|first| first + 4).unwrap();
                taken.send(()).unwrap();
                panic!("as it should");
            });
            // All slots are with the other: this would wait for ever.
            let waits = scope.spawn(move || {
                all_taken.recv().unwrap();
                dispatcher.claim(|first| first + 4).is_none()
            });
            (fails.join().is_err(), waits.join().unwrap())
        });
        assert_eq!(ended, (true, true));
    }

    #[test]
    fn nobody_claims_once_called_off() {
        let (mut producer, _consumer) = ring((0..4).map(|_| Pulse::new(&LAYOUT)));
        let (worth, stop, health) = (Worth::default(), AtomicBool::new(false), Health::new(Vec::new(), 0));
        let dispatcher = Dispatcher::new(&mut producer, 0..10, 1, &worth, &stop, &health);
        // Never more than the ring has, however much is asked.
        let claim = dispatcher.claim(|first| first + 100).unwrap();
        assert_eq!((claim.first, claim.slots.len()), (0, 4));
        dispatcher.call_off();
        assert!(dispatcher.claim(|first| first + 1).is_none());
    }
}
