//! Smooth motion about a track: gusts, and the truth beside what an instrument reported.
//!
//! Six axes, East, North, up (m) and roll, pitch, heading (rad), each a chain of quintic segments
//! ([`crate::scene::hermite`]) on nodes at equal steps that carry value, first and second derivative: C2, as
//! the echo needs it. The position, velocity and acceleration of the track are added to; angles are added to
//! yaw, pitch and roll, and the angular rate is that of the sums:
//!
//! `p = roll' - yaw' sin(pitch)`, `q = pitch' cos(roll) + yaw' cos(pitch) sin(roll)`,
//! `r = -pitch' sin(roll) + yaw' cos(pitch) cos(roll)` along forward, starboard, down. Within 1e-6 of the
//! vertical, where rates of yaw and roll cannot be separated, the rate of the track is turned with the
//! body.

use glam::DVec3;

use crate::frames::{Body, Enu, Rotation, Vector};
use crate::motion::errors::{
    ATTITUDE, AXES, AxisErrors, Circumstances, ErrorModel, Errors, ErrorsFault, MOST_VALUES,
};
use crate::motion::track::{State, TrackError};
use crate::scene::hermite::{Basis, derivative_weights, stencil};
use crate::time::TimeTag;

/// Value, first and second derivative.
pub(super) type Jet = [f64; 3];
/// Cosine of a pitch at which yaw and roll are one.
const VERTICAL_COSINE: f64 = 1e-6;
/// Nodes in a correlation time.
const NODES_PER_TAU: f64 = 20.0;
/// Time between nodes of a walk, s.
const WALK_STEP_S: f64 = 1.0;
/// How long after the run nodes go on, s: more than any light time.
const AFTER_S: f64 = 1.0;

/// Motion about a track.
#[derive(Clone, Debug)]
pub(super) struct Deviation {
    start: TimeTag,
    first_s: f64,
    step_s: f64,
    nodes: Vec<[Jet; 6]>,
    /// Known errors, by which the truth differs from the track.
    short_of: Option<Box<Errors>>,
}

impl Deviation {
    /// Through nodes at `first_s + k step_s` after pulse 0.
    pub fn through(start: TimeTag, first_s: f64, step_s: f64, nodes: Vec<[Jet; 6]>) -> Self {
        Self { start, first_s, step_s, nodes, short_of: None }
    }

    /// The truth beside a report that is wrong by a model: less its errors. Random parts are taken at nodes,
    /// twenty to the shortest correlation time, and made smooth in between.
    ///
    /// # Errors
    /// A model with numbers out of range, or with random parts that need more nodes than can be held.
    pub fn short_of(model: &ErrorModel, of: &Circumstances, start: TimeTag) -> Result<Self, ErrorsFault> {
        let random = || model.axes.iter().filter(|axis| axis.is_random());
        let shortest_s = random().fold(WALK_STEP_S * NODES_PER_TAU, |shortest: f64, axis| {
            if axis.gm_sigma > 0.0 { shortest.min(axis.gm_tau_s) } else { shortest }
        });
        let step_s = shortest_s / NODES_PER_TAU;
        let epochs = (of.before_s + of.times.interval_s(0, of.pulses) + AFTER_S) / step_s;
        let values = epochs * size_of::<[Jet; 6]>() as f64 / size_of::<f64>() as f64;
        if random().next().is_some() && values > MOST_VALUES as f64 {
            return Err(ErrorsFault::TooLong { values: values as u64, epochs: epochs as u64 });
        }
        let axes: [AxisErrors; AXES] = model.axes;
        let sampled = ErrorModel { rate_hz: Some(1.0 / step_s), axes, ..ErrorModel::default() };
        let from = -((of.before_s / step_s).ceil() as i64) - 2;
        let to = ((of.times.interval_s(0, of.pulses) + AFTER_S) / step_s).ceil() as i64 + 4;
        let more_s = AFTER_S + 8.0 * step_s;
        let pulses = of.pulses.saturating_add((more_s * of.times.mean_prf_hz()).ceil() as u64);
        model.check()?;
        let errors = Errors::new(&sampled, &Circumstances { pulses, ..*of })?;
        let mut nodes = Vec::new();
        if random().next().is_some() {
            nodes = vec![[[0.0; 3]; 6]; (to - from + 1) as usize];
            for (place, axis) in axes_of_motion().enumerate() {
                let values: Vec<f64> = (from..=to).map(|k| -errors.random(axis, k)).collect();
                for (node, jet) in nodes.iter_mut().zip(jets(&values, step_s)) {
                    node[place] = jet;
                }
            }
        }
        let first_s = from as f64 * step_s;
        Ok(Self { start, first_s, step_s, nodes, short_of: Some(Box::new(errors)) })
    }

