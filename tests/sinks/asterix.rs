//! Radar video: bytes against the items of EUROCONTROL-SPEC-0149-240, edition 1.3, written out here by hand;
//! the dissector of Wireshark (Debian package `tshark`); the decoder `pycatzao` (a Python package).

use std::fs;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use nereus::pulse::{Layout, Pulse};
use nereus::sinks::asterix::{AsterixSink, Bits, CellTime, Detection, Radial, Settings, Source, Video};
use nereus::sinks::sink::{Sink, SinkReport};
use nereus::sinks::{Kind, preflight};
use nereus::time::TimeTag;

/// The port that Wireshark takes for ASTERIX.
const PORT: u16 = 8600;
/// Before the cells of a video message: category, length, field specification and items.
const AHEAD: usize = 3 + 2 + 2 + 1 + 4 + 12 + 2 + 5 + 1;

/// A radial for every pulse, as given.
struct Given {
    cell: CellTime,
    radials: Vec<Radial>,
}

impl Video for Given {
    fn channel(&self) -> &str {
        "HH"
    }

    fn cell_time(&self) -> CellTime {
        self.cell
    }

    fn cells(&self) -> usize {
        self.radials.iter().map(|radial| radial.powers_w.len()).max().unwrap_or(1)
    }

    fn take(&mut self, pulse: &Pulse, done: &mut dyn FnMut(&Radial)) {
        self.radials.get(pulse.index as usize).into_iter().for_each(done);
    }

    fn finish(&mut self, _: &mut dyn FnMut(&Radial)) {}
}

/// Half past one in the afternoon, and 0.25 s: 48,600.25 s of the day, 6,220,832 / 128 s.
fn time() -> TimeTag {
    TimeTag::from_iso8601("2018-05-30T13:30:00.25Z").unwrap()
}

/// A radial of so many cells; the code of cell `k` of 8 bits over 80 dB up to 0 dBW is `code(k)`.
fn radial(cells: usize, code: impl Fn(usize) -> u8) -> Radial {
    let power_w = |k| 10f64.powf((f64::from(code(k)) / 255.0 - 1.0) * 8.0) as f32;
    Radial {
        time: time(),
        azimuths_deg: [-22.5, 90.0],
        first: 100,
        powers_w: (0..cells).map(power_w).collect(),
        missed: 0,
    }
}

fn settings(to: &UdpSocket) -> Settings {
    let address = to.local_addr().unwrap().to_string();
    Settings { address, source: Source { sac: 7, sic: 42 }, ..Settings::default() }
}

/// What the sink sends of radials, the greatest code at 0 dBW, and what it reports.
fn sent(
    change: impl FnOnce(&mut Settings),
    cell: CellTime,
    radials: Vec<Radial>,
) -> (Vec<Vec<u8>>, SinkReport) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_nonblocking(true).unwrap();
    let mut settings = settings(&socket);
    change(&mut settings);
    let pulses = radials.len() as u64;
    let mut sink = AsterixSink::open(&settings, Box::new(Given { cell, radials }), 0.0).unwrap();
    let mut pulse = Pulse::new(&Layout { channels: 1, samples: 1, ..Layout::default() });
    let (mut all, mut buffer) = (Vec::new(), vec![0; 1 << 16]);
    for index in 0..pulses {
        pulse.index = index;
        sink.write(&pulse).unwrap();
        // On loopback a datagram is there when the call that sent it returns.
        while let Ok(length) = socket.recv(&mut buffer) {
            all.push(buffer[..length].to_vec());
        }
    }
    (all, sink.close().unwrap().report)
}

fn hex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    digits.chunks(2).map(byte).collect()
}

