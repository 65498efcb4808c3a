//! Powers of pixels that are to be fitted.
//!
//! Powers of 0, of pixels without echo, belong to none of the laws: they are left out and counted.
//! Logarithms of amplitudes are gathered in bins of 0.02, each with its own mean: a likelihood of that costs
//! as many densities as there are bins, and errs by half the variance within a bin times the curvature of the
//! logarithm of the density, 2e-5 a pixel, with almost no slope in the parameters.
//!
//! Fits take the pixels as independent. Pixels one resolution cell apart of an image without tapers are, as
//! far as speckle goes: the response is a sinc that is zero at whole cells. What waves do to their power is
//! not: [`blocks`](super::blocks).

/// Why powers cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SampleFault {
    /// A power that is none.
    #[error("pixel {pixel} has a power of {power}: allowed: finite numbers from 0")]
    Power {
        /// Which one.
        pixel: usize,
        /// Its power.
        power: f64,
    },
    /// Too few of them.
    #[error("{samples} pixels with power: a fit takes at least 2")]
    Few {
        /// Pixels with power.
        samples: usize,
    },
}

/// Width of a bin of `ln z`.
const WIDTH: f64 = 0.02;

/// Amplitudes by their logarithm.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Bins {
    first: i64,
    /// Count, and sum of `ln z`.
    held: Vec<[f64; 2]>,
}

impl Bins {
    pub fn of(powers: impl Iterator<Item = f64> + Clone) -> Self {
        let place = |power: f64| (0.5 * power.ln() / WIDTH).floor() as i64;
        let (mut first, mut last) = (i64::MAX, i64::MIN);
        for power in powers.clone().filter(|power| *power > 0.0) {
            first = first.min(place(power));
            last = last.max(place(power));
        }
        if first > last {
            return Self::default();
        }
        let mut held = vec![[0.0; 2]; usize::try_from(last - first).unwrap_or(0) + 1];
        for power in powers.filter(|power| *power > 0.0) {
            if let Some(bin) = usize::try_from(place(power) - first).ok().and_then(|at| held.get_mut(at)) {
                bin[0] += 1.0;
                bin[1] += 0.5 * power.ln();
            }
        }
        Self { first, held }
    }

    /// Without those of a part.
    pub fn without(&self, part: &Self) -> Self {
        let mut left = self.clone();
        for (i, [count, sum]) in part.held.iter().enumerate() {
            let at = usize::try_from(part.first - left.first + i as i64);
            if let Some(bin) = at.ok().and_then(|at| left.held.get_mut(at)) {
                bin[0] -= count;
                bin[1] -= sum;
            }
        }
        left
    }

    /// Count and mean `ln z` of every bin that has any.
    pub fn filled(&self) -> impl Iterator<Item = [f64; 2]> + Clone + '_ {
        self.held.iter().filter(|[count, _]| *count > 0.5).map(|[count, sum]| [*count, sum / count])
    }

    pub fn count(&self) -> f64 {
        self.held.iter().map(|[count, _]| count).sum()
    }

    /// Logarithm of the mean power.
    pub fn ln_mean_power(&self) -> f64 {
        let top = self.filled().map(|[_, u]| u).fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = self.filled().map(|[count, u]| count * (2.0 * (u - top)).exp()).sum();
        2.0 * top + (sum / self.count()).ln()
    }
}

/// Powers that can be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Over their mean: powers of 1e-15 W keep their digits.
    pub(super) ratios: Vec<f64>,
    pub(super) bins: Bins,
    mean_power: f64,
    moments: [f64; 3],
    zeros: usize,
}

impl Sample {
    /// Of powers `I = z^2` in any unit.
    ///
    /// # Errors
    /// A power that is no finite number from 0; fewer than two above 0.
    pub fn new(powers: &[f64]) -> Result<Self, SampleFault> {
        let is_power = |power: &f64| power.is_finite() && *power >= 0.0;
        if let Some(pixel) = powers.iter().position(|power| !is_power(power)) {
            return Err(SampleFault::Power { pixel, power: powers[pixel] });
        }
        let positive: Vec<f64> = powers.iter().copied().filter(|power| *power > 0.0).collect();
        if positive.len() < 2 {
            return Err(SampleFault::Few { samples: positive.len() });
        }
        let n = positive.len() as f64;
        // Of the largest, so that no sum is beyond what a number holds.
        let top = positive.iter().copied().fold(0.0, f64::max);
        let mean = positive.iter().map(|power| power / top).sum::<f64>() / n;
        let ratios: Vec<f64> = positive.iter().map(|power| power / top / mean).collect();
        let moment = |order: i32| ratios.iter().map(|r| r.powi(order)).sum::<f64>() / n;
        let bins = Bins::of(ratios.iter().copied());
        Ok(Self {
            bins,
            mean_power: top * mean,
            moments: [2, 3, 4].map(moment),
            zeros: powers.len() - positive.len(),
            ratios,
        })
    }

    /// Powers above 0.
    pub fn len(&self) -> usize {
        self.ratios.len()
    }

    /// Whether there is none: never.
    pub fn is_empty(&self) -> bool {
        self.ratios.is_empty()
    }

    /// Powers of 0, which were left out.
    pub fn zeros(&self) -> usize {
        self.zeros
    }

    /// `<I>`.
    pub fn mean_power(&self) -> f64 {
        self.mean_power
    }

    /// `<I^2>/<I>^2`: 2 for Rayleigh.
    pub fn contrast(&self) -> f64 {
        self.moments[0]
    }

    /// Its standard error, from the first four moments of the sample to first order: right for many
    /// independent samples.
    pub fn contrast_error(&self) -> f64 {
        let [m2, m3, m4] = self.moments;
        let variance = (m4 - m2 * m2) + 4.0 * m2 * m2 * (m2 - 1.0) - 4.0 * m2 * (m3 - m2);
        (variance.max(0.0) / self.len() as f64).sqrt()
    }
}
