//! Changes as text.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::Change;
use crate::motion::errors::{ATTITUDE, AXES, VELOCITY};

/// Names of the axes, in their order.
pub const AXIS_NAMES: [&str; AXES] = [
    "position.east",
    "position.north",
    "position.up",
    "velocity.east",
    "velocity.north",
    "velocity.up",
    "attitude.roll",
    "attitude.pitch",
    "attitude.heading",
];

/// Longest dropout, s.
const LONGEST_S: f64 = 1e6;
/// Greatest latency, ms.
const LATEST_MS: f64 = 60_000.0;

/// A text that is no change.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum NotAChange {
    /// Not one of the words.
    #[error("'{word}': allowed: step, bias, ramp, dropout, latency, clear")]
    Word {
        /// As written.
        word: String,
    },
    /// Too few or too many parts.
    #[error("'{text}': allowed: {allowed}")]
    Parts {
        /// As written.
        text: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// An axis that is none.
    #[error("axis '{axis}': allowed: {}", AXIS_NAMES.join(", "))]
    Axis {
        /// As written.
        axis: String,
    },
    /// Not a number, or one that is out of range.
    #[error("value '{value}': allowed: a number from {least} to {most} {unit}")]
    Value {
        /// As written.
        value: String,
        /// Smallest.
        least: f64,
        /// Greatest.
        most: f64,
        /// Unit.
        unit: &'static str,
    },
    /// A unit that the quantity does not have.
    #[error("unit '{unit}' of {of}: allowed: {allowed}")]
    Unit {
        /// As written.
        unit: String,
        /// Of what.
        of: String,
        /// What is allowed.
        allowed: &'static str,
    },
}

/// Unit and greatest value of an axis.
fn unit(axis: usize) -> (&'static str, f64) {
    match axis {
        0..VELOCITY => ("m", 1e8),
        VELOCITY..ATTITUDE => ("m/s", 2e4),
        _ => ("deg", 360.0),
    }
}

/// The same of its growth.
fn rate(axis: usize) -> (&'static str, f64) {
    match axis {
        0..VELOCITY => ("m/s", 2e4),
        VELOCITY..ATTITUDE => ("m/s^2", 2e4),
        _ => ("deg/s", 360.0),
    }
}

fn number(text: &str, least: f64, most: f64, unit: &'static str) -> Result<f64, NotAChange> {
    let value = text.parse::<f64>().ok().filter(|value| (least..=most).contains(value));
    value.ok_or_else(|| NotAChange::Value { value: shown(text), least, most, unit })
}

/// At most a few dozen characters, without those that move a terminal's cursor.
fn shown(text: &str) -> String {
    text.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect()
}

/// A change and, where `on PLATFORM` stands behind it, the platform.
///
/// ```
/// use nereus::motion::changes::addressed;
/// let (change, platform) = addressed("dropout 2.5 s on aircraft")?;
/// assert_eq!((change.to_string().as_str(), platform), ("dropout 2.5 s", Some("aircraft")));
/// # Ok::<(), nereus::motion::changes::NotAChange>(())
/// ```
///
/// # Errors
/// A text that is no change.
pub fn addressed(text: &str) -> Result<(Change, Option<&str>), NotAChange> {
    let text = text.trim();
    let behind = text.rsplit_once(|c: char| c.is_ascii_whitespace()).and_then(|(before, name)| {
        let (change, on) = before.trim_end().rsplit_once(|c: char| c.is_ascii_whitespace())?;
        (on == "on").then_some((change, name))
    });
    match behind {
        Some((change, name)) => Ok((change.parse()?, Some(name))),
        None => Ok((text.parse()?, None)),
    }
}

impl FromStr for Change {
    type Err = NotAChange;

