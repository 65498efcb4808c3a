//! What a receiver would send of a state: NMEA 0183 sentences, NovAtel INSPVAX.
//!
//! | message | resolution |
//! | --- | --- |
//! | time of all NMEA sentences | 1 ns; three decimals of the second at least |
//! | GGA, RMC: latitude, longitude | 1e-8 minutes: 9e-6 m at most |
//! | GGA: altitude, separation | 1e-5 m, 1e-4 m; the sum is the height to 5e-6 m |
//! | RMC, VTG: speed, course | 1e-4 kn, 1e-4 deg |
//! | HDT, PASHR: angles | 1e-4 deg |
//! | GST: deviations | 1e-4 m |
//! | INSPVAX: time | 1 ms, see below |
//! | INSPVAX, ASCII | 1e-11 deg (1e-6 m), 1e-5 m, 1e-6 m/s, 1e-9 deg |
//! | INSPVAX, binary | f64; undulation and deviations f32, the undulation's rounding is taken up by the height |
//!
//! INSPVAX has milliseconds. A state between two is moved along its velocity to the nearer one, at most 0.5
//! ms: with an acceleration of 10 m/s^2 that leaves 1e-6 m. Its attitude is left as it is (0.03 deg at 1
//! rad/s).
//!
//! Sentences are longer than the 82 characters of the standard (up to about 100), as those of precise
//! receivers are. Figures that are not known are empty fields; PASHR is left out without an attitude, and
//! INSPVAX needs velocity and attitude.
//!
//! ```
//! use nereus::frames::Geodetic;
//! use nereus::nav::Sigma;
//! use nereus::nav::encode::{Format, Sentence};
//! use nereus::nav::solution::Solution;
//! use nereus::time::TimeTag;
//!
//! let solution = Solution {
//!     time: TimeTag::from_iso8601("2018-05-30T18:40:00.25Z").unwrap(),
//!     place: Geodetic::from_deg(53.5, -4.25, 143.5),
//!     undulation_m: 43.5,
//!     velocity_mps: Some([0.0, 100.0, 0.0]),
//!     yaw_pitch_roll_rad: None,
//!     sigma: Sigma::default(),
//! };
//! let mut out = Vec::new();
//! Format::Nmea(vec![Sentence::Gga]).write(&solution, &mut out).unwrap();
//! assert_eq!(
//!     out,
//!     b"$GPGGA,184000.250,5330.00000000,N,00415.00000000,W,1,10,1.0,100.00000,M,43.5000,M,,*72\r\n"
//! );
//! assert!(Format::InspvaxBinary.write(&solution, &mut out).is_err());
//! ```

pub mod csv;
mod kml;
mod nmea;
mod novatel;
pub mod targets;

use std::path::Path;

use thiserror::Error;

use super::solution::Solution;

/// A sentence that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sentence {
    /// Position and height.
    Gga,
    /// Position, speed, course, date.
    Rmc,
    /// Speed and course.
    Vtg,
    /// Heading.
    Hdt,
    /// Time and date.
    Zda,
    /// Standard deviations of the position.
    Gst,
    /// Heading, roll and pitch.
    Pashr,
}

impl Sentence {
    /// All of them, in an order that readers understand.
    pub const ALL: [Self; 7] =
        [Self::Gga, Self::Rmc, Self::Vtg, Self::Hdt, Self::Zda, Self::Gst, Self::Pashr];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gga => "GGA",
            Self::Rmc => "RMC",
            Self::Vtg => "VTG",
            Self::Hdt => "HDT",
            Self::Zda => "ZDA",
            Self::Gst => "GST",
            Self::Pashr => "PASHR",
        }
    }

    /// The sentence of a name, in letters of any case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|sentence| sentence.name().eq_ignore_ascii_case(name))
    }
}

/// How states are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Format {
    /// NMEA 0183 sentences, in this order.
    Nmea(Vec<Sentence>),
    /// `#INSPVAXA`.
    InspvaxAscii,
    /// INSPVAX, binary.
    InspvaxBinary,
}

/// Why a state cannot be written.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// INSPVAX has no empty fields.
    #[error("INSPVAX needs a velocity and an attitude; allowed without: nmea")]
    Incomplete,
    /// A time or position that the format has no figures for.
    #[error(
        "the state cannot be written; allowed: 1980 to 2136, heights and speeds of what moves on or about Earth"
    )]
    Range,
}

