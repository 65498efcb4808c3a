//! `nereus tradeoff`: error and speed over the settings of `[fidelity]`, as a table, as CSV and as a picture.

use super::values::{counts, threads};
use crate::cli::scenario::ScenarioArgs;
use clap::Args;
use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;
use serde_json::{Map, Value};

use super::bench::reference;
use super::error::CliError;
use super::escape;
use super::json;
use super::progress;
use super::sea::SeaError;
use super::{counted, say, warn};
use crate::bench::accuracy;
use crate::bench::settings::{ERROR_KEY, SETTINGS, settings};
use crate::bench::sweep::{Overrides, Point, Sweep, sweep, taken};
use crate::cli::check::plan::settings_text;
use crate::cli::outputs::save_canvas;
use crate::config::Run;
use crate::echo::Fidelity;
use crate::pipeline::build;
use crate::plot::chart::{Curve, Mark, Plot, PlotAxis, Spacing};
use crate::recording::output::{FileKind, Output, OutputError};
use crate::transport::pacer::Status;

/// `nereus tradeoff`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TradeoffArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Folder for tradeoff.csv and tradeoff.png
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Every combination of the settings, instead of one setting at a time
    #[arg(long)]
    pub grid: bool,
    /// Pulses, spread over the run, at which errors are measured
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = counts(1, u64::MAX))]
    pub error_pulses: u64,
    /// Error that is wanted, dB (instead of fidelity.error_db)
    #[arg(long, value_name = "DB")]
    pub error_db: Option<f64>,
    /// Threads that make pulses (instead of stream.threads); 0: as many as the machine has
    #[arg(long, value_name = "T", value_parser = threads())]
    pub threads: Option<u64>,
    /// Overwrite files that exist
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// Error that is wanted of a scenario that asks for none, dB.
const DEFAULT_DB: f64 = -60.0;

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report<'a> {
    scenario: String,
    facets: usize,
    threads: usize,
    error_db: f64,
    error_pulses: &'a [u64],
    reference_pulses_per_s: f64,
    #[serde(flatten)]
    sweep: &'a Sweep,
    /// The fastest setting that keeps the error.
    taken: Option<&'a Point>,
    /// What the plan takes for the scenario as written.
    plan: Map<String, Value>,
    predicted_rel_rms_db: Option<f64>,
    out: Vec<PathBuf>,
}

/// Sweeps and prints.
pub(super) fn tradeoff(args: &TradeoffArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let wanted = args.error_db.map(|error_db| (ERROR_KEY.to_owned(), format!("{error_db:?}")));
    let again = |change: &Overrides| {
        let change: Overrides = wanted.iter().chain(change).cloned().collect();
        args.scenario.load_to_measure(args.threads, &change)
    };
    let mut run = again(&Vec::new())?;
    // There is nothing to sweep in the reference: its scenario is tried with the fast echo.
    let fast = ("fidelity.echo".to_owned(), "fast".to_owned());
    let with_fast = |change: &Overrides| again(&[std::slice::from_ref(&fast), &change[..]].concat());
    if run.fidelity == Fidelity::Reference {
        run = with_fast(&Vec::new())?;
    }
    let error_db = if let Fidelity::Fast(asked) = &run.fidelity { asked.error_db } else { DEFAULT_DB };
    let files = files(args)?;
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
    let stream = build::on_nominal_tracks(&accuracy::noiseless(&run), 0..run.scene.pulses)?;
    let (threads, facets) = (stream.threads(), stream.factory().facets());
    let scene = &run.scene;
    let sampled =
        accuracy::sample(scene.seed, scene.pulses, stream.factory().block_pulses(), args.error_pulses);
    let plan = stream.factory().plan().copied();
    drop(stream);
    let judge = reference(&run, sampled, threads)?;
    let begun;
    let swept = {
        say("settings ...");
        let (status, watcher) = progress::watch_of(0, "settings");
        let mut written = 0;
        let swept = sweep(&judge, &run, args.grid, with_fast, |done, all, sweep| {
            let _ = status.try_send(Status { passed: done as u64, total: all as u64, late: 0, dropped: 0 });
            if let Some(files) = files.as_ref().filter(|_| sweep.points.len() > written) {
                // What cannot be written now is reported at the end, when the whole table is.
                let _ = files.write_table(csv(sweep, None), written == 0);
                written = sweep.points.len();
            }
        });
        begun = written > 0;
        drop(status);
        watcher.finish();
        swept?
    };
    let best = taken(&swept.points, error_db);
    let paths = files.iter().flat_map(|files| json::all_legible(&files.paths)).collect();
    let report = Report {
        scenario: run.path.display().to_string(),
        facets,
        threads,
        error_db,
        error_pulses: judge.pulses(),
        reference_pulses_per_s: judge.pulses_per_s(),
        sweep: &swept,
        taken: best,
        plan: settings(plan.as_ref().map(|plan| &plan.chosen)),
        predicted_rel_rms_db: plan.as_ref().map(|plan| plan.prediction.total_db()),
        out: paths,
    };
    let text = if args.json { json::json(&report)? + "\n" } else { text(&report) };
    if let Some(files) = &files {
        files.write_table(csv(&swept, best), !begun)?;
        save_canvas(files.picture.clone(), &draw(&run, &swept, error_db)?)?;
    }
    out.write_all(text.as_bytes()).map_err(CliError::Output)
}

