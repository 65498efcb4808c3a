//! The per-pulse columns of a recording: which there are, of what type and shape, and how a pulse
//! fills a row. HDF5 and plain recordings hold the same columns under the same paths.
//!
//! What each of them is, in words: [`super::descriptions`]. [`INDEX`] is always last, because it is written
//! after all others.

use bytemuck::cast_slice;
use num_complex::{Complex, Complex32};

use crate::pulse::{PlatformRecord, Pulse, SampleFormat, Samples};

use super::fault::RecordingError;
use super::header::Header;

/// Path of the column that is written last: what it covers is complete.
pub const INDEX: &str = "pulse/index";

/// Type of one element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// One column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Where it is in the recording.
    pub path: String,
    /// Type of an element.
    pub element: Element,
    /// Shape of a row; empty for a single value.
    pub shape: Vec<usize>,
    from: From,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum From {
    Iq,
    Index,
    TimeNs,
    TimeFracNs,
    WindowStart,
    Flags,
    TxPol,
    Position(Nav, usize),
    Velocity(Nav, usize),
    Attitude(Nav, usize),
    Age(Nav, usize),
    NavFlags(Nav, usize),
    PhaseCentre(usize),
    Boresight(usize),
    ReportedPhaseCentre(usize),
    Delay,
    Doppler,
    ShipPosition,
    ShipVelocity,
    ShipHeading,
    Clock(usize),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Nav {
    True,
    Reported,
}

impl Nav {
    fn of(self, pulse: &Pulse, platform: usize) -> Option<&PlatformRecord> {
        match self {
            Self::True => pulse.nav_true.get(platform),
            Self::Reported => pulse.nav_reported.get(platform),
        }
    }
}

/// The columns of a recording; [`INDEX`] last.
pub fn columns(header: &Header) -> Vec<Column> {
    let layout = &header.layout;
    let mut list = Vec::new();
    let mut add = |path: String, element, shape: &[usize], from| {
        list.push(Column { path, element, shape: shape.to_vec(), from });
    };
    let iq = match layout.format {
        SampleFormat::Cf32 => Element::Cf32,
        SampleFormat::Ci16 => Element::Ci16,
    };
    add("iq".to_owned(), iq, &[layout.channels, layout.samples], From::Iq);
    add("pulse/time_ns".to_owned(), Element::I64, &[], From::TimeNs);
    add("pulse/time_frac_ns".to_owned(), Element::F64, &[], From::TimeFracNs);
    add("pulse/window_start_s".to_owned(), Element::F64, &[], From::WindowStart);
    add("pulse/flags".to_owned(), Element::U32, &[], From::Flags);
    add("pulse/tx_pol".to_owned(), Element::U8, &[], From::TxPol);
    for (p, name) in header.platforms.iter().enumerate() {
        for (nav, kind) in [(Nav::True, "true"), (Nav::Reported, "reported")] {
            if nav == Nav::True && !header.truth {
                continue;
            }
            add(format!("nav/{name}/{kind}/position_m"), Element::F64, &[3], From::Position(nav, p));
            add(format!("nav/{name}/{kind}/velocity_mps"), Element::F64, &[3], From::Velocity(nav, p));
            add(format!("nav/{name}/{kind}/attitude_quat"), Element::F64, &[4], From::Attitude(nav, p));
            add(format!("nav/{name}/{kind}/age_s"), Element::F64, &[], From::Age(nav, p));
            add(format!("nav/{name}/{kind}/flags"), Element::U32, &[], From::NavFlags(nav, p));
        }
    }
    for (a, name) in header.antennas().enumerate() {
        add(format!("nav/{name}/phase_centre_m"), Element::F64, &[3], From::PhaseCentre(a));
        add(format!("nav/{name}/boresight_quat"), Element::F64, &[4], From::Boresight(a));
        let reported = From::ReportedPhaseCentre(a);
        add(format!("nav/{name}/reported_phase_centre_m"), Element::F64, &[3], reported);
    }
    if layout.targets > 0 && layout.pairs > 0 {
        let shape = [layout.pairs, layout.targets];
        add("truth/delay_s".to_owned(), Element::F64, &shape, From::Delay);
        add("truth/doppler_hz".to_owned(), Element::F64, &shape, From::Doppler);
    }
    if layout.ships > 0 {
        let each = [layout.ships, 3];
        add("truth/ship_position_m".to_owned(), Element::F64, &each, From::ShipPosition);
        add("truth/ship_velocity_mps".to_owned(), Element::F64, &each, From::ShipVelocity);
        add("truth/ship_heading_deg".to_owned(), Element::F64, &[layout.ships], From::ShipHeading);
    }
    for (c, name) in header.clocks.iter().enumerate() {
        add(format!("truth/clock/{name}/x_s"), Element::F64, &[], From::Clock(c));
    }
    add(INDEX.to_owned(), Element::U64, &[], From::Index);
    list
}

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
}

impl Rows {
    /// No rows yet, room for `elements`.
    pub fn with_capacity(element: Element, elements: usize) -> Self {
        match element {
            Element::U8 => Self::U8(Vec::with_capacity(elements)),
            Element::U32 => Self::U32(Vec::with_capacity(elements)),
            Element::U64 => Self::U64(Vec::with_capacity(elements)),
            Element::I64 => Self::I64(Vec::with_capacity(elements)),
            Element::F64 => Self::F64(Vec::with_capacity(elements)),
            Element::Cf32 => Self::Cf32(Vec::with_capacity(elements)),
            Element::Ci16 => Self::Ci16(Vec::with_capacity(elements)),
        }
    }

