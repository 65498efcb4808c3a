//! The list of keys, the reader and the manual say the same; faults are complete; no text makes it panic.

use std::collections::BTreeSet;
use std::path::Path;

use num_complex::Complex64;

use super::*;
use crate::echo::Asked;
use crate::frames::{Geodetic, SceneFrame};
use crate::nav::TrackSource;
use crate::nav::{AttitudeSource, Place, Smoothing, VerticalDatum};
use crate::scene::radar::{Aim, AimFrom, Gate, Pattern, Pointing, Polarisation, TxPolarisation};

mod ais;
mod hostile;
mod receivers;
mod scanning;
mod refused;
mod changes;
mod continuous;
mod live;
mod names;
mod navigation;
mod emitters;
mod errors;
mod far_sea;
mod faults;
mod front_end;
mod sea;
mod sea_defaults;
mod ship;
mod swell;
mod video;
mod waveforms;

/// An emitter with every key but one of those of its train.
const EMITTER: &str = concat!(
    "[{ name = 'a', platform = 'coast', power_w = 1, prf_hz = 100, antenna = { kind = 'isotropic' }, ",
    "waveform = { kind = 'lfm', bandwidth_hz = 1e6, pulse_s = 1e-6 } }]"
);
const COASTAL: &str = include_str!("../../configs/coastal.toml");
const QUICKSTART: &str = include_str!("../../configs/quickstart.toml");
const CALIBRATION: &str = include_str!("../../configs/calibration.toml");
const MONOSTATIC: &str = include_str!("../../configs/monostatic.toml");
const SPACEBORNE: &str = include_str!("../../configs/spaceborne.toml");

fn in_configs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/test.toml")
}

fn settings(list: &[(&str, &str)]) -> Vec<(String, String)> {
    list.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
}

fn coastal_with(list: &[(&str, &str)]) -> Result<Run, ConfigError> {
    parse(COASTAL, &in_configs(), &settings(list))
}

