//! Land among the facets of a batch: [`LandScattering`] in f32.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use super::{Batch, Row, cross, dot, lanes_for};
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::LANES;
use crate::scattering::land::{LEAST_GRAZING, LandScattering};

/// What facets of a batch are land, and their phasors.
#[derive(Clone, Debug)]
pub struct LandRows {
    /// 1 for land, 0 for sea.
    pub land: Row,
    /// Real and imaginary parts of the phasors of VV, HH and cross-polarisation.
    pub phasor: [[Row; 2]; 3],
    /// Facets of land.
    pub count: usize,
}

impl LandRows {
    /// No land, on the heap.
    pub fn boxed() -> Box<Self> {
        Box::new(Self { land: [0.0; LANES], phasor: [[[0.0; LANES]; 2]; 3], count: 0 })
    }

    /// All rows.
    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut Row> {
        std::iter::once(&mut self.land).chain(self.phasor.as_flattened_mut())
    }
}

impl Batch {
    /// Responses of the facets of land, in place of those of water; with `silent` they return nothing.
    /// Cosines of all facets are found on the way, by the axis of the water.
    pub fn respond_as_land(
        &mut self,
        variant: Variant,
        axis: [f32; 2],
        land: &LandScattering,
        rows: &LandRows,
        silent: bool,
    ) {
        variant.run(Respond { batch: self, axis, land, rows, silent });
    }
}

struct Respond<'a> {
    batch: &'a mut Batch,
    axis: [f32; 2],
    land: &'a LandScattering,
    rows: &'a LandRows,
    silent: bool,
}

/// Fourth root of the law's sine; a facet that turns away goes on smoothly for half of the least angle.
#[inline(always)]
fn root_grazing(sine: f32) -> f32 {
    let least = LEAST_GRAZING as f32;
    let sine = sine.max(-0.5 * least);
    let root = (sine + least).sqrt();
    sine / (root * root.sqrt())
}

/// Vertical and horizontal unit vectors of a direction.
#[inline(always)]
fn vertical_horizontal(k: [f32; 3]) -> [[f32; 3]; 2] {
    let level = (k[0] * k[0] + k[1] * k[1]).sqrt();
    let inverse = 1.0 / level.max(1e-12);
    let h = if level > 1e-6 { [-k[1] * inverse, k[0] * inverse, 0.0] } else { [0.0, 1.0, 0.0] };
    [cross(h, k), h]
}

impl Task for Respond<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { batch, axis, land, rows, silent } = self;
        batch.tangents(axis);
        let root_gamma = land.root_gamma.map(|root| root as f32);
        for i in 0..lanes_for(batch.count) {
            if rows.land[i] < 0.5 {
                continue;
            }
            let grazing = root_grazing(batch.cosine[0][i]) * root_grazing(batch.cosine[1][i]);
            let scale = if silent { 0.0 } else { grazing };
            let at = |vectors: &super::Vectors| [vectors[0][i], vectors[1][i], vectors[2][i]];
            let [v_in, h_in] = vertical_horizontal(at(&batch.incident));
            let [v_out, h_out] = vertical_horizontal(at(&batch.scattered));
            for r in 0..2 {
                let p = at(&batch.receive[r]);
                let (v_r, h_r) = (dot(p, v_out), dot(p, h_out));
                for t in 0..2 {
                    let q = at(&batch.transmit[t]);
                    let (v_t, h_t) = (dot(q, v_in), dot(q, h_in));
                    let shares = [v_r * v_t, h_r * h_t, v_r * h_t - h_r * v_t];
                    for part in 0..2 {
                        let mut sum = 0.0;
                        for of in 0..3 {
                            sum += root_gamma[of] * shares[of] * rows.phasor[of][part][i];
                        }
                        batch.matrix[r][t][part][i] = scale * sum;
                    }
                }
            }
        }
    }
}
