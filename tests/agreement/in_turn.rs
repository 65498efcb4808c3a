//! Waveforms in turn: emission `k` radiates its own pulse, in windows, in blocks and from emitters. Against
//! runs of each pulse alone, against a radar of another carrier, and against the reference.

use std::f64::consts::TAU;

use nereus::config::Run;
use nereus::pipeline::build;
use nereus::pulse::{Pulse, Samples};
use num_complex::Complex64;

use crate::cases::some_of;
use crate::runs;
use crate::two_platforms::{self, RATE_HZ};

const WINDOW: &str = "window = { samples = 256, start_us = 15.2 }";

fn run(sea: bool, radar: &str, more: &str, settings: &[(&str, &str)]) -> Run {
    two_platforms::run(0.02, sea, radar, more, settings)
}

fn made(run: &Run) -> Vec<Pulse> {
    runs::kept(build::stream(run, 0..run.scene.pulses).unwrap())
}

fn samples(pulse: &Pulse) -> Vec<Complex64> {
    let Samples::Cf32(all) = &pulse.samples else { panic!("a converter") };
    all.iter().map(|s| Complex64::new(s.re.into(), s.im.into())).collect()
}

/// Pulses of one length: the reference has the bits of three runs of one pulse each, in turn.
#[test]
fn the_reference_radiates_one_after_the_other() {
    let pulses = [
        "{ kind = \"lfm\", bandwidth_hz = 20e6, pulse_s = 1.3e-6 }",
        "{ kind = \"lfm\", bandwidth_hz = 20e6, pulse_s = 1.3e-6, sweep = \"down\" }",
        "{ kind = \"phase-code\", code = \"barker\", chips = 13, chip_s = 0.1e-6 }",
    ];
    let of = |waveform: &str| {
        let radar = format!("prf_hz = 1000.0\nchannels = [\"HH\"]\nwaveform = {waveform}\n{WINDOW}");
        made(&run(true, &radar, "", &[("fidelity.echo", "reference"), ("scene.patch_size_m", "[4, 4]")]))
    };
    let all = of(&format!("{{ kind = \"in-turn\", waveforms = [{}] }}", pulses.join(", ")));
    assert!(all.len() >= 20);
    for (turn, waveform) in pulses.iter().enumerate() {
        let alone = of(waveform);
        let own = all.iter().zip(&alone).enumerate().filter(|(n, _)| n % 3 == turn);
        own.for_each(|(n, (a, b))| assert_eq!(samples(a), samples(b), "pulse {n}"));
    }
}

/// Step `k` of frequency is what a radar of the carrier `f0 + df` receives, brought down from there, in the
/// middle of a pulse that is long beside a sample: `s_k(t) = s(t) e^{j 2 pi df t}`.
#[test]
fn a_step_is_a_carrier_of_its_own() {
    let window = "window = { samples = 256, start_us = 13.0 }";
    let channels = "prf_hz = 1000.0\nchannels = [\"HH\"]";
    // Gains and path loss change by a few parts in a thousand with the wavelength.
    let isotropic = "{ kind = 'isotropic' }";
    let settings = [
        ("fidelity.echo", "reference"),
        ("transmitter.0.antenna", isotropic),
        ("receiver.0.antenna", isotropic),
    ];
    let stepped = format!(
        "{channels}\nwaveform = {{ kind = \"stepped\", steps = 4, step_hz = 3e6, pulse_s = 2e-6 }}\n{window}"
    );
    let all = made(&run(false, &stepped, "", &settings));
    for k in 0..4usize {
        let offset_hz = (k as f64 - 1.5) * 3e6;
        let plain = format!("{channels}\nwaveform = {{ kind = \"cw\", pulse_s = 2e-6 }}\n{window}");
        let carrier = format!("{:?}", 9.4e9 + offset_hz);
        let other =
            made(&run(false, &plain, "", &[&settings[..], &[("radar.carrier_hz", &carrier)]].concat()));
        for n in (k..12).step_by(4) {
            let (own, wanted) = (samples(&all[n]), samples(&other[n]));
            let strongest = wanted.iter().map(|s| s.norm()).fold(0.0, f64::max);
            // The middle of the echo, 40 samples from its edges.
            let on: Vec<usize> = (0..256).filter(|i| wanted[*i].norm() > 0.5 * strongest).collect();
            let (from, to) = (on[0] + 35, on[on.len() - 1] - 35);
            assert!(to > from, "{from} {to}");
            for i in from..to {
                let t_s = 13.0e-6 + i as f64 / RATE_HZ;
                let brought = wanted[i] * Complex64::cis(TAU * (offset_hz * t_s).fract());
                let wavelength = 9.4e9 / (9.4e9 + offset_hz);
                let off = (own[i] * wavelength - brought).norm() / brought.norm();
                // What the filter rings of the edges, and the pulse's own Doppler of the other carrier.
                assert!(off < 0.02, "step {k}, pulse {n}, sample {i}: {off}");
            }
        }
    }
}

