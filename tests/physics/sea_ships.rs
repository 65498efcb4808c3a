//! Ships in the echo at the ends of what is legal, and the narrow V of their short waves.

use nereus::cpu::Variant;
use nereus::geometry::lanes::LANES;
use nereus::motion::PlatformTracks;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::scattering::water::{Sight, WaterScattering};
use nereus::scene::Scene;
use nereus::scene::radar::{Aim, AimFrom};
use nereus::scene::sea::{PatchPlace, Shadowing};
use nereus::scene::ship::{HullGiven, KelvinWake, Ship, TurbulentWake};
use nereus::sea::fleet;
use nereus::sea::realise::realise;
use proptest::prelude::*;

use crate::cases::sized;

use super::radar_scenes::{PULSE_S, evaluate, point, scene, straight, vector};
use super::sea_paths::sea;

/// A Wigley hull of the usual proportions along +x, with all that ships have.
fn ship(length_m: f64, speed_mps: f64, position_m: [f64; 2]) -> Ship {
    Ship {
        name: "ship".into(),
        hull: HullGiven::Wigley { beam_m: 0.13 * length_m, draught_m: 0.05 * length_m },
        length_m: Some(length_m),
        position_m,
        heading_rad: 0.0,
        speed_mps,
        kelvin: Some(KelvinWake { short_waves: true, ..KelvinWake::default() }),
        turbulent: Some(TurbulentWake::default()),
        echo: false,
        mesh: Default::default(),
        trajectory: None,
        panels: Default::default(),
    }
}

/// 16 x 16 facets at 1.3 GHz, ships among them.
fn with_ships(facet_m: f64, ships: Vec<Ship>) -> Scene {
    let mut scene = Scene { sea: Some(sea(16, facet_m, 0.3)), targets: Vec::new(), ships, ..scene() };
    scene.radar.carrier_hz = 1.3e9;
    scene
}

fn abeam(scene: &Scene) -> Vec<PlatformTracks> {
    let track = straight(scene, [0.0, -3000.0, 3000.0], [50.0, 0.0, 0.0]);
    vec![track.clone(), track]
}

fn paths_from(scene: &Scene, tracks: Vec<PlatformTracks>, index: u64) -> ScattererPaths {
    let generator = PathGenerator::new(scene, PULSE_S, tracks).unwrap();
    let list = evaluate(scene, &generator, index).0;
    let finite = |column: &Vec<f64>| column.iter().all(|value| value.is_finite());
    assert!(list.delay_s.iter().all(finite) && list.delay_rate.iter().all(finite));
    assert!(list.amplitude.iter().flatten().all(|a| a.re.is_finite() && a.im.is_finite()));
    list
}

fn paths(scene: &Scene) -> ScattererPaths {
    paths_from(scene, abeam(scene), 3)
}

#[test]
fn a_ship_without_way_changes_nothing() {
    let empty = paths(&with_ships(1.0, Vec::new()));
    assert!(!empty.is_empty());
    for speed_mps in [0.0, f64::MIN_POSITIVE, 1e-9, 0.0999] {
        let still = paths(&with_ships(1.0, vec![ship(20.0, speed_mps, [12.0, 0.0])]));
        assert!(still == empty, "{speed_mps} m/s");
    }
    // Nor does one that is yet to come, one whose waves have faded (its strip is still there then), and one
    // that passes far off.
    for place_m in [[-500.0, 0.0], [20.0 * 42.0, 0.0], [12.0, 2000.0]] {
        let turbulent = Some(TurbulentWake::default()).filter(|_| place_m[0] < 100.0);
        let away = paths(&with_ships(1.0, vec![Ship { turbulent, ..ship(20.0, 6.0, place_m) }]));
        assert_eq!(away.delay_s, empty.delay_s, "{place_m:?}");
        // Where ships have short waves other code asks for the spectrum: a rounding or two are left.
        for (a, b) in away.amplitude.iter().zip(&empty.amplitude) {
            let level = b.iter().map(|b| b.norm()).fold(0.0, f64::max);
            let worst = a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(worst < 1e-14 * level, "{place_m:?}: {worst:e} of {level:e}");
        }
    }
    assert!(paths(&with_ships(1.0, vec![ship(20.0, 6.0, [40.0, 0.0])])) != empty);
}

