//! The instrument.

pub mod filter;
pub mod phasor;
pub mod receiver;
pub mod waveform;
