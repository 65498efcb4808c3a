//! Chips of equal length: phase codes, and a plain pulse, which is one chip.
//!
//! With `N` chips of length `Tb` and unit amplitude `c_k`, and `rect` 1 within half of either side of 0,
//!
//! ```text
//! p(t) = sum_k c_k rect((t - (k + 1/2) Tb) / Tb) ,   k = 0 .. N-1
//! P(f) = Tb sinc(f Tb) e^{-j pi f Tb} sum_k c_k e^{-j 2 pi k f Tb} ,   sinc x = sin(pi x)/(pi x)
//! ```
//!
//! A jump of phase is infinitely wide: `|P|` falls as `1/f`. Nothing is smoothed here; the receive filter
//! limits it, as it does the edges of any pulse.
//!
//! | code | phase of chip `k = 0 .. N-1` | side lobes of the compressed pulse |
//! | --- | --- | --- |
//! | Barker | 0 or pi, `N` = 2, 3, 4, 5, 7, 11, 13 | `1/N` at most |
//! | Frank | `(2 pi/M) i j`, `k = M i + j`, `N = M^2` | about `1/(pi M)` |
//! | P3 | `pi k^2/N` | `sin(pi l^2/N) / (N sin(pi l/N))` at a lag of `l` chips |
//! | P4 | `pi k^2/N - pi k` | as P3 |
//! | m-sequence | `pi a_k`, `a_k = sum_t a_{k-t} mod 2`, first 1, `N = 2^n - 1` | periodic: `-1/N` |
//! | Golay | `a' = a b`, `b' = a -b` from one chip each, `N = 2^n` | none of the sum over the pair |
//!
//! Source: Levanon and Mozeson, *Radar Signals* (2004), chapter 6; Lewis and Kretschmer, IEEE Trans. AES-18
//! (1982) 637 (P3, P4); Golomb, *Shift Register Sequences* (1967); Golay, IRE Trans. IT-7 (1961) 82.
//!
//! The sum over chips has the period `1/Tb` in `f`. Up to 32 chips are summed, more are read from a table as
//! that of [`Sampled`](super::Sampled): within 1.8e-13 of `N Tb`.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::table::{self, POINTS};
use super::{Waveform, WaveformError};
use crate::radar::phasor::phasor;
use crate::scene::radar::Code;

/// Chips up to which they are summed.
const SUMMED: usize = 32;

/// Chips of unit amplitude.
#[derive(Clone, Debug)]
pub struct Coded {
    name: &'static str,
    chip_s: f64,
    chips: Vec<Complex64>,
    /// Delay of the middle of the chips, in chips.
    middle: f64,
    /// Entries of the table in one `1/Tb`.
    cells: usize,
    /// [`table::of_sum`]; empty where chips are summed.
    table: Vec<Complex64>,
}

impl Coded {
    /// A rectangular pulse of the carrier.
    ///
    /// # Errors
    /// A length that is not above 0 and finite.
    pub fn plain(duration_s: f64) -> Result<Self, WaveformError> {
        if !(duration_s > 0.0 && duration_s.is_finite()) {
            return Err(WaveformError::Duration { duration_s });
        }
        Ok(Self::of("cw", vec![Complex64::ONE], duration_s))
    }

    /// A phase code.
    ///
    /// # Errors
    /// A code that does not exist, chips of a length that is not above 0 and finite.
    pub fn new(code: Code, chip_s: f64) -> Result<Self, WaveformError> {
        if !(chip_s > 0.0 && chip_s.is_finite()) {
            return Err(WaveformError::Chip { chip_s });
        }
        let chips = turns(code)?.into_iter().map(phasor).collect();
        Ok(Self::of(code.name(), chips, chip_s))
    }

    fn of(name: &'static str, chips: Vec<Complex64>, chip_s: f64) -> Self {
        let middle = 0.5 * (chips.len() as f64 - 1.0);
        let (cells, table) = if chips.len() > SUMMED { table::of_sum(&chips, 1.0) } else { (0, Vec::new()) };
        Self { name, chip_s, chips, middle, cells, table }
    }

