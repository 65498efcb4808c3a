//! What is written is read back, by the project's own decoder and by others.

use nereus::frames::{Earth, Geodetic, Point, Rotation, SceneFrame, Vector};
use nereus::nav::encode::{EncodeError, Format, Sentence};
use nereus::nav::solution::Solution;
use nereus::nav::{Fix, Place, Sigma, VerticalDatum};
use nereus::time::TimeTag;
use proptest::prelude::*;

use crate::decoding::assemble;

/// A state of a flight, one a second.
pub fn solution_of(second: u32) -> Solution {
    let s = f64::from(second);
    Solution {
        time: TimeTag::from_iso8601("2018-05-30T18:40:00.125Z").unwrap().plus(s),
        place: Geodetic::from_deg(53.1 + 1e-3 * s, 4.6 - 2e-4 * s, 1_234.567_89 + s),
        undulation_m: 43.25,
        velocity_mps: Some([-13.5, 111.2, 1.0]),
        yaw_pitch_roll_rad: Some([6.2, 0.05, -0.1 + 0.01 * s]),
        sigma: Sigma {
            position_m: Some([0.5, 0.25, 1.0]),
            velocity_mps: Some([0.0625, 0.125, 0.25]),
            angles_rad: Some([0.01, 0.002, 0.003]),
        },
    }
}

fn read_back(format: &Format, solution: &Solution) -> Fix {
    let mut out = Vec::new();
    format.write(solution, &mut out).unwrap();
    let epochs = assemble(&out);
    assert_eq!(epochs.len(), 1, "{}", String::from_utf8_lossy(&out));
    // The datum is that of the messages.
    epochs[0].fix(VerticalDatum::Ellipsoid, f64::NAN).unwrap()
}

fn distance_m(a: Geodetic, b: Place) -> f64 {
    let Place::Geodetic(b) = b else { panic!("not geodetic") };
    (a.to_ecef() - b.to_ecef()).norm()
}

/// The rotation between two attitudes, radians.
fn between_rad(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [a, b] = [a, b].map(|[y, p, r]| Rotation::from_yaw_pitch_roll(y, p, r).raw());
    let q = a.conjugate() * b;
    2.0 * q.xyz().length().atan2(q.w.abs())
}

