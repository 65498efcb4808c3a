//! The packets that describe the radar: waveform and receive filter, replica, antennas. A processor behind
//! the wire needs them, and receivers of earlier versions leave them: each kind has streams of its own.

use super::datagram::{Datagram, EXTENSION_PROLOGUE, Type, text_bytes};
use super::stamp::Stamp;
use crate::recording::header::Header;
use crate::recording::instrument::{AntennaRow, Instrument, Look};

/// Stream of the waveform and the receive filter.
const SIGNAL_STREAM: u32 = 0x5000_0000;
/// Stream of the replica.
const REPLICA_STREAM: u32 = 0x6000_0000;
/// Stream of the description of antenna 0; the others follow.
const ANTENNA_STREAM: u32 = 0x7000_0000;

/// Packet classes of extension contexts.
const SIGNAL: u16 = 5;
const REPLICA: u16 = 6;
const ANTENNA: u16 = 7;

/// Longest replica that is sent.
pub(super) const REPLICA_SAMPLES: usize = 1 << 20;

/// In place of the platform of a window that follows nothing: blocks without a gap. Receivers of earlier
/// versions do not look at it.
const CONTINUOUS: u32 = 1;

/// Bytes before the samples of a piece of the replica, and of one of them.
const PIECE: usize = 16;
const SAMPLE: usize = 8;

/// Samples of the replica that are sent.
pub(super) fn replica_samples(header: &Header) -> usize {
    let samples = header.replica.len();
    if samples <= REPLICA_SAMPLES { samples } else { 0 }
}

/// Samples in a piece of the replica.
pub(super) fn replica_piece(room: usize) -> usize {
    room.saturating_sub(EXTENSION_PROLOGUE + PIECE) / SAMPLE
}

/// Kind of a place to look at, and the platform beside which it lies.
fn look_words(look: Option<&Look>, header: &Header) -> [u32; 2] {
    match look {
        None | Some(Look::Body { .. }) => [0, 0],
        Some(Look::Point { .. }) => [1, 0],
        Some(Look::Beside { platform, .. }) => [2, platform_number(platform, header)],
    }
}

fn platform_number(name: &str, header: &Header) -> u32 {
    header.platforms.iter().position(|known| known == name).unwrap_or(0) as u32
}

/// The description of waveform and receive filter.
pub(super) fn signal<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    instrument: &Instrument,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    let Instrument { waveform, filter, earth_radius_factor, window, continuous, middle_m, .. } = instrument;
    let [kind, platform] = look_words(window.as_ref(), header);
    // Where nothing is followed there is no platform.
    let platform = if window.is_none() && *continuous { CONTINUOUS } else { platform };
    let number = |value: &Option<f64>| value.unwrap_or(f64::NAN);
    datagram
        .begin(Type::Extension(SIGNAL), SIGNAL_STREAM, count, at)
        .f64s(&[number(&waveform.sweep_hz_per_s), number(&waveform.rate_hz)])
        .f64s(&[filter.flat_hz, filter.zero_hz, number(earth_radius_factor)])
        .f64s(middle_m)
        .u32(kind)
        .u32(platform)
        .f64s(&window.as_ref().map_or([0.0; 6], Look::numbers))
        .text(&waveform.kind)
        .text(&filter.kind)
        .end()
}

/// The samples of the replica from `first`, as many as a piece has.
pub(super) fn replica<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    (first, piece): (usize, usize),
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    let all = &header.replica;
    datagram
        .begin(Type::Extension(REPLICA), REPLICA_STREAM, count, at)
        .u32(first as u32)
        .u32(piece as u32)
        .u32(all.len() as u32)
        .u32(0);
    for sample in all.iter().skip(first).take(piece) {
        datagram.u32(sample.re.to_bits()).u32(sample.im.to_bits());
    }
    datagram.end()
}

/// The description of an antenna.
pub(super) fn antenna<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    (number, row): (usize, &AntennaRow),
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    let [kind, beside] = look_words(Some(&row.look), header);
    datagram
        .begin(Type::Extension(ANTENNA), ANTENNA_STREAM + number as u32, count, at)
        .u32(number as u32)
        .u32(header.layout.antennas as u32)
        .u32(u32::from(!row.transmits))
        .u32(platform_number(&row.platform, header))
        .f64s(&row.lever_arm_m)
        .f64s(&row.aperture_m.unwrap_or([f64::NAN; 2]))
        .u32(kind)
        .u32(beside)
        .f64s(&row.look.numbers())
        .text(&row.name)
        .text(&row.pattern)
        .end()
}

/// Bytes of the longest of these descriptions.
pub(super) fn longest(instrument: &Instrument) -> usize {
    let signal = 112 + text_bytes(&instrument.waveform.kind) + text_bytes(&instrument.filter.kind);
    let antennas = &instrument.antennas;
    let antenna = antennas.iter().map(|row| 112 + text_bytes(&row.name) + text_bytes(&row.pattern)).max();
    signal.max(antenna.unwrap_or(0))
}
