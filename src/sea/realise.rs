//! From the description of a sea to its wind, its spectrum and one realisation of its surface.
//!
//! The grid of the surface is that of the patch: as many facets, the same side. A surface read from a file
//! must have that grid and the dispersion of the scene; its amplitudes then stand for spectrum and seed,
//! while wind and spectrum still decide how facets scatter.
//!
//! ```
//! use nereus::scene::water::{Development, SpectrumKind, WindGiven, WindProfile, WindStrength};
//! use nereus::scene::{Patch, Sea, Water};
//! use nereus::sea::realise::realise;
//! let wind = WindGiven {
//!     strength: WindStrength::Speed { speed_mps: 8.0, height_m: 10.0 },
//!     profile: WindProfile::Cardone,
//!     direction_rad: 0.5,
//! };
//! let water = Water::new(wind, SpectrumKind::Elfouhaily { development: Development::default() });
//! let sea = Sea::new(water, Patch::new([64.0, 64.0], 2.0, [0.0, 0.0])?);
//! let realised = realise(&sea, 7)?;
//! assert_eq!(realised.surface.grid().len(), 32 * 32);
//! assert!((realised.wind.u10_mps - 8.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::io::{self, BufReader};
use std::path::PathBuf;
use std::sync::Arc;

use super::spectrum::{Spectrum, SpectrumError, of_water};
use super::surface::{Grid, StateError, Surface, SurfaceError};
use super::wind::{Wind, WindError};
use crate::inputs;
use crate::scene::Sea;
use crate::scene::sea::Realisation;
use crate::scene::water::Dispersion;

/// A sea of which one realisation is known. Cheap to clone; clones share its spectrum and surface.
#[derive(Clone, Debug)]
pub struct Realised {
    /// The wind record of the run.
    pub wind: Wind,
    /// What waves there are, statistically.
    pub spectrum: Arc<dyn Spectrum>,
    /// What waves there are.
    pub surface: Arc<Surface>,
}

/// Why a sea cannot be realised.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RealiseError {
    /// The wind.
    #[error(transparent)]
    Wind(#[from] WindError),
    /// The spectrum.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The saved state cannot be opened.
    #[error("saved sea {path}: {source}", path = path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The saved state cannot be read.
    #[error("saved sea {path}: {source}", path = path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// Why.
        source: StateError,
    },
    /// The saved state is that of another grid.
    #[error(
        "saved sea {path}: {} x {} facets of {} m, but the patch has {} x {} of {} m",
        found.nx(), found.ny(), found.facet_m(), wanted.nx(), wanted.ny(), wanted.facet_m(),
        path = path.display()
    )]
    Grid {
        /// The file.
        path: PathBuf,
        /// Its grid.
        found: Grid,
        /// That of the patch.
        wanted: Grid,
    },
    /// The saved state moves by another dispersion.
    #[error("saved sea {path}: dispersion {found:?}, but the scene has {wanted:?}", path = path.display())]
    Dispersion {
        /// The file.
        path: PathBuf,
        /// Its dispersion.
        found: Dispersion,
        /// That of the scene.
        wanted: Dispersion,
    },
}

/// Resolves the wind, prepares the spectrum, draws the surface or reads it.
///
/// # Errors
/// A wind, spectrum or surface out of range, or a state that cannot be read.
pub fn realise(sea: &Sea, seed: u64) -> Result<Realised, RealiseError> {
    let wind = Wind::resolve(&sea.water.wind)?;
    let spectrum = of_water(&sea.water, &wind)?;
    let [nx, ny] = sea.patch.facets;
    let grid = Grid::new(nx, ny, sea.patch.facet_m)?;
    let dispersion = sea.water.dispersion;
    let surface = match &sea.realisation {
        Realisation::Drawn { averaging } => {
            Surface::synthesise(grid, spectrum.as_ref(), dispersion, seed, *averaging)?
        }
        Realisation::Saved { path } => {
            let path = path.clone();
            let file =
                inputs::open(&path).map_err(|source| RealiseError::Open { path: path.clone(), source })?;
            let surface = Surface::load(&mut BufReader::new(file))
                .map_err(|source| RealiseError::State { path: path.clone(), source })?;
            if *surface.grid() != grid {
                return Err(RealiseError::Grid { path, found: *surface.grid(), wanted: grid });
            }
            if surface.dispersion() != dispersion {
                let found = surface.dispersion();
                return Err(RealiseError::Dispersion { path, found, wanted: dispersion });
            }
            surface
        }
    };
    Ok(Realised { wind, spectrum: spectrum.into(), surface: surface.into() })
}
