//! Bragg scattering of facets side by side: [`spm`](crate::scattering::spm) in f32.

use num_complex::Complex32;

use super::{BEYOND, Batch, LaneWater, dot, lanes_for};
use crate::geometry::lanes::{GROUP, group, groups, lane};

/// `4 sqrt(pi)`.
const FOUR_ROOT_PI: f32 = 7.089_815_4;
/// Keeps inverses finite where two media are one.
const TINY: f32 = 1e-30;

impl Batch {
    /// Adds the Bragg part to all entries: on the facet's own plane, or that of a sub-facet.
    #[inline(always)]
    pub(super) fn small_perturbations(
        &mut self,
        water: &LaneWater,
        flat: bool,
        mechanism: usize,
        single: bool,
    ) {
        if water.contrast == Complex32::ZERO {
            return;
        }
        match (flat, single) {
            (true, false) => self.bragg_part::<true, false>(water, mechanism),
            (true, true) => self.bragg_part::<true, true>(water, mechanism),
            (false, false) => self.bragg_part::<false, false>(water, mechanism),
            (false, true) => self.bragg_part::<false, true>(water, mechanism),
        }
    }

    #[inline(always)]
    fn bragg_part<const FLAT: bool, const SINGLE: bool>(&mut self, water: &LaneWater, mechanism: usize) {
        let k = water.wavenumber_radpm;
        let contrast = water.contrast;
        let eps = contrast + 1.0;
        // Sub-facets that turn away go dark one by one: nobody could cut them later.
        let beyond = if water.tilts.len() > 1 { 0.0 } else { BEYOND };
        for g in 0..lanes_for(self.count) / GROUP {
            let (plane, local) = if FLAT { (&self.normal, &self.cosine) } else { (&self.plane, &self.local) };
            let normals = groups(plane, g);
            let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
            let transmit = [groups(&self.transmit[0], g), groups(&self.transmit[1], g)];
            let receive = [groups(&self.receive[0], g), groups(&self.receive[1], g)];
            let cosines = [group(&local[0], g), group(&local[1], g)];
            let phasors = match self.phasor.get(mechanism) {
                Some(phasor) if !SINGLE => [group(&phasor[0], g), group(&phasor[1], g)],
                _ => [[1.0; GROUP], [0.0; GROUP]],
            };
            let (densities, gains) = (group(&self.density, g), group(&self.gain, g));
            let mut sums = [[[[0.0f32; GROUP]; 2]; 2]; 2];
            for i in 0..GROUP {
                let (n, ki, ks) = (lane(&normals, i), lane(&incident, i), lane(&scattered, i));
                let (cos_i, cos_s) = (cosines[0][i].max(beyond), cosines[1][i].max(beyond));
                let scale = FOUR_ROOT_PI
                    * k
                    * k
                    * cos_i
                    * cos_s
                    * densities[i].max(0.0).sqrt()
                    * if FLAT { 1.0 } else { gains[i] };
                let along_i = [ki[0] + n[0] * cos_i, ki[1] + n[1] * cos_i, ki[2] + n[2] * cos_i];
                let along_s = [n[0] * cos_s - ks[0], n[1] * cos_s - ks[1], n[2] * cos_s - ks[2]];
                let (te_i, tm_i) = transmission(eps, contrast, cos_i);
                let (te_s, tm_s) = transmission(eps, contrast, cos_s);
                let turned = Complex32::new(phasors[0][i], phasors[1][i]) * scale;
                let (bend_i, bend_s) = (contrast * tm_i, contrast * tm_s);
                let tangential = contrast * turned * (te_i * te_s);
                let incident_bend = tangential * bend_i;
                let scattered_bend = tangential * bend_s;
                let normal = incident_bend * bend_s * dot(along_i, along_s)
                    + contrast * turned * eps * (tm_i * tm_s)
                    - tangential;
                for r in 0..2 {
                    let p = lane(&receive[r], i);
                    let (p_normal, p_along) = (dot(p, n), dot(p, along_i));
                    for t in 0..2 {
                        let q = lane(&transmit[t], i);
                        let (q_normal, q_along) = (dot(q, n), dot(q, along_s));
                        let entry = tangential * dot(p, q)
                            + incident_bend * (p_along * q_normal)
                            + scattered_bend * (q_along * p_normal)
                            + normal * (p_normal * q_normal);
                        if SINGLE {
                            sums[r][t][0][i] = entry.norm_sqr();
                        } else {
                            sums[r][t][0][i] = entry.re;
                            sums[r][t][1][i] = entry.im;
                        }
                    }
                }
            }
            self.gather(g, &sums, SINGLE);
        }
    }
}

/// `sqrt(eps - sin^2)`, `Im <= 0`, for `Im eps <= 0`.
#[inline(always)]
pub(super) fn refracted(contrast: Complex32, cosine: f32) -> Complex32 {
    let (re, im) = (contrast.re + cosine * cosine, contrast.im);
    let larger = (0.5 * ((re * re + im * im).sqrt() + re.abs())).sqrt();
    let other = 0.5 * im / larger.max(TINY);
    if re >= 0.0 { Complex32::new(larger, other) } else { Complex32::new(-other, -larger) }
}

/// `1/(c + r)` and `1/(eps c + r)`.
#[inline(always)]
fn transmission(eps: Complex32, contrast: Complex32, cosine: f32) -> (Complex32, Complex32) {
    let r = refracted(contrast, cosine);
    (inverse(r + cosine), inverse(eps * cosine + r))
}

#[inline(always)]
pub(super) fn inverse(z: Complex32) -> Complex32 {
    z.conj() * (1.0 / (z.norm_sqr() + TINY))
}
