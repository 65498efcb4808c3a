//! Released pulses are shared: every sink reads the same slot, and none is held up by another.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use nereus::bench::speed::peak_rss_bytes;
use nereus::pulse::{Layout, Pulse, SampleFormat, Samples, flags};
use nereus::time::PulseTimes;
use nereus::transport::fanout::{Fed, Feed};
use nereus::transport::schedule::Schedule;
use nereus::transport::stage::Stream;
use nereus::transport::view::{Seen, view};
use nereus::transport::{Pace, Policy, Settings};

use crate::stream_fixture::{generate, in_a_process_of_its_own, remember, stream};

/// Where each pulse lay when a sink read it.
fn places(mut feed: Feed) -> Result<BTreeMap<u64, usize>, String> {
    let mut places = BTreeMap::new();
    let look = |pulse: &Pulse| Ok::<_, String>((pulse.index, std::ptr::from_ref(pulse).addr()));
    loop {
        match feed.next(Duration::from_millis(200), look)? {
            Fed::Pulse((index, place)) => places.insert(index, place),
            Fed::Idle => None,
            Fed::Ended => return Ok(places),
        };
    }
}

#[test]
fn all_sinks_read_the_same_slots() {
    for pace in [Pace::Fast, Pace::Realtime] {
        let settings = Settings { pace, ring_slots: 64, ..Settings::default() };
        let schedule = Schedule { times: PulseTimes::uniform(1000.0).unwrap(), first: 0, count: 400 };
        let stop = Arc::new(AtomicBool::new(false));
        let mut run = Stream::new(settings, schedule, crate::stream_fixture::LAYOUT, stop);
        for name in ["a", "b", "c"] {
            run.sink(name, 512, places).unwrap();
        }
        let outcome = run.run(|source| generate(source, 0, 400, 4, Duration::ZERO));
        outcome.result.unwrap();
        let [(_, a), (_, b), (_, c)] = &outcome.reports[..] else { panic!("three reports") };
        assert_eq!((a.len(), a == b, b == c), (400, true, true), "{pace:?}");
    }
}

/// One sink takes nothing until the others have all: it misses what its queue has no room for, they miss
/// nothing, and generation is never short of slots. Its gap is flagged to it alone.
#[test]
fn a_sink_that_stands_still_holds_up_nobody() {
    let mut run = stream(Pace::Realtime, Policy::Drop, 0.05, 0, 400);
    let ended = Arc::new(AtomicBool::new(false));
    let wait = Arc::clone(&ended);
    run.sink("stands still", 16, move |feed| {
        while !wait.load(Ordering::Acquire) {
            thread::sleep(Duration::from_millis(1));
        }
        remember(feed, Duration::ZERO)
    })
    .unwrap();
    for name in ["b", "c"] {
        let ended = Arc::clone(&ended);
        run.sink(name, 512, move |feed| {
            let all = remember(feed, Duration::ZERO);
            ended.store(true, Ordering::Release);
            all
        })
        .unwrap();
    }
    let outcome = run.run(|source| generate(source, 0, 400, 4, Duration::ZERO));
    outcome.result.unwrap();
    let health = &outcome.summary.health;
    let [(_, still), (_, b), (_, c)] = &outcome.reports[..] else { panic!("three reports") };
    let released = health.pulses as usize;
    println!("{released} released, {} dropped, low water {:?}", health.dropped, health.ring_low_water);
    // Those that it got are the first ones, as they were released.
    assert_eq!((still.len(), health.sinks[0].dropped as usize), (16, released - 16));
    assert_eq!([b.len(), c.len()], [released; 2]);
    let gap = |seen: &crate::stream_fixture::Seen| seen.flags & flags::AFTER_GAP != 0;
    assert!(still.iter().zip(b).all(|(one, other)| (one.index, gap(one)) == (other.index, gap(other))));
}

