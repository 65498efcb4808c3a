//! Field gain of an antenna.
//!
//! **Field gain** `g` (complex, `|g|^2` = power gain) of a uniformly illuminated aperture in direction
//! cosines `u = d.y_a`, `v = d.z_a`, with full dimensions `a` along y and `b` along z:
//!
//! * rectangle: `g = sqrt(4 pi a b) / lambda  sinc(pi a u / lambda) sinc(pi b v / lambda)`,
//!   `sinc x = sin x / x`;
//! * ellipse: `g = sqrt(4 pi (pi a b / 4)) / lambda  2 J1(X) / X`, `X = (pi / lambda) hypot(a u, b v)`;
//! * tapered rectangle: each `sinc` by the pattern of its [taper](crate::radar::taper);
//! * isotropic: constant;
//! * a measured pattern ([`crate::radar::pattern`]).
//!
//! The sign of the sidelobes is kept. No obliquity factor. Apertures are dark behind (`d.x_a <= 0`).
//!
//! Polarisation stands in [`crate::radar::polarisation`].
//!
//! ```
//! use nereus::radar::antenna::Antenna;
//! use nereus::frames::Vector;
//! // 4 m x 5 cm at 10 GHz: 34.47 dBi.
//! let antenna = Antenna::Rectangle { width_m: 4.0, height_m: 0.05, wavelength_m: 0.029_979_245_8 };
//! let g = antenna.field_gain(Vector::new(1.0, 0.0, 0.0));
//! assert!((20.0 * g.norm().log10() - 34.47).abs() < 0.005);
//! ```

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::frames::{self, Vector};
use crate::radar::pattern::{GridPattern, PatternError};
use crate::radar::taper::SideTaper;
use crate::scene::radar::Pattern;
use crate::units::Decibels;

/// An antenna ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub enum Antenna {
    /// The same everywhere.
    Isotropic {
        /// Field gain.
        gain: f64,
    },
    /// Uniformly illuminated rectangle.
    Rectangle {
        /// Full width a along y, m.
        width_m: f64,
        /// Full height b along z, m.
        height_m: f64,
        /// Wavelength, m.
        wavelength_m: f64,
    },
    /// Rectangle whose illumination falls towards the edges.
    Tapered {
        /// Field gain ahead.
        peak: f64,
        /// Full sides along y and z, wavelengths.
        sides: [f64; 2],
        /// Along them.
        tapers: [SideTaper; 2],
    },
    /// Uniformly illuminated ellipse.
    Ellipse {
        /// Full axis a along y, m.
        width_m: f64,
        /// Full axis b along z, m.
        height_m: f64,
        /// Wavelength, m.
        wavelength_m: f64,
    },
    /// Measured.
    Grid(GridPattern),
}

impl Antenna {
    /// The antenna of a description, at a wavelength; reads the file of a measured pattern.
    ///
    /// # Errors
    /// A file of a measured pattern that cannot be read, or its faults.
    pub fn open(pattern: &Pattern, wavelength_m: f64) -> Result<Self, PatternError> {
        Ok(match *pattern {
            Pattern::Isotropic { gain_dbi } => Self::Isotropic { gain: Decibels(gain_dbi).amplitude_ratio() },
            Pattern::Rectangle { width_m, height_m } => Self::Rectangle { width_m, height_m, wavelength_m },
            Pattern::Tapered { width_m, height_m, tapers } => {
                let (sides, tapers) =
                    ([width_m, height_m].map(|m| m / wavelength_m), tapers.map(SideTaper::of));
                let efficiency: f64 = tapers.iter().map(SideTaper::efficiency).product();
                let peak = (4.0 * PI * sides[0] * sides[1] * efficiency).sqrt();
                Self::Tapered { peak, sides, tapers }
            }
            Pattern::Ellipse { width_m, height_m } => Self::Ellipse { width_m, height_m, wavelength_m },
            Pattern::File { ref path, floor_dbi } => Self::Grid(GridPattern::open(path, floor_dbi)?),
        })
    }

    /// Whether its field gain is a real number everywhere, so that it can be kept apart from the amplitude.
    pub fn is_real(&self) -> bool {
        !matches!(self, Self::Grid(_))
    }

    /// Full sides along y and z in wavelengths: over direction cosines, a field gain has no more cycles a
    /// unit than half of them. Zero where it is the same everywhere, and of a measured pattern.
    pub fn sides_wavelengths(&self) -> [f64; 2] {
        match *self {
            Self::Isotropic { .. } | Self::Grid(_) => [0.0; 2],
            Self::Tapered { sides, .. } => sides,
            Self::Rectangle { width_m, height_m, wavelength_m }
            | Self::Ellipse { width_m, height_m, wavelength_m } => {
                [width_m, height_m].map(|m| m / wavelength_m)
            }
        }
    }

    /// Field gain towards a unit direction in the antenna frame.
    pub fn field_gain(&self, direction: Vector<frames::Antenna>) -> Complex64 {
        let d = direction.raw();
        match self {
            Self::Isotropic { gain } => (*gain).into(),
            Self::Grid(grid) => grid.field_gain(d.y.atan2(d.x), d.z.clamp(-1.0, 1.0).asin()),
            Self::Rectangle { .. } | Self::Tapered { .. } | Self::Ellipse { .. } if d.x <= 0.0 => {
                Complex64::ZERO
            }
            Self::Tapered { peak, sides, tapers } => {
                (peak * tapers[0].field(sides[0] * d.y) * tapers[1].field(sides[1] * d.z)).into()
            }
            Self::Rectangle { width_m, height_m, wavelength_m } => {
                let peak = (4.0 * PI * width_m * height_m).sqrt() / wavelength_m;
                let across = sinc(PI * width_m * d.y / wavelength_m);
                let along = sinc(PI * height_m * d.z / wavelength_m);
                (peak * across * along).into()
            }
            Self::Ellipse { width_m, height_m, wavelength_m } => {
                let peak = PI * (width_m * height_m).sqrt() / wavelength_m;
                let x = PI / wavelength_m * (width_m * d.y).hypot(height_m * d.z);
                (peak * jinc(x)).into()
            }
        }
    }
}

/// `sin x / x`.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

/// `2 J1(x) / x`.
fn jinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { 2.0 * libm::j1(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sidelobes_alternate_and_the_back_is_dark() {
        let antenna = Antenna::Rectangle { width_m: 4.0, height_m: 0.05, wavelength_m: 0.03 };
        let at = |u: f64| antenna.field_gain(Vector::new((1.0 - u * u).sqrt(), u, 0.0)).re;
        assert!(at(0.0) > 0.0 && at(0.0107) < 0.0 && at(0.0185) > 0.0);
        // First sidelobe of a uniform aperture: -13.26 dB.
        assert!((20.0 * (at(0.010_727) / at(0.0)).abs().log10() + 13.26).abs() < 0.005);
        assert_eq!(antenna.field_gain(Vector::new(-1.0, 0.0, 0.0)), Complex64::ZERO);
    }
}