struct Files {
    table: Output,
    picture: Output,
    paths: [PathBuf; 2],
}

impl Files {
    /// Writes the table: anew, or in the place of the one that this program has written before.
    fn write_table(&self, csv: String, first: bool) -> Result<(), SeaError> {
        let table = match first {
            true => self.table.clone(),
            false => Output::plan(&self.paths[0], FileKind::Settings, true)?,
        };
        table.write(|partial| {
            fs::write(partial, csv).map_err(OutputError::io(partial, "writing")).map_err(SeaError::from)
        })
    }
}

/// The files of `--out`, whose folder is made where it is not there.
fn files(args: &TradeoffArgs) -> Result<Option<Files>, SeaError> {
    let Some(folder) = &args.out else { return Ok(None) };
    fs::create_dir_all(folder).map_err(OutputError::io(folder, "making the folder"))?;
    let paths = ["tradeoff.csv", "tradeoff.png"].map(|name| folder.join(name));
    let plan = |path: &PathBuf, kind| Output::plan(path, kind, args.force);
    let (table, picture) = (plan(&paths[0], FileKind::Settings)?, plan(&paths[1], FileKind::Png)?);
    Ok(Some(Files { table, picture, paths }))
}

/// A setting of a point, as a word.
fn setting(point: &Point, name: &str) -> String {
    match point.settings.get(name) {
        Some(Value::String(word)) => word.clone(),
        Some(value) => value.to_string(),
        None => String::new(),
    }
}

/// The first word must stay the first: it tells the file from others.
fn csv(sweep: &Sweep, taken: Option<&Point>) -> String {
    let names: Vec<&String> =
        sweep.points.first().map_or(Vec::new(), |point| point.settings.keys().collect());
    let mut csv = "setting".to_owned();
    for name in &names {
        let _ = write!(csv, ",{name}");
    }
    csv += ",rel_rms_db,rel_rms_db_mean,pulses_per_s,facet_pulses_per_s,real_time_factor,predicted_rel_rms_db,on_front,taken\n";
    for point in &sweep.points {
        let _ = write!(csv, "{}", point.change);
        for name in &names {
            let _ = write!(csv, ",{}", setting(point, name));
        }
        let _ = writeln!(
            csv,
            ",{:.3},{:.3},{:.6e},{:.6e},{:.6e},{},{},{}",
            point.rel_rms_db,
            point.rel_rms_db_mean,
            point.pulses_per_s,
            point.facet_pulses_per_s,
            point.real_time_factor,
            point.predicted_rel_rms_db.map_or(String::new(), |db| format!("{db:.3}")),
            point.on_front,
            taken.is_some_and(|taken| std::ptr::eq(taken, point))
        );
    }
    csv
}

