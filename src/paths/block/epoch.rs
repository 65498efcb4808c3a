//! One tile at one instant: paths, directions, fields of the antennas, amplitudes.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use num_complex::Complex32;

use super::tile::{CHANNELS_PER_LAYER, Node};
use crate::cpu::Task;
use crate::geometry::lanes::{
    End, GROUP, Held, LANES, Paths, Row, group, group_mut, groups, lane, lanes_for,
};

use crate::radar::link::{LaneLink, OfPorts};
use crate::radar::polarisation::{Axes, PortBasis, port_shares};
use crate::scattering::lanes::{Batch, Vectors, exponential};
use crate::scene::radar::{Polarisation, PolarisationBasis, PortErrors};

/// The transmitter is met at the emission.
const NO_DELAY: Row = [0.0; LANES];
/// Square of `x_a + d` below which a direction is straight back.
const BACKWARD: f32 = 1e-12;
/// Square of the sine to the vertical below which a direction is straight up or down: H is North there.
const OVERHEAD: f32 = 1e-12;
const NORTH: [f32; 3] = [0.0, 1.0, 0.0];

/// What a channel takes of each entry of the scattering matrix, `[receive][transmit]`: products of the shares
/// of H and V of its ports. Ports and their errors are those of transmitter and receiver.
pub(in crate::paths) fn port_products(
    ports: [Polarisation; 2],
    errors: [PortErrors; 2],
) -> [[Complex32; 2]; 2] {
    let [c_t, c_r] = [0, 1]
        .map(|end| port_shares(ports[end], errors[end]).map(|c| Complex32::new(c.re as f32, c.im as f32)));
    [0, 1].map(|r| [0, 1].map(|t| c_r[r] * c_t[t]))
}

/// A polarisation basis in f32.
pub(in crate::paths) struct LaneBasis {
    kind: PolarisationBasis,
    /// Its axes as rows of three.
    axes: [[f32; 3]; 3],
    change_per_s: [[f32; 3]; 3],
}

impl LaneBasis {
    pub fn new(basis: &PortBasis, change_per_s: Axes) -> Self {
        let rows =
            |axes: Axes| [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.to_array().map(|c| c as f32));
        Self { kind: basis.kind, axes: rows(basis.axes), change_per_s: rows(change_per_s) }
    }

    /// An axis `delay_s` after the emission.
    #[inline(always)]
    fn axis(&self, axis: usize, delay_s: f32) -> [f32; 3] {
        let (axis, change) = (&self.axes[axis], &self.change_per_s[axis]);
        [axis[0] + change[0] * delay_s, axis[1] + change[1] * delay_s, axis[2] + change[2] * delay_s]
    }

    /// Unit vectors of H and V across unit directions, `sign` times `k`: those of [`PortBasis::vectors`].
    #[inline(always)]
    fn vectors(&self, n: usize, sign: f32, k: &Vectors, delay_s: &Row, out: &mut [Vectors; 2]) {
        for g in 0..n.min(LANES) / GROUP {
            let (k, delay_s) = (groups(k, g), group(delay_s, g));
            let mut found = [[[0.0; GROUP]; 3]; 2];
            match self.kind {
                PolarisationBasis::Ludwig3 => {
                    for i in 0..GROUP {
                        let (x, y, z) =
                            (self.axis(0, delay_s[i]), self.axis(1, delay_s[i]), self.axis(2, delay_s[i]));
                        put(ludwig3(scaled(lane(&k, i), sign), x, y, z), i, &mut found);
                    }
                }
                PolarisationBasis::LocalHorizontal => {
                    for i in 0..GROUP {
                        let up = self.axis(2, delay_s[i]);
                        put(local_horizontal(scaled(lane(&k, i), sign), up), i, &mut found);
                    }
                }
            }
            for (out, found) in out.iter_mut().zip(found) {
                for (row, found) in out.iter_mut().zip(found) {
                    *group_mut(row, g) = found;
                }
            }
        }
    }
}

