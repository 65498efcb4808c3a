//! The command and its subcommands; the arguments of each stand beside it.

use clap::{Parser, Subcommand};

use super::bench::BenchArgs;
use super::check::CheckArgs;
use super::completions::CompletionsArgs;
use super::doctor::DoctorArgs;
use super::export::ExportArgs;
use super::fit::FitArgs;
use super::focus::FocusArgs;
use super::import::ImportArgs;
use super::manpages::ManpagesArgs;
use super::merge::MergeArgs;
use super::monitor::MonitorArgs;
use super::nav::NavArgs;
use super::new::NewArgs;
use super::ppi::PpiArgs;
use super::receive::ReceiveArgs;
use super::run::RunArgs;
use super::sea::SeaArgs;
use super::sea::snapshot::SnapshotArgs;
use super::speckle::SpeckleArgs;
use super::table::TableArgs;
use super::tradeoff::TradeoffArgs;
use super::verify::{ExamineArgs, VerifyArgs};
use super::wake::WakeArgs;

/// Hardware-in-the-loop bistatic marine radar emulator.
#[derive(Debug, Parser)]
#[command(name = "nereus", version, about, disable_help_subcommand = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scenario: emit every pulse, in order, at the PRF, to the sinks
    Run(RunArgs),
    /// Validate a scenario, explain it, predict what it takes
    Check(CheckArgs),
    /// Find what makes a scenario run in real time on this machine: changes as `--set` words, each measured
    Fit(FitArgs),
    /// Measure throughput, start-up time, memory, time per stage, and the error against the reference echo
    Bench(BenchArgs),
    /// Measure error and speed over the settings of the fast echo: table, CSV, picture
    Tradeoff(TradeoffArgs),
    /// Print a commented scenario to start from, or the list of keys
    New(NewArgs),
    /// Map the sea of a scenario at a time: heights, slopes, velocities, a picture, its state for reuse
    Sea(SeaArgs),
    /// Map the waves of a scenario's ships alone: heights, slopes, velocities, a picture, wave cuts, wave
    /// resistance
    Wake(WakeArgs),
    /// Map what every facet contributes to the echo of a pulse, in dBW
    Snapshot(SnapshotArgs),
    /// Tabulate the models (spectra, sigma0, antenna) as CSV
    Table(Box<TableArgs>),
    /// Make a scenario of a scene of another program
    Import(ImportArgs),
    /// Join recordings of parts of one run
    Merge(MergeArgs),
    /// Export a recording to CRSD 1.0 or SigMF
    Export(ExportArgs),
    /// Show a recording in the browser, as `run --monitor` shows a run
    Monitor(MonitorArgs),
    /// Read all of a recording and say whether it is whole: exit 0 if so, 1 if not
    Verify(VerifyArgs),
    /// Make an image of a recording: range compression and bistatic back-projection
    Focus(Box<FocusArgs>),
    /// Make a plan position picture of a recording of a scanning antenna: power over range and bearing
    Ppi(PpiArgs),
    /// Fit amplitude distributions to sea clutter against wind azimuth: shape parameters, goodness of fit, a
    /// picture
    Speckle(Box<SpeckleArgs>),
    /// Receive pulses that are sent as VITA 49.2, and report gaps, lateness and navigation
    Receive(ReceiveArgs),
    /// Inspect, convert, play and corrupt recorded navigation
    Nav(NavArgs),
    /// Examine this machine: is it fit for real time, what would help, and how late pulses leave in a trial
    Doctor(DoctorArgs),
    /// Print a script by which a shell completes commands and options
    Completions(CompletionsArgs),
    /// Write a manual page for each command
    Manpages(ManpagesArgs),
    /// Read a recording to the end under limits of time and memory: `focus`, `merge` and `ppi` call it
    #[command(hide = true)]
    ExamineRecording(ExamineArgs),
}