#[test]
fn messages_are_those_of_the_items() {
    // 40 ns a cell: 4e7 fs, 02625a00; six cells of 8 bits in two blocks of 4 octets.
    let (all, report) = sent(|_| (), CellTime::Femto(40_000_000), vec![radial(6, |k| 50 * k as u8)]);
    // 240; length 43; items 010, 000, 020, 041, 048, and 049, 050, 140.
    let video = "f0 002b  e7 c8  07 2a  02  00000000 \
                 f000 4000 00000064 02625a00  00 04  0006 000006  02 00 32 64 96 c8 fa 00 00  5eec20";
    assert_eq!(all.len(), 2);
    assert_eq!(all[1], hex(video));
    // A summary before it: 240, its length, items 010, 000, 030, and 140; a text with its length before it.
    let text =
        format!("nereus {}; channel HH; 8 bits, logarithmic; -80.0 to 0.0 dBW", env!("CARGO_PKG_VERSION"));
    let length = 3 + 2 + 2 + 1 + 1 + text.len() + 3;
    let ahead = [0xf0, 0, length as u8, 0xd1, 0x08, 7, 42, 1, text.len() as u8];
    assert_eq!(all[0], [&ahead[..], text.as_bytes(), &hex("5eec20")].concat());
    let wire = report.wire.unwrap();
    let bytes = all.iter().map(Vec::len).sum::<usize>() as u64;
    assert_eq!((wire.datagrams, wire.lost(), report.bytes), (2, 0, bytes));
    let video = report.video.unwrap();
    assert_eq!((video.radials, video.cells, video.missed, video.clipped), (1, 6, 0, 0));
}

#[test]
fn cells_of_16_bits_linear_codes_and_long_cells() {
    // 5 us a cell do not fit into femtoseconds: item 040, 5000 ns.
    let cell = CellTime::nearest(5e-6);
    let mut of = radial(3, |_| 0);
    of.powers_w = vec![1.0, 0.25, 1e-6];
    let change = |settings: &mut Settings| {
        (settings.bits, settings.detection) = (Bits::Sixteen, Detection::Linear);
    };
    let (all, _) = sent(change, cell, vec![of]);
    // Codes 65535, 32768 (32767.5), 66 (65.5), the most significant octet first.
    let video = "f0 002b  eb c8  07 2a  02  00000000 \
                 f000 4000 00000064 00001388  00 05  0006 000003  02 ffff 8000 0042 0000  5eec20";
    assert_eq!(all[1], hex(video));
}

/// The item and its repetition, octets and cells of a video message, and where the cells begin.
fn volume(message: &[u8]) -> (u8, usize, usize, usize) {
    let octets = usize::from(message[26]) << 8 | usize::from(message[27]);
    let cells = message[28..31].iter().fold(0, |all, byte| all << 8 | usize::from(*byte));
    (message[4] & 0x70, message[31].into(), octets, cells)
}

/// Messages: item, its repetitions, cells.
type Pieces = &'static [(u8, usize, usize)];

#[test]
fn a_radial_is_split_by_range_as_the_packet_size_asks() {
    // Cells, bits, greatest packet, and the messages.
    let cases: [(usize, Bits, usize, Pieces); 6] = [
        (1020, Bits::Eight, 1500, &[(0x40, 255, 1020)]),
        (1021, Bits::Eight, 1500, &[(0x20, 16, 1021)]),
        // 1472 bytes less 35: 22 blocks of 64.
        (3000, Bits::Eight, 1500, &[(0x20, 22, 1408), (0x20, 22, 1408), (0x40, 46, 184)]),
        (3000, Bits::Sixteen, 65_535, &[(0x20, 94, 3000)]),
        (16_321, Bits::Eight, 65_535, &[(0x10, 64, 16_321)]),
        // 254 blocks of 256, as the standard asks: 32,512 cells of 16 bits.
        (40_000, Bits::Sixteen, 65_535, &[(0x10, 254, 32_512), (0x20, 234, 7488)]),
    ];
    for (cells, bits, mtu_bytes, wanted) in cases {
        let code = |k: usize| (k % 251) as u8;
        let change = |settings: &mut Settings| (settings.bits, settings.mtu_bytes) = (bits, mtu_bytes);
        let (all, _) = sent(change, CellTime::Femto(1), vec![radial(cells, code), radial(cells, code)]);
        assert_eq!(all.len(), 1 + 2 * wanted.len());
        let mut first = 100;
        for (n, (message, (item, repeated, held))) in all[1..].iter().zip(wanted.iter().cycle()).enumerate() {
            if n % wanted.len() == 0 {
                first = 100;
            }
            let octets = held * bits.count() as usize / 8;
            assert!(message.len() + 28 <= mtu_bytes);
            assert_eq!(volume(message), (*item, *repeated, octets, *held));
            let number = |at: usize| u32::from_be_bytes(message[at..at + 4].try_into().unwrap());
            assert_eq!((number(8), number(16)), (n as u32, first as u32));
            for k in 0..*held {
                let at = AHEAD + k * bits.count() as usize / 8;
                let wanted = code(first - 100 + k);
                match bits {
                    Bits::Eight => assert_eq!(message[at], wanted),
                    // 257 codes of 16 bits for one of 8; f32 has 24 bits, and 80 dB are 65,535 codes.
                    Bits::Sixteen => {
                        let code = u16::from_be_bytes([message[at], message[at + 1]]);
                        assert!(i32::from(code).abs_diff(257 * i32::from(wanted)) <= 1, "{code} {wanted}");
                    }
                }
            }
            // What fills the last block is zero.
            assert!(message[AHEAD + octets..message.len() - 3].iter().all(|byte| *byte == 0));
            first += held;
        }
    }
}

