//! The front end of a receiver against closed forms: image of the imbalance, offset, sensitivity time
//! control, blanking, jitter of the sampling clock.

use std::f64::consts::TAU;
use std::sync::Arc;

use nereus::pulse::{Pulse, SampleFormat};
use nereus::radar::front_end::FrontEnd;
use nereus::radar::receiver::Receiver;
use nereus::radar::waveform::{Coded, InTurn, Waveform};
use nereus::scene::Radar;
use nereus::scene::front_end::{self, Jitter, Stc};
use nereus::scene::radar::{
    AntennaMount, Channel, Gate, Pattern, Pointing, Polarisation, Transmitter, Window,
};
use nereus::time::PulseTimes;
use num_complex::Complex64;

use crate::receiver_noise::{FS_HZ, cf32, radar, slot};

const N: usize = 4096;
const PULSE_S: f64 = 2e-6;

fn with(front_end: front_end::FrontEnd) -> Radar {
    Radar { front_end, ..radar(N, None, None) }
}

fn plain(pulse_s: f64) -> Coded {
    Coded::plain(pulse_s).unwrap()
}

/// Samples of a pulse whose spectrum is a tone of amplitude 1 in a bin, as a receiver has them.
fn tone(radar: &Radar, bin: usize, index: u64) -> Vec<Complex64> {
    received(radar, &plain(PULSE_S), bin, index)
}

/// The same of a radar that radiates this.
fn received(radar: &Radar, waveform: &dyn Waveform, bin: usize, index: u64) -> Vec<Complex64> {
    let receiver = Receiver::new(radar, 7, N, 1).with_front_end(FrontEnd::new(radar, 7, waveform));
    let mut spectrum = vec![Complex64::ZERO; N];
    // s_j = (fs/N) S e^{j 2 pi j k/N}.
    spectrum[bin] = Complex64::from(N as f64 / FS_HZ);
    let mut pulse: Pulse = slot(1, N, SampleFormat::Cf32);
    pulse.index = index;
    if let Gate::Fixed { start_s } = radar.window.gate {
        pulse.window_start_s = start_s;
    }
    receiver.receive(&mut spectrum, &mut pulse, &mut receiver.scratch());
    cf32(&pulse).iter().map(|s| Complex64::new(f64::from(s.re), f64::from(s.im))).collect()
}

/// Amplitude of a bin of samples.
fn at(samples: &[Complex64], bin: i64) -> Complex64 {
    let turned =
        |(j, s): (usize, &Complex64)| s * Complex64::cis(-TAU * (bin as f64 * j as f64 / N as f64).fract());
    samples.iter().enumerate().map(turned).sum::<Complex64>() / N as f64
}

/// `(r + 1/r + 2 cos phi)/(r + 1/r - 2 cos phi)`, what I/Q imbalance leaves of a tone over its image, to the
/// rounding of f32 samples (1e-7 of the tone); and the offset is where it is asked.
#[test]
fn images_and_offsets_are_those_of_the_closed_form() {
    for (gain_db, phase_deg) in [(1.0, 5.0), (-0.5, 2.0), (0.0, -3.0), (0.2, 0.0)] {
        let offset = [3e-3, -4e-3];
        let errors = front_end::FrontEnd {
            iq_gain_db: gain_db,
            iq_phase_rad: f64::to_radians(phase_deg),
            offset,
            ..Default::default()
        };
        let samples = tone(&with(errors), 300, 0);
        let [own, image, constant] = [300, -300, 0].map(|bin| at(&samples, bin));
        let (r, cos) = (10f64.powf(gain_db / 20.0), f64::to_radians(phase_deg).cos());
        let wanted_db = 10.0 * ((r + 1.0 / r + 2.0 * cos) / (r + 1.0 / r - 2.0 * cos)).log10();
        let found_db = 20.0 * (own.norm() / image.norm()).log10();
        println!("{gain_db} dB, {phase_deg} deg: image {found_db:.3} dB below, closed form {wanted_db:.3}");
        assert!((found_db - wanted_db).abs() < 1e-3);
        assert!((constant - Complex64::new(offset[0], offset[1])).norm() < 1e-8, "{constant}");
        // I over Q of a real tone and of an imaginary one.
        let [i, q] = [Complex64::ONE, Complex64::I].map(|s| {
            let [alpha, beta] = nereus::radar::front_end::imbalance(gain_db, f64::to_radians(phase_deg));
            alpha * s + beta * s.conj()
        });
        assert!((20.0 * (i.re / q.im).log10() - gain_db - 20.0 * (1.0 / cos).log10()).abs() < 1e-9);
        assert!(q.re.abs() < 1e-15);
    }
}

