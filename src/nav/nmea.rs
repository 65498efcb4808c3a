//! NMEA 0183 logs.
//!
//! Positions come from GGA, RMC and GLL, dates from RMC and ZDA, heights from GGA, headings from HDT and
//! the whole attitude from PASHR; sentences of one epoch (the same time of day) become one [`Fix`], GGA
//! before RMC before GLL. A sentence may have anything before its `$` on the line (a logger's time
//! stamp). Sentences with a wrong checksum, without one, of other kinds, void or unreadable are
//! skipped, counted in the [`LoadReport`] and never an error by themselves; a log that
//! gives no usable fix at all is one, with the reason.
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
//! * **Attitude.** HDT has no time and belongs to the epoch that is open when it comes; alone it gives yaw,
//!   with pitch and roll zero. Fixes without a heading get one interpolated (the short way round; held at the
//!   ends) and are counted as `headings_filled`. VTG and the course of RMC say where the platform goes, not
//!   where it looks, and are not used.
//!
//! Resolution: a position of `ddmm.mmm` is quantised to 1.9 m, which used as truth without smoothing means
//! accelerations of metres per second squared.
//!
//! Sentences are read by [`decode`](super::decode), joined by [`epoch`](super::epoch) and completed by
//! [`completion`](super::completion), as those of a live receiver are. Logs of NovAtel receivers in between
//! are read too, see [`inspvax`](super::inspvax) for files of them alone.
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

use super::completion::{Completer, Reported};
use super::decode::{Content, Decoder, Message};
use super::epoch::Assembler;
use super::faults::{FaultKind, Faults, NavError, NoFix};
use super::recording;
use super::{FileSource, Fix};
use crate::nav::load_report::LoadReport;
use crate::nav::recording::{MAX_FIXES, Recording};

/// Bytes that are handed to the decoder at once.
const PIECE_BYTES: usize = 1 << 20;

/// What is made of the messages of a log.
struct Reading<'a> {
    source: &'a FileSource,
    assembler: Assembler,
    completer: Completer,
    epochs: usize,
    /// Messages of which nothing is used.
    unused: u64,
    fixes: Vec<Fix>,
    faults: Faults,
}

/// Reads fixes from the bytes of an NMEA log.
///
/// # Errors
/// All faults of the file, each with its line.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let mut decoder = Decoder::new();
    let mut reading = Reading {
        source,
        assembler: Assembler::new(),
        completer: Completer::for_file(source.datum, source.undulation_m),
        epochs: 0,
        unused: 0,
        fixes: Vec::new(),
        faults: Faults::default(),
    };
    // Whole pieces, so that a log of too many fixes need not be read to its end.
    for piece in bytes.chunks(PIECE_BYTES) {
        decoder.push(piece, &mut |message| reading.take(&message));
        if reading.epochs > MAX_FIXES {
            break;
        }
    }
    decoder.finish(&mut |message| reading.take(&message));
    reading.end();
    let Reading { completer, epochs, unused, fixes, mut faults, .. } = reading;
    let (counts, completed) = (decoder.counts(), completer.counts());
    let report = LoadReport {
        path: source.path.display().to_string(),
        lines: counts.lines,
        bad_checksum: counts.bad_checksum,
        unknown_sentences: counts.unknown + unused,
        malformed: counts.malformed,
        void_positions: counts.void,
        out_of_order: completed.out_of_order,
        heights_filled: completed.heights_filled,
        headings_filled: completed.headings_filled,
        ..LoadReport::default()
    };
    let reason = if counts.good + counts.unknown == 0 {
        Some(NoFix::NoSentence)
    } else if !completer.is_located() {
        Some(NoFix::NoPosition)
    } else if !completer.is_dated() {
        Some(NoFix::NoDate)
    } else {
        None
    };
    if let Some(reason) = reason {
        let report = Box::new(report);
        return Err(NavError::NoFix { path: source.path.clone(), reason, report });
    }
    if epochs > MAX_FIXES {
        faults.push(report.lines, FaultKind::TooManyFixes { allowed: MAX_FIXES });
    }
    recording::finish(fixes, report, faults, source)
}

impl Reading<'_> {
    fn take(&mut self, message: &Message) {
        self.unused += u64::from(matches!(message.content, Content::Vtg(_) | Content::Gst(_)));
        let Self { source, assembler, completer, epochs, fixes, faults, .. } = self;
        assembler.push(message, &mut |epoch| {
            *epochs += 1;
            completer.push(epoch, &mut |reported| note(reported, source, fixes, faults));
        });
    }

    fn end(&mut self) {
        let Self { source, assembler, completer, epochs, fixes, faults, .. } = self;
        let mut see = |reported| note(reported, source, fixes, faults);
        if let Some(epoch) = assembler.finish() {
            *epochs += 1;
            completer.push(epoch, &mut see);
        }
        completer.finish(&mut see);
    }
}

/// Keeps a fix; notes what is wrong between an epoch and the one before it.
fn note(reported: Reported, source: &FileSource, fixes: &mut Vec<Fix>, faults: &mut Faults) {
    match reported {
        Reported::Fix(fix) => fixes.push(fix),
        Reported::Follows { line, time, before } => {
            let gap_s = time.since(before);
            if gap_s > source.max_gap_s {
                faults.push(line, FaultKind::gap(time, gap_s, source.max_gap_s));
            }
        }
        Reported::StepsBack { line, time, before } => {
            faults.push(line, FaultKind::TimeOrder { time, before })
        }
    }
}
