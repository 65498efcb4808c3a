//! Recorded navigation sent on: written to a file, or played to a port at its own pace.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::files::{self, Draft, FileFault, Holding, Recognised};
use crate::inputs::{self, shown};
use crate::nav::encode::{Format, Unwritable};
use crate::nav::solution::Solution;
use crate::sinks::port::{self, Device, Port, PortCounts, PortFault};

/// How long the last bytes may take.
const LAST_BYTES: Duration = Duration::from_secs(2);

/// Why navigation is not sent on.
#[derive(Debug, Error)]
pub enum PlaybackError {
    /// A state that the format cannot hold.
    #[error(transparent)]
    Unwritable(#[from] Unwritable),
    /// The output cannot be made.
    #[error(transparent)]
    Output(#[from] FileFault),
    /// The output cannot be written.
    #[error("{}: cannot write: {source}", shown(path))]
    Write {
        /// The output.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A device that cannot be opened, or does not take the messages.
    #[error("{device}: {action}: {source}")]
    Port {
        /// The device.
        device: String,
        /// What was tried.
        action: &'static str,
        /// The system's error.
        source: io::Error,
    },
}

impl PlaybackError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Unwritable(_) => true,
            Self::Output(FileFault::Io { .. }) | Self::Write { .. } | Self::Port { .. } => false,
            Self::Output(fault) => fault.is_wrong_input(),
        }
    }
}

/// Makes a file; one that exists is replaced only by force, and only if it begins like navigation.
///
/// # Errors
/// A file that may not be replaced, and what the system refuses.
pub fn write_file(path: &Path, force: bool, bytes: &[u8]) -> Result<(), PlaybackError> {
    let fault = |source| PlaybackError::Write { path: path.to_owned(), source };
    // A pipe or a device is written as it is.
    if force && std::fs::metadata(path).is_ok_and(|data| !(data.is_file() || data.is_dir())) {
        let opened = std::fs::OpenOptions::new().write(true).open(path);
        return opened.and_then(|mut file| file.write_all(bytes)).map_err(fault);
    }
    files::preflight(path, force, &recognise)?;
    let (draft, mut file) = Draft::file(path)?;
    if let Err(source) = file.write_all(bytes) {
        draft.abandon();
        return Err(fault(source));
    }
    Ok(draft.finish(force, &recognise).map(|_| ())?)
}

/// Messages, or a table of states.
fn recognise(path: &Path) -> Recognised {
    let is_table = inputs::beginning(path, 15).is_some_and(|start| start == b"unix_s,lat_deg,");
    if is_table { Ok(Holding::File) } else { port::recognise(path) }
}

/// What was sent to a port.
pub struct Played {
    /// Messages and losses.
    pub counts: PortCounts,
    /// From the opened port to its last byte.
    pub lasted: Duration,
}

/// Sends states to a port, every one at its time after the first, `rate` times as fast. A file that exists is
/// replaced only by force.
///
/// # Errors
/// A state that the format cannot hold, a port that cannot be opened or does not take the messages.
pub fn play(
    solutions: &[Solution],
    format: &Format,
    device: &Device,
    rate: f64,
    force: bool,
) -> Result<Played, PlaybackError> {
    let mut message = Vec::new();
    // What cannot be reported is known before the port is opened.
    for (number, solution) in (1..).zip(solutions) {
        message.clear();
        format.write(solution, &mut message).map_err(|source| Unwritable::of(number, solution, source))?;
    }
    let failed = |action| move |source| PlaybackError::Port { device: device.to_string(), action, source };
    let fault = |action| {
        move |fault| match fault {
            PortFault::System(source) => failed(action)(source),
            PortFault::File(fault) => PlaybackError::Output(fault),
        }
    };
    let mut port = Port::open(device.clone(), force).map_err(fault("cannot open the port"))?;
    let begun = Instant::now();
    for solution in solutions {
        let due = Duration::from_secs_f64(solution.time.since(solutions[0].time).max(0.0) / rate);
        thread::sleep(due.saturating_sub(begun.elapsed()));
        message.clear();
        if format.write(solution, &mut message).is_ok() {
            port.send(&message);
        }
        if port.failed() {
            break;
        }
    }
    if let Some(source) = port.fault() {
        return Err(failed("writing")(source));
    }
    let counts = port.finish(LAST_BYTES).map_err(fault("writing"))?;
    Ok(Played { counts, lasted: begun.elapsed() })
}
