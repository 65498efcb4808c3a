//! `nereus run` and `nereus merge`, as a user starts them.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant, SystemTime};

use crate::program::{Ended, nereus, package, started};

fn calibration() -> String {
    package().join("configs/calibration.toml").display().to_string()
}

fn json(stdout: &str) -> serde_json::Value {
    serde_json::from_str(stdout.lines().last().unwrap()).unwrap()
}

/// Extension of a recording that this build can make.
const RECORDING: &str = if cfg!(feature = "hdf5") { "h5" } else { "plain" };

#[test]
fn a_run_reports_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let out = format!("run.{RECORDING}");
    let run = ["run", &calibration(), "--pace", "fast", "--pulses", "10..40", "--out", &out, "--json"];
    let ended = nereus(folder.path(), &run);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let summary = json(&ended.stdout);
    assert_eq!(summary["pulses"], 30);
    assert_eq!((&summary["late"], &summary["dropped"]), (&0.into(), &0.into()));
    for key in ["p50", "p99", "p999", "max"] {
        assert!(summary["lateness_us"][key].is_number(), "{key}");
    }
    assert!(summary["real_time_factor"].as_f64().unwrap() > 0.0);
    assert_eq!(summary["sinks"][0]["written"], 30);
    assert_eq!(summary["out"][0]["pulses"], 30);
    assert!(folder.path().join(&out).exists());
    assert!(!ended.stderr.contains("slipped"), "{}", ended.stderr);
    // How the recorded track was made is reported.
    assert!(ended.stderr.contains("smoothed"), "{}", ended.stderr);

    // What exists is not overwritten, and nothing of it is touched.
    let before = fs::metadata(folder.path().join(&out)).unwrap().modified().unwrap();
    let again = nereus(folder.path(), &run);
    assert_eq!(again.code, 2, "{}", again.stderr);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
    assert_eq!(before, fs::metadata(folder.path().join(&out)).unwrap().modified().unwrap());
    let forced = nereus(folder.path(), &[&run[..], &["--force"]].concat());
    assert_eq!(forced.code, 0, "{}", forced.stderr);
}

#[test]
fn pulses_that_the_run_does_not_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let ended = nereus(folder.path(), &["run", &calibration(), "--pulses", "10..4000", "--out", "x.plain"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("10..4000") && ended.stderr.contains("0..2220"), "{}", ended.stderr);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is half-written");
}

#[test]
fn faults_of_tracks_and_outputs_are_reported_together() {
    let folder = tempfile::tempdir().unwrap();
    let track = folder.path().join("backwards.csv");
    fs::write(
        &track,
        "time_utc,lat_deg,lon_deg,height_m\n2018-05-30T18:38:00Z,52.9,4.6,4000\n2018-05-30T18:37:00Z,52.9,4.6,NaN\n",
    )
    .unwrap();
    let path = format!("platform.1.track.path=\"{}\"", track.display());
    let ended = nereus(
        folder.path(),
        &[
            "run",
            &calibration(),
            "--set",
            &path,
            "--out",
            "missing/folder/run.plain",
            "--set",
            "sink.0.kind=\"plain\"",
        ],
    );
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    for part in ["backwards.csv", "line 3", "NaN", "missing/folder"] {
        assert!(ended.stderr.contains(part), "{part}: {}", ended.stderr);
    }
}

#[test]
fn a_track_that_ends_before_the_run_does_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let ended = nereus(
        folder.path(),
        &["run", &calibration(), "--duration-s", "1000", "--out", &format!("x.{RECORDING}")],
    );
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("missing at the end"), "{}", ended.stderr);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    // Wholly beside it: said once, with what is allowed.
    let set = ["--set", "scene.start_utc=2018-06-02T00:00:00Z", "--out", "x.plain"];
    let ended = nereus(folder.path(), &[&["run", &calibration()][..], &set].concat());
    assert_eq!(
        (ended.code, ended.stderr.matches("which ends before the run").count()),
        (2, 1),
        "{}",
        ended.stderr
    );
    assert!(ended.stderr.contains("allowed: a scene.start_utc within the track"), "{}", ended.stderr);
    assert_eq!(ended.stderr.matches("2018-06-02T00:00:00").count(), 1, "{}", ended.stderr);
}

