//! Values of arguments: what is read, and what is refused.

use std::str::FromStr;
use std::time::Duration;

use thiserror::Error;

use crate::config::keys::{self, Kind};

/// Not a whole number, or not one that is allowed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: a whole number from {least} to {}", if *most == u64::MAX { "2^64 - 1".to_owned() } else { most.to_string() })]
pub struct NotACount {
    /// The least allowed.
    pub least: u64,
    /// The most allowed.
    pub most: u64,
}

/// Reads whole numbers within a range.
pub(super) fn counts(least: u64, most: u64) -> impl Fn(&str) -> Result<u64, NotACount> + Clone + Send + Sync {
    move |text| {
        let count = text.parse().ok().filter(|count| (least..=most).contains(count));
        count.ok_or(NotACount { least, most })
    }
}

/// A value out of range.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} {value} is not allowed; allowed: {min} to {max}")]
pub struct OutOfRange {
    /// The option.
    pub key: &'static str,
    /// What was given.
    pub value: f64,
    /// Least allowed value.
    pub min: f64,
    /// Greatest allowed value.
    pub max: f64,
}

/// Refuses values outside a range, not-a-number among them.
pub(super) fn within(key: &'static str, values: &[f64], [min, max]: [f64; 2]) -> Result<(), OutOfRange> {
    match values.iter().find(|value| !(min..=max).contains(*value)) {
        Some(&value) => Err(OutOfRange { key, value, min, max }),
        None => Ok(()),
    }
}

/// Neither a number nor all.
#[derive(Debug, Error)]
#[error("not a number of pulses; allowed: a whole number, or all")]
pub(super) struct NotPulses;

/// Reads a number of pulses, or all.
pub(super) fn pulses_or_all(text: &str) -> Result<u64, NotPulses> {
    if text == "all" { Ok(u64::MAX) } else { text.parse().map_err(|_| NotPulses) }
}

/// Reads numbers of threads, as `stream.threads` has them.
pub(super) fn threads() -> impl Fn(&str) -> Result<u64, NotACount> + Clone + Send + Sync {
    match keys::stream::THREADS.kind {
        Kind::Count { min, max } => counts(min, max),
        _ => counts(0, u64::MAX),
    }
}

/// Not a length that a run can have.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: {}", keys::scene::DURATION_S.kind.allowed())]
pub struct NotADuration;

/// The length of a run, as `scene.duration_s` has it; the text itself becomes part of the recorded scenario.
pub(super) fn duration(text: &str) -> Result<String, NotADuration> {
    let seconds: f64 = text.parse().map_err(|_| NotADuration)?;
    let fits = match keys::scene::DURATION_S.kind {
        Kind::Number { min, max, above, .. } => (min..=max).contains(&seconds) && !(above && seconds == min),
        _ => seconds.is_finite(),
    };
    if fits { Ok(text.to_owned()) } else { Err(NotADuration) }
}

/// Not a span of time.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: a number of seconds above 0, up to 1e9")]
pub struct NotASpan;

pub(super) fn seconds(text: &str) -> Result<Duration, NotASpan> {
    let seconds: f64 = text.parse().map_err(|_| NotASpan)?;
    if seconds > 0.0 && seconds <= 1e9 { Ok(Duration::from_secs_f64(seconds)) } else { Err(NotASpan) }
}

/// What was asked for, each once, in the order of asking.
pub(super) fn distinct(places: Vec<usize>) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::with_capacity(places.len());
    for place in places {
        if !kept.contains(&place) {
            kept.push(place);
        }
    }
    kept
}

/// A part of a run: pulses `first..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PulseRange {
    /// First pulse.
    pub first: u64,
    /// The pulse after the last one.
    pub end: u64,
}

/// Not a range of pulses.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: two whole numbers A..B, A below B, such as 100..200")]
pub struct NotARange;

impl FromStr for PulseRange {
    type Err = NotARange;

    fn from_str(text: &str) -> Result<Self, NotARange> {
        let (first, end) = text.split_once("..").ok_or(NotARange)?;
        let (first, end) = (first.parse().map_err(|_| NotARange)?, end.parse().map_err(|_| NotARange)?);
        if first < end { Ok(Self { first, end }) } else { Err(NotARange) }
    }
}

/// `KEY=VALUE` of `--set`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Dotted path of the key.
    pub key: String,
    /// The value, TOML or plain text.
    pub value: String,
}

/// Not `KEY=VALUE`.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: KEY=VALUE such as radar.prf_hz=500")]
pub struct NotASetting;

impl FromStr for Setting {
    type Err = NotASetting;

    fn from_str(text: &str) -> Result<Self, NotASetting> {
        let (key, value) = text.split_once('=').ok_or(NotASetting)?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err(NotASetting);
        }
        Ok(Self { key: key.to_owned(), value: value.to_owned() })
    }
}
