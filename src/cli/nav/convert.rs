//! `nereus nav convert`

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::error::NavToolError;
use super::recorded::solutions;
use super::{SourceArgs, Target, TargetArgs, write_file};
use crate::cli::error::CliError;
use crate::cli::escape;
use crate::cli::say;
use crate::nav::encode::Format;
use crate::nav::solution::Solution;

/// `nereus nav convert`
#[derive(Debug, Args)]
pub struct NavConvertArgs {
    /// The recording
    pub file: PathBuf,
    /// The file to make
    pub out: PathBuf,
    /// How it is read
    #[command(flatten)]
    pub source: SourceArgs,
    /// How it is written
    #[command(flatten)]
    pub target: TargetArgs,
    /// Overwrite a file that exists
    #[arg(long)]
    pub force: bool,
}

/// Writes a recording in another format.
pub(super) fn convert(args: &NavConvertArgs) -> Result<(), CliError> {
    let target = match args.target.to {
        Some(target) => target,
        None => named(&args.out).ok_or_else(|| NavToolError::Target { path: args.out.clone() })?,
    };
    let solutions = solutions(&args.file, &args.source)?;
    let mut bytes = Vec::new();
    match format_of(target, &args.target) {
        Some(format) => {
            for (number, said) in (1..).zip(&solutions) {
                format.write(said, &mut bytes).map_err(|source| NavToolError::Encode {
                    number,
                    time: said.time.to_string(),
                    source,
                })?;
            }
        }
        None => csv(&solutions, &mut bytes),
    }
    // Nothing is made before all could be written.
    write_file(&args.out, args.force, &bytes)?;
    say(format_args!("{}: {} fixes, {} bytes", escape::path(&args.out), solutions.len(), bytes.len()));
    Ok(())
}

/// The format of messages; `None`: CSV.
pub(super) fn format_of(target: Target, args: &TargetArgs) -> Option<Format> {
    match target {
        Target::Csv => None,
        Target::Nmea => Some(Format::Nmea(args.sentences.clone())),
        Target::Inspvaxa => Some(Format::InspvaxAscii),
        Target::Inspvaxb => Some(Format::InspvaxBinary),
    }
}

fn named(path: &Path) -> Option<Target> {
    match path.extension()?.to_ascii_lowercase().to_str()? {
        "csv" => Some(Target::Csv),
        "nmea" => Some(Target::Nmea),
        "inspvaxa" => Some(Target::Inspvaxa),
        "inspvax" | "inspvaxb" => Some(Target::Inspvaxb),
        _ => None,
    }
}

/// Times to a nanosecond, degrees to 1e-11 (1e-6 m), heights to 1e-5 m, angles to 1e-9 deg.
fn csv(solutions: &[Solution], out: &mut Vec<u8>) {
    let turned = solutions.iter().all(|said| said.yaw_pitch_roll_rad.is_some());
    // Writing to memory does not fail.
    let _ = writeln!(
        out,
        "unix_s,lat_deg,lon_deg,height_m{}",
        if turned { ",yaw_deg,pitch_deg,roll_deg" } else { "" }
    );
    for said in solutions {
        let (mut seconds, mut ns) = (said.time.seconds(), (said.time.fraction_s() * 1e9).round() as u64);
        if ns >= 1_000_000_000 {
            (seconds, ns) = (seconds + 1, 0);
        }
        let place = said.place;
        let _ = write!(
            out,
            "{seconds}.{ns:09},{:.11},{:.11},{:.5}",
            place.lat_rad.to_degrees(),
            place.lon_rad.to_degrees(),
            place.h_m
        );
        if let Some([yaw, pitch, roll]) = said.yaw_pitch_roll_rad.filter(|_| turned) {
            let yaw = yaw.to_degrees().rem_euclid(360.0);
            let _ = write!(out, ",{yaw:.9},{:.9},{:.9}", pitch.to_degrees(), roll.to_degrees());
        }
        let _ = writeln!(out);
    }
}
