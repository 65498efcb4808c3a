//! Navigation out: ticks, delays, ports that are full, and ports that vanish.

use std::path::Path;

use nereus::pulse::{Pulse, SampleFormat};
use nereus::sinks::nav::{Encoder, Messages, NavSettings, NavSink};
use nereus::sinks::port::Device;
use nereus::sinks::sink::{Sink, SinkReport};
use nereus::sinks::{Kind, Settings, preflight};
use nereus::time::{PulseTimes, TimeTag};

use crate::recording_fixture::header;

/// Says the time after `start`, in nanoseconds, and the easting.
struct Plain(TimeTag);

impl Encoder for Plain {
    fn encode(&mut self, pulse: &Pulse, out: &mut Vec<u8>) -> u64 {
        let ns = (pulse.time.since(self.0) * 1e9).round();
        out.extend(format!("{ns} {}\n", pulse.nav_reported[1].position_m[0]).bytes());
        0
    }
}

fn settings(device: &str, rate_hz: f64, latency_s: f64) -> NavSettings {
    NavSettings {
        device: Device::of(device, 115_200).unwrap(),
        platform: 1,
        messages: Messages::Nmea(vec!["GGA"]),
        rate_hz,
        latency_s,
        force: false,
    }
}

/// Hands pulses over; their easting is their number.
fn run(settings: &NavSettings, prf_hz: f64, pulses: impl IntoIterator<Item = u64>) -> SinkReport {
    let mut header = header(SampleFormat::Cf32);
    header.prf_hz = prf_hz;
    let mut sink = NavSink::open(settings, Box::new(Plain(header.start)), &header).unwrap();
    let times = PulseTimes::uniform(prf_hz).unwrap();
    let mut pulse = Pulse::new(&header.layout);
    for index in pulses {
        pulse.index = index;
        pulse.time = times.emission(header.start, index);
        pulse.nav_reported[1].position_m[0] = index as f64;
        sink.write(&pulse).unwrap();
    }
    Box::new(sink).finish().unwrap()
}

fn stamps(path: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(' ').nth(1).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_message_a_tick() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ticks.txt");
    let device = format!("file:{}", path.display());
    // 333.3 pulses and 5 messages a second: the first pulse at or after k / 5 s is number ceil(66.66 k).
    let report = run(&settings(&device, 5.0, 0.0), 333.3, 0..1000);
    let wanted: Vec<u64> =
        (0..).map(|k| (66.66 * f64::from(k)).ceil() as u64).take_while(|n| *n < 1000).collect();
    assert_eq!(stamps(&path), wanted);
    let port = report.port.unwrap();
    assert_eq!((port.messages, port.lost_messages), (wanted.len() as u64, 0));
    assert_eq!((report.pulses, report.bytes), (1000, std::fs::metadata(&path).unwrap().len()));
    assert_eq!(report.files, std::slice::from_ref(&path));
    // The time is that of the pulse, not of the tick.
    let first = std::fs::read_to_string(&path).unwrap().lines().nth(1).unwrap().to_owned();
    assert_eq!(first.split(' ').next().unwrap(), format!("{:.0}", 67.0 / 333.3 * 1e9));

    // Pulses at ticks belong to them, at any rate, and a part of a run reports what the whole reports there.
    for (name, rate_hz, range, wanted) in [
        ("even", 10.0, 0..1000, (0..10).map(|k| 100 * k).collect::<Vec<u64>>()),
        ("part", 10.0, 101..500, vec![200, 300, 400]),
        ("at", 10.0, 100..301, vec![100, 200, 300]),
        ("third", 1000.0 / 3.0, 0..10, vec![0, 3, 6, 9]),
        ("more", 1e3 * 2.0, 5..9, vec![5, 6, 7, 8]),
    ] {
        let path = folder.path().join(name);
        run(&settings(&format!("file:{}", path.display()), rate_hz, 0.0), 1000.0, range);
        assert_eq!(stamps(&path), wanted, "{name}");
    }
    // Missing pulses: the first one after the tick.
    let path = folder.path().join("gap");
    run(&settings(&format!("file:{}", path.display()), 10.0, 0.0), 1000.0, (0..50).chain(250..350));
    assert_eq!(stamps(&path), [0, 250, 300]);
}

#[test]
fn a_message_leaves_later() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("late");
    let settings = settings(&format!("file:{}", path.display()), 10.0, 0.25);
    let mut header = header(SampleFormat::Cf32);
    header.prf_hz = 1000.0;
    let times = PulseTimes::uniform(1000.0).unwrap();
    let mut sink = NavSink::open(&settings, Box::new(Plain(header.start)), &header).unwrap();
    let mut pulse = Pulse::new(&header.layout);
    for index in 0..400 {
        pulse.time = times.emission(header.start, index);
        pulse.nav_reported[1].position_m[0] = index as f64;
        sink.write(&pulse).unwrap();
        // Reported at pulse n, sent at n + 250.
        let sent = stamps(&path).len() as u64;
        let wanted = if index < 250 { 0 } else { (index - 250) / 100 + 1 };
        assert_eq!(sent, wanted, "pulse {index}");
    }
    Box::new(sink).finish().unwrap();
    assert_eq!(stamps(&path), [0, 100, 200, 300]);
}

