//! What is given to read and is no file, and names that would write lines of their own.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::program::{Ended, command, nereus, package, started};

/// Runs `nereus`; `None`, and its end, if it takes longer than it may.
fn within(limit: Duration, folder: &Path, words: &[&str]) -> Option<Ended> {
    let mut child = started(folder, words);
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > limit {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Some(child.wait_with_output().unwrap().into())
}

/// Before: `nereus verify` and every command with a scenario, a log or a table waited for a writer, for ever.
#[test]
fn a_pipe_is_refused_by_every_command_that_reads() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("fifo");
    nix::unistd::mkfifo(&fifo, nix::sys::stat::Mode::S_IRWXU).unwrap();
    let commands = [
        "check fifo",
        "run fifo",
        "bench fifo",
        "tradeoff fifo",
        "fit fifo",
        "sea fifo",
        "wake fifo",
        "snapshot fifo",
        "speckle fifo",
        "verify fifo",
        "focus fifo --out p.png",
        "merge fifo fifo --out all.h5",
        "nav inspect fifo",
        "nav convert fifo out.csv",
        "nav corrupt fifo out.nmea",
        "nav play fifo file:out.nmea",
        "table hull fifo",
        "table spectrum --kind measured --spectrum-path fifo --from-rad-m 0.1 --to-rad-m 1",
    ];
    for command in commands {
        let words: Vec<&str> = command.split(' ').collect();
        let ended = within(Duration::from_secs(20), folder.path(), &words);
        let ended = ended.unwrap_or_else(|| panic!("nereus {command} waits for ever"));
        // `verify` reports what is wrong with a recording, and `merge` that it cannot be read; both end with
        // 1.
        let is_recording = ["verify", "merge"].iter().any(|word| command.starts_with(word));
        let expected = if is_recording && cfg!(feature = "hdf5") { 1 } else { 2 };
        assert_eq!(ended.code, expected, "nereus {command}: {}{}", ended.stdout, ended.stderr);
        assert!(!ended.stderr.contains("panicked"), "nereus {command}: {}", ended.stderr);
        let output = format!("{}{}", ended.stdout, ended.stderr);
        let words = ["is a pipe or a device; allowed: a regular file", "is no regular file; recordings are"];
        assert!(words.iter().any(|words| output.contains(words)), "nereus {command}: {output}");
    }
}

#[test]
fn pipes_in_a_plain_recording_are_faults() {
    let folder = tempfile::tempdir().unwrap();
    let config = package().join("configs/monostatic.toml").display().to_string();
    let run =
        ["run", &config, "--pace", "fast", "--pulses", "0..5", "--out", "rec", "--set", "sink.0.kind=plain"];
    for name in ["meta.json", "replica.bin", "iq.bin", "pulse/index.bin"] {
        let mut words = run.to_vec();
        words.push("--force");
        assert_eq!(nereus(folder.path(), &words).code, 0);
        let path = folder.path().join("rec").join(name);
        std::fs::remove_file(&path).unwrap();
        nix::unistd::mkfifo(&path, nix::sys::stat::Mode::S_IRWXU).unwrap();
        let ended = within(Duration::from_secs(20), folder.path(), &["verify", "rec"]);
        let ended = ended.unwrap_or_else(|| panic!("verify waits for {name}"));
        assert_eq!(ended.code, 1, "{name}: {}{}", ended.stdout, ended.stderr);
        assert!(ended.stdout.contains("is a pipe or a device; allowed: a regular file"), "{}", ended.stdout);
        std::fs::remove_dir_all(folder.path().join("rec")).unwrap();
    }
}

/// A recording whose names hold lines, under a name that does. Before: each forged a line of what is printed.
#[test]
fn names_stay_on_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let config = package().join("configs/monostatic.toml").display().to_string();
    let plain = ["--pace", "fast", "--pulses", "0..5", "--set", "sink.0.kind=plain", "--out", "rec"];
    let run: Vec<&str> = ["run", config.as_str()].into_iter().chain(plain).collect();
    assert_eq!(nereus(folder.path(), &run).code, 0);
    let meta = folder.path().join("rec/meta.json");
    let mut description: serde_json::Value = serde_json::from_slice(&std::fs::read(&meta).unwrap()).unwrap();
    description["channel"][0]["name"] = "HH\nforged.h5: whole; 5 pulses".into();
    // It names the antennas, too, and must agree; a recording of an earlier version has none.
    description["instrument"] = serde_json::Value::Null;
    // Its columns have no file of that name, which `verify` reports.
    let antenna = description["transmitters"][0].as_str().unwrap().to_owned();
    let text = description.to_string().replace(&format!("nav/{antenna}/"), "nav/a\\nforged.h5: whole/");
    let mut description: serde_json::Value = serde_json::from_str(&text).unwrap();
    description["transmitters"][0] = "a\nforged.h5: whole".into();
    std::fs::write(&meta, description.to_string()).unwrap();
    std::fs::rename(folder.path().join("rec"), folder.path().join("rec\nforged.h5: whole")).unwrap();
    let name = "rec\nforged.h5: whole";
    for words in [vec!["verify", name], vec!["focus", name, "--channel", "none", "--out", "p.png"]] {
        let ended = nereus(folder.path(), &words);
        assert_ne!(ended.code, 0);
        let output = format!("{}{}", ended.stdout, ended.stderr);
        assert!(output.contains("\\u{a}forged.h5"), "{output}");
        assert!(!output.lines().any(|line| line.starts_with("forged")), "{output}");
    }
}

/// Before: `\u{202e}` in JSON, which no parser reads, and of a path that is not UTF-8 no JSON at all, after a
/// complete run.
#[test]
fn json_is_valid_whatever_a_path_holds() {
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::OsStrExt;

    let folder = tempfile::tempdir().unwrap();
    let config = package().join("configs/monostatic.toml").into_os_string();
    let json = |words: &[&OsStr]| -> serde_json::Value {
        let ended = command(folder.path(), words).arg("--json").output().unwrap();
        let (out, err) = (String::from_utf8_lossy(&ended.stdout), String::from_utf8_lossy(&ended.stderr));
        serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {words:?}: {out}{err}"))
    };
    let names: [(&[u8], &str); 2] = [
        ("rec\u{202e}\u{7f}\u{9b}\u{61c}\u{2028}".as_bytes(), "rec\u{202e}\u{7f}\u{9b}\u{61c}\u{2028}"),
        (b"rec\xff", "rec\u{fffd}"),
    ];
    for (name, shown) in names {
        let words = ["run", "--pace", "fast", "--pulses", "0..5", "--set", "sink.0.kind=plain", "--out"];
        let mut words: Vec<OsString> = words.iter().map(OsString::from).collect();
        words.extend([OsStr::from_bytes(name).to_owned(), config.clone()]);
        let words: Vec<&OsStr> = words.iter().map(OsString::as_os_str).collect();
        let report = json(&words);
        assert_eq!(report["out"][0]["files"][0], shown);
        assert_eq!(report["error"], serde_json::Value::Null);
        let verdict = json(&[OsStr::new("verify"), OsStr::from_bytes(name)]);
        assert_eq!((&verdict["path"], &verdict["whole"]), (&shown.into(), &true.into()));
    }
}