fn any_solution() -> impl Strategy<Value = Solution> {
    let time = (315_964_800i64..4_000_000_000, 0.0..1.0f64);
    let place = (-90.0..=90.0f64, -180.0..=360.0f64, -1000.0..1e6f64, -110.0..90.0f64);
    let motion = ([-8e3..8e3f64, -8e3..8e3, -1e2..1e2], [-7.0..7.0f64, -2.0..2.0, -4.0..4.0]);
    let sigma = (any::<bool>(), 0.0..100.0f32, 0.0..1.0f32);
    (time, place, motion, sigma).prop_map(
        |((seconds, fraction), (lat, lon, h_m, undulation_m), (velocity, angles), (stated, metres, rad))| {
            Solution {
                time: TimeTag::new(seconds, fraction),
                place: Geodetic::from_deg(lat, lon, h_m),
                undulation_m,
                velocity_mps: Some(velocity),
                yaw_pitch_roll_rad: Some(angles),
                sigma: Sigma {
                    position_m: stated.then_some([metres, 2.0 * metres, 3.0 * metres]),
                    velocity_mps: None,
                    angles_rad: stated.then_some([rad, rad / 2.0, rad / 4.0]),
                },
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(512) })]

    /// To half of the last digit that is written, see the table of the module.
    #[test]
    fn sentences_are_read_back(solution in any_solution()) {
        let fix = read_back(&Format::Nmea(Sentence::ALL.to_vec()), &solution);
        prop_assert!(fix.time.since(solution.time).abs() <= 0.5e-9 + 1e-12);
        // Half of 1e-8 minutes (1.86 m a thousandth) along both axes, at heights up to 1000 km 16 % more;
        // height 5e-6 m; f64 of ECEF 1e-9 m a coordinate.
        let allowed_m = 1.16 * 1862e-8 / 2.0 * 2f64.sqrt() + 5e-6 + 3e-9;
        prop_assert!(distance_m(solution.place, fix.place) < allowed_m);
        prop_assert!(allowed_m < 1e-4);
        let ([e, n, _], [fe, fn_]) = (solution.velocity_mps.unwrap(), fix.velocity_mps.unwrap());
        let speed = e.hypot(n);
        // Half of 1e-4 kn along, half of 1e-4 deg across.
        prop_assert!((fe - e).hypot(fn_ - n) <= 0.5e-4 * 0.5145 + speed * 0.5e-4f64.to_radians() + 1e-9);
        // Half of 1e-4 deg about each of three axes.
        let turn_rad = between_rad(solution.yaw_pitch_roll_rad.unwrap(), fix.yaw_pitch_roll_rad.unwrap());
        prop_assert!(turn_rad <= 3.0 * 0.5e-4f64.to_radians() + 1e-9);
        for (a, b) in [(solution.sigma.position_m, fix.sigma.position_m), (solution.sigma.angles_rad, fix.sigma.angles_rad)] {
            prop_assert_eq!(a.is_some(), b.is_some());
            for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                // Half of 1e-4 and the rounding of f32.
                prop_assert!((a - b).abs() <= 0.5e-4 + 1.2e-7 * a);
            }
        }
    }

    /// The label is the nearest millisecond, and the place that of the label.
    #[test]
    fn inspvax_is_read_back(solution in any_solution(), ascii in any::<bool>()) {
        let format = if ascii { Format::InspvaxAscii } else { Format::InspvaxBinary };
        let fix = read_back(&format, &solution);
        let step_s = fix.time.since(solution.time);
        prop_assert!(step_s.abs() <= 0.5e-3 + 1e-9);
        let velocity = solution.velocity_mps.unwrap();
        let [e, n, u] = velocity;
        let local = SceneFrame::at(solution.place, Earth::Flat);
        let moved = local.to_ecef(Point::new(e * step_s, n * step_s, u * step_s)).unwrap();
        let Place::Geodetic(found) = fix.place else { panic!("not geodetic") };
        // Half of 1e-11 deg twice and of 1e-5 m; 6 m of way on a sphere of 6.3e6 m curve by 3e-6 m, near the
        // poles by way^2 tan(lat) / radius.
        let way_m = velocity.iter().map(|v| v * step_s).fold(0.0, f64::hypot);
        let bend_m = way_m * way_m * (1.0 + solution.place.lat_rad.tan().abs()) / 6.3e6;
        let allowed_m = 1.6e-6 + 5e-6 + bend_m + 1e-8;
        prop_assert!((moved - found.to_ecef()).norm() <= allowed_m);
        let [fe, fn_] = fix.velocity_mps.unwrap();
        for (a, b) in [(e, fe), (n, fn_), (u, fix.climb_mps.unwrap())] {
            prop_assert!((a - b).abs() <= 0.5e-6 + 1e-9);
        }
        let turn_rad = between_rad(solution.yaw_pitch_roll_rad.unwrap(), fix.yaw_pitch_roll_rad.unwrap());
        prop_assert!(turn_rad <= 1e-9);
    }
}

/// NovAtel: x right, y ahead, z up; Rz(-azimuth) Rx(pitch) Ry(roll) to ENU, written out from the manual.
#[test]
fn angles_of_the_receiver_are_those_of_the_body() {
    let matrix = |azimuth: f64, pitch: f64, roll: f64, [x, y, z]: [f64; 3]| {
        // Right-handed about y, then about x, then left-handed about z.
        let [x, z] = [x * roll.cos() + z * roll.sin(), -x * roll.sin() + z * roll.cos()];
        let [y, z] = [y * pitch.cos() - z * pitch.sin(), y * pitch.sin() + z * pitch.cos()];
        [x * azimuth.cos() + y * azimuth.sin(), -x * azimuth.sin() + y * azimuth.cos(), z]
    };
    for (azimuth, pitch, roll) in [(0.3, 0.2, -0.4), (4.0, -1.1, 2.5), (0.0, 0.0, 0.1), (6.1, 0.7, -3.0)] {
        let body = Rotation::from_yaw_pitch_roll(azimuth, pitch, roll);
        for [x, y, z] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            // Forward is y, starboard x, down -z.
            let ours = (body * Vector::new(y, x, -z)).to_array();
            for (a, b) in ours.iter().zip(matrix(azimuth, pitch, roll, [x, y, z])) {
                assert!((a - b).abs() < 1e-14);
            }
        }
    }
}

