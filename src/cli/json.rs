//! Reports as JSON: valid whatever names and paths they hold, and harmless on a terminal.

use std::fmt::Write as _;

use crate::inputs::acts;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_stays_json() {
        let name = "a\u{202e}\u{7f}\u{9b}\u{200e}\u{2028}\u{2029}\u{61c}\u{1b}\n\"é";
        let mut report = crate::cli::report::Report::default();
        report.value("names", [name]);
        let text = report.json().unwrap();
        assert!(!text.contains(acts), "{text}");
        assert!(
            text.starts_with(r#"{"names":["a\u202e\u007f\u009b\u200e\u2028\u2029\u061c\u001b\n\"é""#),
            "{text}"
        );
        let back: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["names"][0], name);
    }
}
