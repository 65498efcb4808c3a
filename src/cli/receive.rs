//! `nereus receive`: the reference receiver of the wire.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::error::CliError;
use super::report::Report;
use super::scenario::OutputArgs;
use super::values::{counts, seconds};
use super::{counted, escape, say, stop_on_ctrl_c};
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::outputs;
use crate::receive::listener::{Opener, Senders, Until, senders};
use crate::receive::report::Report as Reception;
use crate::receive::{Listener, parts};
use crate::sinks::{self, Kind, redirection};

/// `nereus receive`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct ReceiveArgs {
    /// Address and port of this machine; port 0 takes a free one and prints it
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:4991")]
    pub listen: String,
    /// End after so many whole pulses
    #[arg(long, value_name = "N", value_parser = counts(1, u64::MAX))]
    pub pulses: Option<u64>,
    /// End after so long
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration_s: Option<Duration>,
    /// End when nothing of a run has come for so long, once something has
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub idle_s: Option<Duration>,
    /// Take datagrams of this sender only: an address or name, with or without a port
    #[arg(long, value_name = "ADDR")]
    pub from: Option<String>,
    /// When the sender begins another run, follow it (with --out into a recording of its own: name-2, name-3,
    /// ...)
    #[arg(long)]
    pub restart: bool,
    /// Record whole pulses: HDF5 (.h5, .hdf5), or else a folder of plain files
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Receives, and reports.
pub(super) fn receive(args: &ReceiveArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let force = args.output.overwrite.force;
    let record = args.out.as_deref().map(|path| opener(path, force)).transpose()?;
    // The recordings of all runs are one output: what an earlier reception left is not taken for a part of
    // it.
    let older = args.out.as_deref().filter(|_| args.restart).map(parts::older).unwrap_or_default();
    preflight(older.iter().map(|path| Kind::recording_at(path, force)))?;
    let from = args.from.as_deref().map(senders).transpose()?;
    let next = args.out.clone().filter(|_| args.restart).map(|path| parts::further(path, force));
    let notice: Option<fn(&str)> = Some(|line| say(format_args!("warning: {line}")));
    let senders = Senders { from, restart: args.restart, next, older, notice };
    let listener = Listener::bind(&args.listen)?.with(senders);
    let stop = stop_on_ctrl_c(true)?;
    say(format_args!(
        "listening at {}, room for {} KiB of datagrams",
        listener.address(),
        listener.buffer_bytes() >> 10
    ));
    let until = Until { pulses: args.pulses, duration: args.duration_s, idle: args.idle_s };
    let (report, error) = match listener.receive(until, &stop, record, |_| {}) {
        Ok(report) => (report, None),
        Err(interrupted) => (interrupted.report, Some(interrupted.error)),
    };
    show(&report).print(args.output.format.json, out)?;
    error.map_or(Ok(()), |error| Err(error.into()))
}

fn preflight(kinds: impl Iterator<Item = Kind>) -> Result<(), CliError> {
    let settings: Vec<_> = kinds.map(|kind| sinks::Settings::new(kind, 1)).collect();
    outputs::preflight(&settings)
        .into_iter()
        .next()
        .map_or(Ok(()), |fault| Err(BuildErrors::from(fault).into()))
}

/// What makes the recording, when what is allowed has been looked at.
fn opener(path: &Path, force: bool) -> Result<Opener, CliError> {
    redirection::check_name(path)?;
    preflight(std::iter::once(Kind::recording_at(path, force)))?;
    Ok(parts::opener(path.to_owned(), force))
}

/// Pulses, gaps, order, datagrams, and what is known of sender, time and platforms.
fn show(found: &Reception) -> Report {
    let mut report = Report::default();
    report.values(found);
    let number = |pulse: Option<u64>| pulse.map_or("none".to_owned(), |pulse| pulse.to_string());
    let [first, last] = [found.first_pulse, found.last_pulse].map(number);
    report.row(
        "pulses",
        format!("{} whole, {} incomplete; numbers {first} to {last}", found.pulses, found.incomplete),
    );
    let missing = &found.missing;
    report.row(
        "gaps",
        format!(
            "{} by number, {} by time stamps, {} packets by packet counts",
            counted(missing.pulses_by_index, "pulse"),
            missing.pulses_by_time,
            missing.packets_by_count
        ),
    );
    report.row(
        "order",
        format!(
            "{} packets out of order, {} duplicate, {} late, {} off the sample grid; pulse number decreased {}",
            found.overtaken,
            found.duplicates,
            found.too_late,
            found.stray,
            counted(found.backwards, "time")
        ),
    );
    report.row(
        "datagrams",
        format!(
            "{} of {} bytes in all; {} malformed, {} unknown, {} before the description, {} conflicting descriptions",
            found.datagrams,
            found.bytes,
            found.malformed,
            found.unknown,
            found.undescribed,
            found.contradictions
        ),
    );
    report.row(
        "sender",
        format!(
            "{} with implausible time stamps, {} with implausible pulse numbers, {} of other senders; restarted {}",
            counted(found.implausible, "packet"),
            counted(found.misnumbered, "state"),
            counted(found.strangers, "datagram"),
            counted(found.restarts, "time")
        ),
    );
    if let Some(fault) = &found.first_fault {
        report.row("", format!("first malformed: {}", escape::name(fault)));
    }
    let drops = found.kernel_drops.map_or("not reported".to_owned(), |drops| drops.to_string());
    let room = found.receive_buffer_bytes >> 10;
    report.row("socket", format!("{room} KiB of room; {drops} datagrams dropped by the system"));
    let (emitted_s, arrived_s) = (found.emission_span_s, found.arrival_span_s);
    report.row("time", format!("{emitted_s:.3} s of emissions came in {arrived_s:.3} s"));
    report.row("lateness", found.lateness_text());
    add_platforms(&mut report, found);
    if let Some(recorded) = found.recorded {
        report.row("recorded", format!("{recorded} of {}", counted(found.pulses, "whole pulse")));
    }
    let missing = found.not_carried.join(", ");
    for file in &found.out {
        report.row("recording", format!("{}; the wire does not carry {missing}", escape::path(file)));
    }
    report
}

fn add_platforms(report: &mut Report, found: &Reception) {
    for platform in &found.platforms {
        let ([e, n, u], [ve, vn, vu]) = (platform.position_m, platform.velocity_mps);
        report.row(
            "platform",
            format!(
                "{} at pulse {}: {e:.3} m East, {n:.3} m North, {u:.3} m up; {ve:.3}, {vn:.3}, {vu:.3} m/s; \
                 report {:.3} s old, flags {:#x}",
                escape::name(&platform.name),
                platform.pulse,
                platform.age_s,
                platform.flags
            ),
        );
        if let [x, y, z] = platform.ecef_position_m
            && x.is_finite()
        {
            report.row("", format!("ECEF {x:.3}, {y:.3}, {z:.3} m"));
        }
    }
}
