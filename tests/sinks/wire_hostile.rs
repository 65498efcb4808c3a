//! Datagrams that are wrong, forged, or of a sender that begins again.

use std::net::UdpSocket;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use nereus::pulse::SampleFormat;
use nereus::receive::Receiver;
use nereus::receive::listener::{Listener, Senders, Until, senders};
use nereus::receive::report::Report;
use nereus::sinks::sink::Header;
use nereus::time::TimeTag;

use crate::recording_fixture::header;
use crate::wire_fixture::{datagrams, kind, word};

/// Descriptions before the first pulse: the run, two platforms, two channels with their contexts.
const DESCRIPTIONS: usize = 7;

fn run(format: SampleFormat) -> Header {
    let mut header = header(format);
    header.layout.samples = 50;
    header
}

fn received<'a>(mut receiver: Receiver, all: impl IntoIterator<Item = &'a Vec<u8>>) -> (Vec<u64>, Report) {
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
fn restamped(datagram: &[u8], seconds: impl Fn(u32) -> u32) -> Vec<u8> {
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

/// Stamps within the run, but hours ahead: a few are passed over; what goes on so is followed, and left again.
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
    // Sixty-four late datagrams are needed to believe it, and pulses that were cut are not whole.
    assert!(indices.len() >= 180 && *indices.last().unwrap() == 99, "{}", indices.len());
}

#[test]
fn only_the_sender_that_was_named_is_heard() {
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
