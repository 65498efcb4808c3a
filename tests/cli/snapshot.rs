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
    // Pulse 250 is illuminated from abeam.
    let ended = snapshot(folder.path(), &["--pulse", "250", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    assert_eq!((report["facets"].as_u64(), report["received"].as_u64()), (Some(4096), Some(4096)));
    let channel = |name: &str| {
        let rows = report["channels"].as_array().unwrap();
        rows.iter().find(|row| row[0] == name).unwrap()[2].as_f64().unwrap()
    };
    // A facet of 1 m^2 on the beam's axis returns -156.3 dBW in VV at a cross section of -16.7 dB (golden
    // notes), which is that of level water across the wind; the tilts of the waves and 30 deg from the wind
    // bring up to 4 dB. The beam leaves the integral of sinc^4 over u = 4 m / wavelength: 2/3 wavelength/4 m
    // of 4243 m = 21.2 m, times 64 m.
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
fn the_map_has_every_channel_and_what_the_window_receives() {
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
    let (delay_us, received) = (read("delay_us"), read("received"));
    // The window opens at 26.8 us and listens 32 samples beyond its 118.
    for (delay_us, received) in delay_us.iter().zip(&received) {
        assert_eq!(*received == 1.0, *delay_us < 26.8 + 1.50, "{delay_us} us");
    }
    assert!(received.contains(&0.0) && received.contains(&1.0));
}

#[test]
fn wrong_input_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        (&["--channel", "XX"][..], "no channel 'XX'; allowed: HH, HV, VH, VV"),
        (&["--pulse", "500"][..], "allowed: 0 to 499"),
    ] {
        let ended = snapshot(folder.path(), arguments);
        assert_eq!(ended.code, 2);
        assert!(ended.stderr.contains(words), "{}", ended.stderr);
    }
    let coastal = package().join("configs/coastal.toml");
    let ended = nereus(folder.path(), &["snapshot", coastal.to_str().unwrap()]);
    assert!(ended.code == 2 && ended.stderr.contains("no [sea]"), "{}", ended.stderr);
}

/// Paths of a scenario of two targets, no sea.
#[cfg(feature = "hdf5")]
#[test]
fn paths_are_those_of_the_pulse() {
    let folder = tempfile::tempdir().unwrap();
    let coastal = package().join("configs/coastal.toml").display().to_string();
    let ask = ["snapshot", &coastal, "--pulse", "137", "--paths", "c.h5", "--json"];
    let ended = nereus(folder.path(), &ask);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
    assert_eq!((&report["path_count"], &report["facets"]), (&2.into(), &0.into()));
    let ended =
        nereus(folder.path(), &["run", &coastal, "--pace", "fast", "--pulses", "137..139", "--out", "r.h5"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);

    let open = |name: &str| hdf5::File::open(folder.path().join(name)).unwrap();
    let (file, run) = (open("c.h5"), open("r.h5"));
    let number = |name: &str| file.attr(name).unwrap().read_scalar::<f64>().unwrap();
    assert_eq!((number("carrier_hz"), number("sample_rate_hz")), (10e9, 100e6));
    assert_eq!((number("bandwidth_hz"), number("pulse_s")), (60e6, 0.333e-6));
    assert_eq!(file.attr("pulse").unwrap().read_scalar::<u64>().unwrap(), 137);
    let read = |file: &hdf5::File, name: &str| file.dataset(name).unwrap().read_raw::<f64>().unwrap();
    assert_eq!(number("window_start_s"), read(&run, "pulse/window_start_s")[0]);
    // What the recording has as truth, two pulses of one pair and two targets.
    let truth = read(&run, "truth/delay_s");
    let delay_s = read(&file, "delay_s");
    assert_eq!(file.dataset("delay_s").unwrap().shape(), [1, 2]);
    assert_eq!(delay_s, truth[..2]);
    // The rate is the delay's: a difference over 1/222 s of a delay of 24 us, whose last digit is 3e-21 s,
    // misses it by half the interval times the rate of the rate, v^2/(R c) = 6e-8/s here at most.
    let rate = read(&file, "delay_rate");
    for (target, rate) in rate.iter().enumerate() {
        let difference = (truth[2 + target] - truth[target]) * 222.0;
        assert!((rate - difference).abs() < 6e-8 / 444.0, "{rate} {difference}");
    }
    let amplitude_of = file.dataset("amplitude").unwrap();
    assert_eq!(amplitude_of.shape(), [4, 2]);
    let amplitude = amplitude_of.read_raw::<num_complex::Complex<f64>>().unwrap();
    // The sphere (the first one) turns no polarisation: HV next to nothing beside HH.
    assert!(amplitude[0].norm() > 0.0 && amplitude[2].norm() < 0.2 * amplitude[0].norm(), "{amplitude:?}");
    assert_eq!(read(&file, "emission_offset_s"), [0.0, 0.0]);
    drop((amplitude_of, file, run));
    // A second time only by force, and never without being asked for a file.
    assert_eq!(nereus(folder.path(), &ask).code, 2);
    assert_eq!(nereus(folder.path(), &[&ask[..], &["--force"]].concat()).code, 0);
    let mapped = nereus(folder.path(), &[&ask[..5], &["d.h5", "--png", "d.png"]].concat());
    assert!(mapped.code == 2 && mapped.stderr.contains("no [sea]"), "{}", mapped.stderr);
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn paths_ask_for_hdf5() {
    let folder = tempfile::tempdir().unwrap();
    let ended = snapshot(folder.path(), &["--paths", "c.h5"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("no HDF5 (feature `hdf5`): c.h5"), "{}", ended.stderr);
}

#[test]
fn a_headland_throws_its_shadow_on_the_sea_and_a_boat() {
    let folder = tempfile::tempdir().unwrap();
    let coast = package().join("configs/coast.toml").display().to_string();
    let received = |more: &[&str]| {
        let ended = nereus(folder.path(), &[&["snapshot", &coast, "--pulse", "50", "--json"], more].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let report: serde_json::Value = serde_json::from_str(ended.stdout.trim()).unwrap();
        assert_eq!(report["facets"].as_u64(), Some(65536));
        (report["received"].as_u64().unwrap(), report["path_count"].as_u64())
    };
    let ((hidden, _), (open, _)) = (received(&[]), received(&["--set", "sea.shadow.enabled=false"]));
    // Behind the hills, and behind waves at five degrees; what lies with its back to the antennas is dark in
    // both.
    println!("{hidden} and {open} facets are received");
    assert!((35_000..45_000).contains(&hidden) && open > hidden + 4000);
    #[cfg(feature = "hdf5")]
    {
        let targets = |more: &[&str], name: &str| {
            let calm = ["--paths", name, "--set", "sea.scattering.breaking=off"];
            let (facets, count) = received(&[&calm, more].concat());
            count.unwrap() - facets
        };
        assert_eq!(targets(&[], "a.h5"), 1, "the buoy alone");
        assert_eq!(targets(&["--set", "sea.shadow.enabled=false"], "b.h5"), 2, "nothing hides the boat");
    }
}
