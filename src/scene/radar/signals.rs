//! Continuous signals, as described: broadcast, satellites, recordings.

use std::path::PathBuf;

use crate::units::fast_len;

/// Chips a second of the coarse code of GPS.
pub const CA_CHIPS_HZ: f64 = 1.023e6;
/// Samples a second of it: ten a chip.
pub const CA_RATE_HZ: f64 = 10.0 * CA_CHIPS_HZ;

/// Parameters of FM broadcast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fm {
    /// Greatest deviation, Hz.
    pub deviation_hz: f64,
}

impl Fm {
    /// Length of a slot of programme, s: every frequency in it is a multiple of one over that.
    pub const SLOT_S: f64 = 0.04;
    /// End of the multiplex: the subcarrier of 38 kHz and 15 kHz of audio, Hz.
    pub const MULTIPLEX_HZ: f64 = 53e3;

    /// Bandwidth by Carson's rule, Hz.
    pub fn occupied_hz(&self) -> f64 {
        2.0 * (self.deviation_hz + Self::MULTIPLEX_HZ)
    }

    /// Samples of a slot, an even number: Carson's band is where an interpolation is flat.
    pub fn samples(&self) -> usize {
        fast_len((self.occupied_hz() / 0.83 * Self::SLOT_S).ceil() as usize)
    }

    /// Samples a second.
    pub fn rate_hz(&self) -> f64 {
        self.samples() as f64 / Self::SLOT_S
    }
}

/// A recording of complex samples.
#[derive(Clone, Debug, PartialEq)]
pub struct IqFile {
    /// Samples, or the metadata of SigMF.
    pub path: PathBuf,
    /// What samples without metadata are; `None` of SigMF.
    pub raw: Option<RawIq>,
    /// What follows it.
    pub after: AfterEnd,
}

/// What samples are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawIq {
    /// Rate, Hz.
    pub rate_hz: f64,
    /// Type.
    pub datatype: Datatype,
}

/// What follows the end of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AfterEnd {
    /// Its beginning.
    Repeat,
    /// Nothing.
    Silence,
}

/// Type of complex samples, I before Q, as SigMF names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datatype {
    /// Each of both.
    pub component: Component,
    /// Whether the first byte has the greatest weight.
    pub is_big_endian: bool,
}

/// Type of I and of Q.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Component {
    /// 64-bit float.
    F64,
    /// 32-bit float.
    F32,
    /// 32 bits, signed.
    I32,
    /// 16 bits, signed.
    I16,
    /// 8 bits, signed.
    I8,
    /// 32 bits, 0 at half of the scale.
    U32,
    /// 16 bits, 0 at half of the scale.
    U16,
    /// 8 bits, 0 at half of the scale.
    U8,
}

impl Datatype {
    /// All of them.
    pub const NAMED: [(&str, Self); 14] = [
        ("cf32_le", Self::little(Component::F32)),
        ("cf64_le", Self::little(Component::F64)),
        ("ci32_le", Self::little(Component::I32)),
        ("ci16_le", Self::little(Component::I16)),
        ("ci8", Self::little(Component::I8)),
        ("cu32_le", Self::little(Component::U32)),
        ("cu16_le", Self::little(Component::U16)),
        ("cu8", Self::little(Component::U8)),
        ("cf32_be", Self::big(Component::F32)),
        ("cf64_be", Self::big(Component::F64)),
        ("ci32_be", Self::big(Component::I32)),
        ("ci16_be", Self::big(Component::I16)),
        ("cu32_be", Self::big(Component::U32)),
        ("cu16_be", Self::big(Component::U16)),
    ];
    /// Endings by which tools name files of a type.
    pub const ENDINGS: [(&str, Self); 13] = [
        ("cf32", Self::little(Component::F32)),
        ("fc32", Self::little(Component::F32)),
        ("c64", Self::little(Component::F32)),
        ("cfile", Self::little(Component::F32)),
        ("cf64", Self::little(Component::F64)),
        ("fc64", Self::little(Component::F64)),
        ("c128", Self::little(Component::F64)),
        ("cs16", Self::little(Component::I16)),
        ("sc16", Self::little(Component::I16)),
        ("ci16", Self::little(Component::I16)),
        ("cs8", Self::little(Component::I8)),
        ("sc8", Self::little(Component::I8)),
        ("cu8", Self::little(Component::U8)),
    ];

    const fn little(component: Component) -> Self {
        Self { component, is_big_endian: false }
    }

    const fn big(component: Component) -> Self {
        Self { component, is_big_endian: true }
    }

    /// That of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(known, _)| *known == name).map(|(_, of)| *of)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMED.iter().find(|(_, of)| *of == self).map_or("", |(name, _)| name)
    }

    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        2 * match self.component {
            Component::F64 => 8,
            Component::F32 | Component::I32 | Component::U32 => 4,
            Component::I16 | Component::U16 => 2,
            Component::I8 | Component::U8 => 1,
        }
    }
}
