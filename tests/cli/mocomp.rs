//! `nereus focus --nav both`, on scenarios of known errors.

use std::fs;

use crate::program::{nereus, package};

/// Records a few pulses of `configs/mocomp-NAME.toml`.
fn recorded(folder: &std::path::Path, name: &str, out: &str, settings: &[&str]) {
    let scenario = package().join(format!("configs/mocomp-{name}.toml"));
    let run = ["run", scenario.to_str().unwrap(), "--pace", "fast", "--pulses", "280..320", "--out", out];
    let ended = nereus(folder, &[&run[..], settings].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

const BOTH: [&str; 8] = ["--nav", "both", "--centre-m", "0,0", "--size-m", "8", "--pixel-m", "0.5"];

#[test]
fn a_table_sets_prediction_beside_measurement() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), "ramp", "r.plain", &[]);
    let out = ["--out", "i.png", "--cuts", "c.png"];
    let ended = nereus(folder.path(), &[&["focus", "r.plain"], &BOTH[..], &out].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for words in [
        "predicted",
        "measured",
        "path error: constant",
        "scenario  ramp of +0.0707 m/s of path",
        "pixels of 0.5 m",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    for picture in ["i_VV_true.png", "i_VV_reported.png", "c.png"] {
        assert!(fs::read(folder.path().join(picture)).unwrap().starts_with(b"\x89PNG"), "{picture}");
    }
    let ended = nereus(folder.path(), &[&["focus", "r.plain", "--json"], &BOTH[..]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let target = &report["channels"][0]["targets"][0];
    let of = |kind: &str, axis: usize| target[kind]["shift_cells"][axis].as_f64().unwrap();
    // 2 x 50 mm/s cos 45 for 40 pulses of 1/300 s over 29.98 mm: -0.3145 cells (cross-range counts against
    // the flight); and 0.1 m along the track, gained up to the middle of the run, over cells of lambda R/(2
    // L) = 4.77 m.
    let length_m = 100.0 * 40.0 / 300.0;
    let law = -0.05 * 2f64.sqrt() * 40.0 / 300.0 / 0.029_979_245_8
        - 0.1 * 299.5 / 300.0 * 2.0 * length_m / (0.029_979_245_8 * 3000.0 * 2f64.sqrt());
    assert!((of("predicted", 1) - law).abs() < 2e-3, "{law} {target}");
    for axis in 0..2 {
        assert!((of("predicted", axis) - of("measured", axis)).abs() < 0.02, "{target}");
    }
    let loss = |kind: &str| target[kind]["loss_db"].as_f64().unwrap();
    assert!((loss("predicted") - loss("measured")).abs() < 0.1, "{target}");
    let closed = target["laws"][0]["cross_range_cells"].as_f64().unwrap();
    assert!((closed - law).abs() < 1e-3 && target["laws"][0]["kind"] == "ramp", "{target}");
    let pixels = &report["channels"][0]["pixels"];
    assert!(pixels["count"].is_u64(), "{pixels}");
}

#[test]
fn gain_that_an_aim_costs_is_reported_against_a_recording_without_it() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), "misaim", "m.plain", &[]);
    let right =
        ["--set", "transmitter.0.pointing.bias_az_deg=0", "--set", "receiver.0.pointing.bias_az_deg=0"];
    recorded(folder.path(), "misaim", "n.plain", &right);
    let words = ["focus", "m.plain", "--json", "--against", "n.plain", "--doppler-hz", "all"];
    let ended = nereus(folder.path(), &[&words[..], &BOTH[..]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let target = &report["channels"][0]["targets"][0];
    // A uniformly illuminated width of 0.3 m at both ends, 2 degrees off.
    let x = std::f64::consts::PI * 0.3 * 2f64.to_radians().sin() / 0.029_979_245_8;
    let law = -40.0 * (x.sin() / x).log10();
    let of = |value: &serde_json::Value| value.as_f64().unwrap();
    println!("{law:.4} dB, {target}");
    assert!((of(&target["aim_loss_db"]) - law).abs() < 1e-3, "{law} {target}");
    assert!((of(&target["predicted"]["loss_db"]) - law).abs() < 2e-3, "{law} {target}");
    assert!((of(&target["measured"]["loss_db"]) - law).abs() < 0.02, "{law} {target}");
    // Without another recording there is nothing to see: reports are right.
    let ended =
        nereus(folder.path(), &[&["focus", "m.plain", "--json", "--doppler-hz", "all"], &BOTH[..]].concat());
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let target = &report["channels"][0]["targets"][0];
    assert!(target["aim_loss_db"].is_null() && of(&target["measured"]["loss_db"]).abs() < 1e-6, "{target}");
}

#[test]
fn what_is_wrong_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), "step", "s.plain", &[]);
    recorded(folder.path(), "step", "t.plain", &["--set", "radar.carrier_hz=9e9"]);
    for (arguments, words) in [
        (&["--cuts", "c.png"][..], "--cuts c.png: allowed: with --nav both only"),
        (&["--against", "t.plain"], "with --nav both only"),
        (&["--nav", "both", "--against", "t.plain"], "--against t.plain: its carrier_hz differ"),
        (&["--nav", "both", "--against", "u.plain"], "u.plain"),
        (&["--nav", "neither"], "possible values: true, reported, both"),
    ] {
        let ended = nereus(folder.path(), &[&["focus", "s.plain", "--size-m", "8"], arguments].concat());
        assert!(ended.code == 2 && ended.stderr.contains(words), "{arguments:?}: {}", ended.stderr);
    }
    // One pulse has no cross-range: reported, not refused.
    let one = ["focus", "s.plain", "--pulses", "290..291"];
    let ended = nereus(folder.path(), &[&one[..], &BOTH[..]].concat());
    assert!(ended.code == 0 && ended.stdout.contains("no cross-range"), "{}{}", ended.stdout, ended.stderr);
}

#[test]
fn figures_of_the_page_are_those_of_its_file() {
    let page = fs::read_to_string(package().join("docs/mocomp.md")).unwrap();
    // Every scenario has rows, and prediction and measurement agree as the page says.
    let table = fs::read_to_string(package().join("docs/mocomp.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    for entry in fs::read_dir(package().join("configs")).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        if let Some(name) = name.strip_prefix("mocomp-").and_then(|name| name.strip_suffix(".toml")) {
            assert!(
                rows.iter().any(|row| row[0] == name) && page.contains(&format!("`mocomp-{name}`")),
                "{name}"
            );
        }
    }
    for both in rows.chunks_exact(2) {
        let number = |row: usize, column: usize| both[row][column].parse::<f64>().unwrap();
        assert_eq!((both[0][2], both[1][2], both[0][1]), ("predicted", "measured", both[1][1]));
        // In a sea 36 dB below a point its amplitude moves by up to 0.3 dB.
        let loss_db = if both[0][0] == "gauss-markov" { 0.3 } else { 0.1 };
        assert!((number(0, 3) - number(1, 3)).abs() < loss_db, "{both:?}");
        assert!(
            (number(0, 4) - number(1, 4)).abs() < 0.02 && (number(0, 6) - number(1, 6)).abs() < 0.02,
            "{both:?}"
        );
    }
}
