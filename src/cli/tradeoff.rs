//! `nereus tradeoff`: error and speed over the settings of `[fidelity]`, as a table, as CSV and as a picture.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;

use super::bench::reference;
use super::error::CliError;
use super::escape;
use super::progress;
use super::report::Report;
use super::scenario::{MeasuredArgs, OutputArgs, warn_of_scene};
use super::values::counts;
use super::{counted, say};
use crate::bench::accuracy::{self, Judge};
use crate::bench::plan::settings_text;
use crate::bench::settings::{ERROR_KEY, settings};
use crate::bench::sweep::{Effect, Overrides, Point, Sweep, sweep, taken};
use crate::bench::sweep_files;
use crate::bench::table_and_picture::TableAndPicture;
use crate::config::{ConfigError, Run};
use crate::echo::Fidelity;
use crate::fidelity::budget::Plan;
use crate::pipeline::build;
use crate::recording::output::FileKind;

/// `nereus tradeoff`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TradeoffArgs {
    /// The scenario
    #[command(flatten)]
    pub measured: MeasuredArgs,
    /// Folder for tradeoff.csv and tradeoff.png
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Every combination of the settings, instead of one setting at a time
    #[arg(long)]
    pub grid: bool,
    /// Pulses, spread over the run, at which errors are measured
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = counts(1, u64::MAX))]
    pub error_pulses: u64,
    /// Time for which the speed of each setting is measured, ms
    #[arg(long, value_name = "MS", default_value_t = 600, value_parser = counts(1, 60_000))]
    pub trial_ms: u64,
    /// Error that is wanted, dB (instead of fidelity.error_db)
    #[arg(long, value_name = "DB")]
    pub error_db: Option<f64>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Error that is wanted of a scenario that asks for none, dB.
const DEFAULT_DB: f64 = -60.0;

/// Sweeps and prints.
pub(super) fn tradeoff(args: &TradeoffArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let wanted = args.error_db.map(|error_db| (ERROR_KEY.to_owned(), format!("{error_db:?}")));
    let again = |change: &Overrides| {
        let change: Overrides = wanted.iter().chain(change).cloned().collect();
        args.measured.load(&change)
    };
    let mut run = again(&Vec::new())?;
    // There is nothing to sweep in the reference: its scenario is tried with the fast echo.
    let fast = ("fidelity.echo".to_owned(), "fast".to_owned());
    let with_fast = |change: &Overrides| again(&[std::slice::from_ref(&fast), &change[..]].concat());
    if run.fidelity == Fidelity::Reference {
        run = with_fast(&Vec::new())?;
    }
    let error_db = if let Fidelity::Fast(asked) = &run.fidelity { asked.error_db } else { DEFAULT_DB };
    let force = args.output.overwrite.force;
    let plan = |folder: &PathBuf| TableAndPicture::plan(folder, "tradeoff", FileKind::Settings, force);
    let mut files = args.out.as_ref().map(plan).transpose()?;
    warn_of_scene(&run);
    let stream = build::on_nominal_tracks(&accuracy::noiseless(&run), 0..run.scene.pulses)?;
    let (threads, facets) = (stream.threads(), stream.factory().facets());
    let block_pulses = stream.factory().block_pulses();
    let (plan, prepared) = (stream.factory().plan().copied(), Arc::clone(stream.prepared()));
    drop(stream);
    let sampled = accuracy::sample(run.scene.seed, run.scene.pulses, block_pulses, args.error_pulses);
    let judge = reference(&prepared, sampled, threads)?;
    let trial = (Duration::from_millis(args.trial_ms), args.grid);
    let swept = swept(trial, &judge, &run, with_fast, &mut files)?;
    let best = taken(&swept.points, error_db);
    let mut report = Report::default();
    let (scenario, speed) = (run.path.display().to_string(), judge.pulses_per_s());
    let [facets_text, threads_text] = [counted(facets, "facet"), counted(threads, "thread")];
    let pulses = counted(judge.pulses().len(), "pulse");
    report
        .line(format!(
            "{scenario}: {facets_text}, {threads_text}, errors at {pulses} against the reference ({speed:.2} pulses/s)"
        ))
        .value("scenario", &scenario)
        .value("facets", facets)
        .value("threads", threads)
        .value("error_db", error_db)
        .value("error_pulses", judge.pulses())
        .value("reference_pulses_per_s", speed)
        .values(&swept);
    add_points(&mut report, &swept.points);
    add_choice(&mut report, error_db, best, plan.as_ref());
    add_models(&mut report, &swept);
    let paths = files.iter().flat_map(|files| &files.paths);
    for path in paths.clone() {
        report.line(escape::path(path));
    }
    report.paths("out", paths);
    if let Some(files) = &mut files {
        files.write_table(sweep_files::csv(&swept, best))?;
        let scenario = run.path.file_name().unwrap_or_default().to_string_lossy();
        sweep_files::picture(&scenario, &swept, error_db)?.save(files.picture.clone())?;
    }
    report.print(args.output.format.json, out)
}

