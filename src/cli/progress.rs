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
pub(super) fn watch(total: u64) -> (Sender<Status>, Watcher) {
    watch_of(total, "pulses")
}

/// The same for other things than pulses.
pub(super) fn watch_of(total: u64, what: &'static str) -> (Sender<Status>, Watcher) {
    let (sender, receiver) = bounded(8);
    let show = move || {
        if std::io::stderr().is_terminal() { bar(&receiver, total, what) } else { lines(&receiver, what) }
    };
    // A machine that cannot start a thread shows no progress; the run itself will say what is wrong.
    (sender, Watcher(thread::Builder::new().name("progress".to_owned()).spawn(show).ok()))
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

fn bar(receiver: &Receiver<Status>, total: u64, what: &str) {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
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

fn lines(receiver: &Receiver<Status>, what: &str) {
    let mut last = Instant::now();
    for status in receiver {
        if last.elapsed() >= LINE_EVERY {
            last = Instant::now();
            let trouble = trouble(&status).map(|trouble| format!(", {trouble}")).unwrap_or_default();
            say(format_args!("{} of {} {what}{trouble}", status.passed, status.total));
        }
    }
}
