//! A platform that is flown over a pseudo terminal while the run goes on.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use nereus::frames::Geodetic;
use nereus::nav::Sigma;
use nereus::nav::encode::{Format, Sentence};
use nereus::nav::solution::Solution;
use nereus::time::TimeTag;
use serialport::{SerialPort, TTYPort};

use crate::program::{nereus, started};

/// Epochs per second of the receiver.
const RATE_HZ: f64 = 20.0;
/// Length of a run, s; pulses per second.
const RUN_S: f64 = 2.0;
const PRF_HZ: f64 = 200.0;

/// The first epoch; the run begins 2 s later.
fn begin() -> TimeTag {
    TimeTag::from_iso8601("2021-06-01T12:00:00Z").unwrap()
}

/// A flight that turns, climbs and rolls.
fn solution_at(epoch: u32) -> Solution {
    let t = f64::from(epoch) / RATE_HZ;
    let turn = 0.2 * t;
    Solution {
        time: begin().plus(t),
        place: Geodetic::from_deg(51.0 + 5e-3 * turn.sin(), 1.5 + 8e-3 * (1.0 - turn.cos()), 345.0 + 3.0 * t),
        undulation_m: 45.0,
        velocity_mps: Some([60.0 * turn.sin(), 60.0 * turn.cos(), 3.0]),
        yaw_pitch_roll_rad: Some([turn, 0.03 * (3.0 * t).sin(), 0.1 * (2.0 * t).cos()]),
        sigma: Sigma::default(),
    }
}

/// The messages of an epoch.
fn messages(format: &Format, epoch: u32) -> Vec<u8> {
    let mut out = Vec::new();
    format.write(&solution_at(epoch), &mut out).unwrap();
    out
}

fn mixed() -> Format {
    Format::Nmea([Sentence::Pashr, Sentence::Vtg, Sentence::Gga, Sentence::Zda, Sentence::Rmc].to_vec())
}

/// A scene of two targets whose receiver flies on a track.
fn scenario(folder: &Path, track: &str) -> String {
    let text = format!(
        "[scene]\norigin_lat_deg = 51.0\norigin_lon_deg = 1.5\norigin_h_m = 45.0\n\
         start_utc = \"2021-06-01T12:00:02Z\"\nduration_s = {RUN_S}\nseed = 3\n\
         [radar]\ncarrier_hz = 10e9\nsample_rate_hz = 100e6\nprf_hz = {PRF_HZ}\nchannels = [\"VV\"]\nnoise_figure_db = 3.0\n\
         [radar.waveform]\nkind = \"lfm\"\nbandwidth_hz = 60e6\npulse_s = 1e-6\n\
         [radar.window]\nsamples = 512\nstart_us = 8.0\n\
         [[platform]]\nname = \"coast\"\ntrack = {{ kind = \"fixed\", position_m = [1500.0, 0.0, 15.0] }}\n\
         [[platform]]\nname = \"aircraft\"\ntrack = {track}\n\
         [[transmitter]]\nname = \"tx\"\nplatform = \"coast\"\npower_w = 1.0\nantenna = {{ kind = \"isotropic\" }}\n\
         [[receiver]]\nname = \"rx\"\nplatform = \"aircraft\"\nantenna = {{ kind = \"isotropic\" }}\n\
         [[target]]\nname = \"buoy\"\nposition_m = [300.0, 900.0, 2.0]\nrcs_dbsm = 20.0\n\
         [stream]\nlatency_ms = 700.0\n[fidelity]\necho = \"reference\"\n"
    );
    let path = folder.join(format!("run-{}.toml", fs::read_dir(folder).unwrap().count()));
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

fn live(port: &str, more: &str) -> String {
    format!(
        "{{ kind = \"live\", source = \"{port}\", datum = \"ellipsoid\", attitude = \"recorded\"{more} }}"
    )
}

fn start(folder: &Path, config: &str, out: &str, more: &[&str]) -> Child {
    started(folder, &[&["run", config, "--json", "--out", out][..], more].concat())
}

fn report(child: Child) -> serde_json::Value {
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    println!("{text}");
    serde_json::from_str(String::from_utf8_lossy(&output.stdout).lines().last().unwrap()).unwrap()
}

/// Sends epochs at their times until the run has ended, but for those that `lost` selects; something else
/// before each.
fn fly(
    to: &mut impl Write,
    child: &mut Child,
    format: &Format,
    lost: impl Fn(u32) -> bool,
    noise: impl Fn(u32) -> Vec<u8>,
) {
    let begun = Instant::now();
    for epoch in 0.. {
        if child.try_wait().unwrap().is_some() || begun.elapsed() > Duration::from_secs(40) {
            return;
        }
        let due = Duration::from_secs_f64(f64::from(epoch) / RATE_HZ);
        thread::sleep(due.saturating_sub(begun.elapsed()));
        let _ = to.write_all(&noise(epoch));
        if !lost(epoch) {
            let _ = to.write_all(&messages(format, epoch));
        }
    }
}

/// The files of a plain recording that hold what was emulated.
fn recorded(folder: &Path, out: &str) -> Vec<(String, Vec<u8>)> {
    fn all(folder: &Path, under: &str, files: &mut Vec<(String, Vec<u8>)>) {
        for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let name = format!("{under}/{}", entry.file_name().display());
            if entry.file_type().unwrap().is_dir() {
                all(&entry.path(), &name, files);
            } else if !name.ends_with(".json") && !name.ends_with(".toml") {
                files.push((name, fs::read(entry.path()).unwrap()));
            }
        }
    }
    let mut files = Vec::new();
    all(&folder.join(out), "", &mut files);
    files.sort();
    files
}

