//! Live navigation: what a stream gives is what its file gives; lines that are noisy, vanish, jump or fall
//! silent.

use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::sleep;
use std::time::{Duration, Instant};

use nereus::nav::completion::{Completer, Reported};
use nereus::nav::encode::{Format, Sentence};
use nereus::nav::epoch::Epoch;
use nereus::nav::live::{Feed, FeedCounts, FeedError, FixDecoder, LiveSource, Origin, ReceivedFix};
use nereus::nav::{AttitudeSource, FileFormat, FileSource, Fix, NavError, VerticalDatum, nmea, pcap, replay};
use nereus::time::TimeTag;
use proptest::prelude::*;

use crate::sentences::solution_of;
use crate::sources::{self, sentence};

/// Longest wait for what must come.
const TIMEOUT: Duration = Duration::from_secs(5);

fn start() -> TimeTag {
    solution_of(0).time
}

fn source(origin: Origin) -> LiveSource {
    LiveSource {
        origin,
        datum: VerticalDatum::MeanSeaLevel,
        undulation_m: 41.0,
        attitude: AttitudeSource::Recorded,
        first_day: None,
        max_gap_s: 10.0,
        max_extrapolation_s: 1.0,
        timeout_s: 30.0,
        bounds: nereus::nav::live::MotionBounds::AIRCRAFT,
        nominal: None,
    }
}

fn decoder(wait_s: f64) -> FixDecoder {
    FixDecoder::new(VerticalDatum::MeanSeaLevel, 41.0, AttitudeSource::Recorded, wait_s)
}

/// The fixes of some pieces: those reported while they come, and those reported at the end.
fn decoded(pieces: &[&[u8]], wait_s: f64) -> (Vec<Fix>, Vec<Fix>) {
    let mut decoder = decoder(wait_s);
    let (mut reported, mut last) = (Vec::new(), Vec::new());
    for piece in pieces {
        decoder.push(piece, &mut |fix| reported.push(fix));
    }
    decoder.finish(&mut |fix| last.push(fix));
    (reported, last)
}

/// Cuts a stream into pieces of these lengths, over and over.
fn cut<'a>(stream: &'a [u8], lengths: &[usize]) -> Vec<&'a [u8]> {
    let (mut pieces, mut rest) = (Vec::new(), stream);
    for length in lengths.iter().cycle() {
        if rest.is_empty() {
            break;
        }
        let (piece, after) = rest.split_at((*length).min(rest.len()));
        pieces.push(piece);
        rest = after;
    }
    pieces
}

fn message_of(second: u32, format: &Format) -> Vec<u8> {
    let mut out = Vec::new();
    format.write(&solution_of(second), &mut out).unwrap();
    out
}

/// A whole epoch of sentences.
fn epoch(second: u32) -> Vec<u8> {
    message_of(second, &Format::Nmea(Sentence::ALL.to_vec()))
}

fn inspvax(second: u32) -> Vec<u8> {
    message_of(second, &Format::InspvaxBinary)
}

fn seconds(fixes: &[Fix]) -> Vec<f64> {
    fixes.iter().map(|fix| fix.time.since(start())).collect()
}

/// `Fix` has no bits to compare, but its text has every digit.
fn same(a: &[Fix], b: &[Fix]) -> bool {
    format!("{a:?}") == format!("{b:?}")
}

#[test]
fn a_stream_gives_the_fixes_of_its_file() {
    let read = |path: &str| std::fs::read(sources::repository(path)).unwrap();
    let plaka = read("tests/data/nav/plaka_700.nmea");
    let capture = pcap::parse(&read("tests/data/nav/span_90.pcap")).unwrap();
    let span = capture.streams.into_iter().map(|stream| stream.bytes).max_by_key(Vec::len).unwrap();
    let mut all = 0;
    for (name, bytes, format) in [
        ("gofree", read("tests/data/nav/gofree_merrimac_400.nmea"), FileFormat::Nmea),
        ("plaka", [sentence("GPZDA,095558,01,07,2014,00,00").as_bytes(), &plaka].concat(), FileFormat::Nmea),
        ("cart", read("configs/tracks/cart.inspvax"), FileFormat::Inspvax),
        ("cart", read("configs/tracks/cart.inspvax"), FileFormat::Nmea),
        ("span", span, FileFormat::Inspvax),
    ] {
        let source = FileSource { format, ..sources::nmea(name) };
        let wanted = replay::parse(&bytes, &source).unwrap().fixes;
        for lengths in [&[1][..], &[7, 1, 300], &[4096]] {
            let (reported, last) = decoded(&cut(&bytes, lengths), source.max_gap_s);
            // The epoch of a sentence waits for the next, a log without headings for as long as it may.
            println!("{name}: {} fixes, {} of them at the end", wanted.len(), last.len());
            assert!(same(&[reported, last].concat(), &wanted), "{name}");
        }
        all += wanted.len();
    }
    assert!(all > 600, "{all}");
}

