//! The short way through: a scenario file to its pulses.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use thiserror::Error;

use super::build::{self, PulseStream, RunFailure};
use super::fault::BuildErrors;
use crate::config::{self, ConfigError, Run};
use crate::processor::focus::Described;
use crate::pulse::Pulse;
use crate::recording::Recording;
use crate::transport::Pace;

/// A scenario that was read and is free of faults.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario(pub Run);

/// Why a scenario gives no pulses.
#[derive(Debug, Error)]
#[non_exhaustive]
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
}
