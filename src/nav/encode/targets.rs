//! What a radar reports of its targets: NMEA 0183 TTM, TLL and RSD, of the talker RA.
//!
//! | sentence | fields |
//! | --- | --- |
//! | TTM | number, distance, bearing, T, speed, course, T, distance and time of the closest approach, N, name, T (tracking), reference, time, A (automatic) |
//! | TLL | number, latitude, longitude, name, time, T (tracking), reference |
//! | RSD | range scale and N, display N (North up); without cursor, markers and offset origins |
//!
//! Distances are nautical miles, speeds knots, the time of the closest approach minutes, negative when it has
//! passed; it and its distance are those of straight courses. Resolution: 1e-4 of each, 1e-8 minutes of an
//! angle. Source: IEC 61162-1.
//!
//! ```
//! use nereus::frames::Geodetic;
//! use nereus::nav::encode::targets::{Tracked, ttm};
//! use nereus::time::TimeTag;
//! let tracked = Tracked {
//!     number: 7,
//!     name: "buoy",
//!     time: TimeTag::from_iso8601("2018-05-30T18:40:00.25Z").unwrap(),
//!     place: Geodetic::from_deg(53.5, -4.25, 0.0),
//!     offset_m: [0.0, 1852.0],
//!     velocity_mps: [0.0, 0.0],
//!     own_velocity_mps: [0.0, 5.144444444444445],
//! };
//! let mut out = Vec::new();
//! ttm(&tracked, &mut out);
//! // A mile ahead at 10 knots: 6 minutes.
//! let text = b"$RATTM,07,1.0000,0.0000,T,0.0000,,T,0.0000,6.0000,N,buoy,T,,184000.250,A*22\r\n";
//! assert_eq!(String::from_utf8(out).unwrap().into_bytes(), text);
//! ```

use std::io::Write;

use super::nmea::{Stamp, figure, position, sealed};
use super::turn_deg;
use crate::frames::Geodetic;
use crate::time::TimeTag;
use crate::units::KNOT_MPS;

/// The greatest number that a target has.
pub const MOST_TARGETS: usize = 999;
/// Nautical mile, m.
const MILE_M: f64 = 1852.0;
/// Resolution of angles, degrees.
const UNIT_DEG: f64 = 1e-4;
/// Slower ones stand still, m/s: they have no course.
const STILL_MPS: f64 = 1e-3;
/// Later approaches are none, minutes.
const MOST_MINUTES: f64 = 1e4;

/// A target that is tracked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked<'a> {
    /// Its number, from 1.
    pub number: usize,
    /// Its name.
    pub name: &'a str,
    /// When it was there, UTC.
    pub time: TimeTag,
    /// Where.
    pub place: Geodetic,
    /// From own ship, East and North, m.
    pub offset_m: [f64; 2],
    /// Velocity East and North, m/s.
    pub velocity_mps: [f64; 2],
    /// That of own ship.
    pub own_velocity_mps: [f64; 2],
}

impl Tracked<'_> {
    /// Distance, m, and time from now, s, of the closest approach; no time where it is never nearer.
    fn closest(&self) -> (f64, Option<f64>) {
        let [x, y] = self.offset_m;
        let [vx, vy] = [0, 1].map(|axis| self.velocity_mps[axis] - self.own_velocity_mps[axis]);
        let squared = vx * vx + vy * vy;
        if squared.sqrt() < STILL_MPS {
            return (x.hypot(y), None);
        }
        let time_s = -(x * vx + y * vy) / squared;
        ((x + vx * time_s).hypot(y + vy * time_s), Some(time_s))
    }

    /// A name as fields hold it: other characters end fields or sentences.
    fn plain_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || " _-.".contains(c) { c } else { '-' };
        self.name.chars().take(32).map(plain).collect()
    }
}

/// Appends TTM, tracked target message.
pub fn ttm(tracked: &Tracked<'_>, out: &mut Vec<u8>) {
    sealed(out, |out| {
        let [x, y] = tracked.offset_m;
        let [vx, vy] = tracked.velocity_mps;
        let (range_m, speed_mps) = (x.hypot(y), vx.hypot(vy));
        let course = (speed_mps >= STILL_MPS).then(|| turn_deg(vx.atan2(vy), UNIT_DEG));
        let (closest_m, time_s) = tracked.closest();
        write!(out, "$RATTM,{:02},{:.4},", tracked.number, range_m / MILE_M)?;
        write!(out, "{:.4},T,{:.4},", turn_deg(x.atan2(y), UNIT_DEG), speed_mps / KNOT_MPS)?;
        figure(out, course)?;
        write!(out, ",T,{:.4},", closest_m / MILE_M)?;
        figure(out, time_s.map(|s| s / 60.0).filter(|minutes| minutes.abs() <= MOST_MINUTES))?;
        write!(out, ",N,{},T,,{},A", tracked.plain_name(), Stamp::of(tracked.time).time)
    });
}

/// Appends TLL, target latitude and longitude.
pub fn tll(tracked: &Tracked<'_>, out: &mut Vec<u8>) {
    sealed(out, |out| {
        write!(out, "$RATLL,{:02},", tracked.number)?;
        position(tracked.place, out)?;
        write!(out, ",{},{},T,", tracked.plain_name(), Stamp::of(tracked.time).time)
    });
}

/// Appends RSD, radar system data: the range to which the radar looks, m.
pub fn rsd(range_m: f64, out: &mut Vec<u8>) {
    sealed(out, |out| write!(out, "$RARSD,,,,,,,,,,,{:.4},N,N", range_m / MILE_M));
}
