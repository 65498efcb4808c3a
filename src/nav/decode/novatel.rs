//! NovAtel logs: frames, checksum, and INSPVAX, position, velocity and attitude of an inertial system with
//! their deviations; INSPVA and INSPVAS, the same without deviations.
//!
//! **Binary**, little-endian: `AA 44 12`, header of 28 bytes (its length at 3, id at 4, length of the body at
//! 8, status of the time at 13, GPS week at 14, ms of the week at 16), body, CRC. The short header `AA 44 13`
//! has 12 bytes: length of the body at 3, id at 4, week at 6, ms at 8. **ASCII**:
//! `#INSPVAXA,port,sequence,idle,status,week,seconds,...;fields*crc`, with a short header
//! `%INSPVASA,week,seconds;fields*crc`. **Abbreviated ASCII** (`<INSPVAX ...`) has no checksum: it is counted
//! and not read.
//!
//! | INSPVAX (id 1465) | binary, at | unit |
//! | --- | --- | --- |
//! | status of the solution, type of the position | u32 0, u32 4 | |
//! | latitude, longitude | f64 8, 16 | deg |
//! | height above mean sea level, undulation | f64 24, f32 32 | m; their sum is above the ellipsoid |
//! | velocity North, East, up | f64 36, 44, 52 | m/s |
//! | roll, pitch, azimuth | f64 60, 68, 76 | deg |
//! | deviations of latitude, longitude, height | f32 84, 88, 92 | m |
//! | of velocity North, East, up | f32 96, 100, 104 | m/s |
//! | of roll, pitch, azimuth | f32 108, 112, 116 | deg |
//! | extended status, time since the last update | u32 120, u16 124 | s |
//!
//! INSPVA (id 507) and INSPVAS (id 508, short header), 88 bytes: week u32 0, seconds of the week f64 4,
//! latitude, longitude f64 12, 20, height above the ellipsoid f64 28, velocity North, East, up f64 36, 44,
//! 52, roll, pitch, azimuth f64 60, 68, 76, status of the solution u32 84.
//!
//! **A header is believed** when it announces a binary message (bits 5 and 6 at 6 are 0) of a time within a
//! week; messages that are read have one length. See [`decode`](super) for what is decoded while a long one
//! is waited for.
//!
//! **Angles.** The body axes of the receiver are x to the right, y ahead, z up. Roll turns about y and pitch
//! about x, both right-handed, azimuth about z left-handed (clockwise from North): body to ENU is
//! `Rz(-azimuth) Rx(pitch) Ry(roll)`. Right wing down and nose up are positive, and azimuth comes first: the
//! same three angles as those of
//! [`Rotation::from_yaw_pitch_roll`](crate::frames::Rotation::from_yaw_pitch_roll) for forward, starboard,
//! down.
//!
//! **CRC-32**: polynomial 0xEDB88320 (reflected), begun with 0, not inverted; a message with its CRC behind
//! it gives 0.
//!
//! Source: NovAtel OEM7 Commands and Logs Reference Manual, "Message formats", "32-Bit CRC", log 1465.
//!
//! ```
//! use nereus::nav::decode::novatel::crc32;
//! // The check value of CRC-32 without inversion, 0x2DFD2D88, is that of 123456789.
//! assert_eq!(crc32(b"123456789"), 0x2DFD_2D88);
//! ```

use super::nmea::number;
use super::{Content, MAX_BINARY_BYTES, Unread};
use crate::time::TimeTag;

/// Id of INSPVAX.
pub const INSPVAX_ID: u16 = 1465;
/// Bytes of its body.
pub const INSPVAX_BYTES: usize = 126;
/// Id of INSPVA.
pub const INSPVA_ID: u16 = 507;
/// Id of INSPVAS, the same with the short header.
pub const INSPVAS_ID: u16 = 508;
/// Bytes of the body of both.
pub const INSPVA_BYTES: usize = 88;
/// Bytes of the long header.
pub const HEADER_BYTES: usize = 28;
/// Bytes of the short header.
const SHORT_HEADER_BYTES: usize = 12;
/// The longest header that is believed; longer ones were never made.
const MOST_HEADER_BYTES: usize = 64;
/// Milliseconds of a week.
const WEEK_MS: u32 = 604_800_000;
/// Status of a solution that is good, as sent.
pub const SOLUTION_GOOD: u32 = 3;

