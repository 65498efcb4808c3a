//! Exact emission times.
//!
//! Pulse `n` leaves at `t0 + n / PRF`, as an exact rational: the PRF is the f64 given, which is a
//! dyadic rational `m 2^e`, so `n / PRF = n 2^-e / m` is split by integer division into whole seconds
//! and a remainder that is rounded once (1.1e-16 s). Nothing is accumulated, so pulse 10^9 is as exact
//! as pulse 1. A PRI sequence is held in integer attoseconds.
//!
//! A [`TimeTag`] keeps whole seconds and the fraction apart: a single f64 of UTC seconds would round
//! to 2e-7 s.

use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

use hifitime::leap_seconds::LatestLeapSeconds;
use hifitime::{Epoch, Unit};
use thiserror::Error;

/// Seconds of a week of GPS time.
const WEEK_S: i64 = 604_800;
/// Weeks are reported in 13 bits by the newer satellites.
const MOST_GPS_WEEK: u32 = 8191;
/// 1980-01-06, in UTC seconds since 1970-01-01.
const GPS_START_S: i64 = 315_964_800;
/// 1900-01-01 to 1970-01-01, s.
const NTP_TO_UNIX_S: f64 = 2_208_988_800.0;
/// TAI minus GPS time, s.
const TAI_GPS_S: f64 = 19.0;
const ATTOSECONDS_PER_SECOND: u128 = 1_000_000_000_000_000_000;

/// An instant: UTC seconds since 1970-01-01 (POSIX, no leap seconds) and a fraction in [0, 1).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default)]
pub struct TimeTag {
    seconds: i64,
    fraction_s: f64,
}

/// Why a time cannot be read or a pulse schedule cannot be kept.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TimeError {
    /// Not an ISO 8601 UTC time.
    #[error("'{text}' is not an ISO 8601 UTC time such as 2018-05-30T20:15:00.5Z")]
    NotIso {
        /// What was written.
        text: String,
    },
    /// PRF outside the range in which the rational arithmetic is exact.
    #[error("PRF {prf_hz} Hz is not allowed: 0.001 to 1e9 Hz")]
    Prf {
        /// What was asked.
        prf_hz: f64,
    },
    /// A PRI sequence is empty or holds an interval out of range.
    #[error("PRI {pri_s} s (entry {index}) is not allowed: 1e-9 to 1000 s, at least one entry")]
    Pri {
        /// Position in the sequence.
        index: usize,
        /// What was asked.
        pri_s: f64,
    },
}

impl TimeTag {
    /// From whole seconds and any finite fraction (normalised).
    pub fn new(seconds: i64, fraction_s: f64) -> Self {
        let carry = fraction_s.floor();
        let mut tag = Self { seconds: seconds.saturating_add(carry as i64), fraction_s: fraction_s - carry };
        // -1e-17 floors to -1 and leaves a fraction that rounds to 1.
        if tag.fraction_s >= 1.0 {
            tag = Self { seconds: tag.seconds.saturating_add(1), fraction_s: 0.0 };
        }
        tag
    }

