//! What goes into each kind of packet; `docs/wire.md` has the tables.

use num_complex::Complex32;

use super::datagram::{Datagram, EXTENSION_PROLOGUE, OUI, Type, text_bytes};
use super::radar;
use super::stamp::Stamp;
use crate::frames::{Body, Earth, Ecef, Enu, Geodetic, Point, Rotation, SceneFrame, Vector};
use crate::pulse::{PlatformRecord, Pulse, SampleFormat};
use crate::recording::RecordingError;
use crate::recording::header::{ChannelRow, Header, Origin};

/// Stream of channel 0; the others follow.
pub(super) const CHANNEL_STREAM: u32 = 0x1000_0000;
/// Stream of the state of platform 0; the others follow.
pub(super) const PLATFORM_STREAM: u32 = 0x2000_0000;
/// Stream of the description of platform 0; the others follow.
pub(super) const NAME_STREAM: u32 = 0x3000_0000;
/// Stream of the description of the run.
pub(super) const RUN_STREAM: u32 = 0x4000_0000;

/// Packet classes of extension contexts.
const STATE: u16 = 1;
const CHANNEL: u16 = 2;
const PLATFORM: u16 = 3;
const RUN: u16 = 4;

/// Platforms that a channel's context lists as associated with it.
const LISTED_PLATFORMS: usize = 64;

/// Which sample of a pulse a packet begins with, and whether it ends the pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Only,
    First,
    Middle,
    Last,
}

impl Part {
    pub(super) fn of(piece: usize, pieces: usize) -> Self {
        match (piece, piece + 1 == pieces) {
            (0, true) => Self::Only,
            (0, false) => Self::First,
            (_, true) => Self::Last,
            _ => Self::Middle,
        }
    }

    /// Code of the trailer's sample frame.
    fn code(self) -> u32 {
        match self {
            Self::Only => 0,
            Self::First => 1,
            Self::Middle => 2,
            Self::Last => 3,
        }
    }
}

/// The trailer: time calibrated, data valid, reference locked, over-range reported, place in the sample
/// frame.
pub(super) fn trailer(part: Part, saturated: bool) -> u32 {
    let enabled = 0b1110_0010 << 24 | 0b11 << 22;
    enabled | 0b111 << 17 | u32::from(saturated) << 13 | part.code() << 10
}

/// In-phase and quadrature, a word each.
pub(super) fn cf32(datagram: &mut Datagram, samples: &[Complex32]) {
    for sample in samples {
        datagram.u32(sample.re.to_bits()).u32(sample.im.to_bits());
    }
}

/// In-phase and quadrature in one word.
pub(super) fn ci16(datagram: &mut Datagram, samples: &[[i16; 2]]) {
    for [i, q] in samples {
        datagram.bytes(&i.to_be_bytes()).bytes(&q.to_be_bytes());
    }
}

/// The standard context of a channel.
pub(super) fn channel_context<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    channel: usize,
    count: u8,
    at: Stamp,
    changed: bool,
) -> &'a [u8] {
    let platforms = header.platforms.len().min(LISTED_PLATFORMS);
    let fields: u32 = u32::from(changed) << 31
        | 1 << 29 // bandwidth
        | 1 << 28 // intermediate frequency
        | 1 << 27 // radio frequency
        | 1 << 24 // reference level
        | 1 << 21 // sample rate
        | 1 << 17 // device
        | 1 << 15 // payload format
        | 1 << 8; // associated streams
    // Power of a complex sinusoid of amplitude 1 in the payload: 1 sqrt(W), or 2^15 codes.
    let (unit, bits, item) = match (header.layout.format, header.adc) {
        (SampleFormat::Ci16, Some(adc)) => (32_768.0 * adc.step, 16, 0),
        (SampleFormat::Ci16, None) => (f64::NAN, 16, 0),
        (SampleFormat::Cf32, _) => (1.0, 32, 14),
    };
    let level = (20.0 * unit.log10() + 30.0) * 128.0;
    let format = 1 << 29 | item << 24 | (bits - 1) << 6 | (bits - 1);
    datagram
        .begin(Type::Context, CHANNEL_STREAM + channel as u32, count, at)
        .u32(fields)
        .hertz(header.bandwidth_hz)
        .hertz(0.0)
        .hertz(header.carrier_hz)
        .u32(u32::from(level.round_ties_even() as i16 as u16))
        .hertz(header.sample_rate_hz)
        .u32(OUI)
        .u32(1)
        .u32(format)
        .u32(0)
        // No source list, a system list, nothing else.
        .u32(platforms as u32)
        .u32(0);
    for platform in 0..platforms {
        datagram.u32(PLATFORM_STREAM + platform as u32);
    }
    datagram.end()
}

