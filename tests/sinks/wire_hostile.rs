//! Datagrams that are wrong, forged, or of a sender that begins again.

use std::net::UdpSocket;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use nereus::pulse::{Pulse, SampleFormat};
use nereus::receive::Receiver;
use nereus::receive::listener::{Listener, Opener, Senders, Until, senders};
use nereus::receive::report::Report;
use nereus::recording::header::Header;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use nereus::time::TimeTag;

use proptest::prelude::*;

use crate::recording_fixture::{PRF_HZ, header, pulse};
use crate::wire_fixture::{caught, datagrams, kind, long, word};

/// Descriptions before the first pulse: the run, two platforms, two channels with their contexts.
pub const DESCRIPTIONS: usize = 7;

pub fn run(format: SampleFormat) -> Header {
    let mut header = header(format);
    header.layout.samples = 50;
    header
}

pub fn received<'a>(
    mut receiver: Receiver,
    all: impl IntoIterator<Item = &'a Vec<u8>>,
) -> (Vec<u64>, Report) {
    let mut indices = Vec::new();
    let mut see = |pulse: Box<nereus::pulse::Pulse>| {
        indices.push(pulse.index);
        Some(pulse)
    };
    for datagram in all {
        receiver.take(datagram, Instant::now(), &mut see);
    }
    let report = receiver.finish(&mut see);
    (indices, report)
}

/// A packet with other seconds.
pub fn restamped(datagram: &[u8], seconds: impl Fn(u32) -> u32) -> Vec<u8> {
    let mut forged = datagram.to_vec();
    // Behind header and stream; extension contexts have a class of two words between.
    let at = if kind(datagram) == 5 { 16 } else { 8 };
    forged[at..at + 4].copy_from_slice(&seconds(word(datagram, at)).to_be_bytes());
    forged
}

/// A packet with its seconds set to 2096.
fn of_2096(datagram: &[u8]) -> Vec<u8> {
    restamped(datagram, |_| 3_976_214_400)
}

/// Before: the pulses of 2096 were closed, and every later one was too late: 20 of 60.
#[test]
fn stamps_of_2096_deafen_nobody() {
    let header = run(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 60);
    let per_pulse = (all.len() - DESCRIPTIONS) / 60;
    let at = DESCRIPTIONS + 20 * per_pulse;
    let forged: Vec<Vec<u8>> =
        all[at..at + 10 * per_pulse].iter().map(|datagram| of_2096(datagram)).collect();
    assert!(forged.iter().any(|datagram| kind(datagram) == 1));
    let (indices, report) = received(Receiver::new(), all[..at].iter().chain(&forged).chain(&all[at..]));
    assert_eq!(indices, (0..60).collect::<Vec<_>>());
    assert!(report.implausible > 0 && report.too_late == 0, "{report:?}");
    assert_eq!((report.incomplete, report.missing.pulses_by_index), (0, 0));
}

/// Stamps within the run, but hours ahead: a few are passed over; what goes on so is followed, and left
/// again.
#[test]
fn a_leap_is_followed_when_the_stream_agrees() {
    let mut header = run(SampleFormat::Ci16);
    header.pulses = 100_000_000;
    let (all, _) = datagrams(&header, 1500, 0, 100);
    let ahead = |datagram: &Vec<u8>| restamped(datagram, |seconds| seconds + 90_000);
    let per_pulse = (all.len() - DESCRIPTIONS) / 100;
    let at = DESCRIPTIONS + 10 * per_pulse;
    let signals = all[at..].iter().filter(|datagram| kind(datagram) == 1);
    let few: Vec<Vec<u8>> = signals.clone().take(30).map(ahead).collect();
    let (indices, report) = received(Receiver::new(), all[..at].iter().chain(&few).chain(&all[at..]));
    assert_eq!(indices.len(), 100, "{report:?}");
    // Enough of them lead the receiver away, and it comes back.
    let many: Vec<Vec<u8>> = signals.take(120).map(ahead).collect();
    let (indices, report) = received(Receiver::new(), all[..at].iter().chain(&many).chain(&all[at..]));
    assert!(indices.len() >= 60 && *indices.last().unwrap() == 99, "{report:?}");
}

