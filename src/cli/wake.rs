//! `nereus wake`: the waves of the ships of a scenario alone, as a map and a picture, as cuts, and what they
//! cost.
//!
//! The map is that of the patch where it lies at the time asked. Files:
//! [`map_file`](crate::recording::map_file) with format `nereus-wake` and the fields of `nereus sea`,
//! [`picture`](crate::plot::picture). Cuts ([`cut`](crate::sea::wake::cut)) are those of one ship each,
//! printed as CSV.

use std::io::Write;

use clap::Args;

use super::error::{CliError, Refused};
use super::report::Report;
use super::say;
use super::scenario::sea_of;
use super::sea::{MapArgs, files, outputs};
use super::values::within;
use crate::adequacy::ShipOutlook;
use crate::adequacy::description::ships::figures;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::prepared::patch_at;
use crate::recording::field_file::Attribute;
use crate::recording::map_file;
use crate::recording::output::FileKind;
use crate::sea::fleet::Fleet;
use crate::sea::surface::Selection;
use crate::sea::wake::cut::{self, Cut, FAR_M, Line, STEP_RANGE_M, Way};

/// `nereus wake`
#[derive(Debug, Args)]
pub struct WakeArgs {
    /// The map
    #[command(flatten)]
    pub map: MapArgs,
    /// Cuts along the track, so far to starboard of every ship, m: CSV
    #[arg(long, value_name = "Y,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub cut_starboard_m: Vec<f64>,
    /// Cuts across the track, so far astern of midship of every ship, m: CSV
    #[arg(long, value_name = "X,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub cut_astern_m: Vec<f64>,
    /// Step along a cut, m [default: a facet]
    #[arg(long, value_name = "M")]
    pub cut_step_m: Option<f64>,
}

/// Makes the files that the arguments ask for, prints cuts, and reports what ships they are.
pub(super) fn wake(args: &WakeArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let asked = &args.map;
    let (json, time_s) = (asked.output.format.json, asked.time_s);
    let run = asked.scenario.load_and_warn()?;
    let path = &asked.scenario.config;
    let (sea, ships) = (sea_of(&run, path)?, &run.scene.ships);
    if ships.is_empty() {
        return Err(Refused::Without { path: path.clone(), what: "[[ship]]" }.into());
    }
    let lines = lines(args, sea.patch.facet_m)?;
    if let Some(ship) = ships.iter().find(|ship| ship.trajectory.is_some()).filter(|_| !lines.is_empty()) {
        let asked = format!("cuts of ship '{}', which is on a track", ship.name);
        let allowed = "--out and --png of ships on tracks; cuts where all ships sail straight on";
        return Err(Refused::Value { asked, allowed: allowed.to_owned() }.into());
    }
    let kinds = [(&asked.out, FileKind::Hdf5), (&asked.png, FileKind::Png)];
    let [map, picture] = outputs(kinds, asked.output.overwrite.force)?;
    let patch = patch_at(&run, sea, time_s)?;
    let fleet = Fleet::muster(ships, &[(time_s, patch)]).map_err(BuildErrors::from)?;
    let of = |ship| ShipOutlook::of(ship, patch.facet_m).map_err(BuildErrors::from);
    let outlooks = ships.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    for ship in &outlooks {
        say(format_args!("{}: {}", ship.name, figures(ship)));
    }
    let fields = fleet.waves(&patch, asked.selection(Selection::ALL), time_s)?;
    let [low_m, high_m] = fields
        .height_m
        .iter()
        .fold([0.0_f64; 2], |[low, high], height_m| [low.min(*height_m), high.max(*height_m)]);
    let mut report = Report::default();
    report.value("time_s", time_s).value("facets", patch.facets).value("facet_m", patch.facet_m);
    report
        .line(format!("on the map the wakes are {low_m:.3} to {high_m:.3} m high"))
        .value("height_range_m", [low_m, high_m])
        .value("ships", &outlooks);
    // Ships whose waves are off have none in the fleet.
    let sailing = ships.iter().filter(|ship| ship.kelvin.is_some()).zip(&fleet.wakes);
    let mut cuts = Vec::new();
    for (ship, wake) in sailing {
        for line in &lines {
            cuts.push(Cut::of(&ship.name, wake, line, &patch, time_s)?);
        }
    }
    if let Some(output) = map {
        let attributes = [("time_s", Attribute::Real(time_s)), ("facet_m", Attribute::Real(patch.facet_m))];
        let write =
            |path: &_| map_file::write_sea(path, "nereus-wake", &run.text, &attributes, &patch, &fields);
        output.write(|partial| Ok::<_, CliError>(write(partial)?))?;
    }
    if let Some(output) = picture {
        let title = match &outlooks[..] {
            [ship] => format!("Wake of {} of {:.0} m at {} m/s", ship.hull, ship.length_m, ship.speed_mps),
            _ => format!("Wakes of {} ships, {time_s} s", outlooks.len()),
        };
        asked.field.draw(&title, &patch, &fields)?.save(output)?;
    }
    if asked.out.is_none() && asked.png.is_none() && lines.is_empty() {
        report.line("nothing was asked for: --out, --png, --cut-starboard-m, --cut-astern-m");
    }
    report.value("cuts", &cuts);
    files(&mut report, [("out", &asked.out), ("png", &asked.png)]);
    report.say(json, out)?;
    if json || lines.is_empty() { Ok(()) } else { cut::print(&cuts, out).map_err(CliError::Output) }
}

/// The lines along which cuts are made.
fn lines(args: &WakeArgs, facet_m: f64) -> Result<Vec<Line>, Refused> {
    let step_m = args.cut_step_m.unwrap_or(facet_m);
    let starboard = args.cut_starboard_m.iter().map(|at_m| (Way::Along, *at_m));
    let astern = args.cut_astern_m.iter().map(|at_m| (Way::Across, *at_m));
    within("--cut-step-m", &[step_m], STEP_RANGE_M)?;
    let line = |(way, at_m)| {
        let key = if way == Way::Along { "--cut-starboard-m" } else { "--cut-astern-m" };
        within(key, &[at_m], [-FAR_M, FAR_M])?;
        Ok(Line { way, at_m, step_m })
    };
    starboard.chain(astern).map(line).collect()
}
