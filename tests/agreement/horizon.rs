//! What the curve of the earth hides: a radar on a mast of 35 m, whose horizon is `sqrt(2 k R 35 m)` = 24.4
//! km away.

use std::fs;

use nereus::config::{self, Run};
use nereus::paths::list::ScattererPaths;
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;

use crate::cases::some_of;
use crate::runs::keeps_the_error;

const RADIUS_M: f64 = 4.0 / 3.0 * 6_371_000.0;

const COAST: &str = include_str!("../data/scenarios/coast.toml");

/// The scenario without its sea.
fn dry() -> String {
    let of_sea = |line: &&str| !["patch", "facet", "[sea]", "wind"].iter().any(|key| line.starts_with(key));
    COAST.lines().filter(of_sea).flat_map(|line| [line, "\n"]).collect()
}

fn scene(text: &str, settings: &[(&str, &str)]) -> Run {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coast.toml");
    fs::write(&path, text).unwrap();
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    config::load(&path, &settings).unwrap()
}

/// Scatterer paths of pulse 0, as the reference takes them.
fn paths(text: &str, settings: &[(&str, &str)]) -> ScattererPaths {
    let run = scene(text, settings);
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    factory.scatterer_paths(0).unwrap().1
}

fn power(paths: &ScattererPaths) -> f64 {
    paths.amplitude.iter().flatten().map(|a| a.norm_sqr()).sum()
}

/// Window, patch centre and nothing else at a distance, m.
fn at_range(range_m: f64) -> [(&'static str, String); 3] {
    let start_us = 2e6 * range_m / 299_792_458.0 - 0.9;
    [
        ("radar.window.start_us", format!("{start_us:.3}")),
        ("scene.patch_centre_m", format!("[{range_m:.1}, 0.0]")),
        ("target", "[]".to_owned()),
    ]
}

fn borrowed<'a>(
    settings: &'a [(&'static str, String)],
    more: &[(&'a str, &'a str)],
) -> Vec<(&'a str, &'a str)> {
    settings.iter().map(|(k, v)| (*k, v.as_str())).chain(more.iter().copied()).collect()
}

#[test]
fn water_and_buoys_at_60_km_are_dark_and_a_helicopter_is_seen() {
    let seen = paths(COAST, &[]);
    assert_eq!(seen.len(), 1);
    // It is the helicopter, 10 m farther and 100 m up.
    let up_m = 100.0 - 60_010f64.powi(2) / (2.0 * RADIUS_M);
    let expected_s = 2.0 * 60_010f64.hypot(up_m - 35.0) / 299_792_458.0;
    assert!((seen.delay_s[0][0] - expected_s).abs() < 1e-12);
    let all = paths(COAST, &[("scene.horizon", "false")]);
    assert!(all.len() > 100, "{}", all.len());
    // Neither the shadows of waves nor how they are found decide.
    assert_eq!(paths(COAST, &[("sea.shadow.enabled", "false")]).len(), 1);
    assert_eq!(paths(COAST, &[("sea.shadow.edge", "\"sharp\"")]).len(), 1);
    assert!(paths(COAST, &[("sea.shadow.enabled", "false"), ("scene.horizon", "false")]).len() > 100);
}

#[test]
fn targets_vanish_at_the_sum_of_the_two_horizons() {
    // 35 m and 100 m: 24.386 + 41.218 km. Over 1 m of height they go down: 0.42 km at 2 k R (c = 1 m) there.
    let horizon_m = (2.0 * RADIUS_M * 35.0).sqrt() + (2.0 * RADIUS_M * 100.0).sqrt();
    let found = |range_m: f64| {
        let target = format!("[{{ name = \"t\", position_m = [{range_m:.3}, 0, 100], rcs_m2 = 10 }}]");
        let [window, ..] = at_range(range_m);
        let illuminated = |horizon: &str| {
            let settings = [(window.0, window.1.as_str()), ("target", &target), ("scene.horizon", horizon)];
            power(&paths(&dry(), &settings))
        };
        illuminated("true") / illuminated("false")
    };
    assert_eq!(found(horizon_m - 50.0), 1.0);
    assert_eq!(found(horizon_m + 500.0), 0.0);
    // At c = -1/2 m half of the field passes each way.
    let half_m = (2.0 * RADIUS_M * 35.0).sqrt() + (2.0 * RADIUS_M * 100.5).sqrt();
    let share = found(half_m);
    println!("half way down: {share}");
    assert!((share - 0.0625).abs() < 1e-3, "{share}");
}

