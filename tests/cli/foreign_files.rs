//! Files of other programs that once were misread or refused without a remedy: what `check` says of each.

use std::fs;
use std::io::Cursor;
use std::process::Command;

use tiff::encoder::colortype::GrayI16;
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder};
use tiff::tags::Tag;

use crate::program::{Ended, nereus, package};

/// A scenario of `tests/data/cases`, settings, the exit code, and what both streams hold; `!` in front: what
/// they do not.
struct Case {
    scenario: &'static str,
    set: &'static [&'static str],
    code: i32,
    holds: &'static [&'static str],
}

const fn case(scenario: &'static str, code: i32, holds: &'static [&'static str]) -> Case {
    Case { scenario, set: &[], code, holds }
}

/// The house of all meshes: 12 m x 6 m, 4 m high, on a deck.
const HOUSE: &str = "its superstructure reaches from -6.0 to 6.0 m forward of midship, -3.0 to 3.0 m to port, \
                     2.0 to 6.0 m up";
/// The coast of all rasters.
const COAST: &str = "its cells lie -20.0 to 60.0 m above the sea";
const BELOW_THE_TOWER: &str = "range does not resolve the ground at the centre of the patch";
/// What is looked at is the middle of the patch.
const SMALL: &[&str] = &["scene.patch_size_m=[120, 120]"];

const CASES: &[Case] = &[
    case(
        "29-ais-sentinels/s.toml",
        0,
        &[
            "log.csv: 3 position reports; passed over: 1 without a position, 2 without course or speed",
            "mmsi-211000001: ",
            "!mmsi-211000002",
            "!mmsi-211000003",
            // 102.2 knots or more.
            "!mmsi-211000004",
        ],
    ),
    case(
        "29-ais-sentinels/s2.toml",
        0,
        &[
            "mild.csv: 2 position reports; passed over: 1 without a position, 1 without course or speed",
            "mmsi-211000001: ",
            "!mmsi-211000004",
        ],
    ),
    case(
        "31-ais-marinecadastre/s.toml",
        0,
        &["mmsi-211000001: Wigley's hull of 20 m beam and 6.1 m draught, 120 m long", "!passed over"],
    ),
    case("31-ais-marinecadastre/s2.toml", 0, &["mmsi-211000001: ", " at 5.14444444444 m/s", "!passed over"]),
    case("32-ais-nmea/s.toml", 0, &["mmsi-211000001: ", " at 5.14444444444 m/s", "!passed over"]),
    case("36-dem-scale-and-feet/ref.toml", 0, &[COAST, "!(values"]),
    case("36-dem-scale-and-feet/scale.toml", 0, &[COAST, "(values times 0.1)"]),
    case("36-dem-scale-and-feet/feet.toml", 0, &[COAST, "(values in US survey feet)"]),
    case("37-mesh-obj-variants/plain.toml", 0, &[HOUSE]),
    case("37-mesh-obj-variants/negative.toml", 0, &[HOUSE]),
    case("37-mesh-obj-variants/interleaved.toml", 0, &[HOUSE]),
    case("37-mesh-obj-variants/colours.toml", 0, &[HOUSE]),
    case("37-mesh-obj-variants/continued.toml", 0, &[HOUSE]),
    case(
        "37-mesh-obj-variants/quads.toml",
        2,
        &["6 faces that are no triangles", "export the mesh triangulated"],
    ),
    case("37-mesh-obj-variants/mm.toml", 2, &["farther than 1000 m from midship", "metres (not millimetres"]),
    case(
        "37-mesh-obj-variants/yup.toml",
        0,
        &["superstructure of ship \"ship-0\" lies on its side", "up = \"y\" would turn it"],
    ),
    Case { set: &["ship.0.up=y"], ..case("37-mesh-obj-variants/yup.toml", 0, &[HOUSE, "!lies on its side"]) },
    Case {
        set: &["ship.0.up=y"],
        ..case("37-mesh-obj-variants/plain.toml", 0, &["up = \"z\" would turn it"])
    },
    case("38-mesh-stl-solid-binary/plain.toml", 0, &[HOUSE]),
    case("38-mesh-stl-solid-binary/ascii.toml", 0, &[HOUSE]),
    case("38-mesh-stl-solid-binary/ascii-upper.toml", 0, &[HOUSE]),
    case("38-mesh-stl-solid-binary/solid.toml", 0, &[HOUSE]),
    Case { set: SMALL, ..case("q_fixed337.toml", 0, &[BELOW_THE_TOWER]) },
    Case { set: SMALL, ..case("q_noais.toml", 0, &[BELOW_THE_TOWER]) },
    Case { set: SMALL, ..case("wrap.toml", 0, &[BELOW_THE_TOWER]) },
    Case {
        set: &[
            "ship.0.hull=../../../hulls/dtmb5415.toml",
            "ship.0.echo=false",
            "scene.patch_size_m=[64, 64]",
        ],
        ..case("sar.toml", 0, &["m ground range", "!misses the patch"])
    },
];

fn check(scenario: &str, set: &[&str]) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    let scenario = package().join("tests/data/cases").join(scenario).display().to_string();
    // One pulse, or a few: files are read all the same.
    let set = ["scene.duration_s=0.02"].iter().chain(set).flat_map(|set| ["--set", set]);
    nereus(folder.path(), &["check", &scenario].into_iter().chain(set).collect::<Vec<_>>())
}