/// INSPVAX is reported with its last byte, an epoch of sentences with the next one.
#[test]
fn latency_of_messages() {
    let mut reported = Vec::new();
    let mut received = decoder(10.0);
    received.push(&epoch(0), &mut |fix| reported.push(fix));
    assert_eq!(seconds(&reported), [] as [f64; 0]);
    // The first sentence of the next epoch.
    let next = epoch(1);
    let first = next.iter().position(|byte| *byte == b'\n').unwrap() + 1;
    received.push(&next[..first - 1], &mut |fix| reported.push(fix));
    assert_eq!(reported.len(), 0);
    received.push(&next[first - 1..first], &mut |fix| reported.push(fix));
    assert_eq!(seconds(&reported), [0.0]);
    let message = inspvax(2);
    received.push(&message[..message.len() - 1], &mut |fix| reported.push(fix));
    received.push(&message[message.len() - 1..], &mut |fix| reported.push(fix));
    assert_eq!(seconds(&reported), [0.0, 1.0, 2.0]);
}

/// Who has no height and no heading waits for them once, as long as it may, and then no longer.
#[test]
fn what_never_comes_is_not_waited_for_twice() {
    let rmc = |second: u32| message_of(second, &Format::Nmea(vec![Sentence::Rmc]));
    let mut decoder = decoder(3.0);
    let mut reported = Vec::new();
    let mut after = Vec::new();
    for second in 0..8 {
        decoder.push(&rmc(second), &mut |fix| reported.push(fix));
        after.push(reported.len());
    }
    // Epoch n is closed by n + 1; epoch 4 is the first more than 3 s after epoch 0.
    assert_eq!(after, [0, 0, 0, 0, 0, 5, 6, 7]);
    assert_eq!((decoder.completion().heights_filled, decoder.completion().headings_filled), (7, 0));
    // A height comes, and is waited for again.
    for second in 8..10 {
        decoder.push(&epoch(second), &mut |fix| reported.push(fix));
    }
    for second in 10..12 {
        decoder.push(&rmc(second), &mut |fix| reported.push(fix));
    }
    assert_eq!(reported.len(), 10);
    decoder.push(&[epoch(12), epoch(13)].concat(), &mut |fix| reported.push(fix));
    assert_eq!(reported.len(), 13);
    // In between: 1246.8 + 41 m is not known at 10 s, but 1 m a second is.
    let height_m = |fix: &Fix| match fix.place {
        nereus::nav::Place::Geodetic(place) => place.h_m,
        place => panic!("{place:?}"),
    };
    assert_eq!(height_m(&reported[7]), 41.0);
    // Two digits of 1e-5 m each, and the separation's 1e-4 m.
    assert!((height_m(&reported[10]) - height_m(&reported[9]) - 1.0).abs() < 1.5e-4);
    assert!(reported[10].yaw_pitch_roll_rad.is_some() && reported[6].yaw_pitch_roll_rad.is_none());
}

#[test]
fn clocks_that_step() {
    let mut decoder = decoder(10.0);
    let mut reported = Vec::new();
    // Back by 2 and 0 s: out of order. Back by 20 s: steps. 60 s ahead, alone: a step. From 100 on: believed
    // with the second.
    for second in [30, 31, 29, 31, 11, 12, 32, 92, 33, 100, 99, 101, 80, 102] {
        decoder.push(&inspvax(second), &mut |fix| reported.push(fix));
    }
    assert_eq!(seconds(&reported), [30.0, 31.0, 32.0, 33.0, 100.0, 101.0, 102.0]);
    let counts = decoder.completion();
    // 29, 31 and 99; 11, 12, 92 and 80.
    assert_eq!((counts.out_of_order, counts.clock_steps), (3, 4));
}

