//! The sea of a scene: the water, the patch of it that is modelled, how it scatters, what floats on it.
//!
//! Plain settings; the modules `sea`, `scattering`, `geometry` and `radar` know what they mean.

use std::path::PathBuf;

use super::radar::{Aim, AimFrom};
use super::{Land, Patch, Water};

/// The sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Sea {
    /// Wind, spectrum, swell, depth, temperature, salinity.
    pub water: Water,
    /// How the spectrum is drawn, and where from.
    pub realisation: Realisation,
    /// The facets that are modelled. Of a patch that follows, only their number and size: where they are, its
    /// aim of the receiver has it.
    pub patch: Patch,
    /// Whether they stay.
    pub place: PatchPlace,
    /// Resolution in azimuth of the processor behind, m: facets are judged by it.
    pub azimuth_resolution_m: f64,
    /// Whether crests are as long as troughs.
    pub waves: Waves,
    /// How facets scatter.
    pub scattering: FacetScattering,
    /// Who stands behind a wave; `None`: nobody is ever hidden.
    pub shadow: Option<Shadowing>,
    /// The sea beyond the patch; `None`: none.
    pub far: Option<FarSea>,
    /// Films on the water.
    pub slicks: Vec<SlickRegion>,
    /// Land on the patch, if any.
    pub land: Option<Land>,
}

impl Sea {
    /// A patch of such water that stays, its waves drawn by the seed, in the default way of everything; no
    /// shadows, slicks or land.
    pub fn new(water: Water, patch: Patch) -> Self {
        Self {
            water,
            realisation: Realisation::Drawn { averaging: Averaging::default() },
            patch,
            place: PatchPlace::Fixed,
            azimuth_resolution_m: 1.0,
            waves: Waves::default(),
            scattering: FacetScattering::default(),
            shadow: None,
            far: None,
            slicks: Vec::new(),
            land: None,
        }
    }
}

/// Where the amplitudes of the waves come from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
#[non_exhaustive]
pub enum Averaging {
    /// Means over cells where the grid is coarse for the spectrum, points otherwise.
    #[default]
    Automatic,
    /// At the points of the grid.
    Points,
    /// Means over the cells around them.
    Cells,
}

/// Order of the waves in their steepness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Waves {
    /// Linear: crests and troughs alike, facets of equal area.
    Linear,
    /// Sharp crests and flat troughs, facets that crowd on crests (`sea::surface::choppy`).
    #[default]
    Choppy,
}

/// Whether the patch stays.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
    /// Bragg waves in light wind.
    pub light_wind: LightWinds,
    /// Whether slope densities have the Gram-Charlier terms.
    pub gram_charlier: bool,
    /// How random phases enter.
    pub phases: Phases,
    /// Which amplitudes they have.
    pub speckle: Speckle,
    /// Whether the waves that scatter travel.
    pub bragg: BraggWaves,
    /// Whether waves break.
    pub breaking: Breaking,
    /// Whether long waves modulate the waves that scatter.
    pub modulation: Modulation,
    /// Time in which a facet forgets its phase, s; `None` for never, or as travelling waves have it.
    pub decorrelation_s: Option<f64>,
    /// Whether facets follow the horizontal orbital motion; if not (as in the paper) they move up and down
    /// only.
    pub displacement: bool,
}

impl Default for FacetScattering {
    fn default() -> Self {
        Self {
            permittivity: Permittivity::default(),
            splitting: Splitting::default(),
            cut_radpm: None,
            tilt_average: true,
            light_wind: LightWinds::default(),
            gram_charlier: false,
            phases: Phases::default(),
            speckle: Speckle::default(),
            bragg: BraggWaves::TRAVELLING,
            breaking: Breaking::default(),
            modulation: Modulation::default(),
            decorrelation_s: None,
            displacement: true,
        }
    }
}

/// Whether waves break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Breaking {
    /// None does.
    Off,
    /// As much of the sea as whitecaps cover (`sea::breaking`).
    #[default]
    Whitecaps,
}

/// Model of the permittivity of sea water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Permittivity {
    /// Meissner and Wentz 2012: 1 to 90 GHz.
    #[default]
    MeissnerWentz,
    /// Klein and Swift 1977: 1 to 10 GHz.
    KleinSwift,
    /// Recommendation ITU-R P.527-6: 1 MHz to 1 THz.
    ItuRP527,
}

/// How waves are shared between the two scattering mechanisms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Splitting {
    /// Each wave counts once.
    #[default]
    Consistent,
    /// As the paper: all slopes and the whole spectrum, on top of the tilts of the height map.
    Mars2007,
}

