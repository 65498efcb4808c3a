//! `--force`, and what other programs do meanwhile: when an older recording goes, and where the new one is if
//! it cannot.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use nereus::files::FileFault;
use nereus::pulse::SampleFormat;
use nereus::receive::listener::{Listener, Opener, Until};
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::{Sink, SinkError};

use crate::listing::listing;
use crate::recording_fixture::{header, pulse, unlocked};
use crate::wire_fixture::{datagrams, kind};

/// Opens a plain recording and writes its first pulses.
fn plain(path: &Path, force: bool, pulses: u64) -> Box<PlainSink> {
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(unlocked(|| PlainSink::create(path, force, &header)));
    (0..pulses).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
    sink
}

/// Pulses that the index of a plain recording has.
fn indices(path: &Path) -> u64 {
    fs::metadata(path.join("pulse/index.bin")).unwrap().len() / 8
}

#[test]
fn a_run_without_pulses_replaces_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    plain(&path, false, 7).finish().unwrap();
    let report = plain(&path, true, 0).finish().unwrap();
    assert_eq!((indices(&path), listing(dir.path())), (7, vec!["rec".to_owned()]));
    assert_eq!((report.files.len(), &report.kept), (0, &vec![path.clone()]));
    let note = format!("{}: not overwritten, because this run has written nothing", path.display());
    assert_eq!(report.notes(), [note]);
    // Nothing to lose: it stands as it is.
    let other = dir.path().join("other");
    let report = plain(&other, true, 0).finish().unwrap();
    assert_eq!((report.files, report.kept), (vec![other], Vec::new()));
}

#[test]
fn a_stopped_run_that_replaces_more_than_it_has_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    let notes = |pulses: u64, whole: bool| {
        let report = plain(&path, true, pulses).close().unwrap().place(whole).unwrap();
        assert_eq!((indices(&path), &report.files), (pulses, &vec![path.clone()]));
        report.notes()
    };
    assert_eq!(notes(7, false), Vec::<String>::new());
    let note = format!("{}: replaced a recording of 7 pulses by one of 3 pulses", path.display());
    assert_eq!(notes(3, false), [note]);
    // More than before, and what was meant to be as short as it is.
    assert_eq!((notes(5, false), notes(2, true)), (Vec::new(), Vec::new()));
}

#[test]
fn folders_of_somebody_are_no_recording() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    fs::create_dir_all(path.join("2025/plans")).unwrap();
    let header = header(SampleFormat::Cf32);
    let refused = PlainSink::create(&path, true, &header).unwrap_err();
    assert!(matches!(refused, SinkError::File(FileFault::Foreign { .. })), "{refused}");
    assert!(path.join("2025/plans").is_dir());
    assert_eq!(listing(dir.path()), ["rec"]);
    fs::remove_dir_all(&path).unwrap();
    plain(&path, false, 3).finish().unwrap();
    fs::create_dir(path.join("nav/plans")).unwrap();
    let refused = PlainSink::create(&path, true, &header).unwrap_err();
    assert!(matches!(refused, SinkError::File(FileFault::Foreign { .. })), "{refused}");
    assert_eq!((indices(&path), path.join("nav/plans").is_dir()), (3, true));
    // An empty folder holds nothing.
    let empty = dir.path().join("empty");
    fs::create_dir(&empty).unwrap();
    plain(&empty, true, 2).finish().unwrap();
    assert_eq!(indices(&empty), 2);
}

/// Somebody reads the old recording when the new one is complete.
#[test]
fn what_cannot_be_put_in_its_place_is_kept_and_named() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    plain(&path, false, 7).finish().unwrap();
    let mut new = plain(&path, true, 3);
    let reader = fs::File::open(path.join("meta.json")).unwrap();
    reader.lock_shared().unwrap();
    let unplaced = new.close().unwrap().place(true).unwrap_err();
    let SinkError::File(FileFault::Kept { why, at, .. }) = &unplaced.error else { panic!("{unplaced:?}") };
    assert!(matches!(**why, FileFault::InUse { .. }), "{why}");
    assert_eq!(unplaced.report.files, std::slice::from_ref(at));
    assert_eq!((indices(at), indices(&path)), (3, 7));
    let text = unplaced.error.to_string();
    assert!(text.contains(&format!("complete and stays as {}", at.display())), "{text}");
}

