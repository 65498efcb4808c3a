//! Hull files: what is read, and every fault of a bad one, with file and line.

use std::fs;
use std::path::{Path, PathBuf};

use nereus::frames::Point;
use nereus::scene::hull::{Hull, HullError, table};
use proptest::prelude::*;
use tempfile::TempDir;

const TABLE: &str = "x_m/z_m,-2,-1,0\n0,0,0,0\n5,0,0.75,1\n10,0,0,0\n";

fn written(files: &[(&str, &str)]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let first = folder.path().join(files[0].0);
    (folder, first)
}

/// The text of the error, without the folder.
fn refused(files: &[(&str, &str)]) -> String {
    let (folder, path) = written(files);
    let text = Hull::load(&path).unwrap_err().to_string();
    text.replace(&format!("{}/", folder.path().display()), "")
}

#[test]
fn a_hull_by_hand() {
    let toml = "# a punt\nname = 'punt'\noffsets = 'punt.csv'\nsource = 'a pencil'\n[stated]\nblock = 0.444\n\
                tolerance_percent = 0.2\n[[scatterer]]\nname = 'pole'\nforward_m = -4\nstarboard_m = 0.5\nup_m = 3\nrcs_m2 = 0.1\n";
    let (_folder, path) =
        written(&[("punt.toml", toml), ("punt.csv", &format!("\u{feff}# half-breadths\n\n{TABLE}"))]);
    let hull = Hull::load(&path).unwrap();
    assert_eq!((hull.name(), hull.length_m(), hull.beam_m(), hull.draught_m()), ("punt", 10.0, 2.0, 2.0));
    assert_eq!((hull.stations_m(), hull.waterlines_m()), (&[-5.0, 0.0, 5.0][..], &[-2.0, -1.0, 0.0][..]));
    assert_eq!(hull.half_breadths_m(1), [0.0, 0.75, 1.0]);
    assert_eq!(hull.stated().values[5], Some(0.444));
    let pole = &hull.scatterers()[0];
    assert_eq!((pole.name.as_str(), pole.position, pole.rcs_m2), ("pole", Point::new(-4.0, 0.5, -3.0), 0.1));
    // The table alone.
    let (_folder, path) = written(&[("skiff.CSV", TABLE)]);
    let alone = Hull::load(&path).unwrap();
    assert_eq!((alone.name(), alone.half_breadths_m(1)), ("skiff", hull.half_breadths_m(1)));
    // Stations from anywhere, lines of another system, blanks.
    let moved = "x_m/z_m , -2, -1 ,0\r\n 95,0,0,0\r\n100,0,0.75,1\r\n105,0,0,0\r\n";
    assert_eq!(table::parse("skiff", moved).unwrap(), alone);
}

#[test]
fn every_hull_that_is_shipped_is_described() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("hulls");
    let readme = fs::read_to_string(folder.join("README.md")).unwrap();
    let mut hulls = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name != "README.md" {
            assert!(readme.contains(&format!("`{name}`")), "{name}");
        }
        if name.ends_with(".toml") {
            Hull::load(&path).unwrap();
            hulls += 1;
        }
    }
    assert!(hulls >= 4);
    let notice = fs::read_to_string(folder.join("LICENSE-dtmb5415")).unwrap();
    assert!(
        notice.contains("Copyright (c) 2017 Marco Tezzele")
            && notice.contains("Permission is hereby granted")
    );
}

#[test]
fn all_faults_at_once() {
    let toml = "nam = 'punt'\noffsets = 'punt.csv'\ndraught_m = -1\n[stated]\nblock = 'big'\nlength_m = inf\nvolume = 3\n\
                [[scatterer]]\nname = 'a'\nforward_m = 1\nstarboard_m = 0\nup_m = 9000\n";
    let csv = "# half-breadths\nx_m/z_m,-2,-2.5,x,-1\n0,0,0,0,0\n5,0,,nan,-1\n4,0,1\n\n10,0,0,0,0\n";
    assert_eq!(
        refused(&[("punt.toml", toml), ("punt.csv", csv)]),
        "hull punt.toml: 18 faults
  punt.toml line 1: unknown key nam; allowed: name, offsets, source, licence, draught_m, stated, scatterer
  punt.toml line 1: name is missing; allowed: a text
  punt.toml line 3: draught_m = -1 is not allowed; allowed: a number above 0
  punt.toml line 5: stated.block = 'big' is not allowed; allowed: a number above 0
  punt.toml line 6: stated.length_m = inf is not allowed; allowed: a number above 0
  punt.toml line 7: unknown key stated.volume; allowed: length_m, beam_m, draught_m, volume_m3, wetted_surface_m2, block, midship, waterplane, lcb_percent, tolerance_percent
  punt.toml line 8: scatterer.rcs_m2 is missing; allowed: a number from 0 to 1e9 m^2
  punt.toml line 12: scatterer.up_m = 9000 is not allowed; allowed: a number from -2000 to 2000 m
  punt.csv line 2: column 4 is 'x'; allowed: a finite number
  punt.csv line 2: waterline -2.5 m follows -2 m; allowed: increasing from the keel to 0
  punt.csv line 2: the last waterline is -1 m; allowed: 0, the design waterline
  punt.csv line 2: 4 waterlines; allowed: an odd number, 3 to 1001
  punt.csv line 4: nothing in column 3; allowed: a half-breadth, 0 where there is no hull
  punt.csv line 4: column 4 is 'nan'; allowed: a finite number
  punt.csv line 4: half-breadth -1 m at waterline -1 m is negative; allowed: 0 and above
  punt.csv line 5: 3 fields; needed are 5: the station, then a half-breadth for each waterline
  punt.csv line 5: station 4 m follows 5 m; allowed: increasing from bow to stern
  punt.csv line 7: 4 stations; allowed: an odd number, 3 to 2001"
    );
}

