//! The reference: from the equation, f64.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use super::{Aperture, points};
use crate::recording::ground::Ground;

/// The image, pixel by pixel from the [equation](super), row by row.
pub fn reference(aperture: &Aperture, ground: &Ground) -> Vec<Complex64> {
    let compressor = aperture.compressor;
    let spectra: Vec<Vec<Complex64>> = aperture
        .pulses
        .par_iter()
        .map(|pulse| {
            let doppler_hz = aperture.doppler_hz(pulse, aperture.centre_m);
            compressor.spectrum(pulse.samples, pulse.number, doppler_hz)
        })
        .collect();
    let all: Vec<[f64; 3]> = points(ground).collect();
    let last = (compressor.samples() - 1) as f64;
    all.par_iter()
        .map(|point| {
            let (mut sum, mut weights) = (Complex64::ZERO, 0.0);
            for (place, (pulse, spectrum)) in aperture.pulses.iter().zip(&spectra).enumerate() {
                let weight = aperture.weight(place, pulse, *point);
                weights += weight;
                if weight == 0.0 {
                    continue;
                }
                let tau_s = aperture.delay_s(pulse, *point);
                let lag = (tau_s - pulse.window_start_s) * compressor.sample_rate_hz();
                if (0.0..=last).contains(&lag) {
                    let turns = (aperture.carrier_hz * tau_s).fract();
                    sum += exact(spectrum, lag) * Complex64::cis(TAU * turns) * weight;
                }
            }
            if weights == 0.0 { Complex64::ZERO } else { sum / weights }
        })
        .collect()
}

/// `sum_k spectrum[k] e^{j 2 pi k lag / N}`, `k` from `-N/2`: a polynomial in `e^{j 2 pi lag / N}`.
fn exact(spectrum: &[Complex64], lag: f64) -> Complex64 {
    let half = spectrum.len() / 2;
    let turn = Complex64::cis(TAU * lag / spectrum.len() as f64);
    let ascending = spectrum[half..].iter().chain(&spectrum[..half]);
    let sum = ascending.rev().fold(Complex64::ZERO, |sum, bin| sum * turn + bin);
    sum * Complex64::cis(-0.5 * TAU * lag.rem_euclid(2.0))
}
