//! Ports: serial lines, pseudo terminals, files and sockets that take bytes while something listens.
//!
//! | device | what it is |
//! | --- | --- |
//! | `/dev/ttyUSB0`, `/dev/pts/3` | a serial port or pseudo terminal; raw, 8N1, with its baud rate (feature `serial`) |
//! | `file:PATH` | a file that is made ([`crate::files`]); with force it replaces a file of messages when it is complete |
//! | `tcp://ADDRESS:PORT` | a connection to somebody who listens |
//! | `udp://ADDRESS:PORT` | datagrams, a message each |
//!
//! A [`Port`] never waits: what the port does not take at once is held, up to 4096 bytes, and goes before the
//! next message; a message for which there is no room is lost as a whole and counted, so nobody reads half of
//! one. A port that vanishes is counted and opened again, at most twice per second; until then messages are
//! lost. A **file** that cannot be written (a full disk) is a fault, not a port that vanishes: it ends with
//! the last whole message, and [`Port::fault`] is why.
//!
//! ```
//! use nereus::sinks::port::{Device, Port};
//!
//! let path = std::env::temp_dir().join(format!("nereus-port-{}.nmea", std::process::id()));
//! let mut port = Port::open(Device::of(&format!("file:{}", path.display()), 4800)?, false)?;
//! port.send(b"$GPHDT,274.5,T*37\r\n");
//! assert!(port.fault().is_none());
//! # drop(port);
//! # std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Serialize;
use thiserror::Error;

use crate::files::{Draft, FileFault, Holding, Recognised};
use crate::inputs;

/// Bytes that wait for a port.
const HELD_BYTES: usize = 4096;
/// Time between attempts to open a port again.
const REOPEN: Duration = Duration::from_millis(500);
/// How long an answer of the other side of a connection is waited for.
const CONNECT: Duration = Duration::from_millis(200);

/// Where a port is.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Device {
    /// A serial port or a pseudo terminal.
    Serial {
        /// Its path.
        path: PathBuf,
        /// Bits a second.
        baud: u32,
    },
    /// A file.
    File(PathBuf),
    /// Somebody who listens.
    Tcp(SocketAddr),
    /// Somebody who takes datagrams.
    Udp(SocketAddr),
}

/// Not a device.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "'{text}' is no device; allowed: the path of a port, file:PATH, tcp://ADDRESS:PORT or udp://ADDRESS:PORT such as tcp://127.0.0.1:2947"
)]
pub struct NotADevice {
    /// What was written.
    pub text: String,
}

impl Device {
    /// The device of a text; the baud rate is that of a serial port.
    ///
    /// # Errors
    /// A text that is no device.
    pub fn of(text: &str, baud: u32) -> Result<Self, NotADevice> {
        let bad = || NotADevice { text: text.to_owned() };
        if let Some(path) = text.strip_prefix("file:") {
            return if path.is_empty() { Err(bad()) } else { Ok(Self::File(path.into())) };
        }
        if let Some(address) = text.strip_prefix("tcp://") {
            return address.parse().map(Self::Tcp).map_err(|_| bad());
        }
        if let Some(address) = text.strip_prefix("udp://") {
            return address.parse().map(Self::Udp).map_err(|_| bad());
        }
        if text.is_empty() || text.contains("://") {
            return Err(bad());
        }
        Ok(Self::Serial { path: text.into(), baud })
    }

    /// The file, if it is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            _ => None,
        }
    }

    fn open(&self) -> io::Result<Box<dyn Write + Send>> {
        Ok(match self {
            Self::Serial { path, baud } => Box::new(serial(path, *baud)?),
            // A pipe or a device; a file that is made is not opened again.
            Self::File(path) => Box::new(OpenOptions::new().write(true).open(path)?),
            Self::Tcp(address) => {
                let stream = TcpStream::connect_timeout(address, CONNECT)?;
                stream.set_nodelay(true)?;
                stream.set_nonblocking(true)?;
                Box::new(stream)
            }
            Self::Udp(to) => Box::new(Datagrams::to(*to)?),
        })
    }
}

impl std::fmt::Display for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Serial { path, baud } => write!(f, "{} at {baud} baud", path.display()),
            Self::File(path) => write!(f, "file {}", path.display()),
            Self::Tcp(address) => write!(f, "tcp://{address}"),
            Self::Udp(address) => write!(f, "udp://{address}"),
        }
    }
}

/// Datagrams to one address. Whether anybody is there is not asked: that nobody takes them is no fault.
struct Datagrams {
    socket: UdpSocket,
    to: SocketAddr,
}