    /// What the clock of the machine shows.
    pub fn now() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self::new(i64::try_from(now.as_secs()).unwrap_or_default(), f64::from(now.subsec_nanos()) * 1e-9)
    }

    /// Reads an ISO 8601 UTC time (`2018-05-30T20:15:00.5Z`; the `Z` may be missing).
    ///
    /// # Errors
    /// A text that is no such time.
    pub fn from_iso8601(text: &str) -> Result<Self, TimeError> {
        let bad = || TimeError::NotIso { text: text.to_owned() };
        let text_utc = text.trim().trim_end_matches(['Z', 'z']);
        let whole = text_utc.split('.').next().unwrap_or(text_utc);
        let epoch = Epoch::from_gregorian_str(&format!("{whole} UTC")).map_err(|_| bad())?;
        let seconds = epoch.to_unix_seconds().round() as i64;
        let fraction_s = match text_utc.split_once('.') {
            None => 0.0,
            Some((_, digits)) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => {
                format!("0.{digits}").parse().map_err(|_| bad())?
            }
            Some(_) => return Err(bad()),
        };
        Ok(Self::new(seconds, fraction_s))
    }

    /// From a week of GPS time and seconds into it (which may run past the week). GPS time has no leap
    /// seconds: UTC is behind by those that were in force then (16 in 2014, 18 since 2017), which `hifitime`
    /// lists. `None` outside 0 to 8191 weeks or 0 to 1e8 s. A leap second itself has the label of the second
    /// after it.
    ///
    /// ```
    /// use nereus::time::TimeTag;
    /// let tag = TimeTag::from_gps(2000, 331_218.25).unwrap();
    /// assert_eq!(tag.to_string(), "2018-05-09T20:00:00.250000Z");
    /// assert_eq!(tag.to_gps(), Some((2000, 331_218.25)));
    /// ```
    pub fn from_gps(week: u32, seconds_of_week: f64) -> Option<Self> {
        if week > MOST_GPS_WEEK || !(0.0..=1e8).contains(&seconds_of_week) {
            return None;
        }
        let whole = seconds_of_week.floor();
        let gps_s = i64::from(week) * WEEK_S + whole as i64;
        // The last step of UTC that GPS time has passed.
        let behind_s = leaps().filter(|(from_s, leap_s)| gps_s + GPS_START_S - leap_s >= *from_s).last()?.1;
        Some(Self::new(gps_s + GPS_START_S - behind_s, seconds_of_week - whole))
    }

    /// Leap seconds between 1980-01-06 and this instant: by so many seconds GPS time is ahead of UTC.
    pub fn leap_seconds(self) -> i64 {
        leaps().filter(|(from_s, _)| self.seconds >= *from_s).last().map_or(0, |(_, leap_s)| leap_s)
    }

    /// Whether an instant of GPS time lies within a leap second, where [`Self::from_gps`] gives the label of
    /// the second after it.
    pub fn is_leap_second(week: u32, seconds_of_week: f64) -> bool {
        let gps_s = i64::from(week) * WEEK_S + seconds_of_week.floor() as i64;
        leaps().any(|(from_s, leap_s)| from_s > GPS_START_S && gps_s + GPS_START_S - (leap_s - 1) == from_s)
    }

    /// Week and second of the week of GPS time; `None` before 1980-01-06 and after week 8191.
    pub fn to_gps(self) -> Option<(u32, f64)> {
        let behind_s = leaps().filter(|(from_s, _)| self.seconds >= *from_s).last()?.1;
        let gps_s = self.seconds.checked_sub(GPS_START_S)?.checked_add(behind_s)?;
        let week = u32::try_from(gps_s.div_euclid(WEEK_S)).ok().filter(|week| *week <= MOST_GPS_WEEK)?;
        Some((week, gps_s.rem_euclid(WEEK_S) as f64 + self.fraction_s))
    }

    /// Whole UTC seconds since 1970-01-01.
    pub fn seconds(self) -> i64 {
        self.seconds
    }

    /// Fraction of the second, in [0, 1).
    pub fn fraction_s(self) -> f64 {
        self.fraction_s
    }

    /// `self - other` in seconds; the whole seconds are subtracted as integers.
    pub fn since(self, other: Self) -> f64 {
        (self.seconds - other.seconds) as f64 + (self.fraction_s - other.fraction_s)
    }

    /// `self + offset_s`.
    pub fn plus(self, offset_s: f64) -> Self {
        let whole = offset_s.floor();
        Self::new(self.seconds.saturating_add(whole as i64), self.fraction_s + (offset_s - whole))
    }

    /// UTC nanoseconds since 1970-01-01, floored, and the rest in [0, 1) ns.
    pub fn to_unix_ns(self) -> (i64, f64) {
        let ns = self.fraction_s * 1e9;
        let floor = ns.floor();
        (self.seconds.saturating_mul(1_000_000_000).saturating_add(floor as i64), ns - floor)
    }
}

impl fmt::Display for TimeTag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let micros = (self.fraction_s * 1e6).floor() as i64;
        let epoch = Epoch::from_unix_duration(self.seconds * Unit::Second);
        let (y, mo, d, h, mi, s, _) = epoch.to_gregorian_utc();
        write!(f, "{y:04}-{mo:02}-{d:02}T{h:02}:{mi:02}:{s:02}.{micros:06}Z")
    }
}

/// Since which UTC second GPS time is ahead by how many seconds, in order. The list is read here and not
/// through epochs of the crate, which take its UTC labels for TAI and so change over half a minute early.
fn leaps() -> impl Iterator<Item = (i64, i64)> {
    LatestLeapSeconds::default()
        .filter(|leap| leap.announced_by_iers && leap.delta_at >= TAI_GPS_S)
        .map(|leap| ((leap.timestamp_tai_s - NTP_TO_UNIX_S) as i64, (leap.delta_at - TAI_GPS_S) as i64))
}

