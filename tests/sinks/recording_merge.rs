use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use hdf5::{Dataset, File, Group};

use nereus::files::FileFault;
use nereus::pulse::{SampleFormat, flags};
use nereus::recording::RecordingError;
use nereus::recording::header::Header;
use nereus::recording::merge::{MergeError, merge};
use nereus::recording::shard::Shard;
use nereus::sinks::hdf5::Hdf5Sink;
use nereus::sinks::sink::Sink;

use crate::recording_fixture::{header, pulse, unlocked};
use crate::recording_hdf5::record;

fn datasets(group: &Group, list: &mut Vec<Dataset>) {
    list.extend(group.datasets().unwrap());
    for inner in group.groups().unwrap() {
        datasets(&inner, list);
    }
}

/// Every dataset with its type, shape and raw bytes (strings as strings), sorted by path.
fn content(path: &Path) -> Vec<(String, String, Vec<usize>, Vec<u8>)> {
    let file = File::open(path).unwrap();
    let mut list = Vec::new();
    datasets(&file, &mut list);
    let mut out: Vec<_> = list
        .iter()
        .map(|d| {
            let dtype = d.dtype().unwrap().to_descriptor().unwrap();
            // Memory of variable-length strings is addresses: these are compared by the header.
            let name = d.name();
            let bytes = if ["/channel", "/truth/targets", "/truth/ships", "/truth/clocks", "/truth/pairs"]
                .contains(&name.as_str())
            {
                Vec::new()
            } else {
                raw(d)
            };
            (name, format!("{dtype:?}"), d.shape(), bytes)
        })
        .collect();
    out.sort();
    out
}

fn raw(d: &Dataset) -> Vec<u8> {
    use num_complex::{Complex, Complex32};
    let dtype = d.dtype().unwrap();
    if dtype.is::<f64>() {
        bytemuck::cast_slice(&d.read_raw::<f64>().unwrap()).to_vec()
    } else if dtype.is::<Complex32>() {
        bytemuck::cast_slice(&d.read_raw::<Complex32>().unwrap()).to_vec()
    } else if dtype.is::<Complex<i16>>() {
        bytemuck::cast_slice(&d.read_raw::<Complex<i16>>().unwrap()).to_vec()
    } else if dtype.is::<u64>() {
        bytemuck::cast_slice(&d.read_raw::<u64>().unwrap()).to_vec()
    } else if dtype.is::<i64>() {
        bytemuck::cast_slice(&d.read_raw::<i64>().unwrap()).to_vec()
    } else if dtype.is::<u32>() {
        bytemuck::cast_slice(&d.read_raw::<u32>().unwrap()).to_vec()
    } else {
        d.read_raw::<u8>().unwrap()
    }
}

fn shard(folder: &Path, header: &Header, from: u64, to: u64) -> PathBuf {
    let path = folder.join(format!("{from}.h5"));
    let header = Header { first_pulse: from, pulses: to - from, ..header.clone() };
    record(&path, None, &header, from, to);
    path
}

