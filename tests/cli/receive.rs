//! `nereus run` to `nereus receive`, two programs on one machine.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::program::{command, nereus, package};

/// A receiver that listens at a port of the system's choice.
pub fn listening(folder: &Path, arguments: &[&str]) -> (Child, String) {
    begun(command(folder, &RECEIVE), arguments)
}

/// The same under a limit of the size of files.
#[cfg(unix)]
fn limited(folder: &Path, kib: u64, arguments: &[&str]) -> (Child, String) {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("ulimit -f {}; exec \"$0\" \"$@\"", kib * 2)]);
    shell.arg(env!("CARGO_BIN_EXE_nereus")).args(RECEIVE).current_dir(folder);
    shell.stdout(Stdio::piped()).stderr(Stdio::piped());
    begun(shell, arguments)
}

/// At a port of the system's choice; a loaded machine may take minutes for the pulses of a run.
const RECEIVE: [&str; 5] = ["receive", "--listen", "127.0.0.1:0", "--duration-s", "300"];

fn begun(mut program: Command, arguments: &[&str]) -> (Child, String) {
    let mut child = program.args(arguments).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
    let address = line.strip_prefix("listening at ").unwrap().split(',').next().unwrap().to_owned();
    assert!(line.contains("KiB"), "{line}");
    (child, address)
}

pub fn stdout(mut child: Child) -> String {
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert!(child.wait().unwrap().success());
    text
}

