//! What a recording of navigation holds: messages by kind, fixes, gaps, area, speeds.

use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::decode::{Content, Counts, Decoder, Message};
use super::pcap::{self, CaptureError};
use super::{
    AttitudeSource, FileFormat, FileSource, Fix, MotionBounds, NavError, Place, Recording, Smoothing,
    VerticalDatum, replay, unpacked,
};
use crate::frames::Geodetic;
use crate::inputs::shown;
use crate::nav::load_report::LoadReport;

/// An interval is a gap when it is longer than so many of the usual ones.
const GAP_INTERVALS: f64 = 1.5;
/// Gaps that are listed.
const MOST_GAPS: usize = 10;

/// What a recording is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Comma-separated values.
    Csv,
    /// NMEA 0183 log, NovAtel messages among it.
    Nmea,
    /// NovAtel INSPVAX, ASCII or binary.
    Inspvax,
    /// Smoothed best estimate of trajectory.
    Sbet,
    /// GPX.
    Gpx,
    /// KML.
    Kml,
    /// Capture of a receiver's messages on a network.
    Pcap,
}

impl Encoding {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Nmea => "nmea",
            Self::Inspvax => "inspvax",
            Self::Sbet => "sbet",
            Self::Gpx => "gpx",
            Self::Kml => "kml",
            Self::Pcap => "pcap",
        }
    }
}

/// How a recording is read.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Its encoding; `None`: found from its first bytes and its name.
    pub encoding: Option<Encoding>,
    /// GPS week of the first record of an SBET.
    pub gps_week: Option<u32>,
    /// What heights are measured from, where the file does not say; `None`: the ellipsoid is supposed.
    pub datum: Option<VerticalDatum>,
    /// Height of mean sea level above the ellipsoid, m.
    pub undulation_m: f64,
    /// The day of the first fix of a log (since 1970-01-01), in place of its dates.
    pub first_day: Option<i64>,
}

/// Why a recording cannot be inspected.
#[derive(Debug, Error)]
pub enum InspectionError {
    /// It cannot be read.
    #[error(transparent)]
    Nav(#[from] NavError),
    /// The capture cannot be read.
    #[error("{}: {source}", shown(path))]
    Capture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: CaptureError,
    },
    /// An SBET has no week of its own.
    #[error(
        "{}: an SBET has neither date nor week; needed: --gps-week, such as 2000 (from 2018-05-06)",
        shown(path)
    )]
    Week {
        /// The file.
        path: PathBuf,
    },
    /// A capture without navigation.
    #[error("{}: no stream of this capture holds a message that is read", shown(path))]
    Silent {
        /// The file.
        path: PathBuf,
    },
}

/// A capture and the stream of it that was read.
#[derive(Clone, Debug, Serialize)]
pub struct Captured {
    /// Packets.
    pub packets: u64,
    /// Packets that were not read.
    pub packets_left: u64,
    /// The stream with the most positions.
    pub stream: String,
    /// Bytes of it that are missing.
    pub missing_bytes: u64,
}

/// Kinds of messages, by name.
pub const KINDS: [&str; 12] =
    ["GGA", "GNS", "RMC", "GLL", "VTG", "HDT", "THS", "ZDA", "GST", "PASHR", "INSPVAX", "INSPVA"];
/// Kinds of NovAtel receivers among them.
const NOVATEL: std::ops::Range<usize> = 10..12;

/// What was read.
#[derive(Debug)]
pub struct Recorded {
    /// As it was read.
    pub encoding: Encoding,
    /// Bytes of messages or rows.
    pub bytes: usize,
    /// Messages that were found, and how many of each kind; none in files that hold no messages.
    pub messages: Option<(Counts, [u64; KINDS.len()])>,
    /// The capture it came from.
    pub capture: Option<Captured>,
    /// Fixes, or why there are none.
    pub track: Result<Recording, NavError>,
}

fn count(bytes: &[u8]) -> (Counts, [u64; KINDS.len()]) {
    let (mut decoder, mut kinds) = (Decoder::new(), [0; KINDS.len()]);
    let mut see = |message: Message| {
        let kind = match message.content {
            Content::Gga(_) => 0,
            Content::Gns(_) => 1,
            Content::Rmc(_) => 2,
            Content::Gll(_) => 3,
            Content::Vtg(_) => 4,
            Content::Hdt(_) => 5,
            Content::Ths(_) => 6,
            Content::Zda(_) => 7,
            Content::Gst(_) => 8,
            Content::Pashr(_) => 9,
            Content::Inspvax(_) => 10,
            Content::Inspva(_) => 11,
        };
        kinds[kind] += 1;
    };
    decoder.push(bytes, &mut see);
    decoder.finish(&mut see);
    (*decoder.counts(), kinds)
}

