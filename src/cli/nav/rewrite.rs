//! `nereus nav convert` and `nereus nav play`: a recording in another format, to a file or to a port.

use std::path::{Path, PathBuf};

use clap::Args;

use super::SourceArgs;
use crate::cli::error::{CliError, Refused};
use crate::cli::scenario::ForceArg;
use crate::cli::values::{Unreadable, Word, allowed, one_of};
use crate::cli::{escape, say};
use crate::nav::Place;
use crate::nav::encode::{Format, OutputFormat, Sentence};
use crate::nav::inspection::{InspectionError, Recorded};
use crate::nav::solution::{Solution, derive_velocities};
use crate::pipeline::playback::{self, Played};
use crate::sinks::port::Device;

/// Word of a format that is written; NMEA sentences are those of `--sentences`.
#[derive(Clone, Copy, Debug)]
enum Written {
    Csv,
    Kml,
    Nmea,
    InspvaxAscii,
    InspvaxBinary,
}

const WRITTEN: [Word<Written>; 5] = [
    ("csv", "Comma-separated values", Written::Csv),
    ("kml", "KML, a track with times", Written::Kml),
    ("nmea", "NMEA 0183 sentences", Written::Nmea),
    ("inspvaxa", "NovAtel INSPVAX, ASCII", Written::InspvaxAscii),
    ("inspvaxb", "NovAtel INSPVAX, binary", Written::InspvaxBinary),
];

/// How states are written.
#[derive(Clone, Debug, Args)]
pub struct TargetArgs {
    /// Format to write [default: csv, kml, nmea or inspvaxb, from the name of the output; nmea for ports]
    #[arg(long, value_parser = one_of(WRITTEN), value_name = "FORMAT")]
    to: Option<Written>,
    /// NMEA sentences, in this order
    #[arg(long, value_delimiter = ',', default_value = "GGA,RMC,VTG,HDT,ZDA,GST,PASHR", value_parser = sentence)]
    pub sentences: Vec<Sentence>,
}

impl TargetArgs {
    /// The format asked for.
    fn target(&self) -> Option<OutputFormat> {
        Some(match self.to? {
            Written::Csv => OutputFormat::Csv,
            Written::Kml => OutputFormat::Kml,
            Written::Nmea => OutputFormat::Messages(Format::Nmea(self.sentences.clone())),
            Written::InspvaxAscii => OutputFormat::Messages(Format::InspvaxAscii),
            Written::InspvaxBinary => OutputFormat::Messages(Format::InspvaxBinary),
        })
    }
}

fn sentence(text: &str) -> Result<Sentence, Unreadable> {
    allowed(Sentence::named(text), "GGA, RMC, VTG, HDT, ZDA, GST, PASHR")
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

/// `nereus nav convert`
#[derive(Debug, Args)]
pub struct NavConvertArgs {
    /// The recording
    pub file: PathBuf,
    /// The file to make
    pub out: PathBuf,
    /// How it is read and written
    #[command(flatten)]
    pub rewrite: RewriteArgs,
}

/// `nereus nav play`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct NavPlayArgs {
    /// The recording
    pub file: PathBuf,
    /// Path of a serial port or pseudo terminal, file:PATH, tcp://ADDRESS:PORT, or udp://ADDRESS:PORT
    pub device: String,
    /// How much faster than it was recorded
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub rate: f64,
    /// Bits per second of a serial port
    #[arg(long, default_value_t = 115_200)]
    pub baud: u32,
    /// How it is read and sent
    #[command(flatten)]
    pub rewrite: RewriteArgs,
}

/// The states of a recording, to be written elsewhere. Velocities that it does not have are derived.
fn solutions(path: &Path, args: &SourceArgs) -> Result<Vec<Solution>, CliError> {
    let recording = Recorded::read(path, &args.reading())?.track.map_err(InspectionError::from)?;
    say(format_args!("{}: {}", escape::path(path), recording.report));
    if recording.fixes.iter().any(|fix| matches!(fix.place, Place::Local(_))) {
        return Err(Refused::Local(path.to_owned()).into());
    }
    let mut solutions: Vec<Solution> =
        recording.fixes.iter().filter_map(|fix| Solution::of_fix(fix, args.undulation_m)).collect();
    let derived = derive_velocities(&mut solutions);
    if derived > 0 {
        say(format_args!("velocities of {derived} fixes derived from their neighbours"));
    }
    Ok(solutions)
}

/// Writes a recording in another format.
pub(super) fn convert(args: &NavConvertArgs) -> Result<(), CliError> {
    let NavConvertArgs { file, out, rewrite } = args;
    let target = rewrite.target.target().or_else(|| OutputFormat::named(out, &rewrite.target.sentences));
    let target = target.ok_or_else(|| Refused::Target(out.clone()))?;
    let solutions = solutions(file, &rewrite.source)?;
    // Nothing is made before all could be written.
    let bytes = target.encode(&solutions).map_err(playback::PlaybackError::from)?;
    playback::write_file(out, rewrite.overwrite.force, &bytes)?;
    say(format_args!("{}: {} fixes, {} bytes", escape::path(out), solutions.len(), bytes.len()));
    Ok(())
}

/// Sends a recording, every message at its time.
pub(super) fn play(args: &NavPlayArgs) -> Result<(), CliError> {
    let NavPlayArgs { file, rate, rewrite, .. } = args;
    if !(1e-3..=1e6).contains(rate) {
        return Err(Refused::value("rate", rate, "0.001 to 1e6").into());
    }
    let device = Device::of(&args.device, args.baud)?;
    let solutions = solutions(file, &rewrite.source)?;
    let format = match rewrite.target.target() {
        Some(OutputFormat::Messages(format)) => format,
        _ => Format::Nmea(rewrite.target.sentences.clone()),
    };
    if solutions.is_empty() {
        return Ok(());
    }
    let Played { counts, lasted } =
        playback::play(&solutions, &format, &device, *rate, rewrite.overwrite.force)?;
    say(format_args!(
        "{device}: {} messages of {} sent in {:.1} s, {} lost; vanished {} times",
        counts.messages,
        solutions.len(),
        lasted.as_secs_f64(),
        counts.lost_messages,
        counts.vanished
    ));
    Ok(())
}