#[test]
fn files_of_other_programs_are_read_or_refused_with_the_remedy() {
    let mut wrong = Vec::new();
    for Case { scenario, set, code, holds } in CASES {
        let ended = check(scenario, set);
        let said = format!("{}{}", ended.stdout, ended.stderr);
        for part in *holds {
            let (part, expected) = part.strip_prefix('!').map_or((*part, true), |part| (part, false));
            if said.contains(part) != expected {
                wrong.push(format!(
                    "{scenario} {set:?}: \"{part}\" {}",
                    if expected { "lacks" } else { "is there" }
                ));
            }
        }
        if ended.code != *code {
            wrong.push(format!("{scenario} {set:?}: exit {}, not {code}\n{said}", ended.code));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every scenario of a folder that the table names is in the table.
#[test]
fn no_scenario_of_a_folder_is_left_out() {
    let cases = package().join("tests/data/cases");
    let folders = CASES.iter().filter_map(|case| case.scenario.split_once('/')).map(|(folder, _)| folder);
    for folder in folders {
        for entry in fs::read_dir(cases.join(folder)).unwrap() {
            let name = format!("{folder}/{}", entry.unwrap().file_name().to_string_lossy());
            assert!(
                !name.ends_with(".toml") || CASES.iter().any(|case| case.scenario == name),
                "{name} has no line in the table"
            );
        }
    }
}

/// A raster of 8192 x 8192 cells in a file of 300 kB: 1 GiB of addresses is enough for all of `check`.
#[cfg(target_os = "linux")]
#[test]
fn a_raster_takes_memory_by_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut encoder = encoder.with_compression(Compression::Deflate(DeflateLevel::Best));
    let mut image = encoder.new_image::<GrayI16>(8192, 8192).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[1e-4, 1e-4, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 9.6, 54.4, 0.0][..]).unwrap();
    let keys = [1u16, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326];
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    image.write_data(&vec![7; 8192 * 8192]).unwrap();
    assert!(bytes.get_ref().len() < 400_000, "{}", bytes.get_ref().len());
    fs::write(folder.path().join("ref.tif"), bytes.get_ref()).unwrap();
    let text = fs::read_to_string(package().join("tests/data/cases/36-dem-scale-and-feet/ref.toml")).unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    let call = format!(
        "ulimit -v 1048576; exec '{}' check scene.toml --set stream.threads=2",
        env!("CARGO_BIN_EXE_nereus")
    );
    let ended: Ended =
        Command::new("sh").args(["-c", &call]).current_dir(folder.path()).output().unwrap().into();
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stdout.contains("its cells lie 7.0 to 7.0 m above the sea"), "{}", ended.stdout);
}
