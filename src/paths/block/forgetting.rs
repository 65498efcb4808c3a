//! Facets that forget their phases, over a block: what turns the amplitudes of a mechanism at every pulse.
//!
//! Amplitudes at the scattering epochs are those of phasors of 1, and so as slow as frozen ones. The phasor
//! of a facet and mechanism is a sum of waves of fixed frequency ([`crate::scattering::speckle`]), which is
//! found at every pulse. Mechanisms turn each by their own, so a tile is handed over once for each of them.
//!
//! Waves are drawn once a facet, and kept for as many mechanisms as [`ROOM_BYTES`] hold; those of others are
//! drawn again for every block.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::TAU;

use crate::cpu::Task;
use crate::scattering::bragg::block::{Phasors, Times, phasors};
use crate::scattering::bragg::group::GROUP;
use crate::scattering::speckle::{WAVES, Wave};
use crate::scattering::water::WaterScattering;

/// What waves of facets may take of a worker's memory.
pub const ROOM_BYTES: usize = 64 << 20;
/// Bytes of the waves of a facet and mechanism.
pub const FACET_BYTES: usize = size_of::<[Wave; WAVES]>();
/// Pulses from one phase in f64 to the next: turning leaves 1e-6 each.
const LONGEST: usize = 64;
/// Waves that turn side by side: a step waits for the one before.
const TOGETHER: usize = 4;
const _: () = assert!(WAVES.is_multiple_of(TOGETHER));

/// The waves of a mechanism, at the keys of their facets modulo the patch.
#[derive(Clone)]
struct Held {
    mechanism: usize,
    keys: Vec<Option<[i64; 2]>>,
    waves: Vec<[Wave; WAVES]>,
}

/// Waves of the facets at hand.
#[derive(Clone, Default)]
pub(super) struct Forgetting {
    held: Vec<Held>,
}

impl Forgetting {
    /// Waves of a mechanism of up to [`GROUP`] facets.
    pub fn waves(
        &mut self,
        of: &WaterScattering,
        mechanism: usize,
        keys: &[[i64; 2]],
        facets: [usize; 2],
    ) -> GroupWaves {
        let [nx, ny] = facets;
        let at = self.held.iter().position(|held| held.mechanism == mechanism);
        let at = at.or_else(|| {
            let most = ROOM_BYTES / (nx * ny * FACET_BYTES).max(1);
            (self.held.len() < most).then(|| {
                let none = [Wave::default(); WAVES];
                self.held.push(Held { mechanism, keys: vec![None; nx * ny], waves: vec![none; nx * ny] });
                self.held.len() - 1
            })
        });
        let mut group = GroupWaves { omega_radps: [[0.0; GROUP]; WAVES], turns: [[0.0; GROUP]; WAVES] };
        // Facets of a row follow one another: few of them are looked up.
        let mut next: Option<([i64; 2], [usize; 2])> = None;
        for (i, &key) in keys.iter().enumerate().take(GROUP) {
            let [column, row] = match next {
                Some((own, place)) if own == key => place,
                _ => [key[0].rem_euclid(nx as i64) as usize, key[1].rem_euclid(ny as i64) as usize],
            };
            next = Some(([key[0] + 1, key[1]], [if column + 1 < nx { column + 1 } else { 0 }, row]));
            let drawn;
            let own = match at {
                None => {
                    drawn = of.waves(key, mechanism);
                    &drawn
                }
                Some(at) => {
                    let held = &mut self.held[at];
                    let place = row * nx + column;
                    if held.keys[place] != Some(key) {
                        held.keys[place] = Some(key);
                        held.waves[place] = of.waves(key, mechanism);
                    }
                    &held.waves[place]
                }
            };
            for (w, wave) in own.iter().enumerate() {
                (group.omega_radps[w][i], group.turns[w][i]) = (wave.omega_radps, wave.turns);
            }
        }
        group
    }
}

/// Waves of a group of facets, `[wave][facet]`.
pub(super) struct GroupWaves {
    omega_radps: [[f64; GROUP]; WAVES],
    /// At pulse 0.
    turns: [[f64; GROUP]; WAVES],
}

/// Phasors of a group of facets at every pulse.
pub(super) struct SumWaves<'a> {
    pub waves: &'a GroupWaves,
    pub times: Times<'a>,
    pub out: &'a mut [Phasors],
}

