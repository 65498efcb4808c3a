//! The trajectory of a platform: position, velocity, acceleration, attitude at any instant.
//!
//! A recorded track is a chain of quintic Hermite segments on (position, velocity, acceleration) at its
//! nodes, see [`crate::scene::hermite`]: position is C2 (velocity and acceleration are continuous),
//! evaluation depends on the two nodes beside the instant alone, and it is exact at the nodes. Node states
//! come from the fixes ([`crate::motion::track::fit`]), the attitude from [`super::attitude`].
//!
//! A track never extrapolates: outside its span it answers with [`TrackError::OutOfSpan`]. Times are exact
//! ([`TimeTag`]); within a segment they are counted from its first node, so a fix of the year 2018 costs no
//! digits.
//!
//! Positions m, velocities m/s, accelerations m/s^2, all along the scene's East, North, up; the attitude
//! takes body (forward, starboard, down) to ENU; the angular rate is in rad/s along ENU.
//!
//! ```
//! use nereus::frames::{Point, Vector};
//! use nereus::motion::Track;
//! use nereus::time::TimeTag;
//!
//! let start = TimeTag::new(1_527_705_600, 0.0);
//! let track = Track::straight(Point::new(0.0, 0.0, 3000.0), start, Vector::new(150.0, 0.0, 0.0), None);
//! let state = track.state(start.plus(2.0))?;
//! assert_eq!(state.position.to_array(), [300.0, 0.0, 3000.0]);
//! assert!((state.attitude.to_yaw_pitch_roll()[0].to_degrees() - 90.0).abs() < 1e-12);
//! # Ok::<(), nereus::motion::TrackError>(())
//! ```

mod deviation;
mod fault;
#[doc(hidden)]
pub mod fit;
#[doc(hidden)]
pub mod live;
mod recorded;
mod report;
#[doc(hidden)]
pub mod turbulence;

pub use fault::{
    LEAST_AIRSPEED_MPS, MAX_MISFIT_SIGMAS, MOST_STEPS, SourceError, TrackError, TurbulenceFault,
};
pub use fit::FitReport;
pub use report::Report;

use std::fmt;
use std::sync::Arc;

use serde::Serialize;

use super::{attitude, gate};
use crate::frames::{Body, Enu, Point, Rotation, SceneFrame, Vector};
use crate::motion::changes::PlatformChanges;
use crate::motion::errors::{AxisErrors, Circumstances, ErrorModel, Errors};
use crate::motion::gusts::Gusts;
use crate::nav::TrackSource;
use crate::nav::{self, AttitudeSource, FileSource, Fix, LoadReport, NavError, Place, Smoothing};
use crate::scene::trajectory::Knot;
use crate::time::TimeTag;
use deviation::Deviation;
use fit::Node;
use live::{LiveTrack, Reported};
use recorded::{Attitude, recorded_state, shift_to, turns};
use report::Reports;

/// Where a platform is, and how it moves, at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Position.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Acceleration, m/s^2.
    pub acceleration: Vector<Enu>,
    /// Attitude.
    pub attitude: Rotation<Body, Enu>,
    /// Angular rate of the body, rad/s, components along ENU.
    pub angular_rate: Vector<Enu>,
}

/// What became of the file of a recorded track.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SourceReport {
    /// Reading it.
    pub load: LoadReport,
    /// Making a track of it.
    pub fit: FitReport,
}

impl SourceReport {
    /// Whether something was skipped, filled in, set right or refused.
    pub fn is_noted(&self) -> bool {
        let FitReport { rejected_horizontal, rejected_vertical, .. } = self.fit;
        !self.load.notes().is_empty() || rejected_horizontal + rejected_vertical > 0
    }
}

impl fmt::Display for SourceReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}\n  {}", self.load.path, self.load, self.fit)
    }
}

/// Whether fixes that were refused left gaps that are not interpolated.
fn without_gaps(fixes: &[Fix], file: &FileSource) -> Result<(), TrackError> {
    let gap = |pair: &[Fix]| (pair[1].time, pair[1].time.since(pair[0].time));
    match fixes.windows(2).map(gap).find(|(_, gap_s)| *gap_s > file.max_gap_s) {
        None => Ok(()),
        Some((time, gap_s)) => {
            let (path, allowed_s) = (file.path.clone(), file.max_gap_s);
            Err(TrackError::RejectedGap { path, time, gap_s, allowed_s })
        }
    }
}

