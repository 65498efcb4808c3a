//! `nereus run`: a scenario becomes a running stream.

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::args::{Pace, RunArgs, Setting};
use super::error::CliError;
use crate::config::{self, Run};
use crate::sinks::Kind;
use crate::transport;

/// Runs the scenario.
pub(super) fn run(args: &RunArgs, _out: &mut dyn Write) -> Result<(), CliError> {
    let (run, _pulses) = prepare(args)?;
    for warning in &run.warnings {
        eprintln!("warning: {warning}");
    }
    Err(CliError::Absent { command: "run" })
}

/// Overrides as `config` takes them.
pub(super) fn overrides(settings: &[Setting]) -> Vec<(String, String)> {
    settings.iter().map(|setting| (setting.key.clone(), setting.value.clone())).collect()
}

/// The run that the arguments ask for, and its pulses. Options that change what is emulated become part
/// of the recorded scenario text; pace, output and force do not, so that parts of a run can be joined.
fn prepare(args: &RunArgs) -> Result<(Run, Range<u64>), CliError> {
    let mut overrides = overrides(&args.settings);
    if let Some(duration_s) = &args.duration_s {
        overrides.push(("scene.duration_s".to_owned(), duration_s.clone()));
    }
    let mut run = config::load(&args.config, &overrides)?;
    if let Some(pace) = args.pace {
        run.stream.pace = match pace {
            Pace::Realtime => transport::Pace::Realtime,
            Pace::Fast => transport::Pace::Fast,
        };
    }
    if let Some(out) = &args.out {
        redirect(&mut run, out)?;
    }
    if args.force {
        for sink in &mut run.sinks {
            if let Kind::Hdf5 { force, .. } | Kind::Plain { force, .. } = &mut sink.kind {
                *force = true;
            }
        }
    }
    let pulses = match args.pulses {
        None => 0..run.scene.pulses,
        Some(range) if range.end <= run.scene.pulses => range.first..range.end,
        Some(range) => {
            return Err(CliError::Pulses { first: range.first, end: range.end, pulses: run.scene.pulses });
        }
    };
    Ok((run, pulses))
}

/// Sends the recording elsewhere, or adds one where the scenario has none.
fn redirect(run: &mut Run, out: &Path) -> Result<(), CliError> {
    let mut paths: Vec<&mut PathBuf> = run
        .sinks
        .iter_mut()
        .filter_map(|sink| match &mut sink.kind {
            Kind::Hdf5 { path, .. } | Kind::Plain { path, .. } => Some(path),
            Kind::Null => None,
        })
        .collect();
    match &mut paths[..] {
        [path] => **path = out.to_owned(),
        [] => {
            let hdf5 = out.extension().is_some_and(|extension| extension == "h5" || extension == "hdf5");
            if hdf5 && !cfg!(feature = "hdf5") {
                return Err(CliError::NoHdf5 { out: out.to_owned() });
            }
            let path = out.to_owned();
            let kind = match hdf5 {
                true => Kind::Hdf5 { path, segment_s: None, force: false },
                false => Kind::Plain { path, force: false },
            };
            // A resolved run has at least one sink.
            if let Some(sink) = run.sinks.first_mut() {
                sink.kind = kind;
            }
        }
        several => {
            return Err(CliError::WhichSink { out: out.to_owned(), recordings: several.len() });
        }
    }
    Ok(())
}
