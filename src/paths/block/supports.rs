//! Supports: the pulses at which a tile is evaluated where pulses lie closer than it changes.
//!
//! With the phase of its middle taken out, what a tile returns is band-limited in slow time: its facets
//! differ in Doppler by far less than they have. At a PRF far above this bandwidth a tile is evaluated at
//! some pulses of the block alone, its **supports**, which lie closer at both ends of the block. What it
//! returns at a pulse `t` is the sum over the nearest [`TAPS`] of them,
//!
//! ```text
//! s(t) = sum_k w_k s(t_k) ,   (R + eps I) w = r ,   R_kl = sinc(B (t_k - t_l)) ,   r_k = sinc(B (t - t_k))
//! ```
//!
//! with `B` the bandwidth: of all sums that of least mean square error where the spectrum is flat over `B`.
//! It leaves `1 - 2 w.r + w.R w` of the power of the tile, at every pulse no more than what is asked.

use super::slow_time::SlowTime;

/// Supports from which a pulse is found.
pub const TAPS: usize = 10;
/// Pulses from support to support, inside of a block, on average.
const STEPS: [f64; 17] =
    [64.0, 48.0, 36.0, 27.0, 20.0, 16.0, 12.5, 10.0, 8.0, 6.5, 5.2, 4.2, 3.4, 2.8, 2.3, 1.9, 1.6];
/// What keeps the equations regular: of the power, far below what f32 leaves.
const REGULAR: f64 = 1e-11;
/// What of the bandwidth is taken where intervals differ.
const OF_UNEVEN: f64 = 0.85;
/// Share of the pulses that supports may be: more save nothing.
const MOST_SUPPORTS: f64 = 0.7;

/// Supports of a block, some pulses apart, and how pulses follow from them.
#[derive(Clone, Debug, Default)]
pub struct Supports {
    /// Bandwidth up to which they serve, cycles a mean interval.
    bandwidth: f64,
    /// Their pulses, rising, the first and the last of the block among them.
    pulses: Vec<usize>,
    /// Slow time of these.
    at: Vec<f64>,
    /// Of every pulse: the first of its supports, and the weights.
    taps: Vec<(usize, [f32; TAPS])>,
}

impl Supports {
    /// Pulses of the supports.
    pub fn pulses(&self) -> &[usize] {
        &self.pulses
    }

    /// Slow time of the supports.
    pub fn at(&self) -> &[f64] {
        &self.at
    }

    /// The first support of a pulse, and the weights from there on.
    pub fn taps(&self, pulse: usize) -> (usize, &[f32; TAPS]) {
        let (first, weights) = &self.taps[pulse];
        (*first, weights)
    }

    /// Places supports in a block, on average no more than so many pulses apart and closer at its ends; says
    /// whether there are enough of them, and few enough.
    fn place(&mut self, pulses: usize, step: f64, slow: &SlowTime) -> bool {
        self.pulses.clear();
        let (last, mut before) = (pulses.saturating_sub(1), 0);
        loop {
            self.pulses.push(before);
            let gap = self.pulses.len();
            if gap as f64 >= step || 2 * (before + gap) > last {
                break;
            }
            before += gap;
        }
        let (from_end, between) = (self.pulses.len(), last - 2 * before);
        let gaps = (between as f64 / step).ceil() as usize;
        for n in 1..gaps {
            // From the nearer end, so that both halves are alike.
            let own = (n.min(gaps - n) as f64 * between as f64 / gaps as f64).round() as usize;
            self.pulses.push(if 2 * n <= gaps { before + own } else { last - before - own });
        }
        for n in (0..from_end).rev() {
            let mirrored = last - self.pulses[n];
            if self.pulses.last().is_some_and(|held| *held < mirrored) {
                self.pulses.push(mirrored);
            }
        }
        self.at.clear();
        self.at.extend(self.pulses.iter().map(|pulse| slow.at(*pulse)));
        self.pulses.len() >= TAPS && (self.pulses.len() as f64) < MOST_SUPPORTS * pulses as f64
    }

