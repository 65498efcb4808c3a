//! What every sink is.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use crate::files::{self, Draft, FileFault, Recognised};
use crate::inputs::shown;
use crate::pulse::Pulse;
use crate::recording::source::pulses_in;
use crate::transport::fanout::{Fed, Feed};
use crate::units::counted;

use super::asterix::VideoReport;
use super::port::PortCounts;
use super::vita49::WireReport;

pub use super::fault::SinkError;

/// What a reader may count on after a kill: everything older than this was handed to the system.
/// Recordings flush when a pulse finds the last flush older than this, or when none came for as long.
pub const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

/// A place where pulses go. A sink runs in a thread of its own and may wait; see [`drain`].
pub trait Sink: Send {
    /// Short name for counters and messages (`hdf5`).
    fn name(&self) -> &'static str;
    /// One line for people: what goes where.
    fn describe(&self) -> String;
    /// Takes a pulse.
    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError>;
    /// Makes everything taken so far visible to readers.
    fn flush(&mut self) -> Result<(), SinkError>;
    /// Completes and closes the output. It is not yet put in the place of an older one: see [`Closed`].
    fn close(&mut self) -> Result<Closed, SinkError>;
    /// After a failure: gives up what cannot be completed, and counts the pulses that a reader of the output
    /// finds. `None` of a sink that keeps nothing.
    fn readable(&mut self) -> Option<u64> {
        None
    }
    /// Removes what this sink has made: a run that could not begin leaves nothing.
    fn abandon(&mut self) {}
    /// Completes and closes the output of a whole run and puts it in its place.
    fn finish(mut self: Box<Self>) -> Result<SinkReport, SinkError> {
        self.close()?.place(true).map_err(|unplaced| unplaced.error)
    }
}

/// An output that is complete and closed.
///
/// A recording that is to replace an older one still has the name of its process, so that a run that fails in
/// another of its sinks leaves the older one as it was.
#[derive(Debug, Default)]
pub struct Closed {
    /// What the sink did; the files as they will be named.
    pub report: SinkReport,
    pub(super) drafts: Vec<Draft>,
    /// Whether older recordings are replaced.
    pub(super) force: bool,
    /// Older parts beyond those of this run: segments, recordings of further runs.
    pub(super) surplus: Vec<PathBuf>,
    pub(super) recognise: Option<fn(&Path) -> Recognised>,
}

impl Closed {
    /// Of an output that has no place to be put in.
    pub fn of(report: SinkReport) -> Self {
        Self { report, ..Self::default() }
    }

    /// Puts everything in its place, hands it to the disk, and removes what it replaces. What holds nothing
    /// replaces nothing, and older segments beyond those of this run go only when it was `whole`: it was
    /// asked for all pulses and has come to its end.
    ///
    /// # Errors
    /// The first fault, after all has been tried; the report has where everything is.
    pub fn place(self, whole: bool) -> Result<SinkReport, Box<Unplaced>> {
        let Self { mut report, drafts, force, surplus, recognise } = self;
        let recognise = |path: &Path| recognise.map_or(Err("output"), |recognise| recognise(path));
        let mut names =
            if drafts.is_empty() { Vec::new() } else { std::mem::take(&mut report.files) }.into_iter();
        let mut error = None;
        for draft in drafts {
            let name = names.next().unwrap_or_else(|| draft.target().to_owned());
            if report.bytes == 0 && !draft.is_in_place() && draft.target().exists() {
                draft.abandon();
                report.kept.push(name);
                report.kept_because = Some(Keeping::Empty);
                continue;
            }
            let target = draft.target().to_owned();
            // A run that was stopped may have fewer pulses than what it replaces.
            let older = if whole || draft.is_in_place() { None } else { pulses_in(&target) };
            match draft.finish(force, &recognise) {
                Ok(Some(at)) => {
                    let fewer = |older: &usize| *older as u64 > report.pulses && at == target;
                    report.shortened.extend(older.filter(fewer).map(|older| (name.clone(), older as u64)));
                    report.files.push(if at == target { name } else { at });
                }
                Ok(None) => report.gone.push(name),
                Err(fault) => {
                    report.files.extend(match &fault {
                        FileFault::Kept { at, .. } => Some(at.clone()),
                        FileFault::Moved { now, .. } => now.clone(),
                        FileFault::Removed { .. } => None,
                        _ => Some(name),
                    });
                    error.get_or_insert(fault);
                }
            }
        }
        let why = match error {
            _ if report.bytes == 0 => Some(Keeping::Empty),
            Some(_) => Some(Keeping::Unplaced),
            None => (!whole).then_some(Keeping::Part),
        };
        for path in surplus {
            // Somebody has put a link there: what it points to is not beside the output.
            let is_link = std::fs::symlink_metadata(&path).is_ok_and(|data| data.is_symlink());
            if let Some(why) = why.or(is_link.then_some(Keeping::Link)) {
                report.kept.push(path);
                report.kept_because = Some(why);
                continue;
            }
            match files::remove_recognised(&path, &recognise) {
                Ok(()) => report.removed.push(path),
                Err(fault) => error = error.or(Some(fault)),
            }
        }
        match error {
            None => Ok(report),
            Some(fault) => Err(Box::new(Unplaced { report, error: fault.into() })),
        }
    }

