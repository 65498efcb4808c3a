//! Polarisation bases of antennas, through the whole way: scene, pointing, amplitudes.

use std::f64::consts::{FRAC_PI_3, PI};

use nereus::frames::{Earth, Rotation, SceneFrame, Vector};
use nereus::motion::PlatformTracks;
use nereus::motion::track::Track;
use nereus::scene::radar::*;
use nereus::scene::{Scene, Target};
use num_complex::Complex64;

use crate::radar_scenes::*;

const AHEAD: Pointing = Pointing::Fixed { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 };

fn vertical_wire() -> [[Complex64; 2]; 2] {
    [[Complex64::ONE, Complex64::ZERO], [Complex64::ZERO; 2]]
}

/// Transmitter and receiver in one place, bolted on, with one pattern.
fn monostatic(pattern: &Pattern, pointing: &Pointing) -> Scene {
    let mut scene = scene();
    scene.radar.receivers[0].antenna.platform = 0;
    for mount in [&mut scene.radar.transmitters[0].antenna, &mut scene.radar.receivers[0].antenna] {
        mount.pattern = pattern.clone();
        mount.pointing = pointing.clone();
    }
    scene
}

/// HH, HV, VH, VV of one target seen from a platform at a place with an attitude.
fn amplitudes(
    scene: &mut Scene,
    at: [f64; 3],
    attitude: [f64; 3],
    target_m: [f64; 3],
    scattering: [[Complex64; 2]; 2],
) -> [Complex64; 4] {
    let [yaw, pitch, roll] = attitude;
    let track = same(Track::fixed(point(at), Rotation::from_yaw_pitch_roll(yaw, pitch, roll)));
    scene.targets = vec![Target { scattering, ..target(target_m, [0.0; 3]) }];
    let tracks: Vec<PlatformTracks> = vec![track.clone(), track];
    let (paths, _) = pulse(scene, &tracks, 0);
    assert_eq!(paths.len(), 1);
    std::array::from_fn(|channel| paths.amplitude[channel][0])
}

fn db(a: Complex64, of: Complex64) -> f64 {
    20.0 * (a.norm() / of.norm()).log10()
}

/// A sphere of 30 dBsm abeam of an isotropic antenna that looks ahead: there is no cross-polarisation.
#[test]
fn a_sphere_abeam_of_an_isotropic_antenna() {
    let mut scene = monostatic(&Pattern::Isotropic { gain_dbi: 0.0 }, &AHEAD);
    for (bearing_deg, height_m) in
        [(90.0, 50.0), (90.0, 3000.0), (-90.0, 300.0), (45.0, 1000.0), (180.0, 10.0)]
    {
        let bearing = f64::to_radians(bearing_deg);
        let place = [3000.0 * bearing.sin(), 3000.0 * bearing.cos(), 0.0];
        // Rolling and pitching, as platforms do.
        let attitude = [0.0, 0.1, -0.2];
        let sphere = Target::sphere(1000.0);
        let [hh, hv, vh, vv] = amplitudes(&mut scene, [0.0, 0.0, height_m], attitude, place, sphere);
        assert!((hh - vv).norm() < 1e-12 * hh.norm(), "{bearing_deg}: HH {hh}, VV {vv}");
        assert!(db(hv, hh) < -240.0 && db(vh, hh) < -240.0, "{bearing_deg}: {hv}, {vh}");
    }
}

/// A vertical wire on the horizon is seen by V alone from every side.
#[test]
fn a_vertical_wire_is_seen_by_v_alone() {
    let isotropic = monostatic(&Pattern::Isotropic { gain_dbi: 0.0 }, &AHEAD);
    // Of a level aperture this holds in its horizontal plane, out to the edge of what it sees.
    let aperture = monostatic(&Pattern::Rectangle { width_m: 0.02, height_m: 0.02 }, &AHEAD);
    for (mut scene, bearings) in [(isotropic, -180..=180), (aperture, -85..=85)] {
        for bearing_deg in bearings.step_by(5) {
            let bearing = f64::from(bearing_deg).to_radians();
            let place = [3000.0 * bearing.sin(), 3000.0 * bearing.cos(), 100.0];
            let [hh, hv, vh, vv] =
                amplitudes(&mut scene, [0.0, 0.0, 100.0], [0.0; 3], place, vertical_wire());
            for (name, other) in [("HH", hh), ("HV", hv), ("VH", vh)] {
                assert!(db(other, vv) < -240.0, "{bearing_deg}: {name} {other}, VV {vv}");
            }
        }
    }
}

