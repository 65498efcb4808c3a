//! A trajectory that grows: fixes come while the run goes on.
//!
//! What has been told once never changes: the path is a chain of nodes to which more are added and of which
//! none is altered, joined by quintic segments as in a recorded track ([`crate::motion::track`]).
//!
//! * **Interpolated.** A node is the fix itself, its derivatives those of the polynomial through its seven
//!   nearest fixes ([`crate::motion::hermite`]); it is reported once the three fixes after it have come (six
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
//! assert!((track.told(at(3)).state.velocity.norm() - 50.0).abs() < 1e-9);
//! # Ok::<(), nereus::motion::track::live::Unusable>(())
//! ```

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock, PoisonError, RwLock};
use std::time::Instant;

use glam::{DVec3, DVec4};
use thiserror::Error;

use super::fit::{Node, exact_node, position, to_local_axes};
use crate::frames::{Enu, Point, Rotation, SceneFrame, Vector};
use crate::motion::attitude::{Turn, turn};
use crate::motion::hermite::{Basis, STENCIL, stencil};
use crate::motion::track::State;
use crate::motion::track::recorded::{NoAttitude, attitude_of, between};
use crate::nav::{AttitudeSource, Fix};
use crate::pulse::flags;
use crate::time::TimeTag;

/// How long the path is kept behind its end, s: more than any servo lag or latency of a report.
pub const KEPT_S: f64 = 300.0;
/// Acceleration with which a path goes back to its fixes, m/s^2.
const REJOIN_MPS2: f64 = 20.0;
/// Rate at which an attitude does, rad/s.
const REJOIN_RAD_S: f64 = 0.5;
/// The shortest time in which it does, s.
const REJOIN_S: f64 = 0.3;
/// Fixes whose polynomial gives the derivatives where no more are there.
const FEW: usize = 3;
/// Metres, metres per second and parts of a turn that are no way to go.
const NOTHING: f64 = 1e-9;
/// Ways back at a time; then they become one.
const MOST_WAYS: usize = 64;
/// Fixes that are kept behind the last node.
const BEHIND: usize = 2 * STENCIL;

/// A fix of which no node can be made.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Unusable {
    /// Latitude and longitude in a scene that lies nowhere on Earth, or numbers that are not finite.
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
    /// [`flags::NAV_EXTRAPOLATED`], [`flags::NAV_STALE`].
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

/// What a node rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rests {
    Fixes,
    Past,
    Stale,
}

/// A node of the path.
#[derive(Clone, Copy, Debug)]
struct Step {
    node: Node,
    turn: Turn,
    rests: Rests,
    /// Time and arrival of the fix that it is, or is extrapolated from.
    fix: TimeTag,
    arrived: Instant,
    /// Beside what the fixes say.
    adrift: bool,
}

/// A fix of the run of fixes at hand.
#[derive(Clone, Copy, Debug)]
struct Entry {
    fix: Fix,
    p: DVec3,
    arrived: Instant,
    node: Option<Node>,
    q: Option<DVec4>,
}

#[derive(Debug, Default)]
struct Grown {
    path: VecDeque<Step>,
    /// Fixes without a gap; the first one has number `base`.
    run: VecDeque<Entry>,
    base: usize,
    /// Nodes and turns that have been made.
    nodes: usize,
    turned: usize,
    /// A gap lies before the next node.
    after_gap: bool,
    /// Steps that wait until the path, adrift, can go back to them.
    waiting: VecDeque<Step>,
    /// Ways back that are under way; what is left of each adds up.
    ways: Vec<Back>,
    /// Fixes are followed again, beside them by what is left.
    follows: bool,
    last_attitude: Option<DVec4>,
}

/// Value, first and second derivative of position and quaternion.
#[derive(Clone, Copy, Debug)]
struct Jets {
    p: [DVec3; 3],
    q: [DVec4; 3],
}

/// The way back from what was reported to what is known.
#[derive(Clone, Copy, Debug)]
struct Back {
    from: TimeTag,
    span_s: f64,
    offset: Jets,
}

impl Jets {
    fn of(step: &Step) -> Self {
        let (node, turn) = (&step.node, &step.turn);
        Self { p: [node.p, node.v, node.a], q: [turn.q, turn.first, turn.second] }
    }

    fn combined(self, other: Self, sign: f64) -> Self {
        Self {
            p: std::array::from_fn(|i| self.p[i] + other.p[i] * sign),
            q: std::array::from_fn(|i| self.q[i] + other.q[i] * sign),
        }
    }

