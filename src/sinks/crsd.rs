//! Pulses as a CRSD file ([`crate::recording::crsd`]), as they come.
//!
//! Arrays are written where they will be if all pulses of the run come; what is missing in the end is closed
//! up. The file has no name of its own until it is complete: before that nobody could read it. A pulse waits
//! for those after it that show where antennas are when its window opens: three, and as many as leave before.

use std::collections::VecDeque;
use std::fs::OpenOptions;
use std::path::{Path, PathBuf};

use super::sink::{Closed, Keeping, Sink, SinkError, SinkReport};
use crate::files::{self, Draft, FileFault, Holding};
use crate::pulse::{Pulse, Samples};
use crate::recording::crsd::{CrsdError, Description, Nearby, PulseSamples, Writer};
use crate::recording::output::recognise_crsd;

/// What a CRSD sink needs to know of a run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is recorded.
    pub description: Description,
    /// Pulses of every transmit sequence.
    pub planned: Vec<u64>,
}

/// A CRSD file.
#[derive(Debug)]
pub struct CrsdSink {
    target: PathBuf,
    force: bool,
    draft: Option<Draft>,
    writer: Option<Writer>,
    nearby: Nearby,
    waiting: VecDeque<Samples>,
    pulses: u64,
}

impl CrsdSink {
    /// Makes the file under a name of this process; nothing is left of it when that fails.
    ///
    /// # Errors
    /// A run that is too short, what is there already, and what the system refuses.
    pub fn create(path: &Path, force: bool, plan: &Plan) -> Result<Self, SinkError> {
        files::preflight(path, force, &recognise_crsd)?;
        let mut draft = Draft::named(path);
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(draft.path());
        let file = file.map_err(FileFault::io(path, "making the file"))?;
        draft.made(Holding::File)?;
        draft.lock();
        match Writer::new(path, file, plan.description.clone(), &plan.planned) {
            Ok(writer) => Ok(Self {
                target: path.to_owned(),
                force,
                draft: Some(draft),
                writer: Some(writer),
                nearby: Nearby::default(),
                waiting: VecDeque::new(),
                pulses: 0,
            }),
            Err(error) => {
                draft.abandon();
                Err(error.into())
            }
        }
    }

    /// Writes what waits, if all that it needs has come, or nothing more will.
    fn write_waiting(&mut self, is_last: bool) -> Result<(), SinkError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        while !self.waiting.is_empty() && (is_last || self.nearby.is_ready()) {
            let Some(samples) = self.waiting.pop_front() else { break };
            let samples = match &samples {
                Samples::Cf32(values) => PulseSamples::Cf32(values),
                Samples::Ci16(codes) => PulseSamples::Ci16(bytemuck::cast_slice(codes)),
            };
            self.nearby.write(writer, samples)?;
        }
        Ok(())
    }
}

impl Sink for CrsdSink {
    fn name(&self) -> &'static str {
        "crsd"
    }

    fn describe(&self) -> String {
        format!("CRSD file {}", self.target.display())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        let Some(writer) = &self.writer else { return Ok(()) };
        self.nearby.take(writer, pulse)?;
        self.waiting.push_back(pulse.samples.clone());
        self.pulses += 1;
        self.write_waiting(false)
    }

    /// Nobody reads a file that is not complete.
    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        self.write_waiting(true)?;
        let mut report = SinkReport { name: "crsd".to_owned(), pulses: self.pulses, ..SinkReport::default() };
        let (Some(writer), Some(draft)) = (self.writer.take(), self.draft.take()) else {
            return Ok(Closed::of(report));
        };
        if writer.too_few().is_some() {
            // The run was stopped before two pulses: there is no such file.
            draft.abandon();
            report.kept.extend(self.target.exists().then(|| self.target.clone()));
            report.kept_because = Some(Keeping::Empty);
            return Ok(Closed::of(report));
        }
        report.bytes = match writer.finish() {
            Ok(bytes) => bytes,
            Err(error) => {
                draft.abandon();
                return Err(error.into());
            }
        };
        report.files = vec![self.target.clone()];
        let drafts = vec![draft];
        Ok(Closed { report, drafts, force: self.force, recognise: Some(recognise_crsd), ..Closed::default() })
    }

    fn readable(&mut self) -> Option<u64> {
        self.abandon();
        Some(0)
    }

    fn abandon(&mut self) {
        self.writer = None;
        if let Some(draft) = self.draft.take() {
            draft.abandon();
        }
    }
}

impl From<CrsdError> for SinkError {
    fn from(error: CrsdError) -> Self {
        Self::Crsd(Box::new(error))
    }
}
