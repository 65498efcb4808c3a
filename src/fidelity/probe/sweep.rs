//! What interpolation between instants of gain leaves.

use std::ops::Range;
use std::rc::Rc;

use super::{ErrorSampler, Place, Powers, TILES, runs_of, square};
use crate::fidelity::sidelobe::{Binned, Candidates};
use crate::fidelity::worst::Sum;
use crate::geometry::lanes::Row;
use crate::paths::block::probe::{Keep, Shadows};
use crate::paths::block::{
    Instants, Sidelobe, SlowTime, Tiers, gain_instants, gain_step, gain_weights, sidelobe_gain_pulses,
};
use crate::radar::fault::RadarError;

/// Most instants at which the gains of a block are found.
const MOST_GAINS: usize = 128;

/// What interpolation between instants of gain leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Swept {
    /// In the first and last interval of a block.
    pub end: Powers,
    /// Between the others.
    pub inner: Powers,
}

/// Sums over the sample at the probes of one step, the first of them in the first interval:
/// `[probe][channel]`, by gain.
type Probed = Vec<Vec<Binned>>;

/// `[close, sidelobe][step]`.
pub(super) type OfPlace = [Vec<Probed>; 2];

/// What steps of gain leave at all places, each tile taken as a mainlobe tile and as a sidelobe tile.
#[derive(Clone, Debug)]
pub struct Sweeps {
    /// Pulses from gain to gain: of mainlobe tiles, and the more that sidelobe tiles then have.
    steps: Vec<u64>,
    /// `[place][close, sidelobe][step]`.
    sea: Rc<Vec<OfPlace>>,
    /// Of points, steps and powers; panels of ships with the step of theirs.
    points: Vec<(u64, Powers)>,
    channels: usize,
    share: f64,
    deviations: f64,
}

impl Sweeps {
    /// Of mainlobe tiles with one of the steps, with sidelobe tiles by the threshold of a candidate: the
    /// worst of all places.
    pub fn swept(&self, gain_pulses: u64, candidates: &Candidates, candidate: usize) -> Swept {
        let none = vec![0.0f64; self.channels];
        let mut worst = Swept { end: none.clone(), inner: none };
        let at = |wanted: u64| self.steps.iter().position(|step| *step == wanted).unwrap_or(0);
        let (close, rough) = (at(gain_pulses), at(sidelobe_gain_pulses(gain_pulses as usize) as u64));
        for sea in self.sea.iter() {
            for channel in 0..self.channels {
                let of = |step: usize, sidelobe: bool, end: bool| {
                    let probes = sea[usize::from(sidelobe)][step]
                        .iter()
                        .enumerate()
                        .filter(|(probe, _)| (*probe == 0) == end);
                    probes
                        .map(|(_, probe)| self.worst(&probe[channel], candidates, candidate, sidelobe))
                        .fold(0.0, f64::max)
                };
                for (worst, end) in [(&mut worst.end, true), (&mut worst.inner, false)] {
                    let both = of(close, false, end) + of(rough, true, end);
                    worst[channel] = worst[channel].max(both);
                }
            }
        }
        if let Some((_, points)) = self.points.iter().find(|(step, _)| *step == gain_pulses) {
            for worst in [&mut worst.end, &mut worst.inner] {
                worst.iter_mut().zip(points).for_each(|(worst, own)| *worst += own);
            }
        }
        worst
    }

    fn worst(&self, of: &Binned, candidates: &Candidates, candidate: usize, sidelobe: bool) -> f64 {
        let mut sum = Sum::default();
        of.join_into(candidates, candidate, sidelobe, &mut sum);
        sum.worst(self.share, self.deviations)
    }
}

/// Gains and what they weigh, of one tile and pair.
struct Exact {
    gains: Vec<Row>,
    factor: Vec<Row>,
    amplitude: Vec<[Row; 2]>,
    delay_s: Vec<f64>,
    /// How much the window receives of each.
    share: Vec<f64>,
    /// As [`runs_of`] has them.
    runs: Vec<(Range<usize>, usize)>,
}

impl Exact {
    /// Square of what a facet's factor is off at an instant with a gain that was found, as it is received.
    fn off(&self, instant: usize, i: usize, found: f32) -> f64 {
        let exact = self.gains[instant][i];
        // Shadows and facets that turn away.
        let seen = if exact == 0.0 { 1.0 } else { self.factor[instant][i] / exact };
        f64::from((found - exact) * seen).powi(2) * self.share[i]
    }
}

