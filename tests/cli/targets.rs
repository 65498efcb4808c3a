//! Messages about targets: figures worked out here by plane geometry about the origin, AIS by `pyais` (a
//! Python package).

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::nereus;

/// A ship on a course to the East that reports 3 degrees too much heading and to be 200 m farther North.
const SCENARIO: &str = r#"
[scene]
start_utc = "2024-05-01T09:59:58Z"
duration_s = 5.0
seed = 3
origin_lat_deg = 0.0
origin_lon_deg = 10.0
origin_h_m = 0.0
patch_size_m = [16.0, 16.0]
facet_m = 4.0
[sea]
wind_mps = 5.0
wind_from_deg = 250.0
[fidelity]
echo = "reference"
[radar]
carrier_hz = 9.41e9
sample_rate_hz = 25e6
prf_hz = 8.0
channels = ["HH"]
waveform = { kind = "lfm", bandwidth_hz = 20e6, pulse_s = 1e-6 }
window = { samples = 30, start_us = 22.8 }
[[platform]]
name = "own"
track = { kind = "straight", position_m = [0.0, 0.0, 20.0], velocity_mps = [10.0, 0.0, 0.0] }
errors = { position = { bias_m = [0.0, 200.0, 0.0] }, attitude = { bias_deg = [0.0, 0.0, 3.0] } }
[[transmitter]]
name = "t"
platform = "own"
power_w = 1000.0
antenna = { kind = "isotropic" }
[[receiver]]
name = "r"
platform = "own"
antenna = { kind = "isotropic" }
[[target]]
name = "buoy"
position_m = [1852.0, 926.0, 3.0]
rcs_m2 = 10.0
[[target]]
name = "boat"
position_m = [0.0, -1852.0, 3.0]
velocity_mps = [0.0, 5.0, 0.0]
rcs_m2 = 10.0
[[ship]]
name = "mmsi-235070762"
hull = "wigley"
length_m = 90.0
beam_m = 14.0
draught_m = 4.0
position_m = [-3704.0, 0.0]
heading_deg = 90.0
speed_mps = 10.0
wake = false
turbulent = false
[[sink]]
kind = "targets"
device = "file:targets.nmea"
target_sentences = ["RSD", "TTM", "TLL", "VDM"]
"#;

/// Fields of the sentences of a name, their checksums checked.
fn sentences(folder: &Path, settings: &[&str], name: &str) -> Vec<Vec<String>> {
    fs::write(folder.join("s.toml"), SCENARIO).unwrap();
    let mut arguments = vec!["run", "s.toml", "--pace", "fast", "--force"];
    settings.iter().for_each(|setting| arguments.extend(["--set", *setting]));
    let ended = nereus(folder, &arguments);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let text = fs::read_to_string(folder.join("targets.nmea")).unwrap();
    let of = |line: &str| {
        let (body, sum) = line[1..].split_once('*').unwrap();
        assert_eq!(
            u8::from_str_radix(sum, 16).unwrap(),
            body.bytes().fold(0, |sum, byte| sum ^ byte),
            "{line}"
        );
        body.split(',').map(str::to_owned).collect::<Vec<String>>()
    };
    text.lines().map(of).filter(|fields| fields[0] == name).collect()
}

fn figure(field: &str) -> f64 {
    field.parse().unwrap_or_else(|_| panic!("{field}"))
}

fn close(found: &str, wanted: f64, within: f64) {
    assert!((figure(found) - wanted).abs() <= within, "{found}, not {wanted}");
}

