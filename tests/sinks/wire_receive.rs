//! The reference receiver: whole pulses bit for bit, and its report of losses, order and nonsense.

use std::net::UdpSocket;
use std::sync::atomic::AtomicBool;
use std::sync::{OnceLock, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use nereus::pulse::{Pulse, SampleFormat, flags};
use nereus::receive::listener::Until;
use nereus::receive::report::Report;
use nereus::receive::{Listener, Receiver};
use nereus::recording::header::Header;
use nereus::sinks::sink::{Sink, SinkReport};
use nereus::sinks::vita49::{Settings, Vita49Sink};
use proptest::prelude::*;

use crate::recording_fixture::{PRF_HZ, header, pulse};
use crate::wire_fixture::{datagrams, datagrams_of, kind, received, word};

/// What the wire carries of a pulse.
fn carried(pulse: &Pulse) -> Pulse {
    let mut carried = pulse.clone();
    carried.nav_true = vec![Default::default(); pulse.nav_reported.len()];
    carried.antennas.clear();
    carried.target_delay_s.clear();
    carried.target_doppler_hz.clear();
    carried.ship_position_m.clear();
    carried.ship_velocity_mps.clear();
    carried.ship_heading_deg.clear();
    carried.clock_x_s.clear();
    carried
}

fn expected(header: &Header, from: u64, to: u64) -> Vec<Pulse> {
    (from..to).map(|n| carried(&pulse(header, n))).collect()
}

/// A pulse whose window opens soon after its emission, as those about it do: where samples come before
/// states, their times alone say where the stream is.
fn soon(header: &Header, n: u64) -> Pulse {
    Pulse { window_start_s: 30e-6, ..pulse(header, n) }
}

/// A header whose windows take three datagrams a channel.
fn wide(format: SampleFormat) -> Header {
    let mut header = header(format);
    header.layout.samples = 900;
    header.pulses = 500;
    header
}

/// Pulses `0..count` over a socket of loopback, paced so that no buffer overflows.
fn over_loopback(address: &str, format: SampleFormat, count: u64) -> (Vec<Pulse>, Report, SinkReport) {
    let header = wide(format);
    let listener = Listener::bind(address).unwrap();
    let settings = Settings { address: listener.address().to_string(), ..Settings::default() };
    let (sender, receiver) = mpsc::channel();
    let receiving = thread::spawn(move || {
        let until = Until {
            pulses: Some(count),
            duration: Some(Duration::from_secs(30)),
            idle: Some(Duration::from_secs(10)),
        };
        listener
            .receive(until, &AtomicBool::new(false), None, |pulse| sender.send(pulse.clone()).unwrap())
            .unwrap()
    });
    let mut sink = Box::new(Vita49Sink::open(&settings, &header).unwrap());
    let mut pulses = Vec::new();
    for n in 0..count {
        sink.write(&pulse(&header, n)).unwrap();
        // The receiver keeps step: this test is of bits, not of buffers.
        pulses.extend(receiver.recv_timeout(Duration::from_secs(10)));
    }
    let sent = sink.finish().unwrap();
    (pulses, receiving.join().unwrap(), sent)
}

#[test]
fn every_bit_of_a_run_arrives() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let (pulses, report, sent) = over_loopback("127.0.0.1:0", format, 60);
        assert!(pulses == expected(&wide(format), 0, 60));
        assert_eq!((report.pulses, report.incomplete, report.malformed, report.unknown), (60, 0, 0, 0));
        assert_eq!((report.missing, report.duplicates, report.overtaken), Default::default());
        assert_eq!((report.first_pulse, report.last_pulse), (Some(0), Some(59)));
        let wire = sent.wire.unwrap();
        assert_eq!((wire.datagrams, wire.lost()), (report.datagrams, 0));
        assert_eq!(report.bytes, sent.bytes);
        let last = &report.platforms[1];
        assert_eq!((last.name.as_str(), last.pulse), ("aircraft", 59));
        let record = pulse(&wide(format), 59).nav_reported[1];
        assert_eq!(
            (last.position_m, last.age_s, last.flags),
            (record.position_m, record.age_s, record.flags)
        );
        let ephemeris = last.ephemeris.unwrap();
        for (found, exact) in ephemeris.position_m.iter().zip(last.ecef_position_m) {
            assert!((found.unwrap() - exact).abs() <= 2f64.powi(-6));
        }
    }
}