/// Before: contradictions were counted, and nothing of the second run came.
#[test]
fn a_sender_that_begins_again_is_seen_and_followed() {
    let first = run(SampleFormat::Cf32);
    let mut second = first.clone();
    second.seed += 1;
    second.start = TimeTag::new(first.start.seconds() + 1000, 0.0);
    let (mut all, _) = datagrams(&first, 1500, 0, 30);
    let (begun, _) = datagrams(&second, 1500, 0, 40);
    // The description comes every second; here the sink's first one comes twice.
    all.extend_from_slice(&begun[..DESCRIPTIONS]);
    all.extend(begun);
    let (indices, report) = received(Receiver::following(), &all);
    assert_eq!(indices.len(), 70);
    assert_eq!((indices[29], indices[30], indices[69]), (29, 0, 39));
    assert_eq!((report.restarts, report.pulses), (1, 70));
    let (indices, report) = received(Receiver::new(), &all);
    assert_eq!((indices.len(), report.restarts), (30, 1));
    // One forged description is none.
    let one = &datagrams(&second, 1500, 0, 1).0[..DESCRIPTIONS];
    let (all, _) = datagrams(&first, 1500, 0, 30);
    let (indices, report) = received(Receiver::following(), all[..30].iter().chain(one).chain(&all[30..]));
    assert_eq!((indices.len(), report.restarts), (30, 0));
}

/// The same run from its first pulse: its descriptions are the same, its time stamps go back.
#[test]
fn the_same_run_again_is_followed() {
    let header = run(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 100);
    let (indices, report) = received(Receiver::following(), all.iter().chain(&all));
    assert_eq!((report.restarts, indices[99]), (1, 99));
    // Thirty-two states are needed to believe it, and pulses that were cut are not whole.
    assert!(indices.len() >= 180 && *indices.last().unwrap() == 99, "{}", indices.len());
}

#[test]
fn only_the_sender_that_was_named_is_received() {
    let header = run(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 5);
    let (known, stranger) =
        (UdpSocket::bind("127.0.0.1:0").unwrap(), UdpSocket::bind("127.0.0.1:0").unwrap());
    let from = senders(&known.local_addr().unwrap().to_string()).unwrap();
    let listener = Listener::bind("127.0.0.1:0").unwrap();
    let listener = listener.with(Senders { from: Some(from), ..Senders::default() });
    let to = listener.address();
    let receiving = thread::spawn(move || {
        let until = Until { idle: Some(Duration::from_millis(500)), ..Until::default() };
        listener.receive(until, &AtomicBool::new(false), None, |_| {}).unwrap()
    });
    for datagram in &all {
        stranger.send_to(datagram, to).unwrap();
        known.send_to(datagram, to).unwrap();
    }
    let report = receiving.join().unwrap();
    assert_eq!((report.pulses, report.duplicates), (5, 0));
    assert_eq!(report.strangers, all.len() as u64);
    assert!(senders("no such host.").is_err());
    assert_eq!(senders("127.0.0.1").unwrap()[0].port(), 0);
}

/// Three datagrams a channel: time stamps step back at each channel of a pulse.
pub fn wide(format: SampleFormat) -> Header {
    let mut header = run(format);
    header.layout.samples = 900;
    header
}

/// Where the body of an extension context begins.
const BODY: usize = 28;

fn put<const N: usize>(datagram: &mut [u8], at: usize, bytes: [u8; N]) {
    datagram[at..at + N].copy_from_slice(&bytes);
}

/// The states among datagrams: extension contexts of platforms.
pub fn states(all: &[Vec<u8>]) -> impl Iterator<Item = &Vec<u8>> {
    all.iter().filter(|datagram| kind(datagram) == 5 && word(datagram, 4) >> 28 == 2)
}

/// A state of so much later, in its stamp, its emission and its number.
pub fn later(state: &[u8], by_s: f64) -> Vec<u8> {
    let mut forged = state.to_vec();
    let emission =
        TimeTag::new(long(state, BODY + 24) as i64, f64::from_bits(long(state, BODY + 32))).plus(by_s);
    put(&mut forged, 16, (emission.seconds() as u32).to_be_bytes());
    put(&mut forged, 20, ((emission.fraction_s() * 1e12).round() as u64).to_be_bytes());
    put(&mut forged, BODY, (long(state, BODY) + (by_s * PRF_HZ) as u64).to_be_bytes());
    put(&mut forged, BODY + 24, emission.seconds().to_be_bytes());
    put(&mut forged, BODY + 32, emission.fraction_s().to_bits().to_be_bytes());
    forged
}

/// The datagrams of pulses whose windows open 30 us after the emission.
pub fn near(header: &Header, count: u64) -> Vec<Vec<u8>> {
    sent(header, 0..count)
}

