//! A recording from elsewhere is read by a process of its own first.
//!
//! The HDF5 library is written in C, and its authors do not promise that a forged file does no harm. So
//! `focus`, `merge` and `ppi` have an HDF5 recording read to the end by this program in a second process
//! (`nereus examine-recording FILE`), with limits of memory and of time. Only what that process survived is
//! read again, by the same functions, in this one. docs/decisions/0041-hostile-files.md has the reasons.

use std::ffi::OsString;
use std::io::{self, Read};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::thread;
use std::time::{Duration, Instant};

#[cfg(feature = "hdf5")]
use super::RecordingError;
use crate::inputs::shown;

/// Why a recording is not read.
#[derive(Debug, thiserror::Error)]
pub enum ExaminationError {
    /// It is wrong, as the process that read it reports.
    #[error("{message}")]
    Refused {
        /// Its report.
        message: String,
    },
    /// The process did not come to an end by itself.
    #[error(
        "{path}: not read: {how} when it was examined in a process of its own; the file is damaged or was forged; \
         allowed: recordings of nereus as they were written"
    )]
    Fatal {
        /// The recording.
        path: String,
        /// How it ended.
        how: String,
    },
    /// There is no such process.
    #[error("{path}: cannot be examined in a process of its own: {source}")]
    Process {
        /// The recording.
        path: String,
        /// The system's error.
        source: io::Error,
    },
}

/// Memory of the second process, bytes: far above what a reader of blocks needs.
#[cfg(all(feature = "hdf5", unix))]
const MEMORY: u64 = 2 << 30;
/// Time that any file may take, and what longer ones may take beyond it.
const LEAST_S: u64 = 3;
const BYTES_PER_S: u64 = 20 << 20;
/// Longest wait between two looks at the process.
const GLANCE: Duration = Duration::from_millis(20);
/// Most of its message that is passed on, bytes.
const MESSAGE: u64 = 16 << 10;

/// Seconds that a file of this length may take.
fn seconds(bytes: u64) -> u64 {
    LEAST_S.saturating_add(bytes / BYTES_PER_S)
}

/// How this program is called, where it lives in another one.
static PROGRAM: OnceLock<Vec<OsString>> = OnceLock::new();

/// Says how a process that is not `nereus` itself calls the program: its file, and what stands before the
/// subcommand. The first call holds.
pub fn called_by(program: Vec<OsString>) {
    let _ = PROGRAM.set(program);
}

/// The program itself, also where its file was replaced meanwhile.
fn program() -> io::Result<Command> {
    match PROGRAM.get().and_then(|words| words.split_first()) {
        Some((program, before)) => {
            let mut command = Command::new(program);
            command.args(before);
            Ok(command)
        }
        None if cfg!(target_os = "linux") => Ok(Command::new("/proc/self/exe")),
        None => std::env::current_exe().map(Command::new),
    }
}

/// Has an HDF5 file read in a process of its own; what is none is left to who reads it.
///
/// # Errors
/// A file that is not read: what is wrong with it, or how the process ended.
pub(crate) fn examine(path: &Path) -> Result<(), ExaminationError> {
    let length = match std::fs::metadata(path) {
        Ok(data) if data.is_file() && cfg!(feature = "hdf5") => data.len(),
        _ => return Ok(()),
    };
    let shown = || shown(path);
    let failed = |source| ExaminationError::Process { path: shown(), source };
    let child = program()
        .map_err(failed)?
        .arg("examine-recording")
        .arg("--")
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    let fatal = |how: String| ExaminationError::Fatal { path: shown(), how };
    let limit = Duration::from_secs(seconds(length).saturating_mul(4));
    let Some((status, words)) = listen(child, limit).map_err(failed)? else {
        return Err(fatal(format!("nothing came of it within {} s", limit.as_secs())));
    };
    if status.success() {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&words);
    match (status.code(), words.trim().strip_prefix("error: ")) {
        (Some(1 | 2), Some(message)) => Err(ExaminationError::Refused { message: message.to_owned() }),
        _ => Err(fatal(format!("the reader ended with {status}"))),
    }
}

/// How a process ended and the first of what it reported; `None`, and its end, when it takes longer than it
/// may.
fn listen(mut child: Child, limit: Duration) -> io::Result<Option<(ExitStatus, Vec<u8>)>> {
    let errors = child.stderr.take();
    // A full pipe would hold up the process, so all of it is read while it runs. What is lost of a message is
    // no reason to read the file.
    let reader = thread::Builder::new().spawn(move || {
        let mut words = Vec::new();
        if let Some(mut errors) = errors {
            let _ = errors.by_ref().take(MESSAGE).read_to_end(&mut words);
            let _ = io::copy(&mut errors, &mut io::sink());
        }
        words
    });
    let reader = match reader {
        Ok(reader) => reader,
        Err(error) => {
            child.kill()?;
            child.wait()?;
            return Err(error);
        }
    };
    Ok(wait(&mut child, limit)?.map(|status| (status, reader.join().unwrap_or_default())))
}

/// How a process ended; `None`, and its end, when it takes longer than it may.
fn wait(child: &mut Child, limit: Duration) -> io::Result<Option<ExitStatus>> {
    let begun = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() >= limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(pause);
        pause = (pause * 2).min(GLANCE);
    }
}

/// Refuses a file that kills or holds up its reader; damage is left to the caller.
///
/// # Errors
/// A file that its reader did not survive.
pub(crate) fn refuse_fatal(path: &Path) -> Result<(), ExaminationError> {
    match examine(path) {
        Ok(()) | Err(ExaminationError::Refused { .. }) => Ok(()),
        Err(fatal) => Err(fatal),
    }
}

/// The second process: reads everything under limits, and keeps nothing.
///
/// # Errors
/// What is wrong with the recording.
#[cfg(feature = "hdf5")]
pub(crate) fn read_under_limits(recording: &Path) -> Result<(), RecordingError> {
    let length = std::fs::metadata(recording).map_or(0, |data| data.len());
    limit(length);
    super::hdf5::read_through(recording).map(drop)
}

/// Limits of this process. A system that refuses one goes without: the other process watches the time.
#[cfg(all(feature = "hdf5", unix))]
fn limit(length: u64) {
    use nix::sys::resource::{Resource, setrlimit};
    for (resource, most) in
        [(Resource::RLIMIT_AS, MEMORY), (Resource::RLIMIT_CPU, seconds(length)), (Resource::RLIMIT_CORE, 0)]
    {
        let _ = setrlimit(resource, most, most);
    }
}

#[cfg(all(feature = "hdf5", not(unix)))]
fn limit(_length: u64) {}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Before: a message longer than the pipe (64 KiB) was never read, and its process counted as hung.
    #[test]
    fn a_long_message_holds_up_nobody() {
        let child = Command::new("sh")
            .args(["-c", "printf 'error: ' >&2; head -c 300000 /dev/zero | tr '\\0' x >&2; exit 2"])
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (status, words) = listen(child, Duration::from_secs(20)).unwrap().expect("it ends by itself");
        assert_eq!((status.code(), words.len()), (Some(2), MESSAGE as usize));
        assert!(words.starts_with(b"error: xxx"));
    }
}
