//! Properties of tracks: smoothness, support, span, attitude.

use insta::assert_snapshot;
use nereus::frames::{Earth, Geodetic, Point, Rotation, SceneFrame, Vector};
use nereus::motion::{State, Track, TrackError};
use nereus::nav::TrackSource;
use nereus::nav::{AttitudeSource, FileSource, Fix, Place, Smoothing};
use nereus::time::TimeTag;
use proptest::prelude::*;

use crate::sources;

fn start() -> TimeTag {
    TimeTag::new(1_527_705_600, 0.123_456_789)
}

fn plain() -> SceneFrame {
    SceneFrame::plain(Earth::Flat)
}

fn at(state: &State) -> [f64; 3] {
    state.position.to_array()
}

/// A helix with a changing pitch: circle of 2 km at 100 m/s, climbing.
fn helix(t: f64) -> ([f64; 3], [f64; 3]) {
    let (r, w) = (2000.0, 0.05);
    let (s, c) = (w * t).sin_cos();
    ([r * s, r * c, 1000.0 + 2.0 * t], [r * w * c, -r * w * s, 2.0])
}

fn helix_fixes(times_s: &[f64]) -> Vec<Fix> {
    times_s
        .iter()
        .map(|&t| {
            let [x, y, z] = helix(t).0;
            Fix::at(start().plus(t), Place::Local(Point::new(x, y, z)))
        })
        .collect()
}

fn source(attitude: AttitudeSource) -> FileSource {
    FileSource { attitude, ..sources::csv("helix.csv") }
}

#[test]
fn exact_fixes_are_met_and_converge_at_high_order() {
    let mut errors = Vec::new();
    for step in [2.0, 1.0] {
        let times: Vec<f64> = (0..=(100.0 / step) as usize).map(|i| i as f64 * step).collect();
        let fixes = helix_fixes(&times);
        let (track, report) = Track::recorded(&fixes, &plain(), &source(AttitudeSource::Level)).unwrap();
        assert_eq!(report.rejected_horizontal, 0);
        for fix in &fixes {
            let Place::Local(place) = fix.place else { panic!("not local") };
            assert_eq!(track.state(fix.time).unwrap().position, place);
        }
        // Away from the ends, where the stencil is central.
        let worst = (200..800)
            .map(|i| {
                let t = f64::from(i) * 0.1 + 0.05;
                let state = track.state(start().plus(t)).unwrap();
                let (p, v) = helix(t);
                let dp = (state.position - Point::new(p[0], p[1], p[2])).norm();
                let dv = (state.velocity - Vector::new(v[0], v[1], v[2])).norm();
                [dp, dv]
            })
            .fold([0.0f64; 2], |worst, e| [worst[0].max(e[0]), worst[1].max(e[1])]);
        println!("step {step} s: {:.3e} m, {:.3e} m/s", worst[0], worst[1]);
        errors.push(worst);
    }
    // Hermite's own remainder is p^(6) h^6/(720 64) = 2000 0.05^6 64/46080 = 4.3e-8 m at 2 s; node velocities
    // (error p^(7) h^6 36/5040 = 7.1e-7 m/s, times h times at most 0.16 from each end) add 2.3e-7 m at most.
    assert!(errors[0][0] < 3e-7, "{:?}", errors[0]);
    // Sixth order is a factor 64; one factor of 2 is left for what is not yet asymptotic and for rounding
    // (5e-10 m).
    assert!(errors[1][0] < errors[0][0] / 32.0 + 1e-9, "{errors:?}");
}

