//! Delay, Doppler, angles.

pub mod bistatic;
pub mod light_time;