/// The same of some pulses of a run.
fn sent(header: &Header, pulses: impl IntoIterator<Item = u64>) -> Vec<Vec<u8>> {
    let (socket, mut sink) = caught(header, 1500);
    socket.set_nonblocking(true).unwrap();
    let (mut all, mut buffer) = (Vec::new(), vec![0; 1 << 16]);
    for n in pulses {
        sink.write(&Pulse { window_start_s: 30e-6, ..pulse(header, n) }).unwrap();
        while let Ok(length) = socket.recv(&mut buffer) {
            all.push(buffer[..length].to_vec());
        }
    }
    all
}

/// Before: 64 rising stamps in a row were needed, and none came of two channels with three datagrams each.
#[test]
fn the_same_run_again_is_followed_over_several_channels() {
    let header = wide(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 100);
    for receiver in [Receiver::following(), Receiver::new()] {
        let (indices, report) = received(receiver, all.iter().chain(&all));
        assert_eq!(report.restarts, 1, "{report:?}");
        assert!(indices.len() >= 180 && *indices.last().unwrap() == 99, "{}", indices.len());
    }
    // A run that was cut short begins again: its pulses are remembered, and not taken for datagrams that came
    // twice.
    let cut = all.len() / 2;
    let (indices, report) = received(Receiver::following(), all[..cut].iter().chain(&all));
    assert_eq!((report.restarts, *indices.last().unwrap()), (1, 99));
    assert!(indices.len() >= 130, "{}", indices.len());
}

/// Before: the first whole pulses after each gap of more than a second were evidence that the stream was
/// there, and were lost for it.
#[test]
fn a_gap_costs_no_pulse_that_came_whole() {
    let long = (1.5 * PRF_HZ).ceil() as u64;
    for (format, samples) in [(SampleFormat::Ci16, 50), (SampleFormat::Cf32, 900)] {
        let mut header = run(format);
        (header.layout.samples, header.pulses) = (samples, 100_000_000);
        // Gaps of 1.5 s, of 15 s and of 2.5 hours.
        let starts = [0, long + 40, 12 * long, 6000 * long];
        let pulses: Vec<u64> = starts.iter().flat_map(|start| *start..start + 40).collect();
        let all = sent(&header, pulses.iter().copied());
        let (indices, report) = received(Receiver::new(), &all);
        assert_eq!(indices, pulses, "{report:?}");
        assert_eq!((report.pulses, report.incomplete, report.restarts), (160, 0, 0), "{report:?}");
        let (first, last) = (pulses[0], pulses[159]);
        assert_eq!(report.missing.pulses_by_index, last - first + 1 - 160, "{report:?}");
        // Nothing of it is called anybody else's, or out of order.
        assert_eq!((report.implausible, report.stray, report.too_late), (0, 0, 0), "{report:?}");
        assert_eq!((report.overtaken, report.duplicates, report.backwards), (0, 0, 0), "{report:?}");
    }
}

/// Before: pulses 50 minutes ahead were opened, and every true one after them was too late.
#[test]
fn states_that_lie_ahead_deafen_nobody() {
    let mut header = run(SampleFormat::Ci16);
    header.pulses = 100_000_000;
    let all = near(&header, 200);
    let per_pulse = (all.len() - DESCRIPTIONS) / 200;
    let at = DESCRIPTIONS + 20 * per_pulse;
    for (by_s, of) in [
        (3000.0, "number and time"),
        (3000.0, "stamp alone"),
        (30.0, "number and time"),
        (0.9, "number and time"),
        (0.1, "number and time"),
    ] {
        let forged: Vec<Vec<u8>> = states(&all[at..])
            .step_by(2)
            .take(20)
            .map(|state| match of {
                "stamp alone" => restamped(state, |seconds| seconds + by_s as u32),
                _ => later(state, by_s),
            })
            .collect();
        // All at once: nothing true is lost, and what was refused is counted.
        let (indices, report) = received(Receiver::new(), all[..at].iter().chain(&forged).chain(&all[at..]));
        println!("{by_s} s, {of}: {} whole, {report:?}", indices.len());
        assert_eq!((indices.len(), report.restarts), (200, 0));
        assert_eq!((report.last_pulse, report.missing.pulses_by_index, report.backwards), (Some(199), 0, 0));
        if by_s > 1.0 {
            assert_eq!((report.implausible, report.incomplete), (20, 0));
        }
        // One after each pulse, without end.
        let mut mixed = all[..at].to_vec();
        let mut forged = forged.iter().cycle();
        for pulse in all[at..].chunks(per_pulse) {
            mixed.extend(forged.next().cloned());
            mixed.extend_from_slice(pulse);
        }
        let (indices, report) = received(Receiver::new(), &mixed);
        println!("mixed: {} whole, {report:?}", indices.len());
        assert_eq!((indices.len(), report.restarts), (200, 0));
        assert_eq!((report.last_pulse, report.missing.pulses_by_index), (Some(199), 0));
    }
}

