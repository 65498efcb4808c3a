//! States of the sea: what is read is finite, and is written as the same bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::sea::surface::Surface;

/// The checksum behind a state: 64-bit FNV-1a.
fn sum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

fuzz_target!(|bytes: &[u8]| {
    // With the checksum put right, or nothing else would be looked at.
    let mut bytes = bytes.to_vec();
    if let Some((body, last)) = bytes.split_last_chunk_mut::<8>() {
        *last = sum(body).to_le_bytes();
    }
    if let Ok(surface) = Surface::load(&mut bytes.as_slice()) {
        let mut again = Vec::new();
        assert!(surface.save(&mut again).is_ok());
        assert_eq!(again, bytes);
    }
});
