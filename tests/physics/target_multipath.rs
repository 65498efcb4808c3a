//! Targets over a sea that reflects: two rays in closed form, their fade with range and on waves.

use std::f64::consts::TAU;

use nereus::frames::{Earth, SceneFrame};
use nereus::geometry::horizon;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::roughness::coherent;
use nereus::scene::Scene;
use nereus::scene::sea::Sea;
use nereus::scene::target::Floating;
use nereus::scene::water::WindStrength;
use nereus::sea::realise::realise;
use nereus::units::SPEED_OF_LIGHT_MPS;
use num_complex::Complex64;

use crate::cases::cases;
use crate::radar_scenes::{scene, straight, target};
use crate::sea_paths::sea;

const MAST_M: f64 = 15.0;
const HH: usize = 0;
const VV: usize = 3;

/// No wind, no waves.
fn calm() -> Sea {
    let mut calm = sea(16, 4.0, 0.7);
    calm.water.wind.strength = WindStrength::Speed { speed_mps: 0.1, height_m: 10.0 };
    calm
}

/// A radar on a mast, and a target at a distance and a height over the mean sea.
fn with(sea: Sea, earth: Earth, distance_m: f64, height_m: f64) -> Scene {
    let mut scene = scene();
    scene.frame = SceneFrame::plain(earth);
    scene.sea = Some(sea);
    let (x_m, y_m) = (-0.6 * distance_m, 0.8 * distance_m);
    scene.targets = vec![target([x_m, y_m, height_m - earth.drop_m(x_m, y_m)], [0.0; 3])];
    scene.targets[0].multipath = true;
    scene
}

/// Fields of target and images at a pulse by channel, over the field of the straight path.
fn fields(scene: &Scene, mast_m: f64, indices: &[u64]) -> Vec<[Complex64; 4]> {
    let mast = straight(scene, [0.0, 0.0, mast_m], [0.0; 3]);
    let generator = PathGenerator::new(scene, 1e-6, vec![mast.clone(), mast]).unwrap();
    assert_eq!(generator.point_count(), 4);
    let mut paths = ScattererPaths::new(1, 4, 4);
    let of = |index: &u64| {
        generator.points(*index, &mut generator.workspace(), &mut paths).unwrap();
        std::array::from_fn(|channel| {
            let field = |n: usize| {
                let turns = scene.radar.carrier_hz * (paths.delay_s[0][n] - paths.delay_s[0][0]);
                paths.amplitude[channel][n] * Complex64::cis(-TAU * turns)
            };
            (0..4).map(field).sum::<Complex64>() / paths.amplitude[channel][0]
        })
    };
    indices.iter().map(of).collect()
}

fn wave_number(scene: &Scene) -> f64 {
    TAU * scene.radar.carrier_hz / SPEED_OF_LIGHT_MPS
}

/// The reflected ray over the straight one, `[V, H]`, of a flat sea as smooth as glass.
fn reflected(wave_number: f64, mast_m: f64, distance_m: f64, height_m: f64) -> [Complex64; 2] {
    let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    let eps = Model::default().permittivity(wave_number * SPEED_OF_LIGHT_MPS / TAU, water).unwrap();
    let [straight, by_sea] = [height_m - mast_m, height_m + mast_m].map(|rise| distance_m.hypot(rise));
    let (sine, cosine) = ((height_m + mast_m) / by_sea, distance_m / by_sea);
    let root = (eps - cosine * cosine).sqrt();
    let root = if root.im > 0.0 { -root } else { root };
    // The difference of ways without the difference of two lengths.
    let longer_m = 4.0 * mast_m * height_m / (straight + by_sea);
    let turned = Complex64::cis(-wave_number * longer_m) * (straight / by_sea);
    [(eps * sine - root) / (eps * sine + root), (sine - root) / (sine + root)].map(|of| of * turned)
}

#[test]
fn two_rays_over_a_flat_calm_sea_are_the_closed_form() {
    let mut worst_db = 0f64;
    for height_m in [0.5, 3.0, 12.0, 150.0] {
        for step in 0..40 {
            let distance_m = 300.0 * 1.15f64.powi(step);
            let scene = with(calm(), Earth::Flat, distance_m, height_m);
            let found = fields(&scene, MAST_M, &[0])[0];
            let [v, h] = reflected(wave_number(&scene), MAST_M, distance_m, height_m);
            for (channel, ray) in [(HH, h), (VV, v)] {
                // Out and back: two rays squared.
                let exact = (1.0 + ray).norm_sqr();
                worst_db = worst_db.max((20.0 * (found[channel].norm() / exact).log10()).abs());
            }
        }
    }
    println!("off by {worst_db:.1e} dB at most");
    assert!(worst_db < 0.1, "{worst_db}");
}

