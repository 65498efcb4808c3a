//! Cost of the reference echo: one call of a pulse's spectrum, and one contact in all bins and channels.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::echo::reference::ReferenceEcho;
use nereus::radar::phasor::phasor;
use nereus::radar::waveform::{Lfm, Sampled, Waveform};
use nereus::scattering::contact::Contacts;
use nereus::scene::radar::Sweep;
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
        let mut contacts = Contacts::new(1, channels, 1);
        contacts.emission_offset_s.push(0.0);
        contacts.delay_s[0].push(24.123_456e-6);
        contacts.delay_rate[0].push(-4.3e-8);
        contacts.amplitude.iter_mut().for_each(|a| a.push(Complex64::new(1e-6, 2e-6)));
        let mut out = vec![Complex64::ZERO; channels * BINS];
        // Throughput in contact-bins: the inverse is ns per contact and bin.
        group.throughput(Throughput::Elements(BINS as u64));
        group.bench_function(format!("1_contact_384_bins_{channels}_channels"), |b| {
            b.iter(|| echo.spectrum(black_box(&contacts), 23.6e-6, &mut out));
        });
    }
    group.finish();
}

criterion_group!(benches, spectra, echo);
criterion_main!(benches);
