//! Amplitudes of the waves that a thin ship makes, and its wave resistance.
//!
//! In the frame of the ship (x astern from midship, y to starboard, z up; speed V towards -x) the far field
//! is
//!
//! ```text
//! zeta(x, y) = Re int_{-pi/2}^{pi/2} A(theta) exp(-j k [x cos theta + y sin theta]) dtheta,   k = k0 sec^2 theta
//! A = (2 k0/pi) sec^3 theta S,     S = int int Y_x exp(k z + j kappa x) dz dx,   kappa = k0 sec theta
//!   = -(2j/pi) k0^2 sec^4 theta (P + j Q)   for a hull whose ends close
//! P + j Q = int F exp(j kappa x) dx,   F(x) = int_{-T}^0 Y exp(k z) dz
//! R = (pi/2) rho V^2 int |A|^2 cos^3 theta dtheta
//! ```
//!
//! | symbol | unit | meaning |
//! | --- | --- | --- |
//! | theta | rad | direction of a wave from the track; here always `t = tan theta` |
//! | k0 = g/V^2 | rad/m | wave number of the transverse waves, g = 9.81 m/s^2 |
//! | Y | m | half-breadth, of [`Hull`] |
//! | A | m | amplitude per radian of theta; even in theta, since it depends on sec theta alone |
//! | P, Q | m^3 | Kochin function |
//! | R | N | wave resistance; `Cw = R/(rho V^2 S/2)` with the wetted surface S |
//!
//! `Y` is piecewise quadratic (see [`hull`](crate::scene::hull)); with it all integrals over the hull are
//! exact, whatever the wave number: moments of `exp(k z)` in z, Filon's quadrature in x. The form with `Y_x`
//! is used for A: it does not lose the ends of the hull in differences, and it defines what an open stern is
//! ([`Transom`]).
//!
//! Source: Tuck, Lazauskas, Scullen, *Sea Wave Pattern Evaluation I* (1999), sign and factor of the paper's
//! (25) corrected; Michell (1898) for R. Linear, thin ship, deep water, steady course, fixed trim; no
//! viscosity. Real slow ships (below a Froude number of about 0.2) make smaller waves than the theory
//! predicts.
//!
//! Limits: 0 to 100 m/s. Below [`LEAST_SPEED_MPS`] a ship makes no waves, and no ship makes waves of more
//! than
//! [`LARGEST_WAVE_NUMBER_RADPM`]: there A = 0. A ship that sails backwards is refused.
//!
//! ```
//! use nereus::scene::hull::{Hull, Particulars};
//! use nereus::sea::wake::kochin::{Kochin, Transom, resistance_coefficient};
//! let hull = Hull::wigley(100.0, 10.0, 6.25)?;
//! let speed_mps = 0.3 * (9.81_f64 * 100.0).sqrt();
//! let ship = Kochin::new(&hull, speed_mps, Transom::Open)?;
//! let at_cusp = ship.amplitude_m(0.5_f64.sqrt());
//! assert!(at_cusp.norm() > 0.0 && at_cusp == ship.amplitude_m(-0.5_f64.sqrt()));
//! let surface_m2 = Particulars::of(&hull).wetted_surface_m2;
//! let cw = resistance_coefficient(ship.wave_resistance_n(1000.0)?, speed_mps, 1000.0, surface_m2);
//! assert!((cw - 2.142e-3).abs() < 1e-6);
//! assert!(Kochin::new(&hull, -1.0, Transom::Open).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;
use thiserror::Error;

use crate::scene::Hull;
use crate::scene::hull::Panel;
use crate::sea::GRAVITY_MPS2;

/// Slowest ship that makes waves, m/s: those of slower ones (6 mm and less) are ripples of surface tension.
pub const LEAST_SPEED_MPS: f64 = 0.1;
/// Fastest ship, m/s.
pub const MOST_SPEED_MPS: f64 = 100.0;
/// Largest wave number that a ship makes, rad/m: far beyond what water carries, far from overflow.
pub const LARGEST_WAVE_NUMBER_RADPM: f64 = 1e9;
/// Most nodes of the resistance integral.
const MOST_NODES: f64 = 4e5;
/// Where the resistance integral ends, in units of the tangent beyond which |A| has its last form. What
/// remains of it falls by the fourth power (4e-8 of the whole where ends close), and is added in closed form.
const TAIL: f64 = 60.0;

