//! Dechirp on reception: against the tones that it must give, and the fast echo against the reference.

use std::f64::consts::{PI, TAU};

use nereus::config::Run;
use nereus::pipeline::build;
use nereus::pulse::{Pulse, Samples};
use num_complex::Complex64;

use crate::cases::some_of;
use crate::runs;
use crate::two_platforms::{self, C, ON_MAST, masts};

const RATE_HZ: f64 = 2e6;
const CARRIER_HZ: f64 = 9.4e9;

fn run(duration_s: f64, sea: bool, radar: &str, more: &str, settings: &[(&str, &str)]) -> Run {
    let rate = [("radar.sample_rate_hz", "2e6")];
    two_platforms::run(duration_s, sea, radar, more, &[&rate[..], settings].concat())
}

fn made(run: &Run, count: u64) -> Vec<Pulse> {
    runs::kept(build::stream(run, 0..count).unwrap())
}

fn samples(pulse: &Pulse) -> Vec<Complex64> {
    let Samples::Cf32(all) = &pulse.samples else { panic!("a converter") };
    all.iter().map(|s| Complex64::new(s.re.into(), s.im.into())).collect()
}

/// `H` of the receiver.
fn response(f_hz: f64) -> f64 {
    let x = f_hz.abs() / RATE_HZ;
    if x <= 0.4 {
        1.0
    } else if x < 0.5 {
        0.5 * (1.0 + (10.0 * PI * (x - 0.4)).cos())
    } else {
        0.0
    }
}

