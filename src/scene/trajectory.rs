//! How a target or a ship moves that does not go straight on: along a recorded track, or waypoints.
//!
//! States at knots, and quintic Hermite segments in between ([`super::hermite`]): position, velocity and
//! acceleration are continuous. Before the first knot and after the last it moves straight on, at the
//! velocity that it has there. Times are seconds after pulse 0.
//!
//! ```
//! use nereus::frames::{Point, Vector};
//! use nereus::scene::trajectory::{Knot, Trajectory};
//! // A circle of 100 m in 40 s, a knot a second.
//! let rate = std::f64::consts::TAU / 40.0;
//! let knot = |n: u32| {
//!     let (sin, cos) = (rate * f64::from(n)).sin_cos();
//!     Knot {
//!         time_s: f64::from(n),
//!         position: Point::new(100.0 * cos, 100.0 * sin, 0.0),
//!         velocity: Vector::new(-100.0 * rate * sin, 100.0 * rate * cos, 0.0),
//!         acceleration: Vector::new(-100.0 * rate * rate * cos, -100.0 * rate * rate * sin, 0.0),
//!     }
//! };
//! let circle = Trajectory::new((0..=40).map(knot).collect()).unwrap();
//! let [x, y, _] = circle.at(12.3).position.to_array();
//! assert!((x.hypot(y) - 100.0).abs() < 1e-6);
//! assert!((circle.at(12.3).velocity.norm() - 100.0 * rate).abs() < 1e-5);
//! assert!(circle.fastest_mps() < 1.2 * 100.0 * rate);
//! assert!(Trajectory::new(vec![knot(1), knot(1)]).is_none());
//! ```

use std::sync::Arc;

use super::hermite::{Basis, acceleration_controls};
use crate::frames::{Enu, Point, Vector};

/// Where something is at an instant, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// After pulse 0, s.
    pub time_s: f64,
    /// Position.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Acceleration, m/s^2.
    pub acceleration: Vector<Enu>,
}

/// A way through knots. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    knots: Arc<[Knot]>,
    fastest_mps: f64,
}

impl Trajectory {
    /// Through at least two knots; `None` unless their times ascend and all is finite.
    pub fn new(knots: Vec<Knot>) -> Option<Self> {
        let finite = |knot: &Knot| {
            let Knot { time_s, position, velocity, acceleration } = knot;
            time_s.is_finite()
                && [position.to_array(), velocity.to_array(), acceleration.to_array()]
                    .as_flattened()
                    .iter()
                    .all(|value| value.is_finite())
        };
        let ascend = knots.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        let fastest_mps = knots.windows(2).map(fastest_mps).fold(0.0, f64::max);
        (knots.len() > 1 && ascend && knots.iter().all(finite))
            .then(|| Self { knots: knots.into(), fastest_mps })
    }

    /// The knots.
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// First and last time, s after pulse 0.
    pub fn span_s(&self) -> [f64; 2] {
        [self.knots[0].time_s, self.knots[self.knots.len() - 1].time_s]
    }

    /// A bound on its speed, m/s.
    pub fn fastest_mps(&self) -> f64 {
        self.fastest_mps
    }

    /// The state at a time after pulse 0.
    pub fn at(&self, elapsed_s: f64) -> Knot {
        let [first, last] = self.span_s();
        if elapsed_s <= first || elapsed_s >= last {
            let end = self.knots[if elapsed_s <= first { 0 } else { self.knots.len() - 1 }];
            let position = end.position + end.velocity * (elapsed_s - end.time_s);
            return Knot { time_s: elapsed_s, position, acceleration: Vector::ZERO, ..end };
        }
        let after = self.knots.partition_point(|knot| knot.time_s <= elapsed_s);
        let (from, to) = (&self.knots[after - 1], &self.knots[after]);
        let h = to.time_s - from.time_s;
        let basis = Basis::at((elapsed_s - from.time_s) / h, h);
        let rise = (to.position - from.position).raw();
        let (v, a) = ([from, to].map(|knot| knot.velocity.raw()), [from, to].map(|k| k.acceleration.raw()));
        let sum = |w: &[f64; 5]| rise * w[0] + v[0] * w[1] + v[1] * w[2] + a[0] * w[3] + a[1] * w[4];
        Knot {
            time_s: elapsed_s,
            position: Point::from_raw(from.position.raw() + sum(&basis.value)),
            velocity: Vector::from_raw(sum(&basis.first)),
            acceleration: Vector::from_raw(sum(&basis.second)),
        }
    }
}

/// A bound on the speed of a segment: that of its nearer end, and what the acceleration may add until there.
fn fastest_mps(ends: &[Knot]) -> f64 {
    let [from, to] = ends else { return 0.0 };
    let h = to.time_s - from.time_s;
    let rise = (to.position - from.position).to_array();
    let (v, a) = ([from, to].map(|k| k.velocity.to_array()), [from, to].map(|k| k.acceleration.to_array()));
    let most = |i: usize| {
        let controls = acceleration_controls(rise[i], [v[0][i], v[1][i]], [a[0][i], a[1][i]], h);
        controls.into_iter().map(f64::abs).fold(0.0, f64::max)
    };
    let acceleration_mps2 = most(0).hypot(most(1)).hypot(most(2));
    from.velocity.norm().max(to.velocity.norm()) + 0.5 * h * acceleration_mps2
}
