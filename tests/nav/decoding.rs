//! The streaming decoder and the assembler: cuts, garbage, order, counts.

use insta::assert_snapshot;
use nereus::nav::VerticalDatum;
use nereus::nav::decode::{Content, Counts, Decoder, Message};
use nereus::nav::encode::{Format, Sentence};
use nereus::nav::epoch::{Assembler, Epoch};
use proptest::prelude::*;

use crate::sentences::solution_of;
use crate::sources::{self, sentence};

/// The example of the receiver's manual, with the checksum printed there.
pub const MANUAL: &str = "#INSPVAXA,COM1,0,73.5,FINESTEERING,1695,309428.000,00000040,4e77,43562;INS_SOLUTION_GOOD,INS_PSRSP,\
                          51.11637873403,-114.03825114994,1063.6093,-16.9000,-0.0845,-0.0464,-0.0127,0.138023492,0.069459386,\
                          90.000923268,0.9428,0.6688,1.4746,0.0430,0.0518,0.0521,0.944295466,0.944567084,1.000131845,3,0*e877c178\r\n";

fn decode(pieces: &[&[u8]]) -> (Vec<Message>, Counts) {
    let (mut decoder, mut messages) = (Decoder::new(), Vec::new());
    for piece in pieces {
        decoder.push(piece, &mut |message| messages.push(message));
    }
    decoder.finish(&mut |message| messages.push(message));
    (messages, *decoder.counts())
}

pub fn assemble(bytes: &[u8]) -> Vec<Epoch> {
    let mut assembler = Assembler::new();
    let mut epochs = Vec::new();
    for message in decode(&[bytes]).0 {
        assembler.push(&message, &mut |epoch| epochs.push(epoch));
    }
    epochs.extend(assembler.finish());
    epochs
}

#[test]
fn the_example_of_the_manual_is_read() {
    let (messages, counts) = decode(&[MANUAL.as_bytes()]);
    assert_eq!((counts.good, counts.bad_checksum, counts.malformed), (1, 0, 0));
    let Content::Inspvax(solution) = messages[0].content else { panic!("{messages:?}") };
    assert_eq!((solution.lat_deg, solution.lon_deg), (51.11637873403, -114.03825114994));
    assert_eq!((solution.altitude_m, solution.undulation_m), (1063.6093, -16.9));
    assert_eq!(solution.angles_deg, [0.138023492, 0.069459386, 90.000923268]);
    // Week 1695 began on 2012-07-01; UTC is 16 s behind GPS time: Wednesday 13:57:08 - 16 s.
    assert_eq!(solution.time().unwrap().to_string(), "2012-07-04T13:56:52.000000Z");
    let epochs = assemble(MANUAL.as_bytes());
    assert_eq!(epochs[0].height_m(VerticalDatum::MeanSeaLevel, 100.0), Some(1063.6093 - 16.9));
    assert_eq!(epochs[0].velocity_mps, Some([-0.0464, -0.0845]));
    // A digit changed.
    let (_, counts) = decode(&[MANUAL.replace("1063.6", "1063.7").as_bytes()]);
    assert_eq!((counts.good, counts.bad_checksum), (0, 1));
}

#[test]
fn sentences_in_garbage_are_found() {
    let hdt = sentence("HEHDT,10.0,T");
    let stream = [
        b"\x00\xAA\x44\xFF garbage \xAA".as_slice(),
        b"\n2014-07-01T09:55:58 ",
        hdt.as_bytes(),
        b"$GPGGA,1200",
        hdt.as_bytes(),
        b"#not a log\r\n",
        MANUAL.as_bytes(),
        // A header that claims 300 bytes, with a sentence among them.
        b"\xAA\x44\x12\x1C\x2B\x00\x00\x20\x2C\x01",
        hdt.as_bytes(),
        &[0; 330],
        b"\r\n",
        hdt.trim_end().as_bytes(),
    ]
    .concat();
    let (messages, counts) = decode(&[&stream]);
    assert_eq!(messages.len(), 5);
    assert_eq!((counts.good, counts.bad_checksum, counts.unknown), (5, 0, 0));
    // The garbage, the cut GGA, the comment, the false header, and the zeros in the line after it.
    assert_eq!(counts.malformed, 5);
}