#[test]
fn shards_and_segments_become_the_whole_run() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let dir = tempfile::tempdir().unwrap();
        let header = Header { pulses: 500, ..header(format) };
        let whole = dir.path().join("whole.h5");
        record(&whole, None, &header, 0, 500);
        let segments = record(&dir.path().join("s.h5"), Some(0.4), &header, 0, 500).files;
        let shards: Vec<PathBuf> = [(300, 500), (0, 17), (17, 300), (500, 500)]
            .map(|(from, to)| shard(dir.path(), &header, from, to))
            .into();
        for (name, parts) in [("a.h5", &shards), ("b.h5", &segments)] {
            let out = dir.path().join(name);
            let report = merge(parts, &out, false).unwrap();
            assert_eq!((report.pulses, report.first, report.last, report.dropped), (500, 0, 499, 0));
            assert!(content(&out) == content(&whole), "{name} differs from the whole run");
            let (a, b) = (File::open(&out).unwrap(), File::open(&whole).unwrap());
            for attribute in ["first_pulse", "pulses", "seed"] {
                let read = |f: &File| f.attr(attribute).unwrap().read_scalar::<u64>().unwrap();
                assert_eq!(read(&a), read(&b), "{attribute}");
            }
        }
        let again = merge(&shards, &whole, false);
        assert!(matches!(again, Err(MergeError::Recording(RecordingError::File(FileFault::Exists { .. })))));
        unlocked(|| match merge(&shards, &whole, true) {
            Err(MergeError::Recording(fault)) => Err(fault.into()),
            merged => Ok(merged.unwrap()),
        });
        let leftovers = fs::read_dir(dir.path()).unwrap().flatten();
        assert_eq!(leftovers.filter(|e| e.file_name().to_string_lossy().contains("partial")).count(), 0);
    }
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let header = header(SampleFormat::Cf32);
    let out = dir.path().join("out.h5");
    let a = shard(dir.path(), &header, 0, 20);
    let b = shard(dir.path(), &header, 19, 40);
    let c = shard(dir.path(), &header, 42, 60);
    let other = shard(dir.path(), &Header { seed: 43, ..header.clone() }, 100, 110);
    let empty = shard(dir.path(), &header, 70, 70);
    let cases = [
        (vec![b.clone(), a.clone()], "begins with pulse 19"),
        (vec![b.clone(), c], "pulses 40..42 are in no shard"),
        (vec![a.clone(), other], "seed differs"),
        (vec![empty], "none holds a pulse"),
        (vec![], "nothing to merge"),
        (vec![a.clone(), dir.path().join("missing.h5")], "missing.h5"),
    ];
    for (shards, words) in cases {
        let error = merge(&shards, &out, false).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        assert!(!out.exists());
    }
    let junk = dir.path().join("junk.h5");
    for bytes in [vec![], vec![0x89, b'H', b'D', b'F'], fs::read(&a).unwrap()[..900].to_vec()] {
        fs::write(&junk, bytes).unwrap();
        assert!(matches!(
            merge(std::slice::from_ref(&junk), &out, false),
            Err(MergeError::Recording(RecordingError::Hdf5 { .. }))
        ));
    }
}

#[test]
fn a_gap_that_was_dropped_in_real_time_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let header = header(SampleFormat::Cf32);
    let a = shard(dir.path(), &header, 0, 20);
    let path = dir.path().join("later.h5");
    let mut sink = Box::new(Hdf5Sink::create(&path, None, false, &header).unwrap());
    for n in 25..30 {
        let mut pulse = pulse(&header, n);
        pulse.flags = if n == 25 { flags::AFTER_GAP } else { 0 };
        sink.write(&pulse).unwrap();
    }
    sink.finish().unwrap();
    let report = merge(&[path, a], &dir.path().join("out.h5"), false).unwrap();
    assert_eq!((report.pulses, report.dropped), (25, 5));
}

/// The flag of a gap marks that the run dropped pulses; it does not excuse a file that is missing.
#[test]
fn a_lost_segment_is_no_dropped_pulse() {
    let dir = tempfile::tempdir().unwrap();
    let header = header(SampleFormat::Cf32);
    let path = dir.path().join("run.h5");
    // One segment a pulse time of ten.
    let segment_s = 10.0 / header.prf_hz;
    let mut sink = Box::new(Hdf5Sink::create(&path, Some(segment_s), false, &header).unwrap());
    for n in (0..20).chain(25..40) {
        let mut pulse = pulse(&header, n);
        pulse.flags = if n == 25 || n == 30 { flags::AFTER_GAP } else { 0 };
        sink.write(&pulse).unwrap();
    }
    let files = sink.finish().unwrap().files;
    assert_eq!(files.len(), 4, "{files:?}");
    let out = dir.path().join("out.h5");
    let whole = merge(&files, &out, false).unwrap();
    assert_eq!((whole.pulses, whole.dropped), (35, 5));
    let lost = [files[0].clone(), files[1].clone(), files[3].clone()];
    let refused = merge(&lost, &out, true).unwrap_err();
    assert!(matches!(refused, MergeError::Gap { from: 20, to: 30, .. }), "{refused}");
}

