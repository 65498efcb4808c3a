//! The ring alone: slots per second from one thread to another. Then a whole stream at pace `fast`, of pulses
//! of 40 kB that nobody fills: what remains is the way from generation over the pacer to the sinks.
//!
//! ```text
//! cargo bench --bench ring
//! ```

#![allow(clippy::expect_used, missing_docs)]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nereus::pulse::{Layout, Pulse};
use nereus::time::PulseTimes;
use nereus::transport::fanout::Fed;
use nereus::transport::ring::ring;
use nereus::transport::schedule::Schedule;
use nereus::transport::stage::Stream;
use nereus::transport::{Pace, Settings};

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

/// So many pulses to so many sinks, each of which looks at the first sample; how long they took.
fn stream_of(pulses: u64, sinks: usize) -> Duration {
    let layout = Layout { channels: 1, samples: 5000, ..Layout::default() };
    let settings = Settings { pace: Pace::Fast, ring_slots: 256, ..Settings::default() };
    let times = PulseTimes::uniform(2000.0).expect("a rate");
    let schedule = Schedule { times, first: 0, count: pulses };
    let mut stream = Stream::new(settings, schedule, layout, Arc::new(AtomicBool::new(false)));
    for k in 0..sinks {
        let added = stream.sink(&format!("sink {k}"), 256, |mut feed| {
            let mut seen = 0_u64;
            let look = |pulse: &Pulse| Ok::<_, String>(pulse.samples.as_bytes()[0]);
            loop {
                match feed.next(Duration::from_secs(1), look)? {
                    Fed::Pulse(_) => seen += 1,
                    Fed::Idle => {}
                    Fed::Ended => return Ok::<_, String>(seen),
                }
            }
        });
        assert!(added.is_ok());
    }
    let outcome = stream.run(|source| {
        for first in (0..pulses).step_by(BATCH) {
            let Some(slots) = source.reserve(BATCH.min((pulses - first) as usize)) else { break };
            let taken = slots.len();
            slots.iter_mut().zip(first..).for_each(|(slot, index)| slot.index = index);
            source.commit(taken);
        }
        Ok::<_, String>(())
    });
    assert!(outcome.reports.iter().all(|(_, seen)| *seen == pulses));
    Duration::from_secs_f64(outcome.summary.elapsed_s)
}

fn pulses(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("stream");
    group.throughput(Throughput::Elements(1));
    group.sample_size(10);
    for sinks in [1, 4] {
        group.bench_function(format!("pulse of 40 kB to {sinks} sinks"), |bencher| {
            bencher.iter_custom(|pulses| stream_of(pulses, sinks));
        });
    }
    group.finish();
}

criterion_group!(benches, pass, pulses);
criterion_main!(benches);
