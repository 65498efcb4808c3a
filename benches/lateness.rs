//! Lateness on the wire: `nereus run` sends VITA 49.2 to a `nereus receive` of this machine and records HDF5
//! at the same time, a loop that never sleeps keeps a core busy, and a bare absolute-sleep loop of the
//! pacer's own priority runs beside it all.
//!
//! ```text
//! cargo bench --bench lateness                    # 222 Hz and 1 kHz, with and without SCHED_FIFO, 60 s each
//! NEREUS_SECONDS=10 cargo bench --bench lateness
//! NEREUS_SCENE=configs/mars-live.toml NEREUS_PRF_HZ=222 NEREUS_BUSY=0 cargo bench --bench lateness
//! ```
//!
//! A line for each: pulses late and dropped, lateness of the pulses (p50, p99, worst, us) and of the bare
//! loop, and what the receiver got.
#![allow(clippy::expect_used, missing_docs)]

use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

const NEREUS: &str = env!("CARGO_BIN_EXE_nereus");

/// A setting of the environment, or its default.
fn setting(name: &str, default: &str) -> String {
    std::env::var(name).unwrap_or_else(|_| default.to_owned())
}

/// The priority that the pacer asks for.
#[cfg(target_os = "linux")]
fn run_ahead() -> bool {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
        thread_native_id,
    };
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    50u8.try_into().is_ok_and(|level| {
        set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(level), fifo).is_ok()
    })
}

#[cfg(not(target_os = "linux"))]
fn run_ahead() -> bool {
    false
}

/// Lateness of a loop that only sleeps: how often more than its interval, and p50, p99, worst, us.
fn bare_loop(prf_hz: f64, seconds: f64, ahead: bool) -> (usize, [f64; 3]) {
    if ahead {
        run_ahead();
    }
    let sleeper = spin_sleep::SpinSleeper::new(200_000);
    let start = Instant::now();
    let loops = (prf_hz * seconds) as u32;
    let mut late_us: Vec<f64> = (1..=loops)
        .map(|n| {
            let deadline = start + Duration::from_secs_f64(f64::from(n) / prf_hz);
            sleeper.sleep_until(deadline);
            Instant::now().saturating_duration_since(deadline).as_secs_f64() * 1e6
        })
        .collect();
    late_us.sort_by(f64::total_cmp);
    let late = late_us.iter().filter(|us| **us > 1e6 / prf_hz).count();
    (late, [late_us.len() / 2, late_us.len() * 99 / 100, late_us.len() - 1].map(|i| late_us[i]))
}

fn report(child: Child) -> Value {
    let output = child.wait_with_output().expect("the program ends");
    let text = String::from_utf8_lossy(&output.stdout);
    let last = text.lines().last().unwrap_or_default();
    serde_json::from_str(last)
        .unwrap_or_else(|_| panic!("no report: {}", String::from_utf8_lossy(&output.stderr)))
}

fn measure(scene: &Path, prf_hz: f64, seconds: f64, ahead: bool, busy: bool, folder: &Path) {
    let address = UdpSocket::bind("127.0.0.1:0").and_then(|s| s.local_addr()).expect("a free port");
    let listener = Command::new(NEREUS)
        .args(["receive", "--json", "--idle-s", "3", "--listen", &address.to_string()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the receiver starts");
    thread::sleep(Duration::from_millis(500));
    let recording = folder.join("recording.h5");
    let sinks = format!(
        "[{{ kind = 'vita49', address = '{address}' }}, {{ kind = 'hdf5', path = '{}' }}]",
        recording.display()
    );
    let priority = if ahead { "realtime" } else { "normal" };
    let mut run = Command::new(NEREUS);
    run.arg("run").arg(scene).args(["--json", "--force", "--pace", "realtime"]);
    run.args(["--duration-s", &seconds.to_string()]);
    for (key, value) in
        [("sink", sinks.as_str()), ("radar.prf_hz", &prf_hz.to_string()), ("stream.pacer_priority", priority)]
    {
        run.arg("--set").arg(format!("{key}={value}"));
    }
    let run = run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("nereus starts");
    let done = Arc::new(AtomicBool::new(false));
    let spinning = busy.then(|| {
        let done = Arc::clone(&done);
        thread::spawn(move || while !done.load(Ordering::Relaxed) {})
    });
    let (bare_late, bare_us) =
        thread::spawn(move || bare_loop(prf_hz, seconds, ahead)).join().expect("a loop");
    let run = report(run);
    done.store(true, Ordering::Relaxed);
    if let Some(spinning) = spinning {
        spinning.join().expect("a loop");
    }
    let received = report(listener);
    let us = |key: &str| run["lateness_us"][key].as_f64().unwrap_or(f64::NAN);
    println!(
        "{prf_hz} Hz, {seconds} s, {}, {}: {} pulses, {} late, {} dropped, {:.0} {:.0} {:.0} us; \
         bare loop {bare_late} late, {:.0} {:.0} {:.0} us; received {} pulses, {} missing",
        if run["pacer_ahead"] == Value::Bool(true) { "SCHED_FIFO" } else { "ordinary" },
        if busy { "beside a busy loop" } else { "alone" },
        run["pulses"],
        run["late"],
        run["dropped"],
        us("p50"),
        us("p99"),
        us("max"),
        bare_us[0],
        bare_us[1],
        bare_us[2],
        received["pulses"],
        received["missing"],
    );
}

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scene = root.join(setting("NEREUS_SCENE", "configs/live-wire.toml"));
    let seconds: f64 = setting("NEREUS_SECONDS", "60").parse().expect("seconds");
    let prf_hz = setting("NEREUS_PRF_HZ", "222,1000");
    let busy = setting("NEREUS_BUSY", "1") != "0";
    let folder = tempfile::tempdir().expect("a folder");
    for prf_hz in prf_hz.split(',') {
        for ahead in [true, false] {
            measure(&scene, prf_hz.parse().expect("a rate"), seconds, ahead, busy, folder.path());
        }
    }
}