/// When pulses leave, as offsets from pulse 0 of a radar: its own pulses, or those of an emitter that starts
/// sooner or later.
///
/// ```
/// use nereus::time::PulseTimes;
/// let late = PulseTimes::uniform(1000.0)?.starting(-2.25e-3);
/// assert!((late.elapsed_s(3) - 0.75e-3).abs() < 2e-16);
/// // Pulse 2 is the first after -1 ms.
/// assert!((late.not_before(-1e-3).elapsed_s(0) + 0.25e-3).abs() < 2e-16);
/// # Ok::<(), nereus::time::TimeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PulseTimes {
    rhythm: Rhythm,
    /// When the first of all leaves, attoseconds.
    start_as: i128,
    /// How many of these are left out.
    skipped: u64,
}

#[derive(Clone, Debug, PartialEq)]
enum Rhythm {
    /// `n * numerator / denominator` seconds.
    Uniform { prf_hz: f64, numerator: u128, denominator: u128 },
    /// Repeating intervals: `starts_as[i]` is the offset of the i-th pulse of a cycle.
    Sequence { starts_as: Vec<u128>, cycle_as: u128 },
}

impl PulseTimes {
    /// A constant PRF, Hz.
    ///
    /// # Errors
    /// A frequency outside 1 mHz to 1 GHz.
    pub fn uniform(prf_hz: f64) -> Result<Self, TimeError> {
        if !(prf_hz.is_finite() && (1e-3..=1e9).contains(&prf_hz)) {
            return Err(TimeError::Prf { prf_hz });
        }
        let (numerator, denominator) = period(prf_hz);
        Ok(Self::of(Rhythm::Uniform { prf_hz, numerator, denominator }))
    }

    /// Blocks of so many samples that follow each other without a gap, exactly.
    ///
    /// # Errors
    /// Blocks shorter than 1 ns or longer than 1000 s.
    pub fn blocks(samples: usize, sample_rate_hz: f64) -> Result<Self, TimeError> {
        let prf_hz = sample_rate_hz / samples as f64;
        Self::uniform(prf_hz)?;
        let (numerator, denominator) = period(sample_rate_hz);
        let numerator = numerator * samples as u128;
        Ok(Self::of(Rhythm::Uniform { prf_hz, numerator, denominator }))
    }

    /// A repeating sequence of pulse repetition intervals, seconds; each is rounded once to an
    /// integer number of attoseconds, which then *is* the interval.
    ///
    /// # Errors
    /// No interval, or one outside 1 ns to 1000 s.
    pub fn sequence(pri_s: &[f64]) -> Result<Self, TimeError> {
        if pri_s.is_empty() {
            return Err(TimeError::Pri { index: 0, pri_s: f64::NAN });
        }
        let mut starts_as = Vec::with_capacity(pri_s.len());
        let mut cycle_as = 0u128;
        for (index, &pri) in pri_s.iter().enumerate() {
            if !(pri.is_finite() && (1e-9..=1e3).contains(&pri)) {
                return Err(TimeError::Pri { index, pri_s: pri });
            }
            starts_as.push(cycle_as);
            cycle_as += (pri * 1e18).round() as u128;
        }
        Ok(Self::of(Rhythm::Sequence { starts_as, cycle_as }))
    }

    fn of(rhythm: Rhythm) -> Self {
        Self { rhythm, start_as: 0, skipped: 0 }
    }

    /// The same, of which the first pulse leaves so long after the radar's pulse 0, s: rounded once to an
    /// integer number of attoseconds, which then *is* the start.
    #[must_use]
    pub fn starting(self, start_s: f64) -> Self {
        Self { start_as: (start_s * 1e18).round() as i128, ..self }
    }

    /// When the first of all leaves, s after the radar's pulse 0.
    pub fn start_s(&self) -> f64 {
        self.start_as as f64 * 1e-18
    }

    /// The same without pulses that leave earlier than so long after the radar's pulse 0, s.
    #[must_use]
    pub fn not_before(mut self, earliest_s: f64) -> Self {
        let early_s = earliest_s - self.elapsed_s(0);
        if early_s > 0.0 {
            self.skipped += self.count_until(early_s);
        }
        self
    }

    /// The number of pulse `n` among all, those that are left out included.
    pub fn number(&self, n: u64) -> u64 {
        n.saturating_add(self.skipped)
    }

    /// Offset of pulse `n` from the first of all: whole seconds and a fraction in [0, 1].
    fn offset(&self, n: u64) -> (i64, f64) {
        match &self.rhythm {
            Rhythm::Uniform { numerator, denominator, .. } => {
                let total = u128::from(n) * numerator;
                let rest = total % denominator;
                ((total / denominator) as i64, rest as f64 / *denominator as f64)
            }
            Rhythm::Sequence { starts_as, cycle_as } => {
                let len = starts_as.len() as u64;
                let total = u128::from(n / len) * cycle_as + starts_as[(n % len) as usize];
                let rest = total % ATTOSECONDS_PER_SECOND;
                ((total / ATTOSECONDS_PER_SECOND) as i64, rest as f64 * 1e-18)
            }
        }
    }

