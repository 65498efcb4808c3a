//! Lines of text that change a run while it goes on: `nereus run --control`.
//!
//! A line is a command and gets one line in answer, `ok ...` or `error ...: allowed: ...` (docs/control.md).
//! Lines come from clients of a Unix socket or from standard input. Every client has a thread of its own;
//! none of them is waited for by the stream.

use std::io::{self, BufRead, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use thiserror::Error;

use super::control::Control;
use crate::inputs::shown;

#[cfg(unix)]
pub mod socket;

/// Longest line, bytes, without its end.
pub const LONGEST_LINE: usize = 256;
/// Longest path of a socket, bytes: what systems allow, less the folder in which it is made.
#[cfg(unix)]
const LONGEST_PATH: usize = 90;

const HELP: &str = "ok step AXIS VALUE UNIT; bias AXIS VALUE UNIT; ramp AXIS VALUE UNIT/s; dropout SECONDS s; latency MS ms; clear; \
                    each with on PLATFORM behind it where there are several; status; stop; help";

/// Why there is no control.
#[derive(Debug, Error)]
pub enum ControlFault {
    /// A path that no socket can have.
    #[error("--control {}: {bytes} bytes; allowed: a path of 1 to 90 bytes, or - for standard input", path.display())]
    TooLong {
        /// As given.
        path: PathBuf,
        /// Its length.
        bytes: usize,
    },
    /// Another run listens there.
    #[error("--control {}: another run listens there; allowed: a path of its own for every run", path.display())]
    InUse {
        /// As given.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("--control {}: exists and is no socket; allowed: a path where nothing is, or a socket that a run has left", path.display())]
    NotASocket {
        /// As given.
        path: PathBuf,
    },
    /// The system refuses.
    #[error("--control {}: {action}: {source}; allowed: a path in a folder that may be written", path.display())]
    Io {
        /// As given.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// There are no such sockets here.
    #[cfg(not(unix))]
    #[error("--control {}: this system has no Unix sockets; allowed: - for standard input", path.display())]
    NoSockets {
        /// As given.
        path: PathBuf,
    },
}

/// What lines are about.
#[derive(Clone)]
pub struct Subject {
    /// The run that is changed.
    pub control: Control,
    /// Set by `stop`.
    pub stop: Arc<AtomicBool>,
}

/// Where lines come from, made ready before the run is built.
pub enum ControlSocket {
    /// Standard input.
    Input,
    /// A Unix socket.
    #[cfg(unix)]
    Socket(socket::Socket),
}

/// Lines are answered until this is closed.
pub enum Open {
    /// Standard input.
    Input,
    /// A Unix socket.
    #[cfg(unix)]
    Socket(socket::Listening),
}

impl ControlSocket {
    /// At a path, or `-`.
    ///
    /// # Errors
    /// A path that no socket can have, or where something else is.
    pub fn at(path: &Path) -> Result<Self, ControlFault> {
        if path == Path::new("-") {
            return Ok(Self::Input);
        }
        #[cfg(unix)]
        return socket::Socket::make(path).map(Self::Socket);
        #[cfg(not(unix))]
        Err(ControlFault::NoSockets { path: path.to_owned() })
    }

    /// Answers lines from now on; `say` takes the answers to lines of standard input.
    pub fn open(self, subject: Subject, say: fn(String)) -> Open {
        match self {
            Self::Input => {
                // Ends with the program: nobody can be made to end a line.
                let read = move || converse(&mut io::stdin().lock(), &subject, say);
                let _ = thread::Builder::new().name("control".to_owned()).spawn(read);
                Open::Input
            }
            #[cfg(unix)]
            Self::Socket(socket) => Open::Socket(socket.listen(subject)),
        }
    }
}

impl Open {
    /// Answers nothing any more; a socket is removed.
    pub fn close(self) {
        match self {
            Self::Input => {}
            #[cfg(unix)]
            Self::Socket(listening) => listening.close(),
        }
    }
}

/// The answer to a line.
fn answer(line: &[u8], subject: &Subject) -> String {
    let text = String::from_utf8_lossy(line);
    let text = text.trim();
    match text {
        "help" => HELP.to_owned(),
        "status" => {
            let counts = subject.control.counts();
            format!(
                "ok released {} late {} dropped {} made {} of {}",
                counts.released, counts.late, counts.dropped, counts.made, counts.total
            )
        }
        "stop" => {
            subject.stop.store(true, Ordering::Release);
            "ok stopping".to_owned()
        }
        _ => match subject.control.line(text) {
            Ok((pulse, change)) => format!("ok pulse {pulse} {change}"),
            Err(error) => format!("error {error}"),
        },
    }
}

/// Lines as they come, of bounded length.
#[derive(Default)]
struct Lines {
    held: Vec<u8>,
    /// What is left of a line that was too long is not looked at.
    skipping: bool,
}

impl Lines {
    /// Takes bytes and hands over every line that they end.
    fn take(&mut self, bytes: &[u8], mut line: impl FnMut(Result<&[u8], ()>)) {
        for &byte in bytes {
            if byte == b'\n' {
                line(if std::mem::take(&mut self.skipping) { Err(()) } else { Ok(&self.held) });
                self.held.clear();
            } else if self.held.len() < LONGEST_LINE {
                self.held.push(byte);
            } else if byte != b'\r' {
                self.skipping = true;
            }
        }
    }
}

/// Answers the lines in some bytes.
fn answers(lines: &mut Lines, bytes: &[u8], subject: &Subject, mut send: impl FnMut(String)) {
    lines.take(bytes, |line| {
        send(match line {
            Ok(line) => answer(line, subject),
            Err(()) => {
                format!("error a line of more than {LONGEST_LINE} bytes: allowed: at most so many")
            }
        });
    });
}

/// Answers lines until their source ends.
fn converse(source: &mut impl BufRead, subject: &Subject, mut send: impl FnMut(String)) {
    let mut lines = Lines::default();
    loop {
        let count = match source.fill_buf() {
            Ok([]) => return,
            Ok(bytes) => {
                answers(&mut lines, bytes, subject, &mut send);
                bytes.len()
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => 0,
            Err(_) => return,
        };
        source.consume(count);
    }
}

/// How long an answer is waited for.
#[cfg(unix)]
const ANSWER: std::time::Duration = std::time::Duration::from_secs(10);

/// Why a run does not do what a line asks.
#[derive(Debug, Error)]
pub enum LineError {
    /// A line that no run takes.
    #[error("a line of {bytes} bytes; allowed: at most {LONGEST_LINE}, without control characters")]
    Line {
        /// Its length.
        bytes: usize,
    },
    /// No run answers.
    #[error("{}: {source}; allowed: the socket of a run under way (nereus run --control)", shown(path))]
    Silent {
        /// The socket.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The run does not take the line.
    #[error("{answer}")]
    Refused {
        /// Why.
        answer: String,
    },
}

impl LineError {
    /// Whether the line itself is wrong.
    pub fn is_wrong_input(&self) -> bool {
        matches!(self, Self::Line { .. })
    }
}

/// Has a run do what a line asks, and returns its answer.
///
/// # Errors
/// A line that no run takes, no answer, or why the run does not do it.
pub fn command(path: &Path, line: &str) -> Result<String, LineError> {
    if line.len() > LONGEST_LINE || line.contains(char::is_control) {
        return Err(LineError::Line { bytes: line.len() });
    }
    let answer = ask(path, line).map_err(|source| LineError::Silent { path: path.to_owned(), source })?;
    match answer.strip_prefix("error ") {
        Some(why) => Err(LineError::Refused { answer: why.to_owned() }),
        None => Ok(answer),
    }
}

/// Sends a line to a run and returns its answer.
///
/// # Errors
/// Nobody listens there, or answers in time.
#[cfg(unix)]
fn ask(path: &Path, line: &str) -> io::Result<String> {
    let mut stream = std::os::unix::net::UnixStream::connect(path)?;
    stream.set_read_timeout(Some(ANSWER))?;
    // Who turns a client away says why before the line can be sent.
    let sent = stream.write_all(format!("{line}\n").as_bytes());
    let mut text = String::new();
    match io::BufReader::new(stream.take(1 << 16)).read_line(&mut text) {
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
            let why = "no answer within 10 s: the run is not ready yet, or busy; ask again";
            return Err(io::Error::new(io::ErrorKind::TimedOut, why));
        }
        Err(error) => return Err(error),
        Ok(_) if text.is_empty() => sent?,
        Ok(_) => {}
    }
    match text.strip_suffix('\n') {
        Some(answer) => Ok(answer.to_owned()),
        None => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the run ended before it answered")),
    }
}

/// Sends a line to a run and returns its answer.
///
/// # Errors
/// Nobody listens there, or answers in time.
#[cfg(not(unix))]
fn ask(_: &Path, _: &str) -> io::Result<String> {
    Err(io::ErrorKind::Unsupported.into())
}
