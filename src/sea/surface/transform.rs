//! From rotating amplitudes to fields: two real fields by one complex transform.
//!
//! If X and Y are the (Hermitian) spectra of two real fields, the inverse transform of `X + j Y` has the
//! one as its real and the other as its imaginary part. Columns are transformed first, written
//! transposed, then rows. Pairs are independent of one another: each may have a [`Transform`] and a
//! thread of its own, with the same result.
//!
//! ```
//! use nereus::scene::water::{Dispersion, WindProfile};
//! use nereus::sea::spectrum::FungLee;
//! use nereus::sea::surface::{Averaging, Grid, Pair, Phasors, Surface, Transform};
//! use nereus::sea::wind::Wind;
//! let spectrum = FungLee::new(&Wind::from_speed(6.0, 10.0, WindProfile::Cardone, 0.0)?);
//! let grid = Grid::new(16, 16, 4.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 1, Averaging::Automatic)?;
//! let mut phasors = Phasors::<f32>::new(&surface);
//! phasors.turn_to(30.0);
//! let (mut slope_x, mut slope_y) = (vec![0.0; grid.len()], vec![0.0; grid.len()]);
//! Transform::new(&surface).run(&phasors, Pair::Slope, &mut slope_x, &mut slope_y);
//! assert!(slope_x.iter().any(|s| *s != 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex;

use super::fields::Real;
use super::modulation::{CONTRACTION, parts};
use super::{Phasors, Surface};
use crate::cpu::{Task, Variant};

/// Two fields that are transformed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// Height and vertical acceleration.
    Height,
    /// Slopes along x and y.
    Slope,
    /// Horizontal velocities.
    HorizontalVelocity,
    /// Vertical velocity, alone.
    VerticalVelocity,
    /// Height and vertical velocity.
    Rise,
    /// Horizontal accelerations.
    HorizontalAcceleration,
    /// Horizontal displacements.
    Displacement,
    /// Rates of the slopes.
    SlopeRate,
    /// Modulation, xx and yy ([`modulation`](super::modulation)).
    Modulation,
    /// Modulation, xy, alone.
    ModulationShear,
    /// Gradient of the displacement, xx and yy.
    Stretch,
    /// Gradient of the displacement, xy, alone.
    StretchShear,
    /// Modulation, xy, and gradient of the displacement, xy.
    Shears,
}

/// Rows of the wave-number plane that are transformed before they are written transposed: one cache line
/// of f32 pairs.
const BLOCK: usize = 8;

/// Factors and buffers of the transforms of one surface.
#[derive(Clone)]
pub struct Transform<T: Real> {
    nx: usize,
    ny: usize,
    along_y: Arc<dyn Fft<T>>,
    along_x: Arc<dyn Fft<T>>,
    /// Kx of every row and Ky of every column (0 at Nyquist), rad/m.
    kx: Vec<T>,
    ky: Vec<T>,
    /// `[|kx|][ky]`: w, rad/s, and `coth(K d)/K`, m (0 at K = 0).
    omega: Vec<T>,
    excursion: Vec<T>,
    /// Power of two that brings the vertical acceleration to the size of the height: what one of two
    /// fields loses to rounding is proportional to the larger.
    levelling: T,
    levelled_back: T,
    /// `g` where the horizontal acceleration is `-g` times the slope: gravity waves in any depth.
    gravity: Option<T>,
    /// `[|kx|][ky]`: what relaxation leaves of the contraction, in phase and behind; empty unless it is
    /// known.
    relaxed: [Vec<T>; 2],
    block: Vec<Complex<T>>,
    plane: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
    /// First column and row of the fields.
    begin: [usize; 2],
}

