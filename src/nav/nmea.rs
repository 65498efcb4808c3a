//! NMEA 0183 logs.
//!
//! Positions come from GGA, RMC and GLL, dates from RMC and ZDA, heights from GGA, headings from HDT and
//! the whole attitude from PASHR; sentences of one epoch (the same time of day) become one [`Fix`], GGA
//! before RMC before GLL. A sentence may have anything before its `$` on the line (a logger's time
//! stamp). Sentences with a wrong checksum, without one, of other kinds, void or unreadable are
//! skipped, counted in the [`LoadReport`] and never an error by themselves; a log that
//! gives no usable fix at all is one, and says why.
//!
//! * **Date.** An epoch without a date of its own takes that of its neighbours: where the time of day falls
//!   by more than half a day, midnight has passed. Epochs before the first date are dated backwards.
//! * **Order.** An epoch up to 5 s earlier than one already seen (two talkers with different delays) is
//!   skipped and counted; a larger step back is a fault of the file.
//! * **Height** above the ellipsoid: altitude of GGA plus geoid separation of the same sentence; where it
//!   gives no separation, the datum of the source decides: `Ellipsoid` takes it as it is, `MeanSeaLevel`
//!   adds `undulation_m`, `Barometric` adds `offset_m` and `undulation_m`. A fix without an altitude gets
//!   one interpolated between those beside it (held at the ends); a log without any altitude is taken to
//!   be at mean sea level, `undulation_m`. Both are counted as `heights_filled`.
//! * **Attitude.** HDT has no time and belongs to the epoch that is open when it comes; alone it gives yaw, with
//!   pitch and roll zero. Fixes without a heading get one
//!   interpolated (the short way round; held at the ends) and are counted as `headings_filled`.
//!   VTG and the course of RMC say where the platform goes, not where it looks, and are not used.
//!
//! Resolution: a position of `ddmm.mmm` is quantised to 1.9 m, which used as truth without smoothing means
//! accelerations of metres per second squared.
//!
//! Source of the sentence formats: <https://gpsd.gitlab.io/gpsd/NMEA.html>. Decoding is done by the crate
//! `nmea`, but for PASHR, which it does not know.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, nmea};
//!
//! let source = FileSource {
//!     path: "ship.nmea".into(),
//!     format: FileFormat::Nmea,
//!     datum: VerticalDatum::MeanSeaLevel,
//!     undulation_m: 41.0,
//!     max_gap_s: 5.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Level,
//! };
//! let log = "$GPRMC,195719,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*10\r\n\
//!            $GPRMC,195720,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*1B\r\n";
//! let error = nmea::parse(log.as_bytes(), &source).unwrap_err();
//! // The second checksum is wrong: one fix is left, and a track needs two.
//! assert!(error.to_string().contains("usable fixes: 1, needed: at least 2"));
//! ```

use ::nmea::ParseResult;
use ::nmea::sentences::FixType;
use ::nmea::sentences::rmc::RmcStatusOfFix;

use super::faults::{Faults, NavError, NoFix};
use super::replay::{self, LoadReport, MAX_FIXES, Recording};
use super::{FaultKind, FileSource, Fix, Place};
use crate::frames::Geodetic;
use crate::time::TimeTag;

const DAY_S: i64 = 86_400;
const DAY_NS: i64 = DAY_S * 1_000_000_000;
/// The step back that two talkers with different delays may cause, ns.
const DISORDER_NS: i64 = 5_000_000_000;

/// Reads fixes from the bytes of an NMEA log.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let mut log = Log {
        report: LoadReport { path: source.path.display().to_string(), ..LoadReport::default() },
        ..Log::default()
    };
    for line in bytes.split(|&b| b == b'\n') {
        log.line(line, source);
        if log.epochs.len() > MAX_FIXES {
            break;
        }
    }
    // What follows the last newline is a line only if there is something.
    if bytes.is_empty() || bytes.ends_with(b"\n") {
        log.report.lines -= 1;
    }
    log.close_epoch();
    log.finish(source)
}

/// Everything said with one time of day.
#[derive(Clone, Copy, Debug, Default)]
struct Epoch {
    line: u64,
    time_of_day_ns: i64,
    /// Days since 1970-01-01.
    day: Option<i64>,
    /// Latitude and longitude, degrees, and how good their source is.
    position: Option<(f64, f64, u8)>,
    height_m: Option<f64>,
    yaw_pitch_roll_rad: Option<[f64; 3]>,
}