/// Names of the states of a solution, and their numbers.
const STATUS: [(&str, u32); 12] = [
    ("INS_INACTIVE", 0),
    ("INS_ALIGNING", 1),
    ("INS_HIGH_VARIANCE", 2),
    ("INS_SOLUTION_GOOD", SOLUTION_GOOD),
    ("INS_SOLUTION_FREE", 6),
    ("INS_ALIGNMENT_COMPLETE", 7),
    ("DETERMINING_ORIENTATION", 8),
    ("WAITING_INITIALPOS", 9),
    ("WAITING_AZIMUTH", 10),
    ("INITIALIZING_BIASES", 11),
    ("MOTION_DETECT", 12),
    ("WAITING_ALIGNMENTORIENTATION", 14),
];
/// States in which position, velocity and attitude are reported: alignment done, whatever the variance.
const SOLVED: [u32; 4] = [2, SOLUTION_GOOD, 6, 7];
/// Status of a time that is not known.
const TIME_UNKNOWN: u8 = 20;

/// Position, velocity and attitude with their standard deviations, in the units of the message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inspvax {
    /// GPS week.
    pub week: u32,
    /// Seconds of the week.
    pub seconds: f64,
    /// Whether the time is known.
    pub timed: bool,
    /// Status of the solution; 3 is good.
    pub status: u32,
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Height above mean sea level, m.
    pub altitude_m: f64,
    /// Height of mean sea level above the ellipsoid, m.
    pub undulation_m: f64,
    /// Velocity North, East, up, m/s.
    pub velocity_mps: [f64; 3],
    /// Roll, pitch, azimuth, degrees.
    pub angles_deg: [f64; 3],
    /// Standard deviations of latitude, longitude, height, m.
    pub sigma_position_m: [f32; 3],
    /// Standard deviations of the velocity, m/s.
    pub sigma_velocity_mps: [f32; 3],
    /// Standard deviations of roll, pitch, azimuth, degrees.
    pub sigma_angles_deg: [f32; 3],
}

impl Inspvax {
    /// Whether time, position, velocity and attitude are there.
    pub fn is_solution(&self) -> bool {
        self.timed && SOLVED.contains(&self.status) && self.time().is_some()
    }

    /// When, UTC.
    pub fn time(&self) -> Option<TimeTag> {
        TimeTag::from_gps(self.week, self.seconds)
    }

    /// Itself, if every figure is in its range.
    fn checked(self) -> Result<Self, Unread> {
        let Self { lat_deg, lon_deg, altitude_m, undulation_m, .. } = self;
        let [roll, pitch, azimuth] = self.angles_deg;
        let sigmas = [self.sigma_position_m, self.sigma_velocity_mps, self.sigma_angles_deg];
        // A receiver without a solution fills in zeros.
        let sound = lat_deg.abs() <= 90.0
            && lon_deg.abs() <= 180.0
            && altitude_m.abs() <= 1e8
            && undulation_m.abs() <= 1e4
            && self.velocity_mps.iter().all(|v| v.abs() <= 1e5)
            && roll.abs() <= 180.0
            && pitch.abs() <= 90.0
            && azimuth.abs() <= 360.0
            && sigmas.iter().flatten().all(|sigma| sigma.is_finite() && *sigma >= 0.0);
        if sound { Ok(self) } else { Err(Unread::Malformed) }
    }
}

/// Polynomial of the CRC, reflected.
const POLYNOMIAL: u32 = 0xEDB8_8320;

/// CRC-32 of a message.
pub fn crc32(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |crc, byte| crc32_step(crc, *byte))
}

/// CRC-32 with one more byte.
fn crc32_step(crc: u32, byte: u8) -> u32 {
    const TABLE: [u32; 256] = table();
    TABLE[((crc ^ u32::from(byte)) & 0xFF) as usize] ^ (crc >> 8)
}

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        let mut crc = i as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ POLYNOMIAL } else { crc >> 1 };
            bit += 1;
        }
        table[i] = crc;
        i += 1;
    }
    table
}

/// Sizes of a binary message.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub header_bytes: usize,
    body_bytes: usize,
    /// What its header says is that of a message.
    believed: bool,
    /// Kind of message that is read.
    kind: Option<Kind>,
}

/// Messages that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Inspvax,
    Inspva,
}

