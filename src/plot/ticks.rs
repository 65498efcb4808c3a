//! Round numbers along an axis.
//!
//! Steps are 1, 2 or 5 times a power of ten, as fine as the room allows. Labels have the digits that set
//! neighbours apart, and an exponent where plain digits would be many. Over two decades or more a logarithmic
//! axis bears powers of ten, with 2 and 5 between them where there is room.
//!
//! Limits: axes between finite numbers up to 1e150, at least 1e-12 of their size apart ([`spread`]).
//!
//! ```
//! use nereus::plot::ticks;
//! let labels: Vec<String> = ticks::linear([-1.2, 1.1], 6).into_iter().map(|tick| tick.label).collect();
//! assert_eq!(labels, ["-1.0", "-0.5", "0", "0.5", "1.0"]);
//! ```

/// Numbers beyond are drawn as if they were infinite.
pub const LARGEST: f64 = 1e150;

/// Least length of an axis against its ends: f64 still separates a thousand ticks.
const LEAST_SHARE: f64 = 1e-12;

/// A place on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where, in the unit of the axis (log10 of it on a logarithmic axis).
    pub at: f64,
    /// What stands there.
    pub label: String,
}

/// Limits that an axis can have, from the least and greatest value to be shown: what is no number becomes
/// `[0, 1]`, a single value gets room on both sides.
pub fn spread([low, high]: [f64; 2]) -> [f64; 2] {
    if !(low.abs() <= LARGEST && high.abs() <= LARGEST && low <= high) {
        return [0.0, 1.0];
    }
    let size = low.abs().max(high.abs());
    if high - low > LEAST_SHARE * size && high - low > f64::MIN_POSITIVE / LEAST_SHARE {
        return [low, high];
    }
    let room = if size > 1e-290 { 0.05 * size } else { 1.0 };
    [low - room, high + room]
}

/// Whether an axis can have these limits.
pub fn is_axis([low, high]: [f64; 2]) -> bool {
    low < high && spread([low, high]) == [low, high]
}

/// The largest 1, 2 or 5 times a power of ten that is no larger; 0 for what is not positive.
pub fn round_below(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 0.0;
    }
    let decade = 10f64.powf(value.log10().floor());
    // A decade computed a rounding error too high must not push its own value down to a half.
    let share = value / decade * (1.0 + 1e-12);
    [5.0, 2.0, 1.0].into_iter().find(|step| share >= *step).unwrap_or(0.5) * decade
}

/// Round numbers between limits: at most `most` of them, or a few more where it would be less than two.
pub fn linear(limits: [f64; 2], most: usize) -> Vec<Tick> {
    let [low, high] = spread(limits);
    let most = most.max(2);
    let decade = ((high - low) / most as f64).log10().floor();
    let numbered = |factor: f64, exponent: f64| {
        let step = factor * 10f64.powf(exponent);
        let (first, last) = ((low / step - 1e-6).ceil(), (high / step + 1e-6).floor());
        let count = if last >= first { (last - first) as usize + 1 } else { 0 };
        (step, exponent as i32, first, count)
    };
    let steps = [(1.0, 0.0), (2.0, 0.0), (5.0, 0.0), (1.0, 1.0), (2.0, 1.0)];
    let steps = steps.map(|(factor, up)| numbered(factor, decade + up));
    let fits = steps.iter().position(|(.., count)| *count <= most).unwrap_or(steps.len() - 1);
    // The next finer one has at most five where this one has less than two.
    let chosen = if steps[fits].3 < 2 { fits.saturating_sub(1) } else { fits };
    let (step, exponent, first, count) = steps[chosen];
    let top = (low.abs().max(high.abs()) * (1.0 + 1e-9)).log10().floor() as i32;
    (0..count.min(most + 5))
        .map(|i| {
            let at = (first + i as f64) * step;
            Tick { at: at.clamp(low, high), label: label(at, step, exponent, top) }
        })
        .collect()
}

/// A number on an axis of a step with the given exponent, the largest number of which has the exponent `top`.
fn label(value: f64, step: f64, exponent: i32, top: i32) -> String {
    if value.abs() < 0.5 * step {
        return "0".to_owned();
    }
    if top > 5 || exponent < -4 {
        let own = value.abs().log10().floor() as i32;
        return format!("{value:.*e}", usize::try_from(own - exponent).unwrap_or(0).min(17));
    }
    format!("{value:.*}", usize::try_from(-exponent).unwrap_or(0))
}

