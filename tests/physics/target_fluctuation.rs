//! Swerling's cases: the statistics of what a pulse returns, against their closed forms.

use nereus::paths::PathGenerator;
use nereus::scene::Scene;
use nereus::scene::target::Swerling;

use crate::radar_scenes::{evaluate, scene, straight, target};

const PULSES: u64 = 4000;

/// A tower, two steady targets beside each other, and so many pulses at 222 Hz.
fn with(swerling: Swerling, seed: u64) -> (Scene, PathGenerator) {
    let mut scene = scene();
    (scene.pulses, scene.seed) = (PULSES, seed);
    scene.targets = vec![target([0.0; 3], [0.0; 3]), target([30.0, 0.0, 0.0], [0.0; 3])];
    scene.targets[1].name = "other".into();
    scene.targets.iter_mut().for_each(|target| target.swerling = swerling);
    let tower = straight(&scene, [3000.0, 0.0, 100.0], [0.0; 3]);
    let generator = PathGenerator::new(&scene, 1e-6, vec![tower.clone(), tower]).unwrap();
    (scene, generator)
}

/// Radar cross section over its mean of both targets at every pulse: `[target][pulse]`.
fn cross_sections(swerling: Swerling, seed: u64) -> [Vec<f64>; 2] {
    let (scene, generator) = with(swerling, seed);
    let (_, steady) = with(Swerling::Steady, seed);
    let of_steady = evaluate(&scene, &steady, 0).0.amplitude;
    let mut found = [Vec::new(), Vec::new()];
    for index in 0..PULSES {
        let (paths, _) = evaluate(&scene, &generator, index);
        for (n, found) in found.iter_mut().enumerate() {
            let ratio = paths.amplitude[0][n] / of_steady[0][n];
            assert!(ratio.im.abs() < 1e-12 * ratio.re, "the phase does not fluctuate: {ratio}");
            let vv = paths.amplitude[3][n] / of_steady[3][n];
            assert!((vv - ratio).norm() < 1e-12 * ratio.re, "one draw for all channels: {vv} {ratio}");
            found.push(ratio.norm_sqr());
        }
    }
    found
}

/// `P(X <= x)` of a case.
fn distribution(swerling: Swerling, x: f64) -> f64 {
    match swerling.case() {
        1 | 2 => 1.0 - (-x).exp(),
        _ => 1.0 - (1.0 + 2.0 * x) * (-2.0 * x).exp(),
    }
}

/// Largest distance of the empirical distribution from the law, times the root of their number.
fn kolmogorov(swerling: Swerling, values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let off = |(n, x): (usize, &f64)| {
        let law = distribution(swerling, *x);
        (law - n as f64 / count).abs().max((law - (n as f64 + 1.0) / count).abs())
    };
    count.sqrt() * sorted.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Correlation of two series of known mean 1, times the root of their length: one deviation is 1.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let power = |of: &[f64]| of.iter().map(|x| (x - 1.0).powi(2)).sum::<f64>();
    let both: f64 = a.iter().zip(b).map(|(a, b)| (a - 1.0) * (b - 1.0)).sum();
    (a.len() as f64).sqrt() * both / (power(a) * power(b)).sqrt()
}

/// Exceeded by a right law once in 10,000 samples (Kolmogorov: `2 exp(-2 d^2)`).
const KOLMOGOROV: f64 = 2.225;
/// Deviations of a correlation, once in 16,000.
const DEVIATIONS: f64 = 4.0;

#[test]
fn pulse_to_pulse_cases_have_their_laws_and_no_memory() {
    for swerling in [Swerling::Case2, Swerling::Case4] {
        let [first, second] = cross_sections(swerling, 7);
        for values in [&first, &second] {
            let d = kolmogorov(swerling, values);
            println!("{swerling:?}: Kolmogorov {d:.3}");
            assert!(d < KOLMOGOROV, "{swerling:?}: {d}");
            for lag in [1, 2, 3, 64] {
                let r = correlation(&values[lag..], &values[..values.len() - lag]);
                assert!(r.abs() < DEVIATIONS, "{swerling:?}, lag {lag}: {r}");
            }
        }
        let r = correlation(&first, &second);
        assert!(r.abs() < DEVIATIONS, "{swerling:?}, two targets: {r}");
        // The wrong law is rejected by as many pulses.
        let other = if swerling == Swerling::Case2 { Swerling::Case4 } else { Swerling::Case2 };
        assert!(kolmogorov(other, &first) > 2.0 * KOLMOGOROV);
    }
}

#[test]
fn scan_cases_are_constant_over_a_scan_and_have_their_laws_over_scans() {
    // Five pulses a scan, on whose edges pulses fall.
    let scan_s = 5.0 / 222.0;
    for swerling in [Swerling::Case1 { scan_s }, Swerling::Case3 { scan_s }] {
        let [first, second] = cross_sections(swerling, 3);
        for values in [&first, &second] {
            let scans: Vec<f64> = values.chunks(5).map(|scan| scan[0]).collect();
            for scan in values.chunks(5) {
                assert!(scan.iter().all(|x| (x / scan[0] - 1.0).abs() < 1e-9), "{scan:?}");
            }
            let d = kolmogorov(swerling, &scans);
            println!("{swerling:?}: Kolmogorov {d:.3}");
            assert!(d < KOLMOGOROV, "{swerling:?}: {d}");
            let r = correlation(&scans[1..], &scans[..scans.len() - 1]);
            assert!(r.abs() < DEVIATIONS, "{swerling:?}: {r}");
        }
        let r = correlation(&first[..].iter().step_by(5).copied().collect::<Vec<_>>(), &{
            second.iter().step_by(5).copied().collect::<Vec<_>>()
        });
        assert!(r.abs() < DEVIATIONS, "{swerling:?}, two targets: {r}");
    }
}

#[test]
fn draws_depend_on_seed_target_and_pulse_alone() {
    let (scene, generator) = with(Swerling::Case2, 7);
    let alone = evaluate(&scene, &with(Swerling::Case2, 7).1, 1234).0;
    for index in [3, 1235] {
        evaluate(&scene, &generator, index);
    }
    let again = evaluate(&scene, &generator, 1234).0;
    assert_eq!(alone.amplitude, again.amplitude);
    let other_seed = evaluate(&scene, &with(Swerling::Case2, 8).1, 1234).0;
    assert_ne!(alone.amplitude, other_seed.amplitude);
}
