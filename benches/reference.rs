//! Cost of the reference echo: one call of a pulse's spectrum, and one scatterer path in all bins and
//! channels.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::echo::reference::ReferenceEcho;
use nereus::paths::list::ScattererPaths;
use nereus::pulse::{Layout, Pulse};
use nereus::radar::phasor::phasor;
use nereus::radar::receiver::Receiver;
use nereus::radar::waveform::{Lfm, Sampled, Waveform};
use nereus::scene::radar::{Gate, Sweep, Window};
use nereus::scene::{self, Radar};
use nereus::time::PulseTimes;
use num_complex::Complex64;

const BINS: usize = 384;

fn spectra(c: &mut Criterion) {
    let mut group = c.benchmark_group("waveform_spectrum");
    group.throughput(Throughput::Elements(BINS as u64));
    let samples = (0..256).map(|i| phasor(f64::from(i * i) / 1024.0)).collect();
    let waveforms: [(&str, Box<dyn Waveform>); 3] = [
        ("lfm_bt20", Box::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap())),
        ("lfm_bt1e4", Box::new(Lfm::new(60e6, 1e4 / 60e6, Sweep::Up).unwrap())),
        ("samples_256", Box::new(Sampled::new(samples, 200e6).unwrap())),
    ];
    for (name, waveform) in &waveforms {
        group.bench_function(*name, |b| {
            b.iter(|| {
                (0..BINS)
                    .map(|k| waveform.spectrum(black_box(k as f64 * 100e6 / BINS as f64 - 50e6)))
                    .sum::<Complex64>()
            });
        });
    }
    group.finish();
}

fn echo(c: &mut Criterion) {
    let mut group = c.benchmark_group("reference_echo");
    for channels in [1, 4] {
        let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
        let echo = ReferenceEcho::with_period(pulse, 10e9, 100e6, 286, vec![0; channels], BINS);
        let mut paths = ScattererPaths::new(1, channels, 1);
        paths.emission_offset_s.push(0.0);
        paths.delay_s[0].push(24.123_456e-6);
        paths.delay_rate[0].push(-4.3e-8);
        paths.amplitude.iter_mut().for_each(|a| a.push(Complex64::new(1e-6, 2e-6)));
        let mut out = vec![Complex64::ZERO; channels * BINS];
        // Throughput in scatterer path-bins: the inverse is ns per scatterer path and bin.
        group.throughput(Throughput::Elements(BINS as u64));
        group.bench_function(format!("1_path_384_bins_{channels}_channels"), |b| {
            b.iter(|| echo.spectrum(black_box(&paths), 23.6e-6, &mut out));
        });
    }
    group.finish();
}

fn receive(c: &mut Criterion) {
    let radar = Radar {
        noise_figure_db: Some(3.0),
        ..Radar::new(
            10e9,
            100e6,
            scene::radar::Waveform::Lfm { bandwidth_hz: 60e6, duration_s: 0.333e-6, sweep: Sweep::Up },
            PulseTimes::uniform(222.0).unwrap(),
            Window { samples: 286, gate: Gate::Fixed { start_s: 0.0 } },
        )
    };
    let receiver = Receiver::new(&radar, 1, BINS, 4);
    let mut scratch = receiver.scratch();
    let layout = Layout { channels: 4, samples: 286, format: receiver.sample_format(), ..Layout::default() };
    let mut pulse = Pulse::new(&layout);
    let mut spectrum = vec![Complex64::ZERO; 4 * BINS];
    c.bench_function("receive_384_bins_4_channels_with_noise", |b| {
        b.iter(|| {
            spectrum.fill(Complex64::ZERO);
            receiver.receive(black_box(&mut spectrum), &mut pulse, &mut scratch)
        });
    });
}

criterion_group!(benches, spectra, echo, receive);
criterion_main!(benches);