#[test]
fn memory_is_bounded() {
    let line = vec![b'x'; 1 << 20];
    let (_, counts) = decode(&[&line]);
    assert_eq!(counts.malformed, 256);
    // Headers that claim the most that fits in their field: nothing is waited for.
    let header = [0xAA, 0x44, 0x12, 0x1C, 0xB9, 0x05, 0x00, 0x20, 0xFF, 0xFF];
    let hdt = sentence("HEHDT,10.0,T");
    let (messages, _) = decode(&[&header.repeat(1000), b"\n", hdt.as_bytes()]);
    assert_eq!(messages.len(), 1);
}

/// Messages of one epoch in any order make the same epoch.
#[test]
fn order_within_an_epoch_does_not_matter() {
    let solution = solution_of(3);
    let mut parts: Vec<Vec<u8>> = Sentence::ALL
        .into_iter()
        .map(|sentence| {
            let mut out = Vec::new();
            Format::Nmea(vec![sentence]).write(&solution, &mut out).unwrap();
            out
        })
        .collect();
    let whole = |parts: &[Vec<u8>]| {
        let mut epochs = assemble(&parts.concat());
        assert_eq!(epochs.len(), 1);
        epochs[0].line = 0;
        epochs.remove(0)
    };
    let wanted = whole(&parts);
    assert!(wanted.sigma.position_m.is_some() && wanted.velocity_mps.is_some());
    assert!(wanted.yaw_pitch_roll_rad.is_some() && wanted.day.is_some());
    // VTG and HDT have no time, so something with a time comes first: PASHR, GST, ZDA, RMC, GGA in turn.
    for _ in 0..2 {
        parts.swap(0, 4);
        parts.swap(1, 5);
        parts[2..].rotate_right(1);
        assert_eq!(whole(&parts), wanted);
    }
}

#[test]
fn inspvax_completes_its_epoch_at_once() {
    let solution = solution_of(4);
    let write = |format: Format| {
        let mut out = Vec::new();
        format.write(&solution, &mut out).unwrap();
        out
    };
    let gga = write(Format::Nmea(vec![Sentence::Gga, Sentence::Gst]));
    let ins = write(Format::InspvaxBinary);
    for stream in [[&gga[..], &ins, &gga].concat(), [&ins[..], &gga, &gga].concat()] {
        let (mut decoder, mut assembler) = (Decoder::new(), Assembler::new());
        let mut epochs = 0;
        decoder.push(&stream, &mut |message| assembler.push(&message, &mut |_| epochs += 1));
        assert_eq!(epochs, 1);
        assert_eq!(assembler.finish(), None);
    }
}

#[test]
fn a_solution_marked_invalid_is_void() {
    let (_, counts) = decode(&[MANUAL.as_bytes()]);
    assert_eq!(counts.void, 0);
    let body = MANUAL[1..MANUAL.rfind('*').unwrap()].replace("INS_SOLUTION_GOOD", "INS_ALIGNING");
    let line = format!("#{body}*{:08x}\r\n", nereus::nav::decode::novatel::crc32(body.as_bytes()));
    let (messages, counts) = decode(&[line.as_bytes()]);
    assert_eq!((messages.len(), counts.void), (1, 1));
    assert!(assemble(line.as_bytes()).is_empty());
}

#[test]
fn leap_seconds() {
    // The label of a leap second, and one that is none.
    for (time, good) in [("235960.00", 1), ("225960.00", 0), ("235961.00", 0)] {
        let (_, counts) = decode(&[sentence(&format!("GPZDA,{time},31,12,2016,00,00")).as_bytes()]);
        assert_eq!((counts.good, counts.malformed), (good, 1 - good), "{time}");
    }
    let tag = |week, seconds| nereus::time::TimeTag::from_gps(week, seconds).unwrap();
    // 2017 began at second 18 of week 1930: 17 leap seconds before it, 18 from it on; the leap second itself
    // is 17.
    assert_eq!(tag(1930, 16.0).to_string(), "2016-12-31T23:59:59.000000Z");
    assert_eq!(tag(1930, 18.0).to_string(), "2017-01-01T00:00:00.000000Z");
    assert_eq!(tag(1930, 17.0), tag(1930, 18.0));
    assert_eq!(tag(0, 0.0).to_string(), "1980-01-06T00:00:00.000000Z");
    for (week, seconds) in [(0, 0.0), (1820, 500_000.125), (1930, 16.0), (1930, 18.0), (8191, 604_799.5)] {
        assert_eq!(tag(week, seconds).to_gps(), Some((week, seconds)));
    }
    assert_eq!(nereus::time::TimeTag::from_gps(8192, 0.0), None);
    assert_eq!(nereus::time::TimeTag::from_gps(1, f64::NAN), None);
}

