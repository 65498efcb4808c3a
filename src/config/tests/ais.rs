//! Ships of AIS logs: which sail, where, and every way to be wrong.

use std::fs;

use proptest::prelude::*;

use super::*;
use crate::scene::ship::{HullGiven, ShipMotion};

const SEA: &str = include_str!("../../../configs/sea.toml");

/// Twice vessel 1, 20 s before and 10 s after 12:00; others for one reason each not under way; 8 with its
/// size.
const LOG: &str = "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots,Length_metres,Beam_metres,Draught_metres
2016-01-12 11:59:40.000,1,50.0,-1.0,90.0,10.0,,,
2016-01-12 12:00:10.000,1,50.0,-0.99964,90.0,10.0,,,
2016-01-12 12:00:00.000,2,50.001,-1.0,10.0,0.1,,,
2016-01-12 12:00:00.000,3,50.002,-1.0,360.0,5.0,,,
2016-01-12 12:00:00.000,4,50.002,-1.0,10.0,102.3,,,
2016-01-12 11:00:00.000,5,50.002,-1.0,10.0,5.0,,,
2016-01-12 12:00:00.000,6,52.0,-1.0,10.0,5.0,,,
2016-01-12 12:00:00.000,7,91.0,181.0,10.0,5.0,,,
2016-01-12 12:00:00.000,8,50.0005,-1.0,180.0,8.0,120,20,0
";

/// The smallest sea at 50 N 1 W on that day at noon.
fn placed() -> String {
    let origin = "[scene]\norigin_lat_deg = 50\norigin_lon_deg = -1\norigin_h_m = 48\nstart_utc = \"2016-01-12T12:00:00Z\"\n";
    SEA.replace("[scene]\n", origin)
}

/// Scenarios that between them read every key.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    vec![
        (SEA, vec![("ais", "[{ log = 'tracks/solent_ais.csv', hull = 'wigley' }]")]),
        (
            SEA,
            vec![(
                "ais",
                "[{ log = 'tracks/solent_ais.csv', echo = true, mesh = true, superstructure = 'none' }]",
            )],
        ),
        (SEA, vec![("ais", "[{ log = 'tracks/solent_ais.csv', follow = true }]")]),
        (SEA, vec![("ais", "[{ log = 'tracks/solent_ais.csv', start_utc = '2016-01-12T13:05:00Z' }]")]),
    ]
}

fn read_log(text: &str, log: &str, table: &str) -> Result<Run, ConfigError> {
    read_in(&tempfile::tempdir().unwrap(), text, log, table)
}

fn read_in(folder: &tempfile::TempDir, text: &str, log: &str, table: &str) -> Result<Run, ConfigError> {
    fs::write(folder.path().join("log.csv"), log).unwrap();
    parse(&format!("{text}\n[[ais]]\nlog = \"log.csv\"\n{table}\n"), &folder.path().join("my.toml"), &[])
}

fn fault(text: &str, log: &str, table: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let error = read_in(&folder, text, log, table).unwrap_err();
    let here = folder.path().display().to_string();
    error.faults().iter().map(|fault| format!("{fault}\n").replace(&here, "here")).collect()
}

