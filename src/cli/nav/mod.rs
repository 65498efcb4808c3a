//! `nereus nav`: recorded navigation inspected, converted, played, corrupted, and changed in a run under way.

mod convert;
mod corrupt;
mod error;
mod inject;
mod inspect;
mod play;

use std::io::Write;
use std::path::Path;

use clap::{Args, Subcommand, ValueEnum};

use super::error::CliError;
use super::scenario::ForceArg;
use super::{escape, say};
use crate::files::{self, Draft, Holding, Recognised};
use crate::inputs;
use crate::nav::inspection::{Encoding, InspectionError, Reading, Recorded};
use crate::nav::solution::{Solution, derive_velocities};
use crate::nav::{Place, VerticalDatum};
use crate::sinks::port;

pub use convert::NavConvertArgs;
pub use corrupt::NavCorruptArgs;
pub use error::NavToolError;
pub use inject::NavInjectArgs;
pub use inspect::NavInspectArgs;
pub use play::NavPlayArgs;

/// `nereus nav`
#[derive(Debug, Args)]
pub struct NavArgs {
    /// What to do
    #[command(subcommand)]
    pub command: NavCommand,
}

/// Subcommands of `nereus nav`.
#[derive(Debug, Subcommand)]
pub enum NavCommand {
    /// Report what a recording holds: counts, span, gaps, rate, area, speeds
    Inspect(NavInspectArgs),
    /// Write a recording in another format
    Convert(NavConvertArgs),
    /// Send a recording to a port, in time
    Play(NavPlayArgs),
    /// Drop, flip and cut bytes of a file, to try readers on it
    Corrupt(NavCorruptArgs),
    /// Change what a platform reports in a run under way (nereus run --control), and print the answer
    Inject(NavInjectArgs),
}

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Source {
    /// Comma-separated values
    Csv,
    /// NMEA 0183 log, NovAtel messages among it
    Nmea,
    /// NovAtel INSPVAX, ASCII or binary
    Inspvax,
    /// Smoothed best estimate of trajectory (needs --gps-week)
    Sbet,
    /// Capture of a receiver's messages on a network, gzipped or not
    Pcap,
}

/// Formats that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// Comma-separated values
    Csv,
    /// NMEA 0183 sentences
    Nmea,
    /// NovAtel INSPVAX, ASCII
    Inspvaxa,
    /// NovAtel INSPVAX, binary
    Inspvaxb,
}

/// What heights of a recording are measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Datum {
    /// WGS-84 ellipsoid
    Ellipsoid,
    /// Mean sea level
    Msl,
}

/// How a recording is read.
#[derive(Clone, Debug, Args)]
pub struct SourceArgs {
    /// Format of the file [default: from what is in it, and its name]
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub from: Option<Source>,
    /// GPS week of the first record of an SBET
    #[arg(long, value_name = "WEEK")]
    pub gps_week: Option<u32>,
    /// What heights are measured from, where the file does not say (CSV, GGA without separation)
    #[arg(long, value_enum, default_value = "ellipsoid")]
    pub datum: Datum,
    /// Height of mean sea level above the ellipsoid
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true)]
    pub undulation_m: f64,
}

impl SourceArgs {
    fn reading(&self) -> Reading {
        Reading {
            encoding: self.from.map(|from| match from {
                Source::Csv => Encoding::Csv,
                Source::Nmea => Encoding::Nmea,
                Source::Inspvax => Encoding::Inspvax,
                Source::Sbet => Encoding::Sbet,
                Source::Pcap => Encoding::Pcap,
            }),
            gps_week: self.gps_week,
            datum: match self.datum {
                Datum::Ellipsoid => VerticalDatum::Ellipsoid,
                Datum::Msl => VerticalDatum::MeanSeaLevel,
            },
            undulation_m: self.undulation_m,
        }
    }
}

/// How states are written.
#[derive(Clone, Debug, Args)]
pub struct TargetArgs {
    /// Format to write [default: csv, nmea or inspvaxb, from the name of the output; nmea for ports]
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub to: Option<Target>,
    /// NMEA sentences, in this order
    #[arg(long, value_delimiter = ',', default_value = "GGA,RMC,VTG,HDT,ZDA,GST,PASHR", value_parser = sentence)]
    pub sentences: Vec<crate::nav::encode::Sentence>,
}

/// How a recording is read, and written again.
#[derive(Clone, Debug, Args)]
pub struct RewriteArgs {
    /// How it is read
    #[command(flatten)]
    pub source: SourceArgs,
    /// How it is written
    #[command(flatten)]
    pub target: TargetArgs,
    /// Files that exist
    #[command(flatten)]
    pub overwrite: ForceArg,
}

fn sentence(text: &str) -> Result<crate::nav::encode::Sentence, &'static str> {
    crate::nav::encode::Sentence::named(text).ok_or("allowed: GGA, RMC, VTG, HDT, ZDA, GST, PASHR")
}

/// Does what the arguments ask for.
pub(super) fn nav(args: &NavArgs, out: &mut dyn Write) -> Result<(), CliError> {
    match &args.command {
        NavCommand::Inspect(args) => inspect::inspect(args, out),
        NavCommand::Convert(args) => convert::convert(args),
        NavCommand::Play(args) => play::play(args),
        NavCommand::Corrupt(args) => corrupt::corrupt(args),
        NavCommand::Inject(args) => inject::inject(args, out),
    }
}

/// The states of a recording, to be written elsewhere. Velocities that it does not have are derived.
fn solutions(path: &Path, args: &SourceArgs) -> Result<Vec<Solution>, NavToolError> {
    let recording = Recorded::read(path, &args.reading())?.track.map_err(InspectionError::from)?;
    say(format_args!("{}: {}", escape::path(path), recording.report));
    if recording.fixes.iter().any(|fix| matches!(fix.place, Place::Local(_))) {
        return Err(NavToolError::Local { path: path.to_owned() });
    }
    let mut solutions: Vec<Solution> =
        recording.fixes.iter().filter_map(|fix| Solution::of_fix(fix, args.undulation_m)).collect();
    let derived = derive_velocities(&mut solutions);
    if derived > 0 {
        say(format_args!("velocities of {derived} fixes derived from their neighbours"));
    }
    Ok(solutions)
}

/// Makes a file; one that exists is replaced only by force, and only if it begins like navigation.
fn write_file(path: &Path, force: bool, bytes: &[u8]) -> Result<(), NavToolError> {
    let fault = |source| NavToolError::Write { path: path.to_owned(), source };
    // A pipe or a device is written as it is.
    if force && std::fs::metadata(path).is_ok_and(|data| !(data.is_file() || data.is_dir())) {
        return std::fs::OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut f| f.write_all(bytes))
            .map_err(fault);
    }
    files::preflight(path, force, &recognise)?;
    let (draft, mut file) = Draft::file(path)?;
    if let Err(source) = file.write_all(bytes) {
        draft.abandon();
        return Err(fault(source));
    }
    Ok(draft.finish(force, &recognise).map(|_| ())?)
}

/// Messages, or a table as `nav convert` makes it.
fn recognise(path: &Path) -> Recognised {
    let is_table = inputs::beginning(path, 15).is_some_and(|start| start == b"unix_s,lat_deg,");
    if is_table { Ok(Holding::File) } else { port::recognise(path) }
}
