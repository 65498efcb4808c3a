//! Panels of ships through the path generator, against closed forms and against each other.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use nereus::frames::{Earth, SceneFrame};
use nereus::motion::PlatformTracks;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::pulse::flags;
use nereus::scene::mesh::{Triangle, divided};
use nereus::scene::radar::Pattern;
use nereus::scene::sea::Shadowing;
use nereus::scene::ship::{HullForm, HullGiven, ShipMesh, ShipMotion};
use nereus::scene::{Scene, Ship};
use nereus::sea::realise::realise;
use nereus::time::PulseTimes;
use num_complex::Complex64;

use crate::radar_scenes::{PULSE_S, buffers, channels, evaluate, pulse, scene, straight};
use crate::sea_paths::sea;

const EARTH: Earth = Earth::Curved { radius_factor: 4.0 / 3.0 };

/// A ship at rest, whose bow points at a bearing from +x.
fn ship(panels: Vec<Triangle>, position_m: [f64; 2], heading_rad: f64) -> Ship {
    Ship {
        name: "body".to_owned(),
        hull: HullGiven::Wigley { beam_m: 1.0, draught_m: 1.0 },
        length_m: None,
        position_m,
        heading_rad,
        speed_mps: 0.0,
        kelvin: None,
        turbulent: None,
        echo: false,
        mesh: Default::default(),
        trajectory: None,
        panels: panels.into(),
    }
}

/// A rectangle of sides `u` and `v` at a corner.
fn wall(at: DVec3, u: DVec3, v: DVec3, panel_m: f64) -> Vec<Triangle> {
    divided(vec![[at, at + u, at + u + v], [at, at + u + v, at + v]], panel_m).unwrap()
}

/// A scene of one ship and its radar, both antennas at a place.
fn monostatic(frame: SceneFrame, ship: Ship, place: [f64; 3]) -> (Scene, Vec<PlatformTracks>) {
    let scene = Scene { frame, targets: Vec::new(), ships: vec![ship], ..scene() };
    let track = straight(&scene, place, [0.0; 3]);
    (scene, vec![track.clone(), track])
}

/// The sum of all paths in the first channel.
fn sum(scene: &Scene, paths: &ScattererPaths) -> Complex64 {
    let carried =
        |(a, delay_s): (&Complex64, &f64)| a * Complex64::cis(-TAU * scene.radar.carrier_hz * delay_s);
    paths.amplitude[0].iter().zip(&paths.delay_s[0]).map(carried).sum()
}

/// A trough of two planes at right angles about a horizontal edge returns a low wave by two bounces. Its
/// image is as deep below the sea as the trough is high; what a radar at 4 m sees to 8 km is not beyond its
/// horizon.
#[test]
fn double_bounces_stay_within_the_horizon() {
    let echo_db = |earth: Earth| {
        let edge = DVec3::new(0.0, -1.0, 4.0);
        let mut panels = wall(edge, DVec3::new(3.5, 0.0, -3.5), DVec3::Y * 2.0, 0.5);
        panels.extend(wall(edge, DVec3::Y * 2.0, DVec3::new(3.5, 0.0, 3.5), 0.5));
        let frame = SceneFrame::plain(earth).with_horizon(true);
        let (scene, tracks) = monostatic(frame, ship(panels, [7000.0, 0.0], PI), [0.0, 0.0, 4.0]);
        let (paths, _) = pulse(&scene, &tracks, 0);
        20.0 * sum(&scene, &paths).norm().log10()
    };
    let (flat, curved) = (echo_db(Earth::Flat), echo_db(EARTH));
    assert!((flat - curved).abs() < 0.1, "{flat} {curved}");
}

/// A house with a mast on a deck: planes between which waves bounce, and that hide each other.
fn house() -> Vec<Triangle> {
    let mut panels = wall(DVec3::new(-10.0, -4.0, 2.0), DVec3::X * 20.0, DVec3::Y * 8.0, 1.0);
    for (x, half, high) in [(0.0, 2.0, 8.0), (-6.0, 1.0, 5.0)] {
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
        let at = |(a, b): (f64, f64)| DVec3::new(x + a * half, b * half, 2.0);
        for ends in corners.windows(2) {
            panels.extend(wall(at(ends[0]), at(ends[1]) - at(ends[0]), DVec3::Z * high, 1.0));
        }
    }
    panels
}

