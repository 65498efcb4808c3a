//! What interpolation leaves of flight, waves and beams: closed forms that predictions are held against.

pub mod gain;
pub mod interpolation;
mod path;
mod waves;