fn text(report: &Report) -> String {
    let mut text = format!(
        "{}: {}, {}, errors at {} against the reference ({:.2} pulses/s)\n",
        report.scenario,
        counted(report.facets, "facet"),
        counted(report.threads, "thread"),
        counted(report.error_pulses.len(), "pulse"),
        report.reference_pulses_per_s
    );
    let name = |change: &str| change.replace("fidelity.", "").replace('"', "");
    let wide = report.sweep.points.iter().map(|p| name(&p.change).len()).max().unwrap_or(0).max(11);
    let _ = writeln!(
        text,
        "  {:wide$}  worst, dB  mean, dB  predicted   pulses/s  M facet-pulses/s  times real time",
        "setting"
    );
    for point in &report.sweep.points {
        let _ = writeln!(
            text,
            "{} {:wide$}  {:9.1}  {:8.1}  {:>9}  {:9.2}  {:16.3}  {:15.4}",
            if point.on_front { '*' } else { ' ' },
            name(&point.change),
            point.rel_rms_db,
            point.rel_rms_db_mean,
            point.predicted_rel_rms_db.map_or("-".to_owned(), |db| format!("{db:.1}")),
            point.pulses_per_s,
            point.facet_pulses_per_s / 1e6,
            point.real_time_factor,
        );
    }
    let _ = writeln!(text, "* no other setting is both faster and better");
    match report.taken {
        Some(point) => {
            let _ = writeln!(
                text,
                "for {} dB, the fastest that keeps it, as predicted and as measured: {} ({})",
                report.error_db,
                name(&point.change),
                settings_text(&point.settings)
            );
        }
        None => {
            let _ = writeln!(
                text,
                "none of these keeps {} dB, as predicted and as measured: fidelity.echo = \"reference\"",
                report.error_db
            );
        }
    }
    let predicted = report.predicted_rel_rms_db.map_or(String::new(), |db| format!("; {db:.1} dB predicted"));
    let _ = writeln!(text, "the plan takes {}{predicted}", settings_text(&report.plan));
    if !report.sweep.models.is_empty() {
        let _ = writeln!(text, "choices of the model, apart from the scenario as written (no errors):");
    }
    let wide = report.sweep.models.iter().map(|effect| effect.change.len()).max().unwrap_or(0);
    for effect in &report.sweep.models {
        let _ = writeln!(
            text,
            "  {:wide$}  {:9.1}  {:8.1}",
            effect.change, effect.difference_db, effect.difference_db_mean
        );
    }
    for refused in &report.sweep.refused {
        let _ = writeln!(text, "not tried: {}: {}", refused.change, refused.why);
    }
    for path in &report.out {
        let _ = writeln!(text, "{}", escape::path(path));
    }
    text
}

/// Error over speed: a colour for each setting, a line through what nothing beats.
fn draw(run: &Run, sweep: &Sweep, error_db: f64) -> Result<crate::plot::canvas::Canvas, SeaError> {
    let at = |point: &Point| [point.real_time_factor, 10f64.powf(0.1 * point.rel_rms_db)];
    let of = |key: &str| -> Vec<[f64; 2]> {
        let its = |point: &&Point| point.change.starts_with(key);
        sweep.points.iter().filter(its).map(at).collect()
    };
    let mut front: Vec<[f64; 2]> = sweep.points.iter().filter(|point| point.on_front).map(at).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let slow_fast = sweep
        .points
        .iter()
        .map(|point| point.real_time_factor)
        .fold([f64::INFINITY, 0.0], |[low, high], x| [low.min(x), high.max(x)]);
    let wanted = slow_fast.map(|speed| [speed, 10f64.powf(0.1 * error_db)]);
    let mut named = vec![("wanted", wanted.to_vec(), Mark::Line), ("front", front, Mark::Line)];
    named.push(("as written", of("as written"), Mark::Dots));
    for knob in SETTINGS {
        let name = knob.key.rsplit('.').next().unwrap_or(knob.key);
        named.push((name, of(knob.key), Mark::Dots));
    }
    let curves: Vec<Curve> =
        named.iter().map(|(name, points, mark)| Curve { name, points, mark: *mark }).collect();
    let scenario = run.path.file_name().unwrap_or_default().to_string_lossy();
    let plot = Plot {
        title: &format!("Error against speed, {scenario}"),
        x: PlotAxis { label: "times real time", spacing: Spacing::Logarithmic, limits: None },
        y: PlotAxis { label: "error, worst pulse, dB", spacing: Spacing::Decibels, limits: None },
        curves: &curves,
        size_px: [720, 480],
    };
    Ok(plot.draw()?)
}
