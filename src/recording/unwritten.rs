//! Changes that a recording has still to write.

use std::sync::Arc;

use crate::pulse::log::{Entry, Log};

/// The changes of a run behind those that have been written.
#[derive(Debug)]
pub(super) struct Unwritten {
    log: Arc<Log>,
    after: Option<u64>,
}

impl Unwritten {
    /// All of them.
    pub fn of(log: &Arc<Log>) -> Self {
        Self { log: Arc::clone(log), after: None }
    }

    /// Those that pulses up to this one have: they will have been written.
    pub fn up_to(&mut self, pulse: u64) -> Vec<Entry> {
        if self.after.is_some_and(|after| after >= pulse) {
            return Vec::new();
        }
        let entries = self.log.between(self.after, pulse);
        self.after = Some(pulse);
        entries
    }
}
