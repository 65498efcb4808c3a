//! Cross sections by aspect: a plate's closed form from its table, headings, bisectors, faults of the file.

use std::fmt::Write as _;
use std::path::Path;

use nereus::paths::PathGenerator;
use nereus::radar::pattern::{GridPattern, PatternFault, Quantity};
use nereus::scene::Scene;
use nereus::scene::target::Aspect;

use crate::radar_scenes::{evaluate, scene, straight, target};

/// Half a metre of plate at 10 GHz, whose normal is the bow: `sqrt(sigma)` over its peak.
fn plate(azimuth_rad: f64) -> f64 {
    let x = 2.0 * std::f64::consts::PI / 0.0299792458 * 0.5 * azimuth_rad.sin();
    if x == 0.0 { 1.0 } else { (x.sin() / x).abs() }
}

/// Its table, 20 dBsm at the peak, over azimuths of 60 degrees either way and all elevations.
fn table(step_deg: f64) -> String {
    let mut text = String::from("az_deg,el_deg,rcs_dbsm\n");
    let steps = (60.0 / step_deg).round() as i32;
    for i in -steps..=steps {
        let azimuth_deg = f64::from(i) * step_deg;
        let dbsm = (20.0 + 20.0 * plate(azimuth_deg.to_radians()).log10()).max(-300.0);
        for elevation_deg in [-90, 90] {
            writeln!(text, "{azimuth_deg},{elevation_deg},{dbsm}").unwrap();
        }
    }
    text
}

fn aspect(path: &Path, heading_deg: f64) -> Option<Aspect> {
    Some(Aspect { path: path.to_owned(), heading_rad: Some(heading_deg.to_radians()), floor_dbsm: -300.0 })
}

/// Cross sections that a scene returns, over the law of a sphere of 1 m^2, at some pulses.
fn cross_sections(scene: &Scene, ends: [([f64; 3], [f64; 3]); 2], pulses: &[u64]) -> Vec<f64> {
    let tracks = ends.map(|(at, velocity)| straight(scene, at, velocity)).to_vec();
    let generator = PathGenerator::new(scene, 1e-6, tracks.clone()).unwrap();
    let mut sphere = scene.clone();
    sphere.targets[0].aspect = None;
    let of_sphere = PathGenerator::new(&sphere, 1e-6, tracks).unwrap();
    let of = |index: &u64| {
        let (found, unit) = (evaluate(scene, &generator, *index).0, evaluate(&sphere, &of_sphere, *index).0);
        let ratio = found.amplitude[0].first().map_or(0.0, |a| (a / unit.amplitude[0][0]).norm_sqr());
        let vv = found.amplitude[3].first().map_or(0.0, |a| (a / unit.amplitude[3][0]).norm_sqr());
        assert!((vv - ratio).abs() <= 1e-12 * ratio);
        ratio
    };
    pulses.iter().map(of).collect()
}

#[test]
fn a_plate_is_recovered_as_a_platform_flies_by() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.csv");
    let step_deg: f64 = 0.05;
    std::fs::write(&path, table(step_deg)).unwrap();
    let mut scene = scene();
    scene.targets = vec![target([0.0; 3], [0.0; 3])];
    // The bow points North, the platform flies to the East, 1000 m off, half a degree a pulse at most.
    scene.targets[0].aspect = aspect(&path, 0.0);
    scene.pulses = 500;
    let (start, speed) = (-500.0, 444.0);
    let end = ([start, 1000.0, 0.0], [speed, 0.0, 0.0]);
    let pulses: Vec<u64> = (0..500).collect();
    let found = cross_sections(&scene, [end, end], &pulses);
    // Steepest over a null, per rad. A corner half-way between two points is passed at 3/8 of what the slope
    // makes of a step: (1/2 + 1/2)/2 less the slopes' (1/2 + 1/2)/8.
    let slope = 2.0 * 0.5 / 0.0299792458;
    let corner = 0.375 * slope * step_deg.to_radians();
    let (mut smooth, mut anywhere, mut seen) = (0.0f64, 0.0f64, 0.0f64);
    for (index, sigma) in pulses.iter().zip(found) {
        // Aspect at the scattering: half the delay after the emission.
        let t_s = *index as f64 / 222.0;
        let azimuth_rad = (start + speed * (t_s + 3.5e-6)).atan2(1000.0);
        let off = (sigma.sqrt() / 10.0 - plate(azimuth_rad)).abs();
        anywhere = anywhere.max(off);
        seen = seen.max(sigma);
        let nearest = (azimuth_rad.sin() * slope - (azimuth_rad.sin() * slope).round()).abs() / slope;
        if nearest > 2.0 * step_deg.to_radians() || azimuth_rad.abs() < 0.01 {
            smooth = smooth.max(off);
        }
    }
    println!("off by {smooth:.1e} of the peak between nulls, {anywhere:.1e} at them");
    // Slopes by central differences are off by h^2/6 of the third derivative, less than (k a)^3; a cubic
    // keeps a tenth of it.
    let cubic = (std::f64::consts::PI * slope * step_deg.to_radians()).powi(3) / 60.0;
    assert!(smooth < cubic, "{smooth} {cubic}");
    assert!(anywhere < corner, "{anywhere} {corner}");
    assert!(seen > 99.0, "the flash is passed: {seen}");
}

