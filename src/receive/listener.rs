//! The socket of a receiver, and when to stop.

use std::fs;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use socket2::SockRef;
use thiserror::Error;

use crate::pulse::Pulse;
use crate::sinks::sink::SinkError;

use super::recording::Recordings;
use super::report::Report;
use super::{Outlet, Receiver};

pub use super::recording::Opener;

/// Receive buffer that is asked for, bytes: the system may give less.
pub(crate) const RECEIVE_BUFFER: usize = 16 << 20;
/// Greatest datagram of UDP, and one byte to see that it is not longer.
const DATAGRAM: usize = 65_536;
/// How often the end is looked for.
const GLANCE: Duration = Duration::from_millis(50);
/// Restarts that are reported one by one: whoever can begin runs does not fill a log.
const NOTICES: u64 = 20;

/// When to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Until {
    /// After so many whole pulses.
    pub pulses: Option<u64>,
    /// After so long.
    pub duration: Option<Duration>,
    /// When nothing of a run has come for so long, once something has.
    pub idle: Option<Duration>,
}

/// Why nothing is received.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReceiveError {
    /// The address.
    #[error("cannot listen at {address}: {source}; allowed: host:port of this machine with a free port")]
    Listen {
        /// What was asked.
        address: String,
        /// What the system reported.
        source: io::Error,
    },
    /// The sender.
    #[error("--from {address}: {source}; allowed: a name or address, with or without :port")]
    From {
        /// What was asked.
        address: String,
        /// What the system reported.
        source: io::Error,
    },
    /// The socket.
    #[error("receiving at {address}: {source}")]
    Socket {
        /// Where.
        address: String,
        /// What the system reported.
        source: io::Error,
    },
    /// The recording.
    #[error(transparent)]
    Record(#[from] SinkError),
}

impl ReceiveError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            // A full disk is not wrong input, nor is a socket that breaks.
            Self::Record(error) => error.is_wrong_input(),
            Self::Socket { .. } => false,
            Self::Listen { .. } | Self::From { .. } => true,
        }
    }
}