#[test]
fn missed_radials_leave_out_their_numbers_and_a_summary_comes_every_second() {
    let radials: Vec<Radial> = (0..30)
        .map(|n| Radial {
            time: time().plus(0.1 * f64::from(n)),
            missed: if n == 7 { 5 } else { 0 },
            ..radial(2000, |_| 1)
        })
        .collect();
    let (all, report) = sent(|_| (), CellTime::Femto(40_000_000), radials);
    let (summaries, videos): (Vec<_>, Vec<_>) = all.iter().partition(|message| message[7] == 1);
    assert_eq!((summaries.len(), videos.len()), (3, 60));
    let numbers: Vec<u32> = videos.iter().map(|m| u32::from_be_bytes(m[8..12].try_into().unwrap())).collect();
    let wanted: Vec<u32> = (0..14).chain(24..70).collect();
    assert_eq!(numbers, wanted);
    assert_eq!(report.video.unwrap().missed, 5);
}

#[test]
fn what_is_above_the_greatest_code_is_counted_and_named() {
    let mut of = radial(4, |_| 9);
    of.powers_w[2] = 2.0;
    let (all, report) = sent(|_| (), CellTime::Femto(1), vec![of]);
    assert_eq!(all[1][AHEAD..AHEAD + 4], [9, 9, 255, 9]);
    let lines = report.lines().join("\n");
    assert!(lines.contains("asterix: 1 of 4 cells are above the greatest code; see full_dbw"), "{lines}");
}

#[test]
fn datagrams_that_nobody_takes_are_counted() {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let settings = settings(&socket);
    drop(socket);
    let given = Given { cell: CellTime::Femto(1), radials: vec![radial(5, |_| 1); 20] };
    let mut sink = AsterixSink::open(&settings, Box::new(given), 0.0).unwrap();
    let mut pulse = Pulse::new(&Layout { channels: 1, samples: 1, ..Layout::default() });
    for index in 0..20 {
        pulse.index = index;
        sink.write(&pulse).unwrap();
    }
    let report = sink.close().unwrap().report;
    assert!(report.wire.as_ref().unwrap().lost() > 0);
    assert!(report.losses()[0].contains("datagrams were lost"), "{:?}", report.losses());
}

#[test]
fn a_group_gets_the_video_by_the_interface_that_is_named() {
    let group = Ipv4Addr::new(239, 192, 7, 42);
    let socket = UdpSocket::bind("0.0.0.0:0").unwrap();
    if let Err(error) = socket.join_multicast_v4(&group, &Ipv4Addr::LOCALHOST) {
        println!("skipped: no group can be joined here: {error}");
        return;
    }
    socket.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    let address = format!("{group}:{}", socket.local_addr().unwrap().port());
    let settings = Settings { address, ..settings(&socket) };
    let given = Given { cell: CellTime::Femto(1), radials: vec![radial(5, |_| 1)] };
    let mut sink = AsterixSink::open(&settings, Box::new(given), 0.0).unwrap();
    sink.write(&Pulse::new(&Layout { channels: 1, samples: 1, ..Layout::default() })).unwrap();
    let mut buffer = [0; 2000];
    let (length, from) = socket.recv_from(&mut buffer).unwrap();
    assert_eq!((buffer[0], usize::from(buffer[2]), from.ip()), (240, length, Ipv4Addr::LOCALHOST.into()));
    assert_eq!(sink.close().unwrap().report.wire.unwrap().lost(), 0);
    // Of documentation: no machine has it.
    let settings = Settings { interface: Ipv4Addr::new(203, 0, 113, 9), ..settings };
    let given = Given { cell: CellTime::Femto(1), radials: Vec::new() };
    let error = AsterixSink::open(&settings, Box::new(given), 0.0).err().unwrap().to_string();
    let ends = "allowed: the IPv4 address of an interface of this machine";
    assert!(error.starts_with("interface = 203.0.113.9: ") && error.ends_with(ends), "{error}");
}

