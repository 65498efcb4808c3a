//! Reference B' against the integral it stands for, in the time domain and with nothing shared: the pulse,
//! its Doppler and the filter's impulse response under one quadrature. And against reference A, oversampled.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nereus::echo::reference::{GUARD_SAMPLES, ReferenceEcho, raw_samples};
use nereus::paths::list::ScattererPaths;
use nereus::radar::filter::ReceiveFilter;
use nereus::radar::waveform::{Lfm, Waveform};
use nereus::scene::radar::Sweep;
use num_complex::Complex64;

use crate::quadrature::unit_interval;

const F0_HZ: f64 = 10e9;
const FS_HZ: f64 = 100e6;
const WINDOW: usize = 256;
const START_S: f64 = 23.6e-6;

struct Echo {
    offset_s: f64,
    delay_s: f64,
    rate: f64,
    amplitude: Complex64,
}

fn paths(echoes: &[Echo]) -> ScattererPaths {
    let mut paths = ScattererPaths::new(1, 1, echoes.len());
    for e in echoes {
        paths.emission_offset_s.push(e.offset_s);
        paths.delay_s[0].push(e.delay_s);
        paths.delay_rate[0].push(e.rate);
        paths.amplitude[0].push(e.amplitude);
    }
    paths
}

/// Samples of one channel by way of the reference.
fn reference(echo: &ReferenceEcho, paths: &ScattererPaths) -> Vec<Complex64> {
    let n = echo.fft_len();
    let mut out = vec![Complex64::ZERO; n];
    echo.spectrum(paths, START_S, &mut out);
    nereus_fft::inverse(n).process(&mut out);
    out.iter().take(WINDOW).map(|s| s * FS_HZ / n as f64).collect()
}

fn rms(x: &[Complex64]) -> f64 {
    (x.iter().map(Complex64::norm_sqr).sum::<f64>() / x.len() as f64).sqrt()
}

fn relative_rms(ours: &[Complex64], theirs: &[Complex64]) -> f64 {
    let difference: Vec<Complex64> = ours.iter().zip(theirs).map(|(a, b)| a - b).collect();
    rms(&difference) / rms(theirs)
}

/// The raised cosine, inverse transform of the receive filter, `t` in samples, times `1/fs`.
fn impulse_response(t: f64) -> f64 {
    let sinc = if t == 0.0 { 1.0 } else { (0.9 * PI * t).sin() / (0.9 * PI * t) };
    let x = 0.2 * t;
    // At t = +-5 the quotient has the limit pi/4.
    let taper = if (x.abs() - 1.0).abs() < 1e-6 { PI / 4.0 } else { (0.5 * PI * x).cos() / (1.0 - x * x) };
    0.9 * sinc * taper
}

/// `h` repeated every `n` samples: a finite Fourier sum.
fn periodic_response(t: f64, n: usize) -> f64 {
    let filter = ReceiveFilter::new(FS_HZ);
    let terms = (1..n.div_ceil(2)).map(|k| {
        let f = k as f64 / n as f64;
        2.0 * filter.response(f * FS_HZ) * (TAU * (f * t).fract()).cos()
    });
    (1.0 + terms.sum::<f64>()) / n as f64
}

/// `a e^{-j 2 pi f0 tau} int q(x) h(t - o - tau - x) dx` at sample `j`; what leaves `u` after the beginning
/// of the pulse arrives at `x = (1 + r) u` with the phase of its emission:
/// `q(x) = p(u) e^{j 2 pi f0 (u - x)}`.
fn integral(echoes: &[Echo], b_hz: f64, tc_s: f64, j: usize, h: impl Fn(f64) -> f64) -> Complex64 {
    let mut sum = Complex64::ZERO;
    for e in echoes {
        let carrier = Complex64::cis(-TAU * (F0_HZ * e.delay_s).fract());
        let place_s = START_S + j as f64 / FS_HZ - e.offset_s - e.delay_s;
        // Filter and pulse together turn (0.5 fs + B/2) Tc = 27 times at most: half a turn in a panel.
        let part = unit_interval(64, |y| {
            let (u, x) = (y * tc_s, (1.0 + e.rate) * y * tc_s);
            let phase = PI * b_hz * tc_s * (y - 0.5).powi(2) - TAU * F0_HZ * e.rate * u;
            Complex64::cis(phase) * h((place_s - x) * FS_HZ)
        });
        sum += e.amplitude * carrier * part * tc_s * (1.0 + e.rate) * FS_HZ;
    }
    sum
}

