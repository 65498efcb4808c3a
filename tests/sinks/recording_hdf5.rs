use std::path::{Path, PathBuf};

use hdf5::File;
use num_complex::{Complex, Complex32};

use nereus::files::FileFault;
use nereus::pulse::{Layout, SampleFormat, Samples};
use nereus::recording::RecordingError;
use nereus::recording::header::Header;
use nereus::sinks::hdf5::{CHUNK_PULSES, Hdf5Sink};
use nereus::sinks::sink::{FLUSH_INTERVAL, Sink, SinkError, SinkReport};

use crate::recording_fixture::{header, pulse, python, unlocked};

pub fn record(path: &Path, segment_s: Option<f64>, header: &Header, from: u64, to: u64) -> SinkReport {
    let mut sink = Box::new(Hdf5Sink::create(path, segment_s, false, header).unwrap());
    for n in from..to {
        sink.write(&pulse(header, n)).unwrap();
    }
    sink.finish().unwrap()
}

#[test]
fn every_column_comes_back() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let header = header(format);
        let report = record(&path, None, &header, 7, 107);
        assert_eq!((report.pulses, report.files), (100, vec![path.clone()]));

        let file = File::open(&path).unwrap();
        let iq = file.dataset("iq").unwrap();
        assert_eq!(iq.shape(), [100, 2, 50]);
        assert!(iq.is_resizable() && iq.chunk().unwrap()[0] >= CHUNK_PULSES);
        match format {
            SampleFormat::Cf32 => {
                let got = iq.read_raw::<Complex32>().unwrap();
                let want = (7..107).flat_map(|n| match pulse(&header, n).samples {
                    Samples::Cf32(v) => v,
                    Samples::Ci16(_) => unreachable!(),
                });
                assert!(got.into_iter().eq(want));
            }
            SampleFormat::Ci16 => {
                let got = iq.read_raw::<Complex<i16>>().unwrap();
                let want = (7..107).flat_map(|n| match pulse(&header, n).samples {
                    Samples::Ci16(v) => v,
                    Samples::Cf32(_) => unreachable!(),
                });
                assert!(got.into_iter().map(|c| [c.re, c.im]).eq(want));
            }
        }
        let index = file.dataset("pulse/index").unwrap().read_raw::<u64>().unwrap();
        assert_eq!(index, (7..107).collect::<Vec<_>>());
        drop(file);
        python(
            true,
            &format!(
                r#"
rec = reader.open_recording({path:?})
assert rec.state == "closed", rec.state
check(rec, 7, 100)
reader.show(reader.summary(rec))
import h5py
f = rec.file
t = f["channel"]
assert t.dtype.names == ("name", "transmitter", "receiver", "polarisations"), t.dtype
assert [c.decode() for c in t["name"]] == ["HH", "HV"] and t[1]["receiver"] == b"pod"
assert list(f.attrs["transmit_basis"]) == ["local-horizontal"] * 2, list(f.attrs["transmit_basis"])
assert list(f.attrs["receive_basis"]) == ["ludwig-3"] * 2
assert [c.decode() for c in f["truth/targets"][:]] == ["buoy", "ship", "rock"]
assert [c.decode() for c in f["truth/ships"][:]] == ["tug", "tow"]
assert f["truth/pairs"]["transmitter"][0] == b"mast"
assert isinstance(f.attrs["config"], str) and isinstance(f.attrs["format"], str)
assert f["iq"].maxshape[0] is None and f["iq"].chunks[0] >= 16
"#
            ),
        );
    }
}

#[test]
fn a_scene_with_nothing_but_samples() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bare.h5");
    let full = header(SampleFormat::Cf32);
    let bare = Header {
        layout: Layout {
            platforms: 0,
            antennas: 0,
            targets: 0,
            pairs: 0,
            ships: 0,
            clocks: 0,
            ..full.layout
        },
        pairs: Vec::new(),
        origin: None,
        replica: Vec::new(),
        platforms: Vec::new(),
        transmitters: Vec::new(),
        receivers: Vec::new(),
        targets: Vec::new(),
        ships: Vec::new(),
        clocks: Vec::new(),
        config: String::new(),
        ..full
    };
    record(&path, None, &bare, 0, 3);
    assert_eq!(File::open(&path).unwrap().dataset("iq").unwrap().shape()[0], 3);
    python(
        true,
        &format!(
            "rec = reader.open_recording({path:?}); reader.show(reader.summary(rec)); assert rec.pulses == 3"
        ),
    );
}

#[test]
fn a_long_window_is_cut_into_chunks_the_library_takes() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("long.h5");
    let mut long = header(SampleFormat::Cf32);
    long.layout.samples = 200_001;
    record(&path, None, &long, 0, 2);
    let file = File::open(&path).unwrap();
    let iq = file.dataset("iq").unwrap();
    let chunk = iq.chunk().unwrap();
    assert!(chunk[0] >= CHUNK_PULSES && chunk.iter().product::<usize>() * 8 <= 4 << 20, "{chunk:?}");
    let got = iq.read_raw::<Complex32>().unwrap();
    let want = (0..2).flat_map(|n| match pulse(&long, n).samples {
        Samples::Cf32(v) => v,
        Samples::Ci16(_) => unreachable!(),
    });
    assert!(got.into_iter().eq(want));
}

