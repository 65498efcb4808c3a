//! The table of emitters: what recordings, the wire and SigMF say of them.

use nereus::pulse::SampleFormat;
use nereus::recording::Recording;
use nereus::recording::header::Header;
use nereus::recording::instrument::{AntennaRow, EmitterRow, GateRow, Look, WaveformRow};
use nereus::recording::plain_header;
use nereus::recording::sigmf::{Settings, export};
use nereus::recording::verify::verify;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use serde_json::Value;

use crate::recording_fixture::{header, instrument, pulse};
use crate::wire_fixture::{datagrams, kind, received_with_header, word};

const EMITTERS: u32 = 0x8000_0000;

/// A radar that another one and a jammer disturb, and whose receiver has a window of its own.
pub fn disturbed(format: SampleFormat) -> Header {
    let text = str::to_owned;
    let mut instrument = instrument();
    let look = Look::Beside { platform: text("aircraft"), along_m: 1.0, across_m: -2.0 };
    instrument.antennas[1].window = Some(GateRow::Follow { look: look.clone(), lead_s: 2e-6 });
    let radar = EmitterRow {
        antenna: AntennaRow {
            name: text("navigation"),
            transmits: true,
            platform: text("tower"),
            lever_arm_m: [0.5, 0.25, -8.0],
            pattern: text("rectangle"),
            aperture_m: Some([1.75, 0.125]),
            look,
            window: None,
        },
        waveform: WaveformRow {
            kind: text("lfm"),
            sweep_hz_per_s: Some(2e12),
            rate_hz: None,
            pulses: Vec::new(),
        },
        carrier_hz: 9.612e9,
        bandwidth_hz: 4e6,
        pulse_s: 0.25,
        start_s: -0.125,
        prf_hz: 0.75,
        intervals: 3,
        pri_s: vec![1.0, 1.25, 1.75],
        power_w: 4000.0,
        polarisation: text("V"),
        basis: text("ludwig-3"),
        receivers: vec![text("pod")],
        direct_path: true,
        echo: false,
    };
    let jammer = EmitterRow {
        antenna: AntennaRow {
            name: text("jammer"),
            pattern: text("isotropic"),
            aperture_m: None,
            ..radar.antenna.clone()
        },
        waveform: WaveformRow {
            kind: text("samples"),
            sweep_hz_per_s: None,
            rate_hz: Some(8e6),
            pulses: Vec::new(),
        },
        intervals: 1,
        pri_s: Vec::new(),
        receivers: Vec::new(),
        direct_path: false,
        echo: true,
        ..radar.clone()
    };
    instrument.emitters = vec![radar, jammer];
    Header { instrument: Some(instrument), pulses: 0, ..header(format) }
}

fn recorded(path: &std::path::Path, header: &Header, hdf5: bool) {
    let mut sink: Box<dyn Sink> = match hdf5 {
        #[cfg(feature = "hdf5")]
        true => Box::new(nereus::sinks::hdf5::Hdf5Sink::create(path, None, false, header).unwrap()),
        _ => Box::new(PlainSink::create(path, false, header).unwrap()),
    };
    (0..5).for_each(|n| sink.write(&pulse(header, n)).unwrap());
    sink.finish().unwrap();
}

fn meta(path: &std::path::Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn recordings_and_their_exports_have_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let sent = disturbed(SampleFormat::Ci16);
    for hdf5 in [false, true].into_iter().filter(|hdf5| !hdf5 || cfg!(feature = "hdf5")) {
        let path = folder.path().join(if hdf5 { "r.h5" } else { "r" });
        recorded(&path, &sent, hdf5);
        let recording = crate::recording_fixture::unlocked(|| Ok(Recording::open(&path, None).unwrap()));
        assert_eq!(recording.header.instrument, sent.instrument);
        assert_eq!(recording.header.difference(&sent), None);
        let notes = verify(&path).unwrap().notes.join("\n");
        assert!(notes.contains("emitter navigation on tower: 9612000000 Hz"), "{notes}");
        // One who made shards of another jammer is told so.
        let mut other = sent.clone();
        other.instrument.as_mut().unwrap().emitters[1].power_w = 5.0;
        assert_eq!(recording.header.difference(&other), Some("instrument"));
    }
    let settings = Settings { out: folder.path().join("out"), ..Settings::default() };
    export(&folder.path().join("r"), &settings).unwrap();
    let global = &meta(&folder.path().join("out-HV.sigmf-meta"))["global"]["nereus:instrument"]["emitters"];
    let rows: Vec<EmitterRow> = serde_json::from_value(global.clone()).unwrap();
    assert_eq!(rows, sent.emitters());
}

