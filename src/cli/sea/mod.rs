//! `nereus sea`: the sea of a scenario at a time, as a map and a picture, and its state for reuse.
//!
//! The map is [`SeaMap`]'s. Files: [`map_file`](crate::recording::map_file) with format `nereus-sea`,
//! [`picture`](crate::plot::picture), [`state`](crate::sea::surface::state).

mod map;
pub mod snapshot;

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

pub(super) use map::{MapArgs, files, outputs};

use super::error::CliError;
use super::report::Report;
use super::scenario::sea_of;
use crate::config::Run;
use crate::pipeline::sea_map::SeaMap;
use crate::recording::output::FileKind;
use crate::scene::sea::Waves;
use crate::sea::summary::Summary;
use crate::sea::surface::Selection;

/// `nereus sea`
#[derive(Debug, Args)]
pub struct SeaArgs {
    /// The map
    #[command(flatten)]
    pub map: MapArgs,
    /// State of the sea to save, for sea.state_path of other scenarios
    #[arg(long, value_name = "PATH")]
    pub save_state: Option<PathBuf>,
}

/// Fields that a map holds.
const WRITTEN: Selection = Selection { slope_rate: false, ..Selection::ALL };

/// The sea of a run at a time after pulse 0, with every field.
///
/// # Errors
/// A run without sea, and what keeps it from being made.
pub fn sea_at(run: &Run, time_s: f64) -> Result<SeaMap, CliError> {
    Ok(SeaMap::of(run, sea_of(run, &run.path)?, time_s, WRITTEN)?)
}

/// Makes the files that the arguments ask for, and reports what sea it is.
pub(super) fn sea(args: &SeaArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let SeaArgs { map: asked, save_state } = args;
    let run = asked.scenario.load_and_warn()?;
    let sea = sea_of(&run, &run.path)?;
    let [map, picture, state] = outputs(
        [(&asked.out, FileKind::Hdf5), (&asked.png, FileKind::Png), (save_state, FileKind::SeaState)],
        asked.output.overwrite.force,
    )?;
    // The summary wants height and slopes.
    let selection = Selection { slopes: true, ..asked.selection(WRITTEN) };
    let made = SeaMap::of(&run, sea, asked.time_s, selection)?;
    if let Some(output) = state {
        made.save_state(output)?;
    }
    if let Some(output) = map {
        made.save(output, &run.text)?;
    }
    if let Some(output) = picture {
        made.draw(asked.field)?.save(output)?;
    }
    let mut report = report(made.summary());
    if sea.waves == Waves::Choppy {
        report.line("choppy waves: heights and slopes are those of the facets where the displacement has carried them");
    }
    files(&mut report, [("out", &asked.out), ("png", &asked.png), ("state", save_state)]);
    if asked.out.is_none() && asked.png.is_none() && save_state.is_none() {
        report.line("no file was asked for: --out, --png, --save-state");
    }
    report.say(asked.output.format.json, out)
}

fn report(summary: &Summary) -> Report {
    let ([nx, ny], [sx, sy], [ex, ey]) = (summary.facets, summary.rms_slope, summary.expected_rms_slope);
    let mut report = Report::default();
    report
        .values(summary)
        .line(format!(
            "sea at {} s: {nx} x {ny} facets of {} m, seed {}, wind {:.1} m/s at 10 m",
            summary.time_s, summary.facet_m, summary.seed, summary.wind_10m_mps
        ))
        .line(format!(
            "significant height {:.2} m (expected {:.2} m), rms slopes {sx:.4} East, {sy:.4} North (expected {ex:.4}, {ey:.4})",
            summary.significant_height_m, summary.expected_significant_height_m
        ));
    let Some(peak_m) = summary.peak_wavelength_m else {
        report.line("the spectrum is that of still water");
        return report;
    };
    let [width_m, height_m] = summary.facets.map(|n| n as f64 * summary.facet_m);
    let least_m = summary.least_length_m;
    report.line(format!(
        "peak wavelength {peak_m:.1} m; patch {width_m} x {height_m} m, at least {least_m:.0} m a side hold the peak of the spectrum"
    ));
    if width_m.min(height_m) < least_m {
        report.warning(format!(
            "the patch is shorter than {least_m:.0} m: few waves near the peak fit it, and its height varies much with the seed"
        ));
    }
    report
}