/// A trajectory. Cheap to clone; clones share their nodes.
#[derive(Clone, Debug)]
pub struct Track(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Straight {
        position: Point<Enu>,
        at: TimeTag,
        velocity: Vector<Enu>,
        attitude: Rotation<Body, Enu>,
    },
    Recorded {
        nodes: Arc<[Node]>,
        attitude: Attitude,
    },
    /// Another track with motion about it.
    Moved {
        base: Arc<Track>,
        by: Arc<Deviation>,
    },
    /// Another track as it is reported.
    Reported(Arc<Reports>),
    /// One that grows while it is flown.
    Live(LiveTrack),
}

impl Track {
    /// Stays at a place.
    pub fn fixed(position: Point<Enu>, attitude: Rotation<Body, Enu>) -> Self {
        Self(Kind::Straight { position, at: TimeTag::default(), velocity: Vector::ZERO, attitude })
    }

    /// A straight line through `position` at the instant `at`, at constant velocity. Without an attitude
    /// the nose follows the velocity and the wings are level; a velocity without horizontal part looks
    /// North.
    pub fn straight(
        position: Point<Enu>,
        at: TimeTag,
        velocity: Vector<Enu>,
        attitude: Option<Rotation<Body, Enu>>,
    ) -> Self {
        let attitude = attitude.unwrap_or_else(|| {
            let [yaw, pitch, roll] = attitude::coordinated_turn(velocity.to_array(), [0.0; 3]);
            Rotation::from_yaw_pitch_roll(yaw, pitch, roll)
        });
        Self(Kind::Straight { position, at, velocity, attitude })
    }

    /// A smooth track through recorded fixes, as the source asks for it.
    ///
    /// # Errors
    /// Fixes that make no track: too few, gaps, jumps, places that are not in the scene.
    pub fn recorded(
        fixes: &[Fix],
        frame: &SceneFrame,
        source: &FileSource,
    ) -> Result<(Self, FitReport), TrackError> {
        let derived = source.attitude == AttitudeSource::Automatic
            && fixes.iter().all(|fix| fix.yaw_pitch_roll_rad.is_none());
        let source = &FileSource {
            attitude: match source.attitude {
                AttitudeSource::Automatic if derived => AttitudeSource::CoordinatedTurn,
                AttitudeSource::Automatic => AttitudeSource::Recorded,
                chosen => chosen,
            },
            ..source.clone()
        };
        let (nodes, mut report) = fit::nodes(fixes, frame, source)?;
        report.attitude_derived = derived;
        let attitude = match source.attitude {
            AttitudeSource::Constant(attitude) => Attitude::Constant(attitude),
            _ => Attitude::Nodes(turns(&nodes, fixes, frame, source)?.into()),
        };
        Ok((Self(Kind::Recorded { nodes: nodes.into(), attitude }), report))
    }

    /// The track of any source; `start` is the emission of pulse 0. A file is read here.
    ///
    /// # Errors
    /// A file that cannot be read, fixes that make no track, or a place that is not in the scene.
    pub fn from_source(
        source: &TrackSource,
        frame: &SceneFrame,
        start: TimeTag,
    ) -> Result<(Self, Option<SourceReport>), SourceError> {
        let locate = |place: &Place| match place {
            Place::Local(point) => Ok(*point),
            Place::Geodetic(geodetic) => frame.from_geodetic(*geodetic).ok_or(TrackError::PlaceNeedsOrigin),
        };
        match source {
            TrackSource::Fixed { place, attitude } => Ok((Self::fixed(locate(place)?, *attitude), None)),
            TrackSource::Straight { place, velocity, attitude } => {
                let [east, north, _] = velocity.to_array();
                if attitude.is_none() && east == 0.0 && north == 0.0 {
                    return Err(TrackError::NoHeading.into());
                }
                Ok((Self::straight(locate(place)?, start, *velocity, *attitude), None))
            }
            TrackSource::File(file) => Self::from_file(file, frame, None),
            TrackSource::Live(live) => match live.nominal.as_deref() {
                Some(TrackSource::File(file)) => Self::from_file(file, frame, Some(start)),
                Some(nominal) => Self::from_source(nominal, frame, start),
                None => Err(TrackError::NoRehearsal.into()),
            },
        }
    }

