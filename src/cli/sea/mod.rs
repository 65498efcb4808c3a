//! `nereus sea`: the sea of a scenario at a time, as a map and a picture, and its state for reuse.
//!
//! The map is that of the patch at pulse 0; a patch that follows moves over the same water. With ships, whose
//! waves are part of the map, it lies where it does at the time asked. Files:
//! [`map_file`](crate::recording::map_file) with format `nereus-sea`, [`picture`](crate::plot::picture),
//! [`state`](crate::sea::surface::state).

mod paths;
mod error;
pub(super) mod field;
pub mod snapshot;
mod summary;

use crate::cli::outputs::{axes, outputs, save_png};
use crate::cli::scenario::ScenarioArgs;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

pub use error::SeaError;
pub use field::Field;

use super::error::CliError;
use super::{json, say, warn};
use crate::adequacy::patch_at;
use crate::config::Run;
use crate::pipeline::fault::BuildErrors;
use crate::plot::picture::Picture;
use crate::recording::map_file::{Attribute, Layer, MapFile};
use crate::recording::output::{FileKind, Output, OutputError};
use crate::scene::Patch;
use crate::scene::sea::Sea;
use crate::sea::facet_surface::FacetSurface;
use crate::sea::fleet::Fleet;
use crate::sea::realise::{Realised, realise};
use crate::sea::surface::{Fields, Selection};
use summary::Summary;

/// `nereus sea`
#[derive(Debug, Args)]
pub struct SeaArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Time after pulse 0
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true)]
    pub time_s: f64,
    /// Map to make: every field of the patch (HDF5)
    #[arg(long, value_name = "PATH.h5")]
    pub out: Option<PathBuf>,
    /// Picture to make
    #[arg(long, value_name = "PATH.png")]
    pub png: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = Field::Height)]
    pub field: Field,
    /// State of the sea to save, for sea.state_path of other scenarios
    #[arg(long, value_name = "PATH")]
    pub save_state: Option<PathBuf>,
    /// Overwrite files that exist
    #[arg(long)]
    pub force: bool,
    /// Print a summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    out: Option<PathBuf>,
    png: Option<PathBuf>,
    state: Option<PathBuf>,
}

/// The sea of a run at a time.
pub struct SeaMap {
    realised: Realised,
    patch: Patch,
    fields: Fields<f64>,
    summary: Summary,
}

impl SeaMap {
    /// Every field: name, unit, meaning, and a value for each facet, from South to North and in a row from
    /// West to East.
    pub fn layers(&self) -> impl Iterator<Item = (&'static str, &'static str, &'static str, &[f64])> {
        field::LAYERS
            .into_iter()
            .map(|(name, unit, meaning, values)| (name, unit, meaning, values(&self.fields)))
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
    let sheet = FacetSurface::new(&realised.surface, selection);
    let mut sheet = sheet.with_wakes(&fleet.wakes, &patch).map_err(SeaError::from)?;
    let mut fields = sheet.fields(&patch);
    sheet.evaluate(time_s, &patch, &mut fields).map_err(SeaError::from)?;
    let summary = Summary::new(&realised, &patch, &fields, time_s);
    Ok(SeaMap { realised, patch, fields, summary })
}

/// Makes the files that the arguments ask for, and tells what sea it is.
pub(super) fn sea(args: &SeaArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load(&[])?;
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
    let sea = run.scene.sea.as_ref().ok_or_else(|| SeaError::NoSea { path: run.path.clone() })?;
    let [map, picture, state] = outputs(
        [(&args.out, FileKind::Hdf5), (&args.png, FileKind::Png), (&args.save_state, FileKind::SeaState)],
        args.force,
    )?;
    let SeaMap { realised, patch, fields, summary } = evaluate(&run, sea, args.time_s, selection(args))?;
    for line in summary.lines() {
        say(line);
    }
    if let Some(output) = state {
        save(output, &realised)?;
    }
    if let Some(output) = map {
        write_map(output, &run.text, &patch, &fields, &summary)?;
    }
    if let Some(output) = picture {
        draw(output, args.field, &patch, &fields, args.time_s)?;
    }
    if args.out.is_none() && args.png.is_none() && args.save_state.is_none() {
        say("no file was asked for: --out, --png, --save-state");
    }
    if args.json {
        let [out_file, png, state] =
            [&args.out, &args.png, &args.save_state].map(|path| path.as_deref().map(json::legible));
        let report = Report { summary: &summary, out: out_file, png, state };
        json::print(&report, out)?;
    }
    Ok(())
}

/// Everything that is written; the summary wants height and slopes.
fn selection(args: &SeaArgs) -> Selection {
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

fn write_map(
    output: Output,
    config: &str,
    patch: &Patch,
    fields: &Fields<f64>,
    summary: &Summary,
) -> Result<(), SeaError> {
    let layers = field::LAYERS.map(|(name, unit, meaning, values)| {
        let values: &[f64] = values(fields);
        Layer { name, unit, meaning, values }
    });
    let software = format!("nereus {}", env!("CARGO_PKG_VERSION"));
    let attributes = [
        ("software", Attribute::Text(&software)),
        ("config", Attribute::Text(config)),
        ("seed", Attribute::Whole(summary.seed)),
        ("time_s", Attribute::Real(summary.time_s)),
        ("facet_m", Attribute::Real(summary.facet_m)),
        ("wind_10m_mps", Attribute::Real(summary.wind_10m_mps)),
        ("significant_height_m", Attribute::Real(summary.significant_height_m)),
        ("expected_significant_height_m", Attribute::Real(summary.expected_significant_height_m)),
    ];
    let file = MapFile { format: "nereus-sea", attributes: &attributes, patch, layers: &layers };
    output.write(|partial| Ok(file.write(partial)?))
}

fn draw(
    output: Output,
    field: Field,
    patch: &Patch,
    fields: &Fields<f64>,
    time_s: f64,
) -> Result<(), SeaError> {
    let [x, y] = axes(patch);
    let title = format!("{}, {time_s} s", field.title());
    let values = field.values(fields);
    let picture = Picture {
        title: &title,
        x,
        y,
        quantity: field.quantity(),
        colours: field.colours(),
        scale_bar: Some("m"),
        ..Picture::new(&values, patch.facets)?
    };
    save_png(output, &picture)
}
