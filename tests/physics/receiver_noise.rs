//! Thermal noise of the receiver: variance, shape, independence, and the same numbers whatever was asked
//! before.

use nereus::pulse::{Layout, Pulse, SampleFormat, Samples};
use nereus::radar::filter::{ReceiveFilter, bin_frequency_hz};
use nereus::radar::receiver::Receiver;
use nereus::scene::Radar;
use nereus::scene::radar::{Adc, Gate, Sweep, Waveform, Window};
use nereus::time::PulseTimes;
use num_complex::{Complex32, Complex64};

pub const FS_HZ: f64 = 100e6;

/// A radar that is all receiver.
pub fn radar(window_samples: usize, noise_figure_db: Option<f64>, adc: Option<Adc>) -> Radar {
    Radar {
        noise_figure_db,
        adc,
        ..Radar::new(
            10e9,
            FS_HZ,
            Waveform::Lfm { bandwidth_hz: 60e6, duration_s: 0.333e-6, sweep: Sweep::Up },
            PulseTimes::uniform(222.0).unwrap(),
            Window { samples: window_samples, gate: Gate::Fixed { start_s: 0.0 } },
        )
    }
}

pub fn slot(channels: usize, samples: usize, format: SampleFormat) -> Pulse {
    Pulse::new(&Layout { channels, samples, format, ..Layout::default() })
}

pub fn cf32(pulse: &Pulse) -> &[Complex32] {
    match &pulse.samples {
        Samples::Cf32(samples) => samples,
        Samples::Ci16(_) => panic!("codes where floating-point samples were laid out"),
    }
}

/// Pure noise of pulse `index`, `[channel][sample]`.
fn noise(receiver: &Receiver, n: usize, channels: usize, window: usize, index: u64) -> Vec<Complex64> {
    let mut spectrum = vec![Complex64::ZERO; n * channels];
    let mut pulse = slot(channels, window, SampleFormat::Cf32);
    pulse.index = index;
    receiver.receive(&mut spectrum, &mut pulse, &mut receiver.scratch());
    cf32(&pulse).iter().map(|s| Complex64::new(f64::from(s.re), f64::from(s.im))).collect()
}

/// Neighbours in different blocks are related as those of one block are: by the filter, as
/// `int |H|^2 cos(2 pi f) df / int |H|^2 df`.
#[test]
fn noise_goes_on_from_block_to_block() {
    let (samples, blocks, n) = (64, 20_000u64, 360);
    let mut radar = radar(samples, Some(3.0), None);
    radar.sent = Some(radar.emissions.clone());
    let receiver = Receiver::new(&radar, 5, n, 1);
    let all: Vec<Complex64> = (0..blocks).flat_map(|block| noise(&receiver, n, 1, samples, block)).collect();
    let filter = ReceiveFilter::new(FS_HZ);
    let mean = |of: &dyn Fn(f64) -> f64| {
        let f = |k: u32| (f64::from(k) + 0.5) / 4096.0 - 0.5;
        (0..4096).map(|k| filter.response(f(k) * FS_HZ).powi(2) * of(f(k))).sum::<f64>() / 4096.0
    };
    let expected = mean(&|f| (std::f64::consts::TAU * f).cos()) / mean(&|_| 1.0);
    assert!(expected > 0.1, "{expected}");
    let variance = receiver.noise_variance_w();
    let power = all.iter().map(|s| s.norm_sqr()).sum::<f64>() / all.len() as f64;
    // 1,280,000 samples: five deviations.
    assert!((power / variance - 1.0).abs() < 5.0 / 1.1e6f64.sqrt(), "{power} {variance}");
    let related = |at: usize| {
        let pairs = (at..all.len() - 1).step_by(samples).map(|j| (all[j + 1] * all[j].conj()).re);
        pairs.sum::<f64>() / (blocks as f64 * variance)
    };
    for (place, at) in [("border", samples - 1), ("middle", samples / 2)] {
        let found = related(at);
        println!("{place}: {found:.4}, expected {expected:.4}");
        // Of a product of circular Gaussians: the real part has the variance (1 + r^2)/2.
        assert!((found - expected).abs() < 5.0 * (0.51 / blocks as f64).sqrt(), "{place}: {found}");
    }
    // The same numbers whatever was asked before.
    assert_eq!(noise(&receiver, n, 1, samples, 7), all[7 * samples..8 * samples]);
}

#[test]
fn noise_has_the_variance_of_its_bandwidth() {
    let n = 360;
    let mut worst = 0.0f64;
    for noise_figure_db in [0.0, 3.0, 7.5] {
        let expected = 1.380_649e-23 * 290.0 * 0.875 * FS_HZ * 10f64.powf(noise_figure_db / 10.0);
        for seed in 0..8 {
            let receiver = Receiver::new(&radar(256, Some(noise_figure_db), None), seed, n, 2);
            assert!((receiver.noise_variance_w() / expected - 1.0).abs() < 1e-12);
            let pulses = 60;
            let power: f64 = (0..pulses)
                .flat_map(|index| noise(&receiver, n, 2, 256, index))
                .map(|s| s.norm_sqr())
                .sum::<f64>()
                / (pulses * 512) as f64;
            worst = worst.max((power / expected - 1.0).abs());
        }
    }
    // 30720 samples of |x|^2 (deviation = mean), of which the filter leaves about 0.875 independent: 0.61 %.
    // Worst of 24: five deviations.
    println!("noise variance: worst of 24 runs {:.2} %", 100.0 * worst);
    assert!(worst < 5.0 * 0.0061, "{worst}");
}

