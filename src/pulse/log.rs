//! What was changed while a run went on, and at which pulse.
//!
//! A [`Log`] is shared by those who change something and by the recordings, which write a row for every
//! change that has come into effect (`truth/changes`). It only grows: a change is entered before any pulse
//! that has it is begun, so whoever holds a pulse finds all changes up to it.
//!
//! ```
//! use nereus::pulse::log::{Entry, Log, Origin};
//! let log = Log::default();
//! let entry = |pulse| Entry {
//!     pulse, time_ns: 0, platform: "mast".into(), text: "clear".into(), origin: Origin::Control,
//! };
//! log.enter(entry(7));
//! log.enter(entry(3));
//! let pulses = |after, to| log.between(after, to).iter().map(|e| e.pulse).collect::<Vec<_>>();
//! assert_eq!((pulses(None, 7), pulses(Some(3), 9), pulses(None, 2)), (vec![3, 7], vec![7], vec![]));
//! ```

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

/// One change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The first pulse that has it.
    pub pulse: u64,
    /// Emission of that pulse, UTC, floored; that of the pulse has the rest.
    pub time_ns: i64,
    /// Whose report it changes.
    pub platform: String,
    /// What it does, as one would write it.
    pub text: String,
    /// Where it came from.
    #[serde(rename = "source")]
    pub origin: Origin,
}

/// Where a change came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Origin {
    /// The scenario.
    Scenario,
    /// Somebody, while the run went on.
    Control,
}

impl Origin {
    /// As recorded.
    pub fn word(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Control => "control",
        }
    }

    /// From the word.
    pub fn named(word: &str) -> Option<Self> {
        [Self::Scenario, Self::Control].into_iter().find(|origin| origin.word() == word)
    }
}

/// All changes of a run, in the order of their pulses.
#[derive(Debug, Default)]
pub struct Log {
    /// In front of the lock: pulses of a run without changes meet no lock.
    count: AtomicUsize,
    entries: Mutex<Vec<Entry>>,
}

impl PartialEq for Log {
    fn eq(&self, other: &Self) -> bool {
        self.entries() == other.entries()
    }
}

impl From<Vec<Entry>> for Log {
    fn from(entries: Vec<Entry>) -> Self {
        let log = Self::default();
        entries.into_iter().for_each(|entry| log.enter(entry));
        log
    }
}

impl Log {
    fn lock(&self) -> MutexGuard<'_, Vec<Entry>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Enters a change, behind those of the same pulse.
    pub fn enter(&self, entry: Entry) {
        let mut entries = self.lock();
        let place = entries.partition_point(|other| other.pulse <= entry.pulse);
        entries.insert(place, entry);
        self.count.store(entries.len(), Ordering::Release);
    }

    /// All of them.
    pub fn entries(&self) -> Vec<Entry> {
        self.lock().clone()
    }

    /// Those after one pulse (`None`: from the begin) and up to another.
    pub fn between(&self, after: Option<u64>, to: u64) -> Vec<Entry> {
        if self.count.load(Ordering::Acquire) == 0 {
            return Vec::new();
        }
        let entries = self.lock();
        let wanted = |entry: &&Entry| after.is_none_or(|after| entry.pulse > after) && entry.pulse <= to;
        entries.iter().filter(wanted).cloned().collect()
    }
}
