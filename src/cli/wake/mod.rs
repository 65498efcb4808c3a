//! `nereus wake`: the waves of the ships of a scenario alone, as a map and a picture, as cuts, and what they
//! cost.
//!
//! The map is that of the patch where it lies at the time asked. Files:
//! [`map_file`](crate::recording::map_file) with format `nereus-wake` and the fields of `nereus sea`,
//! [`picture`](crate::plot::picture). Cuts ([`cut`]) are those of one ship each, printed as CSV.

mod cut;

use crate::cli::scenario::ScenarioArgs;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::error::CliError;
use super::json;
use super::sea::{Field, SeaError, field};
use super::{say, warn};
use crate::adequacy::description::ships::figures;
use crate::adequacy::{ShipOutlook, patch_at};
use crate::cli::outputs::{axes, outputs, save_png};
use crate::pipeline::fault::BuildErrors;
use crate::plot::picture::Picture;
use crate::recording::map_file::{Attribute, Layer, MapFile};
use crate::recording::output::{FileKind, Output};
use crate::scene::Patch;
use crate::sea::fleet::Fleet;
use crate::sea::surface::{Fields, Selection};
use cut::{Cut, Line, Way};

/// `nereus wake`
#[derive(Debug, Args)]
pub struct WakeArgs {
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
    /// Cuts along the track, so far to starboard of every ship, m: CSV
    #[arg(long, value_name = "Y,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub cut_starboard_m: Vec<f64>,
    /// Cuts across the track, so far astern of midship of every ship, m: CSV
    #[arg(long, value_name = "X,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub cut_astern_m: Vec<f64>,
    /// Step along a cut, m [default: a facet]
    #[arg(long, value_name = "M")]
    pub cut_step_m: Option<f64>,
    /// Overwrite files that exist
    #[arg(long)]
    pub force: bool,
    /// Print a summary as one JSON object, cuts included, instead of CSV
    #[arg(long)]
    pub json: bool,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report<'a> {
    time_s: f64,
    facets: [usize; 2],
    facet_m: f64,
    /// Lowest and highest water of the map, m.
    height_range_m: [f64; 2],
    ships: &'a [ShipOutlook],
    cuts: &'a [Cut],
    out: Option<PathBuf>,
    png: Option<PathBuf>,
}

/// Makes the files that the arguments ask for, prints cuts, and tells what ships they are.
pub(super) fn wake(args: &WakeArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load(&[])?;
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
    let sea = run.scene.sea.as_ref().ok_or_else(|| SeaError::NoSea { path: args.scenario.config.clone() })?;
    let ships = &run.scene.ships;
    if ships.is_empty() {
        return Err(SeaError::NoShip { path: args.scenario.config.clone() }.into());
    }
    let lines = lines(args, sea.patch.facet_m)?;
    let [map, picture] = outputs([(&args.out, FileKind::Hdf5), (&args.png, FileKind::Png)], args.force)?;
    let patch = patch_at(&run, sea, args.time_s)?;
    let fleet = Fleet::muster(ships, &[(args.time_s, patch)]).map_err(BuildErrors::from)?;
    let outlooks = ships
        .iter()
        .map(|ship| ShipOutlook::of(ship, patch.facet_m).map_err(BuildErrors::from))
        .collect::<Result<Vec<_>, _>>()?;
    for ship in &outlooks {
        say(format_args!("{}: {}", ship.name, figures(ship)));
    }
    let fields = fleet.waves(&patch, selection(args), args.time_s).map_err(SeaError::from)?;
    let height_range_m = fields
        .height_m
        .iter()
        .fold([0.0_f64; 2], |[low, high], height_m| [low.min(*height_m), high.max(*height_m)]);
    let [low_m, high_m] = height_range_m;
    say(format_args!("on the map the wakes are {low_m:.3} to {high_m:.3} m high"));
    // Ships whose waves are off have none in the fleet.
    let sailing = ships.iter().filter(|ship| ship.kelvin.is_some()).zip(&fleet.wakes);
    let mut cuts = Vec::new();
    for (ship, wake) in sailing {
        for line in &lines {
            cuts.push(Cut::of(&ship.name, wake, line, &patch, args.time_s).map_err(SeaError::from)?);
        }
    }
    if let Some(output) = map {
        write_map(output, &run.text, &patch, &fields, args.time_s)?;
    }
    if let Some(output) = picture {
        draw(output, args, &patch, &fields, &outlooks)?;
    }
    if args.out.is_none() && args.png.is_none() && lines.is_empty() {
        say("nothing was asked for: --out, --png, --cut-starboard-m, --cut-astern-m");
    }
    if args.json {
        let report = Report {
            time_s: args.time_s,
            facets: patch.facets,
            facet_m: patch.facet_m,
            height_range_m,
            ships: &outlooks,
            cuts: &cuts,
            out: args.out.as_deref().map(json::legible),
            png: args.png.as_deref().map(json::legible),
        };
        json::print(&report, out)
    } else if lines.is_empty() {
        Ok(())
    } else {
        cut::print(&cuts, out).map_err(CliError::Output)
    }
}

/// The lines along which cuts are made.
fn lines(args: &WakeArgs, facet_m: f64) -> Result<Vec<Line>, SeaError> {
    let step_m = args.cut_step_m.unwrap_or(facet_m);
    let starboard = args.cut_starboard_m.iter().map(|at_m| (Way::Along, *at_m));
    let astern = args.cut_astern_m.iter().map(|at_m| (Way::Across, *at_m));
    starboard.chain(astern).map(|(way, at_m)| Line::new(way, at_m, step_m)).collect()
}

/// What must be evaluated.
fn selection(args: &WakeArgs) -> Selection {
    match (&args.out, &args.png) {
        (Some(_), _) => Selection::ALL,
        (None, Some(_)) => args.field.selection(),
        (None, None) => Selection::HEIGHT,
    }
}

fn write_map(
    output: Output,
    config: &str,
    patch: &Patch,
    fields: &Fields<f64>,
    time_s: f64,
) -> Result<(), SeaError> {
    let layers = field::LAYERS.map(|(name, unit, meaning, values)| {
        let values: &[f64] = values(fields);
        Layer { name, unit, meaning, values }
    });
    let software = format!("nereus {}", env!("CARGO_PKG_VERSION"));
    let attributes = [
        ("software", Attribute::Text(&software)),
        ("config", Attribute::Text(config)),
        ("time_s", Attribute::Real(time_s)),
        ("facet_m", Attribute::Real(patch.facet_m)),
    ];
    let file = MapFile { format: "nereus-wake", attributes: &attributes, patch, layers: &layers };
    output.write(|partial| Ok(file.write(partial)?))
}

fn draw(
    output: Output,
    args: &WakeArgs,
    patch: &Patch,
    fields: &Fields<f64>,
    ships: &[ShipOutlook],
) -> Result<(), SeaError> {
    let [x, y] = axes(patch);
    let title = match ships {
        [ship] => format!("Wake of {} of {:.0} m at {} m/s", ship.hull, ship.length_m, ship.speed_mps),
        _ => format!("Wakes of {} ships, {} s", ships.len(), args.time_s),
    };
    let values = args.field.values(fields);
    let picture = Picture {
        title: &title,
        x,
        y,
        quantity: args.field.quantity(),
        colours: args.field.colours(),
        scale_bar: Some("m"),
        ..Picture::new(&values, patch.facets)?
    };
    save_png(output, &picture)
}