/// The faults of the coastal scenario with overrides, without the path.
fn faults_of(list: &[(&str, &str)]) -> String {
    let error = coastal_with(list).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

/// Before: a cap on its nodes, with which -56 dB were predicted, of the -60 dB that it asks.
#[test]
fn the_quickstart_leaves_the_fast_echo_its_choice() {
    let run = parse(QUICKSTART, &in_configs(), &[]).unwrap();
    assert_eq!(run.fidelity, Fidelity::Fast(Asked::default()));
}

#[test]
fn every_listed_key_is_read_and_every_read_key_is_listed() {
    let mut asked: BTreeSet<(&str, &str)> = BTreeSet::new();
    let track = "platform.0.track";
    let variants: &[(&str, &[(&str, &str)])] = &[
        (QUICKSTART, &[]),
        (CALIBRATION, &[]),
        (COASTAL, &[]),
        (MONOSTATIC, &[]),
        (SPACEBORNE, &[]),
        (COASTAL, &[("radar.waveform", "{ kind = 'file', path = 'README.md', rate_hz = 1e8 }")]),
        (COASTAL, &[("radar.channel", "[{ polarisation = 'HH', name = 'a' }]")]),
        (COASTAL, &[("receiver.0.antenna", "{ kind = 'isotropic', gain_dbi = 3 }")]),
        (COASTAL, &[("sink.0", "{ kind = 'vita49', address = 'localhost:4991', bind = '127.0.0.1:4000' }")]),
        (COASTAL, &[("sink.0", "{ kind = 'shm' }")]),
        (COASTAL, &[("sink.0", "{ kind = 'zmq', bind = '127.0.0.1:4000', buffer_pulses = 9 }")]),
        (COASTAL, &[("receiver.0.antenna", "{ kind = 'circle', diameter_m = 3 }")]),
        (COASTAL, &[("receiver.0.antenna", "{ kind = 'file', path = 'README.md', floor_dbi = -40 }")]),
        (COASTAL, &[(track, "{ kind = 'sbet', path = 'README.md', gps_week = 2000 }")]),
        (COASTAL, &[("sink", "[{ kind = 'nav', device = 'file:x' }]")]),
        (COASTAL, &[("stream.pacer_core", "1"), ("stream.lock_memory", "true")]),
        (COASTAL, &[(track, "{ kind = 'nmea', path = 'README.md', attitude = 'constant' }")]),
        (SPACEBORNE, &[("radar.window.follow", "{ kind = 'at', lat_deg = 1, lon_deg = 2, lead_us = 1 }")]),
        (SPACEBORNE, &[("radar.window.follow", "{ kind = 'at', position_m = [0, 0, 0], lead_us = 1 }")]),
        (COASTAL, &[("receiver.0.window", "{ start_us = 3 }"), ("receiver.0.hears", "['tower']")]),
        (
            COASTAL,
            &[(
                "receiver.0.array",
                "{ elements = 2, spacing_m = [0, 1, 0], gains_db = [0, 1], phases_deg = [0, 1] }",
            )],
        ),
        (COASTAL, &[("emitter", EMITTER)]),
        (
            COASTAL,
            &[("receiver.0.window", "{ follow = { kind = 'at', position_m = [0, 0, 0], lead_us = 1 } }")],
        ),
        (COASTAL, &[("receiver.0.pointing", "{ kind = 'at', lat_deg = 1, lon_deg = 2 }")]),
        (
            COASTAL,
            &[
                ("target", "[{ lat_deg = 1, lon_deg = 2 }]"),
                ("target_grid", "[{ lat_deg = 1, lon_deg = 2 }]"),
            ],
        ),
    ];
    let mut seas = sea::variants();
    seas.extend(ship::variants());
    seas.extend(ais::variants());
    seas.extend(errors::variants());
    seas.extend(live::variants());
    seas.extend(changes::variants());
    seas.extend(waveforms::variants());
    seas.extend(scanning::variants());
    seas.extend(front_end::variants());
    seas.extend(video::variants());
    let seas = seas.iter().map(|(text, overrides)| (*text, &overrides[..]));
    for (text, overrides) in variants.iter().copied().chain(seas) {
        asked.extend(read(text, &in_configs(), &settings(overrides), Files::Required).asked);
    }
    let listed: BTreeSet<(&str, &str)> = keys::TABLES
        .iter()
        .flat_map(|table| table.keys.iter().map(|key| (table.heading, key.name)))
        .collect();
    assert_eq!(
        listed.difference(&asked).collect::<Vec<_>>(),
        Vec::<&(&str, &str)>::new(),
        "listed, never read"
    );
    assert_eq!(
        asked.difference(&listed).collect::<Vec<_>>(),
        Vec::<&(&str, &str)>::new(),
        "read, not listed"
    );
}

#[test]
fn the_manual_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scenario.md");
    let written = std::fs::read_to_string(path).unwrap();
    assert!(written == manual::page(), "run `nereus new keys > docs/scenario.md`");
}

#[test]
fn names_of_keys_bear_their_unit() {
    let endings = [
        ("deg", "_deg"),
        ("m", "_m"),
        ("s", "_s"),
        ("Hz", "_hz"),
        ("us", "_us"),
        ("ms", "_ms"),
        ("dB", "_db"),
        ("dB/km", "_db_per_km"),
        ("mm/h", "_mmph"),
        ("dBW", "_dbw"),
        ("dBi", "_dbi"),
        ("W", "_w"),
        ("m/s", "_mps"),
        ("m^2", "_m2"),
        ("dBsm", "_dbsm"),
        ("m/s^2", "_mps2"),
        ("C", "_c"),
        ("psu", "_psu"),
        ("N/m", "_npm"),
        ("rad", "_rad"),
        ("rad/m", "_radpm"),
        ("m/sqrt(s)", "_m_per_root_s"),
        ("m/s/sqrt(s)", "_mps_per_root_s"),
        ("deg/sqrt(s)", "_deg_per_root_s"),
        ("deg/s", "_degps"),
        ("1/min", "rpm"),
        ("1/s", "_per_s"),
        ("1/h", "per_hour"),
        ("1/day", "_per_day"),
    ];
    for table in keys::TABLES {
        for key in table.keys.iter().filter(|key| !key.kind.unit().is_empty()) {
            let unit = key.kind.unit();
            let ending = endings.iter().find(|(u, _)| *u == unit).unwrap_or_else(|| panic!("unit {unit}")).1;
            // The elements of a scattering matrix keep their name in the trade.
            assert!(
                key.name.ends_with(ending) || key.name.starts_with("s_"),
                "{} {}",
                table.heading,
                key.name
            );
        }
    }
}

