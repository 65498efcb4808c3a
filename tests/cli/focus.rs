//! `nereus focus`, and the independent processor.

use std::fs;

use crate::program::{nereus, package};

/// One aircraft over two points, in all channels; noise, a converter.
const SCENARIO: &str = r#"
[scene]
duration_s = 0.199
seed = 5
[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = 400.0
channels = ["HH", "VV"]
noise_figure_db = 3.0
adc = { bits = 14, full_scale_dbw = -80.0 }
waveform = { kind = "lfm", bandwidth_hz = 60e6, pulse_s = 1e-6 }
window = { samples = 512, follow = { kind = "beside", platform = "plane", across_m = -3000.0, lead_us = 1.5 } }
[[platform]]
name = "plane"
track = { kind = "straight", position_m = [-22.0, -3000.0, 3000.0], velocity_mps = [222.0, 0.0, 0.0] }
[[transmitter]]
name = "t"
platform = "plane"
power_w = 1000.0
lever_arm_m = [1.0, 0.5, 1.5]
antenna = { kind = "rectangle", width_m = 0.5, height_m = 0.1 }
pointing = { kind = "beside", platform = "plane", across_m = -3000.0 }
[[receiver]]
name = "r"
platform = "plane"
lever_arm_m = [-1.0, 0.5, 1.5]
antenna = { kind = "ellipse", width_m = 0.5, height_m = 0.1 }
pointing = { kind = "beside", platform = "plane", across_m = -3000.0 }
[[target]]
name = "near"
position_m = [12.0, -30.0, 0.0]
rcs_m2 = 1000.0
[[target]]
name = "high"
position_m = [-15.0, 35.0, 6.0]
rcs_m2 = 1000.0
[[target]]
name = "outside"
position_m = [0.0, 400.0, 0.0]
rcs_m2 = 1.0
[[sink]]
kind = "plain"
path = "r.plain"
"#;

fn recorded(folder: &std::path::Path, settings: &[&str]) {
    fs::write(folder.join("s.toml"), SCENARIO).unwrap();
    let ended = nereus(folder, &[&["run", "s.toml", "--pace", "fast", "--force"], settings].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

#[test]
fn a_plain_recording_becomes_pictures_and_a_table_of_points() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &[]);
    let ended = nereus(folder.path(), &["focus", "r.plain", "--size-m", "128", "--out", "a.png", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    assert_eq!((&report["pulses"], &report["pixels"]), (&80.into(), &serde_json::json!([128, 128])));
    // The window follows the sea 3 km to port: at the middle pulse that is under 0 m East, 0 m North.
    assert_eq!(report["centre_m"], serde_json::json!([0.0, 0.0, 0.0]));
    for channel in report["channels"].as_array().unwrap() {
        let targets = channel["targets"].as_array().unwrap();
        assert_eq!(targets.iter().map(|t| t["name"].as_str().unwrap()).collect::<Vec<_>>(), ["near", "high"]);
        for target in targets {
            for cut in ["range", "cross_range"] {
                let of = |key: &str| target[cut][key].as_f64().unwrap();
                // Noise: the points stand 40 dB above it, which moves 1 % of a cell and of a width.
                assert!((of("width_m") / of("theory_m") - 1.0).abs() < 0.05, "{target}");
                assert!(of("error_cells").abs() < 0.05, "{target}");
            }
        }
        // 6 m up seen from 45 degrees lies over by 6 m, towards the radar.
        let high = &targets[1]["expected_m"];
        assert!((high[1].as_f64().unwrap() - 29.0).abs() < 0.1, "{high}");
    }
    for picture in ["a_HH.png", "a_VV.png"] {
        assert!(fs::read(folder.path().join(picture)).unwrap().starts_with(b"\x89PNG"));
    }
    // 400 Hz separate 115 m of the track: the corners of 128 m lie beyond, those of 48 m do not.
    assert_eq!(report["channels"][0]["doppler_hz"], 400.0);
    for (more, found) in
        [(&["--size-m", "48"][..], None), (&["--size-m", "128", "--doppler-hz", "all"], None)]
    {
        let ended = nereus(folder.path(), &[&["focus", "r.plain", "--json"], more].concat());
        let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
        assert_eq!(report["channels"][0]["doppler_hz"].as_f64(), found, "{more:?}");
    }
    let panels = ["focus", "r.plain", "--size-m", "32", "--panels", "--out", "p.png"];
    assert_eq!(nereus(folder.path(), &panels).code, 0);
    assert!(fs::read(folder.path().join("p.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(!folder.path().join("p_HH.png").exists());
    let again = ["focus", "r.plain", "--size-m", "128", "--out", "a.png"];
    let ended = nereus(folder.path(), &again);
    assert!(ended.code == 2 && ended.stderr.contains("--force"), "{}", ended.stderr);
    // By reports without errors, the same table to all digits that a person reads.
    let one = ["focus", "r.plain", "--size-m", "128", "--channel", "VV", "--nav"];
    let [truth, report] = ["true", "reported"].map(|nav| {
        let ended = nereus(folder.path(), &[&one[..], &[nav]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended
            .stdout
            .lines()
            .filter(|line| !line.starts_with("pulses "))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    });
    assert_eq!(truth, report);
    assert!(truth.iter().any(|line| line.contains("near")), "{truth:?}");
}

/// `configs/selftest.toml`: an echo, a tone, a loopback.
fn with_calibration(folder: &std::path::Path, kind: &str, out: &str) {
    let scenario = package().join("configs/selftest.toml");
    let kind = format!("sink.0.kind={kind:?}");
    let run = ["run", scenario.to_str().unwrap(), "--pulses", "0..8", "--set", &kind, "--out", out];
    let ended = nereus(folder, &run);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

#[test]
fn channels_of_calibration_are_left_out_and_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    with_calibration(folder.path(), "plain", "s.plain");
    let on_the_corner =
        ["focus", "s.plain", "--centre-m", "3300,0", "--size-m", "16", "--pixel-m", "0.25", "--json"];
    let ended = nereus(folder.path(), &on_the_corner);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let channels = report["channels"].as_array().unwrap();
    assert_eq!(channels.iter().map(|c| c["name"].as_str().unwrap()).collect::<Vec<_>>(), ["VV"]);
    // The radar equation: 100 W, 30 dBi at both ends, 100 m^2 at a height of 2 m, seen from 30 m.
    let range_m = 3300f64.hypot(28.0);
    let wanted_dbw = 10.0
        * (100.0 * 1e6 * 0.029_979_245_8f64.powi(2) * 100.0 / (4.0 * std::f64::consts::PI).powi(3)).log10()
        - 40.0 * range_m.log10();
    // An eighth of a metre off the pixel: 0.04 dB. Noise 46 dB below: 0.05 dB. A pulse between samples: 0.09
    // dB.
    assert!((channels[0]["peak_dbw"].as_f64().unwrap() - wanted_dbw).abs() < 0.2, "{wanted_dbw} {report}");
    for (name, kind) in [("tone", "tone"), ("loopback", "loopback")] {
        let ended = nereus(folder.path(), &[&on_the_corner[..], &["--channel", name]].concat());
        let expected =
            format!("channel {name} is a calibration channel ({kind}) and carries no echo; allowed: VV");
        assert!(ended.code == 2 && ended.stderr.contains(&expected), "{}", ended.stderr);
    }
    let ended = nereus(folder.path(), &[&on_the_corner[..], &["--channel", "HH"]].concat());
    assert!(
        ended.code == 2 && ended.stderr.contains("HH is not in the recording; allowed: VV"),
        "{}",
        ended.stderr
    );
}

#[test]
fn an_image_is_where_the_window_looks_by_latitude_and_longitude() {
    let folder = tempfile::tempdir().unwrap();
    let beside = "{ kind = \"beside\", platform = \"plane\", across_m = -3000.0, lead_us = 1.5 }";
    let there = "{ kind = \"at\", lat_deg = 52.001, lon_deg = 4.0005, lead_us = 1.5 }";
    let origin = "seed = 5\norigin_lat_deg = 52.0\norigin_lon_deg = 4.0\norigin_h_m = 43.0";
    let scenario = SCENARIO.replace(beside, there).replace("seed = 5", origin);
    fs::write(folder.path().join("s.toml"), scenario).unwrap();
    let ended = nereus(folder.path(), &["run", "s.toml", "--pace", "fast", "--pulses", "10..14"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let ended = nereus(folder.path(), &["focus", "r.plain", "--size-m", "8", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    // Radii of curvature of WGS-84 at 52 degrees, 43 m up: 111.27 m and 34.34 m. The centre is whole metres.
    let (sin, cos) = 52f64.to_radians().sin_cos();
    let (a_m, e2) = (6_378_137.0, 0.006_694_38);
    let w = 1.0 - e2 * sin * sin;
    let north_m = (a_m * (1.0 - e2) / w.powf(1.5) + 43.0) * 0.001f64.to_radians();
    let east_m = (a_m / w.sqrt() + 43.0) * cos * 0.0005f64.to_radians();
    assert_eq!(report["centre_m"], serde_json::json!([east_m.round(), north_m.round(), 0.0]));
}

#[test]
fn what_is_wrong_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &["--pulses", "10..14"]);
    let isotropic = "transmitter.0.antenna={ kind = 'isotropic' }";
    recorded(folder.path(), &["--pulses", "10..14", "--set", isotropic, "--out", "isotropic.plain"]);
    for (arguments, words) in [
        (&["nothing.h5"][..], "nothing.h5"),
        (&["r.plain", "--channel", "HV"], "allowed: HH, VV"),
        (&["r.plain", "--pulses", "20..30"], "holds pulses 10..14"),
        (&["r.plain", "--size-m", "1e9"], "1 to 32768 pixels"),
        (&["r.plain", "--pixel-m", "0"], "pixels of 0 m"),
        (&["r.plain", "--percentile", "0"], "--percentile 0"),
        (&["r.plain", "--size-m", "16,8", "--looks", "9"], "--looks 9: allowed: up to the shorter side"),
        (&["r.plain", "--out", "a.jpg"], ".png or .h5"),
        (&["r.plain", "--centre-m", "1,2,3"], "two numbers"),
        (&["r.plain", "--doppler-hz", "-3"], "allowed: a number of Hz above 0, or all"),
        (&["isotropic.plain", "--doppler-hz", "90"], "its antennas are isotropic, or"),
    ] {
        let ended = nereus(folder.path(), &[&["focus"], arguments].concat());
        assert!(ended.code == 2 && ended.stderr.contains(words), "{arguments:?}: {}", ended.stderr);
    }
    // Receive windows without echo of the image, and one pulse: an image of zeros, and no cross-range.
    let far = ["focus", "r.plain", "--pulses", "10..11", "--centre-m", "1e6,0", "--size-m", "8", "--json"];
    let ended = nereus(folder.path(), &far);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(!ended.stdout.contains("NaN") && ended.stdout.contains("\"contrast\":0.0"), "{}", ended.stdout);
}

#[test]
fn the_library_makes_the_images_of_the_command() {
    use nereus::focus::{Navigation, Settings};
    use nereus::processor::multilook::levels;
    use nereus::processor::taper::Taper;

    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &["--pulses", "30..50"]);
    let asked = ["focus", "r.plain", "--size-m", "24,16", "--nav", "reported", "--window", "hann", "--json"];
    let ended = nereus(folder.path(), &asked);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let recording = nereus::Recording::open(&folder.path().join("r.plain"), None).unwrap();
    let mut settings = Settings::default();
    settings.nav = Navigation::Reported;
    settings.size_m = [24.0, 16.0];
    settings.window = Taper::Hann;
    let images = nereus::focus(&recording, &settings).unwrap();
    assert_eq!(images.len(), 2);
    for (image, channel) in images.iter().zip(report["channels"].as_array().unwrap()) {
        assert_eq!(channel["name"], image.channel);
        assert_eq!(report["centre_m"], serde_json::json!(image.ground.centre_m()));
        assert_eq!(image.values.len(), 24 * 16);
        // Bit by bit: the same sums in the same order.
        let [mean, peak, contrast] = levels(&image.power(1).0);
        assert_eq!(channel["mean_dbw"], 10.0 * mean.log10());
        assert_eq!(channel["peak_dbw"], 10.0 * peak.log10());
        assert_eq!(channel["contrast"], contrast);
    }
}

/// What the default middle of an image is, and standard error.
fn centred(folder: &std::path::Path, more: &[&str]) -> (i32, serde_json::Value, String) {
    let ended = nereus(folder, &[&["focus", "r.plain", "--size-m", "8", "--json"], more].concat());
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap_or_default();
    (ended.code, report["centre_m"].clone(), ended.stderr)
}

#[test]
fn files_of_the_scenario_need_not_be_there_to_focus() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = "az_deg,el_deg,gain_dbi\n-90,-90,10\n-90,90,10\n90,-90,10\n90,90,10\n";
    fs::write(folder.path().join("gain.csv"), pattern).unwrap();
    let antenna = "receiver.0.antenna={ kind = 'file', path = 'gain.csv' }";
    recorded(folder.path(), &["--pulses", "0..4", "--set", antenna]);
    fs::remove_file(folder.path().join("gain.csv")).unwrap();
    let (code, centre_m, stderr) = centred(folder.path(), &[]);
    // The window follows the sea abeam: 22 m back at pulse 0, and 1.1 m on at the middle pulse.
    assert_eq!((code, centre_m), (0, serde_json::json!([-21.0, 0.0, 0.0])), "{stderr}");
    assert!(!stderr.contains("warning"), "{stderr}");
}

#[test]
fn a_scenario_that_cannot_be_read_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &["--pulses", "0..4"]);
    let (_, where_it_looks, _) = centred(folder.path(), &[]);
    let meta = folder.path().join("r.plain/meta.json");
    let text = fs::read_to_string(&meta).unwrap();
    assert!(text.contains("noise_figure_db"));
    let text = text.replace("noise_figure_db", "noise_number_db");
    fs::write(&meta, &text).unwrap();
    // The recording itself has where the radar looks.
    let (code, centre_m, stderr) = centred(folder.path(), &[]);
    assert_eq!((code, centre_m), (0, where_it_looks), "{stderr}");
    assert!(stderr.contains("radar.noise_number_db") && !stderr.contains("antennas count"), "{stderr}");
    // One of an earlier version does not.
    let mut older: serde_json::Value = serde_json::from_str(&text).unwrap();
    older.as_object_mut().unwrap().remove("instrument").unwrap();
    fs::write(&meta, older.to_string()).unwrap();
    let (code, _, stderr) = centred(folder.path(), &[]);
    assert!(code == 2 && stderr.contains("allowed: a centre (--centre-m X,Y)"), "{stderr}");
    let (code, centre_m, stderr) = centred(folder.path(), &["--centre-m", "3,-4"]);
    assert_eq!((code, centre_m), (0, serde_json::json!([3.0, -4.0, 0.0])), "{stderr}");
    assert!(stderr.contains("warning") && stderr.contains("radar.noise_number_db"), "{stderr}");
}

/// Recordings of a program that did not yet record aims and reported phase centres.
fn without_newer_columns(folder: &std::path::Path) {
    let meta = folder.join("r.plain/meta.json");
    let mut header: serde_json::Value = serde_json::from_slice(&fs::read(&meta).unwrap()).unwrap();
    for antenna in ["t", "r"] {
        for column in ["boresight_quat", "reported_phase_centre_m"] {
            let path = format!("nav/{antenna}/{column}");
            header["columns"].as_object_mut().unwrap().remove(&path).unwrap();
            fs::remove_file(folder.join(format!("r.plain/{path}.bin"))).unwrap();
        }
    }
    fs::write(&meta, header.to_string()).unwrap();
}

#[test]
fn what_an_older_recording_lacks_is_missed_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &[]);
    without_newer_columns(folder.path());
    let of = |nav: &str| nereus(folder.path(), &["focus", "r.plain", "--size-m", "64", "--nav", nav]);
    let ended = of("true");
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let ended = of("reported");
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("/nav/t/reported_phase_centre_m is not in the recording"),
        "{}",
        ended.stderr
    );
    // A column that is reported but gone is no older recording.
    fs::remove_file(folder.path().join("r.plain/nav/t/phase_centre_m.bin")).unwrap();
    let ended = of("true");
    assert_ne!(ended.code, 0);
    assert!(ended.stderr.contains("phase_centre_m.bin"), "{}", ended.stderr);
}

#[test]
fn pulses_beyond_the_end_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &[]);
    let ended = nereus(folder.path(), &["focus", "r.plain", "--size-m", "64", "--pulses", "40..100"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("warning: --pulses 40..100: the recording ends with pulse 79"),
        "{}",
        ended.stderr
    );
    let ended = nereus(folder.path(), &["focus", "r.plain", "--dynamic-db", "40", "--percentile", "99"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
}

#[cfg(feature = "hdf5")]
#[test]
fn the_independent_processor_agrees() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), &["--set", "sink.0.kind=\"hdf5\"", "--out", "r.h5"]);
    let can = std::process::Command::new("python3").args(["-c", "import numpy, h5py, tomllib"]).output();
    if !can.is_ok_and(|ended| ended.status.success()) {
        println!("skipped: no python3 with numpy, h5py, tomllib");
        return;
    }
    for how in [
        &["--nav", "true"][..],
        &["--nav", "reported", "--window", "taylor", "--aperture", "kaiser", "--filter", "flat"],
        &["--window", "hann", "--pulses", "20..60", "--height-m", "6"],
        &["--doppler-hz", "90", "--aperture", "hann"],
        &["--doppler-hz", "90", "--nav", "reported"],
    ] {
        let make = ["focus", "r.h5", "--size-m", "96,64", "--pixel-m", "0.9", "--out", "i.h5", "--force"];
        let ended = nereus(folder.path(), &[&make[..], how].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let ended = std::process::Command::new("python3")
            .arg(package().join("tools/focus_numpy.py"))
            .args(["r.h5", "--image", "i.h5", "--json", "--limit-db", "-50"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let printed = String::from_utf8_lossy(&ended.stdout);
        println!("{how:?}: {printed}");
        assert!(ended.status.success(), "{printed}{}", String::from_utf8_lossy(&ended.stderr));
        let report: serde_json::Value = serde_json::from_str(printed.trim()).unwrap();
        for channel in ["HH", "VV"] {
            // Cells of 1/16 sample, linear: -65 dB, and what noise beyond the band adds to that.
            assert!(report["channels"][channel]["difference_db"].as_f64().unwrap() < -55.0, "{report}");
        }
    }
}

#[cfg(feature = "hdf5")]
#[test]
fn the_independent_processor_does_not_pass_what_it_did_not_compare() {
    let can = std::process::Command::new("python3").args(["-c", "import numpy, h5py, tomllib"]).output();
    if !can.is_ok_and(|ended| ended.status.success()) {
        println!("skipped: no python3 with numpy, h5py, tomllib");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    with_calibration(folder.path(), "hdf5", "s.h5");
    let make = ["focus", "s.h5", "--centre-m", "3300,0", "--size-m", "16", "--out", "i.h5"];
    let ended = nereus(folder.path(), &make);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    // Copies of the image: one whose values are no numbers, of nothing, of a channel that the recording does
    // not have.
    let copies = "import h5py, shutil\n\
        for name in 'nan', 'zero', 'other':\n    \
            shutil.copy('i.h5', name + '.h5')\n    \
            with h5py.File(name + '.h5', 'r+') as f:\n        \
                f['image'][0, 0, 0] = float('nan') if name == 'nan' else 0\n        \
                if name == 'zero': f['x_m'][:] += 1e6; f['image'][:] = 0\n        \
                if name == 'other': del f.attrs['channels']; f.attrs['channels'] = ['HV']\n";
    let python = |arguments: &[&str]| {
        let ended = std::process::Command::new("python3")
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let printed = [ended.stdout, ended.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        (ended.status.code().unwrap(), printed)
    };
    assert_eq!(python(&["-c", copies]), (0, String::new()));
    let tool = package().join("tools/focus_numpy.py");
    for (more, code, words) in [
        (&["--image", "i.h5"][..], 0, "VV: peak"),
        (&["--image", "i.h5", "--channel", "VV"], 0, "VV: peak"),
        (&["--image", "nan.h5"], 1, "differs by nan dB"),
        (&["--image", "zero.h5"], 1, "differs by nan dB"),
        (&["--image", "other.h5"], 2, "not in the recording: HV"),
        (&["--image", "i.h5", "--channel", "HH"], 2, "HH is not in the recording; allowed: VV"),
        (&["--image", "i.h5", "--channel", "tone"], 2, "tone is a calibration channel"),
        (&[], 2, "--limit-db needs --image"),
    ] {
        let given = [&[tool.to_str().unwrap(), "s.h5", "--limit-db", "-50"], more].concat();
        let (ended, printed) = python(&given);
        assert!(ended == code && printed.contains(words), "{more:?}: {ended}, {printed}");
    }
}
