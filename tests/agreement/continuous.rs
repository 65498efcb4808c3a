//! Reception in blocks that follow each other without a gap: against a closed form, blocks of another length,
//! the same radar in windows, and the reference.

use std::f64::consts::TAU;
use std::ops::Range;

use nereus::config::Run;
use nereus::pipeline::build;
use nereus::pulse::{Pulse, Samples};
use num_complex::Complex64;

use crate::cases::{sized, some_of};
use crate::runs;
use crate::two_platforms::{self, C, ON_MAST, RATE_HZ, masts, power, tone};

/// The radar of [`two_platforms`].
fn run(sea: bool, radar: &str, more: &str, settings: &[(&str, &str)]) -> Run {
    two_platforms::run(0.02, sea, radar, more, settings)
}

/// Pulses of 1 us.
const PULSES: &str = r#"waveform = { kind = "lfm", bandwidth_hz = 30e6, pulse_s = 1e-6 }"#;

/// Blocks of so many samples.
fn blocks(samples: usize) -> String {
    format!("window = {{ gate = \"continuous\", samples = {samples} }}")
}

/// An emitter of the other platform, 10 MHz off.
fn jammer(train: &str, waveform: &str) -> String {
    format!(
        r#"
        [[emitter]]
        name = "jam"
        platform = "other"
        carrier_hz = 9.41e9
        power_w = 20.0
        antenna = {{ kind = "rectangle", width_m = 0.2, height_m = 0.4 }}
        pointing = {{ kind = "at", position_m = [0, 0, 0] }}
        {train}
        waveform = {waveform}
        "#
    )
}

fn made(run: &Run, range: Range<u64>) -> Vec<Pulse> {
    runs::kept(build::stream(run, range).unwrap())
}

/// The samples of a channel, window after window.
fn stream_of(run: &Run, pulses: &[Pulse], channel: usize) -> Vec<Complex64> {
    let samples = run.scene.radar.window.samples;
    let of = |pulse: &Pulse| {
        let Samples::Cf32(all) = &pulse.samples else { panic!("a converter") };
        let own = all[channel * samples..][..samples].iter();
        own.map(|s| Complex64::new(s.re.into(), s.im.into())).collect::<Vec<_>>()
    };
    pulses.iter().flat_map(of).collect()
}

