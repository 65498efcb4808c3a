//! The unified spectrum of Elfouhaily, Chapron, Katsaros and Vandemark 1997.
//!
//! `S(K) = (Bl + Bh)/K^3`, with `kp = g Omega_c^2 / U10^2`, `km = 370 rad/m`, `cm = 0.23 m/s`,
//! `c = sqrt[(g/K)(1 + (K/km)^2)]`, `Omega = U10/cp`, `L = exp[-1.25 (kp/K)^2]`:
//!
//! * long waves `Bl = (ap/2)(cp/c) L J exp{-(Omega/sqrt 10)[sqrt(K/kp) - 1]}`, `ap = 6e-3 sqrt(Omega)`,
//!   `J = gam^G`, `G = exp{-[sqrt(K/kp) - 1]^2 / (2 s^2)}`, `gam = 1.7 + 6 log10(Omega_c)` above 1 else 1.7,
//!   `s = 0.08 (1 + 4 Omega_c^-3)`;
//! * short waves `Bh = (am/2)(cm/c) L exp{-0.25 (K/km - 1)^2}`, `am = 0.01 [1 + ln(u*/cm)]` below cm,
//!   `0.01 [1 + 3 ln(u*/cm)]` above, never negative. The factor L on Bh follows McDaniel 2001.
//!
//! Spreading `1 + Delta cos 2 phi` with `Delta = tanh{ln 2/4 + 4 (c/cp)^2.5 + 0.13 (u*/cm)(cm/c)^2.5}`. Fetch
//! x: `Omega_c = 0.84 tanh[(g x / (U10^2 2.2e4))^0.4]^-0.75`. u* is Wu's.
//!
//! Limits: Omega_c 0.84 to 5; zero in a calm.
//!
//! ```
//! use nereus::scene::water::{Development, WindProfile};
//! use nereus::sea::spectrum::{moments::Moments, Elfouhaily};
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_speed(10.0, 10.0, WindProfile::Cardone, 0.0)?;
//! let sea = Elfouhaily::new(&wind, Development::default())?;
//! let moments = Moments::of(&sea, [3.46e-3, 2e4]);
//! assert!((moments.significant_height_m() - 2.603).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::spreading::Heading;
use super::spreading::{SLOWEST_MPS, delta, phase_speed_mps};
use super::{Spectrum, SpectrumError, WaveVector, cells, in_range};
use crate::scene::water::Development;
use crate::sea::GRAVITY_MPS2;
use crate::sea::dispersion::CAPILLARY_PEAK_RAD_M;
use crate::sea::wind::Wind;

/// Elfouhaily's spectrum for one wind.
#[derive(Clone, Debug)]
pub struct Elfouhaily {
    calm: bool,
    heading: Heading,
    ustar_mps: f64,
    enhancement_rad_m: f64,
    peak_speed_mps: f64,
    /// `Omega / sqrt 10`.
    decay: f64,
    half_alpha_long: f64,
    half_alpha_short: f64,
    ln_gamma: f64,
    /// `1 / (2 s^2)`.
    sharpness: f64,
    peak_rad_m: f64,
}

/// Inverse wave age of a fetch, m, at a wind, m/s.
pub fn inverse_wave_age(fetch_m: f64, u10_mps: f64) -> f64 {
    let fetch = GRAVITY_MPS2 * fetch_m / (u10_mps * u10_mps);
    0.84 * (fetch / 2.2e4).powf(0.4).tanh().powf(-0.75)
}

