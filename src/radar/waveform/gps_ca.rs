//! The coarse code of a GPS satellite, C/A on L1, as IS-GPS-200 defines it.
//!
//! ```text
//! s(t) = A sum_k c_{k mod 1023} d_{floor(k / 20460)} p(t - k T) ,   T = 1/1.023 MHz
//! c = G1 xor G2 of a delay:   G1 = 1 + X^3 + X^10 ,   G2 = 1 + X^2 + X^3 + X^6 + X^8 + X^9 + X^10
//! ```
//!
//! Signs `c` and `d`: 0 is +1. `p` is a rectangle of the length of a chip that went through the interpolation
//! (`shaping`) at ten samples a chip: flat within 4.25 MHz either side, gone beyond 6 MHz. So edges rise
//! within 0.1 chips, with the ripple of a filter. `A` makes the mean power 1. 20 periods of the code are a
//! bit `d` of the message, 50 a second. **Bits are drawn** by their number: there is no navigation message
//! in them.
//!
//! Source: IS-GPS-200, sections 3.2.1.3 and 3.3.2.3, tables 3-Ia and 20.3.

use num_complex::Complex64;
use rand::Rng;

use super::WaveformError;
use super::shaping::{REACH, areas, overlaps};
use super::stream::Signal;
use crate::rng::{Room, stream};
use crate::scene::radar::{CA_CHIPS_HZ, CA_RATE_HZ};

/// Chips of the code, and of a bit.
const CHIPS: i64 = 1023;
const OF_BIT: i64 = 20 * CHIPS;
/// Samples of a chip.
const SAMPLES: usize = 10;
/// Chips that a sample is made of: its own, and so many to either side.
const SIDES: i64 = 2;
const REACHED: usize = 2 * SIDES as usize + 1;
/// Stages of G2 whose sum is the delayed G2 of a satellite (table 3-Ia).
const TAPS: [[usize; 2]; 32] = [
    [2, 6],
    [3, 7],
    [4, 8],
    [5, 9],
    [1, 9],
    [2, 10],
    [1, 8],
    [2, 9],
    [3, 10],
    [2, 3],
    [3, 4],
    [5, 6],
    [6, 7],
    [7, 8],
    [8, 9],
    [9, 10],
    [1, 4],
    [2, 5],
    [3, 6],
    [4, 7],
    [5, 8],
    [6, 9],
    [1, 3],
    [4, 6],
    [5, 7],
    [6, 8],
    [7, 9],
    [8, 10],
    [1, 6],
    [2, 7],
    [3, 8],
    [4, 9],
];
/// Part of the stream of random numbers: noise, television and broadcast have others.
const PART: u64 = 4;

/// The code of a satellite with random data.
#[derive(Clone, Debug)]
pub struct CoarseCode {
    signs: Vec<f64>,
    seed: u64,
    /// For every sample of a chip what the chips around it give, from the earliest on.
    weights: [[f64; REACHED]; SAMPLES],
}

impl CoarseCode {
    /// Of a satellite, 1 to 32, by the number of its code.
    pub fn new(prn: u8, seed: u64) -> Self {
        let signs = code(prn);
        let mut own = Self { signs, seed, weights: weights() };
        let scale = own.power().sqrt().recip();
        own.weights.iter_mut().flatten().for_each(|weight| *weight *= scale);
        own
    }

    /// Sign of a chip of the code, by its number from any begin of the code.
    fn sign(&self, chip: i64) -> f64 {
        self.signs[chip.rem_euclid(CHIPS) as usize]
    }

    /// A sample of ten of a chip whose neighbours and itself are these.
    fn sample(&self, place: usize, chips: &[f64; REACHED]) -> f64 {
        self.weights[place].iter().zip(chips).map(|(weight, chip)| weight * chip).sum()
    }

