//! Ships: what the keys mean, and every way to be wrong.

use proptest::prelude::*;

use super::*;
use crate::scene::Ship;
use crate::scene::hull::LENGTH_RANGE_M;
use crate::scene::ship::{HullGiven, KelvinWake, ShipMotion, TurbulentWake};
use crate::sea::wake::{kochin, turbulent};

const SEA: &str = include_str!("../../../configs/sea.toml");
const WIGLEY: &str = "hull = 'wigley', length_m = 100, beam_m = 13, draught_m = 4.3";

/// Scenarios that between them read every key of a ship.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    vec![
        (
            SEA,
            vec![(
                "ship",
                "[{ hull = 'wigley', length_m = 100, beam_m = 13, draught_m = 4.3, position_m = [0, 0], \
                 heading_deg = 0, speed_mps = 5, turbulent = {} }]",
            )],
        ),
        (
            SEA,
            vec![(
                "ship",
                "[{ hull = 'README.md', track = { kind = 'waypoints', waypoints_m = [[0, 0], [1, 1]], \
                 speed_mps = 5, turn_radius_m = 9, begin_s = 0, waypoints_deg = [[1, 2]] } }, \
                 { hull = 'README.md', track = { kind = 'csv', path = 'README.md', heights = 'sea' } }]",
            )],
        ),
        (
            SEA,
            vec![(
                "target",
                "[{ rcs_m2 = 1, track = { kind = 'csv', path = 'README.md', heights = 'recorded', datum = \
                 'barometric', smoothing = {} } }, { rcs_m2 = 1, track = { kind = 'sbet', path = 'README.md', \
                 gps_week = 2000 } }, { rcs_m2 = 1, track = { kind = 'nmea', path = 'README.md', date = \
                 '2024-05-01' } }]",
            )],
        ),
        (SEA, vec![("ship", "[{ hull = 'README.md', lat_deg = 1, lon_deg = 2, towards_deg = 3 }]")]),
        (
            SEA,
            vec![(
                "ship",
                "[{ hull = 'README.md', position_m = [0, 0], heading_deg = 0, speed_mps = 5, echo = true, \
                 mesh = true, superstructure = 'README.md', freeboard_m = 4, panel_m = 2, motion = 'waves', roll_period_s = 9 }]",
            )],
        ),
    ]
}

fn with_ships(list: &str) -> Result<Run, ConfigError> {
    parse(SEA, &in_configs(), &settings(&[("ship", list)]))
}

fn ship(table: &str) -> Ship {
    with_ships(&format!("[{{ {table} }}]")).unwrap().scene.ships.remove(0)
}

fn faults(list: &str) -> String {
    let error = with_ships(list).unwrap_err();
    let folder = in_configs().parent().unwrap().display().to_string();
    error.faults().iter().map(|fault| format!("{fault}\n").replace(&folder, "configs")).collect()
}

#[test]
fn ranges_are_those_of_the_laws() {
    let range = |key: &'static keys::Key| match key.kind {
        keys::Kind::Number { min, max, .. } => [min, max],
        _ => panic!("{}", key.name),
    };
    assert_eq!(range(&keys::ship::LENGTH_M), LENGTH_RANGE_M);
    assert_eq!(range(&keys::ship::SPEED_MPS), [0.0, kochin::MOST_SPEED_MPS]);
    assert_eq!(range(&keys::turbulent::SPREAD_EXPONENT), turbulent::EXPONENT_RANGE);
}

#[test]
fn defaults_are_those_of_the_descriptions() {
    let found = ship(&format!("{WIGLEY}, position_m = [60, -5], heading_deg = 90, speed_mps = 9"));
    let expected = Ship {
        name: "ship-0".to_owned(),
        hull: HullGiven::Wigley { beam_m: 13.0, draught_m: 4.3 },
        length_m: Some(100.0),
        position_m: [60.0, -5.0],
        heading_rad: 0.0,
        speed_mps: 9.0,
        kelvin: Some(KelvinWake::default()),
        turbulent: Some(TurbulentWake::default()),
        echo: false,
        mesh: Default::default(),
        trajectory: None,
        panels: Default::default(),
    };
    assert_eq!(found, expected);
}

/// A recording of three fixes a second apart about the start, East at 5 m/s.
const RECORDING: &str = "time_utc,x_m,y_m,z_m\n2024-05-01T11:59:59Z,-5,0,7\n2024-05-01T12:00:00Z,0,0,7\n\
                         2024-05-01T12:00:30Z,150,0,7\n";

fn tracked(table: &str) -> Result<Run, ConfigError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("way.csv"), RECORDING).unwrap();
    std::fs::write(folder.path().join("deep.csv"), RECORDING.replace(",7\n", ",-7\n")).unwrap();
    let text = SEA.replace("[scene]\n", "[scene]\nstart_utc = \"2024-05-01T12:00:00Z\"\n");
    parse(&format!("{text}\n{table}\n"), &folder.path().join("my.toml"), &[])
}

