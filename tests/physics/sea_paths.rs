//! The facets of the sea as scatterer paths: one path for delay, phase and Doppler, keys, kinds, shadows,
//! reciprocity.

use std::f64::consts::TAU;

use nereus::motion::PlatformTracks;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::scattering::kind::{Kind, slick::Slick};
use nereus::scene::radar::{Aim, AimFrom, Gate, Pattern, Polarisation};
use nereus::scene::sea::*;
use nereus::scene::ship::{HullGiven, KelvinWake, Ship, TurbulentWake};
use nereus::scene::water::*;
use nereus::scene::{Patch, Scene, Sea};
use nereus::time::PulseTimes;

use super::radar_scenes::{PULSE_S, buffers, channels, evaluate, point, scene, straight, vector};

/// 8 m/s towards `direction_rad`, `n` x `n` facets about the origin.
pub fn sea(n: usize, facet_m: f64, direction_rad: f64) -> Sea {
    let strength = WindStrength::Speed { speed_mps: 8.0, height_m: 10.0 };
    let side_m = n as f64 * facet_m;
    let wind = WindGiven { strength, profile: WindProfile::Cardone, direction_rad };
    let water = Water::new(wind, SpectrumKind::Elfouhaily { development: Development::default() });
    Sea {
        waves: Waves::Linear,
        scattering: FacetScattering {
            tilt_average: false,
            breaking: Breaking::Off,
            modulation: Modulation::Off,
            ..FacetScattering::default()
        },
        ..Sea::new(water, Patch::new([side_m, side_m], facet_m, [0.0, 0.0]).unwrap())
    }
}

/// No targets, the given sea.
fn sea_scene(sea: Sea) -> Scene {
    Scene { sea: Some(sea), targets: Vec::new(), ..scene() }
}

/// Transmitter and receiver on one aircraft that flies past at 45 degrees.
fn side_looking(scene: &Scene) -> Vec<PlatformTracks> {
    let track = straight(scene, [-10.0, -3000.0, 3000.0], [222.0, 0.0, 0.0]);
    vec![track.clone(), track]
}

fn at_rest(scene: &Scene, tx: [f64; 3], rx: [f64; 3]) -> Vec<PlatformTracks> {
    vec![straight(scene, tx, [0.0; 3]), straight(scene, rx, [0.0; 3])]
}

fn paths(scene: &Scene, tracks: &[PlatformTracks], index: u64) -> ScattererPaths {
    let generator = PathGenerator::new(scene, PULSE_S, tracks.to_vec()).unwrap();
    evaluate(scene, &generator, index).0
}

fn power(paths: &ScattererPaths, channel: usize) -> f64 {
    paths.amplitude[channel].iter().map(|a| a.norm_sqr()).sum()
}

#[test]
fn phase_is_smooth_and_its_derivative_is_the_doppler() {
    // 20 kHz, so that a central difference leaves jerk T^2 / 6: 1e-9 m/s of some 1 m/s, and rounding of the
    // delay (3e-21 s over 1e-4 s) 1e-8 of the rate.
    for (displacement, waves) in [(true, Waves::Linear), (false, Waves::Linear), (true, Waves::Choppy)] {
        let mut water = sea(16, 1.0, 0.5);
        water.scattering.displacement = displacement;
        water.waves = waves;
        // Lines that travel fade, and turn fast where they do.
        water.scattering.bragg = BraggWaves::Frozen;
        let mut scene = sea_scene(water);
        scene.radar.emissions = PulseTimes::uniform(20e3).unwrap();
        scene.radar.window =
            nereus::scene::radar::Window { samples: 1000, gate: Gate::Fixed { start_s: 25e-6 } };
        let tracks = side_looking(&scene);
        let generator = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
        let mut worst = 0f64;
        for middle in [1, 100, 400, 498] {
            let [before, now, after] =
                [middle - 1, middle, middle + 1].map(|k| evaluate(&scene, &generator, k).0);
            assert_eq!((before.len(), now.len(), after.len()), (256, 256, 256));
            for i in 0..now.len() {
                let slope = (after.delay_s[0][i] - before.delay_s[0][i]) * 20e3 / 2.0;
                // Relative to the Doppler of 1 m/s: side-looking facets may have none at all.
                worst = worst.max((slope - now.delay_rate[0][i]).abs() / (2.0 / 299_792_458.0));
                // Nothing jumps: amplitudes change by less than slopes do in 50 us.
                let (a, b) = (before.amplitude[0][i], now.amplitude[0][i]);
                assert!((a - b).norm() < 0.01 * a.norm(), "facet {i}");
            }
        }
        println!(
            "displacement {displacement}, {waves:?}: finite difference against rate {worst:.1e} of 1 m/s"
        );
        assert!(worst <= 1e-6);
    }
}

