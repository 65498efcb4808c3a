//! HDF5 recordings: a small one with some of its bytes changed, read to the end.
//!
//! An input is a list of changes of four bytes: the place, three bytes little-endian and modulo the length of
//! the file, and what stands there then.
#![no_main]

use std::path::PathBuf;
use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use nereus::recording::Recording;
use nereus::pulse::{Layout, Pulse, SampleFormat};
use nereus::sinks::hdf5::Hdf5Sink;
use nereus::recording::header::{ChannelRow, Header, PairRow};
use nereus::sinks::sink::Sink;
use nereus::time::{PulseTimes, TimeTag};

struct Seed {
    bytes: Vec<u8>,
    victim: PathBuf,
}

fn header() -> Header {
    let text = |text: &str| text.to_owned();
    Header {
        software: text("nereus fuzz"),
        carrier_hz: 10e9,
        sample_rate_hz: 100e6,
        bandwidth_hz: 80e6,
        pulse_s: 1e-6,
        prf_hz: 400.0,
        channels: vec![ChannelRow {
            name: text("HH"),
            transmitter: text("t"),
            receiver: text("r"),
            polarisations: text("HH"),
            ..ChannelRow::default()
        }],
        pairs: vec![PairRow { transmitter: text("t"), receiver: text("r") }],
        seed: 1,
        config: text("# a scenario\n"),
        replica: vec![Default::default(); 4],
        platforms: vec![text("p")],
        transmitters: vec![text("t")],
        receivers: vec![text("r")],
        targets: vec![text("buoy")],
        layout: Layout {
            channels: 1,
            samples: 8,
            platforms: 1,
            antennas: 2,
            targets: 1,
            pairs: 1,
            ..Layout::default()
        },
        pulses: 16,
        truth: true,
        ..Header::default()
    }
}

fn seed() -> &'static Seed {
    static SEED: OnceLock<Seed> = OnceLock::new();
    SEED.get_or_init(|| {
        let folder = ["/dev/shm", "/tmp"].map(PathBuf::from).into_iter().find(|folder| folder.is_dir());
        let folder = folder.unwrap_or_default();
        let victim = folder.join(format!("nereus-fuzz-{}.h5", std::process::id()));
        let header = header();
        let mut sink: Box<dyn Sink> =
            Box::new(Hdf5Sink::create(&victim, None, true, &header).expect("the seed is made"));
        let mut pulse = Pulse::new(&header.layout);
        let times = PulseTimes::uniform(header.prf_hz).expect("a PRF");
        for index in 0..header.pulses {
            pulse.index = index;
            pulse.time = times.emission(header.start, index);
            sink.write(&pulse).expect("a pulse is written");
        }
        sink.finish().expect("the seed is closed");
        let bytes = std::fs::read(&victim).expect("the seed is read");
        Seed { bytes, victim }
    })
}

fuzz_target!(|changes: &[u8]| {
    let Seed { bytes, victim } = seed();
    let mut bytes = bytes.clone();
    for change in changes.as_chunks::<4>().0 {
        let [a, b, c, value] = *change;
        let at = u32::from_le_bytes([a, b, c, 0]) as usize % bytes.len();
        bytes[at] = value;
    }
    std::fs::write(victim, &bytes).expect("the file is written");
    if let Ok(recording) = Recording::open(victim, None) {
        assert!(recording.pulses() > 0);
        let _ = recording.true_path("t");
        let _ = recording.boresights("r");
        let _ = recording.window(0, 0);
    }
});
