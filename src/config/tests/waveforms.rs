//! Waveforms: what they say, and what they may not.

use super::*;
use crate::scene::radar::{AfterEnd, Code, Datatype, Fm, IqFile, RawIq, Source, Sweep, Taper, Waveform};

/// A continuous signal.
const ENDLESS: [(&str, &str); 2] = [
    ("radar.window", "{ gate = 'continuous', samples = 1000 }"),
    ("radar.waveform", "{ kind = 'noise', bandwidth_hz = 1e6, seed = 5 }"),
];

/// A recording.
const IQ_FILE: &str = "{ kind = 'iq-file', path = '../tests/data/iq/noise.cs8', rate_hz = 1e6, datatype = 'ci8', after = 'silence' }";

/// Scenarios by which every key of a waveform is read.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    [
        "{ kind = 'nlfm', bandwidth_hz = 50e6, pulse_s = 1e-6 }",
        "{ kind = 'phase-code', code = 'p4', chips = 20, chip_s = 2e-8 }",
        "{ kind = 'phase-code', code = 'm-sequence', register = 5, chip_s = 2e-8 }",
        "{ kind = 'stepped', steps = 4, step_hz = 1e6, pulse_s = 1e-6 }",
        "{ kind = 'in-turn', waveforms = [{ kind = 'cw', pulse_s = 1e-6 }, { kind = 'cw', pulse_s = 1e-6, offset_hz = 1e6 }] }",
    ]
    .map(|waveform| vec![("radar.waveform", waveform)])
    .into_iter()
    .chain([
        vec![("radar.dechirp", "{ delay_us = 0 }")],
        ENDLESS.to_vec(),
        vec![ENDLESS[0], ("radar.waveform", "{ kind = 'dvb-t', bandwidth_hz = 8e6 }")],
        vec![
            ENDLESS[0],
            ("radar.prf_hz", "1000"),
            ("radar.waveform", "{ kind = 'fm', deviation_hz = 50e3 }"),
        ],
        vec![ENDLESS[0], ("radar.waveform", "{ kind = 'gps-l1-ca', prn = 9 }")],
        vec![ENDLESS[0], ("radar.waveform", IQ_FILE)],
    ])
    .map(|settings| (COASTAL, settings))
    .collect()
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
    let triangular = of(&format!("{{ kind = 'lfm', {swept}, sweep = 'triangular' }}"));
    assert_eq!(triangular, Waveform::Triangular { bandwidth_hz: 50e6, duration_s: 1e-6 });
    let plain = of("{ kind = 'cw', pulse_s = 0.5e-6 }");
    assert_eq!((plain.kind(), plain.bandwidth_hz(), plain.duration_s()), ("cw", Some(2e6), Some(5e-7)));
    for (keys, code) in [
        ("code = 'barker', chips = 13", Code::Barker { chips: 13 }),
        ("code = 'frank', chips = 16", Code::Frank { phases: 4 }),
        ("code = 'p3', chips = 21", Code::P3 { chips: 21 }),
        ("code = 'p4', chips = 22", Code::P4 { chips: 22 }),
        ("code = 'm-sequence', register = 5", Code::MSequence { register: 5 }),
        ("code = 'golay-a', chips = 8", Code::Golay { chips: 8, second: false }),
        ("code = 'golay-b', chips = 2", Code::Golay { chips: 2, second: true }),
    ] {
        // A chip of one sample is not wider than the rate.
        let found = of(&format!("{{ kind = 'phase-code', {keys}, chip_s = 1e-8 }}"));
        assert_eq!(found, Waveform::PhaseCode { code, chip_s: 1e-8 });
        crate::radar::waveform::from_description(&found).unwrap();
    }
}

