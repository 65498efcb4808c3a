//! Tiles of scatterer paths side by side, spread without being listed.
//!
//! A [`Tile`] has delays and rates of its paths at the nodes of a block, amplitudes at its scattering epochs,
//! and a factor for every pulse. Between two nodes phase and place are Hermite cubics of
//! `s = (t - t_0)/(t_1 - t_0)`,
//!
//! `f = f_0 + s d_0 + s^2 (3 D - 2 d_0 - d_1) + s^3 (d_0 + d_1 - 2 D)`, `D = f_1 - f_0`,
//! `d = f' (t_1 - t_0)`,
//!
//! in f64, held as in [`block`](super::block); amplitudes are one polynomial through four scattering epochs.
//! What Doppler off the mean adds to phase and place is linear between nodes. It is the same echo as that of
//! [`Synth::fill`], but for these polynomials.
//!
//! **Error** of a delay between nodes `T` apart: `max |tau''''| T^4 / 384`; of amplitudes, as there.

use std::ops::Range;

use super::block::{MAX_NODES, Through};
use super::frame::Frame;
use super::grid::{FAR_CELLS, Grids, Lined};
use super::spread::{DelayPolynomials, Emitted, Job, TICKS};
use super::{Synth, of_group};
use crate::cpu::Task;
use crate::geometry::lanes::{LANES, Row, WideRow, lanes_for};
use crate::paths::block::{Pair, Piece, TURNED_LANES, Tile};

/// Most emissions that are spread with one set of polynomials: their grids stay in the cache.
pub(super) const TOGETHER: usize = 64;

/// Room to work; one per thread.
#[derive(Debug, Default)]
pub struct LaneWork {
    pub(super) polynomials: DelayPolynomials<f32>,
    /// `[layer][epoch]`: amplitudes of layers of moments, `[path][lane]`.
    moments: Vec<Vec<Lined<f32>>>,
    /// `[layer][power]`, each `[path][lane]`.
    pub(super) amplitude: Vec<[Lined<f32>; MAX_NODES]>,
    pub(super) emitted: Vec<Emitted<f32>>,
    /// Powers of the amplitudes at hand, 2 or 4.
    pub(super) powers: usize,
    /// Of a tile that was evaluated at supports alone.
    pub(super) rows: Rows,
}

/// Room for the rows of a tile.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// `[layer]`: `[support][cell][lane]`.
    pub cells: Vec<Lined<f32>>,
    /// First cell of each row, by the window that places count from; none of a row that is empty.
    pub first: Vec<Option<i32>>,
    /// Phase of the middle of the tile at every emission, turns.
    pub turns: Vec<f64>,
    /// Whole cells from that window to those that receive emissions, in their order.
    pub shifts: Vec<i32>,
    /// The rows of an emission.
    pub sum: Vec<f32>,
}

