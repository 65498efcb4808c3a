//! What is suspicious gives a warning, and what is left to the program is chosen so that it works.

use std::fs;
use std::path::Path;
use std::process::Command;

use nereus::frames::Geodetic;
use nereus::nav::Sigma;
use nereus::nav::encode::{Format, Sentence};
use nereus::nav::solution::Solution;
use nereus::time::TimeTag;
use serde_json::Value;

use crate::program::{Ended, nereus, package};

fn config(name: &str) -> String {
    package().join(format!("configs/{name}.toml")).display().to_string()
}

fn last_json(stdout: &str) -> Value {
    serde_json::from_str(stdout.lines().last().unwrap()).unwrap()
}

#[test]
fn targets_beside_the_window_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let far = ["--set", "target.+={ name = 'far', position_m = [90e3, 0, 5], rcs_m2 = 1.0 }"];
    for command in [&["check"][..], &["run", "--json", "--pace", "fast", "--duration-s", "0.1"]] {
        let name = config("coastal");
        let words = [&command[..1], &[name.as_str()], &command[1..], &far].concat();
        let ended = nereus(folder.path(), &words);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        assert!(ended.stderr.contains("never lie in the receive window: far (echo "), "{}", ended.stderr);
        if command[0] == "run" {
            let warnings = last_json(&ended.stdout)["warnings"].to_string();
            assert!(warnings.contains("far (echo "), "{warnings}");
        }
    }
}

#[test]
fn an_antenna_below_the_sea_is_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["check", "run"] {
        let ended = nereus(
            folder.path(),
            &[command, &config("coastal"), "--set", "transmitter.0.lever_arm_m=[0, 0, 4000]"],
        );
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        assert!(ended.stderr.contains("below mean sea level at pulse "), "{}", ended.stderr);
    }
}

/// With 1 GiB of addresses, which the sea would need many times over: nothing of it is made before it is
/// refused.
#[test]
fn a_sea_too_large_for_memory_is_refused_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["scene.patch_size_m=[8192, 8192]", "stream.threads=64"].map(|set| format!("--set '{set}'"));
    let call = format!(
        "ulimit -v 1048576; exec '{}' check '{}' {}",
        env!("CARGO_BIN_EXE_nereus"),
        config("sea"),
        words.join(" ")
    );
    let ended = Command::new("sh").args(["-c", &call]).current_dir(folder.path()).output().unwrap();
    let ended = Ended::from(ended);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("a sea of 67108864 facets takes about"), "{}", ended.stderr);
}

