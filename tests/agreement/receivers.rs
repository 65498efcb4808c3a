//! Several receivers, far from each other, each with its own window.

use std::path::Path;

use nereus::config::{self, Run};
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;
use nereus::pulse::{Pulse, Samples};

use crate::cases::some_of;
use crate::runs;

const C: f64 = 299_792_458.0;
const RATE_HZ: f64 = 80e6;
const PULSE_S: f64 = 0.4e-6;
const LEAD_S: f64 = 0.8e-6;
/// Where the transmitter stands, and receivers are at pulse 0.
const TX_M: [f64; 3] = [0.0, -4000.0, 60.0];
const RX_M: [[f64; 3]; 3] = [[-300.0, -3600.0, 40.0], [3000.0, -500.0, 900.0], [200.0, 9000.0, 120.0]];

const SPEED_MPS: [f64; 3] = [4.0, 120.0, -7.0];

/// A coast that sends and three platforms that receive, with a target where windows look; `more` is appended.
fn scene(window: &str, receivers: [&str; 3], more: &str) -> Run {
    let mut text = format!(
        r#"
        [scene]
        duration_s = 0.1
        seed = 5
        {}
        [radar]
        carrier_hz = 9.4e9
        sample_rate_hz = {RATE_HZ:?}
        prf_hz = 1000.0
        channels = ["HH", "VV"]
        waveform = {{ kind = "lfm", bandwidth_hz = 60e6, pulse_s = {PULSE_S:?} }}
        window = {{ samples = 160, {window} }}
        [[platform]]
        name = "coast"
        track = {{ kind = "fixed", position_m = {TX_M:?} }}
        [[transmitter]]
        name = "tx"
        platform = "coast"
        power_w = 10.0
        antenna = {{ kind = "isotropic", gain_dbi = 20.0 }}
        [[target]]
        position_m = [0, 0, 0]
        rcs_m2 = 1e6
        "#,
        if more.contains("[sea]") { "patch_size_m = [32, 32]\nfacet_m = 1.0" } else { "" }
    );
    for (n, (at_m, own)) in RX_M.iter().zip(receivers).enumerate() {
        let speed_mps = SPEED_MPS[n];
        text += &format!(
            r#"
            [[platform]]
            name = "p{n}"
            track = {{ kind = "straight", position_m = {at_m:?}, velocity_mps = [{speed_mps:?}, 0, 0] }}
            [[receiver]]
            name = "r{n}"
            platform = "p{n}"
            antenna = {{ kind = "isotropic", gain_dbi = 10.0 }}
            {own}
            "#
        );
    }
    config::parse(&(text + more), Path::new("receivers.toml"), &[]).unwrap()
}

const FOLLOW: &str = r#"follow = { kind = "at", position_m = [0, 0, 0], lead_us = 0.8 }"#;
const SEA: &str = "[sea]\nwind_mps = 6.0\nwind_from_deg = 30.0\n";
const REFERENCE: &str = "[fidelity]\necho = \"reference\"\n";
const FAST: &str = "[fidelity]\necho = \"fast\"\nerror_db = -60.0\n";

fn made(run: &Run, of: &[u64]) -> Vec<Pulse> {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    let (mut slot, mut worker) = (factory.slot(), factory.worker());
    let make = |index: &u64| {
        worker.make(*index, &mut slot).unwrap();
        slot.clone()
    };
    of.iter().map(make).collect()
}

fn samples(pulse: &Pulse, channel: usize) -> &[num_complex::Complex32] {
    let Samples::Cf32(iq) = &pulse.samples else { panic!("codes") };
    &iq[160 * channel..160 * (channel + 1)]
}

fn apart_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Where the power of a channel is, from the start of its window, s.
fn middle_s(pulse: &Pulse, channel: usize) -> f64 {
    let powers = samples(pulse, channel).iter().map(|s| f64::from(s.norm_sqr()));
    let (sum, first) = powers
        .enumerate()
        .fold((0.0, 0.0), |(sum, first), (i, power)| (sum + power, first + i as f64 * power));
    first / sum / RATE_HZ
}

/// The echo of what windows follow begins a lead after the start of each, whatever the way to it.
#[test]
fn receivers_find_what_they_follow_in_windows_of_their_own() {
    for fidelity in [REFERENCE, FAST] {
        let run = scene(FOLLOW, [""; 3], fidelity);
        for pulse in made(&run, &[0, 57]) {
            let later_s = pulse.index as f64 / 1000.0;
            for receiver in 0..3 {
                let mut at_m = RX_M[receiver];
                at_m[0] += SPEED_MPS[receiver] * later_s;
                let delay_s = (apart_m(TX_M, [0.0; 3]) + apart_m(at_m, [0.0; 3])) / C;
                let start_s = pulse.window_start_of(receiver);
                // The receiver moves on by 1e-6 of its way while the pulse is under way.
                assert!((start_s - (delay_s - LEAD_S)).abs() < 1e-11, "{receiver}: {start_s} {delay_s}");
                for channel in [2 * receiver, 2 * receiver + 1] {
                    let found_s = middle_s(&pulse, channel);
                    assert!((found_s - LEAD_S - 0.5 * PULSE_S).abs() < 0.5 / RATE_HZ, "{channel}: {found_s}");
                }
            }
            assert_eq!(pulse.window_start_s, pulse.window_start_of(0));
            assert_eq!(pulse.flags, 0, "all echoes lie in their windows");
        }
    }
}

