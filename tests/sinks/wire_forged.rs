//! Single forged datagrams: what they cost a reception.

use std::time::Duration;

use nereus::pulse::SampleFormat;
use nereus::receive::Receiver;

use crate::wire_fixture::{datagrams, kind, word};
use crate::wire_hostile::{DESCRIPTIONS, later, near, received, restamped, run, states, until_idle, wide};

/// Before: the pulse that such a state opened took the middle packets of the true one, of which none was
/// whole.
#[test]
fn a_state_one_sample_early_costs_no_pulse() {
    let header = wide(SampleFormat::Ci16);
    let all = near(&header, 100);
    let per_pulse = (all.len() - DESCRIPTIONS) / 100;
    let mut mixed = all[..DESCRIPTIONS].to_vec();
    for pulse in all[DESCRIPTIONS..].chunks(per_pulse) {
        mixed.extend(states(pulse).next().map(|state| later(state, -1.0 / header.sample_rate_hz)));
        mixed.extend_from_slice(pulse);
    }
    let (indices, report) = received(Receiver::new(), &mixed);
    assert_eq!(indices, (0..100).collect::<Vec<_>>(), "{report:?}");
    assert_eq!((report.implausible, report.misnumbered, report.missing.pulses_by_index), (0, 0, 0));
}

/// Before: every packet after the forged one was counted as overtaken, and no loss was seen in its stream any
/// more.
#[test]
fn loss_is_counted_after_a_forged_packet() {
    let mut header = wide(SampleFormat::Ci16);
    header.pulses = 100_000_000;
    let (all, _) = datagrams(&header, 1500, 0, 1010);
    let per_pulse = 10;
    let of = |what: u32, stream: u32| -> Vec<usize> {
        (DESCRIPTIONS + 20 * per_pulse..all.len())
            .filter(|&k| (kind(&all[k]), word(&all[k], 4)) == (what, stream))
            .collect()
    };
    for (what, kind, stream, skip) in [
        ("first samples", 1, 0x1000_0001, 0),
        ("samples between", 1, 0x1000_0001, 1),
        ("state", 5, 0x2000_0001, 0),
        ("ephemeris", 4, 0x2000_0001, 0),
        ("context of a channel", 4, 0x1000_0001, 0),
        ("description of the run", 5, 0x4000_0000, 0),
    ] {
        let places = of(kind, stream);
        let (at, lost) = (places[skip], places[skip + 1]);
        for by_s in [3000, 100_000] {
            let forged = restamped(&all[at], |seconds| seconds + by_s);
            let kept = all.iter().enumerate().filter(|(k, _)| *k != lost).map(|(_, datagram)| datagram);
            let mut mixed: Vec<Vec<u8>> = kept.cloned().collect();
            mixed.insert(at, forged);
            let (indices, report) = received(Receiver::new(), &mixed);
            assert!(indices.len() >= 1009, "{what}, {by_s} s: {report:?}");
            assert_eq!(
                (report.missing.packets_by_count, report.overtaken),
                (1, 0),
                "{what}, {by_s} s: {report:?}"
            );
        }
    }
}

/// Before: samples that are on no pulse's grid put off the end that `--idle-s` asks for.
#[test]
fn stray_samples_do_not_keep_a_reception_from_its_end() {
    let (all, _) = datagrams(&run(SampleFormat::Ci16), 1500, 0, 5);
    // More samples than a pulse of the run has, with a packet count that none of the run had.
    let (others, _) = datagrams(&wide(SampleFormat::Ci16), 1500, 0, 5);
    let stray = others.iter().rfind(|datagram| kind(datagram) == 1).unwrap();
    let (report, took) = until_idle(&all, stray, 6);
    assert_eq!(report.pulses, 5);
    assert!(report.stray > 0 && took < Duration::from_secs(5), "{took:?}");
}
