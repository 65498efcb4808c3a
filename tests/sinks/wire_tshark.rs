//! The wire through the dissector of Wireshark (Debian package `tshark`), from a capture written here:
//! capturing needs rights that a test does not have.

use std::fs;
use std::path::Path;
use std::process::Command;

use nereus::pulse::SampleFormat;

use crate::recording_fixture::header;
use crate::wire_fixture::{datagrams, kind, long, word};

pub const PORT: u16 = 4991;

/// A capture of UDP datagrams over IPv4 without a link layer (pcap, link type 101).
pub fn pcap(path: &Path, datagrams: &[Vec<u8>]) {
    let mut file = Vec::new();
    for word in [0xa1b2_c3d4u32, 0x0002_0004, 0, 0, 65_535, 101] {
        file.extend(word.to_be_bytes());
    }
    for (n, datagram) in datagrams.iter().enumerate() {
        let length = (28 + datagram.len()) as u32;
        for word in [n as u32 / 1000, n as u32 % 1000 * 1000, length, length] {
            file.extend(word.to_be_bytes());
        }
        // IPv4 without options, do not fragment, UDP; no checksum is checked.
        let ip = [0x4500_0000 | length, 0x4000, 0x4011_0000, 0x7f00_0001, 0x7f00_0001];
        file.extend(ip.into_iter().flat_map(u32::to_be_bytes));
        let udp = [40_000, PORT, 8 + datagram.len() as u16, 0];
        file.extend(udp.into_iter().flat_map(u16::to_be_bytes));
        file.extend(datagram);
    }
    fs::write(path, file).unwrap();
}

#[test]
fn tshark_finds_nothing_malformed() {
    if !Command::new("tshark").arg("--version").output().is_ok_and(|o| o.status.success()) {
        println!("skipped: tshark is not installed (Debian: apt-get install tshark)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("wire.pcap");
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let mut header = header(format);
        header.layout.samples = 384;
        let (all, _) = datagrams(&header, 1500, 0, 8);
        pcap(&capture, &all);
        let tshark = |arguments: &[&str]| {
            let mut command = Command::new("tshark");
            command.arg("-r").arg(&capture).args(["-d", &format!("udp.port=={PORT},vrt")]).args(arguments);
            let output = command.output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8(output.stdout).unwrap()
        };
        assert_eq!(tshark(&["-Y", "_ws.malformed"]), "");
        let fields = tshark(&[
            "-Y",
            "vrt",
            "-T",
            "fields",
            "-e",
            "vrt.type",
            "-e",
            "vrt.seq",
            "-e",
            "vrt.len",
            "-e",
            "vrt.sid",
            "-e",
            "vrt.ts_int",
            "-e",
            "vrt.ts_frac_picosecond",
        ]);
        let number = |text: &str| match text.strip_prefix("0x") {
            Some(hex) => u64::from_str_radix(hex, 16).unwrap(),
            None => text.parse().unwrap(),
        };
        let mut lines = 0;
        for (line, datagram) in fields.lines().zip(&all) {
            let found: Vec<u64> = line.split('\t').map(number).collect();
            // The class identifier of extension contexts comes before the time.
            let at = if kind(datagram) == 5 { 16 } else { 8 };
            let header = word(datagram, 0);
            let expected = [
                u64::from(kind(datagram)),
                u64::from(header >> 16 & 15),
                u64::from(header & 0xffff),
                u64::from(word(datagram, 4)),
                u64::from(word(datagram, at)),
                long(datagram, at + 4),
            ];
            assert_eq!(found, expected, "{line}");
            lines += 1;
        }
        assert_eq!(lines, all.len());
    }
}
