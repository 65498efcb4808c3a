//! Logs of NovAtel receivers: INSPVAX, ASCII or binary.
//!
//! Which of the two is found message by message ([`decode`](super::decode)); other messages, NMEA sentences
//! too, may stand between. Position, attitude and GPS time are those of the message; its height above mean
//! sea level plus its undulation is the height above the ellipsoid, so the source needs no datum. Messages
//! with a wrong checksum, or that say of themselves that there is no solution, are skipped and counted.
//! Faults name the message, counted from 1, instead of a line.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, inspvax};
//!
//! let source = FileSource {
//!     path: "flight.gps".into(),
//!     format: FileFormat::Inspvax,
//!     datum: VerticalDatum::Ellipsoid,
//!     undulation_m: 0.0,
//!     max_gap_s: 1.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Recorded,
//! };
//! let error = inspvax::parse(b"$GPHDT,274.5,T*37\r\n", &source).unwrap_err();
//! assert!(error.to_string().contains("no INSPVAX message has a right checksum and a solution"));
//! ```

use super::decode::{Content, Decoder};
use super::epoch::Assembler;
use super::faults::{FaultKind, Faults, NavError, NoFix};
use super::recording;
use super::{FileSource, Fix, VerticalDatum};
use crate::nav::load_report::LoadReport;
use crate::nav::recording::{MAX_FIXES, Recording};

/// Reads fixes from the bytes of a log.
///
/// # Errors
/// All faults of the file, each with its place.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    let (mut decoder, mut assembler) = (Decoder::new(), Assembler::new());
    let (mut fixes, mut faults): (Vec<Fix>, Faults) = Default::default();
    let (mut messages, mut void, mut others) = (0u64, 0, 0);
    let mut too_many = false;
    let mut see = |message: super::decode::Message| {
        let Content::Inspvax(_) = message.content else {
            others += 1;
            return;
        };
        messages += 1;
        if message.content.is_void() {
            void += 1;
            return;
        }
        if fixes.len() >= MAX_FIXES {
            if !too_many {
                faults.push(messages, FaultKind::TooManyFixes { allowed: MAX_FIXES });
            }
            too_many = true;
            return;
        }
        assembler.push(&message, &mut |epoch| {
            if let Some(fix) = epoch.fix(VerticalDatum::Ellipsoid, 0.0)
                && recording::follows(&fixes, &fix, messages, source, &mut faults)
            {
                fixes.push(fix);
            }
        });
    };
    decoder.push(bytes, &mut see);
    decoder.finish(&mut see);
    let counts = decoder.counts();
    let report = LoadReport {
        path: source.path.display().to_string(),
        lines: messages,
        bad_checksum: counts.bad_checksum,
        unknown_sentences: counts.unknown + others,
        malformed: counts.malformed,
        void_positions: void,
        ..LoadReport::default()
    };
    if fixes.is_empty() {
        let report = Box::new(report);
        return Err(NavError::NoFix { path: source.path.clone(), reason: NoFix::NoInspvax, report });
    }
    recording::finish(fixes, report, faults, source)
}