/// A sink that takes half of the pulses has its gaps flagged; another, which reads the same slots, has none.
#[test]
fn a_gap_is_known_to_the_sink_that_has_it() {
    let mut run = stream(Pace::Realtime, Policy::Drop, 0.05, 0, 400);
    run.sink("slow", 1, |feed| remember(feed, Duration::from_millis(2))).unwrap();
    run.sink("all", 512, |feed| remember(feed, Duration::ZERO)).unwrap();
    let outcome = run.run(|source| generate(source, 0, 400, 4, Duration::ZERO));
    outcome.result.unwrap();
    let [(_, slow), (_, all)] = &outcome.reports[..] else { panic!("two reports") };
    let released: Vec<u64> = all.iter().map(|seen| seen.index).collect();
    assert_eq!(released.len() as u64, outcome.summary.health.pulses);
    let gaps = |seen: &[crate::stream_fixture::Seen]| {
        let flagged = seen.iter().filter(|seen| seen.flags & flags::AFTER_GAP != 0);
        flagged.map(|seen| seen.index).collect::<Vec<_>>()
    };
    let breaks = |seen: &[crate::stream_fixture::Seen]| {
        let firsts = seen.windows(2).filter(|pair| pair[1].index != pair[0].index + 1);
        firsts.map(|pair| pair[1].index).collect::<Vec<_>>()
    };
    assert!(breaks(slow).len() > 10 && slow.len() < all.len());
    assert_eq!((gaps(slow), gaps(all)), (breaks(slow), breaks(all)));
}

/// An onlooker who keeps the pulse that he is shown, and what is counted, for as long as the stream lasts.
#[test]
fn an_onlooker_who_holds_a_pulse_holds_up_nobody() {
    let mut run = stream(Pace::Realtime, Policy::Slip, 0.05, 0, 400);
    run.sink("all", 512, |feed| remember(feed, Duration::ZERO)).unwrap();
    let (view, mut onlooker) = view(8);
    run.view(view);
    let ended = Arc::new(AtomicBool::new(false));
    let wait = Arc::clone(&ended);
    let looking = thread::spawn(move || {
        let mut shown = None;
        while shown.is_none() {
            let health = onlooker.health().cloned();
            let seen = onlooker.poll(|pulse, _| {
                let before = pulse.clone();
                while !wait.load(Ordering::Acquire) {
                    let _ = health.as_ref().map(|health| health.snapshot());
                }
                shown = Some(before == *pulse);
            });
            assert_ne!(seen, Seen::Ended);
        }
        (shown, onlooker.not_shown())
    });
    let outcome = run.run(|source| generate(source, 0, 400, 4, Duration::ZERO));
    ended.store(true, Ordering::Release);
    outcome.result.unwrap();
    let (_, all) = &outcome.reports[0];
    assert_eq!((all.len(), outcome.summary.health.sinks[0].dropped), (400, 0));
    // Nobody wrote into the pulse that he held; one in his hands and seven in his queue.
    assert_eq!(looking.join().unwrap(), (Some(true), 392));
}

/// Queues for two seconds of large pulses take no memory while sinks keep up.
#[test]
fn queues_take_memory_as_they_fill() {
    if !cfg!(target_os = "linux") {
        return;
    }
    in_a_process_of_its_own("stream_shared::resident_run");
}

#[test]
#[ignore = "run by queues_take_memory_as_they_fill in a process of its own"]
fn resident_run() {
    let layout =
        Layout { channels: 1, samples: 5000, format: SampleFormat::Cf32, platforms: 1, ..Layout::default() };
    let (ring_slots, queue) = (200, 1000);
    let settings = Settings { pace: Pace::Realtime, policy: Policy::Drop, ring_slots, ..Settings::default() };
    let schedule = Schedule { times: PulseTimes::uniform(2000.0).unwrap(), first: 0, count: 2000 };
    let before = peak_rss_bytes().unwrap();
    let mut run = Stream::new(settings, schedule, layout, Arc::new(AtomicBool::new(false)));
    for name in ["a", "b", "c"] {
        run.sink(name, queue, |feed| remember(feed, Duration::ZERO)).unwrap();
    }
    let outcome = run.run(|source| {
        for index in 0..2000 {
            let Some(slots) = source.reserve(1) else { break };
            (slots[0].index, slots[0].flags) = (index, 0);
            if let Samples::Cf32(samples) = &mut slots[0].samples {
                samples.fill(num_complex::Complex32::ONE);
            }
            source.commit(1);
        }
        Ok::<_, String>(())
    });
    outcome.result.unwrap();
    let most = outcome.summary.health.sinks.iter().map(|sink| sink.queue_high_water).max().unwrap();
    let pulses = (peak_rss_bytes().unwrap() - before) / layout.slot_bytes() as u64;
    println!(
        "{pulses} pulses resident; ring of {ring_slots}, at most {most} waited for one of 3 sinks of {queue}"
    );
    // The ring, what waited, one in the hands of each sink, 4 MB of stacks and histograms, and of every slot
    // that was not used two pages.
    let unused = 3 * queue as u64 * (8 << 10) / layout.slot_bytes() as u64;
    assert!(pulses < ring_slots as u64 + 3 * (most + 1) + 100 + unused, "{pulses}");
}
