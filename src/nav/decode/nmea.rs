//! The grammar of NMEA 0183 sentences: fields to values, in the units of the sentence.
//!
//! | sentence | fields |
//! | --- | --- |
//! | GGA | time, latitude, longitude, quality, satellites, HDOP, altitude above mean sea level m, geoid separation m |
//! | RMC | time, status, latitude, longitude, speed kn, course, date `ddmmyy` |
//! | GNS | time, latitude, longitude, mode of each constellation, satellites, HDOP, altitude m, geoid separation m |
//! | GLL | latitude, longitude, time, status |
//! | VTG | course true, course magnetic, speed kn, speed km/h |
//! | HDT | heading true |
//! | THS | heading true, mode |
//! | ZDA | time, day, month, year (four digits), local zone |
//! | GST | time, rms, error ellipse, standard deviations of latitude, longitude, altitude, m |
//! | PASHR | time, heading true, `T`, roll, pitch, heave, standard deviations of roll, pitch, heading, two quality flags |
//!
//! Times are `hhmmss` with any number of decimals, read to a nanosecond from the text. The label 235960 of a
//! leap second is a time of day of 86,400 s. Minutes of an angle are the two digits before the point,
//! whatever zeros of the degrees are left out; below three digits and from 60 minutes on it is malformed.
//! Years of RMC from 80 on are 19xx. Empty fields are no value; a number must be digits with at most one sign
//! and point. Roll is right wing down, pitch nose up.
//!
//! Source: <https://gpsd.gitlab.io/gpsd/NMEA.html>.

use hifitime::Epoch;

use super::{Content, Unread};

/// Fields that are kept of a sentence.
const FIELDS: usize = 24;

/// A time of day and a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed {
    /// UTC since midnight, ns; 86,400 s and more within a leap second.
    pub time_of_day_ns: i64,
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
}

/// Position, quality and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gga {
    /// When and where; `None`: void.
    pub fix: Option<Fixed>,
    /// Altitude above mean sea level (as the receiver has it), m.
    pub altitude_m: Option<f64>,
    /// Height of mean sea level above the ellipsoid, m.
    pub separation_m: Option<f64>,
}

/// Position, speed, course and date.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rmc {
    /// When and where; `None`: void.
    pub fix: Option<Fixed>,
    /// Speed over ground, knots.
    pub speed_knots: Option<f64>,
    /// Course over ground, clockwise from North, degrees.
    pub course_deg: Option<f64>,
    /// Days since 1970-01-01.
    pub day: Option<i64>,
}

/// Position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gll {
    /// When and where; `None`: void.
    pub fix: Option<Fixed>,
}

/// Speed and course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vtg {
    /// Course over ground, clockwise from North, degrees.
    pub course_deg: Option<f64>,
    /// Speed over ground, knots.
    pub speed_knots: Option<f64>,
}

/// Heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hdt {
    /// Heading, clockwise from North, degrees.
    pub heading_deg: Option<f64>,
}

/// Time and date.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zda {
    /// UTC since midnight, ns.
    pub time_of_day_ns: Option<i64>,
    /// Days since 1970-01-01; some receivers leave the date empty.
    pub day: Option<i64>,
}

/// Standard deviations of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gst {
    /// UTC since midnight, ns.
    pub time_of_day_ns: Option<i64>,
    /// Northward, eastward, upward, m.
    pub sigma_m: Option<[f64; 3]>,
}

/// Heading, roll and pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pashr {
    /// UTC since midnight, ns.
    pub time_of_day_ns: i64,
    /// Heading, clockwise from North, degrees.
    pub heading_deg: f64,
    /// Roll, right wing down, degrees.
    pub roll_deg: f64,
    /// Pitch, nose up, degrees.
    pub pitch_deg: f64,
    /// Standard deviations of roll, pitch and heading, degrees.
    pub sigma_deg: Option<[f64; 3]>,
}

/// What lies between `$` and `*`, and the two hexadecimal digits after it.
pub(super) fn split_checksum(sentence: &[u8]) -> Option<(&[u8], u8)> {
    let star = sentence.iter().position(|&b| b == b'*')?;
    let digits = sentence.get(star + 1..star + 3).filter(|d| d.iter().all(u8::is_ascii_hexdigit))?;
    let given = u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    Some((&sentence[1..star], given))
}

