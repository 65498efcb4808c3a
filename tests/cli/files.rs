//! What happens to files when things go wrong: full disks, calls that fail, runs that meet, and
//! `nereus verify`.

use std::fs;
use std::path::Path;
#[cfg(target_os = "linux")]
use std::path::PathBuf;
use std::process::Command;
#[cfg(unix)]
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::cases::sized;
use crate::listing::listing;
use crate::program::{Ended, command, nereus, package, started};

fn scenario() -> String {
    package().join("configs/monostatic.toml").display().to_string()
}

fn json(text: &str) -> Value {
    text.lines().last().and_then(|line| serde_json::from_str(line).ok()).unwrap_or(Value::Null)
}

/// The recordings that this build makes.
fn recordings() -> Vec<&'static str> {
    if cfg!(feature = "hdf5") { vec!["rec.h5", "rec"] } else { vec!["rec"] }
}

fn run_of<'a>(config: &'a str, pulses: &'a str, out: &'a str) -> Vec<&'a str> {
    let mut words = vec!["run", config, "--pace", "fast", "--pulses", pulses, "--out", out, "--json"];
    if !out.ends_with(".h5") {
        words.extend(["--set", "sink.0.kind=plain"]);
    }
    words
}

/// `nereus` under a limit of the size of files, with the signal for that as the system sets it.
fn limited(folder: &Path, kib: u64, words: &[&str]) -> Ended {
    let output = Command::new("sh")
        .args(["-c", &format!("ulimit -f {}; exec \"$0\" \"$@\"", kib * 2)])
        .arg(env!("CARGO_BIN_EXE_nereus"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap();
    Ended {
        // A signal is no exit.
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

fn verdict(folder: &Path, name: &str) -> Value {
    json(&nereus(folder, &["verify", name, "--json"]).stdout)
}

#[cfg(unix)]
#[test]
fn counts_are_those_that_can_be_read_on_a_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    for name in recordings() {
        // 2000 pulses of 16 KiB are asked for.
        let ended = limited(folder.path(), 24 * 1024, &run_of(&config, "0..2000", name));
        assert_eq!(ended.code, 1, "{}", ended.stderr);
        assert!(ended.stderr.contains("File too large"), "{}", ended.stderr);
        let (report, found) = (json(&ended.stdout), verdict(folder.path(), name));
        println!(
            "{name}: {} written, {} readable: {}",
            report["sinks"][0]["written"], found["pulses"], found
        );
        assert_eq!(report["sinks"][0]["written"], found["pulses"]);
        assert!(found["pulses"].as_u64().unwrap() >= 500, "{found}");
        assert!(report["error"].as_str().unwrap().contains(name), "{report}");
        // What is there can be read to the last pulse.
        let places: Vec<&str> =
            found["findings"].as_array().unwrap().iter().map(|f| f["where"].as_str().unwrap()).collect();
        assert!(places.iter().all(|place| !place.contains("rows")), "{found}");
    }
}

#[cfg(unix)]
#[test]
fn navigation_on_a_full_disk_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    // The cart with its port alone.
    let text = fs::read_to_string(package().join("configs/cart.toml")).unwrap();
    let (before, port) = (text.split("[[sink]]").next().unwrap(), text.rsplit("[[sink]]").next().unwrap());
    let tracks = format!("{}/", package().join("configs/tracks").display());
    let text = format!("{before}[[sink]]{port}").replace("tracks/", &tracks);
    fs::write(folder.path().join("cart.toml"), text).unwrap();
    let run = ["run", "cart.toml", "--pace", "fast", "--json", "--set", "sink.0.rate_hz=100"];
    let ended = limited(folder.path(), 8, &run);
    assert_eq!(ended.code, 1, "{}\n{}", ended.stdout, ended.stderr);
    assert!(ended.stderr.contains("cart.nmea: writing: File too large"), "{}", ended.stderr);
    // It ends with a whole sentence.
    let text = fs::read_to_string(folder.path().join("cart.nmea")).unwrap();
    assert!(text.len() > 7000 && text.ends_with("\r\n"), "{}", text.len());
}

/// Runs that start together on one name: one makes the recording, the others say that it is there.
#[test]
fn runs_that_meet_leave_one_whole_recording() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    for name in recordings() {
        let words = run_of(&config, "0..50", name);
        let runs: Vec<_> = (0..6).map(|_| started(folder.path(), &words)).collect();
        let codes: Vec<i32> = runs.into_iter().map(|mut run| run.wait().unwrap().code().unwrap()).collect();
        assert_eq!(codes.iter().filter(|code| **code == 0).count(), 1, "{codes:?}");
        assert!(codes.iter().all(|code| *code == 0 || *code == 2), "{codes:?}");
        let ended = nereus(folder.path(), &["verify", name]);
        assert_eq!(ended.code, 0, "{}{}", ended.stdout, ended.stderr);
        assert!(ended.stdout.contains("whole; 50 pulses (0 to 49)"), "{}", ended.stdout);
    }
    assert_eq!(listing(folder.path()).len(), recordings().len());
}

/// A disk that is full from the beginning is no wrong input. Before: exit 2.
#[cfg(unix)]
#[test]
fn an_output_that_cannot_be_begun_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    for name in recordings() {
        let ended = limited(folder.path(), 0, &run_of(&config, "0..10", name));
        assert_eq!(ended.code, 1, "{name}: {}", ended.stderr);
        assert!(ended.stderr.contains("File too large"), "{name}: {}", ended.stderr);
    }
    // A folder that is not there is.
    let ended = nereus(folder.path(), &run_of(&config, "0..10", "no/such/folder/x.plain"));
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert_eq!(listing(folder.path()), Vec::<String>::new());
}

