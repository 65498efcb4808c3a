//! Released pulses for an onlooker whom nobody waits for.
//!
//! A view shares every pulse that its queue has room for, in real time and at pace `fast`; the others
//! it does not get, and [`Onlooker::not_shown`] counts them. It is no sink: nothing that it does, nor its
//! end, is seen in the stream, and its losses are not the stream's.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use super::health::Health;
use super::pool::{self, Lane, Pool, Reader};
use super::ring::Polled;
use crate::pulse::Pulse;

/// The stream's end of a view.
#[derive(Debug)]
pub struct View {
    lane: Lane,
    left_out: Arc<AtomicU64>,
    health: Arc<OnceLock<Arc<Health>>>,
}

/// The onlooker's end.
#[derive(Debug)]
pub struct Onlooker {
    reader: Reader,
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
pub fn view(slots: usize) -> (View, Onlooker) {
    let (lane, reader) = pool::lane(slots.max(1));
    let (left_out, health) = (Arc::default(), Arc::default());
    (
        View { lane, left_out: Arc::clone(&left_out), health: Arc::clone(&health) },
        Onlooker { reader, left_out, health },
    )
}

impl View {
    /// Says how the stream counts.
    pub(super) fn open(&self, health: &Arc<Health>) {
        let _ = self.health.set(Arc::clone(health));
    }

    /// Pulses that the onlooker may have.
    pub(super) fn slots(&self) -> usize {
        self.lane.slots()
    }

    /// Offers a pulse; `false` when the onlooker has gone.
    pub(super) fn offer(&mut self, pulse: &Arc<Pulse>, pool: &mut Pool) -> bool {
        let gone = self.lane.is_abandoned();
        // What it left behind comes back even then.
        let room = self.lane.has_room(pool);
        if gone {
            return false;
        }
        if room {
            self.lane.send(pulse, false);
        } else {
            self.left_out.fetch_add(1, Ordering::Relaxed);
        }
        true
    }
}

impl Onlooker {
    /// Shows the oldest pulse that waits, if there is one, and how many wait behind it. Does not wait: a
    /// stream that finds nobody asleep need not wake anybody.
    pub fn poll(&mut self, show: impl FnOnce(&Pulse, usize)) -> Seen {
        match self.reader.poll(|pulse, waiting, _| show(pulse, waiting)) {
            Polled::Slot(()) => Seen::Pulse,
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
    use crate::transport::pacer::tests::LAYOUT;
    use crate::transport::ring::Slot;

    #[test]
    fn what_has_no_room_is_left_out_and_an_onlooker_may_go() {
        let mut pool = Pool::new(2, &LAYOUT);
        let (mut view, mut onlooker) = view(2);
        let mut slot = Slot::new(Pulse::new(&LAYOUT));
        for index in 0..5 {
            slot.index = index;
            let pulse = slot.share();
            assert!(view.offer(&pulse, &mut pool));
            slot = pool.exchange(pulse);
        }
        let mut seen = Vec::new();
        while onlooker.poll(|pulse, waiting| seen.push((pulse.index, waiting))) == Seen::Pulse {}
        assert_eq!((seen, onlooker.not_shown()), (vec![(0, 1), (1, 0)], 3));
        drop(onlooker);
        assert!(!view.offer(&slot.share(), &mut pool));
        assert_eq!(pool.slots(), 2);
    }

    #[test]
    fn the_end_comes_after_the_last_pulse() {
        let (mut view, mut onlooker) = view(2);
        assert_eq!(onlooker.poll(|_, _| {}), Seen::Nothing);
        assert!(view.offer(&Arc::new(Pulse::new(&LAYOUT)), &mut Pool::new(0, &LAYOUT)));
        drop(view);
        assert_eq!((onlooker.poll(|_, _| {}), onlooker.poll(|_, _| {})), (Seen::Pulse, Seen::Ended));
    }
}
