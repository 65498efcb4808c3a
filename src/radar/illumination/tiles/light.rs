//! One tile of facets, lit at every node and pulse of a block.

use num_complex::{Complex32, Complex64};

use super::gain::{Gains, Sighted, is_real};
use super::{NodeWork, Phasors, Sample, Tally, Tile, TileWork};
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{End, LANES, Paths, Row};
use crate::radar::antenna::{Axes, port_shares};
use crate::radar::emission::Emission;
use crate::radar::illumination::sea::SeaPlan;
use crate::radar::illumination::{Illumination, PairPlan};
use crate::scattering::facets::Phases;
use crate::scattering::lanes::{Batch, Beside, Vectors};
use crate::scene::Patch;
use crate::scene::radar::Polarisation;

/// Cosine of a local angle below which a facet may turn away within a block.
const NEAR_GRAZING: f32 = 0.1;

/// A tile at a node, over one pair.
#[derive(Clone)]
pub struct Node {
    /// Places, delays, directions.
    pub paths: Box<Paths>,
}

/// A tile at a look, over one pair.
#[derive(Clone)]
pub struct Look {
    /// Per channel of the pair: amplitude, sqrt(W), real and imaginary; without gains that are real numbers, and without shadows.
    pub amplitude: Vec<[Row; 2]>,
    /// Cosines of the local angles to both antennas.
    pub(super) cosine: [Row; 2],
}

/// A tile over one pair of antennas.
#[derive(Clone)]
pub struct Pair {
    /// At every node.
    pub nodes: Vec<Node>,
    /// At every look.
    pub looks: Vec<Look>,
    /// Per pulse: what multiplies the amplitudes.
    pub factor: Vec<Row>,
    channels: usize,
}

impl Pair {
    pub(super) fn new(channels: usize) -> Self {
        Self { nodes: Vec::new(), looks: Vec::new(), factor: Vec::new(), channels }
    }

    pub(super) fn resize(&mut self, nodes: usize, looks: usize, pulses: usize) {
        let channels = self.channels;
        self.nodes.resize_with(nodes, || Node { paths: Paths::boxed() });
        self.looks.resize_with(looks, || Look {
            amplitude: vec![[[0.0; LANES]; 2]; channels],
            cosine: [[0.0; LANES]; 2],
        });
        self.factor.resize(pulses, [0.0; LANES]);
    }

    /// Sums of power, and of power times delay rate, over facets at the middle node.
    pub(super) fn power(&self, count: usize) -> (f64, f64) {
        let (mut power, mut rate) = (0.0, 0.0);
        let middle = (
            self.nodes.get(self.nodes.len() / 2),
            self.looks.get(self.looks.len() / 2),
            self.factor.get(self.factor.len() / 2),
        );
        if let (Some(node), Some(look), Some(factor)) = middle {
            for i in 0..count {
                let of = |[re, im]: &[Row; 2]| f64::from(re[i] * re[i] + im[i] * im[i]);
                let own = look.amplitude.iter().map(of).sum::<f64>() * f64::from(factor[i] * factor[i]);
                if own.is_finite() && node.paths.delay_rate[i].is_finite() {
                    power += own;
                    rate += own * node.paths.delay_rate[i];
                }
            }
        }
        (power, rate)
    }

    /// A bound on the power of each facet at any pulse.
    #[inline(always)]
    fn bounds(&self, out: &mut Row) {
        let (mut amplitude, mut factor) = ([0.0f32; LANES], [0.0f32; LANES]);
        for [re, im] in self.looks.iter().flat_map(|look| &look.amplitude) {
            for i in 0..LANES {
                amplitude[i] = amplitude[i].max(re[i] * re[i] + im[i] * im[i]);
            }
        }
        for row in &self.factor {
            for i in 0..LANES {
                factor[i] = factor[i].max(row[i].abs());
            }
        }
        for i in 0..LANES {
            out[i] = amplitude[i] * factor[i] * factor[i];
        }
    }

    fn keep(&mut self, kept: &[u16]) {
        for node in &mut self.nodes {
            // What the echo reads; the rest stays where it was.
            compact(&mut node.paths.delay_s, kept);
            compact(&mut node.paths.delay_rate, kept);
        }
        for look in &mut self.looks {
            for row in look.amplitude.as_flattened_mut() {
                compact(row, kept);
            }
        }
        for row in &mut self.factor {
            compact(row, kept);
        }
    }
}

fn compact<T: Copy>(row: &mut [T; LANES], kept: &[u16]) {
    for (to, &from) in kept.iter().enumerate() {
        row[to] = row[usize::from(from) % LANES];
    }
}

