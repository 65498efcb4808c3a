//! Streams whose generation does nothing but take time.

use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use nereus::pulse::{Layout, Pulse, SampleFormat};
use nereus::time::PulseTimes;
use nereus::transport::fanout::{Fed, Feed};
use nereus::transport::schedule::Schedule;
use nereus::transport::stage::{Source, Stream};
use nereus::transport::{Pace, Policy, Settings};

pub const LAYOUT: Layout = Layout {
    channels: 2,
    samples: 64,
    format: SampleFormat::Cf32,
    platforms: 2,
    antennas: 2,
    targets: 3,
    pairs: 1,
    windows: 0,
    ships: 0,
    clocks: 0,
};

/// What a sink saw of one pulse.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    pub index: u64,
    pub flags: u32,
    pub at: Instant,
}

pub type TestStream<'a> = Stream<'a, Vec<Seen>, String>;

pub fn stream<'a>(pace: Pace, policy: Policy, latency_s: f64, first: u64, count: u64) -> TestStream<'a> {
    let settings = Settings { pace, policy, latency_s, ring_slots: 64, threads: 1, ..Settings::default() };
    let schedule = Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first, count };
    Stream::new(settings, schedule, LAYOUT, Arc::new(AtomicBool::new(false)))
}

/// A sink that takes `each` for a pulse and remembers what it saw.
pub fn remember(mut feed: Feed, each: Duration) -> Result<Vec<Seen>, String> {
    let mut seen = Vec::new();
    let look =
        |pulse: &Pulse| Ok::<_, String>(Seen { index: pulse.index, flags: pulse.flags, at: Instant::now() });
    loop {
        match feed.next(Duration::from_millis(200), look)? {
            Fed::Pulse(one) => seen.push(one),
            Fed::Idle => {}
            Fed::Ended => return Ok(seen),
        }
        if !each.is_zero() {
            thread::sleep(each);
        }
    }
}

/// Makes pulses first..end in batches, taking `each` for a pulse; skips what is not worth making.
pub fn generate(source: &mut Source, first: u64, end: u64, batch: u64, each: Duration) -> Result<(), String> {
    let mut index = first;
    while index < end {
        index = index.max(source.next_worth());
        let n = batch.min(end.saturating_sub(index));
        if n == 0 {
            break;
        }
        let Some(slots) = source.reserve(n as usize) else { break };
        let n = slots.len();
        for (k, slot) in slots.iter_mut().enumerate() {
            slot.index = index + k as u64;
            slot.flags = 0;
            if !each.is_zero() {
                thread::sleep(each);
            }
        }
        source.commit(n);
        index += n as u64;
    }
    Ok(())
}

/// Runs one ignored test alone.
pub fn in_a_process_of_its_own(test: &str) {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--ignored", "--nocapture", "--test-threads=1"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&child.stdout);
    println!("{text}{}", String::from_utf8_lossy(&child.stderr));
    assert!(child.status.success() && text.contains("1 passed"));
}
