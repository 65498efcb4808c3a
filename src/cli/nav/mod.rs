//! `nereus nav`: recorded navigation inspected, converted, played, corrupted, and changed in a run under way.
//!
//! `corrupt` and `inject` are here, the rest in files of their own.

mod inspect;
mod rewrite;

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::error::{CliError, Refused};
use super::scenario::ForceArg;
use super::values::{Unreadable, Word, allowed, one_of};
use super::{escape, say};
use crate::inputs;
use crate::nav::corruption::{self, Chances, Corrupted};
use crate::nav::inspection::{Encoding, InspectionError, Reading};
use crate::nav::unpacked::MAX_FILE_BYTES;
use crate::nav::{NavError, VerticalDatum, csv};
use crate::pipeline::control_lines;
use crate::pipeline::playback::write_file;

use inspect::NavInspectArgs;
use rewrite::{NavConvertArgs, NavPlayArgs};

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
const ENCODINGS: [Word<Encoding>; 7] = [
    ("csv", "Comma-separated values", Encoding::Csv),
    ("nmea", "NMEA 0183 log, NovAtel messages among it", Encoding::Nmea),
    ("inspvax", "NovAtel INSPVAX, INSPVA or INSPVAS, ASCII or binary", Encoding::Inspvax),
    ("sbet", "Smoothed best estimate of trajectory (needs --gps-week)", Encoding::Sbet),
    ("gpx", "GPX, its tracks", Encoding::Gpx),
    ("kml", "KML, its tracks and points with times", Encoding::Kml),
    ("pcap", "Capture of a receiver's messages on a network, pcap or pcapng", Encoding::Pcap),
];
/// What heights of a recording are measured from.
const DATUMS: [Word<VerticalDatum>; 2] = [
    ("ellipsoid", "WGS-84 ellipsoid", VerticalDatum::Ellipsoid),
    ("msl", "Mean sea level", VerticalDatum::MeanSeaLevel),
];

/// How a recording is read.
#[derive(Clone, Debug, Args)]
pub struct SourceArgs {
    /// Format of the file [default: from what is in it, and its name]
    #[arg(long, value_parser = one_of(ENCODINGS), value_name = "FORMAT")]
    pub from: Option<Encoding>,
    /// GPS week of the first record of an SBET
    #[arg(long, value_name = "WEEK")]
    pub gps_week: Option<u32>,
    /// What heights are measured from, where the file does not say (CSV, GGA without separation) [default:
    /// ellipsoid]
    #[arg(long, value_parser = one_of(DATUMS))]
    pub datum: Option<VerticalDatum>,
    /// Height of mean sea level above the ellipsoid
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true)]
    pub undulation_m: f64,
    /// Date of the first position of an NMEA log, in place of its own dates
    #[arg(long, value_name = "DATE", value_parser = day)]
    pub date: Option<i64>,
}

/// Days since 1970-01-01 of a date.
fn day(text: &str) -> Result<i64, Unreadable> {
    allowed(csv::day(text), "a date such as 2024-05-01")
}

impl SourceArgs {
    fn reading(&self) -> Reading {
        let &Self { from: encoding, gps_week, datum, undulation_m, date: first_day } = self;
        Reading { encoding, gps_week, datum, undulation_m, first_day }
    }
}

/// `nereus nav corrupt`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct NavCorruptArgs {
    /// The file
    pub file: PathBuf,
    /// The file to make
    pub out: PathBuf,
    /// Chance of a byte to be lost
    #[arg(long, value_name = "P", default_value_t = 1e-4)]
    pub drop: f64,
    /// Chance of a byte to have one of its bits flipped
    #[arg(long, value_name = "P", default_value_t = 1e-4)]
    pub flip: f64,
    /// Chance of a stretch of 1 to 200 bytes to be cut out behind a byte
    #[arg(long, value_name = "P", default_value_t = 1e-5)]
    pub cut: f64,
    /// The same seed corrupts the same bytes
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Files that exist
    #[command(flatten)]
    pub overwrite: ForceArg,
}

/// `nereus nav inject`
#[derive(Debug, Args)]
pub struct NavInjectArgs {
    /// Socket of the run (its --control)
    pub socket: PathBuf,
    /// Command, such as step position.up 5 m (docs/control.md)
    #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub line: Vec<String>,
}

/// Does what the arguments ask for.
pub(super) fn nav(args: &NavArgs, out: &mut dyn Write) -> Result<(), CliError> {
    match &args.command {
        NavCommand::Inspect(args) => inspect::inspect(args, out),
        NavCommand::Convert(args) => rewrite::convert(args),
        NavCommand::Play(args) => rewrite::play(args),
        NavCommand::Corrupt(args) => corrupt(args),
        NavCommand::Inject(args) => {
            let answer = control_lines::command(&args.socket, &args.line.join(" "))?;
            writeln!(out, "{answer}").map_err(CliError::Output)
        }
    }
}

fn corrupt(args: &NavCorruptArgs) -> Result<(), CliError> {
    let &NavCorruptArgs { drop, flip, cut, seed, .. } = args;
    for (key, value) in [("drop", drop), ("flip", flip), ("cut", cut)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(Refused::value(key, value, "0 to 1").into());
        }
    }
    // As it lies there, packed or not.
    let bytes = inputs::read(&args.file, MAX_FILE_BYTES)
        .map_err(|source| NavError::Read { path: args.file.clone(), source })
        .and_then(|bytes| match bytes.len() as u64 {
            0..=MAX_FILE_BYTES => Ok(bytes),
            _ => Err(NavError::TooLarge { path: args.file.clone(), allowed_bytes: MAX_FILE_BYTES }),
        })
        .map_err(InspectionError::from)?;
    let (corrupted, counts) = corruption::corrupt(&bytes, Chances { drop, flip, cut }, seed);
    write_file(&args.out, args.overwrite.force, &corrupted)?;
    let Corrupted { dropped, flipped, cuts, cut_bytes } = counts;
    say(format_args!(
        "{}: {} bytes; {dropped} dropped, {flipped} with a bit flipped, {cut_bytes} cut in {cuts} stretches",
        escape::path(&args.out),
        corrupted.len()
    ));
    Ok(())
}
