//! Ships: particulars, wave resistance.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::csv::{Cell, Table, bound};
use super::sweep::{SpeedSweep, Usual};
use crate::cli::error::CliError;
use crate::cli::scenario::ForceArg;
use crate::cli::values::{Word, one_of, within};
use crate::plot::body_plan;
use crate::recording::output::{FileKind, Output};
use crate::scene::hull::{Hull, HullError, Particulars, QUANTITIES};
use crate::sea::wake::kochin::{Kochin, Transom, resistance_coefficient};

/// Density of sea water, kg/m^3.
const DENSITY_KGPM3: f64 = 1025.0;

/// `nereus table hull`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableHullArgs {
    /// Hull: a description (.toml) or an offset table (.csv)
    file: PathBuf,
    /// Lengths that it is scaled to, m [its own]
    #[arg(long, value_name = "X,...", value_delimiter = ',')]
    length_m: Vec<f64>,
    /// Body plan to make, at the first length
    #[arg(long, value_name = "PATH.png")]
    png: Option<PathBuf>,
    /// Files that exist
    #[command(flatten)]
    overwrite: ForceArg,
}

/// Prints the table.
pub(super) fn hull(args: &TableHullArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let hulls = scaled(Hull::load(&args.file)?, &args.length_m)?;
    bound(&[hulls.len(), QUANTITIES.len()])?;
    if let (Some(png), Some(hull)) = (&args.png, hulls.first()) {
        let picture = Output::plan(png, FileKind::Png, args.overwrite.force)?;
        body_plan::draw(hull)?.save(picture)?;
    }
    let mut table = Table::new(out);
    for hull in &hulls {
        let (found, stated) = (Particulars::of(hull), hull.stated());
        for ((quantity, computed), stated) in QUANTITIES.into_iter().zip(found.values()).zip(stated.values) {
            let difference = |stated| Particulars::difference_percent(quantity, computed, stated);
            let cells = [
                ("scaled_to_m", Cell::Given(hull.length_m())),
                ("quantity", Cell::Name(quantity)),
                ("computed", Cell::Value(computed)),
                ("stated", stated.map_or(Cell::Empty, Cell::Given)),
                ("difference_percent", stated.map_or(Cell::Empty, |stated| Cell::Value(difference(stated)))),
            ];
            table.row(&cells)?;
        }
    }
    Ok(())
}

/// `nereus table wake-resistance`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableWakeResistanceArgs {
    /// Hull: a description (.toml) or an offset table (.csv) [Wigley's]
    #[arg(long, value_name = "FILE")]
    hull_path: Option<PathBuf>,
    /// Lengths that it is scaled to, m [that of the file; 100]
    #[arg(long, value_name = "X,...", value_delimiter = ',')]
    length_m: Vec<f64>,
    /// Beam of Wigley's hull, parts of its length [0.1]
    #[arg(long, value_name = "X", conflicts_with = "hull_path")]
    beam_ratio: Option<f64>,
    /// Draught of Wigley's hull, parts of its length [0.0625]
    #[arg(long, value_name = "X", conflicts_with = "hull_path")]
    draught_ratio: Option<f64>,
    /// Speeds, m/s, instead of a sweep
    #[arg(long, value_name = "V,...", value_delimiter = ',')]
    speed_mps: Vec<f64>,
    #[command(flatten)]
    sweep: SpeedSweep,
    /// What is behind an immersed transom
    #[arg(long, value_parser = one_of(TRANSOMS), default_value = "open")]
    transom: Transom,
    /// Density of the water, kg/m^3
    #[arg(long, value_name = "X", default_value_t = DENSITY_KGPM3)]
    density_kg_m3: f64,
}

/// What is behind an immersed transom.
const TRANSOMS: [Word<Transom>; 2] = [
    ("open", "A dry edge: no step behind the hull", Transom::Open),
    ("capped", "A flat stern: the step is part of the hull", Transom::Capped),
];

/// Prints the table.
pub(super) fn wake_resistance(args: &TableWakeResistanceArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let usual = Usual::steps(1.0, 15.0, 0.5);
    let speeds_mps = args.sweep.sweep().or_list("--speed-mps", &args.speed_mps, usual)?;
    let hull = match &args.hull_path {
        Some(path) => Hull::load(path),
        None => {
            let [beam, draught] = [args.beam_ratio.unwrap_or(0.1), args.draught_ratio.unwrap_or(0.0625)];
            within("--beam-ratio", &[beam], [1e-3, 1.0])?;
            within("--draught-ratio", &[draught], [1e-3, 1.0])?;
            Hull::wigley(100.0, 100.0 * beam, 100.0 * draught)
        }
    };
    let hulls = scaled(hull?, &args.length_m)?;
    bound(&[hulls.len(), speeds_mps.len()])?;
    // Every row before the first is printed: one may be refused.
    let mut rows = Vec::new();
    for hull in &hulls {
        let wetted_surface_m2 = Particulars::of(hull).wetted_surface_m2;
        for &speed_mps in &speeds_mps {
            let ship = Kochin::new(hull, speed_mps, args.transom)?;
            let density = args.density_kg_m3;
            let resistance_n = ship.wave_resistance_n(density)?;
            let cw = resistance_coefficient(resistance_n, speed_mps, density, wetted_surface_m2);
            rows.push([
                ("length_m", Cell::Given(hull.length_m())),
                ("speed_mps", Cell::Given(speed_mps)),
                ("froude", Cell::Value(ship.froude())),
                ("wetted_surface_m2", Cell::Value(wetted_surface_m2)),
                ("resistance_n", Cell::Value(resistance_n)),
                ("cw", Cell::Value(cw)),
            ]);
        }
    }
    let mut table = Table::new(out);
    rows.iter().try_for_each(|cells| table.row(cells))
}

/// A hull at every length asked, or as it is.
fn scaled(hull: Hull, lengths_m: &[f64]) -> Result<Vec<Hull>, HullError> {
    if lengths_m.is_empty() {
        return Ok(vec![hull]);
    }
    lengths_m.iter().map(|length_m| hull.scaled_to_length(*length_m)).collect()
}