    /// Mean power over a period, once samples are interpolated.
    fn power(&self) -> f64 {
        let chips = |chip: i64| std::array::from_fn(|i| self.sign(chip + i as i64 - SIDES));
        let samples: Vec<f64> = (0..CHIPS)
            .flat_map(|chip| (0..SAMPLES).map(move |place| (chip, place)))
            .map(|(chip, place)| self.sample(place, &chips(chip)))
            .collect();
        let count = samples.len();
        let apart = |k: usize| -> f64 { (0..count).map(|n| samples[n] * samples[(n + k) % count]).sum() };
        let of = |(k, overlap): (usize, &f64)| if k == 0 { 1.0 } else { 2.0 } * overlap * apart(k);
        overlaps().iter().enumerate().map(of).sum::<f64>() / count as f64
    }
}

impl Signal for CoarseCode {
    fn name(&self) -> &str {
        "gps-l1-ca"
    }

    fn rate_hz(&self) -> f64 {
        CA_RATE_HZ
    }

    /// One over the length of a chip.
    fn bandwidth_hz(&self) -> f64 {
        CA_CHIPS_HZ
    }

    fn fill(&self, first: u64, out: &mut [Complex64]) -> Result<(), WaveformError> {
        let mut numbers = stream(self.seed, Room::Waveform, 0, PART);
        let mut known = None;
        let mut chip_at = |chip: i64| {
            let number = chip.div_euclid(OF_BIT);
            let bit = match known {
                Some((known, bit)) if known == number => bit,
                _ => {
                    numbers.set_word_pos(u128::from(number as u64));
                    if numbers.next_u32() & 1 == 0 { 1.0 } else { -1.0 }
                }
            };
            known = Some((number, bit));
            self.sign(chip) * bit
        };
        let chip = (first / SAMPLES as u64) as i64;
        let mut place = (first % SAMPLES as u64) as usize;
        let mut chips: [f64; REACHED] = std::array::from_fn(|i| chip_at(chip + i as i64 - SIDES));
        let mut next = chip + SIDES + 1;
        for sample in out {
            if place == SAMPLES {
                place = 0;
                chips.rotate_left(1);
                chips[REACHED - 1] = chip_at(next);
                next += 1;
            }
            *sample = Complex64::from(self.sample(place, &chips));
            place += 1;
        }
        Ok(())
    }
}

/// The code of a satellite, 0 as +1.
fn code(prn: u8) -> Vec<f64> {
    let taps = TAPS[usize::from(prn.clamp(1, 32)) - 1];
    let (mut g1, mut g2) = ([true; 10], [true; 10]);
    let next = |stages: &mut [bool; 10], feedback: &[usize]| {
        let new = feedback.iter().fold(false, |sum, stage| sum ^ stages[stage - 1]);
        stages.rotate_right(1);
        stages[0] = new;
    };
    (0..CHIPS)
        .map(|_| {
            let chip = g1[9] ^ taps.iter().fold(false, |sum, stage| sum ^ g2[stage - 1]);
            next(&mut g1, &[3, 10]);
            next(&mut g2, &[2, 3, 6, 8, 9, 10]);
            if chip { -1.0 } else { 1.0 }
        })
        .collect()
}

