//! Sentences.

use std::io::Write;

use hifitime::{Epoch, Unit};

use super::super::decode::nmea::checksum;
use super::super::solution::Solution;
use super::{Sentence, lon_deg, tidy, turn_deg};
use crate::frames::Geodetic;
use crate::time::TimeTag;
use crate::units::KNOT_MPS;

/// Steps of a position in a degree: 60 minutes of 1e8.
const STEPS_PER_DEG: f64 = 60e8;
/// The resolution of angles, degrees.
const UNIT_DEG: f64 = 1e-4;

/// Appends a sentence with checksum and line end.
pub(super) fn write(sentence: Sentence, solution: &Solution, out: &mut Vec<u8>) {
    sealed(out, |out| fields(sentence, solution, out));
}

/// Appends what is written, with checksum and line end; nothing where nothing is.
pub(super) fn sealed(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>) -> std::io::Result<()>) {
    let start = out.len();
    // Writing to memory does not fail.
    let _ = write(out);
    if out.len() > start {
        let sum = checksum(&out[start + 1..]);
        let _ = write!(out, "*{sum:02X}\r\n");
    }
}

fn fields(sentence: Sentence, solution: &Solution, out: &mut Vec<u8>) -> std::io::Result<()> {
    let stamp = Stamp::of(solution.time);
    let angles = solution.yaw_pitch_roll_rad.map(tidy);
    let heading = angles.map(|[yaw, ..]| turn_deg(yaw, UNIT_DEG));
    match sentence {
        Sentence::Gga => {
            write!(out, "$GPGGA,{},", stamp.time)?;
            position(solution.place, out)?;
            // The altitude takes up the rounding of the separation.
            let separation_m = (solution.undulation_m * 1e4).round() / 1e4;
            let altitude_m = solution.place.h_m - separation_m;
            write!(out, ",1,10,1.0,{altitude_m:.5},M,{separation_m:.4},M,,")
        }
        Sentence::Rmc => {
            write!(out, "$GPRMC,{},A,", stamp.time)?;
            position(solution.place, out)?;
            write!(out, ",")?;
            let (speed_knots, course_deg) = ground(solution);
            figure(out, speed_knots)?;
            write!(out, ",")?;
            figure(out, course_deg)?;
            write!(out, ",{:02}{:02}{:02},,,A", stamp.day, stamp.month, stamp.year % 100)
        }
        Sentence::Vtg => {
            let (speed_knots, course_deg) = ground(solution);
            write!(out, "$GPVTG,")?;
            figure(out, course_deg)?;
            write!(out, ",T,,M,")?;
            figure(out, speed_knots)?;
            write!(out, ",N,")?;
            figure(out, speed_knots.map(|knots| knots * 1.852))?;
            write!(out, ",K,A")
        }
        Sentence::Hdt => {
            write!(out, "$GPHDT,")?;
            figure(out, heading)?;
            write!(out, ",T")
        }
        Sentence::Zda => {
            let Stamp { time, day, month, year } = stamp;
            write!(out, "$GPZDA,{time},{day:02},{month:02},{year:04},00,00")
        }
        Sentence::Gst => {
            write!(out, "$GPGST,{},,,,", stamp.time)?;
            let [east, north, up] = match solution.sigma.position_m {
                Some(sigma) => sigma.map(|m| Some(f64::from(m))),
                None => [None; 3],
            };
            for sigma in [north, east, up] {
                write!(out, ",")?;
                figure(out, sigma)?;
            }
            Ok(())
        }
        Sentence::Pashr => {
            let (Some([_, pitch, roll]), Some(heading)) = (angles, heading) else { return Ok(()) };
            let (roll, pitch) = (roll.to_degrees(), pitch.to_degrees());
            write!(out, "$PASHR,{},{heading:.4},T,{roll:+.4},{pitch:+.4},+0.00", stamp.time)?;
            let [yaw, pitch, roll] = match solution.sigma.angles_rad {
                Some(sigma) => sigma.map(|rad| Some(f64::from(rad).to_degrees())),
                None => [None; 3],
            };
            for sigma in [roll, pitch, yaw] {
                write!(out, ",")?;
                figure(out, sigma)?;
            }
            write!(out, ",1,1")
        }
    }
}

/// A figure of four decimals, or nothing.
pub(super) fn figure(out: &mut Vec<u8>, value: Option<f64>) -> std::io::Result<()> {
    value.map_or(Ok(()), |value| write!(out, "{value:.4}"))
}

/// Speed, knots, and course, degrees.
fn ground(solution: &Solution) -> (Option<f64>, Option<f64>) {
    let Some([east, north, _]) = solution.velocity_mps else { return (None, None) };
    (Some(east.hypot(north) / KNOT_MPS), Some(turn_deg(east.atan2(north), UNIT_DEG)))
}

/// Latitude and longitude with their halves.
pub(super) fn position(place: Geodetic, out: &mut Vec<u8>) -> std::io::Result<()> {
    let lat = (place.lat_rad.to_degrees().clamp(-90.0, 90.0) * STEPS_PER_DEG).round();
    let lon = (lon_deg(place.lon_rad) * STEPS_PER_DEG).round();
    let split = |steps: f64| {
        let (all, degree) = (steps.abs() as u64, STEPS_PER_DEG as u64);
        let minutes = all % degree;
        (all / degree, minutes / 100_000_000, minutes % 100_000_000)
    };
    let ((d, m, f), half) = (split(lat), if lat < 0.0 { 'S' } else { 'N' });
    write!(out, "{d:02}{m:02}.{f:08},{half},")?;
    let ((d, m, f), half) = (split(lon), if lon < 0.0 { 'W' } else { 'E' });
    write!(out, "{d:03}{m:02}.{f:08},{half}")
}

/// Time of day as written, and the date.
pub(super) struct Stamp {
    pub(super) time: String,
    day: u8,
    month: u8,
    year: i32,
}

impl Stamp {
    pub(super) fn of(at: TimeTag) -> Self {
        let mut seconds = at.seconds();
        let mut ns = (at.fraction_s() * 1e9).round() as u64;
        if ns >= 1_000_000_000 {
            (seconds, ns) = (seconds + 1, 0);
        }
        let epoch = Epoch::from_unix_duration(seconds * Unit::Second);
        let (year, month, day, hour, minute, second, _) = epoch.to_gregorian_utc();
        let mut time = format!("{hour:02}{minute:02}{second:02}.{ns:09}");
        // Zeros beyond the third decimal say nothing.
        while time.len() > "hhmmss.sss".len() && time.ends_with('0') {
            time.pop();
        }
        Self { time, day, month, year }
    }
}
