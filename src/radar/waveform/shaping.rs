//! What makes a continuous signal of samples: an interpolation of finite length.
//!
//! ```text
//! s(t) = sum_j s_j h(R t - j)
//! h(u) = sinc(u) I0(b sqrt(1 - (u/K)^2)) / I0(b)   |u| < K = 20 ,   b = 10.5
//! H(v) = int h(u) e^{-j 2 pi v u} du
//! ```
//!
//! `H` is 1 within 1e-5 up to `|v| = 0.416` cycles a sample, one half at 0.5, and below 1e-5 from 0.584 on
//! (Kaiser's window, 104 dB). `h` is 1 at 0 and 0 at all other whole numbers: the signal passes through its
//! samples. As `h` ends, a signal that is cut into segments is exactly the sum of these, each with the tails
//! of its samples.

use std::f64::consts::PI;
use std::sync::OnceLock;

use num_complex::Complex64;

use super::gridded::lagrange;
use crate::units::GAUSS_16;

/// Samples that the interpolation reaches to either side.
pub const REACH: usize = 20;
/// `b`.
const SHAPE: f64 = 10.5;
/// Values of `h` a sample, from which its transform is found.
const FINE: usize = 16;
/// Values of `H` from 0 to 1.
const STEPS: usize = 10_240;

/// `h(u)`.
pub fn kernel(u: f64) -> f64 {
    let inside = 1.0 - (u / REACH as f64).powi(2);
    if inside <= 0.0 {
        return 0.0;
    }
    let sinc = if u == 0.0 { 1.0 } else { (PI * u).sin() / (PI * u) };
    sinc * bessel(SHAPE * inside.sqrt()) / bessel(SHAPE)
}

/// `I0(x)`, by its power series.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for n in 1..60 {
        term *= (0.5 * x / f64::from(n)).powi(2);
        sum += term;
    }
    sum
}

/// `H(v)` and `H'(v)`, real; 0 beyond one cycle a sample.
#[inline(always)]
pub fn response(v: f64) -> [f64; 2] {
    let place = v.abs() * STEPS as f64;
    if place >= STEPS as f64 || place.is_nan() {
        return [0.0; 2];
    }
    let at = place as usize;
    let x = place - at as f64;
    let Some(values) = table().get(at..at + 4) else { return [0.0; 2] };
    let weights = lagrange(x);
    let value: f64 = weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
    // Derivatives of the four weights.
    let of = [
        -(3.0 * x * x - 6.0 * x + 2.0) / 6.0,
        (3.0 * x * x - 4.0 * x - 1.0) / 2.0,
        -(3.0 * x * x - 2.0 * x - 2.0) / 2.0,
        (3.0 * x * x - 1.0) / 6.0,
    ];
    let slope: f64 = of.iter().zip(values).map(|(weight, value)| weight * value).sum();
    [value, slope * STEPS as f64 * v.signum()]
}

/// `int |h|^2 du`: the mean power that samples without relation to each other keep.
pub fn white_power() -> f64 {
    static POWER: OnceLock<f64> = OnceLock::new();
    *POWER.get_or_init(|| {
        let reach = (REACH * FINE) as i32;
        (-reach..=reach).map(|i| kernel(f64::from(i) / FINE as f64).powi(2)).sum::<f64>() / FINE as f64
    })
}

/// `int h(u) h(u - k) du` for `k = 0 ..= 2 K`: two samples that lie `k` apart add to the mean power by that.
pub fn overlaps() -> Vec<f64> {
    let of: Vec<f64> =
        (0..=2 * REACH * FINE).map(|i| kernel(i as f64 / FINE as f64 - REACH as f64)).collect();
    let apart = |k: usize| of.iter().skip(k * FINE).zip(&of).map(|(a, b)| a * b).sum::<f64>() / FINE as f64;
    (0..=2 * REACH).map(apart).collect()
}

/// `int h(u) du` from one whole number to the next, from `-K` on.
pub fn areas() -> Vec<f64> {
    let half = |middle: f64, (x, weight): &(f64, f64)| {
        0.5 * weight * (kernel(middle + 0.5 * x) + kernel(middle - 0.5 * x))
    };
    let of = |i: usize| {
        let middle = i as f64 + 0.5 - REACH as f64;
        GAUSS_16.iter().map(|node| half(middle, node)).sum()
    };
    (0..2 * REACH).map(of).collect()
}

/// `H` from one step before 0 to two beyond 1.
fn table() -> &'static [f64] {
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let len = STEPS * FINE;
        let mut values = vec![Complex64::ZERO; len];
        let reach = (REACH * FINE) as isize;
        for i in -reach..=reach {
            values[i.rem_euclid(len as isize) as usize] =
                Complex64::from(kernel(i as f64 / FINE as f64) / FINE as f64);
        }
        nereus_fft::forward(len).process(&mut values);
        (-1..STEPS as isize + 3).map(|m| values[m.rem_euclid(len as isize) as usize].re).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_flat_and_images_are_gone() {
        for i in 0..=416 {
            let [value, _] = response(f64::from(i) * 1e-3);
            assert!((value - 1.0).abs() < 1e-5, "{i}: {value}");
        }
        assert!((response(0.5)[0] - 0.5).abs() < 1e-5);
        for i in 584..1000 {
            assert!(response(f64::from(-i) * 1e-3)[0].abs() < 1e-5, "{i}");
        }
        assert_eq!(response(1.0), [0.0; 2]);
    }

    #[test]
    fn the_slope_is_that_of_the_response() {
        for v in [-0.55, -0.47, 0.43, 0.5, 0.56] {
            let step = 1e-5;
            let wanted = (response(v + step)[0] - response(v - step)[0]) / (2.0 * step);
            assert!((response(v)[1] - wanted).abs() < 1e-4, "{v}: {} {wanted}", response(v)[1]);
        }
    }
}
