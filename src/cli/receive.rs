//! `nereus receive`: the reference receiver of the wire.

use super::values::{counts, seconds};
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::error::CliError;
use super::escape;
use super::json;
use super::run::names_hdf5;
use super::{counted, say};
use crate::files;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::outputs;
use crate::receive::listener::{Opener, Senders, Until, senders};
use crate::receive::report::Report;
use crate::receive::{Listener, RUNS};
use crate::sinks::plain::PlainSink;
use crate::sinks::sink::Sink;
use crate::sinks::{self, Kind};

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
    /// Overwrite a recording that exists
    #[arg(long)]
    pub force: bool,
    /// Print the report as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Receives, and reports.
pub(super) fn receive(args: &ReceiveArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let record = args.out.as_deref().map(|path| opener(path, args.force)).transpose()?;
    // The recordings of all runs are one output: what an earlier reception left is not taken for a part of
    // it.
    let older = args.out.as_deref().filter(|_| args.restart).map(parts).unwrap_or_default();
    preflight(older.iter().map(|path| kind(path, args.force)))?;
    let from = args.from.as_deref().map(senders).transpose()?;
    let next = args.out.clone().filter(|_| args.restart).map(|path| further(path, args.force));
    let notice: Option<fn(&str)> = Some(|line| say(format_args!("warning: {line}")));
    let senders = Senders { from, restart: args.restart, next, older, notice };
    let listener = Listener::bind(&args.listen)?.with(senders);
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::AcqRel) {
            std::process::exit(130);
        }
    })
    .map_err(CliError::Signal)?;
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
    if args.json {
        let shown = Report { out: json::all_legible(&report.out), ..report.clone() };
        json::print(&shown, out)?;
    } else {
        tell(&report, out).map_err(CliError::Output)?;
    }
    error.map_or(Ok(()), |error| Err(error.into()))
}

/// Name of the recording of a further run: `name-2.h5`, `name-3.h5`, ...
fn part(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = format!("{stem}-{number}");
    if let Some(extension) = path.extension() {
        name = format!("{name}.{}", extension.to_string_lossy());
    }
    path.with_file_name(name)
}

/// Recordings of further runs that an earlier reception left. `flight-20180509.h5` is none, nor what a run
/// has written.
fn parts(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(files::folder(path)) else { return Vec::new() };
    let stem = format!("{}-", path.file_stem().unwrap_or_default().to_string_lossy());
    let mut found: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| path.with_file_name(entry.file_name()))
        .filter(|candidate| {
            let name = candidate.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let number = name.strip_prefix(&stem).and_then(|number| number.parse().ok());
            let is_part = |number| (2..=RUNS + 1).contains(&number) && part(path, number) == *candidate;
            number.is_some_and(is_part) && is_received(candidate)
        })
        .collect();
    found.sort();
    found
}

fn is_received(path: &Path) -> bool {
    #[cfg(feature = "hdf5")]
    if names_hdf5(path) {
        return crate::recording::hdf5::file::is_received(path);
    }
    crate::recording::plain::is_received(path)
}

/// What makes the recordings of further runs.
fn further(path: PathBuf, force: bool) -> Box<dyn Fn(usize) -> Opener + Send + Sync> {
    Box::new(move |number| made_at(part(&path, number), force))
}

fn kind(path: &Path, force: bool) -> Kind {
    match names_hdf5(path) {
        true => Kind::Hdf5 { path: path.to_owned(), segment_s: None, force },
        false => Kind::Plain { path: path.to_owned(), force },
    }
}

fn preflight(kinds: impl Iterator<Item = Kind>) -> Result<(), CliError> {
    let settings: Vec<_> = kinds.map(|kind| sinks::Settings { kind, queue_pulses: 1 }).collect();
    outputs::preflight(&settings)
        .into_iter()
        .next()
        .map_or(Ok(()), |fault| Err(BuildErrors::from(fault).into()))
}

/// What makes the recording, when what is allowed has been looked at.
fn opener(path: &Path, force: bool) -> Result<Opener, CliError> {
    if names_hdf5(path) && !cfg!(feature = "hdf5") {
        return Err(CliError::NoHdf5 { out: path.to_owned() });
    }
    preflight(std::iter::once(kind(path, force)))?;
    Ok(made_at(path.to_owned(), force))
}

