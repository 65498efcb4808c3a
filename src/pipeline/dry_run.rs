//! A dry run of what is planned: pulses as they will be made, against the same pulses from exact scatterer
//! paths.
//!
//! What a plan predicts is a statistic of many facets, and it is the worst pulse that is promised. On a small
//! patch few facets decide: one that turns away between two nodes, one behind a crest, one in a null of its
//! scattering. No sample shows which. But such a patch is cheap: so its pulses are made before anything is
//! promised, and where they miss what is asked, finer settings are tried, then pulses one by one, then f64.
//!
//! ```text
//! error = max over pulses and channels of |planned - exact|^2 / mean |exact|^2  +  finest grid + Doppler within the pulse + rounding
//! ```
//!
//! Exact are scatterer paths found at every pulse, spread in f64 by the widest kernel; Doppler within a pulse
//! is of both alike, so that part stays as the plan predicts it. Where all pulses were made, the error found
//! is the prediction; where there is time for a part of them alone, it only raises the prediction. How many
//! are made depends on the scene alone: [`FACET_PULSES`].

use std::collections::BTreeSet;
use std::sync::Arc;

use num_complex::Complex32;

use super::engines;
use super::overheard::{segment_apart, shares, steadiness};
use super::stages::PulseFactory;
use crate::echo::Asked;
use crate::fidelity::DryRun;
use crate::fidelity::budget::{EXACT_DB, Plan};
use crate::fidelity::choose::Chooser;
use crate::fidelity::probe::spread_over;
use crate::paths::PathGenerator;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::fault::PulseError;
use crate::pipeline::power::{least_mean, mean_of, power, powers};
use crate::pulse::Samples;
use crate::radar::waveform::Waveform;
use crate::scene::front_end::FrontEnd;
use crate::scene::{Radar, Scene};

/// Facets, and cells of the far sea, times pairs times pulses that are made, at most: some 0.15 s of one
/// core.
const FACET_PULSES: u64 = 1 << 17;
/// Fewer pulses say nothing.
const LEAST_PULSES: u64 = 8;
/// Settings that are tried in blocks.
const TRIES: u32 = 5;
/// How much finer than what was missed the next settings are, dB.
const CLOSER_DB: f64 = 3.0;
/// How far below what is asked exact pulses are, dB: long pulses are then made in fewer bands of Doppler.
const FINER_DB: f64 = 40.0;
/// How far below what is asked pulses one by one are tried before exact ones, dB.
const HALFWAY_DB: f64 = 15.0;
/// What exact scatterer paths on the finest grid are themselves off the reference, and other instructions
/// round otherwise, dB.
const MORE_DB: f64 = 1.0;
/// Pulses before and after one that show the level of errors there.
const NEIGHBOURS: usize = 2;
/// No tail is taken to be lighter than this: the top of a level lies between the pulses made.
const LIGHTEST_TAIL: f64 = 0.2;
/// Heavier tails than this mean that too few pulses were made to know.
const HEAVIEST_TAIL: f64 = 1.5;
/// Pulses of a tail, at least; and the heaviest that fewer than ten times as many can show, since the others,
/// some of them at nodes, are then no part of it. Such few are made of a thousand facets and more, of which
/// none decides alone.
const LEAST_TAIL: usize = 4;
const OF_FEW: f64 = 0.5;

/// The settings of a scene for every one of some errors, tried where that costs little, where a mixer leaves
/// so much of the power of echoes.
pub(crate) fn plans(
    scene: &Scene,
    generator: &PathGenerator,
    waveform: &Arc<dyn Waveform>,
    mixed: f64,
    asked: &[Asked],
) -> Result<Vec<Plan>, BuildErrors> {
    let Some(first) = asked.first() else { return Ok(Vec::new()) };
    let mut chooser = Chooser::new(scene, generator, waveform, first)?;
    asked.iter().map(|asked| plan(&mut chooser, scene, generator, waveform, (asked, mixed))).collect()
}

