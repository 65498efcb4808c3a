//! Water stirred by a ship's screws, with fewer small waves than the sea around it.
//!
//! `A(K) = Psi(U_dv)/Psi(U)`: the spectrum is that of a weaker wind `U_dv` (0.4 U where nothing is known),
//! tabulated at construction from any ratio of spectra: 256 values uniform in `ln K`, linear between,
//! constant beyond the ends, 0 to 1. Slopes go to those of Cox and Munk's slick, as the paper has it. The
//! share `q` of a facet that is stirred comes from [`sea::wake::turbulent`](crate::sea::wake::turbulent).
//!
//! Limits: a model of an appearance; the stirring itself is not computed. The ratio does not depend on
//! direction.
//!
//! ```
//! use nereus::scattering::kind::{Kind, turbulent_wake::TurbulentWake};
//! let stirred = TurbulentWake::new([1.0, 500.0], |k| 1.0 / (1.0 + 0.02 * k))?;
//! assert!((stirred.spectrum_factor(50.0) - 0.5).abs() < 1e-3);
//! assert!(TurbulentWake::new([1.0, 500.0], |_| f64::NAN).is_err());
//! # Ok::<(), nereus::scattering::kind::turbulent_wake::RatioError>(())
//! ```

use super::Kind;
use crate::scattering::slope_pdf::{GramCharlier, MeanSquareSlope};

/// Wind in the strip over the wind outside, where nothing is known.
pub const WIND_RATIO: f64 = 0.4;
/// Values tabulated.
const VALUES: usize = 256;

/// What is wrong with a ratio of spectra.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RatioError {
    /// No range.
    #[error(
        "spectrum ratio from {from_radpm} to {to_radpm} rad/m: both must be finite and above 0, the second larger"
    )]
    Range {
        /// The lower end, rad/m.
        from_radpm: f64,
        /// The upper end, rad/m.
        to_radpm: f64,
    },
    /// Not a number, or negative.
    #[error("spectrum ratio at {wavenumber_radpm} rad/m is {ratio}: it must be at least 0")]
    Value {
        /// Where, rad/m.
        wavenumber_radpm: f64,
        /// The ratio.
        ratio: f64,
    },
}

/// Water behind a ship.
#[derive(Clone, Debug, PartialEq)]
pub struct TurbulentWake {
    log_from: f64,
    values_per_unit: f64,
    ratio: Vec<f64>,
}

impl TurbulentWake {
    /// From the ratio of the spectrum in the strip to the clean one, for wave numbers in a range, rad/m. What
    /// is above 1 counts as 1: the strip has no more waves than the sea.
    ///
    /// # Errors
    /// A range without extent, or a ratio that is negative or not a number.
    pub fn new([from_radpm, to_radpm]: [f64; 2], ratio: impl Fn(f64) -> f64) -> Result<Self, RatioError> {
        if !(from_radpm > 0.0 && to_radpm > from_radpm && to_radpm.is_finite()) {
            return Err(RatioError::Range { from_radpm, to_radpm });
        }
        let log_from = from_radpm.ln();
        let values_per_unit = (VALUES - 1) as f64 / (to_radpm.ln() - log_from);
        if !values_per_unit.is_finite() {
            return Err(RatioError::Range { from_radpm, to_radpm });
        }
        let tabulate = |i: usize| {
            let wavenumber_radpm = (log_from + i as f64 / values_per_unit).exp();
            let ratio = ratio(wavenumber_radpm);
            if ratio.is_nan() || ratio < 0.0 {
                return Err(RatioError::Value { wavenumber_radpm, ratio });
            }
            Ok(ratio.min(1.0))
        };
        let ratio = (0..VALUES).map(tabulate).collect::<Result<_, _>>()?;
        Ok(Self { log_from, values_per_unit, ratio })
    }
}

impl Kind for TurbulentWake {
    #[inline]
    fn spectrum_factor(&self, wavenumber_radpm: f64) -> f64 {
        let place = (wavenumber_radpm.ln() - self.log_from) * self.values_per_unit;
        // max and min turn NaN (a negative wave number) into an end of the table.
        let place = place.max(0.0).min((VALUES - 1) as f64);
        let cell = (place as usize).min(VALUES - 2);
        let share = place - cell as f64;
        self.ratio[cell] + share * (self.ratio[cell + 1] - self.ratio[cell])
    }

    fn slopes(&self, wind_12p5_mps: f64) -> MeanSquareSlope {
        MeanSquareSlope::cox_munk_slick(wind_12p5_mps)
    }

    fn gram_charlier(&self, _wind_12p5_mps: f64) -> GramCharlier {
        GramCharlier::cox_munk_slick()
    }
}
