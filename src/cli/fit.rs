//! `nereus fit`: what makes a scenario run in real time on this machine.

use std::io::Write;
use std::time::Duration;

use clap::Args;

use super::error::CliError;
use super::report::Report;
use super::scenario::{JsonArg, ScenarioArgs, warn_of_scene};
use super::values::{allowed, counts};
use super::{counted, escape, progress, say};
use crate::bench::fit::{Fit, Limit, MARGIN, Remedy};
use crate::bench::fit_trials::{Search, search};
use crate::bench::sweep::Overrides;
use crate::units::digits;

/// `nereus fit`
#[derive(Debug, Args)]
pub struct FitArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Fit it into real time: what it is fitted into unless something else is asked
    #[arg(long)]
    pub real_time: bool,
    /// Times real time that are wanted: what is above 1 is for sinks, the pacer and other programs
    #[arg(long, value_name = "FACTOR", default_value_t = MARGIN, value_parser = factor)]
    pub margin: f64,
    /// Time for which the speed of each change is measured, ms; 0: changes are predicted, and not measured
    #[arg(long, value_name = "MS", default_value_t = 300, value_parser = counts(0, 60_000))]
    pub trial_ms: u64,
    /// Time after which nothing more is tried, s; twice as long while nothing fits
    #[arg(long, value_name = "S", default_value_t = 15, value_parser = counts(1, 86_400))]
    pub limit_s: u64,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// Reads a number of times real time.
fn factor(text: &str) -> Result<f64, super::values::Unreadable> {
    let factor = text.parse().ok().filter(|factor: &f64| *factor > 0.0 && *factor <= 1e9);
    allowed(factor, "a number above 0, up to 1e9")
}

/// Looks for changes, and prints them.
pub(super) fn fit(args: &FitArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let load = |change: &Overrides| args.scenario.load_to_measure(None, change);
    let run = load(&Vec::new())?;
    warn_of_scene(&run);
    say("speed as written ...");
    let asked = Search {
        margin: args.margin,
        trial: Duration::from_millis(args.trial_ms),
        limit: Duration::from_secs(args.limit_s),
    };
    let found = progress::counting("kinds of change", |passed| search(&run, &asked, load, passed))?;
    let mut report = Report::default();
    let name = run.path.display().to_string();
    report.value("scenario", &name).values(&found);
    add_text(&mut report, &name, &found);
    report.print(args.format.json, out)?;
    let fits = found.fits || !found.remedies.is_empty();
    if fits { Ok(()) } else { Err(CliError::NoFit { path: run.path, margin: args.margin }) }
}

fn add_text(report: &mut Report, name: &str, found: &Fit) {
    let threads = counted(found.threads, "thread");
    let at = found.error_db.map_or("the reference".to_owned(), |db| format!("{db} dB"));
    let word = if found.fits { "fits" } else { "does not fit" };
    let factor = digits(found.real_time_factor);
    report.line(format!(
        "{name}: {word}: {factor} times real time at {at} with {threads}, {} wanted",
        found.margin
    ));
    if let Some(db) = found.fits_at_db {
        report.line(format!("it is predicted to fit at {db} dB as well"));
    }
    for remedy in &found.remedies {
        add_remedy(report, remedy);
    }
    match &found.nearest {
        _ if found.fits || !found.remedies.is_empty() => {}
        Some(nearest) => {
            report.line("nothing that was tried makes it fit; nearest:");
            add_remedy(report, nearest);
        }
        None => {
            report.line("nothing that was tried makes it faster");
        }
    }
    if let Some(Limit { stage, share }) = found.limit {
        let share = 100.0 * share;
        report.line(format!(
            "most of the fastest is spent in the stage {stage}: {share:.0} %, by the cost model"
        ));
    }
    if found.out_of_time {
        report.line("not all was tried; --limit-s gives more time");
    }
    for refused in &found.refused {
        report.line(format!("not tried: {}: {}", refused.change, escape::name(&refused.why)));
    }
}

/// The words that make a change, its speed, and a line for what it costs.
fn add_remedy(report: &mut Report, remedy: &Remedy) {
    let quoted = |set: &String| {
        if set.contains(['[', '"', ' ']) { format!("--set '{set}'") } else { format!("--set {set}") }
    };
    let words: Vec<String> = remedy.set.iter().map(quoted).collect();
    let how = if remedy.real_time_factor.is_some() { "" } else { " predicted" };
    report.line(format!("{} times{how}: {}", digits(remedy.factor()), words.join(" ")));
    let predicted = remedy.predicted_rel_rms_db.map(|db| format!("{db:.1} dB predicted"));
    let costs: Vec<String> = remedy.costs.iter().cloned().chain(predicted).collect();
    report.line(format!("    {}", costs.join("; ")));
    for warning in &remedy.warnings {
        report.line(format!("    warns: {warning}"));
    }
}
