//! The instrument.

pub mod antenna;
pub mod pattern;
pub mod link;
mod emission;
pub mod illumination;
