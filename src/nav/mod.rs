//! Where platforms say they are: recorded fixes from track files and NMEA logs.
//!
//! [`load`] is the one way from a file to fixes: it reads the file that a [`FileSource`] names, in the format
//! that it names, and hands back every usable [`Fix`] in time order with a [`LoadReport`]. Formats: [`csv`]
//! (documented columns), [`nmea`] (NMEA 0183 logs and those of NovAtel receivers), [`sbet`] (post-processed
//! trajectories) and [`xml`] (GPX and KML). What becomes of the fixes is the business of `motion::track`.
//! Reports of other vessels are read by [`ais`].
//!
//! Bytes of a receiver go through [`decode`], [`epoch`] and [`completion`], which know no files: [`live`]
//! reads them while a run goes on. [`encode`] writes what a receiver would send of a [`solution`].

#[doc(hidden)]
pub mod ais;
#[doc(hidden)]
pub mod alternation;
#[doc(hidden)]
pub mod completion;
#[doc(hidden)]
pub mod corruption;
#[doc(hidden)]
pub mod csv;
#[doc(hidden)]
pub mod decode;
#[doc(hidden)]
pub mod encode;
#[doc(hidden)]
pub mod epoch;
#[doc(hidden)]
pub mod faults;
#[doc(hidden)]
pub mod inspection;
#[doc(hidden)]
pub mod live;
#[doc(hidden)]
pub mod load_report;
#[doc(hidden)]
pub mod nmea;
#[doc(hidden)]
pub mod pcap;
#[doc(hidden)]
pub mod recording;
#[doc(hidden)]
pub mod replay;
#[doc(hidden)]
pub mod sbet;
#[doc(hidden)]
pub mod solution;
#[doc(hidden)]
pub mod stretches;
#[doc(hidden)]
pub mod unpacked;
#[doc(hidden)]
pub mod xml;

use std::path::PathBuf;

use crate::frames::{Body, Enu, Geodetic, Point, Rotation, Vector};
use crate::time::TimeTag;

pub use faults::{Fault, FaultKind, Faults, NavError};
pub use live::{LiveSource, MotionBounds};
pub use load_report::LoadReport;
pub use recording::Recording;
pub use replay::load;

/// A source of one trajectory.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TrackSource {
    /// Stays where it is.
    Fixed {
        /// Where.
        place: Place,
        /// Attitude.
        attitude: Rotation<Body, Enu>,
    },
    /// Straight line at constant speed.
    Straight {
        /// Position at the emission of pulse 0.
        place: Place,
        /// Velocity, m/s.
        velocity: Vector<Enu>,
        /// Attitude; `None`: nose along the velocity, wings level.
        attitude: Option<Rotation<Body, Enu>>,
    },
    /// A recorded track.
    File(FileSource),
    /// What a receiver reports while the run goes on.
    Live(LiveSource),
}

/// A position, as given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// On Earth, ellipsoidal height.
    Geodetic(Geodetic),
    /// In the scene frame.
    Local(Point<Enu>),
}

/// A recorded track file.
#[derive(Clone, Debug, PartialEq)]
pub struct FileSource {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: FileFormat,
    /// What its heights are measured from.
    pub datum: VerticalDatum,
    /// Height of mean sea level above the ellipsoid, m: used where heights are above the sea and the
    /// file does not say (NMEA GGA does).
    pub undulation_m: f64,
    /// The longest gap between fixes that is interpolated, s.
    pub max_gap_s: f64,
    /// How the fixes become a smooth track.
    pub smoothing: Smoothing,
    /// Where the attitude comes from.
    pub attitude: AttitudeSource,
    /// NMEA: the day of the first fix (since 1970-01-01), in place of the dates of the file.
    pub first_day: Option<i64>,
    /// How the platform can move: single fixes that ask for more are left.
    pub bounds: MotionBounds,
}

/// Format of a track file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileFormat {
    /// Documented columns, see `nav::csv`.
    Csv,
    /// NMEA 0183 log.
    Nmea,
    /// NovAtel INSPVAX, INSPVA and INSPVAS, ASCII or binary, see `nav::nmea`.
    Inspvax,
    /// GPX, see `nav::xml`.
    Gpx,
    /// KML, see `nav::xml`.
    Kml,
    /// Smoothed best estimate of trajectory, see `nav::sbet`.
    Sbet {
        /// GPS week of the first record.
        gps_week: u32,
    },
}

/// What heights are measured from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum VerticalDatum {
    /// WGS-84 ellipsoid.
    Ellipsoid,
    /// Mean sea level.
    MeanSeaLevel,
    /// Pressure altitude; `offset_m` is added to make it a height above mean sea level.
    Barometric {
        /// Correction, m.
        offset_m: f64,
    },
}

/// How fixes become a track.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Smoothing {
    /// Fixes are taken as exact.
    Off,
    /// Rauch-Tung-Striebel smoother whose result stays below an acceleration.
    Rts {
        /// Standard deviation of the horizontal position of a fix, m.
        horizontal_sigma_m: f64,
        /// Standard deviation of the height of a fix, m.
        vertical_sigma_m: f64,
        /// Bound on the acceleration of the smoothed track, m/s^2.
        max_acceleration_mps2: f64,
    },
}

/// Where the attitude of a recorded track comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AttitudeSource {
    /// As recorded where the fixes have an attitude, otherwise derived as [`Self::CoordinatedTurn`].
    Automatic,
    /// Columns or sentences of the file.
    Recorded,
    /// Derived from the motion: nose along the velocity, roll of a coordinated turn.
    CoordinatedTurn,
    /// Wings level, nose along the ground track.
    Level,
    /// Constant.
    Constant(Rotation<Body, Enu>),
}

/// One recorded fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// When, UTC.
    pub time: TimeTag,
    /// Where.
    pub place: Place,
    /// Yaw (clockwise from North), pitch, roll, radians, if the source has them.
    pub yaw_pitch_roll_rad: Option<[f64; 3]>,
    /// Velocity East and North of the fix, m/s, if the source has it.
    pub velocity_mps: Option<[f64; 2]>,
    /// Velocity upward, m/s, if the source has it.
    pub climb_mps: Option<f64>,
    /// The accuracy that the source states.
    pub sigma: Sigma,
}

impl Fix {
    /// A fix of which nothing is known but its time and place.
    pub fn at(time: TimeTag, place: Place) -> Self {
        Self {
            time,
            place,
            yaw_pitch_roll_rad: None,
            velocity_mps: None,
            climb_mps: None,
            sigma: Sigma::default(),
        }
    }
}

/// Standard deviations as a source states them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sigma {
    /// Of the position East, North, up, m.
    pub position_m: Option<[f32; 3]>,
    /// Of the velocity East, North, up, m/s.
    pub velocity_mps: Option<[f32; 3]>,
    /// Of yaw, pitch, roll, radians.
    pub angles_rad: Option<[f32; 3]>,
}
