//! `nereus export crsd` and the sink `crsd`, as a user starts them. What the files hold, sarkit judges
//! (`tests/python/test_crsd.py`).

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::listing::listing;
use crate::program::{Ended, nereus, started};

/// Two polarisations in turn, converter codes, windows off the grid of samples.
const SCENARIO: &str = r#"
[scene]
origin_lat_deg = 54.2
origin_lon_deg = 7.9
origin_h_m = 40.0
duration_s = 0.1
seed = 3
[radar]
carrier_hz = 9.6e9
sample_rate_hz = 80e6
prf_hz = 333.0
tx_polarisation = "alternating"
channels = ["VV", "HV", "VH", "HH"]
noise_figure_db = 4.0
adc = { bits = 12, full_scale_dbw = -95.0 }
waveform = { kind = "lfm", bandwidth_hz = 60e6, pulse_s = 0.5e-6 }
window = { samples = 64, follow = { kind = "at", position_m = [0.0, 0.0, 0.0], lead_us = 0.3 } }
[[platform]]
name = "plane"
track = { kind = "straight", position_m = [-3000.0, -15.0, 3000.0], velocity_mps = [0.0, 150.0, 0.0] }
[[transmitter]]
name = "tx"
platform = "plane"
power_w = 500.0
antenna = { kind = "rectangle", width_m = 0.6, height_m = 0.1 }
pointing = { kind = "at", position_m = [0.0, 0.0, 0.0] }
[[receiver]]
name = "rx"
platform = "plane"
antenna = { kind = "ellipse", width_m = 0.6, height_m = 0.1 }
pointing = { kind = "at", position_m = [0.0, 0.0, 0.0] }
[[target]]
position_m = [0.0, 0.0, 0.0]
rcs_m2 = 100.0
[stream]
pace = "fast"
[[sink]]
kind = "plain"
path = "rec"
[[sink]]
kind = "crsd"
path = "direct.crsd"
"#;