impl<T: Real> Transform<T> {
    /// For a surface.
    pub fn new(surface: &Surface) -> Self {
        let grid = surface.grid();
        let (nx, ny) = (grid.nx(), grid.ny());
        let dk = grid.wave_number_step_rad_m();
        let along_y = nereus_fft::inverse(ny);
        let along_x = nereus_fft::inverse(nx);
        let scratch = along_y.get_inplace_scratch_len().max(along_x.get_inplace_scratch_len());
        let wave_number = |index: Option<i64>, dk: f64| index.map_or(0.0, |m| m as f64 * dk);
        let kx: Vec<f64> = (0..nx).map(|i| wave_number(grid.wave_index_x(i), dk[0])).collect();
        let ky: Vec<f64> = (0..ny).map(|j| wave_number(grid.wave_index_y(j), dk[1])).collect();
        let dispersion = surface.dispersion();
        let (mut omega, mut excursion) = (Vec::new(), Vec::new());
        for kx in &kx[..=nx / 2] {
            for ky in &ky {
                let k = kx.hypot(*ky);
                omega.push(T::round_from(dispersion.angular_frequency_rad_s(k)));
                let ratio = if k > 0.0 { dispersion.excursion_ratio(k) / k } else { 0.0 };
                excursion.push(T::round_from(ratio));
            }
        }
        let zero = Complex::new(T::default(), T::default());
        let levelling = levelling(surface);
        Self {
            nx,
            ny,
            levelling: T::round_from(levelling),
            levelled_back: T::round_from(1.0 / levelling),
            along_y,
            along_x,
            kx: kx.into_iter().map(T::round_from).collect(),
            ky: ky.into_iter().map(T::round_from).collect(),
            omega,
            excursion,
            gravity: (!dispersion.capillary).then(|| T::round_from(crate::sea::GRAVITY_MPS2)),
            relaxed: [Vec::new(), Vec::new()],
            block: vec![zero; BLOCK.min(nx) * ny],
            plane: vec![zero; nx * ny],
            scratch: vec![zero; scratch],
            begin: [0; 2],
        }
    }

    /// Short waves relax at a rate from now on, 1/s; 1 where none is given.
    pub fn relax(&mut self, rate_per_s: f64) {
        let rate_per_s = T::round_from(rate_per_s);
        let [in_phase, behind] = &mut self.relaxed;
        in_phase.clear();
        behind.clear();
        for (omega_rad_s, excursion_m) in self.omega.iter().zip(&self.excursion) {
            let (re, im) = parts(*omega_rad_s, rate_per_s);
            let scale = T::round_from(CONTRACTION) * *excursion_m;
            in_phase.push(scale * re);
            behind.push(scale * im);
        }
    }

    /// Which column and row of the grid come first in the fields from now on; those before them come last.
    pub fn begin_at(&mut self, column_row: [usize; 2]) {
        self.begin = [column_row[0] % self.nx, column_row[1] % self.ny];
    }

    /// Fills a pair of fields (the second may be empty). Of slices shorter than the grid whole rows are
    /// filled.
    pub fn run(&mut self, phasors: &Phasors<T>, pair: Pair, first: &mut [T], second: &mut [T]) {
        let relaxes = matches!(pair, Pair::Modulation | Pair::ModulationShear | Pair::Shears);
        if relaxes && self.relaxed[0].is_empty() {
            self.relax(1.0);
        }
        match (pair, self.gravity) {
            (Pair::HorizontalAcceleration, Some(gravity)) => {
                self.transform(phasors, Pair::Slope);
                self.separate(first, second, [-gravity, -gravity]);
            }
            (Pair::Height, _) => {
                self.transform(phasors, pair);
                self.separate(first, second, [T::one(), self.levelled_back]);
            }
            _ => {
                self.transform(phasors, pair);
                self.separate(first, second, [T::one(), T::one()]);
            }
        }
    }

