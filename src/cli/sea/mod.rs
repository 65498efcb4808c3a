//! `nereus sea`: the sea of a scenario at a time, as a map and a picture, and its state for reuse.
//!
//! The map is that of the patch at pulse 0; a patch that follows moves over the same water. With ships, whose
//! waves are part of the map, it lies where it does at the time asked. Files:
//! [`map_file`](crate::recording::map_file) with format `nereus-sea`, [`picture`](crate::plot::picture),
//! [`state`](crate::sea::surface::state).

mod error;
pub(super) mod field;
mod paths;
pub mod snapshot;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

pub use error::SeaError;
pub use field::{Field, MapArgs};

use super::error::CliError;
use super::outputs::outputs;
use super::report::Report;
use super::warn;
use crate::adequacy::patch_at;
use crate::config::Run;
use crate::pipeline::fault::BuildErrors;
use crate::recording::field_file::Attribute;
use crate::recording::map_file::{Layer, sea_layers};
use crate::recording::output::{FileKind, Output, OutputError};
use crate::scene::Patch;
use crate::scene::sea::{Sea, Waves};
use crate::sea::facet_surface::FacetSurface;
use crate::sea::fleet::Fleet;
use crate::sea::realise::{Realised, realise};
use crate::sea::summary::Summary;
use crate::sea::surface::choppy::Choppy;
use crate::sea::surface::{Fields, Selection};
use field::{files, write_map};

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

/// The sea of a run at a time.
pub struct SeaMap {
    realised: Realised,
    patch: Patch,
    fields: Fields<f64>,
    summary: Summary,
}

impl SeaMap {
    /// Every field, facet by facet from South to North and in a row from West to East.
    pub fn layers(&self) -> [Layer<'_>; 11] {
        sea_layers(&self.fields)
    }

    /// Centres of the facets, East and North, m.
    pub fn axes_m(&self) -> [Vec<f64>; 2] {
        let Patch { facets, facet_m, first } = self.patch;
        [0, 1].map(|axis| {
            let places = first[axis]..first[axis] + facets[axis] as i64;
            places.map(|place| place as f64 * facet_m).collect()
        })
    }

    /// The sea in figures: what `nereus sea --json` prints.
    pub fn summary(&self) -> impl Serialize {
        &self.summary
    }
}

/// The sea of a run at a time after pulse 0, with every field.
///
/// # Errors
/// A run without sea, and what keeps it from being made.
pub fn sea_at(run: &Run, time_s: f64) -> Result<SeaMap, CliError> {
    let sea = run.scene.sea.as_ref().ok_or_else(|| SeaError::NoSea { path: run.path.clone() })?;
    evaluate(run, sea, time_s, Selection { slope_rate: false, ..Selection::ALL })
}

fn evaluate(run: &Run, sea: &Sea, time_s: f64, selection: Selection) -> Result<SeaMap, CliError> {
    let realised = realise(sea, run.scene.seed).map_err(SeaError::from)?;
    let ships = &run.scene.ships;
    // Ships do not repeat with the waves of the wind: it matters where the patch lies.
    let patch = if ships.is_empty() { sea.patch } else { patch_at(run, sea, time_s)? };
    let fleet = Fleet::muster(ships, &[(time_s, patch)]).map_err(BuildErrors::from)?;
    let choppy = (sea.waves == Waves::Choppy).then(|| Choppy::of(&realised.surface));
    let surface = FacetSurface::new(&realised.surface, selection).with_choppy(choppy);
    let mut surface = surface.with_wakes(&fleet.wakes, &patch).map_err(SeaError::from)?;
    let mut fields = surface.fields(&patch);
    surface.evaluate(time_s, &patch, &mut fields).map_err(SeaError::from)?;
    let summary = Summary::new(&realised, &patch, &fields, time_s);
    Ok(SeaMap { realised, patch, fields, summary })
}

/// Makes the files that the arguments ask for, and reports what sea it is.
pub(super) fn sea(args: &SeaArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let SeaArgs { map: asked, save_state } = args;
    let run = asked.scenario.load(&[])?;
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
    let sea = run.scene.sea.as_ref().ok_or_else(|| SeaError::NoSea { path: run.path.clone() })?;
    let [map, picture, state] = outputs(
        [(&asked.out, FileKind::Hdf5), (&asked.png, FileKind::Png), (save_state, FileKind::SeaState)],
        asked.output.overwrite.force,
    )?;
    let SeaMap { realised, patch, fields, summary } = evaluate(&run, sea, asked.time_s, selection(asked))?;
    if let Some(output) = state {
        save(output, &realised)?;
    }
    if let Some(output) = map {
        write_map(output, "nereus-sea", &run.text, &attributes(&summary), &patch, &fields)?;
    }
    if let Some(output) = picture {
        let title = format!("{}, {} s", asked.field.title(), asked.time_s);
        asked.field.draw(output, &title, &patch, &fields)?;
    }
    let mut report = report(&summary);
    if sea.waves == Waves::Choppy {
        report.line("choppy waves: heights and slopes are those of the facets where the displacement has carried them");
    }
    files(&mut report, [("out", &asked.out), ("png", &asked.png), ("state", save_state)]);
    if asked.out.is_none() && asked.png.is_none() && save_state.is_none() {
        report.line("no file was asked for: --out, --png, --save-state");
    }
    report.say(asked.output.format.json, out)
}

/// Everything that is written; the summary wants height and slopes.
fn selection(args: &MapArgs) -> Selection {
    if args.out.is_some() {
        return Selection { slope_rate: false, ..Selection::ALL };
    }
    let wanted = if args.png.is_some() { args.field.selection() } else { Selection::HEIGHT };
    Selection { slopes: true, ..wanted }
}

fn save(output: Output, realised: &Realised) -> Result<(), SeaError> {
    output.write(|partial| {
        let file = File::create_new(partial).map_err(OutputError::io(partial, "making the file"))?;
        Ok(realised.surface.save(&mut BufWriter::new(file))?)
    })
}

fn attributes(summary: &Summary) -> [(&'static str, Attribute<'static>); 6] {
    [
        ("seed", Attribute::Whole(summary.seed)),
        ("time_s", Attribute::Real(summary.time_s)),
        ("facet_m", Attribute::Real(summary.facet_m)),
        ("wind_10m_mps", Attribute::Real(summary.wind_10m_mps)),
        ("significant_height_m", Attribute::Real(summary.significant_height_m)),
        ("expected_significant_height_m", Attribute::Real(summary.expected_significant_height_m)),
    ]
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
