//! The error of a block against the reference, predicted from its settings and its Doppler.

use std::f64::consts::TAU;

use super::block::BlockPaths;
use super::doppler;
use super::{Bin, Precision, Scalar, Synth};
use crate::radar::filter::ReceiveFilter;
use crate::radar::waveform::{Waveform, looked_at};

/// Predicted `|error|^2 / |echo|^2` of a pulse by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PredictedError {
    /// Images of the grid.
    pub gridding: f64,
    /// Doppler off the mean and stretch of the envelope, within a pulse.
    pub doppler: f64,
    /// Word length.
    pub rounding: f64,
}

impl PredictedError {
    /// All of it, dB.
    pub fn total_db(&self) -> f64 {
        10.0 * (self.gridding + self.doppler + self.rounding).log10()
    }
}

impl<T: Scalar> Synth<T> {
    /// Parts of the predicted error of a pulse against the reference, for the scatterer paths of a block.
    ///
    /// What the polynomials between the nodes miss is *not* among them, for it does not follow from the
    /// nodes: it belongs to whoever chooses the block. (X band, 3 km, 222 m/s, 64 pulses at 222 Hz through 4
    /// nodes: -82.5 dB, measured on the scene of the bench with [`Doppler::Taylor`].)
    pub fn predicted_error(&self, block: &BlockPaths<T>) -> PredictedError {
        let found = block.found();
        let worst = block
            .frame
            .mean_hz
            .iter()
            .map(|mean| self.predicted_error_of(*mean, found.residual_hz, found.drift_cells));
        worst.max_by(|a, b| a.total_db().total_cmp(&b.total_db())).unwrap_or_default()
    }

    /// The same for a mean Doppler, the largest Doppler off it (Hz), and the largest change of place over
    /// half a block (cells).
    pub fn predicted_error_of(&self, mean_hz: f64, residual_hz: f64, drift_cells: f64) -> PredictedError {
        let filter = ReceiveFilter::new(self.sample_rate_hz);
        // Bins beyond some thousand add nothing.
        let step = (self.bins.len() / 1024).max(1);
        let of = |pulse: &dyn Waveform| {
            let bins = self.bins.iter().step_by(step);
            let power = |bin: &Bin| {
                let power = pulse.spectrum(bin.f_hz + mean_hz).norm_sqr() * filter.response(bin.f_hz).powi(2);
                (bin.f_hz / self.cells_per_s, power)
            };
            let band: Vec<(f64, f64)> = bins.map(power).collect();
            let all: f64 = band.iter().map(|(_, power)| power).sum();
            let mean_square_cycles = if all > 0.0 {
                band.iter().map(|(cycles, power)| cycles * cycles * power).sum::<f64>() / all
            } else {
                0.0
            };
            let rounding = rounding_power::<T>(drift_cells, mean_square_cycles);
            [self.kernel.gridding_error_power(&band), rounding]
        };
        let pulses = looked_at(self.waveform.as_ref());
        let [gridding, rounding] =
            pulses.into_iter().map(of).fold([0.0; 2], |most, own| [0, 1].map(|n| f64::max(most[n], own[n])));
        let doppler = doppler::error_power(
            (self.settings.doppler, self.settings.envelope),
            self.waveform.as_ref(),
            self.carrier_hz,
            self.sample_rate_hz,
            self.fft_len,
            mean_hz,
            residual_hz,
        );
        PredictedError { gridding, doppler, rounding }
    }
}

/// Relative power of rounding.
///
/// A place that moves over `d` cells is rounded to `2^-p d` four times (three products and a sum, each
/// uniform within half of that, not all at their largest: counted as such), that is a phase of
/// `2 pi x cycles` per cell. Phase, phasor, weights and amplitude add some twelve roundings of `2^-p`. Sums
/// of many scatterer paths are carried by what is already in a cell, `2^-p sqrt(adds)` of its rms at most in
/// a random walk; 256 is taken.
fn rounding_power<T: Scalar>(drift_cells: f64, mean_square_cycles: f64) -> f64 {
    let unit: f64 = match T::PRECISION {
        Precision::Single => 2f64.powi(-24),
        Precision::Double => 2f64.powi(-53),
    };
    let place = 4.0 * (drift_cells + 1.0).powi(2) / 3.0 * TAU * TAU * mean_square_cycles;
    unit * unit * (place + 12.0 + 256.0)
}
