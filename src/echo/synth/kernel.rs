//! The spreading kernel: exponential of a semicircle, as piecewise polynomials.
//!
//! ```text
//! phi(u) = exp( beta (sqrt(1 - (2u/w)^2) - 1) ) ,  |u| <= w/2 cells ,   beta = 0.97 pi w (1 - 1/(2 sigma))
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | `u` | distance of a grid cell from the echo's place, cells |
//! | `w` | width, cells: that many cells get a share of each scatterer path |
//! | `sigma` | cells of the grid per sample |
//!
//! An echo at `y + w/2` cells lands on the cells `j0 .. j0 + w`, `j0` the least integer above `y`. With
//! `z = j0 - y - 1/2` in `[-1/2, 1/2]` tap `t` weighs `phi(z + t - (w-1)/2)`. Each tap is a polynomial in `z`
//! (interpolation in Chebyshev points), and taps `t` and `w-1-t` are one polynomial of `z` and of `-z`: its
//! even and odd parts are evaluated once for both. What is spread and what is divided out are the *same*
//! polynomials, so their misfit to `phi` costs only what it adds beyond the band: few terms do
//! ([`terms`]), those of a narrow kernel no worse than `phi` itself.
//!
//! **Error.** A scatterer path of random place spread on a grid of `M` cells, seen in bin `k` and divided by
//! `phihat(k) = int phi(u) e^{-j 2 pi k u/M} du`, has the images `phihat(k + q M)/phihat(k)`, `q != 0`, with
//! random phases. Over the band of a pulse `Q(f)` the relative rms error is
//!
//! `e^2 = sum_k |Q_k|^2 sum_q (phihat(k + q M)/phihat(k))^2 / sum_k |Q_k|^2`.
//!
//! Source: Barnett, Magland, af Klinteberg, SIAM J. Sci. Comput. 41 (2019) C479 (kernel and `beta`); the
//! error is derived here.
//!
//! ```
//! use nereus::echo::synth::kernel::Kernel;
//! let kernel = Kernel::new(5, 2.0)?;
//! // Five cells, twice as fine as the samples: about -90 dB over a flat band of 0.6 fs.
//! let flat: Vec<(f64, f64)> = (-30..=30).map(|k| (f64::from(k) / 200.0, 1.0)).collect();
//! let db = 10.0 * kernel.gridding_error_power(&flat).log10();
//! assert!((-93.0..-86.0).contains(&db), "{db}");
//! # Ok::<(), nereus::echo::synth::SynthError>(())
//! ```

use std::f64::consts::PI;

use super::SynthError;
use crate::units::GAUSS_16;

/// Widths there are, cells.
pub const WIDTHS: std::ops::RangeInclusive<usize> = 2..=8;
/// Oversampling that is allowed.
pub const OVERSAMPLINGS: std::ops::RangeInclusive<f64> = 1.5..=8.0;
/// Most coefficients of an even or odd part.
pub const MAX_TERMS: usize = 4;

/// Coefficients in the even part of each tap, and in the odd one: the degree is twice that less one. More
/// would lessen the error by 1.5 dB at most.
pub const fn terms(width: usize) -> usize {
    match width {
        2..=4 => 2,
        5 | 6 => 3,
        _ => MAX_TERMS,
    }
}

/// A spreading kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    width: usize,
    /// `[tap][part][term]` for taps `0 .. ceil(w/2)`: coefficients of `z^(2 term)` (part 0) and
    /// `z^(2 term + 1)` (part 1). The odd part of the middle tap is zero.
    coefficients: Vec<[Vec<f64>; 2]>,
}

impl Kernel {
    /// The kernel of a width, for a grid of `oversampling` cells per sample.
    ///
    /// # Errors
    /// A width or an oversampling out of range.
    pub fn new(width: usize, oversampling: f64) -> Result<Self, SynthError> {
        if !WIDTHS.contains(&width) {
            return Err(SynthError::Width { width });
        }
        if !OVERSAMPLINGS.contains(&oversampling) {
            return Err(SynthError::Oversampling { oversampling });
        }
        Ok(Self::with_terms(width, oversampling, terms(width)))
    }

