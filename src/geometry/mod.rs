//! Delay, Doppler, angles.
