//! Directional spreading.
//!
//! * **Two-fold**: `Phi = [1 + e cos 2 phi]/(2 pi)`, the centro-symmetric form of Elfouhaily and of Fung
//!   and Lee, phi from the wind. Its wave version keeps the half circle of waves that travel with the
//!   wind, doubled.
//! * **Cosine power**: `Phi = Gamma(s+1) / (2 sqrt(pi) Gamma(s+1/2)) cos^2s(phi/2)`; s from Mitsuyasu et
//!   al. 1975, `s = smax (f/fp)^5` below the peak and `smax (f/fp)^-2.5` above,
//!   `smax = 11.5 (2 pi fp U10/g)^-2.5`, or constant, or matched to Elfouhaily's crosswind ratio:
//!   symmetrised, crosswind over upwind is `2^(1-s)`, hence `s = 1 + log2[(1+Delta)/(1-Delta)]`.
//!
//! Mitsuyasu's buoy measured no waves far from the peak. Carried there his `s` tends to 0: a sea from
//! everywhere but for a cusp to zero exactly upwind. So it has a floor, the `s` that Elfouhaily's crosswind
//! ratio gives short waves (his `Delta` without the term of the long ones),
//! `s >= 3/2 + (0.26/ln 2) (u*/cm) (cm/c)^2.5`; at and about the peak Mitsuyasu's own is larger.
//!
//! Limits: s in 0 to 1000.
//!
//! ```
//! use nereus::sea::spectrum::{spreading::Heading, WaveVector};
//! let north = Heading::new(std::f64::consts::FRAC_PI_2);
//! let [up, down] = [1.0, -1.0].map(|y| north.cosine_power(1.0, WaveVector::new(0.0, y)));
//! assert!((up - 1.0 / std::f64::consts::PI).abs() < 1e-12 && down < 1e-12);
//! ```

use super::{SpectrumError, WaveVector};
use crate::scene::water::Dispersion;
use crate::scene::water::Spreading;
use crate::sea::GRAVITY_MPS2;

/// Largest exponent of a cosine power.
pub const MAX_EXPONENT: f64 = 1000.0;

/// The direction a wave system travels to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    cos: f64,
    sin: f64,
}

impl Heading {
    /// From an azimuth, radians from +x counter-clockwise.
    pub fn new(azimuth_rad: f64) -> Self {
        Self { cos: azimuth_rad.cos(), sin: azimuth_rad.sin() }
    }

    /// Components of K along the heading and to its left, rad/m.
    pub fn resolve(self, k: WaveVector) -> [f64; 2] {
        [self.cos * k.x_rad_m + self.sin * k.y_rad_m, self.cos * k.y_rad_m - self.sin * k.x_rad_m]
    }

    /// `[1 + e cos 2 phi]/(2 pi)`, 1/rad.
    pub fn two_fold(self, e: f64, k: WaveVector) -> f64 {
        let [along, across] = self.resolve(k);
        let k2 = along * along + across * across;
        let cos_2phi = if k2 > 0.0 { (along * along - across * across) / k2 } else { 0.0 };
        (1.0 + e * cos_2phi) / std::f64::consts::TAU
    }

    /// The half of the `cos 2 phi` form that travels with the wind, doubled; on the border as it is.
    pub fn two_fold_wave(self, e: f64, k: WaveVector) -> f64 {
        let [along, _] = self.resolve(k);
        if along > 0.0 {
            2.0 * self.two_fold(e, k)
        } else if along < 0.0 {
            0.0
        } else {
            self.two_fold(e, k)
        }
    }

    /// Second harmonic of the `cos 2 phi` form: see [`super::Spectrum::second_harmonic`].
    pub fn two_fold_harmonic(self, e: f64) -> [f64; 2] {
        self.rotate_harmonic(0.5 * e)
    }

    /// `cos^2s(phi/2)`, normalised, 1/rad.
    pub fn cosine_power(self, s: f64, k: WaveVector) -> f64 {
        let magnitude = k.magnitude();
        let cos_phi = if magnitude > 0.0 { self.resolve(k)[0] / magnitude } else { 1.0 };
        // cos^2(phi/2) = (1 + cos phi)/2; the bracket guards against a rounding beyond +-1.
        let base = (0.5 * (1.0 + cos_phi)).clamp(0.0, 1.0);
        let norm = (libm::lgamma(s + 1.0) - libm::lgamma(s + 0.5)).exp();
        norm / (2.0 * std::f64::consts::PI.sqrt()) * base.powf(s)
    }

    /// Second harmonic of the cosine power, `s (s-1) / [(s+1)(s+2)]` about the heading.
    pub fn cosine_power_harmonic(self, s: f64) -> [f64; 2] {
        self.rotate_harmonic(s * (s - 1.0) / ((s + 1.0) * (s + 2.0)))
    }