#[test]
fn the_wire_runs_over_ipv6() {
    if UdpSocket::bind("[::1]:0").is_err() {
        println!("skipped: this machine has no IPv6 loopback");
        return;
    }
    let (pulses, report, _) = over_loopback("[::1]:0", SampleFormat::Ci16, 5);
    assert!(pulses == expected(&wide(SampleFormat::Ci16), 0, 5));
    assert_eq!((report.pulses, report.malformed), (5, 0));
}

/// Which polarisation bases the antennas have is sent as an addition to the description of a channel: a
/// sender that is older leaves it out, a receiver that is older reads what stands before.
#[test]
fn polarisation_bases_arrive() {
    let header = wide(SampleFormat::Cf32);
    let (all, _) = datagrams(&header, 1500, 0, 1);
    let known = |datagrams: &[Vec<u8>]| {
        let mut receiver = Receiver::new();
        for datagram in datagrams {
            receiver.take(datagram, Instant::now(), &mut |pulse: Box<Pulse>| Some(pulse));
        }
        receiver.header().unwrap().channels.clone()
    };
    assert_eq!(known(&all), header.channels);
    assert_eq!(
        (known(&all)[0].transmit_basis.as_str(), known(&all)[1].receive_basis.as_str()),
        ("local-horizontal", "ludwig-3")
    );
    // Without the two texts: their lengths, and 16 and 8 bytes.
    let older: Vec<Vec<u8>> = all
        .iter()
        .map(|datagram| {
            let mut datagram = datagram.clone();
            if kind(&datagram) == 5 && word(&datagram, 4) >> 28 == 1 {
                datagram.truncate(datagram.len() - 32);
                let words = (datagram.len() / 4) as u16;
                datagram[2..4].copy_from_slice(&words.to_be_bytes());
            }
            datagram
        })
        .collect();
    assert!(older.iter().zip(&all).any(|(a, b)| a.len() < b.len()));
    let channels = known(&older);
    assert_eq!(channels[1].polarisations, "HV");
    assert!(channels.iter().all(|row| row.transmit_basis.is_empty() && row.receive_basis.is_empty()));
}

#[test]
fn a_lost_datagram_is_seen() {
    let header = wide(SampleFormat::Cf32);
    let (all, _) = datagrams(&header, 1500, 0, 30);
    // The second piece of channel 1 in some pulse.
    let signals: Vec<usize> =
        (0..all.len()).filter(|&k| kind(&all[k]) == 1 && word(&all[k], 4) == 0x1000_0001).collect();
    for (lost, of) in [(signals[5 * 10 + 1], 10), (signals[0], 0), (signals[4], 0)] {
        let (pulses, report) = received(all.iter().enumerate().filter(|(k, _)| *k != lost).map(|(_, d)| d));
        assert_eq!((report.pulses, report.incomplete), (29, 1), "{lost}");
        // A stream whose first packet is missing begins with its second.
        let seen_by_count = u64::from(lost != signals[0]);
        assert_eq!(report.missing.packets_by_count, seen_by_count);
        assert_eq!((report.missing.pulses_by_index, report.missing.pulses_by_time), (0, 0));
        let whole: Vec<u64> = pulses.iter().map(|p| p.index).collect();
        assert_eq!(whole, (0..30).filter(|n| *n != of).collect::<Vec<_>>());
        let after = pulses.iter().find(|p| p.index == of + 1).unwrap();
        assert!(after.flags & flags::AFTER_GAP != 0);
    }
}