/// The description of a channel.
pub(super) fn channel_description<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    channel: usize,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    let layout = &header.layout;
    datagram
        .begin(Type::Extension(CHANNEL), CHANNEL_STREAM + channel as u32, count, at)
        .u32(channel as u32)
        .u32(layout.channels as u32)
        .u32(layout.samples as u32)
        .u32(u32::from(layout.format == SampleFormat::Ci16))
        .f64(header.adc.map_or(f64::NAN, |adc| adc.step))
        .u32(header.adc.map_or(0, |adc| adc.bits))
        .u32(0);
    if let Some(row) = header.channels.get(channel) {
        for text in channel_texts(row) {
            datagram.text(text);
        }
    }
    datagram.end()
}

/// Texts of a channel's description. The bases are an addition: receivers that do not know them read what
/// stands before.
fn channel_texts(row: &ChannelRow) -> [&String; 6] {
    let ChannelRow { name, transmitter, receiver, polarisations, transmit_basis, receive_basis } = row;
    [name, transmitter, receiver, polarisations, transmit_basis, receive_basis]
}

/// The description of a platform.
pub(super) fn platform_description<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    platform: usize,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    datagram
        .begin(Type::Extension(PLATFORM), NAME_STREAM + platform as u32, count, at)
        .u32(platform as u32)
        .u32(header.platforms.len() as u32)
        .text(header.platforms.get(platform).map_or("", String::as_str))
        .end()
}

/// The description of the run.
pub(super) fn run_description<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    let none = Origin { lat_deg: f64::NAN, lon_deg: f64::NAN, h_m: f64::NAN };
    let origin = header.origin.unwrap_or(none);
    let packet = datagram
        .begin(Type::Extension(RUN), RUN_STREAM, count, at)
        .f64s(&[origin.lat_deg, origin.lon_deg, origin.h_m])
        .f64s(&[header.carrier_hz, header.sample_rate_hz, header.bandwidth_hz, header.pulse_s, header.prf_hz])
        .i64(header.start.seconds())
        .f64(header.start.fraction_s())
        .u64(header.first_pulse)
        .u64(header.pulses)
        .u64(header.seed)
        .text(&header.software);
    // An addition: how much there is to wait for. One who describes no radar leaves it out.
    if header.instrument.is_some() {
        packet.u32(header.layout.antennas as u32).u32(radar::replica_samples(header) as u32);
        // Another: receivers whose windows stand in every state, and emitters.
        let [windows, emitters] = [header.layout.windows, header.emitters().len()];
        if windows + emitters > 0 {
            packet.u32(windows as u32).u32(emitters as u32);
        }
    }
    packet.end()
}

/// Bytes of a state without windows of receivers and readings of encoders.
const STATE_BYTES: usize = 216;

/// Whether every description fits a datagram, and a state with all windows of receivers and readings of
/// encoders.
pub(super) fn check(header: &Header, room: usize) -> Result<(), RecordingError> {
    let texts = |texts: &[&String]| texts.iter().map(|text| text_bytes(text)).sum::<usize>();
    let channels = header.channels.iter().map(|row| 32 + texts(&channel_texts(row)));
    let platforms = header.platforms.iter().map(|name| 8 + texts(&[name]));
    let others = [112 + texts(&[&header.software]), header.instrument.as_ref().map_or(0, radar::longest)];
    let more = 8 * header.layout.windows + 16 * header.scanning().count();
    let state = (more > 0).then_some(STATE_BYTES + more);
    let longest = channels.chain(platforms).chain(others).chain(state).max().unwrap_or(0);
    if EXTENSION_PROLOGUE + longest > room {
        return Err(RecordingError::Header {
            field: "names",
            found: format!("a description of {} bytes", EXTENSION_PROLOGUE + longest),
            allowed: "names that fit one datagram (mtu_bytes)",
        });
    }
    if !(1.0..=1e12).contains(&header.sample_rate_hz) {
        return Err(RecordingError::Header {
            field: "sample_rate_hz",
            found: header.sample_rate_hz.to_string(),
            allowed: "1 to 1e12 Hz on the wire",
        });
    }
    Ok(())
}

/// The Earth about the scene: ENU to ECEF.
#[derive(Clone, Copy, Debug)]
pub(super) struct Globe {
    frame: SceneFrame,
    to_ecef: Rotation<Enu, Ecef>,
}

/// A platform's state, Earth-centred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EcefState {
    pub(super) position_m: [f64; 3],
    pub(super) velocity_mps: [f64; 3],
    /// Body to ECEF.
    pub(super) attitude_quat: [f64; 4],
    /// Turns about z, then y, then x, degrees.
    pub(super) attitude_deg: [f64; 3],
}

