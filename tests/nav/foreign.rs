//! What real receivers do to logs: read, set right, or counted; in files and live.

use nereus::frames::{Earth, SceneFrame};
use nereus::motion::Track;
use nereus::nav::decode::{Content, Counts, Decoder};
use nereus::nav::encode::Format;
use nereus::nav::live::FixDecoder;
use nereus::nav::{
    AttitudeSource, FileFormat, FileSource, Fix, Place, Recording, TrackSource, VerticalDatum, nmea, replay,
};

use crate::sentences::solution_of;
use crate::sources::{self, sentence};

fn read(text: &str) -> Recording {
    nmea::parse(text.as_bytes(), &sources::nmea("log.nmea")).unwrap()
}

fn streamed(text: &str) -> (Vec<Fix>, FixDecoder) {
    let mut decoder = FixDecoder::new(VerticalDatum::MeanSeaLevel, 41.0, AttitudeSource::Recorded, 10.0);
    let mut fixes = Vec::new();
    decoder.push(text.as_bytes(), &mut |fix| fixes.push(fix));
    decoder.finish(&mut |fix| fixes.push(fix));
    (fixes, decoder)
}

fn position_deg(fix: &Fix) -> [f64; 3] {
    let Place::Geodetic(place) = fix.place else { panic!("not geodetic") };
    [place.lat_rad.to_degrees(), place.lon_rad.to_degrees(), place.h_m]
}

/// A position at a second of the day, moving north by 0.03 minutes (56 m) each.
fn gga(time: &str, minutes: f64) -> String {
    sentence(&format!("GPGGA,{time},54{minutes:08.5},N,01000.00000,E,1,09,1.0,300.0,M,42.0,M,,"))
}

fn rmc(time: &str, minutes: f64, date: &str) -> String {
    sentence(&format!("GPRMC,{time},A,54{minutes:08.5},N,01000.00000,E,97.2,0.0,{date},,,A"))
}

fn clock(second: u32) -> String {
    format!("{:02}{:02}{:02}", second / 3600 % 24, second / 60 % 60, second % 60)
}

/// Before: 100 degrees East, and 54 decimal degrees as 54 degrees and half a minute.
#[test]
fn minutes_are_the_two_digits_before_the_point() {
    let at = |lon: &str| sentence(&format!("GPRMC,120000,A,5400.0,N,{lon},E,1.0,0.0,010524,,,A"));
    for (lon, expected) in [
        ("1000.05", Some(10.0 + 0.05 / 60.0)),
        ("01000.05", Some(10.0 + 0.05 / 60.0)),
        ("930.0", Some(9.5)),
        ("17959", Some(179.0 + 59.0 / 60.0)),
        ("10.5", None),
        ("0.5", None),
        ("01060.0", None),
        ("001000.05", None),
    ] {
        let mut found = None;
        let mut decoder = Decoder::new();
        let mut see = |message: nereus::nav::decode::Message| {
            let Content::Rmc(rmc) = message.content else { panic!("{message:?}") };
            found = rmc.fix.map(|fix| fix.lon_deg);
        };
        decoder.push(at(lon).as_bytes(), &mut see);
        assert_eq!(found, expected, "{lon}");
        assert_eq!(decoder.counts().malformed, u64::from(expected.is_none()), "{lon}");
    }
}

/// Ends of lines of every kind, cut at every byte.
#[test]
fn a_line_ends_with_cr_lf_or_both() {
    let log: String = (0..5).map(|k| rmc(&clock(43_200 + k), f64::from(k), "010524")).collect();
    let found = |log: &str, piece: usize| {
        let (mut decoder, mut messages) = (Decoder::new(), Vec::new());
        for piece in log.as_bytes().chunks(piece) {
            decoder.push(piece, &mut |message| messages.push(message.content));
        }
        decoder.finish(&mut |message| messages.push(message.content));
        (messages, *decoder.counts())
    };
    let expected = found(&log, log.len());
    assert_eq!((expected.0.len(), expected.1.lines), (5, 5));
    for ends in ["\r", "\n"] {
        let log = log.replace("\r\n", ends);
        for piece in 1..80 {
            assert_eq!(found(&log, piece), expected, "{ends:?} in pieces of {piece}");
        }
    }
}