    fn from_str(text: &str) -> Result<Self, NotAChange> {
        let mut parts = text.split_ascii_whitespace();
        let word = parts.next().unwrap_or_default();
        let rest: [Option<&str>; 4] = std::array::from_fn(|_| parts.next());
        let parts = |allowed| NotAChange::Parts { text: shown(text), allowed };
        let fits = |written: &str, of: &str, allowed: &'static str| match written == allowed {
            true => Ok(()),
            false => Err(NotAChange::Unit { unit: shown(written), of: of.to_owned(), allowed }),
        };
        match word {
            "step" | "bias" | "ramp" => {
                let [Some(axis), Some(value), Some(written), None] = rest else {
                    return Err(parts(match word {
                        "ramp" => "ramp AXIS VALUE UNIT, such as ramp position.east 0.5 m/s",
                        "step" => "step AXIS VALUE UNIT, such as step position.up 5 m",
                        _ => "bias AXIS VALUE UNIT, such as bias attitude.heading 0.3 deg",
                    }));
                };
                let found = AXIS_NAMES.iter().position(|name| *name == axis);
                let of = found.ok_or_else(|| NotAChange::Axis { axis: shown(axis) })?;
                let (allowed, most) = if word == "ramp" { rate(of) } else { unit(of) };
                fits(written, axis, allowed)?;
                let value = number(value, -most, most, allowed)?;
                Ok(match word {
                    "step" => Self::Step { axis: of, value },
                    "bias" => Self::Bias { axis: of, value },
                    _ => Self::Ramp { axis: of, value },
                })
            }
            "dropout" => {
                let [Some(value), Some(written), None, None] = rest else {
                    return Err(parts("dropout SECONDS s, such as dropout 2.5 s"));
                };
                fits(written, word, "s")?;
                Ok(Self::Dropout { seconds: number(value, 0.0, LONGEST_S, "s")? })
            }
            "latency" => {
                let [Some(value), Some(written), None, None] = rest else {
                    return Err(parts("latency MS ms, such as latency 250 ms"));
                };
                fits(written, word, "ms")?;
                Ok(Self::Latency { ms: number(value, 0.0, LATEST_MS, "ms")? })
            }
            "clear" if rest[0].is_none() => Ok(Self::Clear),
            "clear" => Err(parts("clear")),
            _ => Err(NotAChange::Word { word: shown(word) }),
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |axis: usize| AXIS_NAMES.get(axis).copied().unwrap_or_default();
        match *self {
            Self::Step { axis, value } => write!(f, "step {} {value} {}", name(axis), unit(axis).0),
            Self::Bias { axis, value } => write!(f, "bias {} {value} {}", name(axis), unit(axis).0),
            Self::Ramp { axis, value } => write!(f, "ramp {} {value} {}", name(axis), rate(axis).0),
            Self::Dropout { seconds } => write!(f, "dropout {seconds} s"),
            Self::Latency { ms } => write!(f, "latency {ms} ms"),
            Self::Clear => write!(f, "clear"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_they_are_written() {
        for text in [
            "step position.east -0.1 m",
            "step velocity.north 2 m/s",
            "bias attitude.heading 0.3 deg",
            "bias attitude.roll 0.0000000000000000001 deg",
            "ramp position.up 20000 m/s",
            "ramp velocity.east 1 m/s^2",
            "ramp attitude.pitch -7.25 deg/s",
            "dropout 2.5 s",
            "latency 250 ms",
            "clear",
        ] {
            let change: Change = text.parse().unwrap();
            assert_eq!(change.to_string(), text);
            assert_eq!(format!("  {} ", text.replace(' ', "\t ")).parse(), Ok(change));
        }
    }

    proptest::proptest! {
        #![proptest_config(crate::rng::cases::proptests(256))]

        /// Whatever is sent is read or refused, and what is read is written as it was meant.
        #[test]
        fn no_text_does_harm(text in "\\PC{0,60}", value in proptest::num::f64::ANY, axis in 0..AXES) {
            let _ = addressed(&text);
            let line = format!("step {} {value} {}", AXIS_NAMES[axis], unit(axis).0);
            match line.parse::<Change>() {
                Ok(change) => proptest::prop_assert_eq!(change, Change::Step { axis, value }),
                Err(_) => proptest::prop_assert!(value.is_nan() || value.abs() > unit(axis).1),
            }
            proptest::prop_assert_eq!(addressed("clear  on x-1 "), Ok((Change::Clear, Some("x-1"))));
        }
    }

    #[test]
    fn what_is_wrong_is_reported() {
        let fault = |text: &str| text.parse::<Change>().unwrap_err().to_string();
        insta::assert_snapshot!(
            [
                "", "jump position.up 5 m", "step", "ramp position.up 5", "bias position.up 5 m m", "step north 5 m",
                "step position.up five m", "step position.up NaN m", "bias attitude.roll 361 deg",
                "ramp position.up 5 m", "step velocity.up 5 m", "dropout 2.5", "dropout -1 s", "dropout inf s",
                "latency 70000 ms", "latency 1 s", "clear all",
            ]
            .map(fault)
            .join("\n"),
            @r"
        '': allowed: step, bias, ramp, dropout, latency, clear
        'jump': allowed: step, bias, ramp, dropout, latency, clear
        'step': allowed: step AXIS VALUE UNIT, such as step position.up 5 m
        'ramp position.up 5': allowed: ramp AXIS VALUE UNIT, such as ramp position.east 0.5 m/s
        'bias position.up 5 m m': allowed: bias AXIS VALUE UNIT, such as bias attitude.heading 0.3 deg
        axis 'north': allowed: position.east, position.north, position.up, velocity.east, velocity.north, velocity.up, attitude.roll, attitude.pitch, attitude.heading
        value 'five': allowed: a number from -100000000 to 100000000 m
        value 'NaN': allowed: a number from -100000000 to 100000000 m
        value '361': allowed: a number from -360 to 360 deg
        unit 'm' of position.up: allowed: m/s
        unit 'm' of velocity.up: allowed: m/s
        'dropout 2.5': allowed: dropout SECONDS s, such as dropout 2.5 s
        value '-1': allowed: a number from 0 to 1000000 s
        value 'inf': allowed: a number from 0 to 1000000 s
        value '70000': allowed: a number from 0 to 60000 ms
        unit 's' of latency: allowed: ms
        'clear all': allowed: clear
        "
        );
    }
}
