//! Calibration channels against their closed forms.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use nereus::config::{self, Run};
use nereus::pipeline::stages::PulseFactory;
use nereus::pipeline::{build, factory};
use nereus::pulse::{Pulse, Samples, flags};
use nereus::radar::calibration::turns;
use nereus::time::PulseTimes;
use num_complex::Complex64;
use proptest::prelude::*;

const FS_HZ: f64 = 100e6;
/// Of the configuration.
const OFFSET_HZ: f64 = 10_000_045.5;
const DELAY_S: f64 = 1.234e-6;

fn scenario(settings: &[(&str, &str)]) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/selftest.toml");
    let settings: Vec<_> =
        settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let mut run = config::load(&path, &settings).unwrap();
    run.sinks.clear();
    run
}

fn factory(run: &Run) -> PulseFactory {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let made = factory::factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    made.with_calibration(&run.calibration, &run.scene.radar).unwrap()
}

fn pulses(run: &Run, of: &[u64]) -> Vec<Pulse> {
    let factory = factory(run);
    let mut worker = factory.worker();
    of.iter()
        .map(|&index| {
            let mut slot = factory.slot();
            worker.make(index, &mut slot).unwrap();
            slot
        })
        .collect()
}

/// Samples of one of the channels: echo, tone, loopback.
fn channel(pulse: &Pulse, place: usize) -> Vec<Complex64> {
    let Samples::Cf32(iq) = &pulse.samples else { panic!("codes") };
    let len = iq.len() / 3;
    iq[place * len..(place + 1) * len].iter().map(|s| Complex64::new(s.re.into(), s.im.into())).collect()
}

/// Turns between two numbers, within half a turn.
fn apart(a: f64, b: f64) -> f64 {
    (a - b) - (a - b).round()
}

#[test]
fn the_tone_keeps_level_and_phase_over_a_hundred_thousand_pulses() {
    let run = scenario(&[("scene.duration_s", "500.0")]);
    for pulse in pulses(&run, &[0, 1, 2, 999, 1000, 99_999, 110_999]) {
        let samples = channel(&pulse, 1);
        // 222 intervals are a second: whole and quarter turns, by hand. 10 000 045.5 / 222 = 45045.25.
        let of_pulse = 0.25 * (pulse.index % 4) as f64;
        for (i, s) in samples.iter().enumerate() {
            // f32: half a unit of the last place in each part, 2^-24 of the amplitude.
            assert!((s.norm() / 1e-5 - 1.0).abs() < 1.2e-7, "{}", s.norm());
            let expected = 30.0 / 360.0 + of_pulse + OFFSET_HZ * (20.0013e-6 + i as f64 / FS_HZ);
            // The same of the phase, 2^-24 rad = 1e-8 turns; 2e-8 turns for the emission (5e7 Hz x 2^-53 s
            // and its neighbours).
            let off = apart(s.arg() / TAU, expected);
            assert!(off.abs() < 3e-8, "pulse {}, sample {i}: {off:e} turns", pulse.index);
        }
    }
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    /// Against whole numbers: hertz, and intervals as they are, whole attoseconds.
    #[test]
    fn turns_are_those_of_integers(hz in -50_000_000i64..50_000_000, us in 1u64..100_000, pulse in 0u64..10_000_000_000) {
        let pri_s = us as f64 * 1e-6;
        let times = PulseTimes::sequence(&[pri_s]).unwrap();
        let interval_as = (pri_s * 1e18).round() as i128;
        let rest = (i128::from(hz) * interval_as * i128::from(pulse)).rem_euclid(1_000_000_000_000_000_000);
        let found = turns(hz as f64, &times, pulse, 0.0);
        prop_assert!(found.is_finite());
        // 5e7 Hz, and a fraction of a second that is right to a rounding of its own and one of the sum: 2^-53
        // s each.
        prop_assert!(apart(found, rest as f64 / 1e18).abs() < 2e-8, "{found} {rest}");
    }
}

