//! Where antennas point.

use crate::frames::{Enu, Point, Vector};

/// Where an antenna points.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pointing {
    /// Bolted to the body: yaw, pitch, roll of the antenna frame relative to the body, radians.
    Fixed {
        /// Rotation about body z (down): positive turns the boresight to starboard.
        yaw_rad: f64,
        /// Rotation about the new y: positive raises the boresight.
        pitch_rad: f64,
        /// Rotation about the boresight.
        roll_rad: f64,
    },
    /// A servo keeps the boresight on an aim point.
    At {
        /// The aim point.
        aim: Aim,
        /// Which tracks the servo knows.
        aim_from: AimFrom,
        /// The servo acts on what was known this long ago, s.
        lag_s: f64,
        /// Constant misalignment about the antenna's z (azimuth) and y (elevation) axes, radians.
        bias_rad: [f64; 2],
    },
    /// A pedestal turns it, whatever there is to be seen.
    Scan(Scan),
}

impl Pointing {
    /// Pulses after which it jumps to another direction, counted from pulse 0; `None` where it never does.
    pub fn dwell_pulses(&self) -> Option<u64> {
        match self {
            Self::Scan(Scan { law, .. }) => law.dwell_pulses(),
            Self::Fixed { .. } | Self::At { .. } => None,
        }
    }
}

/// What a pointing is steered by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steering<'a> {
    /// What it looks at; `None` of a scan.
    pub aim: Option<&'a Aim>,
    /// Which trajectory it acts on.
    pub from: AimFrom,
    /// It acts on what was known this long ago, s.
    pub lag_s: f64,
}

impl Pointing {
    /// What steers it; `None` of what goes with the body.
    pub fn steering(&self) -> Option<Steering<'_>> {
        match self {
            Self::At { aim, aim_from, lag_s, .. } => {
                Some(Steering { aim: Some(aim), from: *aim_from, lag_s: *lag_s })
            }
            Self::Scan(Scan { level_by: Some(from), .. }) => {
                Some(Steering { aim: None, from: *from, lag_s: 0.0 })
            }
            Self::Fixed { .. } | Self::Scan(_) => None,
        }
    }
}

/// A scanning pedestal, or a beam that jumps: azimuth clockwise seen from above, elevation upward.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Where it points when.
    pub law: ScanLaw,
    /// Azimuth from the scene's North and elevation from the horizontal plane, kept level by what is known of
    /// the platform; `None`: both from the platform's nose and its deck.
    pub level_by: Option<AimFrom>,
    /// What its encoder makes of that.
    pub encoder: Encoder,
}

/// Where a pedestal points when.
#[derive(Clone, Debug, PartialEq)]
pub enum ScanLaw {
    /// Turns without end.
    Rotation {
        /// Rate of turn, rad/s; negative: counterclockwise.
        rate_rad_per_s: f64,
        /// Azimuth at pulse 0, rad.
        start_rad: f64,
        /// Elevation, rad.
        elevation_rad: f64,
    },
    /// Goes to and fro; from `from_rad` at pulse 0.
    Sector {
        /// Azimuth where sweeps of even number begin, rad.
        from_rad: f64,
        /// Azimuth where they end; above or below `from_rad`.
        to_rad: f64,
        /// Rate within a sweep, rad/s, positive.
        rate_rad_per_s: f64,
        /// Time from the end of a sweep to the begin of the next, s.
        turn_s: f64,
        /// Elevations of sweeps in turn, rad.
        elevations_rad: Vec<f64>,
    },
    /// Stays in one direction for some pulses, then jumps to the next: a beam that is steered
    /// electronically. Echoes are received through the beam that was set when their pulse left.
    Steps {
        /// Azimuth and elevation of the directions in turn, rad; the first at pulse 0.
        directions_rad: Vec<[f64; 2]>,
        /// Pulses in each.
        dwell_pulses: u64,
        /// Time in each, s: that of so many intervals of the radar.
        dwell_s: f64,
    },
}

impl ScanLaw {
    /// Pulses after which the direction jumps, counted from pulse 0; `None` of laws that do not.
    pub fn dwell_pulses(&self) -> Option<u64> {
        match self {
            Self::Steps { dwell_pulses, .. } => Some(*dwell_pulses),
            Self::Rotation { .. } | Self::Sector { .. } => None,
        }
    }
}

/// Errors of the encoder of a pedestal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoder {
    /// Reading of the azimuth minus the azimuth, rad.
    pub bias_rad: f64,
    /// Noise of each reading, rms, rad.
    pub noise_rad: f64,
    /// Bits of a turn; `None` of an encoder without steps.
    pub bits: Option<u32>,
}

/// A point on the surface that an antenna or a receive window follows.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Aim {
    /// A point that moves on a straight line (position at pulse 0).
    Point {
        /// Position at the emission of pulse 0.
        position: Point<Enu>,
        /// Velocity, m/s.
        velocity: Vector<Enu>,
    },
    /// A point of the mean sea surface beside a platform, in axes along its horizontal velocity.
    Beside {
        /// Index of the platform.
        platform: usize,
        /// Metres ahead along the ground track.
        along_m: f64,
        /// Metres to starboard of the ground track (negative: to port).
        across_m: f64,
    },
}

/// Which trajectory a servo or a receive window acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AimFrom {
    /// What the platform reports.
    Reported,
    /// Where the platform is.
    True,
}