/// Which Bragg waves a light wind has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LightWinds {
    /// None below the wind that sustains them, and never fewer in more wind (`sea::spectrum::light_wind`).
    #[default]
    Threshold,
    /// Those of the spectrum as published.
    AsPublished,
}

/// Whether the Bragg waves within a facet travel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum BraggWaves {
    /// They ride on the facet and do not move: no Doppler but the facet's.
    #[default]
    Frozen,
    /// Two lines, of waves that come closer and that go away (`scattering::bragg`).
    Travelling {
        /// Speed of the water's drift over that of the wind at 10 m.
        drift_share: f64,
        /// Direction of the drift, counter-clockwise from that of the wind, rad.
        drift_turn_rad: f64,
    },
}

/// Whether long waves modulate the Bragg waves of a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Modulation {
    /// All facets are as rough.
    Off,
    /// Short waves gain where the surface contracts, and relax (`sea::surface::modulation`).
    Relaxation {
        /// Relaxation rate, 1/s; `None` for that of their growth in the wind.
        rate_per_s: Option<f64>,
    },
}

impl Default for Modulation {
    fn default() -> Self {
        Self::Relaxation { rate_per_s: None }
    }
}

impl BraggWaves {
    /// They travel, with a drift of 3 % of the wind, along it.
    pub const TRAVELLING: Self = Self::Travelling { drift_share: 0.03, drift_turn_rad: 0.0 };
}

/// How random phases enter a facet's matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Phases {
    /// One phase for each mechanism, amplitudes as they are.
    #[default]
    PolCoherent,
    /// One phase for all, magnitudes only.
    Single,
}

/// What a facet is in a resolution cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Speckle {
    /// One scatterer of a given amplitude and a random phase: many of them make speckle.
    #[default]
    RandomPhase,
    /// All the scatterers that it holds: of complex Gaussian amplitude, speckle by itself.
    Gaussian {
        /// Random processes for the tilts within a facet (`scattering::modes`).
        tilt_modes: usize,
    },
}

/// How visibility is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadowing {
    /// Width of the edge between light and shadow as a tangent: 0 for the paper's binary rule, `None` for
    /// half the rms change of slope over a facet.
    pub width_rad: Option<f64>,
    /// Rays per facet across the look direction.
    pub rays_per_facet: usize,
    /// Time between updates, s; weights are cross-faded linearly in between.
    pub update_s: f64,
    /// Whether the ray that the mean sea reflects onto a facet interferes with the straight one
    /// (`scattering::two_rays`).
    pub two_rays: bool,
}

impl Default for Shadowing {
    fn default() -> Self {
        Self { width_rad: None, rays_per_facet: 2, update_s: 0.02, two_rays: false }
    }
}

/// The sea beyond the patch, by cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FarSea {
    /// Cells in a resolution cell.
    pub cells: u32,
    /// Cells of a pulse, at most.
    pub most: u32,
    /// Whether cells have waves in common, so that swell is seen.
    pub texture: bool,
}

/// A film on the water, at rest.
///
/// ```
/// use nereus::scene::sea::{SlickRegion, SlickShape};
/// let shape = SlickShape::Ellipse { centre_m: [0.0, 0.0], half_axes_m: [100.0, 50.0], direction_rad: 0.0 };
/// let film = SlickRegion { name: "oil".into(), shape, rim_m: 10.0, cover: 0.8, elasticity_npm: 0.0255 };
/// assert_eq!((film.cover_at([0.0, 0.0]), film.cover_at([110.0, 0.0])), (0.8, 0.0));
/// assert!((film.cover_at([100.0, 0.0]) - 0.4).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SlickRegion {
    /// Name, unique among slicks.
    pub name: String,
    /// Where it is.
    pub shape: SlickShape,
    /// Width of the rim, m, over which the cover falls from full to none (raised cosine, centred on the
    /// outline).
    pub rim_m: f64,
    /// Share of the water covered inside, 0 to 1.
    pub cover: f64,
    /// Dilational elasticity of the film, N/m.
    pub elasticity_npm: f64,
}

/// Outline of a slick, on the horizontal plane of the scene frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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

impl SlickRegion {
    /// Share of the water covered at a place, 0 to `cover`: full further inside than half a rim, none further
    /// outside, a raised cosine of the distance from the outline in between.
    pub fn cover_at(&self, place_m: [f64; 2]) -> f64 {
        let inward_m = self.shape.inward_m(place_m);
        let half_m = 0.5 * self.rim_m;
        if inward_m >= half_m {
            self.cover
        } else if inward_m <= -half_m || !inward_m.is_finite() {
            0.0
        } else {
            self.cover * 0.5 * (1.0 + (std::f64::consts::FRAC_PI_2 * inward_m / half_m).sin())
        }
    }
}

