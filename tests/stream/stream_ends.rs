use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use nereus::time::PulseTimes;
use nereus::transport::fanout::{Fed, Feed, Role};
use nereus::transport::pacer::Status;
use nereus::transport::schedule::Schedule;
use nereus::transport::stage::{RunError, Stream};
use nereus::transport::{Pace, Policy, Settings, StreamError};

use crate::stream_fixture::{LAYOUT, Seen, generate, remember, stream};

const NONE: Duration = Duration::ZERO;
const LONG: u64 = 1_000_000;

#[test]
fn a_failing_sink_ends_the_run_and_the_others_close() {
    for pace in [Pace::Fast, Pace::Realtime] {
        let mut run = stream(pace, Policy::Stop, 0.2, 0, LONG);
        run.sink("whole", 64, |feed| remember(feed, NONE)).unwrap();
        run.sink("broken", 64, |mut feed| {
            for _ in 0..50 {
                feed.next(Duration::from_secs(1), |_| Ok::<_, String>(()))?;
            }
            Err("no space left".to_owned())
        })
        .unwrap();
        let begun = Instant::now();
        let outcome = run.run(|source| generate(source, 0, LONG, 8, NONE));
        assert!(begun.elapsed() < Duration::from_secs(5));
        let error = outcome.result.unwrap_err();
        assert_eq!(error.to_string(), "sink 'broken': no space left");
        let (name, seen) = &outcome.reports[0];
        assert_eq!(name, "whole");
        // It got every pulse that was released, to the last.
        assert_eq!(
            seen.iter().map(|s| s.index).collect::<Vec<_>>(),
            (0..seen.len() as u64).collect::<Vec<_>>()
        );
        assert!(seen.len() >= 50 && outcome.summary.health.pulses <= seen.len() as u64 + 1);
    }
}

/// Before: any sink that failed ended the run for all.
#[test]
fn a_run_goes_on_without_a_sink_that_may_fail() {
    for pace in [Pace::Fast, Pace::Realtime] {
        let mut run = stream(pace, Policy::Stop, 0.2, 0, 400);
        let may_fail = Role { lossless: true, may_fail: true };
        let fail = |mut feed: Feed| {
            for _ in 0..50 {
                feed.next(Duration::from_secs(1), |_| Ok::<_, String>(()))?;
            }
            Err("no space left".to_owned())
        };
        run.sink_as("broken", 64, may_fail, fail).unwrap();
        run.sink("whole", 512, |feed| remember(feed, NONE)).unwrap();
        let outcome = run.run(|source| generate(source, 0, 400, 8, NONE));
        outcome.result.unwrap();
        assert_eq!(outcome.failed, [("broken".to_owned(), "no space left".to_owned())]);
        let (name, seen) = &outcome.reports[0];
        assert_eq!((name.as_str(), seen.len()), ("whole", 400));
        // Every pulse is accounted for at each sink.
        let health = &outcome.summary.health;
        let of = |k: usize| (health.sinks[k].written, health.sinks[k].dropped, health.sinks[k].failed);
        assert_eq!((of(0), of(1)), ((50, 350, true), (400, 0, false)));
        assert_eq!((health.pulses, health.missed), (400, 350));
    }
    // Nobody is left.
    let mut run = stream(Pace::Fast, Policy::Stop, 0.0, 0, LONG);
    run.sink_as("broken", 4, Role { lossless: true, may_fail: true }, |_| Err("gone".to_owned())).unwrap();
    let outcome = run.run(|source| generate(source, 0, LONG, 8, NONE));
    assert!(outcome.result.is_ok() && outcome.summary.health.pulses < LONG);
    assert_eq!(outcome.failed.len(), 1);
}

