//! What a run may leave out: facets that are weak, and tiles beyond the beams.
//!
//! A facet below a share of the mean power is left out of its tile, after its scattering was found; a tile
//! whose two-way gain stays below a cutoff is left out before. Either power is summed at every pulse of the
//! profile of a run, for a list of limits, as that of the worst of pulses like it
//! ([`worst`](crate::fidelity::worst)), and the largest limits whose power stays [`EACH_DB`] below the budget
//! are taken. What is both weak and beyond counts twice.

use super::{ErrorSampler, Powers, Truth, square};
use crate::fidelity::budget::Budget;
use crate::fidelity::sidelobe::NONE_DB;
use crate::fidelity::worst::Sum;
use crate::paths::block::{FEW, Least};
use crate::radar::fault::RadarError;

/// Power of a facet over the mean of all up to which it may be left out, dB: from 0 down.
const LEAST_STEP_DB: f64 = -5.0;
const LEASTS: usize = 22;
/// Cutoffs, dB below the peak of both antennas' gains.
const CUTOFFS_DB: [f64; 16] = [
    -10.0, -15.0, -20.0, -25.0, -30.0, -35.0, -40.0, -45.0, -50.0, -55.0, -60.0, -65.0, -70.0, -75.0, -80.0,
    NONE_DB,
];
/// Weak facets, and tiles beyond the beams, stay so far below the budget, dB.
const EACH_DB: f64 = 9.0;

/// What is left out for a budget.
#[derive(Clone, Debug)]
pub struct Omission {
    /// Power over the mean of a facet up to which one is left out, or a part of one.
    pub least_power: Least,
    /// Two-way gain over its peak below which tiles are left out, dB.
    pub cutoff_db: f64,
    /// Share of the facets that is spread, and of those beyond the beams, means over the run.
    pub kept: f64,
    pub beyond_share: f64,
    /// What is missing, by channel.
    pub power: Powers,
}

/// Sums for every limit.
pub(super) struct Omitted {
    cutoffs_db: Vec<f64>,
    leasts: [f64; LEASTS],
    /// Facets that are kept, and beyond the beams, by limit; and all.
    kept: Vec<f64>,
    beyond: Vec<f64>,
    facets: f64,
    /// `[limit][channel]`: power that is missing in the worst pulse.
    weak_power: Vec<Powers>,
    beyond_power: Vec<Powers>,
}

impl Omitted {
    pub fn new(channels: usize, asked_db: Option<f64>) -> Self {
        let cutoffs_db = asked_db.map_or_else(|| CUTOFFS_DB.to_vec(), |asked_db| vec![asked_db]);
        let powers = |limits: usize| vec![vec![0.0; channels]; limits];
        Self {
            leasts: leasts(),
            kept: vec![0.0; LEASTS],
            beyond: vec![0.0; cutoffs_db.len()],
            facets: 0.0,
            weak_power: powers(LEASTS),
            beyond_power: powers(cutoffs_db.len()),
            cutoffs_db,
        }
    }
}

/// Limits of weak facets, falling; the last one leaves out what is dark.
fn leasts() -> [f64; LEASTS] {
    std::array::from_fn(|n| if n + 1 < LEASTS { 10f64.powf(LEAST_STEP_DB * n as f64 / 10.0) } else { 0.0 })
}

