//! `nereus bench`: what a scenario reaches on this machine, and the error of its echo.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use serde_json::{Map, Value, json};

use super::error::CliError;
use super::progress;
use super::report::Report;
use super::scenario::{JsonArg, MeasuredArgs, warn_of_scene};
use super::values::{counts, pulses_or_all};
use super::{counted, say, warn};
use crate::bench::accuracy::{self, Accuracy, Judge, LEAST_DB};
use crate::bench::cost::Calibrated;
use crate::bench::plan::{not_kept, parts_db, settings_text};
use crate::bench::settings;
use crate::bench::speed::{self, Speed, TRIAL};
use crate::config::Run;
use crate::pipeline::build;
use crate::pipeline::prepared::Prepared;
use crate::pulse::costs::Stage;

/// Bytes of a mebibyte.
const MIB: f64 = 1_048_576.0;

/// `nereus bench`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BenchArgs {
    /// The scenario
    #[command(flatten)]
    pub measured: MeasuredArgs,
    /// Make the first so many pulses of the run
    /// [default: what fits in some 10 s, at least two blocks for every thread]
    #[arg(long, value_name = "N", value_parser = counts(1, u64::MAX))]
    pub pulses: Option<u64>,
    /// Pulses, spread over the run, at which the error is measured, or all; 0: none
    #[arg(long, value_name = "N|all", default_value = "16", value_parser = pulses_or_all)]
    pub error_pulses: u64,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// Measures and prints.
pub(super) fn bench(args: &BenchArgs, begun: Instant, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.measured.load(&[])?;
    warn_of_scene(&run);
    let pulses = args.pulses.unwrap_or(run.scene.pulses);
    let stream = build::on_nominal_tracks(&run, 0..pulses)?;
    let (bytes, prepared) = (stream.predicted_bytes(&[]).at_most, Arc::clone(stream.prepared()));
    let (status, watcher) = progress::watch();
    let lasts = args.pulses.is_none().then_some(TRIAL);
    let measured = speed::speed(stream, lasts, Some(status));
    watcher.finish();
    let measured = measured?;
    warn(measured.plan.iter().filter_map(not_kept));
    // Calibrated once the stream has had its machine and its memory for itself.
    let calibrated = build::again(&prepared, &run, 0..pulses)?.calibrated()?;
    let judged =
        (args.error_pulses > 0).then(|| judge(&prepared, &measured, args.error_pulses)).transpose()?;
    report(&run, &measured, begun, judged.as_ref(), calibrated, bytes).print(args.format.json, out)
}

fn judge(prepared: &Arc<Prepared>, measured: &Speed, pulses: u64) -> Result<(Judge, Accuracy), CliError> {
    let scene = prepared.scene();
    let sampled = accuracy::sample(scene.seed, scene.pulses, measured.block_pulses, pulses);
    let judge = reference(prepared, sampled, measured.threads)?;
    let accuracy = judge.judge(prepared.run())?;
    Ok((judge, accuracy))
}

/// The reference of some pulses, with progress.
pub(super) fn reference(
    prepared: &Arc<Prepared>,
    pulses: Vec<u64>,
    threads: usize,
) -> Result<Judge, CliError> {
    let total = pulses.len();
    say(format_args!("reference of {} ...", counted(total, "pulse")));
    Ok(progress::counting("pulses", |done| {
        Judge::of(Arc::clone(prepared), pulses, threads, &|passed| done(passed, total))
    })?)
}

fn report(
    run: &Run,
    speed: &Speed,
    begun: Instant,
    judged: Option<&(Judge, Accuracy)>,
    calibrated: Option<Calibrated>,
    bytes: u64,
) -> Report {
    let mut report = Report::default();
    let name = run.path.display().to_string();
    report.title(&name).value("scenario", &name);
    let settings = settings::settings(speed.plan.as_ref().map(|plan| &plan.chosen));
    report.row("settings", settings_text(&settings)).value("settings", settings);
    add_speed(&mut report, speed);
    let measured =
        |value: Option<f64>, unit: &str| value.map_or("-".to_owned(), |value| format!("{value:.2} {unit}"));
    let startup_s = speed.first_release.map(|release| release.saturating_duration_since(begun).as_secs_f64());
    report.row("start to first pulse", measured(startup_s, "s")).value("startup_s", startup_s);
    // Of the streaming part alone: the reference comes after.
    let peak_mib = speed.peak_rss_bytes.map(|bytes| bytes as f64 / MIB);
    report.row("peak memory", measured(peak_mib, "MiB resident")).value("peak_rss_mib", peak_mib);
    add_stages(&mut report, speed, calibrated);
    add_error(&mut report, run, judged);
    add_prediction(&mut report, speed, calibrated, bytes);
    report
}

