//! `nereus ppi`: where targets are on the plan, and what is refused.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::nereus;

/// An antenna that turns once in 0.2 s among four points, the last of them beyond North; noise.
pub const SCENARIO: &str = r#"
[scene]
duration_s = 0.45
seed = 3
[radar]
carrier_hz = 9.41e9
sample_rate_hz = 25e6
prf_hz = 4000.0
channels = ["HH"]
noise_figure_db = 4.0
waveform = { kind = "lfm", bandwidth_hz = 20e6, pulse_s = 1e-6 }
window = { samples = 256, start_us = 2.0 }
[fidelity]
echo = "reference"
[[platform]]
name = "mast"
track = { kind = "fixed", position_m = [100.0, -200.0, 20.0] }
[[transmitter]]
name = "t"
platform = "mast"
power_w = 1000.0
antenna = { kind = "rectangle", width_m = 1.0, height_m = 0.05 }
pointing = { kind = "scan", rpm = 300.0, start_deg = 10.0, encoder_bits = 12 }
[[receiver]]
name = "r"
platform = "mast"
antenna = { kind = "rectangle", width_m = 1.0, height_m = 0.05 }
pointing = { kind = "scan", rpm = 300.0, start_deg = 10.0, encoder_bits = 12 }
[[target]]
name = "a"
position_m = [700.0, 300.0, 5.0]
rcs_m2 = 100.0
[[target]]
name = "b"
position_m = [-600.0, -400.0, 5.0]
rcs_m2 = 100.0
[[target]]
name = "c"
position_m = [200.0, -1100.0, 5.0]
rcs_m2 = 100.0
[[target]]
name = "d"
position_m = [99.0, 800.0, 5.0]
rcs_m2 = 100.0
[[sink]]
kind = "plain"
path = "r.plain"
"#;

/// East, North and up of the targets from the mast.
pub const TARGETS: [[f64; 3]; 4] =
    [[600.0, 500.0, -15.0], [-700.0, -200.0, -15.0], [100.0, -900.0, -15.0], [-1.0, 1000.0, -15.0]];

