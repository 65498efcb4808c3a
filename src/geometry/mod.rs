//! Delay, Doppler, angles, shadow.

pub mod light_time;
pub mod bistatic;
pub mod shadow;
