//! `nereus export sigmf`.

use std::fs;

use crate::listing::listing;
use crate::program::{nereus, package};

#[test]
fn a_recording_becomes_sigmf() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = package().join("configs/selftest.toml").display().to_string();
    let (kind, name) = if cfg!(feature = "hdf5") { ("hdf5", "self.h5") } else { ("plain", "self") };
    let sink = format!("sink=[{{ kind = '{kind}', path = '{name}' }}]");
    let ended = nereus(folder.path(), &["run", &scenario, "--pulses", "0..8", "--set", &sink]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let export = |arguments: &[&str]| nereus(folder.path(), &[&["export", "sigmf"], arguments].concat());
    let ended = export(&[name, "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((&report["pulses"], &report["channels"][0]), (&8.into(), &"VV".into()), "{report}");
    let made: Vec<String> =
        report["out"].as_array().unwrap().iter().map(|f| f.as_str().unwrap().to_owned()).collect();
    assert!(
        made.contains(&"self-VV.sigmf-meta".to_owned())
            && made.iter().all(|f| folder.path().join(f).exists())
    );
    assert!(made.contains(&"self.sigmf-collection".to_owned()), "echo, tone and loopback: {made:?}");
    let one = export(&[name, "--channel", "VV", "--pulses", "2..4", "--out", "vv.sigmf-meta"]);
    assert_eq!((one.code, one.stdout.as_str()), (0, ""), "{}", one.stderr);
    assert!(
        one.stderr.contains("2 pulses of 1 channel") && one.stderr.contains("vv.sigmf-data"),
        "{}",
        one.stderr
    );
    let before = listing(folder.path());

    // What cannot be exported: an error that names it, and no file.
    let whole = fs::read(folder.path().join(if name == "self" { "self/iq.bin" } else { name })).unwrap();
    let refused = |arguments: &[&str], words: &str| {
        let ended = export(arguments);
        assert!(ended.code == 2 && ended.stderr.contains(words), "{}: {}", ended.code, ended.stderr);
    };
    refused(&["nothing.h5"], "nothing.h5");
    refused(&[name, "--channel", "HH", "--out", "hh"], "has no channel HH; allowed: VV");
    refused(&[name], "exists already");
    fs::write(folder.path().join("thesis.h5"), "chapter 1").unwrap();
    refused(&["thesis.h5"], "thesis.h5");
    fs::remove_file(folder.path().join("thesis.h5")).unwrap();
    assert_eq!(listing(folder.path()), before);
    if cfg!(feature = "hdf5") {
        fs::write(folder.path().join("cut.h5"), &whole[..whole.len() / 2]).unwrap();
        let ended = export(&["cut.h5"]);
        assert!([1, 2].contains(&ended.code) && ended.stderr.contains("cut.h5"), "{}", ended.stderr);
        fs::remove_file(folder.path().join("cut.h5")).unwrap();
        assert_eq!(listing(folder.path()), before);
    }
}
