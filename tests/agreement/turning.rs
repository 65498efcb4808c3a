//! Targets and ships on tracks: the fast echo against the reference over all pulses, and that a track that
//! leads straight on is a straight course.

use std::fmt::Write as _;
use std::path::Path;

use nereus::pulse::{Pulse, Samples};

use crate::runs::{holds, pulses};

const COASTAL: &str = "configs/coastal.toml";
const MARS: &str = "configs/mars-1.toml";

/// A boat and a buoy that turn, one of them within the run, and one whose echo depends on its heading.
const TARGETS: &str = "[\
    { name = 'boat', rcs_dbsm = 20, height_m = 2, track = { kind = 'waypoints', waypoints_m = [[-200, 0], \
      [0, 0], [100, 200]], speed_mps = 15, turn_radius_m = 40, begin_s = -12.5 } }, \
    { name = 'slow', rcs_dbsm = 10, track = { kind = 'waypoints', waypoints_m = [[60, -40], [60, 40], \
      [-60, 40], [-60, -40]], speed_mps = 4, turn_radius_m = 20, begin_s = -10 } }]";

#[test]
fn turning_targets_keep_the_error() {
    holds(COASTAL, &[("target", TARGETS)], &[-60.0, -30.0]);
}

#[test]
fn a_part_of_a_run_with_turning_targets_is_bit_identical() {
    let settings = [("target", TARGETS)];
    let whole = pulses(COASTAL, &settings, "2", 0..150);
    assert!(pulses(COASTAL, &settings, "1", 40..150) == whole[40..], "a part differs");
}

/// The ship of MaRS, 40 m long, half-way through a turn of 80 m radius on a small patch: its panels, its
/// waves and the water that it stirs.
const SHIP: [(&str, &str); 4] = [
    ("scene.patch_size_m", "[48, 48]"),
    ("scene.duration_s", "0.25"),
    ("sea.shadow.mode", "\"soft\""),
    (
        "ship",
        "[{ hull = '../hulls/dtmb5415.toml', length_m = 40, echo = true, panel_m = 1.2, track = { \
           kind = 'waypoints', waypoints_m = [[-300, -5], [20, -5], [20, 300]], speed_mps = 5, \
           turn_radius_m = 80, begin_s = -60 } }]",
    ),
];

#[test]
fn a_turning_ship_keeps_the_error() {
    holds(MARS, &[SHIP[0], SHIP[1], SHIP[3]], &[-60.0, -30.0]);
}

#[test]
fn a_part_of_a_run_with_a_turning_ship_is_bit_identical() {
    let settings = [SHIP[0], SHIP[1], SHIP[3]];
    let whole = pulses(MARS, &settings, "2", 0..40);
    assert!(pulses(MARS, &settings, "1", 25..40) == whole[25..], "a part differs");
}

/// A recording of something that moves straight on at constant velocity, a row a second.
fn recorded(folder: &Path, from: [f64; 2], velocity_mps: [f64; 2]) -> String {
    let mut text = String::from("time_utc,x_m,y_m,z_m\n");
    for second in 0..120 {
        let time_s = f64::from(second) - 60.0;
        let at = [0, 1].map(|i| from[i] + velocity_mps[i] * time_s);
        let (minute, second) = if second < 60 { (59, second) } else { (0, second - 60) };
        let hour = if minute == 59 { 11 } else { 12 };
        writeln!(text, "2024-05-01T{hour}:{minute:02}:{second:02}Z,{},{},0", at[0], at[1]).unwrap();
        let _ = minute;
    }
    let path = folder.join("straight.csv");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

fn apart_db(a: &[Pulse], b: &[Pulse]) -> f64 {
    let samples = |pulse: &Pulse| match &pulse.samples {
        Samples::Cf32(samples) => samples.clone(),
        Samples::Ci16(_) => panic!("no converter here"),
    };
    let (mut apart, mut whole) = (0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        for (x, y) in samples(a).iter().zip(samples(b)) {
            apart += f64::from((x - y).norm_sqr());
            whole += f64::from(x.norm_sqr());
        }
    }
    10.0 * (apart / whole).log10()
}

/// Positions of the recording are rounded to 1e-13 m by the knots, and differ by as much along the way: 4e-11
/// of a wave of 3 cm. The wake's phases are as good. What is left is the rounding of f32 samples.
#[test]
fn a_straight_track_is_a_straight_course() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path(), [5.0, -4.0], [4.0, 3.0]);
    let track = format!("track = {{ kind = 'csv', path = '{path}' }}");
    let hull = "hull = '../hulls/dtmb5415.toml', length_m = 40, echo = true, panel_m = 1.2";
    let straight = "position_m = [5, -4], towards_deg = 36.86989764584402, speed_mps = 5";
    for echo in ["reference", "fast"] {
        let common = [
            ("scene.patch_size_m", "[48, 48]"),
            ("scene.duration_s", "0.05"),
            ("scene.start_utc", "\"2024-05-01T12:00:00Z\""),
            ("fidelity.echo", &*format!("\"{echo}\"")),
        ];
        let of = |ship: &str| {
            let ship = format!("[{{ {hull}, {ship} }}]");
            pulses(MARS, &[&common[..], &[("ship", &ship)]].concat(), "1", 0..8)
        };
        let found_db = apart_db(&of(straight), &of(&track));
        println!("{echo}: {found_db:.1} dB apart");
        // The fast echo takes its settings for something that may turn.
        assert!(found_db < if echo == "reference" { -120.0 } else { -57.0 }, "{echo}: {found_db}");
    }
    let target = |how: &str| format!("[{{ rcs_dbsm = 20, {how} }}]");
    let common = [("scene.start_utc", "\"2024-05-01T12:00:00Z\""), ("fidelity.echo", "\"reference\"")];
    let of = |how: &str| pulses(COASTAL, &[&common[..], &[("target", &target(how))]].concat(), "1", 0..8);
    let found_db = apart_db(&of("position_m = [5, -4, 0], velocity_mps = [4, 3, 0]"), &of(&track));
    println!("target: {found_db:.1} dB apart");
    assert!(found_db < -120.0, "{found_db}");
}