/// A shard of a run of shards: element `number` of `of` of 100 pulses, which holds them up to `to`.
fn element(folder: &Path, header: &Header, number: u64, of: u64, to: Option<u64>) -> PathBuf {
    let shard: Shard = format!("{number}/{of}").parse().unwrap();
    let pulses = shard.pulses(header.pulses).unwrap();
    let path = folder.join(format!("{number}of{of}_{}.h5", to.unwrap_or(pulses.end)));
    let count = pulses.end - pulses.start;
    let part = Header { first_pulse: pulses.start, pulses: count, shard: Some(shard), ..header.clone() };
    record(&path, None, &part, pulses.start, to.unwrap_or(pulses.end));
    path
}

#[test]
fn all_shards_of_a_run_are_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let header = header(SampleFormat::Cf32);
    let at = |number, of, to| element(dir.path(), &header, number, of, to);
    let whole = dir.path().join("whole.h5");
    record(&whole, None, &header, 0, header.pulses);
    let [one, two, three] = [1, 2, 3].map(|number| at(number, 3, None));
    let out = dir.path().join("out.h5");
    merge(&[three.clone(), one.clone(), two.clone()], &out, false).unwrap();
    assert!(content(&out) == content(&whole));
    assert!(File::open(&out).unwrap().attr("shard").is_err(), "the whole is no shard");
    // Each shard in segments, as a sink with segment_s records it; the last segment of one is missing.
    let mut segments: Vec<PathBuf> = (1..=3)
        .flat_map(|number| {
            let shard: Shard = format!("{number}/3").parse().unwrap();
            let Range { start, end } = shard.pulses(header.pulses).unwrap();
            let part =
                Header { first_pulse: start, pulses: end - start, shard: Some(shard), ..header.clone() };
            record(&dir.path().join(format!("s{number}.h5")), Some(0.02), &part, start, end).files
        })
        .collect();
    assert!(segments.len() > 3);
    merge(&segments, &out, true).unwrap();
    assert!(content(&out) == content(&whole), "segments of shards differ from the whole run");
    segments.pop();
    let short = merge(&segments, &out, true).unwrap_err().to_string();
    assert!(short.contains("shard 3/3 was to make pulses 66..100 and has"), "{short}");

    let others = dir.path().join("others.h5");
    let part = Header { first_pulse: 33, pulses: 33, ..header.clone() };
    record(&others, None, &part, 33, 66);

    let refused = [
        (vec![one.clone(), two.clone()], "1 of 3 shards are missing: 3;"),
        (
            vec![two.clone()],
            "2 of 3 shards are missing: 1, 3; allowed: all shards of a run (nereus run --shard 1/3",
        ),
        (
            vec![one.clone(), two.clone(), at(3, 3, Some(80))],
            "shard 3/3 was to make pulses 66..100 and has 14 of them",
        ),
        (vec![one.clone(), two.clone(), at(3, 3, Some(66))], "has 0 of them"),
        (vec![one.clone(), two.clone(), three.clone(), two.clone()], "begins with pulse 33"),
        (vec![one.clone(), two.clone(), at(3, 4, None)], "number of shards differs"),
        (vec![one, others, three], "number of shards differs"),
    ];
    for (shards, words) in refused {
        let error = merge(&shards, &out, true).unwrap_err().to_string();
        assert!(error.contains(words), "{error}\n{words}");
    }
}

/// Whatever the number of shards, every pulse is in one of them.
#[test]
fn shards_cover_all_pulses_once() {
    for (pulses, of) in [(1, 1), (10, 3), (2220, 16), (100, 100), (u64::MAX, 7)] {
        let mut next = 0;
        for number in 1..=of {
            let shard = format!("{number}/{of}").parse::<Shard>().unwrap().pulses(pulses).unwrap();
            assert!(shard.start == next && shard.end > shard.start, "{number}/{of} of {pulses}");
            next = shard.end;
        }
        assert_eq!(next, pulses);
    }
    assert_eq!("2/3".parse::<Shard>().unwrap().pulses(2), None);
    for text in ["", "3", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1/99999999999999999999"] {
        assert!(text.parse::<Shard>().is_err(), "{text}");
    }
}
