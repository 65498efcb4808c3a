//! A scatterer path's echo, received without noise and range-compressed, peaks at its delay with its
//! amplitude and phase.
//!
//! Compressed signal at lag `t` after the window's start, from the samples `s` and a replica `q`, both on `M`
//! points: `c(t) = (1/M) sum_k S[k] conj(Q[k]) e^{j 2 pi f_k t} / sum |q|^2`. Predicted:
//! `a e^{-j 2 pi f0 tau}` at `t = o + tau - t_w`.

use std::f64::consts::TAU;
use std::sync::Arc;

use nereus::echo::reference::{ReferenceEcho, raw_samples};
use nereus::paths::list::ScattererPaths;
use nereus::pulse::SampleFormat;
use nereus::radar::filter::{ReceiveFilter, bin_frequency_hz};
use nereus::radar::receiver::Receiver;
use nereus::radar::waveform::{Lfm, Sampled, Waveform};
use nereus::scene::radar::Sweep;
use num_complex::Complex64;

use crate::receiver_noise::{cf32, radar, slot};

const F0_HZ: f64 = 10e9;

struct Case {
    fs_hz: f64,
    window: usize,
    start_s: f64,
    delay_s: f64,
    rate: f64,
    amplitude: Complex64,
}

struct Peak {
    lag_s: f64,
    value: Complex64,
}

/// Cf32 samples of one scatterer path.
fn received(case: &Case, waveform: &Arc<dyn Waveform>) -> (Receiver, Vec<Complex64>) {
    let mut radar = radar(case.window, None, None);
    radar.sample_rate_hz = case.fs_hz;
    let echo = ReferenceEcho::new(waveform.clone(), F0_HZ, case.fs_hz, case.window, vec![0]);
    let receiver = Receiver::new(&radar, 0, echo.fft_len(), 1);
    let mut paths = ScattererPaths::new(1, 1, 1);
    paths.emission_offset_s.push(0.0);
    paths.delay_s[0].push(case.delay_s);
    paths.delay_rate[0].push(case.rate);
    paths.amplitude[0].push(case.amplitude);
    let mut spectrum = vec![Complex64::ZERO; echo.fft_len()];
    assert!(echo.spectrum(&paths, case.start_s, &mut spectrum).is_complete());
    let mut pulse = slot(1, case.window, SampleFormat::Cf32);
    receiver.receive(&mut spectrum, &mut pulse, &mut receiver.scratch());
    let samples = cf32(&pulse).iter().map(|s| Complex64::new(f64::from(s.re), f64::from(s.im))).collect();
    (receiver, samples)
}

/// The highest point of the compressed signal.
fn compress(fs_hz: f64, samples: &[Complex64], replica: &[Complex64]) -> Peak {
    let m = (samples.len() + replica.len()).next_power_of_two();
    let energy: f64 = replica.iter().map(Complex64::norm_sqr).sum();
    let transform = |x: &[Complex64]| {
        let mut bins = x.to_vec();
        bins.resize(m, Complex64::ZERO);
        nereus_fft::forward(m).process(&mut bins);
        bins
    };
    let (s, q) = (transform(samples), transform(replica));
    let product: Vec<Complex64> = s.iter().zip(&q).map(|(s, q)| s * q.conj() / (energy * m as f64)).collect();
    let mut coarse = product.clone();
    nereus_fft::inverse(m).process(&mut coarse);
    let top = (0..samples.len()).max_by(|a, b| coarse[*a].norm().total_cmp(&coarse[*b].norm())).unwrap();
    let at = |lag: f64| -> Complex64 {
        let terms = product.iter().enumerate();
        terms.map(|(k, c)| c * Complex64::cis(TAU * (bin_frequency_hz(k, m, 1.0) * lag).fract())).sum()
    };
    // Golden section on |c|, to 1e-7 sample.
    let (mut low, mut high) = (top as f64 - 0.7, top as f64 + 0.7);
    let ratio = 0.618_033_988_749_895;
    while high - low > 1e-7 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if at(a).norm() > at(b).norm() {
            high = b;
        } else {
            low = a;
        }
    }
    let lag = 0.5 * (low + high);
    Peak { lag_s: lag / fs_hz, value: at(lag) }
}

