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
    /// NMEA: fixes without a height of their own; see `nav::nmea` for what they get.
    pub heights_filled: u64,
    /// NMEA: fixes whose heading is interpolated between headings beside them.
    pub headings_filled: u64,
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} fixes over {:.3} s from {} lines", self.fixes, self.span_s, self.lines)?;
        write!(f, ", longest gap {:.3} s", self.longest_gap_s)?;
        for (count, what) in [
            (self.bad_checksum, "with a wrong checksum skipped"),
            (self.malformed, "malformed skipped"),
            (self.unknown_sentences, "of other kinds skipped"),
            (self.void_positions, "void positions skipped"),
            (self.out_of_order, "out of order skipped"),
            (self.heights_filled, "heights filled in"),
            (self.headings_filled, "headings filled in"),
        ] {
            if count > 0 {
                write!(f, "; {count} {what}")?;
            }
        }
        Ok(())
    }
}
