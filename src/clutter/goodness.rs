//! Whether a law fits: the Kolmogorov-Smirnov distance.
//!
//! ```text
//! D = max over z of |F_n(z) - P(z)|,   F_n the share of the sample that is not larger
//! ```
//!
//! The tables of that distance hold for laws that are known beforehand. Here the law was fitted to the same
//! sample, so the probability is that of a **parametric bootstrap**: samples of the same size are drawn from
//! the fitted law, each is fitted again (by maximum likelihood), and `p = (1 + k)/(1 + B)`, `k` of `B` being
//! at least as far from their own law. Numbers come from streams keyed by the seed and the number of the
//! sample: the same for any number of threads.
//!
//! Limits: the sample is independent; large samples refuse every law that is not exact. `p` is never below
//! `1/(1 + B)`.
//!
//! Source: W. Stute, W. Gonzales Manteiga, M. Presedo Quindimil, Metrika 40, 243 (1993).

use rayon::prelude::*;

use super::laws::{Kind, Law};
use super::{Sample, likelihood};
use crate::rng::{Room, stream};

/// Points at which a K law is evaluated; between them its probability is a cubic that has its density as
/// slope.
const POINTS: usize = 800;

/// How well a law fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goodness {
    /// The law, fitted by maximum likelihood.
    pub law: Law,
    /// `D`.
    pub distance: f64,
    /// Probability of such a distance or a larger one if the law were true; none without resamples.
    pub probability: Option<f64>,
    /// Powers of the sample.
    pub samples: usize,
}

/// The probability of a law, quick to evaluate for many amplitudes.
enum Table<'a> {
    Exact(&'a Law),
    Cubic {
        first: f64,
        step: f64,
        /// Probability, and its slope over `ln z` times the step.
        held: Vec<[f64; 2]>,
    },
}

impl<'a> Table<'a> {
    fn of(law: &'a Law, least: f64, most: f64) -> Self {
        match law {
            Law::K(k) if k.shape.is_finite() && least > 0.0 && most > least => {
                let (first, last) = (least.ln(), most.ln());
                let step = (last - first) / (POINTS - 1) as f64;
                let at = |i: usize| {
                    let z = (first + step * i as f64).exp();
                    [k.probability(z), step * z * k.density(z)]
                };
                Self::Cubic { first, step, held: (0..POINTS).map(at).collect() }
            }
            _ => Self::Exact(law),
        }
    }

    fn probability(&self, z: f64) -> f64 {
        match self {
            Self::Exact(law) => law.probability(z),
            Self::Cubic { first, step, held } => {
                let place = ((z.ln() - first) / step).clamp(0.0, (held.len() - 1) as f64);
                let i = (place as usize).min(held.len() - 2);
                let t = place - i as f64;
                let ([p, dp], [q, dq]) = (held[i], held[i + 1]);
                let rise = q - p;
                p + t * (dp + t * (3.0 * rise - 2.0 * dp - dq + t * (dp + dq - 2.0 * rise)))
            }
        }
    }
}

/// Amplitudes over their rms, in order.
fn ordered(sample: &Sample) -> Vec<f64> {
    let mut amplitudes: Vec<f64> = sample.ratios.iter().map(|ratio| ratio.sqrt()).collect();
    amplitudes.sort_unstable_by(f64::total_cmp);
    amplitudes
}

/// `D` of a law that was not fitted to the sample, or was.
pub fn distance(sample: &Sample, law: &Law) -> f64 {
    // In the unit of the sample.
    let law = Law::new(law.kind(), law.shape(), law.mean_power() / sample.mean_power());
    let ordered = ordered(sample);
    let (Some(least), Some(most)) = (ordered.first(), ordered.last()) else { return 0.0 };
    let table = Table::of(&law, *least, *most);
    let n = ordered.len() as f64;
    let apart = |(i, z): (usize, &f64)| {
        let p = table.probability(*z);
        (p - i as f64 / n).max((i + 1) as f64 / n - p)
    };
    ordered.iter().enumerate().map(apart).fold(0.0, f64::max)
}

/// Fits a law and measures how well it fits, by so many samples drawn from it.
pub fn test(sample: &Sample, kind: Kind, resamples: usize, seed: u64) -> Goodness {
    let law = likelihood::fit(sample, kind).law;
    let found = distance(sample, &law);
    let farther = |resample: usize| {
        let mut numbers = stream(seed, Room::Bootstrap, resample as u64, kind as u64);
        let powers: Vec<f64> = (0..sample.len()).map(|_| law.draw(&mut numbers).powi(2)).collect();
        // Numbers too small to be held leave no sample: those count as far.
        Sample::new(&powers)
            .map_or(true, |drawn| distance(&drawn, &likelihood::fit(&drawn, kind).law) >= found)
    };
    let count = (0..resamples).into_par_iter().filter(|resample| farther(*resample)).count();
    let probability = (resamples > 0).then(|| (1 + count) as f64 / (1 + resamples) as f64);
    Goodness { law, distance: found, probability, samples: sample.len() }
}
