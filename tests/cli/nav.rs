//! `nereus nav`, and navigation out of a run.

use std::fs;
use std::path::Path;

use nereus::nav::decode::{Content, Decoder};

use crate::program::{nereus, package};

fn cart() -> String {
    package().join("configs/tracks/cart.inspvax").display().to_string()
}

fn run(folder: &Path, arguments: &[&str]) -> String {
    let ended = nereus(folder, arguments);
    assert_eq!(ended.code, 0, "{arguments:?}: {}", ended.stderr);
    ended.stdout
}

/// What follows the line with the name of the file.
fn behind_the_name(text: &str) -> &str {
    text.split_once('\n').unwrap().1
}

#[test]
fn inspect_reports_what_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let text = run(folder.path(), &["nav", "inspect", &cart()]);
    let (text, block) = text.trim_end().rsplit_once('\n').unwrap();
    let expected = format!("track = {{ kind = \"inspvax\", path = \"{}\", max_gap_s = 0.051 }}", cart());
    assert_eq!(block, expected);
    insta::assert_snapshot!(behind_the_name(text), @r"
    format    inspvax, 47400 bytes
    messages  300 good (0 void), 0 with a wrong checksum, 0 of other kinds, 0 malformed
    kinds     300 INSPVAX
    fixes     300
    time      2014-11-24T20:30:19.900000Z to 2014-11-24T20:30:34.850000Z (GPS week 1820)
    span      14.950 s, 20.000 per second
    gaps      0, longest interval 0.050 s
    area      43.404059 .. 43.404103 deg N, -80.470327 .. -80.470223 deg E
    height    289.62 .. 289.84 m
    speed     0.66 .. 1.69 m/s, mean 0.87
    contains  300 velocities, 300 attitudes, 300 standard deviations
    worst     0.047 m East, 0.059 m North, 0.100 m up
    scenario  under [[platform]], its path relative to the scenario:
    ");
    let json = run(folder.path(), &["nav", "inspect", &cart(), "--json"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&report["messages"]["good"], &report["track"]["fixes"]), (&300.into(), &300.into()));
    assert_eq!(report["track"]["gps_week"], 1820);
    // A capture: the messages among its packets.
    let capture = package().join("tests/data/nav/span_90.pcap").display().to_string();
    let text = run(folder.path(), &["nav", "inspect", &capture]);
    insta::assert_snapshot!(behind_the_name(&text), @r"
    format    pcap, 10058 bytes
    capture   90 packets, 0 left; tcp 192.168.1.28:3001 > 192.168.1.21:35711, 0 bytes missing
    messages  26 good (0 void), 0 with a wrong checksum, 56 of other kinds, 26 malformed
    kinds     26 INSPVAX
    fixes     26
    time      2014-11-24T20:29:49.900000Z to 2014-11-24T20:29:51.150000Z (GPS week 1820)
    span      1.250 s, 20.000 per second
    gaps      0, longest interval 0.050 s
    area      43.404089 .. 43.404089 deg N, -80.470247 .. -80.470247 deg E
    height    289.71 .. 289.71 m
    speed     0.00 .. 0.00 m/s, mean 0.00
    contains  26 velocities, 26 attitudes, 26 standard deviations
    worst     0.022 m East, 0.023 m North, 0.038 m up
    ");
    let strait = package().join("configs/tracks/strait_of_dover.csv").display().to_string();
    let text = run(folder.path(), &["nav", "inspect", &strait]);
    assert!(text.contains("\ncontains  no velocities, attitudes or standard deviations\n"), "{text}");
    // A log without any date has counts, and the reason why it has no track.
    let plaka = package().join("tests/data/nav/plaka_700.nmea").display().to_string();
    let ended = nereus(folder.path(), &["nav", "inspect", &plaka]);
    let text = ended.stdout;
    assert!(ended.code == 1 && ended.stderr.contains("no track"), "{}: {}", ended.code, ended.stderr);
    assert!(text.contains("no date") && text.contains("219 good"), "{text}");
}

/// The block that `inspect` prints is a track: of noisy fixes with smoothing, without which their attitude
/// turns too far.
#[test]
fn the_block_of_inspect_is_a_track() {
    let folder = tempfile::tempdir().unwrap();
    let strait = package().join("configs/tracks/strait_of_dover.csv").display().to_string();
    let text = run(folder.path(), &["nav", "inspect", &strait, "--datum", "msl"]);
    let block = text.lines().last().unwrap();
    assert!(!text.contains("does not state"), "{text}");
    assert!(block.contains("datum = \"msl\", max_gap_s = 10, smoothing = { kind = \"rts\""), "{block}");
    let track = format!("platform.1.{}", block.replacen(" = ", "=", 1));
    let scenario = package().join("configs/quickstart.toml").display().to_string();
    let small = ["--set", "scene.duration_s=0.1", "--set", "scene.patch_size_m=[16, 16]", "--set", &track];
    let words = [&["check", &scenario][..], &small].concat();
    let checked = nereus(folder.path(), &words);
    assert_eq!(checked.code, 0, "{}", checked.stderr);
    assert!(checked.stdout.contains("fixes smoothed"), "{}", checked.stdout);
}

/// What a file does not state is asked for, not supposed.
#[test]
fn inspect_supposes_no_datum() {
    let folder = tempfile::tempdir().unwrap();
    let strait = package().join("configs/tracks/strait_of_dover.csv").display().to_string();
    let text = run(folder.path(), &["nav", "inspect", &strait]);
    let lines: Vec<&str> = text.lines().collect();
    let [.., remark, block] = lines[..] else { panic!("{text}") };
    let expected = "the file does not state what its heights refer to: \
                    datum = \"ellipsoid\", \"msl\" or \"barometric\"";
    assert_eq!(remark.trim(), expected);
    assert!(!block.contains("datum"), "{block}");
    let block: toml::Table = toml::from_str(block).unwrap();
    assert_eq!(block["track"]["kind"].as_str(), Some("csv"));
    let stated = run(folder.path(), &["nav", "inspect", &strait, "--datum", "ellipsoid"]);
    assert!(stated.lines().last().unwrap().contains("datum = \"ellipsoid\""), "{stated}");
    assert!(!stated.contains("does not state"), "{stated}");
}

/// From one format to the next and back, nothing is lost but digits.
#[test]
fn convert_goes_around() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let steps = [
        (cart(), "a.csv"),
        (cart(), "b.nmea"),
        (cart(), "c.inspvaxa"),
        ("c.inspvaxa".to_owned(), "d.inspvax"),
        ("d.inspvax".to_owned(), "e.csv"),
        ("b.nmea".to_owned(), "f.csv"),
    ];
    for (from, to) in &steps {
        run(folder, &["nav", "convert", from, to, "--undulation-m", "-36.5"]);
    }
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(folder.join(name)).unwrap();
        assert!(text.starts_with("unix_s,lat_deg,lon_deg,height_m,yaw_deg,pitch_deg,roll_deg\n"));
        text.lines().skip(1).map(|line| line.split(',').map(|f| f.parse().unwrap()).collect()).collect()
    };
    let wanted = rows("a.csv");
    assert_eq!(wanted.len(), 300);
    // Half a digit of each file on the way: degrees, metres, degrees of angles.
    for (name, deg, height_m, angle_deg) in [("e.csv", 2e-11, 2e-5, 3e-9), ("f.csv", 2e-10, 3e-5, 1e-4)] {
        let found = rows(name);
        assert_eq!(found.len(), 300);
        for (a, b) in wanted.iter().zip(&found) {
            let allowed = [1e-6, deg, deg, height_m, angle_deg, angle_deg, angle_deg];
            for ((a, b), allowed) in a.iter().zip(b).zip(allowed) {
                assert!((a - b).abs() <= allowed, "{name}: {a} {b}");
            }
        }
    }
    // What is there is not overwritten; a name without a format is refused; so is an attitude that nobody
    // knows.
    let again = nereus(folder, &["nav", "convert", &cart(), "a.csv"]);
    assert_eq!(again.code, 2);
    assert!(again.stderr.contains("exists already"), "{}", again.stderr);
    let odd = nereus(folder, &["nav", "convert", &cart(), "a.what"]);
    assert!(odd.code == 2 && odd.stderr.contains("gives no format"), "{}", odd.stderr);
    let flight = package().join("configs/tracks/strait_of_dover.csv").display().to_string();
    let refused = nereus(folder, &["nav", "convert", &flight, "x.inspvax"]);
    assert!(
        refused.code == 2 && refused.stderr.contains("needs a velocity and an attitude"),
        "{}",
        refused.stderr
    );
    assert!(!folder.join("x.inspvax").exists());
    let epochs = nereus(folder, &["nav", "convert", &flight, "x.nmea"]);
    assert!(
        epochs.code == 0 && epochs.stderr.contains("velocities of 877 fixes derived"),
        "{}",
        epochs.stderr
    );
    let sbet = nereus(folder, &["nav", "inspect", "a.csv", "--from", "sbet"]);
    assert!(sbet.code == 2 && sbet.stderr.contains("--gps-week"), "{}", sbet.stderr);
}

