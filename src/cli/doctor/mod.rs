//! `nereus doctor`: is this machine fit for real time, and what would make it fitter.
//!
//! What the system grants and how it is set is read, never changed. Then a trial: pulses without echo pass
//! through the ring, the pacer and a sink of a run, beside busy threads like those that make echoes, and
//! their lateness is counted as a run counts it.

mod disk;
mod machine;
mod trial;

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::error::CliError;
use super::report::Report;
use super::scenario::JsonArg;
use super::values::{allowed, counts};
use super::{escape, say};
use crate::bench::lateness::{Asked, Lateness, measure};

/// `nereus doctor`
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Where recordings will be: up to 64 MiB are written there to measure the disk, and removed
    #[arg(value_name = "FOLDER", default_value = ".")]
    pub folder: PathBuf,
    /// How long the lateness of pulses is tried, s; 0: not at all
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = seconds)]
    pub seconds: f64,
    /// Pulses per second of the trial, Hz
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, value_parser = prf)]
    pub prf_hz: f64,
    /// Busy threads beside the trial; as many as the machine has unless given
    #[arg(long, value_name = "T", value_parser = counts(0, 4096))]
    pub busy_threads: Option<u64>,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

fn seconds(text: &str) -> Result<f64, super::values::Unreadable> {
    let read = text.parse().ok().filter(|seconds| (0.0..=3600.0).contains(seconds));
    allowed(read, "a number from 0 to 3600 s")
}

fn prf(text: &str) -> Result<f64, super::values::Unreadable> {
    let read = text.parse().ok().filter(|prf_hz| (1.0..=20_000.0).contains(prf_hz));
    allowed(read, "a number from 1 to 20000 Hz")
}

/// How good something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Verdict {
    /// As it should be.
    Fine,
    /// It works; the remedy makes it better.
    Improve,
    /// The system does not show it.
    Unknown,
}

/// One thing that was examined.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Finding {
    /// What was examined.
    check: &'static str,
    /// How good it is.
    verdict: Verdict,
    /// What was found.
    found: String,
    /// The figure that was judged, in the unit of `unit`.
    value: Option<f64>,
    unit: Option<&'static str>,
    /// What would make it better.
    remedy: Option<String>,
}

impl Finding {
    fn new(check: &'static str, is_fine: bool, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        let (verdict, remedy) =
            if is_fine { (Verdict::Fine, None) } else { (Verdict::Improve, Some(remedy.into())) };
        Self { check, verdict, found: found.into(), value: None, unit: None, remedy }
    }

    fn unknown(check: &'static str, why: impl Into<String>) -> Self {
        Self { verdict: Verdict::Unknown, ..Self::new(check, true, why, "") }
    }

    /// With the figure that was judged.
    fn of(self, value: f64, unit: &'static str) -> Self {
        Self { value: Some(value), unit: Some(unit), ..self }
    }
}

/// Examines the machine, and reports.
pub(super) fn doctor(args: &DoctorArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let mut findings = machine::examine();
    findings.push(disk::examine(&args.folder)?);
    let lateness = (args.seconds > 0.0).then(|| {
        let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get() as u64);
        let busy_threads = args.busy_threads.unwrap_or(threads);
        let asked = Asked { seconds: args.seconds, prf_hz: args.prf_hz, busy_threads };
        say(format_args!("trial of lateness: {} s at {} Hz ...", asked.seconds, asked.prf_hz));
        measure(asked)
    });
    let lateness = lateness.transpose()?;
    report(&findings, lateness.as_ref()).print(args.format.json, out)
}

fn report(findings: &[Finding], lateness: Option<&Lateness>) -> Report {
    let mut report = Report::default();
    report.title("this machine");
    for finding in findings {
        let mark = match finding.verdict {
            Verdict::Fine => "fine",
            Verdict::Improve => "improve",
            Verdict::Unknown => "unknown",
        };
        report.row(finding.check, format!("{mark:7}  {}", escape::name(&finding.found)));
        if let Some(remedy) = &finding.remedy {
            report.row("", format!("         -> {remedy}"));
        }
    }
    let tried = lateness.map(trial::finding);
    if let (Some(lateness), Some(tried)) = (lateness, &tried) {
        trial::add_to(&mut report, lateness, tried);
    }
    let open = findings.iter().chain(&tried).filter(|finding| finding.verdict == Verdict::Improve).count();
    report.line(match open {
        0 => "nothing to improve was found".to_owned(),
        1 => "1 thing to improve".to_owned(),
        more => format!("{more} things to improve"),
    });
    report.value("fine", open == 0).value("findings", findings).value("lateness", lateness);
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remedies_stand_below_what_is_to_improve() {
        let findings = [
            Finding::new("clock source", true, "tsc", "none"),
            Finding::new("frequency governor", false, "powersave", "cpupower frequency-set -g performance"),
            Finding::unknown("large pages", "not shown"),
        ];
        let report = report(&findings, None);
        insta::assert_snapshot!(report.text(), @r"
        this machine
          clock source        fine     tsc
          frequency governor  improve  powersave
                                       -> cpupower frequency-set -g performance
          large pages         unknown  not shown
        1 thing to improve
        ");
        let json: serde_json::Value = serde_json::from_str(&report.json().unwrap()).unwrap();
        assert_eq!(json["fine"], false);
        assert_eq!(json["findings"][2]["verdict"], "unknown");
        assert_eq!(json["findings"][0]["remedy"], serde_json::Value::Null);
    }

    #[test]
    fn times_out_of_range_are_refused() {
        for text in ["-1", "nan", "3601", "a"] {
            assert!(seconds(text).is_err(), "{text}");
        }
        assert!(prf("0.5").is_err() && prf("20001").is_err() && prf("250").is_ok());
    }
}
