//! `nereus nav corrupt`

use std::path::PathBuf;

use clap::Args;

use super::error::NavToolError;
use super::write_file;
use crate::cli::error::CliError;
use crate::cli::escape;
use crate::cli::say;
use crate::cli::scenario::ForceArg;
use crate::nav::corruption::{self, Chances, Corrupted};
use crate::nav::inspection::InspectionError;
use crate::nav::replay::read_bytes;

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

/// Corrupts a file.
pub(super) fn corrupt(args: &NavCorruptArgs) -> Result<(), CliError> {
    for (key, value) in [("drop", args.drop), ("flip", args.flip), ("cut", args.cut)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(NavToolError::Range { key, value, allowed: "0 to 1" }.into());
        }
    }
    let bytes = read_bytes(&args.file).map_err(InspectionError::from).map_err(NavToolError::from)?;
    let chances = Chances { drop: args.drop, flip: args.flip, cut: args.cut };
    let (corrupted, Corrupted { dropped, flipped, cuts, cut_bytes }) =
        corruption::corrupt(&bytes, chances, args.seed);
    write_file(&args.out, args.overwrite.force, &corrupted)?;
    say(format_args!(
        "{}: {} bytes; {dropped} dropped, {flipped} with a bit flipped, {cut_bytes} cut in {cuts} stretches",
        escape::path(&args.out),
        corrupted.len()
    ));
    Ok(())
}
