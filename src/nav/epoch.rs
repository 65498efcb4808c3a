//! Messages of one instant, in any order, become one epoch.
//!
//! GGA, GNS, RMC, GLL, ZDA, GST and PASHR bear a time of day; all with the same one belong together. VTG, HDT
//! and THS have no time. A stream that begins with one of them sends them before the sentences with a time
//! (unless it begins within a sentence): each belongs to the epoch that opens next. Otherwise they belong to
//! the epoch that is open when they come. A message with another time closes the open epoch. INSPVAX, INSPVA
//! and INSPVAS are complete by themselves: each completes its epoch at once, and sentences that follow with
//! the same time are left.
//!
//! * **Position**: INSPVAX before GGA before GNS before RMC before GLL; of two talkers that send the same,
//!   the one with a height, else the first. **Attitude**: INSPVAX, PASHR, HDT or THS (pitch and roll zero).
//! * **Talker.** Positions of one talker are used throughout: those of others are left and counted until it
//!   has been silent for 10 s. All satellite systems (GP, GN, GL, ...) are one talker. A second sentence of a
//!   kind with the same time and another place is left and counted: a clock of whole seconds, or two
//!   receivers.
//! * **Height**: altitude above mean sea level, and the separation of the ellipsoid where the message gives
//!   one. One talker's is not taken away by another that has none.
//! * **Velocity**: INSPVAX; else speed and course of VTG or RMC (`v_E = v sin(course)`,
//!   `v_N = v cos(course)`), no climb.
//! * **Date** of RMC, ZDA or INSPVAX; an epoch without one takes that of the epoch before: where the time of
//!   day falls by more than half a day, midnight has passed. Before the first date there is none. Within a
//!   minute of midnight, or of the end of a GPS week, a date that changes late or early is that of the epoch
//!   before, and counted. With a date of the source ([`Assembler::dated`]) those of the messages are not
//!   used.
//! * **Leap seconds.** Time is counted on from day to day: behind a leap second it is one second ahead of
//!   UTC, so that the motion goes on steadily.
//! * A GST of an earlier time than the open epoch is left.
//!
//! ```
//! use nereus::nav::decode::Decoder;
//! use nereus::nav::epoch::Assembler;
//!
//! let (mut decoder, mut assembler) = (Decoder::new(), Assembler::new());
//! let mut epochs = Vec::new();
//! decoder.push(
//!     b"$GPRMC,195719,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*10\r\n\
//!       $GPGGA,195719,5310.8115,N,00525.7025,E,8,10,0.9,-2.0,M,43.0,M,,*61\r\n",
//!     &mut |message| assembler.push(&message, &mut |epoch| epochs.push(epoch)),
//! );
//! epochs.extend(assembler.finish());
//! assert_eq!(epochs.len(), 1);
//! assert_eq!(epochs[0].time().unwrap().to_string(), "2014-04-16T19:57:19.000000Z");
//! assert_eq!(epochs[0].altitude_m, Some(-2.0));
//! ```

use super::decode::nmea::Fixed;
use super::decode::{Content, Inspvax, Message};
use super::{Fix, Place, Sigma, VerticalDatum};
use crate::frames::Geodetic;
use crate::time::TimeTag;
use crate::units::KNOT_MPS;

const DAY_S: i64 = 86_400;
const SECOND_NS: i64 = 1_000_000_000;
pub(super) const DAY_NS: i64 = DAY_S * SECOND_NS;

/// Ranks of positions.
const GLL: u8 = 1;
const RMC: u8 = 2;
const GNS: u8 = 3;
const GGA: u8 = 4;
const INSPVAX: u8 = 5;
/// Talker of which no other positions are used is given up after so long.
const SILENT_NS: i64 = 10 * SECOND_NS;
/// Within so much of midnight or of the end of a week a date may change late or early.
const NEAR_NS: i64 = 60 * SECOND_NS;
const WEEK_S: f64 = 604_800.0;