#[test]
fn direct_path_is_cut_by_the_earth() {
    let echo_of = |height_m: f64, horizon: &str| {
        let up_m = height_m - 60e3 * 60e3 / (2.0 * RADIUS_M);
        let receiver = format!("{{ kind = \"fixed\", position_m = [60000, 0, {up_m:.6}] }}");
        let platforms = format!(
            "[{{ name = \"mast\", track = {{ kind = \"fixed\", position_m = [0, 0, 35] }} }}, {{ name = \"far\", track = {receiver} }}]"
        );
        let settings = [
            ("platform", platforms.as_str()),
            ("receiver.0.platform", "\"far\""),
            ("radar.direct_path", "true"),
            ("radar.window.start_us", "199.5"),
            ("scene.horizon", horizon),
            ("target", "[]"),
        ];
        power(&paths(&dry(), &settings))
    };
    assert_eq!(echo_of(10.0, "true"), 0.0);
    assert!(echo_of(10.0, "false") > 0.0);
    assert_eq!(echo_of(100.0, "true"), echo_of(100.0, "false"));
    assert!(echo_of(100.0, "true") > 0.0);
}

#[test]
fn before_the_horizon_no_bit_changes() {
    let settings = at_range(20e3);
    let [with, without] =
        ["true", "false"].map(|on| paths(COAST, &borrowed(&settings, &[("scene.horizon", on)])));
    assert!(with.len() > 100);
    assert_eq!(with.amplitude, without.amplitude);
}

#[test]
fn crests_are_seen_beyond_the_horizon_and_both_echoes_agree() {
    // 2.6 km beyond: the mean surface lies 0.4 m below the ray, waves of 1.6 m significant height stand above
    // it in part.
    let settings = at_range(27e3);
    let [with, without] =
        ["true", "false"].map(|on| paths(COAST, &borrowed(&settings, &[("scene.horizon", on)])));
    let share = power(&with) / power(&without);
    println!("27 km: {} of {} facets, {share:.3} of the power", with.len(), without.len());
    assert!(with.len() * 10 > without.len() && with.len() * 10 < without.len() * 9, "{}", with.len());
    for waves in some_of(["true", "false"]) {
        for error_db in some_of(["-60.0", "-45.0"]) {
            let fast = [
                ("fidelity.echo", "\"fast\""),
                ("fidelity.error_db", error_db),
                ("sea.shadow.enabled", waves),
            ];
            keeps_the_error("horizon", &scene(COAST, &borrowed(&settings, &fast)));
        }
    }
}

#[test]
fn a_target_that_goes_down_is_the_same_in_both_echoes() {
    // 0.3 m below, outward at 250 m/s (0.7 m/s up from the ray, as the earth falls away) and 3 m/s down: it
    // fades within the run.
    let range_m = (2.0 * RADIUS_M * 35.0).sqrt() + (2.0 * RADIUS_M * 100.3).sqrt();
    let target = format!(
        "[{{ name = \"t\", position_m = [{range_m:.3}, 0, 100], velocity_mps = [250, 0, -3], rcs_m2 = 1000 }}]"
    );
    let [window, ..] = at_range(range_m);
    let settings = [(window.0, window.1.as_str()), ("target", &target)];
    let fast = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", "-60.0")];
    keeps_the_error("horizon", &scene(&dry(), &[&settings[..], &fast].concat()));
}