/// Delay and phase of a signal against the pulse's own spectrum, over the band.
fn fitted(samples: &[Complex64], run: &Run) -> (f64, f64, f64) {
    let waveform = nereus::radar::waveform::from_description(&run.scene.radar.waveform).unwrap();
    // Frequencies of the flat band. Weighted straight line through the phase of S/P after the nominal delay
    // is taken off.
    let ratio = |f_hz: f64| {
        let sum = samples.iter().enumerate().fold(Complex64::ZERO, |sum, (i, s)| {
            sum + s * Complex64::cis(-TAU * (f_hz * i as f64 / FS_HZ).fract())
        });
        sum / FS_HZ / waveform.spectrum(f_hz) * Complex64::cis(TAU * f_hz * DELAY_S)
    };
    let points: Vec<(f64, Complex64)> =
        (-20..=20).map(|k| (1e6 * f64::from(k), ratio(1e6 * f64::from(k)))).collect();
    let mean = points.iter().map(|(_, r)| r).sum::<Complex64>() / points.len() as f64;
    let slope = points.iter().map(|(f, r)| f * (r / mean).arg()).sum::<f64>()
        / points.iter().map(|(f, _)| f * f).sum::<f64>();
    (-slope / TAU, mean.arg() / TAU, mean.norm())
}

#[test]
fn the_loopback_has_its_delay_level_and_phase_in_every_window() {
    for start_us in ["20.0013", "0.0", "333.33333333"] {
        let run = scenario(&[("radar.window.start_us", start_us)]);
        let made = pulses(&run, &[0, 7, 1000]);
        for pulse in &made {
            assert_eq!(channel(pulse, 2), channel(&made[0], 2));
            let (delay_s, turns, amplitude) = fitted(&channel(pulse, 2), &run);
            // What the filter rings over the ends of the window wraps and is missed: beyond 123 samples t^-3
            // leaves 1e-7 of the peak, 41 frequencies of up to 20 MHz make of that 1e-7 / (2 pi 12 MHz
            // sqrt(41)) = 2e-16 s. f32: 4e-8 / (2 pi 12 MHz sqrt(100 samples)) = 5e-17 s.
            assert!(delay_s.abs() < 1e-15, "{delay_s:e}");
            assert!(apart(turns, -45.0 / 360.0).abs() < 1e-7, "{turns}");
            assert!((amplitude / 10f64.powf(-4.5) - 1.0).abs() < 1e-6, "{amplitude:e}");
        }
    }
}

#[test]
fn echoes_are_not_changed_by_a_bit() {
    let with = scenario(&[]);
    let mut without = with.clone();
    without.calibration.clear();
    for echo in ["reference", "fast"] {
        let set = |run: &Run| Run { fidelity: scenario(&[("fidelity.echo", echo)]).fidelity, ..run.clone() };
        for (a, b) in pulses(&set(&with), &[0, 3, 500]).iter().zip(pulses(&set(&without), &[0, 3, 500])) {
            let (Samples::Cf32(a), Samples::Cf32(b)) = (&a.samples, &b.samples) else { panic!("codes") };
            assert_eq!((a.len(), b.len()), (3 * 512, 512));
            assert!(a[..512] == b[..] && b.iter().any(|s| s.re != 0.0));
        }
    }
}

#[test]
fn codes_are_those_of_the_converter() {
    // 1e-5 sqrt(W) in 12 bits of 2e-5 sqrt(W); the loopback, 3.2e-5, saturates.
    let settings = [("radar.adc.bits", "12"), ("radar.adc.full_scale_dbw", "-93.97940008672037")];
    let run = scenario(&settings);
    let floats = pulses(&scenario(&[]), &[5]);
    let codes = pulses(&run, &[5]);
    let Samples::Ci16(iq) = &codes[0].samples else { panic!("floats") };
    let step = run.scene.radar.adc.unwrap().step();
    assert_eq!(codes[0].flags & flags::ADC_SATURATED, flags::ADC_SATURATED);
    let mut held = 0;
    for place in [1, 2] {
        for (s, code) in channel(&floats[0], place).iter().zip(&iq[place * 512..]) {
            for (x, code) in [s.re, s.im].into_iter().zip(code) {
                if (-2048.0 * step..2048.0 * step).contains(&x) {
                    // Half a step, and what f32 is off by.
                    let back = (f64::from(*code) + 0.5) * step;
                    assert!((back - x).abs() <= 0.5 * step + 1.2e-7 * x.abs(), "{back} {x}");
                } else {
                    held += 1;
                    assert!(*code == if x > 0.0 { 2047 } else { -2048 });
                }
            }
        }
    }
    assert!(held > 50, "{held}");
    let tone_alone = Run { calibration: run.calibration[..1].to_vec(), ..run };
    assert_eq!(pulses(&tone_alone, &[5])[0].flags & flags::ADC_SATURATED, 0);
}

