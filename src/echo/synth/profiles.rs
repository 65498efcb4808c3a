//! Tiles that were evaluated at their supports alone: profiles over delay, and pulses from these.
//!
//! A tile is spread at each support on a row of cells of its own, which begins at its first cell there, and
//! turned back by the phase of its middle `theta`. A pulse `t` is the sum of the rows of its supports `t_k`,
//! cell by cell, turned by its own phase,
//!
//! `g_t[j] += e^{j theta(t)} sum_k w_k e^{-j theta(t_k)} row_k[j]` ,
//!
//! with the weights of [`paths::block::supports`](crate::paths::block::Supports). An emission that several
//! windows receive is summed once, and added to the grids of each. Rows and grids are cells of one and the
//! same delay axis, so windows must lie whole cells apart ([`Synth::windows_align`]). Every frequency of a
//! row changes as slowly as it does in the echo, so what the weights lack of the power is all that is lost.
//! What turns the carrier from emission to emission ([`Frame::carrier_turns`]) comes last: that may be fast.

use std::ops::Range;

use num_complex::Complex64;

use super::frame::{Frame, Receives};
use super::grid::{FAR_CELLS, Grids, Lined};
use super::lanes::{LaneWork, Rows, TOGETHER};
use super::scalar::Scalar;
use super::spread::{DelayPolynomials, Emitted, Job};
use super::{Layer, Synth};
use crate::cpu::Task;
use crate::geometry::lanes::LANES;
use crate::paths::block::{Pair, Piece, Supports, TAPS, TURNED_LANES, Tile};
use crate::radar::phasor::phasor;

/// Cells that the first cells of the rows of a pulse may lie apart where they are summed at once.
const APART: usize = 4;
/// What a row may be longer than the tile at its nodes, cells: waves move facets between these.
const MORE_CELLS: f64 = 4.0;
/// Windows that are so near to whole cells apart are.
const WHOLE_CELLS: f64 = 1e-6;

/// The rows of a tile: empty cells, those that hold it, empty ones again, and those that nobody reads.
#[derive(Clone, Copy)]
struct Shape {
    /// Empty cells on either side.
    margin: usize,
    /// Places that a first cell may have.
    places: usize,
    /// Cells that hold the tile: those, and what a path is spread over.
    cells: usize,
    /// Cells from row to row.
    stride: usize,
    /// When the window opens that places count from, s.
    reference_s: f64,
    /// First cells by that window that any window receives, the first and the last.
    reach: [i32; 2],
}

impl Synth<f32> {
    /// Whether windows lie whole cells apart, after each of the emissions that they receive: only then may
    /// tiles be evaluated at supports alone. `receives` is that of a [`Frame`].
    pub fn windows_align(&self, windows_s: &[Vec<f64>], receives: &[Receives]) -> bool {
        windows_s.iter().all(|of| match receives {
            [] => self.lie_whole_cells_apart(of.iter().copied()),
            _ => self.lie_whole_cells_apart(receives.iter().filter_map(|own| own.opens_s(of))),
        })
    }

    fn lie_whole_cells_apart(&self, mut starts_s: impl Iterator<Item = f64>) -> bool {
        let first_s = starts_s.next().unwrap_or_default();
        starts_s.all(|start_s| {
            let cells = (start_s - first_s) * self.cells_per_s;
            (cells - cells.round()).abs() < WHOLE_CELLS && cells.abs() < FAR_CELLS
        })
    }

