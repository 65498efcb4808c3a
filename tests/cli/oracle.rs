//! Recordings against `tools/oracle.py`, which recomputes pulses from first principles.

use std::fs;
use std::process::Command;

use crate::program::{nereus, package};

/// A scenario without noise and converter, which the oracle cannot predict.
fn noiseless(name: &str) -> String {
    let text = fs::read_to_string(package().join("configs").join(name)).unwrap();
    let tracks = package().join("configs/tracks");
    let mut kept = Vec::new();
    let mut converter = false;
    for line in text.lines() {
        if line.starts_with('[') {
            converter = line.trim() == "[radar.adc]";
        }
        if !converter && !line.starts_with("noise_figure_db") && !line.starts_with("adc ") {
            kept.push(line.replace("\"tracks/", &format!("\"{}/", tracks.display())));
        }
    }
    kept.join("\n")
}

#[test]
fn recordings_are_what_an_independent_program_computes() {
    let python = |script: &str| Command::new("python3").args(["-c", script]).output();
    if !python("import numpy, h5py, tomllib").is_ok_and(|ended| ended.status.success()) {
        println!("skipped: no python3 with numpy and h5py");
        return;
    }
    for name in ["coastal.toml", "quickstart.toml", "monostatic.toml", "spaceborne.toml"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), noiseless(name)).unwrap();
        let run = ["run", name, "--pace", "fast", "--pulses", "0..40", "--out", "run.h5"];
        let ended = nereus(folder.path(), &run);
        assert_eq!(ended.code, 0, "{name}: {}", ended.stderr);
        let oracle = Command::new("python3")
            .arg(package().join("tools/oracle.py"))
            .args(["run.h5", "--count", "2", "--limit-db", "-100"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&oracle.stdout);
        println!("{name}: {text}");
        // f32 samples round to -140 dB of a sample; -100 dB is the agreement asked of an oracle.
        assert!(oracle.status.success(), "{name}: {text}{}", String::from_utf8_lossy(&oracle.stderr));
    }
}
