//! Where a phase centre is between pulses, and how long a wave takes over a point of the ground.
//!
//! A path is known at the emissions of the pulses. Between them it is the cubic through the four nearest
//! (`|x''''| h^4 3/128` is left out: 3e-10 m for 35 m/s^4 at h = 1/222 s). Beyond its ends, where the last
//! echoes arrive, it is the cubic through points a stride apart that is not shorter than what lies beyond:
//! neighbours alone would raise their rounding or noise a thousandfold over ten intervals.
//!
//! Delay of the echo of a point at rest (see [`crate::geometry::light_time`] for the emulator's own):
//!
//! ```text
//! c tau = |x - x_T(t)| + |x_R(t + tau) - x|
//! ```
//!
//! ```
//! use nereus::geometry::phase_path::PhasePath;
//! let times_s: Vec<f64> = (0..8).map(|i| f64::from(i) * 0.01).collect();
//! let points_m: Vec<[f64; 3]> = times_s.iter().map(|t| [222.0 * t, 0.0, 3000.0]).collect();
//! let path = PhasePath::new(times_s, points_m)?;
//! assert!((path.at(0.0335)[0] - 7.437).abs() < 1e-12);
//! # Ok::<(), nereus::geometry::phase_path::PhasePathError>(())
//! ```

use glam::DVec3;

use crate::units::SPEED_OF_LIGHT_MPS;

/// Points of the interpolating polynomial.
const POINTS: usize = 4;

/// What is wrong with a path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhasePathError {
    /// No points, or not one for each time.
    #[error("{points} positions for {times} emissions: one for each is needed, and at least one")]
    Shape {
        /// Times given.
        times: usize,
        /// Positions given.
        points: usize,
    },
    /// A time or a position that is no number, or times that do not ascend.
    #[error("row {row} of the recording: times of emissions must ascend and positions be finite")]
    Row {
        /// Which one.
        row: usize,
    },
}

/// The path of a phase centre.
#[derive(Clone, Debug, PartialEq)]
pub struct PhasePath {
    times_s: Vec<f64>,
    points_m: Vec<DVec3>,
}

impl PhasePath {
    /// Through points (ENU, m) at ascending times (s after any one instant).
    ///
    /// # Errors
    /// No points, not as many as times, or a row that is not finite or does not ascend.
    pub fn new(times_s: Vec<f64>, points_m: Vec<[f64; 3]>) -> Result<Self, PhasePathError> {
        if times_s.is_empty() || times_s.len() != points_m.len() {
            return Err(PhasePathError::Shape { times: times_s.len(), points: points_m.len() });
        }
        for (row, (time, point)) in times_s.iter().zip(&points_m).enumerate() {
            let ascends = row == 0 || times_s[row - 1] < *time;
            if !(time.is_finite() && ascends && point.iter().all(|x| x.is_finite())) {
                return Err(PhasePathError::Row { row });
            }
        }
        Ok(Self { times_s, points_m: points_m.into_iter().map(DVec3::from).collect() })
    }

    /// Position at a time, m.
    pub fn at(&self, time_s: f64) -> [f64; 3] {
        self.state(time_s).0.to_array()
    }

    /// Position (m) and velocity (m/s) at a time.
    pub(crate) fn state(&self, time_s: f64) -> (DVec3, DVec3) {
        let (rows, count) = self.nearest(time_s);
        let (mut position, mut velocity) = (self.points_m[rows[0]], DVec3::ZERO);
        // Newton's divided differences, relative to the first point: no digits are lost to the size of the
        // coordinates.
        let mut table = [DVec3::ZERO; POINTS];
        for (slot, row) in table.iter_mut().zip(&rows[..count]) {
            *slot = self.points_m[*row] - position;
        }
        for order in 1..count {
            for i in (order..count).rev() {
                let span = self.times_s[rows[i]] - self.times_s[rows[i - order]];
                table[i] = (table[i] - table[i - 1]) / span;
            }
        }
        let (mut product, mut slope) = (1.0, 0.0);
        for order in 1..count {
            let step = time_s - self.times_s[rows[order - 1]];
            slope = slope * step + product;
            product *= step;
            position += table[order] * product;
            velocity += table[order] * slope;
        }
        (position, velocity)
    }

    /// Rows that carry the polynomial at a time, and how many there are.
    fn nearest(&self, time_s: f64) -> ([usize; POINTS], usize) {
        let all = self.times_s.len();
        let count = all.min(POINTS);
        let after = self.times_s.partition_point(|t| *t <= time_s);
        if (1..all).contains(&after) || all <= POINTS {
            let first = after.saturating_sub(count / 2).min(all - count);
            return (std::array::from_fn(|i| (first + i).min(all - 1)), count);
        }
        let beyond_s = if after == 0 { self.times_s[0] - time_s } else { time_s - self.times_s[all - 1] };
        let interval_s = (self.times_s[all - 1] - self.times_s[0]) / (all - 1) as f64;
        let most = (all - 1) / (POINTS - 1);
        let stride = ((beyond_s / interval_s).ceil() as usize).clamp(1, most);
        if after == 0 {
            (std::array::from_fn(|i| i * stride), count)
        } else {
            (std::array::from_fn(|i| all - 1 - (POINTS - 1 - i) * stride), count)
        }
    }
}

