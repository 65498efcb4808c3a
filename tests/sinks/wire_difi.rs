//! DIFI packets (IEEE-ISTO 4900), by a parser written from the standard's tables alone, by the crate
//! `vita49` and by Wireshark's dissector.

use std::fs;
use std::path::Path;
use std::process::Command;

use nereus::pulse::{Pulse, SampleFormat, Samples};
use nereus::receive::Receiver;
use nereus::recording::header::Header;
use nereus::sinks::vita49::{Profile, Settings, open};
use vita49::prelude::*;

use crate::recording_fixture::{header, pulse, python};
use crate::wire_fixture::{kind, word};
use crate::wire_tshark::{PORT, pcap};

/// 400 samples a window: two packets of 200 at 1500 bytes.
fn difi_header() -> Header {
    let mut header = header(SampleFormat::Ci16);
    header.layout.samples = 400;
    header.pulses = 0;
    header
}

fn of_pulse(header: &Header, n: u64) -> Pulse {
    Pulse { window_start_s: 22e-6, ..pulse(header, n) }
}

/// The datagrams of so many pulses.
fn sent(header: &Header, pulses: u64) -> Vec<Vec<u8>> {
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_nonblocking(true).unwrap();
    let address = socket.local_addr().unwrap().to_string();
    let settings = Settings { address, profile: Profile::Difi, ..Settings::default() };
    let mut sink = open(&settings, header).unwrap();
    let (mut all, mut buffer) = (Vec::new(), vec![0; 1 << 16]);
    for n in 0..pulses {
        sink.write(&of_pulse(header, n)).unwrap();
        while let Ok(length) = socket.recv(&mut buffer) {
            all.push(buffer[..length].to_vec());
        }
    }
    let report = sink.close().unwrap().report;
    let bytes = all.iter().map(Vec::len).sum::<usize>() as u64;
    assert_eq!((report.pulses, report.bytes, report.wire.unwrap().lost()), (pulses, bytes, 0));
    all
}

/// A parser of the packets by the tables of the standard, which `tests/python/test_formats.py` uses, too.
const PARSER: &str = include_str!("../python/difi.py");

const READER: &str = r#"
data = open(PATH, "rb").read()
packets = []
while data:
    length, = struct.unpack("<I", data[:4])
    packets.append(parse(data[4:4 + length]))
    data = data[4 + length:]
streams = sorted({p["stream"] for p in packets})
assert streams == [0x10000000, 0x10000001], streams
assert [p["type"] for p in packets[:6]] == [5, 4, 5, 4, 1, 1]
for stream in streams:
    own = [p for p in packets if p["stream"] == stream]
    for kind in (1, 4, 5):
        of = [p for p in own if p["type"] == kind]
        assert [p["count"] for p in of] == [n % 16 for n in range(len(of))]
        assert all(a["time"] < b["time"] for a, b in zip(of, of[1:]))
    signal, context, version = ([p for p in own if p["type"] == kind] for kind in (1, 4, 5))
    assert len(context) == len(version) == 3 and [p["changed"] for p in context + version] == [1, 0, 0] * 2
    for p in context:
        assert (p["bandwidth"], p["rf"], p["rate"]) == (80e6, 10e9, 100e6)
        assert abs(p["level"] - (20 * np.log10(2**15 * 2.5e-8) + 30)) <= 1 / 256
    assert {p["samples"].shape for p in signal} == {(200, 2)}
    # Two packets a pulse: the second 2 us after the first.
    assert {b["time"] - a["time"] for a, b in zip(signal[::2], signal[1::2])} <= {1999999, 2000000, 2000001}
    assert len(signal) == 2 * 700
print(sum(int(p["samples"].sum()) for p in packets if p["type"] == 1))
"#;

#[test]
fn a_parser_of_the_standard_reads_every_packet() {
    let header = difi_header();
    let all = sent(&header, 700);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("difi.bin");
    let framed = all.iter().flat_map(|d| [&(d.len() as u32).to_le_bytes()[..], d].concat());
    fs::write(&path, framed.collect::<Vec<u8>>()).unwrap();
    let script = format!("{PARSER}{}", READER.replace("PATH", &format!("{:?}", path.to_str().unwrap())));
    let Some(out) = python(false, &script) else { return };
    let of = |n: u64| match of_pulse(&header, n).samples {
        Samples::Ci16(all) => all.as_flattened().iter().map(|v| i64::from(*v)).sum::<i64>(),
        Samples::Cf32(_) => 0,
    };
    assert_eq!(out.trim().parse::<i64>().unwrap(), (0..700).map(of).sum::<i64>());
}

