//! The phasors of many facets at all pulses of a block: the sums of [`comb`](super::comb) in f32.
//!
//! Lines are asked for at the first pulse and at the last; middle, inverse of the end, and height of the bell
//! are straight in between. What that leaves of an amplitude is an eighth of their second difference over the
//! end: with a middle of twice the end, -73 dB where the antennas turn by 0.03 rad about a facet in a block.
//!
//! A block is cut into pieces in which no component moves by more than `WITHIN` of the bell's end: there its
//! weight is a straight line between both ends of the piece, at most `WITHIN^2` off (-72 dB). Components
//! start a piece at their own phase, from f64, and turn by a constant phasor from pulse to pulse.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::TAU;

use super::comb::Comb;
use super::group::{End, GROUP, Looks};
use super::{BraggLines, Mechanism};
use crate::cpu::Task;

/// Pulses of a piece, at most: turning leaves 1e-6 each, -83 dB in as many.
const LONGEST: usize = 64;
/// What a component may move in a piece, over the bell's end.
const WITHIN: f32 = 1.0 / 64.0;

/// Phasors at a pulse: real and imaginary.
pub type Phasors = [[f32; GROUP]; 2];

/// When a block's pulses are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times<'a> {
    /// The first, after pulse 0, s.
    pub first_s: f64,
    /// From one to the next, s; the mean.
    pub interval_s: f64,
    /// Of every pulse from the first on, in these intervals; empty where all are equal.
    pub uneven: &'a [f64],
}

/// What turns a mechanism of up to [`GROUP`] facets of global keys at every pulse.
pub struct BlockPhasors<'a> {
    /// The lines of the sea.
    pub lines: &'a BraggLines,
    /// What is turned.
    pub mechanism: Mechanism,
    /// Which mode of it.
    pub mode: usize,
    /// The facets.
    pub keys: &'a [[i64; 2]],
    /// Where they are looked at from, at the first pulse and at the last.
    pub looks: &'a [Looks; 2],
    /// When pulses are.
    pub times: Times<'a>,
    /// Phasors of every pulse.
    pub out: &'a mut [Phasors],
}

impl Task for BlockPhasors<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lines, mechanism, mode, keys, looks: [first, last], times, out } = self;
        out.fill([[0.0; GROUP]; 2]);
        let count = keys.len().min(GROUP);
        let mut facets = [0; GROUP];
        for i in 0..count {
            facets[i] = lines.number_of(keys[i], mode);
        }
        let mut ends = [[End::NONE; 2]; 2];
        let [of_first, of_last] = &mut ends;
        lines.of_group(mechanism, first, count, of_first);
        lines.of_group(mechanism, last, count, of_last);
        for line in 0..2 {
            let ends = [&ends[0][line], &ends[1][line]];
            if ends[0].highest() > 0.0 || ends[1].highest() > 0.0 {
                let number = mechanism.number() + line as u32;
                Sum { comb: lines.comb, facets: &facets, number, ends, times, out: &mut *out }.run();
            }
        }
    }
}

/// Adds the components of a line of a group.
struct Sum<'a> {
    comb: Comb,
    facets: &'a [u64; GROUP],
    number: u32,
    ends: [&'a End; 2],
    times: Times<'a>,
    out: &'a mut [Phasors],
}

/// A line of a group over the pulses of a block.
struct Bell {
    /// Change of the middle from pulse to pulse, rad/s.
    moved: [f32; GROUP],
    /// 1 over the bell's end, s/rad, and its change.
    inverse: [f32; GROUP],
    narrowed: [f32; GROUP],
    height: [f32; GROUP],
    raised: [f32; GROUP],
}

impl Bell {
    #[inline(always)]
    fn between(start: &End, stop: &End, intervals: f32) -> Self {
        let share = 1.0 / intervals;
        let mut bell = Self {
            moved: [0.0; GROUP],
            inverse: [0.0; GROUP],
            narrowed: [0.0; GROUP],
            height: [0.0; GROUP],
            raised: [0.0; GROUP],
        };
        for i in 0..GROUP {
            bell.moved[i] = (stop.centre_radps[i] - start.centre_radps[i]) * share;
            bell.inverse[i] = start.inverse[i];
            bell.narrowed[i] = (stop.inverse[i] - start.inverse[i]) * share;
            bell.height[i] = start.height[i];
            bell.raised[i] = (stop.height[i] - start.height[i]) * share;
        }
        bell
    }

    /// Pulses in which no component moves by more than [`WITHIN`].
    #[inline(always)]
    fn piece(&self) -> usize {
        let mut most = 0.0f32;
        for i in 0..GROUP {
            let step = self.moved[i].abs() * self.inverse[i] + self.narrowed[i].abs() / self.inverse[i];
            most = if step > most { step } else { most };
        }
        ((WITHIN / most) as usize).clamp(1, LONGEST)
    }

