//! Polarisation bases of a bistatic path (forward-scatter alignment).
//!
//! For a unit propagation direction `k` and a unit normal `up` of the reference plane,
//!
//! `h = up x k / |up x k|`, `v = h x k`,
//!
//! so that (v, h, k) is right-handed, for the incident wave (transmitter to scatterer) and for the
//! scattered one (scatterer to receiver) alike. `h(-k) = -h(k)`, `v(-k) = v(k)`.
//! Where `k` is along `up` the plane of incidence is undefined and `h` is +y (made normal to `k`).
//!
//! ```
//! use glam::DVec3;
//! use nereus::geometry::bistatic::fsa_basis;
//! let (v, h) = fsa_basis(DVec3::X, DVec3::Z);
//! assert_eq!((v, h), (DVec3::Z, DVec3::Y));
//! ```

use glam::DVec3;

/// `|up x k|` below which `k` counts as being along `up`.
pub const NADIR_SINE: f64 = 1e-12;

/// The unit vectors `(v, h)` of the unit propagation direction `k` with respect to the unit normal `up`.
pub fn fsa_basis(k: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let across = up.cross(k);
    let sine = across.length();
    let h = if sine < NADIR_SINE { nadir_h(k) } else { across / sine };
    (h.cross(k), h)
}

/// `+y` made normal to `k`, or `+x` where `k` itself is along y.
fn nadir_h(k: DVec3) -> DVec3 {
    let across = DVec3::Y - k * k.y;
    across.try_normalize().unwrap_or(DVec3::X)
}
