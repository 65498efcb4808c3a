//! Bragg waves that travel: Doppler spectra of a small patch from its exact paths, against what the waves
//! are.
//!
//! Facets have random phases, so the spectrum of the patch is the sum of those of its facets.

use std::f64::consts::TAU;

use nereus::paths::PathGenerator;
use nereus::scene::radar::{Gate, Polarisation, Window};
use nereus::scene::sea::{BraggWaves, Breaking, FacetScattering, Modulation};
use nereus::scene::water::{SpectrumKind, Spreading, WindStrength};
use nereus::scene::{Scene, Sea};
use nereus::time::PulseTimes;
use num_complex::Complex64;

use super::radar_scenes::{PULSE_S, buffers, channels, scene, straight};
use super::sea_paths::sea;

use crate::cases::some_of;

/// Drift apart, as the judges have it.
const TRAVELLING: BraggWaves = BraggWaves::Travelling { drift_share: 0.0, drift_turn_rad: 0.0 };

/// A patch of 16 m under a wind towards a direction (from East counter-clockwise).
fn patch(facet_m: f64, u10_mps: f64, towards_deg: f64, bragg: BraggWaves) -> Sea {
    let mut sea = sea((16.0 / facet_m) as usize, facet_m, towards_deg.to_radians());
    sea.water.wind.strength = WindStrength::Speed { speed_mps: u10_mps, height_m: 10.0 };
    sea.scattering = FacetScattering { bragg, ..sea.scattering };
    sea
}

/// Seen in L band, VV, from the East at 60 degrees incidence.
fn from_east(sea: Sea, prf_hz: f64) -> Scene {
    let mut scene = Scene { sea: Some(sea), targets: Vec::new(), ..scene() };
    scene.radar.carrier_hz = 1.3e9;
    scene.radar.emissions = PulseTimes::uniform(prf_hz).unwrap();
    scene.radar.window = Window { samples: 1000, gate: Gate::Fixed { start_s: 130e-6 } };
    scene.radar.channels = channels(&[(Polarisation::V, Polarisation::V)]);
    scene
}

/// What each facet returns at some pulses: `[pulse][facet]`.
fn echoes(scene: &Scene, pulses: &[u64]) -> Vec<Vec<Complex64>> {
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let place = straight(scene, [20_000.0 * sin, 0.0, 20_000.0 * cos], [0.0; 3]);
    let generator = PathGenerator::new(scene, PULSE_S, vec![place.clone(), place]).unwrap();
    let mut workspace = generator.workspace();
    let (mut list, mut record) = buffers(scene);
    let mut of = |pulse: u64| {
        generator.pulse(pulse, &mut workspace, &mut list, &mut record).unwrap();
        let paths = list.amplitude[0].iter().zip(&list.delay_s[0]);
        paths
            .map(|(a, delay_s)| a * Complex64::cis(-(TAU * scene.radar.carrier_hz * delay_s) % TAU))
            .collect()
    };
    let all: Vec<Vec<Complex64>> = pulses.iter().map(|pulse| of(*pulse)).collect();
    assert!(all.iter().all(|pulse| pulse.len() == all[0].len() && !pulse.is_empty()));
    all
}

/// Power at some Dopplers, Hz, of the sum of facets' spectra, Hann window.
fn spectrum(echoes: &[Vec<Complex64>], prf_hz: f64, dopplers_hz: &[f64]) -> Vec<f64> {
    let pulses = echoes.len();
    let window: Vec<f64> =
        (0..pulses).map(|n| 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / pulses as f64).cos()).collect();
    let power = |hz: &f64| {
        let turn: Vec<Complex64> =
            (0..pulses).map(|n| Complex64::cis(-TAU * hz * n as f64 / prf_hz) * window[n]).collect();
        let of = |facet: usize| {
            let sum: Complex64 = turn.iter().zip(echoes).map(|(turn, pulse)| turn * pulse[facet]).sum();
            sum.norm_sqr()
        };
        (0..echoes[0].len()).map(of).sum()
    };
    dopplers_hz.iter().map(power).collect()
}

