//! A triangular sweep: up over the band in the first half of the pulse, down again in the second.
//!
//! ```text
//! p(t) = e^{j pi mu (t - Tc/4)^2}                          0 <= t < Tc/2 ,   mu = 2 B/Tc
//!      = e^{j 2 pi B Tc/8} e^{-j pi mu (t - 3 Tc/4)^2}     Tc/2 <= t < Tc
//! P(f) = P_up(f) + e^{j 2 pi B Tc/8} e^{-j pi f Tc} P_down(f)
//! ```
//!
//! `P_up`, `P_down`: spectra of linear sweeps of length `Tc/2` ([`Lfm`]). Frequency and phase are continuous.

use num_complex::Complex64;

use super::{Lfm, Waveform, WaveformError};
use crate::radar::phasor::phasor;
use crate::scene::radar::Sweep;

/// A triangular sweep of unit amplitude.
#[derive(Clone, Copy, Debug)]
pub struct Triangular {
    up: Lfm,
    down: Lfm,
    /// Phase of the middle of the second half.
    turn: Complex64,
}

impl Triangular {
    /// A sweep over `bandwidth_hz >= 0` and back in `duration_s > 0`.
    ///
    /// # Errors
    /// A bandwidth, a duration or their product out of range.
    pub fn new(bandwidth_hz: f64, duration_s: f64) -> Result<Self, WaveformError> {
        let of = |sweep| Lfm::new(bandwidth_hz, 0.5 * duration_s, sweep);
        let turn = phasor(bandwidth_hz * duration_s / 8.0);
        Ok(Self { up: of(Sweep::Up)?, down: of(Sweep::Down)?, turn })
    }
}

impl Waveform for Triangular {
    fn name(&self) -> &str {
        "lfm triangular"
    }

    fn duration_s(&self) -> f64 {
        2.0 * self.up.duration_s()
    }

    fn bandwidth_hz(&self) -> f64 {
        self.up.bandwidth_hz()
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        let later = self.turn * phasor(-f_hz * self.up.duration_s());
        self.up.spectrum(f_hz) + self.down.spectrum(f_hz) * later
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        let half_s = self.up.duration_s();
        if t_s < half_s { self.up.sample(t_s) } else { self.down.sample(t_s - half_s) * self.turn }
    }
}
