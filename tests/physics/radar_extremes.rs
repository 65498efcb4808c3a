//! Legal but unlikely geometry: nothing panics, nothing is NaN or infinite.

use nereus::frames::{Earth, Rotation, SceneFrame, Vector};
use nereus::motion::track::Track;
use nereus::paths::PathGenerator;
use nereus::scene::Scene;
use nereus::scene::radar::*;
use nereus::time::PulseTimes;
use proptest::prelude::*;

use crate::radar_scenes::*;

fn all_finite(scene: &Scene, tracks: &[nereus::motion::PlatformTracks], index: u64) -> usize {
    let (paths, record) = pulse(scene, tracks, index);
    let finite = |list: &[f64]| list.iter().all(|x| x.is_finite());
    assert!(finite(&paths.emission_offset_s) && record.window_start_s.is_finite());
    assert!(paths.delay_s.iter().chain(&paths.delay_rate).all(|column| finite(column)));
    assert!(paths.amplitude.iter().flatten().all(|a| a.is_finite()));
    assert!(finite(&record.target_delay_s) && finite(&record.target_doppler_hz));
    assert!(record.antennas.iter().all(|a| finite(&a.phase_centre_m)
        && finite(&a.boresight_quat)
        && finite(&a.reported_phase_centre_m)));
    paths.len()
}

fn rectangles(scene: &mut Scene) {
    for mount in [&mut scene.radar.transmitters[0].antenna, &mut scene.radar.receivers[0].antenna] {
        mount.pattern = Pattern::Rectangle { width_m: 4.0, height_m: 0.05 };
    }
}

#[test]
fn a_target_in_the_antenna_or_behind_it_returns_nothing() {
    let mut scene = scene();
    rectangles(&mut scene);
    let tracks = [straight(&scene, [0.0, -3e3, 3e3], [0.0; 3]), straight(&scene, [0.0, -3e3, 3e3], [0.0; 3])];
    scene.targets = vec![target([0.0, -3e3, 3e3], [0.0; 3])];
    assert_eq!(all_finite(&scene, &tracks, 0), 0);
    scene.targets = vec![target([0.0, -9e3, 3e3], [0.0; 3])];
    assert_eq!(all_finite(&scene, &tracks, 0), 0);
    scene.targets = vec![];
    assert_eq!(all_finite(&scene, &tracks, 0), 0);
    scene.radar.direct_path = true;
    assert_eq!(all_finite(&scene, &tracks, 0), 0, "no direct path to oneself");
}

#[test]
fn nadir_and_the_forward_baseline() {
    let mut scene = scene();
    rectangles(&mut scene);
    let above = [
        straight(&scene, [0.0, 0.0, 3e3], [222.0, 0.0, 0.0]),
        straight(&scene, [0.0, 0.0, 3e3], [222.0, 0.0, 0.0]),
    ];
    assert_eq!(all_finite(&scene, &above, 0), 1);
    // Transmitter, target and receiver on a line, level and vertical.
    for (a, b) in [([-3e3, 0.0, 0.0], [2e3, 0.0, 0.0]), ([0.0, 0.0, 3e3], [0.0, 0.0, -1e3])] {
        let tracks = [straight(&scene, a, [0.0; 3]), straight(&scene, b, [0.0; 3])];
        scene.radar.direct_path = true;
        assert_eq!(all_finite(&scene, &tracks, 0), 2);
        let (paths, _) = pulse(&scene, &tracks, 0);
        assert!((paths.delay_s[0][0] - paths.delay_s[0][1]).abs() < 1e-19);
    }
}

#[test]
fn no_channels_no_targets_no_samples() {
    let mut scene = scene();
    let tracks = [straight(&scene, [0.0, -3e3, 3e3], [0.0; 3]), straight(&scene, [0.0, -3e3, 3e3], [0.0; 3])];
    scene.radar.window = Window {
        samples: 0,
        gate: Gate::Follow {
            aim: Aim::Beside { platform: 0, along_m: 0.0, across_m: 100.0 },
            lead_s: 1e-6,
            aim_from: AimFrom::True,
        },
    };
    scene.radar.direct_path = true;
    scene.radar.channels.clear();
    assert_eq!(all_finite(&scene, &tracks, 0), 0);
    scene.targets.clear();
    assert_eq!(all_finite(&scene, &tracks, 499), 0);
    scene.pulses = 0;
    assert!(PathGenerator::new(&scene, PULSE_S, tracks.to_vec()).is_ok());
}

