//! Lines on which navigation comes: serial ports and sockets, opened again when they vanish.
//!
//! A [`Line`] never waits longer than [`READ_TIMEOUT`] for bytes, so that whoever reads it can be stopped. A
//! device that vanishes, a connection that ends, are opened again, at most twice per second. Of those who
//! connect one is received, others are turned away; one that is silent because its machine is gone is noticed
//! after some 10 s (TCP keep-alive).

use std::io::{self, ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::thread;
use std::time::{Duration, Instant};

use socket2::{Domain, Protocol, SockRef, Socket, TcpKeepalive, Type};

use super::Origin;

/// How long bytes are waited for.
pub(super) const READ_TIMEOUT: Duration = Duration::from_millis(40);
/// Time between attempts to open a line again.
const REOPEN: Duration = Duration::from_millis(500);
/// How long the answer of somebody who listens is waited for.
const CONNECT: Duration = Duration::from_secs(2);
/// From one check to the next whether anybody has connected.
const LOOK: Duration = Duration::from_millis(10);
/// Silence after which a connection is asked whether it is alive, and time between questions.
const ALIVE: [Duration; 2] = [Duration::from_secs(5), Duration::from_secs(1)];

/// What reading a line brought.
pub(super) enum Received {
    /// So many bytes.
    Bytes(usize),
    /// Nothing yet.
    Nothing,
    /// The line is open from now on.
    Opened,
    /// It is no more.
    Vanished,
}

/// Something that is read.
enum Link {
    Stream(Box<dyn Read + Send>),
    Datagrams(UdpSocket),
}

/// A line.
pub(super) struct Line {
    origin: Origin,
    listener: Option<TcpListener>,
    link: Option<Link>,
    tried: Option<Instant>,
    /// Others who wanted to connect.
    refused: u64,
}

impl Line {
    /// Opens the line; of somebody to connect to, nothing is asked yet.
    pub(super) fn open(origin: &Origin) -> io::Result<Self> {
        let mut line = Self { origin: origin.clone(), listener: None, link: None, tried: None, refused: 0 };
        match origin {
            Origin::Serial { path, baud } => line.link = Some(Link::Stream(serial(path, *baud)?)),
            Origin::TcpListen(address) => {
                let listener = TcpListener::bind(address)?;
                listener.set_nonblocking(true)?;
                line.listener = Some(listener);
            }
            Origin::Udp(address) => line.link = Some(Link::Datagrams(datagrams(*address)?)),
            Origin::TcpConnect(_) | Origin::File(_) => {}
        }
        Ok(line)
    }

    pub(super) fn is_open(&self) -> bool {
        self.link.is_some()
    }

    pub(super) fn refused(&self) -> u64 {
        self.refused
    }

    /// Waits a little for bytes, or for the line. `stop` is asked while an answer is waited for.
    pub(super) fn read(&mut self, buffer: &mut [u8], stop: &dyn Fn() -> bool) -> Received {
        self.turn_away();
        let Some(link) = &mut self.link else { return self.reopen(stop) };
        let read = match link {
            Link::Stream(stream) => stream.read(buffer),
            // An empty datagram is no end.
            Link::Datagrams(socket) => match socket.recv(buffer) {
                Ok(0) => return Received::Nothing,
                other => other,
            },
        };
        match read {
            Ok(0) => self.vanish(),
            Ok(bytes) => Received::Bytes(bytes),
            Err(error) => match error.kind() {
                ErrorKind::Interrupted | ErrorKind::WouldBlock | ErrorKind::TimedOut => Received::Nothing,
                _ => self.vanish(),
            },
        }
    }

    fn vanish(&mut self) -> Received {
        self.link = None;
        self.tried = Some(Instant::now());
        Received::Vanished
    }

    /// Those who connect while somebody is received.
    fn turn_away(&mut self) {
        if let (Some(listener), Some(_)) = (&self.listener, &self.link)
            && listener.accept().is_ok()
        {
            self.refused += 1;
        }
    }

    fn reopen(&mut self, stop: &dyn Fn() -> bool) -> Received {
        if let Some(listener) = &self.listener {
            self.link = listener.accept().and_then(|(stream, _)| connected(stream)).ok();
            if self.link.is_none() {
                thread::sleep(LOOK);
            }
        } else if self.tried.is_some_and(|tried| tried.elapsed() < REOPEN) {
            thread::sleep(LOOK);
        } else {
            self.tried = Some(Instant::now());
            self.link = match &self.origin {
                Origin::Serial { path, baud } => serial(path, *baud).map(Link::Stream).ok(),
                Origin::TcpConnect(address) => connect(*address, stop).and_then(connected).ok(),
                Origin::Udp(address) => datagrams(*address).map(Link::Datagrams).ok(),
                Origin::TcpListen(_) | Origin::File(_) => None,
            };
        }
        if self.link.is_some() { Received::Opened } else { Received::Nothing }
    }
}

/// Connects without being held up by those who do not answer.
fn connect(address: SocketAddr, stop: &dyn Fn() -> bool) -> io::Result<TcpStream> {
    let socket = Socket::new(Domain::for_address(address), Type::STREAM, Some(Protocol::TCP))?;
    socket.set_nonblocking(true)?;
    let begun = Instant::now();
    // Under way, or refused: what became of it is asked for below.
    let _ = socket.connect(&address.into());
    loop {
        if let Some(error) = socket.take_error()? {
            return Err(error);
        }
        if let Ok(peer) = socket.peer_addr() {
            // Where nobody listens, a port of this machine may happen to connect to itself.
            let own = socket.local_addr().is_ok_and(|own| own.as_socket() == peer.as_socket());
            return if own { Err(ErrorKind::ConnectionRefused.into()) } else { Ok(socket.into()) };
        }
        if stop() || begun.elapsed() > CONNECT {
            return Err(ErrorKind::TimedOut.into());
        }
        thread::sleep(LOOK);
    }
}

fn connected(stream: TcpStream) -> io::Result<Link> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(READ_TIMEOUT))?;
    let alive = TcpKeepalive::new().with_time(ALIVE[0]).with_interval(ALIVE[1]);
    SockRef::from(&stream).set_tcp_keepalive(&alive)?;
    Ok(Link::Stream(Box::new(stream)))
}

fn datagrams(address: SocketAddr) -> io::Result<UdpSocket> {
    let socket = UdpSocket::bind(address)?;
    socket.set_read_timeout(Some(READ_TIMEOUT))?;
    Ok(socket)
}

/// A serial port, raw, 8N1.
#[cfg(feature = "serial")]
fn serial(path: &std::path::Path, baud: u32) -> io::Result<Box<dyn Read + Send>> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if !std::fs::metadata(path)?.file_type().is_char_device() {
            return Err(io::Error::new(ErrorKind::InvalidInput, "not a port; for a file write file:PATH"));
        }
    }
    let text = path.to_str().ok_or(ErrorKind::InvalidInput)?;
    #[allow(unused_mut)]
    let mut port = serialport::new(text, baud).timeout(READ_TIMEOUT).open_native()?;
    // Of a pseudo terminal the claim would outlive the reader.
    #[cfg(unix)]
    port.set_exclusive(false)?;
    Ok(Box::new(port))
}

#[cfg(not(feature = "serial"))]
fn serial(_: &std::path::Path, _: u32) -> io::Result<Box<dyn Read + Send>> {
    let text = "this build reads no serial ports (feature `serial`)";
    Err(io::Error::new(ErrorKind::Unsupported, text))
}
