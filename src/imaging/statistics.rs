//! Laws of clutter amplitude, and their parameters from samples.
//!
//! K law of the amplitude `z` (compound Gaussian: speckle on a gamma-distributed local power), shape `nu`, scale `b`:
//!
//! ```text
//! p(z) = (2 b / G(nu)) (b z / 2)^nu K_{nu-1}(b z),   P(z) = 1 - (2 / G(nu)) (b z / 2)^nu K_nu(b z)
//! <z^2> = 4 nu / b^2,   <I^2>/<I>^2 = 2 (1 + 1/nu),  I = z^2
//! ```
//!
//! `K_nu` by the trapezoidal rule on `int_0^inf exp(-x cosh t) cosh(nu t) dt`, which converges faster than any power of the step, over the peak of the
//! integrand alone: it is `1/sqrt(hypot(nu, x))` wide. Above `nu` of some 10 the law is hardly told from Rayleigh's; an infinite shape is Rayleigh's.
//!
//! Limits: shapes from 0.01; rounding leaves `2^-52 nu ln nu` of density and tail, 2e-11 at 1e4. Only the fit by moments is here.
//!
//! Sources: K. D. Ward, Electron. Lett. 17, 561 (1981); K. D. Ward, S. Watts, IEE Proc. F 137, 51 (1990) for the shape of sea clutter at low
//! grazing angles ([`sea_shape`]).
//!
//! ```
//! use nereus::imaging::statistics::{KLaw, sea_shape};
//! let law = KLaw { shape: 0.5, scale: 1.0 };
//! // Shape 1/2 is the exponential law.
//! assert!((law.density(0.3) - (-0.3f64).exp()).abs() < 1e-12);
//! assert!((sea_shape(1.0, [1.0, 0.75], 0.0, true) - 1.5814e-2).abs() < 1e-6);
//! ```

use libm::lgamma;

/// The K law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KLaw {
    /// `nu`, above 0; infinite for Rayleigh's law.
    pub shape: f64,
    /// `b`, over the unit of the amplitude; `b/sqrt(nu) = 2/sqrt(<z^2>)` where the shape is infinite.
    pub scale: f64,
}

/// A K law found from samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KFit {
    /// The law; its shape is infinite where the samples vary no more than Rayleigh's.
    pub law: KLaw,
    /// Standard error of the shape, for independent samples.
    pub shape_error: f64,
    /// `<I^2>/<I>^2`: 2 for Rayleigh.
    pub contrast: f64,
    /// Its standard error.
    pub contrast_error: f64,
    /// Samples.
    pub samples: usize,
}

/// Logarithm of `K_nu(x)`, `x` above 0 and finite.
fn ln_bessel_k(order: f64, x: f64) -> f64 {
    let order = order.abs();
    // The integrand peaks where x sinh t = nu; there x cosh t is the hypotenuse, and so is the curvature of its logarithm.
    let hypotenuse = order.hypot(x);
    let ratio = order / x;
    let peak = if ratio < 1.0 { ratio.asinh() } else { (order + hypotenuse).ln() - x.ln() };
    let width = hypotenuse.sqrt().recip();
    // Fall of the logarithm at a distance from the peak, without differences of large numbers.
    let fall = |away: f64| {
        if away > -1.0 {
            hypotenuse * (2.0 * (0.5 * away).sinh().powi(2)) + order * (away.sinh() - away)
        } else {
            let (t, ln_x) = (peak + away, x.ln());
            0.5 * ((ln_x + t).exp() + (ln_x - t).exp()) - hypotenuse - order * away
        }
    };
    // Gone where it has fallen by e^-45. To the left it may fall as slowly as e^(nu t), to the right as e^(-x cosh t).
    let reach = |step: f64, most: f64| {
        let mut away = step;
        while away.abs() < most && fall(away) < 45.0 {
            away += step;
        }
        away
    };
    let begin = reach(-width, peak).max(-peak);
    let end = reach(width.min(0.5), f64::INFINITY);
    let steps = 600;
    let h = (end - begin) / f64::from(steps);
    let term = |i: i32| {
        let away = begin + h * f64::from(i);
        // cosh(nu t) = e^{nu t} (1 + e^{-2 nu t})/2
        (-fall(away)).exp() * 0.5 * (1.0 + (-2.0 * order * (peak + away)).exp())
    };
    // Half of the first: the integrand is even about zero, or gone where the sum begins.
    let sum: f64 = 0.5 * term(0) + (1..=steps).map(term).sum::<f64>();
    order * peak - hypotenuse + (h * sum).ln()
}