/// One sink on a full disk: by default the run ends, and where its key says so the others get all of it.
#[cfg(unix)]
#[test]
fn a_full_disk_ends_the_run_or_its_own_sink() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    let run = |on_failure: &str| {
        let sinks = format!(
            "sink=[{{ kind = \"plain\", path = \"full.plain\", on_failure = \"{on_failure}\", queue_pulses = 8 }}, {{ kind = \"null\" }}]"
        );
        let words =
            ["run", &config, "--pace", "fast", "--pulses", "0..2000", "--set", &sinks, "--force", "--json"];
        let ended = limited(folder.path(), 2048, &words);
        assert_eq!(ended.code, 1, "{}", ended.stderr);
        (json(&ended.stdout), ended.stderr)
    };
    let count = |report: &Value, sink: usize, what: &str| report["sinks"][sink][what].as_u64().unwrap();
    let (report, said) = run("stop");
    assert!(count(&report, 1, "written") < 2000, "{report}");
    assert!(!said.contains("went on without it"), "{said}");
    let (report, said) = run("continue");
    assert!(said.contains("sink 'plain' failed and the run went on without it"), "{said}");
    assert!(said.contains("File too large"), "{said}");
    assert_eq!((count(&report, 1, "written"), &report["pulses"]), (2000, &2000.into()));
    let (written, missed) = (count(&report, 0, "written"), count(&report, 0, "dropped"));
    assert_eq!((written + missed, &report["missed"]), (2000, &missed.into()));
    assert_eq!(report["sinks"][0]["failed"], true);
    assert!(report["error"].as_str().unwrap().contains("went on without it"), "{report}");
}