/// A wrong time stamp costs its own fix, and one that is believed two more.
#[test]
fn wrong_stamps_cost_little() {
    let read = |order: &[u32]| {
        let mut decoder = decoder(1.0);
        let mut reported = Vec::new();
        order.iter().for_each(|second| decoder.push(&inspvax(*second), &mut |fix| reported.push(fix)));
        let counts = decoder.completion();
        (seconds(&reported), counts.out_of_order, counts.clock_steps)
    };
    // 3 s ahead, less than two talkers may differ: it is the one that follows that counts.
    assert_eq!(read(&[30, 31, 34, 32, 33, 34, 35]), (vec![30.0, 31.0, 32.0, 33.0, 34.0, 35.0], 0, 1));
    // Two messages of another hour confirm each other; the third that follows from the old time on is
    // believed again.
    let reported = vec![30.0, 31.0, 91.0, 92.0, 34.0, 35.0];
    assert_eq!(read(&[30, 31, 91, 92, 32, 33, 34, 35]), (reported, 0, 3));
}

/// What waits is bounded by number where it is not by time.
#[test]
fn not_more_than_so_many_wait() {
    const MOST: u64 = 16_384;
    let at = |tenth: i64, day: Option<i64>| {
        let mut epoch = Epoch::default();
        (epoch.time_of_day_ns, epoch.day) = (tenth * 100_000_000, day);
        (epoch.position_deg, epoch.altitude_m) = (Some([53.0, 4.5]), Some(1.0));
        epoch
    };
    let completer = || Completer::for_stream(VerticalDatum::Ellipsoid, 0.0, 86_400.0, true);
    let fixes = |completer: &mut Completer, epoch: Epoch| {
        let mut fixes = 0;
        completer.push(epoch, &mut |reported| fixes += u64::from(matches!(reported, Reported::Fix(_))));
        fixes
    };
    // No message has a heading.
    let mut headless = completer();
    let reported: Vec<u64> = (0..20_000).map(|n| fixes(&mut headless, at(n, Some(17_000)))).collect();
    let full = MOST as usize;
    assert!(reported[..full].iter().all(|fixes| *fixes == 0));
    assert_eq!(reported[full], MOST + 1);
    assert!(reported[full + 1..].iter().all(|fixes| *fixes == 1));
    // No message has the date, until one does.
    let mut undated = completer();
    for n in 0..20_000 {
        assert_eq!(fixes(&mut undated, at(n, None)), 0);
    }
    assert_eq!(undated.counts().undated, 20_000 - MOST);
    assert_eq!(fixes(&mut undated, at(20_000, Some(17_000))), MOST + 1);
}

/// What a feed passes on, and the feed.
struct Listening {
    feed: Feed,
    from: Receiver<ReceivedFix>,
}

impl Listening {
    fn open(origin: Origin) -> Self {
        let (to, from) = channel();
        let deliver = move |received| {
            let _ = to.send(received);
        };
        Self { feed: Feed::open(&source(origin), "ship", start(), deliver).unwrap(), from }
    }

    /// Waits for counts.
    fn until(&self, what: impl Fn(&FeedCounts) -> bool) -> FeedCounts {
        let begun = Instant::now();
        loop {
            let counts = self.feed.counts();
            if what(&counts) {
                return counts;
            }
            assert!(begun.elapsed() < TIMEOUT, "{counts:?}");
            sleep(Duration::from_millis(2));
        }
    }

    /// The next fixes, so many.
    fn next(&self, count: usize) -> Vec<f64> {
        let fixes: Vec<Fix> = (0..count).map(|_| self.from.recv_timeout(TIMEOUT).unwrap().fix).collect();
        seconds(&fixes)
    }

    fn is_silent(&self) -> bool {
        matches!(self.from.recv_timeout(Duration::from_millis(100)), Err(RecvTimeoutError::Timeout))
    }
}

#[cfg(all(unix, feature = "serial"))]
mod terminals {
    use std::os::unix::fs::symlink;

    use serialport::{SerialPort, TTYPort};

    use super::*;

    fn port(path: &Path) -> Origin {
        Origin::Serial { path: path.to_owned(), baud: 115_200 }
    }