const HULL: &str = "[[ship]]\nhull = \"wigley\"\nlength_m = 20\nbeam_m = 3\ndraught_m = 1\n";

#[test]
fn tracks_arrive() {
    let recorded = "track = { kind = \"csv\", path = \"way.csv\", max_gap_s = 40 }";
    let ship = tracked(&format!("{HULL}{recorded}")).unwrap().scene.ships.remove(0);
    assert_eq!((ship.position_m, ship.heading_rad), ([0.0, 0.0], 0.0));
    assert!((ship.speed_mps - 5.0).abs() < 1e-9 && ship.kelvin.is_some_and(|waves| !waves.short_waves));
    let way = ship.trajectory.unwrap();
    // It sails on the sea, whatever heights are recorded.
    assert_eq!((way.span_s(), way.at(15.0).position.to_array()[2]), ([-1.0, 30.0], 0.0));
    let target = |keys: &str| {
        tracked(&format!("[[target]]\nrcs_m2 = 1\n{keys}")).unwrap().scene.targets.pop().unwrap()
    };
    let high = target(&format!("height_m = 3\n{recorded}"));
    assert_eq!(high.at(15.0).0.to_array()[2], 3.0);
    let own = "track = { kind = \"csv\", path = \"way.csv\", max_gap_s = 40, heights = \"recorded\" }";
    assert!((target(own).at(15.0).0.to_array()[2] - 7.0).abs() < 1e-9);
    let round = "track = { kind = \"waypoints\", waypoints_m = [[0, 0], [100, 0], [100, 100]], \
                 speed_mps = 5, turn_radius_m = 20 }";
    let (place, velocity) = target(round).at(1e4);
    assert!(place.to_array()[1] > 1e4 && velocity.to_array()[0].abs() < 1e-9, "{place:?}");
}

