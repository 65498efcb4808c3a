//! Random phasors of the facets of a patch.

use num_complex::Complex64;

use crate::scattering::water::WaterScattering;
use crate::scene::Patch;

/// Random phasors of the facets at hand. A facet's place is its key modulo the patch, so that what moves is
/// only what enters.
#[derive(Clone)]
pub(super) struct Phasors {
    keys: Vec<Option<[i64; 2]>>,
    phasors: Vec<Complex64>,
    mechanisms: usize,
}

impl Phasors {
    /// Of so many facets, none of them known yet.
    pub fn new(facets: usize, mechanisms: usize) -> Self {
        Self { keys: vec![None; facets], phasors: vec![Complex64::ZERO; facets * mechanisms], mechanisms }
    }

    fn place(&self, patch: &Patch, key: [i64; 2]) -> usize {
        let [nx, ny] = patch.facets;
        key[1].rem_euclid(ny as i64) as usize * nx + key[0].rem_euclid(nx as i64) as usize
    }

    /// The phasors of a facet, one a mechanism.
    pub fn of(&self, patch: &Patch, key: [i64; 2]) -> &[Complex64] {
        let place = self.place(patch, key) * self.mechanisms;
        &self.phasors[place..place + self.mechanisms]
    }

    /// Those of a patch at a time, s after pulse 0.
    pub fn prepare(&mut self, scattering: &WaterScattering, patch: &Patch, t_s: f64) {
        for index in 0..patch.len() {
            let key = patch.key(index);
            let place = self.place(patch, key);
            if self.keys[place] != Some(key) || scattering.decorrelates() {
                self.keys[place] = Some(key);
                let begin = place * self.mechanisms;
                scattering.phasors(key, t_s, &mut self.phasors[begin..begin + self.mechanisms]);
            }
        }
    }
}
