//! NMEA 0183 logs, real ones first.

use insta::assert_snapshot;
use nereus::nav::{AttitudeSource, Fix, Place, Recording, VerticalDatum, load, nmea};
use proptest::prelude::*;

use crate::sources::{self, sentence};

fn read(text: &str) -> Recording {
    nmea::parse(text.as_bytes(), &sources::nmea("log.nmea")).unwrap()
}

fn height_m(fix: &Fix) -> f64 {
    let Place::Geodetic(place) = fix.place else { panic!("not geodetic") };
    place.h_m
}

#[test]
fn a_ship_at_its_mooring_among_ais_is_read() {
    let recording = load(&sources::nmea(
        sources::repository("tests/data/nav/gofree_merrimac_400.nmea").to_str().unwrap(),
    ))
    .unwrap();
    let report = &recording.report;
    println!("{report}");
    assert_eq!(recording.fixes.len(), 10);
    assert_eq!((report.lines, report.bad_checksum, report.void_positions), (400, 0, 0));
    // Its ZDA has a year of two digits, which is no ZDA; nine are in the cut.
    assert_eq!(report.malformed, 9);
    assert_eq!(recording.fixes[0].time.to_string(), "2014-04-16T19:57:19.000000Z");
    let Place::Geodetic(place) = recording.fixes[0].place else { panic!("not geodetic") };
    // 5310.8115,N,00525.7025,E, altitude -2 m, no separation: undulation 41 m.
    assert!((place.lat_rad.to_degrees() - (53.0 + 10.8115 / 60.0)).abs() < 1e-12);
    assert!((place.lon_rad.to_degrees() - (5.0 + 25.7025 / 60.0)).abs() < 1e-12);
    assert_eq!(place.h_m, 39.0);
}

