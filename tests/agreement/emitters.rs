//! Emitters beside the radar's own transmitters: against these, a closed form, and the reference.

use std::f64::consts::TAU;
use std::ops::Range;

use nereus::bench::accuracy::Judge;
use nereus::config::Run;
use nereus::pipeline::build;
use nereus::pulse::Samples;
use num_complex::Complex64;

use crate::cases::{sized, some_of};
use crate::runs;
use crate::two_platforms::{self, C, ON_MAST, masts, power, tone};

/// The radar of [`two_platforms`], with pulses of 1 us.
fn run(sea: bool, radar: &str, more: &str, settings: &[(&str, &str)]) -> Run {
    let waveform = r#"waveform = { kind = "lfm", bandwidth_hz = 30e6, pulse_s = 1e-6 }"#;
    two_platforms::run(0.16, sea, &format!("{radar}\n{waveform}"), more, settings)
}

/// Windows in which the target is received.
const WINDOW: &str = "window = { samples = 256, start_us = 15.2 }";

/// An antenna of the other platform.
const OTHER: &str = r#"
    platform = "other"
    power_w = 20.0
    antenna = { kind = "rectangle", width_m = 0.2, height_m = 0.4 }
    pointing = { kind = "at", position_m = [0, 0, 0] }
"#;

/// Samples of some pulses by channel, `[pulse][channel][sample]`.
fn samples(run: &Run, range: Range<u64>) -> Vec<Vec<Vec<Complex64>>> {
    let of = |pulse: nereus::pulse::Pulse| {
        let Samples::Cf32(samples) = &pulse.samples else { panic!("a converter") };
        let channels = samples.chunks_exact(run.scene.radar.window.samples);
        let widen = |s: &num_complex::Complex32| Complex64::new(s.re.into(), s.im.into());
        channels.map(|own| own.iter().map(widen).collect()).collect()
    };
    runs::kept(build::stream(run, range).unwrap()).into_iter().map(of).collect()
}

/// What an emitter adds is what a transmitter of the same train has in channels of its own.
#[test]
fn an_emitter_adds_what_a_transmitter_would_have_had() {
    let train = r#"prf_hz = 500.0"#;
    for echo in some_of(["reference", "fast"]) {
        let settings = [("fidelity.echo", echo), ("fidelity.error_db", "-100")];
        let emitter = format!(
            "[[emitter]]\nname = \"jam\"\n{train}\npolarisation = \"V\"\ndirect_path = false\n{OTHER}
            waveform = {{ kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 1e-6 }}"
        );
        let channels = "channels = [\"HH\", \"VH\", \"VV\"]";
        let both = run(true, &format!("{train}\n{channels}\n{WINDOW}"), &emitter, &settings);
        let transmitter = format!("[[transmitter]]\nname = \"jam\"\n{OTHER}");
        let apart = "channels = [\"HH\", \"VH\", \"VV\", \"HV\"]";
        let two = run(true, &format!("{train}\n{apart}\n{WINDOW}"), &transmitter, &settings);
        let names: Vec<&str> = two.scene.radar.channels.iter().map(|own| own.name.as_str()).collect();
        let place = |name: &str| names.iter().position(|own| *own == name).unwrap();
        let range = 0..sized(40, 12);
        let mut heard = 0.0;
        for (sums, parts) in samples(&both, range.clone()).iter().zip(samples(&two, range)) {
            for (sum, [own, jam]) in sums.iter().zip([
                ["HH-tx-rx", "HV-jam-rx"],
                ["VH-tx-rx", "VV-jam-rx"],
                ["VV-tx-rx", "VV-jam-rx"],
            ]) {
                let [own, jam] = [own, jam].map(|name| &parts[place(name)]);
                let off: Vec<Complex64> =
                    sum.iter().zip(own.iter().zip(jam)).map(|(sum, (a, b))| sum - (a + b)).collect();
                let off_db = 10.0 * (power(&off) / power(sum)).log10();
                assert!(off_db < -95.0, "{echo}: {off_db} dB");
                heard += power(jam) / power(own);
            }
        }
        assert!(heard > 1.0, "the emitter is weak: {heard}");
    }
}

