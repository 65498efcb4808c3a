//! Recorded flights: how far the fixes are from a motion, and what smoothing makes of them.

use nereus::frames::{Earth, Geodetic, SceneFrame};
use nereus::motion::{FitReport, SourceReport, Track};
use nereus::nav::TrackSource;
use nereus::nav::{FileSource, Fix, load};
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
fn every_recorded_track_is_a_motion() {
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
    // The aircraft itself reports -64 to 4031 ft/min on the way (vertical_rate): -0.3 to 20.5 m/s. A step of
    // 25 ft between rows a second apart is 7.6 m/s more or less; tamed means less than half of that.
    let (first, last) = track.span().unwrap();
    for i in 0..(last.since(first) as u32) {
        let climb = track.state(first.plus(f64::from(i))).unwrap().velocity.to_array()[2];
        assert!((-0.3 - 3.8..20.5 + 3.8).contains(&climb), "{i}: {climb}");
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
    // Coordinates of 6.4e6 m round to 1e-9 m; the search for the density stops where its cost, rounded to
    // 1e-13, is flat: 1 % of the density moves the path by less than a millimetre per metre of residual.
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

/// A ship at 8 m/s on a gentle curve, as GGA sentences of 0.001 minutes (1.9 m) once a second.
fn quantised_ship() -> (Vec<u8>, impl Fn(f64) -> [f64; 2]) {
    let truth = |t: f64| {
        let (radius_m, rate) = (800.0, 0.01);
        [radius_m * (rate * t).sin(), radius_m * (1.0 - (rate * t).cos())]
    };
    let origin = frame();
    let mut log = String::new();
    for second in 0..300 {
        let [x, y] = truth(f64::from(second));
        let place = origin.to_geodetic(nereus::frames::Point::new(x, y, 0.0)).unwrap();
        let (lat, lon) = (place.lat_rad.to_degrees(), place.lon_rad.to_degrees());
        let minutes = |degrees: f64| (degrees.fract() * 60_000.0).round() / 1000.0;
        let body = format!(
            "GPGGA,12{:02}{:02},{:02.0}{:06.3},N,{:03.0}{:06.3},E,1,10,0.9,10.0,M,42.0,M,,",
            second / 60,
            second % 60,
            lat.trunc(),
            minutes(lat),
            lon.trunc(),
            minutes(lon)
        );
        log += &sources::sentence(&body);
    }
    let date = sources::sentence("GPZDA,120000,01,07,2020,00,00");
    ((date + &log).into_bytes(), truth)
}

#[test]
fn quantised_nmea_becomes_a_ship_again() {
    let (bytes, truth) = quantised_ship();
    let mut source = sources::nmea("ship.nmea");
    let fixes = nereus::nav::nmea::parse(&bytes, &source).unwrap().fixes;
    let start = fixes[0].time;
    let worst = |track: &Track| {
        (0..2990)
            .map(|i| {
                let t = f64::from(i) * 0.1;
                let [x, y, _] = track.state(start.plus(t)).unwrap().position.to_array();
                let [tx, ty] = truth(t);
                (x - tx).hypot(y - ty)
            })
            .fold(0.0, f64::max)
    };
    let (exact, report) = Track::recorded(&fixes, &frame(), &source).unwrap();
    println!("taken as exact: worst {:.2} m; {report}", worst(&exact));
    assert!(report.max_acceleration_mps2 > 2.0, "{report}");
    source.smoothing = nereus::nav::Smoothing::Rts {
        horizontal_sigma_m: 0.6,
        vertical_sigma_m: 0.6,
        max_acceleration_mps2: 0.5,
    };
    let (smooth, report) = Track::recorded(&fixes, &frame(), &source).unwrap();
    println!("smoothed: worst {:.2} m; {report}", worst(&smooth));
    // Flown: 8 m/s, 0.08 m/s^2. Half a step is 0.93 m in latitude and 0.56 m in longitude: 1.08 m at the
    // corner of the cell, which no fix exceeds, and which averaging only makes smaller.
    assert!(worst(&smooth) < 1.08);
    assert!(sampled_acceleration(&smooth) <= 0.5);
    assert!(report.speed_mps[0] > 7.0 && report.speed_mps[1] < 9.0, "{report}");
}

#[test]
fn a_real_boat_log_is_smoothed() {
    let bytes = std::fs::read(sources::repository("tests/data/nav/plaka_700.nmea")).unwrap();
    // The log has no date; one is put in front.
    let dated = [sources::sentence("GPZDA,095558,01,07,2014,00,00").as_bytes(), &bytes].concat();
    let mut source = sources::nmea("plaka.nmea");
    source.smoothing = nereus::nav::Smoothing::Rts {
        horizontal_sigma_m: 1.0,
        vertical_sigma_m: 1.0,
        max_acceleration_mps2: 0.5,
    };
    let recording = nereus::nav::nmea::parse(&dated, &source).unwrap();
    let nereus::nav::Place::Geodetic(place) = recording.fixes[0].place else { panic!("not geodetic") };
    let (track, report) =
        Track::recorded(&recording.fixes, &SceneFrame::at(place, Earth::Flat), &source).unwrap();
    println!("{}\n{report}", recording.report);
    assert!(sampled_acceleration(&track) <= 0.5);
    // Its VTG says 5.7 to 5.9 knots over the ground: 2.9 to 3.0 m/s; a position step of 1.9 m in 2 s is 0.9
    // m/s.
    assert!(report.speed_mps[0] > 2.0 && report.speed_mps[1] < 4.0, "{report}");
    assert!(report.horizontal_rms_m < 1.9, "{report}");
}
