//! Other people's recordings of navigation, each with what a good program makes of it (tests/data/cases).

use crate::program::{Ended, nereus, package};

/// A command on a file of a folder, its exit code, texts that it prints and texts that it must not.
struct Case {
    folder: &'static str,
    command: &'static [&'static str],
    code: i32,
    prints: &'static [&'static str],
    not: &'static [&'static str],
}

const fn check(folder: &'static str, prints: &'static [&'static str], not: &'static [&'static str]) -> Case {
    Case { folder, command: &["check", "s.toml"], code: 0, prints, not }
}

const fn inspect(
    folder: &'static str,
    file: &'static [&'static str],
    prints: &'static [&'static str],
) -> Case {
    Case { folder, command: file, code: 0, prints, not: &[] }
}

const EVEN: &str = "speed 50.1 to 50.1 m/s";

const CASES: &[Case] = &[
    check("02-nmea-date-lags", &["20 fixes over 19.000 s", "1 dates set right", EVEN], &["fault"]),
    Case {
        folder: "03-nmea-gga-only",
        command: &["check", "s.toml"],
        code: 2,
        prints: &["date = \"2024-05-01\"", "--date 2024-05-01"],
        not: &[],
    },
    Case {
        folder: "03-nmea-gga-only",
        command: &["check", "s.toml", "--set", "platform.mover.track.date='2024-05-01'"],
        code: 0,
        prints: &["100 fixes over 9.900 s"],
        not: &[],
    },
    inspect(
        "03-nmea-gga-only",
        &["nav", "inspect", "log.nmea", "--date", "2024-05-01"],
        &["2024-05-01T12:00:00.000000Z to", "date = \"2024-05-01\""],
    ),
    Case {
        folder: "03-nmea-gga-only",
        command: &["nav", "inspect", "log.nmea"],
        code: 1,
        prints: &["no track", "date = \"2024-05-01\""],
        not: &[],
    },
    check("04-nmea-two-talkers", &["20 of another talker skipped", EVEN], &["heights filled in"]),
    inspect(
        "04-nmea-two-talkers",
        &["nav", "inspect", "log.nmea"],
        &["54.000000 .. 54.000000 deg N", "342.00 .. 342.00 m"],
    ),
    check(
        "05-nmea-5hz-whole-seconds",
        &[
            "80 with the time of the position before skipped (a clock of whole seconds, or two receivers",
            EVEN,
        ],
        &[],
    ),
    check("07-nmea-minutes-60", &["1 implausible fixes refused", "1 malformed skipped", EVEN], &[]),
    check(
        "12-nmea-leap-learnt",
        &["10 before a step of the clock by -2 s at 2024-05-01T12:00:10.000000Z moved by -2 s", EVEN],
        &["out of order"],
    ),
    check("13-nmea-gns-zda", &["20 fixes over 19.000 s", EVEN], &["of other kinds", "no attitude"]),
    inspect(
        "13-nmea-gns-zda",
        &["nav", "inspect", "log.nmea"],
        &["20 GNS, 20 THS, 20 ZDA", "342.00 .. 342.00 m"],
    ),
    check("15-nmea-cr-only", &["60 fixes over 59.000 s", EVEN], &["malformed"]),
    check("19-novatel-inspva-short", &["fixes over", EVEN], &["no usable fix"]),
    inspect("19-novatel-inspva-short", &["nav", "inspect", "log.gps"], &["INSPVA", "342.00 .. 342.00 m"]),
    check("21-novatel-week-boundary", &["20 dates set right", "longest gap 0.050 s", EVEN], &["fault"]),
    Case {
        folder: "23-sbet-big-endian",
        command: &["check", "s.toml"],
        code: 2,
        prints: &["1 fault", "the records are big-endian", "np.fromfile"],
        not: &["out of range"],
    },
    check("27-csv-pandas", &["fixes over", EVEN], &["fault"]),
    inspect(
        "41-pcap-tso",
        &["nav", "inspect", "tso.pcap"],
        &["20 packets, 0 left; tcp 10.0.0.1", "20 GGA, 20 RMC"],
    ),
    inspect(
        "41-pcap-tso",
        &["nav", "inspect", "udp.pcap"],
        &["20 packets, 0 left; udp 10.0.0.1", "20 GGA, 20 RMC"],
    ),
    check(
        "44-nmea-heading-first",
        &["headings or speeds taken for the position after them"],
        &["headings filled in"],
    ),
    check("46-nmea-unpadded-longitude", &["20 fixes over 19.000 s", EVEN], &["malformed"]),
    inspect(
        "46-nmea-unpadded-longitude",
        &["nav", "inspect", "log.nmea"],
        &["54.000000 .. 54.000000 deg N, 10.0000"],
    ),
];

fn ended(case: &Case) -> Ended {
    nereus(&package().join("tests/data/cases").join(case.folder), case.command)
}

