//! Terrestrial television, DVB-T, as EN 300 744 modulates it.
//!
//! ```text
//! s_n = A sum_k c_{l,k} e^{j 2 pi (k - K/2) (n - G)/N} ,   n = 0 .. N + G - 1 of symbol l    (section 4.4)
//! ```
//!
//! at 64/7 MHz in a channel of 8 MHz (56/7, 48/7 of 7 and 6 MHz); `N` = 2048 or 8192, `K + 1` = 1705 or 6817
//! carriers, `G` = N/4 to N/32 samples of guard, 68 symbols a frame. `A` makes the mean power 1.
//!
//! | carriers | `c_{l,k}` | EN 300 744 |
//! | --- | --- | --- |
//! | scattered pilots, `k = 3 (l mod 4) + 12 p` | `4/3 * 2 (1/2 - w_k)` | 4.5.3 |
//! | continual pilots | the same in every symbol | 4.5.4 |
//! | signalling (TPS) | `+-1`, differential | 4.6 |
//! | data | points of the constellation, of mean power 1 | 4.3.5 |
//!
//! `w_k` is the sequence of `X^11 + X^2 + 1` from all ones. A receiver finds mode, guard, constellation,
//! frame and pilots. The **data are drawn**: no transport stream, no code that could be decoded; signalling
//! says non-hierarchical, rate 2/3. Symbols are drawn by their number, so that any part of a run is the same
//! part of the signal.

use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex64;
use rand::Rng;

use super::WaveformError;
use super::stream::Signal;
use crate::rng::{Room, stream};
use crate::scene::radar::{DvbT, DvbTMode};

/// Symbols of a frame, and frames of a super-frame.
const SYMBOLS: u64 = 68;
const FRAMES: u64 = 4;
/// From one carrier number to the same of the next quarter of the 8k mode.
const REPEATS: usize = 1704;
/// Amplitude of pilots.
const BOOST: f64 = 4.0 / 3.0;
/// Continual pilots of the 2k mode; those of the 8k mode are four times as many, [`REPEATS`] apart.
const CONTINUAL: [usize; 45] = [
    0, 48, 54, 87, 141, 156, 192, 201, 255, 279, 282, 333, 432, 450, 483, 525, 531, 618, 636, 714, 759, 765,
    780, 804, 873, 888, 918, 939, 942, 969, 984, 1050, 1101, 1107, 1110, 1137, 1140, 1146, 1206, 1269, 1323,
    1377, 1491, 1683, 1704,
];
/// Carriers of the signalling, likewise.
const SIGNALLING: [usize; 17] =
    [34, 50, 209, 346, 413, 569, 595, 688, 790, 901, 1073, 1219, 1262, 1286, 1469, 1594, 1687];
/// Synchronisation of odd frames; that of even ones is its inverse.
const SYNC: u32 = 0b0011_0101_1110_1110;
/// `X^14 + X^9 + X^8 + X^6 + X^5 + X^4 + X^2 + X + 1` of the code of the signalling.
const GENERATOR: u32 = 0b100_0011_0111_0111;
/// Part of the stream of random numbers: noise has another.
const PART: u64 = 1;

/// What a carrier has.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Carrier {
    Data,
    /// In every symbol.
    Continual,
    Signalling,
}

/// A DVB-T signal.
pub struct Television {
    of: DvbT,
    seed: u64,
    carriers: Vec<Carrier>,
    /// `2 (1/2 - w_k)`.
    signs: Vec<f64>,
    /// Signalling bits of every frame.
    bits: [[bool; SYMBOLS as usize]; FRAMES as usize],
    scale: f64,
    inverse: Arc<dyn Fft<f64>>,
}

impl Television {
    /// Of what is described, drawn by a seed.
    pub fn new(of: DvbT, seed: u64) -> Self {
        let count = of.carriers();
        let mut carriers = vec![Carrier::Data; count];
        for from in (0..count.saturating_sub(1)).step_by(REPEATS) {
            let mut mark = |places: &[usize], kind| {
                places.iter().for_each(|place| carriers[from + place] = kind);
            };
            mark(&CONTINUAL, Carrier::Continual);
            mark(&SIGNALLING, Carrier::Signalling);
        }
        let mut own = Self {
            of,
            seed,
            carriers,
            signs: signs(count),
            bits: std::array::from_fn(|frame| signalling(of, frame)),
            scale: 1.0,
            inverse: nereus_fft::inverse(of.samples()),
        };
        let power = |symbol: u64| -> f64 {
            let of = |k: usize| if own.is_pilot(symbol, k) { BOOST * BOOST } else { 1.0 };
            (0..count).map(of).sum()
        };
        own.scale = ((0..4).map(power).sum::<f64>() / 4.0).sqrt().recip();
        own
    }

