//! What is recorded of a reception: a recording of every run, written in a thread of its own, so that the
//! socket is read meanwhile.
//!
//! A recording is made when its first pulse is whole: runs that are only announced leave no files. One that
//! is over is closed while the next is received. All are put in their places when the reception has ended
//! well; when one of them fails to be written they stay where they are. One that cannot be put in its place
//! does not keep the others from theirs. What is counted is what a reader finds.

use std::panic;
use std::path::PathBuf;
use std::thread;

use crossbeam_channel::{Receiver as Inbox, RecvTimeoutError, Sender, TrySendError, bounded};

use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::sinks;
use crate::sinks::sink::{Closed, FLUSH_INTERVAL, Sink, SinkError};

/// Whole pulses that may wait to be recorded, and samples that they may have together.
const WAITING: usize = 512;
const WAITING_SAMPLES: usize = 1 << 25;

/// Makes the sink of a recording when its header is known.
pub type Opener = Box<dyn FnOnce(&Header) -> Result<Box<dyn Sink>, SinkError> + Send>;

/// What a recording came to, and what a reader finds of it if it failed.
type Done = Result<Closed, (SinkError, u64)>;

/// A recording under way.
struct Recorder {
    pulses: Sender<Box<Pulse>>,
    free: Inbox<Box<Pulse>>,
    /// One past the last pulse that was recorded.
    next: u64,
    thread: thread::JoinHandle<Done>,
}

/// Takes pulses until there are no more.
fn take_all(
    sink: &mut dyn Sink,
    inbox: &Inbox<Box<Pulse>>,
    give: &Sender<Box<Pulse>>,
) -> Result<Closed, SinkError> {
    loop {
        match inbox.recv_timeout(FLUSH_INTERVAL) {
            Ok(pulse) => {
                sink.write(&pulse)?;
                match give.try_send(pulse) {
                    Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {}
                }
            }
            // Silence: what has come is made readable.
            Err(RecvTimeoutError::Timeout) => sink.flush()?,
            Err(RecvTimeoutError::Disconnected) => return sink.close(),
        }
    }
}

impl Recorder {
    fn start(header: &Header, open: Opener) -> Result<Self, SinkError> {
        let mut sink = open(header)?;
        let samples = header.layout.channels.saturating_mul(header.layout.samples).max(1);
        let waiting = (WAITING_SAMPLES / samples).clamp(2, WAITING);
        let (pulses, inbox) = bounded::<Box<Pulse>>(waiting);
        let (give, free) = bounded(waiting);
        let thread = thread::spawn(move || {
            let done = take_all(sink.as_mut(), &inbox, &give);
            done.map_err(|error| (error, sink.readable().unwrap_or(0)))
        });
        Ok(Self { pulses, free, next: 0, thread })
    }

    /// Hands a pulse over and takes back one that was written.
    fn record(&mut self, pulse: Box<Pulse>) -> Option<Box<Pulse>> {
        // Pulses of a recording ascend: those of a stream that went back are counted alone.
        if pulse.index < self.next {
            return Some(pulse);
        }
        self.next = pulse.index.saturating_add(1);
        // A recording that failed is reported in the end.
        let _ = self.pulses.send(pulse);
        self.free.try_recv().ok()
    }

    /// There are no more pulses: the thread closes the recording.
    fn end(self) -> thread::JoinHandle<Done> {
        self.thread
    }
}

/// The recordings of a reception.
#[derive(Default)]
pub(super) struct Recordings {
    /// What makes the next one.
    next: Option<Opener>,
    /// Header of the run that is received.
    header: Option<Header>,
    recorder: Option<Recorder>,
    /// The one before, while it is closed: handing it to the disk takes time, in which the socket is read.
    ending: Option<thread::JoinHandle<Done>>,
    closed: Vec<Closed>,
    /// Pulses that a reader finds of recordings that failed.
    readable: u64,
    fault: Option<SinkError>,
    /// Recordings of an earlier reception that are removed where this one makes none of its own.
    older: Vec<PathBuf>,
}