/// Vectors of one lane to where they stand.
#[inline(always)]
fn put(vectors: [[f32; 3]; 2], i: usize, found: &mut [[Held; 3]; 2]) {
    for of in 0..2 {
        for c in 0..3 {
            found[of][c][i] = vectors[of][c];
        }
    }
}

#[inline(always)]
fn scaled(a: [f32; 3], s: f32) -> [f32; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// One vector of some rows.
#[inline(always)]
fn at(vectors: &Vectors, i: usize) -> [f32; 3] {
    [vectors[0][i], vectors[1][i], vectors[2][i]]
}

/// H and V of an aperture of axes `x`, `y`, `z` towards `d`.
#[inline(always)]
fn ludwig3(d: [f32; 3], x: [f32; 3], y: [f32; 3], z: [f32; 3]) -> [[f32; 3]; 2] {
    let s = [x[0] + d[0], x[1] + d[1], x[2] + d[2]];
    let ahead = dot(s, s) > BACKWARD;
    let s =
        [if ahead { s[0] } else { z[0] }, if ahead { s[1] } else { z[1] }, if ahead { s[2] } else { z[2] }];
    let scale = 2.0 / dot(s, s);
    let (h, v) = (scale * dot(y, s), scale * dot(z, s));
    [[y[0] - h * s[0], y[1] - h * s[1], y[2] - h * s[2]], [z[0] - v * s[0], z[1] - v * s[1], z[2] - v * s[2]]]
}

/// H level and V across it, towards `d`.
#[inline(always)]
fn local_horizontal(d: [f32; 3], up: [f32; 3]) -> [[f32; 3]; 2] {
    let level = cross(up, d);
    let square = dot(level, level);
    let overhead = square < OVERHEAD;
    let scale = if overhead { 1.0 } else { 1.0 / square.max(OVERHEAD).sqrt() };
    let mut h = [0.0; 3];
    for c in 0..3 {
        h[c] = scale * if overhead { NORTH[c] - d[c] * d[1] } else { level[c] };
    }
    [h, cross(d, h)]
}

/// Light time.
pub(super) struct Solve<'a> {
    pub count: usize,
    pub ends: [End; 2],
    pub paths: &'a mut Paths,
}

impl Task for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.paths.solve(self.count, &self.ends[0], &self.ends[1]);
    }
}

/// A tile over one pair at an instant between nodes.
#[derive(Clone)]
pub(in crate::paths) struct View {
    pub incident: Vectors,
    pub scattered: Vectors,
    pub leg_m: [Row; 2],
    pub delay_s: Row,
}

impl View {
    pub fn boxed() -> Box<Self> {
        let row = [0.0; LANES];
        Box::new(Self { incident: [row; 3], scattered: [row; 3], leg_m: [row; 2], delay_s: row })
    }
}

/// The view, and the vectors of both antennas' fields.
pub(super) struct Sight<'a> {
    pub slopes: &'a [[Row; 2]],
    pub strains: &'a [[Row; 3]],
    pub nodes: &'a [Node],
    pub weights: &'a [f32],
    /// Transmit, receive.
    pub bases: &'a [LaneBasis; 2],
    pub single: bool,
    pub view: &'a mut View,
    pub batch: &'a mut Batch,
}

#[inline(always)]
fn add(n: usize, to: &mut Row, from: &Row, weight: f32) {
    for i in 0..n.min(LANES) {
        to[i] += weight * from[i];
    }
}

/// Vertical and horizontal unit vectors of a direction.
#[inline(always)]
fn vertical_horizontal(k: [f32; 3]) -> [[f32; 3]; 2] {
    let level = (k[0] * k[0] + k[1] * k[1]).sqrt();
    let inverse = 1.0 / level.max(1e-12);
    let h = if level > 1e-6 { [-k[1] * inverse, k[0] * inverse, 0.0] } else { [0.0, 1.0, 0.0] };
    let v = [h[1] * k[2] - h[2] * k[1], h[2] * k[0] - h[0] * k[2], h[0] * k[1] - h[1] * k[0]];
    [v, h]
}