/// The exclusive or of all bytes.
pub(crate) fn checksum(body: &[u8]) -> u8 {
    body.iter().fold(0, |sum, byte| sum ^ byte)
}

/// Reads a sentence, without its `$` and checksum.
pub(super) fn sentence(body: &[u8]) -> Result<Content, Unread> {
    let fields = Fields::of(std::str::from_utf8(body).map_err(|_| Unread::Malformed)?);
    if fields.text(0) == "PASHR" {
        return fields.pashr();
    }
    match fields.text(0).get(2..) {
        Some("GGA") => fields.gga(),
        Some("GNS") => fields.gns(),
        Some("THS") => fields.ths(),
        Some("RMC") => fields.rmc(),
        Some("GLL") => fields.gll(),
        Some("VTG") => fields.vtg(),
        Some("HDT") => fields.hdt(),
        Some("ZDA") => fields.zda(),
        Some("GST") => fields.gst(),
        _ => Err(Unread::Unknown),
    }
}

struct Fields<'a> {
    texts: [&'a str; FIELDS],
    count: usize,
}

impl<'a> Fields<'a> {
    fn of(body: &'a str) -> Self {
        let (mut texts, mut count) = ([""; FIELDS], 0);
        for (text, field) in texts.iter_mut().zip(body.split(',')) {
            *text = field;
            count += 1;
        }
        Self { texts, count }
    }

