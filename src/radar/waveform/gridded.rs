//! A sum over samples at any frequency, by a transform twice as long and an interpolation.
//!
//! ```text
//! S(y) = sum_n s_n e^{-j 2 pi y n} ,   n = -L/2 .. L/2     y in cycles a sample
//!      = sum_m G[m] psi(M y - m) ,     G[m] = sum_n s_n / psihat(n) e^{-j 2 pi n m / M} ,   M >= 2 L
//! psi(x) = exp(b (sqrt(1 - (2 x/w)^2) - 1)) ,   w = 10 cells, b = 2.3 w
//! ```
//!
//! `psihat(n) = int psi(x) e^{j 2 pi n x / M} dx`. Off by some 1e-9 of `sum |s_n|^2`, rms. Source: Barnett,
//! Magland and af Klinteberg, SIAM J. Sci. Comput. 41 (2019) C479.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::{Arc, OnceLock};

use nereus_fft::Fft;
use num_complex::Complex64;

use crate::units::fast_len;

/// Cells of an interpolation.
const WIDTH: usize = 10;
/// The same in registers of four.
const LANES: usize = WIDTH.next_multiple_of(4);
const SHAPE: f64 = 2.3 * WIDTH as f64;
/// Rows of the kernel's table from one cell to the next.
const ROWS: usize = 512;
/// Points of the quadrature of the kernel's transform.
const POINTS: usize = 64;

/// Transforms of up to so many samples.
#[derive(Clone)]
pub(super) struct Plan {
    cells: usize,
    /// `1/psihat(n)`, `n = 0 ..= L/2`.
    inverse: Arc<[f64]>,
    forward: Arc<dyn Fft<f64>>,
}

impl Plan {
    pub fn new(samples: usize) -> Self {
        let cells = fast_len(2 * samples.max(WIDTH));
        // x = w/2 sin a.
        let nodes: Vec<[f64; 2]> = (0..POINTS)
            .map(|i| {
                let a = PI * (i as f64 + 0.5) / POINTS as f64 - FRAC_PI_2;
                [0.5 * WIDTH as f64 * a.sin(), (SHAPE * (a.cos() - 1.0)).exp() * a.cos()]
            })
            .collect();
        let step = 0.5 * WIDTH as f64 * PI / POINTS as f64;
        let of = |n: usize| {
            let turn = TAU * n as f64 / cells as f64;
            let sum: f64 = nodes.iter().map(|[x, weight]| weight * (turn * x).cos()).sum();
            (step * sum).recip()
        };
        let inverse = (0..=samples / 2 + 1).map(of).collect();
        Self { cells, inverse, forward: nereus_fft::forward(cells) }
    }

    /// Memory that several sums may be made in.
    pub fn room(&self) -> Room {
        let of = |len: usize| vec![Complex64::ZERO; len];
        Room { values: of(self.cells), scratch: of(self.forward.get_inplace_scratch_len()) }
    }

    /// The sum of `count` samples that `of` gives by `n + count/2`.
    pub fn gridded(&self, count: usize, of: impl Fn(usize) -> Complex64, room: &mut Room) -> Gridded {
        let Room { values, scratch } = room;
        values.fill(Complex64::ZERO);
        let middle = (count / 2) as isize;
        for j in 0..count {
            let n = j as isize - middle;
            let scale = self.inverse.get(n.unsigned_abs()).copied().unwrap_or(0.0);
            values[n.rem_euclid(self.cells as isize) as usize] = of(j) * scale;
        }
        self.forward.process_with_scratch(values, scratch);
        // With the edges that an interpolation reaches.
        let (before, after) = (&values[self.cells - WIDTH..], &values[..LANES]);
        let all = || before.iter().chain(values.iter()).chain(after);
        let (mut re, mut im) =
            (Vec::with_capacity(self.cells + WIDTH + LANES), Vec::with_capacity(self.cells + WIDTH + LANES));
        all().for_each(|value| re.push(value.re));
        all().for_each(|value| im.push(value.im));
        Gridded { cells: self.cells, re, im }
    }
}

/// Memory of a transform.
pub(super) struct Room {
    values: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

/// The transform of some samples, read between its cells.
#[derive(Clone, Debug)]
pub(super) struct Gridded {
    cells: usize,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Gridded {
    /// `S(y)`.
    #[inline(always)]
    pub fn at(&self, y: f64) -> Complex64 {
        let (first, weights) = taps(y, self.cells);
        self.sum(first, &weights)
    }

    /// The sum over some taps.
    #[inline(always)]
    fn sum(&self, first: usize, weights: &[f64; LANES]) -> Complex64 {
        let taps = first..first + LANES;
        let (Some(re), Some(im)) = (self.re.get(taps.clone()), self.im.get(taps)) else {
            return Complex64::ZERO;
        };
        let mut sums = [[0.0; 4]; 2];
        for (part, weights) in weights.as_chunks::<4>().0.iter().enumerate() {
            for lane in 0..4 {
                sums[0][lane] += weights[lane] * re[4 * part + lane];
                sums[1][lane] += weights[lane] * im[4 * part + lane];
            }
        }
        let [re, im] = sums;
        Complex64::new((re[0] + re[1]) + (re[2] + re[3]), (im[0] + im[1]) + (im[2] + im[3]))
    }
}

/// Where the transform of samples is read, once for all that have as many cells.
#[derive(Debug)]
pub(super) struct Places {
    cells: usize,
    first: Vec<usize>,
    /// Rounded: 6e-8 of the sum, in half the memory.
    weights: Vec<[f32; LANES]>,
}

impl Places {
    /// For such sums at `y`, cycles a sample.
    pub fn new(of: &Gridded, y: impl Iterator<Item = f64>) -> Self {
        let rounded = |(first, weights): (usize, [f64; LANES])| (first, weights.map(|weight| weight as f32));
        let (first, weights) = y.map(|y| rounded(taps(y, of.cells))).unzip();
        Self { cells: of.cells, first, weights }
    }