    /// Spreads a tile that was evaluated at its supports on the grids of its block.
    pub(super) fn spread_profiles(
        &self,
        tile: &Tile,
        pair: usize,
        supports: &Supports,
        frame: &Frame,
        work: &mut LaneWork,
        grids: &mut Grids<f32>,
    ) {
        let emissions = 0..tile.instants.pulses;
        let windows_s = self.windows_of(frame, pair);
        let reference_s = frame.reference_s(windows_s, emissions.clone());
        let Rows { shifts, turns, .. } = &mut work.rows;
        shifts.clear();
        shifts.extend(frame.received(emissions.clone()).map(|own| {
            let start_s = own.opens_s(windows_s).unwrap_or(reference_s);
            ((reference_s - start_s) * self.cells_per_s).round() as i32
        }));
        tile.middle_turns(pair, self.carrier_hz, turns);
        let shape = self.shape_of_rows(tile, pair, reference_s, &work.rows.shifts);
        let own = self.layers.iter().enumerate().filter(|(_, layer)| layer.pair == pair);
        work.rows.cells.resize_with(self.layers.len(), Lined::default);
        for (index, layer) in own.clone() {
            work.rows.cells[index].reset(supports.pulses().len() * shape.stride * layer.lanes);
        }
        work.rows.first.clear();
        self.fill_rows(tile, pair, (supports, shape), frame, work);
        for (index, layer) in own {
            self.turn_rows(index, layer, (supports, shape), &mut work.rows);
            let mut before = 0;
            for emission in emissions.clone() {
                let received = frame.received(emission..emission + 1);
                let at = before;
                before += received.len();
                let fills = frame.groups.get(emission).is_none_or(|group| *group == layer.group);
                if !fills || received.len() == 0 {
                    continue;
                }
                let of = (supports, shape, emission);
                let Some(least) = self.sum_rows((index, layer), of, &mut work.rows) else { continue };
                let carrier = frame.turns_at(tile.slow.at(emission));
                let apart = frame.emission_turns.get(emission).copied().unwrap_or(0.0);
                let by = phasor(work.rows.turns[emission] + carrier + apart);
                let known = received.enumerate().filter(|(_, own)| own.pulse < frame.pulses());
                for (n, own) in known {
                    let begins = least + work.rows.shifts[at + n];
                    let from = self.shape.offset(index);
                    let cells = &mut grids.of_pulse(own.pulse)[from..][..self.shape.layer_len(index)];
                    self.add_sum(layer.lanes, begins, by, &work.rows.sum, cells);
                }
            }
        }
    }

    /// Rows as long as the tile at its nodes, and a little more.
    fn shape_of_rows(&self, tile: &Tile, pair: usize, reference_s: f64, shifts: &[i32]) -> Shape {
        let extent_s = tile.pairs[pair].extent_s(tile.count);
        let places = (extent_s * self.cells_per_s + MORE_CELLS).ceil() as usize;
        // Windows may reach farther together than one of them.
        let [least, most] = [shifts.iter().min(), shifts.iter().max()].map(|n| n.copied().unwrap_or(0));
        let places = places.min(self.shape.outside() + (most - least) as usize);
        let (width, margin) = (self.settings.width, APART);
        let cells = places + width;
        let stride = (cells + 2 * margin + width).next_multiple_of(2);
        Shape { margin, places, cells, stride, reference_s, reach: [-most, self.last_cell - least] }
    }

    /// Spreads the tile at every support on its row.
    fn fill_rows(
        &self,
        tile: &Tile,
        pair: usize,
        (supports, shape): (&Supports, Shape),
        frame: &Frame,
        work: &mut LaneWork,
    ) {
        let node_count = tile.instants.node_count;
        self.fill_moments(tile, pair, frame.mean_hz[pair], work);
        let mut at = None;
        for interval in 0..node_count.saturating_sub(1).max(1) {
            for Piece { pulses, epochs, middle } in tile.instants.pieces(interval) {
                let own = [pulses.start, pulses.end]
                    .map(|end| supports.pulses().partition_point(|pulse| *pulse < end));
                if own[0] == own[1] {
                    continue;
                }
                if at != Some((epochs.start, middle)) {
                    at = Some((epochs.start, middle));
                    self.amplitudes_through(tile, pair, epochs, tile.slow.at(middle), work);
                }
                let parts = (own[1] - own[0]).div_ceil(TOGETHER);
                for part in 0..parts {
                    let [a, b] = [part, part + 1].map(|n| own[0] + n * (own[1] - own[0]) / parts);
                    let of = (interval, middle, a..b);
                    self.fill_part_of_rows(tile, pair, of, (supports, shape), frame, work);
                }
            }
        }
    }