/// What the water does behind an immersed transom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transom {
    /// The flow leaves the edge and the transom is dry: sources up to the edge, none for the step to nothing
    /// behind it.
    #[default]
    Open,
    /// A flat stern closes the hull: the step of Y is part of it. (25) of the paper as it stands.
    Capped,
}

/// Why there are no amplitudes, or no resistance.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum KochinError {
    /// A speed out of range.
    #[error("ship's speed of {value_mps} m/s: allowed are 0 to {MOST_SPEED_MPS} m/s")]
    Speed {
        /// The speed given, m/s.
        value_mps: f64,
    },
    /// A density out of range.
    #[error("water of {value_kgpm3} kg/m^3: allowed are 1 to 10000 kg/m^3")]
    Density {
        /// The density given, kg/m^3.
        value_kgpm3: f64,
    },
    /// A resistance integral that oscillates too fast.
    #[error(
        "wave resistance at a Froude number of {froude:.1e} needs {nodes:.1e} nodes: allowed are {MOST_NODES:.0e}; a faster ship"
    )]
    Slow {
        /// Speed over sqrt(g L).
        froude: f64,
        /// Nodes needed.
        nodes: f64,
    },
}

/// A hull at a speed.
#[derive(Clone, Debug)]
pub struct Kochin {
    speed_mps: f64,
    k0_radpm: f64,
    /// Panels of stations, of waterlines.
    along: Vec<Panel>,
    up: Vec<Panel>,
    waterlines: usize,
    /// `[station][waterline]`, m.
    half_breadths_m: Vec<f64>,
    /// First and last station, depth of the hull, m.
    ends_m: [f64; 2],
    depth_m: f64,
    /// Whether a step at the bow, at the stern is part of the hull.
    steps: [bool; 2],
}

impl Kochin {
    /// Of a hull at a speed.
    ///
    /// # Errors
    /// A speed out of range.
    pub fn new(hull: &Hull, speed_mps: f64, transom: Transom) -> Result<Self, KochinError> {
        if !(0.0..=MOST_SPEED_MPS).contains(&speed_mps) {
            return Err(KochinError::Speed { value_mps: speed_mps });
        }
        let stations = hull.stations_m().len();
        let blunt = |station: usize| hull.half_breadths_m(station).iter().any(|y| *y > 0.0);
        let ends_m = [hull.stations_m()[0], hull.stations_m()[stations - 1]];
        Ok(Self {
            speed_mps,
            k0_radpm: GRAVITY_MPS2 / (speed_mps * speed_mps),
            along: Panel::all(hull.stations_m()),
            up: Panel::all(hull.waterlines_m()),
            waterlines: hull.waterlines_m().len(),
            half_breadths_m: (0..stations).flat_map(|i| hull.half_breadths_m(i).iter().copied()).collect(),
            ends_m,
            depth_m: hull.depth_m(),
            steps: [blunt(0), transom == Transom::Capped && blunt(stations - 1)],
        })
    }

    /// Whether the ship is too slow for waves.
    pub fn is_still(&self) -> bool {
        self.speed_mps < LEAST_SPEED_MPS
    }

    /// Wave number of the waves that run along with the ship, rad/m; infinite for a ship at rest.
    pub fn transverse_radpm(&self) -> f64 {
        self.k0_radpm
    }

    /// Speed over `sqrt(g L)`.
    pub fn froude(&self) -> f64 {
        self.speed_mps / (GRAVITY_MPS2 * self.length_m()).sqrt()
    }

    fn length_m(&self) -> f64 {
        self.ends_m[1] - self.ends_m[0]
    }

    /// Wave numbers k and kappa in the direction of tangent t, rad/m; `None` where there are no waves.
    fn wave_numbers_radpm(&self, tan_theta: f64) -> Option<[f64; 2]> {
        // A tangent that is no number, or a square that is too large for one, has none either.
        let sec2 = 1.0 + tan_theta * tan_theta;
        let k = self.k0_radpm * sec2;
        (!self.is_still() && k <= LARGEST_WAVE_NUMBER_RADPM).then(|| [k, self.k0_radpm * sec2.sqrt()])
    }