#[test]
fn the_stop_flag_ends_a_run_cleanly() {
    for (pace, prf_hz) in [(Pace::Realtime, 1000.0), (Pace::Realtime, 0.01), (Pace::Fast, 1000.0)] {
        let stop = Arc::new(AtomicBool::new(false));
        let settings = Settings {
            pace,
            policy: Policy::Stop,
            latency_s: 0.1,
            ring_slots: 32,
            threads: 1,
            ..Settings::default()
        };
        let schedule = Schedule { times: PulseTimes::uniform(prf_hz).unwrap(), first: 0, count: LONG };
        let mut run: Stream<Vec<Seen>, String> = Stream::new(settings, schedule, LAYOUT, Arc::clone(&stop));
        run.sink("one", 32, |feed| remember(feed, NONE)).unwrap();
        let (sender, receiver) = crossbeam_channel::bounded::<Status>(64);
        run.status(sender);
        let flag = Arc::clone(&stop);
        let presser = thread::spawn(move || {
            thread::sleep(Duration::from_millis(250));
            flag.store(true, Ordering::Release);
            Instant::now()
        });
        let outcome = run.run(|source| generate(source, 0, LONG, 8, Duration::from_micros(100)));
        let after = presser.join().unwrap().elapsed();
        assert!(after < Duration::from_millis(500), "{pace:?} {prf_hz}: {after:?}");
        outcome.result.unwrap();
        assert!(outcome.summary.stopped);
        let health = &outcome.summary.health;
        assert_eq!(outcome.reports[0].1.len() as u64, health.pulses, "{pace:?} {prf_hz}");
        assert!(health.pulses >= 1 && health.dropped == 0);
        // Fast: what was made is kept.
        if pace == Pace::Fast {
            assert_eq!(health.made, health.pulses);
        }
        let statuses: Vec<Status> = receiver.try_iter().collect();
        assert_eq!(statuses.last().unwrap().passed, health.pulses);
    }
}

#[test]
fn an_error_or_a_panic_anywhere_is_the_runs_error() {
    let mut run = stream(Pace::Fast, Policy::Stop, 0.0, 0, 10);
    run.sink("one", 4, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run(|_| Err("no track"));
    assert_eq!(outcome.result, Err(RunError::Generation("no track")));

    let mut run = stream(Pace::Fast, Policy::Stop, 0.0, 0, LONG);
    run.sink("one", 4, |_| panic!("made to panic")).unwrap();
    let outcome = run.run(|source| generate(source, 0, LONG, 8, NONE));
    assert_eq!(outcome.result, Err(RunError::Panic { thread: "sink one".to_owned() }));

    let mut run = stream(Pace::Fast, Policy::Stop, 0.0, 0, LONG);
    run.sink("one", 4, |feed| remember(feed, NONE)).unwrap();
    let outcome = run.run::<String>(|_| panic!("made to panic"));
    assert_eq!(outcome.result, Err(RunError::Panic { thread: "generation".to_owned() }));
}

#[test]
fn a_sink_that_has_had_enough_ends_the_run() {
    let mut run = stream(Pace::Fast, Policy::Stop, 0.0, 0, LONG);
    run.sink("ten", 4, |mut feed| {
        let mut seen = Vec::new();
        while seen.len() < 10 {
            let next = |p: &nereus::pulse::Pulse| {
                Ok::<_, String>(Seen { index: p.index, flags: p.flags, at: Instant::now() })
            };
            if let Fed::Pulse(one) = feed.next(Duration::from_secs(1), next)? {
                seen.push(one);
            }
        }
        Ok::<_, String>(seen)
    })
    .unwrap();
    let outcome = run.run(|source| generate(source, 0, LONG, 8, NONE));
    outcome.result.unwrap();
    assert_eq!(outcome.reports[0].1.len(), 10);
}

#[test]
fn queues_without_slots_are_refused() {
    let mut run = stream(Pace::Fast, Policy::Stop, 0.0, 0, 10);
    let refused = run.sink("none", 0, |feed| remember(feed, NONE));
    assert_eq!(refused, Err(StreamError::EmptyQueue { sink: "none".to_owned() }));
    let settings = Settings {
        pace: Pace::Fast,
        policy: Policy::Stop,
        latency_s: 0.0,
        ring_slots: 0,
        threads: 1,
        ..Settings::default()
    };
    let schedule = Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count: 1 };
    let run: Stream<(), String> = Stream::new(settings, schedule, LAYOUT, Arc::new(AtomicBool::new(false)));
    let outcome = run.run(|_| Ok::<(), String>(()));
    assert_eq!(outcome.result, Err(RunError::Stream(StreamError::EmptyRing)));
}
