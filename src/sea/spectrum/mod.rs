//! Wave spectra.
//!
//! `sigma_h^2 = integral of Psi(Kx, Ky) over the whole plane`, `Psi(K, phi) = S(K) Phi(K, phi) / K` (m^4),
//! `S` the omnidirectional spectrum (m^3), `Phi` the spreading (1/rad, its integral over the circle is 1).
//! Angles from +x counter-clockwise, K in the direction of travel.
//!
//! Two conventions, both given by every spectrum:
//! * **wave** (propagating): energy at K travels along +K. Surface synthesis uses it.
//! * **symmetric** (image): `[Psi(K) + Psi(-K)]/2`. Scattering uses it.
//!
//! A spectrum of one's own is one type that gives [`Spectrum::omnidirectional_m3`],
//! [`Spectrum::spreading_per_rad`] and [`Spectrum::peak_rad_m`]:
//!
//! ```
//! use nereus::sea::spectrum::{Spectrum, WaveVector};
//!
//! /// Waves of 2 cm^2 variance, all near 1 rad/m, from everywhere.
//! #[derive(Debug)]
//! struct Ring;
//! impl Spectrum for Ring {
//!     fn omnidirectional_m3(&self, k: f64) -> f64 {
//!         if (0.9..1.1).contains(&k) { 1e-3 } else { 0.0 }
//!     }
//!     fn spreading_per_rad(&self, _: WaveVector) -> f64 {
//!         0.5 / std::f64::consts::PI
//!     }
//!     fn peak_rad_m(&self) -> f64 {
//!         1.0
//!     }
//! }
//! let [low, high] = Ring.half_power_band_rad_m();
//! assert!((low - 0.9).abs() < 1e-9 && (high - 1.1).abs() < 1e-9);
//! ```
//!
//! Limits: K up to 1e8 rad/m; zero outside.

mod cells;
pub mod elfouhaily;
pub mod fung_lee;
pub mod jonswap;
pub mod light_wind;
pub mod measured;
pub mod mix;
pub mod moments;
pub mod pierson_moskowitz;
pub mod sampling;
pub mod spreading;
pub mod swell;
pub mod tail;

use std::fmt::Debug;
use std::ops::Neg;

use crate::scene::water::{SpectrumKind, Water};
use crate::sea::dispersion::DepthError;
use crate::sea::wind::Wind;

pub use elfouhaily::Elfouhaily;
pub use fung_lee::FungLee;
pub use jonswap::Jonswap;
pub use light_wind::LightWind;
pub use measured::Measured;
pub use mix::{Combined, Mix};
pub use pierson_moskowitz::PiersonMoskowitz;
pub use spreading::FETCH_RANGE_M;
pub use swell::SwellTrain;
pub use tail::Tailed;

/// Largest wave number at which a spectrum is evaluated, rad/m.
pub const MAX_WAVE_NUMBER_RAD_M: f64 = 1e8;

/// A wave vector, rad/m, scene axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaveVector {
    /// Component along +x, rad/m.
    pub x_rad_m: f64,
    /// Component along +y, rad/m.
    pub y_rad_m: f64,
}

impl WaveVector {
    /// From components, rad/m.
    pub fn new(x_rad_m: f64, y_rad_m: f64) -> Self {
        Self { x_rad_m, y_rad_m }
    }

    /// From wave number (rad/m) and direction of travel (radians from +x counter-clockwise).
    pub fn polar(k_rad_m: f64, azimuth_rad: f64) -> Self {
        Self::new(k_rad_m * azimuth_rad.cos(), k_rad_m * azimuth_rad.sin())
    }

    /// Wave number, rad/m.
    pub fn magnitude(self) -> f64 {
        (self.x_rad_m * self.x_rad_m + self.y_rad_m * self.y_rad_m).sqrt()
    }
}

impl Neg for WaveVector {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x_rad_m, -self.y_rad_m)
    }
}

/// A directional wave spectrum.
pub trait Spectrum: Debug + Send + Sync {
    /// `S(K)`, m^3; zero for K <= 0.
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64;

    /// `Phi(K)` of waves travelling along +K, 1/rad; integrates to 1 over the circle.
    fn spreading_per_rad(&self, k: WaveVector) -> f64;

    /// Wave number at which S is largest, rad/m; 0 for a spectrum that is zero throughout.
    fn peak_rad_m(&self) -> f64;

    /// `[Phi(K) + Phi(-K)]/2`, 1/rad.
    fn symmetric_spreading_per_rad(&self, k: WaveVector) -> f64 {
        0.5 * (self.spreading_per_rad(k) + self.spreading_per_rad(-k))
    }

