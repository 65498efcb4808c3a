//! The inner loop of the fast echo, one thread: million scatterer path-pulses per second, by variant and
//! width, with the error against the f64 reference on a part of the same scatterer paths.
//!
//! `cargo bench --bench kernel [-- CONTACTS]` (default 262144). A patch of 512 m x 512 m seen from 3 km at 45
//! degrees, 64 pulses at 222 Hz, four channels. Figures are medians of five runs, in time of the thread on
//! its core where Linux reports it (other work on the machine then disturbs less), else by the clock.
#![allow(clippy::unwrap_used, missing_docs)]

use std::sync::Arc;
use std::time::Instant;

use nereus::echo::reference::ReferenceEcho;
use nereus::echo::synth::block::Node;
use nereus::echo::synth::doppler::Doppler;
use nereus::echo::synth::{Settings, Synth, Variant};
use nereus::paths::list::ScattererPaths;
use nereus::radar::waveform::Lfm;
use nereus::rng::{Room, stream};
use nereus::scene::radar::Sweep;
use nereus::units::SPEED_OF_LIGHT_MPS as C;
use num_complex::Complex64;
use rand_distr::{Distribution, StandardNormal};

const CARRIER_HZ: f64 = 10e9;
const RATE_HZ: f64 = 100e6;
const PRF_HZ: f64 = 222.0;
const SPEED_MPS: f64 = 222.0;
const PULSES: usize = 64;
const NODES: [usize; 4] = [0, 21, 42, 63];
/// Samples of the window: the patch is 2.5 us deep.
const WINDOW: usize = 320;
const WINDOW_START_S: f64 = 26.6e-6;
/// Spectra that are timed: the kernel counts a thread's time in ticks of up to 4 ms, and one takes some 6 us.
const SPECTRA: usize = 20_000;
/// Scatterer paths on which the error is measured, in pulses `CHECKED`.
const SUBSET: usize = 2048;
const CHECKED: [usize; 3] = [0, 32, 63];

/// Facets at a pulse, every `side / n`-th of the patch in rows along the flight, amplitudes fixed.
fn facets(count: usize, pulse: usize) -> ScattererPaths {
    let side = (count as f64).sqrt().ceil() as usize;
    let mut paths = ScattererPaths::new(1, 4, count);
    let mut numbers = stream(5, Room::ReceiverNoise, 0, 0);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut numbers) };
    let x_radar = SPEED_MPS * (pulse as f64 - 31.5) / PRF_HZ;
    for n in 0..count {
        let (ix, iy) = (n % side, n / side);
        let x = 512.0 * ((ix as f64 + 0.5) / side as f64 - 0.5) + 0.1 * gauss();
        let y = 512.0 * ((iy as f64 + 0.5) / side as f64 - 0.5) + 0.1 * gauss();
        let z = gauss();
        let (dx, dy, dz) = (x - x_radar, y + 3000.0, z - 3000.0);
        let range_m = (dx * dx + dy * dy + dz * dz).sqrt();
        paths.emission_offset_s.push(0.0);
        paths.delay_s[0].push(2.0 * range_m / C);
        paths.delay_rate[0].push(-2.0 * SPEED_MPS * dx / range_m / C);
        for channel in &mut paths.amplitude {
            channel.push(Complex64::new(gauss(), gauss()));
        }
    }
    paths
}

