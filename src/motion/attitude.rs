//! Attitude at the nodes of a track, and between them.
//!
//! * **Recorded**: yaw, pitch and roll of the fixes, relative to North and vertical of the fix itself.
//! * **Coordinated turn**: ADS-B and most logs carry no attitude; it is derived from the motion. Nose along
//!   the velocity: `yaw = atan2(v_E, v_N)`, `pitch = atan2(v_U, v_h)`; wings banked so that nobody on board
//!   feels a side force: `roll = atan2(v_h dpsi/dt, g)`, with `v_h dpsi/dt = (a_E v_N - a_N v_E)/v_h`, `v_h`
//!   the horizontal speed, g = 9.80665 m/s^2, right wing down in a turn to the right. No angle of attack, no
//!   crab into the wind.
//! * **Level**: the same yaw, pitch and roll zero.
//!
//! A derived heading needs a speed of [`MIN_SPEED_MPS`] at least: below it the direction of the velocity is
//! noise, and the track is refused.
//!
//! Between nodes the unit quaternion is the normalised quintic Hermite ([`crate::scene::hermite`]) of the
//! node quaternions (signs aligned), whose derivatives come from the seven nearest nodes: C2 in time, so the
//! angular rate is continuous. Exact at the nodes. The angular rate is that of the attitude returned,
//! `omega = 2 (dq/dt) q*`, components along ENU.
//!
//! ```
//! use nereus::motion::attitude::coordinated_turn;
//! // 100 m/s northwards, turning right with 1 m/s^2: roll atan(1/g), right wing down.
//! let angles = coordinated_turn([0.0, 100.0, 0.0], [1.0, 0.0, 0.0]);
//! assert!((angles[2] - (1.0f64 / 9.80665).atan()).abs() < 1e-12);
//! ```

use glam::{DQuat, DVec3, DVec4};

use crate::scene::hermite::{Basis, STENCIL, derivative_weights, stencil};

/// Standard gravity, m/s^2.
pub const GRAVITY_MPS2: f64 = 9.806_65;
/// Horizontal speed below which a heading is not derived from the motion, m/s.
pub const MIN_SPEED_MPS: f64 = 1.0;
/// The largest rotation between two nodes, degrees: interpolation would have to guess the way.
pub const MAX_STEP_DEG: f64 = 90.0;
/// Least length of the interpolated quaternion before it is normalised.
const MIN_LENGTH: f64 = 0.5;

/// Yaw, pitch and roll, radians, of a coordinated turn with velocity (m/s) and acceleration
/// (m/s^2) along East, North, up.
pub fn coordinated_turn(velocity_mps: [f64; 3], acceleration_mps2: [f64; 3]) -> [f64; 3] {
    let ([ve, vn, vu], [ae, an, _]) = (velocity_mps, acceleration_mps2);
    let speed = ve.hypot(vn);
    let lateral = if speed > 0.0 { (ae * vn - an * ve) / speed } else { 0.0 };
    [ve.atan2(vn), vu.atan2(speed), lateral.atan2(GRAVITY_MPS2)]
}

/// Yaw along the ground track, wings and nose level.
pub fn level(velocity_mps: [f64; 3]) -> [f64; 3] {
    [velocity_mps[0].atan2(velocity_mps[1]), 0.0, 0.0]
}

/// A unit quaternion and its first two derivatives at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    pub q: DVec4,
    pub first: DVec4,
    pub second: DVec4,
}

/// The attitude turns too far between a node and the next for an interpolation, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TooFar {
    pub node: usize,
    pub step_deg: f64,
}

/// Node quaternions with derivatives, from body-to-ENU quaternions at times `t_s`.
pub(super) fn turns(attitudes: &[DQuat], t_s: impl Fn(usize, usize) -> f64) -> Result<Vec<Turn>, TooFar> {
    let mut q: Vec<DVec4> = Vec::with_capacity(attitudes.len());
    for (node, attitude) in attitudes.iter().enumerate() {
        let mut here = DVec4::from(*attitude);
        if let Some(before) = q.last() {
            if before.dot(here) < 0.0 {
                here = -here;
            }
            let step_deg = 2.0 * before.dot(here).clamp(-1.0, 1.0).acos().to_degrees();
            if step_deg > MAX_STEP_DEG {
                return Err(TooFar { node, step_deg });
            }
        }
        q.push(here);
    }
    let turns: Vec<Turn> =
        (0..q.len()).map(|i| turn(i, stencil(i, q.len()), |node| q[node], |node| t_s(i, node))).collect();
    // Steps near the limit in turn with others may swing the quintic through zero.
    for (i, pair) in turns.windows(2).enumerate() {
        let h = t_s(i, i + 1);
        for s in [0.25, 0.5, 0.75] {
            if raw(&pair[0], &pair[1], &Basis::at(s, h)).0.length() < MIN_LENGTH {
                let step_deg = 2.0 * pair[0].q.dot(pair[1].q).clamp(-1.0, 1.0).acos().to_degrees();
                return Err(TooFar { node: i + 1, step_deg });
            }
        }
    }
    Ok(turns)
}

/// The quaternion of a node with derivatives from those of its stencil (signs aligned), at times `t_s` from
/// it.
pub(super) fn turn(
    index: usize,
    stencil: std::ops::Range<usize>,
    q: impl Fn(usize) -> DVec4,
    t_s: impl Fn(usize) -> f64,
) -> Turn {
    let mut times = [0.0; STENCIL];
    for (time, node) in times.iter_mut().zip(stencil.clone()) {
        *time = t_s(node);
    }
    let [w1, w2] = derivative_weights(&times[..stencil.len()]);
    let sum =
        |w: &[f64]| w.iter().zip(stencil.clone()).fold(DVec4::ZERO, |sum, (w, node)| sum + q(node) * *w);
    Turn { q: q(index), first: sum(&w1), second: sum(&w2) }
}

fn raw(from: &Turn, to: &Turn, basis: &Basis) -> (DVec4, DVec4) {
    let rise = to.q - from.q;
    let sum = |w: &[f64; 5]| {
        rise * w[0] + from.first * w[1] + to.first * w[2] + from.second * w[3] + to.second * w[4]
    };
    (from.q + sum(&basis.value), sum(&basis.first))
}

/// Body-to-ENU quaternion and angular rate (rad/s, along ENU) between two nodes.
pub(super) fn between(from: &Turn, to: &Turn, basis: &Basis) -> (DQuat, DVec3) {
    let (q, rate) = raw(from, to, basis);
    let norm2 = q.length_squared();
    // Opposite attitudes, between which there is no way: recorded tracks are refused before.
    if norm2 < 1e-4 {
        return (DQuat::from_vec4(from.q.normalize()), DVec3::ZERO);
    }
    let (q_, rate_) = (DQuat::from_vec4(q), DQuat::from_vec4(rate));
    // The scalar part of dq/dt q* is the change of length, which normalising takes away.
    let omega = rate_.mul_quat(q_.conjugate()).xyz() * (2.0 / norm2);
    (DQuat::from_vec4(q / norm2.sqrt()), omega)
}
