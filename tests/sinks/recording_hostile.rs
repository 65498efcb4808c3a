//! Recordings that are damaged or forged in ways that can be written down.
//! `tests/python/test_hostile_recordings.py` has hundreds of others.

use std::fs;
use std::path::Path;

use nereus::pulse::{Pulse, SampleFormat, Samples};
use nereus::recording::hdf5::read_through;
use nereus::recording::header::Header;
use nereus::recording::{Recording, RecordingError};
use nereus::sinks::hdf5::Hdf5Sink;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use nereus::time::PulseTimes;

use crate::recording_fixture::{PRF_HZ, header};

fn record(mut sink: Box<dyn Sink>, header: &Header, corrupt: impl Fn(&mut Pulse)) {
    let mut pulse = Pulse::new(&header.layout);
    let times = PulseTimes::uniform(PRF_HZ).unwrap();
    for n in 0..20 {
        pulse.index = n;
        pulse.time = times.emission(header.start, n);
        pulse.window_start_s = 1e-5;
        if n == 7 {
            corrupt(&mut pulse);
        }
        sink.write(&pulse).unwrap();
    }
    sink.finish().unwrap();
}

fn hdf5(path: &Path, corrupt: impl Fn(&mut Pulse)) {
    let header = header(SampleFormat::Cf32);
    // Not replaced: a child of a test beside this one may have inherited the lock of the one before.
    let _ = fs::remove_file(path);
    record(Box::new(Hdf5Sink::create(path, None, false, &header).unwrap()), &header, corrupt);
}

fn refused(path: &Path) -> String {
    Recording::open(path, None).err().expect("it is refused").to_string()
}

/// Before: the text was taken for UTF-8, and looking at its characters left the string's end.
#[test]
fn texts_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    hdf5(&path, |_| {});
    let whole = fs::read(&path).unwrap();
    // The name stands in the attribute, in names of groups and in the text of the scenario: each is damaged
    // in turn.
    let mut reported = Vec::new();
    for at in (0..whole.len() - 8).filter(|at| whole[*at..].starts_with(b"aircraft")) {
        let mut bytes = whole.clone();
        // The first byte of a character of four, and then the end.
        bytes[at + 7] = 0xF0;
        fs::write(&path, &bytes).unwrap();
        reported.extend(Recording::open(&path, None).err().map(|error| error.to_string()));
    }
    assert!(reported.iter().any(|text| text.contains("platforms is not UTF-8 text")), "{reported:#?}");
}

#[test]
fn figures_that_no_radar_has_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    for (name, value) in
        [("carrier_hz", f64::NAN), ("prf_hz", 0.0), ("sample_rate_hz", -1.0), ("pulse_s", f64::INFINITY)]
    {
        hdf5(&path, |_| {});
        let file = hdf5::File::open_rw(&path).unwrap();
        file.attr(name).unwrap().write_scalar(&value).unwrap();
        drop(file);
        let message = refused(&path);
        assert!(message.contains(&format!("recording header, {name}: {value}; allowed:")), "{message}");
    }
    hdf5(&path, |pulse| pulse.window_start_s = f64::NAN);
    assert!(refused(&path).contains("pulse/window_start_s of pulse 7 is NaN"), "{}", refused(&path));
    hdf5(&path, |pulse| pulse.time = PulseTimes::uniform(PRF_HZ).unwrap().emission(pulse.time, 1_000_000));
    assert!(refused(&path).contains("pulse 8 leaves"), "{}", refused(&path));
}

/// Whoever has a recording examined reads on after a fault, so nothing may lie behind it unread. Before: the
/// examination ended at the first.
#[test]
fn an_examination_reads_all_whatever_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    hdf5(&path, |pulse| {
        let Samples::Cf32(samples) = &mut pulse.samples else { panic!() };
        samples[0] = num_complex::Complex32::new(1234.5, -6.75);
    });
    let mut bytes = fs::read(&path).unwrap();
    let sample = [1234.5_f32.to_le_bytes(), (-6.75_f32).to_le_bytes()].concat();
    for chunk in [sample, 1e-5_f64.to_le_bytes().repeat(20)] {
        let at = (0..bytes.len() - chunk.len()).find(|at| bytes[*at..].starts_with(&chunk)).unwrap();
        bytes[at] ^= 1;
    }
    fs::write(&path, bytes).unwrap();
    let message = read_through(&path).unwrap_err().to_string();
    assert!(message.contains("/iq") && message.contains("; and 1 more fault"), "{message}");
}

