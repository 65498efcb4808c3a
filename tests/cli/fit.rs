//! `nereus fit`, as a user starts it, on a small sea. What a machine keeps up with is its own affair: what is
//! wanted is some times what it just reached, and changes are judged by the cost model.

use std::path::Path;

use crate::program::{Ended, nereus, package};

/// The paper's scene on 64 x 64 facets.
const SMALL: [&str; 4] = ["--set", "scene.patch_size_m=[64,64]", "--set", "scene.duration_s=0.2"];

fn mars(folder: &Path, command: &str, more: &[&str]) -> Ended {
    let config = package().join("configs/mars-1.toml").display().to_string();
    nereus(folder, &[&[command, &config], &SMALL[..], more].concat())
}

fn json(ended: &Ended) -> serde_json::Value {
    assert_eq!(ended.stdout.lines().count(), 1, "{}{}", ended.stdout, ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// Speed on the reference machine by the cost model, and the error that is predicted, of the run with some
/// settings: it is legal.
fn checked(folder: &Path, sets: &[&str]) -> (f64, f64) {
    let words: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).chain(["--json"]).collect();
    let ended = mars(folder, "check", &words);
    assert_eq!(ended.code, 0, "{sets:?}: {}", ended.stderr);
    let plan = &json(&ended)["plan"];
    (number(&plan["predicted_real_time_factor"]), number(&plan["predicted_rel_rms_db"]))
}

/// The speed of this machine, by a margin that every machine reaches; nothing is changed.
#[test]
fn what_fits_needs_no_change() {
    let folder = tempfile::tempdir().unwrap();
    let ended = mars(folder.path(), "fit", &["--real-time", "--margin", "1e-6", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let found = json(&ended);
    assert_eq!((&found["fits"], &found["error_db"]), (&true.into(), &(-60.0).into()), "{found}");
    assert!(found["remedies"].as_array().unwrap().is_empty() && found["nearest"].is_null(), "{found}");
    // With so little wanted the finest error of the ladder fits as well.
    assert!(number(&found["fits_at_db"]) < -60.0, "{found}");
    let text = mars(folder.path(), "fit", &["--margin", "1e-6"]).stdout;
    assert!(text.contains(": fits: ") && text.contains(" times real time at -60 dB with "), "{text}");
    assert!(!text.contains("--set"), "{text}");
}

/// Changes are predicted, not measured: each is a legal scenario, and as much cheaper by the plan that is
/// then made as was predicted from that of the scenario as written.
#[test]
fn a_scenario_that_is_too_heavy_becomes_one_that_fits() {
    let folder = tempfile::tempdir().unwrap();
    let fit = |margin: f64, more: &[&str]| {
        let margin = margin.to_string();
        mars(folder.path(), "fit", &[&["--margin", &margin, "--trial-ms", "0"], more].concat())
    };
    let factor = number(&json(&fit(1e-6, &["--json"]))["real_time_factor"]);
    let ended = fit(2.0 * factor, &["--json"]);
    let found = json(&ended);
    if found["fits"] == true {
        return eprintln!("skipped: the machine has become twice as fast meanwhile");
    }
    let written = number(&found["real_time_factor"]);
    let (cost_model, _) = checked(folder.path(), &[]);
    // Where the machine has slowed down meanwhile, nothing may fit, and the nearest miss is judged instead.
    let remedies = found["remedies"].as_array().unwrap();
    assert_eq!(ended.code, i32::from(remedies.is_empty()), "{found}");
    let mut harm = 0.0;
    for remedy in if remedies.is_empty() { std::slice::from_ref(&found["nearest"]) } else { remedies } {
        let sets: Vec<&str> = remedy["set"].as_array().unwrap().iter().map(|s| s.as_str().unwrap()).collect();
        assert!(matches!(sets.len(), 1 | 2), "{remedy}");
        let faster = number(&remedy["predicted_factor"]);
        assert_eq!(faster >= 2.0 * factor, !remedies.is_empty(), "{remedy}");
        assert!(remedy["real_time_factor"].is_null(), "{remedy}");
        let predicted = faster / written;
        assert!(number(&remedy["harm"]) >= harm, "least harm first: {found}");
        harm = number(&remedy["harm"]);
        // Threads are those of the machine, and no part of the costs of a pulse.
        let (changed, error_db) = checked(folder.path(), &sets);
        assert!(
            (0.8..1.25).contains(&(changed / cost_model / predicted)),
            "{remedy}: {changed} {cost_model}"
        );
        assert!((error_db - number(&remedy["predicted_rel_rms_db"])).abs() < 1e-9, "{remedy}: {error_db}");
    }
    let text = fit(1e9, &[]).stdout;
    assert!(text.contains(": does not fit: "), "{text}");
}

/// Exit 1, with what comes nearest and what limits it.
#[test]
fn where_nothing_fits_the_nearest_miss_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let ended = mars(folder.path(), "fit", &["--margin", "1e9", "--trial-ms", "0", "--json"]);
    assert_eq!(ended.code, 1, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("nothing that was tried makes it run at 1000000000 times"),
        "{}",
        ended.stderr
    );
    let found = json(&ended);
    assert!(found["remedies"].as_array().unwrap().is_empty(), "{found}");
    let nearest = &found["nearest"];
    assert!(number(&nearest["predicted_factor"]) > number(&found["real_time_factor"]), "{found}");
    assert_eq!(nearest["set"].as_array().unwrap().len(), 2, "{found}");
    assert!((0.0..=1.0).contains(&number(&found["limit"]["share"])), "{found}");
}

/// The fast echo comes in place of the reference, and what is wrong is wrong here, too.
#[test]
fn the_reference_becomes_the_fast_echo_and_faults_exit_2() {
    let folder = tempfile::tempdir().unwrap();
    let small = ["--set", "scene.patch_size_m=[32,32]", "--set", "fidelity.echo=reference"];
    let more = ["--margin", "1e9", "--trial-ms", "0", "--json"];
    let found = json(&mars(folder.path(), "fit", &[&small[..], &more].concat()));
    assert!(found["error_db"].is_null(), "{found}");
    assert_eq!(found["nearest"]["set"][0], "fidelity.echo=fast", "{found}");
    for (wrong, expected) in
        [(["--margin", "0"], "allowed: a number above 0"), (["--set", "sea.x=1"], "sea.x")]
    {
        let ended = mars(folder.path(), "fit", &wrong);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
        assert!(ended.stderr.contains(expected), "{}", ended.stderr);
    }
}

/// `check` answers beside its forecast, and where the answer is no, what is predicted to help.
#[test]
fn check_answers_whether_it_runs_in_real_time() {
    let folder = tempfile::tempdir().unwrap();
    let line = |stdout: &str| {
        stdout.lines().find(|line| line.trim_start().starts_with("real time")).unwrap().trim().to_owned()
    };
    // A pulse a second is kept up with anywhere, a million nowhere.
    let slow = mars(folder.path(), "check", &["--set", "radar.prf_hz=1", "--set", "scene.duration_s=20"]);
    assert!(line(&slow.stdout).contains("yes at -60 dB ("), "{}", slow.stdout);
    let busy = ["--set", "radar.prf_hz=200000", "--set", "scene.duration_s=0.001"];
    let busy = [&busy[..], &["--set", "radar.window.start_us=1", "--json"]].concat();
    let found = json(&mars(folder.path(), "check", &busy));
    assert_eq!(found["fits"], false, "{found}");
    for remedy in found["remedies"].as_array().unwrap() {
        assert!(number(&remedy["real_time_factor"]) >= 1.15 - 1e-9, "{remedy}");
    }
}
