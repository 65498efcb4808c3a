//! The sea of a scene: the water, the patch of it that is modelled, how it scatters, what floats on it.
//!
//! Plain settings; the rooms `sea`, `scattering`, `geometry` and `radar` know what they mean.

use std::path::PathBuf;

use super::radar::{Aim, AimFrom};
use super::{Patch, Water};

/// The sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Sea {
    /// Wind, spectrum, swell, depth, temperature, salinity.
    pub water: Water,
    /// How the spectrum is drawn, and where from.
    pub realisation: Realisation,
    /// The facets that are modelled: at every pulse ([`PatchPlace::Fixed`]) or at pulse 0.
    pub patch: Patch,
    /// Whether they stay.
    pub place: PatchPlace,
    /// How facets scatter.
    pub scattering: FacetScattering,
    /// Who stands behind a wave; `None`: nobody is ever hidden.
    pub shadow: Option<Shadowing>,
    /// Films on the water.
    pub slicks: Vec<SlickRegion>,
}

/// Where the amplitudes of the waves come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Realisation {
    /// Drawn from the scene's seed.
    Drawn {
        /// How the spectrum is taken on the grid of wave numbers.
        averaging: Averaging,
    },
    /// Read from a state saved by `nereus sea` (its grid must be that of the patch).
    Saved {
        /// The file.
        path: PathBuf,
    },
}

/// How the spectrum is taken on the grid of wave numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Averaging {
    /// Means over cells where the grid is coarse for the spectrum, points otherwise.
    #[default]
    Automatic,
    /// At the points of the grid.
    Points,
    /// Means over the cells around them.
    Cells,
}

/// Whether the patch stays.
#[derive(Clone, Debug, PartialEq)]
pub enum PatchPlace {
    /// It stays where it is.
    Fixed,
    /// Its middle facet is the one nearest to an aim point; rows enter and leave on either side, with the
    /// phases of their global keys. The waves repeat with the patch's size.
    Follow {
        /// The point followed.
        aim: Aim,
        /// From which tracks it is known.
        aim_from: AimFrom,
    },
}

/// How facets scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetScattering {
    /// Permittivity of the water.
    pub permittivity: Permittivity,
    /// How waves are shared between specular points and Bragg scattering.
    pub splitting: Splitting,
    /// Wave number that divides them, rad/m; `None` for the splitting's own.
    pub cut_radpm: Option<f64>,
    /// Whether the Bragg part averages over sub-facet tilts.
    pub tilt_average: bool,
    /// Whether slope densities have the Gram-Charlier terms.
    pub gram_charlier: bool,
    /// How random phases enter.
    pub phases: Phases,
    /// Time in which a facet forgets its phase, s; `None` for never.
    pub decorrelation_s: Option<f64>,
    /// Whether facets follow the horizontal orbital motion; if not (as in the paper) they move up and down only.
    pub displacement: bool,
}

impl Default for FacetScattering {
    fn default() -> Self {
        Self {
            permittivity: Permittivity::default(),
            splitting: Splitting::default(),
            cut_radpm: None,
            tilt_average: false,
            gram_charlier: false,
            phases: Phases::default(),
            decorrelation_s: None,
            displacement: true,
        }
    }
}

/// Model of the permittivity of sea water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Permittivity {
    /// Meissner and Wentz 2012: 1 to 90 GHz.
    #[default]
    MeissnerWentz,
    /// Klein and Swift 1977: 1 to 10 GHz.
    KleinSwift,
}

/// How waves are shared between the two scattering mechanisms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Splitting {
    /// Each wave counts once.
    #[default]
    Consistent,
    /// As the paper: all slopes and the whole spectrum, on top of the tilts of the height map.
    Mars2007,
}

/// How random phases enter a facet's matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phases {
    /// One phase for each mechanism, amplitudes as they are.
    #[default]
    PolCoherent,
    /// One phase for all, magnitudes only.
    Single,
}

/// How visibility is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadowing {
    /// Width of the edge between light and shadow as a tangent: 0 for the paper's binary rule, `None` for half the
    /// rms change of slope over a facet.
    pub width_rad: Option<f64>,
    /// Rays per facet across the look direction.
    pub rays_per_facet: usize,
    /// Time between updates, s; weights are cross-faded linearly in between.
    pub update_s: f64,
}

impl Default for Shadowing {
    fn default() -> Self {
        Self { width_rad: None, rays_per_facet: 2, update_s: 0.02 }
    }
}

/// A film on the water, at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct SlickRegion {
    /// Name, unique among slicks.
    pub name: String,
    /// Where it is.
    pub shape: SlickShape,
    /// Width of the rim, m, over which the cover falls from full to none (raised cosine, centred on the outline).
    pub rim_m: f64,
    /// Share of the water covered inside, 0 to 1.
    pub cover: f64,
    /// Dilational elasticity of the film, N/m.
    pub elasticity_npm: f64,
}

/// Outline of a slick, on the horizontal plane of the scene frame.
#[derive(Clone, Debug, PartialEq)]
pub enum SlickShape {
    /// An ellipse.
    Ellipse {
        /// Centre, m.
        centre_m: [f64; 2],
        /// Half axes, m.
        half_axes_m: [f64; 2],
        /// Direction of the first axis, from +x counter-clockwise, radians.
        direction_rad: f64,
    },
    /// A simple polygon, either way round.
    Polygon {
        /// Corners, m.
        corners_m: Vec<[f64; 2]>,
    },
}