/// A sweep of 150 MHz, 75 times the sample rate, between antennas that rest: `sqrt(P g) lambda/(4 pi d)`
/// times the tone of the module page, in the middle of what sweep and reference have in common.
#[test]
fn an_echo_is_a_tone_of_known_frequency_and_phase() {
    let (bandwidth_hz, pulse_s, power_w, distance_m) = (150e6, 500e-6, 5.0f64, 5000.0);
    let delay_s = distance_m / C;
    for (echo, sweep, reference_us, start_us) in some_of([
        // Sweeps that follow each other without a pause: what is left of the one before is filtered away.
        ("fast", "up", 15.2, 0.0),
        ("reference", "up", 15.2, 0.0),
        ("fast", "down", 18.1, 3.3),
        // Beyond the flat part of the filter.
        ("fast", "up", 19.66, 0.0),
        ("fast", "up", 0.0, 0.0),
        ("fast", "up", 16.678_204_76, 100.123_456),
    ]) {
        let radar = format!(
            "prf_hz = 2000.0\nchannels = [\"VV\"]\ndirect_path = true
            window = {{ samples = 1000, start_us = {start_us:?} }}
            dechirp = {{ delay_us = {reference_us:?} }}
            waveform = {{ kind = \"lfm\", bandwidth_hz = {bandwidth_hz:?}, pulse_s = {pulse_s:?}, sweep = \"{sweep}\" }}"
        );
        let own = [
            ("fidelity.echo", echo),
            ("fidelity.error_db", "-80"),
            ("transmitter.0.platform", "far"),
            ("transmitter.0.power_w", "5.0"),
            ("transmitter.0.antenna", "{ kind = 'isotropic' }"),
        ];
        let run = run(0.003, false, &radar, &masts(distance_m), &[&own[..], &ON_MAST].concat());
        let rate = if sweep == "up" { bandwidth_hz / pulse_s } else { -bandwidth_hz / pulse_s };
        let reference_s = reference_us * 1e-6;
        let beat_hz = -rate * (delay_s - reference_s);
        let amplitude = power_w.sqrt() * C / CARRIER_HZ / (2.0 * TAU * distance_m) * response(beat_hz);
        let (from_s, to_s) = (delay_s.max(reference_s), delay_s.min(reference_s) + pulse_s);
        let (mut off, mut all, mut silent) = (0.0, 0.0, 0.0f64);
        for pulse in made(&run, 3) {
            assert!((pulse.window_start_s - start_us * 1e-6).abs() < 1e-15, "{}", pulse.window_start_s);
            for (j, found) in samples(&pulse).into_iter().enumerate() {
                let t_s = start_us * 1e-6 + j as f64 / RATE_HZ;
                let turns = beat_hz * (t_s - 0.5 * pulse_s)
                    + 0.5 * rate * (delay_s * delay_s - reference_s * reference_s)
                    - (CARRIER_HZ * delay_s).fract();
                let expected = amplitude * Complex64::cis(TAU * turns.fract());
                // What the filter rings of either end has fallen to -70 dB in 32 samples.
                let edge_s = 40.0 / RATE_HZ;
                if t_s > from_s + edge_s && t_s < to_s - edge_s {
                    off += (found - expected).norm_sqr();
                    all += expected.norm_sqr();
                } else if t_s < from_s - edge_s || t_s > to_s + edge_s {
                    silent = silent.max(found.norm() / amplitude.max(1e-30));
                }
            }
        }
        if response(beat_hz) < 1e-3 {
            let most = power_w.sqrt() * C / CARRIER_HZ / (2.0 * TAU * distance_m);
            println!("{echo}, {sweep}, {reference_us} us: beat {beat_hz:.0} Hz, nothing is received");
            assert!((off / 2000.0).sqrt() < 1e-4 * most, "{off}");
            continue;
        }
        let error_db = 10.0 * (off / all).log10();
        println!(
            "{echo}, {sweep}, {reference_us} us: beat {beat_hz:.0} Hz, off by {error_db:.1} dB, else {silent:.1e}"
        );
        assert!(error_db < -60.0, "{echo}, {sweep}, {reference_us} us: {error_db} dB");
        assert!(silent < 1e-3, "{silent}");
    }
}

/// Up and down: two tones, of the signs of either half, where echo and reference are in the same half.
#[test]
fn a_triangular_sweep_gives_two_tones() {
    let (bandwidth_hz, pulse_s, distance_m, reference_s) = (100e6, 500e-6, 5000.0, 16e-6);
    let delay_s = distance_m / C;
    let radar = format!(
        "prf_hz = 1000.0\nchannels = [\"VV\"]\ndirect_path = true
        window = {{ samples = 1100, start_us = 0 }}
        dechirp = {{ delay_us = 16.0 }}
        waveform = {{ kind = \"lfm\", bandwidth_hz = {bandwidth_hz:?}, pulse_s = {pulse_s:?}, sweep = \"triangular\" }}"
    );
    let own = [
        ("fidelity.error_db", "-80"),
        ("transmitter.0.platform", "far"),
        ("transmitter.0.antenna", "{ kind = 'isotropic' }"),
    ];
    let run = run(0.002, false, &radar, &masts(distance_m), &[&own[..], &ON_MAST].concat());
    let rate = 2.0 * bandwidth_hz / pulse_s;
    // tx: 3 W.
    let amplitude = 3f64.sqrt() * C / CARRIER_HZ / (2.0 * TAU * distance_m);
    let (mut off, mut count) = (0.0, 0);
    for (j, found) in samples(&made(&run, 1)[0]).into_iter().enumerate() {
        let t_s = j as f64 / RATE_HZ;
        let edge_s = 40.0 / RATE_HZ;
        // Rising, falling: the middle of the half, and the sign.
        for (half, sign) in [(0.0, 1.0), (1.0, -1.0)] {
            let from_s = 0.5 * half * pulse_s + delay_s + edge_s;
            let to_s = 0.5 * (half + 1.0) * pulse_s + reference_s - edge_s;
            if t_s > from_s && t_s < to_s {
                let middle_s = (0.25 + 0.5 * half) * pulse_s;
                let turns = -sign * rate * (delay_s - reference_s) * (t_s - middle_s)
                    + 0.5 * sign * rate * (delay_s * delay_s - reference_s * reference_s)
                    - (CARRIER_HZ * delay_s).fract();
                off += (found / amplitude - Complex64::cis(TAU * turns.fract())).norm_sqr();
                count += 1;
            }
        }
    }
    let error_db = 10.0 * (off / f64::from(count)).log10();
    println!(
        "triangular: beats of {:.0} Hz, off by {error_db:.1} dB in {count} samples",
        rate * (delay_s - reference_s)
    );
    assert!(count > 800 && error_db < -60.0, "{count}, {error_db}");
}

/// A target that closes: the beat frequency has its Doppler, and turns from sweep to sweep by the carrier.
#[test]
fn doppler_adds_to_the_beat() {
    let (bandwidth_hz, pulse_s, speed_mps, range_m) = (75e6, 500e-6, 30.0, 2400.0);
    let radar = format!(
        "prf_hz = 2000.0\nchannels = [\"VV\"]\nwindow = {{ samples = 1000, start_us = 0 }}
        dechirp = {{ delay_us = 16.0 }}
        waveform = {{ kind = \"lfm\", bandwidth_hz = {bandwidth_hz:?}, pulse_s = {pulse_s:?} }}"
    );
    let own = [
        ("fidelity.error_db", "-80"),
        ("transmitter.0.platform", "mast"),
        ("transmitter.0.antenna", "{ kind = 'isotropic' }"),
        ("receiver.0.platform", "mast"),
        ("receiver.0.antenna", "{ kind = 'isotropic' }"),
        ("target.0.position_m", "[0, 2400, 0.0]"),
        ("target.0.velocity_mps", "[0, -30, 0]"),
    ];
    let run = run(0.004, false, &radar, &masts(5000.0), &own);
    let rate = bandwidth_hz / pulse_s;
    for (n, pulse) in made(&run, 8).iter().enumerate() {
        // Seen from the beginning of the sweep: it meets a target that has moved on for half the way.
        let from_s = n as f64 / 2000.0;
        let closing = speed_mps / C;
        let delay_s = 2.0 * (range_m / C - closing * from_s) / (1.0 + closing);
        let slope = -2.0 * closing / (1.0 + closing);
        // x = u + tau + r u: phase -f0 (tau + r u), the sweep at u, less the reference.
        let phase = |t_s: f64| {
            let u = (t_s - delay_s) / (1.0 + slope);
            let sweep = |t_s: f64| 0.5 * rate * (t_s - 0.5 * pulse_s).powi(2);
            sweep(u) - sweep(t_s - 16e-6) - CARRIER_HZ * (delay_s + slope * u)
        };
        let found = samples(pulse);
        let turn = |j: usize| {
            let t_s = j as f64 / RATE_HZ;
            found[j] / Complex64::cis(TAU * phase(t_s).fract())
        };
        // A single amplitude: no turn is left over the sweep.
        let mean = (100..900).map(turn).sum::<Complex64>() / 800.0;
        let worst = (100..900).map(|j| (turn(j) / mean - 1.0).norm()).fold(0.0, f64::max);
        println!("sweep {n}: delay {:.6} us, off by {worst:.1e}, phase {:.1e}", delay_s * 1e6, mean.arg());
        assert!(worst < 2e-3, "{n}: {worst}");
    }
}

/// Sea, target and direct path; an emitter and windows that follow, too.
#[test]
fn dechirped_echoes_keep_the_error() {
    let sweep = "waveform = { kind = \"lfm\", bandwidth_hz = 40e6, pulse_s = 100e-6 }";
    let radar = |more: &str| {
        format!(
            "prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\n{sweep}\ndechirp = {{ delay_us = 16.7 }}\n{more}"
        )
    };
    let fixed = radar("window = { samples = 220, start_us = 10 }");
    let follows =
        radar("window = { samples = 220, follow = { kind = \"at\", position_m = [0, 0, 0], lead_us = 4 } }");
    let emitter = r#"
        [[emitter]]
        name = "jam"
        platform = "other"
        carrier_hz = 9.41e9
        power_w = 0.02
        antenna = { kind = "rectangle", width_m = 0.2, height_m = 0.4 }
        pointing = { kind = "at", position_m = [0, 0, 0] }
        prf_hz = 9733.0
        waveform = { kind = "lfm", bandwidth_hz = 8e6, pulse_s = 30e-6 }
    "#;
    for (what, radar, more, asked) in some_of([
        ("fixed", &fixed, "", "-60"),
        ("follows", &follows, "", "-60"),
        ("emitter", &fixed, emitter, "-60"),
        ("coarse", &fixed, "", "-40"),
        ("fine", &follows, "", "-80"),
    ]) {
        runs::keeps_the_error(what, &run(0.02, true, radar, more, &[("fidelity.error_db", asked)]));
    }
}
