//! First-order small-perturbation (Bragg) scattering, full bistatic and polarimetric.
//!
//! `sigma0_pq = 16 pi k^4 ci^2 cs^2 |a_pq|^2 Psi(K_B)`, `K_B = k (ks - ki)` in the facet's plane,
//! with the polarisation amplitudes (`ci`, `cs` cosines of the local angles, `ri = sqrt(eps - sin^2)`,
//! `d` the azimuth of `ks` minus that of `ki`: 0 forward, pi back)
//!
//! ```text
//! a_hh = (eps-1) cos d / [(ci+ri)(cs+rs)]
//! a_vv = (eps-1) [eps sin_i sin_s - cos d ri rs] / [(eps ci+ri)(eps cs+rs)]
//! a_hv = (eps-1) ri sin d / [(eps ci+ri)(cs+rs)]
//! a_vh = (eps-1) rs sin d / [(ci+ri)(eps cs+rs)]
//! ```
//!
//! `k` is the radar wave number (rad/m), `Psi` the symmetrised two-sided height spectrum (m^4, its
//! integral over the whole plane is the height variance): `Psi_sym(K) = [Psi(K) + Psi(-K)]/2`.
//! `sigma0` is per unit area of the facet itself. Amplitudes here are `A`, `|A_pq|^2 = sigma0_pq`,
//! rotated from the facet's bases into those of the vertical.
//!
//! Sources: Ulaby, Moore, Fung 1982; Valenzuela, Boundary-Layer Met. 13, 61 (1978).
//! Limits: heights above the cut well below the wavelength, slopes small; first order has no
//! cross-polarised backscatter of an untilted facet.
//!
//! ```
//! use glam::DVec3;
//! use nereus::scattering::spm::amplitude;
//! use nereus::scattering::tilt::{Path, Tangent};
//! use num_complex::Complex64;
//! let (k, eps) = (209.6, Complex64::new(55.1, -37.5));
//! let down = DVec3::new(0.5f64.sqrt(), 0.0, -0.5f64.sqrt());
//! let flat = Tangent::from_slopes(0.0, 0.0, DVec3::X);
//! let a = amplitude(eps, k, &flat, &Path::new(down, -down), |kx, ky| 1e-3 / (kx * kx + ky * ky).powi(2));
//! assert!(a[0][0].norm() > a[1][1].norm()); // VV above HH
//! ```

use std::f64::consts::PI;

use num_complex::Complex64;

use super::fresnel::{quotient, refracted};
use super::tilt::{NO_ECHO, Path, ScatterMatrix, Tangent};
use crate::geometry::bistatic::fsa_basis;

/// Bragg wave number below which the spectrum counts as nothing, rad/m (the forward direction).
pub const LEAST_BRAGG_RADPM: f64 = 1e-9;

/// Polarisation amplitudes `a[p][q]`, order (v, h), in the bases of the facet. `azimuth` is the cosine and
/// sine of `d`.
#[inline]
pub fn alphas(eps: Complex64, cos_i: f64, cos_s: f64, azimuth: (f64, f64)) -> ScatterMatrix {
    let (cos_d, sin_d) = azimuth;
    let contrast = eps - 1.0;
    if contrast == Complex64::ZERO {
        return NO_ECHO;
    }
    let (ri, rs) = (refracted(eps, cos_i), refracted(eps, cos_s));
    let sines = ((1.0 - cos_i * cos_i).max(0.0) * (1.0 - cos_s * cos_s).max(0.0)).sqrt();
    let (tm_i, te_i) = (eps * cos_i + ri, cos_i + ri);
    let (tm_s, te_s) = (eps * cos_s + rs, cos_s + rs);
    [
        [
            quotient(contrast * (eps * sines - cos_d * ri * rs), tm_i * tm_s),
            quotient(contrast * rs * sin_d, te_i * tm_s),
        ],
        [quotient(contrast * ri * sin_d, tm_i * te_s), quotient(contrast * cos_d, te_i * te_s)],
    ]
}

/// Bragg wave vector `k (ks - ki)` on the facet's axes, rad/m.
#[inline]
pub fn bragg_vector(wavenumber_radpm: f64, tangent: &Tangent, path: &Path) -> (f64, f64) {
    let q = path.ks - path.ki;
    (wavenumber_radpm * q.dot(tangent.e_x), wavenumber_radpm * q.dot(tangent.e_y))
}

/// Amplitude matrix per square root of facet area, in the bases of the vertical; `psi(kx, ky)` is the
/// symmetrised spectrum on the facet's axes, m^4. Zero when the facet is not both lit and seen.
#[inline]
pub fn amplitude(
    eps: Complex64,
    wavenumber_radpm: f64,
    tangent: &Tangent,
    path: &Path,
    psi: impl Fn(f64, f64) -> f64,
) -> ScatterMatrix {
    let Some((cos_i, cos_s)) = path.local_cosines(tangent.normal) else { return NO_ECHO };
    let (kx, ky) = bragg_vector(wavenumber_radpm, tangent, path);
    if kx.hypot(ky) < LEAST_BRAGG_RADPM {
        return NO_ECHO;
    }
    // `max` also turns a NaN of a foreign spectrum into nothing.
    let density = psi(kx, ky).max(0.0);
    let scale = 4.0 * PI.sqrt() * wavenumber_radpm * wavenumber_radpm * cos_i * cos_s * density.sqrt();

    let (v_i, h_i) = fsa_basis(path.ki, tangent.normal);
    let (v_s, h_s) = fsa_basis(path.ks, tangent.normal);
    let azimuth = (h_i.dot(h_s), tangent.normal.dot(h_i.cross(h_s)));
    let local = alphas(eps, cos_i, cos_s, azimuth);

    let (v, h) = path.incident;
    let into = [[v_i.dot(v), v_i.dot(h)], [h_i.dot(v), h_i.dot(h)]];
    let (v, h) = path.scattered;
    let out_of = [[v_s.dot(v), v_s.dot(h)], [h_s.dot(v), h_s.dot(h)]];
    let mut global = NO_ECHO;
    for (p, row) in global.iter_mut().enumerate() {
        for (q, entry) in row.iter_mut().enumerate() {
            let from_v = local[0][0] * into[0][q] + local[0][1] * into[1][q];
            let from_h = local[1][0] * into[0][q] + local[1][1] * into[1][q];
            *entry = (from_v * out_of[0][p] + from_h * out_of[1][p]) * scale;
        }
    }
    global
}