impl Frame {
    /// From the beginning of a message; `None` when more of it is needed.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let (header_bytes, body_bytes, time_ms, kind, is_binary);
        if bytes[2] == 0x13 {
            let header = bytes.get(..SHORT_HEADER_BYTES)?;
            (header_bytes, body_bytes, is_binary) = (SHORT_HEADER_BYTES, usize::from(header[3]), true);
            time_ms = u32_at(header, 8);
            kind = (u16_at(header, 4) == INSPVAS_ID).then_some(Kind::Inspva);
        } else {
            let header = bytes.get(..HEADER_BYTES)?;
            (header_bytes, body_bytes) = (usize::from(header[3]), usize::from(u16_at(header, 8)));
            is_binary = header[6] & 0x60 == 0;
            time_ms = u32_at(header, 16);
            // The highest bit of the type marks the answer to a command.
            kind = match u16_at(header, 4) {
                INSPVAX_ID if header[6] & 0x80 == 0 => Some(Kind::Inspvax),
                INSPVA_ID if header[6] & 0x80 == 0 => Some(Kind::Inspva),
                _ => None,
            };
        }
        let length = match kind {
            Some(Kind::Inspvax) => Some(INSPVAX_BYTES),
            Some(Kind::Inspva) => Some(INSPVA_BYTES),
            None => None,
        };
        let least = if bytes[2] == 0x13 { SHORT_HEADER_BYTES } else { HEADER_BYTES };
        let believed = is_binary
            && (least..=MOST_HEADER_BYTES).contains(&header_bytes)
            && time_ms <= WEEK_MS
            && length.is_none_or(|length| length == body_bytes);
        Some(Self { header_bytes, body_bytes, believed, kind })
    }

    pub fn all_bytes(&self) -> usize {
        self.header_bytes + self.body_bytes + 4
    }

    /// Whether such a message may follow.
    pub fn is_believed(&self) -> bool {
        self.believed && self.all_bytes() <= MAX_BINARY_BYTES
    }

    /// Whether it is one that is read.
    pub fn is_read(&self) -> bool {
        self.kind.is_some()
    }
}

/// CRCs of all beginnings of some held bytes, as far as one was asked for.
///
/// CRC-32 without inversion is linear: with `c(n)` the CRC of the first `n` bytes, that of the bytes `a..b`
/// is `c(b)` less what becomes of `c(a)` when `b - a` zeros follow. So every byte is looked at once, however
/// many messages seem to begin before it: frames of 16 KiB announced every 16 bytes cost no more than others.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    /// CRC of the bytes before each one; of those that were taken from the front, something that fits the
    /// others.
    before: Vec<u32>,
}

impl Sums {
    /// With room for so many bytes.
    pub fn with_capacity(bytes: usize) -> Self {
        let mut before = Vec::with_capacity(bytes + 1);
        before.push(0);
        Self { before }
    }

    /// Whether the bytes `from..to` of `held` are a message with the right CRC behind it.
    pub fn is_intact(&mut self, held: &[u8], from: usize, to: usize) -> bool {
        let known = self.before.len() - 1;
        let mut crc = self.before[known];
        for byte in held.get(known..to).unwrap_or_default() {
            crc = crc32_step(crc, *byte);
            self.before.push(crc);
        }
        match (self.before.get(from), self.before.get(to)) {
            (Some(first), Some(last)) => zeros_behind(*first, to - from) == *last,
            _ => false,
        }
    }

    /// So many bytes are gone from the front of what is held.
    pub fn taken(&mut self, bytes: usize) {
        if bytes < self.before.len() {
            self.before.drain(..bytes);
        } else {
            self.before.clear();
            self.before.push(0);
        }
    }
}

/// What becomes of a CRC when zeros follow: the product with `x^(8 zeros)`, modulo the polynomial.
fn zeros_behind(crc: u32, zeros: usize) -> u32 {
    const POWERS: [u32; 16] = powers();
    let bits = (0..POWERS.len()).filter(|bit| zeros >> bit & 1 == 1);
    bits.fold(crc, |crc, bit| product(POWERS[bit], crc))
}

/// Product of two polynomials modulo that of the CRC; the highest bit is the constant term.
const fn product(a: u32, mut b: u32) -> u32 {
    let (mut sum, mut bit) = (0, 1 << 31);
    while bit != 0 {
        if a & bit != 0 {
            sum ^= b;
        }
        b = if b & 1 == 1 { (b >> 1) ^ POLYNOMIAL } else { b >> 1 };
        bit >>= 1;
    }
    sum
}