impl Datagrams {
    fn to(to: SocketAddr) -> io::Result<Self> {
        let own: SocketAddr = match to {
            SocketAddr::V4(_) if to.ip().is_loopback() => (Ipv4Addr::LOCALHOST, 0).into(),
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) if to.ip().is_loopback() => (Ipv6Addr::LOCALHOST, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(own)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, to })
    }
}

impl Write for Datagrams {
    fn write(&mut self, message: &[u8]) -> io::Result<usize> {
        self.socket.send_to(message, self.to)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A serial port, raw and with its rate, for writing without waiting.
#[cfg(unix)]
fn serial(path: &Path, baud: u32) -> io::Result<std::fs::File> {
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    if !std::fs::metadata(path)?.file_type().is_char_device() {
        let text = "not a port; for a file write file:PATH";
        return Err(io::Error::new(ErrorKind::InvalidInput, text));
    }
    set_up(path, baud)?;
    // Opened apart, because the crate's own port waits for its bytes.
    OpenOptions::new().write(true).custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY).open(path)
}

#[cfg(all(unix, feature = "serial"))]
fn set_up(path: &Path, baud: u32) -> io::Result<()> {
    let text = path.to_str().ok_or(ErrorKind::InvalidInput)?;
    // What is set up lasts while anyone has the port open; `/dev/null` and such have nothing to set up.
    match serialport::new(text, baud).open_native() {
        Ok(mut port) => Ok(port.set_exclusive(false)?),
        Err(error) => match io::Error::from(error) {
            error if error.raw_os_error() == Some(libc::ENOTTY) => Ok(()),
            error if error.kind() == ErrorKind::Other && !is_terminal(path) => Ok(()),
            error => Err(error),
        },
    }
}

#[cfg(all(unix, feature = "serial"))]
fn is_terminal(path: &Path) -> bool {
    use std::io::IsTerminal;
    std::fs::File::open(path).is_ok_and(|file| file.is_terminal())
}

#[cfg(all(unix, not(feature = "serial")))]
fn set_up(_: &Path, _: u32) -> io::Result<()> {
    Ok(())
}

#[cfg(not(unix))]
fn serial(path: &Path, _: u32) -> io::Result<std::fs::File> {
    OpenOptions::new().write(true).open(path)
}

/// What became of the messages for a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PortCounts {
    /// Messages handed over.
    pub messages: u64,
    /// Bytes that the port took.
    pub bytes: u64,
    /// Messages for which there was no port or no room.
    pub lost_messages: u64,
    /// Bytes that the port did not take: of lost messages, and of those that waited when it vanished.
    pub lost_bytes: u64,
    /// How often it vanished.
    pub vanished: u64,
    /// How often it was opened again.
    pub reopened: u64,
}

/// Why a port cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PortFault {
    /// The system refused.
    #[error(transparent)]
    System(#[from] io::Error),
    /// A file cannot be made.
    #[error(transparent)]
    File(#[from] FileFault),
}

/// A file that takes messages.
#[derive(Debug)]
struct Made {
    draft: Draft,
    file: fs::File,
    force: bool,
    /// Bytes of whole messages.
    whole: u64,
}

/// Whether a file may be made, or replaced, here.
///
/// # Errors
/// What is there already and may not be replaced, and a folder that is missing.
pub fn preflight(path: &Path, force: bool) -> Result<(), FileFault> {
    match is_regular_or_new(path) {
        true => crate::files::preflight(path, force, &recognise),
        false if force => Ok(()),
        false => Err(FileFault::Exists { path: path.to_owned() }),
    }
}

/// A pipe or a device is written as it is.
fn is_regular_or_new(path: &Path) -> bool {
    fs::metadata(path).map_or(true, |data| data.is_file() || data.is_dir())
}

/// A file that may be replaced by one of messages: it is empty, or begins with a message of navigation.
pub fn recognise(path: &Path) -> Recognised {
    let is_message = |rest: &[u8]| {
        let name = rest.iter().position(|byte| *byte == b',').map(|end| &rest[..end]);
        name.is_some_and(|name| name.len() >= 5 && name.iter().all(u8::is_ascii_alphanumeric))
    };
    let is_ours = inputs::beginning(path, 16).is_some_and(|start| match start.as_slice() {
        [] | [0xAA, 0x44, 0x12 | 0x13, ..] => true,
        [b'$' | b'!' | b'#', rest @ ..] => is_message(rest),
        _ => false,
    });
    is_ours.then_some(Holding::File).ok_or("file of navigation messages")
}

/// Something that takes bytes.
pub struct Port {
    device: Device,
    link: Option<Box<dyn Write + Send>>,
    /// The file, where the port is one that is made.
    made: Option<Made>,
    fault: Option<io::Error>,
    held: Vec<u8>,
    tried: Instant,
    counts: PortCounts,
}

impl std::fmt::Debug for Port {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Port").field("device", &self.device).field("counts", &self.counts).finish()
    }
}