/// `g^2 = (t/T)^n` after the last emission, also of one within the window, and samples in pulses are blank.
#[test]
fn control_and_blanking_follow_the_emissions() {
    let stc = Stc { full_s: 30e-6, exponent: 4.0, depth_db: 50.0 };
    let errors = front_end::FrontEnd { stc: Some(stc), blanked_s: Some(0.5e-6), ..Default::default() };
    // A window of 41 us from 5 us on, and an emission every 25 us.
    let radar = Radar {
        emissions: PulseTimes::uniform(40e3).unwrap(),
        window: Window { samples: N, gate: Gate::Fixed { start_s: 5e-6 } },
        ..with(errors)
    };
    let samples = tone(&radar, 5, 3);
    let mut blank = 0;
    for (j, sample) in samples.iter().enumerate() {
        let t = 5e-6 + j as f64 / FS_HZ;
        let after_s = t % 25e-6;
        // Next to an edge rounding decides.
        if after_s < PULSE_S + 0.5e-6 - 1e-12 {
            blank += usize::from(sample.norm() == 0.0);
            continue;
        }
        let wanted = (after_s / 30e-6).powi(2).max(10f64.powf(-50.0 / 20.0)).min(1.0);
        if (after_s - PULSE_S - 0.5e-6).abs() > 1e-12 {
            assert!((sample.norm() / wanted - 1.0).abs() < 1e-6, "{t}: {} {wanted}", sample.norm());
        }
    }
    assert!((249..=251).contains(&blank), "{blank}");
}

/// A receiver on another platform hears its transmitter: only the radar's own receiver is blanked.
#[test]
fn receivers_elsewhere_are_not_blanked() {
    let mount = |platform: usize| AntennaMount {
        platform,
        lever_arm: nereus::frames::Vector::ZERO,
        of_array: nereus::frames::Vector::ZERO,
        pattern: Pattern::Isotropic { gain_dbi: 0.0 },
        pointing: Pointing::Fixed { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 },
        ports: nereus::scene::radar::PortErrors::default(),
    };
    let errors = front_end::FrontEnd { blanked_s: Some(0.0), ..Default::default() };
    let heard = |receiver: usize| {
        let mut radar = with(errors);
        radar.transmitters = vec![Transmitter { name: "tx".into(), power_w: 1.0, antenna: mount(0) }];
        let rx = |name: &str, platform| nereus::scene::radar::Receiver {
            name: name.into(),
            antenna: mount(platform),
            gate: None,
        };
        radar.receivers = vec![rx("own", 0), rx("other", 1)];
        let polarisation = Polarisation::H;
        radar.channels =
            vec![Channel { name: "HH".into(), transmitter: 0, receiver, rx: polarisation, tx: polarisation }];
        tone(&radar, 5, 0)[10].norm()
    };
    assert!(heard(0) == 0.0 && (heard(1) - 1.0).abs() < 1e-6);
}

/// A tone at `f` keeps `-20 log10(2 pi |f + f_IF| sigma)` of signal to noise: over 8 pulses of 4096 samples,
/// within 0.1 dB (a deviation is 0.025 dB).
#[test]
fn jitter_has_the_noise_floor_of_its_tone() {
    for (bin, intermediate_hz, rms_s) in [(900, 0.0, 2e-12), (-1300, 0.0, 5e-12), (200, 140e6, 1e-12)] {
        let errors =
            front_end::FrontEnd { jitter: Some(Jitter { rms_s, intermediate_hz }), ..Default::default() };
        let radar = with(errors);
        let place = (bin as i64).rem_euclid(N as i64) as usize;
        let (mut noise, mut signal) = (0.0, 0.0);
        for index in 0..8 {
            let samples = tone(&radar, place, index);
            for (j, sample) in samples.iter().enumerate() {
                let clean = Complex64::cis(TAU * (bin as f64 * j as f64 / N as f64).fract());
                noise += (sample - clean).norm_sqr();
                signal += clean.norm_sqr();
            }
        }
        let found_db = 10.0 * (signal / noise).log10();
        let f_hz = bin as f64 * FS_HZ / N as f64 + intermediate_hz;
        let wanted_db = -20.0 * (TAU * f_hz.abs() * rms_s).log10();
        println!("{f_hz:e} Hz, {rms_s:e} s: {found_db:.2} dB, closed form {wanted_db:.2}");
        assert!((found_db - wanted_db).abs() < 0.1);
        assert_eq!(tone(&radar, place, 5), tone(&radar, place, 5));
        assert_ne!(tone(&radar, place, 5), tone(&radar, place, 6));
    }
}

#[test]
fn an_ideal_front_end_is_none() {
    assert!(FrontEnd::new(&with(front_end::FrontEnd::default()), 1, &plain(PULSE_S)).is_none());
}

/// Of several pulses in turn each is blanked as long as it lasts.
#[test]
fn pulses_in_turn_are_blanked_by_their_own_lengths() {
    let errors = front_end::FrontEnd { blanked_s: Some(0.0), ..Default::default() };
    let radar = Radar {
        emissions: PulseTimes::uniform(10e3).unwrap(),
        window: Window { samples: N, gate: Gate::Fixed { start_s: 0.0 } },
        ..with(errors)
    };
    let lengths_s = [2e-6, 0.5e-6, 7e-6];
    let waveform = InTurn::new(lengths_s.iter().map(|s| Arc::new(plain(*s)) as Arc<dyn Waveform>).collect());
    for index in 0..6 {
        let samples = received(&radar, &waveform, 5, index);
        let blank = samples.iter().take_while(|sample| sample.norm() == 0.0).count();
        let wanted = (lengths_s[index as usize % 3] * FS_HZ).ceil();
        assert!(
            (blank as f64 - wanted).abs() <= 1.0,
            "pulse {index}: {blank} samples, {wanted} of its length"
        );
    }
}