impl Task for Sight<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { slopes, strains, nodes, weights, bases, single, view, batch } = self;
        let n = lanes_for(batch.count);
        let View { incident, scattered, leg_m, delay_s } = view;
        incident.iter_mut().chain(&mut *scattered).chain(&mut *leg_m).for_each(|row| row[..n].fill(0.0));
        batch.slope.iter_mut().for_each(|row| row[..n].fill(0.0));
        delay_s[..n].fill(0.0);
        for ((node, slope), &weight) in nodes.iter().zip(slopes).zip(weights) {
            if weight == 0.0 {
                continue;
            }
            for axis in 0..3 {
                add(n, &mut incident[axis], &node.paths.incident[axis], weight);
                add(n, &mut scattered[axis], &node.paths.scattered[axis], weight);
            }
            add(n, &mut leg_m[0], &node.paths.leg_m[0], weight);
            add(n, &mut leg_m[1], &node.paths.leg_m[1], weight);
            add(n, &mut batch.slope[0], &slope[0], weight);
            add(n, &mut batch.slope[1], &slope[1], weight);
            for i in 0..n {
                delay_s[i] += weight * node.paths.delay_s[i] as f32;
            }
        }
        for axis in 0..3 {
            batch.incident[axis][..n].copy_from_slice(&incident[axis][..n]);
            batch.scattered[axis][..n].copy_from_slice(&scattered[axis][..n]);
        }
        if !strains.is_empty() {
            batch.strain.iter_mut().for_each(|row| row[..n].fill(0.0));
        }
        for (strain, &weight) in strains.iter().zip(weights).take(nodes.len()) {
            for (to, from) in batch.strain.iter_mut().zip(strain) {
                add(n, to, from, weight);
            }
        }
        if !single {
            let Batch { incident, scattered, transmit, receive, .. } = &mut *batch;
            bases[0].vectors(n, 1.0, incident, &NO_DELAY, transmit);
            bases[1].vectors(n, -1.0, scattered, delay_s, receive);
            return;
        }
        on_rays(batch);
    }
}

/// Vertical and horizontal vectors of both rays for those of the antennas.
#[inline(always)]
fn on_rays(batch: &mut Batch) {
    for i in 0..lanes_for(batch.count) {
        let (ki, ks) = (at(&batch.incident, i), at(&batch.scattered, i));
        let (v_h_in, v_h_out) = (vertical_horizontal(ki), vertical_horizontal(ks));
        for axis in 0..2 {
            for c in 0..3 {
                batch.transmit[axis][c][i] = v_h_in[axis][c];
                batch.receive[axis][c][i] = v_h_out[axis][c];
            }
        }
    }
}

/// The same alone.
pub(in crate::paths) struct OnRays<'a>(pub &'a mut Batch);

impl Task for OnRays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        on_rays(self.0);
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

/// A matrix on the vertical and horizontal vectors of both rays becomes one on the polarisation bases of the
/// antennas.
pub(in crate::paths) struct OntoPorts<'a> {
    /// Transmit, receive.
    pub bases: &'a [LaneBasis; 2],
    pub view: &'a View,
    pub batch: &'a mut Batch,
}

impl Task for OntoPorts<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bases, view, batch } = self;
        let n = lanes_for(batch.count);
        let mut fields = [[[[0.0f32; LANES]; 3]; 2]; 2];
        bases[0].vectors(n, 1.0, &view.incident, &NO_DELAY, &mut fields[0]);
        bases[1].vectors(n, -1.0, &view.scattered, &view.delay_s, &mut fields[1]);
        for i in 0..n {
            let v_h_in = [at(&batch.transmit[0], i), at(&batch.transmit[1], i)];
            let v_h_out = [at(&batch.receive[0], i), at(&batch.receive[1], i)];
            let t = [at(&fields[0][0], i), at(&fields[0][1], i)];
            let r = [at(&fields[1][0], i), at(&fields[1][1], i)];
            let mut part = [[Complex32::ZERO; 2]; 2];
            for (row, entries) in part.iter_mut().zip(&batch.matrix) {
                for (to, entry) in row.iter_mut().zip(entries) {
                    *to = Complex32::new(entry[0][i], entry[1][i]);
                }
            }
            for (axis, b) in r.into_iter().enumerate() {
                for (of, a) in t.into_iter().enumerate() {
                    let entry = (part[0][0] * dot(a, v_h_in[0]) + part[0][1] * dot(a, v_h_in[1]))
                        * dot(b, v_h_out[0])
                        + (part[1][0] * dot(a, v_h_in[0]) + part[1][1] * dot(a, v_h_in[1]))
                            * dot(b, v_h_out[1]);
                    batch.matrix[axis][of][0][i] = entry.re;
                    batch.matrix[axis][of][1][i] = entry.im;
                }
            }
        }
    }
}