#[derive(Default)]
struct Log {
    report: LoadReport,
    sentences: u64,
    open: Option<Epoch>,
    epochs: Vec<Epoch>,
}

impl Log {
    fn line(&mut self, line: &[u8], source: &FileSource) {
        self.report.lines += 1;
        let line = line.trim_ascii();
        if line.is_empty() {
            return;
        }
        let Some(start) = line.iter().position(|&b| b == b'$' || b == b'!') else {
            self.report.malformed += 1;
            return;
        };
        let line = &line[start..];
        let Some((body, given)) = split_checksum(line) else {
            self.report.malformed += 1;
            return;
        };
        if body.iter().fold(0, |sum, byte| sum ^ byte) != given {
            self.report.bad_checksum += 1;
            return;
        }
        let Ok(text) = std::str::from_utf8(&line[..body.len() + 4]) else {
            self.report.malformed += 1;
            return;
        };
        self.sentences += 1;
        let fields: Vec<&str> = text[1..=body.len()].split(',').collect();
        if fields[0] == "PASHR" {
            self.pashr(&fields);
            return;
        }
        let time_field = match fields[0].get(2..) {
            Some("GGA" | "RMC" | "ZDA") => fields.get(1),
            Some("GLL") => fields.get(5),
            Some("HDT") => None,
            _ => {
                self.report.unknown_sentences += 1;
                return;
            }
        };
        // Times are read from the text: the crate takes "nan" for a number, and rounds.
        let time = time_field.and_then(|text| parse_time_of_day_ns(text));
        if time.is_none() && time_field.is_some_and(|text| !text.is_empty()) {
            self.report.malformed += 1;
            return;
        }
        match ::nmea::parse_str(text) {
            Ok(ParseResult::GGA(gga)) => {
                let valid = gga.fix_type.is_some_and(|quality| quality != FixType::Invalid);
                let height_m = gga.altitude.map(|altitude| match gga.geoid_separation {
                    Some(separation) => f64::from(altitude) + f64::from(separation),
                    None => replay::ellipsoidal_height_m(f64::from(altitude), source),
                });
                self.position(time, gga.latitude.zip(gga.longitude), valid, 3, |epoch| {
                    epoch.height_m = height_m.filter(|h| h.is_finite() && h.abs() < 1e8);
                });
            }
            Ok(ParseResult::RMC(rmc)) => {
                let valid = rmc.status_of_fix != RmcStatusOfFix::Invalid;
                let day = rmc.fix_date.map(|date| date.signed_duration_since(Default::default()).num_days());
                self.position(time, rmc.lat.zip(rmc.lon), valid, 2, |epoch| {
                    epoch.day = day.or(epoch.day);
                });
            }
            Ok(ParseResult::GLL(gll)) => {
                self.position(time, gll.latitude.zip(gll.longitude), gll.valid, 1, |_| {});
            }
            Ok(ParseResult::ZDA(zda)) => {
                let day =
                    zda.utc_date().map(|date| date.signed_duration_since(Default::default()).num_days());
                if let (Some(time), Some(day)) = (time, day) {
                    self.epoch(time).day = Some(day);
                }
            }
            Ok(ParseResult::HDT(hdt)) => {
                let yaw = hdt.heading.map(f64::from).filter(|yaw| (0.0..=360.0).contains(yaw));
                if let (Some(yaw), Some(epoch)) = (yaw, self.open.as_mut()) {
                    epoch.yaw_pitch_roll_rad.get_or_insert([yaw.to_radians(), 0.0, 0.0]);
                }
            }
            Ok(_) => self.report.unknown_sentences += 1,
            Err(_) => self.report.malformed += 1,
        }
    }