fn live_wire(folder: &Path, address: &str, out: &str) -> serde_json::Value {
    let config = package().join("configs/live-wire.toml").display().to_string();
    let address = format!("sink.0.address={address}");
    let run =
        ["run", &config, "--duration-s", "1", "--set", &address, "--set", "stream.policy=slip", "--out", out];
    let ended = nereus(folder, &[&run[..], &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    serde_json::from_str(ended.stdout.lines().last().unwrap()).unwrap()
}

#[test]
fn a_run_is_received_as_it_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let (sent, got) = if cfg!(feature = "hdf5") { ("sent.h5", "got.h5") } else { ("sent", "got") };
    let (receiver, address) = listening(folder.path(), &["--pulses", "222", "--out", got, "--json"]);
    let run = live_wire(folder.path(), &address, sent);
    let report: serde_json::Value = serde_json::from_str(&stdout(receiver)).unwrap();

    let wire = &run["out"][0];
    assert_eq!((&wire["name"], &wire["pulses"]), (&"vita49".into(), &222.into()));
    assert_eq!(wire["wire"]["datagrams"], report["datagrams"]);
    assert_eq!(wire["wire"]["refused"], 0);
    assert_eq!(report["pulses"], 222);
    for nothing in
        ["incomplete", "malformed", "unknown", "duplicates", "overtaken", "stray", "contradictions"]
    {
        assert_eq!(report[nothing], 0, "{nothing}");
    }
    assert_eq!(report["missing"]["pulses_by_index"], 0);
    assert_eq!(report["missing"]["packets_by_count"], 0);
    // Emissions of 2020 by a clock of today: years apart, and kept apart from the lateness, which is small.
    // (None where this machine was too busy to keep step.)
    let late = &report["lateness"];
    if late.is_null() {
        println!("skipped: the run was not in real time, {} s slipped", run["slipped_s"]);
    } else {
        assert!(late["least_offset_s"].as_f64().unwrap() > 1e8, "{late}");
        assert!(late["max_us"].as_f64().unwrap() < 60e6, "{late}");
    }
    assert_eq!(report["platforms"][1]["name"], "aircraft");
    assert_eq!(report["platforms"][1]["pulse"], 221);
    same(&folder.path().join(sent), &folder.path().join(got));
}

/// Every column that the wire carries, bit for bit; and the reader of recordings takes the file.
#[cfg(feature = "hdf5")]
fn same(sent: &Path, got: &Path) {
    let (a, b) = (hdf5::File::open(sent).unwrap(), hdf5::File::open(got).unwrap());
    let floats = |file: &hdf5::File, name: &str| -> Vec<u64> {
        file.dataset(name).unwrap().read_raw::<f64>().unwrap().into_iter().map(f64::to_bits).collect()
    };
    for platform in ["coast", "aircraft"] {
        for what in ["position_m", "velocity_mps", "attitude_quat"] {
            let name = format!("nav/{platform}/reported/{what}");
            assert!(floats(&a, &name) == floats(&b, &name), "{name}");
        }
        assert!(!b.link_exists(&format!("nav/{platform}/true")));
    }
    for name in ["pulse/window_start_s", "pulse/time_frac_ns"] {
        assert!(floats(&a, name) == floats(&b, name), "{name}");
    }
    for name in ["pulse/index", "pulse/time_ns", "pulse/flags", "pulse/tx_pol"] {
        let read = |file: &hdf5::File| file.dataset(name).unwrap().read_raw::<i64>().unwrap();
        assert!(read(&a) == read(&b), "{name}");
    }
    for name in ["channels", "transmit_basis", "receive_basis"] {
        let read = |file: &hdf5::File| {
            let texts = file.attr(name).unwrap().read_raw::<hdf5::types::VarLenUnicode>().unwrap();
            texts.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert!(read(&a) == read(&b) && read(&a).iter().all(|text| !text.is_empty()), "{name}");
    }
    let iq = |file: &hdf5::File| file.dataset("iq").unwrap().read_raw::<num_complex::Complex32>().unwrap();
    let (a_iq, b_iq) = (iq(&a), iq(&b));
    assert_eq!(a_iq.len(), 222 * 4 * 384);
    assert!(
        a_iq.iter()
            .zip(&b_iq)
            .all(|(x, y)| (x.re.to_bits(), x.im.to_bits()) == (y.re.to_bits(), y.im.to_bits()))
    );
    drop((a, b));
    let again = got.with_file_name("again.h5");
    let report = nereus::recording::merge::merge(&[got.to_owned()], &again, false).unwrap();
    assert_eq!((report.pulses, report.dropped), (222, 0));
}

#[cfg(not(feature = "hdf5"))]
fn same(sent: &Path, got: &Path) {
    for name in
        ["iq", "pulse/index", "pulse/time_ns", "pulse/window_start_s", "nav/aircraft/reported/position_m"]
    {
        let read = |folder: &Path| std::fs::read(folder.join(format!("{name}.bin"))).unwrap();
        assert!(read(sent) == read(got), "{name}");
    }
}

#[test]
fn the_report_as_text_has_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (receiver, address) = listening(folder.path(), &["--idle-s", "1.5"]);
    let out = if cfg!(feature = "hdf5") { "sent.h5" } else { "sent" };
    live_wire(folder.path(), &address, out);
    let text = stdout(receiver);
    for part in [
        "pulses     222 whole, 0 incomplete; numbers 0 to 221",
        "gaps       0 pulses by number, 0 by time stamps, 0 packets by packet counts",
        "platform   coast at pulse 221: 3000.000 m East, 0.000 m North, 15.000 m up",
        "\nlateness   ",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_run_without_a_receiver_ends_well_and_reports_what_was_refused() {
    let folder = tempfile::tempdir().unwrap();
    // A port that was free a moment ago.
    let address = std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let out = if cfg!(feature = "hdf5") { "sent.h5" } else { "sent" };
    let run = live_wire(folder.path(), &address, out);
    let wire = &run["out"][0]["wire"];
    assert_eq!(run["out"][0]["pulses"], 222);
    assert!(wire["refused"].as_u64().unwrap() > wire["datagrams"].as_u64().unwrap() / 2, "{wire}");
}

#[test]
fn addresses_and_outputs_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], part: &str| {
        let ended = nereus(folder.path(), &[&["receive", "--duration-s", "0.1"], arguments].concat());
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        assert!(ended.stderr.contains(part), "{part}: {}", ended.stderr);
    };
    refused(&["--listen", "nowhere"], "cannot listen at nowhere");
    let taken = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    refused(&["--listen", &taken.local_addr().unwrap().to_string()], "cannot listen at 127.0.0.1");
    refused(&["--listen", "127.0.0.1:0", "--out", "no/such/folder"], "no/such");
    refused(&["--idle-s", "0"], "allowed: a number of seconds above 0");
    let ended =
        nereus(folder.path(), &["receive", "--listen", "127.0.0.1:0", "--duration-s", "0.1", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((ended.code, &report["pulses"]), (0, &0.into()));
    // Before: the text was that the stream was not sent in real time.
    let ended = nereus(folder.path(), &["receive", "--listen", "127.0.0.1:0", "--duration-s", "0.1"]);
    assert!(ended.stdout.contains("lateness   not reported: nothing was received"), "{}", ended.stdout);
}

/// A limit of the size of files is what a full disk is: the recording can be read, and what is counted is
/// what is in it.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_what_is_counted() {
    let names = if cfg!(feature = "hdf5") { vec!["got.h5", "got"] } else { vec!["got"] };
    let recorded = |name: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (receiver, address) = limited(folder.path(), 2048, &["--idle-s", "3", "--out", name, "--json"]);
        live_wire(folder.path(), &address, if cfg!(feature = "hdf5") { "sent.h5" } else { "sent" });
        let ended = receiver.wait_with_output().unwrap();
        let report: serde_json::Value = serde_json::from_slice(&ended.stdout).unwrap();
        assert_eq!(ended.status.code(), Some(1), "{report}");
        let error = report["error"].as_str().unwrap();
        assert!(error.contains("File too large") && error.contains(name), "{report}");
        let found = nereus(folder.path(), &["verify", name, "--json"]);
        let found: serde_json::Value = serde_json::from_str(&found.stdout).unwrap();
        println!("{name}: {} received, {} recorded: {found}", report["pulses"], report["recorded"]);
        assert_eq!(report["recorded"], found["pulses"], "{found}");
        found["pulses"].as_u64().unwrap()
    };
    for name in names {
        // 222 pulses have 2.7 MB; they are written twice a second, on a loaded machine perhaps all at once.
        assert!((0..4).any(|_| recorded(name) > 0), "{name}");
    }
}

/// A description of some run, as `docs/wire.md` has it.
fn announcement() -> Vec<u8> {
    let mut words: Vec<u8> = Vec::new();
    // Extension context with class, UTC and picoseconds; stream; organisation and class 4; stamp.
    for word in [0x5860_0000u32, 0x4000_0000, 0x004e_4552, 0x0001_0004, 0, 0, 0] {
        words.extend(word.to_be_bytes());
    }
    // Origin; carrier, sample rate, bandwidth, pulse, PRF.
    for value in [f64::NAN, f64::NAN, f64::NAN, 1e10, 1e8, 8e7, 1e-6, 100.0] {
        words.extend(value.to_be_bytes());
    }
    // Start; first pulse, pulses, seed; no text.
    words.extend([0u8; 8 + 8]);
    for value in [0u64, 1000, 1] {
        words.extend(value.to_be_bytes());
    }
    words.extend([0u8; 4]);
    let count = (words.len() / 4) as u16;
    words[2..4].copy_from_slice(&count.to_be_bytes());
    words
}

/// With `--restart` the recordings of all runs are one output.
#[test]
fn further_recordings_follow_the_rule_of_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let (out, second, third) = match cfg!(feature = "hdf5") {
        true => ("left.h5", "left-2.h5", "left-3.h5"),
        false => ("left", "left-2", "left-3"),
    };
    let sent = if cfg!(feature = "hdf5") { "sent.h5" } else { "sent" };
    let there = |name: &str| folder.path().join(name).exists();
    // A run that is only announced leaves no recording.
    let (receiver, address) =
        listening(folder.path(), &["--idle-s", "2", "--restart", "--out", out, "--json"]);
    live_wire(folder.path(), &address, sent);
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    for _ in 0..2 {
        socket.send_to(&announcement(), &address).unwrap();
    }
    let report: serde_json::Value = serde_json::from_str(&stdout(receiver)).unwrap();
    assert_eq!((&report["restarts"], &report["recorded"]), (&1.into(), &222.into()), "{report}");
    assert_eq!(report["out"], serde_json::json!([out]));
    assert!(there(out) && !there(second));
    // What an earlier reception left is no part of this one: without --force it blocks the run, which is
    // reported at once.
    fs::rename(folder.path().join(out), folder.path().join(second)).unwrap();
    let ended = nereus(
        folder.path(),
        &["receive", "--listen", "127.0.0.1:0", "--duration-s", "0.1", "--restart", "--out", out],
    );
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains(&format!("{second}: exists already")), "{}", ended.stderr);
    // With it, it goes when the reception has ended well and made no second recording of its own.
    fs::write(folder.path().join("left-4.txt"), "a note").unwrap();
    fs::create_dir(folder.path().join("left-x")).unwrap();
    let again = ["--idle-s", "2", "--restart", "--force", "--out", out, "--json"];
    let (receiver, address) = listening(folder.path(), &again);
    fs::remove_dir_all(folder.path().join(sent))
        .or_else(|_| fs::remove_file(folder.path().join(sent)))
        .unwrap();
    live_wire(folder.path(), &address, sent);
    assert!(there(second));
    stdout(receiver);
    assert!(there(out) && !there(second) && there("left-4.txt") && there("left-x"));
    // What was not received is no part, whatever its name: it stays, and nothing is in its way.
    fs::create_dir(folder.path().join(third)).unwrap();
    fs::write(folder.path().join(third).join("important.txt"), "kept").unwrap();
    let dated = out.replace("left", "left-20180509");
    fs::rename(folder.path().join(out), folder.path().join(&dated)).unwrap();
    fs::rename(folder.path().join(sent), folder.path().join(second)).unwrap();
    for force in [None, Some("--force")] {
        let again = ["--idle-s", "2", "--restart", "--out", out, "--json"];
        let again: Vec<&str> = again.into_iter().chain(force).collect();
        let (receiver, address) = listening(folder.path(), &again);
        live_wire(folder.path(), &address, sent);
        stdout(receiver);
        assert!(there(out) && there(second) && there(&dated));
        assert!(folder.path().join(third).join("important.txt").exists());
        for name in [out, sent] {
            let path = folder.path().join(name);
            fs::remove_dir_all(&path).or_else(|_| fs::remove_file(&path)).unwrap();
        }
    }
}
