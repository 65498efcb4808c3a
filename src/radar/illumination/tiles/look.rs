//! One tile at one instant: paths, directions, fields of the antennas, amplitudes.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use num_complex::{Complex32, Complex64};

use super::tile::Node;
use crate::cpu::Task;
use crate::geometry::lanes::{End, GROUP, LANES, Paths, Row, group, group_mut, groups, lane, lanes_for};
use crate::radar::antenna::{Axes, port_shares};
use crate::radar::link::LaneLink;
use crate::scattering::lanes::{Batch, Vectors};
use crate::scene::radar::Polarisation;

/// Ports of the channels of a pair: shares of the antenna's axes.
pub(super) struct Port {
    pub shares: [Complex64; 2],
}

impl Port {
    pub fn new(port: Polarisation, isolation_db: Option<f64>) -> Self {
        Self { shares: port_shares(port, isolation_db) }
    }

    /// Weights of the squares of the axes normal to the ray, and of their product, in the square of the field's length.
    fn lengths(&self) -> [f32; 3] {
        let [y, z] = self.shares;
        [y.norm_sqr() as f32, z.norm_sqr() as f32, 2.0 * (y.re * z.re + y.im * z.im) as f32]
    }
}

/// Inverse root of the square of a field's length; nothing where there is no field.
#[inline(always)]
fn inverse_root(square: f32) -> f32 {
    if square > 1e-10 { 1.0 / square.sqrt() } else { 0.0 }
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
pub(super) struct View {
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
    pub nodes: &'a [Node],
    pub weights: &'a [f32],
    pub axes: [Axes; 2],
    pub rx_change: Axes,
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

/// Axes y and z of an antenna as rows of three.
#[inline(always)]
fn across(axes: Axes) -> [[f32; 3]; 2] {
    [axes.y_axis, axes.z_axis].map(|axis| axis.to_array().map(|c| c as f32))
}

/// What of a vector is normal to a unit direction.
#[inline(always)]
fn normal_to(a: [f32; 3], k: [f32; 3]) -> [f32; 3] {
    let along = a[0] * k[0] + a[1] * k[1] + a[2] * k[2];
    [0, 1, 2].map(|c| a[c] - k[c] * along)
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
        let Self { slopes, nodes, weights, axes, rx_change, single, view, batch } = self;
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
        let (tx, rx, change) = (across(axes[0]), across(axes[1]), across(rx_change));
        for i in 0..n {
            let ki = batch.incident.each_ref().map(|column| column[i]);
            let ks = batch.scattered.each_ref().map(|column| column[i]);
            let (v_h_in, v_h_out) = (vertical_horizontal(ki), vertical_horizontal(ks));
            for axis in 0..2 {
                let a = normal_to(tx[axis], ki);
                let b = normal_to([0, 1, 2].map(|c| rx[axis][c] + change[axis][c] * delay_s[i]), ks);
                for c in 0..3 {
                    batch.transmit[axis][c][i] = if single { v_h_in[axis][c] } else { a[c] };
                    batch.receive[axis][c][i] = if single { v_h_out[axis][c] } else { b[c] };
                }
            }
        }
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A matrix on the vertical and horizontal vectors of both rays becomes one on the axes of the antennas, which become the fields.
pub(super) struct OntoAxes<'a> {
    pub axes: [Axes; 2],
    pub rx_change: Axes,
    pub view: &'a View,
    pub batch: &'a mut Batch,
}

impl Task for OntoAxes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { axes, rx_change, view, batch } = self;
        let (tx, rx, change) = (across(axes[0]), across(axes[1]), across(rx_change));
        for i in 0..lanes_for(batch.count) {
            let at = |vectors: &Vectors| vectors.each_ref().map(|column| column[i]);
            let (ki, ks) = (at(&view.incident), at(&view.scattered));
            let (v_h_in, v_h_out) = (batch.transmit.each_ref().map(at), batch.receive.each_ref().map(at));
            let t = tx.map(|axis| normal_to(axis, ki));
            let r = [0, 1].map(|axis| {
                normal_to([0, 1, 2].map(|c| rx[axis][c] + change[axis][c] * view.delay_s[i]), ks)
            });
            let part = [0, 1]
                .map(|r| [0, 1].map(|t| Complex32::new(batch.matrix[r][t][0][i], batch.matrix[r][t][1][i])));
            for axis in 0..2 {
                let b = r[axis];
                for (of, a) in t.into_iter().enumerate() {
                    let entry = (part[0][0] * dot(a, v_h_in[0]) + part[0][1] * dot(a, v_h_in[1]))
                        * dot(b, v_h_out[0])
                        + (part[1][0] * dot(a, v_h_in[0]) + part[1][1] * dot(a, v_h_in[1]))
                            * dot(b, v_h_out[1]);
                    batch.matrix[axis][of][0][i] = entry.re;
                    batch.matrix[axis][of][1][i] = entry.im;
                }
                for c in 0..3 {
                    batch.transmit[axis][c][i] = t[axis][c];
                    batch.receive[axis][c][i] = r[axis][c];
                }
            }
        }
    }
}

