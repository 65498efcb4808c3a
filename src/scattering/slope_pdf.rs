//! Probability density of sea slopes.
//!
//! Gaussian with variances `s_u^2` (up/downwind) and `s_c^2` (crosswind), optionally with the
//! Gram-Charlier terms of Cox and Munk, J. Opt. Soc. Am. 44, 838 (1954):
//!
//! `p = p0 [1 - (c21/2)(X^2-1)E - (c03/6)(E^3-3E) + (c40/24)(X^4-6X^2+3) + (c22/4)(X^2-1)(E^2-1)
//! + (c04/24)(E^4-6E^2+3)]`, `p0 = exp(-(X^2+E^2)/2) / (2 pi s_u s_c)`,
//!
//! `X` = crosswind slope / `s_c`, `E` = -(downwind slope)/`s_u` (positive where the surface rises upwind:
//! steep lee faces are the more probable). The series is clamped at 0 far out, where it has no meaning.
//! Wind speed is that at 12.5 m; variances are floored at [`SLOPE_VARIANCE_FLOOR`].
//!
//! ```
//! use nereus::scattering::slope_pdf::{MeanSquareSlope, SlopePdf};
//! let pdf = SlopePdf::new(MeanSquareSlope::cox_munk_clean(10.0), None, 0.0);
//! let peak = 1.0 / (std::f64::consts::TAU * (0.0316f64 * 0.0222).sqrt());
//! assert!((pdf.density(0.0, 0.0) / peak - 1.0).abs() < 1e-12);
//! ```

use std::f64::consts::TAU;

/// Least variance of a slope component: keeps the specular glint of a dead calm sea finite.
pub const SLOPE_VARIANCE_FLOOR: f64 = 1e-5;

/// Variances of the slope along and across the wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanSquareSlope {
    /// Along the wind.
    pub up: f64,
    /// Across the wind.
    pub cross: f64,
}

impl MeanSquareSlope {
    /// Cox and Munk, clean sea: `3.16e-3 U`, `3e-3 + 1.92e-3 U`, `U` in m/s at 12.5 m.
    pub fn cox_munk_clean(wind_12p5_mps: f64) -> Self {
        Self { up: 3.16e-3 * wind_12p5_mps, cross: 3e-3 + 1.92e-3 * wind_12p5_mps }
    }

    /// Cox and Munk, oil slick: `5e-3 + 0.78e-3 U`, `3e-3 + 0.84e-3 U`, `U` in m/s at 12.5 m.
    pub fn cox_munk_slick(wind_12p5_mps: f64) -> Self {
        Self { up: 5e-3 + 0.78e-3 * wind_12p5_mps, cross: 3e-3 + 0.84e-3 * wind_12p5_mps }
    }

    /// `(1-share) self + share other`.
    #[inline]
    pub fn blend(self, other: Self, share: f64) -> Self {
        Self {
            up: self.up + share * (other.up - self.up),
            cross: self.cross + share * (other.cross - self.cross),
        }
    }

    /// Sum of both.
    pub fn total(self) -> f64 {
        self.up + self.cross
    }

    /// Both no less than [`SLOPE_VARIANCE_FLOOR`].
    #[inline]
    pub fn floored(self) -> Self {
        Self { up: self.up.max(SLOPE_VARIANCE_FLOOR), cross: self.cross.max(SLOPE_VARIANCE_FLOOR) }
    }
}

/// Coefficients of the Gram-Charlier series (first index crosswind, second upwind).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GramCharlier {
    /// Skewness, cross-cross-up.
    pub c21: f64,
    /// Skewness, up-up-up.
    pub c03: f64,
    /// Peakedness, cross.
    pub c40: f64,
    /// Peakedness, mixed.
    pub c22: f64,
    /// Peakedness, up.
    pub c04: f64,
}

impl GramCharlier {
    /// Cox and Munk, clean sea, wind in m/s at 12.5 m.
    pub fn cox_munk_clean(wind_12p5_mps: f64) -> Self {
        Self {
            c21: 0.01 - 0.0086 * wind_12p5_mps,
            c03: 0.04 - 0.033 * wind_12p5_mps,
            c40: 0.40,
            c22: 0.12,
            c04: 0.23,
        }
    }

    /// Cox and Munk, oil slick.
    pub fn cox_munk_slick() -> Self {
        Self { c21: 0.0, c03: 0.02, c40: 0.36, c22: 0.10, c04: 0.26 }
    }

    /// `(1-share) self + share other`.
    #[inline]
    pub fn blend(self, other: Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Self {
            c21: mix(self.c21, other.c21),
            c03: mix(self.c03, other.c03),
            c40: mix(self.c40, other.c40),
            c22: mix(self.c22, other.c22),
            c04: mix(self.c04, other.c04),
        }
    }

    /// The bracket of the series, at least 0.
    #[inline]
    fn factor(&self, x: f64, e: f64) -> f64 {
        let (x2, e2) = (x * x, e * e);
        let series = 1.0 - 0.5 * self.c21 * (x2 - 1.0) * e - self.c03 / 6.0 * e * (e2 - 3.0)
            + self.c40 / 24.0 * (x2 * x2 - 6.0 * x2 + 3.0)
            + self.c22 / 4.0 * (x2 - 1.0) * (e2 - 1.0)
            + self.c04 / 24.0 * (e2 * e2 - 6.0 * e2 + 3.0);
        series.max(0.0)
    }
}

/// A slope density on horizontal axes x, y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopePdf {
    inverse_s_up: f64,
    inverse_s_cross: f64,
    peak: f64,
    downwind_cos: f64,
    downwind_sin: f64,
    gram_charlier: Option<GramCharlier>,
}

impl SlopePdf {
    /// Density with the given variances (floored), for a wind that blows towards `downwind_rad` from x.
    pub fn new(slopes: MeanSquareSlope, gram_charlier: Option<GramCharlier>, downwind_rad: f64) -> Self {
        let (sin, cos) = downwind_rad.sin_cos();
        Self::along(slopes, gram_charlier, cos, sin)
    }

    /// As [`Self::new`], with cosine and sine of the wind's direction.
    #[inline]
    pub fn along(
        slopes: MeanSquareSlope,
        gram_charlier: Option<GramCharlier>,
        downwind_cos: f64,
        downwind_sin: f64,
    ) -> Self {
        let slopes = slopes.floored();
        let (inverse_s_up, inverse_s_cross) = (1.0 / slopes.up.sqrt(), 1.0 / slopes.cross.sqrt());
        let peak = inverse_s_up * inverse_s_cross / TAU;
        Self { inverse_s_up, inverse_s_cross, peak, downwind_cos, downwind_sin, gram_charlier }
    }

    /// Density of the slope `(slope_x, slope_y)`, per unit slope squared.
    #[inline]
    pub fn density(&self, slope_x: f64, slope_y: f64) -> f64 {
        let downwind = self.downwind_cos * slope_x + self.downwind_sin * slope_y;
        let cross = self.downwind_cos * slope_y - self.downwind_sin * slope_x;
        let (e, x) = (-downwind * self.inverse_s_up, cross * self.inverse_s_cross);
        let half = 0.5 * (e * e + x * x);
        // Beyond the smallest double the polynomial could still overflow and corrupt 0 with inf.
        if half.is_nan() || half > 745.0 {
            return 0.0;
        }
        let gaussian = self.peak * (-half).exp();
        match &self.gram_charlier {
            Some(series) => gaussian * series.factor(x, e),
            None => gaussian,
        }
    }
}
