//! Which echoes a receive window receives.

use nereus::frames::{Point, Rotation, Vector};
use nereus::geometry::light_time::{LightTime, bistatic, direct};
use nereus::motion::PlatformTracks;
use nereus::motion::pointing::{PhaseCentre, Surroundings};
use nereus::motion::track::Track;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::pulse::flags;
use nereus::radar::antenna::Antenna;
use nereus::radar::fault::{RadarError, RadarFault};
use nereus::radar::window::GUARD_SAMPLES;
use nereus::scene::Scene;
use nereus::scene::radar::*;
use nereus::time::PulseTimes;

use crate::radar_scenes::*;

fn is_shared<T: Send + Sync>() {}

/// A satellite pair at 800 km, 7.5 km/s, delays near 5.4 ms, PRI 0.5 ms.
fn from_space() -> (Scene, Vec<PlatformTracks>) {
    let mut scene = scene();
    scene.radar.emissions = PulseTimes::uniform(2000.0).unwrap();
    scene.pulses = 4000;
    scene.targets = vec![target([0.0; 3], [0.0; 3]), target([3e3, 8e3, 0.0], [10.0, -5.0, 0.0])];
    let tracks = vec![
        straight(&scene, [-7500.0, 50e3, 800e3], [7500.0, 0.0, 0.0]),
        straight(&scene, [-7500.0, 80e3, 801e3], [7500.0, 20.0, 0.0]),
    ];
    scene.radar.window = Window {
        samples: 4096,
        gate: Gate::Follow {
            aim: Aim::Point { position: Point::new(0.0, 0.0, 0.0), velocity: Vector::ZERO },
            lead_s: 5e-6,
            aim_from: AimFrom::Reported,
        },
    };
    (scene, tracks)
}

/// Every emission of the run, tried one after the other: which (emission offset, delay) touch.
fn brute_force(scene: &Scene, tracks: &[PlatformTracks], index: u64, window_start_s: f64) -> Vec<(f64, f64)> {
    let radar = &scene.radar;
    let guard = GUARD_SAMPLES as f64 / radar.sample_rate_hz;
    let close = window_start_s + radar.window.samples as f64 / radar.sample_rate_hz;
    let mut received = Vec::new();
    for e in 0..scene.pulses {
        let t = radar.emissions.emission(scene.start, e);
        let end = |i: usize| PhaseCentre::of(&tracks[i].truth.state(t).unwrap(), Vector::ZERO);
        let offset = radar.emissions.interval_s(index, e);
        let elapsed = radar.emissions.interval_s(0, e);
        let mut delays: Vec<f64> = scene
            .targets
            .iter()
            .map(|s| {
                bistatic(LightTime::Exact, &end(0), s.position + s.velocity * elapsed, s.velocity, &end(1))
                    .delay_s
            })
            .collect();
        if radar.direct_path {
            delays.push(direct(LightTime::Exact, &end(0), &end(1)).delay_s);
        }
        for delay in delays {
            let begin = offset + delay;
            if begin <= close + guard && begin + PULSE_S >= window_start_s - guard {
                received.push((offset, delay));
            }
        }
    }
    received
}

#[test]
fn spaceborne_windows_hear_what_overlaps_them() {
    is_shared::<PathGenerator>();
    let (mut scene, tracks) = from_space();
    for (direct_path, samples, prf_hz) in
        [(false, 4096, 2000.0), (true, 4096, 2000.0), (true, 150_000, 2000.0), (false, 60_000, 17_000.0)]
    {
        scene.radar.direct_path = direct_path;
        scene.radar.window.samples = samples;
        scene.radar.emissions = PulseTimes::uniform(prf_hz).unwrap();
        for index in [0, 1, 12, 2000, 3998, 3999] {
            let (paths, record) = pulse(&scene, &tracks, index);
            let expected = brute_force(&scene, &tracks, index, record.window_start_s);
            let ours: Vec<(f64, f64)> =
                paths.emission_offset_s.iter().copied().zip(paths.delay_s[0].iter().copied()).collect();
            assert_eq!(ours, expected, "pulse {index}, {samples} samples");
            assert!(!ours.is_empty());
        }
    }
    // The gate lies its lead before the aim point's echo, whatever the sample grid.
    scene.radar.direct_path = false;
    let (paths, record) = pulse(&scene, &tracks, 2000);
    assert!((paths.delay_s[0][0] - record.window_start_s - 5e-6).abs() < 1e-17);
    assert!(record.target_delay_s[0] > 10.0 / 2000.0);
}

