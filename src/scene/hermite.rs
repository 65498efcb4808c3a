//! Quintic Hermite segments, and node derivatives from a finite stencil.
//!
//! On a segment of length `h` (s) with `s = (t - t_0)/h`, values p, first derivatives v and second
//! derivatives a at both ends, the quintic with those six data is
//!
//! ```text
//! p(s) = p0 + (p1 - p0) (10 s^3 - 15 s^4 + 6 s^5)
//!      + h v0 (s - 6 s^3 + 8 s^4 - 3 s^5) + h v1 (-4 s^3 + 7 s^4 - 3 s^5)
//!      + h^2 a0 (s^2 - 3 s^3 + 3 s^4 - s^5)/2 + h^2 a1 (s^3 - 2 s^4 + s^5)/2
//! ```
//!
//! so a chain of segments is C2: value, velocity and acceleration are continuous at every node, and a
//! value depends on the two nodes beside it alone. It reproduces every polynomial up to degree 5.
//!
//! Node derivatives come from the polynomial through the [`STENCIL`] nearest nodes (weights by the recursion
//! of B. Fornberg, *Math. Comp.* 51 (1988) 699): with 7 nodes of spacing h the first derivative is exact to
//! O(h^6), the second to O(h^5), whatever the spacing.
//!
//! ```
//! use nereus::scene::hermite::Basis;
//! // t^5 over [1, 3] from its end values: exact to rounding.
//! let (h, s) = (2.0, 0.3);
//! let basis = Basis::at(s, h);
//! let p = |t: f64| [t.powi(5), 5.0 * t.powi(4), 20.0 * t.powi(3)];
//! let (a, b, x) = (p(1.0), p(3.0), p(1.6));
//! for (k, weights) in basis.rows().into_iter().enumerate() {
//!     let start = if k == 0 { a[0] } else { 0.0 };
//!     let got = start + weights[0] * (b[0] - a[0]) + weights[1] * a[1] + weights[2] * b[1]
//!         + weights[3] * a[2] + weights[4] * b[2];
//!     assert!((got - x[k]).abs() < 1e-12 * 1e3);
//! }
//! ```

/// Nodes whose polynomial gives the derivatives at a node.
pub const STENCIL: usize = 7;

/// Weights of `(p1 - p0, v0, v1, a0, a1)` for the value (to be added to p0), the first and the second
/// derivative with respect to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// For the value.
    pub value: [f64; 5],
    /// For the first derivative.
    pub first: [f64; 5],
    /// For the second derivative.
    pub second: [f64; 5],
}

impl Basis {
    /// At `s` in [0, 1] of a segment of `h_s` seconds.
    pub fn at(s: f64, h_s: f64) -> Self {
        let (s2, h) = (s * s, h_s);
        let s3 = s2 * s;
        let rate = h.recip();
        Self {
            value: [
                s3 * (10.0 + s * (-15.0 + 6.0 * s)),
                h * s * (1.0 + s2 * (-6.0 + s * (8.0 - 3.0 * s))),
                h * s3 * (-4.0 + s * (7.0 - 3.0 * s)),
                0.5 * h * h * s2 * (1.0 + s * (-3.0 + s * (3.0 - s))),
                0.5 * h * h * s3 * (1.0 + s * (-2.0 + s)),
            ],
            first: [
                rate * s2 * (30.0 + s * (-60.0 + 30.0 * s)),
                1.0 + s2 * (-18.0 + s * (32.0 - 15.0 * s)),
                s2 * (-12.0 + s * (28.0 - 15.0 * s)),
                0.5 * h * s * (2.0 + s * (-9.0 + s * (12.0 - 5.0 * s))),
                0.5 * h * s2 * (3.0 + s * (-8.0 + 5.0 * s)),
            ],
            second: [
                rate * rate * s * (60.0 + s * (-180.0 + 120.0 * s)),
                rate * s * (-36.0 + s * (96.0 - 60.0 * s)),
                rate * s * (-24.0 + s * (84.0 - 60.0 * s)),
                1.0 + s * (-9.0 + s * (18.0 - 10.0 * s)),
                s * (3.0 + s * (-12.0 + 10.0 * s)),
            ],
        }
    }

    /// Value, first and second derivative, in that order.
    pub fn rows(&self) -> [[f64; 5]; 3] {
        [self.value, self.first, self.second]
    }
}

