//! `nereus check`: validate, explain, predict.

use std::io::Write;

use clap::Args;

use super::error::CliError;
use super::report::Report;
use super::scenario::{JsonArg, ScenarioArgs};
use super::{counted, warn};
use crate::adequacy::description::{Described, ECHO, Models, RAIN, described, models, scenario, sea, ships};
use crate::adequacy::link_budget::{self, LinkBudget, link_budget};
use crate::adequacy::polarisation::polarisation;
use crate::adequacy::{Adequacy, EDGE_BUDGET_DB, SeaWarning, adequacy, edge_db, hidden_targets};
use crate::bench::plan::{PlanReport, echo_text, not_kept};
use crate::bench::resources::Resources;
use crate::config::Run;
use crate::fidelity::cost::CostTable;
use crate::motion::PlatformNav;
use crate::nav::TrackSource;
use crate::paths::drops;
use crate::pipeline::build::{self, PulseStream};
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::outputs;
use crate::pipeline::plausible;
use crate::pulse::SampleFormat;
use crate::transport::Pace;
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

/// What is found of a run without emitting a pulse.
struct Found {
    models: Models,
    warnings: Vec<String>,
    /// How the recorded tracks were made.
    tracks: Vec<Described>,
    sea: Option<Adequacy>,
    /// What antennas, noise and pulse interval mean for the targets.
    link: Option<LinkBudget>,
    /// What is chosen for the error that is asked; none for the reference.
    plan: Option<PlanReport>,
    forecast: Option<Resources>,
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
pub fn assess(run: &Run, mut warned: impl FnMut(&[String])) -> Result<Report, CliError> {
    let mut warnings: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    // An output that exists stands in the way of a run, not of a look at the scenario.
    warnings.extend(outputs::preflight(&run.sinks).iter().map(ToString::to_string));
    warned(&warnings);
    let first = warnings.len();
    let models = models(run);
    let mut found =
        Found { models, warnings, tracks: Vec::new(), sea: None, link: None, plan: None, forecast: None };
    let unknown = without_trajectory(run);
    if unknown.is_empty() {
        found.predict(run)?;
    } else {
        // What needs a trajectory is left out, rather than predicted of a wrong one.
        found.warnings.extend(unknown);
    }
    warned(&found.warnings[first..]);
    Ok(report(run, &found))
}

/// Live platforms of which nothing is known beforehand.
fn without_trajectory(run: &Run) -> Vec<String> {
    let live = |(name, nav): (&String, &PlatformNav)| match &nav.truth {
        TrackSource::Live(source) if source.nominal.is_none() => Some(format!(
            "platform '{name}' is live, and where it will be is not known: sea, window, plan and speed are not predicted; \
             a nominal trajectory (track.nominal) lets check predict them"
        )),
        _ => None,
    };
    run.scene.platforms.iter().zip(&run.nav).filter_map(live).collect()
}

impl Found {
    /// What follows from the tracks: how sea, horizon, polarisation and receiver fit, settings, speed.
    fn predict(&mut self, run: &Run) -> Result<(), CliError> {
        let unrecorded = Run { sinks: Vec::new(), ..run.clone() };
        let stream = build::on_nominal_tracks(&unrecorded, 0..run.scene.pulses)?;
        for note in stream.notes() {
            let what = format!("{}, {} track", note.platform, note.role);
            self.tracks.push(described(&what, note.report.to_string()));
        }
        self.link = Some(link_budget(run)?);
        self.sea = adequacy(run)?;
        if let Some(sea) = &mut self.sea {
            sea.edge_db = edge_db(stream.factory(), stream.schedule()).map_err(BuildErrors::from)?;
            let strong = sea.edge_db.filter(|edge| *edge > EDGE_BUDGET_DB);
            sea.warnings.extend(strong.map(|edge_db| SeaWarning::Edge { edge_db }));
        }
        self.warnings.extend(hidden_targets::warnings(&stream).map_err(BuildErrors::from)?);
        self.warnings.extend(self.sea.iter().flat_map(|sea| &sea.warnings).map(ToString::to_string));
        self.warnings.extend(polarisation(run)?.iter().map(ToString::to_string));
        self.plan(run, &stream);
        if let Some((points, in_cell)) = stream.factory().rain()
            && let Some(row) = self.models.with.iter_mut().find(|row| row.what == RAIN)
        {
            row.how += &format!("; {points:.0} points at a pulse, {in_cell} in a resolution cell");
            if in_cell < drops::DROPS {
                row.how += &format!(": {} would make more than {} at some pulse", drops::DROPS, drops::MOST);
            }
        }
        self.warnings.extend(plausible::targets(run)?.iter().map(ToString::to_string));
        let forecast = stream.resources(&run.scene.radar).map_err(BuildErrors::from)?;
        let levels = forecast.converter.iter().flat_map(|converter| converter.warnings());
        self.warnings.extend(levels.map(|warning| warning.to_string()));
        if forecast.real_time_factor < 1.0 && run.stream.pace == Pace::Realtime {
            self.warnings.push(format!(
                "{} times real time on this machine: a run in real time falls behind; --pace fast, or stream.pace = \"fast\"",
                digits(forecast.real_time_factor)
            ));
        }
        self.forecast = Some(forecast);
        Ok(())
    }

