//! `nereus speckle`, and `nereus focus --speckle`.

use std::fs;

use crate::program::{nereus, package};

/// A small sea from 30 degrees above, in cells of 1.5 m.
const SCENARIO: &str = r#"
[scene]
duration_s = 0.02
seed = 5
patch_size_m = [48.0, 72.0]
facet_m = 1.0
[sea]
wind_mps = 8.0
wind_from_deg = 10.0
waves = "linear"
# Facets of a realistic sea are spikier than Rayleigh: two a cell would show nothing.
scattering = { bragg = "frozen", breaking = "off", modulation = "off" }
[radar]
carrier_hz = 10e9
sample_rate_hz = 160e6
prf_hz = 2e3
channels = ["HH", "VV"]
waveform = { kind = "lfm", bandwidth_hz = 120e6, pulse_s = 0.5e-6 }
window = { samples = 256, start_us = 12.8 }
[[platform]]
name = "plane"
track = { kind = "straight", position_m = [-10.0, -1732.0, 1000.0], velocity_mps = [1000.0, 0.0, 0.0] }
[[transmitter]]
name = "t"
platform = "plane"
power_w = 1000.0
antenna = { kind = "isotropic" }
[[receiver]]
name = "r"
platform = "plane"
antenna = { kind = "isotropic" }
[[sink]]
kind = "plain"
path = "r.plain"
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), SCENARIO).unwrap();
    folder
}

#[test]
fn speckle_over_the_wind_becomes_a_table_and_a_picture() {
    let folder = folder();
    let asked = [
        "speckle",
        "s.toml",
        "--winds",
        "4",
        "--resamples",
        "9",
        "--test-pixels",
        "400",
        "--out",
        "made",
        "--json",
    ];
    let ended = nereus(folder.path(), &asked);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let azimuths = report["azimuths"].as_array().unwrap();
    let of = |key: &str| azimuths.iter().map(|a| a[key].clone()).collect::<Vec<_>>();
    assert_eq!(of("psi_deg"), [0.0, 0.0, 90.0, 90.0, 180.0, 180.0, 270.0, 270.0]);
    assert_eq!(of("channel"), ["HH", "VV"].repeat(4));
    for azimuth in azimuths {
        let number = |key: &str| azimuth[key].as_f64().unwrap();
        let pair = |key: &str| [0, 1].map(|i| azimuth[key][i].as_f64().unwrap());
        // lambda R/(2 L) of 40 pulses, 20 m of track: 1.5 m; c/(2 B cos 30) = 1.44 m.
        let [across, along] = pair("cell_m");
        assert!(
            (across - 0.029979 * 2000.0 / 40.0).abs() < 0.01 && (along - 1.4423).abs() < 0.002,
            "{azimuth}"
        );
        assert!((azimuth["grazing_deg"][1].as_f64().unwrap() - 30.0).abs() < 0.01);
        // All pixels lie on the patch, and fill it to a cell.
        let pixels = number("pixels");
        let most = (48.0 / across) * (72.0 / along);
        assert!(pixels <= most + 5.0 && pixels > most - 48.0 / across - 72.0 / along - 1.0, "{azimuth}");
        assert_eq!(number("silent"), 0.0);
        // Some Rayleigh speckle, no more than a few facets a cell make of it.
        assert!((1.3..3.5).contains(&number("contrast")), "{azimuth}");
        assert!(azimuth["empirical"].is_null(), "30 degrees are beyond that law");
        assert_eq!(azimuth["laws"].as_array().unwrap().len(), 3);
        for law in azimuth["laws"].as_array().unwrap() {
            let p = law["probability"].as_f64().unwrap();
            assert!((0.1..=1.0).contains(&p) && law["distance"].as_f64().unwrap() < 0.3, "{law}");
        }
    }
    let csv = fs::read_to_string(folder.path().join("made/speckle.csv")).unwrap();
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    assert_eq!(rows.headers().unwrap().len(), 33);
    assert_eq!(rows.records().map(|row| row.unwrap().len()).collect::<Vec<_>>(), [33; 8]);
    assert!(fs::read(folder.path().join("made/speckle.png")).unwrap().starts_with(b"\x89PNG"));
    // The same numbers in a text; what is there stays.
    let text =
        nereus(folder.path(), &["speckle", "s.toml", "--winds", "1", "--resamples", "0", "--channel", "VV"]);
    assert_eq!(text.code, 0, "{}", text.stderr);
    let contrast = format!("{:.3}", azimuths[1]["contrast"].as_f64().unwrap());
    assert!(text.stdout.contains(&contrast), "{contrast}: {}", text.stdout);
    let again = nereus(folder.path(), &asked);
    assert!(again.code == 2 && again.stderr.contains("--force"), "{}", again.stderr);
}

