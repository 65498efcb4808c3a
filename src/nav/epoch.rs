//! Messages of one instant, in any order, become one epoch.
//!
//! GGA, RMC, GLL, ZDA, GST and PASHR bear a time of day; all with the same one belong together. VTG and HDT
//! have no time and belong to the epoch that is open when they come. A message with another time closes the
//! open epoch. INSPVAX is complete by itself: it completes its epoch at once, and sentences that follow with
//! the same time are left.
//!
//! * **Position**: INSPVAX before GGA before RMC before GLL. **Attitude**: INSPVAX, PASHR, HDT (pitch and
//!   roll zero).
//! * **Height**: altitude above mean sea level, and the separation of the ellipsoid where the message gives
//!   one.
//! * **Velocity**: INSPVAX; else speed and course of VTG or RMC (`v_E = v sin(course)`,
//!   `v_N = v cos(course)`), no climb.
//! * **Date** of RMC, ZDA or INSPVAX; an epoch without one takes that of the epoch before: where the time of
//!   day falls by more than half a day, midnight has passed. Before the first date there is none.
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
const GGA: u8 = 3;
const INSPVAX: u8 = 4;

/// Everything that was reported of one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Epoch {
    /// Line of its first message.
    pub line: u64,
    /// UTC since midnight, ns.
    pub time_of_day_ns: i64,
    /// Days since 1970-01-01, if known.
    pub day: Option<i64>,
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
}

impl Epoch {
    /// When, if there is a date.
    pub fn time(&self) -> Option<TimeTag> {
        let (seconds, rest_ns) = (self.time_of_day_ns / SECOND_NS, self.time_of_day_ns % SECOND_NS);
        Some(TimeTag::new(self.day? * DAY_S + seconds, rest_ns as f64 * 1e-9))
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

    fn locate(&mut self, lat_deg: f64, lon_deg: f64, rank: u8) {
        if self.rank < rank {
            self.rank = rank;
            self.position_deg = Some([lat_deg, lon_deg]);
        }
    }

    fn inspvax(&mut self, message: &Inspvax) {
        self.locate(message.lat_deg, message.lon_deg, INSPVAX);
        self.altitude_m = Some(message.altitude_m);
        self.separation_m = Some(message.undulation_m);
        let [north, east, up] = message.velocity_mps;
        self.velocity_mps = Some([east, north]);
        self.climb_mps = Some(up);
        let [roll, pitch, azimuth] = message.angles_deg;
        self.yaw_pitch_roll_rad = Some([azimuth, pitch, roll].map(f64::to_radians));
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

/// Joins messages to epochs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Assembler {
    open: Option<Epoch>,
    /// Day and time of day of the epoch closed last that has a date.
    before: Option<(i64, i64)>,
    /// Time of day of an epoch that INSPVAX has completed.
    complete: Option<i64>,
}

impl Assembler {
    /// An assembler that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a message and calls with every epoch that it closes, two at most.
    pub fn push(&mut self, message: &Message, see: &mut dyn FnMut(Epoch)) {
        let line = message.line;
        match &message.content {
            Content::Gga(gga) => {
                if let Some(epoch) = self.located(&gga.fix, GGA, line, see) {
                    (epoch.altitude_m, epoch.separation_m) = (gga.altitude_m, gga.separation_m);
                }
            }
            Content::Rmc(rmc) => {
                if let Some(epoch) = self.located(&rmc.fix, RMC, line, see) {
                    epoch.day = rmc.day.or(epoch.day);
                    epoch.velocity_mps = ground(rmc.speed_knots, rmc.course_deg).or(epoch.velocity_mps);
                }
            }
            Content::Gll(gll) => drop(self.located(&gll.fix, GLL, line, see)),
            Content::Vtg(vtg) => {
                if let Some(epoch) = &mut self.open {
                    epoch.velocity_mps = ground(vtg.speed_knots, vtg.course_deg).or(epoch.velocity_mps);
                }
            }
            Content::Hdt(hdt) => {
                if let (Some(heading_deg), Some(epoch)) = (hdt.heading_deg, &mut self.open) {
                    epoch.yaw_pitch_roll_rad.get_or_insert([heading_deg.to_radians(), 0.0, 0.0]);
                }
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
            Content::Inspvax(message) => self.complete(message, line, see),
        }
    }

    /// Closes the epoch that is open: the stream has ended, or nothing more is expected of its instant.
    pub fn finish(&mut self) -> Option<Epoch> {
        let mut epoch = self.open.take()?;
        if let (None, Some((day, before_ns))) = (epoch.day, self.before) {
            let step = epoch.time_of_day_ns - before_ns;
            // A talker that lags may fall back over midnight.
            let days = i64::from(step < -DAY_NS / 2) - i64::from(step > DAY_NS / 2);
            epoch.day = Some(day + days);
        }
        self.before = epoch.day.map(|day| (day, epoch.time_of_day_ns)).or(self.before);
        Some(epoch)
    }

    fn located(
        &mut self,
        fix: &Option<Fixed>,
        rank: u8,
        line: u64,
        see: &mut dyn FnMut(Epoch),
    ) -> Option<&mut Epoch> {
        let fix = fix.as_ref()?;
        let epoch = self.epoch(fix.time_of_day_ns, line, see)?;
        epoch.locate(fix.lat_deg, fix.lon_deg, rank);
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
        Some(self.open.get_or_insert(Epoch { line, time_of_day_ns, ..Epoch::default() }))
    }

    fn complete(&mut self, message: &Inspvax, line: u64, see: &mut dyn FnMut(Epoch)) {
        let Some(time) = message.time().filter(|_| message.is_solution()) else { return };
        // To the nanosecond, as sentences have it.
        let ns = (time.fraction_s() * 1e9).round() as i64;
        let (day, time_of_day_ns) =
            (time.seconds().div_euclid(DAY_S), time.seconds().rem_euclid(DAY_S) * SECOND_NS + ns);
        let Some(epoch) = self.epoch(time_of_day_ns, line, see) else { return };
        epoch.day = Some(day);
        epoch.inspvax(message);
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
