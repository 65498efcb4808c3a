//! Live navigation: what a receiver reports while the run goes on.
//!
//! A [`LiveSource`] names where the bytes come from and what is made of them; its fixes are those that a file
//! of the same sentences gives. A [`Feed`] reads it, a [`FixDecoder`] makes fixes of the bytes. A run takes
//! them as they come, see `motion::live`.
//!
//! Symbols: `max_gap_s` the longest time between two fixes that is interpolated, `max_extrapolation_s` the
//! longest time after the last fix for which the motion is still reported from it; beyond that it is stale.

mod decoder;
pub mod feed;
mod line;

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Instant;

pub use decoder::FixDecoder;
pub use feed::{Feed, FeedCounts, FeedError};

use super::{AttitudeSource, Fix, VerticalDatum};
use crate::nav::TrackSource;

/// Navigation that comes while the run goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveSource {
    /// Where the bytes come from.
    pub origin: Origin,
    /// What heights are measured from, where the messages do not say.
    pub datum: VerticalDatum,
    /// Height of mean sea level above the ellipsoid, m.
    pub undulation_m: f64,
    /// Where the attitude comes from.
    pub attitude: AttitudeSource,
    /// The day of the first fix (since 1970-01-01), in place of the dates of the messages.
    pub first_day: Option<i64>,
    /// The longest time between two fixes that is interpolated, s.
    pub max_gap_s: f64,
    /// The longest time after the last fix for which motion is extrapolated, s; beyond it, it is stale.
    pub max_extrapolation_s: f64,
    /// How long the begin of a run waits for navigation, s.
    pub timeout_s: f64,
    /// How a platform can move: fixes that ask for more are refused.
    pub bounds: MotionBounds,
    /// A track that stands for the flight where one must be known beforehand.
    pub nominal: Option<Box<TrackSource>>,
}

/// How fast a platform can be, and when fixes that say otherwise are believed all the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionBounds {
    /// Highest speed, m/s.
    pub max_speed_mps: f64,
    /// Highest acceleration, m/s^2.
    pub max_acceleration_mps2: f64,
    /// Refused fixes in a row that agree with each other after which they are believed.
    pub reset_fixes: usize,
}

impl MotionBounds {
    /// A ship, 40 m/s and 10 m/s^2 (an antenna at a mast head).
    pub const SHIP: Self = Self { max_speed_mps: 40.0, max_acceleration_mps2: 10.0, reset_fixes: 5 };
    /// A vehicle on the ground, 100 m/s and 30 m/s^2.
    pub const GROUND: Self = Self { max_speed_mps: 100.0, max_acceleration_mps2: 30.0, reset_fixes: 5 };
    /// An aircraft, 1000 m/s and 100 m/s^2.
    pub const AIRCRAFT: Self = Self { max_speed_mps: 1000.0, max_acceleration_mps2: 100.0, reset_fixes: 5 };
    /// A spacecraft, 12 km/s and 100 m/s^2.
    pub const SPACECRAFT: Self =
        Self { max_speed_mps: 12_000.0, max_acceleration_mps2: 100.0, reset_fixes: 5 };
}

/// Where live navigation comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A serial port or a pseudo terminal.
    Serial {
        /// Its path.
        path: PathBuf,
        /// Bits a second.
        baud: u32,
    },
    /// Somebody who sends to those who connect.
    TcpConnect(SocketAddr),
    /// An address to which a sender connects.
    TcpListen(SocketAddr),
    /// An address to which datagrams are sent.
    Udp(SocketAddr),
    /// A file, replayed in time.
    File(PathBuf),
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path, baud } => write!(f, "{} at {baud} baud", path.display()),
            Self::TcpConnect(address) => write!(f, "tcp://{address}"),
            Self::TcpListen(address) => write!(f, "tcp-listen://{address}"),
            Self::Udp(address) => write!(f, "udp://{address}"),
            Self::File(path) => write!(f, "file {}", path.display()),
        }
    }
}

/// A fix of a live source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceivedFix {
    /// What it states.
    pub fix: Fix,
    /// When its last byte had come.
    pub arrived: Instant,
}