/// A window that receives only pulses sent long before: its start is the delay modulo the PRI.
#[test]
fn a_folded_window_receives_the_older_pulse() {
    let (mut scene, tracks) = from_space();
    let (_, record) = pulse(&scene, &tracks, 2000);
    let pri = 1.0 / 2000.0;
    let folds = (record.target_delay_s[0] / pri).floor();
    scene.radar.window.gate = Gate::Fixed { start_s: record.target_delay_s[0] - folds * pri - 5e-6 };
    let (paths, record) = pulse(&scene, &tracks, 2000);
    assert_eq!(paths.len(), 2);
    assert!(paths.emission_offset_s.iter().all(|&o| (o + folds * pri).abs() < 1e-12));
    assert_eq!(record.flags, flags::OUTSIDE_WINDOW);
    // The first pulses of the run have nothing before them.
    let (paths, record) = pulse(&scene, &tracks, folds as u64 - 1);
    assert!(paths.is_empty() && record.flags == flags::OUTSIDE_WINDOW);
}

#[test]
fn flags_distinguish_partly_and_wholly_outside() {
    let mut scene = scene();
    let tracks =
        [straight(&scene, [-3000.0, 0.0, 0.0], [0.0; 3]), straight(&scene, [-3000.0, 0.0, 0.0], [0.0; 3])];
    let delay = 6000.0 / 299_792_458.0;
    let mut with = |start_s: f64, samples: usize| {
        scene.radar.window = Window { samples, gate: Gate::Fixed { start_s } };
        let (paths, record) = pulse(&scene, &tracks, 0);
        (paths.len(), record.flags)
    };
    assert_eq!(with(delay - 1e-6, 256), (1, 0));
    assert_eq!(with(delay + 0.1e-6, 256), (1, flags::OUTSIDE_WINDOW));
    // Within the guard of 0.32 us: kept, beyond: not.
    assert_eq!(with(delay + PULSE_S + 0.31e-6, 256), (1, flags::OUTSIDE_WINDOW));
    assert_eq!(with(delay + PULSE_S + 0.33e-6, 256), (0, flags::OUTSIDE_WINDOW));
    assert_eq!(with(delay - 2.56e-6 - 0.31e-6, 256), (1, flags::OUTSIDE_WINDOW));
    assert_eq!(with(delay - 2.56e-6 - 0.33e-6, 256), (0, flags::OUTSIDE_WINDOW));
}

/// When polarisations alternate a channel receives only emissions of its own: also of several in the air.
#[test]
fn alternating_polarisations() {
    use Polarisation::{H, V};
    let (mut scene, tracks) = from_space();
    scene.radar.window.samples = 120_000;
    let (together, _) = pulse(&scene, &tracks, 2000);
    scene.radar.tx_polarisation = TxPolarisation::Alternating(vec![H, V]);
    let (paths, record) = pulse(&scene, &tracks, 2000);
    assert_eq!(record.tx_pol, H.code());
    assert_eq!(paths.len(), together.len());
    let mut received = [0; 2];
    for (path, &offset) in paths.emission_offset_s.iter().enumerate() {
        let sent = (2000 + (offset * 2000.0).round() as i64) as usize % 2;
        received[sent] += 1;
        for (channel, row) in scene.radar.channels.iter().enumerate() {
            let a = paths.amplitude[channel][path];
            if (row.tx == H) == (sent == 0) {
                assert_eq!(a, together.amplitude[channel][path]);
            } else {
                assert_eq!(a.norm(), 0.0);
            }
        }
    }
    assert!(received[0] > 0 && received[1] > 0);
    // A channel that is not asked is not there: HH alone receives every other pulse.
    scene.radar.channels.truncate(1);
    scene.radar.window.samples = 4096;
    assert_eq!(pulse(&scene, &tracks, 2000).0.len(), 2);
    let (odd, record) = pulse(&scene, &tracks, 2001);
    assert_eq!((odd.len(), record.tx_pol), (0, V.code()));
    assert_eq!(record.target_delay_s.len(), 2);
    assert!(record.target_delay_s.iter().all(|d| d.is_finite()));
}

