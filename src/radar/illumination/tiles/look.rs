//! One tile at one instant: paths, directions, fields of the antennas, amplitudes.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use num_complex::{Complex32, Complex64};

use super::tile::Node;
use crate::cpu::Task;
use crate::geometry::lanes::{End, LANES, Paths, Row, lanes_for};
use crate::radar::antenna::{Axes, port_shares};
use crate::radar::illumination::PairPlan;
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

    /// Inverse length of the field, given the squares of the axes normal to the ray and their product.
    #[inline(always)]
    fn inverse_norm(&self, yy: f32, zz: f32, yz: f32) -> f32 {
        let [y, z] = self.shares;
        let mixed = 2.0 * (y.re * z.re + y.im * z.im) as f32;
        let square = y.norm_sqr() as f32 * yy + z.norm_sqr() as f32 * zz + mixed * yz;
        if square > 1e-10 { 1.0 / square.sqrt() } else { 0.0 }
    }
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

/// From the matrix to the amplitude of one channel.
pub(super) struct Combine<'a> {
    /// Transmit, receive.
    pub ports: [Port; 2],
    pub plan: &'a PairPlan,
    pub footprint_m2: f32,
    pub single: bool,
    pub axes: [Axes; 2],
    pub rx_change: Axes,
    pub view: &'a View,
    pub batch: &'a Batch,
    pub out: &'a mut [Row; 2],
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Task for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ports: [tx_port, rx_port], plan, footprint_m2, single, axes, rx_change, view, batch, out } =
            self;
        let link = plan.link.in_air();
        let (tx, rx, change) = (across(axes[0]), across(axes[1]), across(rx_change));
        let single_precision = |port: &Port| port.shares.map(|c| Complex32::new(c.re as f32, c.im as f32));
        let (c_t, c_r) = (single_precision(&tx_port), single_precision(&rx_port));
        let n = lanes_for(batch.count);
        for i in 0..n {
            let at = |vectors: &Vectors| vectors.each_ref().map(|column| column[i]);
            let entry =
                |r: usize, t: usize| Complex32::new(batch.matrix[r][t][0][i], batch.matrix[r][t][1][i]);
            // Axes normal to the rays.
            let (mut t, mut r) = (batch.transmit.each_ref().map(at), batch.receive.each_ref().map(at));
            let mut matrix = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
            if single {
                let (ki, ks) = (at(&view.incident), at(&view.scattered));
                let delay_s = view.delay_s[i];
                let (v_h_in, v_h_out) = (t, r);
                for axis in 0..2 {
                    t[axis] = normal_to(tx[axis], ki);
                    r[axis] = normal_to([0, 1, 2].map(|c| rx[axis][c] + change[axis][c] * delay_s), ks);
                }
                let part = matrix;
                for (row, b) in matrix.iter_mut().zip(r) {
                    for (entry, a) in row.iter_mut().zip(t) {
                        *entry = (part[0][0] * dot(a, v_h_in[0]) + part[0][1] * dot(a, v_h_in[1]))
                            * dot(b, v_h_out[0])
                            + (part[1][0] * dot(a, v_h_in[0]) + part[1][1] * dot(a, v_h_in[1]))
                                * dot(b, v_h_out[1]);
                    }
                }
            }
            let norm = tx_port.inverse_norm(dot(t[0], t[0]), dot(t[1], t[1]), dot(t[0], t[1]))
                * rx_port.inverse_norm(dot(r[0], r[0]), dot(r[1], r[1]), dot(r[0], r[1]));
            let (sx, sy) = (batch.slope[0][i], batch.slope[1][i]);
            let root_area = (footprint_m2 * (1.0 + sx * sx + sy * sy).sqrt()).sqrt();
            let (out_m, back_m) = (view.leg_m[0][i], view.leg_m[1][i]);
            let scale = link.scattered(out_m, back_m) * root_area * norm;
            let sum = c_r[0] * (matrix[0][0] * c_t[0] + matrix[0][1] * c_t[1])
                + c_r[1] * (matrix[1][0] * c_t[0] + matrix[1][1] * c_t[1]);
            out[0][i] = sum.re * scale;
            out[1][i] = sum.im * scale;
        }
        // A product of lengths of rows is never asked to be large: what overflowed is silent.
        for row in out {
            for value in &mut row[..n] {
                *value = if value.is_finite() { *value } else { 0.0 };
            }
        }
    }
}
