//! Live navigation in scenarios.

use std::net::SocketAddr;

use super::*;
use crate::nav::FileFormat;
use crate::nav::live::{LiveSource, Origin};

const CART: &str = include_str!("../../../configs/cart.toml");

type Variant = (&'static str, Vec<(&'static str, &'static str)>);

/// Scenarios that have every key.
pub(super) fn variants() -> Vec<Variant> {
    vec![(
        CART,
        vec![(
            "platform.1.track",
            "{ kind = 'live', source = '/dev/ttyS0', nominal = { kind = 'fixed', position_m = [0, 0, 0] } }",
        )],
    )]
}

fn live(track: &str) -> LiveSource {
    let run = parse(CART, &in_configs(), &settings(&[("platform.1.track", track)])).unwrap();
    let TrackSource::Live(source) = run.nav[1].truth.clone() else { panic!("{:?}", run.nav) };
    source
}

/// The faults of a scenario on the cart with overrides, without the path.
fn faults(list: &[(&str, &str)]) -> String {
    let error = parse(CART, &in_configs(), &settings(list)).unwrap_err();
    let text: String = error.faults().iter().map(|fault| format!("{fault}\n")).collect();
    text.replace(env!("CARGO_MANIFEST_DIR"), "..")
}

#[test]
fn origins_as_meant() {
    let of = |text: &str| live(&format!("{{ kind = 'live', source = '{text}' }}")).origin;
    let local = |port| SocketAddr::from(([127, 0, 0, 1], port));
    assert_eq!(of("/dev/ttyUSB0"), Origin::Serial { path: "/dev/ttyUSB0".into(), baud: 115_200 });
    assert_eq!(of("tcp://127.0.0.1:5000"), Origin::TcpConnect(local(5000)));
    assert_eq!(of("tcp-listen://127.0.0.1:5001"), Origin::TcpListen(local(5001)));
    assert_eq!(of("udp://127.0.0.1:5002"), Origin::Udp(local(5002)));
    assert_eq!(of("udp://[::1]:5002"), Origin::Udp("[::1]:5002".parse().unwrap()));
    // Beside the scenario, not where the user is.
    let file = in_configs().with_file_name("tracks/cart.inspvax");
    assert_eq!(of("file:tracks/cart.inspvax"), Origin::File(file));
}

#[test]
fn defaults_and_keys() {
    let plain = live("{ kind = 'live', source = 'udp://127.0.0.1:5002' }");
    assert_eq!((plain.datum, plain.undulation_m), (VerticalDatum::MeanSeaLevel, 288.2));
    assert_eq!(plain.attitude, AttitudeSource::Automatic);
    assert_eq!(plain.bounds, crate::nav::MotionBounds::AIRCRAFT);
    assert_eq!((plain.max_gap_s, plain.max_extrapolation_s, plain.timeout_s), (5.0, 1.0, 30.0));
    assert_eq!(plain.nominal, None);
    let full = live(
        "{ kind = 'live', source = '/dev/ttyS0', baud = 4800, datum = 'barometric', barometric_offset_m = 12, \
         attitude = 'level', max_gap_s = 2, max_extrapolation_s = 0.5, timeout_s = 0, \
         nominal = { kind = 'inspvax', path = 'tracks/cart.inspvax' } }",
    );
    assert_eq!(full.origin, Origin::Serial { path: "/dev/ttyS0".into(), baud: 4800 });
    assert_eq!(full.datum, VerticalDatum::Barometric { offset_m: 12.0 });
    assert_eq!(full.attitude, AttitudeSource::Level);
    let ship = live(
        "{ kind = 'live', source = '/dev/ttyS0', vehicle = 'ship', max_speed_mps = 20, reset_fixes = 9 }",
    );
    let bounds =
        crate::nav::MotionBounds { max_speed_mps: 20.0, reset_fixes: 9, ..crate::nav::MotionBounds::SHIP };
    assert_eq!(ship.bounds, bounds);
    assert_eq!((full.max_gap_s, full.max_extrapolation_s, full.timeout_s), (2.0, 0.5, 0.0));
    let Some(TrackSource::File(file)) = full.nominal.as_deref() else { panic!("{:?}", full.nominal) };
    assert_eq!(file.format, FileFormat::Inspvax);
}

#[test]
fn a_start_that_navigation_decides() {
    let track = ("platform.1.track", "{ kind = 'live', source = 'udp://127.0.0.1:5002' }");
    let run = parse(CART, &in_configs(), &settings(&[track])).unwrap();
    assert!(!run.start_live && run.scene.start.to_string() == "2014-11-24T20:30:21.000000Z");
    let run = parse(CART, &in_configs(), &settings(&[track, ("scene.start_utc", "live")])).unwrap();
    assert!(run.start_live);
    // The record of the run reads as the same.
    assert!(parse(&run.text, &in_configs(), &[]).unwrap().start_live);
    insta::assert_snapshot!(faults(&[("scene.start_utc", "live")]), @r#"scene.start_utc: "live" is not allowed beside a recorded track; allowed: a UTC time within the recording"#);
    let still = ("platform.1.track", "{ kind = 'fixed', position_m = [0, 0, 9] }");
    insta::assert_snapshot!(faults(&[still, ("scene.start_utc", "live")]), @r#"scene.start_utc: "live" is not allowed without live navigation; allowed: "now", or a UTC time"#);
    insta::assert_snapshot!(faults(&[track, ("scene.start_utc", "now")]), @r#"scene.start_utc: "now" is not allowed with live navigation; allowed: "live", or a UTC time"#);
    insta::assert_snapshot!(faults(&[("scene.start_utc", "now")]), @r#"scene.start_utc: "now" is not allowed beside a recorded track; allowed: a UTC time within the recording"#);
    insta::assert_snapshot!(faults(&[track, ("scene.start_utc", "soon")]), @r#"scene.start_utc: "soon" is not allowed; allowed: a UTC time from 1970 to 2200 such as "2018-05-30T20:15:00.5Z", or "now" without recorded tracks, logs and live navigation, or "live" with live navigation and no recording"#);
    let mast = ("platform.0.track", "{ kind = 'inspvax', path = 'tracks/cart.inspvax' }");
    insta::assert_snapshot!(faults(&[track, mast, ("scene.start_utc", "live")]), @r#"scene.start_utc: "live" is not allowed beside a recorded track; allowed: a UTC time within the recording"#);
    let without = CART.replace("start_utc", "# start_utc");
    let error = parse(&without, &in_configs(), &settings(&[track])).unwrap_err();
    insta::assert_snapshot!(error.faults()[0], @r#"scene.start_utc: is missing; required with live navigation: "live", or the UTC time at which pulse 0 leaves"#);
}

#[test]
fn a_start_that_the_clock_decides() {
    let before = TimeTag::now();
    let track = ("platform.1.track", "{ kind = 'fixed', position_m = [0, 0, 9] }");
    let run = parse(CART, &in_configs(), &settings(&[track, ("scene.start_utc", "now")])).unwrap();
    // A whole second, 3 to 4 s after it was read.
    let ahead_s = run.scene.start.since(before);
    assert!(run.start_now && !run.start_live && run.scene.start.fraction_s() == 0.0);
    assert!(ahead_s >= 3.0 && run.scene.start.since(TimeTag::now()) <= 4.0, "{ahead_s}");
    // The record of the run has the time.
    let again = parse(&run.text, &in_configs(), &[]).unwrap();
    assert!(!again.start_now && again.scene == run.scene, "{}", run.text);
    let later = run.starting_later(60.0).unwrap();
    assert!(later.start_now && later.scene.start.since(run.scene.start) >= 56.0);
    assert_eq!(parse(&later.text, &in_configs(), &[]).unwrap().scene.start, later.scene.start);
}

#[test]
fn faults_of_live_navigation_are_reported_together() {
    let list = [
        (
            "platform.1.track",
            "{ kind = 'live', source = 'udp://here', baud = 1, max_gap_s = 0, timeout_s = -1, path = 'x', \
             nominal = { kind = 'live', source = '/dev/null' } }",
        ),
        ("platform.1.errors", "{ recorded = 'reported' }"),
        ("platform.1.turbulence", "{ level = 'light' }"),
        ("platform.0.reported", "{ kind = 'live', source = 'file:no/such.nmea', datum = 'geoid' }"),
        ("stream.policy", "slip"),
        ("stream.pace", "fast"),
    ];
    insta::assert_snapshot!(faults(&list), @r#"
    platform.0.reported.kind: "live" is not allowed as a report; allowed: a track that is known beforehand
    platform.0.reported.source: there is no file ../configs/no/such.nmea; allowed: a file that exists (relative to the scenario file)
    platform.0.reported.datum: "geoid" is not allowed; allowed: "ellipsoid", "msl", "barometric"
    platform.1.track.baud: 1 is out of range; allowed: a whole number from 50 to 4000000
    platform.1.track.source: "udp://here" is not allowed; allowed: the path of a serial port, tcp://ADDRESS:PORT, tcp-listen://ADDRESS:PORT or udp://ADDRESS:PORT such as udp://127.0.0.1:5001, or file:PATH (relative to the scenario file)
    platform.1.track.max_gap_s: 0 is out of range; allowed: a number above 0, up to 86400 s
    platform.1.track.timeout_s: -1 is out of range; allowed: a number from 0 to 86400 s
    platform.1.track.nominal.kind: "live" is not allowed as a nominal trajectory; allowed: a track that is known beforehand
    platform.1.track.path: not allowed here (kind = "live")
    platform.1.errors.recorded: "reported" is not allowed beside live navigation; allowed: "truth"
    platform.1.turbulence: not allowed here (the track is live: its air is real)
    stream.pace: "fast" is not allowed beside live navigation; allowed: "realtime"
    stream.policy: "slip" is not allowed beside live navigation; allowed: "stop", "drop", "relax"
    "#);
    // In a scene that is not georeferenced.
    let plain = faults_of(&[("platform.1.track", "{ kind = 'live', source = '' }")]);
    insta::assert_snapshot!(plain, @r#"
    scene.start_utc: is missing; required with live navigation: "live", or the UTC time at which pulse 0 leaves
    platform.1.track.source: live navigation needs scene.origin_lat_deg, origin_lon_deg and origin_h_m
    platform.1.track.source: "" is not allowed; allowed: the path of a serial port, tcp://ADDRESS:PORT, tcp-listen://ADDRESS:PORT or udp://ADDRESS:PORT such as udp://127.0.0.1:5001, or file:PATH (relative to the scenario file)
    "#);
    // A track of another kind has none of its keys.
    insta::assert_snapshot!(faults(&[("platform.0.track.source", "/dev/ttyS0"), ("platform.0.track.baud", "9600")]), @r#"
    platform.0.track.source: not allowed here (kind = "fixed")
    platform.0.track.baud: not allowed here (kind = "fixed")
    "#);
}

#[test]
fn keys_of_earlier_versions_lead_to_their_names() {
    let track = "{ kind = 'live', source = 'udp://127.0.0.1:5002', patience_s = 3, \
                 rehearsal = { kind = 'fixed', position_m = [0, 0, 0] } }";
    insta::assert_snapshot!(faults(&[("platform.1.track", track), ("fidelity.faint_db", "-40")]), @r#"
    platform.1.track.patience_s: unknown key; did you mean timeout_s?
    platform.1.track.rehearsal: unknown key; did you mean nominal?
    fidelity.faint_db: unknown key; did you mean sidelobe_db?
    "#);
}
