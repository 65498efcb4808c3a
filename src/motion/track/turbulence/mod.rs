//! Turbulence: gusts of the Dryden model, and how an aircraft answers them.
//!
//! White noise of unit intensity through (MIL-F-8785C, `u` along the track, `v` to starboard, `w` up)
//!
//! ```text
//! H_u = s_u sqrt(2 T_u) / (1 + T_u s)
//! H_v, H_w = s sqrt(T) (1 + sqrt(3) T s) / (1 + T s)^2 ,    T = L / V
//! ```
//!
//! has variance `s^2` exactly. Lengths `L` and strengths `s` by height above the sea `h` (ft; at least 10)
//! and wind at 20 ft `W20`:
//!
//! | h | L_w | L_u, L_v | s_w | s_u, s_v |
//! | --- | --- | --- | --- | --- |
//! | below 1000 | h | h / (0.177 + 0.000823 h)^1.2 | 0.1 W20 | s_w / (0.177 + 0.000823 h)^0.4 |
//! | above 2000 | 1750 | 1750 | 1.5, 3, 6 m/s at W20 of 15, 30, 45 kt | the same |
//!
//! linear in between, and linear in W20 between and beyond those three.
//!
//! The aircraft follows each gust `g` through a low pass of second order with damping 0.7,
//! `y'' = w_c^2 (g - y) - 1.4 w_c y'`: its velocity is `k_v y`, and a stable aircraft turns its nose into the
//! wind: pitch `-k_a y_w / V`, heading `-k_a y_v / V`, roll `+k_a y_v / V` (the windward wing rises). Its
//! position is the integral of its velocity; with a track hold of `T_h` the velocity is `k_v (y - h)`,
//! `h' = (y - h)/T_h`, so the position is `k_v T_h h` and stays bounded. Without one the position at pulse 0
//! is on the track.
//!
//! Gust, answer and position of an axis are one linear system `x' = A x + b n`, stepped without error for
//! every step: `x_(k+1) = e^(A dt) x_k + c`, the covariance of `c` being
//! `integral of e^(A t) b b^T e^(A^T t)` over a step (Van Loan, IEEE Trans. Automatic Control 23 (1978) 395).
//! It starts with its stationary covariance, 128 s before pulse 0. Steps are a twentieth of the shortest `T`
//! and of the period of the cut-off. Each step gives position, velocity and acceleration, through which
//! quintics run: C2, a function of time alone.
//!
//! Limits: height, airspeed and strength are those of pulse 0 (or given) for the whole run; axes are
//! independent; no rolling gusts; the gain model stands for an aircraft, not for a certain one.
//!
//! ```
//! use nereus::motion::track::turbulence::strength;
//! use nereus::units::FOOT_M;
//! // Moderate turbulence at 500 ft: 0.1 of 30 knots upwards, more along the track.
//! let scales = strength(500.0 * FOOT_M, 15.43);
//! assert!((scales.sigma_mps[2] - 1.543).abs() < 1e-12 && (scales.length_m[2] - 152.4).abs() < 1e-9);
//! assert!(scales.sigma_mps[0] > 1.9 && scales.length_m[0] > 280.0);
//! ```

mod system;

use super::fault::TurbulenceFault;
use super::fault::{LEAST_AIRSPEED_MPS, MOST_STEPS};
use std::f64::consts::TAU;

use glam::DVec3;

use super::deviation::Deviation;
use crate::frames::SceneFrame;
use crate::motion::errors::Circumstances;
use crate::motion::gusts::Gusts;
use crate::motion::gusts::LEVELS_MPS;
use crate::motion::track::{State, Track, TrackError};
use crate::time::TimeTag;
use crate::units::FOOT_M;

pub use system::{Axis, Chain};

/// Strength far above the sea of light, moderate and severe turbulence, m/s.
const HIGH_MPS: [f64; 3] = [1.5, 3.0, 6.0];
/// How long before pulse 0 gusts begin, s: more than any servo looks back.
const LEAD_S: f64 = 128.0;
/// How long they go on after the run, s: more than any light time.
const AFTER_S: f64 = 1.0;
/// Steps in the shortest correlation time and in a period of the cut-off.
const STEPS: f64 = 20.0;

