//! Captures: packets in any order, sent twice, lost, of every link layer that is read.

use std::io::Write;

use nereus::nav::pcap::{self, CaptureError};
use proptest::prelude::*;

use crate::sources;

/// A capture of packets, little-endian, with a link layer.
fn capture(link: u32, packets: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = vec![0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0, 0];
    bytes.extend(link.to_le_bytes());
    for packet in packets {
        bytes.extend([0; 8]);
        bytes.extend((packet.len() as u32).to_le_bytes());
        bytes.extend((packet.len() as u32).to_le_bytes());
        bytes.extend(packet);
    }
    bytes
}

fn tcp(sequence: u32, flags: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x0B, 0xB9, 0x12, 0x34];
    bytes.extend(sequence.to_be_bytes());
    bytes.extend([0, 0, 0, 0, 5 << 4, flags, 0, 0, 0, 0, 0, 0]);
    bytes.extend(payload);
    bytes
}

fn udp(payload: &[u8]) -> Vec<u8> {
    let length = (8 + payload.len()) as u16;
    let mut bytes = vec![0x0B, 0xB9, 0x12, 0x34];
    bytes.extend(length.to_be_bytes());
    bytes.extend([0, 0]);
    bytes.extend(payload);
    bytes
}

fn ipv4(protocol: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x45, 0];
    bytes.extend(((20 + body.len()) as u16).to_be_bytes());
    bytes.extend([0, 0, 0x40, 0, 64, protocol, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2]);
    bytes.extend(body);
    bytes
}

fn ipv6(protocol: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x60, 0, 0, 0];
    bytes.extend((body.len() as u16).to_be_bytes());
    bytes.extend([protocol, 64]);
    bytes.extend([1; 16]);
    bytes.extend([2; 16]);
    bytes.extend(body);
    bytes
}

fn only(bytes: &[u8]) -> pcap::Stream {
    let mut capture = pcap::parse(bytes).unwrap();
    assert_eq!(capture.streams.len(), 1);
    capture.streams.remove(0)
}

#[test]
fn every_link_layer() {
    let ip = ipv4(6, &tcp(1, 0x10, b"hello"));
    let ether = |kind: &[u8], ip: &[u8]| [&[0; 12], kind, ip].concat();
    for (link, packet) in [
        (1, ether(&[0x08, 0x00], &ip)),
        (1, ether(&[0x81, 0x00, 0, 7, 0x08, 0x00], &ip)),
        (1, ether(&[0x86, 0xDD], &ipv6(17, &udp(b"hello")))),
        (0, [&[2, 0, 0, 0], &ip[..]].concat()),
        (101, ip.clone()),
        // The padding of a short frame is not payload.
        (113, [[0; 14].as_slice(), &[0x08, 0x00], &ip, &[0; 6]].concat()),
    ] {
        assert_eq!(only(&capture(link, &[packet])).bytes, b"hello", "{link}");
    }
    let stream = only(&capture(101, &[ip]));
    assert_eq!(stream.name, "tcp 10.0.0.1:3001 > 10.0.0.2:4660");
    // ARP, a fragment, a cut packet: left, and counted.
    let mut fragment = ipv4(17, &udp(b"x"));
    fragment[6] = 0x20;
    let mut cut = capture(1, &[ether(&[0x08, 0x06], &[0; 28]), ether(&[0x08, 0x00], &fragment)]);
    cut.extend([0; 10]);
    let found = pcap::parse(&cut).unwrap();
    assert_eq!((found.packets, found.left, found.streams.len()), (2, 3, 0));
    assert!(matches!(pcap::parse(&capture(147, &[])), Err(CaptureError::Link { found: 147 })));
}

#[test]
fn gzip_and_other_orders() {
    let plain = capture(101, &[ipv4(17, &udp(b"one ")), ipv4(17, &udp(b"two"))]);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&plain).unwrap();
    let packed = packed.finish().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("packed");
    std::fs::write(&path, &packed).unwrap();
    assert_eq!(pcap::load(&path).unwrap().streams[0].bytes, b"one two");
    std::fs::write(&path, &packed[..packed.len() / 2]).unwrap();
    assert!(matches!(pcap::load(&path), Err(CaptureError::File(_))));
    // Big-endian with nanoseconds.
    let ip = ipv4(17, &udp(b"big"));
    let mut big =
        vec![0xA1, 0xB2, 0x3C, 0x4D, 0, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0, 0, 0, 101];
    big.extend([0; 8]);
    big.extend((ip.len() as u32).to_be_bytes());
    big.extend((ip.len() as u32).to_be_bytes());
    big.extend(&ip);
    assert_eq!(only(&big).bytes, b"big");
}

