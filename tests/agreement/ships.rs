//! Ships that echo by their mesh: the fast echo against the reference, over all pulses.

use std::path::Path;

use crate::cases::some_of;
use crate::runs::{holds, pulses};

const MARS: &str = "configs/mars-1.toml";
/// The hull of MaRS, DTMB 5415, 40 m long and of some 2000 panels, on a small patch.
const SHIP: [(&str, &str); 5] = [
    ("scene.patch_size_m", "[32, 32]"),
    ("scene.duration_s", "0.25"),
    ("ship.0.length_m", "40"),
    ("ship.0.panel_m", "1.2"),
    ("ship.0.echo", "true"),
];

#[test]
fn a_ship_of_panels_keeps_the_error() {
    holds(MARS, &SHIP, &[-60.0, -30.0]);
}

/// The same of a boat that heaves, pitches and rolls on a fresh sea.
const RIDING: [(&str, &str); 8] = [
    ("scene.patch_size_m", "[32, 32]"),
    ("scene.duration_s", "0.2"),
    ("sea.wind_ustar_mps", "0.5"),
    ("ship.0.length_m", "14"),
    ("ship.0.panel_m", "0.8"),
    ("ship.0.echo", "true"),
    ("ship.0.motion", "\"waves\""),
    ("ship.0.roll_period_s", "3"),
];

#[test]
fn a_ship_that_rides_the_waves_keeps_the_error() {
    holds(MARS, &RIDING, &[-60.0, -30.0]);
}

#[test]
fn a_part_of_a_run_with_a_ship_that_rides_is_bit_identical() {
    let whole = pulses(MARS, &RIDING, "2", 0..40);
    assert!(pulses(MARS, &RIDING, "1", 25..40) == whole[25..], "a part differs");
    assert!(pulses(MARS, &RIDING[..6], "2", 0..40) != whole, "the ship does not move");
}

#[test]
fn a_part_of_a_run_with_a_ship_is_bit_identical() {
    let whole = pulses(MARS, &SHIP, "2", 0..40);
    assert!(pulses(MARS, &SHIP, "1", 25..40) == whole[25..], "a part differs");
    assert!(pulses(MARS, &SHIP[..3], "2", 0..40) != whole, "the ship does not echo");
}

/// Every hull of the package runs and echoes by its mesh; with few cases the first of them.
#[test]
fn every_hull_echoes() {
    let mut hulls: Vec<_> = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("hulls"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ends| ends == "toml" || ends == "csv"))
        .collect();
    hulls.sort();
    assert!(hulls.len() >= 8, "{hulls:?}");
    for hull in some_of(hulls) {
        let hull = format!("\"{}\"", hull.display());
        let of = |echo: &str| {
            let ship = [
                ("scene.patch_size_m", "[16, 16]"),
                ("scene.duration_s", "0.1"),
                ("ship.0.hull", &*hull),
                ("ship.0.length_m", "20"),
                ("ship.0.heading_deg", "20"),
                ("ship.0.echo", echo),
            ];
            let more = if echo == "true" { &[("ship.0.panel_m", "2")][..] } else { &[] };
            pulses(MARS, &[&ship[..], more].concat(), "1", 3..4)
        };
        let (with, without) = (of("true"), of("false"));
        assert!(with[0].samples != without[0].samples, "{hull} does not echo");
    }
}