    fn transform(&mut self, phasors: &Phasors<T>, pair: Pair) {
        let (nx, ny) = (self.nx, self.ny);
        for first in (0..nx).step_by(BLOCK) {
            let rows = BLOCK.min(nx - first);
            let block = &mut self.block[..rows * ny];
            for (row, out) in block.chunks_exact_mut(ny).enumerate() {
                let i = first + row;
                let here = i * ny..(i + 1) * ny;
                let half = i.min(nx - i) * ny;
                let factors = Row {
                    levelling: self.levelling,
                    relaxed: self
                        .relaxed
                        .each_ref()
                        .map(|table| table.get(half..half + ny).unwrap_or_default()),
                    kx: self.kx[i],
                    ky: &self.ky,
                    omega: &self.omega[half..half + ny],
                    excursion: &self.excursion[half..half + ny],
                };
                let (h, g) = (&phasors.h[here.clone()], &phasors.g[here]);
                Variant::fastest().run(FillRow { factors, pair, h, g, out });
            }
            self.along_y.process_with_scratch(block, &mut self.scratch);
            for (iy, line) in self.plane.chunks_exact_mut(nx).enumerate() {
                for (row, value) in line[first..first + rows].iter_mut().enumerate() {
                    *value = block[row * ny + iy];
                }
            }
        }
    }

    fn separate(&mut self, first: &mut [T], second: &mut [T], factors: [T; 2]) {
        let (nx, ny) = (self.nx, self.ny);
        let [from_x, from_y] = self.begin;
        for (iy, line) in self.plane.chunks_exact_mut(nx).enumerate() {
            self.along_x.process_with_scratch(line, &mut self.scratch);
            let start = (iy + ny - from_y) % ny * nx;
            for (part, field) in [&mut *first, &mut *second].into_iter().enumerate() {
                // Columns from the first one on, and those before it behind them.
                let Some(row) = field.get_mut(start..start + nx) else { continue };
                let (near, far) = row.split_at_mut(nx - from_x);
                let factor = factors[part];
                Variant::fastest().run(Separate { part, factor, from: &line[from_x..], to: near });
                Variant::fastest().run(Separate { part, factor, from: &line[..from_x], to: far });
            }
        }
    }
}

/// Real or imaginary parts of a row, times a factor.
struct Separate<'a, T> {
    part: usize,
    factor: T,
    from: &'a [Complex<T>],
    to: &'a mut [T],
}

impl<T: Real> Task for Separate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { part, factor, from, to } = self;
        for (to, from) in to.iter_mut().zip(from) {
            *to = if part == 0 { from.re } else { from.im } * factor;
        }
    }
}

/// The power of two nearest to the rms of the height over that of the vertical acceleration.
fn levelling(surface: &Surface) -> f64 {
    let grid = surface.grid();
    let dk = grid.wave_number_step_rad_m();
    let (mut height, mut acceleration) = (0.0, 0.0);
    for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
        for (j, amplitude) in row.iter().enumerate() {
            if let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) {
                let k = (mx as f64 * dk[0]).hypot(my as f64 * dk[1]);
                let energy = amplitude.norm_sqr();
                height += energy;
                acceleration += energy * surface.dispersion().angular_frequency_rad_s(k).powi(4);
            }
        }
    }
    if height > 0.0 && acceleration > 0.0 {
        // Limits within which f32 neither overflows nor loses digits.
        (0.5 * (height / acceleration).log2()).round().clamp(-40.0, 40.0).exp2()
    } else {
        1.0
    }
}

/// Factors along one row of the wave-number plane.
struct Row<'a, T> {
    levelling: T,
    relaxed: [&'a [T]; 2],
    kx: T,
    ky: &'a [T],
    omega: &'a [T],
    excursion: &'a [T],
}

struct FillRow<'a, T> {
    factors: Row<'a, T>,
    pair: Pair,
    h: &'a [Complex<T>],
    g: &'a [Complex<T>],
    out: &'a mut [Complex<T>],
}

impl<T: Real> Task for FillRow<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.factors.fill(self.pair, self.h, self.g, self.out);
    }
}

