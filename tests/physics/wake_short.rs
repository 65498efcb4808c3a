//! Short waves of ships as a local spectrum: held to direct sums of the free waves, of which it knows only
//! energies and rays.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use nereus::scene::Hull;
use nereus::scene::water::{Development, SpectrumKind, WindGiven, WindProfile, WindStrength};
use nereus::sea::GRAVITY_MPS2;
use nereus::sea::spectrum::of_kind;
use nereus::sea::wake::kochin::{Kochin, Transom};
use nereus::sea::wake::nodes::Band;
use nereus::sea::wake::short_waves::{Losses, STEEPEST, VISCOSITY_M2PS};
use nereus::sea::wake::{Course, Reach, Settings, ShortWaves, TurbulentStrip, Upstream, WakeError, Wigley};
use nereus::sea::wind::Wind;
use num_complex::Complex64;

const BOAT: Wigley = Wigley { length_m: 20.0, beam_m: 3.0, draught_m: 1.0 };
const SPEED_MPS: f64 = 5.0;
const FACET_M: f64 = 1.0;
const SHORTEST_RADPM: f64 = 30.0;

fn settings() -> Settings {
    Settings { upstream: Upstream::Symmetric, ..Settings::new(FACET_M, Reach::disc(0.0)) }
}

fn boat(shortest_radpm: f64) -> ShortWaves {
    let course = Course::straight([0.0, 0.0], 0.0, SPEED_MPS);
    let amplitude_m = |t: f64| BOAT.amplitude_m(SPEED_MPS, t);
    ShortWaves::new(course, BOAT.length_m, &settings(), shortest_radpm, amplitude_m).unwrap()
}

/// One of the free waves that the map leaves out: amplitude, m, wave vector ahead and to port, rad/m.
struct Wave {
    amplitude_m: Complex64,
    k_radpm: [f64; 2],
}

/// Free waves from one t to another, in steps so small that phases turn by less than half a turn at 300 m
/// astern.
fn left_out(from: f64, to: f64) -> Vec<Wave> {
    let k0 = GRAVITY_MPS2 / (SPEED_MPS * SPEED_MPS);
    let band = Band::of_facets(FACET_M);
    let step = 1e-3;
    let first = (from / step).ceil() as i64;
    (first..=(to / step).floor() as i64)
        .map(|i| {
            let t = step * i as f64;
            let sec2 = 1.0 + t * t;
            let weight = band.weight(k0 * sec2);
            let amplitude_m =
                BOAT.amplitude_m(SPEED_MPS, t.abs()) * ((1.0 - weight * weight).sqrt() * step / sec2);
            Wave { amplitude_m, k_radpm: [k0 * sec2.sqrt(), k0 * t * sec2.sqrt()] }
        })
        .collect()
}

#[test]
fn the_spectrum_has_the_energy_that_the_map_leaves_out() {
    // By waves: up to t = 8 of either side; half the squared modulus over a cut is Parseval's, at any
    // distance.
    let most = 8.0;
    let waves = left_out(-most, most);
    let (astern_m, dy_m) = (150.0, 0.05);
    let mut by_waves = 0.0;
    for i in -1400..=1400 {
        let y_m = dy_m * f64::from(i);
        let sum: Complex64 = waves
            .iter()
            .map(|w| w.amplitude_m * Complex64::cis(-w.k_radpm[0] * astern_m - w.k_radpm[1] * y_m))
            .sum();
        by_waves += 0.5 * sum.norm_sqr() * dy_m;
    }
    let k0 = GRAVITY_MPS2 / (SPEED_MPS * SPEED_MPS);
    // The table ends six deviations, 6 sqrt(3) rad/m, above the wave number asked.
    let short = boat(k0 * (1.0 + most * most) - 6.0 * 3f64.sqrt()).with_losses(Losses::NONE);
    let by_table = short.energy_m3();
    // By the spectrum: over half the cut, and as much again for the other. Steps of a deviation leave exp(-2
    // pi^2) = 3e-9 of a Gaussian's integral.
    let (dy_m, dk) = (FACET_M / 12f64.sqrt(), 3f64.sqrt());
    let mut by_spectrum = 0.0;
    for iy in 0..230 {
        for ix in -8..=8 {
            for jy in -22..=22 {
                let k = [dk * f64::from(ix), dk * f64::from(jy)];
                let weight = if iy == 0 { 0.5 } else { 1.0 };
                by_spectrum += weight * short.psi_m4([astern_m, dy_m * f64::from(iy)], k);
            }
        }
    }
    by_spectrum *= 2.0 * dy_m * dk * dk;
    println!("energy, m^3: waves {by_waves:.6e}, table {by_table:.6e}, spectrum {by_spectrum:.6e}");
    assert!((by_table / by_waves - 1.0).abs() < 2e-3);
    assert!((by_spectrum / by_table - 1.0).abs() < 2e-3);
}

