//! Cost of back-projection, all cores: `cargo bench --bench focus`.
//! Criterion's elements are pulses times pixels; 512 x 512 pixels and 500 pulses are 131 Melem.
#![allow(clippy::unwrap_used, missing_docs)]

use std::f64::consts::PI;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::geometry::phase_path::PhasePath;
use nereus::processor::backproject::{Aperture, PulseEcho, fast, reference};
use nereus::processor::range_compress::{Compressor, PulseShape, RangeFilter};
use nereus::processor::taper::Taper;
use nereus::recording::ground::Ground;
use nereus::scene::radar::Band;
use num_complex::Complex32;

const PULSES: usize = 500;
const PRF_HZ: f64 = 222.0;
const SAMPLES: usize = 512;

fn sweep(len: usize) -> Vec<Complex32> {
    let phase = |i: usize| (PI * 60e6 / 0.333e-6 * (i as f64 / 100e6 - 0.1665e-6).powi(2)) as f32;
    (0..len).map(|i| Complex32::cis(phase(i))).collect()
}

fn focus(c: &mut Criterion) {
    let times_s: Vec<f64> = (0..PULSES).map(|i| i as f64 / PRF_HZ).collect();
    let line = |y_m: f64| {
        let points = times_s.iter().map(|t| [222.0 * t - 250.0, y_m, 3000.0]).collect();
        PhasePath::new(times_s.clone(), points).unwrap()
    };
    let (transmitter, receiver) = (line(-6000.0), line(-3000.0));
    let replica = sweep(34);
    let shape = PulseShape {
        replica: &replica,
        turns: 1,
        sample_rate_hz: 100e6,
        band: Band::about(0.0, 60e6),
        pulse_s: 0.333e-6,
    };
    let compressor = Compressor::new(shape, SAMPLES, RangeFilter::Matched, Taper::Uniform, 16).unwrap();
    let samples = sweep(SAMPLES);
    let echoes = |count: usize| -> Vec<PulseEcho> {
        let echo = |t: &f64| PulseEcho {
            emission_s: *t,
            number: 0,
            window_start_s: 35.0e-6,
            weight: 1.0,
            samples: &samples,
        };
        times_s.iter().take(count).map(echo).collect()
    };
    let aperture = |count: usize| Aperture {
        carrier_hz: 10e9,
        compressor: &compressor,
        transmitter: &transmitter,
        receiver: &receiver,
        pulses: echoes(count),
        centre_m: [0.0; 3],
        gate: None,
    };
    let mut group = c.benchmark_group("focus, two aircraft");
    group.sample_size(10);
    let ground = Ground::map([0.0; 3], [512.0, 512.0], 1.0).unwrap();
    group.throughput(Throughput::Elements((PULSES * ground.len()) as u64));
    let whole = aperture(PULSES);
    group.bench_function("fast, 512 x 512, 500 pulses", |b| b.iter(|| fast(&whole, &[ground], &|_| ())));
    let small = Ground::map([0.0; 3], [32.0, 32.0], 1.0).unwrap();
    let few = aperture(20);
    group.throughput(Throughput::Elements((20 * small.len()) as u64));
    group.bench_function("reference, 32 x 32, 20 pulses", |b| b.iter(|| reference(&few, &small)));
    group.finish();
}

criterion_group!(benches, focus);
criterion_main!(benches);
