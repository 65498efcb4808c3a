//! A thread that reads a receiver and delivers its fixes.
//!
//! [`Feed::open`] opens the [`Origin`] of a [`LiveSource`] and starts the thread; every fix is handed to the
//! caller with the instant of the read that completed it. Serial ports, listening addresses and files must be
//! there, somebody to connect to may come later. Dropping the feed ends the thread within 200 ms.
//!
//! * **Faults.** Garbage and half sentences are counted and passed over. A line that vanishes is counted and
//!   opened again, at most twice per second; half a message before the break is dropped. Silence is silence:
//!   nothing is reported.
//! * **Time.** Fixes come with strictly increasing times. One that is not later than the one before is
//!   counted and left (more than 5 s: as a step of the clock); a fix more than `max_gap_s` ahead is reported
//!   when the next one confirms it. See [`completion`](crate::nav::completion).
//! * **Latency.** That of the receiver and its line; sentences wait for the next epoch, INSPVAX for nothing.
//! * **A file** is replayed in time: fixes earlier than `from` less 10 s are left out, those before `from`
//!   are reported at once, later ones when as much time has passed since the feed was opened as lies between
//!   `from` and them. Without `from` its first fix is reported at once. Behind its end it is silent.
//! * **Memory** is bounded whatever comes in: the decoder holds 32 KiB, at most 16,384 fixes wait.
//!
//! ```
//! use std::sync::mpsc;
//! use nereus::nav::live::{Feed, LiveSource, MotionBounds, Origin};
//! use nereus::nav::{AttitudeSource, VerticalDatum};
//! use nereus::time::TimeTag;
//!
//! let source = LiveSource {
//!     origin: Origin::File("configs/tracks/cart.inspvax".into()),
//!     datum: VerticalDatum::Ellipsoid,
//!     undulation_m: 0.0,
//!     attitude: AttitudeSource::Recorded,
//!     first_day: None,
//!     max_gap_s: 5.0,
//!     max_extrapolation_s: 1.0,
//!     timeout_s: 30.0,
//!     bounds: MotionBounds::AIRCRAFT,
//!     nominal: None,
//! };
//! let (to, from) = mpsc::channel();
//! let start = TimeTag::from_iso8601("2014-11-24T20:30:21Z")?;
//! let feed = Feed::open(&source, "cart", start, move |received| { let _ = to.send(received.fix.time); })?;
//! assert_eq!(from.recv()?.to_string(), "2014-11-24T20:30:19.900000Z");
//! assert!(feed.counts().good > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::{Serialize, Serializer};
use thiserror::Error;

use super::line::{self, Line, Received};
use super::{FixDecoder, LiveSource, Origin, ReceivedFix};
use crate::nav::alternation::Alternation;
use crate::nav::recording::Alternating;
use crate::nav::{Fix, unpacked};
use crate::time::TimeTag;

/// The longest datagram, and more than a port holds.
const READ_BYTES: usize = 1 << 16;
/// Bytes of a file that are read at once.
const FILE_BYTES: usize = 1 << 12;
/// How much of a file is reported that lies before the begin, s.
pub const BEFORE_S: f64 = 10.0;

/// Why nothing can be received.
#[derive(Debug, Error)]
#[error("live navigation of \"{name}\": cannot open {origin}: {source}")]
pub struct FeedError {
    /// From whom fixes are to come.
    pub name: String,
    /// Where.
    pub origin: Origin,
    /// The system's error.
    pub source: io::Error,
}

/// What was received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FeedCounts {
    /// Bytes read.
    pub bytes: u64,
    /// Messages that were read.
    pub good: u64,
    /// Messages whose checksum is wrong.
    pub bad_checksum: u64,
    /// Lines that are no sentence, and messages whose fields cannot be read.
    pub malformed: u64,
    /// Messages of kinds that are not read here.
    pub unknown: u64,
    /// Among the good ones: positions that say of themselves that there is none.
    pub void: u64,
    /// Epochs not later than one before by up to 5 s: left.
    pub out_of_order: u64,
    /// Epochs earlier by more, and single ones far ahead: left.
    pub clock_steps: u64,
    /// Epochs with a position and no date: left.
    pub undated: u64,
    /// Positions of another talker than the one that is used: left.
    pub other_talkers: u64,
    /// Positions with the time of one before, elsewhere: left.
    pub repeated_times: u64,
    /// Dates that changed late or early at midnight or at the end of a GPS week, set right.
    pub dates_corrected: u64,
    /// How far from each other two places are between which fixes alternate, m.
    pub alternating_m: Option<f64>,
    /// Fixes reported.
    pub fixes: u64,
    /// Among all fixes: those without a height of their own.
    pub heights_filled: u64,
    /// Those that got the heading of their neighbours.
    pub headings_filled: u64,
    /// Whether the line is open; of a file, whether its end is not yet reached.
    pub connected: bool,
    /// How often it vanished.
    pub vanished: u64,
    /// How often it was opened again.
    pub reopened: u64,
    /// Others who wanted to connect.
    pub refused: u64,
    /// Time of the last fix reported.
    #[serde(serialize_with = "as_text")]
    pub last_fix: Option<TimeTag>,
}

