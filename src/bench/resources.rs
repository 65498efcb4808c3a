//! What a run will take: memory, recording and speed, estimated before it starts.
//!
//! Sizes follow from the layout. Speed is measured: pulses spread over the run are made, by every worker
//! at once, for about [`TRIAL`], and thrown away; of a scene whose blocks take longer, one block each. Where
//! antennas scan, a pulse costs what their beams meet: then at least `BEARINGS` blocks are made, at
//! bearings of their own.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde::Serialize;

use crate::pipeline::build::{PulseStream, sum_of};
use crate::pipeline::fault::PulseError;
use crate::pipeline::plausible::ConverterReport;
use crate::pipeline::stages::{PulseFactory, Worker};
use crate::scene::Radar;

/// How long the trial lasts.
pub const TRIAL: Duration = Duration::from_millis(100);
/// Trials that a first block lasts where it is enough.
const FIRST_ALONE: u32 = 5;
/// Blocks of a trial where antennas scan, unless they take longer than so many trials.
const BEARINGS: u64 = 12;
const LONGEST_TRIALS: u32 = 30;
/// Of a run from one of them to the next: the golden section keeps step with no turn.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// An estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resources {
    /// Pulses of the run.
    pub pulses: u64,
    /// Length of the run, emission of the first pulse to one interval after the last, s.
    pub duration_s: f64,
    /// Workers that make pulses.
    pub threads: usize,
    /// One pulse with its records, bytes.
    pub pulse_bytes: usize,
    /// Memory of the ring, and of what sinks hold with all their queues full, bytes.
    pub memory_bytes: u64,
    /// The sea in all workers, bytes, about.
    pub sea_bytes: u64,
    /// What every recording sink will hold, bytes.
    pub recording_bytes: u64,
    /// Data rate at the pulse repetition frequency, bytes per second.
    pub bytes_per_s: f64,
    /// Most targets whose whole echo lies in the window, over the first, middle and last pulse, in any pair.
    pub targets_in_window: usize,
    /// What the converter was fed with in the trial; none of a radar without one.
    pub converter: Option<ConverterReport>,
    /// Pulses made in the trial.
    pub trial_pulses: u64,
    /// Pulses per second, measured.
    pub pulses_per_s: f64,
    /// Pulses per second made over pulses per second needed; real time needs more than 1.
    pub real_time_factor: f64,
    /// The error classes to which policy `relax` may go.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coarser: Vec<ClassForecast>,
}

/// An error class of policy `relax`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassForecast {
    /// The error that its pulses keep, dB.
    pub error_db: f64,
    /// By the cost model, from the speed that was measured of the first class.
    pub real_time_factor: f64,
}

impl PulseStream {
    /// Makes pulses for a moment and estimates what the run will take.
    ///
    /// # Errors
    /// A pulse that cannot be made.
    pub fn resources(&self, radar: &Radar) -> Result<Resources, PulseError> {
        self.resources_over(radar, TRIAL)
    }

    /// The error classes of policy `relax` beyond the first, where that makes pulses at so many times real
    /// time.
    fn coarser(&self, real_time_factor: f64) -> Vec<ClassForecast> {
        let mut classes =
            self.classes().filter_map(PulseFactory::plan).map(|plan| (plan.seconds(), plan.promised_db()));
        let asked_s = classes.next().map_or(0.0, |(seconds, _)| seconds);
        let of = |(seconds, error_db)| ClassForecast {
            error_db,
            real_time_factor: real_time_factor * asked_s / seconds,
        };
        classes.map(of).collect()
    }

    /// The same over a longer or shorter trial; every worker makes a block at least.
    ///
    /// # Errors
    /// A pulse that cannot be made.
    pub fn resources_over(&self, radar: &Radar, trial: Duration) -> Result<Resources, PulseError> {
        let factory = self.factory();
        let schedule = self.schedule();
        let threads = self.threads();
        let mut hands: Vec<_> = (0..threads).map(|_| (factory.slot(), factory.worker())).collect();
        // Whole blocks, and each worker walks over the whole run in strides that visit every part of it.
        let block = factory.block_pulses();
        let blocks = schedule.count.div_ceil(block).max(1);
        let stride = (blocks / 64).max(1);
        let bearings = if factory.generator().scans() { BEARINGS.min(blocks) } else { 1 };
        let pulses_of = |step: u64, hand: u64| {
            let place = if bearings > 1 {
                ((step as f64 * GOLDEN).fract() * blocks as f64) as u64
            } else {
                step.wrapping_mul(stride) + hand
            };
            let segment = factory.segment_of(schedule.first + place % blocks * block);
            segment.start..segment.end.min(schedule.end())
        };
        // Pulses made and the time that took, each worker from its own step on: so many blocks at least.
        let mut make_for = |least: (Duration, u64), step_of: fn(u64) -> u64| {
            let begun = Instant::now();
            let of_worker = |(hand, (slot, worker)): (usize, &mut (_, Worker<'_>))| {
                let (mut made, mut step) = (0, step_of(hand as u64));
                let last = step + least.1;
                let is_over = |step| {
                    let lasted = begun.elapsed();
                    lasted >= least.0 && (step >= last || lasted >= LONGEST_TRIALS * trial)
                };
                while made == 0 || !is_over(step) {
                    for index in pulses_of(step, hand as u64) {
                        worker.make(index, slot)?;
                        made += 1;
                    }
                    step += threads as u64;
                }
                Ok(made)
            };
            let made = self.pool().install(|| {
                hands.par_iter_mut().enumerate().map(of_worker).sum::<Result<u64, PulseError>>()
            })?;
            Ok::<_, PulseError>((made, begun.elapsed()))
        };
        // The first block of a worker also takes its memory into use, which does not show in a long one.
        let first = if block > 1 { Some(make_for((Duration::ZERO, 0), |_| 0)?) } else { None };
        let (made, lasted) = match first {
            Some((made, lasted)) if lasted >= FIRST_ALONE * trial && bearings == 1 => (made, lasted),
            _ => make_for((trial, bearings), |hand| 1 + hand)?,
        };
        let pulses_per_s = made as f64 / lasted.as_secs_f64();
        let (mut slot, mut worker) = (factory.slot(), factory.worker());
        let mut targets_in_window = 0;
        // A pulse of a sea may take seconds: it is not made for targets that are none.
        let looked_at = if factory.layout().targets == 0 { 0 } else { 3 };
        for index in [schedule.first, schedule.first + schedule.count / 2, schedule.end().saturating_sub(1)]
            .into_iter()
            .take(looked_at)
        {
            worker.make(index, &mut slot)?;
            targets_in_window = targets_in_window.max(factory.targets_in_window(&slot));
        }
        let (pulse_bytes, slots) = (factory.layout().slot_bytes(), self.slots());
        let prf_hz = schedule.times.mean_prf_hz();
        Ok(Resources {
            pulses: schedule.count,
            duration_s: schedule.times.interval_s(schedule.first, schedule.end()),
            threads,
            pulse_bytes,
            memory_bytes: ((slots.ring + slots.held) * pulse_bytes) as u64,
            sea_bytes: self.sea_bytes(),
            recording_bytes: schedule.count.saturating_mul(pulse_bytes as u64),
            bytes_per_s: prf_hz * pulse_bytes as f64,
            targets_in_window,
            converter: ConverterReport::of(radar, &sum_of(hands.iter().map(|(_, worker)| worker.levels()))),
            trial_pulses: made,
            pulses_per_s,
            real_time_factor: pulses_per_s / prf_hz,
            coarser: self.coarser(pulses_per_s / prf_hz),
        })
    }
}
