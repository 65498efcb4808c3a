//! Moments of a spectrum: height and slopes.
//!
//! `sigma_h^2 = integral of S dK`, `Hs = 4 sigma_h`, `mss = integral of K^2 S dK`; along a direction alpha
//! the slope variance is `integral of K^2 S [1 + c cos 2 alpha + s sin 2 alpha]/2 dK`, `(c, s)` the second
//! harmonic of the spreading. Simpson's rule in ln K, 40001 points (so a band edge may cut the spectrum
//! anywhere).
//!
//! ```
//! use nereus::scene::water::WindProfile;
//! use nereus::sea::spectrum::{moments::Moments, FungLee};
//! use nereus::sea::wind::Wind;
//! let sea = FungLee::new(&Wind::from_speed(10.0, 10.0, WindProfile::Cardone, 0.0)?);
//! let moments = Moments::of(&sea, [1e-3, 2e4]);
//! let [along, across] = [0.0, std::f64::consts::FRAC_PI_2].map(|a| moments.slope_variance(a));
//! assert!((along + across - moments.mean_square_slope).abs() < 1e-12);
//! # Ok::<(), nereus::sea::wind::WindError>(())
//! ```

use super::Spectrum;

/// Points of the integration.
const POINTS: usize = 40_001;

/// Height and slope moments of a band of waves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Variance of the height, m^2.
    pub variance_m2: f64,
    /// Mean square slope, along and across together.
    pub mean_square_slope: f64,
    /// Second harmonic of the slope variance about +x: its cos and sin parts.
    pub harmonic: [f64; 2],
}

impl Moments {
    /// Moments of the waves in a band, rad/m; zero for an empty band.
    pub fn of(spectrum: &dyn Spectrum, [low_rad_m, high_rad_m]: [f64; 2]) -> Self {
        let mut moments = Self::default();
        let low_rad_m = low_rad_m.max(f64::MIN_POSITIVE);
        let high_rad_m = high_rad_m.min(super::MAX_WAVE_NUMBER_RAD_M);
        if high_rad_m <= low_rad_m {
            return moments;
        }
        let step = (high_rad_m / low_rad_m).ln() / (POINTS - 1) as f64;
        for i in 0..POINTS {
            let k = low_rad_m * (i as f64 * step).exp();
            let s = spectrum.omnidirectional_m3(k);
            if s <= 0.0 {
                continue;
            }
            let simpson = match i {
                0 => 1.0,
                _ if i == POINTS - 1 => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let height = simpson * step / 3.0 * k * s;
            let slope = height * k * k;
            let [c, q] = spectrum.second_harmonic(k);
            moments.variance_m2 += height;
            moments.mean_square_slope += slope;
            moments.harmonic[0] += slope * c;
            moments.harmonic[1] += slope * q;
        }
        moments
    }

    /// Significant wave height, m.
    pub fn significant_height_m(&self) -> f64 {
        4.0 * self.variance_m2.sqrt()
    }

    /// Variance of the slope along an azimuth, radians from +x.
    pub fn slope_variance(&self, azimuth_rad: f64) -> f64 {
        let (sin, cos) = (2.0 * azimuth_rad).sin_cos();
        0.5 * (self.mean_square_slope + self.harmonic[0] * cos + self.harmonic[1] * sin)
    }
}
