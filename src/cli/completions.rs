//! `nereus completions`: what a shell needs to complete the command line.

use std::io::Write;

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use super::error::CliError;

/// `nereus completions`
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Prints the script of a shell for the program.
pub(super) fn completions(
    args: &CompletionsArgs,
    mut program: Command,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    // By way of memory: what writes the script panics where standard output cannot be written.
    let mut script = Vec::new();
    generate(args.shell, &mut program, "nereus", &mut script);
    out.write_all(&script).map_err(CliError::Output)
}