/// A block of pcapng, little-endian.
fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let mut body = body.to_vec();
    body.resize(body.len().next_multiple_of(4), 0);
    let length = (12 + body.len() as u32).to_le_bytes();
    [&kind.to_le_bytes()[..], &length, &body, &length].concat()
}

/// Two interfaces of different link layers, and packets whose IP length is 0 as their sender's network card
/// gets them.
#[test]
fn pcapng_and_segmentation_offload() {
    let packet = |interface: u32, packet: &[u8]| {
        let length = (packet.len() as u32).to_le_bytes();
        block(6, &[&interface.to_le_bytes()[..], &[0; 8], &length, &length, packet].concat())
    };
    let unsized_ip = |sequence, payload: &[u8]| {
        let mut ip = ipv4(6, &tcp(sequence, 0x18, payload));
        (ip[2], ip[3]) = (0, 0);
        ip
    };
    let ether = [&[0; 12], &[0x08, 0x00][..], &unsized_ip(7, b"two")].concat();
    let head = [&0x1A2B_3C4D_u32.to_le_bytes()[..], &[1, 0, 0, 0], &[0xFF; 8]].concat();
    let capture = [
        block(0x0A0D_0D0A, &head),
        block(1, &[101, 0, 0, 0, 0, 0, 0, 0]),
        block(1, &[1, 0, 0, 0, 0, 0, 0, 0]),
        packet(0, &unsized_ip(3, b"one ")),
        packet(1, &ether),
    ]
    .concat();
    let stream = only(&capture);
    assert_eq!((stream.bytes.as_slice(), stream.missing_bytes), (&b"one two"[..], 0));
    let cut = pcap::parse(&capture[..capture.len() - 5]).unwrap();
    assert_eq!((cut.packets, cut.left, cut.streams[0].bytes.as_slice()), (1, 1, &b"one "[..]));
}

#[test]
fn the_cut_of_a_real_capture() {
    let capture = pcap::load(&sources::repository("tests/data/nav/span_90.pcap")).unwrap();
    assert_eq!((capture.packets, capture.left, capture.streams.len()), (90, 0, 1));
    let stream = &capture.streams[0];
    assert_eq!(
        (stream.name.as_str(), stream.missing_bytes),
        ("tcp 192.168.1.28:3001 > 192.168.1.21:35711", 0)
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(256) })]

    /// Segments shuffled and sent twice, numbers over their end, make the same stream; a lost one is a hole
    /// of its length.
    #[test]
    fn segments_in_any_order(
        lengths in proptest::collection::vec(1usize..40, 2..20),
        first in prop_oneof![any::<u32>(), (u32::MAX - 200)..=u32::MAX],
        order in proptest::collection::vec(any::<u32>(), 40),
        lost in any::<proptest::sample::Index>(),
    ) {
        let total: usize = lengths.iter().sum();
        let stream: Vec<u8> = (0..total).map(|i| i as u8).collect();
        let mut packets = Vec::new();
        let mut at = 0;
        for (index, length) in lengths.iter().enumerate() {
            let packet = ipv4(6, &tcp(first.wrapping_add(at as u32), 0x18, &stream[at..at + length]));
            packets.push((order[index], packet.clone()));
            packets.push((order[index + 20], packet));
            at += length;
        }
        let mut shuffled = packets.clone();
        shuffled.sort_by_key(|(key, _)| *key);
        let all: Vec<Vec<u8>> = shuffled.into_iter().map(|(_, packet)| packet).collect();
        let found = only(&capture(101, &all));
        prop_assert_eq!(&found.bytes, &stream);
        prop_assert_eq!(found.missing_bytes, 0);

        let lost = lost.index(lengths.len());
        let kept: Vec<Vec<u8>> = packets
            .iter()
            .enumerate()
            .filter(|(index, _)| index / 2 != lost)
            .map(|(_, (_, packet))| packet.clone())
            .collect();
        let found = only(&capture(101, &kept));
        let before: usize = lengths[..lost].iter().sum();
        prop_assert_eq!(&found.bytes, &[&stream[..before], &stream[before + lengths[lost]..]].concat());
        // What is lost at an end is not known to have been sent.
        let inside = lost > 0 && lost + 1 < lengths.len();
        prop_assert_eq!(found.missing_bytes, if inside { lengths[lost] as u64 } else { 0 });
    }
}
