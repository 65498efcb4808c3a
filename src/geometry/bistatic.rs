//! Polarisation bases and angles of a bistatic path.
//!
//! For a unit propagation direction `k` (transmitter to scatterer, or scatterer to receiver):
//!
//! `h = z x k / |z x k|`, `v = h x k`; `(v, h, k)` is right-handed (forward-scatter alignment).
//!
//! Along the vertical (`|z x k| < 1e-12`), `h = y`. Turning the direction round gives `h(-k) = -h(k)`,
//! `v(-k) = v(k)`, so that reciprocity of a scattering matrix reads
//! `S_pq(ks, ki) = s_p s_q S_qp(-ki, -ks)` with `s_v = +1`, `s_h = -1`.
//!
//! Angles are between the vertical and the way back to the antenna: 0 at nadir, pi/2 at grazing.
//!
//! ```
//! use glam::DVec3;
//! use nereus::geometry::bistatic::Basis;
//! let basis = Basis::of(DVec3::new(1.0, 0.0, 0.0));
//! assert_eq!(basis.h, DVec3::Y);
//! assert_eq!(basis.v, DVec3::NEG_Z);
//! ```

use glam::DVec3;

/// Sine of the angle to the vertical below which `h` is taken as `y`.
const VERTICAL_SINE: f64 = 1e-12;

/// Polarisation unit vectors of a propagation direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// "Vertical", in the plane of `k` and the vertical.
    pub v: DVec3,
    /// Horizontal.
    pub h: DVec3,
}

impl Basis {
    /// The basis of a unit direction, with respect to the vertical.
    pub fn of(k: DVec3) -> Self {
        Self::about(k, DVec3::Z)
    }

    /// The basis of a unit direction with respect to another unit normal than the vertical, such as that of a
    /// tilted facet. Along the normal, `h` is `y` made normal to `k` (or `x` where `k` itself is along `y`).
    pub fn about(k: DVec3, normal: DVec3) -> Self {
        let level = normal.cross(k);
        let sine = level.length();
        let h = if sine < VERTICAL_SINE {
            (DVec3::Y - k * k.y).try_normalize().unwrap_or(DVec3::X)
        } else {
            level / sine
        };
        Self { v: h.cross(k), h }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_right_handed_and_turn_round() {
        for k in [DVec3::new(0.3, -0.5, -0.8), DVec3::new(-1.0, 1e-3, 0.2), DVec3::new(0.0, 1.0, 0.0)] {
            let k = k.normalize();
            let (there, back) = (Basis::of(k), Basis::of(-k));
            assert!((there.v.cross(there.h) - k).length() < 1e-15);
            assert!((there.h + back.h).length() < 1e-15 && (there.v - back.v).length() < 1e-15);
        }
    }

    #[test]
    fn nadir_has_a_basis() {
        let basis = Basis::of(DVec3::NEG_Z);
        assert_eq!((basis.h, basis.v), (DVec3::Y, DVec3::NEG_X));
    }
}
