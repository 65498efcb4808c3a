//! What a command found, stated once: rows for people and values for programs.
//!
//! A command adds titles, rows of a label and a text, and free lines; beside a row stand the values that it
//! shows, under their keys of `--json`. Text and JSON come from the same list, in the same order. A title
//! begins a section; labels of a section are aligned.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::error::CliError;
use super::say;
use crate::adequacy::description::Described;
use crate::inputs::escaped_json;

/// A line of the text.
enum Line {
    Title(String),
    Row { label: String, text: String },
    Free(String),
}

/// What a command found.
#[derive(Default)]
pub struct Report {
    lines: Vec<Line>,
    /// `"key":value`, in order.
    values: Vec<String>,
    fault: Option<serde_json::Error>,
}

impl Report {
    /// Begins a section.
    pub fn title(&mut self, text: impl Into<String>) -> &mut Self {
        self.lines.push(Line::Title(text.into()));
        self
    }

    /// A label and what there is to say; without a label it goes on with the row above.
    pub fn row(&mut self, label: impl Into<String>, text: impl Into<String>) -> &mut Self {
        self.lines.push(Line::Row { label: label.into(), text: text.into() });
        self
    }

    /// A line outside the columns.
    pub fn line(&mut self, text: impl Into<String>) -> &mut Self {
        self.lines.push(Line::Free(text.into()));
        self
    }

    /// A line that is a warning.
    pub fn warning(&mut self, text: impl std::fmt::Display) -> &mut Self {
        self.line(format!("warning: {text}"))
    }

    /// A section of rows; none without rows.
    pub fn section(&mut self, title: impl Into<String>, rows: &[Described]) -> &mut Self {
        if !rows.is_empty() {
            self.title(title);
        }
        rows.iter().fold(self, |report, row| report.row(&row.what, &row.how))
    }

    /// A value of the JSON object.
    pub fn value(&mut self, key: &str, value: impl Serialize) -> &mut Self {
        match serde_json::to_string(&value) {
            Ok(value) => self.values.push(format!("\"{key}\":{value}")),
            Err(fault) => self.fault = Some(fault),
        }
        self
    }

    /// Paths as a value of the JSON object, which is Unicode: it must not be lost because a path is not.
    pub fn paths(&mut self, key: &str, paths: impl IntoIterator<Item = impl AsRef<Path>>) -> &mut Self {
        let lossy = paths.into_iter().map(|path| path.as_ref().to_string_lossy().into_owned());
        self.value(key, lossy.collect::<Vec<_>>())
    }

    /// Every field of a struct as a value of the JSON object.
    pub fn values(&mut self, of: impl Serialize) -> &mut Self {
        match serde_json::to_string(&of) {
            Ok(object) => self.values.push(object[1..object.len() - 1].to_owned()),
            Err(fault) => self.fault = Some(fault),
        }
        self
    }

    /// The text: rows of a section under its title, labels aligned.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        for section in self.lines.chunk_by(|_, next| !matches!(next, Line::Title(_))) {
            let titled = matches!(section.first(), Some(Line::Title(_)));
            let indent = if titled { "  " } else { "" };
            let length =
                |line: &Line| if let Line::Row { label, .. } = line { label.chars().count() } else { 0 };
            let width = section.iter().map(length).max().unwrap_or(0);
            for line in section {
                let _ = match line {
                    Line::Title(line) | Line::Free(line) => writeln!(text, "{line}"),
                    Line::Row { label, text: row } => writeln!(text, "{indent}{label:width$}  {row}"),
                };
            }
        }
        text
    }

    /// One JSON object on a line.
    ///
    /// # Errors
    /// A value that JSON cannot hold.
    pub fn json(self) -> Result<String, CliError> {
        match self.fault {
            Some(fault) => Err(CliError::Output(fault.into())),
            None => Ok(escaped_json(format!("{{{}}}", self.values.join(",")))),
        }
    }

    /// Prints the text, or the object instead.
    pub(super) fn print(self, json: bool, out: &mut dyn Write) -> Result<(), CliError> {
        let text = if json { self.json()? + "\n" } else { self.text() };
        out.write_all(text.as_bytes()).map_err(CliError::Output)
    }

    /// Says the text on standard error, and prints the object if it is asked for.
    pub(super) fn say(self, json: bool, out: &mut dyn Write) -> Result<(), CliError> {
        let text = self.text();
        if json {
            writeln!(out, "{}", self.json()?).map_err(CliError::Output)?;
        }
        text.lines().for_each(say);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_json_come_from_the_same_rows() {
        #[derive(Serialize)]
        struct Sizes {
            pulses: u64,
            bytes: Option<u64>,
        }
        let mut report = Report::default();
        report.title("my.toml").value("scenario", "my.toml");
        report.row("speed", "2.5 pulses/s").value("pulses_per_s", 2.5).value("rms_m", f64::NAN);
        report.row("peak memory", "-").values(Sizes { pulses: 2, bytes: None });
        report.line("done").title("next").row("a", "b");
        assert_eq!(
            report.text(),
            "my.toml\n  speed        2.5 pulses/s\n  peak memory  -\ndone\nnext\n  a  b\n"
        );
        let json = r#"{"scenario":"my.toml","pulses_per_s":2.5,"rms_m":null,"pulses":2,"bytes":null}"#;
        assert_eq!(report.json().unwrap(), json);
    }

    #[test]
    fn what_acts_on_a_terminal_stays_json() {
        let name = "a\u{202e}\u{7f}\u{9b}\u{200e}\u{2028}\u{2029}\u{61c}\u{1b}\n\"é";
        let mut report = Report::default();
        report.value("name", name);
        let text = report.json().unwrap();
        let expected = r#"{"name":"a\u202e\u007f\u009b\u200e\u2028\u2029\u061c\u001b\n\"é"}"#;
        assert_eq!(text, expected);
        let back: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["name"], name);
    }
}