#[test]
fn outputs_are_looked_at_first() {
    let folder = tempfile::tempdir().unwrap();
    let there = folder.path().join("there");
    std::fs::write(&there, "x").unwrap();
    let sink = |device: &str| Settings::new(Kind::Nav(settings(device, 5.0, 0.0)), 64);
    let faults = preflight(&[
        sink(&format!("file:{}", there.display())),
        sink("file:no/such/folder/x"),
        sink("tcp://127.0.0.1:9"),
        sink("tcp://127.0.0.1:9"),
    ]);
    let texts: Vec<String> = faults.iter().map(ToString::to_string).collect();
    assert_eq!(texts.len(), 3, "{texts:?}");
    assert!(texts[0].contains("exists already") && texts[2].contains("output of two sinks"), "{texts:?}");
}

#[test]
fn a_connection_that_breaks_is_made_again() {
    use std::io::Read;
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let settings = settings(&format!("tcp://{}", listener.local_addr().unwrap()), 1000.0, 0.0);
    let mut header = header(SampleFormat::Cf32);
    header.prf_hz = 1000.0;
    let mut sink = NavSink::open(&settings, Box::new(Plain(header.start)), &header).unwrap();
    let (first, _) = listener.accept().unwrap();
    drop(first);
    let times = PulseTimes::uniform(1000.0).unwrap();
    let mut pulse = Pulse::new(&header.layout);
    let mut index = 0;
    let mut write = |sink: &mut NavSink| {
        pulse.time = times.emission(header.start, index);
        index += 1;
        sink.write(&pulse).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(10));
    };
    // Half a second until it is tried again.
    for _ in 0..80 {
        write(&mut sink);
    }
    let (mut second, _) = listener.accept().unwrap();
    write(&mut sink);
    let port = Box::new(sink).finish().unwrap().port.unwrap();
    assert_eq!((port.vanished, port.reopened), (1, 1));
    assert!(port.lost_messages > 0 && port.messages + port.lost_messages == 81, "{port:?}");
    let mut text = String::new();
    second.read_to_string(&mut text).unwrap();
    assert!(text.lines().count() > 0 && text.ends_with('\n'));
}

#[cfg(all(unix, feature = "serial"))]
mod terminals {
    use std::io::Read;
    use std::time::Duration;

    use serialport::{SerialPort, TTYPort};

    use super::*;

    /// Nobody reads: the stream goes on, whole messages are lost.
    #[test]
    fn a_terminal_that_nobody_reads_holds_up_nothing() {
        let (mut reader, writer) = TTYPort::pair().unwrap();
        let name = writer.name().unwrap();
        let begun = std::time::Instant::now();
        // 20,000 messages of a dozen bytes are more than a terminal holds.
        let report = run(&settings(&name, 1000.0, 0.0), 1000.0, 0..20_000);
        assert!(begun.elapsed() < Duration::from_secs(10));
        let port = report.port.unwrap();
        assert!(port.lost_messages > 10_000, "{port:?}");
        assert_eq!(port.messages + port.lost_messages, 20_000);
        reader.set_timeout(Duration::from_millis(100)).unwrap();
        let mut text = Vec::new();
        let _ = reader.read_to_end(&mut text);
        assert_eq!(text.len() as u64, port.bytes);
        // Raw: line ends are not turned. What came are whole messages, some of which may be missing between.
        let text = String::from_utf8(text).unwrap();
        assert!(!text.contains('\r'));
        let mut next = 0;
        for line in text[..text.rfind('\n').unwrap()].lines() {
            let number: u64 = line.split(' ').nth(1).unwrap().parse().unwrap();
            assert_eq!(line, format!("{} {number}", number * 1_000_000));
            assert!(number >= next, "{number} after {next}");
            next = number + 1;
        }
    }

    #[test]
    fn a_terminal_that_vanishes_does_not_end_the_run() {
        let (reader, writer) = TTYPort::pair().unwrap();
        let name = writer.name().unwrap();
        let settings = settings(&name, 1000.0, 0.0);
        let header = header(SampleFormat::Cf32);
        let mut sink = NavSink::open(&settings, Box::new(Plain(header.start)), &header).unwrap();
        let mut pulse = Pulse::new(&header.layout);
        let times = PulseTimes::uniform(1000.0).unwrap();
        drop(writer);
        for index in 0..100 {
            pulse.time = times.emission(header.start, index);
            sink.write(&pulse).unwrap();
            if index == 49 {
                std::thread::sleep(Duration::from_millis(20));
            }
        }
        drop(reader);
        for index in 100..200 {
            pulse.time = times.emission(header.start, index);
            sink.write(&pulse).unwrap();
        }
        let port = Box::new(sink).finish().unwrap().port.unwrap();
        assert_eq!(port.vanished, 1, "{port:?}");
        assert!(port.lost_messages >= 99, "{port:?}");
    }
}
