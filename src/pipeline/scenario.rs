//! The short way through: a scenario file to its pulses.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crossbeam_channel::Sender;

use super::build::{self, PulseStream, RunOutcome};
use super::released::ReleasedPulses;
use crate::config::{self, Run};
use crate::processor::focus::Described;
use crate::pulse::Pulse;
use crate::recording::Recording;
use crate::sinks;
use crate::transport::Pace;
use crate::transport::pacer::Status;

pub use super::released::ScenarioError;

/// Pulses that may wait to be recorded.
const QUEUE_PULSES: usize = 64;

/// A scenario that was read and is free of faults.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario(pub Run);

impl Scenario {
    /// Reads a scenario file; `overrides` are dotted keys and their values, as `--set` takes them.
    ///
    /// # Errors
    /// All faults of the file and the overrides, each with its line, its key and what is allowed.
    pub fn load(path: impl AsRef<Path>, overrides: &[(&str, &str)]) -> Result<Self, ScenarioError> {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        let overrides: Vec<(String, String)> = overrides.iter().map(owned).collect();
        Ok(Self(config::load(path.as_ref(), &overrides)?))
    }

    /// The scenario that stands inside a recording. Files that it names need not be there.
    ///
    /// # Errors
    /// All faults of its text; an older version may have written keys that this one does not know.
    pub fn of(recording: &Recording) -> Result<Self, ScenarioError> {
        Ok(Self(config::recorded(&recording.header.config)?))
    }

    /// What it describes, for a processor.
    pub(crate) fn described(&self) -> Described<'_> {
        Described { scene: &self.0.scene, nav: &self.0.nav }
    }

    /// Reads a scenario from memory; `path` names it in faults, and files are looked for beside it.
    ///
    /// # Errors
    /// All faults of the text and the overrides.
    pub fn parse(
        text: &str,
        path: impl AsRef<Path>,
        overrides: &[(String, String)],
    ) -> Result<Self, ScenarioError> {
        Ok(Self(config::parse(text, path.as_ref(), overrides)?))
    }

    /// Pulses of the run.
    pub fn pulses(&self) -> u64 {
        self.0.scene.pulses
    }

    /// A run of some pulses into the sinks of the scenario, ready to start.
    ///
    /// # Errors
    /// What keeps it from being built, all at once.
    pub fn stream(&self, pulses: Range<u64>) -> Result<PulseStream, ScenarioError> {
        Ok(build::stream(&self.0, pulses)?)
    }

    /// Makes some pulses as fast as the machine can and hands each over, in order; sinks of the scenario are
    /// left out. The samples are those that `nereus run` records, bit by bit.
    ///
    /// # Errors
    /// What keeps the run from being built, or ends it.
    pub fn each_pulse(
        &self,
        pulses: Range<u64>,
        see: impl FnMut(&Pulse) + Send,
    ) -> Result<(), ScenarioError> {
        let mut run = self.0.clone();
        run.sinks.clear();
        run.stream.pace = Pace::Fast;
        let outcome = build::stream(&run, pulses)?.tap(&Arc::new(AtomicBool::new(false)), see)?;
        outcome.result.map(|_| ()).map_err(|error| ScenarioError::Run(Box::new(error)))
    }

    /// Makes some pulses and hands them over, one by one and in order, as an iterator; sinks of the scenario
    /// are left out. Reports may be changed meanwhile ([`ReleasedPulses::control`]).
    ///
    /// # Errors
    /// What keeps the run from being built.
    pub fn released(&self, pulses: Range<u64>, pace: Pace) -> Result<ReleasedPulses, ScenarioError> {
        let mut run = self.0.clone();
        run.sinks.clear();
        run.stream.pace = pace;
        run.control = true;
        ReleasedPulses::start(build::stream(&run, pulses)?)
    }

    /// Makes some pulses as fast as the machine can and records them in one place; sinks of the scenario are
    /// left out. Ends when `stop` is set, with a recording of the pulses so far. How the run ended is in what
    /// is returned; progress goes to `status`.
    ///
    /// # Errors
    /// What keeps the run from being built: a recording that exists, too.
    pub fn record(
        &self,
        pulses: Range<u64>,
        recording: sinks::Kind,
        stop: &Arc<AtomicBool>,
        status: Option<Sender<Status>>,
    ) -> Result<RunOutcome, ScenarioError> {
        let mut run = self.0.clone();
        run.sinks = vec![sinks::Settings::new(recording, QUEUE_PULSES)];
        run.stream.pace = Pace::Fast;
        Ok(build::stream(&run, pulses)?.run(stop, status)?)
    }
}