    /// Lets others move on what is complete, and holds no file of it open.
    pub(crate) fn hand_on(&mut self) {
        self.drafts.iter_mut().for_each(Draft::hand_on);
    }

    /// Leaves everything where it is, and reports where that is: what a failed run has recorded is not lost,
    /// nor does it replace anything.
    pub fn keep(mut self) -> SinkReport {
        if self.drafts.is_empty() {
            return self.report;
        }
        let mut names = std::mem::take(&mut self.report.files).into_iter();
        for draft in &self.drafts {
            let name = names.next().unwrap_or_else(|| draft.target().to_owned());
            match draft.present() {
                Ok(_) if draft.is_gone() => self.report.gone.push(name),
                Ok(at) | Err(FileFault::Moved { now: Some(at), .. }) => {
                    if !draft.is_in_place() {
                        self.report.beside.push((name, at.clone()));
                    }
                    self.report.files.push(at);
                }
                Err(_) => self.report.gone.push(name),
            }
        }
        self.report
    }
}

/// Why older outputs stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Keeping {
    /// Nothing was written.
    Empty,
    /// The run was stopped, or was a part of its pulses.
    Part,
    /// A new output could not be put in its place.
    Unplaced,
    /// They are links.
    Link,
}

impl Keeping {
    /// As the report prints it.
    fn text(self) -> &'static str {
        match self {
            Self::Empty => "not overwritten, because this run has written nothing",
            Self::Part => "older, not removed, because the run was stopped or was a part of its pulses",
            Self::Unplaced => "older, not removed, because not all new outputs could be put in place",
            Self::Link => "older, not removed, because it is a link",
        }
    }
}

/// An output that could not be put in its place, or not all of it.
#[derive(Debug)]
pub struct Unplaced {
    /// What the sink did; the files where they are.
    pub report: SinkReport,
    /// Why.
    pub error: SinkError,
}

/// What a sink did.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SinkReport {
    /// The sink's name.
    pub name: String,
    /// Pulses taken.
    pub pulses: u64,
    /// Bytes of per-pulse data written.
    pub bytes: u64,
    /// What was written, in order.
    #[serde(serialize_with = "crate::files::lossy_paths")]
    pub files: Vec<PathBuf>,
    /// Older outputs that stay although they were to be replaced.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "crate::files::lossy_paths")]
    pub kept: Vec<PathBuf>,
    /// Why they stay.
    #[serde(skip)]
    pub kept_because: Option<Keeping>,
    /// Older parts that were removed, because this run has none in their places.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "crate::files::lossy_paths")]
    pub removed: Vec<PathBuf>,
    /// Recordings that a run which was stopped has replaced by shorter ones, and how many pulses they had.
    #[serde(skip)]
    pub shortened: Vec<(PathBuf, u64)>,
    /// Of a run that failed: older outputs that stay, and where the new ones are.
    #[serde(skip)]
    pub beside: Vec<(PathBuf, PathBuf)>,
    /// Outputs that another program has moved on or removed after they were complete.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "crate::files::lossy_paths")]
    pub gone: Vec<PathBuf>,
    /// Of a sink that sends: what became of its datagrams.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wire: Option<WireReport>,
    /// What became of the messages, where the output is a port.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub port: Option<PortCounts>,
    /// Of a sink that others subscribe to: what became of its messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subscribers: Option<SubscriberCounts>,
    /// Of a sink that sends video: what became of its cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub video: Option<VideoReport>,
}

/// What became of the messages of a sink that others subscribe to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SubscriberCounts {
    /// Where they were published.
    pub at: String,
    /// Subscribers that came.
    pub seen: u64,
    /// Messages handed over, each to each subscriber.
    pub messages: u64,
    /// Messages that were not handed over because a subscriber was too slow or gone, as far as the sink can
    /// know: a subscriber counts by their `sequence` what it has missed.
    pub lost: u64,
}

