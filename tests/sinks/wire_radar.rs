//! The description of the radar on the wire: waveform, receive filter, replica, antennas.

use std::collections::BTreeSet;

use nereus::pulse::{Pulse, SampleFormat};
use nereus::recording::header::Header;
use nereus::recording::instrument::Instrument;
use nereus::sinks::sink::Sink;
use num_complex::Complex32;
use proptest::prelude::*;

use crate::recording_fixture::{header, instrument, pulse};
use crate::wire_fixture::{caught, kind, long, received_with_header as received, word};

const SIGNAL: u32 = 0x5000_0000;
const REPLICA: u32 = 0x6000_0000;
const ANTENNAS: u32 = 0x7000_0000;
/// Pulses of a little more than a second.
const SECOND: u64 = 340;

/// A run with such a radar, and a replica of so many samples.
fn described(format: SampleFormat, replica: usize) -> Header {
    let mut header = header(format);
    header.replica = (0..replica).map(|k| Complex32::new(k as f32, 0.5 - k as f32)).collect();
    header.instrument = Some(instrument());
    header.pulses = 0;
    header
}

/// The datagrams of pulses `0..to`, whose windows open as those of a radar do.
fn datagrams(header: &Header, to: u64) -> Vec<Vec<u8>> {
    let (socket, mut sink) = caught(header, 1500);
    socket.set_nonblocking(true).unwrap();
    let (mut all, mut buffer) = (Vec::new(), vec![0; 1 << 16]);
    for n in 0..to {
        sink.write(&Pulse { window_start_s: 22e-6, ..pulse(header, n) }).unwrap();
        // On loopback a datagram is there when the call that sent it returns.
        while let Ok(length) = socket.recv(&mut buffer) {
            all.push(buffer[..length].to_vec());
        }
    }
    all
}

fn is_of(datagram: &[u8], streams: &[u32]) -> bool {
    kind(datagram) == 5 && streams.contains(&word(datagram, 4))
}

#[test]
fn a_receiver_knows_the_radar() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        // In one piece, and in many of which sixteen packet counts are not enough.
        for replica in [7, 6000] {
            let sent = described(format, replica);
            let all = datagrams(&sent, 5);
            let (header, pulses, report) = received(&all);
            let header = header.unwrap();
            assert_eq!(header.instrument, sent.instrument);
            assert!(header.replica == sent.replica);
            assert_eq!((&header.transmitters, &header.receivers), (&sent.transmitters, &sent.receivers));
            assert_eq!((pulses.len(), report.unknown, report.malformed, report.duplicates), (5, 0, 0, 0));
            assert_eq!((report.missing.packets_by_count, report.contradictions), (0, 0));
            assert!(!report.not_carried.contains(&"replica"), "{:?}", report.not_carried);
            for found in &pulses {
                let sent = pulse(&sent, found.index);
                for (antenna, row) in found.antennas.iter().zip(&instrument().antennas) {
                    let platform = usize::from(row.platform == "aircraft");
                    let state = &sent.nav_reported[platform];
                    let [w, x, y, z] = state.attitude_quat;
                    // p + C l, as docs/wire.md has it.
                    let turned = glam::DQuat::from_xyzw(x, y, z, w) * glam::DVec3::from(row.lever_arm_m);
                    let centre = glam::DVec3::from(state.position_m) + turned;
                    assert_eq!(antenna.reported_phase_centre_m, centre.to_array());
                }
            }
        }
    }
}

/// Blocks without a gap are announced as such.
#[test]
fn a_receiver_knows_that_blocks_are_contiguous() {
    for continuous in [false, true] {
        let mut sent = described(SampleFormat::Cf32, 7);
        sent.instrument = Some(Instrument { window: None, continuous, ..instrument() });
        let (header, pulses, report) = received(&datagrams(&sent, 5));
        let header = header.unwrap();
        assert_eq!((header.is_continuous(), pulses.len(), report.malformed), (continuous, 5, 0));
        assert_eq!(header.instrument, sent.instrument);
    }
}