/// Delay of the echo of a point at rest for a wave that leaves at `time_s`, s. Light time is iterated to 1e-7
/// m.
pub fn delay_s(transmitter: &PhasePath, receiver: &PhasePath, time_s: f64, point_m: [f64; 3]) -> f64 {
    let point = DVec3::from(point_m);
    let (from, _) = transmitter.state(time_s);
    let out_m = from.distance(point);
    let mut tau_s = 2.0 * out_m / SPEED_OF_LIGHT_MPS;
    // Each turn gains a factor v/c, 3e-5 at most in orbit.
    for _ in 0..4 {
        let (to, _) = receiver.state(time_s + tau_s);
        tau_s = (out_m + to.distance(point)) / SPEED_OF_LIGHT_MPS;
    }
    tau_s
}

/// Rate of that delay, s/s: negative when closing. First order in v/c.
pub fn delay_rate(transmitter: &PhasePath, receiver: &PhasePath, time_s: f64, point_m: [f64; 3]) -> f64 {
    let point = DVec3::from(point_m);
    let tau_s = delay_s(transmitter, receiver, time_s, point_m);
    let (from, from_mps) = transmitter.state(time_s);
    let (to, to_mps) = receiver.state(time_s + tau_s);
    let rate_mps =
        from_mps.dot((from - point).normalize_or_zero()) + to_mps.dot((to - point).normalize_or_zero());
    rate_mps / SPEED_OF_LIGHT_MPS
}

/// Gradient of that delay over the point, s/m.
pub fn delay_gradient(
    transmitter: &PhasePath,
    receiver: &PhasePath,
    time_s: f64,
    point_m: [f64; 3],
) -> [f64; 3] {
    let point = DVec3::from(point_m);
    let tau_s = delay_s(transmitter, receiver, time_s, point_m);
    let (from, _) = transmitter.state(time_s);
    let (to, to_mps) = receiver.state(time_s + tau_s);
    let (out, back) = ((point - from).normalize_or_zero(), (point - to).normalize_or_zero());
    // c tau = R_T + R_R(tau): the receiver moves on while the wave is later.
    let closing = 1.0 + to_mps.dot(back) / SPEED_OF_LIGHT_MPS;
    ((out + back) / (SPEED_OF_LIGHT_MPS * closing)).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(count: usize, interval_s: f64, law: impl Fn(f64) -> [f64; 3]) -> PhasePath {
        let times_s: Vec<f64> = (0..count).map(|i| i as f64 * interval_s).collect();
        let points = times_s.iter().map(|t| law(*t)).collect();
        PhasePath::new(times_s, points).unwrap()
    }

    #[test]
    fn cubics_come_back_inside_and_beyond() {
        let law = |t: f64| [7500.0 * t - 4.0 * t * t, 3.0 * t * t * t, 8e5 - 2.0 * t];
        for (count, interval_s) in [(40, 0.55e-3), (4, 0.01), (2000, 0.55e-3)] {
            let path = path(count, interval_s, law);
            let end_s = (count - 1) as f64 * interval_s;
            for t in [0.1 * interval_s, 0.43 * end_s, end_s, end_s + 6e-3, -1e-4] {
                let found = path.at(t);
                for (a, b) in found.into_iter().zip(law(t)) {
                    // 8e5 m has a spacing of 1.2e-10 m; extrapolation by a stride raises it 15-fold, four
                    // points over 6 ms of 30 ms not at all.
                    assert!((a - b).abs() < 4e-9, "{count}, {t}: {a} {b}");
                }
                let speed = path.state(t).1.x;
                assert!((speed - (7500.0 - 8.0 * t)).abs() < 1e-4, "{speed}");
            }
        }
    }

    #[test]
    fn few_points_give_lower_orders() {
        assert_eq!(path(1, 1.0, |_| [1.0, 2.0, 3.0]).at(5.0), [1.0, 2.0, 3.0]);
        assert_eq!(path(2, 1.0, |t| [2.0 * t, 0.0, 0.0]).at(3.0), [6.0, 0.0, 0.0]);
        assert_eq!(path(3, 1.0, |t| [t * t, 0.0, 0.0]).at(2.5), [6.25, 0.0, 0.0]);
        assert!(PhasePath::new(vec![], vec![]).is_err());
        assert_eq!(PhasePath::new(vec![0.0, 0.0], vec![[0.0; 3]; 2]), Err(PhasePathError::Row { row: 1 }));
    }

    #[test]
    fn gradient_and_rate_are_those_of_the_delay() {
        let transmitter = path(2000, 0.5e-3, |t| [7500.0 * t, -4.6e5, 8e5]);
        let receiver = path(2000, 0.5e-3, |t| [7400.0 * t, -4.0e5, 8e5 + 5.0 * t]);
        let (t, point) = (0.4, [3100.0, 40.0, 0.0]);
        let tau = |t: f64, p: [f64; 3]| delay_s(&transmitter, &receiver, t, p);
        let gradient = delay_gradient(&transmitter, &receiver, t, point);
        for i in 0..3 {
            let moved = |step: f64| {
                let mut p = point;
                p[i] += step;
                tau(t, p)
            };
            let found = (moved(10.0) - moved(-10.0)) / 20.0;
            // Central difference: h^2/(6 R^2) = 1e-11 of 1/c, rounding 1e-18 s / 20 m; the angle that the
            // wave turns by: v/c.
            assert!((found - gradient[i]).abs() < 1e-4 * 6.7e-9, "{i}: {found} {}", gradient[i]);
        }
        let found = (tau(t + 1e-3, point) - tau(t - 1e-3, point)) / 2e-3;
        let rate = delay_rate(&transmitter, &receiver, t, point);
        // First order in v/c = 2.5e-5 of 5e-5.
        assert!((found - rate).abs() < 5e-9, "{found} {rate}");
    }
}
