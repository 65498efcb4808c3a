//! A pulse as a receiver of another carrier takes it.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;

use super::frequencies::Frequencies;
use super::{InTurn, Waveform, WaveformError, by_differences};
use crate::scene::radar::Band;

/// A waveform whose carrier lies so far above that of the receiver:
///
/// ```text
/// p'(u) = p(u) e^{j 2 pi df u} ,  P'(f) = P(f - df)
/// ```
struct Offset {
    waveform: Arc<dyn Waveform>,
    offset_hz: f64,
    /// Whether it is a continuous signal or a segment of one.
    of_stream: bool,
}

/// Frequencies that are shifted together.
const TOGETHER: usize = 64;

/// A waveform whose carrier lies so far above that of the receiver; of pulses in turn, each of them.
pub(crate) fn offset(waveform: Arc<dyn Waveform>, offset_hz: f64) -> Arc<dyn Waveform> {
    let pulses = waveform.in_turn();
    if !pulses.is_empty() {
        let of = pulses.iter().map(|pulse| offset(Arc::clone(pulse), offset_hz)).collect();
        return Arc::new(InTurn::new(of));
    }
    let of_stream = waveform.is_stream();
    Arc::new(Offset { waveform, offset_hz, of_stream })
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

    fn band(&self) -> Band {
        self.waveform.band().shifted(self.offset_hz)
    }

    fn lobe_hz(&self) -> f64 {
        self.waveform.lobe_hz()
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        self.waveform.spectrum(f_hz - self.offset_hz)
    }

    fn spectra(&self, f_hz: &[f64], out: &mut [Complex64]) {
        for (f_hz, out) in f_hz.chunks(TOGETHER).zip(out.chunks_mut(TOGETHER)) {
            let mut shifted_hz = [0.0; TOGETHER];
            let shifted_hz = &mut shifted_hz[..f_hz.len()];
            shifted_hz.iter_mut().zip(f_hz).for_each(|(shifted, f_hz)| *shifted = f_hz - self.offset_hz);
            self.waveform.spectra(shifted_hz, out);
        }
    }

    fn spectra_at(&self, at: &mut Frequencies, out: &mut [Complex64]) {
        self.waveform.spectra_at(at.less(self.offset_hz), out);
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

    fn of_emissions(&self, emissions: Range<u64>) -> Result<Vec<Arc<dyn Waveform>>, WaveformError> {
        let of = |waveform| Arc::new(Self { waveform, ..*self }) as Arc<dyn Waveform>;
        Ok(self.waveform.of_emissions(emissions)?.into_iter().map(of).collect())
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
