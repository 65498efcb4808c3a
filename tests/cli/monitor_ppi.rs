//! The plan position panel of the live page, as a browser gets it.

use std::fs;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::monitor_client::{Browser, Message, Radial, served, shown, shown_of};
use crate::ppi::{SCENARIO, TARGETS};
use crate::program::{nereus, started};

const HALF_C_MPS: f64 = 299_792_458.0 / 2.0;

/// A turn a second, 0.36 degrees a pulse; machines that are too slow for it stretch time.
const SLOW: [&str; 12] = [
    "--set",
    "scene.duration_s=60",
    "--set",
    "radar.prf_hz=1000",
    "--set",
    "transmitter.0.pointing.rpm=60",
    "--set",
    "receiver.0.pointing.rpm=60",
    "--set",
    "stream.policy=\"slip\"",
    "--set",
    "sink=[{kind=\"null\"}]",
];

fn away_deg(a: f64, b: f64) -> f64 {
    ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs()
}

/// Radials until there are some within a degree of every bearing.
fn turn(browser: &mut Browser) -> Vec<Radial> {
    browser.send(r#"{"ppi":true}"#);
    let mut all: Vec<Radial> = Vec::new();
    browser.until(|message| {
        let Message::Radials(radials) = message else { return None };
        all.extend(radials.iter().cloned());
        let is_seen = |deg: usize| all.iter().any(|radial| away_deg(radial.azimuth_deg, deg as f64) <= 1.0);
        (0..360).all(is_seen).then_some(())
    });
    all
}

/// Range, bearing and level of the strongest cell within five degrees of a bearing.
fn strongest(radials: &[Radial], bearing_deg: f64) -> [f64; 3] {
    let near = radials.iter().filter(|radial| away_deg(radial.azimuth_deg, bearing_deg) < 5.0);
    let cells = near.flat_map(|radial| {
        radial.levels_dbw.iter().enumerate().filter_map(|(cell, level)| {
            let range_m = HALF_C_MPS * (radial.start_s + (cell as f64 + 0.5) * radial.step_s);
            Some([range_m, radial.azimuth_deg, (*level)?])
        })
    });
    cells.max_by(|a, b| a[2].total_cmp(&b[2])).unwrap()
}

/// Every target stands at its range, within a cell, and at its bearing, within a third of the beam; half of
/// that is how far apart radials are, the rest is the encoder, of 12 bits, and noise.
fn check(radials: &[Radial], about: &Value, what: &str) {
    let beam_deg = about["ppi"]["beam_deg"].as_f64().unwrap();
    let cell_m = HALF_C_MPS * radials[0].step_s;
    for [east, north, up] in TARGETS {
        let (range_m, bearing_deg) = (east.hypot(north).hypot(up), east.atan2(north).to_degrees());
        let [found_m, found_deg, level_dbw] = strongest(radials, bearing_deg);
        println!(
            "{what}: {:.2} m, {:.3} degrees off, {level_dbw} dBW",
            found_m - range_m,
            away_deg(found_deg, bearing_deg)
        );
        assert!((found_m - range_m).abs() <= cell_m, "{what}: {found_m} {range_m}");
        assert!(away_deg(found_deg, bearing_deg) <= beam_deg / 3.0, "{what}: {found_deg} {bearing_deg}");
    }
}

#[test]
fn targets_stand_where_they_are_on_the_panel() {
    let shown = shown_of(SCENARIO, &SLOW);
    let mut browser = shown.browser();
    let about = browser.json("about");
    let ppi = &about["ppi"];
    assert_eq!((&ppi["channel"], &ppi["antenna"]), (&"HH".into(), &1.into()));
    assert!((ppi["period_s"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{ppi}");
    // Two apertures of 1 m: 0.886 lambda / D / sqrt 2; a spoke is a third of it.
    let beam_deg = (0.886 * 0.031_859 / 2f64.sqrt()).to_degrees();
    assert!((ppi["beam_deg"].as_f64().unwrap() - beam_deg).abs() < 1e-3, "{ppi}");
    assert_eq!(ppi["spokes"].as_f64().unwrap(), (1080.0 / beam_deg).ceil());
    let radials = turn(&mut browser);
    check(&radials, &about, "live");
    assert!(radials.is_sorted_by(|a, b| a.pulse < b.pulse && a.time_s < b.time_s));
    assert!(radials.iter().all(|radial| radial.heading_deg == 0.0 && radial.levels_dbw.len() <= 512));
    // Where nobody looks nothing is made, and nothing is sent that was not asked for.
    let mut other = shown.browser();
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_millis(500) {
        assert!(!matches!(other.next().unwrap(), Message::Radials(_)));
    }
    shown.end();
}

/// Bearings count from North on a platform that is turned, and its heading comes with them; samples are
/// codes.
#[test]
fn bearings_count_from_north_wherever_the_nose_is() {
    let turned = "platform.0.track={ kind = 'fixed', position_m = [100.0, -200.0, 20.0], yaw_deg = 77.0 }";
    let more = ["--set", turned, "--set", "radar.adc={ bits = 12, full_scale_dbw = -60.0 }"];
    let shown = shown_of(SCENARIO, &[&SLOW[..], &more].concat());
    let mut browser = shown.browser();
    let about = browser.json("about");
    let radials = turn(&mut browser);
    check(&radials, &about, "turned");
    assert!(radials.iter().all(|radial| (radial.heading_deg - 77.0).abs() < 1e-6));
    shown.end();
}

/// A recording has the same panel.
#[test]
fn a_recording_has_the_panel_as_well() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), SCENARIO).unwrap();
    let ended = nereus(folder.path(), &["run", "s.toml", "--pace", "fast"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    // Two turns and a quarter of 0.2 s, made to last 9 s.
    let child = started(folder.path(), &["monitor", "r.plain", "--listen", "127.0.0.1:0", "--speed", "0.05"]);
    let shown = served(folder, child);
    let mut browser = shown.browser();
    let about = browser.json("about");
    assert_eq!((&about["replayed"], &about["ppi"]["channel"]), (&true.into(), &"HH".into()));
    let radials = turn(&mut browser);
    check(&radials, &about, "recorded");
}

/// Without an antenna that scans there is no panel, and whoever asks for it gets nothing.
#[test]
fn without_a_scan_there_is_no_panel() {
    let shown = shown(&[]);
    let mut browser = shown.browser();
    assert!(browser.json("about")["ppi"].is_null());
    browser.send(r#"{"ppi":true}"#);
    let mut statuses = 0;
    while statuses < 3 {
        match browser.next().unwrap() {
            Message::Radials(_) => panic!("radials of an antenna that does not scan"),
            Message::Json(value) => statuses += u32::from(value["kind"] == "status"),
            _ => {}
        }
    }
    shown.end();
}
