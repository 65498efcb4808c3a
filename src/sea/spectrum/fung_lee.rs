//! The spectrum of Fung and Lee 1982, and its directional function.
//!
//! Gravity, K < 4 rad/m: `S = (1.4e-3/K^3) exp[-0.74 g^2/(K^2 U19.5^4)]`, peak at `0.7024 g/U19.5^2`.
//! Capillary, K >= 4 rad/m: `S = a0 (1 + 3k^2) [k (1 + k^2)]^(-(p+1)/2)`, `k = K/363 rad/m`,
//! `p = 5 - log10(u* in cm/s)`, `a0 = 0.875 (2 pi)^(p-1) 981^((1-p)/2) 3.63^(-(p+1)/2) 1e-6 m^3`.
//! u* is Cardone's for U19.5.
//!
//! Directional: `Phi = 1/(2 pi) + a1 (1 - exp(-b K^2)) cos 2 phi`, `b = 1.5e-4 m^2`,
//! `a1 = (1/pi) (1-R)/(1+R)/(1-D)`, `R = (0.003 + 1.92e-3 U12.5)/(3.16e-3 U12.5)`,
//! `D = [integral of K^2 S exp(-b K^2)] / [integral of K^2 S]` over this S, so that crosswind over upwind
//! mean square slope is R (Cox and Munk). a1 is kept within 0 and 1/(2 pi).
//!
//! Limits: a spectrum for backscatter: its gravity part holds 0.35 of the energy of Pierson and
//! Moskowitz, its capillary part about twice the slopes of Cox and Munk. Zero in a calm.
//!
//! ```
//! use nereus::scene::water::WindProfile;
//! use nereus::sea::spectrum::FungLee;
//! use nereus::sea::wind::Wind;
//! let sea = FungLee::new(&Wind::from_speed(10.0, 12.5, WindProfile::Cardone, 0.0)?);
//! assert!((sea.directional().a1 - 0.0673).abs() < 1e-4);
//! # Ok::<(), nereus::sea::wind::WindError>(())
//! ```

use std::f64::consts::{PI, TAU};

use super::spreading::Heading;
use super::{Spectrum, WaveVector, in_range};
use crate::sea::GRAVITY_MPS2;
use crate::sea::wind::Wind;

/// Wave number at which the branches meet, rad/m.
pub const BRANCH_RAD_M: f64 = 4.0;
/// Scale of the capillary branch, rad/m.
pub const CAPILLARY_SCALE_RAD_M: f64 = 363.0;
const GRAVITY_LEVEL: f64 = 1.4e-3;
pub(super) const GRAVITY_DECAY: f64 = 0.74;
/// b of the directional function, m^2.
const DIRECTIONAL_SCALE_M2: f64 = 1.5e-4;
/// Band and points (log spaced) over which D is integrated.
const SLOPE_BAND_RAD_M: [f64; 2] = [1e-3, 2e4];
const SLOPE_POINTS: usize = 40_001;

/// Exponent p and level a0 (m^3) of the capillary branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capillary {
    /// Exponent p.
    pub p: f64,
    /// Level a0, m^3.
    pub a0_m3: f64,
}

impl Capillary {
    /// For a friction velocity, m/s (positive).
    pub fn new(ustar_mps: f64) -> Self {
        let p = 5.0 - (100.0 * ustar_mps).log10();
        let a0_m3 = 0.875
            * TAU.powf(p - 1.0)
            * 981f64.powf(0.5 * (1.0 - p))
            * (0.01 * CAPILLARY_SCALE_RAD_M).powf(-0.5 * (p + 1.0))
            * 1e-6;
        Self { p, a0_m3 }
    }

    /// S, m^3, for K > 0.
    pub fn omnidirectional_m3(self, k_rad_m: f64) -> f64 {
        let k = k_rad_m / CAPILLARY_SCALE_RAD_M;
        self.a0_m3 * (1.0 + 3.0 * k * k) * (k * (1.0 + k * k)).powf(-0.5 * (self.p + 1.0))
    }
}

/// The gravity form `(level/K^3) exp[-0.74 g^2/(K^2 U^4)]`, m^3, shared with Pierson and Moskowitz.
pub(super) fn gravity_m3(level: f64, k_rad_m: f64, u19_5_mps: f64) -> f64 {
    let x = GRAVITY_MPS2 / (k_rad_m * u19_5_mps * u19_5_mps);
    let cutoff = (-GRAVITY_DECAY * x * x).exp();
    if cutoff > 0.0 { level / (k_rad_m * k_rad_m * k_rad_m) * cutoff } else { 0.0 }
}

