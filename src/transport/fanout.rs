//! From the pacer to every sink, each through a ring of its own.
//!
//! In real time a full queue means that the pulse is missed *by that sink*: counted, and the next
//! pulse that the sink gets carries `AFTER_GAP`. The others are not held up. At pace `fast` a full
//! queue holds up the pacer, and through the main ring the generation: nothing is lost. In real time the
//! pacer asks for the same with [`FanOut::make_room`], for sinks that are to get every pulse.
//!
//! A sink that is gone ends the run, unless it may fail: then the others go on without it.
//!
//! The last outlet gets the slot itself in exchange for a free one of its own, the others a copy; with
//! one sink nothing is copied. A [`View`] gets a copy before them, if it has room.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::pulse::{Layout, Pulse, flags};

use super::health::SinkHealth;
use super::ring::{self, Consumer, NAP, Polled, Producer};
use super::view::View;
use super::{Pace, StreamError};

/// The way to one sink.
#[derive(Debug)]
pub struct Outlet {
    queue: Producer<Pulse>,
    gap: bool,
    role: Role,
    health: Arc<SinkHealth>,
}

/// What a sink is to the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Role {
    /// Whether it is to get every pulse: the pacer waits for it where its policy allows that.
    pub lossless: bool,
    /// Whether the run goes on without it when it fails.
    pub may_fail: bool,
}

/// What a sink's thread reads from.
#[derive(Debug)]
pub struct Feed {
    queue: Consumer<Pulse>,
    health: Arc<SinkHealth>,
}

/// What a feed gives.
#[derive(Debug)]
pub enum Fed<R> {
    /// A pulse came and was handled with this result.
    Pulse(R),
    /// No pulse came in the time allowed.
    Idle,
    /// The stream has ended.
    Ended,
}

/// All outlets.
#[derive(Debug)]
pub struct FanOut {
    outlets: Vec<Outlet>,
    pace: Pace,
    view: Option<View>,
}

/// A queue of `slots` pulses for a sink.
///
/// # Errors
/// A queue without slots.
pub fn outlet(name: &str, slots: usize, role: Role, layout: &Layout) -> Result<(Outlet, Feed), StreamError> {
    if slots == 0 {
        return Err(StreamError::EmptyQueue { sink: name.to_owned() });
    }
    let (producer, consumer) = ring::ring((0..slots).map(|_| Pulse::new(layout)));
    let health = Arc::new(SinkHealth::new(name, slots, role.lossless));
    Ok((
        Outlet { queue: producer, gap: false, role, health: Arc::clone(&health) },
        Feed { queue: consumer, health },
    ))
}

impl Outlet {
    pub(crate) fn health(&self) -> Arc<SinkHealth> {
        Arc::clone(&self.health)
    }

    /// Whether a pulse has to wait until this sink has room for it.
    fn is_short(&mut self) -> bool {
        self.role.lossless && !self.queue.is_abandoned() && self.queue.try_reserve().is_none()
    }
}

impl Feed {
    /// Corrects the count of pulses written: a sink that failed knows how many can be read.
    pub fn wrote_in_all(&self, pulses: u64) {
        self.health.wrote_in_all(pulses);
    }

    /// Waits up to `timeout` for a pulse and hands it to `take`; the slot goes back afterwards.
    ///
    /// # Errors
    /// That of `take`.
    pub fn next<R, E>(
        &mut self,
        timeout: Duration,
        take: impl FnOnce(&Pulse) -> Result<R, E>,
    ) -> Result<Fed<R>, E> {
        self.next_slot(timeout, |pulse| take(pulse))
    }

    /// The same for somebody who may keep the pulse, and leave another of the same layout in its place.
    pub fn next_slot<R, E>(
        &mut self,
        timeout: Duration,
        take: impl FnOnce(&mut Pulse) -> Result<R, E>,
    ) -> Result<Fed<R>, E> {
        match self.queue.wait_for(timeout) {
            Polled::Slot(mut pulse) => {
                let taken = take(&mut pulse);
                self.queue.give_back(pulse);
                if taken.is_ok() {
                    self.health.wrote();
                }
                taken.map(Fed::Pulse)
            }
            Polled::Empty => Ok(Fed::Idle),
            Polled::Ended => Ok(Fed::Ended),
        }
    }
}

impl FanOut {
    /// Over these outlets.
    pub fn new(outlets: Vec<Outlet>, pace: Pace) -> Self {
        Self { outlets, pace, view: None }
    }

    /// Lets an onlooker see what is sent.
    pub fn with_view(self, view: Option<View>) -> Self {
        Self { view, ..self }
    }

    /// Waits until every sink that is to get all pulses has room for one, but not after `until`, nor once
    /// `stop` is set. Returns whether it had to wait.
    pub fn make_room(&mut self, until: Instant, stop: &AtomicBool) -> bool {
        let mut waited = false;
        while self.outlets.iter_mut().any(Outlet::is_short) {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || stop.load(Ordering::Acquire) {
                break;
            }
            waited = true;
            thread::sleep(left.min(NAP));
        }
        waited
    }

    /// Hands a pulse to every sink; the slot that comes back is free (its content is of no use).
    /// `None` when a sink is gone that may not fail, or all are: they failed, or have had enough; the run
    /// ends then.
    pub fn send(&mut self, mut pulse: Box<Pulse>) -> Option<Box<Pulse>> {
        // Sinks always empty their queues, so a stop need not cut this wait short.
        static NEVER: AtomicBool = AtomicBool::new(false);
        if self.view.as_mut().is_some_and(|view| !view.offer(&pulse)) {
            self.view = None;
        }
        let last = self.outlets.len().checked_sub(1);
        let mut gone = last.is_some();
        for (k, outlet) in self.outlets.iter_mut().enumerate() {
            if outlet.queue.is_abandoned() {
                if !outlet.role.may_fail {
                    return None;
                }
                outlet.health.missed();
                continue;
            }
            gone = false;
            let slot = match self.pace {
                Pace::Realtime => outlet.queue.try_reserve(),
                Pace::Fast => outlet.queue.reserve(1, &NEVER).and_then(|slots| slots.first_mut()),
            };
            let Some(slot) = slot else {
                if self.pace == Pace::Fast && !outlet.role.may_fail {
                    return None;
                }
                outlet.gap = true;
                outlet.health.missed();
                continue;
            };
            if Some(k) == last {
                std::mem::swap(slot, &mut pulse);
            } else {
                slot.copy_from(&pulse);
            }
            if std::mem::take(&mut outlet.gap) {
                slot.flags |= flags::AFTER_GAP;
            }
            outlet.queue.commit(1);
            outlet.health.queue_level(outlet.queue.filled());
        }
        (!gone).then_some(pulse)
    }
}
