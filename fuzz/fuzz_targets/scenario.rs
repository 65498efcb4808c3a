//! Scenarios: no text makes the reader panic; files that a text names are looked for in an empty folder.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = nereus::config::parse(text, Path::new("/nonexistent/scenario.toml"), &[]);
    }
});
