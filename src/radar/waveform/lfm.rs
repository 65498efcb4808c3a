//! Linear frequency modulation, and the unmodulated rectangular pulse (`B = 0`).
//!
//! Pulse, baseband: `p(t) = exp(j pi mu (t - Tc/2)^2)` for `0 <= t < Tc`, else 0; `mu = +-B/Tc` (Hz/s).
//!
//! Spectrum. With `b = B Tc`, `v = |f| Tc`, the Fresnel auxiliary function `w` (see `fresnel`) and
//! `u1 = (v + b/2) sqrt(2/b)`, `u2 = |v - b/2| sqrt(2/b)`, for a rising sweep
//!
//! ```text
//! P(f) = Tc e^{-j pi f Tc} J ,
//! J sqrt(2b) = [v < b/2] (1+j) e^{-j pi v^2/b}  -+ e^{j pi (b/4 - v)} w(u2)  -  e^{j pi (b/4 + v)} w(u1)
//! ```
//!
//! upper sign inside the band (`v < b/2`); a falling sweep has `conj J`. This is the textbook difference of
//! two Fresnel integrals with the point of stationary phase and the two edges of the pulse written apart, so
//! that far outside the band, or with a tiny `b`, no large phase `v^2/b` appears and nothing cancels. Three
//! leading terms differ by `O(1/sqrt(2b))` from their sum, so for `b < 1e-6` the series in `b` is used
//! instead: `J = sinc(v) + j (pi b/8) int_{-1}^{1} y^2 cos(pi v y) dy`, error below `(pi b/4)^2/10 = 6e-14`.
//!
//! Accuracy relative to the peak: 1e-11 or better for `B Tc` up to 1e4 (rounding of `b/8` turns of phase
//! grows as `1e-16 B Tc`).

use std::f64::consts::PI;

use num_complex::Complex64;

use super::fresnel;
use super::{Waveform, WaveformError};
use crate::radar::phasor::phasor;
use crate::scene::radar::Sweep;

/// Below this time-bandwidth product the spectrum is a series in it.
const SMALL_PRODUCT: f64 = 1e-6;

/// A linear sweep of unit amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lfm {
    bandwidth_hz: f64,
    duration_s: f64,
    sweep: Sweep,
    /// `b = B Tc`.
    product: f64,
    /// `sqrt(2/b)`.
    to_fresnel: f64,
    /// `Tc / sqrt(2b)`.
    scale_s: f64,
    /// `e^{j pi b/4}`.
    edge: Complex64,
}

impl Lfm {
    /// A sweep over `bandwidth_hz >= 0` in `duration_s > 0`.
    ///
    /// # Errors
    /// A bandwidth, a duration or their product out of range.
    pub fn new(bandwidth_hz: f64, duration_s: f64, sweep: Sweep) -> Result<Self, WaveformError> {
        if !(bandwidth_hz >= 0.0 && bandwidth_hz.is_finite()) {
            return Err(WaveformError::Bandwidth { bandwidth_hz });
        }
        if !(duration_s > 0.0 && duration_s.is_finite()) {
            return Err(WaveformError::Duration { duration_s });
        }
        let product = bandwidth_hz * duration_s;
        if product > super::MAX_TIME_BANDWIDTH {
            return Err(WaveformError::TimeBandwidth { product });
        }
        // Built here rather than within the first pulse.
        fresnel::table();
        Ok(Self {
            bandwidth_hz,
            duration_s,
            sweep,
            product,
            to_fresnel: (2.0 / product.max(SMALL_PRODUCT)).sqrt(),
            scale_s: duration_s / (2.0 * product.max(SMALL_PRODUCT)).sqrt(),
            edge: phasor(product / 8.0),
        })
    }

    /// `Tc J` by the series in `b`.
    fn small(&self, v: f64) -> Complex64 {
        let a = PI * v;
        // int_{-1}^{1} y^2 cos(a y) dy; the closed form loses a^-3 digits, but is multiplied by b < 1e-6.
        let (zeroth, second) = if a < 1e-2 {
            (1.0 - a * a / 6.0 + a.powi(4) / 120.0, 2.0 / 3.0 - a * a / 5.0)
        } else {
            let (sin, cos) = (phasor(0.5 * v).im, phasor(0.5 * v).re);
            (sin / a, 2.0 * (sin / a + 2.0 * cos / (a * a) - 2.0 * sin / (a * a * a)))
        };
        self.duration_s * Complex64::new(zeroth, PI * self.product / 8.0 * second)
    }
}

impl Waveform for Lfm {
    fn name(&self) -> &str {
        match self.sweep {
            Sweep::Up => "lfm up",
            Sweep::Down => "lfm down",
        }
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn bandwidth_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn sweep_rate_hz_per_s(&self) -> Option<f64> {
        let rate = self.bandwidth_hz / self.duration_s;
        // A plain pulse does not sweep.
        (self.product >= SMALL_PRODUCT).then_some(match self.sweep {
            Sweep::Up => rate,
            Sweep::Down => -rate,
        })
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        let signed = f_hz * self.duration_s;
        let v = signed.abs();
        // e^{j pi v}
        let turn = phasor(0.5 * v);
        let up = if self.product < SMALL_PRODUCT {
            self.small(v)
        } else {
            let b = self.product;
            let pieces = fresnel::table();
            let far = turn * fresnel::auxiliary(pieces, (v + 0.5 * b) * self.to_fresnel);
            let near = turn.conj() * fresnel::auxiliary(pieces, (v - 0.5 * b).abs() * self.to_fresnel);
            let sum = if v < 0.5 * b {
                Complex64::new(1.0, 1.0) * phasor(-0.5 * v * v / b) - self.edge * (near + far)
            } else {
                self.edge * (near - far)
            };
            self.scale_s * sum
        };
        let centred = match self.sweep {
            Sweep::Up => up,
            Sweep::Down => up.conj(),
        };
        // e^{-j pi f Tc}: the pulse starts at 0, not at -Tc/2.
        centred * if signed < 0.0 { turn } else { turn.conj() }
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        if !(0.0..self.duration_s).contains(&t_s) {
            return Complex64::ZERO;
        }
        let y = t_s / self.duration_s - 0.5;
        let turns = 0.5 * self.product * y * y;
        match self.sweep {
            Sweep::Up => phasor(turns),
            Sweep::Down => phasor(-turns),
        }
    }
}
