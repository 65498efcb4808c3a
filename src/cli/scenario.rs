//! The scenario of a command, with what its arguments change.

use super::values::Setting;
use crate::config::{self, Run};
use crate::transport::Pace;

/// Overrides as `config` takes them.
pub(super) fn overrides(settings: &[Setting]) -> Vec<(String, String)> {
    settings.iter().map(|setting| (setting.key.clone(), setting.value.clone())).collect()
}

/// A scenario as it is measured: without sinks, as fast as it can.
pub(super) fn load(
    config: &std::path::Path,
    settings: &[Setting],
    more: &[(String, String)],
    threads: Option<u64>,
) -> Result<Run, config::ConfigError> {
    let mut overrides = overrides(settings);
    overrides.extend(threads.map(|threads| ("stream.threads".to_owned(), threads.to_string())));
    overrides.extend_from_slice(more);
    let mut run = config::load(config, &overrides)?;
    run.sinks.clear();
    run.stream.pace = Pace::Fast;
    Ok(run)
}
