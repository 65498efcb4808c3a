//! `nereus bench`: what a scenario reaches on this machine, and the error of its echo.

use super::check::plan::settings_text;
use super::values::{counts, pulses_or_all, threads};
use crate::cli::scenario::ScenarioArgs;
use clap::Args;
use std::fmt::Write as _;
use std::io::Write;
use std::time::Instant;

use serde::Serialize;
use serde_json::{Map, Value};

use super::check::plan::{not_kept, parts_db};
use super::error::CliError;
use super::json;
use super::progress;
use super::{counted, say, warn};
use crate::bench::accuracy::{self, Accuracy, Judge, LEAST_DB};
use crate::bench::cost::Calibrated;
use crate::bench::settings;
use crate::bench::speed::{self, Speed, TRIAL};
use crate::config::Run;
use crate::pipeline::build;
use crate::pulse::costs::Stage;
use crate::transport::pacer::Status;

/// `nereus bench`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BenchArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Make the first so many pulses of the run
    /// [default: what fits in some 10 s, at least two blocks for every thread]
    #[arg(long, value_name = "N", value_parser = counts(1, u64::MAX))]
    pub pulses: Option<u64>,
    /// Threads that make pulses (instead of stream.threads); 0: as many as the machine has
    #[arg(long, value_name = "T", value_parser = threads())]
    pub threads: Option<u64>,
    /// Pulses, spread over the run, at which the error is measured, or all; 0: none
    #[arg(long, value_name = "N|all", default_value = "16", value_parser = pulses_or_all)]
    pub error_pulses: u64,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report {
    scenario: String,
    facets: usize,
    paths: usize,
    /// Mean share of the facets that is illuminated, times the facets.
    illuminated: f64,
    /// Those of them that were left out as too weak.
    culled: f64,
    /// In tiles that are looked at less often.
    sidelobe: f64,
    /// Scatterer paths accumulated in a pulse, over all pairs.
    accumulated: f64,
    channels: usize,
    pulses: u64,
    block_pulses: u64,
    threads: usize,
    pulses_per_s: f64,
    facet_pulses_per_s: f64,
    real_time_factor: f64,
    /// None for the reference, as all that is predicted.
    predicted_real_time_factor: Option<f64>,
    /// By the prices of a common machine.
    list_real_time_factor: Option<f64>,
    predicted_rel_rms_db: Option<f64>,
    /// By cause, dB.
    predicted_error_db: Map<String, Value>,
    predicted_rss_mib: Option<f64>,
    /// None where it was not measured.
    rel_rms_db: Option<f64>,
    rel_rms_db_mean: Option<f64>,
    error: Option<ErrorReport>,
    /// Of the streaming part alone: the reference comes after.
    peak_rss_mib: Option<f64>,
    startup_s: Option<f64>,
    /// Seconds of one worker for a pulse, by stage.
    stages: Map<String, Value>,
    /// The same as predicted, of those that have a price: `spread` with `fill`, `receive` with `record`.
    predicted_stages: Map<String, Value>,
    settings: Map<String, Value>,
}

/// Where and how the error was found.
#[derive(Debug, Serialize)]
struct ErrorReport {
    pulses: Vec<u64>,
    /// Whether these are all pulses of the run.
    all: bool,
    worst_pulse: u64,
    worst_channel: String,
    /// Worst of each channel, dB.
    channel_db: Map<String, Value>,
    reference_pulses_per_s: f64,
}

