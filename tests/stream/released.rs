//! Pulses of a scenario taken one by one: the same as those that are seen, theirs who takes them, and what
//! ends them.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use nereus::pipeline::released::Taken;
use nereus::sinks::Kind;
use nereus::transport::Pace;
use nereus::{Pulse, Samples, Scenario, ScenarioError};

fn scenario() -> Scenario {
    Scenario::load("configs/selftest.toml", &[("radar.window.samples", "512")]).unwrap()
}

#[test]
fn pulses_that_are_taken_are_those_that_are_seen() {
    let mut seen: Vec<Pulse> = Vec::new();
    scenario().each_pulse(3..60, |pulse| seen.push(pulse.clone())).unwrap();
    let taken: Vec<_> = scenario().released(3..60, Pace::Fast).unwrap().map(Result::unwrap).collect();
    assert_eq!(taken.len(), 57);
    for (taken, seen) in taken.iter().zip(&seen) {
        assert_eq!(**taken, *seen);
    }
    // All at once: none is another's memory.
    let mut places: Vec<_> = taken.iter().map(|pulse| pulse.samples.as_bytes().as_ptr()).collect();
    places.sort();
    places.dedup();
    assert_eq!(places.len(), 57);
}

#[test]
fn a_stream_that_is_closed_or_dropped_ends_its_run() {
    let mut pulses = scenario().released(0..1000, Pace::Realtime).unwrap();
    assert!(pulses.next().unwrap().is_ok());
    let summary = pulses.close().unwrap().unwrap();
    assert!(summary.stopped && summary.health.pulses < 1000, "{summary:?}");
    assert!(matches!(pulses.next_within(Duration::ZERO), Ok(Taken::Ended)));
    drop(scenario().released(0..1000, Pace::Realtime).unwrap());
}

#[test]
fn who_is_slow_in_real_time_misses_pulses_that_are_counted() {
    let fast = [
        ("radar.prf_hz", "2000"),
        ("scene.duration_s", "100"),
        ("stream.policy", "slip"),
        ("radar.window.samples", "512"),
    ];
    let scenario = Scenario::load("configs/selftest.toml", &fast).unwrap();
    let mut pulses = scenario.released(0..200_000, Pace::Realtime).unwrap();
    let mut before = pulses.next().unwrap().unwrap().index;
    let control = pulses.control().unwrap();
    // Takes nothing until the queue has overflowed.
    while control.health().is_none_or(|health| health.sinks[0].dropped == 0) {
        std::thread::sleep(Duration::from_millis(20));
    }
    for pulse in pulses.by_ref().map(Result::unwrap) {
        let gap = pulse.index != before + 1;
        assert_eq!(gap, pulse.flags & nereus::pulse::flags::AFTER_GAP != 0, "{}", pulse.index);
        before = pulse.index;
        if gap {
            break;
        }
    }
    assert!(before + 1 < 200_000);
    pulses.close().unwrap();
}

#[test]
fn a_line_changes_what_is_reported_from_the_pulse_that_is_answered() {
    let long = [("scene.duration_s", "100"), ("radar.window.samples", "512")];
    let mut pulses =
        Scenario::load("configs/selftest.toml", &long).unwrap().released(0..20_000, Pace::Fast).unwrap();
    let control = pulses.control().unwrap();
    assert!(pulses.next().unwrap().is_ok());
    let (first, text) = control.line(" step position.up 5 m on mast ").unwrap();
    assert_eq!(text, "step position.up 5 m on mast");
    assert!(control.health().unwrap().made > 0);
    for pulse in pulses.by_ref().map(Result::unwrap).take_while(|pulse| pulse.index <= first) {
        let error_m = pulse.nav_reported[0].position_m[2] - pulse.nav_true[0].position_m[2];
        assert_eq!(error_m, if pulse.index < first { 0.0 } else { 5.0 }, "{}", pulse.index);
    }
    pulses.close().unwrap();
    let refused = control.line("step up 5 m on mast").unwrap_err().to_string();
    assert!(refused.contains("allowed: position.east"), "{refused}");
    let over = control.line("clear on mast").unwrap_err().to_string();
    assert!(over.starts_with("the run has ended"), "{over}");
}

#[test]
fn a_text_is_the_same_scenario_as_its_file() {
    let text = std::fs::read_to_string("configs/selftest.toml").unwrap();
    let set = [("radar.window.samples".to_owned(), "512".to_owned())];
    let parsed = Scenario::parse(&text, Path::new("configs/selftest.toml"), &set).unwrap();
    assert_eq!(parsed, scenario());
}

#[test]
fn a_recording_ends_with_the_stop_flag_and_holds_what_was_made() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight");
    let kind = || Kind::Plain { path: path.clone(), force: false };
    let stop = Arc::new(AtomicBool::new(false));
    let outcome = scenario().record(0..8, kind(), &stop, None).unwrap();
    assert!(outcome.result.is_ok());
    assert_eq!(std::fs::metadata(path.join("pulse/index.bin")).unwrap().len(), 64);
    let exists = scenario().record(0..8, kind(), &stop, None).unwrap_err();
    assert!(matches!(exists, ScenarioError::Build(_)), "{exists}");

    let mut samples = Vec::new();
    scenario()
        .each_pulse(0..8, |pulse| {
            let Samples::Cf32(iq) = &pulse.samples else { panic!("no converter here") };
            samples.extend_from_slice(iq);
        })
        .unwrap();
    let recorded = std::fs::read(path.join("iq.bin")).unwrap();
    assert_eq!(recorded, bytemuck::cast_slice::<_, u8>(&samples));
}
