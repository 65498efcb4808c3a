//! Specular points of facets side by side: [`kirchhoff`](crate::scattering::kirchhoff) in f32.

use num_complex::Complex32;

use super::spm::{inverse, refracted};
use super::{Batch, LANES, LaneKind, LaneWater, Vectors, cross, dot, unit};
use crate::scattering::kirchhoff::LEAST_BEND;
use crate::scattering::slope_pdf::GramCharlier;

/// Root of `sigma0` below which specular points are left out: -240 dB, as in f64.
const LEAST: f32 = 1e-12;
const PI: f32 = std::f32::consts::PI;
const TAU: f32 = std::f32::consts::TAU;

impl Batch {
    /// Adds the specular part.
    #[inline(always)]
    pub(super) fn specular(&mut self, water: &LaneWater, kind: &LaneKind, single: bool) {
        if !self.specular_weights(water, kind) {
            return;
        }
        let contrast = water.contrast;
        let eps = contrast + 1.0;
        for i in 0..LANES {
            let at = |vectors: &Vectors| vectors.each_ref().map(|column| column[i]);
            let (ki, ks) = (at(&self.incident), at(&self.scattered));
            let q = [0, 1, 2].map(|c| ks[c] - ki[c]);
            let q_norm = dot(q, q).sqrt();
            let across = cross(q, ki);
            // Straight back: any vector normal to the ray will do.
            let straight = dot(across, across) < 1e-12 * q_norm * q_norm;
            let other = if ki[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
            let fallback = cross(other, ki);
            let t = unit([0, 1, 2].map(|c| if straight { fallback[c] } else { across[c] }));
            let (w_i, w_s) = (cross(t, ki), cross(t, ks));
            let cosine = (0.5 * q_norm).min(1.0);
            let root = refracted(contrast, cosine);
            let r_v = (eps * cosine - root) * inverse(eps * cosine + root);
            let r_h = (-root + cosine) * inverse(root + cosine);
            let turned = if single {
                Complex32::new(self.gain[i], 0.0)
            } else {
                Complex32::new(self.phasor[0][0][i], self.phasor[0][1][i]) * self.gain[i]
            };
            let (r_v, r_h) = (r_v * turned, r_h * turned);
            for r in 0..2 {
                let p = at(&self.receive[r]);
                let (p_t, p_w) = (dot(p, t), dot(p, w_s));
                for transmit in 0..2 {
                    let e = at(&self.transmit[transmit]);
                    let entry = r_h * (p_t * dot(e, t)) + r_v * (p_w * dot(e, w_i));
                    if single {
                        self.power[r][transmit][i] += entry.norm_sqr();
                    } else {
                        self.matrix[r][transmit][0][i] += entry.re;
                        self.matrix[r][transmit][1][i] += entry.im;
                    }
                }
            }
        }
    }

    /// What multiplies the reflection, into `gain`; says whether there is anything.
    #[inline(always)]
    fn specular_weights(&mut self, water: &LaneWater, kind: &LaneKind) -> bool {
        let k = water.wavenumber_radpm;
        let slopes = kind.slopes.map(|s| s.floored()).map(|s| [s.up as f32, s.cross as f32]);
        let [cos, sin] = kind.downwind.map(|c| c as f32);
        let roughness = kind.roughness_m2.map(|s| s as f32);
        let least_bend = LEAST_BEND as f32;
        let mut largest = 0.0f32;
        for i in 0..LANES {
            let at = |vectors: &Vectors| vectors.each_ref().map(|column| column[i]);
            let n = at(&self.normal);
            let (ki, ks) = (at(&self.incident), at(&self.scattered));
            let q = [0, 1, 2].map(|c| ks[c] - ki[c]);
            let (q_norm, q_n) = (dot(q, q).sqrt(), dot(q, n));
            let there = q_norm >= least_bend && q_n >= least_bend * q_norm;
            let inverse_n = 1.0 / q_n.max(1e-20);
            let sx = -dot(q, at(&self.axes[0])) * inverse_n;
            let sy = -dot(q, at(&self.axes[1])) * inverse_n;
            let secant = q_norm * inverse_n;
            let mix = |which: usize| slopes[0][which] + self.cover[i] * (slopes[1][which] - slopes[0][which]);
            let (s_up, s_cross) = (1.0 / mix(0).sqrt(), 1.0 / mix(1).sqrt());
            let e = -(cos * sx + sin * sy) * s_up;
            let x = (cos * sy - sin * sx) * s_cross;
            let phase = k * q_norm;
            let calm = phase * phase * (roughness[0] + self.cover[i] * (roughness[1] - roughness[0]));
            // Root of the density: half the exponent; the roughness' own factor with it.
            let exponent = 0.25 * (e * e + x * x) + 0.5 * calm;
            let series = match &kind.skew {
                None => 1.0,
                Some([clean, covered]) => series(clean, covered, self.cover[i], x, e),
            };
            let density = PI * s_up * s_cross * (1.0 / TAU) * series;
            let weight = density.sqrt() * exponential(-exponent) * (secant * secant);
            let weight = if there && weight > LEAST { weight } else { 0.0 };
            self.gain[i] = weight;
            largest = largest.max(weight);
        }
        largest > 0.0
    }
}

/// The Gram-Charlier factor of a blend.
#[inline(always)]
fn series(clean: &GramCharlier, covered: &GramCharlier, cover: f32, x: f32, e: f32) -> f32 {
    let mix = |a: f64, b: f64| a as f32 + cover * (b - a) as f32;
    let (c21, c03) = (mix(clean.c21, covered.c21), mix(clean.c03, covered.c03));
    let (c40, c22, c04) =
        (mix(clean.c40, covered.c40), mix(clean.c22, covered.c22), mix(clean.c04, covered.c04));
    // Far out the Gaussian is nothing, and the polynomial must not overflow.
    let (x, e) = (x.clamp(-30.0, 30.0), e.clamp(-30.0, 30.0));
    let (x2, e2) = (x * x, e * e);
    let sum = 1.0 - 0.5 * c21 * (x2 - 1.0) * e - c03 / 6.0 * e * (e2 - 3.0)
        + c40 / 24.0 * (x2 * x2 - 6.0 * x2 + 3.0)
        + c22 / 4.0 * (x2 - 1.0) * (e2 - 1.0)
        + c04 / 24.0 * (e2 * e2 - 6.0 * e2 + 3.0);
    sum.max(0.0)
}

/// `e^x` for `x <= 0`, relative error 2e-7; 0 below -86.
#[inline(always)]
pub fn exponential(x: f32) -> f32 {
    const TO_INTEGER: f32 = 12_582_912.0;
    let turns = x.max(-86.0) * std::f32::consts::LOG2_E;
    let shifted = turns + TO_INTEGER;
    let whole = shifted - TO_INTEGER;
    // 2^f = e^(f ln 2), f in [-1/2, 1/2]; Taylor, remainder 1e-8.
    let f = (turns - whole) * std::f32::consts::LN_2;
    let series = 1.0
        + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f / 720.0)))));
    let bits = (shifted.to_bits() as i32).wrapping_sub(TO_INTEGER.to_bits() as i32);
    let scale = f32::from_bits((bits.wrapping_add(127) as u32) << 23);
    if x < -86.0 { 0.0 } else { series * scale }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials() {
        for i in 0..9000 {
            let x = -0.01 * i as f32;
            let exact = f64::from(x).exp();
            let found = f64::from(exponential(x));
            // Eight roundings of 2^-24, and the argument's own (86 turns into 124 of 2^-24 of them).
            let slack = (8.0 + 124.0 * 0.7) * 2f64.powi(-24);
            assert!((found - exact).abs() <= slack * exact || x < -86.0 && found == 0.0, "{x}");
        }
    }
}