/// The four Bernstein control values of the second derivative of a segment (it is a cubic): the second
/// derivative nowhere leaves their convex hull.
pub fn acceleration_controls(rise: f64, v: [f64; 2], a: [f64; 2], h_s: f64) -> [f64; 4] {
    let per_h = h_s.recip();
    let slope0 = per_h * (60.0 * per_h * rise - 36.0 * v[0] - 24.0 * v[1]) - 9.0 * a[0] + 3.0 * a[1];
    let slope1 = per_h * (60.0 * per_h * rise - 24.0 * v[0] - 36.0 * v[1]) - 3.0 * a[0] + 9.0 * a[1];
    [a[0], a[0] + slope0 / 3.0, a[1] - slope1 / 3.0, a[1]]
}

/// The nodes of the stencil of node `index` of `count`.
pub fn stencil(index: usize, count: usize) -> std::ops::Range<usize> {
    let width = STENCIL.min(count);
    let start = index.saturating_sub(width / 2).min(count - width);
    start..start + width
}

/// Weights of the values at times `t_s` (relative to the node, at most [`STENCIL`]) for the first and the
/// second derivative at 0.
pub fn derivative_weights(t_s: &[f64]) -> [[f64; STENCIL]; 2] {
    let mut c = [[0.0; STENCIL]; 3];
    c[0][0] = 1.0;
    let mut c1 = 1.0;
    let Some(&first) = t_s.first() else { return [[0.0; STENCIL]; 2] };
    let mut c4 = first;
    for i in 1..t_s.len().min(STENCIL) {
        let mut c2 = 1.0;
        let c5 = c4;
        c4 = t_s[i];
        for j in 0..i {
            let c3 = t_s[i] - t_s[j];
            c2 *= c3;
            if j == i - 1 {
                for k in (1..3).rev() {
                    c[k][i] = c1 * (k as f64 * c[k - 1][i - 1] - c5 * c[k][i - 1]) / c2;
                }
                c[0][i] = -c1 * c5 * c[0][i - 1] / c2;
            }
            for k in (1..3).rev() {
                c[k][j] = (c4 * c[k][j] - k as f64 * c[k - 1][j]) / c3;
            }
            c[0][j] = c4 * c[0][j] / c3;
        }
        c1 = c2;
    }
    [c[1], c[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stencil_weights_are_exact_for_degree_six() {
        let t = [-3.1, -1.7, -1.0, 0.0, 0.6, 2.2, 2.9];
        let [first, second] = derivative_weights(&t);
        for degree in 0..=6 {
            let sum = |w: &[f64; STENCIL]| w.iter().zip(t).map(|(w, t)| w * t.powi(degree)).sum::<f64>();
            let (want1, want2) = (f64::from(degree == 1), 2.0 * f64::from(degree == 2));
            // Terms reach 3.1^6 = 900 with weights of order one, seven of them.
            assert!((sum(&first) - want1).abs() < 7.0 * 900.0 * 1e-15, "{degree}");
            assert!((sum(&second) - want2).abs() < 7.0 * 900.0 * 4e-15, "{degree}");
        }
    }

    #[test]
    fn few_nodes_give_lower_degrees() {
        assert_eq!(stencil(0, 3), 0..3);
        assert_eq!(stencil(9, 10), 3..10);
        let [first, second] = derivative_weights(&[0.0, 2.0]);
        assert_eq!(&first[..2], &[-0.5, 0.5]);
        assert_eq!(second, [0.0; STENCIL]);
    }

    #[test]
    fn controls_bound_the_acceleration() {
        let (rise, v, a, h) = (40.0, [11.0, 9.5], [-2.0, 3.0], 4.0);
        let controls = acceleration_controls(rise, v, a, h);
        let (low, high) =
            controls.iter().fold((f64::MAX, f64::MIN), |(low, high), &c| (low.min(c), high.max(c)));
        for i in 0..=100 {
            let w = Basis::at(f64::from(i) / 100.0, h).second;
            let value = w[0] * rise + w[1] * v[0] + w[2] * v[1] + w[3] * a[0] + w[4] * a[1];
            assert!((low - 1e-12..=high + 1e-12).contains(&value), "{value} {low} {high}");
        }
    }
}
