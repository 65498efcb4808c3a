//! Track files as comma-separated values.
//!
//! The first line that is neither empty nor a comment (`#`) names the columns, in any order:
//!
//! | columns | meaning |
//! | --- | --- |
//! | `time_utc` | ISO 8601 UTC, `2018-05-30T18:40:00.25Z` (the `Z` may be missing; an offset such as `+02:00` is taken off) |
//! | `unix_s` | instead of it: UTC seconds since 1970-01-01 without leap seconds, decimal |
//! | `lat_deg`, `lon_deg`, `height_m` | WGS-84 position; what the height is measured from is set by [`VerticalDatum`](super::VerticalDatum) of the source, not by the file |
//! | `x_m`, `y_m`, `z_m` | instead of them: East, North, up in the scene frame; needs no origin, and the datum is not used |
//! | `yaw_deg`, `pitch_deg`, `roll_deg` | optional, all three: clockwise from North, nose up, right wing down |
//!
//! Angles are local to the fix (its own North and vertical) with `lat_deg..`, and relative to the axes of
//! the scene frame with `x_m..`. Unknown columns are refused by name. Fractions of a second are read from
//! the text, so that no digit of a time is lost. All faults of a file are reported together, with
//! their lines; times must increase and no gap may be longer than `max_gap_s`. Fields are never quoted.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, MotionBounds, Smoothing, VerticalDatum, csv};
//!
//! let source = FileSource {
//!     path: "track.csv".into(),
//!     format: FileFormat::Csv,
//!     datum: VerticalDatum::MeanSeaLevel,
//!     undulation_m: 43.0,
//!     max_gap_s: 5.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Level,
//!     first_day: None,
//!     bounds: MotionBounds::SPACECRAFT,
//! };
//! let text = "# a comment\ntime_utc,lat_deg,lon_deg,height_m\n\
//!             2018-05-30T18:40:00Z,53.1,4.6,4267\n2018-05-30T18:40:01Z,53.101,4.6,4267\n";
//! let recording = csv::parse(text.as_bytes(), &source)?;
//! assert_eq!(recording.report.fixes, 2);
//! # Ok::<(), nereus::nav::NavError>(())
//! ```

use std::path::Path;

use ::csv::{ByteRecord, Reader, ReaderBuilder, Trim};

use super::faults::{FaultKind, Faults, NavError, quote};
use super::recording;
use super::{FileSource, Fix, Place, unpacked};
use crate::frames::{Geodetic, Point};
use crate::nav::load_report::LoadReport;
use crate::nav::recording::{MAX_FIXES, Recording};
use crate::time::TimeTag;

/// The header of a track lies within so much of it.
const HEAD_BYTES: u64 = 1 << 16;

const COLUMNS: [&str; 11] = [
    "time_utc",
    "unix_s",
    "lat_deg",
    "lon_deg",
    "height_m",
    "x_m",
    "y_m",
    "z_m",
    "yaw_deg",
    "pitch_deg",
    "roll_deg",
];
const ALLOWED: &str =
    "time_utc or unix_s; lat_deg, lon_deg, height_m or x_m, y_m, z_m; yaw_deg, pitch_deg, roll_deg";
/// Anything that flies, to geostationary height and beyond; below, the deepest shore.
const HEIGHT_RANGE_M: (f64, f64) = (-1_000.0, 1e8);
const LOCAL_RANGE_M: (f64, f64) = (-1e8, 1e8);
/// Years 1 to 9999, so that every accepted time can be printed.
const UNIX_RANGE_S: (f64, f64) = (-62_135_596_800.0, 253_402_300_799.0);