/// A reception that was to go on: what was received until then, and why it ended.
#[derive(Debug, Error)]
#[error("{error}")]
pub struct Interrupted {
    /// The report until then.
    pub report: Report,
    /// Why it ended.
    #[source]
    pub error: ReceiveError,
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

/// What to do about senders: whose datagrams are taken, and what when one begins again.
#[derive(Default)]
pub struct Senders {
    /// Only these, a port of 0 for any; all, if none is named.
    pub from: Option<Vec<SocketAddr>>,
    /// Whether another run of the sender is followed.
    pub restart: bool,
    /// Where further runs are recorded, by their number from 2.
    pub next: Option<Box<dyn Fn(usize) -> Opener + Send + Sync>>,
    /// Recordings of an earlier reception that are removed when this one has ended well, where it makes none
    /// of its own.
    pub older: Vec<PathBuf>,
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
    fn accepts(&self, sender: &SocketAddr) -> bool {
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
    // Several sockets of one port cannot be distinguished.
    if let [drops] = drops[..] { Some(drops) } else { None }
}

impl Listener {
    /// Binds a socket.
    ///
    /// # Errors
    /// An address at which the system does not let it listen.
    pub fn bind(address: &str) -> Result<Self, ReceiveError> {
        let fault = |source| ReceiveError::Listen { address: address.to_owned(), source };
        let mut found = address.to_socket_addrs().map_err(fault)?;
        let to = found.next().ok_or_else(|| fault(ErrorKind::NotFound.into()))?;
        let socket = UdpSocket::bind(to).map_err(fault)?;
        let options = SockRef::from(&socket);
        // A system may give less: what it gave is read below.
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

    /// Receives until the end that was asked for, or until `stop` is set. Whole pulses go to the recording,
    /// if there is one, and to `see`.
    ///
    /// # Errors
    /// What ended the reception or the recording early, with the report until then.
    pub fn receive(
        &self,
        until: Until,
        stop: &AtomicBool,
        record: Option<Opener>,
        mut see: impl FnMut(&Pulse),
    ) -> Result<Report, Box<Interrupted>> {
        self.receive_into(until, stop, record, &mut see)
    }

    fn receive_into(
        &self,
        until: Until,
        stop: &AtomicBool,
        record: Option<Opener>,
        see: &mut dyn FnMut(&Pulse),
    ) -> Result<Report, Box<Interrupted>> {
        let mut receiver = if self.senders.restart { Receiver::following() } else { Receiver::new() };
        let (mut strangers, mut restarts, mut runs, mut known) = (0u64, 0, 0, 0);
        let recorded = record.is_some();
        let mut recordings = Recordings::replacing(self.senders.older.clone());
        recordings.begin(record);
        let mut fault = None;
        let mut datagram = vec![0; DATAGRAM];
        let begun = Instant::now();
        let mut last: Option<Instant> = None;
        while !stop.load(Ordering::Acquire) {
            if until.pulses.is_some_and(|pulses| receiver.pulses() >= pulses)
                || until.duration.is_some_and(|duration| begun.elapsed() >= duration)
                || until.idle.zip(last).is_some_and(|(idle, last)| last.elapsed() >= idle)
                || recordings.has_failed()
            {
                break;
            }
            match self.socket.recv_from(&mut datagram) {
                Ok((_, sender)) if !self.senders.accepts(&sender) => strangers = strangers.saturating_add(1),
                Ok((length, _)) => {
                    let (arrival, refused) = (Instant::now(), receiver.refused());
                    let packet = datagram.get(..length).unwrap_or(&[]);
                    receiver.take(packet, arrival, &mut outlet(&mut recordings, see));
                    // Who sends nonsense does not keep a reception from its end.
                    if receiver.refused() == refused {
                        last = Some(arrival);
                    }
                    if receiver.restarts() > restarts {
                        restarts = receiver.restarts();
                        self.say_restarted(restarts);
                    }
                    if receiver.runs_before() > runs {
                        runs = receiver.runs_before();
                        let next = self.senders.next.as_ref().filter(|_| recorded);
                        recordings.begin(next.map(|next| next(runs + 1)));
                    }
                    if let Some(header) = receiver.header().filter(|_| receiver.times_known() > known) {
                        known = receiver.times_known();
                        recordings.describe(header);
                    }
                }
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {}
                    // An answer to something that another program sent from this port.
                    ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset => {}
                    _ => {
                        let address = self.address.to_string();
                        fault = Some(ReceiveError::Socket { address, source: error });
                        break;
                    }
                },
            }
        }
        let mut report = receiver.finish(&mut outlet(&mut recordings, see));
        let done = recordings.finish(fault.is_none());
        if let Some(notice) = self.senders.notice {
            done.notes.iter().for_each(|note| notice(note));
        }
        (report.out, report.kept, report.gone) = (done.files, done.kept, done.gone);
        report.recorded = recorded.then_some(done.pulses);
        report.strangers = strangers;
        report.listen = self.address.to_string();
        report.receive_buffer_bytes = self.buffer_bytes;
        let now = kernel_drops(&self.address);
        report.kernel_drops = now.zip(self.drops_before).map(|(now, before)| now.saturating_sub(before));
        match fault.or(done.fault.map(ReceiveError::Record)) {
            None => Ok(report),
            Some(error) => {
                report.error = Some(error.to_string());
                Err(Box::new(Interrupted { report, error }))
            }
        }
    }

    /// Reports that the sender restarted; not for ever.
    fn say_restarted(&self, times: u64) {
        let Some(notice) = self.senders.notice.filter(|_| times <= NOTICES) else { return };
        let what =
            if self.senders.restart { "it is followed" } else { "not followed (--restart follows it)" };
        notice(&format!("the sender began another run, or the same one again: {what}"));
        if times == NOTICES {
            notice(&format!("the sender has restarted {NOTICES} times; further restarts are only counted"));
        }
    }
}

/// Where whole pulses go.
fn outlet<'a>(recordings: &'a mut Recordings, see: &'a mut dyn FnMut(&Pulse)) -> impl Outlet + 'a {
    move |pulse: Box<Pulse>| {
        see(&pulse);
        recordings.take(pulse)
    }
}
