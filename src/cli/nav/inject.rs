//! `nereus nav inject`: a line to a run under way.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::super::error::CliError;
use super::NavToolError;
use crate::pipeline::control_lines::{LONGEST_LINE, ask};

/// `nereus nav inject`
#[derive(Debug, Args)]
pub struct NavInjectArgs {
    /// Socket of the run (its --control)
    pub socket: PathBuf,
    /// Command, such as step position.up 5 m (docs/control.md)
    #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub line: Vec<String>,
}

/// Sends the line and prints the answer.
pub(super) fn inject(args: &NavInjectArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let line = args.line.join(" ");
    if line.len() > LONGEST_LINE || line.contains(char::is_control) {
        return Err(NavToolError::Line { bytes: line.len() }.into());
    }
    let answer = ask(&args.socket, &line)
        .map_err(|source| NavToolError::Control { path: args.socket.clone(), source })?;
    match answer.strip_prefix("error ") {
        Some(why) => Err(NavToolError::Refused { answer: why.to_owned() }.into()),
        None => writeln!(out, "{answer}").map_err(CliError::Output),
    }
}
