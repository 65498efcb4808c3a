//! What interpolation leaves of the distance to a platform that flies by.
//!
//! A leg `R(t) = sqrt(R^2 + 2 R V s t + V^2 t^2)`, `s` the sine of the angle from broadside. Derivatives at a
//! distance R, over all `s`:
//!
//! `|R'''| <= (2/sqrt 3) V^3/R^2 ,   |R''''| <= 3 V^4/R^3`
//!
//! (the third is `3 V^3 s (1 - s^2)/R^2`, largest at `s = 1/sqrt 3`; the fourth `3 V^4 c (4 - 5 c)/R^3` with
//! `c = 1 - s^2`, largest at broadside). With n nodes the error is at most
//! `max |d^n R/dt^n| |prod (t - t_i)| / n!`: [`residue_m`] takes the leg itself instead, for any number of
//! nodes, in the worst of many directions. A path error `x` is a phase error `2 pi x / lambda` of every
//! scatterer path, and so a relative error of the echo; legs add.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `R`, `V` | distance, speed of the platform against the scatterer | m, m/s |
//!
//! Limits: straight flight within a block. Accelerations `a` of a manoeuvre that changes within a block add
//! `a''' t^5/120` and the like: nothing for aircraft. The water's own motion is in [`super::waves`].

use super::interpolation::Nodes;

/// Directions that are tried.
const DIRECTIONS: i32 = 16;

/// A bound on the third derivative of a leg, m/s^3.
pub fn third_derivative_mps3(range_m: f64, speed_mps: f64) -> f64 {
    2.0 / 3f64.sqrt() * speed_mps.powi(3) / range_m.powi(2)
}

/// A bound on the fourth derivative of a leg, m/s^4.
pub fn fourth_derivative_mps4(range_m: f64, speed_mps: f64) -> f64 {
    3.0 * speed_mps.powi(4) / range_m.powi(3)
}

/// What nodes leave of a leg at a time, in the worst direction, m. `range_m` is the distance at the middle of
/// the nodes; a leg that the platform passes through has none (infinite).
pub fn residue_m(range_m: f64, speed_mps: f64, nodes: &Nodes, t_s: f64) -> f64 {
    let half_s = 0.5 * nodes.span_s();
    if range_m.is_nan() || range_m <= speed_mps * half_s {
        return f64::INFINITY;
    }
    (-DIRECTIONS..=DIRECTIONS)
        .map(|step| {
            let s = f64::from(step) / f64::from(DIRECTIONS);
            let leg_m = |t: f64| {
                let x = speed_mps * (t - half_s);
                // R(t) - R(0), without cancellation.
                let change = x * (x + 2.0 * range_m * s);
                change / ((range_m * range_m + change).max(0.0).sqrt() + range_m)
            };
            nodes.residue(t_s, leg_m).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn quadratics_over_blocks_as_on_the_physics_page() {
    // docs/physics.md section 15.7: one leg, X band, 222 m/s, 4243 m, 222 Hz; relative rms over a block
    // about its middle. Figures are given to a decibel.
    for (pulses, db) in [(8.0, -86.0), (16.0, -67.0), (32.0, -49.0), (64.0, -31.0)] {
        let half_s: f64 = 0.5 * pulses / 222.0;
        let rms_m = third_derivative_mps3(4243.0, 222.0) * half_s.powi(3) / 6.0 / 7f64.sqrt();
        let found = 20.0 * (std::f64::consts::TAU * rms_m / 0.03).log10();
        assert!((found - db).abs() <= 1.0, "{pulses}: {found}");
    }
}

#[test]
fn residues_are_those_of_the_derivatives() {
    for (count, spacing_s, bound) in
        [(3, 0.02, third_derivative_mps3(4243.0, 222.0)), (4, 0.05, fourth_derivative_mps4(4243.0, 222.0))]
    {
        let nodes = Nodes::evenly(count, spacing_s);
        let factorial: f64 = (1..=count).map(|i| i as f64).product();
        let t_s = 0.4 * spacing_s;
        let product: f64 = nodes.times_s().iter().map(|node| (t_s - node).abs()).product();
        let expected_m = bound * product / factorial;
        // R changes by V t / R = 0.4 % over the nodes, and directions are 1/16 apart: 0.1 % of the
        // largest.
        let found_m = residue_m(4243.0, 222.0, &nodes, t_s);
        assert!((found_m / expected_m - 1.0).abs() < 0.03, "{count}: {found_m} {expected_m}");
    }
}

#[test]
fn extremes_are_numbers_or_refused() {
    let nodes = Nodes::evenly(4, 0.1);
    assert_eq!(residue_m(10.0, 1000.0, &nodes, 0.05), f64::INFINITY);
    assert_eq!(residue_m(f64::NAN, 1.0, &nodes, 0.05), f64::INFINITY);
    assert_eq!(residue_m(1e3, 0.0, &nodes, 0.05), 0.0);
    // From orbit: rounding alone, below a hundredth of a nanometre.
    assert!(residue_m(8e5, 7.5e3, &Nodes::evenly(4, 1e-6), 5e-7) < 1e-11);
}
