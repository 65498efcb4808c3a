//! Reception without a gap: what it means, and what it may not stand beside.

use super::*;
use crate::time::PulseTimes;

/// Blocks of 1000 samples and what else is set.
fn parsed(more: &[(&str, &str)]) -> Result<Run, ConfigError> {
    let window = "{ gate = 'continuous', samples = 1000 }";
    parse(COASTAL, &in_configs(), &settings(&[&[("radar.window", window)], more].concat()))
}

fn faults(more: &[(&str, &str)]) -> String {
    parsed(more).unwrap_err().faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn blocks_take_the_place_of_pulses() {
    let scene = parsed(&[("scene.duration_s", "2")]).unwrap().scene;
    let windowed = parse(COASTAL, &in_configs(), &[]).unwrap().scene;
    let radar = &scene.radar;
    let blocks = PulseTimes::blocks(1000, radar.sample_rate_hz).unwrap();
    assert_eq!((&radar.emissions, radar.sends()), (&blocks, &windowed.radar.emissions));
    assert_eq!(radar.window.gate, Gate::Fixed { start_s: 0.0 });
    assert_eq!(scene.pulses, blocks.count_within(2.0));
    assert_eq!((windowed.radar.sends(), &windowed.radar.sent), (&windowed.radar.emissions, &None));
    // Pulses may be longer than a block.
    let long = [("radar.waveform.pulse_s", "1e-3")];
    assert!(parsed(&long).is_ok());
}

#[test]
fn what_needs_windows_is_refused() {
    insta::assert_snapshot!(faults(&[("radar.window.start_us", "5")]), @r#"radar.window.start_us: not allowed here (gate = "continuous")"#);
    insta::assert_snapshot!(faults(&[("receiver.0.window", "{ start_us = 5 }"), ("receiver.0.clock", "{ offset_s = 1e-6 }"), ("radar.rain_mmph", "5"), ("radar.rain_clutter", "true")]), @r#"
radar.window: gate = "continuous" beside [receiver.window] is not allowed; allowed: gate = "windowed", or no [receiver.window]
radar.window: gate = "continuous" beside clock errors of antennas is not allowed; allowed: gate = "windowed", or no clock errors of antennas
radar.window: gate = "continuous" beside rain_clutter is not allowed; allowed: gate = "windowed", or no rain_clutter
"#);
    insta::assert_snapshot!(faults(&[("radar.window.gate", "'open'")]), @r#"radar.window.gate: "open" is not allowed; allowed: "windowed", "continuous""#);
    let all = faults(&[("radar.window", "{ gate = 'open', samples = 1000, start_us = 'x', starts = 1 }")]);
    assert!(
        ["gate", "start_us", "starts"].iter().all(|key| all.contains(&format!("radar.window.{key}:"))),
        "{all}"
    );
    insta::assert_snapshot!(faults(&[("radar.prf_hz", "2000"), ("radar.waveform.pulse_s", "1e-3")]), @"radar.prf_hz: 500 us between pulses are shorter than the pulse of 1000 us: two pulses would leave at once; allowed: at least 1000 us");
}