    /// Amplitude A in the direction whose tangent is given, m; even in it.
    ///
    /// ```
    /// # use nereus::scene::hull::Hull;
    /// # use nereus::sea::wake::kochin::{Kochin, Transom};
    /// # let hull = Hull::wigley(100.0, 10.0, 6.25)?;
    /// let ship = Kochin::new(&hull, 4.5, Transom::Open)?;
    /// // Across the track, and beyond any number.
    /// assert_eq!(ship.amplitude_m(std::f64::consts::FRAC_PI_2.tan()).norm(), 0.0);
    /// assert_eq!(ship.amplitude_m(f64::INFINITY).norm(), 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn amplitude_m(&self, tan_theta: f64) -> Complex64 {
        let Some([k, kappa]) = self.wave_numbers_radpm(tan_theta) else { return Complex64::ZERO };
        let weights_m = self.weights_m(k);
        let depthwise_m2 = |station: usize| self.depthwise_m2(station, &weights_m);
        let mut sum_m2 = Complex64::ZERO;
        if self.steps[0] {
            sum_m2 += depthwise_m2(0) * Complex64::cis(kappa * self.ends_m[0]);
        }
        let mut filon = Filon::default();
        let mut fore_m2 = depthwise_m2(0);
        for (i, panel) in self.along.iter().enumerate() {
            let values_m2 = [fore_m2, depthwise_m2(2 * i + 1), depthwise_m2(2 * i + 2)];
            fore_m2 = values_m2[2];
            let [_, c1, c2] = panel.quadratic(&values_m2);
            let [even, odd, _] = filon.moments(kappa * panel.half);
            // The slope is (c1 + 2 c2 s)/half, the step half ds.
            sum_m2 += Complex64::cis(kappa * panel.middle) * Complex64::new(c1 * even, 2.0 * c2 * odd);
        }
        if self.steps[1] {
            sum_m2 -= fore_m2 * Complex64::cis(kappa * self.ends_m[1]);
        }
        let sec = kappa / self.k0_radpm;
        sum_m2 * (2.0 / PI * self.k0_radpm * sec * sec * sec)
    }

    /// Kochin function `P + j Q`, m^3: that of the hull up to its last station, whatever stands behind it.
    pub fn kochin_m3(&self, tan_theta: f64) -> Complex64 {
        let Some([k, kappa]) = self.wave_numbers_radpm(tan_theta) else { return Complex64::ZERO };
        let weights_m = self.weights_m(k);
        let mut filon = Filon::default();
        let mut sum_m3 = Complex64::ZERO;
        for (i, panel) in self.along.iter().enumerate() {
            let values_m2 = [0, 1, 2].map(|n| self.depthwise_m2(2 * i + n, &weights_m));
            let [c0, c1, c2] = panel.quadratic(&values_m2);
            let [even, odd, second] = filon.moments(kappa * panel.half);
            sum_m3 += Complex64::cis(kappa * panel.middle)
                * Complex64::new(c0 * even + c2 * second, c1 * odd)
                * panel.half;
        }
        sum_m3
    }

    /// F at a station, m^2.
    fn depthwise_m2(&self, station: usize, weights_m: &[f64]) -> f64 {
        let row = &self.half_breadths_m[station * self.waterlines..(station + 1) * self.waterlines];
        row.iter().zip(weights_m).map(|(y, weight)| y * weight).sum()
    }

    /// Weights of the waterlines in F, m: exact for piecewise quadratic Y.
    fn weights_m(&self, k_radpm: f64) -> Vec<f64> {
        let mut weights_m = vec![0.0; self.waterlines];
        for (i, panel) in self.up.iter().enumerate() {
            let top_m = (panel.middle + panel.half).min(0.0);
            // Of waves this short nothing is felt down here; exp(-745) is the smallest number.
            if k_radpm * top_m < -745.0 {
                continue;
            }
            let decay = (k_radpm * top_m).exp();
            let weights = panel.weights(decaying_moments(k_radpm * panel.half));
            for (sum, weight) in weights_m[2 * i..].iter_mut().zip(weights) {
                *sum += decay * weight;
            }
        }
        weights_m
    }

    /// Wave resistance, N, in water of the given density.
    ///
    /// Trapezoid in u, `t = sinh u` or `t = u`, whichever takes fewer nodes: the integrand is even and
    /// analytic, so the rule is exact to rounding once the step resolves the phase `k0 L sec theta` between
    /// the ends of the hull. The rest beyond the last node is that of |A|^2 going as `t^0` (ends that close)
    /// or `t^2` (steps). Relative error below 1e-6 for hulls whose ends close; with a step 1e-4.
    ///
    /// # Errors
    /// A density out of range, or a ship too slow for the integral.
    pub fn wave_resistance_n(&self, density_kgpm3: f64) -> Result<f64, KochinError> {
        if !(1.0..=1e4).contains(&density_kgpm3) {
            return Err(KochinError::Density { value_kgpm3: density_kgpm3 });
        }
        if self.is_still() {
            return Ok(0.0);
        }
        let integral_m2 = self.rule()?.integral(|t| self.amplitude_m(t).norm_sqr(), self.last_power());
        // Both sides of the track.
        Ok(FRAC_PI_2 * density_kgpm3 * self.speed_mps * self.speed_mps * 2.0 * integral_m2)
    }

    /// Power of t with which |A|^2 goes at the end.
    fn last_power(&self) -> i32 {
        if self.steps.contains(&true) { 2 } else { 0 }
    }

    fn rule(&self) -> Result<Rule, KochinError> {
        let k0 = self.k0_radpm;
        // Waves shorter than the draught see a wall: from there |A| has its last form.
        let end = TAIL * (k0 * self.depth_m).powf(-0.5).max(1.0);
        // 40: exp(-40) is what is left of the pole of sec theta at t = j; a quarter more than the phase
        // needs.
        let uniform = Rule { hyperbolic: false, end, rate: 40.0 + 1.25 * k0 * self.length_m() };
        let hyperbolic = Rule {
            hyperbolic: true,
            end: end.asinh(),
            rate: 40.0 + 1.25 * k0 * self.length_m() * end.hypot(1.0),
        };
        let rule = if uniform.nodes() <= hyperbolic.nodes() { uniform } else { hyperbolic };
        let nodes = rule.nodes();
        if nodes <= MOST_NODES { Ok(rule) } else { Err(KochinError::Slow { froude: self.froude(), nodes }) }
    }
}

