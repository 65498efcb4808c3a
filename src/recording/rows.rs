//! Rows of values as recordings hold them.

use bytemuck::cast_slice;
use num_complex::{Complex, Complex32};

use crate::pulse::SampleFormat;

/// Type of one element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Element {
    /// Unsigned byte.
    U8,
    /// Unsigned 32-bit integer.
    U32,
    /// Unsigned 64-bit integer.
    U64,
    /// Signed 64-bit integer.
    I64,
    /// 64-bit float.
    F64,
    /// Two 32-bit floats.
    Cf32,
    /// Two 16-bit integers.
    Ci16,
}

/// Rows of one column.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Rows {
    /// See [`Element::U8`].
    U8(Vec<u8>),
    /// See [`Element::U32`].
    U32(Vec<u32>),
    /// See [`Element::U64`].
    U64(Vec<u64>),
    /// See [`Element::I64`].
    I64(Vec<i64>),
    /// See [`Element::F64`].
    F64(Vec<f64>),
    /// See [`Element::Cf32`].
    Cf32(Vec<Complex32>),
    /// See [`Element::Ci16`].
    Ci16(Vec<Complex<i16>>),
}

/// Rows of an element's type, of an expression that has that type.
macro_rules! rows_of {
    ($element:expr, $values:expr) => {
        match $element {
            Element::U8 => Rows::U8($values),
            Element::U32 => Rows::U32($values),
            Element::U64 => Rows::U64($values),
            Element::I64 => Rows::I64($values),
            Element::F64 => Rows::F64($values),
            Element::Cf32 => Rows::Cf32($values),
            Element::Ci16 => Rows::Ci16($values),
        }
    };
}

/// An expression of the values of rows, whatever their type.
macro_rules! with_values {
    ($rows:expr, $values:ident => $result:expr) => {
        match $rows {
            Rows::U8($values) => $result,
            Rows::U32($values) => $result,
            Rows::U64($values) => $result,
            Rows::I64($values) => $result,
            Rows::F64($values) => $result,
            Rows::Cf32($values) => $result,
            Rows::Ci16($values) => $result,
        }
    };
}

pub(super) use rows_of;
#[cfg(feature = "hdf5")]
pub(super) use with_values;

impl Element {
    /// numpy's name of the type in this machine's byte order.
    pub fn numpy(self) -> &'static str {
        let little = cfg!(target_endian = "little");
        match self {
            Self::U8 => "|u1",
            Self::U32 => ["<u4", ">u4"][usize::from(!little)],
            Self::U64 => ["<u8", ">u8"][usize::from(!little)],
            Self::I64 => ["<i8", ">i8"][usize::from(!little)],
            Self::F64 => ["<f8", ">f8"][usize::from(!little)],
            Self::Cf32 => ["<c8", ">c8"][usize::from(!little)],
            Self::Ci16 => ["<i2", ">i2"][usize::from(!little)],
        }
    }

    /// Bytes of one element.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U32 | Self::Ci16 => 4,
            Self::U64 | Self::I64 | Self::F64 | Self::Cf32 => 8,
        }
    }

    /// Its name on the page of datasets: numpy's where it has one.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::U32 => "uint32",
            Self::U64 => "uint64",
            Self::I64 => "int64",
            Self::F64 => "float64",
            Self::Cf32 => "complex64",
            Self::Ci16 => "{r, i} of int16",
        }
    }
}

impl From<SampleFormat> for Element {
    fn from(format: SampleFormat) -> Self {
        match format {
            SampleFormat::Cf32 => Self::Cf32,
            SampleFormat::Ci16 => Self::Ci16,
        }
    }
}

impl Rows {
    /// No rows yet, room for `elements`.
    pub fn with_capacity(element: Element, elements: usize) -> Self {
        rows_of!(element, Vec::with_capacity(elements))
    }

    /// Forgets the rows, keeps the room.
    pub fn clear(&mut self) {
        with_values!(self, values => values.clear());
    }

    /// Elements held.
    pub fn len(&self) -> usize {
        with_values!(self, values => values.len())
    }

    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The elements as bytes in this machine's order.
    pub fn as_bytes(&self) -> &[u8] {
        with_values!(self, values => cast_slice(values))
    }
}
