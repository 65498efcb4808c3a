//! What can be wrong with a pattern file.

use std::path::PathBuf;

use thiserror::Error;

use super::columns::{Column, MOST_POINTS, Quantity};

const MOST_FAULTS: usize = 20;

/// Why a pattern file cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PatternError {
    /// It cannot be read.
    #[error("{quantity} {}: {source}", path.display())]
    Read {
        /// What it should hold.
        quantity: Quantity,
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is too large.
    #[error("{quantity} {}: more than 64 MiB", path.display())]
    TooLarge {
        /// What it should hold.
        quantity: Quantity,
        /// The file.
        path: PathBuf,
    },
    /// Its content is wrong.
    #[error("{quantity} {}:{}", path.display(), listed(faults))]
    Faults {
        /// What it should hold.
        quantity: Quantity,
        /// The file.
        path: PathBuf,
        /// Everything that is wrong with it.
        faults: Vec<PatternFault>,
    },
}

fn listed(faults: &[PatternFault]) -> String {
    faults.iter().map(|fault| format!("\n  {fault}")).collect()
}

/// One fault of a pattern file.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PatternFault {
    /// The header is none of those allowed.
    #[error("line {line}: header '{found}': {wanted} wanted")]
    Header {
        /// Line, from 1.
        line: u64,
        /// What stands there.
        found: String,
        /// What is allowed.
        wanted: &'static str,
    },
    /// Not text, or a row with too few or too many fields.
    #[error("line {line}: {found} fields, {wanted} wanted")]
    Fields {
        /// Line, from 1.
        line: u64,
        /// Fields found.
        found: usize,
        /// Fields that the header announces.
        wanted: usize,
    },
    /// Not CSV at all (bytes that are not UTF-8, an open quote).
    #[error("{what}")]
    Csv {
        /// The CSV reader's error.
        what: String,
    },
    /// A value that is no number or out of range.
    #[error("line {line}: {column} '{found}': {allowed} wanted")]
    Value {
        /// Line, from 1.
        line: u64,
        /// Column.
        column: Column,
        /// What stands there.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A point off the regular grid.
    #[error("line {line}: {column} {value} is not on the regular grid from {first} in steps of {step}")]
    OffGrid {
        /// Line, from 1.
        line: u64,
        /// Column.
        column: Column,
        /// The value, degrees.
        value: f64,
        /// Start of the grid, degrees.
        first: f64,
        /// Step of the grid, degrees.
        step: f64,
    },
    /// The same point twice.
    #[error("line {line}: az {az_deg} el {el_deg} is given already in line {before}")]
    Twice {
        /// Line, from 1.
        line: u64,
        /// Line of the first.
        before: u64,
        /// Azimuth, degrees.
        az_deg: f64,
        /// Elevation, degrees.
        el_deg: f64,
    },
    /// Points of the grid that no line gives.
    #[error("{missing} of {wanted} grid points are missing, the first at az {az_deg} el {el_deg}")]
    Holes {
        /// How many.
        missing: usize,
        /// Points of the grid.
        wanted: usize,
        /// Azimuth of the first, degrees.
        az_deg: f64,
        /// Elevation of the first, degrees.
        el_deg: f64,
    },
    /// An axis with fewer than two values.
    #[error("{column}: {found} value(s), at least 2 wanted")]
    TooFew {
        /// Column.
        column: Column,
        /// Values found.
        found: usize,
    },
    /// More points than allowed.
    #[error("more than {MOST_POINTS} grid points")]
    TooMany,
    /// The azimuths go more than once round.
    #[error("az_deg spans {span_deg} degrees: at most 360 wanted")]
    Span {
        /// From the first to the last azimuth, degrees.
        span_deg: f64,
    },
    /// A line of a Planet or GRASP file.
    #[error("line {line}: '{found}': {wanted} wanted")]
    Line {
        /// Line, from 1.
        line: u64,
        /// What stands there.
        found: String,
        /// What is allowed.
        wanted: &'static str,
    },
    /// What a Planet or GRASP file as a whole lacks.
    #[error("{what}")]
    Lacks {
        /// What, and what is allowed.
        what: String,
    },
    /// Further faults, not listed.
    #[error("and {0} more faults")]
    More(usize),
}

/// Faults, the first few kept and the others counted.
#[derive(Default)]
pub(super) struct Faults {
    pub list: Vec<PatternFault>,
    more: usize,
}

impl Faults {
    pub fn push(&mut self, fault: PatternFault) {
        if self.list.len() < MOST_FAULTS {
            self.list.push(fault);
        } else {
            self.more += 1;
        }
    }

    pub fn finish(mut self) -> Vec<PatternFault> {
        if self.more > 0 {
            self.list.push(PatternFault::More(self.more));
        }
        self.list
    }
}
