//! Why there is no track, or no state of it at an instant.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

use crate::motion::attitude::{MAX_STEP_DEG, MIN_SPEED_MPS};
use crate::motion::errors::ErrorsFault;
use crate::nav::NavError;
use crate::time::TimeTag;

/// Why there is no track, or no state at an instant.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TrackError {
    /// The instant lies outside the track.
    #[error(
        "the track covers {first} to {last}; asked for {asked}, {:.9} s {}",
        if first.since(*asked) > 0.0 { first.since(*asked) } else { asked.since(*last) },
        if first.since(*asked) > 0.0 { "before its begin" } else { "after its end" }
    )]
    OutOfSpan {
        /// The instant.
        asked: TimeTag,
        /// Begin of the track.
        first: TimeTag,
        /// End of the track.
        last: TimeTag,
    },
    /// A stretch of time lies partly outside the track.
    #[error(
        "the track covers {first} to {last} ({:.3} s); asked for {from} to {to}: {}",
        last.since(*first),
        Missing { from: *from, to: *to, first: *first, last: *last }
    )]
    Uncovered {
        /// Begin of what is asked.
        from: TimeTag,
        /// End of what is asked.
        to: TimeTag,
        /// Begin of the track.
        first: TimeTag,
        /// End of the track.
        last: TimeTag,
    },
    /// Too few fixes for a track.
    #[error("{}: usable fixes: {found}, needed: at least {needed}", path.display())]
    TooFewFixes {
        /// The file.
        path: PathBuf,
        /// Usable fixes.
        found: usize,
        /// Needed.
        needed: usize,
    },
    /// A fix that is not finite or not later than the one before.
    #[error("{}: fix {index} ({time}) is not finite or not later than the one before", path.display())]
    BadFix {
        /// The file.
        path: PathBuf,
        /// Position among the fixes.
        index: usize,
        /// Its time.
        time: TimeTag,
    },
    /// Latitudes and longitudes in a scene that is not georeferenced.
    #[error(
        "{}: positions are latitudes and longitudes, but the scene is a plain local frame; \
         give the scene an origin, or the track x_m, y_m, z_m",
        path.display()
    )]
    NoOrigin {
        /// The file.
        path: PathBuf,
    },
    /// A platform is placed by latitude and longitude in a scene that is not georeferenced.
    #[error(
        "a platform is placed by latitude and longitude, but the scene is a plain local frame; \
         give the scene an origin, or the platform a local position"
    )]
    PlaceNeedsOrigin,
    /// Recorded attitude is asked for and not there.
    #[error("{}: attitude = recorded, but {missing} of {fixes} fixes have none", path.display())]
    NoAttitude {
        /// The file.
        path: PathBuf,
        /// Fixes without attitude.
        missing: usize,
        /// All fixes.
        fixes: usize,
    },
    /// A heading cannot be derived from hardly any motion.
    #[error(
        "{}: the heading is to follow the motion, but at {time} the horizontal speed is {speed_mps:.3} m/s; \
         needed: at least {MIN_SPEED_MPS} m/s, or a recorded or constant attitude",
        path.display()
    )]
    HeadingUndefined {
        /// The file.
        path: PathBuf,
        /// When.
        time: TimeTag,
        /// Horizontal speed there, m/s.
        speed_mps: f64,
    },
    /// Live navigation where the whole flight must be known.
    #[error(
        "live navigation is not known beforehand; allowed: track.nominal, a track that stands for the flight"
    )]
    NoRehearsal,
    /// A straight track that does not move horizontally has no heading of its own.
    #[error("the heading is to follow the motion, but the horizontal velocity is zero; give an attitude")]
    NoHeading,
    /// The attitude turns too far between two fixes.
    #[error(
        "{}: the attitude turns by {step_deg:.1} deg to the fix at {time}; allowed: {MAX_STEP_DEG} deg between fixes; \
         where it is derived from noisy fixes, track.smoothing (kind = \"rts\") evens them out; \
         track.attitude = \"constant\" takes none from the file",
        path.display()
    )]
    AttitudeStep {
        /// The file.
        path: PathBuf,
        /// The later fix.
        time: TimeTag,
        /// The rotation, degrees.
        step_deg: f64,
    },
    /// A setting of the smoother out of range.
    #[error("{}: {name} = {value} is not allowed: 0.0001 to 10000", path.display())]
    SmoothingSetting {
        /// The file.
        path: PathBuf,
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// No smooth track stays below the acceleration bound.
    #[error(
        "{}: even the smoothest track through the fixes reaches {reached:.3} m/s^2; allowed: {allowed_mps2} m/s^2",
        path.display()
    )]
    AccelerationBound {
        /// The file.
        path: PathBuf,
        /// What the smoothest track reaches, m/s^2.
        reached: f64,
        /// The bound, m/s^2.
        allowed_mps2: f64,
    },
    /// The smooth track is far from its fixes.
    #[error(
        "{}: the track smoothed to {allowed_mps2} m/s^2 misses the fixes by {rms_m:.1} m rms ({axis}), more than \
         {MAX_MISFIT_SIGMAS} times {axis}_sigma_m = {sigma_m}; allow more acceleration, state a larger deviation, \
         or cut the manoeuvre",
        path.display()
    )]
    Misfit {
        /// The file.
        path: PathBuf,
        /// `horizontal` or `vertical`.
        axis: &'static str,
        /// Residual, m.
        rms_m: f64,
        /// Stated standard deviation of a fix, m.
        sigma_m: f64,
        /// The acceleration bound, m/s^2.
        allowed_mps2: f64,
    },
    /// Rejecting outliers left a gap.
    #[error(
        "{}: without the outliers there is no fix for {gap_s:.3} s before {time}; \
         longest gap allowed: max_gap_s = {allowed_s} s",
        path.display()
    )]
    RejectedGap {
        /// The file.
        path: PathBuf,
        /// The fix after the gap.
        time: TimeTag,
        /// Its length, s.
        gap_s: f64,
        /// `max_gap_s` of the source.
        allowed_s: f64,
    },
}