impl Elfouhaily {
    /// The spectrum of a wind and a state of development.
    ///
    /// # Errors
    /// An inverse wave age or fetch out of range, or a sea too young for its fetch.
    pub fn new(wind: &Wind, development: Development) -> Result<Self, SpectrumError> {
        let calm = wind.is_calm();
        // Any wind does for a sea that is zero throughout; its parameters are still checked.
        let u10_mps = if calm { 1.0 } else { wind.u10_mps };
        let age = match development {
            Development::InverseWaveAge(age) if (0.84..=5.0).contains(&age) => age,
            Development::InverseWaveAge(inverse_wave_age) => {
                return Err(SpectrumError::InverseWaveAge { inverse_wave_age });
            }
            Development::Fetch(fetch_m) => {
                let [shortest, longest] = crate::sea::spectrum::FETCH_RANGE_M;
                if !(shortest..=longest).contains(&fetch_m) {
                    return Err(SpectrumError::Fetch { fetch_m });
                }
                let age = inverse_wave_age(fetch_m, u10_mps);
                if age > 5.0 {
                    return Err(SpectrumError::Young { fetch_m, u10_mps, inverse_wave_age: age });
                }
                age
            }
        };
        let ustar_mps = if calm { 0.0 } else { wind.ustar_wu_mps };
        let enhancement_rad_m = GRAVITY_MPS2 / (u10_mps * u10_mps) * age * age;
        let peak_speed_mps = phase_speed_mps(enhancement_rad_m);
        let omega = u10_mps / peak_speed_mps;
        let gamma = if age <= 1.0 { 1.7 } else { 1.7 + 6.0 * age.log10() };
        let s = 0.08 * (1.0 + 4.0 / (age * age * age));
        let ln_ratio = (ustar_mps / SLOWEST_MPS).ln();
        let alpha_short = 0.01 * if ustar_mps < SLOWEST_MPS { 1.0 + ln_ratio } else { 1.0 + 3.0 * ln_ratio };
        let mut spectrum = Self {
            calm,
            heading: Heading::new(wind.direction_rad),
            ustar_mps,
            enhancement_rad_m,
            peak_speed_mps,
            decay: omega / 10f64.sqrt(),
            half_alpha_long: 0.5 * 6e-3 * omega.sqrt(),
            half_alpha_short: 0.5 * alpha_short.max(0.0),
            ln_gamma: gamma.ln(),
            sharpness: 0.5 / (s * s),
            peak_rad_m: 0.0,
        };
        if !calm {
            let around = [0.2 * enhancement_rad_m, 5.0 * enhancement_rad_m];
            spectrum.peak_rad_m = cells::peak_rad_m(|k| spectrum.omnidirectional_m3(k), around);
        }
        Ok(spectrum)
    }

    /// Curvature spectra of the long and of the short waves, dimensionless.
    pub fn curvature(&self, k_rad_m: f64) -> [f64; 2] {
        if self.calm || !in_range(k_rad_m) {
            return [0.0; 2];
        }
        let kp = self.enhancement_rad_m;
        let c = phase_speed_mps(k_rad_m);
        let root = (k_rad_m / kp).sqrt() - 1.0;
        let cutoff = -1.25 * (kp / k_rad_m) * (kp / k_rad_m);
        let peak = (-root * root * self.sharpness).exp() * self.ln_gamma;
        let long =
            self.half_alpha_long * (self.peak_speed_mps / c) * (cutoff + peak - self.decay * root).exp();
        let detuning = k_rad_m / CAPILLARY_PEAK_RAD_M - 1.0;
        let short = self.half_alpha_short * (SLOWEST_MPS / c) * (cutoff - 0.25 * detuning * detuning).exp();
        [long, short]
    }

    /// Crosswind parameter Delta at K.
    pub fn delta(&self, k_rad_m: f64) -> f64 {
        if !in_range(k_rad_m) {
            return 0.0;
        }
        delta(k_rad_m, self.ustar_mps, self.peak_speed_mps)
    }
}

impl Spectrum for Elfouhaily {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        let [long, short] = self.curvature(k_rad_m);
        let sum = long + short;
        if sum > 0.0 { sum / (k_rad_m * k_rad_m * k_rad_m) } else { 0.0 }
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.two_fold_wave(self.delta(k.magnitude()), k)
    }

    fn symmetric_spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.two_fold(self.delta(k.magnitude()), k)
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        self.heading.two_fold_harmonic(self.delta(k_rad_m))
    }

    fn peak_rad_m(&self) -> f64 {
        self.peak_rad_m
    }
}
