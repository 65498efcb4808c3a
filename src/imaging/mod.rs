//! What a processor would see: images of recordings, pictures of maps and curves, files of maps and contacts.
//!
//! | page | holds |
//! | --- | --- |
//! | [`recording`] | reads recordings, HDF5 and plain folders |
//! | [`range_compress`] | pulse compression with the recorded replica |
//! | [`taper`] | weights over a band or an aperture |
//! | [`phase_path`] | where a phase centre is between pulses; light time |
//! | [`ground`] | the points of an image |
//! | [`backproject`] | bistatic time-domain back-projection: f64 reference, fast f32 |
//! | [`point_target`] | what an image makes of a point: width, side lobes, place |
//! | [`degradation`] | what wrong navigation makes of a point: predicted from the paths, closed forms |
//! | [`multilook`] | means of power, percentiles |
//! | [`statistics`] | K, Weibull and Rayleigh laws of clutter: fits, how good they are, shapes as measured |
//! | [`picture`] | a 2-D array in false colours: axes, colour bar, scale bar |
//! | [`plot`] | curves on linear, logarithmic or decibel axes |
//! | [`colours`] | colour maps of even steps |
//! | [`ticks`] | round numbers along an axis |
//! | [`canvas`] | pixels, lines and letters; PNG |
//! | [`map_file`] | several fields over one patch in an HDF5 file |
//! | [`image_file`] | complex images in an HDF5 file |
//! | [`contact_file`] | the contacts of one pulse in an HDF5 file |
//! | [`output`] | a file that is whole or not there |
//!
//! ```
//! use nereus::imaging::picture::{Axis, Picture};
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

pub mod recording;
pub mod taper;
pub mod phase_path;
pub mod range_compress;
pub mod ground;
pub mod backproject;
pub mod point_target;
pub mod degradation;
pub mod multilook;
pub mod statistics;
pub mod canvas;
pub mod colours;
pub mod contact_file;
pub mod map_file;
pub mod image_file;
pub mod output;
pub mod picture;
pub mod plot;
pub mod ticks;