/// A quantity at both ends of an interval.
#[derive(Clone, Copy)]
struct Ends<'a> {
    delay_s: [&'a WideRow; 2],
    delay_rate: [&'a WideRow; 2],
}

impl Synth<f32> {
    /// Makes room for any tile of a block of so many pulses with so many scattering epochs: later ones may
    /// have more of everything than the first.
    pub fn make_room(&self, epochs: usize, pulses: usize, work: &mut LaneWork) {
        fn reserve<T>(column: &mut Vec<T>, room: usize) {
            column.reserve(room.saturating_sub(column.len()));
        }
        let LaneWork { polynomials, moments, amplitude, emitted, rows, .. } = work;
        reserve(&mut rows.shifts, pulses);
        reserve(&mut rows.turns, pulses);
        reserve(&mut rows.first, pulses);
        moments.resize_with(self.layers.len(), Vec::new);
        amplitude.resize_with(self.layers.len(), Default::default);
        for ((layer, moments), powers) in self.layers.iter().zip(moments).zip(amplitude) {
            moments.resize_with(if layer.moment { epochs.max(moments.len()) } else { 0 }, Lined::default);
            moments.iter_mut().chain(powers).for_each(|column| column.fit(LANES * layer.lanes));
        }
        polynomials.phase.iter_mut().for_each(|column| reserve(column, LANES));
        polynomials.place.iter_mut().for_each(|column| reserve(column, LANES));
        reserve(&mut polynomials.phase_cubic, LANES);
        reserve(&mut polynomials.base, LANES);
        reserve(emitted, pulses);
    }

    /// Spreads a tile on the grids of its block. The work has room for it ([`Synth::make_room`]).
    pub fn spread_tile(&self, tile: &Tile, frame: &Frame, work: &mut LaneWork, grids: &mut Grids<f32>) {
        for pair in 0..tile.pairs.len().min(self.pairs) {
            self.spread_pair(tile, pair, frame, work, grids);
        }
    }

    fn spread_pair(
        &self,
        tile: &Tile,
        pair: usize,
        frame: &Frame,
        work: &mut LaneWork,
        grids: &mut Grids<f32>,
    ) {
        let node_count = tile.instants.node_count;
        if node_count == 0 || tile.count == 0 {
            return;
        }
        if let Some(supports) = tile.supports() {
            return self.spread_profiles(tile, pair, supports, frame, work, grids);
        }
        self.fill_moments(tile, pair, frame.mean_hz[pair], work);
        let mut at = None;
        for interval in 0..node_count.saturating_sub(1).max(1) {
            for Piece { pulses: Range { start: from, end: to }, epochs, middle } in
                tile.instants.pieces(interval).filter(|piece| !piece.pulses.is_empty())
            {
                if at != Some((epochs.start, middle)) {
                    at = Some((epochs.start, middle));
                    self.amplitudes_through(tile, pair, epochs, tile.slow.at(middle), work);
                }
                // As many together as stay in the cache with what they are spread on.
                let parts = (to - from).div_ceil(TOGETHER);
                for part in 0..parts {
                    let [a, b] = [part, part + 1].map(|n| from + n * (to - from) / parts);
                    self.spread_interval(tile, pair, (interval, middle), a..b, frame, work, grids);
                }
            }
        }
    }

    /// Amplitudes times Doppler off the mean over the length of a pulse, at every scattering epoch: for the
    /// layers of [second terms](super::doppler::Doppler::has_moments).
    pub(super) fn fill_moments(&self, tile: &Tile, pair: usize, mean_hz: f64, work: &mut LaneWork) {
        let of_pair = &tile.pairs[pair];
        for (layer, moments) in self.layers.iter().zip(&mut work.moments) {
            if layer.pair != pair || !layer.moment {
                continue;
            }
            for ((epoch, pulse), out) in of_pair.epochs().iter().zip(tile.instants.epochs).zip(moments) {
                // From the node before the scattering epoch, or at it.
                let nodes = &tile.instants.nodes[..tile.instants.node_count];
                let node = nodes.iter().rposition(|node| *node <= pulse).unwrap_or(0);
                let mut scale = [0.0; LANES];
                for (scale, rate) in scale.iter_mut().zip(&of_pair.nodes()[node].paths.delay_rate) {
                    *scale = ((self.carrier_hz * rate - mean_hz) * self.waveform.duration_s()) as f32;
                }
                let (scale, amplitude) = (&scale, epoch.layers[layer.of_pair].of_first(tile.count));
                out.fit(amplitude.len());
                let out = out.as_mut_slice();
                match layer.lanes {
                    2 => self.variant.run(Scaled::<2> { amplitude, scale, out }),
                    4 => self.variant.run(Scaled::<4> { amplitude, scale, out }),
                    _ => self.variant.run(Scaled::<8> { amplitude, scale, out }),
                }
            }
        }
    }

    /// Polynomials of the amplitudes through some scattering epochs.
    pub(super) fn amplitudes_through(
        &self,
        tile: &Tile,
        pair: usize,
        epochs: Range<usize>,
        middle: f64,
        work: &mut LaneWork,
    ) {
        let mut places = [0.0; MAX_NODES];
        for (place, pulse) in places.iter_mut().zip(&tile.instants.epochs[epochs.clone()]) {
            *place = tile.slow.at(*pulse) - middle;
        }
        let through = Through::new(&places[..epochs.len()]);
        work.powers = if epochs.len() <= 2 { 2 } else { MAX_NODES };
        let basis = through.basis.map(|row| row.map(|b| b as f32));
        for ((layer, moments), held) in self.layers.iter().zip(&work.moments).zip(&mut work.amplitude) {
            if layer.pair != pair {
                continue;
            }
            let mut seen: [&[f32]; MAX_NODES] = [&[]; MAX_NODES];
            for (seen, epoch) in seen.iter_mut().zip(epochs.clone()) {
                *seen = if layer.moment {
                    moments[epoch].as_slice()
                } else {
                    tile.pairs[pair].epochs()[epoch].layers[layer.of_pair].of_first(tile.count)
                };
            }
            for (power, weights) in held.iter_mut().zip(&basis).take(work.powers) {
                power.fit(tile.count * layer.lanes);
                self.variant.run(Weighted { epochs: &seen, weights, out: power.as_mut_slice() });
            }
        }
    }

    /// Phase and place of a tile from a node to the next, counted from `middle` (intervals), by a window that
    /// opens at `reference_s`; a carrier turns them by so much there, and from one emission to the next.
    pub(super) fn polynomials_between(
        &self,
        (tile, pair, interval): (&Tile, usize, usize),
        (middle, reference_s): (f64, f64),
        mean_hz: f64,
        carrier_turns: [f64; 2],
        polynomials: &mut DelayPolynomials<f32>,
    ) {
        let (slow, uneven) = (&tile.slow, !tile.slow.uneven().is_empty());
        let nodes = tile.pairs[pair].nodes();
        let [first, second] = [interval, (interval + 1).min(nodes.len() - 1)].map(|node| &nodes[node].paths);
        let (count, at_node) = (tile.count, tile.instants.nodes);
        polynomials.phase.iter_mut().for_each(|p| p.resize(count, 0));
        polynomials.phase_cubic.resize(count, 0.0);
        polynomials.uneven.iter_mut().for_each(|p| p.resize(if uneven { count } else { 0 }, 0.0));
        polynomials.base.resize(count, 0);
        polynomials.place.iter_mut().for_each(|p| p.resize(count, 0.0));
        let first_node = slow.at(at_node[interval]);
        let length = if nodes.len() == 1 { 0.0 } else { slow.at(at_node[interval + 1]) - first_node };
        let correction = self.correction();
        let [shifted, moved] = correction.delays();
        let task = Polynomials {
            ends: Ends {
                delay_s: [&first.delay_s, &second.delay_s],
                delay_rate: [&first.delay_rate, &second.delay_rate],
            },
            carrier_hz: self.carrier_hz,
            mean_hz,
            about_hz: correction.about_hz(mean_hz),
            middle_s: correction.middle_s,
            shifted,
            moved,
            before_s: self.lead_s - reference_s,
            cells_per_s: self.cells_per_s,
            interval_s: tile.interval_s,
            length,
            middle: middle - first_node,
            carrier_turns,
            count,
            polynomials,
        };
        self.variant.run(task);
    }

    /// Spreads a tile on the grids of pulses from one node to the next; powers of amplitudes count from a
    /// pulse.
    fn spread_interval(
        &self,
        tile: &Tile,
        pair: usize,
        (interval, of_amplitudes): (usize, usize),
        pulses: Range<usize>,
        frame: &Frame,
        work: &mut LaneWork,
        grids: &mut Grids<f32>,
    ) {
        let LaneWork { polynomials, amplitude, emitted, powers: in_use, .. } = work;
        let slow = &tile.slow;
        let middle = slow.at(pulses.start + pulses.len() / 2);
        let middles = [middle, slow.at(of_amplitudes)];
        let groups = frame.groups.get(pulses.clone()).unwrap_or_default();
        let time = |row: usize| middles.map(|middle| slow.at(pulses.start + row) - middle);
        let reference_s =
            self.fill_emitted((frame, self.windows_of(frame, pair)), pulses.clone(), time, emitted);
        let (mean_hz, carrier_turns) =
            (frame.mean_hz[pair], [frame.turns_at(middle), frame.carrier_turns[1]]);
        let of = (tile, pair, interval);
        self.polynomials_between(of, (middle, reference_s), mean_hz, carrier_turns, polynomials);
        let Pair { factor, turned, .. } = &tile.pairs[pair];
        let stride = grids.shape.pulse_len();
        for (index, layer) in self.layers.iter().enumerate().filter(|(_, layer)| layer.pair == pair) {
            let own = of_group(emitted, groups, layer.group);
            if own.is_empty() {
                continue;
            }
            let powers = amplitude[index].each_ref().map(|power| power.as_slice());
            let job = Job {
                polynomials,
                amplitude: &powers[..*in_use],
                pulses: own,
                first: 0,
                factors: factor[pulses.clone()].as_flattened(),
                turned: turned.get(pulses.clone()).unwrap_or_default().as_flattened().as_flattened(),
                factor_stride: LANES,
                turned_stride: TURNED_LANES,
                coefficients: &self.coefficients,
                last_cell: self.last_cell,
                exact: self.exact,
                outside: self.shape.outside() as i32,
                stride,
                offset: self.shape.offset(index),
            };
            (self.bodies[index])(&job, grids.all());
        }
    }
}

/// Amplitudes of `C` lanes for each path, times what each path has.
struct Scaled<'a, const C: usize> {
    amplitude: &'a [f32],
    scale: &'a Row,
    out: &'a mut [f32],
}