/// A pulse is the same in a run of a second and in one of half a day: an aircraft flies by at 200 m/s, so
/// other planes are met later on, and what is hidden changes between the knots about the pulse.
#[test]
fn pulses_do_not_depend_on_the_length_of_a_run() {
    let of_run = |pulses: u64| {
        let frame = SceneFrame::plain(Earth::Flat);
        let (scene, _) = monostatic(frame, ship(house(), [0.0, 0.0], 0.3), [0.0; 3]);
        let scene = Scene { pulses, ..scene };
        let track = straight(&scene, [-500.0, 400.0, 200.0], [200.0, 0.0, 0.0]);
        pulse(&scene, &[track.clone(), track], 150).0
    };
    let short = of_run(222);
    assert!(short.len() > 200, "{}", short.len());
    for pulses in [2220, 222 * 60 * 60 * 12] {
        let long = of_run(pulses);
        assert_eq!((&short.amplitude, &short.delay_s), (&long.amplitude, &long.delay_s), "{pulses}");
    }
}

/// A plate of 3 m x 2 m and some hundred panels, off broadside:
/// `sigma = 4 pi A^2/lambda^2 cos^2 t sinc^2(k w sin t)` (Knott, Shaeffer, Tuley, section 5.4.1), through
/// delays, amplitudes and the radar equation, from the main lobe to the sixth side lobe.
#[test]
fn a_plate_has_its_pattern() {
    let (wide, high, range_m) = (3.0, 2.0, 100e3);
    for degrees in [0.0, 0.1, 0.2, 0.45, 0.7, 1.0, 1.3, 1.9] {
        let t = f64::to_radians(degrees);
        let panels = wall(DVec3::new(0.0, -0.5 * wide, -0.5 * high), DVec3::Y * wide, DVec3::Z * high, 0.3);
        assert!(panels.len() > 100);
        let frame = SceneFrame::plain(Earth::Flat);
        let (scene, tracks) = monostatic(frame, ship(panels, [range_m, 0.0], PI + t), [0.0; 3]);
        let (paths, _) = pulse(&scene, &tracks, 0);
        let wavelength_m = scene.radar.wavelength_m();
        let phase = TAU / wavelength_m * wide * t.sin();
        let sinc = if phase == 0.0 { 1.0 } else { phase.sin() / phase };
        let rcs_m2 = 4.0 * PI * (wide * high * t.cos() * sinc / wavelength_m).powi(2);
        let power = wavelength_m.powi(2) * rcs_m2 / ((4.0 * PI).powi(3) * range_m.powi(4));
        // Relative to the main lobe, since there are nulls: a thousandth of it.
        let peak = power.sqrt() / (t.cos() * sinc).abs();
        let off = (sum(&scene, &paths).norm() - power.sqrt()) / peak;
        assert!(off.abs() < 1e-3, "{degrees}: {off}");
    }
}

/// A ship that lies across the end of the window is flagged as a target is, by the record of the fast echo
/// too.
#[test]
fn echoes_outside_the_window_are_flagged() {
    let frame = SceneFrame::plain(Earth::Flat);
    let (mut scene, tracks) = monostatic(frame, ship(house(), [3000.0, 0.0], PI), [0.0, 0.0, 20.0]);
    // Ends of echoes: 20.0 us of the way, and the pulse.
    let end_s = |scene: &Scene| scene.radar.window.samples as f64 / scene.radar.sample_rate_hz;
    for (samples, outside) in [(2300, false), (2035, true), (1900, true)] {
        scene.radar.window.samples = samples;
        let (_, record) = pulse(&scene, &tracks, 7);
        assert_eq!(record.flags & flags::OUTSIDE_WINDOW != 0, outside, "{} s", end_s(&scene));
        let generator = PathGenerator::new(&scene, PULSE_S, tracks.clone()).unwrap();
        let (_, mut of_block) = buffers(&scene);
        generator.record(7, &mut generator.workspace(), &mut of_block).unwrap();
        assert_eq!(of_block.flags, record.flags, "{samples}");
    }
    // What no antenna sees is not missed: the same, all its panels turned round.
    let turned = house().into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let below = ship(turned, [3000.0, 0.0], PI);
    scene.ships =
        vec![Ship { panels: below.panels.iter().filter(|t| t[0].x > 5.0).copied().collect(), ..below }];
    assert_eq!(pulse(&scene, &tracks, 7).1.flags & flags::OUTSIDE_WINDOW, 0);
}

