//! A pulse as a receiver of another carrier takes it.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex64;

use super::{Waveform, WaveformError, by_differences};

/// A waveform whose carrier lies so far above that of the receiver:
///
/// ```text
/// p'(u) = p(u) e^{j 2 pi df u} ,  P'(f) = P(f - df)
/// ```
pub(crate) struct Offset {
    waveform: Arc<dyn Waveform>,
    offset_hz: f64,
    /// Whether it is a continuous signal or a segment of one.
    of_stream: bool,
}

impl Offset {
    pub fn new(waveform: Arc<dyn Waveform>, offset_hz: f64) -> Self {
        let of_stream = waveform.is_stream();
        Self { waveform, offset_hz, of_stream }
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

    fn moment_spectrum(&self, f_hz: f64) -> Complex64 {
        if self.of_stream {
            return self.waveform.moment_spectrum(f_hz - self.offset_hz);
        }
        by_differences(self, f_hz)
    }

    fn of_emission(&self, emission: u64) -> Result<Option<Arc<dyn Waveform>>, WaveformError> {
        let own = self.waveform.of_emission(emission)?;
        Ok(own.map(|own| Arc::new(Self { waveform: own, ..*self }) as Arc<dyn Waveform>))
    }

    fn steadiness(&self, emissions: u64) -> f64 {
        self.waveform.steadiness(emissions)
    }

    fn is_stream(&self) -> bool {
        self.waveform.is_stream()
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
