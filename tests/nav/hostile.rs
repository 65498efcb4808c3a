//! Logs that cost more than they hold. Limits are those of a loaded machine: what they replace took minutes.

use std::time::Instant;

use nereus::config;
use nereus::nav::decode::Decoder;
use nereus::nav::{ais, pcap};

/// What a log of a hundred thousand vessels may take, s; in a release build on an idle machine it is below
/// 0.4 s, without optimisation ten times as much.
const VESSELS_S: f64 = 5.0;

fn seconds(work: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    work();
    begun.elapsed().as_secs_f64()
}

fn decode(bytes: &[u8]) -> (u64, u64) {
    let mut decoder = Decoder::new();
    decoder.push(bytes, &mut |_| {});
    decoder.finish(&mut |_| {});
    (decoder.counts().bad_checksum, decoder.counts().malformed)
}

/// Frames of 16 KiB, announced every 16 bytes. Before: 16 KiB of CRC for each, 4 MiB took 20 s.
#[test]
fn announced_frames_cost_their_bytes() {
    let mut frame = [0_u8; 16];
    frame[..10].copy_from_slice(&[0xAA, 0x44, 0x12, 0x1C, 0x2B, 0, 0, 0x20, 0xE0, 0x3E]);
    let bomb = frame.repeat((4 << 20) / 16);
    let mut bad = 0;
    let took = seconds(|| bad = decode(&bomb).0);
    assert!(bad > 250_000, "{bad}");
    assert!(took < 5.0, "{took} s");
}

/// Sentences within sentences. Before: the checksum of the rest of the line for each `$`.
#[test]
fn sentences_within_a_line_cost_their_bytes() {
    let line = [&b"$".repeat(4000)[..], b"*00\n"].concat();
    let took = seconds(|| assert!(decode(&line.repeat(1000)).1 > 0));
    assert!(took < 5.0, "{took} s");
}

/// A log of a hundred thousand vessels, a report each.
fn log() -> String {
    let mut text = String::from("Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n");
    for vessel in 0..100_000 {
        text.push_str(&format!("2016-01-12 13:02:11.218,{},50.773,-1.093,157.8,5.9\n", 200_000_000 + vessel));
    }
    text
}

#[test]
fn a_hundred_thousand_vessels_are_read_at_once() {
    let text = log();
    let took = seconds(|| assert_eq!(ais::parse(text.as_bytes()).unwrap().reports.len(), 100_000));
    assert!(took < VESSELS_S, "{took} s");
}

/// The same in a scenario: a ship each, which are too many, and one that is not among them.
#[test]
fn a_scenario_with_a_hundred_thousand_vessels_is_read_at_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), log()).unwrap();
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/sea.toml");
    let text = std::fs::read_to_string(scenario).unwrap();
    for (key, expected) in [("within_m = 1e7", "at most 1000"), ("mmsi = [1]", "no vessel \"1\"")] {
        let text = text.replacen(
            "[scene]",
            "[scene]\norigin_lat_deg = 50.773\norigin_lon_deg = -1.093\norigin_h_m = 0.0\n",
            1,
        );
        let log = format!("\n[[ais]]\nlog = \"log.csv\"\nstart_utc = \"2016-01-12T13:02:11Z\"\n{key}\n");
        let path = folder.path().join("s.toml");
        let mut printed = String::new();
        let took = seconds(|| {
            printed =
                config::parse(&(text + &log), &path, &[]).err().map_or_else(String::new, |e| e.to_string());
        });
        assert!(printed.contains(expected), "{}", &printed[..printed.len().min(2000)]);
        assert!(took < VESSELS_S, "{key}: {took} s");
    }
}

/// A position report of class A (ITU-R M.1371-5, message 1) as a datagram of IPv4.
fn datagram(vessel: u32, port: u16) -> Vec<u8> {
    // 168 bits: type, repeat, MMSI, and a position that is not available.
    let bits = 1u64 << 58 | u64::from(200_000_000 + vessel) << 26;
    let letter = |value: u64| char::from(if value < 40 { value as u8 + 48 } else { value as u8 + 56 });
    let payload: String =
        (0..28).map(|at| letter(if at < 10 { bits >> (58 - 6 * at) & 63 } else { 0 })).collect();
    let body = format!("AIVDM,1,1,,A,{payload},0");
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    let sentence = format!("!{body}*{sum:02X}\r\n").into_bytes();
    let udp_length = 8 + sentence.len() as u16;
    let mut packet = vec![0x45, 0];
    packet.extend((20 + udp_length).to_be_bytes());
    packet.extend([0, 0, 0x40, 0, 64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2]);
    packet.extend(port.to_be_bytes());
    packet.extend(10110_u16.to_be_bytes());
    packet.extend(udp_length.to_be_bytes());
    packet.extend([0, 0]);
    packet.extend(sentence);
    packet
}

/// A capture of a harbour: a hundred thousand vessels in one stream, and from as many ports as there are.
#[test]
fn a_capture_of_a_hundred_thousand_vessels_is_read_at_once() {
    for ports in [1, 60_000] {
        let mut bytes = vec![0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0, 0];
        bytes.extend(101_u32.to_le_bytes());
        for vessel in 0..100_000 {
            let packet = datagram(vessel, 1024 + (vessel % ports) as u16);
            bytes.extend([0; 8]);
            bytes.extend((packet.len() as u32).to_le_bytes());
            bytes.extend((packet.len() as u32).to_le_bytes());
            bytes.extend(packet);
        }
        let mut unknown = 0;
        let took = seconds(|| {
            let capture = pcap::parse(&bytes).unwrap();
            assert_eq!((capture.packets, capture.streams.len() as u32), (100_000, ports.min(1024)));
            for stream in capture.streams {
                let mut decoder = Decoder::new();
                decoder.push(&stream.bytes, &mut |_| {});
                decoder.finish(&mut |_| {});
                unknown += decoder.counts().unknown;
            }
        });
        println!("{ports} ports: {unknown} messages in {took:.2} s");
        // Of further streams than are read nothing is kept.
        let kept = if ports == 1 { 100_000 } else { 2 * 1024 };
        assert_eq!(unknown, kept, "{ports} ports");
        assert!(took < VESSELS_S, "{ports} ports: {took} s");
    }
}
