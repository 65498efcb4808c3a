//! Fits by the first two moments of the power: `<I^2>/<I>^2` of the law is that of the sample.
//!
//! The error of the shape is that of the contrast times the slope of the shape over it: to first order, and
//! with a fourth moment that few samples of a spiky law make too small. A K law cannot vary less than
//! Rayleigh's: its shape is then infinite. Shapes of Weibull laws are held to 0.05 .. 1000.

use libm::lgamma;

use super::bessel::digamma;
use super::laws::{Kind, Law};
use super::{Fit, Sample};

/// Shapes of Weibull laws that are reported.
pub(super) const WEIBULL_SHAPES: [f64; 2] = [0.05, 1000.0];

/// Logarithm of `<I^2>/<I>^2` of a Weibull law.
fn ln_contrast(shape: f64) -> f64 {
    lgamma(1.0 + 4.0 / shape) - 2.0 * lgamma(1.0 + 2.0 / shape)
}

/// Fits a law.
pub fn fit(sample: &Sample, kind: Kind) -> Fit {
    let (contrast, contrast_error) = (sample.contrast(), sample.contrast_error());
    let (mean_power, n) = (sample.mean_power(), sample.len() as f64);
    let power_error = ((contrast - 1.0).max(0.0) / n).sqrt();
    match kind {
        Kind::K => {
            let shape = if contrast > 2.0 { 2.0 / (contrast - 2.0) } else { f64::INFINITY };
            let inverse_error = 0.5 * contrast_error;
            let shape_error = if contrast > 2.0 { inverse_error * shape * shape } else { f64::INFINITY };
            Fit { law: Law::new(kind, shape, mean_power), shape_error, inverse_error, power_error }
        }
        Kind::Weibull => {
            let [low, high] = WEIBULL_SHAPES.map(f64::ln);
            // The contrast falls as the shape grows.
            let ln_shape = bisect(low, high, |ln_shape| contrast.ln() - ln_contrast(ln_shape.exp()));
            let shape = ln_shape.exp();
            let slope = 4.0 / (shape * shape) * (digamma(1.0 + 4.0 / shape) - digamma(1.0 + 2.0 / shape));
            let shape_error = contrast_error / (contrast * slope);
            Fit { law: Law::new(kind, shape, mean_power), shape_error, inverse_error: 0.0, power_error }
        }
        Kind::Rayleigh => {
            Fit { law: Law::new(kind, 2.0, mean_power), shape_error: 0.0, inverse_error: 0.0, power_error }
        }
    }
}

/// Where a rising function passes zero; the end nearest to it where it does not.
pub(super) fn bisect(mut low: f64, mut high: f64, rising: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if rising(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
