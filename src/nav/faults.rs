//! What can be wrong with a track file: every fault with its line, the value found and what is allowed.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

use crate::nav::load_report::LoadReport;
use crate::time::TimeTag;

/// Faults kept in full; the rest are only counted.
pub const FAULTS_KEPT: usize = 20;
/// Characters of a faulty value that are quoted.
const QUOTED_CHARS: usize = 40;

/// Why a track file gives no fixes.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NavError {
    /// The file cannot be opened or read.
    #[error("{}: cannot read the track file: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is larger than is read.
    #[error("{}: larger than {allowed_bytes} bytes; cut the stretch that is needed", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The most that is read.
        allowed_bytes: u64,
    },
    /// The file was read and holds faults.
    #[error("{}: {faults}", path.display())]
    Faulty {
        /// The file.
        path: PathBuf,
        /// All of them.
        faults: Faults,
    },
    /// A log of a receiver without a single usable fix.
    #[error("{}: no usable fix: {reason}\n  {report}", path.display())]
    NoFix {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: NoFix,
        /// What was read.
        report: Box<LoadReport>,
    },
}

/// Why a log of a receiver holds no usable fix.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoFix {
    /// Nothing in the file is an NMEA sentence with a right checksum.
    #[error("no line is an NMEA 0183 sentence with a right checksum")]
    NoSentence,
    /// Sentences, but none with a valid position and time.
    #[error("no GGA, GNS, RMC or GLL sentence has a valid position and a time of day")]
    NoPosition,
    /// Positions with a time of day, but no date.
    #[error(
        "positions have a time of day but no date: no RMC sentence, and no ZDA sentence with its date filled in; \
         give that of the first position: date = \"2024-05-01\" (nereus nav: --date 2024-05-01)"
    )]
    NoDate,
    /// Nothing in the file is an INSPVAX with a solution.
    #[error("no INSPVAX, INSPVA or INSPVAS message has a right checksum and a solution")]
    NoInspvax,
}

/// All faults of one file: the first [`FAULTS_KEPT`] in full, the others counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    kept: Vec<Fault>,
    more: usize,
}