/// The squared Fourier transform of the waves themselves under a Gaussian window, m^4.
fn directly_m4(waves: &[Wave], [astern_m, starboard_m]: [f64; 2], k_radpm: [f64; 2]) -> f64 {
    let s2 = FACET_M * FACET_M / 12.0;
    let sum: Complex64 = waves
        .iter()
        .map(|w| {
            let off = [0, 1].map(|i| k_radpm[i] - w.k_radpm[i]);
            let window = (-s2 * (off[0] * off[0] + off[1] * off[1])).exp();
            let phase = -w.k_radpm[0] * astern_m - w.k_radpm[1] * starboard_m;
            w.amplitude_m * Complex64::cis(phase) * window
        })
        .sum();
    0.25 * sum.norm_sqr() * 2.0 * s2 / PI
}

#[test]
fn the_spectrum_of_a_place_is_that_of_its_waves() {
    let waves = left_out(-9.5, 9.5);
    let short = boat(SHORTEST_RADPM).with_losses(Losses::NONE);
    let k0 = GRAVITY_MPS2 / (SPEED_MPS * SPEED_MPS);
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for astern_m in [100.0, 200.0, 300.0] {
        for t in [3.5f64, 4.5, 6.0, 7.5] {
            for source_m in [-10.0, 10.0] {
                let y_m = -(astern_m - source_m) * t / (1.0 + 2.0 * t * t);
                let sec = (1.0 + t * t).sqrt();
                let level = directly_m4(&waves, [astern_m, y_m], [k0 * sec, k0 * sec * t]).sqrt();
                for [dx, dy] in [[0.0, 0.0], [1.0, 0.0], [-0.5, 1.5]] {
                    let k = [k0 * sec + dx, k0 * sec * t + dy];
                    let place = [astern_m, y_m + 0.1];
                    let (ours, direct) = (short.psi_m4(place, k), directly_m4(&waves, place, k));
                    largest = largest.max(direct);
                    worst = worst.max((ours.sqrt() - direct.sqrt()).abs() / level.max(direct.sqrt()));
                    println!("{astern_m} {t} {source_m} {dx} {dy}: {ours:.3e} {direct:.3e}");
                }
            }
        }
    }
    println!("worst {worst:.3e}, largest {largest:.2e} m^4");
    // Linear interpolation of amplitudes that turn by 1/16 radian from node to node loses 1/2048 of them, of
    // bow and stern each; of an amplitude whose parts cancel to a third, 1/340.
    assert!(worst < 3e-3);
}

#[test]
fn waves_of_slow_ships_and_of_ships_that_no_map_shows() {
    let make = |speed_mps: f64, facet_m: f64| {
        let course = Course::straight([0.0, 0.0], 0.0, speed_mps);
        let settings = Settings::new(facet_m, Reach::disc(0.0));
        ShortWaves::new(course, 20.0, &settings, 50.0, |t| BOAT.amplitude_m(speed_mps, t)).unwrap()
    };
    assert!(make(0.0, 1.0).is_empty() && make(0.0999, 1.0).is_empty());
    // 2 pi V^2/g = 3.63 m is less than four facets of 1 m: all of its waves are within facets, also the
    // longest, of k0.
    let (hidden, k0) = (make(2.38, 1.0), GRAVITY_MPS2 / (2.38 * 2.38));
    let shown = make(2.6, 1.0);
    assert!(hidden.psi_m4([60.0, 0.0], [k0, 0.0]) > 0.0);
    // The map's own waves are not counted twice: 1 - W^2 of k0 = 1.45 rad/m is 0.31 there.
    let k0 = GRAVITY_MPS2 / (2.6 * 2.6);
    let weight = Band::of_facets(1.0).weight(k0);
    assert!((0.2..0.5).contains(&(1.0 - weight * weight)));
    assert!(shown.psi_m4([60.0, 0.0], [k0, 0.0]) > 0.0);
    // Refused as a wake is.
    let course = Course::straight([0.0, 0.0], 0.0, 5.0);
    let refused = |length_m: f64, facet_m: f64, shortest_radpm: f64, a: f64| {
        let settings = Settings::new(facet_m, Reach::disc(0.0));
        ShortWaves::new(course, length_m, &settings, shortest_radpm, |_| Complex64::new(a, 0.0)).unwrap_err()
    };
    assert!(matches!(refused(0.0, 1.0, 50.0, 1.0), WakeError::Length { .. }));
    assert!(matches!(refused(20.0, 0.0, 50.0, 1.0), WakeError::Facet { .. }));
    assert!(matches!(refused(20.0, 1.0, f64::NAN, 1.0), WakeError::Cutoff { .. }));
    assert!(matches!(refused(20.0, 1.0, 50.0, f64::NAN), WakeError::Amplitude { .. }));
}