/// Trapezoid rule for `int_0^inf f(t) (1 + t^2)^(-5/2) dt`.
struct Rule {
    /// Whether t = sinh u, else t = u.
    hyperbolic: bool,
    /// Largest u.
    end: f64,
    /// Largest angular rate of the integrand in u, with its reserve.
    rate: f64,
}

impl Rule {
    fn nodes(&self) -> f64 {
        (self.end * self.rate / (2.0 * PI)).ceil()
    }

    fn integral(&self, f: impl Fn(f64) -> f64, last_power: i32) -> f64 {
        let nodes = self.nodes();
        let step = self.end / nodes;
        let (mut sum, mut last, mut counted) = (0.0, 0.0, 0.0);
        for n in 0..=nodes as usize {
            let u = n as f64 * step;
            let (t, rate) = if self.hyperbolic { (u.sinh(), u.cosh()) } else { (u, 1.0) };
            let value = f(t);
            let weight = if n == 0 || n as f64 == nodes { 0.5 } else { 1.0 };
            sum += weight * value * (1.0 + t * t).powf(-2.5) * rate;
            if u > 0.9 * self.end {
                last += value / t.powi(last_power);
                counted += 1.0;
            }
        }
        let end = if self.hyperbolic { self.end.sinh() } else { self.end };
        let rest = last / counted * end.powi(last_power - 4) / f64::from(4 - last_power);
        sum * step + rest
    }
}

/// Wave resistance as a coefficient, `R/(rho V^2 S/2)`; 0 for a ship at rest.
pub fn resistance_coefficient(
    resistance_n: f64,
    speed_mps: f64,
    density_kgpm3: f64,
    wetted_surface_m2: f64,
) -> f64 {
    let scale_n = 0.5 * density_kgpm3 * speed_mps * speed_mps * wetted_surface_m2;
    if scale_n > 0.0 { resistance_n / scale_n } else { 0.0 }
}

