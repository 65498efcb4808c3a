//! Fixed-interval smoother of one coordinate.
//!
//! State `x = (position, velocity, acceleration)`, driven by white jerk of density q (m^2/s^5):
//!
//! ```text
//! F(h) = | 1 h h^2/2 |      Q(h) = q | h^5/20 h^4/8 h^3/6 |      z = position + noise of std sigma
//!        | 0 1   h   |               | h^4/8  h^3/3 h^2/2 |
//!        | 0 0   1   |               | h^3/6  h^2/2 h     |
//! ```
//!
//! Forward Kalman filter with a diffuse start, then the backward pass of Bryson and Frazier, which gives the
//! same estimate as that of Rauch, Tung and Striebel (*AIAA J.* 3 (1965) 1445) without inverting a
//! covariance. Times need not be uniform; a fix may be left out (its node is then carried by its neighbours).
//!
//! The mean of this process between two nodes is the quintic through their states (the smoother is the
//! quintic smoothing spline that minimises `sum (z - p)^2/sigma^2 + (1/q) int p'''^2 dt`; Wahba 1978), so
//! [`crate::scene::hermite`] adds nothing to it: the path is even C4.
//!
//! ```
//! use nereus::motion::smoother::{Series, smooth};
//! // A parabola is in the span of the states: it comes back as it is.
//! let t: Vec<f64> = (0..20).map(|i| 1.3 * i as f64).collect();
//! let step_s: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
//! let z_m: Vec<f64> = t.iter().map(|t| 5.0 + 2.0 * t - 0.3 * t * t).collect();
//! let used = vec![true; t.len()];
//! let series = Series { step_s: &step_s, z_m: &z_m, used: &used, sigma_m: 3.0 };
//! let states = smooth(&series, 1e-3);
//! assert!((states[7][1] - (2.0 - 0.6 * t[7])).abs() < 1e-5);
//! assert!((states[7][2] + 0.6).abs() < 1e-5);
//! ```

/// Standard deviations before the first fix, about it: position (m), velocity (m/s), acceleration (m/s^2).
/// Wide enough for anything from a mooring to an orbit, so that the start does not matter.
const DIFFUSE: [f64; 3] = [1e5, 1e5, 1e3];
/// Updates that only replace the diffuse start by data; they say nothing about q.
const SETTLING: usize = 3;

/// One coordinate of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// From each fix to the next, s; one fewer than fixes.
    pub step_s: &'a [f64],
    /// Measured coordinate, m.
    pub z_m: &'a [f64],
    /// Whether a fix is used.
    pub used: &'a [bool],
    /// Standard deviation of a fix, m.
    pub sigma_m: f64,
}

type Matrix = [[f64; 3]; 3];

/// What the filter knew at a fix before it was used, and what it used.
struct Step {
    mean: [f64; 3],
    cov: Matrix,
    /// Innovation and its variance, if the fix was used.
    innovation: Option<(f64, f64)>,
}

/// Walks forward; `visit` sees every step.
fn filter(series: &Series, q: f64, mut visit: impl FnMut(Step)) {
    let Some(&origin) = series.z_m.first() else { return };
    let mut mean = [origin, 0.0, 0.0];
    let mut cov: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { DIFFUSE[i].powi(2) } else { 0.0 }));
    let r = series.sigma_m * series.sigma_m;
    for (i, (&z, &used)) in series.z_m.iter().zip(series.used).enumerate() {
        if i > 0 {
            let h = series.step_s[i - 1];
            (mean, cov) = predict(mean, &cov, h, q);
        }
        let innovation = used.then(|| (z - mean[0], cov[0][0] + r));
        visit(Step { mean, cov, innovation });
        if let Some((e, s)) = innovation {
            let gain = [cov[0][0] / s, cov[1][0] / s, cov[2][0] / s];
            for k in 0..3 {
                mean[k] += gain[k] * e;
            }
            cov = joseph(&cov, gain, r);
        }
    }
}

fn predict(x: [f64; 3], p: &Matrix, h: f64, q: f64) -> ([f64; 3], Matrix) {
    let h2 = 0.5 * h * h;
    let mean = [x[0] + h * x[1] + h2 * x[2], x[1] + h * x[2], x[2]];
    // F P, then (F P) F^T.
    let fp: Matrix = std::array::from_fn(|k| match k {
        0 => std::array::from_fn(|j| p[0][j] + h * p[1][j] + h2 * p[2][j]),
        1 => std::array::from_fn(|j| p[1][j] + h * p[2][j]),
        _ => p[2],
    });
    let mut cov: Matrix = std::array::from_fn(|i| {
        let row = fp[i];
        [row[0] + h * row[1] + h2 * row[2], row[1] + h * row[2], row[2]]
    });
    let (q1, q2, q3) = (q * h, q * h * h / 2.0, q * h * h * h);
    let (q4, q5) = (q3 * h / 8.0, q3 * h * h / 20.0);
    let noise = [[q5, q4, q3 / 6.0], [q4, q3 / 3.0, q2], [q3 / 6.0, q2, q1]];
    for i in 0..3 {
        for j in 0..3 {
            cov[i][j] += noise[i][j];
        }
    }
    (mean, symmetric(&cov))
}

/// `(I - K H) P (I - K H)^T + K r K^T`: stays positive in rounding, where `(I - K H) P` does not.
fn joseph(p: &Matrix, k: [f64; 3], r: f64) -> Matrix {
    let left: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] - k[i] * p[0][j]));
    let cov: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| left[i][j] - left[i][0] * k[j] + r * k[i] * k[j]));
    symmetric(&cov)
}

