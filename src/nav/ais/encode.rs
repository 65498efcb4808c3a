//! AIS messages as a receiver hears them: `AIVDM` sentences of messages 1 and 5 (ITU-R M.1371-5, tables 48
//! and 52).
//!
//! What is not known has the value that stands for that. A vessel's reference point is midship, so that the
//! distances to bow and stern are equal.
//!
//! ```
//! use nereus::nav::ais::encode::{PositionReport, position};
//! // The example of E. S. Raymond, "AIVDM/AIVDO protocol decoding".
//! let report = PositionReport {
//!     mmsi: 477_553_000,
//!     status: 5,
//!     turn: 0,
//!     speed_knots: Some(0.0),
//!     lat_deg: 47.582_833_333,
//!     lon_deg: -122.345_833_333,
//!     course_deg: Some(51.0),
//!     heading_deg: Some(181.0),
//!     second: 15,
//!     radio: 149_208,
//! };
//! let mut out = Vec::new();
//! position(&report, 'B', &mut out);
//! assert_eq!(out, b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n");
//! ```

use std::io::Write;

/// Unit of latitudes and longitudes, in a degree.
const ANGLES_PER_DEG: f64 = 600_000.0;
/// Not available: rate of turn, speed, course, heading.
pub const NO_TURN: i8 = -128;
const NO_SPEED: u32 = 1023;
const NO_COURSE: u32 = 3600;
const NO_HEADING: u32 = 511;
/// The greatest speed that is not "or more", in tenths of a knot.
const MOST_SPEED: f64 = 1021.0;
/// Characters of a payload in a sentence: 82 in all.
const MOST_PAYLOAD: usize = 60;
/// Characters of a name.
const NAME: usize = 20;

/// Message 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionReport {
    /// Number of the vessel.
    pub mmsi: u32,
    /// Navigational status; 0: under way using engine.
    pub status: u8,
    /// Rate of turn, as coded; [`NO_TURN`]: not available.
    pub turn: i8,
    /// Speed over ground, knots.
    pub speed_knots: Option<f64>,
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Course over ground, clockwise from North, degrees.
    pub course_deg: Option<f64>,
    /// Heading, clockwise from North, degrees.
    pub heading_deg: Option<f64>,
    /// Second of the minute, UTC.
    pub second: u8,
    /// State of the radio.
    pub radio: u32,
}

/// What message 5 says of a vessel.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticReport {
    /// Number of the vessel.
    pub mmsi: u32,
    /// Its name; 20 characters are sent, in capitals.
    pub name: String,
    /// Length, beam and draught, m.
    pub size_m: [f64; 3],
}

/// Bits of a message.
#[derive(Default)]
struct Bits(Vec<bool>);

impl Bits {
    fn put(&mut self, value: u32, wide: usize) {
        self.0.extend((0..wide).rev().map(|bit| value >> bit & 1 == 1));
    }

    /// A number that may be negative.
    fn put_signed(&mut self, value: f64, wide: usize) {
        self.put(value.round() as i32 as u32, wide);
    }

    fn text(&mut self, text: &str, characters: usize) {
        let six = |c: char| match c.to_ascii_uppercase() {
            c @ '@'..='_' => u32::from(c) - 64,
            c @ ' '..='?' => u32::from(c),
            _ => u32::from('-'),
        };
        let filled = text.chars().map(six).chain(std::iter::repeat(0));
        filled.take(characters).for_each(|six| self.put(six, 6));
    }

    /// The characters of a payload, and the bits that fill the last.
    fn payload(&self) -> (Vec<u8>, usize) {
        let character = |six: &[bool]| {
            let value = (0..6).fold(0, |value, bit| value << 1 | u8::from(six.get(bit) == Some(&true)));
            if value < 40 { value + 48 } else { value + 56 }
        };
        (self.0.chunks(6).map(character).collect(), self.0.len().div_ceil(6) * 6 - self.0.len())
    }
}

