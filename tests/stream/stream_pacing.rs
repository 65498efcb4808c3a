use std::time::{Duration, Instant};

use nereus::pulse::flags::{AFTER_GAP, LATE};
use nereus::transport::pacer::PacerError;
use nereus::transport::stage::RunError;
use nereus::transport::{Pace, Policy};

use crate::stream_fixture::{Seen, generate, remember, stream};

const NONE: Duration = Duration::ZERO;
/// Twice the interval at 1 kHz: an overload of two.
const OVERLOAD: Duration = Duration::from_millis(2);

fn indices(seen: &[Seen]) -> Vec<u64> {
    seen.iter().map(|s| s.index).collect()
}

/// Every jump of the index carries the flag, and nothing else does.
fn gaps_are_flagged(seen: &[Seen], first: u64) -> usize {
    let mut next = first;
    let mut gaps = 0;
    for s in seen {
        assert_eq!(s.flags & AFTER_GAP != 0, s.index != next, "pulse {} where {next} was next", s.index);
        gaps += usize::from(s.index != next);
        next = s.index + 1;
    }
    gaps
}

#[test]
fn fast_is_lossless_and_in_order_even_with_a_slow_sink() {
    let mut run = stream(Pace::Fast, Policy::Drop, 0.0, 5, 3000);
    run.sink("slow", 4, |feed| remember(feed, Duration::from_micros(50))).unwrap();
    run.sink("quick", 4, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run(|source| generate(source, 5, 3005, 7, NONE));
    outcome.result.unwrap();
    let expected: Vec<u64> = (5..3005).collect();
    for (name, seen) in &outcome.reports {
        assert_eq!(indices(seen), expected, "{name}");
        assert!(seen.iter().all(|s| s.flags == 0), "{name}");
    }
    let health = &outcome.summary.health;
    assert_eq!((health.pulses, health.late, health.dropped, health.made), (3000, 0, 0, 3000));
    assert!(health.sinks.iter().all(|s| s.written == 3000 && s.dropped == 0));
    assert!(health.sinks.iter().all(|s| (1..=4).contains(&s.queue_high_water)));
    assert_eq!(outcome.summary.latency_ms, None);
}

#[test]
fn realtime_keeps_the_schedule() {
    let latency_s = 0.2;
    let mut run = stream(Pace::Realtime, Policy::Stop, latency_s, 0, 500);
    run.sink("one", 600, |feed| remember(feed, NONE)).unwrap();
    let begun = Instant::now();
    let outcome = run.run(|source| generate(source, 0, 500, 16, NONE));
    let lateness = outcome.summary.health.lateness_us;
    println!("1 kHz, lateness us: {lateness:?}");
    outcome.result.unwrap();
    let seen = &outcome.reports[0].1;
    assert_eq!(indices(seen), (0..500).collect::<Vec<_>>());
    for s in seen {
        // The schedule starts after `begun`, so no pulse may be here before this instant.
        let earliest = Duration::from_secs_f64(latency_s) + Duration::from_millis(s.index);
        assert!(s.at.duration_since(begun) >= earliest, "pulse {} early", s.index);
    }
    let health = &outcome.summary.health;
    assert_eq!((health.pulses, health.dropped, health.made), (500, 0, 500));
    let flagged = seen.iter().filter(|s| s.flags & LATE != 0).count() as u64;
    assert_eq!(flagged, health.late);
    let latency_ms = outcome.summary.latency_ms.unwrap();
    assert!(latency_ms >= 200.0 && (latency_ms - 200.0 - lateness.mean * 1e-3).abs() < 1e-9, "{latency_ms}");
    assert!(health.ring_low_water.is_some());
}

#[test]
fn stop_names_the_stage_that_is_short() {
    let mut run = stream(Pace::Realtime, Policy::Stop, 0.02, 0, 10_000);
    run.sink("one", 64, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run(|source| generate(source, 0, 10_000, 4, OVERLOAD));
    let Err(RunError::Pacer(error @ PacerError::Underrun { index, late_by_s, made_hz, needed_hz, .. })) =
        outcome.result
    else {
        panic!("{:?}", outcome.result)
    };
    println!("{error}");
    assert!(error.to_string().starts_with("echo generation cannot keep up: "), "{error}");
    assert!(error.to_string().contains(&format!("pulse {index} is not made yet; ")), "{error}");
    // A latency of 20 pulses at half the rate runs dry after about 40; made_hz cannot exceed the rate
    // at which generation sleeps.
    assert!(index < 60 && made_hz <= 500.0 && needed_hz == 1000.0 && late_by_s > 1e-3, "{error:?}");
    assert_eq!(outcome.summary.health.pulses, index);
    assert_eq!(outcome.reports[0].1.len() as u64, index);
}

#[test]
fn slip_loses_nothing_and_flags_the_late() {
    let mut run = stream(Pace::Realtime, Policy::Slip, 0.02, 0, 200);
    run.sink("one", 256, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run(|source| generate(source, 0, 200, 4, OVERLOAD));
    outcome.result.unwrap();
    let seen = &outcome.reports[0].1;
    assert_eq!(indices(seen), (0..200).collect::<Vec<_>>());
    let health = &outcome.summary.health;
    assert_eq!((health.pulses, health.dropped), (200, 0));
    assert!(health.late > 0);
    assert_eq!(seen.iter().filter(|s| s.flags & LATE != 0).count() as u64, health.late);
    // 200 pulses take 0.4 s to make; the last was due at 0.219 s. The schedule moved by the
    // difference, but for at most the batch and the interval that count as no underrun.
    println!("slipped by {} s", health.slipped_s);
    assert!(health.slipped_s > 0.4 - 0.219 - 0.02, "{}", health.slipped_s);
    // The schedule moved instead of every pulse being late.
    assert!(health.lateness_us.max < health.slipped_s * 1e6);
}

#[test]
fn drop_keeps_real_time_and_shows_every_gap() {
    let mut run = stream(Pace::Realtime, Policy::Drop, 0.02, 3, 700);
    run.sink("one", 1024, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run(|source| generate(source, 3, 703, 4, OVERLOAD));
    outcome.result.unwrap();
    let seen = &outcome.reports[0].1;
    let health = &outcome.summary.health;
    let gaps = gaps_are_flagged(seen, 3);
    println!(
        "released {}, dropped {}, {gaps} gaps, {:.3} s",
        health.pulses, health.dropped, outcome.summary.elapsed_s
    );
    assert_eq!(health.pulses + health.dropped, 700);
    assert_eq!(seen.len() as u64, health.pulses);
    assert!(gaps >= 2);
    // At half the rate no more than half can be made (and the head start of one latency); a quarter
    // must come through even if every batch of 4 after a gap loses some pulses.
    assert!((175..=375).contains(&health.pulses), "{}", health.pulses);
    // 0.72 s by the schedule; stretched to the pace of generation it would be 1.4 s.
    assert!(outcome.summary.elapsed_s < 1.1, "{}", outcome.summary.elapsed_s);
    assert_eq!(health.slipped_s, 0.0);
}

#[test]
fn a_slow_sink_misses_pulses_and_the_others_do_not() {
    let mut run = stream(Pace::Realtime, Policy::Stop, 0.2, 0, 400);
    run.sink("slow", 8, |feed| remember(feed, Duration::from_millis(5))).unwrap();
    run.sink("quick", 512, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run(|source| generate(source, 0, 400, 16, NONE));
    outcome.result.unwrap();
    let (slow, quick) = (&outcome.reports[0].1, &outcome.reports[1].1);
    assert_eq!(indices(quick), (0..400).collect::<Vec<_>>());
    assert!(quick.iter().all(|s| s.flags & AFTER_GAP == 0));
    // The last gap may be at the end, with no pulse after it.
    assert!(gaps_are_flagged(slow, 0) > 0);
    let counters = &outcome.summary.health.sinks[0];
    assert_eq!(counters.written + counters.dropped, 400);
    assert_eq!(counters.written, slow.len() as u64);
    assert!(counters.dropped > 100 && counters.queue_high_water == 8, "{counters:?}");
    assert_eq!(outcome.summary.health.sinks[1].dropped, 0);
    assert_eq!(outcome.summary.health.dropped, 0);
}
