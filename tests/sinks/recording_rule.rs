//! The rule of outputs: nothing is lost, and nobody else's file is touched.

use std::fs;
use std::path::{Path, PathBuf};

use nereus::files::FileFault;
use nereus::pulse::SampleFormat;
use nereus::sinks::nav::{Messages, NavSettings};
use nereus::sinks::plain::PlainSink;
use nereus::sinks::port::{Device, Port};
use nereus::sinks::sink::{Sink, SinkError, SinkReport};
use nereus::sinks::{Kind, Settings, preflight};

use crate::listing::listing;
use crate::recording_fixture::{header, pulse};

fn plain(path: &Path, force: bool, pulses: u64) -> Box<PlainSink> {
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(PlainSink::create(path, force, &header).unwrap());
    (0..pulses).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
    sink
}

/// Why a complete recording is not in its place, and where it is.
fn kept(finished: Result<SinkReport, SinkError>) -> (FileFault, PathBuf) {
    match finished {
        Err(SinkError::File(FileFault::Kept { why, at, .. })) => (*why, at),
        other => panic!("{other:?}"),
    }
}

/// Pulses that the index of a plain recording has.
fn indices(path: &Path) -> u64 {
    fs::metadata(path.join("pulse/index.bin")).unwrap().len() / 8
}

#[test]
fn a_plain_recording_is_replaced_only_when_the_new_one_is_complete() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    plain(&path, false, 7).finish().unwrap();
    let mut new = plain(&path, true, 3);
    new.flush().unwrap();
    assert_eq!(indices(&path), 7);
    // A run that ends without its end keeps both.
    drop(new);
    assert_eq!((indices(&path), listing(dir.path()).len()), (7, 2));
    let mut begun = plain(&path, true, 2);
    begun.abandon();
    assert_eq!((indices(&path), listing(dir.path()).len()), (7, 2));
    plain(&path, true, 3).finish().unwrap();
    assert_eq!((indices(&path), listing(dir.path()).len()), (3, 2));
    // Two that want the same free name: one gets it.
    let (first, second) = (dir.path().join("a"), header(SampleFormat::Cf32));
    let holder = plain(&first, false, 1);
    assert!(matches!(
        PlainSink::create(&first, false, &second),
        Err(SinkError::File(FileFault::Exists { .. }))
    ));
    assert!(matches!(
        PlainSink::create(&first, true, &second),
        Err(SinkError::File(FileFault::InUse { .. }))
    ));
    holder.finish().unwrap();
}

#[test]
fn a_folder_with_somebodys_files_is_no_recording_to_overwrite() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    let header = header(SampleFormat::Cf32);
    plain(&path, false, 7).finish().unwrap();
    for notes in ["notes.txt", "nav/notes.txt"] {
        fs::write(path.join(notes), "dear diary").unwrap();
        assert!(matches!(
            PlainSink::create(&path, true, &header),
            Err(SinkError::File(FileFault::Foreign { .. }))
        ));
        assert_eq!(fs::read_to_string(path.join(notes)).unwrap(), "dear diary");
        fs::remove_file(path.join(notes)).unwrap();
    }
    // Notes that come while the new recording grows.
    let new = plain(&path, true, 3);
    fs::write(path.join("notes.txt"), "dear diary").unwrap();
    let (why, at) = kept(new.finish());
    assert!(matches!(why, FileFault::Foreign { .. }) && indices(&at) == 3, "{why}");
    assert_eq!(
        (indices(&path), fs::read_to_string(path.join("notes.txt")).unwrap().as_str()),
        (7, "dear diary")
    );
    // A `meta.json` that names files elsewhere.
    let trap = dir.path().join("trap");
    fs::create_dir(&trap).unwrap();
    fs::write(trap.join("meta.json"), r#"{"format": "nereus", "columns": {"../letter": {}}}"#).unwrap();
    fs::write(dir.path().join("letter.bin"), "mine").unwrap();
    plain(&trap, true, 1).finish().unwrap();
    assert_eq!(fs::read_to_string(dir.path().join("letter.bin")).unwrap(), "mine");
}