/// A state in the frame of a scene is reported in the frame of its place: 60 nautical miles North of an
/// origin on the equator, a level velocity there points down into the ground here.
#[test]
fn states_of_a_scene_are_turned_to_their_place() {
    let frame = SceneFrame::at(Geodetic::from_deg(0.0, 10.0, 30.0), Earth::Flat);
    let there = Geodetic::from_deg(1.0, 10.0, 500.0);
    let place = frame.from_geodetic(there).unwrap();
    let tilt = 1f64.to_radians();
    // North and up of the place along the axes of the scene.
    let north = Vector::new(0.0, tilt.cos(), -tilt.sin());
    let attitude =
        Rotation::from_axes(north, Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, -tilt.sin(), -tilt.cos()));
    let solution = Solution::of_scene(&frame, TimeTag::default(), place, north * 100.0, attitude).unwrap();
    let [e, n, u] = solution.velocity_mps.unwrap();
    assert!(e.abs() < 1e-10 && (n - 100.0).abs() < 1e-10 && u.abs() < 1e-10, "{e} {n} {u}");
    assert!(between_rad(solution.yaw_pitch_roll_rad.unwrap(), [0.0; 3]) < 1e-12);
    assert!((solution.place.to_ecef() - there.to_ecef()).norm() < 1e-8);
    assert_eq!(solution.undulation_m, 30.0);
    let nowhere = SceneFrame::plain(Earth::Flat);
    assert!(Solution::of_scene(&nowhere, TimeTag::default(), place, north, attitude).is_none());
}