/// Two talkers, whichever comes first; the one without a height takes none away.
#[test]
fn positions_are_of_one_talker() {
    for order in [[0, 1], [1, 0]] {
        let log: String = (0..20)
            .map(|k| {
                let time = clock(43_200 + k);
                let own = gga(&time, 0.03 * f64::from(k));
                let other = own.replace("$GPGGA", "$IIGGA").replace("300.0,M,42.0,M", ",M,,M");
                let other = sentence(&other[1..other.len() - 5]);
                let both = [own, other];
                rmc(&time, 0.03 * f64::from(k), "010524").repeat(usize::from(k == 0))
                    + &order.map(|i| both[i].clone()).concat()
            })
            .collect();
        let recording = read(&log);
        assert_eq!(recording.report.other_talkers, 20, "{order:?}");
        assert_eq!(recording.fixes.len(), 20);
        assert!(recording.fixes.iter().all(|fix| (position_deg(fix)[2] - 342.0).abs() < 1e-9), "{order:?}");
        assert_eq!(streamed(&log).0, recording.fixes);
    }
    // A date is taken from whoever has one.
    let log: String = (0..20)
        .map(|k| {
            let other = rmc(&clock(43_200 + k), 3.0, "010524").replace("$GPRMC", "IIRMC");
            gga(&clock(43_200 + k), 0.03 * f64::from(k)) + &sentence(&other[..other.len() - 5])
        })
        .collect();
    let recording = read(&log);
    assert_eq!(recording.fixes[19].time.to_string(), "2024-05-01T12:00:19.000000Z");
    assert!((position_deg(&recording.fixes[19])[0] - (54.0 + 0.57 / 60.0)).abs() < 1e-9);
    // GP and GN are one receiver.
    let log: String = (0..20)
        .map(|k| {
            let own = rmc(&clock(43_200 + k), 0.03 * f64::from(k), "010524");
            if k % 2 == 0 { own } else { sentence(&own.replace("$GPRMC", "GNRMC")[..own.len() - 6]) }
        })
        .collect();
    let report = read(&log).report;
    assert_eq!((report.fixes, report.other_talkers), (20, 0));
}

/// The date of a receiver that is a second or more behind or ahead of midnight.
#[test]
fn a_date_that_changes_late_or_early_is_set_right() {
    for late in [-2_i32, -1, 0, 1, 5, 30] {
        let log: String = (-60..60)
            .map(|k: i32| {
                let second = (86_400 + k) as u32;
                rmc(&clock(second), 0.01 * f64::from(k + 60), if k < late { "300424" } else { "010524" })
            })
            .collect();
        let recording = read(&log);
        assert_eq!(recording.report.dates_corrected, u64::from(late.unsigned_abs()), "{late}");
        assert_eq!((recording.fixes.len(), recording.report.span_s), (120, 119.0), "{late}");
        assert_eq!(recording.fixes[0].time.to_string(), "2024-04-30T23:59:00.000000Z");
        assert_eq!(streamed(&log).0, recording.fixes, "{late}");
    }
}

/// A cold start, and weeks that have rolled over: left, counted and said.
#[test]
fn steps_of_the_clock_do_not_refuse_a_log() {
    for (date, hint) in
        [("060180", "step of the clock"), ("150904", "1024 weeks"), ("010538", "step of the clock")]
    {
        let log: String = (0..60)
            .map(|k| rmc(&clock(43_200 + k), 0.03 * f64::from(k), if k < 8 { date } else { "010524" }))
            .collect();
        let recording = read(&log);
        let report = &recording.report;
        assert_eq!((report.fixes, report.clock_steps), (52, 8), "{date}: {report}");
        assert!(report.to_string().contains(hint), "{date}: {report}");
        assert_eq!(recording.fixes[0].time.to_string(), "2024-05-01T12:00:08.000000Z");
    }
}

