//! Reception without a gap: run, exported, and refused where a window for every pulse is taken.

use std::fs;

use serde_json::Value;

use crate::program::{nereus, package};

/// `configs/continuous.toml`, small.
const SMALL: [&str; 6] = [
    "--set",
    "scene.patch_size_m=[8,8]",
    "--set",
    "fidelity.echo=reference",
    "--set",
    "scene.duration_s=0.003",
];

#[test]
fn a_stream_is_recorded_exported_and_not_focused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let scenario = package().join("configs/continuous.toml").display().to_string();
    let (recording, sigmf) = (at("rec"), at("out"));
    let sink = format!("sink=[{{ kind = 'plain', path = '{recording}' }}]");
    let run = [&["run", &scenario, "--pace", "fast", "--set", &sink][..], &SMALL].concat();
    let ended = nereus(folder.path(), &run);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let meta: Value = serde_json::from_slice(&fs::read(at("rec/meta.json")).unwrap()).unwrap();
    let instrument: Value = serde_json::from_str(meta["instrument"].as_str().unwrap()).unwrap();
    assert_eq!((&instrument["continuous"], meta["prf_hz"].as_f64()), (&Value::Bool(true), Some(2000.0)));

    let ended = nereus(folder.path(), &["export", "sigmf", &recording, "--out", &sigmf, "--channel", "HH"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let meta: Value = serde_json::from_slice(&fs::read(at("out.sigmf-meta")).unwrap()).unwrap();
    assert_eq!(meta["captures"].as_array().unwrap().len(), 1);
    assert!(meta["global"]["core:description"].as_str().unwrap().starts_with("blocks without a gap"));
    // 6 blocks of 10,000 samples, 8 bytes each.
    assert_eq!(fs::metadata(at("out.sigmf-data")).unwrap().len(), 480_000);

    let crsd = at("rec.crsd");
    let crsd_run = [&["run", &scenario, "--pace", "fast", "--out", &crsd][..], &SMALL].concat();
    for (arguments, says) in [
        (vec!["focus", recording.as_str()], "received without a gap"),
        (vec!["export", "crsd", &recording, "--out", &crsd], "received without a gap"),
        (crsd_run, "received without a gap"),
        (vec!["speckle", scenario.as_str()], "radar.window.gate"),
    ] {
        let ended = nereus(folder.path(), &arguments);
        assert!(
            ended.code == 2 && ended.stderr.contains(says),
            "{arguments:?}: {} {}",
            ended.code,
            ended.stderr
        );
    }
}
