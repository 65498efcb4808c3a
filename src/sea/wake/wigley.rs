//! Free waves of a Wigley hull, in closed form.
//!
//! Half-breadth `Y = (B/2) (1 - (2x/L)^2) (1 - (z/T)^2)`: length L, beam B, draught T, m. Of thin-ship theory
//! (Michell; Tuck, Lazauskas and Scullen 1999), with `k0 = g/V^2` and `a = k0 sec^2 theta`, rad/m,
//!
//! `A = -(2j/pi) k0^2 sec^4 P`, `P = (B/2) Fx Fz`,
//! `Fz = 1/a - 2/(a^3 T^2) + e^{-aT} [2/(a^2 T) + 2/(a^3 T^2)]`,
//! `Fx = 2L (sin u - u cos u)/u^3`, `u = k0 sec(theta) L/2`.
//!
//! `a Fz` and `a Fx` stay bounded when theta nears a right angle; their product is what is computed. Small
//! `aT` and `u` go by series. Limits: thin hulls, no sinkage, no viscosity.
//!
//! ```
//! use nereus::sea::wake::Wigley;
//! let hull = Wigley { length_m: 1.0, beam_m: 0.1, draught_m: 0.0625 };
//! // Fore and aft symmetric about midship: a purely imaginary amplitude.
//! let along = hull.amplitude_m(0.9, 0.0);
//! assert!(along.re == 0.0 && along.im.abs() > 1e-3);
//! assert!(hull.amplitude_m(0.9, 1e6).norm() < 0.1);
//! ```

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::sea::GRAVITY_MPS2;

/// A Wigley hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wigley {
    /// Length, m.
    pub length_m: f64,
    /// Beam, m.
    pub beam_m: f64,
    /// Draught, m.
    pub draught_m: f64,
}

impl Wigley {
    /// `A(theta)`, m, at a speed above 0, m/s.
    pub fn amplitude_m(&self, speed_mps: f64, tan_theta: f64) -> Complex64 {
        let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
        let sec2 = 1.0 + tan_theta * tan_theta;
        let depth = depth_factor(k0 * sec2 * self.draught_m);
        let u = 0.5 * k0 * sec2.sqrt() * self.length_m;
        // a Fx = (8/(k0 L)) (sin u/u - cos u).
        let along = 8.0 / (k0 * self.length_m) * along_factor(u);
        Complex64::new(0.0, -(self.beam_m / PI) * depth * along)
    }
}

/// `a Fz` over `b = aT`.
fn depth_factor(b: f64) -> f64 {
    if b < 0.5 {
        // b sum of (-b)^n/n! 2/((n+1)(n+3)): terms beyond n = 14 are below 0.5^15/15!/120 = 2e-19.
        let (mut power, mut sum) = (b, 0.0);
        for n in 0..15 {
            let n = f64::from(n);
            sum += power * 2.0 / ((n + 1.0) * (n + 3.0));
            power *= -b / (n + 1.0);
        }
        return sum;
    }
    1.0 - 2.0 / (b * b) + (-b).exp() * (2.0 / b + 2.0 / (b * b))
}

/// `sin u/u - cos u`.
fn along_factor(u: f64) -> f64 {
    if u < 0.5 {
        // sum of (-1)^n u^{2n+2} (2n+2)/(2n+3)!: the term n = 8 is below 0.5^18 18/19! = 6e-22.
        let u2 = u * u;
        let (mut term, mut sum) = (u2 / 6.0, 0.0);
        for n in 0..8 {
            let n = f64::from(n);
            sum += term * (2.0 * n + 2.0);
            term *= -u2 / ((2.0 * n + 4.0) * (2.0 * n + 5.0));
        }
        return sum;
    }
    u.sin() / u - u.cos()
}
