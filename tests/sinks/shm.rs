//! Shared memory: what subscribers get, and what becomes of those that sleep, die, or find no memory.
//! Python's subscriber is in `python/tests`.
//!
//! Subscribers that are stopped or killed are processes: this program again, with one of the tests below that
//! are ignored otherwise.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use nereus::pulse::SampleFormat;
use nereus::receive::shm::{Next, SharedPulse, ShmError, Subscriber};
use nereus::recording::header::Header;
use nereus::sinks::shm::{Settings, ShmSink};
use nereus::sinks::sink::{Sink, SinkError};
use nereus::sinks::{self, Kind};

use crate::recording_fixture::{header, pulse};

const SOON: Duration = Duration::from_secs(10);

/// A service of its own.
fn service() -> String {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    format!("test-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed))
}

fn settings(service: &str, buffer_pulses: usize) -> Settings {
    Settings { service: service.to_owned(), subscribers: 3, buffer_pulses }
}

fn open(service: &str, buffer_pulses: usize, header: &Header) -> Box<ShmSink> {
    Box::new(ShmSink::open(&settings(service, buffer_pulses), header).unwrap())
}

fn next(subscriber: &mut Subscriber) -> SharedPulse {
    match subscriber.next(SOON).unwrap() {
        Next::Pulse(pulse) => pulse,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_subscriber_gets_every_field_of_every_pulse() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        // An odd number of samples: the last word of codes is half full.
        let mut header = header(format);
        header.layout.samples = 33;
        header.layout.channels = 1;
        header.channels.truncate(1);
        let service = service();
        let mut sink = open(&service, 16, &header);
        let mut subscriber = Subscriber::open(&service, SOON).unwrap();
        for n in 5..200 {
            let sent = pulse(&header, n);
            sink.write(&sent).unwrap();
            let got = next(&mut subscriber);
            let known = got.header();
            assert_eq!((known.index, known.sequence, known.flags), (n, n - 5, sent.flags));
            assert_eq!((known.time_ns, known.time_frac_ns), sent.time.to_unix_ns());
            assert_eq!((known.window_start_s, known.tx_pol), (sent.window_start_s, sent.tx_pol));
            assert_eq!((known.channels, known.samples, known.platforms), (1, 33, 2));
            assert_eq!(got.reported(0), Some(sent.nav_reported[0]));
            assert_eq!(got.reported(1), Some(sent.nav_reported[1]));
            assert_eq!(got.reported(2), None);
            let (samples, codes): (&[u8], &[u8]) =
                (bytemuck::cast_slice(got.channel(0)), bytemuck::cast_slice(got.codes(0)));
            let (own, other) = if format == SampleFormat::Cf32 { (samples, codes) } else { (codes, samples) };
            assert_eq!(own, sent.samples.as_bytes());
            assert!(other.is_empty() && got.channel(1).is_empty() && got.codes(usize::MAX).is_empty());
            assert_eq!(known.adc_step, if format == SampleFormat::Ci16 { 2.5e-8 } else { 1.0 });
        }
        let run = subscriber.run().unwrap();
        assert_eq!((&run["platforms"][1], &run["channels"][0]["name"]), (&"aircraft".into(), &"HH".into()));
        // The truth is not published.
        assert!(run["config"].is_null() && run["targets"].is_null());
        let report = sink.finish().unwrap();
        assert!(matches!(subscriber.next(SOON).unwrap(), Next::Ended));
        assert_eq!((subscriber.received(), subscriber.missed()), (195, 0));
        assert!(matches!(subscriber.next(Duration::ZERO).unwrap(), Next::Gone));
        let all = report.subscribers.unwrap();
        assert_eq!((report.pulses, all.seen, all.messages, all.lost), (195, 1, 196, 0));
    }
}

#[test]
fn a_slow_subscriber_loses_the_oldest_and_counts_them() {
    let header = header(SampleFormat::Cf32);
    let service = service();
    let mut sink = open(&service, 8, &header);
    let mut slow = Subscriber::open(&service, SOON).unwrap();
    let mut quick = Subscriber::open(&service, SOON).unwrap();
    for n in 0..1000 {
        sink.write(&pulse(&header, n)).unwrap();
        assert_eq!(next(&mut quick).header().sequence, n);
        if n == 0 {
            assert_eq!(next(&mut slow).header().sequence, 0);
        }
    }
    // The latest eight are there, unharmed.
    for n in 992..1000 {
        let got = next(&mut slow);
        assert_eq!(got.header().sequence, n);
        assert_eq!(
            bytemuck::cast_slice::<_, u8>(got.channel(1)),
            &pulse(&header, n).samples.as_bytes()[400..]
        );
    }
    assert_eq!((slow.received(), slow.missed(), quick.missed()), (9, 991, 0));
    // Who comes now gets them as well.
    let mut late = Subscriber::open(&service, SOON).unwrap();
    sink.write(&pulse(&header, 1000)).unwrap();
    assert_eq!(next(&mut late).header().sequence, 993);
    assert_eq!(late.missed(), 0);
    // No place for a fourth.
    let fault = Subscriber::open(&service, SOON).unwrap_err().to_string();
    assert!(fault.contains("ExceedsMaxSupportedSubscribers"), "{fault}");
    assert_eq!(sink.finish().unwrap().subscribers.unwrap().lost, 0);
}

/// Subscribers hold all that they may, and one of them sleeps: there is memory for the next pulse all the
/// same.
#[test]
fn memory_suffices_for_subscribers_that_hold_pulses() {
    let header = header(SampleFormat::Cf32);
    let service = service();
    let mut sink = open(&service, 2, &header);
    let mut all: Vec<Subscriber> = (0..3).map(|_| Subscriber::open(&service, SOON).unwrap()).collect();
    let mut held: Vec<Vec<SharedPulse>> = vec![vec![], vec![], vec![]];
    for n in 0..200 {
        sink.write(&pulse(&header, n)).unwrap();
        for (place, subscriber) in all.iter_mut().enumerate() {
            // Pulses of different ages in every hand.
            if n % (place as u64 * 3 + 1) == 0 {
                if held[place].len() == sinks::shm::BORROWED {
                    held[place].remove(0);
                }
                held[place].push(next(subscriber));
            }
        }
    }
    for pulses in &held {
        for held in pulses {
            let n = held.header().index;
            assert_eq!(
                bytemuck::cast_slice::<_, u8>(held.channel(0)),
                &pulse(&header, n).samples.as_bytes()[..400]
            );
        }
    }
    assert_eq!(sink.finish().unwrap().subscribers.unwrap().lost, 0);
}

#[test]
fn a_service_has_one_publisher() {
    let header = header(SampleFormat::Cf32);
    let service = service();
    let sink = open(&service, 8, &header);
    let expected = format!(
        "shared memory service '{service}': another run publishes there; end it, or name another service"
    );
    let fault = ShmSink::open(&settings(&service, 8), &header).unwrap_err();
    assert_eq!(fault.to_string(), expected);
    let kind = |name: &str| sinks::Settings::new(Kind::Shm(settings(name, 8)), 4);
    let faults: Vec<String> = sinks::preflight(&[kind(&service)]).iter().map(ToString::to_string).collect();
    assert_eq!(faults, [expected]);
    sink.finish().unwrap();
    assert!(sinks::preflight(&[kind(&service)]).is_empty());
    let faults = sinks::preflight(&[kind("a"), kind("a")]);
    assert_eq!(faults[0].to_string(), "a: is the output of two sinks; each needs its own");
}

#[test]
fn nobody_publishes() {
    let fault = Subscriber::open("no-such-service", Duration::ZERO).unwrap_err();
    assert!(matches!(fault, ShmError::Nobody { .. }), "{fault}");
}

/// More than there can be.
#[test]
fn memory_that_is_not_there_is_reported() {
    let mut header = header(SampleFormat::Cf32);
    header.layout.samples = 1 << 20;
    let fault = ShmSink::open(&settings(&service(), 1 << 20), &header).unwrap_err();
    let text = fault.to_string();
    assert!(matches!(fault, SinkError::NoSharedMemory { .. }) && !fault.is_wrong_input(), "{text}");
    assert!(text.contains("lower buffer_pulses"), "{text}");
}

/// A file system of 2 MiB in the place of /dev/shm, of this process alone.
#[test]
fn a_full_file_system_is_reported() {
    let program = std::env::current_exe().unwrap();
    let script = "mount -t tmpfs -o size=2m none /dev/shm || exit 77; exec \"$0\" \"$@\"";
    let child = Command::new("unshare")
        .args(["--mount", "sh", "-c", script])
        .arg(program)
        .args(["--exact", "shm::in_little_memory", "--ignored", "--nocapture"])
        .output();
    let Ok(child) = child else {
        println!("skipped: unshare");
        return;
    };
    let text = String::from_utf8_lossy(&child.stdout).into_owned() + &String::from_utf8_lossy(&child.stderr);
    match child.status.code() {
        Some(0) => assert!(text.contains("1 passed"), "{text}"),
        // A test that fails.
        Some(101) => panic!("{text}"),
        _ => println!("skipped: unshare --mount (needs root): {text}"),
    }
}

#[test]
#[ignore = "run by a_full_file_system_is_reported with a small /dev/shm"]
fn in_little_memory() {
    let header = header(SampleFormat::Cf32);
    let service = service();
    let fault = ShmSink::open(&settings(&service, 4000), &header).unwrap_err().to_string();
    println!("{fault}");
    let expected = format!("shared memory service '{service}': needs 6 MiB, 2 MiB of /dev/shm are free");
    assert!(fault.starts_with(&expected), "{fault}");
    // Nothing is left, and less than that can be had.
    let mut sink = open(&service, 100, &header);
    for n in 0..500 {
        sink.write(&pulse(&header, n)).unwrap();
    }
    sink.finish().unwrap();
    let left: Vec<_> =
        std::fs::read_dir("/dev/shm").unwrap().flatten().map(|file| file.file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().starts_with("nereus")), "{left:?}");
}

