//! The instrument.

pub mod antenna;
pub mod pattern;
pub mod link;
pub mod emission;
pub mod illumination;
