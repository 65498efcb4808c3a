//! The two-scale sea, many facets side by side, in f32.
//!
//! The equations are those of [`two_scale`](super::two_scale), [`spm`](super::spm) and
//! [`kirchhoff`](super::kirchhoff), written without branches over rows of [`LANES`] facets, so that one
//! instruction does many. What differs:
//!
//! - The spectrum is a table over wave number and azimuth ([`table`]).
//! - Fields of the ports enter as vectors: the response is bilinear in them, so that no polarisation basis is
//!   asked and none is singular. [`Batch::matrix`]`[r][t]` is `p_r . S . q_t` with the vectors of
//!   [`Batch::receive`] and [`Batch::transmit`].
//! - A facet that turns away from an antenna is not cut: its response goes on smoothly to cosines of
//!   [`BEYOND`], and the caller cuts it at the instant at which the cosine ([`Batch::cosine`]) is zero. So
//!   responses at some instants can be interpolated.
//!
//! **Errors** against the f64 routines, relative to the rms response: rounding about -120 dB, the table's
//! -100 dB (a test holds both). A facet within 1e-4 rad of grazing loses digits of its cosine, which is then
//! small itself.
//!
//! Limits: specular points are left out below -120 dB (there: -240 dB).

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

mod go;
mod modulation;
mod land;
mod spm;
pub mod table;

use std::sync::Arc;

use num_complex::Complex32;

use super::facets::Phases;
use super::slope_pdf::{GramCharlier, MeanSquareSlope};
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{GROUP, Held, group, group_mut, groups, lane};
pub use crate::geometry::lanes::{LANES, Row, lanes_for};
use crate::scattering::splitting::high_pass;
use crate::sea::surface::modulation::Strength;
pub use crate::units::exponential;
pub use land::LandRows;
pub(super) use modulation::LaneModulation;
use table::{BraggTable, Damping};

/// Cosine of the local angle down to which a response goes on behind the tangent plane.
pub const BEYOND: f32 = -0.08;

/// Vectors of all facets: x, y, z.
pub type Vectors = [Row; 3];

/// Facets side by side: what is asked, what they return, and room to work.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Facets: the first lanes.
    pub count: usize,
    /// Unit direction from the transmitter.
    pub incident: Vectors,
    /// Unit direction to the receiver.
    pub scattered: Vectors,
    /// Slopes of the height map.
    pub slope: [Row; 2],
    /// Share that the kind covers, 0 to 1.
    pub cover: Row,
    /// Two field vectors of the transmitter, normal to `incident`.
    pub transmit: [Vectors; 2],
    /// Two of the receiver, normal to `scattered`.
    pub receive: [Vectors; 2],
    /// Modulation by the waves of the map, the tensor's entries xx, yy, xy on the axes of the scene.
    pub strain: [Row; 3],
    /// Random phasor of each mechanism, real and imaginary.
    pub phasor: Vec<[Row; 2]>,
    /// Cosines of the local angles to both antennas.
    pub cosine: [Row; 2],
    /// Largest amplitude of the specular points of a facet since this was 0, per square root of facet area,
    /// were they to reflect all.
    pub reflects: f32,
    /// `[receive][transmit]`, per square root of facet area: real and imaginary.
    pub matrix: [[[Row; 2]; 2]; 2],
    normal: Vectors,
    axes: [Vectors; 2],
    plane: Vectors,
    local: [Row; 2],
    bragg: [Row; 2],
    density: Row,
    gain: Row,
    /// Factor on the density of Bragg waves, where they are modulated, and on the amplitude of sub-facets
    /// that are tilted up by a node along and across the wind.
    raise: Row,
    bias: [Row; 2],
    power: [[Row; 2]; 2],
}

