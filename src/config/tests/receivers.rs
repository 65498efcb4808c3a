//! Receivers: their own windows, and whom they hear.

use super::*;
use crate::scene::radar::Pair;

/// Two transmitters and two receivers on platforms of their own; `own` are more keys of the receivers.
fn text(own: [&str; 2], channels: &str) -> String {
    let mut text = format!(
        r#"
        scene = {{ duration_s = 1.0 }}
        [radar]
        carrier_hz = 10e9
        sample_rate_hz = 100e6
        prf_hz = 100.0
        {channels}
        waveform = {{ kind = "lfm", bandwidth_hz = 60e6, pulse_s = 1e-6 }}
        window = {{ samples = 512, start_us = 20.0 }}
        "#
    );
    for (n, kind) in ["transmitter", "transmitter", "receiver", "receiver"].into_iter().enumerate() {
        let (name, more) = match n {
            0 | 1 => (format!("tx{}", n + 1), "power_w = 1.0"),
            _ => (format!("rx{}", n - 1), own[n - 2]),
        };
        let place = 1000 * n;
        text += &format!(
            r#"
            [[platform]]
            name = "p{n}"
            track = {{ kind = "fixed", position_m = [{place}, 0, 10] }}
            [[{kind}]]
            name = "{name}"
            platform = "p{n}"
            antenna = {{ kind = "isotropic" }}
            {more}
            "#
        );
    }
    text
}

const VV: &str = "channels = [\"VV\"]";

fn radar(own: [&str; 2], channels: &str) -> crate::scene::Radar {
    parse(&text(own, channels), Path::new("two.toml"), &[]).unwrap().scene.radar
}

fn faults(own: [&str; 2], channels: &str) -> String {
    let error = parse(&text(own, channels), Path::new("two.toml"), &[]).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

fn ends(radar: &crate::scene::Radar) -> Vec<[usize; 2]> {
    radar.pairs().iter().map(|pair| [pair.transmitter, pair.receiver]).collect()
}

#[test]
fn receivers_pair_with_transmitters_that_they_hear() {
    let all = radar([""; 2], VV);
    assert_eq!(ends(&all), [[0, 0], [0, 1], [1, 0], [1, 1]]);
    let own = radar(["hears = ['tx1']", "hears = ['tx2']"], VV);
    assert_eq!(ends(&own), [[0, 0], [1, 1]]);
    let names: Vec<&str> = own.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["VV-tx1-rx1", "VV-tx2-rx2"]);
    assert_eq!(radar(["hears = ['tx2', 'tx1']", ""], VV), all);
}

#[test]
fn windows_are_found_by_the_first_transmitter_that_is_heard() {
    let follow = "window = { follow = { kind = 'at', position_m = [0, 0, 0], lead_us = 2.0 } }";
    let pair = |transmitter, receiver| Pair { transmitter, receiver };
    // Fixed windows that are the same are one.
    assert_eq!(radar([""; 2], VV).window_leads(), [pair(0, 0)]);
    assert_eq!(radar(["window = { start_us = 20 }", ""], VV).window_leads(), [pair(0, 0)]);
    assert_eq!(radar(["", "window = { start_us = 30 }"], VV).window_leads(), [pair(0, 0), pair(0, 1)]);
    assert_eq!(radar([follow; 2], VV).window_leads(), [pair(0, 0), pair(0, 1)]);
    let by_others = radar([follow, &format!("{follow}\nhears = ['tx2']")], VV);
    assert_eq!(by_others.window_leads(), [pair(0, 0), pair(1, 1)]);
    // On one platform they are sampled together.
    let mut together = radar([follow; 2], VV);
    together.receivers[1].antenna.platform = 2;
    assert_eq!(together.window_leads(), [pair(0, 0)]);
    assert_eq!(together.layout(4, 0).windows, 0);
    assert_eq!(by_others.layout(4, 0).windows, 2);
}