/// What all channels share: the way there and back, and the area of the facet.
pub(super) struct Scale<'a> {
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

/// Inverse lengths of the field of a port across the rays, times a scale.
pub(super) struct Lengths<'a> {
    pub count: usize,
    pub port: &'a Port,
    /// Axes of the antenna normal to the rays.
    pub axes: &'a [Vectors; 2],
    pub scale: Option<&'a Row>,
    pub out: &'a mut Row,
}

impl Task for Lengths<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, port, axes, scale, out } = self;
        let [yy, zz, yz] = port.lengths();
        for g in 0..lanes_for(count) / GROUP {
            let [y, z] = [groups(&axes[0], g), groups(&axes[1], g)];
            let mut inverse = [1.0; GROUP];
            if let Some(scale) = scale {
                inverse = group(scale, g);
            }
            for i in 0..GROUP {
                let (y, z) = (lane(&y, i), lane(&z, i));
                inverse[i] *= inverse_root(yy * dot(y, y) + zz * dot(z, z) + yz * dot(y, z));
            }
            *group_mut(out, g) = inverse;
        }
    }
}

/// From the matrix to the amplitude of one channel.
pub(super) struct Combine<'a> {
    /// Transmit, receive.
    pub ports: [&'a Port; 2],
    /// What the [`Lengths`] of both make of it.
    pub scales: [&'a Row; 2],
    pub batch: &'a Batch,
    pub out: &'a mut [Row; 2],
}

impl Task for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ports, scales, batch, out } = self;
        let [c_t, c_r] = ports.map(|port| port.shares.map(|c| Complex32::new(c.re as f32, c.im as f32)));
        // Weights of the entries, receive then transmit.
        let weights = [0, 1].map(|r| [0, 1].map(|t| c_r[r] * c_t[t]));
        for g in 0..lanes_for(batch.count) / GROUP {
            let [of_transmitter, of_receiver] = scales.map(|row| group(row, g));
            let (mut re, mut im) = ([0.0; GROUP], [0.0; GROUP]);
            for row in 0..2 {
                for column in 0..2 {
                    let [a, b] = [0, 1].map(|part| group(&batch.matrix[row][column][part], g));
                    let weight = weights[row][column];
                    for i in 0..GROUP {
                        re[i] += weight.re * a[i] - weight.im * b[i];
                        im[i] += weight.re * b[i] + weight.im * a[i];
                    }
                }
            }
            for i in 0..GROUP {
                let all = of_transmitter[i] * of_receiver[i];
                let (a, b) = (re[i] * all, im[i] * all);
                // A product of lengths of rows is never asked to be large: what overflowed is silent.
                re[i] = if a.is_finite() { a } else { 0.0 };
                im[i] = if b.is_finite() { b } else { 0.0 };
            }
            *group_mut(&mut out[0], g) = re;
            *group_mut(&mut out[1], g) = im;
        }
    }
}