/// Late in a long run at a high PRF nothing drifts: the truth still obeys the closed form.
#[test]
fn a_billionth_pulse() {
    let mut scene = scene();
    scene.radar.emissions = PulseTimes::uniform(1e6 / 3.0).unwrap();
    scene.pulses = 2_000_000_000;
    scene.targets = vec![target([0.0; 3], [1.0, 0.0, 0.0])];
    let tracks = [
        straight(&scene, [0.0, -3e3, 3e3], [1.0, 0.0, 0.0]),
        straight(&scene, [0.0, -3e3, 3e3], [1.0, 0.0, 0.0]),
    ];
    scene.radar.window.samples = 256;
    let (_, first) = pulse(&scene, &tracks, 0);
    let (_, last) = pulse(&scene, &tracks, 1_000_000_000);
    // Everything moves alike, so that the delay stays; positions of 3 km round to 4.5e-13 m.
    assert!((first.target_delay_s[0] - last.target_delay_s[0]).abs() < 1e-20);
}

fn place(reach_m: f64) -> impl Strategy<Value = [f64; 3]> {
    // Coarse steps make coincident and aligned places likely.
    prop_oneof![
        prop::array::uniform3(-reach_m..reach_m),
        prop::array::uniform3((-2i32..=2).prop_map(move |k| f64::from(k) * reach_m / 4.0)),
    ]
}

fn antenna() -> impl Strategy<Value = Pattern> {
    prop_oneof![
        (-20.0..60.0).prop_map(|gain_dbi| Pattern::Isotropic { gain_dbi }),
        (0.001..20.0, 0.001..20.0).prop_map(|(width_m, height_m)| Pattern::Rectangle { width_m, height_m }),
        (0.001..20.0, 0.001..20.0).prop_map(|(width_m, height_m)| Pattern::Ellipse { width_m, height_m }),
    ]
}

proptest! {
    #![proptest_config(crate::cases::proptests(400))]

    #[test]
    fn nothing_but_finite_numbers(
        ends in [place(1e6), place(1e6)],
        speeds in [place(8e3), place(8e3), place(100.0)],
        spot in place(1e5),
        angles in prop::array::uniform3(-7.0..7.0f64),
        arms in [place(20.0), place(20.0)],
        patterns in [antenna(), antenna()],
        carrier_hz in 1e9..40e9,
        prf_hz in 1.0..5e3,
        index in 0u64..500,
        beside in any::<bool>(),
        circular in any::<bool>(),
        (lag_s, lead_s) in (0.0..1.0, -1e-4..1e-4),
    ) {
        use Polarisation::{H, L, R, V};
        let mut scene = scene();
        scene.frame = SceneFrame::plain(Earth::Curved { radius_factor: 1.0 });
        let radar = &mut scene.radar;
        radar.carrier_hz = carrier_hz;
        radar.emissions = PulseTimes::uniform(prf_hz).unwrap();
        radar.direct_path = true;
        let aim = match beside {
            true => Aim::Beside { platform: 1, along_m: 0.0, across_m: -3e3 },
            false => Aim::Point { position: point(spot), velocity: vector(speeds[2]) },
        };
        radar.window = Window { samples: 500, gate: Gate::Follow { aim: aim.clone(), lead_s, aim_from: AimFrom::Reported } };
        if circular {
            radar.channels = channels(&[(R, R), (L, R), (H, L), (V, L)]);
        }
        let [tx, rx] = &patterns;
        radar.transmitters[0].antenna.pattern = tx.clone();
        radar.receivers[0].antenna.pattern = rx.clone();
        radar.transmitters[0].antenna.lever_arm = Vector::new(arms[0][0], arms[0][1], arms[0][2]);
        radar.receivers[0].antenna.lever_arm = Vector::new(arms[1][0], arms[1][1], arms[1][2]);
        radar.transmitters[0].antenna.pointing =
            Pointing::At { aim, aim_from: AimFrom::Reported, lag_s, bias_rad: [0.01, -0.02] };
        radar.receivers[0].antenna.pointing =
            Pointing::Fixed { yaw_rad: angles[0], pitch_rad: angles[1], roll_rad: angles[2] };
        scene.targets = vec![
            target(spot, speeds[2]),
            target([0.0; 3], [0.0; 3]),
            target(ends[0], [0.0; 3]),
            target(ends[1], speeds[1]),
        ];
        let attitude = Rotation::from_yaw_pitch_roll(angles[0], angles[1], angles[2]);
        let tracks: Vec<_> = (0..2)
            .map(|i| same(Track::straight(point(ends[i]), scene.start, vector(speeds[i]), Some(attitude))))
            .collect();
        all_finite(&scene, &tracks, index);
    }
}