#[test]
fn faults_of_tracks_are_named() {
    let text = |table: &str| {
        let error = tracked(table).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    let has = |table: &str, wanted: &str| {
        let found = text(table);
        assert!(found.contains(wanted), "{found}");
    };
    let csv = "track = { kind = \"csv\", path = \"way.csv\"";
    has(&format!("{HULL}{csv} }}"), "gap");
    let open = format!("{csv}, max_gap_s = 40");
    has(&format!("{HULL}{open} }}\nspeed_mps = 3"), "ship.0.speed_mps: ");
    has(&format!("{HULL}{open} }}\nspeed_mps = 3"), "the ship has a track");
    has(&format!("{HULL}{open}, heights = \"recorded\" }}"), "a ship sails on the sea");
    has(&format!("{HULL}{open} }}\nwake_bragg = true"), "allowed with a track: wake_bragg = false");
    has(
        &format!("{HULL}{open} }}\necho = true\nmotion = \"waves\""),
        "allowed with a track: motion = \"level\"",
    );
    has(&format!("[[target]]\nrcs_m2 = 1\n{open} }}\nposition_m = [0, 0, 0]"), "the target has a track");
    let own = format!("[[target]]\nrcs_m2 = 1\n{open}, heights = \"recorded\" }}\n");
    has(&format!("{own}floating = true"), "target.1.floating: the sea lifts a floating target");
    has(&own.replace("way", "deep"), "target.1.track.path: ");
    has(&format!("{own}height_m = 3"), "target.1.height_m: not allowed here (heights = \"recorded\")");
    let round = |points: &str, radius_m: &str| {
        format!(
            "{HULL}track = {{ kind = \"waypoints\", waypoints_m = {points}, speed_mps = 5, turn_radius_m = {radius_m} }}"
        )
    };
    has(&round("[[0, 0], [10, 0], [10, 10]]", "90"), "the leg from waypoint 0 to 1 is 10.0 m long");
    has(&round("[[0, 0], [0, 0]]", "90"), "lie in the same place");
    has(&round("[[0, 0]]", "90"), "a list of 2 to 1000 pairs");
    let now = parse(
        &format!(
            "{SEA}\n{HULL}track = {{ kind = \"csv\", path = \"tracks/north_sea_turn.csv\", max_gap_s = 40 }}"
        ),
        &in_configs(),
        &[],
    );
    let now: String = now.unwrap_err().faults().iter().map(|fault| format!("{fault}\n")).collect();
    assert!(now.contains("ship.0.track.path"), "{now}");
}

#[test]
fn every_setting_arrives() {
    let found = ship(
        "name = 'frigate', hull = '../hulls/dtmb5415.toml', position_m = [1, 2], towards_deg = 30, speed_mps = 4.5, \
         band_limit_radpm = 1.5, turbulent = { spread_exponent = 4, decay_lengths = 7, wind_ratio = 0.1 }, echo = true",
    );
    assert_eq!(found.name, "frigate");
    assert_eq!(found.hull, HullGiven::File(in_configs().parent().unwrap().join("../hulls/dtmb5415.toml")));
    assert_eq!((found.length_m, found.heading_rad), (None, 30f64.to_radians()));
    assert_eq!(found.kelvin, Some(KelvinWake { band_limit_radpm: Some(1.5), short_waves: false }));
    let turbulent = TurbulentWake { spread_exponent: 4.0, decay_lengths: 7.0, wind_ratio: 0.1 };
    assert_eq!((found.turbulent, found.echo), (Some(turbulent), true));
    let off = format!("{WIGLEY}, position_m = [0, 0], heading_deg = 0, speed_mps = 0");
    let off = ship(&format!("{off}, wake = false, turbulent = false"));
    assert_eq!((off.kelvin, off.turbulent, off.heading_rad), (None, None, 90f64.to_radians()));
    let on = format!("{WIGLEY}, position_m = [0, 0], heading_deg = -90, speed_mps = 0, turbulent = true");
    let on = ship(&on);
    assert_eq!((on.turbulent, on.heading_rad), (Some(TurbulentWake::default()), 180f64.to_radians()));
    // Latitude and longitude are those of the frame.
    let text = format!(
        "{}\n[[ship]]\nhull = \"wigley\"\nlength_m = 10\nbeam_m = 1\ndraught_m = 1\nlat_deg = 52\nlon_deg = 4.001\n\
         heading_deg = 0\nspeed_mps = 1\n",
        SEA.replace("[scene]\n", "[scene]\norigin_lat_deg = 52\norigin_lon_deg = 4\norigin_h_m = 40\n")
    );
    let run = parse(&text, &in_configs(), &[]).unwrap();
    let [east_m, north_m] = run.scene.ships[0].position_m;
    // a cos(lat) dlon = 68.7 m with the radius of the prime vertical, 6391 km.
    assert!((east_m - 68.68).abs() < 0.05 && north_m.abs() < 0.01, "{east_m} {north_m}");
}

#[test]
fn ships_that_are_none() {
    insta::assert_snapshot!(faults("[{ }]"), @r#"
ship.0.hull: is missing; required: "wigley", or a file that exists (relative to the scenario file)
ship.0: one of position_m, (lat_deg, lon_deg) is required
ship.0: one of heading_deg, towards_deg is required
ship.0.speed_mps: is missing; required: a number from 0 to 100 m/s
"#);
    insta::assert_snapshot!(faults(&format!("[{{ {WIGLEY}, length_m = 0, position_m = [0, 0, 0], heading_deg = 1, towards_deg = 2, speed_mps = -1 }}]").replacen("length_m = 100, ", "", 1)), @r#"
ship.0.length_m: 0 is out of range; allowed: a number from 0.05 to 1000 m
ship.0.position_m: [0, 0, 0] is not allowed; allowed: a list of 2 numbers from -1e8 to 1e8 m
ship.0.towards_deg: heading_deg, towards_deg exclude each other; allowed: one of them
ship.0.speed_mps: -1 is out of range; allowed: a number from 0 to 100 m/s
"#);
    insta::assert_snapshot!(faults("[{ hull = 'no.toml', beam_m = 1, position_m = [0, 0], lat_deg = 1, heading_deg = 500, speed_mps = 101, wake = false, band_limit_radpm = 1, turbulent = 3, echo = 'yes' }]"), @r#"
ship.0.hull: there is no file configs/no.toml; allowed: "wigley", or a file that exists (relative to the scenario file)
ship.0.position_m: position_m and (lat_deg, lon_deg) exclude each other; allowed: one of them
ship.0.heading_deg: 500 is out of range; allowed: a number from -360 to 360 deg
ship.0.speed_mps: 101 is out of range; allowed: a number from 0 to 100 m/s
ship.0.band_limit_radpm: not allowed here (wake = false)
ship.0.turbulent: 3 is not allowed; allowed: a table [ship.turbulent], true or false
ship.0.echo: "yes" is not allowed; allowed: true or false
"#);
    insta::assert_snapshot!(faults("[{ name = 'a', hull = 'README.md', beam_m = 1, position_m = [0, 0], heading_deg = 0, speed_mps = 1, turbulent = { spread_exponent = 3, decay_lengths = 0, wind = 1 } }, { name = 'a', hull = 'wigley', beam_m = 0, draught_m = 1, position_m = [0, 0], heading = 0, towards_deg = 0, speed_mps = nan, band_limit_radpm = 0 }]"), @r#"
ship.0.beam_m: not allowed here (the hull is that of a file)
ship.0.turbulent.spread_exponent: 3 is out of range; allowed: a number from 4 to 5
ship.0.turbulent.decay_lengths: 0 is out of range; allowed: a number from 0.01 to 10000
ship.0.turbulent.wind: unknown key; allowed: spread_exponent, decay_lengths, wind_ratio
ship.1.name: "a" is already the name of another ship; allowed: unique names
ship.1.length_m: is missing; required with hull = "wigley": a number from 0.05 to 1000 m
ship.1.beam_m: 0 is out of range; allowed: a number above 0, up to 1000 m
ship.1.speed_mps: nan is out of range; allowed: a number from 0 to 100 m/s
ship.1.band_limit_radpm: 0 is out of range; allowed: a number above 0, up to 1e6 rad/m
ship.1.heading: unknown key; did you mean heading_deg, in deg?
"#);
    insta::assert_snapshot!(faults("[{ hull = 'wigley', length_m = 1, beam_m = 0.1, draught_m = 0.1, lat_deg = 1, lon_deg = 2, heading_deg = 0, speed_mps = 1 }]"), @r#"ship.0.lat_deg: a geodetic position needs scene.origin_lat_deg, origin_lon_deg and origin_h_m; allowed here: position_m"#);
}

#[test]
fn ships_ride_the_waves_where_it_is_asked() {
    let at = "position_m = [0, 0], heading_deg = 0, speed_mps = 1";
    let motion = |more: &str| ship(&format!("{WIGLEY}, {at}, {more}")).mesh.motion;
    assert_eq!(motion("echo = true"), ShipMotion::Level);
    let waves = |roll_period_s| ShipMotion::Waves { roll_period_s, form: None };
    assert_eq!(motion("echo = true, motion = 'waves'"), waves(None));
    assert_eq!(motion("echo = true, motion = 'waves', roll_period_s = 9"), waves(Some(9.0)));
    let with = |more: &str| faults(&format!("[{{ {WIGLEY}, {at}, {more} }}]"));
    insta::assert_snapshot!(with("motion = 'waves'"), @"ship.0.motion: not allowed here (echo = false)");
    insta::assert_snapshot!(with("echo = true, mesh = false, motion = 'waves'"), @"ship.0.motion: not allowed here (mesh = false)");
    insta::assert_snapshot!(with("echo = true, roll_period_s = 9"), @r#"ship.0.roll_period_s: not allowed here (motion = "level")"#);
    insta::assert_snapshot!(with("echo = true, motion = 'waves', roll_period_s = 0.4"), @"ship.0.roll_period_s: 0.4 is out of range; allowed: a number from 0.5 to 60 s");
    insta::assert_snapshot!(with("echo = true, motion = 'heave'"), @r#"ship.0.motion: "heave" is not allowed; allowed: "level", "waves""#);
    insta::assert_snapshot!(with("echo = true, motions = 'waves'"), @"ship.0.motions: unknown key; did you mean motion?");
}

#[test]
fn a_ship_needs_a_sea_and_its_patch() {
    let ship = "[{ hull = 'wigley', length_m = 1, beam_m = 0.1, draught_m = 0.1, position_m = [0, 0], heading_deg = 0, speed_mps = 1 }]";
    insta::assert_snapshot!(faults_of(&[("ship", ship)]), @r#"ship: not allowed here (there is no [sea])"#);
    let text = SEA.lines().filter(|line| !line.starts_with("facet_m")).collect::<Vec<_>>().join("\n");
    let error = parse(&text, &in_configs(), &settings(&[("ship", ship)])).unwrap_err();
    assert!(error.to_string().contains("scene.facet_m: is missing"), "{error}");
    let many = (0..1001).map(|_| &ship[1..ship.len() - 1]).collect::<Vec<_>>().join(", ");
    insta::assert_snapshot!(faults(&format!("[{many}]")), @r#"ship: 1001 ships; allowed: at most 1000"#);
}

proptest! {
    #![proptest_config(crate::rng::cases::proptests(200))]

    #[test]
    fn extreme_numbers_of_a_ship_are_read_or_refused(
        index in 0usize..8,
        value in prop_oneof![any::<f64>(), (-12i32..13).prop_map(|e| 10f64.powi(e))],
    ) {
        let key = [
            "length_m", "beam_m", "draught_m", "heading_deg", "speed_mps", "band_limit_radpm",
            "turbulent.decay_lengths", "turbulent.wind_ratio",
        ][index];
        let ship = format!("[{{ {WIGLEY}, position_m = [0, 0], heading_deg = 0, speed_mps = 1, turbulent = {{}} }}]");
        let list = [("ship".to_owned(), ship), (format!("ship.0.{key}"), format!("{value:?}"))];
        match parse(SEA, &in_configs(), &list) {
            Ok(run) => prop_assert!(run.scene.ships[0].heading_rad.is_finite()),
            Err(error) => prop_assert!(!error.faults().is_empty()),
        }
    }
}
