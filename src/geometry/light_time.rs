//! Exact light time along transmitter, scatterer, receiver, and its rate.
//!
//! A pulse leaves the transmitter's phase centre at `t`, meets the scatterer at `t + tau1` and the
//! receiver's phase centre at `t + tau`, `tau = tau1 + tau2`:
//!
//! `c tau1 = |x_s(t + tau1) - x_T(t)|`, `c tau2 = |x_R(t + tau) - x_s(t + tau1)|`.
//!
//! Both are solved by fixed-point iteration (contraction `v/c`, started from standing ends) until the step is
//! below 1e-19 s or the rounding of `tau` itself. Ends and scatterer move by `p + v s + a s^2/2` about the
//! emission; what the quadratic leaves out is `|da/dt| tau^3 / 6`: 2e-10 m for a satellite at 800 km.
//!
//! Rate with respect to the emission time, by differentiation, with the unit vectors `k_i`
//! (transmitter to scatterer) and `k_s` (scatterer to receiver) and the receiver's velocity at reception:
//!
//! `tau1' = k_i.(v_s - v_T) / (c - k_i.v_s)`,
//! `tau2' = (1 + tau1') k_s.(v_R - v_s) / (c - k_s.v_R)`, `tau' = tau1' + tau2'`.
//!
//! Carrier phase `-2 pi f0 tau`, Doppler `f_D = -f0 tau'` (positive when closing).
//!
//! **Limits.** Speeds well below `c`. Straight rays. The scene frame is treated as inertial although it turns
//! with the Earth (`w = 7.3e-5 rad/s`). That neglects `2 w A / c` metres, `A` the area that the line from the
//! Earth's axis to the pulse sweeps on its way, seen along the axis. Out and back it cancels but for the
//! radar's own motion (8e-6 m for a satellite at 800 km). For two platforms whose clocks are set to UTC it
//! does not: about `b 465 m/s cos(lat) / c` for an east-west baseline `b` near the surface, 5 mm for 3 km;
//! and 1.4 m for satellites at 800 km that fly 800 km apart over the equator. It is a bias that changes as
//! slowly as the baseline does.
//!
//! ```
//! use nereus::frames::{Point, Vector};
//! use nereus::geometry::light_time::{LightTime, bistatic};
//! use nereus::motion::pointing::PhaseCentre;
//! let end = PhaseCentre::at_rest(Point::new(0.0, 0.0, 299_792.458));
//! let path = bistatic(LightTime::Exact, &end, Point::new(0.0, 0.0, 0.0), Vector::ZERO, &end);
//! assert!((path.delay_s - 2.0e-3).abs() < 1e-17);
//! ```

use glam::DVec3;

use crate::frames::{Enu, Point, Vector};
use crate::motion::pointing::PhaseCentre;
use crate::units::SPEED_OF_LIGHT_MPS as C;

/// The iteration stops at steps below this, s (3e-11 m).
const STEP_S: f64 = 1e-19;
/// Enough for any contraction factor up to 0.1.
const MOST_STEPS: usize = 20;

/// How light time is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LightTime {
    /// Everything moves while the pulse is under way.
    Exact,
    /// Everything stands still at the emission: the textbook approximation, up to 1.3 rad wrong for an
    /// aircraft at X band and useless from space. For comparison only.
    StopAndGo,
}

/// One path transmitter - scatterer - receiver, or the direct path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    /// Delay tau, s.
    pub delay_s: f64,
    /// The part of it from the transmitter to the scatterer, s.
    pub tx_leg_s: f64,
    /// The part of it from the scatterer to the receiver, s.
    pub rx_leg_s: f64,
    /// d tau / d t of emission, dimensionless (negative when closing).
    pub delay_rate: f64,
    /// Unit propagation direction at the scatterer, inward (zero when the leg has no length).
    pub incident: DVec3,
    /// Unit propagation direction at the scatterer, outward (zero when the leg has no length).
    pub scattered: DVec3,
}

impl Path {
    /// Doppler shift of a carrier, Hz, positive when closing.
    pub fn doppler_hz(&self, carrier_hz: f64) -> f64 {
        -carrier_hz * self.delay_rate
    }
}

