//! Spectra made of others: the paper's mix, and sums.
//!
//! [`Mix`]: `S` of Elfouhaily with `Phi` of Fung and Lee (D from Fung and Lee's own spectrum).
//! [`Combined`]: `Psi` is the sum of its parts, as wind sea and swell trains.
//!
//! ```
//! use nereus::scene::water::{Development, WindProfile};
//! use nereus::sea::spectrum::{Elfouhaily, FungLee, Mix, Spectrum, WaveVector};
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_friction_velocity(0.36, WindProfile::Cardone, 0.0)?;
//! let mix = Mix::new(&wind, Development::default())?;
//! let k = WaveVector::new(30.0, 10.0);
//! assert_eq!(mix.spreading_per_rad(k), FungLee::new(&wind).spreading_per_rad(k));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::{Elfouhaily, FungLee, Spectrum, SpectrumError, WaveVector, cells};
use crate::scene::water::Development;
use crate::sea::wind::Wind;

/// Elfouhaily's omnidirectional spectrum with Fung and Lee's spreading.
#[derive(Clone, Debug)]
pub struct Mix {
    omnidirectional: Elfouhaily,
    spreading: FungLee,
}

impl Mix {
    /// The spectrum of a wind and a state of development.
    ///
    /// # Errors
    /// An inverse wave age out of range.
    pub fn new(wind: &Wind, development: Development) -> Result<Self, SpectrumError> {
        Ok(Self { omnidirectional: Elfouhaily::new(wind, development)?, spreading: FungLee::new(wind) })
    }
}

impl Spectrum for Mix {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        self.omnidirectional.omnidirectional_m3(k_rad_m)
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.spreading.spreading_per_rad(k)
    }

    fn symmetric_spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.spreading.symmetric_spreading_per_rad(k)
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        self.spreading.second_harmonic(k_rad_m)
    }

    fn peak_rad_m(&self) -> f64 {
        self.omnidirectional.peak_rad_m()
    }
}

/// The sum of spectra.
#[derive(Debug)]
pub struct Combined {
    parts: Vec<Box<dyn Spectrum>>,
    peak_rad_m: f64,
}

impl Combined {
    /// The sum of the given parts.
    pub fn new(parts: Vec<Box<dyn Spectrum>>) -> Self {
        let total = |k: f64| parts.iter().map(|part| part.omnidirectional_m3(k)).sum::<f64>();
        // The peak of a sum lies at, or a little beside, the peak of one of its parts.
        let mut best = [0.0, 0.0];
        for part in &parts {
            let near = part.peak_rad_m();
            if near > 0.0 {
                let peak_rad_m = cells::peak_rad_m(total, [0.7 * near, 1.4 * near]);
                let value = total(peak_rad_m);
                if value > best[1] {
                    best = [peak_rad_m, value];
                }
            }
        }
        Self { parts, peak_rad_m: best[0] }
    }

    fn sum(&self, f: impl Fn(&dyn Spectrum) -> f64) -> f64 {
        self.parts.iter().map(|part| f(part.as_ref())).sum()
    }

    /// Mean of a quantity over the parts, weighted by their S; the plain mean where all are zero.
    fn mean(&self, k_rad_m: f64, f: impl Fn(&dyn Spectrum) -> f64) -> f64 {
        let total = self.omnidirectional_m3(k_rad_m);
        if total > 0.0 {
            return self.sum(|part| {
                let s = part.omnidirectional_m3(k_rad_m);
                if s > 0.0 { s * f(part) } else { 0.0 }
            }) / total;
        }
        self.sum(&f) / self.parts.len().max(1) as f64
    }
}

impl Spectrum for Combined {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        self.sum(|part| part.omnidirectional_m3(k_rad_m))
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.mean(k.magnitude(), |part| part.spreading_per_rad(k))
    }

    fn symmetric_spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.mean(k.magnitude(), |part| part.symmetric_spreading_per_rad(k))
    }

    fn second_harmonic(&self, k_rad_m: f64) -> [f64; 2] {
        [0, 1].map(|i| self.mean(k_rad_m, |part| part.second_harmonic(k_rad_m)[i]))
    }

    fn peak_rad_m(&self) -> f64 {
        self.peak_rad_m
    }

    fn wave_m4(&self, k: WaveVector) -> f64 {
        self.sum(|part| part.wave_m4(k))
    }

    fn symmetric_m4(&self, k: WaveVector) -> f64 {
        self.sum(|part| part.symmetric_m4(k))
    }

    fn cell_mean_m4(&self, k: WaveVector, dk_rad_m: [f64; 2]) -> f64 {
        self.sum(|part| part.cell_mean_m4(k, dk_rad_m))
    }

    fn smooth_from_rad_m(&self) -> f64 {
        self.parts.iter().map(|part| part.smooth_from_rad_m()).fold(0.0, f64::max)
    }

    fn needs_cell_means(&self, dk_rad_m: f64) -> bool {
        self.parts.iter().any(|part| part.needs_cell_means(dk_rad_m))
    }
}
