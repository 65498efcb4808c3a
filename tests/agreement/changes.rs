//! Changes of reports while a run goes on: from one pulse on and not before, whoever asks, on any number of
//! threads, and in both echoes.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use nereus::config::Run;
use nereus::motion::changes::{Change, Event};
use nereus::pipeline::build;
use nereus::pipeline::changing;
use nereus::pipeline::control::Control;
use nereus::pulse::{Pulse, Samples, flags};

use crate::runs::{kept, scene};

/// Of `errors.toml`.
const AIRCRAFT: usize = 1;

fn scenario(name: &str, settings: &[(&str, &str)]) -> Run {
    scene(&format!("configs/{name}"), &[settings, &[("stream.pace", "\"fast\"")]].concat())
}

fn pulses(run: &Run, range: Range<u64>) -> Vec<Pulse> {
    kept(build::stream(run, range).unwrap())
}

fn event(pulse: u64, platform: usize, text: &str) -> Event {
    Event { pulse, platform, change: text.parse().unwrap() }
}

/// Runs with changes that are asked for when so many pulses have been made; returns what was taken.
fn controlled(run: &Run, end: u64, platform: usize, asked: &[(u64, &str)]) -> (Vec<Pulse>, Vec<Event>) {
    let run = Run { control: true, ..run.clone() };
    let stream = build::stream(&run, 0..end).unwrap();
    let control: Control = stream.control().unwrap();
    let name = run.scene.platforms[platform].clone();
    let asked: Vec<(u64, Change)> = asked.iter().map(|(made, text)| (*made, text.parse().unwrap())).collect();
    let asks = thread::spawn(move || {
        let ask = |(made, change): (u64, Change)| {
            while control.counts().made < made {
                thread::sleep(Duration::from_micros(200));
            }
            let pulse = control.change(Some(&name), change).unwrap();
            // Nothing that has been made is changed.
            assert!(pulse >= made);
            Event { pulse, platform, change }
        };
        asked.into_iter().map(ask).collect()
    });
    let mut pulses = Vec::new();
    let taken = |pulse: &Pulse| {
        // So many have been made that nothing is waited for: the run does not end before it is asked.
        while pulse.index >= 100 && !asks.is_finished() {
            thread::sleep(Duration::from_millis(1));
        }
        pulses.push(pulse.clone());
    };
    stream.tap(&Arc::new(AtomicBool::new(false)), taken).unwrap().result.unwrap();
    (pulses, asks.join().unwrap())
}

#[test]
fn what_is_asked_for_meanwhile_is_what_the_same_events_make() {
    let of_errors: &[(u64, &str)] =
        &[(0, "bias position.up 4 m"), (30, "step attitude.heading 1 deg"), (60, "dropout 0.2 s")];
    let of_sea: &[(u64, &str)] = &[(20, "step attitude.heading 0.5 deg"), (40, "latency 13 ms")];
    // The sea is coarse: bits are compared, not errors.
    let duration = ("scene.duration_s", "4.0");
    for (name, echo, end, platform, asked, size) in [
        ("errors.toml", "reference", 600, AIRCRAFT, of_errors, duration),
        ("errors.toml", "fast", 600, AIRCRAFT, of_errors, duration),
        ("sea.toml", "fast", 300, 0, of_sea, ("scene.facet_m", "4.0")),
    ] {
        let settings = [("fidelity.echo", echo), ("stream.threads", "2"), duration, size];
        let run = scenario(name, &settings);
        let (whole, taken) = controlled(&run, end, platform, asked);
        assert_eq!(whole.len() as u64, end);
        let from_pulse: Vec<u64> = taken.iter().map(|event| event.pulse).collect();
        let again = Run { events: taken.clone(), ..run.clone() };
        assert!(
            pulses(&again, 0..end) == whole,
            "{name}, {echo}: events at {from_pulse:?} make other pulses"
        );
        let one = scenario(name, &[settings[0], ("stream.threads", "1"), duration, size]);
        let (from, to) = (taken[1].pulse - 5, (taken[1].pulse + 40).min(end));
        let part = pulses(&Run { events: taken, ..one }, from..to);
        assert!(part == whole[from as usize..to as usize], "{name}, {echo}: a part on one thread differs");
        // Without them it is another run, from the first change on and not before.
        let without = pulses(&run, 0..end);
        let first = (0..end as usize).find(|n| without[*n] != whole[*n]).unwrap() as u64;
        assert_eq!(first, from_pulse[0], "{name}, {echo}");
    }
}

