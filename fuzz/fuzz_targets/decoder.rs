//! The decoder and the assembler: no bytes make them panic, and cuts change nothing.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nereus::nav::decode::Decoder;
use nereus::nav::epoch::Assembler;
use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, replay};

fuzz_target!(|bytes: &[u8]| {
    let mut decoder = Decoder::new();
    let mut assembler = Assembler::new();
    let mut messages = Vec::new();
    let mut epochs = Vec::new();
    let mut see = |message| {
        messages.push(message);
        assembler.push(&message, &mut |epoch| epochs.push(epoch));
    };
    decoder.push(bytes, &mut see);
    decoder.finish(&mut see);
    epochs.extend(assembler.finish());
    for epoch in &epochs {
        if let Some(fix) = epoch.fix(VerticalDatum::MeanSeaLevel, 40.0) {
            assert!(fix.time.fraction_s() < 1.0);
        }
    }

    let mut again = Decoder::new();
    let mut others = Vec::new();
    let length = 1 + bytes.first().copied().map_or(0, usize::from) % 17;
    for piece in bytes.chunks(length) {
        again.push(piece, &mut |message| others.push(message));
    }
    again.finish(&mut |message| others.push(message));
    assert_eq!(messages, others);
    assert_eq!(decoder.counts(), again.counts());

    for format in [FileFormat::Nmea, FileFormat::Inspvax] {
        let source = FileSource {
            path: "fuzz".into(),
            format,
            datum: VerticalDatum::MeanSeaLevel,
            undulation_m: 40.0,
            max_gap_s: 1e9,
            smoothing: Smoothing::Off,
            attitude: AttitudeSource::Level,
            first_day: None,
            bounds: nereus::nav::MotionBounds::SPACECRAFT,
        };
        let _ = replay::parse(bytes, &source);
    }
});
