//! A trajectory that grows: fixes come while the run goes on.
//!
//! What has been reported once never changes: the path is a chain of nodes to which more are added and of
//! which none is altered, joined by quintic segments as in a recorded track ([`crate::motion::track`]).
//!
//! * **Interpolated.** A node is the fix itself, its derivatives those of the polynomial through its seven
//!   nearest fixes ([`crate::scene::hermite`]); it is reported once the three fixes after it have come (six
//!   where the attitude follows the motion), and is then, bit for bit, the node of a file with the same
//!   fixes. The **support** of the interpolant is thus four fixes (seven) after the instant.
//! * **Extrapolated** ([`LiveTrack::extend`]). Where an instant cannot wait: fixes at hand become nodes with
//!   derivatives from the three last fixes alone, and beyond the last one the motion goes on,
//!
//! ```text
//! p(t) = R(t) + o(t),   R(t) = p_n + v_n (t - t_n),   o(t_e) = p_e - R(t_e), o'(t_e) = v_e - v_n, ..., o(t_e + T) = 0
//! ```
//!
//!   with `p_n`, `v_n` the last fix and its velocity (as sent; else from the last three fixes), `t_e` the end
//!   of the path so far, and `o` the quintic that brings what was reported before back to what is known now,
//!   without a jump in position, velocity or acceleration, within
//!   `T = max(0.3 s, sqrt(5.8 |o| / A), 4 |o'| / A)`, `A` = 20 m/s^2, and no faster than some 30 deg/s where
//!   the attitude is off. The attitude is held. When fixes come again the path goes back to them in the same
//!   way, and what is reported is flagged until it has.
//! * **Stale**: more than `max_extrapolation_s` after the last fix. The motion still goes on as it was,
//!   flagged.
//! * A time between fixes of more than `max_gap_s` is not interpolated: the fixes before it are as at the end
//!   of a file, those after it as at the begin of another, and what lies between is flagged as extrapolated.
//!
//! Instants before the first fix are extrapolated back. The path is kept for [`KEPT_S`] behind its end.
//!
//! Feeding and asking are for different threads.
//!
//! ```
//! use std::time::Instant;
//! use nereus::frames::{Earth, Point, Rotation, SceneFrame};
//! use nereus::motion::track::live::LiveTrack;
//! use nereus::nav::{AttitudeSource, Fix, Place};
//! use nereus::time::TimeTag;
//!
//! let level = AttitudeSource::Constant(Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0));
//! let track = LiveTrack::new(SceneFrame::plain(Earth::Flat), level, 2.0, 1.0);
//! let at = |k: i32| TimeTag::new(1_000_000, 0.1 * f64::from(k));
//! for k in 0..10 {
//!     track.push(&Fix::at(at(k), Place::Local(Point::new(5.0 * f64::from(k), 0.0, 0.0))), Instant::now())?;
//! }
//! // Fix 6 has three after it.
//! assert_eq!(track.end(), Some(at(6)));
//! assert!((track.report(at(3)).state.velocity.norm() - 50.0).abs() < 1e-9);
//! # Ok::<(), nereus::motion::track::live::Unusable>(())
//! ```

mod jets;
mod path;

use std::sync::{Arc, OnceLock, PoisonError, RwLock};
use std::time::Instant;

use thiserror::Error;

use self::path::{Entry, Grown};
use crate::frames::{Enu, Point, SceneFrame, Vector};
use crate::motion::place::position;
use crate::motion::track::State;
use crate::nav::{AttitudeSource, Fix};
use crate::scene::hermite::STENCIL;
use crate::time::TimeTag;

/// How long the path is kept behind its end, s: more than any servo lag or latency of a report.
pub const KEPT_S: f64 = 300.0;
/// A fix of which no node can be made.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unusable {
    /// Latitude and longitude in a scene that is not georeferenced, or numbers that are not finite.
    #[error("its position is not in the scene")]
    NoPosition,
    /// Not later than the one before.
    #[error("it is not later than the one before")]
    NotLater,
    /// No attitude, where it is to be as recorded, and none has come yet.
    #[error("it has no attitude, and none has come yet")]
    NoAttitude,
}

/// Where a platform is at an instant, and what that rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reported {
    /// The state.
    pub state: State,
    /// The instant less the time of the fix that it is extrapolated from, s; 0 where it is interpolated.
    pub age_s: f64,
    /// [`NAV_EXTRAPOLATED`](crate::pulse::flags::NAV_EXTRAPOLATED),
    /// [`NAV_STALE`](crate::pulse::flags::NAV_STALE).
    pub flags: u32,
    /// When the last fix up to the instant had come.
    pub arrived: Option<Instant>,
}

