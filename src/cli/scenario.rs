//! The scenario of a command, with what its arguments change.

use std::path::{Path, PathBuf};

use clap::Args;

use super::error::Refused;
use super::values::{Setting, threads};
use super::warn;
use crate::config::{self, ConfigError, Run};
use crate::scene::Sea;
use crate::transport::Pace;

/// The scenario of a command.
#[derive(Debug, Args)]
pub struct ScenarioArgs {
    /// Scenario file
    pub config: PathBuf,
    /// Set a key of the scenario, e.g. radar.prf_hz=500 or target.0.rcs_m2=10
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
    /// The scenario itself, for who has no file of it: `config` then names it in faults.
    #[arg(skip)]
    pub text: Option<String>,
}

/// How a command reports.
#[derive(Debug, Args)]
pub struct JsonArg {
    /// Print the report as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What becomes of files that exist.
#[derive(Clone, Debug, Args)]
pub struct ForceArg {
    /// Overwrite outputs that exist
    #[arg(long)]
    pub force: bool,
}

/// What becomes of the output of a command.
#[derive(Debug, Args)]
pub struct OutputArgs {
    /// Files that exist
    #[command(flatten)]
    pub overwrite: ForceArg,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// A scenario that is measured.
#[derive(Debug, Args)]
pub struct MeasuredArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Threads that make pulses (instead of stream.threads); 0: as many as the machine has
    #[arg(long, value_name = "T", value_parser = threads())]
    pub threads: Option<u64>,
}

impl ScenarioArgs {
    /// The run that is asked for, with overrides of the command's own after those of `--set`.
    pub(super) fn load(&self, more: &[(String, String)]) -> Result<Run, ConfigError> {
        let of = |setting: &Setting| (setting.key.clone(), setting.value.clone());
        let overrides: Vec<(String, String)> =
            self.settings.iter().map(of).chain(more.iter().cloned()).collect();
        match &self.text {
            Some(text) => config::parse(text, &self.config, &overrides),
            None => config::load(&self.config, &overrides),
        }
    }

    /// The run asked for; shows warnings except those of its sinks.
    pub(super) fn load_and_warn(&self) -> Result<Run, ConfigError> {
        let run = self.load(&[])?;
        warn_of_scene(&run);
        Ok(run)
    }

    /// The run as it is measured: without sinks, as fast as it can.
    pub(super) fn load_to_measure(
        &self,
        threads: Option<u64>,
        more: &[(String, String)],
    ) -> Result<Run, ConfigError> {
        let threads = threads.map(|threads| ("stream.threads".to_owned(), threads.to_string()));
        let more: Vec<(String, String)> = threads.into_iter().chain(more.iter().cloned()).collect();
        let mut run = self.load(&more)?;
        run.sinks.clear();
        run.stream.pace = Pace::Fast;
        Ok(run)
    }
}

/// Shows what is suspicious of a scenario apart from its sinks.
pub(super) fn warn_of_scene(run: &Run) {
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
}

impl MeasuredArgs {
    /// The run that is asked for, without sinks, as fast as it can.
    pub(super) fn load(&self, more: &[(String, String)]) -> Result<Run, ConfigError> {
        self.scenario.load_to_measure(self.threads, more)
    }
}

/// The sea of a run; `path` names its scenario.
pub(super) fn sea_of<'a>(run: &'a Run, path: &Path) -> Result<&'a Sea, Refused> {
    run.scene.sea.as_ref().ok_or_else(|| Refused::Without { path: path.to_owned(), what: "[sea]" })
}

/// The number of a channel of a run.
pub(super) fn channel_of(run: &Run, name: &str) -> Result<usize, Refused> {
    let all = &run.scene.radar.channels;
    all.iter().position(|channel| channel.name == name).ok_or_else(|| {
        let known: Vec<&str> = all.iter().map(|channel| channel.name.as_str()).collect();
        Refused::NoChannel { name: name.to_owned(), known: known.join(", ") }
    })
}
