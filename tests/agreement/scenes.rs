//! Small scenes, built in Rust.

use nereus::frames::{Earth, Enu, Point, SceneFrame, Vector};
use nereus::motion::PlatformTracks;
use nereus::motion::track::Track;
use nereus::scene::radar::{
    AntennaMount, Channel, Gate, Pattern, Pointing, Polarisation, Receiver, Sweep, Transmitter, Waveform,
    Window,
};
use nereus::scene::{Radar, Scene, Target};
use nereus::time::{PulseTimes, TimeTag};

/// An end of the path: where at pulse 0, how fast.
#[derive(Clone, Copy)]
pub struct End {
    pub position_m: [f64; 3],
    pub velocity_mps: [f64; 3],
}

impl End {
    pub fn at(self, t_s: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.position_m[i] + self.velocity_mps[i] * t_s)
    }
}

/// Gain of both isotropic antennas, dBi.
pub const GAIN_DBI: f64 = 20.0;
pub const CARRIER_HZ: f64 = 10e9;
pub const RATE_HZ: f64 = 100e6;
pub const BANDWIDTH_HZ: f64 = 60e6;
pub const PULSE_S: f64 = 2e-6;
pub const POWER_W: f64 = 50.0;

fn mount(platform: usize) -> AntennaMount {
    AntennaMount {
        platform,
        lever_arm: Vector::ZERO,
        of_array: Vector::ZERO,
        pattern: Pattern::Isotropic { gain_dbi: GAIN_DBI },
        pointing: Pointing::Fixed { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 },
        ports: nereus::scene::radar::PortErrors::default(),
    }
}

/// One transmitter, one receiver and spheres, noiseless, HH and VV.
pub fn scene(window_start_s: f64, samples: usize, prf_hz: f64, pulses: u64, targets: &[(End, f64)]) -> Scene {
    let channel =
        |name: &str, pol| Channel { name: name.into(), transmitter: 0, receiver: 0, tx: pol, rx: pol };
    Scene {
        frame: SceneFrame::plain(Earth::Flat),
        start: TimeTag::new(1_700_000_000, 0.25),
        pulses,
        seed: 11,
        platforms: vec!["tx".into(), "rx".into()],
        radar: Radar {
            losses_db: 3.0,
            transmitters: vec![Transmitter { name: "t".into(), power_w: POWER_W, antenna: mount(0) }],
            receivers: vec![Receiver { name: "r".into(), antenna: mount(1), gate: None }],
            channels: vec![channel("HH", Polarisation::H), channel("VV", Polarisation::V)],
            ..Radar::new(
                CARRIER_HZ,
                RATE_HZ,
                Waveform::Lfm { bandwidth_hz: BANDWIDTH_HZ, duration_s: PULSE_S, sweep: Sweep::Up },
                PulseTimes::uniform(prf_hz).unwrap(),
                Window { samples, gate: Gate::Fixed { start_s: window_start_s } },
            )
        },
        sea: None,
        ships: Vec::new(),
        targets: targets
            .iter()
            .enumerate()
            .map(|(i, (end, rcs_m2))| {
                let position = Point::from_raw(end.position_m.into());
                let velocity = Vector::from_raw(end.velocity_mps.into());
                Target::new(format!("t{i}"), position, velocity, Target::sphere(*rcs_m2))
            })
            .collect(),
    }
}

/// Straight tracks for the two platforms.
pub fn tracks(scene: &Scene, tx: End, rx: End) -> Vec<PlatformTracks> {
    [tx, rx]
        .into_iter()
        .map(|end| {
            let position: Point<Enu> = Point::from_raw(end.position_m.into());
            let velocity: Vector<Enu> = Vector::from_raw(end.velocity_mps.into());
            let level = nereus::frames::Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
            let truth = Track::straight(position, scene.start, velocity, Some(level));
            PlatformTracks { reported: truth.clone(), truth }
        })
        .collect()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let n = dot(a, a).sqrt();
    a.map(|x| x / n)
}

/// `e_r^T S e_t` of a unit sphere for isotropic antennas: H level, across the direction from the antenna, V
/// upward; in the bases h = z x k, v = h x k of the wave fronts.
pub fn polarisation_factor(tx: &[f64; 3], in_flight: &[f64; 3], rx: &[f64; 3], channel: usize) -> f64 {
    let up = [0.0, 0.0, 1.0];
    let components = |k: [f64; 3], from_antenna: [f64; 3]| {
        let level = unit(cross(up, from_antenna));
        let e = if channel == 0 { level } else { cross(from_antenna, level) };
        let h = unit(cross(up, k));
        let v = cross(h, k);
        [dot(v, e), dot(h, e)]
    };
    let incident = unit(std::array::from_fn(|i| in_flight[i] - tx[i]));
    let scattered = unit(std::array::from_fn(|i| rx[i] - in_flight[i]));
    let t = components(incident, incident);
    let r = components(scattered, scattered.map(|c| -c));
    r[0] * t[0] - r[1] * t[1]
}
