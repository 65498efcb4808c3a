//! What breaking waves return: the cross section of a breaker for each square metre that breaks.
//!
//! Kudryavtsev, Hauser, Caudal and Chapron 2003 take a breaker for a rough surface of large slopes, which has
//! specular points, and for a front face of vertical size, which returns the same at all angles:
//!
//! `sigma_hh = (|q|/q_z)^4 / s^2 exp(-|z - z_0|^2/s^2) + eps/s^2` , `s^2 = 0.19` , `eps = 0.005` ,
//! `z = -q_xy/q_z` , `z_0 = -0.05 t`
//!
//! (in backscatter `sec^4(th)/s^2 exp(-tan^2(th)/s^2) + eps/s^2`, -15.8 dB near grazing; their tilt `z_0` of
//! the mean front face along its travel `t` makes the echo stronger upwind than downwind). The sea has
//! `W sigma` on top of what it returns without breaking, `W` its coverage by breakers
//! ([`coverage`](crate::sea::breaking::coverage)).
//!
//! **VV over HH.** At moderate incidence breakers hardly know polarisation; near grazing HH exceeds VV by
//! some 5 dB (Liu, Frasier and McIntosh 1998, at 3 degrees). What makes the difference is the water before
//! the front face, which reflects H almost wholly and V near Brewster's angle hardly (Trizna 1997). Each of
//! the two ways has the straight ray and the reflected one, in backscatter the same both ways, of a phase
//! that the height of the breaker makes random: the mean of `|1 + R e^{j psi}|^4` is `1 + 4|R|^2 + |R|^4`,
//! hence
//!
//! `sigma_vv/sigma_hh = p(th_i) p(th_s)` , `p^2 = (1 + 4|R_v|^2 + |R_v|^4)/(1 + 4|R_h|^2 + |R_h|^4)` ,
//!
//! `R` of Fresnel on level water. X band: -0.5 dB at 30 degrees of incidence, -5.2 dB at 3 degrees grazing.
//! Nothing is fitted to that figure. The level of HH is left as published.
//!
//! **HV** (Kudryavtsev, Fan, Zhang, Mouche and Chapron 2019): waves on the breaker scatter by Bragg, at a
//! saturation of `B = 0.01`, and its slopes across the look turn the polarisation:
//!
//! `sigma_hv = pi cot^4(th) |a_vv - a_hh|^2 B s^2/(2 sin^2(th))` ,
//!
//! `a` as in [`spm`](super::spm) without its cosines; `th` is the incidence, in bistatic geometry half the
//! angle of the bisector, and at least [`LEAST_CROSS_RAD`], below which the expression was not meant.
//!
//! Limits: made for backscatter between nadir and some 60 degrees in C to Ku band; near grazing the part that
//! does not depend on angle decides, and shadows are not in it. Bistatic values are those of the bisector.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use num_complex::Complex64;

use super::fresnel::{quotient, reflection, refracted};
use super::tilt::Path;
use crate::sea::breaking::{DIRECTIONS, coverage};

/// Slope variance of a breaker's surface, and the vertical size of its front face over its horizontal one.
const SLOPE_VARIANCE: f64 = 0.19;
const FRONT_FACE: f64 = 0.005;
/// Tilt of the mean front face along its travel.
const TILT: f64 = 0.05;
/// Saturation of the waves on a breaker.
const SATURATION: f64 = 0.01;
/// Incidence below which the cross-polarised cross section is held, rad.
pub const LEAST_CROSS_RAD: f64 = TAU / 18.0;

/// Cross sections of a breaker per area that breaks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Returned {
    /// H received, H transmitted.
    pub hh: f64,
    /// V received, V transmitted.
    pub vv: f64,
    /// Either cross-polarised channel.
    pub cross: f64,
}

/// Cross sections over a path, of a breaker that runs along the horizontal unit vector `travel`, over water
/// of a permittivity.
///
/// ```
/// use glam::DVec3;
/// use nereus::scattering::{breaking::breaker, tilt::Path};
/// use num_complex::Complex64;
/// let grazing = DVec3::new(87f64.to_radians().sin(), 0.0, -87f64.to_radians().cos());
/// let back = breaker(Complex64::new(55.0, -37.5), &Path::new(grazing, -grazing), -DVec3::X);
/// assert!((10.0 * back.hh.log10() + 15.8).abs() < 0.05);
/// assert!((10.0 * (back.hh / back.vv).log10() - 5.2).abs() < 0.1);
/// ```
pub fn breaker(permittivity: Complex64, path: &Path, travel: DVec3) -> Returned {
    let q = path.ks - path.ki;
    let (length, cos_i, cos_s) = (q.length(), -path.ki.z, path.ks.z);
    // From below, or straight through: nothing.
    if !(cos_i > 0.0 && cos_s > 0.0 && length > 1e-6) {
        return Returned::default();
    }
    let off = DVec3::new(-q.x / q.z + TILT * travel.x, -q.y / q.z + TILT * travel.y, 0.0);
    let steep = (-off.length_squared() / SLOPE_VARIANCE).exp();
    // Where the exponential is nothing the secant may be infinite.
    let specular = if steep > 0.0 { (length / q.z).powi(4) * steep / SLOPE_VARIANCE } else { 0.0 };
    let hh = specular + FRONT_FACE / SLOPE_VARIANCE;
    let ratio = (v_over_h(permittivity, cos_i) * v_over_h(permittivity, cos_s)).sqrt();
    let bisector = (q.z / length).clamp(0.0, LEAST_CROSS_RAD.cos());
    Returned { hh, vv: hh * ratio, cross: cross(permittivity, bisector) }
}

/// What breaking waves add to the cross section of a sea per area, `[received][transmitted]`, v before h: the
/// mean over the directions in which they run, about a wind that blows towards an angle of x, rad, times
/// their coverage in its speed at 10 m, m/s.
pub fn sigma0(permittivity: Complex64, path: &Path, downwind_rad: f64, u10_mps: f64) -> [[f64; 2]; 2] {
    let mut sigma0 = [[0.0; 2]; 2];
    for (off_rad, weight) in DIRECTIONS {
        let (sin, cos) = (downwind_rad + off_rad).sin_cos();
        let Returned { hh, vv, cross } = breaker(permittivity, path, DVec3::new(cos, sin, 0.0));
        let share = weight * coverage(u10_mps);
        for (sum, own) in sigma0.as_flattened_mut().iter_mut().zip([vv, cross, cross, hh]) {
            *sum += share * own;
        }
    }
    sigma0
}

/// Mean power of V over that of H in backscatter by the water before the front face.
fn v_over_h(permittivity: Complex64, cos: f64) -> f64 {
    let reflected = reflection(permittivity, cos);
    let both_ways = |r: Complex64| {
        let share = r.norm_sqr();
        1.0 + 4.0 * share + share * share
    };
    both_ways(reflected.v) / both_ways(reflected.h)
}

fn cross(permittivity: Complex64, cos: f64) -> f64 {
    let (eps, sin2, r) = (permittivity, 1.0 - cos * cos, refracted(permittivity, cos));
    let square = |z: Complex64| z * z;
    let hh = quotient(eps - 1.0, square(cos + r));
    let vv = quotient((eps - 1.0) * (eps * (1.0 + sin2) - sin2), square(eps * cos + r));
    let cot2 = cos * cos / sin2;
    PI * cot2 * cot2 * (vv - hh).norm_sqr() * SATURATION * SLOPE_VARIANCE / (2.0 * sin2)
}
