//! Wakes at the ends of what is legal: no panic, NaN or infinity, and errors that say why.

use nereus::scene::Patch;
use nereus::sea::surface::{Fields, Grid, Selection};
use nereus::sea::wake::{Course, Map, Presence, Reach, Settings, Upstream, Wake, WakeError, Wigley};
use num_complex::Complex64;
use proptest::prelude::*;

use crate::wake_map::{SHIP, all, map_of, wake};

fn settings(facet_m: f64) -> Settings {
    Settings::new(facet_m, Reach::disc(300.0))
}

fn eastward(speed_mps: f64) -> Course {
    Course::straight([0.0, 0.0], 0.0, speed_mps)
}

#[test]
fn slow_ships_have_no_wake() {
    let at = |speed_mps: f64, facet_m: f64| wake(SHIP, eastward(speed_mps), &settings(facet_m)).presence();
    for speed_mps in [0.0, f64::MIN_POSITIVE, 1e-150, 0.0999] {
        assert_eq!(at(speed_mps, 1e-3), Presence::Slow);
    }
    // 2 pi V^2/g = 4 m at V = 2.4990 m/s.
    assert_eq!(at(2.4989, 1.0), Presence::Unresolved);
    assert_eq!(at(2.4991, 1.0), Presence::Waves);
    let away = Settings { cutoff_rad_m: Some(0.1), ..settings(1.0) };
    let away = wake(SHIP, eastward(4.5), &away);
    assert_eq!(away.presence(), Presence::BandLimited);
    // No presence: no waves, and a map is left as it was.
    let patch = Patch::new([32.0, 32.0], 1.0, [-60.0, 0.0]).unwrap();
    let fields = map_of::<f64>(vec![away], &patch, -100.0, 0.0);
    assert_eq!(fields, Fields::new(&Grid::new(32, 32, 1.0).unwrap(), Selection::ALL));
}

#[test]
fn what_is_refused() {
    let make = |course: Course, length_m: f64, settings: &Settings| {
        Wake::new(course, length_m, settings, |t| SHIP.amplitude_m(course.speed_mps, t)).unwrap_err()
    };
    for speed_mps in [-1.0, -1e-300, f64::NAN, f64::INFINITY, 101.0] {
        let error = make(eastward(speed_mps), 100.0, &settings(1.0));
        assert!(matches!(error, WakeError::Speed { .. }), "{error}");
    }
    assert_eq!(
        make(eastward(-1.0), 100.0, &settings(1.0)).to_string(),
        "ship at -1 m/s: allowed are 0 to 100 m/s"
    );
    let adrift = Course { heading_rad: f64::NAN, ..eastward(5.0) };
    assert_eq!(make(adrift, 100.0, &settings(1.0)), WakeError::Course);
    for length_m in [0.0, -3.0, f64::NAN, 1e5] {
        assert!(matches!(make(eastward(5.0), length_m, &settings(1.0)), WakeError::Length { .. }));
    }
    for facet_m in [0.0, -1.0, f64::NAN] {
        assert!(matches!(make(eastward(5.0), 100.0, &settings(facet_m)), WakeError::Facet { .. }));
    }
    for cutoff_rad_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let settings = Settings { cutoff_rad_m: Some(cutoff_rad_m), ..settings(1.0) };
        assert!(matches!(make(eastward(5.0), 100.0, &settings), WakeError::Cutoff { .. }));
    }
    for radius_m in [-1.0, f64::INFINITY, f64::NAN] {
        let error = make(eastward(5.0), 100.0, &Settings { reach: Reach::disc(radius_m), ..settings(1.0) });
        assert!(matches!(error, WakeError::Reach { .. }), "{error}");
    }
    for (reach, cutoff_rad_m) in
        [(Reach::disc(1e9), None), (Reach::disc(1e300), None), (Reach::disc(1.0), Some(f64::MAX))]
    {
        let error = make(eastward(5.0), 100.0, &Settings { reach, cutoff_rad_m, ..settings(1.0) });
        assert!(matches!(error, WakeError::Nodes { .. }), "{error}");
    }
    let nothing = Wake::new(eastward(5.0), 100.0, &settings(1.0), |t| Complex64::new(1.0 / (t - t), 0.0));
    assert!(matches!(nothing, Err(WakeError::Amplitude { tan_theta: 0.0 })));
}

#[test]
fn turns_are_slow_or_refused() {
    let turning = |turn_rate_radps: f64| Course { turn_rate_radps, ..eastward(9.0) };
    // Over 300 m at 9 m/s, 33.3 s, at most 0.05 rad.
    let fast = Wake::new(turning(0.002), 100.0, &settings(1.0), |t| SHIP.amplitude_m(9.0, t));
    assert!(matches!(fast, Err(WakeError::Turn { .. })));
    // The pattern of a slow turn departs from that of its velocities by less than 5 % of V.
    let rate = -0.0015;
    let wake = wake(SHIP, turning(rate), &settings(1.0));
    let dt = 1e-3;
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for i in 0..40 {
        let position_m = [-6.0 * f64::from(i), 2.0 * f64::from(i % 7)];
        let [early, here, late] = [-dt, 0.0, dt].map(|time_s| wake.at(position_m, time_s).unwrap());
        let moved = (late.height_m - early.height_m) / (2.0 * dt);
        worst = worst.max((moved - here.velocity_mps[2]).abs());
        largest = largest.max(here.slope[0].hypot(here.slope[1]));
    }
    // At most 0.05 V times the slope.
    assert!(worst > 1e-6 && worst < 0.05 * 9.0 * largest, "{worst} of {largest}");
}