    /// Emission time of pulse `n` when pulse 0 leaves at `start`.
    pub fn emission(&self, start: TimeTag, n: u64) -> TimeTag {
        let (seconds, fraction_s) = self.offset(n.saturating_add(self.skipped));
        let whole_as = ATTOSECONDS_PER_SECOND as i128;
        let (late, late_s) =
            (self.start_as.div_euclid(whole_as), self.start_as.rem_euclid(whole_as) as f64 * 1e-18);
        let seconds = start.seconds.saturating_add(seconds).saturating_add(late as i64);
        TimeTag::new(seconds, start.fraction_s + (fraction_s + late_s))
    }

    /// When pulse `n` leaves, s after pulse 0 of the radar.
    pub fn elapsed_s(&self, n: u64) -> f64 {
        self.emission(TimeTag::default(), n).since(TimeTag::default())
    }

    /// `t_b - t_a`, seconds, exact to one rounding for neighbouring pulses.
    pub fn interval_s(&self, a: u64, b: u64) -> f64 {
        let zero = TimeTag::default();
        self.emission(zero, b).since(self.emission(zero, a))
    }

    /// Whether all intervals are equal.
    pub fn is_uniform(&self) -> bool {
        matches!(self.rhythm, Rhythm::Uniform { .. })
    }

    /// The intervals of a sequence, seconds; none where all are equal.
    pub fn intervals_s(&self) -> Vec<f64> {
        match &self.rhythm {
            Rhythm::Uniform { .. } => Vec::new(),
            Rhythm::Sequence { starts_as, cycle_as } => {
                let ends_as = starts_as.iter().skip(1).chain(std::iter::once(cycle_as));
                starts_as.iter().zip(ends_as).map(|(a, b)| (b - a) as f64 * 1e-18).collect()
            }
        }
    }

    /// The mean PRF, Hz.
    pub fn mean_prf_hz(&self) -> f64 {
        match &self.rhythm {
            Rhythm::Uniform { prf_hz, .. } => *prf_hz,
            Rhythm::Sequence { starts_as, cycle_as } => starts_as.len() as f64 / (*cycle_as as f64 * 1e-18),
        }
    }

    /// The mean interval between two pulses, seconds: that of pulses 0 and 1 where all are equal.
    pub fn mean_pri_s(&self) -> f64 {
        match &self.rhythm {
            Rhythm::Uniform { .. } => {
                let (seconds, fraction_s) = self.offset(1);
                seconds as f64 + fraction_s
            }
            Rhythm::Sequence { starts_as, cycle_as } => *cycle_as as f64 * 1e-18 / starts_as.len() as f64,
        }
    }

    /// The shortest interval between two pulses, seconds.
    pub fn shortest_pri_s(&self) -> f64 {
        match &self.rhythm {
            Rhythm::Uniform { prf_hz, .. } => prf_hz.recip(),
            Rhythm::Sequence { .. } => self.intervals_s().into_iter().fold(f64::INFINITY, f64::min),
        }
    }

    /// Number of pulses that leave before `duration_s` after pulse 0 of the radar.
    pub fn count_within(&self, duration_s: f64) -> u64 {
        self.count_until(duration_s - self.elapsed_s(0))
    }

    /// Number of pulses that leave less than `duration_s` after the first.
    fn count_until(&self, duration_s: f64) -> u64 {
        if !(duration_s.is_finite() && duration_s > 0.0) {
            return 0;
        }
        let mut n = (duration_s * self.mean_prf_hz()).ceil().max(1.0) as u64;
        while n > 1 && self.interval_s(0, n - 1) >= duration_s {
            n -= 1;
        }
        while self.interval_s(0, n) < duration_s {
            n += 1;
        }
        n
    }
}