#[test]
fn defaults_lie_in_their_ranges() {
    for table in keys::TABLES {
        for key in table.keys {
            if let (keys::Kind::Number { min, max, above, .. }, keys::Absent::Number(value)) =
                (&key.kind, &key.absent)
            {
                assert!((*min..=*max).contains(value) && !(*above && value == min), "{}", key.name);
            }
            if let (keys::Kind::Choice(words), keys::Absent::Word(word)) = (&key.kind, &key.absent) {
                assert!(words().contains(word), "{}", key.name);
            }
        }
    }
}

#[test]
fn the_scenario_of_a_recording_is_read_without_its_files() {
    let beside_it = parse(CALIBRATION, &in_configs(), &[]).unwrap();
    assert!(parse(CALIBRATION, Path::new("elsewhere/calibration.toml"), &[]).is_err());
    let read = recorded(CALIBRATION).unwrap();
    assert_eq!((&read.scene, &read.clocks), (&beside_it.scene, &beside_it.clocks));
    // What is wrong with the text is a fault all the same.
    let error = recorded(&CALIBRATION.replace("carrier_hz", "carrier")).unwrap_err().to_string();
    assert!(error.contains("scenario in the recording:") && error.contains("carrier_hz"), "{error}");
}

#[test]
fn a_recorded_flight_is_resolved() {
    let run = parse(CALIBRATION, &in_configs(), &[]).unwrap();
    assert_eq!(run.scene.pulses, 2220);
    assert_eq!(run.scene.start.to_string(), "2018-05-30T18:38:30.000000Z");
    assert_eq!(run.scene.platforms, ["coast", "aircraft"]);
    assert_eq!(run.scene.targets.len(), 25);
    assert_eq!(run.text, CALIBRATION);
    let TrackSource::Fixed { place: Place::Geodetic(mast), .. } = run.nav[0].truth else { panic!() };
    // 50 m above mean sea level, which lies 42 m above the ellipsoid.
    assert_eq!(mast.h_m, 92.0);
    let TrackSource::File(flight) = &run.nav[1].truth else { panic!() };
    assert_eq!(flight.datum, VerticalDatum::Barometric { offset_m: 0.0 });
    assert_eq!(flight.undulation_m, 42.0);
    assert_eq!(flight.attitude, AttitudeSource::CoordinatedTurn);
    assert!(matches!(flight.smoothing, Smoothing::Rts { max_acceleration_mps2: 2.9, .. }));
    assert!(flight.path.is_file());
    let names: Vec<&str> = run.scene.radar.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["HH", "HV", "VH", "VV"]);
    let hv = &run.scene.radar.channels[1];
    assert_eq!((hv.rx, hv.tx), (Polarisation::H, Polarisation::V));
    assert_eq!(run.scene.radar.receivers[0].antenna.lever_arm.to_array(), [2.0, -1.0, 1.5]);
    let Gate::Follow { aim, lead_s, aim_from } = &run.scene.radar.window.gate else { panic!() };
    assert_eq!(*aim, Aim::Beside { platform: 1, along_m: 0.0, across_m: -6600.0 });
    assert_eq!((*lead_s, *aim_from), (2e-6, AimFrom::Reported));
    // Latency 0.5 s at 222 Hz and the pulse under way.
    assert_eq!(run.stream.ring_slots, 112);
    assert_eq!(run.sinks[0].queue_pulses, 444);
}

#[test]
fn angles_become_radians_and_other_settings_arrive() {
    let run = parse(MONOSTATIC, &in_configs(), &[]).unwrap();
    let radar = &run.scene.radar;
    let Pointing::Fixed { yaw_rad, pitch_rad, .. } = radar.transmitters[0].antenna.pointing else { panic!() };
    assert_eq!((yaw_rad, pitch_rad), (90f64.to_radians(), (-45f64).to_radians()));
    let Pointing::At { bias_rad, lag_s, .. } = radar.receivers[0].antenna.pointing else { panic!() };
    assert_eq!((bias_rad, lag_s), ([0.1f64.to_radians(), 0.0], 0.02));
    assert_eq!(radar.receivers[0].antenna.pattern, Pattern::Ellipse { width_m: 0.6, height_m: 0.1 });
    assert_eq!(radar.tx_polarisation, TxPolarisation::Alternating(vec![Polarisation::V, Polarisation::H]));
    let adc = radar.adc.unwrap();
    // -85 dBW of squared amplitude.
    assert!((adc.full_scale.powi(2).log10() * 10.0 + 85.0).abs() < 1e-12);
    assert_eq!(adc.bits, 12);
    let run =
        coastal_with(&[("radar.tx_polarisation", "alternating"), ("radar.tx_sequence", "['H','H','V']")])
            .unwrap();
    assert_eq!(run.scene.radar.tx_polarisation.of_pulse(5), Some(Polarisation::V));
}