#[test]
fn nothing_is_extrapolated() {
    let fixes = helix_fixes(&[0.0, 1.0, 2.0, 3.0]);
    let (track, _) = Track::recorded(&fixes, &plain(), &source(AttitudeSource::Level)).unwrap();
    let (first, last) = track.span().unwrap();
    assert!(track.state(first).is_ok() && track.state(last).is_ok());
    assert_snapshot!(track.state(first.plus(-1e-9)).unwrap_err(), @"the track covers 2018-05-30T18:40:00.123456Z to 2018-05-30T18:40:03.123456Z; asked for 2018-05-30T18:40:00.123456Z, 0.000000001 s before its begin");
    assert!(track.state(last.plus(1e-9)).is_err());
    assert_eq!(track.covers(first, last), Ok(()));
    assert_snapshot!(track.covers(first, last.plus(7.5)).unwrap_err(), @"the track covers 2018-05-30T18:40:00.123456Z to 2018-05-30T18:40:03.123456Z (3.000 s); asked for 2018-05-30T18:40:00.123456Z to 2018-05-30T18:40:10.623456Z: 7.500 s are missing at the end");
    assert_snapshot!(track.covers(first.plus(-1.5), last.plus(7.5)).unwrap_err(), @"the track covers 2018-05-30T18:40:00.123456Z to 2018-05-30T18:40:03.123456Z (3.000 s); asked for 2018-05-30T18:39:58.623456Z to 2018-05-30T18:40:10.623456Z: 1.500 s are missing at the beginning and 7.500 s at the end");
    let fixed = Track::fixed(Point::new(1.0, 2.0, 3.0), Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0));
    assert_eq!(fixed.span(), None);
    assert_eq!(fixed.covers(first.plus(-1e9), last.plus(1e9)), Ok(()));
}

