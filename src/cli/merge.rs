//! `nereus merge`: parts of one run become one recording.

use clap::Args;
use std::io::Write;
use std::path::PathBuf;

use super::error::CliError;
#[cfg(feature = "hdf5")]
use super::{escape, json, say};

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
    let mut report = crate::recording::merge::merge(&args.shards, &args.out, args.force)?;
    if args.json {
        report.out = json::legible(&report.out);
        report.shards = json::all_legible(&report.shards);
        return json::print(&report, out);
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
