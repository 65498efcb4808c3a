//! Spectra of pulses against quadrature of their defining integral.

use std::f64::consts::{PI, TAU};
use std::io::Write;

use nereus::radar::waveform::{Lfm, Sampled, Triangular, Waveform, WaveformError, from_description};
use nereus::scene;
use nereus::scene::radar::Sweep;
use num_complex::Complex64;

use crate::quadrature::unit_interval;

/// `P(f)/Tc` of a sweep with `b = B Tc` at `v = f Tc`, straight from the definition.
fn chirp_integral(b: f64, v: f64) -> Complex64 {
    // 1/4 turn or less in a panel: the 8-point rule is then exact to rounding.
    let panels = 8 + (4.0 * (0.5 * b + v.abs())) as usize;
    unit_interval(panels, |y| Complex64::cis(PI * b * (y - 0.5) * (y - 0.5) - TAU * ((v * y).fract())))
}

#[test]
fn lfm_agrees_with_quadrature_for_every_product_and_frequency() {
    let mut worst = (0.0f64, 0.0, 0.0);
    for b in [0.0, 1e-15, 1e-9, 0.99e-6, 1.01e-6, 1e-5, 1e-3, 0.05, 0.7, 3.0, 20.0, 151.3, 1000.0, 1e4] {
        let mut places = vec![0.0, 1e-12, 1e-6, 3.1e-3, 3.3e-3, 0.3, 0.5, 1.0, 1.7, 6.0, 23.456, 100.25];
        // In the band, about its edge, and far outside.
        for share in [0.01, 0.33, 0.9, 0.999_999, 1.0, 1.000_001, 1.1, 3.0] {
            places.push(0.5 * b * share);
        }
        places.push(0.5 * b + 0.7 * f64::sqrt(b));
        for duration_s in [0.333e-6, 1e-3] {
            let bandwidth_hz = b / duration_s;
            let up = Lfm::new(bandwidth_hz, duration_s, Sweep::Up).unwrap();
            let down = Lfm::new(bandwidth_hz, duration_s, Sweep::Down).unwrap();
            // The level of the top of the spectrum, in Tc.
            let peak = 1.0 / b.max(1.0).sqrt();
            for v in places.iter().flat_map(|v| [*v, -*v]) {
                let f_hz = v / duration_s;
                // What was asked is f, not v: its rounding belongs to neither.
                let v = f_hz * duration_s;
                let expected = chirp_integral(b, v);
                // conj(p) has the spectrum conj(P(-f)).
                let mirrored = chirp_integral(b, -v).conj();
                for (ours, theirs) in [(up.spectrum(f_hz), expected), (down.spectrum(f_hz), mirrored)] {
                    let error = (ours / duration_s - theirs).norm() / peak;
                    if error > worst.0 {
                        worst = (error, b, v);
                    }
                    assert!(error <= 1e-10, "b {b}, f Tc {v}: {error:.1e}");
                }
            }
        }
    }
    println!("LFM: worst error {:.1e} of the peak, at B Tc = {}, f Tc = {}", worst.0, worst.1, worst.2);
}

#[test]
fn lfm_is_smooth_where_its_formula_changes() {
    // On either side of the edge of the band and of the small-product series.
    for b in [1e-5, 1.0, 20.0, 1e4] {
        let pulse = Lfm::new(b, 1.0, Sweep::Up).unwrap();
        let edge = 0.5 * b;
        let step = pulse.spectrum(edge * (1.0 + 1e-13)) - pulse.spectrum(edge * (1.0 - 1e-13));
        // dP/df <= pi Tc |P|max-like slope: 2 pi x 2e-13 x edge, and the formula's 1e-11.
        assert!(step.norm() * b.max(1.0).sqrt() < 1e-11 + TAU * 2e-13 * edge, "{b}: {step}");
    }
    for v in [0.0, 0.4, 2.5] {
        let below = Lfm::new(0.999_999_9e-6, 1.0, Sweep::Up).unwrap().spectrum(v);
        let above = Lfm::new(1.000_000_1e-6, 1.0, Sweep::Up).unwrap().spectrum(v);
        assert!((below - above).norm() < 1e-11, "{v}: {below} {above}");
    }
}

