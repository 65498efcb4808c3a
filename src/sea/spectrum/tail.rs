//! A measured spectrum with the wind's waves beyond its last wave number.
//!
//! A buoy measures waves down to some metres; radars see those of centimetres. Beyond `K_e`, the last wave
//! number of the file with energy (at most the shorter half of its grid), where the file has nothing, the sea
//! is Elfouhaily's for the wind of the scene, fully developed and in light wind as
//! [`light_wind`](super::light_wind) has it, joined to the file: `Psi = Psi_E r^h`, `r` the ratio of both
//! omnidirectional spectra over the last part of the file (0.7 to 0.95 `K_e`, held to 0.1 to 10), `h` falling
//! from 1 at `K_e` to 0 at `4 K_e` (raised cosine of `ln K`). Within the file nothing is added.
//!
//! Limits: a calm adds nothing.

use super::{LightWind, Measured, Spectrum, SpectrumError, WaveVector, cells};
use crate::scene::water::{Development, SpectrumKind};
use crate::sea::wind::Wind;

/// Part of the file over which levels are compared, of its last wave number.
const COMPARED: [f64; 2] = [0.7, 0.95];
/// Ratios of levels that are followed.
const RATIOS: [f64; 2] = [0.1, 10.0];
/// Multiple of the last wave number at which the tail is Elfouhaily's own.
const JOINED: f64 = 4.0;

/// A measured spectrum and what follows it.
#[derive(Debug)]
pub struct Tailed {
    measured: Measured,
    wind_sea: LightWind,
    last_rad_m: f64,
    ln_ratio: f64,
}

impl Tailed {
    /// Joins the waves of a wind to a measured spectrum.
    ///
    /// # Errors
    /// Those of the wind's spectrum.
    pub fn new(measured: Measured, wind: &Wind) -> Result<Self, SpectrumError> {
        let wind_sea =
            LightWind::new(&SpectrumKind::Elfouhaily { development: Development::default() }, wind)?;
        let last_rad_m = measured.last_rad_m();
        let sum = |spectrum: &dyn Spectrum| {
            let at = |i: usize| last_rad_m * (COMPARED[0] + (COMPARED[1] - COMPARED[0]) * i as f64 / 15.0);
            (0..16).map(|i| spectrum.omnidirectional_m3(at(i))).sum::<f64>()
        };
        let ratio = sum(&measured) / sum(&wind_sea);
        let ratio = if ratio.is_finite() { ratio.clamp(RATIOS[0], RATIOS[1]) } else { 1.0 };
        Ok(Self { measured, wind_sea, last_rad_m, ln_ratio: ratio.ln() })
    }

    /// Wave number beyond which the waves are those of the wind, rad/m.
    pub fn last_rad_m(&self) -> f64 {
        self.last_rad_m
    }

    /// Level of the tail over Elfouhaily's.
    fn level(&self, k_rad_m: f64) -> f64 {
        let share = ((k_rad_m / self.last_rad_m).ln() / JOINED.ln()).clamp(0.0, 1.0);
        (self.ln_ratio * 0.5 * (1.0 + (std::f64::consts::PI * share).cos())).exp()
    }

    fn extent_rad_m(&self) -> f64 {
        self.measured.smooth_from_rad_m()
    }
}

impl Spectrum for Tailed {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        if k_rad_m <= self.last_rad_m {
            self.measured.omnidirectional_m3(k_rad_m)
        } else if k_rad_m > self.extent_rad_m() {
            self.wind_sea.omnidirectional_m3(k_rad_m) * self.level(k_rad_m)
        } else {
            self.measured.circle_m3(k_rad_m, |k| self.wave_m4(k))
        }
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        let magnitude = k.magnitude();
        let s = self.omnidirectional_m3(magnitude);
        if s > 0.0 { self.wave_m4(k) * magnitude / s } else { 0.5 / std::f64::consts::PI }
    }

    fn peak_rad_m(&self) -> f64 {
        // In light wind after swell, or with an empty file, the wind's own waves may be the highest.
        let [measured, wind] = [self.measured.peak_rad_m(), self.wind_sea.peak_rad_m()];
        if self.omnidirectional_m3(wind) > self.omnidirectional_m3(measured) { wind } else { measured }
    }

    fn wave_m4(&self, k: WaveVector) -> f64 {
        let measured = self.measured.wave_m4(k);
        let magnitude = k.magnitude();
        if measured > 0.0 || magnitude <= self.last_rad_m {
            return measured;
        }
        self.wind_sea.wave_m4(k) * self.level(magnitude)
    }

    fn symmetric_m4(&self, k: WaveVector) -> f64 {
        0.5 * (self.wave_m4(k) + self.wave_m4(-k))
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        if k_rad_m <= self.last_rad_m {
            self.measured.second_harmonic(k_rad_m)
        } else {
            self.wind_sea.second_harmonic(k_rad_m)
        }
    }

    fn cell_mean_m4(&self, k: WaveVector, dk_rad_m: [f64; 2]) -> f64 {
        let reach = 0.5 * dk_rad_m[0].hypot(dk_rad_m[1]);
        if k.magnitude() + reach <= self.last_rad_m {
            return self.measured.cell_mean_m4(k, dk_rad_m);
        }
        let divisions = if k.magnitude() - reach > self.extent_rad_m() {
            cells::divisions(k, dk_rad_m)
        } else {
            self.measured.cell_divisions(dk_rad_m)
        };
        cells::cell_mean(|k| self.wave_m4(k), k, dk_rad_m, divisions)
    }

    fn needs_cell_means(&self, dk_rad_m: f64) -> bool {
        self.measured.needs_cell_means(dk_rad_m)
    }

    fn smooth_from_rad_m(&self) -> f64 {
        self.extent_rad_m()
    }
}
