//! `nereus doctor`: every check has a verdict, what is to improve has a remedy, and nothing stays behind.

use std::fs;

use serde_json::Value;

use crate::program::nereus;

#[test]
fn every_check_has_a_verdict_and_a_remedy_where_it_helps() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["doctor", "--seconds", "0.5", "--prf-hz", "200", "--busy-threads", "1", "--json"];
    let ended = nereus(folder.path(), &arguments);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: Value = serde_json::from_str(&ended.stdout).unwrap();
    let findings = report["findings"].as_array().unwrap();
    let checks: Vec<&str> = findings.iter().map(|finding| finding["check"].as_str().unwrap()).collect();
    assert_eq!(
        checks,
        [
            "real-time priority",
            "locked memory",
            "processors",
            "frequency governor",
            "clock source",
            "receive buffer",
            "send buffer",
            "memory",
            "large pages",
            "HDF5",
            "disk"
        ]
    );
    for finding in findings {
        let to_improve = finding["verdict"] == "improve";
        assert_eq!(finding["remedy"].is_string(), to_improve, "{finding}");
        assert!(!finding["found"].as_str().unwrap().is_empty(), "{finding}");
        assert_eq!(finding["value"].is_number(), finding["unit"].is_string(), "{finding}");
    }
    assert_eq!(findings[9]["verdict"] == "fine", cfg!(feature = "hdf5"));
    let lateness = &report["lateness"];
    assert_eq!((&lateness["pulses"], &lateness["busy_threads"]), (&100.into(), &1.into()));
    let us = |key: &str| lateness[key].as_f64().unwrap();
    assert!(us("p50_us") <= us("p99_us") && us("p99_us") <= us("max_us"), "{lateness}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_text_ends_with_what_is_to_improve() {
    let folder = tempfile::tempdir().unwrap();
    let ended = nereus(folder.path(), &["doctor", "--seconds", "0"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    assert!(
        ended.stdout.starts_with("this machine\n") && !ended.stdout.contains("lateness"),
        "{}",
        ended.stdout
    );
    let last = ended.stdout.lines().last().unwrap();
    let remedies = ended.stdout.lines().filter(|line| line.trim_start().starts_with("-> ")).count();
    match remedies {
        0 => assert_eq!(last, "nothing to improve was found"),
        1 => assert_eq!(last, "1 thing to improve"),
        more => assert_eq!(last, format!("{more} things to improve")),
    }
}

#[test]
fn a_folder_that_is_missing_and_times_out_of_range_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [&["doctor", "missing"][..], &["doctor", "--seconds", "-1"], &["doctor", "--prf-hz", "0"]];
    for arguments in cases {
        let refused = nereus(folder.path(), arguments);
        assert!(refused.code == 2 && refused.stdout.is_empty(), "{arguments:?}: {}", refused.stderr);
    }
    assert!(nereus(folder.path(), &["doctor", "missing"]).stderr.contains("missing"));
}
