//! `nereus manpages`: a manual page for the program and for each of its subcommands.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use super::error::CliError;
use super::report::Report;
use super::scenario::OutputArgs;
use super::{counted, escape};
use crate::files::FileFault;
use crate::recording::output::{FileKind, Output, OutputError};

/// `nereus manpages`
#[derive(Debug, Args)]
pub struct ManpagesArgs {
    /// The folder, made if it is missing; `man` looks for pages in .../share/man/man1
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Pages that exist, and how it is reported
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Writes the pages of the program.
pub(super) fn manpages(args: &ManpagesArgs, program: Command, out: &mut dyn Write) -> Result<(), CliError> {
    fs::create_dir_all(&args.folder)
        .map_err(FileFault::io(&args.folder, "making the folder"))
        .map_err(OutputError::File)?;
    let force = args.output.overwrite.force;
    let planned = pages(program).into_iter().map(|page| {
        let output = Output::plan(&args.folder.join(page.get_filename()), FileKind::ManualPage, force)?;
        Ok((page, output))
    });
    // None is written if one is refused.
    let planned = planned.collect::<Result<Vec<_>, OutputError>>()?;
    let mut report = Report::default();
    report.paths("pages", planned.iter().map(|(_, output)| output.path()));
    report.line(format!("{}: {}", escape::path(&args.folder), counted(planned.len() as u64, "manual page")));
    for (page, output) in planned {
        output.write(|partial| {
            let mut text = Vec::new();
            let made = page.render(&mut text).and_then(|()| fs::write(partial, &text));
            made.map_err(OutputError::io(partial, "writing"))
        })?;
    }
    report.say(args.output.format.json, out)
}

/// The page of the program, then those of its subcommands and of theirs.
fn pages(mut program: Command) -> Vec<Man> {
    program.build();
    let mut waiting = vec![program];
    let mut pages = Vec::new();
    while let Some(command) = waiting.pop() {
        waiting.extend(command.get_subcommands().filter(|inner| !inner.is_hide_set()).cloned());
        pages.push(page(command));
    }
    pages
}

/// A page whose footer has the program's name and version.
fn page(command: Command) -> Man {
    // A date that is left out moves what follows to its place.
    Man::new(command).date(" ").source(concat!("nereus ", env!("CARGO_PKG_VERSION"))).manual("nereus")
}
