//! Changes of reports in recordings: every one up to the last pulse, in files that grow, in segments, and
//! joined.

use std::path::PathBuf;
use std::sync::Arc;

use nereus::pulse::SampleFormat;
use nereus::pulse::log::{Entry, Log, Origin};
use nereus::recording::header::Header;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use nereus::time::{PulseTimes, TimeTag};

use crate::recording_fixture::{PRF_HZ, header, pulse};

fn entry(start: TimeTag, pulse: u64, text: &str, origin: Origin) -> Entry {
    let time = PulseTimes::uniform(PRF_HZ).unwrap().emission(start, pulse);
    Entry { pulse, time_ns: time.to_unix_ns().0, platform: "aircraft".into(), text: text.into(), origin }
}

/// A header whose run has an event at pulse 40 and one behind its end.
fn changing() -> Header {
    let plain = header(SampleFormat::Cf32);
    let log = Log::default();
    log.enter(entry(plain.start, 40, "step position.up 5 m", Origin::Scenario));
    log.enter(entry(plain.start, 500, "clear", Origin::Scenario));
    Header { changes: Some(Arc::new(log)), ..plain }
}

/// Writes pulses; before pulse 60 is made somebody asks for a change at pulse 62, before the event at 500.
fn write(mut sink: Box<dyn Sink>, header: &Header, from: u64, to: u64) -> Vec<PathBuf> {
    for n in from..to {
        if n == 60 {
            let asked = entry(header.start, 62, "dropout 2.5 s", Origin::Control);
            header.changes.as_ref().unwrap().enter(asked);
        }
        sink.write(&pulse(header, n)).unwrap();
        if n % 25 == 0 {
            sink.flush().unwrap();
        }
    }
    sink.finish().unwrap().files
}

#[test]
fn plain_recordings_have_a_line_for_each() {
    let folder = tempfile::tempdir().unwrap();
    let header = changing();
    let path = folder.path().join("run");
    write(Box::new(PlainSink::create(&path, false, &header).unwrap()), &header, 0, 100);
    let text = std::fs::read_to_string(path.join("truth/changes.jsonl")).unwrap();
    let rows: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of =
        |row: &serde_json::Value| (row["pulse"].as_u64().unwrap(), row["text"].as_str().unwrap().to_owned());
    assert_eq!(
        rows.iter().map(of).collect::<Vec<_>>(),
        [(40, "step position.up 5 m".to_owned()), (62, "dropout 2.5 s".to_owned())]
    );
    assert_eq!((&rows[0]["source"], &rows[1]["source"]), (&"scenario".into(), &"control".into()));
    // 40 / 333.3 s after a quarter past the start: 0.25 s + 0.120012.. s, floored.
    let ns = header.start.to_unix_ns().0 + 120_012_001;
    assert_eq!((rows[0]["time_ns"].as_i64(), &rows[0]["platform"]), (Some(ns), &"aircraft".into()));
}

#[test]
fn where_nothing_can_change_there_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let header = header(SampleFormat::Cf32);
    let path = folder.path().join("run");
    let mut sink = Box::new(PlainSink::create(&path, false, &header).unwrap());
    sink.write(&pulse(&header, 0)).unwrap();
    sink.finish().unwrap();
    assert!(!path.join("truth/changes.jsonl").exists());
}

#[cfg(feature = "hdf5")]
mod files {
    use std::path::Path;

    use hdf5::types::FixedUnicode;
    use hdf5::{File, H5Type};
    use nereus::recording::merge::merge;
    use nereus::sinks::hdf5::Hdf5Sink;

    use super::*;

    #[derive(Clone, Copy, H5Type)]
    #[repr(C)]
    struct Row {
        pulse: u64,
        time_ns: i64,
        platform: FixedUnicode<200>,
        text: FixedUnicode<128>,
        source: FixedUnicode<16>,
    }

    fn rows(path: &Path) -> Vec<(u64, i64, String, String)> {
        let rows = File::open(path).unwrap().dataset("truth/changes").unwrap().read_raw::<Row>().unwrap();
        rows.iter()
            .inspect(|row| assert_eq!(row.platform.as_str(), "aircraft"))
            .map(|row| (row.pulse, row.time_ns, row.text.as_str().to_owned(), row.source.as_str().to_owned()))
            .collect()
    }

    fn record(path: &Path, segment_s: Option<f64>, header: &Header, from: u64, to: u64) -> Vec<PathBuf> {
        write(Box::new(Hdf5Sink::create(path, segment_s, false, header).unwrap()), header, from, to)
    }

    #[test]
    fn whole_runs_parts_and_segments() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        record(&at("whole.h5"), None, &changing(), 0, 100);
        let whole = rows(&at("whole.h5"));
        let ns = changing().start.to_unix_ns().0;
        assert_eq!(
            whole,
            [
                (40, ns + 120_012_001, "step position.up 5 m".to_owned(), "scenario".to_owned()),
                // 62 / 333.3 s
                (62, ns + 186_018_601, "dropout 2.5 s".to_owned(), "control".to_owned()),
            ]
        );
        // Segments of 30 pulses: each has all changes up to its end.
        let segments = record(&at("cut.h5"), Some(30.0 / PRF_HZ), &changing(), 0, 100);
        let counts: Vec<usize> = segments.iter().map(|path| rows(path).len()).collect();
        assert_eq!(counts, [0, 1, 2, 2]);
        merge(&segments, &at("joined.h5"), false).unwrap();
        assert_eq!(rows(&at("joined.h5")), whole);
        // A part whose changes are others is not of the same run.
        let other = header(SampleFormat::Cf32);
        let without = Header { changes: Some(Arc::default()), ..other };
        let log = without.changes.as_ref().unwrap();
        log.enter(entry(without.start, 41, "step position.up 5 m", Origin::Scenario));
        record(&at("b.h5"), None, &without, 90, 100);
        let error = merge(
            &[segments[0].clone(), segments[1].clone(), segments[2].clone(), at("b.h5")],
            &at("x.h5"),
            false,
        );
        let message = error.unwrap_err().to_string();
        assert!(message.contains("truth/changes differs"), "{message}");
    }
}
