//! The error of an echo, measured against the reference echo of the same run.
//!
//! ```text
//! error = max over pulses and channels of  ||fast - ref|| / sqrt( mean over the run of ||ref||^2 in that channel )
//! ```
//!
//! over samples before noise and converter, `||.||` the root of the sum of squares over a window. The mean
//! error takes the mean of the squares over pulses and channels. Channels in which nothing is received at
//! all, and nothing should be, do not count; nor does what rounding of f64 leaves of the strongest channel in
//! one that has no more than that.
//!
//! The mean over the run is that of all its pulses where the reference makes them all; else of [`OF_POINTS`]
//! pulses spread evenly over it, or [`OF_SEA`] of a scene with a sea, each by itself, of an echo within -40
//! dB of the reference (0.1 dB of the mean), and at least what the pulses of the reference add to a run that
//! is silent otherwise. Where scatterer paths cannot be followed, and only the reference makes them, the mean
//! is that of the pulses drawn.
//!
//! Pulses are drawn from the seed of the scene, one from each of so many equal parts of the run, by turns the
//! first, the last and the middle one of a block and any other: [`sample`].
//!
//! The figures are held within [`LEAST_DB`] and its opposite: samples are f32, and -150 dB is what that
//! can resolve; bit-identical samples are reported as [`LEAST_DB`].

use crate::pipeline::power::{least_mean, mean_of, of_channel, powers};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use num_complex::Complex32;
use rand::{Rng, RngExt};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use crate::config::Run;
use crate::echo::{Asked, Fidelity};
use crate::fidelity::budget::Plan;
use crate::fidelity::probe::{scattered_over, spread_over};
use crate::pipeline::build::{self, PulseStream};
use crate::pipeline::changing;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::fault::PulseError;
use crate::pipeline::memory::available_bytes;
use crate::pipeline::memory::sea_bytes;
use crate::pipeline::prepared::Prepared;
use crate::pipeline::stages::PulseFactory;
use crate::pulse::Samples;
use crate::rng::{Room, stream};
use crate::scene::front_end::FrontEnd;

/// What no difference at all is reported as, dB; twice the bits of an f64 lie above.
pub const LEAST_DB: f64 = -400.0;

/// Pulses of which the mean power is taken, without a sea and with one.
pub const OF_POINTS: u64 = 4096;
/// The same with a sea.
pub const OF_SEA: u64 = 64;
/// Error of the echo that it is taken of, dB.
const OF_POWER_DB: f64 = -40.0;

/// An error as measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// Worst pulse and channel, dB.
    pub rel_rms_db: f64,
    /// Mean over pulses and channels, dB.
    pub rel_rms_db_mean: f64,
    /// The pulse of the worst.
    pub worst_pulse: u64,
    /// Its channel.
    pub worst_channel: usize,
    /// The worst of each channel, dB; `None` where there is nothing to receive.
    pub channel_db: Vec<Option<f64>>,
}

/// Some pulses of a run as the reference makes them.
pub struct Judge {
    pulses: Vec<u64>,
    samples: Vec<Vec<Complex32>>,
    /// Mean power of each channel over the run.
    means: Vec<f64>,
    threads: usize,
    pulses_per_s: f64,
    /// What the run has in common with those that are judged.
    prepared: Arc<Prepared>,
}

/// The same run without noise and converter, with an ideal front end, and without sinks.
pub fn noiseless(run: &Run) -> Run {
    let mut run = run.clone();
    run.scene.radar.noise_figure_db = None;
    run.scene.radar.adc = None;
    run.scene.radar.front_end = FrontEnd::default();
    run.calibration.clear();
    run.sinks.clear();
    run
}

/// Draws `count` pulses of a run of `pulses`, or all where it has no more; in their order.
pub fn sample(seed: u64, pulses: u64, block_pulses: u64, count: u64) -> Vec<u64> {
    if count >= pulses {
        return (0..pulses).collect();
    }
    let mut numbers = stream(seed, Room::SampledPulses, 0, 0);
    let block = block_pulses.max(1);
    let mut chosen = BTreeSet::new();
    let begin = |part: u64| (u128::from(pulses) * u128::from(part) / u128::from(count)) as u64;
    for part in 0..count {
        let any = any_of(&mut numbers, begin(part), begin(part + 1));
        let first = any - any % block;
        let last = first.saturating_add(block - 1).min(pulses - 1);
        let wanted = match part % 4 {
            0 => first,
            1 => last,
            2 => first + (last - first) / 2,
            _ => any,
        };
        if !chosen.insert(wanted) {
            chosen.insert(any);
        }
    }
    // Parts shorter than a block may have met in one pulse.
    while (chosen.len() as u64) < count {
        chosen.insert(any_of(&mut numbers, 0, pulses));
    }
    chosen.into_iter().collect()
}

