//! What interpolation through nodes leaves of a quantity that changes in time.
//!
//! Through the values at nodes `t_i` goes one polynomial, `sum L_i(t) f(t_i)`, `L_i` of Lagrange. Of an
//! oscillation it leaves
//!
//! `E(w, t) = | e^{j w t} - sum L_i(t) e^{j w t_i} |`,   for n nodes and small `w`:
//! `|w|^n |prod (t - t_i)| / n!`
//!
//! and of a process with power `S(w) dw`, whatever the phases, the mean square `integral of S E^2 dw`. So one
//! function gives the error for waves, for gains that sweep by, and for whatever else is a sum of
//! oscillations.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `t_i`, `t` | nodes, place | s |
//! | `w` | angular frequency | rad/s |
//!
//! Limits: weights of Lagrange grow with the number of nodes; beyond 8 equally spaced ones they amplify
//! rounding.

use proptest::prelude::*;
/// Most nodes.
pub const MOST_NODES: usize = 8;
/// Most places at which errors are looked for, less one.
pub const MOST_PLACES: usize = 64;

/// Instants through which a polynomial goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nodes {
    count: usize,
    times_s: [f64; MOST_NODES],
}

impl Nodes {
    /// So many nodes, 1 to [`MOST_NODES`] (held within), a time apart, from 0 on.
    pub fn evenly(count: usize, spacing_s: f64) -> Self {
        Self { count: count.clamp(1, MOST_NODES), times_s: std::array::from_fn(|i| i as f64 * spacing_s) }
    }

    /// The nodes, s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s[..self.count]
    }

    /// From the first to the last, s.
    pub fn span_s(&self) -> f64 {
        self.times_s[self.count - 1]
    }

    /// Weights of the values at the nodes at a time.
    pub fn weights(&self, t_s: f64) -> [f64; MOST_NODES] {
        let times_s = self.times_s();
        std::array::from_fn(|i| {
            let Some(own_s) = times_s.get(i) else { return 0.0 };
            let others = times_s.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, other_s)| (t_s - other_s) / (own_s - other_s)).product()
        })
    }

    /// What is left of a function at a time: it less its interpolation.
    pub fn residue(&self, t_s: f64, f: impl Fn(f64) -> f64) -> f64 {
        // Differences from the value at hand: a constant costs no digits.
        let here = f(t_s);
        let weights = self.weights(t_s);
        -self.times_s().iter().zip(weights).map(|(node_s, weight)| weight * (f(*node_s) - here)).sum::<f64>()
    }

    /// `E(w, t)`, of an oscillation of amplitude 1.
    pub fn error(&self, omega_rad_s: f64, t_s: f64) -> f64 {
        let weights = self.weights(t_s);
        let (mut re, mut im) = (0.0, 0.0);
        for (node_s, weight) in self.times_s().iter().zip(weights) {
            // e^{jx} - 1 without cancellation, and the weights sum to 1.
            let half = 0.5 * omega_rad_s * (node_s - t_s);
            re += weight * -2.0 * half.sin() * half.sin();
            im += weight * 2.0 * half.sin() * half.cos();
        }
        re.hypot(im)
    }

    /// Pulses of an even sequence between the first and the last node, both among them, s: all, or
    /// [`MOST_PLACES`] spread over them (between those a polynomial through a few nodes adds nothing).
    pub fn places_s(&self, interval_s: f64) -> impl Iterator<Item = f64> + use<> {
        let last = (self.span_s() / interval_s + 1e-6).floor().max(0.0);
        let steps = last.min(MOST_PLACES as f64);
        (0..=steps as usize).map(move |i| (i as f64 * last / steps.max(1.0)).round() * interval_s)
    }
}

#[test]
fn polynomials_are_met_exactly() {
    for count in 1..=MOST_NODES {
        let nodes = Nodes::evenly(count, 0.3);
        let polynomial = |t: f64| (0..count).map(|power| t.powi(power as i32)).sum::<f64>();
        for t_s in [0.0, 0.1, 0.37, nodes.span_s()] {
            // Values up to 2.1^7, weights up to some 10, in f64.
            let left = nodes.residue(t_s.min(nodes.span_s()), polynomial);
            assert!(left.abs() < 1e-12, "{count} {t_s}: {left}");
        }
    }
}

#[test]
fn small_oscillations_follow_the_remainder() {
    for count in 1..=6 {
        let nodes = Nodes::evenly(count, 1.0);
        let t_s = 0.4;
        let product: f64 = nodes.times_s().iter().map(|node| (t_s - node).abs()).product();
        let factorial: f64 = (1..=count).map(|i| i as f64).product();
        let omega: f64 = 1e-2;
        let remainder = omega.powi(count as i32) * product / factorial;
        // The next term is n + 1 times w t_span / (n + 1) = 0.05 smaller at most.
        assert!((nodes.error(omega, t_s) / remainder - 1.0).abs() < 0.05, "{count}");
    }
}

#[test]
fn places_are_pulses_from_end_to_end() {
    let of = |count, pulses: f64| Nodes::evenly(count, pulses * 0.25).places_s(0.25).collect::<Vec<_>>();
    assert_eq!(of(4, 1.0), [0.0, 0.25, 0.5, 0.75]);
    assert_eq!(of(1, 5.0), [0.0]);
    let many = of(4, 1000.0);
    assert_eq!((many.len(), many[0], many[MOST_PLACES]), (MOST_PLACES + 1, 0.0, 750.0));
    assert!(many.iter().all(|t| (t / 0.25).fract() == 0.0) && many.is_sorted_by(|a, b| a < b));
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    #[test]
    fn errors_are_bounded_and_vanish_at_nodes(
        count in 1usize..=MOST_NODES, spacing in 1e-6f64..10.0, omega in 0.0f64..1e6, share in 0.0f64..1.0,
    ) {
        let nodes = Nodes::evenly(count, spacing);
        let error = nodes.error(omega, share * nodes.span_s());
        let weights: f64 = nodes.weights(share * nodes.span_s()).iter().map(|w| w.abs()).sum();
        prop_assert!(error.is_finite() && error <= 1.0 + weights + 1e-9);
        for node_s in nodes.times_s() {
            prop_assert!(nodes.error(omega, *node_s) < 1e-12);
        }
    }
}