#[test]
fn addresses_and_sizes_are_looked_at_first() {
    let sink = |address: &str, sic: u8| {
        let source = Source { sac: 0, sic };
        let settings = Settings { address: address.to_owned(), source, ..Settings::default() };
        nereus::sinks::Settings::new(Kind::Asterix(settings), 4)
    };
    let texts = |sinks: &[nereus::sinks::Settings]| -> Vec<String> {
        preflight(sinks).iter().map(ToString::to_string).collect()
    };
    assert!(
        texts(&[sink("239.1.2.3:8600", 1), sink("239.1.2.3:8600", 2), sink("127.0.0.1:8600", 1)]).is_empty()
    );
    assert_eq!(
        texts(&[
            sink("224.0.0.5:1", 1),
            sink("[ff02::1]:1", 1),
            sink("255.255.255.255:1", 1),
            sink("127.0.0.1:1", 1),
            sink("127.0.0.1:1", 1)
        ]),
        [
            "224.0.0.5:1: datagrams cannot go there; allowed: a group from 224.0.1.0 to 239.255.255.255: those below are of routers",
            "[ff02::1]:1: datagrams cannot go there; allowed: a group of IPv4, from 224.0.1.0 to 239.255.255.255",
            "255.255.255.255:1: datagrams cannot go there; allowed: the address of a machine, or a group from 224.0.1.0 to 239.255.255.255",
            "127.0.0.1:1: two sinks send there, with the same stream identifiers; each needs its own address",
        ]
    );
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let settings = Settings { mtu_bytes: 70_000, ..settings(&socket) };
    let given = Given { cell: CellTime::Femto(1), radials: Vec::new() };
    let error = AsterixSink::open(&settings, Box::new(given), 0.0).err().unwrap();
    assert_eq!(error.to_string(), "mtu_bytes = 70000: allowed: 576 to 65535 bytes");
}

/// Messages of all three items, 8 and 16 bits, femto- and nanoseconds, split and whole, with summaries.
fn of_all_kinds() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for (cells, bits, mtu_bytes, cell) in [
        (500, Bits::Eight, 1500, CellTime::Femto(40_000_000)),
        (3000, Bits::Eight, 1500, CellTime::Femto(4_000_000)),
        (9000, Bits::Sixteen, 65_535, CellTime::Nano(5000)),
        (501, Bits::Sixteen, 1500, CellTime::Femto(40_000_001)),
    ] {
        let turn = |n: u32| {
            let azimuth_deg = 7.5 * f64::from(n) - 30.0;
            let code = move |k: usize| (3 * k + n as usize) as u8;
            Radial { azimuths_deg: [azimuth_deg, azimuth_deg + 7.5], ..radial(cells, code) }
        };
        let change = |settings: &mut Settings| (settings.bits, settings.mtu_bytes) = (bits, mtu_bytes);
        all.extend(sent(change, cell, (0..48).map(turn).collect()).0);
    }
    all
}