    #[test]
    fn garbage_and_half_sentences_on_a_port() {
        let (mut to, port_of) = TTYPort::pair().unwrap();
        let reported = Listening::open(port(Path::new(&port_of.name().unwrap())));
        let gga = message_of(1, &Format::Nmea(vec![Sentence::Gga]));
        let wrong = String::from_utf8(gga.clone()).unwrap().replace("GPGGA,1840", "GPGGA,1849");
        let stream = [
            b"\x00\xFF noise\r\n".as_slice(),
            &epoch(0),
            &gga[..30],
            b"\r\n",
            &epoch(1),
            wrong.as_bytes(),
            &inspvax(2),
            &gga[40..],
            b"$PGRME,15.0,M,22.5,M,15.0,M*1B\r\n",
            &epoch(3),
        ]
        .concat();
        for piece in cut(&stream, &[5, 200, 1]) {
            to.write_all(piece).unwrap();
        }
        let counts = reported.until(|counts| counts.bytes == stream.len() as u64);
        assert_eq!(reported.next(3), [0.0, 1.0, 2.0]);
        assert!(reported.is_silent());
        // Three epochs of seven sentences, and INSPVAX.
        assert_eq!((counts.good, counts.fixes), (22, 3));
        // The noise, half a GGA, the other half.
        assert_eq!((counts.malformed, counts.bad_checksum, counts.unknown), (3, 1, 1));
        assert_eq!((counts.out_of_order, counts.clock_steps, counts.void), (0, 0, 0));
        assert!(counts.connected && counts.vanished == 0);
        assert_eq!(counts.last_fix, Some(solution_of(2).time));
    }

    #[test]
    fn a_port_that_vanishes_is_opened_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gps");
        let (mut to, first) = TTYPort::pair().unwrap();
        symlink(first.name().unwrap(), &path).unwrap();
        let reported = Listening::open(port(&path));
        // The second epoch breaks off.
        let begun = [epoch(0), inspvax(1), epoch(2)[..40].to_vec()].concat();
        to.write_all(&begun).unwrap();
        reported.until(|counts| counts.bytes == begun.len() as u64);
        assert_eq!(reported.next(2), [0.0, 1.0]);
        std::fs::remove_file(&path).unwrap();
        drop((to, first));
        let counts = reported.until(|counts| counts.vanished == 1);
        assert!(!counts.connected && counts.malformed == 1, "{counts:?}");
        let (mut to, second) = TTYPort::pair().unwrap();
        symlink(second.name().unwrap(), &path).unwrap();
        reported.until(|counts| counts.connected);
        to.write_all(&[epoch(3), epoch(4)].concat()).unwrap();
        assert_eq!(reported.next(1), [3.0]);
        let counts = reported.until(|counts| counts.good == 7 + 1 + 14);
        assert_eq!((counts.vanished, counts.reopened, counts.bad_checksum), (1, 1, 0));
        assert_eq!((counts.malformed, counts.fixes), (1, 3));
    }

    #[test]
    fn a_port_ends_at_once() {
        let (_to, port_of) = TTYPort::pair().unwrap();
        ends_at_once(&port(Path::new(&port_of.name().unwrap())));
    }
}

/// A read waits 40 ms. Of three tries the shortest, because others use the machine too.
fn ends_at_once(origin: &Origin) {
    let shortest = (0..3).map(|_| {
        let reported = Listening::open(origin.clone());
        sleep(Duration::from_millis(10));
        let begun = Instant::now();
        drop(reported.feed);
        begun.elapsed()
    });
    let shortest = shortest.min().unwrap();
    assert!(shortest < Duration::from_millis(200), "{shortest:?}");
}

#[test]
fn every_origin_ends_at_once() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let nobody = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let any: SocketAddr = "127.0.0.1:0".parse().unwrap();
    ends_at_once(&Origin::TcpConnect(listener.local_addr().unwrap()));
    ends_at_once(&Origin::TcpConnect(nobody));
    // Documentation addresses answer nobody.
    ends_at_once(&Origin::TcpConnect("192.0.2.1:5000".parse().unwrap()));
    ends_at_once(&Origin::TcpListen(any));
    ends_at_once(&Origin::Udp(any));
    ends_at_once(&Origin::File(sources::repository("configs/tracks/cart.inspvax")));
}

#[test]
fn a_sender_that_closes_and_listens_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let reported = Listening::open(Origin::TcpConnect(address));
    let (mut to, _) = listener.accept().unwrap();
    let begun = [inspvax(0), inspvax(1)[..100].to_vec()].concat();
    to.write_all(&begun).unwrap();
    assert_eq!(reported.next(1), [0.0]);
    reported.until(|counts| counts.bytes == begun.len() as u64);
    drop((to, listener));
    let counts = reported.until(|counts| counts.vanished == 1);
    assert!(!counts.connected);
    let listener = TcpListener::bind(address).unwrap();
    let (mut to, _) = listener.accept().unwrap();
    // Whatever was half is gone: the first message is whole.
    to.write_all(&[inspvax(2), inspvax(3)].concat()).unwrap();
    assert_eq!(reported.next(2), [2.0, 3.0]);
    let counts = reported.feed.counts();
    assert_eq!((counts.vanished, counts.reopened, counts.good, counts.connected), (1, 1, 3, true));
    // Silence is nothing but silence.
    assert!(reported.is_silent());
    assert!(reported.feed.counts() == counts);
}

