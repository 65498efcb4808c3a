//! What a stream asks of the system so that pulses leave on time, and what it is granted.
//!
//! | asked | how | refused |
//! | --- | --- | --- |
//! | real-time priority | `SCHED_FIFO`, priority 50, the pacer alone | without `CAP_SYS_NICE` or `RLIMIT_RTPRIO` |
//! | a core | the affinity of the pacer alone | a core that there is not, or that this process may not use |
//! | memory that stays | `mlockall` of all that the stream has when it begins | without `CAP_IPC_LOCK`, beyond `RLIMIT_MEMLOCK` |
//!
//! Nothing of it is needed: what is refused is reported, and the stream goes on without it.

use serde::Serialize;

/// Real-time priority for the pacer.
pub(super) const PRIORITY: &str = "pacer_priority";
const CORE: &str = "pacer_core";
const MEMORY: &str = "lock_memory";
/// All that may be asked.
pub(super) const ALL: [&str; 3] = [PRIORITY, CORE, MEMORY];

/// The system's answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Right {
    /// `pacer_priority`, `pacer_core` or `lock_memory`.
    pub asked: &'static str,
    /// Whether it was granted.
    pub granted: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Right {
    fn of(asked: &'static str, answer: Result<(), String>) -> Self {
        Self { asked, granted: answer.is_ok(), reason: answer.err() }
    }
}

/// Asks that this thread run at real-time priority: a woken thread of ordinary priority waits until those at
/// work have had their slice, some milliseconds, nice or not.
pub(crate) fn run_ahead() -> Right {
    Right::of(PRIORITY, fifo())
}

/// Asks that this thread run on one core.
pub(super) fn stay_on(core: usize) -> Right {
    Right::of(CORE, affine(core))
}

/// Asks that all memory taken so far stay where it is.
pub(crate) fn lock_memory() -> Right {
    Right::of(MEMORY, locked())
}

/// Priority of 1 to 99 among threads that run ahead of ordinary ones.
#[cfg(all(target_os = "linux", not(miri)))]
const AHEAD: u8 = 50;

#[cfg(all(target_os = "linux", not(miri)))]
fn fifo() -> Result<(), String> {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
        thread_native_id,
    };
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let level = AHEAD.try_into().map_err(|error| format!("{error:?}"))?;
    set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(level), fifo)
        .map_err(|error| error.to_string())
}

#[cfg(all(target_os = "linux", not(miri)))]
fn affine(core: usize) -> Result<(), String> {
    use nix::sched::{CpuSet, sched_setaffinity};
    use nix::unistd::Pid;
    let mut cores = CpuSet::new();
    cores
        .set(core)
        .map_err(|_| format!("core {core} is not allowed; allowed: 0 to {}", CpuSet::count() - 1))?;
    sched_setaffinity(Pid::from_raw(0), &cores).map_err(|error| format!("core {core}: {error}"))
}

#[cfg(all(target_os = "linux", not(miri)))]
fn locked() -> Result<(), String> {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    // Not what comes later: beyond a limit, taking memory would fail then.
    mlockall(MlockAllFlags::MCL_CURRENT).map_err(|error| error.to_string())
}

#[cfg(not(all(target_os = "linux", not(miri))))]
const ELSEWHERE: &str = "not asked on this system";

#[cfg(not(all(target_os = "linux", not(miri))))]
fn fifo() -> Result<(), String> {
    Err(ELSEWHERE.to_owned())
}

#[cfg(not(all(target_os = "linux", not(miri))))]
fn affine(_: usize) -> Result<(), String> {
    Err(ELSEWHERE.to_owned())
}

#[cfg(not(all(target_os = "linux", not(miri))))]
fn locked() -> Result<(), String> {
    Err(ELSEWHERE.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever this process may do, it is reported; a core that nobody has is refused.
    #[test]
    fn what_is_refused_is_reported() {
        std::thread::spawn(|| {
            for right in [stay_on(100_000), stay_on(1000)] {
                assert!(!right.granted && right.reason.is_some(), "{right:?}");
            }
            for right in [run_ahead(), stay_on(0), lock_memory()] {
                assert_eq!(right.granted, right.reason.is_none(), "{right:?}");
                println!("{right:?}");
            }
        })
        .join()
        .unwrap();
    }
}
