//! What is recorded of a reception: a recording of every run, written in a thread of its own, so that the socket is read
//! meanwhile.
//!
//! A recording is made when its first pulse is whole: runs that are only announced leave no files. All are put in their
//! places when the reception has ended well; when one of them fails they stay where they are, and what is counted is what
//! a reader finds.

use std::panic;
use std::path::PathBuf;
use std::thread;

use crossbeam_channel::{Receiver as Inbox, RecvTimeoutError, Sender, TrySendError, bounded};

use crate::pulse::Pulse;
use crate::sinks;
use crate::sinks::sink::{Closed, FLUSH_INTERVAL, Header, Sink, SinkError};

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

    fn finish(self) -> Done {
        drop(self.pulses);
        // A panic goes on where the thread was begun.
        self.thread.join().unwrap_or_else(|panic| panic::resume_unwind(panic))
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
    closed: Vec<Closed>,
    /// Pulses that a reader finds.
    pulses: u64,
    fault: Option<SinkError>,
    /// Recordings of an earlier reception that are removed where this one makes none of its own.
    older: Vec<PathBuf>,
}

/// What was recorded.
pub(super) struct Recorded {
    pub(super) files: Vec<PathBuf>,
    pub(super) pulses: u64,
    /// What the user should know of older outputs.
    pub(super) notes: Vec<String>,
    pub(super) fault: Option<SinkError>,
}

impl Recordings {
    /// None yet. Older ones are removed in the end, where it makes none of its own in their places.
    pub(super) fn replacing(older: Vec<PathBuf>) -> Self {
        Self { older, ..Self::default() }
    }

    /// The next pulse begins a recording, after that of the run before has ended.
    pub(super) fn begin(&mut self, next: Option<Opener>) {
        self.end_one();
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
                Err(error) => self.fault = Some(error),
            }
        }
        match &mut self.recorder {
            Some(recorder) => recorder.record(pulse),
            None => Some(pulse),
        }
    }

    pub(super) fn has_failed(&self) -> bool {
        self.fault.is_some() || self.recorder.as_ref().is_some_and(|recorder| recorder.thread.is_finished())
    }

    fn end_one(&mut self) {
        match self.recorder.take().map(Recorder::finish) {
            None => {}
            Some(Ok(closed)) => {
                self.pulses = self.pulses.saturating_add(closed.report.pulses);
                self.closed.push(closed);
            }
            Some(Err((error, readable))) => {
                self.pulses = self.pulses.saturating_add(readable);
                self.fault.get_or_insert(error);
            }
        }
    }

    /// Ends the last recording, and puts all in their places if nothing has failed and the reception itself has not.
    pub(super) fn finish(mut self, went_well: bool) -> Recorded {
        self.end_one();
        let own: Vec<PathBuf> = self.closed.iter().flat_map(|closed| &closed.report.files).cloned().collect();
        self.older.retain(|old| own.iter().all(|own| own.file_name() != old.file_name()));
        if let Some(last) = self.closed.pop() {
            self.closed.push(sinks::with_surplus(last, self.older));
        }
        let (mut files, mut notes) = (Vec::new(), Vec::new());
        for closed in self.closed {
            if !went_well || self.fault.is_some() {
                files.extend(closed.keep().files);
                continue;
            }
            let (report, error) = match closed.place(true) {
                Ok(report) => (report, None),
                Err(unplaced) => (unplaced.report, Some(unplaced.error)),
            };
            notes.extend(report.notes());
            files.extend(report.files);
            self.fault = error.or(self.fault);
        }
        Recorded { files, pulses: self.pulses, notes, fault: self.fault }
    }
}