/// Tries every setting for so long, on a grid or not, with progress; the table grows with them.
fn swept(
    (trial, grid): (Duration, bool),
    judge: &Judge,
    run: &Run,
    load: impl Fn(&Overrides) -> Result<Run, ConfigError>,
    files: &mut Option<TableAndPicture>,
) -> Result<Sweep, CliError> {
    say("settings ...");
    let mut written = 0;
    let swept = progress::counting("settings", |passed| {
        sweep(judge, run, trial, grid, load, |done, all, sweep| {
            passed(done, all);
            if let Some(files) = files.as_mut().filter(|_| sweep.points.len() > written) {
                // What cannot be written now is reported at the end, when the whole table is.
                let _ = files.write_table(sweep_files::csv(sweep, None));
                written = sweep.points.len();
            }
        })
    });
    Ok(swept?)
}

/// A setting as the table names it.
fn name(change: &str) -> String {
    change.replace("fidelity.", "").replace('"', "")
}

fn add_points(report: &mut Report, points: &[Point]) {
    let wide = points.iter().map(|point| name(&point.change).len()).max().unwrap_or(0).max(11);
    report.line(format!(
        "  {:wide$}  worst, dB  mean, dB  predicted   pulses/s  M facet-pulses/s  times real time",
        "setting"
    ));
    for point in points {
        report.line(format!(
            "{} {:wide$}  {:9.1}  {:8.1}  {:>9}  {:9.2}  {:16.3}  {:15.4}",
            if point.on_front { '*' } else { ' ' },
            name(&point.change),
            point.rel_rms_db,
            point.rel_rms_db_mean,
            point.predicted_rel_rms_db.map_or("-".to_owned(), |db| format!("{db:.1}")),
            point.pulses_per_s,
            point.facet_pulses_per_s / 1e6,
            point.real_time_factor,
        ));
    }
    report.line("* no other setting is both faster and better");
}

/// The fastest setting that keeps the error, and what the plan takes for the scenario as written.
fn add_choice(report: &mut Report, error_db: f64, best: Option<&Point>, plan: Option<&Plan>) {
    report.value("taken", best).line(match best {
        Some(point) => format!(
            "for {error_db} dB, the fastest that keeps it, as predicted and as measured: {} ({})",
            name(&point.change),
            settings_text(&point.settings)
        ),
        None => format!(
            "none of these keeps {error_db} dB, as predicted and as measured: fidelity.echo = \"reference\""
        ),
    });
    let chosen = settings(plan.map(|plan| &plan.chosen));
    let predicted_db = plan.map(|plan| plan.prediction.total_db());
    let predicted = predicted_db.map_or(String::new(), |db| format!("; {db:.1} dB predicted"));
    report.line(format!("the plan takes {}{predicted}", settings_text(&chosen)));
    report.value("plan", chosen).value("predicted_rel_rms_db", predicted_db);
}

/// Choices of the model, and what could not be tried.
fn add_models(report: &mut Report, swept: &Sweep) {
    if !swept.models.is_empty() {
        report.line("choices of the model, apart from the scenario as written (no errors):");
    }
    let wide = swept.models.iter().map(|effect| effect.change.len()).max().unwrap_or(0);
    for Effect { change, difference_db, difference_db_mean } in &swept.models {
        report.line(format!("  {change:wide$}  {difference_db:9.1}  {difference_db_mean:8.1}"));
    }
    for refused in &swept.refused {
        report.line(format!("not tried: {}: {}", refused.change, refused.why));
    }
}