#[cfg(feature = "hdf5")]
#[test]
fn merged_shards_have_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let sent = disturbed(SampleFormat::Cf32);
    let parts: Vec<_> = (0..2)
        .map(|k| {
            let path = folder.path().join(format!("{k}.h5"));
            let own = Header { first_pulse: 5 * k, pulses: 5, ..sent.clone() };
            let mut sink = Box::new(nereus::sinks::hdf5::Hdf5Sink::create(&path, None, false, &own).unwrap());
            (5 * k..5 * k + 5).for_each(|n| sink.write(&pulse(&own, n)).unwrap());
            sink.finish().unwrap();
            path
        })
        .collect();
    let out = folder.path().join("whole.h5");
    crate::recording_fixture::unlocked(|| {
        nereus::recording::merge::merge(&parts, &out, true).map_err(|error| panic!("{error}"))
    });
    assert_eq!(Recording::open(&out, None).unwrap().header.instrument, sent.instrument);
}

/// Recordings of before have neither emitters nor windows of receivers, and what has none of them is written
/// as it was.
#[test]
fn recordings_of_before_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r");
    let plain = Header { instrument: Some(instrument()), ..header(SampleFormat::Cf32) };
    recorded(&path, &plain, false);
    let text = meta(&path.join("meta.json"))["instrument"].as_str().unwrap().to_owned();
    assert!(!text.contains("emitters") && text.matches("window").count() == 1, "{text}");
    let older = r#"{"waveform":{"kind":"lfm","sweep_hz_per_s":-8e13,"rate_hz":null},
        "filter":{"kind":"raised-cosine","flat_hz":40e6,"zero_hz":50e6},"earth_radius_factor":null,
        "window":null,"middle_m":[0.0,0.0],"antennas":[
        {"name":"mast","transmits":true,"platform":"tower","lever_arm_m":[0.0,0.0,0.0],"pattern":"isotropic",
         "aperture_m":null,"look":{"kind":"body","yaw_rad":0.0,"pitch_rad":0.0,"roll_rad":0.0}},
        {"name":"pod","transmits":false,"platform":"aircraft","lever_arm_m":[0.0,0.0,0.0],"pattern":"isotropic",
         "aperture_m":null,"look":{"kind":"body","yaw_rad":0.0,"pitch_rad":0.0,"roll_rad":0.0}}]}"#;
    let mut changed = meta(&path.join("meta.json"));
    changed["instrument"] = older.into();
    std::fs::write(path.join("meta.json"), changed.to_string()).unwrap();
    let recording = Recording::open(&path, None).unwrap();
    assert!(recording.header.emitters().is_empty() && recording.header.instrument.is_some());
}

