//! Point targets at an instant.
//!
//! A target keeps a straight course, `x(t) = x_0 + v t` with `t` from the emission of pulse 0, and
//! scatters the same in every direction: its matrix `S[p][q]` (p received, q transmitted, order (v, h),
//! sqrt(m^2)) holds in the forward-scatter bases of [`crate::geometry::bistatic`].
//!
//! ```
//! use nereus::frames::{Point, Vector};
//! use nereus::scattering::target::Scatterer;
//! use nereus::scene::Target;
//! let buoy = Target {
//!     name: "buoy".into(),
//!     position: Point::new(10.0, 0.0, 1.0),
//!     velocity: Vector::new(0.5, 0.0, 0.0),
//!     scattering: Target::sphere(4.0),
//! };
//! assert_eq!(Scatterer::at(&buoy, 2.0).position, Point::new(11.0, 0.0, 1.0));
//! ```

use num_complex::Complex64;

use crate::frames::{Enu, Point, Vector};
use crate::scene::Target;

/// What scatters at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer<'a> {
    /// Position.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Scattering matrix `S[p][q]`, sqrt(m^2), order (v, h).
    pub matrix: &'a [[Complex64; 2]; 2],
}

impl<'a> Scatterer<'a> {
    /// A target `elapsed_s` seconds after the emission of pulse 0.
    pub fn at(target: &'a Target, elapsed_s: f64) -> Self {
        Self {
            position: target.position + target.velocity * elapsed_s,
            velocity: target.velocity,
            matrix: &target.scattering,
        }
    }
}