#[test]
fn lost_pulses_are_seen_by_number_time_and_count() {
    let header = wide(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 40);
    // The state of platform 0 begins with the pulse's number; its ephemeris comes right before it.
    let begins = |n: u64| {
        let state = |d: &Vec<u8>| kind(d) == 5 && word(d, 4) == 0x2000_0000 && word(d, 32) == n as u32;
        all.iter().position(state).unwrap() - 1
    };
    let kept: Vec<&Vec<u8>> = all[..begins(10)].iter().chain(&all[begins(13)..]).collect();
    let (pulses, report) = received(kept);
    assert_eq!((report.pulses, report.incomplete), (37, 0));
    assert_eq!((report.missing.pulses_by_index, report.missing.pulses_by_time), (3, 3));
    // Two channels of 3 pieces, two platforms with ephemeris and state.
    let per_pulse = (all[begins(10)..begins(11)].len()) as u64;
    assert_eq!(per_pulse, 2 * 3 + 4);
    assert_eq!((report.missing.packets_by_count, report.overtaken), (3 * per_pulse, 0));
    assert_eq!(pulses[10].index, 13);
    assert!(pulses[10].flags & flags::AFTER_GAP != 0);
}

#[test]
fn states_may_come_after_the_samples_and_some_may_be_missing() {
    let header = wide(SampleFormat::Cf32);
    let (all, _) = datagrams_of(&header, 1500, (0..4).map(|n| soon(&header, n)));
    let is_state = |d: &&Vec<u8>| kind(d) == 5 && word(d, 4) & 0xf000_0000 == 0x2000_0000;
    // All that is no state first: every pulse is opened by its samples.
    let (states, others): (Vec<_>, Vec<_>) = all.iter().partition(|d| is_state(d));
    let (pulses, report) = received(others.iter().copied().chain(states.iter().copied()));
    assert!(pulses == (0..4).map(|n| carried(&soon(&header, n))).collect::<Vec<_>>());
    assert_eq!((report.pulses, report.incomplete, report.stray), (4, 0, 0));
    // Without the states of one platform no pulse is whole.
    let (pulses, report) =
        received(others.iter().copied().chain(states.iter().copied().filter(|d| word(d, 4) == 0x2000_0000)));
    assert_eq!((pulses.len(), report.incomplete), (0, 4));
}

#[test]
fn a_receiver_may_come_late() {
    let header = wide(SampleFormat::Cf32);
    let (all, _) = datagrams(&header, 1500, 0, 500);
    let (pulses, report) = received(&all[100..]);
    // The next description comes a second after the first: at pulse 334 of 333.3 Hz.
    assert_eq!(pulses.first().map(|p| p.index), Some((PRF_HZ + 1.0) as u64));
    assert_eq!((report.incomplete, report.malformed, report.missing.pulses_by_index), (0, 0, 0));
    assert!(report.undescribed > 0);
}

#[test]
fn another_run_on_the_same_address_is_reported() {
    let first = wide(SampleFormat::Cf32);
    let second = Header { seed: 43, ..first.clone() };
    let (mut all, _) = datagrams(&first, 1500, 0, 3);
    all.extend(datagrams(&second, 1500, 0, 1).0);
    let (pulses, report) = received(&all);
    assert_eq!((pulses.len(), report.contradictions), (3, 1));
}

/// Arrivals that are known: every second pulse 1 ms late, one 5 ms.
#[test]
fn lateness_is_that_of_the_arrivals() {
    const DESCRIPTIONS: usize = 7;
    const PER_PULSE: usize = 2 * 3 + 4;
    let header = wide(SampleFormat::Ci16);
    let (all, _) = datagrams(&header, 1500, 0, 100);
    assert_eq!(all.len(), DESCRIPTIONS + 100 * PER_PULSE);
    let begun = Instant::now();
    let report = |arrival_s: &dyn Fn(usize) -> f64| {
        let mut receiver = Receiver::new();
        for (k, datagram) in all.iter().enumerate() {
            let n = k.saturating_sub(DESCRIPTIONS) / PER_PULSE;
            receiver.take(datagram, begun + Duration::from_secs_f64(arrival_s(n)), &mut Some);
        }
        receiver.finish(&mut Some)
    };
    let late = |n: usize| if n == 57 { 5e-3 } else { (n % 2) as f64 * 1e-3 };
    let lateness = report(&|n| 0.1 + n as f64 / PRF_HZ + late(n)).lateness.unwrap();
    // Instants count nanoseconds: two roundings.
    for (found, exact) in [(lateness.p50_us, 0.0), (lateness.p99_us, 1000.0), (lateness.max_us, 5000.0)] {
        assert!((found - exact).abs() < 3e-3, "{lateness:?}");
    }
    assert_eq!(lateness.pulses, 100);
    // All at once, and at half the pace: not in real time.
    assert_eq!(report(&|_| 0.0).lateness, None);
    assert_eq!(report(&|n| 2.0 * n as f64 / PRF_HZ).lateness, None);
}

