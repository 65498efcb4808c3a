//! `check` of ships, faults of their hulls, and their echo.

use std::fs;

use crate::program::{Ended, nereus, package};

/// Checks a small patch of the first MaRS scene with settings.
fn check(settings: &[&str]) -> Ended {
    let mut words = vec!["check", "configs/mars-1.toml", "--set", "scene.patch_size_m=[32, 32]"];
    words.extend(["--set", "scene.duration_s=0.01"]);
    settings.iter().for_each(|setting| words.extend(["--set", setting]));
    nereus(package(), &words)
}

#[test]
fn figures_of_a_ship_are_reported() {
    let ended = check(&[]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for words in [
        "heading 90 deg from North at 4.5 m/s; Kelvin wake; turbulent wake",
        "Froude number 0.144",
        "transverse waves 12.97 m long",
        "its wake is resolved",
        "offsets agree with the stated particulars; largest deviation 1.54 % (wetted surface)",
        "echo = false",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    assert!(!ended.stderr.contains("ship"), "{}", ended.stderr);
}

#[test]
fn wakes_that_do_not_show_are_warned_of() {
    let cases: [(&str, &str); 6] = [
        ("ship.0.speed_mps=1", "the longest, 0.64 m, are shorter than 4 facets of 1 m"),
        ("ship.0.speed_mps=0.05", "raises no waves at 0.05 m/s"),
        ("ship.0.speed_mps=0", "raises no waves at 0 m/s"),
        ("ship.0.band_limit_radpm=0.05", "beyond its band limit of 0.05 rad/m"),
        (
            "ship.0.position_m=[3000, 0]",
            "outside the patch of sea at the start, middle and end of the run: its wake reaches it",
        ),
        ("ship.0.position_m=[-3000, 0]", "and so does its wake"),
    ];
    for (setting, words) in cases {
        let ended = check(&[setting]);
        assert!(ended.code == 0 && ended.stderr.contains(words), "{setting}: {}", ended.stderr);
        assert!(
            !ended.stdout.contains("NaN") && !ended.stdout.contains("inf "),
            "{setting}: {}",
            ended.stdout
        );
    }
    let silent = check(&["ship.0.echo=true", "ship.0.mesh=false"]);
    assert!(silent.code == 0 && silent.stderr.contains("its hull has no [[scatterer]]"), "{}", silent.stderr);
    let quiet = check(&["ship.0.wake=false", "ship.0.speed_mps=0"]);
    assert!(quiet.code == 0 && !quiet.stderr.contains("ship"), "{}", quiet.stderr);
    assert!(quiet.stdout.contains("wake = false"), "{}", quiet.stdout);
}

#[test]
fn faults_of_every_hull_are_reported_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("holes.csv"), "x_m/z_m,-2,-1,0\n0,0,0,0\n5,0.4,,1\n10,0,-1,0\n").unwrap();
    fs::write(path("order.csv"), "x_m/z_m,-2,-1,0\n0,0,0,0\n-5,0.4,0.9,1\n10,0,0,0\n").unwrap();
    let ships = format!(
        "ship=[{{ hull = '{}', position_m = [0, 0], heading_deg = 0, speed_mps = 1 }}, \
         {{ hull = '{}', position_m = [0, 0], heading_deg = 0, speed_mps = 1 }}, \
         {{ hull = 'wigley', length_m = 1, beam_m = 2, draught_m = 0.1, position_m = [0, 0], heading_deg = 0, speed_mps = 1 }}]",
        path("holes.csv"),
        path("order.csv")
    );
    // With the radar, and where something else keeps it from being made.
    for others in [
        &[][..],
        &[
            "platform.0.track={ kind = 'csv', path = 'README.md', datum = 'msl' }",
            "scene.start_utc=2020-01-01T00:00:00Z",
        ],
    ] {
        let ended = check(&[&[ships.as_str()], others].concat());
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        for words in [
            "ship 'ship-0'",
            "holes.csv line 3",
            "holes.csv line 4",
            "ship 'ship-1'",
            "order.csv line 3",
            "ship 'ship-2'",
        ] {
            assert!(ended.stderr.contains(words), "{words}: {}", ended.stderr);
        }
    }
}

