//! Delay, Doppler, angles, shadow.

pub mod lanes;
pub mod light_time;
pub mod phase_path;
pub mod bistatic;
pub mod shadow;
pub mod horizon;
pub mod occlusion;
pub mod specular;