    /// `PASHR,hhmmss.sss,heading,T,roll,pitch,heave,...`, degrees.
    fn pashr(&mut self, fields: &[&str]) {
        let number = |index: usize, limit: f64| {
            let value: f64 = fields.get(index)?.parse().ok()?;
            (value.abs() <= limit).then_some(value)
        };
        let time = fields.get(1).and_then(|text| parse_time_of_day_ns(text));
        match (time, number(2, 360.0), number(5, 90.0), number(4, 180.0)) {
            (Some(time), Some(yaw), Some(pitch), Some(roll)) => {
                self.epoch(time).yaw_pitch_roll_rad = Some([yaw, pitch, roll].map(f64::to_radians));
            }
            _ => self.report.malformed += 1,
        }
    }

    fn position(
        &mut self,
        time_of_day_ns: Option<i64>,
        position_deg: Option<(f64, f64)>,
        valid: bool,
        rank: u8,
        also: impl FnOnce(&mut Epoch),
    ) {
        let (Some(time), Some((lat, lon)), true) = (time_of_day_ns, position_deg, valid) else {
            self.report.void_positions += 1;
            return;
        };
        if !(lat.abs() <= 90.0 && lon.abs() <= 180.0) {
            self.report.malformed += 1;
            return;
        }
        let epoch = self.epoch(time);
        also(epoch);
        if epoch.position.is_none_or(|(_, _, held)| held < rank) {
            epoch.position = Some((lat, lon, rank));
        }
    }

    /// The open epoch of this time of day; another one is closed first.
    fn epoch(&mut self, time_of_day_ns: i64) -> &mut Epoch {
        if self.open.is_some_and(|epoch| epoch.time_of_day_ns != time_of_day_ns) {
            self.close_epoch();
        }
        let line = self.report.lines;
        self.open.get_or_insert(Epoch { line, time_of_day_ns, ..Epoch::default() })
    }

    fn close_epoch(&mut self) {
        self.epochs.extend(self.open.take());
    }

    fn finish(mut self, source: &FileSource) -> Result<Recording, NavError> {
        let located = self.epochs.iter().any(|epoch| epoch.position.is_some());
        let reason = if self.sentences == 0 {
            Some(NoFix::NoSentence)
        } else if !located {
            Some(NoFix::NoPosition)
        } else if !date_all(&mut self.epochs) {
            Some(NoFix::NoDate)
        } else {
            None
        };
        if let Some(reason) = reason {
            let report = Box::new(self.report);
            return Err(NavError::NoFix { path: source.path.clone(), reason, report });
        }

        let mut faults = Faults::default();
        if self.epochs.len() > MAX_FIXES {
            faults.push(self.report.lines, FaultKind::TooManyFixes { allowed: MAX_FIXES });
        }
        let mut kept: Vec<(TimeTag, Epoch)> = Vec::with_capacity(self.epochs.len());
        for epoch in self.epochs {
            let (Some(day), Some(_)) = (epoch.day, epoch.position) else { continue };
            let (seconds, rest_ns) =
                (epoch.time_of_day_ns / 1_000_000_000, epoch.time_of_day_ns % 1_000_000_000);
            let time = TimeTag::new(day * DAY_S + seconds, rest_ns as f64 * 1e-9);
            let step_s = kept.last().map_or(f64::INFINITY, |(before, _)| time.since(*before));
            if step_s <= 0.0 && step_s >= -(DISORDER_NS as f64) * 1e-9 {
                self.report.out_of_order += 1;
                continue;
            }
            kept.push((time, epoch));
        }
        self.report.heights_filled = fill_heights(&mut kept, source.undulation_m);
        self.report.headings_filled = fill_attitudes(&mut kept);

        let mut fixes = Vec::with_capacity(kept.len());
        for (time, epoch) in kept {
            let (Some((lat, lon, _)), Some(h_m)) = (epoch.position, epoch.height_m) else { continue };
            let fix = Fix {
                time,
                place: Place::Geodetic(Geodetic::from_deg(lat, lon, h_m)),
                yaw_pitch_roll_rad: epoch.yaw_pitch_roll_rad,
            };
            if replay::follows(&fixes, &fix, epoch.line, source, &mut faults) {
                fixes.push(fix);
            }
        }
        replay::finish(fixes, self.report, faults, source)
    }
}

/// What lies between `$` and `*`, and the two hexadecimal digits after it.
fn split_checksum(line: &[u8]) -> Option<(&[u8], u8)> {
    let star = line.iter().position(|&b| b == b'*')?;
    let digits = line.get(star + 1..star + 3)?;
    if !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    let given = u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    Some((&line[1..star], given))
}