    /// Weights, so many intervals after the first pulse, of components that lie so far from the middle there,
    /// rad/s, and have amplitudes of their own.
    #[inline(always)]
    fn weigh(&self, from: &[f32; GROUP], pulse: f32, own: &[f32; GROUP], weight: &mut [f32; GROUP]) {
        for i in 0..GROUP {
            let x = (from[i] - pulse * self.moved[i]) * (self.inverse[i] + pulse * self.narrowed[i]);
            let fall = 1.0 - x * x;
            let fall = if fall > 0.0 { fall } else { 0.0 };
            weight[i] = own[i] * (self.height[i] + pulse * self.raised[i]) * fall * fall;
        }
    }
}

impl Task for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { comb, facets, number, ends: [start, stop], times, out } = self;
        let per_cell = 1.0 / comb.step_radps() as f32;
        let (mut first, mut cells) = ([0i32; GROUP], 0);
        for i in 0..GROUP {
            let ([a, b], [c, d]) = (start.span(i), stop.span(i));
            first[i] = (a.min(c) * per_cell).floor() as i32;
            let last = (b.max(d) * per_cell).floor() as i32;
            cells = cells.max(last.saturating_sub(first[i]).saturating_add(1));
        }
        let last = (out.len().max(2) - 1) as f32;
        let intervals = times.uneven.last().map_or(last, |last| (*last as f32).max(f32::MIN_POSITIVE));
        let bell = Bell::between(start, stop, intervals);
        let length = bell.piece();
        let (to_start, to_next) = (times.first_s / TAU, times.interval_s / TAU);
        let (mut from, mut turns, mut step) = ([0.0f32; GROUP], [0.0f32; GROUP], [0.0f32; GROUP]);
        let (mut at, mut next) = ([0.0f64; GROUP], [0.0f64; GROUP]);
        let (mut weight, mut end, mut grow) = ([0.0f32; GROUP], [0.0f32; GROUP], [0.0f32; GROUP]);
        let mut own = [1.0f32; GROUP];
        for cell in 0..cells {
            if comb.is_gaussian() {
                for i in 0..GROUP {
                    own[i] = Comb::amplitude(facets[i], number, first[i].wrapping_add(cell));
                }
            }
            for i in 0..GROUP {
                let (omega_radps, phase) = comb.component(facets[i], number, first[i].wrapping_add(cell));
                from[i] = (omega_radps - f64::from(start.centre_radps[i])) as f32;
                (at[i], next[i]) = (omega_radps * to_start + phase, omega_radps * to_next);
                step[i] = (next[i] - next[i].floor()) as f32;
            }
            if !times.uneven.is_empty() {
                // Every pulse by itself: none is a step from the one before.
                for ([re, im], after) in out.iter_mut().zip(times.uneven) {
                    bell.weigh(&from, *after as f32, &own, &mut weight);
                    for i in 0..GROUP {
                        let now = at[i] + after * next[i];
                        turns[i] = (now - now.floor()) as f32;
                    }
                    let [cos, sin] = phasors(&turns);
                    for i in 0..GROUP {
                        re[i] += weight[i] * cos[i];
                        im[i] += weight[i] * sin[i];
                    }
                }
                continue;
            }
            let [cos_step, sin_step] = phasors(&step);
            bell.weigh(&from, 0.0, &own, &mut weight);
            let mut before = 0;
            for out in out.chunks_mut(length) {
                bell.weigh(&from, (before + out.len()) as f32, &own, &mut end);
                let share = 1.0 / out.len() as f32;
                for i in 0..GROUP {
                    grow[i] = (end[i] - weight[i]) * share;
                    let now = at[i] + before as f64 * next[i];
                    turns[i] = (now - now.floor()) as f32;
                }
                let [mut cos, mut sin] = phasors(&turns);
                for [re, im] in &mut *out {
                    for i in 0..GROUP {
                        re[i] += weight[i] * cos[i];
                        im[i] += weight[i] * sin[i];
                        let turned = cos[i] * cos_step[i] - sin[i] * sin_step[i];
                        sin[i] = cos[i] * sin_step[i] + sin[i] * cos_step[i];
                        cos[i] = turned;
                        weight[i] += grow[i];
                    }
                }
                before += out.len();
                weight = end;
            }
        }
    }
}

