//! Events and calibration channels.

use super::*;
use crate::motion::changes::Change;
use crate::scene::calibration::Signal;

const SELFTEST: &str = include_str!("../../../configs/selftest.toml");
const EVENTS: &str =
    "[{ pulse = 3, platform = 'mast', change = 'clear' }, { at_s = 1.0, change = 'dropout 2 s' }]";

pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    vec![(SELFTEST, vec![("event", EVENTS)])]
}

fn with(list: &[(&str, &str)]) -> Result<Run, ConfigError> {
    parse(SELFTEST, &in_configs(), &settings(list))
}

fn faults(list: &[(&str, &str)]) -> String {
    with(list).unwrap_err().faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn events_become_pulses() {
    // 222 intervals are a second; a time written in decimals is the pulse that is meant, and one a little
    // later is the next.
    for (at_s, pulse) in
        [("0", 0), ("1.0", 222), ("0.004504504504504504", 1), ("1.00001", 223), ("4.99", 1108)]
    {
        let event = format!("[{{ at_s = {at_s}, change = 'bias attitude.roll 1 deg' }}]");
        let run = with(&[("event", &event)]).unwrap();
        let [event] = run.events[..] else { panic!("{:?}", run.events) };
        assert_eq!((event.pulse, event.platform), (pulse, 0), "{at_s}");
        assert_eq!(event.change, Change::Bias { axis: 6, value: 1.0 });
    }
    assert!(!with(&[]).unwrap().control);
}

#[test]
fn faults_of_events_name_what_is_allowed() {
    let list = "[{ change = 'clear' }, { pulse = 1110, change = 'clear' }, { pulse = 1, change = 7 }, \
                 { pulse = 1, platform = 'x', change = 'jump' }, { pulse = 1, at_s = 1, change = 'clear', colour = 1 }]";
    let text = faults(&[("event", list)]);
    for part in [
        "event.0",
        "pulse 1110: allowed: before pulse 1110, where the run ends",
        "event.2.change: 7 is not allowed",
        "event.3.platform",
        "'jump': allowed: step, bias, ramp, dropout, latency, clear",
        "event.4.colour",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn calibration_channels_are_read_and_checked() {
    let run = with(&[]).unwrap();
    let [tone, loopback] = &run.calibration[..] else { panic!("{:?}", run.calibration) };
    assert_eq!(tone.signal, Signal::Tone { offset_hz: 10_000_045.5 });
    assert_eq!(loopback.signal, Signal::Loopback { transmitter: 0, delay_s: 1.234e-6 });
    assert!((tone.power_w / 1e-10 - 1.0).abs() < 1e-15 && !tone.noise && loopback.receiver == 0);
    let text = faults(&[
        ("radar.calibration.0.offset_hz", "6e7"),
        ("radar.calibration.1.delay_s", "5e-6"),
        ("radar.calibration.1.name", "VV"),
        ("radar.calibration.1.receiver", "ear"),
        ("radar.calibration.1.phase_deg", "1e3"),
    ]);
    for part in [
        "allowed: from -50000000 to 50000000 Hz, half the sample rate",
        "s, so that the whole pulse is in the window",
        "VV",
        "there is no receiver \"ear\"; allowed: rx",
        "phase_deg",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}