/// A sender of an earlier version ends before the additions: its pulses come all the same.
#[test]
fn a_sender_that_describes_no_radar_is_received() {
    let sent = header(SampleFormat::Cf32);
    let all = datagrams(&sent, 5);
    assert!(!all.iter().any(|datagram| is_of(datagram, &[SIGNAL, REPLICA, ANTENNAS, ANTENNAS + 1])));
    let (header, pulses, report) = received(&all);
    let header = header.unwrap();
    assert_eq!((header.instrument, header.replica.len(), pulses.len()), (None, 0, 5));
    assert!(report.not_carried.contains(&"replica") && report.not_carried.contains(&"instrument"));
}

#[test]
fn a_receiver_that_comes_late_knows_the_radar_within_a_second() {
    // 34 pieces: more than a pulse sends later on, so that nothing comes in a burst.
    let sent = described(SampleFormat::Ci16, 6000);
    let all = datagrams(&sent, 3 * SECOND);
    let bursts = all.chunk_by(|a, b| word(a, 4) == word(b, 4) && is_of(a, &[REPLICA])).map(<[_]>::len);
    assert_eq!(bursts.max(), Some(34), "before the first pulse");
    // From the middle of the first second on.
    let late = &all[all.len() / 6..];
    let burst = late.chunk_by(|a, b| word(a, 4) == word(b, 4) && is_of(a, &[REPLICA])).map(<[_]>::len).max();
    assert_eq!(burst, Some(1));
    let (header, pulses, report) = received(late);
    let header = header.unwrap();
    assert!(header.replica == sent.replica && header.instrument == sent.instrument);
    let first = pulses[0].index;
    assert!((SECOND / 2..SECOND + SECOND / 2).contains(&first), "{first}");
    assert_eq!(pulses.len() as u64, 3 * SECOND - first);
    assert_eq!((report.missing.packets_by_count, report.contradictions), (0, 0));
}

/// What is lost of the description comes again; no pulse is recorded without it.
#[test]
fn a_lost_piece_is_waited_for() {
    let sent = described(SampleFormat::Ci16, 600);
    let all = datagrams(&sent, SECOND);
    for stream in [SIGNAL, REPLICA, ANTENNAS, ANTENNAS + 1] {
        let lost = all.iter().position(|datagram| is_of(datagram, &[stream])).unwrap();
        let without = all.iter().enumerate().filter(|(k, _)| *k != lost).map(|(_, datagram)| datagram);
        let (header, pulses, _) = received(without);
        assert!(header.unwrap().replica == sent.replica, "{stream:#x}");
        assert!((330..SECOND).contains(&pulses[0].index), "{stream:#x}: {}", pulses[0].index);
    }
}

/// Pieces, antennas and waveforms of somebody else do not replace those of a run of which a pulse was whole,
/// and hold nothing up before that.
#[test]
fn forged_descriptions_are_counted_and_left() {
    let sent = described(SampleFormat::Ci16, 600);
    let other = {
        let mut other = described(SampleFormat::Ci16, 600);
        other.replica.iter_mut().for_each(|sample| sample.re += 1.0);
        let instrument = other.instrument.as_mut().unwrap();
        instrument.antennas[1].lever_arm_m[0] += 1.0;
        instrument.filter.flat_hz += 1.0;
        other
    };
    let all = datagrams(&sent, 20);
    let forged: Vec<Vec<u8>> = datagrams(&other, 1);
    let streams = [SIGNAL, REPLICA, ANTENNAS, ANTENNAS + 1];
    let forged: Vec<&Vec<u8>> = forged.iter().filter(|datagram| is_of(datagram, &streams)).collect();
    // Before the first description, and behind the first pulses.
    for at in [0, all.len() / 2] {
        let mixed = all[..at].iter().chain(forged.iter().copied()).chain(&all[at..]);
        let (header, pulses, report) = received(mixed);
        let header = header.unwrap();
        assert!(header.instrument == sent.instrument && header.replica == sent.replica, "{at}");
        assert_eq!(pulses.len(), 20);
        let of: BTreeSet<_> =
            pulses.iter().map(|pulse| pulse.antennas[1].reported_phase_centre_m[0] as i64).collect();
        assert!(of.len() > 1 && report.contradictions > 0, "{report:?}");
    }
}

