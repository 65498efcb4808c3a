//! `verify` beside readers and writers, and on hundreds of damaged recordings.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Duration;

use nereus::pulse::SampleFormat;
use nereus::recording::verify::{Ending, verify};
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;

use crate::recording_fixture::{header, pulse};

fn plain(path: &Path, pulses: u64) {
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(PlainSink::create(path, false, &header).unwrap());
    (0..pulses).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
    sink.finish().unwrap();
}

/// Random numbers that depend on the seed alone (Steele, Lea, Flood 2014: SplitMix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Numbers at which counting goes wrong, and others.
    fn odd(&mut self) -> u64 {
        let values = [0, 1, u64::MAX, u64::MAX - 1, i64::MAX as u64, i64::MIN as u64, f64::NAN.to_bits()];
        match self.below(9) {
            7 => 1 << self.below(64),
            8 => self.next(),
            place => values[place],
        }
    }
}

/// Another `verify` holds the lock of `meta.json` for an instant. Before: the recording counted as being
/// written.
#[test]
fn two_at_once_do_not_disturb_each_other() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    plain(&path, 5);
    let other = fs::File::open(path.join("meta.json")).unwrap();
    other.try_lock().unwrap();
    let verdict = thread::scope(|scope| {
        let verdict = scope.spawn(|| verify(&path).unwrap());
        thread::sleep(Duration::from_millis(25));
        other.unlock().unwrap();
        verdict.join().unwrap()
    });
    assert!(verdict.whole && verdict.ending == Ending::Closed, "{verdict:?}");
}

#[test]
fn a_plain_recording_that_grows_is_being_written() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    let header = header(SampleFormat::Cf32);
    let mut sink = Box::new(PlainSink::create(&path, false, &header).unwrap());
    (0..3).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
    sink.flush().unwrap();
    let growing = verify(&path).unwrap();
    assert_eq!((growing.ending, growing.faults), (Ending::Growing, 1), "{growing:?}");
    assert!(growing.findings[0].what.starts_with("being written"), "{growing:?}");
}

/// 300 plain recordings with numbers in their columns that no run has, bits of their header flipped, or files
/// cut. Before: pulses 0, 2^64 - 1, 0, 2^64 - 1 after gaps were more than can be counted.
#[test]
fn damaged_plain_recordings_are_judged() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("rec");
    plain(&path, 12);
    let files =
        ["pulse/index.bin", "pulse/flags.bin", "pulse/time_ns.bin", "pulse/time_frac_ns.bin", "iq.bin"];
    let files = files.map(|name| path.join(name));
    let meta = path.join("meta.json");
    let whole = files.each_ref().map(|file| fs::read(file).unwrap());
    let whole_meta = fs::read(&meta).unwrap();
    let mut not_whole = 0;
    for seed in 0..300 {
        let mut dice = Dice(seed);
        for (file, whole) in files.iter().zip(&whole) {
            let mut bytes = whole.clone();
            match dice.below(4) {
                0 => (0..bytes.len() / 8).for_each(|at| {
                    bytes[at * 8..at * 8 + 8].copy_from_slice(&dice.odd().to_le_bytes());
                }),
                1 => bytes.truncate(dice.below(bytes.len())),
                2 => {
                    let at = dice.below(bytes.len());
                    bytes[at] ^= 1 << dice.below(8);
                }
                _ => {}
            }
            fs::write(file, bytes).unwrap();
        }
        let mut bytes = whole_meta.clone();
        if dice.below(3) == 0 {
            let at = dice.below(bytes.len());
            bytes[at] = b"0123456789-\"[]{},e "[dice.below(19)];
        }
        fs::write(&meta, bytes).unwrap();
        not_whole += u32::from(verify(&path).is_ok_and(|verdict| !verdict.whole));
    }
    println!("{not_whole} of 300 are not whole");
    assert!(not_whole > 200);
    // The one that panicked.
    let numbers = |values: &[u64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    for (file, whole) in files.iter().zip(&whole) {
        fs::write(file, whole).unwrap();
    }
    fs::write(&meta, &whole_meta).unwrap();
    fs::write(&files[0], numbers(&[0, u64::MAX, 0, u64::MAX, 0, u64::MAX, 0, 1, 2, 3, 4, 5])).unwrap();
    fs::write(&files[1], [0xff; 48]).unwrap();
    let verdict = verify(&path).unwrap();
    assert_eq!((verdict.whole, verdict.dropped), (false, u64::MAX), "{verdict:?}");
}

#[cfg(feature = "hdf5")]
mod hdf5 {
    use nereus::sinks::hdf5::Hdf5Sink;

    use super::*;
    use crate::recording_hdf5::record;

    /// Before: whoever had the file open, under the lock that the HDF5 library takes for readers, counted as
    /// its writer.
    #[test]
    fn readers_are_no_fault() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        record(&path, None, &header(SampleFormat::Cf32), 0, 20);
        let reader = fs::File::open(&path).unwrap();
        reader.try_lock_shared().unwrap();
        let verdict = verify(&path).unwrap();
        assert!(verdict.whole && verdict.ending == Ending::Closed, "{verdict:?}");
        // And `verify` leaves a reader's lock possible, at every instant.
        thread::scope(|scope| {
            let many: Vec<_> = (0..4).map(|_| scope.spawn(|| verify(&path).unwrap().whole)).collect();
            assert!(many.into_iter().all(|one| one.join().unwrap()));
        });
    }

    #[test]
    fn a_writer_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        let header = header(SampleFormat::Cf32);
        let mut sink = Box::new(Hdf5Sink::create(&path, None, false, &header).unwrap());
        (0..20).for_each(|n| sink.write(&pulse(&header, n)).unwrap());
        sink.flush().unwrap();
        let growing = verify(&path).unwrap();
        assert_eq!((growing.ending, growing.faults), (Ending::Growing, 1), "{growing:?}");
        assert!(growing.findings[0].what.starts_with("being written"), "{growing:?}");
    }

    /// 100 recordings whose index, flags and times are replaced by numbers that no run has, with sound
    /// checksums.
    #[test]
    fn damaged_indices_are_judged() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.h5");
        record(&path, None, &header(SampleFormat::Cf32), 0, 12);
        for seed in 0..100 {
            let mut dice = Dice(seed);
            let file = ::hdf5::File::open_rw(&path).unwrap();
            let index: Vec<u64> = (0..12).map(|_| dice.odd()).collect();
            file.dataset("pulse/index").unwrap().write_raw(&index).unwrap();
            let flags: Vec<u32> = (0..12).map(|_| dice.next() as u32).collect();
            file.dataset("pulse/flags").unwrap().write_raw(&flags).unwrap();
            let ns: Vec<i64> = (0..12).map(|_| dice.odd() as i64).collect();
            file.dataset("pulse/time_ns").unwrap().write_raw(&ns).unwrap();
            file.close().unwrap();
            assert!(!verify(&path).unwrap().whole, "seed {seed}");
        }
    }
}
