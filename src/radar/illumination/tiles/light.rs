//! One tile of facets, lit at every node and pulse of a block.

use num_complex::Complex32;

use super::TileWork;
use super::factor::{Lit, Shadowed, Turn, Turns, Weigh};
use super::gain::{Gains, Sighted, is_real};
use super::look::{Combine, Lengths, OntoAxes, Port, Scale, Sight, Solve, View};
use super::tile::{Look, Pair, compact};
use crate::cpu::Variant;
use crate::geometry::lanes::{End, LANES, Paths, lanes_for};
use crate::radar::antenna::Axes;
use crate::radar::emission::Emission;
use crate::radar::illumination::Illumination;
use crate::radar::illumination::sea::SeaPlan;
use crate::scattering::facets::Phases;
use crate::scattering::lanes::{Batch, Beside};
use crate::scene::Patch;
use crate::scene::radar::Polarisation;

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
        let TileWork {
            nodes,
            phasors,
            batch,
            places_m,
            bounds_m,
            drop_m,
            fall,
            slopes,
            shades,
            seen,
            tile,
            ..
        } = work;
        let earth = self.frame.earth();
        let count = tile.count;
        let here = first..first + count;
        let nx = patch.facets[0];
        let (mut ix, mut iy) = (first % nx, first / nx);
        // Lanes beyond the patch go on along it: nobody looks at them.
        let [x_m, y_m] = &mut *places_m;
        for (x_m, y_m) in x_m.iter_mut().zip(y_m) {
            [*x_m, *y_m] = patch.centre_m([patch.first[0] + ix as i64, patch.first[1] + iy as i64]);
            ix += 1;
            if ix == nx {
                (ix, iy) = (0, iy + 1);
            }
        }
        *bounds_m = places_m.each_ref().map(|row| {
            let of = &row[..count];
            of.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)])
        });
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
        let TileWork { variant, batch, places_m, whole, kept, slopes, gain_rows, shades, seen, tile, .. } =
            work;
        if *whole {
            return;
        }
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
        for (axis, places_m) in places_m.iter().enumerate() {
            paths.position_m[axis] = *places_m;
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
    fn look(&self, sea: &SeaPlan, pair: usize, place: usize, footprint_m2: f64, work: &mut TileWork) {
        let TileWork {
            variant, looks, batch, view, lengths, places_m, bounds_m, kinds, slopes, tile, ..
        } = work;
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
        variant.run(Sight {
            slopes,
            nodes: paths,
            weights: &instant.weights,
            axes,
            rx_change,
            single,
            view,
            batch,
        });
        kinds.clear();
        if sea.scattering.kinds() > 1 && sea.scattering.kinds_within(*bounds_m, &instant.poses) {
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
        if single {
            variant.run(OntoAxes { axes, rx_change, view, batch });
        }
        let mut scale = [0.0; LANES];
        let (link, footprint_m2) = (plan.link.in_air(), footprint_m2 as f32);
        variant.run(Scale { link, footprint_m2, view, batch, out: &mut scale });
        let isolations_db = [
            self.radar.transmitters[tx].antenna.cross_pol_isolation_db,
            self.radar.receivers[rx - transmitters].antenna.cross_pol_isolation_db,
        ];
        let mut known = [[false; Polarisation::COUNT]; 2];
        for ((_, tx_port, rx_port), amplitude) in plan.channels.iter().zip(&mut out.amplitude) {
            let of = [*tx_port, *rx_port];
            let ports = [0, 1].map(|end| Port::new(of[end], isolations_db[end]));
            for end in 0..2 {
                // Channels share their ports.
                if !std::mem::replace(&mut known[end][of[end] as usize], true) {
                    let axes = if end == 0 { &batch.transmit } else { &batch.receive };
                    let (scale, out) = ((end == 0).then_some(&scale), &mut lengths[end][of[end] as usize]);
                    variant.run(Lengths { count, port: &ports[end], axes, scale, out });
                }
            }
            let scales = [&lengths[0][of[0] as usize], &lengths[1][of[1] as usize]];
            variant.run(Combine { ports: ports.each_ref(), scales, batch, out: amplitude });
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