    /// `sum_k c_k e^{-j 2 pi k x}`.
    fn sum(&self, x: f64) -> Complex64 {
        // Within half a period, so that the table holds it.
        let x = x - x.round();
        if self.table.is_empty() {
            let turn = phasor(-x);
            return self.chips.iter().rev().fold(Complex64::ZERO, |sum, chip| sum * turn + chip);
        }
        let place = (x + 0.5) * self.cells as f64 + (POINTS / 2) as f64;
        table::at(&self.table, place) * phasor(-x * self.middle)
    }
}

/// Values of a code's chips, in turns.
fn turns(code: Code) -> Result<Vec<f64>, WaveformError> {
    let refused =
        |allowed: &'static str| Err(WaveformError::Code { code: code.name(), chips: code.chips(), allowed });
    let signs = |text: &str| text.bytes().map(|sign| if sign == b'+' { 0.0 } else { 0.5 }).collect();
    let between = |chips: usize| (2..=Code::MOST_CHIPS).contains(&chips);
    Ok(match code {
        Code::Barker { chips } => signs(match chips {
            2 => "+-",
            3 => "++-",
            4 => "++-+",
            5 => "+++-+",
            7 => "+++--+-",
            11 => "+++---+--+-",
            13 => "+++++--++-+-+",
            _ => return refused("2, 3, 4, 5, 7, 11 or 13"),
        }),
        Code::Frank { phases } => {
            if !(2..=256).contains(&phases) {
                return refused("a square of 4 to 65536");
            }
            let turn = |k: usize| (k / phases * (k % phases) % phases) as f64 / phases as f64;
            (0..phases * phases).map(turn).collect()
        }
        Code::P3 { chips } | Code::P4 { chips } => {
            if !between(chips) {
                return refused("2 to 65536");
            }
            // k^2/(2 N) turns, by whole numbers modulo one.
            let square = |k: usize| ((k * k) % (2 * chips)) as f64 / (2 * chips) as f64;
            let centred = |k: usize| if matches!(code, Code::P4 { .. }) { 0.5 * (k % 2) as f64 } else { 0.0 };
            (0..chips).map(|k| square(k) - centred(k)).collect()
        }
        Code::Golay { chips, second } => {
            if !(between(chips) && chips.is_power_of_two()) {
                return refused("a power of two, 2 to 65536");
            }
            // Chip k of either: pairs of ones side by side in the binary digits of k, and the first digit.
            let half = |k: usize| usize::from(second && k >= chips / 2);
            let turn = |k: usize| (k & (k >> 1)).count_ones() as usize + half(k);
            (0..chips).map(|k| 0.5 * (turn(k) % 2) as f64).collect()
        }
        Code::MSequence { register } => {
            // Exponents of primitive polynomials beside `register` and 0.
            let taps: &[usize] = match register {
                2 => &[1],
                3 => &[2],
                4 => &[3],
                5 => &[3],
                6 => &[5],
                7 => &[6],
                8 => &[6, 5, 4],
                9 => &[5],
                10 => &[7],
                11 => &[9],
                12 => &[11, 10, 4],
                13 => &[12, 11, 8],
                14 => &[13, 12, 2],
                15 => &[14],
                16 => &[15, 13, 4],
                _ => return refused("3 to 65535, by a register of 2 to 16 stages"),
            };
            let stages = register as usize;
            let mut bits = vec![true; stages];
            for k in stages..code.chips() {
                bits.push(taps.iter().fold(bits[k - stages], |sum, tap| sum ^ bits[k - tap]));
            }
            bits.into_iter().map(|bit| if bit { 0.5 } else { 0.0 }).collect()
        }
    })
}

impl Waveform for Coded {
    fn name(&self) -> &str {
        self.name
    }

    fn duration_s(&self) -> f64 {
        self.chips.len() as f64 * self.chip_s
    }

    /// One over a chip, Hz.
    fn bandwidth_hz(&self) -> f64 {
        self.chip_s.recip()
    }

    fn lobe_hz(&self) -> f64 {
        self.chip_s.recip()
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        let x = f_hz * self.chip_s;
        let sinc = if x.abs() < 1e-9 { 1.0 } else { phasor(0.5 * x).im / (PI * x) };
        self.sum(x) * (self.chip_s * sinc) * phasor(-0.5 * x)
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        if t_s < 0.0 {
            return Complex64::ZERO;
        }
        self.chips.get((t_s / self.chip_s) as usize).copied().unwrap_or(Complex64::ZERO)
    }
}
