//! Antennas: signed field gain and polarisation.
//!
//! With direction cosines `u = d.y_a`, `v = d.z_a` of a direction `d` and wavelength `lambda`, the field gain `g`
//! (`g^2 = G`, the power gain over isotropic) of a uniformly lit aperture is
//!
//! | aperture | g |
//! | --- | --- |
//! | rectangle a x b | `sqrt(4 pi a b)/lambda  sinc(pi a u/lambda) sinc(pi b v/lambda)`, `sinc x = sin x / x` |
//! | ellipse, full axes a, b | `pi sqrt(a b)/lambda  2 J1(X)/X`, `X = (pi/lambda) sqrt((a u)^2 + (b v)^2)` |
//!
//! The sign is kept: sidelobes alternate. Behind the aperture (`d.x_a <= 0`) `g = 0`; an isotropic antenna has no
//! behind. No obliquity factor. Far field: beyond `2 D^2/lambda` ([`far_field_m`]).
//!
//! A port's electric axis `e_a` (H: `y_a`; V: `z_a`; circular: `(y_a -+ j z_a)/sqrt 2`) gives, for a wave along `k`, the unit
//! field `e = (e_a - (e_a.k) k)/|..|` with components `(v.e, h.e)`. On reception it is the field that the antenna would radiate
//! along `-k`, without conjugation.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::DVec3;
use num_complex::Complex64;

use super::pattern::{MeasuredPattern, PatternError};
use crate::geometry::bistatic::fsa_basis;
use crate::scene::radar::{Pattern, Polarisation};
use crate::units::Decibels;

/// A gain pattern at one wavelength.
#[derive(Clone, Debug)]
pub enum Antenna {
    /// Equal gain everywhere.
    Isotropic {
        /// Field gain.
        field: f64,
    },
    /// Uniformly lit rectangle.
    Rectangle {
        /// Field gain on boresight.
        peak: f64,
        /// `pi a / lambda`.
        width: f64,
        /// `pi b / lambda`.
        height: f64,
    },
    /// Uniformly lit ellipse.
    Ellipse {
        /// Field gain on boresight.
        peak: f64,
        /// `pi a / lambda`.
        width: f64,
        /// `pi b / lambda`.
        height: f64,
    },
    /// From a file.
    Measured(MeasuredPattern),
}

impl Antenna {
    /// The pattern at a wavelength; a pattern file is read here.
    pub fn new(pattern: &Pattern, wavelength_m: f64) -> Result<Self, PatternError> {
        Ok(match pattern {
            Pattern::Isotropic { gain_dbi } => {
                Self::Isotropic { field: Decibels(*gain_dbi).amplitude_ratio() }
            }
            Pattern::Rectangle { width_m, height_m } => Self::Rectangle {
                peak: (4.0 * PI * width_m * height_m).sqrt() / wavelength_m,
                width: PI * width_m / wavelength_m,
                height: PI * height_m / wavelength_m,
            },
            Pattern::Ellipse { width_m, height_m } => Self::Ellipse {
                peak: PI * (width_m * height_m).sqrt() / wavelength_m,
                width: PI * width_m / wavelength_m,
                height: PI * height_m / wavelength_m,
            },
            Pattern::File { path, floor_dbi } => Self::Measured(MeasuredPattern::load(path, *floor_dbi)?),
        })
    }

    /// Field gain towards a unit direction in the antenna frame.
    pub fn field_gain(&self, direction: DVec3) -> Complex64 {
        let (u, v) = (direction.y, direction.z);
        match self {
            Self::Isotropic { field } => (*field).into(),
            Self::Measured(pattern) => pattern.field_gain(direction),
            _ if direction.x <= 0.0 => Complex64::ZERO,
            Self::Rectangle { peak, width, height } => (peak * sinc(width * u) * sinc(height * v)).into(),
            Self::Ellipse { peak, width, height } => (peak * jinc((width * u).hypot(height * v))).into(),
        }
    }

    /// Field gain for direction cosines (u, v) in the half space before the aperture; zero where no direction has
    /// them.
    pub fn field_gain_uv(&self, u: f64, v: f64) -> Complex64 {
        let before = 1.0 - u * u - v * v;
        // The rim itself is still before the aperture as far as rounding can tell.
        if before < -1e-15 {
            return Complex64::ZERO;
        }
        self.field_gain(DVec3::new(before.max(f64::MIN_POSITIVE).sqrt(), u, v))
    }
}

