//! The socket of a receiver, and when to stop.

use std::fs;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver as Inbox, RecvTimeoutError, Sender, TrySendError, bounded};
use socket2::SockRef;
use thiserror::Error;

use crate::pulse::Pulse;
use crate::sinks::sink::{FLUSH_INTERVAL, Header, Sink, SinkError, SinkReport};

use super::report::Report;
use super::{Outlet, Receiver};

/// Receive buffer that is asked for, bytes: the system may give less.
const RECEIVE_BUFFER: usize = 16 << 20;
/// Greatest datagram of UDP, and one byte to see that it is not longer.
const DATAGRAM: usize = 65_536;
/// How often the end is looked for.
const GLANCE: Duration = Duration::from_millis(50);
/// Whole pulses that may wait to be recorded, and samples that they may have together.
const WAITING: usize = 512;
const WAITING_SAMPLES: usize = 1 << 25;

/// When to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Until {
    /// After so many whole pulses.
    pub pulses: Option<u64>,
    /// After so long.
    pub duration: Option<Duration>,
    /// When nothing has come for so long, once something has.
    pub idle: Option<Duration>,
}

/// Why nothing is received.
#[derive(Debug, Error)]
pub enum ReceiveError {
    /// The address.
    #[error("cannot listen at {address}: {source}; allowed: host:port of this machine with a free port")]
    Listen {
        /// What was asked.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// The sender.
    #[error("--from {address}: {source}; allowed: a name or address, with or without :port")]
    From {
        /// What was asked.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// The socket.
    #[error("receiving at {address}: {source}")]
    Socket {
        /// Where.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// The recording.
    #[error(transparent)]
    Record(#[from] SinkError),
}

/// A bound socket.
#[derive(Debug)]
pub struct Listener {
    socket: UdpSocket,
    address: SocketAddr,
    buffer_bytes: usize,
    drops_before: Option<u64>,
    senders: Senders,
}

/// What to do about senders: whom to hear, and what when one begins again.
#[derive(Default)]
pub struct Senders {
    /// Only these, a port of 0 for any; all, if none is named.
    pub from: Option<Vec<SocketAddr>>,
    /// Whether another run of the sender is followed.
    pub restart: bool,
    /// Where further runs are recorded, by their number from 2.
    pub next: Option<Box<dyn Fn(usize) -> Opener + Send + Sync>>,
    /// Takes what the user should know at once.
    pub notice: Option<fn(&str)>,
}

impl std::fmt::Debug for Senders {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Senders")
            .field("from", &self.from)
            .field("restart", &self.restart)
            .finish_non_exhaustive()
    }
}

impl Senders {
    /// Whether a sender is listened to.
    fn hears(&self, sender: &SocketAddr) -> bool {
        self.from.as_ref().is_none_or(|from| {
            from.iter().any(|one| {
                one.ip().to_canonical() == sender.ip().to_canonical()
                    && (one.port() == 0 || one.port() == sender.port())
            })
        })
    }
}

/// Addresses of a sender: a name or address, with or without a port.
///
/// # Errors
/// What no sender can have.
pub fn senders(text: &str) -> Result<Vec<SocketAddr>, ReceiveError> {
    let found = text.to_socket_addrs().or_else(|_| (text, 0).to_socket_addrs());
    let fault = |source| ReceiveError::From { address: text.to_owned(), source };
    let list: Vec<SocketAddr> = found.map_err(fault)?.collect();
    if list.is_empty() { Err(fault(ErrorKind::NotFound.into())) } else { Ok(list) }
}

/// Makes the sink of a recording when its header is known.
pub type Opener = Box<dyn FnOnce(&Header) -> Result<Box<dyn Sink>, SinkError> + Send>;

/// A recording that is written in a thread of its own, so that the socket is read meanwhile.
struct Recorder {
    pulses: Sender<Box<Pulse>>,
    free: Inbox<Box<Pulse>>,
    /// One past the last pulse that was recorded.
    next: std::cell::Cell<u64>,
    thread: thread::JoinHandle<Result<SinkReport, SinkError>>,
}

impl Recorder {
    fn start(header: &Header, open: Opener) -> Result<Self, SinkError> {
        let mut sink = open(header)?;
        let samples = header.layout.channels.saturating_mul(header.layout.samples).max(1);
        let waiting = (WAITING_SAMPLES / samples).clamp(2, WAITING);
        let (pulses, inbox) = bounded::<Box<Pulse>>(waiting);
        let (give, free) = bounded(waiting);
        let thread = thread::spawn(move || {
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
                    Err(RecvTimeoutError::Disconnected) => return sink.finish(),
                }
            }
        });
        Ok(Self { pulses, free, next: std::cell::Cell::new(0), thread })
    }

    /// Hands a pulse over and takes back one that was written.
    fn record(&self, pulse: Box<Pulse>) -> Option<Box<Pulse>> {
        // Pulses of a recording ascend: those of a stream that went back are counted alone.
        if pulse.index < self.next.get() {
            return Some(pulse);
        }
        self.next.set(pulse.index.saturating_add(1));
        // A recording that failed is told in the end.
        let _ = self.pulses.send(pulse);
        self.free.try_recv().ok()
    }

    fn has_failed(&self) -> bool {
        self.thread.is_finished()
    }

    fn finish(self) -> Result<Option<SinkReport>, SinkError> {
        drop(self.pulses);
        // A panic of the thread has been told by the thread.
        self.thread.join().ok().transpose()
    }
}

/// Datagrams that the system dropped at a local UDP port, by its own table.
fn kernel_drops(address: &SocketAddr) -> Option<u64> {
    let table = if address.is_ipv4() { "/proc/net/udp" } else { "/proc/net/udp6" };
    let text = fs::read_to_string(table).ok()?;
    let port = format!(":{:04X}", address.port());
    let of_port = |line: &&str| line.split_whitespace().nth(1).is_some_and(|local| local.ends_with(&port));
    let drops: Vec<u64> = text
        .lines()
        .filter(of_port)
        .filter_map(|line| line.split_whitespace().last()?.parse().ok())
        .collect();
    // Several sockets of one port cannot be told apart.
    if let [drops] = drops[..] { Some(drops) } else { None }
}

impl Listener {
    /// Binds a socket.
    pub fn bind(address: &str) -> Result<Self, ReceiveError> {
        let fault = |source| ReceiveError::Listen { address: address.to_owned(), source };
        let mut found = address.to_socket_addrs().map_err(fault)?;
        let to = found.next().ok_or_else(|| fault(ErrorKind::NotFound.into()))?;
        let socket = UdpSocket::bind(to).map_err(fault)?;
        let options = SockRef::from(&socket);
        // A system that gives less says so below.
        let _ = options.set_recv_buffer_size(RECEIVE_BUFFER);
        let buffer_bytes = options.recv_buffer_size().unwrap_or(0);
        socket.set_read_timeout(Some(GLANCE)).map_err(fault)?;
        let address = socket.local_addr().map_err(fault)?;
        let drops_before = kernel_drops(&address);
        Ok(Self { socket, address, buffer_bytes, drops_before, senders: Senders::default() })
    }

