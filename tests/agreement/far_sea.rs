//! The sea beyond the patch: its power by a quadrature of the scattering model, power and Doppler of facets
//! at the same place, and that both echoes agree.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use nereus::config::Run;
use nereus::paths::list::ScattererPaths;
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;
use nereus::pipeline::stages::PulseFactory;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::sigma0::SeaView;
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::Settings;
use nereus::sea::realise::realise;
use nereus::sea::spectrum::WaveVector;
use num_complex::Complex64;

use crate::cases::{cases, some_of};
use crate::runs::{keeps_the_error, pulses, scene};

const FAR: &str = "tests/data/scenarios/far-sea.toml";
const C_MPS: f64 = 299_792_458.0;
const WAVELENGTH_M: f64 = C_MPS / 10e9;
const HEIGHT_M: f64 = 150.0;
const PITCH_DEG: f64 = -4.0;
/// The same sea by facets.
const FACETS: [(&str, &str); 3] = [
    ("scene.patch_size_m", "[512.0, 256.0]"),
    ("scene.patch_centre_m", "[2400.0, 0.0]"),
    ("sea.far", "{ enabled = false }"),
];

fn factory(run: &Run) -> PulseFactory {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap()
}

fn reference(settings: &[(&str, &str)]) -> PulseFactory {
    factory(&scene(FAR, &[settings, &[("fidelity.echo", "\"reference\"")]].concat()))
}

fn paths(settings: &[(&str, &str)]) -> ScattererPaths {
    reference(settings).scatterer_paths(0).unwrap().1
}

/// Power of a channel between two ranges, W.
fn power_w(paths: &ScattererPaths, channel: usize, ranges_m: [f64; 2]) -> f64 {
    let delays_s = ranges_m.map(|range_m| 2.0 * range_m / C_MPS);
    let of = paths.delay_s[0].iter().zip(&paths.amplitude[channel]);
    of.filter(|(delay_s, _)| (delays_s[0]..delays_s[1]).contains(*delay_s)).map(|(_, a)| a.norm_sqr()).sum()
}

