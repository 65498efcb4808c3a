//! Rows of a run under way.

use super::fault::CrsdError;
use super::states::{BEFORE, BEYOND, PulseRow};
use super::writer::{PulseSamples, Writer};
use crate::pulse::Pulse;

/// Rows of pulses under way, around the one that is written next.
#[derive(Debug, Default)]
pub struct Nearby {
    rows: Vec<PulseRow>,
    /// The row that is written next.
    next: usize,
}

/// Rows that are no longer needed are dropped so many at a time.
const SURPLUS: usize = 1024;

impl Nearby {
    /// Takes the row of a pulse that comes after all others.
    ///
    /// # Errors
    /// A pulse that lacks an antenna.
    pub fn take(&mut self, writer: &Writer, pulse: &Pulse) -> Result<(), CrsdError> {
        let missing =
            || CrsdError::NotFinite { pulse: pulse.index, what: "the state of an antenna".to_owned() };
        self.rows.push(PulseRow::of(pulse, writer.description()).ok_or_else(missing)?);
        if self.next > BEFORE + SURPLUS {
            self.rows.drain(..self.next - BEFORE);
            self.next = BEFORE;
        }
        Ok(())
    }

    /// Whether all rows have come from which states of the next pulse are found.
    pub fn is_ready(&self) -> bool {
        let (Some(own), Some(last)) = (self.rows.get(self.next), self.rows.iter().nth_back(BEYOND - 1))
        else {
            return false;
        };
        last.time.since(own.time) > own.window_start_s.max(0.0)
    }

    /// Writes the next pulse.
    ///
    /// # Errors
    /// As of [`Writer`].
    pub fn write(&mut self, writer: &mut Writer, samples: PulseSamples) -> Result<(), CrsdError> {
        self.next += 1;
        writer.push(&self.rows, self.next - 1, samples)
    }
}