impl Task for SumWaves<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { waves, times, out } = self;
        out.fill([[0.0; GROUP]; 2]);
        let (to_start, to_next) = (times.first_s / TAU, times.interval_s / TAU);
        let scale = 1.0 / (WAVES as f32).sqrt();
        let (mut at, mut next) = ([[0.0f64; GROUP]; WAVES], [[0.0f64; GROUP]; WAVES]);
        for w in 0..WAVES {
            for i in 0..GROUP {
                let omega_radps = waves.omega_radps[w][i];
                (at[w][i], next[w][i]) = (omega_radps * to_start + waves.turns[w][i], omega_radps * to_next);
            }
        }
        let mut turns = [0.0f32; GROUP];
        if !times.uneven.is_empty() {
            // Every pulse by itself: none is a step from the one before.
            for (at, next) in at.iter().zip(&next) {
                for ([re, im], after) in out.iter_mut().zip(times.uneven) {
                    for i in 0..GROUP {
                        let now = at[i] + after * next[i];
                        turns[i] = (now - now.floor()) as f32;
                    }
                    let [cos, sin] = phasors(&turns);
                    for i in 0..GROUP {
                        re[i] += scale * cos[i];
                        im[i] += scale * sin[i];
                    }
                }
            }
            return;
        }
        for (at, next) in at.as_chunks::<TOGETHER>().0.iter().zip(next.as_chunks::<TOGETHER>().0) {
            let mut steps = [[[0.0f32; GROUP]; 2]; TOGETHER];
            for (step, next) in steps.iter_mut().zip(next) {
                for i in 0..GROUP {
                    turns[i] = (next[i] - next[i].floor()) as f32;
                }
                *step = phasors(&turns);
            }
            let mut before = 0;
            for out in out.chunks_mut(LONGEST) {
                let mut now = [[[0.0f32; GROUP]; 2]; TOGETHER];
                for ((now, at), next) in now.iter_mut().zip(at).zip(next) {
                    for i in 0..GROUP {
                        let own = at[i] + before as f64 * next[i];
                        turns[i] = (own - own.floor()) as f32;
                    }
                    let [cos, sin] = phasors(&turns);
                    for i in 0..GROUP {
                        (now[0][i], now[1][i]) = (scale * cos[i], scale * sin[i]);
                    }
                }
                for sum in &mut *out {
                    add_and_turn(sum, &mut now, &steps);
                }
                before += out.len();
            }
        }
    }
}

/// Adds waves to a sum, and turns each by its step.
#[inline(always)]
fn add_and_turn(sum: &mut Phasors, now: &mut [Phasors; TOGETHER], steps: &[Phasors; TOGETHER]) {
    let [mut re, mut im] = *sum;
    for w in 0..TOGETHER {
        let ([cos, sin], [cos_step, sin_step]) = (now[w], &steps[w]);
        for i in 0..GROUP {
            re[i] += cos[i];
            im[i] += sin[i];
            now[w][0][i] = cos[i] * cos_step[i] - sin[i] * sin_step[i];
            now[w][1][i] = cos[i] * sin_step[i] + sin[i] * cos_step[i];
        }
    }
    *sum = [re, im];
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::cpu::Variant;
    use crate::scattering::speckle::Speckle;

    /// A block is the process of the reference at every pulse, early and late, at equal intervals and not.
    #[test]
    fn a_block_is_the_reference() {
        let (seed, speckle) = (5, Speckle::Decorrelating { time_s: 0.05 });
        let keys: Vec<(i64, i64)> = (0..13).map(|n| (n, 3 - 2 * n)).collect();
        for variant in Variant::ALL.into_iter().filter(|variant| variant.is_available()) {
            for (first_s, pulses) in [(0.0, 1), (3.5, 33), (3600.0, 150)] {
                for staggered in [false, true] {
                    let at: Vec<f64> = (0..pulses).map(|n| n as f64 + 0.3 * (n % 3) as f64).collect();
                    let uneven: &[f64] = if staggered { &at } else { &[] };
                    let times = Times { first_s, interval_s: 0.004, uneven };
                    for mechanism in 0..2 {
                        let mut waves =
                            GroupWaves { omega_radps: [[0.0; GROUP]; WAVES], turns: [[0.0; GROUP]; WAVES] };
                        for (i, key) in keys.iter().enumerate() {
                            for (w, wave) in speckle.waves(seed, *key, mechanism).iter().enumerate() {
                                (waves.omega_radps[w][i], waves.turns[w][i]) = (wave.omega_radps, wave.turns);
                            }
                        }
                        let mut out = vec![[[7.0; GROUP]; 2]; pulses];
                        variant.run(SumWaves { waves: &waves, times, out: &mut out });
                        let (mut off, mut power) = (0.0, 0.0);
                        for (pulse, [re, im]) in out.iter().enumerate() {
                            let after = uneven.get(pulse).copied().unwrap_or(pulse as f64);
                            for (n, key) in keys.iter().enumerate() {
                                let mut exact = [Complex64::ZERO; 2];
                                speckle.phasors(seed, *key, first_s + 0.004 * after, &mut exact);
                                let exact = exact[mechanism];
                                off += (f64::from(re[n]) - exact.re).powi(2)
                                    + (f64::from(im[n]) - exact.im).powi(2);
                                power += exact.norm_sqr();
                            }
                        }
                        // Turning leaves 1e-6 a pulse, of each wave: -84 dB after 64.
                        let db = 10.0 * (off / power).log10();
                        println!("{variant} {first_s} s, {pulses} pulses, staggered {staggered}: {db:.1} dB");
                        assert!(db < -84.0, "{db}");
                    }
                }
            }
        }
    }
}