    fn text(&self, index: usize) -> &'a str {
        self.texts[index]
    }

    fn at_least(&self, count: usize) -> Result<(), Unread> {
        if self.count >= count { Ok(()) } else { Err(Unread::Malformed) }
    }

    /// A number within bounds; `None` for an empty field.
    fn number(&self, index: usize, (min, max): (f64, f64)) -> Result<Option<f64>, Unread> {
        match self.text(index) {
            "" => Ok(None),
            text => number(text).filter(|v| (min..=max).contains(v)).map(Some).ok_or(Unread::Malformed),
        }
    }

    fn course(&self, index: usize) -> Result<Option<f64>, Unread> {
        self.number(index, (-360.0, 360.0))
    }

    fn speed(&self, index: usize) -> Result<Option<f64>, Unread> {
        self.number(index, (-1e5, 1e5))
    }

    fn time(&self, index: usize) -> Result<Option<i64>, Unread> {
        match self.text(index) {
            "" => Ok(None),
            text => time_of_day_ns(text).map(Some).ok_or(Unread::Malformed),
        }
    }

    /// Latitude, hemisphere, longitude, hemisphere; `None` if all four are empty.
    fn position(&self, first: usize) -> Result<Option<[f64; 2]>, Unread> {
        let [lat, ns, lon, ew] = [0, 1, 2, 3].map(|i| self.text(first + i));
        if [lat, ns, lon, ew].iter().all(|text| text.is_empty()) {
            return Ok(None);
        }
        let signed = |angle: Option<f64>, half: &str, [plus, minus]: [&str; 2]| match half {
            _ if half == plus => angle,
            _ if half == minus => angle.map(|angle| -angle),
            _ => None,
        };
        let lat = signed(degrees(lat, 2), ns, ["N", "S"]).filter(|lat| lat.abs() <= 90.0);
        let lon = signed(degrees(lon, 3), ew, ["E", "W"]).filter(|lon| lon.abs() <= 180.0);
        lat.zip(lon).map(|(lat, lon)| Some([lat, lon])).ok_or(Unread::Malformed)
    }

    /// Time, position and whether it is valid.
    fn fix(&self, time: usize, position: usize, valid: bool) -> Result<Option<Fixed>, Unread> {
        let (time, position) = (self.time(time)?, self.position(position)?);
        Ok(time.zip(position).filter(|_| valid).map(|(time_of_day_ns, [lat_deg, lon_deg])| Fixed {
            time_of_day_ns,
            lat_deg,
            lon_deg,
        }))
    }

    fn gga(&self) -> Result<Content, Unread> {
        self.at_least(10)?;
        let valid = match self.text(6) {
            "" | "0" => false,
            text if text.bytes().all(|b| b.is_ascii_digit()) => true,
            _ => return Err(Unread::Malformed),
        };
        Ok(Content::Gga(Gga {
            fix: self.fix(1, 2, valid)?,
            altitude_m: self.number(9, (-1e8, 1e8))?,
            separation_m: self.number(11, (-1e4, 1e4))?,
        }))
    }

    fn gns(&self) -> Result<Content, Unread> {
        self.at_least(11)?;
        // One letter for each constellation; N: it is not used.
        let mode = self.text(6);
        if !mode.bytes().all(|b| b.is_ascii_uppercase()) {
            return Err(Unread::Malformed);
        }
        let valid = mode.bytes().any(|b| b != b'N');
        Ok(Content::Gns(Gga {
            fix: self.fix(1, 2, valid)?,
            altitude_m: self.number(9, (-1e8, 1e8))?,
            separation_m: self.number(10, (-1e4, 1e4))?,
        }))
    }

    fn rmc(&self) -> Result<Content, Unread> {
        self.at_least(10)?;
        let valid = match self.text(2) {
            "A" | "D" => true,
            "V" | "" => false,
            _ => return Err(Unread::Malformed),
        };
        let day = match self.text(9) {
            "" => None,
            text => Some(short_date(text).ok_or(Unread::Malformed)?),
        };
        let fix = self.fix(1, 3, valid)?;
        Ok(Content::Rmc(Rmc { fix, speed_knots: self.speed(7)?, course_deg: self.course(8)?, day }))
    }

    fn gll(&self) -> Result<Content, Unread> {
        self.at_least(5)?;
        let valid = match self.text(6) {
            "A" | "D" => true,
            "V" | "" => false,
            _ => return Err(Unread::Malformed),
        };
        Ok(Content::Gll(Gll { fix: self.fix(5, 1, valid)? }))
    }

    fn vtg(&self) -> Result<Content, Unread> {
        self.at_least(2)?;
        // Before version 2 the units were not among the fields.
        let [speed, kmh] = if self.count > 5 { [5, 7] } else { [3, 4] };
        let kmh = self.speed(kmh)?.map(|kmh| kmh / 1.852);
        Ok(Content::Vtg(Vtg { course_deg: self.course(1)?, speed_knots: self.speed(speed)?.or(kmh) }))
    }

    fn hdt(&self) -> Result<Content, Unread> {
        self.at_least(2)?;
        let heading_deg = self.number(1, (f64::MIN, f64::MAX))?;
        // Out of range it is ignored.
        Ok(Content::Hdt(Hdt { heading_deg: heading_deg.filter(|heading| (0.0..=360.0).contains(heading)) }))
    }

    fn ths(&self) -> Result<Content, Unread> {
        self.at_least(3)?;
        let Content::Hdt(hdt) = self.hdt()? else { return Err(Unread::Malformed) };
        Ok(Content::Ths(Hdt { heading_deg: hdt.heading_deg.filter(|_| self.text(2) != "V") }))
    }

    fn zda(&self) -> Result<Content, Unread> {
        self.at_least(5)?;
        let date = [self.text(2), self.text(3), self.text(4)];
        let day = match date {
            ["", _, _] | [_, "", _] | [_, _, ""] => None,
            [day, month, year] if year.len() == 4 => {
                Some(day_of(digits(year), digits(month), digits(day)).ok_or(Unread::Malformed)?)
            }
            _ => return Err(Unread::Malformed),
        };
        Ok(Content::Zda(Zda { time_of_day_ns: self.time(1)?, day }))
    }

    fn gst(&self) -> Result<Content, Unread> {
        self.at_least(9)?;
        let sigma = |index| self.number(index, (0.0, 1e8));
        let sigma_m = match (sigma(6)?, sigma(7)?, sigma(8)?) {
            (Some(north), Some(east), Some(up)) => Some([north, east, up]),
            _ => None,
        };
        Ok(Content::Gst(Gst { time_of_day_ns: self.time(1)?, sigma_m }))
    }

    fn pashr(&self) -> Result<Content, Unread> {
        // Other sentences of that name begin with a word.
        if self.text(1).starts_with(|c: char| c.is_ascii_alphabetic()) {
            return Err(Unread::Unknown);
        }
        let need = |value: Option<f64>| value.ok_or(Unread::Malformed);
        let sigma = |index| self.number(index, (0.0, 1e3));
        let sigma_deg = match (sigma(7), sigma(8), sigma(9)) {
            (Ok(Some(roll)), Ok(Some(pitch)), Ok(Some(heading))) => Some([roll, pitch, heading]),
            _ => None,
        };
        Ok(Content::Pashr(Pashr {
            time_of_day_ns: self.time(1)?.ok_or(Unread::Malformed)?,
            heading_deg: need(self.course(2)?)?,
            roll_deg: need(self.number(4, (-180.0, 180.0))?)?,
            pitch_deg: need(self.number(5, (-90.0, 90.0))?)?,
            sigma_deg,
        }))
    }
}

