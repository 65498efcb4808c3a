//! Recordings of a point in one- and two-ended geometries, made by the library.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::config;
use nereus::geometry::phase_path::PhasePath;
use nereus::pipeline::build;
use nereus::processor::backproject::{Aperture, PulseEcho};
use nereus::processor::range_compress::{Compressor, PulseShape, RangeFilter, oversampling};
use nereus::processor::taper::Taper;
use nereus::recording::Recording;

pub const CARRIER_HZ: f64 = 10e9;
pub const BAND_HZ: f64 = 60e6;
/// `B Tc` = 240: the side lobes of the sweep's own response are -13.26 dB and a little less (see the tests).
pub const PULSE_S: f64 = 4e-6;
pub const C_MPS: f64 = 299_792_458.0;
/// Phase of the target's scattering matrix, rad.
pub const PHASE_RAD: f64 = 0.7;
/// Where the target is, m.
pub const TARGET_M: [f64; 3] = [21.3, -17.6, 0.0];

/// An end of the path at pulse 0.
#[derive(Clone, Copy)]
pub struct End {
    pub position_m: [f64; 3],
    pub velocity_mps: [f64; 3],
}

impl End {
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.position_m[i] + self.velocity_mps[i] * t_s)
    }
}

#[derive(Clone, Copy)]
pub struct Geometry {
    pub name: &'static str,
    pub transmitter: End,
    pub receiver: End,
    pub prf_hz: f64,
    pub pulses: u64,
}

const fn end(position_m: [f64; 3], velocity_mps: [f64; 3]) -> End {
    End { position_m, velocity_mps }
}

/// One aircraft; two on parallel and on crossing courses; a mast on the coast and an aircraft; two
/// satellites.
pub const GEOMETRIES: [Geometry; 5] = [
    Geometry {
        name: "one aircraft",
        transmitter: end([-27.0, -3000.0, 3000.0], [222.0, 0.0, 0.0]),
        receiver: end([-27.0, -3000.0, 3000.0], [222.0, 0.0, 0.0]),
        prf_hz: 500.0,
        pulses: 120,
    },
    Geometry {
        name: "parallel",
        transmitter: end([-27.0, -6000.0, 3000.0], [222.0, 0.0, 0.0]),
        receiver: end([-27.0, -3000.0, 3000.0], [222.0, 0.0, 0.0]),
        prf_hz: 500.0,
        pulses: 120,
    },
    Geometry {
        name: "crossing",
        transmitter: end([-27.0, -3000.0, 3000.0], [222.0, 0.0, 0.0]),
        receiver: end([-4000.0, 24.0, 3500.0], [0.0, -200.0, 3.0]),
        prf_hz: 500.0,
        pulses: 120,
    },
    Geometry {
        name: "coast and aircraft",
        transmitter: end([300.0, -3000.0, 15.0], [0.0, 0.0, 0.0]),
        receiver: end([-54.0, -3000.0, 3000.0], [222.0, 0.0, 0.0]),
        prf_hz: 400.0,
        pulses: 192,
    },
    Geometry {
        name: "orbit",
        transmitter: end([-462_000.0, -800.0, 800_000.0], [0.0, 7500.0, 0.0]),
        receiver: end([-470_000.0, 2200.0, 801_000.0], [0.0, 7498.0, -2.0]),
        prf_hz: 1800.0,
        pulses: 400,
    },
];

impl Geometry {
    pub fn scenario(&self, more_radar: &str, lever_arms: [[f64; 3]; 2]) -> String {
        let [s_re, s_im] = [PHASE_RAD.cos(), PHASE_RAD.sin()].map(|x| 30.0 * x);
        let duration_s = self.pulses as f64 / self.prf_hz - 0.5 / self.prf_hz;
        let (tx, rx) = (self.transmitter, self.receiver);
        format!(
            r#"
[scene]
duration_s = {duration_s:?}
[radar]
carrier_hz = {CARRIER_HZ:?}
sample_rate_hz = 100e6
prf_hz = {:?}
channels = ["HH", "HV", "VH", "VV"]
{more_radar}
[radar.waveform]
kind = "lfm"
bandwidth_hz = {BAND_HZ:?}
pulse_s = {PULSE_S:?}
[radar.window]
samples = 768
follow = {{ kind = "at", position_m = [0.0, 0.0, 0.0], lead_us = 1.7 }}
[[platform]]
name = "a"
track = {{ kind = "straight", position_m = {:?}, velocity_mps = {:?}, yaw_deg = 40.0 }}
[[platform]]
name = "b"
track = {{ kind = "straight", position_m = {:?}, velocity_mps = {:?}, yaw_deg = -70.0 }}
[[transmitter]]
name = "t"
platform = "a"
power_w = 100.0
lever_arm_m = {:?}
antenna = {{ kind = "isotropic" }}
[[receiver]]
name = "r"
platform = "b"
lever_arm_m = {:?}
antenna = {{ kind = "isotropic" }}
[[target]]
name = "point"
position_m = {TARGET_M:?}
s_hh = [{s_re:?}, {s_im:?}]
s_vv = [{:?}, {:?}]
s_hv = [{:?}, {:?}]
s_vh = [{:?}, {:?}]
[stream]
pace = "fast"
threads = 1
[[sink]]
kind = "plain"
path = "unused"
"#,
            self.prf_hz,
            tx.position_m,
            tx.velocity_mps,
            rx.position_m,
            rx.velocity_mps,
            lever_arms[0],
            lever_arms[1],
            0.8 * s_re,
            0.8 * s_im,
            0.5 * s_re,
            0.5 * s_im,
            0.6 * s_re,
            0.6 * s_im,
        )
    }

    /// A recording of it.
    pub fn record(&self, more_radar: &str, lever_arms: [[f64; 3]; 2]) -> Recording {
        record(&self.scenario(more_radar, lever_arms))
    }
}

pub fn record(scenario: &str) -> Recording {
    record_and(scenario, |path| Recording::open(path, None).unwrap())
}

/// Records into a plain folder that goes away afterwards.
pub fn record_and<T>(scenario: &str, read: impl FnOnce(&Path) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording");
    let out = format!("{:?}", path.to_str().unwrap());
    let change = [("sink.0.path".to_owned(), out)];
    let run = config::parse(scenario, Path::new("test.toml"), &change).unwrap();
    let stream = build::stream(&run, 0..run.scene.pulses).unwrap();
    stream.run(&Arc::new(AtomicBool::new(false)), None).unwrap().result.unwrap();
    read(&path)
}

pub fn compressor(recording: &Recording, filter: RangeFilter, taper: Taper) -> Compressor {
    let header = &recording.header;
    let shape = PulseShape::of(header);
    let cells = oversampling(header.bandwidth_hz, header.sample_rate_hz, -60.0);
    Compressor::new(shape, header.layout.samples, filter, taper, cells).unwrap()
}

/// The pulses of a channel.
pub fn aperture<'a>(
    recording: &'a Recording,
    compressor: &'a Compressor,
    [transmitter, receiver]: [&'a PhasePath; 2],
    channel: usize,
) -> Aperture<'a> {
    Aperture {
        carrier_hz: recording.header.carrier_hz,
        compressor,
        transmitter,
        receiver,
        pulses: (0..recording.pulses())
            .filter(|pulse| recording.is_illuminated(*pulse, channel))
            .map(|pulse| PulseEcho {
                emission_s: recording.emission_s[pulse],
                number: recording.index[pulse],
                window_start_s: recording.window_start_s[pulse],
                weight: 1.0,
                samples: recording.window(pulse, channel),
            })
            .collect(),
        centre_m: [0.0; 3],
        gate: None,
    }
}
