//! What a platform reports: its track at the epoch of the report at hand, wrong by its errors, moved on to
//! the instant.
//!
//! `p = p_k + e_k + (v_k + e'_k) (t - t_k)` (or held), `k` the report that has arrived
//! ([`crate::motion::errors`]); velocity and attitude are those of the epoch. A report of the instant itself
//! keeps acceleration and angular rate of the track; one that is older has neither. Before the begin of a
//! recorded track its first instant is reported.
//!
//! Changes while a run goes on ([`crate::motion::changes`]) add to `e_k` and choose `k`: those are in effect
//! whose pulse has been emitted at the instant.

use std::sync::Arc;

use super::deviation::tilted;
use crate::frames::{Enu, Point, Rotation, Vector};
use crate::motion::changes::{self, Given, PlatformChanges, Standing};
use crate::motion::errors::{ATTITUDE, Between, Errors, VELOCITY};
use crate::motion::track::{State, Track, TrackError};
use crate::pulse::flags;
use crate::time::TimeTag;

/// What a platform reports at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// The state.
    pub state: State,
    /// The instant less the epoch of the navigation that this rests on, s.
    pub age_s: f64,
    /// Bits of [`flags`].
    pub flags: u32,
}

impl Report {
    /// One that is right, and of this instant.
    pub fn of(state: State) -> Self {
        Self { state, age_s: 0.0, flags: 0 }
    }
}

/// A track as it is reported.
#[derive(Clone, Debug)]
pub(super) struct Reports {
    pub base: Track,
    pub errors: Errors,
    pub start: TimeTag,
    /// Without changes the track itself is reported.
    pub right: bool,
    pub changes: Option<Arc<PlatformChanges>>,
}

impl Reports {
    /// What is reported at an instant. Nothing is allocated.
    ///
    /// # Errors
    /// An instant that the reported track does not cover.
    pub fn at(&self, t: TimeTag) -> Result<Report, TrackError> {
        match &self.changes {
            Some(changes) => changes.read(|given| {
                let begun = given.partition_point(|one| t.since(one.time) >= 0.0);
                self.changed(t, &given[..begun])
            }),
            None => self.changed(t, &[]),
        }
    }

    /// What is reported at an instant by which some changes have begun.
    fn changed(&self, t: TimeTag, given: &[Given]) -> Result<Report, TrackError> {
        if self.right && given.is_empty() {
            return self.base.report(t);
        }
        let t_s = t.since(self.start);
        let (given, latest) = match given {
            [] => (given, self.errors.latest(t_s)),
            _ => {
                let (in_effect, latest) = changes::latest(&self.errors, given, t_s);
                (&given[..in_effect], latest)
            }
        };
        let mut epoch = latest.time_s.map_or(t, |time_s| self.start.plus(time_s));
        if let Some((first, _)) = self.base.span()
            && first.since(epoch) > 0.0
        {
            epoch = if first.since(t) > 0.0 { t } else { first };
        }
        let epoch_s = epoch.since(self.start);
        let standing = changes::standing(&self.errors, given, epoch_s);
        let base = self.base.report(epoch)?;
        let mut state = base.state;
        if !self.right || !standing.is_nothing() {
            state = self.wrong(&state, latest.epoch, epoch_s, &standing);
        }
        let age_s = t.since(epoch);
        if age_s > 0.0 {
            if latest.between == Between::Extrapolate {
                state.position = state.position + state.velocity * age_s;
            }
            state.acceleration = Vector::ZERO;
            state.angular_rate = Vector::ZERO;
        }
        let lost = if latest.dropout { flags::REPORT_DROPOUT } else { 0 };
        Ok(Report { state, age_s: age_s + base.age_s, flags: base.flags | lost })
    }

    /// A state with the errors of an epoch, `t_s` after pulse 0.
    fn wrong(&self, state: &State, epoch: i64, t_s: f64, more: &Standing) -> State {
        let (errors, model) = (&self.errors, self.errors.model());
        let error = |first: usize| {
            [0, 1, 2].map(|axis| errors.value(first + axis, epoch, t_s) + more.error[first + axis])
        };
        let moving = [0, 1, 2].map(|axis| errors.known(axis, t_s)[1] + more.growth[axis]);
        let arm = state.attitude * model.lever_arm_error;
        let offset = vector(error(0)) + arm;
        let drift = vector(error(VELOCITY)) + vector(moving) + state.angular_rate.cross(arm);
        let [q_m, q_mps, q_rad] = model.quantisation;
        let [x, y, z] = rounded((state.position + offset).to_array(), q_m);
        let (mut attitude, angular_rate) =
            tilted(state.attitude, state.angular_rate, error(ATTITUDE), [0.0; 3]);
        if q_rad > 0.0 {
            let [yaw, pitch, roll] = rounded(attitude.to_yaw_pitch_roll(), q_rad);
            attitude = Rotation::from_yaw_pitch_roll(yaw, pitch, roll);
        }
        State {
            position: Point::new(x, y, z),
            velocity: vector(rounded((state.velocity + drift).to_array(), q_mps)),
            attitude,
            angular_rate,
            ..*state
        }
    }
}

/// To the nearest step, unless that is 0.
fn rounded(values: [f64; 3], step: f64) -> [f64; 3] {
    if step > 0.0 { values.map(|value| (value / step).round() * step) } else { values }
}

fn vector([x, y, z]: [f64; 3]) -> Vector<Enu> {
    Vector::new(x, y, z)
}