#[test]
fn scatterers_of_a_hull_sail_with_it_as_targets() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::copy(package().join("hulls/wigley.csv"), path("wigley.csv")).unwrap();
    let hull = "name = 'tug'\noffsets = 'wigley.csv'\n[[scatterer]]\nname = 'bridge top'\nforward_m = 5\n\
                starboard_m = 3\nup_m = 12\nrcs_m2 = 100\n";
    fs::write(path("tug.toml"), hull).unwrap();
    let ship = format!("ship.0.hull={}", path("tug.toml").display());
    let scenario = package().join("configs/mars-1.toml");
    // Northward: ahead is North, starboard East.
    let run = |out: &str, setting: &str| {
        let sinks = format!("sink=[{{ kind = 'plain', path = '{out}' }}]");
        let settings = [
            "scene.patch_size_m=[32, 32]",
            "scene.duration_s=0.05",
            "ship.0.heading_deg=0",
            "ship.0.position_m=[-20, 30]",
            &ship,
            &sinks,
            setting,
        ];
        let mut words = vec!["run", scenario.to_str().unwrap(), "--pace", "fast", "--pulses", "5..7"];
        settings.iter().for_each(|setting| words.extend(["--set", setting]));
        let ended = nereus(folder.path(), &words);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let samples = fs::read(path(out).join("iq.bin")).unwrap();
        let samples = samples.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        (samples.collect::<Vec<f32>>(), fs::read_to_string(path(out).join("meta.json")).unwrap())
    };
    let (silent, silent_meta) = run("silent", "ship.0.echo=false");
    let truth = |column: &str| -> Vec<f64> {
        let bytes = fs::read(path("silent").join(format!("truth/{column}.bin"))).unwrap();
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    };
    // Pulses 5 and 6 of a PRF of 222 Hz; midship on the sea, 4.5 m/s to the North.
    let north_m = [5.0, 6.0].map(|pulse| 30.0 + 4.5 * pulse / 222.0);
    for (found, wanted) in
        truth("ship_position_m").iter().zip([-20.0, north_m[0], 0.0, -20.0, north_m[1], 0.0])
    {
        assert!((found - wanted).abs() < 1e-3, "{found} {wanted}");
    }
    let [vx, vy, vz, ..] = truth("ship_velocity_mps")[..] else { panic!("no velocity") };
    assert!(vx.abs() < 1e-12 && (vy - 4.5).abs() < 1e-12 && vz.abs() < 1e-4);
    assert_eq!(truth("ship_heading_deg").len(), 2);
    assert!(truth("ship_heading_deg").iter().all(|heading| heading.abs() < 1e-9));
    let meta: serde_json::Value = serde_json::from_str(&silent_meta).unwrap();
    assert_eq!(meta["ships"], serde_json::json!(["dtmb5415"]));
    let (hull, hull_meta) = run("hull", "ship.0.echo=true");
    let target = "target=[{ position_m = [-17, 35, 12], velocity_mps = [0, 4.5, 0], rcs_m2 = 100 }]";
    let (beside, _) = run("beside", target);
    assert!(hull_meta.contains("dtmb5415.bridge-top") && !silent_meta.contains("bridge-top"));
    let largest = beside.iter().fold(0f32, |most, v| most.max(v.abs()));
    let apart = |other: &[f32]| {
        assert_eq!(other.len(), beside.len());
        beside.iter().zip(other).fold(0f32, |most, (a, b)| most.max((a - b).abs())) / largest
    };
    // Sine and cosine of a right angle place it to 1e-14 m: a few last bits of an f32 may differ.
    assert!(apart(&hull) < 1e-6, "{}", apart(&hull));
    assert!(apart(&silent) > 0.1, "{}", apart(&silent));
}
