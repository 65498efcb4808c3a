//! Specular points of facets side by side: [`kirchhoff`](crate::scattering::kirchhoff) in f32.

use num_complex::Complex32;

use super::spm::{inverse, refracted};
use super::{Batch, LANES, LaneKind, LaneWater, cross, dot, lanes_for, unit};
use crate::geometry::lanes::{GROUP, group, group_mut, groups, lane};
use crate::scattering::kirchhoff::LEAST_BEND;
use crate::scattering::slope_pdf::GramCharlier;
use crate::units::exponential;

/// Root of `sigma0` below which specular points are left out: -120 dB, far below any sea's Bragg scattering.
const LEAST: f32 = 1e-6;
/// Exponent beyond which a weight stays below [`LEAST`] whatever multiplies it: `e^-40` is 4e-18, the root of
/// the density at most some 2e4 with its series, and the square of the secant goes with the exponent itself.
const SILENT: f32 = 40.0;
const PI: f32 = std::f32::consts::PI;
const TAU: f32 = std::f32::consts::TAU;

impl Batch {
    /// Adds the specular part.
    #[inline(always)]
    pub(super) fn specular(&mut self, water: &LaneWater, kind: &LaneKind, single: bool) {
        if !self.specular_weights(water, kind) {
            return;
        }
        for weight in &self.gain[..lanes_for(self.count)] {
            self.reflects = self.reflects.max(*weight);
        }
        // Specular facets are few: whole groups are passed over.
        for first in (0..lanes_for(self.count)).step_by(GROUP) {
            if self.gain[first..first + GROUP].iter().any(|gain| *gain > 0.0) {
                self.reflections(water, first, single);
            }
        }
    }

    #[inline(always)]
    fn reflections(&mut self, water: &LaneWater, first: usize, single: bool) {
        let contrast = water.contrast;
        let eps = contrast + 1.0;
        let g = first.min(LANES - GROUP) / GROUP;
        let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
        let transmit = [groups(&self.transmit[0], g), groups(&self.transmit[1], g)];
        let receive = [groups(&self.receive[0], g), groups(&self.receive[1], g)];
        let gains = group(&self.gain, g);
        let phasors = match self.phasor.first() {
            Some(phasor) if !single => [group(&phasor[0], g), group(&phasor[1], g)],
            _ => [[1.0; GROUP], [0.0; GROUP]],
        };
        let zero = [0.0f32; GROUP];
        let (mut t, mut w_i, mut w_s) = ([zero; 3], [zero; 3], [zero; 3]);
        let (mut vertical, mut horizontal) = ([zero; 2], [zero; 2]);
        for i in 0..GROUP {
            let (ki, ks) = (lane(&incident, i), lane(&scattered, i));
            let q = [ks[0] - ki[0], ks[1] - ki[1], ks[2] - ki[2]];
            let q_norm = dot(q, q).sqrt();
            let across = cross(q, ki);
            // Straight back: any vector normal to the ray will do.
            let straight = dot(across, across) < 1e-12 * q_norm * q_norm;
            let steep = if ki[2].abs() < 0.9 { 1.0 } else { 0.0 };
            let other = cross([0.0, 1.0 - steep, steep], ki);
            let normal = unit([
                if straight { other[0] } else { across[0] },
                if straight { other[1] } else { across[1] },
                if straight { other[2] } else { across[2] },
            ]);
            let (own_i, own_s) = (cross(normal, ki), cross(normal, ks));
            for c in 0..3 {
                (t[c][i], w_i[c][i], w_s[c][i]) = (normal[c], own_i[c], own_s[c]);
            }
            let cosine = (0.5 * q_norm).min(1.0);
            let root = refracted(contrast, cosine);
            let turned = Complex32::new(phasors[0][i], phasors[1][i]) * gains[i];
            let r_v = (eps * cosine - root) * inverse(eps * cosine + root) * turned;
            let r_h = (-root + cosine) * inverse(root + cosine) * turned;
            (vertical[0][i], vertical[1][i]) = (r_v.re, r_v.im);
            (horizontal[0][i], horizontal[1][i]) = (r_h.re, r_h.im);
        }
        let mut sums = [[[zero; 2]; 2]; 2];
        for r in 0..2 {
            for column in 0..2 {
                let (mut re, mut im) = (zero, zero);
                for i in 0..GROUP {
                    let (p, e) = (lane(&receive[r], i), lane(&transmit[column], i));
                    let along = dot(p, lane(&t, i)) * dot(e, lane(&t, i));
                    let across = dot(p, lane(&w_s, i)) * dot(e, lane(&w_i, i));
                    let entry = [
                        horizontal[0][i] * along + vertical[0][i] * across,
                        horizontal[1][i] * along + vertical[1][i] * across,
                    ];
                    re[i] = if single { entry[0] * entry[0] + entry[1] * entry[1] } else { entry[0] };
                    im[i] = entry[1];
                }
                sums[r][column] = [re, im];
            }
        }
        self.gather(g, &sums, single);
    }