struct Bounds<'a>(&'a Pair, &'a mut Row);

impl Task for Bounds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.bounds(self.1);
    }
}

impl Tile {
    /// Leaves out facets that nobody would miss.
    pub(super) fn thin_out(&mut self, variant: Variant, samples: &[Sample], least: f64, tally: &mut Tally) {
        let mut wanted = [false; LANES];
        let mut lit = [false; LANES];
        let mut bound = [0.0; LANES];
        for (pair, sample) in self.pairs.iter().zip(samples) {
            variant.run(Bounds(pair, &mut bound));
            let least_w = (least * sample.mean_power_w) as f32;
            for i in 0..self.count {
                lit[i] |= bound[i] > 0.0;
                wanted[i] |= bound[i] > least_w;
            }
        }
        let mut kept = [0u16; LANES];
        let mut count = 0;
        for i in 0..self.count {
            tally.lit += u64::from(lit[i]);
            tally.culled += u64::from(lit[i] && !wanted[i]);
            if wanted[i] {
                kept[count] = i as u16;
                count += 1;
            }
        }
        if count < self.count {
            for pair in &mut self.pairs {
                pair.keep(&kept[..count]);
            }
            self.count = count;
        }
    }
}

/// Ports of the channels of a pair: shares of the antenna's axes.
struct Port {
    shares: [Complex64; 2],
}