    /// Between two steps.
    fn between(from: &Step, to: &Step, t: TimeTag) -> Self {
        let h = to.node.time.since(from.node.time);
        let rows = Basis::at(t.since(from.node.time) / h, h).rows();
        let (a, b) = (Self::of(from), Self::of(to));
        let along = |w: &[f64; 5], a: [DVec3; 3], b: [DVec3; 3]| {
            (b[0] - a[0]) * w[0] + a[1] * w[1] + b[1] * w[2] + a[2] * w[3] + b[2] * w[4]
        };
        let around = |w: &[f64; 5], a: [DVec4; 3], b: [DVec4; 3]| {
            (b[0] - a[0]) * w[0] + a[1] * w[1] + b[1] * w[2] + a[2] * w[3] + b[2] * w[4]
        };
        let mut jets = Self { p: rows.map(|w| along(&w, a.p, b.p)), q: rows.map(|w| around(&w, a.q, b.q)) };
        jets.p[0] += a.p[0];
        jets.q[0] += a.q[0];
        jets
    }
}

impl Back {
    fn of(from: TimeTag, offset: Jets) -> Self {
        let [away, apart, _] = offset.p.map(DVec3::length);
        // Of a small turn, the length of the difference of quaternions is half the angle.
        let turn_rad = 2.0 * offset.q[0].length().min(std::f64::consts::SQRT_2);
        let span_s = REJOIN_S
            .max((5.8 * away / REJOIN_MPS2).sqrt())
            .max(4.0 * apart / REJOIN_MPS2)
            .max(1.9 * turn_rad / REJOIN_RAD_S);
        Self { from, span_s, offset }
    }

    fn is_over(&self, t: TimeTag) -> bool {
        t.since(self.from) >= self.span_s
    }

    /// What is left of the offset.
    fn left(&self, t: TimeTag) -> Jets {
        let rows = Basis::at(t.since(self.from) / self.span_s, self.span_s).rows();
        let Jets { p, q } = self.offset;
        let mut left = Jets {
            p: rows.map(|w| p[0] * -w[0] + p[1] * w[1] + p[2] * w[3]),
            q: rows.map(|w| q[0] * -w[0] + q[1] * w[1] + q[2] * w[3]),
        };
        left.p[0] += p[0];
        left.q[0] += q[0];
        left
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
    pub fn told(&self, t: TimeTag) -> Reported {
        self.read().told(&self.0, t)
    }
}

impl Grown {
    fn count(&self) -> usize {
        self.base + self.run.len()
    }

    fn entry(&self, number: usize) -> &Entry {
        &self.run[number - self.base]
    }

    fn push(&mut self, of: &Shared, mut entry: Entry) -> Result<(), Unusable> {
        if let Some(before) = self.run.back() {
            let gap_s = entry.fix.time.since(before.fix.time);
            if gap_s <= 0.0 {
                return Err(Unusable::NotLater);
            }
            if gap_s > of.max_gap_s {
                self.end_run(of);
            }
        }
        if of.attitude() == AttitudeSource::Recorded
            && entry.fix.yaw_pitch_roll_rad.is_none()
            && self.last_attitude.is_none()
        {
            return Err(Unusable::NoAttitude);
        }
        if !follows_motion(of) {
            // Needs no derivatives.
            let still = Node { time: entry.fix.time, p: entry.p, v: DVec3::ZERO, a: DVec3::ZERO };
            entry.q = Some(self.attitude(of, &still, &entry.fix));
        }
        self.run.push_back(entry);
        self.advance(of);
        Ok(())
    }

    /// Makes nodes of all fixes whose neighbours have come, and hands them on.
    fn advance(&mut self, of: &Shared) {
        let count = self.count();
        while count >= STENCIL.max(self.nodes + STENCIL / 2 + 1) {
            let number = self.nodes;
            let node = exact_node(number, stencil(number, count), |n| {
                let entry = self.entry(n);
                (entry.fix.time, entry.p)
            });
            let q = match self.entry(number).q {
                Some(q) => q,
                None => self.attitude(of, &node, &self.entry(number).fix.clone()),
            };
            let entry = &mut self.run[number - self.base];
            (entry.node, entry.q) = (Some(node), Some(q));
            self.nodes += 1;
        }
        let turnable = if follows_motion(of) { self.nodes } else { count };
        while turnable >= STENCIL.max(self.turned + STENCIL / 2 + 1) && self.turned < self.nodes {
            let number = self.turned;
            let step = self.step(number, stencil(number, turnable));
            self.turned += 1;
            if let Some(step) = step {
                self.hand_on(of, step);
            }
        }
        // What no stencil needs any more.
        let least = self.nodes.min(self.turned);
        while self.base + BEHIND < least {
            self.run.pop_front();
            self.base += 1;
        }
    }