/// The receive antenna sweeps on while the pulse is under way: its gain is that of the reception.
#[test]
fn the_receive_antenna_is_that_of_the_reception() {
    let (mut scene, tracks) = from_space();
    scene.targets.truncate(1);
    // A spot that runs over the ground: 0.03 rad/s, 1.6e-4 rad during the light time.
    let aim = Aim::Point { position: Point::new(-3000.0, 0.0, 0.0), velocity: Vector::new(24e3, 9e3, 0.0) };
    let mount = &mut scene.radar.receivers[0].antenna;
    let (wavelength_m, index) = (299_792_458.0 / 10e9, 200);
    mount.pattern = Pattern::Rectangle { width_m: 4.0, height_m: 1.0 };
    let Pointing::At { aim: receive_aim, .. } = &mut mount.pointing else { panic!() };
    *receive_aim = aim;
    let (paths, record) = pulse(&scene, &tracks, index);
    scene.radar.receivers[0].antenna.pattern = Pattern::Isotropic { gain_dbi: 0.0 };
    let (plain, _) = pulse(&scene, &tracks, index);
    // Both ports of the receiver together: their bases differ between the patterns.
    let power = |c: &ScattererPaths| c.amplitude[0][0].norm_sqr() + c.amplitude[2][0].norm_sqr();
    let sign = (paths.amplitude[0][0] / plain.amplitude[0][0]).re.signum();
    let ours = sign * (power(&paths) / power(&plain)).sqrt();
    scene.radar.receivers[0].antenna.pattern = Pattern::Rectangle { width_m: 4.0, height_m: 1.0 };
    let emission = scene.radar.emissions.emission(scene.start, index);
    let around = Surroundings { tracks: &tracks, frame: &scene.frame, start: scene.start };
    let mount = &scene.radar.receivers[0].antenna;
    let antenna = Antenna::open(&mount.pattern, wavelength_m).unwrap();
    let from = tracks[1].truth.state(emission.plus(record.target_delay_s[0])).unwrap().position;
    let epoch = Point::new(0.0, 0.0, 0.0) - from;
    let gain_at = |s: f64| {
        let frame = around.antenna_frame(mount, level(), [emission.plus(s); 2]).unwrap();
        antenna.field_gain(frame.inverse() * (epoch * epoch.norm().recip())).re
    };
    let (exact, stale) = (gain_at(record.target_delay_s[0]), gain_at(0.0));
    println!("receive gain: {ours:.9}, at reception {exact:.9}, at emission {stale:.9}");
    // What is linear about the interpolation leaves (w T)^2 / 8 = 3e-9 rad, times pi a / lambda = 420
    // per radian, of the peak gain.
    let peak = (4.0 * std::f64::consts::PI * 4.0).sqrt() / wavelength_m;
    assert!((ours - exact).abs() < 1.3e-6 * peak);
    assert!((stale - exact).abs() > 1e-3 * peak);
}