/// Pulses a second, pulses, and the bin they make, Hz.
const PRF_HZ: f64 = 32.0;
const PULSES: u64 = 128;
const BIN_HZ: f64 = PRF_HZ / PULSES as f64;

/// Doppler at which the spectrum is highest, smoothed over 1 Hz, that of its mean, and powers above and below
/// zero.
fn line(sea: Sea) -> ([f64; 2], [f64; 2]) {
    let scene = from_east(sea, PRF_HZ);
    let all = echoes(&scene, &(0..PULSES).collect::<Vec<_>>());
    let dopplers: Vec<f64> = (-40..=40).map(|n| f64::from(n) * BIN_HZ).collect();
    let powers = spectrum(&all, PRF_HZ, &dopplers);
    let smooth = |n: usize| (n - 2..=n + 2).map(|m| powers[m]).sum::<f64>();
    let peak = (2..powers.len() - 2).max_by(|a, b| smooth(*a).total_cmp(&smooth(*b))).unwrap();
    let side =
        |sign: f64| dopplers.iter().zip(&powers).filter(|(hz, _)| *hz * sign > 0.0).map(|(_, p)| p).sum();
    let mean = dopplers.iter().zip(&powers).map(|(hz, p)| hz * p).sum::<f64>() / powers.iter().sum::<f64>();
    ([dopplers[peak], mean], [side(1.0), side(-1.0)])
}

/// The Bragg wave of 13.3 cm, with surface tension: 3.45 Hz.
fn bragg_hz() -> f64 {
    let k = 2.0 * TAU * 1.3e9 / 299_792_458.0 * 60f64.to_radians().sin();
    (9.81 * k * (1.0 + (k / 370.0).powi(2))).sqrt() / TAU
}

#[test]
fn a_light_wind_has_the_line_of_its_bragg_wave() {
    let ([hz, _], [above, below]) = line(patch(1.0, 2.5, 180.0, TRAVELLING));
    println!("away: {hz:.2} Hz, {above:.2e} above, {below:.2e} below");
    assert!((hz + bragg_hz()).abs() <= BIN_HZ && below > 20.0 * above);
    let ([hz, _], [above, below]) = line(patch(1.0, 2.5, 0.0, TRAVELLING));
    println!("towards: {hz:.2} Hz, {above:.2e} above, {below:.2e} below");
    assert!((hz - bragg_hz()).abs() <= BIN_HZ && above > 20.0 * below);
    // As long as they were frozen.
    let ([hz, _], _) = line(patch(1.0, 2.5, 0.0, BraggWaves::Frozen));
    println!("frozen: {hz:.2} Hz");
    assert!(hz.abs() < 0.75);
}

#[test]
fn drift_moves_the_line() {
    // 3 % of 2.5 m/s, half of it along the line of sight where turned by 60 degrees: 2 u sin 60/lambda.
    let drifting = |drift_share, turn_deg: f64| {
        let bragg = BraggWaves::Travelling { drift_share, drift_turn_rad: turn_deg.to_radians() };
        line(patch(1.0, 2.5, 0.0, bragg)).0[1]
    };
    let still = drifting(0.0, 0.0);
    for (turn_deg, share) in [(0.0, 1.0), (-60.0, 0.5), (180.0, -1.0)] {
        let expected = 2.0 * 0.075 * share * 60f64.to_radians().sin() * 1.3e9 / 299_792_458.0;
        let found = drifting(0.03, turn_deg) - still;
        println!("{turn_deg} deg: {found:.3} Hz, {expected:.3} expected");
        // Lines of 1 Hz rms, seen for 4 s on 256 facets: 0.03 Hz each.
        assert!((found - expected).abs() <= 0.12, "{turn_deg}: {found} {expected}");
    }
}