#[test]
fn orbital_motion_carries_the_radial_velocity_of_waves() {
    // At 45 degrees, looking along the waves, the radial velocity of a deep-water wave has the amplitude w a
    // in full; with the horizontal part frozen only cos 45 of it is left.
    let rms = |displacement: bool| {
        let mut water = sea(64, 4.0, TAU / 4.0);
        water.scattering.displacement = displacement;
        let scene = sea_scene(water);
        let tracks = at_rest(&scene, [0.0, -30_000.0, 30_000.0], [0.0, -30_000.0, 30_000.0]);
        let list = paths(&scene, &tracks, 100);
        let sum: f64 = list.delay_rate[0].iter().map(|r| (r * 299_792_458.0 / 2.0).powi(2)).sum();
        (sum / list.len() as f64).sqrt()
    };
    let (full, frozen) = (rms(true), rms(false));
    println!("radial velocity rms {full:.3} m/s, horizontal part frozen {frozen:.3} m/s");
    // The sea is not long-crested: part of the energy travels across.
    assert!((1.25..1.45).contains(&(full / frozen)));
}

#[test]
fn doppler_centroid_distinguishes_approaching_from_receding_waves() {
    // Facets that face the radar return more. On waves that approach, these rise and close in.
    let centroid_hz = |direction_rad: f64| {
        let mut sum = [0.0; 2];
        for seed in 1..=6 {
            let mut scene = sea_scene(sea(64, 2.0, direction_rad));
            scene.seed = seed;
            let place = [0.0, -3000.0, 3000.0];
            let tracks = at_rest(&scene, place, place);
            for pulse in [0, 250] {
                let list = paths(&scene, &tracks, pulse);
                for (r, a) in list.delay_rate[0].iter().zip(&list.amplitude[3]) {
                    sum[0] -= 10e9 * r * a.norm_sqr();
                    sum[1] += a.norm_sqr();
                }
            }
        }
        sum[0] / sum[1]
    };
    let (approaching, receding) = (centroid_hz(-TAU / 4.0), centroid_hz(TAU / 4.0));
    println!("VV centroid {approaching:.1} Hz approaching, {receding:.1} Hz receding");
    assert!(approaching > 2.0 && receding < -2.0);
}

/// A Wigley hull of 20 m at 4 m/s along +x, midship at a place at pulse 0.
fn launch(position_m: [f64; 2]) -> Ship {
    Ship {
        name: "launch".into(),
        hull: HullGiven::Wigley { beam_m: 3.0, draught_m: 1.2 },
        length_m: Some(20.0),
        position_m,
        heading_rad: 0.0,
        speed_mps: 4.0,
        kelvin: Some(KelvinWake::default()),
        turbulent: Some(TurbulentWake::default()),
        echo: false,
        mesh: Default::default(),
        trajectory: None,
        panels: Default::default(),
    }
}

