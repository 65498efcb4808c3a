//! Receivers with windows of their own: what recordings, the wire and SigMF say of them.

use std::time::Instant;

use nereus::pulse::{Pulse, SampleFormat};
use nereus::receive::Receiver;
use nereus::recording::Recording;
use nereus::recording::header::Header;
use nereus::recording::instrument::AntennaRow;
use nereus::recording::sigmf::{Settings, export};
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use proptest::prelude::*;

use crate::recording_fixture::{header, instrument, pulse};
use crate::wire_fixture::{datagrams_of, kind, long, received_with_header, word};

/// The second channel is that of a receiver of its own.
fn two(format: SampleFormat) -> Header {
    let mut header = header(format);
    let mut instrument = instrument();
    let other = AntennaRow { name: "ear".to_owned(), ..instrument.antennas[1].clone() };
    instrument.antennas.push(other);
    header.instrument = Some(instrument);
    header.receivers.push("ear".to_owned());
    header.channels[1].receiver = "ear".to_owned();
    (header.layout.antennas, header.layout.windows) = (3, 2);
    header.pulses = 200;
    header
}

/// Pulse `n` with windows soon after its emission, the second 6.25 us and a bit later than the first.
fn soon(header: &Header, n: u64) -> Pulse {
    let mut pulse = pulse(header, n);
    pulse.window_start_s = 30e-6 + 1e-9 * n as f64;
    let later_s = 6.25e-6 + 0.3e-9 * n as f64;
    pulse.receiver_window_start_s.copy_from_slice(&[pulse.window_start_s, pulse.window_start_s + later_s]);
    pulse
}

fn recorded(path: &std::path::Path, header: &Header, hdf5: bool) {
    let mut sink: Box<dyn Sink> = match hdf5 {
        #[cfg(feature = "hdf5")]
        true => Box::new(nereus::sinks::hdf5::Hdf5Sink::create(path, None, false, header).unwrap()),
        _ => Box::new(PlainSink::create(path, false, header).unwrap()),
    };
    (0..20).for_each(|n| sink.write(&soon(header, n)).unwrap());
    sink.finish().unwrap();
}

#[test]
fn recordings_hold_the_window_of_every_receiver() {
    let folder = tempfile::tempdir().unwrap();
    for hdf5 in [false, true].into_iter().filter(|hdf5| !hdf5 || cfg!(feature = "hdf5")) {
        let path = folder.path().join(if hdf5 { "two.h5" } else { "two" });
        let sent = two(SampleFormat::Ci16);
        recorded(&path, &sent, hdf5);
        let recording = Recording::open(&path, Some(5..15)).unwrap();
        assert_eq!(recording.header.layout, sent.layout);
        let mut slot = Pulse::new(&recording.layout());
        for place in 0..10 {
            let wanted = soon(&sent, 5 + place as u64);
            recording.pulse(place, &mut slot);
            assert_eq!(slot.window_start_s, wanted.window_start_s);
            assert_eq!(slot.receiver_window_start_s, wanted.receiver_window_start_s);
            for channel in 0..2 {
                assert_eq!(
                    recording.window_start_of(place, channel),
                    wanted.receiver_window_start_s[channel]
                );
            }
        }
    }
    // In one window there is nothing of it, and the version is that of before.
    let plain = |header: &Header, name: &str| {
        recorded(&folder.path().join(name), header, false);
        let meta = std::fs::read(folder.path().join(name).join("meta.json")).unwrap();
        let there = folder.path().join(name).join("pulse/receiver_window_start_s.bin").exists();
        let meta: serde_json::Value = serde_json::from_slice(&meta).unwrap();
        (meta["version"].as_u64().unwrap(), there)
    };
    let mut one = two(SampleFormat::Cf32);
    one.layout.windows = 0;
    let written = |header: &Header, name: &str| {
        let mut sink = Box::new(PlainSink::create(&folder.path().join(name), false, header).unwrap());
        (0..3).for_each(|n| sink.write(&pulse(header, n)).unwrap());
        sink.finish().unwrap();
    };
    written(&one, "one");
    let meta = std::fs::read(folder.path().join("one/meta.json")).unwrap();
    let meta: serde_json::Value = serde_json::from_slice(&meta).unwrap();
    assert_eq!(meta["version"], 1);
    assert!(!folder.path().join("one/pulse/receiver_window_start_s.bin").exists());
    assert_eq!(plain(&two(SampleFormat::Cf32), "again"), (2, true));
}