impl SlickShape {
    /// Distance from the outline, m, positive inside. Of an ellipse it is counted along the ray from the
    /// centre.
    fn inward_m(&self, place_m: [f64; 2]) -> f64 {
        match self {
            Self::Ellipse { centre_m, half_axes_m, direction_rad } => {
                let (sin, cos) = direction_rad.sin_cos();
                let (x, y) = (place_m[0] - centre_m[0], place_m[1] - centre_m[1]);
                let (along, across) = (cos * x + sin * y, cos * y - sin * x);
                let radius_m = along.hypot(across);
                let reduced = (along / half_axes_m[0]).hypot(across / half_axes_m[1]);
                if reduced > 0.0 { radius_m / reduced - radius_m } else { half_axes_m[0].min(half_axes_m[1]) }
            }
            Self::Polygon { corners_m } => polygon_inward_m(corners_m, place_m),
        }
    }

    /// The smallest upright rectangle around the outline: least and greatest x and y, m.
    pub fn bounds_m(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Ellipse { centre_m, half_axes_m: [a, b], direction_rad } => {
                let (sin, cos) = direction_rad.sin_cos();
                let half_m = [(a * cos).hypot(b * sin), (a * sin).hypot(b * cos)];
                [0, 1].map(|axis| [centre_m[axis] - half_m[axis], centre_m[axis] + half_m[axis]])
            }
            Self::Polygon { corners_m } => [0, 1].map(|axis| {
                let of = |fold: fn(f64, f64) -> f64, from| corners_m.iter().map(|c| c[axis]).fold(from, fold);
                [of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY)]
            }),
        }
    }
}

/// Distance from the nearest side, positive where a ray to +x crosses an odd number of sides.
fn polygon_inward_m(corners_m: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let mut inside = false;
    let mut nearest_m = f64::INFINITY;
    for (i, &[x1, y1]) in corners_m.iter().enumerate() {
        let [x0, y0] = corners_m[if i == 0 { corners_m.len() - 1 } else { i - 1 }];
        let (dx, dy) = (x1 - x0, y1 - y0);
        let length2 = dx * dx + dy * dy;
        let along =
            if length2 > 0.0 { (((x - x0) * dx + (y - y0) * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        nearest_m = nearest_m.min((x - x0 - along * dx).hypot(y - y0 - along * dy));
        if (y0 > y) != (y1 > y) && x < x0 + (y - y0) / dy * dx {
            inside = !inside;
        }
    }
    if inside { nearest_m } else { -nearest_m }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(rim_m: f64) -> SlickRegion {
        let corners_m = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        SlickRegion {
            name: "square".into(),
            shape: SlickShape::Polygon { corners_m },
            rim_m,
            cover: 1.0,
            elasticity_npm: 0.02,
        }
    }

    #[test]
    fn polygons_are_full_inside_and_empty_outside() {
        let film = square(2.0);
        assert_eq!((film.cover_at([5.0, 5.0]), film.cover_at([-1.5, 5.0])), (1.0, 0.0));
        assert!((film.cover_at([0.0, 5.0]) - 0.5).abs() < 1e-12);
        assert_eq!(square(0.0).cover_at([9.99, 5.0]), 1.0);
        assert_eq!(film.shape.bounds_m(), [[0.0, 10.0], [0.0, 10.0]]);
    }

    #[test]
    fn the_rim_of_a_turned_ellipse_lies_on_its_axes() {
        let direction_rad = 0.7f64;
        let shape = SlickShape::Ellipse { centre_m: [3.0, -2.0], half_axes_m: [40.0, 10.0], direction_rad };
        let film = SlickRegion { shape, ..square(4.0) };
        let (sin, cos) = direction_rad.sin_cos();
        let at = |along: f64, across: f64| {
            film.cover_at([3.0 + cos * along - sin * across, -2.0 + sin * along + cos * across])
        };
        for (along, across) in [(40.0, 0.0), (0.0, 10.0), (-40.0, 0.0), (0.0, -10.0)] {
            assert!((at(along, across) - 0.5).abs() < 1e-9);
        }
        assert_eq!((at(37.9, 0.0), at(42.1, 0.0), at(0.0, 0.0)), (1.0, 0.0, 1.0));
        let [[west, east], [south, north]] = film.shape.bounds_m();
        assert!(film.cover_at([west - 4.0, 0.0]) == 0.0 && east > 3.0 && south < -2.0 && north > -2.0);
    }
}
