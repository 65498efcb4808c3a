//! Changes of reports while a run goes on.
//!
//! Whoever holds a [`Control`] asks for a change; it is taken between two claims of the workers
//! ([`Dispatcher::between`](crate::transport::dispatcher::Dispatcher::between)) and has effect from the first
//! pulse that no work begun so far asks for. That is the first one that no worker has claimed or, where
//! windows hold later emissions or flights are longer than an interval, some pulses later. The same change
//! given as an event of the scenario at that pulse makes the same pulses, bit for bit, on any number of
//! threads.
//!
//! Nobody in the stream waits for whoever asks: a channel of bounded length is evaluated, and what is found
//! is answered.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use serde::Serialize;
use thiserror::Error;

use crate::motion::changes::{Change, ChangeFault, Changes, Event, NotAChange, addressed};
use crate::pulse::log::Origin;
use crate::transport::health::{Health, Snapshot};

/// Changes that may wait to be taken.
const WAITING: usize = 64;
/// How often a waiting caller checks whether the run is over.
const GLANCE: Duration = Duration::from_millis(20);

/// Why a change is not taken.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ControlError {
    /// A line that is no change.
    #[error(transparent)]
    Text(#[from] NotAChange),
    /// What is wrong with it.
    #[error(transparent)]
    Fault(#[from] ChangeFault),
    /// There is nothing to change any more.
    #[error("the run has ended: allowed: changes while pulses are left to be made")]
    Over,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Pulses released.
    pub released: u64,
    /// Of these, late ones.
    pub late: u64,
    /// Pulses that were not made in time.
    pub dropped: u64,
    /// Pulses made.
    pub made: u64,
    /// Pulses of the whole run.
    pub total: u64,
}

struct Request {
    platform: usize,
    change: Change,
    answer: Sender<Result<u64, ChangeFault>>,
}

/// Asks a running stream for changes, from any thread.
#[derive(Clone)]
pub struct Control {
    requests: Sender<Request>,
    changes: Arc<Changes>,
    health: Arc<OnceLock<Arc<Health>>>,
    over: Arc<AtomicBool>,
    total: u64,
}

/// Where the stream finds what it is asked for.
pub(super) struct CommandQueue {
    requests: Receiver<Request>,
    changes: Arc<Changes>,
    health: Arc<OnceLock<Arc<Health>>>,
    over: Arc<AtomicBool>,
}

impl Drop for CommandQueue {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
    }
}

/// The two ends, for a run of so many pulses.
pub(super) fn control(changes: &Arc<Changes>, total: u64) -> (Control, CommandQueue) {
    let (sender, receiver) = bounded(WAITING);
    let health = Arc::new(OnceLock::new());
    let over = Arc::new(AtomicBool::new(false));
    let asks = Control {
        requests: sender,
        changes: Arc::clone(changes),
        health: Arc::clone(&health),
        over: Arc::clone(&over),
        total,
    };
    (asks, CommandQueue { requests: receiver, changes: Arc::clone(changes), health, over })
}

impl Control {
    /// Asks for a change and waits until it is taken; says which pulse is the first that has it.
    ///
    /// # Errors
    /// A platform that is none, too many changes, a run that has no pulse left.
    pub fn change(&self, platform: Option<&str>, change: Change) -> Result<u64, ControlError> {
        let platform = self.changes.platform(platform)?;
        let (answer, answered) = bounded(1);
        let request = Request { platform, change, answer };
        self.requests.send(request).map_err(|_| ControlError::Over)?;
        loop {
            // A request that comes as the run ends stays in the channel unseen: nobody answers it.
            let over = self.over.load(Ordering::Acquire);
            match answered.recv_timeout(GLANCE) {
                Ok(taken) => return Ok(taken?),
                Err(RecvTimeoutError::Timeout) if !over => {}
                Err(_) => return Err(ControlError::Over),
            }
        }
    }

    /// Asks for the change that a line describes, such as `step position.up 5 m on aircraft`
    /// (`docs/control.md`). Returns the first pulse that has it, and the line as it was understood.
    ///
    /// # Errors
    /// A line that is no change, and what [`Self::change`] refuses.
    pub fn line(&self, text: &str) -> Result<(u64, String), ControlError> {
        let (change, platform) = addressed(text.trim())?;
        let pulse = self.change(platform, change)?;
        let on = platform.map_or_else(String::new, |name| format!(" on {name}"));
        Ok((pulse, format!("{change}{on}")))
    }

    /// All counters of the run; `None` before its first pulse is made.
    pub fn health(&self) -> Option<Snapshot> {
        self.health.get().map(|health| health.snapshot())
    }

    /// How far the run is.
    pub fn counts(&self) -> Counts {
        let total = self.total;
        self.health.get().map_or(Counts { total, ..Counts::default() }, |health| Counts {
            released: health.released_pulses(),
            late: health.late_pulses(),
            dropped: health.dropped_pulses(),
            made: health.made_pulses(),
            total,
        })
    }
}

impl CommandQueue {
    /// Tells those who ask how the stream counts.
    pub fn open(&self, health: &Arc<Health>) {
        let _ = self.health.set(Arc::clone(health));
    }

    /// Takes what is asked for. `untouched` finds the first pulse that may have it, and the run ends before
    /// pulse `end`.
    pub fn serve(&self, untouched: impl Fn() -> u64, end: u64) {
        while let Ok(Request { platform, change, answer }) = self.requests.try_recv() {
            let pulse = untouched();
            let taken = if pulse < end {
                self.changes.enter(&Event { pulse, platform, change }, Origin::Control).map(|()| pulse)
            } else {
                Err(ChangeFault::AfterTheEnd { pulse, end })
            };
            // Who asked may have gone.
            let _ = answer.try_send(taken);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;
    use crate::time::{PulseTimes, TimeTag};

    /// A request that is in the channel when the run ends is refused, although nobody has seen it.
    #[test]
    fn nobody_waits_for_a_run_that_is_over() {
        let times = PulseTimes::uniform(1.0).unwrap();
        let changes = Changes::new(&["mast".to_owned()], &times, TimeTag::default());
        let (asks, commands) = control(&Arc::new(changes), 10);
        let other = asks.clone();
        let waits = thread::spawn(move || other.change(None, Change::Clear));
        while commands.requests.is_empty() {
            thread::yield_now();
        }
        drop(commands);
        assert_eq!(waits.join().unwrap(), Err(ControlError::Over));
        assert_eq!(asks.change(None, Change::Clear), Err(ControlError::Over));
    }
}