/// What is found in the cuts of real logs.
#[test]
fn counts_of_real_logs() {
    let counts = |file: &str| {
        let bytes = std::fs::read(sources::repository(file)).unwrap();
        let (messages, counts) = decode(&[&bytes]);
        format!("{} messages, {counts:?}", messages.len())
    };
    assert_snapshot!(counts("tests/data/nav/gofree_merrimac_400.nmea"), @r#"37 messages, Counts { lines: 400, good: 37, bad_checksum: 0, unknown: 354, malformed: 9, void: 0, abbreviated: 0, others: "105 AIVDM, 9 GPGSA, 27 GPGSV, 9 GPAAM, 9 GPAPB, 9 GPBOD, 9 GPRMB, 9 GPXTE", begun_within: false }"#);
    assert_snapshot!(counts("tests/data/nav/plaka_700.nmea"), @r#"219 messages, Counts { lines: 700, good: 219, bad_checksum: 0, unknown: 481, malformed: 0, void: 0, abbreviated: 0, others: "44 IIVHW, 44 IIVPW, 44 IIMWV, 44 IIVWT, 44 GPWCV, 44 GPXTE, 44 IIDBT, 44 GPGSV", begun_within: false }"#);
    assert_snapshot!(counts("configs/tracks/cart.inspvax"), @r#"300 messages, Counts { lines: 0, good: 300, bad_checksum: 0, unknown: 0, malformed: 0, void: 0, abbreviated: 0, others: "", begun_within: false }"#);
}

fn any_stream() -> impl Strategy<Value = Vec<Vec<u8>>> {
    let part = prop_oneof![
        (0u32..50, 0usize..7).prop_map(|(second, sentence)| {
            let mut out = Vec::new();
            Format::Nmea(vec![Sentence::ALL[sentence]]).write(&solution_of(second), &mut out).unwrap();
            out
        }),
        (0u32..50, any::<bool>()).prop_map(|(second, ascii)| {
            let mut out = Vec::new();
            let format = if ascii { Format::InspvaxAscii } else { Format::InspvaxBinary };
            format.write(&solution_of(second), &mut out).unwrap();
            out
        }),
        proptest::collection::vec(any::<u8>(), 0..40),
        proptest::collection::vec(
            proptest::sample::select(b"\xAA\x44\x12\x13$!#*,;\r\n0A".as_slice()),
            0..40
        ),
    ];
    proptest::collection::vec(part, 0..30)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(256) })]

    /// However a stream is cut, and whatever stands in it, the messages and counts are the same.
    #[test]
    fn cuts_change_nothing(parts in any_stream(), cuts in proptest::collection::vec(1usize..200, 1..20)) {
        let stream = parts.concat();
        let whole = decode(&[&stream]);
        let mut pieces = Vec::new();
        let mut rest = &stream[..];
        for length in cuts.iter().cycle() {
            let (piece, after) = rest.split_at((*length).min(rest.len()));
            pieces.push(piece);
            rest = after;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(&decode(&pieces), &whole);
        let bytes: Vec<&[u8]> = stream.chunks(1).collect();
        prop_assert_eq!(&decode(&bytes), &whole);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
        assemble(&bytes);
    }

    /// The checksums are right, so that the garbage reaches the figures.
    #[test]
    fn no_figures_make_it_panic(mut body in proptest::collection::vec(any::<u8>(), 154), text in "[-+0-9.A-Z_,]{0,300}") {
        use nereus::nav::decode::novatel::crc32;
        body[..10].copy_from_slice(&[0xAA, 0x44, 0x12, 28, 0xB9, 0x05, 0, 32, 126, 0]);
        // A time within the week: another header is not believed.
        body[19] %= 0x24;
        let mut stream = [&body[..], &crc32(&body).to_le_bytes()].concat();
        let text = format!("INSPVAXA,COM1,0,0.0,FINE,2000,1.5,0,0,0;INS_SOLUTION_GOOD,NONE,{text}");
        stream.extend(format!("#{text}*{:08x}\n", crc32(text.as_bytes())).bytes());
        let (messages, counts) = decode(&[&stream]);
        prop_assert_eq!(counts.bad_checksum, 0);
        for message in messages {
            if let Content::Inspvax(solution) = message.content {
                prop_assert!(solution.lat_deg.abs() <= 90.0 && solution.velocity_mps.iter().all(|v| v.is_finite()));
            }
        }
        assemble(&stream);
    }
}