#[test]
fn pulses_leave_in_turn() {
    let cw = |duration_s: f64| Waveform::Cw { duration_s };
    let at = |of: Waveform, offset_hz: f64| Waveform::Offset { of: Box::new(of), offset_hz };
    let steps = of("{ kind = 'stepped', steps = 3, step_hz = -2e6, pulse_s = 1e-6 }");
    let wanted = [2e6, 0.0, -2e6].map(|hz| at(cw(1e-6), hz)).to_vec();
    assert_eq!(steps, Waveform::InTurn { of: wanted, stepped: true });
    assert_eq!((steps.kind(), steps.bandwidth_hz(), steps.duration_s()), ("stepped", Some(5e6), Some(1e-6)));
    let two = of("{ kind = 'in-turn', waveforms = [{ kind = 'cw', pulse_s = 1e-6 }, \
                  { kind = 'cw', pulse_s = 2e-6, offset_hz = 1e7, droop_db = 1.0 }] }");
    let droops = Waveform::Drooping { of: Box::new(cw(2e-6)), droop_db: 1.0 };
    assert_eq!(two, Waveform::InTurn { of: vec![cw(1e-6), at(droops, 1e7)], stepped: false });
    assert_eq!((two.turns(), two.duration_s()), (2, Some(2e-6)));
    insta::assert_snapshot!(faults("{ kind = 'in-turn', waveforms = [{ kind = 'cw', pulse_s = 1e-6 }], droop_db = 1.0 }"), @"radar.waveform.waveforms: 1 of them is not allowed; allowed: 2 to 1024 pulses");
    insta::assert_snapshot!(faults("{ kind = 'in-turn', waveforms = [{ kind = 'noise', bandwidth_hz = 1e6 }, { kind = 'stepped', steps = 2, step_hz = 0, pulse_s = 1e-6 }, { kind = 'lfm', bandwidth_hz = 6e7, pulse_s = 1e-6, offset_hz = 3e7 }] }"), @r#"
radar.waveform.waveforms.0.kind: kind = "noise" among waveforms is not allowed; allowed: pulses, which end
radar.waveform.waveforms.1.kind: kind = "stepped" among waveforms is not allowed; allowed: a single pulse
radar.waveform.waveforms.1.step_hz: 0 Hz is not allowed; allowed: a step that is not 0
radar.waveform.waveforms.2.offset_hz: a band from 0 to 6e7 Hz about the carrier is not allowed; allowed: within 5e7 Hz of it: half of sample_rate_hz
"#);
    insta::assert_snapshot!(faults("{ kind = 'stepped', steps = 1, step_hz = 1e6, pulse_s = 1e-6, offset_hz = 1.0 }"), @r#"
radar.waveform.steps: 1 is out of range; allowed: a whole number from 2 to 1024
radar.waveform.offset_hz: not allowed here (kind = "stepped")
"#);
    insta::assert_snapshot!(faults("{ kind = 'stepped', steps = 120, step_hz = 1e6, pulse_s = 1e-6 }"), @"radar.waveform.step_hz: a band from -6e7 to 6e7 Hz about the carrier is not allowed; allowed: within 5e7 Hz of it: half of sample_rate_hz");
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
    insta::assert_snapshot!(coded("chips = 5, chip_s = 1e-7"), @r#"radar.waveform.code: is missing; required: "barker", "frank", "p3", "p4", "m-sequence", "golay-a", "golay-b""#);
    insta::assert_snapshot!(coded("code = 'barker', chips = 6, chip_s = 1e-7"), @r#"radar.waveform.chips: 6 chips of code = "barker" is not allowed; allowed: 2, 3, 4, 5, 7, 11 or 13"#);
    insta::assert_snapshot!(coded("code = 'frank', chips = 15, chip_s = 1e-7"), @r#"radar.waveform.chips: 15 chips of code = "frank" is not allowed; allowed: the square of a whole number from 2 to 256"#);
    insta::assert_snapshot!(coded("code = 'p3', chips = 1, chip_s = 0"), @r#"
radar.waveform.chips: 1 is out of range; allowed: a whole number from 2 to 65536
radar.waveform.chip_s: 0 is out of range; allowed: a number above 0, up to 1 s
"#);
    insta::assert_snapshot!(coded("code = 'p4', chips = 5, chip_s = 1e-9"), @r#"radar.waveform.chip_s: 9.999999999999999e8 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 1e8 Hz"#);
    insta::assert_snapshot!(coded("code = 'm-sequence', chips = 5, chip_s = 1e-7"), @r#"
radar.waveform.chips: not allowed here (code = "m-sequence")
radar.waveform.register: is missing; required: a whole number from 2 to 16
"#);
    insta::assert_snapshot!(coded("code = 'p4', chips = 50, register = 5, bandwidth_hz = 1e6, chip_s = 1e-7"), @r#"
radar.waveform.register: not allowed here (code = "p4")
radar.waveform.bandwidth_hz: not allowed here (kind = "phase-code")
"#);
    insta::assert_snapshot!(coded("code = 'p4', chips = 60000, chip_s = 1e-6"), @r#"
radar.prf_hz: 4504.504505 us between pulses are shorter than the pulse of 60000 us: two pulses would leave at once; allowed: at least 60000 us
radar.window.samples: 512 samples (5.12e-6 s) are shorter than the pulse (6e-2 s); allowed: at least 6000000
"#);
    insta::assert_snapshot!(faults("{ kind = 'nlfm', bandwidth_hz = 2e8, pulse_s = 1e-9, sidelobe_db = 70 }"), @r#"
radar.waveform.bandwidth_hz: 2e8 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 1e8 Hz
radar.waveform.sidelobe_db: 70 is out of range; allowed: a number from 20 to 60 dB
radar.waveform.pulse_s: bandwidth_hz times pulse_s = 0.2 is not allowed; allowed: a product of 4 to 20000 for kind = "nlfm"
"#);
    insta::assert_snapshot!(faults("{ kind = 'nlfm', bandwidth_hz = 5e7, pulse_s = 1e-6, taper = 'hamming', sidelobe_db = 30 }"), @r#"radar.waveform.sidelobe_db: not allowed here (taper = "hamming")"#);
    insta::assert_snapshot!(faults("{ kind = 'nlfm', bandwidth_hz = 5e7, pulse_s = 1e-6, sweep = 'triangular' }"), @r#"radar.waveform.sweep: sweep = "triangular" of kind = "nlfm" is not allowed; allowed: "up", "down""#);
    insta::assert_snapshot!(faults("{ kind = 'cw', bandwidth_hz = 5e7 }"), @r#"
radar.waveform.pulse_s: is missing; required: a number above 0, up to 10 s
radar.waveform.bandwidth_hz: not allowed here (kind = "cw")
"#);
}

#[test]
fn a_continuous_signal_is_cut_by_the_interval() {
    let radar = coastal_with(&ENDLESS).unwrap().scene.radar;
    let interval_s = radar.sends().mean_pri_s();
    let source = Source::Noise { bandwidth_hz: 1e6, seed: 5 };
    assert_eq!(radar.waveform, Waveform::Stream { source, interval_s });
    let seedless = [ENDLESS[0], ("radar.waveform", "{ kind = 'noise', bandwidth_hz = 1e6 }")];
    let source = Source::Noise { bandwidth_hz: 1e6, seed: 0 };
    let radar = coastal_with(&seedless).unwrap().scene.radar;
    assert_eq!(radar.waveform, Waveform::Stream { source, interval_s });
    let refused = |more: &[(&str, &str)]| {
        let error = coastal_with(&[&ENDLESS[..], more].concat()).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    let windows = refused(&[("radar.window", "{ samples = 512, start_us = 20 }")]);
    assert!(windows.contains("gate = \"continuous\" in [radar.window], or an [[emitter]]"), "{windows}");
    let short = refused(&[("radar.prf_hz", "20000")]);
    assert!(short.contains("with segments of 50 samples") && short.contains("64 to 1.048576e6"), "{short}");
    let wide = refused(&[("radar.waveform.bandwidth_hz", "2e8")]);
    assert!(wide.contains("radar.waveform.bandwidth_hz: 2e8 Hz exceeds the sample rate"), "{wide}");
    let pulse = refused(&[("radar.waveform.pulse_s", "1e-3")]);
    assert!(pulse.contains("radar.waveform.pulse_s: not allowed here (kind = \"noise\")"), "{pulse}");
}

#[test]
fn television_is_that_of_the_standard() {
    use crate::scene::radar::{Constellation, DvbT, DvbTMode, Guard};
    let of = |waveform: &str| coastal_with(&[ENDLESS[0], ("radar.waveform", waveform)]);
    let Waveform::Stream { source: Source::DvbT { of: found, seed }, .. } =
        of("{ kind = 'dvb-t', bandwidth_hz = 8e6, seed = 4 }").unwrap().scene.radar.waveform
    else {
        panic!("another kind");
    };
    let constellation = Constellation::Qam64;
    let expected = DvbT { channel_hz: 8e6, mode: DvbTMode::K8, guard: Guard::Quarter, constellation };
    assert_eq!((found, seed), (expected, 4));
    // 64/7 MHz; 6817 carriers 1116 Hz apart.
    assert!((found.rate_hz() - 64e6 / 7.0).abs() < 1e-6 && (found.occupied_hz() - 7.608_259e6).abs() < 1.0);
    let refused = |waveform: &str| of(waveform).unwrap_err().to_string();
    let narrow = refused("{ kind = 'dvb-t', bandwidth_hz = 5e6, carriers = '4k', guard = '1/4' }");
    assert!(narrow.contains("a channel of 5e6 Hz") && narrow.contains("6e6, 7e6 or 8e6 Hz"), "{narrow}");
    assert!(narrow.contains("radar.waveform.carriers: \"4k\" is not allowed"), "{narrow}");
    let chips = refused("{ kind = 'dvb-t', bandwidth_hz = 8e6, chips = 3 }");
    assert!(chips.contains("radar.waveform.chips: not allowed here (kind = \"dvb-t\")"), "{chips}");
}

/// What is in the air beside television.
#[test]
fn broadcast_and_satellites_are_what_they_say() {
    let with =
        |waveform: &str| coastal_with(&[ENDLESS[0], ("radar.prf_hz", "1000"), ("radar.waveform", waveform)]);
    let source = |waveform: &str| match with(waveform).unwrap().scene.radar.waveform {
        Waveform::Stream { source, .. } => source,
        other => panic!("{other:?}"),
    };
    let fm = source("{ kind = 'fm', seed = 4 }");
    assert_eq!(fm, Source::Fm { of: Fm { deviation_hz: 75e3 }, seed: 4 });
    assert_eq!((fm.bandwidth_hz(), fm.rate_hz()), (Some(256e3), Some(312_500.0)));
    let satellite = source("{ kind = 'gps-l1-ca', prn = 32 }");
    assert_eq!(satellite, Source::GpsCa { prn: 32, seed: 0 });
    assert_eq!((satellite.bandwidth_hz(), satellite.rate_hz()), (Some(1.023e6), Some(10.23e6)));
    let refused = |waveform: &str, more: &[(&str, &str)]| {
        let all = [&[ENDLESS[0], ("radar.prf_hz", "1000"), ("radar.waveform", waveform)], more].concat();
        let error = coastal_with(&all).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    insta::assert_snapshot!(refused("{ kind = 'gps-l1-ca', prn = 33, deviation_hz = 1e4 }", &[]), @r#"
radar.waveform.prn: 33 is out of range; allowed: a whole number from 1 to 32
radar.waveform.deviation_hz: not allowed here (kind = "gps-l1-ca")
"#);
    insta::assert_snapshot!(refused("{ kind = 'gps-l1-ca', prn = 3 }", &[("radar.sample_rate_hz", "1e6")]), @"radar.waveform.kind: 1.023e6 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 1e6 Hz");
    insta::assert_snapshot!(refused("{ kind = 'fm', deviation_hz = 300e3, droop_db = 1 }", &[]), @"radar.waveform.deviation_hz: 300000.0 is out of range; allowed: a number from 5000 to 200000 Hz");
    insta::assert_snapshot!(refused("{ kind = 'fm' }", &[("radar.prf_hz", "5000"), ("radar.sample_rate_hz", "2e5")]), @r#"
radar.waveform.deviation_hz: 2.56e5 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 2e5 Hz
radar.waveform.kind: kind = "fm" with segments of 62.5 samples is not allowed; allowed: 64 to 1.048576e6 samples in an interval, by prf_hz and its rate
"#);
}

#[test]
fn a_recording_is_named_with_what_it_holds() {
    let of = |waveform: &str| coastal_with(&[ENDLESS[0], ("radar.waveform", waveform)]);
    let file = |waveform: &str| match of(waveform).unwrap().scene.radar.waveform {
        Waveform::Stream { source: Source::IqFile(file), .. } => file,
        other => panic!("{other:?}"),
    };
    let path = in_configs().with_file_name("../tests/data/iq/noise.cs8");
    let datatype = Datatype::named("ci8").unwrap();
    let expected = IqFile { path, raw: Some(RawIq { rate_hz: 1e6, datatype }), after: AfterEnd::Silence };
    assert_eq!(file(IQ_FILE), expected);
    let by_ending = file("{ kind = 'iq-file', path = '../tests/data/iq/noise.cs8', rate_hz = 1e6 }");
    assert_eq!(by_ending, IqFile { after: AfterEnd::Repeat, ..expected });
    let described = file("{ kind = 'iq-file', path = '../tests/data/iq/noise.sigmf-meta' }");
    assert_eq!(described.raw, None);
    let found = crate::radar::waveform::Recording::open(&described).unwrap();
    assert_eq!(crate::radar::waveform::Signal::rate_hz(&found), 1e6);
    let refused = |waveform: &str| {
        let error = of(waveform).unwrap_err();
        let faults = error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>();
        faults.replace(&in_configs().with_file_name("").display().to_string(), "")
    };
    let beside = |keys: &str| refused(&format!("{{ kind = 'iq-file', path = '../tests/data/iq/{keys} }}"));
    insta::assert_snapshot!(refused("{ kind = 'iq-file', rate_hz = 1e6 }"), @"radar.waveform.path: is missing; required: a file that exists (relative to the scenario file)");
    insta::assert_snapshot!(beside("none.sigmf-meta', after = 'stop'"), @r#"
radar.waveform.path: there is no file ../tests/data/iq/none.sigmf-meta; allowed: a file that exists (relative to the scenario file)
radar.waveform.after: "stop" is not allowed; allowed: "repeat", "silence"
"#);
    insta::assert_snapshot!(beside("noise.sigmf-data', rate_hz = 1e6, datatype = 'ci8'"), @r#"
radar.waveform.rate_hz: not allowed here (the metadata of a SigMF recording have it)
radar.waveform.datatype: not allowed here (the metadata of a SigMF recording have it)
"#);
    insta::assert_snapshot!(beside("noise.cs8', datatype = 'rf32_le'"), @r#"
radar.waveform.rate_hz: is missing; required: a number from 1000 to 1e11 Hz
radar.waveform.datatype: "rf32_le" is not allowed; allowed: "cf32_le", "cf64_le", "ci32_le", "ci16_le", "ci8", "cu32_le", "cu16_le", "cu8", "cf32_be", "cf64_be", "ci32_be", "ci16_be", "cu32_be", "cu16_be"
"#);
    insta::assert_snapshot!(refused("{ kind = 'iq-file', path = 'test.toml', rate_hz = 1e6 }"), @"radar.waveform.path: there is no file test.toml; allowed: a file that exists (relative to the scenario file)");
    insta::assert_snapshot!(refused("{ kind = 'iq-file', path = 'quickstart.toml', rate_hz = 1e6 }"), @"radar.waveform.path: a file of samples that ends in .toml is not allowed; allowed: datatype beside it, or one of the endings cf32, fc32, c64, cfile, cf64, fc64, c128, cs16, sc16, ci16, cs8, sc8, cu8");
    insta::assert_snapshot!(beside("noise.cs8', rate_hz = 1e4"), @r#"radar.waveform.kind: kind = "iq-file" with segments of 45.04504504504504 samples is not allowed; allowed: 64 to 1.048576e6 samples in an interval, by prf_hz and its rate"#);
}

/// A radar of a bandwidth far above its sample rate, that is dechirped.
fn dechirped(more: &[(&str, &str)]) -> Result<Run, ConfigError> {
    let own = [
        ("radar.sample_rate_hz", "2e6"),
        ("radar.prf_hz", "1000"),
        ("radar.waveform", "{ kind = 'lfm', bandwidth_hz = 75e6, pulse_s = 1e-3 }"),
        ("radar.window", "{ samples = 500, start_us = 30 }"),
        ("radar.dechirp", "{ delay_us = 20 }"),
    ];
    coastal_with(&[&own[..], more].concat())
}

#[test]
fn a_dechirp_needs_a_linear_sweep_in_windows() {
    let radar = dechirped(&[]).unwrap().scene.radar;
    assert_eq!(radar.dechirp.unwrap().delay_s, 20e-6);
    let of = |more: &[(&str, &str)]| {
        let error = dechirped(more).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    insta::assert_snapshot!(of(&[("radar.dechirp", "{}")]), @"radar.dechirp.delay_us: is missing; required: a number from 0 to 1e7 us");
    insta::assert_snapshot!(of(&[("radar.waveform", "{ kind = 'cw', pulse_s = 1e-5 }")]), @r#"radar.dechirp: dechirp of waveform.kind = "cw" is not allowed; allowed: waveform.kind = "lfm""#);
    insta::assert_snapshot!(of(&[("radar.window", "{ gate = 'continuous', samples = 500 }"), ("receiver.0.clock", "{ preset = 'tcxo' }")]), @r#"
radar.window: gate = "continuous" beside clock errors of antennas is not allowed; allowed: gate = "windowed", or no clock errors of antennas
radar.dechirp: dechirp beside gate = "continuous" is not allowed; allowed: no dechirp, or no gate = "continuous"
radar.dechirp: dechirp beside clock errors of antennas is not allowed; allowed: no dechirp, or no clock errors of antennas
"#);
    insta::assert_snapshot!(of(&[("radar.waveform.bandwidth_hz", "8e9")]), @"radar.dechirp: a pulse and a window of 1.701e7 samples at the rate of the bandwidth is not allowed; allowed: up to 4e6: less bandwidth, a shorter pulse or window");
}