/// Against the reference, over all pulses: sweeps up and down, pulses of different lengths and codes, steps,
/// with stagger, alternating polarisations, blocks without a gap, an emitter.
#[test]
fn pulses_in_turn_keep_the_error() {
    let in_turn = |pulses: &str| format!("waveform = {{ kind = \"in-turn\", waveforms = [{pulses}] }}");
    let sweeps = in_turn(
        "{ kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 1e-6 }, \
         { kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 1e-6, sweep = \"down\" }",
    );
    let unlike = in_turn(
        "{ kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 3e-6 }, { kind = \"cw\", pulse_s = 0.2e-6 }, \
         { kind = \"phase-code\", code = \"golay-a\", chips = 16, chip_s = 0.1e-6, offset_hz = -4e6 }, \
         { kind = \"phase-code\", code = \"golay-b\", chips = 16, chip_s = 0.1e-6, droop_db = 1.0 }, \
         { kind = \"nlfm\", bandwidth_hz = 20e6, pulse_s = 2e-6 }",
    );
    let steps = "waveform = { kind = \"stepped\", steps = 16, step_hz = 2e6, pulse_s = 0.6e-6 }";
    let chirps =
        "waveform = { kind = \"stepped\", steps = 5, step_hz = -6e6, pulse_s = 1e-6, bandwidth_hz = 5e6 }";
    let ports = "channels = [\"HH\", \"VV\"]";
    let windows = |train: &str, waveform: &str| format!("{train}\n{ports}\n{waveform}\n{WINDOW}");
    let uniform = "prf_hz = 2000.0";
    let sweep = "waveform = { kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 1e-6 }";
    let blocks =
        format!("prf_hz = 40e3\n{ports}\n{sweeps}\nwindow = {{ gate = \"continuous\", samples = 2048 }}");
    let other = two_platforms::beside(&format!("carrier_hz = 9.403e9\nprf_hz = 9733.0\n{sweeps}"));
    for (what, radar, emitters, asked) in some_of([
        ("up and down", windows(uniform, &sweeps), "", "-60"),
        ("unlike", windows(uniform, &unlike), "", "-60"),
        ("unlike, fine", windows(uniform, &unlike), "", "-80"),
        ("unlike, coarse", windows(uniform, &unlike), "", "-30"),
        ("steps", windows(uniform, steps), "", "-60"),
        ("steps of sweeps, stagger", windows("pri_us = [500.0, 430.0, 610.0]", chirps), "", "-60"),
        ("alternating", windows("prf_hz = 2000.0\ntx_polarisation = \"alternating\"", &unlike), "", "-60"),
        ("in blocks", blocks, "", "-60"),
        ("an emitter", windows("prf_hz = 1900.0", sweep), other.as_str(), "-60"),
    ]) {
        let length = if what == "in blocks" { "0.003" } else { "0.05" };
        let settings = [
            ("fidelity.error_db", asked),
            ("receiver.0.platform", "other"),
            ("scene.duration_s", length),
            ("scene.patch_size_m", "[16, 16]"),
        ];
        let run = run(true, &radar, emitters, &settings);
        println!("{what}: nodes {}", runs::plan(&run).chosen.node_pulses);
        runs::keeps_the_error(what, &run);
    }
}

/// Windows that receive another emission, which radiated something else, are refused, and a gate without a
/// gap is named.
#[test]
fn windows_of_several_pulses_are_refused() {
    let sweeps = "waveform = { kind = \"in-turn\", waveforms = [{ kind = \"cw\", pulse_s = 1e-6 }, { kind = \"cw\", pulse_s = 2e-6 }] }";
    let radar = format!(
        "prf_hz = 150e3\nchannels = [\"HH\"]\n{sweeps}\nwindow = {{ samples = 256, start_us = 1.0 }}"
    );
    for echo in ["fast", "reference"] {
        let run = run(true, &radar, "", &[("fidelity.echo", echo), ("scene.duration_s", "0.001")]);
        let error = build::stream(&run, 0..run.scene.pulses).err().unwrap().to_string();
        assert!(error.contains("windows receive several of the pulses in turn"), "{error}");
        assert!(error.contains("gate = \"continuous\""), "{error}");
    }
}

/// Eleven plain pulses and one wide sweep among them, of a target that moves fast: what is promised is kept
/// of the sweep as well.
#[test]
fn one_unlike_pulse_among_many_keeps_the_error() {
    let plain = "{ kind = \"cw\", pulse_s = 20e-6 }";
    let sweep = "{ kind = \"lfm\", bandwidth_hz = 38e6, pulse_s = 20e-6 }";
    let pulses: Vec<&str> = (0..12).map(|n| if n == 7 { sweep } else { plain }).collect();
    let radar = format!(
        "prf_hz = 2000.0\nchannels = [\"HH\"]\nwaveform = {{ kind = \"in-turn\", waveforms = [{}] }}\n\
         window = {{ samples = 1200, start_us = 15.2 }}",
        pulses.join(", ")
    );
    let settings = [("target.0.velocity_mps", "[10, -300, 0]"), ("fidelity.error_db", "-50")];
    runs::keeps_the_error("one sweep among eleven plain pulses", &run(false, &radar, "", &settings));
}
