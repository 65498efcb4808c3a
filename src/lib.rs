//! `nereus`: a hardware-in-the-loop bistatic marine radar emulator.
//!
//! From a scenario to its pulses:
//!
//! ```
//! use nereus::{Samples, Scenario};
//!
//! let scenario = Scenario::load("configs/selftest.toml", &[("radar.window.samples", "512")])?;
//! scenario.each_pulse(0..4, |pulse| {
//!     let Samples::Cf32(iq) = &pulse.samples else { return };
//!     let peak = iq.iter().map(|sample| sample.norm_sqr()).fold(0.0, f32::max);
//!     println!("pulse {} at {}: peak {:.1} dBW", pulse.index, pulse.time, 10.0 * peak.log10());
//! })?;
//! # Ok::<(), nereus::ScenarioError>(())
//! ```
//!
//! [`Scenario`] reads and runs a scenario, [`PulseStream`] is a run with its sinks in real time,
//! [`Recording`] reads what was recorded, and [`focus()`] makes its images. [`scene`], [`config`] and
//! [`motion`] describe a run built in Rust instead of TOML, and [`processor`] has what images are made with.
//! What these pages leave out is the inside of the emulator: open to its own tests and tools, and free to
//! change with every version.
//!
//! The modules, in the order in which one may use another (a module imports only modules above it):
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`cpu`] | which instructions inner loops are compiled for |
//! | [`units`] | physical constants, decibels |
//! | [`frames`] | points and rotations tagged ECEF, ENU, body, antenna |
//! | [`time`] | exact emission times |
//! | [`rng`] | counter-based random streams |
//! | [`pulse`] | one pulse under way: samples, time tag, navigation, flags |
//! | [`files`] | outputs that are whole or not there |
//! | [`inputs`] | files that are read |
//! | [`scene`] | what there is, resolved, no physics |
//! | [`sea`] | the water: wind, spectra, the synthesised surface |
//! | [`nav`] | where platforms say they are: track files, NMEA and NovAtel messages, in and out |
//! | [`motion`] | where everything is at an instant: tracks, attitude, pointing |
//! | [`geometry`] | light time, delay rate, polarisation bases |
//! | [`scattering`] | what each target and facet returns |
//! | [`radar`] | waveform, antenna, link budget, receiver |
//! | [`paths`] | every scatterer's path of a pulse: exact, and by block |
//! | [`echo`] | scatterer paths to samples |
//! | [`transport`] | ring, pacer, health: real time, no physics |
//! | [`recording`] | files of pulses, maps and images, written and read |
//! | [`sinks`] | where pulses go |
//! | [`receive`] | a reference receiver of what the network sink sends |
//! | [`plot`] | pictures of maps, curves, the sea, and what its facets contribute |
//! | [`processor`] | what a processor makes of pulses: compression, back-projection, point targets |
//! | [`clutter`] | statistics of the sea's echo: laws, fits, goodness |
//! | [`config`] | a scenario as written, then as meant |
//! | [`fidelity`] | a requested error becomes settings, and the error they are predicted to leave |
//! | [`pipeline`] | the only factory: a run becomes a running stream, or a map of its sea; navigation is played to a port |
//! | [`adequacy`] | whether patch, facets, window and horizon fit the scene |
//! | [`mod@bench`] | assesses a run before it, and measures speed, error and clutter of a pipeline |
//! | `monitor` | the live page (feature `monitor`) |
//! | [`cli`] | the command line |
//!
//! SI units throughout, angles in radians, time convention `exp(+j w t)`.
//! Degrees appear at the scenario file and the command line only.

// The order is the order of the modules (tests/layout reads it), not the alphabet's.
#[doc(hidden)]
pub mod cpu;
pub mod units;
pub mod frames;
pub mod time;
pub mod rng;
pub mod pulse;
#[doc(hidden)]
pub mod files;
#[doc(hidden)]
pub mod inputs;
pub mod scene;
#[doc(hidden)]
pub mod sea;
pub mod nav;
pub mod motion;
#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod scattering;
#[doc(hidden)]
pub mod radar;
#[doc(hidden)]
pub mod paths;
#[doc(hidden)]
pub mod echo;
pub mod transport;
pub mod recording;
pub mod sinks;
#[doc(hidden)]
pub mod receive;
#[doc(hidden)]
pub mod plot;
pub mod processor;
#[doc(hidden)]
pub mod clutter;
pub mod config;
#[doc(hidden)]
pub mod fidelity;
pub mod pipeline;
#[doc(hidden)]
pub mod adequacy;
#[doc(hidden)]
pub mod bench;
#[doc(hidden)]
pub mod monitor;
#[doc(hidden)]
pub mod cli;

pub use pipeline::build::PulseStream;
pub use pipeline::focus::focus;
pub use pipeline::scenario::{Scenario, ScenarioError};
pub use processor::focus;
pub use pulse::{Pulse, Samples};
pub use recording::Recording;
