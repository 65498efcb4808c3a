//! The pulses of a run, taken one by one.
//!
//! The run goes on in a thread of its own. Every pulse is handed over as a copy, which whoever takes it may
//! keep: the run needs its slots. Who takes pulses slower than they are made holds up a run at pace
//! `fast`; one in real time goes on without them, and the next pulse that is taken has the flag
//! [`AFTER_GAP`](crate::pulse::flags::AFTER_GAP).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};
use thiserror::Error;

use super::build::{PulseStream, RunFailure, RunOutcome};
use super::control::Control;
use super::fault::BuildErrors;
use crate::config::ConfigError;
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::transport::StreamError;
use crate::transport::stage::Summary;

/// Pulses between the run and who takes them, in addition to those of its rings.
const WAITING: usize = 16;
/// Longest wait between two looks whether the run has ended.
const GLANCE: Duration = Duration::from_secs(1);

/// Why a scenario gives no pulses.
#[derive(Debug, Error)]
pub enum ScenarioError {
    /// The file, with all its faults.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// It cannot be run: tracks, patterns, outputs, an error that cannot be kept.
    #[error(transparent)]
    Build(#[from] BuildErrors),
    /// The run failed.
    #[error("{0}")]
    Run(Box<RunFailure>),
}

/// A run under way, as an iterator over its pulses.
///
/// ```
/// use nereus::Scenario;
/// use nereus::transport::Pace;
///
/// let scenario = Scenario::load("configs/selftest.toml", &[("radar.window.samples", "512")])?;
/// let mut pulses = scenario.released(0..1000, Pace::Fast)?;
/// assert_eq!(pulses.next().transpose()?.map(|pulse| pulse.index), Some(0));
/// // Pulses wait for whoever takes them, so the run has not ended.
/// assert!(pulses.close()?.is_some_and(|summary| summary.stopped));
/// # Ok::<(), nereus::ScenarioError>(())
/// ```
pub struct ReleasedPulses {
    pulses: Option<Receiver<Box<Pulse>>>,
    run: Option<JoinHandle<Result<RunOutcome, BuildErrors>>>,
    stop: Arc<AtomicBool>,
    control: Option<Control>,
    header: Header,
    summary: Option<Summary>,
}

/// What came in the time allowed.
#[derive(Debug)]
pub enum Taken {
    /// The next pulse.
    Pulse(Box<Pulse>),
    /// None yet.
    Waiting,
    /// None, and none will come.
    Ended,
}

impl ReleasedPulses {
    pub(super) fn start(stream: PulseStream) -> Result<Self, ScenarioError> {
        let (sender, pulses) = bounded(WAITING);
        let (header, control) = (stream.header().clone(), stream.control());
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let hand_over = move || {
            stream.tap(&asked, |pulse| {
                // Who has closed the stream takes no more.
                let _ = sender.send(Box::new(pulse.clone()));
            })
        };
        let run = thread::Builder::new().name("run".to_owned()).spawn(hand_over).map_err(|error| {
            let refused = StreamError::Thread { thread: "run".to_owned(), kind: error.kind() };
            ScenarioError::Run(Box::new(RunFailure::Stream(refused)))
        })?;
        Ok(Self { pulses: Some(pulses), run: Some(run), stop, control, header, summary: None })
    }

    /// What the pulses are: names in the order of their records, radar, first emission.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Changes reports while the run goes on, and counts it.
    pub fn control(&self) -> Option<Control> {
        self.control.clone()
    }

    /// Ends the run where it is when this is set, as [`Self::close`] does.
    pub fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Figures of the run, once it has ended.
    pub fn summary(&self) -> Option<&Summary> {
        self.summary.as_ref()
    }

    /// Waits up to `timeout` for the next pulse.
    ///
    /// # Errors
    /// Why the run failed, once, after the pulses that it has released.
    pub fn next_within(&mut self, timeout: Duration) -> Result<Taken, ScenarioError> {
        let Some(pulses) = &self.pulses else { return Ok(Taken::Ended) };
        match pulses.recv_timeout(timeout) {
            Ok(pulse) => Ok(Taken::Pulse(pulse)),
            Err(RecvTimeoutError::Timeout) => Ok(Taken::Waiting),
            Err(RecvTimeoutError::Disconnected) => self.end().map(|()| Taken::Ended),
        }
    }

    /// Ends the run, if it has not ended, and reports its figures.
    ///
    /// # Errors
    /// Why it failed.
    pub fn close(&mut self) -> Result<Option<&Summary>, ScenarioError> {
        self.stop.store(true, Ordering::Release);
        self.end()?;
        Ok(self.summary.as_ref())
    }

    fn end(&mut self) -> Result<(), ScenarioError> {
        // Before the thread is waited for: it may be about to hand over a pulse.
        self.pulses = None;
        let Some(run) = self.run.take() else { return Ok(()) };
        let panicked = || ScenarioError::Run(Box::new(RunFailure::Panic { thread: "run".to_owned() }));
        let outcome = run.join().map_err(|_| panicked())??;
        self.summary = Some(outcome.summary);
        outcome.result.map_err(|error| ScenarioError::Run(Box::new(error)))
    }
}

impl Iterator for ReleasedPulses {
    type Item = Result<Box<Pulse>, ScenarioError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.next_within(GLANCE) {
                Ok(Taken::Pulse(pulse)) => return Some(Ok(pulse)),
                Ok(Taken::Waiting) => {}
                Ok(Taken::Ended) => return None,
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

impl Drop for ReleasedPulses {
    fn drop(&mut self) {
        // A failure that nobody asked about.
        let _ = self.close();
    }
}