/// Everything that was reported of one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Epoch {
    /// Line of its first message.
    pub line: u64,
    /// UTC since midnight, ns; 86,400 s and more within a leap second.
    pub time_of_day_ns: i64,
    /// Days since 1970-01-01, if known.
    pub day: Option<i64>,
    /// Leap seconds between the first date of the stream and this one.
    pub leap_s: i64,
    /// Latitude and longitude, degrees.
    pub position_deg: Option<[f64; 2]>,
    /// Height, m: above mean sea level, or what the source takes it for.
    pub altitude_m: Option<f64>,
    /// What is added to it for a height above the ellipsoid, m, if the message states it.
    pub separation_m: Option<f64>,
    /// Velocity East and North, m/s.
    pub velocity_mps: Option<[f64; 2]>,
    /// Velocity upward, m/s.
    pub climb_mps: Option<f64>,
    /// Yaw (clockwise from North), pitch, roll, radians.
    pub yaw_pitch_roll_rad: Option<[f64; 3]>,
    /// What was reported of the accuracy.
    pub sigma: Sigma,
    /// Of which message the position is; 0: none.
    rank: u8,
    /// Whether the height is that of the message of the position.
    own_height: bool,
    /// Kinds of positions that have come, bits of their ranks.
    seen: u8,
}

impl Epoch {
    /// When, if there is a date.
    pub fn time(&self) -> Option<TimeTag> {
        let (seconds, rest_ns) = (self.time_of_day_ns / SECOND_NS, self.time_of_day_ns % SECOND_NS);
        Some(TimeTag::new(self.day? * DAY_S + seconds + self.leap_s, rest_ns as f64 * 1e-9))
    }

    /// Height above the ellipsoid, m; where the message gives no separation, the datum decides, and
    /// `undulation_m` is that of mean sea level above the ellipsoid.
    pub fn height_m(&self, datum: VerticalDatum, undulation_m: f64) -> Option<f64> {
        let altitude_m = self.altitude_m?;
        Some(match (self.separation_m, datum) {
            (Some(separation_m), _) => altitude_m + separation_m,
            (None, VerticalDatum::Ellipsoid) => altitude_m,
            (None, VerticalDatum::MeanSeaLevel) => altitude_m + undulation_m,
            (None, VerticalDatum::Barometric { offset_m }) => altitude_m + offset_m + undulation_m,
        })
    }

    /// As a fix, if it has a date, a position and a height.
    pub fn fix(&self, datum: VerticalDatum, undulation_m: f64) -> Option<Fix> {
        let [lat_deg, lon_deg] = self.position_deg?;
        let height_m = self.height_m(datum, undulation_m)?;
        Some(Fix {
            time: self.time()?,
            place: Place::Geodetic(Geodetic::from_deg(lat_deg, lon_deg, height_m)),
            yaw_pitch_roll_rad: self.yaw_pitch_roll_rad,
            velocity_mps: self.velocity_mps,
            climb_mps: self.climb_mps,
            sigma: self.sigma,
        })
    }

    fn inspvax(&mut self, message: &Inspvax, deviations: bool) {
        self.rank = INSPVAX;
        self.position_deg = Some([message.lat_deg, message.lon_deg]);
        self.altitude_m = Some(message.altitude_m);
        self.separation_m = Some(message.undulation_m);
        let [north, east, up] = message.velocity_mps;
        self.velocity_mps = Some([east, north]);
        self.climb_mps = Some(up);
        let [roll, pitch, azimuth] = message.angles_deg;
        self.yaw_pitch_roll_rad = Some([azimuth, pitch, roll].map(f64::to_radians));
        if !deviations {
            return;
        }
        let [lat, lon, height] = message.sigma_position_m;
        let [north, east, up] = message.sigma_velocity_mps;
        let [roll, pitch, azimuth] = message.sigma_angles_deg;
        self.sigma = Sigma {
            position_m: Some([lon, lat, height]),
            velocity_mps: Some([east, north, up]),
            angles_rad: Some([azimuth, pitch, roll].map(f32::to_radians)),
        };
    }
}

/// What was left, and what was set right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssemblyCounts {
    /// Positions of another talker.
    pub other_talkers: u64,
    /// Positions with the time of one before, elsewhere.
    pub repeated: u64,
    /// Dates that changed late or early at midnight or at the end of a GPS week.
    pub dates_corrected: u64,
    /// Headings and velocities that belong to the position after them.
    pub ahead: u64,
    /// Epochs behind a leap second.
    pub behind_leap: u64,
}

/// What comes without a time.
#[derive(Clone, Copy, Debug, Default)]
struct Untimed {
    heading_deg: Option<f64>,
    velocity_mps: Option<[f64; 2]>,
}

/// A sentence with a position.
#[derive(Clone, Copy)]
struct Located {
    fix: Option<Fixed>,
    rank: u8,
    /// Altitude, and separation of the ellipsoid.
    height_m: Option<(f64, Option<f64>)>,
}