/// Before: the pulse was handed on with that number, and no later one was recorded any more.
#[test]
fn numbers_outside_the_run_are_refused() {
    let header = run(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 60);
    let second = |datagram: &&Vec<u8>| word(datagram, 4) == 0x2000_0001;
    for index in [u64::MAX - 5, 100, 59, 0] {
        let mut mixed = all.clone();
        let state = states(&all).filter(second).nth(20).unwrap();
        let at = all.iter().position(|datagram| datagram == state).unwrap();
        let mut forged = state.clone();
        put(&mut forged, BODY, index.to_be_bytes());
        // Another packet count, so that it is not taken for the same packet.
        forged[1] ^= 8;
        mixed.insert(at, forged.clone());
        let (indices, report) = received(Receiver::new(), &mixed);
        assert_eq!(indices, (0..60).collect::<Vec<_>>(), "{index}");
        assert_eq!((report.missing.pulses_by_index, report.backwards), (0, 0), "{index}");
        // As the first state of its pulse, too, but for numbers near the true one: those cost one pulse at
        // most.
        mixed.remove(at);
        mixed.insert(at - 3, forged);
        let (indices, _) = received(Receiver::new(), &mixed);
        assert!(indices.iter().is_sorted() && indices.len() >= 59, "{index}: {indices:?}");
    }
}

/// Before: sums of counts of 2^64 ended the program with `--restart`.
#[test]
fn counts_that_are_large_do_not_overflow() {
    let header = run(SampleFormat::Ci16);
    let (mut all, _) = datagrams(&header, 1500, 0, 100);
    let at =
        all.iter().rposition(|datagram| word(datagram, 4) == 0x2000_0001 && kind(datagram) == 5).unwrap();
    put(&mut all[at], BODY, (u64::MAX - 5).to_be_bytes());
    let (indices, report) = received(Receiver::following(), all.iter().chain(&all).chain(&all));
    assert_eq!(report.restarts, 2);
    assert!(indices.iter().all(|index| *index < 100));
}

/// Before: what came first held for ever.
#[test]
fn forged_descriptions_before_the_first_pulse_are_forgotten() {
    let mut header = run(SampleFormat::Ci16);
    header.pulses = 1000;
    let (all, _) = datagrams(&header, 1500, 0, 900);
    let other = Header { seed: 7, ..header.clone() };
    let wider = Header { layout: nereus::pulse::Layout { samples: 60, ..header.layout }, ..header.clone() };
    let mut crowd = all[1].clone();
    // Platform 0 of 2: of five.
    put(&mut crowd, BODY + 4, 5u32.to_be_bytes());
    let contexts: Vec<Vec<u8>> = (0..3000u32)
        .map(|k| {
            let mut context = all[DESCRIPTIONS - 1].clone();
            assert_eq!(kind(&context), 4);
            put(&mut context, 4, (0x1000_0100 + k).to_be_bytes());
            context
        })
        .collect();
    for (what, forged) in [
        ("another run", datagrams(&other, 1500, 0, 1).0[..1].to_vec()),
        ("a whole run", datagrams(&other, 1500, 0, 1).0[..DESCRIPTIONS].to_vec()),
        ("wider windows", datagrams(&wider, 1500, 0, 1).0[..DESCRIPTIONS].to_vec()),
        ("five platforms", vec![crowd]),
        ("contexts", contexts),
    ] {
        for receiver in [Receiver::new(), Receiver::following()] {
            let (indices, report) = received(receiver, forged.iter().chain(&all));
            // Descriptions come every second: 334 pulses.
            assert!(
                indices.len() >= 230 && *indices.last().unwrap() == 899,
                "{what}: {} {report:?}",
                indices.len()
            );
            assert_eq!(report.pulses, indices.len() as u64);
        }
    }
}

