//! One tile of facets, lit at every node and pulse of a block.

use num_complex::{Complex32, Complex64};

use super::gain::{Gains, Sighted, is_real};
use super::{Sample, Tally, Tile, TileWork};
use crate::cpu::{Task, Variant};
use crate::geometry::lanes::{End, LANES, Paths, Row, lanes_for};
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

/// Cosine (but for the length of the normal) at all nodes below which a facet does not turn towards an antenna between them.
const TURNED_AWAY: f32 = -0.02;

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
    fn bounds(&self, count: usize, out: &mut Row) {
        let n = lanes_for(count);
        let (mut amplitude, mut factor) = ([0.0f32; LANES], [0.0f32; LANES]);
        for [re, im] in self.looks.iter().flat_map(|look| &look.amplitude) {
            for i in 0..n {
                amplitude[i] = amplitude[i].max(re[i] * re[i] + im[i] * im[i]);
            }
        }
        for row in &self.factor {
            for i in 0..n {
                factor[i] = factor[i].max(row[i].abs());
            }
        }
        for i in 0..n {
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

struct Bounds<'a>(&'a Pair, usize, &'a mut Row);

impl Task for Bounds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.bounds(self.1, self.2);
    }
}

impl Tile {
    /// Leaves out facets that nobody would miss.
    pub(super) fn thin_out(&mut self, variant: Variant, samples: &[Sample], least: f64, tally: &mut Tally) {
        let mut wanted = [false; LANES];
        let mut lit = [false; LANES];
        let mut bound = [0.0; LANES];
        for (pair, sample) in self.pairs.iter().zip(samples) {
            variant.run(Bounds(pair, self.count, &mut bound));
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
    /// Lights a tile of the patch: [`TileWork::tile`]. Facets that no pair can hear at any pulse are left out.
    pub(super) fn light_tile(&self, sea: &SeaPlan, patch: &Patch, tile: usize, work: &mut TileWork) {
        let first = tile * LANES;
        work.tile.count = LANES.min(patch.len() - first);
        self.place(patch, first, work);
        for pair in 0..self.plans.len() {
            for place in 0..work.tile.pairs[pair].nodes.len() {
                self.find_paths(pair, first, place, work);
            }
            self.gains(pair, work);
        }
        self.keep_lit(work);
        if work.tile.count == 0 {
            return;
        }
        let footprint_m2 = patch.facet_m * patch.facet_m;
        for pair in 0..self.plans.len() {
            for place in 0..work.tile.pairs[pair].looks.len() {
                self.look(sea, pair, place, footprint_m2, work);
            }
            self.factors(pair, work);
        }
    }

    /// Places of the facets on the mean surface, random phases, slopes, visibility.
    fn place(&self, patch: &Patch, first: usize, work: &mut TileWork) {
        let TileWork { nodes, phasors, batch, places_m, drop_m, fall, slopes, shades, seen, tile, .. } = work;
        let earth = self.frame.earth();
        let count = tile.count;
        let here = first..first + count;
        let nx = patch.facets[0];
        let (mut ix, mut iy) = (first % nx, first / nx);
        // Lanes beyond the patch go on along it: nobody looks at them.
        for i in 0..LANES {
            let place_m = patch.centre_m([patch.first[0] + ix as i64, patch.first[1] + iy as i64]);
            (places_m[0][i], places_m[1][i]) = (place_m[0], place_m[1]);
            ix += 1;
            if ix == nx {
                (ix, iy) = (0, iy + 1);
            }
        }
        let flat = earth.drop_m(1.0, 1.0) == 0.0;
        for i in 0..if flat { 0 } else { LANES } {
            drop_m[i] = earth.drop_m(places_m[0][i], places_m[1][i]);
            let down = earth.drop_slope(places_m[0][i], places_m[1][i]);
            (fall[0][i], fall[1][i]) = (down[0] as f32, down[1] as f32);
        }
        for (row, column) in batch.phasor.iter_mut().zip(&phasors.ordered) {
            row[0][..count].copy_from_slice(&column[0][here.clone()]);
            row[1][..count].copy_from_slice(&column[1][here.clone()]);
        }
        for (slopes, node) in slopes.iter_mut().zip(nodes) {
            for axis in 0..2 {
                let from = &node.fields.slope[axis][here.clone()];
                for ((to, from), fall) in slopes[axis].iter_mut().zip(from).zip(&fall[axis]) {
                    *to = from - fall;
                }
            }
        }
        let ends = shades.first().map_or(0, |shade| shade.weights.len());
        seen.resize(shades.len() * ends, [1.0; LANES]);
        for (row, weights) in seen.iter_mut().zip(shades.iter().flat_map(|shade| &shade.weights)) {
            if weights.is_empty() {
                row.fill(1.0);
            } else {
                row[..count].copy_from_slice(&weights[here.clone()]);
            }
        }
    }

    /// Leaves out facets that are hidden at every update, turned away at every node, or seen by no gain.
    fn keep_lit(&self, work: &mut TileWork) {
        let TileWork { variant, batch, places_m, kept, slopes, gain_rows, shades, seen, tile, .. } = work;
        let count = tile.count;
        let mut lit = [0.0f32; LANES];
        let ends = shades.first().map_or(0, |shade| shade.weights.len());
        for ((plan, pair), gains) in self.plans.iter().zip(&tile.pairs).zip(&*gain_rows) {
            let of = [plan.pair.transmitter, self.radar.transmitters.len() + plan.pair.receiver];
            variant.run(Lit { count, nodes: &pair.nodes, slopes, gains, seen, ends, of, lit: &mut lit });
        }
        kept.clear();
        kept.extend((0..count as u16).filter(|i| lit[usize::from(*i)] > 0.0));
        // Moving facets together costs something, and what is gained are whole groups.
        if lanes_for(kept.len()) == lanes_for(count) {
            return;
        }
        for pair in &mut tile.pairs {
            for node in &mut pair.nodes {
                let Paths { delay_s, delay_rate, leg_m, incident, scattered, .. } = &mut *node.paths;
                compact(delay_s, kept);
                compact(delay_rate, kept);
                leg_m.iter_mut().chain(incident).chain(scattered).for_each(|row| compact(row, kept));
            }
        }
        slopes.as_flattened_mut().iter_mut().for_each(|row| compact(row, kept));
        gain_rows.iter_mut().flatten().chain(seen).for_each(|row| compact(row, kept));
        batch.phasor.as_flattened_mut().iter_mut().for_each(|row| compact(row, kept));
        places_m.iter_mut().for_each(|row| compact(row, kept));
        tile.count = kept.len();
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
        variant.run(Solve { count: tile.count, ends, paths });
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
        place: usize,
        footprint_m2: f64,
        work: &mut TileWork,
    ) {
        let TileWork { variant, looks, batch, view, places_m, kinds, slopes, tile, .. } = work;
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
        batch.count = count;
        variant.run(Sight { slopes, nodes: paths, weights: &instant.weights, axes, rx_change, single, view, batch });
        kinds.clear();
        let [x_m, y_m] = places_m.each_ref().map(|row| {
            row[..count].iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)])
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
    fn gains(&self, pair: usize, work: &mut TileWork) {
        let TileWork { variant, gains, gain_rows, tile, .. } = work;
        let plan = &self.plans[pair];
        let (tx, rx) = (plan.pair.transmitter, self.radar.transmitters.len() + plan.pair.receiver);
        // Instants beyond those in use keep their room for the next block.
        for (instant, out) in gains.iter().zip(&mut gain_rows[pair]) {
            let now = |antenna: usize| {
                let (axes, change_per_s) = self.axes_of(&instant.emission, antenna);
                Sighted { antenna: &self.antennas[antenna], axes, change_per_s }
            };
            let (nodes, weights, count) = (&tile.pairs[pair].nodes, &instant.weights, tile.count);
            Gains { count, ends: [now(tx), now(rx)], nodes, weights, out }.find(*variant);
        }
    }

    /// Factors of every pulse: gains, shadows, facets that turn away.
    fn factors(&self, pair: usize, work: &mut TileWork) {
        let TileWork { variant, gain_rows, lagrange, cosines, shades, shares, seen, tile, .. } = work;
        let plan = &self.plans[pair];
        let antennas = [plan.pair.transmitter, self.radar.transmitters.len() + plan.pair.receiver];
        let count = tile.count;
        let Pair { looks, factor, .. } = &mut tile.pairs[pair];
        let turns = variant.run(Turns { count, looks });
        let ends = shades.first().map_or(0, |shade| shade.weights.len());
        for (pulse, out) in factor.iter_mut().enumerate() {
            let (start, weights) = &lagrange[pulse];
            variant.run(Weigh { count, rows: &gain_rows[pair][*start..], weights, out });
            let (before, share) = shares[pulse];
            // Where the next update adds nothing it may not be there.
            let next = (before + 1).min(shades.len().saturating_sub(1));
            for antenna in antennas.into_iter().filter(|antenna| *antenna < ends) {
                let dark = |update: usize| !shades[update].weights[antenna].is_empty();
                if dark(before) || dark(next) {
                    let of = |update: usize| &seen[update * ends + antenna];
                    variant.run(Shadowed { count, from: of(before), to: of(next), share, out });
                }
            }
            if turns {
                let (start, weights) = &cosines[pulse];
                variant.run(Turn { count, looks: &looks[*start..], weights, out });
            }
        }
    }
}

/// Marks the facets of a pair that may return something.
struct Lit<'a> {
    count: usize,
    nodes: &'a [Node],
    slopes: &'a [[Row; 2]],
    gains: &'a [Row],
    /// `[update][antenna]`.
    seen: &'a [Row],
    ends: usize,
    /// Transmitter and receiver.
    of: [usize; 2],
    lit: &'a mut Row,
}

impl Task for Lit<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, nodes, slopes, gains, seen, ends, of, lit } = self;
        let n = lanes_for(count);
        let mut gain = [0.0f32; LANES];
        for row in gains {
            for i in 0..n {
                gain[i] = gain[i].max(row[i].abs());
            }
        }
        for end in 0..2 {
            // Largest cosine, but for the length of the normal.
            let mut cosine = [-1.0f32; LANES];
            for (node, slope) in nodes.iter().zip(slopes) {
                let (k, sign) =
                    if end == 0 { (&node.paths.incident, -1.0f32) } else { (&node.paths.scattered, 1.0) };
                for i in 0..n {
                    let along = sign * (k[2][i] - k[0][i] * slope[0][i] - k[1][i] * slope[1][i]);
                    cosine[i] = if along > cosine[i] { along } else { cosine[i] };
                }
            }
            for i in 0..n {
                gain[i] = if cosine[i] > TURNED_AWAY { gain[i] } else { 0.0 };
            }
            if ends > 0 {
                let mut most = [0.0f32; LANES];
                for rows in seen.chunks_exact(ends) {
                    let row = &rows[of[end] % ends];
                    for i in 0..n {
                        most[i] = if row[i] > most[i] { row[i] } else { most[i] };
                    }
                }
                for i in 0..n {
                    gain[i] *= most[i];
                }
            }
        }
        for i in 0..n {
            lit[i] = if gain[i] > lit[i] { gain[i] } else { lit[i] };
        }
    }
}

