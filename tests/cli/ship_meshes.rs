//! Meshes of ships from files, and how many panels there may be.

use std::fs;
use std::path::Path;

use crate::program::{Ended, nereus, package};

/// A box of 4 m x 3 m x 2 m on the deck; inside out where asked.
fn house(folder: &Path, name: &str, inside_out: bool) {
    let mut text = String::from("o house\n");
    for n in 0..8 {
        let at = |bit: usize, wide: f64| if n >> bit & 1 == 1 { wide } else { 0.0 };
        text += &format!("v {} {} {}\n", at(0, 4.0), at(1, 3.0), 2.0 + at(2, 2.0));
    }
    let faces = "134 142 568 587 126 165 378 384 157 173 248 286";
    for face in faces.split(' ') {
        let corners: Vec<char> =
            if inside_out { face.chars().rev().collect() } else { face.chars().collect() };
        text += &format!("f {} {} {}\n", corners[0], corners[1], corners[2]);
    }
    fs::write(folder.join(name), text).unwrap();
}

fn check(folder: &Path, more: &[&str]) -> Ended {
    let config = package().join("configs/mars-1.toml").display().to_string();
    let mut words = vec!["check".to_owned(), config];
    let small =
        ["scene.patch_size_m=[16, 16]", "scene.duration_s=0.1", "ship.0.echo=true", "ship.0.length_m=20"];
    for setting in small.iter().chain(more) {
        words.extend(["--set".to_owned(), (*setting).to_owned()]);
    }
    nereus(folder, &words.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Panels that echo, as `check` prints them.
fn panels(ended: &Ended) -> usize {
    let text = ended.stdout.split(" panels of its mesh").next().unwrap();
    text.rsplit(' ').next().unwrap().parse().unwrap_or_else(|_| panic!("{} {}", ended.stdout, ended.stderr))
}

#[test]
fn superstructures_are_read_and_damaged_ones_named() {
    let folder = tempfile::tempdir().unwrap();
    house(folder.path(), "house.obj", false);
    house(folder.path(), "damaged.obj", true);
    let with = |name: &str| {
        let path = folder.path().join(name).display().to_string();
        check(folder.path(), &["ship.0.panel_m=2", &format!("ship.0.superstructure='{path}'")])
    };
    let hull = panels(&check(folder.path(), &["ship.0.panel_m=2"]));
    let whole = with("house.obj");
    assert_eq!(whole.code, 0, "{}", whole.stderr);
    assert!(panels(&whole) >= hull + 12, "{} {hull}", panels(&whole));
    let damaged = with("damaged.obj");
    assert_ne!(damaged.code, 0);
    let named =
        "damaged.obj: 1 parts are inside out, the first has triangle 1; allowed: corners counter-clockwise";
    assert!(damaged.stderr.contains(named), "{}", damaged.stderr);
    let missing = with("missing.obj");
    assert!(missing.code != 0 && missing.stderr.contains("missing.obj"), "{}", missing.stderr);
}

/// Each of twelve ships is allowed, all together are not.
#[test]
fn panels_of_all_ships_are_limited() {
    let folder = tempfile::tempdir().unwrap();
    let ship = "{ hull = 'wigley', length_m = 60, beam_m = 8, draught_m = 2.5, heading_deg = 0, speed_mps = 3, \
                wake = false, turbulent = false, echo = true, panel_m = 0.45, position_m = [0, 0] }";
    let config = package().join("configs/mars-1.toml");
    let text = fs::read_to_string(config).unwrap();
    // Without its own ship, which a table of ships replaces.
    let text = text.replace("[[ship]]", "[[extra]]");
    let begin = text.find("[[extra]]").unwrap();
    let end = begin + text[begin + 1..].find("\n[").unwrap() + 1;
    let ships = format!("ship = [{}]\n", [ship; 12].join(", "));
    fs::write(folder.path().join("many.toml"), format!("{ships}{}{}", &text[..begin], &text[end..])).unwrap();
    let found = nereus(folder.path(), &["check", "many.toml", "--set", "scene.patch_size_m=[16, 16]"]);
    assert_ne!(found.code, 0);
    assert!(found.stderr.contains("of all ships: allowed are at most 200000 together"), "{}", found.stderr);
}
