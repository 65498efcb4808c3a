//! Radar video of a run: where targets are in it, by a reader of the messages that is written out here.

use std::fs;
use std::net::UdpSocket;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use socket2::SockRef;

use crate::ppi::{SCENARIO, TARGETS};
use crate::program::nereus;

/// What a message says.
struct Message {
    number: u32,
    azimuths_deg: [f64; 2],
    first: u32,
    cell_m: f64,
    codes: Vec<u8>,
}

impl Message {
    /// A video message with item 041 and 8 bits; `None` of a summary.
    fn of(bytes: &[u8]) -> Option<Self> {
        let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
        let azimuth_deg = |at: usize| f64::from(word(at) >> 16) * 360.0 / 65_536.0;
        assert_eq!((bytes[0], usize::from(bytes[1]) << 8 | usize::from(bytes[2])), (240, bytes.len()));
        if bytes[7] == 1 {
            return None;
        }
        assert_eq!((bytes[3], bytes[24], bytes[25]), (0xe7, 0, 4));
        let cells = (word(27) & 0xff_ffff) as usize;
        Some(Self {
            number: word(8),
            azimuths_deg: [azimuth_deg(12), azimuth_deg(14)],
            first: word(16),
            cell_m: 299_792_458.0 / 2.0 * f64::from(word(20)) * 1e-15,
            codes: bytes[32..32 + cells].to_vec(),
        })
    }

    /// Middle of its azimuths, degrees, and their width.
    fn azimuth_deg(&self) -> [f64; 2] {
        let [from, to] = self.azimuths_deg;
        let width = (to - from).rem_euclid(360.0);
        [(from + 0.5 * width).rem_euclid(360.0), width]
    }
}

/// Datagrams that the system has discarded because nobody read a socket in time; 0 where it does not say.
fn discarded(socket: &UdpSocket) -> u64 {
    let port = format!(":{:04X}", socket.local_addr().unwrap().port());
    let table = fs::read_to_string("/proc/net/udp").unwrap_or_default();
    let fields = table.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    fields
        .filter(|fields| fields.get(1).is_some_and(|address| address.ends_with(&port)))
        .filter_map(|fields| fields.last()?.parse::<u64>().ok())
        .sum()
}

/// Runs the scenario with a sink of video beside these settings of it; again where the system has discarded
/// messages, as a loaded machine does.
fn video(folder: &Path, sink: &str, settings: &[&str]) -> (Vec<Message>, String) {
    for _ in 0..5 {
        let (found, said, discarded) = video_once(folder, sink, settings);
        if discarded == 0 {
            return (found, said);
        }
        println!("{discarded} messages were discarded by the system");
    }
    panic!("the system discards messages again and again");
}

fn video_once(folder: &Path, sink: &str, settings: &[&str]) -> (Vec<Message>, String, u64) {
    fs::write(folder.join("s.toml"), SCENARIO).unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    // Room for every message of a run, where the system allows it: the reader may be kept from a processor.
    SockRef::from(&socket).set_recv_buffer_size(4 << 20).unwrap();
    let to = socket.local_addr().unwrap();
    let sink = format!("sink.0={{ kind = 'asterix', address = '{to}', {sink} }}");
    let mut arguments = vec!["run", "s.toml", "--pace", "fast", "--set", &sink];
    settings.iter().for_each(|setting| arguments.extend(["--set", *setting]));
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            let (mut all, mut buffer) = (Vec::new(), vec![0; 1 << 16]);
            loop {
                match socket.recv(&mut buffer) {
                    Ok(length) => all.extend(Message::of(&buffer[..length])),
                    Err(_) if ended.load(Ordering::Acquire) => return all,
                    Err(_) => {}
                }
            }
        });
        let run = nereus(folder, &arguments);
        ended.store(true, Ordering::Release);
        assert_eq!(run.code, 0, "{}", run.stderr);
        (reader.join().unwrap(), run.stdout + &run.stderr, discarded(&socket))
    })
}

/// The strongest cell within a quarter of a turn about a bearing, of the first turn: range, m, and the
/// azimuth, degrees, weighted by what is above half the power: 255 codes are 80 dB.
fn strongest(video: &[Message], bearing_deg: f64) -> [f64; 2] {
    let away = |deg: f64| (deg - bearing_deg + 180.0).rem_euclid(360.0) - 180.0;
    let near: Vec<&Message> =
        video.iter().take(800).filter(|message| away(message.azimuth_deg()[0]).abs() < 45.0).collect();
    let best = near.iter().max_by_key(|message| message.codes.iter().max()).unwrap();
    let most = *best.codes.iter().max().unwrap();
    let place = best.codes.iter().position(|code| *code == most).unwrap();
    let cell = best.first as usize + place;
    let (mut sum, mut weight) = (0.0, 0.0);
    for message in &near {
        let Some(code) = cell.checked_sub(message.first as usize).and_then(|place| message.codes.get(place))
        else {
            continue;
        };
        let power = 10f64.powf(8.0 * (f64::from(*code) - f64::from(most)) / 255.0);
        if power > 0.5 {
            sum += power * away(message.azimuth_deg()[0]);
            weight += power;
        }
    }
    [cell as f64 * best.cell_m, bearing_deg + sum / weight]
}