/// Solves `c tau = distance(tau)` by fixed-point iteration from `tau = 0`.
fn fixed_point(distance_m: impl Fn(f64) -> f64) -> f64 {
    let mut tau = distance_m(0.0) / C;
    for _ in 0..MOST_STEPS {
        let next = distance_m(tau) / C;
        let step = (next - tau).abs();
        tau = next;
        if step <= STEP_S.max(f64::EPSILON * tau) {
            break;
        }
    }
    tau
}

/// Position and velocity of a phase centre `s` seconds after its instant.
fn moved(end: &PhaseCentre, s: f64) -> (DVec3, DVec3) {
    let (v, a) = (end.velocity.raw(), end.acceleration.raw());
    (end.position.raw() + (v + a * (0.5 * s)) * s, v + a * s)
}

/// The path over a scatterer that is at `position` at the emission and moves with `velocity`; both ends
/// as they are at the emission. See [`bistatic_over`] for one that accelerates.
pub fn bistatic(
    method: LightTime,
    transmitter: &PhaseCentre,
    position: Point<Enu>,
    velocity: Vector<Enu>,
    receiver: &PhaseCentre,
) -> Path {
    let scatterer = PhaseCentre { position, velocity, acceleration: Vector::ZERO };
    bistatic_over(method, transmitter, &scatterer, receiver)
}

/// The path over a scatterer whose motion about the emission is `p + v s + a s^2 / 2`, as that of the ends.
pub fn bistatic_over(
    method: LightTime,
    transmitter: &PhaseCentre,
    scatterer: &PhaseCentre,
    receiver: &PhaseCentre,
) -> Path {
    bistatic_between(method, transmitter, [scatterer; 2], receiver)
}

/// The path by a mirror: it ends at the image of the scatterer, and goes on from the scatterer itself.
pub fn bistatic_between(
    method: LightTime,
    transmitter: &PhaseCentre,
    [image, scatterer]: [&PhaseCentre; 2],
    receiver: &PhaseCentre,
) -> Path {
    let (x_t, v_t) = (transmitter.position.raw(), transmitter.velocity.raw());
    match method {
        LightTime::Exact => {
            let tx_leg_s = fixed_point(|s| (moved(image, s).0 - x_t).length());
            let (arrives, v_i) = moved(image, tx_leg_s);
            let (in_flight, v_s) = moved(scatterer, tx_leg_s);
            let rx_leg_s = fixed_point(|s| (moved(receiver, tx_leg_s + s).0 - in_flight).length());
            let (x_r, v_r) = moved(receiver, tx_leg_s + rx_leg_s);
            let incident = (arrives - x_t).normalize_or_zero();
            let scattered = (x_r - in_flight).normalize_or_zero();
            let tx_rate = incident.dot(v_i - v_t) / (C - incident.dot(v_i));
            let rx_rate = (1.0 + tx_rate) * scattered.dot(v_r - v_s) / (C - scattered.dot(v_r));
            Path {
                delay_s: tx_leg_s + rx_leg_s,
                tx_leg_s,
                rx_leg_s,
                delay_rate: tx_rate + rx_rate,
                incident,
                scattered,
            }
        }
        LightTime::StopAndGo => {
            let (x_i, v_i) = (image.position.raw(), image.velocity.raw());
            let (x_s, v_s) = (scatterer.position.raw(), scatterer.velocity.raw());
            let (x_r, v_r) = (receiver.position.raw(), receiver.velocity.raw());
            let (tx_leg_s, rx_leg_s) = ((x_i - x_t).length() / C, (x_r - x_s).length() / C);
            let incident = (x_i - x_t).normalize_or_zero();
            let scattered = (x_r - x_s).normalize_or_zero();
            let delay_rate = (incident.dot(v_i - v_t) + scattered.dot(v_r - v_s)) / C;
            Path { delay_s: tx_leg_s + rx_leg_s, tx_leg_s, rx_leg_s, delay_rate, incident, scattered }
        }
    }
}