/// `Q_r(f) = (1 + r) P((1 + r) f + f0 r) H(f)` in time, ringing and all: what a processor that knows the
/// Doppler correlates with. Entry `lead` is the start of the pulse.
fn matched(waveform: &dyn Waveform, fs_hz: f64, rate: f64, lead: usize) -> Vec<Complex64> {
    let period = (waveform.span_samples(fs_hz) + 4 * lead).next_power_of_two();
    let filter = ReceiveFilter::new(fs_hz);
    let mut q: Vec<Complex64> = (0..period)
        .map(|k| {
            let f_hz = bin_frequency_hz(k, period, fs_hz);
            let delay = Complex64::cis(-TAU * (f_hz * lead as f64 / fs_hz).fract());
            let pulse = waveform.spectrum((1.0 + rate) * f_hz + F0_HZ * rate) * (1.0 + rate);
            pulse * filter.response(f_hz) * delay * fs_hz / period as f64
        })
        .collect();
    nereus_fft::inverse(period).process(&mut q);
    q.truncate(waveform.span_samples(fs_hz) + 2 * lead);
    q
}

/// Checks amplitude (0.01 dB), phase (1e-3 rad) and delay (`delay_tolerance_s`), prints all three.
fn check(what: &str, peak: &Peak, expected: Complex64, lag_s: f64, delay_tolerance_s: f64) {
    let db = 20.0 * (peak.value.norm() / expected.norm()).log10();
    let rad = (peak.value / expected).arg();
    let delay_s = peak.lag_s - lag_s;
    println!("{what}: {db:+.1e} dB, {rad:+.1e} rad, {delay_s:+.1e} s");
    assert!(db.abs() <= 0.01, "{what}: {db} dB");
    assert!(rad.abs() <= 1e-3, "{what}: {rad} rad");
    assert!(delay_s.abs() <= delay_tolerance_s, "{what}: {delay_s} s");
}

fn replica64(receiver: &Receiver, waveform: &dyn Waveform) -> Vec<Complex64> {
    let replica = receiver.replica(waveform);
    assert_eq!(replica.len(), waveform.span_samples(receiver.sample_rate_hz()));
    replica.iter().map(|s| Complex64::new(f64::from(s.re), f64::from(s.im))).collect()
}

fn carrier(delay_s: f64) -> Complex64 {
    Complex64::cis(-TAU * (F0_HZ * delay_s).fract())
}

const STILL: Case = Case {
    fs_hz: 100e6,
    window: 512,
    start_s: 23.6e-6,
    delay_s: 25.123_456_7e-6,
    rate: 0.0,
    amplitude: Complex64::new(3e-7, -1e-7),
};

#[test]
fn recorded_replica_finds_a_still_target() {
    for sweep in [Sweep::Up, Sweep::Down] {
        for shift in [0.0, 0.13e-8, 0.5e-8, 0.77e-8] {
            let case = Case { delay_s: STILL.delay_s + shift, ..STILL };
            let waveform: Arc<dyn Waveform> = Arc::new(Lfm::new(60e6, 0.333e-6, sweep).unwrap());
            let (receiver, samples) = received(&case, &waveform);
            let peak = compress(case.fs_hz, &samples, &replica64(&receiver, waveform.as_ref()));
            // The replica ends 0.3 of a sample short of the middle of its last interval; the unequal ends
            // (|q|^2 differs by up to 0.5 there) tilt |c| by 0.25 against its curvature (2 pi 17 MHz)^2 33 =
            // 38/sample^2: 7e-3 sample.
            check("still", &peak, case.amplitude * carrier(case.delay_s), case.delay_s - case.start_s, 7e-11);
        }
    }
}

#[test]
fn recorded_replica_finds_a_moving_target_where_the_chirp_puts_it() {
    // p(t) e^{j 2 pi v t} = p(t + v/mu) e^{j pi v Tc - j pi v^2/mu} where both last: earlier by v/mu, v =
    // f_D.
    let waveform: Arc<dyn Waveform> = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
    let mu = 60e6 / 0.333e-6;
    for doppler_hz in [7e3, -7e3] {
        let case = Case { rate: -doppler_hz / F0_HZ, ..STILL };
        let (receiver, samples) = received(&case, &waveform);
        let peak = compress(case.fs_hz, &samples, &replica64(&receiver, waveform.as_ref()));
        let turn = Complex64::cis(0.5 * TAU * (doppler_hz * 0.333e-6 - doppler_hz * doppler_hz / mu));
        let lag_s = case.delay_s - case.start_s - doppler_hz / mu;
        check("7 kHz, recorded replica", &peak, case.amplitude * carrier(case.delay_s) * turn, lag_s, 7e-11);
    }
}

