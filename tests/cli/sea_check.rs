//! `check` of seas: figures, warnings, files that are wrong.

use std::fs;
use std::path::PathBuf;

use crate::cases::sized;
use crate::program::{nereus, package};
use crate::table_golden::golden;

/// What is set is reported as keys and as what follows from them, and what was asked otherwise beside it.
#[test]
fn settings_are_reported_as_asked_and_as_set() {
    let check = |scatter: &str, more: &[&str]| {
        let sea = package().join("configs/sea.toml").display().to_string();
        let small =
            ["check", &sea, "--set", "scene.patch_size_m=[16, 16]", "--set", "fidelity.node_pulses=12"];
        let scatter = format!("fidelity.scatter_pulses={scatter}");
        let ended = nereus(package(), &[&small[..], &["--set", &scatter], more].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stdout
    };
    let row = |text: &str, what: &str| {
        text.lines().find(|line| line.trim_start().starts_with(what)).map(str::to_owned).unwrap_or_default()
    };
    let text = check("5", &[]);
    assert!(row(&text, "rounded").contains("scatter_pulses 4, requested 5 ("), "{text}");
    let (keys, derived) = (row(&text, "settings"), row(&text, "derived"));
    for name in ["oversampling", "precision"] {
        assert!(!keys.contains(name) && derived.contains(name), "{name}: {text}");
    }
    for name in ["node_pulses 12", "scatter_pulses 4", "kernel_width"] {
        assert!(keys.contains(name) && !derived.contains(name), "{name}: {text}");
    }
    assert_eq!(row(&check("6", &[]), "rounded"), "");
    let plan = |scatter| serde_json::from_str::<serde_json::Value>(&check(scatter, &["--json"])).unwrap();
    assert_eq!(plan("5")["plan"]["asked"]["scatter_pulses"], 5);
    assert!(plan("6")["plan"]["asked"].is_null());
}

/// Before: "within -60 dB of the reference" among what is modelled, and another error below.
#[test]
fn an_error_that_is_not_kept_is_reported_as_predicted() {
    let sea = package().join("configs/sea.toml").display().to_string();
    let coarse = ["scene.patch_size_m=[16, 16]", "fidelity.node_pulses=21"];
    let ended = nereus(package(), &["check", &sea, "--set", coarse[0], "--set", coarse[1]]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let text = &ended.stdout;
    let row = |what: &str| {
        let found = text.lines().find_map(|line| line.trim_start().strip_prefix(what));
        found.unwrap_or_else(|| panic!("{what}: {text}")).trim()
    };
    let error = row("error ");
    let predicted =
        error.strip_suffix(" dB predicted, -60 dB requested").unwrap_or_else(|| panic!("{error}"));
    assert!(predicted.parse::<f64>().unwrap() > -60.0, "{error}");
    assert_eq!(row("echo "), format!("fast: error against the reference {error}; settings below"));
    assert!(row("by cause").ends_with("dB; the dry run found less than their sum"), "{text}");
    let warning = format!(
        "-60 dB cannot be reached with the [fidelity] keys set in this file (node_pulses); best {predicted} dB"
    );
    assert!(ended.stderr.contains(&warning), "{}", ended.stderr);
}

/// Checks a scenario with settings.
fn check(scenario: &str, settings: &[&str]) -> (serde_json::Value, String) {
    let mut arguments = vec!["check", scenario, "--json"];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let ended = nereus(package(), &arguments);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    (serde_json::from_str(&ended.stdout).unwrap(), ended.stderr)
}

fn number(report: &serde_json::Value, key: &str) -> f64 {
    report["sea"][key].as_f64().unwrap_or_else(|| panic!("{key}: {report}"))
}

fn close(what: &str, value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{what}: {value}, expected {expected} within {tolerance}");
}

/// The four configurations of the paper as computed independently.
fn configurations() -> serde_json::Value {
    let folder =
        std::env::var_os("NEREUS_GOLDEN").map_or_else(|| package().join("tests/data/golden"), PathBuf::from);
    serde_json::from_str(&fs::read_to_string(folder.join("configs.json")).unwrap()).unwrap()
}

/// Half of the last digit that the golden file prints, and what rounding of decimals may add.
const THREE_DECIMALS: f64 = 0.5e-3 + 1e-12;

#[test]
fn the_configurations_of_the_paper_have_their_wind_and_their_resolution() {
    let golden = configurations();
    // The resolutions are those of the middle of the track.
    for (n, platform) in [("1", 0), ("2", 0), ("4", 1)] {
        let scenario = format!("configs/mars-{n}.toml");
        let middle = format!("platform.{platform}.track.position_m.0=0");
        let (report, _) =
            check(&scenario, &["scene.patch_size_m=[16, 16]", "scene.duration_s=0.004", &middle]);
        let expected = golden["expected"]["range_res_m"][n].as_f64().unwrap();
        close(&scenario, number(&report, "ground_range_m"), expected, THREE_DECIMALS);
        for (key, name) in [("u10_mps", "U10_m_s"), ("u12_5_mps", "U12p5_m_s"), ("u19_5_mps", "U19p5_m_s")] {
            let expected = golden["environment"][name].as_f64().unwrap();
            close(name, number(&report, key), expected, THREE_DECIMALS);
        }
    }
}

#[test]
fn the_windows_of_the_paper_s_scenarios_hold_their_patches() {
    for n in 1..=4 {
        // Few pulses: the three that are looked at are at the ends and the middle of the track all the same.
        // A coarse facet keeps the size of the patch and spares the forecast.
        let (report, _) = check(&format!("configs/mars-{n}.toml"), &["scene.facet_m=16"]);
        assert_eq!(number(&report, "share_in_window"), 1.0, "mars-{n}");
        assert_eq!(report["pulses"], 500);
    }
}

#[test]
fn waves_are_those_of_the_golden_spectra() {
    let small = "scene.patch_size_m=[16, 16]";
    let kpeak = golden("kpeak_lmin.csv");
    let row = kpeak.rows().find(|row| row.get("U19p5_m_s") == 10.0 && row.get("alpha") == 0.25).unwrap();
    let settings = [small, "swell=[]", "sea.spectrum=fung-lee", "sea.wind_mps=10", "sea.wind_height_m=19.5"];
    let (report, _) = check("configs/sea.toml", &settings);
    // The edges of the band are bisected to the last bits; the golden file prints 12 decimals.
    close("Lmin", number(&report, "least_length_m"), row.get("Lmin_m"), 1e-6);

    let moments = golden("spectrum_moments.csv");
    let row = moments.rows().find(|row| row.get("U10_m_s") == 10.0 && row.get("Omega_c") == 0.84).unwrap();
    let (report, _) = check("configs/sea.toml", &[small, "swell=[]", "sea.wind_mps=10"]);
    // Trapezoids of the golden file over 2e4 points a decade or better; nothing lies beyond its band.
    let expected = row.get("Hs_m");
    close("Hs", number(&report, "significant_height_m"), expected, 1e-4 * expected);
    // A swell adds its variance: Hs adds in squares.
    let (report, _) = check("configs/sea.toml", &[small, "sea.wind_mps=10"]);
    close("with swell", number(&report, "significant_height_m"), expected.hypot(0.8), 2e-4 * expected);

    let (report, _) = check("configs/sea.toml", &[small, "swell=[]", "sea.wind_mps=0.2"]);
    assert_eq!(report["sea"]["calm"], true);
    assert_eq!((number(&report, "significant_height_m"), number(&report, "least_length_m")), (0.0, 0.0));
}

#[test]
fn what_does_not_fit_gives_a_warning_and_no_error() {
    let warnings = |settings: &[&str]| {
        // Nothing to say of this sea: long, finely cut.
        let mut all = vec![
            "swell=[]",
            "slick=[]",
            "target=[]",
            "sea.wind_mps=2",
            "scene.patch_size_m=[16, 16]",
            "scene.facet_m=0.5",
            // Quick to check; the first has the fast echo always.
            sized("fidelity.echo=fast", "fidelity.echo=reference"),
        ];
        all.extend(settings);
        let warnings = check("configs/sea.toml", &all).1;
        // A build without HDF5 has a word about the recording besides.
        warnings.lines().filter(|line| !line.contains("has no HDF5")).collect::<Vec<_>>().join("\n")
    };
    insta::assert_snapshot!(warnings(&["fidelity.echo=fast"]), @"");
    insta::assert_snapshot!(warnings(&["sea.wind_mps=10"]), @r#"warning: the patch of 16 m x 16 m is shorter than the 329 m that its spectrum asks for: long waves are coarsely drawn"#);
    insta::assert_snapshot!(warnings(&["sea.wind_mps=26"]), @r#"
warning: the patch of 16 m x 16 m is shorter than the 2221 m that its spectrum asks for: long waves are coarsely drawn
warning: wind of 26.0 m/s at 10 m: above 25 m/s the laws of wind and waves are extrapolations, and a linear sea is a rough model
"#);
    insta::assert_snapshot!(warnings(&["scene.facet_m=1"]), @r#"warning: 3.5 facets in a resolution cell of 3.53 m ground range x 1 m azimuth (scene.azimuth_resolution_m): below 6 of random phase its speckle is not Rayleigh's; sea.scattering.speckle = "gaussian" needs one, of at most 1 m, or scene.facet_m of at most 0.76 would do, with 1.7 times as many facets"#);
    insta::assert_snapshot!(warnings(&["scene.facet_m=8"]), @r#"warning: 0.1 facets in a resolution cell of 3.53 m ground range x 1 m azimuth (scene.azimuth_resolution_m): below 6 of random phase its speckle is not Rayleigh's; sea.scattering.speckle = "gaussian" needs one, of at most 1 m, or scene.facet_m of at most 0.76 would do, with 110.8 times as many facets"#);
    let gaussian = "sea.scattering.speckle=gaussian";
    assert_eq!(warnings(&["scene.facet_m=1", gaussian]), "");
    insta::assert_snapshot!(warnings(&["scene.facet_m=2", gaussian]), @r#"warning: 0.9 facets in a resolution cell of 3.53 m ground range x 1 m azimuth (scene.azimuth_resolution_m): a facet should not be longer than it; scene.facet_m of at most 1 would do, with 4.0 times as many facets"#);
    let low = [
        "scene.facet_m=1",
        gaussian,
        "platform.0.track.position_m=[0,-4000,400]",
        "radar.window.start_us=26.0",
    ];
    insta::assert_snapshot!(warnings(&low), @"warning: the sea is looked at from 5.7 degrees above it: with fewer sea.scattering.tilt_modes than 6 its echo is too weak, by 1 dB in HH and 2.5 dB in HV at 5 degrees with 3");
    insta::assert_snapshot!(warnings(&["radar.window.start_us=29.5"]), @r#"warning: the receive window misses the patch at pulse 0: it holds full echoes that begin [29.5, 31.09] us after the emission, those of the patch begin [28.27, 28.34] us"#);
    // The echo of the pulse before: 28.3 us are 3.3 us after the next emission.
    assert_eq!(warnings(&["radar.window={samples=64,start_us=3.0}", "radar.prf_hz=40000"]), "");
    insta::assert_snapshot!(warnings(&["scene.earth=curved", "platform.0.track.position_m=[-30000, 0, 0]", "radar.window.start_us=199.5"]), @r#"
warning: 48 % of the patch lie beyond the horizon of "tx" at pulse 0 and are dark: it sees the sea to 30.0 km, the patch lies 30.0 to 30.0 km away
warning: 48 % of the patch lie beyond the horizon of "rx" at pulse 0 and are dark: it sees the sea to 30.0 km, the patch lies 30.0 to 30.0 km away
"#);
    insta::assert_snapshot!(warnings(&["slick=[{centre_m=[50,0],half_axes_m=[3,4]}]"]), @r#"warning: slick "slick-0" lies outside the patch of sea: no facet has it"#);
}

#[test]
fn a_spectrum_file_is_faulted_by_line_beside_the_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("waves.csv", "kx_rad_m,ky_rad_m,psi_m4\n0,0,0\n0,1,-2\n1,0,4\n1,1.5,2\n");
    write("flight.csv", "time_utc,x_m\n");
    let scenario = fs::read_to_string(package().join("configs/sea.toml")).unwrap();
    let scenario = scenario.replace("\"elfouhaily\"  ", "\"measured\"\nspectrum_path = \"waves.csv\"");
    write("my.toml", &scenario);
    let ended = nereus(folder.path(), &["check", "my.toml"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""));
    let sea = "line 3: psi_m4 is -2: it must not be negative";
    assert!(
        ended.stderr.contains("sea: measured spectrum waves.csv: ") && ended.stderr.contains(sea),
        "{}",
        ended.stderr
    );
    assert!(ended.stderr.contains("line 5: "), "{}", ended.stderr);
    // The other faulty files of the scenario are named in the same run.
    let flight = "platform.0.track={kind='csv',path='flight.csv'}";
    let start = "scene.start_utc='2020-01-01T00:00:00Z'";
    for command in ["check", "run"] {
        let ended = nereus(folder.path(), &[command, "my.toml", "--set", flight, "--set", start]);
        assert_eq!(ended.code, 2);
        assert!(ended.stderr.contains(sea) && ended.stderr.contains("flight.csv"), "{}", ended.stderr);
    }
    write("waves.csv", "kx_rad_m,ky_rad_m,psi_m4\n0,0,0\n0,1,0\n1,0,4\n1,1,2\n");
    let settings = ["--set", "scene.patch_size_m=[16, 16]"];
    let ended = nereus(folder.path(), &[&["check", "my.toml"], &settings[..]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

#[test]
fn what_the_earth_hides_is_named_with_its_distance() {
    let (report, warnings) = check("tests/data/scenarios/coast.toml", &[]);
    // 35 m and 1 m of height: 24.4 + 4.1 km. The helicopter, 100 m high, is seen.
    let lines: Vec<_> = warnings.lines().filter(|line| line.contains("horizon")).collect();
    insta::assert_snapshot!(lines.join("\n"), @r#"
warning: target "buoy" lies beyond the horizon of "tx" at pulse 0: 60.0 km away, seen to 28.5 km
warning: target "buoy" lies beyond the horizon of "rx" at pulse 0: 60.0 km away, seen to 28.5 km
warning: 100 % of the patch lie beyond the horizon of "tx" at pulse 0 and are dark: it sees the sea to 24.4 km, the patch lies 59.9 to 60.1 km away
warning: 100 % of the patch lie beyond the horizon of "rx" at pulse 0 and are dark: it sees the sea to 24.4 km, the patch lies 59.9 to 60.1 km away
"#);
    let has = |list: &str| report[list].as_array().unwrap().iter().any(|row| row["what"] == "horizon");
    assert!(has("modelled") && !has("not_modelled"));
    let (report, warnings) = check("tests/data/scenarios/coast.toml", &["scene.horizon=false"]);
    assert!(
        !warnings.contains("buoy") && warnings.contains("illuminated all the same (scene.horizon = false)"),
        "{warnings}"
    );
    assert!(report["not_modelled"].as_array().unwrap().iter().any(|row| row["what"] == "horizon"));
}

/// A buoy's spectrum ends before the radar's Bragg waves: they are Elfouhaily's unless the file's own are
/// asked for.
#[test]
fn waves_beyond_a_measured_spectrum_are_stated() {
    let folder = tempfile::tempdir().unwrap();
    let text: String = ["kx_rad_m,ky_rad_m,psi_m4\n".to_owned()]
        .into_iter()
        .chain((0..16).map(|n| {
            let (kx, ky) = (0.1 * f64::from(n % 4), 0.1 * f64::from(n / 4));
            format!("{kx},{ky},{}\n", if n == 0 { 0.0 } else { 0.02 })
        }))
        .collect();
    fs::write(folder.path().join("buoy.csv"), text).unwrap();
    let sea = package().join("configs/sea.toml").display().to_string();
    let path = format!("sea.spectrum_path={}", folder.path().join("buoy.csv").display());
    let with = |more: &[&str]| {
        let patch = sized("scene.patch_size_m=[16, 16]", "scene.patch_size_m=[8, 8]");
        let small = ["check", &sea, "--set", patch, "--set", "sea.spectrum=measured"];
        let echo = sized("fidelity.echo=fast", "fidelity.echo=reference");
        let own = ["--set", &path, "--set", echo];
        let ended = nereus(package(), &[&small[..], &own, more].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stdout
    };
    let joined = "with Elfouhaily's waves of the wind beyond its last wave number";
    let silent = "nothing scatters by Bragg where it ends before the radar's Bragg waves";
    let text = with(&[]);
    assert!(text.contains(joined) && !text.contains(silent), "{text}");
    let text = with(&["--set", "sea.spectrum_tail=none"]);
    assert!(!text.contains(joined) && text.contains(silent), "{text}");
}

/// `scene.facet_m = "auto"`: the largest that divides 16 m and is enough of a cell of 2.5 m, for speckle of
/// six or as a facet of its own, and of the longest waves.
#[test]
fn facets_are_chosen() {
    let facets = |settings: &[&str]| {
        let own =
            ["scene.patch_size_m=[16, 16]", "scene.facet_m=auto", "swell=[]", "fidelity.echo=reference"];
        number(&check("configs/sea.toml", &[&own[..], settings].concat()).0, "facets")
    };
    let gaussian = "sea.scattering.speckle=gaussian";
    let coarse = "scene.azimuth_resolution_m=100";
    assert_eq!(facets(&[]), 25.0 * 25.0);
    assert_eq!(facets(&[gaussian]), 16.0 * 16.0);
    assert_eq!(facets(&[gaussian, coarse]), 7.0 * 7.0);
    // Twelve along a wave of 18 m, and no 11 of them: that is a prime. Waves of 3.6 m are left to the tilts.
    assert_eq!(facets(&[gaussian, coarse, "sea.wind_mps=4.45"]), 12.0 * 12.0);
    assert_eq!(facets(&[gaussian, coarse, "sea.wind_mps=2"]), 16.0 * 16.0);
    // A young sea has shorter waves.
    assert_eq!(facets(&[gaussian, coarse, "sea.wind_mps=7.6", "sea.inverse_wave_age=1.43"]), 12.0 * 12.0);
    assert_eq!(facets(&[gaussian, "sea.wind_mps=0"]), 16.0 * 16.0);
}
