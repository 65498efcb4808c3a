//! Continuous signals: a segment with every emission, received as one signal. Against a closed form, against
//! the reference, and whatever blocks and threads.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::config::Run;
use nereus::pipeline::build;
use nereus::pulse::{Pulse, Samples};
use nereus::radar::waveform::{Broadcast, CoarseCode, Noise, Recording, Signal};
use nereus::scene::radar::{AfterEnd, Datatype, Fm, IqFile, RawIq};
use num_complex::Complex64;

use crate::cases::some_of;
use crate::runs;
use crate::two_platforms::{self, C, ON_MAST, RATE_HZ, masts, power};

/// Samples that an interpolation reaches to either side, and the shape of its window.
const REACH: f64 = 20.0;
const SHAPE: f64 = 10.5;

fn run(sea: bool, radar: &str, more: &str, settings: &[(&str, &str)]) -> Run {
    two_platforms::run(0.01, sea, radar, more, settings)
}

/// All samples of a channel.
fn samples_of(run: &Run, pulses: &[Pulse], channel: usize) -> Vec<Complex64> {
    let samples = run.scene.radar.window.samples;
    let of = |pulse: &Pulse| {
        let Samples::Cf32(all) = &pulse.samples else { panic!("a converter") };
        let own = all[channel * samples..][..samples].iter();
        own.map(|s| Complex64::new(s.re.into(), s.im.into())).collect::<Vec<_>>()
    };
    pulses.iter().flat_map(of).collect()
}

fn made(run: &Run) -> Vec<Pulse> {
    runs::kept(build::stream(run, 0..run.scene.pulses).unwrap())
}

/// `I0(x)` by its integral over half of a turn, whose mean of 32 points is exact to 1e-15 here.
fn bessel(x: f64) -> f64 {
    (0..16).map(|i| (x * ((f64::from(i) + 0.5) * PI / 32.0).cos()).cosh()).sum::<f64>() / 16.0
}

/// The signal of some samples at a time, `sum_j s_j h(R t - j)`.
fn signal(samples: &[Complex64], rate_hz: f64, t_s: f64) -> Complex64 {
    let place = t_s * rate_hz;
    let (from, to) = ((place - REACH).ceil().max(0.0) as usize, (place + REACH).max(0.0) as usize);
    let most = bessel(SHAPE);
    let of = |j: usize| {
        let u = place - j as f64;
        let window = bessel(SHAPE * (1.0 - (u / REACH).powi(2)).max(0.0).sqrt()) / most;
        let sinc = if u == 0.0 { 1.0 } else { (PI * u).sin() / (PI * u) };
        samples.get(j).map_or(Complex64::ZERO, |sample| sample * sinc * window)
    };
    (from..=to).map(of).sum()
}

/// What is radiated, as a scenario has it and by itself.
fn radiated(what: &str) -> (String, Arc<dyn Signal>) {
    match what {
        "noise" => ("bandwidth_hz = 20e6, seed = 9".to_owned(), Arc::new(Noise::new(20e6, 9))),
        "fm" => ("seed = 9".to_owned(), Arc::new(Broadcast::new(Fm { deviation_hz: 75e3 }, 9))),
        "gps-l1-ca" => ("prn = 17, seed = 9".to_owned(), Arc::new(CoarseCode::new(17, 9))),
        _ => {
            let path = "tests/data/iq/noise.cs8";
            let raw = RawIq { rate_hz: 20e6, datatype: Datatype::named("ci8").unwrap() };
            let of = IqFile { path: path.into(), raw: Some(raw), after: AfterEnd::Repeat };
            (format!("path = \"{path}\", rate_hz = 20e6"), Arc::new(Recording::open(&of).unwrap()))
        }
    }
}

