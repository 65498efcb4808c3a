//! What windows receive of points at a pulse.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::line::Line;
use super::points::{Stretch, Variation};
use super::{ErrorSampler, Powers};
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;

impl ErrorSampler<'_> {
    /// Power of a channel of a pair, whose window opens then.
    pub(super) fn received_power(
        &self,
        index: u64,
        (pair, opens_s): (usize, f64),
        (line, paths, drawn): (&Line, &ScattererPaths, &Variation),
        channel: usize,
    ) -> f64 {
        let (delays_s, amplitude) = (&paths.delay_s[pair], &paths.amplitude[channel]);
        line.power(|n| {
            let received = self.generator.received_share(index, opens_s, delays_s[n]).sqrt();
            let received = received * drawn.of(n, pair);
            amplitude[n] * received * Complex64::cis(-TAU * self.radar.carrier_hz * delays_s[n])
        })
    }

    /// The most power that points have at any pulse of a stretch, by channel.
    pub(super) fn most_of(&self, stretch: &Stretch) -> Powers {
        let bounds = [self.deviations(), self.points.coherence];
        let mut highest = vec![0.0f64; self.radar.channels.len()];
        for ((own, lines), varied) in stretch.exact.iter().zip(&stretch.lines).zip(&stretch.most) {
            for (channel, pair) in self.generator.channel_pairs().iter().enumerate() {
                let modulus = |n: usize| own.amplitude[channel][n].norm() * varied.of(n, *pair);
                highest[channel] = highest[channel].max(lines[*pair].most(bounds, modulus));
            }
        }
        highest
    }

    /// How far the delay rate of a point is off the mean of its block. A beam that scans may show any of the
    /// points at the pulses of which the mean is taken: then off whichever is farthest.
    pub(super) fn off_mean(&self, rates: &[f64], point: usize, mean: f64) -> f64 {
        let own = rates[point];
        if !self.generator.scans() {
            return own - mean;
        }
        let finite = rates.iter().filter(|rate| rate.is_finite());
        finite.fold((own - mean).abs(), |most, rate| most.max((own - rate).abs()))
    }

    /// Raises what points leave at their strongest pulse in the stretches, by channel, to what that is at the
    /// strongest of all: a beam that scans may pass over them between two that are looked at.
    pub(super) fn raise_to_peaks(&mut self, worst: &mut [(u64, Powers)]) -> Result<(), RadarError> {
        if !self.generator.scans() {
            return Ok(());
        }
        let highest = self.points.highest.clone();
        let mut seen = vec![0.0f64; highest.len()];
        for n in 0..self.points.stretches.len() {
            let stretch = self.stretch(n)?;
            seen.iter_mut().zip(self.most_of(&stretch)).for_each(|(seen, most)| *seen = seen.max(most));
        }
        let ratio = |(highest, seen): (&f64, &f64)| if *seen > 0.0 { (highest / seen).max(1.0) } else { 1.0 };
        let missed: Vec<f64> = highest.iter().zip(&seen).map(ratio).collect();
        for (_, worst) in worst {
            worst.iter_mut().zip(&missed).for_each(|(worst, missed)| *worst *= missed);
        }
        Ok(())
    }

    /// Power of all points by channel, mean over the polarisations that leave in turn.
    pub(super) fn power_of_points(&mut self, index: u64) -> Result<Powers, RadarError> {
        let mut power = vec![0.0; self.radar.channels.len()];
        if self.generator.point_count() == 0 {
            return Ok(power);
        }
        let mut paths = self.no_points();
        let found = self.points_at(index, &mut paths)?;
        let drawn = self.variation(index, false)?;
        let shares = self.generator.shares_of_pulses();
        for (pair, channels) in self.channels.iter().enumerate() {
            let line = Line::new(&paths.delay_s[pair], self.cells_per_s);
            for &channel in channels {
                let window = (pair, found[pair].0);
                let own = self.received_power(index, window, (&line, &paths, &drawn), channel);
                power[channel] = shares[channel] * own;
            }
        }
        Ok(power)
    }
}