/// Powers of ten between limits given as log10, at most `most` of them; 2 and 5 between where there is room,
/// round numbers of the value itself within a decade.
pub fn logarithmic(limits: [f64; 2], most: usize) -> Vec<Tick> {
    let [low, high] = spread(limits);
    // No number has such a logarithm.
    if low < -400.0 || high > 400.0 {
        return linear([low, high], most);
    }
    if high - low < 1.0 {
        let near = linear([10f64.powf(low), 10f64.powf(high)], most);
        let near: Vec<Tick> = near
            .into_iter()
            .filter(|tick| tick.at > 0.0)
            .map(|tick| Tick { at: tick.at.log10().clamp(low, high), ..tick })
            .collect();
        if !near.is_empty() {
            return near;
        }
    }
    let (first, last) = ((low - 1e-9).ceil(), (high + 1e-9).floor());
    let decades = (last - first).max(0.0) as usize + 1;
    let stride = decades.div_ceil(most.max(2));
    let between: &[f64] = if 3 * decades <= most { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let mut ticks = Vec::new();
    for i in (0..decades.saturating_add(1)).step_by(stride) {
        // From the decade before the first: its 2 and 5 may lie inside.
        let decade = first - if between.len() > 1 { 1.0 } else { 0.0 } + i as f64;
        for factor in between {
            let at = decade + factor.log10();
            if at >= low - 1e-9 && at <= high + 1e-9 {
                let label = if (-3.0..=4.0).contains(&decade) {
                    let digits = if decade < 0.0 { -decade as usize } else { 0 };
                    format!("{:.*}", digits, 10f64.powf(at))
                } else {
                    format!("{factor}e{decade}")
                };
                ticks.push(Tick { at: at.clamp(low, high), label });
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn labels_distinguish_neighbours() {
        assert_eq!(labels(&linear([0.0, 512.0], 6)), ["0", "100", "200", "300", "400", "500"]);
        assert_eq!(labels(&linear([-0.004, 0.004], 5)), ["-0.004", "-0.002", "0", "0.002", "0.004"]);
        assert_eq!(labels(&linear([0.0, 3e9], 4)), ["0", "1e9", "2e9", "3e9"]);
        assert_eq!(labels(&linear([1e9, 1e9 + 2.0], 3)), ["1.000000000e9", "1.000000001e9", "1.000000002e9"]);
        assert_eq!(labels(&logarithmic([-1.0, 2.0], 5)), ["0.1", "1", "10", "100"]);
        assert_eq!(labels(&logarithmic([0.0, 1.0], 8)), ["1", "2", "5", "10"]);
        assert_eq!(labels(&logarithmic([-9.0, -6.0], 4)), ["1e-9", "1e-8", "1e-7", "1e-6"]);
        assert_eq!(labels(&logarithmic([0.0, 0.3], 4)), ["1.0", "1.5"]);
    }

    #[test]
    fn round_numbers_lie_below() {
        for (value, round) in [(512.0, 500.0), (100.0, 100.0), (0.19, 0.1), (2.0, 2.0), (1e-30, 1e-30)] {
            assert!((round_below(value) / round - 1.0).abs() < 1e-9, "{value}");
        }
        assert_eq!((round_below(0.0), round_below(f64::NAN), round_below(f64::INFINITY)), (0.0, 0.0, 0.0));
    }

    proptest! {
        #[test]
        fn any_axis_has_ticks_inside(low in any::<f64>(), high in any::<f64>(), most in 0usize..20) {
            let limits = spread([low, high]);
            prop_assert!(is_axis(limits), "{limits:?}");
            for ticks in [linear(limits, most), logarithmic(limits, most)] {
                prop_assert!(ticks.len() <= 3 * (most.max(2) + 2));
                for pair in ticks.windows(2) {
                    prop_assert!(pair[0].at <= pair[1].at && pair[0].label != pair[1].label, "{pair:?}");
                }
                for tick in &ticks {
                    prop_assert!((limits[0]..=limits[1]).contains(&tick.at) && tick.label.len() < 32, "{tick:?}");
                }
            }
        }

        #[test]
        fn ordinary_axes_are_well_filled(low in -1e6..1e6, span in 1e-3..1e6, most in 4usize..12) {
            let ticks = linear([low, low + span], most);
            // A step too fine has more than `most`, and the next is at most 2.5 times as long: (most + 1 - 1)
            // / 2.5 lengths of it fit, the ticks are one fewer at worst.
            prop_assert!(ticks.len() >= 2 && ticks.len() + 1 > most * 2 / 5, "{ticks:?}");
            prop_assert!(ticks.len() <= most.max(5), "{ticks:?}");
        }
    }
}
