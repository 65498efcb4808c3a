//! The mean Doppler of a block.

use super::BlockEcho;
use crate::fidelity::probe::points::{mean_rate, of_points};
use crate::paths::block::{NODES, Sample};
use crate::paths::list::ScattererPaths;
use crate::paths::{PathGenerator, Workspace};
use crate::pipeline::fault::PulseError;

impl BlockEcho {
    /// Mean Doppler of every pair over so many emissions from the first on, weighted by received power: of
    /// the sea's sample, and of targets and ships at [`of_points`] (of all of them where no window receives
    /// anything); rain as it is at a pulse.
    pub(super) fn mean_doppler(
        &self,
        generator: &PathGenerator,
        (first, count, of_rain): (u64, usize, u64),
        memory: &mut Workspace,
        samples: &[Sample],
        points: &mut [ScattererPaths],
        mean_hz: &mut Vec<f64>,
    ) -> Result<(), PulseError> {
        let of_pulses = if generator.point_count() > 0 { &of_points(count)[..] } else { &[] };
        for (pulse, points) in of_pulses.iter().zip(points.iter_mut()) {
            generator.points_of_mean(first + *pulse as u64, memory, points)?;
        }
        // Rain: all three as the middle one.
        let rain = &mut points[NODES - 1];
        generator.some_clutter_at(of_rain, (true, generator.far_sample()), memory, rain)?;
        let (rain, points) = (&points[NODES - 1], &points[..NODES - 1]);
        let facets = generator.facets() as f64;
        mean_hz.clear();
        for pair in 0..generator.pairs().len() {
            let sample = samples.get(pair).copied().unwrap_or_default();
            let of_facets = sample.received_power_w * facets;
            let opens_s = generator.pair_start_of(pair, of_rain)?;
            let share = |delay_s| generator.received_share(of_rain, opens_s, delay_s);
            let rates = generator.rates(rain, pair, share);
            let mut received = (3.0 * rates.0, 3.0 * rates.1);
            let mut all = received;
            for (pulse, points) in of_pulses.iter().zip(points.iter()) {
                let index = first + *pulse as u64;
                let opens_s = generator.pair_start_of(pair, index)?;
                let share = |delay_s| generator.received_share(index, opens_s, delay_s);
                for (sums, own) in [
                    (&mut received, generator.rates(points, pair, share)),
                    (&mut all, generator.rates(points, pair, |_| 1.0)),
                ] {
                    *sums = (sums.0 + own.0, sums.1 + own.1);
                }
            }
            let rate = mean_rate((of_facets, sample.mean_rate), received, all);
            mean_hz.push(self.synth.carrier_hz() * rate);
        }
        Ok(())
    }
}
