//! Recordings as SigMF: samples read back, and what SigMF's own tools say (Python package `sigmf`).

use std::fs;
use std::path::Path;
use std::process::Command;

use nereus::pulse::{SampleFormat, Samples};
use nereus::recording::header::Header;
use nereus::recording::sigmf::{Exported, Settings, export};
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use serde_json::Value;

use crate::listing::listing as names;
use crate::recording_fixture::{header, instrument, pulse, unlocked};

const PULSES: u64 = 30;

/// A plain recording of some pulses.
fn recorded(folder: &Path, format: SampleFormat) -> Header {
    let header = Header { instrument: Some(instrument()), ..header(format) };
    let mut sink = Box::new(unlocked(|| PlainSink::create(&folder.join("rec"), false, &header)));
    for n in 10..10 + PULSES {
        sink.write(&pulse(&header, n)).unwrap();
    }
    sink.finish().unwrap();
    header
}

fn exported(folder: &Path, settings: Settings) -> Result<Exported, String> {
    let settings = Settings { out: folder.join("out"), ..settings };
    export(&folder.join("rec"), &settings).map_err(|error| error.to_string())
}

/// The bytes that the samples of a channel have in SigMF.
fn bytes(header: &Header, channel: usize, pulses: std::ops::Range<u64>) -> Vec<u8> {
    let window = channel * header.layout.samples..(channel + 1) * header.layout.samples;
    let of = |n: u64| match pulse(header, n).samples {
        Samples::Cf32(all) => all[window.clone()]
            .iter()
            .flat_map(|z| [z.re, z.im])
            .flat_map(f32::to_le_bytes)
            .collect::<Vec<_>>(),
        Samples::Ci16(all) => {
            all[window.clone()].as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect()
        }
    };
    pulses.flat_map(of).collect()
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// A Python that has `sigmf`: that of the project, or the machine's.
fn python(script: &str, arguments: &[&Path]) -> Option<String> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/target/python-venv/bin/python");
    let has = |python: &&str| {
        let there = Command::new(python).args(["-c", "import sigmf, numpy"]).output();
        there.is_ok_and(|ended| ended.status.success())
    };
    let Some(python) = [own, "python3"].into_iter().find(has) else {
        println!("skipped: no python3 with sigmf and numpy (tools/python installs them)");
        return None;
    };
    let ended = Command::new(python).args(["-c", script]).args(arguments).output().unwrap();
    let (out, error) = (String::from_utf8_lossy(&ended.stdout), String::from_utf8_lossy(&ended.stderr));
    assert!(ended.status.success(), "{out}{error}");
    Some(out.into_owned())
}

#[test]
fn samples_are_read_back_bit_for_bit() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let folder = tempfile::tempdir().unwrap();
        let header = recorded(folder.path(), format);
        let report = exported(folder.path(), Settings::default()).unwrap();
        let datatype = if format == SampleFormat::Cf32 { "cf32_le" } else { "ci16_le" };
        assert_eq!((report.pulses, report.samples, report.datatype), (30, 30 * 50, datatype));
        assert_eq!(report.channels, ["HH", "HV"]);
        let files = [
            "out-HH.sigmf-data",
            "out-HH.sigmf-meta",
            "out-HV.sigmf-data",
            "out-HV.sigmf-meta",
            "out.sigmf-collection",
            "rec",
        ];
        assert_eq!(names(folder.path()), files);
        assert_eq!(report.out.len(), 5);
        for (place, name) in ["HH", "HV"].into_iter().enumerate() {
            let data = fs::read(folder.path().join(format!("out-{name}.sigmf-data"))).unwrap();
            assert!(data == bytes(&header, place, 10..40), "{name}");
            let meta = read(&folder.path().join(format!("out-{name}.sigmf-meta")));
            let global = &meta["global"];
            assert_eq!(
                (&global["core:datatype"], &global["core:sample_rate"]),
                (&datatype.into(), &1e8.into())
            );
            assert_eq!(global["nereus:channel"]["name"], name);
            assert_eq!(global["nereus:instrument"]["antennas"][1]["name"], "pod");
            let captures = meta["captures"].as_array().unwrap();
            assert_eq!((captures.len(), &captures[0]["core:frequency"]), (1, &1e10.into()));
            // Pulse 10 leaves 10/333.3 s after 20:15:00.25; its window opens 1250.125 s later.
            assert_eq!(captures[0]["core:datetime"], "2018-05-30T20:35:50.405003000Z");
            let annotations = meta["annotations"].as_array().unwrap();
            assert_eq!(annotations.len(), 30);
            for (n, of) in annotations.iter().enumerate() {
                assert_eq!(
                    (&of["core:sample_start"], &of["core:sample_count"]),
                    (&(n * 50).into(), &50.into())
                );
                assert_eq!(of["nereus:pulse"], n + 10);
                let sent = pulse(&header, n as u64 + 10);
                let ns = i128::from(of["nereus:emission_ns"].as_i64().unwrap());
                assert_eq!(ns, i128::from(sent.time.to_unix_ns().0));
                assert_eq!(of["nereus:window_start_s"], sent.window_start_s);
                assert_eq!(of["nereus:flags"], sent.flags);
                assert_eq!(
                    of["nereus:receiver_enu_m"],
                    serde_json::json!(sent.antennas[1].reported_phase_centre_m)
                );
            }
            assert_eq!(annotations[0]["core:label"], "pulse 10");
            let comment = annotations[1]["core:comment"].as_str().unwrap();
            assert!(
                comment.starts_with("emitted 2018-05-30T20:15:00.283003")
                    && comment.ends_with("; echo outside the window"),
                "{comment}"
            );
            // Some 4 km from the origin, on the ellipsoid.
            let [lon, lat, h] =
                [0, 1, 2].map(|k| captures[0]["core:geolocation"]["coordinates"][k].as_f64().unwrap());
            assert!(
                (lon + 6.25).abs() < 0.05 && (lat - 53.5).abs() < 0.05 && (1000.0..2000.0).contains(&h),
                "{lon} {lat} {h}"
            );
        }
    }
}

