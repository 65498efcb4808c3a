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
//! [`amplitude`] uses the same matrix written without local bases: with unit fields
//! `e` and `e'` of the incident wave and of the scattered one reversed in time, and the factors
//! `te = 1/(c+r)`, `tm = 1/(eps c+r)` of each, the fields just inside a plane boundary are (less `2c`)
//! `E_t = te e_t +- (eps-1) te tm (e.n) k_t` and `E_z = -tm (e.n)` (`k_t`: tangential part of the direction,
//! plus incident, minus scattered), and
//!
//! `ci cs (Rs^T a Ri)_pq = ci cs (eps-1) [E'_t . E_t + eps E'_z E_z]`,
//!
//! free of singular cases at nadir (derived from the above with `eps c^2 - r^2 = -(eps-1) sin^2`; tests
//! compare it with the above).
//!
//! `k` is the radar wave number (rad/m), `Psi` the symmetrised two-sided height spectrum (m^4, its
//! integral over the whole plane is the height variance): `Psi_sym(K) = [Psi(K) + Psi(-K)]/2`.
//! `sigma0` is per unit area of the facet itself. Amplitudes here are `A`, `|A_pq|^2 = sigma0_pq`,
//! rotated from the facet's bases into those of the vertical.
//!
//! Sources: Ulaby, Moore, Fung 1982; Valenzuela, Boundary-Layer Met. 13, 61 (1978).
//! Limits: heights above the cutoff well below the wavelength, slopes small; first order has no
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

use glam::DVec3;
use num_complex::Complex64;

use super::fresnel::{quotient, refracted};
use super::tilt::{NO_ECHO, Path, ScatterMatrix, Tangent};

/// Bragg wave number below which the spectrum counts as nothing, rad/m (the forward direction).
pub const LEAST_BRAGG_RADPM: f64 = 1e-9;

/// Bragg wave vector `k (ks - ki)` on the facet's axes, rad/m.
#[inline]
pub fn bragg_vector(wavenumber_radpm: f64, tangent: &Tangent, path: &Path) -> (f64, f64) {
    let q = path.ks - path.ki;
    (wavenumber_radpm * q.dot(tangent.e_x), wavenumber_radpm * q.dot(tangent.e_y))
}

/// Amplitude matrix per square root of facet area, in the bases of the vertical; `psi(kx, ky)` is the
/// symmetrised spectrum on the facet's axes, m^4. Zero when the facet is not both illuminated and seen.
#[inline]
pub fn amplitude(
    eps: Complex64,
    wavenumber_radpm: f64,
    tangent: &Tangent,
    path: &Path,
    psi: impl Fn(f64, f64) -> f64,
) -> ScatterMatrix {
    let Some((cos_i, cos_s)) = path.local_cosines(tangent.normal) else { return NO_ECHO };
    let contrast = eps - 1.0;
    if contrast == Complex64::ZERO {
        return NO_ECHO;
    }
    let (kx, ky) = bragg_vector(wavenumber_radpm, tangent, path);
    if kx * kx + ky * ky < LEAST_BRAGG_RADPM * LEAST_BRAGG_RADPM {
        return NO_ECHO;
    }
    // `max` also turns a NaN of a foreign spectrum into nothing.
    let density = psi(kx, ky).max(0.0);
    let scale =
        contrast * (FOUR_ROOT_PI * wavenumber_radpm * wavenumber_radpm * cos_i * cos_s * density.sqrt());

    // Tangential parts of the directions; the sign of the scattered one is that of the time-reversed wave.
    let n = tangent.normal;
    let along_i = path.ki + n * cos_i;
    let along_s = n * cos_s - path.ks;
    // E'_t . E_t + eps E'_z E_z is bilinear in the unit fields: four complex constants and real products.
    let (te_i, tm_i) = transmission(eps, cos_i);
    let (te_s, tm_s) = transmission(eps, cos_s);
    let (bend_i, bend_s) = (contrast * tm_i, contrast * tm_s);
    let tangential = scale * te_i * te_s;
    let incident_bend = tangential * bend_i;
    let scattered_bend = tangential * bend_s;
    let normal = incident_bend * bend_s * along_i.dot(along_s) + scale * eps * tm_i * tm_s - tangential;

    let entry = |p: DVec3, q: DVec3| {
        let (p_normal, q_normal) = (p.dot(n), q.dot(n));
        tangential * p.dot(q)
            + incident_bend * (p.dot(along_i) * q_normal)
            + scattered_bend * (q.dot(along_s) * p_normal)
            + normal * (p_normal * q_normal)
    };
    let row = |p: DVec3| [entry(p, path.incident.v), entry(p, path.incident.h)];
    [row(path.scattered.v), row(path.scattered.h)]
}

/// `4 sqrt(pi)`.
const FOUR_ROOT_PI: f64 = 7.089_815_403_622_064;

/// `1/(c + r)` and `1/(eps c + r)`.
#[inline]
fn transmission(eps: Complex64, cos_theta: f64) -> (Complex64, Complex64) {
    let r = refracted(eps, cos_theta);
    (quotient(Complex64::ONE, r + cos_theta), quotient(Complex64::ONE, eps * cos_theta + r))
}
