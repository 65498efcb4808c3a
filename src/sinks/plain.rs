//! A recording as a folder of plain files ([`crate::recording::plain`]), for machines without HDF5.

use std::path::Path;
use std::time::Instant;

use super::sink::{Closed, FLUSH_INTERVAL, Sink, SinkError, SinkReport};
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::recording::plain::recognise;
use crate::recording::plain::writer::Writer;

/// A folder of plain files.
#[derive(Debug)]
pub struct PlainSink {
    writer: Writer,
    force: bool,
    pulses: u64,
    flushed: Instant,
}

impl PlainSink {
    /// Makes the folder; nothing is left of it when that fails.
    ///
    /// # Errors
    /// A header that cannot be recorded, what is there already, and what the system refuses.
    pub fn create(path: &Path, force: bool, header: &Header) -> Result<Self, SinkError> {
        let writer = Writer::create(path, force, header)?;
        Ok(Self { writer, force, pulses: 0, flushed: Instant::now() })
    }
}

impl Sink for PlainSink {
    fn name(&self) -> &'static str {
        "plain"
    }

    fn describe(&self) -> String {
        format!("plain recording {}", self.writer.target().display())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        self.writer.push(pulse)?;
        self.pulses += 1;
        if self.writer.is_full() || self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.writer.flush()?;
        self.flushed = Instant::now();
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        let drafts = self.writer.close()?.into_iter().collect();
        let report = SinkReport {
            name: "plain".to_owned(),
            pulses: self.pulses,
            bytes: self.pulses * self.writer.row_bytes() as u64,
            files: vec![self.writer.target().to_owned()],
            ..SinkReport::default()
        };
        Ok(Closed { report, drafts, force: self.force, recognise: Some(recognise), ..Closed::default() })
    }

    fn readable(&mut self) -> Option<u64> {
        Some(self.writer.readable())
    }

    fn abandon(&mut self) {
        self.writer.abandon();
    }
}