/// Factors times a visibility between two updates.
struct Shadowed<'a> {
    count: usize,
    from: &'a Row,
    to: &'a Row,
    share: f32,
    out: &'a mut Row,
}

impl Task for Shadowed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, from, to, share, out } = self;
        for i in 0..lanes_for(count) {
            out[i] *= from[i] + share * (to[i] - from[i]);
        }
    }
}

/// Whether some facet may turn away from an antenna.
struct Turns<'a> {
    count: usize,
    looks: &'a [Look],
}

impl Task for Turns<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let n = lanes_for(self.count);
        let mut least = [1.0f32; LANES];
        for row in self.looks.iter().flat_map(|look| &look.cosine) {
            for i in 0..n {
                least[i] = if row[i] < least[i] { row[i] } else { least[i] };
            }
        }
        least[..self.count.min(LANES)].iter().any(|cosine| *cosine < NEAR_GRAZING)
    }
}

/// `out = sum of weights times rows`.
struct Weigh<'a> {
    count: usize,
    rows: &'a [Row],
    weights: &'a [f32],
    out: &'a mut Row,
}

impl Task for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = lanes_for(self.count);
        self.out[..n].fill(0.0);
        for (row, weight) in self.rows.iter().zip(self.weights) {
            for i in 0..n {
                self.out[i] += weight * row[i];
            }
        }
    }
}

/// Darkens facets whose cosine is not positive.
struct Turn<'a> {
    count: usize,
    looks: &'a [Look],
    weights: &'a [f32],
    out: &'a mut Row,
}

impl Task for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = lanes_for(self.count);
        for end in 0..2 {
            let mut cosine = [0.0f32; LANES];
            for (look, weight) in self.looks.iter().zip(self.weights) {
                for i in 0..n {
                    cosine[i] += weight * look.cosine[end][i];
                }
            }
            for i in 0..n {
                self.out[i] = if cosine[i] > 0.0 { self.out[i] } else { 0.0 };
            }
        }
    }
}

/// Light time.
struct Solve<'a> {
    count: usize,
    ends: [End; 2],
    paths: &'a mut Paths,
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
    slopes: &'a [[Row; 2]],
    nodes: &'a [Node],
    weights: &'a [f32],
    axes: [Axes; 2],
    rx_change: Axes,
    single: bool,
    view: &'a mut View,
    batch: &'a mut Batch,
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
