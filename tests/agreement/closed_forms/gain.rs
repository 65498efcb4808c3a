//! What interpolation leaves of a gain while the beam sweeps over the water.
//!
//! The field gain of an aperture of length `a` is the Fourier transform of its illumination. Where
//! directions in its frame change at `u'` (rad/s), a facet sees a band-limited function of time,
//! `|w| <= pi a u'/lambda` each way. Over all facets the mean square error relative to the mean square gain
//! is, with Parseval,
//!
//! `e^2(t) = integral of |A(w)|^2 E^2(w, t) dw / integral of |A(w)|^2 dw`
//!
//! with `A` the illumination (even: constant), and for both ways its convolution with that of the other
//! antenna (`E` of [`super::interpolation`]). So `e` depends on `a u' / lambda` and the nodes alone: 4 nodes
//! so many pulses apart keep the same error wherever `lambda R PRF / (a V)` is the same.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `a` | length of the aperture along the sweep | m |
//! | `u'` | rate of the directions in the antenna's frame, `V/R` for a beam fixed to the flight | rad/s |
//!
//! Limits: facets spread evenly over main lobe and side lobes; a window that receives the lobe's edge alone
//! does worse. A pattern that is not a uniform aperture is held for one of its largest dimension.

use std::f64::consts::PI;

use super::interpolation::Nodes;

/// Frequencies of the integral.
const FREQUENCIES: usize = 400;

/// The highest angular frequency of a gain, rad/s: `pi a u' / lambda`.
pub fn sweep_rad_s(aperture_m: f64, wavelength_m: f64, rate_rad_s: f64) -> f64 {
    PI * aperture_m * rate_rad_s.abs() / wavelength_m
}

/// `e^2(t)` of a product of gains, given the [`sweep_rad_s`] of each (at most two count: the fastest).
pub fn error_power(sweeps_rad_s: &[f64], nodes: &Nodes, t_s: f64) -> f64 {
    let (mut wide, mut narrow) = (0.0f64, 0.0f64);
    for sweep in sweeps_rad_s.iter().map(|sweep| sweep.abs()) {
        (wide, narrow) = if sweep > wide { (sweep, wide) } else { (wide, narrow.max(sweep)) };
    }
    let edge = wide + narrow;
    if edge == 0.0 || !edge.is_finite() {
        return if edge == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let (mut sum, mut all) = (0.0, 0.0);
    for i in 0..FREQUENCIES {
        let omega = (i as f64 + 0.5) / FREQUENCIES as f64 * edge;
        // Two rectangles convolved: flat to the difference of their edges, then falling.
        let flat = wide - narrow;
        let amplitude = if omega <= flat { 1.0 } else { (edge - omega) / (edge - flat) };
        let power = amplitude * amplitude;
        sum += power * nodes.error(omega, t_s).powi(2);
        all += power;
    }
    sum / all
}

/// Mean over the pulses of an interval of the nodes, dB, one way, in the case of docs/physics.md section
/// 15.7.
fn mean_db(count: usize, first: usize, pulses: usize) -> f64 {
    let sweep = sweep_rad_s(4.0, 0.03, 0.052);
    let nodes = Nodes::evenly(count, pulses as f64 / 222.0);
    let t_s = |m: usize| (first * pulses + m) as f64 / 222.0;
    let sum: f64 = (0..pulses).map(|m| error_power(&[sweep], &nodes, t_s(m))).sum();
    10.0 * (sum / pulses as f64).log10()
}

#[test]
fn gains_of_the_physics_page() {
    // docs/physics.md section 15.7: facets over +-0.03 in u, one way, linear, and the middle interval of
    // a cubic. The fewer pulses there are, the more the ends, which are exact, count: 2 dB.
    for (pulses, linear_db, cubic_db) in [(4, -44.0, -78.0), (8, -32.0, -55.0), (16, -21.0, -32.0)] {
        let (linear, cubic) = (mean_db(2, 0, pulses), mean_db(4, 1, pulses));
        println!("{pulses}: linear {linear:.1}, cubic {cubic:.1}");
        assert!((linear - linear_db).abs() < 2.0, "{pulses}: {linear}");
        assert!((cubic - cubic_db).abs() < 2.0, "{pulses}: {cubic}");
    }
}

#[test]
fn the_integral_is_that_of_gains_summed_over_facets() {
    // Directly: sinc gains of both ways at facets spread evenly over 200 lobes.
    let omega = 20.0;
    let nodes = Nodes::evenly(4, 0.02);
    let t_s = 0.011;
    let gain = |t: f64, at: f64| {
        let x = omega * t - at;
        if x == 0.0 { 1.0 } else { (x.sin() / x).powi(2) }
    };
    let (mut error, mut power) = (0.0, 0.0);
    for i in -20_000..20_000 {
        let at = (f64::from(i) + 0.5) * 0.01 * PI;
        error += nodes.residue(t_s, |t| gain(t, at)).powi(2);
        power += gain(t_s, at).powi(2);
    }
    let found = error_power(&[omega, omega], &nodes, t_s);
    // The sum is cut at 200 lobes (1e-7 of the power) and the integral has 400 steps.
    assert!((found / (error / power) - 1.0).abs() < 1e-3, "{found} {}", error / power);
}

#[test]
fn what_does_not_sweep_costs_nothing() {
    let nodes = Nodes::evenly(4, 0.1);
    assert_eq!(error_power(&[], &nodes, 0.05), 0.0);
    assert_eq!(error_power(&[0.0, 0.0], &nodes, 0.05), 0.0);
    assert_eq!(error_power(&[f64::INFINITY], &nodes, 0.05), f64::INFINITY);
    assert!(error_power(&[1e9, 1.0], &nodes, 0.05).is_finite());
    // The fastest two count, in any order.
    let of = |sweeps: &[f64]| error_power(sweeps, &nodes, 0.05);
    assert_eq!(of(&[3.0, 7.0, 1.0]), of(&[7.0, 1.0, 3.0]));
}
