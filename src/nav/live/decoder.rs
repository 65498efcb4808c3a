//! Bytes of a receiver become fixes.
//!
//! The decoder, the assembler and the completer that read files, one behind the other. What is reported
//! depends on the bytes alone, not on how they were cut nor on when they came: an epoch of sentences is
//! complete when the next one begins, and a pause does not close it, because a sentence behind the pause
//! could still belong to it. INSPVAX is complete by itself.
//!
//! Where the attitude of a source is not that of its messages, headings are passed on as they came, and
//! none is waited for.
//!
//! ```
//! use nereus::nav::live::FixDecoder;
//! use nereus::nav::{AttitudeSource, VerticalDatum};
//!
//! let mut decoder = FixDecoder::new(VerticalDatum::MeanSeaLevel, 43.0, AttitudeSource::Level, 5.0);
//! let mut fixes = Vec::new();
//! decoder.push(b"$GPRMC,195719,A,5310.8115,N,00525.7025,E,0.0,0.0,160414,0.7,E,A*10\r\n$GPGGA,195719,53", &mut |fix| fixes.push(fix));
//! decoder.push(b"10.8115,N,00525.7025,E,8,10,0.9,-2.0,M,43.0,M,,*61\r\n", &mut |fix| fixes.push(fix));
//! assert!(fixes.is_empty());
//! decoder.finish(&mut |fix| fixes.push(fix));
//! assert_eq!(fixes[0].time.to_string(), "2014-04-16T19:57:19.000000Z");
//! ```

use crate::nav::completion::{Completer, CompletionCounts, Reported};
use crate::nav::decode::{Counts, Decoder};
use crate::nav::epoch::{Assembler, AssemblyCounts};
use crate::nav::{AttitudeSource, Fix, VerticalDatum};

/// Makes fixes of bytes.
#[derive(Clone, Debug)]
pub struct FixDecoder {
    decoder: Decoder,
    assembler: Assembler,
    completer: Completer,
}

impl FixDecoder {
    /// A decoder that has read nothing. A fix waits for what it lacks for `max_gap_s` of its own time at
    /// most.
    pub fn new(datum: VerticalDatum, undulation_m: f64, attitude: AttitudeSource, max_gap_s: f64) -> Self {
        let headings = matches!(attitude, AttitudeSource::Recorded | AttitudeSource::Automatic);
        Self {
            decoder: Decoder::new(),
            assembler: Assembler::new(),
            completer: Completer::for_stream(datum, undulation_m, max_gap_s, headings),
        }
    }

    /// The same, where the first fix is of a day (since 1970-01-01), whatever the messages say.
    pub fn dated(mut self, first_day: Option<i64>) -> Self {
        self.assembler = Assembler::dated(first_day);
        self
    }

    /// Takes the next bytes and calls with the fixes that they complete, in the order of their times.
    pub fn push(&mut self, bytes: &[u8], see: &mut impl FnMut(Fix)) {
        let Self { decoder, assembler, completer } = self;
        decoder.push(bytes, &mut |message| {
            assembler.push(&message, &mut |epoch| completer.push(epoch, &mut |reported| fix(reported, see)));
        });
    }

    /// The line is broken: half a message is dropped, a last line needs no line end. What is not yet complete
    /// waits on.
    pub fn interrupt(&mut self, see: &mut impl FnMut(Fix)) {
        let Self { decoder, assembler, completer } = self;
        decoder.finish(&mut |message| {
            assembler.push(&message, &mut |epoch| completer.push(epoch, &mut |reported| fix(reported, see)));
        });
    }

    /// Nothing more will come: what waits is completed as at the end of a file.
    pub fn finish(&mut self, see: &mut impl FnMut(Fix)) {
        self.interrupt(see);
        let Self { assembler, completer, .. } = self;
        if let Some(epoch) = assembler.finish() {
            completer.push(epoch, &mut |reported| fix(reported, see));
        }
        completer.finish(&mut |reported| fix(reported, see));
    }

    /// What was found among the bytes.
    pub fn messages(&self) -> &Counts {
        self.decoder.counts()
    }

    /// What was left and set right among the messages of an epoch.
    pub fn assembly(&self) -> AssemblyCounts {
        self.assembler.counts()
    }

    /// What was left and filled in.
    pub fn completion(&self) -> CompletionCounts {
        self.completer.counts()
    }
}

fn fix(reported: Reported, see: &mut impl FnMut(Fix)) {
    if let Reported::Fix(fix) = reported {
        see(fix);
    }
}
