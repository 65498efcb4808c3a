//! `tools/baseline.py`, `tools/steady.py` and `tools/passive.py`, on small recordings.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::{nereus, package};

/// A tool under python3; `None`, and a line that says so, where python3 or a module is missing.
fn tool(name: &str, modules: &str, arguments: &[&str], folder: &Path) -> Option<Output> {
    let can = Command::new("python3").args(["-c", &format!("import {modules}")]).output();
    if !can.is_ok_and(|ended| ended.status.success()) {
        println!("skipped: no python3 with {modules}");
        return None;
    }
    let mut command = Command::new("python3");
    // Loops of so few scatterer paths are faster interpreted than compiled. Modules of the folder go first.
    command.env("NUMBA_DISABLE_JIT", "1").env("PYTHONPATH", folder).env("PYTHONDONTWRITEBYTECODE", "1");
    Some(
        command.arg(package().join("tools").join(name)).args(arguments).current_dir(folder).output().unwrap(),
    )
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[cfg(feature = "hdf5")]
#[test]
fn baseline_agrees_with_the_recording_and_is_timed() {
    let folder = tempfile::tempdir().unwrap();
    let sea = package().join("configs/sea.toml").display().to_string();
    // The beam passes over the patch in the middle of the run.
    let small = ["--config", &sea, "--set", "scene.patch_size_m=[16, 16]", "--pulse", "55", "--nereus"];
    let few = [env!("CARGO_BIN_EXE_nereus"), "--counts", "50,all", "--repeats", "1", "--json"];
    let arguments = [&small[..], &few].concat();
    let modules = "numpy, h5py, tomllib";
    let Some(ended) = tool("baseline.py", modules, &arguments, folder.path()) else { return };
    let printed = text(&ended.stdout);
    assert!(ended.status.success(), "{printed}{}", text(&ended.stderr));
    let report: serde_json::Value = serde_json::from_str(printed.trim()).unwrap();
    // 256 facets, a buoy, and a wave or two that break.
    assert!(report["paths"].as_u64().is_some_and(|paths| (257..=260).contains(&paths)), "{report}");
    let error = |way: &str, of: &str| report["error_db"][way][of].as_f64();
    // What the receive filter takes from one chirp of 60 MHz is -20.3 dB of it. Here the echoes of a few
    // resolution cells of random phase add up, so that the share scatters from pulse to pulse: 6 dB are left
    // to it.
    for way in ["numpy chirp", "numba chirp"] {
        for of in ["recorded", "reference"] {
            assert!(error(way, of).is_none_or(|db| (-26.3..-14.3).contains(&db)), "{way} {of}: {report}");
        }
    }
    assert!(error("numpy chirp", "reference").is_some());
    // Eight times the rate leaves the images beyond 750 MHz: the spectrum of a cut chirp falls as 1/f, which
    // is -41 dB.
    assert!(error("numba chirp x8", "reference").is_none_or(|db| db < -35.0), "{report}");
    // Five cells leave -90 dB, Doppler by a shift less than -80 dB in this scene.
    assert!(error("numba grid", "reference").is_none_or(|db| db < -75.0), "{report}");
    for count in ["50", &report["paths"].to_string()] {
        assert!(report["seconds"][count]["numpy chirp"].as_f64().unwrap() > 0.0);
        assert!(report["nereus"][count]["seconds"].as_f64().unwrap() > 0.0);
    }

    // Without numba what is left is reported.
    fs::write(folder.path().join("numba.py"), "raise ImportError('none')").unwrap();
    let bare = [&arguments[..arguments.len() - 1], &["--no-bench"]].concat();
    let ended = tool("baseline.py", modules, &bare, folder.path()).unwrap();
    let printed = text(&ended.stdout);
    assert!(
        ended.status.success() && printed.contains("numba is absent") && !printed.contains("numba grid"),
        "{printed}"
    );
}

#[test]
fn steady_distinguishes_a_recording_that_changes_from_one_that_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = package().join("configs/calibration.toml").display().to_string();
    let set = "sink.0.kind=\"plain\"";
    let run = ["run", &calibration, "--pace", "fast", "--pulses", "0..400", "--set", set, "--out", "r.plain"];
    let ended = nereus(folder.path(), &run);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let judged = || tool("steady.py", "numpy", &["r.plain", "--limit-db", "0.5", "--json"], folder.path());
    let Some(ended) = judged() else { return };
    let printed = text(&ended.stdout);
    assert!(ended.status.success(), "{printed}{}", text(&ended.stderr));
    let report: serde_json::Value = serde_json::from_str(printed.trim()).unwrap();
    assert_eq!(
        (&report["pulses"], &report["compared"], &report["missing"]),
        (&400.into(), &200.into(), &0.into())
    );
    for channel in report["channels"].as_array().unwrap() {
        // Noise of 3 dB over 87.5 MHz: k T0 B F = -204.0 + 79.4 + 3.0 dBW, and the targets' echo, some 1 % of
        // it.
        let power_dbw = channel["first_dbw"].as_f64().unwrap();
        assert!((power_dbw + 121.55).abs() < 0.1, "{channel}");
        // Thermal noise: 2, and its deviation is sqrt(20/N) of 200 x 512 samples.
        assert!((channel["kurtosis"][0].as_f64().unwrap() - 2.0).abs() < 0.06, "{channel}");
    }

    // The second half twice as strong.
    let file = folder.path().join("r.plain/iq.bin");
    let mut bytes = fs::read(&file).unwrap();
    let from = bytes.len() / 2;
    for sample in bytes[from..].chunks_exact_mut(4) {
        let value = f32::from_le_bytes(sample.try_into().unwrap());
        sample.copy_from_slice(&(2.0 * value).to_le_bytes());
    }
    fs::write(&file, &bytes).unwrap();
    assert_eq!(judged().unwrap().status.code(), Some(1));
    // One sample that is none, in the middle, judged without a limit.
    fs::write(&file, {
        let middle = bytes.len() / 2 / 4 * 4;
        bytes[middle..middle + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        &bytes
    })
    .unwrap();
    let ended = tool("steady.py", "numpy", &["r.plain", "--json"], folder.path()).unwrap();
    let report: serde_json::Value = serde_json::from_str(text(&ended.stdout).trim()).unwrap();
    assert_eq!((ended.status.code(), &report["not_finite"]), (Some(1), &1.into()), "{report}");
}

/// Heights of the scenario, deflated: other versions of zlib may pack them otherwise, but the header is the
/// same.
#[test]
fn the_headland_is_made_by_its_tool() {
    let folder = tempfile::tempdir().unwrap();
    let Some(ended) = tool("headland.py", "zlib", &["coast.tif"], folder.path()) else { return };
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let heights = |path: &Path| {
        let mut decoder = tiff::decoder::Decoder::new(fs::File::open(path).unwrap()).unwrap();
        assert_eq!(decoder.dimensions().unwrap(), (180, 180));
        let tiff::decoder::DecodingResult::F32(heights_m) = decoder.read_image().unwrap() else {
            panic!("other heights");
        };
        heights_m
    };
    let [made, kept] = [folder.path().join("coast.tif"), package().join("configs/coast.tif")];
    assert!(heights(&made) == heights(&kept));
    // Hills of 46 to 70 m that overlap.
    let top_m = heights(&kept).into_iter().fold(0f32, f32::max);
    assert!((90.0..110.0).contains(&top_m), "{top_m}");
}

/// Both boats of the passive radar are where they are, to a tenth of a cell of delay and of Doppler, with the
/// direct path far above them.
#[cfg(feature = "hdf5")]
#[test]
fn a_passive_radar_finds_its_targets() {
    let folder = tempfile::tempdir().unwrap();
    let config = package().join("configs/passive.toml").display().to_string();
    let small = ["--set", "scene.patch_size_m=[32, 32]", "--pace", "fast"];
    let ended = nereus(folder.path(), &[&["run", &config][..], &small].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let Some(ended) = tool("passive.py", "numpy, h5py", &["passive.h5"], folder.path()) else { return };
    let printed = text(&ended.stdout);
    assert!(ended.status.success(), "{printed}{}", text(&ended.stderr));
    for name in ["launch", "ferry"] {
        let line = printed.lines().find(|line| line.starts_with(name)).unwrap();
        let off = line.split_once("off by ").unwrap().1.trim_end_matches(" cells");
        let off: Vec<f64> = off.split(" and ").map(|cells| cells.parse().unwrap()).collect();
        assert!(off.len() == 2 && off.iter().all(|cells| *cells < 0.1), "{printed}");
    }
}