#[test]
fn lines_have_the_ratio_of_the_directional_spectrum() {
    for towards_deg in [90.0f64, 70.0, 115.0] {
        let mut sea = patch(1.0, 2.5, towards_deg, TRAVELLING);
        sea.water.spectrum = SpectrumKind::PiersonMoskowitz { spreading: Spreading::Constant(2.0) };
        let (_, [above, below]) = line(sea);
        let ratio = (0.5 * towards_deg.to_radians()).tan().powi(-4);
        let db = 10.0 * (above / below / ratio).log10();
        println!("{towards_deg} deg off the wind: {:.2} expected {ratio:.2}, {db:.2} dB", above / below);
        // 256 facets of some ten components of one line each.
        assert!(db.abs() < 1.0, "{towards_deg}: {db} dB");
    }
    let (_, [above, below]) = line(patch(1.0, 2.5, 90.0, TRAVELLING));
    let db = 10.0 * (above / below).log10();
    println!("half circle, crosswind: {db:.2} dB");
    assert!(db.abs() < 1.5);
}

/// Facets of 0.25 to 2 m share the same orbital motion between map and line: centre and rms width, Hz.
#[test]
fn width_does_not_depend_on_the_size_of_facets() {
    let of = |facet_m: f64, bragg| {
        let lag_s = 1.0 / 64.0;
        let scene = from_east(patch(facet_m, 2.5, 0.0, bragg), 1.0 / lag_s);
        // As many facets in all, over the same 7 s.
        let instants = ((32.0 * facet_m * facet_m) as u64).clamp(6, 64);
        let pulses: Vec<u64> = (0..instants).map(|n| 448 * n / instants).flat_map(|n| [n, n + 1]).collect();
        let all = echoes(&scene, &pulses);
        let (mut power, mut covariance) = (0.0, Complex64::ZERO);
        for pair in all.chunks(2) {
            for (a, b) in pair[0].iter().zip(&pair[1]) {
                power += 0.5 * (a.norm_sqr() + b.norm_sqr());
                covariance += a.conj() * b;
            }
        }
        let width = (-2.0 * (covariance.norm() / power).ln()).sqrt() / lag_s / TAU;
        [covariance.arg() / lag_s / TAU, width]
    };
    let travelling = [0.25, 0.5, 1.0, 2.0].map(|facet_m| of(facet_m, TRAVELLING));
    let frozen = [0.5, 2.0].map(|facet_m| of(facet_m, BraggWaves::Frozen));
    println!("centre and width, Hz: {travelling:.2?}; frozen {frozen:.2?}");
    let mean = travelling.iter().map(|of| of[1]).sum::<f64>() / 4.0;
    for [centre, width] in travelling {
        assert!((width / mean - 1.0).abs() < 0.1, "{width} of {mean}");
        assert!((centre - travelling[0][0]).abs() < 0.35, "{centre}");
    }
    assert!(frozen[0][1] > 1.3 * frozen[1][1], "what frozen facets do not resolve is lost");
}

/// Doppler centroids of VV and HH in C band by CDOP, the empirical law of Mouche et al. (IEEE TGRS 50, 2901,
/// 2012), with its published coefficients at 7 m/s: incidence, deg; upwind, crosswind and downwind, Hz.
const CDOP: [(f64, [[f64; 2]; 3]); 2] = [
    (30.0, [[24.4, 25.8], [1.5, -0.9], [-17.2, -22.9]]),
    (40.0, [[20.8, 24.2], [0.8, -2.0], [-11.9, -19.8]]),
];