/// What all channels share: the way there and back, and the area of the facet.
pub(in crate::paths) struct Scale<'a> {
    pub link: LaneLink,
    pub footprint_m2: f32,
    pub view: &'a View,
    pub batch: &'a Batch,
    pub out: &'a mut Row,
}

impl Task for Scale<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { link, footprint_m2, view, batch, out } = self;
        for g in 0..lanes_for(batch.count) / GROUP {
            let [sx, sy] = [group(&batch.slope[0], g), group(&batch.slope[1], g)];
            let legs_m = [group(&view.leg_m[0], g), group(&view.leg_m[1], g)];
            let mut scale = [0.0; GROUP];
            for i in 0..GROUP {
                let root_area = (footprint_m2 * (1.0 + sx[i] * sx[i] + sy[i] * sy[i]).sqrt()).sqrt();
                scale[i] = link.scattered(legs_m[0][i], legs_m[1][i]) * root_area;
            }
            *group_mut(out, g) = scale;
        }
    }
}

/// A scale in the rain between two ports.
pub(in crate::paths) struct InRain<'a> {
    pub rain: OfPorts<f32>,
    /// Of transmitter and receiver.
    pub ports: [Polarisation; 2],
    pub view: &'a View,
    pub scale: &'a Row,
    pub count: usize,
    pub out: &'a mut Row,
}

impl Task for InRain<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { rain, ports, view, scale, count, out } = self;
        let (down, up, [tx_m, rx_m]) = (&view.incident[2], &view.scattered[2], &view.leg_m);
        for i in 0..lanes_for(count).min(LANES) {
            let neper = rain.neper(ports, [tx_m[i], rx_m[i]], [down[i], up[i]]);
            // No port has less than the least but for rounding.
            out[i] = scale[i] * exponential(neper.min(0.0));
        }
    }
}

/// From the matrix to the amplitudes of the channels of a layer of `C` lanes.
pub(super) struct Combine<'a, const C: usize> {
    /// [`port_products`] of each channel.
    pub ports: &'a [[[Complex32; 2]; 2]],
    /// Of each channel.
    pub scales: [&'a Row; CHANNELS_PER_LAYER],
    pub batch: &'a Batch,
    /// `[facet][lane]`.
    pub out: &'a mut [[f32; C]],
    /// Raised to the largest power of any channel, W.
    pub power: &'a mut Row,
}

