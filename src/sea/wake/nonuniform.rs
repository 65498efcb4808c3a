//! Sums of arbitrary plane waves on a grid of facets, by FFT.
//!
//! `P(m, l) = sum over n of [c_n exp(j (a_n m + b_n l)) + d_n exp(-j (a_n m + b_n l))]`
//!
//! with m, l the place of a facet counted from the middle of the grid and `a_n, b_n` the phase steps from
//! facet to facet, radians: two real fields at once when c and d are chosen so that P's real and imaginary
//! parts are they. Each wave is spread over `w x w` cells of a wave-number grid finer by the factor
//! [`OVERSAMPLING`] with the kernel `phi(x) = exp(beta (sqrt(1 - x^2) - 1))`, `x = 2 (cell - place)/w`,
//! `beta = 0.97 pi (1 - 1/(2 s)) w`; then one FFT along each axis (columns that are not wanted are left out,
//! and rows without waves: those of a ship lie on two curves), and division by the kernel's own transform.
//! Source: Barnett, Magland and af Klinteberg, SIAM J. Sci. Comp. 41, C479 (2019).
//!
//! The largest error of any facet is below the one asked, relative to the root sum square of c and d: `w` is
//! `(25 dB - error)/15 dB`, and each cell gains about [`DB_A_CELL`] dB, until rounding stops it: near -230 dB
//! in f64; in f32 near -100 dB of the largest value on a map.
//!
//! ```
//! use nereus::sea::wake::nonuniform::NonUniform;
//! use num_complex::Complex64;
//! let mut sum = NonUniform::<f64>::new([8, 4], 1, -100.0)?;
//! sum.place(&[[0.3, -0.2]]);
//! let mut out = vec![Complex64::ZERO; 32];
//! sum.run(&[[Complex64::ONE, Complex64::ZERO]], &mut out);
//! // Facet (6, 3) is (2, 1) from the middle facet (4, 2).
//! let phase: f64 = 0.3 * 2.0 - 0.2 * 1.0;
//! assert!((out[3 * 8 + 6] - Complex64::cis(phase)).norm() < 1e-5);
//! # Ok::<(), nereus::sea::wake::WakeError>(())
//! ```

use super::fault::ERROR_RANGE_DB;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex;

use crate::sea::surface::fields::Real;
use crate::sea::wake::fault::WakeError;
use crate::units::next_product_of;

/// Cells of the wave-number grid per cell of a critically sampled one, at least.
pub const OVERSAMPLING: f64 = 1.5;

/// What one more cell of kernel width gains, dB.
pub const DB_A_CELL: f64 = 15.0;
/// Rows transformed before their results are turned: a cache line of f32 pairs.
const BLOCK: usize = 8;

/// Cells of kernel width for an error, dB.
pub fn width(error_db: f64) -> usize {
    ((25.0 - error_db) / DB_A_CELL).ceil().clamp(4.0, 17.0) as usize
}