    /// What multiplies the reflection, into `gain`; returns whether there is anything.
    #[inline(always)]
    fn specular_weights(&mut self, water: &LaneWater, kind: &LaneKind) -> bool {
        let k = water.wavenumber_radpm;
        let slopes = kind.slopes.map(|s| s.floored()).map(|s| [s.up as f32, s.cross as f32]);
        let [cos, sin] = kind.downwind.map(|c| c as f32);
        let roughness = kind.roughness_m2.map(|s| s as f32);
        let least_bend = LEAST_BEND as f32;
        let mut any = false;
        for g in 0..lanes_for(self.count) / GROUP {
            let (normal, x, y) =
                (groups(&self.normal, g), groups(&self.axes[0], g), groups(&self.axes[1], g));
            let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
            let cover = group(&self.cover, g);
            let zero = [0.0; GROUP];
            let (mut secant, mut density, mut up, mut across) = (zero, zero, zero, zero);
            let (mut exponent, mut least) = (zero, f32::INFINITY);
            for i in 0..GROUP {
                let (n, ki, ks) = (lane(&normal, i), lane(&incident, i), lane(&scattered, i));
                let q = [ks[0] - ki[0], ks[1] - ki[1], ks[2] - ki[2]];
                let (q_norm, q_n) = (dot(q, q).sqrt(), dot(q, n));
                let there = (q_norm >= least_bend) & (q_n >= least_bend * q_norm);
                let inverse_n = 1.0 / q_n.max(1e-20);
                let sx = -dot(q, lane(&x, i)) * inverse_n;
                let sy = -dot(q, lane(&y, i)) * inverse_n;
                let mix = |which: usize| slopes[0][which] + cover[i] * (slopes[1][which] - slopes[0][which]);
                let (s_up, s_cross) = (1.0 / mix(0).sqrt(), 1.0 / mix(1).sqrt());
                let e = -(cos * sx + sin * sy) * s_up;
                let x = (cos * sy - sin * sx) * s_cross;
                let phase = k * q_norm;
                let calm = phase * phase * (roughness[0] + cover[i] * (roughness[1] - roughness[0]));
                // Root of the density: half the exponent; the roughness' own factor with it.
                let half = 0.25 * (e * e + x * x) + 0.5 * calm;
                exponent[i] = if there { half } else { f32::INFINITY };
                (secant[i], up[i], across[i]) = (q_norm * inverse_n, e, x);
                density[i] = PI * s_up * s_cross * (1.0 / TAU);
            }
            for value in exponent {
                least = least.min(value);
            }
            let mut weights = zero;
            if least < SILENT {
                for i in 0..GROUP {
                    let series = match &kind.skew {
                        None => 1.0,
                        Some([clean, covered]) => series(clean, covered, cover[i], across[i], up[i]),
                    };
                    let root = (density[i] * series).sqrt();
                    let weight = root * exponential(-exponent[i].min(SILENT)) * (secant[i] * secant[i]);
                    let counts = (exponent[i] < SILENT) & (weight > LEAST);
                    weights[i] = if counts { weight } else { 0.0 };
                }
                any |= weights.iter().any(|weight| *weight > 0.0);
            }
            *group_mut(&mut self.gain, g) = weights;
        }
        any
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