/// Lengths and strengths of gusts along the track, to starboard, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Lengths, m.
    pub length_m: [f64; 3],
    /// Standard deviations, m/s.
    pub sigma_mps: [f64; 3],
}

/// Gusts at a height above the sea, for a wind at 20 ft.
pub fn strength(height_m: f64, wind20_mps: f64) -> Scales {
    let low = |h_ft: f64| {
        let base = 0.177 + 0.000_823 * h_ft;
        let (length, sigma) = (h_ft / base.powf(1.2), 0.1 * wind20_mps / base.powf(0.4));
        ([length, length, h_ft], [sigma, sigma, 0.1 * wind20_mps])
    };
    let (mut at, mut from) = (LEVELS_MPS[0], 0.0);
    let (mut value, mut begin) = (HIGH_MPS[0], 0.0);
    for (level, sigma) in LEVELS_MPS.into_iter().zip(HIGH_MPS).skip(1) {
        if wind20_mps > at {
            (from, begin, at, value) = (at, value, level, sigma);
        }
    }
    let high = begin + (value - begin) * (wind20_mps - from) / (at - from);
    let h_ft = (height_m / FOOT_M).max(10.0);
    let (length_ft, sigma_mps) = if h_ft <= 1000.0 {
        low(h_ft)
    } else {
        let part = ((h_ft - 1000.0) / 1000.0).min(1.0);
        let (length, sigma) = low(1000.0);
        (length.map(|l| l + (1750.0 - l) * part), sigma.map(|s| s + (high - s) * part))
    };
    Scales { length_m: length_ft.map(|l| l * FOOT_M), sigma_mps }
}

/// Motion about a track in turbulent air.
pub(super) fn deviation(
    track: &Track,
    gusts: &Gusts,
    frame: &SceneFrame,
    of: &Circumstances,
    start: TimeTag,
) -> Result<Deviation, TurbulenceFault> {
    check(gusts)?;
    let state = track.state(start)?;
    let [x, y, z] = state.position.to_array();
    let height_m = gusts.height_m.unwrap_or(z + frame.earth().drop_m(x, y));
    let airspeed_mps = gusts.airspeed_mps.unwrap_or(state.velocity.norm());
    if !(airspeed_mps >= LEAST_AIRSPEED_MPS && airspeed_mps.is_finite()) {
        return Err(TurbulenceFault::Slow { airspeed_mps });
    }
    let scales = strength(height_m, gusts.wind20_mps);
    let times_s = scales.length_m.map(|length_m| length_m / airspeed_mps);
    let hold_s = gusts.hold_s.unwrap_or(f64::INFINITY);
    let shortest_s = times_s.into_iter().fold(gusts.cutoff_hz.recip().min(hold_s), f64::min);
    let step_s = shortest_s / STEPS;
    let first = -((LEAD_S / step_s).ceil() as i64);
    let span_s = LEAD_S + of.times.interval_s(0, of.pulses) + AFTER_S;
    let steps = (span_s / step_s).ceil() + 2.0;
    if steps > MOST_STEPS as f64 {
        return Err(TurbulenceFault::TooLong { steps: steps as u64, step_s });
    }
    let cutoff = TAU * gusts.cutoff_hz;
    let mut answers = [const { Vec::new() }; 3];
    for (place, answer) in answers.iter_mut().enumerate() {
        let axis = Axis { along: place == 0, sigma_mps: scales.sigma_mps[place], time_s: times_s[place] };
        let key = of.platform as u64 * 256 + place as u64;
        *answer = Chain::new(axis, cutoff, gusts.hold_s, step_s).run(of.seed, key, first, steps as usize);
    }
    let zero = (-first) as usize;
    // A drifting aircraft is on its track at pulse 0.
    let on_track = answers.each_ref().map(|answer| match gusts.hold_s {
        Some(_) => 0.0,
        None => answer[zero].position_m,
    });
    let span = track.span();
    let nodes = (0..steps as usize).map(|k| {
        let mut t = start.plus((first + k as i64) as f64 * step_s);
        if let Some((begin, end)) = span {
            t = if begin.since(t) > 0.0 { begin } else { t };
            t = if t.since(end) > 0.0 { end } else { t };
        }
        let course = Course::of(&track.state(t)?);
        let of_axes = |value: &dyn Fn(usize) -> f64| DVec3::new(value(0), value(1), value(2));
        let p = of_axes(&|i| answers[i][k].position_m - on_track[i]) * gusts.velocity_gain;
        let v = of_axes(&|i| answers[i][k].velocity_mps) * gusts.velocity_gain;
        let a = of_axes(&|i| answers[i][k].acceleration_mps2) * gusts.velocity_gain;
        let linear = course.jets(p, v, a);
        let turn = |i: usize, sign: f64| {
            answers[i][k].followed.map(|y| sign * gusts.attitude_gain * y / airspeed_mps)
        };
        let [e, n, u] = linear;
        Ok([e, n, u, turn(1, 1.0), turn(2, -1.0), turn(1, -1.0)])
    });
    let nodes = nodes.collect::<Result<Vec<_>, TrackError>>()?;
    Ok(Deviation::through(start, first as f64 * step_s, step_s, nodes))
}