impl Port {
    /// Opens a device; with `force` a file of messages that exists is replaced at the end.
    ///
    /// # Errors
    /// What the system refuses, and a file that may not be replaced.
    pub fn open(device: Device, force: bool) -> Result<Self, PortFault> {
        let Some(path) = device.file().filter(|path| is_regular_or_new(path)) else {
            if let Some(path) = device.file() {
                preflight(path, force)?;
            }
            let link = device.open()?;
            return Ok(Self::over(device, Some(link)));
        };
        preflight(path, force)?;
        let (mut draft, file) = Draft::file(path)?;
        draft.lock();
        if let Err(fault) = draft.place_early(force) {
            draft.abandon();
            return Err(fault.into());
        }
        let link = file.try_clone()?;
        let mut port = Self::over(device, Some(Box::new(link)));
        port.made = Some(Made { draft, file, force, whole: 0 });
        Ok(port)
    }

    fn over(device: Device, link: Option<Box<dyn Write + Send>>) -> Self {
        let held = Vec::with_capacity(2 * HELD_BYTES);
        let counts = PortCounts::default();
        Self { device, link, made: None, fault: None, held, tried: Instant::now(), counts }
    }

    /// Hands over a message, without waiting.
    pub fn send(&mut self, message: &[u8]) {
        self.flush();
        // Two messages that wait would become one datagram.
        let room = if matches!(self.device, Device::Udp(_)) { 0 } else { HELD_BYTES };
        if self.link.is_none() || self.held.len() + message.len() > room.max(message.len()) {
            self.counts.lost_messages += 1;
            self.counts.lost_bytes += message.len() as u64;
            return;
        }
        self.counts.messages += 1;
        self.held.extend_from_slice(message);
        self.flush();
    }

    /// Counts a message that could not be made.
    pub fn count_lost(&mut self) {
        self.counts.lost_messages += 1;
    }

    /// Hands over what waits, and opens the port again if it vanished.
    pub fn flush(&mut self) {
        if self.link.is_none() && self.made.is_none() && self.tried.elapsed() >= REOPEN {
            self.tried = Instant::now();
            self.link = self.device.open().ok();
            self.counts.reopened += u64::from(self.link.is_some());
        }
        let Some(link) = &mut self.link else { return };
        let mut taken = 0;
        let mut fault = None;
        let alive = loop {
            if taken == self.held.len() {
                break true;
            }
            match link.write(&self.held[taken..]) {
                Ok(0) => break false,
                Ok(bytes) => taken += bytes,
                Err(error) => match error.kind() {
                    ErrorKind::Interrupted => {}
                    ErrorKind::WouldBlock | ErrorKind::TimedOut => break true,
                    _ => {
                        fault = Some(error);
                        break false;
                    }
                },
            }
        };
        self.counts.bytes += taken as u64;
        self.held.drain(..taken);
        match &mut self.made {
            Some(made) if alive => made.whole = self.counts.bytes,
            Some(_) => self.give_up(fault.unwrap_or_else(|| ErrorKind::WriteZero.into())),
            None if !alive => self.vanish(),
            None => {}
        }
    }

    /// A file that cannot be written ends with its last whole message.
    fn give_up(&mut self, fault: io::Error) {
        let Some(made) = &mut self.made else { return };
        let _ = made.file.set_len(made.whole);
        self.counts.messages = self.counts.messages.saturating_sub(1);
        self.counts.lost_messages += 1;
        self.counts.lost_bytes += self.counts.bytes - made.whole + self.held.len() as u64;
        self.counts.bytes = made.whole;
        self.held.clear();
        self.link = None;
        self.fault = Some(fault);
    }

    /// Whether a file could not be written.
    pub fn failed(&self) -> bool {
        self.fault.is_some()
    }

    /// Why a file could not be written, once.
    pub fn fault(&mut self) -> Option<io::Error> {
        self.fault.take()
    }

    /// Waits some time for what is left, then counts it as lost. A file is put in its place.
    ///
    /// # Errors
    /// A file that could not be written, or cannot be put in its place.
    pub fn finish(mut self, timeout: Duration) -> Result<PortCounts, PortFault> {
        self.wait(timeout);
        if let Some(fault) = self.fault {
            return Err(fault.into());
        }
        if let Some(made) = self.made {
            made.draft.finish(made.force, &recognise)?;
        }
        Ok(self.counts)
    }

