//! Progress of long work: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, bounded};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::say;
use crate::transport::pacer::Status;

/// Plain lines come this often.
const LINE_EVERY: Duration = Duration::from_secs(2);

/// Something that shows progress until its sender is gone.
pub(super) struct Watcher(Option<JoinHandle<()>>);

/// A sender for progress of pulses, and what shows it.
pub(super) fn watch() -> (Sender<Status>, Watcher) {
    watch_of("pulses")
}

fn watch_of(what: &'static str) -> (Sender<Status>, Watcher) {
    let (sender, receiver) = bounded(8);
    let show = move || {
        if std::io::stderr().is_terminal() { bar(&receiver, what) } else { lines(&receiver, what) }
    };
    // A machine that cannot start a thread shows no progress; the run itself will say what is wrong.
    (sender, Watcher(thread::Builder::new().name("progress".to_owned()).spawn(show).ok()))
}

/// Does some work and shows how far it is; `work` calls what it is given with what is done, and all there is.
pub(super) fn counting<T>(what: &'static str, work: impl FnOnce(&(dyn Fn(usize, usize) + Sync)) -> T) -> T {
    let (status, watcher) = watch_of(what);
    let made = work(&|done, total| {
        let (passed, total) = (done as u64, total as u64);
        // Progress that nobody has time to show is not worth waiting for.
        let _ = status.try_send(Status { passed, total, late: 0, dropped: 0 });
    });
    drop(status);
    watcher.finish();
    made
}

impl Watcher {
    /// Waits until the last word is shown.
    pub(super) fn finish(self) {
        if let Some(thread) = self.0 {
            let _ = thread.join();
        }
    }
}

fn trouble(status: &Status) -> Option<String> {
    let Status { late, dropped, .. } = status;
    (*late > 0 || *dropped > 0).then(|| format!("{late} late, {dropped} dropped"))
}

fn bar(receiver: &Receiver<Status>, what: &str) {
    let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(&format!(
        "{{bar:40}} {{pos}}/{{len}} {what}, {{per_sec}}, {{eta}} left {{msg:.red}}"
    )) {
        bar.set_style(style);
    }
    for status in receiver {
        bar.set_length(status.total);
        bar.set_position(status.passed);
        bar.set_message(trouble(&status).unwrap_or_default());
    }
    bar.finish_and_clear();
}

/// How long the rest takes if it goes on as since the first status.
fn left(status: &Status, first: u64, elapsed: Duration) -> String {
    if status.passed <= first || status.passed >= status.total {
        return String::new();
    }
    let rest = (status.total - status.passed) as f64;
    let seconds = elapsed.as_secs_f64() * rest / (status.passed - first) as f64;
    match seconds {
        s if s < 100.0 => format!(", about {s:.0} s left"),
        s if s < 6000.0 => format!(", about {:.0} min left", s / 60.0),
        s => format!(", about {:.1} h left", s / 3600.0),
    }
}

fn lines(receiver: &Receiver<Status>, what: &str) {
    let mut last = Instant::now();
    let mut begun = None;
    for status in receiver {
        // A stream passes nothing until its latency is over: what is left is reported from its first progress
        // on.
        let (since, first) = *begun.get_or_insert((Instant::now(), status.passed));
        if last.elapsed() >= LINE_EVERY {
            last = Instant::now();
            let trouble = trouble(&status).map(|trouble| format!(", {trouble}")).unwrap_or_default();
            let left = left(&status, first, since.elapsed());
            say(format_args!("{} of {} {what}{left}{trouble}", status.passed, status.total));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_from_what_is_done() {
        let of = |passed, total, seconds| {
            left(&Status { passed, total, late: 0, dropped: 0 }, 0, Duration::from_secs(seconds))
        };
        assert_eq!(of(5, 20, 10), ", about 30 s left");
        assert_eq!(of(1, 31, 20), ", about 10 min left");
        assert_eq!(of(1, 1001, 36), ", about 10.0 h left");
        assert_eq!((of(0, 20, 10), of(20, 20, 10)), (String::new(), String::new()));
    }
}
