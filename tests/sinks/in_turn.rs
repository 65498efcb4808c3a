//! Pulses in turn: what recordings, the wire and SigMF say of each.

use nereus::pulse::SampleFormat;
use nereus::recording::Recording;
use nereus::recording::header::Header;
use nereus::recording::instrument::{PulseRow, WaveformRow};
use nereus::recording::sigmf::{Settings, export};
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;
use num_complex::Complex32;
use serde_json::Value;

use crate::recording_fixture::{header, instrument, pulse};
use crate::wire_fixture::{datagrams, received_with_header};

/// Three pulses: a sweep, a plain one 20 MHz above it, a sweep from a file.
fn sent() -> Header {
    let row = |kind: &str, offset_hz, bandwidth_hz, sweep_hz_per_s| PulseRow {
        kind: kind.to_owned(),
        offset_hz,
        bandwidth_hz,
        pulse_s: 1e-6,
        sweep_hz_per_s,
    };
    let pulses =
        vec![row("lfm", -10e6, 8e6, Some(8e12)), row("cw", 20e6, 1e6, None), row("samples", 0.0, 3e6, None)];
    let waveform = WaveformRow { kind: "in-turn".into(), sweep_hz_per_s: None, rate_hz: None, pulses };
    let instrument = nereus::recording::instrument::Instrument { waveform, ..instrument() };
    let replica = (0..12).map(|k| Complex32::new(k as f32, 1.0)).collect();
    Header { instrument: Some(instrument), replica, pulses: 0, ..header(SampleFormat::Cf32) }
}

#[test]
fn recordings_and_their_exports_say_what_each_is() {
    let folder = tempfile::tempdir().unwrap();
    let sent = sent();
    let path = folder.path().join("r");
    let mut sink = Box::new(PlainSink::create(&path, false, &sent).unwrap());
    (0..5).for_each(|n| sink.write(&pulse(&sent, n)).unwrap());
    sink.finish().unwrap();
    let header = Recording::open(&path, None).unwrap().header;
    assert_eq!((header.turns(), header.instrument.as_ref()), (3, sent.instrument.as_ref()));
    // From the lower edge of the first to the upper one of the second.
    let band = header.band();
    assert_eq!([band.from_hz, band.to_hz, band.reach_hz()], [-14e6, 20.5e6, 20.5e6]);
    let meta =
        |path: &std::path::Path| -> Value { serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap() };
    // Who takes the replica for that of one pulse refuses it.
    let of_receivers = meta(&path.join("meta.json"))["version"].as_u64().unwrap();
    assert_eq!(of_receivers, 3);
    let settings = Settings { out: folder.path().join("out"), ..Settings::default() };
    export(&path, &settings).unwrap();
    let exported = meta(&folder.path().join("out-HV.sigmf-meta"));
    for (n, annotation) in exported["annotations"].as_array().unwrap().iter().enumerate() {
        let row = &sent.in_turn()[n % 3];
        let edge = |name: &str| annotation[name].as_f64().unwrap() - sent.carrier_hz;
        let wide = 0.5 * row.bandwidth_hz;
        let found = [edge("core:freq_lower_edge"), edge("core:freq_upper_edge")];
        assert_eq!(found, [row.offset_hz - wide, row.offset_hz + wide], "pulse {n}");
    }
    // A replica that does not hold so many.
    let mut wrong = sent.clone();
    wrong.replica.pop();
    let error = wrong.check().unwrap_err().to_string();
    assert!(error.contains("3 pulses in turn in a replica of 11"), "{error}");
}

#[test]
fn the_wire_says_what_each_is() {
    let sent = sent();
    let (all, report) = datagrams(&sent, 1500, 0, 6);
    assert!(report.wire.is_some());
    let (header, pulses, report) = received_with_header(&all);
    let header = header.unwrap();
    assert_eq!((header.in_turn(), header.turns()), (sent.in_turn(), 3));
    assert_eq!((header.replica, pulses.len()), (sent.replica.clone(), 6));
    assert_eq!(report.unknown + report.malformed, 0, "{report:?}");
    // Without one of the three descriptions nothing is known of the run.
    let second = |datagram: &&Vec<u8>| crate::wire_fixture::word(datagram, 4) != 0x9000_0001;
    let (header, pulses, _) = received_with_header(all.iter().filter(second));
    assert!(header.is_none() && pulses.is_empty());
}
