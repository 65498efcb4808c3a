//! `nereus export`: a recording as CRSD 1.0 or SigMF.

mod crsd;
mod sigmf;

use std::io::Write;

use clap::{Args, Subcommand};

use super::error::CliError;

pub use crsd::ExportCrsdArgs;
pub use sigmf::ExportSigmfArgs;

/// `nereus export`
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// The format
    #[command(subcommand)]
    pub format: ExportCommand,
}

/// Formats.
#[derive(Debug, Subcommand)]
pub enum ExportCommand {
    /// CRSD 1.0 (NGA.STND.0080): pulses, reported positions, antennas and errors in one file
    Crsd(ExportCrsdArgs),
    /// SigMF 1.2: samples of each channel, and an annotation per pulse
    Sigmf(ExportSigmfArgs),
}

/// Exports.
pub(super) fn export(args: &ExportArgs, out: &mut dyn Write) -> Result<(), CliError> {
    match &args.format {
        ExportCommand::Crsd(args) => crsd::crsd(args, out),
        ExportCommand::Sigmf(args) => sigmf::sigmf(args, out),
    }
}