fn main() {
    let nodes_per_block = NODES.len();
    let count = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(262_144);
    let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
    let reference = ReferenceEcho::new(pulse.clone(), CARRIER_HZ, RATE_HZ, WINDOW, vec![0; 4]);
    let windows_s = [WINDOW_START_S; PULSES];
    let whole: Vec<ScattererPaths> = NODES.iter().map(|p| facets(count, *p)).collect();
    let part: Vec<ScattererPaths> = NODES.iter().map(|p| facets(SUBSET, *p)).collect();
    let nodes = |lists: &'static [ScattererPaths]| -> Vec<Node<'static>> {
        NODES.iter().zip(lists).map(|(pulse, paths)| Node { pulse: *pulse, paths }).collect()
    };
    let (whole, part) = (nodes(whole.leak()), nodes(part.leak()));
    let len = reference.fft_len();
    let truth: Vec<Vec<Complex64>> = CHECKED
        .iter()
        .map(|p| {
            let mut out = vec![Complex64::ZERO; 4 * len];
            reference.spectrum(&facets(SUBSET, *p), WINDOW_START_S, &mut out);
            out
        })
        .collect();
    println!(
        "{count} paths x {PULSES} pulses x 4 channels, {nodes_per_block} nodes (cubic amplitudes), f32, one thread"
    );
    println!(
        "variant    width     Mpath-pulse/s  ns each  cycles*  fill ms  spectra us/pulse  error dB (predicted)"
    );
    for variant in Variant::ALL {
        if !variant.is_available() {
            println!("{variant}: not on this CPU");
            continue;
        }
        for width in 4..=7 {
            let settings =
                Settings { width, doppler: Doppler::Shift, variant: Some(variant), ..Settings::default() };
            let synth =
                Synth::<f32>::new(pulse.clone(), CARRIER_HZ, RATE_HZ, WINDOW, &[0; 4], settings).unwrap();
            let (mut block, mut grids, mut scratch) = (synth.block(), synth.grids(), synth.scratch());
            let mut out = vec![Complex64::ZERO; 4 * len];
            synth.fill(&part, &windows_s, &mut block).unwrap();
            synth.spread(&block, &mut grids);
            let mut worst_db = f64::NEG_INFINITY;
            for (pulse, truth) in CHECKED.iter().zip(&truth) {
                synth.spectrum(&block, &grids, *pulse, &mut scratch, &mut out);
                for (fast, truth) in out.chunks(len).zip(truth.chunks(len)) {
                    let wrong: f64 = fast.iter().zip(truth).map(|(a, b)| (a - b).norm_sqr()).sum();
                    let all: f64 = truth.iter().map(|b| b.norm_sqr()).sum();
                    worst_db = worst_db.max(10.0 * (wrong / all).log10());
                }
            }
            let predicted = synth.predicted_error(&block).total_db();
            let started = Stopwatch::start();
            synth.fill(&whole, &windows_s, &mut block).unwrap();
            let fill_s = started.seconds();
            let mut spread_s: Vec<f64> = (0..5)
                .map(|_| {
                    synth.clear(&block, &mut grids);
                    let started = Stopwatch::start();
                    for mut share in grids.shares(1) {
                        synth.spread_share(&block, &mut share);
                    }
                    started.seconds()
                })
                .collect();
            spread_s.sort_by(f64::total_cmp);
            let started = Stopwatch::start();
            for pulse in (0..PULSES).cycle().take(SPECTRA) {
                synth.spectrum(&block, &grids, pulse, &mut scratch, &mut out);
            }
            let spectra_s = started.seconds() / SPECTRA as f64;
            let each_s = spread_s[2] / (count * PULSES) as f64;
            println!(
                "{:<10} {width:>5}  {:>16.1}  {:>7.2}  {:>7.1}  {:>7.1}  {:>16.1}  {worst_db:>8.1} ({predicted:.1})",
                variant.to_string(),
                1e-6 / each_s,
                1e9 * each_s,
                each_s * ticks_per_s(),
                1e3 * fill_s,
                1e6 * spectra_s,
            );
        }
    }
    println!("* ticks of the time stamp counter, which need not be the core's clock");
}

/// Time that this thread was on a core, to a tick of the scheduler (1 to 4 ms).
struct Stopwatch {
    thread_ns: Option<u64>,
    clock: Instant,
}

impl Stopwatch {
    fn start() -> Self {
        Self { thread_ns: thread_ns(), clock: Instant::now() }
    }

    fn seconds(&self) -> f64 {
        match (self.thread_ns, thread_ns()) {
            (Some(from), Some(to)) => (to - from) as f64 * 1e-9,
            _ => self.clock.elapsed().as_secs_f64(),
        }
    }
}

fn thread_ns() -> Option<u64> {
    std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split_whitespace().next()?.parse().ok()
}

/// Rate of the time stamp counter, measured over 20 ms.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
fn ticks_per_s() -> f64 {
    // SAFETY: every x86-64 CPU has the instruction.
    let ticks = || unsafe { std::arch::x86_64::_rdtsc() };
    let (from, started) = (ticks(), Instant::now());
    while started.elapsed().as_secs_f64() < 0.02 {}
    (ticks() - from) as f64 / started.elapsed().as_secs_f64()
}

/// No counter: no figure.
#[cfg(not(target_arch = "x86_64"))]
fn ticks_per_s() -> f64 {
    f64::NAN
}