/// Numerator and denominator of `1 / hz`, s, exactly.
fn period(hz: f64) -> (u128, u128) {
    // hz = mantissa 2^exponent.
    let bits = hz.to_bits();
    let mut exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
    let mut mantissa = u128::from((bits & ((1 << 52) - 1)) | (1 << 52));
    let zeros = mantissa.trailing_zeros();
    mantissa >>= zeros;
    exponent += zeros as i32;
    if exponent >= 0 { (1, mantissa << exponent) } else { (1u128 << -exponent, mantissa) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_billion_pulses_do_not_drift() {
        let times = PulseTimes::uniform(222.0).unwrap();
        let zero = TimeTag::default();
        let tag = times.emission(zero, 1_000_000_000);
        // 10^9 / 222 = 4504504 + 112/222 exactly.
        assert_eq!(tag.seconds(), 4_504_504);
        assert!((tag.fraction_s() - 112.0 / 222.0).abs() <= f64::EPSILON);
        for prf_hz in [0.001, 1.0 / 3.0, 333.3, 1000.0, 99_999.999, 1e9] {
            let times = PulseTimes::uniform(prf_hz).unwrap();
            let pri = times.interval_s(1_000_000_000, 1_000_000_001);
            assert!((pri * prf_hz - 1.0).abs() <= 4e-16 * prf_hz.max(1.0), "{prf_hz}: {pri}");
        }
    }

    #[test]
    fn blocks_follow_each_other_exactly() {
        let (zero, times) = (TimeTag::default(), PulseTimes::blocks(768, 40e6 / 3.0).unwrap());
        let samples = PulseTimes::uniform(40e6 / 3.0).unwrap();
        for n in [0, 1, 7, 1_000_003, 10_000_000_000] {
            assert_eq!(times.emission(zero, n), samples.emission(zero, 768 * n));
        }
        assert!((times.mean_prf_hz() * times.mean_pri_s() - 1.0).abs() < 1e-15);
        assert!(PulseTimes::blocks(0, 1e6).is_err() && PulseTimes::blocks(1 << 24, 1e3).is_err());
    }

    #[test]
    fn a_pri_sequence_repeats_exactly() {
        let times = PulseTimes::sequence(&[4.0e-3, 5.0e-3, 4.5e-3]).unwrap();
        let zero = TimeTag::default();
        let tag = times.emission(zero, 3_000_000_001);
        assert_eq!(tag.seconds(), 13_500_000);
        assert!((tag.fraction_s() - 4.0e-3).abs() < 1e-17);
        assert!((times.shortest_pri_s() - 4.0e-3).abs() < 1e-17);
        assert_eq!(times.count_within(13.5e-3), 3);
        assert_eq!(times.count_within(13.6e-3), 4);
    }

    #[test]
    fn a_start_is_kept_exactly() {
        for times in [PulseTimes::uniform(222.0).unwrap(), PulseTimes::sequence(&[1.0 / 222.0]).unwrap()] {
            let late = times.clone().starting(-0.375);
            for n in [0, 1, 83, 84, 1_000_000_000] {
                let off_s = late.elapsed_s(n) + 0.375 - times.elapsed_s(n);
                assert!(off_s.abs() <= 4.0 * f64::EPSILON * times.elapsed_s(n).max(1.0), "{n}: {off_s}");
            }
            // 0.375 s are 83.25 intervals.
            assert_eq!((late.count_within(0.0), late.count_within(1e-3)), (84, 84));
            let cut = late.clone().not_before(-1.5 / 222.0);
            assert!((cut.elapsed_s(0) + 1.25 / 222.0).abs() < 1e-15 && cut.start_s() == -0.375);
            assert_eq!(cut.elapsed_s(1), late.elapsed_s(83));
            assert_eq!(times.clone().starting(2.0).count_within(1.5), 0);
            assert_eq!((times.clone().starting(0.0), times.clone().not_before(-5.0)), (times.clone(), times));
        }
    }

    #[test]
    fn iso_times_and_nanoseconds() {
        let tag = TimeTag::from_iso8601("2018-05-30T20:15:00.123456789Z").unwrap();
        assert_eq!(tag.seconds(), 1_527_711_300);
        assert_eq!(tag.to_unix_ns().0, 1_527_711_300_123_456_789);
        assert_eq!(tag.to_string(), "2018-05-30T20:15:00.123456Z");
        // Past 2^62 ns, where a count of nanoseconds in f64 is no longer exact.
        assert_eq!(TimeTag::new(253_402_300_799, 0.5).to_string(), "9999-12-31T23:59:59.500000Z");
        assert!(TimeTag::from_iso8601("yesterday").is_err());
        assert!(TimeTag::from_iso8601("2018-05-30T20:15:00.Z").is_err());
    }

    #[test]
    fn odd_schedules_are_refused() {
        assert!(PulseTimes::uniform(-222.0).is_err());
        assert!(PulseTimes::uniform(f64::NAN).is_err());
        assert!(PulseTimes::sequence(&[]).is_err());
        assert!(PulseTimes::sequence(&[1e-3, -1.0]).is_err());
    }
}
