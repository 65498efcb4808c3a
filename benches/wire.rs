//! The network sink alone: pulses per second of four channels of 384 samples, to a socket of this machine
//! that is not read, and what the reference receiver takes to read them.
//!
//! ```text
//! cargo bench --bench wire
//! ```

use std::net::UdpSocket;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::pulse::{Layout, Pulse, SampleFormat};
use nereus::receive::Receiver;
use nereus::recording::header::{AdcRow, ChannelRow, Header, Origin};
use nereus::sinks::sink::Sink;
use nereus::sinks::vita49::{Settings, Vita49Sink};
use nereus::time::PulseTimes;

const PRF_HZ: f64 = 222.0;

fn header(format: SampleFormat) -> Header {
    let channel = |name: &str| ChannelRow {
        name: name.to_owned(),
        transmitter: "tx".to_owned(),
        receiver: "rx".to_owned(),
        polarisations: name.to_owned(),
        ..ChannelRow::default()
    };
    Header {
        software: "bench".to_owned(),
        carrier_hz: 10e9,
        sample_rate_hz: 100e6,
        bandwidth_hz: 60e6,
        pulse_s: 0.333e-6,
        prf_hz: PRF_HZ,
        channels: ["HH", "HV", "VH", "VV"].map(channel).to_vec(),
        origin: Some(Origin { lat_deg: 51.0, lon_deg: 1.5, h_m: 45.0 }),
        seed: 1,
        platforms: vec!["coast".to_owned(), "aircraft".to_owned()],
        layout: Layout { channels: 4, samples: 384, format, platforms: 2, ..Layout::default() },
        adc: (format == SampleFormat::Ci16).then_some(AdcRow { bits: 12, step: 1e-8 }),
        pulses: u64::MAX,
        ..Header::default()
    }
}

fn send(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("wire");
    group.throughput(Throughput::Elements(1)).sample_size(20);
    let Ok(times) = PulseTimes::uniform(PRF_HZ) else { return };
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let header = header(format);
        let Ok(socket) = UdpSocket::bind("127.0.0.1:0") else { return };
        let Ok(address) = socket.local_addr() else { return };
        let settings = Settings { address: address.to_string(), ..Settings::default() };
        let Ok(mut sink) = Vita49Sink::open(&settings, &header) else { return };
        let mut pulse = Pulse::new(&header.layout);
        group.bench_function(format!("send a pulse, {format:?}"), |bencher| {
            bencher.iter(|| {
                pulse.index += 1;
                pulse.time = times.emission(header.start, pulse.index);
                sink.write(&pulse)
            });
        });
        // The datagrams of some pulses, read again and again by receivers that know nothing yet.
        let Ok(mut sink) = Vita49Sink::open(&settings, &header) else { return };
        if socket.set_nonblocking(true).is_err() {
            return;
        }
        let mut buffer = vec![0; 2048];
        while socket.recv(&mut buffer).is_ok() {}
        let mut datagrams = Vec::new();
        const PULSES: u64 = 64;
        for index in 0..PULSES {
            pulse.index = index;
            pulse.time = times.emission(header.start, index);
            if sink.write(&pulse).is_err() {
                return;
            }
            while let Ok(length) = socket.recv(&mut buffer) {
                datagrams.push(buffer[..length].to_vec());
            }
        }
        group.throughput(Throughput::Elements(PULSES));
        group.bench_function(format!("take apart {PULSES} pulses, {format:?}"), |bencher| {
            bencher.iter(|| {
                let mut receiver = Receiver::new();
                let now = Instant::now();
                for datagram in &datagrams {
                    receiver.take(datagram, now, &mut Some);
                }
                receiver.finish(&mut Some).pulses
            });
        });
        group.throughput(Throughput::Elements(1));
    }
    group.finish();
}

criterion_group!(benches, send);
criterion_main!(benches);
