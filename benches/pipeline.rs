//! The whole way, on the calibration scene: pulses per second made, and lateness of the release beside that
//! of a bare absolute-sleep loop run right after it.
//!
//! ```text
//! cargo bench --bench pipeline
//! ```
#![allow(clippy::expect_used, missing_docs)]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use nereus::config::Run;
use nereus::pipeline::build;
use nereus::transport::Pace;

fn calibration() -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/calibration.toml");
    let mut run = nereus::config::load(&path, &[]).expect("the calibration scene is good");
    run.sinks.clear();
    run
}

fn make(criterion: &mut Criterion) {
    let run = calibration();
    let stream = build::stream(&run, 0..run.scene.pulses).expect("the calibration scene builds");
    let factory = stream.factory();
    let (mut slot, mut worker) = (factory.slot(), factory.worker());
    let mut group = criterion.benchmark_group("calibration");
    group.throughput(Throughput::Elements(1));
    let mut index = 0;
    group.bench_function("pulse, one thread", |bencher| {
        bencher.iter(|| {
            index = (index + 37) % run.scene.pulses;
            worker.make(index, black_box(&mut slot)).expect("a pulse of the run");
        });
    });
    group.finish();
}

/// Lateness of a loop that only sleeps, microseconds: p50, p99, worst.
fn bare_loop(prf_hz: f64, pulses: u32) -> [f64; 3] {
    let sleeper = spin_sleep::SpinSleeper::new(200_000);
    let start = Instant::now();
    let mut late: Vec<f64> = (1..=pulses)
        .map(|n| {
            let deadline = start + Duration::from_secs_f64(f64::from(n) / prf_hz);
            sleeper.sleep_until(deadline);
            Instant::now().saturating_duration_since(deadline).as_secs_f64() * 1e6
        })
        .collect();
    late.sort_by(f64::total_cmp);
    [late.len() / 2, late.len() * 99 / 100, late.len() - 1].map(|i| late[i])
}

fn pace() {
    for _ in 0..3 {
        let mut run = calibration();
        run.stream.pace = Pace::Realtime;
        let prf_hz = run.scene.radar.emissions.mean_prf_hz();
        let pulses = (5.0 * prf_hz) as u64;
        let outcome = build::stream(&run, 0..pulses)
            .and_then(|stream| stream.run(&Arc::new(AtomicBool::new(false)), None))
            .expect("the calibration scene runs");
        let health = outcome.summary.health;
        let late = health.lateness_us;
        let [p50, p99, worst] = bare_loop(prf_hz, pulses as u32);
        println!(
            "{prf_hz} Hz, {} pulses: {} late, {} dropped, made at {:.1} times real time\n  \
             lateness us: p50 {:.1}, p99 {:.1}, worst {:.1}; bare loop p50 {p50:.1}, p99 {p99:.1}, worst {worst:.1}",
            health.pulses,
            health.late,
            health.dropped,
            outcome.summary.real_time_factor,
            late.p50,
            late.p99,
            late.max,
        );
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args().sample_size(20);
    make(&mut criterion);
    criterion.final_summary();
    pace();
}