/// The day of a log is that of its source, whatever its messages say, in files and live.
#[test]
fn the_source_gives_the_date() {
    let log: String = (0..20).map(|k| gga(&clock(86_390 + k), 0.03 * f64::from(k))).collect();
    let wrong: String = (0..20).map(|k| rmc(&clock(86_390 + k), 0.03 * f64::from(k), "150904")).collect();
    let source = FileSource { first_day: Some(19_843), ..sources::nmea("log.nmea") };
    for log in [log, wrong] {
        let recording = nmea::parse(log.as_bytes(), &source).unwrap();
        assert_eq!(recording.fixes[0].time.to_string(), "2024-04-30T23:59:50.000000Z");
        assert_eq!(recording.report.span_s, 19.0);
        let decoder = FixDecoder::new(VerticalDatum::MeanSeaLevel, 41.0, AttitudeSource::Recorded, 10.0);
        let (mut decoder, mut fixes) = (decoder.dated(Some(19_843)), Vec::new());
        decoder.push(log.as_bytes(), &mut |fix| fixes.push(fix));
        decoder.finish(&mut |fix| fixes.push(fix));
        assert_eq!(fixes, recording.fixes);
    }
}

/// Over the leap second at the end of 2016: by sentences with the label 60, and by GPS time. Before: the
/// second was left out, and what moves at 56 m/s did 112.
#[test]
fn motion_goes_on_over_a_leap_second() {
    let labels = (0..10).map(|k| (format!("2359{:02}", 50 + k), "311216"));
    let leap = std::iter::once(("235960".to_owned(), "311216"));
    let behind = (0..10).map(|k| (format!("0000{k:02}"), "010117"));
    let log: String = labels
        .chain(leap)
        .chain(behind)
        .zip(0..)
        .map(|((time, date), k)| rmc(&time, 0.03 * f64::from(k), date))
        .collect();
    let recording = read(&log);
    assert_eq!(recording.fixes.len(), 21);
    assert!(recording.fixes.windows(2).all(|pair| pair[1].time.since(pair[0].time) == 1.0));
    assert!(recording.report.to_string().contains("a leap second lies within"), "{}", recording.report);
    assert_eq!(streamed(&log).0, recording.fixes);

    // GPS week 1930 began on 2017-01-01, 17 s before midnight of UTC.
    let records: Vec<u8> = (0..30)
        .flat_map(|k| {
            let mut figures = [0.0; 17];
            figures[..4].copy_from_slice(&[f64::from(k), 0.9, 0.1 + 1e-5 * f64::from(k), 300.0]);
            figures
        })
        .flat_map(f64::to_le_bytes)
        .collect();
    let source = FileSource { format: FileFormat::Sbet { gps_week: 1930 }, ..sources::nmea("t.sbet") };
    let recording = replay::parse(&records, &source).unwrap();
    assert_eq!(recording.fixes[0].time.to_string(), "2016-12-31T23:59:43.000000Z");
    assert!(recording.fixes.windows(2).all(|pair| pair[1].time.since(pair[0].time) == 1.0));
}

/// One position a minute of arc away: before, the track flew there and back at 7,137 m/s^2.
#[test]
fn a_spike_of_a_recorded_track_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.nmea");
    for spike in [0_u32, 12, 29] {
        let log: String = (0..30)
            .map(|k| {
                rmc(&clock(43_200 + k), 0.03 * f64::from(k) + if k == spike { 1.0 } else { 0.0 }, "010524")
            })
            .collect();
        std::fs::write(&path, log).unwrap();
        let source = TrackSource::File(FileSource {
            attitude: AttitudeSource::Level,
            ..sources::nmea(path.to_str().unwrap())
        });
        let frame = SceneFrame::at(nereus::frames::Geodetic::from_deg(54.0, 10.0, 0.0), Earth::Flat);
        let start = nereus::time::TimeTag::default();
        let (_, report) = Track::from_source(&source, &frame, start).unwrap();
        let fit = report.unwrap().fit;
        assert_eq!((fit.refused.implausible, fit.fixes), (1, 29), "{spike}");
        assert!(fit.max_acceleration_mps2 < 1.0, "{spike}: {}", fit.max_acceleration_mps2);
    }
}

