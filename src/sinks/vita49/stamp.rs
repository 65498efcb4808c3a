//! Time stamps of the wire: whole UTC seconds and picoseconds, rounded once.
//!
//! A stamp is `emission + window_start + n / fs`. Whole seconds stay integers; the parts below a second are
//! added in units of 2^-64 s (5.4e-20 s), in which an f64 below a second is exact to that unit, and `n / fs`
//! is divided as integers. The one rounding that matters is the last, to the nearest picosecond.

use crate::time::TimeTag;

/// Picoseconds per second.
const PICOSECONDS: u128 = 1_000_000_000_000;

/// A time stamp as the wire has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stamp {
    /// UTC seconds since 1970, modulo 2^32 (the field's width; it turns over in 2106).
    pub(super) seconds: u32,
    /// Picoseconds, below 10^12.
    pub(super) picoseconds: u64,
}

/// A span in units of 2^-64 s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Span(i128);

impl Span {
    /// From seconds; exact but for what lies below the unit.
    pub(super) fn of_seconds(seconds: f64) -> Self {
        // A power of two: the product is exact, and the conversion saturates.
        Self((seconds * 2f64.powi(64)) as i128)
    }

    /// `samples / rate_hz`, rounded down to the unit. The rate is finite and at least 1 Hz.
    pub(super) fn of_samples(samples: u32, rate_hz: f64) -> Self {
        let bits = rate_hz.to_bits();
        let exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
        let mantissa = u128::from((bits & ((1 << 52) - 1)) | (1 << 52));
        // rate = mantissa 2^exponent, with an exponent of -52 at least.
        let (numerator, denominator) = if exponent < 0 {
            (u128::from(samples) << exponent.unsigned_abs().min(52), mantissa)
        } else {
            (u128::from(samples), mantissa << exponent.min(60))
        };
        let (whole, rest) = (numerator / denominator, numerator % denominator);
        // The rest is below the denominator, which has 53 bits, or 2^113 at a rate nobody has.
        let below = match rest.checked_shl(64).filter(|shifted| shifted >> 64 == rest) {
            Some(shifted) => shifted / denominator,
            None => 0,
        };
        Self(((whole << 64) | below) as i128)
    }
}

impl Stamp {
    /// `tag + after + later`, to the nearest picosecond.
    pub(super) fn new(tag: TimeTag, after: Span, later: Span) -> Self {
        let sum = Span::of_seconds(tag.fraction_s()).0.saturating_add(after.0).saturating_add(later.0);
        let whole = (sum >> 64) as i64;
        let below = (sum as u128) & u128::from(u64::MAX);
        let picoseconds = (below * PICOSECONDS + (1 << 63)) >> 64;
        let carry = i64::from(picoseconds == PICOSECONDS);
        let seconds = tag.seconds().wrapping_add(whole).wrapping_add(carry);
        Self { seconds: seconds as u32, picoseconds: (picoseconds % PICOSECONDS) as u64 }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn stamps_are_the_nearest_picosecond() {
        let tag = TimeTag::new(1_527_711_300, 0.25);
        let stamp = |after_s: f64, n: u32, rate: f64| {
            Stamp::new(tag, Span::of_seconds(after_s), Span::of_samples(n, rate))
        };
        assert_eq!(stamp(0.0, 0, 1e8), Stamp { seconds: 1_527_711_300, picoseconds: 250_000_000_000 });
        // 3 samples of 1/3 us are 1 us; one is 333333.33 ps.
        assert_eq!(stamp(0.0, 3, 3e6).picoseconds, 250_001_000_000);
        assert_eq!(stamp(0.0, 1, 3e6).picoseconds, 250_000_333_333);
        assert_eq!(stamp(0.0, 2, 3e6).picoseconds, 250_000_666_667);
        // Over the second, and before the emission.
        assert_eq!(stamp(0.75, 0, 1e8), Stamp { seconds: 1_527_711_301, picoseconds: 0 });
        assert_eq!(stamp(-0.5, 0, 1e8), Stamp { seconds: 1_527_711_299, picoseconds: 750_000_000_000 });
        // Half a picosecond below the second is the second.
        let last = Stamp::new(TimeTag::new(7, 1.0 - 1e-13), Span::default(), Span::default());
        assert_eq!(last, Stamp { seconds: 8, picoseconds: 0 });
    }

    proptest! {
        /// Against rational arithmetic in integers of another width: attoseconds.
        #[test]
        fn sample_spans_agree_with_attoseconds(n in 0u32..1 << 24, rate in 1_000u64..100_000_000_000) {
            let span = Span::of_samples(n, rate as f64);
            let exact_as = u128::from(n) * 1_000_000_000_000_000_000 / u128::from(rate);
            let whole = span.0 >> 64;
            let below = (span.0 as u128) & u128::from(u64::MAX);
            let found_as = whole as u128 * 1_000_000_000_000_000_000
                + ((below * 1_000_000_000) >> 64) * 1_000_000_000;
            // Both are rounded down; the product keeps nine digits of the part below a second.
            prop_assert!(exact_as.abs_diff(found_as) <= 1_000_000_001);
        }

        #[test]
        fn any_times_make_a_stamp(seconds: i64, fraction in 0f64..1.0, after: f64, n: u32, rate in 1.0..1e12) {
            let stamp =
                Stamp::new(TimeTag::new(seconds, fraction), Span::of_seconds(after), Span::of_samples(n, rate));
            prop_assert!(u128::from(stamp.picoseconds) < PICOSECONDS);
        }
    }
}