    /// The same, but a file is left to the caller, with whether it is to replace another.
    pub(super) fn close(&mut self, timeout: Duration) -> (PortCounts, Option<(Draft, bool)>) {
        self.wait(timeout);
        (self.counts, self.made.take().map(|made| (made.draft, made.force)))
    }

    /// Removes the file that was made.
    pub(super) fn abandon(&mut self) {
        if let Some(made) = self.made.take() {
            made.draft.abandon();
        }
    }

    fn wait(&mut self, timeout: Duration) {
        let until = Instant::now() + timeout;
        self.flush();
        while !self.held.is_empty() && self.link.is_some() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(5));
            self.flush();
        }
        self.counts.lost_bytes += self.held.len() as u64;
    }

    fn vanish(&mut self) {
        self.link = None;
        self.counts.vanished += 1;
        self.counts.lost_bytes += self.held.len() as u64;
        self.held.clear();
        self.tried = Instant::now();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// Takes so many bytes in all, then waits or breaks.
    struct Narrow {
        room: Arc<Mutex<(usize, bool)>>,
        got: Arc<Mutex<Vec<u8>>>,
    }

    impl Write for Narrow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let (room, broken) = &mut *self.room.lock().unwrap();
            let taken = bytes.len().min(*room);
            *room -= taken;
            self.got.lock().unwrap().extend_from_slice(&bytes[..taken]);
            match taken {
                0 if *broken => Err(ErrorKind::BrokenPipe.into()),
                0 => Err(ErrorKind::WouldBlock.into()),
                taken => Ok(taken),
            }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn whole_messages_or_none() {
        let (room, got) = (Arc::new(Mutex::new((150, false))), Arc::new(Mutex::new(Vec::new())));
        let narrow = Narrow { room: Arc::clone(&room), got: Arc::clone(&got) };
        let device = Device::File("/nowhere/at/all".into());
        let mut port = Port::over(device, Some(Box::new(narrow)));
        for i in 0..60u8 {
            port.send(&[i; 100]);
        }
        // 150 bytes taken; 40 messages fit into 4096 bytes beside the half one.
        assert_eq!(port.counts.messages, 42);
        assert_eq!((port.counts.lost_messages, port.counts.lost_bytes), (18, 1800));
        room.lock().unwrap().0 = 1_000_000;
        port.send(&[60; 100]);
        let taken = got.lock().unwrap().clone();
        assert_eq!(taken.len() as u64, port.counts.bytes);
        assert!(taken.chunks(100).all(|chunk| chunk.iter().all(|byte| *byte == chunk[0])));
        // It breaks with 70 bytes waiting.
        *room.lock().unwrap() = (30, true);
        port.send(&[61; 100]);
        assert_eq!((port.counts.vanished, port.counts.lost_bytes), (1, 1870));
        port.send(&[62; 100]);
        let counts = port.finish(Duration::ZERO).unwrap();
        assert_eq!((counts.lost_messages, counts.lost_bytes, counts.reopened), (19, 1970, 0));
    }

    #[test]
    fn a_message_a_datagram() {
        let to = UdpSocket::bind("127.0.0.1:0").unwrap();
        to.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let device = Device::Udp(to.local_addr().unwrap());
        let mut port = Port::open(device, false).unwrap();
        for i in 1..=9u8 {
            port.send(&vec![i; 100 * usize::from(i)]);
        }
        let mut buffer = [0; 2000];
        for i in 1..=9u8 {
            let bytes = to.recv(&mut buffer).unwrap();
            assert_eq!(buffer[..bytes], vec![i; 100 * usize::from(i)]);
        }
        // Nobody listens any more: that is no fault.
        drop(to);
        for _ in 0..3 {
            port.send(&[0; 10]);
        }
        let counts = port.finish(Duration::ZERO).unwrap();
        assert_eq!((counts.messages, counts.lost_messages, counts.vanished), (12, 0, 0));
    }

    #[test]
    fn devices() {
        assert_eq!(Device::of("file:a b", 1).unwrap(), Device::File("a b".into()));
        assert!(matches!(Device::of("/dev/ttyS0", 4800), Ok(Device::Serial { baud: 4800, .. })));
        assert!(matches!(Device::of("tcp://127.0.0.1:80", 1), Ok(Device::Tcp(_))));
        assert!(matches!(Device::of("udp://[::1]:80", 1), Ok(Device::Udp(_))));
        for text in ["", "file:", "tcp://host", "udp://127.0.0.1", "http://127.0.0.1:80"] {
            assert!(Device::of(text, 1).unwrap_err().to_string().contains("is no device"), "{text}");
        }
    }
}
