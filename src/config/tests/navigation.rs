//! Recorded logs of receivers, and navigation outputs.

use super::*;
use crate::nav::FileFormat;
use crate::sinks::Kind;
use crate::sinks::nav::Messages;
use crate::sinks::port::Device;

const CART: &str = include_str!("../../../configs/cart.toml");

#[test]
fn navigation_outputs_as_meant() {
    let run = parse(CART, &in_configs(), &[]).unwrap();
    let Kind::Nav(nav) = &run.sinks[1].kind else { panic!("{:?}", run.sinks) };
    assert_eq!(nav.device, Device::File("cart.nmea".into()));
    assert_eq!((nav.platform, nav.rate_hz, nav.latency_s, nav.force), (1, 20.0, 0.0, false));
    assert_eq!(nav.messages, Messages::Nmea(vec!["GGA", "RMC", "VTG", "HDT", "ZDA", "PASHR"]));
    let sink =
        "[{ kind = 'nav', device = '/dev/ttyS1', baud = 9600, platform = 'mast', format = 'inspvaxb' }]";
    let run = parse(CART, &in_configs(), &settings(&[("sink", sink)])).unwrap();
    let Kind::Nav(nav) = &run.sinks[0].kind else { panic!("{:?}", run.sinks) };
    assert_eq!(nav.device, Device::Serial { path: "/dev/ttyS1".into(), baud: 9600 });
    assert_eq!((nav.platform, &nav.messages), (0, &Messages::InspvaxBinary));
}

#[test]
fn tracks_of_receivers_as_meant() {
    let of = |track: &str| {
        let run = parse(CART, &in_configs(), &settings(&[("platform.1.track", track)])).unwrap();
        let TrackSource::File(source) = run.nav[1].truth.clone() else { panic!("{:?}", run.nav) };
        (source.format, source.datum)
    };
    assert_eq!(
        of("{ kind = 'inspvax', path = 'tracks/cart.inspvax' }"),
        (FileFormat::Inspvax, VerticalDatum::Ellipsoid)
    );
    assert_eq!(
        of("{ kind = 'sbet', path = 'tracks/cart.inspvax', gps_week = 1820 }"),
        (FileFormat::Sbet { gps_week: 1820 }, VerticalDatum::Ellipsoid)
    );
}

#[test]
fn faults_of_navigation() {
    let faults = |list: &[(&str, &str)]| -> String {
        let error = parse(CART, &in_configs(), &settings(list)).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect()
    };
    insta::assert_snapshot!(faults(&[("sink", "[{ kind = 'nav', device = 'udp://x', platform = 'ship', sentences = ['GGA', 'XYZ'], rate_hz = 0 }]")]), @r#"
    sink.0.device: 'udp://x' is no device; allowed: the path of a port, file:PATH, tcp://ADDRESS:PORT or udp://ADDRESS:PORT such as tcp://127.0.0.1:2947
    sink.0.platform: there is no platform "ship"; allowed: mast, cart
    sink.0.sentences: entry 1, "XYZ", is not allowed; allowed: a list of 1 to 7 texts, each GGA, RMC, VTG, HDT, ZDA, GST or PASHR
    sink.0.rate_hz: 0 is out of range; allowed: a number above 0, up to 1000 Hz
    "#);
    insta::assert_snapshot!(faults(&[("sink", "[{ kind = 'nav', path = 'x', format = 'nmea2000' }]")]), @r#"
    sink.0.device: is missing; required: a path (relative to the working directory)
    sink.0.platform: is missing; required: a name of 1 to 64 letters, digits, '_', '-', '.', not starting with '.'
    sink.0.format: "nmea2000" is not allowed; allowed: "nmea", "inspvaxa", "inspvaxb"
    sink.0.path: not allowed here (kind = "nav")
    "#);
    insta::assert_snapshot!(faults(&[("platform.1.track", "{ kind = 'sbet', path = 'tracks/cart.inspvax' }")]), @"platform.1.track.gps_week: is missing; required: a whole number from 0 to 8191");
    insta::assert_snapshot!(faults(&[("platform.1.track", "{ kind = 'inspvax', path = 'tracks/cart.inspvax', datum = 'msl', gps_week = 1 }")]), @r#"
    platform.1.track.datum: not allowed here (kind = "inspvax")
    platform.1.track.gps_week: not allowed here (kind = "inspvax")
    "#);
    // In a scene that is not georeferenced; before, the track was refused only when all else was right, and
    // its datum after that.
    insta::assert_snapshot!(faults_of(&[
        ("platform.0.track", "{ kind = 'csv', path = 'tracks/strait_of_dover.csv' }"),
        ("radar.carrier_hz", "-1"),
    ]), @r#"
    scene.start_utc: is missing; required with a recorded track: a UTC time within the recording
    platform.0.track.path: holds latitudes and longitudes, which need scene.origin_lat_deg, origin_lon_deg and origin_h_m; allowed without them: a CSV file of x_m, y_m, z_m
    platform.0.track.datum: is missing; required: "ellipsoid", "msl", "barometric"
    radar.carrier_hz: -1 is out of range; allowed: a number from 1e6 to 1e12 Hz
    "#);
    insta::assert_snapshot!(faults_of(&[("sink", "[{ kind = 'nav', device = 'file:x', platform = 'coast' }]")]), @"sink.0.device: navigation out needs scene.origin_lat_deg, origin_lon_deg and origin_h_m");
}
