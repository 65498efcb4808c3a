//! Captures of network traffic: the byte streams that were carried.
//!
//! Receivers send over TCP or UDP, and captures of that (`tcpdump -w`) are how many recordings are kept. What
//! is read: pcap of either byte order, with micro- or nanoseconds, and pcapng; Ethernet (with VLAN tags),
//! Linux "cooked", BSD loopback and raw IP; IPv4 and IPv6; TCP and UDP. Each direction of each connection is
//! a [`Stream`]: UDP datagrams as they came, TCP in the order of its sequence numbers, what was sent twice
//! left out, what is missing counted. Packets of other kinds and fragments are counted and left. An IP packet
//! of length 0, as the sending host captures it before its network card cuts it, reaches to the end of its
//! frame.
//!
//! Sequence numbers wrap; they are unwrapped to the nearest of the packet before (within 2 GiB).
//!
//! ```
//! let error = nereus::nav::pcap::parse(b"no capture at all, but long enough").unwrap_err();
//! assert!(error.to_string().contains("is no capture"));
//! ```
//!
//! Source: <https://www.ietf.org/archive/id/draft-gharris-opsawg-pcap-01.html>, RFC 791, 8200, 9293, 768.

use std::collections::HashMap;
use std::net::IpAddr;
use std::path::Path;

use etherparse::{EtherType, LaxNetSlice, LaxSlicedPacket, TransportSlice};
use pcap_parser::pcap::{parse_pcap_frame, parse_pcap_frame_be, parse_pcap_header};
use pcap_parser::{Block, PcapBlockOwned, PcapNGSlice};
use thiserror::Error;

use super::{NavError, unpacked};

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
    #[error("this is no capture: it begins with {found}; allowed: pcap or pcapng, gzipped or not")]
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
}

/// Reads the capture in a file.
///
/// # Errors
/// A file that cannot be read, or is no capture.
pub fn load(path: &Path) -> Result<Capture, CaptureError> {
    parse(&unpacked::read(path)?)
}

/// Reads the capture in some bytes.
///
/// # Errors
/// Bytes that are no capture.
pub fn parse(bytes: &[u8]) -> Result<Capture, CaptureError> {
    let mut capture = Capture::default();
    let mut flows = Flows::default();
    let mut take = |link: i32, packet| {
        capture.packets += 1;
        if segment(link, packet).is_none_or(|segment| !flows.take(segment)) {
            capture.left += 1;
        }
    };
    let mut links: Vec<i32> = Vec::new();
    let mut is_whole = true;
    for block in blocks(bytes)? {
        match block {
            Ok(PcapBlockOwned::LegacyHeader(header)) => links = vec![known(header.network.0)?],
            Ok(PcapBlockOwned::Legacy(block)) => take(links.first().copied().unwrap_or_default(), block.data),
            Ok(PcapBlockOwned::NG(Block::SectionHeader(_))) => links.clear(),
            Ok(PcapBlockOwned::NG(Block::InterfaceDescription(interface))) => {
                links.push(known(interface.linktype.0)?)
            }
            Ok(PcapBlockOwned::NG(Block::EnhancedPacket(block))) => {
                let link = usize::try_from(block.if_id).ok().and_then(|id| links.get(id));
                // Behind the packet stand up to three bytes to the end of a word.
                let length = usize::try_from(block.caplen).unwrap_or(usize::MAX).min(block.data.len());
                take(link.copied().unwrap_or_default(), &block.data[..length]);
            }
            Ok(PcapBlockOwned::NG(Block::SimplePacket(block))) => {
                let length = usize::try_from(block.origlen).unwrap_or(usize::MAX).min(block.data.len());
                take(links.first().copied().unwrap_or_default(), &block.data[..length]);
            }
            Ok(PcapBlockOwned::NG(_)) => {}
            // The last packet is not whole.
            Err(_) => {
                is_whole = false;
                break;
            }
        }
    }
    capture.left += u64::from(!is_whole);
    capture.streams = flows.streams();
    Ok(capture)
}

