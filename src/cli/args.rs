//! Arguments.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use thiserror::Error;

use super::focus::FocusArgs;
use super::nav::NavArgs;
use super::sea::SeaArgs;
use super::sea::snapshot::SnapshotArgs;
use super::speckle::SpeckleArgs;
use super::table::TableArgs;
use super::wake::WakeArgs;
use crate::config::keys::{self, Kind};

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
    /// Run a scenario: every pulse in PRF order at PRF rate into its sinks
    Run(RunArgs),
    /// Validate a scenario, explain it, predict what it takes
    Check(CheckArgs),
    /// Measure speed, start, memory, what the stages take, and the error against the reference echo
    Bench(BenchArgs),
    /// Measure error and speed over the settings of the fast echo: table, CSV, picture
    Tradeoff(TradeoffArgs),
    /// Print a commented scenario to start from, or the list of keys
    New(NewArgs),
    /// Map the sea of a scenario at a time: heights, slopes, velocities, a picture, its state for reuse
    Sea(SeaArgs),
    /// Map the waves of a scenario's ships alone: heights, slopes, velocities, a picture, wave cuts, wave resistance
    Wake(WakeArgs),
    /// Map what every facet contributes to the echo of a pulse, in dBW
    Snapshot(SnapshotArgs),
    /// Print physics as CSV
    Table(Box<TableArgs>),
    /// Join recordings of parts of one run
    Merge(MergeArgs),
    /// Read all of a recording and say whether it is whole: exit 0 if so, 1 if not
    Verify(VerifyArgs),
    /// Make an image of a recording: range compression and bistatic back-projection
    Focus(Box<FocusArgs>),
    /// Fit laws to the speckle of the sea over the azimuth of the wind: shape parameters, how well they fit, a picture
    Speckle(Box<SpeckleArgs>),
    /// Receive pulses that are sent as VITA 49.2, and tell gaps, lateness and navigation
    Receive(ReceiveArgs),
    /// Inspect, convert, play and spoil recorded navigation
    Nav(NavArgs),
    /// Read a recording to the end under limits of time and memory: `focus` and `merge` call it
    #[command(hide = true)]
    ExamineRecording(ExamineArgs),
}

/// `nereus examine-recording`
#[derive(Debug, Args)]
pub struct ExamineArgs {
    /// Recording (HDF5)
    pub recording: PathBuf,
}