/// Cosines and sines of some turns, within 1e-6: from those of half the angle, within a quarter of a turn.
#[inline(always)]
pub(crate) fn phasors(turns: &[f32; GROUP]) -> [[f32; GROUP]; 2] {
    let mut out = [[0.0; GROUP]; 2];
    for i in 0..GROUP {
        // -1/2 to 1/2.
        let t = turns[i] - (turns[i] + 0.5).floor();
        let x = std::f32::consts::PI * t;
        let y = x * x;
        let sin = x
            * (1.0
                + y * (-1.0 / 6.0
                    + y * (1.0 / 120.0
                        + y * (-1.0 / 5040.0 + y * (1.0 / 362_880.0 - y * (1.0 / 39_916_800.0))))));
        let cos = 1.0
            + y * (-0.5
                + y * (1.0 / 24.0
                    + y * (-1.0 / 720.0
                        + y * (1.0 / 40_320.0 + y * (-1.0 / 3_628_800.0 + y * (1.0 / 479_001_600.0))))));
        (out[0][i], out[1][i]) = (1.0 - 2.0 * sin * sin, 2.0 * sin * cos);
    }
    out
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::tests::lines;
    use super::*;
    use crate::cpu::Variant;

    /// A block is the sum of the reference at every pulse: with a flight past facets, near and far from its
    /// start, in every variant.
    #[test]
    fn a_block_is_the_reference() {
        let plain = lines(100.0, 1.0, [0.05, 0.02], [0.01, 0.005]);
        let gaussian = BraggLines { comb: plain.comb.gaussian(), ..plain.clone() };
        let keys: Vec<[i64; 2]> = (0..13).map(|n| [n, 3 - 2 * n]).collect();
        let sight = |n: usize, at: f64| {
            let place = DVec3::new(-1.0, 0.1 + 0.01 * n as f64 + at, -0.8).normalize();
            [place, -place]
        };
        for variant in Variant::ALL.into_iter().filter(|variant| variant.is_available()) {
            for (first_s, pulses) in [(0.0, 1), (3.5, 33), (60.0, 150), (3600.0, 20)] {
                for staggered in [false, true] {
                    let at: Vec<f64> = (0..pulses).map(|n| n as f64 + 0.3 * (n % 3) as f64).collect();
                    let uneven: &[f64] = if staggered { &at } else { &[] };
                    let after = |pulse: usize| uneven.get(pulse).copied().unwrap_or(pulse as f64);
                    let times = Times { first_s, interval_s: 0.004, uneven };
                    let along = |pulse: usize| 5e-5 * after(pulse);
                    let mut looks = [[[0.0; GROUP]; 3]; 2];
                    for (looks, at) in looks.iter_mut().zip([0.0, along(pulses - 1)]) {
                        for n in 0..keys.len() {
                            let [incident, scattered] = sight(n, at);
                            let look = scattered - incident;
                            let look = look.as_vec3();
                            (looks[0][n], looks[1][n], looks[2][n]) = (look.x, look.y, look.z);
                        }
                    }
                    let mut out = vec![[[7.0; GROUP]; 2]; pulses];
                    let of = [(&plain, Mechanism::Specular, 0), (&plain, Mechanism::Bragg, 0)];
                    for (lines, mechanism, mode) in of.into_iter().chain([(&gaussian, Mechanism::Bragg, 2)]) {
                        let (keys, looks) = (&keys[..], &looks);
                        variant.run(BlockPhasors {
                            lines,
                            mechanism,
                            mode,
                            keys,
                            looks,
                            times,
                            out: &mut out,
                        });
                        let (mut off, mut power) = (0.0, 0.0);
                        for (pulse, [re, im]) in out.iter().enumerate() {
                            for (n, key) in keys.iter().enumerate() {
                                let [incident, scattered] = sight(n, along(pulse));
                                let t_s = first_s + 0.004 * after(pulse);
                                let exact = lines.phasor((mechanism, mode), *key, (incident, scattered), t_s);
                                off += (f64::from(re[n]) - exact.re).powi(2)
                                    + (f64::from(im[n]) - exact.im).powi(2);
                                power += exact.norm_sqr();
                            }
                        }
                        let db = 10.0 * (off / power).log10();
                        println!(
                            "{variant} {first_s} s, {pulses} pulses, staggered {staggered}, {mechanism:?} {mode}: {db:.1} dB"
                        );
                        assert!(db < -85.0);
                    }
                }
            }
        }
    }

    #[test]
    fn phasors_are_cosines_and_sines() {
        for n in 0..2000 {
            let turns: [f32; GROUP] = std::array::from_fn(|i| (n * GROUP + i) as f32 / 16_000.0);
            let [cos, sin] = phasors(&turns);
            for i in 0..GROUP {
                let (s, c) = (TAU * f64::from(turns[i])).sin_cos();
                let off = (f64::from(cos[i]) - c).abs().max((f64::from(sin[i]) - s).abs());
                // Words of 24 bits: 1.8e-7 of each of half the angle, twice in a product of two.
                assert!(off < 1e-6, "{}: {off:e}", turns[i]);
            }
        }
    }
}