/// The error of some samples, dB below the power of others.
fn off_db(found: &[Complex64], expected: &[Complex64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let off: Vec<Complex64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    10.0 * (power(&off) / power(expected)).log10()
}

/// The direct path of a carrier without pauses between antennas that rest, `sqrt(P g) lambda/(4 pi d)
/// e^{-j 2 pi f d/c}`, and of a second one 3.7 MHz above it: over all blocks, whatever their length and that
/// of the pulses, and without a step where one ends and the next begins.
#[test]
fn a_carrier_is_one_tone_over_all_blocks() {
    let (offset_hz, power_w, distance_m) = (3.7e6, 5.0f64, 5000.0);
    for (echo, samples, prf_hz) in
        some_of([("fast", 1024, 8000.0), ("reference", 1024, 8000.0), ("fast", 1000, 317.3)])
    {
        let keys = format!(
            "name = \"second\"\ncarrier_hz = {:?}\nprf_hz = 5000.0\npower_w = {power_w:?}",
            9.4e9 + offset_hz
        );
        let alone = masts(distance_m);
        let beside = alone.clone() + &tone(&keys, 200e-6);
        let own = [
            ("fidelity.echo", echo),
            ("fidelity.error_db", "-80"),
            ("transmitter.0.platform", "far"),
            ("transmitter.0.power_w", "5.0"),
            ("transmitter.0.antenna", "{ kind = 'isotropic' }"),
        ];
        let settings = [&own[..], &ON_MAST].concat();
        for second in [false, true] {
            let radar = format!(
                "prf_hz = {prf_hz:?}\nchannels = [\"VV\"]\ndirect_path = true\n{}
                waveform = {{ kind = \"lfm\", bandwidth_hz = 1e-3, pulse_s = {:?} }}",
                blocks(samples),
                1.0 / prf_hz
            );
            let run = run(false, &radar, if second { &beside } else { &alone }, &settings);
            let tone = |carrier_hz: f64, j: usize| {
                let amplitude = power_w.sqrt() * C / carrier_hz / (2.0 * TAU * distance_m);
                let turns = ((carrier_hz - 9.4e9) * j as f64 / RATE_HZ).fract()
                    - (carrier_hz * distance_m / C).fract();
                amplitude * Complex64::cis(TAU * turns)
            };
            // Nothing has arrived before.
            let first = 2000usize.div_ceil(samples) as u64;
            let pulses = made(&run, first..first + sized(300, 60));
            let found = stream_of(&run, &pulses, 0);
            let at = (first as usize * samples..).take(found.len());
            let expected: Vec<Complex64> = at
                .map(|j| tone(9.4e9, j) + if second { tone(9.4e9 + offset_hz, j) } else { Complex64::ZERO })
                .collect();
            let error_db = off_db(&found, &expected);
            let step = |j: usize| {
                let turned = |j: usize| found[j] / expected[j];
                (turned(j) / turned(j - 1)).arg().abs()
            };
            let steps = (samples..found.len()).step_by(samples).map(step);
            let largest = steps.fold(0.0, f64::max);
            println!(
                "{echo}, {samples} samples, second {second}: {error_db:.1} dB, steps of {largest:.1e} rad at most"
            );
            assert!(error_db < -78.0, "{echo}, {samples} samples: {error_db} dB");
            assert!(second || largest < 1e-3, "{echo}, {samples} samples: {largest} rad");
        }
    }
}

/// Blocks of half the length, and of another: the same samples, of pulses, a sea, a target and an emitter.
#[test]
fn the_stream_does_not_depend_on_its_blocks() {
    let emitter = jammer("prf_hz = 9733.0", "{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 3e-6 }");
    for (echo, least_db) in some_of([("fast", -57.0), ("reference", -100.0)]) {
        let of = |samples: usize| {
            let radar = format!("prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\n{PULSES}\n{}", blocks(samples));
            let run = run(true, &radar, &emitter, &[("fidelity.echo", echo), ("scene.duration_s", "0.0045")]);
            let pulses = made(&run, 0..run.scene.pulses);
            [0, 1].map(|channel| stream_of(&run, &pulses, channel))
        };
        let long = of(1024);
        for samples in [512, 700] {
            for (found, expected) in of(samples).iter().zip(&long) {
                let both = found.len().min(expected.len());
                assert!(both > 170_000);
                let error_db = off_db(&found[..both], &expected[..both]);
                let worst = found.iter().zip(expected).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                let most = expected.iter().map(|s| s.norm()).fold(0.0, f64::max);
                println!("{echo}, {samples} samples: {error_db:.1} dB, worst {:.1e}", worst / most);
                assert!(error_db < least_db, "{echo}, {samples} samples: {error_db} dB");
            }
        }
    }
}

/// The windows of a radar are the samples of its stream at their places.
#[test]
fn windows_are_cut_from_the_stream() {
    for (echo, least_db) in some_of([("fast", -57.0), ("reference", -100.0)]) {
        let of = |window: &str| {
            let radar = format!("prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\n{PULSES}\n{window}");
            run(true, &radar, "", &[("fidelity.echo", echo)])
        };
        let (windowed, continuous) = (of("window = { samples = 256, start_us = 15.2 }"), of(&blocks(1000)));
        let stream = made(&continuous, 0..continuous.scene.pulses);
        let windows = made(&windowed, 0..windowed.scene.pulses);
        assert_eq!((stream.len(), windows.len()), (800, 16));
        for channel in 0..2 {
            let (stream, windows) =
                (stream_of(&continuous, &stream, channel), stream_of(&windowed, &windows, channel));
            // 1250 us are 50,000 samples, and 15.2 us are 608.
            let cut = (0..16).flat_map(|n| &stream[50_000 * n + 608..][..256]).copied();
            let cut: Vec<Complex64> = cut.collect();
            let error_db = off_db(&cut, &windows);
            println!("{echo}, channel {channel}: {error_db:.1} dB");
            assert!(error_db < least_db, "{echo}: {error_db} dB");
            // And between them there is nothing.
            let between = power(&stream) - power(&cut);
            assert!(between < 1e-3 * power(&cut), "{echo}: {between}");
        }
    }
}

/// Sweeps so long that Doppler turns within them, over a sea and a target of another Doppler: in blocks, and
/// their error is kept over all of them.
#[test]
fn long_sweeps_are_made_in_blocks() {
    let radar = format!(
        "prf_hz = 2000.0\nchannels = [\"HH\"]\nwaveform = {{ kind = \"lfm\", bandwidth_hz = 15e6, pulse_s = 500e-6 }}\n{}",
        blocks(10_000)
    );
    for asked in some_of(["-60", "-40"]) {
        let settings = [
            ("fidelity.error_db", asked),
            ("radar.sample_rate_hz", "20e6"),
            ("scene.duration_s", "0.06"),
            ("scene.patch_size_m", "[16, 16]"),
            ("target.0.velocity_mps", "[-1, 1, 0]"),
        ];
        let run = run(true, &radar, "", &settings);
        let chosen = runs::plan(&run).chosen;
        assert!(chosen.node_pulses > 1 && chosen.between.is_some(), "{asked}: {chosen:?}");
        runs::keeps_the_error(asked, &run);
    }
}

/// Over all blocks, against the reference.
#[test]
fn blocks_keep_the_error() {
    let pulsed = format!("prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\n{PULSES}");
    let turns = format!(
        "pri_us = [400, 433.25, 410]\nchannels = [\"HH\", \"VV\"]\ntx_polarisation = \"alternating\"\n{PULSES}"
    );
    let full = "prf_hz = 8000.0\nchannels = [\"HH\", \"VV\"]
        waveform = { kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 125e-6 }";
    let two = jammer("prf_hz = 9733.0", "{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 3e-6 }");
    let direct = "\ndirect_path = true";
    for (what, radar, samples, emitters, asked) in some_of([
        ("full duty", full, 4096, "", "-60"),
        ("pulsed", &pulsed, 1024, "", "-60"),
        ("with an emitter", &pulsed, 4096, &two, "-60"),
        ("full duty, short blocks", full, 1024, "", "-40"),
        ("full duty, fine", full, 4096, "", "-80"),
        ("staggered, in turn", &turns, 2048, "", "-60"),
        ("pulsed, coarse", &pulsed, 4096, "", "-40"),
        ("pulsed, fine", &pulsed, 4096, "", "-80"),
        ("full duty, direct", &format!("{full}{direct}"), 4096, &two, "-60"),
    ]) {
        let mut settings = vec![("fidelity.error_db", asked), ("receiver.0.platform", "other")];
        if what.contains("full duty") {
            // The reference takes long for long pulses.
            settings.extend([("scene.duration_s", "0.004"), ("scene.patch_size_m", "[16, 16]")]);
        }
        let run = run(true, &format!("{radar}\n{}", blocks(samples)), emitters, &settings);
        runs::keeps_the_error(what, &run);
    }
}

#[test]
fn blocks_depend_on_their_number_alone() {
    let emitter = jammer("prf_hz = 9733.0", "{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 3e-6 }");
    let radar = format!("prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\n{PULSES}\n{}", blocks(2000));
    let of = |threads: &str, range: Range<u64>| {
        made(&run(true, &radar, &emitter, &[("stream.threads", threads)]), range)
    };
    let whole = of("2", 0..400);
    assert!(of("1", 0..400) == whole, "one thread and two differ");
    assert!(of("3", 131..257) == whole[131..257], "a range differs from that part of the run");
}

/// What is recorded of a block: when it begins, where everything is then, and the delay of what leaves then.
#[test]
fn blocks_have_records() {
    let run =
        run(false, &format!("prf_hz = 800.0\nchannels = [\"HH\"]\n{PULSES}\n{}", blocks(3000)), "", &[]);
    let start = run.scene.start;
    for (n, pulse) in made(&run, 0..run.scene.pulses).iter().enumerate() {
        let t_s = n as f64 * 3000.0 / RATE_HZ;
        assert!((pulse.time.since(start) - t_s).abs() < 1e-15 && pulse.window_start_s == 0.0);
        let [east_m, ..] = pulse.nav_true[0].position_m;
        assert!((east_m - (-40.0 + 90.0 * t_s)).abs() < 1e-9, "{east_m}");
        let target_m = [3.0 + 3.0 * t_s, -4.0 - 5.0 * t_s, 1.0];
        let from_m = [east_m, -2000.0, 1500.0];
        let far_m = target_m.iter().zip(from_m).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        assert!((pulse.target_delay_s[0] * C / 2.0 - far_m).abs() < 0.01, "{far_m}");
        assert_eq!((pulse.flags, pulse.tx_pol), (0, 0));
    }
}