#[test]
fn clocks_turn_both_signals() {
    let calm = scenario(&[]);
    let receiver = [("receiver.0.clock.offset_s", "1e-11"), ("receiver.0.clock.drift", "3e-10")];
    let transmitter = [("transmitter.0.clock.offset_s", "4e-11"), ("transmitter.0.clock.drift", "-5e-9")];
    let of = [0, 1000];
    let right = pulses(&calm, &of);
    for (settings, [x_t, y_t], [x_r, y_r]) in [
        (receiver.to_vec(), [0.0; 2], [1e-11, 3e-10]),
        (transmitter.to_vec(), [4e-11, -5e-9], [0.0; 2]),
        ([receiver, transmitter].concat(), [4e-11, -5e-9], [1e-11, 3e-10]),
    ] {
        for (a, b) in right.iter().zip(pulses(&scenario(&settings), &of)) {
            let turned = |place: usize, i: usize| {
                let of = |pulse: &Pulse| channel(pulse, place)[i].arg() / TAU;
                apart(of(&b), of(a))
            };
            // Both clocks at the instant of the sample.
            let at =
                |[x, y]: [f64; 2], i: usize| x + y * (a.index as f64 / 222.0 + 20.0013e-6 + i as f64 / FS_HZ);
            for i in [0, 200, 511] {
                // Twice the rounding of phases; 1e10 Hz x 1e-9 s is ten turns, to 1e-15.
                assert!(apart(turned(1, i), -(10e9 + OFFSET_HZ) * at([x_r, y_r], i)).abs() < 5e-8);
            }
            // The pulse lies in samples 123.4 to 223.4. The transmitter turns by 4e-5 from the first of these
            // samples to the last.
            for i in [130, 175, 217] {
                let x_s = at([x_r, y_r], i) - at([x_t, y_t], i);
                assert!(apart(turned(2, i), -10e9 * x_s).abs() < 5e-8, "{i}: {:e}", turned(2, i));
            }
            let [calm_at, wrong_at] = [a, &b].map(|pulse| {
                let peak = channel(pulse, 2)
                    .into_iter()
                    .enumerate()
                    .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
                peak.unwrap().0
            });
            assert_eq!(calm_at, wrong_at);
        }
    }
}

#[test]
fn one_clock_for_both_ends_does_not_turn_the_loopback() {
    let calm = scenario(&[]);
    // Wrong, drifting and noisy.
    let settings = [
        ("transmitter.0.clock.offset_s", "1e-11"),
        ("transmitter.0.clock.drift", "3e-10"),
        ("transmitter.0.clock.preset", "\"tcxo\""),
        ("receiver.0.clock.same_as", "\"tx\""),
    ];
    let of = [0, 7, 1000];
    let [mut echoes, mut tones] = [0.0f64; 2];
    for (a, b) in pulses(&calm, &of).iter().zip(pulses(&scenario(&settings), &of)) {
        assert_eq!(channel(&b, 2), channel(a, 2));
        let moved = |place: usize| {
            channel(a, place).iter().zip(channel(&b, place)).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max)
        };
        (echoes, tones) = (echoes.max(moved(0)), tones.max(moved(1)));
    }
    // The clock is there: it moves what is not a cable.
    assert!(echoes > 0.0 && tones > 1e-6, "{echoes:e} {tones:e}");
}