/// Paths, channels and pulses per second.
fn add_speed(report: &mut Report, speed: &Speed) {
    let (costs, facets) = (&speed.costs, speed.facets as f64);
    let illuminated = facets * costs.illuminated_share();
    let [culled, sidelobe, beyond] =
        [costs.culled_share(), costs.sidelobe_share(), costs.beyond_share()].map(|share| facets * share);
    let accumulated = costs.accumulated_per_pulse();
    report
        .row(
            "paths",
            format!(
                "{}, {} of them facets; {illuminated:.0} facets illuminated, {culled:.0} of them culled; \
                 {accumulated:.0} accumulated in a pulse; {sidelobe:.0} facets in sidelobe tiles, {beyond:.0} \
                 beyond the beams",
                speed.paths, speed.facets
            ),
        )
        .value("facets", speed.facets)
        .value("paths", speed.paths)
        .value("illuminated", illuminated)
        .value("culled", culled)
        .value("sidelobe", sidelobe)
        .value("beyond", beyond)
        .value("accumulated", accumulated);
    report.row("channels", speed.channels.to_string()).value("channels", speed.channels);
    report
        .row(
            "speed",
            format!(
                "{:.1} pulses/s, {:.3} times real time, {:.2} M facet-pulses/s ({}, {})",
                speed.pulses_per_s,
                speed.real_time_factor,
                speed.facet_pulses_per_s() / 1e6,
                counted(speed.pulses, "pulse"),
                counted(speed.threads as u64, "thread")
            ),
        )
        .value("pulses", speed.pulses)
        .value("block_pulses", speed.block_pulses)
        .value("threads", speed.threads)
        .value("pulses_per_s", speed.pulses_per_s)
        .value("facet_pulses_per_s", speed.facet_pulses_per_s())
        .value("real_time_factor", speed.real_time_factor);
}

/// Seconds of one worker for a pulse, by stage, measured and predicted: `spread` is predicted with `fill`,
/// `receive` with `record`.
fn add_stages(report: &mut Report, speed: &Speed, calibrated: Option<Calibrated>) {
    let seconds = |stage: &Stage| speed.costs.seconds_per_pulse(*stage);
    let total: f64 = Stage::ALL.iter().map(seconds).sum();
    let costs: BTreeMap<&str, f64> = calibrated
        .iter()
        .flat_map(|calibrated| calibrated.stages_s)
        .map(|(stage, seconds)| (stage.name(), seconds))
        .collect();
    for stage in &Stage::ALL {
        let share = if total > 0.0 { 100.0 * seconds(stage) / total } else { 0.0 };
        let with = match stage {
            Stage::Spread => ", fill with it",
            Stage::Receive => ", record with it",
            _ => "",
        };
        let predicted = costs.get(stage.name()).filter(|seconds| **seconds > 0.0);
        let predicted =
            predicted.map_or_else(String::new, |seconds| format!("  (predicted {:.3}{with})", 1e3 * seconds));
        report.row(
            format!("stage {}", stage.name()),
            format!("{:8.3} ms per pulse {share:5.1} %{predicted}", 1e3 * seconds(stage)),
        );
    }
    let stages: BTreeMap<&str, f64> = Stage::ALL.iter().map(|stage| (stage.name(), seconds(stage))).collect();
    report.value("stages", stages).value("predicted_stages", costs);
}

/// The error against the reference, and where and how it was found.
fn add_error(report: &mut Report, run: &Run, judged: Option<&(Judge, Accuracy)>) {
    let Some((judge, accuracy)) = judged else {
        let none = None::<f64>;
        report.row("error", "not measured").value("error", none);
        report.value("rel_rms_db", none).value("rel_rms_db_mean", none);
        return;
    };
    let name = |channel: usize| {
        run.scene.radar.channels.get(channel).map_or_else(String::new, |channel| channel.name.clone())
    };
    let (worst_db, mean_db) = (accuracy.rel_rms_db, accuracy.rel_rms_db_mean);
    let (pulse, channel) = (accuracy.worst_pulse, name(accuracy.worst_channel));
    let (number, all) = (judge.pulses().len() as u64, judge.pulses().len() as u64 == run.scene.pulses);
    let pulses = match counted(number, "pulse") {
        of if all => format!("all {of}"),
        of => format!("{of} drawn from the run"),
    };
    let text = if worst_db <= LEAST_DB {
        format!("none: {} have the bits of the reference", counted(number, "pulse"))
    } else {
        format!(
            "{worst_db:.1} dB at worst (pulse {pulse}, {channel}), {mean_db:.1} dB in the mean, of {pulses}, \
             against the reference"
        )
    };
    let channel_db: Map<String, Value> =
        accuracy.channel_db.iter().enumerate().map(|(at, db)| (name(at), Value::from(*db))).collect();
    report.row("error", text).value("rel_rms_db", worst_db).value("rel_rms_db_mean", mean_db).value(
        "error",
        json!({
            "pulses": judge.pulses(),
            "all": all,
            "worst_pulse": pulse,
            "worst_channel": channel,
            "channel_db": channel_db,
            "reference_pulses_per_s": judge.pulses_per_s(),
        }),
    );
}

/// What was predicted; none for the reference.
fn add_prediction(report: &mut Report, speed: &Speed, calibrated: Option<Calibrated>, bytes: u64) {
    let prediction = speed.plan.as_ref().map(|plan| &plan.prediction);
    let error_db = prediction.map(|prediction| prediction.total_db());
    let factor = calibrated.map(|calibrated| calibrated.factor);
    let mib = prediction.map(|_| bytes as f64 / MIB);
    if let (Some(error_db), Some(factor), Some(mib)) = (error_db, factor, mib) {
        let text = format!(
            "error {error_db:.1} dB, {factor:.3} times real time (calibrated), {mib:.0} MiB resident"
        );
        report.row("predicted", text);
    }
    report.value("predicted_rel_rms_db", error_db).value("predicted_real_time_factor", factor);
    report.value("list_real_time_factor", calibrated.map(|calibrated| calibrated.list_factor));
    report.value("predicted_error_db", prediction.map(parts_db).unwrap_or_default());
    report.value("predicted_rss_mib", mib);
}
