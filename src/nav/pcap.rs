//! Captures of network traffic: the byte streams that were carried.
//!
//! Receivers send over TCP or UDP, and captures of that (`tcpdump -w`) are how many recordings are kept. What
//! is read: classic pcap of either byte order, with micro- or nanoseconds, gzipped or not; Ethernet (with
//! VLAN tags), Linux "cooked", BSD loopback and raw IP; IPv4 and IPv6; TCP and UDP. Each direction of each
//! connection is a [`Stream`]: UDP datagrams as they came, TCP in the order of its sequence numbers, what was
//! sent twice left out, what is missing counted. Packets of other kinds, cut ones and fragments are counted
//! and left.
//!
//! Sequence numbers wrap; they are unwrapped to the nearest of the packet before (within 2 GiB).
//!
//! ```
//! let error = nereus::nav::pcap::parse(b"no capture at all, but long enough").unwrap_err();
//! assert!(error.to_string().contains("is no capture"));
//! ```
//!
//! Source: <https://www.ietf.org/archive/id/draft-gharris-opsawg-pcap-01.html>, RFC 791, 8200, 9293, 768.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use thiserror::Error;

use super::NavError;
use super::replay::{MAX_FILE_BYTES, read_bytes};

/// Most streams of a capture that are kept apart.
pub const MAX_STREAMS: usize = 1024;
const TCP: u8 = 6;
const UDP: u8 = 17;

/// What a capture holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Capture {
    /// Streams with at least one byte, in the order of their first packets.
    pub streams: Vec<Stream>,
    /// Packets of the capture.
    pub packets: u64,
    /// Packets that carry neither TCP nor UDP, are cut, or are fragments.
    pub left: u64,
}

/// One direction of a connection.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// From where to where: `tcp 192.168.1.28:3001 > 192.168.1.21:35711`.
    pub name: String,
    /// What was carried.
    pub bytes: Vec<u8>,
    /// Bytes that were sent, by their numbers, but are not in the capture.
    pub missing_bytes: u64,
}

/// Why bytes are no capture that can be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] NavError),
    /// Something else.
    #[error("this is no capture: it begins with {found}; allowed: pcap (not pcapng), gzipped or not")]
    NotPcap {
        /// The first four bytes.
        found: String,
    },
    /// Not a link layer that is read.
    #[error(
        "link layer {found} is not read; allowed: Ethernet (1), loopback (0, 108), raw IP (12, 101, 228, 229), Linux cooked (113)"
    )]
    Link {
        /// Its number.
        found: u32,
    },
    /// Broken compression, or too much of it.
    #[error("gzip: {0}")]
    Gzip(#[source] std::io::Error),
    /// More than is read.
    #[error("larger than {allowed_bytes} bytes; cut the stretch that is needed")]
    TooLarge {
        /// The most that is read.
        allowed_bytes: u64,
    },
}

/// Reads the capture in a file.
///
/// # Errors
/// A file that cannot be read, or is no capture.
pub fn load(path: &Path) -> Result<Capture, CaptureError> {
    parse(&read_bytes(path)?)
}

/// Reads the capture in some bytes.
///
/// # Errors
/// Bytes that are no capture.
pub fn parse(bytes: &[u8]) -> Result<Capture, CaptureError> {
    let bytes = unpacked(bytes)?;
    let reader = Reader::of(&bytes)?;
    let mut capture = Capture::default();
    let mut flows = Flows::default();
    let mut rest = bytes.get(24..).unwrap_or_default();
    while let Some((packet, after)) = reader.packet(rest) {
        rest = after;
        capture.packets += 1;
        if reader.network(packet).and_then(segment).is_none_or(|segment| !flows.take(segment)) {
            capture.left += 1;
        }
    }
    // A last packet that is not whole.
    capture.left += u64::from(!rest.is_empty());
    capture.streams = flows.streams();
    Ok(capture)
}

/// The bytes of a gzipped file, or those of any other as they are.
pub(super) fn unpacked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, CaptureError> {
    if !bytes.starts_with(&[0x1F, 0x8B]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut unpacked = Vec::new();
    let mut reader = MultiGzDecoder::new(bytes).take(MAX_FILE_BYTES + 1);
    reader.read_to_end(&mut unpacked).map_err(CaptureError::Gzip)?;
    if unpacked.len() as u64 > MAX_FILE_BYTES {
        return Err(CaptureError::TooLarge { allowed_bytes: MAX_FILE_BYTES });
    }
    Ok(Cow::Owned(unpacked))
}

/// How the numbers of this capture are read.
struct Reader {
    little: bool,
    link: u32,
}

impl Reader {
    fn of(bytes: &[u8]) -> Result<Self, CaptureError> {
        let little = match bytes.get(..4) {
            Some([0xD4, 0xC3, 0xB2, 0xA1] | [0x4D, 0x3C, 0xB2, 0xA1]) => true,
            Some([0xA1, 0xB2, 0xC3, 0xD4] | [0xA1, 0xB2, 0x3C, 0x4D]) => false,
            other => {
                let found = other.map_or("too few bytes".to_owned(), |found| format!("{found:02X?}"));
                return Err(CaptureError::NotPcap { found });
            }
        };
        let mut reader = Self { little, link: 0 };
        let found = bytes.get(20..24).map_or(u32::MAX, |bytes| reader.number(bytes)) & 0xFFFF;
        if ![0, 1, 12, 101, 108, 113, 228, 229].contains(&found) {
            return Err(CaptureError::Link { found });
        }
        reader.link = found;
        Ok(reader)
    }

    fn number(&self, bytes: &[u8]) -> u32 {
        let bytes = std::array::from_fn(|i| bytes[i]);
        if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
    }

    /// The next packet and what follows it; `None` at the end.
    fn packet<'a>(&self, rest: &'a [u8]) -> Option<(&'a [u8], &'a [u8])> {
        let length = self.number(rest.get(8..12)?) as usize;
        rest.get(16..)?.split_at_checked(length)
    }

    /// The IP packet in a packet of the link layer.
    fn network<'a>(&self, packet: &'a [u8]) -> Option<&'a [u8]> {
        let of_ip = |kind: u16| kind == 0x0800 || kind == 0x86DD;
        match self.link {
            0 | 108 => packet.get(4..),
            1 => {
                let mut at = 12;
                while matches!(big_u16(packet, at)?, 0x8100 | 0x88A8) {
                    at += 4;
                }
                packet.get(at + 2..).filter(|_| big_u16(packet, at).is_some_and(of_ip))
            }
            113 => packet.get(16..).filter(|_| big_u16(packet, 14).is_some_and(of_ip)),
            _ => Some(packet),
        }
    }
}