/// Joins messages to epochs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Assembler {
    open: Option<Epoch>,
    /// Day and time of day of the epoch closed last that has a date.
    before: Option<(i64, i64)>,
    /// Time of day of an epoch that INSPVAX has completed.
    complete: Option<i64>,
    /// The date of the first epoch, where the source gives it.
    first_day: Option<i64>,
    /// Whether what has no time comes before the sentences of its epoch; `None`: not known yet.
    leads: Option<bool>,
    untimed: Untimed,
    /// Whose positions are used, and when the last one came.
    talker: Option<([u8; 2], i64)>,
    /// Whether midnight has passed and the date has not changed.
    lags: bool,
    /// Leap seconds from which time is counted on, and the day of the last epoch.
    leap: Option<(i64, i64)>,
    counts: AssemblyCounts,
}

/// The talker of a sentence; those of satellite systems are one.
fn group(talker: Option<[u8; 2]>) -> [u8; 2] {
    match talker {
        Some([b'G', _] | [b'B', b'D'] | [b'Q', b'Z']) | None => *b"GN",
        Some(other) => other,
    }
}

impl Assembler {
    /// An assembler that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same for a stream whose first epoch is of a day (since 1970-01-01), whatever its messages say.
    pub fn dated(first_day: Option<i64>) -> Self {
        Self { first_day, ..Self::default() }
    }

    /// What was left and set right so far.
    pub fn counts(&self) -> AssemblyCounts {
        self.counts
    }

    /// Takes a message and calls with every epoch that it closes, two at most.
    pub fn push(&mut self, message: &Message, see: &mut dyn FnMut(Epoch)) {
        let line = message.line;
        match &message.content {
            Content::Gga(gga) | Content::Gns(gga) => {
                let rank = if matches!(message.content, Content::Gga(_)) { GGA } else { GNS };
                let height_m = gga.altitude_m.map(|altitude_m| (altitude_m, gga.separation_m));
                self.located(Located { fix: gga.fix, rank, height_m }, message, see);
            }
            Content::Rmc(rmc) => {
                let located = Located { fix: rmc.fix, rank: RMC, height_m: None };
                let velocity_mps = ground(rmc.speed_knots, rmc.course_deg);
                if let Some(epoch) = self.located(located, message, see) {
                    epoch.day = rmc.day.or(epoch.day);
                    epoch.velocity_mps = velocity_mps.or(epoch.velocity_mps);
                } else if let (Some(fix), Some(epoch)) = (rmc.fix, &mut self.open)
                    && fix.time_of_day_ns == epoch.time_of_day_ns
                {
                    // Another talker's date is as good where there is none.
                    epoch.day = epoch.day.or(rmc.day);
                }
            }
            Content::Gll(gll) => {
                self.located(Located { fix: gll.fix, rank: GLL, height_m: None }, message, see);
            }
            Content::Vtg(vtg) => {
                let velocity_mps = ground(vtg.speed_knots, vtg.course_deg);
                self.take_untimed(Untimed { velocity_mps, heading_deg: None }, message);
            }
            Content::Hdt(hdt) | Content::Ths(hdt) => {
                self.take_untimed(Untimed { heading_deg: hdt.heading_deg, velocity_mps: None }, message);
            }
            Content::Zda(zda) => {
                if let (Some(time), Some(day)) = (zda.time_of_day_ns, zda.day)
                    && let Some(epoch) = self.epoch(time, line, see)
                {
                    epoch.day = Some(day);
                }
            }
            Content::Gst(gst) => {
                let Some(time) = gst.time_of_day_ns.filter(|time| !self.is_past(*time)) else { return };
                if let Some(epoch) = self.epoch(time, line, see) {
                    let sigma = gst.sigma_m.map(|[north, east, up]| [east, north, up].map(|m| m as f32));
                    epoch.sigma.position_m = sigma.or(epoch.sigma.position_m);
                }
            }
            Content::Pashr(pashr) => {
                if let Some(epoch) = self.epoch(pashr.time_of_day_ns, line, see) {
                    let angles = [pashr.heading_deg, pashr.pitch_deg, pashr.roll_deg];
                    epoch.yaw_pitch_roll_rad = Some(angles.map(f64::to_radians));
                    let single = |deg: f64| deg.to_radians() as f32;
                    let sigma = pashr.sigma_deg.map(|[roll, pitch, yaw]| [yaw, pitch, roll].map(single));
                    epoch.sigma.angles_rad = sigma.or(epoch.sigma.angles_rad);
                }
            }
            Content::Inspvax(inspvax) => self.complete(inspvax, true, line, see),
            Content::Inspva(inspva) => self.complete(inspva, false, line, see),
        }
    }