    /// Finds the weights of so many pulses for a bandwidth; returns the most that a pulse lacks of the power.
    fn weigh(&mut self, pulses: usize, bandwidth: f64, slow: &SlowTime) -> f64 {
        self.bandwidth = bandwidth;
        self.taps.clear();
        let mut most = 0.0f64;
        for pulse in 0..pulses {
            let after = self.pulses.partition_point(|support| *support <= pulse);
            let first = after.saturating_sub(TAPS / 2).min(self.pulses.len() - TAPS);
            let (weights, lacks) = weights(&self.at[first..], slow.at(pulse), bandwidth);
            most = most.max(lacks);
            self.taps.push((first, weights.map(|weight| weight as f32)));
        }
        most
    }
}

/// Weights of [`TAPS`] instants at another, and what that lacks of the power.
fn weights(at: &[f64], t: f64, bandwidth: f64) -> ([f64; TAPS], f64) {
    let mut lower = [[0.0; TAPS]; TAPS];
    let mut right = [0.0; TAPS];
    for k in 0..TAPS {
        right[k] = sinc(bandwidth * (t - at[k]));
        for l in 0..=k {
            lower[k][l] = sinc(bandwidth * (at[k] - at[l]));
        }
        lower[k][k] += REGULAR;
    }
    let covariance = lower;
    // Cholesky, in place.
    for k in 0..TAPS {
        for l in 0..=k {
            let (above, rest) = lower.split_at(k);
            let row = above.get(l).unwrap_or(&rest[0]);
            let sum = rest[0][l] - (0..l).map(|m| rest[0][m] * row[m]).sum::<f64>();
            lower[k][l] = if l == k { sum.max(REGULAR * REGULAR).sqrt() } else { sum / lower[l][l] };
        }
    }
    let mut weights = right;
    for k in 0..TAPS {
        let sum: f64 = (0..k).map(|l| lower[k][l] * weights[l]).sum();
        weights[k] = (weights[k] - sum) / lower[k][k];
    }
    for k in (0..TAPS).rev() {
        let sum: f64 = (k + 1..TAPS).map(|l| lower[l][k] * weights[l]).sum();
        weights[k] = (weights[k] - sum) / lower[k][k];
    }
    let mut lacks = 1.0;
    for k in 0..TAPS {
        let of = |l: usize| weights[l] * if l <= k { covariance[k][l] } else { covariance[l][k] };
        lacks += weights[k] * ((0..TAPS).map(of).sum::<f64>() - 2.0 * right[k]);
    }
    (weights, lacks.max(0.0))
}

fn sinc(x: f64) -> f64 {
    let angle = std::f64::consts::PI * x;
    if angle.abs() < 1e-8 { 1.0 } else { angle.sin() / angle }
}

/// Supports of a block for tiles of any bandwidth.
#[derive(Clone, Debug, Default)]
pub struct SupportSets {
    /// From far to close.
    sets: Vec<Supports>,
    /// How many are in use.
    count: usize,
    /// Of equal intervals: pulses, what may be lacking, and the bandwidth of every step (0 for none).
    known: Option<(usize, f64, [f64; STEPS.len()])>,
    /// Whether those at hand are of equal intervals.
    even: bool,
    /// Those of the tile at hand; `None`: it is evaluated at every pulse.
    chosen: Option<usize>,
}

impl SupportSets {
    /// None: every pulse is evaluated.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// For a block of so many pulses, leaving no more than `loss` of the power of a tile.
    pub fn set(&mut self, pulses: usize, loss: f64, slow: &SlowTime) {
        let even = slow.uneven().is_empty();
        let known = self.known.filter(|(of, least, _)| *of == pulses && *least == loss);
        if let (Some(_), true, true) = (known, even, self.even && self.count > 0) {
            return;
        }
        let bandwidths = known.map_or_else(|| self.bandwidths(pulses, loss), |(_, _, known)| known);
        self.known = Some((pulses, loss, bandwidths));
        (self.count, self.even) = (0, even);
        for (step, bandwidth) in STEPS.into_iter().zip(bandwidths).filter(|(_, bandwidth)| *bandwidth > 0.0) {
            let of = if even { bandwidth } else { OF_UNEVEN * bandwidth };
            let set = self.next();
            if set.place(pulses, step, slow) && set.weigh(pulses, of, slow) <= loss {
                self.count += 1;
            }
        }
    }

