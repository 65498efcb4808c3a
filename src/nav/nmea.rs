//! NMEA 0183 logs.
//!
//! Positions come from GGA, RMC and GLL, dates from RMC and ZDA, heights from GGA, headings from HDT and
//! the whole attitude from PASHR; sentences of one epoch (the same time of day) become one [`Fix`](super::Fix), GGA
//! before RMC before GLL. A sentence may have anything before its `$` on the line (a logger's time
//! stamp). Sentences with a wrong checksum, without one, of other kinds, void or unreadable are
//! skipped, counted in the [`LoadReport`] and never an error by themselves; a log that
//! gives no usable fix at all is one, and says why.
//!
//! * **Date.** An epoch without a date of its own takes that of its neighbours: where the time of day falls
//!   by more than half a day, midnight has passed. Epochs before the first date are dated backwards.
//! * **Order.** An epoch up to 5 s earlier than one already seen (two talkers with different delays) is
//!   skipped and counted; a larger step back is a fault of the file.
//! * **Height** above the ellipsoid: altitude of GGA plus geoid separation of the same sentence; where it
//!   gives no separation, the datum of the source decides: `Ellipsoid` takes it as it is, `MeanSeaLevel`
//!   adds `undulation_m`, `Barometric` adds `offset_m` and `undulation_m`. A fix without an altitude gets
//!   one interpolated between those beside it (held at the ends); a log without any altitude is taken to
//!   be at mean sea level, `undulation_m`. Both are counted as `heights_filled`.
//! * **Attitude.** HDT has no time and belongs to the epoch that is open when it comes; alone it gives yaw, with
//!   pitch and roll zero. Fixes without a heading get one
//!   interpolated (the short way round; held at the ends) and are counted as `headings_filled`.
//!   VTG and the course of RMC say where the platform goes, not where it looks, and are not used.
//!
//! Resolution: a position of `ddmm.mmm` is quantised to 1.9 m, which used as truth without smoothing means
//! accelerations of metres per second squared.
//!
//! Sentences are read by [`decode`](super::decode) and joined by [`epoch`](super::epoch), as those of a live receiver are.
//! Logs of NovAtel receivers in between are read too, see [`inspvax`](super::inspvax) for files of them alone.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, nmea};
//!
//! let source = FileSource {
//!     path: "ship.nmea".into(),
//!     format: FileFormat::Nmea,
//!     datum: VerticalDatum::MeanSeaLevel,
//!     undulation_m: 41.0,
//!     max_gap_s: 5.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Level,
//! };
//! let log = "$GPRMC,195719,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*10\r\n\
//!            $GPRMC,195720,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*1B\r\n";
//! let error = nmea::parse(log.as_bytes(), &source).unwrap_err();
//! // The second checksum is wrong: one fix is left, and a track needs two.
//! assert!(error.to_string().contains("usable fixes: 1, needed: at least 2"));
//! ```

use super::decode::{Content, Decoder};
use super::epoch::{Assembler, DAY_NS, Epoch};
use super::faults::{Faults, NavError, NoFix};
use super::replay::{self, LoadReport, MAX_FIXES, Recording};
use super::{FaultKind, FileSource};
use crate::time::TimeTag;

/// Bytes that are handed to the decoder at once.
const PIECE_BYTES: usize = 1 << 20;
/// The step back that two talkers with different delays may cause, s.
const DISORDER_S: f64 = 5.0;

/// Reads fixes from the bytes of an NMEA log.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let (mut decoder, mut assembler) = (Decoder::new(), Assembler::new());
    let mut epochs: Vec<Epoch> = Vec::new();
    // Whole pieces, so that a log of too many fixes need not be read to its end.
    let mut unused = 0;
    for piece in bytes.chunks(PIECE_BYTES) {
        decoder.push(piece, &mut |message| {
            unused += u64::from(matches!(message.content, Content::Vtg(_) | Content::Gst(_)));
            assembler.push(&message, &mut |epoch| epochs.push(epoch));
        });
        if epochs.len() > MAX_FIXES {
            break;
        }
    }
    decoder.finish(&mut |message| {
        unused += u64::from(matches!(message.content, Content::Vtg(_) | Content::Gst(_)));
        assembler.push(&message, &mut |epoch| epochs.push(epoch));
    });
    epochs.extend(assembler.finish());
    let counts = decoder.counts();
    let report = LoadReport {
        path: source.path.display().to_string(),
        lines: counts.lines,
        bad_checksum: counts.bad_checksum,
        unknown_sentences: counts.unknown + unused,
        malformed: counts.malformed,
        void_positions: counts.void,
        ..LoadReport::default()
    };
    finish(epochs, report, counts.good + counts.unknown, source)
}

