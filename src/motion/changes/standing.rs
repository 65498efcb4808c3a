//! What changes amount to at an instant.

use super::{Change, Given};
use crate::motion::errors::{ATTITUDE, AXES, Between, Errors, LatestReport};

/// What changes add to the errors of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Standing {
    /// Added to the error of each axis, m, m/s, rad.
    pub error: [f64; AXES],
    /// Growth of that, per second.
    pub growth: [f64; AXES],
}

impl Standing {
    /// Whether nothing is added.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }
}

/// SI of a value as written.
fn si(axis: usize, value: f64) -> f64 {
    if axis >= ATTITUDE { value.to_radians() } else { value }
}

/// How many of the changes are in effect at an instant, and the report that is then at hand: `given` are all
/// that have begun by `t_s` after pulse 0, in their order. During a dropout only those from before it are in
/// effect.
pub fn latest(errors: &Errors, given: &[Given], t_s: f64) -> (usize, LatestReport) {
    let mut lost: Option<(usize, f64)> = None;
    for (place, one) in given.iter().enumerate() {
        match one.change {
            Change::Dropout { seconds } => {
                let until_s = one.t_s + seconds;
                lost = match lost {
                    Some((first, until)) if one.t_s < until => Some((first, until.max(until_s))),
                    _ => Some((place, until_s)),
                };
            }
            Change::Clear => lost = None,
            _ => {}
        }
    }
    let (in_effect, dropout) = match lost {
        Some((first, until_s)) if t_s < until_s => (first, given.get(first).map(|one| one.t_s)),
        _ => (given.len(), None),
    };
    // The latency in force, and the latest report that had arrived when it came into force.
    let mut latency_s = None;
    let mut at_hand: Option<i64> = None;
    let arrived = |at_s: f64, latency_s: Option<f64>, at_hand: Option<i64>| {
        let epoch = errors.received_before(at_s, latency_s).epoch;
        at_hand.map_or(epoch, |held| held.max(epoch))
    };
    for one in &given[..in_effect] {
        let next = match one.change {
            Change::Latency { ms } => Some(ms / 1e3),
            Change::Clear if latency_s.is_some() => None,
            _ => continue,
        };
        at_hand = Some(arrived(one.t_s, latency_s, at_hand));
        latency_s = next;
    }
    if let Some(begun_s) = dropout {
        let between = errors.model().dropouts.map_or(Between::Extrapolate, |model| model.during);
        let epoch = arrived(begun_s, latency_s, at_hand);
        return (
            in_effect,
            LatestReport { epoch, time_s: errors.time_unless_now(epoch, t_s), between, dropout: true },
        );
    }
    let mut latest = errors.latest_after(t_s, latency_s);
    if let Some(held) = at_hand.filter(|held| *held > latest.epoch) {
        latest = LatestReport {
            epoch: held,
            time_s: errors.time_unless_now(held, t_s),
            between: errors.model().between,
            dropout: false,
        };
    }
    (in_effect, latest)
}

/// What changes add to the report of an epoch, `epoch_s` after pulse 0.
pub fn standing(errors: &Errors, given: &[Given], epoch_s: f64) -> Standing {
    let mut standing = Standing::default();
    let mut ramps = [[0.0; 2]; AXES];
    // What a ramp has grown to when another takes its place.
    let grown = |ramp: &[f64; 2], to_s: f64| {
        let [rate, since_s] = *ramp;
        if rate == 0.0 { 0.0 } else { rate * (epoch_s.min(to_s) - since_s).max(0.0) }
    };
    for one in given {
        match one.change {
            Change::Step { axis, value } => standing.error[axis] += si(axis, value),
            Change::Bias { axis, value } => {
                standing.error[axis] = si(axis, value) - errors.constant(axis);
                ramps[axis][1] = one.t_s;
            }
            Change::Ramp { axis, value } => {
                standing.error[axis] += grown(&ramps[axis], one.t_s);
                ramps[axis] = [si(axis, value), one.t_s];
                if epoch_s >= one.t_s {
                    standing.growth[axis] = si(axis, value);
                }
            }
            Change::Clear => {
                standing = Standing::default();
                ramps = [[0.0; 2]; AXES];
            }
            Change::Dropout { .. } | Change::Latency { .. } => {}
        }
    }
    for (error, ramp) in standing.error.iter_mut().zip(&ramps) {
        *error += grown(ramp, f64::INFINITY);
    }
    standing
}