/// Two runs that replace one recording at once: before, the one that ended last removed what the other had
/// just made, and neither said so.
#[cfg(unix)]
#[test]
fn of_two_runs_that_replace_a_recording_one_says_so() {
    let config = scenario();
    for name in recordings() {
        let folder = tempfile::tempdir().unwrap();
        let made = nereus(folder.path(), &run_of(&config, "0..10", name));
        assert_eq!(made.code, 0, "{}", made.stderr);
        let mut slow = run_of(&config, "0..1000", name);
        slow.iter_mut().filter(|word| **word == "fast").for_each(|word| *word = "realtime");
        let first =
            started(folder.path(), &[&slow[..], &["--force", "--set", "stream.policy=slip"]].concat());
        // It has begun when its own file is there.
        let begun = Instant::now();
        while !listing(folder.path()).iter().any(|name| name.ends_with(".partial")) {
            assert!(begun.elapsed() < Duration::from_secs(60), "nothing is made");
            thread::sleep(Duration::from_millis(5));
        }
        let signal =
            |signal: &str| Command::new("kill").args([signal, &first.id().to_string()]).status().unwrap();
        signal("-STOP");
        let second = nereus(folder.path(), &[&run_of(&config, "0..20", name)[..], &["--force"]].concat());
        assert_eq!(second.code, 0, "{}", second.stderr);
        signal("-CONT");
        let first: Ended = first.wait_with_output().unwrap().into();
        assert_eq!(first.code, 1, "{}", first.stderr);
        let said =
            "not overwritten, because another program has put this output there since the new one was begun";
        assert!(first.stderr.contains(said), "{}", first.stderr);
        // Both are there, whole.
        assert_eq!(verdict(folder.path(), name)["pulses"], 20);
        let kept = json(&first.stdout)["out"][0]["files"][0].as_str().unwrap().to_owned();
        assert_eq!(verdict(folder.path(), &kept)["pulses"], 1000);
    }
}

#[test]
fn an_old_recording_survives_a_run_that_cannot_begin_or_fails() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    let name = recordings()[0];
    assert_eq!(nereus(folder.path(), &run_of(&config, "0..50", name)).code, 0);
    // Another sink that cannot be opened.
    let port = "\n[[sink]]\nkind = \"nav\"\ndevice = \"tcp://127.0.0.1:1\"\nplatform = \"aircraft\"\n";
    let text = format!("{}{port}", fs::read_to_string(&config).unwrap());
    let two = folder.path().join("two.toml").display().to_string();
    fs::write(
        &two,
        text.replacen("[scene]", "[scene]\norigin_lat_deg = 50.0\norigin_lon_deg = 0.0\norigin_h_m = 0.0", 1),
    )
    .unwrap();
    let mut words = run_of(&two, "0..20", name);
    words.push("--force");
    let ended = nereus(folder.path(), &words);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert_eq!(verdict(folder.path(), name)["pulses"], 50, "{}", ended.stderr);
    assert_eq!(listing(folder.path()).len(), 2, "{:?}", listing(folder.path()));
    // A disk that is full half-way.
    let mut words = run_of(&config, "0..2000", name);
    words.push("--force");
    let ended = limited(folder.path(), 4 * 1024, &words);
    assert_eq!(ended.code, 1, "{}", ended.stderr);
    assert_eq!(verdict(folder.path(), name)["pulses"], 50);
    // Complete at last.
    let mut words = run_of(&config, "0..30", name);
    words.push("--force");
    assert_eq!(nereus(folder.path(), &words).code, 0);
    assert_eq!(verdict(folder.path(), name)["pulses"], 30);
}

/// Before: refused when the run had ended, whose pulses were lost.
#[test]
fn an_output_without_a_name_is_refused_before_the_run() {
    let config = scenario();
    for (out, into) in [(".", "empty"), ("..", "empty/below")] {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join(into)).unwrap();
        let mut words = run_of(&config, "0..5", out);
        words.push("--force");
        let ended = nereus(&folder.path().join("empty"), &words);
        assert_eq!(ended.code, 2, "{out}: {}", ended.stderr);
        let allowed = "the path ends in no name; allowed: the name of a file or folder that is to be made";
        assert!(ended.stderr.contains(allowed), "{out}: {}", ended.stderr);
        assert_eq!(ended.stdout, "", "{out}");
        let receive = ["receive", "--listen", "127.0.0.1:0", "--out", out, "--force", "--duration-s", "1"];
        let ended = nereus(&folder.path().join("empty"), &receive);
        assert!(ended.code == 2 && ended.stderr.contains(allowed), "{out}: {}", ended.stderr);
    }
}