/// Reads fixes from the bytes of a CSV track.
///
/// # Errors
/// All faults of the file, each with its line.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut faults = Faults::default();
    let mut fixes = Vec::new();
    let mut report = LoadReport {
        path: source.path.display().to_string(),
        lines: bytes.iter().filter(|&&b| b == b'\n').count() as u64
            + u64::from(!bytes.is_empty() && !bytes.ends_with(b"\n")),
        ..LoadReport::default()
    };
    let mut reader = reader_of(bytes);
    let mut record = ByteRecord::new();
    let mut layout: Option<Layout> = None;
    let mut header_read = false;
    // Reading from memory does not fail, and a flexible byte record has no other error.
    while let Ok(true) = reader.read_byte_record(&mut record) {
        let line = line_of(bytes, &record);
        // A line of blanks only is an empty line.
        if record.len() == 1 && record[0].is_empty() {
            continue;
        }
        if !header_read {
            header_read = true;
            layout = Layout::from_header(&record, line, &mut faults);
            if layout.is_none() {
                break;
            }
            continue;
        }
        let Some(layout) = &layout else { break };
        if fixes.len() >= MAX_FIXES {
            faults.push(line, FaultKind::TooManyFixes { allowed: MAX_FIXES });
            break;
        }
        if let Some(fix) = layout.fix(&record, line, source, &mut faults)
            && recording::follows(&fixes, &fix, line, source, &mut faults)
        {
            fixes.push(fix);
        }
    }
    if !header_read {
        faults.push(1, FaultKind::Empty);
    }
    report.lines = report.lines.max(1);
    recording::finish(fixes, report, faults, source)
}

/// Whether the header of a CSV track names latitudes or longitudes; no if it cannot be read.
pub fn is_geodetic(path: &Path) -> bool {
    let bytes = unpacked::beginning(path, HEAD_BYTES);
    let bytes = unpacked::utf8(&bytes);
    let mut reader = reader_of(&bytes);
    let mut header = ByteRecord::new();
    while matches!(reader.read_byte_record(&mut header), Ok(true)) {
        if header.len() != 1 || !header[0].is_empty() {
            return header.iter().any(|name| matches!(name, b"lat_deg" | b"lon_deg"));
        }
    }
    false
}

/// A reader of lines with fields of any number, comments left out. Without quotes a record is a line,
/// whatever the bytes.
pub(super) fn reader_of(bytes: &[u8]) -> Reader<&[u8]> {
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .quoting(false)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes)
}

/// The line of a record. The reader gives the place where it began to look, which is before the comments
/// and empty lines that it passed over.
pub(super) fn line_of(bytes: &[u8], record: &ByteRecord) -> u64 {
    let Some(position) = record.position() else { return 1 };
    let mut line = position.line();
    let mut at = (position.byte() as usize).min(bytes.len());
    while at < bytes.len() {
        match bytes[at] {
            b'\n' => {
                line += 1;
                at += 1;
            }
            b'\r' => at += 1,
            b'#' => at += bytes[at..].iter().position(|&b| b == b'\n').unwrap_or(bytes.len() - at),
            _ => break,
        }
    }
    line
}

/// Which field of a row holds what.
struct Layout {
    fields: usize,
    time: Time,
    position: Position,
    attitude: Option<[usize; 3]>,
}

enum Time {
    Iso(usize),
    Unix(usize),
}

enum Position {
    Geodetic([usize; 3]),
    Local([usize; 3]),
}