#[test]
fn speckle_that_cannot_be_made_is_refused_with_a_reason() {
    let folder = folder();
    let without_sea = SCENARIO.replace("patch_size_m = [48.0, 72.0]\nfacet_m = 1.0\n", "");
    let (head, tail) = without_sea.split_once("[sea]").unwrap();
    let (_, tail) = tail.split_once("[radar]").unwrap();
    fs::write(folder.path().join("dry.toml"), format!("{head}[radar]{tail}")).unwrap();
    for (asked, words) in [
        (&["speckle", "dry.toml"][..], "no [sea]"),
        (&["speckle", "s.toml", "--channel", "HV"], "HH, VV"),
        (&["speckle", "s.toml", "--pixels", "5,500"], "5 x "),
        (&["speckle", "s.toml", "--pixels", "5"], "two whole numbers"),
        (&["speckle", "s.toml", "--set", "scene.duration_s=0.0004"], "no cross-range"),
        (&["speckle", "s.toml", "--set", "scene.duration_s=0.001"], "1 x "),
        (&["speckle", "s.toml", "--set", "radar.window.start_us=100"], "pixels with power"),
        (&["speckle", "none.toml"], "none.toml"),
        (&["speckle", "s.toml", "--winds", "0"], "--winds"),
    ] {
        let ended = nereus(folder.path(), asked);
        assert_eq!(ended.code, 2, "{asked:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(words), "{asked:?}: {}", ended.stderr);
    }
}

#[test]
fn focus_fits_laws_to_pixels_a_cell_apart() {
    let folder = folder();
    let ended = nereus(folder.path(), &["run", "s.toml", "--pace", "fast"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let asked =
        ["focus", "r.plain", "--centre-m", "0,0", "--size-m", "44,66", "--pixel-m", "0.5", "--speckle"];
    let ended = nereus(folder.path(), &[&asked[..], &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    let channels = report["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 2);
    for channel in channels {
        let speckle = &channel["speckle"];
        // 1.5 m and 1.44 m are three pixels.
        assert_eq!(speckle["step"], serde_json::json!([3, 3]), "{speckle}");
        assert_eq!(speckle["pixels"], 30 * 44);
        assert_eq!(speckle["laws"].as_array().unwrap().len(), 3);
    }
    let text = nereus(folder.path(), &asked);
    assert!(text.stdout.contains("every 3 to the East and 3 to the North"), "{}", text.stdout);
    let tapered = nereus(folder.path(), &[&asked[..], &["--window", "hann", "--aperture", "hann"]].concat());
    assert!(tapered.stdout.contains("every 5 to the East and 5 to the North"), "{}", tapered.stdout);
    let plain = nereus(folder.path(), &["focus", "r.plain", "--centre-m", "0,0", "--size-m", "44", "--json"]);
    assert!(!plain.stdout.contains("speckle"), "{}", plain.stdout);
    let dark =
        nereus(folder.path(), &["focus", "r.plain", "--centre-m", "9e4,0", "--size-m", "44", "--speckle"]);
    assert!(dark.code == 2 && dark.stderr.contains("pixels with power"), "{}", dark.stderr);
}

/// The table of the page is that of the figures beside it.
#[test]
fn the_page_has_the_figures_of_its_file() {
    let read = |name: &str| fs::read_to_string(package().join("docs").join(name)).unwrap();
    let (page, figures) = (read("speckle.md"), read("speckle.csv"));
    let mut rows = csv::Reader::from_reader(figures.as_bytes());
    let mut rows_found = 0;
    for row in rows.deserialize::<std::collections::HashMap<String, String>>() {
        let row = row.unwrap();
        let number = |key: &str| row[key].parse::<f64>().unwrap();
        let nu = number("nu_likelihood");
        let law = row["nu_empirical"].parse::<f64>().map_or(String::new(), |nu| format!("{nu:.4} "));
        let line = format!(
            "| {:.0} | {} | {:.1} | {:.3} | {nu:.3} +- {:.3} | {:.3} +- {:.3} | {:.2}, {:.2}, {:.2} | {law}|",
            number("psi_deg"),
            row["channel"],
            number("mean_power_dbw"),
            number("nu_moments"),
            nu * nu * number("inverse_nu_block_error"),
            number("nu_histogram"),
            number("nu_histogram_error"),
            number("ks_k"),
            number("ks_weibull"),
            number("ks_rayleigh"),
        );
        assert!(page.contains(&line), "not in the page: {line}");
        rows_found += 1;
    }
    // Eight winds, three channels.
    assert_eq!(rows_found, 24);
}

/// Figures of the last table, with and without breaking waves, are means over the winds of both files.
#[test]
fn the_page_compares_breaking_waves() {
    let read = |name: &str| fs::read_to_string(package().join("docs").join(name)).unwrap();
    let page = read("speckle.md");
    for (breaking, name) in [("off", "speckle.csv"), ("whitecaps", "speckle_breaking.csv")] {
        let figures = read(name);
        let mut rows = csv::Reader::from_reader(figures.as_bytes());
        let rows: Vec<_> =
            rows.deserialize::<std::collections::HashMap<String, String>>().map(Result::unwrap).collect();
        for channel in ["HH", "HV", "VV"] {
            let of: Vec<_> = rows.iter().filter(|row| row["channel"] == channel).collect();
            assert_eq!(of.len(), 8);
            let mean = |key: &str, f: fn(f64) -> f64| {
                of.iter().map(|row| f(row[key].parse().unwrap())).sum::<f64>() / of.len() as f64
            };
            let power_dbw = 10.0 * mean("mean_power_dbw", |dbw| 10f64.powf(dbw / 10.0)).log10();
            let line = format!(
                "| {channel} | {breaking} | {power_dbw:.1} | {:.4} | {:.3} | {:.3} | {:.2} |",
                mean("nu_moments", |nu| nu),
                mean("nu_likelihood", |nu| nu),
                mean("nu_histogram", |nu| nu),
                mean("ks_k", |d| d),
            );
            assert!(page.contains(&line), "not in the page: {line}");
        }
    }
}