    fn fill_part_of_rows(
        &self,
        tile: &Tile,
        pair: usize,
        (interval, of_amplitudes, own): (usize, usize, Range<usize>),
        (supports, shape): (&Supports, Shape),
        frame: &Frame,
        work: &mut LaneWork,
    ) {
        let (slow, uneven) = (&tile.slow, !tile.slow.uneven().is_empty());
        let middle = slow.at(supports.pulses()[own.start + own.len() / 2]);
        let (mean_hz, polynomials) = (frame.mean_hz[pair], &mut work.polynomials);
        self.polynomials_between(
            (tile, pair, interval),
            (middle, shape.reference_s),
            mean_hz,
            [0.0; 2],
            polynomials,
        );
        let LaneWork { polynomials, amplitude, emitted, powers: in_use, rows, .. } = work;
        emitted.clear();
        for row in own.clone() {
            let at = slow.at(supports.pulses()[row]);
            let time = at - middle;
            let least = self.variant.run(FirstCell { polynomials, time: time as f32, reach: shape.reach });
            rows.first.push(least);
            let shift = (-least.unwrap_or(0), 0.0);
            emitted.push(Emitted::new(shift, [time, at - slow.at(of_amplitudes)], (row, row), uneven));
        }
        let Pair { factor, turned, .. } = &tile.pairs[pair];
        for (index, layer) in self.layers.iter().enumerate().filter(|(_, layer)| layer.pair == pair) {
            let powers = amplitude[index].each_ref().map(|power| power.as_slice());
            let stride = shape.stride * layer.lanes;
            let job = Job {
                polynomials,
                amplitude: &powers[..*in_use],
                pulses: emitted,
                first: own.start,
                factors: factor.as_flattened(),
                turned: turned.as_flattened().as_flattened(),
                factor_stride: LANES,
                turned_stride: TURNED_LANES,
                coefficients: &self.coefficients,
                last_cell: shape.places as i32 - 1,
                exact: None,
                outside: (shape.cells + shape.margin) as i32,
                stride,
                offset: shape.margin * layer.lanes,
            };
            let cells = &mut rows.cells[index].as_mut_slice()[own.start * stride..own.end * stride];
            (self.bodies[index])(&job, cells);
        }
    }

    /// Turns rows back by the phase of the middle of the tile.
    fn turn_rows(&self, index: usize, layer: &Layer, (supports, shape): (&Supports, Shape), rows: &mut Rows) {
        let stride = shape.stride * layer.lanes;
        let cells = rows.cells[index].as_mut_slice();
        for (row, pulse) in cells.chunks_exact_mut(stride).zip(supports.pulses()) {
            let by = phasor(-rows.turns[*pulse]);
            let row = &mut row[shape.margin * layer.lanes..][..shape.cells * layer.lanes];
            self.variant.run(Turned { row, by: [by.re as f32, by.im as f32] });
        }
    }

    /// The sum of the rows of a layer at an emission, without its phase; returns its first cell by the window
    /// that places count from.
    fn sum_rows(
        &self,
        (index, layer): (usize, &Layer),
        (supports, shape, emission): (&Supports, Shape, usize),
        rows: &mut Rows,
    ) -> Option<i32> {
        let (from, weights) = supports.taps(emission);
        let firsts = &rows.first[from..from + TAPS];
        let known = firsts.iter().flatten();
        let (Some(&least), Some(&most)) = (known.clone().min(), known.max()) else { return None };
        let (lanes, stride) = (layer.lanes, shape.stride * layer.lanes);
        let apart = (most - least) as usize;
        let length = (shape.cells + apart) * lanes;
        let held = rows.cells[index].as_slice();
        if apart <= APART && firsts.iter().all(Option::is_some) {
            rows.sum.resize(length, 0.0);
            let row = |n: usize| {
                let after = firsts[n].map_or(0, |first| (first - least) as usize);
                &held[(from + n) * stride + (shape.margin - after) * lanes..][..length]
            };
            let to = rows.sum.as_mut_slice();
            self.variant.run(Summed { rows: std::array::from_fn(row), weights, to });
        } else {
            rows.sum.clear();
            rows.sum.resize(length, 0.0);
            for (n, (first, weight)) in firsts.iter().zip(weights).enumerate() {
                let Some(first) = first else { continue };
                let row = &held[(from + n) * stride + shape.margin * lanes..][..shape.cells * lanes];
                let to = &mut rows.sum[(first - least) as usize * lanes..][..shape.cells * lanes];
                self.variant.run(Weighted { row, weight: *weight, to });
            }
        }
        Some(least)
    }