/// This program again, as a process of its own.
fn process(test: &str, service: &str) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", &format!("shm::{test}"), "--ignored", "--nocapture"])
        .env("NEREUS_TEST_SERVICE", service)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Reads lines of a process up to one that holds a word.
fn until(out: &mut impl BufRead, word: &str) -> String {
    let mut line = String::new();
    while out.read_line(&mut line).unwrap() > 0 {
        if line.contains(word) {
            return line;
        }
        line.clear();
    }
    panic!("no {word}");
}

fn signal(child: &Child, name: &str) {
    let done = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(done.success());
}

#[test]
#[ignore = "a process that subscribes"]
fn subscriber_process() {
    let mut subscriber = Subscriber::open(&std::env::var("NEREUS_TEST_SERVICE").unwrap(), SOON).unwrap();
    println!("subscribed");
    let mut last = None;
    while let Next::Pulse(pulse) = subscriber.next(Duration::from_secs(20)).unwrap() {
        if last.is_none() {
            println!("began");
        }
        last = Some(pulse.header().sequence);
    }
    println!("end: last {last:?}, received {}, missed {}", subscriber.received(), subscriber.missed());
}

#[test]
#[ignore = "a process that publishes"]
fn publisher_process() {
    let header = header(SampleFormat::Cf32);
    let mut sink = open(&std::env::var("NEREUS_TEST_SERVICE").unwrap(), 8, &header);
    for n in 0.. {
        sink.write(&pulse(&header, n)).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// One subscriber is killed, one is stopped and wakes up later, one goes on: it gets everything.
#[test]
fn subscribers_that_die_or_sleep_cost_nobody_else_a_pulse() {
    let header = header(SampleFormat::Cf32);
    let service = service();
    let mut sink = open(&service, 200, &header);
    let mut dies = process("subscriber_process", &service);
    let mut sleeps = process("subscriber_process", &service);
    let mut outs = [&mut dies, &mut sleeps].map(|child| BufReader::new(child.stdout.take().unwrap()));
    let mut good = Subscriber::open(&service, SOON).unwrap();
    let mut n = 0;
    let mut publish = |pulses: u64| {
        for _ in 0..pulses {
            sink.write(&pulse(&header, n)).unwrap();
            assert_eq!(next(&mut good).header().sequence, n);
            n += 1;
            std::thread::sleep(Duration::from_micros(500));
        }
    };
    outs.iter_mut().for_each(|out| drop(until(out, "subscribed")));
    publish(1);
    outs.iter_mut().for_each(|out| drop(until(out, "began")));
    publish(100);
    signal(&dies, "-KILL");
    signal(&sleeps, "-STOP");
    dies.wait().unwrap();
    publish(1000);
    signal(&sleeps, "-CONT");
    publish(100);
    // The place of the one that died is free again for another.
    let mut after = Subscriber::open(&service, SOON).unwrap();
    let end = sink.finish().unwrap();
    let (mut last, mut rest) = (until(&mut outs[1], "end:"), String::new());
    last.truncate(last.trim_end().len());
    outs[1].read_to_string(&mut rest).unwrap();
    sleeps.wait().unwrap();
    let number = |key: &str| -> u64 {
        let at = last.find(key).unwrap() + key.len();
        last[at..].chars().take_while(char::is_ascii_digit).collect::<String>().parse().unwrap()
    };
    let (received, missed) = (number("received "), number("missed "));
    assert_eq!(number("last Some("), 1200);
    assert_eq!(received + missed, 1201, "{last}");
    // A buffer of 200 while 1000 went by.
    assert!((750..=1000).contains(&missed), "{last}");
    assert_eq!((good.received(), good.missed()), (1201, 0));
    assert!(matches!(after.next(SOON).unwrap(), Next::Pulse(_)));
    assert_eq!((end.pulses, end.subscribers.unwrap().lost), (1201, 0));
}

#[test]
fn a_run_that_was_killed_leaves_nothing_in_the_way() {
    let header = header(SampleFormat::Cf32);
    let service = service();
    let mut run = process("publisher_process", &service);
    let mut subscriber = Subscriber::open(&service, SOON).unwrap();
    for _ in 0..50 {
        next(&mut subscriber);
    }
    signal(&run, "-KILL");
    run.wait().unwrap();
    let ending = loop {
        match subscriber.next(Duration::from_millis(300)).unwrap() {
            Next::Pulse(_) | Next::Quiet => {}
            ending => break ending,
        }
    };
    assert!(matches!(ending, Next::Gone), "{ending:?}");
    // The next run, beside a subscriber of the one that was killed, which gets its pulses.
    let mut sink = open(&service, 8, &header);
    sink.write(&pulse(&header, 7)).unwrap();
    let before = subscriber.missed();
    assert_eq!(next(&mut subscriber).header().index, 7);
    assert_eq!(subscriber.missed(), before);
    sink.finish().unwrap();
}
