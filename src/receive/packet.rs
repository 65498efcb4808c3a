//! A datagram as VITA 49.2 has it: header, stream, class, time stamp, payload, trailer (section 5.1 of the
//! standard).

use thiserror::Error;

/// What is wrong with a datagram.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Malformed {
    /// Too short for what it announces.
    #[error("the packet ends within its {0}")]
    Short(&'static str),
    /// The size of the header is not that of the datagram.
    #[error("the header announces {announced} bytes, the datagram has {found}")]
    Size {
        /// Bytes announced.
        announced: usize,
        /// Bytes received.
        found: usize,
    },
    /// A packet type that the standard reserves.
    #[error("packet type {0} is reserved")]
    Type(u8),
    /// A value that the standard does not allow.
    #[error("{0} is not allowed")]
    Value(&'static str),
}

/// What a packet is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// Signal data.
    Signal,
    /// Extension data.
    ExtensionData,
    /// Context.
    Context,
    /// Extension context.
    ExtensionContext,
    /// Command, or extension command.
    Command,
}

/// Class identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Class {
    /// Organisation.
    pub oui: u32,
    /// Information class.
    pub information: u16,
    /// Packet class.
    pub packet: u16,
}

/// Where a signal packet stands in its sample frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Frame {
    /// The frame is one packet, or there are no frames.
    Only,
    /// First packet of a frame.
    First,
    /// Neither first nor last.
    Middle,
    /// Last packet of a frame.
    Last,
}

/// A packet, taken apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packet<'a> {
    /// What it is.
    pub kind: Kind,
    /// Packet count, modulo 16.
    pub count: u8,
    /// Stream identifier.
    pub stream: Option<u32>,
    /// Class identifier.
    pub class: Option<Class>,
    /// Picoseconds since 1970, UTC, where the packet has such a time.
    pub time_ps: Option<i128>,
    /// What comes after the prologue, without the trailer.
    pub payload: &'a [u8],
    /// The trailer.
    pub trailer: Option<u32>,
}

/// Longest text, bytes: names of platforms and channels, the software.
const TEXT: usize = 1024;

/// Reads big-endian words one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Words<'a> {
    rest: &'a [u8],
    part: &'static str,
}

impl<'a> Words<'a> {
    pub(super) fn new(bytes: &'a [u8], part: &'static str) -> Self {
        Self { rest: bytes, part }
    }

    pub(super) fn part(&mut self, part: &'static str) {
        self.part = part;
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    pub(super) fn bytes(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(Malformed::Short(self.part))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (taken, rest) = self.rest.split_first_chunk::<N>().ok_or(Malformed::Short(self.part))?;
        self.rest = rest;
        Ok(*taken)
    }

    pub(super) fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_be_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_be_bytes)
    }

    pub(super) fn i64(&mut self) -> Result<i64, Malformed> {
        self.array().map(i64::from_be_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64, Malformed> {
        self.array().map(f64::from_be_bytes)
    }

    pub(super) fn f64s<const N: usize>(&mut self) -> Result<[f64; N], Malformed> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// A text behind its length, in whole words.
    pub(super) fn text(&mut self) -> Result<String, Malformed> {
        let length = self.u32()? as usize;
        if length > TEXT {
            return Err(Malformed::Value("a text of more than 1024 bytes"));
        }
        let bytes = self.bytes(length)?;
        self.bytes(length.next_multiple_of(4) - length)?;
        let text = std::str::from_utf8(bytes).map_err(|_| Malformed::Value("a text that is not UTF-8"))?;
        if text.contains('\0') {
            return Err(Malformed::Value("a text with NUL"));
        }
        Ok(text.to_owned())
    }

    pub(super) fn rest(self) -> &'a [u8] {
        self.rest
    }
}

/// Picoseconds of a second.
pub(super) const SECOND_PS: i128 = 1_000_000_000_000;

impl<'a> Packet<'a> {
    /// Takes a datagram apart.
    ///
    /// # Errors
    /// Bytes that are no packet.
    pub fn parse(datagram: &'a [u8]) -> Result<Self, Malformed> {
        let mut words = Words::new(datagram, "header");
        let header = words.u32()?;
        let announced = 4 * (header & 0xffff) as usize;
        if announced != datagram.len() {
            return Err(Malformed::Size { announced, found: datagram.len() });
        }
        let code = (header >> 28) as u8;
        let (kind, has_stream) = match code {
            0 => (Kind::Signal, false),
            1 => (Kind::Signal, true),
            2 => (Kind::ExtensionData, false),
            3 => (Kind::ExtensionData, true),
            4 => (Kind::Context, true),
            5 => (Kind::ExtensionContext, true),
            6 | 7 => (Kind::Command, true),
            _ => return Err(Malformed::Type(code)),
        };
        words.part("stream identifier");
        let stream = has_stream.then(|| words.u32()).transpose()?;
        words.part("class identifier");
        let class = match header >> 27 & 1 {
            0 => None,
            _ => {
                let (oui, codes) = (words.u32()? & 0x00ff_ffff, words.u32()?);
                Some(Class { oui, information: (codes >> 16) as u16, packet: codes as u16 })
            }
        };
        words.part("time stamp");
        let (integer, fractional) = (header >> 22 & 3, header >> 20 & 3);
        let seconds = (integer != 0).then(|| words.u32()).transpose()?;
        let fraction = (fractional != 0).then(|| words.u64()).transpose()?;
        // UTC and real time; other scales are not compared with each other.
        let time_ps = match (integer, seconds, fractional, fraction) {
            (1, Some(seconds), 2, Some(ps)) if i128::from(ps) < SECOND_PS => {
                Some(i128::from(seconds) * SECOND_PS + i128::from(ps))
            }
            (_, _, 2, Some(ps)) if i128::from(ps) >= SECOND_PS => {
                return Err(Malformed::Value("a time stamp of 10^12 picoseconds and more"));
            }
            _ => None,
        };
        let mut payload = words.rest();
        let mut trailer = None;
        // In context packets this bit means something else.
        if matches!(kind, Kind::Signal | Kind::ExtensionData) && header >> 26 & 1 == 1 {
            let (before, last) = payload.split_last_chunk::<4>().ok_or(Malformed::Short("trailer"))?;
            payload = before;
            trailer = Some(u32::from_be_bytes(*last));
        }
        Ok(Self { kind, count: (header >> 16 & 15) as u8, stream, class, time_ps, payload, trailer })
    }

    /// Its place in the sample frame; `None` where the trailer does not have it.
    pub fn frame(&self) -> Option<Frame> {
        let trailer = self.trailer.filter(|trailer| trailer >> 22 & 3 == 3)?;
        Some(match trailer >> 10 & 3 {
            0 => Frame::Only,
            1 => Frame::First,
            2 => Frame::Middle,
            _ => Frame::Last,
        })
    }
}