/// A run in real time on a small sea, whose pulses come in blocks: more of them than a millisecond holds.
fn short_of_latency(policy: &str, more: &[&str]) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    let sea = package().join("configs/sea.toml").display().to_string();
    let policy = format!("stream.policy={policy}");
    let scene = ["run", &sea, "--set", "scene.patch_size_m=[128, 128]", "--set", &policy, "--json"];
    let rate = ["--set", "radar.prf_hz=5000", "--pace", "realtime", "--set", "stream.threads=2"];
    let short = ["--set", "fidelity.node_pulses=12"];
    let sink = ["--set", "sink.0.kind=plain", "--out", "x.plain", "--set", "stream.latency_ms=1"];
    nereus(folder.path(), &[&scene[..], &rate, &short, &sink, more].concat())
}

#[test]
fn a_latency_below_a_block_is_refused_with_one_that_is_allowed() {
    let ended = short_of_latency("stop", &["--duration-s", "0.1"]);
    assert_eq!(ended.code, 1, "{}", ended.stderr);
    // 37 pulses of each of two threads at 5 kHz.
    for part in ["after its deadline pulse 0 is not made yet", "stream.latency_ms = 15 or more (it is 1;"] {
        assert!(ended.stderr.contains(part), "{part}: {}", ended.stderr);
    }
    for part in ["0.0 pulses/s", "factor 0.000", "lateness p50"] {
        assert!(!ended.stderr.contains(part), "{part}: {}", ended.stderr);
    }
    assert!(json(&ended.stdout)["error"].as_str().unwrap().contains("pulse 0"));
}

/// Before: 13 of 5,000 pulses were released, and nothing said why.
#[test]
fn a_latency_that_drops_pulses_is_named() {
    let ended = short_of_latency("drop", &["--duration-s", "0.3"]);
    // Nothing else is wrong with it, however few were in time.
    let summary = json(&ended.stdout);
    assert!(summary["dropped"].as_u64().unwrap() > 0, "{summary}");
    assert!(ended.stderr.contains(" dropped: stream.latency_ms = 15 or more (it is 1;"), "{}", ended.stderr);
    let folder = tempfile::tempdir().unwrap();
    let sea = package().join("configs/sea.toml").display().to_string();
    let check = |latency: &str| {
        let set = ["scene.patch_size_m=[128, 128]", "radar.prf_hz=5000", "stream.pace=realtime", latency];
        let more = ["stream.threads=2", "fidelity.node_pulses=12", "sink=[]"];
        let set = set.into_iter().chain(more).flat_map(|set| ["--set", set]);
        nereus(folder.path(), &["check", &sea].into_iter().chain(set).collect::<Vec<_>>()).stderr
    };
    let warned = check("stream.latency_ms=1");
    assert!(warned.contains("come too late in real time: those that are made at once take"), "{warned}");
    assert!(warned.contains("ms on this machine; stream.latency_ms = 15 or more (it is 1;"), "{warned}");
    assert!(!check("stream.latency_ms=15").contains("stream.latency_ms"));
}

#[test]
fn a_run_that_releases_nothing_has_failed() {
    // One block, and it is late as a whole.
    let ended = short_of_latency("drop", &["--pulses", "0..3"]);
    assert_eq!(ended.code, 1, "{}", ended.stderr);
    for part in ["not one pulse of 3 was released", "stream.latency_ms = 15 or more (it is 1;"] {
        assert!(ended.stderr.contains(part), "{part}: {}", ended.stderr);
    }
    let summary = json(&ended.stdout);
    assert_eq!((&summary["pulses"], &summary["dropped"]), (&0.into(), &3.into()));
    assert!(summary["error"].as_str().unwrap().contains("not one pulse of 3"));
}