/// Every target stands within half a cell and half of a value of the compressed window (1.5 m), and within
/// some degrees: a fifth of the beam of 1.15, or half of a wider radial.
fn check(video: &[Message], what: &str, within_deg: f64) {
    let cell_m = video[0].cell_m;
    for [east, north, up] in TARGETS {
        let (range_m, bearing_deg) = (east.hypot(north).hypot(up), east.atan2(north).to_degrees());
        let [found_m, found_deg] = strongest(video, bearing_deg);
        println!("{what}: {:.1} m, {:.3} degrees off", found_m - range_m, found_deg - bearing_deg);
        assert!((found_m - range_m).abs() < 0.5 * cell_m + 2.0, "{what}: {found_m} {range_m}");
        assert!((found_deg - bearing_deg).abs() < within_deg, "{what}: {found_deg} {bearing_deg}");
    }
}

#[test]
fn targets_stand_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    // 4000 pulses a second, a turn in 0.2 s: 0.45 degrees a pulse.
    let (found, _) = video(folder.path(), "", &[]);
    assert_eq!(found.len(), 1800);
    assert!(found.iter().enumerate().all(|(n, message)| message.number == n as u32));
    for message in &found {
        assert!((message.azimuth_deg()[1] - 0.45).abs() < 0.012, "{:?}", message.azimuths_deg);
        // The window opens after 2 us, 50 cells of 40 ns, and has 255 of them.
        assert_eq!((message.first, message.codes.len()), (50, 255));
    }
    check(&found, "a pulse", 0.25);

    // A mean of 4 pulses, 15 m a cell.
    let (found, _) = video(folder.path(), "radial_pulses = 4, cell_m = 15.0, full_dbw = -60.0", &[]);
    assert_eq!(found.len(), 450);
    assert!(found.iter().all(|message| (message.azimuth_deg()[1] - 1.8).abs() < 0.1));
    assert!((found[0].cell_m - 15.0).abs() < 1e-5);
    check(&found, "four pulses", 0.9);

    // Azimuths count from North, wherever the nose is.
    let turned = "platform.0.track={ kind = 'fixed', position_m = [100.0, -200.0, 20.0], yaw_deg = 77.0 }";
    let (found, _) = video(folder.path(), "", &[turned]);
    check(&found, "turned", 0.25);

    // The other way round: edges are clockwise all the same.
    let back = ["transmitter.0.pointing.rpm=-300", "receiver.0.pointing.rpm=-300"];
    let (found, _) = video(folder.path(), "", &back);
    assert!(found.iter().all(|message| (message.azimuth_deg()[1] - 0.45).abs() < 0.012));
    check(&found, "back", 0.25);
}

#[test]
fn a_sector_is_swept_to_and_fro() {
    let folder = tempfile::tempdir().unwrap();
    let sector = "{ kind = 'sector', from_deg = 20.0, to_deg = 80.0, rate_degps = 600.0, turn_ms = 5.0 }";
    let settings = ["transmitter", "receiver"].map(|end| format!("{end}.0.pointing={sector}"));
    let (video, _) = video(folder.path(), "", &settings.each_ref().map(String::as_str));
    assert_eq!(video.len(), 1800);
    // It runs 0.75 degrees past either end, and a radial reaches 0.075 degrees to either side.
    let within = |deg: f64| (19.1..=80.9).contains(&deg);
    assert!(video.iter().all(|message| message.azimuths_deg.iter().all(|deg| within(*deg))));
    let [found_m, found_deg] = strongest(&video, 600f64.atan2(500.0).to_degrees());
    assert!((found_m - 781.2).abs() < 5.0 && (found_deg - 50.194).abs() < 0.25, "{found_m} {found_deg}");
}

#[test]
fn levels_follow_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    // Noise alone: its mean is 70 of 80 dB below the greatest code, 10 dB above code 0.
    // A lost message does not alter it.
    let (found, ..) = video_once(folder.path(), "cell = 'mean', cell_m = 600", &["target=[]"]);
    let mean_db = |codes: &[u8], db: f64| {
        let power = |code: &u8| 10f64.powf(f64::from(*code) / 255.0 * db / 10.0);
        10.0 * (codes.iter().map(power).sum::<f64>() / codes.len() as f64).log10()
    };
    let codes: Vec<u8> = found.iter().flat_map(|message| message.codes.clone()).collect();
    let found = mean_db(&codes, 80.0);
    println!("noise {found:.2} dB above code 0");
    // The taper lets 1.3 dB more pass, and the band of the pulse is less than its length says by as much.
    assert!((found - 10.0).abs() < 2.0, "{found}");
    let clipped = video_once(folder.path(), "full_dbw = -140", &[]).1;
    assert!(clipped.contains("are above the greatest code"), "{clipped}");
}
