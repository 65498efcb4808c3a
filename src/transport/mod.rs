//! Real time: rings, pacer, health. Knows no physics.
//!
//! ```text
//! generation -> ring -> pacer -> fan-out -> one ring per sink -> sink threads
//! ```
//!
//! [`stage::Stream`] puts these together; [`pacer`] defines deadlines, lateness, underrun and what the
//! policies do; [`ring`] is the only way by which pulses travel between threads.

use thiserror::Error;

#[doc(hidden)]
pub mod rights;
#[doc(hidden)]
pub mod ring;
pub mod schedule;
mod durations;
#[doc(hidden)]
pub mod health;
#[doc(hidden)]
pub mod pool;
#[doc(hidden)]
pub mod view;
#[doc(hidden)]
pub mod fanout;
#[doc(hidden)]
pub mod shortage;
#[doc(hidden)]
pub mod judge;
#[doc(hidden)]
pub mod pacer;
#[doc(hidden)]
pub mod dispatcher;
#[doc(hidden)]
pub mod stage;

/// Why a stream cannot be set up.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum StreamError {
    /// The ring between generation and pacer has no slot.
    #[error("the ring between generation and pacer has 0 slots; at least 1 is needed")]
    EmptyRing,
    /// A sink's queue has no slot.
    #[error("the queue of sink '{sink}' has 0 slots; at least 1 is needed")]
    EmptyQueue {
        /// Which sink.
        sink: String,
    },
    /// A thread could not be started.
    #[error("thread '{thread}' could not be started: {kind}")]
    Thread {
        /// Its name.
        thread: String,
        /// The system's error.
        kind: std::io::ErrorKind,
    },
}

/// Release minus emission time where nothing is asked, s.
pub const DEFAULT_LATENCY_S: f64 = 0.5;

/// How pulses are released.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Real time, or as fast as they are made.
    pub pace: Pace,
    /// What happens when generation cannot keep up in real time.
    pub policy: Policy,
    /// Release of a pulse minus its emission time, s: how far ahead pulses are made.
    pub latency_s: f64,
    /// Whether the scenario asks for that latency; otherwise live navigation may need a longer one.
    pub latency_given: bool,
    /// Slots of the ring between generation and release.
    pub ring_slots: usize,
    /// Pulses that are made at once before the first of them is there: a block for every thread.
    pub batch_pulses: u64,
    /// Threads that make pulses; 0: as many as the machine has.
    pub threads: usize,
    /// Whether the pacer asks for real-time priority (`SCHED_FIFO`).
    pub pacer_ahead: bool,
    /// The core on which the pacer asks to stay.
    pub pacer_core: Option<usize>,
    /// Whether the stream asks that its memory stay where it is.
    pub lock_memory: bool,
}

impl Settings {
    /// At what priority pulses of a mean rate, Hz, were released, and why not at real-time priority
    /// (`ahead`). What the system refused is reported beside it.
    pub fn priority(&self, ahead: bool, mean_prf_hz: f64) -> &'static str {
        if ahead {
            "real-time priority"
        } else if !self.pacer_ahead {
            "ordinary priority (stream.pacer_priority)"
        } else if pacer::may_run_ahead(mean_prf_hz) {
            "ordinary priority (refused)"
        } else {
            "ordinary priority (above 1000 pulses/s, where its waiting would take a core from all others)"
        }
    }
}

impl Default for Settings {
    /// Real time, stopping when it is not kept, half a second ahead.
    fn default() -> Self {
        Self {
            pace: Pace::Realtime,
            policy: Policy::Stop,
            latency_s: DEFAULT_LATENCY_S,
            latency_given: true,
            ring_slots: 128,
            batch_pulses: 1,
            threads: 0,
            pacer_ahead: true,
            pacer_core: None,
            lock_memory: false,
        }
    }
}

/// When pulses are released.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pace {
    /// At `t0 + n/PRF`.
    Realtime,
    /// As soon as they are made; nothing is late and nothing is dropped.
    Fast,
}

/// What happens when generation cannot keep up in real time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Policy {
    /// End with an error that names the stage that cannot keep up.
    Stop,
    /// Lossless: time stretches, late pulses are flagged and counted.
    Slip,
    /// Keep real time: missing pulse indices are counted.
    Drop,
    /// Keep real time by making pulses at coarser errors; the same as `Drop` where the coarsest is too slow.
    Relax,
}

impl Policy {
    /// Whether what is overdue is left out instead of waited for.
    pub(crate) fn drops(self) -> bool {
        matches!(self, Self::Drop | Self::Relax)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_priority_has_its_reason() {
        let asked = Settings { pacer_ahead: true, ..Settings::default() };
        assert_eq!(asked.priority(true, 250.0), "real-time priority");
        assert_eq!(asked.priority(false, 250.0), "ordinary priority (refused)");
        assert!(asked.priority(false, 1001.0).starts_with("ordinary priority (above 1000 pulses/s"));
        let ordinary = Settings { pacer_ahead: false, ..asked };
        assert_eq!(ordinary.priority(false, 250.0), "ordinary priority (stream.pacer_priority)");
    }
}
