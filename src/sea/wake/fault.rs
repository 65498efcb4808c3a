//! Limits of a ship's wake, and what is wrong with one.

use crate::sea::surface::SurfaceError;
use crate::sea::surface::grid::FACET_RANGE_M;

/// What is wrong with a wake.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WakeError {
    /// Speed out of range.
    #[error("ship at {speed_mps} m/s: allowed are 0 to {MAX_SPEED_MPS} m/s")]
    Speed {
        /// The speed given, m/s.
        speed_mps: f64,
    },
    /// A course that is not a number.
    #[error("course of a ship: position (within 1e12 m), heading and rate of turn must be finite")]
    Course,
    /// Length out of range.
    #[error("ship of {length_m} m: allowed are {} to {} m", LENGTH_RANGE_M[0], LENGTH_RANGE_M[1])]
    Length {
        /// The length given, m.
        length_m: f64,
    },
    /// Not a length.
    #[error("{what} of a turbulent wake is {value}: it must be {allowed}")]
    Strip {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        allowed: &'static str,
    },
    /// Facet size out of range.
    #[error("facet of {facet_m} m: allowed are {} to {} m", FACET_RANGE_M[0], FACET_RANGE_M[1])]
    Facet {
        /// The size given, m.
        facet_m: f64,
    },
    /// Band limit out of range.
    #[error("band limit of {cutoff_rad_m} rad/m: it must be finite and above 0")]
    Cutoff {
        /// The limit given, rad/m.
        cutoff_rad_m: f64,
    },
    /// Not a reach.
    #[error(
        "reach of a wake of {along_m} m along and {across_m} m across: both must be finite and at least 0"
    )]
    Reach {
        /// Along the course, m.
        along_m: f64,
        /// To the sides, m.
        across_m: f64,
    },
    /// Too many nodes.
    #[error(
        "wake up to {along_m} m along and {across_m} m across needs {needed} waves, {MAX_NODES} are allowed: \
         a shorter reach, a lower band limit or larger facets need fewer"
    )]
    Nodes {
        /// Waves needed.
        needed: f64,
        /// Reach along the course, m.
        along_m: f64,
        /// Reach to the sides, m.
        across_m: f64,
    },
    /// The hull's amplitude is not a number.
    #[error("amplitude of the ship's waves at tan(theta) = {tan_theta} is not finite")]
    Amplitude {
        /// Where.
        tan_theta: f64,
    },
    /// The ship turns too fast for its wake to count as straight.
    #[error(
        "ship turns by {turn_rad} rad over the age of its wake of {along_m} m: at most {MOST_TURN_RAD} rad is modelled"
    )]
    Turn {
        /// Turn over the age of the wake, radians.
        turn_rad: f64,
        /// Reach along the course, m.
        along_m: f64,
    },
    /// Asked further away than the nodes were made for.
    #[error(
        "wake asked {astern_m} m astern and {starboard_m} m to starboard: it was made for {along_m} m along and {across_m} m across"
    )]
    BeyondReach {
        /// Distance astern, m.
        astern_m: f64,
        /// Distance to starboard, m.
        starboard_m: f64,
        /// Reach along the course, m.
        along_m: f64,
        /// Reach to the sides, m.
        across_m: f64,
    },
    /// Time out of range.
    #[error("wake at {time_s} s: allowed are times within {MAX_TIME_S} s of t = 0")]
    Time {
        /// The time asked, s.
        time_s: f64,
    },
    /// Accuracy out of range.
    #[error(
        "error of {error_db} dB: allowed are {} to {} dB",
        ERROR_RANGE_DB[0],
        ERROR_RANGE_DB[1]
    )]
    ErrorBudget {
        /// The requested error, dB.
        error_db: f64,
    },
    /// A wake made for other facets.
    #[error("wake made for facets of {wake_m} m on a map of facets of {map_m} m")]
    FacetsDiffer {
        /// Facet of the wake, m.
        wake_m: f64,
        /// Facet of the map, m.
        map_m: f64,
    },
    /// The rectangle of facets, or the buffers for it.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}

/// Lengths a ship may have, m.
pub const LENGTH_RANGE_M: [f64; 2] = [1e-3, 1e4];

/// Most nodes of one wake: a sum of this many takes about a second.
pub const MAX_NODES: usize = 1 << 18;

/// Speeds up to this are ships', m/s.
pub const MAX_SPEED_MPS: f64 = 100.0;

/// Furthest time from t = 0, s.
pub const MAX_TIME_S: f64 = 1e9;

/// Most turn over the age of the wake, radians.
pub const MOST_TURN_RAD: f64 = 0.05;

/// Errors that may be asked for, dB.
pub const ERROR_RANGE_DB: [f64; 2] = [-220.0, -20.0];