#[test]
fn a_second_decoder_reads_the_samples() {
    let header = difi_header();
    let mut iq = Vec::new();
    for datagram in sent(&header, 3) {
        // It does not know DIFI's version context.
        if kind(&datagram) == 5 {
            continue;
        }
        let packet = Vrt::try_from(datagram.as_slice()).unwrap();
        assert_eq!(packet.class_id().map(|class| class.oui()), Some(0x6a_621e));
        if kind(&datagram) == 1 {
            assert_eq!(packet.trailer(), None);
            iq.extend_from_slice(packet.signal_payload().unwrap());
            continue;
        }
        let context = packet.payload().context().unwrap();
        assert_eq!(context.bandwidth_hz(), Some(80e6));
        assert_eq!((context.rf_ref_freq_hz(), context.sample_rate_sps()), (Some(10e9), Some(100e6)));
    }
    let codes = |n| match of_pulse(&header, n).samples {
        Samples::Ci16(all) => all.as_flattened().iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<_>>(),
        Samples::Cf32(_) => Vec::new(),
    };
    assert!(iq == (0..3).flat_map(codes).collect::<Vec<_>>());
}

#[test]
fn tshark_reads_the_packets() {
    if !Command::new("tshark").arg("--version").output().is_ok_and(|o| o.status.success()) {
        println!("skipped: tshark is not installed (Debian: apt-get install tshark)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let all = sent(&difi_header(), 4);
    let capture = folder.path().join("difi.pcap");
    pcap(&capture, &all);
    let tshark = |path: &Path, arguments: &[&str]| {
        let mut command = Command::new("tshark");
        command.arg("-r").arg(path).args(["-d", &format!("udp.port=={PORT},vrt")]).args(arguments);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(tshark(&capture, &["-Y", "_ws.malformed"]), "");
    let oui = tshark(&capture, &["-Y", "vrt", "-T", "fields", "-e", "vrt.oui"]);
    assert_eq!(oui.lines().count(), all.len());
    assert!(oui.lines().all(|line| line.to_lowercase().contains("6a")), "{oui}");
}

#[test]
fn what_difi_has_no_place_for_is_refused() {
    let opened = |header: &Header, mtu_bytes: usize| {
        let settings = Settings { mtu_bytes, profile: Profile::Difi, ..Settings::default() };
        open(&settings, header).map(|_| ()).map_err(|error| error.to_string())
    };
    let header = difi_header();
    assert_eq!(opened(&header, 1500), Ok(()));
    let float = Header {
        adc: None,
        layout: nereus::pulse::Layout { format: SampleFormat::Cf32, ..header.layout },
        ..header.clone()
    };
    assert_eq!(
        opened(&float, 1500).unwrap_err(),
        "profile = \"difi\": samples are floating point; allowed: codes of an ADC: add [radar.adc], or profile = \"nereus\" \
         (docs/wire.md)"
    );
    assert!(opened(&header, 9001).unwrap_err().contains("mtu_bytes = 9001; allowed: 576 to 9000 bytes"));
    let mut odd = header.clone();
    odd.layout.samples = 401;
    let refused = opened(&odd, 1500).unwrap_err();
    assert!(
        refused.contains("samples = 401 cannot be sent in equal packets of 25 to 361 samples"),
        "{refused}"
    );
    assert!(refused.contains("such as samples = 400"), "{refused}");
    // The ordinary receiver takes none of it for a run.
    let mut receiver = Receiver::new();
    for datagram in sent(&header, 3) {
        receiver.take(&datagram, std::time::Instant::now(), &mut |pulse| Some(pulse));
        assert!([0x1000_0000, 0x1000_0001].contains(&word(&datagram, 4)));
    }
    let report = receiver.finish(&mut |pulse| Some(pulse));
    assert_eq!((report.pulses, report.malformed, report.undescribed), (0, 0, 12));
}