fn terminal() -> (TTYPort, TTYPort, String) {
    let (master, slave) = TTYPort::pair().unwrap();
    let name = slave.name().unwrap();
    (master, slave, name)
}

#[test]
fn a_flight_over_a_terminal_has_the_bits_of_its_file() {
    for format in [Format::InspvaxBinary, mixed()] {
        let folder = tempfile::tempdir().unwrap();
        let (mut master, _slave, port) = terminal();
        let config = scenario(folder.path(), &live(&port, ""));
        let mut child = start(folder.path(), &config, "live", &[]);
        // Garbage and half sentences in between cost nothing.
        let noise = |epoch: u32| match epoch % 3 {
            0 => b"\x00\xff$GPGGA,12".to_vec(),
            1 => b"\r\n#INSPVAXA,noise*00000000\r\n\xaa\x44".to_vec(),
            _ => b"\r\n".to_vec(),
        };
        fly(&mut master, &mut child, &format, |_| false, noise);
        let report = report(child);
        assert_eq!(report["pulses"], (RUN_S * PRF_HZ) as u64);
        assert_eq!((&report["extrapolated"], &report["dropped"]), (&0.into(), &0.into()), "{report}");
        let flight = &report["navigation"][0];
        assert!(
            flight["malformed"].as_u64().unwrap() + flight["bad_checksum"].as_u64().unwrap() > 10,
            "{report}"
        );
        // The last fix before an emission comes up to an interval before it, and NMEA another one later.
        let latency_ms = &report["navigation_to_release_ms"];
        assert!(latency_ms["min"].as_f64().unwrap() > 600.0, "{report}");

        let log: Vec<u8> = (0..200).flat_map(|epoch| messages(&format, epoch)).collect();
        fs::write(folder.path().join("flight.log"), log).unwrap();
        let kind = if matches!(format, Format::Nmea(_)) { "nmea" } else { "inspvax" };
        let datum = if kind == "nmea" { "datum = \"ellipsoid\", " } else { "" };
        let track = format!("{{ kind = \"{kind}\", path = \"flight.log\", {datum}attitude = \"recorded\" }}");
        let config = scenario(folder.path(), &track);
        let ended = nereus(folder.path(), &["run", &config, "--pace", "fast", "--out", "file"]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let (live, file) = (recorded(folder.path(), "live"), recorded(folder.path(), "file"));
        assert!(live.len() > 5 && live.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() > 1_000_000);
        for ((name, live), (other, file)) in live.iter().zip(&file) {
            assert_eq!(name, other);
            // A stall of the machine makes a pulse late, whatever moves it.
            let late = |bytes: &[u8]| {
                let bits = bytes.chunks_exact(4).map(|four| u32::from_le_bytes(four.try_into().unwrap()));
                bits.map(|bits| bits & !nereus::pulse::flags::LATE).collect::<Vec<_>>()
            };
            let same = if name == "/pulse/flags.bin" { late(live) == late(file) } else { live == file };
            assert!(same, "{name} differs");
        }
    }
}

#[test]
fn what_comes_too_late_is_extrapolated_and_flagged() {
    let folder = tempfile::tempdir().unwrap();
    let (mut master, _slave, port) = terminal();
    let config = scenario(folder.path(), &live(&port, ", max_extrapolation_s = 0.3, max_gap_s = 1.0"));
    // Four fixes at 20 Hz take 200 ms: 60 ms do not cover them.
    let arguments = ["--set", "stream.latency_ms=60", "--set", "stream.policy=drop", "--duration-s", "4"];
    let mut child = start(folder.path(), &config, "live", &arguments);
    // Silence from 1 s after the begin of the run for 1.5 s.
    let lost = |epoch: u32| (60..90).contains(&epoch);
    fly(&mut master, &mut child, &Format::InspvaxBinary, lost, |_| Vec::new());
    let report = report(child);
    let count = |key: &str| report[key].as_u64().unwrap();
    assert!(count("extrapolated") + count("dropped") > 700, "{report}");
    // 1.2 s of it lie beyond what may be extrapolated.
    assert!((180..320).contains(&(count("stale"))), "{report}");
    assert!(report["navigation_to_release_ms"]["max"].as_f64().unwrap() > 1200.0, "{report}");
}

#[test]
fn what_cannot_run_live_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (_master, _slave, port) = terminal();
    let config = scenario(folder.path(), &live(&port, ", timeout_s = 0.3"));
    let refused = |arguments: &[&str]| {
        let ended = nereus(folder.path(), &[&["run", &config, "--out", "out"], arguments].concat());
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        assert!(!folder.path().join("out").exists());
        ended.stderr
    };
    let stderr = refused(&["--set", "stream.policy=slip"]);
    assert!(stderr.contains("live") && stderr.contains("slip"), "{stderr}");
    let stderr = refused(&["--pace", "fast"]);
    assert!(stderr.contains("live navigation goes on in real time") && stderr.contains("fast"), "{stderr}");
    // Nobody speaks.
    let stderr = refused(&[]);
    assert!(stderr.contains("no navigation from") && stderr.contains("within 0.3 s"), "{stderr}");
}