    /// With what to do about senders.
    pub fn with(self, senders: Senders) -> Self {
        Self { senders, ..self }
    }

    /// Where it listens; the port is that of the system if 0 was asked.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Room for datagrams that wait to be read, bytes.
    pub fn buffer_bytes(&self) -> usize {
        self.buffer_bytes
    }

    /// Receives until the end that was asked for, or until `stop` is set. Whole pulses go to the recording, if there is
    /// one, and to `see`.
    pub fn receive(
        &self,
        until: Until,
        stop: &AtomicBool,
        mut record: Option<Opener>,
        mut see: impl FnMut(&Pulse),
    ) -> Result<Report, ReceiveError> {
        let mut receiver = if self.senders.restart { Receiver::following() } else { Receiver::new() };
        let (mut strangers, mut restarts, mut runs, mut files) = (0, 0, 0, Vec::new());
        let recorded = record.is_some();
        let mut recorder: Option<Recorder> = None;
        let mut datagram = vec![0; DATAGRAM];
        let begun = Instant::now();
        let mut last: Option<Instant> = None;
        while !stop.load(Ordering::Acquire) {
            if until.pulses.is_some_and(|pulses| receiver.pulses() >= pulses)
                || until.duration.is_some_and(|duration| begun.elapsed() >= duration)
                || until.idle.zip(last).is_some_and(|(idle, last)| last.elapsed() >= idle)
                || recorder.as_ref().is_some_and(Recorder::has_failed)
            {
                break;
            }
            match self.socket.recv_from(&mut datagram) {
                Ok((_, sender)) if !self.senders.hears(&sender) => strangers += 1,
                Ok((length, _)) => {
                    let arrival = Instant::now();
                    last = Some(arrival);
                    let packet = datagram.get(..length).unwrap_or(&[]);
                    receiver.take(packet, arrival, &mut outlet(recorder.as_ref(), &mut see));
                    if receiver.restarts() > restarts {
                        restarts = receiver.restarts();
                        self.say_restarted();
                    }
                    if receiver.runs_before() > runs {
                        runs = receiver.runs_before();
                        if let Some(done) = recorder.take() {
                            files.extend(self.recorded(done.finish()?));
                        }
                        record = self.senders.next.as_ref().filter(|_| recorded).map(|next| next(runs + 1));
                    }
                    if let (Some(header), true) = (receiver.header(), record.is_some())
                        && let Some(open) = record.take()
                    {
                        recorder = Some(Recorder::start(header, open)?);
                    }
                }
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {}
                    // An answer to something that another program sent from this port.
                    ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset => {}
                    _ => {
                        return Err(ReceiveError::Socket {
                            address: self.address.to_string(),
                            source: error,
                        });
                    }
                },
            }
        }
        let mut report = receiver.finish(&mut outlet(recorder.as_ref(), &mut see));
        if let Some(recorder) = recorder {
            files.extend(self.recorded(recorder.finish()?));
        }
        report.out = files;
        report.strangers = strangers;
        report.listen = self.address.to_string();
        report.receive_buffer_bytes = self.buffer_bytes;
        let now = kernel_drops(&self.address);
        report.kernel_drops = now.zip(self.drops_before).map(|(now, before)| now.saturating_sub(before));
        Ok(report)
    }
}

impl Listener {
    /// The files of a recording that has ended; reports what did not become of it.
    fn recorded(&self, done: Option<SinkReport>) -> Vec<PathBuf> {
        let Some(done) = done else { return Vec::new() };
        if let Some(notice) = self.senders.notice {
            done.notes().iter().for_each(|note| notice(note));
        }
        done.files
    }

    /// Reports that the sender began again.
    fn say_restarted(&self) {
        let what =
            if self.senders.restart { "it is followed" } else { "not followed (--restart follows it)" };
        if let Some(notice) = self.senders.notice {
            notice(&format!("the sender began another run, or the same one again: {what}"));
        }
    }
}

/// Where whole pulses go.
fn outlet<'a>(recorder: Option<&'a Recorder>, see: &'a mut impl FnMut(&Pulse)) -> impl Outlet + 'a {
    move |pulse: Box<Pulse>| {
        see(&pulse);
        match recorder {
            Some(recorder) => recorder.record(pulse),
            None => Some(pulse),
        }
    }
}
