//! Short waves of ships as a local spectrum: held to direct sums of the free waves, of which it knows only energies and rays.

use std::f64::consts::PI;

use nereus::sea::GRAVITY_MPS2;
use nereus::sea::wake::nodes::Band;
use nereus::sea::wake::short_waves::Losses;
use nereus::sea::wake::{Course, Reach, Settings, ShortWaves, Upstream, Wigley};
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

/// Free waves from one t to another, in steps so small that phases turn by less than half a turn at 300 m astern.
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
    // By waves: up to t = 8 of either side; half the squared modulus over a cut is Parseval's, at any distance.
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
    // By the spectrum: over half the cut, and as much again for the other. Steps of a deviation leave exp(-2 pi^2) = 3e-9
    // of a Gaussian's integral.
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
    // Linear interpolation of amplitudes that turn by an eighth of a radian from node to node loses 1/512 of them; twice that where
    // bow and stern cancel.
    assert!(worst < 4e-3);
}
