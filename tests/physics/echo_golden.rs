//! `echo_refA_raw`, `echo_refB_filtered`, `noise`: every row. Delays come from a light-time
//! iteration of this file's own, from `echo_scene.json` alone.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use nereus::echo::reference::{ReferenceEcho, raw_samples};
use nereus::paths::list::ScattererPaths;
use nereus::radar::receiver::thermal_noise_w;
use nereus::radar::waveform::Lfm;
use nereus::scene::radar::Sweep;
use nereus::units::Decibels;
use num_complex::Complex64;
use serde::Deserialize;

const C_MPS: f64 = 299_792_458.0;

fn golden(name: &str) -> PathBuf {
    let folder = std::env::var_os("NEREUS_GOLDEN")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden"), PathBuf::from);
    folder.join(name)
}

fn rows(name: &str) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(golden(name)).unwrap();
    reader.records().map(|r| r.unwrap().iter().map(|v| v.trim().parse().unwrap()).collect()).collect()
}

#[derive(Deserialize)]
#[allow(non_snake_case)]
struct Scene {
    B: f64,
    Tc: f64,
    f0: f64,
    fs: f64,
    N: usize,
    prf: f64,
    t0: f64,
    tx: [f64; 3],
    vtx: [f64; 3],
    rx: [f64; 3],
    vrx: [f64; 3],
    /// Position, velocity, amplitude [re, im].
    scat: Vec<([f64; 3], [f64; 3], [f64; 2])>,
}

fn at(p: &[f64; 3], v: &[f64; 3], t: f64) -> [f64; 3] {
    [p[0] + v[0] * t, p[1] + v[1] * t, p[2] + v[2] * t]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// docs/physics.md section 3.1: the exact delay of a pulse that leaves at `t`.
fn light_time(scene: &Scene, n: usize, t: f64) -> f64 {
    let (position, velocity, _) = &scene.scat[n];
    let from = at(&scene.tx, &scene.vtx, t);
    let (mut leg1, mut leg2) = (0.0, 0.0);
    // Each turn gains a factor v/c = 1e-6: six are more than f64 can hold.
    for _ in 0..6 {
        let hit = at(position, velocity, t + leg1);
        leg1 = distance(hit, from) / C_MPS;
        let hit = at(position, velocity, t + leg1);
        leg2 = distance(at(&scene.rx, &scene.vrx, t + leg1 + leg2), hit) / C_MPS;
    }
    leg1 + leg2
}

fn paths(scene: &Scene, t: f64) -> ScattererPaths {
    let mut paths = ScattererPaths::new(1, 1, scene.scat.len());
    for (n, (_, _, a)) in scene.scat.iter().enumerate() {
        // Central difference over 2 ms: error tau''' h^2/6 = 1e-15 and rounding 1e-18.
        let h = 1e-3;
        paths.emission_offset_s.push(0.0);
        paths.delay_s[0].push(light_time(scene, n, t));
        paths.delay_rate[0].push((light_time(scene, n, t + h) - light_time(scene, n, t - h)) / (2.0 * h));
        paths.amplitude[0].push(Complex64::new(a[0], a[1]));
    }
    paths
}

/// Samples of each pulse of a golden file; every pulse has every sample, once.
fn pulses(name: &str, samples: usize) -> BTreeMap<u64, Vec<Complex64>> {
    let mut pulses: BTreeMap<u64, Vec<Option<Complex64>>> = BTreeMap::new();
    for row in rows(name) {
        let pulse = pulses.entry(row[0] as u64).or_insert_with(|| vec![None; samples]);
        assert!(pulse[row[1] as usize].replace(Complex64::new(row[2], row[3])).is_none());
    }
    assert!(!pulses.is_empty());
    pulses.into_iter().map(|(n, v)| (n, v.into_iter().map(|s| s.unwrap()).collect())).collect()
}

/// Worst single row relative to the pulse's rms, and relative rms over the pulse.
fn errors(ours: &[Complex64], theirs: &[Complex64]) -> (f64, f64) {
    let rms = (theirs.iter().map(Complex64::norm_sqr).sum::<f64>() / theirs.len() as f64).sqrt();
    let differences: Vec<f64> = ours.iter().zip(theirs).map(|(a, b)| (a - b).norm() / rms).collect();
    let total = (differences.iter().map(|d| d * d).sum::<f64>() / theirs.len() as f64).sqrt();
    (differences.into_iter().fold(0.0, f64::max), total)
}

fn scene_and_pulse() -> (Scene, Lfm) {
    let scene: Scene =
        serde_json::from_reader(std::fs::File::open(golden("echo_scene.json")).unwrap()).unwrap();
    let pulse = Lfm::new(scene.B, scene.Tc, Sweep::Up).unwrap();
    (scene, pulse)
}

#[test]
fn raw_samples_match_reference_a_in_every_row() {
    let (scene, pulse) = scene_and_pulse();
    let mut worst = (0.0f64, 0.0f64);
    let mut out = vec![Complex64::ZERO; scene.N];
    for (index, theirs) in pulses("echo_refA_raw.csv", scene.N) {
        let paths = paths(&scene, index as f64 / scene.prf);
        raw_samples(&pulse, scene.f0, scene.fs, scene.t0, &paths, 0, 0, &mut out);
        let (row, rms) = errors(&out, &theirs);
        worst = (worst.0.max(row), worst.1.max(rms));
    }
    let db = 20.0 * worst.0.log10();
    println!("reference A: worst row {:.2e} of the rms ({db:.1} dB), worst pulse {:.2e}", worst.0, worst.1);
    assert!(db <= -100.0, "{db}");
}

#[test]
fn spectrum_matches_reference_b_in_every_row() {
    let (scene, pulse) = scene_and_pulse();
    let echo = ReferenceEcho::with_period(Arc::new(pulse), scene.f0, scene.fs, scene.N, vec![0], scene.N)
        .neglect_intra_pulse_doppler();
    let inverse = nereus_fft::inverse(scene.N);
    let mut worst = (0.0f64, 0.0f64);
    let mut out = vec![Complex64::ZERO; scene.N];
    for (index, theirs) in pulses("echo_refB_filtered.csv", scene.N) {
        let paths = paths(&scene, index as f64 / scene.prf);
        echo.spectrum(&paths, scene.t0, &mut out);
        inverse.process(&mut out);
        out.iter_mut().for_each(|s| *s *= scene.fs / scene.N as f64);
        let (row, rms) = errors(&out, &theirs);
        worst = (worst.0.max(row), worst.1.max(rms));
    }
    println!("reference B: worst row {:.2e} of the rms, worst pulse {:.2e}", worst.0, worst.1);
    // tau is a sum of a few roundings on either side, and f0 tau one more: some ten of them in all, each half
    // an epsilon of the phase 2 pi f0 tau; a row may stand 4 times above the rms. The file has 13 digits.
    let delay_s = scene.t0 + scene.N as f64 / scene.fs;
    let tolerance = 4.0 * 10.0 * 0.5 * f64::EPSILON * std::f64::consts::TAU * scene.f0 * delay_s + 1e-11;
    assert!(worst.0 <= tolerance, "{worst:?} {tolerance}");
}

#[test]
fn thermal_noise_matches_in_every_row() {
    let mut worst = 0.0f64;
    let rows = rows("noise.csv");
    assert!(!rows.is_empty());
    for row in rows {
        worst = worst.max((thermal_noise_w(row[0], Decibels(row[1])) / row[2] - 1.0).abs());
    }
    println!("noise: worst relative error {worst:.1e}");
    assert!(worst <= 1e-9, "{worst}");
}
