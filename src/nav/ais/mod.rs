//! AIS logs: positions that vessels reported, as a table or as sentences.
//!
//! A **table** is comma-separated; its first line names the columns, in any order and case. Other columns are
//! passed over, and a field may be quoted. Three layouts are known: that of the first column below, that of
//! MarineCadastre, and that of the Danish Maritime Authority.
//!
//! | column | MarineCadastre | Danish | meaning |
//! | --- | --- | --- | --- |
//! | `Time` | `BaseDateTime` | `# Timestamp` | UTC of reception, ISO 8601 (`2016-01-12 13:02:11.218`), or `12/01/2016 13:02:11`, day first |
//! | `MMSI` | `MMSI` | `MMSI` | number of the vessel, up to nine digits |
//! | `Latitude_degrees`, `Longitude_degrees` | `LAT`, `LON` | `Latitude`, `Longitude` | position |
//! | `COG_degrees` | `COG` | `COG` | course over ground, clockwise from North |
//! | `SOG_knots` | `SOG` | `SOG` | speed over ground |
//! | `Length_metres`, `Beam_metres`, `Draught_metres` | `Length`, `Width`, `Draft` | `Length`, `Width`, `Draught` | optional |
//!
//! **Sentences** are `!AIVDM` and its like: see [`sentences`].
//!
//! A value that AIS declares unavailable (position 91 or 181, course 360, speed 102.3, size 0), "or more"
//! (speed 102.2), empty or out of its range costs what hangs on it, not the log: without position a row is
//! passed over, without course or speed a vessel cannot sail from it. Both are counted ([`PassedOver`]). A
//! field that is no number or no time is a fault: then the columns are not what they are called. All faults
//! of a file are reported together, with their lines. Rows may come in any order of time.
//!
//! ```
//! use nereus::nav::ais;
//! let text = "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n\
//!             2016-01-12 13:02:11.218,235070762,50.773,-1.093,157.8,5.9\n\
//!             2016-01-12 13:02:12.000,235070763,91,181,511,102.3\n";
//! let log = ais::parse(text.as_bytes()).unwrap();
//! assert_eq!((log.reports[0].mmsi, log.reports[0].course_deg), (235_070_762, Some(157.8)));
//! assert_eq!((log.reports.len(), log.passed_over.without_position), (1, 1));
//! let faults = ais::parse(text.replace("157.8", "east").as_bytes()).unwrap_err();
//! assert!(faults.to_string().contains("line 2: COG_degrees = 'east' is not a finite number"));
//! ```

pub mod encode;
pub mod sentences;
mod table;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::fmt;
use std::path::Path;

use super::faults::{FaultKind, Faults, NavError};
use super::unpacked;
use crate::nav::recording::MAX_FIXES;
use crate::time::TimeTag;
use crate::units::KNOT_MPS;

/// Speeds from here on are "102.2 knots or more", or not available.
const NO_SPEED_KNOTS: f64 = 102.2;
const MOST_SIZE_M: f64 = 1000.0;
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
    pub size_m: Size,
}

/// Length, beam and draught of a vessel, m.
pub type Size = [Option<f64>; 3];

/// What a log holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Its reports; sizes that a vessel states anywhere are in all of its reports.
    pub reports: Vec<Report>,
    /// What is no report.
    pub passed_over: PassedOver,
}

/// Rows and sentences of a log that say less than a report does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassedOver {
    /// Without a position or a vessel: no report.
    pub without_position: usize,
    /// Reports without course or speed: no vessel sails from them.
    pub without_motion: usize,
    /// Sentences with a wrong checksum, cut or garbled.
    pub damaged: usize,
    /// Position reports without a time: no report.
    pub without_time: usize,
}

impl PassedOver {
    /// Whether nothing was.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for PassedOver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.without_position, "without a position"),
            (self.without_motion, "without course or speed"),
            (self.damaged, "damaged"),
            (self.without_time, "without a time"),
        ];
        let named: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        f.write_str(&named.join(", "))
    }
}

/// Reads a log.
///
/// # Errors
/// A file that cannot be read, and all faults of its lines.
pub fn load(path: &Path) -> Result<Log, NavError> {
    parse(&unpacked::utf8(&unpacked::read(path)?))
        .map_err(|faults| NavError::Faulty { path: path.to_owned(), faults })
}

/// Reads the bytes of a log.
///
/// # Errors
/// All faults of its lines.
pub fn parse(bytes: &[u8]) -> Result<Log, Faults> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut collected = Collected::default();
    let mut faults = Faults::default();
    if sentences::are_in(bytes) {
        sentences::read(bytes, &mut collected, &mut faults);
    } else {
        table::read(bytes, &mut collected, &mut faults);
    }
    if faults.is_empty() { Ok(collected.log()) } else { Err(faults) }
}

/// A log being read.
#[derive(Default)]
struct Collected {
    reports: Vec<Report>,
    passed_over: PassedOver,
    sizes_m: HashMap<u32, Size>,
}

/// What a row or a message says of a vessel, as numbers of AIS.
struct Stated {
    mmsi: Option<f64>,
    lat_deg: Option<f64>,
    lon_deg: Option<f64>,
    course_deg: Option<f64>,
    knots: Option<f64>,
}

impl Collected {
    /// Whether there is room for another report; a fault otherwise.
    fn has_room(&self, line: u64, faults: &mut Faults) -> bool {
        let room = self.reports.len() < MAX_FIXES;
        if !room {
            faults.push(line, FaultKind::TooManyFixes { allowed: MAX_FIXES });
        }
        room
    }

    /// Keeps what is stated, if it is a report.
    fn push(&mut self, time: TimeTag, stated: &Stated) {
        let within = |value: Option<f64>, low: f64, high: f64| value.filter(|v| (low..=high).contains(v));
        let mmsi = within(stated.mmsi, 0.0, MOST_MMSI).filter(|mmsi| mmsi.fract() == 0.0);
        let place = (within(stated.lat_deg, -90.0, 90.0), within(stated.lon_deg, -180.0, 180.0));
        let (Some(mmsi), (Some(lat_deg), Some(lon_deg))) = (mmsi, place) else {
            self.passed_over.without_position += 1;
            return;
        };
        let course_deg = stated.course_deg.filter(|course| (0.0..360.0).contains(course));
        let knots = stated.knots.filter(|knots| (0.0..NO_SPEED_KNOTS).contains(knots));
        self.passed_over.without_motion += usize::from(course_deg.is_none() || knots.is_none());
        let speed_mps = knots.map(|knots| knots * KNOT_MPS);
        let size_m = [None; 3];
        let mmsi = mmsi as u32;
        self.reports.push(Report { time, mmsi, lat_deg, lon_deg, course_deg, speed_mps, size_m });
    }

    /// Keeps the size of a vessel: what is stated first stays.
    fn size(&mut self, mmsi: u32, size_m: Size) {
        let sound = size_m.map(|size| size.filter(|size| *size > 0.0 && *size <= MOST_SIZE_M));
        if sound != [None; 3] {
            let known = self.sizes_m.entry(mmsi).or_default();
            known.iter_mut().zip(sound).for_each(|(known, size)| *known = known.or(size));
        }
    }

    fn log(self) -> Log {
        let Self { mut reports, passed_over, sizes_m } = self;
        for report in &mut reports {
            report.size_m = sizes_m.get(&report.mmsi).copied().unwrap_or_default();
        }
        Log { reports, passed_over }
    }
}