fn plan(
    chooser: &mut Chooser<'_>,
    scene: &Scene,
    generator: &PathGenerator,
    waveform: &Arc<dyn Waveform>,
    (asked, mixed): (&Asked, f64),
) -> Result<Plan, BuildErrors> {
    // A pulse is judged by the mean of all, of which few may receive anything.
    let received = match generator.is_apart() {
        true => shares(generator, generator)?.received,
        false => mixed,
    };
    let share = received * steadiness(scene, waveform.as_ref());
    let finer = |error_db: f64| (error_db + 10.0 * share.log10()).max(EXACT_DB.min(error_db));
    let choose = |chooser: &mut Chooser<'_>, error_db: f64, node_pulses: Option<u64>| {
        let plan = chooser.choose(&Asked { error_db: finer(error_db), node_pulses, ..*asked })?;
        let prediction = plan.prediction.over_share(share);
        Ok::<_, BuildErrors>(Plan { asked: *asked, prediction, ..plan })
    };
    let first = choose(chooser, asked.error_db, asked.node_pulses)?;
    let block = first.chosen.block_pulses(generator.hold_pulses());
    let chosen = Chosen::of(scene, generator, block, chooser.scanned());
    let exact = asked.node_pulses.map_or(asked.error_db <= EXACT_DB, |pulses| pulses <= 1);
    if exact || (chosen.pulses.len() as u64) < LEAST_PULSES {
        return Ok(first);
    }
    let exact = (asked.error_db - FINER_DB).max(EXACT_DB);
    let exact = Asked { node_pulses: Some(1), ..Asked::error_db(finer(exact)) };
    let exact = chooser.choose(&exact)?;
    let exact = Plan { prediction: exact.prediction.over_share(share), ..exact };
    let Some(trial) = Trial::new(scene, generator, waveform, chosen, &exact)? else { return Ok(first) };
    let trial = Trial { mixed, ..trial };
    let (mut tried, mut target_db) = (first, asked.error_db);
    let mut best: Option<Plan> = None;
    let mut tries = 0;
    while tries < TRIES {
        tries += 1;
        let Some(found) = trial.judged(tried, tries)? else { return Ok(first) };
        if found.keeps() {
            return Ok(found);
        }
        if best.is_none_or(|held| found.prediction.total() < held.prediction.total()) {
            best = Some(found);
        }
        let missed_db = found.prediction.total_db() - asked.error_db;
        // The same settings again say the same again.
        let next = loop {
            target_db -= missed_db.clamp(0.0, 20.0) + CLOSER_DB;
            if target_db <= EXACT_DB {
                break None;
            }
            let next = choose(chooser, target_db, asked.node_pulses)?;
            if next.chosen != tried.chosen {
                break Some(next);
            }
        };
        match next {
            Some(next) if next.chosen.node_pulses > 1 => tried = next,
            _ => break,
        }
    }
    let best = best.unwrap_or(first);
    if asked.node_pulses.is_some() {
        return Ok(best);
    }
    for error_db in [asked.error_db, asked.error_db - HALFWAY_DB, EXACT_DB] {
        let plan = choose(chooser, error_db.max(EXACT_DB), Some(1))?;
        // The same settings again say the same again.
        if plan.chosen == tried.chosen {
            continue;
        }
        (tried, tries) = (plan, tries + 1);
        let Some(found) = trial.judged(plan, tries)? else { return Ok(plan) };
        if found.keeps() {
            return Ok(found);
        }
    }
    Ok(best)
}

/// Pulses that are made, rising.
struct Chosen {
    pulses: Vec<u64>,
    /// Those of them that are spread over the run.
    spread: Vec<bool>,
    all: bool,
    /// Where an antenna scans, power by channel of these pulses in the mean, over that of all of the run.
    over_run: Option<Vec<f64>>,
}

impl Chosen {
    fn of(
        scene: &Scene,
        generator: &PathGenerator,
        block: u64,
        (scanned, of_run): (&[(u64, Vec<f64>)], &[f64]),
    ) -> Self {
        let cells = generator.far_cells().map_or(0.0, |(cells, _)| cells) as usize;
        let each = ((generator.facets() + cells) * generator.pairs().len()) as u64;
        let count = FACET_PULSES.checked_div(each).unwrap_or(0);
        let all = generator.receiving_pulses();
        if all <= count {
            let spread = vec![true; all as usize];
            return Self { pulses: (0..all).collect(), spread, all: true, over_run: None };
        }
        // A beam that is seldom on the patch: the strongest of many that were looked at.
        if !scanned.is_empty() {
            let mut strongest = scanned[..scanned.len().min(count as usize)].to_vec();
            strongest.sort_unstable_by_key(|(index, _)| *index);
            let mean = |channel: usize| {
                strongest.iter().map(|(_, power)| power[channel]).sum::<f64>() / strongest.len().max(1) as f64
            };
            let over = |(channel, of_run): (usize, &f64)| mean(channel) / of_run.max(f64::MIN_POSITIVE);
            let over_run = of_run.iter().enumerate().map(over).collect();
            let pulses: Vec<u64> = strongest.iter().map(|(index, _)| *index).collect();
            return Self { spread: vec![true; pulses.len()], pulses, all: false, over_run: Some(over_run) };
        }
        // Half of them all over the run; a block at its begin, and its end, where the last block is cut
        // short.
        let cycle = scene.radar.cycle();
        let spread: BTreeSet<u64> = spread_over(all, count / 2, cycle).collect();
        let ends = (count / 4).min(block);
        let pulses: BTreeSet<u64> = spread.iter().copied().chain(0..ends).chain(all - ends..all).collect();
        let of_run = pulses.iter().map(|pulse| spread.contains(pulse)).collect();
        Self { pulses: pulses.into_iter().collect(), spread: of_run, all: false, over_run: None }
    }
}