impl ErrorSampler<'_> {
    /// Takes in a pulse; `counts`: one of those that stand for the run in equal shares.
    pub(super) fn omit(&mut self, index: u64, truths: &[Truth], counts: bool) -> Result<(), RadarError> {
        let (cells, share, deviations) = (self.cells_at(index)?, self.sampled(), self.deviations());
        let pairs = self.channels.len().max(1);
        let means_w: Vec<f64> =
            (0..pairs).map(|pair| mean_power(truths.iter().skip(pair).step_by(pairs))).collect();
        let leasts = self.omitted.leasts;
        // How many limits a power over the mean is not above.
        let at_most = |power: f64| leasts.partition_point(|least| power <= *least);
        let sums = |limits: usize| vec![vec![Sum::default(); self.power.len()]; limits];
        let (mut weak, mut beyond) = (sums(LEASTS), sums(self.omitted.cutoffs_db.len()));
        for tile in truths.chunks(pairs) {
            let strongest = |i: usize| {
                let of = |(truth, mean): (&Truth, &f64)| truth.strongest(i) / mean.max(f64::MIN_POSITIVE);
                tile.iter().zip(&means_w).map(of).fold(0.0, f64::max)
            };
            for ((lanes, _), gain) in tile[0].runs.iter().zip(&tile[0].gains) {
                let limits: Vec<usize> = lanes.clone().map(|i| at_most(strongest(i))).collect();
                let lost: Vec<usize> =
                    (0..LEASTS).map(|n| limits.iter().filter(|own| **own > n).count()).collect();
                let is_lost = |n: usize| lost[n] > lanes.len() / FEW;
                let gain_db = 20.0 * f64::from(*gain).log10();
                let cutoffs =
                    self.omitted.cutoffs_db.iter().filter(|cutoff_db| gain_db < **cutoff_db).count();
                for (truth, channels) in tile.iter().zip(&self.channels) {
                    let cell = cells.of(truth.delay_s[lanes.start]);
                    for (a, channel) in truth.amplitude.iter().zip(channels) {
                        let mut powers = [0.0; LEASTS + 1];
                        for (i, limit) in lanes.clone().zip(&limits) {
                            powers[*limit] +=
                                square(a, i) * f64::from(truth.factor[i]).powi(2) * truth.share[i];
                        }
                        let all: f64 = powers.iter().sum();
                        for sum in &mut beyond[..cutoffs] {
                            sum[*channel].add(all, cell);
                        }
                        let mut below = 0.0;
                        for n in (0..LEASTS).rev() {
                            below += powers[n + 1];
                            if is_lost(n) && below > 0.0 {
                                weak[n][*channel].add(below, cell);
                            }
                        }
                    }
                }
                weak.iter_mut().chain(&mut beyond).flatten().for_each(Sum::close);
                if counts {
                    let omitted = &mut self.omitted;
                    omitted.facets += lanes.len() as f64;
                    omitted.beyond[..cutoffs].iter_mut().for_each(|own| *own += lanes.len() as f64);
                    for (n, kept) in omitted.kept.iter_mut().enumerate() {
                        *kept += (lanes.len() - if is_lost(n) { lost[n] } else { 0 }) as f64;
                    }
                }
            }
        }
        let Omitted { weak_power, beyond_power, .. } = &mut self.omitted;
        for (of, sums) in weak_power.iter_mut().zip(weak).chain(beyond_power.iter_mut().zip(beyond)) {
            for (most, sum) in of.iter_mut().zip(sums) {
                *most = most.max(sum.worst(share, deviations));
            }
        }
        Ok(())
    }

    /// The most that a budget lets leave out.
    pub(in crate::fidelity) fn omission(&self, budget: &Budget) -> Omission {
        let Omitted { cutoffs_db, leasts, kept, beyond, facets, weak_power, beyond_power } = &self.omitted;
        let limit = budget.power * 10f64.powf(-EACH_DB / 10.0);
        let first = |powers: &[Powers]| powers.iter().position(|own| self.worst_ratio(own) <= limit);
        let of_facets = |count: f64| if *facets > 0.0 { count / facets } else { 0.0 };
        let cutoff =
            if cutoffs_db.len() == 1 { 0 } else { first(beyond_power).unwrap_or(cutoffs_db.len() - 1) };
        // All facets together do not matter where each is as weak as that.
        let safe = leasts.partition_point(|least| *least > budget.least_power);
        let weak = first(weak_power).unwrap_or(LEASTS - 1).min(safe);
        let parts = (self.generator.parts_of_tiles() + 1) as f64;
        let beyond_share = of_facets(beyond[cutoff]);
        let power = weak_power[weak].iter().zip(&beyond_power[cutoff]).map(|(weak, beyond)| weak + beyond);
        Omission {
            // Of parts nothing is known but that all of them together do not matter.
            least_power: Least { facet: leasts[weak], part: leasts[weak].min(budget.least_power / parts) },
            cutoff_db: cutoffs_db[cutoff],
            kept: of_facets(kept[weak]).min(1.0 - beyond_share),
            beyond_share,
            power: power.collect(),
        }
    }
}

/// Mean power of the facets of a pair as the window receives it, W.
fn mean_power<'a>(truths: impl Iterator<Item = &'a Truth>) -> f64 {
    let (mut sum, mut facets) = (0.0, 0);
    for truth in truths {
        sum += (0..truth.count).map(|i| truth.received(i)).sum::<f64>();
        facets += truth.count;
    }
    sum / facets.max(1) as f64
}
