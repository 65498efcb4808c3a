use std::f64::consts::TAU;

use super::*;
use crate::scene::water::{Development, SpectrumKind, WindProfile};
use crate::sea::spectrum::LightWind;
use crate::sea::wind::Wind;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Lines of facets of a size at 60 degrees incidence from the East, wind of 2.5 m/s towards a direction, L
/// band.
pub(super) fn lines(towards_deg: f64, facet_m: f64, drift_mps: [f64; 2], tilts: [f64; 2]) -> BraggLines {
    let wind = Wind::from_speed(2.5, 10.0, WindProfile::Cardone, towards_deg.to_radians()).unwrap();
    let kind = SpectrumKind::Elfouhaily { development: Development::default() };
    let spectrum = LightWind::new(&kind, &wind).unwrap();
    let (sin, cos) = wind.direction_rad.sin_cos();
    let k = TAU * 1.3e9 / SPEED_OF_LIGHT_MPS;
    let setting = Setting {
        spectrum: &spectrum,
        dispersion: Dispersion::default(),
        downwind: [cos, sin],
        drift_mps,
        wavenumber_radpm: k,
        resolved_radpm: std::f64::consts::PI / facet_m,
        cut_radpm: Some((std::f64::consts::PI / facet_m).max(k / 3.0)),
        decorrelation_s: None,
        gaussian: false,
        seed: 1,
    };
    BraggLines::new(&setting, tilts)
}

/// From an antenna in the East down at 60 degrees incidence, and back.
fn from_east() -> (DVec3, DVec3) {
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let down = DVec3::new(-sin, 0.0, -cos);
    (down, -down)
}

#[test]
fn waves_that_come_closer_raise_the_frequency() {
    let (ki, ks) = from_east();
    for (towards_deg, advancing) in [(0.0, 1.0), (180.0, 0.0), (90.0, 0.5), (-90.0, 0.5)] {
        let [up, down] = lines(towards_deg, 1.0, [0.0; 2], [0.0; 2]).lines(Mechanism::Bragg, ki, ks);
        // lambda_B = lambda/(2 sin 60) = 13.3 cm: K = 47.2 rad/m, omega^2 = g K + 7.2e-5 K^3.
        let k = 2.0 * TAU * 1.3e9 / SPEED_OF_LIGHT_MPS * 60f64.to_radians().sin();
        let hz = (9.81 * k + 0.074 / 1025.0 * k.powi(3)).sqrt() / TAU;
        assert!((hz - 3.45).abs() < 0.01, "{hz}");
        assert!((up.centre_radps / TAU - hz).abs() < 0.002, "{towards_deg}: {up:?}");
        assert_eq!(down.centre_radps, -up.centre_radps);
        let shares = [up, down].map(|line| line.amplitude.powi(2));
        assert!((shares[0] - advancing).abs() < 0.01 && (shares[0] + shares[1] - 1.0).abs() < 1e-4);
    }
}

#[test]
fn drift_carries_both_lines() {
    let (ki, ks) = from_east();
    let still = lines(0.0, 1.0, [0.0; 2], [0.0; 2]);
    let adrift = lines(0.0, 1.0, [0.075, 3.0], [0.0; 2]);
    // 7.5 cm/s towards the East, and none of what goes North: 2 u sin 60/lambda.
    let hz = 2.0 * 0.075 * 60f64.to_radians().sin() * 1.3e9 / SPEED_OF_LIGHT_MPS;
    for (mechanism, lines) in [(Mechanism::Specular, 1), (Mechanism::Bragg, 2)] {
        let both = adrift.lines(mechanism, ki, ks).into_iter().zip(still.lines(mechanism, ki, ks));
        for (own, other) in both.take(lines) {
            assert!(((own.centre_radps - other.centre_radps) / TAU - hz).abs() < 1e-9);
        }
    }
}

#[test]
fn swapped_antennas_see_the_same_lines() {
    let lines = lines(40.0, 1.0, [0.05, -0.02], [0.01, 0.005]);
    let (a, b) = (DVec3::new(-0.6, 0.3, -0.7).normalize(), DVec3::new(0.2, 0.5, 0.8).normalize());
    for mechanism in [Mechanism::Specular, Mechanism::Bragg] {
        assert_eq!(lines.lines(mechanism, a, b), lines.lines(mechanism, -b, -a));
    }
}

/// What a coarser map does not move, sub-facet waves do: map and line together are as wide.
#[test]
fn what_the_map_does_not_resolve_is_in_the_width() {
    let (ki, ks) = from_east();
    let of = |facet_m| {
        let [line, _] = lines(0.0, facet_m, [0.0; 2], [0.0; 2]).lines(Mechanism::Bragg, ki, ks);
        line.deviation_radps
    };
    let widths = [0.0625, 0.25, 1.0, 2.0].map(of);
    println!("{widths:?} rad/s");
    assert!(widths.is_sorted() && widths[1] > 0.0 && widths[3] > 1.5 * widths[1]);
    // Facets of half a Bragg wave have no longer wave within them.
    assert_eq!(widths[0], 0.0);
}

#[test]
fn facets_are_random_and_the_same_at_any_time_and_place() {
    let lines = lines(0.0, 1.0, [0.0; 2], [0.0; 2]);
    let at = |key: [i64; 2], t_s: f64| {
        [Mechanism::Specular, Mechanism::Bragg].map(|of| lines.phasor((of, 0), key, from_east(), t_s))
    };
    assert_eq!(at([3, -4], 1.5), at([3, -4], 1.5));
    let (mut power, mut mean, mut neighbours) = ([0.0; 2], [Complex64::ZERO; 2], Complex64::ZERO);
    let count = 4000;
    for n in 0..count {
        let (own, next) = (at([n, 7], 20.0), at([n + 1, 7], 20.0));
        for i in 0..2 {
            power[i] += own[i].norm_sqr() / count as f64;
            mean[i] += own[i] / count as f64;
        }
        neighbours += own[1].conj() * next[1] / count as f64;
    }
    // One in the root of 4000 is 1.6 %.
    assert!(power.iter().all(|power| (power - 1.0).abs() < 0.06), "{power:?}");
    assert!(mean.iter().all(|mean| mean.norm() < 0.06) && neighbours.norm() < 0.06);
}

/// Sub-facets tilted by `s` to and from the antenna have `K_B` off by `q_z s`, and lines off by `c_g q_z s`.
#[test]
fn tilts_widen_the_lines() {
    let (ki, ks) = from_east();
    let of = |tilts| lines(0.0, 0.0625, [0.0; 2], tilts).lines(Mechanism::Bragg, ki, ks)[0].deviation_radps;
    let k = TAU * 1.3e9 / SPEED_OF_LIGHT_MPS;
    let omega = |slope: f64| {
        let k_b = 2.0 * k * (60f64.to_radians().sin() + slope * 60f64.to_radians().cos());
        (9.81 * k_b * (1.0 + (k_b / 370.0).powi(2))).sqrt()
    };
    let expected = 0.5 * (omega(0.05) - omega(-0.05)).abs();
    let found = of([0.05f64.powi(2), 0.0]);
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    assert!(of([0.0, 0.05f64.powi(2)]) < 1e-6);
}