fn scene(rate: f64) -> Vec<Echo> {
    vec![
        Echo { offset_s: 0.0, delay_s: 24.183_52e-6, rate, amplitude: Complex64::new(1.0, 0.0) },
        Echo { offset_s: -1e-3, delay_s: 1025.1e-6, rate: -0.7 * rate, amplitude: Complex64::new(-0.3, 0.6) },
        // Cut by the end of the window.
        Echo { offset_s: 0.0, delay_s: 26.05e-6, rate: 0.0, amplitude: Complex64::new(0.0, 0.5) },
    ]
}

#[test]
fn reference_is_the_integral_it_stands_for() {
    let (b_hz, tc_s) = (60e6, 0.333e-6);
    let pulse = Arc::new(Lfm::new(b_hz, tc_s, Sweep::Up).unwrap());
    let echo = ReferenceEcho::new(pulse, F0_HZ, FS_HZ, WINDOW, vec![0]);
    for rate in [0.0, -7e-7, 5e-5] {
        let echoes = scene(rate);
        let ours = reference(&echo, &paths(&echoes));
        let (mut worst, level) = (0.0f64, rms(&ours));
        for j in (0..WINDOW).step_by(5) {
            let theirs = integral(&echoes, b_hz, tc_s, j, |t| periodic_response(t, echo.fft_len()));
            worst = worst.max((ours[j] - theirs).norm() / level);
        }
        println!("rate {rate:e}: worst sample {worst:.1e} of the rms");
        // Phase of f0 tau, 1e7 turns for the second emission: 1e7 x 2^-53 x 2 pi = 7e-9 rad of half the
        // signal would be the bound; both sides round the same product, so only 1e-9 is left for the rest.
        assert!(worst <= 1e-9, "{rate}: {worst}");
    }
}

#[test]
fn nothing_wraps_into_the_window() {
    // The same with the filter's own, endless response: what differs is what the period folds back. An echo's
    // image ends or begins a guard or more from any sample, where |h| <= 1/(pi n (0.04 n^2 - 1)), and lasts
    // Tc.
    let (b_hz, tc_s) = (60e6, 0.333e-6);
    let pulse = Lfm::new(b_hz, tc_s, Sweep::Up).unwrap();
    let span = pulse.span_samples(FS_HZ);
    let echo = ReferenceEcho::new(Arc::new(pulse), F0_HZ, FS_HZ, WINDOW, vec![0]);
    let fold: f64 = (GUARD_SAMPLES..GUARD_SAMPLES + span)
        .map(|n| 1.0 / (PI * n as f64 * (0.04 * (n * n) as f64 - 1.0)))
        .sum();
    let guard_s = GUARD_SAMPLES as f64 / FS_HZ;
    for place_s in [-tc_s - 0.99 * guard_s, -0.1e-6, 1e-6, 2.4e-6, 2.56e-6 + 0.99 * guard_s] {
        let one = [Echo { offset_s: 0.0, delay_s: START_S + place_s, rate: 0.0, amplitude: Complex64::ONE }];
        let ours = reference(&echo, &paths(&one));
        let mut worst = 0.0f64;
        for (j, sample) in ours.iter().enumerate().step_by(3) {
            worst = worst.max((sample - integral(&one, b_hz, tc_s, j, impulse_response)).norm());
        }
        println!("place {place_s:.2e} s: folded back {worst:.1e}, bound {fold:.1e}");
        assert!(worst <= fold, "{place_s}: {worst} > {fold}");
    }
}

#[test]
fn reference_is_the_low_passed_oversampled_pulse() {
    // Reference A at 64 fs, filtered by H in the frequency domain. Sampling moves each of the two edges of a
    // pulse by up to half a fine sample, 1/(128 fs): a white error of that size over 0.875 fs against the
    // energy Tc gives (1/128) sqrt(2 x 0.875 / (fs Tc)) = 1.8e-3 (-55 dB) at worst, -59 dB for edges placed
    // at random.
    const FINE: usize = 64;
    let (b_hz, tc_s) = (60e6, 0.333e-6);
    let pulse = Arc::new(Lfm::new(b_hz, tc_s, Sweep::Up).unwrap());
    let bound = (2.0 * 0.875 / (FS_HZ * tc_s)).sqrt() / (2.0 * FINE as f64);
    let n = ReferenceEcho::new(pulse.clone(), F0_HZ, FS_HZ, WINDOW, vec![0]).fft_len();
    let echo = ReferenceEcho::with_period(pulse.clone(), F0_HZ, FS_HZ, WINDOW, vec![0], n);
    let filter = ReceiveFilter::new(FS_HZ);
    for rate in [0.0, -7e-7, 5e-5] {
        // Whole echoes: the raw pulse does not wrap.
        let echoes = &scene(rate)[..2];
        let paths = paths(echoes);
        let mut fine = vec![Complex64::ZERO; n * FINE];
        raw_samples(pulse.as_ref(), F0_HZ, FS_HZ * FINE as f64, START_S, &paths, 0, 0, &mut fine);
        nereus_fft::forward(n * FINE).process(&mut fine);
        let mut coarse = vec![Complex64::ZERO; n];
        for (k, bin) in coarse.iter_mut().enumerate() {
            let signed = if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
            let from = if 2 * k < n { k } else { n * FINE - (n - k) };
            *bin = fine[from] * filter.response(signed * FS_HZ / n as f64) / (n * FINE) as f64;
        }
        nereus_fft::inverse(n).process(&mut coarse);
        let error = relative_rms(&reference(&echo, &paths), &coarse[..WINDOW]);
        println!("rate {rate:e}: oversampled reference A differs by {:.1} dB", 20.0 * error.log10());
        assert!(error <= bound, "{rate}: {error} > {bound}");
    }
}

