//! FM broadcast: a stereo multiplex of random programme.
//!
//! ```text
//! s(t) = exp(j 2 pi D int m dt) ,   |m| <= 1
//! m(t) = M(t) + S(t) sin 2 pi 38 kHz t + 0.09 sin 2 pi 19 kHz t                     (ITU-R BS.450, pilot tone)
//! M + S sin = sum_i w(t - i T/2) g_i x_i(t) ,   w = sin^2(pi t/T)   0 <= t < T = 40 ms
//! ```
//!
//! `D` greatest deviation, Hz. A slot `x_i` is a sum of tones at multiples of 25 Hz: sum and difference of
//! two channels, 50 Hz to 15 kHz, of complex Gaussian amplitudes that fall by 3 dB an octave (pink) and rise
//! by the pre-emphasis of 50 us; the difference is 6 dB weaker. `g_i` makes its peak 0.91 at most, lower by 0
//! to 12 dB that are drawn every half second.
//!
//! All tones are whole numbers of cycles of a slot, 2 and more. So the integral of one under `w` is 0, and
//! the phase at any sample is that of the pilot and of the two slots that it lies in: nothing adds up from
//! the beginning, and any sample is found by its number, exactly. `w` and the next one add to 1: `|m| <= 1`.
//!
//! The rate is Carson's bandwidth `2 (D + 53 kHz)` over 0.83: the interpolation (`shaping`) is flat over it.

use std::f64::consts::TAU;
use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex64;
use rand::Rng;

use super::WaveformError;
use super::noise::complex_normal;
use super::stream::Signal;
use crate::radar::phasor::phasor;
use crate::rng::{Room, stream};
use crate::scene::radar::Fm;

/// Audio, pilot and subcarrier, cycles a slot.
const AUDIO: std::ops::RangeInclusive<usize> = 2..=600;
const PILOT: f64 = 760.0;
const SUBCARRIER: usize = 1520;
/// Of the greatest deviation.
const OF_PILOT: f64 = 0.09;
/// Time constant of the pre-emphasis, s.
const EMPHASIS_S: f64 = 50e-6;
/// Amplitude of the difference of two channels over their sum.
const DIFFERENCE: f64 = 0.5;
/// Slots of a level, and how far levels lie apart, dB.
const OF_LEVEL: u64 = 25;
const LEVELS_DB: f64 = 12.0;
/// Parts of the stream of random numbers: noise, television and satellites have others.
const PARTS: [u64; 2] = [2, 3];

/// An FM broadcast.
pub struct Broadcast {
    of: Fm,
    seed: u64,
    inverse: Arc<dyn Fft<f64>>,
}

impl Broadcast {
    /// Of a deviation, with a programme of a seed.
    pub fn new(of: Fm, seed: u64) -> Self {
        Self { of, seed, inverse: nereus_fft::inverse(of.samples()) }
    }

    /// Tones of a slot, by their cycles.
    fn tones(&self, slot: u64) -> Vec<Complex64> {
        let mut numbers = stream(self.seed, Room::Waveform, slot, PARTS[0]);
        let mut normal = || complex_normal(&mut numbers, 1.0);
        let mut tones = vec![Complex64::ZERO; SUBCARRIER + AUDIO.end() + 2];
        for n in AUDIO {
            let turns = TAU * n as f64 / Fm::SLOT_S * EMPHASIS_S;
            let amplitude = ((1.0 + turns * turns) / n as f64).sqrt();
            tones[n] = normal() * amplitude;
            // sin a times the real part of S e^jb.
            let difference = normal() * (0.5 * DIFFERENCE * amplitude);
            tones[SUBCARRIER + n] = -Complex64::I * difference;
            tones[SUBCARRIER - n] = -Complex64::I * difference.conj();
        }
        tones
    }

    /// What a slot adds to the phase, at its samples, turns: the integral of its deviation from its begin on.
    fn turns(&self, slot: u64) -> Vec<f64> {
        let (samples, tones) = (self.of.samples(), self.tones(slot));
        // The programme is the real part, the integral of what the window leaves of it the imaginary one.
        let mut values = vec![Complex64::ZERO; samples];
        for k in 1..tones.len() {
            let next = tones.get(k + 1).copied().unwrap_or_default();
            let windowed = 0.5 * tones[k] - 0.25 * (tones[k - 1] + next);
            let integral = windowed * Fm::SLOT_S / (Complex64::I * TAU * k as f64);
            values[k] = 0.5 * (tones[k] + Complex64::I * integral);
            values[samples - k] = 0.5 * (tones[k].conj() + Complex64::I * integral.conj());
        }
        self.inverse.process(&mut values);
        let peak = values.iter().map(|value| value.re.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let mut levels = stream(self.seed, Room::Waveform, slot / OF_LEVEL, PARTS[1]);
        let level_db = -LEVELS_DB * f64::from(levels.next_u32()) / 2f64.powi(32);
        let scale = self.of.deviation_hz * (1.0 - OF_PILOT) * 10f64.powf(level_db / 20.0) / peak;
        let begins = values[0].im;
        values.iter().map(|value| scale * (value.im - begins)).collect()
    }
}

impl Signal for Broadcast {
    fn name(&self) -> &str {
        "fm"
    }

    fn rate_hz(&self) -> f64 {
        self.of.rate_hz()
    }

    fn bandwidth_hz(&self) -> f64 {
        self.of.occupied_hz()
    }