impl Layout {
    fn from_header(header: &ByteRecord, line: u64, faults: &mut Faults) -> Option<Self> {
        let mut place = [None; COLUMNS.len()];
        let before = faults.count();
        for (index, name) in header.iter().enumerate() {
            match COLUMNS.iter().position(|known| known.as_bytes() == name) {
                None if name.is_empty() => {
                    faults.push(line, FaultKind::UnnamedColumn { number: index + 1 });
                }
                None => {
                    faults.push(line, FaultKind::UnknownColumn { name: quote(name), allowed: ALLOWED });
                }
                Some(column) if place[column].is_some() => {
                    faults.push(line, FaultKind::RepeatedColumn { name: COLUMNS[column] });
                }
                Some(column) => place[column] = Some(index),
            }
        }
        let three = |first: usize| match (place[first], place[first + 1], place[first + 2]) {
            (Some(a), Some(b), Some(c)) => Some([a, b, c]),
            _ => None,
        };
        let any = |first: usize| place[first..first + 3].iter().any(Option::is_some);
        let mut refuse = |kind| faults.push(line, kind);

        let time = match (place[0], place[1]) {
            (Some(iso), None) => Some(Time::Iso(iso)),
            (None, Some(unix)) => Some(Time::Unix(unix)),
            (Some(_), Some(_)) => {
                refuse(FaultKind::ContradictingColumns { first: "time_utc", second: "unix_s" });
                None
            }
            (None, None) => {
                refuse(FaultKind::MissingColumns { needed: "time_utc or unix_s" });
                None
            }
        };
        let position = match (three(2), three(5)) {
            (Some(columns), None) if !any(5) => Some(Position::Geodetic(columns)),
            (None, Some(columns)) if !any(2) => Some(Position::Local(columns)),
            _ if any(2) && any(5) => {
                refuse(FaultKind::ContradictingColumns {
                    first: "lat_deg, lon_deg, height_m",
                    second: "x_m, y_m, z_m",
                });
                None
            }
            _ => {
                refuse(FaultKind::MissingColumns {
                    needed: "lat_deg, lon_deg and height_m, or x_m, y_m and z_m",
                });
                None
            }
        };
        let attitude = three(8);
        if attitude.is_none() && any(8) {
            refuse(FaultKind::MissingColumns { needed: "all of yaw_deg, pitch_deg and roll_deg, or none" });
        }
        if faults.count() > before {
            return None;
        }
        Some(Self { fields: header.len(), time: time?, position: position?, attitude })
    }

    fn fix(&self, record: &ByteRecord, line: u64, source: &FileSource, faults: &mut Faults) -> Option<Fix> {
        if record.len() != self.fields {
            faults.push(line, FaultKind::FieldCount { found: record.len(), expected: self.fields });
            return None;
        }
        let mut number = |index: usize, column: &'static str, range: (f64, f64)| {
            let result = read_number(&record[index], column, range);
            result.map_err(|kind| faults.push(line, kind)).ok()
        };
        // Every field is read before the row is given up, so that all its faults are reported.
        let place = match self.position {
            Position::Geodetic([lat, lon, height]) => {
                let lat = number(lat, "lat_deg", (-90.0, 90.0));
                let lon = number(lon, "lon_deg", (-180.0, 180.0));
                let height = number(height, "height_m", HEIGHT_RANGE_M);
                lat.zip(lon).zip(height).map(|((lat, lon), height)| {
                    let h_m = recording::ellipsoidal_height_m(height, source);
                    Place::Geodetic(Geodetic::from_deg(lat, lon, h_m))
                })
            }
            Position::Local([x, y, z]) => {
                let x = number(x, "x_m", LOCAL_RANGE_M);
                let y = number(y, "y_m", LOCAL_RANGE_M);
                let z = number(z, "z_m", LOCAL_RANGE_M);
                x.zip(y).zip(z).map(|((x, y), z)| Place::Local(Point::new(x, y, z)))
            }
        };
        let attitude = match self.attitude {
            None => Some(None),
            Some([yaw, pitch, roll]) => {
                let yaw = number(yaw, "yaw_deg", (-360.0, 360.0));
                let pitch = number(pitch, "pitch_deg", (-90.0, 90.0));
                let roll = number(roll, "roll_deg", (-180.0, 180.0));
                yaw.zip(pitch)
                    .zip(roll)
                    .map(|((yaw, pitch), roll)| Some([yaw, pitch, roll].map(f64::to_radians)))
            }
        };
        let time = match self.time {
            Time::Iso(index) => read_iso(&record[index], "time_utc"),
            Time::Unix(index) => read_unix(&record[index]),
        };
        let time = time.map_err(|kind| faults.push(line, kind)).ok();
        Some(Fix { yaw_pitch_roll_rad: attitude?, ..Fix::at(time?, place?) })
    }
}