/// Sums of plane waves on a grid.
#[derive(Clone)]
pub struct NonUniform<T: Real> {
    axes: [Axis<T>; 2],
    width: usize,
    beta: f64,
    /// Phase steps of the waves placed last, radians.
    steps_rad: Vec<[f64; 2]>,
    /// Per wave, and then its opposite: first cell along x and y.
    first: Vec<[usize; 2]>,
    /// As many: `w` values of the kernel along x, `w` along y.
    taps: Vec<T>,
    /// Blocks of rows of the grid in which waves lie, rising.
    blocks: Vec<usize>,
    /// `[kx][ky]`; what stands in blocks without waves is of no account.
    grid: Vec<Complex<T>>,
    /// `[iy][place in blocks][kx]`.
    half: Vec<Complex<T>>,
    /// One row of it, `[kx]`.
    line: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

/// One axis of the grid.
#[derive(Clone)]
struct Axis<T: Real> {
    facets: usize,
    cells: usize,
    fft: Arc<dyn Fft<T>>,
    /// Per facet: cell of its value after the transform.
    cell: Vec<usize>,
    /// Per facet: the inverse of the kernel's transform.
    factor: Vec<T>,
}

impl<T: Real> Axis<T> {
    fn new(facets: usize, width: usize, beta: f64) -> Self {
        let cells =
            next_product_of(&[2, 3, 5], ((OVERSAMPLING * facets as f64).ceil() as usize).max(2 * width));
        let offset = |i: usize| i as i64 - (facets / 2) as i64;
        Self {
            facets,
            cells,
            fft: nereus_fft::inverse(cells),
            cell: (0..facets).map(|i| offset(i).rem_euclid(cells as i64) as usize).collect(),
            factor: (0..facets)
                .map(|i| {
                    let turn = PI * width as f64 * offset(i) as f64 / cells as f64;
                    T::round_from(2.0 / (width as f64 * kernel_transform(beta, turn)))
                })
                .collect(),
        }
    }
}

impl<T: Real> NonUniform<T> {
    /// For facets along x and y, at most so many waves, and an error in dB.
    pub fn new(facets: [usize; 2], most_waves: usize, error_db: f64) -> Result<Self, WakeError> {
        if !(ERROR_RANGE_DB[0]..=ERROR_RANGE_DB[1]).contains(&error_db) {
            return Err(WakeError::ErrorBudget { error_db });
        }
        let width = width(error_db);
        let beta = 0.97 * PI * (1.0 - 0.5 / OVERSAMPLING) * width as f64;
        let axes = facets.map(|n| Axis::new(n.max(1), width, beta));
        let zero = Complex::new(T::default(), T::default());
        let scratch = axes.iter().map(|axis| axis.fft.get_inplace_scratch_len()).max().unwrap_or(0);
        Ok(Self {
            width,
            beta,
            steps_rad: Vec::with_capacity(most_waves),
            first: Vec::with_capacity(2 * most_waves),
            taps: Vec::with_capacity(4 * width * most_waves),
            blocks: Vec::with_capacity(axes[0].cells.div_ceil(BLOCK)),
            grid: vec![zero; axes[0].cells * axes[1].cells],
            half: vec![zero; axes[0].cells.next_multiple_of(BLOCK) * axes[1].facets],
            line: vec![zero; axes[0].cells],
            scratch: vec![zero; scratch],
            axes,
        })
    }

    /// Where the waves are: phase steps along x and y, radians. No memory is taken up to the number of waves
    /// made for.
    pub fn place(&mut self, steps_rad: &[[f64; 2]]) {
        if self.steps_rad == steps_rad {
            // A ship on a straight course.
            return;
        }
        self.steps_rad.clear();
        self.steps_rad.extend_from_slice(steps_rad);
        self.first.clear();
        self.taps.clear();
        let cells_x = self.axes[0].cells;
        let half_width = 0.5 * self.width as f64;
        for step in steps_rad {
            for sign in [1.0, -1.0] {
                let mut first = [0; 2];
                for (axis, first) in first.iter_mut().enumerate() {
                    let cells = self.axes[axis].cells;
                    let turn = sign * step[axis] / TAU;
                    let place = (turn - turn.round()) * cells as f64;
                    let start = (place - half_width).ceil();
                    *first = (start as i64).rem_euclid(cells as i64) as usize;
                    for i in 0..self.width {
                        let x = (start + i as f64 - place) / half_width;
                        let root = (1.0 - x * x).max(0.0).sqrt();
                        self.taps.push(T::round_from((self.beta * (root - 1.0)).exp()));
                    }
                }
                self.first.push(first);
            }
        }
        self.blocks.clear();
        let touched = |block: usize| {
            let rows = block * BLOCK..((block + 1) * BLOCK).min(cells_x);
            // A kernel that begins before the block, or goes on over the edge.
            let reaches = |[first, _]: &[usize; 2]| {
                let before = (rows.start + cells_x - first) % cells_x;
                before < self.width || rows.contains(first)
            };
            self.first.iter().any(reaches)
        };
        self.blocks.extend((0..cells_x.div_ceil(BLOCK)).filter(|block| touched(*block)));
    }

