//! What `check` reports of recorded tracks.

use crate::program::{nereus, package};

/// Before: 876 faults, twenty of them printed and none with the key, and the next fault only once these were
/// gone.
#[test]
fn gaps_and_turns_of_a_track_are_reported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = package().join("configs/quickstart.toml").display().to_string();
    let track = package().join("configs/tracks/strait_of_dover.csv").display().to_string();
    let check = |more: &str| {
        let track =
            format!("platform.1.track={{ kind = 'csv', path = '{track}', datum = 'barometric'{more} }}");
        let ended = nereus(folder.path(), &["check", &scenario, "--set", &track]);
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        ended.stderr
    };
    let gaps = "1 fault\n  line 5: no fix for 10.000 s before 2020-04-17T04:10:10.000000Z, the first of 876 gaps, the \
                longest 10.000 s before 2020-04-17T04:10:10.000000Z; longest gap allowed: max_gap_s = 5 s; \
                max_gap_s = 10 interpolates them all\n";
    let turn = "the attitude turns by 93.7 deg to the fix at 2020-04-17T05:46:10.000000Z; allowed: 90 deg between fixes; \
                where it is derived from noisy fixes, track.smoothing (kind = \"rts\") evens them out";
    let report = check("");
    assert!(report.contains(gaps) && report.contains(turn), "{report}");
    let report = check(", max_gap_s = 10");
    assert!(!report.contains("no fix for") && report.contains(turn), "{report}");
}
