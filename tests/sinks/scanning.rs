//! Antennas that scan: what recordings and the wire say of them, and of what their encoders read.

use nereus::pulse::{Pulse, SampleFormat};
use nereus::recording::Recording;
use nereus::recording::header::Header;
use nereus::recording::instrument::Look;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;

use crate::recording_fixture::{header, instrument, pulse};
use crate::wire_fixture::{datagrams_of, received_with_header};

const LOOK: Look =
    Look::Scan { level: true, rate_deg_per_s: 144.0, sector_deg: [-20.0, 30.0], elevation_deg: -2.0 };

/// The receiver scans, the transmitter does not.
fn scanning() -> Header {
    let mut header = header(SampleFormat::Ci16);
    let mut instrument = instrument();
    instrument.antennas[1].look = LOOK;
    header.instrument = Some(instrument);
    header.pulses = 40;
    header
}

fn reading_deg(n: u64) -> [f64; 2] {
    [(0.12 * n as f64 + 359.0) % 360.0, -2.0 + 1e-3 * n as f64]
}

fn read(header: &Header, n: u64) -> Pulse {
    let mut pulse = pulse(header, n);
    // Otherwise than by the fixture.
    pulse.antennas[1].encoder_deg = Some(reading_deg(n));
    pulse
}

#[test]
fn recordings_hold_what_encoders_read() {
    let folder = tempfile::tempdir().unwrap();
    let sent = scanning();
    for hdf5 in [false, true].into_iter().filter(|hdf5| !hdf5 || cfg!(feature = "hdf5")) {
        let path = folder.path().join(if hdf5 { "scan.h5" } else { "scan" });
        let mut sink: Box<dyn Sink> = match hdf5 {
            #[cfg(feature = "hdf5")]
            true => Box::new(nereus::sinks::hdf5::Hdf5Sink::create(&path, None, false, &sent).unwrap()),
            _ => Box::new(PlainSink::create(&path, false, &sent).unwrap()),
        };
        (0..20).for_each(|n| sink.write(&read(&sent, n)).unwrap());
        sink.finish().unwrap();
        let recording = Recording::open(&path, Some(5..15)).unwrap();
        assert_eq!(recording.header.instrument.as_ref().unwrap().antennas[1].look, LOOK);
        let mut slot = Pulse::new(&recording.layout());
        for place in 0..10 {
            recording.pulse(place, &mut slot);
            let read: Vec<_> = slot.antennas.iter().map(|antenna| antenna.encoder_deg).collect();
            assert_eq!(read, [None, Some(reading_deg(5 + place as u64))]);
        }
    }
}

#[test]
fn the_wire_carries_what_encoders_read() {
    let sent = scanning();
    let (all, _) = datagrams_of(&sent, 1500, (0..20).map(|n| read(&sent, n)));
    let (header, found, report) = received_with_header(&all);
    assert_eq!(header.unwrap().instrument.unwrap().antennas[1].look, LOOK);
    assert_eq!(found.len(), 20);
    for (n, found) in found.iter().enumerate() {
        let read: Vec<_> = found.antennas.iter().map(|antenna| antenna.encoder_deg).collect();
        assert_eq!(read, [None, Some(reading_deg(n as u64))]);
    }
    assert_eq!((report.incomplete, report.malformed, report.unknown, report.stray), (0, 0, 0, 0));
}