impl<const C: usize> Task for Scaled<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { amplitude, scale, out } = self;
        let (from, to) = (amplitude.as_chunks::<C>().0, out.as_chunks_mut::<C>().0);
        for ((to, from), scale) in to.iter_mut().zip(from).zip(scale) {
            for k in 0..C {
                to[k] = from[k] * scale;
            }
        }
    }
}

/// A sum of scattering epochs, each with its weight.
struct Weighted<'a> {
    epochs: &'a [&'a [f32]; MAX_NODES],
    weights: &'a [f32; MAX_NODES],
    out: &'a mut [f32],
}

impl Task for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { epochs: [a, b, c, d], weights: w, out } = self;
        let n = out.len();
        match (b.len() == n, c.len() == n, d.len() == n) {
            (true, true, true) => {
                for ((((out, a), b), c), d) in out.iter_mut().zip(*a).zip(*b).zip(*c).zip(*d) {
                    *out = w[0] * a + w[1] * b + w[2] * c + w[3] * d;
                }
            }
            (true, true, _) => {
                for (((out, a), b), c) in out.iter_mut().zip(*a).zip(*b).zip(*c) {
                    *out = w[0] * a + w[1] * b + w[2] * c;
                }
            }
            (true, ..) => {
                for ((out, a), b) in out.iter_mut().zip(*a).zip(*b) {
                    *out = w[0] * a + w[1] * b;
                }
            }
            _ => {
                for (out, a) in out.iter_mut().zip(*a) {
                    *out = w[0] * a;
                }
            }
        }
    }
}