impl Globe {
    /// `None` for a scene that is not georeferenced.
    pub(super) fn new(origin: Option<Origin>) -> Option<Self> {
        let origin = origin?;
        let frame =
            SceneFrame::at(Geodetic::from_deg(origin.lat_deg, origin.lon_deg, origin.h_m), Earth::Flat);
        let axis = |x, y, z| frame.vector_to_ecef(Vector::new(x, y, z));
        let to_ecef = Rotation::from_axes(axis(1.0, 0.0, 0.0)?, axis(0.0, 1.0, 0.0)?, axis(0.0, 0.0, 1.0)?);
        Some(Self { frame, to_ecef })
    }

    /// The state of a record.
    pub(super) fn state(&self, record: &PlatformRecord) -> Option<EcefState> {
        let [x, y, z] = record.position_m;
        let [vx, vy, vz] = record.velocity_mps;
        let [w, i, j, k] = record.attitude_quat;
        let attitude = Rotation::<Body, Enu>::from_raw(glam::DQuat::from_xyzw(i, j, k, w)).then(self.to_ecef);
        let (nose, wing, belly) = (
            attitude * Vector::new(1.0, 0.0, 0.0),
            attitude * Vector::new(0.0, 1.0, 0.0),
            attitude * Vector::new(0.0, 0.0, 1.0),
        );
        // Columns of Rz(alpha) Ry(beta) Rx(phi).
        let [nx, ny, nz] = nose.to_array();
        let (wz, bz) = (wing.to_array()[2], belly.to_array()[2]);
        let turns = [ny.atan2(nx), (-nz).clamp(-1.0, 1.0).asin(), wz.atan2(bz)];
        Some(EcefState {
            position_m: self.frame.to_ecef(Point::new(x, y, z))?.to_array(),
            velocity_mps: self.frame.vector_to_ecef(Vector::new(vx, vy, vz))?.to_array(),
            attitude_quat: attitude.to_wxyz(),
            attitude_deg: turns.map(f64::to_degrees),
        })
    }
}

/// The standard ECEF ephemeris of a platform.
pub(super) fn ephemeris<'a>(
    datagram: &'a mut Datagram,
    platform: usize,
    state: &EcefState,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    datagram
        .begin(Type::Context, PLATFORM_STREAM + platform as u32, count, at)
        .u32(1 << 31 | 1 << 12)
        // UTC, real time, and by which clock.
        .u32(1 << 26 | 2 << 24 | OUI)
        .u32(at.seconds)
        .u64(at.picoseconds);
    for (values, point) in [(state.position_m, 5), (state.attitude_deg, 22), (state.velocity_mps, 16)] {
        for value in values {
            datagram.fixed(value, point);
        }
    }
    datagram.end()
}

/// The state of a platform in full, and what else is to be known of the pulse.
pub(super) fn state<'a>(
    datagram: &'a mut Datagram,
    pulse: &Pulse,
    platform: usize,
    earth: Option<&EcefState>,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    const NOWHERE: EcefState = EcefState {
        position_m: [f64::NAN; 3],
        velocity_mps: [f64::NAN; 3],
        attitude_quat: [f64::NAN; 4],
        attitude_deg: [f64::NAN; 3],
    };
    let record = pulse.nav_reported.get(platform).copied().unwrap_or_default();
    let earth = earth.unwrap_or(&NOWHERE);
    let packet = datagram
        .begin(Type::Extension(STATE), PLATFORM_STREAM + platform as u32, count, at)
        .u64(pulse.index)
        .u32(pulse.flags)
        .u32(u32::from(pulse.tx_pol) << 24 | platform as u32 & 0xffff)
        .f64(pulse.window_start_s)
        .i64(pulse.time.seconds())
        .f64(pulse.time.fraction_s())
        .f64(record.age_s)
        .u32(record.flags)
        .u32(pulse.nav_reported.len() as u32)
        .f64s(&record.position_m)
        .f64s(&record.velocity_mps)
        .f64s(&record.attitude_quat)
        .f64s(&earth.position_m)
        .f64s(&earth.velocity_mps)
        .f64s(&earth.attitude_quat);
    // An addition, of receivers with windows of their own.
    for start_s in &pulse.receiver_window_start_s {
        packet.f64(*start_s);
    }
    // Another, of antennas that scan: what their encoders read.
    for reading_deg in pulse.antennas.iter().filter_map(|antenna| antenna.encoder_deg) {
        packet.f64s(&reading_deg);
    }
    packet.end()
}
