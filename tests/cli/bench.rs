//! `nereus bench` and `nereus tradeoff`, as a user starts them, on a sea of 16 x 16 facets.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use crate::cases::sized;
use crate::program::{Ended, nereus, package, started};

fn sea() -> String {
    package().join("configs/sea.toml").display().to_string()
}

/// A command on the small sea.
fn small(folder: &Path, command: &str, arguments: &[&str]) -> Ended {
    let scene = ["--set", "scene.patch_size_m=[16, 16]", "--threads", "2"];
    nereus(folder, &[&[command, &sea()], &scene[..], arguments].concat())
}

fn json(ended: &Ended) -> serde_json::Value {
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert_eq!(ended.stdout.lines().count(), 1, "{}", ended.stdout);
    serde_json::from_str(&ended.stdout).unwrap()
}

fn number(report: &serde_json::Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or_else(|| panic!("{key}: {report}"))
}

#[test]
fn bench_reports_speed_memory_stages_and_error() {
    let folder = tempfile::tempdir().unwrap();
    let calm = ["--set", "sea.scattering.breaking=off", "--pulses", "60", "--json"];
    let report = json(&small(folder.path(), "bench", &calm));
    // A buoy beside the facets.
    let whole = [("facets", 256), ("paths", 257), ("channels", 4), ("pulses", 60), ("threads", 2)];
    for (key, expected) in whole {
        assert_eq!(report[key], expected, "{key}");
    }
    let pulses_per_s = number(&report, "pulses_per_s");
    // The scenario's repetition frequency is 222 Hz.
    assert!((number(&report, "real_time_factor") * 222.0 / pulses_per_s - 1.0).abs() < 1e-9);
    assert!((number(&report, "facet_pulses_per_s") / (256.0 * pulses_per_s) - 1.0).abs() < 1e-9);
    let (worst, mean) = (number(&report, "rel_rms_db"), number(&report, "rel_rms_db_mean"));
    assert!(mean <= worst && worst < -60.0 && mean > -150.0, "{worst} {mean}");
    assert_eq!(report["error"]["pulses"].as_array().unwrap().len(), 16);
    let illuminated = number(&report, "illuminated");
    assert!(
        illuminated > 0.0 && illuminated <= 256.0 && number(&report, "culled") <= illuminated,
        "{report}"
    );
    assert!(number(&report, "accumulated") <= 257.0);
    if cfg!(target_os = "linux") {
        assert!(number(&report, "peak_rss_mib") > 1.0);
    }
    let startup_s = number(&report, "startup_s");
    assert!(startup_s > 0.0, "{startup_s}");
    // What the workers spent is what they had: two of them for as long as generation took, less what they
    // waited.
    let stages = report["stages"].as_object().unwrap();
    for stage in ["record", "surface", "shadow", "paths", "fill", "spread", "transform", "receive"] {
        assert!(stages[stage].as_f64().unwrap() >= 0.0, "{stage}");
    }
    let spent_s: f64 = stages.values().map(|seconds| seconds.as_f64().unwrap()).sum();
    assert!(spent_s > 0.0 && spent_s * pulses_per_s <= 2.0 * (1.0 + 1e-6), "{report}");
    assert_eq!(report["settings"]["echo"], "fast");
    assert!(report["settings"]["node_pulses"].as_u64().unwrap() > 1, "{report}");
    // What was predicted stands beside what was measured.
    assert!(number(&report, "predicted_rel_rms_db") <= -60.0, "{report}");
    for key in ["predicted_real_time_factor", "list_real_time_factor", "predicted_rss_mib"] {
        assert!(number(&report, key) > 0.0, "{key}: {report}");
    }
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none(), "nothing is recorded");
}

