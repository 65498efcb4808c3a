//! Tracks and AIS logs as comma-separated values.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, ais, replay};

fuzz_target!(|bytes: &[u8]| {
    let source = FileSource {
        path: "fuzz".into(),
        format: FileFormat::Csv,
        datum: VerticalDatum::MeanSeaLevel,
        undulation_m: 40.0,
        max_gap_s: 1e9,
        smoothing: Smoothing::Off,
        attitude: AttitudeSource::Level,
        first_day: None,
        bounds: nereus::nav::MotionBounds::SPACECRAFT,
    };
    let _ = replay::parse(bytes, &source);
    let _ = ais::parse(bytes);
});
