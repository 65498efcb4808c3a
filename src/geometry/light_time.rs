//! Exact bistatic light time.
//!
//! A pulse leaves the transmit phase centre at `t`. With `x_T`, `x_s`, `x_R` the paths of transmitter,
//! scatterer and receiver,
//!
//! ```text
//! tau1 = |x_s(t + tau1) - x_T(t)| / c
//! tau2 = |x_R(t + tau1 + tau2) - x_s(t + tau1)| / c ,   tau = tau1 + tau2
//! ```
//!
//! Both are solved by fixed-point iteration, whose contraction is v/c, until the delay stands still to the
//! last bits. Ends move as `x + v dt + a dt^2/2` over the flight of the pulse: what is left out, `j dt^3/6`, is
//! 2e-10 m from orbit (5 ms, 0.01 m/s^3). The rate `r = d tau/dt` comes from differentiating the two equations:
//!
//! ```text
//! tau1' (1 - u1.v_s/c) = u1.(v_s - v_T)/c            u1 = unit(x_s - x_T)
//! tau2' (1 - u2.v_R/c) = (1 + tau1') u2.(v_R - v_s)/c   u2 = unit(x_R - x_s)
//! ```
//!
//! with velocities at emission, bounce and reception. Doppler is `-f0 r`, positive when closing.
//!
//! The ENU frame is treated as inertial. The rotation of the Earth during the flight adds up to
//! `2 w A / c^2` (A: area swept by the path about the axis): 1.5 cm one way over 10 km, and 1.4 m one way from
//! 800 km, which cancels between the legs of a monostatic path but not of a wide bistatic one.
//!
//! ```
//! use glam::DVec3;
//! use nereus::geometry::light_time::{Mover, bistatic};
//! let still = |x: f64| Mover { position_m: DVec3::new(x, 0.0, 0.0), ..Mover::default() };
//! let path = bistatic(&still(0.0), &still(299_792_458.0), &still(0.0));
//! assert_eq!(path.delay_s, 2.0);
//! ```

use glam::DVec3;

use crate::units::SPEED_OF_LIGHT_MPS as C;

/// Iterations at most: v/c below 0.1 settles to f64 in 16.
const ITERATIONS: usize = 32;

/// Local motion of an end of the path, from the emission on (ENU, SI).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mover {
    /// Position at the emission, m.
    pub position_m: DVec3,
    /// Velocity at the emission, m/s.
    pub velocity_mps: DVec3,
    /// Acceleration, m/s^2.
    pub acceleration_mps2: DVec3,
}

impl Mover {
    /// Position `dt_s` after the emission.
    pub fn position_after(&self, dt_s: f64) -> DVec3 {
        self.position_m + (self.velocity_mps + self.acceleration_mps2 * (0.5 * dt_s)) * dt_s
    }

    /// Velocity `dt_s` after the emission.
    pub fn velocity_after(&self, dt_s: f64) -> DVec3 {
        self.velocity_mps + self.acceleration_mps2 * dt_s
    }
}

/// The way of a pulse from transmitter to receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Delay tau, s.
    pub delay_s: f64,
    /// Its first leg, s (all of it on the direct path).
    pub tx_leg_s: f64,
    /// d tau / dt with respect to the emission time; negative when closing.
    pub rate: f64,
    /// Where the scatterer is when the pulse meets it (the receiver, on the direct path).
    pub bounce_m: DVec3,
    /// Where the receiver is when the echo meets it.
    pub reception_m: DVec3,
}

impl Path {
    /// Doppler frequency, Hz: `-f0 d tau/dt`.
    pub fn doppler_hz(&self, carrier_hz: f64) -> f64 {
        -carrier_hz * self.rate
    }
}

/// Flight time from `from` to a mover that is met `leg` after `already_s`.
fn leg_s(from: DVec3, to: &Mover, already_s: f64) -> f64 {
    let mut leg = (to.position_after(already_s) - from).length() / C;
    for _ in 0..ITERATIONS {
        let next = (to.position_after(already_s + leg) - from).length() / C;
        let step = (next - leg).abs();
        leg = next;
        // A quarter of the last bit of the whole delay: nothing moves any more.
        if step <= 0.25 * f64::EPSILON * leg {
            break;
        }
    }
    leg
}

/// Rate of a leg that ends on `to` at velocity `v_to` and starts from a point of velocity `v_from` whose own
/// delay grows at `rate_from`.
fn leg_rate(from: DVec3, to: DVec3, v_from: DVec3, v_to: DVec3, rate_from: f64) -> f64 {
    let u = (to - from).normalize_or_zero();
    (1.0 + rate_from) * u.dot(v_to - v_from) / (C - u.dot(v_to))
}

/// The path by way of a scatterer.
pub fn bistatic(tx: &Mover, scatterer: &Mover, rx: &Mover) -> Path {
    let tx_leg_s = leg_s(tx.position_m, scatterer, 0.0);
    let bounce_m = scatterer.position_after(tx_leg_s);
    let rx_leg_s = leg_s(bounce_m, rx, tx_leg_s);
    let delay_s = tx_leg_s + rx_leg_s;
    let reception_m = rx.position_after(delay_s);
    let v_s = scatterer.velocity_after(tx_leg_s);
    let rate_1 = leg_rate(tx.position_m, bounce_m, tx.velocity_mps, v_s, 0.0);
    let rate_2 = leg_rate(bounce_m, reception_m, v_s, rx.velocity_after(delay_s), rate_1);
    Path { delay_s, tx_leg_s, rate: rate_1 + rate_2, bounce_m, reception_m }
}

/// The direct path.
pub fn direct(tx: &Mover, rx: &Mover) -> Path {
    let delay_s = leg_s(tx.position_m, rx, 0.0);
    let reception_m = rx.position_after(delay_s);
    let rate = leg_rate(tx.position_m, reception_m, tx.velocity_mps, rx.velocity_after(delay_s), 0.0);
    Path { delay_s, tx_leg_s: delay_s, rate, bounce_m: reception_m, reception_m }
}

/// Stop-and-go: everything stands still while the pulse flies, s. At 222 m/s and 4 km it is wrong by
/// 6 mm, from orbit by tens of metres; for comparison only.
pub fn stop_and_go_s(tx: &Mover, scatterer: &Mover, rx: &Mover) -> f64 {
    ((scatterer.position_m - tx.position_m).length() + (rx.position_m - scatterer.position_m).length()) / C
}
