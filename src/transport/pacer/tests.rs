//! The pacer against rings that are filled by hand.

use super::*;
use crate::pulse::{Layout, SampleFormat};
use crate::time::PulseTimes;
use crate::transport::fanout::{self, Fed, Role};
use crate::transport::health::Snapshot;
use crate::transport::ring::ring;

/// The least that a pulse can have.
pub const LAYOUT: Layout = Layout {
    channels: 1,
    samples: 1,
    format: SampleFormat::Cf32,
    platforms: 0,
    antennas: 0,
    targets: 0,
    pairs: 0,
    windows: 0,
    ships: 0,
    clocks: 0,
};

/// A pacer whose ring already holds pulses with these indices, and its health.
fn filled(policy: Policy, indices: &[u64], count: u64) -> (Pacer, Arc<Health>) {
    let (mut producer, ring) = ring(indices.iter().map(|_| Pulse::new(&LAYOUT)));
    let never = AtomicBool::new(false);
    for (slot, &index) in producer.reserve(indices.len(), &never).unwrap().iter_mut().zip(indices) {
        slot.index = index;
    }
    producer.commit(indices.len());
    let health = Arc::new(Health::new(Vec::new(), 0));
    let pacer = Pacer {
        ring,
        fan_out: FanOut::new(Vec::new(), &Settings::default(), &LAYOUT),
        schedule: Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count },
        settings: Settings {
            pace: Pace::Realtime,
            policy,
            latency_s: 0.0,
            ring_slots: 8,
            threads: 1,
            ..Settings::default()
        },
        health: Arc::clone(&health),
        worth: Worth::default(),
        status: None,
    };
    (pacer, health)
}

#[test]
fn a_pacer_that_is_late_itself_is_no_underrun() {
    for policy in [Policy::Stop, Policy::Slip, Policy::Drop] {
        let (pacer, health) = filled(policy, &[0, 1, 2, 3], 4);
        let start = Instant::now().checked_sub(Duration::from_millis(100)).unwrap();
        pacer.run(start, &AtomicBool::new(false)).unwrap();
        let shot = health.snapshot();
        // Time that slips is not made up for: the others are in time.
        let (late, slipped) = if policy == Policy::Slip { (1, 0.1) } else { (4, 0.0) };
        assert_eq!((shot.pulses, shot.dropped), (4, 0), "{policy:?}");
        assert!(shot.late >= late && shot.held_up == shot.late, "{policy:?} {shot:?}");
        assert!(shot.slipped_s >= slipped && (slipped > 0.0 || shot.slipped_s == 0.0), "{policy:?} {shot:?}");
        assert!(shot.lateness_us.max >= 97_000.0, "{policy:?} {shot:?}");
    }
}

/// Each batch comes less than an interval later than the one before: at last they are too late all the
/// same.
#[test]
fn a_generation_that_is_short_by_little_is_short() {
    let (batches, batch) = (60, 10);
    let (mut producer, ring) = ring((0..4 * batch).map(|_| Pulse::new(&LAYOUT)));
    let (template, health) = filled(Policy::Drop, &[0], (batches * batch) as u64);
    let pacer = Pacer { ring, ..template };
    thread::scope(|scope| {
        let start = Instant::now();
        let pacing = scope.spawn(move || pacer.run(start, &AtomicBool::new(false)));
        let never = AtomicBool::new(false);
        for n in 0..batches {
            for (slot, index) in producer.reserve(batch, &never).unwrap().iter_mut().zip(n * batch..) {
                slot.index = index as u64;
            }
            // A batch of 10 ms takes 10.5.
            let due = start + Duration::from_micros(10_500) * n as u32;
            thread::sleep(due.saturating_duration_since(Instant::now()));
            producer.commit(batch);
        }
        drop(producer);
        pacing.join().unwrap().unwrap();
    });
    let shot = health.snapshot();
    assert!(shot.dropped > 0, "{shot:?}");
}

