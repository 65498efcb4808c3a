//! A scene built in Rust instead of TOML, and its pulses read off the ring as they are released.
//!
//! ```text
//! cargo run --release --example scene_in_rust
//! ```
//!
//! An aircraft passes a buoy at 100 m/s; the example compresses each twentieth pulse with the replica and
//! prints where the echo is strongest, beside where the buoy is.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::config::Run;
use nereus::frames::{Earth, Point, Rotation, SceneFrame, Vector};
use nereus::motion::PlatformNav;
use nereus::nav::Place;
use nereus::nav::TrackSource;
use nereus::pipeline::build;
use nereus::pulse::{Pulse, Samples};
use nereus::scene::radar::{
    Aim, AimFrom, AntennaMount, Channel, Gate, Pattern, Pointing, Polarisation, PortErrors, Radar, Receiver,
    Sweep, Transmitter, Waveform, Window,
};
use nereus::scene::{Scene, Target};
use nereus::time::{PulseTimes, TimeTag};
use nereus::transport::{Pace, Policy, Settings};
use nereus::units::SPEED_OF_LIGHT_MPS;
use num_complex::Complex32;

const SAMPLE_RATE_HZ: f64 = 100e6;
const WINDOW_START_S: f64 = 27.5e-6;

fn scene() -> Result<Scene, Box<dyn Error>> {
    let aircraft = 0;
    let antenna = AntennaMount {
        platform: aircraft,
        lever_arm: Vector::new(0.0, 0.0, 1.5),
        of_array: Vector::ZERO,
        pattern: Pattern::Rectangle { width_m: 0.4, height_m: 0.05 },
        pointing: Pointing::At {
            aim: Aim::Beside { platform: aircraft, along_m: 0.0, across_m: 3000.0 },
            aim_from: AimFrom::Reported,
            lag_s: 0.0,
            bias_rad: [0.0, 0.0],
        },
        ports: PortErrors::default(),
    };
    let vv =
        Channel { name: "VV".into(), transmitter: 0, receiver: 0, tx: Polarisation::V, rx: Polarisation::V };
    Ok(Scene {
        frame: SceneFrame::plain(Earth::Flat),
        start: TimeTag::from_iso8601("2026-01-01T00:00:00Z")?,
        pulses: 200,
        seed: 1,
        platforms: vec!["aircraft".into()],
        radar: Radar {
            noise_figure_db: Some(4.0),
            transmitters: vec![Transmitter { name: "tx".into(), power_w: 1000.0, antenna: antenna.clone() }],
            receivers: vec![Receiver { name: "rx".into(), antenna, gate: None }],
            channels: vec![vv],
            ..Radar::new(
                10e9,
                SAMPLE_RATE_HZ,
                Waveform::Lfm { bandwidth_hz: 60e6, duration_s: 0.333e-6, sweep: Sweep::Up },
                PulseTimes::uniform(200.0)?,
                Window { samples: 256, gate: Gate::Fixed { start_s: WINDOW_START_S } },
            )
        },
        sea: None,
        ships: Vec::new(),
        // The track runs North; its starboard side is East.
        targets: vec![Target::new(
            "buoy",
            Point::new(3000.0, 50.0, 0.0),
            Vector::ZERO,
            Target::sphere(100.0),
        )],
    })
}

/// The sample at which the correlation with the replica is strongest.
fn strongest(iq: &[Complex32], replica: &[Complex32]) -> usize {
    let correlation = |lag: usize| -> f32 {
        iq[lag..].iter().zip(replica).map(|(s, q)| s * q.conj()).sum::<Complex32>().norm_sqr()
    };
    (0..iq.len()).max_by(|a, b| correlation(*a).total_cmp(&correlation(*b))).unwrap_or(0)
}

fn show(pulse: &Pulse, replica: &[Complex32]) {
    let Samples::Cf32(iq) = &pulse.samples else { return };
    if !pulse.index.is_multiple_of(20) {
        return;
    }
    let range = |delay_s: f64| 0.5 * SPEED_OF_LIGHT_MPS * delay_s;
    println!(
        "pulse {:3} at {}: echo at {:.1} m, buoy at {:.1} m, Doppler {:6.1} Hz",
        pulse.index,
        pulse.time,
        range(pulse.window_start_s + strongest(iq, replica) as f64 / SAMPLE_RATE_HZ),
        range(pulse.target_delay_s[0]),
        pulse.target_doppler_hz[0],
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let run = Run {
        start_live: false,
        start_now: false,
        scene: scene()?,
        nav: vec![PlatformNav {
            truth: TrackSource::Straight {
                place: Place::Local(Point::new(0.0, 0.0, 3000.0)),
                velocity: Vector::new(0.0, 100.0, 0.0),
                attitude: Some(Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0)),
            },
            reported: None,
            errors: None,
            gusts: None,
        }],
        clocks: nereus::scene::clock::Clocks::default(),
        calibration: Vec::new(),
        events: Vec::new(),
        control: false,
        shard: None,
        relax_db: Vec::new(),
        monitor: None,
        fidelity: nereus::echo::Fidelity::Reference,
        stream: Settings {
            pace: Pace::Realtime,
            policy: Policy::Stop,
            latency_s: 0.1,
            ring_slots: 64,
            threads: 0,
            ..Settings::default()
        },
        sinks: Vec::new(),
        text: String::new(),
        path: PathBuf::new(),
        warnings: Vec::new(),
    };
    let stream = build::stream(&run, 0..run.scene.pulses)?;
    let replica = stream.factory().replica();
    let outcome = stream.tap(&Arc::new(AtomicBool::new(false)), |pulse| show(pulse, &replica))?;
    outcome.result?;
    println!("{} pulses, {} late", outcome.summary.health.pulses, outcome.summary.health.late);
    Ok(())
}