#[test]
fn back_scatter_alignment_is_converted() {
    let run = parse(COASTAL, &in_configs(), &[]).unwrap();
    let [[vv, vh], [hv, hh]] = run.scene.targets[1].scattering;
    // Reciprocal in back-scatter alignment: symmetric; in forward-scatter alignment: S_vh = -S_hv.
    assert_eq!(vv, Complex64::new(12.0, 0.0));
    assert_eq!(hh, Complex64::new(-10.0, -2.0));
    assert_eq!(vh, Complex64::new(1.5, -0.5));
    assert_eq!(hv, -vh);
    // A sphere is the unit matrix there.
    let set = settings(&[
        ("target.1.s_vv", "[10,0]"),
        ("target.1.s_hh", "[10,0]"),
        ("target.1.s_vh", "[0,0]"),
        ("target.1.s_hv", "[0,0]"),
        ("target.0.rcs_dbsm", "20"),
    ]);
    let run = parse(COASTAL, &in_configs(), &set).unwrap();
    // 20 dBsm by way of powf: a few ulp.
    for (row, other) in run.scene.targets[0].scattering.iter().zip(&run.scene.targets[1].scattering) {
        for (a, b) in row.iter().zip(other) {
            assert!((a - b).norm() < 1e-13, "{a} {b}");
        }
    }
}

#[test]
fn heights_are_above_the_sea_that_curves() {
    let origin =
        [("scene.origin_lat_deg", "53"), ("scene.origin_lon_deg", "4.5"), ("scene.origin_h_m", "42")];
    let far = [
        ("target.0.position_m", "[30000, 40000, 5]"),
        ("target.1", "{ lat_deg = 53.2, lon_deg = 4.9, height_m = 7, rcs_m2 = 1 }"),
    ];
    let run = coastal_with(&[origin.as_slice(), &far].concat()).unwrap();
    let drop_m = 50e3f64.powi(2) / (2.0 * 6_371_000.0);
    assert!((run.scene.targets[0].position.to_array()[2] - (5.0 - drop_m)).abs() < 1e-9);
    let [x, y, z] = run.scene.targets[1].position.to_array();
    assert!((z - (7.0 - (x * x + y * y) / (2.0 * 6_371_000.0))).abs() < 1e-9);
    // On the true ellipsoid, 7 m above the sea, the point is the same within the difference between
    // sphere and ellipsoid (radii of curvature 6376 to 6392 km at 53 degrees: below 0.5 % of the drop).
    let frame = SceneFrame::at(Geodetic::from_deg(53.0, 4.5, 42.0), run.scene.frame.earth());
    let [tx, ty, tz] = frame.from_geodetic(Geodetic::from_deg(53.2, 4.9, 49.0)).unwrap().to_array();
    assert!((x - tx).abs() < 0.1 && (y - ty).abs() < 0.1, "{x} {tx} {y} {ty}");
    assert!((z - tz).abs() < 0.005 * (7.0 - z), "{z} {tz}");
    // The same in a flat scene.
    let flat = coastal_with(&[origin.as_slice(), &far, &[("scene.earth", "flat")]].concat()).unwrap();
    assert_eq!(flat.scene.targets[0].position.to_array()[2], 5.0);
    assert_eq!(flat.scene.targets[1].position.to_array()[2], 7.0);
}

#[test]
fn a_grid_is_centred() {
    let grid =
        "[{ name = 'g', position_m = [100, 200, 3], count = [3, 2], spacing_m = [10, 20], rcs_m2 = 4 }]";
    let run = coastal_with(&[("target_grid", grid)]).unwrap();
    let grid = &run.scene.targets[2..];
    let names: Vec<&str> = grid.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["g-0-0", "g-0-1", "g-1-0", "g-1-1", "g-2-0", "g-2-1"]);
    assert_eq!(grid[0].position.to_array(), [90.0, 190.0, 3.0]);
    assert_eq!(grid[5].position.to_array(), [110.0, 210.0, 3.0]);
}

