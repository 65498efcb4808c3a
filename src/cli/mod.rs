//! The command line: arguments, and reports as text and JSON; a file or folder for each subcommand.
//!
//! Data goes to standard output, everything else to standard error. Exit 0: done; 1: the run failed;
//! 2: the input is wrong (arguments, scenario, files it names). `--json` prints one object, last.

mod args;
mod bench;
mod check;
mod completions;
mod doctor;
mod error;
mod escape;
mod export;
mod fit;
mod focus;
#[cfg(unix)]
mod import;
mod large_pages;
mod manpages;
mod merge;
mod monitor;
mod nav;
mod new;
#[cfg(test)]
mod openings;
mod ppi;
mod progress;
mod receive;
mod report;
mod run;
mod scenario;
mod sea;
mod speckle;
mod table;
mod tradeoff;
mod values;
mod verify;
mod wake;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{CommandFactory, Parser};

use crate::units::counted;

pub use args::{Arguments, Command};
pub use check::assess;
pub use error::CliError;
#[cfg(unix)]
pub use large_pages::with_large_pages;
pub use sea::sea_at;

/// Runs the program.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(status(arguments))
}

/// Runs the program and returns its exit code.
pub fn status(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let begun = Instant::now();
    crate::files::report_large_files();
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are data; a failure to print them has nowhere to go.
            let _ = error.print();
            return if error.use_stderr() { 2 } else { 0 };
        }
    };
    let mut out = escape::Printable(std::io::stdout().lock());
    let done = execute(&arguments, begun, &mut out).and_then(|()| out.flush().map_err(CliError::Output));
    match done {
        Ok(()) => 0,
        // The reader of a pipe has seen enough.
        Err(CliError::Output(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => 0,
        Err(error) => {
            say(format_args!("error: {error}"));
            error.exit_code()
        }
    }
}

/// A flag that Ctrl-C sets. Where `files` are written, a second one is answered, and a third ends the program
/// (130) while they are not closed.
fn stop_on_ctrl_c(files: bool) -> Result<Arc<AtomicBool>, CliError> {
    let stop = Arc::new(AtomicBool::new(false));
    let (asked, mut presses) = (Arc::clone(&stop), Presses::default());
    let set = ctrlc::set_handler(move || {
        asked.store(true, Ordering::Release);
        match presses.signal(Instant::now()) {
            Some(2) if files => {
                say("outputs are being closed; Ctrl-C again leaves them as they are, and the rest is lost");
            }
            Some(3..) if files => std::process::exit(130),
            _ => {}
        }
    });
    set.map(|()| stop).map_err(CliError::Signal)
}

/// Signals so close together are one press: a terminal, a shell and `timeout` may each pass it on.
const ONE_PRESS: Duration = Duration::from_secs(1);

/// How often Ctrl-C was pressed.
#[derive(Debug, Default)]
struct Presses {
    count: u32,
    last: Option<Instant>,
}

impl Presses {
    /// The press that a signal is; none if it is part of the one before.
    fn signal(&mut self, now: Instant) -> Option<u32> {
        let before = self.last.replace(now);
        if before.is_some_and(|before| now.saturating_duration_since(before) < ONE_PRESS) {
            return None;
        }
        self.count = self.count.saturating_add(1);
        Some(self.count)
    }
}

/// A line for people. A standard error that cannot be written is no reason to lose a run.
fn say(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{}", escape::printable(&line.to_string()));
}

/// What the user should know, a line each.
fn warn(warnings: impl IntoIterator<Item = impl std::fmt::Display>) {
    for warning in warnings {
        say(format_args!("warning: {warning}"));
    }
}

/// Carries out a command whose data go to `out`; what is for people goes to standard error. `begun` is when
/// the program began.
///
/// # Errors
/// Why the command ends early.
pub fn execute(arguments: &Arguments, begun: Instant, out: &mut dyn Write) -> Result<(), CliError> {
    match &arguments.command {
        Command::Run(args) => run::run(args, out),
        Command::Check(args) => check::check(args, out),
        Command::Bench(args) => bench::bench(args, begun, out),
        Command::Fit(args) => fit::fit(args, out),
        Command::Tradeoff(args) => tradeoff::tradeoff(args, out),
        Command::New(args) => new::new(args, out),
        Command::Sea(args) => sea::sea(args, out),
        Command::Wake(args) => wake::wake(args, out),
        Command::Snapshot(args) => sea::snapshot::snapshot(args, out),
        Command::Table(args) => table::table(args, out),
        Command::Merge(args) => merge::merge(args, out),
        Command::Export(args) => export::export(args, out),
        Command::Monitor(args) => monitor::page::replay(args),
        Command::Verify(args) => verify::verify(args, out),
        Command::Focus(args) => focus::focus(args, out),
        Command::Ppi(args) => ppi::ppi(args, out),
        Command::Speckle(args) => speckle::speckle(args, out),
        Command::Receive(args) => receive::receive(args, out),
        Command::Nav(args) => nav::nav(args, out),
        Command::Doctor(args) => doctor::doctor(args, out),
        Command::Completions(args) => completions::completions(args, Arguments::command(), out),
        Command::Import(args) => import::import(args, out),
        Command::Manpages(args) => manpages::manpages(args, Arguments::command(), out),
        Command::ExamineRecording(args) => verify::examine_here(args),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Before: the second of two signals within 5 ms ended the program while files were open.
    #[test]
    fn signals_close_together_are_one_press() {
        let mut presses = Presses::default();
        let begun = Instant::now();
        let mut at = |ms| presses.signal(begun + Duration::from_millis(ms));
        assert_eq!([at(0), at(5), at(6), at(900)], [Some(1), None, None, None]);
        // A key that is held down is one press, too.
        assert_eq!([at(1800), at(2799), at(3799), at(3800), at(9000)], [None, None, Some(2), None, Some(3)]);
    }
}