/// Measures and prints.
pub(super) fn bench(args: &BenchArgs, begun: Instant, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load_to_measure(args.threads, &[])?;
    warn(run.warnings.iter().filter(|warning| !warning.is_of_sinks()));
    let pulses = args.pulses.unwrap_or(run.scene.pulses);
    let stream = build::on_nominal_tracks(&run, 0..pulses)?;
    let bytes = stream.predicted_bytes();
    let (status, watcher) = progress::watch(pulses);
    let lasts = args.pulses.is_none().then_some(TRIAL);
    let measured = speed::speed(stream, lasts, Some(status));
    watcher.finish();
    let measured = measured?;
    warn(measured.plan.iter().filter_map(not_kept));
    // Calibrated once the stream has had its machine and its memory for itself.
    let calibrated = build::on_nominal_tracks(&run, 0..pulses)?.calibrated()?;
    let judged = (args.error_pulses > 0).then(|| judge(&run, &measured, args.error_pulses)).transpose()?;
    let report = report(&run, &measured, begun, judged.as_ref(), calibrated, bytes);
    let text = if args.json { json::json(&report)? + "\n" } else { text(&report) };
    out.write_all(text.as_bytes()).map_err(CliError::Output)
}

fn judge(run: &Run, measured: &Speed, pulses: u64) -> Result<(Judge, Accuracy), CliError> {
    let scene = &run.scene;
    let sampled = accuracy::sample(scene.seed, scene.pulses, measured.block_pulses, pulses);
    let judge = reference(run, sampled, measured.threads)?;
    let accuracy = judge.judge(run)?;
    Ok((judge, accuracy))
}

/// The reference of some pulses, with progress.
pub(super) fn reference(run: &Run, pulses: Vec<u64>, threads: usize) -> Result<Judge, CliError> {
    let total = pulses.len() as u64;
    say(format_args!("reference of {} ...", counted(total, "pulse")));
    let (status, watcher) = progress::watch(total);
    let judge = Judge::new(run, pulses, threads, |passed| {
        // Progress that nobody has time to show is not worth waiting for.
        let _ = status.try_send(Status { passed: passed as u64, total, late: 0, dropped: 0 });
    });
    drop(status);
    watcher.finish();
    Ok(judge?)
}

fn report(
    run: &Run,
    speed: &Speed,
    begun: Instant,
    judged: Option<&(Judge, Accuracy)>,
    calibrated: Option<Calibrated>,
    bytes: u64,
) -> Report {
    let name = |channel: usize| {
        run.scene.radar.channels.get(channel).map_or_else(String::new, |channel| channel.name.clone())
    };
    let facets = speed.facets as f64;
    Report {
        scenario: run.path.display().to_string(),
        facets: speed.facets,
        paths: speed.paths,
        illuminated: facets * speed.costs.illuminated_share(),
        sidelobe: facets * speed.costs.sidelobe_share(),
        culled: facets * speed.costs.culled_share(),
        accumulated: speed.costs.accumulated_per_pulse(),
        channels: speed.channels,
        pulses: speed.pulses,
        block_pulses: speed.block_pulses,
        threads: speed.threads,
        pulses_per_s: speed.pulses_per_s,
        facet_pulses_per_s: speed.facet_pulses_per_s(),
        real_time_factor: speed.real_time_factor,
        predicted_real_time_factor: calibrated.map(|calibrated| calibrated.factor),
        list_real_time_factor: calibrated.map(|calibrated| calibrated.list_factor),
        predicted_rel_rms_db: speed.plan.as_ref().map(|plan| plan.prediction.total_db()),
        predicted_error_db: speed.plan.as_ref().map(|plan| parts_db(&plan.prediction)).unwrap_or_default(),
        predicted_rss_mib: speed.plan.map(|_| bytes as f64 / f64::from(1 << 20)),
        rel_rms_db: judged.map(|(_, accuracy)| accuracy.rel_rms_db),
        rel_rms_db_mean: judged.map(|(_, accuracy)| accuracy.rel_rms_db_mean),
        error: judged.map(|(judge, accuracy)| ErrorReport {
            pulses: judge.pulses().to_vec(),
            all: judge.pulses().len() as u64 == run.scene.pulses,
            worst_pulse: accuracy.worst_pulse,
            worst_channel: name(accuracy.worst_channel),
            channel_db: accuracy
                .channel_db
                .iter()
                .enumerate()
                .map(|(channel, db)| (name(channel), Value::from(*db)))
                .collect(),
            reference_pulses_per_s: judge.pulses_per_s(),
        }),
        peak_rss_mib: speed.peak_rss_bytes.map(|bytes| bytes as f64 / f64::from(1 << 20)),
        startup_s: speed.first_release.map(|release| release.saturating_duration_since(begun).as_secs_f64()),
        stages: Stage::ALL
            .iter()
            .map(|stage| (stage.name().to_owned(), Value::from(speed.costs.seconds_per_pulse(*stage))))
            .collect(),
        predicted_stages: calibrated
            .iter()
            .flat_map(|calibrated| calibrated.stages_s)
            .map(|(stage, seconds)| (stage.name().to_owned(), Value::from(seconds)))
            .collect(),
        settings: settings::settings(speed.plan.as_ref().map(|plan| &plan.chosen)),
    }
}

