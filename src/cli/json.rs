//! Reports as JSON: valid whatever names and paths they hold, and harmless on a terminal.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::error::CliError;
use crate::inputs::acts;

/// A report as one JSON object on a line.
pub(super) fn json(report: &impl Serialize) -> Result<String, CliError> {
    serde_json::to_string(report).map(escaped).map_err(|error| CliError::Output(error.into()))
}

/// JSON without what acts on a terminal, which is escaped as JSON has it: serde_json escapes only what is
/// below U+0020, and [`super::escape::Printable`] would write the rest as `\u{202e}`, which is no JSON.
pub(super) fn escaped(plain: String) -> String {
    if !plain.contains(acts) {
        return plain;
    }
    let mut text = String::with_capacity(plain.len() + 16);
    // Such characters stand within strings only.
    for c in plain.chars() {
        if acts(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                // Writing to a String cannot fail.
                let _ = write!(text, "\\u{unit:04x}");
            }
        } else {
            text.push(c);
        }
    }
    text
}

/// Prints a report as one line of JSON.
pub(super) fn print(report: &impl Serialize, out: &mut dyn Write) -> Result<(), CliError> {
    writeln!(out, "{}", json(report)?).map_err(CliError::Output)
}

/// A path as a report shows it: JSON is Unicode, and a report must not be lost because a path is not.
pub(super) fn legible(path: &Path) -> PathBuf {
    path.to_string_lossy().into_owned().into()
}

/// The same of several.
pub(super) fn all_legible(paths: &[PathBuf]) -> Vec<PathBuf> {
    paths.iter().map(|path| legible(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_stays_json() {
        let name = "a\u{202e}\u{7f}\u{9b}\u{200e}\u{2028}\u{2029}\u{61c}\u{1b}\n\"é";
        let text = json(&[name]).unwrap();
        assert!(!text.contains(acts), "{text}");
        assert!(text.starts_with(r#"["a\u202e\u007f\u009b\u200e\u2028\u2029\u061c\u001b\n\"é""#), "{text}");
        let back: Vec<String> = serde_json::from_str(&text).unwrap();
        assert_eq!(back, [name]);
    }
}