    /// The step of a fix that has a node, its turn from the attitudes of a stencil.
    fn step(&self, number: usize, around: std::ops::Range<usize>) -> Option<Step> {
        let entry = self.entry(number);
        let (node, q) = (entry.node?, entry.q?);
        let of = |n: usize| self.entry(n).q.unwrap_or(q);
        let turn = turn(number, around, of, |n| self.entry(n).fix.time.since(entry.fix.time));
        let (fix, arrived) = (entry.fix.time, entry.arrived);
        Some(Step { node, turn, rests: Rests::Fixes, fix, arrived, adrift: false })
    }

    /// The attitude of a node, its sign that of the one before. One that cannot be reported is that of the
    /// one before, or level to the North.
    fn attitude(&mut self, of: &Shared, node: &Node, fix: &Fix) -> DVec4 {
        let found = attitude_of(node, fix, &of.frame, of.attitude()).map(DVec4::from);
        let before = self.last_attitude;
        let mut q = match found {
            Ok(q) => q,
            Err(NoAttitude::Slow(_) | NoAttitude::Missing) => before.unwrap_or_else(|| {
                let level: Rotation<crate::frames::Body, Enu> = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
                DVec4::from(level.raw())
            }),
        };
        if before.is_some_and(|before| before.dot(q) < 0.0) {
            q = -q;
        }
        self.last_attitude = Some(q);
        q
    }

    /// Adds a step to the path, or keeps it until the path can go back to it.
    fn hand_on(&mut self, of: &Shared, mut step: Step) {
        let Some(end) = self.path.back().copied() else {
            self.path.push_back(step);
            return;
        };
        if end.adrift && !self.follows {
            self.waiting.push_back(step);
            self.go_back(of);
            return;
        }
        if step.node.time.since(end.node.time) <= 0.0 {
            return;
        }
        step = self.with_what_is_left(step);
        if std::mem::take(&mut self.after_gap) {
            step.rests = step.rests.max(Rests::Past);
        }
        self.append(step);
    }

    fn append(&mut self, step: Step) {
        self.path.push_back(step);
        while self.path.len() > 2 && step.node.time.since(self.path[1].node.time) > KEPT_S {
            self.path.pop_front();
        }
    }

    /// Sets out from the end of the path for what is known now of its instant.
    fn set_out(&mut self, end: &Step, known: Jets) {
        let t = end.node.time;
        self.ways.retain(|way| !way.is_over(t));
        if self.ways.len() >= MOST_WAYS {
            self.ways.clear();
        }
        let planned = self.ways.iter().fold(known, |sum, way| sum.combined(way.left(t), 1.0));
        let offset = Jets::of(end).combined(planned, -1.0);
        if offset.p[0].length() > NOTHING || offset.p[1].length() > NOTHING || offset.q[0].length() > NOTHING
        {
            self.ways.push(Back::of(t, offset));
        }
    }

    /// A step beside the fixes by what is left of all ways back.
    fn with_what_is_left(&mut self, step: Step) -> Step {
        let t = step.node.time;
        self.ways.retain(|way| !way.is_over(t));
        if self.ways.is_empty() {
            return step;
        }
        let jets = self.ways.iter().fold(Jets::of(&step), |sum, way| sum.combined(way.left(t), 1.0));
        Step { adrift: true, ..beside(step, jets) }
    }

    /// Leads a path that is adrift back to the fixes, once they reach beyond its end.
    fn go_back(&mut self, of: &Shared) {
        let Some(end) = self.path.back().copied() else { return };
        while self.waiting.len() > 1 && self.waiting[1].node.time.since(end.node.time) <= 0.0 {
            self.waiting.pop_front();
        }
        let [Some(from), Some(to)] = [0, 1].map(|i| self.waiting.get(i).copied()) else { return };
        if from.node.time.since(end.node.time) > 0.0 {
            return;
        }
        self.set_out(&end, Jets::between(&from, &to, end.node.time));
        self.follows = true;
        self.waiting.pop_front();
        while let Some(step) = self.waiting.pop_front() {
            self.hand_on(of, step);
        }
    }

