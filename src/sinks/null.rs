//! A sink that counts and forgets.

use crate::pulse::Pulse;

use super::sink::{Closed, Sink, SinkError, SinkReport};

/// Counts pulses.
#[derive(Clone, Copy, Debug, Default)]
pub struct NullSink {
    pulses: u64,
}

impl NullSink {
    /// A sink that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Sink for NullSink {
    fn name(&self) -> &'static str {
        "null"
    }

    fn describe(&self) -> String {
        "nowhere (pulses are counted)".to_owned()
    }

    fn write(&mut self, _: &Pulse) -> Result<(), SinkError> {
        self.pulses += 1;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        let name = "null".to_owned();
        Ok(Closed::of(SinkReport { name, pulses: self.pulses, ..SinkReport::default() }))
    }
}