#[test]
fn overrides_are_recorded_as_a_scenario_that_reads_the_same() {
    for text in [COASTAL, CALIBRATION, MONOSTATIC, SPACEBORNE] {
        let set = settings(&[
            ("radar.prf_hz", "333.25"),
            ("stream.pace", "fast"),
            ("receiver.0.lever_arm_m.1", "0.125"),
        ]);
        let with_arm =
            set.iter().filter(|(key, _)| text.contains("lever_arm_m") || !key.starts_with("receiver"));
        let set: Vec<(String, String)> = with_arm.cloned().collect();
        let run = parse(text, &in_configs(), &set).unwrap();
        assert_eq!(run.scene.radar.emissions.mean_prf_hz(), 333.25);
        assert!(run.text.starts_with("# --set radar.prf_hz=333.25\n"));
        let again = parse(&run.text, &in_configs(), &[]).unwrap();
        assert_eq!(Run { text: String::new(), ..again }, Run { text: String::new(), ..run });
    }
}

#[test]
fn entries_are_named_by_number_or_by_name() {
    let by_name = coastal_with(&[("platform.aircraft.track.velocity_mps", "[0, 77, 0]")]).unwrap();
    let by_number = coastal_with(&[("platform.1.track.velocity_mps", "[0, 77, 0]")]).unwrap();
    assert_eq!((by_name.nav, by_name.scene), (by_number.nav, by_number.scene));
    let unknown = faults_of(&[("platform.plane.track.velocity_mps", "[0, 77, 0]")]);
    assert!(unknown.contains("platform has entries 0 to 1 (coast, aircraft), not plane"), "{unknown}");
}