    fn jump(&mut self, of: &Shared, at: TimeTag) {
        // Straight on first: a path that led from one place to the other between two fixes would fly at any
        // speed.
        self.extend(of, at);
        if self.path.is_empty() {
            self.run.clear();
            (self.base, self.nodes, self.turned) = (0, 0, 0);
        } else {
            self.end_run(of);
        }
    }

    /// A gap: the fixes so far are all there will be of this run.
    fn end_run(&mut self, of: &Shared) {
        let to = self.run.back().map(|entry| entry.fix.time);
        self.hurry(of, to);
        self.run.clear();
        self.waiting.clear();
        (self.base, self.nodes, self.turned) = (0, 0, 0);
        self.after_gap = true;
    }

    /// Makes steps of the fixes at hand, up to the first at or after an instant.
    fn hurry(&mut self, of: &Shared, to: Option<TimeTag>) {
        let count = self.count();
        for number in self.turned..count {
            let end = self.path.back().copied();
            if let (Some(end), Some(to)) = (end, to)
                && to.since(end.node.time) <= 0.0
            {
                return;
            }
            let time = self.entry(number).fix.time;
            if end.is_some_and(|end| time.since(end.node.time) <= 0.0) {
                continue;
            }
            let Some(mut step) = self.hasty(of, number) else { continue };
            step.rests = Rests::Past;
            if let Some(end) = end.filter(|end| end.adrift) {
                let Some(known) = self.known_by_now(of, end.node.time) else { continue };
                self.set_out(&end, known);
                self.follows = false;
                step = self.with_what_is_left(step);
            }
            self.append(step);
        }
    }

    /// A step from the few fixes at hand.
    fn hasty(&self, of: &Shared, number: usize) -> Option<Step> {
        let count = self.count();
        if count - self.base < 2 {
            return None;
        }
        let first = number.saturating_sub(FEW - 1).max(self.base).min(count - FEW.min(count - self.base));
        let around = first..(first + FEW).min(count);
        let entry = self.entry(number);
        let node = exact_node(number, around.clone(), |n| {
            let entry = self.entry(n);
            (entry.fix.time, entry.p)
        });
        let q = entry.q.or(self.last_attitude)?;
        let turn = match follows_motion(of) {
            // Attitudes of its neighbours are not known yet.
            true => Turn { q, first: DVec4::ZERO, second: DVec4::ZERO },
            false => {
                let near = |n: usize| self.entry(n).q.unwrap_or(q);
                turn(number, around, near, |n| self.entry(n).fix.time.since(entry.fix.time))
            }
        };
        let (fix, arrived) = (entry.fix.time, entry.arrived);
        Some(Step { node, turn, rests: Rests::Past, fix, arrived, adrift: false })
    }

    /// What the fixes at hand say of an instant.
    fn known_by_now(&self, of: &Shared, t: TimeTag) -> Option<Jets> {
        let after = self.run.iter().position(|entry| entry.fix.time.since(t) > 0.0);
        let Some(after) = after.filter(|_| self.run.len() > 1) else { return self.known(of, t) };
        let at = |place: usize| self.hasty(of, self.base + place);
        if after > 0 {
            return Some(Jets::between(&at(after - 1)?, &at(after)?, t));
        }
        let first = at(0)?;
        let Jets { p: [p, v, a], q } = Jets::of(&first);
        let dt = t.since(first.node.time);
        Some(Jets { p: [p + (v + a * (0.5 * dt)) * dt, v + a * dt, a], q: [q[0], DVec4::ZERO, DVec4::ZERO] })
    }

    /// What the last fix says of an instant: on from there at constant velocity, the attitude held.
    fn known(&self, of: &Shared, t: TimeTag) -> Option<Jets> {
        let last = self.run.back()?;
        let dt = t.since(last.fix.time);
        let sent = last.fix.velocity_mps.map(|[east, north]| {
            let up = last.fix.climb_mps.unwrap_or(0.0);
            to_local_axes(&last.fix.place, &of.frame).transpose() * DVec3::new(east, north, up)
        });
        let v = match sent {
            Some(v) => v,
            None if self.run.len() > 1 => {
                let before = &self.run[self.run.len().saturating_sub(FEW)];
                (last.p - before.p) / last.fix.time.since(before.fix.time)
            }
            None => self.path.back()?.node.v,
        };
        let q = last.q.or(self.last_attitude)?;
        Some(Jets { p: [last.p + v * dt, v, DVec3::ZERO], q: [q, DVec4::ZERO, DVec4::ZERO] })
    }

