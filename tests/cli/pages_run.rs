//! Every command of the front page and of docs/ is run, made small, or listed with the reason why not.
//!
//! A page has a folder of its own, with the scenarios, hulls and tools of the package. Its lines run in
//! order, so what one makes the next one reads.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::pages::{blocks, lines_of, name, pages, words};
use crate::program::{command, package};

/// Lines that are not run, by how they begin, and why.
const NOT_RUN: [(&str, &str); 24] = [
    ("cargo ", "builds; tools/test builds and runs the same"),
    ("tools/quickstart", "builds; tests/cli/setup_script.rs covers its set-up"),
    ("tools/test", "runs this test"),
    ("tools/release", "builds all anew; tools/test --all runs both lines"),
    ("tools/mocomp", "takes minutes; tests/cli/mocomp.rs compares the page with what it wrote"),
    ("tools/paper.py", "takes minutes; tests/cli/pages.rs compares the page with what it wrote"),
    ("python3 tools/baseline.py", "takes minutes; tests/cli/python_tools.rs runs it on a small sea"),
    ("python3 tools/steady.py", "reads an hour of pulses; tests/cli/python_tools.rs runs it on a few"),
    ("python3 tools/passive.py", "needs 200 blocks; tests/cli/python_tools.rs makes them"),
    ("python3 tools/focus_numpy.py", "takes minutes; tests/cli/focus.rs runs it on a small image"),
    ("nereus run configs/live-nav.toml --set platform.1.track.source=/dev", "needs a serial port"),
    ("nereus nav play configs/tracks/cart.inspvax /dev", "needs a serial port"),
    ("nereus nav play configs/tracks/cart.inspvax udp", "takes 15 s; tests/cli/nav.rs listens to it"),
    ("nereus nav play configs/tracks/cart.inspvax file", "takes 15 s; tests/cli/nav.rs reads what comes"),
    ("nereus receive --listen 127.0.0.1:4991 --pulses", "waits for a sender; with a sender it is run"),
    ("nereus run configs/quickstart.toml --monitor", "takes a port; tests/cli/monitor.rs takes a free one"),
    ("nereus monitor", "serves until Ctrl-C; tests/cli/monitor.rs ends it"),
    ("nereus speckle", "takes minutes; tests/cli/speckle.rs runs it on a small sea"),
    ("nereus focus quickstart.h5 --speckle", "needs a large image; tests/cli/speckle.rs runs it on its own"),
    ("nereus fit", "measures the machine; tests/cli/fit.rs runs it on a small sea"),
    ("nereus tradeoff", "takes minutes; tests/cli/bench.rs runs it on a small sea"),
    (
        "nereus run configs/mars-live.toml --duration-s 60",
        "takes a minute; the scenario is run by the next line",
    ),
    ("nereus run configs/coastal.toml --pulses 250..500", "the page of commands makes two parts ..."),
    ("nereus merge a.h5 b.h5", "... and merges them"),
];

/// What a page expects to be there, as commands.
const BEFORE: [(&str, &str); 6] = [
    ("docs/tutorial.md", "nereus run configs/quickstart.toml"),
    ("docs/reading.md", "nereus run configs/quickstart.toml"),
    ("docs/recording.md", "nereus run configs/coastal.toml --out rec.h5"),
    ("docs/recording.md", "nereus run configs/monostatic.toml --out rec"),
    ("docs/continuous.md", "nereus run configs/continuous.toml --out continuous.h5"),
    ("docs/navigation.md", "nereus nav convert configs/tracks/cart.inspvax cart.nmea"),
];

/// Scenarios with a sea, by the beginning of their names.
const WITH_SEA: [&str; 8] = [
    "configs/coastal-scan",
    "configs/mars-",
    "configs/quickstart",
    "configs/sea",
    "configs/continuous",
    "configs/passive",
    "configs/scan.toml",
    "first.toml",
];

/// What makes a sea quick in a debug build: few facets, and no plan of the fast echo, whose dry run takes a
/// minute. The tests of plans and benchmarks run the fast echo. Of settings of the same key the last one
/// counts.
const SMALL_SEA: [&str; 2] = ["scene.patch_size_m=[48,48]", "fidelity.echo=reference"];