/// Nobody listens: every datagram is refused, and the sink ends well.
#[test]
fn an_absent_receiver_costs_only_its_datagrams() {
    // A port that was free a moment ago.
    let address = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let header = wide(SampleFormat::Cf32);
    let mut sink = Box::new(Vita49Sink::open(&Settings { address, ..Settings::default() }, &header).unwrap());
    for n in 0..50 {
        sink.write(&pulse(&header, n)).unwrap();
    }
    let report = sink.finish().unwrap();
    let wire = report.wire.unwrap();
    assert_eq!(report.pulses, 50);
    assert_eq!(wire.datagrams, 50 * (2 * 5 + 4) + 7);
    // The answer to the last one may still be on its way; Linux answers at once on loopback.
    assert!(cfg!(not(target_os = "linux")) || wire.refused == wire.datagrams, "{wire:?}");
}

/// A receiver that does not read: the sink is not held up, and what was lost is seen later.
#[test]
fn a_halted_receiver_does_not_hold_up_the_sink() {
    let header = wide(SampleFormat::Cf32);
    let listener = Listener::bind("127.0.0.1:0").unwrap();
    let settings = Settings { address: listener.address().to_string(), ..Settings::default() };
    let mut sink = Box::new(Vita49Sink::open(&settings, &header).unwrap());
    let begun = Instant::now();
    // More than any buffer of a socket: 14.6 kB a pulse.
    let count = 20 + 2 * listener.buffer_bytes() as u64 / 14_600;
    let mut sent = Pulse::new(&header.layout);
    for n in 0..count {
        crate::recording_fixture::fill(&mut sent, &header, n);
        sink.write(&sent).unwrap();
    }
    // On loopback no datagram waits 20 ms: all of them would take minutes.
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    let report = sink.finish().unwrap();
    assert_eq!(report.pulses, count);
    let until = Until { idle: Some(Duration::from_millis(200)), ..Until::default() };
    let got = listener.receive(until, &AtomicBool::new(false), None, |_| {}).unwrap();
    assert!(got.pulses > 0 && got.pulses < count, "{} of {count}", got.pulses);
    assert!(got.datagrams < report.wire.unwrap().datagrams);
    if let Some(drops) = got.kernel_drops {
        assert!(drops > 0);
    }
}

/// A recording of what was received holds what a recording of the run holds, but for what the wire does not
/// carry.
#[test]
fn a_plain_recording_can_be_made_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let header = wide(SampleFormat::Ci16);
    let whole = folder.path().join("whole");
    let got = folder.path().join("got");
    let mut recording = Box::new(nereus::sinks::plain::PlainSink::create(&whole, false, &header).unwrap());
    let listener = Listener::bind("127.0.0.1:0").unwrap();
    let settings = Settings { address: listener.address().to_string(), ..Settings::default() };
    let mut sink = Box::new(Vita49Sink::open(&settings, &header).unwrap());
    let path = got.clone();
    let receiving = thread::spawn(move || {
        let until = Until { pulses: Some(20), duration: Some(Duration::from_secs(20)), idle: None };
        let open: nereus::receive::listener::Opener = Box::new(move |header| {
            Ok(Box::new(nereus::sinks::plain::PlainSink::create(&path, false, header)?) as Box<dyn Sink>)
        });
        listener.receive(until, &AtomicBool::new(false), Some(open), |_| {}).unwrap()
    });
    for n in 0..20 {
        recording.write(&pulse(&header, n)).unwrap();
        sink.write(&pulse(&header, n)).unwrap();
    }
    recording.finish().unwrap();
    sink.finish().unwrap();
    let report = receiving.join().unwrap();
    assert_eq!(report.out, std::slice::from_ref(&got));
    let mut same = 0;
    for name in [
        "iq",
        "pulse/index",
        "pulse/time_ns",
        "pulse/time_frac_ns",
        "pulse/window_start_s",
        "pulse/flags",
        "pulse/tx_pol",
        "nav/tower/reported/position_m",
        "nav/aircraft/reported/velocity_mps",
        "nav/aircraft/reported/attitude_quat",
    ] {
        let read = |folder: &std::path::Path| std::fs::read(folder.join(format!("{name}.bin"))).unwrap();
        assert!(read(&whole) == read(&got), "{name}");
        same += 1;
    }
    assert_eq!(same, 10);
    assert!(!got.join("nav/aircraft/true").exists() && whole.join("nav/aircraft/true").exists());
    let meta: serde_json::Value =
        serde_json::from_slice(&std::fs::read(got.join("meta.json")).unwrap()).unwrap();
    assert_eq!(meta["truth"], false);
    assert_eq!((&meta["seed"], &meta["adc_step"]), (&42.into(), &2.5e-8.into()));
    assert_eq!(meta["channel"][1]["receiver"], "pod");
}

