//! The spectrum of Pierson and Moskowitz 1964: a fully developed sea.
//!
//! `S(K) = (8.1e-3/2) K^-3 exp[-0.74 g^2/(K^2 U19.5^4)]`; `Hs = 0.0213 U19.5^2`. Spreading is a cosine power
//! about the wind (see [`super::spreading`]).
//!
//! Limits: gravity waves only: slopes of waves shorter than about 0.3 m are not those of the sea. Zero in a
//! calm.
//!
//! ```
//! use nereus::scene::water::{Spreading, WindProfile};
//! use nereus::sea::spectrum::{moments::Moments, PiersonMoskowitz};
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_speed(10.0, 19.5, WindProfile::Cardone, 0.0)?;
//! let sea = PiersonMoskowitz::new(&wind, Spreading::Mitsuyasu)?;
//! let height_m = Moments::of(&sea, [1e-3, 1e3]).significant_height_m();
//! assert!((height_m / 2.13 - 1.0).abs() < 2e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::fung_lee::{gravity_m3, gravity_peak_rad_m};
use super::spreading::{Exponent, Heading};
use super::{Spectrum, SpectrumError, WaveVector, in_range};
use crate::scene::water::Spreading;
use crate::sea::wind::Wind;

const LEVEL: f64 = 8.1e-3 / 2.0;

/// Pierson and Moskowitz's spectrum for one wind.
#[derive(Clone, Debug)]
pub struct PiersonMoskowitz {
    calm: bool,
    heading: Heading,
    u19_5_mps: f64,
    exponent: Exponent,
}

impl PiersonMoskowitz {
    /// The spectrum of a wind.
    ///
    /// # Errors
    /// A wind out of range.
    pub fn new(wind: &Wind, spreading: Spreading) -> Result<Self, SpectrumError> {
        let calm = wind.is_calm();
        // Any wind does for a sea that is zero throughout.
        let u19_5_mps = if calm { 1.0 } else { wind.u19_5_mps };
        let u10_mps = if calm { 1.0 } else { wind.u10_mps };
        let peak_rad_m = gravity_peak_rad_m(u19_5_mps);
        let exponent = Exponent::new(spreading, u10_mps, wind.ustar_wu_mps, peak_rad_m)?;
        Ok(Self { calm, heading: Heading::new(wind.direction_rad), u19_5_mps, exponent })
    }
}

impl Spectrum for PiersonMoskowitz {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        if self.calm || !in_range(k_rad_m) {
            return 0.0;
        }
        gravity_m3(LEVEL, k_rad_m, self.u19_5_mps)
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.cosine_power(self.exponent.at(k.magnitude()), k)
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        self.heading.cosine_power_harmonic(self.exponent.at(k_rad_m))
    }

    fn peak_rad_m(&self) -> f64 {
        if self.calm { 0.0 } else { gravity_peak_rad_m(self.u19_5_mps) }
    }
}
