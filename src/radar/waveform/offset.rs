//! A pulse as a receiver of another carrier takes it.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex64;

use super::Waveform;

/// A waveform whose carrier lies so far above that of the receiver:
///
/// ```text
/// p'(u) = p(u) e^{j 2 pi df u} ,  P'(f) = P(f - df)
/// ```
pub(crate) struct Offset {
    waveform: Arc<dyn Waveform>,
    offset_hz: f64,
}

impl Offset {
    pub fn new(waveform: Arc<dyn Waveform>, offset_hz: f64) -> Self {
        Self { waveform, offset_hz }
    }
}

impl Waveform for Offset {
    fn name(&self) -> &str {
        self.waveform.name()
    }

    fn duration_s(&self) -> f64 {
        self.waveform.duration_s()
    }

    fn bandwidth_hz(&self) -> f64 {
        self.waveform.bandwidth_hz()
    }

    fn lobe_hz(&self) -> f64 {
        self.waveform.lobe_hz()
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

    fn sweep_middle_hz(&self) -> f64 {
        self.waveform.sweep_middle_hz() + self.offset_hz
    }
}