/// A vessel on a circle of 500 m at 10 knots, a report every 10 s, one of them astray, and one that stops.
#[test]
fn vessels_follow_their_reports() {
    let mut log = String::from("Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\n");
    let (speed_mps, metres) = (10.0 * 1852.0 / 3600.0, [71_700.0, 111_230.0]);
    for n in -10..=10 {
        let time_s = 10.0 * f64::from(n);
        let turn = speed_mps / 500.0 * time_s;
        let stray_m = if n == 3 { 2000.0 } else { 0.0 };
        let [east_m, north_m] = [500.0 * turn.sin() + stray_m, 500.0 - 500.0 * turn.cos()];
        let second = 43_200 + 10 * n;
        let (hour, minute, rest) = (second / 3600, second / 60 % 60, second % 60);
        let (lat, lon) = (50.0 + north_m / metres[1], -1.0 + east_m / metres[0]);
        let course = (90.0 - turn.to_degrees()).rem_euclid(360.0);
        log += &format!("2016-01-12 {hour:02}:{minute:02}:{rest:02},1,{lat:.7},{lon:.7},{course:.1},10.0\n");
        let knots = if n > 0 { 0.0 } else { 5.0 };
        log += &format!("2016-01-12 {hour:02}:{minute:02}:{rest:02},2,50.01,-1.0,0.0,{knots:.1}\n");
    }
    let run = read_log(&placed(), &log, "follow = true").unwrap();
    let [ship] = &run.scene.ships[..] else { panic!("{:?}", run.scene.ships) };
    let way = ship.trajectory.as_ref().unwrap();
    for n in -50..50 {
        let time_s = f64::from(n);
        let turn = speed_mps / 500.0 * time_s;
        let [x, y, _] = way.at(time_s).position.to_array();
        let off_m = (x - 500.0 * turn.sin()).hypot(y - (500.0 - 500.0 * turn.cos()));
        // Courses are rounded to 0.1 degree, and a degree of longitude is not known to more digits here.
        assert!(off_m < 0.5, "{time_s}: {off_m}");
    }
    let text: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    let wanted = "1 reports left out for which vessels would have to turn or run faster";
    assert!(text.iter().any(|text| text.contains(wanted) && text.contains("1 vessels left out")), "{text:?}");
    // One that is silent for longer than most_age_s within the run.
    let silent = "2016-01-12 11:58:20,4,50.0,-1.0,0.0,5.0\n2016-01-12 12:05:00,4,50.00925,-1.0,0.0,5.0\n";
    let run = read_log(&placed(), &format!("{log}{silent}"), "follow = true").unwrap();
    let text: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    assert!(text.iter().any(|text| text.contains("1 whose reports leave")), "{text:?}");
    // One that moors before or after the run sails in it, on the part of its way without berths.
    let mut moors = log.lines().next().unwrap().to_owned() + "\n";
    for (n, knots) in [0.0, 0.0, 4.0, 4.0, 4.0, 0.0, 0.0].into_iter().enumerate() {
        let lat = 50.0 + 20.0 * 4.0 * 1852.0 / 3600.0 * (n as f64 - 3.0) / metres[1];
        let (minute, second) = [(59, 0), (59, 20), (59, 40), (0, 0), (0, 20), (0, 40), (1, 0)][n];
        let hour = if minute == 59 { 11 } else { 12 };
        moors += &format!("2016-01-12 {hour}:{minute:02}:{second:02},3,{lat:.7},-1.0,0.0,{knots:.1}\n");
    }
    let run = read_log(&placed(), &moors, "follow = true").unwrap();
    assert_eq!(run.scene.ships[0].trajectory.as_ref().unwrap().span_s(), [-20.0, 20.0]);
    // A bound that it does not keep leaves it one report: it sails straight on.
    let run = read_log(&placed(), &log, "follow = true\nmax_turn_degps = 0.0001\nmmsi = [1]").unwrap();
    assert!(run.scene.ships.len() <= 1);
    let idle = fault(&placed(), &log, "max_turn_degps = 5");
    assert!(idle.contains("ais.0.max_turn_degps") && idle.contains("follow = false"), "{idle}");
}

#[test]
fn a_log_that_is_gone_has_no_ships_in_a_recording() {
    let text = format!("{}\n[[ais]]\nlog = \"gone.csv\"\nwithin_m = 1000\n", placed());
    assert!(
        parse(&text, Path::new("my.toml"), &[])
            .unwrap_err()
            .to_string()
            .contains("there is no file gone.csv")
    );
    assert_eq!(recorded(&text).unwrap().scene.ships, []);
    let error = recorded(&text.replace("within_m = 1000", "within_m = -1")).unwrap_err().to_string();
    assert!(error.contains("within_m"), "{error}");
}