/// A sphere far off the boresight of an aperture, off both principal planes: its ports stay orthogonal.
#[test]
fn ports_of_an_aperture_are_orthogonal_far_off_its_boresight() {
    let mut scene = monostatic(&Pattern::Rectangle { width_m: 0.02, height_m: 0.02 }, &AHEAD);
    // 60 degrees off, half way between its planes.
    let off = FRAC_PI_3.sin() / 2f64.sqrt();
    let place = [3000.0 * off, 3000.0 * FRAC_PI_3.cos(), 3000.0 - 3000.0 * off];
    let sphere = Target::sphere(1.0);
    let [hh, hv, vh, vv] = amplitudes(&mut scene, [0.0, 0.0, 3000.0], [0.0; 3], place, sphere);
    assert!((hh - vv).norm() < 1e-12 * hh.norm(), "HH {hh}, VV {vv}");
    assert!(db(hv, hh) < -240.0 && db(vh, hh) < -240.0, "{hv}, {vh}");
    // Ludwig-3 there, by hand: theta = 60 degrees, phi from the left axis -135 degrees (right, down). V has
    // the part (sin phi theta^ + cos phi phi^) . up = 1 - sin^2 phi (1 - cos theta) = 3/4 of a vertical wire.
    let mut wire = scene.clone();
    let d = [off, FRAC_PI_3.cos(), -off];
    let vertical = |theta: f64, phi: f64| {
        let along = [theta.cos() * phi.sin(), phi.cos()];
        phi.sin() * along[0] + phi.cos() * along[1]
    };
    let expected = vertical(FRAC_PI_3, -0.75 * PI);
    assert!((expected - 0.75).abs() < 1e-15);
    // The wire answers the component along v of the ray, up = -sin(incidence) v: S_vv = sin^2(incidence) as a
    // dipole has.
    let sine = d[0].hypot(d[1]);
    let dipole = [[(sine * sine).into(), Complex64::ZERO], [Complex64::ZERO; 2]];
    let [_, _, _, of_v] = amplitudes(&mut wire, [0.0, 0.0, 3000.0], [0.0; 3], place, dipole);
    assert!((of_v.norm() / vv.norm() - expected * expected).abs() < 1e-12, "{of_v} {vv}");
}

/// Isotropic antennas over a flat earth receive H of each other in H alone, wherever they look.
#[test]
fn the_direct_path_between_isotropic_antennas() {
    let mut scene = monostatic(&Pattern::Isotropic { gain_dbi: 0.0 }, &AHEAD);
    scene.radar.receivers[0].antenna.platform = 1;
    scene.radar.direct_path = true;
    scene.targets.clear();
    let track =
        |at: [f64; 3], yaw: f64| same(Track::fixed(point(at), Rotation::from_yaw_pitch_roll(yaw, 0.3, -0.4)));
    let tracks = [track([0.0, 0.0, 500.0], 0.7), track([4000.0, -3000.0, 2000.0], 2.9)];
    let (paths, _) = pulse(&scene, &tracks, 0);
    let [hh, hv, vh, vv] = std::array::from_fn(|channel| paths.amplitude[channel][0]);
    // H of both points to the left of the one who looks: against each other.
    assert!((hh + vv).norm() < 1e-14 * hh.norm() && vv.re > 0.0, "{hh} {vv}");
    assert!(hv.norm().max(vh.norm()) < 1e-14 * hh.norm());
}

/// Over a curved earth H is level at the phase centre, not at the origin of the scene.
#[test]
fn level_is_level_at_the_phase_centre() {
    let earth = Earth::Curved { radius_factor: 1.0 };
    let mut scene = monostatic(&Pattern::Isotropic { gain_dbi: 0.0 }, &AHEAD);
    scene.frame = SceneFrame::plain(earth);
    // 400 km East of the origin, 500 km up: the vertical leans East by 3.33 degrees.
    let at = [400e3, 0.0, 500e3];
    let up = earth.up(point(at));
    let lean = (400e3f64 / (6371e3 + 500e3)).atan();
    assert!((up - Vector::new(lean.sin(), 0.0, lean.cos())).norm() < 1e-15);
    // A target North of it at its height: H there leans by as much towards a vertical wire.
    let north = [400e3, 60e3, 500e3];
    let [hh, _, _, vv] = amplitudes(&mut scene, at, [0.0; 3], north, vertical_wire());
    assert!(((hh.norm() / vv.norm()).sqrt() - lean.tan()).abs() < 1e-9, "{hh} {vv}");
}