/// Some pulses from exact scatterer paths, and what makes them otherwise.
struct Trial<'a> {
    scene: &'a Scene,
    /// Without noise and converter.
    radar: Radar,
    generator: &'a PathGenerator,
    waveform: &'a Arc<dyn Waveform>,
    chosen: Chosen,
    exact: Vec<Vec<Complex32>>,
    /// Mean power of each channel over the run.
    means: Vec<f64>,
    /// What the finest grid leaves, a ratio of powers.
    own: f64,
    /// What a mixer leaves of the power of echoes.
    mixed: f64,
}

impl<'a> Trial<'a> {
    /// `None` where scatterer paths cannot be followed.
    fn new(
        scene: &'a Scene,
        generator: &'a PathGenerator,
        waveform: &'a Arc<dyn Waveform>,
        chosen: Chosen,
        exact: &Plan,
    ) -> Result<Option<Self>, BuildErrors> {
        let radar =
            Radar { noise_figure_db: None, adc: None, front_end: FrontEnd::default(), ..scene.radar.clone() };
        let (samples, means) = (Vec::new(), Vec::new());
        let own = exact.prediction.echo.gridding;
        let mut trial =
            Self { scene, radar, generator, waveform, chosen, exact: samples, means, own, mixed: 1.0 };
        let Some(samples) = trial.samples(exact)? else { return Ok(None) };
        let channels = trial.radar.channels.len();
        let spread = samples.iter().zip(&trial.chosen.spread).filter(|(_, spread)| **spread);
        let found: Vec<Vec<f64>> = spread.map(|(pulse, _)| powers(pulse, channels)).collect();
        trial.means = (0..channels).map(|channel| mean_of(&found, channel)).collect();
        for (mean, over) in trial.means.iter_mut().zip(trial.chosen.over_run.iter().flatten()) {
            *mean /= over.max(f64::MIN_POSITIVE);
        }
        // Of blocks of samples few may receive anything, and none of those spread over the run.
        if generator.is_apart() && trial.means.contains(&0.0) {
            return Ok(None);
        }
        trial.exact = samples;
        Ok(Some(trial))
    }

    /// The pulses by a plan.
    fn samples(&self, plan: &Plan) -> Result<Option<Vec<Vec<Complex32>>>, BuildErrors> {
        let (scene, radar) = (self.scene, &self.radar);
        let segment = || segment_apart(Some(plan), scene, self.generator, self.waveform.as_ref());
        let segment = self.generator.is_apart().then(segment);
        let echo = engines::engine(Some(plan), radar, segment, self.generator, self.waveform)?;
        let (generator, waveform) = (self.generator.clone(), Arc::clone(self.waveform));
        let factory = PulseFactory::new((echo, None), (scene, radar), generator, waveform);
        let (mut slot, mut worker) = (factory.slot(), factory.worker());
        let mut samples = Vec::with_capacity(self.chosen.pulses.len());
        for &index in &self.chosen.pulses {
            match worker.make(index, &mut slot) {
                Ok(()) => {}
                Err(PulseError::Unplaced { .. }) => return Ok(None),
                Err(error) => return Err(error.into()),
            }
            // There is no converter.
            if let Samples::Cf32(own) = &slot.samples {
                samples.push(own.clone());
            }
        }
        Ok(Some(samples))
    }

    /// Error of a pulse, a ratio of powers: the worst channel in which anything is received.
    fn error(&self, made: &[Complex32], exact: &[Complex32]) -> f64 {
        let len = exact.len() / self.means.len().max(1);
        let channels = made.chunks_exact(len).zip(exact.chunks_exact(len)).zip(&self.means);
        let least = least_mean(&self.means);
        let of_channel = channels.map(|((made, exact), mean)| {
            let off: Vec<Complex32> = made.iter().zip(exact).map(|(a, b)| a - b).collect();
            let off = power(&off);
            if *mean <= least && off <= least { 0.0 } else { off / mean }
        });
        of_channel.fold(0.0, f64::max)
    }

