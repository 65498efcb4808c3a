//! Random phasors of the facets of a patch.

use num_complex::Complex64;

use crate::paths::sea::SeaPlan;
use crate::scene::Patch;

/// Random phasors of the facets at hand, at their key modulo the patch, and in the order of the patch.
#[derive(Clone)]
pub(super) struct Phasors {
    keys: Vec<Option<[i64; 2]>>,
    /// `[mechanism][place]`.
    kept: Vec<Vec<[f32; 2]>>,
    first: Option<[i64; 2]>,
    /// `[mechanism][real, imaginary][facet]`.
    pub ordered: Vec<[Vec<f32>; 2]>,
    found: Vec<Complex64>,
}

impl Phasors {
    pub fn new(facets: usize, mechanisms: usize) -> Self {
        Self {
            keys: vec![None; facets],
            kept: vec![vec![[0.0; 2]; facets]; mechanisms],
            first: None,
            ordered: vec![[vec![0.0; facets], vec![0.0; facets]]; mechanisms],
            found: vec![Complex64::ZERO; mechanisms],
        }
    }

    /// Those of a patch, at rest.
    pub fn prepare(&mut self, sea: &SeaPlan, patch: &Patch) {
        if self.first == Some(patch.first) {
            return;
        }
        self.first = Some(patch.first);
        let [nx, ny] = patch.facets;
        for iy in 0..ny {
            let key_y = patch.first[1] + iy as i64;
            let row = key_y.rem_euclid(ny as i64) as usize * nx;
            let first_column = patch.first[0].rem_euclid(nx as i64) as usize;
            for ix in 0..nx {
                let key = [patch.first[0] + ix as i64, key_y];
                let place = row + (first_column + ix) % nx;
                if self.keys[place] != Some(key) {
                    self.keys[place] = Some(key);
                    sea.scattering.phasors_at_rest(key, &mut self.found);
                    for (column, phasor) in self.kept.iter_mut().zip(&self.found) {
                        column[place] = [phasor.re as f32, phasor.im as f32];
                    }
                }
                let index = iy * nx + ix;
                for (ordered, kept) in self.ordered.iter_mut().zip(&self.kept) {
                    ordered[0][index] = kept[place][0];
                    ordered[1][index] = kept[place][1];
                }
            }
        }
    }
}