/// What was recorded.
#[derive(Default)]
pub(super) struct Recorded {
    pub(super) files: Vec<PathBuf>,
    /// Of those.
    pub(super) pulses: u64,
    /// Older outputs that stay although they were to be replaced.
    pub(super) kept: Vec<PathBuf>,
    /// Recordings that another program has moved on or removed after they were complete.
    pub(super) gone: Vec<PathBuf>,
    /// What the user should know of older outputs, and of further faults.
    pub(super) notes: Vec<String>,
    /// The first.
    pub(super) fault: Option<SinkError>,
}

impl Recordings {
    /// None yet. Older ones are removed in the end, where it makes none of its own in their places.
    pub(super) fn replacing(older: Vec<PathBuf>) -> Self {
        Self { older, ..Self::default() }
    }

    /// The next pulse begins a recording. That of the run before is closed meanwhile; one at a time, for each
    /// takes memory.
    pub(super) fn begin(&mut self, next: Option<Opener>) {
        if let Some(recorder) = self.recorder.take() {
            self.end_one(true);
            self.ending = Some(recorder.end());
        }
        self.next = next;
    }

    /// The run that is received.
    pub(super) fn describe(&mut self, header: &Header) {
        self.header = Some(header.clone());
    }

    /// Takes a whole pulse; what it gives back is used again.
    pub(super) fn take(&mut self, pulse: Box<Pulse>) -> Option<Box<Pulse>> {
        if let (None, Some(header)) = (&self.recorder, &self.header)
            && let Some(open) = self.next.take()
        {
            match Recorder::start(header, open) {
                Ok(recorder) => self.recorder = Some(recorder),
                Err(error) => drop(self.fault.get_or_insert(error)),
            }
        }
        match &mut self.recorder {
            Some(recorder) => recorder.record(pulse),
            None => Some(pulse),
        }
    }

    pub(super) fn has_failed(&mut self) -> bool {
        if self.ending.as_ref().is_some_and(thread::JoinHandle::is_finished) {
            self.end_one(true);
        }
        self.fault.is_some() || self.recorder.as_ref().is_some_and(|recorder| recorder.thread.is_finished())
    }

    /// Waits until the recording that is closed is whole. One that others may move on holds no file open:
    /// there may be hundreds of them.
    fn end_one(&mut self, may_be_moved: bool) {
        let Some(thread) = self.ending.take() else { return };
        // A panic goes on where the thread was begun.
        match thread.join().unwrap_or_else(|panic| panic::resume_unwind(panic)) {
            Ok(mut closed) => {
                if may_be_moved {
                    closed.hand_on();
                }
                self.closed.push(closed);
            }
            Err((error, readable)) => {
                self.readable = self.readable.saturating_add(readable);
                self.fault.get_or_insert(error);
            }
        }
    }

    /// Ends the last recording, and puts all in their places if nothing has failed and the reception itself
    /// has not.
    pub(super) fn finish(mut self, went_well: bool) -> Recorded {
        self.begin(None);
        self.end_one(false);
        let own: Vec<PathBuf> = self.closed.iter().flat_map(|closed| &closed.report.files).cloned().collect();
        self.older.retain(|old| own.iter().all(|own| own.file_name() != old.file_name()));
        if let Some(last) = self.closed.pop() {
            self.closed.push(sinks::with_surplus(last, self.older));
        }
        let places = went_well && self.fault.is_none();
        let mut recorded = Recorded { pulses: self.readable, fault: self.fault, ..Recorded::default() };
        for closed in self.closed {
            recorded.add(closed, places);
        }
        recorded
    }
}

impl Recorded {
    /// Puts a recording in its place, or leaves it where it is.
    fn add(&mut self, closed: Closed, places: bool) {
        let report = if places {
            // Older recordings are removed only if all of these are in their places.
            closed.place(self.fault.is_none()).unwrap_or_else(|unplaced| {
                self.fail(unplaced.error);
                unplaced.report
            })
        } else {
            closed.keep()
        };
        self.notes.extend(report.notes());
        if !report.files.is_empty() {
            self.pulses = self.pulses.saturating_add(report.pulses);
        }
        self.files.extend(report.files);
        self.kept.extend(report.kept);
        self.gone.extend(report.gone);
    }

    /// The first fault ends the program; the others are reported, for each names a recording.
    fn fail(&mut self, error: SinkError) {
        match &self.fault {
            Some(_) => self.notes.push(error.to_string()),
            None => self.fault = Some(error),
        }
    }
}
