//! Error covariances, from the error models of platforms and clocks.
//!
//! The covariance of an axis is the mean square of its error over the run: known parts (constant, sinusoid,
//! step, ramp) at 65 instants, variances of random ones, that of a walk at half the run, `q^2/12` of a
//! quantisation `q`. Axes are independent in the frame of the scene and turned to Earth-centred axes. Not
//! in it: what age, dropouts and attitude add.

use std::ops::Range;

use glam::DMat3;

use crate::frames::{Enu, SceneFrame, Vector};
use crate::motion::errors::{AxisErrors, ErrorModel, VELOCITY};
use crate::scene::clock::Clocks;
use crate::scene::radar::Radar;

/// Position (m), then velocity (m/s).
pub(super) type Matrix6 = [[f64; 6]; 6];

/// Instants at which known parts are evaluated.
const INSTANTS: usize = 65;
/// Keeps a covariance along one direction from getting a negative eigenvalue by rounding: relative to the
/// greatest variance.
const FLOOR: f64 = 1e-9;

/// Mean over some time, s after pulse 0.
fn mean(time_s: &Range<f64>, value: impl Fn(f64) -> f64) -> f64 {
    let seconds = time_s.end - time_s.start;
    let at = |i: usize| value(time_s.start + seconds * i as f64 / (INSTANTS - 1) as f64);
    (0..INSTANTS).map(at).sum::<f64>() / INSTANTS as f64
}

/// Mean square of what is drawn by chance.
fn drawn(axis: &AxisErrors, time_s: &Range<f64>, quantum: f64) -> f64 {
    let AxisErrors { bias_sigma, white, gm_sigma, walk, .. } = *axis;
    bias_sigma.powi(2)
        + white.powi(2)
        + gm_sigma.powi(2)
        + 0.5 * walk.powi(2) * (time_s.start + time_s.end)
        + quantum.powi(2) / 12.0
}

/// Covariance of reported position and velocity in Earth-centred axes, over some time (s after pulse 0); zero
/// without errors.
pub(super) fn of_report(errors: Option<&ErrorModel>, frame: &SceneFrame, time_s: &Range<f64>) -> Matrix6 {
    let mut matrix = [[0.0; 6]; 6];
    let Some(errors) = errors else { return matrix };
    let [q_m, q_mps, _] = errors.quantisation;
    let lever_m2 = errors.lever_arm_error.norm().powi(2) / 3.0;
    let position: [f64; 3] = std::array::from_fn(|i| {
        let axis = &errors.axes[i];
        mean(time_s, |t| axis.known(t)[0].powi(2)) + drawn(axis, time_s, q_m) + lever_m2
    });
    let velocity: [f64; 3] = std::array::from_fn(|i| {
        let (of_position, axis) = (&errors.axes[i], &errors.axes[VELOCITY + i]);
        mean(time_s, |t| (axis.known(t)[0] + of_position.known(t)[1]).powi(2)) + drawn(axis, time_s, q_mps)
    });
    let axis = |v: Vector<Enu>| frame.vector_to_ecef(v).map_or(v.raw(), Vector::raw);
    let turn = DMat3::from_cols(
        axis(Vector::new(1.0, 0.0, 0.0)),
        axis(Vector::new(0.0, 1.0, 0.0)),
        axis(Vector::new(0.0, 0.0, 1.0)),
    );
    for (block, variances) in [position, velocity].into_iter().enumerate() {
        let greatest = variances.into_iter().fold(0.0, f64::max);
        let turned = turn * DMat3::from_diagonal(variances.into()) * turn.transpose();
        for row in 0..3 {
            for column in row..3 {
                let floor = if row == column { FLOOR * greatest } else { 0.0 };
                let value = turned.col(column)[row] + floor;
                matrix[3 * block + row][3 * block + column] = value;
                matrix[3 * block + column][3 * block + row] = value;
            }
        }
    }
    matrix
}

/// Mean squares of the reading of an antenna's clock less time (s^2) and of its fractional frequency, over
/// some time (s after pulse 0); of its noise only what white frequency noise adds to the reading.
pub(super) fn of_clock(clocks: &Clocks, radar: &Radar, name: &str, time_s: &Range<f64>) -> [f64; 2] {
    let at = |place: Option<usize>, list: &[Option<usize>]| list.get(place?).copied().flatten();
    let transmitter = at(radar.transmitters.iter().position(|t| t.name == name), &clocks.transmitters);
    let receiver = at(radar.receivers.iter().position(|r| r.name == name), &clocks.receivers);
    let Some(named) = transmitter.or(receiver).and_then(|place| clocks.clocks.get(place)) else {
        return [0.0; 2];
    };
    let clock = &named.clock;
    let rate = |t: f64| clock.drift + clock.ageing_per_s * t;
    let reading = |t: f64| clock.offset_s + clock.drift * t + 0.5 * clock.ageing_per_s * t * t;
    // Variance of the phase of white frequency noise: h_0 t / 2, here in the middle.
    let wander = 0.25 * clock.noise[2] * (time_s.start + time_s.end);
    [mean(time_s, |t| reading(t).powi(2)) + wander, mean(time_s, |t| rate(t).powi(2))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Earth, Geodetic};

    #[test]
    fn errors_to_the_north_lie_to_the_north() {
        let frame = SceneFrame::at(Geodetic::from_deg(0.0, 0.0, 0.0), Earth::Flat);
        let mut errors = ErrorModel::default();
        errors.axes[1].bias = 2.0;
        errors.axes[1].ramp = 0.0;
        errors.axes[VELOCITY].white = 0.5;
        let matrix = of_report(Some(&errors), &frame, &(0.0..10.0));
        // At latitude and longitude 0 North is z and East is y.
        assert!((matrix[2][2] - 4.0).abs() < 1e-6 && matrix[0][0] < 1e-6 && matrix[1][1] < 1e-6);
        assert!((matrix[4][4] - 0.25).abs() < 1e-6 && matrix[5][5] < 1e-6);
        assert_eq!(of_report(None, &frame, &(0.0..10.0)), [[0.0; 6]; 6]);
    }

    /// A part of a run has the errors of its own time.
    #[test]
    fn errors_are_those_of_the_pulses() {
        let frame = SceneFrame::at(Geodetic::from_deg(0.0, 0.0, 0.0), Earth::Flat);
        let mut errors = ErrorModel::default();
        (errors.axes[0].step, errors.axes[0].step_at_s) = (3.0, 5.0);
        errors.axes[1].walk = 0.5;
        let variances = |time_s| {
            let matrix = of_report(Some(&errors), &frame, &time_s);
            [matrix[1][1], matrix[2][2]]
        };
        let [before, after] = [variances(0.0..2.0), variances(6.0..8.0)];
        assert!(before[0] < 1e-6 && (before[1] - 0.25).abs() < 1e-6, "{before:?}");
        // A walk has the variance 0.25 t.
        assert!((after[0] - 9.0).abs() < 1e-6 && (after[1] - 1.75).abs() < 1e-6, "{after:?}");
    }
}
