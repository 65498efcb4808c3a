//! The water of a scene: which kind of surface a facet is, and what facets of each kind return.
//!
//! Kinds are numbered: 0 clean, then the slicks in the order of the scene. A facet belongs to the slick that
//! covers most of its centre (the first of equals), to the share it covers; where none does, it is clean.
//!
//! Spectrum, slope variances and the local axes of facets are counted from the direction the wind blows
//! towards, so that turning scene, wind and radar together changes nothing.
//!
//! ```
//! use std::sync::Arc;
//! use nereus::scattering::water::{Sight, SpectrumPath, WaterScattering};
//! use nereus::scene::sea::FacetScattering;
//! use nereus::scene::water::{Development, WindProfile};
//! use nereus::sea::spectrum::Elfouhaily;
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.5)?;
//! let spectrum = Arc::new(Elfouhaily::new(&wind, Development::default())?);
//! let sight = Sight { carrier_hz: 10e9, facet_m: 1.0, seed: 1, spectrum: SpectrumPath::Exact };
//! let settings = FacetScattering::default();
//! let water = WaterScattering::new(&settings, 20.0, 35.0, &[], &wind, spectrum, sight)?;
//! assert_eq!((water.kinds(), water.mechanisms()), (1, 2));
//! assert_eq!(water.kind_at([10.0, 20.0]), (0, 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::facets::{Facets, LengthError, Phases};
use super::kind::Kind;
use super::kind::clean::Clean;
use super::kind::slick::Slick;
use super::permittivity::{Model, PermittivityError, SeaWater};
use super::speckle::Speckle;
use super::spectrum_table::SpectrumTable;
use super::two_scale::{Medium, Moments, Settings, TwoScale};
use crate::scene::sea::{FacetScattering, Permittivity, SlickRegion};
use crate::sea::spectrum::{Spectrum, WaveVector};
use crate::sea::wind::Wind;

/// What the water is looked at with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Side of a facet, m.
    pub facet_m: f64,
    /// Seed of the facets' phases.
    pub seed: u64,
    /// How the spectrum that scatters is found.
    pub spectrum: SpectrumPath,
}

/// How facets find the spectrum at their Bragg wave vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpectrumPath {
    /// From its equation.
    #[default]
    Exact,
    /// From a table ([`super::spectrum_table`]), whose error is measured when it is made.
    Tabulated,
}

/// Facets of one kind, a batch at a time.
trait Batch: Send + Sync {
    fn scatter(&self, facets: &Facets, phases: Phases, out: [&mut [Complex64]; 4])
    -> Result<(), LengthError>;
}

impl<K: Kind + Send + Sync, F: Fn(f64, f64) -> f64 + Send + Sync> Batch for TwoScale<K, F> {
    fn scatter(
        &self,
        facets: &Facets,
        phases: Phases,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        facets.scatter(self, phases, out)
    }
}

/// Every kind of water of a scene.
pub struct WaterScattering {
    kinds: Vec<Box<dyn Batch>>,
    /// Regions of kinds 1 onwards, with their bounds.
    regions: Vec<(SlickRegion, [[f64; 2]; 2])>,
    phases: Phases,
    speckle: Speckle,
    seed: u64,
    mechanisms: usize,
    permittivity: Complex64,
    cut_radpm: Option<f64>,
    moments: Moments,
    spectrum_error: f64,
}

/// One kind, asking the spectrum itself or a table of it.
fn batch<K, F>(
    settings: Settings,
    medium: Medium,
    kind: K,
    psi: F,
    table: Option<&Arc<SpectrumTable<F>>>,
) -> Box<dyn Batch>
where
    K: Kind + Send + Sync + 'static,
    F: Fn(f64, f64) -> f64 + Send + Sync + 'static,
{
    match table {
        None => Box::new(TwoScale::new(settings, medium, kind, psi)),
        Some(table) => {
            let table = Arc::clone(table);
            Box::new(TwoScale::new(settings, medium, kind, move |x, y| table.psi(x, y)))
        }
    }
}