#[test]
fn neglected_doppler_is_no_doppler() {
    let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
    let make = || ReferenceEcho::new(pulse.clone(), F0_HZ, FS_HZ, WINDOW, vec![0]);
    let still = reference(&make(), &paths(&scene(0.0)));
    let neglected = reference(&make().neglect_intra_pulse_doppler(), &paths(&scene(-7.4e-7)));
    assert_eq!(still, neglected);
    // 7.4 kHz: without the turn at mid-pulse, f_D Tc = 2.46e-3 turns are lost linearly from 0 to the end:
    // rms phase 2 pi 2.46e-3 / sqrt 3 = 8.9e-3 (-41 dB) for the first echo.
    let one = &scene(-7.4e-7)[..1];
    let exact = reference(&make(), &paths(one));
    let lost = relative_rms(&reference(&make().neglect_intra_pulse_doppler(), &paths(one)), &exact);
    let expected = TAU * 7.4e3 * 0.333e-6 / 3f64.sqrt();
    println!("neglecting 7.4 kHz costs {lost:.3e}, expected {expected:.3e}");
    // The filter removes 1 % of the pulse's energy, most of it at the edges.
    assert!((lost / expected - 1.0).abs() < 0.05, "{lost} {expected}");
}

#[test]
fn channels_of_a_pair_share_and_pairs_do_not() {
    // Channels 0, 1, 3 on pair 0 and 2 on pair 1: each is what it would be alone, bit for bit, however often
    // asked.
    let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Down).unwrap());
    let echo = ReferenceEcho::new(pulse.clone(), F0_HZ, FS_HZ, WINDOW, vec![0, 0, 1, 0]);
    let n = echo.fft_len();
    let mut all = ScattererPaths::new(2, 4, 3);
    for i in 0..3 {
        let x = f64::from(i);
        all.emission_offset_s.push(0.0);
        all.delay_s[0].push(24e-6 + 0.31e-6 * x);
        all.delay_s[1].push(24.2e-6 + 0.17e-6 * x);
        all.delay_rate[0].push(1e-7 * x);
        all.delay_rate[1].push(-3e-7);
        for (channel, a) in all.amplitude.iter_mut().enumerate() {
            a.push(Complex64::new(1.0 + channel as f64, x));
        }
    }
    // Seen by pair 1 only.
    for channel in [0, 1, 3] {
        all.amplitude[channel][1] = Complex64::ZERO;
    }
    let mut out = vec![Complex64::ZERO; 4 * n];
    echo.spectrum(&all, START_S, &mut out);
    let first = out.clone();
    echo.spectrum(&ScattererPaths::new(2, 4, 0), 0.0, &mut out);
    echo.spectrum(&all, START_S, &mut out);
    assert_eq!(first, out);
    for (channel, pair) in [0, 0, 1, 0].into_iter().enumerate() {
        let alone = ReferenceEcho::new(pulse.clone(), F0_HZ, FS_HZ, WINDOW, vec![0]);
        let mut paths = ScattererPaths::new(1, 1, 3);
        paths.emission_offset_s.clone_from(&all.emission_offset_s);
        paths.delay_s[0].clone_from(&all.delay_s[pair]);
        paths.delay_rate[0].clone_from(&all.delay_rate[pair]);
        paths.amplitude[0].clone_from(&all.amplitude[channel]);
        let mut single = vec![Complex64::ZERO; n];
        alone.spectrum(&paths, START_S, &mut single);
        assert_eq!(single, out[channel * n..(channel + 1) * n], "channel {channel}");
    }
}

/// A scatterer path, its radar, and what its echo lacks (dB) where the envelope is not stretched with the
/// carrier.
struct Stretched {
    what: &'static str,
    f0_hz: f64,
    fs_hz: f64,
    b_hz: f64,
    tc_s: f64,
    rate: f64,
    rigid_db: Option<f64>,
}

