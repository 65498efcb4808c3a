//! NMEA 0183 logs.
//!
//! Positions come from GGA, GNS, RMC and GLL, dates from RMC and ZDA, heights from GGA and GNS, headings from
//! HDT and THS, the whole attitude from PASHR; sentences of one epoch (the same time of day) become one
//! [`Fix`](super::Fix), see [`epoch`](super::epoch). A sentence may have anything before its `$` on the line
//! (a logger's time stamp). Sentences with a wrong checksum, without one, of other kinds, void or unreadable
//! are skipped, counted in the [`LoadReport`] and never an error by themselves; a log that gives no usable
//! fix at all is one, with the reason.
//!
//! * **Date.** An epoch without a date of its own takes that of its neighbours: where the time of day falls
//!   by more than half a day, midnight has passed. Epochs before the first date are dated backwards. A log
//!   without any date takes that of its first fix from the source.
//! * **Order.** An epoch up to 5 s earlier than one already seen (two talkers with different delays) is
//!   skipped and counted. Behind larger steps of the clock, and steps that stay, the longest stretch is kept,
//!   the rest counted ([`stretches`](super::stretches)).
//! * **Height** above the ellipsoid: altitude of GGA plus geoid separation of the same sentence; where it
//!   gives no separation, the datum of the source decides: `Ellipsoid` takes it as it is, `MeanSeaLevel`
//!   adds `undulation_m`, `Barometric` adds `offset_m` and `undulation_m`. A fix without an altitude gets
//!   one interpolated between those beside it (held at the ends); a log without any altitude is taken to
//!   be at mean sea level, `undulation_m`. Both are counted as `heights_filled`.
//! * **Attitude.** HDT and THS have no time; alone they give yaw, with pitch and roll zero. Fixes without a
//!   heading get one interpolated (the short way round; held at the ends) and are counted as
//!   `headings_filled`. VTG and the course of RMC say where the platform goes, not where it looks, and are
//!   not used.
//!
//! Resolution: a position of `ddmm.mmm` is quantised to 1.9 m, which used as truth without smoothing means
//! accelerations of metres per second squared.
//!
//! Sentences are read by [`decode`](super::decode), joined by [`epoch`](super::epoch) and completed by
//! [`completion`](super::completion), as those of a live receiver are. Logs of NovAtel receivers in between
//! are read too, by [`novatel`](super::decode::novatel).
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, MotionBounds, Smoothing, VerticalDatum, nmea};
//!
//! let source = FileSource {
//!     path: "ship.nmea".into(),
//!     format: FileFormat::Nmea,
//!     datum: VerticalDatum::MeanSeaLevel,
//!     undulation_m: 41.0,
//!     max_gap_s: 5.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Level,
//!     first_day: None,
//!     bounds: MotionBounds::SPACECRAFT,
//! };
//! let log = "$GPRMC,195719,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*10\r\n\
//!            $GPRMC,195720,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*1B\r\n";
//! let error = nmea::parse(log.as_bytes(), &source).unwrap_err();
//! // The second checksum is wrong: one fix is left, and a track needs two.
//! assert!(error.to_string().contains("usable fixes: 1, needed: at least 2"));
//! ```

use super::completion::date_backwards;
use super::decode::{Content, Counts, Decoder, Message};
use super::epoch::{Assembler, Epoch};
use super::faults::{Faults, NavError, NoFix};
use super::{FileFormat, FileSource, VerticalDatum, recording};
use crate::nav::load_report::LoadReport;
use crate::nav::recording::{MAX_FIXES, Recording};

/// Bytes that are handed to the decoder at once.
const PIECE_BYTES: usize = 1 << 20;

/// Epochs of a log.
struct Reading {
    assembler: Assembler,
    /// Of files of INSPVAX: its messages alone count.
    only_novatel: bool,
    /// Messages of NovAtel, and those among them without a solution.
    novatel: [u64; 2],
    epochs: Vec<Epoch>,
    is_located: bool,
    is_dated: bool,
}