    fn rotate_harmonic(self, about_heading: f64) -> [f64; 2] {
        let cos_2 = self.cos * self.cos - self.sin * self.sin;
        let sin_2 = 2.0 * self.sin * self.cos;
        [about_heading * cos_2, about_heading * sin_2]
    }
}

/// How the exponent of a wind sea's cosine power depends on K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Exponent {
    Constant(f64),
    Mitsuyasu { largest: f64, peak_rad_m: f64, ustar_mps: f64 },
    LikeElfouhaily { ustar_mps: f64, peak_speed_mps: f64 },
}

/// Exponent of waves that only the wind of the moment raises: `s = 1 + log2[(1+Delta)/(1-Delta)]` with
/// `Delta = tanh[ln 2/4 + 0.13 (u*/cm) (cm/c)^2.5]`, and `(1 + tanh x)/(1 - tanh x) = e^2x`.
fn of_short_waves(k_rad_m: f64, ustar_mps: f64) -> f64 {
    1.0 + 2.0
        * std::f64::consts::LOG2_E
        * crate::sea::spectrum::spreading::short_wave_spread(k_rad_m, ustar_mps)
}

impl Exponent {
    /// For a sea with its spectral peak at `peak_rad_m`.
    pub(super) fn new(
        spreading: Spreading,
        u10_mps: f64,
        ustar_mps: f64,
        peak_rad_m: f64,
    ) -> Result<Self, SpectrumError> {
        match spreading {
            Spreading::Constant(exponent) if (0.0..=MAX_EXPONENT).contains(&exponent) => {
                Ok(Self::Constant(exponent))
            }
            Spreading::Constant(exponent) => Err(SpectrumError::Exponent { exponent }),
            Spreading::Mitsuyasu => {
                let omega_peak = (GRAVITY_MPS2 * peak_rad_m).sqrt();
                let largest = 11.5 * (omega_peak * u10_mps / GRAVITY_MPS2).powf(-2.5);
                Ok(Self::Mitsuyasu { largest: largest.clamp(0.0, MAX_EXPONENT), peak_rad_m, ustar_mps })
            }
            Spreading::LikeElfouhaily => {
                let peak_speed_mps = crate::sea::spectrum::spreading::phase_speed_mps(peak_rad_m);
                Ok(Self::LikeElfouhaily { ustar_mps, peak_speed_mps })
            }
        }
    }

    /// s at K.
    pub(super) fn at(self, k_rad_m: f64) -> f64 {
        match self {
            Self::Constant(s) => s,
            Self::Mitsuyasu { largest, peak_rad_m, ustar_mps } => {
                // (f/fp)^2 = K/Kp in deep water.
                let ratio = k_rad_m / peak_rad_m;
                let measured = largest * if ratio < 1.0 { ratio.powf(2.5) } else { ratio.powf(-1.25) };
                measured.max(of_short_waves(k_rad_m, ustar_mps)).min(MAX_EXPONENT)
            }
            Self::LikeElfouhaily { ustar_mps, peak_speed_mps } => {
                let delta = crate::sea::spectrum::spreading::delta(k_rad_m, ustar_mps, peak_speed_mps);
                (1.0 + ((1.0 + delta) / (1.0 - delta)).log2()).clamp(0.0, MAX_EXPONENT)
            }
        }
    }
}

/// Fetches that may be given, m.
pub const FETCH_RANGE_M: [f64; 2] = [100.0, 1e7];

/// Phase speed with surface tension, m/s.
pub fn phase_speed_mps(k_rad_m: f64) -> f64 {
    Dispersion { capillary: true, depth_m: None }.phase_speed_mps(k_rad_m)
}

/// Elfouhaily's crosswind parameter Delta at K, for a friction velocity and a peak phase speed.
pub fn delta(k_rad_m: f64, ustar_mps: f64, peak_speed_mps: f64) -> f64 {
    let c = phase_speed_mps(k_rad_m);
    (0.25 * std::f64::consts::LN_2
        + 4.0 * power(c / peak_speed_mps)
        + 0.13 * (ustar_mps / SLOWEST_MPS) * power(SLOWEST_MPS / c))
    .tanh()
}

/// What the hyperbolic tangent of [`delta`] is of without the term of the long waves.
pub(super) fn short_wave_spread(k_rad_m: f64, ustar_mps: f64) -> f64 {
    let c = phase_speed_mps(k_rad_m);
    0.25 * std::f64::consts::LN_2 + 0.13 * (ustar_mps / SLOWEST_MPS) * power(SLOWEST_MPS / c)
}

/// Phase speed at km as the authors round it, m/s.
pub(super) const SLOWEST_MPS: f64 = 0.23;

/// `ratio^2.5`.
fn power(ratio: f64) -> f64 {
    ratio * ratio * ratio.sqrt()
}