#[test]
fn slipped_time_is_reported() {
    let ended = short_of_latency("slip", &["--pulses", "0..1"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("released 1 pulse in "), "{}", ended.stderr);
    assert!(ended.stderr.contains("time slipped by "), "{}", ended.stderr);
    assert!(json(&ended.stdout)["slipped_s"].as_f64().unwrap() > 0.0, "{}", ended.stdout);
}

/// Stamps are those of the clock at which pulses are emitted, released by the latency later.
#[test]
fn a_run_that_starts_now_waits_for_its_start() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = package().join("configs/live-wire.toml").display().to_string();
    let clock = || SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs_f64();
    let before_s = clock();
    let set = ["--set", "scene.start_utc=now", "--set", "sink=[]", "--set", "stream.policy=slip"];
    let run = ["run", &scenario, "--duration-s", "0.3", "--out", "now.plain", "--json"];
    let ended = nereus(folder.path(), &[&run[..], &set].concat());
    let after_s = clock();
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("pulses begin at 20"), "{}", ended.stderr);
    let stamps = fs::read(folder.path().join("now.plain/pulse/time_ns.bin")).unwrap();
    let first_s = i64::from_le_bytes(stamps[..8].try_into().unwrap()) as f64 * 1e-9;
    // 3 s ahead; the last pulse, 0.3 s later, is released half a second after its stamp.
    assert!(first_s.fract() == 0.0 && first_s >= before_s + 3.0, "{before_s} {first_s}");
    assert!(after_s >= first_s + 0.3 + 0.49, "{first_s} {after_s}");
    let recorded = fs::read_to_string(folder.path().join("now.plain/meta.json")).unwrap();
    assert!(!recorded.contains("start_utc = \\\"now\\\""), "{recorded}");
}

#[test]
fn a_name_that_says_another_format_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = package().join("configs/mocomp-step.toml").display().to_string();
    let run = ["run", &scenario, "--pace", "fast", "--pulses", "0..4", "--out", "x.sigmf-meta"];
    let ended = nereus(folder.path(), &run);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let warned = "warning: x.sigmf-meta becomes a recording of kind = \"plain\", whatever its name says";
    assert!(ended.stderr.contains(warned), "{}", ended.stderr);
    let ended = nereus(folder.path(), &[&run[..6], &["--out", "x.plain"]].concat());
    assert!(ended.code == 0 && !ended.stderr.contains("whatever"), "{}", ended.stderr);
}

/// Ctrl-C ends a run cleanly, and so does whoever stops a service: exit 0, the recording closed and readable.
#[cfg(unix)]
#[test]
fn signals_close_the_recording() {
    ["-INT", "-TERM"].into_iter().for_each(|signal| closed_by(signal, 1));
}

/// Before: the second signal ended the program while its files were open.
#[cfg(unix)]
#[test]
fn two_signals_at_once_are_one() {
    closed_by("-INT", 2);
    closed_by("-INT", 5);
}

#[cfg(unix)]
fn closed_by(signal: &str, times: usize) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("stopped.plain");
    let set = ["--set", "sink.0.kind=\"plain\"", "--set", "stream.policy=slip"];
    let config = calibration();
    let run = [&["run", &config, "--out", "stopped.plain"], &set[..]].concat();
    let mut child = started(folder.path(), &run);
    let begun = Instant::now();
    let index = out.join("pulse/index.bin");
    while !fs::metadata(&index).is_ok_and(|data| data.len() > 0) {
        assert!(begun.elapsed() < Duration::from_secs(20), "no pulse came");
        std::thread::sleep(Duration::from_millis(20));
    }
    let pause = format!("kill {signal} {}; sleep 0.003;", child.id());
    Command::new("sh").args(["-c", &pause.repeat(times)]).status().unwrap();
    let status = child.wait().unwrap();
    assert!(status.success(), "{status}");
    assert!(begun.elapsed() < Duration::from_secs(20));
    let pulses = fs::metadata(&index).unwrap().len() / 8;
    assert!(pulses > 0 && pulses < 2220, "{pulses}");
    assert!(out.join("meta.json").exists());
    let verified = nereus(folder.path(), &["verify", "stopped.plain"]);
    assert_eq!(verified.code, 0, "{}", verified.stdout);
    // Whole as far as it goes, and no more.
    let verified = nereus(folder.path(), &["verify", "stopped.plain", "--complete", "--json"]);
    assert_eq!(verified.code, 1, "{}", verified.stdout);
    let missing = 2220 - pulses;
    let said = format!("stopped.plain: not complete: {missing} of the 2220 pulses of the run are missing");
    assert!(verified.stderr.contains(&said), "{}", verified.stderr);
    assert_eq!(json(&verified.stdout)["missing"], missing);
}