/// A number from `from` to before `to`.
fn any_of(numbers: &mut impl Rng, from: u64, to: u64) -> u64 {
    numbers.random_range(from..to.max(from + 1))
}

/// A ratio of powers in dB, within what is reported.
fn decibels(ratio: f64) -> f64 {
    (10.0 * ratio.log10()).clamp(LEAST_DB, -LEAST_DB)
}

impl Judge {
    /// Makes the reference of some pulses of a run, as many at once as `threads` and memory allow. `passed`
    /// is reported how many are done.
    ///
    /// # Errors
    /// A run that cannot be built, or a pulse that cannot be made.
    pub fn new(
        run: &Run,
        pulses: Vec<u64>,
        threads: usize,
        passed: impl Fn(usize) + Sync,
    ) -> Result<Self, BuildErrors> {
        Self::of(Arc::new(Prepared::of(run)?), pulses, threads, &passed)
    }

    /// The same of a run that is prepared.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn of(
        prepared: Arc<Prepared>,
        pulses: Vec<u64>,
        threads: usize,
        passed: &(dyn Fn(usize) + Sync),
    ) -> Result<Self, BuildErrors> {
        let run = prepared.run();
        let factory = factory_for(&prepared, run, &Fidelity::Reference)?;
        let one = sea_bytes(&run.scene, &Fidelity::Reference, 1).max(1);
        let fit = available_bytes().map_or(threads, |bytes| usize::try_from(bytes / one).unwrap_or(threads));
        let workers = threads.min(fit).max(1);
        let begun = Instant::now();
        let samples = make(&factory, &pulses, workers, passed, <[_]>::to_vec)?;
        let pulses_per_s = pulses.len() as f64 / begun.elapsed().as_secs_f64().max(f64::MIN_POSITIVE);
        let channels = factory.layout().channels;
        drop(factory);
        let found: Vec<Vec<f64>> = samples.iter().map(|pulse| powers(pulse, channels)).collect();
        let all =
            if pulses.len() as u64 == run.scene.pulses { None } else { over_the_run(&prepared, threads)? };
        let means = match all {
            Some(all) => (0..channels)
                .map(|channel| {
                    let received = found.iter().map(|pulse| pulse[channel]).sum::<f64>();
                    mean_of(&all, channel).max(received / run.scene.pulses.max(1) as f64)
                })
                .collect(),
            None => (0..channels).map(|channel| mean_of(&found, channel)).collect(),
        };
        Ok(Self { pulses, samples, means, threads, pulses_per_s, prepared })
    }

    /// The pulses.
    pub fn pulses(&self) -> &[u64] {
        &self.pulses
    }

    /// Pulses per second that the reference made.
    pub fn pulses_per_s(&self) -> f64 {
        self.pulses_per_s
    }

    /// The error of a run's own echo: the same scene, another fidelity.
    ///
    /// # Errors
    /// A run that cannot be built, or a pulse that cannot be made.
    pub fn judge(&self, run: &Run) -> Result<Accuracy, BuildErrors> {
        self.judge_with_plan(run).map(|(accuracy, _)| accuracy)
    }

    /// The same, and what was planned for the fast echo.
    ///
    /// # Errors
    /// As [`Self::judge`].
    pub fn judge_with_plan(&self, run: &Run) -> Result<(Accuracy, Option<Plan>), BuildErrors> {
        let factory = factory_for(&self.prepared, run, &run.fidelity)?;
        Ok((self.accuracy(&self.make(&factory)?), factory.plan().copied()))
    }

    /// A run without noise and converter, ready to start.
    pub(crate) fn stream(&self, run: &Run) -> Result<PulseStream, BuildErrors> {
        build::again(&self.prepared, &noiseless(run), 0..run.scene.pulses)
    }

    /// The pulses as a factory without noise and converter makes them.
    pub(crate) fn make(&self, factory: &PulseFactory) -> Result<Vec<Vec<Complex32>>, PulseError> {
        make(factory, &self.pulses, self.threads, &|_| (), <[_]>::to_vec)
    }

    /// The error of samples, `[pulse][channel x sample]`.
    pub(crate) fn accuracy(&self, found: &[Vec<Complex32>]) -> Accuracy {
        compare(&self.pulses, &self.means, found, &self.samples)
    }

    /// How far two sets of samples are apart, as an error of the first.
    pub(crate) fn apart(&self, found: &[Vec<Complex32>], from: &[Vec<Complex32>]) -> Accuracy {
        compare(&self.pulses, &self.means, found, from)
    }
}