fn big_u16(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]))
}

fn big_u32(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from(big_u16(bytes, at)?) << 16 | u32::from(big_u16(bytes, at + 2)?))
}

/// Which direction of which connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Flow {
    protocol: u8,
    from: (std::net::IpAddr, u16),
    to: (std::net::IpAddr, u16),
}

/// What one packet carries.
struct Segment<'a> {
    flow: Flow,
    /// TCP: number of the first byte, and whether the connection begins here.
    sequence: Option<(u32, bool)>,
    payload: &'a [u8],
}

/// The TCP or UDP segment of an IP packet; `None` for others.
fn segment(packet: &[u8]) -> Option<Segment<'_>> {
    let address = |at: usize, long: bool| -> Option<std::net::IpAddr> {
        Some(if long {
            <[u8; 16]>::try_from(packet.get(at..at + 16)?).ok()?.into()
        } else {
            <[u8; 4]>::try_from(packet.get(at..at + 4)?).ok()?.into()
        })
    };
    let (protocol, from, to, body) = match packet.first()? >> 4 {
        4 => {
            let header = usize::from(packet[0] & 15) * 4;
            let length = usize::from(big_u16(packet, 2)?);
            // More fragments, or not the first one.
            if big_u16(packet, 6)? & 0x3FFF != 0 {
                return None;
            }
            (*packet.get(9)?, address(12, false)?, address(16, false)?, packet.get(header..length)?)
        }
        6 => {
            let length = 40 + usize::from(big_u16(packet, 4)?);
            (*packet.get(6)?, address(8, true)?, address(24, true)?, packet.get(40..length)?)
        }
        _ => return None,
    };
    let (from, to) = ((from, big_u16(body, 0)?), (to, big_u16(body, 2)?));
    let flow = Flow { protocol, from, to };
    match protocol {
        UDP => Some(Segment { flow, sequence: None, payload: body.get(8..)? }),
        TCP => {
            let header = usize::from(*body.get(12)? >> 4) * 4;
            let begins = *body.get(13)? & 2 != 0;
            Some(Segment { flow, sequence: Some((big_u32(body, 4)?, begins)), payload: body.get(header..)? })
        }
        _ => None,
    }
}

/// Payloads, and at which byte of the stream they begin.
type Parts<'a> = Vec<(i64, &'a [u8])>;

/// The packets of every stream.
#[derive(Default)]
struct Flows<'a> {
    place: HashMap<Flow, usize>,
    all: Vec<(Flow, Parts<'a>)>,
}

impl<'a> Flows<'a> {
    /// Takes a segment; false if there are too many streams.
    fn take(&mut self, segment: Segment<'a>) -> bool {
        let begins = segment.sequence.is_some_and(|(_, begins)| begins);
        let known = self.place.get(&segment.flow).copied().filter(|place| {
            // The same ports again are another connection.
            !begins || self.all[*place].1.is_empty()
        });
        let place = match known {
            Some(place) => place,
            None if self.all.len() >= MAX_STREAMS => return false,
            None => {
                self.all.push((segment.flow, Vec::new()));
                self.place.insert(segment.flow, self.all.len() - 1);
                self.all.len() - 1
            }
        };
        if segment.payload.is_empty() {
            return true;
        }
        let held = &mut self.all[place].1;
        let at = match (segment.sequence, held.last()) {
            (Some((number, begins)), last) => {
                let number = number.wrapping_add(u32::from(begins));
                let near = last.map_or(i64::from(number), |(at, _)| *at);
                near + i64::from(number.wrapping_sub(near as u32) as i32)
            }
            // One datagram behind the other.
            (None, last) => last.map_or(0, |(at, payload)| at + payload.len() as i64),
        };
        held.push((at, segment.payload));
        true
    }

    fn streams(self) -> Vec<Stream> {
        let joined = self.all.into_iter().map(|(flow, mut parts)| {
            parts.sort_by_key(|(at, _)| *at);
            let mut bytes = Vec::with_capacity(parts.iter().map(|(_, part)| part.len()).sum());
            let mut missing_bytes = 0;
            let mut next = parts.first().map_or(0, |(at, _)| *at);
            for (at, part) in parts {
                missing_bytes += u64::try_from(at - next).unwrap_or(0);
                // What was sent before is left out.
                let sent = usize::try_from(next - at).unwrap_or(0).min(part.len());
                bytes.extend_from_slice(&part[sent..]);
                next = next.max(at + part.len() as i64);
            }
            let protocol = if flow.protocol == TCP { "tcp" } else { "udp" };
            let end = |(address, port)| std::net::SocketAddr::new(address, port);
            let name = format!("{protocol} {} > {}", end(flow.from), end(flow.to));
            Stream { name, bytes, missing_bytes }
        });
        joined.filter(|stream| !stream.bytes.is_empty()).collect()
    }
}