/// A batch that comes late is late from its first pulse to its last: nothing of it leaves in a burst.
#[test]
fn a_late_batch_is_discarded_whole() {
    let (mut producer, ring) = ring((0..4).map(|_| Pulse::new(&LAYOUT)));
    let (template, health) = filled(Policy::Drop, &[0], 4);
    let pacer = Pacer { ring, ..template };
    let ended = thread::scope(|scope| {
        let pacing = scope.spawn(|| pacer.run(Instant::now(), &AtomicBool::new(false)));
        let never = AtomicBool::new(false);
        for (slot, index) in producer.reserve(4, &never).unwrap().iter_mut().zip(0..) {
            slot.index = index;
        }
        thread::sleep(Duration::from_millis(50));
        producer.commit(4);
        drop(producer);
        pacing.join().unwrap()
    });
    let shot = health.snapshot();
    assert_eq!((shot.pulses, shot.late, shot.dropped), (0, 0, 4));
    // Nor does a run end well that released nothing.
    let Err(error @ PacerError::NothingReleased { pulses: 4, .. }) = ended else { panic!("{ended:?}") };
    insta::assert_snapshot!(error, @r#"not one pulse of 4 was released: policy = "drop" discards what is made too late, and all of them were. Allowed: stream.latency_ms = 1 or more (it is 0; pulses are made in blocks, and a block for every thread is that long), a lighter scene, policy = "slip", or --pace fast"#);
}

/// What left, and when, of a stream whose pulses wait in the ring since the machine stood still for 20 s, to
/// a sink that takes `each` for a pulse.
fn after_a_standstill(
    policy: Policy,
    prf_hz: f64,
    indices: &[u64],
    each: Duration,
) -> (Vec<(u64, Instant)>, Snapshot) {
    let count = indices.last().unwrap() + 1;
    let (template, _) = filled(policy, indices, count);
    let schedule = Schedule { times: PulseTimes::uniform(prf_hz).unwrap(), first: 0, count };
    let role = Role { lossless: true, may_fail: false };
    let queue = if each.is_zero() { 256 } else { 4 };
    let (outlet, mut feed) = fanout::outlet("slow", queue, role, &LAYOUT).unwrap();
    let health = Arc::new(Health::new(vec![outlet.health()], 0));
    let fan_out = FanOut::new(vec![outlet], &template.settings, &LAYOUT);
    let pacer = Pacer { fan_out, schedule, health: Arc::clone(&health), ..template };
    let start = Instant::now().checked_sub(Duration::from_secs(20)).unwrap();
    let left = thread::scope(|scope| {
        scope.spawn(|| pacer.run(start, &AtomicBool::new(false)).unwrap());
        let mut left = Vec::new();
        loop {
            let take = |pulse: &Pulse| Ok::<_, ()>((pulse.index, Instant::now()));
            match feed.next(Duration::from_secs(1), take).unwrap() {
                Fed::Pulse(pulse) => left.push(pulse),
                Fed::Idle => {}
                Fed::Ended => return left,
            }
            thread::sleep(each);
        }
    });
    (left, health.snapshot())
}

fn indices(left: &[(u64, Instant)]) -> Vec<u64> {
    left.iter().map(|(index, _)| *index).collect()
}

/// Before: pulses left in one burst, and all but the first few found the queue full.
#[test]
fn overdue_pulses_wait_for_a_sink_that_is_slow() {
    let all: Vec<u64> = (0..50).collect();
    // At 100 Hz: one that makes up for it, and for slip one that never does.
    for (policy, each_ms) in [(Policy::Stop, 4), (Policy::Slip, 15)] {
        let (left, shot) = after_a_standstill(policy, 100.0, &all, Duration::from_millis(each_ms));
        assert_eq!(indices(&left), all, "{policy:?}");
        assert_eq!((shot.pulses, shot.dropped, shot.missed), (50, 0, 0), "{policy:?} {shot:?}");
        assert!(shot.late > 0, "{policy:?} {shot:?}");
    }
}

/// Before: a burst, whoever could not take it.
#[test]
fn overdue_pulses_leave_half_an_interval_apart() {
    let all: Vec<u64> = (0..100).collect();
    let lasts = |policy| {
        let (left, _) = after_a_standstill(policy, 1000.0, &all, Duration::ZERO);
        left.last().unwrap().1 - left[0].1
    };
    // Of 1 ms. The sink may see the first one late: half of it would still be no burst.
    assert!(lasts(Policy::Stop) >= Duration::from_micros(500) * 50);
    // Time that slips stretches: they leave as they were emitted.
    assert!(lasts(Policy::Slip) >= Duration::from_millis(1) * 50);
}

/// Before: pulses of a time long past left one after the other, each of them late.
#[test]
fn pulses_of_a_standstill_are_dropped_where_real_time_is_kept() {
    let all: Vec<u64> = (0..100).chain(20_500..20_550).collect();
    let (left, shot) = after_a_standstill(Policy::Drop, 1000.0, &all, Duration::ZERO);
    assert_eq!(indices(&left), all[100..]);
    assert_eq!((shot.pulses, shot.dropped, shot.missed), (50, 20_500, 0));
}

/// Before: the advice was a lighter scene.
#[test]
fn a_standstill_is_named() {
    let (pacer, _) = filled(Policy::Stop, &[0], 20_001);
    let start = Instant::now();
    let mut judge = Judge::new(start, start);
    judge.stood_still(&pacer.schedule, 0, Duration::from_millis(19_960), 8);
    // What is made within the allowance is in time; then as if the machine had never stood still.
    assert!(judge.limit(&pacer.schedule, 10) >= start + Duration::from_millis(19_970));
    let error = pacer.underrun(&judge, start + Duration::from_millis(20_012), 10);
    insta::assert_snapshot!(error, @r#"the machine, or this program, stood still for 20.0 s, and echo generation has not made up for it: 20002.0 ms after its deadline pulse 10 is not made yet. Allowed: policy = "slip" (time stretches) or "drop" (the pulses of that time are missing)"#);
}

#[test]
fn skipped_indices_are_counted_and_pulses_out_of_order_refused() {
    let (pacer, health) = filled(Policy::Drop, &[0, 3, 4], 5);
    pacer.run(Instant::now(), &AtomicBool::new(false)).unwrap();
    assert_eq!((health.released_pulses(), health.dropped_pulses()), (3, 2));
    let (pacer, _) = filled(Policy::Drop, &[0, 2, 2], 5);
    let refused = pacer.run(Instant::now(), &AtomicBool::new(false));
    assert_eq!(refused, Err(PacerError::Order { index: 2, expected: 3 }));
}
