//! Contacts to samples.

pub mod reference;
pub mod synth;