impl ErrorSampler<'_> {
    /// What gains every so many pulses leave of the sample in blocks of a length, and what cubics between
    /// them leave of points. Blocks with less than six instants of gain leave more than long ones.
    ///
    /// # Errors
    /// A track that ends before the run.
    pub fn gains(&mut self, steps: &[u64], block_pulses: u64) -> Result<Sweeps, RadarError> {
        let mut all = steps.to_vec();
        all.extend(steps.iter().map(|step| sidelobe_gain_pulses(*step as usize) as u64));
        all.sort_unstable();
        all.dedup();
        let key = (all.clone(), block_pulses);
        let sea = match self.known.swept.get(&key) {
            Some(known) => known,
            None => {
                let places = 0..self.places.len();
                let found = places.map(|place| self.gains_of_sea(place, &all, block_pulses));
                let found = found.collect::<Result<Vec<_>, _>>()?;
                let numbers = found.iter().flatten().flatten().flatten().flatten().map(Binned::numbers).sum();
                self.known.swept.keep(key, found, numbers)
            }
        };
        let (share, deviations) = (self.sampled(), self.deviations());
        let of_points = |step: &u64| -> Option<(u64, Powers)> {
            let left = self.points().swept(*step)?;
            Some((*step, left.iter().map(|own| share * own).collect()))
        };
        let points = steps.iter().filter_map(of_points).collect();
        Ok(Sweeps { steps: all, sea, points, channels: self.radar.channels.len(), share, deviations })
    }

    fn gains_of_sea(
        &mut self,
        place: usize,
        steps: &[u64],
        block_pulses: u64,
    ) -> Result<OfPlace, RadarError> {
        let channels = self.radar.channels.len();
        let Place { first, patch } = self.places[place].clone();
        let (cells, longest) = (self.cells_at(first)?, self.longest());
        let (Some(patch), Some(tiles)) = (patch, &mut self.tiles) else {
            let none = vec![Vec::new(); steps.len()];
            return Ok([none.clone(), none]);
        };
        let pulses = block_pulses.clamp(1, longest).min(self.pulses - first) as usize;
        // Gains are found every so many pulses: steps and their halves are multiples of it.
        let fine = pulses.div_ceil(MOST_GAINS);
        let candidates = &self.candidates;
        let mut slow = SlowTime::default();
        self.generator.slow_time(first, pulses, &mut slow);
        // Between the first two instants, the second two, and in the middle.
        let instants_of = |step: u64| -> (usize, Vec<usize>) {
            let step = gain_step(pulses, step as usize);
            // Where every pulse has its gain nothing is left.
            let step = if fine > 1 && step > 1 { step.next_multiple_of(2 * fine) } else { step };
            (step, gain_instants(pulses, step).collect())
        };
        let probes: Vec<Vec<(usize, usize, [f32; 6])>> = steps
            .iter()
            .map(|&step| {
                let (step, places) = instants_of(step);
                let half = step / 2;
                let probes = [half, step + half, (pulses / 2).next_multiple_of(step) + half];
                let weights = |pulse: usize| {
                    let (from, weights) = gain_weights(&places, pulse, &slow);
                    (pulse, from, weights)
                };
                probes.into_iter().filter(|pulse| *pulse < pulses && step > 1).map(weights).collect()
            })
            .collect();
        let none = || -> Vec<Probed> {
            probes.iter().map(|probes| vec![vec![Binned::new(candidates); channels]; probes.len()]).collect()
        };
        let mut sums = [none(), none()];
        let (pairs, mut exact) = (self.channels.len(), Vec::new());
        let block = Instants::of_block(first, pulses, 1, fine);
        let hearing = self.generator.hearing(first)?;
        for (tier, sums) in sums.iter_mut().enumerate() {
            // Gains of sidelobe tiles as often, too, but with directions that are straight from end to
            // end of the block.
            let mut tiers = Tiers::new(block, (tier == 1).then_some(Sidelobe::everywhere(2)));
            tiers.sidelobe.iter_mut().for_each(|sidelobe| sidelobe.gain_pulses = fine);
            let keep =
                if tier == 0 { Keep::default() } else { Keep { shadows: Shadows::Keep, surface: true } };
            self.generator.sample_tiles(&tiers, &patch, TILES, keep, tiles, |sampled| {
                if tier == 0 {
                    let delays_s = &sampled.of.nodes()[0].paths.delay_s;
                    exact.push(Exact {
                        gains: sampled.gains.to_vec(),
                        factor: sampled.of.factor.iter().step_by(fine).copied().collect(),
                        amplitude: sampled.of.epochs()[0].rows(),
                        delay_s: delays_s.to_vec(),
                        share: delays_s.iter().map(|delay_s| hearing.share(sampled.pair, *delay_s)).collect(),
                        runs: runs_of(sampled, candidates),
                    });
                }
                let (own, exact) =
                    (&self.channels[sampled.pair], &exact[sampled.tile * pairs + sampled.pair]);
                for ((step, probes), sums) in steps.iter().zip(&probes).zip(sums.iter_mut()) {
                    let (_, places) = instants_of(*step);
                    for ((pulse, from, weights), sum) in probes.iter().zip(sums) {
                        for (lanes, bin) in &exact.runs {
                            for i in lanes.clone() {
                                let rows = places[*from..].iter().zip(weights);
                                let found: f32 =
                                    rows.map(|(place, w)| w * sampled.gains[place.div_ceil(fine)][i]).sum();
                                let off = exact.off(*pulse / fine, i, found);
                                let cell = cells.of(exact.delay_s[i]);
                                for (channel, a) in own.iter().zip(&exact.amplitude) {
                                    sum[*channel].0[*bin].add(square(a, i) * off, cell);
                                }
                            }
                            own.iter().for_each(|channel| sum[*channel].0[*bin].close());
                        }
                    }
                }
            })?;
        }
        Ok(sums)
    }
}