    fn fill(&self, first: u64, out: &mut [Complex64]) -> Result<(), WaveformError> {
        let hop = self.of.samples() / 2;
        let (mut number, mut from) = (first / hop as u64, (first % hop as u64) as usize);
        let (mut rest, mut ending) = (out, self.turns(number));
        let of_pilot = -self.of.deviation_hz * OF_PILOT * Fm::SLOT_S / (TAU * PILOT);
        let per_sample = PILOT / self.of.samples() as f64;
        while !rest.is_empty() {
            // The second half of one slot, and the first of the next.
            let begun = self.turns(number + 1);
            let (now, later) = rest.split_at_mut((hop - from).min(rest.len()));
            for (sample, place) in now.iter_mut().zip(from..) {
                // The pilot has whole cycles in half of a slot, too.
                let pilot = of_pilot * phasor(per_sample * place as f64).re;
                *sample = phasor(ending[hop + place] + begun[place] + pilot);
            }
            (number, from, ending, rest) = (number + 1, 0, begun, later);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broadcast(deviation_hz: f64) -> Broadcast {
        Broadcast::new(Fm { deviation_hz }, 5)
    }

    /// Deviations from sample to sample, Hz.
    fn deviations(samples: &[Complex64], rate_hz: f64) -> Vec<f64> {
        samples.windows(2).map(|pair| (pair[1] * pair[0].conj()).arg() * rate_hz / TAU).collect()
    }

    /// Amplitudes of the tones of some samples, by their cycles in these.
    fn amplitudes(values: &[f64]) -> Vec<f64> {
        let mut bins: Vec<Complex64> = values.iter().map(|value| Complex64::from(*value)).collect();
        nereus_fft::forward(bins.len()).process(&mut bins);
        bins.iter().map(|bin| 2.0 * bin.norm() / values.len() as f64).collect()
    }

    /// No deviation is above the greatest, also where slots meet; the pilot has 9 % of it, the subcarrier
    /// none.
    #[test]
    fn the_multiplex_is_that_of_stereo() {
        for deviation_hz in [75e3, 50e3] {
            let own = broadcast(deviation_hz);
            let rate_hz = own.rate_hz();
            // Half a second, from within a slot on.
            let count = (rate_hz / 2.0) as usize;
            let mut samples = vec![Complex64::ZERO; count + 1];
            own.fill((1 << 40) + 777, &mut samples).unwrap();
            assert!(samples.iter().all(|sample| (sample.norm() - 1.0).abs() < 1e-12));
            let found = deviations(&samples, rate_hz);
            let most = found.iter().map(|hz| hz.abs()).fold(0.0, f64::max);
            // The mean over a sample is below the peak.
            assert!(most < deviation_hz && most > 0.15 * deviation_hz, "{most}");
            // A cycle is 2 Hz.
            let tones = amplitudes(&found);
            let at = |f_hz: f64| tones[(f_hz / 2.0) as usize] / deviation_hz;
            let x = std::f64::consts::PI * 19e3 / rate_hz;
            let pilot = at(19e3) / (x.sin() / x);
            assert!((pilot - 0.09).abs() < 3e-4, "{pilot}");
            let between = [17e3, 21e3, 56e3, 60e3].map(at);
            assert!(between.iter().all(|left| *left < 1e-3), "{between:?}");
            assert!(at(38e3) < 0.01, "{}", at(38e3));
            let power = |from_hz: f64, to_hz: f64| -> f64 {
                tones[(from_hz / 2.0) as usize..(to_hz / 2.0) as usize].iter().map(|tone| tone * tone).sum()
            };
            let ratio_db = 10.0 * (power(22e3, 54e3) / power(10.0, 16e3)).log10();
            // Half of a quarter of the power: the subcarrier is suppressed.
            assert!((ratio_db + 9.0).abs() < 1.5, "{ratio_db}");
        }
    }

    /// Carson's band holds 99 % and more, and nearly all lies where an interpolation is flat.
    #[test]
    fn the_band_is_carsons() {
        let own = broadcast(75e3);
        let (rate_hz, carson_hz) = (own.rate_hz(), own.bandwidth_hz());
        assert_eq!((rate_hz, carson_hz), (312_500.0, 256e3));
        let count = 312_500;
        let mut values = vec![Complex64::ZERO; count];
        own.fill(3 << 33, &mut values).unwrap();
        nereus_fft::forward(count).process(&mut values);
        let within = |half_hz: f64| {
            let of = |(k, value): (usize, &Complex64)| {
                let f_hz = k.min(count - k) as f64;
                if f_hz <= half_hz { value.norm_sqr() } else { 0.0 }
            };
            values.iter().enumerate().map(of).sum::<f64>() / (count as f64).powi(2)
        };
        let narrow = (1..).map(|n| 1e3 * f64::from(n)).find(|half_hz| within(*half_hz) >= 0.99).unwrap();
        println!("99 % within +-{narrow} Hz; beyond Carson's {:.1e}", 1.0 - within(0.5 * carson_hz));
        assert!(within(0.5 * carson_hz) > 0.9999, "{}", within(0.5 * carson_hz));
        assert!((20e3..100e3).contains(&narrow), "{narrow}");
    }

    #[test]
    fn parts_are_those_of_the_whole() {
        let own = broadcast(75e3);
        let mut all = vec![Complex64::ZERO; 40_000];
        own.fill(1 << 40, &mut all).unwrap();
        let mut part = vec![Complex64::ZERO; 20_000];
        broadcast(75e3).fill((1 << 40) + 12_345, &mut part).unwrap();
        assert_eq!(part, all[12_345..32_345]);
    }
}
