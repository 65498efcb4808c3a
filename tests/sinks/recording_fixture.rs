//! A header and pulses whose every value follows from the pulse index, in Rust and in Python.

#[cfg(feature = "hdf5")]
use std::path::Path;
use std::process::Command;

use num_complex::Complex32;

use nereus::files::FileFault;
use nereus::pulse::{Layout, PlatformRecord, Pulse, SampleFormat, Samples};
use nereus::recording::header::{AdcRow, ChannelRow, Header, Origin, PairRow};
use nereus::recording::instrument::{AntennaRow, FilterRow, Instrument, Look, WaveformRow};
#[cfg(feature = "hdf5")]
use nereus::recording::verify::{Ending, Verdict, verify};
use nereus::sinks::sink::SinkError;
use nereus::time::{PulseTimes, TimeTag};

pub const PRF_HZ: f64 = 333.3;

pub fn header(format: SampleFormat) -> Header {
    let channel = |name: &str| ChannelRow {
        name: name.to_owned(),
        transmitter: "mast".to_owned(),
        receiver: "pod".to_owned(),
        polarisations: name.to_owned(),
        transmit_basis: "local-horizontal".to_owned(),
        receive_basis: "ludwig-3".to_owned(),
    };
    Header {
        software: "nereus test".to_owned(),
        carrier_hz: 10e9,
        sample_rate_hz: 100e6,
        bandwidth_hz: 80e6,
        pulse_s: 1e-6,
        prf_hz: PRF_HZ,
        channels: vec![channel("HH"), channel("HV")],
        pairs: vec![PairRow { transmitter: "mast".to_owned(), receiver: "pod".to_owned() }],
        origin: Some(Origin { lat_deg: 53.5, lon_deg: -6.25, h_m: 12.5 }),
        seed: 42,
        config: "# a scenario\n[radar]\nname = \"é\"\n".to_owned(),
        replica: (0..7).map(|k| Complex32::new(k as f32, -0.5 * k as f32)).collect(),
        instrument: None,
        platforms: vec!["tower".to_owned(), "aircraft".to_owned()],
        transmitters: vec!["mast".to_owned()],
        receivers: vec!["pod".to_owned()],
        targets: vec!["buoy".to_owned(), "ship".to_owned(), "rock".to_owned()],
        ships: vec!["tug".to_owned(), "tow".to_owned()],
        clocks: vec!["tx".to_owned()],
        layout: Layout {
            channels: 2,
            samples: 50,
            format,
            platforms: 2,
            antennas: 2,
            targets: 3,
            pairs: 1,
            windows: 0,
            ships: 2,
            clocks: 1,
        },
        adc: (format == SampleFormat::Ci16).then_some(AdcRow { bits: 12, step: 2.5e-8 }),
        start: TimeTag::from_iso8601("2018-05-30T20:15:00.25Z").unwrap(),
        first_pulse: 0,
        pulses: 100,
        shard: None,
        truth: true,
        changes: None,
    }
}

/// A radar of the antennas of [`header`].
pub fn instrument() -> Instrument {
    let text = str::to_owned;
    Instrument {
        waveform: WaveformRow {
            kind: text("lfm"),
            sweep_hz_per_s: Some(-8e13),
            rate_hz: None,
            pulses: Vec::new(),
        },
        filter: FilterRow { kind: text("raised-cosine"), flat_hz: 40e6, zero_hz: 50e6 },
        earth_radius_factor: Some(4.0 / 3.0),
        window: Some(Look::Point { position_m: [1.5, 2.0, -3.0], velocity_mps: [0.1, 0.2, 0.3] }),
        continuous: false,
        middle_m: [100.0, -200.0],
        antennas: vec![
            AntennaRow {
                name: text("mast"),
                transmits: true,
                platform: text("tower"),
                lever_arm_m: [0.3, -0.7, -12.1],
                pattern: text("isotropic"),
                aperture_m: None,
                look: Look::Body { yaw_rad: 0.5, pitch_rad: -0.25, roll_rad: 0.125 },
                window: None,
            },
            AntennaRow {
                name: text("pod"),
                transmits: false,
                platform: text("aircraft"),
                lever_arm_m: [1.1, 0.2, 0.9],
                pattern: text("rectangle"),
                aperture_m: Some([4.0, 0.05]),
                look: Look::Beside { platform: text("aircraft"), along_m: 5.0, across_m: -3000.0 },
                window: None,
            },
        ],
        dechirp_s: None,
        emitters: Vec::new(),
        error_classes_db: vec![-60.0, -45.5, -30.0],
    }
}

/// Pulse `n`: the value of element k of any field is a multiple of 1/8, so all types hold it exactly.
pub fn pulse(header: &Header, n: u64) -> Pulse {
    let mut pulse = Pulse::new(&header.layout);
    fill(&mut pulse, header, n);
    pulse
}