/// `nereus run`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct RunArgs {
    /// Scenario file
    pub config: PathBuf,
    /// Release pulses in real time or as fast as they are made (instead of stream.pace)
    #[arg(long, value_enum)]
    pub pace: Option<Pace>,
    /// Length of the run (instead of scene.duration_s)
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration_s: Option<String>,
    /// Make only these pulses of the run, the last one excluded
    #[arg(long, value_name = "A..B")]
    pub pulses: Option<PulseRange>,
    /// Recording (instead of the path of the scenario's recording)
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Take changes of reports while the run goes on: a Unix socket to be made, or - for standard input (docs/control.md)
    #[arg(long, value_name = "PATH")]
    pub control: Option<PathBuf>,
    /// Set a key of the scenario, e.g. radar.prf_hz=500 or target.0.rcs_m2=10
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
    /// Overwrite recordings that exist
    #[arg(long)]
    pub force: bool,
    /// Print a summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `nereus verify`
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// HDF5 file or folder
    pub recording: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `nereus check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scenario file
    pub config: PathBuf,
    /// Set a key of the scenario, e.g. radar.prf_hz=500 or target.0.rcs_m2=10
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `nereus bench`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BenchArgs {
    /// Scenario file
    pub config: PathBuf,
    /// Make the first so many pulses of the run [default: what fits in some 10 s, at least two blocks for every thread]
    #[arg(long, value_name = "N", value_parser = counts(1, u64::MAX))]
    pub pulses: Option<u64>,
    /// Threads that make pulses (instead of stream.threads); 0: as many as the machine has
    #[arg(long, value_name = "T", value_parser = threads())]
    pub threads: Option<u64>,
    /// Pulses, spread over the run, at which the error is measured, or all; 0: none
    #[arg(long, value_name = "N|all", default_value = "16", value_parser = pulses_or_all)]
    pub error_pulses: u64,
    /// Set a key of the scenario, e.g. fidelity.node_pulses=2
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `nereus tradeoff`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TradeoffArgs {
    /// Scenario file
    pub config: PathBuf,
    /// Folder for tradeoff.csv and tradeoff.png
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Every combination of the settings, instead of one setting at a time
    #[arg(long)]
    pub grid: bool,
    /// Pulses, spread over the run, at which errors are measured
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = counts(1, u64::MAX))]
    pub error_pulses: u64,
    /// Error that is wanted, dB (instead of fidelity.error_db)
    #[arg(long, value_name = "DB")]
    pub error_db: Option<f64>,
    /// Threads that make pulses (instead of stream.threads); 0: as many as the machine has
    #[arg(long, value_name = "T", value_parser = threads())]
    pub threads: Option<u64>,
    /// Set a key of the scenario, e.g. scene.facet_m=2
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
    /// Overwrite files that exist
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `nereus new`
#[derive(Debug, Args)]
pub struct NewArgs {
    /// What to print
    #[arg(value_enum, default_value_t = Template::Coastal)]
    pub kind: Template,
}

/// What `nereus new` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// Coastal transmitter, airborne receiver; stands alone
    Coastal,
    /// One aircraft, alternating polarisation, ADC; stands alone
    Monostatic,
    /// From orbit, several pulses in the air; stands alone
    Spaceborne,
    /// A small patch of sea under one aircraft, with swell and a slick; stands alone
    Sea,
    /// The whole thing: recorded flight, sea, ship, targets; needs configs/tracks and hulls as in the repository
    Quickstart,
    /// Recorded flight and a field of point targets; needs configs/tracks beside it
    Calibration,
    /// Every key with unit, default and range (Markdown)
    Keys,
}

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

/// `nereus receive`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct ReceiveArgs {
    /// Address and port of this machine; port 0 takes a free one and says which
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:4991")]
    pub listen: String,
    /// End after so many whole pulses
    #[arg(long, value_name = "N", value_parser = counts(1, u64::MAX))]
    pub pulses: Option<u64>,
    /// End after so long
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration_s: Option<Duration>,
    /// End when nothing of a run has come for so long, once something has
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub idle_s: Option<Duration>,
    /// Take datagrams of this sender only: an address or name, with or without a port
    #[arg(long, value_name = "ADDR")]
    pub from: Option<String>,
    /// When the sender begins another run, follow it (with --out into a recording of its own: name-2, name-3, ...)
    #[arg(long)]
    pub restart: bool,
    /// Record whole pulses: HDF5 (.h5, .hdf5), or else a folder of plain files
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwrite a recording that exists
    #[arg(long)]
    pub force: bool,
    /// Print the report as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Not a whole number, or not one that is allowed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: a whole number from {least} to {}", if *most == u64::MAX { "2^64 - 1".to_owned() } else { most.to_string() })]
pub struct NotACount {
    /// The least allowed.
    pub least: u64,
    /// The most allowed.
    pub most: u64,
}

/// Reads whole numbers within a range.
pub(super) fn counts(least: u64, most: u64) -> impl Fn(&str) -> Result<u64, NotACount> + Clone + Send + Sync {
    move |text| {
        let count = text.parse().ok().filter(|count| (least..=most).contains(count));
        count.ok_or(NotACount { least, most })
    }
}

/// Neither a number nor all.
#[derive(Debug, Error)]
#[error("not a number of pulses; allowed: a whole number, or all")]
pub(super) struct NotPulses;

/// Reads a number of pulses, or all.
fn pulses_or_all(text: &str) -> Result<u64, NotPulses> {
    if text == "all" { Ok(u64::MAX) } else { text.parse().map_err(|_| NotPulses) }
}

/// Reads numbers of threads, as `stream.threads` has them.
pub(super) fn threads() -> impl Fn(&str) -> Result<u64, NotACount> + Clone + Send + Sync {
    match keys::stream::THREADS.kind {
        Kind::Count { min, max } => counts(min, max),
        _ => counts(0, u64::MAX),
    }
}

/// Not a length that a run can have.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: {}", keys::scene::DURATION_S.kind.allowed())]
pub struct NotADuration;

/// The length of a run, as `scene.duration_s` has it; the text itself becomes part of the recorded scenario.
fn duration(text: &str) -> Result<String, NotADuration> {
    let seconds: f64 = text.parse().map_err(|_| NotADuration)?;
    let fits = match keys::scene::DURATION_S.kind {
        Kind::Number { min, max, above, .. } => (min..=max).contains(&seconds) && !(above && seconds == min),
        _ => seconds.is_finite(),
    };
    if fits { Ok(text.to_owned()) } else { Err(NotADuration) }
}

/// Not a span of time.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: a number of seconds above 0, up to 1e9")]
pub struct NotASpan;

fn seconds(text: &str) -> Result<Duration, NotASpan> {
    let seconds: f64 = text.parse().map_err(|_| NotASpan)?;
    if seconds > 0.0 && seconds <= 1e9 { Ok(Duration::from_secs_f64(seconds)) } else { Err(NotASpan) }
}

/// How pulses are released.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Pace {
    /// At their emission times plus the latency
    Realtime,
    /// As soon as they are made
    Fast,
}

/// What was asked for, each once, in the order of asking.
pub(super) fn distinct(places: Vec<usize>) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::with_capacity(places.len());
    for place in places {
        if !kept.contains(&place) {
            kept.push(place);
        }
    }
    kept
}

/// A part of a run: pulses `first..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PulseRange {
    /// First pulse.
    pub first: u64,
    /// The pulse after the last one.
    pub end: u64,
}

/// Not a range of pulses.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: two whole numbers A..B, A below B, such as 100..200")]
pub struct NotARange;

impl FromStr for PulseRange {
    type Err = NotARange;

    fn from_str(text: &str) -> Result<Self, NotARange> {
        let (first, end) = text.split_once("..").ok_or(NotARange)?;
        let (first, end) = (first.parse().map_err(|_| NotARange)?, end.parse().map_err(|_| NotARange)?);
        if first < end { Ok(Self { first, end }) } else { Err(NotARange) }
    }
}

/// `KEY=VALUE` of `--set`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Dotted path of the key.
    pub key: String,
    /// The value, TOML or plain text.
    pub value: String,
}

/// Not `KEY=VALUE`.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("allowed: KEY=VALUE such as radar.prf_hz=500")]
pub struct NotASetting;

impl FromStr for Setting {
    type Err = NotASetting;

    fn from_str(text: &str) -> Result<Self, NotASetting> {
        let (key, value) = text.split_once('=').ok_or(NotASetting)?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err(NotASetting);
        }
        Ok(Self { key: key.to_owned(), value: value.to_owned() })
    }
}