#[test]
fn tshark_finds_nothing_malformed() {
    if !Command::new("tshark").arg("--version").output().is_ok_and(|o| o.status.success()) {
        println!("skipped: tshark is not installed (Debian: apt-get install tshark)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("video.pcap");
    let all = of_all_kinds();
    pcap(&capture, &all);
    let tshark = |arguments: &[&str]| {
        let mut command = Command::new("tshark");
        command.arg("-r").arg(&capture).args(["-d", &format!("udp.port=={PORT},asterix")]).args(arguments);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(tshark(&["-Y", "_ws.malformed || _ws.expert.severity >= \"warning\""]), "");
    let of = |field: &str| format!("asterix.240_{field}");
    let fields =
        ["000_VALUE", "010_SIC", "020_VALUE", "040_STARTAZ", "041_STARTAZ", "048_RES", "049_NBCELLS"].map(of);
    let mut arguments = vec!["-Y", "asterix.category == 240", "-T", "fields"];
    fields.iter().for_each(|field| arguments.extend(["-e", field]));
    let found = tshark(&arguments);
    let lines: Vec<&str> = found.lines().collect();
    assert_eq!(lines.len(), all.len());
    for (line, message) in lines.iter().zip(&all) {
        let columns: Vec<&str> = line.split('\t').collect();
        assert_eq!((columns[0], columns[1]), (message[7].to_string().as_str(), "0x2a"));
        if message[7] == 1 {
            continue;
        }
        let number = u32::from_be_bytes(message[8..12].try_into().unwrap());
        assert_eq!(columns[2], number.to_string());
        let azimuth_deg =
            f64::from(u16::from_be_bytes(message[12..14].try_into().unwrap())) / 65_536.0 * 360.0;
        let shown: f64 = [columns[3], columns[4]].concat().parse().unwrap();
        assert!((shown - azimuth_deg).abs() < 1e-3, "{line}");
        assert_eq!(
            (columns[5], columns[6]),
            (message[25].to_string().as_str(), volume(message).3.to_string().as_str())
        );
    }
}

/// A capture of UDP datagrams over IPv4 without a link layer, as of [`crate::wire_tshark`], to another port.
fn pcap(path: &Path, datagrams: &[Vec<u8>]) {
    crate::wire_tshark::pcap(path, datagrams);
    let mut bytes = fs::read(path).unwrap();
    let mut at = 24;
    for datagram in datagrams {
        // Header of the record, IP, and the port that UDP comes from.
        let port = at + 16 + 20 + 2;
        assert_eq!(bytes[port..port + 2], crate::wire_tshark::PORT.to_be_bytes());
        bytes[port..port + 2].copy_from_slice(&PORT.to_be_bytes());
        at += 16 + 28 + datagram.len();
    }
    fs::write(path, bytes).unwrap();
}

/// The package drops cells of code 0, and takes those of 16 bits in the order of the machine.
const READER: &str = r#"
import sys, numpy as np, pycatzao
blocks, rest = pycatzao.decode(open(sys.argv[1], "rb").read())
assert rest == b""
video = [b for b in blocks if b["type"] == 2]
assert {(b["sac"], b["sic"]) for b in blocks} == {(7, 42)} and {b["tod"] for b in blocks} == {48600.25}
assert all(b["summary"].startswith("nereus ") for b in blocks if b["type"] == 1)
c, cells = 299792458, 0
counts = [(500, 1, 40e-9), (3000, 1, 4e-9), (9000, 2, 5e-6), (501, 2, 40.000001e-9)]
for count, octets, duration in counts:
    for n in range(48):
        found = {}
        while len(found) < sum((3 * k + n) % 256 > 0 for k in range(count)):
            b = video.pop(0)
            middle = (7.5 * n - 30 + 3.75) % 360
            assert abs((b["az"] - middle + 180) % 360 - 180) < 0.006, (b["az"], middle)
            assert abs(b["az_cell_size"] - 7.5) < 0.006 and abs(b["r_cell_size"] / (duration * c / 2) - 1) < 1e-9
            place = np.rint(b["r"] / b["r_cell_size"]).astype(int)
            amp = b["amp"] if octets == 1 else b["amp"].byteswap()
            found.update(zip(place.tolist(), amp.tolist()))
        for place, amp in found.items():
            code = (3 * (place - 100) + n) % 256
            assert abs(amp - code * (1 if octets == 1 else 257)) <= octets - 1, (place, amp, code)
        cells += len(found)
assert video == []
print(cells)
"#;

#[test]
fn pycatzao_decodes_the_same_video() {
    if !Command::new("python3").args(["-c", "import pycatzao"]).output().is_ok_and(|o| o.status.success()) {
        println!("skipped: python3 cannot import pycatzao");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.cat240");
    fs::write(&path, of_all_kinds().concat()).unwrap();
    let output = Command::new("python3").args(["-c", READER]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    println!("{} cells decoded", String::from_utf8_lossy(&output.stdout).trim());
}