    /// A plan with what its pulses have; `tries` is how many settings were tried with it.
    fn judged(&self, mut plan: Plan, tries: u32) -> Result<Option<Plan>, BuildErrors> {
        let Some(samples) = self.samples(&plan)? else { return Ok(None) };
        let errors: Vec<f64> = samples.iter().zip(&self.exact).map(|(a, b)| self.error(a, b)).collect();
        let found = worst_of_run(
            &errors,
            if self.chosen.all { None } else { Some(self.generator.receiving_pulses()) },
        );
        let prediction = &mut plan.prediction;
        let both = self.own + prediction.echo.doppler + prediction.echo.rounding;
        let found = found / self.mixed * 10f64.powf(0.1 * MORE_DB) + both;
        let error = if self.chosen.all { found } else { found.max(prediction.modelled()) };
        let pulses = self.chosen.pulses.len() as u64;
        prediction.dry_run = Some(DryRun { pulses, all: self.chosen.all, tries, error });
        Ok(Some(plan))
    }
}

/// Largest error of the pulses of a run, of which some are known, in their order; of all of them without a
/// number of pulses.
///
/// What is not known goes by a Pareto law, whose largest of `N` is `(N/n)^g` times that of `n`. Its index `g`
/// is Hill's, `mean ln(x/x_k)` over the largest, of each error over the largest of its [`NEIGHBOURS`] before
/// and after it. Of pulses that are alike that has the same index as the errors themselves. Where the level
/// changes along the run, as over the wake of a ship, errors themselves would give the few on top of it an
/// index that none of them has: known is the top already.
fn worst_of_run(errors: &[f64], of: Option<u64>) -> f64 {
    let worst = errors.iter().copied().max_by(f64::total_cmp).unwrap_or(0.0);
    let mut above: Vec<f64> = (0..errors.len()).filter_map(|n| above_neighbours(errors, n)).collect();
    above.sort_by(|a, b| b.total_cmp(a));
    let tail = (above.len() / 10).max(LEAST_TAIL);
    let heaviest = if above.len() < 10 * LEAST_TAIL { OF_FEW } else { HEAVIEST_TAIL };
    let (Some(pulses), Some(&least)) = (of, above.get(tail)) else { return worst };
    if least <= 0.0 || !worst.is_finite() {
        return worst;
    }
    let index = above[..tail].iter().map(|above| (above / least).ln()).sum::<f64>() / tail as f64;
    worst * (pulses as f64 / errors.len() as f64).max(1.0).powf(index.clamp(LIGHTEST_TAIL, heaviest))
}

/// An error over the largest of its neighbours; `None` where these are 0.
fn above_neighbours(errors: &[f64], n: usize) -> Option<f64> {
    let (before, after) = (&errors[n.saturating_sub(NEIGHBOURS)..n], errors[n..].iter().skip(1));
    let largest = before.iter().chain(after.take(NEIGHBOURS)).copied().fold(0.0, f64::max);
    (largest > 0.0).then(|| errors[n] / largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_of_a_longer_run() {
        // Quantiles of a Pareto law of index 0.5, one far from the next: the worst of 100 times as many is 10
        // times as large. 200 of them know the index to some 0.5/sqrt(20), a factor of 1.7.
        let rank = |n: u32| f64::from(n * 61 % 200);
        let errors: Vec<f64> = (0..200).map(|n| ((rank(n) + 0.5) / 200.0).powf(-0.5)).collect();
        let most = worst_of_run(&errors, None);
        assert_eq!(most, 20.0);
        let found = worst_of_run(&errors, Some(20_000)) / most;
        assert!((6.0..17.0).contains(&found), "{found}");
        // Of a few, some of them at nodes, the smaller ones are no part of a tail.
        let few =
            [-63.0, -90.0, -64.0, -95.0, -61.0, -66.0, -88.0, -62.0].map(|db: f64| 10f64.powf(0.1 * db));
        let found_db = 10.0 * worst_of_run(&few, Some(500)).log10();
        assert!((-61.0..-51.0).contains(&found_db), "{found_db}");
        // All alike, none, nothing.
        assert_eq!(worst_of_run(&[2.0; 50], Some(1000)), 2.0 * 20f64.powf(LIGHTEST_TAIL));
        assert_eq!((worst_of_run(&[0.0; 50], Some(1000)), worst_of_run(&[], Some(9))), (0.0, 0.0));
    }

    /// A patch of 64 x 64 m that follows an aircraft and passes over the wake of a ship: errors, dB, of every
    /// 625th pulse of 10,000.
    #[test]
    fn a_level_that_changes_along_the_run_is_no_heavy_tail() {
        let errors_db = [
            -86.7, -87.1, -87.2, -84.3, -86.9, -84.7, -78.2, -76.8, -76.0, -82.4, -87.9, -88.2, -87.1, -88.6,
            -86.5, -86.4,
        ];
        let errors = errors_db.map(|db: f64| 10f64.powf(0.1 * db));
        let found_db = 10.0 * worst_of_run(&errors, Some(10_000)).log10();
        assert!((-76.0..-66.0).contains(&found_db), "{found_db}");
    }
}
