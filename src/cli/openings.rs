//! What a run's files hold is read once by a command, however many parts of the program ask for it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use clap::Parser;

use super::{Arguments, execute};
use crate::inputs::opened;
use crate::sea::realise::realise;

/// An aircraft on a recorded track, a pulse from a file, a sea from a saved state.
const SCENARIO: &str = r#"
[scene]
start_utc = "2024-05-01T10:00:05Z"
duration_s = 0.1
origin_lat_deg = 54.0
origin_lon_deg = 8.0
origin_h_m = 40.0
patch_size_m = [32.0, 32.0]
facet_m = 2.0

[radar]
carrier_hz = 10e9
sample_rate_hz = 50e6
prf_hz = 200.0
channels = ["VV"]
waveform = { kind = "file", path = "pulse.csv", rate_hz = 50e6 }
window = { samples = 256, start_us = 9.0 }

[[platform]]
name = "aircraft"
track = { kind = "gpx", path = "flight.gpx", datum = "msl" }

[[transmitter]]
name = "tx"
platform = "aircraft"
power_w = 100.0
antenna = { kind = "isotropic" }

[[receiver]]
name = "rx"
platform = "aircraft"
antenna = { kind = "isotropic" }

[[target]]
name = "buoy"
position_m = [0.0, 0.0, 1.0]
rcs_m2 = 1.0

[sea]
wind_mps = 6.0
wind_from_deg = 270.0

[[sink]]
kind = "null"
"#;

fn files(folder: &Path) {
    let mut points = String::new();
    for second in 0..10 {
        let lon_deg = 7.98 + 1e-3 * f64::from(second);
        let point = format!("<trkpt lat=\"54.0\" lon=\"{lon_deg}\"><ele>1000</ele>");
        let _ = write!(points, "{point}<time>2024-05-01T10:00:0{second}Z</time></trkpt>");
    }
    let gpx = format!("<gpx version=\"1.1\"><trk><trkseg>{points}</trkseg></trk></gpx>");
    fs::write(folder.join("flight.gpx"), gpx).unwrap();
    fs::write(folder.join("pulse.csv"), "1.0,0.0\n".repeat(32)).unwrap();
    let run = crate::config::parse(SCENARIO, &folder.join("drawn.toml"), &[]).unwrap();
    let drawn = realise(run.scene.sea.as_ref().unwrap(), 1).unwrap();
    drawn.surface.save(&mut fs::File::create(folder.join("sea.state")).unwrap()).unwrap();
    let saved = SCENARIO.replace("[sea]", "[sea]\nstate_path = \"sea.state\"");
    fs::write(folder.join("scene.toml"), saved).unwrap();
}

/// Before: `check` opened the track and the pulse five times each, `bench` all three five to seven times.
#[test]
fn a_command_opens_what_it_needs_once() {
    let commands: [&[&str]; 3] = [
        &["check"],
        &["run", "--pace", "fast"],
        &["bench", "--threads", "1", "--pulses", "4", "--error-pulses", "2"],
    ];
    for command in commands {
        let folder = tempfile::tempdir().unwrap();
        files(folder.path());
        let scenario = folder.path().join("scene.toml");
        let words = [&["nereus", command[0], scenario.to_str().unwrap()], &command[1..]].concat();
        let arguments = Arguments::try_parse_from(words).unwrap();
        let mut out = Vec::new();
        execute(&arguments, Instant::now(), &mut out).unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let times = ["flight.gpx", "pulse.csv", "sea.state"].map(|name| opened(&folder.path().join(name)));
        assert_eq!(times, [1; 3], "{command:?}");
    }
}
