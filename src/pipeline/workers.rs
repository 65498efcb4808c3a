//! Workers of the generation pool: they claim pulses, make them and deliver them.

use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;
use thread_priority::ThreadPriority;

use super::control::CommandQueue;
use super::fault::PulseError;
use super::live::LiveNav;
use super::stages::{PulseFactory, Worker};
use crate::pulse::Pulse;
use crate::transport::stage::Source;

/// Priority of a worker from 0 to 99, where 50 is that of an ordinary thread: nice 9.
const WORKER_PRIORITY: u8 = 23;

/// Lowers the priority of a worker, so that the pacer runs as soon as its deadline wakes it. Where the system
/// refuses, pulses are released later and the lateness shows it.
pub(super) fn yield_to_pacer() {
    if let Ok(level) = WORKER_PRIORITY.try_into() {
        let _ = thread_priority::set_current_thread_priority(ThreadPriority::Crossplatform(level));
    }
}

/// Lets every worker make a segment before the clock starts, so that it has all the memory it will need, in
/// runs that are longer than that. What fails here fails again in the run, which reports it.
pub(super) fn warm_up(factory: &PulseFactory, range: &Range<u64>, workers: &mut [Worker<'_>]) {
    let length = factory.block_pulses();
    if length <= 1 || (range.end - range.start) / length <= workers.len() as u64 {
        return;
    }
    workers.par_iter_mut().with_max_len(1).enumerate().for_each(|(place, worker)| {
        // The last pulse of a segment leaves nothing of it for later, when other tracks may be flown.
        let segment = factory.segment_of(range.start.saturating_add(place as u64 * length));
        let _ = worker.make(segment.end.min(range.end) - 1, &mut Pulse::new(factory.layout()));
        worker.count_anew();
    });
}

/// Makes the pulses of `range` until all are made or the stream ends. Workers take segment by segment, each
/// at its own pace: a segment is made by one worker, and two would each make all of it.
pub(super) fn generate(
    source: &mut Source,
    factory: &PulseFactory,
    nav: Option<&LiveNav>,
    range: Range<u64>,
    workers: &mut [Worker<'_>],
    commands: Option<CommandQueue>,
) -> Result<(), PulseError> {
    let (due, generator) = (source.due(), factory.generator());
    let (begin, end) = (range.start, range.end);
    if let Some(commands) = &commands {
        commands.open(source.health());
    }
    // Segments are claimed whole, but for those that the ring is too short for.
    let between = |first: u64| {
        if let Some(commands) = &commands {
            let untouched = || match first {
                first if first == begin => first,
                first => generator.first_untouched(factory.segment_of(first - 1).end - 1),
            };
            commands.serve(untouched, end);
        }
    };
    let dispatcher = source.dispatcher(range, workers.len()).between(&between);
    workers.par_iter_mut().with_max_len(1).try_for_each(|worker| {
        // A worker that panics calls the others off as well: its pulses will never come.
        let _watch = dispatcher.watch();
        while let Some(mut claim) = dispatcher.claim(|first| factory.segment_of(first).end) {
            let begun = nav.map(|nav| {
                // A segment is made whole, whatever part of it was claimed.
                let need = generator.latest_state_needed(factory.segment_of(claim.first).end);
                nav.hold(need, due.deadline(claim.first), due.latency, due.stop());
                Instant::now()
            });
            claim.slots.iter_mut().for_each(|slot| slot.fit(factory.layout()));
            let pulses = claim.first..claim.first + claim.slots.len() as u64;
            let mut slots = claim.slots.iter_mut().map(|slot| &mut **slot);
            worker.make_all(pulses, &mut slots).inspect_err(|_| dispatcher.call_off())?;
            if let (Some(nav), Some(begun)) = (nav, begun) {
                nav.took(begun.elapsed());
            }
            dispatcher.deliver(claim);
        }
        Ok(())
    })
}