/// In the reference a receiver among others records bit by bit what it records alone.
#[test]
fn others_do_not_change_what_a_receiver_records() {
    let own = [r#"window = { start_us = 25.1 }"#, "", r#"window = { start_us = 42.7 }"#];
    let of = [0, 31];
    let together = made(&scene(FOLLOW, own, &(SEA.to_owned() + REFERENCE)), &of);
    for receiver in 0..3 {
        let mut run = scene(FOLLOW, own, &(SEA.to_owned() + REFERENCE));
        run.scene.radar.channels.retain(|channel| channel.receiver == receiver);
        for (pulse, alone) in together.iter().zip(made(&run, &of)) {
            assert!(alone.receiver_window_start_s.is_empty(), "one pair has one window");
            assert_eq!(pulse.window_start_of(receiver), alone.window_start_s);
            for n in 0..2 {
                assert!(samples(&alone, n).iter().any(|s| s.norm_sqr() > 0.0));
                assert!(samples(pulse, 2 * receiver + n) == samples(&alone, n), "{receiver} {n}");
            }
        }
    }
}

/// Antennas of one platform are sampled together, and what is common to all has no list of its own.
#[test]
fn receivers_on_one_platform_share_a_window() {
    let mut run = scene(FOLLOW, [""; 3], REFERENCE);
    for (receiver, ahead_m) in run.scene.radar.receivers.iter_mut().zip([0.0, 0.5, 1.0]) {
        receiver.antenna.platform = 1;
        receiver.antenna.lever_arm = nereus::frames::Vector::new(ahead_m, 0.0, 0.0);
    }
    let pulse = &made(&run, &[3])[0];
    assert!(pulse.receiver_window_start_s.is_empty());
    // With one elsewhere each has an entry; those two have the same one.
    run.scene.radar.receivers[1].antenna.platform = 3;
    let pulse = &made(&run, &[3])[0];
    let [a, b, c] = pulse.receiver_window_start_s[..] else { panic!("{pulse:?}") };
    assert!(a == c && (a - b).abs() > 1e-6, "{a} {b} {c}");
}

/// Blocks and single pulses against the reference, over all pulses: nodes, supports, stagger, echoes of
/// before in some windows alone, ships, breaking waves and rain.
#[test]
fn blocks_place_every_echo_in_the_window_of_its_receiver() {
    let own = ["window = { start_us = 25.1 }", "", ""];
    let ship = "[[ship]]\nhull = \"wigley\"\nlength_m = 9.0\nbeam_m = 2.0\ndraught_m = 0.6\nposition_m = [4, 2]\nheading_deg = 20.0\nspeed_mps = 3.0\necho = true\n";
    for (what, own, settings, more) in some_of([
        ("all follow", [""; 3], &[][..], ""),
        ("one of them fixed", own, &[], ""),
        ("a ship", [""; 3], &[], ship),
        ("stagger and alternation", [""; 3], &[("pri_us", "[900.0, 1100.0]")], ""),
        (
            "the echo of the last pulse in one window",
            ["", "", "window = { start_us = 12.0 }"],
            &[("prf", "20e3")],
            "",
        ),
        ("single pulses", [""; 3], &[("error", "-110")], ""),
    ]) {
        let mut run = scene(FOLLOW, own, &(SEA.to_owned() + more + FAST));
        run.scene.targets.clear();
        for (key, value) in settings {
            match *key {
                "prf" => {
                    run.scene.radar.emissions =
                        nereus::time::PulseTimes::uniform(value.parse().unwrap()).unwrap();
                }
                "pri_us" => {
                    run.scene.radar.emissions = nereus::time::PulseTimes::sequence(&[9e-4, 11e-4]).unwrap();
                    run.scene.radar.tx_polarisation =
                        nereus::scene::radar::TxPolarisation::Alternating(vec![
                            nereus::scene::radar::Polarisation::H,
                            nereus::scene::radar::Polarisation::V,
                        ]);
                }
                _ => {
                    let nereus::echo::Fidelity::Fast(asked) = &mut run.fidelity else { panic!() };
                    asked.error_db = value.parse().unwrap();
                }
            }
        }
        runs::keeps_the_error(what, &run);
    }
}
