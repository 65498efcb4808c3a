//! Pulses that droop keep the error, and what is wrong in the front end is the same whatever is asked.

use nereus::pipeline::build;
use nereus::pulse::Samples;
use num_complex::Complex64;

use crate::runs::{self, holds, pulses};

const COASTAL: &str = "configs/coastal.toml";

#[test]
fn drooping_pulses_keep_the_error() {
    holds(COASTAL, &[("radar.waveform.droop_db", "3")], &[-60.0, -30.0]);
    let coded = "{ kind = 'phase-code', code = 'barker', chips = 13, chip_s = 2e-8, droop_db = 2 }";
    holds(COASTAL, &[("radar.waveform", coded)], &[-60.0]);
}

/// Every error at once: a part of a run is bit-identical, and each of them changes what is received.
#[test]
fn a_part_of_a_run_with_front_end_errors_is_bit_identical() {
    let table = "{ iq_gain_db = 0.5, iq_phase_deg = 2, offset_dbw = -150, stc_full_us = 30, blanking = true, \
                 agc_level_dbw = -120, tx_level_rms_db = 0.1, tx_phase_rms_deg = 1, jitter_rms_s = 1e-12 }";
    let settings = [("radar.front_end", table), ("radar.noise_figure_db", "3")];
    let whole = pulses(COASTAL, &settings, "2", 0..60);
    assert!(pulses(COASTAL, &settings, "1", 20..60) == whole[20..], "a part differs");
    let ideal = pulses(COASTAL, &settings[1..], "1", 0..8);
    for keys in [
        "iq_gain_db = 0.5",
        "iq_phase_deg = 2",
        "offset_dbw = -150, offset_phase_deg = 30",
        "stc_full_us = 30, stc_exponent = 2, stc_depth_db = 20",
        "agc_level_dbw = -140, agc_attack_us = 0.2, agc_release_us = 3, agc_depth_db = 30",
        "tx_level_rms_db = 0.1",
        "tx_phase_rms_deg = 1",
        "jitter_rms_s = 1e-12, jitter_if_hz = 60e6",
    ] {
        let table = format!("{{ {keys} }}");
        let found = pulses(COASTAL, &[("radar.front_end", &*table), settings[1]], "1", 0..8);
        assert!(found[3].samples != ideal[3].samples, "{keys} changes nothing");
    }
    assert!(pulses(COASTAL, &[("radar.front_end", "{}"), settings[1]], "1", 0..8) == ideal, "it is not free");
}

/// A transmitter that is not stable multiplies every pulse by one number; levels and phases have their
/// deviations (within four standard errors of 400), and windows that receive several pulses are refused.
#[test]
fn pulses_of_an_unstable_transmitter_are_multiples() {
    let quiet = [("stream.pace", "fast")];
    let unstable = [("radar.front_end", "{ tx_level_rms_db = 0.5, tx_phase_rms_deg = 3 }")];
    let wanted = [0.5, 3f64.to_radians()];
    let made = |settings: &[(&str, &str)]| {
        let run = runs::scene(COASTAL, settings);
        runs::kept(build::stream(&run, 0..400).unwrap())
    };
    let (plain, other) = (made(&quiet), made(&[&quiet[..], &unstable].concat()));
    let mut sums = [0.0; 2];
    for (plain, other) in plain.iter().zip(&other) {
        let [plain, other] = [plain, other].map(|pulse| {
            let Samples::Cf32(samples) = &pulse.samples else { panic!("a converter") };
            samples.iter().map(|s| Complex64::new(s.re.into(), s.im.into())).collect::<Vec<_>>()
        });
        let power: f64 = plain.iter().map(|s| s.norm_sqr()).sum();
        let by = plain.iter().zip(&other).map(|(a, b)| b * a.conj()).sum::<Complex64>() / power;
        let off: f64 = plain.iter().zip(&other).map(|(a, b)| (b - a * by).norm_sqr()).sum();
        assert!(off < 1e-12 * power, "{}", off / power);
        for (sum, value) in sums.iter_mut().zip([20.0 * by.norm().log10(), by.arg()]) {
            *sum += value * value;
        }
    }
    for (sum, wanted) in sums.into_iter().zip(wanted) {
        let found = (sum / 400.0).sqrt();
        assert!((found / wanted - 1.0).abs() < 4.0 / 800f64.sqrt(), "{found} {wanted}");
    }
    let early = [&unstable[..], &[("radar.prf_hz", "1e6")]].concat();
    let mut run = runs::scene(COASTAL, &early);
    run.scene.pulses = 100;
    let refused = build::stream(&run, 0..100).err().unwrap().to_string();
    assert!(refused.contains("windows that receive their own pulse alone"), "{refused}");
}