impl Port {
    fn new(port: Polarisation, isolation_db: Option<f64>) -> Self {
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

impl Illumination {
    /// Lights a tile of the patch: [`TileWork::tile`].
    pub(super) fn light_tile(&self, sea: &SeaPlan, patch: &Patch, tile: usize, work: &mut TileWork) {
        let first = tile * LANES;
        let count = LANES.min(patch.len() - first);
        work.tile.count = count;
        self.place(patch, first, work);
        let footprint_m2 = patch.facet_m * patch.facet_m;
        for pair in 0..self.plans.len() {
            for place in 0..work.tile.pairs[pair].nodes.len() {
                self.find_paths(pair, first, place, work);
            }
            for place in 0..work.tile.pairs[pair].looks.len() {
                self.look(sea, pair, first, place, footprint_m2, work);
            }
        }
        for pair in 0..self.plans.len() {
            self.gains(pair, work);
            self.factors(pair, first, work);
        }
    }

    /// Places of the facets on the mean surface, and their random phases.
    fn place(&self, patch: &Patch, first: usize, work: &mut TileWork) {
        let earth = self.frame.earth();
        let last = patch.len() - 1;
        for i in 0..LANES {
            // Lanes beyond the patch repeat its last facet.
            let key = patch.key((first + i).min(last));
            let place_m = patch.centre_m(key);
            (work.places_m[0][i], work.places_m[1][i]) = (place_m[0], place_m[1]);
            work.drop_m[i] = earth.drop_m(place_m[0], place_m[1]);
            let fall = earth.drop_slope(place_m[0], place_m[1]);
            (work.fall[0][i], work.fall[1][i]) = (fall[0] as f32, fall[1] as f32);
            let from = Phasors::place(patch, key);
            for (row, column) in work.batch.phasor.iter_mut().zip(&work.phasors.phasors) {
                (row[0][i], row[1][i]) = (column[from][0], column[from][1]);
            }
        }
    }

    /// Places and paths at a node.
    fn find_paths(&self, pair: usize, first: usize, place: usize, work: &mut TileWork) {
        let TileWork { variant, nodes, places_m, drop_m, tile, .. } = work;
        let node = &nodes[place];
        let fields = &node.fields;
        let here = first..first + tile.count;
        let plan = &self.plans[pair];
        let paths = &mut tile.pairs[pair].nodes[place].paths;
        let displaced = !fields.displacement_m[0].is_empty();
        for axis in 0..2 {
            paths.position_m[axis] = places_m[axis];
            if displaced {
                let from = &fields.displacement_m[axis][here.clone()];
                for (to, from) in paths.position_m[axis].iter_mut().zip(from) {
                    *to += f64::from(*from);
                }
                paths.velocity_mps[axis][..tile.count]
                    .copy_from_slice(&fields.velocity_mps[axis][here.clone()]);
            } else {
                paths.velocity_mps[axis].fill(0.0);
            }
        }
        let heights = fields.height_m[here.clone()].iter().zip(drop_m.iter());
        for (to, (from, drop_m)) in paths.position_m[2].iter_mut().zip(heights) {
            *to = f64::from(*from) - drop_m;
        }
        paths.velocity_mps[2][..tile.count].copy_from_slice(&fields.velocity_mps[2][here]);
        let centres = &node.emission.centres;
        let rx = self.radar.transmitters.len() + plan.pair.receiver;
        let ends = [End::from(&centres[plan.pair.transmitter]), End::from(&centres[rx])];
        variant.run(Solve { ends, paths });
    }

    /// Axes of an antenna of a pair at an emission, and their change in a second.
    fn axes_of(&self, emission: &Emission, antenna: usize) -> (Axes, Axes) {
        let now = emission.axes(antenna);
        if self.axes_span_s > 0.0 {
            let later = emission.axes_after(antenna, self.axes_span_s, self.axes_span_s);
            (now, (later - now) * (1.0 / self.axes_span_s))
        } else {
            (now, Axes::ZERO)
        }
    }

    /// Scattering at a look.
    fn look(
        &self,
        sea: &SeaPlan,
        pair: usize,
        first: usize,
        place: usize,
        footprint_m2: f64,
        work: &mut TileWork,
    ) {
        let TileWork { variant, nodes, looks, batch, view, places_m, fall, kinds, tile, .. } = work;
        let instant = &looks[place];
        let count = tile.count;
        let Pair { nodes: paths, looks: seen, .. } = &mut tile.pairs[pair];
        let out = &mut seen[place];
        let single = sea.lanes.phases() == Phases::Single;
        let plan = &self.plans[pair];
        let transmitters = self.radar.transmitters.len();
        let (tx, rx) = (plan.pair.transmitter, transmitters + plan.pair.receiver);
        let (tx_axes, _) = self.axes_of(&instant.emission, tx);
        let (rx_axes, rx_change) = self.axes_of(&instant.emission, rx);
        let axes = [tx_axes, rx_axes];
        variant.run(Slopes { nodes, weights: &instant.weights, first, count, fall, out: &mut batch.slope });
        variant.run(Sight { nodes: paths, weights: &instant.weights, axes, rx_change, single, view, batch });
        kinds.clear();
        let [x_m, y_m] = places_m.each_ref().map(|row| {
            row.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)])
        });
        if sea.scattering.kinds() > 1 && sea.scattering.kinds_within([x_m, y_m], &instant.poses) {
            kinds.extend((0..count).map(|i| {
                let (kind, cover) = sea.scattering.kind_at([places_m[0][i], places_m[1][i]], &instant.poses);
                (kind, cover as f32)
            }));
        }
        let beside = |i: usize, k: [f64; 2]| {
            sea.scattering.beside_m4([places_m[0][i], places_m[1][i]], k, &instant.poses)
        };
        let beside: Option<Beside<'_>> = if sea.scattering.has_short_waves() { Some(&beside) } else { None };
        self.respond(sea, *variant, kinds, beside, batch);
        out.cosine = batch.cosine;
        for ((_, tx_port, rx_port), amplitude) in plan.channels.iter().zip(&mut out.amplitude) {
            let tx_isolation_db = self.radar.transmitters[tx].antenna.cross_pol_isolation_db;
            let rx_isolation_db = self.radar.receivers[rx - transmitters].antenna.cross_pol_isolation_db;
            variant.run(Combine {
                ports: [Port::new(*tx_port, tx_isolation_db), Port::new(*rx_port, rx_isolation_db)],
                plan,
                footprint_m2: footprint_m2 as f32,
                single,
                axes,
                rx_change,
                view,
                batch,
                out: amplitude,
            });
        }
        for (end, antenna, axes, change) in [(0, tx, tx_axes, Axes::ZERO), (1, rx, rx_axes, rx_change)] {
            if !is_real(&self.antennas[antenna]) {
                self.complex_gain(antenna, axes, change, end, view, out, count);
            }
        }
    }

    /// Responses of the batch, kind by kind.
    fn respond(
        &self,
        sea: &SeaPlan,
        variant: Variant,
        kinds: &[(usize, f32)],
        beside: Option<Beside<'_>>,
        batch: &mut Batch,
    ) {
        let mut present = [false; 64];
        for &(kind, _) in kinds {
            present[kind.min(63)] = true;
        }
        for (i, cover) in batch.cover.iter_mut().enumerate() {
            *cover = kinds.get(i).map_or(0.0, |&(_, cover)| cover);
        }
        let several = present.iter().filter(|p| **p).count() > 1 || sea.scattering.kinds() > 64;
        if !several {
            let kind = kinds.first().map_or(0, |&(kind, _)| kind);
            batch.respond(variant, &sea.lanes, kind, beside);
            return;
        }
        let mut whole = [[[[0.0; LANES]; 2]; 2]; 2];
        for kind in 0..sea.scattering.kinds() {
            if !kinds.iter().any(|&(own, _)| own == kind) {
                continue;
            }
            batch.respond(variant, &sea.lanes, kind, beside);
            let rows = whole.as_flattened_mut().as_flattened_mut().iter_mut();
            for (to, from) in rows.zip(batch.matrix.as_flattened().as_flattened()) {
                for (i, &(own, _)) in kinds.iter().enumerate() {
                    if own == kind {
                        to[i] = from[i];
                    }
                }
            }
        }
        batch.matrix = whole;
    }

    /// Gain of an antenna whose pattern is measured, into the amplitudes.
    fn complex_gain(
        &self,
        antenna: usize,
        axes: Axes,
        change_per_s: Axes,
        end: usize,
        view: &View,
        look: &mut Look,
        count: usize,
    ) {
        let directions = if end == 0 { &view.incident } else { &view.scattered };
        let sign = if end == 0 { 1.0 } else { -1.0 };
        for i in 0..count {
            let d = glam::DVec3::from_array([0, 1, 2].map(|c| sign * f64::from(directions[c][i])));
            let axes = axes + change_per_s * f64::from(view.delay_s[i]);
            let d = crate::frames::Vector::from_raw(axes.transpose() * d);
            let gain = self.antennas[antenna].field_gain(d);
            let gain = Complex32::new(gain.re as f32, gain.im as f32);
            for [re, im] in &mut look.amplitude {
                let value = Complex32::new(re[i], im[i]) * gain;
                (re[i], im[i]) = (value.re, value.im);
            }
        }
    }

    /// Products of gains at every gain instant.
    pub(super) fn gains(&self, pair: usize, work: &mut TileWork) {
        let TileWork { variant, gains, gain_rows, tile, .. } = work;
        let plan = &self.plans[pair];
        let (tx, rx) = (plan.pair.transmitter, self.radar.transmitters.len() + plan.pair.receiver);
        // Instants beyond those in use keep their room for the next block.
        for (instant, out) in gains.iter().zip(gain_rows) {
            let now = |antenna: usize| {
                let (axes, change_per_s) = self.axes_of(&instant.emission, antenna);
                Sighted { antenna: &self.antennas[antenna], axes, change_per_s }
            };
            let nodes = &tile.pairs[pair].nodes;
            Gains { ends: [now(tx), now(rx)], nodes, weights: &instant.weights, out }.find(*variant);
        }
    }

    /// Factors of every pulse: gains, shadows, facets that turn away.
    fn factors(&self, pair: usize, first: usize, work: &mut TileWork) {
        let TileWork { variant, gain_rows, lagrange, cosines, shades, shares, seen, tile, .. } = work;
        let plan = &self.plans[pair];
        let ends = [plan.pair.transmitter, self.radar.transmitters.len() + plan.pair.receiver];
        let count = tile.count;
        let Pair { looks, factor, .. } = &mut tile.pairs[pair];
        let turns = variant.run(Turns { looks, count });
        for (pulse, out) in factor.iter_mut().enumerate() {
            let (start, weights) = &lagrange[pulse];
            variant.run(Weigh { rows: &gain_rows[*start..], weights, out });
            let (before, share) = shares[pulse];
            if let Some(shade) = shades.get(before) {
                // Where the next update adds nothing it may not be there.
                let next = shades.get(before + 1).unwrap_or(shade);
                for end in ends {
                    let from = |of: &[Vec<f32>], row: &mut Row| match of.get(end) {
                        Some(weights) if !weights.is_empty() => {
                            row[..count].copy_from_slice(&weights[first..first + count]);
                        }
                        _ => row.fill(1.0),
                    };
                    if shade.weights[end].is_empty() && next.weights[end].is_empty() {
                        continue;
                    }
                    from(&shade.weights, &mut seen[0]);
                    from(&next.weights, &mut seen[1]);
                    for i in 0..LANES {
                        out[i] *= seen[0][i] + share * (seen[1][i] - seen[0][i]);
                    }
                }
            }
            if turns {
                let (start, weights) = &cosines[pulse];
                variant.run(Turn { looks: &looks[*start..], weights, out });
            }
        }
    }
}

