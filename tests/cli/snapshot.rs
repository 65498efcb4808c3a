//! `nereus snapshot`: levels, files, and what is refused.

use std::fs;
use std::path::Path;

use crate::program::{Ended, nereus, package};

/// The paper's first scene on 64 x 64 facets.
fn snapshot(folder: &Path, arguments: &[&str]) -> Ended {
    let scenario = package().join("configs/mars-1.toml");
    let scenario = scenario.to_str().unwrap().to_owned();
    let small = ["--set", "scene.patch_size_m=[64, 64]"];
    let words: Vec<&str> =
        ["snapshot", scenario.as_str()].iter().chain(&small).chain(arguments).copied().collect();
    nereus(folder, &words)
}

#[test]
fn levels_are_those_of_the_radar_equation() {
    let folder = tempfile::tempdir().unwrap();
    // Pulse 250 is lit from abeam.
    let ended = snapshot(folder.path(), &["--pulse", "250", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    assert_eq!((report["facets"].as_u64(), report["heard"].as_u64()), (Some(4096), Some(4096)));
    let channel = |name: &str| {
        let rows = report["channels"].as_array().unwrap();
        rows.iter().find(|row| row[0] == name).unwrap()[2].as_f64().unwrap()
    };
    // A facet of 1 m^2 on the beam's axis returns -156.3 dBW in VV at a cross section of -16.7 dB (golden notes), which is that
    // of level water across the wind; the tilts of the waves and 30 deg from the wind bring up to 4 dB. The beam leaves
    // the integral of sinc^4 over u = 4 m / wavelength: 2/3 wavelength/4 m of 4243 m = 21.2 m, times 64 m.
    let level_dbw = -156.3 + 10.0 * f64::log10(21.2 * 64.0);
    let found = channel("VV");
    println!("VV sum {found:.1} dBW, level water {level_dbw:.1} dBW");
    assert!((level_dbw - 1.0..level_dbw + 5.0).contains(&found));
    assert!(channel("HH") < channel("VV") - 4.0 && channel("HV") < channel("HH") - 8.0);
    assert!((channel("HV") - channel("VH")).abs() < 0.01);
}

#[test]
fn pictures_and_maps_are_whole_or_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let ended = snapshot(folder.path(), &["--png", "facets.png", "--channel", "HH"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let picture = fs::read(folder.path().join("facets.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    let again = snapshot(folder.path(), &["--png", "facets.png"]);
    assert_eq!(again.code, 2);
    assert!(again.stderr.contains("facets.png"), "{}", again.stderr);
    assert_eq!(fs::read(folder.path().join("facets.png")).unwrap(), picture);
}

#[cfg(feature = "hdf5")]
#[test]
fn the_map_has_every_channel_and_what_the_window_hears() {
    let folder = tempfile::tempdir().unwrap();
    // A window that ends within the patch.
    let ended =
        snapshot(folder.path(), &["--pulse", "250", "--out", "f.h5", "--set", "radar.window.samples=118"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let file = hdf5::File::open(folder.path().join("f.h5")).unwrap();
    let read = |name: &str| file.dataset(name).unwrap().read_raw::<f32>().unwrap();
    for name in ["contribution_dbw_HH", "contribution_dbw_HV", "contribution_dbw_VH", "contribution_dbw_VV"] {
        // In the nulls of the antennas there is next to nothing, but no facet is dark.
        assert!(read(name).iter().all(|dbw| dbw.is_finite() && *dbw < -100.0), "{name}");
    }
    let (delay_us, heard) = (read("delay_us"), read("heard"));
    // The window opens at 26.8 us and listens 32 samples beyond its 118.
    for (delay_us, heard) in delay_us.iter().zip(&heard) {
        assert_eq!(*heard == 1.0, *delay_us < 26.8 + 1.50, "{delay_us} us");
    }
    assert!(heard.contains(&0.0) && heard.contains(&1.0));
}

#[test]
fn wrong_input_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, said) in [
        (&["--channel", "XX"][..], "no channel 'XX'; allowed: HH, HV, VH, VV"),
        (&["--pulse", "500"][..], "allowed: 0 to 499"),
    ] {
        let ended = snapshot(folder.path(), arguments);
        assert_eq!(ended.code, 2);
        assert!(ended.stderr.contains(said), "{}", ended.stderr);
    }
    let coastal = package().join("configs/coastal.toml");
    let ended = nereus(folder.path(), &["snapshot", coastal.to_str().unwrap()]);
    assert!(ended.code == 2 && ended.stderr.contains("no [sea]"), "{}", ended.stderr);
}