impl Faults {
    /// Notes a fault. Gaps have one cause, and stand together where the first is.
    pub fn push(&mut self, line: u64, kind: FaultKind) {
        let gaps = self.kept.iter_mut().map(|fault| &mut fault.kind);
        if let FaultKind::Gap { time, gap_s, .. } = kind
            && let Some(FaultKind::Gap { gaps, longest_s, longest, .. }) =
                gaps.into_iter().find(|kept| matches!(kept, FaultKind::Gap { .. }))
        {
            *gaps += 1;
            if gap_s > *longest_s {
                (*longest_s, *longest) = (gap_s, time);
            }
        } else if self.kept.len() < FAULTS_KEPT || matches!(kind, FaultKind::Gap { .. }) {
            self.kept.push(Fault { line, kind });
        } else {
            self.more += 1;
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.kept.len() + self.more
    }

    /// Whether there are gaps, and nothing else.
    pub fn are_gaps(&self) -> bool {
        self.more == 0 && matches!(&self.kept[..], [Fault { kind: FaultKind::Gap { .. }, .. }])
    }

    /// Those kept in full.
    pub fn kept(&self) -> &[Fault] {
        &self.kept
    }

    /// Nothing if there is no fault, else the error that carries them all.
    pub(super) fn into_result(self, path: &std::path::Path) -> Result<(), NavError> {
        if self.is_empty() {
            return Ok(());
        }
        Err(NavError::Faulty { path: path.to_owned(), faults: self })
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count() {
            1 => write!(f, "1 fault")?,
            count => write!(f, "{count} faults")?,
        }
        for fault in &self.kept {
            write!(f, "\n  {fault}")?;
        }
        if self.more > 0 {
            write!(f, "\n  and {} more", self.more)?;
        }
        Ok(())
    }
}

/// One fault and its line (counted from 1; comment lines count).
#[derive(Clone, Debug, Error, PartialEq)]
#[error("line {line}: {kind}")]
pub struct Fault {
    /// Line of the file.
    pub line: u64,
    /// What is wrong there.
    pub kind: FaultKind,
}

/// What is wrong with a line.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FaultKind {
    /// A column that the format does not know.
    #[error("unknown column '{name}'; allowed: {allowed}")]
    UnknownColumn {
        /// As written.
        name: String,
        /// The columns that exist.
        allowed: &'static str,
    },
    /// A column without a name.
    #[error(
        "column {number} has no name, as the index of a data frame; allowed: named columns alone \
         (pandas: to_csv(..., index=False))"
    )]
    UnnamedColumn {
        /// Its number, from 1.
        number: usize,
    },
    /// A column given twice.
    #[error("column '{name}' is given twice")]
    RepeatedColumn {
        /// Its name.
        name: &'static str,
    },
    /// Columns that must be there are not.
    #[error("missing: {needed}")]
    MissingColumns {
        /// What must be there.
        needed: &'static str,
    },
    /// Columns that contradict each other.
    #[error("both {first} and {second} are given; give one of them")]
    ContradictingColumns {
        /// One.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A row with more or fewer fields than the header.
    #[error("{found} fields; the header has {expected}")]
    FieldCount {
        /// Fields of the row.
        found: usize,
        /// Columns of the header.
        expected: usize,
    },
    /// A field that is no number.
    #[error("{column} = '{text}' is not a finite number")]
    NotANumber {
        /// The column.
        column: &'static str,
        /// As written.
        text: String,
    },
    /// A number outside its range.
    #[error("{column} = {value} is out of range: {min} to {max}")]
    OutOfRange {
        /// The column.
        column: &'static str,
        /// As read.
        value: f64,
        /// Least allowed.
        min: f64,
        /// Most allowed.
        max: f64,
    },
    /// A field that is no time.
    #[error("{column} = '{text}' is not a time such as {example}")]
    NotATime {
        /// The column.
        column: &'static str,
        /// As written.
        text: String,
        /// A right one.
        example: &'static str,
    },
    /// A fix that is not later than the one before.
    #[error("time {time} is not later than {before} of the fix before: times must increase")]
    TimeOrder {
        /// Time of the fix.
        time: TimeTag,
        /// Time of the fix before it.
        before: TimeTag,
    },
    /// Too long without a fix.
    #[error(
        "no fix for {gap_s:.3} s before {time}{}; longest gap allowed: max_gap_s = {allowed_s} s; \
         max_gap_s = {} interpolates {}",
        if *gaps > 1 {
            format!(", the first of {gaps} gaps, the longest {longest_s:.3} s before {longest}")
        } else {
            String::new()
        },
        longest_s.ceil(),
        if *gaps > 1 { "them all" } else { "it" }
    )]
    Gap {
        /// Time of the fix after the first gap.
        time: TimeTag,
        /// Its length, s.
        gap_s: f64,
        /// Gaps of the file.
        gaps: u64,
        /// Length of the longest, s.
        longest_s: f64,
        /// Time of the fix after it.
        longest: TimeTag,
        /// `max_gap_s` of the source.
        allowed_s: f64,
    },
    /// Not enough fixes.
    #[error("the file ends; usable fixes: {found}, needed: at least {needed}")]
    TooFewFixes {
        /// Usable fixes.
        found: usize,
        /// Needed.
        needed: usize,
    },
    /// More fixes than are read.
    #[error("more than {allowed} fixes; cut the stretch that is needed")]
    TooManyFixes {
        /// The most that is read.
        allowed: usize,
    },
    /// The last record of a binary file is not whole.
    #[error("the file ends {found} bytes into a record of {needed}")]
    CutRecord {
        /// Bytes that are there.
        found: usize,
        /// Bytes of a record.
        needed: usize,
    },
    /// Records of the other byte order.
    #[error(
        "the records are big-endian; an SBET is little-endian: reverse the bytes of every f64 \
         (numpy: np.fromfile(path, '>f8').astype('<f8').tofile(out))"
    )]
    BigEndian,
    /// Records in degrees.
    #[error(
        "latitudes and longitudes are in degrees ({lat}, {lon}); an SBET has radians: multiply fields 2 and 3 \
         of each record by pi/180, and check its angles"
    )]
    Degrees {
        /// Latitude of the first record, as read.
        lat: f64,
        /// Its longitude.
        lon: f64,
    },
    /// Text that is no XML.
    #[error("this is no XML that can be read: {error}")]
    Xml {
        /// What the reader says.
        error: String,
    },
    /// Places without times.
    #[error("{places} places have no time; allowed: {allowed}")]
    Timeless {
        /// How many.
        places: u64,
        /// Where times must stand.
        allowed: &'static str,
    },
    /// Lists that should be of one length.
    #[error("{whens} <when> and {places} <gx:coord>; allowed: as many of the one as of the other")]
    Unpaired {
        /// Times.
        whens: usize,
        /// Places.
        places: usize,
    },
    /// No header at all.
    #[error("the file is empty; needed: a header line and fixes")]
    Empty,
    /// A table that is none of AIS.
    #[error(
        "missing: {missing}; allowed: the columns Time (UTC), MMSI, Latitude_degrees, Longitude_degrees, COG_degrees, SOG_knots, \
         or as MarineCadastre (BaseDateTime, MMSI, LAT, LON, COG, SOG) or the Danish Maritime Authority (# Timestamp, MMSI, \
         Latitude, Longitude, COG, SOG) names them; or sentences !AIVDM"
    )]
    NoAisColumns {
        /// The columns that are not there, by our names.
        missing: String,
    },
    /// AIS sentences without a single report.
    #[error(
        "no position report (messages 1, 2, 3, 18, 19) with a time among {messages} AIS messages{passed_over}; allowed: times in \
         tag blocks (\\c:1714564800*55\\ before a sentence), UNIX seconds after its checksum, or base station reports (message 4)"
    )]
    NoAisReport {
        /// Whole messages.
        messages: usize,
        /// What was counted besides.
        passed_over: String,
    },
}

impl FaultKind {
    /// One gap, before the fix at an instant.
    pub(super) fn gap(time: TimeTag, gap_s: f64, allowed_s: f64) -> Self {
        Self::Gap { time, gap_s, gaps: 1, longest_s: gap_s, longest: time, allowed_s }
    }
}

/// A piece of foreign text, short and printable, for an error message.
pub(super) fn quote(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * QUOTED_CHARS)]);
    let mut quoted: String = text
        .chars()
        .take(QUOTED_CHARS)
        .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
        .collect();
    if text.chars().count() > QUOTED_CHARS {
        quoted.push_str("...");
    }
    quoted
}