#[test]
fn tiny_and_huge_ships_slow_and_fast_ones() {
    for (a, length_m) in [0.05, 1.0, 1000.0].into_iter().enumerate() {
        for (b, speed_mps) in [0.1, 0.5, 5.0, 100.0].into_iter().enumerate() {
            for (c, facet_m) in [0.1, 1.0, 30.0].into_iter().enumerate() {
                // Every pair of two of them, where there are to be fewer cases.
                if sized(false, (a + b + c) % 3 != 0) {
                    continue;
                }
                let astern_m = 0.5 * length_m + 4.0 * facet_m;
                paths(&with_ships(facet_m, vec![ship(length_m, speed_mps, [astern_m, 0.3])]));
            }
        }
    }
}

#[test]
fn a_ship_under_the_radar_and_crossing_ships() {
    let mut scene = with_ships(1.0, vec![ship(20.0, 5.0, [0.0, 0.0])]);
    let overhead = straight(&scene, [0.0, 0.0, 3000.0], [0.0; 3]);
    let below = paths_from(&scene, vec![overhead.clone(), overhead], 0);
    assert!(!below.is_empty());
    // Five ships through one point, two of them one and the same.
    scene.ships = [0.0, 1.3, 2.6, 3.9, 3.9]
        .into_iter()
        .enumerate()
        .map(|(n, heading_rad)| {
            let place_m = [25.0 * f64::cos(heading_rad), 25.0 * f64::sin(heading_rad)];
            Ship { name: format!("ship-{n}"), heading_rad, ..ship(30.0, 5.0, place_m) }
        })
        .collect();
    assert!(!paths(&scene).is_empty());
}

#[test]
fn a_following_patch_meets_ships() {
    let mut scene = with_ships(2.0, vec![ship(20.0, 6.0, [400.0, 0.0]), ship(20.0, 6.0, [2200.0, 30.0])]);
    let Some(sea) = &mut scene.sea else { panic!("a sea") };
    let aim = Aim::Point { position: point([0.0; 3]), velocity: vector([1500.0, 0.0, 0.0]) };
    sea.place = PatchPlace::Follow { aim, aim_from: AimFrom::True };
    sea.shadow = Some(Shadowing::default());
    let generator = PathGenerator::new(&scene, PULSE_S, abeam(&scene)).unwrap();
    let calm = Scene { ships: Vec::new(), ..scene.clone() };
    let without = PathGenerator::new(&calm, PULSE_S, abeam(&calm)).unwrap();
    let mut changed = 0;
    for index in (0..490).step_by(14) {
        let (a, b) = (evaluate(&scene, &generator, index).0, evaluate(&calm, &without, index).0);
        assert!(a.delay_s[0].iter().all(|delay_s| delay_s.is_finite()));
        changed += usize::from(a.delay_s != b.delay_s);
    }
    println!("ships change {changed} of 35 pulses");
    // The first wake is under the patch until that has overtaken the ship by its own half length; ahead of
    // that there is none.
    assert!((5..35).contains(&changed));
}

