//! JONSWAP (Hasselmann et al. 1973): a wind sea of limited fetch.
//!
//! `S_w = a g^2 w^-5 exp[-1.25 (wp/w)^4] 3.3^r`, `r = exp[-(w-wp)^2/(2 s^2 wp^2)]`, `s = 0.07` up to the
//! peak and 0.09 above, `a = 0.076 (U10^2/(F g))^0.22`, `wp = 22 (g^2/(U10 F))^(1/3)`;
//! `S(K) = S_w (1/2) sqrt(g/K)`, `w^2 = g K` (deep water). Spreading is a cosine power about the wind (see
//! [`super::spreading`]).
//!
//! Limits: fetch 100 m to 1e7 m; past full development the fetch law keeps growing. Zero in a calm.
//!
//! ```
//! use nereus::scene::water::{Spreading, WindProfile};
//! use nereus::sea::spectrum::{Jonswap, Spectrum};
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_speed(10.0, 10.0, WindProfile::Cardone, 0.0)?;
//! let sea = Jonswap::new(&wind, 100e3, Spreading::default())?;
//! let omega_peak: f64 = 22.0 * (9.81f64.powi(2) / (10.0 * 100e3)).cbrt();
//! assert!((sea.peak_rad_m() * 9.81 / omega_peak.powi(2) - 1.0).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::FETCH_RANGE_M;
use super::spreading::{Exponent, Heading};
use super::{Spectrum, SpectrumError, WaveVector, cells, in_range};
use crate::scene::water::Spreading;
use crate::sea::GRAVITY_MPS2;
use crate::sea::wind::Wind;

const PEAK_ENHANCEMENT: f64 = 3.3;

/// JONSWAP's shape `(w/wp)^-5 exp[-1.25 (wp/w)^4] gamma^r` at the ratio `w/wp`.
pub(super) fn shape(ratio: f64, ln_gamma: f64) -> f64 {
    let inverse = 1.0 / ratio;
    let cutoff = -1.25 * inverse.powi(4);
    if cutoff < -745.0 {
        return 0.0;
    }
    let width = if ratio <= 1.0 { 0.07 } else { 0.09 };
    let offset = (ratio - 1.0) / width;
    let r = (-0.5 * offset * offset).exp();
    inverse.powi(5) * (cutoff + r * ln_gamma).exp()
}

/// JONSWAP for one wind and fetch.
#[derive(Clone, Debug)]
pub struct Jonswap {
    calm: bool,
    heading: Heading,
    /// `a g^2 wp^-5`, m^2 s.
    level_m2s: f64,
    omega_peak_rad_s: f64,
    exponent: Exponent,
    peak_rad_m: f64,
}

impl Jonswap {
    /// The spectrum of a wind and a fetch, m.
    ///
    /// # Errors
    /// A wind or fetch out of range.
    pub fn new(wind: &Wind, fetch_m: f64, spreading: Spreading) -> Result<Self, SpectrumError> {
        if !(FETCH_RANGE_M[0]..=FETCH_RANGE_M[1]).contains(&fetch_m) {
            return Err(SpectrumError::Fetch { fetch_m });
        }
        let calm = wind.is_calm();
        // Any wind does for a sea that is zero throughout.
        let u10_mps = if calm { 1.0 } else { wind.u10_mps };
        let g = GRAVITY_MPS2;
        let level = 0.076 * (u10_mps * u10_mps / (fetch_m * g)).powf(0.22);
        let omega_peak_rad_s = 22.0 * (g * g / (u10_mps * fetch_m)).cbrt();
        let nominal_rad_m = omega_peak_rad_s * omega_peak_rad_s / g;
        let mut spectrum = Self {
            calm,
            heading: Heading::new(wind.direction_rad),
            level_m2s: level * g * g / omega_peak_rad_s.powi(5),
            omega_peak_rad_s,
            exponent: Exponent::new(spreading, u10_mps, wind.ustar_wu_mps, nominal_rad_m)?,
            peak_rad_m: 0.0,
        };
        if !calm {
            let around = [0.5 * nominal_rad_m, 2.0 * nominal_rad_m];
            spectrum.peak_rad_m = cells::peak_rad_m(|k| spectrum.omnidirectional_m3(k), around);
        }
        Ok(spectrum)
    }

    /// Frequency spectrum, m^2 s, at an angular frequency, rad/s.
    pub fn frequency_m2s(&self, omega_rad_s: f64) -> f64 {
        if self.calm || omega_rad_s <= 0.0 {
            return 0.0;
        }
        self.level_m2s * shape(omega_rad_s / self.omega_peak_rad_s, PEAK_ENHANCEMENT.ln())
    }
}

impl Spectrum for Jonswap {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        if self.calm || !in_range(k_rad_m) {
            return 0.0;
        }
        let density_m2s = self.frequency_m2s((GRAVITY_MPS2 * k_rad_m).sqrt());
        if density_m2s > 0.0 { density_m2s * 0.5 * (GRAVITY_MPS2 / k_rad_m).sqrt() } else { 0.0 }
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.cosine_power(self.exponent.at(k.magnitude()), k)
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        self.heading.cosine_power_harmonic(self.exponent.at(k_rad_m))
    }

    fn peak_rad_m(&self) -> f64 {
        self.peak_rad_m
    }
}
