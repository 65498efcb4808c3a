//! Breaking waves and rain, whose paths are found exactly at every pulse: so only the echo errs about them.
//!
//! They come and go, and a few may have much of a pulse's power far off its mean Doppler. So their error is
//! that of each pulse of the profile, with phases at their worst, and not that of the mean power:
//!
//! `e = max over pulses of W(sum over n of |a_n|^2 left(f_n - f0)) / mean power` ,
//!
//! `left` what Doppler off the mean leaves of a pulse, `f0` the mean Doppler of facets and rain at that
//! pulse, and `W` the worst of many pulses ([`worst`](crate::fidelity::worst)).

use num_complex::Complex64;

use super::{ErrorSampler, Law, Powers, Truth};
use crate::fidelity::worst::Sum;
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;
use crate::scene::Patch;

/// Share of the power of a pulse's rain and breaking waves below which one of them is left out.
const LEAST: f64 = 1e-6;

/// One of them at a pulse, as a channel receives it.
#[derive(Clone, Copy)]
struct Term {
    pair: u16,
    channel: u16,
    cell: u32,
    hz: f32,
    power: f32,
}

/// Those of a pulse, and the mean Doppler of every pair, Hz.
pub(super) struct ExactPulse {
    terms: Vec<Term>,
    means_hz: Vec<f64>,
}

impl ErrorSampler<'_> {
    /// Breaking waves of a pulse, seen as its sample is, and its rain, as the window receives them.
    fn exact(&mut self, index: u64, patch: Option<&Patch>) -> Result<[ScattererPaths; 2], RadarError> {
        let empty = || ScattererPaths::new(self.channels.len(), self.radar.channels.len(), 0);
        let mut both = [empty(), empty()];
        let [breakers, rain] = &mut both;
        if let (Some(patch), Some(tiles), true) =
            (patch, &mut self.tiles, self.generator.breakers_alive() > 0.0)
        {
            self.generator.breakers((index, 0), patch, tiles, &mut self.memory, breakers)?;
        }
        let some = (true, self.generator.far_sample());
        self.generator.some_clutter_at(index, some, &mut self.memory, rain)?;
        let hearing = self.generator.hearing(index)?;
        for paths in &mut both {
            for (channel, pair) in self.generator.channel_pairs().iter().enumerate() {
                for (a, delay_s) in paths.amplitude[channel].iter_mut().zip(&paths.delay_s[*pair]) {
                    *a *= hearing.share(*pair, *delay_s).sqrt();
                }
            }
        }
        Ok(both)
    }

    /// Their powers by channel, as those of a sample as small as that of the facets; keeps them. `truths` is
    /// the sample of the facets.
    pub(super) fn profile_exact(
        &mut self,
        index: u64,
        patch: Option<&Patch>,
        truths: &[Truth],
    ) -> Result<[Powers; 2], RadarError> {
        let (both, weight, cells) = (self.exact(index, patch)?, self.sampled(), self.cells_at(index)?);
        let of = |column: &Vec<Complex64>| weight * column.iter().map(Complex64::norm_sqr).sum::<f64>();
        let powers = both.each_ref().map(|paths| paths.amplitude.iter().map(of).collect::<Powers>());
        let (carrier_hz, pairs) = (self.radar.carrier_hz, self.channels.len());
        let mut terms = Vec::new();
        let mut sums = vec![(0.0, 0.0); pairs];
        for (n, truth) in truths.iter().enumerate() {
            let (power, weighted) = &mut sums[n % pairs];
            for (i, own) in (0..truth.count).map(|i| (i, truth.received(i))).filter(|(_, own)| *own > 0.0) {
                (*power, *weighted) = (*power + own, *weighted + own * carrier_hz * truth.rate[i]);
            }
        }
        let least = LEAST * powers.iter().flatten().sum::<f64>();
        for (paths, rains) in both.iter().zip([false, true]) {
            for (channel, &pair) in self.generator.channel_pairs().iter().enumerate() {
                for (n, a) in paths.amplitude[channel].iter().enumerate() {
                    let power = weight * a.norm_sqr();
                    if power.is_nan() || power <= least {
                        continue;
                    }
                    let hz = carrier_hz * paths.delay_rate[pair][n];
                    if rains {
                        sums[pair] = (sums[pair].0 + power, sums[pair].1 + power * hz);
                    }
                    let cell = cells.of(paths.delay_s[pair][n]) as u32;
                    terms.push(Term {
                        pair: pair as u16,
                        channel: channel as u16,
                        cell,
                        hz: hz as f32,
                        power: power as f32,
                    });
                }
            }
        }
        if !terms.is_empty() {
            let means_hz = sums.iter().map(|(power, weighted)| weighted / power.max(f64::MIN_POSITIVE));
            self.exact_pulses.push(ExactPulse { terms, means_hz: means_hz.collect() });
        }
        Ok(powers)
    }

    /// What Doppler within a pulse leaves of them in the worst pulse, over the mean power of all.
    pub fn doppler_of_exact(&self, law: &Law) -> f64 {
        let (mut worst, deviations) = (vec![0.0f64; self.power.len()], self.deviations());
        for pulse in &self.exact_pulses {
            let mut sums = vec![Sum::default(); self.power.len()];
            for Term { pair, channel, cell, hz, power } in &pulse.terms {
                let off_hz = (f64::from(*hz) - pulse.means_hz[usize::from(*pair)]).abs();
                let sum = &mut sums[usize::from(*channel)];
                sum.add(f64::from(*power) * law.root(off_hz).powi(2), *cell as usize);
                sum.close();
            }
            for (worst, sum) in worst.iter_mut().zip(&sums) {
                *worst = worst.max(sum.worst_of_like(1.0, deviations));
            }
        }
        self.worst_ratio(&worst)
    }

    /// Adds the Doppler of the breaking waves and the rain of a pulse to that of facets.
    pub(super) fn add_exact_at(&mut self, index: u64, patch: Option<&Patch>) -> Result<(), RadarError> {
        let (both, weight) = (self.exact(index, patch)?, self.sampled());
        for (paths, (pair, n)) in both.iter().flat_map(|paths| {
            let of = |(pair, rates): (usize, &Vec<f64>)| (0..rates.len()).map(move |n| (pair, n));
            paths.delay_rate.iter().enumerate().flat_map(of).map(move |at| (paths, at))
        }) {
            let of = |channel: &usize| paths.amplitude[*channel][n].norm_sqr();
            let power = weight * self.channels[pair].iter().map(of).sum::<f64>();
            if power > 0.0 {
                let rate = paths.delay_rate[pair][n];
                self.dopplers.push((pair, self.radar.carrier_hz * rate, power));
                self.fastest = self.fastest.max(rate.abs());
            }
        }
        Ok(())
    }
}
