//! Phase codes and plain pulses: spectra by their definition, side lobes as they are published.

use std::f64::consts::{PI, TAU};

use nereus::radar::waveform::{Coded, Waveform};
use nereus::scene::radar::Code;
use num_complex::Complex64;

use crate::quadrature::unit_interval;

/// Values of all chips, in the middle of each.
fn chips(pulse: &Coded, chip_s: f64) -> Vec<Complex64> {
    let count = (pulse.duration_s() / chip_s).round() as usize;
    (0..count).map(|k| pulse.sample((k as f64 + 0.5) * chip_s)).collect()
}

/// `|sum_k c_k conj(c_{k+lag})|` for every lag from 0 on.
fn aperiodic(chips: &[Complex64]) -> Vec<f64> {
    let at =
        |lag: usize| chips.iter().zip(&chips[lag..]).map(|(a, b)| b * a.conj()).sum::<Complex64>().norm();
    (0..chips.len()).map(at).collect()
}

fn code(code: Code) -> Vec<Complex64> {
    chips(&Coded::new(code, 1.0).unwrap(), 1.0)
}

#[test]
fn spectra_are_the_integral_of_their_chips() {
    let chip_s = 0.37e-6;
    let codes = [
        Code::Barker { chips: 13 },
        Code::Frank { phases: 8 },
        Code::P3 { chips: 33 },
        Code::P4 { chips: 100 },
        Code::MSequence { register: 7 },
        Code::P4 { chips: 1000 },
    ];
    let mut worst = 0.0f64;
    for code in codes {
        let pulse = Coded::new(code, chip_s).unwrap();
        let chips = chips(&pulse, chip_s);
        let peak_s = chip_s * (chips.len() as f64).sqrt();
        for share in [0.0, 1e-9, 0.013, 0.25, 0.4999, 0.5, 0.73, 1.0, 1.31, 7.7] {
            for f_hz in [share / chip_s, -share / chip_s] {
                // Over each chip, and its place.
                let x = f_hz * chip_s;
                let one = unit_interval(4 + (4.0 * x.abs()) as usize, |y| Complex64::cis(-TAU * x * y));
                let expected: Complex64 = chips
                    .iter()
                    .enumerate()
                    .map(|(k, chip)| chip * one * Complex64::cis(-TAU * (x * k as f64).fract()) * chip_s)
                    .sum();
                worst = worst.max((pulse.spectrum(f_hz) - expected).norm() / peak_s);
            }
        }
    }
    println!("worst error of a code's spectrum: {worst:.1e} of Tb sqrt(N)");
    // 1.8e-13 of N Tb by the table, times sqrt(N) = 32.
    assert!(worst < 1e-11, "{worst}");
}

#[test]
fn a_plain_pulse_has_the_spectrum_of_a_rectangle() {
    let (pulse, duration_s) = (Coded::plain(3e-6).unwrap(), 3e-6);
    for v in [1e-12, 0.2, 0.5, 1.0, 2.5, -17.25, 400.5] {
        let expected = duration_s * (PI * v).sin() / (PI * v) * Complex64::cis(-PI * v);
        let found = pulse.spectrum(v / duration_s);
        assert!((found - expected).norm() < 1e-13 * duration_s, "{v}: {found} {expected}");
    }
    assert_eq!(pulse.spectrum(0.0), Complex64::new(duration_s, 0.0));
    assert_eq!((pulse.sample(0.0), pulse.sample(2.9e-6)), (Complex64::ONE, Complex64::ONE));
    assert_eq!((pulse.sample(-1e-12), pulse.sample(3e-6)), (Complex64::ZERO, Complex64::ZERO));
    assert_eq!((pulse.name(), pulse.bandwidth_hz()), ("cw", 1.0 / 3e-6));
}

#[test]
fn barker_codes_have_side_lobes_of_one_chip() {
    for count in [2, 3, 4, 5, 7, 11, 13] {
        let found = aperiodic(&code(Code::Barker { chips: count }));
        assert!((found[0] - count as f64).abs() < 1e-12);
        assert!(found[1..].iter().all(|lobe| *lobe < 1.0 + 1e-12), "{count}: {found:?}");
    }
}

#[test]
fn m_sequences_have_the_autocorrelation_of_the_greatest_period() {
    for register in 2..=16 {
        let chips = code(Code::MSequence { register });
        let period = (1 << register) - 1;
        assert_eq!(chips.len(), period);
        // Balanced by one: -1 once more than +1.
        assert!((chips.iter().sum::<Complex64>() + 1.0).norm() < 1e-9, "{register}");
        for lag in [1, 2, 3, period / 2, period - 1].into_iter().filter(|lag| lag % period != 0) {
            let sum: Complex64 = (0..period).map(|k| chips[k] * chips[(k + lag) % period].conj()).sum();
            assert!((sum + 1.0).norm() < 1e-9, "{register}, {lag}: {sum}");
        }
    }
}