/// Mean Doppler of VV and HH, Hz, of seas of 128 m at 7 m/s, facets of 2 m.
fn centroids_hz(incidence_deg: f64, towards_deg: f64, of: (BraggWaves, Modulation)) -> [f64; 2] {
    let (bragg, modulation) = of;
    let lag_s = 1e-3;
    let mut covariance = [Complex64::ZERO; 2];
    for seed in 1..=2 {
        let mut sea = sea(64, 2.0, towards_deg.to_radians());
        sea.water.wind.strength = WindStrength::Speed { speed_mps: 7.0, height_m: 10.0 };
        sea.scattering =
            FacetScattering { bragg, modulation, breaking: Breaking::Off, ..FacetScattering::default() };
        let mut scene = from_east(sea, 1.0 / lag_s);
        (scene.seed, scene.pulses, scene.radar.carrier_hz) = (seed, 20_000, 5.331e9);
        scene.radar.channels =
            channels(&[(Polarisation::V, Polarisation::V), (Polarisation::H, Polarisation::H)]);
        let (sin, cos) = incidence_deg.to_radians().sin_cos();
        let place = straight(&scene, [20_000.0 * sin, 0.0, 20_000.0 * cos], [0.0; 3]);
        let generator = PathGenerator::new(&scene, PULSE_S, vec![place.clone(), place]).unwrap();
        let mut workspace = generator.workspace();
        let (mut list, mut record) = buffers(&scene);
        let mut of = |pulse: u64| {
            generator.pulse(pulse, &mut workspace, &mut list, &mut record).unwrap();
            [0, 1].map(|channel| -> Vec<Complex64> {
                let paths = list.amplitude[channel].iter().zip(&list.delay_s[0]);
                let turned = |(a, delay_s): (&Complex64, &f64)| {
                    a * Complex64::cis(-(TAU * scene.radar.carrier_hz * delay_s) % TAU)
                };
                paths.map(turned).collect()
            })
        };
        for instant in 0..6 {
            let (before, after) = (of(3000 * instant), of(3000 * instant + 1));
            for channel in 0..2 {
                let pairs = before[channel].iter().zip(&after[channel]);
                covariance[channel] += pairs.map(|(a, b)| a.conj() * b).sum::<Complex64>();
            }
        }
    }
    covariance.map(|c| c.arg() / lag_s / TAU)
}

/// Bragg's own line and the drift bring centroids to what is measured. A linear sea is the same upwind and
/// downwind: half the difference of both is compared, of which 89 to 94 % are here. The rest, and the 3 to 9
/// Hz by which measured ones are larger upwind, is that of short waves that long ones modulate (below) and of
/// breaking waves.
#[test]
fn centroids_in_c_band_are_near_those_of_cdop() {
    let drifting = BraggWaves::Travelling { drift_share: 0.03, drift_turn_rad: 0.0 };
    for (incidence_deg, measured) in some_of(CDOP) {
        let of = |bragg| {
            [0.0, 90.0, 180.0].map(|off_deg| centroids_hz(incidence_deg, off_deg, (bragg, Modulation::Off)))
        };
        let (found, frozen) = (of(drifting), of(BraggWaves::Frozen));
        println!("{incidence_deg} deg: {found:.1?} Hz, frozen {frozen:.1?}, CDOP {measured:.1?}");
        for polarisation in 0..2 {
            let half = |of: &[[f64; 2]; 3]| 0.5 * (of[0][polarisation] - of[2][polarisation]);
            let (share, of_frozen) = (half(&found) / half(&measured), half(&frozen) / half(&measured));
            assert!((0.75..1.1).contains(&share) && of_frozen < 0.65, "{share} {of_frozen}");
            assert!(found[1][polarisation].abs() < 2.0, "crosswind");
        }
    }
}

/// Short waves that long ones modulate add Doppler both ways: half the difference of upwind and downwind
/// comes nearer to what is measured.
#[test]
fn modulation_moves_centroids_in_c_band_towards_cdop() {
    let drifting = BraggWaves::Travelling { drift_share: 0.03, drift_turn_rad: 0.0 };
    for (incidence_deg, measured) in some_of(CDOP) {
        let of =
            |modulation| [0.0, 180.0].map(|off| centroids_hz(incidence_deg, off, (drifting, modulation)));
        let (off, found) = (of(Modulation::Off), of(Modulation::Relaxation { rate_per_s: None }));
        println!("{incidence_deg} deg: {found:.1?} Hz, without {off:.1?}, CDOP {measured:.1?}");
        for polarisation in 0..2 {
            let half = |up: &[f64; 2], down: &[f64; 2]| 0.5 * (up[polarisation] - down[polarisation]);
            let wanted = half(&measured[0], &measured[2]);
            let [share, before] = [&found, &off].map(|of| half(&of[0], &of[1]) / wanted);
            println!("{before:.3} -> {share:.3}");
            assert!(share > before && (share - 1.0).abs() < (before - 1.0).abs() + 0.05, "{before} {share}");
        }
    }
}
