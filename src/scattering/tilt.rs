//! Directions at a facet: its tangent plane, and the path from transmitter over facet to receiver.
//!
//! A facet with slopes `(zx, zy)` has the normal `n = (-zx, -zy, 1)/sqrt(1 + zx^2 + zy^2)` and the local
//! axes `e_x` = reference axis projected on the facet, `e_y = n x e_x`. The reference axis is the scene's
//! x unless another is given; wave vectors handed to a spectrum and slopes handed to a slope density have
//! their components on these axes. (Two choices of the axis differ by an angle of second order in the
//! slopes.)
//!
//! A facet is illuminated if `-ki.n > 0` and seen if `ks.n > 0`.
//!
//! ```
//! use glam::DVec3;
//! use nereus::scattering::tilt::Tangent;
//! let facet = Tangent::from_slopes(0.1, 0.0, DVec3::X);
//! assert!(facet.normal.x < 0.0 && facet.e_x.z > 0.0 && (facet.e_y - DVec3::Y).length() < 1e-15);
//! ```

use glam::DVec3;
use num_complex::Complex64;

use crate::geometry::bistatic::Basis;

/// A scattering matrix `S[p][q]`, p received, q transmitted, order (v, h), forward-scatter alignment.
pub type ScatterMatrix = [[Complex64; 2]; 2];

/// The matrix of nothing.
pub const NO_ECHO: ScatterMatrix = [[Complex64::ZERO; 2]; 2];

/// The plane of a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    /// Unit normal, upwards.
    pub normal: DVec3,
    /// First unit axis in the plane.
    pub e_x: DVec3,
    /// Second unit axis in the plane, `n x e_x`.
    pub e_y: DVec3,
}

impl Tangent {
    /// From the slopes of the surface and the horizontal unit reference axis.
    #[inline]
    pub fn from_slopes(slope_x: f64, slope_y: f64, axis: DVec3) -> Self {
        Self::from_normal(DVec3::new(-slope_x, -slope_y, 1.0).normalize(), axis)
    }

    /// From the unit normal and the horizontal unit reference axis.
    #[inline]
    pub fn from_normal(normal: DVec3, axis: DVec3) -> Self {
        let e_x = (axis - normal * normal.dot(axis)).normalize();
        Self { normal, e_x, e_y: normal.cross(e_x) }
    }

    /// The plane whose slopes relative to this one, on its axes, are given.
    #[inline]
    pub fn tilted(&self, slope_x: f64, slope_y: f64, axis: DVec3) -> Self {
        Self::from_normal((self.normal - self.e_x * slope_x - self.e_y * slope_y).normalize(), axis)
    }
}

/// Unit propagation directions to and from a facet, with their polarisation bases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Transmitter to facet.
    pub ki: DVec3,
    /// Facet to receiver.
    pub ks: DVec3,
    /// Polarisation basis of `ki`.
    pub incident: Basis,
    /// Polarisation basis of `ks`.
    pub scattered: Basis,
}

impl Path {
    /// Path with the bases of the vertical z.
    #[inline]
    pub fn new(ki: DVec3, ks: DVec3) -> Self {
        Self { ki, ks, incident: Basis::of(ki), scattered: Basis::of(ks) }
    }

    /// Cosines `(-ki.n, ks.n)` of the local angles, if the facet is both illuminated and seen.
    #[inline]
    pub fn local_cosines(&self, normal: DVec3) -> Option<(f64, f64)> {
        let (cos_i, cos_s) = (-self.ki.dot(normal), self.ks.dot(normal));
        (cos_i > 0.0 && cos_s > 0.0).then_some((cos_i, cos_s))
    }
}