fn finish(
    mut epochs: Vec<Epoch>,
    mut report: LoadReport,
    sentences: u64,
    source: &FileSource,
) -> Result<Recording, NavError> {
    let located = epochs.iter().any(|epoch| epoch.position_deg.is_some());
    let reason = if sentences == 0 {
        Some(NoFix::NoSentence)
    } else if !located {
        Some(NoFix::NoPosition)
    } else if !date_first(&mut epochs) {
        Some(NoFix::NoDate)
    } else {
        None
    };
    if let Some(reason) = reason {
        let report = Box::new(report);
        return Err(NavError::NoFix { path: source.path.clone(), reason, report });
    }

    let mut faults = Faults::default();
    if epochs.len() > MAX_FIXES {
        faults.push(report.lines, FaultKind::TooManyFixes { allowed: MAX_FIXES });
    }
    let mut kept: Vec<(TimeTag, Epoch)> = Vec::with_capacity(epochs.len());
    for mut epoch in epochs {
        let (Some(time), Some(_)) = (epoch.time(), epoch.position_deg) else { continue };
        let step_s = kept.last().map_or(f64::INFINITY, |(before, _)| time.since(*before));
        if (-DISORDER_S..=0.0).contains(&step_s) {
            report.out_of_order += 1;
            continue;
        }
        // From here on heights are above the ellipsoid.
        epoch.altitude_m =
            epoch.height_m(source.datum, source.undulation_m).filter(|height| height.abs() < 1e8);
        epoch.separation_m = Some(0.0);
        kept.push((time, epoch));
    }
    report.heights_filled = fill_heights(&mut kept, source.undulation_m);
    report.headings_filled = fill_attitudes(&mut kept);

    let mut fixes = Vec::with_capacity(kept.len());
    for (_, epoch) in kept {
        let Some(fix) = epoch.fix(source.datum, source.undulation_m) else { continue };
        if replay::follows(&fixes, &fix, epoch.line, source, &mut faults) {
            fixes.push(fix);
        }
    }
    replay::finish(fixes, report, faults, source)
}

/// Gives a day to the epochs before the first that has one; false if none has. Those after it have been given theirs.
fn date_first(epochs: &mut [Epoch]) -> bool {
    let Some(first) = epochs.iter().position(|epoch| epoch.day.is_some()) else { return false };
    for index in (0..first).rev() {
        let (later_day, later_ns) = (epochs[index + 1].day, epochs[index + 1].time_of_day_ns);
        let passed = epochs[index].time_of_day_ns - later_ns > DAY_NS / 2;
        epochs[index].day = later_day.map(|day| day - i64::from(passed));
    }
    true
}

/// Gives a height to those that have none; how many.
fn fill_heights(kept: &mut [(TimeTag, Epoch)], sea_level_m: f64) -> u64 {
    fill(
        kept,
        |epoch| epoch.altitude_m,
        |a, b, s| a + (b - a) * s,
        |epoch, height| {
            epoch.altitude_m = Some(height.unwrap_or(sea_level_m));
        },
    )
}

/// Gives an attitude to those that have none, if any has one; how many.
fn fill_attitudes(kept: &mut [(TimeTag, Epoch)]) -> u64 {
    if kept.iter().all(|(_, epoch)| epoch.yaw_pitch_roll_rad.is_none()) {
        return 0;
    }
    let short_way = |a: f64, b: f64| {
        let turn = (b - a).rem_euclid(std::f64::consts::TAU);
        if turn > std::f64::consts::PI { turn - std::f64::consts::TAU } else { turn }
    };
    let between =
        |a: [f64; 3], b: [f64; 3], s: f64| std::array::from_fn(|i| a[i] + short_way(a[i], b[i]) * s);
    fill(kept, |epoch| epoch.yaw_pitch_roll_rad, between, |epoch, angles| epoch.yaw_pitch_roll_rad = angles)
}

/// Fills what is missing from the nearest on either side; how many were missing.
fn fill<T: Copy>(
    kept: &mut [(TimeTag, Epoch)],
    get: impl Fn(&Epoch) -> Option<T>,
    between: impl Fn(T, T, f64) -> T,
    set: impl Fn(&mut Epoch, Option<T>),
) -> u64 {
    let mut missing = 0;
    let mut before: Option<(TimeTag, T)> = None;
    let mut index = 0;
    while index < kept.len() {
        if let Some(value) = get(&kept[index].1) {
            before = Some((kept[index].0, value));
            index += 1;
            continue;
        }
        let end = (index..kept.len()).find(|&i| get(&kept[i].1).is_some());
        let after = end.and_then(|i| Some((kept[i].0, get(&kept[i].1)?)));
        let end = end.unwrap_or(kept.len());
        for (time, epoch) in &mut kept[index..end] {
            let value = match (before, after) {
                (Some((t0, a)), Some((t1, b))) => Some(between(a, b, time.since(t0) / t1.since(t0))),
                (Some((_, held)), None) | (None, Some((_, held))) => Some(held),
                (None, None) => None,
            };
            set(epoch, value);
            missing += 1;
        }
        index = end;
    }
    missing
}