fn recorded(folder: &Path, out: &str, settings: &[&str]) {
    fs::write(folder.join("s.toml"), SCENARIO).unwrap();
    let mut arguments = vec!["run", "s.toml", "--pace", "fast", "--out", out];
    settings.iter().for_each(|setting| arguments.extend(["--set", *setting]));
    let ended = nereus(folder, &arguments);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

fn report(folder: &Path, arguments: &[&str]) -> Value {
    let ended = nereus(folder, &[&["ppi"], arguments, &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    serde_json::from_str(ended.stdout.trim()).unwrap()
}

/// Targets have strongest cells at their ranges, within a cell, and bearings, within half a beam and a step
/// of the encoder; bearings count from `zero_deg`.
fn check_targets(report: &Value, targets: &[[f64; 3]], zero_deg: f64) {
    let of = |value: &Value, key: &str| value[key].as_f64().unwrap();
    let (cell_m, beam_deg) = (of(report, "range_cell_m"), of(report, "bearing_resolution_deg"));
    let cells = report["strongest"].as_array().unwrap();
    assert!(cells.len() >= targets.len(), "{report}");
    for [x, y, z] in targets {
        let (range_m, bearing_deg) = ((x * x + y * y + z * z).sqrt(), x.atan2(*y).to_degrees() - zero_deg);
        let is_there = |cell: &Value| {
            let away = (of(cell, "bearing_deg") - bearing_deg + 180.0).rem_euclid(360.0) - 180.0;
            (of(cell, "range_m") - range_m).abs() <= cell_m && away.abs() <= 0.5 * beam_deg + 360.0 / 4096.0
        };
        assert!(cells[..targets.len()].iter().any(is_there), "{range_m} m {bearing_deg}: {report}");
    }
}

#[test]
fn targets_appear_where_they_are_whichever_way_the_antenna_turns() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    recorded(folder, "r.plain", &[]);
    let found = report(folder, &["r.plain", "--truth", "--strongest", "4"]);
    check_targets(&found, &TARGETS, 0.0);
    assert!(fs::read(folder.join("r_ppi.png")).unwrap().starts_with(b"\x89PNG"));
    let scans = found["scans"].as_array().unwrap();
    let whole: Vec<bool> = scans.iter().map(|scan| scan["whole"].as_bool().unwrap()).collect();
    assert_eq!((whole, &found["scan"]), (vec![true, true, false], &1.into()));
    assert!((found["period_s"].as_f64().unwrap() - 0.2).abs() < 5e-4, "{found}");
    // Two apertures of 1 m: 0.886 lambda / D / sqrt 2.
    let beam_deg = (0.886 * 0.031_859 / 2f64.sqrt()).to_degrees();
    assert!((found["bearing_resolution_deg"].as_f64().unwrap() - beam_deg).abs() < 1e-3);
    // The truth record agrees with the strongest cells.
    let targets = found["targets"].as_array().unwrap();
    assert_eq!(targets.iter().map(|t| t["name"].as_str().unwrap()).collect::<Vec<_>>(), ["a", "b", "c", "d"]);
    assert!(targets.iter().all(|target| target["level_dbw"].as_f64().unwrap() > -95.0), "{found}");
    // Two whole turns become two pictures.
    report(folder, &["r.plain", "--scans", "--out", "all.png"]);
    let all = fs::read(folder.join("all.png")).unwrap();
    let at = all.windows(4).position(|word| word == b"acTL").unwrap();
    assert_eq!(all[at + 4..at + 8], [0, 0, 0, 2]);
    // The other way round.
    let back = ["transmitter.0.pointing.rpm=-300", "receiver.0.pointing.rpm=-300"];
    recorded(folder, "back.plain", &back);
    let found = report(folder, &["back.plain", "--strongest", "4"]);
    assert_eq!(found["scans"][0]["clockwise"], false);
    check_targets(&found, &TARGETS, 0.0);
}

#[test]
fn bearings_count_from_the_nose_or_from_north_and_sectors_go_to_and_fro() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // 160 degrees in 0.16 s about the nose, which is 30 degrees to the right of North: two targets are seen.
    let sector = "{ kind = 'sector', from_deg = -80.0, to_deg = 80.0, rate_degps = 1000.0, turn_ms = 20.0, encoder_bits = 12 }";
    let [sends, takes] = ["transmitter", "receiver"].map(|end| format!("{end}.0.pointing={sector}"));
    let nose = "platform.0.track.yaw_deg=30";
    recorded(folder, "r.plain", &[&sends, &takes, nose]);
    let seen = [TARGETS[0], TARGETS[3]];
    for (scan, clockwise) in [("0", true), ("1", false)] {
        let found = report(folder, &["r.plain", "--scan", scan, "--force", "--strongest", "2"]);
        assert_eq!(found["scans"][scan.parse::<usize>().unwrap()]["clockwise"], clockwise);
        check_targets(&found, &seen, 0.0);
        let ahead = report(folder, &["r.plain", "--scan", scan, "--head-up", "--force", "--strongest", "2"]);
        check_targets(&ahead, &seen, 30.0);
        assert_eq!(ahead["targets"].as_array().unwrap().len(), 2, "{ahead}");
    }
}

#[test]
fn what_is_no_plan_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let short = "scene.duration_s=0.004";
    recorded(folder, "r.plain", &[short]);
    recorded(folder, "still.plain", &[short, "receiver.0.pointing={ kind = 'fixed' }"]);
    let other = "platform=[{ name = 'mast', track = { kind = 'fixed', position_m = [0, 0, 20] } }, \
                 { name = 'quay', track = { kind = 'fixed', position_m = [50, 0, 20] } }]";
    recorded(folder, "two.plain", &[short, other, "receiver.0.platform=quay"]);
    for (arguments, words) in [
        (&["nothing.h5"][..], "nothing.h5"),
        (&["still.plain"], "receiver r does not scan; allowed: channels whose receiver has pointing.kind"),
        (&["two.plain"], "transmitter on mast, receiver on quay; allowed: channels whose transmitter and"),
        (&["r.plain", "--channel", "VV"], "channel VV is no channel of echoes of the recording; allowed: HH"),
        (&["r.plain", "--scan", "1"], "scan 1 is not in the recording; allowed: 0 to 0"),
        (&["r.plain", "--range-m", "200"], "a range of 200 m; allowed: above 299.8 m"),
        (&["r.plain", "--db", "-60", "-90"], "--db -60 -90: allowed: two numbers"),
        (&["r.plain", "--beam-deg", "0"], "a beam of 0 degrees"),
        (&["r.plain", "--out", "a.jpg"], "--out a.jpg: allowed: a name that ends in .png"),
    ] {
        let ended = nereus(folder, &[&["ppi"], arguments].concat());
        assert!(ended.code == 2 && ended.stderr.contains(words), "{arguments:?}: {}", ended.stderr);
    }
    // A part of a turn is shown where there is nothing else.
    let ended = nereus(folder, &["ppi", "r.plain"]);
    assert!(ended.code == 0 && ended.stderr.contains("no whole scan"), "{}", ended.stderr);
    let ended = nereus(folder, &["ppi", "r.plain"]);
    assert!(ended.code == 2 && ended.stderr.contains("--force"), "{}", ended.stderr);
}
