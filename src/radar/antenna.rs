//! Field gain and polarisation of an antenna.
//!
//! **Field gain** `g` (complex, `|g|^2` = power gain) of a uniformly lit aperture in direction cosines
//! `u = d.y_a`, `v = d.z_a`, with full dimensions `a` along y and `b` along z:
//!
//! * rectangle: `g = sqrt(4 pi a b) / lambda  sinc(pi a u / lambda) sinc(pi b v / lambda)`, `sinc x = sin x / x`;
//! * ellipse: `g = sqrt(4 pi (pi a b / 4)) / lambda  2 J1(X) / X`, `X = (pi / lambda) hypot(a u, b v)`;
//! * isotropic: constant;
//! * a measured pattern ([`crate::radar::pattern`]).
//!
//! The sign of the sidelobes is kept. No obliquity factor. Apertures are dark behind (`d.x_a <= 0`).
//!
//! **Polarisation.** The port's electric axis `e_a` is `y_a` (H), `z_a` (V), `(y_a - j z_a)/sqrt 2` (R) or
//! `(y_a + j z_a)/sqrt 2` (L). Along the propagation direction `k` the field is
//! `e = e_a - (e_a.k) k`, scaled to unit length, with components `(v.e, h.e)`. A receiver is described by
//! the field that it would radiate back along `-k_s`, in the basis of `k_s`, **without** conjugate: what
//! it hears is `e_r^T S e_t`. A port that leaks has `e_a + eps e_x` for `e_a`, with `e_x` the other port of
//! the pair and `eps = 10^(-isolation/20)`, real; the sum is scaled to unit length afterwards, since the
//! port's power is the power that leaves, leak included (20 dB of isolation cost the wanted
//! polarisation 0.043 dB). Along the electric axis itself nothing is radiated.
//!
//! ```
//! use nereus::radar::antenna::Antenna;
//! use nereus::frames::Vector;
//! // 4 m x 5 cm at 10 GHz: 34.47 dBi.
//! let antenna = Antenna::Rectangle { width_m: 4.0, height_m: 0.05, wavelength_m: 0.029_979_245_8 };
//! let g = antenna.field_gain(Vector::new(1.0, 0.0, 0.0));
//! assert!((20.0 * g.norm().log10() - 34.47).abs() < 0.005);
//! ```

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::frames::{self, Vector};
use crate::geometry::bistatic::Basis;
use crate::radar::pattern::{GridPattern, PatternError};
use crate::scene::radar::{Pattern, Polarisation};
use crate::units::Decibels;

