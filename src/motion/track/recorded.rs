//! The state of a recorded track between its nodes, and the attitude of the nodes.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::fit::Node;
use super::{State, TrackError};
use crate::frames::{Body, Enu, Point, Rotation, SceneFrame, Vector};
use crate::motion::attitude::{self, MIN_SPEED_MPS, Turn};
use crate::motion::place;
use crate::nav::{AttitudeSource, FileSource, Fix};
use crate::scene::hermite::Basis;
use crate::time::TimeTag;

/// Moves a recorded nominal trajectory in time so that the run begins within it, [`LEAD_S`] after its first
/// fix, unless it does already.
pub(super) fn shift_to(start: TimeTag, fixes: &mut [Fix]) {
    let (Some(first), Some(last)) = (fixes.first(), fixes.last()) else { return };
    if start.since(first.time) >= 0.0 && last.time.since(start) > 0.0 {
        return;
    }
    let lead_s = LEAD_S.min(0.1 * last.time.since(first.time));
    let (begin, from) = (start.plus(-lead_s), first.time);
    for fix in fixes {
        fix.time = begin.plus(fix.time.since(from));
    }
}

pub(super) fn recorded_state(nodes: &[Node], attitude: &Attitude, t: TimeTag) -> Result<State, TrackError> {
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
    /// The motion is too slow to give a heading: its horizontal speed, m/s.
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
    let axes = place::to_local_axes(&fix.place, frame);
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
pub(super) fn turns(
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

/// How much of a nominal trajectory lies before the run, s: what servos look back.
const LEAD_S: f64 = 2.0;

#[derive(Clone, Debug)]
pub(super) enum Attitude {
    Constant(Rotation<Body, Enu>),
    Nodes(Arc<[Turn]>),
}
