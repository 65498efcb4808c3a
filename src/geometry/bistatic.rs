//! Polarisation bases of the forward-scatter alignment (FSA), and angles.
//!
//! For a propagation direction `k`: `h = z x k / |z x k|`, `v = h x k`, so (v, h, k) is right-handed. Both the
//! wave that comes in (transmitter to scatterer) and the wave that leaves (scatterer to receiver) are
//! described in this basis of their own direction. `h(-k) = -h(k)`, `v(-k) = v(k)`.
//!
//! ```
//! use glam::DVec3;
//! use nereus::geometry::bistatic::fsa_basis;
//! let (v, h) = fsa_basis(DVec3::X, DVec3::Z);
//! assert_eq!((v, h), (-DVec3::Z * -1.0, DVec3::Y));
//! ```

use glam::DVec3;

/// Below this `|up x k|` a direction counts as vertical.
const VERTICAL: f64 = 1e-12;

/// The vectors `(v, h)` of a propagation direction, with respect to `up` (unit vectors). Along `up` itself
/// `h = y`.
pub fn fsa_basis(k: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let across = up.cross(k);
    let length = across.length();
    let h = if length < VERTICAL { DVec3::Y } else { across / length };
    (h.cross(k), h)
}

/// Angle between two directions, radians, accurate near 0 and pi.
pub fn angle_rad(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
