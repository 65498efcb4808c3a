//! `nereus nav inspect`

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::SourceArgs;
use super::block::block;
use super::recorded::{KINDS, Recorded};
use crate::cli::error::CliError;
use crate::cli::escape::name;
use crate::cli::json;
use crate::nav::decode::Counts;
use crate::nav::{Fix, Place};

/// An interval is a gap when it is longer than so many of the usual ones.
const GAP_INTERVALS: f64 = 1.5;
/// Gaps that are listed.
const GAPS_TOLD: usize = 10;

/// `nereus nav inspect`
#[derive(Debug, Args)]
pub struct NavInspectArgs {
    /// The recording
    pub file: PathBuf,
    /// How it is read
    #[command(flatten)]
    pub source: SourceArgs,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    file: String,
    format: String,
    bytes: usize,
    capture: Option<Captured>,
    messages: Option<Counts>,
    kinds: Vec<(&'static str, u64)>,
    track: Option<TrackReport>,
    /// The track of a scenario that takes the recording.
    scenario: Option<String>,
    /// Why there is no track.
    error: Option<String>,
}

#[derive(Debug, Serialize)]
struct Captured {
    packets: u64,
    packets_left: u64,
    stream: String,
    missing_bytes: u64,
}

#[derive(Debug, Serialize)]
struct TrackReport {
    fixes: usize,
    first: String,
    last: String,
    gps_week: Option<u32>,
    span_s: f64,
    /// One over the median interval.
    rate_hz: f64,
    longest_gap_s: f64,
    gaps: usize,
    /// Begin and length of the longest, at most ten.
    gaps_s: Vec<(String, f64)>,
    out_of_order: u64,
    heights_filled: u64,
    headings_filled: u64,
    lat_deg: Option<[f64; 2]>,
    lon_deg: Option<[f64; 2]>,
    height_m: [f64; 2],
    /// Least, mean and greatest, from one fix to the next.
    speed_mps: [f64; 3],
    /// Fixes with a velocity, an attitude, a stated deviation of the position.
    velocities: usize,
    attitudes: usize,
    deviations: usize,
    /// Worst deviation stated, East, North, up.
    worst_sigma_m: Option<[f32; 3]>,
}

/// Tells what a recording holds.
pub(super) fn inspect(args: &NavInspectArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let recorded = Recorded::read(&args.file, &args.source)?;
    let (track, error) = match recorded.track {
        Ok(recording) => (Some((recording.report, recording.fixes)), None),
        Err(error) => (None, Some(error.to_string())),
    };
    let scenario =
        track.as_ref().and_then(|(_, fixes)| block(&args.file, recorded.format, &args.source, fixes));
    let report = Report {
        scenario,
        file: args.file.display().to_string(),
        format: format!("{:?}", recorded.format).to_lowercase(),
        bytes: recorded.bytes,
        capture: recorded.capture.map(|(packets, packets_left, stream, missing_bytes)| Captured {
            packets,
            packets_left,
            stream,
            missing_bytes,
        }),
        messages: recorded.messages.map(|(counts, _)| counts),
        kinds: recorded
            .messages
            .map(|(_, kinds)| KINDS.into_iter().zip(kinds).filter(|(_, count)| *count > 0).collect())
            .unwrap_or_default(),
        track: track.map(|(read, fixes)| TrackReport {
            out_of_order: read.out_of_order,
            heights_filled: read.heights_filled,
            headings_filled: read.headings_filled,
            ..TrackReport::of(&fixes)
        }),
        error,
    };
    let text = if args.json { json::json(&report)? + "\n" } else { report.text() };
    out.write_all(text.as_bytes()).map_err(CliError::Output)
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

impl TrackReport {
    /// Of two fixes at least, in the order of their times.
    fn of(fixes: &[Fix]) -> Self {
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
        let geodetic = |get: fn(&crate::frames::Geodetic) -> f64| {
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
                .take(GAPS_TOLD)
                .map(|(index, h)| (fixes[*index].time.to_string(), *h))
                .collect(),
            out_of_order: 0,
            heights_filled: 0,
            headings_filled: 0,
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
}

/// What fixes hold beside positions: counts of velocities, attitudes and stated standard deviations.
fn contents(counts: [usize; 3]) -> String {
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

impl Report {
    fn text(&self) -> String {
        let mut rows: Vec<(&str, String)> = vec![
            ("file", name(&self.file).into_owned()),
            ("format", format!("{}, {} bytes", self.format, self.bytes)),
        ];
        if let Some(capture) = &self.capture {
            let Captured { packets, packets_left, stream, missing_bytes } = capture;
            rows.push((
                "capture",
                format!("{packets} packets, {packets_left} left; {stream}, {missing_bytes} bytes missing"),
            ));
        }
        if let Some(counts) = &self.messages {
            let Counts { good, bad_checksum, unknown, malformed, void, .. } = counts;
            rows.push((
                "messages",
                format!(
                    "{good} good ({void} void), {bad_checksum} with a wrong checksum, {unknown} of other kinds, \
                     {malformed} malformed"
                ),
            ));
            let kinds: Vec<String> =
                self.kinds.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            rows.push(("kinds", kinds.join(", ")));
        }
        if let Some(track) = &self.track {
            let week = track.gps_week.map_or(String::new(), |week| format!(" (GPS week {week})"));
            rows.push(("fixes", track.fixes.to_string()));
            rows.push(("time", format!("{} to {}{week}", track.first, track.last)));
            rows.push(("span", format!("{:.3} s, {:.3} a second", track.span_s, track.rate_hz)));
            rows.push(("gaps", format!("{}, longest interval {:.3} s", track.gaps, track.longest_gap_s)));
            for (begin, length_s) in &track.gaps_s {
                rows.push(("", format!("{length_s:.3} s after {begin}")));
            }
            if let (Some([south, north]), Some([west, east])) = (track.lat_deg, track.lon_deg) {
                rows.push(("area", format!("{south:.6} .. {north:.6} deg N, {west:.6} .. {east:.6} deg E")));
            }
            rows.push(("height", format!("{:.2} .. {:.2} m", track.height_m[0], track.height_m[1])));
            let [slow, mean, fast] = track.speed_mps;
            rows.push(("speed", format!("{slow:.2} .. {fast:.2} m/s, mean {mean:.2}")));
            rows.push(("contains", contents([track.velocities, track.attitudes, track.deviations])));
            if let Some([east, north, up]) = track.worst_sigma_m {
                rows.push(("worst", format!("{east:.3} m East, {north:.3} m North, {up:.3} m up")));
            }
            for (count, what) in [
                (track.out_of_order, "out of order"),
                (track.heights_filled, "heights filled in"),
                (track.headings_filled, "headings filled in"),
            ] {
                if count > 0 {
                    rows.push(("", format!("{count} {what}")));
                }
            }
        }
        if let Some(error) = &self.error {
            rows.push(("no track", error.clone()));
        }
        let mut text: String = rows.into_iter().map(|(name, text)| format!("{name:9} {text}\n")).collect();
        if let Some(block) = &self.scenario {
            // On a line of its own, to be copied.
            text += &format!("scenario  under [[platform]], its path relative to the scenario:\n{block}\n");
        }
        text
    }
}