/// Links to other files and to the file itself, and data that lies elsewhere.
#[test]
fn what_lies_elsewhere_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    hdf5(&path, |_| {});
    hdf5::File::open_rw(&path).unwrap().link_external("/etc/passwd", "/", "other").unwrap();
    assert!(refused(&path).contains("/other is a link to elsewhere"), "{}", refused(&path));

    hdf5(&path, |_| {});
    hdf5::File::open_rw(&path).unwrap().link_soft("/nav", "again").unwrap();
    assert!(refused(&path).contains("/again is a link to elsewhere"), "{}", refused(&path));

    hdf5(&path, |_| {});
    let file = hdf5::File::open_rw(&path).unwrap();
    file.unlink("replica").unwrap();
    let outside = folder.path().join("replica.bin");
    fs::write(&outside, [0; 64]).unwrap();
    let dataset = file.new_dataset::<num_complex::Complex32>().external(outside.to_str().unwrap(), 0, 64);
    dataset.shape(8).create("replica").unwrap();
    drop(file);
    assert!(refused(&path).contains("replica lies in another file"), "{}", refused(&path));
}

/// Before: memory was asked for whatever was announced: 2^40 samples, or names.
#[test]
fn sizes_are_those_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    hdf5(&path, |_| {});
    let file = hdf5::File::open_rw(&path).unwrap();
    file.unlink("replica").unwrap();
    let replica = file.new_dataset::<num_complex::Complex32>().chunk(1 << 10);
    replica.shape(1_usize << 40).create("replica").unwrap();
    drop(file);
    assert!(
        refused(&path).contains("/replica announces 8796093022208 bytes, 0 are stored"),
        "{}",
        refused(&path)
    );
    assert!(read_through(&path).is_err());
}

#[test]
fn a_plain_recording_announces_no_more_than_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r");
    let header = header(SampleFormat::Cf32);
    record(Box::new(PlainSink::create(&path, true, &header).unwrap()), &header, |_| {});
    let meta = fs::read_to_string(path.join("meta.json")).unwrap();
    // 2^60 samples a channel: the bytes of a row cannot be counted.
    let more = meta.replacen("50]", "1152921504606846976]", 1);
    let more = if more == meta { meta.replacen("50\n", "1152921504606846976\n", 1) } else { more };
    assert_ne!(more, meta, "{meta}");
    fs::write(path.join("meta.json"), more).unwrap();
    assert!(refused(&path).contains("at most 2^24 samples a channel"), "{}", refused(&path));
    fs::write(path.join("meta.json"), &meta).unwrap();
    // 2^24 samples: nothing is allocated for what is not in the file.
    fs::write(path.join("meta.json"), meta.replacen("50]", "16777216]", 1).replacen("50\n", "16777216\n", 1))
        .unwrap();
    assert!(refused(&path).contains("iq.bin ends before pulse 20"), "{}", refused(&path));
}

/// Before: opening a pipe waited for a writer, for ever.
#[cfg(unix)]
#[test]
fn pipes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    assert!(refused(&path).contains("is no regular file"));
    let plain = folder.path().join("r");
    let header = header(SampleFormat::Cf32);
    record(Box::new(PlainSink::create(&plain, true, &header).unwrap()), &header, |_| {});
    fs::remove_file(plain.join("iq.bin")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(plain.join("iq.bin")).status().unwrap().success());
    assert!(matches!(Recording::open(&plain, None), Err(RecordingError::File(_))));
}

/// A bit of the superblock flipped. Before: read as if a run were writing it, again and again, with ever
/// longer pauses.
#[test]
fn a_damaged_superblock_ends_the_reading() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.h5");
    hdf5(&path, |_| {});
    let whole = fs::read(&path).unwrap();
    for at in 8..48 {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        fs::write(&path, bytes).unwrap();
        let begun = std::time::Instant::now();
        let _ = read_through(&path);
        assert!(begun.elapsed().as_secs() < 5, "byte {at}");
    }
}