    /// First and last instant; `None` if it has no end.
    pub fn span(&self) -> Option<(TimeTag, TimeTag)> {
        let last = self.nodes.len().checked_sub(1)? as f64;
        Some((self.start.plus(self.first_s), self.start.plus(self.first_s + last * self.step_s)))
    }

    fn jets_at(&self, t: TimeTag) -> Result<[Jet; 6], TrackError> {
        let t_s = t.since(self.start);
        let mut jets = [[0.0; 3]; 6];
        if let Some((first, last)) = self.span() {
            let place = (t_s - self.first_s) / self.step_s;
            let index = place.floor().clamp(0.0, (self.nodes.len() - 2) as f64);
            let s = place - index;
            // A rounding beyond the ends is none.
            if !(-1e-6..=1.0 + 1e-6).contains(&s) {
                return Err(TrackError::OutOfSpan { asked: t, first, last });
            }
            let (from, to) = (&self.nodes[index as usize], &self.nodes[index as usize + 1]);
            let rows = Basis::at(s, self.step_s).rows();
            for ((jet, a), b) in jets.iter_mut().zip(from).zip(to) {
                let rise = b[0] - a[0];
                for (value, w) in jet.iter_mut().zip(&rows) {
                    *value = w[0] * rise + w[1] * a[1] + w[2] * b[1] + w[3] * a[2] + w[4] * b[2];
                }
                jet[0] += a[0];
            }
        }
        if let Some(errors) = &self.short_of {
            for (jet, axis) in jets.iter_mut().zip(axes_of_motion()) {
                for (value, error) in jet.iter_mut().zip(errors.known(axis, t_s)) {
                    *value -= error;
                }
            }
        }
        Ok(jets)
    }

    /// A state of the track, moved.
    ///
    /// # Errors
    /// An instant that the track does not cover.
    pub fn moved(&self, state: &State, t: TimeTag) -> Result<State, TrackError> {
        let jets = self.jets_at(t)?;
        let linear = |order: usize| Vector::new(jets[0][order], jets[1][order], jets[2][order]);
        let angles = |order: usize| [jets[3][order], jets[4][order], jets[5][order]];
        let (attitude, angular_rate) = tilted(state.attitude, state.angular_rate, angles(0), angles(1));
        Ok(State {
            position: state.position + linear(0),
            velocity: state.velocity + linear(1),
            acceleration: state.acceleration + linear(2),
            attitude,
            angular_rate,
        })
    }
}

/// Position and attitude among the axes of an error model.
fn axes_of_motion() -> impl Iterator<Item = usize> {
    (0..3).chain(ATTITUDE..AXES)
}

/// Values at equal steps with derivatives of the polynomial through the nearest.
fn jets(values: &[f64], step_s: f64) -> impl Iterator<Item = Jet> {
    (0..values.len()).map(move |i| {
        let near = stencil(i, values.len());
        let mut times = [0.0; crate::scene::hermite::STENCIL];
        for (time, node) in times.iter_mut().zip(near.clone()) {
            *time = (node as f64 - i as f64) * step_s;
        }
        let weights = derivative_weights(&times[..near.len()]);
        let [first, second] =
            weights.map(|w| w.iter().zip(&values[near.clone()]).map(|(w, v)| w * v).sum::<f64>());
        [values[i], first, second]
    })
}

/// An attitude whose roll, pitch and heading have been added to, and the angular rate along ENU then.
pub(super) fn tilted(
    attitude: Rotation<Body, Enu>,
    angular_rate: Vector<Enu>,
    added_rad: [f64; 3],
    rates: [f64; 3],
) -> (Rotation<Body, Enu>, Vector<Enu>) {
    if added_rad == [0.0; 3] && rates == [0.0; 3] {
        return (attitude, angular_rate);
    }
    let [yaw, pitch, roll] = attitude.to_yaw_pitch_roll();
    let [d_roll, d_pitch, d_yaw] = added_rad;
    let (new_pitch, new_roll) = (pitch + d_pitch, roll + d_roll);
    let turned: Rotation<Body, Enu> = Rotation::from_yaw_pitch_roll(yaw + d_yaw, new_pitch, new_roll);
    let body = attitude.inverse() * angular_rate;
    if pitch.cos().abs() < VERTICAL_COSINE {
        return (turned, turned * body);
    }
    let [p, q, r] = body.to_array();
    let (sine, cosine) = roll.sin_cos();
    let across = q * sine + r * cosine;
    let roll_rate = p + across * pitch.tan() + rates[0];
    let pitch_rate = q * cosine - r * sine + rates[1];
    let yaw_rate = across / pitch.cos() + rates[2];
    let ((sr, cr), (sp, cp)) = (new_roll.sin_cos(), new_pitch.sin_cos());
    let rate = DVec3::new(
        roll_rate - yaw_rate * sp,
        pitch_rate * cr + yaw_rate * cp * sr,
        -pitch_rate * sr + yaw_rate * cp * cr,
    );
    (turned, turned * Vector::from_raw(rate))
}
