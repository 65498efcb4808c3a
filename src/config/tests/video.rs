//! Radar video.

use std::net::Ipv4Addr;

use super::*;
use crate::sinks::Kind;
use crate::sinks::asterix::{Bits, CellValue, Detection, Settings, Source};

const SCAN: &str = include_str!("../../../configs/scan.toml");

/// Of every key.
pub(super) fn variants() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    [
        "{ kind = 'asterix', address = '239.1.2.3:8600', interface = '10.0.0.1' }",
        "{ kind = 'targets', device = 'file:x' }",
    ]
    .map(|sink| (SCAN, vec![("sink.0", sink)]))
    .into()
}

fn of(sink: &str) -> Settings {
    let run = parse(SCAN, &in_configs(), &settings(&[("sink.0", sink)])).unwrap();
    let Kind::Asterix(settings) = &run.sinks[0].kind else { panic!("{:?}", run.sinks) };
    settings.clone()
}

fn faults(list: &[(&str, &str)]) -> String {
    let error = parse(SCAN, &in_configs(), &settings(list)).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn video_as_meant() {
    let usual = Settings { source: Source { sac: 0, sic: 1 }, ..Settings::default() };
    assert_eq!(of("{ kind = 'asterix' }"), usual);
    let all =
        of("{ kind = 'asterix', address = '239.1.2.3:99', interface = '10.0.0.1', ttl_hops = 4, sac = 7, \
                 sic = 42, channel = 'HH', cell_m = 12, cell = 'mean', radial_pulses = 8, bits = 16, \
                 detection = 'linear', full_dbw = -90, mtu_bytes = 9000 }");
    let wanted = Settings {
        address: "239.1.2.3:99".to_owned(),
        interface: Ipv4Addr::new(10, 0, 0, 1),
        ttl: 4,
        mtu_bytes: 9000,
        source: Source { sac: 7, sic: 42 },
        channel: Some("HH".to_owned()),
        cell_m: Some(12.0),
        cell: CellValue::Mean,
        radial_pulses: 8,
        bits: Bits::Sixteen,
        detection: Detection::Linear,
        full_dbw: Some(-90.0),
    };
    assert_eq!(all, wanted);
    let narrow = of("{ kind = 'asterix', dynamic_db = 60 }");
    assert_eq!(narrow.detection, Detection::Logarithmic { dynamic_db: 60.0 });
}

#[test]
fn faults_of_video_are_reported_together() {
    insta::assert_snapshot!(faults(&[("sink.0", "{ kind = 'asterix', address = '224.0.0.1:8600', interface = '239.0.0.1', ttl_hops = 0, sac = 256, sic = -1, channel = 'VV', cell_m = 1, cell = 'first', radial_pulses = 0, bits = 12, detection = 'square', full_dbw = 1e3, dynamic_db = 0, mtu_bytes = 70000, path = 'x' }")]), @r#"
    sink.0.address: "224.0.0.1:8600" is not allowed; allowed: a group from 224.0.1.0 to 239.255.255.255: those below are of routers
    sink.0.interface: "239.0.0.1" is not allowed; allowed: the IPv4 address of an interface of this machine, such as "192.168.1.2"
    sink.0.ttl_hops: 0 is out of range; allowed: a whole number from 1 to 255
    sink.0.mtu_bytes: 70000 is out of range; allowed: a whole number from 576 to 65535
    sink.0.sac: 256 is out of range; allowed: a whole number from 0 to 255
    sink.0.sic: -1 is out of range; allowed: a whole number from 0 to 255
    sink.0.cell: "first" is not allowed; allowed: "peak", "mean"
    sink.0.radial_pulses: 0 is out of range; allowed: a whole number from 1 to 1024
    sink.0.bits: 12 is out of range; allowed: 8 or 16
    sink.0.detection: "square" is not allowed; allowed: "log", "linear"
    sink.0.full_dbw: 1000.0 is out of range; allowed: a number from -300 to 100 dBW
    sink.0.dynamic_db: 0 is out of range; allowed: a number from 1 to 300 dB
    sink.0.channel: there is no channel "VV"; allowed: HH
    sink.0.cell_m: 1 is out of range; allowed: from 2.998 m (half a sample) to 2392.344 m (the receive window)
    sink.0.path: not allowed here (kind = "asterix")
    "#);
    insta::assert_snapshot!(faults(&[("sink.0", "{ kind = 'asterix', interface = '10.0.0.1', ttl_hops = 2, cell_m = 9000, detection = 'linear', dynamic_db = 60, bits = '8' }")]), @r#"
    sink.0.interface: not allowed here (address is that of a machine, not of a group)
    sink.0.ttl_hops: not allowed here (address is that of a machine, not of a group)
    sink.0.bits: "8" is not allowed; allowed: 8 or 16
    sink.0.dynamic_db: not allowed here (detection = "linear")
    sink.0.cell_m: 9000 is out of range; allowed: from 2.998 m (half a sample) to 2392.344 m (the receive window)
    "#);
    insta::assert_snapshot!(faults(&[("sink", "[{ kind = 'asterix', address = '[ff02::1]:8600' }, { kind = 'asterix', address = '255.255.255.255:8600' }]")]), @r#"
    sink.0.address: "[ff02::1]:8600" is not allowed; allowed: a group of IPv4, from 224.0.1.0 to 239.255.255.255
    sink.1.address: "255.255.255.255:8600" is not allowed; allowed: the address of a machine, or a group from 224.0.1.0 to 239.255.255.255
    "#);
}

#[test]
fn radars_without_video() {
    let asterix = ("sink.0", "{ kind = 'asterix' }");
    insta::assert_snapshot!(faults(&[asterix, ("receiver.0.pointing", "{ kind = 'fixed' }")]), @r#"sink.0.channel: channel HH: receiver takes does not scan; allowed: channels whose receiver has pointing.kind = "scan" or "sector""#);
    insta::assert_snapshot!(faults(&[asterix, ("radar.dechirp", "{ delay_us = 3 }")]), @r#"sink.0.kind: "asterix" is not allowed beside radar.dechirp; allowed: pulses received in windows (gate = "windowed", no radar.dechirp)"#);
    insta::assert_snapshot!(faults_of(&[("sink", "[{ kind = 'asterix' }]")]), @r#"sink.0.channel: channel HH: transmitter on coast, receiver on aircraft; allowed: channels whose transmitter and receiver are on one platform"#);
}
