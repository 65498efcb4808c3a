//! The radar equation through the whole way: scene, tracks, pointing, amplitude.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::DQuat;
use nereus::frames::{Point, Rotation, Vector};
use nereus::motion::PlatformTracks;
use nereus::motion::track::Track;
use nereus::radar::rain::Attenuation;
use nereus::scene::radar::*;
use nereus::scene::{Scene, Target};
use num_complex::Complex64;

use crate::radar_scenes::*;

fn matrix() -> [[Complex64; 2]; 2] {
    let c = Complex64::new;
    [[c(1.0, 0.3), c(-0.2, 0.5)], [c(0.7, -0.1), c(0.4, 0.9)]]
}

fn rectangle(mount: &mut AntennaMount) {
    mount.pattern = Pattern::Rectangle { width_m: 0.8, height_m: 0.1 };
}

/// Both antennas a little off their targets, so that gains and polarisations are nothing special.
fn skew_scene() -> Scene {
    let mut scene = scene();
    scene.radar.transmitters[0].antenna = pointed_at(0, [20.0, 10.0, 0.0]);
    scene.radar.receivers[0].antenna = pointed_at(1, [-15.0, 25.0, 0.0]);
    rectangle(&mut scene.radar.transmitters[0].antenna);
    rectangle(&mut scene.radar.receivers[0].antenna);
    scene.targets[0].scattering = matrix();
    scene
}

/// The same, isotropic antennas, and small apertures that point 82 and 68 degrees beside the target.
fn skew_scenes() -> [Scene; 3] {
    let (mut isotropic, mut wide) = (skew_scene(), skew_scene());
    for radar in [&mut isotropic.radar, &mut wide.radar] {
        let mounts = [&mut radar.transmitters[0].antenna, &mut radar.receivers[0].antenna];
        for (mount, place) in mounts.into_iter().zip([[-3500.0, 6500.0, 0.0], [-1700.0, -2500.0, 500.0]]) {
            mount.pattern = Pattern::Isotropic { gain_dbi: 3.0 };
            let Pointing::At { aim: Aim::Point { position, .. }, .. } = &mut mount.pointing else { panic!() };
            *position = point(place);
        }
    }
    for mount in [&mut wide.radar.transmitters[0].antenna, &mut wide.radar.receivers[0].antenna] {
        mount.pattern = Pattern::Rectangle { width_m: 0.02, height_m: 0.015 };
    }
    [skew_scene(), isotropic, wide]
}

fn amplitudes(scene: &Scene, tracks: &[PlatformTracks]) -> Vec<Complex64> {
    let (paths, _) = pulse(scene, tracks, 0);
    assert_eq!(paths.len(), 1);
    paths.amplitude.iter().map(|column| column[0]).collect()
}

fn worst(a: &[Complex64], b: &[Complex64]) -> f64 {
    let scale = a.iter().map(|x| x.norm()).fold(0.0, f64::max);
    assert!(scale > 0.0);
    a.iter().zip(b).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max) / scale
}

/// |a|^2 = P G_t G_r lambda^2 sigma / ((4 pi)^3 R_t^2 R_r^2 L) and the same over the direct path.
#[test]
fn free_space_closed_form() {
    let mut scene = scene();
    scene.radar.losses_db = 2.5;
    scene.radar.direct_path = true;
    scene.radar.transmitters[0].power_w = 4000.0;
    scene.radar.transmitters[0].antenna.pattern = Pattern::Isotropic { gain_dbi: 33.0 };
    scene.radar.receivers[0].antenna.pattern = Pattern::Isotropic { gain_dbi: 12.0 };
    scene.targets[0].scattering = Target::sphere(7.0);
    // In the plane y = 0 every H axis is along y: HH is co-polar on all paths.
    let tracks = [
        straight(&scene, [-4000.0, 0.0, 3000.0], [0.0; 3]),
        straight(&scene, [-500.0, 0.0, 1200.0], [0.0; 3]),
    ];
    let (paths, _) = pulse(&scene, &tracks, 0);
    assert_eq!(paths.len(), 2);
    let (r_t, r_r, r) = (5000f64, 1300f64, 3500f64.hypot(1800.0));
    let lambda = 299_792_458.0 / 10e9;
    let common = 4000.0 * 10f64.powf(4.5 - 0.25) * lambda * lambda / (4.0 * PI).powi(2);
    let expected = [common * 7.0 / (4.0 * PI * (r_t * r_r).powi(2)), common / (r * r)];
    for (path, expected) in expected.into_iter().enumerate() {
        for hh_vv in [0, 3] {
            let power = paths.amplitude[hh_vv][path].norm_sqr();
            // VV of the bistatic sphere in the plane is as strong; the direct path's V axes are tilted
            // to the line of sight, but projected and scaled they agree too.
            let error = (power / expected - 1.0).abs();
            assert!(error < 1e-12, "path {path} channel {hh_vv}: {error:e}");
        }
        for cross in [1, 2] {
            assert!(paths.amplitude[cross][path].norm_sqr() < 1e-28 * expected);
        }
    }
}