/// `hhmmss.sss` as nanoseconds since midnight.
fn parse_time_of_day_ns(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    if whole.len() != 6 || !whole.bytes().chain(fraction.bytes()).all(|b| b.is_ascii_digit()) {
        return None;
    }
    let pair = |at: usize| whole[at..at + 2].parse::<i64>().ok();
    let (hour, minute, second) = (pair(0)?, pair(2)?, pair(4)?);
    if hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    let fraction_s: f64 = format!("0.{fraction}").parse().ok()?;
    let ns = ((fraction_s * 1e9).round() as i64).min(999_999_999);
    Some(((hour * 60 + minute) * 60 + second) * 1_000_000_000 + ns)
}

/// Gives every epoch its day; false if none has one.
fn date_all(epochs: &mut [Epoch]) -> bool {
    let Some(first) = epochs.iter().position(|epoch| epoch.day.is_some()) else { return false };
    for index in (0..first).rev() {
        let (later_day, later_ns) = (epochs[index + 1].day, epochs[index + 1].time_of_day_ns);
        let passed = epochs[index].time_of_day_ns - later_ns > DAY_NS / 2;
        epochs[index].day = later_day.map(|day| day - i64::from(passed));
    }
    for index in first + 1..epochs.len() {
        if epochs[index].day.is_none() {
            let (before_day, before_ns) = (epochs[index - 1].day, epochs[index - 1].time_of_day_ns);
            let step = epochs[index].time_of_day_ns - before_ns;
            // A talker that lags may fall back over midnight.
            let days = i64::from(step < -DAY_NS / 2) - i64::from(step > DAY_NS / 2);
            epochs[index].day = before_day.map(|day| day + days);
        }
    }
    true
}

/// Gives a height to those that have none; how many.
fn fill_heights(kept: &mut [(TimeTag, Epoch)], sea_level_m: f64) -> u64 {
    fill(
        kept,
        |epoch| epoch.height_m,
        |a, b, s| a + (b - a) * s,
        |epoch, height| {
            epoch.height_m = Some(height.unwrap_or(sea_level_m));
        },
    )
}

/// Gives an attitude to those that have none, if any has one; how many.
fn fill_attitudes(kept: &mut [(TimeTag, Epoch)]) -> u64 {
    if kept.iter().all(|(_, epoch)| epoch.yaw_pitch_roll_rad.is_none()) {
        return 0;
    }
    let short_way = |a: f64, b: f64| {
        let turn = (b - a).rem_euclid(std::f64::consts::TAU);
        if turn > std::f64::consts::PI { turn - std::f64::consts::TAU } else { turn }
    };
    let between =
        |a: [f64; 3], b: [f64; 3], s: f64| std::array::from_fn(|i| a[i] + short_way(a[i], b[i]) * s);
    fill(kept, |epoch| epoch.yaw_pitch_roll_rad, between, |epoch, angles| epoch.yaw_pitch_roll_rad = angles)
}

/// Fills what is missing from the nearest on either side; how many were missing.
fn fill<T: Copy>(
    kept: &mut [(TimeTag, Epoch)],
    get: impl Fn(&Epoch) -> Option<T>,
    between: impl Fn(T, T, f64) -> T,
    set: impl Fn(&mut Epoch, Option<T>),
) -> u64 {
    let mut missing = 0;
    let mut before: Option<(TimeTag, T)> = None;
    let mut index = 0;
    while index < kept.len() {
        if let Some(value) = get(&kept[index].1) {
            before = Some((kept[index].0, value));
            index += 1;
            continue;
        }
        let end = (index..kept.len()).find(|&i| get(&kept[i].1).is_some());
        let after = end.and_then(|i| Some((kept[i].0, get(&kept[i].1)?)));
        let end = end.unwrap_or(kept.len());
        for (time, epoch) in &mut kept[index..end] {
            let value = match (before, after) {
                (Some((t0, a)), Some((t1, b))) => Some(between(a, b, time.since(t0) / t1.since(t0))),
                (Some((_, held)), None) | (None, Some((_, held))) => Some(held),
                (None, None) => None,
            };
            set(epoch, value);
            missing += 1;
        }
        index = end;
    }
    missing
}