#[test]
fn a_wake_moves_facets_along_one_path_too() {
    // Waves of the ship on calm water: under its bow, astern of it, and where its wake ends (30 to 40 lengths
    // astern).
    for ahead_m in [0.0, 40.0, 700.0] {
        let mut water = sea(16, 1.0, 0.0);
        water.water.wind.strength = WindStrength::Speed { speed_mps: 3.0, height_m: 10.0 };
        let mut scene = sea_scene(water);
        scene.radar.emissions = PulseTimes::uniform(20e3).unwrap();
        scene.radar.window =
            nereus::scene::radar::Window { samples: 1000, gate: Gate::Fixed { start_s: 25e-6 } };
        let calm =
            evaluate(&scene, &PathGenerator::new(&scene, PULSE_S, side_looking(&scene)).unwrap(), 100).0;
        scene.ships = vec![launch([ahead_m, 0.0])];
        let generator = PathGenerator::new(&scene, PULSE_S, side_looking(&scene)).unwrap();
        let [before, now, after] = [99, 100, 101].map(|k| evaluate(&scene, &generator, k).0);
        let (mut worst, mut lifted) = (0f64, 0f64);
        assert_eq!((now.len(), calm.len()), (256, 256));
        for i in 0..256 {
            let slope = (after.delay_s[0][i] - before.delay_s[0][i]) * 20e3 / 2.0;
            worst = worst.max((slope - now.delay_rate[0][i]).abs() / (2.0 / 299_792_458.0));
        }
        // The facets may stand in another order, for the strip is a kind of its own.
        let mean = |list: &ScattererPaths| list.delay_rate[0].iter().map(|r| r.powi(2)).sum::<f64>();
        lifted = lifted.max((mean(&now) / mean(&calm) - 1.0).abs());
        println!(
            "ship {ahead_m} m ahead: finite difference against rate {worst:.1e} of 1 m/s, motion changed by {lifted:.2e}"
        );
        assert!(worst <= 1e-6 && lifted > 1e-6);
    }
}

#[test]
fn a_patch_may_leave_a_ship_behind() {
    let mut water = sea(32, 2.0, 0.3);
    let aim = Aim::Point { position: point([0.0; 3]), velocity: vector([2000.0, 500.0, 0.0]) };
    water.place = PatchPlace::Follow { aim, aim_from: AimFrom::True };
    water.shadow = Some(Shadowing::default());
    let mut scene = sea_scene(water);
    // 4.5 km in 2.2 s: past the end of the wake of one ship, past another.
    scene.ships = vec![launch([30.0, 0.0]), launch([2500.0, 700.0])];
    let tracks = at_rest(&scene, [0.0, -3000.0, 3000.0], [0.0, -3000.0, 3000.0]);
    let generator = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
    for k in (0..500).step_by(7) {
        let list = evaluate(&scene, &generator, k).0;
        assert!(list.delay_s[0].iter().all(|d| d.is_finite()), "pulse {k}");
    }
}

#[test]
fn a_pulse_depends_on_nothing_made_before() {
    let mut water = sea(32, 1.0, 0.3);
    water.shadow = Some(Shadowing { update_s: 0.007, ..Shadowing::default() });
    water.scattering.decorrelation_s = Some(0.01);
    let aim = Aim::Point { position: point([0.0; 3]), velocity: vector([222.0, 30.0, 0.0]) };
    water.place = PatchPlace::Follow { aim, aim_from: AimFrom::True };
    let scene = sea_scene(water);
    let tracks = at_rest(&scene, [0.0, -2000.0, 15.0], [0.0, -3000.0, 3000.0]);
    let generator = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
    let mut workspace = generator.workspace();
    let (mut list, mut record) = buffers(&scene);
    for k in [3, 5, 100, 4, 5, 6, 499, 7] {
        generator.pulse(k, &mut workspace, &mut list, &mut record).unwrap();
        let (alone, _) = evaluate(&scene, &generator, k);
        assert!(list == alone && !list.is_empty(), "pulse {k}");
    }
}