fn text(report: &Report) -> String {
    let mut text = String::new();
    let mut row = |what: &str, how: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {what:22}{how}");
    };
    row("settings", settings_text(&report.settings));
    row(
        "paths",
        format!(
            "{}, {} of them facets; {:.0} facets illuminated, {:.0} of them culled; {:.0} accumulated in a pulse; {:.0} facets \
             in sidelobe tiles",
            report.paths,
            report.facets,
            report.illuminated,
            report.culled,
            report.accumulated,
            report.sidelobe
        ),
    );
    row("channels", report.channels.to_string());
    row(
        "speed",
        format!(
            "{:.1} pulses/s, {:.3} times real time, {:.2} M facet-pulses/s ({}, {})",
            report.pulses_per_s,
            report.real_time_factor,
            report.facet_pulses_per_s / 1e6,
            counted(report.pulses, "pulse"),
            counted(report.threads as u64, "thread")
        ),
    );
    let measured =
        |value: Option<f64>, unit: &str| value.map_or("-".to_owned(), |value| format!("{value:.2} {unit}"));
    row("start to first pulse", measured(report.startup_s, "s"));
    row("peak memory", measured(report.peak_rss_mib, "MiB resident"));
    let seconds = |stage: &Stage| report.stages.get(stage.name()).and_then(Value::as_f64).unwrap_or(0.0);
    let total: f64 = Stage::ALL.iter().map(seconds).sum();
    for stage in &Stage::ALL {
        let share = if total > 0.0 { 100.0 * seconds(stage) / total } else { 0.0 };
        let predicted = report.predicted_stages.get(stage.name()).and_then(Value::as_f64);
        let predicted = predicted.filter(|seconds| *seconds > 0.0);
        let with = match stage {
            Stage::Spread => ", fill with it",
            Stage::Receive => ", record with it",
            _ => "",
        };
        let predicted =
            predicted.map_or_else(String::new, |seconds| format!("  (predicted {:.3}{with})", 1e3 * seconds));
        row(
            &format!("stage {}", stage.name()),
            format!("{:10.3} ms a pulse {share:5.1} %{predicted}", 1e3 * seconds(stage)),
        );
    }
    match (report.rel_rms_db, report.rel_rms_db_mean, &report.error) {
        (Some(worst), _, Some(error)) if worst <= LEAST_DB => row(
            "error",
            format!("none: {} have the bits of the reference", counted(error.pulses.len() as u64, "pulse")),
        ),
        (Some(worst), Some(mean), Some(error)) => row(
            "error",
            format!(
                "{worst:.1} dB at worst (pulse {}, {}), {mean:.1} dB in the mean, of {}, against the reference",
                error.worst_pulse,
                error.worst_channel,
                match counted(error.pulses.len() as u64, "pulse") {
                    of if error.all => format!("all {of}"),
                    of => format!("{of} drawn from the run"),
                }
            ),
        ),
        _ => row("error", "not measured".to_owned()),
    }
    if let (Some(error_db), Some(factor), Some(mib)) =
        (report.predicted_rel_rms_db, report.predicted_real_time_factor, report.predicted_rss_mib)
    {
        row(
            "predicted",
            format!(
                "error {error_db:.1} dB, {factor:.3} times real time (calibrated), {mib:.0} MiB resident"
            ),
        );
    }
    format!("{}\n{text}", report.scenario)
}
