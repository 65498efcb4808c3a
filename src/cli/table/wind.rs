//! The wind at every height and in every law.

use std::io::Write;

use clap::Args;

use super::csv::{Cell, Table, bound};
use super::sea_keys::WindKeys;
use super::sweep::SpeedSweep;
use crate::cli::error::CliError;
use crate::sea::wind::cardone_roughness_m;

/// `nereus table wind`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableWindArgs {
    #[command(flatten)]
    wind: WindKeys,
    #[command(flatten)]
    sweep: SpeedSweep,
}

/// Prints the table.
pub(super) fn wind(args: &TableWindArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let winds = args.wind.listed_or_swept(args.sweep.sweep())?;
    bound(&[winds.len()])?;
    let mut table = Table::new(out);
    for wind in &winds {
        table.row(&[
            ("ustar_cardone_mps", Cell::Value(wind.ustar_cardone_mps)),
            ("ustar_wu_mps", Cell::Value(wind.ustar_wu_mps)),
            ("roughness_cardone_m", Cell::Value(cardone_roughness_m(wind.ustar_cardone_mps))),
            ("u10_mps", Cell::Value(wind.u10_mps)),
            ("u12p5_mps", Cell::Value(wind.u12_5_mps)),
            ("u19p5_mps", Cell::Value(wind.u19_5_mps)),
        ])?;
    }
    Ok(())
}