#[test]
fn verify_exits_by_what_it_found() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    assert_eq!(nereus(folder.path(), &run_of(&config, "10..40", "rec")).code, 0);
    let ended = nereus(folder.path(), &["verify", "rec"]);
    assert_eq!(ended.code, 0, "{}{}", ended.stdout, ended.stderr);
    assert!(
        ended.stdout.contains("rec: whole; 30 pulses (10 to 39), 0 dropped in real time"),
        "{}",
        ended.stdout
    );
    // It is all that was asked.
    assert_eq!(nereus(folder.path(), &["verify", "rec", "--complete"]).code, 0);
    let iq = folder.path().join("rec/iq.bin");
    let bytes = fs::read(&iq).unwrap();
    fs::write(&iq, &bytes[..bytes.len() - 100]).unwrap();
    let ended = nereus(folder.path(), &["verify", "rec", "--json"]);
    assert_eq!((ended.code, &json(&ended.stdout)["whole"]), (1, &Value::Bool(false)), "{}", ended.stdout);
    assert!(ended.stderr.contains("rec: not whole: 2 faults"), "{}", ended.stderr);
    assert_eq!(nereus(folder.path(), &["verify", "nowhere"]).code, 2);
}

/// The library that lets calls of the system fail, or lists them.
#[cfg(target_os = "linux")]
fn calls(folder: &Path) -> Option<PathBuf> {
    let library = folder.join("fault.so");
    let made = Command::new("cc")
        .args(["-O1", "-shared", "-fPIC", "-o"])
        .arg(&library)
        .arg(package().join("tests/data/io/fault.c"))
        .arg("-ldl")
        .status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: no C compiler (cc)");
        return None;
    }
    Some(library)
}

/// After a power cut there is the old recording or the new one: the new one, its folders and its name are on
/// the disk before the old one is removed.
#[cfg(target_os = "linux")]
#[test]
fn the_old_recording_goes_after_the_new_one_is_on_the_disk() {
    let tools = tempfile::tempdir().unwrap();
    let Some(library) = calls(tools.path()) else { return };
    let config = scenario();
    for name in recordings() {
        let folder = tempfile::tempdir().unwrap();
        let root = fs::canonicalize(folder.path()).unwrap();
        assert_eq!(nereus(&root, &run_of(&config, "0..20", name)).code, 0);
        // Named in full, so that every call has its whole path.
        let out = root.join(name).display().to_string();
        let mut words = run_of(&config, "0..10", &out);
        words.push("--force");
        let output = command(&root, &words)
            .env("LD_PRELOAD", &library)
            .env("NEREUS_FAULT_PATH", &root)
            .env("NEREUS_FAULT_LOG", "1")
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{stderr}");
        let calls: Vec<(&str, &str)> =
            stderr.lines().filter_map(|line| line.strip_prefix("io-call ")?.split_once(' ')).collect();
        let partial = |path: &str, inside: &str| path.ends_with(&format!(".partial{inside}"));
        let first = |wanted: &dyn Fn(&str, &str) -> bool| {
            calls
                .iter()
                .position(|(call, path)| wanted(call, path))
                .unwrap_or_else(|| panic!("{name}: {calls:#?}"))
        };
        // The last one: before it, the name is found to be taken.
        let renamed = calls.iter().rposition(|(call, path)| *call == "rename" && *path == out).unwrap();
        let synced = first(&|call, path| call == "sync" && Path::new(path) == root);
        let removed = first(&|call, _| call == "unlink");
        assert!(renamed < synced && synced < removed, "{name}: {calls:#?}");
        let inside: &[&str] = if name == "rec" {
            &[
                "/iq.bin",
                "/meta.json",
                "/pulse/index.bin",
                "/pulse",
                "/truth",
                "/nav",
                "/nav/aircraft/true",
                "",
            ]
        } else {
            &[""]
        };
        for inside in inside {
            let on_disk = first(&|call, path| call == "sync" && partial(path, inside));
            assert!(on_disk < renamed, "{name}{inside}: {calls:#?}");
        }
    }
}