#[test]
fn headings_and_sides() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.csv");
    // Bow 0 dBsm, starboard 10, stern 20, port 30; 40 from above.
    let mut text = String::from("az_deg,el_deg,rcs_dbsm\n");
    for (azimuth, dbsm) in [(0, 0), (90, 10), (180, 20), (270, 30)] {
        for (elevation, dbsm) in [(-90, dbsm), (0, dbsm), (90, 40)] {
            writeln!(text, "{azimuth},{elevation},{dbsm}").unwrap();
        }
    }
    std::fs::write(&path, text).unwrap();
    let seen = |heading_deg: f64, ends: [[f64; 3]; 2]| {
        let mut scene = scene();
        scene.targets[0].aspect = aspect(&path, heading_deg);
        10.0 * cross_sections(&scene, ends.map(|end| (end, [0.0; 3])), &[0])[0].log10()
    };
    let [north, east, south] = [[0.0, 2000.0, 0.0], [2000.0, 0.0, 0.0], [0.0, -2000.0, 0.0]];
    let above = [0.0, 0.0, 2000.0];
    for (heading_deg, at, dbsm) in [
        (0.0, north, 0.0),
        (0.0, east, 10.0),
        (0.0, south, 20.0),
        (90.0, north, 30.0),
        (90.0, east, 0.0),
        (-90.0, north, 10.0),
        (30.0, above, 40.0),
    ] {
        let found = seen(heading_deg, [at, at]);
        assert!((found - dbsm).abs() < 1e-9, "{heading_deg} {at:?}: {found}");
    }
    // Bistatic: North-West and North-East are North, whatever the distances.
    let (left, right) = ([-1000.0, 1000.0, 0.0], [3000.0, 3000.0, 0.0]);
    for ends in [[left, right], [right, left]] {
        assert!(seen(0.0, ends).abs() < 1e-9);
    }
}

#[test]
fn faults_of_a_file_come_together_with_their_lines() {
    let parse = |text: &str| GridPattern::parse_as(Quantity::CrossSection, text.as_bytes(), -300.0);
    let faults = parse("az_deg,el_deg,rcs_dbsm\n0,0,1\n1,0,121\n2,0,3\n0,1\n1,1,1\n2,95,0\n").unwrap_err();
    let listed: Vec<String> = faults.iter().map(ToString::to_string).collect();
    let has = |what: &str| assert!(listed.iter().any(|f| f.contains(what)), "{what} not in {listed:#?}");
    has("line 3: rcs_dbsm '121': dBsm from -300 to 120 wanted");
    has("line 5: 2 fields, 3 wanted");
    has("line 7: el_deg '95'");
    for text in ["az_deg,el_deg,gain_dbi\n0,0,1\n", "az_deg,el_deg,rcs_dbsm,phase_deg\n0,0,1,0\n"] {
        let faults = parse(text).unwrap_err();
        assert!(matches!(faults[..], [PatternFault::Header { wanted: "az_deg,el_deg,rcs_dbsm", .. }]));
    }
    let mut scene = scene();
    scene.targets[0].aspect = aspect(Path::new("no/such/table.csv"), 0.0);
    let tower = straight(&scene, [100.0, 0.0, 0.0], [0.0; 3]);
    let error = PathGenerator::new(&scene, 1e-6, vec![tower.clone(), tower]).unwrap_err().to_string();
    assert!(error.contains("target 't': file of cross sections no/such/table.csv"), "{error}");
}
