//! Physics against published figures, golden values and itself.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod sea_extremes;
mod sea_golden;
mod sea_spectrum;
mod sea_surface;
mod sea_wind;