    fn extend(&mut self, of: &Shared, to: TimeTag) {
        let short = |grown: &Self| grown.path.back().is_none_or(|end| to.since(end.node.time) > 0.0);
        if !short(self) {
            return;
        }
        self.hurry(of, Some(to));
        if !short(self) {
            return;
        }
        let Some(last) = self.run.back().copied() else { return };
        let Some(end) = self.path.back().copied() else { return };
        let (Some(here), Some(then)) = (self.known(of, end.node.time), self.known(of, to)) else { return };
        self.set_out(&end, here);
        self.follows = false;
        let stale = to.since(last.fix.time) > of.max_extrapolation_s;
        let [p, v, a] = then.p;
        let [q, first, second] = then.q;
        let on = Step {
            node: Node { time: to, p, v, a },
            turn: Turn { q, first, second },
            rests: if stale { Rests::Stale } else { Rests::Past },
            fix: last.fix.time,
            arrived: last.arrived,
            adrift: true,
        };
        let step = self.with_what_is_left(on);
        self.append(step);
        self.go_back(of);
    }

    fn told(&self, of: &Shared, t: TimeTag) -> Reported {
        let still = State {
            position: Point::new(0.0, 0.0, 0.0),
            velocity: Vector::ZERO,
            acceleration: Vector::ZERO,
            attitude: Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0),
            angular_rate: Vector::ZERO,
        };
        let (Some(first), Some(last)) = (self.path.front(), self.path.back()) else {
            let flags = flags::NAV_EXTRAPOLATED | flags::NAV_STALE;
            return Reported { state: still, age_s: 0.0, flags, arrived: None };
        };
        let constant = match of.attitude() {
            AttitudeSource::Constant(attitude) => Some(attitude),
            _ => None,
        };
        // Straight on from an end.
        let beyond = |step: &Step| {
            let dt = t.since(step.node.time);
            State {
                position: Point::from_raw(step.node.p + step.node.v * dt),
                velocity: Vector::from_raw(step.node.v),
                attitude: constant
                    .unwrap_or_else(|| Rotation::from_raw(glam::DQuat::from_vec4(step.turn.q.normalize()))),
                ..still
            }
        };
        let rest = |rests: Rests, step: &Step| {
            let stale = if rests == Rests::Stale { flags::NAV_STALE } else { 0 };
            let (age_s, flags) = match rests {
                Rests::Fixes => (0.0, 0),
                _ => (t.since(step.fix).max(0.0), flags::NAV_EXTRAPOLATED | stale),
            };
            (age_s, flags, Some(step.arrived))
        };
        let (state, rests) = if first.node.time.since(t) > 0.0 {
            (beyond(first), rest(Rests::Past, first))
        } else if t > last.node.time {
            (beyond(last), rest(last.rests.max(Rests::Past), last))
        } else if self.path.len() < 2 {
            (beyond(last), rest(last.rests, last))
        } else {
            let index =
                self.path.partition_point(|step| step.node.time <= t).clamp(1, self.path.len() - 1) - 1;
            let (from, to) = (&self.path[index], &self.path[index + 1]);
            if t == last.node.time {
                // As it will be when there is a node behind it, to the last bit.
                let next = Node { time: t.plus(1.0), ..last.node };
                let turns = constant.map_or(Ok([&last.turn; 2]), Err);
                return told_of(between(&last.node, &next, turns, t), rest(last.rests, last));
            }
            let turns = constant.map_or(Ok([&from.turn, &to.turn]), Err);
            // At a node the segment before it is no matter.
            let rests = if t == from.node.time { from.rests } else { from.rests.max(to.rests) };
            (between(&from.node, &to.node, turns, t), rest(rests, from))
        };
        told_of(state, rests)
    }
}

fn told_of(state: State, (age_s, flags, arrived): (f64, u32, Option<Instant>)) -> Reported {
    Reported { state, age_s, flags, arrived }
}

/// The same step elsewhere.
fn beside(step: Step, jets: Jets) -> Step {
    let Jets { p, q } = jets;
    Step {
        node: Node { time: step.node.time, p: p[0], v: p[1], a: p[2] },
        turn: Turn { q: q[0], first: q[1], second: q[2] },
        rests: step.rests.max(Rests::Past),
        ..step
    }
}

fn follows_motion(of: &Shared) -> bool {
    matches!(of.attitude(), AttitudeSource::CoordinatedTurn | AttitudeSource::Level)
}
