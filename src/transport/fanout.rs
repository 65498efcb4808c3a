//! From the pacer to every sink, each through a queue of its own.
//!
//! In real time a full queue means that the pulse is missed *by that sink*: counted, and the next
//! pulse that the sink gets carries `AFTER_GAP`. The others are not held up. At pace `fast` a full
//! queue holds up the pacer, and through the main ring the generation: nothing is lost. In real time the
//! pacer asks for the same with [`FanOut::make_room`], for sinks that are to get every pulse.
//!
//! A sink that is gone ends the run, unless it may fail: then the others go on without it.
//!
//! Nothing is copied: sinks, and a [`View`], share the pulse in its slot, see [`pool`](super::pool). Only a
//! sink that missed pulses before one gets a copy of that one, made by itself, with a flag that says so.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::pulse::{Layout, Pulse, flags};

use super::health::SinkHealth;
use super::pool::{self, Lane, Pool, Reader};
use super::ring::{NAP, Polled, Slot};
use super::view::View;
use super::{Pace, Policy, Settings, StreamError};

/// The way to one sink.
#[derive(Debug)]
pub struct Outlet {
    lane: Lane,
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
    reader: Reader,
    /// For a pulse of which this sink alone is to know that it comes after a gap.
    marked: Pulse,
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
    pool: Pool,
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
    let (lane, reader) = pool::lane(slots);
    let health = Arc::new(SinkHealth::new(name, slots, role.lossless));
    Ok((
        Outlet { lane, gap: false, role, health: Arc::clone(&health) },
        Feed { reader, marked: Pulse::reserved(layout), health },
    ))
}

/// Distinct pulses that sinks hold at most, given how many may wait for each.
pub fn held_at_most(settings: &Settings, sinks: impl IntoIterator<Item = (usize, Role)>) -> usize {
    let fast = settings.pace == Pace::Fast;
    let slip = settings.policy == Policy::Slip;
    pool::held_at_most(sinks.into_iter().map(|(slots, role)| (slots, fast || (slip && role.lossless))))
}

impl Outlet {
    pub(crate) fn health(&self) -> Arc<SinkHealth> {
        Arc::clone(&self.health)
    }

    /// Whether a pulse has to wait until this sink has room for it.
    fn is_short(&mut self, pool: &mut Pool) -> bool {
        self.role.lossless && !self.lane.is_abandoned() && !self.lane.has_room(pool)
    }

    /// Waits until this sink has room; `false` when it has gone. Sinks always empty their queues, so that a
    /// stop need not cut this wait short.
    fn await_room(&mut self, pool: &mut Pool) -> bool {
        loop {
            if self.lane.is_abandoned() {
                return false;
            }
            if self.lane.has_room(pool) {
                return true;
            }
            thread::sleep(NAP);
        }
    }
}

impl Feed {
    /// Corrects the count of pulses written: a sink that failed knows how many can be read.
    pub fn wrote_in_all(&self, pulses: u64) {
        self.health.wrote_in_all(pulses);
    }

    /// Waits up to `timeout` for a pulse and hands it to `take`; it goes back afterwards.
    ///
    /// # Errors
    /// That of `take`.
    pub fn next<R, E>(
        &mut self,
        timeout: Duration,
        take: impl FnOnce(&Pulse) -> Result<R, E>,
    ) -> Result<Fed<R>, E> {
        let Self { reader, marked, health } = self;
        let read = reader.wait_for(timeout, |pulse, _, after_gap| {
            if !after_gap {
                return take(pulse);
            }
            marked.copy_from(pulse);
            marked.flags |= flags::AFTER_GAP;
            take(marked)
        });
        match read {
            Polled::Slot(taken) => {
                if taken.is_ok() {
                    health.wrote();
                }
                taken.map(Fed::Pulse)
            }
            Polled::Empty => Ok(Fed::Idle),
            Polled::Ended => Ok(Fed::Ended),
        }
    }
}

impl FanOut {
    /// Over these outlets, with slots for all that they may hold.
    pub fn new(outlets: Vec<Outlet>, settings: &Settings, layout: &Layout) -> Self {
        let held = held_at_most(settings, outlets.iter().map(|outlet| (outlet.lane.slots(), outlet.role)));
        Self { outlets, pool: Pool::new(held, layout), pace: settings.pace, view: None }
    }

    /// Lets an onlooker see what is sent.
    pub fn with_view(mut self, view: Option<View>) -> Self {
        self.pool.grow(view.as_ref().map_or(0, View::slots));
        Self { view, ..self }
    }

    /// Waits until every sink that is to get all pulses has room for one, but not after `until`, nor once
    /// `stop` is set. Returns whether it had to wait.
    pub fn make_room(&mut self, until: Instant, stop: &AtomicBool) -> bool {
        let mut waited = false;
        let Self { outlets, pool, .. } = self;
        while outlets.iter_mut().any(|outlet| outlet.is_short(pool)) {
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
    pub fn send(&mut self, pulse: Slot<Pulse>) -> Option<Slot<Pulse>> {
        let pulse = pulse.share();
        let Self { outlets, pool, pace, view } = self;
        if view.as_mut().is_some_and(|view| !view.offer(&pulse, pool)) {
            *view = None;
        }
        let mut gone = !outlets.is_empty();
        for outlet in outlets {
            if outlet.lane.is_abandoned() {
                if !outlet.role.may_fail {
                    return None;
                }
                outlet.lane.has_room(pool);
                outlet.health.missed();
                continue;
            }
            gone = false;
            let room = match pace {
                Pace::Realtime => outlet.lane.has_room(pool),
                Pace::Fast => outlet.await_room(pool),
            };
            if !room {
                if *pace == Pace::Fast && !outlet.role.may_fail {
                    return None;
                }
                outlet.gap = true;
                outlet.health.missed();
                continue;
            }
            outlet.lane.send(&pulse, std::mem::take(&mut outlet.gap));
            outlet.health.queue_level(outlet.lane.waiting());
        }
        (!gone).then(|| pool.exchange(pulse))
    }
}