#[test]
fn a_facet_is_the_same_through_any_patch() {
    let fixed = sea(32, 1.0, 0.3);
    let mut moving = fixed.clone();
    let aim = Aim::Point { position: point([0.0; 3]), velocity: vector([444.0, -222.0, 0.0]) };
    moving.place = PatchPlace::Follow { aim, aim_from: AimFrom::True };
    let (still, moving) = (sea_scene(fixed), sea_scene(moving));
    let tracks = side_looking(&still);
    for pulse in [0, 3, 7, 13] {
        let (here, there) = (paths(&still, &tracks, pulse), paths(&moving, &tracks, pulse));
        assert_eq!((here.len(), there.len()), (1024, 1024));
        // Rows and columns by which the moving patch has gone, two along x and one along y per pulse; it is
        // held for 16 facets at 496 m/s, 7 pulses, of which 6 have more divisors.
        let gone = pulse as usize / 6 * 6;
        let mut shared = 0;
        for (i, delay) in there.delay_s[0].iter().enumerate() {
            if let Some(j) = here.delay_s[0].iter().position(|d| d == delay) {
                // Receive axes are interpolated over the longest delay of the run, which is that of the
                // patch: rounding, of which cross-polarised channels keep more because their parts nearly
                // cancel.
                for (a, b) in here.amplitude.iter().zip(&there.amplitude) {
                    let apart = (a[j] - b[i]).norm() / a[j].norm();
                    assert!(apart <= 1e-11, "{apart:e}");
                }
                shared += 1;
            }
        }
        assert_eq!(shared, (32 - 2 * gone) * (32 - gone), "pulse {pulse}");
    }
}

#[test]
fn ends_can_be_swapped() {
    let (a, b) = ([-500.0, -2500.0, 1800.0], [1500.0, -1000.0, 2600.0]);
    let mut water = sea(16, 1.0, 0.3);
    water.shadow = Some(Shadowing::default());
    let scene = sea_scene(water);
    let there = paths(&scene, &at_rest(&scene, a, b), 7);
    let back = paths(&scene, &at_rest(&scene, b, a), 7);
    assert_eq!(there.len(), back.len());
    // HH, HV, VH, VV: the ports change places with the ends.
    for (channel, swapped) in [(0, 0), (1, 2), (2, 1), (3, 3)] {
        let rms = (power(&there, channel) / there.len() as f64).sqrt();
        for i in 0..there.len() {
            let difference = (there.amplitude[channel][i] - back.amplitude[swapped][i]).norm();
            // While the pulse is under way the water moves by 1e-5 m, which turns directions by 1e-8 rad.
            assert!(difference < 1e-6 * rms, "channel {channel} facet {i}: {difference:e} of {rms:e}");
        }
    }
}

#[test]
fn a_slick_darkens_what_it_covers_and_nothing_else() {
    let clean = sea(32, 1.0, 0.3);
    let mut oiled = clean.clone();
    oiled.slicks.push(SlickRegion {
        name: "oil".into(),
        shape: SlickShape::Ellipse { centre_m: [8.0, 0.0], half_axes_m: [6.0, 12.0], direction_rad: 0.0 },
        rim_m: 0.01,
        cover: 1.0,
        elasticity_npm: 0.0255,
    });
    let (clean, oiled) = (sea_scene(clean), sea_scene(oiled));
    let tracks = side_looking(&clean);
    let (clean, oiled) = (paths(&clean, &tracks, 0), paths(&oiled, &tracks, 0));
    let (mut same, mut covered, mut bare) = (0, 0.0, 0.0);
    for (i, delay) in oiled.delay_s[0].iter().enumerate() {
        let j = clean.delay_s[0].iter().position(|d| d == delay).unwrap();
        if oiled.amplitude[3][i] == clean.amplitude[3][j] {
            same += 1;
        } else {
            covered += oiled.amplitude[3][i].norm_sqr();
            bare += clean.amplitude[3][j].norm_sqr();
        }
    }
    // The ellipse is pi 6 12 = 226 of 1024 facets.
    assert!((1024 - 240..1024 - 210).contains(&same), "{same} facets as before");
    let contrast_db = 10.0 * f64::log10(covered / bare);
    // At 45 degrees nearly all is Bragg scattering, at 2 k sin 45 but for the tilts of the waves.
    let bragg_radpm = 2.0 * TAU / 0.029_979 * 0.5f64.sqrt();
    let film_db = 10.0 * Slick::default().spectrum_factor(bragg_radpm).log10();
    println!("VV contrast of the slick at 45 deg {contrast_db:.1} dB, of its film {film_db:.1} dB");
    assert!((film_db - 1.0..film_db + 1.0).contains(&contrast_db));
}

