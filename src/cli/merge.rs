//! `nereus merge`: parts of one run become one recording.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::error::CliError;
use super::scenario::OutputArgs;
#[cfg(feature = "hdf5")]
use super::{escape, report::Report};

/// `nereus merge`
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Recordings of parts of one run
    #[arg(required = true)]
    pub shards: Vec<PathBuf>,
    /// The recording to make
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Joins the recordings.
#[cfg(feature = "hdf5")]
pub(super) fn merge(args: &MergeArgs, out: &mut dyn Write) -> Result<(), CliError> {
    for shard in &args.shards {
        crate::recording::examination::examine(shard)?;
    }
    let merged = crate::recording::merge::merge(&args.shards, &args.out, args.output.overwrite.force)?;
    let (path, shards) = (escape::path(&merged.out), merged.shards.len());
    let mut report = Report::default();
    report.values(&merged);
    if !args.output.format.json {
        report.line(format!(
            "{path}: pulses {} to {} of {shards} recordings, {} in all, {} dropped",
            merged.first, merged.last, merged.pulses, merged.dropped
        ));
    }
    report.say(args.output.format.json, out)
}

/// A build without HDF5 has nothing to join.
#[cfg(not(feature = "hdf5"))]
pub(super) fn merge(_args: &MergeArgs, _out: &mut dyn Write) -> Result<(), CliError> {
    Err(super::error::Refused::MergeNeedsHdf5.into())
}