#[test]
fn readers_follow_while_it_grows() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec.h5");
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(Hdf5Sink::create(&path, None, false, &header).unwrap());
    let mut next = 0;
    let mut looks = Vec::new();
    // Ends of the flushes fall inside chunks, on their ends, and beyond several.
    for upto in [0, 5, 64, 70, 300, 301] {
        while next < upto {
            sink.write(&pulse(&header, next)).unwrap();
            next += 1;
        }
        sink.flush().unwrap();
        let seen = python(
            true,
            &format!(
                "rec = reader.open_recording({path:?}); assert rec.state != 'closed'; check(rec, 0, rec.pulses); print(rec.pulses)"
            ),
        );
        looks.extend(seen.map(|s| s.trim().parse::<u64>().unwrap() == upto));
    }
    sink.finish().unwrap();
    assert!(looks.iter().all(|&good| good), "{looks:?}");
    python(
        true,
        &format!("rec = reader.open_recording({path:?}); assert rec.state == 'closed'; check(rec, 0, 301)"),
    );
}

#[test]
fn one_reader_refreshes_while_it_grows() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec.h5");
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(Hdf5Sink::create(&path, None, false, &header).unwrap());
    sink.write(&pulse(&header, 0)).unwrap();
    sink.flush().unwrap();
    let reader = std::thread::spawn({
        let path = path.clone();
        move || {
            python(
                true,
                &format!(
                    "rec = reader.open_recording({path:?}); begun = time.monotonic(); seen = set()\n\
                     while rec.pulses < 700 and time.monotonic() - begun < 20:\n\
                     \x20   rec.refresh(); check(rec, 0, rec.pulses); seen.add(rec.pulses); time.sleep(0.02)\n\
                     assert rec.pulses == 700, rec.pulses\nprint(len(seen))"
                ),
            )
        }
    });
    let begun = std::time::Instant::now();
    for n in 1..700 {
        sink.write(&pulse(&header, n)).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(3));
    }
    // 2.1 s at one flush each half second, done by the writes themselves.
    assert!(begun.elapsed() > 3 * FLUSH_INTERVAL);
    sink.flush().unwrap();
    if let Some(lengths) = reader.join().unwrap() {
        println!("lengths seen: {lengths}");
        assert!(lengths.trim().parse::<usize>().unwrap() >= 2);
    }
    sink.finish().unwrap();
}

#[test]
fn segments_open_alone() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec.h5");
    let header = header(SampleFormat::Cf32);
    // 333.3 Hz, 0.1 s: pulses 34, 67 and 100 are the first after the cuts.
    let report = record(&path, Some(0.1), &header, 0, 110);
    let names: Vec<PathBuf> = (0..4).map(|k| dir.path().join(format!("rec_{k:04}.h5"))).collect();
    assert_eq!(report.files, names);
    assert!(!path.exists());
    let firsts = [0, 34, 67, 100, 110];
    for (k, name) in names.iter().enumerate() {
        let (first, count) = (firsts[k], firsts[k + 1] - firsts[k]);
        let index = File::open(name).unwrap().dataset("pulse/index").unwrap().read_raw::<u64>().unwrap();
        assert_eq!(index, (first..first + count).collect::<Vec<_>>());
        python(true, &format!("check(reader.open_recording({name:?}), {first}, {count})"));
    }
    // A shorter run with force leaves no segment of the longer one.
    let sink = Hdf5Sink::create(&path, Some(0.1), false, &header);
    assert!(matches!(sink, Err(SinkError::File(FileFault::Exists { .. }))));
    let mut sink = Box::new(unlocked(|| Hdf5Sink::create(&path, Some(0.1), true, &header)));
    sink.write(&pulse(&header, 0)).unwrap();
    assert_eq!(sink.finish().unwrap().files, names[..1]);
    assert!(!names[1].exists());
}

#[test]
fn what_cannot_be_made_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let header = header(SampleFormat::Cf32);
    let path = dir.path().join("rec.h5");
    std::fs::write(&path, "mine").unwrap();
    let refused = Hdf5Sink::create(&path, None, false, &header).unwrap_err();
    assert!(matches!(refused, SinkError::File(FileFault::Exists { .. })));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    let lost = dir.path().join("none/rec.h5");
    assert!(matches!(
        Hdf5Sink::create(&lost, None, false, &header),
        Err(SinkError::File(FileFault::Io { .. }))
    ));
    let mut wrong = pulse(&header, 0);
    wrong.antennas.pop();
    let mut sink = Hdf5Sink::create(&dir.path().join("b.h5"), None, false, &header).unwrap();
    let error = sink.write(&wrong).unwrap_err();
    assert!(
        matches!(error, SinkError::Recording(RecordingError::Pulse { expected: 3, found: 0, .. })),
        "{error}"
    );
}
