//! The instrument.

pub mod antenna;
pub mod pattern;
pub mod link;
pub mod fault;
mod emission;
pub mod illumination;
