//! SBET: no figures make the reader panic or let anything through that is not finite.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::nav::{AttitudeSource, FileFormat, FileSource, Place, Smoothing, VerticalDatum, replay};

fuzz_target!(|bytes: &[u8]| {
    let (week, bytes) = bytes.split_at(bytes.len().min(2));
    let gps_week = week.iter().fold(0, |week, byte| week << 8 | u32::from(*byte));
    let source = FileSource {
        path: "fuzz".into(),
        format: FileFormat::Sbet { gps_week },
        datum: VerticalDatum::Ellipsoid,
        undulation_m: 0.0,
        max_gap_s: 1e9,
        smoothing: Smoothing::Off,
        attitude: AttitudeSource::Recorded,
        first_day: None,
        bounds: nereus::nav::MotionBounds::SPACECRAFT,
    };
    if let Ok(recording) = replay::parse(bytes, &source) {
        for fix in recording.fixes {
            let Place::Geodetic(place) = fix.place else { panic!("not geodetic") };
            assert!(place.lat_rad.is_finite() && place.h_m.is_finite());
            assert!(fix.velocity_mps.is_some_and(|v| v.iter().all(|v| v.is_finite())));
        }
    }
});