#[test]
fn a_file_of_messages_replaces_only_one_of_its_kind() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("out.nmea");
    let device = Device::of(&format!("file:{}", path.display()), 4800).unwrap();
    let look = |force| {
        let settings = NavSettings {
            device: device.clone(),
            platform: 0,
            messages: Messages::Nmea(vec!["GGA"]),
            rate_hz: 1.0,
            latency_s: 0.0,
            force,
        };
        preflight(&[Settings::new(Kind::Nav(settings), 1)])
    };
    fs::write(&path, "a thesis").unwrap();
    assert!(matches!(look(true)[..], [SinkError::File(FileFault::Foreign { .. })]));
    assert!(Port::open(device.clone(), true).is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "a thesis");
    fs::write(&path, "$GPGGA,old*00\r\n").unwrap();
    assert!(look(true).is_empty() && matches!(look(false)[..], [SinkError::File(FileFault::Exists { .. })]));
    let mut port = Port::open(device, true).unwrap();
    port.send(b"$GPHDT,274.5,T*37\r\n");
    // Not before it is complete.
    assert!(fs::read_to_string(&path).unwrap().starts_with("$GPGGA,old"));
    port.finish(std::time::Duration::ZERO).unwrap();
    assert!(fs::read_to_string(&path).unwrap().starts_with("$GPHDT"));
    assert_eq!(listing(dir.path()), ["out.nmea"]);
}

#[cfg(feature = "hdf5")]
mod hdf5 {
    use nereus::recording::RecordingError;
    use nereus::recording::merge::{MergeError, merge};
    use nereus::recording::verify::{Ending, verify};
    use nereus::sinks::hdf5::Hdf5Sink;

    use super::*;
    use crate::recording_fixture::{unlocked, verified};
    use crate::recording_hdf5::record;

    fn pulses(path: &Path) -> u64 {
        verify(path).unwrap().pulses
    }

    #[test]
    fn a_segment_never_takes_a_strangers_name() {
        let dir = tempfile::tempdir().unwrap();
        let header = header(SampleFormat::Cf32);
        let mut sink = Hdf5Sink::create(&dir.path().join("rec.h5"), Some(0.1), false, &header).unwrap();
        (0..34).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        let stranger = dir.path().join("rec_0001.h5");
        fs::write(&stranger, "a thesis").unwrap();
        let refused = sink.write(&pulse(&header, 34)).unwrap_err();
        assert!(
            matches!(&refused, SinkError::File(FileFault::Exists { path }) if *path == stranger),
            "{refused}"
        );
        assert_eq!(fs::read_to_string(&stranger).unwrap(), "a thesis");
        assert_eq!(sink.readable(), Some(34));
        assert_eq!(listing(dir.path()), ["rec_0000.h5", "rec_0001.h5"]);
    }