#[test]
fn matched_replica_finds_every_doppler() {
    let waveform: Arc<dyn Waveform> = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
    for (what, case) in [
        ("still", Case { ..STILL }),
        ("7 kHz", Case { rate: -7e-7, ..STILL }),
        ("-14.8 kHz", Case { rate: 1.48e-6, ..STILL }),
        // 800 km up at 7.5 km/s, both ways: 5.3 ms, 0.5 MHz.
        ("spaceborne", Case { rate: -5e-5, delay_s: 5.337_123_456_7e-3, start_s: 5.335_6e-3, ..STILL }),
    ] {
        let (_, samples) = received(&case, &waveform);
        let lead = 64;
        let peak = compress(case.fs_hz, &samples, &matched(waveform.as_ref(), case.fs_hz, case.rate, lead));
        let lag_s = case.delay_s - case.start_s - lead as f64 / case.fs_hz;
        // f32 samples: 6e-8 of the peak over a curvature of 1.2/sample^2 moves a maximum by sqrt(1e-7) at
        // most; the ringing that window and replica cut off (1e-5) by 1e-5.
        check(what, &peak, case.amplitude * carrier(case.delay_s), lag_s, 4e-12);
    }
}

#[test]
fn time_bandwidth_ten_thousand() {
    // 100 us, 100 MHz, at 150 MHz: 15000 samples of pulse.
    let waveform: Arc<dyn Waveform> = Arc::new(Lfm::new(100e6, 100e-6, Sweep::Up).unwrap());
    for rate in [0.0, -7e-7] {
        let case =
            Case { fs_hz: 150e6, window: 16_384, start_s: 200e-6, delay_s: 204.321_234_5e-6, rate, ..STILL };
        let (receiver, samples) = received(&case, &waveform);
        let expected = case.amplitude * carrier(case.delay_s);
        let lag_s = case.delay_s - case.start_s;
        if rate == 0.0 {
            let peak = compress(case.fs_hz, &samples, &replica64(&receiver, waveform.as_ref()));
            check("B Tc 1e4, recorded replica", &peak, expected, lag_s, 7e-11);
        }
        let lead = 64;
        let peak = compress(case.fs_hz, &samples, &matched(waveform.as_ref(), case.fs_hz, rate, lead));
        check("B Tc 1e4", &peak, expected, lag_s - lead as f64 / case.fs_hz, 4e-12);
    }
}

#[test]
fn sampled_pulse_is_found_too() {
    // A bell-shaped sweep of 64 samples at 80 MHz, received at 100 MHz.
    let samples = (0..64)
        .map(|j| {
            let x = (f64::from(j) + 0.5) / 64.0 - 0.5;
            Complex64::from_polar((0.5 * TAU * x).cos().powi(2), 0.5 * TAU * 20.0 * x * x)
        })
        .collect();
    let waveform: Arc<dyn Waveform> = Arc::new(Sampled::new(samples, 80e6).unwrap());
    let (receiver, received) = received(&STILL, &waveform);
    let peak = compress(STILL.fs_hz, &received, &replica64(&receiver, waveform.as_ref()));
    let expected = STILL.amplitude * carrier(STILL.delay_s);
    check("samples", &peak, expected, STILL.delay_s - STILL.start_s, 7e-11);
}

#[test]
fn replica_is_the_filtered_pulse() {
    // Away from its edges a replica is the chirp itself: the filter is flat over the band.
    let waveform = Lfm::new(60e6, 10e-6, Sweep::Up).unwrap();
    let receiver = Receiver::new(&radar(2048, None, None), 0, 4096, 1);
    let replica = receiver.replica(&waveform);
    assert_eq!(replica.len(), 1000);
    let mut raw = vec![Complex64::ZERO; 1000];
    let mut paths = ScattererPaths::new(1, 1, 1);
    paths.emission_offset_s.push(0.0);
    paths.delay_s[0].push(0.0);
    paths.delay_rate[0].push(0.0);
    paths.amplitude[0].push(Complex64::ONE);
    raw_samples(&waveform, F0_HZ, 100e6, 0.0, &paths, 0, 0, &mut raw);
    let middle = 300..700;
    let worst = middle
        .map(|i| (Complex64::new(f64::from(replica[i].re), f64::from(replica[i].im)) - raw[i]).norm())
        .fold(0.0, f64::max);
    println!("replica and chirp differ by {worst:.1e} inside");
    // The edges ring as 1/(pi n (0.04 n^2 - 1)): 1e-7 each from 300 samples on, and f32 rounding.
    assert!(worst < 1e-6, "{worst}");
}