/// A trajectory that grows. Clones are the same trajectory.
#[derive(Clone, Debug)]
pub struct LiveTrack(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    frame: SceneFrame,
    /// Where the attitude comes from, once that is known: the first fix decides an automatic choice.
    attitude: OnceLock<AttitudeSource>,
    max_gap_s: f64,
    max_extrapolation_s: f64,
    grown: RwLock<Grown>,
}

impl Shared {
    fn attitude(&self) -> AttitudeSource {
        self.attitude.get().copied().unwrap_or(AttitudeSource::Recorded)
    }
}

impl LiveTrack {
    /// A track without fixes, in the frame of a scene.
    pub fn new(
        frame: SceneFrame,
        attitude: AttitudeSource,
        max_gap_s: f64,
        max_extrapolation_s: f64,
    ) -> Self {
        let grown = RwLock::new(Grown::default());
        let attitude = match attitude {
            AttitudeSource::Automatic => OnceLock::new(),
            chosen => OnceLock::from(chosen),
        };
        Self(Arc::new(Shared { frame, attitude, max_gap_s, max_extrapolation_s, grown }))
    }

    fn read(&self) -> std::sync::RwLockReadGuard<'_, Grown> {
        self.0.grown.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> std::sync::RwLockWriteGuard<'_, Grown> {
        self.0.grown.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the next fix.
    ///
    /// # Errors
    /// A fix of which no node can be made; it is left.
    pub fn push(&self, fix: &Fix, arrived: Instant) -> Result<(), Unusable> {
        let p = position(fix, &self.0.frame).filter(|p| p.is_finite()).ok_or(Unusable::NoPosition)?;
        self.0.attitude.get_or_init(|| match fix.yaw_pitch_roll_rad {
            Some(_) => AttitudeSource::Recorded,
            None => AttitudeSource::CoordinatedTurn,
        });
        self.write().push(&self.0, Entry { fix: *fix, p, arrived, node: None, q: None })
    }

    /// The fixes that come now are elsewhere than the ones before, and believed: the path goes on without
    /// them to their first instant, and from there back to them, as after a time without fixes.
    pub fn jump(&self, at: TimeTag) {
        self.write().jump(&self.0, at);
    }

    /// The median time between the fixes at hand, s; `None` before there are two.
    pub fn interval_s(&self) -> Option<f64> {
        let grown = self.read();
        let times = grown.run.iter().map(|entry| entry.fix.time);
        let mut spans_s: Vec<f64> =
            times.clone().zip(times.skip(1)).map(|(before, after)| after.since(before)).collect();
        spans_s.sort_by(f64::total_cmp);
        spans_s.get(spans_s.len() / 2).copied()
    }

    /// Fixes after an instant without which it is not interpolated.
    pub fn support(&self) -> usize {
        if follows_motion(&self.0) { STENCIL } else { STENCIL / 2 + 1 }
    }

    /// Whether the attitude is derived from the motion; `None` before the first fix where that decides.
    pub fn derives_attitude(&self) -> Option<bool> {
        self.0.attitude.get().map(|_| follows_motion(&self.0))
    }

    /// The last fix.
    pub fn last_fix(&self) -> Option<TimeTag> {
        self.read().run.back().map(|entry| entry.fix.time)
    }

    /// Position and velocity of the last fix.
    pub fn last_known(&self) -> Option<(TimeTag, Point<Enu>, Vector<Enu>)> {
        let grown = self.read();
        let time = grown.run.back()?.fix.time;
        let known = grown.known(&self.0, time)?;
        Some((time, Point::from_raw(known.p[0]), Vector::from_raw(known.p[1])))
    }

    /// Whether enough is known for a first node.
    pub fn is_ready(&self) -> bool {
        !self.read().path.is_empty()
    }

    /// The first instant that is reported without extrapolation.
    pub fn begin(&self) -> Option<TimeTag> {
        self.read().path.front().map(|step| step.node.time)
    }

    /// The last instant that the path reaches.
    pub fn end(&self) -> Option<TimeTag> {
        self.read().path.back().map(|step| step.node.time)
    }

    /// Extrapolates the path to an instant, unless it reaches that far.
    pub fn extend(&self, to: TimeTag) {
        self.write().extend(&self.0, to);
    }

    /// What is reported of an instant. Nothing is allocated. Beyond the path, which nobody should ask, its
    /// end goes straight on.
    pub fn report(&self, t: TimeTag) -> Reported {
        self.read().report(&self.0, t)
    }
}

fn follows_motion(of: &Shared) -> bool {
    matches!(of.attitude(), AttitudeSource::CoordinatedTurn | AttitudeSource::Level)
}
