//! Kinds of water surface: what a film or a disturbance does to the small waves.
//!
//! A kind states a factor `A(K)` on the spectrum and the slope statistics of the whole sea under it. A facet
//! is covered by its kind to a share `q` from 0 to 1, the rest of it is clean:
//! `Psi_eff(K) = Psi(K) [1 - q + q A(K)]`, and slope variances go from clean to covered in the same way.
//!
//! Adding a kind is one file with an `impl Kind`, and its `pub mod` line below: facets are handed over in
//! batches of one kind, so the choice costs nothing per facet.
//!
//! ```
//! use nereus::scattering::kind::{Kind, clean::Clean, slick::Slick};
//! assert_eq!(Clean.spectrum_factor(200.0), 1.0);
//! assert!(Slick::default().spectrum_factor(200.0) < 0.2);
//! ```

pub mod clean;
pub mod slick;
pub mod turbulent_wake;

use super::slope_pdf::{GramCharlier, MeanSquareSlope};

/// A kind of surface.
pub trait Kind {
    /// Factor on the clean spectrum at a wave number, rad/m: 0 to 1.
    fn spectrum_factor(&self, wavenumber_radpm: f64) -> f64;
    /// Slope variances of all waves, wind at 12.5 m.
    fn slopes(&self, wind_12p5_mps: f64) -> MeanSquareSlope;
    /// Departure of the slope density from a Gaussian, wind at 12.5 m.
    fn gram_charlier(&self, wind_12p5_mps: f64) -> GramCharlier;
}

impl Kind for &dyn Kind {
    fn spectrum_factor(&self, wavenumber_radpm: f64) -> f64 {
        (**self).spectrum_factor(wavenumber_radpm)
    }

    fn slopes(&self, wind_12p5_mps: f64) -> MeanSquareSlope {
        (**self).slopes(wind_12p5_mps)
    }

    fn gram_charlier(&self, wind_12p5_mps: f64) -> GramCharlier {
        (**self).gram_charlier(wind_12p5_mps)
    }
}