/// A listener of two runs that records into plain folders `1`, `2`, ..., what it leaves, and its report.
fn recorded(all: &[Vec<u8>]) -> (Vec<(String, u64)>, Report) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().to_owned();
    let opener = move |number: usize| -> Opener {
        let path = at.join(number.to_string());
        Box::new(move |header| Ok(Box::new(PlainSink::create(&path, false, header)?) as Box<dyn Sink>))
    };
    let first = opener(1);
    let senders = Senders { restart: true, next: Some(Box::new(opener)), ..Senders::default() };
    let listener = Listener::bind("127.0.0.1:0").unwrap().with(senders);
    let to = listener.address();
    let receiving = thread::spawn(move || {
        let until = Until { idle: Some(Duration::from_millis(500)), ..Until::default() };
        listener.receive(until, &AtomicBool::new(false), Some(first), |_| {}).unwrap()
    });
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    for (k, datagram) in all.iter().enumerate() {
        socket.send_to(datagram, to).unwrap();
        if k % 50 == 49 {
            thread::sleep(Duration::from_millis(5));
        }
    }
    let report = receiving.join().unwrap();
    let pulses = |path: &std::path::Path| std::fs::metadata(path.join("pulse/index.bin")).unwrap().len() / 8;
    let mut left: Vec<(String, u64)> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), pulses(&path)))
        .collect();
    left.sort();
    (left, report)
}

/// Before: a run that was only described left an empty recording.
#[test]
fn a_run_without_pulses_leaves_no_recording() {
    let first = run(SampleFormat::Ci16);
    let second = Header { seed: 7, ..first.clone() };
    let (mut all, _) = datagrams(&first, 1500, 0, 40);
    let (begun, _) = datagrams(&second, 1500, 0, 1);
    all.extend_from_slice(&begun[..DESCRIPTIONS]);
    all.extend_from_slice(&begun[..DESCRIPTIONS]);
    let (left, report) = recorded(&all);
    assert_eq!((report.restarts, report.pulses), (1, 40));
    assert_eq!(left, [("1".to_owned(), 40)]);
    assert_eq!((report.out.len(), report.recorded), (1, Some(40)));
    // With a pulse there are two, and the counts are those of both.
    all.extend_from_slice(&begun[DESCRIPTIONS..]);
    let (left, report) = recorded(&all);
    assert_eq!(left, [("1".to_owned(), 40), ("2".to_owned(), 1)]);
    assert_eq!((report.out.len(), report.pulses, report.recorded), (2, 41, Some(41)));
}

/// Pulses of a stream that goes back are received and not recorded: the report counts the two apart.
#[test]
fn pulses_that_cannot_be_recorded_are_counted_apart() {
    let header = run(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 60);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("got");
    let listener = Listener::bind("127.0.0.1:0").unwrap();
    let to = listener.address();
    let receiving = thread::spawn(move || {
        let until = Until { idle: Some(Duration::from_millis(500)), ..Until::default() };
        let open: Opener =
            Box::new(move |header| Ok(Box::new(PlainSink::create(&path, false, header)?) as Box<dyn Sink>));
        listener.receive(until, &AtomicBool::new(false), Some(open), |_| {}).unwrap()
    });
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    for datagram in all.iter().chain(&all) {
        socket.send_to(datagram, to).unwrap();
        thread::sleep(Duration::from_micros(50));
    }
    let report = receiving.join().unwrap();
    assert!(report.pulses >= 60 + 40, "{report:?}");
    assert_eq!(report.recorded, Some(60));
}

/// Before: a context of another format that came before those of the sender was believed for ever.
#[test]
fn forged_contexts_before_the_first_pulse_are_forgotten() {
    let mut header = run(SampleFormat::Ci16);
    header.pulses = 1000;
    header.channels.truncate(1);
    header.layout.channels = 1;
    let (all, _) = datagrams(&header, 1500, 0, 900);
    let mut floats = run(SampleFormat::Cf32);
    floats.channels.truncate(1);
    floats.layout.channels = 1;
    let is_context = |datagram: &&Vec<u8>| kind(datagram) == 4 && word(datagram, 4) == 0x1000_0000;
    let forged = datagrams(&floats, 1500, 0, 1).0.iter().find(is_context).unwrap().clone();
    let (indices, report) = received(Receiver::new(), std::iter::once(&forged).chain(&all));
    assert!(indices.len() >= 890 && *indices.last().unwrap() == 899, "{} {report:?}", indices.len());
    // Once a pulse has been whole it changes nothing.
    let (indices, report) = received(Receiver::new(), all[..50].iter().chain([&forged]).chain(&all[50..]));
    assert_eq!((indices.len(), report.contradictions), (900, 1));
    assert_eq!(report.contexts[0].format, Some(nereus::receive::context::Format::Ci16));
}

