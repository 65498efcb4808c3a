//! Modulation of short waves side by side: [`modulation`](crate::scattering::modulation) in f32.

use super::{Batch, Tilt, exponential, lanes_for};
use crate::geometry::lanes::{GROUP, group, group_mut, groups, lane};
use crate::scattering::modulation::TiltBias;
use crate::sea::surface::modulation::{MOST, Strength, TINY};

/// Both, in f32.
#[derive(Clone, Copy, Debug)]
pub struct LaneModulation {
    covariance: [[f32; 3]; 3],
    /// Where weights of sub-facets tend to anything.
    bias: Option<[[f32; 3]; 2]>,
}

impl LaneModulation {
    /// Whether weights of sub-facets tend to anything.
    pub(super) fn leans(&self) -> bool {
        self.bias.is_some()
    }

    /// The same of other waves.
    pub(super) fn with_strength(self, strength: &Strength) -> Self {
        Self { covariance: strength.covariance.map(|row| row.map(|c| c as f32)), ..self }
    }

    pub(in crate::scattering) fn new(strength: &Strength, bias: &TiltBias) -> Self {
        let round = |row: [f64; 3]| row.map(|c| c as f32);
        let bias = (*bias != TiltBias::default()).then(|| bias.of.map(round));
        Self { covariance: strength.covariance.map(round), bias }
    }
}

/// The outer ones of the three nodes of tilts, standard deviations.
const NODE: f32 = 1.732_050_8;

/// `e^x` for `|x| <= 4`: a few roundings more than that of negative numbers.
#[inline(always)]
fn exponential_both(x: f32) -> f32 {
    const LIFT: f32 = 4.0;
    exponential(x - LIFT) * 54.598_15
}

#[inline(always)]
fn times(row: &[f32; 3], look: [f32; 3]) -> f32 {
    row[0] * look[0] + row[1] * look[1] + row[2] * look[2]
}

#[inline(always)]
fn look_of(x: f32, y: f32) -> [f32; 3] {
    let scale = 1.0 / (x * x + y * y + TINY as f32);
    [x * x * scale, y * y * scale, 2.0 * x * y * scale]
}

impl Batch {
    /// Factors on the density of Bragg waves, and what weights of sub-facets tend to.
    #[inline(always)]
    pub(super) fn modulate(&mut self, of: &LaneModulation, axis: [f32; 2]) {
        let most = MOST as f32;
        for g in 0..lanes_for(self.count) / GROUP {
            let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
            let tensor = groups(&self.strain, g);
            let mut raise = [0.0f32; GROUP];
            for i in 0..GROUP {
                let (ki, ks) = (lane(&incident, i), lane(&scattered, i));
                let look = look_of(ks[0] - ki[0], ks[1] - ki[1]);
                let variance = times(
                    &[
                        times(&of.covariance[0], look),
                        times(&of.covariance[1], look),
                        times(&of.covariance[2], look),
                    ],
                    look,
                );
                let m = times(&lane(&tensor, i), look) - 0.5 * variance;
                raise[i] = exponential_both(m.clamp(-most, most));
            }
            if let Some(bias) = &of.bias {
                self.bias(bias, axis, g, &mut raise);
            }
            *group_mut(&mut self.raise, g) = raise;
        }
    }

    /// Amplitudes of sub-facets that are tilted up and across by a node, and what their powers sum up to.
    #[inline(always)]
    fn bias(&mut self, of: &[[f32; 3]; 2], axis: [f32; 2], g: usize, raise: &mut [f32; GROUP]) {
        let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
        let mut roots = [[0.0f32; GROUP]; 2];
        for i in 0..GROUP {
            let (ki, ks) = (lane(&incident, i), lane(&scattered, i));
            let q = [ks[0] - ki[0], ks[1] - ki[1]];
            // On the axes of the wind.
            let turned = look_of(axis[0] * q[0] + axis[1] * q[1], axis[0] * q[1] - axis[1] * q[0]);
            for (own, row) in roots.iter_mut().zip(of) {
                // The root of a weight is an amplitude.
                let root = exponential_both(0.5 * NODE * times(row, turned).clamp(-1.0, 1.0));
                let up = root * root;
                raise[i] /= 2.0 / 3.0 + (up + 1.0 / up) / 6.0;
                own[i] = root;
            }
        }
        for (to, from) in self.bias.iter_mut().zip(roots) {
            *group_mut(to, g) = from;
        }
    }

    /// The share of a sub-facet that waves tilt.
    #[inline(always)]
    pub(super) fn lean(&mut self, [up, across, _]: Tilt) {
        for (row, node) in self.bias.iter().zip([up, across]) {
            for g in (0..lanes_for(self.count) / GROUP).filter(|_| node != 0.0) {
                let (root, mut gain) = (group(row, g), group(&self.gain, g));
                for i in 0..GROUP {
                    gain[i] = if node > 0.0 { gain[i] * root[i] } else { gain[i] / root[i] };
                }
                *group_mut(&mut self.gain, g) = gain;
            }
        }
    }

    /// The density at hand, modulated.
    #[inline(always)]
    pub(super) fn raise_modulated(&mut self) {
        for g in 0..lanes_for(self.count) / GROUP {
            let (raise, mut density) = (group(&self.raise, g), group(&self.density, g));
            for i in 0..GROUP {
                density[i] *= raise[i];
            }
            *group_mut(&mut self.density, g) = density;
        }
    }
}
