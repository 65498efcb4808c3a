//! One tile of facets, illuminated at every node and pulse of a block.

use num_complex::Complex32;

use super::TileWork;
use super::factor::{Illuminated, Shadowed, Stretched, Turns, Weigh};
use super::runs::Gather;
use super::tile::{CHANNELS_PER_LAYER, Epoch, Pair, compact};
use super::timing::Timing;
use super::turning::Turned;
use crate::cpu::Variant;
use crate::geometry::lanes::{LANES, Paths, Row, lanes_for};
use crate::paths::block::epoch::{Combine, InRain, LaneBasis, OntoPorts, Scale, Sight, View, port_products};
use crate::paths::emission::Emission;
use crate::paths::sea::{LandPlan, SeaPlan};
use crate::paths::{PairPlan, PathGenerator};
use crate::radar::polarisation::Axes;
use crate::scattering::facets::Phases;
use crate::scattering::lanes::{Batch, Beside};
use crate::scene::Patch;

/// Most power of a channel over that of the largest entry of a matrix: ports may be as much H as V.
const OF_PORTS: f32 = 4.0;

impl TileWork {
    /// Instants of the tile at hand.
    pub(super) fn timing(&self) -> &Timing {
        self.timings.of(self.tile.tier)
    }
}

impl PathGenerator {
    /// Evaluates the tile of the runs at hand: [`TileWork::tile`]. Facets that return nothing to any pair at
    /// any pulse are left out; `false` of a tile that is left out as a whole, beyond the beams.
    pub(super) fn evaluate_tile(&self, sea: &SeaPlan, patch: &Patch, work: &mut TileWork) -> bool {
        self.place(sea, patch, work);
        if !self.sight(sea, work) {
            work.tile.count = 0;
            return false;
        }
        self.keep_illuminated(work);
        self.choose_supports(sea, work);
        if work.tile.count == 0 {
            return true;
        }
        let footprint_m2 = patch.facet_m * patch.facet_m;
        for pair in 0..self.plans.len() {
            for place in 0..work.tile.pairs[pair].epoch_count {
                self.epoch(sea, pair, place, footprint_m2, work);
            }
            self.factors(patch, pair, work);
        }
        true
    }

    /// Places of the facets on the mean surface, random phases, visibility.
    fn place(&self, sea: &SeaPlan, patch: &Patch, work: &mut TileWork) {
        let TileWork {
            variant,
            facet_surface,
            runs,
            phasors,
            part,
            land,
            batch,
            places_m,
            keys,
            bounds_m,
            drop_m,
            fall,
            shadow_updates,
            seen,
            dims,
            tile,
            ..
        } = work;
        let earth = self.frame.earth();
        let count = runs.iter().map(|run| run.count).sum();
        tile.count = count;
        let nx = patch.facets[0];
        let [x_m, y_m] = &mut *places_m;
        let mut places = x_m.iter_mut().zip(y_m).zip(&mut *keys);
        for run in &*runs {
            let key = [patch.first[0] + (run.first % nx) as i64, patch.first[1] + (run.first / nx) as i64];
            for (((x_m, y_m), own), column) in places.by_ref().take(run.count).zip(0..) {
                *own = [key[0] + column, key[1]];
                [*x_m, *y_m] = patch.centre_m(*own);
            }
        }
        // Lanes that are not in use stay near the others: nothing is read from them.
        for row in &mut *places_m {
            let last = row[count - 1];
            row[count..].fill(last);
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
            variant.run(Gather { runs, from: &column[0], to: &mut row[0] });
            variant.run(Gather { runs, from: &column[1], to: &mut row[1] });
        }
        part.choose(&sea.scattering, batch);
        land.count = 0;
        if let Some(sheet) = facet_surface.land() {
            let from =
                std::iter::once(sheet.land()).chain(sheet.phasors().as_flattened().iter().map(Vec::as_slice));
            land.rows_mut().zip(from).for_each(|(to, from)| variant.run(Gather { runs, from, to }));
            land.land[count..].fill(0.0);
            land.count = land.land.iter().filter(|land| **land > 0.0).count();
        }
        let ends = shadow_updates.first().map_or(0, |update_weights| update_weights.weights.len());
        seen.resize(shadow_updates.len() * ends, [1.0; LANES]);
        dims.clear();
        for (n, row) in seen.iter_mut().enumerate() {
            let (update, antenna) = (&shadow_updates[n / ends], n % ends);
            let own = update.dims(antenna, runs, nx);
            if own {
                variant.run(Gather { runs, from: &update.weights[antenna], to: row });
            } else {
                row.fill(1.0);
            }
            dims.push(own);
        }
    }

