//! `tools/ais_ships.py`, where Python is there: ships of a log sail in a scenario.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::{Ended, nereus, package};

/// Twice vessel 1, 20 s before and 10 s after 12:00; others for one reason each not under way.
const LOG: &str = "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots
2016-01-12 11:59:40.000,1,50.0,-1.0,90.0,10.0
2016-01-12 12:00:10.000,1,50.0,-0.99964,90.0,10.0
2016-01-12 12:00:00.000,2,50.001,-1.0,10.0,0.1
2016-01-12 12:00:00.000,3,50.002,-1.0,360.0,5.0
2016-01-12 12:00:00.000,4,50.002,-1.0,10.0,102.3
2016-01-12 11:00:00.000,5,50.002,-1.0,10.0,5.0
2016-01-12 12:00:00.000,6,52.0,-1.0,10.0,5.0
2016-01-12 12:00:00.000,7,91.0,181.0,10.0,5.0
2016-01-12 12:00:00.000,8,50.0005,-1.0,180.0,8.0
";

fn convert(folder: &Path, log: &str, arguments: &[&str]) -> Option<Ended> {
    fs::write(folder.join("log.csv"), log).unwrap();
    let tool = package().join("tools/ais_ships.py");
    let run = Command::new("python3").arg(tool).arg("log.csv").args(arguments).current_dir(folder).output();
    let Ok(run) = run else {
        println!("skipped: no python3");
        return None;
    };
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Some(Ended { code: run.status.code().unwrap(), stdout: text(run.stdout), stderr: text(run.stderr) })
}

const AREA: [&str; 8] =
    ["--utc", "2016-01-12T12:00:00Z", "--lat-deg", "50", "--lon-deg", "-1", "--within-m", "1000"];

#[test]
fn ships_of_a_log_sail() {
    let folder = tempfile::tempdir().unwrap();
    let Some(ended) = convert(folder.path(), LOG, &AREA) else { return };
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let said = "2 ships; left out: 1 old, 2 unknown course or speed, 1 at rest, 1 far";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
    let sea = fs::read_to_string(package().join("configs/sea.toml")).unwrap();
    let origin = "[scene]\norigin_lat_deg = 50\norigin_lon_deg = -1\norigin_h_m = 48\n";
    let scenario = sea.replace("[scene]\n", origin) + &ended.stdout;
    let run = nereus::config::parse(&scenario, &folder.path().join("log.toml"), &[]).unwrap();
    let [first, second] = &run.scene.ships[..] else { panic!("{}", ended.stdout) };
    assert_eq!((first.name.as_str(), second.name.as_str()), ("mmsi-1", "mmsi-8"));
    let speed_mps = 10.0 * 1852.0 / 3600.0;
    // Printed in millimetres a second.
    assert!((first.speed_mps - speed_mps).abs() < 5.1e-4 && first.heading_rad == 0.0);
    // 0.00036 degrees East of the origin are 25.81 m on the ellipsoid (prime vertical 6390.7 km), 10 s back 51.44 m. The tool
    // takes a sphere for the way (0.3 %: 0.17 m) and prints 1e-7 degrees (1 cm).
    let [east_m, north_m] = first.position_m;
    assert!((east_m - (25.81 - 51.44)).abs() < 0.2 && north_m.abs() < 0.02, "{east_m} {north_m}");
    // Heading South: -90 degrees from East.
    assert_eq!(second.heading_rad, (-90f64).to_radians());
    fs::write(folder.path().join("log.toml"), scenario).unwrap();
    let wake = nereus(folder.path(), &["wake", "log.toml", "--json"]);
    assert_eq!(wake.code, 0, "{}", wake.stderr);
    let report: serde_json::Value = serde_json::from_str(&wake.stdout).unwrap();
    assert_eq!(report["ships"].as_array().unwrap().len(), 2);
    assert!(report["height_range_m"][1].as_f64().unwrap() > 0.01);
}

#[test]
fn logs_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let utc = ["--utc", "2016-01-12T12:00:00Z"];
    let spoiled = LOG.replace("50.001,", "north,");
    let cases: [(&str, &[&str], &str); 5] = [
        ("a,b\n1,2\n", &utc, "log.csv:1: no column Time"),
        (&spoiled, &utc, "log.csv:4: not a report"),
        ("Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots\nnow,1\n", &utc, "log.csv:2"),
        (LOG, &["--utc", "noon"], "expected a UTC time"),
        (LOG, &["--utc", "2016-01-12T12:00:00Z", "--lat-deg", "1"], "stand together"),
    ];
    for (log, arguments, said) in cases {
        let Some(ended) = convert(folder.path(), log, arguments) else { return };
        assert!(ended.code == 2 && ended.stderr.contains(said), "{said}: {}", ended.stderr);
        assert!(ended.stdout.is_empty(), "{}", ended.stdout);
    }
}