/// What makes a recording at a path.
fn made_at(path: PathBuf, force: bool) -> Opener {
    Box::new(move |header| {
        #[cfg(feature = "hdf5")]
        if names_hdf5(&path) {
            let sink = sinks::hdf5::Hdf5Sink::create(&path, None, force, header)?;
            return Ok(Box::new(sink) as Box<dyn Sink>);
        }
        Ok(Box::new(PlainSink::create(&path, force, header)?) as Box<dyn Sink>)
    })
}

/// The report for people.
fn tell(report: &Report, out: &mut dyn Write) -> io::Result<()> {
    let number = |pulse: Option<u64>| pulse.map_or("none".to_owned(), |pulse| pulse.to_string());
    writeln!(
        out,
        "pulses      {} whole, {} incomplete; numbers {} to {}",
        report.pulses,
        report.incomplete,
        number(report.first_pulse),
        number(report.last_pulse)
    )?;
    writeln!(
        out,
        "gaps        {} by number, {} by time stamps, {} packets by packet counts",
        counted(report.missing.pulses_by_index, "pulse"),
        report.missing.pulses_by_time,
        report.missing.packets_by_count
    )?;
    writeln!(
        out,
        "order       {} packets out of order, {} duplicate, {} late, {} off the sample grid; pulse number decreased {}",
        report.overtaken,
        report.duplicates,
        report.too_late,
        report.stray,
        counted(report.backwards, "time")
    )?;
    writeln!(
        out,
        "datagrams   {} of {} bytes in all; {} malformed, {} unknown, {} before the description, {} conflicting descriptions",
        report.datagrams,
        report.bytes,
        report.malformed,
        report.unknown,
        report.undescribed,
        report.contradictions
    )?;
    writeln!(
        out,
        "sender      {} with implausible time stamps, {} with implausible pulse numbers, {} of other senders; began again {}",
        counted(report.implausible, "packet"),
        counted(report.misnumbered, "state"),
        counted(report.strangers, "datagram"),
        counted(report.restarts, "time")
    )?;
    if let Some(fault) = &report.first_fault {
        writeln!(out, "            first malformed: {}", escape::name(fault))?;
    }
    let drops = report.kernel_drops.map_or("not reported".to_owned(), |drops| drops.to_string());
    writeln!(
        out,
        "socket      {} KiB of room; {drops} datagrams dropped by the system",
        report.receive_buffer_bytes >> 10
    )?;
    writeln!(
        out,
        "time        {:.3} s of emissions came in {:.3} s",
        report.emission_span_s, report.arrival_span_s
    )?;
    match &report.lateness {
        Some(late) => writeln!(
            out,
            "lateness    p50 {:.0} us, p99 {:.0} us, max {:.0} us above the earliest pulse; that one came {:.6} s after its emission by this clock",
            late.p50_us, late.p99_us, late.max_us, late.least_offset_s
        )?,
        None if report.datagrams == 0 => writeln!(out, "lateness    not reported: nothing was received")?,
        None if report.pulses < 2 => {
            writeln!(out, "lateness    not reported: fewer than two whole pulses were received")?;
        }
        None => writeln!(out, "lateness    not reported: the stream was not sent in real time")?,
    }
    for platform in &report.platforms {
        let ([e, n, u], [ve, vn, vu]) = (platform.position_m, platform.velocity_mps);
        writeln!(
            out,
            "platform    {} at pulse {}: {e:.3} m East, {n:.3} m North, {u:.3} m up; {ve:.3}, {vn:.3}, {vu:.3} m/s; report {:.3} s old, flags {:#x}",
            escape::name(&platform.name),
            platform.pulse,
            platform.age_s,
            platform.flags
        )?;
        if let [x, y, z] = platform.ecef_position_m
            && x.is_finite()
        {
            writeln!(out, "            ECEF {x:.3}, {y:.3}, {z:.3} m")?;
        }
    }
    if let Some(recorded) = report.recorded {
        writeln!(out, "recorded    {recorded} of {}", counted(report.pulses, "whole pulse"))?;
    }
    for file in &report.out {
        writeln!(
            out,
            "recording   {}; the wire does not carry {}",
            escape::path(file),
            report.not_carried.join(", ")
        )?;
    }
    Ok(())
}