#[test]
fn atmosphere_counts_both_legs() {
    let mut scene = scene();
    let tracks = [
        straight(&scene, [-4000.0, 0.0, 3000.0], [0.0; 3]),
        straight(&scene, [-500.0, 0.0, 1200.0], [0.0; 3]),
    ];
    let clear = amplitudes(&scene, &tracks);
    scene.radar.atmosphere_db_per_km = 0.4;
    let hazy = amplitudes(&scene, &tracks);
    let db = 20.0 * (hazy[0] / clear[0]).norm().log10();
    assert!((db + 0.4 * 6.3).abs() < 1e-11, "{db}");
}

/// ITU-R P.838-3 at 9.4 GHz and 25 mm/h, level: H 0.589, V 0.479, circular 0.533 dB/km; each end of a channel
/// has that of its port over its leg.
#[test]
fn rain_attenuates_ports_by_their_own_coefficients() {
    use Polarisation::{H, L, R, V};
    let mut scene = scene();
    scene.radar.carrier_hz = 9.4e9;
    scene.radar.direct_path = true;
    scene.targets[0].scattering = matrix();
    let ports = [(H, H), (H, V), (V, H), (V, V), (R, L), (R, R)];
    scene.radar.channels = channels(&ports);
    let db = |at: [f64; 3], to: [f64; 3]| {
        let mut scene = scene.clone();
        let tracks = [straight(&scene, at, [0.0; 3]), straight(&scene, to, [0.0; 3])];
        let [clear, wet] = [0.0, 25.0].map(|rain_mmph| {
            scene.radar.rain_mmph = rain_mmph;
            pulse(&scene, &tracks, 0).0.amplitude
        });
        let of = |path: usize| -> Vec<f64> {
            clear.iter().zip(&wet).map(|(a, b)| -20.0 * (b[path] / a[path]).norm().log10()).collect()
        };
        [of(0), of(1)]
    };
    let published = |port| match port {
        H => 0.589,
        V => 0.479,
        R | L => 0.533,
    };
    // Level, 8 km to the target and 3 km back; 11 km straight.
    let [target, direct] = db([-8000.0, 0.0, 0.0], [3000.0, 0.0, 0.0]);
    for ((rx, tx), (target, direct)) in ports.into_iter().zip(target.into_iter().zip(direct)) {
        let expected = published(tx) * 8.0 + published(rx) * 3.0;
        // The figures have three digits.
        assert!((target - expected).abs() < 5e-4 * 11.0, "{rx:?}{tx:?}: {target} {expected}");
        if rx == tx && rx != R {
            assert!((direct - published(tx) * 11.0).abs() < 5e-4 * 11.0, "{rx:?}{tx:?}: {direct}");
        }
    }
    // From above H is V, and rain takes what it takes of circular polarisation.
    let [target, _] = db([0.0, 1.0, 9000.0], [1.0, 0.0, 9000.0]);
    assert!(target.iter().all(|db| (db - 0.533 * 18.0).abs() < 5e-4 * 18.0), "{target:?}");
    // Halfway up: the Recommendation's equations 4 and 5 at 45 degrees, by its table at 10 GHz.
    scene.radar.carrier_hz = 10e9;
    let [(k_h, a_h), (k_v, a_v)] = [(0.01217f64, 1.2571), (0.01129, 1.2156)];
    let exact = [0.5, -0.5].map(|tilt| {
        let k = 0.5 * (k_h + k_v + (k_h - k_v) * tilt);
        k * 25f64.powf((k_h * a_h + k_v * a_v + (k_h * a_h - k_v * a_v) * tilt) / (2.0 * k))
    });
    let at = Attenuation::new(10e9, 25.0);
    for (port, exact) in [H, V].into_iter().zip(exact) {
        let found = at.of(port, FRAC_PI_4.sin());
        assert!((found / exact - 1.0).abs() < 4e-3, "{port:?}: {found} {exact}");
    }
}