    /// Forgets the rows, keeps the room.
    pub fn clear(&mut self) {
        match self {
            Self::U8(v) => v.clear(),
            Self::U32(v) => v.clear(),
            Self::U64(v) => v.clear(),
            Self::I64(v) => v.clear(),
            Self::F64(v) => v.clear(),
            Self::Cf32(v) => v.clear(),
            Self::Ci16(v) => v.clear(),
        }
    }

    /// Elements held.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::U64(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::F64(v) => v.len(),
            Self::Cf32(v) => v.len(),
            Self::Ci16(v) => v.len(),
        }
    }

    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The elements as bytes in this machine's order.
    pub fn as_bytes(&self) -> &[u8] {
        match self {
            Self::U8(v) => v,
            Self::U32(v) => cast_slice(v),
            Self::U64(v) => cast_slice(v),
            Self::I64(v) => cast_slice(v),
            Self::F64(v) => cast_slice(v),
            Self::Cf32(v) => cast_slice(v),
            Self::Ci16(v) => cast_slice(v),
        }
    }
}

impl Column {
    /// Elements of a row.
    pub fn width(&self) -> usize {
        self.shape.iter().product()
    }

    /// Bytes of a row.
    pub fn row_bytes(&self) -> usize {
        self.width() * self.element.bytes()
    }

    /// Whether recordings of an older program may lack it: whoever needs it says so.
    pub fn may_be_missing(&self) -> bool {
        self.path.starts_with("nav/")
    }

    /// Appends the row of a pulse that passed [`check`](Self::check).
    pub fn push(&self, pulse: &Pulse, rows: &mut Rows) {
        match (self.from, rows) {
            (From::Index, Rows::U64(v)) => v.push(pulse.index),
            (From::TimeNs, Rows::I64(v)) => v.push(pulse.time.to_unix_ns().0),
            (From::TimeFracNs, Rows::F64(v)) => v.push(pulse.time.to_unix_ns().1),
            (From::WindowStart, Rows::F64(v)) => v.push(pulse.window_start_s),
            (From::Flags, Rows::U32(v)) => v.push(pulse.flags),
            (From::NavFlags(nav, p), Rows::U32(v)) => v.extend(nav.of(pulse, p).map(|r| r.flags)),
            (From::TxPol, Rows::U8(v)) => v.push(pulse.tx_pol),
            (From::Iq, Rows::Cf32(v)) => {
                if let Samples::Cf32(samples) = &pulse.samples {
                    v.extend_from_slice(samples);
                }
            }
            (From::Iq, Rows::Ci16(v)) => {
                if let Samples::Ci16(samples) = &pulse.samples {
                    v.extend_from_slice(cast_slice(samples));
                }
            }
            (from, Rows::F64(v)) => v.extend_from_slice(from.floats(pulse)),
            _ => {}
        }
    }

    /// Whether a pulse has the values that this column needs.
    pub fn check(&self, pulse: &Pulse) -> Result<(), RecordingError> {
        let found = match (self.from, self.element, &pulse.samples) {
            (From::Iq, Element::Cf32, Samples::Cf32(v)) => v.len(),
            (From::Iq, Element::Ci16, Samples::Ci16(v)) => v.len(),
            (From::Iq, ..) => 0,
            (
                From::Index | From::TimeNs | From::TimeFracNs | From::WindowStart | From::Flags | From::TxPol,
                ..,
            ) => 1,
            (From::NavFlags(nav, p), ..) => usize::from(nav.of(pulse, p).is_some()),
            (from, ..) => from.floats(pulse).len(),
        };
        let expected = self.width();
        if found == expected {
            Ok(())
        } else {
            Err(RecordingError::Pulse { index: pulse.index, column: self.path.clone(), found, expected })
        }
    }
}

impl From {
    fn floats(self, pulse: &Pulse) -> &[f64] {
        match self {
            Self::Position(nav, p) => nav.of(pulse, p).map_or(&[], |r| &r.position_m),
            Self::Velocity(nav, p) => nav.of(pulse, p).map_or(&[], |r| &r.velocity_mps),
            Self::Attitude(nav, p) => nav.of(pulse, p).map_or(&[], |r| &r.attitude_quat),
            Self::Age(nav, p) => nav.of(pulse, p).map_or(&[], |r| std::slice::from_ref(&r.age_s)),
            Self::PhaseCentre(a) => pulse.antennas.get(a).map_or(&[], |r| &r.phase_centre_m),
            Self::Boresight(a) => pulse.antennas.get(a).map_or(&[], |r| &r.boresight_quat),
            Self::ReportedPhaseCentre(a) => pulse.antennas.get(a).map_or(&[], |r| &r.reported_phase_centre_m),
            Self::Delay => &pulse.target_delay_s,
            Self::Doppler => &pulse.target_doppler_hz,
            Self::ShipPosition => pulse.ship_position_m.as_flattened(),
            Self::ShipVelocity => pulse.ship_velocity_mps.as_flattened(),
            Self::ShipHeading => &pulse.ship_heading_deg,
            Self::Clock(c) => pulse.clock_x_s.get(c).map_or(&[], std::slice::from_ref),
            _ => &[],
        }
    }
}