/// A carrier that never pauses, off that of the receiver, by its direct path between antennas that rest:
/// `sqrt(P g) lambda/(4 pi d) e^{j 2 pi (df t - f d/c)}` in windows of any train, without a step where one
/// of its pulses ends and the next begins.
#[test]
fn a_continuous_carrier_keeps_its_phase() {
    let (prf_hz, offset_hz, power_w, distance_m) = (8000.0, 3.7e6, 5.0f64, 5000.0);
    for (echo, train, start_us, least_db) in some_of([
        ("reference", "prf_hz = 317.0", 0.0, -60.0),
        // Under way when the first window opens; a jump by df would turn it by a third of a turn.
        ("reference", "prf_hz = 317.0", -1234.567, -60.0),
        ("fast", "prf_hz = 317.0", -1234.567, -60.0),
        ("fast", "prf_hz = 317.0", 0.0, -60.0),
        ("fast", "pri_us = [3100, 3250.5, 2900.25]", -3e8 + 0.25, -60.0),
    ]) {
        let keys = format!(
            "name = \"carrier\"\ncarrier_hz = {:?}\nprf_hz = {prf_hz:?}\nstart_us = {start_us:?}\npower_w = {power_w:?}",
            9.4e9 + offset_hz
        );
        let emitter = masts(distance_m) + &tone(&keys, 1.0 / prf_hz);
        let listens = [&[("fidelity.echo", echo)][..], &ON_MAST].concat();
        // Windows that open in the middle of an emission, and hold the seam between two.
        let window = "window = { samples = 4000, start_us = 40 }";
        let run = run(false, &format!("{train}\nchannels = [\"VV\"]\n{window}"), &emitter, &listens);
        let wavelength_m = C / (9.4e9 + offset_hz);
        let amplitude = power_w.sqrt() * wavelength_m / (2.0 * TAU * distance_m);
        let emissions = &run.scene.radar.emissions;
        // Without a start of its own it arrives after the first windows have opened.
        let first = if start_us < 0.0 { 0 } else { 5 };
        for (index, pulse) in (first..).zip(samples(&run, first..first + sized(40, 10))) {
            let opens_s = emissions.interval_s(0, index) + 40e-6;
            let expected = |j: usize| {
                let t_s = opens_s + j as f64 / 40e6;
                let turns = (offset_hz * t_s).fract() - ((9.4e9 + offset_hz) * distance_m / C).fract();
                amplitude * Complex64::cis(TAU * turns)
            };
            let off: Vec<Complex64> = pulse[0].iter().enumerate().map(|(j, s)| s - expected(j)).collect();
            let off_db = 10.0 * (power(&off) / (pulse[0].len() as f64 * amplitude * amplitude)).log10();
            assert!(off_db < least_db, "{echo}, {train}, {start_us} us, pulse {index}: {off_db} dB");
        }
    }
}

/// A pulse that starts so long after pulse 0 lies in the window where start, interval and light time put it:
/// the centroid of its power is that of an even envelope behind an even filter.
#[test]
fn a_start_puts_pulses_into_their_place() {
    let (distance_m, pulse_s, fs_hz) = (3000.0, 2e-6, 40e6);
    for (echo, start_us, train) in some_of([
        ("reference", 12.345_678_9, "prf_hz = 317.0"),
        ("fast", 12.345_678_9, "prf_hz = 317.0"),
        ("fast", -20_000.0 + 0.1234, "pri_us = [2100, 1900]"),
    ]) {
        let keys = format!("name = \"beacon\"\npri_us = [2000]\nstart_us = {start_us:?}\npower_w = 1.0");
        let emitter = masts(distance_m) + &tone(&keys, pulse_s);
        let listens = [&[("fidelity.echo", echo), ("fidelity.error_db", "-80")][..], &ON_MAST].concat();
        let window = "window = { samples = 65536, start_us = 3 }";
        let run = run(false, &format!("{train}\nchannels = [\"VV\"]\n{window}"), &emitter, &listens);
        let emissions = run.scene.radar.emissions.clone();
        let mut found = 0;
        for (index, pulse) in (0..).zip(samples(&run, 0..sized(20, 8))) {
            let opens_s = emissions.interval_s(0, index) + 3e-6;
            let arrives_s = |k: i64| start_us * 1e-6 + k as f64 * 2e-3 + distance_m / C;
            let k = ((opens_s - arrives_s(0)) / 2e-3).ceil() as i64;
            let begins = (arrives_s(k) - opens_s) * fs_hz;
            let lasts = pulse_s * fs_hz;
            if k < 0 || !(200.0..65_536.0 - 200.0 - lasts).contains(&begins) {
                continue;
            }
            let about = begins as usize - 150..(begins + lasts) as usize + 150;
            let (sum, moment) = about.fold((0.0, 0.0), |(sum, moment), j| {
                let power = pulse[0][j].norm_sqr();
                (sum + power, moment + j as f64 * power)
            });
            let off = moment / sum - (begins + 0.5 * lasts);
            // Ringing that is cut off at 150 samples: under 1e-6 of the power, times those.
            assert!(off.abs() < 2e-4, "{echo}, pulse {index}: {off} samples");
            found += 1;
        }
        assert!(found > 2, "{echo}, {train}: {found}");
    }
}

