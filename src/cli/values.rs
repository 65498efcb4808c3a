//! Values of arguments: what is read, and what is refused.

use std::collections::BTreeSet;
use std::ops::Range;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use thiserror::Error;

use super::error::Refused;
use crate::config::keys::{self, Kind};

/// What an option does not take, and what it does.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: {0}")]
pub struct Unreadable(String);

/// Reads a text, or reports what is allowed.
pub(super) fn allowed<T>(read: Option<T>, what: impl Into<String>) -> Result<T, Unreadable> {
    read.ok_or_else(|| Unreadable(what.into()))
}

/// A word of an option, its line of help, and what it stands for.
pub(super) type Word<T> = (&'static str, &'static str, T);

/// Reads one of some words.
pub(super) fn one_of<T: Clone + Send + Sync + 'static>(
    words: impl IntoIterator<Item = Word<T>>,
) -> impl TypedValueParser<Value = T> {
    let words: Vec<Word<T>> = words.into_iter().collect();
    let shown = words.iter().map(|(word, help, _)| PossibleValue::new(word).help(*help));
    PossibleValuesParser::new(shown).try_map(move |text| {
        let meant = words.iter().find(|(word, ..)| *word == text);
        allowed(meant.map(|(.., value)| value.clone()), "one of its words")
    })
}

/// The word that stands for a value.
pub(super) fn word_of<T: PartialEq>(words: &[Word<T>], value: &T) -> &'static str {
    words.iter().find(|(.., of)| of == value).map_or("", |(word, ..)| word)
}

/// Reads whole numbers within a range.
pub(super) fn counts(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<u64, Unreadable> + Clone + Send + Sync {
    move |text| {
        let count = text.parse().ok().filter(|count| (least..=most).contains(count));
        let most = if most == u64::MAX { "2^64 - 1".to_owned() } else { most.to_string() };
        allowed(count, format!("a whole number from {least} to {most}"))
    }
}

/// Refuses values outside a range, not-a-number among them.
pub(super) fn within<'a>(
    key: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
    [min, max]: [f64; 2],
) -> Result<(), Refused> {
    match values.into_iter().find(|value| !(min..=max).contains(*value)) {
        Some(value) => {
            Err(Refused::NotAllowed { key, value: value.to_string(), allowed: format!("{min} to {max}") })
        }
        None => Ok(()),
    }
}

/// Reads a number of pulses, or all.
pub(super) fn pulses_or_all(text: &str) -> Result<u64, &'static str> {
    let count = if text == "all" { Some(u64::MAX) } else { text.parse().ok() };
    count.ok_or("not a number of pulses; allowed: a whole number, or all")
}

/// Reads numbers of threads, as `stream.threads` has them.
pub(super) fn threads() -> impl Fn(&str) -> Result<u64, Unreadable> + Clone + Send + Sync {
    match keys::stream::THREADS.kind {
        Kind::Count { min, max } => counts(min, max),
        _ => counts(0, u64::MAX),
    }
}

/// The length of a run, as `scene.duration_s` has it; the text itself becomes part of the recorded scenario.
pub(super) fn duration(text: &str) -> Result<String, Unreadable> {
    let kind = &keys::scene::DURATION_S.kind;
    let fits = |seconds: &f64| match kind {
        Kind::Number { min, max, above, .. } => (min..=max).contains(&seconds) && !(*above && seconds == min),
        _ => seconds.is_finite(),
    };
    allowed(text.parse().ok().filter(fits).map(|_| text.to_owned()), kind.allowed())
}

/// A span of time, s.
pub(super) fn seconds(text: &str) -> Result<Duration, Unreadable> {
    let seconds = text.parse().ok().filter(|seconds: &f64| *seconds > 0.0 && *seconds <= 1e9);
    allowed(seconds.map(Duration::from_secs_f64), "a number of seconds above 0, up to 1e9")
}

/// What was asked for, each once, in the order of asking.
pub(super) fn distinct(mut places: Vec<usize>) -> Vec<usize> {
    let mut seen = BTreeSet::new();
    places.retain(|place| seen.insert(*place));
    places
}

/// A part of a run: pulses `first..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PulseRange {
    /// First pulse.
    pub first: u64,
    /// The pulse after the last one.
    pub end: u64,
}

impl FromStr for PulseRange {
    type Err = Unreadable;

    fn from_str(text: &str) -> Result<Self, Unreadable> {
        let range = text.split_once("..").and_then(|(first, end)| {
            let range = Self { first: first.parse().ok()?, end: end.parse().ok()? };
            (range.first < range.end).then_some(range)
        });
        allowed(range, "two whole numbers A..B, A below B, such as 100..200")
    }
}

impl From<PulseRange> for Range<u64> {
    fn from(range: PulseRange) -> Self {
        range.first..range.end
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

impl FromStr for Setting {
    type Err = Unreadable;

    fn from_str(text: &str) -> Result<Self, Unreadable> {
        let parts = text.split_once('=').map(|(key, value)| (key.trim(), value.trim()));
        let parts = parts.filter(|(key, value)| !key.is_empty() && !value.is_empty());
        let setting = parts.map(|(key, value)| Self { key: key.to_owned(), value: value.to_owned() });
        allowed(setting, "KEY=VALUE such as radar.prf_hz=500")
    }
}