#[test]
fn lfm_obeys_parseval() {
    // Energy Tc = int |P|^2 df; beyond +-F the two edges leave 2 x 2/(4 pi^2 F) (two unit jumps, each |P| =
    // 1/(2 pi f)).
    let (b, duration_s) = (20.0, 1.0);
    let pulse = Lfm::new(b / duration_s, duration_s, Sweep::Up).unwrap();
    let limit = 4000.0;
    let n = 400_000;
    let h = 2.0 * limit / f64::from(n);
    let inside: f64 =
        (0..n).map(|i| pulse.spectrum((f64::from(i) + 0.5) * h - limit).norm_sqr()).sum::<f64>() * h;
    let outside = 2.0 * 2.0 / (4.0 * PI * PI * limit);
    println!("Parseval: {:.2e} from unity", inside + outside - 1.0);
    // The tail is |1/(f - B/2)|^2 rather than 1/f^2 (b/F = 0.5 %), with a fringe of period 1/Tc: 1 % of
    // 2.5e-5.
    assert!((inside + outside - duration_s).abs() < 1e-2 * outside, "{}", inside + outside);
}

#[test]
fn lfm_samples_are_the_pulse() {
    let pulse = Lfm::new(60e6, 0.333e-6, Sweep::Down).unwrap();
    assert_eq!(pulse.sample(-1e-15), Complex64::ZERO);
    assert_eq!(pulse.sample(0.333e-6), Complex64::ZERO);
    assert!((pulse.sample(0.333e-6 / 2.0) - 1.0).norm() < 1e-15);
    let x: f64 = 0.1e-6 - 0.1665e-6;
    let expected = Complex64::cis(-PI * (60e6 / 0.333e-6) * x * x);
    assert!((pulse.sample(0.1e-6) - expected).norm() < 1e-13);
}

/// Up and down again: against the integral of its samples, whose phase and frequency do not jump.
#[test]
fn a_triangular_sweep_is_the_integral_of_its_samples() {
    for b in [0.0, 3.0, 40.0, 1000.0] {
        let pulse = Triangular::new(b, 1.0).unwrap();
        assert_eq!((pulse.duration_s(), pulse.bandwidth_hz(), pulse.sweep_rate_hz_per_s()), (1.0, b, None));
        for v in [0.0, 0.3, -7.7, 0.25 * b, -0.49 * b, 0.5 * b, 0.8 * b, -2.1 * b] {
            let panels = 2 * (16 + (4.0 * (b + f64::abs(v))) as usize);
            let expected =
                unit_interval(panels, |y| pulse.sample(y) * Complex64::cis(-TAU * (v * y).fract()));
            let error = (pulse.spectrum(v) - expected).norm() * b.max(1.0).sqrt();
            assert!(error < 1e-10, "{b}, {v}: {error}");
        }
        let turn = |t: f64| (pulse.sample(t + 1e-6) * pulse.sample(t - 1e-6).conj()).arg() / TAU / 2e-6;
        for (t, frequency) in [(1e-3, -0.498 * b), (0.25, 0.0), (0.5, 0.5 * b), (0.75, 0.0), (0.9, -0.3 * b)]
        {
            assert!((turn(t) - frequency).abs() < 1e-5 * b.max(1.0), "{b}, {t}: {}", turn(t));
        }
    }
}

#[test]
fn odd_sweeps_are_refused_by_name() {
    let refused = |b, t| Lfm::new(b, t, Sweep::Up).unwrap_err().to_string();
    assert!(refused(-1.0, 1e-6).contains("-1 Hz is not allowed"));
    assert!(refused(f64::NAN, 1e-6).contains("bandwidth"));
    assert!(refused(1e6, 0.0).contains("pulse length 0 s"));
    assert!(refused(1e6, f64::INFINITY).contains("pulse length"));
    assert!(refused(1e9, 1.0).contains("time-bandwidth product 1000000000"));
}

/// A pulse with an odd shape: two tones under a bell, `len` samples.
fn shape(len: usize) -> Vec<Complex64> {
    (0..len)
        .map(|j| {
            let x = (j as f64 + 0.5) / len as f64;
            let bell = (PI * x).sin().powi(2);
            (Complex64::cis(0.31 * j as f64) + Complex64::cis(1.0 - 0.77 * j as f64) * 0.4) * bell
        })
        .collect()
}

#[test]
fn sampled_spectrum_is_the_sum_it_is_defined_by() {
    let rate_hz = 150e6;
    let mut worst = 0.0f64;
    for len in [1, 2, 3, 7, 64, 255, 1000] {
        for samples in [shape(len), vec![Complex64::new(0.3, 1.0); len]] {
            let pulse = Sampled::new(samples.clone(), rate_hz).unwrap();
            let direct = |f_hz: f64| {
                let x = f_hz / rate_hz;
                let terms = samples.iter().enumerate();
                terms.map(|(j, p)| p * Complex64::cis(-TAU * (x * j as f64).fract())).sum::<Complex64>()
                    / rate_hz
            };
            let places: Vec<f64> =
                (0..=997).map(|i| rate_hz * (f64::from(i) / 997.0 * 0.999_999 - 0.499_999_5)).collect();
            let peak = places.iter().map(|f| direct(*f).norm()).fold(0.0, f64::max);
            for f_hz in places {
                worst = worst.max((pulse.spectrum(f_hz) - direct(f_hz)).norm() / peak);
            }
            assert_eq!(pulse.spectrum(0.5 * rate_hz), Complex64::ZERO);
            assert_eq!(pulse.spectrum(-0.5 * rate_hz), Complex64::ZERO);
            assert_eq!(pulse.spectrum(3.0 * rate_hz), Complex64::ZERO);
        }
    }
    println!("sampled: worst error {worst:.1e} of the peak");
    // 1.8e-13 of sum |p| (module page), and the peak is not below sum |p| / sqrt(len).
    assert!(worst <= 1e-10, "{worst}");
}

