//! Fresnel reflection of a plane boundary, air above a medium of relative permittivity `eps`.
//!
//! `Rv = (eps c - r)/(eps c + r)`, `Rh = (c - r)/(c + r)`, `c = cos(theta)`,
//! `r = sqrt(eps - sin^2 theta)` on the branch `Im r <= 0` (time convention `exp(+j w t)`).
//! Source: Ulaby, Moore and Fung, Microwave Remote Sensing, 1982. At grazing (`c -> 0`) both tend to -1;
//! at `eps = 1` both are 0.
//!
//! ```
//! use nereus::scattering::fresnel::reflection;
//! use num_complex::Complex64;
//! let normal = reflection(Complex64::new(4.0, 0.0), 1.0);
//! assert!((normal.v.re - 1.0 / 3.0).abs() < 1e-15 && (normal.h.re + 1.0 / 3.0).abs() < 1e-15);
//! ```

use num_complex::Complex64;

/// Reflection coefficients of the electric field, both polarisations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection {
    /// Electric field in the plane of incidence.
    pub v: Complex64,
    /// Electric field normal to the plane of incidence.
    pub h: Complex64,
}

/// `r = sqrt(eps - sin^2 theta)`, the vertical wave number in the medium over that of air, `Im r <= 0`.
#[inline]
pub fn refracted(eps: Complex64, cos_theta: f64) -> Complex64 {
    // eps - sin^2 written as (eps - 1) + cos^2: no loss of digits near grazing or near eps = 1.
    let square = eps - 1.0 + cos_theta * cos_theta;
    // sqrt(z) from |z|, the larger part first so that nothing cancels (the library's goes through polar
    // form).
    let larger = (0.5 * (square.norm_sqr().sqrt() + square.re.abs())).sqrt();
    if larger == 0.0 {
        Complex64::ZERO
    } else if square.re >= 0.0 {
        let im = square.im / (2.0 * larger);
        if im > 0.0 { Complex64::new(-larger, -im) } else { Complex64::new(larger, im) }
    } else {
        Complex64::new(-square.im / (2.0 * larger), -larger)
    }
}

/// Reflection coefficients at the local incidence angle whose cosine is `cos_theta` (0 to 1).
#[inline]
pub fn reflection(eps: Complex64, cos_theta: f64) -> Reflection {
    let r = refracted(eps, cos_theta);
    Reflection {
        v: quotient(eps * cos_theta - r, eps * cos_theta + r),
        h: quotient(cos_theta - r, cos_theta + r),
    }
}

/// `a / b`; 0 where `b` vanishes, which happens only where the two media are one (eps = 1) at grazing.
#[inline]
pub(crate) fn quotient(a: Complex64, b: Complex64) -> Complex64 {
    let power = b.norm_sqr();
    if power < f64::MIN_POSITIVE { Complex64::ZERO } else { a * b.conj() / power }
}
