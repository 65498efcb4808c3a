//! What sea it is, in numbers.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::scene::Patch;
use crate::sea::realise::Realised;
use crate::sea::spectrum::sampling::{BAND_STEP, least_length_m};
use crate::sea::surface::Fields;

/// What sea it is.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    pub(super) time_s: f64,
    pub(super) seed: u64,
    pub(super) facets: [usize; 2],
    pub(super) facet_m: f64,
    pub(super) wind_10m_mps: f64,
    /// Four times the standard deviation of the height over the map.
    pub(super) significant_height_m: f64,
    /// The same over all seeds, for the waves that the grid holds.
    pub(super) expected_significant_height_m: f64,
    pub(super) rms_slope: [f64; 2],
    pub(super) expected_rms_slope: [f64; 2],
    /// Of the spectrum; none for still water.
    pub(super) peak_wavelength_m: Option<f64>,
    /// Side that the patch should have for this spectrum.
    pub(super) least_length_m: f64,
}

/// Root of the mean square. The mean is zero: no wave of a grid has another.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

impl Summary {
    pub(super) fn new(realised: &Realised, patch: &Patch, fields: &Fields<f64>, time_s: f64) -> Self {
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

    /// For people.
    pub(super) fn lines(&self) -> Vec<String> {
        let [nx, ny] = self.facets;
        let size_m = self.facets.map(|n| n as f64 * self.facet_m);
        let [sx, sy] = self.rms_slope;
        let [ex, ey] = self.expected_rms_slope;
        let mut lines = vec![
            format!(
                "sea at {} s: {nx} x {ny} facets of {} m, seed {}, wind {:.1} m/s at 10 m",
                self.time_s, self.facet_m, self.seed, self.wind_10m_mps
            ),
            format!(
                "significant height {:.2} m (expected {:.2} m), rms slopes {sx:.4} East, {sy:.4} North (expected {ex:.4}, {ey:.4})",
                self.significant_height_m, self.expected_significant_height_m
            ),
        ];
        let Some(peak_m) = self.peak_wavelength_m else {
            lines.push("the spectrum is that of still water".to_owned());
            return lines;
        };
        let [width_m, height_m] = size_m;
        lines.push(format!(
            "peak wavelength {peak_m:.1} m; patch {width_m} x {height_m} m, at least {:.0} m a side hold the peak of the spectrum",
            self.least_length_m
        ));
        if size_m[0].min(size_m[1]) < self.least_length_m {
            lines.push(format!(
                "warning: the patch is shorter than {:.0} m: few waves near the peak fit it, and its height varies much with the seed",
                self.least_length_m
            ));
        }
        lines
    }
}