    /// Whether it is for such sums.
    pub fn are_of(&self, sum: &Gridded) -> bool {
        self.cells == sum.cells
    }

    /// `S` at the places, one after the other, each times its factor.
    #[inline(always)]
    pub fn read(&self, sum: &Gridded, factors: &[Complex64], out: &mut [Complex64]) {
        let Self { first, weights, .. } = self;
        for (((out, factor), first), weights) in out.iter_mut().zip(factors).zip(first).zip(weights) {
            let taps = *first..*first + LANES;
            let (Some(re), Some(im)) = (sum.re.get(taps.clone()), sum.im.get(taps)) else {
                *out = Complex64::ZERO;
                continue;
            };
            *out = Complex64::new(dot(re, weights), dot(im, weights)) * factor;
        }
    }
}

/// Halves are added to halves: whole registers.
#[inline(always)]
fn dot(values: &[f64], weights: &[f32; LANES]) -> f64 {
    let mut sums = [0.0; 4];
    for part in 0..LANES / 4 {
        for lane in 0..4 {
            sums[lane] += f64::from(weights[4 * part + lane]) * values[4 * part + lane];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// First tap of `S(y)` over so many cells, and the weights of all.
#[inline(always)]
fn taps(y: f64, cells: usize) -> (usize, [f64; LANES]) {
    let place = (y - y.floor()) * cells as f64;
    let cell = place.floor();
    // Cell 0 stands at WIDTH, the first tap WIDTH/2 - 1 before it.
    (cell as usize + WIDTH - (WIDTH / 2 - 1), weights(place - cell))
}

/// The kernel at the cells about a place that lies `t` beyond a cell, by cubics through its table.
#[inline(always)]
fn weights(t: f64) -> [f64; LANES] {
    let table = table();
    let place = t * ROWS as f64;
    let row = (place as usize).min(ROWS);
    let x = place - row as f64;
    let cubic = lagrange(x);
    let mut sum = [0.0; LANES];
    for (of, row) in cubic.iter().zip(&table[row..row + 4]) {
        for lane in 0..LANES {
            sum[lane] += of * row[lane];
        }
    }
    sum
}

fn table() -> &'static [[f64; LANES]] {
    static TABLE: OnceLock<Vec<[f64; LANES]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let row = |r: usize| {
            let t = (r as f64 - 1.0) / ROWS as f64;
            let of = |i| if i < WIDTH { psi(t + (WIDTH / 2 - 1) as f64 - i as f64) } else { 0.0 };
            std::array::from_fn(of)
        };
        (0..ROWS + 4).map(row).collect()
    })
}

/// Weights of the values at -1, 0, 1 and 2 for one at `x` of 0 to 1.
#[inline(always)]
pub(super) fn lagrange(x: f64) -> [f64; 4] {
    let (a, b, c) = (x + 1.0, x - 1.0, x - 2.0);
    [-x * b * c / 6.0, a * b * c / 2.0, -a * x * c / 2.0, a * x * b / 6.0]
}

fn psi(x: f64) -> f64 {
    let z = 2.0 * x / WIDTH as f64;
    let inside = 1.0 - z * z;
    if inside > 0.0 { (SHAPE * (inside.sqrt() - 1.0)).exp() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::phasor::phasor;

    #[test]
    fn sums_are_those_of_their_samples() {
        for count in [1usize, 2, 63, 500] {
            let samples: Vec<Complex64> =
                (0..count).map(|j| phasor((j * j) as f64 * 0.137) * (1.0 + 0.3 * (j as f64).sin())).collect();
            let plan = Plan::new(count + 1);
            let gridded = plan.gridded(count, |j| samples[j], &mut plan.room());
            let (mut off, mut all) = (0.0, 0.0);
            for i in 0..997 {
                let y = f64::from(i) * 0.00317 - 1.3;
                let exact: Complex64 = samples
                    .iter()
                    .enumerate()
                    .map(|(j, s)| s * phasor(-y * (j as f64 - (count / 2) as f64)))
                    .sum();
                off += (gridded.at(y) - exact).norm_sqr();
                all += exact.norm_sqr();
            }
            println!("{count} samples: {:.1e}", (off / all).sqrt());
            assert!((off / all).sqrt() < 1e-8, "{count}");
        }
    }
}