/// The direct path of a signal between antennas that rest: `sqrt(P g) lambda/(4 pi d) s(t - d/c - K/R)
/// e^{-j 2 pi f d/c}`, of segments of a whole and of a broken number of samples, from a transmitter of the
/// radar and from an emitter off its carrier, without a step where segments or blocks meet.
#[test]
fn a_signal_is_one_over_all_segments() {
    let (distance_m, power_w) = (5000.0, 5.0f64);
    let tau_s = distance_m / C;
    let near = masts(distance_m);
    for (echo, what, prf_hz, samples, offset_hz) in some_of([
        ("fast", "noise", 8000.0, 1024, 0.0),
        ("fast", "noise", 7017.3, 1000, 0.0),
        ("fast", "noise", 3017.3, 1000, 3.7e6),
        ("reference", "noise", 7017.3, 1000, 0.0),
        ("reference", "noise", 3017.3, 1000, 3.7e6),
        ("fast", "iq-file", 7017.3, 1000, 3.7e6),
        ("fast", "gps-l1-ca", 7017.3, 1000, 0.0),
        ("fast", "fm", 3017.3, 1000, 3.7e6),
    ]) {
        let (keys, own_signal) = radiated(what);
        let rate_hz = own_signal.rate_hz();
        let own = format!("waveform = {{ kind = \"{what}\", {keys} }}");
        let emitter = format!(
            "{near}
            [[emitter]]
            name = \"far\"
            polarisation = \"V\"
            platform = \"far\"
            power_w = {power_w:?}
            carrier_hz = {:?}
            echo = false
            antenna = {{ kind = \"isotropic\" }}
            prf_hz = {prf_hz:?}
            {own}",
            9.4e9 + offset_hz
        );
        let window = format!("window = {{ gate = \"continuous\", samples = {samples} }}");
        let mut settings = vec![("fidelity.echo", echo), ("fidelity.error_db", "-80")];
        settings.extend(ON_MAST);
        let run = if offset_hz == 0.0 {
            settings.extend([
                ("transmitter.0.platform", "far"),
                ("transmitter.0.power_w", "5.0"),
                ("transmitter.0.antenna", "{ kind = 'isotropic' }"),
            ]);
            let radar =
                format!("prf_hz = {prf_hz:?}\nchannels = [\"VV\"]\ndirect_path = true\n{own}\n{window}");
            run(false, &radar, &near, &settings)
        } else {
            let sweep = "waveform = { kind = \"lfm\", bandwidth_hz = 5e6, pulse_s = 1e-6 }";
            let radar = format!("prf_hz = 500.0\nchannels = [\"VV\"]\n{sweep}\n{window}");
            settings.push(("transmitter.0.power_w", "1e-30"));
            run(false, &radar, &emitter, &settings)
        };
        let found = samples_of(&run, &made(&run), 0);
        let mut drawn = vec![Complex64::ZERO; (0.0105 * rate_hz) as usize];
        own_signal.fill(0, &mut drawn).unwrap();
        let carrier_hz = 9.4e9 + offset_hz;
        let amplitude = power_w.sqrt() * C / carrier_hz / (2.0 * TAU * distance_m);
        // Nothing has arrived before; then a few thousand samples, over many segments and blocks.
        let first = 4000;
        let found = &found[..first + 60_000];
        let expected: Vec<Complex64> = (first..found.len())
            .map(|j| {
                let t_s = j as f64 / RATE_HZ;
                let turns = (offset_hz * t_s).fract() - (carrier_hz * tau_s).fract();
                let own = signal(&drawn, rate_hz, t_s - tau_s - REACH / rate_hz);
                own * amplitude * Complex64::cis(TAU * turns)
            })
            .collect();
        let off: Vec<Complex64> = found[first..].iter().zip(&expected).map(|(a, b)| a - b).collect();
        let error_db = 10.0 * (power(&off) / power(&expected)).log10();
        let rms = (power(&expected) / expected.len() as f64).sqrt();
        let worst = off.iter().map(|off| off.norm()).fold(0.0, f64::max) / rms;
        // Of full power, as a sweep has it.
        let level_db = 20.0 * (rms / amplitude).log10();
        println!(
            "{echo}, {what}, {prf_hz} Hz, {samples} samples, {offset_hz} Hz off: {error_db:.1} dB, worst {worst:.1e}, level {level_db:.2} dB"
        );
        assert!(error_db < -78.0, "{echo} {what} {prf_hz}: {error_db}");
        assert!(worst < 1e-3, "{echo} {prf_hz}: {worst}");
        assert!(level_db.abs() < 0.1, "{level_db}");
    }
}

/// Against the reference, over all pulses: seas and targets, blocks longer and shorter than segments, an
/// emitter in windows and in blocks.
#[test]
fn streams_keep_the_error() {
    let noise = |hz: f64| format!("waveform = {{ kind = \"noise\", bandwidth_hz = {hz:?} }}");
    let blocks = |samples: usize| format!("window = {{ gate = \"continuous\", samples = {samples} }}");
    let sweep = "waveform = { kind = \"lfm\", bandwidth_hz = 30e6, pulse_s = 1e-6 }";
    let jammer =
        |train: &str, hz: f64| two_platforms::beside(&format!("carrier_hz = 9.41e9\n{train}\n{}", noise(hz)));
    let of = |prf_hz: f64, waveform: &str, samples: usize| {
        format!("prf_hz = {prf_hz:?}\nchannels = [\"HH\", \"VV\"]\n{waveform}\n{}", blocks(samples))
    };
    let own = |prf_hz: f64, hz: f64, samples: usize| of(prf_hz, &noise(hz), samples);
    let file = "waveform = { kind = \"iq-file\", path = \"tests/data/iq/noise.cs8\", rate_hz = 20e6 }";
    let windows = format!(
        "prf_hz = 1900.0\nchannels = [\"HH\", \"VV\"]\n{sweep}\nwindow = {{ samples = 256, start_us = 15.2 }}"
    );
    for (what, radar, emitters, asked) in some_of([
        ("noise", own(20_000.0, 30e6, 2048), String::new(), "-60"),
        ("short blocks", own(17_733.3, 12e6, 700), String::new(), "-40"),
        ("fine", own(20_000.0, 38e6, 4096), String::new(), "-75"),
        ("a file", of(17_733.3, file, 2048), String::new(), "-60"),
        (
            "a satellite",
            of(20_000.0, "waveform = { kind = \"gps-l1-ca\", prn = 5 }", 2048),
            String::new(),
            "-60",
        ),
        ("broadcast", of(4000.0, "waveform = { kind = \"fm\" }", 4096), String::new(), "-60"),
        ("in windows", windows, jammer("prf_hz = 9733.0", 8e6), "-60"),
        (
            "beside a stream",
            own(20_000.0, 30e6, 2048),
            jammer("prf_hz = 15000.0\nstart_us = -300", 8e6),
            "-60",
        ),
    ]) {
        let settings = [
            ("fidelity.error_db", asked),
            ("receiver.0.platform", "other"),
            ("scene.duration_s", "0.003"),
            ("scene.patch_size_m", "[16, 16]"),
        ];
        let run = run(true, &radar, &emitters, &settings);
        println!("{what}: nodes {}", runs::plan(&run).chosen.node_pulses);
        runs::keeps_the_error(what, &run);
    }
}

/// A recording that is cut after the run was built ends it with a word.
#[test]
fn a_recording_that_is_cut_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("air.cs8");
    let file = fs::read("tests/data/iq/noise.cs8").unwrap();
    for echo in ["fast", "reference"] {
        fs::write(&path, &file).unwrap();
        let waveform = format!("waveform = {{ kind = \"iq-file\", path = {path:?}, rate_hz = 20e6 }}");
        let radar = format!(
            "prf_hz = 8000.0\nchannels = [\"VV\"]\n{waveform}\nwindow = {{ gate = \"continuous\", samples = 1000 }}"
        );
        let run = run(false, &radar, "", &[("fidelity.echo", echo), ("stream.threads", "1")]);
        let stream = build::stream(&run, 0..run.scene.pulses).unwrap();
        fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(100).unwrap();
        let mut made = 0;
        let outcome = stream.tap(&Arc::new(AtomicBool::new(false)), |_| made += 1).unwrap();
        let error = outcome.result.unwrap_err().to_string();
        assert!(error.contains("air.cs8: it has changed since the run began"), "{echo}: {error}");
        assert!(made < run.scene.pulses, "{echo}: {made}");
    }
}