/// A ship that rides a sea of 64 x 64 facets, and its radar.
fn riding(panels: Vec<Triangle>, form: HullForm, facet_m: f64, place: [f64; 3]) -> (Scene, PathGenerator) {
    let motion = ShipMotion::Waves { roll_period_s: Some(1.5), form: Some(form) };
    let own = ship(panels, [40.0, -30.0], 0.6);
    let own = Ship {
        length_m: Some(20.0),
        speed_mps: 5.0,
        mesh: ShipMesh { motion, ..ShipMesh::default() },
        ..own
    };
    let (mut scene, tracks) = monostatic(SceneFrame::plain(Earth::Flat), own, place);
    scene.sea = Some(sea(64, facet_m, 0.7));
    scene.pulses = 4000;
    let generator = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
    (scene, generator)
}

/// The delay rate of every panel and double bounce of a ship that heaves, pitches and rolls is the change of
/// its delay: by central differences at 20 kHz.
#[test]
fn panels_that_ride_have_the_doppler_of_their_paths() {
    let form = HullForm { length_m: 20.0, beam_m: 8.0, draught_m: 1.5, block: 0.7 };
    let (mut scene, _) = riding(house(), form, 2.0, [-900.0, 400.0, 300.0]);
    let mut level = Scene { sea: None, ..scene.clone() };
    let mut spread_mps = Vec::new();
    for scene in [&mut scene, &mut level] {
        scene.radar.emissions = PulseTimes::uniform(20e3).unwrap();
        let tracks = straight(scene, [-900.0, 400.0, 300.0], [5.0, 0.0, 0.0]);
        let generator = PathGenerator::new(scene, PULSE_S, vec![tracks.clone(), tracks]).unwrap();
        let mut workspace = generator.workspace();
        let mut fastest = 0f64;
        for at in [100, 1500, 3900] {
            let [before, now, after] = [at - 1, at, at + 1].map(|index| {
                let (mut paths, _) = buffers(scene);
                generator.points(index, &mut workspace, &mut paths).unwrap();
                paths
            });
            assert!(now.len() == generator.ship_paths() && now.len() > 300, "{}", now.len());
            for n in 0..now.len() {
                let slope = (after.delay_s[0][n] - before.delay_s[0][n]) * 20e3 / 2.0;
                let off_mps = (slope - now.delay_rate[0][n]).abs() * 299_792_458.0;
                assert!(off_mps < 1e-5, "{at} {n}: {off_mps}");
            }
            let rates = now.delay_rate[0].iter().map(|rate| rate * 299_792_458.0);
            let [low, high] = rates.fold([f64::MAX, f64::MIN], |[a, b], r| [a.min(r), b.max(r)]);
            fastest = fastest.max(high - low);
        }
        println!("rates of panels differ by up to {fastest:.2} m/s");
        spread_mps.push(fastest);
    }
    // Level, they differ by what ship and radar turn about each other, 10 m/s over 1 km.
    assert!(spread_mps[0] > 1.5 * spread_mps[1], "{spread_mps:?}");
}