impl Batch {
    /// All zero, on the heap, for so many mechanisms.
    pub fn boxed(mechanisms: usize) -> Box<Self> {
        let row = [0.0; LANES];
        let vectors = [row; 3];
        Box::new(Self {
            count: LANES,
            incident: vectors,
            scattered: vectors,
            slope: [row; 2],
            cover: row,
            strain: [row; 3],
            transmit: [vectors; 2],
            receive: [vectors; 2],
            phasor: vec![[row; 2]; mechanisms],
            cosine: [row; 2],
            reflects: 0.0,
            matrix: [[[row; 2]; 2]; 2],
            normal: vectors,
            axes: [vectors; 2],
            plane: vectors,
            local: [row; 2],
            bragg: [row; 2],
            density: row,
            gain: row,
            raise: row,
            bias: [row; 2],
            power: [[row; 2]; 2],
        })
    }

    /// Responses of all facets, which are of one kind; `beside` has a spectrum of each facet's own, m^4, at
    /// wave vectors on the local axes.
    pub fn respond(&mut self, variant: Variant, water: &LaneWater, kind: usize, beside: Option<Beside<'_>>) {
        if let Some(kind) = water.kinds.get(kind) {
            variant.run(Respond { batch: self, water, kind, beside });
        }
    }
}

/// Waves beside those of the wind: the symmetrised spectrum, m^4, of the first facets, at wave vectors on the
/// local axes. Returns whether any have such waves; if none, the row is as it was.
pub type Beside<'a> = &'a dyn Fn(usize, &[Row; 2], &mut Row) -> bool;

/// Sub-facet tilts: standard deviations along and across the wind, and weight.
pub(super) type Tilt = [f32; 3];

/// What all kinds share.
#[derive(Clone, Debug)]
pub struct LaneWater {
    pub(super) wavenumber_radpm: f32,
    /// Relative permittivity less 1.
    pub(super) contrast: Complex32,
    /// Horizontal unit axis from which azimuths count.
    pub(super) axis: [f32; 2],
    pub(super) phases: Phases,
    /// One entry without deviations for no average.
    pub(super) tilts: Vec<Tilt>,
    pub(super) cut_radpm: Option<f64>,
    pub(super) table: Arc<BraggTable>,
    pub(super) kinds: Vec<LaneKind>,
    pub(super) modulation: Option<LaneModulation>,
}

impl LaneWater {
    /// Whether facets ask for [`Batch::strain`].
    pub fn is_modulated(&self) -> bool {
        self.modulation.is_some()
    }

    /// The same modulated by other waves of the same spectrum, of which it is the strength.
    pub fn modulated_by(&self, strength: &Strength) -> Self {
        let modulation = self.modulation.map(|modulation| modulation.with_strength(strength));
        Self { modulation, ..self.clone() }
    }

    /// How random phases are shared.
    pub fn phases(&self) -> Phases {
        self.phases
    }

    /// Horizontal unit axis from which azimuths count.
    pub fn axis(&self) -> [f32; 2] {
        self.axis
    }
}

/// One kind of surface.
#[derive(Clone, Debug)]
pub(super) struct LaneKind {
    /// Slope variances of clean and of covered water.
    pub slopes: [MeanSquareSlope; 2],
    /// Height variances of what scatters by Bragg, m^2.
    pub roughness_m2: [f64; 2],
    pub skew: Option<[GramCharlier; 2]>,
    /// Cosine and sine of the wind's direction from the axis.
    pub downwind: [f64; 2],
    /// `None` for clean water.
    pub damping: Option<Damping>,
}

struct Respond<'a> {
    batch: &'a mut Batch,
    water: &'a LaneWater,
    kind: &'a LaneKind,
    beside: Option<Beside<'a>>,
}