impl fmt::Display for FeedCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} fixes of {} messages", self.fixes, self.good)?;
        for (count, what) in [
            (self.bad_checksum, "with a wrong checksum"),
            (self.malformed, "malformed"),
            (self.unknown, "of other kinds"),
            (self.out_of_order, "epochs out of order"),
            (self.clock_steps, "after a step of the clock"),
            (self.undated, "without a date (give it: date)"),
            (self.other_talkers, "of another talker"),
            (
                self.repeated_times,
                "with the time of the position before (a clock of whole seconds, or two receivers)",
            ),
            (self.dates_corrected, "dates set right"),
            (self.vanished, "times vanished"),
            (self.reopened, "times opened again"),
        ] {
            if count > 0 {
                write!(f, "; {count} {what}")?;
            }
        }
        if let Some(apart_m) = self.alternating_m {
            write!(f, "; {}", Alternating(apart_m))?;
        }
        Ok(())
    }
}

fn as_text<S: Serializer>(time: &Option<TimeTag>, to: S) -> Result<S::Ok, S::Error> {
    time.map(|time| time.to_string()).serialize(to)
}

/// A receiver that is received.
pub struct Feed {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    stop: AtomicBool,
    counts: Mutex<FeedCounts>,
}

impl Shared {
    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn count(&self, change: impl FnOnce(&mut FeedCounts)) {
        change(&mut self.counts.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl std::fmt::Debug for Feed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Feed").field("counts", &self.counts()).finish_non_exhaustive()
    }
}

impl Feed {
    /// Reads a source from now on; `name` is that of the platform, for messages. A file is replayed as if it
    /// were `from` now.
    ///
    /// `deliver` is called on the thread of the feed and must not wait long.
    ///
    /// # Errors
    /// A port, an address or a file that cannot be opened.
    pub fn open(
        source: &LiveSource,
        name: &str,
        from: impl Into<Option<TimeTag>>,
        deliver: impl FnMut(ReceivedFix) + Send + 'static,
    ) -> Result<Self, FeedError> {
        let refused =
            |error| FeedError { name: name.to_owned(), origin: source.origin.clone(), source: error };
        let shared = Arc::new(Shared { stop: AtomicBool::new(false), counts: Mutex::default() });
        let delivery = Delivery {
            shared: Arc::clone(&shared),
            decoder: FixDecoder::new(source.datum, source.undulation_m, source.attitude, source.max_gap_s)
                .dated(source.first_day),
            alternation: Alternation::default(),
            deliver,
        };
        let builder = thread::Builder::new().name(format!("nav {name}"));
        let thread = match &source.origin {
            Origin::File(path) => {
                let file = whole_file(path).map_err(refused)?;
                shared.count(|counts| counts.connected = true);
                let replay = Replay { file, from: from.into(), opened: Instant::now() };
                builder.spawn(move || replay.run(delivery))
            }
            origin => {
                let line = Line::open(origin).map_err(refused)?;
                shared.count(|counts| counts.connected = line.is_open());
                builder.spawn(move || listen(line, delivery))
            }
        };
        Ok(Self { shared, thread: Some(thread.map_err(refused)?) })
    }

    /// What has come so far.
    pub fn counts(&self) -> FeedCounts {
        *self.shared.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic of whoever is reported has been reported on its thread.
            let _ = thread.join();
        }
    }
}

/// Delivers what a decoder finds.
struct Delivery<F> {
    shared: Arc<Shared>,
    decoder: FixDecoder,
    alternation: Alternation,
    deliver: F,
}