    /// The track of a file, moved in time to where a run begins if it is to be.
    fn from_file(
        file: &FileSource,
        frame: &SceneFrame,
        start: Option<TimeTag>,
    ) -> Result<(Self, Option<SourceReport>), SourceError> {
        let made = |file: &FileSource, mut recording: nav::Recording| {
            if let Some(start) = start {
                shift_to(start, &mut recording.fixes);
            }
            let is_exact = file.smoothing == Smoothing::Off;
            let refused = match is_exact {
                true => gate::plausible(&mut recording.fixes, frame, file.bounds),
                false => gate::Refusals::default(),
            };
            if refused.implausible > 0 {
                without_gaps(&recording.fixes, file)?;
            }
            let (track, mut fit) = Self::recorded(&recording.fixes, frame, file)?;
            fit.refused = refused;
            fit.possible_acceleration_mps2 = is_exact.then_some(file.bounds.max_acceleration_mps2);
            Ok((track, Some(SourceReport { load: recording.report, fit })))
        };
        let gaps = match nav::load(file) {
            Ok(recording) => return made(file, recording).map_err(SourceError::Track),
            Err(NavError::Faulty { path, faults }) if faults.are_gaps() => NavError::Faulty { path, faults },
            Err(error) => return Err(error.into()),
        };
        // What else is wrong is reported with them.
        let patient = FileSource { max_gap_s: f64::INFINITY, ..file.clone() };
        match nav::load(&patient).map(|recording| made(&patient, recording)) {
            Ok(Err(track)) => Err(SourceError::Gaps { gaps: Box::new(gaps), track: Box::new(track) }),
            _ => Err(gaps.into()),
        }
    }

    /// A trajectory that grows while it is flown.
    pub fn live(track: LiveTrack) -> Self {
        Self(Kind::Live(track))
    }

    /// The trajectory that grows, if it is one.
    pub fn as_live(&self) -> Option<&LiveTrack> {
        match &self.0 {
            Kind::Live(live) => Some(live),
            _ => None,
        }
    }

    /// First and last instant of the track; `None` if it has no end.
    pub fn span(&self) -> Option<(TimeTag, TimeTag)> {
        match &self.0 {
            Kind::Straight { .. } => None,
            Kind::Recorded { nodes, .. } => Some((nodes.first()?.time, nodes.last()?.time)),
            Kind::Moved { base, by } => match (base.span(), by.span()) {
                (Some((a, b)), Some((c, d))) => {
                    Some((if c.since(a) > 0.0 { c } else { a }, if d.since(b) < 0.0 { d } else { b }))
                }
                (one, other) => one.or(other),
            },
            Kind::Reported(reports) => reports.base.span(),
            // It reaches as far as it is asked for.
            Kind::Live(_) => None,
        }
    }

    /// The knots of a recorded track, at times after pulse 0; `None` of others.
    pub fn knots(&self, start: TimeTag) -> Option<Vec<Knot>> {
        let Kind::Recorded { nodes, .. } = &self.0 else { return None };
        let knot = |node: &Node| Knot {
            time_s: node.time.since(start),
            position: Point::from_raw(node.p),
            velocity: Vector::from_raw(node.v),
            acceleration: Vector::from_raw(node.a),
        };
        Some(nodes.iter().map(knot).collect())
    }

    /// The same track through turbulent air, for a run of the given circumstances whose pulse 0 leaves at
    /// `start`.
    ///
    /// # Errors
    /// A platform that stands, a run that is too long, a track that does not cover pulse 0.
    pub fn in_gusts(
        &self,
        gusts: &Gusts,
        frame: &SceneFrame,
        of: &Circumstances,
        start: TimeTag,
    ) -> Result<Self, SourceError> {
        let by = turbulence::deviation(self, gusts, frame, of, start)?;
        Ok(Self(Kind::Moved { base: Arc::new(self.clone()), by: Arc::new(by) }))
    }

