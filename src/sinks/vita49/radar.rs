//! The packets that describe the radar: waveform and receive filter, replica, antennas, and emitters beside
//! it. A processor behind the wire needs them, and receivers of earlier versions leave them: each kind has
//! streams of its own.

use super::datagram::{Datagram, EXTENSION_PROLOGUE, Type, text_bytes};
use super::stamp::Stamp;
use crate::recording::header::Header;
use crate::recording::instrument::{AntennaRow, EmitterRow, GateRow, Instrument, Look, PulseRow};

/// Stream of the waveform and the receive filter.
const SIGNAL_STREAM: u32 = 0x5000_0000;
/// Stream of the replica.
const REPLICA_STREAM: u32 = 0x6000_0000;
/// Stream of the description of antenna 0; the others follow.
const ANTENNA_STREAM: u32 = 0x7000_0000;
/// Stream of the description of emitter 0; the others follow.
const EMITTER_STREAM: u32 = 0x8000_0000;
/// Stream of the description of pulse 0 of several in turn; the others follow.
const PULSE_STREAM: u32 = 0x9000_0000;

/// Packet classes of extension contexts.
const SIGNAL: u16 = 5;
const REPLICA: u16 = 6;
const ANTENNA: u16 = 7;
const EMITTER: u16 = 8;
const PULSE: u16 = 9;

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

/// Appends a place to look at: its kind, the platform beside which it lies (of none, what it says instead),
/// its numbers.
fn looks<'a>(
    datagram: &'a mut Datagram,
    (look, of_none): (Option<&Look>, u32),
    header: &Header,
) -> &'a mut Datagram {
    let [kind, beside] = match look {
        None => [0, of_none],
        Some(Look::Body { .. }) => [0, 0],
        Some(Look::Point { .. }) => [1, 0],
        Some(Look::Beside { platform, .. }) => [2, platform_number(platform, header)],
        Some(Look::Scan { level, .. }) => [3, u32::from(*level)],
    };
    datagram.u32(kind).u32(beside).f64s(&look.map_or([0.0; 6], Look::numbers))
}

/// Appends the platform of an antenna, its lever arm, its aperture, where it looks.
fn mount<'a>(datagram: &'a mut Datagram, row: &AntennaRow, header: &Header) -> &'a mut Datagram {
    datagram
        .u32(platform_number(&row.platform, header))
        .f64s(&row.lever_arm_m)
        .f64s(&row.aperture_m.unwrap_or([f64::NAN; 2]));
    looks(datagram, (Some(&row.look), 0), header)
}

fn number(value: &Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
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
    let error_classes_db = &instrument.error_classes_db[..];
    datagram
        .begin(Type::Extension(SIGNAL), SIGNAL_STREAM, count, at)
        .f64s(&[number(&waveform.sweep_hz_per_s), number(&waveform.rate_hz)])
        .f64s(&[filter.flat_hz, filter.zero_hz, number(earth_radius_factor)])
        .f64s(middle_m);
    let of_none = if *continuous { CONTINUOUS } else { 0 };
    let packet = looks(datagram, (window.as_ref(), of_none), header).text(&waveform.kind).text(&filter.kind);
    // An addition: the error of each class of pulses, and how many leave in turn.
    if !error_classes_db.is_empty() || !waveform.pulses.is_empty() {
        let counts = [error_classes_db.len(), waveform.pulses.len()].map(|count| count as u32);
        packet.u32(counts[0]).u32(counts[1]).f64s(error_classes_db);
    }
    packet.end()
}

/// The description of one of several pulses in turn.
pub(super) fn pulse<'a>(
    datagram: &'a mut Datagram,
    (place, of): (usize, usize),
    row: &PulseRow,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    datagram
        .begin(Type::Extension(PULSE), PULSE_STREAM + place as u32, count, at)
        .u32(place as u32)
        .u32(of as u32)
        .f64s(&[row.offset_hz, row.bandwidth_hz, row.pulse_s, number(&row.sweep_hz_per_s)])
        .text(&row.kind)
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
    datagram
        .begin(Type::Extension(ANTENNA), ANTENNA_STREAM + number as u32, count, at)
        .u32(number as u32)
        .u32(header.layout.antennas as u32)
        .u32(u32::from(!row.transmits));
    let packet = mount(datagram, row, header).text(&row.name).text(&row.pattern);
    // An addition: a window of its own.
    match &row.window {
        None => packet,
        Some(GateRow::Fixed { start_s }) => looks(packet.u32(1).u32(0).f64(*start_s), (None, 0), header),
        Some(GateRow::Follow { look, lead_s }) => {
            looks(packet.u32(2).u32(0).f64(*lead_s), (Some(look), 0), header)
        }
    }
    .end()
}

/// The description of an emitter, with the intervals of its sequence if they fit so many bytes.
pub(super) fn emitter<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    (place, row): (usize, &EmitterRow),
    room: usize,
    count: u8,
    at: Stamp,
) -> &'a [u8] {
    let EmitterRow { antenna, waveform, .. } = row;
    let least = EXTENSION_PROLOGUE + emitter_bytes(row);
    let pri_s = if least + 8 * row.pri_s.len() <= room { &row.pri_s[..] } else { &[] };
    datagram
        .begin(Type::Extension(EMITTER), EMITTER_STREAM + place as u32, count, at)
        .u32(place as u32)
        .u32(header.emitters().len() as u32)
        .u32(u32::from(row.direct_path) | u32::from(row.echo) << 1);
    mount(datagram, antenna, header)
        .f64s(&[row.carrier_hz, row.bandwidth_hz, row.pulse_s])
        .f64s(&[number(&waveform.sweep_hz_per_s), number(&waveform.rate_hz)])
        .f64s(&[row.start_s, row.prf_hz, row.power_w])
        .u32(row.intervals)
        .u32(pri_s.len() as u32)
        .f64s(pri_s)
        .u32(row.receivers.len() as u32);
    for name in &row.receivers {
        datagram.u32(header.receivers.iter().position(|known| known == name).unwrap_or(0) as u32);
    }
    emitter_texts(row).into_iter().fold(datagram, Datagram::text).end()
}

fn emitter_texts(row: &EmitterRow) -> [&str; 5] {
    let EmitterRow { antenna, waveform, polarisation, basis, .. } = row;
    [&antenna.name, &antenna.pattern, polarisation, basis, &waveform.kind]
}

/// Bytes of the description of an emitter without its intervals.
fn emitter_bytes(row: &EmitterRow) -> usize {
    188 + 4 * row.receivers.len() + emitter_texts(row).into_iter().map(text_bytes).sum::<usize>()
}

/// Bytes of the longest of these descriptions.
pub(super) fn longest(instrument: &Instrument) -> usize {
    let signal = 120
        + 8 * instrument.error_classes_db.len()
        + text_bytes(&instrument.waveform.kind)
        + text_bytes(&instrument.filter.kind);
    let antennas = &instrument.antennas;
    let antenna = antennas.iter().map(|row| {
        let window = if row.window.is_some() { 72 } else { 0 };
        112 + text_bytes(&row.name) + text_bytes(&row.pattern) + window
    });
    let emitters = instrument.emitters.iter().map(emitter_bytes);
    antenna.chain(emitters).fold(signal, usize::max)
}
