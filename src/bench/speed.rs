//! What a run reaches on this machine: pulses per second, start, memory, and what its stages take.
//!
//! The run streams as fast as it can into nothing, as `nereus run --pace fast` does without a recording.
//! Speed is pulses made over the time that generation was at work, its first pulses included. Times of stages
//! are a worker's own: with two workers a pulse of 1 ms may have 2 ms of stages.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use thiserror::Error;

use crate::fidelity::budget::Plan;
use crate::pipeline::build::{PulseStream, RunFailure};
use crate::pipeline::fault::BuildErrors;
use crate::pulse::costs::Costs;
use crate::transport::pacer::Status;

/// How long a measurement lasts where no number of pulses is given.
pub const TRIAL: Duration = Duration::from_secs(10);
/// Blocks that every worker makes at least, where the run has them.
const LEAST_BLOCKS: u64 = 2;

/// What was measured.
#[derive(Clone, Debug)]
pub struct Speed {
    /// Pulses made.
    pub pulses: u64,
    /// Pulses that are made together.
    pub block_pulses: u64,
    /// Workers.
    pub threads: usize,
    /// Facets of the patch; 0 without a sea.
    pub facets: usize,
    /// Facets, targets and direct path.
    pub paths: usize,
    /// Channels.
    pub channels: usize,
    /// Pulses made per second of generation.
    pub pulses_per_s: f64,
    /// The same over the mean pulse repetition frequency.
    pub real_time_factor: f64,
    /// When the first pulse was released.
    pub first_release: Option<Instant>,
    /// What the workers spent and counted.
    pub costs: Costs,
    /// What was planned; `None` for the reference.
    pub plan: Option<Plan>,
    /// Most memory that the program has had resident so far, bytes; `None` where the system does not say.
    pub peak_rss_bytes: Option<u64>,
}

impl Speed {
    /// Facets of the whole patch times pulses per second.
    pub fn facet_pulses_per_s(&self) -> f64 {
        self.facets as f64 * self.pulses_per_s
    }
}

/// Why there is no figure.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SpeedError {
    /// The run cannot be built.
    #[error(transparent)]
    Build(#[from] BuildErrors),
    /// The run failed.
    #[error("{0}")]
    Run(Box<RunFailure>),
}

impl SpeedError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        matches!(self, Self::Build(_))
    }
}

/// Runs a stream to its end, or for so long but not for less than a few blocks, and measures it. Give it a
/// run without sinks, at pace `fast`.
///
/// # Errors
/// A run that cannot be started, or fails.
pub fn speed(
    stream: PulseStream,
    lasts: Option<Duration>,
    status: Option<Sender<Status>>,
) -> Result<Speed, SpeedError> {
    let factory = stream.factory();
    let (facets, paths, layout) = (factory.facets(), factory.paths(), *factory.layout());
    let (block_pulses, threads) = (factory.block_pulses(), stream.threads());
    let plan = factory.plan().copied();
    let prf_hz = stream.schedule().times.mean_prf_hz();
    let least = LEAST_BLOCKS.saturating_mul(block_pulses).saturating_mul(threads as u64);
    let stop = Arc::new(AtomicBool::new(false));
    let begun = Instant::now();
    let (mut first_release, mut seen) = (None, 0);
    let (outcome, costs) = stream.measure(&stop, status, |_| {
        first_release.get_or_insert_with(Instant::now);
        seen += 1;
        if seen >= least && lasts.is_some_and(|lasts| begun.elapsed() >= lasts) {
            stop.store(true, Ordering::Release);
        }
    })?;
    outcome.result.map_err(|error| SpeedError::Run(Box::new(error)))?;
    let real_time_factor = outcome.summary.real_time_factor;
    Ok(Speed {
        pulses: outcome.summary.health.made,
        block_pulses,
        threads,
        facets,
        paths,
        channels: layout.channels,
        pulses_per_s: real_time_factor * prf_hz,
        real_time_factor,
        first_release,
        costs,
        plan,
        peak_rss_bytes: peak_rss_bytes(),
    })
}

/// The most memory that this program has had resident, bytes; `None` where the system does not say.
pub fn peak_rss_bytes() -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}
