//! Floating targets: lifted by the very sea of the scene, at their moving place, and hidden by its crests.

use std::f64::consts::TAU;
use std::io::Write;

use nereus::frames::{Earth, SceneFrame};
use nereus::paths::PathGenerator;
use nereus::scene::Scene;
use nereus::scene::sea::Shadowing;
use nereus::scene::target::{Aspect, Floating};
use nereus::sea::realise::realise;
use nereus::units::SPEED_OF_LIGHT_MPS;

use crate::cases::sized;
use crate::radar_scenes::{evaluate, scene, straight, target};
use crate::sea_paths::sea;

const HIGH_M: f64 = 500.0;

/// A target that floats, and a radar that stays above it; ten seconds.
fn with(waterline_m: f64, earth: Earth) -> (Scene, PathGenerator) {
    let mut scene = scene();
    scene.frame = SceneFrame::plain(earth);
    scene.pulses = 2220;
    scene.sea = Some(sea(64, 2.0, 0.7));
    let (at, velocity) = ([40.0, -30.0, 1.5], [3.0, 4.0, 0.0]);
    scene.targets = vec![target(at, velocity)];
    scene.targets[0].floating = Some(Floating { waterline_m });
    let above = straight(&scene, [at[0], at[1], HIGH_M], velocity);
    let generator = PathGenerator::new(&scene, 1e-6, vec![above.clone(), above]).unwrap();
    (scene, generator)
}

/// Height of the target and its rate at a pulse, from delay and Doppler.
fn height(scene: &Scene, generator: &PathGenerator, index: u64) -> [f64; 2] {
    let (_, record) = evaluate(scene, generator, index);
    let rate = -record.target_doppler_hz[0] / scene.radar.carrier_hz;
    [HIGH_M - 0.5 * SPEED_OF_LIGHT_MPS * record.target_delay_s[0], -0.5 * SPEED_OF_LIGHT_MPS * rate]
}

#[test]
fn a_point_rides_the_surface_of_the_scene() {
    let (scene, generator) = with(1e-3, Earth::Flat);
    let surface = realise(scene.sea.as_ref().unwrap(), scene.seed).unwrap().surface;
    let (mut off_m, mut off_mps, mut largest_m) = (0f64, 0f64, 0f64);
    for index in (0..2220).step_by(37) {
        let [z_m, rate] = height(&scene, &generator, index);
        // The scattering is half the delay after the emission.
        let t_s = index as f64 / 222.0 + 0.5 * HIGH_M / SPEED_OF_LIGHT_MPS;
        let wave = surface.at([40.0 + 3.0 * t_s, -30.0 + 4.0 * t_s], t_s);
        let climbs = wave.velocity_mps[2] + 3.0 * wave.slope[0] + 4.0 * wave.slope[1];
        off_m = off_m.max((z_m - 1.5 - wave.height_m).abs());
        off_mps = off_mps.max((rate - climbs).abs());
        largest_m = largest_m.max(wave.height_m.abs());
    }
    println!("off by {off_m:.1e} m and {off_mps:.1e} m/s of up to {largest_m:.2} m");
    // Quintics between knots, 4e-7 of waves of 1 m; their rate by the knots' distance, 1/50 s, more.
    assert!(off_m < 1e-6 && off_mps < 2e-5, "{off_m} {off_mps}");
    assert!(largest_m > 0.2, "{largest_m}");
}

