//! AIS sentences (NMEA 0183 `VDM` and `VDO`, of any talker) and the messages in them (ITU-R M.1371-5).
//!
//! ```text
//! \c:1714564800*55\!AIVDM,1,1,,A,139>Jh@P1T0eii`NqRv1hgv00000,0*22
//! ```
//!
//! Read are position reports (messages 1, 2, 3, 18, 19), sizes (5, 19, 24) and the UTC of base stations (4,
//! 11). Messages of several sentences are put together. Other lines are passed over.
//!
//! A position report says no more of its time than the second. Its time is, whichever is there first:
//!
//! 1. field `c` of a tag block in front: UTC since 1970, s (or ms);
//! 2. the last field after the checksum, UTC since 1970, s, as networks of stations append it;
//! 3. the instant nearest to the last base station report that has its second.

use std::collections::HashMap;
use std::ops::Range;

use super::{Collected, Size, Stated};
use crate::nav::faults::{FaultKind, Faults};
use crate::time::TimeTag;

/// Sentences of a log begin within so many bytes.
const HEAD_BYTES: usize = 1 << 16;
/// Longest payload of a sentence, characters: they have 82.
const MOST_PAYLOAD: usize = 1024;
/// Unit of latitudes and longitudes, degrees.
const ANGLE_DEG: f64 = 1.0 / 600_000.0;
/// UNIX times of logs, s: from 1990 until 2200.
const UNIX_S: Range<i64> = 631_152_000..7_258_118_400;

/// Whether bytes are such a log.
pub(super) fn are_in(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    head.windows(7).any(|w| w[0] == b'!' && w[3..5] == *b"VD" && matches!(w[5], b'M' | b'O') && w[6] == b',')
}

/// Reads a log.
pub(super) fn read(bytes: &[u8], collected: &mut Collected, faults: &mut Faults) {
    let mut decoder = Decoder { collected, clock: None, parts: HashMap::new(), messages: 0 };
    for (index, line) in bytes.split(|byte| matches!(byte, b'\n' | b'\r')).enumerate() {
        if !decoder.collected.has_room(index as u64 + 1, faults) {
            return;
        }
        decoder.line(line);
    }
    let Decoder { collected, messages, .. } = decoder;
    if collected.reports.is_empty() {
        let passed_over = match &collected.passed_over {
            nothing if nothing.is_nothing() => String::new(),
            some => format!(", {some}"),
        };
        faults.push(1, FaultKind::NoAisReport { messages, passed_over });
    }
}

/// What has come of a message in several sentences.
struct Parts {
    time: Option<TimeTag>,
    payloads: Vec<Option<Vec<u8>>>,
}

struct Decoder<'a> {
    collected: &'a mut Collected,
    /// The last base station report.
    clock: Option<TimeTag>,
    /// By sequence number and channel.
    parts: HashMap<[u8; 2], Parts>,
    /// Whole messages.
    messages: usize,
}

impl Decoder<'_> {
    fn line(&mut self, line: &[u8]) {
        let Some(start) = line.iter().position(|byte| *byte == b'!') else { return };
        let (before, sentence) = line.split_at(start);
        let Some(star) = sentence.iter().position(|byte| *byte == b'*') else { return };
        let (body, after) = (&sentence[1..star], &sentence[star + 1..]);
        if body.len() < 6 || body[2..4] != *b"VD" || !matches!(body[4], b'M' | b'O') {
            return;
        }
        let fields: Vec<&[u8]> = body.split(|byte| *byte == b',').collect();
        let sound = checksum(after) == Some(body.iter().fold(0, |sum, byte| sum ^ byte));
        let &[_, &[total @ b'1'..=b'9'], &[part @ b'1'..=b'9'], sequence, channel, payload, _] = &fields[..]
        else {
            self.collected.passed_over.damaged += 1;
            return;
        };
        if !sound || part > total || payload.len() > MOST_PAYLOAD {
            self.collected.passed_over.damaged += 1;
            return;
        }
        let time = tag_time(before).or_else(|| appended_time(after));
        if total == b'1' {
            self.message(payload, time);
            return;
        }
        let key = [sequence, channel].map(|field| field.first().copied().unwrap_or(0));
        let (total, part) = (usize::from(total - b'0'), usize::from(part - b'1'));
        let parts = self.parts.entry(key).or_insert_with(|| Parts { time, payloads: Vec::new() });
        if part == 0 || parts.payloads.len() != total {
            *parts = Parts { time, payloads: vec![None; total] };
        }
        parts.time = parts.time.or(time);
        parts.payloads[part] = Some(payload.to_vec());
        if parts.payloads.iter().all(Option::is_some)
            && let Some(parts) = self.parts.remove(&key)
        {
            let whole: Vec<u8> = parts.payloads.into_iter().flatten().flatten().collect();
            self.message(&whole, parts.time);
        }
    }

    fn message(&mut self, payload: &[u8], time: Option<TimeTag>) {
        let Some(bits) = Bits::of(payload) else {
            self.collected.passed_over.damaged += 1;
            return;
        };
        self.messages += 1;
        let mmsi = bits.unsigned(8, 30);
        // Where speed, longitude, latitude, course and second begin; where length and beam do.
        let (position, size) = match bits.unsigned(0, 6) {
            Some(1..=3) => (Some([50, 61, 89, 116, 137]), None),
            Some(18) => (Some([46, 57, 85, 112, 133]), None),
            Some(19) => (Some([46, 57, 85, 112, 133]), Some(271)),
            Some(5) => (None, Some(240)),
            // Part B; a craft carried aboard has its ship's number where others have their size.
            Some(24)
                if bits.unsigned(38, 2) == Some(1) && mmsi.is_some_and(|mmsi| mmsi / 10_000_000 != 98) =>
            {
                (None, Some(132))
            }
            Some(4 | 11) => {
                self.clock = bits.utc().or(self.clock);
                return;
            }
            _ => return,
        };
        if let (Some(at), Some(mmsi)) = (size, mmsi) {
            let draught_m =
                bits.unsigned(294, 8).filter(|_| at == 240).map(|tenths| f64::from(tenths) / 10.0);
            let [length_m, beam_m] = bits.length_beam_m(at);
            self.collected.size(mmsi, [length_m, beam_m, draught_m] as Size);
        }
        if let Some([speed, lon, lat, course, second]) = position {
            let Some(seconds) = bits.unsigned(second, 6) else {
                self.collected.passed_over.damaged += 1;
                return;
            };
            let Some(time) = time.or_else(|| self.clock.map(|clock| nearest(clock, seconds))) else {
                self.collected.passed_over.without_time += 1;
                return;
            };
            let tenths =
                |at: usize, wide: usize| bits.unsigned(at, wide).map(|tenths| f64::from(tenths) / 10.0);
            let stated = Stated {
                mmsi: mmsi.map(f64::from),
                lat_deg: bits.signed(lat, 27).map(|angle| f64::from(angle) * ANGLE_DEG),
                lon_deg: bits.signed(lon, 28).map(|angle| f64::from(angle) * ANGLE_DEG),
                course_deg: tenths(course, 12),
                knots: tenths(speed, 10),
            };
            self.collected.push(time, &stated);
        }
    }
}

