//! `nereus nav corrupt`

use std::path::PathBuf;

use clap::Args;
use rand::RngExt;

use super::error::NavToolError;
use super::write_file;
use crate::cli::error::CliError;
use crate::cli::escape;
use crate::cli::say;
use crate::nav::replay::read_bytes;
use crate::rng::{Room, stream};

/// The longest stretch that is cut, bytes.
const LONGEST_CUT: usize = 200;

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
    /// Overwrite a file that exists
    #[arg(long)]
    pub force: bool,
}

/// Spoils a file.
pub(super) fn corrupt(args: &NavCorruptArgs) -> Result<(), CliError> {
    for (key, value) in [("drop", args.drop), ("flip", args.flip), ("cut", args.cut)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(NavToolError::Range { key, value, allowed: "0 to 1" }.into());
        }
    }
    let bytes = read_bytes(&args.file).map_err(NavToolError::from)?;
    let mut random = stream(args.seed, Room::SpoiledBytes, 0, 0);
    let mut corrupted = Vec::with_capacity(bytes.len());
    let (mut dropped, mut flipped, mut cuts, mut cut_bytes) = (0u64, 0u64, 0u64, 0u64);
    let mut skip = 0;
    for byte in bytes {
        if skip > 0 {
            skip -= 1;
            cut_bytes += 1;
            continue;
        }
        // Every byte takes as many draws, whatever becomes of it.
        let draws: [f64; 3] = random.random();
        let (bit, length) = (random.random_range(0..8), random.random_range(1..=LONGEST_CUT));
        if draws[2] < args.cut {
            cuts += 1;
            skip = length;
        }
        if draws[0] < args.drop {
            dropped += 1;
            continue;
        }
        let flip = draws[1] < args.flip;
        flipped += u64::from(flip);
        corrupted.push(if flip { byte ^ (1 << bit) } else { byte });
    }
    write_file(&args.out, args.force, &corrupted)?;
    say(format_args!(
        "{}: {} bytes; {dropped} dropped, {flipped} with a bit flipped, {cut_bytes} cut in {cuts} stretches",
        escape::path(&args.out),
        corrupted.len()
    ));
    Ok(())
}
