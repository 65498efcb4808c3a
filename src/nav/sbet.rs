//! SBET: smoothed best estimates of trajectories, as Applanix POSPac and others write them.
//!
//! Records of 17 little-endian f64 (136 bytes), no header:
//!
//! | fields | meaning | unit |
//! | --- | --- | --- |
//! | 1 | GPS time | s of the week |
//! | 2, 3 | latitude, longitude | rad |
//! | 4 | height above the ellipsoid | m |
//! | 5, 6, 7 | velocity x, y, z in the wander frame | m/s |
//! | 8, 9 | roll (right side down), pitch (nose up) | rad |
//! | 10, 11 | platform heading, wander angle | rad |
//! | 12 .. 14, 15 .. 17 | acceleration and angular rate of the body (not read) | m/s^2, rad/s |
//!
//! The wander frame is x north, y west, z up, turned by the wander angle `w` counter-clockwise about up; the
//! platform heading is clockwise from its x axis. So heading = platform heading - w,
//! `v_N = v_x cos w - v_y sin w`, `v_E = -v_x sin w - v_y cos w`, `v_U = v_z`.
//!
//! The file has neither date nor week: the source gives the GPS week of the first record. A time that falls
//! by more than half a week begins the next week; a time of more than a week goes on counting. GPS time is
//! assumed, as the format has it: a file that was exported with UTC seconds is off by the leap seconds. Times
//! are counted on from the first record: behind a leap second they are one second ahead of UTC.
//! Big-endian records, and places in degrees, are recognised by the first record and refused in one sentence.
//! Faults name the record, counted from 1, instead of a line.
//!
//! Source: the field list of PDAL's `readers.sbet`; the wander angle is turned so that velocity and heading
//! agree.
//!
//! ```
//! use nereus::nav::sbet::Record;
//! let mut figures = [0.0; 17];
//! (figures[4], figures[9], figures[10]) = (50.0, 1.25, 0.25);
//! let record = Record::of(&figures);
//! assert_eq!(record.yaw_pitch_roll_rad, [1.0, 0.0, 0.0]);
//! // Along x, which looks to the west of North.
//! assert!(record.velocity_mps[0] < 0.0 && record.velocity_mps[1] > 0.0);
//! ```

use super::faults::{FaultKind, Faults, NavError};
use super::recording;
use super::{FileSource, Fix, Place};
use crate::frames::Geodetic;
use crate::nav::load_report::LoadReport;
use crate::nav::recording::{MAX_FIXES, Recording};
use crate::time::TimeTag;

/// Bytes of a record.
pub const RECORD_BYTES: usize = 136;
const WEEK_S: f64 = 604_800.0;
const HALF_TURN_RAD: f64 = std::f64::consts::PI;

/// What is read of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// GPS time, s of the week.
    pub seconds: f64,
    /// Latitude, radians.
    pub lat_rad: f64,
    /// Longitude, radians.
    pub lon_rad: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Velocity East, North, up, m/s.
    pub velocity_mps: [f64; 3],
    /// Yaw (clockwise from North), pitch, roll, radians.
    pub yaw_pitch_roll_rad: [f64; 3],
}

impl Record {
    /// From the figures of a record.
    pub fn of(figures: &[f64; 17]) -> Self {
        let [seconds, lat_rad, lon_rad, height_m, vx, vy, vz, roll, pitch, heading, wander, ..] = *figures;
        let (sin, cos) = wander.sin_cos();
        Self {
            seconds,
            lat_rad,
            lon_rad,
            height_m,
            velocity_mps: [-vx * sin - vy * cos, vx * cos - vy * sin, vz],
            yaw_pitch_roll_rad: [heading - wander, pitch, roll],
        }
    }
}

/// The figures of a record.
fn figures(bytes: &[u8; RECORD_BYTES], of: fn([u8; 8]) -> f64) -> [f64; 17] {
    let mut figures = [0.0; 17];
    for (figure, bytes) in figures.iter_mut().zip(bytes.as_chunks::<8>().0) {
        *figure = of(*bytes);
    }
    figures
}

/// What is wrong with all records, if the first one shows it.
fn misread(first: &[u8; RECORD_BYTES]) -> Option<FaultKind> {
    let place = |[seconds, lat, lon, height_m, ..]: [f64; 17], [most_lat, most_lon]: [f64; 2]| {
        let in_time = (0.0..=10.0 * WEEK_S).contains(&seconds);
        in_time && lat.abs() <= most_lat && lon.abs() <= most_lon && height_m.abs() <= 1e8
    };
    // Fields of a swapped record are tiny or huge: none that is meant is below 1e-100.
    let means = |figures: [f64; 17]| figures.iter().all(|figure| *figure == 0.0 || figure.abs() > 1e-100);
    let figures_le = figures(first, f64::from_le_bytes);
    if place(figures_le, [HALF_TURN_RAD / 2.0, 2.0 * HALF_TURN_RAD]) && means(figures_le) {
        return None;
    }
    let figures_be = figures(first, f64::from_be_bytes);
    if place(figures_be, [90.0, 360.0]) && means(figures_be) {
        return Some(FaultKind::BigEndian);
    }
    let [_, lat, lon, ..] = figures_le;
    place(figures_le, [90.0, 360.0]).then_some(FaultKind::Degrees { lat, lon })
}

