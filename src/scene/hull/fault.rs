//! What may be wrong with a hull, reported all at once.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

use crate::inputs::reason;
use crate::scene::hull::limits::MOST_BYTES;
use crate::scene::hull::limits::{LENGTH_RANGE_M, MOST_STATIONS, MOST_WATERLINES};

/// Faults that are listed; the rest are counted.
const LISTED: usize = 50;

/// Why there is no hull.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum HullError {
    /// A file cannot be read.
    #[error("hull {}: cannot be read: {}", path.display(), reason(*kind))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        kind: std::io::ErrorKind,
    },
    /// Files or numbers with faults.
    #[error("hull {name}: {}", listed(faults))]
    Faulty {
        /// File or name of the hull.
        name: String,
        /// All of them.
        faults: Vec<HullFault>,
    },
    /// A length that no hull has.
    #[error("hull of {value_m} m: allowed are {least_m} to {most_m} m")]
    Length {
        /// What was asked, m.
        value_m: f64,
        /// Least allowed, m.
        least_m: f64,
        /// Most allowed, m.
        most_m: f64,
    },
}

impl HullError {
    pub(super) fn faulty(name: &str, faults: Vec<HullFault>) -> Self {
        Self::Faulty { name: name.to_owned(), faults }
    }
}

fn listed(faults: &[HullFault]) -> String {
    let mut text = match faults.len() {
        1 => "1 fault".to_owned(),
        count => format!("{count} faults"),
    };
    for fault in faults.iter().take(LISTED) {
        text.push_str(&format!("\n  {fault}"));
    }
    if faults.len() > LISTED {
        text.push_str(&format!("\n  and {} more", faults.len() - LISTED));
    }
    text
}

/// One fault.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{place}: {what}")]
pub struct HullFault {
    /// Where.
    pub place: Place,
    /// What is wrong there.
    pub what: What,
}

/// Where a fault is.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// In a file.
    Line {
        /// The file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
    },
    /// A station of numbers that came from no file, from 0.
    Station(usize),
    /// A waterline, from 0.
    Waterline(usize),
    /// The numbers as a whole.
    Whole,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { path, line } => write!(f, "{} line {line}", path.display()),
            Self::Station(index) => write!(f, "station {index}"),
            Self::Waterline(index) => write!(f, "waterline {index}"),
            Self::Whole => f.write_str("the hull"),
        }
    }
}

/// What is wrong.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum What {
    /// A file too long.
    #[error("more than {MOST_BYTES} bytes")]
    Long,
    /// A file that is no text.
    #[error("not UTF-8 text")]
    Encoding,
    /// A file that cannot be read.
    #[error("{} cannot be read: {}", path.display(), reason(*kind))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        kind: std::io::ErrorKind,
    },
    /// No TOML.
    #[error("{message}")]
    Syntax {
        /// The reader's error.
        message: String,
    },
    /// A key that does not exist.
    #[error("unknown key {key}; allowed: {allowed}")]
    UnknownKey {
        /// As written.
        key: String,
        /// The keys that exist there.
        allowed: String,
    },
    /// A key that is missing.
    #[error("{key} is missing; allowed: {allowed}")]
    MissingKey {
        /// The key.
        key: String,
        /// What it may be.
        allowed: &'static str,
    },
    /// A value that is not allowed.
    #[error("{key} = {value} is not allowed; allowed: {allowed}")]
    Value {
        /// The key.
        key: String,
        /// As written.
        value: String,
        /// What it may be.
        allowed: &'static str,
    },
    /// A name given twice.
    #[error("the name '{name}' is given twice; allowed: one scatterer a name")]
    Twice {
        /// The name.
        name: String,
    },
    /// No or another header.
    #[error("the header must be x_m/z_m and then the waterlines, m")]
    Header,
    /// A row with too few or too many fields.
    #[error("{found} fields; needed are {needed}: the station, then a half-breadth for each waterline")]
    Fields {
        /// Fields found.
        found: usize,
        /// Fields of the header.
        needed: usize,
    },
    /// An empty field.
    #[error("nothing in column {column}; allowed: a half-breadth, 0 where there is no hull")]
    Hole {
        /// The column, from 1.
        column: usize,
    },
    /// A field that is no number.
    #[error("column {column} is '{text}'; allowed: a finite number")]
    Number {
        /// The column, from 1.
        column: usize,
        /// As written.
        text: String,
    },
    /// A number that is none.
    #[error("{value} where a finite number is needed")]
    NotFinite {
        /// The value.
        value: f64,
    },
    /// Counts that do not fit together.
    #[error("{found} half-breadths; needed are {needed}: stations times waterlines")]
    Count {
        /// Half-breadths found.
        found: usize,
        /// Half-breadths needed.
        needed: usize,
    },
    /// A half-breadth below zero.
    #[error("half-breadth {value_m} m at waterline {waterline_m} m is negative; allowed: 0 and above")]
    Negative {
        /// The half-breadth, m.
        value_m: f64,
        /// Its waterline, m.
        waterline_m: f64,
    },
    /// A station that is not behind the one before.
    #[error("station {value_m} m follows {before_m} m; allowed: increasing from bow to stern")]
    StationOrder {
        /// The station, m.
        value_m: f64,
        /// The one before, m.
        before_m: f64,
    },
    /// A waterline that is not above the one before.
    #[error("waterline {value_m} m follows {before_m} m; allowed: increasing from the keel to 0")]
    WaterlineOrder {
        /// The waterline, m.
        value_m: f64,
        /// The one before, m.
        before_m: f64,
    },
    /// The last waterline is not the design waterline.
    #[error("the last waterline is {value_m} m; allowed: 0, the design waterline")]
    TopWaterline {
        /// The waterline, m.
        value_m: f64,
    },
    /// A number of stations that makes no panels.
    #[error("{found} stations; allowed: an odd number, 3 to {MOST_STATIONS}")]
    Stations {
        /// Stations found.
        found: usize,
    },
    /// A number of waterlines that makes no panels.
    #[error("{found} waterlines; allowed: an odd number, 3 to {MOST_WATERLINES}")]
    Waterlines {
        /// Waterlines found.
        found: usize,
    },
    /// A node too far from the middle of its panel.
    #[error(
        "{value_m} m lies too far from the middle of {from_m} to {to_m} m; allowed: between its quarter points"
    )]
    Uneven {
        /// The node, m.
        value_m: f64,
        /// Where its panel begins, m.
        from_m: f64,
        /// Where its panel ends, m.
        to_m: f64,
    },
    /// An absurd size.
    #[error("{what} is {value_m} m; allowed: {least_m} to {most_m} m")]
    Size {
        /// What.
        what: &'static str,
        /// Its size, m.
        value_m: f64,
        /// Least allowed, m.
        least_m: f64,
        /// Most allowed, m.
        most_m: f64,
    },
    /// Nothing below the waterline.
    #[error("no volume; allowed: offsets that displace water (lengths are {} to {} m)", LENGTH_RANGE_M[0], LENGTH_RANGE_M[1])]
    Empty,
    /// A stated particular that the table does not bear out.
    #[error(
        "{quantity} is stated as {stated}, the table gives {computed:.6}; allowed: within {tolerance_percent} percent"
    )]
    Differs {
        /// Which.
        quantity: &'static str,
        /// As stated.
        stated: f64,
        /// From the table.
        computed: f64,
        /// What is allowed, percent.
        tolerance_percent: f64,
    },
}