/// Every pulse from the first one on has a change, and none before; the report differs by what was asked, and
/// the truth by nothing.
#[test]
fn a_step_is_there_from_its_pulse_on() {
    let run = scenario("errors.toml", &[]);
    let with = Run {
        events: vec![event(233, AIRCRAFT, "step position.east 7 m"), event(401, AIRCRAFT, "clear")],
        ..run.clone()
    };
    let (plain, changed) = (pulses(&run, 0..500), pulses(&with, 0..500));
    for (a, b) in plain.iter().zip(&changed) {
        let step_m = if (233..401).contains(&a.index) { 7.0 } else { 0.0 };
        let [reported, other] = [a, b].map(|p| p.nav_reported[AIRCRAFT]);
        let found_m = other.position_m[0] - reported.position_m[0];
        // Coordinates up to 4 km in f64: 5e-13 m, a few of them.
        assert!((found_m - step_m).abs() < 4e-12, "{}: {found_m}", a.index);
        assert_eq!((a.nav_true.clone(), reported.age_s), (b.nav_true.clone(), other.age_s));
        assert_eq!((reported.flags, a.nav_reported[0]), (other.flags, b.nav_reported[0]));
    }
}

/// What an event does to a platform whose report is right: the report in closed form.
#[test]
fn reports_are_those_of_the_closed_form() {
    let run = scenario("sea.toml", &[("fidelity.echo", "reference"), ("scene.facet_m", "16.0")]);
    let at = |t: f64| 222.0 * t - 55.5;
    let report = |texts: &[(u64, &str)]| -> Vec<Pulse> {
        let events = texts.iter().map(|(pulse, text)| event(*pulse, 0, text)).collect();
        pulses(&Run { events, ..run.clone() }, 0..60)
    };
    let north = |p: &Pulse| p.nav_reported[0].position_m[1];
    // Coordinates of some hundred metres: 3e-14 m each, a dozen operations.
    let near = |p: &Pulse, value: f64| assert!((north(p) - value).abs() < 1e-12, "{}: {}", p.index, north(p));
    let time = |p: &Pulse| p.index as f64 / 222.0;
    for p in report(&[(20, "ramp position.north 3 m/s"), (40, "ramp position.north -1 m/s")]) {
        let grown =
            3.0 * (time(&p).min(40.0 / 222.0) - 20.0 / 222.0).max(0.0) - (time(&p) - 40.0 / 222.0).max(0.0);
        near(&p, at(time(&p)) + grown);
        let slope = if p.index < 20 {
            0.0
        } else if p.index < 40 {
            3.0
        } else {
            -1.0
        };
        assert!((p.nav_reported[0].velocity_mps[1] - 222.0 - slope).abs() < 1e-12);
    }
    for p in report(&[(20, "dropout 0.05 s"), (25, "step position.north 2 m")]) {
        // 0.05 s are 11.1 intervals.
        let lost = (20..32).contains(&p.index);
        assert_eq!(p.nav_reported[0].flags, if lost { flags::REPORT_DROPOUT } else { 0 }, "{}", p.index);
        assert_eq!(p.flags & flags::REPORT_DROPOUT != 0, lost);
        // Moved on with its velocity, a report of a straight flight stays right; what changes meanwhile shows
        // at its end.
        near(&p, at(time(&p)) + if p.index < 32 { 0.0 } else { 2.0 });
        let age_s = if lost { (p.index - 19) as f64 / 222.0 } else { 0.0 };
        assert!((p.nav_reported[0].age_s - age_s).abs() < 1e-12);
    }
    for p in report(&[(20, "latency 20 ms"), (50, "latency 0 ms")]) {
        // 20 ms are 4.44 intervals: the report of 5 pulses ago, once it is later than the one at hand.
        let age = match p.index {
            0..20 | 50.. => 0,
            n => n - (n - 5).max(19),
        };
        assert!((p.nav_reported[0].age_s - age as f64 / 222.0).abs() < 1e-12, "{}", p.index);
        near(&p, at(time(&p)));
    }
    for p in report(&[
        (9, "step position.north 2 m"),
        (20, "bias position.north 5 m"),
        (30, "bias attitude.heading 0.5 deg"),
        (50, "clear"),
    ]) {
        near(
            &p,
            at(time(&p))
                + match p.index {
                    0..9 | 50.. => 0.0,
                    9..20 => 2.0,
                    _ => 5.0,
                },
        );
        let [w, x, y, z] = p.nav_reported[0].attitude_quat;
        let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
        let turned = if (30..50).contains(&p.index) { 0.5f64.to_radians() } else { 0.0 };
        let [w, x, y, z] = p.nav_true[0].attitude_quat;
        let truth = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
        // Heading turns clockwise.
        assert!((truth - yaw - turned).abs() < 1e-14 * 10.0, "{}: {}", p.index, truth - yaw);
    }
}