    /// The same of so many terms.
    fn with_terms(width: usize, oversampling: f64, terms: usize) -> Self {
        let w = width as f64;
        let beta = 0.97 * PI * w * (1.0 - 0.5 / oversampling);
        let phi = |u: f64| {
            let x = 2.0 * u / w;
            (beta * ((1.0 - x * x).max(0.0).sqrt() - 1.0)).exp()
        };
        let coefficients = (0..width.div_ceil(2)).map(|tap| {
            let middle = tap as f64 - 0.5 * (w - 1.0);
            let part = |sign: f64| move |z: f64| 0.5 * (phi(z + middle) + sign * phi(middle - z));
            let has_odd = 2 * tap + 1 != width;
            let odd = if has_odd { in_squares(part(-1.0), 1, terms) } else { vec![0.0; terms] };
            [in_squares(part(1.0), 0, terms), odd]
        });
        Self { width, coefficients: coefficients.collect() }
    }

    /// Coefficients `[tap][part][term]` of the first half of the taps.
    pub(super) fn coefficients(&self) -> impl Iterator<Item = [[f64; MAX_TERMS]; 2]> + use<'_> {
        let padded = |part: &Vec<f64>| std::array::from_fn(|term| part.get(term).copied().unwrap_or(0.0));
        self.coefficients.iter().map(move |parts| parts.each_ref().map(padded))
    }

    /// Weight of tap `t` at `z` in `[-1/2, 1/2]`.
    pub fn weight(&self, tap: usize, z: f64) -> f64 {
        let (tap, z) = if 2 * tap < self.width { (tap, z) } else { (self.width - 1 - tap, -z) };
        let sum = |c: &[f64]| c.iter().rev().fold(0.0, |s, c| s * z * z + c);
        let [even, odd] = &self.coefficients[tap];
        sum(even) + z * sum(odd)
    }

    /// `phihat`, cells, at a frequency in cycles per cell.
    pub fn transform(&self, cycles: f64) -> f64 {
        // Gauss-Legendre, 16 points on each tap: exact to degree 31, which leaves below 1e-15 of polynomial
        // times cosine up to a cycle and a half per cell, 1e-8 of the images at four.
        let mut sum = 0.0;
        for tap in 0..self.width {
            let middle = tap as f64 - 0.5 * (self.width as f64 - 1.0);
            for (x, weight) in GAUSS_16 {
                for z in [0.5 * x, -0.5 * x] {
                    sum += 0.5 * weight * self.weight(tap, z) * (2.0 * PI * cycles * (z + middle)).cos();
                }
            }
        }
        sum
    }

    /// Expected `|error|^2 / |echo|^2` of gridding; `band` holds a pulse's
    /// `(frequency in cycles per cell, |Q|^2)`.
    pub fn gridding_error_power(&self, band: &[(f64, f64)]) -> f64 {
        let (mut wrong, mut all) = (0.0, 0.0);
        for &(cycles, power) in band {
            let own = self.transform(cycles);
            // Images beyond the third fall off as the cube of their number and add below 1 %.
            let images: f64 = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0]
                .map(|q| (self.transform(cycles + q) / own).powi(2))
                .iter()
                .sum();
            wrong += power * images;
            all += power;
        }
        if all > 0.0 { wrong / all } else { 0.0 }
    }
}