#[test]
fn beyond_reach_is_an_error_and_nothing_is_added() {
    let wake = wake(SHIP, eastward(9.0), &settings(1.0));
    assert!(matches!(wake.at([-301.0, 0.0], 0.0), Err(WakeError::BeyondReach { .. })));
    assert!(matches!(wake.at([-301.0, 0.0], f64::NAN), Err(WakeError::Time { .. })));
    let patch = Patch::new([64.0, 64.0], 1.0, [-290.0, 0.0]).unwrap();
    let near = crate::wake_map::wake(SHIP, Course::straight([-280.0, 0.0], 0.0, 9.0), &settings(1.0));
    let mut map = Map::<f32>::new(vec![near, wake], &patch, -80.0).unwrap();
    let grid = Grid::new(64, 64, 1.0).unwrap();
    let mut fields = Fields::new(&grid, Selection::ALL);
    assert!(matches!(map.add(patch.first, 0.0, &mut fields), Err(WakeError::BeyondReach { .. })));
    assert_eq!(fields, Fields::new(&grid, Selection::ALL));
    assert!(matches!(map.add(patch.first, f64::INFINITY, &mut fields), Err(WakeError::Time { .. })));
    // Fields of another size.
    let mut other = Fields::new(&Grid::new(8, 8, 1.0).unwrap(), Selection::HEIGHT);
    assert!(matches!(map.add([0, 0], 0.0, &mut other), Err(WakeError::Surface(_))));
    // A ship far behind the patch has not been there yet, however far it is.
    let far = Patch::new([64.0, 64.0], 1.0, [5e4, 0.0]).unwrap();
    map.add(far.first, 0.0, &mut fields).unwrap();
    assert_eq!(fields, Fields::new(&grid, Selection::ALL));
}

#[test]
fn maps_of_one_facet_and_of_one_row() {
    let course = Course::straight([30.0, 4.0], 0.2, 9.0);
    let wake = wake(SHIP, course, &settings(1.0));
    for facets in [[1, 1], [1, 7], [13, 1], [2, 3]] {
        let patch = Patch { facets, facet_m: 1.0, first: [-90, -11] };
        let fields = map_of::<f64>(vec![wake.clone()], &patch, -200.0, 1.0);
        for ix in 0..facets[0] as i64 {
            for iy in 0..facets[1] as i64 {
                let key = [ix - 90, iy - 11];
                let sum = wake.at(patch.centre_m(key), 1.0).unwrap();
                let i = patch.nearest_index(key);
                // -190 dB of metres.
                assert!((fields.height_m[i] - sum.height_m).abs() < 1e-9, "{facets:?}");
                assert!((fields.slope_rate_per_s[1][i] - sum.slope_rate_per_s[1]).abs() < 1e-9, "{facets:?}");
            }
        }
    }
}

#[test]
fn errors_and_facets_of_maps() {
    let patch = Patch::new([8.0, 8.0], 1.0, [0.0, 0.0]).unwrap();
    for error_db in [0.0, -300.0, f64::NAN] {
        assert!(matches!(Map::<f64>::new(Vec::new(), &patch, error_db), Err(WakeError::ErrorBudget { .. })));
    }
    let wake = wake(SHIP, eastward(9.0), &settings(2.0));
    assert!(matches!(Map::<f64>::new(vec![wake], &patch, -80.0), Err(WakeError::FacetsDiffer { .. })));
    let mut none = Map::<f64>::new(Vec::new(), &patch, -80.0).unwrap();
    let mut fields = Fields::new(&Grid::new(8, 8, 1.0).unwrap(), Selection::ALL);
    none.add([3, 4], 0.0, &mut fields).unwrap();
    assert!(all(&fields).iter().all(|(_, field)| field.iter().all(|v| *v == 0.0)));
}

proptest! {
    #![proptest_config(crate::cases::proptests(200))]

    #[test]
    fn every_legal_wake_is_finite(
        length_log in -3.0..4.0f64,
        fullness in 0.01..1.0f64,
        speed_log in -2.0..2.0f64,
        facet_log in -3.0..4.0f64,
        heading_rad in -10.0..10.0f64,
        centre in prop::array::uniform2(-300.0..300.0f64),
        facets in prop::array::uniform2(1usize..20),
        time_s in -1e4..1e4f64,
        symmetric in any::<bool>(),
    ) {
        let [length_m, speed_mps, facet_m] = [length_log, speed_log, facet_log].map(|x| 10f64.powf(x));
        let hull = Wigley { length_m, beam_m: fullness * length_m, draught_m: fullness * length_m };
        let first = centre.map(|x| x as i64);
        let patch = Patch { facets, facet_m, first };
        let course = Course::straight([0.0, 0.0], heading_rad, speed_mps);
        let course = Course {
            position_m: course.position_m(-time_s).map(|x| x + 0.3 * length_m),
            ..course
        };
        let reach = Reach::of(&patch, &course, [time_s, time_s]).unwrap();
        let upstream = if symmetric { Upstream::Symmetric } else { Upstream::RaisedCosine };
        let settings = Settings { upstream, ..Settings::new(facet_m, reach) };
        match Wake::new(course, length_m, &settings, |t| hull.amplitude_m(speed_mps, t)) {
            Err(WakeError::Nodes { needed, .. }) => prop_assert!(needed > 2e5),
            Err(other) => prop_assert!(false, "{}", other),
            Ok(wake) => {
                let fields = map_of::<f64>(vec![wake], &patch, -80.0, time_s);
                for (name, field) in all(&fields) {
                    prop_assert!(field.iter().all(|v| v.is_finite()), "{}", name);
                }
            }
        }
    }
}
