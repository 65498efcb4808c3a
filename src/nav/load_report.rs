//! What became of a file of navigation.

use std::fmt;

use serde::Serialize;

/// What was read of a file, what was skipped, and what was filled in.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LoadReport {
    /// The file.
    pub path: String,
    /// Lines read.
    pub lines: u64,
    /// Usable fixes.
    pub fixes: usize,
    /// From the first to the last fix, s.
    pub span_s: f64,
    /// The longest time between two fixes, s.
    pub longest_gap_s: f64,
    /// NMEA: sentences whose checksum is wrong (skipped).
    pub bad_checksum: u64,
    /// NMEA: sentences of a kind that is not used here (skipped).
    pub unknown_sentences: u64,
    /// NMEA: lines that are no sentence, or whose fields cannot be read (skipped).
    pub malformed: u64,
    /// NMEA: position sentences that say of themselves that they are void or empty (skipped).
    pub void_positions: u64,
    /// NMEA: fixes slightly earlier than one before (skipped).
    pub out_of_order: u64,
    /// Fixes beyond a step of the receiver's clock (skipped).
    pub clock_steps: u64,
    /// NMEA: positions of another talker than the one that is used (skipped).
    pub other_talkers: u64,
    /// NMEA: positions with the time of one before, elsewhere (skipped).
    pub repeated_times: u64,
    /// Dates that changed late or early at midnight or at the end of a GPS week, set right.
    pub dates_corrected: u64,
    /// NMEA: headings and speeds that were taken for the position after them.
    pub headings_ahead: u64,
    /// NMEA: fixes without a height of their own; see `nav::nmea` for what they get.
    pub heights_filled: u64,
    /// NMEA: fixes whose heading is interpolated between headings beside them.
    pub headings_filled: u64,
    /// What else should be known, in words.
    pub hints: Vec<String>,
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} fixes over {:.3} s from {} lines", self.fixes, self.span_s, self.lines)?;
        write!(f, ", longest gap {:.3} s", self.longest_gap_s)?;
        for note in self.notes() {
            write!(f, "; {note}")?;
        }
        Ok(())
    }
}

impl LoadReport {
    /// What was skipped, filled in and set right, and what else should be known.
    pub fn notes(&self) -> Vec<String> {
        let sentences = [
            (self.bad_checksum, "with a wrong checksum skipped"),
            (self.malformed, "malformed skipped"),
            (self.unknown_sentences, "of other kinds skipped"),
            (self.void_positions, "void positions skipped"),
        ];
        worded(&sentences).chain(self.notes_of_fixes()).collect()
    }

    /// The same of fixes alone.
    pub fn notes_of_fixes(&self) -> Vec<String> {
        let counts = [
            (self.out_of_order, "out of order skipped"),
            (self.clock_steps, "beyond a step of the clock skipped"),
            (self.other_talkers, "of another talker skipped"),
            (
                self.repeated_times,
                "with the time of the position before skipped (a clock of whole seconds, or two receivers in one log)",
            ),
            (self.dates_corrected, "dates set right that changed late or early"),
            (self.headings_ahead, "headings or speeds taken for the position after them"),
            (self.heights_filled, "heights filled in"),
            (self.headings_filled, "headings filled in"),
        ];
        worded(&counts).chain(self.hints.iter().cloned()).collect()
    }
}

/// Counts that are not zero, in words.
fn worded(counts: &[(u64, &str)]) -> impl Iterator<Item = String> {
    counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"))
}
