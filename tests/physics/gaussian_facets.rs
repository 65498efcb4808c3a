//! Facets of Gaussian amplitude, one in a resolution cell, against nine facets of random phase in its place:
//! what a cell returns has the same mean, the same speckle and texture, the same coherence of polarisations
//! and the same Doppler.

use std::f64::consts::TAU;

use nereus::paths::PathGenerator;
use nereus::scene::radar::{Gate, Polarisation, Window};
use nereus::scene::sea::{BraggWaves, Breaking, FacetScattering, Modulation, Speckle};
use nereus::scene::water::WindStrength;
use nereus::scene::{Scene, Sea};
use nereus::time::PulseTimes;
use num_complex::Complex64;

use super::radar_scenes::{PULSE_S, buffers, channels, scene, straight};
use super::sea_paths::sea;

use Polarisation::{H, V};

/// Side of a resolution cell, m, and of the patch in cells.
const CELL_M: f64 = 2.4;
const CELLS: usize = 64;
/// VV, HH, HV.
const PORTS: [(Polarisation, Polarisation); 3] = [(V, V), (H, H), (H, V)];
const LAG_S: f64 = 1e-3;

/// Of the cells of a sea: mean power of each channel, W; its normalised second moment; coherence of VV and
/// HH and of VV and HV; Doppler centroid and width of VV, Hz.
#[derive(Debug, Default)]
struct Moments {
    power: [f64; 3],
    contrast: [f64; 3],
    coherence: [f64; 2],
    doppler_hz: [f64; 2],
}

/// What the cells of a patch return at some pulses, seen from the East: `[pulse][channel][cell]`.
fn cells(scene: &Scene, incidence_deg: f64, pulses: &[u64]) -> Vec<[Vec<Complex64>; 3]> {
    let (sin, cos) = incidence_deg.to_radians().sin_cos();
    let place = straight(scene, [20_000.0 * sin, 0.0, 20_000.0 * cos], [0.0; 3]);
    let generator = PathGenerator::new(scene, PULSE_S, vec![place.clone(), place]).unwrap();
    let mut workspace = generator.workspace();
    let (mut list, mut record) = buffers(scene);
    let [nx, ny] = scene.sea.as_ref().unwrap().patch.facets;
    let within = nx / CELLS;
    let mut of = |pulse: u64| {
        generator.pulse(pulse, &mut workspace, &mut list, &mut record).unwrap();
        assert_eq!(list.amplitude[0].len(), nx * ny, "a facet each");
        [0, 1, 2].map(|channel| {
            let mut cells = vec![Complex64::ZERO; CELLS * CELLS];
            for (n, a) in list.amplitude[channel].iter().enumerate() {
                let turn = Complex64::cis(-(TAU * scene.radar.carrier_hz * list.delay_s[0][n]) % TAU);
                cells[n / nx / within * CELLS + n % nx / within] += a * turn;
            }
            cells
        })
    };
    pulses.iter().map(|pulse| of(*pulse)).collect()
}

fn moments(facet_m: f64, speckle: Speckle, incidence_deg: f64) -> Moments {
    let (mut sums, mut squares, mut products) = ([0.0; 3], [0.0; 3], [Complex64::ZERO; 2]);
    let (mut covariance, mut count) = (Complex64::ZERO, 0.0);
    for seed in 1..=3 {
        let mut water: Sea = sea((CELLS as f64 * CELL_M / facet_m).round() as usize, facet_m, 0.6);
        water.scattering = FacetScattering { speckle, breaking: Breaking::Off, ..FacetScattering::default() };
        let mut scene = Scene { sea: Some(water), targets: Vec::new(), seed, ..scene() };
        scene.radar.carrier_hz = 10e9;
        scene.radar.emissions = PulseTimes::uniform(1.0 / LAG_S).unwrap();
        scene.radar.window = Window { samples: 1000, gate: Gate::Fixed { start_s: 130e-6 } };
        scene.radar.channels = channels(&PORTS);
        let pulses: Vec<u64> = (0..3).flat_map(|n| [150 * n, 150 * n + 1]).collect();
        let all = cells(&scene, incidence_deg, &pulses);
        for two in all.chunks(2) {
            let [[of_vv, of_hh, of_hv], [later, ..]] = two else { unreachable!() };
            for (((vv, hh), hv), later) in of_vv.iter().zip(of_hh).zip(of_hv).zip(later) {
                for (n, power) in [vv, hh, hv].map(Complex64::norm_sqr).into_iter().enumerate() {
                    sums[n] += power;
                    squares[n] += power * power;
                }
                products[0] += vv * hh.conj();
                products[1] += vv * hv.conj();
                covariance += vv.conj() * later;
                count += 1.0;
            }
        }
    }
    Moments {
        power: sums.map(|sum| sum / count),
        contrast: [0, 1, 2].map(|n| squares[n] * count / (sums[n] * sums[n])),
        coherence: [1, 2].map(|n| products[n - 1].norm() / (sums[0] * sums[n]).sqrt()),
        doppler_hz: [
            covariance.arg() / LAG_S / TAU,
            (2.0 * (1.0 - covariance.norm() / sums[0])).max(0.0).sqrt() / LAG_S / TAU,
        ],
    }
}

