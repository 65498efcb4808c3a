//! The power of facets, breaking waves and rain over a run.
//!
//! It is that of [`PROFILE`] pulses spread over the run. A beam that passes over the patch between two of
//! them, or at an end of the run, would be missed, or taken for as long as the pulses lie apart. So both ends
//! are looked at, and where the power changes by more than [`STEEP`] from one pulse to the next, pulses
//! between them are added, at most as many again; each then stands for the part of the run about it.
//!
//! An antenna that scans passes over the patch again and again. Then many more pulses are looked at, and none
//! is added: each stands for as much of the run.
//!
//! A channel whose polarisation leaves with some pulses alone has the mean of all, as it is measured.

use super::{ErrorSampler, MOST_OF_EXACT, PROFILE, Powers, scattered_over, spread_over};
use crate::paths::block::probe::{Keep, Shadows};
use crate::radar::fault::RadarError;

/// How many times as many pulses are looked at where an antenna scans: its beam is seldom on the patch.
const SCANS: u64 = 6;
/// Ratio of the powers of two pulses that are too far apart.
const STEEP: f64 = 4.0;

/// A pulse of the profile.
struct Profiled {
    index: u64,
    /// Power by channel, mean over the polarisations that leave in turn.
    power: Powers,
    /// Of facets alone, and of all.
    of_facets: f64,
    total: f64,
}

impl ErrorSampler<'_> {
    /// Power over the run; shows the strongest pulse.
    pub(super) fn profile(&mut self) -> Result<u64, RadarError> {
        let scans = self.generator.scans();
        let count = if scans { SCANS * PROFILE } else { PROFILE }.min(self.pulses);
        let mut found = Vec::new();
        let spread: Vec<u64> = match scans {
            true => scattered_over(self.pulses, count, 1).collect(),
            false => spread_over(self.pulses, count, 1).collect(),
        };
        for (step, index) in spread.into_iter().enumerate() {
            found.push(self.profiled(index, (step == 0, count as f64))?);
        }
        let refined = !scans && self.refine(&mut found)?;
        // Each stands for what lies about it.
        let ends = |n: usize, found: &[Profiled]| {
            let between = |a: u64, b: u64| 0.5 * (a as f64 + b as f64 + 1.0);
            let from = n.checked_sub(1).map_or(0.0, |before| between(found[before].index, found[n].index));
            let to = found.get(n + 1).map_or(self.pulses as f64, |next| between(found[n].index, next.index));
            (to - from) / self.pulses as f64
        };
        let (mut strongest, mut most) = (self.points.loudest, 0.0);
        for (n, pulse) in found.iter().enumerate() {
            if pulse.of_facets > most {
                (strongest, most) = (pulse.index, pulse.of_facets);
            }
            let share = if refined { ends(n, &found) } else { 1.0 / count as f64 };
            self.power.iter_mut().zip(&pulse.power).for_each(|(mean, own)| *mean += share * own);
        }
        if scans {
            self.scanned = self.of_scan(&found)?;
        }
        let weight = self.sampled();
        let turns = self.generator.shares_of_pulses();
        let points = self.points.power.iter().zip(&turns);
        self.power.iter_mut().zip(points).for_each(|(mean, (own, share))| *mean += weight * share * own);
        Ok(strongest)
    }

    /// Power of the pulses of a profile, points included, the strongest first.
    fn of_scan(&mut self, found: &[Profiled]) -> Result<Vec<(u64, Powers)>, RadarError> {
        let weight = self.sampled();
        let mut all = Vec::with_capacity(found.len());
        for Profiled { index, power, .. } in found {
            let of_points = self.power_of_points(*index)?;
            let both = |(facets, points): (&f64, &f64)| facets + weight * points;
            all.push((*index, power.iter().zip(&of_points).map(both).collect::<Powers>()));
        }
        let total = |of: &(u64, Powers)| of.1.iter().sum::<f64>();
        all.sort_by(|a, b| total(b).total_cmp(&total(a)));
        Ok(all)
    }

    /// Looks at a pulse; of `count` spread over the run, `first` among them, or, without any, in between.
    fn profiled(&mut self, index: u64, (first, count): (bool, f64)) -> Result<Profiled, RadarError> {
        let patch = self.generator.patch_of(index)?;
        // The waves of the first stand for all.
        let keep = Keep { shadows: if first { Shadows::Find } else { Shadows::Keep }, surface: !first };
        let truths = self.illuminate(index, patch.as_ref(), keep)?;
        let [powers, worst] = self.powers(index, &truths)?;
        self.find_turning(&truths);
        self.omit(index, &truths, count > 0.0)?;
        if count > 0.0 {
            for (lanes, bin) in
                truths.iter().step_by(self.channels.len().max(1)).flat_map(|truth| &truth.runs)
            {
                self.gains[*bin] += lanes.len() as f64;
            }
        }
        let turns = self.generator.shares_of_pulses();
        let of_facets = powers.iter().sum();
        // What is found of a pulse is in all polarisations.
        let [broken, rain] = self.profile_exact(index, patch.as_ref(), &truths)?;
        let exact: Powers = broken.iter().zip(rain).map(|(broken, rain)| broken + rain).collect();
        let power: Powers = powers
            .iter()
            .zip(&exact)
            .zip(&turns)
            .map(|((own, exact), share)| (own + exact) * share)
            .collect();
        for ((highest, own), exact) in self.highest.iter_mut().zip(worst).zip(exact) {
            *highest = highest.max(own + MOST_OF_EXACT * exact);
        }
        Ok(Profiled { index, of_facets, total: power.iter().sum(), power })
    }

    /// Adds pulses where the power changes steeply; says whether there are any.
    fn refine(&mut self, found: &mut Vec<Profiled>) -> Result<bool, RadarError> {
        let before = found.len();
        let mean = found.iter().map(|pulse| pulse.total).sum::<f64>() / before.max(1) as f64;
        let steep = |a: &Profiled, b: &Profiled| {
            let most = a.total.max(b.total);
            most > mean && most > STEEP * a.total.min(b.total)
        };
        let last = self.pulses.saturating_sub(1);
        if found.first().is_some_and(|first| first.index > 0) {
            let own = self.profiled(0, (false, 0.0))?;
            if steep(&own, &found[0]) {
                found.insert(0, own);
            }
        }
        if found.last().is_some_and(|other| other.index < last) {
            let own = self.profiled(last, (false, 0.0))?;
            if steep(&own, &found[found.len() - 1]) {
                found.push(own);
            }
        }
        while found.len() < 2 * before {
            let between = found
                .windows(2)
                .enumerate()
                .filter(|(_, ends)| ends[1].index > ends[0].index + 1 && steep(&ends[0], &ends[1]));
            let adds =
                |ends: &[Profiled]| ends[0].total.max(ends[1].total) * (ends[1].index - ends[0].index) as f64;
            let Some((n, ends)) = between.max_by(|a, b| adds(a.1).total_cmp(&adds(b.1))) else { break };
            let middle = ends[0].index + (ends[1].index - ends[0].index) / 2;
            let own = self.profiled(middle, (false, 0.0))?;
            found.insert(n + 1, own);
        }
        Ok(found.len() > before)
    }
}