/// Sets an option, in place of its value where it is given.
fn set(words: &mut Vec<String>, option: &str, value: &str) {
    match words.iter().position(|word| word == option) {
        Some(at) => words[at + 1] = value.to_owned(),
        None => words.extend([option.to_owned(), value.to_owned()]),
    }
}

/// The same command with fewer pulses, facets and pixels.
fn small(line: &str) -> Vec<String> {
    let mut words: Vec<String> = words(line).into_iter().skip(1).map(str::to_owned).collect();
    let has = |words: &[String], wanted: &str| words.iter().any(|word| word.starts_with(wanted));
    match words[0].as_str() {
        "run" if has(&words, "configs/live-nav") || has(&words, "--control") => {
            set(&mut words, "--duration-s", "1");
        }
        "run" => {
            set(&mut words, "--pace", "fast");
            if !has(&words, "--pulses") {
                set(&mut words, "--pulses", "0..6");
            }
        }
        "doctor" => {
            set(&mut words, "--seconds", "0.1");
        }
        "bench" => {
            set(&mut words, "--pulses", "6");
            set(&mut words, "--error-pulses", "1");
        }
        "focus" => {
            set(&mut words, "--size-m", "24");
            set(&mut words, "--pixel-m", "2");
            set(&mut words, "--channel", "VV");
            set(&mut words, "--interpolation-db", "-30");
        }
        _ => {}
    }
    let takes_a_scenario = ["run", "check", "bench", "sea", "snapshot", "wake"].contains(&words[0].as_str());
    if takes_a_scenario && WITH_SEA.iter().any(|begin| words[1].starts_with(begin)) {
        for setting in SMALL_SEA {
            words.extend(["--set", setting].map(str::to_owned));
        }
    }
    words
}

/// Whether python3 has modules; they are optional.
fn python_has(modules: &str) -> bool {
    let asked = Command::new("python3").args(["-c", &format!("import {modules}")]).output();
    asked.is_ok_and(|ended| ended.status.success())
}

/// Runs the lines of a page, one after the other.
struct Page<'a> {
    name: &'a str,
    folder: &'a Path,
    /// A program that goes on while the next line runs, and what the next line is to have for it.
    beside: Option<(Child, Vec<String>)>,
    faults: Vec<String>,
}

impl Page<'_> {
    fn nereus(&self, arguments: &[String]) -> Command {
        command(self.folder, arguments)
    }

    fn fault(&mut self, line: &str, ended: &Output) {
        let stderr = String::from_utf8_lossy(&ended.stderr);
        self.faults.push(format!("{}: {line}: {}\n{stderr}", self.name, ended.status));
    }

    /// Begins a receiver, and sends to it what the next line runs.
    fn receiver(&mut self, mut arguments: Vec<String>) {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        set(&mut arguments, "--listen", &free.to_string());
        set(&mut arguments, "--idle-s", "1");
        set(&mut arguments, "--duration-s", "60");
        let mut child = self.nereus(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
        assert!(line.starts_with("listening at "), "{}: {line}", self.name);
        self.beside = Some((child, vec!["--set".into(), format!("sink.0.address={free}")]));
    }

    /// Begins a run that takes commands, which the next line sends.
    fn controlled(&mut self, mut arguments: Vec<String>) {
        // It ends by itself if no line does it.
        arguments.extend(["--set", "stream.policy=\"slip\"", "--duration-s", "4"].map(str::to_owned));
        let socket = arguments[arguments.iter().position(|word| word == "--control").unwrap() + 1].clone();
        set(&mut arguments, "--out", "controlled.h5");
        let child = self.nereus(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let begun = Instant::now();
        while !self.folder.join(&socket).exists() && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(10));
        }
        self.beside = Some((child, Vec::new()));
    }

    fn line(&mut self, line: &str) {
        if line.starts_with("python3 ") {
            let modules = if line.contains("picture.py") { "numpy, h5py, matplotlib" } else { "numpy, h5py" };
            if !python_has(modules) {
                println!("skipped: no python3 with {modules}: {line}");
                return;
            }
            let mut command = Command::new("python3");
            command.args(words(line).iter().skip(1)).current_dir(self.folder);
            let ended = command.env("PYTHONDONTWRITEBYTECODE", "1").output().unwrap();
            if !ended.status.success() {
                self.fault(line, &ended);
            }
            return;
        }
        let mut arguments = small(line);
        if arguments[0] == "receive" {
            return self.receiver(arguments);
        }
        if arguments.iter().any(|word| word == "--control") {
            arguments.truncate(arguments.iter().position(|word| word == "--duration-s").unwrap());
            return self.controlled(arguments);
        }
        let beside = self.beside.take();
        arguments.extend(beside.iter().flat_map(|(_, more)| more.clone()));
        let ended = self.nereus(&arguments).output().unwrap();
        if !ended.status.success() {
            self.fault(line, &ended);
        }
        if let Some((_, file)) = line.split_once(" > ") {
            fs::write(self.folder.join(file.trim()), &ended.stdout).unwrap();
        }
        if let Some((mut child, _)) = beside {
            let status = child.wait().unwrap();
            if !status.success() {
                self.faults.push(format!("{}: beside {line}: {status}", self.name));
            }
        }
    }
}