/// Appends the sentence of message 1, on channel `A` or `B`.
pub fn position(report: &PositionReport, channel: char, out: &mut Vec<u8>) {
    let tenths = |value: f64| (value * 10.0).round();
    let mut bits = Bits::default();
    bits.put(1, 6);
    bits.put(0, 2);
    bits.put(report.mmsi, 30);
    bits.put(report.status.into(), 4);
    bits.put(report.turn as u8 as u32, 8);
    bits.put(report.speed_knots.map_or(NO_SPEED, |knots| tenths(knots).clamp(0.0, MOST_SPEED) as u32), 10);
    bits.put(0, 1);
    bits.put_signed(report.lon_deg * ANGLES_PER_DEG, 28);
    bits.put_signed(report.lat_deg * ANGLES_PER_DEG, 27);
    bits.put(report.course_deg.map_or(NO_COURSE, |deg| tenths(deg.rem_euclid(360.0)) as u32 % 3600), 12);
    bits.put(report.heading_deg.map_or(NO_HEADING, |deg| deg.rem_euclid(360.0).round() as u32 % 360), 9);
    bits.put(report.second.into(), 6);
    // No manoeuvre, spare, no RAIM.
    bits.put(0, 2 + 3 + 1);
    bits.put(report.radio, 19);
    sentences(&bits, channel, 0, out);
}

/// Appends the two sentences of message 5, on channel `A` or `B`; `sequence` of one digit joins them.
pub fn particulars(report: &StaticReport, channel: char, sequence: u8, out: &mut Vec<u8>) {
    let [length_m, beam_m, draught_m] = report.size_m;
    let halves = |size_m: f64, most: u32| {
        let whole = (size_m.max(0.0).round() as u32).min(2 * most);
        [whole / 2, whole - whole / 2]
    };
    let mut bits = Bits::default();
    bits.put(5, 6);
    bits.put(0, 2);
    bits.put(report.mmsi, 30);
    // Version, IMO number, call sign.
    bits.put(0, 2);
    bits.put(0, 30);
    bits.text("", 7);
    bits.text(&report.name, NAME);
    // Type of ship.
    bits.put(0, 8);
    halves(length_m, 510).into_iter().for_each(|half| bits.put(half, 9));
    halves(beam_m, 62).into_iter().for_each(|half| bits.put(half, 6));
    // Position device; arrival: month, day, hour, minute.
    bits.put(0, 4);
    bits.put(0, 4);
    bits.put(0, 5);
    bits.put(24, 5);
    bits.put(60, 6);
    bits.put((draught_m.max(0.0) * 10.0).round().min(255.0) as u32, 8);
    bits.text("", 20);
    // Data terminal not available; spare.
    bits.put(1, 1);
    bits.put(0, 1);
    sentences(&bits, channel, sequence, out);
}

fn sentences(bits: &Bits, channel: char, sequence: u8, out: &mut Vec<u8>) {
    let (payload, filled) = bits.payload();
    let parts = payload.len().div_ceil(MOST_PAYLOAD);
    for (part, payload) in payload.chunks(MOST_PAYLOAD).enumerate() {
        let start = out.len();
        let sequence = if parts > 1 { (sequence % 10).to_string() } else { String::new() };
        let filled = if part + 1 == parts { filled } else { 0 };
        let payload = String::from_utf8_lossy(payload);
        // Writing to memory does not fail.
        let _ = write!(out, "!AIVDM,{parts},{},{sequence},{channel},{payload},{filled}", part + 1);
        let sum = out[start + 1..].iter().fold(0, |sum, byte| sum ^ byte);
        let _ = write!(out, "*{sum:02X}\r\n");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nav::ais;

    /// The program's own decoder, which was written for logs of others.
    #[test]
    fn what_is_encoded_is_decoded() {
        let report = PositionReport {
            mmsi: 235_070_762,
            status: 0,
            turn: NO_TURN,
            speed_knots: Some(12.34),
            lat_deg: -33.123_456_7,
            lon_deg: 151.765_432_1,
            course_deg: Some(359.97),
            heading_deg: None,
            second: 40,
            radio: 0,
        };
        let size_m = [201.0, 33.4, 10.25];
        let mut out = b"\\c:1714564840*51\\".to_vec();
        position(&report, 'A', &mut out);
        particulars(&StaticReport { mmsi: report.mmsi, name: "Tug n° 1".into(), size_m }, 'B', 7, &mut out);
        let text = String::from_utf8(out.clone()).unwrap();
        assert!(text.lines().all(|line| line.rsplit('\\').next().unwrap().len() <= 80), "{text}");
        let log = ais::parse(&out).unwrap();
        let [found] = log.reports[..] else { panic!("{log:?} {text}") };
        assert_eq!(found.mmsi, report.mmsi);
        assert!(
            (found.lat_deg - report.lat_deg).abs() < 1e-6 && (found.lon_deg - report.lon_deg).abs() < 1e-6
        );
        assert!((found.speed_mps.unwrap() - 12.3 * 1852.0 / 3600.0).abs() < 1e-9);
        assert_eq!((found.course_deg, found.size_m), (Some(0.0), [Some(201.0), Some(33.0), Some(10.3)]));
    }
}
