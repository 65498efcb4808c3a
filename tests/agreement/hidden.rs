//! Targets hidden by land: where they go dark by plane geometry, and that both echoes agree.

use std::fmt::Write as _;

use nereus::config::Run;
use nereus::frames::Earth;
use nereus::paths::list::ScattererPaths;
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;

use crate::land::{AT_REST, C_MPS, FIXED, hill, scene};
use crate::runs::keeps_the_error;

const FACET_M: f64 = 4.0;
/// The edge of the ridge away from the radar: the last cell above the sea, 7.5 m from the middle.
const EDGE_M: f64 = 1967.5;
const RIDGE_M: f64 = 15.0;

fn ridge([x, _]: [f64; 2]) -> f64 {
    if (x - 1960.0).abs() < 8.0 { RIDGE_M } else { -1.0 }
}

/// A small patch far from all targets.
const ASIDE: [(&str, &str); 4] = [
    ("scene.patch_size_m", "[16.0, 16.0]"),
    ("scene.patch_centre_m", "[1900.0, 100.0]"),
    ("fidelity.echo", "\"reference\""),
    ("radar.window.samples", "448"),
];

fn paths_at(run: &Run, pulses: &[u64]) -> Vec<ScattererPaths> {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    pulses.iter().map(|pulse| factory.scatterer_paths(*pulse).unwrap().1).collect()
}

/// Amplitude of what lies at a distance, beside others or not at all.
fn at(paths: &ScattererPaths, range_m: f64) -> f64 {
    let found = paths.delay_s[0].iter().zip(&paths.amplitude[0]);
    found.filter(|(delay_s, _)| (0.5 * C_MPS * **delay_s - range_m).abs() < 1e-3).map(|(_, a)| a.norm()).sum()
}

fn targets(of: impl Iterator<Item = [f64; 2]>, velocity: &str) -> String {
    let mut text = String::from("[");
    for [x, z] in of {
        write!(text, "{{ position_m = [{x:?}, 0.0, {z:?}], velocity_mps = {velocity}, rcs_m2 = 1.0 }}, ")
            .unwrap();
    }
    text + "]"
}

#[test]
fn a_ridge_hides_targets_up_to_its_shadow_and_height() {
    for earth in ["\"flat\"", "\"curved\""] {
        let places: Vec<[f64; 2]> = (0..60)
            .map(|n| [2010.0 + 2.0 * f64::from(n), 0.0])
            .chain((0..40).map(|n| [2030.0, 0.25 * f64::from(n)]))
            .collect();
        let list = targets(places.iter().copied(), "[0.0, 0.0, 0.0]");
        let settings = [&[AT_REST, ("scene.earth", earth), ("target", &list)], &ASIDE[..]].concat();
        let run = scene(&settings, ridge);
        let earth_of = run.scene.frame.earth();
        assert_eq!(earth_of == Earth::Flat, earth == "\"flat\"");
        let (with, without) = (&paths_at(&run, &[0])[0], &paths_at(&scene(&settings, |_| -1.0), &[0])[0]);
        let (mut hidden, mut seen) = (0, 0);
        for [x, z] in places {
            let lowered = z - earth_of.drop_m(x, 0.0);
            let range_m = x.hypot(lowered - 300.0);
            // Height of the line over the edge, at the target.
            let line_m = 300.0 - (300.0 - RIDGE_M + earth_of.drop_m(EDGE_M, 0.0)) * x / EDGE_M;
            let share = at(with, range_m) / at(without, range_m);
            // A facet along the line falls by 4 m of 300/2000, and the soft edge is less than half a metre.
            let step_m = FACET_M * 300.0 / EDGE_M;
            if lowered < line_m - step_m {
                hidden += 1;
                assert!(share == 0.0, "{x} {z}: {share}");
            } else if lowered > line_m + 0.5 {
                seen += 1;
                assert!((share - 1.0).abs() < 1e-9, "{x} {z}: {share}");
            }
        }
        println!("{earth}: {hidden} hidden, {seen} seen");
        assert!(hidden > 30 && seen > 20);
    }
}

#[test]
fn a_target_goes_dark_within_a_facet_of_the_shadow() {
    // It leaves the shadow of the ridge, which ends at 1967.5 x 300/285 m, at 60 m/s.
    let ends_m = EDGE_M * 300.0 / (300.0 - RIDGE_M);
    let list = targets([[2055.0, 0.0]].into_iter(), "[60.0, 0.0, 0.0]");
    let settings = [&[AT_REST, ("target", &list[..]), ("scene.duration_s", "0.6")], &ASIDE[..]].concat();
    let pulses: Vec<u64> = (0..133).step_by(2).collect();
    let with = paths_at(&scene(&settings, ridge), &pulses);
    let without = paths_at(&scene(&settings, |_| -1.0), &pulses);
    let (mut last_dark_m, mut first_full_m) = (0f64, f64::INFINITY);
    for ((pulse, with), without) in pulses.iter().zip(&with).zip(&without) {
        let x = 2055.0 + 60.0 * *pulse as f64 / 222.0;
        // On the way of light it goes on by 0.4 mm.
        let range_m = x.hypot(300.0);
        let share = at(with, range_m) / at(without, range_m);
        if share == 0.0 {
            last_dark_m = last_dark_m.max(x);
        } else if share > 0.999 {
            first_full_m = first_full_m.min(x);
        }
    }
    println!("dark to {last_dark_m:.1} m, seen from {first_full_m:.1} m; the shadow ends at {ends_m:.1} m");
    assert!((last_dark_m - ends_m).abs() < 1.2 * FACET_M && (first_full_m - ends_m).abs() < 1.2 * FACET_M);
    assert!(last_dark_m <= first_full_m);
}

#[test]
fn targets_behind_an_island_are_the_same_in_both_echoes() {
    let places = (0..10).map(|n| [2160.0 + 24.0 * f64::from(n), 1.0]);
    let list = targets(places, "[60.0, 2.0, 0.0]");
    let fast = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", "-60.0"), ("scene.duration_s", "0.09")];
    let settings = [&[FIXED, ("target", &list[..])], &fast[..]].concat();
    let run = scene(&settings, hill);
    let (first, last) = (&paths_at(&run, &[0])[0], &paths_at(&run, &[run.scene.pulses - 1])[0]);
    // Ten targets and the facets that are seen: some of the former come out.
    println!("{} and {} paths", first.len(), last.len());
    keeps_the_error("hidden by land", &run);
}
