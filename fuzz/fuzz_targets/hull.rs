//! Offset tables of hulls.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::scene::hull::Particulars;
use nereus::scene::hull::table;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(hull) = table::parse("fuzz", text)
    {
        let _ = Particulars::of(&hull).values();
    }
});
