//! Recordings whose writer is killed or runs out of disk. Writers are children of this test's binary.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use nereus::pulse::SampleFormat;
use nereus::recording::header::Header;
use nereus::recording::merge::merge;
use nereus::sinks::hdf5::Hdf5Sink;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::{Sink, drain};
use nereus::time::PulseTimes;
use nereus::transport::schedule::Schedule;
use nereus::transport::stage::Stream;
use nereus::transport::{Pace, Policy, Settings};

use crate::recording_fixture::{PRF_HZ, fill, header, python};

const OUTPUT: &str = "NEREUS_TEST_OUTPUT";
const PULSES: &str = "NEREUS_TEST_PULSES";

fn big() -> Header {
    header(SampleFormat::Cf32)
}

/// The child: a whole stream in real time or fast into the output named by the environment.
#[test]
#[ignore = "the writer that other tests start as a process of its own"]
fn writer() {
    let path = std::env::var(OUTPUT).unwrap();
    let pulses: u64 = std::env::var(PULSES).unwrap().parse().unwrap();
    let header = big();
    let sink: Box<dyn Sink> = if path.ends_with(".h5") {
        Box::new(Hdf5Sink::create(Path::new(&path), None, false, &header).unwrap())
    } else {
        Box::new(PlainSink::create(Path::new(&path), false, &header).unwrap())
    };
    let pace = if pulses > 10_000 { Pace::Fast } else { Pace::Realtime };
    let settings = Settings {
        pace,
        policy: Policy::Slip,
        latency_s: 0.1,
        ring_slots: 64,
        threads: 1,
        ..Settings::default()
    };
    let schedule = Schedule { times: PulseTimes::uniform(PRF_HZ).unwrap(), first: 0, count: pulses };
    let mut run = Stream::new(settings, schedule, header.layout, Arc::new(AtomicBool::new(false)));
    run.sink("recording", 128, |feed| drain(sink, feed)).unwrap();
    let outcome = run.run(|source| {
        let mut n = 0;
        while n < pulses {
            let Some(slots) = source.reserve(16) else { break };
            for (k, slot) in slots.iter_mut().enumerate() {
                fill(slot, &header, n + k as u64);
            }
            source.commit(16);
            n += 16;
        }
        Ok::<(), String>(())
    });
    if let Err(error) = outcome.result {
        println!("the run failed: {error}");
        // As the program does: exit 1 with a word, not a panic.
        std::process::exit(1);
    }
}

fn child(output: &Path, pulses: u64, limit_kib: Option<u64>) -> Command {
    let exe = std::env::current_exe().unwrap();
    let mut command = Command::new("sh");
    // A file size limit stands in for a full disk: with SIGXFSZ ignored, writes fail with EFBIG.
    let limit = limit_kib.map_or(String::new(), |kib| format!("trap '' XFSZ; ulimit -f {};", kib * 2));
    command
        .arg("-c")
        .arg(format!("{limit} exec \"$0\" --exact recording_breakdowns::writer --ignored --nocapture"))
        .arg(exe)
        .env(OUTPUT, output)
        .env(PULSES, pulses.to_string())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

#[test]
fn a_killed_run_is_readable_up_to_its_last_flush() {
    for name in ["rec.h5", "rec"] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        let mut writer = child(&path, 10_000, None).spawn().unwrap();
        thread::sleep(Duration::from_millis(1800));
        // SIGKILL: no handler, no destructor.
        writer.kill().unwrap();
        assert!(!writer.wait().unwrap().success());
        let seen = python(
            name == "rec.h5",
            &format!("rec = reader.open_recording({path:?}); check(rec, 0, rec.pulses); print(rec.pulses)"),
        );
        if let Some(seen) = seen {
            let pulses: u64 = seen.trim().parse().unwrap();
            println!("{name}: {pulses} pulses after kill -9");
            // 1.8 s less start-up, latency and half a second between flushes; 100 pulses are 0.3 s.
            assert!((100..=600).contains(&pulses), "{pulses}");
        }
        if name == "rec.h5" {
            let out = dir.path().join("saved.h5");
            let report = merge(&[path], &out, false).unwrap();
            println!("merge saves {} pulses of it", report.pulses);
            assert!((100..=600).contains(&report.pulses));
            assert_eq!((report.first, report.last), (0, report.pulses - 1));
        }
    }
}

#[test]
fn a_full_disk_ends_the_run_and_leaves_a_readable_recording() {
    for name in ["rec.h5", "rec"] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        let begun = Instant::now();
        // 10 million pulses are asked for. A file may hold 40 MiB; a pulse has 800 bytes of iq.
        let done = child(&path, 10_000_000, Some(40 * 1024)).output().unwrap();
        let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
        println!("{name}: {:.1} s\n{out}{err}", begun.elapsed().as_secs_f64());
        assert_eq!(done.status.code(), Some(1), "{out}{err}");
        assert!(out.contains("the run failed: sink 'recording'"), "{out}{err}");
        assert!(out.contains("File too large"), "{out}{err}");
        assert!(!err.contains("HDF5-DIAG"), "{err}");
        let seen = python(
            name == "rec.h5",
            &format!("rec = reader.open_recording({path:?}); check(rec, 0, rec.pulses); print(rec.pulses)"),
        );
        if let Some(seen) = seen {
            println!("readable: {seen}");
            // Two flushes of 16 MiB fit for certain; a row of all columns has less than 1600 bytes.
            assert!(seen.trim().parse::<u64>().unwrap() >= (32 << 20) / 1600);
        }
    }
}

#[test]
fn the_reader_program_follows_a_run() {
    for name in ["rec.h5", "rec"] {
        if python(name == "rec.h5", "").is_none() {
            continue;
        }
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        let mut writer = child(&path, 500, None).spawn().unwrap();
        thread::sleep(Duration::from_millis(700));
        let reader = Command::new("python3")
            .arg("-B")
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/python/nereus/reader.py"))
            .arg(&path)
            .args(["--follow", "--timeout-s", "1.5"])
            .output()
            .unwrap();
        assert!(writer.wait().unwrap().success());
        let out = String::from_utf8_lossy(&reader.stdout);
        println!("{out}{}", String::from_utf8_lossy(&reader.stderr));
        assert!(reader.status.success());
        // 500 pulses come in batches of 16, so 512 were made; they take 1.5 s: three flushes or so.
        assert!(out.lines().filter(|l| l.contains("pulses, up to")).count() >= 2);
        assert!(out.contains("512 pulses (0 to 511, 0 missing) at 333.3 Hz"));
    }
}
