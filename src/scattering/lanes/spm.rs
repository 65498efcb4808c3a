//! Bragg scattering of facets side by side: [`spm`](crate::scattering::spm) in f32.

use num_complex::Complex32;

use super::{BEYOND, Batch, LANES, LaneWater, Vectors, dot};

/// `4 sqrt(pi)`.
const FOUR_ROOT_PI: f32 = 7.089_815_4;
/// Keeps inverses finite where two media are one.
const TINY: f32 = 1e-30;

impl Batch {
    /// Adds the Bragg part on the plane at hand to all entries.
    #[inline(always)]
    pub(super) fn small_perturbations(
        &mut self,
        water: &LaneWater,
        weight: f32,
        mechanism: usize,
        single: bool,
    ) {
        if weight == 0.0 || water.contrast == Complex32::ZERO {
            return;
        }
        let k = water.wavenumber_radpm;
        let contrast = water.contrast;
        let eps = contrast + 1.0;
        let phasor = if single { None } else { self.phasor.get(mechanism) };
        // Sub-facets that turn away go dark one by one: nobody could cut them later.
        let beyond = if water.tilts.len() > 1 { 0.0 } else { BEYOND };
        let none = [[1.0; LANES], [0.0; LANES]];
        let phasor = phasor.unwrap_or(&none);
        for i in 0..LANES {
            let at = |vectors: &Vectors| vectors.each_ref().map(|column| column[i]);
            let (n, ki, ks) = (at(&self.plane), at(&self.incident), at(&self.scattered));
            let (cos_i, cos_s) = (self.local[0][i].max(beyond), self.local[1][i].max(beyond));
            let scale =
                FOUR_ROOT_PI * k * k * cos_i * cos_s * self.density[i].max(0.0).sqrt() * self.gain[i];
            let along_i = [0, 1, 2].map(|c| ki[c] + n[c] * cos_i);
            let along_s = [0, 1, 2].map(|c| n[c] * cos_s - ks[c]);
            let (te_i, tm_i) = transmission(eps, contrast, cos_i);
            let (te_s, tm_s) = transmission(eps, contrast, cos_s);
            let turned = Complex32::new(phasor[0][i], phasor[1][i]) * scale;
            let (bend_i, bend_s) = (contrast * tm_i, contrast * tm_s);
            let tangential = contrast * turned * (te_i * te_s);
            let incident_bend = tangential * bend_i;
            let scattered_bend = tangential * bend_s;
            let normal = incident_bend * bend_s * dot(along_i, along_s)
                + contrast * turned * eps * (tm_i * tm_s)
                - tangential;
            for r in 0..2 {
                let p = at(&self.receive[r]);
                let (p_normal, p_along) = (dot(p, n), dot(p, along_i));
                for t in 0..2 {
                    let q = at(&self.transmit[t]);
                    let (q_normal, q_along) = (dot(q, n), dot(q, along_s));
                    let entry = tangential * dot(p, q)
                        + incident_bend * (p_along * q_normal)
                        + scattered_bend * (q_along * p_normal)
                        + normal * (p_normal * q_normal);
                    if single {
                        self.power[r][t][i] += entry.norm_sqr();
                    } else {
                        self.matrix[r][t][0][i] += entry.re;
                        self.matrix[r][t][1][i] += entry.im;
                    }
                }
            }
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
