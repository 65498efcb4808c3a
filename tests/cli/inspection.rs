//! `check`, `new` and wrong arguments.

use std::fs;

use crate::cases::sized;
use crate::program::{nereus, package};

/// Patches as scenarios have them, and what of them is checked: of all cases, of few.
const CORNERS: [(&str, [&str; 2]); 7] = [
    ("patch_size_m = [512.0, 512.0]", ["scene.patch_size_m=[32, 32]", "scene.patch_size_m=[16, 16]"]),
    ("patch_size_m = [128.0, 128.0]", ["scene.patch_size_m=[128, 128]", "scene.patch_size_m=[16, 16]"]),
    ("patch_size_m = [1024.0, 1024.0]", ["scene.patch_size_m=[1024, 1024]", "scene.patch_size_m=[64, 64]"]),
    ("patch_size_m = [384.0, 384.0]", ["scene.patch_size_m=[96, 96]", "scene.patch_size_m=[24, 24]"]),
    ("patch_size_m = [256, 256]", ["scene.patch_size_m=[64, 64]", "scene.patch_size_m=[32, 32]"]),
    ("patch_size_m = [224.0, 120.0]", ["scene.patch_size_m=[224, 120]", "scene.patch_size_m=[64, 40]"]),
    ("patch_size_m = [503.808, 1133.568]", ["scene.patch_size_m=[31.488, 31.488]"; 2]),
];