    /// The widest bandwidth of each step, of equal intervals.
    fn bandwidths(&mut self, pulses: usize, loss: f64) -> [f64; STEPS.len()] {
        let (slow, mut found) = (SlowTime::default(), [0.0; STEPS.len()]);
        let mut before = 0;
        for (step, widest) in STEPS.into_iter().zip(&mut found) {
            self.count = 0;
            let set = self.next();
            // In short blocks far supports are all the same.
            let placed = set.place(pulses, step, &slow);
            if !placed || set.pulses.len() == before {
                continue;
            }
            before = set.pulses.len();
            let [mut low, mut high] = [0.0, 1.0 / step];
            for _ in 0..8 {
                let middle = 0.5 * (low + high);
                // What is left mirrors what is before the middle.
                let lacks = set.weigh((2 * pulses).div_ceil(3), middle, &slow);
                if lacks <= loss { low = middle } else { high = middle }
            }
            *widest = low;
        }
        found
    }

    fn next(&mut self) -> &mut Supports {
        if self.count == self.sets.len() {
            self.sets.push(Supports::default());
        }
        &mut self.sets[self.count]
    }

    /// The farthest supports for a bandwidth, cycles a mean interval.
    pub fn for_bandwidth(&self, bandwidth: f64) -> Option<usize> {
        self.sets[..self.count].iter().position(|set| bandwidth <= set.bandwidth)
    }

    /// Some of them.
    pub fn get(&self, place: usize) -> Option<&Supports> {
        self.sets[..self.count].get(place)
    }

    /// Gives the tile at hand some of them, or none.
    pub fn choose(&mut self, place: Option<usize>) {
        self.chosen = place;
    }

    /// Those of the tile at hand, where it is not evaluated at every pulse.
    pub fn chosen(&self) -> Option<&Supports> {
        self.get(self.chosen?)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Tones anywhere in the band come out at every pulse, with equal intervals and with a stagger, and no
    /// more is lacking than was asked.
    #[test]
    fn tones_within_the_band_are_found_at_every_pulse() {
        let loss = 1e-7;
        for pulses in [64, 193] {
            for staggered in [false, true] {
                let times =
                    (0..pulses).map(|n| n as f64 + if staggered { 0.1 * (n % 3) as f64 } else { 0.0 });
                let slow = if staggered { SlowTime::of(times.collect()) } else { SlowTime::default() };
                let mut sets = SupportSets::default();
                sets.set(pulses, loss, &slow);
                assert!(sets.count > 0, "{pulses}");
                for set in &sets.sets[..sets.count] {
                    assert_eq!((set.pulses[0], set.pulses[set.pulses.len() - 1]), (0, pulses - 1));
                    let tones = 100;
                    let mut worst = vec![0.0f64; pulses];
                    for tone in 0..tones {
                        let cycles = set.bandwidth * ((f64::from(tone) + 0.5) / f64::from(tones) - 0.5);
                        for (pulse, worst) in worst.iter_mut().enumerate() {
                            let (first, weights) = set.taps(pulse);
                            let exact = TAU * cycles * slow.at(pulse);
                            let (mut re, mut im) = (-exact.cos(), -exact.sin());
                            for (k, weight) in weights.iter().enumerate() {
                                let own = TAU * cycles * set.at[first + k];
                                re += f64::from(*weight) * own.cos();
                                im += f64::from(*weight) * own.sin();
                            }
                            *worst += (re * re + im * im) / f64::from(tones);
                        }
                    }
                    let worst = worst.into_iter().fold(0.0, f64::max);
                    println!("{pulses} {staggered} {:.3}: worst {worst:.1e}", set.bandwidth);
                    // A sum in place of the integral, steep at the ends of the band.
                    assert!(worst < 1.1 * loss, "{worst}");
                }
            }
        }
    }

    #[test]
    fn far_supports_serve_narrow_bands_alone() {
        let mut sets = SupportSets::default();
        sets.set(400, 1e-7, &SlowTime::default());
        let steps: Vec<f64> = sets.sets[..sets.count].iter().map(|set| set.bandwidth).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        let narrow = sets.get(sets.for_bandwidth(0.01).unwrap()).unwrap();
        let wide = sets.get(sets.for_bandwidth(0.25).unwrap()).unwrap();
        assert!(narrow.pulses.len() < 60 && wide.pulses.len() > 150);
        assert_eq!(sets.for_bandwidth(0.5), None);
        // A block of few pulses has none.
        sets.set(12, 1e-7, &SlowTime::default());
        assert_eq!(sets.for_bandwidth(0.0), None);
    }
}
