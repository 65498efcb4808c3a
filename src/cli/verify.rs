//! `nereus verify`: whether a recording is whole; and the hidden `nereus examine-recording`, which reads one
//! under limits.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::error::CliError;
use super::report::Report;
use super::scenario::JsonArg;
use super::{counted, escape};
use crate::recording::examination::refuse_fatal;
use crate::recording::verify::{Verdict, verify as read_all};

/// `nereus verify`
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// HDF5 file or folder
    pub recording: PathBuf,
    /// Exit 1, too, where pulses of the run are missing: dropped in real time, or not made because it was
    /// stopped
    #[arg(long)]
    pub complete: bool,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// `nereus examine-recording`
#[derive(Debug, Args)]
pub struct ExamineArgs {
    /// Recording (HDF5)
    pub recording: PathBuf,
}

/// Reads an HDF5 file under limits, and keeps nothing ([`crate::recording::examination`]).
pub(super) fn examine_here(args: &ExamineArgs) -> Result<(), CliError> {
    #[cfg(feature = "hdf5")]
    return Ok(crate::recording::examination::read_under_limits(&args.recording)?);
    // A build without HDF5 reads no such file.
    #[cfg(not(feature = "hdf5"))]
    Err(crate::recording::RecordingError::NoHdf5 { path: args.recording.clone() }.into())
}

/// Reads all of it, and reports.
pub(super) fn verify(args: &VerifyArgs, out: &mut dyn Write) -> Result<(), CliError> {
    // What a damaged recording lacks is reported below.
    refuse_fatal(&args.recording)?;
    let verdict = read_all(&args.recording)?;
    report(&verdict).print(args.format.json, out)?;
    let Verdict { path, whole, faults, missing, asked, .. } = verdict;
    match (whole, missing) {
        (false, _) => Err(CliError::NotWhole { path, faults }),
        (true, 1..) if args.complete => Err(CliError::NotComplete { path, missing, asked }),
        _ => Ok(()),
    }
}

fn report(verdict: &Verdict) -> Report {
    let mut report = Report::default();
    report.values(verdict);
    let word = if verdict.whole { "whole" } else { "not whole" };
    let pulses = counted(verdict.pulses, "pulse");
    let span = match (verdict.first, verdict.last) {
        (Some(first), Some(last)) => {
            format!(" ({first} to {last}), {} dropped in real time", verdict.dropped)
        }
        _ => String::new(),
    };
    let path = escape::path(&verdict.path);
    report.line(format!("{path}: {word}; {pulses}{span}; {} bytes read", verdict.bytes));
    for finding in &verdict.findings {
        report.line(format!("  {}: {}", escape::name(&finding.place), escape::name(&finding.what)));
    }
    let more = verdict.faults.saturating_sub(verdict.findings.len() as u64);
    if more > 0 {
        report.line(format!("  and {} more", counted(more, "fault")));
    }
    for note in &verdict.notes {
        report.line(format!("  note: {}", escape::name(note)));
    }
    report
}
