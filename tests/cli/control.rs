//! Changes while a run goes on, as a user makes them.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::program::{command, nereus, package, started};

fn scenario() -> String {
    package().join("configs/errors.toml").display().to_string()
}

/// A run in real time with a socket.
struct Live {
    child: Child,
    socket: PathBuf,
}

fn live(folder: &Path, more: &[&str]) -> Live {
    let socket = folder.join("run.sock");
    let child =
        started(folder, &[&["run", &scenario(), "--json", "--control", "run.sock"][..], more].concat());
    let begun = Instant::now();
    while !socket.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no socket");
        thread::sleep(Duration::from_millis(10));
    }
    Live { child, socket }
}

impl Live {
    fn client(&self) -> Client {
        let stream = UnixStream::connect(&self.socket).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        Client { answers: BufReader::new(stream.try_clone().unwrap()), stream }
    }

    fn end(mut self) -> serde_json::Value {
        let mut text = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
        let mut stderr = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert!(self.child.wait().unwrap().success(), "{stderr}");
        assert!(!self.socket.exists(), "the socket is removed");
        serde_json::from_str(text.lines().last().unwrap()).unwrap()
    }
}

struct Client {
    stream: UnixStream,
    answers: BufReader<UnixStream>,
}

impl Client {
    fn send(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).unwrap();
    }

    fn read_line(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }
}

/// The line with every number of its own replaced, as the page has them.
fn unnumbered(line: &str) -> String {
    let counts = ["pulse", "released", "late", "dropped", "made"];
    let mut words: Vec<&str> = line.split(' ').collect();
    if words[0] == "ok" {
        for n in 1..words.len() {
            if counts.contains(&words[n - 1]) && words[n].bytes().all(|byte| byte.is_ascii_digit()) {
                words[n] = "N";
            }
        }
    }
    words.join(" ")
}

#[test]
fn the_conversation_of_the_page_is_what_happens() {
    let page = fs::read_to_string(package().join("docs/control.md")).unwrap();
    let talk = page.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    let lines: Vec<&str> = talk.lines().collect();
    let folder = tempfile::tempdir().unwrap();
    // Slow machines stretch time rather than end.
    let live = live(folder.path(), &["--set", "stream.policy=\"slip\""]);
    let mode = fs::metadata(&live.socket).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600, "{mode:o}");
    let mut client = live.client();
    let mut pulses = Vec::new();
    for pair in lines.chunks(2) {
        let [sent, wanted] = pair else { panic!("{pair:?}") };
        client.send(format!("{}\n", sent.strip_prefix("> ").unwrap()).as_bytes());
        let answer = client.read_line();
        assert_eq!(unnumbered(&answer), wanted.strip_prefix("< ").unwrap(), "{sent}");
        pulses
            .extend(answer.strip_prefix("ok pulse ").map(|rest| rest.split(' ').next().unwrap().to_owned()));
    }
    let report = live.end();
    assert_eq!(report["stopped"], true);
    let last = report["pulses"].as_u64().unwrap();
    let taken: Vec<_> = pulses.iter().map(|n| n.parse::<u64>().unwrap()).filter(|n| *n < last).collect();
    let changes: Vec<_> =
        report["changes"].as_array().unwrap().iter().map(|c| c["pulse"].as_u64().unwrap()).collect();
    assert_eq!(changes, taken);
    assert_eq!(pulses.len(), 6);
    // The scenario of the page is one.
    let toml = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let text = fs::read_to_string(scenario()).unwrap();
    let long = toml.replace("2220", "222");
    let file = folder.path().join("event.toml");
    fs::write(&file, format!("{text}\n{long}")).unwrap();
    let ended = nereus(folder.path(), &["check", "event.toml"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

/// The pulse that the client is reported is the one in the recording, and the recording is that of the same
/// event.
#[test]
fn what_is_injected_is_recorded_and_can_be_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let set = ["--set", "stream.policy=\"slip\"", "--set", "scene.duration_s=3.0"];
    let running = live(folder.path(), &[&set[..], &["--out", "live.plain"]].concat());
    // Some pulses have left.
    let mut client = running.client();
    loop {
        client.send(b"status\n");
        let status = client.read_line();
        if !status.starts_with("ok released 0 ") {
            break;
        }
        thread::sleep(Duration::from_millis(20));
    }
    let ended = nereus(
        folder.path(),
        &["nav", "inject", "run.sock", "step", "attitude.heading", "-1.5", "deg", "on", "aircraft"],
    );
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    let pulse: u64 = ended.stdout.split(' ').nth(2).unwrap().parse().unwrap();
    assert_eq!(ended.stdout, format!("ok pulse {pulse} step attitude.heading -1.5 deg on aircraft\n"));
    let wrong = nereus(folder.path(), &["nav", "inject", "run.sock", "step up 5 m on aircraft"]);
    assert_eq!((wrong.code, wrong.stdout.as_str()), (1, ""));
    assert!(wrong.stderr.starts_with("error: axis 'up': allowed: position.east"), "{}", wrong.stderr);
    let report = running.end();
    assert!(pulse > 0 && pulse < 666);
    assert_eq!(report["changes"].as_array().unwrap().len(), 1);
    let change = &report["changes"][0];
    assert_eq!((change["pulse"].as_u64(), &change["platform"]), (Some(pulse), &"aircraft".into()));
    assert_eq!(
        (&change["text"], &change["source"]),
        (&"step attitude.heading -1.5 deg".into(), &"control".into())
    );
    let line = fs::read_to_string(folder.path().join("live.plain/truth/changes.jsonl")).unwrap();
    let row: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!(row, *change);

    let event =
        format!("event=[{{pulse={pulse},platform=\"aircraft\",change=\"step attitude.heading -1.5 deg\"}}]");
    for threads in ["stream.threads=1", "stream.threads=2"] {
        let out = format!("{}.plain", &threads[15..]);
        let again = nereus(
            folder.path(),
            &[
                &["run", &scenario(), "--pace", "fast", "--out", &out, "--set", &event, "--set", threads][..],
                &set,
            ]
            .concat(),
        );
        assert_eq!(again.code, 0, "{}", again.stderr);
        let same = |file: &str| {
            let [a, b] =
                ["live.plain", &out].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
            assert!(!a.is_empty() && a == b, "{threads}: {file} differs");
        };
        for file in [
            "iq",
            "pulse/index",
            "pulse/window_start_s",
            "nav/aircraft/reported/attitude_quat",
            "nav/aircraft/reported/position_m",
        ] {
            same(&format!("{file}.bin"));
        }
    }
}

#[test]
fn garbage_and_crowds_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let live = live(folder.path(), &["--set", "stream.policy=\"slip\""]);
    let mut client = live.client();
    client.send(&[0, 255, 254, 13, 10]);
    assert!(client.read_line().starts_with("error '"));
    client.send(b"\n");
    assert_eq!(client.read_line(), "error '': allowed: step, bias, ramp, dropout, latency, clear");
    // Longer than any line, then one that is none of it.
    client.send(&[b'x'; 100_000]);
    client.send(b"\nhelp\r\n");
    assert_eq!(client.read_line(), "error a line of more than 256 bytes: allowed: at most so many");
    assert!(client.read_line().starts_with("ok step AXIS"));
    // One that goes with half a line, and one that never reads.
    live.client().send(b"step position");
    let mut deaf = live.client();
    deaf.stream.set_write_timeout(Some(Duration::from_millis(100))).unwrap();
    let flood = "help\n".repeat(20_000);
    let _ = deaf.stream.write_all(flood.as_bytes());
    // A crowd: those for whom there is no room are reported. At most 16 may stay, and they receive nothing
    // unasked.
    let mut crowd: Vec<Client> = (0..40).map(|_| live.client()).collect();
    thread::sleep(Duration::from_millis(500));
    let read_line = |one: &mut Client| {
        one.stream.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
        let mut line = String::new();
        let _ = one.answers.read_line(&mut line);
        line
    };
    let answers: Vec<String> = crowd.iter_mut().map(read_line).filter(|line| !line.is_empty()).collect();
    assert!(answers.len() >= 24, "{}", answers.len());
    assert!(answers.iter().all(|line| line == "error 16 clients are connected: allowed: at most so many\n"));
    client.send(b"stop\n");
    assert_eq!(client.read_line(), "ok stopping");
    assert_eq!(live.end()["stopped"], true);
}