/// The instant nearest to another whose second of the minute is given; that one where it is none.
pub(super) fn nearest(clock: TimeTag, second: u32) -> TimeTag {
    if second >= 60 {
        return clock;
    }
    let off_s = i64::from(second) - clock.seconds().rem_euclid(60);
    clock.plus(((off_s + 30).rem_euclid(60) - 30) as f64)
}

fn checksum(after: &[u8]) -> Option<u8> {
    u8::from_str_radix(std::str::from_utf8(after.get(..2)?).ok()?, 16).ok()
}

fn unix(field: &[u8]) -> Option<TimeTag> {
    let value: i64 = std::str::from_utf8(field).ok()?.parse().ok()?;
    let (whole_s, fraction_s) = match UNIX_S.contains(&value) {
        true => (value, 0.0),
        false => (value / 1000, (value % 1000) as f64 / 1e3),
    };
    UNIX_S.contains(&whole_s).then(|| TimeTag::new(whole_s, fraction_s))
}

/// Field `c` of a tag block whose checksum is right.
fn tag_time(before: &[u8]) -> Option<TimeTag> {
    let block = before.trim_ascii().strip_suffix(b"\\")?;
    let block = &block[block.iter().rposition(|byte| *byte == b'\\')? + 1..];
    let star = block.iter().rposition(|byte| *byte == b'*')?;
    let (fields, after) = (&block[..star], &block[star + 1..]);
    let sound = checksum(after) == Some(fields.iter().fold(0, |sum, byte| sum ^ byte));
    let mut times = fields.split(|byte| *byte == b',').filter_map(|field| field.strip_prefix(b"c:"));
    times.next().filter(|_| sound).and_then(unix)
}

/// The last field after the checksum.
fn appended_time(after: &[u8]) -> Option<TimeTag> {
    let comma = after.iter().rposition(|byte| *byte == b',')?;
    unix(after[comma + 1..].trim_ascii())
}

/// The bits of a message, six to a value.
struct Bits(Vec<u8>);

impl Bits {
    /// Of the characters of a payload; `None` if one of them is none of AIS.
    fn of(payload: &[u8]) -> Option<Self> {
        let six = |byte: &u8| match byte {
            b'0'..=b'W' => Some(byte - b'0'),
            b'`'..=b'w' => Some(byte - b'0' - 8),
            _ => None,
        };
        payload.iter().map(six).collect::<Option<_>>().map(Self)
    }

    /// An unsigned number of up to 32 bits; `None` beyond the end.
    fn unsigned(&self, at: usize, wide: usize) -> Option<u32> {
        (at..at + wide).try_fold(0, |value, bit| {
            let six = self.0.get(bit / 6)?;
            Some(value << 1 | u32::from(six >> (5 - bit % 6) & 1))
        })
    }

    fn signed(&self, at: usize, wide: usize) -> Option<i32> {
        let unused = 32 - wide as u32;
        Some(((self.unsigned(at, wide)? << unused) as i32) >> unused)
    }

    /// Sums of the distances of the antenna from bow and stern, and from both sides; 0 says nothing, and all
    /// ones "or more".
    fn length_beam_m(&self, at: usize) -> [Option<f64>; 2] {
        let sum = |[first, second]: [usize; 2], wide: usize| {
            let (a, b) = (self.unsigned(first, wide)?, self.unsigned(second, wide)?);
            let most = (1 << wide) - 1;
            (a < most && b < most).then_some(f64::from(a + b))
        };
        [sum([at, at + 9], 9), sum([at + 18, at + 24], 6)]
    }

    /// The UTC of a base station.
    fn utc(&self) -> Option<TimeTag> {
        let [year, month, day] = [(38, 14), (52, 4), (56, 5)].map(|(at, wide)| self.unsigned(at, wide));
        let [hour, minute, second] = [(61, 5), (66, 6), (72, 6)].map(|(at, wide)| self.unsigned(at, wide));
        // Year 0 is none.
        let year = year.filter(|year| (1990..2200).contains(year));
        let (date, clock) = ((year?, month?, day?), (hour?, minute?, second?));
        let text = format!(
            "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
            date.0, date.1, date.2, clock.0, clock.1, clock.2
        );
        TimeTag::from_iso8601(&text).ok()
    }
}