#[test]
fn transmit_polarisations_that_leave_together_are_a_pair() {
    let warnings = |channels: &str, more: &[(&str, &str)]| {
        let set = [&[("radar.channels", channels)], more].concat();
        let run = coastal_with(&set).unwrap();
        let known = run.warnings.iter().filter(|warning| matches!(warning, Warning::NotOrthogonal { .. }));
        known.map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    for fine in ["['HH', 'HV', 'RV']", "['RR', 'RL']", "['VR']"] {
        assert_eq!(warnings(fine, &[]), "", "{fine}");
    }
    assert_eq!(warnings("['RR', 'HV']", &[("radar.tx_polarisation", "alternating")]), "");
    insta::assert_snapshot!(warnings("['RR', 'HV']", &[]), @r#""tx" transmits in V, R with every pulse, which are not orthogonal: no receiver could tell their echoes apart; channels of H and V, or of R and L, or tx_polarisation = "alternating""#);
}

#[test]
fn a_name_is_needed_where_there_are_several() {
    let two = [("transmitter.1", "{}")];
    assert!(faults_of(&two).contains("transmitter has entries 0 to 0 (tx), not 1"));
    let both = "[{ name = 'a', platform = 'coast', power_w = 1, antenna = { kind = 'isotropic' } }, \
                 { name = 'b', platform = 'aircraft', power_w = 1, antenna = { kind = 'isotropic' } }]";
    let run = coastal_with(&[("transmitter", both)]).unwrap();
    assert_eq!(run.scene.radar.channels.len(), 8);
    assert_eq!(run.scene.radar.channels[4].name, "HH-b-rx");
    assert_eq!(run.scene.radar.channels[4].transmitter, 1);
}

#[test]
fn unused_antennas_give_a_warning() {
    let receivers = "[{ name = 'a', platform = 'coast', antenna = { kind = 'isotropic' } }, \
                      { name = 'b', platform = 'aircraft', antenna = { kind = 'isotropic' } }]";
    let text = COASTAL.replace(
        "channels = [\"HH\", \"HV\", \"VH\", \"VV\"]",
        "channel = [{ polarisation = 'VV', receiver = 'b' }]",
    );
    let run = parse(&text, &in_configs(), &settings(&[("receiver", receivers)])).unwrap();
    assert_eq!(of_scene(&run), [&Warning::Unused { what: "receiver", name: "a".to_owned() }]);
    assert_eq!(run.scene.radar.channels[0].receiver, 1);
}

/// Warnings, but for the one that a build without HDF5 gives for every recording.
fn of_scene(run: &Run) -> Vec<&Warning> {
    run.warnings.iter().filter(|warning| !matches!(warning, Warning::NoHdf5 { .. })).collect()
}

#[test]
fn a_build_without_hdf5_records_plainly_and_warns() {
    let run = parse(COASTAL, &in_configs(), &[]).unwrap();
    let (file, folder) = (PathBuf::from("coastal.h5"), PathBuf::from("coastal"));
    if cfg!(feature = "hdf5") {
        let kind = sinks::Kind::Hdf5 { path: file, segment_s: None, force: false };
        assert_eq!((&run.sinks[0].kind, &run.warnings[..]), (&kind, &[][..]));
    } else {
        let kind = sinks::Kind::Plain { path: folder.clone(), force: false };
        let warning = Warning::NoHdf5 { asked: file, taken: folder, segmented: false };
        assert_eq!((&run.sinks[0].kind, &run.warnings[..]), (&kind, &[warning][..]));
    }
}

#[test]
fn a_ring_that_cannot_hold_the_latency_gives_a_warning() {
    let dense = [("stream.latency_ms", "60000"), ("radar.prf_hz", "1e6"), ("radar.window.samples", "64")];
    let run = coastal_with(&dense).unwrap();
    assert!(
        matches!(of_scene(&run)[..], [Warning::ShortRing { wanted: 60_000_001, .. }]),
        "{:?}",
        run.warnings
    );
    let slot = run.scene.radar.layout(2, 2).slot_bytes();
    assert!(run.stream.ring_slots * slot <= 512 << 20);
}

#[test]
fn a_file_that_is_no_toml_is_reported_in_few_lines() {
    let shown = |lines: usize| {
        let text = format!("[scene]\nduration_s = -1\n{}", "Not a scenario.\n".repeat(lines));
        parse(&text, Path::new("bad.toml"), &[]).unwrap_err().to_string()
    };
    let long = shown(300);
    assert_eq!(long.lines().filter(|line| line.contains(": not valid TOML: ")).count(), 5, "{long}");
    let found: usize = long.lines().last().unwrap().split(' ').nth(1).unwrap().parse().unwrap();
    // What is wrong with values is reported all the same.
    assert!(long.contains("scene.duration_s: -1 is out of range") && found > 300, "{long}");
    let more = format!("bad.toml: not valid TOML in {} more places", found - (long.lines().count() - 2));
    assert!(long.contains(&more), "{more}: {long}");
    assert!(!shown(2).contains("more places"));
}

#[test]
fn settings_without_effect_are_named() {
    let written =
        [("fidelity.kernel_width", "6"), ("fidelity.doppler", "mean"), ("fidelity.error_db", "-70")];
    let warned = |echo: &[(&str, &str)]| {
        let run = coastal_with(&[echo, &written].concat()).unwrap();
        of_scene(&run).iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let keys =
        "fidelity.error_db, fidelity.kernel_width, fidelity.doppler; fidelity.echo = \"fast\" heeds them";
    assert_eq!(
        warned(&[("fidelity.echo", "reference")]),
        [format!("without effect on the reference echo: {keys}")]
    );
    // The fast echo is what every scenario takes, with a sea or without one.
    assert_eq!(warned(&[]), [""; 0]);
    assert_eq!(warned(&[("fidelity.echo", "fast")]), [""; 0]);
    assert_eq!(of_scene(&coastal_with(&[("fidelity.echo", "reference")]).unwrap()), [&Warning::NoSink; 0]);
}

#[test]
fn errors_to_which_a_run_may_relax() {
    let relax_db = |more: &[(&str, &str)]| {
        let set = [&[("stream.policy", "relax"), ("fidelity.error_db", "-40")], more].concat();
        coastal_with(&set).unwrap().relax_db
    };
    assert_eq!(relax_db(&[]), [-25.0]);
    assert_eq!(relax_db(&[("stream.relax_db", "[-30, -22.5]")]), [-30.0, -22.5]);
    assert_eq!(coastal_with(&[]).unwrap().relax_db, [0.0; 0]);
    let faults = |set: &[(&str, &str)]| faults_of(&[&[("stream.relax_db", "[-45, -30]")], set].concat());
    insta::assert_snapshot!(faults(&[]), @r#"stream.relax_db: not allowed here (policy is not "relax")"#);
    insta::assert_snapshot!(faults(&[("stream.policy", "relax"), ("fidelity.error_db", "-40")]), @"stream.relax_db: entry 0, -45, is out of range; allowed: above -40 dB, the one before");
    insta::assert_snapshot!(faults(&[("stream.policy", "relax"), ("stream.relax_db", "[-30, -30]")]), @"stream.relax_db: entry 1, -30, is out of range; allowed: above -30 dB, the one before");
    insta::assert_snapshot!(faults(&[("stream.policy", "relax"), ("fidelity.echo", "reference")]), @r#"stream.policy: "relax" is not allowed beside fidelity.echo = "reference"; allowed: "stop", "slip", "drop""#);
}

#[test]
fn what_cannot_be_is_a_fault() {
    insta::assert_snapshot!(faults_of(&[("radar.losses_db", "-3")]), @"radar.losses_db: -3 is out of range; allowed: a number from 0 to 300 dB");
    insta::assert_snapshot!(faults_of(&[("radar.prf_hz", "3.1e6")]), @"radar.prf_hz: 0.322581 us between pulses are shorter than the pulse of 0.333 us: two pulses would leave at once; allowed: at least 0.333 us");
    insta::assert_snapshot!(faults_of(&[("target.0.position_m", "[3000, 0, -0.5]")]), @"target.0.position_m: lies 0.500 m below the sea; allowed: a height of 0 m or more above mean sea level");
    // A pulse right behind the other is one continuous wave.
    assert!(
        coastal_with(&[
            ("radar.waveform.pulse_s", "1e-6"),
            ("radar.prf_hz", "1e6"),
            ("radar.window.samples", "100")
        ])
        .is_ok()
    );
}

#[test]
fn what_can_hardly_be_meant_is_a_warning() {
    let warned = |list: &[(&str, &str)]| {
        of_scene(&coastal_with(list).unwrap()).iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    insta::assert_snapshot!(warned(&[("radar.prf_hz", "1e6"), ("stream.latency_ms", "1")]), @"windows of 5.12 us are longer than the shortest pulse interval of 1 us: they overlap, and a receiver would have to take the same instants twice");
    let small = "{ kind = 'rectangle', width_m = 0.5, height_m = 0.01 }";
    insta::assert_snapshot!(warned(&[("transmitter.0.antenna", small)]), @r#"the aperture of "tx", 0.5 m x 0.01 m, is smaller than half a wavelength (0.0150 m): the gain of a uniform aperture, 4 pi A / lambda^2, does not hold; use an isotropic antenna or a measured pattern"#);
    insta::assert_snapshot!(warned(&[("radar.waveform.bandwidth_hz", "25")]), @"a band of 25 Hz in a pulse of 0.333 us is less than one cycle: the pulse is not compressed, and resolves 50 m; is bandwidth_hz in Hz?");
    // One cycle is a chirp.
    assert_eq!(warned(&[("radar.waveform.bandwidth_hz", "3.1e6")]), "");
    let placed = |target: &str| {
        let origin =
            [("scene.origin_lat_deg", "54"), ("scene.origin_lon_deg", "10"), ("scene.origin_h_m", "42")];
        warned(&[&origin[..], &[("target.0", target)]].concat())
    };
    let near = "{ lat_deg = 54.001, lon_deg = 10.002, height_m = 5, rcs_m2 = 1 }";
    assert_eq!(placed(near), "");
    let swapped = "{ lat_deg = 10.002, lon_deg = 54.001, height_m = 5, rcs_m2 = 1 }";
    insta::assert_snapshot!(placed(swapped), @"target.0.lat_deg: 10.002 deg, 54.001 deg lies far from the origin of the scene, and near it with latitude and longitude swapped");
    // Far either way.
    assert_eq!(placed("{ lat_deg = 10.0, lon_deg = -54.0, height_m = 5, rcs_m2 = 1 }"), "");
    insta::assert_snapshot!(warned(&[("target.0.velocity_mps", "[0, 0, -1]")]), @r#"target "sphere" moves on a straight line below the sea: 2.252 m deep 2.252 s after pulse 0"#);
}