/// Before: samples and states a little ahead of every pulse opened pulses whose end made the true ones late.
#[test]
fn pulses_that_lie_a_little_ahead_cost_none() {
    let header = run(SampleFormat::Ci16);
    let all = near(&header, 100);
    let per_pulse = (all.len() - DESCRIPTIONS) / 100;
    for samples in [true, false] {
        let mut mixed = all[..DESCRIPTIONS].to_vec();
        for pulse in all[DESCRIPTIONS..].chunks(per_pulse) {
            for k in 0..10 {
                // Three intervals ahead.
                let by_s = 0.01 + 1e-5 * f64::from(k);
                mixed.extend(match samples {
                    true => pulse.iter().find(|datagram| kind(datagram) == 1).map(|signal| {
                        let mut forged = signal.clone();
                        put(&mut forged, 12, (long(signal, 12) + (by_s * 1e12) as u64).to_be_bytes());
                        forged
                    }),
                    false => states(pulse).next().map(|state| later(state, by_s)),
                });
            }
            mixed.extend_from_slice(pulse);
        }
        let (indices, report) = received(Receiver::new(), &mixed);
        println!("samples {samples}: {} whole, {report:?}", indices.len());
        assert_eq!((indices.len(), report.missing.pulses_by_index), (100, 0));
    }
}

/// Receives datagrams until nothing of the run has come for half a second, while one more comes again and
/// again; and how long that took.
pub fn until_idle(all: &[Vec<u8>], again: &[u8], most_s: u64) -> (Report, Duration) {
    let listener = Listener::bind("127.0.0.1:0").unwrap();
    let to = listener.address();
    let receiving = thread::spawn(move || {
        let until = Until {
            idle: Some(Duration::from_millis(500)),
            duration: Some(Duration::from_secs(most_s)),
            pulses: None,
        };
        let begun = Instant::now();
        let report = listener.receive(until, &AtomicBool::new(false), None, |_| {}).unwrap();
        (report, begun.elapsed())
    });
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    for datagram in all {
        socket.send_to(datagram, to).unwrap();
    }
    while !receiving.is_finished() {
        // The listener may just have ended.
        let _ = socket.send_to(again, to);
        thread::sleep(Duration::from_millis(100));
    }
    receiving.join().unwrap()
}

/// Before: any datagram, whatever it was, put off the end that `--idle-s` asks for.
#[test]
fn nonsense_does_not_keep_a_reception_from_its_end() {
    let (all, _) = datagrams(&run(SampleFormat::Ci16), 1500, 0, 5);
    let (report, took) = until_idle(&all, b"no packet", 10);
    assert_eq!(report.pulses, 5);
    assert!(report.malformed > 0 && took < Duration::from_secs(8), "{took:?}");
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    /// Fields of any packet set to the worst that they can be, in runs that begin again: nothing panics,
    /// counts add up, and what is whole is of the run.
    #[test]
    fn forged_fields_never_panic(
        forgeries in prop::collection::vec((0usize..2000, 1usize..60, 0usize..12, any::<u64>(), 0usize..400), 1..60),
        follows: bool,
    ) {
        static ALL: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
        let once = ALL.get_or_init(|| near(&run(SampleFormat::Ci16), 60));
        let mut all: Vec<Vec<u8>> = once.iter().chain(once).cloned().collect();
        for (which, at, how, any, to) in forgeries {
            let mut forged = all[which % all.len()].clone();
            let worst = match how {
                0 => 0,
                1 => u64::MAX,
                2 => u64::MAX - 5,
                3 => i64::MAX as u64,
                4 => i64::MIN as u64,
                5 => f64::NAN.to_bits(),
                6 => f64::INFINITY.to_bits(),
                7 => f64::MIN_POSITIVE.to_bits(),
                8 => 1e300f64.to_bits(),
                9 => 999_999_999_999,
                10 => 0x0000_0400_0000_0400,
                _ => any,
            };
            let at = 4 * at;
            if at + 8 <= forged.len() {
                put(&mut forged, at, worst.to_be_bytes());
            }
            all.insert(to % all.len(), forged);
        }
        let receiver = if follows { Receiver::following() } else { Receiver::new() };
        let (indices, report) = received(receiver, &all);
        prop_assert_eq!(report.datagrams, all.len() as u64);
        prop_assert_eq!(report.pulses, indices.len() as u64);
    }
}