/// Means, speckle, texture, coherence and Doppler of cells of one Gaussian facet are those of cells of nine
/// facets of random phase, of which a ninth of the excess of one alone is left; that one alone is too spiky
/// shows that the test can fail.
#[test]
fn one_facet_a_cell_is_as_good_as_nine() {
    for incidence_deg in [45.0, 60.0] {
        let nine = moments(CELL_M / 3.0, Speckle::RandomPhase, incidence_deg);
        let single = moments(CELL_M, Speckle::RandomPhase, incidence_deg);
        let one = moments(CELL_M, Speckle::Gaussian { tilt_modes: 3 }, incidence_deg);
        println!("{incidence_deg} deg\nnine {nine:.3?}\none {one:.3?}\nsingle {single:.3?}");
        for channel in 0..3 {
            let db = 10.0 * (one.power[channel] / nine.power[channel]).log10();
            println!("{channel}: {db:.2} dB");
            assert!(db.abs() < 0.3, "{channel}: {db:.2} dB");
            let [own, of_nine, of_single] = [&one, &nine, &single].map(|of| of.contrast[channel]);
            let many = of_nine - (of_single - own) / 9.0;
            assert!((own / many - 1.0).abs() < 0.06, "{channel}: {own} {many}");
            assert!(of_single > 1.3 * own, "{channel}: {of_single} {own}");
        }
        for (own, other) in one.coherence.iter().zip(nine.coherence) {
            assert!((own - other).abs() < 0.03, "{own} {other}");
        }
        for (own, other) in one.doppler_hz.iter().zip(nine.doppler_hz) {
            // The larger map has less of the correlation of roughness with orbital motion.
            assert!((own / other - 1.0).abs() < 0.12, "{own} {other}");
        }
    }
}

/// At any instant the amplitude of a facet is complex Gaussian, frozen, forgotten or travelling: powers of
/// facets that are lit alike have the moments n! of an exponential law.
#[test]
fn amplitudes_of_a_calm_sea_are_gaussian() {
    for (bragg, decorrelation_s) in
        [(BraggWaves::TRAVELLING, None), (BraggWaves::Frozen, None), (BraggWaves::Frozen, Some(0.01))]
    {
        let mut water = sea(CELLS, 1.0, 0.6);
        water.water.wind.strength = WindStrength::Speed { speed_mps: 3.0, height_m: 10.0 };
        water.scattering = FacetScattering {
            speckle: Speckle::Gaussian { tilt_modes: 3 },
            bragg,
            decorrelation_s,
            tilt_average: false,
            breaking: Breaking::Off,
            modulation: Modulation::Off,
            ..FacetScattering::default()
        };
        let mut scene = Scene { sea: Some(water), targets: Vec::new(), ..scene() };
        scene.radar.window = Window { samples: 1000, gate: Gate::Fixed { start_s: 130e-6 } };
        scene.radar.channels = channels(&PORTS);
        let all = cells(&scene, 50.0, &[3]);
        let count = (CELLS * CELLS) as f64;
        let of = |n: i32| all[0][0].iter().map(|a| a.norm_sqr().powi(n)).sum::<f64>() / count;
        let [second, third] = [2, 3].map(|n| of(n) / of(1).powi(n));
        println!("{bragg:?} {decorrelation_s:?}: {second:.3} {third:.3}");
        assert!((second - 2.0).abs() < 0.3 && (third - 6.0).abs() < 2.5);
    }
}
