//! Targets whose radar cross section varies: the error that is predicted and the one that is measured, over
//! all pulses, and that a pulse depends on its number alone.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use crate::cases::sized;
use crate::runs::{holds, pulses};

const COASTAL: &str = "configs/coastal.toml";
const CASES: [&[(&str, &str)]; 4] = [
    &[("target.0.swerling", "1"), ("target.0.swerling_scan_s", "0.1")],
    &[("target.0.swerling", "2")],
    &[("target.0.swerling", "3"), ("target.0.swerling_scan_s", "0.03")],
    &[("target.0.swerling", "4"), ("target.1.swerling", "2")],
];

#[test]
fn targets_that_fluctuate_keep_the_error() {
    for settings in CASES {
        holds(COASTAL, settings, &[-60.0, -30.0]);
    }
}

#[test]
fn a_part_of_a_run_with_targets_that_fluctuate_is_bit_identical() {
    let whole = pulses(COASTAL, CASES[3], "2", 0..150);
    assert!(pulses(COASTAL, CASES[3], "1", 40..150) == whole[40..], "a part differs");
    assert!(pulses(COASTAL, &[], "2", 0..150) != whole, "nothing fluctuates");
}

/// A table of a plate of 2 m whose normal is the bow: lobes of 0.4 degrees.
fn plate(folder: &Path) -> String {
    let mut text = String::from("az_deg,el_deg,rcs_dbsm\n");
    for step in -1800..1800 {
        let azimuth_deg = f64::from(step) / 10.0;
        let x = TAU / 0.03 * 2.0 * azimuth_deg.to_radians().sin();
        let field = if x == 0.0 { 1.0 } else { x.sin() / x };
        let dbsm = 30.0 + (20.0 * field.abs().log10()).max(-300.0);
        [-90, 90].iter().for_each(|el| writeln!(text, "{azimuth_deg},{el},{dbsm}").unwrap());
    }
    let path = folder.join("plate.csv");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn targets_that_depend_on_the_aspect_keep_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = plate(folder.path());
    let one = format!(
        "{{ name = 'plate', position_m = [0, 0, 0], heading_deg = 90, rcs_csv = '{path}', swerling = 4 }}"
    );
    let two = "{ name = 'sphere', position_m = [60, 20, 0], velocity_mps = [3, 4, 0], rcs_dbsm = 10 }";
    let three = format!(
        "{{ name = 'boat', position_m = [-40, 10, 0], velocity_mps = [5, 0.1, 0], rcs_csv = '{path}' }}"
    );
    for targets in [format!("[{one}, {two}]"), format!("[{three}]")] {
        let settings = [("target", targets.as_str())];
        holds(COASTAL, &settings, &[-60.0, -30.0]);
        let whole = pulses(COASTAL, &settings, "2", 0..150);
        assert!(pulses(COASTAL, &settings, "1", 70..130) == whole[70..130], "a part differs");
    }
}

#[test]
fn a_target_that_floats_keeps_the_error() {
    let target = "[{ position_m = [0, 10, 2], velocity_mps = [0, 8, 0], rcs_dbsm = 50, floating = true, waterline_m = 2 }]";
    let settings = [
        ("scene.patch_size_m", sized("[64, 64]", "[32, 32]")),
        ("scene.duration_s", "0.25"),
        ("platform.0.track.position_m", "[-33, -3000, 3000]"),
        ("target", target),
    ];
    holds("configs/mars-1.toml", &settings, &[-60.0, -30.0]);
}

#[test]
fn a_target_over_a_sea_that_reflects_keeps_the_error() {
    // A mast of 15 m and an aircraft; the sea is rough for the aircraft's rays alone.
    let target = "[{ position_m = [0, 10, 3], velocity_mps = [0, 8, 0], rcs_dbsm = 40, floating = true, waterline_m = 2, multipath = true, swerling = 2 }]";
    let settings = [
        ("scene.patch_size_m", sized("[64, 64]", "[32, 32]")),
        ("scene.duration_s", "0.3"),
        ("platform.1.track.position_m", "[-33, -3000, 3000]"),
        ("target", target),
    ];
    holds("configs/mars-4.toml", &settings, &[-60.0, -30.0]);
}

#[test]
fn a_target_that_crests_hide_keeps_the_error() {
    // The transmitter stands 15 m above the sea, 3 km away.
    let target = "[{ position_m = [0, 10, 0.2], velocity_mps = [0, 8, 0], rcs_dbsm = 50, floating = true, waterline_m = 2 }]";
    let settings = [
        ("scene.patch_size_m", "[64, 64]"),
        ("scene.duration_s", "0.3"),
        ("platform.1.track.position_m", "[-33, -3000, 3000]"),
        ("target", target),
    ];
    holds("configs/mars-4.toml", &settings, &[-60.0]);
}