struct Missing {
    from: TimeTag,
    to: TimeTag,
    first: TimeTag,
    last: TimeTag,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (early, late) = (self.first.since(self.from), self.to.since(self.last));
        match (early > 0.0, late > 0.0) {
            (true, true) => {
                write!(f, "{early:.3} s are missing at the beginning and {late:.3} s at the end")
            }
            (true, false) => write!(f, "{early:.3} s are missing at the beginning"),
            _ => write!(f, "{late:.3} s are missing at the end"),
        }
    }
}

/// Why a source gives no track.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SourceError {
    /// Its file cannot be used.
    #[error(transparent)]
    Nav(#[from] NavError),
    /// Its fixes make no track.
    #[error(transparent)]
    Track(#[from] TrackError),
    /// Its file has gaps, and across them its fixes make no track.
    #[error("{gaps}\n{track}")]
    Gaps {
        /// The gaps.
        gaps: Box<NavError>,
        /// What else is wrong.
        track: Box<TrackError>,
    },
    /// Its errors.
    #[error(transparent)]
    Errors(#[from] ErrorsFault),
    /// Its turbulence.
    #[error(transparent)]
    Turbulence(#[from] TurbulenceFault),
}

/// Residual of a smooth track, in stated standard deviations (rms), beyond which it is refused: it would not
/// be the recorded motion any more.
pub const MAX_MISFIT_SIGMAS: f64 = 5.0;

/// Why there is no turbulence.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TurbulenceFault {
    /// A platform that does not fly.
    #[error(
        "turbulence of a platform at {airspeed_mps:.2} m/s; allowed: at least {LEAST_AIRSPEED_MPS} m/s, \
         or a turbulence.airspeed_mps"
    )]
    Slow {
        /// Its speed, m/s.
        airspeed_mps: f64,
    },
    /// A run of too many steps.
    #[error(
        "turbulence takes {steps} steps of {step_s:.4} s; allowed: at most {MOST_STEPS}; \
         a shorter run, or a turbulence.height_m or cutoff_hz of slower gusts"
    )]
    TooLong {
        /// Steps needed.
        steps: u64,
        /// Their length, s.
        step_s: f64,
    },
    /// A setting that has no meaning.
    #[error("turbulence: {name} = {value} is not allowed: {allowed}")]
    Value {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A track that does not reach pulse 0.
    #[error("turbulence: {0}")]
    Track(#[from] TrackError),
}

/// Airspeed below which a platform does not fly, m/s.
pub const LEAST_AIRSPEED_MPS: f64 = 5.0;

/// Most steps of a run (150 MiB).
pub const MOST_STEPS: u64 = 1 << 20;
