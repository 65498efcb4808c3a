//! The trajectory of a platform: position, velocity, acceleration, attitude at any instant.
//!
//! A recorded track is a chain of quintic Hermite segments on (position, velocity, acceleration) at its
//! nodes, see [`super::hermite`]: position is C2 (velocity and acceleration are continuous), evaluation depends on
//! the two nodes beside the instant alone, and it is exact at the nodes. Node states come from the fixes
//! ([`super::fit`]), the attitude from [`super::attitude`].
//!
//! A track never extrapolates: outside its span it answers with [`TrackError::OutOfSpan`]. Times are exact
//! ([`TimeTag`]); within a segment they are counted from its first node, so a fix of the year 2018 costs no digits.
//!
//! Positions m, velocities m/s, accelerations m/s^2, all along the scene's East, North, up; the attitude takes
//! body (forward, starboard, down) to ENU; the angular rate is in rad/s along ENU.
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

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use serde::Serialize;
use thiserror::Error;

use super::attitude::{self, MAX_STEP_DEG, MIN_SPEED_MPS, Turn};
use super::deviation::Deviation;
use super::fit::{self, FitReport, MAX_MISFIT_SIGMAS, Node};
use super::hermite::Basis;
use super::live::{LiveTrack, Told};
use super::report::{Report, Reports};
use super::turbulence::{self, TurbulenceFault};
use crate::frames::{Body, Enu, Point, Rotation, SceneFrame, Vector};
use crate::motion::TrackSource;
use crate::motion::changes::PlatformChanges;
use crate::motion::errors::{AxisErrors, Circumstances, ErrorModel, Errors, ErrorsFault};
use crate::motion::gusts::Gusts;
use crate::nav::{self, AttitudeSource, FileSource, Fix, LoadReport, NavError, Place};
use crate::time::TimeTag;

/// How much of a rehearsal lies before the run, s: what servos look back.
const REHEARSED_S: f64 = 2.0;

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

/// Why there is no track, or no state at an instant.
#[derive(Clone, Debug, Error, PartialEq)]
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
    /// Latitudes and longitudes in a scene that lies nowhere on Earth.
    #[error(
        "{}: positions are latitudes and longitudes, but the scene is a plain local frame; \
         give the scene an origin, or the track x_m, y_m, z_m",
        path.display()
    )]
    NoOrigin {
        /// The file.
        path: PathBuf,
    },
    /// A platform is placed by latitude and longitude in a scene that lies nowhere on Earth.
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
        "live navigation is not known beforehand; allowed: track.rehearsal, a track that stands for the flight"
    )]
    NoRehearsal,
    /// A straight track that does not move horizontally has no heading of its own.
    #[error("the heading is to follow the motion, but the horizontal velocity is zero; give an attitude")]
    NoHeading,
    /// The attitude turns too far between two fixes.
    #[error(
        "{}: the attitude turns by {step_deg:.1} deg to the fix at {time}; allowed: {MAX_STEP_DEG} deg between fixes",
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
        "{}: without the outliers there is no fix for {gap_s:.3} s before {time}; longest gap allowed: {allowed_s} s",
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
pub enum SourceError {
    /// Its file cannot be used.
    #[error(transparent)]
    Nav(#[from] NavError),
    /// Its fixes make no track.
    #[error(transparent)]
    Track(#[from] TrackError),
    /// Its errors.
    #[error(transparent)]
    Errors(#[from] ErrorsFault),
    /// Its turbulence.
    #[error(transparent)]
    Turbulence(#[from] TurbulenceFault),
}

/// What became of the file of a recorded track.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SourceReport {
    /// Reading it.
    pub load: LoadReport,
    /// Making a track of it.
    pub fit: FitReport,
}

impl fmt::Display for SourceReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}\n  {}", self.load.path, self.load, self.fit)
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
    /// Another track with motion beside it.
    Moved {
        base: Arc<Track>,
        by: Arc<Deviation>,
    },
    /// Another track as it is reported.
    Reported(Arc<Reports>),
    /// One that grows while it is flown.
    Live(LiveTrack),
}

#[derive(Clone, Debug)]
enum Attitude {
    Constant(Rotation<Body, Enu>),
    Nodes(Arc<[Turn]>),
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
            TrackSource::File(file) => {
                let recording = nav::load(file)?;
                let (track, fit) = Self::recorded(&recording.fixes, frame, file)?;
                Ok((track, Some(SourceReport { load: recording.report, fit })))
            }
            TrackSource::Live(live) => match live.rehearsal.as_deref() {
                Some(TrackSource::File(file)) => {
                    let mut recording = nav::load(file)?;
                    rehearse_at(start, &mut recording.fixes);
                    let (track, fit) = Self::recorded(&recording.fixes, frame, file)?;
                    Ok((track, Some(SourceReport { load: recording.report, fit })))
                }
                Some(rehearsal) => Self::from_source(rehearsal, frame, start),
                None => Err(TrackError::NoRehearsal.into()),
            },
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

