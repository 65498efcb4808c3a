//! Whole pulses against what they must agree with.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
#[path = "../support/dem.rs"]
mod dem;
mod arrays;
mod blocks;
mod breaking;
mod changes;
mod choppy;
mod closed_forms;
mod continuous;
mod emitters;
mod dechirp;
mod ends;
mod far_sea;
mod front_end;
mod hidden;
mod horizon;
mod in_turn;
mod known_errors;
mod land;
mod low_grazing;
mod matched_filter;
mod measured;
mod modulation;
mod near;
mod overlap;
mod planned;
mod radar_equation;
mod random_ends;
mod random_plans;
mod random_scene;
mod random_scenes;
mod random_turns;
mod random_waveforms;
mod rain;
mod receivers;
mod runs;
mod scanning;
mod same_bits;
mod scenes;
mod ships;
mod spectra;
mod streams;
mod steps;
mod stretched;
mod synth_error;
mod synth_laws;
mod synth_scenes;
mod turning;
mod two_platforms;
mod varying_targets;