impl SinkReport {
    /// What the user should know of older outputs, and of files that are no longer there.
    pub fn notes(&self) -> Vec<String> {
        let kept = self.kept_because.map_or("older, not removed", Keeping::text);
        let of = |files: &[PathBuf], what: &str| match files {
            [] => None,
            [file] => Some(format!("{}: {what}", file.display())),
            [first, more @ ..] => Some(format!("{} and {} more: {what}", first.display(), more.len())),
        };
        let gone = "moved or removed by another program after it was complete";
        let removed = "older, removed, because this run has no such part";
        let all = [of(&self.kept, kept), of(&self.removed, removed), of(&self.gone, gone)];
        let pulses = counted(self.pulses, "pulse");
        let shortened = self.shortened.iter().map(|(path, older)| {
            let older = counted(*older, "pulse");
            format!("{}: replaced a recording of {older} by one of {pulses}", path.display())
        });
        let beside = self.beside.iter().map(|(path, at)| {
            let (path, at) = (path.display(), at.display());
            // Of several files nobody has counted which pulses are in which.
            let pulses = if self.beside.len() == 1 { pulses.clone() } else { "pulses".to_owned() };
            match self.pulses {
                0 => format!("{path}: kept as it was; {at} has no pulse of this run"),
                _ => format!(
                    "{path}: kept as it was; {pulses} of this run are in {at}: to use them, put it in the place of {path}"
                ),
            }
        });
        all.into_iter().flatten().chain(shortened).chain(beside).collect()
    }

    /// What was written and sent.
    pub fn lines(&self) -> Vec<String> {
        let name = &self.name;
        let files = self.files.iter().map(|file| format!("{name}: {}", shown(file)));
        let published = self.subscribers.as_ref().map(|all| {
            let (messages, seen) = (counted(all.messages, "message"), counted(all.seen, "subscriber"));
            format!("{name}: {messages} to {seen}; {}", all.at)
        });
        let sent = self
            .wire
            .as_ref()
            .map(|wire| format!("{name}: {} datagrams to {}", wire.datagrams, wire.address));
        let clipped = self.video.as_ref().filter(|video| video.clipped > 0).map(|video| {
            let VideoReport { clipped, cells, .. } = video;
            format!("{name}: {clipped} of {cells} cells are above the greatest code; see full_dbw")
        });
        files.chain(published).chain(sent).chain(clipped).collect()
    }

    /// What was lost on the way out.
    pub fn losses(&self) -> Vec<String> {
        let name = &self.name;
        let port = self.port.filter(|port| port.lost_messages > 0 || port.vanished > 0).map(|port| {
            format!(
                "the port of sink '{name}' did not take {} messages ({} bytes); it vanished {} times and was opened again {} times",
                port.lost_messages, port.lost_bytes, port.vanished, port.reopened
            )
        });
        let subscribers = self.subscribers.as_ref().filter(|all| all.lost > 0).map(|all| {
            format!(
                "sink '{name}': subscribers were too slow for {} or went before they had them; see buffer_pulses",
                counted(all.lost, "message")
            )
        });
        let wire = self.wire.as_ref().filter(|wire| wire.lost() > 0).map(|wire| {
            format!(
                "{} datagrams were lost: {} refused by the receiver's machine, {} without room in the send buffer, {} for other reasons",
                wire.lost(),
                wire.refused,
                wire.blocked,
                wire.no_buffer + wire.failed
            )
        });
        [port, subscribers, wire].into_iter().flatten().collect()
    }
}

/// The body of a sink's thread: takes pulses until the stream ends, then closes.
///
/// When something fails, the pulses that the feed counts as written become those that a reader finds.
///
/// # Errors
/// The first fault of the sink.
pub fn drain(mut sink: Box<dyn Sink>, mut feed: Feed) -> Result<Closed, SinkError> {
    let done = take_all(sink.as_mut(), &mut feed);
    if done.is_err()
        && let Some(pulses) = sink.readable()
    {
        feed.wrote_in_all(pulses);
    }
    done
}

fn take_all(sink: &mut dyn Sink, feed: &mut Feed) -> Result<Closed, SinkError> {
    loop {
        match feed.next(FLUSH_INTERVAL, |pulse| sink.write(pulse))? {
            Fed::Pulse(()) => {}
            Fed::Idle => sink.flush()?,
            Fed::Ended => return sink.close(),
        }
    }
}