#[test]
fn tracked_targets_are_where_the_truth_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let truth = [r#"sink.0.own_ship="true""#];
    let ttm = sentences(folder.path(), &truth, "RATTM");
    // Three targets in each of five seconds.
    assert_eq!(ttm.len(), 15);
    for (second, three) in ttm.chunks(3).enumerate() {
        let own_m = 10.0 * second as f64;
        let wanted = [
            // A mile ahead and half a mile to the left, at rest.
            ("01", "buoy", [1852.0 - own_m, 926.0], [0.0, 0.0]),
            ("02", "boat", [-own_m, 5.0 * second as f64 - 1852.0], [0.0, 5.0]),
            // Two miles astern on the same course and speed: it comes no nearer.
            ("03", "mmsi-235070762", [-3704.0, 0.0], [10.0, 0.0]),
        ];
        for (fields, (number, name, [east, north], [vx, vy])) in three.iter().zip(wanted) {
            assert_eq!((fields[1].as_str(), fields[11].as_str()), (number, name));
            // Fields have four decimals; the Earth curves by less.
            close(&fields[2], f64::hypot(east, north) / 1852.0, 2e-4);
            close(&fields[3], f64::atan2(east, north).to_degrees().rem_euclid(360.0), 2e-3);
            close(&fields[5], f64::hypot(vx, vy) * 3600.0 / 1852.0, 2e-3);
            assert_eq!([4, 7, 10, 12, 15].map(|n: usize| fields[n].as_str()), ["T", "T", "N", "T", "A"]);
            let time = ["095958.000", "095959.000", "100000.000", "100001.000", "100002.000"][second];
            assert_eq!(fields[14], time);
        }
        assert_eq!(three[0][6], "");
        close(&three[1][6], 0.0, 2e-3);
        // The buoy passes half a mile to the left in (1852 m - way)/10 m/s.
        close(&three[0][8], 0.5, 2e-3);
        close(&three[0][9], (1852.0 - own_m) / 600.0, 2e-3);
        close(&three[2][8], 2.0, 2e-3);
    }
    let tll = sentences(folder.path(), &truth, "RATLL");
    // On the equator a minute of longitude is 6378137 m pi / 10800, one of latitude (1 - e^2) of that.
    let minute_m = 6_378_137.0 * std::f64::consts::PI / 10_800.0;
    assert_eq!((tll[0][3].as_str(), tll[0][5].as_str(), tll[0][6].as_str()), ("N", "E", "buoy"));
    close(&tll[0][2], 926.0 / (minute_m * (1.0 - 0.006_694_38)), 1e-5);
    close(&tll[0][4], 1000.0 + 1852.0 / minute_m, 1e-5);
    let rsd = sentences(folder.path(), &truth, "RARSD");
    assert_eq!(rsd.len(), 5);
    // The window ends after 24 us: 3597.5 m.
    close(&rsd[0][11], 3597.51 / 1852.0, 1e-4);
    assert_eq!(rsd[0][12..], ["N", "N"]);
}