fn symmetric(p: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (p[i][j] + p[j][i])))
}

/// Smoothed position, velocity and acceleration at every fix, for jerk density `q` (m^2/s^5).
pub fn smooth(series: &Series, q: f64) -> Vec<[f64; 3]> {
    let mut steps = Vec::with_capacity(series.z_m.len());
    filter(series, q, |step| steps.push(step));
    let mut states = vec![[0.0; 3]; steps.len()];
    // lambda of Bryson and Frazier: the gradient of what is yet to come.
    let mut lambda = [0.0; 3];
    for (i, step) in steps.iter().enumerate().rev() {
        if let Some((e, s)) = step.innovation {
            // (I - K H)^T lambda - H^T e/s: only the first component changes.
            let pulled: f64 = (0..3).map(|k| step.cov[k][0] / s * lambda[k]).sum();
            lambda[0] -= pulled + e / s;
        }
        states[i] = std::array::from_fn(|k| {
            let correction: f64 = (0..3).map(|j| step.cov[k][j] * lambda[j]).sum();
            step.mean[k] - correction
        });
        if i > 0 {
            let h = series.step_s[i - 1];
            lambda =
                [lambda[0], lambda[1] + h * lambda[0], lambda[2] + h * lambda[1] + 0.5 * h * h * lambda[0]];
        }
    }
    states
}

/// Twice the negative log-likelihood of the fixes for jerk density `q`, up to a constant.
pub fn misfit(series: &Series, q: f64) -> f64 {
    let mut seen = 0;
    let mut sum = 0.0;
    filter(series, q, |step| {
        if let Some((e, s)) = step.innovation {
            seen += 1;
            if seen > SETTLING {
                sum += s.ln() + e * e / s;
            }
        }
    });
    sum
}

/// Range of the decimal logarithm of the jerk density (m^2/s^5) that is searched: from a barge to a
/// rocket.
const SEARCH_LOG10: (f64, f64) = (-10.0, 6.0);

/// The jerk density that makes the fixes of these coordinates most likely.
pub fn likeliest_density(coordinates: &[Series]) -> f64 {
    let cost =
        |log10_q: f64| -> f64 { coordinates.iter().map(|series| misfit(series, 10f64.powf(log10_q))).sum() };
    // A coarse scan first: the likelihood may have more than one hump.
    let (low, high) = SEARCH_LOG10;
    let mut best = (f64::INFINITY, low);
    let mut log10_q = low;
    while log10_q <= high {
        let here = cost(log10_q);
        if here < best.0 {
            best = (here, log10_q);
        }
        log10_q += 1.0;
    }
    // Golden section to a hundredth of a decade.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let (mut a, mut b) = (best.1 - 1.0, best.1 + 1.0);
    let (mut c, mut d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut fc, mut fd) = (cost(c), cost(d));
    while b - a > 0.01 {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - GOLDEN * (b - a);
            fc = cost(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + GOLDEN * (b - a);
            fd = cost(d);
        }
    }
    10f64.powf(0.5 * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The smoother solves least squares: the gradient of its cost vanishes. Checked against the
    /// normal equations of a batch fit, `min sum (z-p)^2/sigma^2 + sum |x+ - F x|^2_{Q^-1}`,
    /// by the optimality of perturbed states.
    #[test]
    fn smoothed_states_are_where_the_cost_is_least() {
        let step_s = [1.0, 0.7, 2.0, 1.1, 0.4, 1.6, 1.0];
        let z_m = [0.0, 3.0, 2.0, 9.0, 8.0, 14.0, 9.0, 20.0];
        let used = [true, true, true, false, true, true, true, true];
        let series = Series { step_s: &step_s, z_m: &z_m, used: &used, sigma_m: 2.0 };
        let q = 0.5;
        let states = smooth(&series, q);
        // The minimum over the path of int p'''^2 between two states, by 8-point sums of the quintic.
        let cost = |states: &[[f64; 3]]| {
            let mut sum = 0.0;
            for (i, state) in states.iter().enumerate() {
                if used[i] {
                    sum += (z_m[i] - state[0]).powi(2) / 4.0;
                }
                if i > 0 {
                    let (a, b, h) = (states[i - 1], state, step_s[i - 1]);
                    let controls = crate::scene::hermite::acceleration_controls(
                        b[0] - a[0],
                        [a[1], b[1]],
                        [a[2], b[2]],
                        h,
                    );
                    // p''' is the quadratic with Bernstein values 3 (c_{k+1} - c_k)/h; its square integrates
                    // to h/5 [c0^2 + c2^2 + c0 c1 + c1 c2 + (2 c1^2 + c0 c2)/3] of those values.
                    let j: [f64; 3] = std::array::from_fn(|k| 3.0 * (controls[k + 1] - controls[k]) / h);
                    let cross = (2.0 * j[1] * j[1] + j[0] * j[2]) / 3.0;
                    sum += h / 5.0 * (j[0] * j[0] + j[2] * j[2] + j[0] * j[1] + j[1] * j[2] + cross) / q;
                }
            }
            sum
        };
        let best = cost(&states);
        for i in 0..states.len() {
            for k in 0..3 {
                for step in [-1e-3, 1e-3] {
                    let mut moved = states.clone();
                    moved[i][k] += step;
                    assert!(cost(&moved) > best, "node {i} component {k}: {} {best}", cost(&moved));
                }
            }
        }
    }
}