/// The records of a file with their times; all that is wrong with them goes to `faults`.
pub(super) fn records(bytes: &[u8], gps_week: u32, faults: &mut Faults) -> Vec<(u64, TimeTag, Record)> {
    let (whole, rest) = bytes.as_chunks::<RECORD_BYTES>();
    if !rest.is_empty() {
        faults.push(whole.len() as u64 + 1, FaultKind::CutRecord { found: rest.len(), needed: RECORD_BYTES });
    }
    if let Some(kind) = whole.first().and_then(misread) {
        faults.push(1, kind);
        return Vec::new();
    }
    let mut records = Vec::with_capacity(whole.len().min(MAX_FIXES));
    let mut leap_s = None;
    let (mut weeks, mut before_s) = (0.0, 0.0);
    for (number, bytes) in (1..).zip(whole) {
        if records.len() >= MAX_FIXES {
            faults.push(number, FaultKind::TooManyFixes { allowed: MAX_FIXES });
            break;
        }
        let figures = figures(bytes, f64::from_le_bytes);
        let before = faults.count();
        for (column, index, limit) in [
            ("latitude", 1, HALF_TURN_RAD / 2.0),
            ("longitude", 2, 2.0 * HALF_TURN_RAD),
            ("height", 3, 1e8),
            ("x velocity", 4, 1e5),
            ("y velocity", 5, 1e5),
            ("z velocity", 6, 1e5),
            ("roll", 7, HALF_TURN_RAD),
            ("pitch", 8, HALF_TURN_RAD / 2.0),
            ("heading", 9, 4.0 * HALF_TURN_RAD),
            ("wander angle", 10, 4.0 * HALF_TURN_RAD),
        ] {
            let value = figures[index];
            if value.is_nan() || value.abs() > limit {
                faults.push(number, FaultKind::OutOfRange { column, value, min: -limit, max: limit });
            }
        }
        let record = Record::of(&figures);
        if record.seconds < before_s - WEEK_S / 2.0 {
            weeks += 1.0;
        }
        let time = TimeTag::from_gps(gps_week, record.seconds + weeks * WEEK_S);
        match time.filter(|_| (0.0..=10.0 * WEEK_S).contains(&record.seconds)) {
            Some(time) => {
                before_s = record.seconds;
                if faults.count() == before {
                    let now_s = time.leap_seconds()
                        - i64::from(TimeTag::is_leap_second(gps_week, record.seconds + weeks * WEEK_S));
                    let behind_s = now_s - *leap_s.get_or_insert(now_s);
                    records.push((
                        number,
                        TimeTag::new(time.seconds() + behind_s, time.fraction_s()),
                        record,
                    ));
                }
            }
            None => faults.push(
                number,
                FaultKind::OutOfRange { column: "time", value: record.seconds, min: 0.0, max: 10.0 * WEEK_S },
            ),
        }
    }
    records
}

/// Reads fixes from the bytes of a file; `gps_week` is that of the first record.
///
/// # Errors
/// A file that is not made of whole records, and all faults of these.
pub fn parse(bytes: &[u8], gps_week: u32, source: &FileSource) -> Result<Recording, NavError> {
    let mut faults = Faults::default();
    let records = records(bytes, gps_week, &mut faults);
    let mut fixes: Vec<Fix> = Vec::with_capacity(records.len());
    let lines = (bytes.len() / RECORD_BYTES) as u64;
    for (number, time, record) in records {
        let Record { lat_rad, lon_rad, height_m: h_m, .. } = record;
        let place = Place::Geodetic(Geodetic { lat_rad, lon_rad, h_m });
        let [east, north, up] = record.velocity_mps;
        let fix = Fix {
            yaw_pitch_roll_rad: Some(record.yaw_pitch_roll_rad),
            velocity_mps: Some([east, north]),
            climb_mps: Some(up),
            ..Fix::at(time, place)
        };
        if recording::follows(&fixes, &fix, number, source, &mut faults) {
            fixes.push(fix);
        }
    }
    let path = source.path.display().to_string();
    recording::finish(
        fixes,
        LoadReport { path, lines: lines.max(1), ..LoadReport::default() },
        faults,
        source,
    )
}
