//! Waveforms: what they say, and what they may not.

use super::*;
use crate::scene::radar::{Code, Sweep, Taper, Waveform};

/// Scenarios by which every key of a waveform is read.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    [
        "{ kind = 'nlfm', bandwidth_hz = 50e6, pulse_s = 1e-6 }",
        "{ kind = 'phase-code', code = 'p4', chips = 20, chip_s = 2e-8 }",
        "{ kind = 'phase-code', code = 'm-sequence', register = 5, chip_s = 2e-8 }",
    ]
    .map(|waveform| (COASTAL, vec![("radar.waveform", waveform)]))
    .to_vec()
}

fn of(waveform: &str) -> Waveform {
    parse(COASTAL, &in_configs(), &settings(&[("radar.waveform", waveform)])).unwrap().scene.radar.waveform
}

fn faults(waveform: &str) -> String {
    let set = settings(&[("radar.waveform", waveform)]);
    let error = parse(COASTAL, &in_configs(), &set).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn every_kind_is_what_it_says() {
    let swept = "bandwidth_hz = 50e6, pulse_s = 1e-6";
    assert_eq!(
        of(&format!("{{ kind = 'nlfm', {swept}, sweep = 'down' }}")),
        Waveform::Nlfm {
            bandwidth_hz: 50e6,
            duration_s: 1e-6,
            sweep: Sweep::Down,
            taper: Taper::Taylor { sidelobe_db: 35.0 }
        }
    );
    let hamming = of(&format!("{{ kind = 'nlfm', {swept}, taper = 'hamming' }}"));
    assert!(matches!(hamming, Waveform::Nlfm { taper: Taper::Hamming, .. }));
    let plain = of("{ kind = 'cw', pulse_s = 0.5e-6 }");
    assert_eq!((plain.kind(), plain.bandwidth_hz(), plain.duration_s()), ("cw", Some(2e6), Some(5e-7)));
    for (keys, code) in [
        ("code = 'barker', chips = 13", Code::Barker { chips: 13 }),
        ("code = 'frank', chips = 16", Code::Frank { phases: 4 }),
        ("code = 'p3', chips = 21", Code::P3 { chips: 21 }),
        ("code = 'p4', chips = 22", Code::P4 { chips: 22 }),
        ("code = 'm-sequence', register = 5", Code::MSequence { register: 5 }),
    ] {
        // A chip of one sample is not wider than the rate.
        let found = of(&format!("{{ kind = 'phase-code', {keys}, chip_s = 1e-8 }}"));
        assert_eq!(found, Waveform::PhaseCode { code, chip_s: 1e-8 });
        crate::radar::waveform::from_description(&found).unwrap();
    }
}

/// What the reader allows is what there is.
#[test]
fn limits_are_those_of_the_pulses() {
    use crate::radar::waveform::{MAX_NONLINEAR, MIN_NONLINEAR, SIDELOBES_DB};
    let keys::Kind::Number { min, max, .. } = keys::waveform::SIDELOBE_DB.kind else { panic!() };
    assert_eq!([min, max], SIDELOBES_DB);
    let product =
        |product: f64| faults(&format!("{{ kind = 'nlfm', bandwidth_hz = 1e6, pulse_s = {product}e-6 }}"));
    assert!(product(0.99 * MIN_NONLINEAR).contains("a product of 4 to 20000"));
    assert!(product(1.01 * MAX_NONLINEAR).contains("a product of 4 to 20000"));
}

#[test]
fn faulty_waveforms_are_refused() {
    let coded = |keys: &str| faults(&format!("{{ kind = 'phase-code', {keys} }}"));
    insta::assert_snapshot!(coded("chips = 5, chip_s = 1e-7"), @"");
    insta::assert_snapshot!(coded("code = 'barker', chips = 6, chip_s = 1e-7"), @"");
    insta::assert_snapshot!(coded("code = 'frank', chips = 15, chip_s = 1e-7"), @"");
    insta::assert_snapshot!(coded("code = 'p3', chips = 1, chip_s = 0"), @"");
    insta::assert_snapshot!(coded("code = 'p4', chips = 5, chip_s = 1e-9"), @"");
    insta::assert_snapshot!(coded("code = 'm-sequence', chips = 5, chip_s = 1e-7"), @"");
    insta::assert_snapshot!(coded("code = 'p4', chips = 50, register = 5, bandwidth_hz = 1e6, chip_s = 1e-7"), @"");
    insta::assert_snapshot!(coded("code = 'p4', chips = 60000, chip_s = 1e-6"), @"");
    insta::assert_snapshot!(faults("{ kind = 'nlfm', bandwidth_hz = 2e8, pulse_s = 1e-9, sidelobe_db = 70 }"), @"");
    insta::assert_snapshot!(faults("{ kind = 'nlfm', bandwidth_hz = 5e7, pulse_s = 1e-6, taper = 'hamming', sidelobe_db = 30 }"), @"");
    insta::assert_snapshot!(faults("{ kind = 'cw', bandwidth_hz = 5e7 }"), @"");
}