pub(super) fn read_number(
    field: &[u8],
    column: &'static str,
    (min, max): (f64, f64),
) -> Result<f64, FaultKind> {
    let parsed = std::str::from_utf8(field).ok().and_then(|text| text.parse::<f64>().ok());
    match parsed {
        Some(value) if (min..=max).contains(&value) => Ok(value),
        Some(value) if value.is_finite() => Err(FaultKind::OutOfRange { column, value, min, max }),
        _ => Err(FaultKind::NotANumber { column, text: quote(field) }),
    }
}

pub(super) fn read_iso(field: &[u8], column: &'static str) -> Result<TimeTag, FaultKind> {
    let bad = || FaultKind::NotATime { column, text: quote(field), example: "2018-05-30T18:40:00.25Z" };
    // The shape is checked here, so that nothing is passed over.
    let shape = b"dddd-dd-ddTdd:dd:dd";
    let well_formed = field.len() >= shape.len()
        && field.iter().zip(shape).all(|(&byte, &want)| match want {
            b'd' => byte.is_ascii_digit(),
            b'T' => byte == b'T' || byte == b' ',
            _ => byte == want,
        });
    if !well_formed || &field[..4] == b"0000" {
        return Err(bad());
    }
    let rest = &field[shape.len()..];
    let (rest, ahead_s) = match rest {
        [rest @ .., b'Z' | b'z'] => (rest, 0),
        [rest @ .., sign @ (b'+' | b'-'), h1, h2, b':', m1, m2]
        | [rest @ .., sign @ (b'+' | b'-'), h1, h2, m1, m2] => {
            let figure = |tens: &u8, ones: &u8| match (tens, ones) {
                (b'0'..=b'9', b'0'..=b'9') => Some(i64::from(10 * (tens - b'0') + (ones - b'0'))),
                _ => None,
            };
            let (hours, minutes) = figure(h1, h2).zip(figure(m1, m2)).ok_or_else(bad)?;
            let ahead_s = 3600 * hours + 60 * minutes;
            (rest, if *sign == b'-' { -ahead_s } else { ahead_s })
        }
        rest => (rest, 0),
    };
    let fraction_ok = match rest.split_first() {
        None => true,
        Some((b'.', digits)) => !digits.is_empty() && digits.iter().all(u8::is_ascii_digit),
        Some(_) => false,
    };
    let utc = &field[..shape.len() + rest.len()];
    let text = std::str::from_utf8(utc).ok().filter(|_| fraction_ok).ok_or_else(bad)?;
    let time = TimeTag::from_iso8601(&text.replacen(' ', "T", 1)).map_err(|_| bad())?;
    Ok(TimeTag::new(time.seconds() - ahead_s, time.fraction_s()))
}

/// Days since 1970-01-01 of a date such as `2024-05-01`.
pub fn day(date: &str) -> Option<i64> {
    if date.len() != 10 {
        return None;
    }
    let midnight = read_iso(format!("{date}T00:00:00").as_bytes(), "date").ok()?;
    Some(midnight.seconds().div_euclid(86_400))
}

fn read_unix(field: &[u8]) -> Result<TimeTag, FaultKind> {
    let bad = || FaultKind::NotATime { column: "unix_s", text: quote(field), example: "1527705600.25" };
    let text = std::str::from_utf8(field).map_err(|_| bad())?;
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, "0"));
    let is_digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    if !is_digits(whole) || !is_digits(fraction) {
        return Err(bad());
    }
    let seconds: i64 = whole.parse().map_err(|_| bad())?;
    let fraction_s: f64 = format!("0.{fraction}").parse().map_err(|_| bad())?;
    let value = if negative { -(seconds as f64) } else { seconds as f64 };
    let (min, max) = UNIX_RANGE_S;
    if !(min..=max).contains(&value) {
        return Err(FaultKind::OutOfRange { column: "unix_s", value, min, max });
    }
    Ok(if negative { TimeTag::new(-seconds, -fraction_s) } else { TimeTag::new(seconds, fraction_s) })
}