#[test]
fn errors_of_own_ship_move_and_turn_its_targets_but_not_what_ships_report() {
    let folder = tempfile::tempdir().unwrap();
    let (truth, reported) = ([r#"sink.0.own_ship="true""#], []);
    let (true_ttm, ttm) =
        (sentences(folder.path(), &truth, "RATTM"), sentences(folder.path(), &reported, "RATTM"));
    for (wanted, found) in true_ttm.iter().zip(&ttm) {
        close(&found[2], figure(&wanted[2]), 1e-4);
        let turned = (figure(&found[3]) - figure(&wanted[3])).rem_euclid(360.0);
        assert!((turned - 3.0).abs() < 1e-3, "{turned}");
    }
    // What stands still moves by 10 m/s turned by 3 degrees.
    close(&ttm[0][5], 2.0 * 10.0 * (1.5f64).to_radians().sin() * 3600.0 / 1852.0, 2e-3);
    let tll = sentences(folder.path(), &reported, "RATLL");
    // (1852, 926) m turned by 3 degrees clockwise, and 200 m to the North.
    let minute_m = 6_378_137.0 * std::f64::consts::PI / 10_800.0;
    let (sin, cos) = 3f64.to_radians().sin_cos();
    close(&tll[0][2], (926.0 * cos - 1852.0 * sin + 200.0) / (minute_m * (1.0 - 0.006_694_38)), 1e-4);
    close(&tll[0][4], 1000.0 + (1852.0 * cos + 926.0 * sin) / minute_m, 1e-4);
    let ais = |settings: &[&str]| sentences(folder.path(), settings, "AIVDM");
    assert_eq!(ais(&truth), ais(&reported));
}

const READER: &str = r#"
import sys, pyais
messages = [m.decode() for m in pyais.FileReaderStream(sys.argv[1])]
position = [m for m in messages if m.msg_type == 1]
static, = [m for m in messages if m.msg_type == 5]
assert len(position) == 5
minute = 6378137.0 * 3.141592653589793 / 10800
for second, m in enumerate(position):
    assert m.mmsi == 235070762 and m.second == (58 + second) % 60 and m.heading == 90 and m.course == 90
    assert abs(m.speed - 19.4) < 0.01 and m.status == 0, m
    assert abs(m.lat) < 2e-6 and abs((m.lon - 10) * 60 - (10 * second - 3704) / minute) < 1e-4, m
assert static.mmsi == 235070762 and static.shipname == "MMSI-235070762"
assert (static.to_bow + static.to_stern, static.to_port + static.to_starboard, static.draught) == (90, 14, 4)
"#;

#[test]
fn pyais_reads_what_ships_report() {
    if !Command::new("python3").args(["-c", "import pyais"]).output().is_ok_and(|o| o.status.success()) {
        println!("skipped: python3 cannot import pyais");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    sentences(folder.path(), &["sink.0.target_sentences=['VDM']"], "AIVDM");
    let path = folder.path().join("targets.nmea");
    let output = Command::new("python3").args(["-c", READER]).arg(path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn targets_on_a_port_come_line_by_line() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), SCENARIO).unwrap();
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_nonblocking(true).unwrap();
    let device = format!("sink.0.device=udp://{}", socket.local_addr().unwrap());
    let ended = nereus(folder.path(), &["run", "s.toml", "--pace", "fast", "--set", &device, "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let mut buffer = [0; 2000];
    let mut lines = 0;
    while let Ok(length) = socket.recv(&mut buffer) {
        let text = std::str::from_utf8(&buffer[..length]).unwrap();
        assert!(text.ends_with("\r\n") && text.matches('\n').count() == 1, "{text}");
        lines += 1;
    }
    // Five times RSD, three TTM, three TLL and one position; two parts of the particulars.
    assert_eq!(lines, 5 * 8 + 2);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    assert_eq!(report["out"][0]["port"]["messages"], 42, "{report}");
}

#[test]
fn targets_without_an_origin_or_with_other_words_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = SCENARIO.replace("origin_lat_deg = 0.0\norigin_lon_deg = 10.0\norigin_h_m = 0.0\n", "");
    fs::write(folder.path().join("s.toml"), text).unwrap();
    let words = ["sink.0.target_sentences=['TTM', 'GGA']", "sink.0.own_ship=false", "sink.0.platform=other"];
    let mut arguments = vec!["check", "s.toml"];
    words.iter().for_each(|word| arguments.extend(["--set", *word]));
    let ended = nereus(folder.path(), &arguments);
    assert_eq!(ended.code, 2);
    for wanted in [
        "sink.0.device: navigation out needs scene.origin_lat_deg, origin_lon_deg and origin_h_m",
        "sink.0.platform: there is no platform \"other\"; allowed: own",
        "sink.0.target_sentences: entry 1, \"GGA\", is not allowed; allowed: a list of 1 to 4 texts, each TTM, TLL, RSD or VDM",
        "sink.0.own_ship: false is not allowed; allowed: \"reported\", \"true\"",
    ] {
        assert!(ended.stderr.contains(wanted), "{wanted}\n{}", ended.stderr);
    }
}