#[test]
fn single_faults() {
    let csv = |text: &str, words: &str| {
        let error = table::parse("a.csv", text).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    };
    csv("", "a.csv line 1: the header must be x_m/z_m");
    csv("x_m,z_m,y_m\n0,0,0\n", "line 1: the header must be x_m/z_m and then the waterlines");
    csv("x_m/z_m\n0\n", "line 1: the header must be x_m/z_m and then the waterlines");
    csv("x_m/z_m,-2,-1,0\n", "line 1: 0 stations; allowed: an odd number");
    csv("x_m/z_m,-2,-1,0\n0,0,0,0\n5,0,1,1\n6,0,1,1\n10,0,0,0\n", "line 5: 4 stations");
    csv(
        "x_m/z_m,-2,-1,0\n0,0,0,0\n9,0,1,1\n10,0,0,0\n",
        "line 3: 9 m lies too far from the middle of 0 to 10 m",
    );
    csv(
        "x_m/z_m,-2,-0.1,0\n0,0,0,0\n5,0,1,1\n10,0,0,0\n",
        "line 1: -0.1 m lies too far from the middle of -2 to 0 m",
    );
    csv(
        "x_m/z_m,-2,-1,0\n0,0,0,0\n0.01,0,0.01,0.01\n0.02,0,0,0\n",
        "the length is 0.02 m; allowed: 0.05 to 1000 m",
    );
    csv("x_m/z_m,-2,-1,0\n0,0,0,0\n5,0,0,0\n10,0,0,0\n", "no volume");
    csv("x_m/z_m,-2,-1,0\n0,0,0,0\n5,0,1,1\n10,0,0,1e9\n", "the beam is 2000000000 m");
    assert!(
        refused(&[("a.toml", "name = 'a'\noffsets = 'b.csv'\n")])
            .contains("a.toml line 2: b.csv cannot be read")
    );
    assert!(refused(&[("a.toml", "name = 'a'\noffsets = \n")]).contains("a.toml line 2: "));
    assert!(refused(&[("a.toml", "name = 'a'\n")]).contains("offsets is missing"));
    let twice = "name = 'a'\noffsets = 'a.csv'\n[[scatterer]]\nname='m'\nforward_m=0\nstarboard_m=0\nup_m=1\nrcs_m2=1\n\
                 [[scatterer]]\nname='m'\nforward_m=0\nstarboard_m=0\nup_m=1\nrcs_m2=1\n";
    assert!(refused(&[("a.toml", twice), ("a.csv", TABLE)]).contains("line 9: the name 'm' is given twice"));
    let stated =
        "name = 'a'\noffsets = 'a.csv'\n[stated]\nvolume_m3 = 18\nlcb_percent = 1.5\nbeam_m = 2.01\n";
    let text = refused(&[("a.toml", stated), ("a.csv", TABLE)]);
    assert!(text.starts_with("hull a.toml: 2 faults"), "{text}");
    assert!(text.contains("line 4: volume_m3 is stated as 18, the table gives 17.777778"), "{text}");
    assert!(text.contains("line 5: lcb_percent is stated as 1.5"), "{text}");
    let deep = "name = 'a'\noffsets = 'a.csv'\ndraught_m = 2.5\n";
    assert!(refused(&[("a.toml", deep), ("a.csv", TABLE)]).contains("line 3: draught_m is 2.5 m"));
    assert!(matches!(Hull::load(Path::new("no/such.toml")), Err(HullError::Read { .. })));
    let (folder, _) = written(&[("a.csv", TABLE)]);
    fs::write(folder.path().join("a.csv"), b"x_m/z_m,\xff\n").unwrap();
    assert!(
        Hull::load(&folder.path().join("a.csv")).unwrap_err().to_string().contains("line 1: not UTF-8 text")
    );
    assert!(Hull::load(folder.path()).is_err());
}

#[test]
fn many_faults_are_counted() {
    let rows: String = (0..101).map(|i| format!("{i},0,-1,0\n")).collect();
    let error = table::parse("a.csv", &format!("x_m/z_m,-2,-1,0\n{rows}")).unwrap_err().to_string();
    assert!(error.starts_with("hull a.csv: 101 faults") && error.ends_with("and 51 more"), "{error}");
}

proptest! {
    #![proptest_config(crate::cases::proptests(256))]

    /// Corrupt tables: a hull or faults, never a panic.
    #[test]
    fn corrupt_tables_never_panic(at in 0usize..60, with in "[-0-9.,enax#\n/_ ]{0,4}", cut in 0usize..60) {
        let mut text = TABLE.to_owned();
        let at = at.min(text.len());
        let end = (at + cut).min(text.len());
        text.replace_range(at..end.max(at), &with);
        let _ = table::parse("a.csv", &text);
    }
}

/// Before: every unknown key was compared with every other, minutes.
#[test]
fn many_unknown_keys_are_read_once() {
    let keys: String = (0..200_000).map(|n| format!("k{n} = 1\n")).collect();
    let begun = std::time::Instant::now();
    let faults = refused(&[("x.toml", &format!("name = 'x'\noffsets = 'x.csv'\n{keys}")), ("x.csv", TABLE)]);
    assert!(faults.contains("k0"), "{}", &faults[..faults.len().min(400)]);
    let took_s = begun.elapsed().as_secs_f64();
    assert!(took_s < 5.0, "{took_s} s");
}