/// The datagrams of twelve pulses.
fn twelve() -> &'static [Vec<u8>] {
    static ALL: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    let header = wide(SampleFormat::Ci16);
    ALL.get_or_init(|| datagrams_of(&header, 1500, (0..12).map(|n| soon(&header, n))).0)
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    /// Order and doubles do not change what arrives, as long as no datagram is later than eight pulses.
    #[test]
    fn shuffled_and_doubled_datagrams_make_the_same_pulses(
        swaps in prop::collection::vec((0usize..1000, 1usize..7), 0..60),
        doubles in prop::collection::vec(0usize..1000, 0..20),
    ) {
        let header = wide(SampleFormat::Ci16);
        let all = twelve();
        // The descriptions stay first: what comes before them cannot be understood.
        let (first, rest) = all.split_at(7);
        let mut rest: Vec<&Vec<u8>> = rest.iter().collect();
        for (at, by) in swaps {
            let at = at % (rest.len() - by);
            rest.swap(at, at + by);
        }
        let mut doubled = 0;
        for at in doubles {
            let at = at % rest.len();
            rest.insert(at, rest[at]);
            doubled += 1;
        }
        let (pulses, report) = received(first.iter().chain(rest));
        prop_assert!(pulses == (0..12).map(|n| carried(&soon(&header, n))).collect::<Vec<_>>());
        prop_assert_eq!((report.pulses, report.incomplete, report.malformed), (12, 0, 0));
        prop_assert_eq!(report.duplicates, doubled);
        prop_assert_eq!((report.missing.pulses_by_index, report.missing.pulses_by_time), (0, 0));
    }

    /// Nonsense is counted, whatever it is.
    #[test]
    fn random_bytes_never_panic(datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..200), 0..20)) {
        let (pulses, report) = received(&datagrams);
        prop_assert!(pulses.is_empty());
        prop_assert_eq!(report.datagrams, datagrams.len() as u64);
        prop_assert_eq!(report.first_fault.is_some(), report.malformed > 0);
    }

    /// Datagrams of a run with some bytes changed, cut or lengthened.
    #[test]
    fn corrupt_datagrams_never_panic(
        damages in prop::collection::vec((0usize..200, 0usize..1500, any::<u8>(), 0usize..40), 1..40),
        fix_size: bool,
    ) {
        let mut all = twelve().to_vec();
        for (which, at, value, cut) in damages {
            let which = which % all.len();
            let datagram = &mut all[which];
            if let Some(byte) = datagram.get_mut(at) {
                *byte = value;
            }
            if cut < 8 {
                datagram.truncate(datagram.len().saturating_sub(4 * cut));
                if fix_size && datagram.len() >= 4 {
                    let words = (datagram.len() / 4) as u16;
                    datagram[2..4].copy_from_slice(&words.to_be_bytes());
                }
            }
        }
        let (pulses, report) = received(&all);
        prop_assert_eq!(report.datagrams, all.len() as u64);
        prop_assert_eq!(report.pulses, pulses.len() as u64);
        prop_assert!(report.lateness.is_none_or(|late| late.p50_us.is_finite() && late.max_us >= 0.0));
    }
}
