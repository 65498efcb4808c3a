//! The water: wind, wave spectra, the synthesised moving surface.
//!
//! | page | holds |
//! | --- | --- |
//! | [`wind`] | one consistent wind record per run |
//! | [`spectrum`] | what waves there are, statistically |
//! | [`dispersion`] | how fast a wave travels |
//! | [`realise`] | from the description of a sea to all of these |
//! | [`surface`] | one realisation, at any time |
//! | [`facet_surface`] | the same over the patch that is modelled |
//! | [`wave_sum`] | a sea without end, summed wave by wave where it is asked for |
//! | [`breaking`] | where and when it breaks |
//! | [`wake`] | what ships add to it |
//! | [`fleet`] | the ships of a scene with their wakes |
//! | [`seakeeping`] | how ships heave, pitch and roll |
//! | [`land`] | land in place of water, from a raster of heights |
//!
//! From wind to heights, slopes and velocities of facets:
//!
//! ```
//! use nereus::scene::water::{Development, Dispersion, WindProfile};
//! use nereus::sea::spectrum::Elfouhaily;
//! use nereus::sea::surface::{Averaging, Evaluator, Fields, Grid, Selection, Surface};
//! use nereus::sea::wind::Wind;
//!
//! let wind = Wind::from_speed(10.0, 10.0, WindProfile::Cardone, 0.5)?;
//! let spectrum = Elfouhaily::new(&wind, Development::InverseWaveAge(0.84))?;
//! let grid = Grid::new(64, 64, 4.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 7, Averaging::Automatic)?;
//! let mut fields = Fields::<f32>::new(&grid, Selection::ALL);
//! let mut evaluator = Evaluator::new(&surface);
//! evaluator.evaluate(12.5, &mut fields)?;
//! assert!(fields.height_m.iter().all(|z| z.abs() < 10.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod breaking;
pub mod dispersion;
pub mod fleet;
pub mod realise;
pub mod facet_surface;
pub mod land;
pub mod seakeeping;
pub mod spectrum;
pub mod summary;
pub mod surface;
pub mod wake;
pub mod wave_sum;
pub mod wind;

/// Acceleration of gravity, m/s^2.
pub const GRAVITY_MPS2: f64 = 9.81;
