//! `nereus export sigmf`: a recording as SigMF.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use crate::cli::error::CliError;
use crate::cli::report::Report;
use crate::cli::scenario::OutputArgs;
use crate::cli::values::PulseRange;
use crate::cli::{counted, escape};
use crate::recording::examination::examine;
use crate::recording::sigmf::{self, Settings};

/// `nereus export sigmf`
#[derive(Debug, Args)]
pub struct ExportSigmfArgs {
    /// Recording: an HDF5 file or a plain folder
    pub recording: PathBuf,
    /// Name of the SigMF recording, with or without ending; several channels add their names [default: the
    /// recording's name]
    #[arg(long, value_name = "NAME")]
    pub out: Option<PathBuf>,
    /// Channels to export [default: all]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// Export only these pulses, the last one excluded
    #[arg(long, value_name = "A..B")]
    pub pulses: Option<PulseRange>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Exports.
pub(super) fn sigmf(args: &ExportSigmfArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let path = &args.recording;
    examine(path)?;
    let settings = Settings {
        out: args.out.clone().unwrap_or_else(|| path.with_extension("")),
        channels: args.channel.clone(),
        pulses: args.pulses.map(Into::into),
        force: args.output.overwrite.force,
    };
    let made = sigmf::export(path, &settings)?;
    let mut report = Report::default();
    report.values(&made);
    if !args.output.format.json {
        let channels = counted(made.channels.len() as u64, "channel");
        let (pulses, datatype) = (counted(made.pulses as u64, "pulse"), made.datatype);
        report.line(format!("{pulses} of {channels}, {} samples of {datatype} each", made.samples));
        for file in &made.out {
            report.line(escape::path(file).to_string());
        }
    }
    report.say(args.output.format.json, out)
}
