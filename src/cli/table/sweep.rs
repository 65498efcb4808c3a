//! Sweeps: the values of one key of a table, evenly spaced.
//!
//! `--from-UNIT --to-UNIT --step-UNIT` gives `from + i step` (never accumulated, the last value never beyond
//! `to`); `--points N` instead of a step gives N values from `from` to `to`, both included, in linear or log
//! spacing. What is not given is the table's own.

use clap::Args;

use super::MOST_ROWS;
use crate::cli::error::Refused;
use crate::cli::values::{Word, one_of};

/// How points of a sweep are spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Logarithmic,
}

/// Their words.
const SPACINGS: [Word<Spacing>; 2] =
    [("linear", "Equal differences", Spacing::Linear), ("log", "Equal ratios", Spacing::Logarithmic)];

/// What lies between the ends of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Every {
    /// Values a step apart.
    Step(f64),
    /// So many values, spaced so.
    Points(usize, Spacing),
}

/// A sweep as a table would have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Usual {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) every: Every,
}

/// A sweep as it was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sweep {
    from: Option<f64>,
    to: Option<f64>,
    step: Option<f64>,
    points: Option<usize>,
    spacing: Option<Spacing>,
    /// Keys of the ends and of the step.
    keys: [&'static str; 3],
}

impl Sweep {
    /// The first of its keys that was given.
    pub(super) fn given(&self) -> Option<&'static str> {
        let [from, to, step] = self.keys;
        [
            (self.from.is_some(), from),
            (self.to.is_some(), to),
            (self.step.is_some(), step),
            (self.points.is_some(), "--points"),
        ]
        .into_iter()
        .find_map(|(given, key)| given.then_some(key))
    }

    /// The values of a key: those of its list, or else those of the sweep.
    pub(super) fn or_list(&self, key: &'static str, list: &[f64], usual: Usual) -> Result<Vec<f64>, Refused> {
        match self.given() {
            _ if list.is_empty() => self.values(usual),
            Some(sweep_key) => Err(Refused::Both { key, sweep_key }),
            None => Ok(list.to_vec()),
        }
    }

    /// The values of the sweep.
    pub(super) fn values(&self, usual: Usual) -> Result<Vec<f64>, Refused> {
        let (from, to) = (self.from.unwrap_or(usual.from), self.to.unwrap_or(usual.to));
        let [from_key, to_key, step_key] = self.keys;
        let every = match (self.step, self.points) {
            (Some(step), _) => Every::Step(step),
            (None, Some(points)) => Every::Points(points, self.spacing.unwrap_or(usual.spacing())),
            (None, None) => usual.every,
        };
        // A span that overflows is no sweep either.
        let ordered = from <= to && (to - from).is_finite();
        match every {
            Every::Step(step) => {
                // Half a thousandth of a step, so that the last value is not lost to rounding.
                let steps = ((to - from) / step + 5e-4).floor();
                if !(ordered && step.is_finite() && step > 0.0 && steps < MOST_ROWS as f64) {
                    return Err(Refused::Value {
                        asked: format!("{from_key} {from} {to_key} {to} {step_key} {step}"),
                        allowed: format!(
                            "finite numbers, from no greater than to, a step above 0 that gives at most {MOST_ROWS} rows"
                        ),
                    });
                }
                Ok((0..=steps as usize).map(|i| (from + i as f64 * step).min(to)).collect())
            }
            Every::Points(points, spacing) => {
                let log = spacing == Spacing::Logarithmic;
                if !(ordered && (1..=MOST_ROWS).contains(&points) && (!log || from > 0.0)) {
                    return Err(Refused::Value {
                        asked: format!("{from_key} {from} {to_key} {to} --points {points}"),
                        allowed: format!(
                            "finite numbers, from no greater than to (and above 0 in log spacing), 1 to {MOST_ROWS} points"
                        ),
                    });
                }
                let last = points - 1;
                Ok((0..points)
                    .map(|i| match i {
                        0 => from,
                        _ if i == last => to,
                        _ if log => from * (to / from).powf(i as f64 / last as f64),
                        _ => from + (to - from) * (i as f64 / last as f64),
                    })
                    .collect())
            }
        }
    }
}

impl Usual {
    /// `from`, `from + step`, ... `to`.
    pub(super) fn steps(from: f64, to: f64, step: f64) -> Self {
        Self { from, to, every: Every::Step(step) }
    }

    /// So many values in equal ratios.
    pub(super) fn log(from: f64, to: f64, points: usize) -> Self {
        Self { from, to, every: Every::Points(points, Spacing::Logarithmic) }
    }

    fn spacing(&self) -> Spacing {
        match self.every {
            Every::Points(_, spacing) => spacing,
            Every::Step(_) => Spacing::Linear,
        }
    }
}