/// A folder with a recording `rec` and the CRSD file of the same run.
fn recorded(more: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my.toml"), SCENARIO).unwrap();
    let ended = nereus(folder.path(), &[&["run", "my.toml"], more].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    folder
}

fn export(folder: &Path, more: &[&str]) -> Ended {
    nereus(folder, &[&["export", "crsd", "rec"], more].concat())
}

/// The value of a line of the header.
fn field(file: &[u8], name: &str) -> usize {
    let header = String::from_utf8_lossy(&file[..2048.min(file.len())]).into_owned();
    let line = header.lines().find_map(|line| line.strip_prefix(&format!("{name} := "))).unwrap().to_owned();
    line.parse().unwrap()
}

#[test]
fn a_run_and_the_export_of_its_recording_are_the_same_file() {
    let folder = recorded(&[]);
    let ended = export(folder.path(), &["--out", "later.crsd", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let [direct, later] =
        ["direct.crsd", "later.crsd"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(direct == later, "{} and {} bytes", direct.len(), later.len());
    assert_eq!(report["bytes"], direct.len());
    assert_eq!((&report["pulses"], &report["channels"][3]), (&34.into(), &"HH".into()));
    // 17 pulses of V and of H, two channels each of 64 samples of two 16-bit numbers.
    assert!(direct.starts_with(b"CRSDsar/1.0\n"));
    assert_eq!(field(&direct, "SIGNAL_BLOCK_SIZE"), 2 * 34 * 64 * 4);
    assert_eq!(field(&direct, "PPP_BLOCK_SIZE"), 34 * 224);
    assert_eq!(field(&direct, "PVP_BLOCK_SIZE"), 2 * 34 * 224);
    let end = field(&direct, "SIGNAL_BLOCK_BYTE_OFFSET") + field(&direct, "SIGNAL_BLOCK_SIZE");
    assert_eq!(end, direct.len());
}

#[test]
fn channels_are_chosen_by_name() {
    let folder = recorded(&[]);
    let ended = export(folder.path(), &["--channel", "HV,VV", "--out", "v.crsd"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("left out: VH, HH"), "{}", ended.stderr);
    assert_eq!(field(&fs::read(folder.path().join("v.crsd")).unwrap(), "PPP_BLOCK_SIZE"), 17 * 224);
    let ended = export(folder.path(), &["--channel", "XX", "--out", "x.crsd"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("XX; allowed: VV, HV, VH, HH"), "{}", ended.stderr);
    assert!(!folder.path().join("x.crsd").exists());
}

/// A run that is stopped has planned for more pulses than come: the file is that of the pulses that came.
#[cfg(unix)]
#[test]
fn a_stopped_run_leaves_a_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my.toml"), SCENARIO).unwrap();
    let run = [
        "run",
        "my.toml",
        "--pace",
        "realtime",
        "--set",
        "scene.duration_s=60",
        "--set",
        "stream.policy=slip",
    ];
    let mut child = started(folder.path(), &run);
    let begun = Instant::now();
    let index = folder.path().join("rec/pulse/index.bin");
    while !fs::metadata(&index).is_ok_and(|data| data.len() > 8 * 20) {
        assert!(begun.elapsed() < Duration::from_secs(60), "no pulses came");
        assert!(child.try_wait().unwrap().is_none(), "the run has ended");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(!folder.path().join("direct.crsd").exists(), "nobody can read it yet");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert!(child.wait().unwrap().success());
    let ended = export(folder.path(), &["--out", "later.crsd"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let [direct, later] =
        ["direct.crsd", "later.crsd"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(direct == later, "{} and {} bytes", direct.len(), later.len());
}

/// Every refusal has its reason, ends with exit code 2, and leaves the folder as it was.
#[test]
fn bad_recordings_are_refused_and_leave_nothing() {
    let folder = recorded(&[]);
    let path = |name: &str| folder.path().join(name);
    let refused = |recording: &str, words: &str| {
        let before = listing(folder.path());
        let ended = nereus(folder.path(), &["export", "crsd", recording, "--out", "new.crsd"]);
        assert_eq!(ended.code, 2, "{recording}: {}", ended.stderr);
        assert!(ended.stderr.contains(words), "{recording}: {}", ended.stderr);
        assert_eq!(listing(folder.path()), before, "{recording}");
    };
    refused("missing", "missing");
    refused("my.toml", "my.toml");
    refused("direct.crsd", "direct.crsd");
    fs::create_dir(path("empty")).unwrap();
    refused("empty", "meta.json");
    // Truncated: samples, then the header.
    let iq = fs::read(path("rec/iq.bin")).unwrap();
    fs::write(path("rec/iq.bin"), &iq[..iq.len() - 100]).unwrap();
    refused("rec", "iq");
    fs::write(path("rec/iq.bin"), &iq).unwrap();
    let meta = fs::read_to_string(path("rec/meta.json")).unwrap();
    fs::write(path("rec/meta.json"), &meta[..meta.len() / 2]).unwrap();
    refused("rec", "meta.json");
    // A scenario that describes something else, and none.
    for (from, to, words) in [
        ("name = \\\"tx\\\"", "name = \\\"ty\\\"", "no transmitter tx"),
        ("[radar]", "[rader]", "scenario in the recording cannot be read"),
        ("origin_lat_deg = 54.2\\norigin_lon_deg = 7.9\\norigin_h_m = 40.0", "", "no place on Earth"),
        ("\"truth\": true", "\"truth\": false", "came over the wire"),
    ] {
        assert!(meta.contains(from), "{from}");
        fs::write(path("rec/meta.json"), meta.replace(from, to)).unwrap();
        refused("rec", if words.starts_with("came") { "over the wire" } else { words });
    }
    fs::write(path("rec/meta.json"), &meta).unwrap();
    // Damaged: a position that is no number, times that do not ascend.
    let none = [0xff; 8];
    for (name, value, words) in [
        ("nav/rx/reported_phase_centre_m.bin", none, "reported position of rx is no finite number"),
        // Finite, and none any more in Earth-centred axes.
        (
            "nav/rx/reported_phase_centre_m.bin",
            f64::MAX.to_le_bytes(),
            "reported position of rx is no finite number",
        ),
        (
            "nav/plane/reported/velocity_mps.bin",
            f64::MAX.to_le_bytes(),
            "reported velocity of tx is no finite number",
        ),
        ("pulse/window_start_s.bin", none, "window_start_s"),
        ("pulse/time_ns.bin", none, "ascend"),
        ("replica.bin", none, "no replica of finite samples"),
    ] {
        let bytes = fs::read(path("rec").join(name)).unwrap();
        let mut damaged = bytes.clone();
        damaged[80..88].copy_from_slice(&value);
        fs::write(path("rec").join(name), damaged).unwrap();
        refused("rec", words);
        fs::write(path("rec").join(name), bytes).unwrap();
    }
    // One pulse alone; nothing at all.
    let index = fs::read(path("rec/pulse/index.bin")).unwrap();
    fs::write(path("rec/pulse/index.bin"), &index[..8]).unwrap();
    refused("rec", "2 or more");
    fs::write(path("rec/pulse/index.bin"), b"").unwrap();
    refused("rec", "holds pulses 0..0");
}

#[cfg(feature = "hdf5")]
#[test]
fn damaged_hdf5_recordings_leave_nothing() {
    let folder = recorded(&["--set", "sink.0.kind=\"hdf5\"", "--set", "sink.0.path=\"rec.h5\""]);
    let path = folder.path().join("rec.h5");
    let whole = fs::read(&path).unwrap();
    let before = listing(folder.path());
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let ended = nereus(folder.path(), &["export", "crsd", "rec.h5", "--out", "new.crsd"]);
        assert!(matches!(ended.code, 1 | 2), "{}", ended.stderr);
        assert!(ended.stderr.contains("rec.h5"), "{}", ended.stderr);
        assert_eq!(listing(folder.path()), before);
    };
    refused(&whole[..whole.len() / 2]);
    refused(&whole[..100]);
    refused(b"\x89HDF\r\n\x1a\nnothing more");
    // A chunk of samples whose checksum no longer holds: the largest stretch without repetition is samples.
    let mut damaged = whole.clone();
    let middle = damaged.len() / 2;
    damaged[middle..middle + 8].iter_mut().for_each(|byte| *byte = !*byte);
    refused(&damaged);
    fs::write(&path, &whole).unwrap();
    let ended = nereus(folder.path(), &["export", "crsd", "rec.h5"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let [direct, later] = ["direct.crsd", "rec.crsd"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(direct == later, "HDF5 and plain recordings give the same file");
}

#[test]
fn what_is_there_stays() {
    let folder = recorded(&[]);
    let path = |name: &str| folder.path().join(name);
    let again = export(folder.path(), &["--out", "direct.crsd"]);
    assert_eq!(again.code, 2);
    assert!(again.stderr.contains("direct.crsd: exists already"), "{}", again.stderr);
    assert_eq!(export(folder.path(), &["--out", "direct.crsd", "--force"]).code, 0);
    fs::write(path("thesis.crsd"), "chapter 1").unwrap();
    let foreign = export(folder.path(), &["--out", "thesis.crsd", "--force"]);
    assert_eq!(foreign.code, 2);
    assert!(foreign.stderr.contains("because it is no CRSD file"), "{}", foreign.stderr);
    assert_eq!(fs::read(path("thesis.crsd")).unwrap(), b"chapter 1");
    // CRSD of somebody else's radar.
    fs::write(path("thesis.crsd"), "CRSDsar/1.0\nXML_BLOCK_SIZE := 1000\n").unwrap();
    let foreign = export(folder.path(), &["--out", "thesis.crsd", "--force"]);
    assert!(
        foreign.code == 2 && foreign.stderr.contains("no CRSD file of this program"),
        "{}",
        foreign.stderr
    );
    for place in ["no/such/folder.crsd", "my.toml/x.crsd"] {
        let ended = export(folder.path(), &["--out", place]);
        assert_eq!(ended.code, 2, "{place}: {}", ended.stderr);
    }
    assert_eq!(listing(folder.path()), ["direct.crsd", "my.toml", "rec", "thesis.crsd"]);
}

/// Files of so many blocks of 512 bytes, and no more, as on a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_is_reported_with_the_name_of_the_output() {
    let folder = recorded(&[]);
    let before = listing(folder.path());
    for (format, out, named) in [("crsd", "new.crsd", "new.crsd"), ("sigmf", "new", "new-VV.sigmf-data")] {
        let limited = "trap '' XFSZ; ulimit -f 8; exec \"$0\" export \"$1\" rec --out \"$2\"";
        let mut command = Command::new("sh");
        command.args(["-c", limited, env!("CARGO_BIN_EXE_nereus"), format, out]);
        let ended = command.current_dir(folder.path()).output().unwrap();
        let text = String::from_utf8_lossy(&ended.stderr);
        // What the machine lacks is no wrong input.
        assert_eq!(ended.status.code(), Some(1), "{text}");
        assert!(text.starts_with(&format!("error: {named}: writing the ")), "{text}");
        assert_eq!(listing(folder.path()), before);
    }
}

#[test]
fn runs_that_crsd_cannot_express_are_refused_before_anything_is_made() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my.toml"), SCENARIO).unwrap();
    fs::write(folder.path().join("pulse.csv"), "1,0\n".repeat(40)).unwrap();
    for (set, words) in [
        ("scene.duration_s=0.004", "VV: 1 of the pulses"),
        (
            "radar.waveform={kind=\"file\",path=\"pulse.csv\",rate_hz=80e6}",
            "waveform is read from a file; allowed for CRSD",
        ),
    ] {
        let ended = nereus(folder.path(), &["run", "my.toml", "--set", set]);
        assert_eq!(ended.code, 2, "{set}: {}", ended.stderr);
        assert!(ended.stderr.contains(words), "{set}: {}", ended.stderr);
        assert_eq!(listing(folder.path()), ["my.toml", "pulse.csv"], "{set}");
    }
    let text = SCENARIO.replace("origin_lat_deg = 54.2\norigin_lon_deg = 7.9\norigin_h_m = 40.0\n", "");
    fs::write(folder.path().join("nowhere.toml"), text).unwrap();
    let ended = nereus(folder.path(), &["run", "nowhere.toml", "--force"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("origin_lat_deg, origin_lon_deg and origin_h_m"), "{}", ended.stderr);
    let ended =
        nereus(folder.path(), &["run", "my.toml", "--out", "named.crsd", "--force", "--set", "sink=[]"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(folder.path().join("named.crsd").exists());
}
