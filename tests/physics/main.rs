//! Physics against published figures, golden values and identities.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod radar_scenes;
mod radar_golden;
mod radar_link;
mod radar_pointing;
mod radar_pattern;
mod radar_windows;
mod radar_extremes;
