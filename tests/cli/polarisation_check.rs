//! `check` where polarisation bases say little.

use std::fs;

use crate::program::nereus;

const SCENARIO: &str = r#"
[scene]
duration_s = 0.1
seed = 1
earth = "flat"

[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = 100.0
channels = ["HH", "HV"]

[radar.waveform]
kind = "lfm"
bandwidth_hz = 60e6
pulse_s = 0.333e-6

[radar.window]
samples = 4096
start_us = 0.0

[[platform]]
name = "aircraft"
track = { kind = "straight", position_m = [0, 0, 1000], velocity_mps = [0, 80, 0] }

[[target]]
name = "buoy"
position_m = [3000, 0, 0]
rcs_dbsm = 30

[[transmitter]]
name = "tx"
platform = "aircraft"
power_w = 1000.0
antenna = { kind = "isotropic" }

[[receiver]]
name = "rx"
platform = "aircraft"
antenna = { kind = "rectangle", width_m = 0.02, height_m = 0.02 }
pointing = { kind = "fixed", yaw_deg = 90 }

[[sink]]
kind = "null"
"#;

#[test]
fn antennas_used_where_their_bases_say_little_are_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), SCENARIO).unwrap();
    let warnings = |settings: &[&str]| {
        let mut arguments = vec!["check", "a.toml"];
        arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
        let ended = nereus(folder.path(), &arguments);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stderr.lines().filter(|line| line.contains("is used")).map(str::to_owned).collect::<String>()
    };
    // Abeam of the isotropic antenna, on the boresight of the other.
    assert_eq!(warnings(&[]), "");
    // Ahead of an antenna that looks abeam: 71.6 degrees off, less as it comes nearer.
    let off = warnings(&["target.0.position_m=[1000, 3000, 1000]"]);
    assert!(
        off.contains("\"rx\" is used 72 degrees off its boresight at pulse 0 (towards target \"buoy\")"),
        "{off}"
    );
    assert!(!off.contains("isotropic"), "{off}");
    // A large aperture has no more than side lobes there.
    let beside = ["target.0.position_m=[1000, 3000, 1000]", "receiver.0.antenna.width_m=1"];
    assert_eq!(warnings(&beside), "");
    // Beneath: 100 m beside the nadir of 1000 m is 5.7 degrees.
    let beneath = warnings(&["target.0.position_m=[100, 0, 0]", "receiver.0.pointing.pitch_deg=-80"]);
    assert!(
        beneath.contains("isotropic antenna \"tx\" is used 5.7 degrees from the vertical at pulse 0"),
        "{beneath}"
    );
    assert!(!beneath.contains("\"rx\""), "{beneath}");
}