/// Two antennas 11 m apart whose positions take turns.
#[test]
fn two_antennas_are_warned_of() {
    let log = |apart: f64| -> String {
        (0..40)
            .map(|k| rmc(&clock(43_200 + k), 0.03 * f64::from(k) + apart * f64::from(k % 2), "010524"))
            .collect()
    };
    let report = read(&log(0.006)).report.to_string();
    assert!(report.contains("positions alternate between two places 11.1 m apart"), "{report}");
    assert!(!read(&log(0.0)).report.to_string().contains("alternate"));
}

/// What an instrument sends a second after garbage that announces 16,000 bytes.
#[test]
fn garbage_that_announces_a_message_holds_nothing_up() {
    let header = |id: u16, body: u16| {
        let mut header = vec![0xAA, 0x44, 0x12, 28];
        header.extend(id.to_le_bytes());
        header.extend([0, 0]);
        header.extend(body.to_le_bytes());
        header.resize(28, 0);
        header
    };
    let log: String = (0..400).map(|k| gga(&clock(43_200 + k), 0.01 * f64::from(k))).collect();
    let mut inspvax = Vec::new();
    (0..40).for_each(|second| Format::InspvaxBinary.write(&solution_of(second), &mut inspvax).unwrap());
    let mut ascii = Vec::new();
    (0..40).for_each(|second| Format::InspvaxAscii.write(&solution_of(second), &mut ascii).unwrap());
    for (what, stream, most_bytes) in [
        // A message that is read has its own length.
        ("INSPVAX of 16,000 bytes", [header(1465, 16_000), log.clone().into_bytes()].concat(), 28 + 100),
        // Of another one two sentences after the first line must have come.
        ("message of 16,000 bytes", [header(43, 16_000), log.into_bytes()].concat(), 28 + 300),
        ("message before INSPVAX", [header(43, 16_000), inspvax].concat(), 28 + 200),
        ("message before INSPVAXA", [header(43, 16_000), ascii].concat(), 28 + 1000),
    ] {
        let decode = |piece: usize| {
            let (mut decoder, mut messages, mut first) = (Decoder::new(), Vec::new(), None);
            for (index, bytes) in stream.chunks(piece).enumerate() {
                decoder.push(bytes, &mut |message| {
                    first.get_or_insert((index + 1) * piece);
                    messages.push(message);
                });
            }
            decoder.finish(&mut |message| messages.push(message));
            (messages, *decoder.counts(), first.unwrap())
        };
        let (messages, counts, first): (_, Counts, _) = decode(1);
        assert!(first <= most_bytes, "{what}: the first message after {first} bytes");
        for piece in [7, 64, 1000, stream.len()] {
            let (others, other_counts, _) = decode(piece);
            assert_eq!((others.len(), other_counts), (messages.len(), counts), "{what} in pieces of {piece}");
            assert_eq!(others, messages, "{what} in pieces of {piece}");
        }
    }
}