#[test]
fn ships_under_way_sail() {
    let run = read_log(&placed(), LOG, "within_m = 1000").unwrap();
    let [first, second] = &run.scene.ships[..] else { panic!("{:?}", run.scene.ships) };
    assert_eq!((first.name.as_str(), second.name.as_str()), ("mmsi-1", "mmsi-8"));
    assert!((first.speed_mps - 10.0 * 1852.0 / 3600.0).abs() < 1e-12);
    // The meridian of the ship is turned by 0.00036 deg sin 50 deg = 4.8e-6 rad.
    assert!((first.heading_rad - 4.8e-6).abs() < 1e-7, "{}", first.heading_rad);
    // 0.00036 degrees East are 25.806 m on the ellipsoid (prime vertical 6390.7 km), 10 s back 51.444 m.
    let [east_m, north_m] = first.position_m;
    assert!((east_m - (25.806 - 51.444)).abs() < 0.01 && north_m.abs() < 0.01, "{east_m} {north_m}");
    assert!((second.heading_rad - (-90f64).to_radians()).abs() < 1e-12);
    let shape = |beam: f64, draught: f64| HullGiven::Wigley { beam_m: beam, draught_m: draught };
    assert_eq!((&first.hull, first.length_m), (&shape(0.134 * 60.0, 0.043 * 60.0), Some(60.0)));
    assert_eq!((&second.hull, second.length_m), (&shape(20.0, 0.043 * 120.0), Some(120.0)));
    // Above 6 GHz.
    assert!(first.kelvin.is_some_and(|kelvin| !kelvin.short_waves) && first.turbulent.is_some());
}

#[test]
fn settings_of_a_log_arrive() {
    let table = "mmsi = [2, 8]\nleast_speed_mps = 0\nlength_m = 30\nwake_bragg = true\nturbulent = false";
    let run = read_log(&placed(), LOG, table).unwrap();
    let names: Vec<_> = run.scene.ships.iter().map(|ship| ship.name.as_str()).collect();
    assert_eq!((names, run.scene.ships[0].length_m), (vec!["mmsi-2", "mmsi-8"], Some(30.0)));
    assert!(run.scene.ships.iter().all(|s| s.turbulent.is_none() && s.kelvin.unwrap().short_waves));
    // An hour earlier vessel 5 alone; the log's own instant stands for that of the scene.
    let run = read_log(&placed(), LOG, "start_utc = 2016-01-12T11:00:00Z\nwake = false").unwrap();
    let ship = &run.scene.ships[0];
    assert_eq!((run.scene.ships.len(), ship.name.as_str(), ship.kelvin), (1, "mmsi-5", None));
}

#[test]
fn ships_of_a_log_echo() {
    let settings = "within_m = 1000\necho = true\nmotion = \"waves\"\nroll_period_s = 9\nfreeboard_m = 3";
    let ships = read_log(&placed(), LOG, settings).unwrap().scene.ships;
    for (ship, length_m) in ships.iter().zip([60.0, 120.0]) {
        let mesh = &ship.mesh;
        assert_eq!((ship.echo, ship.length_m, mesh.freeboard_m), (true, Some(length_m), Some(3.0)));
        assert_eq!((mesh.panel_m, mesh.used, &mesh.superstructure), (length_m / 50.0, None, &None));
        assert_eq!(mesh.motion, ShipMotion::Waves { roll_period_s: Some(9.0), form: None });
    }
    let ships = read_log(&placed(), LOG, "echo = true\npanel_m = 0.7").unwrap().scene.ships;
    assert!(ships.iter().all(|ship| ship.mesh.panel_m == 0.7 && ship.mesh.motion == ShipMotion::Level));
    let found = fault(&placed(), LOG, "panel_m = -1\nup = \"x\"\necho = true");
    assert_eq!(found.matches("panel_m").count(), 1, "{found}");
    assert!(found.contains("ais.0.up: "), "{found}");
    let found = fault(&placed(), LOG, "panel_m = 1\nmesh = true");
    assert!(found.matches("not allowed here (echo = false)").count() == 2, "{found}");
}

/// Of the reports of a vessel the nearest that says where she goes.
#[test]
fn a_report_without_course_is_not_the_nearest() {
    let row = "2016-01-12 12:00:00.000,1,50.0,-0.9998,360.0,102.3,,,\n";
    let ships = read_log(&placed(), &format!("{LOG}{row}"), "within_m = 1000").unwrap().scene.ships;
    assert_eq!(ships, read_log(&placed(), LOG, "within_m = 1000").unwrap().scene.ships);
}

#[test]
fn what_a_log_passes_over_is_said() {
    let run = read_log(&placed(), LOG, "within_m = 1000").unwrap();
    let warnings: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    let said = "log.csv: 8 position reports; passed over: 1 without a position, 2 without course or speed";
    assert!(warnings.iter().any(|warning| warning.ends_with(said)), "{warnings:?}");
}