#[test]
fn polyphase_codes_have_their_published_side_lobes() {
    // Frank: 1/sin(pi/M) chips where M is even (Levanon and Mozeson 2004, section 6.2).
    for phases in [4, 8, 16] {
        let expected = 1.0 / (PI / phases as f64).sin();
        let found = aperiodic(&code(Code::Frank { phases }))[1..].iter().copied().fold(0.0, f64::max);
        assert!((found - expected).abs() < 1e-9, "{phases}: {found} {expected}");
    }
    // P3 and P4: |sin(pi l^2/N)/sin(pi l/N)| at a lag of l chips, for (k + l)^2 - k^2 is linear in k.
    for chips in [2, 9, 64, 100, 401] {
        for of in [Code::P3 { chips }, Code::P4 { chips }] {
            for (lag, found) in aperiodic(&code(of)).into_iter().enumerate().skip(1) {
                let turns = |x: usize| (PI * (x % (2 * chips)) as f64 / chips as f64).sin();
                let expected = (turns(lag * lag) / turns(lag)).abs();
                assert!((found - expected).abs() < 1e-9, "{of:?}, {lag}: {found} {expected}");
            }
        }
    }
    // Ideal codes: no periodic side lobe at all.
    for of in [Code::Frank { phases: 6 }, Code::P3 { chips: 40 }, Code::P4 { chips: 40 }] {
        let chips = code(of);
        let n = chips.len();
        for lag in 1..n {
            let sum: Complex64 = (0..n).map(|k| chips[(k + lag) % n] * chips[k].conj()).sum();
            assert!(sum.norm() < 1e-9, "{of:?}, {lag}: {sum}");
        }
    }
}

/// `chi(tau, nu) = int p(t) conj(p(t - tau)) e^{j 2 pi nu t} dt` of a plain pulse:
/// `|(Tc - |tau|) sinc(nu (Tc - |tau|))|`; by the product of its spectra, as a matched filter takes it.
#[test]
fn the_ambiguity_of_a_plain_pulse() {
    let (pulse, duration_s) = (Coded::plain(1.0).unwrap(), 1.0);
    let (limit, count) = (2000.0, 400_000);
    let step = 2.0 * limit / f64::from(count);
    for (tau, nu) in [(0.0, 0.0), (0.3, 0.0), (-0.4, 1.2), (0.0, 2.5), (0.75, 0.8)] {
        let sum: Complex64 = (0..count)
            .map(|i| {
                let f = (f64::from(i) + 0.5) * step - limit;
                pulse.spectrum(f - nu) * pulse.spectrum(f).conj() * Complex64::cis(TAU * f * tau)
            })
            .sum();
        let overlap = duration_s - f64::abs(tau);
        let x = PI * nu * overlap;
        let expected = (overlap * if x == 0.0 { 1.0 } else { x.sin() / x }).abs();
        // What lies beyond the limit: 2/(pi^2 2 limit) of two edges.
        assert!(
            ((sum * step).norm() - expected).abs() < 2e-4,
            "{tau}, {nu}: {} {expected}",
            sum.norm() * step
        );
    }
}

#[test]
fn codes_that_do_not_exist_are_refused_by_name() {
    let refused = |code, chip_s| Coded::new(code, chip_s).unwrap_err().to_string();
    assert_eq!(
        refused(Code::Barker { chips: 6 }, 1e-6),
        "a barker code of 6 chips does not exist: 2, 3, 4, 5, 7, 11 or 13"
    );
    assert!(refused(Code::Frank { phases: 1 }, 1e-6).contains("a square of 4 to 65536"));
    assert!(refused(Code::P3 { chips: 1 }, 1e-6).contains("2 to 65536"));
    assert!(refused(Code::P4 { chips: 65_537 }, 1e-6).contains("2 to 65536"));
    for register in [0, 1, 17, 64, 200] {
        assert!(refused(Code::MSequence { register }, 1e-6).contains("2 to 16 stages"), "{register}");
    }
    assert!(refused(Code::P3 { chips: 9 }, 0.0).contains("chip length 0 s is not allowed"));
    assert!(Coded::plain(f64::NAN).unwrap_err().to_string().contains("pulse length NaN s"));
}
