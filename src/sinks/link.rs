//! The socket of a sink that sends datagrams, and what became of them.

use std::io::{self, ErrorKind};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::time::Duration;

use socket2::SockRef;

use super::sink::SinkError;
use super::vita49::WireReport;

/// Send buffer that is asked for, bytes: the system may give less.
pub(crate) const SEND_BUFFER: usize = 1 << 20;
/// How long one datagram may wait for room in the send buffer. After a wait in vain none waits until one went
/// out.
const SEND_TIMEOUT: Duration = Duration::from_millis(20);
/// What IP and UDP add to a datagram at least, bytes.
const IPV4_UDP: usize = 28;
const IPV6_UDP: usize = 48;

/// How datagrams leave for a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Multicast {
    /// Address of the interface by which they leave.
    pub(super) interface: Ipv4Addr,
    /// Routers that they may pass, plus 1.
    pub(super) ttl: u32,
}

impl Multicast {
    /// A socket whose datagrams leave by the interface, and bear its address.
    fn socket(self) -> Result<UdpSocket, SinkError> {
        let Self { interface, ttl } = self;
        let make = || {
            let socket = UdpSocket::bind((interface, 0))?;
            // Before it is connected: that chooses the way.
            SockRef::from(&socket).set_multicast_if_v4(&interface)?;
            SockRef::from(&socket).set_multicast_ttl_v4(ttl)?;
            Ok(socket)
        };
        make().map_err(|source| SinkError::Interface { interface, source })
    }
}

/// A connected socket.
#[derive(Debug)]
pub(super) struct Link {
    socket: UdpSocket,
    /// Whether the last datagram found no room.
    full: bool,
    report: WireReport,
}

/// The first address that a name has.
pub(super) fn resolve(address: &str) -> Result<SocketAddr, SinkError> {
    let fault = |source| SinkError::Address { address: address.to_owned(), action: "looking it up", source };
    let mut found = address.to_socket_addrs().map_err(fault)?;
    found.next().ok_or_else(|| fault(ErrorKind::NotFound.into()))
}

/// Bytes of a datagram's payload that an MTU allows on the way to an address.
pub(super) fn payload_bytes(mtu_bytes: usize, to: &SocketAddr) -> usize {
    let headers = if to.is_ipv4() { IPV4_UDP } else { IPV6_UDP };
    mtu_bytes.saturating_sub(headers) / 4 * 4
}

impl Link {
    /// Binds and connects; sends nothing.
    pub(super) fn open(
        to: SocketAddr,
        bind: Option<&str>,
        multicast: Option<Multicast>,
    ) -> Result<Self, SinkError> {
        let fault = |action, address: SocketAddr| {
            move |source| SinkError::Address { address: address.to_string(), action, source }
        };
        let socket = match (multicast, bind) {
            (Some(multicast), _) => multicast.socket()?,
            (None, bind) => {
                let from = match bind {
                    Some(bind) => resolve(bind)?,
                    None if to.is_ipv4() => (IpAddr::from(Ipv4Addr::UNSPECIFIED), 0).into(),
                    None => (IpAddr::from(Ipv6Addr::UNSPECIFIED), 0).into(),
                };
                UdpSocket::bind(from).map_err(fault("binding", from))?
            }
        };
        socket.connect(to).map_err(fault("connecting", to))?;
        socket.set_write_timeout(Some(SEND_TIMEOUT)).map_err(fault("setting a time limit", to))?;
        let options = SockRef::from(&socket);
        // A system may give less: what it gave is read below.
        let _ = options.set_send_buffer_size(SEND_BUFFER);
        let report = WireReport {
            address: to.to_string(),
            local: socket.local_addr().map_err(fault("binding", to))?.to_string(),
            send_buffer_bytes: options.send_buffer_size().unwrap_or(0),
            ..WireReport::default()
        };
        Ok(Self { socket, full: false, report })
    }

    pub(super) fn address(&self) -> &str {
        &self.report.address
    }

    /// Gives a datagram to the system, or counts why not.
    pub(super) fn send(&mut self, datagram: &[u8]) {
        let mut sent = self.socket.send(datagram);
        if sent.as_ref().is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused) {
            // The answer to an earlier datagram; this one has not been sent.
            self.report.refused += 1;
            sent = self.socket.send(datagram);
        }
        let full = match sent {
            Ok(_) => {
                self.report.datagrams += 1;
                false
            }
            Err(error) => self.count(&error),
        };
        if full != self.full && self.socket.set_nonblocking(full).is_ok() {
            self.full = full;
        }
    }

    /// Counts a datagram that was not sent; whether for want of room.
    fn count(&mut self, error: &io::Error) -> bool {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                self.report.blocked += 1;
                return true;
            }
            _ if is_no_buffer(error) => self.report.no_buffer += 1,
            _ => self.report.failed += 1,
        }
        false
    }

    /// The counters, with the answer to the last datagram if it is there.
    pub(super) fn finish(&mut self) -> WireReport {
        if matches!(self.socket.take_error(), Ok(Some(error)) if error.kind() == ErrorKind::ConnectionRefused)
        {
            self.report.refused += 1;
        }
        self.report.clone()
    }
}

/// `ENOBUFS`, which has no kind of its own.
fn is_no_buffer(error: &io::Error) -> bool {
    let number = if cfg!(target_os = "linux") {
        105
    } else if cfg!(windows) {
        10055
    } else {
        55
    };
    error.raw_os_error() == Some(number) || error.kind() == ErrorKind::OutOfMemory
}