#[test]
fn noise_is_that_of_the_receiver_and_comes_when_asked() {
    let calm = scenario(&[]);
    let noisy = scenario(&[("radar.calibration.0.noise", "true"), ("radar.calibration.1.noise", "true")]);
    let of: Vec<u64> = (0..40).collect();
    let (calm, made) = (pulses(&calm, &of), pulses(&noisy, &of));
    // k T0 F 0.875 fs
    let expected_w = 1.380_649e-23 * 290.0 * 10f64.powf(0.3) * 0.875 * FS_HZ;
    for place in [1, 2] {
        let mut sum = 0.0;
        for (a, b) in calm.iter().zip(&made) {
            assert_eq!(channel(a, 0), channel(b, 0));
            sum +=
                channel(a, place).iter().zip(channel(b, place)).map(|(a, b)| (b - a).norm_sqr()).sum::<f64>();
        }
        let mean_w = sum / (40.0 * 512.0);
        // 20480 samples of which 0.875 are independent: 0.75 %, five of them.
        assert!((mean_w / expected_w - 1.0).abs() < 0.0375, "{place}: {mean_w:e} {expected_w:e}");
    }
    let apart = channel(&made[0], 1).iter().zip(channel(&calm[0], 1)).map(|(a, b)| a - b).collect::<Vec<_>>();
    let other = channel(&made[0], 2).iter().zip(channel(&calm[0], 2)).map(|(a, b)| a - b).collect::<Vec<_>>();
    assert!(apart.iter().zip(&other).all(|(a, b)| (a - b).norm() > 0.0));
}

/// The tables of the page hold in the run of the page.
#[test]
fn the_page_has_the_figures_of_the_run() {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/calibration.md")).unwrap();
    let row = |what: &str| -> Vec<f64> {
        let line = page.lines().find(|line| line.starts_with(&format!("| {what} |"))).unwrap();
        let cell = line.split('|').nth(2).unwrap();
        cell.split([' ', ',']).filter_map(|word| word.parse().ok()).collect()
    };
    let run = scenario(&[]);
    let made = pulses(&run, &[0, 1, 1000]);
    let tone: Vec<Vec<Complex64>> = made.iter().map(|pulse| channel(pulse, 1)).collect();
    let degrees = |a: Complex64, b: Complex64| (a * b.conj()).arg().to_degrees();
    // The last digit of the page.
    let near = |found: f64, tabled: f64, digit: f64| {
        assert!((found - tabled).abs() <= 0.5 * digit * 1.01, "{found} {tabled}")
    };
    let tabled = row("power of every sample");
    near(20.0 * tone[0][0].norm().log10(), tabled[0], 1e-3);
    near(tone[0][0].norm(), tabled[1], 1e-9);
    near(tone[0][0].arg().to_degrees(), row("phase of the first sample of pulse 0")[0], 1e-3);
    near(degrees(tone[0][1], tone[0][0]), row("from sample to sample")[0], 1e-4);
    near(degrees(tone[1][0], tone[0][0]), row("from pulse to pulse")[0], 1e-3);
    near(degrees(tone[2][0], tone[0][0]), row("first sample of pulse 1000 minus that of pulse 0")[0], 1e-3);
    let loopback = channel(&made[0], 2);
    let (off_s, turns, amplitude) = fitted(&loopback, &run);
    let delay = row("delay of the compressed pulse after the first sample");
    near((DELAY_S + off_s) * 1e6, delay[0], 1e-5);
    near((DELAY_S + off_s) * FS_HZ, delay[1], 1e-2);
    near((DELAY_S + off_s + made[0].window_start_s) * 1e6, row("the same after the emission")[0], 1e-5);
    near(turns * 360.0, row("phase of the peak")[0], 1e-3);
    near(20.0 * amplitude.log10(), row("peak over the sum of the squared replica")[0], 1e-3);
    // What a processor does: the replica over the samples.
    let replica = factory(&run).replica();
    let at = |j: usize| -> Complex64 {
        loopback[j..]
            .iter()
            .zip(&replica)
            .map(|(s, q)| s * Complex64::new(q.re.into(), -f64::from(q.im)))
            .sum()
    };
    let peak = (0..400).max_by(|a, b| at(*a).norm().total_cmp(&at(*b).norm())).unwrap();
    assert_eq!(peak, 123);
    let clocks = scenario(&[("receiver.0.clock.offset_s", "1e-11")]);
    let turned = degrees(channel(&pulses(&clocks, &[0])[0], 1)[0], tone[0][0]);
    let turn_deg: f64 =
        page.split("`offset_s = 1e-11` that is ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    near(turned, turn_deg, 1e-2);
}
