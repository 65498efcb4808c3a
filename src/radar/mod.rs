//! The instrument.

pub mod antenna;
pub mod calibration;
pub mod clock;
pub mod dechirp;
pub mod fault;
pub mod filter;
pub mod link;
pub mod pattern;
pub mod polarisation;
pub mod phasor;
pub mod lobe;
pub mod rain;
pub mod receiver;
pub mod taper;
pub mod waveform;
pub mod window;