    /// Leaves out facets that are hidden at every update, turned away at every node, or outside of every
    /// gain.
    fn keep_illuminated(&self, work: &mut TileWork) {
        let instants = work.timing().gain_places.len();
        let TileWork {
            variant,
            batch,
            land,
            places_m,
            keys,
            whole,
            kept,
            slopes,
            strains,
            areas,
            gain_rows,
            shadow_updates,
            seen,
            tile,
            ..
        } = work;
        if *whole {
            return;
        }
        let count = tile.count;
        let mut illuminated = [0.0f32; LANES];
        let ends = shadow_updates.first().map_or(0, |update_weights| update_weights.weights.len());
        for ((plan, pair), gains) in self.plans.iter().zip(&tile.pairs).zip(&*gain_rows) {
            let of = plan.ends(self.radar.transmitters.len());
            let (nodes, gains) = (pair.nodes(), &gains[..instants]);
            variant.run(Illuminated {
                count,
                nodes,
                slopes,
                gains,
                seen,
                ends,
                of,
                illuminated: &mut illuminated,
            });
        }
        kept.clear();
        kept.extend((0..count as u16).filter(|i| illuminated[usize::from(*i)] > 0.0));
        // Moving facets together costs something, and what is gained are whole groups.
        if lanes_for(kept.len()) == lanes_for(count) {
            return;
        }
        for pair in &mut tile.pairs {
            for node in &mut pair.nodes[..pair.node_count] {
                let Paths { delay_s, delay_rate, leg_m, incident, scattered, .. } = &mut *node.paths;
                compact(delay_s, kept);
                compact(delay_rate, kept);
                leg_m.iter_mut().chain(incident).chain(scattered).for_each(|row| compact(row, kept));
            }
        }
        slopes.as_flattened_mut().iter_mut().for_each(|row| compact(row, kept));
        strains.as_flattened_mut().iter_mut().chain(areas).for_each(|row| compact(row, kept));
        gain_rows
            .iter_mut()
            .flat_map(|rows| &mut rows[..instants])
            .chain(seen)
            .for_each(|row| compact(row, kept));
        batch.phasor.as_flattened_mut().iter_mut().for_each(|row| compact(row, kept));
        places_m.iter_mut().for_each(|row| compact(row, kept));
        compact(keys, kept);
        if land.count > 0 {
            land.rows_mut().for_each(|row| compact(row, kept));
            land.land[kept.len()..].fill(0.0);
            land.count = land.land.iter().filter(|land| **land > 0.0).count();
        }
        tile.count = kept.len();
    }

    /// Axes of an antenna of a pair at an emission, and their change in a second.
    pub(in crate::paths) fn axes_of(&self, emission: &Emission, antenna: usize) -> (Axes, Axes) {
        let now = emission.axes(antenna);
        if self.axes_span_s > 0.0 {
            let later = emission.axes_after(antenna, self.axes_span_s, self.axes_span_s);
            (now, (later - now) * (1.0 / self.axes_span_s))
        } else {
            (now, Axes::ZERO)
        }
    }

    /// Polarisation basis of an antenna of a pair at an emission, and how it changes.
    pub(in crate::paths) fn basis_of(&self, emission: &Emission, antenna: usize) -> LaneBasis {
        let now = emission.basis(antenna);
        let span_s = self.axes_span_s;
        if span_s > 0.0 {
            let later = emission.basis_after(antenna, span_s, span_s);
            LaneBasis::new(&now, (later.axes - now.axes) * (1.0 / span_s))
        } else {
            LaneBasis::new(&now, Axes::ZERO)
        }
    }