/// A table that cannot be is refused by its name, whoever wrote it.
#[test]
fn hostile_tables_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let sent = disturbed(SampleFormat::Cf32);
    recorded(&folder.path().join("r"), &sent, false);
    let whole = meta(&folder.path().join("r/meta.json"));
    for (key, value, words) in [
        ("carrier_hz", "-1.0", "emitters: 'jammer': carrier, bandwidth, length, PRF and power"),
        ("prf_hz", "0.0", "emitters: 'jammer': carrier, bandwidth, length, PRF and power"),
        ("power_w", "1e300", "emitters: 'jammer': carrier, bandwidth, length, PRF and power"),
        ("start_s", "1e300", "emitters: 'jammer': a start of"),
        ("intervals", "2", "is not that of"),
        ("intervals", "0", "emitters: 'jammer': 0 intervals for 0"),
        ("pri_s", "[-1.0]", "emitters: 'jammer': 1 intervals for 1, or one that is none"),
        ("receivers", r#"["nobody"]"#, "emitters: 'jammer': the receiver 'nobody'"),
        ("polarisation", r#""""#, "emitters: 'jammer': polarisation ''"),
        ("antenna.name", r#""a/b""#, "emitters: 'a/b'"),
        ("antenna.name", r#""pod""#, "emitters: 'pod' twice"),
        ("antenna.platform", r#""moon""#, "instrument: antenna 'jammer' on 'moon'"),
        ("power_w", r#""much""#, "is not that of a nereus recording"),
    ] {
        let mut instrument: Value = serde_json::from_str(whole["instrument"].as_str().unwrap()).unwrap();
        let pointer = format!("/emitters/1/{}", key.replace('.', "/"));
        *instrument.pointer_mut(&pointer).unwrap() = serde_json::from_str(value).unwrap();
        let mut changed = whole.clone();
        changed["instrument"] = instrument.to_string().into();
        let found = plain_header(changed.to_string().as_bytes(), &[]);
        if (key, value) == ("intervals", "2") {
            // A sequence that the wire had no room for.
            assert_eq!(found.unwrap().emitters()[1].intervals, 2);
            continue;
        }
        let error = found.unwrap_err().to_string();
        assert!(error.contains(words), "{key} = {value}: {error}");
    }
}

#[test]
fn a_receiver_of_the_wire_knows_the_emitters() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let sent = disturbed(format);
        let (all, _) = datagrams(&sent, 1500, 0, 5);
        let (found, pulses, report) = received_with_header(&all);
        assert_eq!(found.unwrap().instrument, sent.instrument);
        assert_eq!((pulses.len(), report.unknown, report.malformed, report.contradictions), (5, 0, 0, 0));
        // Without one of them no pulse is taken.
        let is_lost = |datagram: &&Vec<u8>| !(kind(datagram) == 5 && word(datagram, 4) == EMITTERS + 1);
        let (found, pulses, _) = received_with_header(all.iter().filter(is_lost));
        assert_eq!((found, pulses.len()), (None, 0));
        // One who says otherwise later is not believed.
        let mut forged = all.iter().find(|datagram| !is_lost(datagram)).unwrap().clone();
        forged[28 + 8 + 3] ^= 1;
        let (found, pulses, report) = received_with_header(all.iter().chain([&forged]));
        assert_eq!((found.unwrap().instrument, pulses.len()), (sent.instrument.clone(), 5));
        assert!(report.contradictions > 0);
        // What cannot be is refused at once.
        for (at, value, words) in [
            (112, 0xbff0_0000, "such an emitter"),
            (152, 0x7ff8_0000, "a length or a frequency that is no number"),
            (176, 0, "such an emitter"),
            (180, u32::MAX, "ends"),
            (184, u32::MAX, "ends"),
        ] {
            let mut bad = all.iter().find(|datagram| !is_lost(datagram)).unwrap().clone();
            bad[28 + at..32 + at].copy_from_slice(&value.to_be_bytes());
            let fault = received_with_header([&bad]).2.first_fault.unwrap_or_default();
            assert!(fault.contains(words), "byte {at}: {fault}");
        }
    }
    // A sequence longer than a datagram is described by its mean and its length.
    let mut long = disturbed(SampleFormat::Ci16);
    let row = &mut long.instrument.as_mut().unwrap().emitters[0];
    (row.intervals, row.pri_s) = (4000, (0..4000).map(|k| 1.0 + f64::from(k % 8)).collect());
    let (found, pulses, _) = received_with_header(&datagrams(&long, 1500, 0, 5).0);
    let found = found.unwrap();
    assert_eq!((found.emitters()[0].intervals, pulses.len()), (4000, 5));
    assert!(found.emitters()[0].pri_s.is_empty() && found.emitters()[0].prf_hz == 0.75);
}