/// An antenna ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub enum Antenna {
    /// The same everywhere.
    Isotropic {
        /// Field gain.
        gain: f64,
    },
    /// Uniformly lit rectangle.
    Rectangle {
        /// Full width a along y, m.
        width_m: f64,
        /// Full height b along z, m.
        height_m: f64,
        /// Wavelength, m.
        wavelength_m: f64,
    },
    /// Uniformly lit ellipse.
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
    pub fn open(pattern: &Pattern, wavelength_m: f64) -> Result<Self, PatternError> {
        Ok(match *pattern {
            Pattern::Isotropic { gain_dbi } => Self::Isotropic { gain: Decibels(gain_dbi).amplitude_ratio() },
            Pattern::Rectangle { width_m, height_m } => Self::Rectangle { width_m, height_m, wavelength_m },
            Pattern::Ellipse { width_m, height_m } => Self::Ellipse { width_m, height_m, wavelength_m },
            Pattern::File { ref path, floor_dbi } => Self::Grid(GridPattern::open(path, floor_dbi)?),
        })
    }

    /// Field gain towards a unit direction in the antenna frame.
    pub fn field_gain(&self, direction: Vector<frames::Antenna>) -> Complex64 {
        let d = direction.raw();
        match self {
            Self::Isotropic { gain } => (*gain).into(),
            Self::Grid(grid) => grid.field_gain(d.y.atan2(d.x), d.z.clamp(-1.0, 1.0).asin()),
            Self::Rectangle { .. } | Self::Ellipse { .. } if d.x <= 0.0 => Complex64::ZERO,
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

    /// Distance from which the far-field pattern holds, `2 D^2 / lambda`, D the largest dimension of the
    /// aperture, m. `None` for a measured pattern, whose aperture is not known.
    pub fn far_field_m(&self) -> Option<f64> {
        match self {
            Self::Isotropic { .. } => Some(0.0),
            Self::Rectangle { width_m, height_m, wavelength_m } => {
                Some(2.0 * (width_m * width_m + height_m * height_m) / wavelength_m)
            }
            Self::Ellipse { width_m, height_m, wavelength_m } => {
                Some(2.0 * width_m.max(*height_m).powi(2) / wavelength_m)
            }
            Self::Grid(_) => None,
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

/// Axes of an antenna frame in ENU (columns x, y, z), as the polarisation routines want them.
pub type Axes = DMat3;

/// The field of a port: shares of the antenna's axes y and z, before what lies along the ray is taken out and the rest made unit.
pub fn port_shares(port: Polarisation, cross_pol_isolation_db: Option<f64>) -> [Complex64; 2] {
    let leak = cross_pol_isolation_db.map_or(0.0, |db| Decibels(-db).amplitude_ratio());
    let circular = |y: f64, z: f64| [Complex64::new(y * FRAC_1_SQRT_2, 0.0), Complex64::new(0.0, z * FRAC_1_SQRT_2)];
    match port {
        Polarisation::H => [1.0.into(), leak.into()],
        Polarisation::V => [leak.into(), 1.0.into()],
        Polarisation::R => circular(1.0 + leak, leak - 1.0),
        Polarisation::L => circular(1.0 + leak, 1.0 - leak),
    }
}

/// Components `(v, h)` along the propagation direction `k` of the field of a port, unit length; zero
/// along the port's electric axis. For a receiver, `k` is the direction of the wave that arrives: the
/// field it would radiate along `-k` lies in the same plane.
pub fn field(
    axes: &Axes,
    port: Polarisation,
    cross_pol_isolation_db: Option<f64>,
    k: DVec3,
    basis: &Basis,
) -> [Complex64; 2] {
    let [y, z] = port_shares(port, cross_pol_isolation_db);
    // e_a + eps e_x as a real and an imaginary vector.
    let (re, im) = (axes.y_axis * y.re + axes.z_axis * z.re, axes.y_axis * y.im + axes.z_axis * z.im);
    let (re, im) = (re - k * re.dot(k), im - k * im.dot(k));
    let norm = (re.length_squared() + im.length_squared()).sqrt();
    // Rounding leaves a few 1e-16 along the axis, which is no field.
    if norm < 1e-12 {
        return [Complex64::ZERO; 2];
    }
    [basis.v, basis.h].map(|p| Complex64::new(p.dot(re), p.dot(im)) / norm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_field_of_the_paper_s_antenna() {
        let antenna = Antenna::Rectangle { width_m: 4.0, height_m: 0.05, wavelength_m: 0.03 };
        assert!((antenna.far_field_m().unwrap() - 1067.0).abs() < 1.0);
    }

    #[test]
    fn sidelobes_alternate_and_the_back_is_dark() {
        let antenna = Antenna::Rectangle { width_m: 4.0, height_m: 0.05, wavelength_m: 0.03 };
        let at = |u: f64| antenna.field_gain(Vector::new((1.0 - u * u).sqrt(), u, 0.0)).re;
        assert!(at(0.0) > 0.0 && at(0.0107) < 0.0 && at(0.0185) > 0.0);
        // First sidelobe of a uniform aperture: -13.26 dB.
        assert!((20.0 * (at(0.010_727) / at(0.0)).abs().log10() + 13.26).abs() < 0.005);
        assert_eq!(antenna.field_gain(Vector::new(-1.0, 0.0, 0.0)), Complex64::ZERO);
    }

    #[test]
    fn a_leaking_port_keeps_its_power() {
        let k = DVec3::X;
        let basis = Basis::of(k);
        for port in [Polarisation::H, Polarisation::V, Polarisation::R, Polarisation::L] {
            let clean = field(&Axes::IDENTITY, port, None, k, &basis);
            let leaky = field(&Axes::IDENTITY, port, Some(20.0), k, &basis);
            let power = |e: [Complex64; 2]| e[0].norm_sqr() + e[1].norm_sqr();
            let wanted = (clean[0].conj() * leaky[0] + clean[1].conj() * leaky[1]).norm();
            assert!((power(clean) - 1.0).abs() < 1e-15 && (power(leaky) - 1.0).abs() < 1e-15);
            // 1 / sqrt(1 + 0.01) of the amplitude is left in the wanted polarisation.
            assert!((wanted - 1.01f64.sqrt().recip()).abs() < 1e-15, "{port:?}: {wanted}");
        }
    }

    #[test]
    fn nothing_along_the_electric_axis() {
        let basis = Basis::of(DVec3::Y);
        let e = field(&Axes::IDENTITY, Polarisation::H, None, DVec3::Y, &basis);
        assert_eq!(e, [Complex64::ZERO; 2]);
    }
}