    /// Closes the epoch that is open: the stream has ended, or nothing more is expected of its instant.
    pub fn finish(&mut self) -> Option<Epoch> {
        let mut epoch = self.open.take()?;
        epoch.day = self.day(&epoch);
        if let Some(day) = epoch.day {
            let leap_s = TimeTag::new(day * DAY_S, 0.0).leap_seconds();
            // Counted on from day to day alone: what lies years before was no time.
            let (from_s, last_day) = self.leap.unwrap_or((leap_s, day));
            let from_s = if (day - last_day).abs() > 1 { leap_s } else { from_s };
            self.leap = Some((from_s, day));
            epoch.leap_s = leap_s - from_s;
            self.counts.behind_leap += u64::from(epoch.leap_s != 0);
            self.before = Some((day, epoch.time_of_day_ns));
        }
        Some(epoch)
    }

    /// The day of an epoch: its own, unless the one before it says that it changed late or early.
    fn day(&mut self, epoch: &Epoch) -> Option<i64> {
        let stated = if self.first_day.is_some() { None } else { epoch.day };
        let Some((day, before_ns)) = self.before else { return stated.or(self.first_day) };
        let step = epoch.time_of_day_ns - before_ns;
        // A talker that lags may fall back over midnight.
        let days = i64::from(step < -DAY_NS / 2) - i64::from(step > DAY_NS / 2);
        let expected = day + days;
        let Some(stated) = stated else { return Some(expected) };
        let follows = (0..=NEAR_NS).contains(&(step + days * DAY_NS));
        let is_late = stated == expected - 1 && (days == 1 || self.lags) && epoch.time_of_day_ns < NEAR_NS;
        let is_early = stated == expected + 1 && epoch.time_of_day_ns >= DAY_NS - NEAR_NS;
        self.lags = follows && is_late;
        if follows && (is_late || is_early) {
            self.counts.dates_corrected += 1;
            return Some(expected);
        }
        Some(stated)
    }

    /// What has no time belongs to the epoch that is open, or to the next one.
    fn take_untimed(&mut self, untimed: Untimed, message: &Message) {
        match (self.leads, &mut self.open) {
            (None, _) if message.begun_within => {}
            (None | Some(true), _) => {
                self.untimed.heading_deg = untimed.heading_deg.or(self.untimed.heading_deg);
                self.untimed.velocity_mps = untimed.velocity_mps.or(self.untimed.velocity_mps);
            }
            (_, Some(epoch)) => untimed.give(epoch),
            (_, None) => {}
        }
    }

    /// Takes a position, unless that of another message or talker stands for its epoch.
    fn located(
        &mut self,
        Located { fix, rank, height_m }: Located,
        message: &Message,
        see: &mut dyn FnMut(Epoch),
    ) -> Option<&mut Epoch> {
        let fix = fix?;
        let talker = group(message.talker);
        let before = self.talker;
        self.epoch(fix.time_of_day_ns, message.line, see)?;
        let (epoch, counts) = (self.open.as_mut()?, &mut self.counts);
        let is_silent = |since_ns: i64| (fix.time_of_day_ns - since_ns).rem_euclid(DAY_NS) > SILENT_NS;
        let place = [fix.lat_deg, fix.lon_deg];
        let own_height = height_m.is_some();
        match before {
            // It was the first, and this one has what it lacks: a height of the same kind of message.
            Some((used, since_ns)) if used != talker && !is_silent(since_ns) => {
                let is_better = own_height && !epoch.own_height && epoch.rank == rank;
                if !(is_better && self.before.is_none()) {
                    counts.other_talkers += 1;
                    if let (Some((altitude_m, separation_m)), None) = (height_m, epoch.altitude_m) {
                        (epoch.altitude_m, epoch.separation_m) = (Some(altitude_m), separation_m);
                    }
                    return None;
                }
                (epoch.rank, epoch.seen) = (0, 0);
            }
            Some((used, _)) if used == talker && epoch.seen & 1 << rank != 0 => {
                counts.repeated += u64::from(epoch.rank == rank && epoch.position_deg != Some(place));
                return None;
            }
            _ => {}
        }
        self.talker = Some((talker, fix.time_of_day_ns));
        epoch.seen |= 1 << rank;
        if epoch.rank < rank {
            (epoch.rank, epoch.position_deg) = (rank, Some(place));
            if let Some((altitude_m, separation_m)) = height_m {
                (epoch.altitude_m, epoch.separation_m) = (Some(altitude_m), separation_m);
                epoch.own_height = true;
            }
        } else if let (Some((altitude_m, separation_m)), None) = (height_m, epoch.altitude_m) {
            (epoch.altitude_m, epoch.separation_m) = (Some(altitude_m), separation_m);
        }
        Some(epoch)
    }

