//! What a sink sends, caught on loopback.

use std::collections::BTreeMap;
use std::net::UdpSocket;
use std::time::{Duration, Instant};

use nereus::pulse::Pulse;
use nereus::receive::Receiver;
use nereus::receive::report::Report;
use nereus::recording::header::Header;
use nereus::sinks::sink::{Sink, SinkReport};
use nereus::sinks::vita49::{Settings, Vita49Sink};

use crate::recording_fixture::pulse;

/// A socket of its own, and a sink that sends to it.
pub fn caught(header: &Header, mtu_bytes: usize) -> (UdpSocket, Box<Vita49Sink>) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(300))).unwrap();
    let settings =
        Settings { address: socket.local_addr().unwrap().to_string(), mtu_bytes, ..Settings::default() };
    let sink = Box::new(Vita49Sink::open(&settings, header).unwrap());
    (socket, sink)
}

/// The datagrams of pulses `from..to`, and what the sink reports. Read pulse by pulse, so that none is lost.
pub fn datagrams(header: &Header, mtu_bytes: usize, from: u64, to: u64) -> (Vec<Vec<u8>>, SinkReport) {
    datagrams_of(header, mtu_bytes, (from..to).map(|n| pulse(header, n)))
}

/// The same of other pulses.
pub fn datagrams_of(
    header: &Header,
    mtu_bytes: usize,
    pulses: impl Iterator<Item = Pulse>,
) -> (Vec<Vec<u8>>, SinkReport) {
    let (socket, mut sink) = caught(header, mtu_bytes);
    let mut all = Vec::new();
    let mut buffer = vec![0; 1 << 16];
    socket.set_nonblocking(true).unwrap();
    for pulse in pulses {
        sink.write(&pulse).unwrap();
        // On loopback a datagram is there when the call that sent it returns.
        while let Ok(length) = socket.recv(&mut buffer) {
            all.push(buffer[..length].to_vec());
        }
    }
    (all, sink.finish().unwrap())
}

/// What a receiver makes of datagrams: whole pulses and the report.
pub fn received<'a>(datagrams: impl IntoIterator<Item = &'a Vec<u8>>) -> (Vec<Pulse>, Report) {
    let (_, pulses, report) = received_with_header(datagrams);
    (pulses, report)
}

/// The same, and what it knows of the run at the end.
pub fn received_with_header<'a>(
    datagrams: impl IntoIterator<Item = &'a Vec<u8>>,
) -> (Option<Header>, Vec<Pulse>, Report) {
    let mut receiver = Receiver::new();
    let mut pulses = Vec::new();
    let mut keep = |pulse: Box<Pulse>| {
        pulses.push((*pulse).clone());
        Some(pulse)
    };
    for datagram in datagrams {
        receiver.take(datagram, Instant::now(), &mut keep);
    }
    let header = receiver.header().cloned();
    let report = receiver.finish(&mut keep);
    (header, pulses, report)
}

/// Big-endian word at a byte.
pub fn word(datagram: &[u8], at: usize) -> u32 {
    u32::from_be_bytes(datagram[at..at + 4].try_into().unwrap())
}

/// Big-endian double word at a byte.
pub fn long(datagram: &[u8], at: usize) -> u64 {
    u64::from_be_bytes(datagram[at..at + 8].try_into().unwrap())
}

/// Packet type: 1 signal, 4 context, 5 extension context.
pub fn kind(datagram: &[u8]) -> u32 {
    word(datagram, 0) >> 28
}

/// Datagrams by packet type and stream.
pub fn by_stream(datagrams: &[Vec<u8>]) -> BTreeMap<(u32, u32), Vec<&Vec<u8>>> {
    let mut streams: BTreeMap<(u32, u32), Vec<&Vec<u8>>> = BTreeMap::new();
    for datagram in datagrams {
        streams.entry((kind(datagram), word(datagram, 4))).or_default().push(datagram);
    }
    streams
}
