//! `nereus snapshot`: what every facet contributes to the echo of one pulse.
//!
//! `10 log10 |a|^2` of each facet's amplitude `a` in a channel (sqrt(W), before noise and converter), for the
//! emission of the pulse, whatever its receive window receives of it. Facets that return nothing (behind an
//! antenna, hidden, turned away) are masked. The HDF5 file has the contributions of all channels, delays,
//! Doppler, heights, and whether the window receives a facet.
//!
//! `--paths` writes what the echo of the pulse is made of, facets, targets and direct paths alike
//! ([`path_file`](crate::recording::path_file)); for that alone the scenario needs no sea.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{files, outputs};
use crate::cli::error::{CliError, Refused};
use crate::cli::report::Report;
use crate::cli::scenario::{OutputArgs, ScenarioArgs, channel_of, sea_of};
use crate::cli::values::counts;
use crate::echo::Fidelity;
use crate::paths::snapshot::Snapshot;
use crate::pipeline::changing;
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::plot::patch::contributions;
use crate::recording::output::FileKind;
use crate::recording::{path_file, snapshot_file};

/// `nereus snapshot`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct SnapshotArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// The pulse
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = counts(0, u64::MAX))]
    pub pulse: u64,
    /// The channel that the picture shows [default: the last one]
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Map to make: contributions of all channels, delays, Doppler, heights (HDF5)
    #[arg(long, value_name = "PATH.h5")]
    pub out: Option<PathBuf>,
    /// Scatterer paths of the pulse to write: delays, rates, amplitudes of every channel (HDF5)
    #[arg(long, value_name = "PATH.h5")]
    pub paths: Option<PathBuf>,
    /// Picture to make
    #[arg(long, value_name = "PATH.png")]
    pub png: Option<PathBuf>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Makes the files that the arguments ask for, and reports what is illuminated.
pub fn snapshot(args: &SnapshotArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load_and_warn()?;
    let scene = &run.scene;
    let mapped = args.out.is_some() || args.png.is_some();
    if mapped || args.paths.is_none() {
        sea_of(&run, &args.scenario.config)?;
    }
    let names: Vec<&str> = scene.radar.channels.iter().map(|channel| channel.name.as_str()).collect();
    let shown = match &args.channel {
        None => names.len() - 1,
        Some(name) => channel_of(&run, name)?,
    };
    if args.pulse >= scene.pulses {
        return Err(Refused::NoPulse { pulse: args.pulse, pulses: scene.pulses }.into());
    }
    let asked = [&args.out, &args.paths, &args.png];
    let [hdf5, png] = [FileKind::Hdf5, FileKind::Png];
    let [map, list, picture] =
        outputs([(asked[0], hdf5), (asked[1], hdf5), (asked[2], png)], args.output.overwrite.force)?;
    let factory = changing::factory(&run, &Fidelity::Reference)?;
    // The pulse is in the run and the tracks cover it.
    let lost = |error| BuildErrors::from(BuildError::Radar(error));
    let snapshot = factory.snapshots(&[args.pulse]).map_err(lost)?.pop();
    let mut report = Report::default();
    add_facets(&mut report, args.pulse, &names, snapshot.as_ref());
    if let Some(snapshot) = &snapshot {
        if let Some(output) = map {
            output.write(|partial| {
                Ok::<_, CliError>(snapshot_file::write(partial, scene, &run.text, snapshot)?)
            })?;
        }
        if let Some(output) = picture {
            contributions(snapshot, shown, names[shown])?.save(output)?;
        }
    }
    files(&mut report, [("out", &args.out), ("png", &args.png), ("paths", &args.paths)]);
    let mut count = None;
    if let Some(output) = list {
        let (pulse, paths) = factory.scatterer_paths(args.pulse).map_err(lost)?;
        let pairs = factory.channel_pairs();
        let write = |path: &_| path_file::write(path, scene, &run.text, &pulse, pairs, &paths);
        output.write(|partial| Ok::<_, CliError>(write(partial)?))?;
        report.line(format!("pulse {}: {} paths", args.pulse, paths.len()));
        count = Some(paths.len());
    }
    report.value("path_count", count);
    if !mapped && args.paths.is_none() {
        report.line("no file was asked for: --out, --png, --paths");
    }
    report.say(args.output.format.json, out)
}

/// Facets that return something in any channel, how many of them the window receives, and by channel the
/// strongest facet and the sum of all, dBW.
fn add_facets(report: &mut Report, pulse: u64, names: &[&str], snapshot: Option<&Snapshot>) {
    let (mut facets, mut illuminated, mut received, mut channels) = (0, 0, 0, Vec::new());
    if let Some(snapshot) = snapshot {
        facets = snapshot.patch.len();
        (illuminated, received) = snapshot.counts();
        report.line(format!(
            "pulse {pulse}: {illuminated} of {facets} facets return something; {received} of them within the receive window"
        ));
        for (channel, name) in names.iter().enumerate() {
            let levels = snapshot.levels_dbw(channel);
            report.line(match levels {
                Some([strongest, sum]) => {
                    format!("{name}: strongest facet {strongest:.1} dBW, sum of powers {sum:.1} dBW")
                }
                None => format!("{name}: nothing"),
            });
            channels.push((*name, levels.map(|[strongest, _]| strongest), levels.map(|[_, sum]| sum)));
        }
    }
    report.value("pulse", pulse).value("facets", facets).value("illuminated", illuminated);
    report.value("received", received).value("channels", channels);
}
