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
//! **Out of the plane of incidence** the facet that mirrors the wave to the receiver turns the polarisation,
//! by the matrix `rho` of a perfect mirror ([`Bend::turn`], as in [`kirchhoff`](super::kirchhoff)):
//!
//! `sigma_pq = sigma rho_pq^2 p_p(th_s) p_q(th_i)` , `p_h = 1` , `p_v = p` , `sum_p rho_pq^2 = 1` ,
//!
//! `sigma` the `sigma_hh` above. In backscatter `rho` is diagonal, of ones. At 45 degrees there and back and
//! 90 degrees of azimuth between, it leaves 1/9 co-polarised.
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
//! does not depend on angle decides, and shadows are not in it. **Bistatic values are extrapolated**; no
//! measurement stands behind them: `z` from backscatter to the bisector (geometrical optics); the front face,
//! whose level is held for all directions and whose polarisation is turned as that of specular points; the
//! water before it, as a product of both ways; the cross-polarised Bragg waves, at half the angle of the
//! bisector and in the same amount out of the plane.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use num_complex::Complex64;

use super::fresnel::{quotient, reflection, refracted};
use super::kirchhoff::Bend;
use super::tilt::{Path, ScatterMatrix};
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

/// What a breaker returns per area that breaks; `[received][transmitted]`, v before h.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Returned {
    /// Cross sections of the mirror and the front face, before the polarisation is turned.
    pub like: [[f64; 2]; 2],
    /// How the amplitudes are turned.
    pub turn: [[f64; 2]; 2],
    /// Cross section of the Bragg waves in either cross-polarised channel.
    pub cross: f64,
}

impl Returned {
    /// Cross sections of the channels.
    pub fn sigma(&self) -> [[f64; 2]; 2] {
        let like = |p: usize, q: usize| self.like[p][q] * (self.turn[p][q] * self.turn[p][q]);
        [[like(0, 0), like(0, 1) + self.cross], [like(1, 0) + self.cross, like(1, 1)]]
    }

    /// Scattering matrix of so large an area, m^2, sqrt(m^2): of a phase of the mirror and one of the Bragg
    /// waves, rad.
    pub fn matrix(&self, area_m2: f64, phases_rad: [f64; 2]) -> ScatterMatrix {
        let ([like, cross], size) = (phases_rad.map(Complex64::cis), area_m2.sqrt());
        let of = |p: usize, q: usize| self.like[p][q].sqrt() * size * self.turn[p][q] * like;
        // In these bases h turns round with the wave, v does not.
        let cross = self.cross.sqrt() * cross * size;
        [[of(0, 0), of(0, 1) - cross], [of(1, 0) + cross, of(1, 1)]]
    }
}

/// What a breaker returns that runs along the horizontal unit vector `travel`, over a path and over water of
/// a permittivity.
///
/// ```
/// use glam::DVec3;
/// use nereus::scattering::{breaking::breaker, tilt::Path};
/// use num_complex::Complex64;
/// let grazing = DVec3::new(87f64.to_radians().sin(), 0.0, -87f64.to_radians().cos());
/// let back = breaker(Complex64::new(55.0, -37.5), &Path::new(grazing, -grazing), -DVec3::X);
/// let [[vv, _], [_, hh]] = back.sigma();
/// assert!((10.0 * hh.log10() + 15.8).abs() < 0.05);
/// assert!((10.0 * (hh / vv).log10() - 5.2).abs() < 0.1);
/// ```
pub fn breaker(permittivity: Complex64, path: &Path, travel: DVec3) -> Returned {
    let (cos_i, cos_s) = (-path.ki.z, path.ks.z);
    // From below, or straight through: nothing.
    let Some(bend) = Bend::new(path).filter(|_| cos_i > 0.0 && cos_s > 0.0) else {
        return Returned::default();
    };
    let Bend { q, q_norm: length } = bend;
    let off = DVec3::new(-q.x / q.z + TILT * travel.x, -q.y / q.z + TILT * travel.y, 0.0);
    let steep = (-off.length_squared() / SLOPE_VARIANCE).exp();
    // Where the exponential is nothing the secant may be infinite.
    let specular = if steep > 0.0 { (length / q.z).powi(4) * steep / SLOPE_VARIANCE } else { 0.0 };
    let hh = specular + FRONT_FACE / SLOPE_VARIANCE;
    let [over_i, over_s] = [cos_i, cos_s].map(|cos| v_over_h(permittivity, cos));
    let ratio = (over_i * over_s).sqrt();
    let bisector = (q.z / length).clamp(0.0, LEAST_CROSS_RAD.cos());
    Returned {
        like: [[hh * ratio, hh * over_s.sqrt()], [hh * over_i.sqrt(), hh]],
        // Straight back it is exact.
        turn: if path.ks == -path.ki { [[1.0, 0.0], [0.0, -1.0]] } else { bend.turn(path) },
        cross: cross(permittivity, bisector),
    }
}

/// What breaking waves add to the cross section of a sea per area, `[received][transmitted]`, v before h: the
/// mean over the directions in which they run, about a wind that blows towards an angle of x, rad, times
/// their coverage in its speed at 10 m, m/s.
pub fn sigma0(permittivity: Complex64, path: &Path, downwind_rad: f64, u10_mps: f64) -> [[f64; 2]; 2] {
    let mut sigma0 = [[0.0; 2]; 2];
    for (off_rad, weight) in DIRECTIONS {
        let (sin, cos) = (downwind_rad + off_rad).sin_cos();
        let returned = breaker(permittivity, path, DVec3::new(cos, sin, 0.0));
        let share = weight * coverage(u10_mps);
        for (sum, own) in sigma0.as_flattened_mut().iter_mut().zip(returned.sigma().as_flattened()) {
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