/// Runs a page; what went wrong.
fn run(path: &Path, not_run: &Mutex<BTreeMap<&'static str, usize>>) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let name = name(path);
    let folder = tempfile::tempdir().unwrap();
    for shared in ["configs", "hulls", "python", "tools"] {
        symlink(package().join(shared), folder.path().join(shared)).unwrap();
    }
    fs::create_dir(folder.path().join("docs")).unwrap();
    // The scenario of the tutorial is the one that readers save.
    let tutorial = fs::read_to_string(package().join("docs/tutorial.md")).unwrap();
    fs::write(folder.path().join("first.toml"), blocks(&tutorial, "toml")[0]).unwrap();

    let mut page = Page { name: &name, folder: folder.path(), beside: None, faults: Vec::new() };
    for (_, line) in BEFORE.iter().filter(|(page, _)| *page == name) {
        page.line(line);
    }
    let began = Instant::now();
    let mut lines = 0;
    for line in lines_of(&text) {
        if let Some((begin, _)) = NOT_RUN.iter().find(|(begin, _)| line.starts_with(begin)) {
            *not_run.lock().unwrap().entry(begin).or_default() += 1;
            continue;
        }
        let begun = Instant::now();
        page.line(line);
        lines += 1;
        if begun.elapsed().as_secs() >= 5 {
            println!("{:6.1} s  {name}: {line}", begun.elapsed().as_secs_f64());
        }
    }
    for script in blocks(&text, "python") {
        let modules = if script.contains("sigmf") { "sigmf" } else { "numpy, h5py" };
        if !python_has(modules) {
            println!("skipped: no python3 with {modules}: a script of {name}");
            continue;
        }
        let mut command = Command::new("python3");
        command.args(["-c", script]).current_dir(folder.path()).env("PYTHONDONTWRITEBYTECODE", "1");
        let ended = command.env("PYTHONPATH", "python/nereus").output().unwrap();
        if !ended.status.success() {
            page.fault(script, &ended);
        }
    }
    println!("{:6.1} s  {name}: {lines} lines", began.elapsed().as_secs_f64());
    page.faults
}

#[test]
fn commands_of_the_pages_work() {
    let left = Mutex::new(pages());
    let not_run = Mutex::new(BTreeMap::new());
    let faults = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(path) = left.lock().unwrap().pop() else { return };
                    let found = run(&path, &not_run);
                    faults.lock().unwrap().extend(found);
                }
            });
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // A reason without a line is about a page that has changed.
    let not_run = not_run.into_inner().unwrap();
    for (begin, reason) in NOT_RUN {
        assert!(not_run.contains_key(begin), "no line begins with {begin} ({reason})");
    }
}