#[test]
fn sockets_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refusal = |path: &str| {
        let ended = nereus(folder.path(), &["run", &scenario(), "--out", "x.plain", "--control", path]);
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        assert!(!folder.path().join("x.plain").exists());
        ended.stderr
    };
    fs::write(folder.path().join("file"), "mine").unwrap();
    assert!(refusal("file").contains("exists and is no socket; allowed:"));
    assert_eq!(fs::read_to_string(folder.path().join("file")).unwrap(), "mine");
    assert!(refusal(&"x".repeat(100)).contains("100 bytes; allowed: a path of 1 to 90 bytes"));
    assert!(refusal("missing/run.sock").contains("No such file or directory"));
    // Another run is there: it keeps its socket. One that is dead is replaced.
    let listener = UnixListener::bind(folder.path().join("taken.sock")).unwrap();
    assert!(refusal("taken.sock").contains("another run listens there"));
    drop(listener);
    let ended = nereus(
        folder.path(),
        &[
            "run",
            &scenario(),
            "--pace",
            "fast",
            "--pulses",
            "0..3",
            "--out",
            "y.plain",
            "--control",
            "taken.sock",
        ],
    );
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(!folder.path().join("taken.sock").exists());
    let ended = nereus(folder.path(), &["nav", "inject", "taken.sock", "status"]);
    assert_eq!(ended.code, 1);
    assert!(ended.stderr.contains("allowed: the socket of a run under way"), "{}", ended.stderr);
}

#[test]
fn lines_come_from_standard_input_too() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", &scenario(), "--control", "-", "--out", "x.plain", "--set", "stream.policy=\"slip\""];
    let mut child = command(folder.path(), &run).stdin(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"dropout 1 s on mast\nstop\n").unwrap();
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert!(child.wait().unwrap().success(), "{stderr}");
    assert!(stderr.contains("ok pulse ") && stderr.contains(" dropout 1 s on mast\nok stopping"), "{stderr}");
}

#[test]
fn faults_of_events_are_reported_together() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(scenario()).unwrap()
        + r#"
[[event]]
pulse = 10
at_s = 1.0
platform = "aircraft"
change = "clear"
[[event]]
pulse = 888
platform = "aircraft"
change = "clear"
[[event]]
at_s = 4.0
platform = "ship"
change = "step position.up 5 m"
[[event]]
at_s = 1.0
change = "step position.up 5 furlongs"
"#;
    fs::write(folder.path().join("faults.toml"), text).unwrap();
    let ended = nereus(folder.path(), &["check", "faults.toml"]);
    assert_eq!(ended.code, 2);
    for part in [
        "pulse 888: allowed: before pulse 888, where the run ends",
        "there is no platform \"ship\"; allowed: mast, aircraft",
        "unit 'furlongs' of position.up: allowed: m",
        "at_s",
        "platform",
    ] {
        assert!(ended.stderr.contains(part), "{part}: {}", ended.stderr);
    }
    assert!(ended.stderr.matches("event.").count() >= 5, "{}", ended.stderr);
}