/// What chips around a sample give to it: the interpolation's area over each.
fn weights() -> [[f64; REACHED]; SAMPLES] {
    let areas = areas();
    let area = |from: i64, to: i64| {
        let clamp = |place: i64| (place + REACH as i64).clamp(0, areas.len() as i64) as usize;
        areas[clamp(from)..clamp(to)].iter().sum()
    };
    std::array::from_fn(|place| {
        std::array::from_fn(|i| {
            let begins = (i as i64 - SIDES) * SAMPLES as i64 - place as i64;
            area(begins, begins + SAMPLES as i64)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 3-Ia: the first ten chips, octal.
    const FIRST: [u32; 32] = [
        0o1440, 0o1620, 0o1710, 0o1744, 0o1133, 0o1455, 0o1131, 0o1454, 0o1626, 0o1504, 0o1642, 0o1750,
        0o1764, 0o1772, 0o1775, 0o1776, 0o1156, 0o1467, 0o1633, 0o1715, 0o1746, 0o1763, 0o1063, 0o1706,
        0o1743, 0o1761, 0o1770, 0o1774, 0o1127, 0o1453, 0o1625, 0o1712,
    ];

    #[test]
    fn codes_are_those_of_the_standard() {
        for (prn, first) in (1..=32).zip(FIRST) {
            let signs = code(prn);
            let found = signs[..10].iter().fold(0, |word, sign| word << 1 | u32::from(*sign < 0.0));
            assert_eq!(found, first, "{prn}: {found:o}");
        }
    }

    /// Gold codes: four values of the correlation with itself, three with each other.
    #[test]
    fn correlations_are_those_of_gold_codes() {
        let correlation = |a: &[f64], b: &[f64], lag: usize| {
            (0..a.len()).map(|k| a[k] * b[(k + lag) % b.len()]).sum::<f64>() as i32
        };
        let codes: Vec<Vec<f64>> = (1..=32).map(code).collect();
        for (i, own) in codes.iter().enumerate() {
            assert_eq!(correlation(own, own, 0), 1023);
            for lag in 1..1023 {
                assert!([-1, -65, 63].contains(&correlation(own, own, lag)), "{i} {lag}");
            }
            let other = &codes[(i + 1) % codes.len()];
            assert!((0..1023).all(|lag| [-1, -65, 63].contains(&correlation(own, other, lag))), "{i}");
        }
    }

    /// Chips are rectangles to 4.25 MHz: the transform of one is `sinc`, and all of one sign are level.
    #[test]
    fn a_chip_is_a_rectangle_of_its_band() {
        let weights = weights();
        for of_place in &weights {
            assert!((of_place.iter().sum::<f64>() - 1.0).abs() < 1e-5, "{of_place:?}");
        }
        // Of the chip from sample 0 on, a sample is in chip q and has it 0 - q chips away.
        let sample = |n: i64| {
            let (chip, place) = (n.div_euclid(10), n.rem_euclid(10) as usize);
            usize::try_from(SIDES - chip).ok().and_then(|i| weights[place].get(i)).copied().unwrap_or(0.0)
        };
        for i in 0..=16 {
            let v = 0.0255 * f64::from(i);
            // The middle of the chip is at 5 samples.
            let of = |n: i64| Complex64::cis(-std::f64::consts::TAU * v * (n as f64 - 5.0)) * sample(n);
            let found: Complex64 = (-40..60).map(of).sum();
            let x = std::f64::consts::PI * 10.0 * v;
            let expected = if i == 0 { 10.0 } else { 10.0 * x.sin() / x };
            assert!((found - expected).norm() < 3e-4, "{v}: {found} {expected}");
        }
    }

    /// Mean power 1 between samples as well, bits of 20 ms, and any part the same part.
    #[test]
    fn bits_turn_the_code() {
        let own = CoarseCode::new(7, 3);
        let (bit, first) = (204_600, 204_600u64 << 20);
        let mut all = vec![Complex64::ZERO; 20_460];
        // The middle of chips is within a few per cent of the sign.
        let found: Vec<f64> = (0..20)
            .map(|i| {
                own.fill(first + i * bit + 102_300, &mut all).unwrap();
                (0..1023).map(|k| all[10 * k + 5].re * own.signs[k]).sum::<f64>() / 1023.0
            })
            .collect();
        assert!(found.iter().all(|bit| (bit.abs() - 1.0).abs() < 0.1), "{found:?}");
        let turned = found.iter().filter(|bit| **bit < 0.0).count();
        assert!((3..18).contains(&turned), "{found:?}");
        let halves = |t: usize| -> f64 {
            let of = |j: usize| super::super::shaping::kernel(20.5 - j as f64) * all[t + j].re;
            (0..=41).map(of).sum::<f64>().powi(2)
        };
        let between = (0..10_230).map(halves).sum::<f64>() / 10_230.0;
        let at = all[..10_230].iter().map(|sample| sample.norm_sqr()).sum::<f64>() / 10_230.0;
        // What the filter takes of both is the transition alone.
        assert!((0.5 * (between + at) - 1.0).abs() < 2e-3, "{between} {at}");
        let mut part = vec![Complex64::ZERO; 5000];
        CoarseCode::new(7, 3).fill(first + 203_333, &mut part).unwrap();
        own.fill(first + 200_000, &mut all).unwrap();
        assert_eq!(part, all[3333..8333]);
    }
}
