//! Emitters: what they say, and what they may not.

use super::*;

fn faults(own: &str) -> String {
    let set = settings(&[("emitter", own)]);
    let error = parse(COASTAL, &in_configs(), &set).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn an_emitter_is_heard_by_all_on_the_carrier_of_the_radar() {
    let scene = parse(COASTAL, &in_configs(), &settings(&[("emitter", EMITTER)])).unwrap().scene;
    let radar = &scene.radar;
    let [emitter] = &radar.emitters[..] else { panic!("{:?}", radar.emitters) };
    assert_eq!((emitter.carrier_hz, &emitter.receivers[..]), (radar.carrier_hz, &[0][..]));
    assert!(emitter.direct_path && emitter.echo && emitter.emissions.start_s() == 0.0);
    // A channel for every port of the receiver.
    let heard = crate::paths::scene_of(&scene, emitter, [0.0; 2]).radar;
    let ports: Vec<[char; 2]> = heard.channels.iter().map(|own| [own.rx.letter(), own.tx.letter()]).collect();
    assert_eq!((ports, heard.transmitters.len()), (vec![['H', 'H'], ['V', 'H']], 2));
}

#[test]
fn faulty_emitters_are_refused() {
    let of = |more: &str, less: &str| EMITTER.replace("prf_hz = 100", more).replace(less, "");
    insta::assert_snapshot!(faults(&of("prf_hz = 100, pri_us = [10]", "~")), @"emitter.0.pri_us: prf_hz, pri_us exclude each other; allowed: one of them");
    insta::assert_snapshot!(faults(&of("prf_hz = 100, carrier_hz = 1e9, polarisation = 'X'", "~")), @r#"
emitter.0.polarisation: "X" is not allowed; allowed: "H", "V", "R", "L"
emitter.0.carrier_hz: its band begins 8.9995e9 Hz off the carrier of [radar]; allowed: within half of radar.sample_rate_hz, 5e7 Hz
"#);
    insta::assert_snapshot!(faults(&of("prf_hz = 100, start_us = -1e10", "~")), @"emitter.0.start_us: -10000000000.0 is out of range; allowed: a number from -1e9 to 1e9 us");
    insta::assert_snapshot!(faults(&of("prf_hz = 100, heard_by = ['tx']", "~")), @r#"emitter.0.heard_by: there is no receiver "tx"; allowed: rx"#);
    insta::assert_snapshot!(faults(&of("echo = true", "power_w = 1,").replace("'a'", "'rx'")), @r#"
emitter.0.name: "rx" is already the name of another antenna; allowed: unique names
emitter.0.power_w: is missing; required: a number above 0, up to 1e12 W
emitter.0: one of prf_hz, pri_us is required
"#);
}
