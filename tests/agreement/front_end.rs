//! Pulses that droop keep the error, and what is wrong in the front end is the same whatever is asked.

use crate::runs::{holds, pulses};

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
                 jitter_rms_s = 1e-12 }";
    let settings = [("radar.front_end", table), ("radar.noise_figure_db", "3")];
    let whole = pulses(COASTAL, &settings, "2", 0..60);
    assert!(pulses(COASTAL, &settings, "1", 20..60) == whole[20..], "a part differs");
    let ideal = pulses(COASTAL, &settings[1..], "1", 0..8);
    for keys in [
        "iq_gain_db = 0.5",
        "iq_phase_deg = 2",
        "offset_dbw = -150, offset_phase_deg = 30",
        "stc_full_us = 30, stc_exponent = 2, stc_depth_db = 20",
        "jitter_rms_s = 1e-12, jitter_if_hz = 60e6",
    ] {
        let table = format!("{{ {keys} }}");
        let found = pulses(COASTAL, &[("radar.front_end", &*table), settings[1]], "1", 0..8);
        assert!(found[3].samples != ideal[3].samples, "{keys} changes nothing");
    }
    assert!(pulses(COASTAL, &[("radar.front_end", "{}"), settings[1]], "1", 0..8) == ideal, "it is not free");
}
