//! Recordings of a reception that follows its sender through several runs.

use std::fs;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use nereus::pulse::{Pulse, SampleFormat};
use nereus::receive::listener::{Interrupted, Listener, Opener, Senders, Until};
use nereus::receive::report::Report;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::{Closed, Sink, SinkError, SinkReport};

use crate::recording_fixture::{header, pulse, unlocked};
use crate::wire_fixture::datagrams;

/// Pulses of each run.
const PULSES: u64 = 40;
/// Descriptions before the first pulse.
const DESCRIPTIONS: usize = 7;

/// The datagrams of so many runs; each begins with its description twice.
fn runs(count: u64) -> Vec<Vec<u8>> {
    let run = |seed: u64| {
        let mut header = header(SampleFormat::Ci16);
        header.seed = seed;
        let (all, _) = datagrams(&header, 1500, 0, PULSES);
        let mut twice = all[..DESCRIPTIONS].to_vec();
        twice.extend(all);
        twice
    };
    (0..count).flat_map(run).collect()
}

/// What a reception with `--restart` makes of datagrams.
fn followed(
    all: &[Vec<u8>],
    opener: impl Fn(usize) -> Opener + Send + Sync + 'static,
    see: impl FnMut(&Pulse) + Send + 'static,
) -> Result<Report, Box<Interrupted>> {
    let first = opener(1);
    let senders = Senders { restart: true, next: Some(Box::new(opener)), ..Senders::default() };
    let listener = Listener::bind("127.0.0.1:0").unwrap().with(senders);
    let to = listener.address();
    let receiving = thread::spawn(move || {
        let until = Until { idle: Some(Duration::from_millis(500)), ..Until::default() };
        listener.receive(until, &AtomicBool::new(false), Some(first), see)
    });
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    for (k, datagram) in all.iter().enumerate() {
        // The listener may have ended early.
        let _ = socket.send_to(datagram, to);
        if k % 50 == 49 {
            thread::sleep(Duration::from_millis(5));
        }
    }
    receiving.join().unwrap()
}

fn pulses(path: &Path) -> u64 {
    fs::metadata(path.join("pulse/index.bin")).unwrap().len() / 8
}

/// Before: the first recording was reported as removed (exit 1), and those after it were not put in their
/// places.
#[test]
fn a_recording_that_is_over_may_be_moved_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = |number: usize| folder.path().join(number.to_string());
    let dir = folder.path().to_owned();
    let opener = move |number: usize| -> Opener {
        let dir = dir.clone();
        Box::new(move |header| {
            if number == 3 {
                // To another disk.
                fs::remove_dir_all(dir.join("1")).unwrap();
            }
            Ok(Box::new(PlainSink::create(&dir.join(number.to_string()), false, header)?) as Box<dyn Sink>)
        })
    };
    let report = followed(&runs(3), opener, |_| {}).unwrap();
    assert_eq!((report.pulses, report.recorded), (3 * PULSES, Some(2 * PULSES)));
    assert_eq!(report.out, [at(2), at(3)]);
    assert_eq!(serde_json::to_value(&report).unwrap()["gone"], serde_json::json!([at(1)]));
    assert_eq!((pulses(&at(2)), pulses(&at(3))), (PULSES, PULSES));
}

/// Before: each held a file or two open until the end of the reception, and the 1024 of a process ran out.
#[cfg(target_os = "linux")]
#[test]
fn recordings_that_are_over_hold_no_files_open() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().to_owned();
    let opener = move |number: usize| -> Opener {
        let dir = dir.clone();
        Box::new(move |header| {
            if number == 4 {
                // The third may still be closing.
                let open = fs::read_dir("/proc/self/fd").unwrap();
                let open = open.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok());
                let held: Vec<PathBuf> = open
                    .filter(|path| [1, 2].iter().any(|n| path.starts_with(dir.join(n.to_string()))))
                    .collect();
                assert!(held.is_empty(), "{held:?}");
            }
            Ok(Box::new(PlainSink::create(&dir.join(number.to_string()), false, header)?) as Box<dyn Sink>)
        })
    };
    let report = followed(&runs(4), opener, |_| {}).unwrap();
    assert_eq!((report.recorded, report.out.len()), (Some(4 * PULSES), 4));
}

/// Before: what followed a recording that could not be put in its place stayed under the names of the
/// process, unnamed.
#[test]
fn one_recording_that_is_in_use_does_not_keep_the_others_from_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let at = |number: usize| folder.path().join(number.to_string());
    let old = header(SampleFormat::Cf32);
    for number in 1..=3 {
        let mut sink = Box::new(unlocked(|| PlainSink::create(&at(number), false, &old)));
        sink.write(&pulse(&old, 0)).unwrap();
        sink.finish().unwrap();
    }
    let (dir, (reads, readers)) = (folder.path().to_owned(), mpsc::channel());
    let opener = move |number: usize| -> Opener {
        let (path, reads) = (dir.join(number.to_string()), reads.clone());
        Box::new(move |header| {
            let sink = PlainSink::create(&path, true, header)?;
            if number == 1 {
                let reader = fs::File::open(path.join("meta.json")).unwrap();
                reader.lock_shared().unwrap();
                reads.send(reader).unwrap();
            }
            Ok(Box::new(sink) as Box<dyn Sink>)
        })
    };
    let Interrupted { report, error } = *followed(&runs(3), opener, |_| {}).unwrap_err();
    drop(readers.recv().unwrap());
    let beside: Vec<PathBuf> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some())
        .collect();
    assert_eq!(beside.len(), 1, "{beside:?}");
    assert!(error.to_string().contains(&beside[0].display().to_string()), "{error}");
    assert_eq!(report.out, [beside[0].clone(), at(2), at(3)]);
    assert_eq!(report.recorded, Some(3 * PULSES));
    assert_eq!([1, 2, 3].map(|number| pulses(&at(number))), [1, PULSES, PULSES]);
}

/// A sink whose end takes as long as it is not released.
struct Slow {
    released: mpsc::Receiver<()>,
    in_time: mpsc::Sender<bool>,
}

impl Sink for Slow {
    fn name(&self) -> &'static str {
        "slow"
    }

    fn describe(&self) -> String {
        "slow".to_owned()
    }

    fn write(&mut self, _: &Pulse) -> Result<(), SinkError> {
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        self.in_time.send(self.released.recv_timeout(Duration::from_secs(5)).is_ok()).unwrap();
        Ok(Closed::of(SinkReport::default()))
    }
}

/// Before: the socket was not read while a recording was handed to the disk.
#[test]
fn the_next_run_is_received_while_a_recording_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("2");
    let ((release, released), (in_time, is_in_time)) = (mpsc::channel(), mpsc::channel());
    let slow = std::sync::Mutex::new(Some(Slow { released, in_time }));
    let opener = move |number: usize| -> Opener {
        let (path, slow) = (path.clone(), slow.lock().unwrap().take_if(|_| number == 1));
        Box::new(move |header| match slow {
            Some(slow) => Ok(Box::new(slow) as Box<dyn Sink>),
            None => Ok(Box::new(PlainSink::create(&path, false, header)?) as Box<dyn Sink>),
        })
    };
    let mut seen = 0;
    let see = move |_: &Pulse| {
        seen += 1;
        if seen == PULSES + 1 {
            // Of the second run.
            let _ = release.send(());
        }
    };
    let report = followed(&runs(2), opener, see).unwrap();
    assert!(is_in_time.recv().unwrap());
    assert_eq!((report.pulses, pulses(&folder.path().join("2"))), (2 * PULSES, PULSES));
}
