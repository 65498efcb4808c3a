//! Tracks that grow: the bits of a file where enough is known, a smooth and flagged path where it is not.

use std::time::Instant;

use nereus::frames::{Body, Earth, Enu, Geodetic, Point, Rotation, SceneFrame};
use nereus::motion::Track;
use nereus::motion::track::live::{LiveTrack, Unusable};
use nereus::nav::{AttitudeSource, FileFormat, FileSource, Fix, Place, Smoothing, VerticalDatum, load};
use nereus::pulse::flags::{NAV_EXTRAPOLATED, NAV_STALE};
use nereus::time::TimeTag;

use crate::sources;

fn at(t_s: f64) -> TimeTag {
    TimeTag::new(1_600_000_000, 0.0).plus(t_s)
}

/// A circle of 1 km at 100 m/s, climbing: 10 m/s^2.
fn flown(t_s: f64) -> [f64; 3] {
    let turn = 0.1 * t_s;
    [1000.0 * turn.sin(), 1000.0 * turn.cos(), 300.0 + 2.0 * t_s]
}

fn fix(t_s: f64) -> Fix {
    let [x, y, z] = flown(t_s);
    let mut fix = Fix::at(at(t_s), Place::Local(Point::new(x, y, z)));
    fix.yaw_pitch_roll_rad = Some([1.57 + 0.1 * t_s, 0.02, 0.3]);
    fix
}

fn away(track: &LiveTrack, t_s: f64) -> f64 {
    let reported = track.report(at(t_s)).state.position;
    let [x, y, z] = flown(t_s);
    (reported - Point::new(x, y, z)).norm()
}

#[test]
fn bits_are_those_of_a_file() {
    let frame = SceneFrame::at(Geodetic::from_deg(51.0, 1.5, 45.0), Earth::Flat);
    let cart = FileSource {
        path: sources::repository("configs/tracks/cart.inspvax"),
        format: FileFormat::Inspvax,
        datum: VerticalDatum::Ellipsoid,
        undulation_m: 0.0,
        max_gap_s: 5.0,
        smoothing: Smoothing::Off,
        attitude: AttitudeSource::Recorded,
        first_day: None,
        bounds: nereus::nav::MotionBounds::SPACECRAFT,
    };
    let constant: Rotation<Body, Enu> = Rotation::from_yaw_pitch_roll(0.3, 0.1, -0.2);
    let recorded = load(&cart).unwrap().fixes;
    let synthetic: Vec<Fix> = (0..400).map(|k| fix(f64::from(k) * 0.1 + 0.013 * f64::from(k % 3))).collect();
    let cases = [
        (&recorded, AttitudeSource::Recorded),
        (&recorded, AttitudeSource::Constant(constant)),
        (&synthetic, AttitudeSource::Recorded),
        (&synthetic, AttitudeSource::CoordinatedTurn),
        (&synthetic, AttitudeSource::Level),
    ];
    for (fixes, attitude) in cases {
        let source = FileSource { attitude, ..cart.clone() };
        let (file, _) = Track::recorded(fixes, &frame, &source).unwrap();
        let live = LiveTrack::new(frame, attitude, 5.0, 1.0);
        let mut compared = 0;
        let mut from = fixes[0].time;
        for fix in fixes.iter() {
            live.push(fix, Instant::now()).unwrap();
            let Some(end) = live.end() else { continue };
            // What is new, at once: it is to stay as it is.
            while end.since(from) >= 0.0 {
                let (reported, known) = (live.report(from), file.state(from).unwrap());
                assert_eq!(
                    (reported.state, reported.flags, reported.age_s),
                    (known, 0, 0.0),
                    "{from} {attitude:?}"
                );
                assert!(reported.arrived.is_some());
                compared += 1;
                from = from.plus(0.00371);
            }
        }
        // All but the ends of the fixes, whose neighbours have not come.
        let behind =
            if matches!(attitude, AttitudeSource::Recorded | AttitudeSource::Constant(_)) { 3 } else { 6 };
        assert_eq!(live.end(), Some(fixes[fixes.len() - 1 - behind].time));
        assert!(compared > 500, "{compared}");
    }
}

/// Asks every 20 ms for what is reported up to then, as pulses would, with fixes that come `late_s` after
/// their time.
fn fly(
    live: &LiveTrack,
    late_s: f64,
    silent: std::ops::Range<f64>,
) -> Vec<(f64, nereus::motion::track::live::Reported)> {
    let mut reported = Vec::new();
    let mut next = 0;
    for tick in 0..3000 {
        let t_s = 0.02 * f64::from(tick);
        while f64::from(next) * 0.1 + late_s <= t_s {
            let epoch_s = f64::from(next) * 0.1;
            if !silent.contains(&epoch_s) {
                live.push(&fix(epoch_s), Instant::now()).unwrap();
            }
            next += 1;
        }
        if !live.is_ready() {
            continue;
        }
        live.extend(at(t_s));
        reported.push((t_s, live.report(at(t_s))));
    }
    reported
}