impl<const C: usize> Task for Combine<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ports, scales, batch, out, power } = self;
        let (lines, _) = out.as_chunks_mut::<GROUP>();
        for (g, lines) in lines.iter_mut().enumerate().take(lanes_for(batch.count) / GROUP) {
            let mut most = group(power, g);
            for channel in 0..C / 2 {
                let (Some(products), Some(scale)) = (ports.get(channel), scales.get(channel)) else { break };
                let scale = group(scale, g);
                let (mut re, mut im) = ([0.0; GROUP], [0.0; GROUP]);
                for row in 0..2 {
                    for column in 0..2 {
                        let [re_part, im_part] = &batch.matrix[row][column];
                        let (a, b) = (group(re_part, g), group(im_part, g));
                        let weight = products[row][column];
                        for i in 0..GROUP {
                            re[i] += weight.re * a[i] - weight.im * b[i];
                            im[i] += weight.re * b[i] + weight.im * a[i];
                        }
                    }
                }
                for i in 0..GROUP {
                    let (a, b) = (re[i] * scale[i], im[i] * scale[i]);
                    // A product of lengths of rows is never asked to be large: what overflowed is zero.
                    re[i] = if a.is_finite() { a } else { 0.0 };
                    im[i] = if b.is_finite() { b } else { 0.0 };
                    most[i] = most[i].max(re[i] * re[i] + im[i] * im[i]);
                }
                for i in 0..GROUP {
                    lines[i][2 * channel] = re[i];
                    lines[i][2 * channel + 1] = im[i];
                }
            }
            *group_mut(power, g) = most;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;

    /// The bases of f32 against those of f64, on directions all around that are not near a singular one.
    #[test]
    fn lanes_have_the_bases_of_the_reference() {
        let turned = Axes::from_quat(DQuat::from_xyzw(0.1, -0.3, 0.7, 0.5).normalize());
        let up = DVec3::new(0.02, -0.01, 1.0).normalize();
        let bases = [PortBasis::ludwig3(turned), PortBasis::local_horizontal(up)];
        for (n, basis) in bases.iter().enumerate() {
            let lanes = LaneBasis::new(basis, Axes::ZERO);
            let pole = if n == 0 { -turned.x_axis } else { up };
            for sign in [1.0f32, -1.0] {
                let mut worst = 0.0f64;
                for turn in 0..180 {
                    let mut k: Vectors = [[0.0; LANES]; 3];
                    let at = |i: usize| {
                        let angle = 0.1 + 0.02 * f64::from(turn) + i as f64;
                        let z = (2.0 * i as f64 + 1.0) / LANES as f64 - 1.0;
                        let level = (1.0 - z * z).sqrt();
                        DVec3::new(level * angle.cos(), level * angle.sin(), z)
                    };
                    for i in 0..LANES {
                        let d = at(i) * f64::from(sign);
                        for (row, c) in k.iter_mut().zip(d.to_array()) {
                            row[i] = c as f32;
                        }
                    }
                    let mut out = [[[0.0f32; LANES]; 3]; 2];
                    lanes.vectors(LANES, sign, &k, &NO_DELAY, &mut out);
                    for i in 0..LANES {
                        let d = at(i);
                        let off = d.cross(pole).length();
                        for (vector, exact) in out.iter().zip(basis.vectors(d)) {
                            let found = DVec3::from_array([0, 1, 2].map(|c| f64::from(vector[c][i])));
                            worst = worst.max((found - exact).length() * off.max(1e-3));
                        }
                    }
                }
                // A dozen roundings of 2^-24, more beside a singular direction by the sine of the angle to
                // it.
                assert!(worst < 12.0 * 2f64.powi(-24), "{n} {sign}: {worst:e}");
            }
        }
    }

    /// Straight up, down and back there are vectors all the same, across the direction.
    #[test]
    fn lanes_survive_singular_directions() {
        let bases = [PortBasis::ludwig3(Axes::IDENTITY), PortBasis::local_horizontal(DVec3::X)];
        for basis in &bases {
            for x in [1.0, -1.0] {
                let k: Vectors = [[x; LANES], [0.0; LANES], [0.0; LANES]];
                let mut out = [[[0.0f32; LANES]; 3]; 2];
                LaneBasis::new(basis, Axes::ZERO).vectors(LANES, 1.0, &k, &NO_DELAY, &mut out);
                let [h, v] = out.map(|of| of.map(|row| row[LANES - 1]));
                assert!((dot(h, h) - 1.0).abs() < 1e-6 && (dot(v, v) - 1.0).abs() < 1e-6, "{h:?} {v:?}");
                assert!(h[0] == 0.0 && v[0] == 0.0 && dot(h, v) == 0.0, "{h:?} {v:?}");
                let d = [x, 0.0, 0.0];
                assert!(dot(cross(d, h), v) > 0.999, "right-handed: {h:?} {v:?}");
            }
        }
    }
}