impl<F: FnMut(ReceivedFix)> Delivery<F> {
    /// Brings the counts up to date.
    fn count(&self, change: impl FnOnce(&mut FeedCounts)) {
        let (messages, completion) = (*self.decoder.messages(), self.decoder.completion());
        let assembly = self.decoder.assembly();
        self.shared.count(|counts| {
            counts.good = messages.good;
            counts.bad_checksum = messages.bad_checksum;
            counts.malformed = messages.malformed;
            counts.unknown = messages.unknown;
            counts.void = messages.void;
            counts.out_of_order = completion.out_of_order;
            counts.clock_steps = completion.clock_steps;
            counts.undated = completion.undated;
            counts.other_talkers = assembly.other_talkers;
            counts.repeated_times = assembly.repeated;
            counts.dates_corrected = assembly.dates_corrected;
            counts.heights_filled = completion.heights_filled;
            counts.headings_filled = completion.headings_filled;
            change(counts);
        });
    }

    /// Counts first: whoever is reported a fix finds it in the counts.
    fn report(&mut self, fix: Fix, arrived: Instant) {
        self.alternation.push(&fix);
        let alternating_m = self.alternation.apart_m();
        self.shared.count(|counts| {
            counts.alternating_m = alternating_m;
            counts.fixes += 1;
            counts.last_fix = Some(fix.time);
        });
        (self.deliver)(ReceivedFix { fix, arrived });
    }
}

/// Reads a line until it is stopped.
fn listen<F: FnMut(ReceivedFix)>(mut line: Line, mut delivery: Delivery<F>) {
    let mut buffer = vec![0; READ_BYTES];
    let mut fixes = Vec::new();
    let mut had_been_open = line.is_open();
    let shared = Arc::clone(&delivery.shared);
    while !shared.is_stopped() {
        let received = line.read(&mut buffer, &|| shared.is_stopped());
        let arrived = Instant::now();
        let refused = line.refused();
        match received {
            Received::Nothing => {
                shared.count(|counts| counts.refused = refused);
                continue;
            }
            Received::Opened => {
                delivery.count(|counts| {
                    counts.connected = true;
                    counts.reopened += u64::from(had_been_open);
                    counts.refused = refused;
                });
                had_been_open = true;
            }
            Received::Bytes(bytes) => {
                delivery.decoder.push(&buffer[..bytes], &mut |fix| fixes.push(fix));
                delivery.count(|counts| {
                    counts.bytes += bytes as u64;
                    counts.refused = refused;
                });
            }
            Received::Vanished => {
                delivery.decoder.interrupt(&mut |fix| fixes.push(fix));
                delivery.count(|counts| {
                    counts.connected = false;
                    counts.vanished += 1;
                });
            }
        }
        for fix in fixes.drain(..) {
            delivery.report(fix, arrived);
        }
    }
}

fn whole_file(path: &Path) -> io::Result<Box<dyn Read + Send>> {
    // A folder can be opened, but not read.
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "not a file"));
    }
    unpacked::open(path)
}

/// A file that is replayed in time.
struct Replay {
    file: Box<dyn Read + Send>,
    from: Option<TimeTag>,
    opened: Instant,
}

impl Replay {
    fn run<F: FnMut(ReceivedFix)>(mut self, mut delivery: Delivery<F>) {
        let mut buffer = vec![0; FILE_BYTES];
        let mut fixes = VecDeque::new();
        let mut ended = false;
        while !ended && !delivery.shared.is_stopped() {
            let bytes = match self.file.read(&mut buffer) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(_) => 0,
            };
            ended = bytes == 0;
            if ended {
                delivery.decoder.finish(&mut |fix| fixes.push_back(fix));
            } else {
                delivery.decoder.push(&buffer[..bytes], &mut |fix| fixes.push_back(fix));
            }
            delivery.count(|counts| counts.bytes += bytes as u64);
            while let Some(fix) = fixes.pop_front() {
                if self.wait_for(fix.time, &delivery.shared) {
                    delivery.report(fix, Instant::now());
                } else if delivery.shared.is_stopped() {
                    return;
                }
            }
        }
        delivery.count(|counts| counts.connected = false);
    }

    /// Waits until a time has come; false if it lies too far back, or nobody waits any longer.
    fn wait_for(&mut self, time: TimeTag, shared: &Shared) -> bool {
        let after_s = time.since(*self.from.get_or_insert(time));
        if after_s < -BEFORE_S {
            return false;
        }
        loop {
            let left_s = after_s - self.opened.elapsed().as_secs_f64();
            if shared.is_stopped() {
                return false;
            }
            if left_s <= 0.0 {
                return true;
            }
            let left = Duration::try_from_secs_f64(left_s).unwrap_or(Duration::MAX);
            thread::sleep(left.min(line::READ_TIMEOUT));
        }
    }
}