#[test]
fn play_keeps_time() {
    let folder = tempfile::tempdir().unwrap();
    let begun = std::time::Instant::now();
    let to = ["--sentences", "GGA,RMC", "--rate", "30"];
    let ended = nereus(folder.path(), &[&["nav", "play", &cart(), "file:out.nmea"], &to[..]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    // 14.95 s thirty times as fast; no message is sent early.
    assert!(begun.elapsed().as_secs_f64() > 14.95 / 30.0);
    let text = fs::read_to_string(folder.path().join("out.nmea")).unwrap();
    assert_eq!(text.lines().count(), 600);
    let odd = nereus(folder.path(), &["nav", "play", &cart(), "udp://x"]);
    assert!(odd.code == 2 && odd.stderr.contains("is no device"), "{}", odd.stderr);
}

/// The command of the manual that holds a word, with paths of its own and faster.
#[cfg(unix)]
fn of_the_manual(word: &str, instead: &str) -> String {
    let manual = fs::read_to_string(package().join("docs/navigation.md")).unwrap();
    let mut lines = manual.lines().filter(|line| line.starts_with("nereus nav play") && line.contains(word));
    let (line, None) = (lines.next().unwrap(), lines.next()) else { panic!("several commands with {word}") };
    let line = line.replacen("nereus", env!("CARGO_BIN_EXE_nereus"), 1).replace(word, instead);
    line.replace("--to inspvaxb", "--to inspvaxb --rate 5")
}

/// Runs a command of the manual while its fixes are received; they are those of the file, of which the first
/// and the last may be missed.
#[cfg(unix)]
fn received_meanwhile(command: &str, origin: nereus::nav::live::Origin) {
    use nereus::nav::live::{Feed, LiveSource, Origin};
    use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum};
    let source = LiveSource {
        origin,
        datum: VerticalDatum::Ellipsoid,
        undulation_m: 0.0,
        attitude: AttitudeSource::Recorded,
        first_day: None,
        max_gap_s: 60.0,
        max_extrapolation_s: 1.0,
        timeout_s: 30.0,
        bounds: nereus::nav::live::MotionBounds::AIRCRAFT,
        nominal: None,
    };
    let (to, received) = std::sync::mpsc::channel();
    let open = || {
        let to = to.clone();
        Feed::open(&source, "cart", None, move |received| {
            let _ = to.send(received.fix.time);
        })
    };
    // An address is listened on before anybody sends; a port is there once its maker runs.
    let first = if matches!(source.origin, Origin::Serial { .. }) { None } else { Some(open().unwrap()) };
    let mut sender =
        std::process::Command::new("sh").args(["-c", command]).current_dir(package()).spawn().unwrap();
    let begun = std::time::Instant::now();
    let feed = first.unwrap_or_else(|| {
        loop {
            match open() {
                Ok(feed) => break feed,
                Err(error) => assert!(begun.elapsed().as_secs() < 10, "{error}"),
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    });
    assert!(sender.wait().unwrap().success());
    drop(feed);
    drop(to);
    let received: Vec<_> = received.iter().collect();
    let file = FileSource {
        path: cart().into(),
        format: FileFormat::Inspvax,
        datum: VerticalDatum::Ellipsoid,
        undulation_m: 0.0,
        max_gap_s: 60.0,
        smoothing: Smoothing::Off,
        attitude: AttitudeSource::Recorded,
        first_day: None,
        bounds: nereus::nav::live::MotionBounds::SPACECRAFT,
    };
    let epochs: Vec<_> = nereus::nav::load(&file).unwrap().fixes.iter().map(|fix| fix.time).collect();
    println!("{} of {} fixes received", received.len(), epochs.len());
    assert!(
        received.len() > 20 && epochs.windows(received.len()).any(|part| part == received),
        "{received:?}"
    );
}

#[cfg(unix)]
#[test]
fn a_recording_is_received_as_datagrams() {
    let free = std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let command = of_the_manual("udp://127.0.0.1:5001", &format!("udp://{free}"));
    received_meanwhile(&command, nereus::nav::live::Origin::Udp(free));
}

#[cfg(all(unix, feature = "serial"))]
#[test]
fn a_recording_is_received_through_a_pseudo_terminal() {
    let python = std::process::Command::new("python3").arg("--version").output();
    if !python.is_ok_and(|ended| ended.status.success()) {
        println!("skipped: no python3");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("gps");
    let command = of_the_manual("/tmp/gps", link.to_str().unwrap());
    received_meanwhile(&command, nereus::nav::live::Origin::Serial { path: link.clone(), baud: 115_200 });
    assert!(!link.exists());
}

#[test]
fn corrupt_is_the_same_for_a_seed() {
    let folder = tempfile::tempdir().unwrap();
    let corrupt = |out: &str, seed: &str| {
        let chances = ["--drop", "1e-3", "--flip", "1e-3", "--cut", "1e-4", "--seed", seed];
        run(folder.path(), &[&["nav", "corrupt", &cart(), out], &chances[..]].concat());
        fs::read(folder.path().join(out)).unwrap()
    };
    let (a, b, c) = (corrupt("a", "1"), corrupt("b", "1"), corrupt("c", "2"));
    assert!(a == b && a != c);
    // Every message that is still whole is found: of 158 bytes each some 30 % are hit by a drop or a flip.
    let mut decoder = Decoder::new();
    decoder.push(&a, &mut |_| {});
    decoder.finish(&mut |_| {});
    let sound = fs::read(package().join("configs/tracks/cart.inspvax")).unwrap();
    let whole = sound.chunks(158).filter(|message| a.windows(158).any(|window| window == *message)).count();
    assert!(whole < 300);
    assert_eq!(decoder.counts().good, whole as u64);
}

/// The sentences of a run are the reported states of its pulses, as the recording has them.
#[test]
fn sentences_of_a_run_are_those_of_its_recording() {
    let folder = tempfile::tempdir().unwrap();
    let config = package().join("configs/cart.toml").display().to_string();
    let plain = ["--set", "sink.0.kind=\"plain\"", "--set", "sink.0.path=\"r.plain\"", "--json"];
    let pace = ["run", &config, "--pace", "fast", "--pulses", "0..400"];
    let json = run(folder.path(), &[&pace[..], &plain[..]].concat());
    let report: serde_json::Value = serde_json::from_str(json.trim()).unwrap();
    let port = &report["out"][1]["port"];
    // 200 pulses and 20 ticks a second.
    assert_eq!((&port["messages"], &port["lost_messages"]), (&40.into(), &0.into()), "{report}");
    let bytes = fs::read(folder.path().join("cart.nmea")).unwrap();
    let mut positions = Vec::new();
    let mut decoder = Decoder::new();
    let mut see = |message: nereus::nav::decode::Message| {
        if let Content::Gga(gga) = message.content {
            let fix = gga.fix.unwrap();
            let height_m = gga.altitude_m.unwrap() + gga.separation_m.unwrap();
            positions.push((fix.time_of_day_ns, fix.lat_deg, fix.lon_deg, height_m));
        }
    };
    decoder.push(&bytes, &mut see);
    decoder.finish(&mut see);
    assert_eq!((decoder.counts().good, decoder.counts().bad_checksum), (240, 0));
    let column = fs::read(folder.path().join("r.plain/nav/cart/reported/position_m.bin")).unwrap();
    let positions_m: Vec<[f64; 3]> = column
        .as_chunks::<24>()
        .0
        .iter()
        .map(|row| {
            let bytes = row.as_chunks::<8>().0;
            std::array::from_fn(|i| f64::from_le_bytes(bytes[i]))
        })
        .collect();
    assert_eq!(positions_m.len(), 400);
    let origin = nereus::frames::Geodetic::from_deg(43.40408, -80.47022, 288.2);
    let frame = nereus::frames::SceneFrame::at(origin, nereus::frames::Earth::Flat);
    for (tick, (ns, lat_deg, lon_deg, height_m)) in positions.into_iter().enumerate() {
        // 20:30:21 and a tick of 50 ms each.
        assert_eq!(ns, ((20 * 3600 + 30 * 60 + 21) * 1000 + 50 * tick as i64) * 1_000_000);
        let place = nereus::frames::Geodetic::from_deg(lat_deg, lon_deg, height_m);
        let [x, y, z] = frame.from_geodetic(place).unwrap().to_array();
        let [a, b, c] = positions_m[10 * tick];
        let apart_m = (x - a).hypot(y - b).hypot(z - c);
        assert!(apart_m < 1e-4, "{apart_m}");
    }
}