#[test]
fn a_log_without_a_date_is_refused() {
    let mut source = sources::nmea("plaka.nmea");
    let bytes = std::fs::read(sources::repository("tests/data/nav/plaka_700.nmea")).unwrap();
    assert_snapshot!(nmea::parse(&bytes, &source).unwrap_err(), @r#"
    plaka.nmea: no usable fix: positions have a time of day but no date: no RMC sentence, and no ZDA sentence with its date filled in; give that of the first position: date = "2024-05-01" (nereus nav: --date 2024-05-01)
      0 fixes over 0.000 s from 700 lines, longest gap 0.000 s; 481 of other kinds skipped; 44 headings or speeds taken for the position after them; found: 44 IIVHW, 44 IIVPW, 44 IIMWV, 44 IIVWT, 44 GPWCV, 44 GPXTE, 44 IIDBT, 44 GPGSV
    "#);

    // The same log with a date in front is a boat under way, with positions to 0.001 minutes.
    let dated = [sentence("GPZDA,095558,01,07,2014,00,00").as_bytes(), &bytes].concat();
    source.max_gap_s = 5.0;
    let recording = nmea::parse(&dated, &source).unwrap();
    println!("{}", recording.report);
    assert_eq!(recording.report.heights_filled as usize, recording.fixes.len());
    assert!(recording.fixes.iter().all(|fix| height_m(fix) == 41.0));
    assert_eq!(recording.fixes[0].time.to_string(), "2014-07-01T09:55:59.000000Z");
}

#[test]
fn corrupt_sentences_are_counted_and_skipped() {
    let mut text = String::new();
    for second in 0..6 {
        text +=
            &sentence(&format!("GPRMC,12000{second},A,5300.{second}00,N,00430.000,E,10.0,0.0,010720,,,A"));
    }
    text += "$GPRMC,120006,A,5300.600,N,00430.000,E,10.0,0.0,010720,,,A*00\r\n";
    text += "$GPRMC,120007,A,5300.700,N\r\nnoise\r\n\r\n$*00\r\n";
    text += &sentence("GPRMC,120008,V,5300.800,N,00430.000,E,10.0,0.0,010720,,,N");
    text += &sentence("GPGGA,120008,,,,,0,00,,,M,,M,,");
    text += &sentence("GPRMC,126109,A,5300.800,N,00430.000,E,10.0,0.0,010720,,,A");
    text += &sentence("GPXYZ,1,2,3");
    text += &sentence("PGRME,15.0,M,22.5,M,15.0,M");
    let report = read(&text).report;
    assert_eq!((report.fixes, report.bad_checksum, report.void_positions), (6, 1, 2));
    assert_eq!((report.malformed, report.unknown_sentences), (3, 3));
    assert_snapshot!(report, @"6 fixes over 5.000 s from 16 lines, longest gap 1.000 s; 1 with a wrong checksum skipped; 3 malformed skipped; 3 of other kinds skipped; 2 void positions skipped; 6 heights filled in");
}

#[test]
fn sentences_of_one_epoch_become_one_fix() {
    let mut text = String::new();
    for second in 0..3 {
        text += &sentence(&format!("GPGLL,5300.{second}00,N,00430.000,E,12000{second}.50,A,A"));
        text += &sentence(&format!(
            "GPGGA,12000{second}.50,5300.{second}05,N,00430.000,E,8,10,0.9,20.0,M,43.5,M,,"
        ));
        text +=
            &sentence(&format!("GPRMC,12000{second}.50,A,5300.{second}00,N,00430.000,E,10.0,0.0,010720,,,A"));
        text += &sentence(&format!("HEHDT,{},T", 359 + second));
    }
    // Only 360 is a heading, 361 is not: the last is held.
    let mut source = sources::nmea("log.nmea");
    for datum in [VerticalDatum::MeanSeaLevel, VerticalDatum::Ellipsoid] {
        source.datum = datum;
        let recording = nmea::parse(text.as_bytes(), &source).unwrap();
        assert_eq!(recording.fixes.len(), 3);
        assert_eq!(recording.report.headings_filled, 1);
        for (second, fix) in recording.fixes.iter().enumerate() {
            let Place::Geodetic(place) = fix.place else { panic!("not geodetic") };
            assert!(
                (place.lat_rad.to_degrees() - (53.0 + (0.005 + 0.1 * second as f64) / 60.0)).abs() < 1e-12
            );
            assert_eq!(place.h_m, 63.5);
            assert_eq!(fix.time.fraction_s(), 0.5);
        }
        assert_eq!(recording.fixes[0].yaw_pitch_roll_rad.unwrap()[0], 359f64.to_radians());
    }
}

#[test]
fn midnight_and_late_dates() {
    let position = |time: &str| sentence(&format!("GPGLL,5300.000,N,00430.000,E,{time},A,A"));
    let text = [
        position("235958"),
        position("235959"),
        position("000000"),
        sentence("GPZDA,000001,01,01,2021,00,00"),
        position("000001"),
        position("000000.5"),
        position("000002"),
    ]
    .concat();
    let recording = read(&text);
    let times: Vec<String> = recording.fixes.iter().map(|fix| fix.time.to_string()).collect();
    assert_eq!(times[0], "2020-12-31T23:59:58.000000Z");
    assert_eq!(times[2], "2021-01-01T00:00:00.000000Z");
    assert_eq!(times[4], "2021-01-01T00:00:02.000000Z");
    assert_eq!((times.len(), recording.report.out_of_order), (5, 1));
    // Forwards over midnight, from a date before it.
    let text = [
        sentence("GPZDA,235959,28,02,2020,00,00"),
        position("235959"),
        position("000000"),
        position("000001"),
    ];
    let recording = read(&text.concat());
    assert_eq!(recording.fixes[1].time.to_string(), "2020-02-29T00:00:00.000000Z");
}

#[test]
fn pashr_gives_the_whole_attitude() {
    let mut text = String::new();
    for second in 0..2 {
        text += &sentence(&format!("PASHR,12000{second}.00,090.50,T,-01.25,002.50,000.00,0.1,0.1,0.1,1,1"));
        text +=
            &sentence(&format!("GPRMC,12000{second}.00,A,5300.{second}00,N,00430.000,E,10.0,0.0,010720,,,A"));
    }
    let fixes = read(&text).fixes;
    let [yaw, pitch, roll] = fixes[1].yaw_pitch_roll_rad.unwrap().map(f64::to_degrees);
    assert!((yaw - 90.5).abs() < 1e-12 && (pitch - 2.5).abs() < 1e-12 && (roll + 1.25).abs() < 1e-12);
}

#[test]
fn faults_and_empty_logs() {
    let rmc = |time: &str| sentence(&format!("GPRMC,{time},A,5300.000,N,00430.000,E,10.0,0.0,010720,,,A"));
    let mut source = sources::nmea("log.nmea");
    source.attitude = AttitudeSource::Level;
    let message = |text: &str| nmea::parse(text.as_bytes(), &source).unwrap_err().to_string();
    assert_snapshot!(message(&[rmc("120000"), rmc("120030"), rmc("115900")].concat()), @r#"
    log.nmea: 1 fault
      line 2: no fix for 30.000 s before 2020-07-01T12:00:30.000000Z; longest gap allowed: max_gap_s = 10 s; max_gap_s = 30 interpolates it
    "#);
    assert_snapshot!(message(""), @r#"
    log.nmea: no usable fix: no line is an NMEA 0183 sentence with a right checksum
      0 fixes over 0.000 s from 0 lines, longest gap 0.000 s
    "#);
    assert_snapshot!(message("not NMEA\n"), @r#"
    log.nmea: no usable fix: no line is an NMEA 0183 sentence with a right checksum
      0 fixes over 0.000 s from 1 lines, longest gap 0.000 s; 1 malformed skipped
    "#);
    assert_snapshot!(message(&sentence("GPRMC,120000,V,,,,,,,010720,,,N")), @r#"
    log.nmea: no usable fix: no GGA, GNS, RMC or GLL sentence has a valid position and a time of day
      0 fixes over 0.000 s from 1 lines, longest gap 0.000 s; 1 void positions skipped
    "#);
    assert_snapshot!(message(&rmc("120000")), @r#"
    log.nmea: 1 fault
      line 1: the file ends; usable fixes: 1, needed: at least 2
    "#);
}

fn with_checksum(body: Vec<u8>) -> Vec<u8> {
    let sum = body.iter().fold(0u8, |sum, byte| sum ^ byte);
    let mut line = vec![b'$'];
    line.extend(body);
    line.extend(format!("*{sum:02X}\n").bytes());
    line
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(512) })]

    #[test]
    fn no_bytes_make_the_parser_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = nmea::parse(&bytes, &sources::nmea("t"));
    }

    /// The checksum is right, so that the garbage reaches the parsers of the fields.
    #[test]
    fn no_fields_make_the_parser_panic(lines in proptest::collection::vec(
        ("(GP|II)(GGA|RMC|GLL|ZDA|HDT|VTG|GST)|PASHR", proptest::collection::vec("[-+0-9.NSEWATMVinfae]{0,9}", 0..16)), 1..12)) {
        let bytes: Vec<u8> = lines
            .iter()
            .flat_map(|(kind, fields)| with_checksum(format!("{kind},{}", fields.join(",")).into_bytes()))
            .collect();
        if let Ok(recording) = nmea::parse(&bytes, &sources::nmea("t")) {
            prop_assert!(recording.fixes.len() >= 2);
        }
    }

    #[test]
    fn no_payload_makes_the_parser_panic(body in proptest::collection::vec(0u8..128, 0..120)) {
        let body = body.into_iter().filter(|b| *b != b'*' && *b != b'\n').collect();
        let _ = nmea::parse(&with_checksum(body), &sources::nmea("t"));
    }
}