#[test]
fn every_scenario_of_the_repository_checks() {
    let mut checked = 0;
    for entry in fs::read_dir(package().join("configs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        // From elsewhere: files beside the scenario are found, whatever the working directory.
        let elsewhere = tempfile::tempdir().unwrap();
        let mut arguments = vec!["check", path.to_str().unwrap()];
        // A whole patch takes its time in the forecast; a corner of it is looked at here.
        let text = fs::read_to_string(&path).unwrap();
        if let Some((_, corner)) = CORNERS.iter().find(|(written, _)| text.contains(written)) {
            arguments.extend(["--set", sized(corner[0], corner[1])]);
        }
        let ended = nereus(elsewhere.path(), &arguments);
        assert_eq!(ended.code, 0, "{}: {}", path.display(), ended.stderr);
        assert!(ended.stdout.contains("not modelled"), "{}", ended.stdout);
        assert_eq!(fs::read_dir(elsewhere.path()).unwrap().count(), 0, "check left files");
        checked += 1;
    }
    assert!(checked >= 10);
}

#[test]
fn templates_that_stand_alone_check_anywhere() {
    for kind in [None, Some("coastal"), Some("monostatic"), Some("spaceborne"), Some("sea")] {
        let folder = tempfile::tempdir().unwrap();
        let mut arguments = vec!["new"];
        arguments.extend(kind);
        let new = nereus(folder.path(), &arguments);
        assert_eq!((new.code, new.stderr.as_str()), (0, ""));
        fs::write(folder.path().join("my.toml"), new.stdout).unwrap();
        let patch = sized(&[][..], &["--set", "scene.patch_size_m=[32, 32]"]);
        let patch = if kind == Some("sea") { patch } else { &[] };
        let check = nereus(folder.path(), &[&["check", "my.toml"], patch].concat());
        assert_eq!(check.code, 0, "{}", check.stderr);
    }
}

#[test]
fn templates_are_the_scenarios_of_the_repository() {
    for kind in ["coastal", "monostatic", "spaceborne", "quickstart", "calibration", "sea"] {
        let printed = nereus(package(), &["new", kind]).stdout;
        let file = fs::read_to_string(package().join(format!("configs/{kind}.toml"))).unwrap();
        assert_eq!(printed, file);
    }
}

#[test]
fn check_prints_one_json_object() {
    let ended =
        nereus(package(), &["check", "configs/calibration.toml", "--json", "--set", "scene.duration_s=2"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert_eq!(ended.stdout.lines().count(), 1);
    let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(report["pulses"], 444);
    assert_eq!(report["channels"].as_array().unwrap().len(), 4);
    // 4 channels of 512 complex samples of 8 bytes, 222 times a second.
    let expected = 4.0 * 512.0 * 8.0 * 222.0 / 1e6;
    assert!((report["sample_rate_mb_per_s"].as_f64().unwrap() - expected).abs() < 1e-9);
    let link = &report["link"];
    assert_eq!(link["antennas"].as_array().unwrap().len(), 2, "{link}");
    assert_eq!(link["targets"].as_array().unwrap().len(), 25, "{link}");
    assert!(link["targets"][24]["compressed_snr_db"].is_number(), "{link}");
    assert!(report["not_modelled"].as_array().unwrap().iter().all(|row| row["how"].is_string()));
}

#[test]
fn faults_go_to_standard_error_with_exit_2() {
    let folder = tempfile::tempdir().unwrap();
    let good = nereus(package(), &["new", "coastal"]).stdout;
    let bad = good
        .replace("prf_hz = 222.0", "prf_hz = -222.0")
        .replace("bandwidth_hz = 60e6", "bandwidth_hz = 160e6")
        .replace("samples = 512", "smaples = 512");
    fs::write(folder.path().join("bad.toml"), bad).unwrap();
    for command in ["check", "run"] {
        let ended = nereus(folder.path(), &[command, "bad.toml"]);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""));
        insta::allow_duplicates! {
            insta::assert_snapshot!(ended.stderr, @r#"
error: bad.toml:10:10: radar.prf_hz: -222.0 is out of range; allowed: a number from 0.001 to 1e9 Hz
bad.toml:16:16: radar.waveform.bandwidth_hz: 1.6e8 Hz exceeds the sample rate (radar.sample_rate_hz); allowed: up to 1e8 Hz
bad.toml:20:8: radar.window.samples: is missing; required: a whole number from 1 to 16777216
bad.toml:21:1: radar.window.smaples: unknown key; did you mean samples?
bad.toml: 4 faults
"#);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "{command} left files");
    }
}

#[test]
fn faults_of_settings_name_the_setting() {
    let ended = nereus(
        package(),
        &["check", "configs/coastal.toml", "--set", "radar.prf=3", "--set", "target.9.rcs_m2=1"],
    );
    assert_eq!(ended.code, 2);
    insta::assert_snapshot!(ended.stderr, @r#"
error: --set: target.9.rcs_m2: no such entry: target has entries 0 to 1 (sphere, boat), not 9
--set: radar.prf: unknown key; did you mean prf_hz, in Hz?
configs/coastal.toml: 2 faults
"#);
}

#[test]
fn wrong_arguments_exit_2_and_help_exits_0() {
    for arguments in [
        &[][..],
        &["fly"],
        &["check"],
        &["check", "configs/coastal.toml", "--set", "novalue"],
        &["check", "no-such-file.toml"],
        &["check", "configs"],
        &["run", "configs/coastal.toml", "--pulses", "200..100"],
        &["run", "configs/coastal.toml", "--pulses", "0..100000"],
        &["run", "configs/coastal.toml", "--pace", "warp"],
        &["run", "configs/coastal.toml", "--duration-s", "-1"],
        &["table", "antenna", "--carrier-hz", "0", "--width-m", "1", "--height-m", "1"],
        &["table", "antenna", "--carrier-hz", "1e10", "--width-m", "-1", "--height-m", "1"],
        &["new", "moon"],
        &["merge", "a.h5"],
    ] {
        let ended = nereus(package(), arguments);
        assert_eq!(ended.code, 2, "{arguments:?}: {}", ended.stderr);
        assert!(ended.stdout.is_empty() && !ended.stderr.is_empty(), "{arguments:?}");
    }
    for arguments in [&["--help"][..], &["--version"], &["run", "--help"], &["table", "antenna", "--help"]] {
        let ended = nereus(package(), arguments);
        assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{arguments:?}");
        assert!(!ended.stdout.is_empty());
    }
}

/// A number that is not allowed is reported by the option that has it, with what is.
#[test]
fn numbers_out_of_range_name_their_option() {
    let sea = "configs/sea.toml";
    let of_threads = "for '--threads <T>': allowed: a whole number from 0 to 1024";
    for (arguments, expected) in [
        (&["bench", sea, "--threads", "-1"][..], of_threads),
        (&["bench", sea, "--threads", "2000"], of_threads),
        (&["tradeoff", sea, "--threads", "two"], of_threads),
        (&["speckle", sea, "--threads", "-1"], of_threads),
        (&["bench", sea, "--pulses", "-5"], "for '--pulses <N>': allowed: a whole number from 1 to 2^64 - 1"),
        (
            &["bench", sea, "--error-pulses", "-5"],
            "'--error-pulses <N|all>': not a number of pulses; allowed:",
        ),
        (&["speckle", sea, "--winds", "361"], "for '--winds <N>': allowed: a whole number from 1 to 360"),
        (&["receive", "--pulses", "0"], "for '--pulses <N>': allowed: a whole number from 1"),
        (&["receive", "--idle-s", "-1"], "for '--idle-s <S>': allowed: a number of seconds above 0"),
        (&["snapshot", sea, "--pulse", "-1"], "for '--pulse <N>': allowed: a whole number from 0"),
        (&["run", sea, "--duration-s", "-1"], "for '--duration-s <S>': allowed: a number"),
        (&["run", sea, "--duration-s", "long"], "for '--duration-s <S>': allowed: a number"),
    ] {
        let ended = nereus(package(), arguments);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(expected), "{arguments:?}: {}", ended.stderr);
        assert!(!ended.stderr.contains("-- -") && !ended.stderr.contains("--set"), "{}", ended.stderr);
    }
}

#[test]
fn the_manual_is_printed() {
    let printed = nereus(package(), &["new", "keys"]).stdout;
    assert_eq!(printed, fs::read_to_string(package().join("docs/scenario.md")).unwrap());
}

/// Offsets of clocks are printed in nanoseconds, a rate of zero as 0; without clocks they are ideal.
#[test]
fn check_states_the_clocks() {
    let ended = nereus(package(), &["check", "configs/errors.toml"]);
    assert!(
        ended.stdout.contains(
            "tx: offset 40 ns, rate 0 at pulse 0, Allan deviation 1.00e-11 at 1 s; rx: offset 0 ns, rate 2e-9"
        ),
        "{}",
        ended.stdout
    );
    let ended = nereus(package(), &["check", "configs/calibration.toml"]);
    assert!(ended.stdout.contains("[receiver.clock]: ideal clocks"), "{}", ended.stdout);
}