/// `x^8`, `x^16`, `x^32`, ... modulo the polynomial: one, two, four, ... bytes of zeros, below 64 KiB.
const fn powers() -> [u32; 16] {
    let mut powers = [0; 16];
    powers[0] = 1 << (31 - 8);
    let mut i = 1;
    while i < powers.len() {
        powers[i] = product(powers[i - 1], powers[i - 1]);
        i += 1;
    }
    powers
}

/// Reads a binary message whose checksum is right.
pub(super) fn binary(frame: &Frame, message: &[u8]) -> Result<Content, Unread> {
    let body = &message[frame.header_bytes..message.len() - 4];
    let double = |at| f64_at(body, at);
    let angles_and_velocity =
        |velocity: [usize; 3], angles: [usize; 3]| (velocity.map(double), angles.map(double));
    match frame.kind {
        None => Err(Unread::Unknown),
        Some(Kind::Inspvax) => {
            let (velocity_mps, angles_deg) = angles_and_velocity([36, 44, 52], [60, 68, 76]);
            Inspvax {
                week: u32::from(u16_at(message, 14)),
                seconds: f64::from(u32_at(message, 16)) / 1e3,
                timed: message[13] > TIME_UNKNOWN,
                status: u32_at(body, 0),
                lat_deg: double(8),
                lon_deg: double(16),
                altitude_m: double(24),
                undulation_m: f64::from(f32_at(body, 32)),
                velocity_mps,
                angles_deg,
                sigma_position_m: [84, 88, 92].map(|at| f32_at(body, at)),
                sigma_velocity_mps: [96, 100, 104].map(|at| f32_at(body, at)),
                sigma_angles_deg: [108, 112, 116].map(|at| f32_at(body, at)),
            }
            .checked()
            .map(Content::Inspvax)
        }
        Some(Kind::Inspva) => {
            let (velocity_mps, angles_deg) = angles_and_velocity([36, 44, 52], [60, 68, 76]);
            let place = [12, 20, 28].map(double);
            inspva(u32_at(body, 0), double(4), u32_at(body, 84), place, velocity_mps, angles_deg)
        }
    }
}

/// INSPVA or INSPVAS: its height is above the ellipsoid, and it states no deviations.
fn inspva(
    week: u32,
    seconds: f64,
    status: u32,
    [lat_deg, lon_deg, altitude_m]: [f64; 3],
    velocity_mps: [f64; 3],
    angles_deg: [f64; 3],
) -> Result<Content, Unread> {
    let none = [0.0; 3];
    Inspvax {
        week,
        seconds,
        timed: week > 0,
        status,
        lat_deg,
        lon_deg,
        altitude_m,
        undulation_m: 0.0,
        velocity_mps,
        angles_deg,
        sigma_position_m: none,
        sigma_velocity_mps: none,
        sigma_angles_deg: none,
    }
    .checked()
    .map(Content::Inspva)
}

/// What a binary message is called: the number of its kind.
pub(super) fn number_of(message: &[u8]) -> u16 {
    u16_at(message, 4)
}

/// Where an ASCII log begins in a line: `#` or `%`, a name, a comma, and later a `;`.
pub(super) fn ascii_start(line: &[u8]) -> Option<usize> {
    let at = line.iter().position(|&b| matches!(b, b'#' | b'%'))?;
    let rest = &line[at + 1..];
    let name = rest.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
    let named = rest.first()?.is_ascii_uppercase() && rest.get(name) == Some(&b',');
    (named && rest.contains(&b';')).then_some(at)
}

/// Whether a line is of an abbreviated ASCII log: `<NAME ...` or `<     values`, a port may stand before it.
pub(super) fn is_abbreviated(line: &[u8]) -> bool {
    let line = match line.first() {
        Some(b'[') => line.iter().position(|&b| b == b']').map_or(line, |at| &line[at + 1..]),
        _ => line,
    };
    match line
        .strip_prefix(b"<")
        .map(|rest| (rest, rest.iter().take_while(|b| b.is_ascii_uppercase()).count()))
    {
        Some((rest, 0)) => rest.starts_with(b"  "),
        Some((rest, name)) => {
            name >= 3 && rest[name..].iter().find(|b| !b.is_ascii_alphanumeric()) == Some(&b' ')
        }
        None => false,
    }
}

