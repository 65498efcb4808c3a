//! The auxiliary function of the Fresnel integrals.
//!
//! ```text
//! w(u) = g(u) + j f(u) = exp(-j pi u^2/2) int_u^inf exp(j pi t^2/2) dt ,   u >= 0
//! C(u) + j S(u) = (1 + j)/2 - exp(j pi u^2/2) w(u)
//! ```
//!
//! (`f`, `g` as in NIST DLMF 7.2(iv).) It falls monotonically from `(1+j)/2` to `j/(pi u)`: all oscillation
//! is in the factor. Turning the path of integration by 45 degrees and putting `s = 1/(1+u)` gives
//!
//! ```text
//! w(u) = s W(s) ,  W(s) = e^{j pi/4} int_0^inf exp(-(pi/2) s^2 x^2 - (1-j)(pi/sqrt 2)(1-s) x) dx ,  0 <= s <= 1
//! ```
//!
//! which is smooth on the whole of [0, 1]. `W` is tabulated from this integral (double-exponential
//! rule) once per process, as polynomials on equal intervals of `s`: relative accuracy 2e-14 for
//! every `u >= 0`.

use std::sync::LazyLock;

use num_complex::Complex64;

/// Intervals of `s`.
const INTERVALS: usize = 128;
/// Coefficients of a polynomial.
const TERMS: usize = 8;

/// One interval: coefficients of powers of `2 x - 1`, `x` the place within it.
type Piece = [[f64; 2]; TERMS];

static PIECES: LazyLock<Vec<Piece>> = LazyLock::new(|| (0..INTERVALS).map(piece).collect());

/// The table, built at the first call.
pub(super) fn table() -> &'static [Piece] {
    &PIECES
}

/// `w(u)` from the table, `u >= 0`.
#[inline(always)]
pub(super) fn auxiliary(pieces: &[Piece], u: f64) -> Complex64 {
    let s = 1.0 / (1.0 + u);
    let place = s * INTERVALS as f64;
    let index = (place as usize).min(INTERVALS - 1);
    let Some(c) = pieces.get(index) else { return Complex64::ZERO };
    let x = 2.0 * (place - index as f64) - 1.0;
    let x2 = x * x;
    let mut w = [0.0; 2];
    for (part, w) in w.iter_mut().enumerate() {
        let even = ((c[6][part] * x2 + c[4][part]) * x2 + c[2][part]) * x2 + c[0][part];
        let odd = ((c[7][part] * x2 + c[5][part]) * x2 + c[3][part]) * x2 + c[1][part];
        *w = s * (even + x * odd);
    }
    Complex64::new(w[0], w[1])
}

/// `W(s)` from its integral, with `x = exp(y - exp(-y))`: the integrand then dies doubly exponentially at
/// both ends and the trapezoid rule converges exponentially.
fn integral(s: f64) -> Complex64 {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};
    const STEP: f64 = 1.0 / 32.0;
    let rate = PI * FRAC_1_SQRT_2 * (1.0 - s);
    let mut sum = Complex64::ZERO;
    // y = -4: x = 1e-26. y = 5: x = 147, where the exponent is below -600 for every s.
    for i in -128..=160 {
        let y = f64::from(i) * STEP;
        let x = (y - (-y).exp()).exp();
        let dx = x * (1.0 + (-y).exp());
        sum += Complex64::from_polar((-FRAC_PI_2 * (s * x).powi(2) - rate * x).exp() * dx, rate * x);
    }
    sum * STEP * Complex64::new(FRAC_1_SQRT_2, FRAC_1_SQRT_2)
}

/// Chebyshev interpolation on one interval, as powers.
fn piece(index: usize) -> Piece {
    let n = TERMS as f64;
    let node = |i: usize| (std::f64::consts::PI * (i as f64 + 0.5) / n).cos();
    let values: Vec<Complex64> =
        (0..TERMS).map(|i| integral((index as f64 + 0.5 * (node(i) + 1.0)) / INTERVALS as f64)).collect();
    // T_m as powers of x, by T_{m+1} = 2 x T_m - T_{m-1}.
    let mut chebyshev = [[0.0; TERMS]; TERMS];
    chebyshev[0][0] = 1.0;
    chebyshev[1][1] = 1.0;
    for m in 2..TERMS {
        for power in 0..TERMS {
            let shifted = if power == 0 { 0.0 } else { 2.0 * chebyshev[m - 1][power - 1] };
            chebyshev[m][power] = shifted - chebyshev[m - 2][power];
        }
    }
    let mut coefficients = [[0.0; 2]; TERMS];
    for (m, polynomial) in chebyshev.iter().enumerate() {
        let mut a = Complex64::ZERO;
        for (i, value) in values.iter().enumerate() {
            a += value * (std::f64::consts::PI * m as f64 * (i as f64 + 0.5) / n).cos();
        }
        a *= if m == 0 { 1.0 / n } else { 2.0 / n };
        for (power, factor) in polynomial.iter().enumerate() {
            coefficients[power][0] += a.re * factor;
            coefficients[power][1] += a.im * factor;
        }
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;
    use errorfunctions::ComplexErrorFunctions;

    /// `w(u) = (1+j)/2 wofz(z)`, `z = sqrt(pi)/2 (1+j)... u`: exp(-z^2) erfc(-j z) with
    /// `erfc(sqrt(pi)/2 (1-j) u)`, an independent implementation (Faddeeva package).
    fn faddeeva(u: f64) -> Complex64 {
        let z =
            Complex64::new(0.0, 1.0) * Complex64::new(1.0, -1.0) * (std::f64::consts::PI.sqrt() / 2.0 * u);
        Complex64::new(0.5, 0.5) * z.w()
    }

    #[test]
    fn agrees_with_the_complex_error_function() {
        let mut worst = (0.0f64, 0.0);
        for i in 0..=60_000 {
            // 0, then 1e-9 ... 1e9, many per interval.
            let u = if i == 0 { 0.0 } else { 10f64.powf(f64::from(i) * 3e-4 - 9.0) };
            let expected = faddeeva(u);
            let error = (auxiliary(table(), u) - expected).norm() / expected.norm();
            if error > worst.0 {
                worst = (error, u);
            }
        }
        println!("worst relative error of w(u): {:.2e} at u = {:.3e}", worst.0, worst.1);
        // Interpolation: next Chebyshev term on 1/128 of the range is below 1e-16; the rest is rounding of
        // the 290-term quadrature and of the other library (its stated accuracy is 1e-13).
        assert!(worst.0 < 1e-13, "{worst:?}");
    }

    #[test]
    fn ends_of_the_range() {
        assert!((auxiliary(table(), 0.0) - Complex64::new(0.5, 0.5)).norm() < 1e-15);
        assert_eq!(auxiliary(table(), f64::INFINITY), Complex64::ZERO);
        let far = auxiliary(table(), 1e12) * (std::f64::consts::PI * 1e12);
        assert!((far - Complex64::new(0.0, 1.0)).norm() < 1e-13, "{far}");
    }
}