/// Rain that leaves nothing leaves zeros, not what is no number.
#[test]
fn rain_without_end_leaves_nothing() {
    let mut scene = scene();
    (scene.radar.carrier_hz, scene.radar.rain_mmph) = (1e11, 300.0);
    let tracks = [7e5, 6e5].map(|height_m| straight(&scene, [-4000.0, 0.0, height_m], [0.0; 3]));
    let (paths, _) = pulse(&scene, &tracks, 0);
    assert!(paths.amplitude.iter().flatten().all(|a| a.norm() == 0.0));
}

#[test]
fn a_sphere_is_the_same_in_h_and_v() {
    let mut scene = scene();
    scene.radar.receivers[0].antenna.platform = 0;
    for position in [[0.0, -3000.0, 3000.0], [2000.0, 1000.0, 15.0], [1.0, 1.0, 3000.0]] {
        let tracks = [straight(&scene, position, [0.0; 3]), straight(&scene, position, [0.0; 3])];
        let [hh, hv, vh, vv] = amplitudes(&scene, &tracks)[..] else { panic!("four channels") };
        assert!((hh - vv).norm() < 1e-15 * hh.norm() && hv.norm().max(vh.norm()) < 1e-15 * hh.norm());
        assert!(hh.re > 0.0);
    }
    // Circular: an odd number of reflections turns the hand.
    use Polarisation::{L, R};
    scene.radar.channels = channels(&[(R, R), (L, R), (R, L), (L, L)]);
    let tracks = [straight(&scene, [0.0, -3e3, 3e3], [0.0; 3]), straight(&scene, [0.0, -3e3, 3e3], [0.0; 3])];
    let [rr, lr, rl, ll] = amplitudes(&scene, &tracks)[..] else { panic!("four channels") };
    assert!(rr.norm().max(ll.norm()) < 1e-15 * lr.norm() && (lr - rl).norm() < 1e-15 * lr.norm());
}

/// Ends swapped, matrix reversed (`S_pq(ks, ki) = s_p s_q S_qp(-ki, -ks)`), channel names reversed: the
/// same amplitudes.
#[test]
fn reciprocity() {
    for forward in skew_scenes() {
        reciprocal(&forward);
    }
}

fn reciprocal(forward: &Scene) {
    let tracks = [
        straight(forward, [-3500.0, 400.0, 2500.0], [0.0; 3]),
        straight(forward, [900.0, -2000.0, 1500.0], [0.0; 3]),
    ];
    let there = amplitudes(forward, &tracks);
    let mut backward = forward.clone();
    backward.radar.transmitters[0].antenna = forward.radar.receivers[0].antenna.clone();
    backward.radar.receivers[0].antenna = forward.radar.transmitters[0].antenna.clone();
    let s = matrix();
    backward.targets[0].scattering = [[s[0][0], -s[1][0]], [-s[0][1], s[1][1]]];
    let [hh, hv, vh, vv] = amplitudes(&backward, &tracks)[..] else { panic!("four channels") };
    // A few dozen roundings.
    assert!(worst(&there, &[hh, vh, hv, vv]) < 1e-14);
    assert!(there.iter().all(|a| a.norm() > 1e-12));
}

/// The whole scene turned about the vertical, and moved: nothing changes.
#[test]
fn turning_the_scene_changes_nothing() {
    for original in skew_scenes() {
        turned(&original);
    }
}