    /// Adds a sum, turned, to the cells of a layer from a cell on, as much as lies on its grid.
    fn add_sum(&self, lanes: usize, begins: i32, by: Complex64, sum: &[f32], cells: &mut [f32]) {
        let skip = (-begins).max(0) as usize * lanes;
        let to = begins.max(0) as usize * lanes;
        let room = (self.shape.outside() * lanes).saturating_sub(to);
        let sum = sum.get(skip..).unwrap_or_default();
        let sum = &sum[..sum.len().min(room)];
        let cells = &mut cells[to.min(self.shape.outside() * lanes)..];
        self.variant.run(Added { sum, by: [by.re as f32, by.im as f32], cells });
    }
}

/// The least first cell that is within reach of any window.
struct FirstCell<'a> {
    polynomials: &'a DelayPolynomials<f32>,
    time: f32,
    reach: [i32; 2],
}

impl Task for FirstCell<'_> {
    type Output = Option<i32>;

    #[inline(always)]
    fn run(self) -> Option<i32> {
        let Self { polynomials: DelayPolynomials { base, place, .. }, time, reach: [from, to] } = self;
        let [c0, c1, c2, c3] = place;
        let lanes = base.iter().zip(c0).zip(c1).zip(c2).zip(c3);
        let mut least = i32::MAX;
        for ((((base, c0), c1), c2), c3) in lanes {
            // One cell before, so that rounding in another order does not matter.
            let place = ((c3 * time + c2) * time + c1) * time + c0;
            let first = base.wrapping_add(f32::nearest(place).0 - 1);
            let within = first >= from - 2 && first <= to;
            least = if within && first < least { first } else { least };
        }
        (least < i32::MAX).then_some(least)
    }
}

/// The weighted sum of rows. What turns it is a task of its own: this loop stays whole vectors, whatever they
/// are of.
struct Summed<'a> {
    rows: [&'a [f32]; TAPS],
    weights: &'a [f32; TAPS],
    to: &'a mut [f32],
}

impl Task for Summed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { rows: [r0, r1, r2, r3, r4, r5, r6, r7, r8, r9], weights: w, to } = self;
        let n = to.len();
        let (r0, r1, r2, r3, r4) = (&r0[..n], &r1[..n], &r2[..n], &r3[..n], &r4[..n]);
        let (r5, r6, r7, r8, r9) = (&r5[..n], &r6[..n], &r7[..n], &r8[..n], &r9[..n]);
        for i in 0..n {
            let before = w[0] * r0[i] + w[1] * r1[i] + w[2] * r2[i] + w[3] * r3[i] + w[4] * r4[i];
            let after = w[5] * r5[i] + w[6] * r6[i] + w[7] * r7[i] + w[8] * r8[i] + w[9] * r9[i];
            to[i] = before + after;
        }
    }
}

/// A row times a phasor.
struct Turned<'a> {
    row: &'a mut [f32],
    by: [f32; 2],
}

impl Task for Turned<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [cos, sin] = self.by;
        for [re, im] in self.row.as_chunks_mut::<2>().0 {
            (*re, *im) = (*re * cos - *im * sin, *re * sin + *im * cos);
        }
    }
}

/// Adds a row times its weight.
struct Weighted<'a> {
    row: &'a [f32],
    weight: f32,
    to: &'a mut [f32],
}

impl Task for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (to, own) in self.to.iter_mut().zip(self.row) {
            *to += self.weight * own;
        }
    }
}

/// Adds a sum, turned, to the cells of a pulse.
struct Added<'a> {
    sum: &'a [f32],
    by: [f32; 2],
    cells: &'a mut [f32],
}

impl Task for Added<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [cos, sin] = self.by;
        let both = self.cells.as_chunks_mut::<2>().0.iter_mut().zip(self.sum.as_chunks::<2>().0);
        for ([re, im], [own_re, own_im]) in both {
            *re += own_re * cos - own_im * sin;
            *im += own_re * sin + own_im * cos;
        }
    }
}
