//! Fits by maximum likelihood.
//!
//! * K law: scoring in `s = ln(1 + 1/nu)` and the logarithm of the mean power, by the information of the
//!   sample itself (the mean of the products of the scores), halved steps where a whole one loses. `s` is
//!   even for large shapes, where the law is linear in `1/nu`, and for small ones, where it goes by `ln nu`.
//!   Shapes below 0.01 are reported as that, those above 10 000 as infinite. Errors are those of the
//!   information at the end.
//! * Weibull law: `sum z^c ln z / sum z^c - 1/c = <ln z>`; errors are those of Fisher's information,
//!   `c sqrt(6/n)/pi` of the shape.
//! * Rayleigh law: the mean power, `1/sqrt(n)`.

use super::bessel::{digamma, ln_bessel_k};
use super::laws::{Kind, Law};
use super::moments::{WEIBULL_SHAPES, bisect};
use super::sample::Bins;
use super::{Fit, Sample};

/// Bounds of `ln(1 + 1/nu)`.
pub(super) const S_RANGE: [f64; 2] = [1e-4, 4.615_120_516_841_26];
/// Most steps; a dozen are usual.
const MOST_STEPS: usize = 100;

/// Fits a law.
pub fn fit(sample: &Sample, kind: Kind) -> Fit {
    let mut fit = of_bins(&sample.bins, kind);
    // Bins hold powers over their mean.
    fit.law = Law::new(kind, fit.law.shape(), fit.law.mean_power() * sample.mean_power());
    fit
}

pub(super) fn of_bins(bins: &Bins, kind: Kind) -> Fit {
    match kind {
        Kind::K => k(bins),
        Kind::Weibull => weibull(bins),
        Kind::Rayleigh => rayleigh(bins),
    }
}

fn rayleigh(bins: &Bins) -> Fit {
    let law = Law::new(Kind::Rayleigh, 2.0, bins.ln_mean_power().exp());
    Fit { law, shape_error: 0.0, inverse_error: 0.0, power_error: bins.count().sqrt().recip() }
}

fn weibull(bins: &Bins) -> Fit {
    let n = bins.count();
    let top = bins.filled().map(|[_, u]| u).fold(f64::NEG_INFINITY, f64::max);
    let mean = bins.filled().map(|[count, u]| count * u).sum::<f64>() / n;
    let sums = |shape: f64| {
        bins.filled().fold([0.0; 2], |[powers, logs], [count, u]| {
            let power = count * (shape * (u - top)).exp();
            [powers + power, logs + power * u]
        })
    };
    let [low, high] = WEIBULL_SHAPES.map(f64::ln);
    let rising = |ln_shape: f64| {
        let shape = ln_shape.exp();
        let [powers, logs] = sums(shape);
        logs / powers - 1.0 / shape - mean
    };
    let shape = bisect(low, high, rising).exp();
    let ln_scale = top + (sums(shape)[0] / n).ln() / shape;
    let law = super::WeibullLaw { shape, scale: ln_scale.exp() };
    // Fisher's information of the Weibull law: variances of c and ln a and what they share, times n.
    let pi2 = std::f64::consts::PI.powi(2);
    let euler = 0.577_215_664_901_532_9;
    let of_shape = 6.0 * shape * shape / pi2;
    let of_scale = (1.0 + 6.0 * (1.0 - euler) * (1.0 - euler) / pi2) / (shape * shape);
    let shared = 6.0 * (1.0 - euler) / pi2;
    let slope = -2.0 / (shape * shape) * digamma(1.0 + 2.0 / shape);
    let of_power = 4.0 * of_scale + slope * slope * of_shape + 4.0 * slope * shared;
    Fit {
        law: Law::Weibull(law),
        shape_error: (of_shape / n).sqrt(),
        inverse_error: 0.0,
        power_error: (of_power.max(0.0) / n).sqrt(),
    }
}

/// Shape of `s = ln(1 + 1/nu)`.
pub(super) fn shape_of(s: f64) -> f64 {
    s.exp_m1().recip()
}

/// Log likelihood of a K law, its slopes over `s` and the logarithm of the mean power, and the sums of their
/// products.
struct Score {
    ln: f64,
    slopes: [f64; 2],
    information: [f64; 3],
}