/// Memory is what was predicted, from a fixed patch to one that follows and to a ship of many panels, and not
/// far below.
#[test]
fn memory_is_that_predicted() {
    if !cfg!(target_os = "linux") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let config = package().join("configs/mars-1.toml").display().to_string();
    let follow = "scene.patch_follow={ kind = \"beside\", platform = \"aircraft\", across_m = -3000.0 }";
    let wide = sized("scene.patch_size_m=[256, 256]", "scene.patch_size_m=[192, 192]");
    let small = "scene.patch_size_m=[32, 32]";
    let short = sized("scene.duration_s=0.5", "scene.duration_s=0.2");
    let panels = ["ship.0.echo=true", "ship.0.length_m=50", "ship.0.panel_m=0.8", short];
    let ship = panels.map(|setting| ["--set", setting]).concat();
    for (patch, more) in [
        (wide, &[][..]),
        (wide, &["--set", "scene.patch=\"follow\"", "--set", follow][..]),
        (small, &ship[..]),
        ("scene.patch_size_m=[128, 128]", &["--set", "fidelity.node_pulses=1"][..]),
    ] {
        let patch = ["bench", &config, "--set", patch];
        let few = ["--pulses", sized("100", "20"), "--error-pulses", "0", "--threads", "2", "--json"];
        let arguments = [&patch[..], &few[..], more].concat();
        let report = json(&nereus(folder.path(), &arguments));
        let (found, predicted) = (number(&report, "peak_rss_mib"), number(&report, "predicted_rss_mib"));
        println!("{found:.0} MiB, predicted {predicted:.0}");
        // The prediction is a bound; the program's own share is the largest part of what is not used.
        assert!(found <= predicted && predicted <= 1.6 * found, "{found} {predicted}");
    }
}

#[test]
fn the_reference_has_no_error_and_coarse_nodes_have_one() {
    let folder = tempfile::tempdir().unwrap();
    let error = |more: &[&str]| {
        let arguments = [&["--pulses", "4", "--error-pulses", "16", "--json"], more].concat();
        number(&json(&small(folder.path(), "bench", &arguments)), "rel_rms_db")
    };
    assert!(error(&["--set", "fidelity.echo=reference"]) <= -200.0);
    let (close, wide) =
        (error(&["--set", "fidelity.error_db=-75.0"]), error(&["--set", "fidelity.error_db=-30.0"]));
    assert!(close < -70.0 && wide > close + 20.0, "{close} {wide}");
}

#[test]
fn bench_as_text_and_without_error() {
    let folder = tempfile::tempdir().unwrap();
    let ended = small(folder.path(), "bench", &["--pulses", "20", "--error-pulses", "0"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for part in ["times real time", "MiB", "stage spread", "not measured", "node_pulses", "predicted"] {
        assert!(ended.stdout.contains(part), "{part}: {}", ended.stdout);
    }
    let report = json(&small(folder.path(), "bench", &["--pulses", "20", "--error-pulses", "0", "--json"]));
    assert!(report["rel_rms_db"].is_null());
}

#[test]
fn bench_of_targets_alone() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = package().join("configs/calibration.toml").display().to_string();
    let bench = |more: &[&str]| {
        let arguments = [&["bench", &calibration, "--pulses", "50", "--json"], more].concat();
        json(&nereus(folder.path(), &arguments))
    };
    for (echo, most_db) in [("fast", -60.0), ("reference", -200.0)] {
        let report = bench(&["--set", &format!("fidelity.echo={echo}")]);
        assert_eq!((&report["facets"], &report["settings"]["echo"]), (&0.into(), &echo.into()));
        assert!(number(&report, "paths") >= 1.0 && number(&report, "rel_rms_db") <= most_db, "{report}");
    }
    assert_eq!(bench(&["--error-pulses", "0"])["settings"]["echo"], "fast", "the default");
}

#[test]
fn figures_that_cannot_be_measured_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |command: &str, arguments: &[&str], part: &str| {
        let ended = small(folder.path(), command, arguments);
        assert_eq!(ended.code, 2, "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(part) && ended.stdout.is_empty(), "{arguments:?}: {}", ended.stderr);
    };
    refused("bench", &["--pulses", "0"], "--pulses");
    refused("bench", &["--pulses", "112"], "0..111");
    refused("bench", &["--error-pulses", "few"], "error-pulses");
    refused("bench", &["--set", "fidelity.node_pulse=3"], "node_pulse");
    let crowded = nereus(folder.path(), &["bench", &sea(), "--threads", "5000"]);
    assert_eq!(crowded.code, 2, "{}", crowded.stderr);
    assert!(crowded.stderr.contains("--threads") && crowded.stderr.contains("1024"), "{}", crowded.stderr);
    refused("tradeoff", &["--error-pulses", "0"], "--error-pulses");
    refused("tradeoff", &["--set", "fidelity.kernel_width=9"], "kernel_width");
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("tradeoff.csv"), "mine").unwrap();
    let out = taken.display().to_string();
    refused("tradeoff", &["--out", &out], "tradeoff.csv");
    // Not even by force: it is none of ours.
    refused("tradeoff", &["--out", &out, "--force"], "tradeoff.csv");
    assert_eq!(fs::read_to_string(taken.join("tradeoff.csv")).unwrap(), "mine");
}

