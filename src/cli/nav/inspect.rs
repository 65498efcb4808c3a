//! `nereus nav inspect`

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::SourceArgs;
use crate::cli::error::CliError;
use crate::cli::escape::name;
use crate::cli::report::Report;
use crate::cli::scenario::JsonArg;
use crate::motion::proposal::{block, lacks_datum};
use crate::nav::decode::Counts;
use crate::nav::inspection::{Captured, KINDS, Recorded, TrackFigures};

/// `nereus nav inspect`
#[derive(Debug, Args)]
pub struct NavInspectArgs {
    /// The recording
    pub file: PathBuf,
    /// How it is read
    #[command(flatten)]
    pub source: SourceArgs,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// What the scenario must add to a block without it.
const NO_DATUM: &str = "the file does not state what its heights refer to: \
                        datum = \"ellipsoid\", \"msl\" or \"barometric\"";

/// Reports what a recording holds.
pub(super) fn inspect(args: &NavInspectArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let how = args.source.reading();
    let recorded = Recorded::read(&args.file, &how)?;
    let mut report = Report::default();
    let (file, format) = (args.file.display().to_string(), recorded.encoding.name());
    report.row("file", name(&file)).value("file", &file);
    report.row("format", format!("{format}, {} bytes", recorded.bytes));
    report.value("format", format).value("bytes", recorded.bytes);
    add_messages(&mut report, &recorded);
    let track = recorded.track.as_ref().ok().map(TrackFigures::of);
    if let Some(track) = &track {
        add_track(&mut report, track);
    }
    report.value("track", track);
    let error = recorded.track.as_ref().err().map(ToString::to_string);
    if let Some(error) = &error {
        report.row("no track", error);
    }
    let fixes = recorded.track.as_ref().ok().map(|recording| &recording.fixes[..]);
    let scenario = fixes.and_then(|fixes| block(&args.file, recorded.encoding, &how, fixes));
    if let Some(block) = &scenario {
        // On a line of its own, to be copied.
        report.row("scenario", "under [[platform]], its path relative to the scenario:");
        if fixes.is_some_and(|fixes| lacks_datum(recorded.encoding, &how, fixes)) {
            report.row("", NO_DATUM);
        }
        report.line(block);
    }
    report.value("scenario", scenario).value("error", error);
    report.print(args.format.json, out)?;
    match recorded.track {
        Ok(_) => Ok(()),
        Err(_) => Err(CliError::NoTrack(args.file.clone())),
    }
}

/// Packets of a capture, and messages by kind.
fn add_messages(report: &mut Report, recorded: &Recorded) {
    if let Some(Captured { packets, packets_left, stream, missing_bytes }) = &recorded.capture {
        report.row(
            "capture",
            format!("{packets} packets, {packets_left} left; {stream}, {missing_bytes} bytes missing"),
        );
    }
    report.value("capture", &recorded.capture);
    let mut found: Vec<(&str, u64)> = Vec::new();
    if let Some((counts, kinds)) = &recorded.messages {
        let Counts { good, bad_checksum, unknown, malformed, void, .. } = counts;
        report.row(
            "messages",
            format!(
                "{good} good ({void} void), {bad_checksum} with a wrong checksum, {unknown} of other kinds, \
                 {malformed} malformed"
            ),
        );
        found = KINDS.into_iter().zip(*kinds).filter(|(_, count)| *count > 0).collect();
        let kinds: Vec<String> = found.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
        report.row("kinds", kinds.join(", "));
    }
    report.value("messages", recorded.messages.map(|(counts, _)| counts)).value("kinds", found);
}

fn add_track(report: &mut Report, track: &TrackFigures) {
    let week = track.gps_week.map_or(String::new(), |week| format!(" (GPS week {week})"));
    report.row("fixes", track.fixes.to_string());
    report.row("time", format!("{} to {}{week}", track.first, track.last));
    report.row("span", format!("{:.3} s, {:.3} per second", track.span_s, track.rate_hz));
    report.row("gaps", format!("{}, longest interval {:.3} s", track.gaps, track.longest_gap_s));
    for (begin, length_s) in &track.gaps_s {
        report.row("", format!("{length_s:.3} s after {begin}"));
    }
    if let (Some([south, north]), Some([west, east])) = (track.lat_deg, track.lon_deg) {
        report.row("area", format!("{south:.6} .. {north:.6} deg N, {west:.6} .. {east:.6} deg E"));
    }
    report.row("height", format!("{:.2} .. {:.2} m", track.height_m[0], track.height_m[1]));
    let [slow, mean, fast] = track.speed_mps;
    report.row("speed", format!("{slow:.2} .. {fast:.2} m/s, mean {mean:.2}"));
    report.row("contains", track.contents());
    if let Some([east, north, up]) = track.worst_sigma_m {
        report.row("worst", format!("{east:.3} m East, {north:.3} m North, {up:.3} m up"));
    }
    // Sentences that were skipped stand above.
    for note in track.read.notes_of_fixes() {
        report.row("", note);
    }
}
