//! `nereus export crsd`: a recording as CRSD 1.0.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use crate::cli::error::CliError;
use crate::cli::escape;
use crate::cli::report::Report;
use crate::cli::scenario::OutputArgs;
use crate::pipeline::scenario::Scenario;
use crate::recording::Recording;
use crate::recording::crsd::{self, CrsdError, Described, Description, ExportError, Exported};
use crate::recording::examination::examine;
use crate::recording::output::{FileKind, Output};

/// `nereus export crsd`
#[derive(Debug, Args)]
pub struct ExportCrsdArgs {
    /// Recording: an HDF5 file or a plain folder
    pub recording: PathBuf,
    /// The file to make [default: the recording's name with .crsd]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Channels to export [default: all channels of echoes]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Exports.
pub(super) fn crsd(args: &ExportCrsdArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let path = &args.recording;
    let to = args.out.clone().unwrap_or_else(|| path.with_extension("crsd"));
    let of = |error: CrsdError| error.of(path);
    let plan = |to| Output::plan(to, FileKind::Crsd, args.output.overwrite.force).map_err(CrsdError::from);
    let output = plan(&to).map_err(of)?;
    examine(path)?;
    // The columns are read again, block by block.
    let recording =
        Recording::open_channels::<CrsdError>(path, None, None, |_| Ok(Vec::new())).map_err(of)?;
    let header = recording.header.clone();
    if !header.truth {
        return Err(of(CrsdError::Received).into());
    }
    let scenario = Scenario::of(&recording)
        .map_err(|error| ExportError::Scenario { path: path.clone(), detail: error.to_string() })?;
    drop(recording);
    let run = &scenario.0;
    let described = Described { header: &header, scene: &run.scene, nav: &run.nav, clocks: &run.clocks };
    let description = Description::new(described, &args.channel).map_err(of)?;
    let channels = description.channels().map(str::to_owned).collect::<Vec<_>>();
    let mut exported = Exported { pulses: 0, bytes: 0 };
    output
        .write(|partial| {
            exported = crsd::export(path, description, partial, &to)?;
            Ok::<_, CrsdError>(())
        })
        .map_err(of)?;
    let names = header.channels.iter().map(|channel| channel.name.clone());
    let left_out: Vec<String> = names.filter(|name| !channels.contains(name)).collect();
    let Exported { pulses, bytes } = exported;
    let mut report = Report::default();
    report.value("out", to.to_string_lossy()).value("pulses", pulses).value("bytes", bytes);
    report.value("channels", &channels).value("left_out", &left_out);
    if !args.output.format.json {
        let path = escape::path(&to);
        report.line(format!("{path}: {pulses} pulses, {} channels, {bytes} bytes", channels.len()));
        if !left_out.is_empty() {
            report.line(format!("left out: {}", left_out.join(", ")));
        }
    }
    report.say(args.output.format.json, out)
}