/// A state of a recording that cannot be written.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("fix {number} at {time}: {source}")]
#[doc(hidden)]
pub struct Unwritable {
    /// Which one, from 1.
    pub number: usize,
    /// When.
    pub time: String,
    /// Why.
    pub source: EncodeError,
}

impl Unwritable {
    /// The state of such a number.
    pub fn of(number: usize, solution: &Solution, source: EncodeError) -> Self {
        Self { number, time: solution.time.to_string(), source }
    }
}

/// Format of a navigation file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum OutputFormat {
    /// A table of comma-separated values.
    Csv,
    /// A track of KML.
    Kml,
    /// Messages.
    Messages(Format),
}

impl OutputFormat {
    /// By the ending of a file's name; NMEA sentences are those given.
    pub fn named(path: &Path, sentences: &[Sentence]) -> Option<Self> {
        Some(match path.extension()?.to_ascii_lowercase().to_str()? {
            "csv" => Self::Csv,
            "kml" => Self::Kml,
            "nmea" => Self::Messages(Format::Nmea(sentences.to_vec())),
            "inspvaxa" => Self::Messages(Format::InspvaxAscii),
            "inspvax" | "inspvaxb" => Self::Messages(Format::InspvaxBinary),
            _ => return None,
        })
    }

    /// The whole file.
    ///
    /// # Errors
    /// The first state that the format cannot hold.
    pub fn encode(&self, solutions: &[Solution]) -> Result<Vec<u8>, Unwritable> {
        let mut bytes = Vec::new();
        match self {
            Self::Csv => csv::write(solutions, &mut bytes),
            Self::Kml => kml::write(solutions, &mut bytes),
            Self::Messages(format) => {
                for (number, solution) in (1..).zip(solutions) {
                    let written = format.write(solution, &mut bytes);
                    written.map_err(|source| Unwritable::of(number, solution, source))?;
                }
            }
        }
        Ok(bytes)
    }
}

impl Format {
    /// Appends the messages of a state.
    ///
    /// # Errors
    /// A state without what the format needs, or outside what it can hold; nothing is appended then.
    pub fn write(&self, solution: &Solution, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let angles = solution.yaw_pitch_roll_rad.unwrap_or_default();
        let velocity = solution.velocity_mps.unwrap_or_default();
        let place = solution.place;
        let sound = place.lat_rad.abs() <= 1.571
            && place.lon_rad.abs() <= 7.0
            && place.h_m.abs() <= 9e7
            && solution.undulation_m.abs() <= 9e3
            && velocity.iter().all(|v| v.abs() <= 5e4)
            && angles.iter().all(|angle| angle.abs() <= 100.0);
        if !sound || solution.time.to_gps().is_none() {
            return Err(EncodeError::Range);
        }
        match self {
            Self::Nmea(sentences) => {
                for sentence in sentences {
                    nmea::write(*sentence, solution, out);
                }
                Ok(())
            }
            Self::InspvaxAscii => novatel::Values::of(solution).map(|values| values.ascii(out)),
            Self::InspvaxBinary => novatel::Values::of(solution).map(|values| values.binary(out)),
        }
    }
}

/// Longitude within -180 to 180 degrees.
fn lon_deg(lon_rad: f64) -> f64 {
    let lon = lon_rad.to_degrees();
    if lon.abs() <= 180.0 { lon } else { (lon + 180.0).rem_euclid(360.0) - 180.0 }
}

/// An angle from 0 up to a full turn, degrees, such that rounding to `unit` does not make it a full turn.
fn turn_deg(angle_rad: f64, unit: f64) -> f64 {
    let deg = angle_rad.to_degrees().rem_euclid(360.0);
    if deg >= 360.0 - unit / 2.0 { 0.0 } else { deg }
}

/// Yaw, pitch and roll with pitch within a quarter turn and roll within half a turn, radians.
fn tidy([yaw, pitch, roll]: [f64; 3]) -> [f64; 3] {
    let tau = std::f64::consts::TAU;
    let [pitch, roll] = [pitch, roll].map(|angle| angle - tau * (angle / tau).round());
    let quarter = tau / 4.0;
    if pitch.abs() <= quarter {
        return [yaw, pitch, roll];
    }
    // Over the top: looking back, upside down.
    let roll = if roll > 0.0 { roll - tau / 2.0 } else { roll + tau / 2.0 };
    [yaw + tau / 2.0, pitch.signum() * tau / 2.0 - pitch, roll]
}
