//! A recording of any format, read for the tools.

use std::path::Path;

use super::error::NavToolError;
use super::{Datum, Source, SourceArgs};
use crate::cli::escape;
use crate::cli::say;
use crate::nav::decode::{Content, Counts, Decoder};
use crate::nav::replay::{self, read_bytes};
use crate::nav::solution::{Solution, derive_velocities};
use crate::nav::{
    AttitudeSource, FileFormat, FileSource, NavError, Place, Recording, Smoothing, VerticalDatum, pcap,
};

/// Kinds of messages, by name.
pub(super) const KINDS: [&str; 9] = ["GGA", "RMC", "GLL", "VTG", "HDT", "ZDA", "GST", "PASHR", "INSPVAX"];

/// What was read.
pub(super) struct Recorded {
    /// As it was read.
    pub format: Source,
    /// Bytes of messages or rows.
    pub bytes: usize,
    /// Messages that were found, and how many of each kind; none in files that hold no messages.
    pub messages: Option<(Counts, [u64; KINDS.len()])>,
    /// A capture: packets, packets that were left, and of the stream that was read its name and what is
    /// missing.
    pub capture: Option<(u64, u64, String, u64)>,
    /// Fixes, or why there are none.
    pub track: Result<Recording, NavError>,
}

fn count(bytes: &[u8]) -> (Counts, [u64; KINDS.len()]) {
    let (mut decoder, mut kinds) = (Decoder::new(), [0; KINDS.len()]);
    let mut see = |message: crate::nav::decode::Message| {
        let kind = match message.content {
            Content::Gga(_) => 0,
            Content::Rmc(_) => 1,
            Content::Gll(_) => 2,
            Content::Vtg(_) => 3,
            Content::Hdt(_) => 4,
            Content::Zda(_) => 5,
            Content::Gst(_) => 6,
            Content::Pashr(_) => 7,
            Content::Inspvax(_) => 8,
        };
        kinds[kind] += 1;
    };
    decoder.push(bytes, &mut see);
    decoder.finish(&mut see);
    (*decoder.counts(), kinds)
}

/// The format of a file from its first bytes and its name.
fn sniffed(bytes: &[u8], path: &Path) -> Source {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let is_pcap = [
        [0xD4, 0xC3, 0xB2, 0xA1],
        [0xA1, 0xB2, 0xC3, 0xD4],
        [0x4D, 0x3C, 0xB2, 0xA1],
        [0xA1, 0xB2, 0x3C, 0x4D],
    ]
    .iter()
    .any(|magic| bytes.starts_with(magic));
    if is_pcap || bytes.starts_with(&[0x1F, 0x8B]) {
        return Source::Pcap;
    }
    if extension == "sbet" || extension == "out" {
        return Source::Sbet;
    }
    if extension == "csv" {
        return Source::Csv;
    }
    // The beginning decides; a megabyte holds many messages.
    let (_, kinds) = count(&bytes[..bytes.len().min(1 << 20)]);
    if kinds[8] > 0 { Source::Inspvax } else { Source::Nmea }
}

impl Recorded {
    pub fn read(path: &Path, args: &SourceArgs) -> Result<Self, NavToolError> {
        let bytes = read_bytes(path)?;
        let format = args.from.unwrap_or_else(|| sniffed(&bytes, path));
        let source = |format| FileSource {
            path: path.to_owned(),
            format,
            datum: match args.datum {
                Datum::Ellipsoid => VerticalDatum::Ellipsoid,
                Datum::Msl => VerticalDatum::MeanSeaLevel,
            },
            undulation_m: args.undulation_m,
            // Gaps are reported, not refused.
            max_gap_s: f64::INFINITY,
            smoothing: Smoothing::Off,
            attitude: AttitudeSource::Level,
        };
        let whole = |format: Source, messages, of| Self {
            format,
            bytes: bytes.len(),
            messages,
            capture: None,
            track: replay::parse(&bytes, &source(of)),
        };
        Ok(match format {
            Source::Csv => whole(format, None, FileFormat::Csv),
            Source::Nmea => whole(format, Some(count(&bytes)), FileFormat::Nmea),
            Source::Inspvax => whole(format, Some(count(&bytes)), FileFormat::Inspvax),
            Source::Sbet => {
                let gps_week = args.gps_week.ok_or_else(|| NavToolError::Week { path: path.to_owned() })?;
                whole(format, None, FileFormat::Sbet { gps_week })
            }
            Source::Pcap => {
                let capture = pcap::parse(&bytes)
                    .map_err(|source| NavToolError::Capture { path: path.to_owned(), source })?;
                // The stream with the most positions.
                let heard = capture.streams.into_iter().map(|stream| (count(&stream.bytes), stream));
                let best = heard.max_by_key(|((counts, _), _)| counts.good);
                let Some(((counts, kinds), stream)) = best.filter(|((counts, _), _)| counts.good > 0) else {
                    return Err(NavToolError::Silent { path: path.to_owned() });
                };
                let of = if kinds[8] > 0 { FileFormat::Inspvax } else { FileFormat::Nmea };
                Self {
                    format,
                    bytes: stream.bytes.len(),
                    messages: Some((counts, kinds)),
                    capture: Some((capture.packets, capture.left, stream.name, stream.missing_bytes)),
                    track: replay::parse(&stream.bytes, &source(of)),
                }
            }
        })
    }
}

/// The states of a recording, to be written elsewhere. Velocities that it does not have are derived.
pub(super) fn solutions(path: &Path, args: &SourceArgs) -> Result<Vec<Solution>, NavToolError> {
    let recorded = Recorded::read(path, args)?;
    let recording = recorded.track?;
    say(format_args!("{}: {}", escape::path(path), recording.report));
    if recording.fixes.iter().any(|fix| matches!(fix.place, Place::Local(_))) {
        return Err(NavToolError::Local { path: path.to_owned() });
    }
    let mut solutions: Vec<Solution> =
        recording.fixes.iter().filter_map(|fix| Solution::of_fix(fix, args.undulation_m)).collect();
    let derived = derive_velocities(&mut solutions);
    if derived > 0 {
        say(format_args!("velocities of {derived} fixes derived from their neighbours"));
    }
    Ok(solutions)
}