#[test]
fn shadows_cost_nothing_where_there_are_none_and_darken_at_grazing() {
    let open = sea(64, 1.0, TAU / 4.0);
    let mut shaded = open.clone();
    shaded.shadow = Some(Shadowing::default());
    let (open, shaded) = (sea_scene(open), sea_scene(shaded));
    let high = side_looking(&open);
    assert_eq!(paths(&open, &high, 5), paths(&shaded, &high, 5));
    let low = at_rest(&open, [0.0, -1000.0, 15.0], [0.0, -3000.0, 3000.0]);
    let (illuminated, dark) = (paths(&open, &low, 5), paths(&shaded, &low, 5));
    let share = power(&dark, 3) / power(&illuminated, 3);
    println!("a radar at 15 m sees {:.2} of the power", share);
    assert!(dark.len() < illuminated.len() && (0.05..0.95).contains(&share));
}

#[test]
fn shadows_fade_linearly_between_updates() {
    let mut water = sea(32, 1.0, TAU / 4.0);
    let mut scene = sea_scene(water.clone());
    water.shadow = Some(Shadowing { update_s: 0.02, ..Shadowing::default() });
    let mut shaded = sea_scene(water);
    for scene in [&mut scene, &mut shaded] {
        scene.radar.channels = channels(&[(Polarisation::V, Polarisation::V)]);
        // 1 kHz: an update every 20 pulses.
        scene.radar.emissions = PulseTimes::uniform(1000.0).unwrap();
    }
    let tracks = at_rest(&scene, [0.0, -1000.0, 10.0], [0.0, -1000.0, 10.0]);
    let open = PathGenerator::new(&scene, PULSE_S, tracks.clone()).unwrap();
    let shaded = PathGenerator::new(&shaded, PULSE_S, tracks).unwrap();
    // One-way weights of the facets that face the radar: what the shadow leaves of an amplitude is their
    // square.
    let weights = |pulse| {
        let amplitudes = |light: &PathGenerator| {
            light.snapshot(pulse, &mut light.workspace()).unwrap().unwrap().amplitude.remove(0)
        };
        let (open, shaded) = (amplitudes(&open), amplitudes(&shaded));
        open.iter().zip(shaded).map(|(a, b)| (b.norm() / a.norm()).sqrt()).collect::<Vec<f64>>()
    };
    let [first, middle, last, next] = [40, 50, 60, 70].map(weights);
    let (mut bent, mut moved) = (0f64, 0f64);
    for facet in 0..1024 {
        let four = [first[facet], middle[facet], last[facet], next[facet]];
        if four.iter().any(|w| !w.is_finite()) {
            continue;
        }
        let straight = 0.5 * (first[facet] + last[facet]);
        // A square root near zero loses half the digits.
        assert!((middle[facet] - straight).abs() < 1e-7, "facet {facet}: {four:?}");
        moved = moved.max((last[facet] - first[facet]).abs());
        bent = bent.max((last[facet] - 0.5 * (middle[facet] + next[facet])).abs());
    }
    println!("weights move by up to {moved:.3} in 20 ms; they bend at an update by up to {bent:.3}");
    assert!(moved > 0.05 && bent > 0.005);
}

#[test]
fn calm_water_is_a_mirror() {
    let mut water = sea(16, 1.0, 0.0);
    water.water.wind.strength = WindStrength::Speed { speed_mps: 0.0, height_m: 10.0 };
    let scene = sea_scene(water);
    // Nothing comes back at 45 degrees ...
    assert!(paths(&scene, &side_looking(&scene), 0).is_empty());
    // ... and all comes back from below.
    let above = [0.0, 0.0, 500.0];
    let glint = paths(&scene, &at_rest(&scene, above, above), 0);
    assert!(!glint.is_empty());
    assert!(glint.amplitude.iter().flatten().all(|a| a.is_finite()));
}