/// The format of a file from its first bytes and its name.
fn sniffed(bytes: &[u8], path: &Path) -> Encoding {
    // Of a gzipped file the name before `.gz` counts.
    let ending = |path: &Path| path.extension().unwrap_or_default().to_ascii_lowercase();
    let stem = Path::new(path.file_stem().unwrap_or_default());
    let extension = if ending(path) == "gz" { ending(stem) } else { ending(path) };
    if pcap::is_capture(bytes) {
        return Encoding::Pcap;
    }
    let endings = [
        ("sbet", Encoding::Sbet),
        ("out", Encoding::Sbet),
        ("csv", Encoding::Csv),
        ("gpx", Encoding::Gpx),
        ("kml", Encoding::Kml),
    ];
    if let Some((_, encoding)) = endings.into_iter().find(|(ending, _)| extension == *ending) {
        return encoding;
    }
    // The beginning decides; a megabyte holds many messages.
    let begin = unpacked::utf8(&bytes[..bytes.len().min(1 << 20)]);
    let holds = |tag: &[u8]| begin.windows(tag.len()).take(1 << 12).any(|bytes| bytes == tag);
    if begin.trim_ascii_start().starts_with(b"<") && holds(b"<gpx") {
        return Encoding::Gpx;
    }
    if begin.trim_ascii_start().starts_with(b"<") && holds(b"<kml") {
        return Encoding::Kml;
    }
    let (_, kinds) = count(&begin);
    if has_novatel(&kinds) { Encoding::Inspvax } else { Encoding::Nmea }
}

/// Whether messages of NovAtel receivers are among those of each kind.
fn has_novatel(kinds: &[u64; KINDS.len()]) -> bool {
    kinds[NOVATEL].iter().any(|count| *count > 0)
}

impl Recorded {
    /// Reads a recording. Gaps are reported, not refused.
    ///
    /// # Errors
    /// Files that cannot be read, an SBET without its week, a capture without navigation.
    pub fn read(path: &Path, how: &Reading) -> Result<Self, InspectionError> {
        let bytes = unpacked::read(path)?;
        let encoding = how.encoding.unwrap_or_else(|| sniffed(&bytes, path));
        let source = |format| FileSource {
            path: path.to_owned(),
            format,
            datum: how.datum.unwrap_or(VerticalDatum::Ellipsoid),
            undulation_m: how.undulation_m,
            max_gap_s: f64::INFINITY,
            smoothing: Smoothing::Off,
            attitude: AttitudeSource::Level,
            first_day: how.first_day,
            bounds: MotionBounds::SPACECRAFT,
        };
        let messages = || Some(count(&unpacked::utf8(&bytes)));
        let whole = |messages, of| Self {
            encoding,
            bytes: bytes.len(),
            messages,
            capture: None,
            track: replay::parse(&bytes, &source(of)),
        };
        Ok(match encoding {
            Encoding::Csv => whole(None, FileFormat::Csv),
            Encoding::Nmea => whole(messages(), FileFormat::Nmea),
            Encoding::Inspvax => whole(messages(), FileFormat::Inspvax),
            Encoding::Gpx => whole(None, FileFormat::Gpx),
            Encoding::Kml => whole(None, FileFormat::Kml),
            Encoding::Sbet => {
                let gps_week = how.gps_week.ok_or_else(|| InspectionError::Week { path: path.to_owned() })?;
                whole(None, FileFormat::Sbet { gps_week })
            }
            Encoding::Pcap => {
                let capture = pcap::parse(&bytes)
                    .map_err(|source| InspectionError::Capture { path: path.to_owned(), source })?;
                // The stream with the most positions.
                let counted = capture.streams.into_iter().map(|stream| (count(&stream.bytes), stream));
                let best = counted.max_by_key(|((counts, _), _)| counts.good);
                let Some(((counts, kinds), stream)) = best.filter(|((counts, _), _)| counts.good > 0) else {
                    return Err(InspectionError::Silent { path: path.to_owned() });
                };
                let of = if has_novatel(&kinds) { FileFormat::Inspvax } else { FileFormat::Nmea };
                Self {
                    encoding,
                    bytes: stream.bytes.len(),
                    messages: Some((counts, kinds)),
                    capture: Some(Captured {
                        packets: capture.packets,
                        packets_left: capture.left,
                        stream: stream.name,
                        missing_bytes: stream.missing_bytes,
                    }),
                    track: replay::parse(&stream.bytes, &source(of)),
                }
            }
        })
    }
}

