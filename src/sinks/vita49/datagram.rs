//! One packet being packed: big-endian words in a buffer that keeps its room.

use super::stamp::Stamp;

/// Packet types of VITA 49.2 that are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    /// Signal data with a stream identifier and a trailer.
    Signal,
    /// Context.
    Context,
    /// Extension context of this packet class.
    Extension(u16),
    /// A packet of DIFI.
    Difi(Difi),
}

/// Packet classes of DIFI that are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Difi {
    /// Standard flow signal data.
    Data,
    /// Standard flow signal context.
    Context,
    /// Version flow signal context.
    Version,
}

impl Type {
    /// Packet type and the bits that are its own.
    fn bits(self) -> u32 {
        match self {
            // Type 1, with a trailer that has a sample frame: not a V49.0 packet.
            Self::Signal => 1 << 28 | 1 << 26 | 1 << 25,
            Self::Context => 4 << 28,
            Self::Extension(_) => 5 << 28 | 1 << 27,
            Self::Difi(Difi::Data) => 1 << 28 | 1 << 27,
            // Their time is that of the settings, not of a sample.
            Self::Difi(Difi::Context) => 4 << 28 | 1 << 27 | 1 << 24,
            Self::Difi(Difi::Version) => 5 << 28 | 1 << 27 | 1 << 24,
        }
    }

    /// Organisation; information class and packet class.
    fn class(self) -> Option<[u32; 2]> {
        match self {
            Self::Signal | Self::Context => None,
            Self::Extension(class) => Some([OUI, INFORMATION_CLASS << 16 | u32::from(class)]),
            Self::Difi(Difi::Data) => Some([DIFI_OUI, 0]),
            Self::Difi(Difi::Context) => Some([DIFI_OUI, 1]),
            Self::Difi(Difi::Version) => Some([DIFI_OUI, 1 << 16 | 4]),
        }
    }
}

/// Class identifier's organisation: `NER`, an identifier of those that are administered locally.
pub(super) const OUI: u32 = 0x004e_4552;
/// Class identifier's information class: version 1 of the extension-context packets.
const INFORMATION_CLASS: u32 = 1;

/// The same of DIFI.
const DIFI_OUI: u32 = 0x006a_621e;

/// Bytes before the payload of signal data and context.
pub(super) const PROLOGUE: usize = 20;
/// Bytes before the body of an extension context: a class identifier as well.
pub(super) const EXTENSION_PROLOGUE: usize = 28;
/// Bytes of the trailer.
pub(super) const TRAILER: usize = 4;

/// A packet; the buffer is allocated once.
#[derive(Debug)]
pub(super) struct Datagram(Vec<u8>);

impl Datagram {
    /// Room for packets of up to `bytes`.
    pub(super) fn with_room(bytes: usize) -> Self {
        Self(Vec::with_capacity(bytes))
    }

    /// Starts a packet: header, stream, class, time stamp (UTC and picoseconds). The size is filled in at the
    /// end.
    pub(super) fn begin(&mut self, of: Type, stream: u32, count: u8, at: Stamp) -> &mut Self {
        self.0.clear();
        // Whole seconds are UTC (1), fractions real time (2).
        let header: u32 = of.bits() | 1 << 22 | 2 << 20 | u32::from(count & 15) << 16;
        self.u32(header).u32(stream);
        if let Some([organisation, codes]) = of.class() {
            self.u32(organisation).u32(codes);
        }
        self.u32(at.seconds).u64(at.picoseconds)
    }

    /// The whole packet, with its size in words.
    pub(super) fn end(&mut self) -> &[u8] {
        let words = (self.0.len() / 4) as u16;
        if let Some(size) = self.0.get_mut(2..4) {
            size.copy_from_slice(&words.to_be_bytes());
        }
        &self.0
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.extend_from_slice(bytes);
        self
    }

    pub(super) fn u32(&mut self, value: u32) -> &mut Self {
        self.bytes(&value.to_be_bytes())
    }

    pub(super) fn u64(&mut self, value: u64) -> &mut Self {
        self.bytes(&value.to_be_bytes())
    }

    pub(super) fn i64(&mut self, value: i64) -> &mut Self {
        self.bytes(&value.to_be_bytes())
    }

    pub(super) fn f64(&mut self, value: f64) -> &mut Self {
        self.u64(value.to_bits())
    }

    pub(super) fn f64s(&mut self, values: &[f64]) -> &mut Self {
        for &value in values {
            self.f64(value);
        }
        self
    }

    /// Length in bytes, UTF-8, zeros up to the next word.
    pub(super) fn text(&mut self, text: &str) -> &mut Self {
        let padding = text.len().next_multiple_of(4) - text.len();
        self.u32(text.len() as u32).bytes(text.as_bytes()).bytes(&[0; 3][..padding])
    }

    /// A signed fixed-point number of 64 bits, 20 of them below the point.
    pub(super) fn hertz(&mut self, value_hz: f64) -> &mut Self {
        self.i64((value_hz * f64::from(1 << 20)).round_ties_even() as i64)
    }

    /// A signed fixed-point number of 32 bits, `point` of them below the point; what is not finite or does
    /// not fit is unknown.
    pub(super) fn fixed(&mut self, value: f64, point: u32) -> &mut Self {
        const UNKNOWN: i32 = 0x7fff_ffff;
        let scaled = (value * f64::from(1u32 << point)).round_ties_even();
        let fits = scaled >= f64::from(i32::MIN) && scaled < f64::from(UNKNOWN);
        let word = if fits { scaled as i32 } else { UNKNOWN };
        self.bytes(&word.to_be_bytes())
    }
}

/// Bytes that a text takes.
pub(super) fn text_bytes(text: &str) -> usize {
    4 + text.len().next_multiple_of(4)
}