    #[test]
    fn an_old_recording_stays_until_the_new_one_is_complete() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let header = header(SampleFormat::Cf32);
        record(&path, None, &header, 0, 70);
        let mut sink = Box::new(unlocked(|| Hdf5Sink::create(&path, None, true, &header)));
        (0..10).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        sink.flush().unwrap();
        assert_eq!(pulses(&path), 70);
        // What a run that fails elsewhere leaves: both, and the report says where.
        let closed = sink.close().unwrap();
        let kept = closed.keep();
        assert_eq!((pulses(&path), pulses(&kept.files[0])), (70, 10));
        let (path_text, at) = (path.display(), kept.files[0].display());
        let note = format!(
            "{path_text}: kept as it was; 10 pulses of this run are in {at}: to use them, put it in the place of {path_text}"
        );
        assert_eq!(kept.notes(), [note]);
        let mut sink = Box::new(unlocked(|| Hdf5Sink::create(&path, None, true, &header)));
        sink.abandon();
        assert_eq!((pulses(&path), listing(dir.path()).len()), (70, 2));
        let mut sink = Box::new(unlocked(|| Hdf5Sink::create(&path, None, true, &header)));
        (0..10).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        assert_eq!(sink.finish().unwrap().files, std::slice::from_ref(&path));
        assert_eq!((pulses(&path), verified(&path).whole), (10, true));
    }

    #[test]
    fn merge_replaces_only_a_recording_that_nobody_writes() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        let header = header(SampleFormat::Cf32);
        let shards = [at("a.h5"), at("b.h5")];
        record(&shards[0], None, &header, 0, 20);
        record(&shards[1], None, &header, 20, 40);
        let out = at("out.h5");
        fs::write(&out, "a thesis").unwrap();
        let refused = merge(&shards, &out, true).unwrap_err();
        assert!(
            matches!(refused, MergeError::Recording(RecordingError::File(FileFault::Foreign { .. }))),
            "{refused}"
        );
        assert_eq!(fs::read_to_string(&out).unwrap(), "a thesis");
        fs::remove_file(&out).unwrap();
        let mut growing = Box::new(Hdf5Sink::create(&out, None, false, &header).unwrap());
        growing.write(&pulse(&header, 0)).unwrap();
        let refused = merge(&shards, &out, true).unwrap_err();
        assert!(
            matches!(refused, MergeError::Recording(RecordingError::File(FileFault::InUse { .. }))),
            "{refused}"
        );
        growing.finish().unwrap();
        assert_eq!(pulses(&out), 1);
        unlocked(|| match merge(&shards, &out, true) {
            Err(MergeError::Recording(fault)) => Err(fault.into()),
            merged => Ok(merged.unwrap()),
        });
        assert_eq!((pulses(&out), listing(dir.path()).len()), (40, 3));
    }

    #[test]
    fn foreign_hdf5_is_not_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("results.h5");
        let file = ::hdf5::File::create(&path).unwrap();
        file.new_attr::<f64>().create("temperature").unwrap().write_scalar(&20.0).unwrap();
        file.close().unwrap();
        let before = fs::read(&path).unwrap();
        let refused = Hdf5Sink::create(&path, None, true, &header(SampleFormat::Cf32)).unwrap_err();
        assert!(matches!(refused, SinkError::File(FileFault::Foreign { .. })), "{refused}");
        assert_eq!(fs::read(&path).unwrap(), before);
    }

    #[test]
    fn a_damaged_sample_is_seen_and_found() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let header = header(SampleFormat::Cf32);
        record(&path, None, &header, 0, 300);
        let whole = verified(&path);
        assert!(whole.whole && whole.ending == Ending::Closed, "{whole:?}");
        assert_eq!((whole.pulses, whole.first, whole.last, whole.dropped), (300, Some(0), Some(299), 0));
        // One bit of a sample of pulse 100: its value is 100 + k / 128 - i k.
        let mut bytes = fs::read(&path).unwrap();
        let wanted: Vec<u8> = (10..20)
            .flat_map(|k| [100.0 + k as f32 / 128.0, -(k as f32)])
            .flat_map(f32::to_le_bytes)
            .collect();
        let at = bytes.windows(wanted.len()).position(|window| window == wanted).unwrap();
        bytes[at] ^= 1;
        fs::write(&path, bytes).unwrap();
        let damaged = verified(&path);
        assert!(!damaged.whole && damaged.faults == 1, "{damaged:?}");
        assert!(damaged.findings[0].place.starts_with("/iq, rows 0.."), "{damaged:?}");
    }

    /// What `verify` finds of recordings that grow, were killed, were cut, or lack pulses.
    #[test]
    fn what_is_not_whole_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let header = header(SampleFormat::Cf32);
        let path = dir.path().join("rec.h5");
        let mut sink = Box::new(Hdf5Sink::create(&path, None, false, &header).unwrap());
        (0..20).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        sink.flush().unwrap();
        let growing = verify(&path).unwrap();
        assert_eq!((growing.whole, growing.ending, growing.pulses), (false, Ending::Growing, 20));
        // A copy has the mark of the writer and no lock, as after a kill.
        let copy = dir.path().join("copy.h5");
        fs::copy(&path, &copy).unwrap();
        let killed = verify(&copy).unwrap();
        assert_eq!((killed.whole, killed.ending, killed.pulses), (false, Ending::WriterLost, 20));
        // Pulses that no flag explains.
        (25..30).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        sink.finish().unwrap();
        let gap = verified(&path);
        assert_eq!(gap.findings.len(), 1, "{gap:?}");
        assert!(gap.findings[0].what.contains("pulses 20..25 are missing"), "{gap:?}");
        // Half a file.
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(!verify(&path).unwrap().whole);
        // A plain recording whose columns differ in length, and one with no number in it.
        let folder = dir.path().join("rec");
        plain(&folder, false, 9).finish().unwrap();
        assert!(verify(&folder).unwrap().whole);
        let iq = folder.join("iq.bin");
        let mut samples = fs::read(&iq).unwrap();
        samples[800..804].copy_from_slice(&f32::NAN.to_le_bytes());
        fs::write(&iq, &samples).unwrap();
        let odd = verify(&folder).unwrap();
        assert!(odd.faults == 1 && odd.findings[0].what.contains("1 values are not finite"), "{odd:?}");
        fs::write(&iq, &samples[..samples.len() - 3]).unwrap();
        let cut = verify(&folder).unwrap();
        assert!(cut.findings.iter().any(|f| f.what == "8 rows and 797 bytes of one more"), "{cut:?}");
        assert!(verify(Path::new("nowhere")).is_err());
    }
}