/// A recorded track in figures.
#[derive(Clone, Debug, Serialize)]
pub struct TrackFigures {
    /// Fixes.
    pub fixes: usize,
    /// Time of the first.
    pub first: String,
    /// Time of the last.
    pub last: String,
    /// GPS week of the first.
    pub gps_week: Option<u32>,
    /// From the first to the last, s.
    pub span_s: f64,
    /// One over the median interval.
    pub rate_hz: f64,
    /// Longest interval, s.
    pub longest_gap_s: f64,
    /// Intervals that are gaps.
    pub gaps: usize,
    /// Begin and length of the longest, at most ten.
    pub gaps_s: Vec<(String, f64)>,
    /// What was left out, filled in and set right.
    pub read: LoadReport,
    /// Least and greatest latitude, degrees.
    pub lat_deg: Option<[f64; 2]>,
    /// Least and greatest longitude, degrees.
    pub lon_deg: Option<[f64; 2]>,
    /// Least and greatest height, m.
    pub height_m: [f64; 2],
    /// Least, mean and greatest, from one fix to the next.
    pub speed_mps: [f64; 3],
    /// Fixes with a velocity.
    pub velocities: usize,
    /// Fixes with an attitude.
    pub attitudes: usize,
    /// Fixes with a stated deviation of the position.
    pub deviations: usize,
    /// Worst deviation stated, East, North, up.
    pub worst_sigma_m: Option<[f32; 3]>,
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

impl TrackFigures {
    /// Those of a recording, which has two fixes at least, in the order of their times.
    pub fn of(recording: &Recording) -> Self {
        let (read, fixes) = (&recording.report, &recording.fixes[..]);
        let (first, last) = (&fixes[0], &fixes[fixes.len() - 1]);
        let mut intervals: Vec<(usize, f64)> =
            fixes.windows(2).map(|pair| pair[1].time.since(pair[0].time)).enumerate().collect();
        let distance = |pair: &[Fix]| match (pair[0].place, pair[1].place) {
            (Place::Geodetic(a), Place::Geodetic(b)) => (b.to_ecef() - a.to_ecef()).norm(),
            (Place::Local(a), Place::Local(b)) => (b - a).norm(),
            _ => 0.0,
        };
        let speeds: Vec<f64> =
            fixes.windows(2).zip(&intervals).map(|(pair, (_, h))| distance(pair) / h).collect();
        let [slow, fast] = range(speeds.iter().copied());
        let span_s = last.time.since(first.time);
        let way_m: f64 = fixes.windows(2).map(distance).sum();
        intervals.sort_by(|a, b| a.1.total_cmp(&b.1));
        let median_s = intervals[intervals.len() / 2].1;
        let longest_gap_s = intervals[intervals.len() - 1].1;
        let is_gap = |(_, h): &&(usize, f64)| *h > GAP_INTERVALS * median_s;
        let geodetic = |get: fn(&Geodetic) -> f64| {
            let all: Option<Vec<f64>> = fixes
                .iter()
                .map(|fix| match &fix.place {
                    Place::Geodetic(place) => Some(get(place)),
                    Place::Local(_) => None,
                })
                .collect();
            all.map(|all| range(all.into_iter()))
        };
        let worst = |worst: Option<[f32; 3]>, sigma: [f32; 3]| {
            let worst = worst.unwrap_or_default();
            Some(std::array::from_fn(|i| worst[i].max(sigma[i])))
        };
        Self {
            fixes: fixes.len(),
            first: first.time.to_string(),
            last: last.time.to_string(),
            gps_week: first.time.to_gps().map(|(week, _)| week),
            span_s,
            rate_hz: median_s.recip(),
            longest_gap_s,
            gaps: intervals.iter().filter(is_gap).count(),
            gaps_s: intervals
                .iter()
                .rev()
                .filter(is_gap)
                .take(MOST_GAPS)
                .map(|(index, h)| (fixes[*index].time.to_string(), *h))
                .collect(),
            read: read.clone(),
            lat_deg: geodetic(|place| place.lat_rad.to_degrees()),
            lon_deg: geodetic(|place| place.lon_rad.to_degrees()),
            height_m: range(fixes.iter().map(|fix| match &fix.place {
                Place::Geodetic(place) => place.h_m,
                Place::Local(point) => point.to_array()[2],
            })),
            speed_mps: [slow, way_m / span_s, fast],
            velocities: fixes.iter().filter(|fix| fix.velocity_mps.is_some()).count(),
            attitudes: fixes.iter().filter(|fix| fix.yaw_pitch_roll_rad.is_some()).count(),
            deviations: fixes.iter().filter(|fix| fix.sigma.position_m.is_some()).count(),
            worst_sigma_m: fixes.iter().filter_map(|fix| fix.sigma.position_m).fold(None, worst),
        }
    }

    /// What fixes hold beside positions, in words: counts of velocities, attitudes and stated standard
    /// deviations.
    pub fn contents(&self) -> String {
        let counts = [self.velocities, self.attitudes, self.deviations];
        if counts == [0; 3] {
            return "no velocities, attitudes or standard deviations".to_owned();
        }
        let rows = counts.into_iter().zip(["velocities", "attitudes", "standard deviations"]);
        let text = |(count, what)| match count {
            0 => format!("no {what}"),
            _ => format!("{count} {what}"),
        };
        rows.map(text).collect::<Vec<_>>().join(", ")
    }
}
