//! The path itself: how fixes become nodes, and what it reports of an instant.

use std::collections::VecDeque;
use std::time::Instant;

use glam::{DVec3, DVec4};

use super::jets::{Back, Jets, Rests, Step, beside};
use super::{KEPT_S, Reported, Shared, Unusable, follows_motion};
use crate::frames::{Enu, Point, Rotation, Vector};
use crate::motion::attitude::{Turn, turn};
use crate::motion::place::to_local_axes;
use crate::motion::track::State;
use crate::motion::track::fit::{Node, exact_node};
use crate::motion::track::recorded::{NoAttitude, attitude_of, between};
use crate::nav::{AttitudeSource, Fix};
use crate::pulse::flags;
use crate::scene::hermite::{STENCIL, stencil};
use crate::time::TimeTag;

/// Fixes whose polynomial gives the derivatives where no more are there.
const FEW: usize = 3;
/// Metres, metres per second and parts of a turn that are no way to go.
const NOTHING: f64 = 1e-9;
/// Ways back at a time; then they become one.
const MOST_WAYS: usize = 64;
/// Fixes that are kept behind the last node.
const BEHIND: usize = 2 * STENCIL;

/// A fix of the run of fixes at hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) fix: Fix,
    pub(super) p: DVec3,
    pub(super) arrived: Instant,
    pub(super) node: Option<Node>,
    pub(super) q: Option<DVec4>,
}

#[derive(Debug, Default)]
pub(super) struct Grown {
    pub(super) path: VecDeque<Step>,
    /// Fixes without a gap; the first one has number `base`.
    pub(super) run: VecDeque<Entry>,
    pub(super) base: usize,
    /// Nodes and turns that have been made.
    pub(super) nodes: usize,
    pub(super) turned: usize,
    /// A gap lies before the next node.
    pub(super) after_gap: bool,
    /// Steps that wait until the path, adrift, can go back to them.
    pub(super) waiting: VecDeque<Step>,
    /// Ways back that are under way; what is left of each adds up.
    pub(super) ways: Vec<Back>,
    /// Fixes are followed again, beside them by what is left.
    pub(super) follows: bool,
    pub(super) last_attitude: Option<DVec4>,
}

impl Grown {
    fn count(&self) -> usize {
        self.base + self.run.len()
    }

    fn entry(&self, number: usize) -> &Entry {
        &self.run[number - self.base]
    }

    pub(super) fn push(&mut self, of: &Shared, mut entry: Entry) -> Result<(), Unusable> {
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

    pub(super) fn jump(&mut self, of: &Shared, at: TimeTag) {
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

    /// Where the last fix puts the platform at an instant: on from there at constant velocity, the attitude
    /// held.
    pub(super) fn known(&self, of: &Shared, t: TimeTag) -> Option<Jets> {
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

    pub(super) fn extend(&mut self, of: &Shared, to: TimeTag) {
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

    pub(super) fn report(&self, of: &Shared, t: TimeTag) -> Reported {
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
                return reported(between(&last.node, &next, turns, t), rest(last.rests, last));
            }
            let turns = constant.map_or(Ok([&from.turn, &to.turn]), Err);
            // At a node the segment before it is no matter.
            let rests = if t == from.node.time { from.rests } else { from.rests.max(to.rests) };
            (between(&from.node, &to.node, turns, t), rest(rests, from))
        };
        reported(state, rests)
    }
}

fn reported(state: State, (age_s, flags, arrived): (f64, u32, Option<Instant>)) -> Reported {
    Reported { state, age_s, flags, arrived }
}
