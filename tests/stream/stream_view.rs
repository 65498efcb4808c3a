//! Onlookers: what they do is not seen in the stream.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use nereus::transport::view::{Seen, view};
use nereus::transport::{Pace, Policy};

use crate::stream_fixture::{generate, remember, stream};

/// One that never looks, one that goes, one that looks at all: the sink gets every pulse, none is late for
/// it.
#[test]
fn an_onlooker_holds_up_nobody() {
    for pace in [Pace::Realtime, Pace::Fast] {
        for manner in ["never looks", "goes", "looks"] {
            let mut stream = stream(pace, Policy::Slip, 0.05, 0, 400);
            stream.sink("all", 512, |feed| remember(feed, Duration::ZERO)).unwrap();
            let (view, mut onlooker) = view(8);
            stream.view(view);
            let seen = Arc::new(AtomicU64::new(0));
            let count = Arc::clone(&seen);
            let watching = match manner {
                "goes" => {
                    drop(onlooker);
                    None
                }
                "looks" => Some(thread::spawn(move || {
                    loop {
                        match onlooker.poll(|pulse, _| {
                            count.fetch_max(pulse.index, Ordering::Relaxed);
                        }) {
                            Seen::Pulse => {}
                            Seen::Nothing => thread::sleep(Duration::from_micros(200)),
                            Seen::Ended => return onlooker,
                        }
                    }
                })),
                _ => Some(thread::spawn(move || onlooker)),
            };
            let outcome = stream.run(|source| generate(source, 0, 400, 4, Duration::ZERO));
            assert!(outcome.result.is_ok(), "{manner}");
            let (_, all) = &outcome.reports[0];
            assert_eq!(all.len(), 400, "{manner}, {pace:?}");
            // The view is no sink: it is not among them, and what it missed is no loss.
            assert_eq!((outcome.summary.health.sinks.len(), outcome.summary.health.dropped), (1, 0));
            assert_eq!(outcome.summary.health.sinks[0].dropped, 0);
            let Some(watching) = watching else { continue };
            let onlooker = watching.join().unwrap();
            let counters = onlooker.health().map(|health| health.counters()).unwrap();
            assert_eq!((counters.released, counters.sinks[0].written, counters.ring_slots), (400, 400, 64));
            let timed: u64 = counters.lateness.iter().sum();
            assert_eq!(timed, if pace == Pace::Realtime { 400 } else { 0 });
            match manner {
                "looks" => assert!(seen.load(Ordering::Relaxed) > 300 || onlooker.not_shown() > 0),
                _ => assert_eq!(onlooker.not_shown(), 392),
            }
        }
    }
}
