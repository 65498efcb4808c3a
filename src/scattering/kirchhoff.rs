//! Kirchhoff scattering in the limit of geometrical optics: specular points of the large waves.
//!
//! `q = ks - ki`, specular normal `m = q/|q|`, local angle `cos th_l = |q|/2`;
//!
//! `rho = Rh(th_l) t t^T + Rv(th_l) w_s w_i^T`, `t = m x ki/|m x ki|`, `w_i = t x ki`, `w_s = t x ks`,
//! `rho_pq = p_s . rho . q_i`;
//!
//! `sigma0_pq = pi (|q|/q_n)^4 |rho_pq|^2 p(zx, zy)`, `q_n = q.n`, `zx = -(q.e_x)/q_n`, `zy = -(q.e_y)/q_n`
//!
//! with `p` the density of slopes relative to the facet. Small waves riding on the specular points weaken
//! them by `|R|^2 exp(-4 k^2 cos^2 th_l s^2)`, `s^2` their height variance (m^2), `k` the radar wave number.
//!
//! Source: Barrick, IEEE TAP 16, 449 (1968). Monostatic: `pi sec^4 |R(0)|^2 p`. Limits: radii of curvature
//! well above the wavelength; no multiple reflections. Straight ahead (`q -> 0`) there is no
//! specular normal: the contribution is 0.
//!
//! ```
//! use glam::DVec3;
//! use nereus::scattering::kirchhoff::Specular;
//! use nereus::scattering::tilt::Path;
//! use num_complex::Complex64;
//! let nadir = Path::new(DVec3::NEG_Z, DVec3::Z);
//! let mirror = Specular::new(Complex64::new(4.0, 0.0), &nadir).unwrap();
//! assert!((mirror.reflection[0][0].norm() - 1.0 / 3.0).abs() < 1e-15);
//! ```

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;

use super::fresnel::reflection;
use super::slope_pdf::SlopePdf;
use super::tilt::{Path, ScatterMatrix, Tangent};

/// `|q|` below which transmitter, facet and receiver count as one line, and `q_n/|q|` below which the
/// specular normal counts as lying in the facet's plane.
pub const LEAST_BEND: f64 = 1e-6;

/// The bend of a path: which mirror would send the wave from transmitter to receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// `ks - ki`.
    pub q: DVec3,
    /// `|q|`.
    pub q_norm: f64,
}

impl Bend {
    /// The bend of a path; `None` when the path is (nearly) straight.
    #[inline]
    pub fn new(path: &Path) -> Option<Self> {
        let q = path.ks - path.ki;
        let q_norm = q.length();
        (q_norm >= LEAST_BEND).then_some(Self { q, q_norm })
    }

    /// Components of the polarisation vectors (v, h) of the same path along `t` and across it, along `w`:
    /// incident, scattered.
    #[inline]
    pub fn components(&self, path: &Path) -> [[[f64; 2]; 2]; 2] {
        let across = (self.q / self.q_norm).cross(path.ki);
        let sine = across.length();
        let t = if sine < 1e-12 { path.incident.h } else { across / sine };
        [(path.incident, path.ki), (path.scattered, path.ks)].map(|(basis, k)| {
            let w = t.cross(k);
            [basis.v, basis.h].map(|p| [p.dot(t), p.dot(w)])
        })
    }

    /// `rho_pq`, order (v, h), of the same path.
    #[inline]
    pub fn reflection(&self, eps: Complex64, path: &Path) -> ScatterMatrix {
        let r = reflection(eps, (0.5 * self.q_norm).min(1.0));
        let [incident, scattered] = self.components(path);
        let scattered = scattered.map(|[p_t, p_w]| (r.h * p_t, r.v * p_w));
        scattered.map(|(p_t, p_w)| incident.map(|[q_t, q_w]| p_t * q_t + p_w * q_w))
    }

    /// The same of a perfect mirror, but for the sign: how it turns the polarisation. Of unit columns and
    /// rows.
    #[inline]
    pub fn turn(&self, path: &Path) -> [[f64; 2]; 2] {
        let [incident, scattered] = self.components(path);
        scattered.map(|[p_t, p_w]| incident.map(|[q_t, q_w]| p_t * q_t - p_w * q_w))
    }

    /// Slopes relative to the facet at which it mirrors the wave to the receiver, and `|q|/q_n`. `None` when
    /// no finite slope does.
    #[inline]
    pub fn slopes(&self, tangent: &Tangent) -> Option<(f64, f64, f64)> {
        let q_n = self.q.dot(tangent.normal);
        if q_n < LEAST_BEND * self.q_norm {
            return None;
        }
        Some((-self.q.dot(tangent.e_x) / q_n, -self.q.dot(tangent.e_y) / q_n, self.q_norm / q_n))
    }

    /// `sqrt(pi p) (|q|/q_n)^2`: what multiplies `rho` to give amplitudes per square root of
    /// facet area. Zero when the facet is not both illuminated and seen.
    #[inline]
    pub fn weight(&self, tangent: &Tangent, path: &Path, pdf: &SlopePdf) -> f64 {
        if path.local_cosines(tangent.normal).is_none() {
            return 0.0;
        }
        match self.slopes(tangent) {
            Some((slope_x, slope_y, secant)) => (PI * pdf.density(slope_x, slope_y)).sqrt() * secant * secant,
            None => 0.0,
        }
    }

    /// `exp(-2 k^2 cos^2 th_l s^2)`, the factor on the amplitude of small waves of height variance `s^2`.
    #[inline]
    pub fn roughness(&self, wavenumber_radpm: f64, height_variance_m2: f64) -> f64 {
        let phase = wavenumber_radpm * self.q_norm;
        (-0.5 * phase * phase * height_variance_m2).exp()
    }
}

/// What does not depend on the facet: the mirror of a path and its reflection coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// The mirror.
    pub bend: Bend,
    /// `rho_pq`, order (v, h).
    pub reflection: ScatterMatrix,
}

impl Specular {
    /// The mirror of a path; `None` when the path is (nearly) straight.
    #[inline]
    pub fn new(eps: Complex64, path: &Path) -> Option<Self> {
        let bend = Bend::new(path)?;
        Some(Self { bend, reflection: bend.reflection(eps, path) })
    }

    /// [`Bend::weight`].
    #[inline]
    pub fn weight(&self, tangent: &Tangent, path: &Path, pdf: &SlopePdf) -> f64 {
        self.bend.weight(tangent, path, pdf)
    }

    /// [`Bend::roughness`].
    #[inline]
    pub fn roughness(&self, wavenumber_radpm: f64, height_variance_m2: f64) -> f64 {
        self.bend.roughness(wavenumber_radpm, height_variance_m2)
    }
}