/// Shadows are updated before an emitter starts, and after it has ended, if that is before pulse 0: ships
/// then lie where none of its pulses meets them.
#[test]
fn ships_are_where_shadows_are_updated() {
    let ship = r#"
        [[ship]]
        hull = "wigley"
        length_m = 16.0
        beam_m = 2.0
        draught_m = 0.8
        position_m = [10.0, 2.0]
        heading_deg = 254.0
        speed_mps = 4.0
    "#;
    for start_us in [78.3, 9000.0, -60_000.0] {
        let emitter = format!(
            r#"
            [[emitter]]
            name = "other"
            platform = "other"
            power_w = 1.0
            prf_hz = 2000.0
            start_us = {start_us:?}
            waveform = {{ kind = "lfm", bandwidth_hz = 8e6, pulse_s = 3e-6 }}
            antenna = {{ kind = "isotropic" }}
            "#
        );
        let radar = format!("prf_hz = 500.0\nchannels = [\"HH\"]\n{WINDOW}");
        let run = run(true, &radar, &[ship, &emitter].concat(), &[("sea.shadow.update_ms", "20")]);
        let made = samples(&run, 0..run.scene.pulses.min(12));
        assert!(made.iter().flatten().flatten().all(|s| s.is_finite()), "{start_us} us");
    }
}