#[test]
fn sigmf_says_when_the_window_of_a_channel_opens() {
    let folder = tempfile::tempdir().unwrap();
    let sent = two(SampleFormat::Cf32);
    recorded(&folder.path().join("rec"), &sent, false);
    let settings = Settings { out: folder.path().join("out"), ..Settings::default() };
    export(&folder.path().join("rec"), &settings).unwrap();
    for (channel, name) in ["HH", "HV"].iter().enumerate() {
        let meta = std::fs::read(folder.path().join(format!("out-{name}.sigmf-meta"))).unwrap();
        let meta: serde_json::Value = serde_json::from_slice(&meta).unwrap();
        for n in 0..20 {
            let found = meta["annotations"][n]["nereus:window_start_s"].as_f64().unwrap();
            // The text is exact; reading it back is not, in its last digit.
            assert!((found - soon(&sent, n as u64).receiver_window_start_s[channel]).abs() < 1e-20);
        }
    }
}

/// What the wire carries of a pulse.
fn check(found: &[Pulse], sent: &Header, count: u64) {
    assert_eq!(found.len() as u64, count);
    for (n, found) in found.iter().enumerate() {
        let wanted = soon(sent, n as u64);
        assert_eq!((found.index, found.window_start_s), (wanted.index, wanted.window_start_s));
        assert_eq!(found.receiver_window_start_s, wanted.receiver_window_start_s);
        assert!(found.samples == wanted.samples, "{n}");
    }
}

#[test]
fn samples_find_their_pulse_by_the_window_of_their_receiver() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let mut sent = two(format);
        sent.layout.samples = 900;
        let pulses = (0..40).map(|n| soon(&sent, n));
        let (all, _) = datagrams_of(&sent, 1500, pulses);
        let (header, found, report) = received_with_header(&all);
        assert_eq!(header.unwrap().layout.windows, 2);
        check(&found, &sent, 40);
        assert_eq!((report.incomplete, report.malformed, report.unknown, report.duplicates), (0, 0, 0, 0));
        // Stamps are those of each channel's own samples: 6.25 us and 12 times 0.3 ns apart in pulse 12.
        let stamps: Vec<u64> = (0..2)
            .map(|channel| {
                let own = all.iter().filter(|d| kind(d) == 1 && word(d, 4) == 0x1000_0000 + channel);
                let first = own.step_by(if format == SampleFormat::Cf32 { 5 } else { 3 }).nth(12).unwrap();
                long(first, 12)
            })
            .collect();
        assert_eq!(stamps[1] - stamps[0], 6_250_000 + 3_600);
        // A state that was lost costs its pulse and no other.
        let mut states = all
            .iter()
            .enumerate()
            .filter(|(_, d)| kind(d) == 5 && d.len() == 244 + 16 && word(d, 4) >> 28 == 2);
        let (lost, _) = states.nth(24).unwrap();
        let rest = all.iter().enumerate().filter(|(n, _)| *n != lost).map(|(_, d)| d);
        let (_, found, _) = received_with_header(rest);
        assert_eq!(found.len(), 39);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::cases::cases(24), ..ProptestConfig::default() })]

    /// Samples that overtake the state that says where they belong wait for it.
    #[test]
    fn order_on_the_way_does_not_matter(swaps in proptest::collection::vec((30_usize..160, 1_usize..7), 0..40)) {
        let mut sent = two(SampleFormat::Ci16);
        sent.layout.samples = 700;
        let (mut all, _) = datagrams_of(&sent, 1500, (0..20).map(|n| soon(&sent, n)));
        for (at, by) in swaps {
            if at + by < all.len() {
                all.swap(at, at + by);
            }
        }
        let mut receiver = Receiver::new();
        let mut found = Vec::new();
        let mut keep = |pulse: Box<Pulse>| {
            found.push((*pulse).clone());
            Some(pulse)
        };
        all.iter().for_each(|datagram| receiver.take(datagram, Instant::now(), &mut keep));
        receiver.finish(&mut keep);
        check(&found, &sent, 20);
    }
}