    /// The open epoch of this time of day; another one is closed first. `None` if INSPVAX has completed it.
    fn epoch(&mut self, time_of_day_ns: i64, line: u64, see: &mut dyn FnMut(Epoch)) -> Option<&mut Epoch> {
        if self.complete == Some(time_of_day_ns) {
            return None;
        }
        self.complete = None;
        if self.open.is_some_and(|epoch| epoch.time_of_day_ns != time_of_day_ns) {
            self.finish().into_iter().for_each(see);
        }
        if self.open.is_none() {
            let mut epoch = Epoch { line, time_of_day_ns, ..Epoch::default() };
            let untimed = std::mem::take(&mut self.untimed);
            let is_there = untimed.heading_deg.is_some() || untimed.velocity_mps.is_some();
            if *self.leads.get_or_insert(is_there) {
                self.counts.ahead += u64::from(is_there);
                untimed.give(&mut epoch);
            }
            self.open = Some(epoch);
        }
        self.open.as_mut()
    }

    fn complete(&mut self, message: &Inspvax, deviations: bool, line: u64, see: &mut dyn FnMut(Epoch)) {
        let Some(time) = message.time().filter(|_| message.is_solution()) else { return };
        // To the nanosecond, as sentences have it.
        let ns = (time.fraction_s() * 1e9).round() as i64;
        let (mut day, mut time_of_day_ns) =
            (time.seconds().div_euclid(DAY_S), time.seconds().rem_euclid(DAY_S) * SECOND_NS + ns);
        if TimeTag::is_leap_second(message.week, message.seconds) {
            (day, time_of_day_ns) = (day - 1, time_of_day_ns + DAY_NS);
        }
        // The week may change after the seconds of the week have begun again.
        if let Some((before_day, before_ns)) = self.before
            && message.seconds * 1e9 < NEAR_NS as f64
        {
            let late = day + (WEEK_S as i64) / DAY_S;
            let step_ns = (late - before_day) * DAY_NS + time_of_day_ns - before_ns;
            if (0..=NEAR_NS).contains(&step_ns) {
                self.counts.dates_corrected += 1;
                day = late;
            }
        }
        let Some(epoch) = self.epoch(time_of_day_ns, line, see) else { return };
        epoch.day = Some(day);
        epoch.inspvax(message, deviations);
        self.finish().into_iter().for_each(see);
        self.complete = Some(time_of_day_ns);
    }

    /// Whether a time of day is before the open epoch, midnight in between left aside.
    fn is_past(&self, time_of_day_ns: i64) -> bool {
        self.open.is_some_and(|epoch| {
            let step = (time_of_day_ns - epoch.time_of_day_ns + DAY_NS / 2).rem_euclid(DAY_NS) - DAY_NS / 2;
            step < 0
        })
    }
}

impl Untimed {
    fn give(self, epoch: &mut Epoch) {
        epoch.velocity_mps = self.velocity_mps.or(epoch.velocity_mps);
        if let Some(heading_deg) = self.heading_deg {
            epoch.yaw_pitch_roll_rad.get_or_insert([heading_deg.to_radians(), 0.0, 0.0]);
        }
    }
}

/// Velocity East and North from speed and course; a ship that lies still may leave the course empty.
fn ground(speed_knots: Option<f64>, course_deg: Option<f64>) -> Option<[f64; 2]> {
    let speed_mps = speed_knots? * KNOT_MPS;
    let course_rad = match course_deg {
        Some(course_deg) => course_deg.to_radians(),
        None if speed_mps == 0.0 => 0.0,
        None => return None,
    };
    Some([speed_mps * course_rad.sin(), speed_mps * course_rad.cos()])
}
