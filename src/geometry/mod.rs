//! Delay, Doppler, angles.

pub mod light_time;
pub mod bistatic;
