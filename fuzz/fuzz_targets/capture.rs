//! Captures: no bytes make the reader panic, and it hands on no more bytes than there are.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if bytes.starts_with(&[0x1F, 0x8B]) {
        return;
    }
    if let Ok(capture) = nereus::nav::pcap::parse(bytes) {
        assert!(capture.streams.iter().map(|stream| stream.bytes.len()).sum::<usize>() <= bytes.len());
    }
});
