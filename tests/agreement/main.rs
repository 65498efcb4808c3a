//! Whole pulses against what they must agree with.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
mod blocks;
mod changes;
mod closed_forms;
mod ends;
mod horizon;
mod known_errors;
mod matched_filter;
mod measured;
mod planned;
mod radar_equation;
mod random_scene;
mod random_scenes;
mod runs;
mod same_bits;
mod scenes;
mod spectra;
mod stretched;
mod synth_error;
mod synth_laws;
mod synth_scenes;
mod varying_targets;