/// Means over seeds, and the deviations of these means.
fn over_seeds<const N: usize>(
    seeds: u32,
    settings: &[(&str, &str)],
    of: impl Fn(&ScattererPaths) -> [f64; N],
) -> [[f64; 2]; N] {
    let values: Vec<[f64; N]> = (0..seeds)
        .map(|seed| of(&paths(&[settings, &[("scene.seed", &seed.to_string())]].concat())))
        .collect();
    let n = f64::from(seeds);
    std::array::from_fn(|i| {
        let mean = values.iter().map(|value| value[i]).sum::<f64>() / n;
        let variance = values.iter().map(|value| (value[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        [mean, (variance / n).sqrt()]
    })
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

/// Power that a flat sea returns from between two ranges, W, of HH and VV: the radar equation over the
/// surface, with the mean of facets' cross sections over Gaussian slopes of the waves that a map resolves.
fn expected_w(run: &Run, [near_m, far_m]: [f64; 2]) -> [f64; 2] {
    let sea = run.scene.sea.as_ref().unwrap();
    let realised = realise(sea, 1).unwrap();
    let wind = &realised.wind;
    let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    let view = SeaView {
        carrier_hz: 10e9,
        permittivity: Model::default().permittivity(10e9, water).unwrap(),
        wind,
        spectrum: &Turned(realised.spectrum.as_ref(), wind.direction_rad),
        kind: &Clean,
        aspect: (wind.direction_rad.cos(), wind.direction_rad.sin()),
        facet_m: Some(sea.patch.facet_m),
        relaxation: None,
        breaking: false,
        settings: Settings { tilt_average: true, ..Settings::default() },
    };
    let sigma0 = view.sigma0();
    // Covariance of slopes, by a plain sum over the square of the map.
    let most = PI / sea.patch.facet_m;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for n in 0..4000 {
        let k = 1e-3 * (most * 2f64.sqrt() / 1e-3).powf((f64::from(n) + 0.5) / 4000.0);
        let step = (most * 2f64.sqrt() / 1e-3).ln() / 4000.0;
        for azimuth in 0..90 {
            let (sin, cos) = (TAU * (f64::from(azimuth) + 0.5) / 90.0).sin_cos();
            if (k * cos).abs().max((k * sin).abs()) < most {
                let psi = realised.spectrum.symmetric_m4(WaveVector::new(k * cos, k * sin));
                let power = psi * k.powi(4) * step * TAU / 90.0;
                xx += power * cos * cos;
                xy += power * cos * sin;
                yy += power * sin * sin;
            }
        }
    }
    let (a, b) = (xx.sqrt(), xy / xx.sqrt());
    let c = (yy - b * b).sqrt();
    let mean = |range_m: f64| {
        let sine = HEIGHT_M / range_m;
        let cosine = (1.0 - sine * sine).sqrt();
        let down = DVec3::new(cosine, 0.0, -sine);
        let path = Path::new(down, -down);
        let (mut sum, mut weight) = ([0.0; 2], 0.0);
        for i in -40..=40 {
            for j in -40..=40 {
                let [u, v] = [i, j].map(|n| f64::from(n) / 8.0);
                let w = (-0.5 * (u * u + v * v)).exp();
                let slope = [a * u, b * u + c * v];
                weight += w;
                let area = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
                let [[vv, _], [_, hh]] = sigma0(&path, slope).sum;
                sum = [sum[0] + w * area * hh, sum[1] + w * area * vv];
            }
        }
        sum.map(|sum| sum / weight)
    };
    let (width_m, height_m) = (1.2, 0.15);
    let peak = 4.0 * PI * width_m * height_m / WAVELENGTH_M.powi(2);
    let (sin, cos) = PITCH_DEG.to_radians().sin_cos();
    let mut expected = [0.0; 2];
    let steps = 6;
    for n in 0..steps {
        let range_m = near_m + (far_m - near_m) * (f64::from(n) + 0.5) / f64::from(steps);
        let ground_m = (range_m * range_m - HEIGHT_M * HEIGHT_M).sqrt();
        let mean = mean(range_m);
        let azimuths = 2000;
        let mut beam = 0.0;
        for azimuth in 0..azimuths {
            let rad = 0.06 * ((f64::from(azimuth) + 0.5) / f64::from(azimuths) - 0.5);
            let way = DVec3::new(ground_m * rad.cos(), ground_m * rad.sin(), -HEIGHT_M) / range_m;
            // Direction cosines across the beam.
            let (u, v) = (way.y, way.z * cos - way.x * sin);
            if u.abs() <= WAVELENGTH_M / width_m {
                let gain = peak
                    * (sinc(PI * u * width_m / WAVELENGTH_M) * sinc(PI * v * height_m / WAVELENGTH_M))
                        .powi(2);
                beam += gain * gain * 0.06 / f64::from(azimuths);
            }
        }
        // dA = R dR dphi.
        let area = range_m * (far_m - near_m) / f64::from(steps);
        let scale = 1000.0 * WAVELENGTH_M.powi(2) / ((4.0 * PI).powi(3) * range_m.powi(4)) * beam * area;
        expected = [expected[0] + scale * mean[0], expected[1] + scale * mean[1]];
    }
    expected
}

/// A spectrum on axes along the wind.
#[derive(Debug)]
struct Turned<'a>(&'a dyn nereus::sea::spectrum::Spectrum, f64);

impl nereus::sea::spectrum::Spectrum for Turned<'_> {
    fn omnidirectional_m3(&self, k: f64) -> f64 {
        self.0.omnidirectional_m3(k)
    }
    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        let (sin, cos) = self.1.sin_cos();
        self.0.spreading_per_rad(WaveVector::new(
            k.x_rad_m * cos - k.y_rad_m * sin,
            k.x_rad_m * sin + k.y_rad_m * cos,
        ))
    }
    fn peak_rad_m(&self) -> f64 {
        self.0.peak_rad_m()
    }
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

/// Without shadows and modulation, for which no closed form is at hand.
const PLAIN: [(&str, &str); 2] =
    [("sea.shadow", "{ enabled = false }"), ("sea.scattering.modulation", "\"off\"")];

#[test]
fn power_is_that_of_a_quadrature_of_the_scattering_model() {
    let ranges_m = [[1700.0, 1900.0], [2300.0, 2600.0]];
    let many = [&PLAIN[..], &[("sea.far.cells", "16"), ("sea.far.most_cells", "100000")]].concat();
    let of = |paths: &ScattererPaths| [0, 1, 2, 3].map(|n| power_w(paths, n % 2, ranges_m[n / 2]));
    let found = over_seeds(cases(12), &many, of);
    let run = scene(FAR, &PLAIN);
    for (n, ranges_m) in ranges_m.into_iter().enumerate() {
        let expected = expected_w(&run, ranges_m);
        for channel in 0..2 {
            let [mean, deviation] = found[2 * n + channel];
            let (off_db, deviation_db) = (db(mean / expected[channel]), 4.34 * deviation / mean);
            println!(
                "{ranges_m:?} channel {channel}: {off_db:.3} dB of the expected, deviation {deviation_db:.3}"
            );
            assert!(off_db.abs() < 0.3 + 2.0 * deviation_db);
        }
    }
}

/// Power, mean Doppler and rms width, Hz, of a channel between ranges, by the correlation of pulses 0.5 ms
/// apart.
fn moments(settings: &[(&str, &str)], channel: usize, ranges_m: [f64; 2], seeds: u32) -> [[f64; 2]; 3] {
    let lag_s = 1.0 / 4000.0;
    let values: Vec<[f64; 3]> = (0..seeds)
        .map(|seed| {
            let seed = seed.to_string();
            let more = [("scene.seed", seed.as_str()), ("radar.prf_hz", "4000.0")];
            let factory = reference(&[settings, &more].concat());
            let field = |index: u64| {
                let paths = factory.scatterer_paths(index).unwrap().1;
                let mut field = vec![Complex64::ZERO; 64];
                for (delay_s, a) in paths.delay_s[0].iter().zip(&paths.amplitude[channel]) {
                    let share = (0.5 * C_MPS * delay_s - ranges_m[0]) / (ranges_m[1] - ranges_m[0]);
                    if (0.0..1.0).contains(&share) {
                        field[(64.0 * share) as usize] += a * Complex64::cis(-TAU * 10e9 * delay_s);
                    }
                }
                field
            };
            let (mut power, mut product) = (0.0, Complex64::ZERO);
            for first in [0u64, 100, 200, 300] {
                let [one, other] = [field(first), field(first + 1)];
                power += 0.5 * one.iter().chain(&other).map(Complex64::norm_sqr).sum::<f64>();
                product += one.iter().zip(&other).map(|(a, b)| a.conj() * b).sum::<Complex64>();
            }
            [power, product.re, product.im]
        })
        .collect();
    let of = |some: &[[f64; 3]]| {
        let sum = |i: usize| some.iter().map(|value| value[i]).sum::<f64>();
        let product = Complex64::new(sum(1), sum(2));
        let width = (-2.0 * (product.norm() / sum(0)).ln()).max(0.0).sqrt() / (TAU * lag_s);
        [sum(0) / some.len() as f64, product.arg() / (TAU * lag_s), width]
    };
    let all = of(&values);
    // Deviations by leaving one out.
    let n = values.len() as f64;
    let without: Vec<[f64; 3]> = (0..values.len())
        .map(|out| {
            let rest: Vec<_> =
                values.iter().enumerate().filter(|(i, _)| *i != out).map(|(_, v)| *v).collect();
            of(&rest)
        })
        .collect();
    std::array::from_fn(|i| {
        let variance: f64 =
            without.iter().map(|value| (value[i] - all[i]).powi(2)).sum::<f64>() * (n - 1.0) / n;
        [all[i], variance.sqrt()]
    })
}

#[test]
fn power_and_doppler_are_those_of_facets_at_the_same_place() {
    let ranges_m = [2210.0, 2590.0];
    for channel in some_of([1, 0]) {
        let far = moments(
            &[("sea.far.cells", "32"), ("sea.far.most_cells", "1000000")],
            channel,
            ranges_m,
            cases(16),
        );
        let facets = moments(&FACETS, channel, ranges_m, cases(12));
        println!("channel {channel}: far {far:.4?}, facets {facets:.4?}");
        let off_db = db(far[0][0] / facets[0][0]);
        let deviation_db = 4.34 * (far[0][1] / far[0][0]).hypot(facets[0][1] / facets[0][0]);
        println!("power {off_db:.3} dB, deviation {deviation_db:.3}");
        assert!(off_db.abs() < 0.5 + 2.0 * deviation_db);
        for i in [1, 2] {
            let (off, deviation) = (far[i][0] - facets[i][0], far[i][1].hypot(facets[i][1]));
            println!("{}: off {off:.2} Hz, deviation {deviation:.2}", ["", "centroid", "width"][i]);
            assert!(off.abs() < 0.1 * facets[2][0] + 2.0 * deviation);
        }
    }
}

/// A fixed beam; alternating polarisations from two places; a beam that scans; from an aircraft, beside the
/// patch.
const SCENES: [(&str, &[(&str, &str)]); 2] = [
    (FAR, &[("radar.window.samples", "64"), ("scene.duration_s", "0.04")]),
    (
        "configs/scan.toml",
        &[
            ("scene.duration_s", "0.05"),
            ("scene.patch_size_m", "[96, 96]"),
            ("sea.far", "{ enabled = true, cells = 2 }"),
        ],
    ),
];

#[test]
fn the_far_sea_keeps_the_error() {
    for (path, settings) in some_of(SCENES) {
        let fast = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", "-60.0")];
        let run = scene(path, &[settings, &fast].concat());
        keeps_the_error(path, &run);
    }
}

#[test]
fn a_part_of_a_run_over_the_far_sea_is_bit_identical() {
    // Slots begin every second: at pulse 500.
    let long = [("scene.duration_s", "1.1"), ("radar.window.samples", "64")];
    let whole = pulses(FAR, &long, "2", 490..510);
    for begin in some_of([497, 504]) {
        assert!(pulses(FAR, &long, "1", begin..510) == whole[begin as usize - 490..], "a part differs");
    }
}