#[test]
fn other_peoples_recordings_are_read_or_named() {
    let mut failed = Vec::new();
    for case in CASES {
        let Ended { code, stdout, stderr } = ended(case);
        let all = stdout + &stderr;
        let missing: Vec<&&str> = case.prints.iter().filter(|text| !all.contains(**text)).collect();
        let unwanted: Vec<&&str> = case.not.iter().filter(|text| all.contains(**text)).collect();
        if code != case.code || !missing.is_empty() || !unwanted.is_empty() {
            let Case { folder, command, .. } = case;
            failed.push(format!("{folder} {command:?}: {code}, lacks {missing:?}, has {unwanted:?}\n{all}"));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

/// Column of a CSV, as numbers.
fn column(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

/// Before: every heading was that of the second before, 10 degrees off.
#[test]
fn a_heading_before_its_position_belongs_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let log = package().join("tests/data/cases/44-nmea-heading-first/log.nmea").display().to_string();
    let converted = nereus(folder.path(), &["nav", "convert", &log, "out.csv"]);
    assert_eq!(converted.code, 0, "{}", converted.stderr);
    let yaw_deg = column(&std::fs::read_to_string(folder.path().join("out.csv")).unwrap(), "yaw_deg");
    for (index, yaw_deg) in yaw_deg.iter().enumerate() {
        let expected = (90.0 + 10.0 * index as f64) % 360.0;
        assert!((yaw_deg - expected).abs() < 1e-6, "{index}: {yaw_deg}, {expected}");
    }
}

/// KML out, and in again; GPX in; each gzipped, and the log as UTF-16.
#[test]
fn tracks_of_maps_and_packed_ones_are_read() {
    use std::io::Write as _;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let log = package().join("tests/data/cases/46-nmea-unpadded-longitude/log.nmea").display().to_string();
    let convert = |from: &str, to: &str| {
        let ended =
            nereus(folder.path(), &["nav", "convert", from, to, "--undulation-m", "42", "--datum", "msl"]);
        assert_eq!(ended.code, 0, "{from} {to}: {}", ended.stderr);
    };
    convert(&log, "a.csv");
    convert(&log, "a.kml");
    let csv = std::fs::read_to_string(path("a.csv")).unwrap();
    let kml = std::fs::read_to_string(path("a.kml")).unwrap();
    assert!(kml.contains("<gx:coord>10.000000000 54.000000000 300.000</gx:coord>"), "{kml}");
    let [lat, lon, height] = ["lat_deg", "lon_deg", "height_m"].map(|name| column(&csv, name));
    let mut gpx = "<?xml version=\"1.0\"?><gpx version=\"1.1\"><trk><trkseg>\n".to_owned();
    for (second, ((lat, lon), height)) in lat.iter().zip(&lon).zip(&height).enumerate() {
        let height = height - 42.0;
        gpx += &format!("<trkpt lat=\"{lat}\" lon=\"{lon}\"><ele>{height}</ele>");
        // Local time with its offset is read as UTC.
        gpx += &format!("<time>2024-05-01T14:00:{second:02}+02:00</time></trkpt>\n");
    }
    gpx += "</trkseg></trk></gpx>";
    let packed = |bytes: &[u8]| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(bytes).unwrap();
        packed.finish().unwrap()
    };
    let wide: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(std::fs::read_to_string(&log).unwrap().encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    std::fs::write(path("b.gpx"), &gpx).unwrap();
    std::fs::write(path("b.gpx.gz"), packed(gpx.as_bytes())).unwrap();
    std::fs::write(path("b.kml.gz"), packed(kml.as_bytes())).unwrap();
    std::fs::write(path("wide.nmea"), &wide).unwrap();
    std::fs::write(path("wide.nmea.gz"), packed(&wide)).unwrap();
    for from in ["a.kml", "b.gpx", "b.gpx.gz", "b.kml.gz", "wide.nmea", "wide.nmea.gz"] {
        let to = format!("{from}.csv");
        convert(from, &to);
        let again = std::fs::read_to_string(path(&to)).unwrap();
        for (name, of) in [("unix_s", 1e-6), ("lat_deg", 1e-9), ("lon_deg", 1e-9), ("height_m", 1e-3)] {
            let [was, is] = [&csv, &again].map(|text| column(text, name));
            assert_eq!(was.len(), is.len(), "{from}");
            assert!(was.iter().zip(&is).all(|(was, is)| (was - is).abs() <= of), "{from} {name}");
        }
    }
    // Places without times are named, with where times must stand.
    std::fs::write(path("no.gpx"), "<gpx><trk><trkseg><trkpt lat=\"1\" lon=\"2\"/></trkseg></trk></gpx>")
        .unwrap();
    let ended = nereus(folder.path(), &["nav", "inspect", "no.gpx"]);
    assert_eq!(ended.code, 1);
    assert!(
        ended.stdout.contains("1 places have no time; allowed: a <time> in every <trkpt>"),
        "{}",
        ended.stdout
    );
}
