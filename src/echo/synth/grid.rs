//! Delay grids of a block of pulses.
//!
//! `[pulse][layer][cell][lane]`: a **layer** is what is spread with one set of places and weights, up to four
//! channels of one pair; a **lane** is the real or imaginary part of one channel. Cells `0 .. period` are the
//! grid, the next `width` belong to its beginning (a scatterer path at the end spreads over the edge
//! without a branch), and `width` more take what lies outside the window and is never read.
//!
//! Pulses do not share cells, so threads may each take a share of the pulses: no sum depends on how many
//! there are.

use num_complex::Complex;

use super::scalar::Scalar;

/// Whole cells are held within this, so that sums of two do not overflow; no window is as long.
pub(super) const FAR_CELLS: f64 = 5e8;

/// Bytes of a cache line.
const LINE: usize = 64;

/// Numbers that start on a cache line.
#[derive(Debug, Default)]
pub(super) struct Lined<T> {
    raw: Vec<T>,
    start: usize,
    len: usize,
}

impl<T: Copy + Default> Lined<T> {
    /// Makes it `len` long, every number zero. Keeps its memory where that suffices.
    pub fn reset(&mut self, len: usize) {
        let room = LINE / size_of::<T>();
        self.raw.clear();
        self.raw.resize(len + room, T::default());
        self.start = self.raw.as_ptr().align_offset(LINE).min(room);
        self.len = len;
    }

    /// Makes it `len` long; what it holds is of no account.
    pub fn fit(&mut self, len: usize) {
        if self.raw.len() < len + LINE / size_of::<T>() {
            self.reset(len);
        }
        self.len = len;
    }

    pub fn as_slice(&self) -> &[T] {
        &self.raw[self.start..self.start + self.len]
    }

    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.raw[self.start..self.start + self.len]
    }
}

/// Size of the grids of one pulse.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    /// Cells after which the grid repeats.
    pub period: usize,
    /// Cells that a scatterer path is spread over.
    pub width: usize,
    /// Lanes of each layer: 2, 4 or 8.
    pub lanes: Vec<usize>,
}

impl Shape {
    /// First cell of what is not read: even, so that pairs of cells stay in their cache lines.
    pub fn outside(&self) -> usize {
        (self.period + self.width).next_multiple_of(2)
    }

    /// Numbers in one layer, whole cache lines.
    pub fn layer_len(&self, layer: usize) -> usize {
        ((self.outside() + self.width + 1) * self.lanes[layer]).next_multiple_of(LINE / size_of::<f32>())
    }

    /// Numbers of a pulse before a layer.
    pub fn offset(&self, layer: usize) -> usize {
        (0..layer).map(|before| self.layer_len(before)).sum()
    }

    /// Numbers of a pulse.
    pub fn pulse_len(&self) -> usize {
        (0..self.lanes.len()).map(|layer| self.layer_len(layer)).sum()
    }
}

/// Grids of every pulse of a block.
#[derive(Debug)]
pub struct Grids<T> {
    pub(super) shape: Shape,
    cells: Lined<T>,
}

/// The grids of some neighbouring pulses of a block, for one thread.
#[derive(Debug)]
pub struct Share<'a, T> {
    /// First pulse of the share.
    pub(super) first: usize,
    pub(super) pulse_len: usize,
    pub(super) cells: &'a mut [T],
}

impl<T: Scalar> Grids<T> {
    pub(super) fn new(shape: Shape) -> Self {
        Self { shape, cells: Lined::default() }
    }

    /// Empties the grids and makes room for `pulses`.
    pub(super) fn reset(&mut self, pulses: usize) {
        self.cells.reset(pulses * self.shape.pulse_len());
    }

    /// Splits the pulses in `count` shares of equal size (the last may be smaller; there may be fewer).
    pub fn shares(&mut self, count: usize) -> impl Iterator<Item = Share<'_, T>> {
        let pulse_len = self.shape.pulse_len().max(1);
        let pulses = self.cells.as_slice().len() / pulse_len;
        let each = pulses.div_ceil(count.max(1)).max(1);
        let chunks = self.cells.as_mut_slice().chunks_mut(each * pulse_len);
        chunks.enumerate().map(move |(i, cells)| Share { first: i * each, pulse_len, cells })
    }

    /// The grids of all pulses.
    pub(super) fn all(&mut self) -> &mut [T] {
        self.cells.as_mut_slice()
    }

    /// Those of one.
    pub(super) fn of_pulse(&mut self, pulse: usize) -> &mut [T] {
        let pulse_len = self.shape.pulse_len();
        &mut self.cells.as_mut_slice()[pulse * pulse_len..][..pulse_len]
    }

    /// The grid of a layer.
    fn of_layer(&self, pulse: usize, layer: usize) -> &[T] {
        let shape = &self.shape;
        let from = pulse * shape.pulse_len() + shape.offset(layer);
        &self.cells.as_slice()[from..][..(shape.period + shape.width) * shape.lanes[layer]]
    }

    /// Whether nothing was spread on the grid of a layer.
    pub(super) fn is_empty(&self, pulse: usize, layer: usize) -> bool {
        // Many at a time, without a branch for each.
        let all_zero = |cells: &[T]| cells.iter().fold(true, |zero, cell| zero & (*cell == T::default()));
        self.of_layer(pulse, layer).chunks(64).all(all_zero)
    }

    /// The grid of one channel, the edges folded, `period` cells.
    pub(super) fn fold(&self, pulse: usize, layer: usize, channel: usize, out: &mut [Complex<T>]) {
        let cells = self.of_layer(pulse, layer);
        match self.shape.lanes[layer] {
            2 => fold::<T, 2>(cells, channel, out),
            4 => fold::<T, 4>(cells, channel, out),
            _ => fold::<T, 8>(cells, channel, out),
        }
    }
}

/// A channel of cells of `C` lanes; those beyond the end of the grid are added to its beginning.
fn fold<T: Scalar, const C: usize>(cells: &[T], channel: usize, out: &mut [Complex<T>]) {
    let cells = cells.as_chunks::<C>().0;
    let value = |cell: &[T; C]| Complex::new(cell[2 * channel], cell[2 * channel + 1]);
    for (to, cell) in out.iter_mut().zip(cells) {
        *to = value(cell);
    }
    let period = out.len();
    for (to, cell) in out.iter_mut().zip(cells.iter().skip(period)) {
        *to = *to + value(cell);
    }
}