/// Whether some facet may turn away from an antenna.
struct Turns<'a> {
    looks: &'a [Look],
    count: usize,
}

impl Task for Turns<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let mut least = 1.0f32;
        for row in self.looks.iter().flat_map(|look| &look.cosine) {
            for cosine in &row[..self.count] {
                least = least.min(*cosine);
            }
        }
        least < NEAR_GRAZING
    }
}

/// `out = sum of weights times rows`.
struct Weigh<'a> {
    rows: &'a [Row],
    weights: &'a [f32],
    out: &'a mut Row,
}

impl Task for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.out.fill(0.0);
        for (row, weight) in self.rows.iter().zip(self.weights) {
            for i in 0..LANES {
                self.out[i] += weight * row[i];
            }
        }
    }
}

/// Darkens facets whose cosine is not positive.
struct Turn<'a> {
    looks: &'a [Look],
    weights: &'a [f32],
    out: &'a mut Row,
}

impl Task for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for end in 0..2 {
            let mut cosine = [0.0f32; LANES];
            for (look, weight) in self.looks.iter().zip(self.weights) {
                for i in 0..LANES {
                    cosine[i] += weight * look.cosine[end][i];
                }
            }
            for i in 0..LANES {
                self.out[i] = if cosine[i] > 0.0 { self.out[i] } else { 0.0 };
            }
        }
    }
}