/// Digits with at most one sign and one point; no exponents, no words.
pub(super) fn number(text: &str) -> Option<f64> {
    let plain = text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+'));
    text.parse().ok().filter(|value: &f64| plain && value.is_finite())
}

fn digits(text: &str) -> Option<i32> {
    text.parse().ok().filter(|_| text.bytes().all(|b| b.is_ascii_digit()))
}

/// `ddmm.mmm` or `dddmm.mmm`, as degrees; leading zeros of the degrees may be missing.
fn degrees(text: &str, most: usize) -> Option<f64> {
    let point = text.find('.').unwrap_or(text.len());
    // Fewer digits are decimal degrees of somebody who does not know the format.
    let (degrees, minutes) = text.split_at_checked(point.checked_sub(2)?)?;
    if !(1..=most).contains(&degrees.len()) {
        return None;
    }
    let degrees = f64::from(digits(degrees)?);
    let minutes = number(minutes).filter(|minutes| (0.0..60.0).contains(minutes))?;
    Some(degrees + minutes / 60.0)
}

/// `hhmmss.sss` as nanoseconds since midnight.
fn time_of_day_ns(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    if whole.len() != 6 || !whole.bytes().chain(fraction.bytes()).all(|b| b.is_ascii_digit()) {
        return None;
    }
    let pair = |at: usize| whole[at..at + 2].parse::<i64>().ok();
    let (hour, minute, second) = (pair(0)?, pair(2)?, pair(4)?);
    let is_leap = (hour, minute, second) == (23, 59, 60);
    if hour > 23 || minute > 59 || second > 59 && !is_leap {
        return None;
    }
    // Digits beyond the ninth round the ninth; a fraction that would round to a second stays below it.
    let mut ns = 0;
    let mut digit = fraction.bytes().map(|b| i64::from(b - b'0'));
    for _ in 0..9 {
        ns = 10 * ns + digit.next().unwrap_or(0);
    }
    ns = (ns + i64::from(digit.next().unwrap_or(0) >= 5)).min(999_999_999);
    Some(((hour * 60 + minute) * 60 + second) * 1_000_000_000 + ns)
}

/// `ddmmyy` as days since 1970-01-01; GPS time, where receivers without a fix begin, is of 1980.
fn short_date(text: &str) -> Option<i64> {
    if text.len() != 6 || !text.is_ascii() {
        return None;
    }
    let year = digits(&text[4..])?;
    day_of(Some(if year >= 80 { year + 1900 } else { year + 2000 }), digits(&text[2..4]), digits(&text[..2]))
}

/// Days since 1970-01-01, if there is such a day.
fn day_of(year: Option<i32>, month: Option<i32>, day: Option<i32>) -> Option<i64> {
    let (month, day) = (u8::try_from(month?).ok()?, u8::try_from(day?).ok()?);
    // The oldest year of a date with a meaning here.
    let year = year.filter(|year| *year >= 1900)?;
    let midnight = Epoch::maybe_from_gregorian_utc(year, month, day, 0, 0, 0, 0).ok()?;
    Some((midnight.to_unix_duration().to_seconds() / 86_400.0).round() as i64)
}