impl Task for Respond<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { batch, water, kind, beside } = self;
        batch.tangents(water.axis);
        let n = lanes_for(batch.count);
        let clear = |row: &mut Row| row[..n].fill(0.0);
        batch.matrix.as_flattened_mut().as_flattened_mut().iter_mut().for_each(clear);
        let single = water.phases == Phases::Single;
        if single {
            batch.power.as_flattened_mut().iter_mut().for_each(clear);
        }
        batch.specular(water, kind, single);
        if let Some(modulation) = &water.modulation {
            batch.modulate(modulation, water.axis);
        }
        for (tilt, shape) in water.tilts.iter().enumerate() {
            let flat = shape[..] == [0.0, 0.0, 1.0];
            if flat {
                batch.bragg_vectors::<true>(water.wavenumber_radpm, water.axis);
            } else {
                batch.tilt(kind, *shape);
                if water.modulation.is_some_and(|of| of.leans()) {
                    batch.lean(*shape);
                }
                batch.bragg_vectors::<false>(water.wavenumber_radpm, water.axis);
            }
            water.table.densities(n, kind.damping.as_ref(), &batch.bragg, &batch.cover, &mut batch.density);
            if let Some(beside) = beside {
                batch.raise(water, kind, beside);
            }
            if water.modulation.is_some() {
                batch.raise_modulated();
            }
            batch.small_perturbations(water, flat, 1 + tilt, single);
        }
        if single {
            batch.one_phase();
        }
    }
}

impl Batch {
    /// Normals, axes and cosines of the facets.
    #[inline(always)]
    fn tangents(&mut self, axis: [f32; 2]) {
        for g in 0..lanes_for(self.count) / GROUP {
            let slope = [group(&self.slope[0], g), group(&self.slope[1], g)];
            let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
            let mut normal = [[0.0f32; GROUP]; 3];
            let (mut x_axis, mut y_axis, mut cosine) = (normal, normal, [[0.0f32; GROUP]; 2]);
            for i in 0..GROUP {
                let n = unit([-slope[0][i], -slope[1][i], 1.0]);
                let [x, y] = axes(n, axis);
                (cosine[0][i], cosine[1][i]) = (-dot(lane(&incident, i), n), dot(lane(&scattered, i), n));
                for c in 0..3 {
                    (normal[c][i], x_axis[c][i], y_axis[c][i]) = (n[c], x[c], y[c]);
                }
            }
            keep(&mut self.normal, g, &normal);
            keep(&mut self.axes[0], g, &x_axis);
            keep(&mut self.axes[1], g, &y_axis);
            for (to, from) in self.cosine.iter_mut().zip(cosine) {
                *group_mut(to, g) = from;
            }
        }
    }

    /// The plane of a sub-facet, and the weight of its share.
    #[inline(always)]
    fn tilt(&mut self, kind: &LaneKind, [up, across, weight]: Tilt) {
        let [clean, covered] = kind.slopes.map(|s| s.floored());
        let [clean, covered] = [clean, covered].map(|s| [s.up as f32, s.cross as f32]);
        let [cos, sin] = kind.downwind.map(|c| c as f32);
        for g in 0..lanes_for(self.count) / GROUP {
            let (normal, x_axis, y_axis) =
                (groups(&self.normal, g), groups(&self.axes[0], g), groups(&self.axes[1], g));
            let cover = group(&self.cover, g);
            let (mut plane, mut gain) = ([[0.0f32; GROUP]; 3], [0.0f32; GROUP]);
            for i in 0..GROUP {
                let mix = |which: usize| clean[which] + cover[i] * (covered[which] - clean[which]);
                let (along, cross) = (up * mix(0).sqrt(), across * mix(1).sqrt());
                let (sx, sy) = (cos * along - sin * cross, sin * along + cos * cross);
                let (n, x, y) = (lane(&normal, i), lane(&x_axis, i), lane(&y_axis, i));
                let tilted = unit([
                    n[0] - x[0] * sx - y[0] * sy,
                    n[1] - x[1] * sx - y[1] * sy,
                    n[2] - x[2] * sx - y[2] * sy,
                ]);
                for c in 0..3 {
                    plane[c][i] = tilted[c];
                }
                gain[i] = (weight * (1.0 + along * along + cross * cross).sqrt()).sqrt();
            }
            keep(&mut self.plane, g, &plane);
            *group_mut(&mut self.gain, g) = gain;
        }
    }

