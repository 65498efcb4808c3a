//! An image in figures.

use serde::Serialize;

use super::Image;
use crate::processor::multilook::{levels, percentile};

/// The image of one channel in figures.
#[derive(Clone, Debug, Serialize)]
pub struct ImageFigures {
    /// Name of the channel.
    pub name: String,
    /// Pulses in use.
    pub pulses: usize,
    /// Doppler band about the aim from which a pixel takes its pulses, Hz; none: all pulses.
    pub doppler_hz: Option<f64>,
    /// Length of a cell in range and in cross-range in the middle of the image, m, by theory.
    pub cell_m: Option<[f64; 2]>,
    /// Mean power, dBW; none where the image has no power.
    pub mean_dbw: Option<f64>,
    /// Power of the brightest pixel, dBW.
    pub peak_dbw: Option<f64>,
    /// Amplitude that a share of the pixels do not exceed, sqrt(W).
    pub percentile_amplitude: Option<f64>,
    /// `<I^2>/<I>^2` of the power: 2 for speckle.
    pub contrast: f64,
}

impl Image {
    /// The image in figures, of power averaged over `looks` by `looks` pixels; `percent` of the pixels do not
    /// exceed [`ImageFigures::percentile_amplitude`].
    pub fn figures(&self, looks: usize, percent: f64) -> ImageFigures {
        let (power, _) = self.power(looks);
        let [mean, peak, contrast] = levels(&power);
        let db = |p: f64| (p > 0.0).then(|| 10.0 * p.log10());
        ImageFigures {
            name: self.channel.clone(),
            pulses: self.pulses,
            doppler_hz: self.doppler_hz,
            cell_m: self.support.map(|s| s.cuts().map(|(_, cell)| cell)),
            mean_dbw: db(mean),
            peak_dbw: db(peak),
            percentile_amplitude: percentile(&power, percent).map(f64::sqrt),
            contrast,
        }
    }
}