    /// The truth, if this track is a report that is wrong by a model.
    ///
    /// # Errors
    /// Errors that jump, and series that are too long.
    pub fn less_errors(
        &self,
        model: &ErrorModel,
        of: &Circumstances,
        start: TimeTag,
    ) -> Result<Self, SourceError> {
        let by = Deviation::short_of(model, of, start)?;
        Ok(Self(Kind::Moved { base: Arc::new(self.clone()), by: Arc::new(by) }))
    }

    /// This track as it is reported by a platform whose reports are wrong by a model.
    ///
    /// # Errors
    /// A model without meaning, and series that are too long.
    pub fn with_errors(
        &self,
        model: &ErrorModel,
        of: &Circumstances,
        start: TimeTag,
    ) -> Result<Self, SourceError> {
        let errors = Errors::new(model, of)?;
        let (base, changes) = (self.clone(), None);
        Ok(Self(Kind::Reported(Arc::new(Reports { base, errors, start, right: false, changes }))))
    }

    /// This track as it is reported by a platform whose reports are changed while the run goes on.
    ///
    /// # Errors
    /// None of a sound run.
    pub fn with_changes(
        self,
        changes: &Arc<PlatformChanges>,
        of: &Circumstances,
        start: TimeTag,
    ) -> Result<Self, SourceError> {
        let changes = Some(Arc::clone(changes));
        let reports = match self.0 {
            Kind::Reported(reports) => {
                Reports { changes, ..Arc::try_unwrap(reports).unwrap_or_else(|shared| (*shared).clone()) }
            }
            other => {
                let errors = Errors::new(&ErrorModel::default(), of)?;
                Reports { base: Self(other), errors, start, right: true, changes }
            }
        };
        Ok(Self(Kind::Reported(Arc::new(reports))))
    }

    /// What changes of this report while the run goes on.
    pub fn changes(&self) -> Option<&PlatformChanges> {
        match &self.0 {
            Kind::Reported(reports) => reports.changes.as_deref(),
            _ => None,
        }
    }

    /// Whether it may jump from one instant to the next: a report that is renewed now and then, or wrong by
    /// chance.
    pub fn jumps(&self) -> bool {
        let Kind::Reported(reports) = &self.0 else { return false };
        let model = reports.errors.model();
        let jumps = |axis: &AxisErrors| axis.is_random() || axis.step != 0.0;
        model.rate_hz.is_some() || model.quantisation != [0.0; 3] || model.axes.iter().any(jumps)
    }

    /// What the platform reports at an instant, and how old that is. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Self::state`].
    pub fn report(&self, t: TimeTag) -> Result<Report, TrackError> {
        match &self.0 {
            Kind::Reported(reports) => reports.at(t),
            Kind::Live(live) => {
                let Reported { state, age_s, flags, .. } = live.report(t);
                Ok(Report { state, age_s, flags })
            }
            _ => self.state(t).map(Report::of),
        }
    }

    /// Whether the track covers a stretch of time, ends included.
    ///
    /// # Errors
    /// The part that is missing.
    pub fn covers(&self, from: TimeTag, to: TimeTag) -> Result<(), TrackError> {
        match self.span() {
            Some((first, last)) if first.since(from) > 0.0 || to.since(last) > 0.0 => {
                Err(TrackError::Uncovered { from, to, first, last })
            }
            _ => Ok(()),
        }
    }

    /// The state at an instant. Nothing is allocated.
    ///
    /// # Errors
    /// An instant that the track does not cover.
    pub fn state(&self, t: TimeTag) -> Result<State, TrackError> {
        match &self.0 {
            Kind::Straight { position, at, velocity, attitude } => Ok(State {
                position: *position + *velocity * t.since(*at),
                velocity: *velocity,
                acceleration: Vector::ZERO,
                attitude: *attitude,
                angular_rate: Vector::ZERO,
            }),
            Kind::Recorded { nodes, attitude } => recorded_state(nodes, attitude, t),
            Kind::Moved { base, by } => by.moved(&base.state(t)?, t),
            Kind::Reported(reports) => Ok(reports.at(t)?.state),
            Kind::Live(live) => Ok(live.report(t).state),
        }
    }
}
