//! The ring alone: slots per second from one thread to another.
//!
//! ```text
//! cargo bench --bench ring
//! ```

use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::transport::ring::ring;

const BATCH: usize = 16;

fn pass(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ring");
    group.throughput(Throughput::Elements(BATCH as u64));
    group.sample_size(20);
    group.bench_function("batch of 16 slots, thread to thread", |bencher| {
        bencher.iter_custom(|rounds| {
            let (mut producer, mut consumer) = ring((0..256).map(|_| [0u64; 8]));
            let go = AtomicBool::new(false);
            let begun = Instant::now();
            thread::scope(|scope| {
                scope.spawn(|| {
                    while let Some(slot) = consumer.wait(&go) {
                        consumer.give_back(slot);
                    }
                });
                for round in 0..rounds {
                    let Some(batch) = producer.reserve(BATCH, &go) else { break };
                    batch.iter_mut().for_each(|slot| slot[0] = round);
                    producer.commit(BATCH);
                }
                drop(producer);
            });
            begun.elapsed()
        });
    });
    group.finish();
}

criterion_group!(benches, pass);
criterion_main!(benches);