impl Score {
    fn of(bins: &Bins, [s, ln_power]: [f64; 2]) -> Self {
        let nu = shape_of(s);
        let ln_half_scale = 0.5 * (nu.ln() - ln_power);
        let (ln_gamma, psi) = (libm::lgamma(nu), digamma(nu));
        let mut score = Self { ln: 0.0, slopes: [0.0; 2], information: [0.0; 3] };
        for [count, u] in bins.filled() {
            // Density of ln z: 4 (x/2)^{nu+1} K_{nu-1}(x) / G(nu), x = b z.
            let ln_half_x = (u + ln_half_scale).max(-700.0);
            let bessel = ln_bessel_k(nu - 1.0, 2.0 * ln_half_x.exp());
            let by_ln_x = nu + 1.0 + bessel.by_ln_x;
            let by_shape = ln_half_x + bessel.by_order - psi + by_ln_x * 0.5 / nu;
            let slopes = [-nu * (nu + 1.0) * by_shape, -0.5 * by_ln_x];
            score.ln += count * ((nu + 1.0) * ln_half_x + bessel.ln - ln_gamma);
            for (sum, slope) in score.slopes.iter_mut().zip(slopes) {
                *sum += count * slope;
            }
            let products = [slopes[0] * slopes[0], slopes[0] * slopes[1], slopes[1] * slopes[1]];
            for (sum, product) in score.information.iter_mut().zip(products) {
                *sum += count * product;
            }
        }
        // The factor of 4, which Rayleigh's law has not.
        score.ln += bins.count() * 4f64.ln();
        score
    }

    /// The whole step; along the power alone where the shape is held.
    fn step(&self, held: bool) -> [f64; 2] {
        let [a, b, d] = self.information;
        let determinant = a * d - b * b;
        let [f, g] = self.slopes;
        if held || determinant <= 1e-12 * a * d {
            return [0.0, if d > 0.0 { g / d } else { 0.0 }];
        }
        [(d * f - b * g) / determinant, (a * g - b * f) / determinant]
    }

    /// Variances of both.
    fn variances(&self) -> [f64; 2] {
        let [a, b, d] = self.information;
        let determinant = a * d - b * b;
        if determinant > 1e-12 * a * d { [d / determinant, a / determinant] } else { [f64::INFINITY; 2] }
    }
}

/// Log likelihood of Rayleigh's law at its best.
fn ln_rayleigh(bins: &Bins) -> f64 {
    let ln_power = bins.ln_mean_power();
    bins.filled()
        .map(|[count, u]| count * (2f64.ln() + 2.0 * u - ln_power - (2.0 * u - ln_power).exp()))
        .sum()
}

fn k(bins: &Bins) -> Fit {
    let n = bins.count();
    // The variance of ln I is pi^2/6 + psi'(nu), some 1/nu + 1/2 nu^2 more: no outlier corrupts that for a
    // start.
    let mean = bins.filled().map(|[count, u]| count * u).sum::<f64>() / n;
    let variance = 4.0 * bins.filled().map(|[count, u]| count * (u - mean) * (u - mean)).sum::<f64>() / n;
    let more = (variance - std::f64::consts::PI.powi(2) / 6.0).max(0.05);
    let clamped = |s: f64| s.clamp(S_RANGE[0], S_RANGE[1]);
    let mut at = [clamped((1.0 + 2.0 * more).sqrt().ln()), bins.ln_mean_power()];
    let mut score = Score::of(bins, at);
    for _ in 0..MOST_STEPS {
        let outward =
            (at[0] <= S_RANGE[0] && score.slopes[0] < 0.0) || (at[0] >= S_RANGE[1] && score.slopes[0] > 0.0);
        let step = score.step(outward);
        // What the step may gain, in the unit of the logarithm: 1e-9 is 3e-5 of a standard error.
        let gain = step[0] * score.slopes[0] + step[1] * score.slopes[1];
        if !gain.is_finite() || gain < 1e-9 {
            break;
        }
        let shorter = (step[0].abs() / 0.7).max(step[1].abs() / 1.5).max(1.0).recip();
        let tries = (0..30).map(|halvings| shorter * 0.5f64.powi(halvings));
        let better = tries
            .map(|share| [clamped(at[0] + share * step[0]), at[1] + share * step[1]])
            .map(|at| (at, Score::of(bins, at)))
            .find(|(_, tried)| tried.ln > score.ln);
        let Some((next, tried)) = better else { break };
        (at, score) = (next, tried);
    }
    if at[0] <= S_RANGE[0] || score.ln <= ln_rayleigh(bins) {
        // The score over 1/nu is Laguerre's polynomial L_2 of the power there: its variance is 1.
        return Fit {
            law: Law::new(Kind::K, f64::INFINITY, bins.ln_mean_power().exp()),
            shape_error: f64::INFINITY,
            inverse_error: n.sqrt().recip(),
            power_error: n.sqrt().recip(),
        };
    }
    let [of_s, of_power] = score.variances();
    let shape = shape_of(at[0]);
    Fit {
        law: Law::new(Kind::K, shape, at[1].exp()),
        shape_error: shape * (shape + 1.0) * of_s.sqrt(),
        inverse_error: (1.0 + 1.0 / shape) * of_s.sqrt(),
        power_error: of_power.sqrt(),
    }
}
