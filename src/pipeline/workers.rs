//! Workers of the generation pool: they claim pulses, make them and deliver them.

use std::cell::Cell;
use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;
use thread_priority::ThreadPriority;

use super::control::CommandQueue;
use super::fault::PulseError;
use super::live::LiveNav;
use super::relax::{Made, Relaxation};
use super::stages::{PulseFactory, Worker};
use crate::pulse::{Pulse, flags};
use crate::transport::stage::Source;

/// What makes pulses in one thread: a worker for each error class.
pub(super) type Crew<'f> = Vec<Worker<'f>>;

/// Priority of a worker from 0 to 99, where 50 is that of an ordinary thread: nice 9.
const WORKER_PRIORITY: u8 = 23;

/// Lowers the priority of a worker, so that the pacer runs as soon as its deadline wakes it. Where the system
/// refuses, pulses are released later and the lateness shows it.
pub(crate) fn yield_to_pacer() {
    if let Ok(level) = WORKER_PRIORITY.try_into() {
        let _ = thread_priority::set_current_thread_priority(ThreadPriority::Crossplatform(level));
    }
}

/// Lets every worker make a segment before the clock starts, so that it has all the memory it will need, in
/// runs that are longer than that. What fails here fails again in the run, which reports it.
pub(super) fn warm_up(classes: &[&PulseFactory], range: &Range<u64>, crews: &mut [Crew<'_>]) {
    let length = classes.iter().map(|factory| factory.block_pulses()).max().unwrap_or(1);
    if length <= 1 || (range.end - range.start) / length <= crews.len() as u64 {
        return;
    }
    crews.par_iter_mut().with_max_len(1).enumerate().for_each(|(place, crew)| {
        for (factory, worker) in classes.iter().zip(crew) {
            // The last pulse of a segment leaves nothing of it for later, when other tracks may be flown.
            let segment = factory.segment_of(range.start.saturating_add(place as u64 * length));
            let _ = worker.make(segment.end.min(range.end) - 1, &mut Pulse::new(factory.layout()));
            worker.count_anew();
        }
    });
}

/// Makes the pulses of `range` until all are made or the stream ends. Workers take segment by segment, each
/// at its own pace: a segment is made by one worker, and two would each make all of it. Its error class is
/// that which [`Relaxation`] finds.
pub(super) fn generate(
    source: &mut Source,
    classes: &[&PulseFactory],
    nav: Option<&LiveNav>,
    range: Range<u64>,
    crews: &mut [Crew<'_>],
    commands: Option<CommandQueue>,
) -> Result<(), PulseError> {
    let (due, generator) = (source.due(), classes[0].generator());
    let relaxation = Relaxation::new(classes, crews.len());
    let (begin, end) = (range.start, range.end);
    if let Some(commands) = &commands {
        commands.open(source.health());
    }
    // Segments are claimed whole, but for those that the ring is too short for.
    let between = |first: u64| {
        if let Some(commands) = &commands {
            let untouched = || match first {
                first if first == begin => first,
                first => {
                    let begun = classes.iter().map(|factory| factory.segment_of(first - 1).end).max();
                    generator.first_untouched(begun.unwrap_or(first) - 1)
                }
            };
            commands.serve(untouched, end);
        }
    };
    let slack_s = |first: u64| {
        let (deadline, now) = (due.deadline(first), Instant::now());
        let left = deadline.saturating_duration_since(now).as_secs_f64();
        left - now.saturating_duration_since(deadline).as_secs_f64()
    };
    let dispatcher = source.dispatcher(range, crews.len()).between(&between);
    crews.par_iter_mut().with_max_len(1).enumerate().try_for_each(|(place, crew)| {
        // A worker that panics calls the others off as well: its pulses will never come.
        let _watch = dispatcher.watch();
        let chosen = Cell::new(0);
        loop {
            let asked = Instant::now();
            let claim = dispatcher.claim(|first| {
                let segment = |class: usize| classes[class].segment_of(first);
                chosen.set(relaxation.class(first, slack_s(first), segment));
                segment(chosen.get()).end
            });
            let Some(mut claim) = claim else { return Ok(()) };
            let class = chosen.get();
            let factory = classes[class];
            if let Some(nav) = nav {
                // A segment is made whole, whatever part of it was claimed.
                let need = generator.latest_state_needed(factory.segment_of(claim.first).end);
                nav.hold(need, due.deadline(claim.first), due.latency, due.stop());
            }
            let (begun, begun_with_s) = (Instant::now(), slack_s(claim.first));
            claim.slots.iter_mut().for_each(|slot| slot.fit(factory.layout()));
            let pulses = claim.first..claim.first + claim.slots.len() as u64;
            relaxation.begin(place, class, pulses.end - pulses.start);
            let mut slots = claim.slots.iter_mut().map(|slot| &mut **slot);
            crew[class].make_all(pulses, &mut slots).inspect_err(|_| dispatcher.call_off())?;
            claim.slots.iter_mut().for_each(|slot| slot.flags |= flags::of_error_class(class));
            let busy = begun.elapsed();
            if let Some(nav) = nav {
                nav.took(busy);
            }
            let (pulses, waited) = (claim.slots.len() as u64, begun.duration_since(asked));
            relaxation.made(&Made { worker: place, class, pulses, waited, busy, begun_with_s });
            dispatcher.deliver(claim);
        }
    })
}