impl WaterScattering {
    /// Prepares every kind: permittivity, moments of the unresolved waves.
    ///
    /// # Errors
    /// Water or carrier outside the range of the permittivity model.
    pub fn new(
        settings: &FacetScattering,
        temperature_c: f64,
        salinity_psu: f64,
        slicks: &[SlickRegion],
        wind: &Wind,
        spectrum: Arc<dyn Spectrum>,
        sight: Sight,
    ) -> Result<Self, PermittivityError> {
        let model = match settings.permittivity {
            Permittivity::MeissnerWentz => Model::MeissnerWentz2012,
            Permittivity::KleinSwift => Model::KleinSwift1977,
        };
        let sea_water = SeaWater { temperature_c, salinity_gpkg: salinity_psu };
        let permittivity = model.permittivity(sight.carrier_hz, sea_water)?;
        let (sin, cos) = wind.direction_rad.sin_cos();
        let medium = Medium {
            carrier_hz: sight.carrier_hz,
            permittivity,
            wind_12p5_mps: wind.u12_5_mps,
            downwind_rad: 0.0,
            resolved_radpm: std::f64::consts::PI / sight.facet_m,
            axis: DVec3::new(cos, sin, 0.0),
        };
        let two_scale = Settings {
            splitting: settings.splitting,
            cut_radpm: settings.cut_radpm,
            tilt_average: settings.tilt_average,
            gram_charlier: settings.gram_charlier,
        };
        let psi = || {
            let spectrum = Arc::clone(&spectrum);
            move |along: f64, across: f64| {
                spectrum.symmetric_m4(WaveVector::new(cos * along - sin * across, sin * along + cos * across))
            }
        };
        let clean = TwoScale::new(two_scale, medium, Clean, psi());
        let (mechanisms, cut_radpm, moments) = (1 + clean.tilts(), clean.cut_radpm(), clean.moments(0.0));
        let table = match sight.spectrum {
            SpectrumPath::Exact => None,
            SpectrumPath::Tabulated => {
                Some(SpectrumTable::for_bragg(psi(), medium.wavenumber_radpm(), cut_radpm))
            }
        };
        let spectrum_error = table.as_ref().map_or(0.0, SpectrumTable::worst_relative_error);
        let table = table.map(Arc::new);
        let mut kinds: Vec<Box<dyn Batch>> = vec![batch(two_scale, medium, Clean, psi(), table.as_ref())];
        let mut regions = Vec::with_capacity(slicks.len());
        for slick in slicks {
            let kind = Slick { elasticity_npm: slick.elasticity_npm };
            kinds.push(batch(two_scale, medium, kind, psi(), table.as_ref()));
            let rim_m = 0.5 * slick.rim_m;
            let bounds = slick.shape.bounds_m().map(|[from, to]| [from - rim_m, to + rim_m]);
            regions.push((slick.clone(), bounds));
        }
        let speckle =
            settings.decorrelation_s.map_or(Speckle::Frozen, |time_s| Speckle::Decorrelating { time_s });
        Ok(Self {
            kinds,
            regions,
            phases: settings.phases,
            speckle,
            seed: sight.seed,
            mechanisms,
            permittivity,
            cut_radpm,
            moments,
            spectrum_error,
        })
    }

    /// Kinds of surface, the clean one included.
    pub fn kinds(&self) -> usize {
        self.kinds.len()
    }

    /// Random phasors that a facet needs.
    pub fn mechanisms(&self) -> usize {
        self.mechanisms
    }

    /// Relative permittivity of the water.
    pub fn permittivity(&self) -> Complex64 {
        self.permittivity
    }

    /// Wave number that divides specular points from Bragg scattering, rad/m, if there is one.
    pub fn cut_radpm(&self) -> Option<f64> {
        self.cut_radpm
    }

    /// Moments of the unresolved waves of clean water.
    pub fn moments(&self) -> Moments {
        self.moments
    }

    /// Largest relative error of the spectrum that facets ask; 0 for the exact one.
    pub fn spectrum_error(&self) -> f64 {
        self.spectrum_error
    }

    /// Whether phasors change in time.
    pub fn decorrelates(&self) -> bool {
        self.speckle != Speckle::Frozen
    }

    /// Kind of the facet centred on a place, and the share of it that the kind covers.
    pub fn kind_at(&self, place_m: [f64; 2]) -> (usize, f64) {
        let mut most = (0, 0.0);
        for (kind, (region, bounds)) in (1..).zip(&self.regions) {
            let near = [0, 1].into_iter().all(|i| (bounds[i][0]..=bounds[i][1]).contains(&place_m[i]));
            if near {
                let cover = region.cover_at(place_m);
                if cover > most.1 {
                    most = (kind, cover);
                }
            }
        }
        most
    }

    /// Phasors of the facet with a global key, `t_s` after pulse 0.
    pub fn phasors(&self, key: [i64; 2], t_s: f64, out: &mut [Complex64]) {
        self.speckle.phasors(self.seed, (key[0], key[1]), t_s, out);
    }

    /// Scattering matrices of a batch of one kind, sqrt(m^2), in the order `vv, vh, hv, hh`.
    ///
    /// # Errors
    /// An array whose length does not fit the number of facets.
    pub fn scatter(
        &self,
        kind: usize,
        facets: &Facets,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        self.kinds[kind].scatter(facets, self.phases, out)
    }
}
