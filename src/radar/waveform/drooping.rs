//! A pulse whose transmitter runs down: its amplitude falls linearly from the begin to the end.
//!
//! `p_d(t) = p(t) (1 - d t/T_c)` , `P_d(f) = (1 - d/2) P(f) - (d/T_c) M(f)` , `d = 1 - 10^(-droop/20)` ,
//!
//! `M` the spectrum of `(t - T_c/2) p(t)`: exact for every pulse. The begin of the pulse keeps its amplitude.
//!
//! ```
//! use nereus::radar::waveform::{Drooping, Lfm, Waveform};
//! use nereus::scene::radar::Sweep;
//! use std::sync::Arc;
//! let chirp = Arc::new(Lfm::new(20e6, 2e-6, Sweep::Up)?);
//! let pulse = Drooping::new(chirp, 1.0);
//! let ratio_db = 20.0 * (pulse.sample(1e-9).norm() / pulse.sample(2e-6 - 1e-9).norm()).log10();
//! assert!((ratio_db - 1.0).abs() < 2e-3);
//! # Ok::<(), nereus::radar::waveform::WaveformError>(())
//! ```

use std::sync::Arc;

use num_complex::Complex64;

use super::Waveform;

/// A pulse that falls by so much.
#[derive(Clone)]
pub struct Drooping {
    of: Arc<dyn Waveform>,
    fall: f64,
}

impl Drooping {
    /// Of a pulse that ends so many dB below its begin.
    pub fn new(of: Arc<dyn Waveform>, droop_db: f64) -> Self {
        Self { of, fall: 1.0 - 10f64.powf(-droop_db / 20.0) }
    }
}

impl Waveform for Drooping {
    fn name(&self) -> &str {
        self.of.name()
    }

    fn duration_s(&self) -> f64 {
        self.of.duration_s()
    }

    fn bandwidth_hz(&self) -> f64 {
        self.of.bandwidth_hz()
    }

    fn lobe_hz(&self) -> f64 {
        self.of.lobe_hz()
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        let slope = self.fall / self.of.duration_s();
        self.of.spectrum(f_hz) * (1.0 - 0.5 * self.fall) - self.of.moment_spectrum(f_hz) * slope
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        self.of.sample(t_s) * (1.0 - self.fall * t_s / self.of.duration_s())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::radar::waveform::{Coded, Lfm, Nlfm, Triangular};
    use crate::scene::radar::{Code, Sweep, Taper};

    /// The spectrum is the transform of the samples, by Simpson's rule: every kind of pulse.
    #[test]
    fn the_spectrum_is_that_of_the_samples() {
        let pulses: [Arc<dyn Waveform>; 5] = [
            Arc::new(Lfm::new(10e6, 3e-6, Sweep::Down).unwrap()),
            Arc::new(Triangular::new(6e6, 4e-6).unwrap()),
            Arc::new(Nlfm::new(10e6, 3e-6, Sweep::Up, Taper::Hamming).unwrap()),
            Arc::new(Coded::plain(1e-6).unwrap()),
            Arc::new(Coded::new(Code::Barker { chips: 13 }, 0.2e-6).unwrap()),
        ];
        for pulse in pulses {
            let pulse = Drooping::new(pulse, 3.0);
            let (lasts_s, parts) = (pulse.duration_s(), 26 * 2000);
            let h = lasts_s / f64::from(parts);
            for f_hz in [-7e6, -1.3e6, 0.0, 0.4e6, 5.1e6] {
                // Midpoints: no sample falls on an edge of a chip.
                let sum: Complex64 = (0..parts)
                    .map(|n| {
                        let t = h * (f64::from(n) + 0.5);
                        pulse.sample(t) * Complex64::cis(-TAU * f_hz * t)
                    })
                    .sum();
                let off = (sum * h - pulse.spectrum(f_hz)).norm() / lasts_s;
                assert!(off < 2e-6, "{} {f_hz}: {off}", pulse.name());
            }
        }
    }
}
