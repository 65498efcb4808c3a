//! `nereus nav convert`

use std::path::{Path, PathBuf};

use clap::Args;

use super::error::NavToolError;
use super::{RewriteArgs, Target, TargetArgs, solutions, write_file};
use crate::cli::error::CliError;
use crate::cli::escape;
use crate::cli::say;
use crate::nav::encode::{Format, csv};

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

/// Writes a recording in another format.
pub(super) fn convert(args: &NavConvertArgs) -> Result<(), CliError> {
    let target = match args.rewrite.target.to {
        Some(target) => target,
        None => named(&args.out).ok_or_else(|| NavToolError::Target { path: args.out.clone() })?,
    };
    let solutions = solutions(&args.file, &args.rewrite.source)?;
    let mut bytes = Vec::new();
    match format_of(target, &args.rewrite.target) {
        Some(format) => {
            for (number, solution) in (1..).zip(&solutions) {
                format.write(solution, &mut bytes).map_err(|source| NavToolError::Encode {
                    number,
                    time: solution.time.to_string(),
                    source,
                })?;
            }
        }
        None => csv::write(&solutions, &mut bytes),
    }
    // Nothing is made before all could be written.
    write_file(&args.out, args.rewrite.overwrite.force, &bytes)?;
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