/// Reads fixes from the bytes of an NMEA log, or of a log of a NovAtel receiver.
///
/// # Errors
/// All faults of the file, each with its line.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let only_novatel = source.format == FileFormat::Inspvax;
    let mut decoder = Decoder::new();
    let mut reading = Reading {
        assembler: Assembler::dated(source.first_day.filter(|_| !only_novatel)),
        only_novatel,
        novatel: [0; 2],
        epochs: Vec::new(),
        is_located: false,
        is_dated: false,
    };
    // Whole pieces, so that a log of too many fixes need not be read to its end.
    for piece in bytes.chunks(PIECE_BYTES) {
        decoder.push(piece, &mut |message| reading.take(message));
        if reading.epochs.len() > MAX_FIXES {
            break;
        }
    }
    decoder.finish(&mut |message| reading.take(message));
    let last = reading.assembler.finish();
    reading.keep(last);
    let counts = decoder.counts();
    if let Some(reason) = reading.no_fix(counts) {
        let mut report = Box::new(reading.report(source, counts));
        if !counts.others.is_empty() {
            report.hints.push(format!("found: {}", counts.others));
        }
        return Err(NavError::NoFix { path: source.path.clone(), reason, report });
    }
    let report = reading.report(source, counts);
    let datum = if only_novatel { VerticalDatum::Ellipsoid } else { source.datum };
    recording::of_epochs(reading.epochs, report, Faults::default(), datum, source)
}

impl Reading {
    fn take(&mut self, mut message: Message) {
        let is_novatel = matches!(message.content, Content::Inspvax(_) | Content::Inspva(_));
        if is_novatel {
            self.novatel[0] += 1;
            self.novatel[1] += u64::from(message.content.is_void());
        }
        if self.only_novatel {
            if !is_novatel {
                return;
            }
            // Binary messages stand on no line.
            message.line = self.novatel[0];
        }
        let mut assembler = self.assembler;
        assembler.push(&message, &mut |epoch| self.keep(Some(epoch)));
        self.assembler = assembler;
    }

    /// Keeps an epoch with a position, once there is a date.
    fn keep(&mut self, epoch: Option<Epoch>) {
        let Some(epoch) = epoch else { return };
        if epoch.day.is_some() && !self.is_dated {
            self.is_dated = true;
            date_backwards(self.epochs.iter_mut().rev(), &epoch);
        }
        if epoch.position_deg.is_some() {
            self.is_located = true;
            self.epochs.push(epoch);
        }
    }

    /// Why there is no fix, if there is none.
    fn no_fix(&self, counts: &Counts) -> Option<NoFix> {
        if self.only_novatel {
            return (self.novatel[0] == self.novatel[1]).then_some(NoFix::NoInspvax);
        }
        if counts.good + counts.unknown == 0 {
            return Some(NoFix::NoSentence);
        }
        match (self.is_located, self.is_dated) {
            (false, _) => Some(NoFix::NoPosition),
            (true, false) => Some(NoFix::NoDate),
            (true, true) => None,
        }
    }

    fn report(&self, source: &FileSource, counts: &Counts) -> LoadReport {
        let assembled = self.assembler.counts();
        let mut hints = Vec::new();
        if counts.abbreviated > 0 {
            hints.push(format!(
                "{} lines of abbreviated ASCII logs (<NAME ...) have no checksum and are not read: log INSPVAXA or INSPVAXB",
                counts.abbreviated
            ));
        }
        if assembled.behind_leap > 0 {
            let behind = assembled.behind_leap;
            hints.push(format!("a leap second lies within: the times of {behind} fixes behind it are counted on, 1 s ahead of UTC"));
        }
        LoadReport {
            path: source.path.display().to_string(),
            lines: if self.only_novatel { self.novatel[0] } else { counts.lines },
            bad_checksum: counts.bad_checksum,
            unknown_sentences: counts.unknown,
            malformed: counts.malformed,
            void_positions: if self.only_novatel { self.novatel[1] } else { counts.void },
            other_talkers: assembled.other_talkers,
            repeated_times: assembled.repeated,
            dates_corrected: assembled.dates_corrected,
            headings_ahead: assembled.ahead,
            hints,
            ..LoadReport::default()
        }
    }
}