pub fn fill(pulse: &mut Pulse, header: &Header, n: u64) {
    let value = |k: usize| (n * 1000 + k as u64) as f64 / 8.0;
    pulse.index = n;
    pulse.time = PulseTimes::uniform(PRF_HZ).unwrap().emission(header.start, n);
    pulse.window_start_s = value(1);
    // Each 6.25 us after the one before it.
    for (receiver, start_s) in pulse.receiver_window_start_s.iter_mut().enumerate() {
        *start_s = pulse.window_start_s + 6.25e-6 * receiver as f64;
    }
    // The bits of the ADC and of the window: a loaded machine may add LATE.
    pulse.flags = ((n % 3) << 2) as u32;
    pulse.tx_pol = (n % 2) as u8 + 1;
    match &mut pulse.samples {
        Samples::Cf32(v) => {
            v.iter_mut()
                .enumerate()
                .for_each(|(k, s)| *s = Complex32::new((n % 4096) as f32 + k as f32 / 128.0, -(k as f32)));
        }
        Samples::Ci16(v) => {
            v.iter_mut().enumerate().for_each(|(k, s)| *s = [((n + k as u64) % 2048) as i16, -(k as i16)]);
        }
    }
    let record = |base: usize| PlatformRecord {
        position_m: [value(base), value(base + 1), value(base + 2)],
        velocity_mps: [value(base + 3), value(base + 4), value(base + 5)],
        attitude_quat: [value(base + 6), value(base + 7), value(base + 8), value(base + 9)],
        age_s: value(base + 10),
        flags: base as u32,
    };
    for p in 0..pulse.nav_true.len() {
        pulse.nav_true[p] = record(100 + 20 * p);
        pulse.nav_reported[p] = record(200 + 20 * p);
    }
    for (a, antenna) in pulse.antennas.iter_mut().enumerate() {
        antenna.phase_centre_m = [value(300 + 3 * a), value(301 + 3 * a), value(302 + 3 * a)];
        antenna.boresight_quat = std::array::from_fn(|i| value(320 + 4 * a + i));
        antenna.reported_phase_centre_m = std::array::from_fn(|i| value(340 + 3 * a + i));
    }
    for antenna in header.scanning() {
        pulse.antennas[antenna].encoder_deg = Some([(n % 360) as f64, value(antenna)]);
    }
    for k in 0..pulse.target_delay_s.len() {
        pulse.target_delay_s[k] = if k == 1 { f64::NAN } else { value(400 + k) };
        pulse.target_doppler_hz[k] = value(500 + k);
    }
    for s in 0..pulse.ship_heading_deg.len() {
        let base = 600 + 10 * s;
        pulse.ship_position_m[s] = [value(base), value(base + 1), value(base + 2)];
        pulse.ship_velocity_mps[s] = [value(base + 3), value(base + 4), value(base + 5)];
        pulse.ship_heading_deg[s] = value(base + 6);
    }
    if let Some(x_s) = pulse.clock_x_s.first_mut() {
        *x_s = value(700);
    }
}