    /// The same track through turbulent air, for a run of the given circumstances whose pulse 0 leaves at `start`.
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

    /// Whether it may jump from one instant to the next: a report that is renewed now and then, or wrong by chance.
    pub fn jumps(&self) -> bool {
        let Kind::Reported(reports) = &self.0 else { return false };
        let model = reports.errors.model();
        let jumps = |axis: &AxisErrors| axis.is_random() || axis.step != 0.0;
        model.rate_hz.is_some() || model.quantisation != [0.0; 3] || model.axes.iter().any(jumps)
    }

    /// What a platform whose report this is says at an instant, and how old that is. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Self::state`].
    pub fn report(&self, t: TimeTag) -> Result<Report, TrackError> {
        match &self.0 {
            Kind::Reported(reports) => reports.at(t),
            Kind::Live(live) => {
                let Told { state, age_s, flags, .. } = live.told(t);
                Ok(Report { state, age_s, flags })
            }
            _ => self.state(t).map(Report::of),
        }
    }

    /// Whether the track covers a stretch of time, ends included.
    pub fn covers(&self, from: TimeTag, to: TimeTag) -> Result<(), TrackError> {
        match self.span() {
            Some((first, last)) if first.since(from) > 0.0 || to.since(last) > 0.0 => {
                Err(TrackError::Uncovered { from, to, first, last })
            }
            _ => Ok(()),
        }
    }

    /// The state at an instant. Nothing is allocated.
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
            Kind::Live(live) => Ok(live.told(t).state),
        }
    }
}

/// Moves a recorded rehearsal in time so that the run begins within it, [`REHEARSED_S`] after its first fix, unless it does already.
fn rehearse_at(start: TimeTag, fixes: &mut [Fix]) {
    let (Some(first), Some(last)) = (fixes.first(), fixes.last()) else { return };
    if start.since(first.time) >= 0.0 && last.time.since(start) > 0.0 {
        return;
    }
    let lead_s = REHEARSED_S.min(0.1 * last.time.since(first.time));
    let (begin, from) = (start.plus(-lead_s), first.time);
    for fix in fixes {
        fix.time = begin.plus(fix.time.since(from));
    }
}

fn recorded_state(nodes: &[Node], attitude: &Attitude, t: TimeTag) -> Result<State, TrackError> {
    let (first, last) = (&nodes[0], &nodes[nodes.len() - 1]);
    if !(t >= first.time && t <= last.time) {
        return Err(TrackError::OutOfSpan { asked: t, first: first.time, last: last.time });
    }
    // The last node belongs to the last segment.
    let index = nodes.partition_point(|node| node.time <= t).clamp(1, nodes.len() - 1) - 1;
    let turns = match attitude {
        Attitude::Constant(attitude) => Err(*attitude),
        Attitude::Nodes(turns) => Ok([&turns[index], &turns[index + 1]]),
    };
    Ok(between(&nodes[index], &nodes[index + 1], turns, t))
}