/// Powers of pulses spread over a run, `[pulse][channel]`; `None` where only the reference can make them.
fn over_the_run(prepared: &Prepared, threads: usize) -> Result<Option<Vec<Vec<f64>>>, BuildErrors> {
    let run = prepared.run();
    let asked = Asked { node_pulses: Some(1), ..Asked::error_db(OF_POWER_DB) };
    let factory = factory_for(prepared, run, &Fidelity::Fast(asked))?;
    let count = if factory.facets() > 0 { OF_SEA } else { OF_POINTS }.min(run.scene.pulses);
    let cycle = run.scene.radar.cycle();
    let pulses: Vec<u64> = match factory.generator().scans() {
        true => scattered_over(run.scene.pulses, count, cycle).collect(),
        false => spread_over(run.scene.pulses, count, cycle).collect(),
    };
    let channels = factory.layout().channels;
    match make(&factory, &pulses, threads, &|_| (), |samples| powers(samples, channels)) {
        Ok(powers) => Ok(Some(powers)),
        Err(PulseError::Unplaced { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// The error of `found` against `reference`, `[pulse][channel x sample]`, relative to the mean powers of the
/// channels.
fn compare(
    pulses: &[u64],
    means: &[f64],
    found: &[Vec<Complex32>],
    reference: &[Vec<Complex32>],
) -> Accuracy {
    let channels = means.len();
    let mut accuracy = Accuracy {
        rel_rms_db: LEAST_DB,
        rel_rms_db_mean: LEAST_DB,
        worst_pulse: pulses.first().copied().unwrap_or(0),
        worst_channel: 0,
        channel_db: vec![None; channels],
    };
    let (mut sum, mut terms, least) = (0.0, 0u32, least_mean(means));
    for (channel, &mean) in means.iter().enumerate() {
        let of = |pulse: &[Complex32]| of_channel(channel, channels, pulse.len());
        for ((found, reference), index) in found.iter().zip(reference).zip(pulses) {
            let apart: f64 = found[of(found)]
                .iter()
                .zip(&reference[of(reference)])
                .map(|(a, b)| {
                    (f64::from(a.re) - f64::from(b.re)).powi(2) + (f64::from(a.im) - f64::from(b.im)).powi(2)
                })
                .sum();
            if mean <= least && apart <= least {
                continue;
            }
            let ratio = apart / mean;
            sum += ratio;
            terms += 1;
            let db = decibels(ratio);
            let held = &mut accuracy.channel_db[channel];
            *held = Some(held.map_or(db, |held| held.max(db)));
            if db > accuracy.rel_rms_db {
                (accuracy.rel_rms_db, accuracy.worst_pulse, accuracy.worst_channel) = (db, *index, channel);
            }
        }
    }
    if terms > 0 {
        accuracy.rel_rms_db_mean = decibels(sum / f64::from(terms));
    }
    accuracy
}

/// A factory for a run without noise and converter, much like one that is prepared.
fn factory_for(known: &Prepared, run: &Run, fidelity: &Fidelity) -> Result<PulseFactory, BuildErrors> {
    changing::factory_for(&known.again(&noiseless(run))?, fidelity)
}

/// What is kept of the samples, `[channel x sample]`, of pulses that stand in their order: blocks go to
/// whoever is free.
fn make<T: Send>(
    factory: &PulseFactory,
    pulses: &[u64],
    threads: usize,
    passed: &(dyn Fn(usize) + Sync),
    keep: impl Fn(&[Complex32]) -> T + Sync,
) -> Result<Vec<T>, PulseError> {
    let block = factory.block_pulses();
    let groups: Vec<&[u64]> = pulses.chunk_by(|a, b| a / block == b / block).collect();
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let (mut slot, mut worker) = (factory.slot(), factory.worker());
        let mut made = Vec::new();
        while let Some(group) = groups.get(next.fetch_add(1, Ordering::Relaxed)) {
            for &index in *group {
                worker.make(index, &mut slot)?;
                let kept = match &slot.samples {
                    Samples::Cf32(samples) => keep(samples),
                    // Not made here: runs are without converter.
                    Samples::Ci16(codes) => {
                        let of = |[re, im]: &[i16; 2]| Complex32::new(f32::from(*re), f32::from(*im));
                        keep(&codes.iter().map(of).collect::<Vec<_>>())
                    }
                };
                made.push((index, kept));
                passed(done.fetch_add(1, Ordering::Relaxed) + 1);
            }
        }
        Ok::<_, PulseError>(made)
    };
    let workers = threads.clamp(1, groups.len().max(1));
    let parts: Vec<_> = match ThreadPoolBuilder::new().num_threads(workers).build() {
        Ok(pool) => pool.install(|| (0..workers).into_par_iter().map(|_| work()).collect()),
        // A machine that gives no threads gives this one.
        Err(_) => vec![work()],
    };
    let mut made = Vec::with_capacity(pulses.len());
    for part in parts {
        made.append(&mut part?);
    }
    made.sort_by_key(|(index, _)| *index);
    Ok(made.into_iter().map(|(_, kept)| kept).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn samples_have_ends_and_middles_of_blocks() {
        let chosen = sample(7, 500, 10, 16);
        assert_eq!(chosen.len(), 16);
        for place in [0, 9, 4] {
            assert!(chosen.iter().filter(|index| *index % 10 == place).count() >= 4, "{place}: {chosen:?}");
        }
        assert_eq!(chosen, sample(7, 500, 10, 16));
        assert_ne!(chosen, sample(8, 500, 10, 16));
        assert!(chosen[0] < 50 && chosen[15] >= 450, "{chosen:?}");
    }

    proptest! {
        #![proptest_config(crate::rng::cases::proptests(256))]

        #[test]
        fn samples_are_pulses_of_the_run(
            seed: u64, pulses in 0u64..2000, block in 0u64..100, count in 0u64..64, long: bool,
        ) {
            let pulses = if long { u64::MAX - pulses } else { pulses };
            let chosen = sample(seed, pulses, block, count);
            prop_assert_eq!(chosen.len() as u64, count.min(pulses));
            prop_assert!(chosen.is_sorted_by(|a, b| a < b));
            prop_assert!(chosen.iter().all(|index| *index < pulses));
        }
    }

    #[test]
    fn the_error_is_relative_to_the_rms_over_the_run() {
        // Two pulses of two channels, two samples each. The first channel has powers 2 and 6: rms 4 over the
        // run. It is off by 0.1 in one sample of the weak pulse: 0.01/4, not 0.01/2. The second channel is
        // silent and right.
        let c = |re: f32| Complex32::new(re, 0.0);
        let reference =
            vec![vec![c(1.0), c(1.0), c(0.0), c(0.0)], vec![c(2.0), c(2f32.sqrt()), c(0.0), c(0.0)]];
        let mut found = reference.clone();
        let powers: Vec<Vec<f64>> = reference.iter().map(|pulse| powers(pulse, 2)).collect();
        let means = [0, 1].map(|channel| mean_of(&powers, channel));
        let same = compare(&[3, 9], &means, &found, &reference);
        assert_eq!((same.rel_rms_db, same.rel_rms_db_mean), (LEAST_DB, LEAST_DB));
        assert_eq!(same.channel_db, [Some(LEAST_DB), None]);
        found[0][0] = c(1.1);
        let off = compare(&[3, 9], &means, &found, &reference);
        // f32 holds 1.1 to 6e-8: 1e-6 of the square of 0.1.
        assert!((off.rel_rms_db - 10.0 * (0.01f64 / 4.0).log10()).abs() < 1e-4, "{off:?}");
        assert!((off.rel_rms_db_mean - 10.0 * (0.01f64 / 8.0).log10()).abs() < 1e-4, "{off:?}");
        assert_eq!((off.worst_pulse, off.worst_channel), (3, 0));
        // An echo where there is none.
        found[1][3] = c(1e-9);
        let ghost = compare(&[3, 9], &means, &found, &reference);
        assert_eq!((ghost.rel_rms_db, ghost.worst_pulse, ghost.worst_channel), (-LEAST_DB, 9, 1));
        // What rounding leaves of a sphere in the crossed channels is none.
        found[1][3] = c(1e-16);
        assert_eq!(compare(&[3, 9], &means, &found, &reference).channel_db, [off.channel_db[0], None]);
    }
}
