//! Measured antenna patterns.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::radar::pattern::GridPattern;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(pattern) = GridPattern::parse(bytes, -60.0) {
        for (az, el) in [(0.0, 0.0), (3.1, 1.5), (-0.2, -1.57)] {
            let gain = pattern.field_gain(az, el);
            assert!(gain.re.is_finite() && gain.im.is_finite());
        }
    }
});