/// Columns exchanged: the origin lies at 50 N 1 W, so that vessels seem to be at 1 S 50 E.
#[test]
fn a_log_with_latitude_and_longitude_swapped_says_so() {
    let swapped = LOG.replace("Latitude_degrees,Longitude", "Longitude_degrees,Latitude");
    let found = fault(&placed(), &swapped, "");
    assert!(found.contains("; with latitude and longitude swapped, vessels would be near"), "{found}");
}

#[test]
fn a_recorded_log_sails() {
    let origin = "[scene]\norigin_lat_deg = 50.75\norigin_lon_deg = -1.1\norigin_h_m = 46\nstart_utc = \"2016-01-12T13:05:00Z\"\n";
    let text = SEA.replace("[scene]\n", origin) + "\n[[ais]]\nlog = \"tracks/solent_ais.csv\"\n";
    let ships = parse(&text, &in_configs(), &[]).unwrap().scene.ships;
    assert!(ships.len() > 10, "{}", ships.len());
    // The fastest of the recording, a ferry of 36 knots.
    let fastest_mps = ships.iter().map(|ship| ship.speed_mps).fold(0.0, f64::max);
    assert!((15.0..19.0).contains(&fastest_mps), "{fastest_mps}");
}

#[test]
fn logs_that_are_none() {
    let placed = placed();
    let corrupted = LOG.replace("50.001,", "north,").replace("8.0,120", "8.0,1200");
    insta::assert_snapshot!(fault(&placed, &corrupted, ""), @r#"
ais.0.log: here/log.csv: 1 fault
  line 4: Latitude_degrees = 'north' is not a finite number
"#);
    insta::assert_snapshot!(fault(&placed, LOG, "mmsi = [9]"), @r#"ais.0.mmsi: there is no vessel "9"; allowed: 1, 2, 3, 4, 5, 6, 8"#);
    insta::assert_snapshot!(fault(&placed, LOG, "least_speed_mps = 50\nmost_age_s = -1"), @r#"ais.0.most_age_s: -1 is out of range; allowed: a number from 0 to 1e6 s"#);
    insta::assert_snapshot!(fault(&placed, LOG, "least_speed_mps = 50"), @r#"ais.0.log: no vessel is under way: of 7 in here/log.csv, 1 have no report within most_age_s, 2 no course or speed, 4 are slower than least_speed_mps, 0 are beyond within_m; allowed: a start_utc within the log, or wider limits"#);
    insta::assert_snapshot!(fault(SEA, LOG, ""), @r#"
ais.0.start_utc: is missing; required with a recorded track: a UTC time within the recording
ais.0.log: positions of a log need scene.origin_lat_deg, origin_lon_deg and origin_h_m
"#);
    insta::assert_snapshot!(fault(&placed, LOG, "[[ais]]\nlog = \"log.csv\"\nmmsi = [8]"), @r#"ais.1.log: "mmsi-8" is already the name of another ship; allowed: unique names"#);
    insta::assert_snapshot!(fault(&placed, "a,b\n", "wake = false\nwake_bragg = true"), @r#"
ais.0.log: here/log.csv: 1 fault
  line 1: missing: Time, MMSI, Latitude_degrees, Longitude_degrees, COG_degrees, SOG_knots; allowed: the columns Time (UTC), MMSI, Latitude_degrees, Longitude_degrees, COG_degrees, SOG_knots, or as MarineCadastre (BaseDateTime, MMSI, LAT, LON, COG, SOG) or the Danish Maritime Authority (# Timestamp, MMSI, Latitude, Longitude, COG, SOG) names them; or sentences !AIVDM
ais.0.wake_bragg: not allowed here (wake = false)
"#);
}

proptest! {
    #![proptest_config(crate::rng::cases::proptests(200))]

    #[test]
    fn corrupt_logs_never_panic(at in 0usize..600, with in "[-0-9.,:enax#\n ]{0,4}", cut in 0usize..60) {
        let mut log = LOG.to_owned();
        let from = at.min(log.len());
        log.replace_range(from..(from + cut).min(log.len()), &with);
        if let Ok(log) = crate::nav::ais::parse(log.as_bytes()) {
            prop_assert!(log.reports.iter().all(|r| r.lat_deg.abs() <= 90.0 && r.lon_deg.abs() <= 180.0));
        }
    }
}