#[test]
fn one_channel_and_some_pulses_are_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let header = recorded(folder.path(), SampleFormat::Cf32);
    let settings = Settings { channels: vec!["HV".to_owned()], pulses: Some(15..18), ..Settings::default() };
    let report = exported(folder.path(), settings).unwrap();
    assert_eq!(
        (report.pulses, names(folder.path())),
        (3, ["out.sigmf-data", "out.sigmf-meta", "rec"].map(String::from).to_vec())
    );
    assert!(fs::read(folder.path().join("out.sigmf-data")).unwrap() == bytes(&header, 1, 15..18));
}

/// The schema, the hashes and the lengths by `sigmf_validate`; the samples by its reader, through the
/// collection.
#[test]
fn the_tools_of_sigmf_take_it() {
    let script = r#"
import os, sys, numpy as np, sigmf, sigmf.validate
folder, raw = sys.argv[1:]
metas = [os.path.join(folder, f"out-{name}.sigmf-meta") for name in ("HH", "HV")]
sys.argv = ["sigmf_validate", *metas]
try:
    sigmf.validate.main()
except SystemExit as ended:
    assert not ended.code, ended.code
collection = sigmf.fromfile(os.path.join(folder, "out.sigmf-collection"))
collection.verify_stream_hashes()
assert collection.get_stream_names() == ["out-HH", "out-HV"], collection.get_stream_names()
wanted = np.fromfile(raw, np.int16).reshape(2, 30, 50, 2)
for place, name in enumerate(collection.get_stream_names()):
    recording = collection.get_SigMFFile(stream_name=name)
    recording.validate()
    recording = sigmf.fromfile(os.path.join(folder, name + ".sigmf-meta"), autoscale=False)
    assert recording.sample_count == 1500 and len(recording.get_captures()) == 1
    spans = [recording.get_annotations(index=i * 50)[0] for i in range(30)]
    assert [span["nereus:pulse"] for span in spans] == list(range(10, 40))
    samples = recording.read_samples()
    if samples.dtype.kind == "c":
        samples = np.stack([samples.real, samples.imag], -1)
    found = samples.reshape(30, 50, 2)
    assert np.array_equal(found, wanted[place])
print("whole")
"#;
    let folder = tempfile::tempdir().unwrap();
    let header = recorded(folder.path(), SampleFormat::Ci16);
    exported(folder.path(), Settings::default()).unwrap();
    let raw = folder.path().join("raw");
    fs::write(&raw, [bytes(&header, 0, 10..40), bytes(&header, 1, 10..40)].concat()).unwrap();
    let Some(out) = python(script, &[folder.path(), &raw]) else { return };
    assert!(out.ends_with("whole\n"), "{out}");
    // A changed sample is found: the hash is that of the data.
    let data = folder.path().join("out-HH.sigmf-data");
    let mut changed = fs::read(&data).unwrap();
    changed[77] ^= 1;
    fs::write(&data, changed).unwrap();
    let check = "import sys, sigmf\ntry:\n    sigmf.fromfile(sys.argv[1])\nexcept sigmf.error.SigMFFileError:\n    print('found')";
    assert_eq!(python(check, &[&folder.path().join("out-HH.sigmf-meta")]).unwrap(), "found\n");
}