#[test]
fn one_sender_at_a_time() {
    // A port that is free a moment before.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let reported = Listening::open(Origin::TcpListen(address));
    assert!(!reported.feed.counts().connected);
    let mut first = TcpStream::connect(address).unwrap();
    first.write_all(&inspvax(0)).unwrap();
    assert_eq!(reported.next(1), [0.0]);
    let mut second = TcpStream::connect(address).unwrap();
    reported.until(|counts| counts.refused == 1);
    let _ = second.write_all(&inspvax(7));
    first.write_all(&inspvax(1)).unwrap();
    assert_eq!(reported.next(1), [1.0]);
    drop(first);
    reported.until(|counts| counts.vanished == 1);
    let mut third = TcpStream::connect(address).unwrap();
    third.write_all(&inspvax(2)).unwrap();
    assert_eq!(reported.next(1), [2.0]);
    let counts = reported.feed.counts();
    assert_eq!((counts.reopened, counts.refused, counts.good, counts.malformed), (1, 1, 3, 0));
}

#[test]
fn datagrams_are_received() {
    let address = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let reported = Listening::open(Origin::Udp(address));
    let from = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut sent = 0;
    // A message in two, an empty one, the longest.
    let message = inspvax(1);
    let longest = [vec![b'x'; 65_000], b"\n".to_vec()].concat();
    for datagram in [&inspvax(0)[..], &message[..50], &message[50..], b"", &longest, &inspvax(2)] {
        from.send_to(datagram, address).unwrap();
        sent += datagram.len() as u64;
    }
    assert_eq!(reported.next(3), [0.0, 1.0, 2.0]);
    let counts = reported.feed.counts();
    // 65001 bytes without a line end: 15 whole pieces of 4096 and the rest.
    assert_eq!((counts.bytes, counts.good, counts.malformed), (sent, 3, 16));
}

#[test]
fn a_file_is_replayed_in_time() {
    let path = sources::repository("configs/tracks/cart.inspvax");
    let whole =
        replay::load(&FileSource { format: FileFormat::Inspvax, ..sources::nmea(path.to_str().unwrap()) });
    let whole = whole.unwrap().fixes;
    let from = TimeTag::from_iso8601("2014-11-24T20:30:34.35Z").unwrap();
    let (to, reported) = channel();
    let opened = Instant::now();
    let feed = Feed::open(&source(Origin::File(path.clone())), "cart", from, move |received: ReceivedFix| {
        let _ = to.send(received);
    })
    .unwrap();
    // From 10 s before: 200 at once, of which the last is that of `from`, then ten in half a second.
    let received: Vec<ReceivedFix> = (0..211).map(|_| reported.recv_timeout(TIMEOUT).unwrap()).collect();
    let fixes: Vec<Fix> = received.iter().map(|received| received.fix).collect();
    assert!(same(&fixes, &whole[whole.len() - 211..]));
    for received in &received {
        let due_s = received.fix.time.since(from);
        assert!((received.arrived - opened).as_secs_f64() >= due_s, "{due_s}");
    }
    assert!(opened.elapsed() >= Duration::from_millis(500));
    let ended = Instant::now();
    while feed.counts().connected {
        assert!(ended.elapsed() < TIMEOUT);
        sleep(Duration::from_millis(1));
    }
    let counts = feed.counts();
    assert_eq!((counts.good, counts.fixes, counts.vanished), (300, 211, 0));
    assert_eq!(counts.last_fix, whole.last().map(|fix| fix.time));
    let text = serde_json::to_string(&counts).unwrap();
    assert!(text.contains("\"last_fix\":\"2014-11-24T20:30:34.850000Z\""), "{text}");
    // Without a begin its own begin counts.
    let (to, reported) = channel();
    let feed = Feed::open(&source(Origin::File(path)), "cart", None, move |received: ReceivedFix| {
        let _ = to.send(received.fix);
    })
    .unwrap();
    assert!(same(&[reported.recv_timeout(TIMEOUT).unwrap()], &whole[..1]));
    drop(feed);
    assert!(reported.iter().count() < 250);
}