/// Light time.
struct Solve<'a> {
    ends: [End; 2],
    paths: &'a mut Paths,
}

impl Task for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.paths.solve(&self.ends[0], &self.ends[1]);
    }
}

/// Slopes at an instant between nodes.
struct Slopes<'a> {
    nodes: &'a [NodeWork],
    weights: &'a [f32],
    first: usize,
    count: usize,
    fall: &'a [Row; 2],
    out: &'a mut [Row; 2],
}

impl Task for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for axis in 0..2 {
            let out = &mut self.out[axis];
            out.fill(0.0);
            for (node, weight) in self.nodes.iter().zip(self.weights) {
                if *weight != 0.0 {
                    let from = &node.fields.slope[axis][self.first..self.first + self.count];
                    for (to, from) in out.iter_mut().zip(from) {
                        *to += weight * from;
                    }
                }
            }
            for i in 0..LANES {
                out[i] -= self.fall[axis][i];
            }
        }
    }
}

/// A tile over one pair at an instant between nodes.
#[derive(Clone)]
pub(super) struct View {
    incident: Vectors,
    scattered: Vectors,
    leg_m: [Row; 2],
    delay_s: Row,
}

impl View {
    pub fn boxed() -> Box<Self> {
        let row = [0.0; LANES];
        Box::new(Self { incident: [row; 3], scattered: [row; 3], leg_m: [row; 2], delay_s: row })
    }
}

/// The view, and the vectors of both antennas' fields.
struct Sight<'a> {
    nodes: &'a [Node],
    weights: &'a [f32],
    axes: [Axes; 2],
    rx_change: Axes,
    single: bool,
    view: &'a mut View,
    batch: &'a mut Batch,
}

#[inline(always)]
fn add(to: &mut Row, from: &Row, weight: f32) {
    for i in 0..LANES {
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
        let Self { nodes, weights, axes, rx_change, single, view, batch } = self;
        let View { incident, scattered, leg_m, delay_s } = view;
        incident.iter_mut().chain(&mut *scattered).chain(&mut *leg_m).for_each(|row| row.fill(0.0));
        delay_s.fill(0.0);
        for (node, &weight) in nodes.iter().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            for axis in 0..3 {
                add(&mut incident[axis], &node.paths.incident[axis], weight);
                add(&mut scattered[axis], &node.paths.scattered[axis], weight);
            }
            add(&mut leg_m[0], &node.paths.leg_m[0], weight);
            add(&mut leg_m[1], &node.paths.leg_m[1], weight);
            for i in 0..LANES {
                delay_s[i] += weight * node.paths.delay_s[i] as f32;
            }
        }
        batch.incident = *incident;
        batch.scattered = *scattered;
        let (tx, rx, change) = (across(axes[0]), across(axes[1]), across(rx_change));
        for i in 0..LANES {
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
struct Combine<'a> {
    /// Transmit, receive.
    ports: [Port; 2],
    plan: &'a PairPlan,
    footprint_m2: f32,
    single: bool,
    axes: [Axes; 2],
    rx_change: Axes,
    view: &'a View,
    batch: &'a Batch,
    out: &'a mut [Row; 2],
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
        for i in 0..LANES {
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
            for value in row.iter_mut() {
                *value = if value.is_finite() { *value } else { 0.0 };
            }
        }
    }
}