#[test]
fn sampled_pulse_is_the_inverse_transform_of_its_spectrum() {
    let rate_hz = 1.0;
    let samples = shape(40);
    let pulse = Sampled::new(samples.clone(), rate_hz).unwrap();
    for (j, sample) in samples.iter().enumerate() {
        assert!((pulse.sample(j as f64) - sample).norm() < 1e-14);
    }
    for t in [-3.2, 0.25, 7.77, 20.5, 39.4, 44.0] {
        let integral = unit_interval(400, |y| {
            let f_hz = y - 0.5;
            pulse.spectrum(f_hz) * Complex64::cis(TAU * f_hz * t)
        });
        assert!((pulse.sample(t) - integral).norm() < 1e-11, "{t}");
    }
    assert_eq!(pulse.duration_s(), 40.0);
    // Two tones, 0.31/2pi = 0.049 and -0.77/2pi = -0.123, widened by 2/40 each.
    assert!((0.2..0.35).contains(&pulse.bandwidth_hz()), "{}", pulse.bandwidth_hz());
}

#[test]
fn sampled_sweep_approaches_the_sweep() {
    // The sum is the trapezoid rule but for half a sample at either end, |p| = 1 each: h together. The rule
    // itself misses h^2/12 [d/dt p e^{-j 2 pi f t}], with slopes up to pi B + 2 pi f at either end.
    let (b, per_tc) = (20.0, 64 * 20);
    let h = 1.0 / f64::from(per_tc);
    let sweep = Lfm::new(b, 1.0, Sweep::Up).unwrap();
    let samples = (0..per_tc).map(|j| sweep.sample(f64::from(j) * h)).collect();
    let pulse = Sampled::new(samples, 1.0 / h).unwrap();
    for f_hz in [-9.0, 0.0, 4.5, 12.0] {
        let error = (pulse.spectrum(f_hz) - sweep.spectrum(f_hz)).norm();
        assert!(error < h + h * h / 6.0 * (PI * b + TAU * f64::abs(f_hz)), "{f_hz}: {error}");
    }
}

fn file(text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

#[test]
fn waveforms_from_descriptions() {
    let lfm = scene::radar::Waveform::Lfm { bandwidth_hz: 60e6, duration_s: 1e-6, sweep: Sweep::Up };
    let lfm = from_description(&lfm).unwrap();
    assert_eq!((lfm.name(), lfm.bandwidth_hz(), lfm.duration_s()), ("lfm up", 60e6, 1e-6));
    let written = file("# Hann\n0,0\n0.5,0\n1,0\n0.5,0\n");
    let described = scene::radar::Waveform::Samples { path: written.path().to_owned(), rate_hz: 100e6 };
    let sampled = from_description(&described).unwrap();
    assert_eq!(sampled.name(), "samples");
    assert!((sampled.spectrum(0.0) - 2.0 / 100e6).norm() < 1e-20);
    assert_eq!(sampled.span_samples(200e6), 8);
}

#[test]
fn bad_waveform_files_are_refused_by_name_and_line() {
    let message = |text: &str, rate_hz: f64| {
        let written = file(text);
        let error = Sampled::from_file(written.path(), rate_hz).unwrap_err();
        error.to_string().replace(&written.path().display().to_string(), "FILE")
    };
    assert_eq!(
        message("1,0\n2;3\nnan,1\n", 1e6),
        "waveform file FILE: line 2: '2;3' has 1 value(s), a sample is 're,im'; line 3: 'nan' is not a finite number"
    );
    assert_eq!(message("# nothing\n", 1e6), "waveform file FILE: no sample differs from zero");
    assert_eq!(message("0,0\n", 1e6), "waveform file FILE: no sample differs from zero");
    assert!(message("1,0\n", -5.0).contains("-5 Hz is not allowed"));
    let missing = Sampled::from_file("/no/such/pulse.csv".as_ref(), 1e6).unwrap_err();
    assert!(matches!(missing, WaveformError::File { .. }));
    assert!(missing.to_string().contains("/no/such/pulse.csv"));
}
