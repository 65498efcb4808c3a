//! The receive filter: anti-alias filter of the complex (I/Q) receiver.
//!
//! ```text
//! H(f) = 1                                        |f| <= 0.4 fs
//!      = [1 + cos(10 pi (|f|/fs - 0.4))] / 2      0.4 fs < |f| < 0.5 fs
//!      = 0                                        |f| >= 0.5 fs
//! ```
//!
//! `f` baseband frequency, Hz; `fs` complex sample rate, Hz. Real and even: zero phase, so it moves
//! no delay. Its impulse response, the raised cosine
//! `0.9 fs sinc(0.9 fs t) cos(0.1 pi fs t) / (1 - (0.2 fs t)^2)`, falls as `t^-3`.
//!
//! Noise bandwidth, in closed form: `B_n = int |H|^2 df = 0.8 fs + 2 (0.1 fs) (3/8) = 0.875 fs`
//! (the mean of `cos^4` over a raised-cosine edge is 3/8).
//!
//! ```
//! use nereus::radar::filter::ReceiveFilter;
//! let filter = ReceiveFilter::new(100e6);
//! assert_eq!(filter.response(-40e6), 1.0);
//! assert!((filter.response(45e6) - 0.5).abs() < 1e-15);
//! assert_eq!(filter.response(50e6), 0.0);
//! assert_eq!(filter.noise_bandwidth_hz(), 87.5e6);
//! ```

use std::f64::consts::PI;

/// Samples beyond either end of a pulse over which the filter's ringing is kept.
pub const RINGING_SAMPLES: usize = 32;

/// Where the flat part ends, in sample rates.
const FLAT_TO: f64 = 0.4;
/// Where the response ends, in sample rates.
const ZERO_FROM: f64 = 0.5;

/// The receive filter of a given sample rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiveFilter {
    sample_rate_hz: f64,
}

impl ReceiveFilter {
    /// The filter in front of a converter of this complex sample rate.
    pub fn new(sample_rate_hz: f64) -> Self {
        Self { sample_rate_hz }
    }

    /// `H(f)`, dimensionless, real.
    pub fn response(&self, f_hz: f64) -> f64 {
        let x = f_hz.abs() / self.sample_rate_hz;
        if x <= FLAT_TO {
            1.0
        } else if x < ZERO_FROM {
            0.5 * (1.0 + (PI * (x - FLAT_TO) / (ZERO_FROM - FLAT_TO)).cos())
        } else {
            0.0
        }
    }

    /// Where the flat part ends, and where the response does, Hz.
    pub fn edges_hz(&self) -> [f64; 2] {
        [FLAT_TO, ZERO_FROM].map(|edge| edge * self.sample_rate_hz)
    }

    /// `int |H(f)|^2 df`, Hz.
    pub fn noise_bandwidth_hz(&self) -> f64 {
        (2.0 * FLAT_TO + 2.0 * (ZERO_FROM - FLAT_TO) * 3.0 / 8.0) * self.sample_rate_hz
    }
}

/// Baseband frequency of bin `k` of an `n`-point transform at `sample_rate_hz`, Hz: the upper half of
/// the bins is negative.
pub fn bin_frequency_hz(k: usize, n: usize, sample_rate_hz: f64) -> f64 {
    let signed = if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
    signed * sample_rate_hz / n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_bandwidth_is_the_integral_of_the_squared_response() {
        for fs in [1.0, 12.5e6, 100e6, 2.4e9] {
            let filter = ReceiveFilter::new(fs);
            // Midpoint rule over +-0.5 fs: with a multiple of 10 cells the kinks lie on cell borders and the
            // error is h^2/24 [d|H|^2/df] = 0 plus fourth order: below 1e-12 at 10^5 cells; sum rounding
            // 1e-12.
            let cells = 100_000;
            let sum: f64 = (0..cells)
                .map(|i| filter.response(((f64::from(i) + 0.5) / f64::from(cells) - 0.5) * fs).powi(2))
                .sum();
            let quadrature = sum * fs / f64::from(cells);
            let error = (filter.noise_bandwidth_hz() / quadrature - 1.0).abs();
            println!("fs {fs}: relative error {error:.1e}");
            assert!(error < 2e-12, "{error}");
        }
    }

    #[test]
    fn bins_of_even_and_odd_transforms() {
        let f: Vec<f64> = (0..4).map(|k| bin_frequency_hz(k, 4, 4.0)).collect();
        assert_eq!(f, [0.0, 1.0, -2.0, -1.0]);
        let f: Vec<f64> = (0..5).map(|k| bin_frequency_hz(k, 5, 5.0)).collect();
        assert_eq!(f, [0.0, 1.0, 2.0, -2.0, -1.0]);
    }
}