/// The keys of a sweep in some unit.
macro_rules! sweep_keys {
    ($($name:ident, $unit:literal, $from:literal, $to:literal, $step:literal;)*) => {$(
        #[doc = concat!("A sweep in ", $unit, ".")]
        #[derive(Clone, Debug, Args)]
        pub struct $name {
            #[arg(long = $from, value_name = "X", help = concat!("First value of the sweep, ", $unit), help_heading = "Sweep")]
            from: Option<f64>,
            #[arg(long = $to, value_name = "X", help = concat!("Last value of the sweep, ", $unit), help_heading = "Sweep")]
            to: Option<f64>,
            #[arg(long = $step, value_name = "X", help = concat!("Step of the sweep, ", $unit), help_heading = "Sweep")]
            step: Option<f64>,
            /// Number of values, instead of a step
            #[arg(long, value_name = "N", conflicts_with = "step", help_heading = "Sweep")]
            points: Option<usize>,
            /// Spacing of the points
            #[arg(long, value_parser = one_of(SPACINGS), requires = "points", help_heading = "Sweep")]
            spacing: Option<Spacing>,
        }

        impl $name {
            pub(super) fn sweep(&self) -> Sweep {
                Sweep {
                    from: self.from,
                    to: self.to,
                    step: self.step,
                    points: self.points,
                    spacing: self.spacing,
                    keys: [concat!("--", $from), concat!("--", $to), concat!("--", $step)],
                }
            }
        }
    )*};
}

sweep_keys! {
    FrequencySweep, "Hz", "from-hz", "to-hz", "step-hz";
    AngleSweep, "degrees", "from-deg", "to-deg", "step-deg";
    WaveNumberSweep, "rad/m", "from-rad-m", "to-rad-m", "step-rad-m";
    SpeedSweep, "m/s", "from-mps", "to-mps", "step-mps";
    SlopeSweep, "slope", "from-slope", "to-slope", "step-slope";
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Sweep = Sweep {
        from: None,
        to: None,
        step: None,
        points: None,
        spacing: None,
        keys: ["--from-deg", "--to-deg", "--step-deg"],
    };

    #[test]
    fn steps_end_at_the_last_value() {
        // 0.1 is no binary fraction: 0.3/0.1 is 2.9999999999999996, and 3 * 0.1 is above 0.3.
        let values = NONE.values(Usual::steps(0.0, 0.3, 0.1)).unwrap();
        assert_eq!(values, [0.0, 0.1, 0.2, 0.3]);
        let short = Sweep { to: Some(0.25), ..NONE }.values(Usual::steps(0.0, 0.3, 0.1)).unwrap();
        assert_eq!(short, [0.0, 0.1, 0.2]);
        assert_eq!(NONE.values(Usual::steps(7.0, 7.0, 1.0)).unwrap(), [7.0]);
    }

    #[test]
    fn points_hold_both_ends() {
        let values = NONE.values(Usual::log(1.0, 100.0, 3)).unwrap();
        assert_eq!((values[0], values[2], values.len()), (1.0, 100.0, 3));
        assert!((values[1] - 10.0).abs() < 1e-14);
        // Asked points keep the table's spacing; a step makes it linear.
        let usual = Usual::log(1.0, 100.0, 9);
        let asked = Sweep { points: Some(3), ..NONE };
        assert!((asked.values(usual).unwrap()[1] - 10.0).abs() < 1e-14);
        let linear = Sweep { spacing: Some(Spacing::Linear), ..asked };
        assert_eq!(linear.values(usual).unwrap(), [1.0, 50.5, 100.0]);
        assert_eq!(Sweep { step: Some(33.0), ..NONE }.values(usual).unwrap(), [1.0, 34.0, 67.0, 100.0]);
        assert_eq!(Sweep { points: Some(1), ..NONE }.values(usual).unwrap(), [1.0]);
    }

    #[test]
    fn sweeps_without_rows_or_without_end_are_refused() {
        let usual = Usual::steps(0.0, 10.0, 1.0);
        let refused = [
            Sweep { step: Some(0.0), ..NONE },
            Sweep { step: Some(-1.0), ..NONE },
            Sweep { step: Some(f64::NAN), ..NONE },
            Sweep { step: Some(f64::INFINITY), ..NONE },
            Sweep { step: Some(1e-9), ..NONE },
            Sweep { from: Some(11.0), ..NONE },
            Sweep { from: Some(f64::NEG_INFINITY), ..NONE },
            Sweep { to: Some(f64::NAN), ..NONE },
            Sweep { from: Some(-1e308), to: Some(1e308), step: Some(1e308), ..NONE },
            Sweep { points: Some(0), ..NONE },
            Sweep { points: Some(MOST_ROWS + 1), ..NONE },
            Sweep { points: Some(3), spacing: Some(Spacing::Logarithmic), ..NONE },
        ];
        for sweep in refused {
            let error = sweep.values(usual).unwrap_err().to_string();
            assert!(error.contains("--from-deg") && error.contains("allowed"), "{sweep:?}: {error}");
        }
        assert_eq!(Sweep { points: Some(MOST_ROWS), ..NONE }.values(usual).unwrap().len(), MOST_ROWS);
    }
}