fn turned(original: &Scene) {
    let places = [[-3500.0, 400.0, 2500.0], [900.0, -2000.0, 1500.0]];
    let speeds = [[50.0, 20.0, 1.0], [-30.0, 80.0, -2.0]];
    let tracks: Vec<_> = (0..2).map(|i| straight(original, places[i], speeds[i])).collect();
    let (reference, reference_record) = pulse(original, &tracks, 100);
    for (angle, shift) in [(0.7, [0.0; 3]), (-2.9, [300.0, -120.0, 0.0]), (PI / 2.0, [0.0, 0.0, 40.0])] {
        let turn = DQuat::from_rotation_z(angle);
        let vector = |v: Vector<_>| Vector::from_raw(turn * v.raw());
        let point = |p: Point<_>| Point::from_raw(turn * p.raw()) + crate::radar_scenes::vector(shift);
        let mut scene = original.clone();
        for mount in [&mut scene.radar.transmitters[0].antenna, &mut scene.radar.receivers[0].antenna] {
            let Pointing::At { aim: Aim::Point { position, .. }, .. } = &mut mount.pointing else { panic!() };
            *position = point(*position);
        }
        scene.targets[0].position = point(scene.targets[0].position);
        let tracks: Vec<_> = (0..2)
            .map(|i| {
                let (p, v) = (crate::radar_scenes::point(places[i]), crate::radar_scenes::vector(speeds[i]));
                let attitude = Rotation::from_raw(turn * level().raw());
                same(Track::straight(point(p), scene.start, vector(v), Some(attitude)))
            })
            .collect();
        let (paths, record) = pulse(&scene, &tracks, 100);
        let columns = |c: &nereus::paths::list::ScattererPaths| -> Vec<Complex64> {
            c.amplitude.iter().map(|column| column[0]).collect()
        };
        let amplitude = worst(&columns(&reference), &columns(&paths));
        let delay = (record.target_delay_s[0] - reference_record.target_delay_s[0]).abs();
        // Coordinates of 4 km round to 5e-13 m, so the off-boresight angles to 1e-16 of a beam whose
        // gain changes by some 50 per radian.
        assert!(amplitude < 1e-12 && delay < 1e-19, "{angle}: {amplitude:e} {delay:e}");
    }
}

/// A roll of the platform turns the antenna about its boresight and mixes H and V.
#[test]
fn roll_turns_the_polarisation() {
    let mut scene = scene();
    // Both antennas bolted to one aircraft that flies north level and looks ahead at a target at
    // its height.
    for mount in [&mut scene.radar.transmitters[0].antenna, &mut scene.radar.receivers[0].antenna] {
        mount.platform = 0;
        mount.pointing = Pointing::Fixed { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 };
        // An isotropic antenna stays level.
        rectangle(mount);
    }
    scene.targets = vec![target([0.0, 5000.0, 1000.0], [0.0; 3])];
    // A vertical wire: S_vv only.
    let zero = Complex64::ZERO;
    scene.targets[0].scattering = [[Complex64::ONE, zero], [zero, zero]];
    let rolled = |roll: f64| {
        let attitude = Rotation::from_yaw_pitch_roll(0.0, 0.0, roll);
        let track = same(Track::fixed(Point::new(0.0, 0.0, 1000.0), attitude));
        let other = track.clone();
        let (paths, _) = pulse(&scene, &[track, other], 0);
        let column = |c: usize| paths.amplitude[c].first().copied().unwrap_or(zero);
        [column(0), column(1), column(2), column(3)]
    };
    let [hh, hv, vh, vv] = rolled(0.0);
    assert!(vv.re > 0.0 && hh.norm().max(hv.norm()).max(vh.norm()) < 1e-15 * vv.norm());
    let [hh2, hv2, vh2, vv2] = rolled(FRAC_PI_4);
    for (name, a) in [("HH", hh2), ("HV", hv2), ("VH", vh2), ("VV", vv2)] {
        assert!((a.norm() / vv.norm() - 0.5).abs() < 1e-12, "{name}: {a}");
    }
    assert!((hv2 - vh2).norm() < 1e-14 * vv.norm());
    let [hh3, _, _, vv3] = rolled(PI / 2.0);
    assert!((hh3.norm() / vv.norm() - 1.0).abs() < 1e-12 && vv3.norm() < 1e-15 * vv.norm());
}

#[test]
fn ports_leak_as_much_as_they_say() {
    let mut scene = scene();
    scene.radar.receivers[0].antenna.platform = 0;
    scene.radar.transmitters[0].antenna.ports.isolation_db = Some(30.0);
    let tracks = [straight(&scene, [0.0, -3e3, 3e3], [0.0; 3]), straight(&scene, [0.0, -3e3, 3e3], [0.0; 3])];
    let [hh, _, vh, _] = amplitudes(&scene, &tracks)[..] else { panic!("four channels") };
    // H leaves with V at -30 dB beside it.
    assert!((20.0 * (vh / hh).norm().log10() + 30.0).abs() < 1e-9);
}