    fn is_pilot(&self, symbol: u64, k: usize) -> bool {
        let scattered = k % 12 == 3 * (symbol % 4) as usize;
        self.carriers[k] == Carrier::Continual || (scattered && self.carriers[k] != Carrier::Signalling)
    }

    /// Carriers of a symbol, by its number from the start of the signal.
    fn cells(&self, number: u64) -> Vec<Complex64> {
        let (symbol, frame) = (number % SYMBOLS, number / SYMBOLS % FRAMES);
        let mut numbers = stream(self.seed, Room::Waveform, number, PART);
        // Every bit that is 1 turns the signalling over.
        let turned = self.bits[frame as usize][1..=symbol as usize].iter().filter(|bit| **bit).count();
        let signalling = if turned % 2 == 0 { 1.0 } else { -1.0 };
        let levels = self.of.constellation.levels();
        let points = (2.0 * (f64::from(levels * levels) - 1.0) / 3.0).sqrt();
        let mut level = || {
            let drawn = (u64::from(numbers.next_u32()) * u64::from(levels)) >> 32;
            (2.0 * drawn as f64 + 1.0 - f64::from(levels)) / points
        };
        (0..self.carriers.len())
            .map(|k| match self.carriers[k] {
                Carrier::Signalling => Complex64::new(signalling * self.signs[k], 0.0),
                _ if self.is_pilot(symbol, k) => Complex64::new(BOOST * self.signs[k], 0.0),
                _ => Complex64::new(level(), level()),
            })
            .collect()
    }

    /// The samples of a symbol without its guard.
    fn symbol(&self, number: u64, out: &mut Vec<Complex64>) {
        let (samples, cells) = (self.of.samples(), self.cells(number));
        out.clear();
        out.resize(samples, Complex64::ZERO);
        for (k, cell) in cells.iter().enumerate() {
            out[(k + samples - cells.len() / 2) % samples] = cell * self.scale;
        }
        self.inverse.process(out);
    }
}

impl Signal for Television {
    fn name(&self) -> &str {
        "dvb-t"
    }

    fn rate_hz(&self) -> f64 {
        self.of.rate_hz()
    }

    fn bandwidth_hz(&self) -> f64 {
        self.of.occupied_hz()
    }

    fn fill(&self, first: u64, out: &mut [Complex64]) -> Result<(), WaveformError> {
        let (samples, guard) = (self.of.samples(), self.of.guard_samples());
        let length = (samples + guard) as u64;
        let (mut at, mut rest, mut symbol) = (first, out, Vec::new());
        while !rest.is_empty() {
            let (number, from) = (at / length, (at % length) as usize);
            self.symbol(number, &mut symbol);
            let (now, later) = rest.split_at_mut((samples + guard - from).min(rest.len()));
            for (sample, place) in now.iter_mut().zip(from..) {
                // The guard is the end of what follows.
                *sample = symbol[(place + samples - guard) % samples];
            }
            at += now.len() as u64;
            rest = later;
        }
        Ok(())
    }
}

/// `2 (1/2 - w_k)` of so many carriers.
fn signs(count: usize) -> Vec<f64> {
    let mut register = 0x7ffu32;
    let next = |register: &mut u32| {
        let bit = *register & 1;
        *register = *register >> 1 | ((*register >> 2 ^ *register) & 1) << 10;
        1.0 - 2.0 * f64::from(bit)
    };
    (0..count).map(|_| next(&mut register)).collect()
}