/// `sin x / x`.
fn sinc(x: f64) -> f64 {
    // Below this 1 - x^2/6 is exact to the last bit.
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// `2 J1(x) / x`.
fn jinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 8.0 } else { 2.0 * libm::j1(x) / x }
}

/// Distance beyond which the far-field pattern holds: `2 D^2 / lambda`, m. Zero without an aperture.
pub fn far_field_m(pattern: &Pattern, wavelength_m: f64) -> f64 {
    match pattern {
        Pattern::Isotropic { .. } | Pattern::File { .. } => 0.0,
        Pattern::Rectangle { width_m, height_m } => {
            2.0 * (width_m * width_m + height_m * height_m) / wavelength_m
        }
        Pattern::Ellipse { width_m, height_m } => 2.0 * width_m.max(*height_m).powi(2) / wavelength_m,
    }
}

/// Complex components along y_a and z_a of a port's electric axis.
///
/// An isolation of `I` dB adds the orthogonal port's axis at `10^(-I/20)`; the sum is normalised, so that leakage
/// takes its power from the wanted polarisation.
pub fn port_axis(polarisation: Polarisation, isolation_db: Option<f64>) -> [Complex64; 2] {
    let axis = |polarisation: Polarisation| {
        let real = |y: f64, z: f64| [Complex64::new(y, 0.0), Complex64::new(z, 0.0)];
        let s = FRAC_1_SQRT_2;
        match polarisation {
            Polarisation::H => real(1.0, 0.0),
            Polarisation::V => real(0.0, 1.0),
            Polarisation::R => [Complex64::new(s, 0.0), Complex64::new(0.0, -s)],
            Polarisation::L => [Complex64::new(s, 0.0), Complex64::new(0.0, s)],
        }
    };
    let wanted = axis(polarisation);
    let Some(isolation_db) = isolation_db else { return wanted };
    let other = axis(match polarisation {
        Polarisation::H => Polarisation::V,
        Polarisation::V => Polarisation::H,
        Polarisation::R => Polarisation::L,
        Polarisation::L => Polarisation::R,
    });
    let leak = Decibels(-isolation_db).amplitude_ratio();
    let scale = (1.0 + leak * leak).sqrt().recip();
    std::array::from_fn(|i| (wanted[i] + other[i] * leak) * scale)
}

/// Components `(v.e, h.e)` of the unit field that a port radiates, in the bases of propagation direction `k`.
/// `y_a`, `z_a` are the antenna's axes. On reception `basis_of` is the direction of the scattered wave while the port
/// radiates along its opposite, which projects alike. Zero when the axis lies along `k`.
pub fn field_components(axis: [Complex64; 2], y_a: DVec3, z_a: DVec3, k: DVec3) -> [Complex64; 2] {
    let (v, h) = fsa_basis(k, DVec3::Z);
    // The part along k drops out of the products with v and h.
    let along = |b: DVec3| axis[0] * b.dot(y_a) + axis[1] * b.dot(z_a);
    let (on_v, on_h) = (along(v), along(h));
    let length = (on_v.norm_sqr() + on_h.norm_sqr()).sqrt();
    if length < 1e-12 { [Complex64::ZERO; 2] } else { [on_v / length, on_h / length] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sidelobes_alternate_and_the_back_is_dark() {
        let antenna = Antenna::new(&Pattern::Rectangle { width_m: 4.0, height_m: 0.05 }, 0.03).unwrap();
        let null = 0.03 / 4.0;
        assert!(antenna.field_gain_uv(0.5 * null, 0.0).re > 0.0);
        assert!(antenna.field_gain_uv(1.5 * null, 0.0).re < 0.0);
        assert!(antenna.field_gain_uv(2.5 * null, 0.0).re > 0.0);
        assert_eq!(antenna.field_gain(-DVec3::X), Complex64::ZERO);
        assert_eq!(antenna.field_gain_uv(0.8, 0.8), Complex64::ZERO);
        // First sidelobe -13.26 dB.
        let peak = antenna.field_gain_uv(0.0, 0.0).norm();
        let lobe = antenna.field_gain_uv(1.4303 * null, 0.0).norm();
        assert!((20.0 * (lobe / peak).log10() + 13.26).abs() < 0.01);
    }

    #[test]
    fn leakage_keeps_the_power() {
        for polarisation in [Polarisation::H, Polarisation::V, Polarisation::R, Polarisation::L] {
            for isolation in [None, Some(0.0), Some(25.0)] {
                let axis = port_axis(polarisation, isolation);
                assert!((axis[0].norm_sqr() + axis[1].norm_sqr() - 1.0).abs() < 1e-15);
            }
        }
    }
}
