//! From a recorded file to fixes: one entry for every format.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, load};
//!
//! let path = std::env::temp_dir().join(format!("nereus-replay-{}.csv", std::process::id()));
//! std::fs::write(&path, "unix_s,x_m,y_m,z_m\n0,0,0,100\n1.5,150,0,100\n")?;
//! let source = FileSource {
//!     path: path.clone(),
//!     format: FileFormat::Csv,
//!     datum: VerticalDatum::Ellipsoid,
//!     undulation_m: 0.0,
//!     max_gap_s: 5.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Level,
//! };
//! let recording = load(&source)?;
//! assert_eq!(recording.fixes.len(), 2);
//! println!("{}", recording.report);
//! # std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::fmt;
use std::path::Path;

use serde::Serialize;

use super::faults::{FaultKind, Faults};
use super::{FileFormat, FileSource, Fix, NavError, Smoothing, VerticalDatum};
use crate::inputs;

/// The most bytes that are read of a file.
pub const MAX_FILE_BYTES: u64 = 1 << 30;
/// The most fixes that are read of a file (11 h at 100 Hz).
pub const MAX_FIXES: usize = 4_000_000;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Fixes, times strictly increasing.
    pub fixes: Vec<Fix>,
    /// What was read, skipped and filled in.
    pub report: LoadReport,
}

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

/// Reads the file of a source.
///
/// All faults of the file are reported at once, each with its line, value and what is allowed. Fixes come
/// back with times strictly increasing and no gap longer than `max_gap_s`; positions on Earth have
/// heights above the WGS-84 ellipsoid, whatever the datum of the file.
pub fn load(source: &FileSource) -> Result<Recording, NavError> {
    parse(&read_bytes(&source.path)?, source)
}

/// The bytes of a file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, NavError> {
    let read_error = |error| NavError::Read { path: path.to_owned(), source: error };
    let bytes = inputs::read(path, MAX_FILE_BYTES).map_err(read_error)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(NavError::TooLarge { path: path.to_owned(), allowed_bytes: MAX_FILE_BYTES });
    }
    Ok(bytes)
}

/// Reads fixes from the bytes of a file (its path is used in messages only).
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    match source.format {
        FileFormat::Csv => super::csv::parse(bytes, source),
        FileFormat::Nmea => super::nmea::parse(bytes, source),
        FileFormat::Inspvax => super::inspvax::parse(bytes, source),
        FileFormat::Sbet { gps_week } => super::sbet::parse(bytes, gps_week, source),
    }
}

/// Fixes that a source needs at least: two points make a line, the smoother needs one more than its
/// three states to have a residual.
pub(super) fn fixes_needed(source: &FileSource) -> usize {
    match source.smoothing {
        Smoothing::Off => 2,
        Smoothing::Rts { .. } => 4,
    }
}

/// Height above the ellipsoid from a height of the file.
pub(super) fn ellipsoidal_height_m(height_m: f64, source: &FileSource) -> f64 {
    match source.datum {
        VerticalDatum::Ellipsoid => height_m,
        VerticalDatum::MeanSeaLevel => height_m + source.undulation_m,
        VerticalDatum::Barometric { offset_m } => height_m + offset_m + source.undulation_m,
    }
}

/// Notes what is wrong between a fix and the one before it; false if the fix cannot be kept.
pub(super) fn follows(
    fixes: &[Fix],
    next: &Fix,
    line: u64,
    source: &FileSource,
    faults: &mut Faults,
) -> bool {
    let Some(before) = fixes.last() else { return true };
    let gap_s = next.time.since(before.time);
    if gap_s <= 0.0 {
        faults.push(line, FaultKind::TimeOrder { time: next.time, before: before.time });
        return false;
    }
    if gap_s > source.max_gap_s {
        faults.push(line, FaultKind::Gap { time: next.time, gap_s, allowed_s: source.max_gap_s });
    }
    true
}

/// Completes the report and wraps up, unless there are faults.
pub(super) fn finish(
    fixes: Vec<Fix>,
    mut report: LoadReport,
    mut faults: Faults,
    source: &FileSource,
) -> Result<Recording, NavError> {
    let needed = fixes_needed(source);
    if fixes.len() < needed && faults.is_empty() {
        faults.push(report.lines, FaultKind::TooFewFixes { found: fixes.len(), needed });
    }
    faults.into_result(&source.path)?;
    report.fixes = fixes.len();
    if let (Some(first), Some(last)) = (fixes.first(), fixes.last()) {
        report.span_s = last.time.since(first.time);
    }
    report.longest_gap_s = fixes.windows(2).map(|w| w[1].time.since(w[0].time)).fold(0.0, f64::max);
    Ok(Recording { fixes, report })
}
