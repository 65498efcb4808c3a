//! Shared memory: a processor on the same machine reads pulses where they lie (iceoryx2).
//!
//! Two publish-subscribe services:
//!
//! | service | user header | payload | |
//! | --- | --- | --- | --- |
//! | `NAME/pulses` | `PulseHeader` | words of 8 bytes: reported states, then samples | every pulse; the last marks that the run has ended |
//! | `NAME/run` | | JSON | what holds for the run, kept for whoever comes later |
//!
//! A pulse is copied once, from the queue of the sink into memory that every subscriber sees. Nobody waits
//! for a subscriber: each has a buffer of `buffer_pulses`, and when that is full the oldest pulse in it makes
//! room. `sequence` counts what was published, so that a subscriber sees what it has missed. Who comes later
//! gets the latest `buffer_pulses`.
//!
//! The memory is taken and touched when the sink is opened. Every buffer holds the latest pulses, the same
//! for all subscribers, so that it takes
//!
//! ```text
//! (buffer_pulses + BORROWED subscribers + a few) * bytes of a pulse
//! ```
//!
//! Limits: one machine; a subscriber borrows [`BORROWED`] pulses at a time, and copies what it keeps longer.

#[cfg(feature = "shm")]
pub(crate) mod layout;
#[cfg(feature = "shm")]
mod memory;
#[cfg(feature = "shm")]
pub(crate) mod publisher;

use super::fault::SinkError;

#[cfg(feature = "shm")]
pub use layout::{PulseHeader, STATE_WORDS};
#[cfg(feature = "shm")]
pub use publisher::ShmSink;

/// Pulses that a subscriber may hold at a time.
pub const BORROWED: usize = 4;

/// Under which name, and for how many.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// First part of the names of the services.
    pub service: String,
    /// Most subscribers at a time.
    pub subscribers: usize,
    /// Pulses that may wait for a subscriber.
    pub buffer_pulses: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { service: "nereus".to_owned(), subscribers: 4, buffer_pulses: 64 }
    }
}

/// Whether somebody else publishes under this name; what killed runs have left behind is removed.
#[cfg(feature = "shm")]
pub(super) fn preflight(settings: &Settings) -> Result<(), SinkError> {
    publisher::preflight(settings)
}

/// Without iceoryx2 there is no shared memory.
#[cfg(not(feature = "shm"))]
pub(super) fn preflight(settings: &Settings) -> Result<(), SinkError> {
    Err(SinkError::NoShm { service: settings.service.clone() })
}