impl KLaw {
    /// Density of an amplitude.
    pub fn density(&self, z: f64) -> f64 {
        let Self { shape, scale } = *self;
        if z <= 0.0 {
            return 0.0;
        }
        let x = scale * z;
        if shape == f64::INFINITY {
            return 0.5 * scale * x * (-0.25 * x * x).exp();
        }
        if x == f64::INFINITY {
            return 0.0;
        }
        let x = x.max(f64::MIN_POSITIVE);
        let ln = (2.0 * scale).ln() - lgamma(shape) + shape * (0.5 * x).ln() + ln_bessel_k(shape - 1.0, x);
        ln.exp()
    }

    /// Probability that an amplitude is not larger.
    pub fn probability(&self, z: f64) -> f64 {
        let Self { shape, scale } = *self;
        if z <= 0.0 {
            return 0.0;
        }
        let x = scale * z;
        if shape == f64::INFINITY {
            return -(-0.25 * x * x).exp_m1();
        }
        if x == f64::INFINITY {
            return 1.0;
        }
        let x = x.max(f64::MIN_POSITIVE);
        let ln = std::f64::consts::LN_2 - lgamma(shape) + shape * (0.5 * x).ln() + ln_bessel_k(shape, x);
        (1.0 - ln.exp()).clamp(0.0, 1.0)
    }

    /// Finds the law from powers `I = z^2` by their first two moments. The error of the shape is that of the contrast, from the first four
    /// moments of the samples, to first order: right for many independent samples. None without two samples or without power.
    pub fn by_moments(powers: &[f64]) -> Option<KFit> {
        let n = powers.len() as f64;
        let mean = powers.iter().sum::<f64>() / n;
        if powers.len() < 2 || !(mean.is_finite() && mean > 0.0) {
            return None;
        }
        // Moments of I over its mean, so that powers of 1e-15 W keep their digits.
        let moment = |order: i32| powers.iter().map(|p| (p / mean).powi(order)).sum::<f64>() / n;
        let [m2, m3, m4] = [2, 3, 4].map(moment);
        let variance = (m4 - m2 * m2) + 4.0 * m2 * m2 * (m2 - 1.0) - 4.0 * m2 * (m3 - m2);
        let contrast_error = (variance.max(0.0) / n).sqrt();
        let shape = if m2 > 2.0 { 2.0 / (m2 - 2.0) } else { f64::INFINITY };
        let shape_error = if m2 > 2.0 { contrast_error * 0.5 * shape * shape } else { f64::INFINITY };
        let scale = if shape.is_finite() { 2.0 * (shape / mean).sqrt() } else { 2.0 / mean.sqrt() };
        Some(KFit {
            law: Self { shape, scale },
            shape_error,
            contrast: m2,
            contrast_error,
            samples: powers.len(),
        })
    }
}

/// Shape of sea clutter by Ward and Watts: `log10 nu = (2/3) log10 g + (5/8) log10(D_a D_r / 4.2) - cos(2 psi)/3 - k_p`, `g` grazing angle in
/// degrees (0.1 to 10), `D_a`, `D_r` the resolution, m, `psi` from the direction of the swell, rad; `k_p` 1 for VV, 1.7 for HH.
pub fn sea_shape(grazing_deg: f64, resolution_m: [f64; 2], psi_rad: f64, vertical: bool) -> f64 {
    let polarisation = if vertical { 1.0 } else { 1.7 };
    let log = 2.0 / 3.0 * grazing_deg.log10() + 0.625 * (resolution_m[0] * resolution_m[1] / 4.2).log10()
        - (2.0 * psi_rad).cos() / 3.0
        - polarisation;
    10f64.powf(log)
}
