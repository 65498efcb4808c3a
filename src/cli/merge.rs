//! `nereus merge`: parts of one run become one recording.

use clap::Args;
use std::io::Write;
use std::path::PathBuf;

use super::error::CliError;
#[cfg(feature = "hdf5")]
use super::{escape, say};

/// `nereus merge`
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Recordings of parts of one run
    #[arg(required = true)]
    pub shards: Vec<PathBuf>,
    /// The recording to make
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Overwrite a recording that exists
    #[arg(long)]
    pub force: bool,
    /// Print a summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Joins the recordings.
#[cfg(feature = "hdf5")]
pub(super) fn merge(args: &MergeArgs, out: &mut dyn Write) -> Result<(), CliError> {
    for shard in &args.shards {
        super::examine::examine(shard)?;
    }
    let report = crate::sinks::merge::merge(&args.shards, &args.out, args.force)?;
    if args.json {
        let text = serde_json::to_string(&report).map_err(|error| CliError::Output(error.into()))?;
        return writeln!(out, "{text}").map_err(CliError::Output);
    }
    let shards = report.shards.len();
    say(format_args!(
        "{}: pulses {} to {} of {shards} recordings, {} in all, {} dropped",
        escape::path(&report.out),
        report.first,
        report.last,
        report.pulses,
        report.dropped
    ));
    Ok(())
}

/// A build without HDF5 has nothing to join.
#[cfg(not(feature = "hdf5"))]
pub(super) fn merge(_args: &MergeArgs, _out: &mut dyn Write) -> Result<(), CliError> {
    Err(CliError::MergeNeedsHdf5)
}
