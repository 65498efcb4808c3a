//! The start of a run that waits for the clock of the machine (`scene.start_utc = "now"`).
//!
//! Its stamps are those of the clock at which its pulses are emitted, so it has to be ready before the
//! first of them is: a run that was not is made ready once more, for a later start.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::config::Run;
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::time::TimeTag;
use crate::transport::Pace;

/// How long the stop flag is not looked at.
const SLICE_S: f64 = 0.05;

/// The run with a later start, where making it ready took too long for its own.
///
/// # Errors
/// A scenario whose files have changed meanwhile.
pub(super) fn later(run: &Run, took: Duration) -> Result<Option<Run>, BuildErrors> {
    let took_s = took.as_secs_f64();
    // Before its first pulse every thread makes a block; that is taken to last no longer.
    if !run.start_now || run.stream.pace == Pace::Fast || run.scene.start.since(TimeTag::now()) > took_s {
        return Ok(None);
    }
    let later = run.starting_later(2.0 * took_s + 1.0);
    later.map(Some).map_err(|fault| BuildError::Scenario(Box::new(fault)).into())
}

/// Waits until the clock shows a time, or `stop` is set.
///
/// # Errors
/// A time that has passed: stamps would not be those of the clock.
pub(super) fn wait(first: TimeTag, stop: &AtomicBool) -> Result<(), BuildError> {
    let late_s = TimeTag::now().since(first);
    if late_s > 0.0 {
        return Err(BuildError::StartPassed { late_s });
    }
    while !stop.load(Ordering::Acquire) {
        let left_s = first.since(TimeTag::now());
        if left_s <= 0.0 {
            break;
        }
        thread::sleep(Duration::from_secs_f64(left_s.min(SLICE_S)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_ends_by_the_clock_or_when_it_is_stopped() {
        let first = TimeTag::now().plus(0.12);
        wait(first, &AtomicBool::new(false)).unwrap();
        assert!(TimeTag::now().since(first) >= 0.0);
        let late = wait(first, &AtomicBool::new(false)).unwrap_err().to_string();
        assert!(late.starts_with("pulse 0 was due ") && late.contains("allowed"), "{late}");
        let far = first.plus(3600.0);
        wait(far, &AtomicBool::new(true)).unwrap();
        assert!(far.since(TimeTag::now()) > 3000.0);
    }
}