#[test]
fn its_cross_sections_tilt_with_the_surface() {
    // 1 dB a degree of elevation.
    let mut table = tempfile::NamedTempFile::new().unwrap();
    writeln!(table, "az_deg,el_deg,rcs_dbsm").unwrap();
    for (az, el) in [-180, 180].iter().flat_map(|az| (-90..=90).map(move |el| (az, el))) {
        writeln!(table, "{az},{el},{el}").unwrap();
    }
    let (mut scene, _) = with(1e-3, Earth::Flat);
    let (from, at) = ([2000.0, 1000.0, 1500.0], [40.0, -30.0, 1.5]);
    let radar = straight(&scene, from, [0.0; 3]);
    let amplitudes = |scene: &Scene| -> Vec<f64> {
        let generator = PathGenerator::new(scene, 1e-6, vec![radar.clone(), radar.clone()]).unwrap();
        let of = |index: u64| {
            let (paths, record) = evaluate(scene, &generator, index);
            let first = paths.delay_s[0].iter().position(|delay_s| *delay_s == record.target_delay_s[0]);
            paths.amplitude[0][first.unwrap()].norm()
        };
        (0..2220).step_by(111).map(of).collect()
    };
    let plain = amplitudes(&scene);
    scene.targets[0].aspect =
        Some(Aspect { path: table.path().to_owned(), heading_rad: Some(1.1), floor_dbsm: -300.0 });
    let tilted = amplitudes(&scene);
    let surface = realise(scene.sea.as_ref().unwrap(), scene.seed).unwrap().surface;
    let (mut off_db, mut level_db) = (0f64, 0f64);
    for (n, (tilted, plain)) in tilted.iter().zip(&plain).enumerate() {
        // The emission, less than 10 us before the scattering, at which nothing has turned.
        let t_s = 0.5 * n as f64;
        let place = [at[0] + 3.0 * t_s, at[1] + 4.0 * t_s];
        let wave = surface.at(place, t_s);
        let towards = [from[0] - place[0], from[1] - place[1], from[2] - at[2] - wave.height_m];
        let up = [-wave.slope[0], -wave.slope[1], 1.0];
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let sine = dot(towards, up) / (dot(towards, towards) * dot(up, up)).sqrt();
        let level = (towards[2] / dot(towards, towards).sqrt()).asin().to_degrees();
        let found_db = 20.0 * (tilted / plain).log10();
        off_db = off_db.max((found_db - sine.asin().to_degrees()).abs());
        level_db = level_db.max((found_db - level).abs());
    }
    println!("off by {off_db:.1e} dB of up to {level_db:.1} dB");
    // Slopes between knots are off by 2e-4 of some 0.1 rad, which is 1e-3 degrees.
    assert!(off_db < 2e-3 && level_db > 2.0, "{off_db} {level_db}");
}

#[test]
fn a_hull_averages_waves_that_are_shorter() {
    let of = |waterline_m: f64| {
        let (scene, generator) = with(waterline_m, Earth::Flat);
        let surface = realise(scene.sea.as_ref().unwrap(), scene.seed).unwrap().surface;
        let (grid, mut variance) = (*surface.grid(), 0.0);
        for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
            for (j, a) in row.iter().enumerate() {
                let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) else { continue };
                let half = 0.5 * waterline_m * TAU / 128.0 * (mx as f64).hypot(my as f64);
                let share = if half < 0.5 * TAU { half.sin() / half } else { 0.0 };
                variance += if half > 0.0 { 2.0 * a.norm_sqr() * share * share } else { 0.0 };
            }
        }
        let heights = (0..2220).step_by(sized(5, 20)).map(|index| height(&scene, &generator, index)[0] - 1.5);
        let heights: Vec<f64> = heights.collect();
        let mean_square = heights.iter().map(|z| z * z).sum::<f64>() / heights.len() as f64;
        (mean_square / variance, variance)
    };
    let ((short, waves), (long, of_hull)) = (of(1e-3), of(30.0));
    println!("time over ensemble: {short:.2} and {long:.2}; variances {waves:.3} and {of_hull:.3} m^2");
    // Ten seconds are some two waves: a chi-square of about four degrees of freedom, within its 99 %.
    assert!([short, long].iter().all(|ratio| (0.05..3.4).contains(ratio)), "{short} {long}");
    assert!(of_hull < 0.7 * waves);
}

