//! Nodes of a growing path with their derivatives, and the way back from one path to another.

use std::time::Instant;

use glam::{DVec3, DVec4};

use crate::motion::attitude::Turn;
use crate::motion::track::fit::Node;
use crate::scene::hermite::Basis;
use crate::time::TimeTag;

/// Acceleration with which a path goes back to its fixes, m/s^2.
const REJOIN_MPS2: f64 = 20.0;
/// Rate at which an attitude does, rad/s.
const REJOIN_RAD_S: f64 = 0.5;
/// The shortest time in which it does, s.
const REJOIN_S: f64 = 0.3;

/// What a node rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rests {
    Fixes,
    Past,
    Stale,
}

/// A node of the path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) node: Node,
    pub(super) turn: Turn,
    pub(super) rests: Rests,
    /// Time and arrival of the fix that it is, or is extrapolated from.
    pub(super) fix: TimeTag,
    pub(super) arrived: Instant,
    /// Beside what the fixes say.
    pub(super) adrift: bool,
}

/// Value, first and second derivative of position and quaternion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jets {
    pub(super) p: [DVec3; 3],
    pub(super) q: [DVec4; 3],
}

/// The way back from what was reported to what is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Back {
    pub(super) from: TimeTag,
    pub(super) span_s: f64,
    pub(super) offset: Jets,
}

impl Jets {
    pub(super) fn of(step: &Step) -> Self {
        let (node, turn) = (&step.node, &step.turn);
        Self { p: [node.p, node.v, node.a], q: [turn.q, turn.first, turn.second] }
    }

    pub(super) fn combined(self, other: Self, sign: f64) -> Self {
        Self {
            p: std::array::from_fn(|i| self.p[i] + other.p[i] * sign),
            q: std::array::from_fn(|i| self.q[i] + other.q[i] * sign),
        }
    }

    /// Between two steps.
    pub(super) fn between(from: &Step, to: &Step, t: TimeTag) -> Self {
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
    pub(super) fn of(from: TimeTag, offset: Jets) -> Self {
        let [away, apart, _] = offset.p.map(DVec3::length);
        // Of a small turn, the length of the difference of quaternions is half the angle.
        let turn_rad = 2.0 * offset.q[0].length().min(std::f64::consts::SQRT_2);
        let span_s = REJOIN_S
            .max((5.8 * away / REJOIN_MPS2).sqrt())
            .max(4.0 * apart / REJOIN_MPS2)
            .max(1.9 * turn_rad / REJOIN_RAD_S);
        Self { from, span_s, offset }
    }

    pub(super) fn is_over(&self, t: TimeTag) -> bool {
        t.since(self.from) >= self.span_s
    }

    /// What is left of the offset.
    pub(super) fn left(&self, t: TimeTag) -> Jets {
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

/// The same step elsewhere.
pub(super) fn beside(step: Step, jets: Jets) -> Step {
    let Jets { p, q } = jets;
    Step {
        node: Node { time: step.node.time, p: p[0], v: p[1], a: p[2] },
        turn: Turn { q: q[0], first: q[1], second: q[2] },
        rests: step.rests.max(Rests::Past),
        ..step
    }
}