    /// Scattering at a scattering epoch.
    pub(super) fn epoch(
        &self,
        sea: &SeaPlan,
        pair: usize,
        place: usize,
        footprint_m2: f64,
        work: &mut TileWork,
    ) {
        let TileWork {
            variant,
            timings,
            batch,
            part,
            land,
            view,
            places_m,
            bounds_m,
            kinds,
            slopes,
            strains,
            areas,
            tile,
            ..
        } = work;
        let timing = timings.of(tile.tier);
        let instant = &timing.epochs[place];
        let count = tile.count;
        let Pair { nodes: paths, node_count, epochs: seen, .. } = &mut tile.pairs[pair];
        let paths = &paths[..*node_count];
        let out = &mut seen[place];
        let single = sea.lanes.phases() == Phases::Single;
        let plan = &self.plans[pair];
        let transmitters = self.radar.transmitters.len();
        let [tx, rx] = plan.ends(transmitters);
        let (tx_axes, _) = self.axes_of(&instant.emission, tx);
        let (rx_axes, rx_change) = self.axes_of(&instant.emission, rx);
        let bases = [tx, rx].map(|antenna| self.basis_of(&instant.emission, antenna));
        (batch.count, batch.reflects) = (count, 0.0);
        variant.run(Sight {
            slopes,
            strains,
            nodes: paths,
            weights: &instant.weights,
            bases: &bases,
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
        let of_ships = sea.scattering.has_short_waves();
        let beside = |count: usize, bragg: &[Row; 2], out: &mut Row| {
            let places = (&*places_m, *bounds_m);
            sea.scattering.beside_lanes(*variant, places, &instant.poses, (count, bragg), out)
        };
        let beside: Option<Beside<'_>> = of_ships.then_some(&beside);
        if land.count < count {
            self.respond(sea, *variant, kinds, beside, batch);
        }
        if let Some(LandPlan { scattering, .. }) = sea.land.as_ref().filter(|_| land.count > 0) {
            let silent = !sea.has_land(*part);
            batch.respond_as_land(*variant, sea.lanes.axis(), scattering, land, silent);
        }
        out.cosine = batch.cosine;
        if single {
            variant.run(OntoPorts { bases: &bases, view, batch });
        }
        let mut scale = [0.0; LANES];
        let (link, footprint_m2) = (plan.link.in_air(), footprint_m2 as f32);
        variant.run(Scale { link, footprint_m2, view, batch, out: &mut scale });
        if !areas.is_empty() {
            let (rows, weights) = (&areas[..paths.len()], &instant.weights);
            variant.run(Stretched { count, rows, weights, out: &mut scale });
        }
        let widest = scale[..count].iter().fold(0.0, |a: f32, b| a.max(*b));
        out.specular_w = OF_PORTS * (batch.reflects * widest).powi(2);
        self.combine(*variant, plan, (batch, view), &scale, out);
        for (end, antenna, axes, change) in [(0, tx, tx_axes, Axes::ZERO), (1, rx, rx_axes, rx_change)] {
            if !self.antennas[antenna].is_real() {
                self.complex_gain(antenna, axes, change, end, view, out, count);
                // By the gain at each facet, which is not asked for here.
                out.specular_w = if batch.reflects > 0.0 { f32::INFINITY } else { 0.0 };
            }
        }
    }

    /// What the batch returns between the ports of every channel of a pair, scaled.
    pub(in crate::paths) fn combine(
        &self,
        variant: Variant,
        plan: &PairPlan,
        (batch, view): (&Batch, &View),
        scale: &Row,
        out: &mut Epoch,
    ) {
        let errors = [
            self.radar.transmitters[plan.pair.transmitter].antenna.ports,
            self.radar.receivers[plan.pair.receiver].antenna.ports,
        ];
        let Epoch { layers, power, .. } = out;
        power.fill(0.0);
        let mut in_rain = plan.link.lanes_in_rain().map(|rain| (rain, [[0.0; LANES]; CHANNELS_PER_LAYER]));
        for layer in layers {
            let channels = layer.channels().iter().map(|channel| plan.channels[*channel]);
            let mut ports = [[[Complex32::ZERO; 2]; 2]; CHANNELS_PER_LAYER];
            let mut scales = [scale; CHANNELS_PER_LAYER];
            for ((_, tx_port, rx_port), port) in channels.clone().zip(&mut ports) {
                *port = port_products([tx_port, rx_port], errors);
            }
            if let Some((rain, rows)) = &mut in_rain {
                for (((_, tx_port, rx_port), row), own) in channels.zip(rows).zip(&mut scales) {
                    let (ports, count) = ([tx_port, rx_port], batch.count);
                    variant.run(InRain { rain: *rain, ports, view, scale, count, out: row });
                    *own = row;
                }
            }
            let (ports, power) = (&ports[..layer.channels().len()], &mut *power);
            match layer.lanes() {
                2 => variant.run(Combine::<2> { ports, scales, batch, out: layer.lines_mut(), power }),
                4 => variant.run(Combine::<4> { ports, scales, batch, out: layer.lines_mut(), power }),
                _ => variant.run(Combine::<8> { ports, scales, batch, out: layer.lines_mut(), power }),
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
        epoch: &mut Epoch,
        count: usize,
    ) {
        let directions = if end == 0 { &view.incident } else { &view.scattered };
        let sign = if end == 0 { 1.0 } else { -1.0 };
        for (i, delay_s) in view.delay_s.iter().enumerate().take(count) {
            let d = glam::DVec3::from_array([0, 1, 2].map(|c| sign * f64::from(directions[c][i])));
            let axes = axes + change_per_s * f64::from(*delay_s);
            let d = crate::frames::Vector::from_raw(axes.transpose() * d);
            let gain = self.antennas[antenna].field_gain(d);
            let gain = Complex32::new(gain.re as f32, gain.im as f32);
            epoch.scale(i, gain);
        }
    }

    /// Factors of every pulse: gains, shadows, facets that turn away.
    fn factors(&self, patch: &Patch, pair: usize, work: &mut TileWork) {
        let TileWork { variant, gain_rows, timings, shadow_updates, shares, seen, dims, tile, .. } = work;
        let timing = timings.of(tile.tier);
        let points = timing.gain_points();
        let plan = &self.plans[pair];
        let antennas = plan.ends(self.radar.transmitters.len());
        let count = tile.count;
        let supports = tile.supports.chosen();
        let rows = supports.map_or(timing.instants.pulses, |own| own.pulses().len());
        let mut factor = std::mem::take(&mut tile.pairs[pair].factor);
        factor.resize(rows, [0.0; LANES]);
        let ends = shadow_updates.first().map_or(0, |update_weights| update_weights.weights.len());
        for (row, out) in factor.iter_mut().enumerate() {
            let pulse = supports.map_or(row, |own| own.pulses()[row]);
            let (start, weights) = &timing.lagrange[pulse];
            let (rows, weights) = (&gain_rows[pair][*start..], &weights[..points]);
            variant.run(Weigh { count, rows, weights, out });
            let (before, share) = shares[pulse];
            // Where the next update adds nothing it may not be there.
            let next = (before + 1).min(shadow_updates.len().saturating_sub(1));
            for antenna in antennas.into_iter().filter(|antenna| *antenna < ends) {
                if [before, next].iter().any(|update| dims[update * ends + antenna]) {
                    let of = |update: usize| &seen[update * ends + antenna];
                    variant.run(Shadowed { count, from: of(before), to: of(next), share, out });
                }
            }
        }
        tile.pairs[pair].factor = factor;
        if variant.run(Turns { count, epochs: tile.pairs[pair].epochs() }) {
            self.turn_away(patch, pair, work);
        }
    }

    /// Leaves facets out of the pulses at which they are turned away from an antenna.
    fn turn_away(&self, patch: &Patch, pair: usize, work: &mut TileWork) {
        let TileWork {
            variant, facet_surface, nodes, timings, turning, slopes, keys, places_m, tile, ..
        } = work;
        let (timing, earth) = (timings.of(tile.tier), self.frame.earth());
        let supports = tile.supports.chosen();
        let (number, count, interval_s) = (pair, tile.count, tile.interval_s);
        let turned = Turned { pair: &tile.pairs[pair], number, timing, count, interval_s, slopes };
        turning.find(&turned, patch, *variant);
        let mut factor = std::mem::take(&mut tile.pairs[pair].factor);
        let turned = Turned { pair: &tile.pairs[pair], number, timing, count, interval_s, slopes };
        let place = |lane: usize| {
            let fall = earth.drop_slope(places_m[0][lane], places_m[1][lane]);
            (keys[lane], fall.map(|slope| slope as f32))
        };
        for (row, out) in factor.iter_mut().enumerate() {
            let pulse = supports.map_or(row, |own| own.pulses()[row]);
            turning.turn(&turned, pulse, *variant, out);
            if turning.is_in_doubt() {
                let elapsed_s = self.radar.emissions.elapsed_s(timing.instants.first + pulse as u64);
                let at = (&turned, pulse, &tile.slow);
                turning.decide(at, elapsed_s, (facet_surface, nodes, patch), place, out);
            }
        }
        tile.pairs[pair].factor = factor;
    }
}