/// Blocks of a capture; the first error ends them.
type Blocks<'a> = Box<dyn Iterator<Item = Result<PcapBlockOwned<'a>, ()>> + 'a>;

fn blocks(bytes: &[u8]) -> Result<Blocks<'_>, CaptureError> {
    let found = || bytes.get(..4).map_or("too few bytes".to_owned(), |found| format!("{found:02X?}"));
    if is_capture(bytes) {
        if bytes.starts_with(&[0x0A, 0x0D, 0x0D, 0x0A])
            && let Ok(slice) = PcapNGSlice::from_slice(bytes)
        {
            return Ok(Box::new(slice.map(|block| block.map_err(|_| ()))));
        }
        if let Ok((mut rest, header)) = parse_pcap_header(bytes) {
            let frame = if header.is_bigendian() { parse_pcap_frame_be } else { parse_pcap_frame };
            let first = Ok(PcapBlockOwned::LegacyHeader(header));
            let frames = std::iter::from_fn(move || {
                if rest.is_empty() {
                    return None;
                }
                let (after, block) = match frame(rest) {
                    Ok(found) => found,
                    Err(_) => return Some(Err(())),
                };
                rest = after;
                Some(Ok(PcapBlockOwned::Legacy(block)))
            });
            return Ok(Box::new(std::iter::once(first).chain(frames)));
        }
    }
    Err(CaptureError::NotPcap { found: found() })
}

/// Whether a file begins as a capture does.
pub(super) fn is_capture(bytes: &[u8]) -> bool {
    let magics = [0xA1B2_C3D4_u32, 0xA1B2_3C4D];
    let is_magic = |word: [u8; 4]| {
        magics.contains(&u32::from_le_bytes(word))
            || magics.contains(&u32::from_be_bytes(word))
            || word == [0x0A, 0x0D, 0x0D, 0x0A]
    };
    bytes.first_chunk().is_some_and(|word| is_magic(*word))
}

/// A link layer, if it is read.
fn known(link: i32) -> Result<i32, CaptureError> {
    // What stands above 16 bits is of check sequences.
    let found = link & 0xFFFF;
    if ![0, 1, 12, 101, 108, 113, 228, 229].contains(&found) {
        return Err(CaptureError::Link { found: found.unsigned_abs() });
    }
    Ok(found)
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

/// The TCP or UDP segment in a packet of a link layer; `None` for others.
fn segment(link: i32, packet: &[u8]) -> Option<Segment<'_>> {
    let layers = match link {
        1 => LaxSlicedPacket::from_ethernet(packet).ok()?,
        0 | 108 => LaxSlicedPacket::from_ip(packet.get(4..)?).ok()?,
        113 => {
            let kind = u16::from_be_bytes(*packet.get(14..)?.first_chunk()?);
            LaxSlicedPacket::from_ether_type(EtherType(kind), packet.get(16..)?)
        }
        _ => LaxSlicedPacket::from_ip(packet).ok()?,
    };
    let [from, to]: [IpAddr; 2] = match layers.net? {
        LaxNetSlice::Ipv4(ip) => [ip.header().source_addr().into(), ip.header().destination_addr().into()],
        LaxNetSlice::Ipv6(ip) => [ip.header().source_addr().into(), ip.header().destination_addr().into()],
        _ => return None,
    };
    Some(match layers.transport? {
        TransportSlice::Tcp(tcp) => Segment {
            flow: Flow { protocol: TCP, from: (from, tcp.source_port()), to: (to, tcp.destination_port()) },
            sequence: Some((tcp.sequence_number(), tcp.syn())),
            payload: tcp.payload(),
        },
        TransportSlice::Udp(udp) => Segment {
            flow: Flow { protocol: UDP, from: (from, udp.source_port()), to: (to, udp.destination_port()) },
            sequence: None,
            payload: udp.payload(),
        },
        _ => return None,
    })
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