/// Coefficients `c_i` of `f(z) = z^parity sum_{i < n} c_i z^(2i)` through the positive half of `2n` Chebyshev
/// points of `[-1/2, 1/2]`.
fn in_squares(f: impl Fn(f64) -> f64, parity: i32, n: usize) -> Vec<f64> {
    let nodes: Vec<f64> = (0..n).map(|i| 0.5 * (PI * (i as f64 + 0.5) / (2 * n) as f64).cos()).collect();
    // Newton's divided differences in s = z^2, then expanded.
    let s: Vec<f64> = nodes.iter().map(|z| z * z).collect();
    let mut newton: Vec<f64> = nodes.iter().map(|z| f(*z) / z.powi(parity)).collect();
    for level in 1..n {
        for i in (level..n).rev() {
            newton[i] = (newton[i] - newton[i - 1]) / (s[i] - s[i - level]);
        }
    }
    let mut c = vec![0.0; n];
    for i in (0..n).rev() {
        for k in (1..n).rev() {
            c[k] = c[k - 1] - s[i] * c[k];
        }
        c[0] = newton[i] - s[i] * c[0];
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Terms with which polynomials are the kernel.
    const MANY: usize = 7;

    #[test]
    fn weights_are_the_kernel() {
        for width in WIDTHS {
            let kernel = Kernel::with_terms(width, 2.0, MANY);
            let w = width as f64;
            let beta = 0.97 * PI * 0.75 * w;
            let mut worst = 0.0f64;
            for tap in 0..width {
                for i in -50..=50 {
                    let z = f64::from(i) / 100.0;
                    let x = 2.0 * (z + tap as f64 - 0.5 * (w - 1.0)) / w;
                    let phi = (beta * ((1.0 - x * x).max(0.0).sqrt() - 1.0)).exp();
                    worst = worst.max((kernel.weight(tap, z) - phi).abs());
                }
            }
            println!("width {width}: misfit {worst:.1e}, e^-beta {:.1e}", (-beta).exp());
            // At its ends the kernel drops by e^-beta with a vertical tangent that no polynomial follows.
            assert!(worst < 10.0 * (-beta).exp(), "{width}: {worst}");
        }
    }

    /// Of few terms and of as many as make no difference, bands from narrow to wide.
    #[test]
    fn few_terms_are_enough() {
        for (width, oversampling, half) in WIDTHS
            .flat_map(|w| [2.0, 3.0, 4.0].into_iter().flat_map(move |s| [0.2, 0.3, 0.42].map(|b| (w, s, b))))
        {
            let cycles = (-30..=30).map(|k| f64::from(k) / 30.0 * half / oversampling);
            let band: Vec<(f64, f64)> = cycles.map(|cycles| (cycles, 1.0)).collect();
            let [few, many] = [terms(width), MANY].map(|terms| {
                let kernel = Kernel::with_terms(width, oversampling, terms);
                10.0 * kernel.gridding_error_power(&band).log10()
            });
            println!("width {width}, {oversampling} cells, band {half}: {few:.1} and {many:.1} dB");
            assert!(few < many + 1.5, "width {width}, {oversampling}, {half}: {few} {many}");
        }
    }

    #[test]
    fn gridding_errors_are_those_measured_elsewhere() {
        // docs/physics.md section 15.4: relative rms of 5000 scatterers at 100 MHz, sigma = 2; of 300 up to
        // width 4 (tests/agreement/synth_error.rs). Within 1 dB for what the flat band and the sample of
        // scatterers leave open.
        for (width, measured_db) in
            [(2, -30.9), (3, -51.2), (4, -72.2), (5, -89.9), (6, -110.0), (7, -130.0), (8, -149.0)]
        {
            let kernel = Kernel::new(width, 2.0).unwrap();
            let band: Vec<(f64, f64)> = (-30..=30).map(|k| (f64::from(k) / 200.0, 1.0)).collect();
            let db = 10.0 * kernel.gridding_error_power(&band).log10();
            println!("width {width}: {db:.1} dB, measured {measured_db}");
            assert!((db - measured_db).abs() < 1.0, "{db}");
        }
    }

    #[test]
    fn widths_and_oversamplings_out_of_range_are_refused() {
        for (width, oversampling) in [(1, 2.0), (9, 2.0), (5, 1.4), (5, f64::NAN), (5, f64::INFINITY)] {
            assert!(Kernel::new(width, oversampling).is_err());
        }
    }
}
