//! Logs that cost more than they hold. Limits are those of a loaded machine: what they replace took minutes.

use std::time::Instant;

use nereus::nav::ais;
use nereus::nav::decode::Decoder;

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
    frame[..10].copy_from_slice(&[0xAA, 0x44, 0x12, 0x1C, 0xB9, 0x05, 0, 0x20, 0xE0, 0x3E]);
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

#[test]
fn a_hundred_thousand_vessels_are_read_at_once() {
    let mut text = String::from("Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n");
    for vessel in 0..100_000 {
        text.push_str(&format!("2016-01-12 13:02:11.218,{},50.773,-1.093,157.8,5.9\n", 200_000_000 + vessel));
    }
    let took = seconds(|| assert_eq!(ais::parse(text.as_bytes()).unwrap().len(), 100_000));
    assert!(took < 5.0, "{took} s");
}