#[test]
fn short_waves_brighten_a_narrow_v() {
    // A ship of 100 m at 9 m/s, 300 m ahead of facets of 1 m: its waves of 20 rad/m run within a few metres
    // of the rays.
    let scene = with_ships(1.0, vec![ship(100.0, 9.0, [300.0, 0.0])]);
    let Some(sea) = &scene.sea else { panic!("a sea") };
    let realised = realise(sea, scene.seed).unwrap();
    let carrier_hz = scene.radar.carrier_hz;
    let short_waves = fleet::short_waves(&scene.ships, 1.0, 60.0).unwrap();
    let sight = Sight { carrier_hz, seed: 1 };
    let water = WaterScattering::new(sea, &realised.wind, realised.spectrum, &[], sight)
        .unwrap()
        .with_short_waves(short_waves);
    let mut poses = Vec::new();
    water.poses(0.0, &mut poses);
    let k0 = nereus::sea::GRAVITY_MPS2 / 81.0;
    let t = (20.0 / k0 - 1.0f64).sqrt();
    let k = [k0 * t.hypot(1.0), k0 * t * t.hypot(1.0)];
    // Sailing East, to port is North; the waves of K run to port on the rays of bow and stern.
    let c = t / (1.0 + 2.0 * t * t);
    let rays_m = [250.0 * c, 350.0 * c];
    let psi = |y_m: f64, k: [f64; 2]| water.short_wave_psi_m4([0.0, y_m], k, &poses);
    let on_rays = rays_m.map(|y_m| psi(y_m, k)).into_iter().fold(0.0, f64::max);
    assert!(on_rays > 1e-10);
    // Fresnel width of 0.6 m: nothing 25 m aside; the mirrored wave on the other side; the same wave seen
    // from behind.
    assert_eq!(psi(rays_m[1] + 25.0, k), 0.0);
    // On the other side run waves of (kx, -ky), whose negative is 2 kx = 3.1 rad/m from K, 1.8 deviations of
    // a facet: exp(-1.6).
    assert!(psi(-rays_m[1], k) < 0.3 * psi(rays_m[1], k));
    assert_eq!(psi(-rays_m[0], [k[0], -k[1]]), psi(rays_m[0], k));
    assert_eq!(psi(rays_m[0], [-k[0], -k[1]]), psi(rays_m[0], k));
    // Turning the whole scene by a right angle turns the V.
    let turned = Ship { heading_rad: 90f64.to_radians(), position_m: [0.0, 300.0], ..scene.ships[0].clone() };
    let other = fleet::short_waves(&[turned], 1.0, 60.0).unwrap().remove(0);
    let pose = other.course().pose(0.0);
    let place = pose.astern_starboard_m([-rays_m[0], 0.0]);
    assert!((other.psi_m4(place, k) / psi(rays_m[0], k) - 1.0).abs() < 1e-9);
}

#[test]
fn facets_get_the_spectrum_of_the_short_waves() {
    // Light wind, so that the waves of the ship stand out. Facets are evaluated from South, across the track:
    // Bragg waves of 2 k sin 45 deg = 38.5 rad/m run North and South.
    let mut scene = with_ships(1.0, vec![Ship { turbulent: None, ..ship(100.0, 9.0, [300.0, 0.0]) }]);
    let bright = paths(&scene);
    scene.ships[0].kelvin = Some(KelvinWake::default());
    let plain = paths(&scene);
    assert_eq!((bright.len(), &bright.delay_s), (plain.len(), &plain.delay_s));
    let power = |list: &ScattererPaths, i: usize| list.amplitude[0][i].norm_sqr();
    let gains_db: Vec<f64> =
        (0..bright.len()).map(|i| 10.0 * (power(&bright, i) / power(&plain, i)).log10()).collect();
    let greatest_db = gains_db.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let raised = gains_db.iter().filter(|db| db.abs() > 0.1).count();
    println!("greatest {greatest_db:.1} dB, {raised} of {} facets", bright.len());
    // t = 17.8 for 38.5 rad/m: rays 7 m (stern) to 10 m (bow) off the track, at the edge of 16 x 16 facets;
    // in between and inside of it longer and shorter waves lie.
    assert!(greatest_db > 10.0 && raised > 10 && raised < bright.len());
}

