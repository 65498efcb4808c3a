//! Released pulses for an onlooker whom nobody waits for.
//!
//! A view gets a copy of every pulse that its queue has room for, in real time and at pace `fast`; the others
//! it does not get, and [`Onlooker::not_shown`] counts them. It is no sink: nothing that it does, nor its
//! end, is seen in the stream, and its losses are not the stream's.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use super::health::Health;
use super::ring::{self, Consumer, Polled, Producer};
use crate::pulse::{Layout, Pulse};

/// The stream's end of a view.
#[derive(Debug)]
pub struct View {
    queue: Producer<Pulse>,
    left_out: Arc<AtomicU64>,
    health: Arc<OnceLock<Arc<Health>>>,
}

/// The onlooker's end.
#[derive(Debug)]
pub struct Onlooker {
    queue: Consumer<Pulse>,
    left_out: Arc<AtomicU64>,
    health: Arc<OnceLock<Arc<Health>>>,
}

/// What an onlooker finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// A pulse, which was shown.
    Pulse,
    /// None yet.
    Nothing,
    /// None, and none will come.
    Ended,
}

/// The two ends of a view with a queue of so many pulses.
pub fn view(slots: usize, layout: &Layout) -> (View, Onlooker) {
    let (producer, consumer) = ring::ring((0..slots.max(1)).map(|_| Pulse::new(layout)));
    let (left_out, health) = (Arc::default(), Arc::default());
    (
        View { queue: producer, left_out: Arc::clone(&left_out), health: Arc::clone(&health) },
        Onlooker { queue: consumer, left_out, health },
    )
}

impl View {
    /// Says how the stream counts.
    pub(super) fn open(&self, health: &Arc<Health>) {
        let _ = self.health.set(Arc::clone(health));
    }

    /// Offers a pulse; `false` when the onlooker has gone.
    pub(super) fn offer(&mut self, pulse: &Pulse) -> bool {
        if self.queue.is_abandoned() {
            return false;
        }
        match self.queue.try_reserve() {
            Some(slot) => {
                slot.copy_from(pulse);
                self.queue.commit(1);
            }
            None => {
                self.left_out.fetch_add(1, Ordering::Relaxed);
            }
        }
        true
    }
}

impl Onlooker {
    /// Shows the oldest pulse that waits, if there is one, and how many wait behind it. Does not wait: a
    /// stream that finds nobody asleep need not wake anybody.
    pub fn poll(&mut self, show: impl FnOnce(&Pulse, usize)) -> Seen {
        match self.queue.poll() {
            Polled::Slot(pulse) => {
                show(&pulse, self.queue.filled());
                self.queue.give_back(pulse);
                Seen::Pulse
            }
            Polled::Empty => Seen::Nothing,
            Polled::Ended => Seen::Ended,
        }
    }

    /// Pulses for which the queue had no room.
    pub fn not_shown(&self) -> u64 {
        self.left_out.load(Ordering::Relaxed)
    }

    /// What the stream counts; `None` before it runs.
    pub fn health(&self) -> Option<&Arc<Health>> {
        self.health.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_room_is_left_out_and_an_onlooker_may_go() {
        let layout = Layout { channels: 1, samples: 2, ..Layout::default() };
        let (mut view, mut onlooker) = view(2, &layout);
        let mut pulse = Pulse::new(&layout);
        for index in 0..5 {
            pulse.index = index;
            assert!(view.offer(&pulse));
        }
        let mut seen = Vec::new();
        while onlooker.poll(|pulse, waiting| seen.push((pulse.index, waiting))) == Seen::Pulse {}
        assert_eq!((seen, onlooker.not_shown()), (vec![(0, 1), (1, 0)], 3));
        drop(onlooker);
        assert!(!view.offer(&pulse));
    }

    #[test]
    fn the_end_comes_after_the_last_pulse() {
        let layout = Layout { channels: 1, samples: 2, ..Layout::default() };
        let (mut view, mut onlooker) = view(2, &layout);
        assert_eq!(onlooker.poll(|_, _| {}), Seen::Nothing);
        assert!(view.offer(&Pulse::new(&layout)));
        drop(view);
        assert_eq!((onlooker.poll(|_, _| {}), onlooker.poll(|_, _| {})), (Seen::Pulse, Seen::Ended));
    }
}