/// INSPVAA as text, and its short form; the height is above the ellipsoid.
#[test]
fn inspva_is_read() {
    // The example of the receiver's manual, with the checksum computed here.
    let body = "1695,309428.000000000,51.116378734,-114.038251150,1046.7093,-0.0845,-0.0464,-0.0127,\
                0.138023492,0.069459386,90.000923268,INS_SOLUTION_GOOD";
    for (sign, header) in [
        ('#', "INSPVAA,COM1,0,73.5,FINESTEERING,1695,309428.000,00000040,4e77,43562"),
        ('%', "INSPVASA,1695,309428.000"),
    ] {
        let text = format!("{header};{body}");
        let crc = nereus::nav::decode::novatel::crc32(text.as_bytes());
        let (mut decoder, mut found) = (Decoder::new(), Vec::new());
        decoder.push(format!("{sign}{text}*{crc:08x}\r\n").as_bytes(), &mut |message| {
            found.push(message.content)
        });
        let [Content::Inspva(solution)] = found[..] else { panic!("{found:?}") };
        assert_eq!((solution.altitude_m, solution.undulation_m), (1046.7093, 0.0));
        assert_eq!(solution.angles_deg, [0.138023492, 0.069459386, 90.000923268]);
        assert_eq!(solution.time().unwrap().to_string(), "2012-07-04T13:56:52.000000Z");
    }
    // Abbreviated text has no checksum: it is named.
    let log = "[COM1]<INSPVAX COM1 0 72.5 FINESTEERING 2312 216000.000 00000000 0000 16000\r\n\
               <     INS_SOLUTION_GOOD INS_PSRSP 54.0 10.0 300.0 42.0\r\n";
    let source = FileSource { format: FileFormat::Inspvax, ..sources::nmea("t.gps") };
    let error = replay::parse(log.as_bytes(), &source).unwrap_err().to_string();
    assert!(error.contains("2 lines of abbreviated ASCII logs"), "{error}");
}

/// Times with offsets, and what a data frame writes.
#[test]
fn offsets_and_index_columns_of_tables() {
    let read = |text: &str| replay::parse(text.as_bytes(), &sources::csv("t.csv"));
    let rows = |zone: &str, hour: u32| {
        format!(
            "time_utc,x_m,y_m,z_m\n2024-05-01 {hour:02}:00:00{zone},0,0,0\n2024-05-01 {hour:02}:00:01.5{zone},1,0,0\n"
        )
    };
    for (zone, hour) in [("", 12), ("Z", 12), ("+00:00", 12), ("+02:00", 14), ("-0330", 8)] {
        let recording = read(&rows(zone, hour)).unwrap();
        let expected =
            if zone == "-0330" { "2024-05-01T11:30:00.000000Z" } else { "2024-05-01T12:00:00.000000Z" };
        assert_eq!(recording.fixes[0].time.to_string(), expected, "{zone}");
        assert_eq!(recording.report.span_s, 1.5);
    }
    assert!(read(&rows("+2:00", 12)).is_err());
    let error = read(",time_utc,x_m,y_m,z_m\n0,2024-05-01,0,0,0\n").unwrap_err().to_string();
    assert!(error.contains("column 1 has no name") && error.contains("index=False"), "{error}");
}

/// One sentence each, whatever the number of records.
#[test]
fn an_sbet_in_another_form_is_named() {
    let records = |of: fn(f64) -> [u8; 8], scale: f64| -> Vec<u8> {
        (0..500)
            .flat_map(|k| {
                let mut figures = [0.0; 17];
                let place = [54.0 * scale, (10.0 + 1e-5 * f64::from(k)) * scale, 300.0];
                figures[0] = 302_400.0 + 0.05 * f64::from(k);
                figures[1..4].copy_from_slice(&place);
                figures[9] = 1.0;
                figures
            })
            .flat_map(of)
            .collect()
    };
    let source = FileSource { format: FileFormat::Sbet { gps_week: 2312 }, ..sources::nmea("t.sbet") };
    let error = |bytes: &[u8]| replay::parse(bytes, &source).unwrap_err().to_string();
    let radians = 1f64.to_radians();
    assert_eq!(replay::parse(&records(f64::to_le_bytes, radians), &source).unwrap().fixes.len(), 500);
    let big = error(&records(f64::to_be_bytes, radians));
    assert!(big.starts_with("t.sbet: 1 fault") && big.contains("big-endian"), "{big}");
    let degrees = error(&records(f64::to_le_bytes, 1.0));
    assert!(degrees.starts_with("t.sbet: 1 fault") && degrees.contains("in degrees (54, 10)"), "{degrees}");
}
