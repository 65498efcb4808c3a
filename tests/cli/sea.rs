//! `nereus sea`: files that others can read, and what is refused.

use std::fs;
use std::path::Path;

use crate::program::{Ended, nereus};

const SCENE: &str = r#"
[scene]
duration_s = 0.1
seed = 3
patch_size_m = [96.0, 64.0]
patch_centre_m = [200.0, -40.0]
facet_m = 2.0
[sea]
wind_mps = 6.0
wind_towards_deg = 20.0
[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = 222.0
channels = ["VV"]
waveform = { kind = "lfm", bandwidth_hz = 60e6, pulse_s = 0.333e-6 }
window = { samples = 512, start_us = 26.5 }
[[platform]]
name = "mast"
track = { kind = "fixed", position_m = [0, 0, 15] }
[[transmitter]]
name = "tx"
platform = "mast"
power_w = 1.0
antenna = { kind = "isotropic" }
[[receiver]]
name = "rx"
platform = "mast"
antenna = { kind = "isotropic" }
"#;

/// A folder with the scenario.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("sea.toml"), SCENE).unwrap();
    folder
}

fn sea(folder: &Path, arguments: &[&str]) -> Ended {
    let words: Vec<&str> = ["sea", "sea.toml"].iter().chain(arguments).copied().collect();
    nereus(folder, &words)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Width, height and pixels of a PNG.
fn pixels(path: &Path) -> (usize, usize, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    let pixels = bytes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    (info.width as usize, info.height as usize, pixels)
}

#[test]
fn the_picture_reads_back_and_shows_two_signs() {
    let folder = folder();
    let ended = sea(folder.path(), &["--png", "sea.png", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let (width, height, pixels) = pixels(&folder.path().join("sea.png"));
    // 48 x 32 facets in 13 whole pixels each.
    assert!((624..900).contains(&width) && (416..700).contains(&height), "{width} x {height}");
    let [blue, red] = [2, 0].map(|hue| {
        pixels.iter().filter(|c| i32::from(c[hue]) > i32::from(c[2 - hue]) + 20).count() as f64
            / (624.0 * 416.0)
    });
    assert!(blue > 0.2 && red > 0.2, "{blue} {red}");
    assert_eq!(ended.stdout.lines().count(), 1);
    let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((&report["facets"][0], &report["png"]), (&48.into(), &"sea.png".into()));
    assert!(ended.stderr.contains("significant height") && ended.stderr.contains("48 x 32 facets of 2 m"));
    assert_eq!(names(folder.path()), ["sea.png", "sea.toml"]);
}

#[test]
fn a_picture_of_every_field_differs() {
    let folder = folder();
    let mut seen = Vec::new();
    let fields = ["height", "slope", "slope-x", "slope-y", "velocity-x", "velocity-y", "velocity-up"];
    for field in fields.into_iter().chain(["displacement-x", "displacement-y"]) {
        let ended = sea(folder.path(), &["--png", "field.png", "--field", field, "--force"]);
        assert_eq!(ended.code, 0, "{field}: {}", ended.stderr);
        let file = fs::read(folder.path().join("field.png")).unwrap();
        assert!(!seen.contains(&file), "{field}");
        seen.push(file);
    }
}

#[test]
fn a_saved_state_is_the_same_sea() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    assert_eq!(sea(folder.path(), &["--time-s", "7", "--png", "a.png", "--save-state", "state"]).code, 0);
    // Another seed, but the waves come from the file.
    let again = ["--time-s", "7", "--png", "b.png", "--set", "sea.state_path=state", "--set", "scene.seed=9"];
    let ended = sea(folder.path(), &again);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert_eq!(fs::read(path("a.png")).unwrap(), fs::read(path("b.png")).unwrap());
    let other = sea(folder.path(), &["--time-s", "7", "--png", "c.png", "--set", "scene.seed=9"]);
    assert_eq!(other.code, 0, "{}", other.stderr);
    assert_ne!(fs::read(path("a.png")).unwrap(), fs::read(path("c.png")).unwrap());
    let wrong = sea(folder.path(), &["--set", "sea.state_path=state", "--set", "scene.facet_m=4.0"]);
    assert_eq!(wrong.code, 2);
    assert!(
        wrong.stderr.contains("48 x 32 facets of 2 m, but the patch has 24 x 16 of 4 m"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn files_that_exist_stay() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("mine.png"), "not a picture").unwrap();
    assert_eq!(sea(folder.path(), &["--png", "sea.png"]).code, 0);
    let first = fs::read(path("sea.png")).unwrap();
    let cases: [(&[&str], &str); 5] = [
        (&["--png", "sea.png", "--save-state", "new"], "exists already"),
        (&["--png", "mine.png", "--force"], "it is no PNG picture"),
        (&["--save-state", "sea.png", "--force"], "it is no saved sea"),
        (&["--png", "a", "--save-state", "./a"], "named twice"),
        (&["--png", "no/such/folder/sea.png"], "folder"),
    ];
    for (arguments, words) in cases {
        let ended = sea(folder.path(), arguments);
        assert_eq!(ended.code, 2, "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(words) && ended.stdout.is_empty(), "{arguments:?}: {}", ended.stderr);
    }
    assert_eq!(names(folder.path()), ["mine.png", "sea.png", "sea.toml"]);
    assert_eq!(fs::read(path("sea.png")).unwrap(), first);
    assert_eq!(sea(folder.path(), &["--png", "sea.png", "--force", "--set", "scene.seed=4"]).code, 0);
    assert_ne!(fs::read(path("sea.png")).unwrap(), first);
}

#[test]
fn wrong_input_is_refused() {
    let folder = folder();
    let cases: [(&[&str], &str); 5] = [
        (&["--time-s", "1e12"], "within"),
        (&["--time-s", "nan"], "within"),
        (&["--field", "colour"], "possible values"),
        (&["--set", "sea.wind=5"], "wind"),
        (&["--set", "sea.wind_mps=-1"], "wind_mps"),
    ];
    for (arguments, words) in cases {
        let ended = sea(folder.path(), arguments);
        assert_eq!(ended.code, 2, "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(words), "{arguments:?}: {}", ended.stderr);
    }
    let (before, after) = SCENE.split_once("patch_size_m").unwrap();
    let dry = format!("{before}{}", &after[after.find("[radar]").unwrap()..]);
    fs::write(folder.path().join("sea.toml"), dry).unwrap();
    let ended = sea(folder.path(), &["--png", "sea.png"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("the scenario has no [sea]"), "{}", ended.stderr);
    assert_eq!(names(folder.path()), ["sea.toml"]);
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn without_hdf5_there_are_pictures_only() {
    let folder = folder();
    let ended = sea(folder.path(), &["--out", "sea.h5", "--png", "sea.png"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("this build has no HDF5"), "{}", ended.stderr);
    assert_eq!(names(folder.path()), ["sea.toml"]);
}

#[cfg(feature = "hdf5")]
#[test]
fn the_map_reads_back_as_the_library_computes_it() {
    use hdf5::types::VarLenUnicode;
    use nereus::sea::realise::realise;

    let folder = folder();
    // Waves that the sum below knows.
    let set = ["--set", "sea.wind_mps=9", "--set", "sea.waves=linear"];
    let ended = sea(folder.path(), &[&["--time-s", "-2.5", "--out", "sea.h5"], &set[..]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let file = hdf5::File::open(folder.path().join("sea.h5")).unwrap();
    let text = |place: &hdf5::Location, name: &str| {
        place.attr(name).unwrap().read_scalar::<VarLenUnicode>().unwrap().as_str().to_owned()
    };
    let real = |name: &str| file.attr(name).unwrap().read_scalar::<f64>().unwrap();
    assert_eq!(text(&file, "format"), "nereus-sea");
    assert!(text(&file, "software").starts_with("nereus "));
    assert_eq!((real("time_s"), real("facet_m")), (-2.5, 2.0));
    assert_eq!(file.attr("seed").unwrap().read_scalar::<u64>().unwrap(), 3);

    // The recorded scenario alone gives the same sea, wave by wave at some facets.
    let run = nereus::config::parse(&text(&file, "config"), Path::new("recorded.toml"), &[]).unwrap();
    let described = run.scene.sea.unwrap();
    let surface = realise(&described, run.scene.seed).unwrap().surface;
    let centres = |name: &str| file.dataset(name).unwrap().read_raw::<f64>().unwrap();
    let (x_m, y_m) = (centres("x_m"), centres("y_m"));
    // 48 and 32 facets of 2 m, the middle ones at the centre.
    assert_eq!((x_m.len(), x_m[0], x_m[47]), (48, 152.0, 246.0));
    assert_eq!((y_m.len(), y_m[0], y_m[31]), (32, -72.0, -10.0));
    let mut checked = 0;
    let mut check = |name: &str, unit: &str, pick: &dyn Fn(&nereus::sea::surface::Sample) -> f64| {
        let dataset = file.dataset(name).unwrap();
        assert_eq!((dataset.shape(), text(&dataset, "unit").as_str()), (vec![32, 48], unit), "{name}");
        let axes = dataset.attr("axes").unwrap().read_raw::<VarLenUnicode>().unwrap();
        assert_eq!([axes[0].as_str(), axes[1].as_str()], ["y_m", "x_m"]);
        let values = dataset.read_raw::<f32>().unwrap();
        let largest = values.iter().fold(0f32, |most, v| most.max(v.abs()));
        assert!(largest > 1e-3, "{name} is flat");
        for (ix, iy) in [(0, 0), (47, 0), (3, 31), (20, 11)] {
            let expected = pick(&surface.at([x_m[ix], y_m[iy]], -2.5));
            // f32 keeps 2^-24 of a value; the sum of waves and the transform differ by far less.
            let error = (f64::from(values[iy * 48 + ix]) - expected).abs();
            assert!(error <= 1e-7 * f64::from(largest), "{name} [{iy}][{ix}]: off by {error:e}");
            checked += 1;
        }
    };
    check("height_m", "m", &|s| s.height_m);
    check("slope_x", "1", &|s| s.slope[0]);
    check("slope_y", "1", &|s| s.slope[1]);
    check("velocity_x_mps", "m/s", &|s| s.velocity_mps[0]);
    check("velocity_y_mps", "m/s", &|s| s.velocity_mps[1]);
    check("velocity_up_mps", "m/s", &|s| s.velocity_mps[2]);
    check("acceleration_x_mps2", "m/s^2", &|s| s.acceleration_mps2[0]);
    check("acceleration_y_mps2", "m/s^2", &|s| s.acceleration_mps2[1]);
    check("acceleration_up_mps2", "m/s^2", &|s| s.acceleration_mps2[2]);
    check("displacement_x_m", "m", &|s| s.displacement_m[0]);
    check("displacement_y_m", "m", &|s| s.displacement_m[1]);
    assert_eq!(checked, 44);
    let heights = file.dataset("height_m").unwrap().read_raw::<f32>().unwrap();
    let mean_square = heights.iter().map(|z| f64::from(*z).powi(2)).sum::<f64>() / heights.len() as f64;
    assert!((4.0 * mean_square.sqrt() / real("significant_height_m") - 1.0).abs() < 1e-6);
}
