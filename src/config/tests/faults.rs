//! What a scenario is refused for, word by word.

use super::*;
use crate::scene::target::Swerling;

#[test]
fn inconsistent_settings() {
    insta::assert_snapshot!(faults_of(&[("radar.waveform.bandwidth_hz", "100.1e6")]), @r#"radar.waveform.bandwidth_hz: 1.001e8 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 1e8 Hz"#);
    insta::assert_snapshot!(faults_of(&[("radar.window.samples", "33")]), @r#"radar.window.samples: 33 samples (3.3e-7 s) are shorter than the pulse (3.33e-7 s); allowed: at least 34"#);
    assert!(coastal_with(&[("radar.window.samples", "34")]).is_ok());
    insta::assert_snapshot!(faults_of(&[("radar.pri_us", "[1000, 2000]")]), @r#"radar.pri_us: prf_hz, pri_us exclude each other; allowed: one of them"#);
    insta::assert_snapshot!(faults_of(&[("radar.prf_hz", "-222")]), @r#"radar.prf_hz: -222 is out of range; allowed: a number from 0.001 to 1e9 Hz"#);
    insta::assert_snapshot!(faults_of(&[("radar.prf_hz", "nan"), ("radar.carrier_hz", "inf"), ("target.0.position_m", "[0, nan, 0]")]), @r#"
radar.carrier_hz: inf is out of range; allowed: a number from 1e6 to 1e12 Hz
radar.prf_hz: nan is out of range; allowed: a number from 0.001 to 1e9 Hz
target.0.position_m: entry 1, NaN, is out of range; allowed: a list of 3 numbers from -1e8 to 1e8 m
"#);
    insta::assert_snapshot!(faults_of(&[("receiver.0.platform", "ship")]), @r#"receiver.0.platform: there is no platform "ship"; allowed: coast, aircraft"#);
    insta::assert_snapshot!(faults_of(&[("receiver.0.name", "tx")]), @r#"receiver.0.name: "tx" is already the name of another antenna; allowed: unique names"#);
    insta::assert_snapshot!(faults_of(&[("target.1.name", "sphere")]), @r#"target.1.name: "sphere" is already the name of another target; allowed: unique names"#);
    insta::assert_snapshot!(faults_of(&[("platform.1.name", "coast")]), @r#"
transmitter.0.pointing.platform: there is no platform "aircraft"; allowed: coast
receiver.0.platform: there is no platform "aircraft"; allowed: coast
receiver.0.pointing.platform: there is no platform "aircraft"; allowed: coast
platform.1.name: "coast" is already the name of another platform; allowed: unique names
"#);
    insta::assert_snapshot!(faults_of(&[("radar.channels", "['HH', 'HH']")]), @r#"radar.channels: "HH" is already the name of another channel; allowed: unique names"#);
    insta::assert_snapshot!(faults_of(&[("radar.channel", "[{ polarisation = 'HH', receiver = 'ry' }]")]), @r#"
radar.channel: channels, channel exclude each other; allowed: one of them
radar.channel.0.receiver: there is no receiver "ry"; allowed: rx
"#);
    insta::assert_snapshot!(faults_of(&[("radar.tx_polarisation", "alternating"), ("radar.tx_sequence", "['V']")]), @r#"
radar.tx_sequence: channel "HH" needs transmit polarisation H, which tx_sequence never sends; allowed: a sequence with H
radar.tx_sequence: channel "VH" needs transmit polarisation H, which tx_sequence never sends; allowed: a sequence with H
"#);
    insta::assert_snapshot!(faults_of(&[("target.0", "{ lat_deg = 1, lon_deg = 2, rcs_m2 = 1 }")]), @r#"target.0.lat_deg: a geodetic position needs scene.origin_lat_deg, origin_lon_deg and origin_h_m; allowed here: position_m"#);
    insta::assert_snapshot!(faults_of(&[("scene.origin_lat_deg", "50"), ("scene.earth_radius_factor", "1.33")]), @r#"
scene.origin_lat_deg: stands alone; allowed: origin_lat_deg, origin_lon_deg, origin_h_m together, or none of them
scene.earth_radius_factor: not allowed here (the earth is flat)
"#);
    insta::assert_snapshot!(faults_of(&[("radar.window.samples", "16777216"), ("radar.channels", "['HH','HV','VH','VV','RR','RL','LR','LL','HR']")]), @r#"radar.window: one pulse takes 1207959552 bytes (9 channels of 16777216 samples); allowed: at most 16777216"#);
    insta::assert_snapshot!(faults_of(&[("target_grid", "[{ position_m = [0,0,0], count = [1000, 1000], spacing_m = [1, 1], rcs_m2 = 1 }]")]), @r#"target_grid.0.count: 1000002 targets; allowed: at most 100000"#);
    insta::assert_snapshot!(faults_of(&[("target_grid", "[{ position_m = [0,0,0], count = [1.5, 1], spacing_m = [1, 1], rcs_m2 = 1 }]")]), @r#"target_grid.0.count: [1.5, 1.0] is not allowed; allowed: two whole numbers from 1 to 1000"#);
    insta::assert_snapshot!(faults_of(&[("platform.1.track", "{ kind = 'csv', path = 'tracks/north_sea_texel.csv' }")]), @r#"
scene.start_utc: is missing; required with a recorded track: a UTC time within the recording
platform.1.track.path: holds latitudes and longitudes, which need scene.origin_lat_deg, origin_lon_deg and origin_h_m; allowed without them: a CSV file of x_m, y_m, z_m
platform.1.track.datum: is missing; required: "ellipsoid", "msl", "barometric"
"#);
    insta::assert_snapshot!(faults_of(&[("platform.0.track.yaw", "3"), ("platform.0.track.velocity_mps", "[1,2,3]")]), @r#"
platform.0.track.yaw: unknown key; did you mean yaw_deg, in deg?
platform.0.track.velocity_mps: not allowed here (kind = "fixed")
"#);
    insta::assert_snapshot!(faults_of(&[("sink", "[{ kind = 'plain', path = 'x' }, { kind = 'plain', path = 'x' }]")]), @r#"sink.1.path: "x" is already the name of another sink; allowed: unique names"#);
    insta::assert_snapshot!(faults_of(&[("sink", "[{ kind = 'vita49', address = 'receiver', bind = '127.0.0.1:0', mtu_bytes = 500, path = 'x' }]")]), @r#"
sink.0.address: "receiver" is not allowed; allowed: host:port with a port from 1 to 65535, such as "127.0.0.1:4991" or "[::1]:4991"
sink.0.mtu_bytes: 500 is out of range; allowed: a whole number from 576 to 65535
sink.0.bind: "127.0.0.1:0" is not allowed; allowed: host:port with a port from 1 to 65535, such as "127.0.0.1:4991" or "[::1]:4991"
sink.0.path: not allowed here (kind = "vita49")
"#);
    insta::assert_snapshot!(faults_of(&[("sink", "[{ kind = 'zmq', bind = 'x', messages = 'sample', buffer_pulses = 0, address = 'x' }]")]), @r#"
sink.0.bind: "x" is not allowed; allowed: host:port with a port from 1 to 65535, such as "127.0.0.1:4991" or "[::1]:4991"
sink.0.messages: "sample" is not allowed; allowed: "samples", "multipart"
sink.0.buffer_pulses: 0 is out of range; allowed: a whole number from 1 to 65536
sink.0.address: not allowed here (kind = "zmq")
"#);
    insta::assert_snapshot!(faults_of(&[("sink", "[{ kind = 'zmq', bind = '127.0.0.1:65533' }, { kind = 'zmqq' }, { kind = 'shm', service = 'a/b', subscribers = 0, subscriber = 2, bind = 'x' }]")]), @r#"
sink.0.bind: "127.0.0.1:65533" is the first of 4 ports, one per channel; allowed: a first port of at most 65532
sink.1.kind: "zmqq" is not allowed; allowed: "hdf5", "plain", "crsd", "vita49", "asterix", "shm", "zmq", "nav", "targets", "null"
sink.2.service: "a/b" is not allowed; allowed: a name of 1 to 64 letters, digits, '_', '-', '.', not starting with '.'
sink.2.subscribers: 0 is out of range; allowed: a whole number from 1 to 64
sink.2.subscriber: unknown key; did you mean subscribers?
sink.2.bind: not allowed here (kind = "shm")
"#);
    insta::assert_snapshot!(faults_of(&[("platform", "[]"), ("sink", "3"), ("stream", "'fast'")]), @r#"
transmitter.0.platform: there is no platform "coast"; allowed: none are defined
transmitter.0.pointing.platform: there is no platform "aircraft"; allowed: none are defined
receiver.0.platform: there is no platform "aircraft"; allowed: none are defined
receiver.0.pointing.platform: there is no platform "aircraft"; allowed: none are defined
platform: is missing; required: an array of tables [[platform]]
stream: "fast" is not allowed; allowed: a table [stream]
sink: 3 is not allowed; allowed: an array of tables [[sink]]
"#);
    insta::assert_snapshot!(faults_of(&[("receiver.0.name", "a/b"), ("transmitter.0.name", "..")]), @r#"
transmitter.0.name: ".." is not allowed; allowed: a name of 1 to 64 letters, digits, '_', '-', '.', not starting with '.'
receiver.0.name: "a/b" is not allowed; allowed: a name of 1 to 64 letters, digits, '_', '-', '.', not starting with '.'
"#);
    insta::assert_snapshot!(faults_of(&[("", "1"), ("a..b", "2"), ("scene.seed.x", "1"), ("scene.seed", "-1")]), @r#"
no such entry: a key is names joined by dots, such as radar.prf_hz, target.0.rcs_m2 or sink.+
a..b: no such entry: a key is names joined by dots, such as radar.prf_hz, target.0.rcs_m2 or sink.+
scene.seed.x: no such entry: scene.seed is not a table
scene.seed: -1 is out of range; allowed: a whole number from 0 to 2^64 - 1
"#);
}

#[test]
fn fluctuations_of_targets() {
    insta::assert_snapshot!(faults_of(&[("target.0.swerling", "5"), ("target.1.swerling", "1")]), @r#"
target.1.swerling_scan_s: is missing; required: a number above 0, up to 1e7 s
target.0.swerling: 5 is out of range; allowed: a whole number from 0 to 4
"#);
    insta::assert_snapshot!(faults_of(&[("target.0.swerling", "2"), ("target.0.swerling_scan_s", "1"), ("target.1.swerling_scan_s", "0")]), @r#"
target.0.swerling_scan_s: not allowed here (only swerling 1 and 3 are constant over a scan)
target.1.swerling_scan_s: 0 is out of range; allowed: a number above 0, up to 1e7 s
target.1.swerling_scan_s: not allowed here (only swerling 1 and 3 are constant over a scan)
"#);
    let run = coastal_with(&[("target.0.swerling", "3"), ("target.0.swerling_scan_s", "0.5")]).unwrap();
    assert_eq!(run.scene.targets[0].swerling, Swerling::Case3 { scan_s: 0.5 });
    assert_eq!(run.scene.targets[1].swerling, Swerling::Steady);
}

#[test]
fn aspects_of_targets() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    insta::assert_snapshot!(faults_of(&[("target.1.heading_deg", "10"), ("target.0.rcs_floor_dbsm", "-20")]), @r#"
target.0.rcs_floor_dbsm: not allowed here (the target has no rcs_csv)
target.1.heading_deg: not allowed here (the target has no rcs_csv)
"#);
    let table = format!("[{{ position_m = [0, 0, 0], rcs_csv = '{file}' }}]");
    insta::assert_snapshot!(faults_of(&[("target", &table)]), @"target.0.heading_deg: is missing; required: with rcs_csv, of a target at rest: a number from -360 to 360 deg");
    let table = format!("[{{ position_m = [0, 0, 0], velocity_mps = [3, 3, 1], rcs_csv = '{file}' }}]");
    let run = coastal_with(&[("target", &table)]).unwrap();
    let aspect = run.scene.targets[0].aspect.clone().unwrap();
    assert_eq!((aspect.heading_rad, aspect.floor_dbsm), (Some(std::f64::consts::FRAC_PI_4), -300.0));
}

#[test]
fn targets_at_sea() {
    insta::assert_snapshot!(faults_of(&[("target.0.floating", "true"), ("target.1.waterline_m", "3"), ("target.1.multipath", "true")]), @r#"
target.0.floating: not allowed here (there is no [sea] to float on)
target.1.waterline_m: not allowed here (floating = false)
target.1.multipath: not allowed here (there is no [sea] that reflects)
"#);
    let target = "{ position_m = [0, 0, 1], velocity_mps = [0, 0, 1], rcs_m2 = 1, floating = true }";
    let sea = ("sea", "{ wind_mps = 8.0, wind_height_m = 10.0, wind_towards_deg = 0.0 }");
    let patch = [("scene.patch_size_m", "[64, 64]"), ("scene.facet_m", "1")];
    insta::assert_snapshot!(faults_of(&[patch[0], patch[1], sea, ("target", &format!("[{target}]"))]), @"target.0.velocity_mps: a floating target rises with the sea alone; allowed: [east, north, 0]");
    let many = format!("[{}]", vec![target.replace("0, 1]", "0, 0]"); 65].join(", "));
    insta::assert_snapshot!(faults_of(&[patch[0], patch[1], sea, ("target", &many)]), @"65 targets that float; allowed: at most 64");
    let choppy =
        ("sea", "{ wind_mps = 8.0, wind_height_m = 10.0, wind_towards_deg = 0.0, waves = 'choppy' }");
    let target = target.replace("0, 1], rcs", "0, 0], rcs");
    insta::assert_snapshot!(faults_of(&[patch[0], patch[1], choppy, ("target", &format!("[{target}]"))]), @r#"target.0.floating: a floating target rides on linear waves, apart from the choppy ones around it; allowed: sea.waves = "linear", or floating = false"#);
    let choppy = (
        "sea",
        "{ wind_mps = 8.0, wind_towards_deg = 0.0, waves = 'choppy', depth_m = 20, scattering = { displacement = false } }",
    );
    insta::assert_snapshot!(faults_of(&[patch[0], patch[1], choppy]), @r#"
sea.depth_m: not allowed here (waves = "choppy", which is for deep water only)
sea.waves: crests are sharp because facets follow the horizontal motion; allowed: waves = "linear", or scattering.displacement = true
"#);
    let wrong = ("sea", "{ wind_mps = 8.0, wind_towards_deg = 0.0, waves = 'chopy' }");
    insta::assert_snapshot!(faults_of(&[patch[0], patch[1], wrong]), @r#"sea.waves: "chopy" is not allowed; allowed: "linear", "choppy""#);
}

#[test]
fn all_faults_of_a_file_at_once() {
    let text = r#"[scene]
origin_lat_deg = 95
duration = 10
seed = "x"
start_utc = "yesterday"

[radar]
carrier_ghz = 10
sample_rate_hz = 50e6
prf_hz = -222
pri_us = [1000]
channels = ["HH", "XX"]
noise_figure_db = nan

[radar.waveform]
kind = "lfm"
bandwidth_hz = 60e6
pulse_s = 20e-6
path = "a"

[radar.window]
samples = 0

[[platform]]
name = "coast"
track = { kind = "fixed", lat_deg = 1, lon_deg = 2 }

[[transmitter]]
name = "tx"
platform = "cost"
power_w = "1 kW"
antenna = { kind = "rect", width_m = 1 }

[[target]]
position_m = [0, 0]
rcs_m2 = 1
rcs_dbsm = 1

[stream]
polcy = "stop"
prf_hz = 3

[[sink]]
kind = "plain"
"#;
    let error =
        parse(text, Path::new("scenes/bad.toml"), &settings(&[("radar.adc.bits", "99")])).unwrap_err();
    insta::assert_snapshot!(error.to_string(), @r#"
scenes/bad.toml:1:1: receiver: is missing; required: an array of tables [[receiver]]
scenes/bad.toml:1:2: scene.duration_s: is missing; required: a number above 0, up to 1e7 s
scenes/bad.toml:2:18: scene.origin_lat_deg: 95 is out of range; allowed: a number from -90 to 90 deg
scenes/bad.toml:2:18: scene.origin_lat_deg: stands alone; allowed: origin_lat_deg, origin_lon_deg, origin_h_m together, or none of them
scenes/bad.toml:3:1: scene.duration: unknown key; did you mean duration_s, in s?
scenes/bad.toml:4:8: scene.seed: "x" is not allowed; allowed: a whole number from 0 to 2^64 - 1
scenes/bad.toml:5:13: scene.start_utc: "yesterday" is not allowed; allowed: a UTC time from 1970 to 2200 such as "2018-05-30T20:15:00.5Z", or "now" without recorded tracks, logs and live navigation, or "live" with live navigation and no recording
scenes/bad.toml:7:2: radar.carrier_hz: is missing; required: a number from 1e6 to 1e12 Hz
scenes/bad.toml:8:1: radar.carrier_ghz: unknown key; did you mean carrier_hz, in Hz?
scenes/bad.toml:10:10: radar.prf_hz: -222 is out of range; allowed: a number from 0.001 to 1e9 Hz
scenes/bad.toml:11:10: radar.pri_us: prf_hz, pri_us exclude each other; allowed: one of them
scenes/bad.toml:12:12: radar.channels: entry 1, "XX", is not allowed; allowed: a list of 1 to 16 texts, each receive then transmit polarisation, each H, V, R or L
scenes/bad.toml:13:19: radar.noise_figure_db: nan is out of range; allowed: a number from 0 to 100 dB
scenes/bad.toml:17:16: radar.waveform.bandwidth_hz: 6e7 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 5e7 Hz
scenes/bad.toml:19:1: radar.waveform.path: not allowed here (kind = "lfm")
scenes/bad.toml:21:8: radar.window: one of start_us, follow is required
scenes/bad.toml:22:11: radar.window.samples: 0 is out of range; allowed: a whole number from 1 to 16777216
scenes/bad.toml:26:1: platform.0.track.h_m: is missing; required: a number from -11000 to 1e8 m
scenes/bad.toml:26:1: platform.0.track.datum: is missing; required: "ellipsoid", "msl"
scenes/bad.toml:30:12: transmitter.0.platform: there is no platform "cost"; allowed: coast
scenes/bad.toml:31:11: transmitter.0.power_w: "1 kW" is not allowed; allowed: a number above 0, up to 1e12 W
scenes/bad.toml:32:20: transmitter.0.antenna.kind: "rect" is not allowed; allowed: "isotropic", "rectangle", "ellipse", "circle", "file"
scenes/bad.toml:34:1: target.0: rcs_m2, rcs_dbsm, rcs_csv, (s_vv, s_vh, s_hv, s_hh) exclude each other; allowed: one of them
scenes/bad.toml:35:14: target.0.position_m: [0, 0] is not allowed; allowed: a list of 3 numbers from -1e8 to 1e8 m
scenes/bad.toml:40:1: stream.polcy: unknown key; did you mean policy?
scenes/bad.toml:41:1: stream.prf_hz: unknown key; it belongs to [radar]
scenes/bad.toml:43:1: sink.0.path: is missing; required: a path (relative to the working directory)
--set: radar.adc.bits: 99 is out of range; allowed: a whole number from 1 to 16
--set: radar.adc.full_scale_dbw: is missing; required: a number from -400 to 200 dBW
scenes/bad.toml: 29 faults
"#);
}

#[test]
fn faults_of_the_language_stand_with_the_others() {
    let text = "a = = 1\n[scene]\nduration_s = 1\nduration_s = 2\nseed = -1\nb = [1,\n";
    let error = parse(text, Path::new("bad.toml"), &[]).unwrap_err();
    insta::assert_snapshot!(error.to_string(), @r#"
bad.toml:1:5: not valid TOML: extra `=`, expected nothing (at =)
bad.toml:1:7: not valid TOML: unexpected key or value, expected newline, `#`
bad.toml:4:1: not valid TOML: duplicate key (at duration_s)
bad.toml:5:8: scene.seed: -1 is out of range; allowed: a whole number from 0 to 2^64 - 1
bad.toml:6:8: not valid TOML: unclosed array, expected `]`
bad.toml: 5 faults
"#);
}
