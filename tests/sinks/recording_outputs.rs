use std::fs;
use std::path::PathBuf;

use nereus::files::FileFault;
use nereus::pulse::SampleFormat;
use nereus::recording::header::Header;
use nereus::sinks::sink::SinkError;
use nereus::sinks::{Kind, Settings, preflight};

use crate::recording_fixture::header;

fn plain(path: PathBuf) -> Settings {
    Settings::new(Kind::Plain { path, force: false }, 8)
}

#[test]
fn every_fault_is_reported_before_anything_is_made() {
    let dir = tempfile::tempdir().unwrap();
    let there = dir.path().join("there");
    fs::create_dir(&there).unwrap();
    let twice = dir.path().join("twice");
    let lost = dir.path().join("no/such/folder/rec");
    let faults = preflight(&[
        plain(there.clone()),
        plain(twice.clone()),
        plain(twice.clone()),
        plain(lost),
        Settings::new(Kind::Null, 8),
    ]);
    assert!(
        matches!(
            faults.as_slice(),
            [SinkError::File(FileFault::Exists { path }), SinkError::Twice { path: second }, SinkError::File(FileFault::Io { .. })]
                if *path == there && *second == twice
        ),
        "{faults:?}"
    );
    assert!(faults[0].to_string().contains("--force"), "{}", faults[0]);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[cfg(feature = "hdf5")]
#[test]
fn hdf5_outputs_and_their_segments() {
    let dir = tempfile::tempdir().unwrap();
    let hdf5 = |name: &str, segment_s, force| {
        Settings::new(Kind::Hdf5 { path: dir.path().join(name), segment_s, force }, 8)
    };
    fs::write(dir.path().join("a.h5"), "").unwrap();
    fs::write(dir.path().join("b_0000.h5"), "").unwrap();
    assert_eq!(preflight(&[hdf5("a.h5", None, false)]).len(), 1);
    assert_eq!(preflight(&[hdf5("a.h5", None, true)]).len(), 0);
    assert_eq!(preflight(&[hdf5("b.h5", None, false)]).len(), 0);
    assert_eq!(preflight(&[hdf5("b.h5", Some(1.0), false)]).len(), 1);
    assert_eq!(preflight(&[hdf5("b.h5", Some(1.0), true)]).len(), 0);
    // No segment: it was not written as one.
    fs::rename(dir.path().join("b_0000.h5"), dir.path().join("b_0003.h5")).unwrap();
    assert_eq!(preflight(&[hdf5("b.h5", Some(1.0), false)]).len(), 0);
    for segment_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let faults = preflight(&[hdf5("c.h5", Some(segment_s), false)]);
        assert!(matches!(faults.as_slice(), [SinkError::Segment { .. }]), "{faults:?}");
    }
}

/// One output under two spellings, a segment of another output, a file where a folder is needed, and files
/// that are no recordings.
#[cfg(feature = "hdf5")]
#[test]
fn nothing_but_recordings_is_overwritten_and_each_output_is_one() {
    let dir = tempfile::tempdir().unwrap();
    let hdf5 = |name: &str, segment_s, force| {
        Settings::new(Kind::Hdf5 { path: dir.path().join(name), segment_s, force }, 8)
    };
    let twice = |sinks: &[Settings]| matches!(preflight(sinks).as_slice(), [SinkError::Twice { .. }]);
    assert!(twice(&[hdf5("s.h5", None, true), hdf5("./s.h5", None, true)]));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(dir.path(), dir.path().join("link")).unwrap();
        assert!(twice(&[hdf5("s.h5", None, true), hdf5("link/s.h5", None, true)]));
        // A link to the output itself, to a plain recording, and to or from a segment of another.
        for (to, link) in [("s.h5", "t.h5"), ("y_0001.h5", "u.h5"), ("s.h5", "x_0000.h5"), ("rec", "rec2")] {
            std::os::unix::fs::symlink(dir.path().join(to), dir.path().join(link)).unwrap();
        }
        for empty in ["s.h5", "y_0001.h5"] {
            fs::write(dir.path().join(empty), "").unwrap();
        }
        fs::create_dir(dir.path().join("rec")).unwrap();
        assert!(twice(&[hdf5("s.h5", None, true), hdf5("t.h5", None, true)]));
        assert!(twice(&[hdf5("link/t.h5", None, true), hdf5("s.h5", None, true)]));
        assert!(twice(&[hdf5("y.h5", Some(1.0), true), hdf5("u.h5", None, true)]));
        assert!(twice(&[hdf5("s.h5", None, true), hdf5("x.h5", Some(1.0), true)]));
        let plain = |name: &str| Settings::new(Kind::Plain { path: dir.path().join(name), force: true }, 8);
        assert!(twice(&[plain("rec"), plain("rec2")]) && twice(&[plain("link/rec2"), plain("rec")]));
        assert!(!twice(&[hdf5("t.h5", None, true), hdf5("u.h5", None, true)]));
    }
    assert!(twice(&[hdf5("z.h5", Some(1.0), false), hdf5("z_0000.h5", None, false)]));
    assert!(!twice(&[hdf5("z.h5", Some(1.0), false), hdf5("z_more.h5", None, false)]));
    fs::write(dir.path().join("scenario.toml"), "[scene]").unwrap();
    fs::create_dir(dir.path().join("folder.h5")).unwrap();
    for name in ["scenario.toml", "folder.h5"] {
        let faults = preflight(&[hdf5(name, None, true)]);
        assert!(matches!(faults.as_slice(), [SinkError::File(FileFault::Foreign { .. })]), "{faults:?}");
    }
    let faults = preflight(&[hdf5("scenario.toml/x.h5", None, false)]);
    assert!(matches!(faults.as_slice(), [SinkError::File(FileFault::NoFolder { .. })]), "{faults:?}");
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn a_build_without_hdf5_refuses_it() {
    let kind = Kind::Hdf5 { path: "x.h5".into(), segment_s: None, force: false };
    let faults = preflight(&[Settings::new(kind, 8)]);
    assert!(matches!(faults.as_slice(), [SinkError::NoHdf5 { .. }]));
}

#[test]
fn headers_that_cannot_be_recorded_are_refused() {
    type Damage = fn(&mut Header);
    let damages: [(Damage, &str); 9] = [
        (|h| h.platforms[0] = "a/b".to_owned(), "platforms"),
        (|h| h.platforms[0] = "..".to_owned(), "platforms"),
        (|h| h.platforms[0] = String::new(), "platforms"),
        (|h| h.platforms[1] = "tower".to_owned(), "platforms"),
        (|h| h.receivers[0] = "mast".to_owned(), "transmitters and receivers"),
        (|h| h.targets.truncate(1), "targets"),
        (|h| h.config.push('\0'), "texts"),
        (|h| h.layout.format = SampleFormat::Ci16, "adc"),
        (
            |h| {
                h.layout.channels = 0;
                h.channels.clear();
            },
            "layout",
        ),
    ];
    for (corrupt, field) in damages {
        let mut bad = header(SampleFormat::Cf32);
        assert!(bad.check().is_ok());
        corrupt(&mut bad);
        let error = bad.check().unwrap_err();
        assert!(error.to_string().contains(field), "{error}");
    }
}