#[cfg(unix)]
#[test]
fn a_plain_recording_that_is_removed_is_no_success() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    let mut sink = plain(&path, false, 3);
    fs::remove_dir_all(&path).unwrap();
    let removed = sink.close().unwrap_err();
    assert!(matches!(&removed, SinkError::File(FileFault::Removed { path: at }) if *at == path), "{removed}");
    assert_eq!(sink.readable(), Some(0));
    // One of its files.
    let mut sink = plain(&path, false, 3);
    fs::remove_file(path.join("iq.bin")).unwrap();
    let removed = sink.close().unwrap_err();
    assert!(removed.to_string().contains("rec/iq.bin: removed by another program"), "{removed}");
    assert_eq!(sink.readable(), Some(0));
    // Moved: the report says where to.
    if cfg!(target_os = "linux") {
        let (here, there) = (dir.path().join("here"), dir.path().join("there"));
        let sink = plain(&here, false, 3);
        fs::rename(&here, &there).unwrap();
        assert_eq!(sink.finish().unwrap().files, std::slice::from_ref(&there));
        assert_eq!(indices(&there), 3);
    }
}

/// Only descriptions of a run arrive: an older recording is worth more.
#[test]
fn what_is_received_without_pulses_replaces_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    plain(&path, false, 7).finish().unwrap();
    let (all, _) = datagrams(&header(SampleFormat::Cf32), 1500, 0, 3);
    let listener = Listener::bind("127.0.0.1:0").unwrap();
    let address = listener.address();
    let made = path.clone();
    let receiving = thread::spawn(move || {
        let until = Until {
            duration: Some(Duration::from_secs(20)),
            idle: Some(Duration::from_millis(500)),
            pulses: None,
        };
        let open: Opener = Box::new(move |header| {
            Ok(Box::new(unlocked(|| PlainSink::create(&made, true, header))) as Box<dyn Sink>)
        });
        listener.receive(until, &AtomicBool::new(false), Some(open), |_| {}).unwrap()
    });
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    for datagram in all.iter().filter(|datagram| kind(datagram) != 1) {
        socket.send_to(datagram, address).unwrap();
    }
    let report = receiving.join().unwrap();
    assert_eq!((report.pulses, report.out), (0, Vec::<PathBuf>::new()));
    assert_eq!((indices(&path), listing(dir.path())), (7, vec!["rec".to_owned()]));
}

#[cfg(feature = "hdf5")]
mod hdf5 {
    use nereus::recording::RecordingError;
    use nereus::recording::merge::{MergeError, merge};
    use nereus::recording::verify::verify;
    use nereus::sinks::hdf5::Hdf5Sink;
    use nereus::sinks::sink::Unplaced;

    use super::*;
    use crate::recording_hdf5::record;

    fn pulses(path: &Path) -> u64 {
        verify(path).unwrap().pulses
    }

    fn opened(path: &Path, segment_s: Option<f64>, pulses: u64) -> Box<Hdf5Sink> {
        let header = header(SampleFormat::Cf32);
        let mut sink = Box::new(unlocked(|| Hdf5Sink::create(path, segment_s, true, &header)));
        (0..pulses).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        sink
    }

