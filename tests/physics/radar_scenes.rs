//! Scenes for the tests of geometry, link and windows.

use nereus::frames::{Body, Earth, Enu, Point, Rotation, SceneFrame, Vector};
use nereus::motion::PlatformTracks;
use nereus::motion::track::Track;
use nereus::paths::PathGenerator;
use nereus::paths::list::ScattererPaths;
use nereus::pulse::{Layout, Pulse, SampleFormat};
use nereus::scene::radar::*;
use nereus::scene::{Radar, Scene, Target};
use nereus::time::{PulseTimes, TimeTag};

pub const PULSE_S: f64 = 0.333e-6;

pub fn level() -> Rotation<Body, Enu> {
    Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0)
}

/// Isotropic antenna of 0 dBi that looks at a ground point from platform `platform`.
pub fn pointed_at(platform: usize, target: [f64; 3]) -> AntennaMount {
    AntennaMount {
        platform,
        lever_arm: Vector::ZERO,
        of_array: Vector::ZERO,
        pattern: Pattern::Isotropic { gain_dbi: 0.0 },
        pointing: Pointing::At {
            aim: Aim::Point { position: point(target), velocity: Vector::ZERO },
            aim_from: AimFrom::Reported,
            lag_s: 0.0,
            bias_rad: [0.0; 2],
        },
        ports: nereus::scene::radar::PortErrors::default(),
    }
}

pub fn point(p: [f64; 3]) -> Point<Enu> {
    Point::new(p[0], p[1], p[2])
}

pub fn vector(v: [f64; 3]) -> Vector<Enu> {
    Vector::new(v[0], v[1], v[2])
}

pub fn channels(list: &[(Polarisation, Polarisation)]) -> Vec<Channel> {
    list.iter()
        .map(|&(rx, tx)| Channel {
            name: format!("{}{}", rx.letter(), tx.letter()),
            transmitter: 0,
            receiver: 0,
            tx,
            rx,
        })
        .collect()
}

/// Transmitter on platform 0, receiver on platform 1, all four linear channels, one target at the origin
/// of 1 m^2, a long window.
pub fn scene() -> Scene {
    use Polarisation::{H, V};
    Scene {
        frame: SceneFrame::plain(Earth::Flat),
        start: TimeTag::from_iso8601("2024-05-01T12:00:00.25Z").unwrap(),
        pulses: 500,
        seed: 1,
        platforms: vec!["a".into(), "b".into()],
        radar: Radar {
            transmitters: vec![Transmitter {
                name: "tx".into(),
                power_w: 1.0,
                antenna: pointed_at(0, [0.0; 3]),
            }],
            receivers: vec![Receiver { name: "rx".into(), antenna: pointed_at(1, [0.0; 3]), gate: None }],
            channels: channels(&[(H, H), (H, V), (V, H), (V, V)]),
            ..Radar::new(
                10e9,
                100e6,
                Waveform::Lfm { bandwidth_hz: 60e6, duration_s: PULSE_S, sweep: Sweep::Up },
                PulseTimes::uniform(222.0).unwrap(),
                Window { samples: 100_000, gate: Gate::Fixed { start_s: 0.0 } },
            )
        },
        sea: None,
        ships: Vec::new(),
        targets: vec![target([0.0; 3], [0.0; 3])],
    }
}

pub fn target(position: [f64; 3], velocity: [f64; 3]) -> Target {
    Target::new("t", point(position), vector(velocity), Target::sphere(1.0))
}

pub fn straight(scene: &Scene, position: [f64; 3], velocity: [f64; 3]) -> PlatformTracks {
    same(Track::straight(point(position), scene.start, vector(velocity), Some(level())))
}

pub fn same(track: Track) -> PlatformTracks {
    PlatformTracks { truth: track.clone(), reported: track }
}

/// The scatterer paths and the record of one pulse.
pub fn pulse(scene: &Scene, tracks: &[PlatformTracks], index: u64) -> (ScattererPaths, Pulse) {
    let generator = PathGenerator::new(scene, PULSE_S, tracks.to_vec()).unwrap();
    evaluate(scene, &generator, index)
}

pub fn evaluate(scene: &Scene, generator: &PathGenerator, index: u64) -> (ScattererPaths, Pulse) {
    let mut workspace = generator.workspace();
    let (mut paths, mut record) = buffers(scene);
    generator.pulse(index, &mut workspace, &mut paths, &mut record).unwrap();
    (paths, record)
}

pub fn buffers(scene: &Scene) -> (ScattererPaths, Pulse) {
    let pairs = scene.radar.pairs().len();
    let layout = scene.radar.layout(scene.platforms.len(), scene.targets.len());
    let layout = Layout { samples: 1, format: SampleFormat::Cf32, ..layout };
    (ScattererPaths::new(pairs, layout.channels, 64), Pulse::new(&layout))
}
