//! An independent matched filter: correlates samples with the recorded replica at any real delay.

use num_complex::{Complex32, Complex64};

/// What a matched filter measures of one echo.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Delay of the peak after the first sample, s.
    pub delay_s: f64,
    /// Complex amplitude of the echo at the peak.
    pub amplitude: Complex64,
}

/// Finds the echo of a replica (which starts at its first sample) in one channel. `doppler_hz` is put
/// on the replica first, so that a linear sweep is not shifted by its range-Doppler coupling.
pub fn peak(samples: &[Complex32], replica: &[Complex32], rate_hz: f64, doppler_hz: f64) -> Peak {
    let len = (samples.len() + replica.len()).next_power_of_two();
    let padded = |x: &mut dyn Iterator<Item = Complex64>| {
        let mut v: Vec<Complex64> = x.collect();
        v.resize(len, Complex64::ZERO);
        nereus_fft::forward(len).process(&mut v);
        v
    };
    let s = padded(&mut samples.iter().map(|z| Complex64::new(z.re.into(), z.im.into())));
    let q = padded(&mut replica.iter().enumerate().map(|(j, z)| {
        Complex64::new(z.re.into(), z.im.into())
            * Complex64::cis(std::f64::consts::TAU * doppler_hz * j as f64 / rate_hz)
    }));
    let energy: f64 = q.iter().map(|z| z.norm_sqr()).sum();
    let correlation = |delay_cells: f64| -> Complex64 {
        let sum: Complex64 = (0..len)
            .map(|k| {
                let f = if k < len / 2 { k as f64 } else { k as f64 - len as f64 } / len as f64;
                s[k] * q[k].conj() * Complex64::cis(std::f64::consts::TAU * f * delay_cells)
            })
            .sum();
        sum / energy
    };
    let mut best = (0..4 * samples.len())
        .map(|i| i as f64 / 4.0)
        .max_by(|a, b| correlation(*a).norm().total_cmp(&correlation(*b).norm()))
        .unwrap();
    // Golden-section search: the main lobe is several cells wide.
    let (mut lo, mut hi) = (best - 0.5, best + 0.5);
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..60 {
        let (a, b) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
        if correlation(a).norm() > correlation(b).norm() {
            hi = b;
        } else {
            lo = a;
        }
    }
    best = 0.5 * (lo + hi);
    Peak { delay_s: best / rate_hz, amplitude: correlation(best) }
}