#[test]
fn what_is_not_known_is_left_empty_or_refused() {
    let bare =
        Solution { velocity_mps: None, yaw_pitch_roll_rad: None, sigma: Sigma::default(), ..solution_of(0) };
    let mut out = Vec::new();
    Format::Nmea(Sentence::ALL.to_vec()).write(&bare, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert!(
        text.contains("$GPVTG,,T,,M,,N,,K,A*") && text.contains("$GPHDT,,T*") && !text.contains("PASHR"),
        "{text}"
    );
    let epochs = assemble(text.as_bytes());
    assert_eq!((epochs[0].velocity_mps, epochs[0].yaw_pitch_roll_rad), (None, None));
    let write = |solution: &Solution| Format::InspvaxAscii.write(solution, &mut Vec::new());
    assert_eq!(write(&bare), Err(EncodeError::Incomplete));
    let far = Solution { velocity_mps: Some([f64::NAN, 0.0, 0.0]), ..solution_of(0) };
    assert_eq!(write(&far), Err(EncodeError::Range));
    let early = Solution { time: TimeTag::new(0, 0.0), ..solution_of(0) };
    assert_eq!(write(&early), Err(EncodeError::Range));
}

/// Another decoder, in Rust.
#[test]
fn the_crate_nmea_reads_the_sentences() {
    use nmea::ParseResult;
    let solution = solution_of(7);
    let mut out = Vec::new();
    Format::Nmea(Sentence::ALL.to_vec()).write(&solution, &mut out).unwrap();
    let (lat, lon) = (solution.place.lat_rad.to_degrees(), solution.place.lon_rad.to_degrees());
    // Half of 1e-8 minutes.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-10, "{a} {b}");
    let mut seen = Vec::new();
    for line in String::from_utf8(out).unwrap().lines().filter(|line| !line.starts_with("$PASHR")) {
        match nmea::parse_str(line).unwrap() {
            ParseResult::GGA(gga) => {
                near(gga.latitude.unwrap(), lat);
                near(gga.longitude.unwrap(), lon);
                // An altitude of f32.
                assert!((f64::from(gga.altitude.unwrap()) - (solution.place.h_m - 43.25)).abs() < 1e-4);
                seen.push("GGA");
            }
            ParseResult::RMC(rmc) => {
                near(rmc.lat.unwrap(), lat);
                assert_eq!(rmc.fix_time.unwrap().to_string(), "18:40:07.125");
                assert_eq!(rmc.fix_date.unwrap().to_string(), "2018-05-30");
                let course = (-13.5f64).atan2(111.2).to_degrees() + 360.0;
                assert!((f64::from(rmc.true_course.unwrap()) - course).abs() < 1e-4);
                seen.push("RMC");
            }
            ParseResult::VTG(vtg) => {
                let knots = 13.5f64.hypot(111.2) * 3600.0 / 1852.0;
                // Half of 1e-4 kn and an f32.
                assert!((f64::from(vtg.speed_over_ground.unwrap()) - knots).abs() < 1e-4, "{vtg:?}");
                seen.push("VTG");
            }
            ParseResult::HDT(hdt) => {
                assert!((f64::from(hdt.heading.unwrap()).to_radians() - 6.2).abs() < 1e-6);
                seen.push("HDT");
            }
            ParseResult::ZDA(zda) => {
                assert_eq!(zda.utc_date().unwrap().to_string(), "2018-05-30");
                seen.push("ZDA");
            }
            ParseResult::GST(gst) => {
                assert_eq!(gst.alt_sd, Some(1.0));
                seen.push("GST");
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(seen, ["GGA", "RMC", "VTG", "HDT", "ZDA", "GST"]);
}

/// Another decoder, in Python.
#[test]
fn pynmea2_reads_the_sentences() {
    let there = std::process::Command::new("python3").args(["-c", "import pynmea2"]).output();
    if !there.is_ok_and(|ended| ended.status.success()) {
        println!("skipped: no python3 with pynmea2");
        return;
    }
    let solution = solution_of(7);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sentences.nmea");
    let mut out = Vec::new();
    Format::Nmea(Sentence::ALL.to_vec()).write(&solution, &mut out).unwrap();
    std::fs::write(&path, out).unwrap();
    let script = "
import sys, pynmea2
for line in open(sys.argv[1]):
    m = pynmea2.parse(line.strip(), check=True)
    kind = m.sentence_type if hasattr(m, 'sentence_type') else m.manufacturer
    if kind == 'GGA': print(kind, repr(m.latitude), repr(m.longitude), m.altitude, m.geo_sep)
    elif kind == 'RMC': print(kind, repr(m.latitude), m.spd_over_grnd, m.true_course, m.datestamp, m.timestamp)
    elif kind == 'VTG': print(kind, m.spd_over_grnd_kts, m.true_track)
    elif kind == 'HDT': print(kind, m.heading)
    elif kind == 'ZDA': print(kind, m.day, m.month, m.year)
    elif kind == 'GST': print(kind, m.std_dev_latitude, m.std_dev_altitude)
    else: print('PASHR', m.true_heading, m.roll, m.pitch)
";
    let ended = std::process::Command::new("python3").args(["-c", script]).arg(&path).output().unwrap();
    let decoded = String::from_utf8_lossy(&ended.stdout).into_owned();
    assert!(ended.status.success(), "{decoded}{}", String::from_utf8_lossy(&ended.stderr));
    let lines: Vec<Vec<&str>> = decoded.lines().map(|line| line.split(' ').collect()).collect();
    let kinds: Vec<&str> = lines.iter().map(|line| line[0]).collect();
    assert_eq!(kinds, ["GGA", "RMC", "VTG", "HDT", "ZDA", "GST", "PASHR"], "{decoded}");
    let figure = |line: usize, at: usize| lines[line][at].parse::<f64>().unwrap();
    // Half of 1e-8 minutes.
    assert!((figure(0, 1) - solution.place.lat_rad.to_degrees()).abs() < 1e-10);
    assert!((figure(0, 2) - solution.place.lon_rad.to_degrees()).abs() < 1e-10);
    assert!((figure(0, 3) + figure(0, 4) - solution.place.h_m).abs() < 1e-5);
    assert!((figure(2, 1) * 1852.0 / 3600.0 - 13.5f64.hypot(111.2)).abs() < 1e-4);
    assert_eq!((figure(5, 1), figure(5, 2)), (0.25, 1.0));
    assert!((figure(6, 1).to_radians() - 6.2).abs() < 1e-6);
    assert!(
        (figure(6, 2).to_radians() + 0.03).abs() < 1e-6 && (figure(6, 3).to_radians() - 0.05).abs() < 1e-6
    );
}
