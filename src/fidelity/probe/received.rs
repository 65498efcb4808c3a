//! What windows receive of points at a pulse.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::line::Line;
use super::points::Variation;
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