#[test]
fn nothing_is_left_of_what_cannot_be_exported() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), SampleFormat::Cf32);
    let only = |settings: Settings, words: &str| {
        let refused = exported(folder.path(), settings).unwrap_err();
        assert!(refused.contains(words), "{refused}");
        assert_eq!(names(folder.path()), ["rec"]);
    };
    let channel = |name: &str| Settings { channels: vec![name.to_owned()], ..Settings::default() };
    only(channel("VV"), "has no channel VV; allowed: HH, HV");
    only(Settings { pulses: Some(90..95), ..Settings::default() }, "holds pulses 10..40, none of 90..95");
    // Samples cut short: the last block cannot be read.
    let iq = folder.path().join("rec/iq.bin");
    let whole = fs::read(&iq).unwrap();
    fs::write(&iq, &whole[..whole.len() - 8]).unwrap();
    only(Settings::default(), "iq");
    fs::write(&iq, &whole).unwrap();
    // A column of pulses cut short, which is found when samples have been written.
    let flags = folder.path().join("rec/pulse/flags.bin");
    let all = fs::read(&flags).unwrap();
    fs::write(&flags, &all[..40]).unwrap();
    only(Settings::default(), "flags");
    fs::write(&flags, &all).unwrap();
    // Pulses that do not ascend.
    let index = folder.path().join("rec/pulse/index.bin");
    let numbers = fs::read(&index).unwrap();
    fs::write(&index, [&numbers[8..16], &numbers[..8], &numbers[16..]].concat()).unwrap();
    only(Settings::default(), "pulse 10 comes after pulse 11");
    fs::write(&index, &numbers).unwrap();
    // An instant that does not ascend, and windows that open at no time or ages later.
    for (name, row, value, words) in [
        ("time_ns", 20, 0_i64.to_le_bytes(), "pulse 30 leaves"),
        ("time_frac_ns", 29, f64::NAN.to_le_bytes(), "pulse 39 leaves NaN s"),
        ("window_start_s", 3, f64::NAN.to_le_bytes(), "pulse/window_start_s of pulse 13 is NaN"),
        ("window_start_s", 3, 1e300_f64.to_le_bytes(), "pulse/window_start_s of pulse 13 is 1e300"),
    ] {
        let column = folder.path().join(format!("rec/pulse/{name}.bin"));
        let all = fs::read(&column).unwrap();
        let mut damaged = all.clone();
        damaged[8 * row..8 * row + 8].copy_from_slice(&value);
        fs::write(&column, damaged).unwrap();
        only(Settings::default(), words);
        fs::write(&column, all).unwrap();
    }
    // No recording, and something else of that name.
    fs::write(folder.path().join("rec/meta.json"), "{}").unwrap();
    only(Settings::default(), "meta.json is not that of a nereus recording");
}

#[test]
fn what_is_there_stays_unless_it_is_an_export() {
    let folder = tempfile::tempdir().unwrap();
    let header = recorded(folder.path(), SampleFormat::Cf32);
    let all = |force: bool| exported(folder.path(), Settings { force, ..Settings::default() });
    all(false).unwrap();
    assert!(all(false).unwrap_err().contains("exists already"));
    all(true).unwrap();
    let data = folder.path().join("out-HH.sigmf-data");
    assert!(fs::read(&data).unwrap() == bytes(&header, 0, 10..40));
    // Samples of somebody else, by their metadata.
    fs::write(folder.path().join("out-HH.sigmf-meta"), "{\"global\":{\"core:datatype\":\"cf32_le\"}}")
        .unwrap();
    fs::write(&data, "theirs").unwrap();
    let refused = all(true).unwrap_err();
    assert!(refused.contains("not overwritten, because it is no SigMF file of this program"), "{refused}");
    assert_eq!(fs::read(&data).unwrap(), b"theirs");
    assert_eq!(names(folder.path()).len(), 6);
}
