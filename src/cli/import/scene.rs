//! A scene that is being imported, and how lines of a scenario are written.

use std::fmt::Write as _;
use std::path::Path;

use super::reading::{Names, Reading};
use super::tree::Element;

pub(super) const ANY: [f64; 2] = [-1e12, 1e12];
pub(super) const POSITIVE: [f64; 2] = [1e-12, 1e15];
pub(super) const NOT_NEGATIVE: [f64; 2] = [0.0, 1e15];

/// What is known of a scene while it is read.
pub(super) struct Import<'a> {
    pub reading: Reading,
    pub folder: &'a Path,
    pub names: Names,
    pub files: Vec<(String, String)>,
    pub waveforms: Vec<&'a Element>,
    pub antennas: Vec<&'a Element>,
    pub rate_hz: f64,
    pub begin_s: f64,
    pub end_s: f64,
    pub in_degrees: bool,
}

/// Adds a line.
pub(super) fn put(text: &mut String, line: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{line}");
}
