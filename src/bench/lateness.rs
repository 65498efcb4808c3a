//! How late pulses leave on this machine: the stream of a run, with pulses that hold nothing.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use serde::Serialize;

use crate::pipeline::yield_to_pacer;
use crate::pulse::{Layout, SampleFormat};
use crate::time::{PulseTimes, TimeError};
use crate::transport::fanout::Fed;
use crate::transport::schedule::Schedule;
use crate::transport::stage::{RunError, Stream};
use crate::transport::{Policy, Settings, StreamError};

/// Pulses are made so far ahead of their release, s.
const LATENCY_S: f64 = 0.1;

/// What is tried.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// How long, s.
    pub seconds: f64,
    /// Pulses per second, Hz.
    pub prf_hz: f64,
    /// Threads that are kept busy beside it, at the priority of workers.
    pub busy_threads: u64,
}

/// Why nothing could be tried.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The schedule.
    #[error(transparent)]
    Times(#[from] TimeError),
    /// The stream.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// The run.
    #[error(transparent)]
    Run(#[from] RunError<StreamError, io::Error>),
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lateness {
    /// Pulses per second, Hz.
    pub prf_hz: f64,
    /// How long, s.
    pub seconds: f64,
    /// Threads that were kept busy.
    pub busy_threads: u64,
    /// Whether the pacer had real-time priority.
    pub pacer_ahead: bool,
    /// Pulses released.
    pub pulses: u64,
    /// Those that left more than one interval after their deadline.
    pub late: u64,
    /// Median.
    pub p50_us: f64,
    /// 99 %.
    pub p99_us: f64,
    /// Worst.
    pub max_us: f64,
    /// For how long the machine, or this program, stood still.
    pub stood_still_s: f64,
}

/// Releases pulses in real time beside busy threads.
///
/// # Errors
/// A rate that no schedule has, and a thread that the system refuses.
pub fn measure(asked: Asked) -> Result<Lateness, TrialError> {
    let count = ((asked.prf_hz * asked.seconds).round() as u64).max(1);
    let schedule = Schedule { times: PulseTimes::uniform(asked.prf_hz)?, first: 0, count };
    let ring_slots = ((LATENCY_S * asked.prf_hz) as usize + 2).max(128);
    let settings = Settings { policy: Policy::Slip, latency_s: LATENCY_S, ring_slots, ..Settings::default() };
    let layout = Layout {
        channels: 1,
        samples: 1,
        format: SampleFormat::Cf32,
        platforms: 0,
        antennas: 0,
        targets: 0,
        pairs: 0,
        windows: 0,
        ships: 0,
        clocks: 0,
    };
    let mut stream = Stream::new(settings, schedule, layout, Arc::new(AtomicBool::new(false)));
    stream.sink("trial", ring_slots, |mut feed| {
        while !matches!(feed.next(Duration::from_secs(1), |_| Ok::<_, io::Error>(()))?, Fed::Ended) {}
        Ok(())
    })?;
    let ended = AtomicBool::new(false);
    let outcome = thread::scope(|scope| {
        for _ in 0..asked.busy_threads {
            // A thread that the system refuses is one less.
            let _ = thread::Builder::new().name("busy".to_owned()).spawn_scoped(scope, || {
                yield_to_pacer();
                while !ended.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let outcome = stream.run(|source| {
            for index in 0..count {
                let Some(slots) = source.reserve(1) else { break };
                slots[0].index = index;
                slots[0].flags = 0;
                source.commit(1);
            }
            Ok::<(), StreamError>(())
        });
        ended.store(true, Ordering::Relaxed);
        outcome
    });
    outcome.result?;
    let health = outcome.summary.health;
    Ok(Lateness {
        prf_hz: asked.prf_hz,
        seconds: asked.seconds,
        busy_threads: asked.busy_threads,
        pacer_ahead: health.pacer_ahead,
        pulses: health.pulses,
        late: health.late,
        p50_us: health.lateness_us.p50,
        p99_us: health.lateness_us.p99,
        max_us: health.lateness_us.max,
        stood_still_s: health.stood_still_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pulse_is_released() {
        let found = measure(Asked { seconds: 0.2, prf_hz: 500.0, busy_threads: 1 }).unwrap();
        assert_eq!(found.pulses, 100);
        assert!(found.p50_us <= found.p99_us && found.p99_us <= found.max_us, "{found:?}");
    }
}