#[cfg(feature = "hdf5")]
#[test]
fn shards_merge_to_the_whole_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = |pulses: &str, threads: &str, out: &str| {
        let threads = format!("stream.threads={threads}");
        let ended = nereus(
            folder.path(),
            &["run", &calibration(), "--pace", "fast", "--pulses", pulses, "--out", out, "--set", &threads],
        );
        assert_eq!(ended.code, 0, "{}", ended.stderr);
    };
    run("0..120", "2", "whole.h5");
    run("0..50", "2", "a.h5");
    run("50..120", "2", "b.h5");
    run("0..120", "1", "single.h5");
    let ended = nereus(folder.path(), &["merge", "b.h5", "a.h5", "--out", "joined.h5", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert_eq!(json(&ended.stdout)["pulses"], 120);
    for other in ["joined.h5", "single.h5"] {
        same_datasets(&folder.path().join("whole.h5"), &folder.path().join(other));
    }
}

/// An array of jobs: each element makes its shard, one fails and is run again.
#[cfg(feature = "hdf5")]
#[test]
fn an_array_of_jobs_makes_the_whole_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| {
        let scenario = ["run", &calibration(), "--pace", "fast", "--duration-s", "0.4"];
        nereus(folder.path(), &[&scenario, more].concat())
    };
    assert_eq!(run(&["--out", "whole.h5"]).code, 0);
    for (shard, out) in [("1/3", "1.h5"), ("3/3", "3.h5")] {
        let ended = run(&["--shard", shard, "--out", out]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
    }
    let join = || nereus(folder.path(), &["merge", "1.h5", "2.h5", "3.h5", "--out", "joined.h5"]);
    // What an element leaves that ended early.
    fs::copy(folder.path().join("1.h5"), folder.path().join("2.h5")).unwrap();
    let refused = join();
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("1 of 3 shards are missing: 2;"), "{}", refused.stderr);
    assert_eq!(run(&["--shard", "2/3", "--out", "2.h5", "--force"]).code, 0);
    let ended = join();
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    same_datasets(&folder.path().join("whole.h5"), &folder.path().join("joined.h5"));

    for (more, words) in [
        (&["--shard", "0/3"] as &[&str], "allowed: K/N, K from 1 to N, such as 3/16"),
        (&["--shard", "1/1000"], "--shard 1/1000: the run has 89 pulses; allowed: at most as many shards"),
        (&["--shard", "1/3", "--pulses", "0..5"], "cannot be used with"),
    ] {
        let refused = run(more);
        assert_eq!(refused.code, 2, "{}", refused.stderr);
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
    }
}

/// Every dataset of a group, by path, as raw bytes.
#[cfg(feature = "hdf5")]
fn same_datasets(a: &Path, b: &Path) {
    fn walk(group: &hdf5::Group, found: &mut Vec<String>) {
        found.extend(group.datasets().unwrap().iter().map(|dataset| dataset.name()));
        for group in group.groups().unwrap() {
            walk(&group, found);
        }
    }
    let (a, b) = (hdf5::File::open(a).unwrap(), hdf5::File::open(b).unwrap());
    let (mut names, mut others) = (Vec::new(), Vec::new());
    walk(&a, &mut names);
    walk(&b, &mut others);
    names.sort();
    others.sort();
    assert_eq!(names, others);
    assert!(names.iter().any(|name| name == "/iq"));
    for name in names {
        let (a, b) = (a.dataset(&name).unwrap(), b.dataset(&name).unwrap());
        assert_eq!(a.shape(), b.shape(), "{name}");
        if name == "/iq" {
            type C = num_complex::Complex<f32>;
            let bits =
                |v: Vec<C>| v.into_iter().map(|c| (c.re.to_bits(), c.im.to_bits())).collect::<Vec<_>>();
            assert!(bits(a.read_raw::<C>().unwrap()) == bits(b.read_raw::<C>().unwrap()), "{name}");
        } else {
            let same = [
                same_raw(&a, &b, f64::to_bits),
                same_raw::<i64, _>(&a, &b, |x| x),
                same_raw::<u64, _>(&a, &b, |x| x),
                same_raw::<u32, _>(&a, &b, |x| x),
                same_raw::<u8, _>(&a, &b, |x| x),
            ];
            match same.iter().flatten().next() {
                Some(same) => assert!(same, "{name}"),
                // Tables of names and the replica, which is the waveform's.
                None => assert!(
                    ["/channel", "/replica"].contains(&name.as_str()) || name.starts_with("/truth"),
                    "{name}"
                ),
            }
        }
    }
}

