//! The turbulent strip behind a stern, where small waves are damped: the dark V of radar images.
//!
//! Full width at a distance x astern of the stern
//!
//! `W(x) = w0 B (x/(x0 L))^(1/a)`, `w0 = 4`, `x0 = 4`, `a = 5` (4 to 5): four beams wide four lengths astern
//!
//! (Zilman, Zapolski and Marom, IEEE TGRS 42, 2335 (2004); B beam, L length of the ship). A facet is covered
//! by the strip to the share
//!
//! `q(x, y) = onset(x/B) edge(|y|/(W/2)) exp(-x/xd)`, `xd = 20 L` by default,
//!
//! `edge` a raised cosine from 1 to 0 over a tenth of W, centred on the outline `|y| = W/2`, and `onset` one
//! from 0 to 1 over a beam behind the stern: by its law the strip is a beam wide after half a metre, and
//! would come over a facet from one pulse to the next. What q does to the spectrum is
//! [`kind::turbulent_wake`](crate::scattering::kind::turbulent_wake)'s affair; heights stay as they are.
//!
//! Limits: W as full width is a reading of the source; the strip follows a straight course (see
//! [`course`](super::course)) or a [track](super::track_line); of several strips that which covers most of a
//! facet decides.
//!
//! ```
//! use nereus::sea::wake::TurbulentStrip;
//! let strip = TurbulentStrip::with(100.0, 13.0, 5.0, 2000.0)?;
//! assert!((strip.width_m(400.0) - 52.0).abs() < 1e-12);
//! // 4 lengths astern of the stern, on the centre line.
//! assert!((strip.cover([450.0, 0.0]) - (-400.0f64 / 2000.0).exp()).abs() < 1e-15);
//! assert_eq!(strip.cover([450.0, 30.0]), 0.0);
//! # Ok::<(), nereus::sea::wake::WakeError>(())
//! ```

use std::f64::consts::PI;

use super::fault::{LENGTH_RANGE_M, WakeError};

/// Width over beam, `x0` lengths astern.
pub const WIDTH_IN_BEAMS: f64 = 4.0;
/// Lengths astern where the strip is [`WIDTH_IN_BEAMS`] wide.
pub const PLACE_IN_LENGTHS: f64 = 4.0;
/// Exponents of the width law.
pub const EXPONENT_RANGE: [f64; 2] = [4.0, 5.0];
/// Width of the edge over that of the strip.
pub const EDGE: f64 = 0.1;
/// Decay lengths below which the cover counts: `exp(-40)` is 4e-18.
const FORGOTTEN: f64 = 40.0;

/// The strip of one ship.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurbulentStrip {
    length_m: f64,
    beam_m: f64,
    exponent: f64,
    decay_m: f64,
}

impl TurbulentStrip {
    /// With an exponent `a` and a decay length xd, m, of the caller's.
    ///
    /// # Errors
    /// A length, beam, exponent or decay length out of range.
    pub fn with(length_m: f64, beam_m: f64, exponent: f64, decay_m: f64) -> Result<Self, WakeError> {
        if !(LENGTH_RANGE_M[0]..=LENGTH_RANGE_M[1]).contains(&length_m) {
            return Err(WakeError::Length { length_m });
        }
        let fault = |what, value, allowed| Err(WakeError::Strip { what, value, allowed });
        if !(beam_m > 0.0 && beam_m <= LENGTH_RANGE_M[1]) {
            return fault("the beam, m,", beam_m, "above 0 and at most 10 000 m");
        }
        if !(EXPONENT_RANGE[0]..=EXPONENT_RANGE[1]).contains(&exponent) {
            return fault("the exponent", exponent, "4 to 5");
        }
        if !(decay_m > 0.0 && decay_m.is_finite()) {
            return fault("the decay length, m,", decay_m, "finite and above 0");
        }
        Ok(Self { length_m, beam_m, exponent, decay_m })
    }

    /// Full width, m, at a distance astern of the stern, m; 0 ahead of it.
    pub fn width_m(&self, behind_stern_m: f64) -> f64 {
        if behind_stern_m.is_nan() || behind_stern_m <= 0.0 {
            return 0.0;
        }
        let place = behind_stern_m / (PLACE_IN_LENGTHS * self.length_m);
        WIDTH_IN_BEAMS * self.beam_m * place.powf(self.exponent.recip())
    }

    /// Distance astern of midship beyond which it is forgotten, m.
    pub fn end_m(&self) -> f64 {
        0.5 * self.length_m + FORGOTTEN * self.decay_m
    }

    /// Distance from the course beyond which nothing is covered, m, at any distance astern of midship up to
    /// the given one, m.
    pub fn reach_aside_m(&self, astern_m: f64) -> f64 {
        0.5 * (1.0 + EDGE) * self.width_m(astern_m - 0.5 * self.length_m)
    }

    /// Share of the water covered, 0 to 1, at distances astern and to starboard of midship, m.
    pub fn cover(&self, [astern_m, starboard_m]: [f64; 2]) -> f64 {
        let behind_m = astern_m - 0.5 * self.length_m;
        let half_m = 0.5 * self.width_m(behind_m);
        let out = starboard_m.abs();
        // Also where the strip has no width, or the place is not a number.
        if !(half_m > 0.0 && out < (1.0 + EDGE) * half_m) || behind_m > FORGOTTEN * self.decay_m {
            return 0.0;
        }
        // -1/2 to 1/2 across the edge.
        let across = ((out / half_m - 1.0) / (2.0 * EDGE)).clamp(-0.5, 0.5);
        let onset = 0.5 - 0.5 * (PI * (behind_m / self.beam_m).min(1.0)).cos();
        onset * (0.5 - 0.5 * (PI * across).sin()) * (-behind_m / self.decay_m).exp()
    }
}
