//! Fits to the histogram, as in the MaRS paper: the law whose density has the least squared distance from
//! that of the sample.
//!
//! The histogram has 100 bins of 0.05 of the rms amplitude; what lies beyond counts, but has no bin. The
//! density of a law over a bin is the difference of its probability over the width of the bin, so that wide
//! bins do no harm. Least squares by Gauss and Newton with damping, in `ln(1 + 1/nu)` (`ln c` of Weibull
//! laws) and the logarithm of the mean power, from the fit by maximum likelihood on.
//!
//! Errors to first order: `(J^T J)^-1 J^T` of the covariance of the counts of a histogram, `J` the slopes of
//! the densities.

use super::laws::{Kind, Law};
use super::likelihood::{self, S_RANGE, shape_of};
use super::moments::WEIBULL_SHAPES;
use super::{Fit, Sample};

/// Bins, and width of one over the rms amplitude.
pub const BINS: usize = 100;
/// Width of a bin over the rms amplitude.
pub const WIDTH: f64 = 0.05;
/// Most steps.
const MOST_STEPS: usize = 100;

/// Density of the amplitudes over their rms, in every bin.
pub fn densities(sample: &Sample) -> Vec<f64> {
    let mut counts = vec![0.0; BINS];
    for ratio in &sample.ratios {
        if let Some(count) = counts.get_mut((ratio.sqrt() / WIDTH) as usize) {
            *count += 1.0;
        }
    }
    counts.iter().map(|count| count / (sample.len() as f64 * WIDTH)).collect()
}

/// Densities of a law of mean power in the units of the bins.
fn model(law: &Law) -> Vec<f64> {
    let probability: Vec<f64> = (0..=BINS).map(|i| law.probability(i as f64 * WIDTH)).collect();
    probability.windows(2).map(|pair| (pair[1] - pair[0]) / WIDTH).collect()
}

/// A law of its parameters.
fn law(kind: Kind, [form, ln_power]: [f64; 2]) -> Law {
    let shape = match kind {
        Kind::K => shape_of(form),
        Kind::Weibull => form.exp(),
        Kind::Rayleigh => 2.0,
    };
    Law::new(kind, shape, ln_power.exp())
}

fn distance(densities: &[f64], kind: Kind, at: [f64; 2]) -> f64 {
    model(&law(kind, at)).iter().zip(densities).map(|(q, h)| (h - q) * (h - q)).sum()
}

/// Slopes of the densities over both parameters.
fn slopes(kind: Kind, at: [f64; 2]) -> Vec<[f64; 2]> {
    let along = |axis: usize| -> Vec<f64> {
        if kind == Kind::Rayleigh && axis == 0 {
            return vec![0.0; BINS];
        }
        let step = 1e-4 * if axis == 0 && kind == Kind::K { at[0].min(1.0) } else { 1.0 };
        let moved = |by: f64| {
            let mut at = at;
            at[axis] += by;
            model(&law(kind, at))
        };
        moved(step).iter().zip(moved(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
    };
    along(0).into_iter().zip(along(1)).map(|(a, b)| [a, b]).collect()
}

/// Inverse of a symmetrical 2 x 2 matrix; of its second entry alone where the first is not determined.
fn inverse([a, b, d]: [f64; 3]) -> [f64; 3] {
    let determinant = a * d - b * b;
    if determinant > 1e-14 * a * d {
        [d / determinant, -b / determinant, a / determinant]
    } else {
        [0.0, 0.0, if d > 0.0 { 1.0 / d } else { 0.0 }]
    }
}

fn squares(slopes: &[[f64; 2]]) -> [f64; 3] {
    slopes.iter().fold([0.0; 3], |[a, b, d], [x, y]| [a + x * x, b + x * y, d + y * y])
}

/// Fits a law.
pub fn fit(sample: &Sample, kind: Kind) -> Fit {
    let densities = densities(sample);
    let begin = likelihood::of_bins(&sample.bins, kind).law;
    let range = match kind {
        Kind::K => S_RANGE,
        Kind::Weibull => WEIBULL_SHAPES.map(f64::ln),
        Kind::Rayleigh => [0.0; 2],
    };
    let form = match kind {
        Kind::K => begin.shape().recip().ln_1p().max(0.05),
        Kind::Weibull => begin.shape().ln(),
        Kind::Rayleigh => 0.0,
    };
    let clamped = |form: f64| form.clamp(range[0], range[1]);
    let mut at = [clamped(form), begin.mean_power().ln()];
    let mut least = distance(&densities, kind, at);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let slopes = slopes(kind, at);
        let left: Vec<f64> = model(&law(kind, at)).iter().zip(&densities).map(|(q, h)| h - q).collect();
        let [f, g] = slopes.iter().zip(&left).fold([0.0; 2], |[f, g], ([x, y], r)| [f + x * r, g + y * r]);
        let [a, b, d] = squares(&slopes);
        let [p, q, r] = inverse([a * (1.0 + damping), b, d * (1.0 + damping)]);
        let step = [(p * f + q * g).clamp(-1.0, 1.0), (q * f + r * g).clamp(-1.0, 1.0)];
        let next = [clamped(at[0] + step[0]), at[1] + step[1]];
        let found = distance(&densities, kind, next);
        if found < least {
            let moved = (next[0] - at[0]).abs().max((next[1] - at[1]).abs());
            (at, least, damping) = (next, found, (0.1 * damping).max(1e-9));
            if moved < 1e-7 {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    let slopes = slopes(kind, at);
    let [p, q, r] = inverse(squares(&slopes));
    let share: Vec<f64> = densities.iter().map(|density| density * WIDTH).collect();
    let weights: Vec<[f64; 2]> = slopes.iter().map(|[x, y]| [p * x + q * y, q * x + r * y]).collect();
    let variance = |axis: usize| {
        let mean: f64 = weights.iter().zip(&share).map(|(w, f)| f * w[axis]).sum();
        let square: f64 = weights.iter().zip(&share).map(|(w, f)| f * w[axis] * w[axis]).sum();
        (square - mean * mean).max(0.0) / (sample.len() as f64 * WIDTH * WIDTH)
    };
    let (form_error, power_error) = (variance(0).sqrt(), variance(1).sqrt());
    let endless = kind == Kind::K && at[0] <= S_RANGE[0];
    let found = law(kind, at);
    let shape = if endless { f64::INFINITY } else { found.shape() };
    let (shape_error, inverse_error) = match kind {
        Kind::K if endless => (f64::INFINITY, form_error),
        Kind::K => (shape * (shape + 1.0) * form_error, (1.0 + 1.0 / shape) * form_error),
        Kind::Weibull => (shape * form_error, 0.0),
        Kind::Rayleigh => (0.0, 0.0),
    };
    let mean_power = found.mean_power() * sample.mean_power();
    Fit { law: Law::new(kind, shape, mean_power), shape_error, inverse_error, power_error }
}