    #[test]
    fn older_segments_go_only_with_a_whole_run() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let names: Vec<PathBuf> = (0..4).map(|k| dir.path().join(format!("rec_{k:04}.h5"))).collect();
        record(&path, Some(0.1), &header(SampleFormat::Cf32), 0, 110);
        // Stopped before its first pulse.
        let report = opened(&path, Some(0.1), 0).finish().unwrap();
        assert_eq!((report.files.len(), &report.kept), (0, &names));
        assert!(
            report.notes()[0].contains("rec_0000.h5 and 3 more: not overwritten"),
            "{:?}",
            report.notes()
        );
        assert_eq!((pulses(&names[0]), listing(dir.path()).len()), (34, 4));
        // Stopped, or a part of the pulses.
        let report = opened(&path, Some(0.1), 10).close().unwrap().place(false).unwrap();
        assert_eq!((report.files.as_slice(), report.kept.as_slice()), (&names[..1], &names[1..]));
        assert!(
            report.notes()[0].contains("because the run was stopped or was a part"),
            "{:?}",
            report.notes()
        );
        assert_eq!((pulses(&names[0]), pulses(&names[3]), listing(dir.path()).len()), (10, 10, 4));
        // Whole.
        let report = opened(&path, Some(0.1), 40).close().unwrap().place(true).unwrap();
        assert_eq!((report.files.as_slice(), report.kept.len()), (&names[..2], 0));
        assert_eq!(listing(dir.path()), ["rec_0000.h5", "rec_0001.h5"]);
    }

    /// Before: `rec_20180509.h5` was taken for segment 20180509 and removed.
    #[test]
    fn recordings_that_are_no_segments_stay() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let header = header(SampleFormat::Cf32);
        let (flight, note) = (dir.path().join("rec_20180509.h5"), dir.path().join("rec_0008.h5"));
        record(&flight, None, &header, 0, 5);
        fs::write(&note, "a note").unwrap();
        // They stand in nobody's way: the 100 pulses of this run end in segment 2.
        unlocked(|| Hdf5Sink::create(&path, Some(0.1), false, &header)).abandon();
        record(&path, Some(0.1), &header, 0, 110);
        let report = opened(&path, Some(0.1), 40).close().unwrap().place(true).unwrap();
        assert_eq!(listing(dir.path()), ["rec_0000.h5", "rec_0001.h5", "rec_0008.h5", "rec_20180509.h5"]);
        assert_eq!((report.files.len(), report.kept.len(), pulses(&flight)), (2, 0, 5));
        let gone: Vec<PathBuf> = (2..4).map(|k| dir.path().join(format!("rec_{k:04}.h5"))).collect();
        assert_eq!(report.removed, gone);
        let note =
            format!("{} and 1 more: older, removed, because this run has no such part", gone[0].display());
        assert_eq!(report.notes(), [note]);
        // What the run itself would come upon is reported at its start.
        for k in 0..2 {
            fs::remove_file(dir.path().join(format!("rec_{k:04}.h5"))).unwrap();
        }
        let there = dir.path().join("rec_0002.h5");
        fs::rename(&flight, &there).unwrap();
        let refused = Hdf5Sink::create(&path, Some(0.1), false, &header).unwrap_err();
        assert!(
            matches!(&refused, SinkError::File(FileFault::Exists { path }) if *path == there),
            "{refused}"
        );
    }

    /// Before: it was refused when all new segments were in place, and the run failed.
    #[cfg(unix)]
    #[test]
    fn a_link_to_an_older_segment_stays() {
        let dir = tempfile::tempdir().unwrap();
        let (path, far) = (dir.path().join("rec.h5"), dir.path().join("stored.h5"));
        let names: Vec<PathBuf> = (0..4).map(|k| dir.path().join(format!("rec_{k:04}.h5"))).collect();
        record(&path, Some(0.1), &header(SampleFormat::Cf32), 0, 110);
        fs::rename(&names[3], &far).unwrap();
        std::os::unix::fs::symlink(&far, &names[3]).unwrap();
        let report = opened(&path, Some(0.1), 40).close().unwrap().place(true).unwrap();
        assert_eq!((report.files.as_slice(), report.kept.as_slice()), (&names[..2], &names[3..]));
        assert_eq!(listing(dir.path()), ["rec_0000.h5", "rec_0001.h5", "rec_0003.h5", "stored.h5"]);
        assert_eq!(pulses(&names[3]), 10);
        let notes = report.notes();
        assert!(
            notes.iter().any(|note| note.contains("rec_0003.h5: older, not removed, because it is a link"))
        );
    }

    #[test]
    fn an_empty_file_takes_no_recordings_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        record(&path, None, &header(SampleFormat::Cf32), 0, 70);
        let report = opened(&path, None, 0).finish().unwrap();
        assert_eq!((report.files.len(), report.kept, pulses(&path)), (0, vec![path.clone()], 70));
        assert_eq!(listing(dir.path()), ["rec.h5"]);
    }

    /// A segment that cannot be put in its place does not hide the others, and none of the old ones goes.
    #[test]
    fn segments_that_cannot_be_put_in_place_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let names: Vec<PathBuf> = (0..4).map(|k| dir.path().join(format!("rec_{k:04}.h5"))).collect();
        record(&path, Some(0.1), &header(SampleFormat::Cf32), 0, 110);
        let mut new = opened(&path, Some(0.1), 90);
        let reader = fs::File::open(&names[1]).unwrap();
        reader.lock_shared().unwrap();
        let Unplaced { report, error } = *new.close().unwrap().place(true).unwrap_err();
        let SinkError::File(FileFault::Kept { at, path: of, .. }) = &error else { panic!("{error}") };
        assert_eq!(of, &names[1]);
        assert_eq!(report.files, [names[0].clone(), at.clone(), names[2].clone()]);
        assert_eq!(report.kept, names[3..]);
        let note = "older, not removed, because not all new outputs could be put in place";
        assert_eq!(report.notes(), [format!("{}: {note}", names[3].display())]);
        assert_eq!(report.files.iter().map(|file| pulses(file)).collect::<Vec<_>>(), [34, 33, 23]);
        assert_eq!((pulses(&names[1]), pulses(&names[3])), (33, 10));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_removed_while_it_grows_is_no_success() {
        let dir = tempfile::tempdir().unwrap();
        let (path, stored) = (dir.path().join("rec.h5"), dir.path().join("stored.h5"));
        let mut sink = opened(&path, None, 20);
        fs::remove_file(&path).unwrap();
        let removed = sink.close().unwrap_err();
        assert!(
            matches!(&removed, SinkError::File(FileFault::Removed { path: at }) if *at == path),
            "{removed}"
        );
        assert_eq!(sink.readable(), Some(0));
        // Between the end of this sink and that of the run.
        let mut sink = opened(&path, None, 20);
        let closed = sink.close().unwrap();
        fs::remove_file(&path).unwrap();
        let unplaced = closed.place(true).unwrap_err();
        assert!(matches!(unplaced.error, SinkError::File(FileFault::Removed { .. })), "{unplaced:?}");
        assert!(unplaced.report.files.is_empty(), "{unplaced:?}");
        if cfg!(target_os = "linux") {
            let sink = opened(&path, None, 20);
            fs::rename(&path, &stored).unwrap();
            assert_eq!(sink.finish().unwrap().files, std::slice::from_ref(&stored));
            assert_eq!(pulses(&stored), 20);
            let sink = opened(&path, None, 20);
            fs::rename(&path, &stored).unwrap();
            fs::write(&path, "a letter").unwrap();
            let Err(SinkError::File(moved)) = sink.finish() else { panic!("moved, and its name taken") };
            assert!(matches!(&moved, FileFault::Moved { now: Some(now), .. } if *now == stored), "{moved}");
            assert_eq!(fs::read_to_string(&path).unwrap(), "a letter");
        }
    }

    /// Before: what had the old name was counted, and its superblock rewritten.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_failure_counts_what_was_moved_and_leaves_what_has_its_name() {
        let dir = tempfile::tempdir().unwrap();
        let (path, stored) = (dir.path().join("rec.h5"), dir.path().join("stored.h5"));
        let mut sink = opened(&path, None, 20);
        sink.flush().unwrap();
        fs::rename(&path, &stored).unwrap();
        assert_eq!((sink.readable(), pulses(&stored)), (Some(20), 20));
        // Another recording in its place, cut off: its superblock announces more than it has.
        let mut other = fs::read(&stored).unwrap();
        other.truncate(other.len() - 10);
        let mut sink = opened(&path, None, 30);
        sink.flush().unwrap();
        fs::rename(&path, &stored).unwrap();
        fs::write(&path, &other).unwrap();
        assert_eq!(sink.readable(), Some(0));
        assert!(fs::read(&path).unwrap() == other, "the file of another program was written");
    }

    /// Segments that are complete are moved on while the run goes on; what is known of them is reported.
    #[cfg(unix)]
    #[test]
    fn segments_may_be_moved_on() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let names: Vec<PathBuf> = (0..3).map(|k| dir.path().join(format!("rec_{k:04}.h5"))).collect();
        let mut sink = opened(&path, Some(0.1), 80);
        fs::rename(&names[0], dir.path().join("stored.h5")).unwrap();
        let report = sink.close().unwrap().place(true).unwrap();
        assert_eq!((report.files.as_slice(), report.gone.as_slice()), (&names[1..], &names[..1]));
        assert!(report.notes()[0].contains("moved or removed by another program"), "{:?}", report.notes());
        // Where another sink of the run has failed, too.
        fs::rename(&names[1], dir.path().join("stored.h5")).unwrap();
        let other = dir.path().join("other.h5");
        let names: Vec<PathBuf> = (0..3).map(|k| dir.path().join(format!("other_{k:04}.h5"))).collect();
        let mut sink = opened(&other, Some(0.1), 80);
        fs::rename(&names[0], dir.path().join("stored.h5")).unwrap();
        let report = sink.close().unwrap().keep();
        assert_eq!((report.files.as_slice(), report.gone.as_slice()), (&names[1..], &names[..1]));
        // One that still grows.
        let dir = tempfile::tempdir().unwrap();
        let mut sink = opened(&dir.path().join("rec.h5"), Some(0.1), 80);
        fs::remove_file(dir.path().join("rec_0002.h5")).unwrap();
        let removed = sink.close().unwrap_err();
        assert!(removed.to_string().contains("rec_0002.h5: removed by another program"), "{removed}");
        assert_eq!(sink.readable(), Some(67));
    }

    /// Somebody takes the name while the result is made: it is complete, so it stays.
    #[test]
    fn a_merge_that_cannot_be_put_in_place_is_kept() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        let header = header(SampleFormat::Cf32);
        let shards: Vec<PathBuf> = (0..20).map(|k| at(&format!("{k:02}.h5"))).collect();
        for (k, shard) in (0..).zip(&shards) {
            record(shard, None, &header, 20 * k, 20 * (k + 1));
        }
        let out = at("out.h5");
        // The other program may be too late: then both try again.
        for _ in 0..50 {
            let merged = thread::scope(|scope| {
                let merging = scope.spawn(|| merge(&shards, &out, false));
                while !merging.is_finished() {
                    if listing(dir.path()).iter().any(|name| name.starts_with(".out.h5.")) {
                        let _ = fs::File::create_new(&out);
                        break;
                    }
                }
                merging.join().unwrap()
            });
            match merged {
                Err(MergeError::Recording(RecordingError::File(FileFault::Kept { why, at, .. }))) => {
                    assert!(matches!(*why, FileFault::Exists { .. }), "{why}");
                    assert_eq!((pulses(&at), fs::metadata(&out).unwrap().len()), (400, 0));
                    return;
                }
                Ok(_) => fs::remove_file(&out).unwrap(),
                Err(other) => panic!("{other}"),
            }
        }
        panic!("50 merges were faster than the other program");
    }
}
