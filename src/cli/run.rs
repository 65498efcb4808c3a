//! `nereus run`: a scenario becomes a running stream.

use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::error::{CliError, Refused};
use super::monitor::page::Page;
use super::report::Report;
use super::scenario::{OutputArgs, ScenarioArgs};
use super::values::{PulseRange, Word, duration, one_of};
use super::{counted, progress, say, stop_on_ctrl_c, warn};
use crate::adequacy::adequacy;
use crate::config::{Run, Warning};
use crate::nav::{AttitudeSource, TrackSource};
use crate::pipeline::build::{self, RunOutcome};
use crate::pipeline::control_lines::{ControlSocket, Subject};
use crate::pipeline::live::FlightReport;
use crate::pipeline::plausible::{self, ChannelReport, ConverterReport};
use crate::pulse::log::Entry;
use crate::recording::shard::Shard;
use crate::sinks::redirection::redirect;
use crate::sinks::sink::SinkReport;
use crate::transport::{Pace, Policy};

/// How pulses are released.
const PACES: [Word<Pace>; 2] = [
    ("realtime", "At their emission times plus the latency", Pace::Realtime),
    ("fast", "As soon as they are made", Pace::Fast),
];

/// `nereus run`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct RunArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Release pulses in real time or as fast as they are made (instead of stream.pace)
    #[arg(long, value_parser = one_of(PACES))]
    pub pace: Option<Pace>,
    /// Length of the run (instead of scene.duration_s)
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration_s: Option<String>,
    /// Make only these pulses of the run, the last one excluded
    #[arg(long, value_name = "A..B")]
    pub pulses: Option<PulseRange>,
    /// Make only the K-th of N shards of the run, K from 1: for arrays of jobs (docs/scale-out.md)
    #[arg(long, value_name = "K/N", conflicts_with = "pulses")]
    pub shard: Option<Shard>,
    /// Recording (instead of the path of the scenario's recording)
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Accept navigation-error commands during the run: Unix socket to create, or - for standard input
    /// (docs/control.md)
    #[arg(long, value_name = "PATH")]
    pub control: Option<PathBuf>,
    /// Serve a live page in the browser at this address, such as 127.0.0.1:8080 (docs/monitor.md); port 0:
    /// any that is free
    #[arg(long, value_name = "ADDR")]
    pub monitor: Option<String>,
    /// Let whoever has the address of the page inject navigation errors from it
    #[arg(long)]
    pub monitor_control: bool,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Runs the scenario.
pub(super) fn run(args: &RunArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let (run, pulses) = prepare(args)?;
    warn(&run.warnings);
    let socket = args.control.as_deref().map(ControlSocket::at).transpose()?;
    let page = run.monitor.as_deref().map(Page::at).transpose()?;
    let first = pulses.start;
    let stream = build::stream(&run, pulses)?;
    let prepared = Arc::clone(stream.prepared());
    let nominal = prepared.run();
    warn(adequacy(&prepared)?.iter().flat_map(|sea| &sea.warnings));
    let mut physics = plausible::geometry(&prepared)?;
    warn(&physics);
    for note in prepared.notes() {
        say(format_args!("platform '{}', {} track: {}", note.platform, note.role, note.report));
    }
    let stop = stop_on_ctrl_c(true)?;
    let (status, watcher) = progress::watch();
    let live = stream.live_navigation();
    if let Some(live) = &live {
        let first = nominal.scene.radar.emissions.emission(nominal.scene.start, stream.schedule().first);
        live.standing(first).for_each(say);
    }
    if nominal.start_now && run.stream.pace == Pace::Realtime {
        say(format_args!("pulses begin at {}", nominal.scene.start));
    }
    let in_hand = stream.in_hand();
    if let Some(needed_s) = stream.needed_latency_s() {
        latency(&run, needed_s, stream.latency_s());
    }
    let (log, levels) = (stream.log(), stream.levels());
    let classes_db = stream.header().error_classes_db().to_vec();
    let control = socket.zip(stream.control());
    let open =
        control.map(|(socket, control)| socket.open(Subject { control, stop: Arc::clone(&stop) }, say));
    let control = stream.control().filter(|_| args.monitor_control);
    let shown = page
        .map(|page| {
            page.show(
                &stream,
                if nominal.start_now { &nominal.scene } else { &run.scene },
                &run.path,
                control,
            )
        })
        .transpose()?;
    let (view, shown) = shown.unzip();
    let outcome = stream.run_in_view(&stop, Some(status), view);
    if let Some(shown) = shown {
        shown.close();
    }
    if let Some(open) = open {
        open.close();
    }
    watcher.finish();
    let outcome = outcome?;
    let passed = outcome.summary.health.pulses + outcome.summary.health.dropped;
    let changes = match (log, (first + passed).checked_sub(1)) {
        (Some(log), Some(last)) if passed > 0 => log.between(None, last),
        _ => Vec::new(),
    };
    let converter = levels.get().and_then(|levels| ConverterReport::of(&run.scene.radar, levels));
    let mut report = Report::default();
    report.values(&outcome.summary);
    add_release(&mut report, &run, &outcome, &classes_db);
    let missing = outcome.summary.health.dropped;
    if let Some(remedy) = in_hand.remedy().filter(|_| missing > 0) {
        report.warning(format_args!("{} dropped: {remedy}", were(missing)));
    }
    for (name, error) in &outcome.failed {
        report.warning(format_args!("sink '{name}' failed, too: {error}"));
    }
    let of_sinks = add_recordings(&mut report, &outcome);
    if let Some(converter) = &converter {
        add_converter(&mut report, converter);
        let found = converter.warnings();
        for warning in &found {
            report.warning(warning);
        }
        physics.extend(found);
    }
    for Entry { pulse, platform, text, .. } in &changes {
        report.line(format!("from pulse {pulse}: {text} on {platform}"));
    }
    if let Some(live) = live {
        add_navigation(&mut report, &run, &live.report(), &outcome);
    }
    let known = run.warnings.iter().map(ToString::to_string);
    let warnings: Vec<String> = known.chain(physics).chain(of_sinks).collect();
    report.value("changes", &changes).value("warnings", warnings);
    report.value("error", outcome.result.as_ref().err().map(ToString::to_string));
    report.say(args.output.format.json, out)?;
    outcome.result.map_err(|error| CliError::Run(Box::new(error)))
}