/// Reads an ASCII log from its `#` or `%` on; `None` if its checksum is wrong or missing.
pub(super) fn ascii(line: &[u8]) -> Option<Result<Content, Unread>> {
    let star = line.iter().rposition(|&b| b == b'*')?;
    let digits = line.get(star + 1..star + 9).filter(|d| d.iter().all(u8::is_ascii_hexdigit))?;
    let given = u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    let text = &line[1..star];
    (crc32(text) == given)
        .then(|| std::str::from_utf8(text).map_err(|_| Unread::Malformed).and_then(ascii_fields))
}

fn ascii_fields(text: &str) -> Result<Content, Unread> {
    let (header, body) = text.split_once(';').ok_or(Unread::Malformed)?;
    match header.split(',').next() {
        Some("INSPVAXA") => inspvaxa(header, body),
        Some("INSPVAA" | "INSPVASA") => inspvaa(body),
        _ => Err(Unread::Unknown),
    }
}

fn status_of(name: &str) -> u32 {
    STATUS.iter().find(|(known, _)| *known == name).map_or(u32::MAX, |(_, number)| *number)
}

/// The next `N` fields, as numbers.
fn figures<'a, const N: usize>(fields: &mut impl Iterator<Item = &'a str>) -> Result<[f64; N], Unread> {
    let mut figures = [0.0; N];
    for place in &mut figures {
        *place = fields.next().and_then(number).ok_or(Unread::Malformed)?;
    }
    Ok(figures)
}

fn inspvaa(body: &str) -> Result<Content, Unread> {
    let mut fields = body.split(',');
    let week = fields.next().and_then(|week| week.parse().ok()).ok_or(Unread::Malformed)?;
    let [seconds] = figures(&mut fields)?;
    let place = figures(&mut fields)?;
    let (velocity, angles) = (figures(&mut fields)?, figures(&mut fields)?);
    inspva(week, seconds, status_of(fields.next().ok_or(Unread::Malformed)?), place, velocity, angles)
}

fn inspvaxa(header: &str, body: &str) -> Result<Content, Unread> {
    let header_field = |index: usize| header.split(',').nth(index).ok_or(Unread::Malformed);
    let mut fields = body.split(',');
    let status = fields.next().ok_or(Unread::Malformed)?;
    fields.next().ok_or(Unread::Malformed)?;
    let [lat_deg, lon_deg, altitude_m, undulation_m] = figures(&mut fields)?;
    let (velocity_mps, angles_deg) = (figures(&mut fields)?, figures(&mut fields)?);
    let mut single = || figures(&mut fields).map(|sigma: [f64; 3]| sigma.map(|sigma| sigma as f32));
    Inspvax {
        week: header_field(5)?.parse().map_err(|_| Unread::Malformed)?,
        seconds: number(header_field(6)?).filter(|s| *s >= 0.0).ok_or(Unread::Malformed)?,
        timed: header_field(4)? != "UNKNOWN",
        status: status_of(status),
        lat_deg,
        lon_deg,
        altitude_m,
        undulation_m,
        velocity_mps,
        angles_deg,
        sigma_position_m: single()?,
        sigma_velocity_mps: single()?,
        sigma_angles_deg: single()?,
    }
    .checked()
    .map(Content::Inspvax)
}

fn bytes_at<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|i| bytes[at + i])
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(bytes_at(bytes, at))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes_at(bytes, at))
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes_at(bytes, at))
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes_at(bytes, at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crc_from_two_beginnings_is_that_of_the_bytes_between() {
        // No byte is 0: the CRC begins at 0 and does not see zeros in front of a message.
        let held: Vec<u8> =
            (0..40_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8 | 1).collect();
        for (taken, from, length) in
            [(0, 0, 4), (0, 17, 1), (5, 900, 16_384), (20_000, 0, 33), (39_000, 3, 900)]
        {
            let mut sums = Sums::with_capacity(held.len());
            // Known or not when the front is taken.
            sums.is_intact(&held, 0, 10_000);
            sums.taken(taken);
            let mut held = held[taken..].to_vec();
            let crc = crc32(&held[from..from + length]);
            held.splice(from + length..(from + length + 4).min(held.len()), crc.to_le_bytes());
            // What was known of the bytes that were changed must not be used.
            let mut fresh = Sums::with_capacity(held.len());
            assert!(fresh.is_intact(&held, from, from + length + 4), "{taken} {from} {length}");
            assert!(!fresh.is_intact(&held, from + 1, from + length + 4));
            if taken > 10_000 {
                assert!(sums.is_intact(&held, from, from + length + 4), "{taken} {from} {length}");
            }
        }
    }
}
