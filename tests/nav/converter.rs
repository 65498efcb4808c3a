//! `tools/convert_adsb.py`, where Python is there.

use std::process::{Command, Output};

use nereus::nav::load;

use crate::sources;

fn convert(arguments: &[&str]) -> Option<Output> {
    let run =
        Command::new("python3").arg(sources::repository("tools/convert_adsb.py")).args(arguments).output();
    if run.is_err() {
        println!("skipped: no python3");
    }
    run.ok()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn an_altitude_of_39000_ft_is_rejected_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("georeal.csv");
    let input = sources::repository("tests/data/nav/georeal_outlier.json.gz");
    let (input, out) = (input.to_str().unwrap(), out.to_str().unwrap());
    let Some(run) = convert(&[input, out, "--end", "2018-04-19T10:58:00Z"]) else { return };
    let report = text(&run.stderr);
    assert!(run.status.success(), "{report}");
    assert!(report.contains("rejected 2018-04-19T10:58:00Z: altitude 11887 m"), "{report}");
    let mut source = sources::adsb(out, 2.9);
    source.max_gap_s = 60.0;
    let highest = load(&source)
        .unwrap()
        .fixes
        .iter()
        .map(|fix| match fix.place {
            nereus::nav::Place::Geodetic(g) => g.h_m,
            nereus::nav::Place::Local(p) => p.to_array()[2],
        })
        .fold(0.0, f64::max);
    // 5,800 ft and the undulation.
    assert!(highest < 1900.0, "{highest}");
    // Not twice over the same file, unless asked to.
    let Some(again) = convert(&[input, out]) else { return };
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("exists; give --force"), "{}", text(&again.stderr));
}

#[test]
fn wrong_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let out = path("out.csv");
    std::fs::write(path("list.json"), "[1, 2]").unwrap();
    std::fs::write(path("half.json.gz"), [0x1f, 0x8b, 8, 0, 0]).unwrap();
    std::fs::write(path("empty.json"), "[]").unwrap();
    for (input, words) in [
        ("missing.json", "cannot read"),
        ("list.json", "expected a JSON array of objects"),
        ("half.json.gz", "not (gzipped) JSON"),
        ("empty.json", "0 usable rows"),
    ] {
        let Some(run) = convert(&[&path(input), &out]) else { return };
        let report = text(&run.stderr);
        assert_eq!(run.status.code(), Some(2), "{report}");
        assert!(report.contains(words) && report.contains(input), "{report}");
        assert!(!std::path::Path::new(&out).exists());
    }
    let Some(run) = convert(&["--help"]) else { return };
    assert!(run.status.success());
}
