//! Point targets.

use num_complex::Complex64;

use crate::frames::{Enu, Point, Vector};

/// A point target on a straight course.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Name, unique in a scene.
    pub name: String,
    /// Position at the emission of pulse 0.
    pub position: Point<Enu>,
    /// Velocity, m/s, constant.
    pub velocity: Vector<Enu>,
    /// Scattering matrix `S[p][q]`, sqrt(m^2), p received, q transmitted, order (v, h), in the
    /// forward-scatter alignment of [`crate::geometry::bistatic`]: `|S_pq|^2` is the radar cross section.
    pub scattering: [[Complex64; 2]; 2],
}

impl Target {
    /// The matrix of a sphere (or trihedral) of the given radar cross section, m^2: in the
    /// forward-scatter alignment `diag(1, -1) sqrt(sigma)`, so that HH and VV of a monostatic radar
    /// come out equal.
    pub fn sphere(rcs_m2: f64) -> [[Complex64; 2]; 2] {
        let s = rcs_m2.sqrt();
        let zero = Complex64::ZERO;
        [[Complex64::new(s, 0.0), zero], [zero, Complex64::new(-s, 0.0)]]
    }
}