/// How the latency of a run suits its live navigation.
fn latency(run: &Run, needed_s: f64, latency_s: f64) {
    let needed_ms = (needed_s * 1e3).ceil();
    if run.stream.latency_given && latency_s < needed_s {
        warn([format!(
            "navigation arrives too late for stream.latency_ms = {}: pulses will be extrapolated; stream.latency_ms at least \
             {needed_ms} interpolates all of them (fidelity.node_pulses = 1 makes every pulse by itself, and saves a block)",
            latency_s * 1e3
        )]);
    } else if !run.stream.latency_given {
        say(format_args!("latency {:.0} ms, from the rate of the fixes", latency_s * 1e3));
    }
}

/// How pulses were released.
fn add_release(report: &mut Report, run: &Run, outcome: &RunOutcome, classes_db: &[f64]) {
    let (summary, health) = (&outcome.summary, &outcome.summary.health);
    let how = if summary.stopped { "stopped after" } else { "released" };
    // Two causes that ask for different remedies.
    let held_up = match health.held_up {
        0 => String::new(),
        ready => format!(" ({ready} of them computed in time, delayed by the operating system)"),
    };
    let made = match health.made {
        0 => "none was computed".to_owned(),
        _ => format!("computed at {:.1} times real time", summary.real_time_factor),
    };
    let (pulses, elapsed_s) = (counted(health.pulses, "pulse"), summary.elapsed_s);
    let (late, dropped) = (health.late, health.dropped);
    report
        .line(format!("{how} {pulses} in {elapsed_s:.2} s: {late} late{held_up}, {dropped} dropped; {made}"));
    if run.stream.policy == Policy::Relax && health.pulses > 0 {
        let of = |(class, pulses): (usize, &u64)| match classes_db.get(class) {
            Some(error_db) => format!("{} at {error_db:.0} dB", counted(*pulses, "pulse")),
            None => counted(*pulses, "pulse"),
        };
        let classes: Vec<String> = health.by_class.iter().enumerate().map(of).collect();
        report.line(format!("error classes: {}", classes.join(", ")));
    }
    if run.stream.pace == Pace::Realtime && health.pulses > 0 {
        let lateness = &health.lateness_us;
        report.line(format!(
            "lateness p50 {:.0} us, p99 {:.0} us, p99.9 {:.0} us, max {:.0} us; latency {:.2} ms; pacer at {}",
            lateness.p50,
            lateness.p99,
            lateness.p999,
            lateness.max,
            summary.latency_ms.unwrap_or(f64::NAN),
            run.stream.priority(health.pacer_ahead, run.scene.radar.emissions.mean_prf_hz())
        ));
    }
    if health.stood_still_s > 0.0 {
        report.warning(format_args!(
            "the machine, or this program, stood still for {} in all",
            span(health.stood_still_s)
        ));
    }
    if health.slipped_s > 0.0 {
        report.line(format!("time slipped by {} in all (policy \"slip\")", span(health.slipped_s)));
    }
    for right in health.rights.iter().filter(|right| !right.granted) {
        let reason = right.reason.as_deref().unwrap_or("refused");
        report.warning(format_args!("the system refused stream.{}: {reason}", right.asked));
    }
    for sink in health.sinks.iter().filter(|sink| sink.dropped > 0 && !sink.failed) {
        let missed = counted(sink.dropped, "pulse");
        report.warning(format_args!("sink '{}' was too slow and missed {missed}", sink.name));
    }
}

/// What each sink holds or has sent; returns its warnings.
fn add_recordings(report: &mut Report, outcome: &RunOutcome) -> Vec<String> {
    let sinks: Vec<&SinkReport> = outcome.reports.iter().filter_map(|(_, report)| report.as_ref()).collect();
    report.value("out", &sinks);
    let mut warnings = Vec::new();
    for sink in sinks {
        for line in sink.lines() {
            report.line(line);
        }
        for warning in sink.notes().into_iter().chain(sink.losses()) {
            report.warning(&warning);
            warnings.push(warning);
        }
    }
    warnings
}