/// Antennas that aim by the report jump with it, in the middle of a block as well: the fast echo keeps its
/// budget.
#[test]
fn the_fast_echo_keeps_its_budget_where_an_aim_jumps() {
    // A start whose fraction of a second makes times round.
    let settings = [
        ("scene.facet_m", "2.0"),
        ("receiver.0.pointing.lag_s", "0.03"),
        ("scene.start_utc", "\"2020-01-01T00:00:00.3Z\""),
    ];
    let run = scenario("sea.toml", &settings);
    let mut run = Run { events: vec![event(20, 0, "step attitude.heading 2 deg")], ..run };
    run.scene.radar.noise_figure_db = None;
    let fast = changing::factory(&run, &run.fidelity).unwrap();
    let reference = changing::factory(&run, &nereus::echo::Fidelity::Reference).unwrap();
    assert!(fast.block_pulses() > 10 && fast.block_pulses() < 100);
    let samples = |factory: &nereus::pipeline::stages::PulseFactory, of: &[u64]| -> Vec<Vec<[f64; 2]>> {
        let (mut slot, mut worker) = (factory.slot(), factory.worker());
        of.iter()
            .map(|&index| {
                worker.make(index, &mut slot).unwrap();
                let Samples::Cf32(iq) = &slot.samples else { panic!("codes") };
                iq[..192].iter().map(|s| [f64::from(s.re), f64::from(s.im)]).collect()
            })
            .collect()
    };
    // The transmitter turns at pulse 20; the receiver 6.66 intervals later, at pulse 27.
    let of = [18, 19, 20, 21, 25, 26, 27, 28, 30];
    let (made, exact) = (samples(&fast, &of), samples(&reference, &of));
    let power = |a: &[[f64; 2]]| a.iter().map(|[re, im]| re * re + im * im).sum::<f64>();
    let mean = exact.iter().map(|a| power(a)).sum::<f64>() / of.len() as f64;
    for ((a, b), index) in made.iter().zip(&exact).zip(of) {
        let apart: Vec<[f64; 2]> = a.iter().zip(b).map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).collect();
        let db = 10.0 * (power(&apart) / mean).log10();
        assert!(db < -60.0, "pulse {index}: {db:.1} dB");
    }
    // The jump itself is far above that.
    let change = 10.0 * (power(&exact[3]) / power(&exact[1])).log10();
    assert!(change.abs() > 1.0, "{change}");
}

#[test]
fn no_pulse_is_left_after_the_end() {
    let run = Run { control: true, ..scenario("errors.toml", &[]) };
    let stream = build::stream(&run, 0..60).unwrap();
    let control = stream.control().unwrap();
    let asks = control.clone();
    let clear: Change = "clear".parse().unwrap();
    let late = thread::spawn(move || {
        while asks.counts().made < 60 {
            thread::sleep(Duration::from_micros(200));
        }
        asks.change(Some("aircraft"), clear).unwrap_err().to_string()
    });
    assert_eq!(kept(stream).len(), 60);
    let late = late.join().unwrap();
    assert!(late.contains("ends") || late.contains("has ended"), "{late}");
    assert_eq!(
        control.change(Some("mast"), clear).unwrap_err().to_string(),
        "the run has ended: allowed: changes while pulses are left to be made"
    );
    assert_eq!(
        control.change(Some("ship"), clear).unwrap_err().to_string(),
        "platform 'ship': allowed: mast, aircraft"
    );
    assert_eq!(control.change(None, clear).unwrap_err().to_string(), "platform '': allowed: mast, aircraft");
}