/// A part of a run replaces its own segments, and a stopped run those that it wrote.
#[cfg(feature = "hdf5")]
#[test]
fn segments_of_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let config = scenario();
    let run = |more: &[&str]| {
        let words = ["run", &config, "--json", "--set", "sink.0.kind=hdf5", "--set", "sink.0.path=rec.h5"];
        let words = [&words[..], &["--set", "sink.0.segment_s=0.1"], more].concat();
        command(folder.path(), &words)
    };
    let ended = |more: &[&str]| {
        let output = run(more).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{stderr}");
        (json(&String::from_utf8(output.stdout).unwrap()), stderr)
    };
    let names: Vec<String> = (0..4).map(|k| format!("rec_{k:04}.h5")).collect();
    ended(&["--pace", "fast", "--duration-s", "0.4"]);
    assert_eq!(listing(folder.path()), names);
    // Another part of the run.
    let (report, stderr) =
        ended(&["--pace", "fast", "--duration-s", "0.4", "--pulses", "100..150", "--force"]);
    assert_eq!(listing(folder.path()), names);
    let pulses = |name: &str| verdict(folder.path(), name)["pulses"].clone();
    assert_eq!((pulses("rec_0001.h5"), pulses("rec_0003.h5")), (50.into(), 100.into()));
    assert_eq!(report["out"][0]["kept"].as_array().unwrap().len(), 3, "{report}");
    assert!(stderr.contains("rec_0000.h5 and 2 more: older, not removed, because the run"), "{stderr}");
    // A run that begins with a later segment, as one whose first pulses come too late.
    fs::remove_file(folder.path().join("rec_0003.h5")).unwrap();
    ended(&["--pace", "fast", "--duration-s", "0.4", "--pulses", "300..400", "--force"]);
    // Ctrl-C when the first segment has begun.
    let child = run(&["--set", "stream.pace=realtime", "--duration-s", "40", "--force"]).spawn().unwrap();
    let begun = Instant::now();
    while !listing(folder.path()).iter().any(|name| name.starts_with('.')) {
        assert!(begun.elapsed() < Duration::from_secs(60), "no pulse in a minute");
        std::thread::sleep(Duration::from_millis(5));
    }
    let pid = nix::unistd::Pid::from_raw(child.id().try_into().unwrap());
    nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = json(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(report["stopped"], true, "{report}");
    let left = listing(folder.path());
    assert!(names.iter().all(|name| left.contains(name)) && !left[0].starts_with('.'), "{left:?}");
    // Whole: what it does not write goes.
    let words = ["--pace", "fast", "--duration-s", "0.2", "--force"];
    // A recording that only has such a name is none of them.
    fs::copy(folder.path().join("rec_0000.h5"), folder.path().join("rec_20180509.h5")).unwrap();
    let (report, stderr) = ended(&words);
    assert!(report["out"][0]["kept"].is_null(), "{report}");
    // Those of the first run, and however many the stopped one came to write after them.
    let gone = &left[2..];
    assert_eq!(report["out"][0]["removed"], serde_json::json!(gone), "{report}");
    let said = format!("rec_0002.h5 and {} more: older, removed, because", gone.len() - 1);
    assert!(stderr.contains(&said), "{stderr}");
    assert_eq!(listing(folder.path()), [&names[..2], &["rec_20180509.h5".to_owned()]].concat());
}