/// Two receivers: each pair has its own delays, channels their own pairs.
#[test]
fn pairs_have_their_own_delays() {
    let mut scene = scene();
    scene.radar.direct_path = true;
    let mut second = scene.radar.receivers[0].clone();
    second.name = "monostatic".into();
    second.antenna.platform = 0;
    scene.radar.receivers.push(second);
    let mut more = scene.radar.channels.clone();
    more.iter_mut().for_each(|channel| channel.receiver = 1);
    scene.radar.channels.extend(more);
    let tracks =
        [straight(&scene, [-4e3, 0.0, 3e3], [0.0; 3]), straight(&scene, [0.0, -600.0, 800.0], [0.0; 3])];
    let generator = PathGenerator::new(&scene, PULSE_S, tracks.to_vec()).unwrap();
    assert_eq!(generator.channel_pairs(), [0, 0, 0, 0, 1, 1, 1, 1]);
    let (paths, record) = evaluate(&scene, &generator, 3);
    assert_eq!(paths.len(), 2);
    let c = 299_792_458.0;
    assert!((record.target_delay_s[0] * c - 6e3).abs() < 1e-8);
    assert!((record.target_delay_s[1] * c - 10e3).abs() < 1e-8);
    // A receiver in the transmitter's phase centre has no direct path.
    assert!(paths.amplitude[0][1].norm() > 0.0 && paths.amplitude[4][1].norm() == 0.0);
    assert_eq!(paths.delay_s[1][1], 0.0);
}

#[test]
fn pulses_do_not_depend_on_what_was_asked_before() {
    let (scene, tracks) = from_space();
    let generator = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
    let mut workspace = generator.workspace();
    let (mut paths, mut record) = buffers(&scene);
    for index in [3999, 7, 8, 2500, 0] {
        generator.pulse(index, &mut workspace, &mut paths, &mut record).unwrap();
        assert_eq!((paths.clone(), record.clone()), evaluate(&scene, &generator, index));
    }
    let outside = generator.pulse(4000, &mut workspace, &mut paths, &mut record);
    assert!(matches!(outside, Err(RadarError::NoSuchPulse { index: 4000, pulses: 4000 })));
}

#[test]
fn the_record_holds_both_tracks() {
    let mut scene = scene();
    scene.radar.receivers[0].antenna.lever_arm = Vector::new(1.0, 2.0, -3.0);
    let truth = Track::fixed(Point::new(1e3, 0.0, 500.0), level());
    let reported =
        Track::fixed(Point::new(1001.0, 0.0, 500.0), Rotation::from_yaw_pitch_roll(0.01, 0.0, 0.0));
    let tracks = [straight(&scene, [-4e3, 0.0, 3e3], [0.0; 3]), PlatformTracks { truth, reported }];
    let (_, record) = pulse(&scene, &tracks, 222);
    assert_eq!((record.index, record.time), (222, scene.start.plus(1.0)));
    assert_eq!(record.nav_true[1].position_m, [1e3, 0.0, 500.0]);
    assert_eq!(record.nav_reported[1].position_m, [1001.0, 0.0, 500.0]);
    assert_ne!(record.nav_true[1].attitude_quat, record.nav_reported[1].attitude_quat);
    // Forward is north, starboard east, down negative up.
    let centre = record.antennas[1].phase_centre_m;
    assert!(
        (Point::<nereus::frames::Enu>::from_raw(centre.into()) - point([1002.0, 1.0, 503.0])).norm() < 1e-12
    );
}

#[test]
fn a_scene_that_does_not_hang_together_is_refused_with_all_faults() {
    let mut scene = scene();
    scene.radar.channels[1].transmitter = 4;
    scene.radar.receivers[0].antenna.platform = 9;
    scene.radar.carrier_hz = f64::NAN;
    scene.radar.tx_polarisation = TxPolarisation::Alternating(vec![]);
    scene.radar.transmitters[0].antenna.pattern = Pattern::File { path: "none.csv".into(), floor_dbi: -60.0 };
    let Err(RadarError::Faults(faults)) = PathGenerator::new(&scene, PULSE_S, vec![]) else { panic!() };
    let all: Vec<String> = faults.iter().map(ToString::to_string).collect();
    assert_eq!(faults.len(), 6, "{all:#?}");
    assert!(faults.iter().any(|f| matches!(f, RadarFault::Missing { what: "transmitter", index: 4, .. })));
    assert!(all.iter().any(|f| f.contains("none.csv")));
}
