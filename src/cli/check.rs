//! `nereus check`: validate, explain, predict.

use std::io::Write;

use clap::Args;

use super::error::CliError;
use super::report::Report;
use super::scenario::{JsonArg, ScenarioArgs};
use super::{counted, warn};
use crate::adequacy::description::{scenario, sea, ships};
use crate::adequacy::{emitter_budget, link_budget};
use crate::bench::assessment::Assessment;
use crate::bench::fit_trials::Predicted;
use crate::bench::plan::PlanReport;
use crate::bench::resources::{ClassForecast, Resources};
use crate::config::Run;
use crate::pipeline::memory::Slots;
use crate::pipeline::plausible;
use crate::pulse::SampleFormat;
use crate::units::digits;

/// `nereus check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// Prints the report.
pub(super) fn check(args: &CheckArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load(&[])?;
    assess(&run, |warnings| warn(warnings))?.print(args.format.json, out)
}

/// Validates, explains and predicts a run. Warnings go to `warned` as soon as they are known, and are in the
/// report as well.
///
/// # Errors
/// What keeps the run from being built, all at once.
pub fn assess(run: &Run, warned: impl FnMut(&[String])) -> Result<Report, CliError> {
    Ok(report(run, &Assessment::of(run, warned)?))
}

fn report(run: &Run, found: &Assessment) -> Report {
    let mut report = scenario_report(run);
    let Assessment { models, warnings, tracks, sea, link, emitters, plan, resources: forecast, remedies } =
        found;
    let platforms = scenario::platforms(run);
    report.section("platforms", &platforms).value("platforms", &platforms);
    report.section("modelled", &models.with).value("modelled", &models.with);
    report.section("link", &link.as_ref().map(link_budget::rows).unwrap_or_default()).value("link", link);
    let straight = "emitters, direct path at mid-run";
    report.section(straight, &emitter_budget::rows(emitters)).value("emitters", emitters);
    report.section("sea", &sea.as_ref().map(sea::rows).unwrap_or_default()).value("sea", sea);
    report.section("ships", &sea.as_ref().map(|sea| ships::rows(&sea.ships)).unwrap_or_default());
    report.section("recorded tracks", tracks).value("tracks", tracks);
    if let Some(forecast) = forecast {
        add_forecast(&mut report, forecast);
        add_real_time(&mut report, forecast, plan.as_ref(), remedies);
    }
    let rows = plan.as_ref().map(PlanReport::rows).unwrap_or_default();
    report.section("plan, predicted", &rows).value("plan", plan);
    report.section("not modelled", &models.without).value("not_modelled", &models.without);
    report.value("forecast", forecast).value("warnings", warnings);
    report
}

/// The scenario itself, and the data that it makes.
fn scenario_report(run: &Run) -> Report {
    let (scene, radar) = (&run.scene, &run.scene.radar);
    let mut layout = radar.layout(scene.platforms.len(), scene.targets.len());
    layout.channels += run.calibration.len();
    let sample_bytes = match layout.format {
        SampleFormat::Cf32 => 8,
        SampleFormat::Ci16 => 4,
    };
    let pulse_mb = (layout.channels * layout.samples * sample_bytes) as f64 / 1e6;
    let (rate, all) = (pulse_mb * radar.emissions.mean_prf_hz(), pulse_mb * scene.pulses as f64);
    let (slots, bytes) = (Slots::of(&run.stream, &run.sinks), layout.slot_bytes());
    let [ring_mib, queues_mib] = [slots.ring, slots.held].map(|n| (n * bytes) as f64 / f64::from(1 << 20));
    let mut report = Report::default();
    let name = run.path.display().to_string();
    report.section(&name, &scenario::rows(run)).value("scenario", &name);
    report.value("start_utc", scene.start.to_string());
    report.value("duration_s", radar.emissions.interval_s(0, scene.pulses));
    report.value("pulses", scene.pulses).value("mean_prf_hz", radar.emissions.mean_prf_hz());
    report.value("channels", scenario::channels(run)).value("samples", layout.samples);
    report.value("targets", scene.targets.len()).value("sinks", scenario::sinks(run));
    report
        .row(
            "data",
            format!(
                "{rate:.3} MB/s of samples, {all:.3} MB in all; {bytes} bytes per pulse in memory, {ring_mib:.1} MiB of ring, \
                 up to {queues_mib:.1} more that sinks hold"
            ),
        )
        .value("pulse_bytes", bytes)
        .value("sample_rate_mb_per_s", rate)
        .value("samples_mb", all)
        .value("ring_mib", ring_mib)
        .value("memory_mib", ring_mib + queues_mib);
    report
}

/// Whether the run keeps up on this machine, and else what is predicted to make it.
fn add_real_time(report: &mut Report, forecast: &Resources, plan: Option<&PlanReport>, more: &[Predicted]) {
    let factor = digits(forecast.real_time_factor);
    let at = plan.map(|plan| format!(" at {} dB", plan.error_db())).unwrap_or_default();
    let fits = forecast.real_time_factor >= 1.0;
    let with: Vec<String> = more.iter().map(ToString::to_string).collect();
    let answer = match (fits, &with[..]) {
        (true, _) => format!("yes{at} ({factor} times)"),
        (false, []) => format!("no{at} ({factor} times); `nereus fit` looks for changes that help"),
        (false, with) => {
            format!(
                "no{at} ({factor} times); predicted: yes {}; `nereus fit` measures changes",
                with.join(", or ")
            )
        }
    };
    report.row("real time", answer).value("fits", fits).value("remedies", more);
}

fn add_forecast(report: &mut Report, forecast: &Resources) {
    let threads = counted(forecast.threads, "thread");
    let (speed, factor) = (digits(forecast.pulses_per_s), digits(forecast.real_time_factor));
    let trial = counted(forecast.trial_pulses, "pulse");
    report.title("forecast (measured on this machine)");
    report.row(
        "speed",
        format!("{speed} pulses/s with {threads} ({trial} made for this forecast): {factor} times real time"),
    );
    if !forecast.coarser.is_empty() {
        let of = |class: &ClassForecast| {
            format!("at {} dB {} times real time", class.error_db.round(), digits(class.real_time_factor))
        };
        let classes: Vec<String> = forecast.coarser.iter().map(of).collect();
        report.row("where it falls behind", format!("{} (predicted from that)", classes.join(", ")));
    }
    report.row("memory of the sea", format!("about {} MiB with {threads}", forecast.sea_bytes >> 20));
    report.row("in the window", format!("up to {}", counted(forecast.targets_in_window, "target")));
    let fast_s = forecast.pulses as f64 / forecast.pulses_per_s;
    report.row("at pace fast", format!("about {} s", digits(fast_s)));
    let (rate, all) = (forecast.bytes_per_s / 1e6, forecast.recording_bytes as f64 / 1e6);
    report.row("recording", format!("{rate:.2} MB/s, {all:.1} MB in all, records included"));
    if let Some(converter) = &forecast.converter {
        let level = |of: &plausible::ChannelReport| {
            format!("{} {} LSB rms, {} peak", of.channel, digits(of.rms_lsb), digits(of.peak_lsb))
        };
        report.row("ADC", converter.channels.iter().map(level).collect::<Vec<_>>().join("; "));
    }
}