impl<T: Real> Row<'_, T> {
    #[inline(always)]
    fn fill(&self, pair: Pair, h: &[Complex<T>], g: &[Complex<T>], out: &mut [Complex<T>]) {
        let zero = T::default();
        match pair {
            // H + j (-w^2 H) levelled
            Pair::Height => {
                self.multiply(h, out, |_, omega, _| (T::one(), -(omega * omega * self.levelling)))
            }
            // j Kx H + j (j Ky H)
            Pair::Slope => self.multiply(h, out, |ky, _, _| (-ky, self.kx)),
            // (Kx + j Ky) w q/K G
            Pair::HorizontalVelocity => self.multiply(g, out, |ky, omega, excursion| {
                let speed = omega * excursion;
                (self.kx * speed, ky * speed)
            }),
            // H + j (-j w G), both levelled by nothing: they are of one size within a wave or two of 1 s.
            Pair::Rise => {
                let n = out.len();
                let (h, g, omega) = (&h[..n], &g[..n], &self.omega[..n]);
                for j in 0..n {
                    out[j] = Complex::new(h[j].re + omega[j] * g[j].re, h[j].im + omega[j] * g[j].im);
                }
            }
            // -j w G
            Pair::VerticalVelocity => self.multiply(g, out, |_, omega, _| (zero, -omega)),
            // -j (Kx + j Ky) w^2 q/K H
            Pair::HorizontalAcceleration => self.multiply(h, out, |ky, omega, excursion| {
                let rate = omega * omega * excursion;
                (ky * rate, -(self.kx * rate))
            }),
            // j (Kx + j Ky) q/K H
            Pair::Displacement => {
                self.multiply(h, out, |ky, _, excursion| (-(ky * excursion), self.kx * excursion))
            }
            // (Kx + j Ky) w G
            Pair::SlopeRate => self.multiply(g, out, |ky, omega, _| (self.kx * omega, ky * omega)),
            Pair::Modulation => self.modulate(h, g, out, |ky| (self.kx * self.kx, ky * ky)),
            Pair::ModulationShear => self.modulate(h, g, out, |ky| (self.kx * ky, zero)),
            // -(Kx^2 + j Ky^2) q/K H
            Pair::Stretch => self.multiply(h, out, |ky, _, excursion| {
                (-(self.kx * self.kx * excursion), -(ky * ky * excursion))
            }),
            Pair::Shears => {
                self.modulate(h, g, out, |ky| (self.kx * ky, zero));
                let n = out.len();
                let (h, ky, excursion) = (&h[..n], &self.ky[..n], &self.excursion[..n]);
                for j in 0..n {
                    // j times what follows.
                    let stretch = self.kx * ky[j] * excursion[j];
                    out[j] = Complex::new(out[j].re + stretch * h[j].im, out[j].im - stretch * h[j].re);
                }
            }
            // -Kx Ky q/K H
            Pair::StretchShear => {
                self.multiply(h, out, |ky, _, excursion| (-(self.kx * ky * excursion), zero))
            }
        }
    }

    /// `out = (a + j b) (Re R H + j Im R G) q/K`: two entries of the tensor, of waves with the transfer
    /// function R.
    #[inline(always)]
    fn modulate(
        &self,
        h: &[Complex<T>],
        g: &[Complex<T>],
        out: &mut [Complex<T>],
        entries: impl Fn(T) -> (T, T),
    ) {
        let n = out.len();
        let (h, g, ky) = (&h[..n], &g[..n], &self.ky[..n]);
        let [in_phase, behind] = self.relaxed.map(|table| &table[..n]);
        for j in 0..n {
            let (re, im) = (in_phase[j], behind[j]);
            let field = Complex::new(re * h[j].re - im * g[j].im, re * h[j].im + im * g[j].re);
            let (a, b) = entries(ky[j]);
            out[j] = Complex::new(a * field.re - b * field.im, a * field.im + b * field.re);
        }
    }

    /// `out = factor(ky, w, q/K) x`, the factor as its real and imaginary part.
    #[inline(always)]
    fn multiply(&self, x: &[Complex<T>], out: &mut [Complex<T>], factor: impl Fn(T, T, T) -> (T, T)) {
        let n = out.len();
        let (x, ky, omega, excursion) = (&x[..n], &self.ky[..n], &self.omega[..n], &self.excursion[..n]);
        for j in 0..n {
            let (re, im) = factor(ky[j], omega[j], excursion[j]);
            out[j] = Complex::new(x[j].re * re - x[j].im * im, x[j].re * im + x[j].im * re);
        }
    }
}
