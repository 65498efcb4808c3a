//! AIS logs: positions that vessels reported, as comma-separated values.
//!
//! The first line names the columns, in any order; other columns are passed over. Of one row:
//!
//! | column | meaning |
//! | --- | --- |
//! | `Time` | UTC of reception, ISO 8601 (`2016-01-12 13:02:11.218`; a `T` and a `Z` may be there, other zones are refused) |
//! | `MMSI` | number of the vessel, up to nine digits |
//! | `Latitude_degrees`, `Longitude_degrees` | position; 91 and 181 say that it is not known: the row is passed over |
//! | `COG_degrees` | course over ground, clockwise from North; 360: not known |
//! | `SOG_knots` | speed over ground; 102.3: not known |
//! | `Length_metres`, `Beam_metres`, `Draught_metres` | optional, and may be empty or 0: not known |
//!
//! Rows may come in any order of time. All faults of a file are reported together, with their lines.
//!
//! ```
//! use nereus::nav::ais;
//! let text = "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n\
//!             2016-01-12 13:02:11.218,235070762,50.773,-1.093,157.8,5.9\n";
//! let reports = ais::parse(text.as_bytes()).unwrap();
//! assert_eq!((reports[0].mmsi, reports[0].course_deg), (235_070_762, Some(157.8)));
//! let faults = ais::parse(text.replace("157.8", "east").as_bytes()).unwrap_err();
//! assert!(faults.to_string().contains("line 2: COG_degrees = 'east' is not a finite number"));
//! ```

use std::path::Path;

use ::csv::ByteRecord;

use super::csv::{line_of, read_iso, read_number, reader_of};
use super::faults::{FaultKind, Faults, NavError};
use super::unpacked;
use crate::nav::recording::MAX_FIXES;
use crate::time::TimeTag;
use crate::units::KNOT_MPS;

const NEEDED: [&str; 6] =
    ["Time", "MMSI", "Latitude_degrees", "Longitude_degrees", "COG_degrees", "SOG_knots"];
const OPTIONAL: [&str; 3] = ["Length_metres", "Beam_metres", "Draught_metres"];
/// Course and speed that say nothing.
const NO_COURSE_DEG: f64 = 360.0;
const NO_SPEED_KNOTS: f64 = 102.3;
const MOST_MMSI: f64 = 999_999_999.0;

/// One report of a vessel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// When it was received.
    pub time: TimeTag,
    /// The vessel.
    pub mmsi: u32,
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Course over ground, clockwise from North, degrees.
    pub course_deg: Option<f64>,
    /// Speed over ground, m/s.
    pub speed_mps: Option<f64>,
    /// Length, beam and draught, m.
    pub size_m: [Option<f64>; 3],
}

/// Reads the reports of a log.
///
/// # Errors
/// A file that cannot be read, and all faults of its lines.
pub fn load(path: &Path) -> Result<Vec<Report>, NavError> {
    parse(&unpacked::utf8(&unpacked::read(path)?))
        .map_err(|faults| NavError::Faulty { path: path.to_owned(), faults })
}

/// Reads the reports in the bytes of a log.
///
/// # Errors
/// All faults of its lines.
pub fn parse(bytes: &[u8]) -> Result<Vec<Report>, Faults> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut faults = Faults::default();
    let mut reports = Vec::new();
    let mut reader = reader_of(bytes);
    let mut record = ByteRecord::new();
    let mut layout: Option<Layout> = None;
    while let Ok(true) = reader.read_byte_record(&mut record) {
        let line = line_of(bytes, &record);
        if record.len() == 1 && record[0].is_empty() {
            continue;
        }
        let Some(layout) = &layout else {
            layout = Layout::from_header(&record, line, &mut faults);
            if layout.is_none() {
                break;
            }
            continue;
        };
        if reports.len() >= MAX_FIXES {
            faults.push(line, FaultKind::TooManyFixes { allowed: MAX_FIXES });
            break;
        }
        reports.extend(layout.report(&record, line, &mut faults));
    }
    if layout.is_none() && faults.is_empty() {
        faults.push(1, FaultKind::Empty);
    }
    if faults.is_empty() { Ok(reports) } else { Err(faults) }
}

/// Which field of a row holds what.
struct Layout {
    fields: usize,
    needed: [usize; NEEDED.len()],
    optional: [Option<usize>; OPTIONAL.len()],
}

impl Layout {
    fn from_header(header: &ByteRecord, line: u64, faults: &mut Faults) -> Option<Self> {
        let mut place = |name: &'static str| {
            let mut found = (0..header.len()).filter(|&i| &header[i] == name.as_bytes());
            let first = found.next();
            if found.next().is_some() {
                faults.push(line, FaultKind::RepeatedColumn { name });
            }
            first
        };
        let needed = NEEDED.map(&mut place);
        let optional = OPTIONAL.map(&mut place);
        for name in NEEDED.into_iter().zip(needed).filter(|(_, place)| place.is_none()).map(|(name, _)| name)
        {
            faults.push(line, FaultKind::MissingColumns { needed: name });
        }
        if !faults.is_empty() {
            return None;
        }
        Some(Self { fields: header.len(), needed: needed.map(|place| place.unwrap_or(0)), optional })
    }

    /// The report of a row; `None` when it is faulty or has no position.
    fn report(&self, record: &ByteRecord, line: u64, faults: &mut Faults) -> Option<Report> {
        if record.len() != self.fields {
            faults.push(line, FaultKind::FieldCount { found: record.len(), expected: self.fields });
            return None;
        }
        let time = read_iso(&record[self.needed[0]], NEEDED[0]).map_err(|kind| faults.push(line, kind)).ok();
        let mut number = |place: usize, column: &'static str, range: (f64, f64)| {
            read_number(&record[place], column, range).map_err(|kind| faults.push(line, kind)).ok()
        };
        let ranges = [(0.0, MOST_MMSI), (-91.0, 91.0), (-181.0, 181.0), (0.0, 360.0), (0.0, NO_SPEED_KNOTS)];
        let mut values = [None; 5];
        for (i, range) in ranges.into_iter().enumerate() {
            values[i] = number(self.needed[i + 1], NEEDED[i + 1], range);
        }
        let mut sound = true;
        let mut size_m = [None; OPTIONAL.len()];
        for (i, place) in self.optional.into_iter().enumerate() {
            if let Some(place) = place.filter(|&place| !record[place].is_empty()) {
                let found = number(place, OPTIONAL[i], (0.0, 1000.0));
                sound &= found.is_some();
                size_m[i] = found.filter(|size| *size > 0.0);
            }
        }
        let [mmsi, lat_deg, lon_deg, course_deg, knots] = values;
        let (time, mmsi, lat_deg, lon_deg) = (time?, mmsi?, lat_deg?, lon_deg?);
        let (course_deg, knots) = (course_deg?, knots?);
        if mmsi.fract() != 0.0 {
            let text = mmsi.to_string();
            faults.push(line, FaultKind::NotANumber { column: NEEDED[1], text });
            return None;
        }
        if !sound || lat_deg.abs() > 90.0 || lon_deg.abs() > 180.0 {
            return None;
        }
        Some(Report {
            time,
            mmsi: mmsi as u32,
            lat_deg,
            lon_deg,
            course_deg: Some(course_deg).filter(|course| *course < NO_COURSE_DEG),
            speed_mps: Some(knots).filter(|knots| *knots < NO_SPEED_KNOTS).map(|knots| knots * KNOT_MPS),
            size_m,
        })
    }
}