/// Python that checks every column of a recording against the same formulas. Needs `rec`, `first`, `count`.
pub const CHECK: &str = r#"
def check(rec, first, count):
    assert rec.pulses == count, (rec.pulses, count)
    if count == 0:
        return
    n = np.arange(first, first + count)
    value = lambda *k: (n[:, None] * 1000 + np.array(k)) / 8.0
    same = lambda c, want: np.testing.assert_array_equal(np.asarray(rec[c][:count]), want, err_msg=c)
    same("pulse/index", n)
    same("pulse/window_start_s", value(1)[:, 0])
    flags = np.asarray(rec["pulse/flags"][:count])
    np.testing.assert_array_equal(flags & 12, n % 3 * 4)
    same("pulse/tx_pol", n % 2 + 1)
    from fractions import Fraction
    ns, frac = rec.emission()
    start = Fraction(1527711300250000000)
    for i in (0, count - 1):
        exact = start + Fraction(int(n[i])) * 10**9 / Fraction(333.3)
        # 1e-7 ns: the fraction of a second is an f64, 1.1e-16 s.
        assert abs(float(Fraction(int(ns[i])) + Fraction(float(frac[i])) - exact)) < 3e-7, i
        assert 0 <= frac[i] < 1
    k = np.arange(100)
    iq = np.asarray(rec["iq"][:count])
    if iq.dtype.kind == "c":
        assert iq.dtype == np.complex64
        want = ((n % 4096)[:, None] + k / 128.0 - 1j * k).astype(np.complex64)
        np.testing.assert_array_equal(iq, want.reshape(count, 2, 50))
    else:
        if iq.dtype.names:
            iq = np.stack([iq["r"], iq["i"]], -1)
        want = np.stack([(n[:, None] + k) % 2048, np.broadcast_to(-k, (count, 100))], -1)
        np.testing.assert_array_equal(iq, want.reshape(count, 2, 50, 2))
        assert rec.meta["adc_step"] == 2.5e-8 and rec.meta["adc_bits"] == 12
        np.testing.assert_allclose(rec.samples(0, 1)[0, 0, 3].real, (first + 3 + 0.5) * 2.5e-8, rtol=1e-6)
    for which, base in (("true", 100), ("reported", 200)):
        for p, name in enumerate(("tower", "aircraft")):
            b = base + 20 * p
            position, velocity, attitude = rec.nav(name, which)
            np.testing.assert_array_equal(position, value(b, b + 1, b + 2))
            np.testing.assert_array_equal(velocity, value(b + 3, b + 4, b + 5))
            np.testing.assert_array_equal(attitude, value(b + 6, b + 7, b + 8, b + 9))
            same(f"nav/{name}/{which}/age_s", value(b + 10)[:, 0])
            same(f"nav/{name}/{which}/flags", n * 0 + b)
    same("truth/clock/tx/x_s", value(700)[:, 0])
    same("nav/mast/phase_centre_m", value(300, 301, 302))
    same("nav/pod/phase_centre_m", value(303, 304, 305))
    same("nav/mast/boresight_quat", value(320, 321, 322, 323))
    same("nav/pod/boresight_quat", value(324, 325, 326, 327))
    same("nav/mast/reported_phase_centre_m", value(340, 341, 342))
    same("nav/pod/reported_phase_centre_m", value(343, 344, 345))
    delay = value(400, 401, 402); delay[:, 1] = np.nan
    same("truth/delay_s", delay[:, None, :])
    same("truth/doppler_hz", value(500, 501, 502)[:, None, :])
    place = value(600, 601, 602, 610, 611, 612).reshape(count, 2, 3)
    same("truth/ship_position_m", place)
    same("truth/ship_velocity_mps", place + 3 / 8)
    same("truth/ship_heading_deg", value(606, 616))
    position, velocity, heading = rec.ship("tow")
    np.testing.assert_array_equal(position, place[:, 1])
    np.testing.assert_array_equal(velocity, place[:, 1] + 3 / 8)
    np.testing.assert_array_equal(heading, value(616)[:, 0])
    np.testing.assert_array_equal(np.asarray(rec["replica"][:]), np.arange(7) * np.complex64(1 - 0.5j))
    m = rec.meta
    assert (m["format"], m["version"], m["software"], m["seed"]) == ("nereus", 1, "nereus test", 42), m
    assert (m["carrier_hz"], m["sample_rate_hz"], m["bandwidth_hz"], m["pulse_s"], m["prf_hz"]) == (10e9, 100e6, 80e6, 1e-6, 333.3)
    assert (m["origin_lat_deg"], m["origin_lon_deg"], m["origin_h_m"]) == (53.5, -6.25, 12.5)
    assert list(m["channels"]) == ["HH", "HV"], m["channels"]
    assert m["config"] == '# a scenario\n[radar]\nname = "é"\n', m["config"]
    assert m["start_time_ns"] == 1527711300250000000
"#;

/// Runs Python with `reader` and `check` at hand. `None` (and a word on stdout) when numpy, or h5py
/// where it is needed, is not there.
pub fn python(needs_h5py: bool, script: &str) -> Option<String> {
    let imports = if needs_h5py { "import numpy, h5py" } else { "import numpy" };
    let there = Command::new("python3").args(["-c", imports]).output();
    if !there.is_ok_and(|o| o.status.success()) {
        println!("skipped: python3 cannot {imports}");
        return None;
    }
    // The one file alone, as it may be copied: nothing beside it can be imported.
    let reader = concat!(env!("CARGO_MANIFEST_DIR"), "/python/nereus/reader.py");
    let text = format!(
        "import sys; sys.dont_write_bytecode = True\n\
         import numpy as np, json, os, time, importlib.util\n\
         spec = importlib.util.spec_from_file_location('reader', {reader:?})\n\
         reader = importlib.util.module_from_spec(spec); spec.loader.exec_module(reader)\n{CHECK}\n{script}\n"
    );
    let output = Command::new("python3").args(["-c", &text]).output().unwrap();
    let out = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{script}\n{out}\n{}", String::from_utf8_lossy(&output.stderr));
    Some(out)
}

/// What `verify` finds of a recording that is closed, as soon as no child has inherited its lock: see
/// [`unlocked`].
#[cfg(feature = "hdf5")]
pub fn verified(path: &Path) -> Verdict {
    for _ in 0..600 {
        match verify(path).unwrap() {
            Verdict { ending: Ending::Growing, .. } => {
                std::thread::sleep(std::time::Duration::from_millis(50))
            }
            verdict => return verdict,
        }
    }
    panic!("{}: locked for 30 s", path.display());
}

/// Tries again while a file is in use. Tests run side by side: a child that another one starts while the HDF5
/// library has a file open inherits its lock.
pub fn unlocked<R>(mut make: impl FnMut() -> Result<R, SinkError>) -> R {
    for _ in 0..200 {
        match make() {
            Err(SinkError::File(FileFault::InUse { .. })) => {}
            Err(SinkError::File(FileFault::Kept { why, at, .. }))
                if matches!(*why, FileFault::InUse { .. }) =>
            {
                std::fs::remove_file(at).unwrap();
            }
            made => return made.unwrap(),
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    panic!("locked for 10 s");
}
