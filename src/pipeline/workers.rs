//! Workers of the generation pool: they claim pulses, make them and deliver them.

use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;
use thread_priority::ThreadPriority;

use super::control::CommandQueue;
use super::fault::PulseError;
use super::live::LiveNav;
use super::stages::{PulseFactory, Workspace};
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

/// Lets every worker make a block before the clock starts, so that it has all the memory it will need, in
/// runs that are longer than that. What fails here fails again in the run, which reports it.
pub(super) fn warm_up(factory: &PulseFactory, range: &Range<u64>, work: &mut [Workspace]) {
    let block = factory.block_pulses();
    if block <= 1 || (range.end - range.start) / block <= work.len() as u64 {
        return;
    }
    work.par_iter_mut().with_max_len(1).enumerate().for_each(|(place, work)| {
        let index = range.start.saturating_add(place as u64 * block).min(range.end - 1);
        let _ = factory.make(index, &mut Pulse::new(factory.layout()), work);
        work.start_anew();
    });
}

/// Makes the pulses of `range` until all are made or the stream ends. Workers take block by block, each at
/// its own pace: a block is made by one worker, and two would each make all of it.
pub(super) fn generate(
    source: &mut Source,
    factory: &PulseFactory,
    nav: Option<&LiveNav>,
    range: Range<u64>,
    work: &mut [Workspace],
    commands: Option<CommandQueue>,
) -> Result<(), PulseError> {
    let length = factory.block_pulses();
    let due = source.due();
    let (begin, end) = (range.start, range.end);
    if let Some(commands) = &commands {
        commands.open(source.health());
    }
    // Blocks are claimed whole, but for those that the ring is too short for.
    let between = |first: u64| {
        if let Some(commands) = &commands {
            let last = |first: u64| (first - 1) / length * length + length - 1;
            let untouched = || match first {
                first if first == begin => first,
                first => factory.generator.first_untouched(last(first)),
            };
            commands.serve(untouched, end);
        }
    };
    let dispatcher = source.dispatcher(range, work.len()).between(&between);
    work.par_iter_mut().with_max_len(1).try_for_each(|work| {
        // A worker that panics calls the others off as well: its pulses will never come.
        let _watch = dispatcher.watch();
        while let Some(mut claim) = dispatcher.claim(|first| first - first % length + length) {
            let begun = nav.map(|nav| {
                // A block is made whole, whatever part of it was claimed.
                let block = claim.first - claim.first % length + length;
                let after = block.max(claim.first + claim.slots.len() as u64);
                let need = factory.generator.latest_state_needed(after);
                nav.hold(need, due.deadline(claim.first), due.latency, due.stop());
                Instant::now()
            });
            let pulses = (claim.first..).zip(&mut claim.slots);
            for (index, slot) in pulses {
                slot.fit(factory.layout());
                factory.make(index, slot, work).inspect_err(|_| dispatcher.call_off())?;
            }
            if let (Some(nav), Some(begun)) = (nav, begun) {
                nav.took(begun.elapsed());
            }
            dispatcher.deliver(claim);
        }
        Ok(())
    })
}
