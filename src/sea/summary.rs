//! A realised sea in figures.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::scene::Patch;
use crate::sea::realise::Realised;
use crate::sea::spectrum::sampling::{BAND_STEP, least_length_m};
use crate::sea::surface::Fields;

/// A realised sea in figures.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Time, s after pulse 0.
    pub time_s: f64,
    /// Seed of its waves.
    pub seed: u64,
    /// Facets, East and North.
    pub facets: [usize; 2],
    /// Side of a facet, m.
    pub facet_m: f64,
    /// Wind at 10 m, m/s.
    pub wind_10m_mps: f64,
    /// Four times the standard deviation of the height over the map.
    pub significant_height_m: f64,
    /// The same over all seeds, for the waves that the grid holds.
    pub expected_significant_height_m: f64,
    /// Root mean square of the slopes of the map, East and North.
    pub rms_slope: [f64; 2],
    /// The same over all seeds.
    pub expected_rms_slope: [f64; 2],
    /// Of the spectrum; none for still water.
    pub peak_wavelength_m: Option<f64>,
    /// Side that the patch should have for this spectrum.
    pub least_length_m: f64,
}

/// Root of the mean square. The mean is zero: no wave of a grid has another.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

impl Summary {
    /// Those of a map at a time, s.
    pub fn new(realised: &Realised, patch: &Patch, fields: &Fields<f64>, time_s: f64) -> Self {
        let Realised { wind, spectrum, surface } = realised;
        let expected = surface.expected();
        let peak_rad_m = spectrum.peak_rad_m();
        Self {
            time_s,
            seed: surface.seed(),
            facets: patch.facets,
            facet_m: patch.facet_m,
            wind_10m_mps: wind.u10_mps,
            significant_height_m: 4.0 * rms(&fields.height_m),
            expected_significant_height_m: 4.0 * expected.variance_m2.sqrt(),
            rms_slope: [rms(&fields.slope[0]), rms(&fields.slope[1])],
            expected_rms_slope: expected.slope_variance.map(f64::sqrt),
            peak_wavelength_m: (peak_rad_m > 0.0).then(|| TAU / peak_rad_m),
            least_length_m: least_length_m(spectrum.as_ref(), BAND_STEP),
        }
    }
}