    /// The sum with amplitudes `[c, d]` of each wave, into `out[iy nx + ix]`.
    pub fn run(&mut self, amplitudes: &[[Complex<T>; 2]], out: &mut [Complex<T>]) {
        let zero = Complex::new(T::default(), T::default());
        self.spread(amplitudes);
        let [x, y] = &self.axes;
        let stride = self.blocks.len() * BLOCK;
        for (nth, block) in self.blocks.iter().enumerate() {
            let count = BLOCK.min(x.cells - block * BLOCK);
            let rows = &mut self.grid[block * BLOCK * y.cells..][..count * y.cells];
            y.fft.process_with_scratch(rows, &mut self.scratch);
            for (line, (&cell, &factor)) in
                self.half.chunks_exact_mut(stride).zip(y.cell.iter().zip(&y.factor))
            {
                for (row, value) in line[nth * BLOCK..][..count].iter_mut().enumerate() {
                    *value = rows[row * y.cells + cell] * factor;
                }
            }
        }
        for (iy, out) in out.chunks_exact_mut(x.facets).enumerate().take(y.facets) {
            self.line.fill(zero);
            let held = self.half[iy * stride..][..stride].chunks_exact(BLOCK);
            for (block, held) in self.blocks.iter().zip(held) {
                let count = BLOCK.min(x.cells - block * BLOCK);
                self.line[block * BLOCK..][..count].copy_from_slice(&held[..count]);
            }
            x.fft.process_with_scratch(&mut self.line, &mut self.scratch);
            // Facets before the middle lie at the end of the line.
            let before = x.facets / 2;
            let (low, high) = out.split_at_mut(before);
            let (low_factors, high_factors) = x.factor.split_at(before);
            scale(low, &self.line[x.cells - before..], low_factors);
            scale(high, &self.line, high_factors);
        }
    }

    fn spread(&mut self, amplitudes: &[[Complex<T>; 2]]) {
        let w = self.width;
        let [cells_x, cells_y] = [self.axes[0].cells, self.axes[1].cells];
        for block in &self.blocks {
            let count = BLOCK.min(cells_x - block * BLOCK);
            self.grid[block * BLOCK * cells_y..][..count * cells_y]
                .fill(Complex::new(T::default(), T::default()));
        }
        let waves = self.first.iter().zip(self.taps.chunks_exact(2 * w));
        for ((first, taps), &amplitude) in waves.zip(amplitudes.iter().flatten()) {
            let (along_x, along_y) = taps.split_at(w);
            // Cells that run over the edge go on at the other.
            let inside = w.min(cells_y - first[1]);
            for (i, &tap) in along_x.iter().enumerate() {
                let row = (first[0] + i) % cells_x * cells_y;
                let value = amplitude * tap;
                let start = row + first[1];
                add(&mut self.grid[start..start + inside], value, &along_y[..inside]);
                add(&mut self.grid[row..row + w - inside], value, &along_y[inside..]);
            }
        }
    }
}

fn scale<T: Real>(out: &mut [Complex<T>], values: &[Complex<T>], factors: &[T]) {
    for ((out, value), factor) in out.iter_mut().zip(values).zip(factors) {
        *out = *value * *factor;
    }
}

#[inline(always)]
fn add<T: Real>(cells: &mut [Complex<T>], value: Complex<T>, taps: &[T]) {
    for (cell, &tap) in cells.iter_mut().zip(taps) {
        cell.re = cell.re + value.re * tap;
        cell.im = cell.im + value.im * tap;
    }
}

/// `integral from -1 to 1 of phi(x) cos(turn x) dx`.
fn kernel_transform(beta: f64, turn: f64) -> f64 {
    // x = sin v: the integrand is then smooth, and the trapezoid's error at the ends is exp(-beta) h^2. The
    // steps follow the faster of kernel and cosine.
    let steps = (16.0 + 2.0 * beta + 2.0 * turn.abs()).ceil();
    let h = FRAC_PI_2 / steps;
    let mut sum = 0.5;
    for i in 1..=steps as usize {
        let (sin, cos) = (h * i as f64).sin_cos();
        sum += cos * (beta * (cos - 1.0)).exp() * (turn * sin).cos();
    }
    2.0 * h * sum
}