fn check(gusts: &Gusts) -> Result<(), TurbulenceFault> {
    let refuse = |name, value, allowed| Err(TurbulenceFault::Value { name, value, allowed });
    let sizes = [
        ("wind20_mps", gusts.wind20_mps),
        ("velocity_gain", gusts.velocity_gain),
        ("attitude_gain", gusts.attitude_gain),
    ];
    for (name, value) in sizes {
        if !(value.is_finite() && value >= 0.0) {
            return refuse(name, value, "a finite number, not negative");
        }
    }
    let above = [("cutoff_hz", Some(gusts.cutoff_hz)), ("hold_s", gusts.hold_s)];
    for (name, value) in above {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return refuse(name, value, "a finite number above 0");
        }
    }
    match gusts.height_m.filter(|height_m| !height_m.is_finite()) {
        Some(value) => refuse("height_m", value, "a finite number"),
        None => Ok(()),
    }
}

/// Where the track leads, and how fast that turns.
struct Course {
    ahead: DVec3,
    starboard: DVec3,
    /// Rate of turn, rad/s, counter-clockwise from above.
    rate: f64,
}

impl Course {
    fn of(state: &State) -> Self {
        let [v, a] = [state.velocity.raw(), state.acceleration.raw()];
        let nose = state.attitude.raw() * DVec3::X;
        let square = v.x * v.x + v.y * v.y;
        let moving = square >= LEAST_AIRSPEED_MPS * LEAST_AIRSPEED_MPS;
        let along = if moving { v } else { nose };
        let ahead = DVec3::new(along.x, along.y, 0.0).try_normalize().unwrap_or(DVec3::Y);
        let rate = if moving { (v.x * a.y - v.y * a.x) / square } else { 0.0 };
        Self { ahead, starboard: DVec3::new(ahead.y, -ahead.x, 0.0), rate }
    }

    /// East, North, up with derivatives, from the same along the track, to starboard, up. A change of the
    /// rate of turn is left out of the second derivative.
    fn jets(&self, p: DVec3, v: DVec3, a: DVec3) -> [[f64; 3]; 3] {
        let enu = |d: DVec3| self.ahead * d.x + self.starboard * d.y + DVec3::Z * d.z;
        let turned = |d: DVec3| DVec3::Z.cross(d) * self.rate;
        let (p, v, a) = (enu(p), enu(v), enu(a));
        let velocity = v + turned(p);
        let acceleration = a + turned(v) * 2.0 + turned(turned(p));
        [0, 1, 2].map(|i| [p[i], velocity[i], acceleration[i]])
    }
}