/// What blocks of pulses take of panels and double bounces, many at a time, is what the reference has of them
/// one by one: patterns and ports of all kinds, two aircraft, a ship that rides the waves, a horizon.
#[test]
fn panels_side_by_side_are_as_one_by_one() {
    use nereus::scene::radar::Polarisation::{H, L, R, V};
    let form = HullForm { length_m: 20.0, beam_m: 8.0, draught_m: 1.5, block: 0.7 };
    let (mut scene, _) = riding(house(), form, 2.0, [0.0; 3]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fan.csv");
    let turning = "az_deg,el_deg,gain_dbi,phase_deg\n-90,-90,3,20\n-90,90,5,-70\n90,-90,9,150\n90,90,2,10\n";
    std::fs::write(&path, turning).unwrap();
    let patterns = [
        Pattern::Isotropic { gain_dbi: 10.0 },
        Pattern::Rectangle { width_m: 1.5, height_m: 0.1 },
        Pattern::Ellipse { width_m: 0.5, height_m: 0.3 },
        Pattern::File { path, floor_dbi: -40.0 },
    ];
    let (mut worst, mut bounces) = (0f64, 0);
    for (n, pattern) in patterns.iter().enumerate() {
        scene.frame = SceneFrame::plain(if n == 0 { EARTH } else { Earth::Flat }).with_horizon(n == 0);
        scene.radar.transmitters[0].antenna.pattern = pattern.clone();
        scene.radar.receivers[0].antenna.pattern = patterns[(n + 1) % patterns.len()].clone();
        scene.radar.receivers[0].antenna.ports.isolation_db = Some(20.0);
        scene.radar.channels = channels(&[(H, H), (V, H), (R, V), (L, R)]);
        let tracks = vec![
            straight(&scene, [-900.0, 400.0, 300.0], [200.0, 30.0, 5.0]),
            straight(&scene, [700.0, -800.0, 150.0 + 400.0 * n as f64], [-90.0, 150.0, 0.0]),
        ];
        let generator = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
        for index in [3, 700, 2200] {
            let (exact, _) = evaluate(&scene, &generator, index);
            let (mut found, mut factors) = (buffers(&scene).0, Vec::new());
            let mut workspace = generator.workspace();
            generator.points(index, &mut workspace, &mut found).unwrap();
            generator.variations(index, None, &mut workspace, &mut factors).unwrap();
            let largest = exact
                .amplitude
                .iter()
                .flat_map(|column| &column[..100])
                .map(|a| a.norm())
                .fold(0.0, f64::max);
            let mut at = 0;
            for (n, factor) in factors.iter().enumerate() {
                let met = (found.delay_s[0][n] - exact.delay_s[0][at]).abs() < 1e-17 && *factor != 0.0;
                for (own, exact) in found.amplitude.iter().zip(&exact.amplitude) {
                    let exact = if met { exact[at] } else { Complex64::ZERO };
                    worst = worst.max((own[n] * factor - exact).norm() / largest);
                }
                if met {
                    assert!((found.delay_rate[0][n] - exact.delay_rate[0][at]).abs() < 1e-15);
                    bounces += usize::from(n >= house().len());
                    at += 1;
                }
            }
            assert!(at > 100, "{at}");
        }
    }
    println!("panels side by side differ by up to {worst:.1e}, {bounces} double bounces among them");
    // Roundings of phases of up to 400 rad.
    assert!(worst < 1e-11 && bounces > 50, "{worst:e} {bounces}");
}

/// A skiff that is much smaller than the waves lies on the surface: its mid and its bow are where the water
/// and its slope put them.
#[test]
fn a_skiff_lies_on_the_surface() {
    let form = HullForm { length_m: 0.4, beam_m: 0.2, draught_m: 0.02, block: 0.9 };
    // Two small triangles, one at midship and one 10 m ahead of it, on a pole.
    let small = |x: f64| {
        [DVec3::new(x - 0.02, -0.02, 0.0), DVec3::new(x + 0.04, 0.0, 0.0), DVec3::new(x - 0.02, 0.02, 0.0)]
    };
    let high_m = 3000.0;
    let (scene, generator) = riding(vec![small(0.0), small(10.0)], form, 8.0, [40.0, -30.0, high_m]);
    let surface = realise(scene.sea.as_ref().unwrap(), scene.seed).unwrap().surface;
    let (mut off_m, mut largest_m) = ([0f64; 2], [0f64; 2]);
    for index in (0..2200).step_by(110) {
        let mut found = buffers(&scene).0;
        generator.points(index, &mut generator.workspace(), &mut found).unwrap();
        let t_s = index as f64 / 222.0 + high_m / 299_792_458.0;
        let place = [40.0 + 5.0 * 0.6f64.cos() * t_s, -30.0 + 5.0 * 0.6f64.sin() * t_s];
        let wave = surface.at(place, t_s);
        let slope = wave.slope[0] * 0.6f64.cos() + wave.slope[1] * 0.6f64.sin();
        let bow = slope.atan();
        for (n, ahead_m) in [0.0, 10.0 * bow.cos()].into_iter().enumerate() {
            let z_m = wave.height_m + if n == 1 { 10.0 * bow.sin() } else { 0.0 };
            let at = [place[0] + ahead_m * 0.6f64.cos(), place[1] + ahead_m * 0.6f64.sin(), z_m];
            let leg_m = (at[0] - 40.0).hypot(at[1] + 30.0).hypot(at[2] - high_m);
            let off = 0.5 * 299_792_458.0 * found.delay_s[0][n] - leg_m;
            off_m[n] = off_m[n].max(off.abs());
            largest_m[n] = largest_m[n].max(if n == 0 { z_m.abs() } else { (z_m - wave.height_m).abs() });
        }
    }
    println!("off by {off_m:.4?} m of up to {largest_m:.3?} m");
    // k T of the shortest waves, of 16 m, is 0.008; a hundredth of those at most.
    assert!(largest_m[0] > 0.3 && largest_m[1] > 0.3, "{largest_m:?}");
    assert!(off_m[0] < 0.01 * largest_m[0] && off_m[1] < 0.02 * largest_m[1], "{off_m:?}");
}

/// Facets behind and under a ship return nothing: as many as its shadow has, `20 m (8 m + 6 m/tan)` of 1 m
/// each. The box is inside out, so that it returns nothing itself, and hides the same.
#[test]
fn a_ship_hides_the_sea_behind_it() {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut panels = wall(at(-10.0, -4.0, 6.0), DVec3::X * 20.0, DVec3::Y * 8.0, 2.0);
    for (corner, along) in [
        (at(-10.0, -4.0, 0.0), DVec3::X * 20.0),
        (at(10.0, 4.0, 0.0), DVec3::X * -20.0),
        (at(10.0, -4.0, 0.0), DVec3::Y * 8.0),
        (at(-10.0, 4.0, 0.0), DVec3::Y * -8.0),
    ] {
        panels.extend(wall(corner, along, DVec3::Z * 6.0, 2.0));
    }
    let panels = panels.into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let (high_m, far_m) = (400.0, 3000.0);
    let own = Ship { length_m: Some(20.0), ..ship(panels, [0.3, 0.2], PI / 2.0) };
    let (mut scene, tracks) = monostatic(SceneFrame::plain(Earth::Flat), own, [-far_m, 0.0, high_m]);
    scene.sea = Some(sea(128, 1.0, 0.3));
    let illuminated = |scene: &Scene| {
        let generator = PathGenerator::new(scene, PULSE_S, tracks.clone()).unwrap();
        evaluate(scene, &generator, 3).0.len()
    };
    let without = |scene: &Scene| Scene { ships: vec![ship(Vec::new(), [0.3, 0.2], 0.0)], ..scene.clone() };
    let open = |scene: &Scene| {
        let mut scene = without(scene);
        scene.ships[0].length_m = Some(20.0);
        illuminated(&scene)
    };
    let (with, all) = (illuminated(&scene), open(&scene));
    let hidden = 20.0 * (8.0 + 6.0 * far_m / high_m);
    println!("{with} of {all} facets, {hidden:.0} m^2 hidden");
    // Some slopes turn away by themselves. The end of the shadow wanders with the waves there, by some metres
    // of 53.
    let facing = all as f64 / (128.0 * 128.0);
    assert!(((all - with) as f64 / (facing * hidden) - 1.0).abs() < 0.06, "{with} {all}");
    // Where waves hide each other too, it hides what they do not.
    scene.sea.as_mut().unwrap().shadow = Some(Shadowing::default());
    let (with, all) = (illuminated(&scene), open(&scene));
    println!("{with} of {all} facets with shadows of waves");
    assert!(all > with && ((all - with) as f64) < 1.1 * hidden, "{with} {all}");
}
