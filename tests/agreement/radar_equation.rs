//! A target's echo, range-compressed, against the radar equation and exact light time, both written
//! here from the equations.

use std::f64::consts::{PI, TAU};

use nereus::pulse::Samples;
use nereus::units::{Decibels, SPEED_OF_LIGHT_MPS as C};
use num_complex::Complex64;

use crate::matched_filter;
use crate::scenes::{self, CARRIER_HZ, End, GAIN_DBI, POWER_W, RATE_HZ};

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Exact light time of straight movers, by bisection-free fixed point to convergence; and both ranges.
fn light_time(tx: End, target: End, rx: End, t_s: f64) -> (f64, f64, f64) {
    let from = tx.at(t_s);
    let mut leg1 = 0.0;
    for _ in 0..50 {
        leg1 = distance(target.at(t_s + leg1), from) / C;
    }
    let in_flight = target.at(t_s + leg1);
    let mut leg2 = 0.0;
    for _ in 0..50 {
        leg2 = distance(rx.at(t_s + leg1 + leg2), in_flight) / C;
    }
    (leg1 + leg2, leg1 * C, leg2 * C)
}

struct Case {
    name: &'static str,
    tx: End,
    rx: End,
    target: End,
    prf_hz: f64,
    pulse: u64,
    samples: usize,
}

#[test]
fn the_compressed_peak_is_where_the_radar_equation_puts_it() {
    let still = |position_m| End { position_m, velocity_mps: [0.0; 3] };
    let cases = [
        Case {
            name: "static",
            tx: still([0.0, -3000.0, 15.0]),
            rx: still([-250.0, -3000.0, 3000.0]),
            target: still([30.0, 40.0, 0.7]),
            prf_hz: 222.0,
            pulse: 3,
            samples: 1024,
        },
        Case {
            name: "moving",
            tx: still([0.0, -3000.0, 15.0]),
            rx: End { position_m: [-250.0, -3000.0, 3000.0], velocity_mps: [222.0, 10.0, -3.0] },
            target: End { position_m: [400.0, 900.0, 2.0], velocity_mps: [-14.0, -9.0, 0.3] },
            prf_hz: 222.0,
            pulse: 499,
            samples: 2048,
        },
        Case {
            // 800 km up: three pulses in the air at once.
            name: "spaceborne",
            tx: End { position_m: [-3750.0, -500e3, 800e3], velocity_mps: [7500.0, 0.0, 0.0] },
            rx: End { position_m: [1200.0, -490e3, 800e3], velocity_mps: [7480.0, 15.0, 2.0] },
            target: End { position_m: [120.0, -80.0, 1.0], velocity_mps: [8.0, -6.0, 0.0] },
            prf_hz: 500.0,
            pulse: 20,
            samples: 1024,
        },
    ];
    for case in cases {
        let rcs_m2 = 120.0;
        let t_s = case.pulse as f64 / case.prf_hz;
        let (tau, range_t, range_r) = light_time(case.tx, case.target, case.rx, t_s);
        let step = 1e-4;
        let rate = (light_time(case.tx, case.target, case.rx, t_s + step).0
            - light_time(case.tx, case.target, case.rx, t_s - step).0)
            / (2.0 * step);
        // The window opens somewhere before the echo, on no grid.
        let window_start_s = tau - 3.33e-6 - 1.234_567e-9;
        let scene = scenes::scene(
            window_start_s,
            case.samples,
            case.prf_hz,
            case.pulse + 1,
            &[(case.target, rcs_m2)],
        );
        let factory =
            nereus::pipeline::factory::factory(&scene, scenes::tracks(&scene, case.tx, case.rx)).unwrap();
        let mut worker = factory.worker();
        let mut pulse = factory.slot();
        worker.make(case.pulse, &mut pulse).unwrap();

        let replica = factory.replica();
        let Samples::Cf32(iq) = &pulse.samples else { panic!("float samples expected") };
        let gain = Decibels(GAIN_DBI).power_ratio();
        let wavelength = C / CARRIER_HZ;
        let power = POWER_W * gain * gain * wavelength.powi(2) * rcs_m2
            / ((4.0 * PI).powi(3) * range_t.powi(2) * range_r.powi(2) * Decibels(3.0).power_ratio());
        for channel in 0..2 {
            let samples = &iq[channel * case.samples..][..case.samples];
            let peak = matched_filter::peak(samples, &replica, RATE_HZ, -CARRIER_HZ * rate);
            let delay = window_start_s + peak.delay_s;
            let expected_phase = -TAU * (CARRIER_HZ * tau).fract();
            // HH and VV of a sphere are equal where the bistatic angle is small; in amplitude the
            // projections of the antennas' axes on the wave front come in: taken from truth-free geometry.
            let projection = scenes::polarisation_factor(
                &case.tx.at(t_s),
                &case.target.at(t_s + range_t / C),
                &case.rx.at(t_s + tau),
                channel,
            );
            let expected = Complex64::cis(expected_phase) * power.sqrt() * projection;
            let level_db = 20.0 * (peak.amplitude.norm() / expected.norm()).log10();
            let phase = (peak.amplitude / expected).arg();
            println!(
                "{} channel {channel}: delay error {:.3e} s, level {level_db:.2e} dB, phase {phase:.2e} rad",
                case.name,
                delay - tau
            );
            // The recorded replica holds the samples of the pulse itself; the ringing of the receive filter
            // that is cut moves the peak by the order of 1e-3 sample. A hundredth of a sample is 1/170 of
            // 1/B.
            assert!((delay - tau).abs() < 1e-2 / RATE_HZ, "{}: {delay} for {tau}", case.name);
            assert!(level_db.abs() <= 0.01, "{}: {level_db} dB", case.name);
            assert!(phase.abs() <= 1e-3, "{}: {phase} rad", case.name);
        }
    }
}