/// Moments of `exp(j t s)` over a panel, kept from one to the next: panels are mostly of one length.
#[derive(Default)]
struct Filon {
    t: f64,
    moments: Option<[f64; 3]>,
}

impl Filon {
    fn moments(&mut self, t: f64) -> [f64; 3] {
        match self.moments {
            Some(moments) if self.t == t => moments,
            _ => {
                self.t = t;
                *self.moments.insert(oscillating_moments(t))
            }
        }
    }
}

/// `int_-1^1 cos ts ds`, `int s sin ts ds`, `int s^2 cos ts ds`: Filon's alpha, beta and gamma are sums of
/// these.
fn oscillating_moments(t: f64) -> [f64; 3] {
    // Below 1 by series: the closed forms lose t^-2 and t^-3. Ten terms leave 1/20!.
    if t < 1.0 {
        let [even, odd, second] = moments_by_series(-t * t);
        return [2.0 * even, 2.0 * t * odd, 2.0 * second];
    }
    let (sin, cos) = t.sin_cos();
    let odd = 2.0 * (sin / t - cos) / t;
    [2.0 * sin / t, odd, 2.0 * (sin / t) - 2.0 * odd / t]
}

/// The sums over n of `square^n/(2n)!` times `1/(2n + 1)`, `1/((2n + 1)(2n + 3))`, `1/(2n + 3)`, to n = 9.
fn moments_by_series(square: f64) -> [f64; 3] {
    let (mut even, mut odd, mut second) = (0.0, 0.0, 0.0);
    let mut term = 1.0;
    for n in 0..10 {
        let m = f64::from(2 * n);
        even += term / (m + 1.0);
        odd += term / ((m + 1.0) * (m + 3.0));
        second += term / (m + 3.0);
        term *= square / ((m + 1.0) * (m + 2.0));
    }
    [even, odd, second]
}

/// `int_-1^1 s^n exp(tau (s - 1)) ds`, n = 0, 1, 2, for tau >= 0.
fn decaying_moments(tau: f64) -> [f64; 3] {
    // Below 1 by series, for the same reason.
    if tau < 1.0 {
        let [even, odd, second] = moments_by_series(tau * tau);
        let decay = 2.0 * (-tau).exp();
        return [decay * even, decay * tau * odd, decay * second];
    }
    let low = (-2.0 * tau).exp();
    let first = (1.0 - low) / tau;
    let second = (1.0 + low - first) / tau;
    [first, second, (1.0 - low - 2.0 * second) / tau]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Series and closed form on either side of where they meet; the closed form loses at most 1/t^3 = 1
    /// there, so that some roundings of terms of size 2 are left.
    #[test]
    fn moments_join() {
        let (below, above) = (1.0 - 1e-15, 1.0);
        for (a, b) in [
            (oscillating_moments(below), oscillating_moments(above)),
            (decaying_moments(below), decaying_moments(above)),
        ] {
            for (a, b) in a.into_iter().zip(b) {
                assert!((a - b).abs() < 1e-14, "{a:e} {b:e}");
            }
        }
        assert_eq!(oscillating_moments(0.0), [2.0, 0.0, 2.0 / 3.0]);
        assert_eq!(decaying_moments(0.0), [2.0, 0.0, 2.0 / 3.0]);
    }

    /// Filon's own weights, as they are printed in textbooks, are sums of the moments.
    #[test]
    fn filons_weights_are_sums_of_moments() {
        for t in [0.3, 0.9, 1.7, 40.0] {
            let (sin, cos) = f64::sin_cos(t);
            let beta = 2.0 * (t * (1.0 + cos * cos) - 2.0 * sin * cos) / t.powi(3);
            let gamma = 4.0 * (sin - t * cos) / t.powi(3);
            let [even, odd, second] = oscillating_moments(t);
            // gamma: the middle of a panel; beta: an end, from the panels on both sides of it. At t = 0.3 the
            // textbook's form loses t^-3 = 40 roundings of terms of about 1.
            assert!((gamma - (even - second)).abs() < 1e-13);
            assert!(
                (beta - (second * cos + odd * sin)).abs() < 1e-13,
                "{t}: {beta} {}",
                second * cos + odd * sin
            );
        }
    }
}
