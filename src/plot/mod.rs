//! Pictures of maps and curves as PNG.
//!
//! | page | holds |
//! | --- | --- |
//! | [`picture`] | a 2-D array in false colours: axes, colour bar, scale bar |
//! | [`plan`] | what a radar sees around it: range rings, bearing marks, colour bar |
//! | [`chart`] | curves on linear, logarithmic or decibel axes |
//! | [`patch`] | fields of a patch of sea, and what its facets contribute to an echo |
//! | [`body_plan`] | sections of a hull, from ahead and from astern |
//! | [`colours`] | colour maps of even steps |
//! | [`ticks`] | round numbers along an axis |
//! | [`canvas`] | pixels, lines and letters; PNG |
//!
//! ```
//! use nereus::plot::picture::{Axis, Picture};
//! let hills: Vec<f64> = (0..32 * 16).map(|i| (0.3 * f64::from(i % 32)).sin()).collect();
//! let picture = Picture {
//!     title: "Hills",
//!     x: Axis { label: "East, m", from: 0.0, to: 64.0 },
//!     y: Axis { label: "North, m", from: 0.0, to: 32.0 },
//!     scale_bar: Some("m"),
//!     ..Picture::new(&hills, [32, 16])?
//! };
//! let mut file = Vec::new();
//! picture.draw()?.write_png(&mut file)?;
//! assert!(file.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod body_plan;
pub mod canvas;
pub mod chart;
pub mod colours;
pub mod patch;
pub mod picture;
pub mod plan;
pub mod ticks;