/// Whether two datasets hold the same values, if they are of this type.
#[cfg(feature = "hdf5")]
fn same_raw<T: hdf5::H5Type, B: PartialEq>(
    a: &hdf5::Dataset,
    b: &hdf5::Dataset,
    bits: fn(T) -> B,
) -> Option<bool> {
    let (a, b) = (a.read_raw::<T>().ok()?, b.read_raw::<T>().ok()?);
    Some(a.into_iter().map(bits).eq(b.into_iter().map(bits)))
}

#[test]
fn a_window_that_misses_every_target_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let coastal = package().join("configs/coastal.toml").display().to_string();
    let ended = nereus(folder.path(), &["check", &coastal, "--set", "radar.window.start_us=500"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("no target lies in the receive window"), "{}", ended.stderr);
    assert!(!nereus(folder.path(), &["check", &coastal]).stderr.contains("no target lies"));
}

/// A live recording is not overwritten by another run.
#[cfg(all(unix, feature = "hdf5"))]
#[test]
fn a_recording_under_way_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("live.h5");
    let run = ["run", &calibration(), "--duration-s", "3", "--out", "live.h5"];
    let mut child = started(folder.path(), &run);
    let begun = Instant::now();
    while !out.exists() {
        assert!(begun.elapsed() < Duration::from_secs(20), "no recording came");
        std::thread::sleep(Duration::from_millis(20));
    }
    let again = ["run", &calibration(), "--pulses", "0..5", "--pace", "fast", "--force", "--out", "live.h5"];
    let ended = nereus(folder.path(), &again);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("a run is writing it"), "{}", ended.stderr);
    assert!(child.wait().unwrap().success());
    let ended = nereus(folder.path(), &again);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

#[test]
fn tables_are_csv() {
    let folder = tempfile::tempdir().unwrap();
    let ended = nereus(
        folder.path(),
        &[
            "table",
            "antenna",
            "--width-m",
            "4",
            "--height-m",
            "0.05",
            "--carrier-hz",
            "1e10",
            "--step-deg",
            "1",
        ],
    );
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let rows: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(rows.len(), 12);
    assert_eq!(rows[0], "angle_deg,direction_cosine,gain_dbi,field_gain");
    assert!(rows[6].starts_with("0,0.000000000000e0,34.4"), "{}", rows[6]);
}

#[test]
fn the_library_example_runs() {
    // Built with all tests, and by tools/test before them.
    let binary = Path::new(env!("CARGO_BIN_EXE_nereus")).with_file_name("examples").join("scene_in_rust");
    if !binary.exists() {
        println!("skipped: {} was not built with these tests", binary.display());
        return;
    }
    let ended = Command::new(binary).output().unwrap();
    let text = String::from_utf8(ended.stdout).unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    assert!(text.lines().count() == 11 && text.contains("200 pulses, "), "{text}");
}

/// Classes are priced before the start, and every pulse is counted in one.
#[test]
fn a_run_may_relax_its_error() {
    let folder = tempfile::tempdir().unwrap();
    let quickstart = package().join("configs/quickstart.toml").display().to_string();
    let relax = ["--set", "stream.policy=relax"];
    let ended = nereus(folder.path(), &[&["check", &quickstart, "--json"][..], &relax].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let forecast = &json(&ended.stdout)["forecast"];
    let classes = forecast["coarser"].as_array().unwrap();
    assert!(!classes.is_empty(), "{forecast}");
    let mut slower = forecast["real_time_factor"].as_f64().unwrap();
    for class in classes {
        let [error_db, factor] = ["error_db", "real_time_factor"].map(|key| class[key].as_f64().unwrap());
        assert!(error_db > -60.0 && factor > slower, "{forecast}");
        slower = factor;
    }
    let run = ["run", &quickstart, "--pulses", "0..100", "--out", "x.plain", "--json"];
    let ended = nereus(folder.path(), &[&run[..], &relax].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let summary = json(&ended.stdout);
    let [released, dropped] = ["pulses", "dropped"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!(released + dropped, 100, "{summary}");
    assert!(ended.stderr.contains("at -60 dB"), "{}", ended.stderr);
}
