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

/// Whether the oracle can run; if not, says so.
fn can_judge() -> bool {
    let ended = Command::new("python3").args(["-c", "import numpy, h5py, tomllib"]).output();
    let can = ended.is_ok_and(|ended| ended.status.success());
    if !can {
        println!("skipped: no python3 with numpy and h5py");
    }
    can
}

/// Records pulses of a scenario and has a few of them judged.
fn judge(name: &str, scenario: &str, settings: &[&str], pulses: &str, count: &str) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), scenario).unwrap();
    let mut run = vec!["run", name, "--pace", "fast", "--pulses", pulses, "--out", "run.h5"];
    run.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    let ended = nereus(folder.path(), &run);
    assert_eq!(ended.code, 0, "{name}: {}", ended.stderr);
    let oracle = Command::new("python3")
        .arg(package().join("tools/oracle.py"))
        .args(["run.h5", "--count", count, "--limit-db", "-100"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&oracle.stdout);
    println!("{name} {settings:?}: {text}");
    // f32 samples round to -140 dB of a sample; -100 dB is the agreement asked of an oracle.
    assert!(
        oracle.status.success(),
        "{name} {settings:?}: {text}{}",
        String::from_utf8_lossy(&oracle.stderr)
    );
}

#[test]
fn recordings_are_what_an_independent_program_computes() {
    if !can_judge() {
        return;
    }
    for name in ["coastal.toml", "calibration.toml", "monostatic.toml", "spaceborne.toml"] {
        judge(name, &noiseless(name), &["fidelity.echo=reference"], "0..40", "2");
    }
}

/// The paper's scenes on 64 x 64 facets while the beam passes over them; what the oracle does not know
/// (shadows that fall, means over cells of the spectrum) is switched off.
#[test]
fn the_sea_is_what_an_independent_program_computes() {
    if !can_judge() {
        return;
    }
    let small = ["scene.patch_size_m=[64, 64]", "sea.averaging=points", "fidelity.echo=reference", "ship=[]"];
    let with = |more: &[&'static str]| [&small[..], more].concat();
    judge("mars-1.toml", &noiseless("mars-1.toml"), &small, "234..266", "4");
    let paper = ["sea.scattering.splitting=mars2007", "sea.scattering.phases=single"];
    judge("mars-1.toml", &noiseless("mars-1.toml"), &with(&paper), "249..251", "1");
    let bright = ["sea.shadow.enabled=false"];
    for name in ["mars-3.toml", "mars-4.toml"] {
        judge(name, &noiseless(name), &with(&bright), "249..251", "1");
    }
    // A minute into the flight: the patch has gone a kilometre.
    judge("mars-live.toml", &live(), &with(&bright), "13320..13322", "1");
}

/// `mars-live.toml` with a recording.
fn live() -> String {
    noiseless("mars-live.toml").replace("kind = \"null\"", "kind = \"hdf5\"\npath = \"live.h5\"")
}