#[test]
fn a_curved_earth_lowers_the_far_sea() {
    use nereus::frames::{Earth, SceneFrame};
    let far = [40_000.0, -30_000.0];
    let mut water = sea(8, 1.0, 0.3);
    water.patch = Patch::new([8.0, 8.0], 1.0, far).unwrap();
    let mut flat = sea_scene(water);
    let place = [far[0], far[1] - 3000.0, 3000.0];
    let tracks = at_rest(&flat, place, place);
    let on_plane = paths(&flat, &tracks, 0);
    flat.frame = SceneFrame::plain(Earth::Curved { radius_factor: 4.0 / 3.0 });
    let on_sphere = paths(&flat, &tracks, 0);
    let drop_m = 50_000f64.powi(2) / (2.0 * 4.0 / 3.0 * 6_371_000.0);
    let later_s = on_sphere.delay_s[0][0] - on_plane.delay_s[0][0];
    let expected_s = 2.0 * (3000f64.hypot(3000.0 + drop_m) - 3000f64.hypot(3000.0)) / 299_792_458.0;
    // The facet asked lies up to 6 m from the middle, where the path changes by 4 parts in a thousand of the
    // difference.
    assert!((later_s / expected_s - 1.0).abs() < 5e-3, "{later_s:e} for {expected_s:e}");
}

#[test]
fn a_curved_earth_tilts_the_far_sea_outward() {
    use nereus::frames::{Earth, SceneFrame};
    // Calm water 40 km East of the origin leans to the East by 40/8494 = 4.7 mrad, which its glint (rms slope
    // 3.2 mrad) shows: seen from above, from where it leans to, from where it leans from.
    let mut water = sea(1, 1.0, 0.0);
    water.water.wind.strength = WindStrength::Speed { speed_mps: 0.0, height_m: 10.0 };
    water.patch = Patch::new([1.0, 1.0], 1.0, [40_000.0, 0.0]).unwrap();
    let mut scene = sea_scene(water);
    scene.frame = SceneFrame::plain(Earth::Curved { radius_factor: 4.0 / 3.0 });
    let lean = 40_000.0 / (4.0 / 3.0 * 6_371_000.0);
    let glint = |tangent: f64| {
        let place = [40_000.0 + 2000.0 * tangent, 0.0, 2000.0 - 0.5 * 40_000.0 * lean];
        power(&paths(&scene, &at_rest(&scene, place, place), 0), 3)
    };
    let (along, above, away) = (glint(lean), glint(0.0), glint(-lean));
    // Monostatic: p(s) with s the slope that would reflect straight back.
    let expected = |s: f64| (-s * s / (2.0 * 1e-5)).exp();
    println!(
        "glint along the normal 1, from above {:.3}, from the other side {:.4}",
        above / along,
        away / along
    );
    // Range and angle of incidence change by 1e-5.
    assert!((above / along / expected(lean) - 1.0).abs() < 1e-3);
    assert!((away / along / expected(2.0 * lean) - 1.0).abs() < 1e-3);
}

#[test]
fn several_pulses_of_the_sea_in_the_air() {
    // From 600 km the echo comes back 4.0 ms later: at 2 kHz eight pulses are under way.
    let mut scene = sea_scene(sea(8, 2.0, 0.3));
    scene.radar.emissions = PulseTimes::uniform(2000.0).unwrap();
    for mount in [&mut scene.radar.transmitters[0].antenna, &mut scene.radar.receivers[0].antenna] {
        mount.pattern = Pattern::Isotropic { gain_dbi: 40.0 };
    }
    let place = [0.0, -300_000.0, 520_000.0];
    let tracks =
        vec![straight(&scene, place, [7500.0, 0.0, 0.0]), straight(&scene, place, [7500.0, 0.0, 0.0])];
    scene.radar.window = nereus::scene::radar::Window { samples: 50_000, gate: Gate::Fixed { start_s: 0.0 } };
    let list = paths(&scene, &tracks, 100);
    assert_eq!(list.len(), 64);
    assert!(
        list.emission_offset_s.iter().all(|o| (o + 0.004).abs() < 1e-9),
        "{:?}",
        list.emission_offset_s[0]
    );
}
