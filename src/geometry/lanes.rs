//! Light time over many scatterers side by side.
//!
//! The equations are those of [`light_time`](super::light_time), in f64, without branches and with a fixed
//! number of steps: Newton's from the motion at the emission. What is left of a leg after its step is of
//! second order in `v/c`:
//!
//! | leg | left | from space (7.5 km/s, 800 km), s |
//! | --- | --- | --- |
//! | to a scatterer of speed `v_s` | `v_s^2 R / (2 c^3)` | 1.5e-18 at 10 m/s |
//! | to the receiver, two steps | `(v^2/c^2)^2 R / c` | 1e-21 |
//!
//! The scatterer moves evenly while the pulse is under way (its acceleration over 5 ms of flight would be
//! 1e-4 m at 10 m/s^2: a pulse from an aircraft flies 30 us, 5e-9 m).
//!
//! ```
//! use nereus::geometry::lanes::{End, LANES, Paths};
//! let mut paths = Paths::boxed();
//! paths.position_m[0][0] = 3000.0;
//! let end = End { position_m: [0.0, 0.0, 4000.0], velocity_mps: [0.0; 3], acceleration_mps2: [0.0; 3] };
//! paths.solve(1, &end, &end);
//! assert!((paths.delay_s[0] - 10e3 / 299_792_458.0).abs() < 1e-17);
//! assert!((paths.incident[2][0] + 0.8).abs() < 1e-6);
//! ```

use crate::motion::pointing::PhaseCentre;
use crate::units::SPEED_OF_LIGHT_MPS as C;

/// Scatterers side by side.
pub const LANES: usize = 256;
/// Lanes that are looped over at least together.
pub const GROUP: usize = 16;

/// A group of a row.
#[inline(always)]
pub fn group(row: &Row, g: usize) -> Held {
    row.as_chunks().0[g]
}

/// The same of three rows.
#[inline(always)]
pub fn groups(vectors: &[Row; 3], g: usize) -> [Held; 3] {
    [group(&vectors[0], g), group(&vectors[1], g), group(&vectors[2], g)]
}

/// Where a group of a row stands.
#[inline(always)]
pub fn group_mut(row: &mut Row, g: usize) -> &mut Held {
    &mut row.as_chunks_mut().0[g]
}

/// One vector of a group.
#[inline(always)]
pub fn lane(vectors: &[Held; 3], i: usize) -> [f32; 3] {
    [vectors[0][i], vectors[1][i], vectors[2][i]]
}

/// Lanes to loop over for so many scatterers: whole groups, at most [`LANES`].
#[inline(always)]
pub fn lanes_for(count: usize) -> usize {
    count.next_multiple_of(GROUP).min(LANES)
}

/// One quantity of all of them.
pub type Row = [f32; LANES];
/// One of a group, held in registers: rows that a task borrows are not known to lie apart, locals are.
pub type Held = [f32; GROUP];
/// The same in f64.
pub type WideRow = [f64; LANES];

/// A phase centre about the emission.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct End {
    /// Position, m.
    pub position_m: [f64; 3],
    /// Velocity, m/s.
    pub velocity_mps: [f64; 3],
    /// Acceleration, m/s^2.
    pub acceleration_mps2: [f64; 3],
}

impl From<&PhaseCentre> for End {
    fn from(centre: &PhaseCentre) -> Self {
        Self {
            position_m: centre.position.to_array(),
            velocity_mps: centre.velocity.raw().to_array(),
            acceleration_mps2: centre.acceleration.raw().to_array(),
        }
    }
}

/// Scatterers and their paths; ENU, SI units.
#[derive(Clone, Debug)]
pub struct Paths {
    /// Positions at the emission, m.
    pub position_m: [WideRow; 3],
    /// Velocities, m/s.
    pub velocity_mps: [Row; 3],
    /// Delay, s.
    pub delay_s: WideRow,
    /// Its derivative by the time of emission.
    pub delay_rate: WideRow,
    /// Lengths of both legs, m.
    pub leg_m: [Row; 2],
    /// Unit direction at the scatterer, inward.
    pub incident: [Row; 3],
    /// Unit direction at the scatterer, outward.
    pub scattered: [Row; 3],
}

impl Paths {
    /// All zero, on the heap.
    pub fn boxed() -> Box<Self> {
        let (row, wide) = ([0.0; LANES], [0.0; LANES]);
        Box::new(Self {
            position_m: [wide; 3],
            velocity_mps: [row; 3],
            delay_s: wide,
            delay_rate: wide,
            leg_m: [row; 2],
            incident: [row; 3],
            scattered: [row; 3],
        })
    }

