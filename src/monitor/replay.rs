//! A recording through the same page, at the pace at which it was made.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::{Endpoint, Monitor, MonitorFault, Scenery};
use crate::config;
use crate::pulse::{Pulse, flags};
use crate::recording::{Recording, RecordingError, plain};
use crate::transport::health::Counters;

/// Samples that are held at a time, bytes.
const BLOCK_BYTES: usize = 32 << 20;
/// Fewest and most pulses that are read at a time.
const BLOCK_PULSES: [u64; 2] = [16, 4096];
/// Longest sleep between two looks whether it is to end.
const GLANCE: Duration = Duration::from_millis(50);
/// Shortest time between two counts.
const COUNT_EVERY: Duration = Duration::from_millis(200);

/// Why a recording is not shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No page.
    #[error(transparent)]
    Monitor(#[from] MonitorFault),
}

/// What was shown of a recording.
#[derive(Debug, Default)]
pub struct Played {
    /// Pulses shown.
    pub pulses: u64,
    /// Why it did not go on; `None` at the end of the recording, or when it was stopped.
    pub fault: Option<RecordingError>,
}

/// A recording that is being shown.
pub struct Replay {
    path: PathBuf,
    monitor: Monitor,
    watcher: super::watch::Watcher,
    /// The next pulse to be read, and how many at a time.
    next: u64,
    block: u64,
    first: Recording,
}

/// The pulses from one on; `None` when none is left.
fn read(path: &Path, from: u64, block: u64) -> Result<Option<Recording>, RecordingError> {
    let (mut from, mut span) = (from, block);
    loop {
        let found =
            match span {
                span if span == block => Recording::open(path, Some(from..from.saturating_add(span))),
                // A gap is passed in ever longer steps, without samples, to the first pulse behind it.
                span => Recording::open_channels(path, Some(from..from.saturating_add(span)), None, |_| {
                    Ok(Vec::new())
                }),
            };
        match found {
            Ok(recording) if span == block => return Ok(Some(recording)),
            Ok(recording) => (from, span) = (recording.index[0], block),
            Err(RecordingError::NoPulses { end, .. }) if from.saturating_add(span) < end => {
                (from, span) = (from.saturating_add(span), span.saturating_mul(2));
            }
            Err(RecordingError::NoPulses { .. }) => return Ok(None),
            Err(error) => return Err(error),
        }
    }
}

impl Replay {
    /// Opens a recording, and serves its page.
    ///
    /// # Errors
    /// A recording that cannot be read or holds no pulse; no page.
    pub fn open(path: &Path, endpoint: Endpoint) -> Result<Self, ReplayError> {
        let mut one = Recording::open(path, Some(0..1)).or_else(|error| match error {
            RecordingError::NoPulses { first, end, .. } if first < end => {
                Recording::open(path, Some(first..first + 1))
            }
            error => Err(error),
        })?;
        if path.is_dir() {
            one.header.changes = plain::changes(path)?.map(Arc::new);
        }
        let header = &one.header;
        let fit = BLOCK_BYTES / (8 * header.layout.channels * header.layout.samples).max(1);
        let block = (fit as u64).min(header.prf_hz.ceil() as u64).clamp(BLOCK_PULSES[0], BLOCK_PULSES[1]);
        let title = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        // A scenario of an older version, or one that names files, is shown as far as it is understood.
        let scene = config::recorded(&header.config).ok().map(|run| run.scene);
        let scenery = Scenery::of_recording(scene.as_ref(), &title);
        let (monitor, watcher) = Monitor::of_recording(endpoint, header, &scenery)?;
        Ok(Self { path: path.to_owned(), monitor, watcher, next: one.index[0], block, first: one })
    }

    /// Shows its pulses at `speed` times the pace at which they were emitted, until its end or `stop`.
    pub fn play(&mut self, speed: f64, stop: &AtomicBool) -> Played {
        let mut played = Played::default();
        let mut counters = Counters::default();
        let mut slot = Pulse::new(&self.first.layout());
        let mut begun: Option<(Instant, crate::time::TimeTag)> = None;
        let (mut last, mut counted) = (None, Instant::now());
        loop {
            let recording = match read(&self.path, self.next, self.block) {
                Ok(Some(recording)) => recording,
                Ok(None) => break,
                Err(error) => {
                    played.fault = Some(error);
                    break;
                }
            };
            for pulse in 0..recording.pulses() {
                recording.pulse(pulse, &mut slot);
                let (at, zero) = *begun.get_or_insert((Instant::now(), slot.time));
                let due_s = (slot.time.since(zero) / speed).max(0.0);
                let due = at + Duration::try_from_secs_f64(due_s).unwrap_or_default();
                while let Some(left) =
                    due.checked_duration_since(Instant::now()).filter(|left| !left.is_zero())
                {
                    if stop.load(Ordering::Acquire) {
                        return played;
                    }
                    thread::sleep(left.min(GLANCE));
                }
                self.watcher.show(&slot, true);
                played.pulses += 1;
                counters.released += 1;
                counters.late += u64::from(slot.flags & flags::LATE != 0);
                counters.extrapolated += u64::from(slot.flags & flags::NAV_EXTRAPOLATED != 0);
                counters.by_class[flags::error_class(slot.flags)] += 1;
                counters.stale += u64::from(slot.flags & flags::NAV_STALE != 0);
                counters.dropped += last.map_or(0, |last: u64| slot.index.saturating_sub(last + 1));
                last = Some(slot.index);
                if counted.elapsed() >= COUNT_EVERY {
                    counted = Instant::now();
                    self.watcher.count(counters.clone(), 0);
                }
            }
            if stop.load(Ordering::Acquire) {
                return played;
            }
            self.next = last.map_or(self.next, |last| last + 1);
        }
        self.watcher.count(counters, 0);
        played
    }

    /// Closes the page.
    pub fn close(self) {
        self.monitor.close();
    }
}