    /// What is predicted of the settings takes the place of what was asked.
    fn plan(&mut self, run: &Run, stream: &PulseStream) {
        let Some(planned) = stream.factory().plan() else { return };
        let speed = stream.threads() as f64 / CostTable::TABLE.seconds(&planned.work);
        let factor = speed / run.scene.radar.emissions.mean_prf_hz();
        self.warnings.extend(not_kept(planned));
        for row in self.models.with.iter_mut().filter(|row| row.what == ECHO) {
            row.how = echo_text(planned);
        }
        self.plan = Some(PlanReport::new(planned, factor, stream.predicted_bytes()));
    }
}

fn report(run: &Run, found: &Found) -> Report {
    let mut report = scenario_report(run);
    let Found { models, warnings, tracks, sea, link, plan, forecast } = found;
    let platforms = scenario::platforms(run);
    report.section("platforms", &platforms).value("platforms", &platforms);
    report.section("modelled", &models.with).value("modelled", &models.with);
    report.section("link", &link.as_ref().map(link_budget::rows).unwrap_or_default()).value("link", link);
    report.section("sea", &sea.as_ref().map(sea::rows).unwrap_or_default()).value("sea", sea);
    report.section("ships", &sea.as_ref().map(|sea| ships::rows(&sea.ships)).unwrap_or_default());
    report.section("recorded tracks", tracks).value("tracks", tracks);
    let rows = plan.as_ref().map(PlanReport::rows).unwrap_or_default();
    report.section("plan, predicted", &rows).value("plan", plan);
    if let Some(forecast) = forecast {
        add_forecast(&mut report, forecast);
    }
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
    let slots = run.stream.ring_slots + run.sinks.iter().map(|sink| sink.queue_pulses).sum::<usize>();
    let bytes = layout.slot_bytes();
    let memory_mib = slots as f64 * bytes as f64 / f64::from(1 << 20);
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
                "{rate:.3} MB/s of samples, {all:.3} MB in all; {bytes} bytes a pulse in memory, {memory_mib:.1} MiB of ring and queues"
            ),
        )
        .value("pulse_bytes", bytes)
        .value("sample_rate_mb_per_s", rate)
        .value("samples_mb", all)
        .value("memory_mib", memory_mib);
    report
}

fn add_forecast(report: &mut Report, forecast: &Resources) {
    let threads = counted(forecast.threads, "thread");
    let (speed, factor) = (digits(forecast.pulses_per_s), digits(forecast.real_time_factor));
    let trial = counted(forecast.trial_pulses, "pulse");
    report.title("forecast");
    report.row(
        "speed",
        format!("{speed} pulses/s with {threads} ({trial} made for this forecast): {factor} times real time"),
    );
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