#[test]
fn levels_of_the_converter_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let run = |full_scale_dbw: &str| {
        let scale = format!("radar.adc.full_scale_dbw={full_scale_dbw}");
        let words =
            ["run", &config("monostatic"), "--json", "--pace", "fast", "--pulses", "0..64", "--set", &scale];
        let ended = nereus(folder.path(), &[&words[..], &["--set", "sink.0={ kind = 'null' }"]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        (last_json(&ended.stdout), ended.stderr)
    };
    let usual = run("-100").0;
    let of = &usual["converter"];
    let peak = of["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["peak_lsb"].as_f64().unwrap())
        .fold(0.0, f64::max);
    assert!(of["samples"].as_u64().unwrap() > 0 && peak > 0.0, "{of}");
    // A step is 6.02 dB of full scale a bit: levels in LSB scale with it.
    let bits = of["bits"].as_f64().unwrap();
    let peak_dbw = -100.0 + 20.0 * (peak / 2f64.powf(bits - 1.0)).log10();
    let (clipped, stderr) = run(&format!("{}", peak_dbw - 40.0));
    assert!(clipped["converter"]["saturated"].as_u64().unwrap() > 0, "{clipped}");
    assert!(stderr.contains("exceed the full scale of radar.adc, by up to 40.0 dB"), "{stderr}");
    let (lost, stderr) = run(&format!("{}", peak_dbw + 6.0206 * (bits - 1.0) + 6.0));
    assert_eq!(lost["converter"]["saturated"], 0);
    assert!(stderr.contains("the strongest sample is 0.50 of a code"), "{stderr}");
    let rms = |report: &Value| report["converter"]["channels"][0]["rms_lsb"].as_f64().unwrap();
    let by_db = 20.0 * (rms(&usual) / rms(&lost)).log10();
    assert!((by_db - (peak_dbw + 6.0206 * (bits - 1.0) + 106.0)).abs() < 0.01, "{by_db}");
}

#[test]
fn a_live_platform_is_checked_without_a_nominal_trajectory() {
    let folder = tempfile::tempdir().unwrap();
    let live = "platform.1.track={ kind = 'live', source = 'udp://127.0.0.1:5001' }";
    let ended = nereus(folder.path(), &["check", &config("live-nav"), "--json", "--set", live]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("platform 'cart' is live, and where it will be is not known"),
        "{}",
        ended.stderr
    );
    let report = last_json(&ended.stdout);
    assert!(report["plan"].is_null() && report["forecast"].is_null(), "{report}");
}

/// A flight of GGA and RMC, north at 60 m/s, so many epochs a second; one fix may lie elsewhere.
fn log(path: &Path, rate_hz: f64, seconds: f64, wrong: impl Fn(u32) -> f64) {
    let begin = TimeTag::from_iso8601("2021-06-01T12:00:00Z").unwrap();
    let format = Format::Nmea([Sentence::Gga, Sentence::Rmc].to_vec());
    let mut out = Vec::new();
    for epoch in 0..(seconds * rate_hz) as u32 {
        let t = f64::from(epoch) / rate_hz;
        let solution = Solution {
            time: begin.plus(t),
            place: Geodetic::from_deg(51.0 + (60.0 * t + wrong(epoch)) / 111_250.0, 1.5, 345.0),
            undulation_m: 45.0,
            velocity_mps: Some([0.0, 60.0, 0.0]),
            yaw_pitch_roll_rad: None,
            sigma: Sigma::default(),
        };
        format.write(&solution, &mut out).unwrap();
    }
    fs::write(path, out).unwrap();
}

/// A scene whose receiver flies on a track; the run begins 12 s after the first epoch.
fn scenario(folder: &Path, track: &str, more: &str) -> String {
    let text = format!(
        "[scene]\norigin_lat_deg = 51.0\norigin_lon_deg = 1.5\norigin_h_m = 45.0\n\
         start_utc = \"2021-06-01T12:00:12Z\"\nduration_s = 1.0\n\
         [radar]\ncarrier_hz = 10e9\nsample_rate_hz = 100e6\nprf_hz = 100\nchannels = [\"VV\"]\n\
         [radar.waveform]\nkind = \"lfm\"\nbandwidth_hz = 60e6\npulse_s = 1e-6\n\
         [radar.window]\nsamples = 512\nstart_us = 4.0\n\
         [[platform]]\nname = \"coast\"\ntrack = {{ kind = \"fixed\", position_m = [1500.0, 0.0, 15.0] }}\n\
         [[platform]]\nname = \"aircraft\"\ntrack = {track}\n\
         [[transmitter]]\nname = \"tx\"\nplatform = \"coast\"\npower_w = 1.0\nantenna = {{ kind = \"isotropic\" }}\n\
         [[receiver]]\nname = \"rx\"\nplatform = \"aircraft\"\nantenna = {{ kind = \"isotropic\" }}\n\
         [[target]]\nname = \"buoy\"\nposition_m = [300.0, 900.0, 2.0]\nrcs_dbsm = 20.0\n{more}"
    );
    let path = folder.join("scene.toml");
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

/// Positions at 1 Hz, nothing else: the run interpolates every pulse, and derives the attitude.
#[test]
fn slow_sentences_are_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    log(&folder.path().join("slow.nmea"), 1.0, 40.0, |_| 0.0);
    let config = scenario(folder.path(), "{ kind = \"live\", source = \"file:slow.nmea\" }", "");
    let ended = nereus(folder.path(), &["run", &config, "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report = last_json(&ended.stdout);
    assert_eq!(
        (&report["pulses"], &report["extrapolated"]),
        (&Value::from(100), &Value::from(0)),
        "{}",
        ended.stderr
    );
    assert!(
        ended.stderr.contains("latency ") && ended.stderr.contains("from the rate of the fixes"),
        "{}",
        ended.stderr
    );
    assert!(ended.stderr.contains("derived from the motion"), "{}", ended.stderr);
    // Asked for less, the run prints how much there should be.
    let asked = ["run", &config, "--set", "stream.latency_ms=2000", "--set", "stream.policy=drop"];
    let ended = nereus(folder.path(), &asked);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let stderr = "navigation arrives too late for stream.latency_ms = 2000: pulses will be extrapolated; stream.latency_ms at least ";
    assert!(ended.stderr.contains(stderr), "{}", ended.stderr);
}

/// A track of a minute to the West at 56 m/s, with the yaw and in the order of columns that are given.
fn westward(path: &Path, columns: &str, row: impl Fn(f64, f64) -> String) {
    let mut text = format!("time_utc,{columns}\n");
    for second in 0..40 {
        text += &format!("2021-06-01T12:00:{second:02}Z,{}\n", row(51.0, 1.5 - 8e-4 * f64::from(second)));
    }
    fs::write(path, text).unwrap();
}

const WESTWARD: &str = "{ kind = \"csv\", path = \"west.csv\", datum = \"msl\" }";

#[test]
fn yaw_in_radians_is_suspected() {
    let columns = "lat_deg,lon_deg,height_m,yaw_deg,pitch_deg,roll_deg";
    // Due West in radians, in degrees, and a heading by the North that wind might ask for.
    for (yaw, suspected) in [(-1.57, true), (4.71, true), (270.0, false), (-90.0, false), (0.2, false)] {
        let folder = tempfile::tempdir().unwrap();
        let row = |lat: f64, lon: f64| format!("{lat},{lon},300,{yaw},0,0");
        westward(&folder.path().join("west.csv"), columns, row);
        let ended = nereus(folder.path(), &["check", &scenario(folder.path(), WESTWARD, "")]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        assert_eq!(ended.stderr.contains("is yaw_deg in radians?"), suspected, "{yaw}: {}", ended.stderr);
    }
}

#[test]
fn a_track_with_latitude_and_longitude_swapped_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let row = |lat: f64, lon: f64| format!("{lon},{lat},300");
    westward(&folder.path().join("west.csv"), "lat_deg,lon_deg,height_m", row);
    let config = scenario(folder.path(), WESTWARD, "");
    let ended = nereus(folder.path(), &["check", &config]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    let said = "latitude and longitude of the track look swapped";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
    // The right order is not suspected.
    westward(&folder.path().join("west.csv"), "lon_deg,lat_deg,height_m", row);
    let ended = nereus(folder.path(), &["check", &config]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(!ended.stderr.contains("swapped"), "{}", ended.stderr);
}

/// A pulse that fills its interval, and a window that fills it, too: every target is received.
#[test]
fn at_full_duty_targets_lie_in_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let track = "{ kind = \"fixed\", position_m = [0.0, -500.0, 300.0] }";
    let config = scenario(folder.path(), track, "");
    let pulse = |pulse_s: &str, window: &[&str]| {
        let pulse = format!("radar.waveform.pulse_s={pulse_s}");
        let set = ["radar.sample_rate_hz=1e6", "radar.waveform.bandwidth_hz=0.5e6", &pulse];
        let words: Vec<&str> = set.iter().chain(window).flat_map(|set| ["--set", set]).collect();
        let ended = nereus(folder.path(), &[&["check", config.as_str()], &words[..]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stderr
    };
    let full = ["radar.window.samples=10000", "radar.window.start_us=0"];
    let stderr = pulse("1e-2", &full);
    assert!(!stderr.contains("lies in the receive window"), "{stderr}");
    // A short pulse is received whole or not at all.
    let stderr = pulse("20e-6", &["radar.window.samples=64", "radar.window.start_us=300"]);
    assert!(stderr.contains("no target lies in the receive window"), "{stderr}");
    // Its echo comes from 9.9 to 29.9 us after the emission.
    let stderr = pulse("20e-6", &["radar.window.samples=24", "radar.window.start_us=16"]);
    assert!(stderr.contains("the receive window cuts the echo of 1 of 1 targets at all times:"), "{stderr}");
    let stderr = pulse("20e-6", &["radar.window.samples=31", "radar.window.start_us=0"]);
    assert!(!stderr.contains("cuts the echo"), "{stderr}");
}

/// The same positions from a recording.
#[test]
fn a_recording_of_positions_derives_its_attitude() {
    let folder = tempfile::tempdir().unwrap();
    log(&folder.path().join("slow.nmea"), 1.0, 40.0, |_| 0.0);
    let track = "{ kind = \"nmea\", path = \"slow.nmea\", datum = \"msl\" }";
    let ended = nereus(folder.path(), &["check", &scenario(folder.path(), track, "")]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(
        ended.stdout.contains("no attitude among the fixes: derived from the motion"),
        "{}",
        ended.stdout
    );
}

/// One fix with a right checksum, 100 km away: counted, and not flown to.
#[test]
fn a_fix_far_away_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let far = |epoch: u32| if epoch == 125 { 1e5 } else { 0.0 };
    log(&folder.path().join("far.nmea"), 10.0, 40.0, far);
    let config = scenario(folder.path(), "{ kind = \"live\", source = \"file:far.nmea\" }", "");
    let ended = nereus(folder.path(), &["run", &config, "--json", "--out", "far.plain"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report = last_json(&ended.stdout);
    let flight = &report["navigation"][0];
    assert_eq!((&flight["implausible"], &flight["jumps"]), (&Value::from(1), &Value::from(0)), "{flight}");
    assert!(ended.stderr.contains("1 fix refused: the platform cannot have flown there"), "{}", ended.stderr);
    let bytes = fs::read(folder.path().join("far.plain/nav/aircraft/true/position_m.bin")).unwrap();
    let north: Vec<f64> =
        bytes.chunks_exact(24).map(|row| f64::from_le_bytes(row[8..16].try_into().unwrap())).collect();
    assert_eq!(north.len(), 100);
    for (pulse, north_m) in north.iter().enumerate() {
        let expected_m = 60.0 * (12.0 + pulse as f64 / 100.0);
        assert!((north_m - expected_m).abs() < 5.0, "pulse {pulse}: {north_m} m, {expected_m} m");
    }
}
