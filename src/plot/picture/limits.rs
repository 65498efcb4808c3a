//! Values of the first and last colour.

use super::PictureError;
use crate::plot::ticks;

/// Which values get the first and the last colour.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Limits {
    /// These.
    Fixed([f64; 2]),
    /// The middle so many percent of all values lie within; 100 is all of them.
    Percentile(f64),
    /// From the value below which so many percent lie, down by a span: for decibels.
    Below {
        /// Percent of the values below the upper limit.
        percent: f64,
        /// From the upper limit to the lower one.
        span: f64,
    },
}

impl Limits {
    pub(super) fn check(self) -> Result<(), PictureError> {
        let percent = match self {
            Self::Fixed([low, high]) => {
                return if ticks::is_axis([low, high]) {
                    Ok(())
                } else {
                    Err(PictureError::Limits { low, high })
                };
            }
            Self::Percentile(percent) => percent,
            Self::Below { percent, span } => {
                if !ticks::is_axis([-span, 0.0]) {
                    return Err(PictureError::Limits { low: -span, high: 0.0 });
                }
                percent
            }
        };
        if percent > 0.0 && percent <= 100.0 { Ok(()) } else { Err(PictureError::Percent { percent }) }
    }

    /// The limits for these values, evenly about zero where asked (but for fixed ones).
    pub(super) fn of(self, values: &[f64], about_zero: bool) -> [f64; 2] {
        if let Self::Fixed(limits) = self {
            return limits;
        }
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.abs() <= ticks::LARGEST).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let [low, high] = match self {
            Self::Percentile(percent) => {
                let out = 0.5 * (1.0 - percent / 100.0);
                [quantile(&sorted, out), quantile(&sorted, 1.0 - out)]
            }
            Self::Below { percent, span } => {
                let top = quantile(&sorted, percent / 100.0);
                [top - span, top]
            }
            Self::Fixed(limits) => limits,
        };
        if about_zero {
            let most = low.abs().max(high.abs());
            return ticks::spread(if most > 0.0 { [-most, most] } else { [0.0, 0.0] });
        }
        ticks::spread([low, high])
    }
}

/// Linear between order statistics; not a number for none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = share.clamp(0.0, 1.0) * last as f64;
    let below = (at as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_leave_out_as_many_at_both_ends() {
        let values: Vec<f64> = (0..=100).map(f64::from).chain([f64::NAN, f64::INFINITY, 1e200]).collect();
        let judge = |limits: Limits, about_zero, expected: [f64; 2]| {
            let found = limits.of(&values, about_zero);
            // Shares of percents are rounded.
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-11), "{limits:?}: {found:?}");
        };
        judge(Limits::Percentile(98.0), false, [1.0, 99.0]);
        judge(Limits::Percentile(100.0), false, [0.0, 100.0]);
        judge(Limits::Percentile(90.0), true, [-95.0, 95.0]);
        judge(Limits::Below { percent: 90.0, span: 40.0 }, false, [50.0, 90.0]);
        assert_eq!(Limits::Fixed([-1.0, 3.0]).of(&values, true), [-1.0, 3.0]);
    }

    #[test]
    fn there_is_always_a_range() {
        assert_eq!(Limits::Percentile(98.0).of(&[f64::NAN], false), [0.0, 1.0]);
        assert_eq!(Limits::Percentile(98.0).of(&[0.0; 3], true), [-1.0, 1.0]);
        let [low, high] = Limits::Percentile(98.0).of(&[7.0; 3], false);
        assert!(low < 7.0 && high > 7.0);
        assert!(Limits::Percentile(0.0).check().is_err() && Limits::Percentile(f64::NAN).check().is_err());
        assert!(Limits::Fixed([1.0, 1.0]).check().is_err());
        assert!(Limits::Below { percent: 50.0, span: -1.0 }.check().is_err());
    }
}