/// The state between two nodes, with a constant attitude or that between theirs.
pub(super) fn between(
    from: &Node,
    to: &Node,
    turns: Result<[&Turn; 2], Rotation<Body, Enu>>,
    t: TimeTag,
) -> State {
    let h = to.time.since(from.time);
    let basis = Basis::at(t.since(from.time) / h, h);
    let rise = to.p - from.p;
    let sum = |w: &[f64; 5]| rise * w[0] + from.v * w[1] + to.v * w[2] + from.a * w[3] + to.a * w[4];
    let (attitude, angular_rate) = match turns {
        Err(attitude) => (attitude, Vector::ZERO),
        Ok([from, to]) => {
            let (q, omega) = attitude::between(from, to, &basis);
            (Rotation::from_raw(q), Vector::from_raw(omega))
        }
    };
    State {
        position: Point::from_raw(from.p + sum(&basis.value)),
        velocity: Vector::from_raw(sum(&basis.first)),
        acceleration: Vector::from_raw(sum(&basis.second)),
        attitude,
        angular_rate,
    }
}

/// Why a node has no attitude.
pub(super) enum NoAttitude {
    /// The motion is too slow to tell a heading: its horizontal speed, m/s.
    Slow(f64),
    /// None was recorded.
    Missing,
}

/// Body-to-ENU attitude of a node, as its source has it.
pub(super) fn attitude_of(
    node: &Node,
    fix: &Fix,
    frame: &SceneFrame,
    source: AttitudeSource,
) -> Result<DQuat, NoAttitude> {
    let axes = fit::to_local_axes(&fix.place, frame);
    let (v, a): (DVec3, DVec3) = (axes * node.v, axes * node.a);
    let derived = |angles: [f64; 3]| {
        let speed_mps = v.truncate().length();
        if speed_mps < MIN_SPEED_MPS { Err(NoAttitude::Slow(speed_mps)) } else { Ok(angles) }
    };
    let [yaw, pitch, roll] = match source {
        AttitudeSource::CoordinatedTurn => derived(attitude::coordinated_turn(v.to_array(), a.to_array()))?,
        AttitudeSource::Level => derived(attitude::level(v.to_array()))?,
        AttitudeSource::Recorded | AttitudeSource::Automatic | AttitudeSource::Constant(_) => {
            fix.yaw_pitch_roll_rad.ok_or(NoAttitude::Missing)?
        }
    };
    let local = Rotation::from_yaw_pitch_roll(yaw, pitch, roll).raw();
    Ok((DQuat::from_mat3(&axes.transpose()) * local).normalize())
}

/// Attitudes of the nodes. Smoothing may have cut fixes from the ends.
fn turns(
    nodes: &[Node],
    fixes: &[Fix],
    frame: &SceneFrame,
    source: &FileSource,
) -> Result<Vec<Turn>, TrackError> {
    let path = || source.path.clone();
    let cut = fixes.partition_point(|fix| fix.time < nodes[0].time);
    let fixes = &fixes[cut..cut + nodes.len()];
    let mut attitudes: Vec<DQuat> = Vec::with_capacity(nodes.len());
    for (node, fix) in nodes.iter().zip(fixes) {
        let attitude = attitude_of(node, fix, frame, source.attitude).map_err(|none| match none {
            NoAttitude::Slow(speed_mps) => {
                TrackError::HeadingUndefined { path: path(), time: node.time, speed_mps }
            }
            NoAttitude::Missing => TrackError::NoAttitude {
                path: path(),
                missing: fixes.iter().filter(|fix| fix.yaw_pitch_roll_rad.is_none()).count(),
                fixes: fixes.len(),
            },
        })?;
        attitudes.push(attitude);
    }
    attitude::turns(&attitudes, |from, to| nodes[to].time.since(nodes[from].time)).map_err(|far| {
        TrackError::AttitudeStep { path: path(), time: nodes[far.node].time, step_deg: far.step_deg }
    })
}
