//! White noise of a bandwidth, complex Gaussian.
//!
//! Samples at the rate `B` without relation to each other: the power spectrum is `|H(f/B)|^2`
//! (`shaping`), flat within 0.83 `B`, a quarter at either edge of `B`, -100 dB from 1.17 `B` on.

use num_complex::Complex64;
use rand::Rng;

use super::WaveformError;
use super::shaping::white_power;
use super::stream::Signal;
use crate::radar::phasor::phasor;
use crate::rng::{Room, stream};

/// 32-bit words of the generator that a sample takes.
const WORDS: u128 = 4;

/// Noise of a seed.
#[derive(Clone, Debug)]
pub struct Noise {
    bandwidth_hz: f64,
    seed: u64,
}

impl Noise {
    /// Of a bandwidth above 0, Hz.
    pub fn new(bandwidth_hz: f64, seed: u64) -> Self {
        Self { bandwidth_hz, seed }
    }
}

impl Signal for Noise {
    fn name(&self) -> &str {
        "noise"
    }

    fn rate_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn bandwidth_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn fill(&self, first: u64, out: &mut [Complex64]) -> Result<(), WaveformError> {
        let mut numbers = stream(self.seed, Room::Waveform, 0, 0);
        numbers.set_word_pos(WORDS * u128::from(first));
        let scale = white_power().recip();
        out.iter_mut().for_each(|sample| *sample = complex_normal(&mut numbers, scale));
        Ok(())
    }
}

/// A complex Gaussian number of a mean power, of two 64-bit words.
pub(super) fn complex_normal(numbers: &mut impl Rng, power: f64) -> Complex64 {
    // Of (0, 1] and [0, 1).
    let [a, b] = [(); 2].map(|()| (numbers.next_u64() >> 11) as f64 * 2f64.powi(-53));
    phasor(b) * (-power * (1.0 - a).ln()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_depend_on_their_number_alone() {
        let noise = Noise::new(1e6, 7);
        let (mut all, mut part) = (vec![Complex64::ZERO; 100], vec![Complex64::ZERO; 40]);
        noise.fill(1 << 40, &mut all).unwrap();
        noise.fill((1 << 40) + 33, &mut part).unwrap();
        assert_eq!(part, all[33..73]);
    }
}