/// Somebody removes the recording while it grows.
#[test]
fn a_recording_that_is_removed_meanwhile_is_a_failure() {
    let config = scenario();
    for name in recordings() {
        let folder = tempfile::tempdir().unwrap();
        let mut words = run_of(&config, "0..1000", name);
        // Late pulses count as well: a loaded machine drops none.
        words.extend(["--set", "stream.pace=realtime", "--set", "stream.policy=slip"]);
        words.retain(|word| !["--pace", "fast"].contains(word));
        let child = started(folder.path(), &words);
        let path = folder.path().join(name);
        let begun = Instant::now();
        while !path.exists() {
            assert!(begun.elapsed() < Duration::from_secs(60), "no recording in a minute");
            std::thread::sleep(Duration::from_millis(5));
        }
        if path.is_dir() {
            fs::remove_dir_all(&path).unwrap()
        } else {
            fs::remove_file(&path).unwrap()
        }
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(
            stderr.contains(&format!("{name}: removed by another program while it was written")),
            "{stderr}"
        );
        let report = json(&String::from_utf8(output.stdout).unwrap());
        assert_eq!(report["sinks"][0]["written"], 0, "{report}");
    }
}

/// Every call that makes a recording fails once, at each place in turn: what is there then can be read to its
/// last whole pulse, and the exit code and the counts say so. All of them with NEREUS_ALL_IO_FAULTS=1, else
/// every few.
#[cfg(target_os = "linux")]
#[test]
fn every_call_that_fails_is_reported_and_leaves_whole_pulses() {
    let tools = tempfile::tempdir().unwrap();
    let Some(library) = calls(tools.path()) else { return };
    let all = std::env::var_os("NEREUS_ALL_IO_FAULTS").is_some();
    let config = scenario();
    let mut wrong = Vec::new();
    for (name, stays) in recordings().into_iter().flat_map(|name| [(name, false), (name, true)]) {
        let (mut runs, mut failed, mut at) = (0, 0, 1);
        loop {
            let folder = tempfile::tempdir().unwrap();
            let words = run_of(&config, if all { "0..1200" } else { "0..200" }, name);
            let mut command = command(folder.path(), &words);
            command
                .env("LD_PRELOAD", &library)
                .env("NEREUS_FAULT_PATH", "rec")
                .env("NEREUS_FAULT_AT", at.to_string());
            if stays {
                command.env("NEREUS_FAULT_STAYS", "1");
            }
            let output = command.output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            let Some(fault) = stderr.lines().find(|line| line.starts_with("io-fault")) else { break };
            runs += 1;
            let report = json(&String::from_utf8_lossy(&output.stdout));
            let found = verdict(folder.path(), name);
            let there = folder.path().join(name).exists();
            let unreadable = found["findings"]
                .as_array()
                .is_some_and(|list| list.iter().any(|f| f["where"].as_str().unwrap().contains("rows")));
            let good = match output.status.code() {
                Some(0) => found["whole"] == true && found["pulses"] == report["sinks"][0]["written"],
                // A call that fails is no wrong input, at whatever stage.
                Some(1) => {
                    failed += 1;
                    let counted = report["sinks"][0]["written"].as_u64().unwrap_or(0);
                    if there { found["pulses"] == counted && !unreadable } else { counted == 0 }
                }
                _ => false,
            };
            if !good {
                wrong.push(format!(
                    "{name}, {fault}, stays {stays}: exit {:?}, there {there}, counted {}, found {found}\n{stderr}",
                    output.status.code(),
                    report["sinks"][0]["written"]
                ));
            }
            at += if all || at < 4 { 1 } else { 1 + at / sized(5, 1) };
        }
        println!("{name}, stays {stays}: {runs} runs, {failed} failed with an error; {} calls", at - 1);
        assert!(runs > 5, "{name}: the library was not loaded");
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
