use std::fs;

use nereus::files::FileFault;
use nereus::pulse::SampleFormat;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::{FLUSH_INTERVAL, Sink, SinkError};

use crate::recording_fixture::{header, pulse, python};

#[test]
fn a_folder_holds_every_column() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec");
        let header = header(format);
        let mut sink = Box::new(PlainSink::create(&path, false, &header).unwrap());
        for n in 7..107 {
            sink.write(&pulse(&header, n)).unwrap();
        }
        let report = sink.finish().unwrap();
        assert_eq!((report.pulses, report.files.as_slice()), (100, std::slice::from_ref(&path)));
        // Without Python: the index and one sample, straight from the bytes.
        let index = fs::read(path.join("pulse/index.bin")).unwrap();
        let want: Vec<u8> = (7..107_u64).flat_map(u64::to_ne_bytes).collect();
        assert_eq!(index, want);
        let iq = fs::metadata(path.join("iq.bin")).unwrap().len();
        assert_eq!(iq, 100 * 100 * if format == SampleFormat::Cf32 { 8 } else { 4 });
        let meta: serde_json::Value =
            serde_json::from_slice(&fs::read(path.join("meta.json")).unwrap()).unwrap();
        assert_eq!(meta["channel"][0]["transmit_basis"], "local-horizontal");
        assert_eq!(meta["channel"][1]["receive_basis"], "ludwig-3");
        python(
            false,
            &format!(
                "rec = reader.open_recording({path:?}); check(rec, 7, 100); reader.show(reader.summary(rec))"
            ),
        );
    }
}

#[test]
fn what_was_flushed_is_there_before_the_end() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    let header = header(SampleFormat::Cf32);
    let mut sink = PlainSink::create(&path, false, &header).unwrap();
    for n in 0..5 {
        sink.write(&pulse(&header, n)).unwrap();
    }
    std::thread::sleep(FLUSH_INTERVAL);
    sink.write(&pulse(&header, 5)).unwrap();
    sink.write(&pulse(&header, 6)).unwrap();
    // A kill leaves the files as they are now.
    std::mem::forget(sink);
    assert_eq!(fs::metadata(path.join("pulse/index.bin")).unwrap().len(), 6 * 8);
    python(false, &format!("check(reader.open_recording({path:?}), 0, 6)"));
}

#[test]
fn a_folder_is_replaced_only_with_force_and_only_if_it_is_a_recording() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(PlainSink::create(&path, false, &header).unwrap());
    sink.write(&pulse(&header, 0)).unwrap();
    sink.finish().unwrap();
    assert!(matches!(
        PlainSink::create(&path, false, &header),
        Err(SinkError::File(FileFault::Exists { .. }))
    ));
    let mut sink = Box::new(PlainSink::create(&path, true, &header).unwrap());
    (0..2).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
    sink.finish().unwrap();
    assert_eq!(fs::metadata(path.join("iq.bin")).unwrap().len(), 1600);

    let other = dir.path().join("letters");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("diary.txt"), "dear").unwrap();
    assert!(matches!(
        PlainSink::create(&other, true, &header),
        Err(SinkError::File(FileFault::Foreign { .. }))
    ));
    assert_eq!(fs::read_to_string(other.join("diary.txt")).unwrap(), "dear");
}