#[test]
fn faults_of_building_are_reported() {
    let message = |fixes: &[Fix], frame: &SceneFrame, source: &FileSource| {
        Track::recorded(fixes, frame, source).unwrap_err().to_string()
    };
    let frame = plain();
    let level = source(AttitudeSource::Level);
    assert_snapshot!(message(&helix_fixes(&[0.0]), &frame, &level), @"helix.csv: usable fixes: 1, needed: at least 2");
    assert_snapshot!(message(&helix_fixes(&[0.0, 2.0, 1.0]), &frame, &level), @"helix.csv: fix 2 (2018-05-30T18:40:01.123456Z) is not finite or not later than the one before");
    assert_snapshot!(message(&helix_fixes(&[0.0, 1.0]), &frame, &source(AttitudeSource::Recorded)), @"helix.csv: attitude = recorded, but 2 of 2 fixes have none");
    let mut there = helix_fixes(&[0.0, 1.0, 2.0]);
    for (i, fix) in there.iter_mut().enumerate() {
        fix.place = Place::Geodetic(Geodetic::from_deg(53.0 + 1e-6 * i as f64, 4.5, 0.0));
    }
    assert_snapshot!(message(&there, &frame, &level), @"helix.csv: positions are latitudes and longitudes, but the scene is a plain local frame; give the scene an origin, or the track x_m, y_m, z_m");
    // 0.1 m/s is no heading.
    let origin = SceneFrame::at(Geodetic::from_deg(53.0, 4.5, 42.0), Earth::Flat);
    assert_snapshot!(message(&there, &origin, &level), @"helix.csv: the heading is to follow the motion, but at 2018-05-30T18:40:00.123456Z the horizontal speed is 0.111 m/s; needed: at least 1 m/s, or a recorded or constant attitude");
    let constant = AttitudeSource::Constant(Rotation::from_yaw_pitch_roll(1.0, 0.0, 0.0));
    assert!(Track::recorded(&there, &origin, &source(constant)).is_ok());
    let mut spinning = helix_fixes(&[0.0, 1.0, 2.0]);
    for (i, fix) in spinning.iter_mut().enumerate() {
        fix.yaw_pitch_roll_rad = Some([2.0 * i as f64, 0.0, 0.0]);
    }
    assert_snapshot!(message(&spinning, &frame, &source(AttitudeSource::Recorded)), @r#"helix.csv: the attitude turns by 114.6 deg to the fix at 2018-05-30T18:40:01.123456Z; allowed: 90 deg between fixes; where it is derived from noisy fixes, track.smoothing (kind = "rts") evens them out; track.attitude = "constant" takes none from the file"#);
    let rts = |max_acceleration_mps2| FileSource {
        smoothing: Smoothing::Rts { horizontal_sigma_m: 1.0, vertical_sigma_m: 1.0, max_acceleration_mps2 },
        ..source(AttitudeSource::Level)
    };
    let times: Vec<f64> = (0..120).map(f64::from).collect();
    // The helix is flown with 5 m/s^2.
    assert_snapshot!(message(&helix_fixes(&times), &frame, &rts(2.0)), @"helix.csv: even the smoothest track through the fixes reaches 2.519 m/s^2; allowed: 2 m/s^2");
    assert!(Track::recorded(&helix_fixes(&times), &frame, &rts(5.5)).is_ok());
    assert_snapshot!(message(&helix_fixes(&times), &frame, &rts(-1.0)), @"helix.csv: max_acceleration_mps2 = -1 is not allowed: 0.0001 to 10000");
    let place = Place::Geodetic(Geodetic::from_deg(53.0, 4.5, 0.0));
    let straight = TrackSource::Straight { place, velocity: Vector::new(0.0, 0.0, 1.0), attitude: None };
    assert_snapshot!(Track::from_source(&straight, &origin, start()).unwrap_err(), @"the heading is to follow the motion, but the horizontal velocity is zero; give an attitude");
    let attitude = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
    let fixed = TrackSource::Fixed { place, attitude };
    assert_snapshot!(Track::from_source(&fixed, &frame, start()).unwrap_err(), @"a platform is placed by latitude and longitude, but the scene is a plain local frame; give the scene an origin, or the platform a local position");
}

#[test]
fn the_error_of_a_state_is_small() {
    assert!(std::mem::size_of::<TrackError>() <= 96, "{}", std::mem::size_of::<TrackError>());
}

#[test]
fn a_coordinated_turn_banks_into_the_turn() {
    let times: Vec<f64> = (0..60).map(f64::from).collect();
    let (track, _) =
        Track::recorded(&helix_fixes(&times), &plain(), &source(AttitudeSource::CoordinatedTurn)).unwrap();
    for i in 100..500 {
        let t = f64::from(i) * 0.1;
        let [yaw, pitch, roll] = track.state(start().plus(t)).unwrap().attitude.to_yaw_pitch_roll();
        // Clockwise from North at 0.05 rad/s, starting eastwards: a right turn of v^2/r = 5 m/s^2.
        let want = (std::f64::consts::FRAC_PI_2 + 0.05 * t).rem_euclid(std::f64::consts::TAU);
        // The acceleration at the nodes is exact to p^(7) h^5/140 = 2000 0.05^7/140 = 1e-8 m/s^2, hence the
        // roll to 1e-9; the quaternion, of frequency 0.025 rad/s, is interpolated to 1e-12.
        assert!((yaw - want).abs() < 1e-8, "{t}: {yaw} {want}");
        assert!((pitch - 2f64.atan2(100.0)).abs() < 1e-8);
        assert!((roll - (5.0f64 / 9.80665).atan()).abs() < 1e-8, "{roll}");
    }
}

#[test]
fn attitude_of_a_fix_is_relative_to_its_own_vertical() {
    // 500 km East of the origin the vertical leans by 4.5 deg; level there is level there.
    let frame = SceneFrame::at(Geodetic::from_deg(0.0, 0.0, 0.0), Earth::Flat);
    let fixes: Vec<Fix> = (0..5)
        .map(|i| {
            let place = Place::Geodetic(Geodetic::from_deg(0.0, 4.5 + 1e-3 * f64::from(i), 1000.0));
            Fix { yaw_pitch_roll_rad: Some([0.0, 0.0, 0.0]), ..Fix::at(start().plus(f64::from(i)), place) }
        })
        .collect();
    for attitude in [AttitudeSource::Recorded, AttitudeSource::Level] {
        let (track, _) = Track::recorded(&fixes, &frame, &source(attitude)).unwrap();
        let state = track.state(fixes[0].time).unwrap();
        let down = (state.attitude * Vector::new(0.0, 0.0, 1.0)).to_array();
        let lean = 4.5f64.to_radians();
        assert!((down[0] + lean.sin()).abs() < 1e-12 && (down[2] + lean.cos()).abs() < 1e-12, "{down:?}");
    }
}

/// Central differences of the track against its own derivatives, close to and across nodes.
fn check_smoothness(track: &Track, nodes: &[TimeTag], scale_mps2: f64) {
    let (first, last) = track.span().unwrap();
    for node in nodes {
        for offset in [-0.3, -1e-3, 0.0, 1e-3, 0.4] {
            let t = node.plus(offset);
            let d = 1e-4;
            if t.plus(-d).since(first) < 0.0 || last.since(t.plus(d)) < 0.0 {
                continue;
            }
            let [a, s, b] = [-d, 0.0, d].map(|d| track.state(t.plus(d)).unwrap());
            let (before, after) = (t.since(t.plus(-d)), t.plus(d).since(t));
            let span = before + after;
            let velocity = (b.position - a.position) * (1.0 / span);
            // Half the acceleration step over d plus rounding of positions of 1e4 m over 2 d.
            let tolerance = scale_mps2 * d + 1e4 * 4e-16 / d;
            assert!((velocity - s.velocity).norm() < tolerance, "{offset}: {velocity:?} {s:?}");
            let acceleration = (b.velocity - a.velocity) * (1.0 / span);
            // The jerk may step at a node: by at most 60 times the acceleration scale per second, times d.
            assert!(
                (acceleration - s.acceleration).norm() < 60.0 * scale_mps2 * d + 1e-7,
                "{acceleration:?} {s:?}"
            );
            // omega from two attitudes: dq q* = omega dt/2.
            let (qa, qb) = (a.attitude.raw(), b.attitude.raw());
            let turn = qb * qa.conjugate();
            let omega = turn.xyz() * (2.0 * turn.w.signum() / span);
            assert!((omega - s.angular_rate.raw()).length() < 1e-4, "{omega:?} {:?}", s.angular_rate);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(64) })]

    #[test]
    fn tracks_are_c2_and_rates_are_theirs(
        steps in proptest::collection::vec(0.6f64..1.5, 8..30),
        rts in any::<bool>(),
        angles in proptest::collection::vec((0.0f64..0.2, -0.1f64..0.1, -0.2f64..0.2), 31),
    ) {
        let mut times = vec![0.0];
        for step in steps {
            times.push(times[times.len() - 1] + step);
        }
        let mut fixes = helix_fixes(&times);
        for (i, fix) in fixes.iter_mut().enumerate() {
            let (yaw, pitch, roll) = angles[i % angles.len()];
            fix.yaw_pitch_roll_rad = Some([6.0 + yaw + 0.1 * i as f64, pitch, roll]);
        }
        let mut wanted = source(AttitudeSource::Recorded);
        if rts {
            wanted.smoothing = Smoothing::Rts { horizontal_sigma_m: 1.0, vertical_sigma_m: 1.0, max_acceleration_mps2: 7.0 };
        }
        let (track, report) = Track::recorded(&fixes, &plain(), &wanted).unwrap();
        if rts {
            prop_assert!(report.max_acceleration_mps2 <= 7.0);
        }
        let nodes: Vec<TimeTag> = fixes.iter().map(|fix| fix.time).collect();
        check_smoothness(&track, &nodes, 10.0);
        for (fix, node) in fixes.iter().zip(&nodes) {
            let want = fix.yaw_pitch_roll_rad.unwrap();
            let want = Rotation::from_yaw_pitch_roll(want[0], want[1], want[2]).raw();
            prop_assert!(track.state(*node).unwrap().attitude.raw().dot(want).abs() > 1.0 - 1e-12);
        }
    }

    #[test]
    fn only_the_span_answers(t in -20.0f64..30.0) {
        let (track, _) = Track::recorded(&helix_fixes(&[0.0, 1.0, 2.5, 3.0, 9.0]), &plain(), &source(AttitudeSource::Level)).unwrap();
        prop_assert_eq!(track.state(start().plus(t)).is_ok(), (0.0..=9.0).contains(&start().plus(t).since(start())));
    }

    /// Moving a fix moves the track near it alone: a node state takes seven fixes, a segment two nodes.
    #[test]
    fn support_is_finite(moved in 10usize..20) {
        let times: Vec<f64> = (0..30).map(f64::from).collect();
        let fixes = helix_fixes(&times);
        let mut other = fixes.clone();
        other[moved].place = Place::Local(Point::new(0.0, 0.0, 0.0));
        let build = |fixes: &[Fix]| {
            let constant = AttitudeSource::Constant(Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0));
            Track::recorded(fixes, &plain(), &source(constant)).unwrap().0
        };
        let (a, b) = (build(&fixes), build(&other));
        for i in 0..290 {
            let t = f64::from(i) * 0.1;
            let same = a.state(start().plus(t)).unwrap() == b.state(start().plus(t)).unwrap();
            if (t - moved as f64).abs() > 4.0 {
                prop_assert!(same, "{t}");
            }
        }
    }
}

