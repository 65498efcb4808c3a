//! `nereus merge`: parts of one run become one recording.

use std::io::Write;

use super::args::MergeArgs;
use super::error::CliError;

/// Joins the recordings.
pub(super) fn merge(_args: &MergeArgs, _out: &mut dyn Write) -> Result<(), CliError> {
    Err(CliError::Absent { command: "merge" })
}
