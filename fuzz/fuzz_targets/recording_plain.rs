//! What describes a plain recording: `meta.json`, then, behind a byte of 0, `replica.bin`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::recording::plain_header;
use nereus::recording::columns::columns;

fuzz_target!(|bytes: &[u8]| {
    let at = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let (meta, replica) = (&bytes[..at], bytes.get(at + 1..).unwrap_or_default());
    if let Ok(header) = plain_header(meta, replica) {
        assert!(header.carrier_hz.is_finite() && header.sample_rate_hz > 0.0 && header.prf_hz > 0.0);
        // Sizes of rows are counted without overflow.
        let row: usize = columns(&header).iter().map(|column| column.row_bytes()).sum();
        assert!(row > 0);
    }
});