/// Peak of the gravity form, rad/m.
pub(super) fn gravity_peak_rad_m(u19_5_mps: f64) -> f64 {
    (2.0 * GRAVITY_DECAY / 3.0).sqrt() * GRAVITY_MPS2 / (u19_5_mps * u19_5_mps)
}

/// Fung and Lee's directional function for one wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    /// Mean square slope of the spectrum, total.
    pub mean_square_slope: f64,
    /// D, the part of it in waves that are hardly directional.
    pub d: f64,
    /// Crosswind over upwind mean square slope.
    pub r: f64,
    /// Amplitude a1, 1/rad.
    pub a1: f64,
}

impl Directional {
    /// Amplitude of `cos 2 phi` at K, times 2 pi.
    pub(super) fn two_fold(&self, k_rad_m: f64) -> f64 {
        // 1 - exp(-x) without cancellation.
        -TAU * self.a1 * (-DIRECTIONAL_SCALE_M2 * k_rad_m * k_rad_m).exp_m1()
    }
}

/// Fung and Lee's spectrum for one wind.
#[derive(Clone, Debug)]
pub struct FungLee {
    calm: bool,
    heading: Heading,
    u19_5_mps: f64,
    capillary: Capillary,
    directional: Directional,
    peak_rad_m: f64,
}

impl FungLee {
    /// The spectrum of a wind.
    pub fn new(wind: &Wind) -> Self {
        let calm = wind.is_calm();
        // Any wind does for a sea that is zero throughout.
        let (u19_5_mps, u12_5_mps, ustar_mps) =
            if calm { (1.0, 1.0, 0.1) } else { (wind.u19_5_mps, wind.u12_5_mps, wind.ustar_cardone_mps) };
        let mut spectrum = Self {
            calm,
            heading: Heading::new(wind.direction_rad),
            u19_5_mps,
            capillary: Capillary::new(ustar_mps),
            directional: Directional { mean_square_slope: 0.0, d: 0.0, r: 1.0, a1: 0.0 },
            peak_rad_m: 0.0,
        };
        if !calm {
            spectrum.directional = spectrum.integrate_directional(u12_5_mps);
            let peak = gravity_peak_rad_m(u19_5_mps);
            spectrum.peak_rad_m = if peak < BRANCH_RAD_M
                && spectrum.gravity_m3(peak) >= spectrum.capillary.omnidirectional_m3(BRANCH_RAD_M)
            {
                peak
            } else {
                BRANCH_RAD_M
            };
        }
        spectrum
    }

    fn integrate_directional(&self, u12_5_mps: f64) -> Directional {
        let [low, high] = SLOPE_BAND_RAD_M;
        let step = (high / low).ln() / (SLOPE_POINTS - 1) as f64;
        let (mut slope, mut weighted) = (0.0, 0.0);
        for i in 0..SLOPE_POINTS {
            let k = low * (i as f64 * step).exp();
            let end = if i == 0 || i == SLOPE_POINTS - 1 { 0.5 } else { 1.0 };
            let term = end * k * k * k * self.omnidirectional_m3(k);
            slope += term;
            weighted += term * (-DIRECTIONAL_SCALE_M2 * k * k).exp();
        }
        let d = weighted / slope;
        let r = (0.003 + 1.92e-3 * u12_5_mps) / (3.16e-3 * u12_5_mps);
        let a1 = ((1.0 - r) / (1.0 + r) / (1.0 - d) / PI).clamp(0.0, 0.5 / PI);
        Directional { mean_square_slope: slope * step, d, r, a1 }
    }

    /// The gravity branch at any K, m^3.
    pub fn gravity_m3(&self, k_rad_m: f64) -> f64 {
        gravity_m3(GRAVITY_LEVEL, k_rad_m, self.u19_5_mps)
    }

    /// The capillary branch, at any K.
    pub fn capillary(&self) -> Capillary {
        self.capillary
    }

    /// The directional function.
    pub fn directional(&self) -> Directional {
        self.directional
    }
}

impl Spectrum for FungLee {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        if self.calm || !in_range(k_rad_m) {
            0.0
        } else if k_rad_m < BRANCH_RAD_M {
            self.gravity_m3(k_rad_m)
        } else {
            self.capillary.omnidirectional_m3(k_rad_m)
        }
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.two_fold_wave(self.directional.two_fold(k.magnitude()), k)
    }

    fn symmetric_spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.two_fold(self.directional.two_fold(k.magnitude()), k)
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        self.heading.two_fold_harmonic(self.directional.two_fold(k_rad_m))
    }

    fn peak_rad_m(&self) -> f64 {
        self.peak_rad_m
    }
}