/// Trains that have nothing to do with the radar's.
#[test]
fn emitters_keep_the_error() {
    let of = |train: &str, more: &str| {
        format!(
            "[[emitter]]\nname = \"jam\"\n{train}\n{more}\n{OTHER}
            waveform = {{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 3e-6, sweep = \"down\" }}"
        )
    };
    let often = of("prf_hz = 9733.0", "carrier_hz = 9.41e9\npolarisation = \"V\"");
    let seldom = of("pri_us = [700, 811.5]", "carrier_hz = 9.395e9\npolarisation = \"R\"");
    // In windows much shorter than its pulses.
    let long = of("prf_hz = 400.0", "").replace("pulse_s = 3e-6", "pulse_s = 2.5e-4");
    let early = of("prf_hz = 9733.0\nstart_us = -431.25", "carrier_hz = 9.41e9\npolarisation = \"V\"");
    let late = of("pri_us = [700, 811.5]\nstart_us = 40123.75", "polarisation = \"R\"");
    let two = format!("{often}\n{}", seldom.replace("jam", "buzz"));
    let still = "prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]";
    let turns = "pri_us = [1200, 1300, 1250]\nchannels = [\"HH\", \"VV\"]\ntx_polarisation = \"alternating\"";
    for (what, radar, emitters, asked) in some_of([
        ("often", still, &often, "-60"),
        ("seldom", still, &seldom, "-60"),
        ("two, a radar that staggers and alternates", turns, &two, "-60"),
        ("coarse", still, &two, "-40"),
        ("fine", still, &two, "-80"),
        ("long", still, &long, "-60"),
        ("early", still, &early, "-60"),
        ("late, a radar that staggers and alternates", turns, &late, "-60"),
        ("exact", turns, &two, "-100"),
    ]) {
        let run = run(true, &format!("{radar}\n{WINDOW}"), emitters, &[("fidelity.error_db", asked)]);
        runs::keeps_the_error(what, &run);
    }
}

/// Echoes of the sea, far above what the window holds, of which a part lies within reach of it, before it
/// and after. Before: -35.4 and -39.4 dB.
#[test]
fn what_is_within_reach_is_what_the_reference_has() {
    let radar = "prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\nwindow = { samples = 256, start_us = 19.47 }";
    for start_us in [0.0, 9.05] {
        let emitter = format!(
            "[[emitter]]\nname = \"jam\"\nprf_hz = 800.0\nstart_us = {start_us:?}\ncarrier_hz = 9.41e9
            polarisation = \"V\"\ndirect_path = false\n{OTHER}
            waveform = {{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 1e-6, sweep = \"down\" }}"
        );
        let far = [("target.0.position_m", "[0, 900, 1]"), ("target.0.rcs_dbsm", "30")];
        runs::keeps_the_error(&format!("{start_us} us"), &run(true, radar, &emitter, &far));
    }
}

/// Pulses that last nearly their interval, between platforms that close at some 100 m/s: Doppler within a
/// pulse is taken off its mean over a few of them, not over a block of the radar's. Before: -52.8 dB of -60.
#[test]
fn long_pulses_between_moving_platforms() {
    let emitter = format!(
        "[[emitter]]\nname = \"jam\"\npri_us = [4000]\ncarrier_hz = 9.4002e9\necho = false\n{OTHER}
        waveform = {{ kind = \"lfm\", bandwidth_hz = 0.5e6, pulse_s = 3e-3 }}"
    );
    let slow = [
        ("radar.sample_rate_hz", "2e6"),
        ("radar.waveform.bandwidth_hz", "1e6"),
        ("radar.waveform.pulse_s", "5e-6"),
        ("target.0.rcs_dbsm", "-100"),
    ];
    let radar = "prf_hz = 500.0\nchannels = [\"HH\"]\nwindow = { samples = 64, start_us = 30 }";
    runs::keeps_the_error("long pulses", &run(false, radar, &emitter, &slow));
}

/// An emission of the slowest of trains is received by the pulse that it reaches, however far off the next
/// is.
#[test]
fn what_a_pulse_receives_does_not_depend_on_what_comes_later() {
    let of = |duration_s: &str| {
        let emitter = format!(
            "[[emitter]]\nname = \"jam\"\npri_us = [999990]\necho = false\n{OTHER}
            waveform = {{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 0.5e-6 }}"
        );
        let fast = [
            ("scene.duration_s", duration_s),
            ("platform.1.track.velocity_mps", "[-700, 30, 2]"),
            ("target.0.rcs_dbsm", "-100"),
            ("fidelity.echo", "reference"),
        ];
        // It comes 10 us earlier, 9 to 12 us after it has left.
        run(
            false,
            "prf_hz = 500.0\nchannels = [\"HH\"]\nwindow = { samples = 256, start_us = 0 }",
            &emitter,
            &fast,
        )
    };
    let [short, long] = ["1.2", "2.5"].map(|duration_s| samples(&of(duration_s), 498..503));
    assert_eq!(short, long);
    assert!(long.iter().any(|pulse| power(&pulse[0]) > 0.0), "nothing is received");
}

#[test]
fn what_emitters_add_depends_on_the_pulse_alone() {
    let emitter = format!(
        "[[emitter]]\nname = \"jam\"\nprf_hz = 9733.0\ncarrier_hz = 9.41e9\n{OTHER}
        waveform = {{ kind = \"lfm\", bandwidth_hz = 8e6, pulse_s = 3e-6 }}"
    );
    let radar = format!("prf_hz = 800.0\nchannels = [\"HH\", \"VV\"]\n{WINDOW}");
    let made = |threads: &str, range: Range<u64>| {
        runs::kept(
            build::stream(&run(true, &radar, &emitter, &[("stream.threads", threads)]), range).unwrap(),
        )
    };
    let whole = made("2", 0..120);
    assert!(made("1", 0..120) == whole, "one thread and two differ");
    assert!(made("3", 70..101) == whole[70..101], "a range differs from that part of the run");
}

/// A second radar on the same mast of the same interval, whose direct path no window receives: its echo keeps
/// the error all the same, and has the bits of one without a direct path.
#[test]
fn a_direct_path_that_is_never_received_judges_nothing() {
    let radar = "prf_hz = 1000.0\nchannels = [\"HH\", \"HV\"]\n\
                 waveform = { kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 1e-6 }\n\
                 window = { samples = 256, start_us = 15.2 }";
    let second = |more: &str| {
        format!(
            "[[emitter]]\nname = \"second\"\nplatform = \"aircraft\"\nlever_arm_m = [5.0, 0.0, 0.0]\npower_w = 30.0\n\
             prf_hz = 1000.0\nwaveform = {{ kind = \"lfm\", bandwidth_hz = 1e6, pulse_s = 2.5e-6 }}\n\
             antenna = {{ kind = \"isotropic\" }}\n{more}"
        )
    };
    let settings = [("fidelity.error_db", "-60"), ("target.0.velocity_mps", "[30, -200, 0]")];
    let of = |more: &str| two_platforms::run(0.02, true, radar, &second(more), &settings);
    runs::keeps_the_error("an echo without its direct path", &of(""));
    let made = |run: &Run| runs::kept(build::stream(run, 0..run.scene.pulses).unwrap());
    let [with, without] = [of(""), of("direct_path = false")].map(|run| made(&run));
    assert!(with.iter().zip(&without).all(|(a, b)| a.samples == b.samples));
}

/// The first sample of a direct path at the end of one window, and nothing else in two channels: what is
/// predicted is of that. No more is promised than -92 dB, and what is asked is kept all the same.
#[test]
fn an_emitter_at_the_edge_of_one_window_keeps_the_error() {
    let run = runs::scene("tests/data/cases/emitter-at-an-edge.toml", &[]);
    let judge = Judge::new(&run, (0..run.scene.pulses).collect(), 2, |_| ()).unwrap();
    let (measured_db, plan) = runs::measured(&judge, &run);
    let predicted_db = plan.prediction.total_db();
    println!("predicted {predicted_db:.1}, measured {measured_db:.1} dB");
    assert!(measured_db <= predicted_db && measured_db <= plan.asked.error_db);
}