#[test]
fn it_follows_the_sea_of_a_curved_earth_and_rests_on_a_flat_one() {
    let curved = Earth::Curved { radius_factor: 1.0 };
    let [(flat_scene, flat), (curved_scene, curved)] = [with(5.0, Earth::Flat), with(5.0, curved)];
    for index in [0, 1000, 2219] {
        let t_s = index as f64 / 222.0;
        let (x_m, y_m) = (40.0 + 3.0 * t_s, -30.0 + 4.0 * t_s);
        let [on_flat, _] = height(&flat_scene, &flat, index);
        let [on_curved, _] = height(&curved_scene, &curved, index);
        let drop = |x: f64, y: f64| curved_scene.frame.earth().drop_m(x, y);
        // Its position was 1.5 m above the plane, not above the sea.
        let fall_m = drop(x_m, y_m) - drop(40.0, -30.0);
        assert!((on_flat - on_curved - fall_m).abs() < 1e-7, "{index}: {on_flat} {on_curved} {fall_m}");
    }
}

/// Weight of the field between the radar and a target at pulse 0, one way, and by the closed form.
fn passes(x_m: f64, height_m: f64, radar_m: f64) -> [f64; 2] {
    let (width_rad, facet_m) = (0.02, 2.0);
    let mut scene = scene();
    scene.sea = Some(sea(64, facet_m, 0.7));
    scene.targets = vec![target([x_m, -30.0, height_m], [3.0, 4.0, 0.0])];
    scene.targets[0].floating = Some(Floating { waterline_m: 1e-3 });
    let low = straight(&scene, [x_m - 1200.0, 1570.0, radar_m], [0.0; 3]);
    let amplitude = |scene: &Scene| {
        let generator = PathGenerator::new(scene, 1e-6, vec![low.clone(), low.clone()]).unwrap();
        let (paths, record) = evaluate(scene, &generator, 0);
        // The target's path comes first, if it is received at all.
        let first = paths.delay_s[0].iter().position(|delay_s| *delay_s == record.target_delay_s[0]);
        first.map_or(0.0, |first| paths.amplitude[0][first].norm())
    };
    let open = amplitude(&scene);
    scene.sea.as_mut().unwrap().shadow =
        Some(Shadowing { width_rad: Some(width_rad), ..Shadowing::default() });
    let found = (amplitude(&scene) / open).sqrt();
    // Brute force: every point of the line of sight, a facet apart.
    let surface = realise(scene.sea.as_ref().unwrap(), scene.seed).unwrap().surface;
    let z_m = height_m + surface.at([x_m, -30.0], 0.0).height_m;
    let mut clearance_m = f64::INFINITY;
    for n in 1..999 {
        let along_m = f64::from(n) * facet_m;
        let crest_m = surface.at([x_m - 0.6 * along_m, -30.0 + 0.8 * along_m], 0.0).height_m;
        let ray_m = radar_m + (crest_m - radar_m) * 2000.0 / (2000.0 - along_m);
        clearance_m = clearance_m.min(z_m - ray_m);
    }
    let s = (clearance_m / (width_rad * facet_m)).clamp(0.0, 1.0);
    [found, s * s * (3.0 - 2.0 * s)]
}

#[test]
fn crests_before_it_hide_it_as_they_hide_facets() {
    let mut seen = [0; 3];
    for n in (0..16).step_by(sized(1, 2)) {
        let [found, exact] = passes(-40.0 + 5.3 * f64::from(n), 0.1, 25.0);
        assert!((found - exact).abs() < 1e-6, "{n}: {found} {exact}");
        seen[if exact < 0.05 {
            0
        } else if exact < 0.95 {
            1
        } else {
            2
        }] += 1;
    }
    println!("hidden, at the edge, seen: {seen:?}");
    assert!(seen[0] > 1 && seen[2] > 1, "{seen:?}");
    // A mast stands above them.
    assert_eq!(passes(-40.0, 20.0, 25.0), [1.0; 2]);
}