#[test]
fn what_is_wrong_with_receivers_is_named() {
    insta::assert_snapshot!(faults(["hears = []", "hears = ['tx3']"], VV), @r#"
receiver.0.hears: [] is not allowed; allowed: one or more of tx1, tx2
receiver.1.hears: there is no transmitter "tx3"; allowed: tx1, tx2
"#);
    insta::assert_snapshot!(faults(["window = { start_us = 1, samples = 7 }", "window = {}"], VV), @r#"
receiver.0.window.samples: not allowed here (every receiver takes radar.window.samples)
receiver.1.window: one of start_us, follow is required
"#);
    insta::assert_snapshot!(faults(["hears = 'tx1'", "window = { start_us = -1 }"], VV), @r#"
receiver.0.hears: "tx1" is not allowed; allowed: a list of 0 to 256 texts, each the name of a transmitter
receiver.1.window.start_us: -1 is out of range; allowed: a number from 0 to 1e7 us
"#);
    let channel = "channel = [{ polarisation = 'VV', transmitter = 'tx2', receiver = 'rx1' }]";
    insta::assert_snapshot!(faults(["hears = ['tx1']", ""], channel), @r#"radar.channel.0.transmitter: receiver "rx1" does not hear transmitter "tx2"; allowed: tx1 (its key hears)"#);
}

#[test]
fn arrays_are_rows_of_receivers() {
    const HH: &str = "channels = [\"HH\"]";
    let array = "lever_arm_m = [1, 2, 3]
        phase_deg = 90.0
        clock = { drift = 1e-9 }
        array = { elements = 3, spacing_m = [0.0, 0.5, 0.0], gains_db = [1, 0, -1] }";
    let run = parse(&text([array, ""], HH), Path::new("two.toml"), &[]).unwrap();
    let receivers = &run.scene.radar.receivers;
    let names: Vec<&str> = receivers.iter().map(|receiver| receiver.name.as_str()).collect();
    assert_eq!(names, ["rx1-0", "rx1-1", "rx1-2", "rx2"]);
    let starboard: Vec<f64> = receivers[..3].iter().map(|rx| rx.antenna.lever_arm.to_array()[1]).collect();
    assert_eq!(starboard, [1.5, 2.0, 2.5]);
    assert_eq!(receivers[2].antenna.ports.gain_db, -1.0);
    assert_eq!(receivers[1].antenna.ports.phase_rad, 90f64.to_radians());
    assert_eq!(run.scene.radar.channels.len(), 8);
    let clocks = &run.clocks.receivers;
    assert!(
        clocks[0].is_some() && clocks[..3].iter().all(|clock| *clock == clocks[0]) && clocks[3].is_none()
    );
    // The clock goes by any of the elements.
    assert_eq!(run.clocks.clocks[0].name, "rx1-0");
    for element in ["rx1-0", "rx1-2"] {
        let shared = format!("clock = {{ same_as = \"{element}\" }}");
        let run = parse(&text([array, &shared], HH), Path::new("two.toml"), &[]).unwrap();
        assert_eq!(run.clocks.receivers[3], run.clocks.receivers[0]);
    }
    let heard = "channel = [{ polarisation = 'VV', transmitter = 'tx1', receiver = 'rx1-1' }]";
    insta::assert_snapshot!(faults(["array = { elements = 1, spacing_m = [0, 1, 0] }", ""], heard), @"receiver.0.array.elements: 1 is out of range; allowed: a whole number from 2 to 64");
    insta::assert_snapshot!(faults(["array = { elements = 1, spacing_m = [0, 0, 0] }", ""], HH), @"
receiver.0.array.elements: 1 is out of range; allowed: a whole number from 2 to 64
receiver.0.array.spacing_m: no distance is not allowed; allowed: a distance between elements
");
    let lists =
        "array = { elements = 3, spacing_m = [0, 1, 0], gains_db = [1, 2], phases_deg = [1, 2, 400] }";
    insta::assert_snapshot!(faults([lists, ""], HH), @"
receiver.0.array.gains_db: 2 numbers is not allowed; allowed: one for each of the 3 elements
receiver.0.array.phases_deg: entry 2, 400, is out of range; allowed: a list of 2 to 64 numbers from -360 to 360 deg
");
    insta::assert_snapshot!(faults(["array = {}", "gain_db = 61"], HH), @"
receiver.0.array.elements: is missing; required: a whole number from 2 to 64
receiver.0.array.spacing_m: is missing; required: a list of 3 numbers from -10000 to 10000 m
receiver.1.gain_db: 61 is out of range; allowed: a number from -60 to 60 dB
");
}