#[test]
fn losses_only_take() {
    let (free, damped) = (boat(SHORTEST_RADPM).with_losses(Losses::NONE), boat(SHORTEST_RADPM));
    let viscous = boat(SHORTEST_RADPM).with_losses(Losses { steepest: f64::INFINITY, ..Losses::default() });
    let k0 = GRAVITY_MPS2 / (SPEED_MPS * SPEED_MPS);
    let mut least = 1.0f64;
    for astern_m in [30.0, 100.0, 400.0] {
        for t in [3.0f64, 5.0, 8.0] {
            let k = [k0 * t.hypot(1.0), -k0 * t * t.hypot(1.0)];
            let place = [astern_m, astern_m * t / (1.0 + 2.0 * t * t)];
            let [all, some, fewer] = [&free, &viscous, &damped].map(|waves| waves.psi_m4(place, k));
            assert!(fewer <= some && some <= all && fewer > 0.0);
            // The spectrum of the steepest wave, STEEPEST^2/K^2 s^2/(2 pi).
            let bound = (STEEPEST / k[0].hypot(k[1])).powi(2) * FACET_M * FACET_M / 12.0 / (2.0 * PI);
            assert!(fewer <= bound * (1.0 + 1e-12));
            // exp(-4 nu K^2 a) of the ray itself. At t = 8, K = 25 rad/m, a deviation of K is 7 %, of K^2 14
            // %, and from 100 m on ages of bow and stern differ by 10 % from that of midship.
            let age_s = astern_m / (SPEED_MPS * (1.0 - 0.5 / (1.0 + t * t)));
            let k2 = k0 * k0 * (1.0 + t * t).powi(2);
            let exponent = 4.0 * VISCOSITY_M2PS * k2 * age_s;
            least = least.min(some / all);
            if t == 8.0 && astern_m >= 100.0 {
                let found = -(some / all).ln();
                assert!((found / exponent - 1.0).abs() < 0.3, "{found} {exponent}");
            }
        }
    }
    println!("viscosity takes up to {:.3} of the power", 1.0 - least);
}

/// The table of the decision page on short waves is made here.
#[test]
fn the_figures_of_the_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/decisions/0017-short-waves-of-ships.md")).unwrap();
    let hull = Hull::load(&root.join("hulls/dtmb5415.toml")).unwrap().scaled_to_length(100.0).unwrap();
    let strength = WindStrength::Speed { speed_mps: 7.0, height_m: 10.0 };
    let given = WindGiven { strength, profile: WindProfile::Cardone, direction_rad: 0.0 };
    let wind = Wind::resolve(&given).unwrap();
    let kind = SpectrumKind::Elfouhaily { development: Development::default() };
    let sea = of_kind(&kind, &wind).unwrap();
    let astern_m = 500.0;
    let strip = TurbulentStrip::with(hull.length_m(), hull.beam_m(), 5.0, 20.0 * hull.length_m()).unwrap();
    let half_strip_m = 0.5 * strip.width_m(astern_m - 50.0);
    let mut missing = Vec::new();
    for speed_mps in [4.5, 9.0] {
        let kochin = Kochin::new(&hull, speed_mps, Transom::Open).unwrap();
        for (band, carrier_hz) in [("L, 1.3 GHz", 1.3e9), ("C, 5.3 GHz", 5.3e9), ("X, 10 GHz", 10e9)] {
            // Backscatter at 45 degrees.
            let k = 2.0 * TAU * carrier_hz / 299_792_458.0 * 0.5f64.sqrt();
            let course = Course::straight([0.0, 0.0], 0.0, speed_mps);
            let settings = Settings::new(1.0, Reach::disc(0.0));
            let waves =
                ShortWaves::new(course, hull.length_m(), &settings, k, |t| kochin.amplitude_m(t)).unwrap();
            let k0 = kochin.transverse_radpm();
            let t = (k / k0 - 1.0).sqrt();
            let vector = [k0 * t.hypot(1.0), -k0 * t * t.hypot(1.0)];
            let free = waves.clone().with_losses(Losses::NONE);
            let (mut most, mut place_m, mut freely) = (0.0, 0.0, 0.0f64);
            for i in 0..400 {
                let y_m = 0.1 * f64::from(i);
                let here = waves.psi_m4([astern_m, y_m], vector);
                freely = freely.max(free.psi_m4([astern_m, y_m], vector));
                if here > most {
                    (most, place_m) = (here, y_m);
                }
            }
            let wind_psi = sea.omnidirectional_m3(k) / (TAU * k);
            let db = |psi: f64| 10.0 * (psi / wind_psi).log10();
            let row = format!(
                "| {speed_mps} m/s | {band} | {k:.1} | {place_m:.1} | {:+.0} | {:+.0} |",
                db(freely),
                db(most)
            );
            println!("{row}");
            assert!(place_m < half_strip_m);
            if !page.contains(&row) {
                missing.push(row);
            }
        }
    }
    println!("half the turbulent strip there: {half_strip_m:.1} m");
    assert!(page.contains(&format!("{half_strip_m:.0} m to either side")));
    assert!(missing.is_empty(), "the page lacks {missing:#?}");
}
