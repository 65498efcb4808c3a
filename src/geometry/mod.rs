//! Delay, Doppler, angles.

pub mod bistatic;
