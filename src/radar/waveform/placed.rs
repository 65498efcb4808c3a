//! A pulse as a receiver of another carrier takes it, on a transform that others share.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex64;

use super::Waveform;

/// A waveform whose carrier lies so far above that of the receiver,
///
/// ```text
/// p'(u) = p(u) e^{j 2 pi df u} ,  P'(f) = P(f - df)
/// ```
///
/// and which takes as much room in a transform as the longest of those that are received together, so that
/// their spectra have the same bins.
pub(crate) struct Placed {
    waveform: Arc<dyn Waveform>,
    offset_hz: f64,
    longest_s: f64,
}

impl Placed {
    pub fn new(waveform: Arc<dyn Waveform>, offset_hz: f64, longest_s: f64) -> Self {
        Self { waveform, offset_hz, longest_s }
    }
}

impl Waveform for Placed {
    fn name(&self) -> &str {
        self.waveform.name()
    }

    fn duration_s(&self) -> f64 {
        self.waveform.duration_s()
    }

    fn bandwidth_hz(&self) -> f64 {
        self.waveform.bandwidth_hz()
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        self.waveform.spectrum(f_hz - self.offset_hz)
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        self.waveform.sample(t_s) * Complex64::cis(TAU * (self.offset_hz * t_s).fract())
    }

    fn sweep_rate_hz_per_s(&self) -> Option<f64> {
        self.waveform.sweep_rate_hz_per_s()
    }

    fn span_samples(&self, sample_rate_hz: f64) -> usize {
        let longest = (self.longest_s * sample_rate_hz * (1.0 - 4.0 * f64::EPSILON)).ceil() as usize;
        self.waveform.span_samples(sample_rate_hz).max(longest)
    }
}