#[test]
fn envelope_is_stretched_with_its_carrier() {
    // 2 pi B Tc |r| / sqrt 30 of a chirp.
    let x = Stretched {
        what: "X band",
        f0_hz: 10e9,
        fs_hz: 100e6,
        b_hz: 60e6,
        tc_s: 0.333e-6,
        rate: -1.48e-6,
        rigid_db: Some(-89.4),
    };
    let cases = [
        Stretched {
            what: "Ka band from orbit",
            f0_hz: 35e9,
            fs_hz: 250e6,
            b_hz: 200e6,
            tc_s: 20e-6,
            rate: 2.8e-5,
            rigid_db: Some(-17.8),
        },
        Stretched {
            what: "jet",
            fs_hz: 200e6,
            b_hz: 164e6,
            tc_s: 50e-6,
            rate: -1.5e-6,
            rigid_db: Some(-37.0),
            ..x
        },
        Stretched { what: "fast", rate: 5e-5, rigid_db: None, ..x },
        Stretched { what: "plain pulse", b_hz: 0.0, rate: 5e-5, rigid_db: None, ..x },
        x,
    ];
    for case in cases {
        let Stretched { what, f0_hz, fs_hz, b_hz, tc_s, rate, rigid_db } = case;
        let pulse = Lfm::new(b_hz, tc_s, Sweep::Up).unwrap();
        let window = pulse.span_samples(fs_hz) + 200;
        let delay_s = START_S + 60.3 / fs_hz;
        let one = [Echo { offset_s: 0.0, delay_s, rate, amplitude: Complex64::new(0.6, -0.8) }];
        let echo = ReferenceEcho::new(Arc::new(pulse), f0_hz, fs_hz, window, vec![0]);
        let n = echo.fft_len();
        let mut ours = vec![Complex64::ZERO; n];
        echo.spectrum(&paths(&one), START_S, &mut ours);
        nereus_fft::inverse(n).process(&mut ours);
        // Half a turn of pulse, Doppler and filter in a panel.
        let turns = (0.5 * (b_hz + fs_hz) + f0_hz * rate.abs()) * tc_s;
        let panels = (2.0 * turns).ceil() as usize + 8;
        // Three images on either side: the next leave 1e-13.
        let h = |t: f64| (-3..=3).map(|m| impulse_response(t + f64::from(m) * n as f64)).sum::<f64>();
        let (mut worst, mut lost, mut all) = (0.0f64, 0.0, 0.0);
        let rigid = rigid_samples(&case, &one[0], n);
        for j in (7..window).step_by(window / 40) {
            let carrier = Complex64::cis(-TAU * (f0_hz * delay_s).fract());
            // What leaves u after the beginning arrives x after the beginning, with the phase of its
            // emission.
            let part = unit_interval(panels, |y| {
                let u = y * tc_s;
                let x = u + rate * u;
                let chirp = PI * b_hz * tc_s * (y - 0.5).powi(2);
                Complex64::cis(chirp + TAU * f0_hz * (u - x)) * h((START_S - delay_s - x) * fs_hz + j as f64)
            });
            let theirs = one[0].amplitude * carrier * part * tc_s * (1.0 + rate) * fs_hz;
            worst = worst.max((ours[j] * fs_hz / n as f64 - theirs).norm());
            lost += (rigid[j] - theirs).norm_sqr();
            all += theirs.norm_sqr();
        }
        let lost_db = 10.0 * (lost / all).log10();
        println!(
            "{what}: worst sample {worst:.1e}, {lost_db:.1} dB with a rigid envelope, {rigid_db:?} by its law"
        );
        assert!(worst <= 1e-9, "{what}: {worst}");
        // One sample in forty of the error's course over the pulse.
        assert!(rigid_db.is_none_or(|db| (lost_db - db).abs() < 1.0), "{what}: {lost_db}");
    }
}

/// The same with `P(f + f0 r)`.
fn rigid_samples(case: &Stretched, one: &Echo, n: usize) -> Vec<Complex64> {
    let pulse = Lfm::new(case.b_hz, case.tc_s, Sweep::Up).unwrap();
    let filter = ReceiveFilter::new(case.fs_hz);
    let carrier = one.amplitude * Complex64::cis(-TAU * (case.f0_hz * one.delay_s).fract());
    let mut out: Vec<Complex64> = (0..n)
        .map(|k| {
            let f_hz = nereus::radar::filter::bin_frequency_hz(k, n, case.fs_hz);
            let place = Complex64::cis(-TAU * (f_hz * (one.delay_s - START_S)).fract());
            pulse.spectrum(f_hz + case.f0_hz * one.rate)
                * filter.response(f_hz)
                * place
                * carrier
                * case.fs_hz
                / n as f64
        })
        .collect();
    nereus_fft::inverse(n).process(&mut out);
    out
}