    /// `integral of Phi cos 2 phi` and `Phi sin 2 phi` over the circle, phi from +x: what slopes along
    /// and across a direction depend on.
    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        // The mean over 128 directions is exact for all harmonics of a smooth Phi up to the 125th.
        const DIRECTIONS: usize = 128;
        let step = std::f64::consts::TAU / DIRECTIONS as f64;
        let mut sum = [0.0; 2];
        for i in 0..DIRECTIONS {
            let azimuth = (i as f64 + 0.5) * step;
            let weight = step * self.spreading_per_rad(WaveVector::polar(k_rad_m, azimuth));
            sum[0] += weight * (2.0 * azimuth).cos();
            sum[1] += weight * (2.0 * azimuth).sin();
        }
        sum
    }

    /// `Psi(K)` of waves travelling along +K, m^4.
    fn wave_m4(&self, k: WaveVector) -> f64 {
        let s = self.omnidirectional_m3(k.magnitude());
        if s > 0.0 { s * self.spreading_per_rad(k) / k.magnitude() } else { 0.0 }
    }

    /// `[Psi(K) + Psi(-K)]/2`, m^4.
    fn symmetric_m4(&self, k: WaveVector) -> f64 {
        let s = self.omnidirectional_m3(k.magnitude());
        if s > 0.0 { s * self.symmetric_spreading_per_rad(k) / k.magnitude() } else { 0.0 }
    }

    /// The wave numbers nearest to the peak, below and above, where S is half its peak, rad/m.
    fn half_power_band_rad_m(&self) -> [f64; 2] {
        cells::half_power_band_rad_m(|k| self.omnidirectional_m3(k), self.peak_rad_m())
    }

    /// Wave number from which on it follows a law over wave numbers and directions, rad/m: values from a file
    /// have a kink at each, and are not worth tabulating.
    fn smooth_from_rad_m(&self) -> f64 {
        0.0
    }

    /// Mean of [`Spectrum::wave_m4`] over the cell of sides `dk` centred on K, m^4.
    fn cell_mean_m4(&self, k: WaveVector, dk_rad_m: [f64; 2]) -> f64 {
        cells::cell_mean(|k| self.wave_m4(k), k, dk_rad_m, cells::divisions(k, dk_rad_m))
    }

    /// Whether values at points `dk` apart misrepresent the energy, so that means over cells must be
    /// used: fewer than six points up to the peak, or four across the half-power band.
    fn needs_cell_means(&self, dk_rad_m: f64) -> bool {
        let [low, high] = self.half_power_band_rad_m();
        self.peak_rad_m() < 6.0 * dk_rad_m || high - low < 4.0 * dk_rad_m
    }
}

/// What is wrong with a spectrum.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// Inverse wave age out of range.
    #[error("inverse wave age of {inverse_wave_age}: allowed are 0.84 (fully developed) to 5")]
    InverseWaveAge {
        /// The value given.
        inverse_wave_age: f64,
    },
    /// Fetch out of range.
    #[error("fetch of {fetch_m} m: allowed are {} to {} m", FETCH_RANGE_M[0], FETCH_RANGE_M[1])]
    Fetch {
        /// The fetch given, m.
        fetch_m: f64,
    },
    /// A fetch too short for this wind.
    #[error(
        "fetch of {fetch_m} m at {u10_mps} m/s means an inverse wave age of {inverse_wave_age:.2}: at most 5 is allowed"
    )]
    Young {
        /// The fetch given, m.
        fetch_m: f64,
        /// Wind at 10 m, m/s.
        u10_mps: f64,
        /// The wave age that follows.
        inverse_wave_age: f64,
    },
    /// Spreading exponent out of range.
    #[error("spreading exponent of {exponent}: allowed are 0 to {}", spreading::MAX_EXPONENT)]
    Exponent {
        /// The exponent given.
        exponent: f64,
    },
    /// A swell parameter out of range.
    #[error("swell {quantity} of {value} {unit}: allowed are {low} to {high} {unit}")]
    Swell {
        /// Which parameter.
        quantity: &'static str,
        /// The value given.
        value: f64,
        /// Smallest allowed.
        low: f64,
        /// Largest allowed.
        high: f64,
        /// Unit of these.
        unit: &'static str,
    },
    /// Water depth out of range.
    #[error(transparent)]
    Depth(#[from] DepthError),
    /// A measured spectrum cannot be used.
    #[error(transparent)]
    Measured(#[from] measured::MeasuredError),
}

/// The spectrum of a sea: the wind sea (or the measured one) and every swell train.
///
/// # Errors
/// A parameter out of range, or a file of a measured spectrum that cannot be read.
pub fn of_water(water: &Water, wind: &Wind) -> Result<Box<dyn Spectrum>, SpectrumError> {
    water.dispersion.check()?;
    let wind_sea = of_kind(&water.spectrum, wind)?;
    if water.swell.is_empty() {
        return Ok(wind_sea);
    }
    let mut parts = vec![wind_sea];
    for swell in &water.swell {
        parts.push(Box::new(SwellTrain::new(swell, water.dispersion)?));
    }
    Ok(Box::new(Combined::new(parts)))
}

/// The spectrum of a wind sea alone (or the measured one).
///
/// # Errors
/// A parameter out of range, or a file of a measured spectrum that cannot be read.
pub fn of_kind(kind: &SpectrumKind, wind: &Wind) -> Result<Box<dyn Spectrum>, SpectrumError> {
    Ok(match kind {
        SpectrumKind::Elfouhaily { development } => Box::new(Elfouhaily::new(wind, *development)?),
        SpectrumKind::FungLee => Box::new(FungLee::new(wind)),
        SpectrumKind::ElfouhailyFungLee { development } => Box::new(Mix::new(wind, *development)?),
        SpectrumKind::PiersonMoskowitz { spreading } => Box::new(PiersonMoskowitz::new(wind, *spreading)?),
        SpectrumKind::Jonswap { fetch_m, spreading } => Box::new(Jonswap::new(wind, *fetch_m, *spreading)?),
        SpectrumKind::Measured { path, tail: false } => Box::new(Measured::load(path)?),
        SpectrumKind::Measured { path, tail: true } => Box::new(Tailed::new(Measured::load(path)?, wind)?),
    })
}

/// Whether a spectrum may have energy at this wave number.
pub(crate) fn in_range(k_rad_m: f64) -> bool {
    k_rad_m > 0.0 && k_rad_m <= MAX_WAVE_NUMBER_RAD_M
}