/// Runs a sweep into `swept`; also how many lines its table had from time to time, finished or not.
fn watched(folder: &Path, arguments: &[&str]) -> (Ended, BTreeSet<usize>) {
    let lines = || {
        let names = fs::read_dir(folder.join("swept")).into_iter().flatten().flatten();
        let table =
            names.map(|entry| entry.path()).find(|path| path.to_string_lossy().contains("tradeoff.csv"));
        table.and_then(|path| fs::read_to_string(path).ok()).unwrap_or_default().lines().count()
    };
    let begun = Instant::now();
    let child = started(folder, arguments);
    let ended = spawn(|| child.wait_with_output().unwrap());
    let mut seen = BTreeSet::new();
    while !ended.is_finished() {
        seen.insert(lines());
        assert!(begun.elapsed().as_secs() < 300, "{seen:?}");
        sleep(Duration::from_millis(2));
    }
    (ended.join().unwrap().into(), seen)
}

#[test]
fn tradeoff_sweeps_the_settings_and_writes_table_and_picture() {
    let folder = tempfile::tempdir().unwrap();
    let duration = sized("scene.duration_s=0.25", "scene.duration_s=0.12");
    let scene = ["--set", "scene.patch_size_m=[16, 16]", "--set", duration, "--threads", "2"];
    let sweep = ["--error-pulses", "4", "--trial-ms", "50", "--out", "swept", "--json"];
    let sea = sea();
    let arguments = [&["tradeoff", sea.as_str()], &scene[..], &sweep].concat();
    let (ended, seen) = watched(folder.path(), &arguments);
    let report = json(&ended);
    let points = report["points"].as_array().unwrap();
    assert_eq!(points[0]["change"], "as written");
    let of = |change: &str| {
        let found = points.iter().find(|point| point["change"] == change);
        number(found.unwrap_or_else(|| panic!("{change}: {report}")), "rel_rms_db")
    };
    assert!(of("fidelity.error_db=-30.0") > of("fidelity.error_db=-75.0") + 10.0, "{report}");
    // What the plan takes is the setting as written, and is not measured twice.
    assert_eq!(report["plan"], points[0]["settings"]);
    let settings: BTreeSet<String> = points.iter().map(|point| point["settings"].to_string()).collect();
    assert_eq!(settings.len(), points.len());
    // The front falls: whoever is faster on it is worse.
    let mut front: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| point["on_front"] == true)
        .map(|point| (number(point, "real_time_factor"), number(point, "rel_rms_db")))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(!front.is_empty() && front.is_sorted_by(|a, b| a.1 < b.1), "{front:?}");
    let taken = &report["taken"];
    // Kept as predicted and as measured.
    let keeps = |point: &serde_json::Value| {
        let predicted = point["predicted_rel_rms_db"].as_f64();
        number(point, "rel_rms_db") <= -60.0 && predicted.is_none_or(|db| db <= -60.0)
    };
    assert!(keeps(taken), "{taken}");
    let fastest = points
        .iter()
        .filter(|point| keeps(point))
        .map(|point| number(point, "real_time_factor"))
        .fold(0.0, f64::max);
    assert_eq!(number(taken, "real_time_factor"), fastest);
    // The model's choices stand apart.
    let models = report["models"].as_array().unwrap();
    assert!(models.iter().any(|effect| effect["change"] == "sea.scattering.splitting=mars2007"), "{report}");
    let csv = fs::read_to_string(folder.path().join("swept/tradeoff.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + points.len());
    // A sweep that is stopped keeps what was measured: rows of the whole table, one more each time. The polls
    // miss some, for writing one takes less than measuring one.
    let partial = seen.iter().filter(|lines| (2..1 + points.len()).contains(*lines)).count();
    assert!(seen.len() >= 4 && partial >= 2, "{seen:?}");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    assert_eq!(csv.lines().filter(|line| line.ends_with(",true")).count(), 1);
    let png = fs::read(folder.path().join("swept/tradeoff.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    let again = nereus(folder.path(), &arguments);
    assert_eq!(again.code, 2, "{}", again.stderr);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
}
