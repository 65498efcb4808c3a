//! The receiver of the wire: no datagrams make it panic, deafen it or take memory that the stream does not
//! call for.
//!
//! An input is a list of datagrams, each behind its length in two bytes. The size in a packet's header is put
//! right, so that what is changed elsewhere is looked at.
#![no_main]

use std::time::Instant;

use libfuzzer_sys::fuzz_target;
use nereus::receive::Receiver;

fuzz_target!(|bytes: &[u8]| {
    let mut receiver = Receiver::new();
    let (mut rest, now) = (bytes, Instant::now());
    let (mut sent, mut whole) = (0, 0);
    let mut packet = Vec::new();
    while let Some((length, behind)) = rest.split_first_chunk::<2>() {
        let length = usize::from(u16::from_le_bytes(*length)).min(behind.len());
        packet.clear();
        packet.extend_from_slice(&behind[..length]);
        rest = &behind[length..];
        if let [_, _, high, low, ..] = packet.as_mut_slice()
            && length % 4 == 0
        {
            [*high, *low] = ((length / 4) as u16).to_be_bytes();
        }
        sent += 1;
        receiver.take(&packet, now, &mut |pulse| {
            whole += 1;
            Some(pulse)
        });
    }
    let report = receiver.finish(&mut |pulse| Some(pulse));
    assert_eq!(report.datagrams, sent);
    assert!(report.malformed <= sent && report.pulses >= whole);
});