/// The fast echo's facets side by side, on the axes of the wind, against one facet at a time.
#[test]
fn facets_side_by_side_get_it_too() {
    let mut scene = with_ships(1.0, vec![ship(100.0, 9.0, [300.0, 0.0])]);
    scene.ships.push(Ship { heading_rad: 2.0, ..ship(60.0, 7.0, [-40.0, 150.0]) });
    let Some(sea) = &scene.sea else { panic!("a sea") };
    let realised = realise(sea, scene.seed).unwrap();
    let short_waves = fleet::short_waves(&scene.ships, 1.0, 60.0).unwrap();
    let sight = Sight { carrier_hz: 1.3e9, seed: 1 };
    let water = WaterScattering::new(sea, &realised.wind, realised.spectrum, &[], sight)
        .unwrap()
        .with_short_waves(short_waves);
    let mut poses = Vec::new();
    water.poses(3.0, &mut poses);
    let [cos, sin] = [realised.wind.direction_rad.cos(), realised.wind.direction_rad.sin()];
    let (mut seen, mut dark) = (0, 0);
    let mut errors = Vec::new();
    for tile in 0..64 {
        let [x0, y0] = [f64::from(16 * (tile % 8)) - 64.0, f64::from(16 * (tile / 8)) - 64.0];
        let place = |i: usize| [x0 + (i % 16) as f64, y0 + (i / 16) as f64];
        let (mut places_m, mut bragg) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        for i in 0..LANES {
            [places_m[0][i], places_m[1][i]] = place(i);
            // To and fro about 38.5 rad/m from the South.
            let k = [5.0 * (i as f64).sin(), 38.5 + 5.0 * (3.0 * i as f64).cos()];
            bragg[0][i] = (cos * k[0] + sin * k[1]) as f32;
            bragg[1][i] = (cos * k[1] - sin * k[0]) as f32;
        }
        let bounds_m = [[x0, x0 + 15.0], [y0, y0 + 15.0]];
        let mut found = [0.0; LANES];
        let any = water.beside_lanes(
            Variant::fastest(),
            (&places_m, bounds_m),
            &poses,
            (LANES, &bragg),
            &mut found,
        );
        for i in 0..LANES {
            let [along, across] = [bragg[0][i], bragg[1][i]].map(f64::from);
            let k = [cos * along - sin * across, sin * along + cos * across];
            let exact = water.short_wave_psi_m4(place(i), k, &poses);
            assert!(any || (exact == 0.0 && found[i] == 0.0));
            errors.push([exact.sqrt(), f64::from(found[i]).sqrt()]);
        }
        *(if any { &mut seen } else { &mut dark }) += 1;
    }
    let largest = errors.iter().fold(0.0f64, |most, [exact, _]| most.max(*exact));
    let worst = errors.iter().fold(0.0f64, |most, [exact, found]| most.max((exact - found).abs()));
    println!("{seen} tiles are asked, {dark} are not; worst {:.1e} of {largest:.1e}", worst / largest);
    assert!(seen > 8 && dark > 8 && worst < 1e-3 * largest);
}

proptest! {
    #![proptest_config(crate::cases::proptests(48))]

    #[test]
    fn short_waves_of_any_ship_are_finite(
        length in -1.3..3.0f64,
        speed in -1.0..2.0f64,
        facet in -2.0..3.0f64,
        place in [-1.0..45.0f64, -1.0..1.0f64],
        wave in [-3.0..3.5f64, 0.0..6.3f64],
    ) {
        let length_m = 10f64.powf(length).max(0.05);
        let ship = ship(length_m, 10f64.powf(speed), [0.0, 0.0]);
        let k_radpm = 10f64.powf(wave[0]);
        let found = fleet::short_waves(&[ship], 10f64.powf(facet), 500.0).unwrap();
        for waves in found {
            let x_m = place[0] * length_m;
            let psi = waves.psi_m4([x_m, 0.36 * place[1] * x_m], [k_radpm * wave[1].cos(), k_radpm * wave[1].sin()]);
            prop_assert!(psi.is_finite() && psi >= 0.0, "{psi}");
        }
    }
}