#[test]
fn states_do_not_depend_on_the_epoch() {
    // The same motion in 1970 and in 2200: only the fraction of the node times may round (2^-53 s at 100
    // m/s).
    let build = |zero: TimeTag| {
        let fixes: Vec<Fix> = (0..20)
            .map(|i| {
                let [x, y, z] = helix(f64::from(i)).0;
                Fix::at(zero.plus(f64::from(i)), Place::Local(Point::new(x, y, z)))
            })
            .collect();
        Track::recorded(&fixes, &plain(), &source(AttitudeSource::Level)).unwrap().0
    };
    let (old, new) = (TimeTag::new(0, 0.25), TimeTag::new(7_258_118_400, 0.25));
    let (a, b) = (build(old), build(new));
    for i in 0..190 {
        let t = f64::from(i) * 0.1;
        assert_eq!(at(&a.state(old.plus(t)).unwrap()), at(&b.state(new.plus(t)).unwrap()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(256) })]

    /// Whatever the fixes are: a clear error, or a track that is finite everywhere and keeps its bound.
    #[test]
    fn wild_fixes_give_an_error_or_a_finite_track(
        raw in proptest::collection::vec((-4.0f64..3.0, -7.0f64..7.0, any::<[bool; 3]>(), any::<[i8; 3]>()), 2..40),
        log10_bound in -3.0f64..3.0,
        rts in any::<bool>(),
        which in 0usize..3,
    ) {
        let mut time = start();
        let fixes: Vec<Fix> = raw
            .iter()
            .map(|(log10_step, log10_scale, signs, angles)| {
                time = time.plus(10f64.powf(*log10_step));
                let [x, y, z] = signs.map(|sign| if sign { 1.0 } else { -1.0 } * 10f64.powf(*log10_scale));
                let yaw_pitch_roll_rad = Some(angles.map(|angle| f64::from(angle) / 40.0));
                Fix { yaw_pitch_roll_rad, ..Fix::at(time, Place::Local(Point::new(x, y, z))) }
            })
            .collect();
        let attitude = [
            AttitudeSource::CoordinatedTurn,
            AttitudeSource::Recorded,
            AttitudeSource::Constant(Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0)),
        ][which];
        let bound = 10f64.powf(log10_bound);
        let smoothing = if rts {
            Smoothing::Rts { horizontal_sigma_m: 1e4, vertical_sigma_m: 1e4, max_acceleration_mps2: bound }
        } else {
            Smoothing::Off
        };
        let wanted = FileSource { smoothing, max_gap_s: 1e9, ..source(attitude) };
        match Track::recorded(&fixes, &plain(), &wanted) {
            Err(error) => prop_assert!(error.to_string().starts_with("helix.csv: ")),
            Ok((track, report)) => {
                prop_assert!(!rts || report.max_acceleration_mps2 <= bound);
                let (first, last) = track.span().unwrap();
                for i in 0..=200 {
                    let t = first.plus(last.since(first) * f64::from(i) / 200.0);
                    // The last instant may round past the end.
                    let Ok(state) = track.state(t) else { continue };
                    let q = state.attitude.raw();
                    prop_assert!(at(&state).iter().all(|x| x.is_finite()) && (q.length() - 1.0).abs() < 1e-12);
                    let rates = [state.velocity, state.acceleration, state.angular_rate];
                    prop_assert!(rates.iter().all(|v| v.norm().is_finite()));
                    if rts {
                        // Sampled in rounding of 1e-16 of the largest terms of the segment.
                        prop_assert!(state.acceleration.norm() <= bound * (1.0 + 1e-6) + 1e-6);
                    }
                }
            }
        }
    }
}
