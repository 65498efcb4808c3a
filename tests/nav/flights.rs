//! Recorded flights: how far the fixes are from a motion, and what smoothing makes of them.

use nereus::frames::{Earth, Geodetic, SceneFrame};
use nereus::motion::{FitReport, SourceReport, Track};
use nereus::nav::{FileSource, Fix, TrackSource, load};
use nereus::time::TimeTag;

use crate::sources;

fn frame() -> SceneFrame {
    SceneFrame::at(Geodetic::from_deg(52.988, 4.520, 42.0), Earth::Flat)
}

fn build(source: &FileSource) -> (Track, SourceReport) {
    let (track, report) =
        Track::from_source(&TrackSource::File(source.clone()), &frame(), TimeTag::default()).unwrap();
    let report = report.unwrap();
    println!("{report}");
    (track, report)
}

/// The largest acceleration that the track itself answers with, every 50 ms.
fn sampled_acceleration(track: &Track) -> f64 {
    let (first, last) = track.span().unwrap();
    let count = (last.since(first) / 0.05) as u64;
    (0..count)
        .map(|i| track.state(first.plus(i as f64 * 0.05)).unwrap().acceleration.norm())
        .fold(0.0, f64::max)
}

fn second_differences(fixes: &[Fix]) -> f64 {
    let p: Vec<_> = fixes
        .iter()
        .map(|fix| match fix.place {
            nereus::nav::Place::Geodetic(g) => frame().from_geodetic(g).unwrap(),
            nereus::nav::Place::Local(p) => p,
        })
        .collect();
    (1..fixes.len() - 1)
        .map(|i| {
            let (a, b) = (fixes[i].time.since(fixes[i - 1].time), fixes[i + 1].time.since(fixes[i].time));
            let turn = (p[i + 1] - p[i]) * (1.0 / b) - (p[i] - p[i - 1]) * (1.0 / a);
            turn.norm() * 2.0 / (a + b)
        })
        .fold(0.0, f64::max)
}

#[test]
fn every_recorded_track_can_be_flown() {
    // Residuals of the README of configs/tracks, rounded up: a change of the fit shows here.
    let wanted = [
        ("north_sea_texel", 2.9, 290.0, [40.0, 130.0, 0.2, 0.6]),
        ("north_sea_turn", 6.0, 690.0, [41.0, 270.0, 1.8, 6.0]),
        ("strait_of_dover", 2.9, 8760.0, [49.5, 215.0, 2.5, 8.1]),
    ];
    for (name, bound, span_s, [h_rms, h_max, v_rms, v_max]) in wanted {
        let (track, report) = build(&sources::adsb(&format!("configs/tracks/{name}.csv"), bound));
        let (first, last) = track.span().unwrap();
        assert_eq!(last.since(first), span_s, "{name}");
        let sampled = sampled_acceleration(&track);
        println!("{name}: sampled acceleration {sampled:.3} m/s^2");
        let fit: FitReport = report.fit;
        assert!(sampled <= fit.max_acceleration_mps2 && fit.max_acceleration_mps2 <= bound, "{name}");
        assert!(fit.horizontal_rms_m < h_rms && fit.horizontal_max_m < h_max, "{name}");
        assert!(fit.vertical_rms_m < v_rms && fit.vertical_max_m < v_max, "{name}");
    }
}

#[test]
fn altitude_steps_of_25_ft_are_tamed() {
    let source = sources::adsb("tests/data/nav/ijsselmeer_climb.csv", 2.9);
    let raw = second_differences(&load(&source).unwrap().fixes);
    let (track, report) = build(&source);
    println!("raw second differences reach {raw:.0} m/s^2");
    assert!(raw > 100.0, "{raw}");
    assert!(sampled_acceleration(&track) <= 2.9);
    // A step of 25 ft has an error of 25 ft/sqrt(12) = 2.2 m rms when the time of the step is not used.
    assert!(report.fit.vertical_rms_m < 2.2, "{}", report.fit);
    // The vertical speed is that of a climb, not of steps: below 15 m/s everywhere.
    let (first, last) = track.span().unwrap();
    for i in 0..(last.since(first) as u32) {
        let climb = track.state(first.plus(f64::from(i))).unwrap().velocity.to_array()[2];
        assert!((-3.0..15.0).contains(&climb), "{i}: {climb}");
    }
}

#[test]
fn a_bound_below_what_was_flown_is_refused() {
    let source = sources::adsb("configs/tracks/north_sea_turn.csv", 2.9);
    let error = Track::from_source(&TrackSource::File(source), &frame(), TimeTag::default()).unwrap_err();
    println!("{error}");
    assert!(error.to_string().contains("misses the fixes"), "{error}");
}

#[test]
fn the_path_does_not_depend_on_the_origin_of_the_scene() {
    let source = sources::adsb("configs/tracks/north_sea_texel.csv", 2.9);
    let recording = load(&source).unwrap();
    let far = SceneFrame::at(Geodetic::from_deg(40.0, -20.0, 50.0), Earth::Flat);
    let (a, _) = Track::recorded(&recording.fixes, &frame(), &source).unwrap();
    let (b, _) = Track::recorded(&recording.fixes, &far, &source).unwrap();
    let (first, last) = a.span().unwrap();
    let mut worst = 0.0f64;
    for i in 0..(last.since(first) as u32) {
        let t = first.plus(f64::from(i) + 0.37);
        let pa = frame().to_ecef(a.state(t).unwrap().position).unwrap();
        let pb = far.to_ecef(b.state(t).unwrap().position).unwrap();
        worst = worst.max((pa - pb).norm());
    }
    println!("worst {worst:.2e} m");
    // Coordinates of 6.4e6 m round to 1e-9 m; the search for the density stops where its cost, rounded to 1e-13, is
    // flat: 1 % of the density moves the path by less than a millimetre per metre of residual.
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn turbulence_of_the_clock_does_not_bank_the_wings() {
    let (track, _) = build(&sources::adsb("configs/tracks/north_sea_texel.csv", 2.9));
    let (first, last) = track.span().unwrap();
    for i in 0..(last.since(first) as u32) {
        let state = track.state(first.plus(f64::from(i))).unwrap();
        let [yaw, pitch, roll] = state.attitude.to_yaw_pitch_roll().map(f64::to_degrees);
        // Straight and level northwards.
        assert!(
            !(5.0..355.0).contains(&yaw) && pitch.abs() < 1.0 && roll.abs() < 1.0,
            "{yaw} {pitch} {roll}"
        );
    }
}

#[test]
fn the_turn_banks_like_an_airliner() {
    let (track, _) = build(&sources::adsb("configs/tracks/north_sea_turn.csv", 6.0));
    let (first, last) = track.span().unwrap();
    let rolls: Vec<f64> = (0..(last.since(first) as u32))
        .map(|i| track.state(first.plus(f64::from(i))).unwrap().attitude.to_yaw_pitch_roll()[2].to_degrees())
        .collect();
    let (low, high) = rolls.iter().fold((0.0f64, 0.0f64), |(low, high), r| (low.min(*r), high.max(*r)));
    println!("roll {low:.1} to {high:.1} deg");
    // Northwards, then back by the West: a turn to the left, usual bank 25 deg, 30 deg at most in service.
    assert!((-32.0..-20.0).contains(&low), "{low}");
}