/// Signalling bits of a frame, the first of which starts the differential modulation.
fn signalling(of: DvbT, frame: usize) -> [bool; SYMBOLS as usize] {
    let mut bits = Vec::with_capacity(SYMBOLS as usize);
    let mut push = |value: u32, count: u32| bits.extend((0..count).rev().map(|bit| value >> bit & 1 == 1));
    push(0, 1);
    push(if frame.is_multiple_of(2) { SYNC } else { !SYNC & 0xffff }, 16);
    // 23 bits are in use; frame of the super-frame; constellation.
    push(0b01_0111, 6);
    push(frame as u32, 2);
    push(of.constellation.number(), 2);
    // Non-hierarchical, code rate 2/3.
    push(0b000, 3);
    push(0b001, 3);
    push(0b001, 3);
    push(of.guard.number(), 2);
    push(u32::from(of.mode == DvbTMode::K8), 2);
    // No cell identification; reserved.
    push(0, 8 + 6);
    let mut register = 0u32;
    for bit in bits[1..].iter().copied().chain([false; 14]) {
        register = register << 1 | u32::from(bit);
        if register >> 14 & 1 == 1 {
            register ^= GENERATOR;
        }
    }
    bits.extend((0..14).rev().map(|bit| register >> bit & 1 == 1));
    let mut out = [false; SYMBOLS as usize];
    out.iter_mut().zip(bits).for_each(|(to, bit)| *to = bit);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::radar::{Constellation, Guard};

    fn television(mode: DvbTMode, guard: Guard) -> Television {
        Television::new(DvbT { channel_hz: 8e6, mode, guard, constellation: Constellation::Qam64 }, 3)
    }

    /// The transform of a symbol is its carriers, wherever the guard is cut; pilots are where the standard
    /// has them.
    #[test]
    fn a_symbol_has_its_carriers() {
        for (mode, guard) in [(DvbTMode::K2, Guard::Quarter), (DvbTMode::K8, Guard::Thirtysecond)] {
            let own = television(mode, guard);
            let (samples, guard) = (own.of.samples(), own.of.guard_samples());
            let length = (samples + guard) as u64;
            for (number, early) in [(0, 0), (70, guard), (201, 5)] {
                let mut values = vec![Complex64::ZERO; samples];
                own.fill(number * length + (guard - early) as u64, &mut values).unwrap();
                nereus_fft::forward(samples).process(&mut values);
                let middle = own.carriers.len() / 2;
                let mut pilots = 0;
                for k in 0..own.carriers.len() {
                    let bin = (k + samples - middle) % samples;
                    let turn = std::f64::consts::TAU * (k as f64 - middle as f64) * early as f64;
                    let found = values[bin] * Complex64::cis(turn / samples as f64);
                    let found = found / (samples as f64 * own.scale);
                    if own.is_pilot(number % 68, k) {
                        pilots += 1;
                        assert!((found - BOOST * own.signs[k]).norm() < 1e-9, "{number} {k}: {found}");
                    }
                }
                // 142 or 143 scattered ones a symbol of 2k, some of which are continual.
                let expected = if mode == DvbTMode::K2 { 170..=190 } else { 680..=760 };
                assert!(expected.contains(&pilots), "{pilots}");
                let beyond = values[(own.carriers.len() - middle + 1)..samples - middle - 1].iter();
                assert!(beyond.map(|value| value.norm()).fold(0.0, f64::max) < 1e-9 * samples as f64);
            }
        }
    }

    /// Mean power 1, and any part is the same part.
    #[test]
    fn parts_are_those_of_the_whole() {
        let own = television(DvbTMode::K2, Guard::Eighth);
        let mut all = vec![Complex64::ZERO; 300_000];
        own.fill(1 << 33, &mut all).unwrap();
        let power = all.iter().map(Complex64::norm_sqr).sum::<f64>() / all.len() as f64;
        assert!((power - 1.0).abs() < 0.01, "{power}");
        let mut part = vec![Complex64::ZERO; 5000];
        television(DvbTMode::K2, Guard::Eighth).fill((1 << 33) + 123_457, &mut part).unwrap();
        assert_eq!(part, all[123_457..128_457]);
    }

    /// Signalling is a word of its code, and carriers of the signalling say it: differential, from the sign
    /// of the reference sequence.
    #[test]
    fn signalling_is_that_of_the_settings() {
        let own = television(DvbTMode::K8, Guard::Sixteenth);
        let bits = own.bits[1];
        let value = |range: std::ops::Range<usize>| {
            bits[range].iter().fold(0u32, |value, bit| value << 1 | u32::from(*bit))
        };
        assert_eq!(value(1..17), 0b1100_1010_0001_0001);
        assert_eq!([value(23..25), value(25..27), value(36..38), value(38..40)], [1, 2, 1, 1]);
        // Every multiple of the generator leaves nothing.
        let mut register = 0u32;
        for bit in &bits[1..] {
            register = register << 1 | u32::from(*bit);
            if register >> 14 & 1 == 1 {
                register ^= GENERATOR;
            }
        }
        assert_eq!(register, 0);
        // Symbols of frame 1 are those from 68 on.
        let mut before = own.cells(68)[34].re;
        assert_eq!(before, own.signs[34]);
        for (symbol, bit) in bits.iter().enumerate().skip(1) {
            let now = own.cells(68 + symbol as u64)[34].re;
            assert_eq!(now != before, *bit, "{symbol}");
            before = now;
        }
    }

    /// The sequence starts with eleven ones and 2047 later begins anew.
    #[test]
    fn signs_are_a_sequence_of_2047() {
        let signs = signs(4200);
        assert!(signs[..11].iter().all(|sign| *sign == -1.0));
        assert_eq!(signs[..2000], signs[2047..4047]);
        assert_ne!(signs[..200], signs[100..300]);
    }
}