#[test]
fn noise_is_white_before_the_filter_and_circular() {
    let (n, trials) = (128, 4000);
    let receiver = Receiver::new(&radar(n, Some(3.0), None), 5, n, 1);
    let filter = ReceiveFilter::new(FS_HZ);
    let forward = nereus_fft::forward(n);
    let mut power = vec![0.0; n];
    let (mut second, mut fourth, mut pseudo, mut count) = (0.0, 0.0, Complex64::ZERO, 0.0);
    for index in 0..trials {
        let mut samples = noise(&receiver, n, 1, n, index);
        for s in &samples {
            second += s.norm_sqr();
            fourth += s.norm_sqr().powi(2);
            pseudo += s * s;
            count += 1.0;
        }
        forward.process(&mut samples);
        for (p, s) in power.iter_mut().zip(&samples) {
            *p += s.norm_sqr() / trials as f64;
        }
    }
    // X_k = fs S_k and E|S_k|^2 = k T0 F (N/fs) |H|^2, with k T0 F = variance / (0.875 fs).
    let level = receiver.noise_variance_w() * n as f64 / 0.875;
    for (k, p) in power.iter().enumerate() {
        let expected = level * filter.response(bin_frequency_hz(k, n, FS_HZ)).powi(2);
        // Mean of 4000 exponentials: 1.6 % each; five deviations for the worst of 128. Cf32 rounding: 1e-14
        // of the level.
        assert!(
            (p - expected).abs() <= 5.0 / (trials as f64).sqrt() * expected + 1e-13 * level,
            "bin {k}: {p} {expected}"
        );
    }
    let kurtosis = fourth / count / (second / count).powi(2);
    let circularity = (pseudo / second).norm();
    println!("E|x|^4/E|x|^2^2 = {kurtosis:.4}, |E x^2|/E|x|^2 = {circularity:.1e}");
    // 512000 samples, 0.875 of them independent: deviations 1/670 (pseudo-variance) and sqrt(20)/670 at most.
    assert!((kurtosis - 2.0).abs() < 5.0 * 20f64.sqrt() / 670.0, "{kurtosis}");
    assert!(circularity < 5.0 / 670.0, "{circularity}");
}

#[test]
fn channels_pulses_and_seeds_are_independent() {
    let n = 4096;
    let receiver = Receiver::new(&radar(n, Some(0.0), None), 1, n, 2);
    let other_seed = Receiver::new(&radar(n, Some(0.0), None), 2, n, 2);
    let first = noise(&receiver, n, 2, n, 7);
    let later = noise(&receiver, n, 2, n, 8);
    let other = noise(&other_seed, n, 2, n, 7);
    let series = [&first[..n], &first[n..], &later[..n], &other[..n]];
    for (i, a) in series.iter().enumerate() {
        for b in &series[i + 1..] {
            let cross: Complex64 = a.iter().zip(b.iter()).map(|(x, y)| x * y.conj()).sum();
            let energy: f64 = a.iter().map(Complex64::norm_sqr).sum();
            // Deviation 1/sqrt(0.875 n) = 1.7 %; five of them.
            assert!(
                cross.norm() / energy < 5.0 / (0.875 * n as f64).sqrt(),
                "{i}: {}",
                cross.norm() / energy
            );
        }
    }
}

#[test]
fn noise_does_not_depend_on_what_was_asked_before() {
    let (n, window) = (360, 256);
    let receiver = Receiver::new(&radar(window, Some(3.0), None), 11, n, 3);
    let alone = noise(&receiver, n, 3, window, 100);
    let mut scratch = receiver.scratch();
    let mut pulse = slot(3, window, SampleFormat::Cf32);
    for index in [3, 99, 101, 100] {
        pulse.index = index;
        receiver.receive(&mut vec![Complex64::ZERO; n * 3], &mut pulse, &mut scratch);
    }
    let after: Vec<Complex64> =
        cf32(&pulse).iter().map(|s| Complex64::new(f64::from(s.re), f64::from(s.im))).collect();
    assert_eq!(alone, after);
    // One channel asked, one computed: the same numbers.
    let single = Receiver::new(&radar(window, Some(3.0), None), 11, n, 1);
    assert_eq!(noise(&single, n, 1, window, 100), alone[..window]);
}

#[test]
fn a_noiseless_receiver_adds_nothing() {
    let receiver = Receiver::new(&radar(256, None, None), 1, 360, 2);
    assert_eq!(receiver.noise_variance_w(), 0.0);
    assert!(noise(&receiver, 360, 2, 256, 0).iter().all(|s| *s == Complex64::ZERO));
}
