//! `nereus verify`: whether a recording is whole.

use clap::Args;
use std::io::{self, Write};
use std::path::PathBuf;

use super::counted;
use super::error::CliError;
use super::escape;
use super::examine::examine;
use super::json;
use crate::cli::examine::error::ExamineError;
use crate::recording::verify::{Verdict, verify as look};

/// `nereus verify`
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// HDF5 file or folder
    pub recording: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Reads all of it, and reports.
pub(super) fn verify(args: &VerifyArgs, out: &mut dyn Write) -> Result<(), CliError> {
    // What a damaged recording lacks is reported below; what kills or holds up its reader is not read here.
    match examine(&args.recording) {
        Ok(()) | Err(ExamineError::Refused { .. }) => {}
        Err(fatal) => return Err(fatal.into()),
    }
    let verdict = look(&args.recording)?;
    if args.json {
        let shown = Verdict { path: json::legible(&verdict.path), ..verdict.clone() };
        json::print(&shown, out)?;
    } else {
        report(&verdict, out).map_err(CliError::Output)?;
    }
    if verdict.whole {
        Ok(())
    } else {
        Err(CliError::NotWhole { path: verdict.path, faults: verdict.faults })
    }
}

/// The verdict for people.
fn report(verdict: &Verdict, out: &mut dyn Write) -> io::Result<()> {
    let word = if verdict.whole { "whole" } else { "not whole" };
    write!(out, "{}: {word}; {}", escape::path(&verdict.path), counted(verdict.pulses, "pulse"))?;
    if let (Some(first), Some(last)) = (verdict.first, verdict.last) {
        write!(out, " ({first} to {last}), {} dropped in real time", verdict.dropped)?;
    }
    writeln!(out, "; {} bytes read", verdict.bytes)?;
    for finding in &verdict.findings {
        writeln!(out, "  {}: {}", escape::name(&finding.place), escape::name(&finding.what))?;
    }
    let more = verdict.faults.saturating_sub(verdict.findings.len() as u64);
    if more > 0 {
        writeln!(out, "  and {} more", counted(more, "fault"))?;
    }
    for note in &verdict.notes {
        writeln!(out, "  note: {note}")?;
    }
    Ok(())
}