/// Phase and place between two nodes.
struct Polynomials<'a> {
    ends: Ends<'a>,
    carrier_hz: f64,
    mean_hz: f64,
    /// The same from the middle of the sweep on.
    about_hz: f64,
    middle_s: f64,
    /// Delay per Hz of Doppler off the mean, s: that which replaces Doppler, and all of it.
    shifted: f64,
    moved: f64,
    /// From the window's start to cell 0, s.
    before_s: f64,
    cells_per_s: f64,
    interval_s: f64,
    /// Intervals between the nodes; 0 for a single one.
    length: f64,
    /// Intervals from the first node to where `m` counts from.
    middle: f64,
    /// Of a carrier apart from the receiver's: where `m` counts from, and from one interval to the next.
    carrier_turns: [f64; 2],
    count: usize,
    polynomials: &'a mut DelayPolynomials<f32>,
}

/// Brings an f64 below `2^51` to the nearest integer, and its low bits are that integer.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// The fraction of a phase as `2^-32` turns.
#[inline(always)]
fn turns(value: f64) -> u32 {
    let fraction = value - ((value + TO_INTEGER) - TO_INTEGER);
    (fraction * 4_294_967_296.0 + TO_INTEGER).to_bits() as u32
}

impl Task for Polynomials<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ends, carrier_hz, mean_hz, about_hz, middle_s, shifted, moved, .. } = self;
        let Self { interval_s, length, middle, carrier_turns, count, polynomials, .. } = self;
        let [d0, d1] = ends.delay_s;
        let [r0, r1] = ends.delay_rate;
        let span_s = length * interval_s;
        // From powers of s to powers of m: s = (m + middle) / length.
        let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
        let uneven = !polynomials.uneven[0].is_empty();
        let per_tick = if uneven { 1.0 / TICKS } else { 1.0 };
        let (mut phase, mut cubic) = ([[0u32; LANES]; 3], [0.0f32; LANES]);
        let mut powers = [[0.0f32; LANES]; 2];
        let (mut base, mut place) = ([0i32; LANES], [[0.0f32; LANES]; 4]);
        for i in 0..lanes_for(count) {
            let (mut delays, mut extra) = ([0.0; 2], [0.0; 2]);
            for (end, rate) in [r0[i], r1[i]].into_iter().enumerate() {
                let nu = carrier_hz * rate - mean_hz;
                delays[end] = nu * moved;
                extra[end] = -nu * middle_s - (nu * shifted) * (0.5 * nu + about_hz);
            }
            let difference = d1[i] - d0[i];
            let (v0, v1) = if length > 0.0 {
                (r0[i] * span_s, r1[i] * span_s)
            } else {
                // One node: the rate is all there is, per pulse.
                (r0[i] * interval_s, r0[i] * interval_s)
            };
            let (a2, a3) = if length > 0.0 {
                (3.0 * difference - 2.0 * v0 - v1, v0 + v1 - 2.0 * difference)
            } else {
                (0.0, 0.0)
            };
            let scale = if length > 0.0 { inverse } else { 1.0 };
            // Delay in powers of m, less its value at the first node.
            let (c1, c2, c3) = (v0 * scale, a2 * scale * scale, a3 * scale * scale * scale);
            let b0 = middle * (c1 + middle * (c2 + middle * c3));
            let b1 = c1 + middle * (2.0 * c2 + 3.0 * middle * c3);
            let b2 = c2 + 3.0 * middle * c3;
            let more_turns = (extra[1] - extra[0]) * inverse;
            let more_s = (delays[1] - delays[0]) * inverse;
            let constant = extra[0] + middle * more_turns - carrier_hz * b0 + carrier_turns[0];
            let linear = more_turns - carrier_hz * b1 + carrier_turns[1];
            phase[0][i] = turns(constant - carrier_hz * d0[i]);
            phase[1][i] = turns(linear * per_tick);
            phase[2][i] = turns(-carrier_hz * b2);
            if uneven {
                powers[0][i] = linear as f32;
                powers[1][i] = (-carrier_hz * b2) as f32;
            }
            cubic[i] = (-carrier_hz * c3) as f32;
            let at_s = d0[i] + b0 + delays[0] + middle * more_s + self.before_s;
            let cells = at_s * self.cells_per_s + 0.5;
            let near = cells.abs() < FAR_CELLS;
            let cells = if near { cells } else { 0.0 };
            let shifted = cells + TO_INTEGER;
            let held = shifted - TO_INTEGER;
            base[i] = if near { shifted.to_bits() as i32 } else { -1_000_000_000 };
            place[0][i] = (cells - held) as f32;
            place[1][i] = ((b1 + more_s) * self.cells_per_s) as f32;
            place[2][i] = (b2 * self.cells_per_s) as f32;
            place[3][i] = (c3 * self.cells_per_s) as f32;
        }
        for (to, from) in polynomials.phase.iter_mut().zip(&phase) {
            to.copy_from_slice(&from[..count]);
        }
        if uneven {
            for (to, from) in polynomials.uneven.iter_mut().zip(&powers) {
                to.copy_from_slice(&from[..count]);
            }
        }
        polynomials.phase_cubic.copy_from_slice(&cubic[..count]);
        polynomials.base.copy_from_slice(&base[..count]);
        for (to, from) in polynomials.place.iter_mut().zip(&place) {
            to.copy_from_slice(&from[..count]);
        }
    }
}