/// What the converter was fed with.
fn add_converter(report: &mut Report, of: &ConverterReport) {
    let level = |channel: &ChannelReport| {
        format!("{} {:.2} LSB rms, {:.1} peak", channel.channel, channel.rms_lsb, channel.peak_lsb)
    };
    let levels: Vec<String> = of.channels.iter().map(level).collect();
    let levels = levels.join("; ");
    report
        .line(format!(
            "ADC of {} bits: {levels}; {} of {} samples saturated",
            of.bits, of.saturated, of.samples
        ))
        .value("converter", of);
}

/// So many pulses were.
fn were(pulses: u64) -> String {
    format!("{} {}", counted(pulses, "pulse"), if pulses == 1 { "was" } else { "were" })
}

/// A span of time, in milliseconds up to a second.
fn span(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.3} ms", seconds * 1e3) } else { format!("{seconds:.3} s") }
}

/// Whether the scenario itself asks for an attitude derived from the motion of a platform.
fn asked_to_derive(run: &Run, platform: &str) -> bool {
    let nav = run.scene.platforms.iter().zip(&run.nav).find(|(name, _)| *name == platform);
    nav.is_some_and(|(_, nav)| {
        matches!(&nav.truth, TrackSource::Live(source) if source.attitude != AttitudeSource::Automatic)
    })
}

/// What came of live navigation.
fn add_navigation(report: &mut Report, run: &Run, flights: &[FlightReport], outcome: &RunOutcome) {
    report.value("navigation", flights);
    let health = &outcome.summary.health;
    for flight in flights {
        let FlightReport { platform, source, counts, ahead, unusable, implausible, jumps, .. } = flight;
        report.line(format!("platform '{platform}' by {source}: {counts}"));
        if ahead + unusable > 0 {
            report.warning(format_args!(
                "{ahead} fixes were ahead of the schedule and {unusable} could not be used"
            ));
        }
        if *implausible > 0 {
            let after = match jumps {
                0 => String::new(),
                _ => format!("; {} they went on to agree and were believed", counted(*jumps, "time")),
            };
            report.warning(format_args!(
                "{} refused: the platform cannot have flown there (track.vehicle, max_speed_mps, max_acceleration_mps2){after}",
                counted(*implausible, "fix").replace("fixs", "fixes")
            ));
        }
        if flight.attitude_derived == Some(true) && !asked_to_derive(run, platform) {
            report.line(format!(
                "platform '{platform}': no attitude among the fixes: derived from the motion (coordinated turn)"
            ));
        }
    }
    if let Some(latency) = &health.navigation_to_release_ms {
        report.line(format!(
            "navigation to release {:.1} to {:.1} ms, median {:.1} ms, p99 {:.1} ms",
            latency.min, latency.max, latency.p50, latency.p99
        ));
    }
    if health.extrapolated > 0 {
        let (extrapolated, pulses, stale) =
            (health.extrapolated, counted(health.pulses, "pulse"), health.stale);
        report.warning(format_args!(
            "navigation was extrapolated for {extrapolated} of {pulses}, for {stale} of them it was stale"
        ));
    }
}

/// The run that the arguments ask for, and its pulses. Options that change what is emulated become part
/// of the recorded scenario text; pace, output and force do not, so that parts of a run can be joined.
fn prepare(args: &RunArgs) -> Result<(Run, Range<u64>), CliError> {
    let duration_s = args.duration_s.iter().map(|text| ("scene.duration_s".to_owned(), text.clone()));
    let mut run = args.scenario.load(&duration_s.collect::<Vec<_>>())?;
    run.control = args.control.is_some() || args.monitor_control;
    run.monitor = args.monitor.clone().or(run.monitor);
    if args.monitor_control && run.monitor.is_none() {
        return Err(Refused::ControlWithoutMonitor.into());
    }
    run.stream.pace = args.pace.unwrap_or(run.stream.pace);
    if let Some(out) = &args.out {
        redirect(&mut run.sinks, out)?;
        let misnamed = run.sinks.iter().filter_map(|sink| sink.kind.misnamed());
        run.warnings.extend(misnamed.map(|(path, kind)| Warning::Misnamed { path: path.to_owned(), kind }));
    }
    if args.output.overwrite.force {
        run.sinks.iter_mut().for_each(|sink| sink.kind.overwrite());
    }
    if let Some(shard) = args.shard.filter(|_| run.start_now) {
        return Err(
            Refused::value("shard", shard, "with the same start_utc for all shards, not \"now\"").into()
        );
    }
    run.shard = args.shard;
    let all = run.scene.pulses;
    let pulses = match (args.shard, args.pulses) {
        (Some(shard), _) => shard.pulses(all).ok_or(Refused::MoreShardsThanPulses { shard, pulses: all })?,
        (None, Some(range)) => range.into(),
        (None, None) => 0..all,
    };
    Ok((run, pulses))
}
