//! A sea under an oil film.
//!
//! Slopes: Cox and Munk's slick. Small waves: Marangoni damping by an elastic, insoluble film, as given by
//! Lombardini et al., J. Atmos. Oceanic Tech. 6, 882 (1989), and Alpers and Huehnerfuss, JGR 94(C5), 6251
//! (1989): the damping rate of water waves grows by
//!
//! `y(K) = (1 - X + X Y) / (1 - 2 X + 2 X^2)`, `X = E K^2 / (rho sqrt(2 nu w^3))`, `Y = E K / (4 rho nu w)`,
//! `w^2 = g K + (s/rho) K^3`,
//!
//! and the spectrum under the film is `A(K) = 1/y` of the clean one (a part `q` of the facet covered:
//! `1 - q + q/y`). `E` is the dilational elasticity (N/m), `rho` the density (kg/m^3), `nu` the kinematic
//! viscosity (m^2/s), `s` the surface tension (N/m), `w` the angular frequency (rad/s). Limits: monomolecular
//! films; thick crude oil damps by its own viscosity, which is not modelled.
//!
//! ```
//! use nereus::scattering::kind::{Kind, slick::Slick};
//! let film = Slick::default();
//! // The Marangoni resonance lies at centimetre waves; metre waves pass.
//! assert!(film.spectrum_factor(150.0) < 0.1 && film.spectrum_factor(1.0) > 0.9);
//! ```

use super::Kind;
use crate::scattering::slope_pdf::{GramCharlier, MeanSquareSlope};
use crate::sea::GRAVITY_MPS2;

/// Density of sea water, kg/m^3.
const DENSITY_KGPM3: f64 = 1025.0;
/// Kinematic viscosity of water at 20 degrees Celsius, m^2/s.
const VISCOSITY_M2PS: f64 = 1.0e-6;
/// Surface tension of clean sea water, N/m.
const TENSION_NPM: f64 = 0.074;

/// Water under an elastic film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slick {
    /// Dilational elasticity of the film, N/m.
    pub elasticity_npm: f64,
}

impl Default for Slick {
    /// Oleyl alcohol, the usual artificial slick: 0.0255 N/m.
    fn default() -> Self {
        Self { elasticity_npm: 0.0255 }
    }
}

impl Slick {
    /// `y(K)`: damping rate under the film over that of clean water, at least 1.
    pub fn relative_damping(&self, wavenumber_radpm: f64) -> f64 {
        let k = wavenumber_radpm;
        if k.is_nan() || k <= 0.0 {
            return 1.0;
        }
        let omega = (GRAVITY_MPS2 * k + TENSION_NPM / DENSITY_KGPM3 * k * k * k).sqrt();
        let elastic = self.elasticity_npm.max(0.0) * k / DENSITY_KGPM3;
        let x = elastic * k / (omega * (2.0 * VISCOSITY_M2PS * omega).sqrt());
        let y = elastic / (4.0 * VISCOSITY_M2PS * omega);
        // The denominator is 1/2 + 2 (x - 1/2)^2, never below 1/2.
        ((1.0 - x + x * y) / (1.0 - 2.0 * x + 2.0 * x * x)).max(1.0)
    }
}

impl Kind for Slick {
    #[inline]
    fn spectrum_factor(&self, wavenumber_radpm: f64) -> f64 {
        1.0 / self.relative_damping(wavenumber_radpm)
    }

    fn slopes(&self, wind_12p5_mps: f64) -> MeanSquareSlope {
        MeanSquareSlope::cox_munk_slick(wind_12p5_mps)
    }

    fn gram_charlier(&self, _wind_12p5_mps: f64) -> GramCharlier {
        GramCharlier::cox_munk_slick()
    }
}