/// Bytes of an extension context behind its prologue.
fn with_word(datagram: &[u8], at: usize, value: u32) -> Vec<u8> {
    let mut forged = datagram.to_vec();
    forged[28 + at..32 + at].copy_from_slice(&value.to_be_bytes());
    forged
}

#[test]
fn what_cannot_be_is_refused() {
    let all = datagrams(&described(SampleFormat::Ci16, 600), 1);
    let of = |stream: u32| all.iter().find(|datagram| is_of(datagram, &[stream])).unwrap();
    let nan = f32::NAN.to_bits();
    for (stream, at, value, words) in [
        (REPLICA, 0, 1, "such a piece of a replica"),
        (REPLICA, 4, 0, "such a piece of a replica"),
        (REPLICA, 4, 31, "such a piece of a replica"),
        (REPLICA, 8, 0, "such a piece of a replica"),
        (REPLICA, 8, u32::MAX, "such a piece of a replica"),
        (REPLICA, 16, nan, "a sample of a replica that is no number"),
        (SIGNAL, 16, 0x7ff8_0000, "a length or a frequency that is no number"),
        (SIGNAL, 56, 3, "such a place to look at"),
        (ANTENNAS, 56, 4, "such a place to look at"),
        (ANTENNAS, 16, 0x7ff8_0000, "a length or a frequency that is no number"),
        (ANTENNAS, 112, u32::MAX, "more than 1024 bytes"),
        (0x4000_0000, 104 + 16, u32::MAX, "so many antennas, or so long a replica,"),
        (0x4000_0000, 104 + 20, 1 << 20 | 1, "so many antennas, or so long a replica,"),
    ] {
        let report = received([&with_word(of(stream), at, value)]).2;
        let fault = report.first_fault.unwrap_or_else(|| panic!("{stream:#x}, byte {at}"));
        assert!(fault.contains(words), "{stream:#x}, byte {at}: {fault}");
    }
    // An antenna of a number that there is not, and a description in a stream of another, are unknown.
    assert_eq!(received([&with_word(of(ANTENNAS), 0, 1)]).2.unknown, 1);
    let mut elsewhere = of(SIGNAL).clone();
    elsewhere[4..8].copy_from_slice(&REPLICA.to_be_bytes());
    assert_eq!(received([&elsewhere]).2.unknown, 1);
    assert!(f64::from_bits(long(of(SIGNAL), 28 + 8)).is_nan(), "no rate of samples of a sweep");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any change of the descriptions of the radar leaves a receiver that goes on.
    #[test]
    fn changed_descriptions_do_no_harm(
        changes in prop::collection::vec((0usize..12, 7usize..60, any::<u32>()), 1..12),
    ) {
        let mut all = datagrams(&described(SampleFormat::Ci16, 600), 3);
        let places: Vec<usize> = (0..all.len())
            .filter(|k| is_of(&all[*k], &[0x4000_0000, SIGNAL, REPLICA, ANTENNAS, ANTENNAS + 1]))
            .collect();
        for (place, at, value) in changes {
            let datagram = &mut all[places[place % places.len()]];
            let at = 4 * (at % (datagram.len() / 4));
            if at >= 8 {
                datagram[at..at + 4].copy_from_slice(&value.to_be_bytes());
            }
        }
        let (_, pulses, report) = received(&all);
        prop_assert!(pulses.len() <= 3 && report.datagrams == all.len() as u64);
    }
}