/// The direct path from transmitter to receiver: `c tau = |x_R(t + tau) - x_T(t)|`,
/// `tau' = k.(v_R - v_T) / (c - k.v_R)`. It has no second leg; inward and outward directions are both `k`.
pub fn direct(method: LightTime, transmitter: &PhaseCentre, receiver: &PhaseCentre) -> Path {
    let (x_t, v_t) = (transmitter.position.raw(), transmitter.velocity.raw());
    let (delay_s, x_r, v_r) = match method {
        LightTime::Exact => {
            let tau = fixed_point(|s| (moved(receiver, s).0 - x_t).length());
            let (x_r, v_r) = moved(receiver, tau);
            (tau, x_r, v_r)
        }
        LightTime::StopAndGo => {
            let x_r = receiver.position.raw();
            ((x_r - x_t).length() / C, x_r, receiver.velocity.raw())
        }
    };
    let k = (x_r - x_t).normalize_or_zero();
    let delay_rate = match method {
        LightTime::Exact => k.dot(v_r - v_t) / (C - k.dot(v_r)),
        LightTime::StopAndGo => k.dot(v_r - v_t) / C,
    };
    Path { delay_s, tx_leg_s: delay_s, rx_leg_s: 0.0, delay_rate, incident: k, scattered: k }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn satellite(x_m: f64, v_mps: f64) -> PhaseCentre {
        PhaseCentre {
            position: Point::new(x_m, 0.0, 800e3),
            velocity: Vector::new(v_mps, 3.0, -2.0),
            acceleration: Vector::new(0.01, -0.02, -8.4),
        }
    }

    /// The equations themselves, put back: c tau against the distances of the moved ends.
    #[test]
    fn the_light_time_equations_hold_from_space() {
        let (tx, rx) = (satellite(-300e3, 7.5e3), satellite(250e3, 7.4e3));
        let (x_s, v_s) = (Point::new(1e3, -2e3, 0.0), Vector::new(10.0, -5.0, 1.0));
        let path = bistatic(LightTime::Exact, &tx, x_s, v_s, &rx);
        let in_flight = x_s + v_s * path.tx_leg_s;
        let out = (in_flight - tx.position).norm();
        let back = (moved(&rx, path.delay_s).0 - in_flight.raw()).length();
        // Four roundings of lengths near 1e6 m (ulp 1.2e-10 m): 1.6e-18 s; asked: 1e-17 s.
        assert!((out / C - path.tx_leg_s).abs() < 1e-17);
        assert!((back / C - path.rx_leg_s).abs() < 1e-17);
    }

    /// Against a five-point central difference of the whole solution.
    #[test]
    fn the_rate_is_the_derivative_of_the_delay() {
        let (tx, rx) = (satellite(-300e3, 7.5e3), satellite(250e3, 7.4e3));
        let (x_s, v_s) = (Point::new(1e3, -2e3, 0.0), Vector::new(10.0, -5.0, 1.0));
        let at = |end: &PhaseCentre, s: f64| {
            let (p, v) = moved(end, s);
            PhaseCentre { position: Point::from_raw(p), velocity: Vector::from_raw(v), ..*end }
        };
        let delays = |s: f64| {
            let (tx, rx) = (at(&tx, s), at(&rx, s));
            let path = bistatic(LightTime::Exact, &tx, x_s + v_s * s, v_s, &rx);
            (path.delay_s, direct(LightTime::Exact, &tx, &rx).delay_s)
        };
        let h = 0.05;
        let slope = |f: &dyn Fn(f64) -> f64| (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
        let path = bistatic(LightTime::Exact, &tx, x_s, v_s, &rx);
        let straight = direct(LightTime::Exact, &tx, &rx);
        // Rounding of tau (4.3e-19 s) over h, a few of them: 3e-17; truncation h^4 tau'''''/30 < 1e-20.
        assert!((slope(&|s| delays(s).0) - path.delay_rate).abs() < 5e-17);
        assert!((slope(&|s| delays(s).1) - straight.delay_rate).abs() < 5e-17);
    }

    #[test]
    fn ends_that_touch_stay_finite() {
        let end = PhaseCentre::at_rest(Point::new(1.0, 2.0, 3.0));
        let path = bistatic(LightTime::Exact, &end, end.position, Vector::ZERO, &end);
        assert_eq!((path.delay_s, path.delay_rate), (0.0, 0.0));
        let straight = direct(LightTime::Exact, &end, &end);
        assert_eq!((straight.delay_s, straight.delay_rate), (0.0, 0.0));
    }
}