#[test]
fn a_low_target_fades_with_the_eighth_power_beyond_the_last_maximum() {
    let power = |distance_m: f64| {
        let scene = with(calm(), Earth::Flat, distance_m, 3.0);
        fields(&scene, MAST_M, &[0])[0][HH].norm_sqr() / distance_m.powi(4)
    };
    // The last maximum is at 4 h h/lambda = 6 km.
    let slope = (power(200e3) / power(60e3)).ln() / (200f64 / 60.0).ln();
    println!("power falls with range to the {slope:.3}");
    // Of sin x/x, x = 0.16 at 60 km, 0.8 % of half the exponent are left.
    assert!((slope + 8.0).abs() < 0.04, "{slope}");
    assert!(power(6e3) * 6e3f64.powi(4) > 14.0);
}

#[test]
fn the_reflected_rays_end_at_the_horizon() {
    let earth = Earth::Curved { radius_factor: 4.0 / 3.0 };
    let horizon_m = horizon::distance_m(earth, [MAST_M, 3.0]);
    let over = |share: f64| {
        let scene = with(calm(), earth, share * horizon_m, 3.0);
        fields(&scene, MAST_M, &[0])[0][HH].norm()
    };
    // Half way rays meet as on a flat sea, but for a lower grazing angle; at the horizon they spread.
    assert!((over(0.999_999) - 1.0).abs() < 0.1 && over(0.7) < 0.6, "{} {}", over(0.999_999), over(0.7));
}

#[test]
fn fading_on_waves_has_the_moments_of_a_gaussian_height() {
    let (mast_m, distance_m, height_m) = (30.0, 5000.0, 6.0);
    let (mut sums, mut count) = ([0.0; 4], 0.0);
    let mut scene = with(sea(32, 4.0, 0.7), Earth::Flat, distance_m, height_m);
    scene.targets[0].floating = Some(Floating { waterline_m: 1e-3 });
    scene.pulses = 22_200;
    let expected = realise(scene.sea.as_ref().unwrap(), 1).unwrap().surface.expected();
    // A hundred seconds of each of many seas.
    let indices: Vec<u64> = (0..8).map(|n| n * 2775).collect();
    let seeds = u64::from(cases(200));
    for seed in 0..seeds {
        scene.seed = seed;
        for field in fields(&scene, mast_m, &indices) {
            let power = field[HH].norm();
            [power, power * power, power.powi(4), 1.0].iter().zip(&mut sums).for_each(|(x, sum)| *sum += x);
            count += 1.0;
        }
    }
    let [mean, square, fourth, _] = sums.map(|sum| sum / count);
    // F = 1 + G e^-jqz, z Gaussian: q from the difference of ways, 2 h z/d.
    let k = wave_number(&scene);
    let sine = (mast_m + height_m) / distance_m.hypot(mast_m + height_m);
    let rho = coherent(k, expected.variance_m2.sqrt(), sine);
    let ray = reflected(k, mast_m, distance_m, height_m)[1] * rho;
    let damped = |n: f64| (-0.5 * (n * 2.0 * k * mast_m / distance_m).powi(2) * expected.variance_m2).exp();
    let g = ray.norm_sqr();
    let exact = 1.0 + g + 2.0 * ray.re * damped(1.0);
    let exact_square =
        (1.0 + g).powi(2) + 4.0 * (1.0 + g) * ray.re * damped(1.0) + 2.0 * (g + (ray * ray).re * damped(2.0));
    // Of the eight draws of one sea, 12 s apart, two are taken as independent.
    let error = |mean: f64, square: f64| ((square - mean * mean) / (2.0 * seeds as f64)).sqrt();
    let (sigma, sigma_square) = (error(mean, square), error(square, fourth));
    println!("rho {rho:.2}, damped to {:.2}; {mean:.3} of {exact:.3} +- {sigma:.3}", damped(1.0));
    println!("square {square:.3} of {exact_square:.3} +- {sigma_square:.3}");
    assert!(
        (mean - exact).abs() < 3.0 * sigma && sigma < 0.05 * (200.0 / seeds as f64).sqrt().max(1.0) * exact,
        "{mean} {exact} {sigma}"
    );
    assert!((square - exact_square).abs() < 3.0 * sigma_square, "{square} {exact_square} {sigma_square}");
}
