//! The converter: quantisation noise, saturation, one bit and sixteen.

use std::f64::consts::PI;

use nereus::pulse::{SampleFormat, Samples, flags};
use nereus::radar::receiver::Receiver;
use nereus::scene::radar::Adc;
use num_complex::Complex64;

use crate::receiver_noise::{FS_HZ, cf32, radar, slot};

const N: usize = 4096;

/// One tone of amplitude `amplitude`, in bin `k`: samples `amplitude e^{j 2 pi j k / N + j 0.3}`.
fn tone(k: usize, amplitude: f64) -> Vec<Complex64> {
    let mut spectrum = vec![Complex64::ZERO; N];
    spectrum[k] = Complex64::from_polar(amplitude * N as f64 / FS_HZ, 0.3);
    spectrum
}

fn codes(adc: Adc, spectrum: &[Complex64]) -> (Vec<[i16; 2]>, usize, u32) {
    let receiver = Receiver::new(&radar(N, None, Some(adc)), 0, N, 1);
    assert_eq!(receiver.sample_format(), SampleFormat::Ci16);
    let mut pulse = slot(1, N, SampleFormat::Ci16);
    pulse.flags = flags::OUTSIDE_WINDOW;
    let saturated = receiver.receive(&mut spectrum.to_vec(), &mut pulse, &mut receiver.scratch());
    assert_ne!(pulse.flags & flags::OUTSIDE_WINDOW, 0, "other flags stay");
    match pulse.samples {
        Samples::Ci16(codes) => (codes, saturated, pulse.flags & flags::ADC_SATURATED),
        Samples::Cf32(_) => panic!("floating-point samples from a converter"),
    }
}

/// Signal to quantisation noise, power ratio.
fn sqnr(adc: Adc, k: usize, amplitude: f64) -> f64 {
    let (codes, saturated, flag) = codes(adc, &tone(k, amplitude));
    assert_eq!((saturated, flag), (0, 0));
    let (mut signal, mut noise) = (0.0, 0.0);
    for (j, code) in codes.iter().enumerate() {
        let ideal = Complex64::from_polar(amplitude, 2.0 * PI * ((j * k) % N) as f64 / N as f64 + 0.3);
        let value = Complex64::new(f64::from(code[0]) + 0.5, f64::from(code[1]) + 0.5) * adc.step();
        signal += ideal.norm_sqr();
        noise += (value - ideal).norm_sqr();
    }
    signal / noise
}

#[test]
fn quantisation_noise_follows_the_number_of_bits() {
    let full_scale = 3.7e-6;
    for bits in [8, 10, 12, 14, 16] {
        for headroom_db in [0.5, 6.0, 20.0] {
            if bits == 8 && headroom_db > 6.0 {
                continue; // 25 steps: the error is no longer uniform.
            }
            let amplitude = full_scale * 10f64.powf(-headroom_db / 20.0);
            let db = 10.0 * sqnr(Adc { bits, full_scale }, 1237, amplitude).log10();
            let expected = 6.0206 * f64::from(bits) + 1.7609 - headroom_db;
            println!("{bits} bits, headroom {headroom_db} dB: {db:.2} dB, expected {expected:.2}");
            // Power of 8192 uniform errors: deviation sqrt(4/5/8192) = 1 %, five of them 0.21 dB. The error
            // of a sine also has a part that is not uniform, at its crests: sqrt(step/amplitude) of the
            // samples, up to 0.15 dB.
            assert!((db - expected).abs() < 0.21 + 0.15, "{bits}: {db} {expected}");
        }
    }
}

#[test]
fn one_bit_keeps_the_sign() {
    let full_scale = 1.0;
    // y = (A/2) sgn x: error power 3/4 - 2/pi of A^2 against 1/2, per part.
    let expected = 0.5 / (0.75 - 2.0 / PI);
    let got = sqnr(Adc { bits: 1, full_scale }, 1237, full_scale * (1.0 - 1e-9));
    println!("one bit: {:.3} dB, expected {:.3}", 10.0 * got.log10(), 10.0 * expected.log10());
    // 4096 equally spaced phases per part: the jump of sgn costs 1/4096 of the range.
    assert!((got / expected - 1.0).abs() < 2e-3, "{got} {expected}");
    let (codes, _, _) = codes(Adc { bits: 1, full_scale }, &tone(3, 0.5));
    assert!(codes.iter().flatten().all(|c| *c == 0 || *c == -1));
}

#[test]
fn saturation_is_held_counted_and_flagged() {
    for bits in [1, 4, 12, 16] {
        let adc = Adc { bits, full_scale: 1.0 };
        let (codes, saturated, flag) = codes(adc, &tone(1237, 2.0));
        let half = 1i32 << (bits - 1);
        assert!(codes.iter().flatten().all(|c| (-half..half).contains(&i32::from(*c))));
        assert!(codes.iter().flatten().any(|c| i32::from(*c) == half - 1));
        assert!(codes.iter().flatten().any(|c| i32::from(*c) == -half));
        assert_eq!(flag, flags::ADC_SATURATED);
        // |2 sin| > 1 for two thirds of the turn, of 8192 parts; one sample either side of each crossing.
        let expected = 8192.0 * 2.0 / 3.0;
        assert!((saturated as f64 - expected).abs() <= 8.0, "{saturated}");
    }
}

#[test]
fn flag_is_cleared_on_the_next_pulse() {
    let adc = Adc { bits: 8, full_scale: 1.0 };
    let receiver = Receiver::new(&radar(N, None, Some(adc)), 0, N, 1);
    let mut pulse = slot(1, N, SampleFormat::Ci16);
    let mut scratch = receiver.scratch();
    assert!(receiver.receive(&mut tone(5, 9.0), &mut pulse, &mut scratch) > 0);
    assert_ne!(pulse.flags & flags::ADC_SATURATED, 0);
    assert_eq!(receiver.receive(&mut tone(5, 0.9), &mut pulse, &mut scratch), 0);
    assert_eq!(pulse.flags & flags::ADC_SATURATED, 0);
    // Silence is code 0: mid-rise has no zero, its value is half a step.
    receiver.receive(&mut vec![Complex64::ZERO; N], &mut pulse, &mut scratch);
    assert_eq!(pulse.samples, Samples::Ci16(vec![[0, 0]; N]));
}

#[test]
fn a_slot_of_another_format_is_replaced() {
    let adc = Adc { bits: 8, full_scale: 1.0 };
    let receiver = Receiver::new(&radar(N, None, Some(adc)), 0, N, 1);
    let mut pulse = slot(1, 3, SampleFormat::Cf32);
    receiver.receive(&mut tone(5, 0.9), &mut pulse, &mut receiver.scratch());
    assert!(matches!(&pulse.samples, Samples::Ci16(codes) if codes.len() == N));
    let receiver = Receiver::new(&radar(N, None, None), 0, N, 1);
    receiver.receive(&mut tone(5, 0.9), &mut pulse, &mut receiver.scratch());
    assert_eq!(cf32(&pulse).len(), N);
}
