//! The clean sea.
//!
//! ```
//! use nereus::scattering::kind::{Kind, clean::Clean};
//! assert!((Clean.slopes(10.0).total() - 0.0538).abs() < 1e-12);
//! ```

use super::Kind;
use crate::scattering::slope_pdf::{GramCharlier, MeanSquareSlope};

/// Water without a film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clean;

impl Kind for Clean {
    #[inline]
    fn spectrum_factor(&self, _wavenumber_radpm: f64) -> f64 {
        1.0
    }

    fn slopes(&self, wind_12p5_mps: f64) -> MeanSquareSlope {
        MeanSquareSlope::cox_munk_clean(wind_12p5_mps)
    }

    fn gram_charlier(&self, wind_12p5_mps: f64) -> GramCharlier {
        GramCharlier::cox_munk_clean(wind_12p5_mps)
    }
}
