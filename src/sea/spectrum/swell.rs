//! Swell: waves that the local wind did not raise.
//!
//! In frequency a Gaussian, or JONSWAP's shape with a large peak enhancement, scaled to `Hs^2/16`; `S(K) =
//! S_w d omega/dK` with the dispersion of the scene (so the period is right in any depth). In direction
//! `cos^2s(phi/2)` with `s = 2/sigma^2 - 1`, sigma the circular standard deviation (Kuik et al. 1988).
//!
//! Limits: Hs to 30 m, period 1 to 40 s, spread 0.05 to 1.4 rad, relative width 0.01 to 0.3, peak
//! enhancement 1 to 50.
//!
//! ```
//! use nereus::scene::water::{Dispersion, Swell, SwellShape};
//! use nereus::sea::spectrum::{moments::Moments, SwellTrain};
//! let swell = Swell {
//!     significant_height_m: 2.0,
//!     peak_period_s: 12.0,
//!     direction_rad: 0.3,
//!     spread_rad: 0.2,
//!     shape: SwellShape::Gaussian { relative_width: 0.05 },
//! };
//! let train = SwellTrain::new(&swell, Dispersion::default())?;
//! assert!((Moments::of(&train, [1e-3, 1.0]).significant_height_m() - 2.0).abs() < 1e-6);
//! # Ok::<(), nereus::sea::spectrum::SpectrumError>(())
//! ```

use super::jonswap::shape;
use super::spreading::Heading;
use super::{Spectrum, SpectrumError, WaveVector, cells, in_range};
use crate::scene::water::{Dispersion, Swell, SwellShape};

/// One swell train.
#[derive(Clone, Debug)]
pub struct SwellTrain {
    heading: Heading,
    exponent: f64,
    shape: SwellShape,
    dispersion: Dispersion,
    omega_peak_rad_s: f64,
    /// Factor of the shape, m^2 s.
    level_m2s: f64,
    peak_rad_m: f64,
    /// Wave number of the peak frequency, and the smallest scale on which Psi changes there, rad/m.
    centre_rad_m: f64,
    scale_rad_m: f64,
}

impl SwellTrain {
    /// The train described, in water of the given dispersion.
    ///
    /// # Errors
    /// A height, period, direction or spread out of range.
    pub fn new(swell: &Swell, dispersion: Dispersion) -> Result<Self, SpectrumError> {
        dispersion.check()?;
        let check = |quantity, value: f64, [low, high]: [f64; 2], unit| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(SpectrumError::Swell { quantity, value, low, high, unit })
            }
        };
        check("height", swell.significant_height_m, [0.0, 30.0], "m")?;
        check("period", swell.peak_period_s, [1.0, 40.0], "s")?;
        check("direction", swell.direction_rad, [-1e3, 1e3], "rad")?;
        check("spread", swell.spread_rad, [0.05, 1.4], "rad")?;
        let omega_peak_rad_s = std::f64::consts::TAU / swell.peak_period_s;
        let variance_m2 = swell.significant_height_m * swell.significant_height_m / 16.0;
        // Integral of the shape over omega/omega_peak, and its width.
        let (integral, width) = match swell.shape {
            SwellShape::Gaussian { relative_width } => {
                check("relative width", relative_width, [0.01, 0.3], "")?;
                let below = 0.5 * libm::erfc(1.0 / (relative_width * std::f64::consts::SQRT_2));
                (relative_width * std::f64::consts::TAU.sqrt() * (1.0 - below), relative_width)
            }
            SwellShape::Jonswap { peak_enhancement } => {
                check("peak enhancement", peak_enhancement, [1.0, 50.0], "")?;
                (jonswap_integral(peak_enhancement), 0.07)
            }
        };
        let centre_rad_m = dispersion.wave_number_rad_m(omega_peak_rad_s);
        let along = width * omega_peak_rad_s / dispersion.group_speed_mps(centre_rad_m);
        let mut train = Self {
            heading: Heading::new(swell.direction_rad),
            exponent: 2.0 / (swell.spread_rad * swell.spread_rad) - 1.0,
            shape: swell.shape,
            dispersion,
            omega_peak_rad_s,
            level_m2s: variance_m2 / (integral * omega_peak_rad_s),
            peak_rad_m: 0.0,
            centre_rad_m,
            scale_rad_m: along.min(swell.spread_rad * centre_rad_m),
        };
        if variance_m2 > 0.0 {
            let around = [0.5 * centre_rad_m, 1.5 * centre_rad_m];
            train.peak_rad_m = cells::peak_rad_m(|k| train.omnidirectional_m3(k), around);
        }
        Ok(train)
    }
}

/// Integral of JONSWAP's shape over the frequency ratio.
fn jonswap_integral(peak_enhancement: f64) -> f64 {
    let ln_gamma = peak_enhancement.ln();
    let [low, high] = [0.2, 50.0];
    let points = 20_001;
    let step = f64::ln(high / low) / (points - 1) as f64;
    let mut sum = 0.0;
    for i in 0..points {
        let ratio = low * (i as f64 * step).exp();
        let end = if i == 0 || i == points - 1 { 0.5 } else { 1.0 };
        sum += end * step * ratio * shape(ratio, ln_gamma);
    }
    // Beyond the last point the shape is ratio^-5.
    sum + 0.25 / high.powi(4)
}

impl Spectrum for SwellTrain {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        if !in_range(k_rad_m) || self.level_m2s == 0.0 {
            return 0.0;
        }
        let ratio = self.dispersion.angular_frequency_rad_s(k_rad_m) / self.omega_peak_rad_s;
        let form = match self.shape {
            SwellShape::Gaussian { relative_width } => {
                let offset = (ratio - 1.0) / relative_width;
                (-0.5 * offset * offset).exp()
            }
            SwellShape::Jonswap { peak_enhancement } => shape(ratio, peak_enhancement.ln()),
        };
        if form > 0.0 { self.level_m2s * form * self.dispersion.group_speed_mps(k_rad_m) } else { 0.0 }
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.heading.cosine_power(self.exponent, k)
    }

    fn second_harmonic(&self, _k_rad_m: f64) -> [f64; 2] {
        self.heading.cosine_power_harmonic(self.exponent)
    }

    fn peak_rad_m(&self) -> f64 {
        self.peak_rad_m
    }

    fn cell_mean_m4(&self, k: WaveVector, dk_rad_m: [f64; 2]) -> f64 {
        let mut divisions = cells::divisions(k, dk_rad_m);
        // A narrow train may lie within one cell: cells that can hold part of it are cut finely enough.
        let side = dk_rad_m[0].max(dk_rad_m[1]);
        if (k.magnitude() - self.centre_rad_m).abs()
            < side + 6.0 * self.scale_rad_m.max(0.1 * self.centre_rad_m)
        {
            divisions = divisions.max((side / self.scale_rad_m).ceil().clamp(1.0, 32.0) as usize);
        }
        cells::cell_mean(|k| self.wave_m4(k), k, dk_rad_m, divisions)
    }
}
