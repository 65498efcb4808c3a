//! Nonlinear sweeps: their spectra by quadrature, their frequency by its law, their side lobes by their
//! taper.

use std::f64::consts::{PI, TAU};

use nereus::radar::waveform::{Nlfm, Waveform};
use nereus::scene::radar::{Sweep, Taper};
use num_complex::Complex64;

use crate::quadrature::unit_interval;

const TAPERS: [Taper; 4] = [
    Taper::Hamming,
    Taper::Taylor { sidelobe_db: 20.0 },
    Taper::Taylor { sidelobe_db: 35.0 },
    Taper::Taylor { sidelobe_db: 60.0 },
];

/// Straight from the definition; near an edge frequency runs fast, so panels are short.
fn integral(pulse: &Nlfm, f_hz: f64) -> Complex64 {
    let turns = pulse.bandwidth_hz() * pulse.duration_s() + (f_hz * pulse.duration_s()).abs();
    let duration_s = pulse.duration_s();
    unit_interval(64 + (8.0 * turns) as usize, |y| {
        pulse.sample(y * duration_s) * Complex64::cis(-TAU * (f_hz * duration_s * y).fract())
    }) * duration_s
}

#[test]
fn spectra_agree_with_quadrature_within_the_band_and_far_from_it() {
    let mut worst = (0.0f64, 0.0, 0.0);
    for taper in TAPERS {
        for product in [4.0, 9.3, 60.0, 500.0] {
            for (duration_s, sweep) in [(1.3e-6, Sweep::Up), (0.02, Sweep::Down)] {
                let bandwidth_hz = product / duration_s;
                let pulse = Nlfm::new(bandwidth_hz, duration_s, sweep, taper).unwrap();
                let peak_s = (duration_s / bandwidth_hz).sqrt();
                // Quadrature of a long pulse far from its band takes long.
                let most = if product > 100.0 { 1.5 } else { 12.0 };
                let shares = [0.0, 0.01, 0.2, 0.45, 0.499, 0.5, 0.51, 0.8, 0.99, 1.01, 1.4, 2.3, 5.0, 11.0];
                for share in shares.into_iter().filter(|share| *share < most) {
                    for f_hz in [share * bandwidth_hz, -share * bandwidth_hz] {
                        let error = (pulse.spectrum(f_hz) - integral(&pulse, f_hz)).norm() / peak_s;
                        if error > worst.0 {
                            worst = (error, product, share);
                        }
                        assert!(error < 1e-10, "{taper:?}, B Tc {product}, f/B {share}: {error:.1e}");
                    }
                }
            }
        }
    }
    println!("worst error of a nonlinear sweep: {:.1e} at B Tc {} and f/B {}", worst.0, worst.1, worst.2);
}

/// Frequency by time is the inverse of the integral of the taper.
#[test]
fn a_sweep_dwells_as_its_taper_says() {
    let (bandwidth_hz, duration_s) = (20e6, 10e-6);
    let pulse = Nlfm::new(bandwidth_hz, duration_s, Sweep::Up, Taper::Hamming).unwrap();
    let falls = Nlfm::new(bandwidth_hz, duration_s, Sweep::Down, Taper::Hamming).unwrap();
    for x in [-0.49, -0.3, -0.02, 0.1, 0.25, 0.44] {
        // int of (0.54 + 0.46 cos 2 pi x)/0.54 from 0 on.
        let y = x + 0.46 / 0.54 * (TAU * x).sin() / TAU;
        let (t_s, h_s) = ((y + 0.5) * duration_s, 1e-6 * duration_s);
        let turn = (pulse.sample(t_s + h_s) * pulse.sample(t_s - h_s).conj()).arg() / TAU / (2.0 * h_s);
        assert!((turn - x * bandwidth_hz).abs() < 1e-6 * bandwidth_hz, "{x}: {turn}");
        assert!((falls.sample(t_s) - pulse.sample(t_s).conj()).norm() < 1e-15);
        assert!((pulse.sample(t_s).norm() - 1.0).abs() < 1e-15);
    }
    assert!((pulse.sample(0.5 * duration_s) - 1.0).norm() < 1e-12);
    assert_eq!(pulse.sample(duration_s), Complex64::ZERO);
    assert_eq!(pulse.sample(-1e-18), Complex64::ZERO);
}

