//! `nereus wake`: files that others can read, cuts, and what is refused.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use crate::program::{Ended, nereus, package};

/// The sea of the MaRS scenes with a ship ahead of the middle; `settings` come after it.
fn wake(folder: &Path, arguments: &[&str]) -> Ended {
    let scenario = package().join("configs/mars-1.toml");
    let mut words = vec!["wake", scenario.to_str().unwrap(), "--set", "ship.0.position_m=[200, 0]"];
    words.extend(arguments);
    nereus(folder, &words)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Astern, starboard, height of every row of a printed cut.
fn cut(ended: &Ended) -> Vec<[f64; 3]> {
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let mut lines = ended.stdout.lines();
    assert_eq!(lines.next(), Some("ship,cut,astern_m,starboard_m,east_m,north_m,height_m"));
    lines
        .map(|line| {
            let cells: Vec<f64> = line.split(',').skip(2).map(|cell| cell.parse().unwrap()).collect();
            [cells[0], cells[1], cells[4]]
        })
        .collect()
}

#[test]
fn transverse_waves_have_their_length() {
    let folder = tempfile::tempdir().unwrap();
    for speed_mps in [4.5, 9.0] {
        let speed = format!("ship.0.speed_mps={speed_mps}");
        let size = "scene.patch_size_m=[4096, 64]";
        // On the axis, from two lengths astern, only transverse waves are left.
        let place = ["--set", &speed, "--set", size, "--set", "ship.0.position_m=[2000, 0]"];
        let cuts = ["--cut-starboard-m", "0", "--cut-step-m", "0.25"];
        let rows = cut(&wake(folder.path(), &[&place[..], &cuts[..]].concat()));
        let crossings: Vec<f64> = rows
            .windows(2)
            .filter(|pair| pair[0][0] > 1000.0 && pair[0][2] < 0.0 && pair[1][2] >= 0.0)
            .map(|pair| pair[0][0] - pair[0][2] * (pair[1][0] - pair[0][0]) / (pair[1][2] - pair[0][2]))
            .collect();
        let waves = crossings.len() - 1;
        let found_m = (crossings[waves] - crossings[0]) / waves as f64;
        let expected_m = TAU * speed_mps * speed_mps / 9.81;
        // The phase on the axis drifts with distance as A does about theta = 0, of width 1/sqrt(k0 X): 1 % is
        // asked.
        assert!((found_m / expected_m - 1.0).abs() < 0.01, "{found_m} m, expected {expected_m} m");
    }
}

/// Root mean square over cuts of the middle and of the highest place across, and the share of the variance in
/// waves more than 35.26 degrees from the course, whose wave number across is above `k0 tan sec`.
fn arms_and_divergent(folder: &Path, speed_mps: f64) -> [f64; 2] {
    let speed = format!("ship.0.speed_mps={speed_mps}");
    let astern: Vec<String> = (300..=450).step_by(4).map(|x| x.to_string()).collect();
    let place = ["--set", "scene.patch_size_m=[1024, 512]", "--set", "ship.0.position_m=[450, 0]"];
    let cuts = ["--set", &speed, "--cut-astern-m", &astern.join(",")];
    let rows = cut(&wake(folder, &[&place[..], &cuts[..]].concat()));
    let mean_square = |starboard_m: f64| {
        let at = rows.iter().filter(|row| (row[1] - starboard_m).abs() < 0.5);
        at.map(|row| row[2] * row[2]).sum::<f64>()
    };
    let arms = (-200..=200).map(|y| mean_square(f64::from(y))).fold(0.0, f64::max);
    let limit = 9.81 / (speed_mps * speed_mps) * 0.5f64.sqrt() * 1.5f64.sqrt();
    let (mut divergent, mut all) = (0.0, 0.0);
    for x in &astern {
        let x: f64 = x.parse().unwrap();
        let line: Vec<f64> = rows.iter().filter(|row| (row[0] - x).abs() < 1e-6).map(|row| row[2]).collect();
        for n in 0..=line.len() / 2 {
            let step = TAU * n as f64 / line.len() as f64;
            let turned = line.iter().enumerate().map(|(i, z)| ((step * i as f64).sin_cos(), *z));
            let [im, re] = turned.fold([0.0; 2], |[im, re], ((s, c), z)| [im + z * s, re + z * c]);
            let power = (re * re + im * im) * if n == 0 { 1.0 } else { 2.0 };
            all += power;
            // Facets of 1 m: the step is the wave number across.
            divergent += if step > limit { power } else { 0.0 };
        }
    }
    [(arms / mean_square(0.0)).sqrt(), divergent / all]
}

#[test]
fn the_figures_of_the_page_are_those_of_the_cuts() {
    let folder = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(package().join("docs/ships.md")).unwrap();
    let [slow, fast] = [4.5, 9.0].map(|speed_mps| arms_and_divergent(folder.path(), speed_mps));
    let figures = [
        format!(
            "the arms are {:.1} times as high as the axis at 4.5 m/s and {:.1} times at 9 m/s",
            slow[0], fast[0]
        ),
        format!(
            "have {:.0} % of the variance of the first wake and {:.0} % of the second",
            100.0 * slow[1],
            100.0 * fast[1]
        ),
    ];
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for figure in figures {
        assert!(page.contains(&figure), "{figure}");
    }
}

#[test]
fn cuts_are_symmetric_and_sail_with_the_ship() {
    let folder = tempfile::tempdir().unwrap();
    let at = |arguments: &[&str]| cut(&wake(folder.path(), arguments));
    let starboard = at(&["--cut-starboard-m", "30", "--cut-step-m", "10"]);
    let port = at(&["--cut-starboard-m", "-30", "--cut-step-m", "10"]);
    assert!(starboard.len() > 45 && starboard.iter().any(|row| row[2].abs() > 0.1));
    for (a, b) in starboard.iter().zip(&port) {
        // Sums of 1e4 waves in another order.
        assert!(a[0] == b[0] && a[1] == -b[1] && (a[2] - b[2]).abs() < 1e-12, "{a:?} {b:?}");
    }
    // Ten seconds later, and 45 m on, the same heights stand at the same distances astern.
    let later = at(&["--cut-starboard-m", "30", "--cut-step-m", "10", "--time-s", "10"]);
    let mut met = 0;
    for row in &later {
        if let Some(before) = starboard.iter().find(|before| before[0] == row[0]) {
            // Another reach means other nodes: each sum is exact to rounding of the root sum square of its
            // waves.
            assert!((before[2] - row[2]).abs() < 1e-9, "{before:?} {row:?}");
            met += 1;
        }
    }
    assert!(met > 40);
    let both = at(&["--cut-starboard-m", "0,20", "--cut-astern-m", "150", "--cut-step-m", "50"]);
    assert!(both.iter().any(|row| row[0] == 150.0 && row[1] == -200.0));
}

#[test]
fn the_picture_shows_two_signs_and_the_summary_the_figures() {
    let folder = tempfile::tempdir().unwrap();
    let ended = wake(folder.path(), &["--png", "wake.png", "--json", "--cut-astern-m", "100"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("Froude number 0.144") && ended.stderr.contains("12.97 m"));
    assert_eq!(ended.stdout.lines().count(), 1);
    let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((&report["png"], &report["ships"][0]["waves"]), (&"wake.png".into(), &"waves".into()));
    let [low_m, high_m] = [0, 1].map(|i| report["height_range_m"][i].as_f64().unwrap());
    assert!(low_m < -0.1 && high_m > 0.1 && high_m < 2.0, "{low_m} {high_m}");
    assert!(report["cuts"][0]["points"].as_array().unwrap().len() > 500);
    let resistance_n = report["ships"][0]["resistance_n"].as_f64().unwrap();
    let table = nereus(
        package(),
        &[
            "table",
            "wake-resistance",
            "--hull-path",
            "hulls/dtmb5415.toml",
            "--length-m",
            "100",
            "--speed-mps",
            "4.5",
        ],
    );
    let printed: f64 = table.stdout.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse().unwrap();
    // Printed in 13 digits.
    assert!((resistance_n / printed - 1.0).abs() < 1e-12);
    let file = std::io::BufReader::new(fs::File::open(folder.path().join("wake.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let coloured =
        |hue: usize| bytes.chunks_exact(3).filter(|c| i32::from(c[hue]) > i32::from(c[2 - hue]) + 60).count();
    assert!(coloured(0) > 10_000 && coloured(2) > 10_000, "{} {}", coloured(0), coloured(2));
    assert_eq!(names(folder.path()), ["wake.png"]);
}

#[test]
fn files_that_exist_stay_and_wrong_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.png"), "not a picture").unwrap();
    assert_eq!(wake(folder.path(), &["--png", "wake.png"]).code, 0);
    let cases: [(&[&str], &str); 8] = [
        (&["--png", "wake.png"], "exists already"),
        (&["--png", "mine.png", "--force"], "it is no PNG picture"),
        (&["--time-s", "nan"], "within"),
        (&["--cut-starboard-m", "nan"], "--cut-starboard-m NaN is not allowed"),
        (&["--cut-astern-m", "0", "--cut-step-m", "0"], "--cut-step-m 0 is not allowed"),
        (&["--set", "ship=[]"], "the scenario has no [[ship]]"),
        (&["--set", "ship.0.speed_mps=-1"], "out of range"),
        (&["--set", "ship.0.length_m=1e9"], "out of range"),
    ];
    for (arguments, words) in cases {
        let ended = wake(folder.path(), arguments);
        assert_eq!(ended.code, 2, "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(words) && ended.stdout.is_empty(), "{arguments:?}: {}", ended.stderr);
    }
    assert_eq!(names(folder.path()), ["mine.png", "wake.png"]);
    assert_eq!(fs::read(folder.path().join("mine.png")).unwrap(), b"not a picture");
}

#[test]
fn a_body_plan_is_drawn_beside_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let hull = package().join("hulls/dtmb5415.toml");
    let words = ["table", "hull", hull.to_str().unwrap(), "--png", "plan.png"];
    let ended = nereus(folder.path(), &words);
    assert_eq!((ended.code, ended.stdout.lines().count()), (0, 10), "{}", ended.stderr);
    let picture = fs::read(folder.path().join("plan.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    let again = nereus(folder.path(), &words);
    assert!(again.code == 2 && again.stderr.contains("exists already"), "{}", again.stderr);
    assert_eq!(fs::read(folder.path().join("plan.png")).unwrap(), picture);
}

#[cfg(feature = "hdf5")]
#[test]
fn the_map_reads_back_as_the_sum_of_waves() {
    use nereus::sea::fleet::Fleet;

    let folder = tempfile::tempdir().unwrap();
    let ended =
        wake(folder.path(), &["--out", "wake.h5", "--time-s", "3", "--set", "scene.patch_size_m=[256, 128]"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let file = hdf5::File::open(folder.path().join("wake.h5")).unwrap();
    let text = |name: &str| {
        file.attr(name).unwrap().read_scalar::<hdf5::types::VarLenUnicode>().unwrap().as_str().to_owned()
    };
    assert_eq!(text("format"), "nereus-wake");
    // The recorded scenario, read where the file of the hull is found, gives the same waves.
    let run = nereus::config::parse(&text("config"), &package().join("configs/again.toml"), &[]).unwrap();
    let patch = run.scene.sea.unwrap().patch;
    let fleet = Fleet::muster(&run.scene.ships, &[(3.0, patch)]).unwrap();
    let read = |name: &str| file.dataset(name).unwrap().read_raw::<f32>().unwrap();
    let (heights_m, slopes, up_mps) = (read("height_m"), read("slope_x"), read("velocity_up_mps"));
    let largest = |values: &[f32]| values.iter().fold(0f32, |most, v| most.max(v.abs()));
    assert!(largest(&heights_m) > 0.1);
    for facet in [0, 1000, 128 * 64 + 100, 256 * 64 + 17, 256 * 128 - 1] {
        let sample = fleet.wakes[0].at(patch.centre_m(patch.key(facet)), 3.0).unwrap();
        for (values, expected) in
            [(&heights_m, sample.height_m), (&slopes, sample.slope[0]), (&up_mps, sample.velocity_mps[2])]
        {
            // f32 keeps 2^-24 of a value; -150 dB of the root sum square, which is below the largest value,
            // is less.
            let error = (f64::from(values[facet]) - expected).abs();
            assert!(error <= 1.2e-7 * f64::from(largest(values)), "facet {facet}: off by {error:e}");
        }
    }
}