    /// Solves the light time of the first `count` scatterers (and of some more, so that groups are whole).
    #[inline(always)]
    pub fn solve(&mut self, count: usize, transmitter: &End, receiver: &End) {
        const LEAST_M: f64 = 1e-9;
        let (x_t, v_t) = (transmitter.position_m, transmitter.velocity_mps);
        let (x_r, v_r, a_r) = (receiver.position_m, receiver.velocity_mps, receiver.acceleration_mps2);
        for i in 0..lanes_for(count) {
            let (places, velocities) = (&self.position_m, &self.velocity_mps);
            let p = [places[0][i], places[1][i], places[2][i]];
            let v = [velocities[0][i], velocities[1][i], velocities[2][i]];
            let v = [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])];
            let d = minus(p, x_t);
            let far = length(d);
            let towards = dot(d, v) / far.max(LEAST_M);
            let s = far / (C - towards);
            let in_flight = plus(p, v, s);
            let d = minus(in_flight, x_t);
            let out_m = length(d);
            let incident = scaled(d, 1.0 / out_m.max(LEAST_M));
            let tx_leg_s = out_m / C;

            let v_then = plus(v_r, a_r, tx_leg_s);
            let x_then = plus(plus(x_r, v_r, tx_leg_s), a_r, 0.5 * tx_leg_s * tx_leg_s);
            let e = minus(x_then, in_flight);
            let far = length(e);
            let away = dot(e, v_then) / far.max(LEAST_M);
            let s = far / (C - away);
            let x_later = plus(plus(x_then, v_then, s), a_r, 0.5 * s * s);
            let v_later = plus(v_then, a_r, s);
            let e = minus(x_later, in_flight);
            let back_m = length(e);
            let scattered = scaled(e, 1.0 / back_m.max(LEAST_M));
            let away = dot(scattered, v_later);
            let rx_leg_s = s + (back_m - C * s) / (C - away);

            let tx_rate = dot(incident, minus(v, v_t)) / (C - dot(incident, v));
            let rx_rate = (1.0 + tx_rate) * dot(scattered, minus(v_later, v)) / (C - away);
            self.delay_s[i] = tx_leg_s + rx_leg_s;
            self.delay_rate[i] = tx_rate + rx_rate;
            self.leg_m[0][i] = out_m as f32;
            self.leg_m[1][i] = back_m as f32;
            for axis in 0..3 {
                self.incident[axis][i] = incident[axis] as f32;
                self.scattered[axis][i] = scattered[axis] as f32;
            }
        }
    }
}

/// `a - b`.
#[inline(always)]
pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + s b`.
#[inline(always)]
pub(crate) fn plus(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s]
}

/// `s a`.
#[inline(always)]
pub(crate) fn scaled(a: [f64; 3], s: f64) -> [f64; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `a.b`.
#[inline(always)]
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a x b`.
#[inline(always)]
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `|a|`.
#[inline(always)]
pub(crate) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Point, Vector};
    use crate::geometry::light_time::{LightTime, bistatic};

    /// Against the iteration, from an aircraft and from space. Where both are right to rounding: f64 has
    /// `2^-52 tau` = 6e-21 s (27 us) and 1.2e-18 s (5.4 ms), a few of which add up; velocities are f32 in the
    /// lanes, so those of the test are too.
    #[test]
    fn as_the_iteration() {
        for (height_m, speed_mps, slack_s) in [(3000.0, 222.0, 5e-20), (800e3, 7500.0, 1e-17)] {
            let at = |x: f64| PhaseCentre {
                position: Point::new(x, -3000.0, height_m),
                velocity: Vector::new(speed_mps, -3.0, 2.0),
                acceleration: Vector::new(0.3, -0.2, -8.4),
            };
            let (tx, rx) = (at(-250.0), at(1000.0));
            let mut paths = Paths::boxed();
            for i in 0..LANES {
                let x = i as f64;
                paths.position_m[0][i] = 3.0 * x - 300.0;
                paths.position_m[1][i] = 500.0 - 7.0 * x;
                paths.position_m[2][i] = 0.01 * x;
                paths.velocity_mps[0][i] = 0.5;
                paths.velocity_mps[2][i] = -1.25;
            }
            paths.solve(LANES, &End::from(&tx), &End::from(&rx));
            for i in 0..LANES {
                let place = paths.position_m.each_ref().map(|column| column[i]);
                let exact = bistatic(
                    LightTime::Exact,
                    &tx,
                    Point::new(place[0], place[1], place[2]),
                    Vector::new(0.5, 0.0, -1.25),
                    &rx,
                );
                assert!((paths.delay_s[i] - exact.delay_s).abs() < slack_s, "{i}");
                assert!((paths.delay_rate[i] - exact.delay_rate).abs() < 1e-16, "{i}");
                for (axis, k) in exact.scattered.to_array().into_iter().enumerate() {
                    assert!((f64::from(paths.scattered[axis][i]) - k).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn ends_that_touch_stay_finite() {
        let mut paths = Paths::boxed();
        paths.solve(1, &End::default(), &End::default());
        assert_eq!((paths.delay_s[0], paths.delay_rate[0], paths.incident[0][0]), (0.0, 0.0, 0.0));
    }
}