    /// Cosines and Bragg wave vectors on the plane at hand: the facet's own, or that of a sub-facet.
    #[inline(always)]
    fn bragg_vectors<const FLAT: bool>(&mut self, wavenumber_radpm: f32, axis: [f32; 2]) {
        for g in 0..lanes_for(self.count) / GROUP {
            let (incident, scattered) = (groups(&self.incident, g), groups(&self.scattered, g));
            let (x_axis, y_axis) = (groups(&self.axes[0], g), groups(&self.axes[1], g));
            let plane = groups(&self.plane, g);
            let (mut bragg, mut local) = ([[0.0f32; GROUP]; 2], [[0.0f32; GROUP]; 2]);
            for i in 0..GROUP {
                let (ki, ks) = (lane(&incident, i), lane(&scattered, i));
                let k = wavenumber_radpm;
                let q = [k * (ks[0] - ki[0]), k * (ks[1] - ki[1]), k * (ks[2] - ki[2])];
                let [x, y] = if FLAT {
                    [lane(&x_axis, i), lane(&y_axis, i)]
                } else {
                    let n = lane(&plane, i);
                    (local[0][i], local[1][i]) = (-dot(ki, n), dot(ks, n));
                    axes(n, axis)
                };
                (bragg[0][i], bragg[1][i]) = (dot(q, x), dot(q, y));
            }
            for part in 0..2 {
                *group_mut(&mut self.bragg[part], g) = bragg[part];
                if !FLAT {
                    *group_mut(&mut self.local[part], g) = local[part];
                }
            }
        }
    }

    /// Adds a group's entries `[receive][transmit][real, imaginary]`, or their powers, which stand where real
    /// parts do.
    #[inline(always)]
    fn gather(&mut self, g: usize, sums: &[[[Held; 2]; 2]; 2], powers: bool) {
        for r in 0..2 {
            for t in 0..2 {
                for part in 0..if powers { 1 } else { 2 } {
                    let row = if powers { &mut self.power[r][t] } else { &mut self.matrix[r][t][part] };
                    let mut sum = group(row, g);
                    for i in 0..GROUP {
                        sum[i] += sums[r][t][part][i];
                    }
                    *group_mut(row, g) = sum;
                }
            }
        }
    }

    /// Adds waves besides those of the wind; kinds and the cutoff change both.
    fn raise(&mut self, water: &LaneWater, kind: &LaneKind, beside: Beside<'_>) {
        let mut more = [0.0; LANES];
        if !beside(self.count, &self.bragg, &mut more) {
            return;
        }
        for (i, more) in more.iter().map(|more| f64::from(*more)).enumerate().take(self.count) {
            if more > 0.0 {
                let magnitude = f64::from(self.bragg[0][i]).hypot(f64::from(self.bragg[1][i]));
                let pass = water.cut_radpm.map_or(1.0, |cut| high_pass(magnitude, cut));
                let damping =
                    kind.damping.as_ref().map_or(1.0, |damping| water.table.damping_at(damping, magnitude));
                let damped = 1.0 + f64::from(self.cover[i]) * (damping - 1.0);
                self.density[i] += (more * pass * damped) as f32;
            }
        }
    }

    /// One random phase for all entries: `sqrt(sigma0) e^{j phi}`.
    #[inline(always)]
    fn one_phase(&mut self) {
        for r in 0..2 {
            for t in 0..2 {
                for part in 0..2 {
                    for i in 0..lanes_for(self.count) {
                        self.matrix[r][t][part][i] = self.power[r][t][i].sqrt() * self.phasor[0][part][i];
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn keep(to: &mut Vectors, g: usize, from: &[Held; 3]) {
    for (to, from) in to.iter_mut().zip(from) {
        *group_mut(to, g) = *from;
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn unit(a: [f32; 3]) -> [f32; 3] {
    let scale = 1.0 / dot(a, a).max(1e-30).sqrt();
    [a[0] * scale, a[1] * scale, a[2] * scale]
}

/// Axes in the plane of a normal: the reference axis on it, and the one across.
#[inline(always)]
fn axes(n: [f32; 3], axis: [f32; 2]) -> [[f32; 3]; 2] {
    let along = n[0] * axis[0] + n[1] * axis[1];
    let x = unit([axis[0] - n[0] * along, axis[1] - n[1] * along, -n[2] * along]);
    [x, cross(n, x)]
}

#[cfg(test)]
mod tests;
