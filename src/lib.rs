//! `nereus`: a hardware-in-the-loop bistatic marine radar emulator.
//!
//! The rooms, in the order in which one may use another (a room imports only rooms above it):
//!
//! | room | what it holds |
//! | --- | --- |
//! | [`cpu`] | which instructions inner loops are compiled for |
//! | [`units`] | physical constants, decibels |
//! | [`frames`] | points and rotations tagged ECEF, ENU, body, antenna |
//! | [`time`] | exact emission times |
//! | [`rng`] | counter-based random streams |
//! | [`pulse`] | one pulse under way: samples, time tag, navigation, flags |
//! | [`files`] | output files, put in place when they are complete |
//! | [`inputs`] | files that are read |
//! | [`scene`] | what there is, resolved, no physics |
//! | [`sea`] | the water: wind, spectra, the synthesised surface |
//! | [`nav`] | where platforms say they are: track files, NMEA and NovAtel messages, in and out |
//! | [`motion`] | where everything is at an instant: tracks, attitude, pointing |
//! | [`geometry`] | light time, delay rate, polarisation bases |
//! | [`scattering`] | what each target and facet returns; the contact list |
//! | [`radar`] | waveform, antenna, link budget, receiver |
//! | [`echo`] | contacts to samples |
//! | [`transport`] | ring, pacer, health: real time, no physics |
//! | [`sinks`] | where pulses go |
//! | [`receive`] | a reference receiver of what the network sink sends |
//! | [`imaging`] | pictures of maps and curves, files of maps |
//! | [`config`] | a scenario as written, then as meant |
//! | [`plan`] | an error that is wanted becomes settings; error and cost before a run |
//! | [`pipeline`] | the only factory: a run becomes a running stream |
//! | [`cli`] | the command line |
//!
//! SI units throughout, angles in radians, time convention `exp(+j w t)`.
//! Degrees appear at the scenario file and the command line only.

// The order is the order of the rooms (tests/layout.rs reads it), not the alphabet's.
pub mod cpu;
pub mod units;
pub mod frames;
pub mod time;
pub mod rng;
pub mod pulse;
pub mod files;
pub mod inputs;
pub mod scene;
pub mod sea;
pub mod nav;
pub mod motion;
pub mod geometry;
pub mod scattering;
pub mod radar;
pub mod echo;
pub mod transport;
pub mod sinks;
pub mod receive;
pub mod imaging;
pub mod config;
pub mod plan;
pub mod pipeline;
pub mod cli;