/// Side lobes of the compressed pulse, outside of the main lobe, dB.
fn sidelobe_db(pulse: &Nlfm) -> f64 {
    let (bandwidth_hz, duration_s) = (pulse.bandwidth_hz(), pulse.duration_s());
    let count = (32.0 * bandwidth_hz * duration_s) as usize;
    let step_hz = 8.0 * bandwidth_hz / count as f64;
    let density: Vec<f64> = (0..count)
        .map(|k| pulse.spectrum((k as f64 + 0.5) * step_hz - 4.0 * bandwidth_hz).norm_sqr())
        .collect();
    let at = |t_s: f64| {
        let of =
            |(k, d): (usize, &f64)| d * (TAU * ((k as f64 + 0.5) * step_hz - 4.0 * bandwidth_hz) * t_s).cos();
        density.iter().enumerate().map(of).sum::<f64>().abs()
    };
    let grid: Vec<f64> = (0..240).map(|i| at(f64::from(i) * 0.1 / bandwidth_hz)).collect();
    let null = (1..grid.len() - 1).find(|i| grid[i + 1] > grid[*i]).unwrap();
    20.0 * (grid[null..].iter().copied().fold(0.0, f64::max) / grid[0]).log10()
}

#[test]
fn side_lobes_are_those_of_the_taper() {
    for (taper, expected_db, within_db) in [
        (Taper::Taylor { sidelobe_db: 25.0 }, -25.0, 1.0),
        (Taper::Taylor { sidelobe_db: 35.0 }, -35.0, 1.5),
        (Taper::Hamming, -42.7, 3.0),
    ] {
        let found: Vec<f64> = [30.0, 100.0, 1000.0]
            .map(|product| sidelobe_db(&Nlfm::new(product, 1.0, Sweep::Up, taper).unwrap()))
            .to_vec();
        println!("{taper:?}: {found:.1?} dB at B Tc = 30, 100, 1000");
        assert!((found[2] - expected_db).abs() < within_db, "{taper:?}: {found:?}");
    }
}

#[test]
fn a_long_sweep_is_made_in_little_time() {
    let begun = std::time::Instant::now();
    let pulse = Nlfm::new(20e6, 1e-3, Sweep::Up, Taper::Taylor { sidelobe_db: 40.0 }).unwrap();
    println!("B Tc = 20000: {:.2} s", begun.elapsed().as_secs_f64());
    // Parseval over the band; 1/(2 pi^2 F) of the energy is beyond F at either edge.
    let (count, limit_hz) = (2_000_000, 100e6);
    let step_hz = 2.0 * limit_hz / f64::from(count);
    let energy: f64 =
        (0..count).map(|i| pulse.spectrum((f64::from(i) + 0.5) * step_hz - limit_hz).norm_sqr()).sum();
    let beyond_s = 1.0 / (PI * PI * limit_hz);
    assert!((energy * step_hz + beyond_s - 1e-3).abs() < 0.05 * beyond_s, "{}", energy * step_hz - 1e-3);
}

#[test]
fn odd_sweeps_are_refused_by_name() {
    let refused = |b, t, taper| Nlfm::new(b, t, Sweep::Up, taper).unwrap_err().to_string();
    assert_eq!(
        refused(1e6, 3e-6, Taper::Hamming),
        "time-bandwidth product 3 of a nonlinear sweep is not allowed: 4 to 20000"
    );
    assert!(refused(1e9, 1e-3, Taper::Hamming).contains("product 1000000 "));
    assert!(refused(0.0, 1e-3, Taper::Hamming).contains("bandwidth 0 Hz"));
    assert!(refused(1e6, f64::NAN, Taper::Hamming).contains("pulse length NaN"));
    let found = refused(1e6, 1e-4, Taper::Taylor { sidelobe_db: 90.0 });
    assert_eq!(found, "side lobes of 90 dB are not allowed: 20 to 60 dB below the peak");
}
