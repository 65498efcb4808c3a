//! Spectra of one length from those of another.

use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex64;

use crate::radar::window::GUARD_SAMPLES;

/// Samples beyond either end of the window that are kept as they are; from there to the end of the guard they
/// fade out, so that what a clock shifts by a part of a sample rings nowhere in the window.
const KEPT_SAMPLES: usize = 8;

/// Brings the spectrum of a window and its guards, of which both transforms have room on either side, from
/// transforms of one length to those of another: equal samples in the window.
pub(crate) struct Refit {
    window_samples: usize,
    inverse: Arc<dyn Fft<f64>>,
    forward: Arc<dyn Fft<f64>>,
    from: Vec<Complex64>,
    to: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Refit {
    /// `None` where both are of the same length.
    pub fn new(window_samples: usize, from: usize, to: usize) -> Option<Self> {
        if from == to {
            return None;
        }
        let (inverse, forward) = (nereus_fft::inverse(from), nereus_fft::forward(to));
        let scratch = inverse.get_inplace_scratch_len().max(forward.get_inplace_scratch_len());
        let [from, to, scratch] = [from, to, scratch].map(|len| vec![Complex64::ZERO; len]);
        Some(Self { window_samples, inverse, forward, from, to, scratch })
    }

    /// The spectrum in the other length.
    pub fn refitted(&mut self, spectrum: &[Complex64]) -> &[Complex64] {
        let Self { window_samples, inverse, forward, from, to, scratch } = self;
        from.copy_from_slice(spectrum);
        inverse.process_with_scratch(from, scratch);
        to.fill(Complex64::ZERO);
        let scale = 1.0 / from.len() as f64;
        let guard = GUARD_SAMPLES as isize;
        for at in -guard..*window_samples as isize + guard {
            let [own, other] = [from.len(), to.len()].map(|len| at.rem_euclid(len as isize) as usize);
            let beyond = (-at).max(at + 1 - *window_samples as isize).max(0) as usize;
            to[other] = from[own] * (scale * fade(beyond));
        }
        forward.process_with_scratch(to, scratch);
        to
    }
}

/// What is left of a sample so many beyond the window.
pub(super) fn fade(beyond: usize) -> f64 {
    let of = beyond.saturating_sub(KEPT_SAMPLES) as f64 / (GUARD_SAMPLES - KEPT_SAMPLES) as f64;
    (0.5 * std::f64::consts::PI * of.min(1.0)).cos().powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_the_window_stay_what_they_are() {
        let (window, lens) = (100, [240, 180]);
        let wave = |j: isize| Complex64::cis(0.9 * j as f64) * (1.0 + 0.01 * j as f64);
        let guard = GUARD_SAMPLES as isize;
        let mut samples = vec![Complex64::ZERO; lens[0]];
        for at in -guard..window as isize + guard {
            samples[at.rem_euclid(lens[0] as isize) as usize] = wave(at);
        }
        nereus_fft::forward(lens[0]).process(&mut samples);
        let mut refit = Refit::new(window, lens[0], lens[1]).unwrap();
        let mut found = refit.refitted(&samples).to_vec();
        // A clock that is half a sample late.
        let mut late = found.clone();
        for (k, bin) in late.iter_mut().enumerate() {
            let f = if 2 * k < lens[1] { k as f64 } else { k as f64 - lens[1] as f64 } / lens[1] as f64;
            *bin *= Complex64::cis(-std::f64::consts::PI * f);
        }
        for spectrum in [&mut found, &mut late] {
            nereus_fft::inverse(lens[1]).process(spectrum);
        }
        for at in 0..window as isize {
            let [own, shifted] = [&found, &late].map(|samples| samples[at as usize] / lens[1] as f64);
            assert!((own - wave(at)).norm() < 1e-12, "{at}: {own}");
            let expected = Complex64::cis(0.9 * (at as f64 - 0.5)) * (1.0 + 0.01 * (at as f64 - 0.5));
            assert!((shifted - expected).norm() < 1e-3, "{at}: {shifted} {expected}");
        }
        assert!(Refit::new(window, 240, 240).is_none());
    }
}
