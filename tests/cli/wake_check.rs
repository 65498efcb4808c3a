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
fn figures_of_a_ship_are_said() {
    let ended = check(&[]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for said in [
        "heading 90 deg from North at 4.5 m/s; Kelvin wake; turbulent wake",
        "Froude number 0.144",
        "transverse waves 12.97 m long",
        "its wake is resolved",
        "furthest wetted_surface_m2 by 1.54 %",
        "echo = false",
    ] {
        assert!(ended.stdout.contains(said), "{said}: {}", ended.stdout);
    }
    assert!(!ended.stderr.contains("ship"), "{}", ended.stderr);
}

#[test]
fn wakes_that_do_not_show_are_warned_of() {
    let cases: [(&str, &str); 7] = [
        ("ship.0.speed_mps=1", "the longest, 0.64 m, are shorter than 4 facets of 1 m"),
        ("ship.0.speed_mps=0.05", "raises no waves at 0.05 m/s"),
        ("ship.0.speed_mps=0", "raises no waves at 0 m/s"),
        ("ship.0.band_limit_radpm=0.05", "beyond its band limit of 0.05 rad/m"),
        (
            "ship.0.position_m=[3000, 0]",
            "outside the patch of sea at the start, middle and end of the run: its wake reaches it",
        ),
        ("ship.0.position_m=[-3000, 0]", "and so does its wake"),
        ("ship.0.echo=true", "its hull has no [[scatterer]]"),
    ];
    for (setting, said) in cases {
        let ended = check(&[setting]);
        assert!(ended.code == 0 && ended.stderr.contains(said), "{setting}: {}", ended.stderr);
        assert!(
            !ended.stdout.contains("NaN") && !ended.stdout.contains("inf "),
            "{setting}: {}",
            ended.stdout
        );
    }
    let quiet = check(&["ship.0.wake=false", "ship.0.speed_mps=0"]);
    assert!(quiet.code == 0 && !quiet.stderr.contains("ship"), "{}", quiet.stderr);
    assert!(quiet.stdout.contains("wake = false"), "{}", quiet.stdout);
}

#[test]
fn faults_of_every_hull_are_said_with_file_and_line() {
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
        for said in [
            "ship 'ship-0'",
            "holes.csv line 3",
            "holes.csv line 4",
            "ship 'ship-1'",
            "order.csv line 3",
            "ship 'ship-2'",
        ] {
            assert!(ended.stderr.contains(said), "{said}: {}", ended.stderr);
        }
    }
}

#[test]
fn scatterers_of_a_hull_sail_with_it_as_targets() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::copy(package().join("hulls/wigley.csv"), path("wigley.csv")).unwrap();
    let hull = "name = 'tug'\noffsets = 'wigley.csv'\n[[scatterer]]\nname = 'bridge top'\nforward_m = 5\nstarboard_m = 0\nup_m = 12\nrcs_m2 = 100\n";
    fs::write(path("tug.toml"), hull).unwrap();
    let ship = format!("ship.0.hull={}", path("tug.toml").display());
    let small = ["--set", "scene.patch_size_m=[32, 32]", "--set", "scene.duration_s=0.05", "--set", &ship];
    let scenario = package().join("configs/mars-1.toml");
    let run = |echo: &str| {
        let words = ["run", scenario.to_str().unwrap(), "--pace", "fast", "--pulses", "0..2", "--set", echo];
        let sinks = format!("sink=[{{ kind = 'plain', path = '{echo}' }}]");
        let ended = nereus(folder.path(), &[&words[..], &small[..], &["--set", &sinks][..]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended
    };
    run("ship.0.echo=false");
    run("ship.0.echo=true");
    let header = |echo: &str| fs::read_to_string(path(echo).join("header.json")).unwrap_or_default();
    println!(
        "{:?}",
        fs::read_dir(path("ship.0.echo=true")).unwrap().map(|e| e.unwrap().file_name()).collect::<Vec<_>>()
    );
    assert!(header("ship.0.echo=true").contains("dtmb5415.bridge-top"), "{}", header("ship.0.echo=true"));
    assert!(!header("ship.0.echo=false").contains("bridge-top"));
}