#[test]
fn what_cannot_be_opened_is_reported() {
    let refused =
        |origin: Origin| -> FeedError { Feed::open(&source(origin), "ship", start(), |_| {}).unwrap_err() };
    let file = refused(Origin::File("no/such.nmea".into())).to_string();
    assert!(file.starts_with("live navigation of \"ship\": cannot open file no/such.nmea: "), "{file}");
    assert!(refused(Origin::File(sources::repository("configs"))).to_string().ends_with("not a file"));
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let text = refused(Origin::TcpListen(address)).to_string();
    assert!(text.contains(&format!("tcp-listen://{address}: ")), "{text}");
    let serial = |path: &Path| refused(Origin::Serial { path: path.to_owned(), baud: 9600 }).to_string();
    let text = serial(&sources::repository("Cargo.toml"));
    let wanted =
        if cfg!(feature = "serial") { "not a port; for a file write file:PATH" } else { "feature `serial`" };
    assert!(text.contains(wanted), "{text}");
    assert!(serial(Path::new("/no/such/port")).contains("/no/such/port at 9600 baud: "));
}

/// Parts of a stream: some sentences of an epoch, INSPVAX, garbage. Seconds grow by 0 to 3.
fn any_stream() -> impl Strategy<Value = Vec<u8>> {
    let garbage = prop_oneof![
        Just(Vec::new()),
        proptest::collection::vec(any::<u8>(), 0..30),
        proptest::collection::vec(
            proptest::sample::select(b"\xAA\x44\x12\x13$!#*,;\r\n0A".as_slice()),
            0..30
        ),
    ];
    let part = (0u32..4, 0u32..160, any::<u8>(), garbage);
    proptest::collection::vec(part, 1..12).prop_map(|parts| {
        let (mut second, mut stream) = (0, Vec::new());
        for (step, which, order, garbage) in parts {
            second += step;
            if which < 128 {
                let mut sentences: Vec<Sentence> = Sentence::ALL.to_vec();
                sentences.rotate_left(usize::from(order) % 7);
                for (place, sentence) in sentences.into_iter().enumerate() {
                    if which & (1 << place) != 0 {
                        stream.extend(message_of(second, &Format::Nmea(vec![sentence])));
                    }
                }
            } else {
                let format = if order & 1 == 0 { Format::InspvaxAscii } else { Format::InspvaxBinary };
                stream.extend(message_of(second, &format));
            }
            stream.extend(garbage);
        }
        stream
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(512) })]

    /// However it is cut, a stream gives the bits of its file: at once what it can, the rest at the end.
    #[test]
    fn any_stream_gives_the_fixes_of_its_file(stream in any_stream(), lengths in proptest::collection::vec(1usize..200, 1..20)) {
        // Nothing lasts longer than 33 s, so nobody waits too long.
        let source = FileSource { max_gap_s: 60.0, ..sources::nmea("t") };
        let (reported, last) = decoded(&cut(&stream, &lengths), source.max_gap_s);
        let all = [reported.clone(), last].concat();
        match nmea::parse(&stream, &source) {
            Ok(recording) => prop_assert!(same(&all, &recording.fixes), "{:?} {:?}", all, recording.fixes),
            Err(NavError::NoFix { .. }) => prop_assert!(all.is_empty()),
            Err(_) => prop_assert!(all.len() < 2, "{:?}", all),
        }
        let (again, _) = decoded(&[&stream], source.max_gap_s);
        prop_assert!(same(&reported, &again));
    }

    /// Times increase whatever comes, and nothing panics.
    #[test]
    fn any_bytes_give_fixes_in_order(
        parts in proptest::collection::vec((0u32..200, proptest::collection::vec(any::<u8>(), 0..20)), 0..40),
        wait_s in prop_oneof![Just(f64::MIN_POSITIVE), 0.1..50.0f64, Just(86_400.0)],
    ) {
        let mut stream = Vec::new();
        for (second, garbage) in parts {
            stream.extend(if second % 3 == 0 { inspvax(second) } else { message_of(second, &Format::Nmea(vec![Sentence::ALL[second as usize % 7]])) });
            stream.extend(garbage);
        }
        let (reported, last) = decoded(&[&stream], wait_s);
        let all = [reported, last].concat();
        // In order, but where a clock that stepped is believed.
        let mut steps = all.windows(2).map(|pair| pair[1].time.since(pair[0].time));
        prop_assert!(steps.all(|step_s| !(-5.0..=0.0).contains(&step_s)));
    }
}
