//! The rotating amplitudes at an instant: `H = E + F` and `G = E - F` over the wave-number plane.
//!
//! With `s = a(K) + conj a(-K)` and `d = a(K) - conj a(-K)`, fixed: `H = s cos wt - j d sin wt` and
//! `G = d cos wt - j s sin wt`. Phases are reduced to a turn in f64 before they are rounded, so an f32
//! surface is as exact after an hour as at the start. An example is at [`super::transform`].

use num_complex::Complex;

use super::Surface;
use super::fields::{Real, round_complex};
use crate::cpu::{Task, Variant};

/// Rotating amplitudes of a surface.
#[derive(Clone, Debug)]
pub struct Phasors<T> {
    ny: usize,
    /// `[|kx|][|ky|]`: frequency, turns per second.
    turns_per_s: Vec<f64>,
    half_columns: usize,
    sum: Vec<Complex<T>>,
    difference: Vec<Complex<T>>,
    cos: Vec<T>,
    sin: Vec<T>,
    pub(super) h: Vec<Complex<T>>,
    pub(super) g: Vec<Complex<T>>,
}

impl<T: Real> Phasors<T> {
    /// Those of a surface, not yet at any time.
    pub fn new(surface: &Surface) -> Self {
        let grid = surface.grid();
        let (nx, ny) = (grid.nx(), grid.ny());
        let dk = grid.wave_number_step_rad_m();
        let (half_rows, half_columns) = (nx / 2 + 1, ny / 2 + 1);
        let mut turns_per_s = Vec::with_capacity(half_rows * half_columns);
        for i in 0..half_rows {
            for j in 0..half_columns {
                let k = (i as f64 * dk[0]).hypot(j as f64 * dk[1]);
                turns_per_s.push(surface.dispersion().angular_frequency_rad_s(k) / std::f64::consts::TAU);
            }
        }
        let amplitude = surface.amplitude_m();
        let mut sum = Vec::with_capacity(nx * ny);
        let mut difference = Vec::with_capacity(nx * ny);
        for i in 0..nx {
            for j in 0..ny {
                let here = amplitude[i * ny + j];
                let opposite = amplitude[(nx - i) % nx * ny + (ny - j) % ny].conj();
                sum.push(round_complex(here + opposite));
                difference.push(round_complex(here - opposite));
            }
        }
        let zero = Complex::new(T::default(), T::default());
        Self {
            ny,
            turns_per_s,
            half_columns,
            sum,
            difference,
            cos: vec![T::default(); ny],
            sin: vec![T::default(); ny],
            h: vec![zero; nx * ny],
            g: vec![zero; nx * ny],
        }
    }

    /// Turns them to a time, s.
    pub fn turn_to(&mut self, time_s: f64) {
        Variant::fastest().run(Turn { phasors: self, time_s });
    }

    #[inline(always)]
    fn turn(&mut self, time_s: f64) {
        let ny = self.ny;
        let nx = self.h.len() / ny;
        for i in 0..=nx / 2 {
            let turns_per_s = &self.turns_per_s[i * self.half_columns..][..self.half_columns];
            let columns = self.cos[..self.half_columns].iter_mut().zip(&mut self.sin[..self.half_columns]);
            for (turns_per_s, (cos, sin)) in turns_per_s.iter().zip(columns) {
                (*cos, *sin) = T::cos_sin_of_turns(turns_per_s * time_s);
            }
            // w depends on |ky| alone: both columns, which coincide at 0 and Nyquist.
            for j in 1..self.half_columns {
                (self.cos[ny - j], self.sin[ny - j]) = (self.cos[j], self.sin[j]);
            }
            let opposite = (nx - i) % nx;
            self.rotate_row(i);
            if opposite != i {
                self.rotate_row(opposite);
            }
        }
    }

    #[inline(always)]
    fn rotate_row(&mut self, i: usize) {
        let row = i * self.ny..(i + 1) * self.ny;
        let amplitudes = self.sum[row.clone()].iter().zip(&self.difference[row.clone()]);
        let turned = self.h[row.clone()].iter_mut().zip(&mut self.g[row]);
        for (((s, d), (h, g)), (cos, sin)) in amplitudes.zip(turned).zip(self.cos.iter().zip(&self.sin)) {
            *h = Complex::new(s.re * *cos + d.im * *sin, s.im * *cos - d.re * *sin);
            *g = Complex::new(d.re * *cos + s.im * *sin, d.im * *cos - s.re * *sin);
        }
    }
}

struct Turn<'a, T> {
    phasors: &'a mut Phasors<T>,
    time_s: f64,
}

impl<T: Real> Task for Turn<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.phasors.turn(self.time_s);
    }
}
