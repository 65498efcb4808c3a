//! The waves of a ship as a finite sum.
//!
//! The height is `Re of the integral of A exp(-j k (x cos theta + y sin theta)) d theta`,
//! `k = k0 sec^2 theta`, `k0 = g/V^2`, x astern, y to starboard. With `t = tan theta`,
//! `d theta = dt/(1 + t^2)` and nodes uniform in t it is a sum of plane waves
//!
//! `a_n = A(t_n) W(k_n) dt/(1 + t_n^2)`, `kx = k0 sqrt(1 + t^2)`, `ky = k0 t sqrt(1 + t^2)`,
//! `w = V kx = sqrt(g k)`.
//!
//! **Band limit.** Slopes of a wall-sided hull do not converge without one: `W(k) = exp(-(k/kc)^4)`, kc by
//! default `0.7 pi/dx`. The sum ends at `k = 2.6 kc`, where W is 1e-20. What a map leaves out belongs to the
//! small waves inside its facets.
//!
//! **Count.** The trapezoid rule is exact but for its aliases: nodes `h` apart also add what varies by
//! `2 pi/h` per unit t. It is exact to rounding once the phase turns by less than a turn from node to node;
//! here it turns by less than half of one wherever the wake is asked for (the length of the ship added to the
//! reach, since bow and stern are where A's own phase comes from). For near places `h <= 1/6` resolves
//! `1/(1 + t^2)`, which is singular at `t = +-j`: the rule's error there is `exp(-2 pi/h) = 4e-17`; at least
//! 64 a side resolve W.
//!
//! A is asked for `t >= 0` alone: a ship is symmetric port and starboard.
//!
//! ```
//! use nereus::sea::wake::nodes::{Band, count_a_side};
//! use nereus::sea::wake::Reach;
//! let band = Band::of_facets(1.0);
//! let k0 = 9.81 / (4.5 * 4.5);
//! let most = band.most_tan_theta(k0).unwrap();
//! assert!((most.atan().to_degrees() - 73.1).abs() < 0.1);
//! let reach = Reach { along_m: 500.0, across_m: 250.0 };
//! assert!(count_a_side(k0, most, reach) > 1000.0);
//! // Waves all shorter than what the band lets pass.
//! assert_eq!(band.most_tan_theta(6.0), None);
//! ```

use super::fault::MAX_NODES;
use std::f64::consts::PI;

use num_complex::Complex64;

use super::course::Reach;
use crate::sea::wake::fault::WakeError;

/// Fewest nodes on either side of t = 0.
const LEAST_A_SIDE: f64 = 64.0;
/// Step in t that resolves `1/(1 + t^2)`.
const LARGEST_STEP: f64 = 1.0 / 6.0;
/// Wave number over kc at which the sum ends.
const END: f64 = 2.6;
/// W of a ship's longest wave below which it has no wake on the map: -120 dB.
const NO_WAVES: f64 = 1e-6;

/// Band limit of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// kc, rad/m.
    pub cutoff_rad_m: f64,
}

impl Band {
    /// That of facets of a side, m: `0.7 pi/dx`.
    pub fn of_facets(facet_m: f64) -> Self {
        Self { cutoff_rad_m: 0.7 * PI / facet_m }
    }

    /// `W(k)`, k in rad/m.
    pub fn weight(&self, k_rad_m: f64) -> f64 {
        (-(k_rad_m / self.cutoff_rad_m).powi(4)).exp()
    }

    /// Largest `tan theta` of a sum; `None` when even the longest wave, k0, rad/m, is taken away.
    pub fn most_tan_theta(&self, k0_rad_m: f64) -> Option<f64> {
        (self.weight(k0_rad_m) > NO_WAVES).then(|| (END * self.cutoff_rad_m / k0_rad_m - 1.0).sqrt())
    }
}

/// Nodes needed on either side of t = 0 for places up to a reach from midship.
pub fn count_a_side(k0_rad_m: f64, most_tan_theta: f64, reach: Reach) -> f64 {
    // Rate of the phase with t: k0 [x t + y (1 + 2 t^2)]/sqrt(1 + t^2); it grows with t.
    let t = most_tan_theta;
    let t2 = t * t;
    let rate = k0_rad_m * (reach.along_m * t + reach.across_m * (1.0 + 2.0 * t2)) / (1.0 + t2).sqrt();
    (rate * t / PI).max(t / LARGEST_STEP).max(LEAST_A_SIDE).ceil()
}

/// One wave of a wake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Weighted complex amplitude, m.
    pub amplitude_m: Complex64,
    /// Wave number ahead, rad/m.
    pub ahead_rad_m: f64,
    /// Wave number to port, rad/m.
    pub port_rad_m: f64,
    /// Magnitude of the wave number, rad/m.
    pub k_rad_m: f64,
    /// Angular frequency at a fixed place, rad/s.
    pub omega_rad_s: f64,
}

/// The waves of a ship of a speed, m/s above 0, with a longest wave of k0, rad/m; `t` up to `most_tan_theta`.
pub(super) fn nodes(
    speed_mps: f64,
    k0_rad_m: f64,
    most_tan_theta: f64,
    band: Band,
    reach: Reach,
    amplitude_m: impl Fn(f64) -> Complex64,
) -> Result<Vec<Node>, WakeError> {
    let count = count_a_side(k0_rad_m, most_tan_theta, reach);
    let allowed = MAX_NODES / 2;
    // A band limit without end makes the count infinite or NaN.
    if count.is_nan() || count > allowed as f64 {
        return Err(WakeError::Nodes {
            needed: 2.0 * count,
            along_m: reach.along_m,
            across_m: reach.across_m,
        });
    }
    let step = most_tan_theta / count;
    let count = count as usize;
    let mut nodes = Vec::with_capacity(2 * count + 1);
    for i in 0..=count {
        let t = step * i as f64;
        let sec2 = 1.0 + t * t;
        let sec = sec2.sqrt();
        let k = k0_rad_m * sec2;
        let amplitude = amplitude_m(t);
        if !(amplitude.re.is_finite() && amplitude.im.is_finite()) {
            return Err(WakeError::Amplitude { tan_theta: t });
        }
        let node = Node {
            amplitude_m: amplitude * (band.weight(k) * step / sec2),
            ahead_rad_m: k0_rad_m * sec,
            port_rad_m: k0_rad_m * t * sec,
            k_rad_m: k,
            omega_rad_s: speed_mps * k0_rad_m * sec,
        };
        if i > 0 {
            nodes.push(Node { port_rad_m: -node.port_rad_m, ..node });
        }
        nodes.push(node);
    }
    Ok(nodes)
}