#[test]
fn what_was_reported_stays_and_is_smooth() {
    for (late_s, silent) in [(0.05, 0.0..0.0), (0.05, 20.0..30.0), (0.4, 20.0..23.0), (-0.5, 20.0..30.0)] {
        let live = LiveTrack::new(SceneFrame::plain(Earth::Flat), AttitudeSource::Recorded, 1.0, 0.5);
        let reported = fly(&live, late_s, silent.clone());
        assert!(reported.len() > 2800);
        let mut worst_mps2 = 0f64;
        for pair in reported.windows(2) {
            let ((a_s, a), (b_s, b)) = (pair[0], pair[1]);
            // Nothing that has been reported has changed.
            assert_eq!(live.report(at(a_s)).state, a.state, "{late_s} {a_s}");
            // A path that jumps, or goes where its velocity does not lead, needs an endless acceleration.
            let step_s = b_s - a_s;
            let predicted = a.state.position + a.state.velocity * step_s;
            worst_mps2 = worst_mps2.max((b.state.position - predicted).norm() * 2.0 / step_s.powi(2));
            worst_mps2 = worst_mps2.max((b.state.velocity - a.state.velocity).norm() / step_s);
        }
        println!("fixes {late_s} s late, silent {silent:?}: up to {worst_mps2:.1} m/s^2");
        // 10 of the flight, and some 20 for each way back, of which there are a few at a time; half a metre
        // at once would be 2500.
        assert!(worst_mps2 < 100.0, "{late_s}: {worst_mps2}");
        // Not known is 10 m/s^2 over the age of the last fix and the 0.1 s that its velocity is older; the
        // way back lags by 0.6 T times the velocity that is missed.
        let unknown_s = late_s.max(0.0) + 0.2;
        let bound = 10.0 * unknown_s * (unknown_s + 0.6 * 0.3) + 0.5;
        for (t_s, reported) in &reported {
            let in_silence =
                t_s - 0.5 - late_s.max(0.0) > silent.start && *t_s < silent.end + late_s.min(0.0);
            if in_silence {
                assert!(reported.flags & NAV_EXTRAPOLATED != 0, "{t_s}");
            }
            if in_silence && t_s - silent.start > 0.7 {
                assert!(reported.flags & NAV_STALE != 0, "{t_s}");
                let age_s = t_s - (silent.start - 0.1);
                assert!((reported.age_s - age_s).abs() < 0.11, "{t_s} {}", reported.age_s);
            }
            if late_s < 0.0 && (*t_s > 3.0 && *t_s < silent.start - 0.4 || *t_s > silent.end + 25.0) {
                assert_eq!((reported.flags, reported.age_s), (0, 0.0), "{t_s}");
            }
            if *t_s > 3.0 && *t_s < silent.start - 0.1 {
                assert!(away(&live, *t_s) < bound, "{t_s} {} {bound}", away(&live, *t_s));
            }
        }
        // 10 s of silence on a circle: 460 m away, and back within sqrt(5.8 460 / 20) = 12 s.
        let (last_s, last) = reported[reported.len() - 1];
        if silent.end > silent.start {
            let stray = away(&live, silent.end - 0.2);
            assert!(stray > if silent.end - silent.start > 5.0 { 100.0 } else { 5.0 }, "{stray}");
        }
        assert!(away(&live, last_s) < bound, "{late_s}: {}", away(&live, last_s));
        assert_eq!(last.flags & NAV_STALE, 0);
    }
}

#[test]
fn gaps_are_not_interpolated_in_silence() {
    let live = LiveTrack::new(SceneFrame::plain(Earth::Flat), AttitudeSource::Level, 1.0, 0.5);
    for k in (0..30).chain(60..100) {
        live.push(&fix(0.1 * f64::from(k)), Instant::now()).unwrap();
    }
    let flags = |t_s: f64| live.report(at(t_s)).flags;
    assert_eq!((flags(1.0), flags(7.0)), (0, 0));
    assert_eq!(flags(4.5), NAV_EXTRAPOLATED);
    assert!((live.report(at(4.5)).age_s - 1.6).abs() < 1e-9);
}

#[test]
fn unusable_fixes_are_left() {
    let live = LiveTrack::new(SceneFrame::plain(Earth::Flat), AttitudeSource::Recorded, 1.0, 0.5);
    let now = Instant::now();
    let reported = live.report(at(0.0));
    assert_eq!(reported.flags, NAV_EXTRAPOLATED | NAV_STALE);
    let mut bare = fix(0.0);
    bare.yaw_pitch_roll_rad = None;
    assert_eq!(live.push(&bare, now), Err(Unusable::NoAttitude));
    live.push(&fix(1.0), now).unwrap();
    assert_eq!(live.push(&fix(1.0), now), Err(Unusable::NotLater));
    assert_eq!(live.push(&fix(0.5), now), Err(Unusable::NotLater));
    let earth = Fix::at(at(2.0), Place::Geodetic(Geodetic::from_deg(1.0, 2.0, 3.0)));
    assert_eq!(live.push(&earth, now), Err(Unusable::NoPosition));
    // One fix is no motion: nothing is reported, and asking for more changes nothing.
    live.extend(at(5.0));
    assert!(!live.is_ready());
}
